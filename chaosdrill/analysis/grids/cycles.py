"""The cycle to which a slow transient leads, found without waiting for it.

Near a bifurcation one multiplier, or a pair, has nearly the modulus 1, and a run of any given length is still on its
way. The states at every p-th strobe, or point of a section, then follow a linear recurrence of order one or two, whose
limit follows from four of them (minimal polynomial extrapolation: Smith, Ford and Sidi 1987, doi:10.1137/1029042). A
run from that limit gives the next four; this converges quadratically in the slow directions. The cycle is taken for the
answer only if its own multipliers lie inside of the unit circle, its own period is p, and the run that led here comes
closer to it.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import groupby

import numpy as np

from chaosdrill.analysis.grids.judging import Verdict, judge, last_rows
from chaosdrill.analysis.grids.plan import Plan
from chaosdrill.analysis.judgement.classification import HYPERBOLIC, is_no_channel
from chaosdrill.analysis.judgement.recurrence import CLOSE, ROUND_OFF, recurrence, sizes, trend
from chaosdrill.analysis.judgement.statistics import block_ends, free_exponents, margin
from chaosdrill.analysis.judgement.tori import aside
from chaosdrill.analysis.tuning import CYCLES, PLAN
from chaosdrill.codegen import kernels_of
from chaosdrill.dataset import Outcome
from chaosdrill.dataset.outcomes import MEASURED
from chaosdrill.engine.batch import Batch, Standing
from chaosdrill.model import HybridSystem


@dataclass(frozen=True)
class Cycles:
    """Cycles of one period that were found: the batch that ran over them and what was judged there.

    ``which`` are the points of the batch that asked, ``places`` those of this one, in the same order.
    """

    batch: Batch
    verdict: Verdict
    which: np.ndarray
    places: np.ndarray


def search(plan: Plan, batch: Batch, which: np.ndarray, parameters: Mapping[str, np.ndarray]) -> list[Cycles]:
    """Look for attracting cycles near the present states of some points of a batch.

    ``batch``: the runs, at the end of their record. ``which``, int: the undecided points. ``parameters``, shape (P,):
    parameters of all points of the batch.

    A point that is in none of them stays undecided.
    """
    if not len(which) or not plan.maps:
        return []
    begun, trail = trail_of(plan, batch, which, parameters)
    open_ = np.ones(len(which), dtype=bool)
    results = []
    for points, periods, found, converged, turning in _tried(plan, begun, trail, open_, shrinking=True):
        for period in np.unique(periods[converged]).tolist():
            chosen = converged & (periods == period)
            group = points[chosen]
            on_cycle = begun.at(group, found[chosen])
            good, measured, verdict = _measure(plan, on_cycle, trail[group], period, turning[chosen])
            good &= open_[group]
            open_[group[good]] = False
            results.append(Cycles(measured, verdict, which[group[good]], np.flatnonzero(good)))
    return [cycles for cycles in results if len(cycles.which)]


@dataclass(frozen=True)
class Begun:
    """Where runs begin: parameters, states, modes, and how guards stand after an event of a section."""

    parameters: Mapping[str, np.ndarray]
    states: np.ndarray
    modes: np.ndarray
    standing: Standing | None
    known: np.ndarray  # (P, n): sizes that states have had on the way there

    def at(self, which: np.ndarray, states: np.ndarray) -> "Begun":
        """Runs of some of the points, from other states."""
        standing = None if self.standing is None else self.standing.at(which)
        return Begun(at_points(self.parameters, which), states, self.modes[which], standing, self.known[which])

    def let(self, runs: Batch) -> Batch:
        """Let runs from these states begin so."""
        runs.remember(self.known)
        if self.standing is not None:
            runs.stand(self.standing)
        return runs

    def mapped(self, plan: Plan, window: int) -> Batch:
        """Runs from there over steps of the map."""
        return self.let(plan.mapped(self.parameters, self.states, self.modes, window))

    def instants(self, plan: Plan) -> Batch:
        """Runs from there that keep their states at the ends of all parts of a duration."""
        return self.let(plan.instants(self.parameters, self.states, self.modes))


def stands(batch: Batch, parameters: Mapping[str, np.ndarray]) -> Begun:
    """Where all runs of a batch stand."""
    standing = batch.standing(np.arange(len(batch.x)))
    return Begun(parameters, batch.x.copy(), batch.mode.copy(), standing, batch.sizes)


def continued(plan: Plan, batch: Batch, which: np.ndarray, here: Mapping[str, np.ndarray]) -> Begun:
    """Where the map goes on from some points of a batch: where they stand, but at a strobe of a forcing."""
    if plan.system.forced and batch.counts_returns:
        batch.to_strobe(which)
    standing = batch.standing(which) if plan.at_events else None
    return Begun(here, batch.x[which], batch.mode[which], standing, batch.sizes[which])


def trail_of(
    plan: Plan, batch: Batch, which: np.ndarray, parameters: Mapping[str, np.ndarray]
) -> tuple[Begun, np.ndarray]:
    """Where some points of a batch stand, or soon after, and the points of the map beside that."""
    begun = continued(plan, batch, which, at_points(parameters, which))
    if plan.section is None:
        return begun, last_rows(batch.window[which], plan.compared)
    mapped = begun.mapped(plan, 2 * plan.max_period)
    mapped.run(0, np.array([0, 2 * plan.max_period]))
    if not plan.at_events:
        return begun, mapped.window
    standing = mapped.standing(np.arange(len(which)))
    return Begun(begun.parameters, mapped.x, mapped.mode, standing, mapped.sizes), mapped.window


def _tried(
    plan: Plan, begun: Begun, trail: np.ndarray, wanted: np.ndarray, *, shrinking: bool
) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]]:
    """Points still wanted whose trail shrinks, or grows, with the periods tried, and what `extrapolate` found."""
    path, known = aside(trail, plan.shifts), plan.shifts.sizes(begun.known)
    for points, periods in attempts(recurrence(path, known, plan.max_period, 2 * plan.max_period).near):
        tried = wanted[points] & trend(path, known, points, periods)[0 if shrinking else 1]
        points, periods = points[tried], periods[tried]
        yield points, periods, *extrapolate(plan, begun.at(points, begun.states[points]), periods)


def attempts(near: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Points and the periods to try there: all divisors of what nearly comes back, the shortest first.

    Periods of one octave are tried together, since the time of many small batches is spent between them.
    """
    tasks: dict[tuple[int, int], list[tuple[int, int]]] = {}
    for point, row in enumerate(near.tolist()):
        divisors = sorted({d for q in row for d in range(1, q + 1) if q % d == 0})
        for octave, some in groupby(divisors, key=lambda d: (d - 1).bit_length()):
            for turn, divisor in enumerate(some):
                tasks.setdefault((octave, turn), []).append((point, divisor))
    for key in sorted(tasks):
        points, periods = np.array(tasks[key]).T.copy()
        yield points, periods


