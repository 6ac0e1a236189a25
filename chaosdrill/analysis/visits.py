"""Attractors that are no cycles are counted once: two are one if long records of them visit the same cells.

Means over short records differ from run to run, the more the slower the motion mixes, so that runs on one attractor may
seem to be on several. What attractors seem to be found is therefore followed from its first run on, over a record of a
length of its own, and the records are compared by the cells of a grid that they visit, as Attractors.jl tells
attractors by recurrences (Datseris and Wagemakers 2022, doi:10.1063/5.0076568): invariant sets that are apart share no
cells, if these are small enough. A record that turns out to end on a cycle belongs to that.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from chaosdrill.analysis.classification import undrawn
from chaosdrill.analysis.matching import KNOWN_BY, alike_first, moments
from chaosdrill.analysis.plan import Plan
from chaosdrill.analysis.recurrence import CLOSE, recurrence, sizes
from chaosdrill.analysis.tori import aside
from chaosdrill.analysis.tuning import ATTRACTORS
from chaosdrill.dataset import Outcome
from chaosdrill.engine.batch import Batch
from chaosdrill.engine.shifts import Shifts


@dataclass(frozen=True)
class Followed:
    """Long records of some attractors."""

    which: np.ndarray  # int (A,): their places among the attractors
    points: np.ndarray  # (A, LENGTH, n + 1): states and modes
    known: np.ndarray  # (A, n): sizes that states have had on the way
    shifts: Shifts  # modulo which they are compared
    period: np.ndarray  # int (A,): of the cycle on which the record ends; 0: none


def merge(
    plan: Plan,
    found: Mapping[str, np.ndarray],
    numbers: np.ndarray,
    leaders: np.ndarray,
    begin: Callable[[np.ndarray], Batch],
) -> tuple[np.ndarray, np.ndarray]:
    """Numbers and leaders, as of `number_attractors`, after those that are one have been merged.

    Parameters
    ----------
    found : mapping of str to ndarray
        What is known of all runs.
    numbers, leaders : ndarray of int
        The attractor of every run, from 1, and the run that stands for each.
    begin : callable
        Given places among the attractors, runs over steps of the map from where those began that stand for them, which
        keep as many points as records are compared by.
    """
    loose = (found["period"][leaders] == 0) & (found["outcome"][leaders] != Outcome.EQUILIBRIUM)
    which = np.flatnonzero(loose)[: ATTRACTORS.most]
    if len(which) == 0 or len(leaders) < 2:
        return numbers, leaders
    followed = _follow(plan, which, begin(which))
    part_of = np.arange(len(leaders))
    for one, other in _pairs(followed):
        part_of[part_of == part_of[other]] = part_of[one]
    for place, cycle in _on_cycles(found, leaders, followed):
        part_of[part_of == part_of[place]] = part_of[cycle]
    return _renumbered(found, numbers, leaders, part_of)


def _follow(plan: Plan, which: np.ndarray, runs: Batch) -> Followed:
    runs.run(plan.transient, np.array([0, ATTRACTORS.length]))
    there = runs.outcome == Outcome.OK
    points, known, shifts = undrawn(plan.system, runs.window[there]), runs.sizes[there], plan.shifts
    period = recurrence(aside(points, shifts), shifts.sizes(known), plan.max_period, 2 * plan.max_period).period
    return Followed(which[there], points, known, shifts, period if plan.maps else np.zeros_like(period))


def _pairs(followed: Followed) -> list[tuple[int, int]]:
    """Attractors, by their places, of which each pair is one."""
    rows = np.flatnonzero(followed.period == 0)
    if len(rows) < 2:
        return []
    shifts = followed.shifts
    records = _scaled(aside(followed.points[rows], shifts), shifts.sizes(followed.known[rows]))
    half = ATTRACTORS.length // 2
    for count in ATTRACTORS.cells:
        cells = _cells(records, count)
        again = np.array([np.isin(one[half:], one[:half]).mean() for one in cells])
        if np.median(again) >= ATTRACTORS.familiar:
            break
    visited = [np.unique(one) for one in cells]
    place = followed.which[rows].tolist()
    return [
        (place[i], place[j])
        for i in range(len(rows))
        for j in range(i + 1, len(rows))
        if max(np.isin(cells[i], visited[j]).mean(), np.isin(cells[j], visited[i]).mean()) >= ATTRACTORS.shared
    ]


def _scaled(points: np.ndarray, known: np.ndarray) -> np.ndarray:
    """States in parts of the extent of all records, 0 for those that do not move, and modes."""
    states = points[:, :, :-1]
    low, extent = states.min(axis=(0, 1)), np.ptp(states, axis=(0, 1))
    moves = extent > CLOSE * sizes(states.reshape(1, -1, states.shape[2]), known.max(axis=0)[np.newaxis])[0]
    scaled = np.where(moves, (states - low) / np.where(moves, extent, 1.0), 0.0)
    return np.concatenate([scaled, points[:, :, -1:]], axis=2)


def _cells(records: np.ndarray, count: int) -> np.ndarray:
    """Numbers of the cells in which the points of records lie, shape (A, length)."""
    place = np.minimum((records[:, :, :-1] * count).astype(np.int64), count - 1)
    table = np.concatenate([place, records[:, :, -1:].astype(np.int64)], axis=2)
    _, number = np.unique(table.reshape(-1, table.shape[2]), axis=0, return_inverse=True)
    return np.asarray(number.reshape(table.shape[:2]))


def _on_cycles(found: Mapping[str, np.ndarray], leaders: np.ndarray, followed: Followed) -> list[tuple[int, int]]:
    """Attractors whose records end on a cycle, and those that are this cycle, by their places."""
    rows = np.flatnonzero(followed.period > 0)
    seen, _ = moments(followed.points[rows], followed.known[rows], followed.period[rows], followed.shifts)
    known = {name: found[name][leaders] for name in KNOWN_BY}
    pairs = []
    for row, of_it in zip(rows.tolist(), seen, strict=True):
        one = {name: values[:1] for name, values in known.items()} | {
            "period": followed.period[row : row + 1],
            "outcome": np.array([int(Outcome.PERIODIC)]),
            "moments": of_it[np.newaxis].astype(known["moments"].dtype),
        }
        pairs += [(int(followed.which[row]), int(same)) for same in np.flatnonzero(alike_first(one, known))[:1]]
    return pairs


def _renumbered(
    found: Mapping[str, np.ndarray], numbers: np.ndarray, leaders: np.ndarray, part_of: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Attractors that were merged, by the number of their runs; a run whose word is known stands for each."""
    sizes_of = np.bincount(numbers, minlength=len(leaders) + 1)[1:]
    kept = np.unique(part_of)
    total = np.array([sizes_of[part_of == one].sum() for one in kept])
    order = kept[np.argsort(-total, kind="stable")]
    unknown = found["outcome"][leaders] == Outcome.UNDECIDED
    chosen = [min(np.flatnonzero(part_of == one), key=lambda k: (unknown[k], -sizes_of[k], k)) for one in order]
    rank = np.zeros(len(leaders) + 1, dtype=np.int64)
    for number, one in enumerate(order, start=1):
        rank[1 + np.flatnonzero(part_of == one)] = number
    return rank[numbers], leaders[np.array(chosen, dtype=np.int64)]
