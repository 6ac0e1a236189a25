"""Exact derivatives of the properties of an orbit with respect to parameters: start, times, means, multipliers.

The linearised shooting equations give those of the unknowns by one linear solve (implicit function theorem). Means and
tangents are carried along the orbit as further states (`chaosdrill.model.lifted`), whose own linearised equations hold
second variations and the derivatives of saltation matrices. The orbits of a branch that have the same events are
derived together. Each is derived twice, the second time with coarser steps on an orbit that is off by their error:
the errors follow from the difference.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.codegen import kernels_of
from chaosdrill.engine import shooting as at
from chaosdrill.engine.layout import DONE
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.setup import constrained_states
from chaosdrill.model.lifted import Lifted, lifted
from chaosdrill.orbits.expressions import slopes_of_surfaces
from chaosdrill.orbits.orbit import Orbit
from chaosdrill.orbits.results import Derived, underived
from chaosdrill.orbits.tuning import TUNING

if TYPE_CHECKING:
    from chaosdrill.orbits.problem import Problem, Shot


@dataclass(frozen=True)
class _Task:
    """An orbit whose strobe begins a segment, and the numbering of its events."""

    number: int  # its place in the list of derived orbits
    orbit: Orbit
    multipliers: np.ndarray
    rank: int
    strobe: int = 0  # the segment that begins at the strobe
    turn: int = 0  # periods from phase 0 to the strobe
    inserted: bool = False  # whether the segment before it ends at no event
    events: tuple[int, ...] = ()  # the segments that end at events, as these come from the strobe on
    turns: tuple[int, ...] = ()  # periods from phase 0 to the strobe that their times are counted from

    @property
    def kind(self) -> tuple[object, ...]:
        """What orbits have in common that are derived together."""
        of = self.orbit
        return (
            *(of.segments.tobytes(), of.periods, of.drift is None, self.strobe, self.turn, self.inserted),
            *(self.events, self.turns),
        )


def _coarser(numerics: Numerics) -> Numerics:
    """Numerics whose errors are several times as large."""
    fewer = max(2, int(numerics.steps_a_period / TUNING.coarser_steps)) if numerics.traits.fixed_step else None
    return replace(numerics, tolerance=TUNING.coarser * numerics.tolerance, steps=fewer)


class Carrier:
    """The shooting problem of orbits with passengers; its free parameters are those of the derivatives.

    ``problem``: its free parameters are those of its orbits. ``names``: parameters of the derivatives.
    """

    def __init__(self, problem: "Problem", names: Sequence[str]) -> None:
        system = problem.plain
        self.problem, self.names = problem, tuple(names)
        self.coarse = problem.alike(system, problem.free, _coarser(problem.numerics))
        self.second = not system.sources
        self.lifted: Lifted = lifted(system, tangent=self.second)
        self.free = tuple(dict.fromkeys((*problem.free, *names)))
        self.wide = problem.alike(self.lifted.system, self.free)
        self.coarse_wide = self.coarse.alike(self.lifted.system, self.free)
        self.n, self.r = len(system.state_names), len(system.quadratures)
        self.coarse.sizes = problem.sizes
        self.wide.sizes = np.concatenate([problem.sizes, np.ones(self.wide.states - self.n)])
        self.coarse_wide.sizes = self.wide.sizes
        self.integrals = slice(self.n, self.n + self.r)
        self.tangent = slice(self.n + self.r, self.wide.states)

    def derived(self, orbits: Sequence[tuple[Orbit, np.ndarray, int]]) -> list[Derived]:
        """The derivatives on orbits of the problem.

        ``orbits``: multipliers are complex, shape (n,), by decreasing modulus, exactly 0 where rank is lost; the rank
        is the number of directions that survive.
        """
        problem, found = self.problem, list[Derived]()
        words = refusal(problem)
        for orbit, _, _ in orbits:
            events = int((orbit.segments[:, at.SEGMENT_END] >= 0).sum())
            found.append(underived(problem.plain, len(self.names), events, words))
        if words:
            return found
        groups: dict[tuple[object, ...], list[_Task]] = {}
        for number, (orbit, multipliers, rank) in enumerate(orbits):
            task = _numbered(problem, _Task(number, orbit, multipliers, rank))
            groups.setdefault(task.kind, []).append(task)
        for group in groups.values():
            for number, one in self._together(group).items():
                found[number] = replace(found[number], message=one) if isinstance(one, str) else one
        return found

    def _together(self, tasks: Sequence[_Task]) -> dict[int, Derived | str]:
        """The derivatives on orbits of one kind, or the reason why they are missing, by the numbers of the orbits."""
        found: dict[int, Derived | str] = {}
        first, second = _Plain(self, self.problem, tasks), _Plain(self, self.coarse, tasks)
        whole = first.regular & second.regular
        for i in np.flatnonzero(~whole).tolist():
            found[tasks[i].number] = first.words(i)
        if not whole.any():
            return found
        first, second = first.among(whole), second.among(whole)
        fine = _Linear(self, self.wide, first, first.tasks)
        near = _Linear(self, self.coarse_wide, second, first.beside(second))
        values, shares = fine.derivatives()
        others = near.derivatives()[0]
        errors = _errors(values, others, shares)
        for i, task in enumerate(first.tasks):
            if not fine.whole[i]:
                found[task.number] = first.words(i)
                continue
            words = "" if self.second else "a Python function has no second derivatives, and so multipliers have none"
            if self.second and np.isnan(values["multiplier"][i]).all():
                words = "an event happens at zero speed, where multipliers are infinite and have no derivatives"
            found[task.number] = Derived(
                {name: one[i] for name, one in values.items()},
                {name: one[i] for name, one in errors.items()},
                fine.means[i],
                words,
            )
        return found


def derived_of(
    problem: "Problem", names: Sequence[str], orbits: Sequence[tuple[Orbit, np.ndarray, int]]
) -> list[Derived]:
    """The derivatives on orbits of a problem, as of `Carrier.derived`; the compiled code is used again."""
    known = problem.carriers.get(tuple(names))
    if known is None:
        known = problem.carriers[tuple(names)] = Carrier(problem, names)
    found: list[Derived] = known.derived(orbits)
    return found


def refusal(problem: "Problem") -> str:
    """Why orbits of a problem have no derivatives by parameters; empty if they have."""
    neutral = problem.neutral
    if len(neutral.conserved) > neutral.paired:
        return (
            "the orbit is one of a family at the same parameters, since a quantity is conserved: which of them a "
            "change of a parameter leads to is not determined, and so there are no derivatives"
        )
    return ""


def _numbered(problem: "Problem", task: _Task) -> _Task:
    """The task with a segment that begins at the strobe, and with its events in their order."""
    orbit, total = task.orbit, float(task.orbit.durations.sum())
    strobe, period = problem.first_strobe(orbit), problem.period_at(orbit)
    ends = np.cumsum(orbit.durations)
    times, order = orbit.in_order((ends - strobe) % total if problem.forced else ends)
    if period is None:
        return replace(task, events=tuple(order.tolist()), turns=(0,) * len(order))
    turns = np.rint((orbit.phase + ends - times) / period)[order].astype(int)
    turn = round((orbit.phase + strobe) / period)
    begins = ends - orbit.durations
    segment = min(int(np.searchsorted(begins, strobe, side="right")) - 1, len(orbit) - 1)
    length = strobe - float(begins[segment])
    if length <= TUNING.same_instant * period:
        return replace(task, strobe=segment, turn=turn, events=tuple(order.tolist()), turns=tuple(turns.tolist()))
    state = problem.at([orbit], np.array([[strobe]]))[0][0]
    before = orbit.segments[[segment]] * [1, 0, 1] + [0, at.SHARE, 0]
    parted = replace(
        orbit,
        segments=np.insert(orbit.segments, segment, before, axis=0),
        starts=np.insert(orbit.starts, segment + 1, np.append(state, orbit.starts[0, problem.states :]), axis=0),
        durations=np.insert(orbit.durations, segment, length),
    )
    parted.durations[segment + 1] -= length
    return replace(
        task, orbit=parted, strobe=segment + 1, turn=turn, inserted=True,
        events=tuple((order + (order >= segment)).tolist()), turns=tuple(turns.tolist()),
    )  # fmt: skip


def _timed(task: _Task, rows: np.ndarray, first: int) -> None:
    """Let the segment before the strobe end there: an equation of the phase, the durations, and so of the period.

    ``rows``, shape (P, m, columns): linearised equations; that of the segment is replaced. ``first``: column of the
    phase.
    """
    if task.inserted:
        row = rows[:, task.strobe - 1]
        count = len(task.orbit)
        row[:] = 0.0
        row[:, first : first + 1 + task.strobe] = 1.0
        row[:, first + 1 : first + 1 + count] -= task.turn / task.orbit.periods


class _Equations:
    """The linearised equations of orbits of one kind, without unit, and their inverse; P orbits.

    ``rows``, shape (P, m, columns + 1): as of `Shot`, those of passengers left out. ``own``, int, shape (k,): columns
    of the unknowns; the others are given.
    """

    def __init__(self, problem: "Problem", tasks: Sequence[_Task], rows: np.ndarray, own: np.ndarray) -> None:
        weights = np.array([problem.weights(one.orbit)[: len(own)] for one in tasks])
        held = np.array([problem.held(one.orbit)[:, : len(own)] for one in tasks])
        self.finite = np.isfinite(rows[:, :, :-1]).all(axis=(1, 2))
        rows = np.where(self.finite[:, np.newaxis, np.newaxis], rows, 0.0)
        self.weights = weights[:, :, np.newaxis]
        matrix = np.concatenate([rows[:, :, own], held], axis=1) / weights[:, np.newaxis]
        scale = np.abs(matrix).max(axis=2, keepdims=True)
        self.scale = np.where(scale > 0, scale, 1.0)
        self.matrix = matrix / self.scale
        left, self.sizes, self.across = np.linalg.svd(self.matrix, full_matrices=False)
        self.regular = self.finite & (self.sizes[:, -1] > TUNING.smallest_pivot * self.sizes[:, 0])
        sizes = np.where(self.regular[:, np.newaxis], self.sizes, 1.0)
        self.inverse = (self.across.swapaxes(1, 2) / sizes[:, np.newaxis]) @ left.swapaxes(1, 2)
        self.misses = self.right(rows[:, :, -1:])

    def right(self, rows: np.ndarray) -> np.ndarray:
        """The right-hand side of the equations, shape (P, m, g), from that without held states."""
        held = np.zeros((len(rows), self.matrix.shape[1] - rows.shape[1], rows.shape[2]))
        return -np.concatenate([rows, held], axis=1) / self.scale

    def solved(self, right: np.ndarray) -> np.ndarray:
        """The unknowns, shape (P, k, g)."""
        return np.asarray(self.inverse @ right / self.weights)

    def uncertain(self, right: np.ndarray) -> np.ndarray:
        """By which factor the relative error of every unknown exceeds that of the entries of each row."""
        change = np.abs(self.inverse @ right)
        off = np.abs(self.matrix).max(axis=2, keepdims=True) * change.sum(axis=1, keepdims=True) + np.abs(right)
        return np.asarray(np.abs(self.inverse) @ off / self.weights)


class _Plain:
    """Orbits of one kind as their own problem, or a coarser one, has them."""

    def __init__(
        self, carrier: Carrier, problem: "Problem", tasks: Sequence[_Task], shots: "Sequence[Shot] | None" = None
    ) -> None:
        self.carrier, self.problem, self.tasks = carrier, problem, tasks
        self.shots = shots or [problem.shoot(one.orbit, watched=False) for one in tasks]

    @cached_property
    def equations(self) -> _Equations:
        """Their linearised equations."""
        n, count = self.carrier.n, len(self.tasks[0].orbit)
        rows = np.array([one.equations[: count + n + 1] for one in self.shots])
        _timed(self.tasks[0], rows, n)
        return _Equations(self.problem, self.tasks, rows, np.arange(n + 1 + count))

    @cached_property
    def regular(self) -> np.ndarray:
        """Which of them have derivatives, bool of shape (P,)."""
        return np.array([one.outcome == DONE for one in self.shots]) & self.equations.regular

    def among(self, kept: np.ndarray) -> "_Plain":
        """Some of them."""
        if kept.all():
            return self
        places = np.flatnonzero(kept).tolist()
        return _Plain(self.carrier, self.problem, [self.tasks[i] for i in places], [self.shots[i] for i in places])

    def words(self, i: int) -> str:
        """The reason why one of them has no derivatives."""
        orbit, speeds = self.tasks[i].orbit, self.shots[i].speeds
        paces = self.problem.paces(orbit)
        slow = int(np.argmin(speeds / paces))
        end, outcome = orbit.segments[slow, [at.SEGMENT_END, at.SEGMENT_OUTCOME]].tolist()
        if end >= 0 and not speeds[slow] > TUNING.grazing_speed * paces[slow]:
            name = self.problem.plain.transitions[outcome].name
            return f"{name!r} meets its guard at zero speed, where derivatives by parameters are infinite"
        return "the equations of the orbit are singular, as at a fold: derivatives by parameters are infinite there"

    def beside(self, coarse: "_Plain") -> list[_Task]:
        """The orbits displaced by the error of coarser steps, and further in the direction that is least determined."""
        n, here, there = self.carrier.n, self.equations, coarse.equations
        missed = np.maximum(np.abs(here.misses), np.abs(there.misses)).max(axis=(1, 2))
        weakest = here.across[:, -1, :, np.newaxis] / here.weights
        weakest *= (np.maximum(missed, TUNING.rounding) / here.sizes[:, -1])[:, np.newaxis, np.newaxis]
        change = here.solved(there.misses)
        along = np.sign((change * here.weights * weakest * here.weights).sum(axis=1, keepdims=True))
        change = (change + np.where(along < 0, -weakest, weakest))[:, :, 0]
        moved = []
        for task, shot, by in zip(self.tasks, self.shots, change, strict=True):
            starts = task.orbit.starts.copy()
            starts[:, :n] += shot.sensitivity[:, :n, : len(by)] @ by
            phase, durations = task.orbit.phase + float(by[n]), task.orbit.durations + by[n + 1 :]
            moved.append(replace(task, orbit=replace(task.orbit, starts=starts, phase=phase, durations=durations)))
        return moved


@dataclass(frozen=True)
class _Tangent:
    """A part of a right eigenvector of the tangent map of an orbit, and its use."""

    orbit: int
    multiplier: int
    factor: complex
    start: np.ndarray  # (n,)


@dataclass
class _Eigen:
    """Eigenvectors of the tangent map of an orbit for m multipliers, in the states that are free in its first mode."""

    values: np.ndarray  # (m,)
    left: np.ndarray  # (f, m)
    right: np.ndarray  # (f, m)
    size: float  # of the map
    rest: list[int]  # those that are not 1 or 0 by structure
    twins: dict[int, int]  # of these, the second of each pair, and the first

    def products(self) -> np.ndarray:
        """Cosines between left and right eigenvectors; they are small for sensitive multipliers."""
        return np.asarray(np.abs((self.left * self.right).sum(axis=0)))


class _Linear:
    """The linearised equations of orbits of one kind with their passengers, solved for the effect of parameters.

    P orbits, N segments, C columns of unknowns and parameters, q parameters of the derivatives.
    """

    def __init__(self, carrier: Carrier, wide: "Problem", plain: _Plain, tasks: Sequence[_Task]) -> None:
        self.carrier, self.wide, self.plain, self.tasks = carrier, wide, plain, tasks
        problem, n, width, count = carrier.problem, carrier.n, wide.states, len(tasks[0].orbit)
        self.kind, self.accuracy = tasks[0], problem.accuracy
        self.lengths = np.array([float(one.orbit.durations.sum()) for one in tasks])
        mode = self.kind.orbit.segments[0, at.SEGMENT_MODE]
        self.loose = np.flatnonzero(constrained_states(problem.plain)[mode] == 0)
        self.units = problem.units
        self.eigen = [self._eigen(i) for i in range(len(tasks))]
        self.tangents = [one for i in range(len(tasks)) for one in self._tangents(i)]
        self.columns = width + 1 + count + len(carrier.free)
        self.equations = np.zeros((len(tasks), count + width + 1, self.columns + 1))
        self.strobes = np.zeros((len(tasks), n, self.columns))
        self.moved = np.zeros((len(self.tangents), n, self.columns))
        done = np.zeros(len(tasks), dtype=bool)
        for k, one in enumerate(self.tangents):
            shot = self._shoot(one.orbit, one.start)
            self.moved[k] = shot.equations[count + carrier.tangent.start : count + carrier.tangent.stop, :-1]
            if not done[one.orbit]:
                done[one.orbit] = self._keep(one.orbit, shot)
        for i in np.flatnonzero(~done).tolist():
            self._keep(i, self._shoot(i, None))
        self.own = np.r_[np.arange(n), width, width + 1 + np.arange(count)]
        self.given = width + 1 + count + np.array([carrier.free.index(name) for name in carrier.names], dtype=int)
        rows = self.equations[:, np.r_[np.arange(count + n), count + width]]
        _timed(self.kind, rows, width)
        solver = _Equations(problem, tasks, rows, self.own)
        self.whole = solver.regular
        right = solver.right(rows[:, :, self.given])
        self.change = np.zeros((len(tasks), self.columns, len(self.given)))
        self.uncertain = np.zeros_like(self.change)
        self.change[:, self.own], self.uncertain[:, self.own] = solver.solved(right), solver.uncertain(right)
        self.change[:, self.given] = np.eye(len(self.given))
        self.change[~self.whole] = np.nan
        integrals = self._passengers(carrier.integrals)
        self.means, self.moved_integrals = integrals[:, :, -1] / self.lengths[:, np.newaxis], integrals[:, :, :-1]

    def _keep(self, i: int, shot: "Shot") -> bool:
        """Keep the result of a shot around an orbit."""
        self.equations[i] = shot.equations if shot.outcome == DONE else np.nan
        self.strobes[i] = shot.sensitivity[self.kind.strobe, : self.carrier.n, :-1]
        return True

    def _shoot(self, i: int, tangent: np.ndarray | None) -> "Shot":
        """The shot around an orbit with this tangent at its first start, or none."""
        carrier, orbit = self.carrier, self.tasks[i].orbit
        n, width, own = carrier.n, self.wide.states, len(carrier.problem.free)
        starts = np.zeros((len(orbit), width + len(carrier.free)))
        starts[:, :n] = orbit.starts[:, :n]
        starts[:, width : width + own] = orbit.starts[:, n:]
        starts[:, width + own :] = [carrier.problem.plain.parameters[name] for name in carrier.free[own:]]
        if tangent is not None:
            here = tangent / self.units
            for k, factor in enumerate(self.plain.shots[i].factors):
                starts[k, carrier.tangent] = here * self.units
                here = factor @ here
        segments = orbit.segments.copy()
        for k, (mode, end, outcome) in enumerate(segments.tolist()):
            if end >= 0:
                segments[k, at.SEGMENT_OUTCOME] = carrier.lifted.taken[mode, outcome]
        drift = None if orbit.drift is None else np.append(orbit.drift, np.zeros(width - len(orbit.drift)))
        return self.wide.shoot(replace(orbit, segments=segments, starts=starts, drift=drift), watched=False)

    def along(self, rows: np.ndarray, places: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Effect of parameters on quantities with these derivatives by the unknowns, shape (P, m, C); error shares.

        With ``places``, for the orbits with these numbers.
        """
        change, uncertain = self.change, self.uncertain
        if places is not None:
            change, uncertain = change[places], uncertain[places]
        rows = np.broadcast_to(rows, (len(change), *rows.shape[-2:]))
        size = np.abs(rows)
        return rows @ change, size @ uncertain + size @ np.abs(change)

    def derivatives(self) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
        """All derivatives, and by how much a relative error of 1 in every number behind them changes them."""
        period = self.along(self._durations(len(self.kind.orbit))[np.newaxis])
        found = {
            "orbit_state": self.along(self.strobes),
            "period_time": (period[0][:, 0], period[1][:, 0]),
            "event_time": self._events(),
            "rates": self._rates(),
            "multiplier": self._multipliers(),
        }
        found["lyapunov_exponent"] = self._exponents(*found["period_time"], *found["multiplier"])
        return {name: one[0] for name, one in found.items()}, {name: one[1] for name, one in found.items()}

    def _durations(self, count: int) -> np.ndarray:
        """The row of the sum of the durations of the first segments, shape (C,)."""
        row = np.zeros(self.columns)
        row[self.own[self.carrier.n + 1 : self.carrier.n + 1 + count]] = 1.0
        return row

    def _events(self) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives of the times of events since the first strobe, in order."""
        kind, total = self.kind, self._durations(len(self.kind.orbit))
        rows = np.zeros((len(kind.events), self.columns))
        for place, (segment, turns) in enumerate(zip(kind.events, kind.turns, strict=True)):
            rows[place] = self._durations(segment + 1)
            if self.carrier.problem.forced:
                rows[place, self.own[self.carrier.n]] = 1.0
                rows[place] -= turns / kind.orbit.periods * total
        return self.along(rows)

    def _passengers(self, which: slice) -> np.ndarray:
        """Rows of passengers at the ends of the orbits over the unknowns, with their constants, (P, m, C + 1)."""
        count = len(self.kind.orbit)
        rows = self.equations[:, count + which.start : count + which.stop].copy()
        rows[:, :, which] += np.eye(which.stop - which.start)
        return rows

    def _rates(self) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives of the mean rates of the quadratures."""
        total = self._durations(len(self.kind.orbit))
        change, off = self.along(self.moved_integrals - self.means[:, :, np.newaxis] * total)
        lengths = self.lengths[:, np.newaxis, np.newaxis]
        return change / lengths, off / lengths

    def _eigen(self, i: int) -> _Eigen | None:
        """Eigenvectors of an orbit's tangent map; None if its multipliers have no derivatives."""
        from scipy.linalg import eig

        task, problem = self.tasks[i], self.carrier.problem
        map_ = self.plain.shots[i].monodromy[np.ix_(self.loose, self.loose)]
        if not (self.carrier.second and np.isfinite(task.multipliers).all() and np.isfinite(map_).all()):
            return None
        values, left, right = eig(map_, left=True, check_finite=False)
        kept = np.argsort(-np.abs(values), kind="stable")[: task.rank]
        values, left, right = values[kept], left[:, kept].conj(), right[:, kept]
        rest = np.ones(len(kept), dtype=bool)
        rest[np.argsort(np.abs(values - 1), kind="stable")[: problem.neutral.count]] = False
        others = np.flatnonzero(rest).tolist()
        twins: dict[int, int] = {}
        for k in others:
            pair = [j for j in others if j < k and values[j] == values[k].conj() and values[k].imag]
            if pair:
                twins[k] = pair[0]
        return _Eigen(values, left, right, float(np.linalg.norm(map_, 2)), others, twins)

    def _tangents(self, i: int) -> list[_Tangent]:
        """The parts of eigenvectors that are carried around an orbit."""
        eigen, found = self.eigen[i], list[_Tangent]()
        if eigen is None:
            return found
        for k in eigen.rest:
            for part, factor in ((eigen.right[:, k].real, 1.0), (eigen.right[:, k].imag, 1j)):
                if k not in eigen.twins and part.any():
                    start = np.zeros(self.carrier.n)
                    start[self.loose] = part * self.units[self.loose]
                    found.append(_Tangent(i, k, factor, start))
        return found

    def _multipliers(self) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives of the multipliers, complex; zero for those that are 0 or 1 by structure."""
        n, q, count = self.carrier.n, len(self.given), len(self.tasks)
        changes = np.full((count, n, q), complex(np.nan, np.nan))
        errors = np.full((count, n, q), np.nan)
        images = self._images()
        for i, eigen in enumerate(self.eigen):
            if eigen is None or not np.isfinite(self.equations[i]).all():
                continue
            changes[i], errors[i] = 0.0, 0.0
            for k, twin in eigen.twins.items():
                images[i, k] = (images[i, twin][0].conj(), images[i, twin][1])
            products = eigen.products()
            largest = max((float(np.abs(images[i, k][0]).max(initial=0.0)) for k in eigen.rest), default=0.0)
            for k in eigen.rest:
                change, error = images[i, k]
                apart = np.abs(eigen.values - eigen.values[k])
                apart[k] = np.inf
                hidden = np.abs(eigen.values[k]) * products[k] <= self.accuracy * eigen.size
                if hidden or (products * apart == 0).any():
                    # by rounding of the largest, or behind another one
                    changes[i, k], errors[i, k] = complex(np.nan, np.nan), np.nan
                    continue
                mixed = eigen.size * float((1 / (products * apart)).sum())
                changes[i, k] = eigen.left[:, k] @ change / (eigen.left[:, k] @ eigen.right[:, k])
                errors[i, k] = (np.abs(eigen.left[:, k]) @ error + largest * mixed) / products[k]
                if changes[i, k].any() and self.tasks[i].multipliers[k].imag * eigen.values[k].imag < 0:
                    changes[i, k] = changes[i, k].conj()
        return changes, errors * (1 + 1j)

    def _images(self) -> dict[tuple[int, int], tuple[np.ndarray, np.ndarray]]:
        """Effect of parameters on the images of the tangents, in their units, shapes (f, q), by orbit and number.

        Tangents are constant, apart from what keeps them on the surfaces that the first mode holds, as these turn.
        """
        units, shape = self.units[self.loose, np.newaxis], (len(self.loose), len(self.given))
        places = np.array([one.orbit for one in self.tangents], dtype=int)
        rows = self.moved[:, self.loose] / units
        changes, errors = self.along(rows, places)
        surfaces = kernels_of(self.carrier.problem.plain).layout.held[int(self.kind.orbit.segments[0, at.SEGMENT_MODE])]
        maps = self._passengers(self.carrier.tangent)[:, self.loose, self.carrier.tangent] if surfaces else None
        found: dict[tuple[int, int], tuple[np.ndarray, np.ndarray]] = {}
        for one, change, error in zip(self.tangents, changes, errors, strict=True):
            if maps is not None:
                kept = maps[one.orbit] @ self._kept_on_surfaces(one) / units
                change, error = change + kept, error + np.abs(kept)
            sums, bounds = found.get((one.orbit, one.multiplier), (np.zeros(shape, dtype=complex), np.zeros(shape)))
            found[one.orbit, one.multiplier] = (sums + one.factor * change, bounds + error)
        return found

    def _kept_on_surfaces(self, tangent: _Tangent) -> np.ndarray:
        """How a tangent at the start has to change with parameters to stay on the surfaces held there, (n, q)."""
        problem, orbit, n = self.carrier.problem, self.tasks[tangent.orbit].orbit, self.carrier.n
        mode, system = int(orbit.segments[0, at.SEGMENT_MODE]), problem.plain
        known = dict(zip(problem.free, orbit.starts[0, n:], strict=True))
        values = np.array([known.get(name, value) for name, value in system.parameters.items()])
        gradients, turned = slopes_of_surfaces(system, mode, orbit.phase, orbit.starts[0, :n], values)
        gradients[:, constrained_states(system)[mode] == 1] = 0.0
        moved = np.zeros((n + 1 + len(values), len(self.given)))
        moved[: n + 1] = self.change[tangent.orbit, self.own[: n + 1]]
        for column, name in enumerate(self.carrier.names):
            moved[n + 1 + list(system.parameters).index(name), column] = 1.0
        return -np.linalg.pinv(gradients) @ np.einsum("mis,sq,i->mq", turned, moved, tangent.start)

    def _exponents(
        self, period: np.ndarray, off: np.ndarray, multipliers: np.ndarray, errors: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives of the exponents log|mu|/T; NaN where they are infinite."""
        lengths = self.lengths[:, np.newaxis, np.newaxis]
        period, off = period[:, np.newaxis], off[:, np.newaxis]
        with np.errstate(divide="ignore", invalid="ignore"):
            size = np.array([one.multipliers for one in self.tasks])[:, :, np.newaxis]
            exponent = np.where(size == 0, np.nan, np.log(np.abs(size)) / lengths)
            # zero by structure; the rest is round-off
            exponent[(exponent == exponent) & ~errors.any(axis=2, keepdims=True)] = 0.0
            change = ((multipliers / size).real - exponent * period) / lengths
            bound = (errors.real / np.abs(size) + np.abs(exponent) * off) / lengths
        nothing = np.isnan(exponent) & np.ones(change.shape, dtype=bool)
        return np.where(nothing, np.nan, change), np.where(nothing, np.nan, bound)


