"""What a system's tangents can be known to do before any run: lost rank, symmetries, driven and driving states.

Shifts are proved from the expressions; the rest is read off Jacobians and saltation matrices at random states on the
guards, at the parameters of the run and around the sizes that its states have there: the same in any unit.
"""

import contextlib
import math
from collections.abc import Callable, Collection, Iterable, Iterator
from dataclasses import dataclass
from functools import cache
from statistics import NormalDist
from typing import TYPE_CHECKING, Any

import numpy as np

from chaosdrill.codegen import kernels_of
from chaosdrill.codegen.kinds import float64, int64
from chaosdrill.codegen.signatures import event_places, integer_matrix, matrix, vector
from chaosdrill.engine.events import saltate, saltation_jump
from chaosdrill.engine.jit import compiled
from chaosdrill.engine.passages import brought_onto, leads_beyond, normal_speed
from chaosdrill.engine.records import functions_type
from chaosdrill.engine.scales import SMALLEST
from chaosdrill.engine.tuning import STRUCTURE, TANGENTS
from chaosdrill.engine.uncompiled import in_python

if TYPE_CHECKING:
    from chaosdrill.model.system import HybridSystem
    from chaosdrill.model.transition import Transition


def saltations(system: "HybridSystem") -> Iterator[tuple[int, np.ndarray]]:
    """Saltation matrices (transition, matrix of shape (n, n)) at random states on the guards, in sizes of states."""
    kernels = kernels_of(system)
    functions = kernels.functions
    n = len(system.state_names)
    c = kernels.constants(system.parameters)
    rng = np.random.default_rng(20260101)
    sizes, unit = _rounded_sizes(system)
    event, gradient, (sooner, jump, scratch) = np.zeros(event_places(n).size), np.empty(n + 1), np.empty((3, n))
    branching = set(_branching(system))
    for mode, events in enumerate(kernels.layout.events):
        for j in range(len(events)):
            seen = dict.fromkeys(events[j].outcomes, 0)
            decades, enough = STRUCTURE.decades, STRUCTURE.samples
            if not branching.isdisjoint(seen):
                decades, enough = STRUCTURE.branches, STRUCTURE.trials
            for _ in range(STRUCTURE.trials):
                if min(seen.values()) >= enough:
                    break
                x, t = sizes * rng.normal(size=n) * 10.0 ** rng.uniform(*decades), unit * rng.uniform(0, 7)
                if events[j].timed:
                    t = _onto_clock(functions.guard, mode, j, t, c, x, gradient)
                elif not _onto_guard(functions, mode, j, t, c, sizes, x, gradient):
                    continue
                transition = functions.event_map(mode, j, t, c, x, 1, np.ones(n), 0.0, event)
                speed = in_python(normal_speed)(event, n)
                if transition < 0 or speed * events[j].direction < 0 or speed == 0:
                    continue
                columns = np.eye(n)
                if not kernels.transition_table[transition, 1]:
                    in_python(saltation_jump)(event, jump)
                    in_python(saltate)(columns, n, event, speed, False, sooner, jump, scratch)
                matrix = columns.T * sizes / sizes[:, np.newaxis]
                if np.isfinite(matrix).all():
                    seen[transition] += 1
                    yield transition, matrix


def sizes_of(system: "HybridSystem") -> tuple[np.ndarray, float]:
    """Sizes that states have at the present parameters and initial state, shape (n,), and a unit of time.

    A state is as large as it begins, or as it has to become to meet a guard. One of which neither tells is as large as
    what it moves by in the unit of time, or as what is moved so by it: a radian of the forcing, or else of the fastest
    motion at these sizes. At a rest it is where the fastest motion becomes another one. Where nothing tells, as of a
    linear motion about a rest, any size does: that of one state is 1, and those of others follow from it.
    """
    key = (*system.parameters.values(), *system.initial.values())
    known = system.shared.get("sizes")
    if known is None or known[0] != key:
        with np.errstate(all="ignore"):
            known = system.shared["sizes"] = (key, _sizes(system))
    found: tuple[np.ndarray, float] = known[1]
    return found


