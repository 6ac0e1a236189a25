"""Floquet multipliers: those that are 1 or 0 by structure, and the stability that the others decide."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.codegen import kernels_of
from chaosdrill.dataset import Outcome
from chaosdrill.engine import shooting as at
from chaosdrill.engine.setup import constrained_states
from chaosdrill.engine.structure import examine
from chaosdrill.orbits.guess import run_from, standpoint
from chaosdrill.orbits.tuning import TUNING

if TYPE_CHECKING:
    from chaosdrill.orbits.orbit import Orbit
    from chaosdrill.orbits.problem import Problem, Shot


def free_multipliers(values: np.ndarray, neutral: int) -> np.ndarray:
    """The multipliers without those that are 1 on every orbit, as that of the flow direction without a period.

    ``values``, complex, shape (..., n): eigenvalues of the tangent map over one period. ``neutral``: how many are 1 by
    the structure of the system (`chaosdrill.orbits.multipliers`): those nearest to 1 go.

    Returns: complex, shape (..., n - neutral).
    """
    if not neutral:
        return values
    left_out = np.argsort(np.abs(values - 1), axis=-1, kind="stable")[..., :neutral]
    kept = np.ones(values.shape, dtype=bool)
    np.put_along_axis(kept, left_out, False, axis=-1)
    return values[kept].reshape(*values.shape[:-1], values.shape[-1] - neutral)


def is_stable(values: np.ndarray, neutral: int) -> np.ndarray:
    """Whether all free multipliers lie inside the unit circle, shape (...); parameters as for `free_multipliers`."""
    return (np.abs(free_multipliers(values, neutral)) < 1).all(axis=-1)


def based(problem: "Problem", orbit: "Orbit") -> "Orbit":
    """The orbit written from the segment with the fewest degrees of freedom, where lost directions are exactly zero."""
    first = int(np.argmin([freedom(problem, mode) for mode in orbit.segments[:, at.SEGMENT_MODE]]))
    return orbit.rotated(first, problem.period_at(orbit)) if first else orbit


def freedom(problem: "Problem", mode: int) -> int:
    """How many directions a mode leaves."""
    system = problem.plain
    return len(system.state_names) - int(constrained_states(system)[mode].sum()) - kernels_of(system).layout.held[mode]


def structural_rank(problem: "Problem", orbit: "Orbit") -> int:
    """Rank that the tangent map keeps however often the orbit is gone through, by what its events remove exactly.

    Where no event may remove any, it is full but for what the mode holds. Else the ordinary engine carries as many
    independent tangents around the orbit as there are states, from within a segment, so that every round holds all
    events.
    """
    d = problem.states
    free = freedom(problem, orbit.segments[0, at.SEGMENT_MODE])
    structure = examine(problem.plain)
    if not structure.deficient:
        return free
    # in the sizes of the states, which a run that begins where they are zero does not know
    sizes = np.linalg.svd(np.nan_to_num(problem.shoot(orbit, False).monodromy), compute_uv=False)
    if sizes[free - 1] > TUNING.tangent_error * len(orbit) * sizes[0]:
        return free
    segment, time, state = standpoint(problem, orbit)
    run = run_from(problem, orbit, segment, time, state, tangents=np.eye(d), deficient=structure.deficient)
    outcome = Outcome.OK
    for _ in range(d):
        outcome = run.advance(orbit.periods if problem.forced else 1)[0] if outcome == Outcome.OK else outcome
        run.x[:] = state
    return run.live if outcome == Outcome.OK else free


def multipliers(problem: "Problem", orbit: "Orbit", monodromy: np.ndarray, rank: int) -> np.ndarray:
    """Eigenvalues of tangent maps around orbits of the same segments, by falling modulus.

    ``orbit``: one of them: from the mode of its first segment follows which states are pinned. ``monodromy``, shape
    (..., d, d). ``rank``: how many are not zero.

    Returns, complex, shape (..., d): NaN where a map has no derivative, as at grazing.
    """
    free = np.flatnonzero(constrained_states(problem.plain)[orbit.segments[0, at.SEGMENT_MODE]] == 0)
    values = np.zeros(monodromy.shape[:-1], dtype=complex)
    known = np.isfinite(monodromy).all(axis=(-2, -1))[..., np.newaxis]
    values[..., : len(free)] = np.linalg.eigvals(
        np.where(known[..., np.newaxis], monodromy, 0.0)[..., free[:, np.newaxis], free]
    )
    order = np.argsort(-np.abs(values), axis=-1, kind="stable")
    values = np.take_along_axis(values, order, axis=-1)
    values[..., rank:] = 0.0
    return np.where(known, values, complex(np.nan, np.nan))


def all_multipliers(problem: "Problem", orbit: "Orbit", shot: "Shot") -> np.ndarray:
    """Multipliers of an orbit as its shot has them, complex of shape (d,), lost directions to round-off only."""
    return multipliers(problem, orbit, shot.monodromy, problem.states)


def pair_near(values: np.ndarray, neutral: int, half: float) -> tuple[float, float, np.ndarray]:
    """The pair of multipliers whose product is nearest to 1 and half its sum to a value known from an orbit near by.

    Those that are 1 by structure count as part of it: where the pair comes to 1 as well they cannot be told apart, but
    their sum and product can.

    ``values``, complex, shape (d,). ``neutral``: how many of them are 1 by the structure of the system.

    Returns: ``half``, ``product``: of the pair; NaN without one. ``rest``, complex, shape (d - 2 - neutral,): the other
    multipliers.
    """
    free = free_multipliers(values, neutral)
    first, second = np.triu_indices(len(free), 1)
    if not len(first) or not np.isfinite(values).all():
        return float("nan"), float("nan"), free
    sums, products = free[first] + free[second], free[first] * free[second]
    best = int((np.abs(sums / 2 - half) + np.abs(products - 1)).argmin())
    rest = np.delete(free, [first[best], second[best]])
    # without the rest, so that what is 1 by structure need not be separated from the pair
    order = np.ones(len(values), dtype=bool)
    for value in rest:
        order[np.flatnonzero(order)[np.abs(values[order] - value).argmin()]] = False
    return float((values[order].sum().real - neutral) / 2), float(values[order].prod().real), rest


@dataclass(frozen=True)
class Spectra:
    """Multipliers of orbits of the same segments, and how well they are known."""

    values: np.ndarray  # complex, (..., d): by falling modulus, exactly 0 where rank is lost
    errors: np.ndarray
    """(...,): of those near the unit circle; those that nearly coincide are known to its root."""

    def unknown(self, neutral: int) -> np.ndarray:
        """Whether the number outside the unit circle is not known, shape (...); ``neutral`` of them are 1."""
        free = free_multipliers(self.values, neutral)
        near = np.abs(np.abs(free) - 1).min(axis=-1, initial=np.inf)
        return ~(np.isfinite(free).all(axis=-1) & (near > np.sqrt(self.errors)))


def spectra(
    problem: "Problem", orbits: "Sequence[Orbit]", monodromies: np.ndarray, factors: np.ndarray, rank: int
) -> Spectra:
    """Multipliers of orbits, each to its own precision where the tangent map as a whole hides the smallest.

    ``orbits``: P of the same segments. ``monodromies``, shape (P, d, d). ``factors``, shape (P, N, d, d): of each map,
    in the order in which they act. ``rank``: how many multipliers are not zero.
    """
    values = multipliers(problem, orbits[0], monodromies, rank)
    noise = TUNING.tangent_error * len(orbits[0])
    errors = noise * np.maximum(1.0, np.abs(values).max(axis=-1, initial=0.0))
    hidden = np.isfinite(values).all(axis=-1)
    for k in np.flatnonzero(hidden).tolist():
        if _strained(problem, values[k], monodromies[k]):
            values[k], errors[k] = _across_flow(problem, orbits[k], rank)
            hidden[k] = False
    if rank < 2 or len(orbits[0]) < 2:
        return Spectra(values, errors)
    hidden[hidden] = _hides(values[hidden, rank - 1], monodromies[hidden], TUNING.graded_along)
    if hidden.any():
        together = _together(values[hidden], monodromies[hidden], rank, TUNING.graded_along)
        values[hidden], spread = _simultaneous(factors[hidden], rank, together)
        errors[hidden] = np.minimum(errors[hidden], noise * spread)
    return Spectra(values, errors)


def _strained(problem: "Problem", values: np.ndarray, monodromy: np.ndarray) -> bool:
    """Whether a tangent map shears along the flow by so much that its multipliers are lost in the rounding of that."""
    largest = max(1.0, float(np.abs(values).max(initial=0.0)))
    return problem.neutral.flow and bool(np.linalg.norm(monodromy, 2) > TUNING.strained * largest)


def _across_flow(problem: "Problem", orbit: "Orbit", rank: int) -> tuple[np.ndarray, float]:
    """The multipliers of an orbit of an autonomous system, shape (d,), that of the flow exactly 1, and their error.

    The others are those of the tangent maps of its pieces across the flow. What these do along it may be large: beside
    a homoclinic orbit a deviation changes the time at the saddle.
    """
    parts = [_at_guard(problem, one) for one, _ in pieces(problem, orbit)]
    parts = [_up_to(problem, one, after) for one, after in zip(parts, [*parts[1:], parts[0]], strict=True)]
    flows = np.array([problem.flow_at(one) for one in parts]) / problem.units
    across = np.linalg.qr(flows[..., np.newaxis], mode="complete")[0][..., 1:]
    maps = np.array([problem.shoot(one, False).monodromy for one in parts])
    factors = np.swapaxes(np.roll(across, -1, axis=0), -1, -2) @ maps @ across
    values = np.zeros(problem.states, dtype=complex)
    values[0] = 1.0
    if rank > 1:
        none = np.zeros((1, rank - 2), dtype=bool)
        values[1:], _ = (one[0] for one in _simultaneous(factors[np.newaxis], rank - 1, none))
    sizes = np.linalg.svd(factors, compute_uv=False)[:, max(rank - 2, 0)]
    with np.errstate(divide="ignore"):
        off = TUNING.tangent_error * float((np.linalg.norm(maps, 2, axis=(-2, -1)) / sizes).sum())
    values = values[np.argsort(-np.abs(values), kind="stable")]
    return values, off * float(np.abs(values[0]))


def _at_guard(problem: "Problem", one: "Orbit") -> "Orbit":
    """An event as a path, on its guard, beside which rounding may have grown along the flow; another path as it is."""
    if one.eventless:
        return one
    shot, starts = problem.shoot(one, False), one.starts.copy()
    starts[:, : problem.states] -= problem.flow_at(one) * shot.equations[0, -1] / shot.speeds[0]
    return replace(one, starts=starts)


def _up_to(problem: "Problem", one: "Orbit", after: "Orbit") -> "Orbit":
    """A path without an event, up to the start of another one, beside which rounding may have grown along the flow."""
    if not one.eventless:
        return one
    d, sizes = problem.states, problem.sizes
    flow = problem.flow_at(after) / sizes
    end = problem.at([one], one.durations[np.newaxis])[0][0, 0]
    left = problem.shifts.across(after.starts[0, :d] - end) / sizes
    return replace(one, durations=one.durations + left @ flow / (flow @ flow))


def _hides(smallest: np.ndarray, maps: np.ndarray, part: float) -> np.ndarray:
    """Whether multipliers cannot be read off tangent maps as a whole."""
    return np.abs(smallest) <= part * np.linalg.norm(maps, 2, axis=(-2, -1))


def _together(values: np.ndarray, maps: np.ndarray, rank: int, part: float) -> np.ndarray:
    """Which multipliers need not be parted from the next, shape (..., rank - 1), as far as maps as a whole tell them.

    Turning around the orbit parts two of nearly one modulus slowly, and those of a complex pair never. Multiplied out
    with the next, such a one loses no more than a digit.
    """
    first, second = values[..., : rank - 1], values[..., 1:rank]
    seen = ~_hides(second, maps[..., np.newaxis, :, :], part)
    return np.asarray(seen & (np.abs(second) > TUNING.graded_near * np.abs(first)))


def _simultaneous(factors: np.ndarray, rank: int, together: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Eigenvalues of products whose factors stay apart, and how unevenly the worst factor stretches.

    Eigenvalues of a product that was multiplied out know the smaller ones only to the round-off of the largest.
    Simultaneous iteration around the orbit makes all factors triangular (periodic QR; Bojanczyk, Golub and Van Dooren
    1992, doi:10.1117/12.130915).

    ``factors``, shape (P, N, d, d): in the order in which they act. ``rank``: how many eigenvalues are not zero.
    ``together``, bool, shape (P, rank - 1): eigenvalues that need not be parted from the next.

    Returns: ``values``, complex, shape (P, d). ``spread``, shape (P,).
    """
    count, steps, d, _ = factors.shape
    before = np.broadcast_to(np.linalg.qr(np.random.default_rng(20260105).normal(size=(d, d)))[0], (count, d, d))
    triangles, basis = np.zeros(factors.shape), before
    logs, apart = np.zeros((count, rank)), np.zeros((count, rank - 1), dtype=bool)
    # with directions that are lost, a basis of those that are left takes a round for each
    for turn in range(TUNING.graded_rounds + d - rank):
        before, turned = basis, turn >= d - rank and (apart | together).all()
        for i in range(steps):
            basis, triangles[:, i] = np.linalg.qr(factors[:, i] @ basis)
        if turned:
            break
        sizes = np.abs(np.diagonal(triangles, axis1=-2, axis2=-1)[..., :rank])
        with np.errstate(divide="ignore", invalid="ignore"):
            logs += np.log(sizes).sum(axis=1)
            apart = -np.diff(logs, axis=-1) > -np.log(TUNING.graded_turned)
    values = np.zeros((count, d), dtype=complex)
    for k in range(count):
        ends = [*(np.flatnonzero(apart[k]) + 1).tolist(), rank]
        for first, end in zip([0, *ends[:-1]], ends, strict=True):
            block = before[k, :, first:end].T @ basis[k, :, first:end]
            if end - first == 1:
                values[k, first] = block[0, 0] * triangles[k, :, first, first].prod()
                continue
            for triangle in triangles[k, ::-1, first:end, first:end]:
                block = block @ triangle
            values[k, first:end] = np.linalg.eigvals(block)
    order = np.argsort(-np.abs(values), axis=-1, kind="stable")
    sizes = np.abs(np.diagonal(triangles, axis1=-2, axis2=-1)[..., :rank])
    with np.errstate(divide="ignore"):
        spread = (np.abs(triangles).max(axis=(-2, -1)) / sizes.min(axis=-1)).max(axis=-1)
    return np.take_along_axis(values, order, axis=-1), spread


