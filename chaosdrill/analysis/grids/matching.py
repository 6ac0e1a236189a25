"""Attractors are recognised as the same, wherever on them a run was when its record ended.

An attractor is known by its kind, its period, and the moments of its section points: means, second and third central
moments of every state. They do not depend on the phase at which a strobe finds a cycle.
"""

import math
from collections.abc import Mapping

import numpy as np

from chaosdrill.analysis.judgement.recurrence import sizes
from chaosdrill.codegen.kinds import float64, int64, void
from chaosdrill.codegen.signatures import integers
from chaosdrill.dataset import Outcome
from chaosdrill.dataset.outcomes import MEASURED
from chaosdrill.engine.jit import compiled
from chaosdrill.engine.shifts import Shifts

_cubes = float64[:, :, ::1]

SAME_CYCLE = 2e-5
"""Relative difference of moments below which two cycles are one."""

SAME_CHAOTIC = 0.2
"""Difference of the means of two attractors that are no cycles, in parts of their extent, below which they are one."""

SAME_CURVE = 0.02
"""The same of two cycles that are known by instants, or of which the period is unknown: means over phases that are
evenly apart are exact but for a few thousandths, and those of cycles around each other are alike otherwise."""

SAME_EXPONENT = 8.0
"""Difference of their leading exponents, in combined standard errors, up to which they are one: those of a diagram are
known from few frequencies, and one cell in 30,000 is six of them off, which a fine grid has."""

KNOWN_BY = ("period", "outcome", "moments", "lyapunov_exponent", "lyapunov_error")
"""Quantities that distinguish attractors."""

BLOCK = 2**16
"""Runs that are compared at once."""

MOST = 1000
"""Largest number of attractors distinguished in one analysis."""

ATTRACTING = tuple(int(outcome) for outcome in MEASURED if outcome not in (Outcome.OPEN, Outcome.TRANSIENT))
"""Outcomes of runs that stay somewhere."""


def moments(
    windows: np.ndarray, known: np.ndarray, period: np.ndarray, shifts: Shifts
) -> tuple[np.ndarray, np.ndarray]:
    """Moments of the section points of every run in the quotient by shifts, and one of the points.

    ``windows``, shape (P, W, n + 1): section points and modes; NaN behind the last. ``known``, shape (P, n): sizes that
    states have had on the way. ``period``, int, shape (P,): period of the cycle, whose points are then taken once each;
    0 for all points there are. ``shifts``: of which m coordinates stay.

    Returns: ``moments``, shape (P, 4, m): means, root mean squares about them, third central moments over the squares
    of the sizes, and their sizes. ``state``, shape (P, n): of a cycle the point with the smallest first state that no
    shift changes, else the last point.
    """
    paths, size = shifts.quotient(windows[:, :, :-1]), shifts.sizes(known)
    found, chosen = np.full((len(windows), 4, size.shape[1]), np.nan), np.full(len(windows), -1)
    found[:, 3] = size
    told = np.setdiff1d(np.arange(size.shape[1]), shifts.firsts)
    _moments(np.ascontiguousarray(paths), period.astype(np.int64), int(told[0]) if len(told) else 0, found, chosen)
    state = np.take_along_axis(windows, chosen[:, np.newaxis, np.newaxis], axis=1)[:, 0, :-1]
    return found, np.where(chosen[:, np.newaxis] < 0, np.nan, state)


@compiled(void(_cubes, integers, int64, _cubes, integers))
def _moments(windows, period, told, found, taken):
    n = windows.shape[2]
    for p in range(windows.shape[0]):
        rows = 0
        while rows < windows.shape[1] and np.isfinite(windows[p, rows, 0]):
            rows += 1
        if rows == 0:
            continue
        count = period[p] if period[p] > 0 else rows
        points = windows[p, rows - count : rows]
        lowest = 0
        for k in range(count):
            if points[k, told] < points[lowest, told]:
                lowest = k
        taken[p] = rows - count + lowest if period[p] > 0 else rows - 1
        for i in range(n):
            mean = 0.0
            size = 1e-100
            for k in range(count):
                mean += points[k, i]
                size = max(size, abs(points[k, i]))
            mean /= count
            second = 0.0
            third = 0.0
            for k in range(count):
                off = points[k, i] - mean
                second += off * off
                third += off * off * (off / size)
            found[p, 0, i] = mean
            found[p, 1, i] = math.sqrt(second / count)
            found[p, 2, i] = third / count / size