def _sizes(system: "HybridSystem") -> tuple[np.ndarray, float]:
    kernels, n = kernels_of(system), len(system.state_names)
    c, guard = kernels.constants(system.parameters), kernels.functions.guard
    x = np.array([float(system.initial[name]) for name in system.state_names])
    found, gradient = np.where(np.abs(x) > SMALLEST, np.abs(x), 0.0), np.zeros(n + 1)
    for mode, events in enumerate(kernels.layout.events):
        for j in range(len(events)):
            value = guard(mode, j, 0.0, c, x, gradient)
            for i, away in enumerate((-value / gradient[:n]).tolist()):
                place, halvings = x.copy(), 0
                # not farther than where a curved guard is as large again
                while math.isfinite(away) and halvings < STRUCTURE.halvings:
                    place[i] = x[i] + away
                    if abs(guard(mode, j, 0.0, c, place, np.empty(n + 1))) <= abs(value):
                        found[i] = max(found[i], abs(away))
                        break
                    away, halvings = away / 2, halvings + 1
    found = found[: system.free]
    rates = [(np.abs(rate), np.abs(jacobian)) for rate, jacobian in _motions(system, x, found)]
    unit = _unit_of_time(system, found, rates)
    for _ in found:
        unknown = found == 0
        if not unknown.any():
            break
        largest = np.zeros(len(found))
        for rate, jacobian in rates:
            largest = np.fmax(largest, unit * np.fmax(rate, np.nan_to_num(_product(jacobian, found))))
        if not largest[unknown].any():
            # as large as what moves a known one by its size
            for _, jacobian in rates:
                there = found[:, np.newaxis] / (unit * jacobian)
                there[~np.isfinite(there) | (found[:, np.newaxis] == 0)] = np.inf
                least = there.min(axis=0)
                largest = np.fmax(largest, np.where(np.isfinite(least), least, 0.0))
        if not largest[unknown].any():
            largest = _where_motions_change(system, x, np.flatnonzero(unknown).tolist())
        if not largest[unknown].any():
            largest[unknown.argmax()] = 1.0
        found = np.where(unknown & np.isfinite(largest), largest, found)
    # draws of a noise have one size, and tell nothing of others
    return np.append(np.where(found > 0, found, 1.0), np.ones(n - system.free)), unit


def _where_motions_change(system: "HybridSystem", x: np.ndarray, at_rest: list[int]) -> np.ndarray:
    """How far states that are zero go, each alone, before the fastest motion of a mode is another one; 0 if it stays.

    Eigenvalues tell it in any unit of the states.
    """
    here, found = _eigenvalues(system, x), np.zeros(system.free)
    fastest = np.abs(here).max(axis=1, initial=0.0)
    if not (fastest > 0).any():
        return found
    for i in at_rest:

        def changes(power: float, i: int = i) -> bool:
            place = x.copy()
            place[i] = 2.0**power
            there = _eigenvalues(system, place)
            gone = np.abs(there[:, :, np.newaxis] - here[:, np.newaxis, :]).min(axis=2).max(axis=1, initial=0.0)
            return bool((~(gone <= STRUCTURE.changed * fastest))[fastest > 0].any())

        powers = range(-STRUCTURE.powers, STRUCTURE.powers + 1, STRUCTURE.stride)
        high = next(filter(changes, powers), None)
        # what is another one at once has no size
        if high is None or high == -STRUCTURE.powers:
            continue
        low = high - STRUCTURE.stride
        while high - low > 1:
            middle = (low + high) // 2
            low, high = (low, middle) if changes(middle) else (middle, high)
        found[i] = 2.0**high
    return found


def _eigenvalues(system: "HybridSystem", x: np.ndarray) -> np.ndarray:
    """Eigenvalues of the Jacobians of all modes at a state, complex of shape (modes, n); NaN where there are none."""
    n, found = system.free, np.full((len(system.modes), system.free), np.nan, dtype=complex)
    c, variation = kernels_of(system).constants(system.parameters), kernels_of(system).functions.variation
    for mode in range(len(system.modes)):
        columns = np.empty((n, len(x)))
        for j, along in enumerate(np.eye(n, len(x))):
            variation(mode, 0.0, c, x, along, columns[j])
        matrix = columns[:, :n]
        if np.isfinite(matrix).all():
            found[mode] = np.linalg.eigvals(matrix)
    return found