def graded(problem: "Problem", orbit: "Orbit", monodromy: np.ndarray, rank: int) -> np.ndarray:
    """The multipliers of one orbit, each to its own relative precision, however far apart they are.

    Its tangent map is made of pieces none of which is ill conditioned.
    """
    plain = multipliers(problem, orbit, monodromy, rank)
    if _strained(problem, plain, monodromy):
        return _across_flow(problem, orbit, rank)[0]
    if rank < 2 or not _hides(plain[rank - 1], monodromy, TUNING.graded):
        return plain
    together = _together(plain, monodromy, rank, TUNING.graded)
    parts = np.array([matrix for _, matrix in pieces(problem, orbit)])
    return np.asarray(_simultaneous(parts[np.newaxis], rank, together[np.newaxis])[0][0])


def largest_growth(problem: "Problem", orbit: "Orbit") -> float:
    """Largest factor by which a deviation grows on any part of an orbit, in units near the sizes of the states."""
    largest, ending = 1.0, np.zeros((0, problem.states, problem.states))
    parts = [piece for _, piece in pieces(problem, orbit, TUNING.growth_halvings)]
    for piece in parts * 2:
        # those that end here, of a round at most
        ending = piece @ np.concatenate([ending, np.eye(problem.states)[np.newaxis]])[-len(parts) :]
        largest = max(largest, float(np.linalg.norm(ending, 2, axis=(-2, -1)).max()))
    return largest