def _errors(
    values: dict[str, np.ndarray], others: dict[str, np.ndarray], shares: dict[str, np.ndarray]
) -> dict[str, np.ndarray]:
    """Errors of derivatives: their change with coarser steps on an orbit that is off, and what this may hide.

    The shares tell the latter: by how much a relative error of 1 in every number changes a derivative. The median over
    all derivatives of an orbit gives the actual relative error.
    """
    apart = {name: values[name] - others[name] for name in values}

    def parts(one: np.ndarray) -> list[np.ndarray]:
        return [one.real, one.imag] if np.iscomplexobj(one) else [one]

    ratios = []
    for name, off in apart.items():
        for difference, share in zip(parts(off), parts(shares[name]), strict=True):
            known = np.full(off.shape, np.nan)
            np.divide(np.abs(difference), share, out=known, where=share > 0)
            ratios.append(known.reshape(len(off), -1))
    units = np.array([_median(one) for one in np.concatenate(ratios, axis=1)])
    units = TUNING.hidden * np.maximum(units, np.finfo(float).eps / 2)

    def error(difference: np.ndarray, share: np.ndarray) -> np.ndarray:
        return np.asarray(np.abs(difference) + units.reshape(-1, *[1] * (share.ndim - 1)) * share)

    errors = {}
    for name, off in apart.items():
        real, *imag = [error(*pair) for pair in zip(parts(off), parts(shares[name]), strict=True)]
        errors[name] = real + 1j * imag[0] if imag else real
    return errors


def _median(values: np.ndarray) -> float:
    """The median without NaN."""
    known = values[np.isfinite(values)]
    return float(np.median(known)) if len(known) else float("nan")