def _rounded_sizes(system: "HybridSystem") -> tuple[np.ndarray, float]:
    """Sizes and unit of time as in `sizes_of`, rounded to powers of two: starts of about the same sizes share them."""
    sizes, unit = sizes_of(system)
    rounded = np.exp2(np.rint(np.log2(np.append(sizes, unit))))
    # the phases of a forcing are those of its period
    return rounded[:-1], unit if system.forced and system.forcing_period() else float(rounded[-1])


def _motions(system: "HybridSystem", x: np.ndarray, sizes: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Rates, shape (n,), and Jacobians of all modes at a state and beside it."""
    kernels, n = kernels_of(system), system.free
    c, field, variation = kernels.constants(system.parameters), kernels.functions.field, kernels.functions.variation
    rates, column, beside = np.empty(len(x) + len(system.quadratures)), np.empty(len(x)), x.copy()
    beside[:n] += sizes * general_position(n)[0]
    for place in (x, beside):
        for mode in range(len(system.modes)):
            field(mode, 0.0, c, place, rates)
            matrix = np.empty((n, n))
            for j, along in enumerate(np.eye(n, len(x))):
                variation(mode, 0.0, c, place, along, column)
                matrix[:, j] = column[:n]
            if np.isfinite(rates[:n]).all() and np.isfinite(matrix).all():
                yield rates[:n].copy(), matrix


def _unit_of_time(system: "HybridSystem", sizes: np.ndarray, rates: list[tuple[np.ndarray, np.ndarray]]) -> float:
    """A radian of the forcing or of the fastest motion, or the time in which a state is moved by its size."""
    if system.forced and (period := system.forcing_period()):
        return period / math.tau
    fastest = max((float(np.abs(np.linalg.eigvals(slopes)).max(initial=0.0)) for _, slopes in rates), default=0.0)
    # further digits of a double eigenvalue are those of a processor
    fastest = float(f"{fastest:.{STRUCTURE.digits}g}")
    if not fastest > 0:
        known = sizes > 0
        for rate, jacobian in rates:
            at_once, later = rate / sizes, np.sqrt(_product(jacobian, rate) / sizes)
            fastest = max(fastest, np.fmax(at_once, later)[known].max(initial=0.0))
    return 1.0 / fastest if 0 < fastest < math.inf else 1.0


def _product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """As ``a @ b``, in the same order of sums on every processor: frames, and with them runs, are made of it."""
    return np.asarray(np.einsum("...n,n->...", a, b))


@compiled(int64(functions_type, int64, int64, float64, vector, vector, vector, vector))
def _onto_guard(functions, mode, j, t, c, sizes, x, gradient):
    """As `brought_onto`, for who is not compiled."""
    return 1 if brought_onto(functions, mode, j, t, c, sizes, x, gradient) else 0


def _onto_clock(guard: Any, mode: int, j: int, t: float, c: np.ndarray, x: np.ndarray, gradient: np.ndarray) -> float:
    """When a guard of time alone is zero, by Newton's method from t; t itself where that does not arrive."""
    there = t
    for _ in range(STRUCTURE.halvings):
        there -= guard(mode, j, there, c, x, gradient) / gradient[-1]
    value = guard(mode, j, there, c, x, gradient)
    return there if abs(value) <= STRUCTURE.on * abs(gradient[-1] * there) else t


def passes(system: "HybridSystem") -> frozenset[tuple[int, int]]:
    """Guards (mode, number in the mode) beyond which the motion may go on after their own events.

    A wall throws the state back; a kick on the way may not. It is read off the same trial states for
    all guards, brought onto each, at the present parameters.
    """
    found: frozenset[tuple[int, int]] = _at_parameters(system, "passes", lambda: frozenset(_passes(system)))
    return found


def _at_parameters(system: "HybridSystem", name: str, find: Callable[[], Any]) -> Any:
    """What was found under a name at the present parameters and about the present sizes of states, or else is now."""
    sizes, unit = _rounded_sizes(system)
    key = (*system.parameters.values(), *sizes.tolist(), unit)
    known = system.shared.setdefault(name, {})
    if key not in known:
        if len(known) >= STRUCTURE.kept:
            known.clear()
        known[key] = find()
    return known[key]


def _passes(system: "HybridSystem") -> Iterator[tuple[int, int]]:
    kernels = kernels_of(system)
    c = kernels.constants(system.parameters)
    n = len(system.state_names)
    sizes, unit = _rounded_sizes(system)
    trials = _trials(n) * np.append(sizes, unit)
    functions = kernels.functions
    event, scratch = np.zeros(event_places(n).size), np.zeros((4, n + 1 + len(system.quadratures)))
    always = _always_passed(system)
    for mode, events in enumerate(kernels.layout.events):
        for j in range(len(events)):
            direction = events[j].direction
            if direction == 0 or events[j].timed:
                continue
            if (mode, j) in always or _goes_beyond(
                functions, mode, j, direction, c, sizes, trials, kernels.transition_table, event, scratch
            ):
                yield mode, j


def _always_passed(system: "HybridSystem") -> frozenset[tuple[int, int]]:
    """Guards whose events change neither them nor their rates, derived once for all values of the parameters."""
    if "always_passed" not in system.shared:
        placed = system.placed
        system.shared["always_passed"] = frozenset(
            (mode, j)
            for mode, events in enumerate(kernels_of(system).layout.events)
            for j, event in enumerate(events)
            if any(_goes_on(placed, placed.mode_names[mode], placed.transitions[k]) for k in event.outcomes)
        )
    found: frozenset[tuple[int, int]] = system.shared["always_passed"]
    return found


@cache
def _trials(n: int) -> np.ndarray:
    """States and, last, times at which guards are looked at, one a row, in their sizes: the same for all guards of all
    systems.

    They lie in all directions, half of them at distances from 1e-4 to 3 and half from 1/3 to 3, where other guards and
    conditions lie, both evenly: multiples of the powers of the root g of g**(d + 1) = g + 1, without their whole parts,
    fill a cube of d dimensions so (Roberts 2018, "The unreasonable effectiveness of quasirandom sequences").
    """
    d = n + 2
    g = 2.0
    for _ in range(64):
        g = (1.0 + g) ** (1.0 / (d + 1))
    part = np.arange(1, STRUCTURE.trials + 1)[:, np.newaxis] * g ** -np.arange(1.0, d + 1) % 1.0
    normal = np.array([[NormalDist().inv_cdf(p) for p in row] for row in part[:, :n].tolist()])
    power = np.where(np.arange(STRUCTURE.trials) % 2 == 0, 4.5 * part[:, n] - 4.0, part[:, n] - 0.5)
    trials = np.column_stack([normal * 10.0 ** power[:, np.newaxis], 7.0 * part[:, n + 1]])
    # it is handed out again
    trials.flags.writeable = False
    return trials


@compiled(int64(functions_type, int64, int64, int64, vector, vector, matrix, integer_matrix, vector, matrix))
def _goes_beyond(functions, mode, j, direction, c, sizes, trials, transitions, event, scratch):
    """Whether the motion goes on beyond a guard (1) at a trial state that was brought onto the guard, or not (0).

    ``transitions`` is a table of target mode and whether an event only marks; ``event`` and ``scratch`` are room.
    """
    n = trials.shape[1] - 1
    x, gradient, rates, ones = scratch[0][:n], scratch[1][: n + 1], scratch[2], scratch[3][:n]
    for i in range(n):
        ones[i] = 1.0
    for trial in range(trials.shape[0]):
        t = trials[trial, n]
        for i in range(n):
            x[i] = trials[trial, i]
        if not brought_onto(functions, mode, j, t, c, sizes, x, gradient):
            continue
        if leads_beyond(functions, transitions, mode, j, direction, t, c, x, event, gradient, rates, ones) == 1:
            return 1
    return 0


def _goes_on(system: "HybridSystem", mode: str, transition: "Transition") -> bool:
    """Whether an event changes neither its guard nor the rate of it."""
    if transition.target != mode:
        return False
    from chaosdrill.model.derive import rate

    reset = {state for state, image in transition.reset.items() if image != state}
    return not (transition.guard.free_symbols | rate(system, mode, transition.guard).free_symbols) & reset


@dataclass(frozen=True)
class Structure:
    """What can be known of the tangents before a run.

    Attributes
    ----------
    deficient : frozenset of int
        Transitions at which rank may be lost.
    frame : ndarray, shape (m, n)
        Orthonormal initial tangents, one a row, for a full spectrum: as many as the system has states, but for those
        that noise is made of, which no tangent moves. Directions along which the whole system can be
        shifted come first, states that drive others without being driven last. Then the triangular form of the tangent
        map is that of the system, and the exponents which its structure makes exact come out exact, not only in the
        limit of a long run. Among states that drive each other tangents start in general position, in parts of the
        sizes of the states: along the axes one may start exactly across what neither grows nor shrinks, where only
        round-off turns it.
    symmetries : int
        How many rows of the frame are such directions.
    autonomous : bool
        Whether the flow itself is a direction that neither grows nor decays.
    """

    deficient: frozenset[int]
    frame: np.ndarray
    symmetries: int
    autonomous: bool

    def tangents(self, count: int) -> tuple[np.ndarray, int]:
        """Initial tangents for ``count`` exponents, and how many of them are symmetries.

        All of them are the frame. It is made of directions that the system keeps, and fewer of these would measure
        what happens to start first: what drives others without being driven never shows in a tangent of the others.
        Fewer tangents therefore start in general position, drawn once and for all, and measure the largest exponents;
        what is exact in a full spectrum is right within its error then.
        """
        return (self.frame, self.symmetries) if count == len(self.frame) else (self.general(count), 0)

    def general(self, count: int) -> np.ndarray:
        """Orthonormal tangents in general position, one a row."""
        m, n = self.frame.shape
        return np.pad(general_position(m)[:count], ((0, 0), (0, n - m)))

    @property
    def most_neutral(self) -> int:
        """Exponents that may be zero whatever the attractor."""
        return min(self.symmetries + self.autonomous, len(self.frame))

    def neutral(self, flow: np.ndarray) -> np.ndarray:
        """Exponents that are zero whatever the attractor: dimensions spanned by the symmetries and the flow, the rates
        of the states on the attractor, shape (..., n)."""
        across = np.linalg.norm(self._across(flow), axis=-1)
        return self.symmetries + (self.autonomous & (across > STRUCTURE.along * np.linalg.norm(flow, axis=-1)))

    def winds(self, flow: np.ndarray) -> np.ndarray:
        """Whether nothing moves but phases that turn steadily, at rates without a common measure.

        A state that grows steadily while nothing depends on it is the angle of a torus; if all that moves is two of
        them or more, and they never come back together, the motion is quasiperiodic though no exponent tells so.
        """
        size = np.abs(flow).max(axis=-1)
        steady = self.autonomous & (np.linalg.norm(self._across(flow), axis=-1) <= STRUCTURE.along * size)
        with np.errstate(invalid="ignore", divide="ignore"):
            rates = np.nan_to_num(flow / size[..., np.newaxis])
        turns = rates[..., np.newaxis] * np.arange(1, STRUCTURE.measures + 1)
        together = (np.abs(turns - np.rint(turns)) <= STRUCTURE.along * STRUCTURE.measures).all(axis=-2).any(axis=-1)
        return steady & (size > 0) & ~together

    def _across(self, flow: np.ndarray) -> np.ndarray:
        """The part of the flow that is orthogonal to all symmetries."""
        symmetries = self.frame[: self.symmetries]
        return np.asarray(flow - (flow @ symmetries.T) @ symmetries)


@cache
def general_position(n: int) -> np.ndarray:
    """Orthonormal vectors of n numbers that no system knows of, one a row."""
    # by this seed those of two numbers, the most frequent ones, are far from both axes
    rng = np.random.default_rng(20260578)
    # the last digits of a library's are those of a processor
    rows = np.round(np.linalg.qr(rng.normal(size=(n, n)))[0], 8).astype(np.longdouble)
    frame = np.array(_orthonormal(rows), dtype=float)
    # it is handed out again
    frame.flags.writeable = False
    return frame


def examine(system: "HybridSystem") -> Structure:
    """Structure of a system's tangents at its present parameters."""
    found, sizes = _at_parameters(system, "coupling", lambda: _examine(system)), sizes_of(system)[0][: system.free]
    # rounded sizes would not be the same in all units
    key, known = (*found, *sizes.tolist()), system.shared.get("structure")
    if known is None or known[0] != key:
        deficient, groups = found
        frame = _frame(groups, symmetries_of(system), sizes, len(system.state_names))
        rows = len(symmetries_of(system))
        known = system.shared["structure"] = key, Structure(deficient, frame, rows, system.autonomous)
    examined: Structure = known[1]
    return examined


def _examine(system: "HybridSystem") -> tuple[frozenset[int], list[list[int]]]:
    """Transitions whose resets may lower the rank, and the states in groups as in `_downstream_first`."""
    m = system.free
    # a random state may be one that the system never sees
    with np.errstate(all="ignore"):
        jumps = [(transition, matrix[:m, :m]) for transition, matrix in saltations(system)]
    effects = [*(matrix[:m, :m] for matrix in _jacobians(system)), *(matrix - np.eye(m) for _, matrix in jumps)]
    return _deficient(system, jumps), _downstream_first(np.any(np.reshape(effects, (-1, m, m)) != 0, axis=0))


def symmetries_of(system: "HybridSystem") -> list[list[float]]:
    """Directions along which the whole system can be shifted, whatever its parameters: n numbers each.

    Where a Jacobian has an inverse there is none; else they are derived, once for all values of the parameters.
    """
    if "symmetries" not in system.shared:
        from chaosdrill.model.derive import shift_directions

        regular = any(_is_regular(matrix[: system.free, : system.free]) for matrix in _jacobians(system, 1))
        system.shared["symmetries"] = [] if regular else shift_directions(system.placed)
    found: list[list[float]] = system.shared["symmetries"]
    return found


def lines_of(system: "HybridSystem") -> list[list[float]]:
    """Directions along which motions as a whole can be shifted, n numbers each; derived once for all parameters.

    Tangents see no more than `symmetries_of`, conditions and steps make a difference besides.
    """
    if "lines" not in system.shared:
        from chaosdrill.model.derive import deciding_states, shift_directions

        found = symmetries_of(system)
        if found and any(row[i] for row in found for i in deciding_states(system.placed)):
            found = shift_directions(system.placed, decides=True)
        system.shared["lines"] = found
    lines: list[list[float]] = system.shared["lines"]
    return lines


def turns_of(system: "HybridSystem", changing: Collection[str]) -> Iterator[tuple[float, ...]]:
    """Shifts of angles by their periods, n numbers each, but those of which ``changing`` parameters tell the length.

    They are derived once for all values of the parameters.
    """
    from chaosdrill.model.arithmetic import parameters_in, value, written

    if "turns" not in system.shared:
        from chaosdrill.model.derive import turns

        placed = system.placed
        each = ((written(e, tuple(placed.parameters), of_arrays=False), states) for e, states in turns(placed))
        system.shared["turns"] = [[plain, states] for plain, states in each if plain is not None]
    names, numbers = list(system.parameters), list(system.parameters.values())
    for plain, states in system.shared["turns"]:
        if not any(names[place] in changing for place in parameters_in(plain)):
            # an angle that a parameter takes out of the equations has no period
            with contextlib.suppress(ZeroDivisionError, OverflowError):
                length = abs(float(value(plain, numbers, math)))
                yield tuple(length if i in states else 0.0 for i in range(len(system.state_names)))


def _is_regular(matrix: np.ndarray) -> bool:
    weights = np.linalg.svd(matrix, compute_uv=False)
    return bool(weights[-1] > STRUCTURE.regular * weights[0])


def _deficient(system: "HybridSystem", jumps: list[tuple[int, np.ndarray]]) -> frozenset[int]:
    """Transitions seen to lose rank somewhere, those never seen, and those whose target holds a surface."""
    # beside the growth of a graze round-off has no rank
    jumps = [(t, matrix) for t, matrix in jumps if np.abs(matrix).max() <= STRUCTURE.most]
    # nothing cancels in an image but by its own terms, however small a row is beside others
    balance = _balanced if system.discrete else np.asarray
    found = {t for t, matrix in jumps if not _has_full_rank(balance(matrix))}
    held = kernels_of(system).layout.held
    found |= {i for i, t in enumerate(system.transitions) if held[system.mode_names.index(t.target)]}
    return frozenset(found | (set(range(len(system.transitions))) - {t for t, _ in jumps}))


def _branching(system: "HybridSystem") -> list[int]:
    """Transitions whose reset has branches: kinks or jumps in the states, or Python code."""
    if "branching" not in system.shared:
        from chaosdrill.model.python import Called
        from chaosdrill.model.rules import kinked

        moving = {*system.states, system.time}
        resets = [t.reset.values() for t in system.transitions]
        system.shared["branching"] = [
            i for i, images in enumerate(resets) if kinked(images, moving) or any(e.has(Called) for e in images)
        ]
    found: list[int] = system.shared["branching"]
    return found


def _has_full_rank(matrix: np.ndarray) -> bool:
    """Whether a matrix, most of whose rows are those of the identity, has an inverse: its other rows decide."""
    other = np.flatnonzero((matrix != np.eye(len(matrix))).any(axis=1))
    if not len(other):
        return True
    block, largest = matrix[np.ix_(other, other)], np.abs(matrix).max()
    return bool(np.linalg.matrix_rank(block, tol=TANGENTS.rank * largest) == len(block))


def _balanced(matrix: np.ndarray) -> np.ndarray:
    """A matrix with its rows, then its columns, in parts of their largest entries."""
    for axis in (1, 0):
        largest = np.abs(matrix).max(axis=axis, keepdims=True)
        matrix = matrix / np.where(largest > 0, largest, 1.0)
    return matrix


def _frame(groups: list[list[int]], symmetries: list[list[float]], sizes: np.ndarray, states: int) -> np.ndarray:
    n = len(sizes)
    rows = [np.array(v[:n]) for v in symmetries]
    for group in groups:
        general = np.zeros((len(group), n))
        general[:, group] = general_position(len(group)) * sizes[group]
        # sizes may be so different that only unit vectors can be told apart
        rows += [*(general if len(group) > 1 else ()), *np.eye(n)[group]]
    made = np.pad(np.array(_orthonormal(rows)), ((0, 0), (0, states - n)))
    # it is handed out again
    made.flags.writeable = False
    return made


def _orthonormal(rows: Iterable[np.ndarray]) -> list[np.ndarray]:
    """Orthonormal vectors that span what these span, without those that are not apart from the ones before."""
    frame: list[np.ndarray] = []
    for row in rows:
        # by a power of two: squares may leave the doubles
        row = np.ldexp(row, -np.frexp(np.abs(row).max())[1])
        row = row / np.sqrt(_product(row, row))
        for _ in range(2):
            near = [frame[i] for i in np.flatnonzero(_product(np.abs(np.reshape(frame, (-1, len(row)))), np.abs(row)))]
            row = row - sum((v * _product(v, row) for v in near), np.zeros(len(row)))
        length = np.sqrt(_product(row, row))
        if length > STRUCTURE.apart:
            frame.append(row / length)
    return frame


def _jacobians(system: "HybridSystem", samples: int = STRUCTURE.samples) -> Iterator[np.ndarray]:
    """Jacobians at random states, of states in their sizes."""
    n = len(system.state_names)
    c = kernels_of(system).constants(system.parameters)
    variation = kernels_of(system).functions.variation
    sizes, time_unit = _rounded_sizes(system)
    rng = np.random.default_rng(20260102)
    column = np.empty(n)
    for mode in range(len(system.modes)):
        for _ in range(samples):
            x, t = sizes * rng.normal(size=n), time_unit * rng.uniform(0, 7)
            matrix = np.empty((n, n))
            for j, unit in enumerate(np.eye(n)):
                variation(mode, t, c, x, unit, column)
                matrix[:, j] = column
            matrix *= sizes / sizes[:, np.newaxis]
            if np.isfinite(matrix).all():
                yield matrix


def _downstream_first(pattern: np.ndarray) -> list[list[int]]:
    """States ordered so that what is driven comes before what drives it, those that drive each other together.

    ``pattern[i, j]``: i depends on j.
    """
    n = len(pattern)
    reach = pattern | np.eye(n, dtype=bool)
    for k in range(n):
        reach |= np.outer(reach[:, k], reach[k])
    influence = reach.sum(axis=0) - reach.sum(axis=1)
    order = sorted(range(n), key=lambda i: (influence[i], i))
    groups = dict.fromkeys(tuple(np.flatnonzero(reach[i] & reach[:, i]).tolist()) for i in order)
    return list(map(list, groups))