def at_points(parameters: Mapping[str, np.ndarray], which: np.ndarray) -> dict[str, np.ndarray]:
    """Parameters of some of the points."""
    return {name: values[which] for name, values in parameters.items()}


def _cycles(periods: int, period: int) -> int:
    return max(CYCLES.least_cycles, -(-periods // period))


def _measure(
    plan: Plan, begun: Begun, trail: np.ndarray, period: int, turning: np.ndarray
) -> tuple[np.ndarray, Batch, Verdict]:
    """Run over cycles of one period, and say which of them are the answer."""
    states = begun.states
    batch = begun.let(plan.batch(begun.parameters, states, begun.modes, of_map=True))
    steps = CYCLES.averaging if plan.where.counts == "time" else max(CYCLES.averaging, plan.periods)
    ends = period * block_ends(_cycles(steps, period), PLAN.blocks)
    settling = period * _cycles(CYCLES.settling, period)
    batch.run(settling, ends)
    verdict = judge(plan, batch, np.arange(len(states)), ends)
    path = last_rows(batch.window, plan.judged)
    if plan.rows > ends[-1]:
        # of a run of its own: how many section points are kept moves no exponent
        kept = begun.let(plan.section_of_map(begun.parameters, states, begun.modes))
        kept.run(settling, np.array([0, period * _cycles(plan.rows, period)]))
        batch.window[:] = kept.window
    if plan.section is not None:
        mapped = begun.mapped(plan, 2 * period)
        mapped.run(0, np.array([0, 2 * period]))
        path = mapped.window
    neutral = plan.structure.most_neutral
    margins = margin(verdict.errors, batch.length[:, np.newaxis])
    complete = plan.computed == states.shape[1]
    free = free_exponents(verdict.exponents, neutral, margins, complete=complete)
    # the tangents of a complex pair go on turning and share its growth unevenly, but lose none of it
    pair = turning & (free.shape[1] > 1) & np.isfinite(free[:, min(1, free.shape[1] - 1)])
    with np.errstate(invalid="ignore"):
        shared = free[:, :2].mean(axis=1)
        multiplier = np.where(pair, shared, free[:, 0]) * batch.length * period / ends[-1]
    if not neutral:
        verdict.exponents[pair, :2], verdict.apart[pair, :2] = shared[pair, np.newaxis], 0.0
    good = verdict.moves & np.isin(verdict.outcome, MEASURED) & (verdict.period > 0) & (multiplier < -HYPERBOLIC)
    path, known = aside(path, plan.shifts), plan.shifts.sizes(begun.known)
    back, trail = recurrence(path, known, period, 2 * period), aside(trail, plan.shifts)
    periods = np.where(good & (back.period == period), period, 0)
    good &= (periods > 0) & is_no_channel(back, multiplier, trail, known, periods)
    good &= approaches(trail, path[:, :period], known, multiplier / period)
    return good, batch, replace(verdict, outcome=np.where(good, int(Outcome.PERIODIC), verdict.outcome))


def extrapolate(plan: Plan, begun: Begun, periods: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """States that come back after a period each, but for shifts, looked for from the given ones.

    Returns: ``states``, shape (P, n). ``found``, bool, shape (P,). ``turning``, bool, shape (P,): whether neighbours
    turn about them: the leading multipliers are a complex pair.
    """
    x, n = begun.states.copy(), begun.states.shape[1]
    tolerance = max(ROUND_OFF, 10 * plan.numerics.tolerance)
    active, converged = np.arange(len(x)), np.zeros(len(x), dtype=bool)
    before, turning = np.full(len(x), np.inf), np.zeros(len(x), dtype=bool)
    for attempt in range(CYCLES.rounds):
        if not len(active):
            break
        length = 4 * int(periods[active].max())
        runs = begun.at(active, x[active]).mapped(plan, length)
        runs.run(0, np.array([0, length]))
        places = np.arange(1, 5) * periods[active, np.newaxis] - 1
        passed = np.take_along_axis(runs.window, places[:, :, np.newaxis], axis=1)
        sound = (runs.outcome == Outcome.OK) & (passed[:, :, n] == begun.modes[active, np.newaxis]).all(axis=1)
        active, points = active[sound], passed[sound, :, :n]
        scale = sizes(points, begun.known[active])
        if plan.shifts:
            # as far along shifts as the first of them
            steps = plan.shifts.across(np.diff(points, axis=1, prepend=x[active, np.newaxis]))
            points = x[active, np.newaxis] + np.cumsum(steps, axis=1)
        residual = (np.abs(points[:, 0] - x[active]) / scale).max(axis=1)
        there = residual <= tolerance
        converged[active[there]] = True
        going = there | (attempt < 2) | (residual < CYCLES.shrinks * before[active])
        active, points, scale, there = active[going], points[going], scale[going], there[going]
        before[active] = residual[going]
        ends, turns = limit(points / scale[:, np.newaxis])
        x[active] = ends * scale
        turning[active[~there]] = turns[~there]
        active = active[~there]
    return x, converged, turning


def limit(z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Limit of sequences that obey a linear recurrence of order two, or one.

    ``z``, shape (P, 4, n): four successive points.

    Returns: ``limit``, shape (P, n). ``turning``, bool, shape (P,): whether the order is two and the roots are a
    complex pair.
    """
    d1, d2, d3 = (z[:, k + 1] - z[:, k] for k in range(3))

    def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return np.einsum("pi,pi->p", a, b)[:, np.newaxis]

    with np.errstate(invalid="ignore", divide="ignore"):
        along = d1 / np.sqrt(dot(d1, d1))
        a = dot(along, d2)
        across = d2 - a * along
        b = dot(across, across)
        c1 = -dot(across, d3) / b
        c0 = -(dot(along, d3) + a * c1) / np.sqrt(dot(d1, d1))
        second = (c0 * z[:, 1] + c1 * z[:, 2] + z[:, 3]) / (1 + c0 + c1)
        ratio = dot(d2, d3) / dot(d2, d2)
        first = z[:, 3] + d3 * ratio / (1 - ratio)
        planar = b > CYCLES.parallel**2 * dot(d2, d2)
        found = np.where(planar, second, first)
        turning = (planar & (c1**2 < 4 * c0))[:, 0]
    return np.where(np.isfinite(found).all(axis=1, keepdims=True), found, z[:, 3]), turning


def approaches(trail: np.ndarray, cycle: np.ndarray, known: np.ndarray, rate: np.ndarray) -> np.ndarray:
    """Whether runs come closer to cycles.

    ``trail``, shape (P, W, n + 1): the last points of the runs; NaN behind the last. ``cycle``, shape (P, p, n + 1):
    the points of the cycles. ``known``, shape (P, n): sizes that states have had on the way. ``rate``, shape (P,):
    logarithm of the leading multiplier a strobe.
    """
    points, period, n = len(trail), cycle.shape[1], trail.shape[2] - 1
    rows = int(np.isfinite(trail[:, :, 0]).all(axis=0).sum())
    scale = sizes(cycle[:, :, :n], known)[:, np.newaxis]
    best = np.full(points, np.inf)
    answer = np.zeros(points, dtype=bool)
    half = rows // 2
    for shift in range(period):
        aligned = cycle[:, (np.arange(rows) + shift) % period, :n]
        distance = (np.abs(trail[:, :rows, :n] - aligned) / scale).max(axis=2)
        early, late = distance[:, : rows - half].max(axis=1), distance[:, rows - half :].max(axis=1)
        closer = late < best
        nearer = (late <= CLOSE) | (late <= early * np.exp(CYCLES.approach * rate * half))
        answer = np.where(closer, nearer, answer)
        best = np.minimum(best, late)
    return answer


def escapes(
    plan: Plan, batch: Batch, which: np.ndarray, parameters: Mapping[str, np.ndarray]
) -> tuple[np.ndarray, Batch]:
    """Runs that begin further away from the cycles that some points of a batch are leaving.

    ``batch``: the runs, at the end of their record. ``which``, int: points that are undecided although they ran as long
    as they may. ``parameters``, shape (P,): parameters of all points of the batch.

    Returns: ``leaving``, int: the points that are leaving a cycle. ``runs``: a run for each of these, which has not
    begun.
    """
    begun, trail = trail_of(plan, batch, which, parameters)
    displaced, waiting = np.full(begun.states.shape, np.nan), np.ones(len(which), dtype=bool)
    for points, _, found, converged, _ in _tried(plan, begun, trail, waiting, shrinking=False):
        off = begun.states[points] - found
        distance = (np.abs(off) / sizes(found[:, np.newaxis], begun.known[points])).max(axis=1)
        slow = converged & (distance > 10 * ROUND_OFF) & (distance < CYCLES.displaced)
        displaced[points[slow]] = found[slow] + off[slow] * (CYCLES.displaced / distance[slow])[:, np.newaxis]
        waiting[points[slow]] = False
    chosen = np.flatnonzero(np.isfinite(displaced[:, 0]))
    begun = begun.at(chosen, displaced[chosen])
    return which[chosen], begun.let(plan.batch(begun.parameters, begun.states, begun.modes))


def linearised(system: HybridSystem, state: np.ndarray, mode: int) -> np.ndarray:
    """Eigenvalues of the rates of a system free of time about a state in a mode, complex, shape (n,)."""
    kernels = kernels_of(system)
    matrix = np.empty((len(state), len(state)))
    for unit, column in zip(np.eye(len(state)), matrix, strict=True):
        kernels.functions.variation(
            mode, 0.0, kernels.constants(system.parameters), np.ascontiguousarray(state), unit, column
        )
    return np.linalg.eigvals(matrix).astype(complex)
