"""The cycle to which a slow transient leads, found without waiting for it.

Near a bifurcation one multiplier, or a pair, has nearly the modulus 1, and a run of any given length is still on its
way. The states at every p-th strobe then follow a linear recurrence of order one or two, whose limit follows from four
of them (minimal polynomial extrapolation: Sidi, Ford and Smith 1988, doi:10.1137/1030095). A run from that limit gives
the next four; this converges quadratically in the slow directions. The cycle is taken for the answer only if
its own multipliers lie inside of the unit circle, its own period is p, and the run that led here comes closer to it.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from chaosdrill.analysis.plan import Plan, block_ends
from chaosdrill.analysis.recurrence import CLOSE, recurrence
from chaosdrill.analysis.verdicts import HYPERBOLIC, ROUND_OFF, Verdict, judge
from chaosdrill.dataset import Outcome
from chaosdrill.engine.batch import Batch

ROUNDS = 12
"""Extrapolations, at most."""

SHRINKS = 0.5
"""Part of the residual that may be left after a round, beyond the first two."""

SETTLING = 32
"""Cycles in which tangents turn into their directions before growth is averaged."""

PARALLEL = 1e-3
"""Sine of the angle below which two differences have one direction."""

APPROACH = 0.25
"""Part of the linear rate at which a run comes closer to the cycle at least."""


@dataclass(frozen=True)
class Cycle:
    """A cycle that was found: the batch that ran over it, what was judged there, and the place of the point in both."""

    batch: Batch
    verdict: Verdict
    place: int


def search(plan: Plan, batch: Batch, which: np.ndarray, parameters: Mapping[str, np.ndarray]) -> dict[int, Cycle]:
    """Look for attracting cycles near the present states of some points of a batch.

    Parameters
    ----------
    plan : Plan
    batch : Batch
        The runs, at a strobe.
    which : ndarray of int
        The undecided points.
    parameters : mapping of str to ndarray, shape (P,)
        Parameters of all points of the batch.

    Returns
    -------
    dict of int to Cycle
        By index of the point in the batch; points without an entry stay undecided.
    """
    results: dict[int, Cycle] = {}
    here = {name: values[which] for name, values in parameters.items()}
    states, modes, trail = batch.x[which], batch.mode[which], batch.window[which]
    if plan.section is not None:
        strobed = plan.strobed(here, states, modes, 2 * plan.max_period)
        strobed.run(0, np.array([0, 2 * plan.max_period]))
        states, modes, trail = strobed.x, strobed.mode, strobed.window
    near = recurrence(trail, plan.max_period, 2 * plan.max_period).near
    open_ = np.ones(len(which), dtype=bool)
    for period in sorted({d for q in set(near.ravel().tolist()) for d in range(1, q + 1) if q % d == 0}):
        group = np.flatnonzero(open_ & ((near > 0) & (near % period == 0)).any(axis=1))
        at = {name: values[group] for name, values in here.items()}
        found, converged = extrapolate(plan, at, states[group], modes[group], period)
        group, found = group[converged], found[converged]
        if not len(group):
            continue
        at = {name: values[group] for name, values in here.items()}
        good, cycle = _measure(plan, at, found, modes[group], trail[group], period)
        for place in np.flatnonzero(good):
            results[int(which[group[place]])] = Cycle(*cycle, int(place))
        open_[group[good]] = False
    return results


def _measure(
    plan: Plan,
    parameters: Mapping[str, np.ndarray],
    states: np.ndarray,
    modes: np.ndarray,
    trail: np.ndarray,
    period: int,
) -> tuple[np.ndarray, tuple[Batch, Verdict]]:
    """Run over cycles of one period, and say which of them are the answer."""
    path = plan.strobed(parameters, states, modes, 2 * period)
    path.run(0, np.array([0, 2 * period]))
    batch = plan.batch(parameters, states, modes)
    cycles = max(SETTLING, -(-plan.periods // period))
    ends = block_ends(cycles, period)
    batch.run(SETTLING * period, ends)
    verdict = judge(plan, batch, np.arange(len(states)), ends)
    good = (verdict.outcome == Outcome.PERIODIC) & (verdict.period > 0) & (verdict.multiplier < -HYPERBOLIC)
    good &= recurrence(path.window, period).period == period
    good &= approaches(trail, path.window[:, :period], verdict.multiplier / period)
    return good, (batch, verdict)


def extrapolate(
    plan: Plan, parameters: Mapping[str, np.ndarray], states: np.ndarray, modes: np.ndarray, period: int
) -> tuple[np.ndarray, np.ndarray]:
    """States that come back after a period, looked for from the given ones, and which of them were found."""
    x, n = states.copy(), states.shape[1]
    tolerance = max(ROUND_OFF, 10 * plan.numerics.tolerance)
    active, converged = np.arange(len(x)), np.zeros(len(x), dtype=bool)
    before = np.full(len(x), np.inf)
    for attempt in range(ROUNDS):
        at = {name: values[active] for name, values in parameters.items()}
        runs = plan.strobed(at, x[active], modes[active], 4 * period)
        runs.run(0, np.array([0, 4 * period]))
        passed = runs.window[:, period - 1 :: period]
        points = passed[:, :, :n]
        sound = (runs.outcome == Outcome.OK) & (passed[:, :, n] == modes[active, np.newaxis]).all(axis=1)
        active, points = active[sound], points[sound]
        scale = np.abs(points).max(axis=1)
        scale = scale + 1e-6 * scale.max(axis=1, keepdims=True) + 1e-300
        residual = (np.abs(points[:, 0] - x[active]) / scale).max(axis=1)
        there = residual <= tolerance
        converged[active[there]] = True
        going = ~there & ((attempt < 2) | (residual < SHRINKS * before[active]))
        active, points, scale = active[going], points[going], scale[going]
        if not len(active):
            break
        before[active] = residual[going]
        x[active] = limit(points / scale[:, np.newaxis]) * scale
    return x, converged


def limit(z: np.ndarray) -> np.ndarray:
    """Limit of sequences that obey a linear recurrence of order two, or one, from four points; (P, 4, n) to (P, n)."""
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
        found = np.where(b > PARALLEL**2 * dot(d2, d2), second, first)
    return np.where(np.isfinite(found).all(axis=1, keepdims=True), found, z[:, 3])


def approaches(trail: np.ndarray, cycle: np.ndarray, rate: np.ndarray) -> np.ndarray:
    """Whether runs come closer to cycles.

    Parameters
    ----------
    trail : ndarray, shape (P, W, n + 1)
        The last points of the runs; NaN behind the last.
    cycle : ndarray, shape (P, p, n + 1)
        The points of the cycles.
    rate : ndarray, shape (P,)
        Logarithm of the leading multiplier a strobe.
    """
    points, period, n = len(trail), cycle.shape[1], trail.shape[2] - 1
    rows = int(np.isfinite(trail[:, :, 0]).all(axis=0).sum())
    scale = np.abs(cycle[:, :, :n]).max(axis=1)
    scale = (scale + 1e-6 * scale.max(axis=1, keepdims=True) + 1e-300)[:, np.newaxis]
    best = np.full(points, np.inf)
    answer = np.zeros(points, dtype=bool)
    half = rows // 2
    for shift in range(period):
        aligned = cycle[:, (np.arange(rows) + shift) % period, :n]
        distance = (np.abs(trail[:, :rows, :n] - aligned) / scale).max(axis=2)
        early, late = distance[:, : rows - half].max(axis=1), distance[:, rows - half :].max(axis=1)
        closer = late < best
        nearer = (late <= CLOSE) | (late <= early * np.exp(APPROACH * rate * half))
        answer = np.where(closer, nearer, answer)
        best = np.minimum(best, late)
    return answer