def pieces(problem: "Problem", orbit: "Orbit", least: int = 0) -> list[tuple["Orbit", np.ndarray]]:
    """Segments and events of an orbit as paths of their own, in order, and their tangent maps.

    Segments are halved ``least`` times, and until none is ill conditioned.
    """
    found: list[tuple[Orbit, np.ndarray]] = []
    for one, before in problem.segment_by_segment(orbit):
        flow = one.segments.copy()
        flow[:, at.SEGMENT_END] = at.PLANE
        _cut(problem, replace(one, segments=flow), found, 0, least)
        if one.segments[0, at.SEGMENT_END] >= 0:
            time = one.phase + float(one.durations[0])
            starts = np.concatenate([before, one.starts[0, problem.states :]])[np.newaxis]
            event = replace(one, starts=starts, phase=time, durations=np.zeros(1))
            found.append((event, problem.shoot(event, False).monodromy))
    return found


def _cut(problem: "Problem", one: "Orbit", found: list[tuple["Orbit", np.ndarray]], depth: int, least: int) -> None:
    """The tangent maps of a segment, halved until they are well conditioned."""
    matrix = problem.shoot(one, False).monodromy
    sizes = np.linalg.svd(matrix, compute_uv=False)
    # across the surfaces that the mode holds it is zero
    smallest = sizes[-1 - kernels_of(problem.plain).layout.held[one.segments[0, at.SEGMENT_MODE]]]
    if depth >= least and (depth >= TUNING.piece_halvings or sizes[0] < TUNING.piece_condition * smallest):
        found.append((one, matrix))
        return
    half = one.durations / 2
    middle = problem.at([replace(one, durations=half)], half[np.newaxis])[0][0, 0]
    starts = np.concatenate([middle, one.starts[0, problem.states :]])[np.newaxis]
    _cut(problem, replace(one, durations=half), found, depth + 1, least)
    rest = replace(one, starts=starts, phase=one.phase + float(half[0]), durations=half)
    _cut(problem, rest, found, depth + 1, least)
