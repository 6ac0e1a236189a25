"""Attractors that are no cycles are counted once: two are one if long records of them visit the same cells.

Means over short records differ from run to run, the more the slower the motion mixes, so that runs on one attractor may
seem to be on several. What attractors seem to be found is therefore followed from its first run on, over a record of a
length of its own, and the records are compared by the cells of a grid that they visit, as Attractors.jl tells
attractors by recurrences (Datseris and Wagemakers 2022, doi:10.1063/5.0076568): invariant sets that are apart share no
cells, if these are small enough. A record that turns out to end on a cycle belongs to that.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from chaosdrill.analysis.grids.matching import alike_first, moments, part
from chaosdrill.analysis.grids.plan import Plan
from chaosdrill.analysis.judgement.classification import OPEN_ANSWERS, is_own_period, undrawn
from chaosdrill.analysis.judgement.recurrence import CLOSE, recurrence, sizes
from chaosdrill.analysis.judgement.resting import rests
from chaosdrill.analysis.judgement.tori import aside
from chaosdrill.analysis.tuning import ATTRACTORS
from chaosdrill.dataset import Outcome
from chaosdrill.engine.batch import Batch
from chaosdrill.engine.shifts import Shifts


@dataclass(frozen=True)
class Followed:
    """Long records of attractors that came to no cycle and to no rest."""

    which: np.ndarray  # int (A,): their places among the attractors
    points: np.ndarray  # (A, LENGTH, n + 1): states and modes
    known: np.ndarray  # (A, n): sizes that states have had on the way
    shifts: Shifts  # modulo which they are compared


def merge(
    plan: Plan,
    found: Mapping[str, np.ndarray],
    numbers: np.ndarray,
    leaders: np.ndarray,
    begin: Callable[[Plan, np.ndarray], Batch],
) -> tuple[np.ndarray, np.ndarray]:
    """Numbers and leaders, as of `number_attractors`, after those that are one have been merged.

    ``found``: what is known of all runs. ``numbers``, ``leaders``, int: the attractor of every run, from 1, and the run
    that stands for each. ``begin``: given places among the attractors, runs over steps of the map from where those
    began that stand for them, which keep as many points as records are compared by, of the plan that is given.
    """
    loose = (found["period"][leaders] == 0) & (found["outcome"][leaders] != Outcome.EQUILIBRIUM)
    todo, part_of = np.flatnonzero(loose), np.arange(len(leaders))
    if len(todo) == 0 or len(leaders) < 2:
        return numbers, leaders
    told, plan = part(found, leaders), plan.uneven()
    settled, left, room = [], [], ATTRACTORS.most
    while len(todo) and room:
        # those that settle leave their place to others
        which, todo = todo[:room], todo[room:]
        followed, ended = _follow(plan, which, begin(plan, which), told)
        settled += ended
        left.append(followed)
        room -= len(which) - len(ended)
    same = [(one, other) for one in settled for other in np.flatnonzero(alike_first(part(told, [one]), told)).tolist()]
    for one, other in (*_pairs(left, told["outcome"]), *same):
        part_of[part_of == part_of[other]] = part_of[one]
    return _renumbered(found, numbers, leaders, part_of)


def _follow(plan: Plan, which: np.ndarray, runs: Batch, told: dict[str, np.ndarray]) -> tuple[Followed, list[int]]:
    """Records of some attractors; those whose records end on a cycle or at rest, which ``told`` then records."""
    runs.run(plan.transient, np.array([0, ATTRACTORS.length]))
    there = np.flatnonzero(runs.outcome == Outcome.OK)
    points, known, shifts = undrawn(plan.system, runs.window[there]), runs.sizes[there], plan.shifts
    seen = recurrence(aside(points, shifts), shifts.sizes(known), plan.max_period, 2 * plan.max_period)
    period = np.where(is_own_period(seen), seen.period, 0)
    rows = np.flatnonzero(period) if plan.maps else np.zeros(0, dtype=np.int64)
    cycles = which[there[rows]]
    told["outcome"][cycles], told["period"][cycles] = Outcome.PERIODIC, period[rows]
    told["moments"][cycles], _ = moments(points[rows], known[rows], period[rows], shifts)
    # points of a section come to none, states at instants stand still
    still = (Outcome.EQUILIBRIUM, Outcome.NO_RETURN, *(() if plan.maps else (Outcome.OK,)))
    found = np.flatnonzero(np.isin(runs.outcome, still if plan.system.autonomous else ()))
    found = found[rests(runs.x[found], runs.sizes[found], runs.flow(found), plan.where.unit, runs.rounding(found))]
    told["outcome"][which[found]] = Outcome.EQUILIBRIUM
    for row in found.tolist():
        told["moments"][which[row], :3] = 0.0
        told["moments"][which[row], 0] = shifts.quotient(runs.rest(row))
    # at instants a cycle has no period, but means over all its phases
    rows = np.flatnonzero((told["outcome"][which[there]] == Outcome.PERIODIC) & (not plan.maps))
    curves = which[there[rows]]
    told["moments"][curves], _ = moments(points[rows], known[rows], np.zeros(len(rows)), shifts)
    ended = np.concatenate([cycles, which[found], curves])
    # one record of each such cycle stays, and of each rest: those are compared with it that have not quite come to it
    firsts: list[int] = []
    for place in [*which[found].tolist(), *curves.tolist()]:
        if not any(alike_first(part(told, [first]), part(told, [place]))[0] for first in firsts):
            firsts.append(place)
    on = np.flatnonzero(~np.isin(which[there], np.setdiff1d(ended, firsts)))
    return Followed(which[there[on]], points[on], known[on], shifts), ended.tolist()


def _pairs(followed: list[Followed], outcome: np.ndarray) -> list[tuple[int, int]]:
    """Attractors, by their places, of which each pair is one.

    A record may have been in a part only of what the other visits. Of different words, neither of them open, each must
    visit cells of the other: a cycle within a sea lies in cells that this visits.
    """
    place = np.concatenate([one.which for one in followed]).tolist()
    if len(place) < 2:
        return []
    shifts = followed[0].shifts
    points, known = (np.concatenate([getattr(one, name) for one in followed]) for name in ("points", "known"))
    records = _scaled(aside(points, shifts), shifts.sizes(known))
    half = ATTRACTORS.length // 2
    for count in ATTRACTORS.cells:
        cells = _cells(records, count)
        again = np.array([np.isin(one[half:], one[:half]).mean() for one in cells])
        if np.median(again) >= ATTRACTORS.familiar:
            break
    visited = [np.unique(one) for one in cells]
    pairs = []
    for i, j in combinations(range(len(place)), 2):
        words = {int(outcome[place[i]]), int(outcome[place[j]])}
        enough = max if len(words.difference(OPEN_ANSWERS)) < 2 else min
        if enough(np.isin(cells[i], visited[j]).mean(), np.isin(cells[j], visited[i]).mean()) >= ATTRACTORS.shared:
            pairs.append((place[i], place[j]))
    return pairs


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


def _renumbered(
    found: Mapping[str, np.ndarray], numbers: np.ndarray, leaders: np.ndarray, part_of: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Attractors that were merged, by the number of their runs; one that has settled, or whose word is known, stands
    for each."""
    sizes_of = np.bincount(numbers, minlength=len(leaders) + 1)[1:]
    kept = np.unique(part_of)
    total = np.array([sizes_of[part_of == one].sum() for one in kept])
    order = kept[np.argsort(-total, kind="stable")]
    outcome = found["outcome"][leaders]
    settled = (found["period"][leaders] > 0) | (outcome == Outcome.EQUILIBRIUM)
    unknown = np.where(settled, 0, np.where(outcome == Outcome.UNDECIDED, 2, 1))
    chosen = [min(np.flatnonzero(part_of == one), key=lambda k: (unknown[k], -sizes_of[k], k)) for one in order]
    rank = np.zeros(len(leaders) + 1, dtype=np.int64)
    for number, one in enumerate(order, start=1):
        rank[1 + np.flatnonzero(part_of == one)] = number
    return rank[numbers], leaders[np.array(chosen, dtype=np.int64)]