def alike_first(first: Mapping[str, np.ndarray], others: Mapping[str, np.ndarray]) -> np.ndarray:
    """Whether runs, (P,), are on the attractor of one run; all arrays have a leading dimension, that of ``first`` 1.

    A spiral of no extent on a section through a point at rest is that point, whatever its word.
    """
    kind = (others["period"] == first["period"]) & (others["outcome"] == first["outcome"])
    kind |= _still(others) & _still(first)
    (one, known_of_one), (many, known_of_many) = ((m[:, :3], m[:, 3]) for m in (first["moments"], others["moments"]))
    size = sizes(one, np.maximum(known_of_one, known_of_many))[:, np.newaxis]
    close = (np.abs(many - one) <= SAME_CYCLE * size).all(axis=(1, 2))
    spread = np.maximum(one[:, 1], many[:, 1]) + SAME_CYCLE * size[:, 0]
    part_of = np.where(first["outcome"] == Outcome.PERIODIC, SAME_CURVE, SAME_CHAOTIC)[:, np.newaxis, np.newaxis]
    chaotic = (np.abs(many[:, :2] - one[:, :2]) <= part_of * spread[:, np.newaxis]).all(axis=(1, 2))
    if others["lyapunov_exponent"].shape[-1]:
        with np.errstate(invalid="ignore"):
            apart = np.abs(others["lyapunov_exponent"][:, 0] - first["lyapunov_exponent"][:, 0])
            error = np.hypot(others["lyapunov_error"][:, 0], first["lyapunov_error"][:, 0])
            chaotic &= ~(apart > SAME_EXPONENT * error)
    is_one = (first["period"] > 0) | (first["outcome"] == Outcome.EQUILIBRIUM)
    return kind & np.where(is_one, close, chaotic)


def _still(found: Mapping[str, np.ndarray]) -> np.ndarray:
    """Which runs come to one point."""
    fixed = (found["outcome"] == Outcome.PERIODIC) & (found["period"] == 1)
    return np.asarray((found["outcome"] == Outcome.EQUILIBRIUM) | fixed)


def number_attractors(found: Mapping[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Number of the attractor of every run, from 1, and the first run of each; 0 without an attractor.

    The run that comes first in the grid, one at rest before others, stands for its attractor, so that the order of
    computation is of no account.
    Attractors are numbered in the order of their number of runs; those beyond the first ``MOST`` get no number.
    """
    numbers = np.zeros(len(found["outcome"]), dtype=np.int64)
    left = np.flatnonzero(np.isin(found["outcome"], ATTRACTING) & np.isfinite(found["moments"]).all(axis=(1, 2)))
    leaders: list[int] = []
    while len(left) and len(leaders) < MOST:
        first = part(found, left[:1])
        same = np.concatenate(
            [alike_first(first, part(found, some)) for some in np.split(left, range(BLOCK, len(left), BLOCK))]
        )
        same[0] = True
        mine = left[same]
        leaders.append(int(mine[np.argmax(found["outcome"][mine] == Outcome.EQUILIBRIUM)]))
        numbers[mine] = len(leaders)
        left = left[~same]
    sizes = np.bincount(numbers, minlength=len(leaders) + 1)[1:]
    order = np.argsort(-sizes, kind="stable")
    rank = np.zeros(len(leaders) + 1, dtype=np.int64)
    rank[1 + order] = np.arange(1, len(leaders) + 1)
    return rank[numbers], np.array(leaders, dtype=np.int64)[order]


def part(found: Mapping[str, np.ndarray], which: np.ndarray | list[int]) -> dict[str, np.ndarray]:
    """Quantities that distinguish the attractors of some runs."""
    return {name: found[name][which] for name in KNOWN_BY}


def count_attractors(found: Mapping[str, np.ndarray]) -> np.ndarray:
    """Number of different attractors among the seeds of every point; arrays of shape (P, S, ...)."""
    points, seeds = found["outcome"].shape
    numbers = np.zeros((points, seeds), dtype=np.int64)
    sound = np.isin(found["outcome"], ATTRACTING) & np.isfinite(found["moments"]).all(axis=(2, 3))
    for seed in range(seeds):
        others = {name: found[name][:, seed] for name in KNOWN_BY}
        for earlier in range(seed):
            first = {name: found[name][:, earlier] for name in KNOWN_BY}
            same = sound[:, seed] & sound[:, earlier] & (numbers[:, seed] == 0) & alike_first(first, others)
            numbers[same, seed] = numbers[same, earlier]
        new = sound[:, seed] & (numbers[:, seed] == 0)
        numbers[new, seed] = numbers[new].max(axis=1) + 1
    return numbers.max(axis=1, initial=0)
