"""A whole branch grown from one orbit: stretch by stretch, across the borders at which its events change."""

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.dataset import Outcome
from chaosdrill.dataset.branches import BranchEnd, Special
from chaosdrill.engine import branch
from chaosdrill.orbits.borders import Border, WeightsOf, bisect, go_on, reason, recounted, what_changed
from chaosdrill.orbits.doubling import returns
from chaosdrill.orbits.find import admissible
from chaosdrill.orbits.multipliers import structural_rank
from chaosdrill.orbits.special import LostError, locate, special_points
from chaosdrill.orbits.stretch import REST, Stretch, follow_branch

if TYPE_CHECKING:
    from chaosdrill.orbits.family import Family, Lap
    from chaosdrill.orbits.orbit import Orbit

FIRST = 0.1
"""First step of a stretch, as a part of the longest."""

MOST_BORDERS = 200
"""Borders that one branch may cross."""


@dataclass
class Mark:
    """A special point: which point of which stretch it is, what happens, how exactly it is known."""

    stretch: int
    point: int
    kind: Special
    error: float
    text: str


@dataclass
class Grown:
    """Stretches of one branch in order, with the rank of each one's tangent maps, marks, and how it ended."""

    stretches: list[Stretch] = field(default_factory=list)
    ranks: list[int] = field(default_factory=list)
    marks: list[Mark] = field(default_factory=list)
    end: BranchEnd = BranchEnd.MOST_POINTS
    words: str = ""

    def __len__(self) -> int:
        return sum(len(s) for s in self.stretches)

    def ended(self, end: BranchEnd) -> "Grown":
        """This branch, ended so, in the words of that end."""
        self.end, self.words = end, end.advice
        return self


@dataclass(frozen=True)
class Frame:
    """What limits a branch: ranges of its parameter, the longest step as a part of them, its number of points."""

    limits: tuple[float, float]
    step: float
    most: int

    @property
    def spans(self) -> np.ndarray:
        """Width of the ranges, shape (1,)."""
        return np.array([self.limits[1] - self.limits[0]])


MEETING = 1e-6
"""Distance in the norm of the weights at which two orbits of the same events are one."""


def met(family: "Family", orbit: "Orbit", weights: np.ndarray, known: list[Stretch]) -> bool:
    """Whether an orbit is one of those at the ends of stretches that are known."""
    for stretch in known:
        if len(stretch) and np.array_equal(stretch.arcs, orbit.arcs):
            for k in (0, -1):
                other = stretch.orbit(k % len(stretch))
                gap = np.abs(other.reduced(family.states) - orbit.reduced(family.states)) * weights
                gap[family.states] = 0.0
                if gap.max() < MEETING:
                    return True
    return False


def grow(
    family: "Family",
    orbit: "Orbit",
    ahead: np.ndarray,
    frame: Frame,
    known: tuple[Stretch, ...] = (),
    others: tuple[Stretch, ...] = (),
) -> Grown:
    """Follow a branch from a converged orbit in one direction, until it ends.

    Parameters
    ----------
    family : Family
    orbit : Orbit
    ahead : ndarray, shape (columns,)
        Which way to go.
    frame : Frame
    known : tuple of Stretch
        What was followed before in the other direction; the branch ends where it meets it.
    others : tuple of Stretch
        Other branches, at which it ends as well.
    """
    weights_of = WeightsOf(family, frame.spans)
    grown = Grown()
    length = 0.0
    for _ in range(MOST_BORDERS):
        weights = weights_of(orbit)
        room = frame.most - len(grown)
        if room < 1:
            return grown
        traced = follow_branch(family, orbit, ahead, weights, frame.limits, (FIRST * frame.step, frame.step), room)
        stretch = traced.stretch
        back = returns(family, [stretch.orbit(k) for k in range(len(stretch))], weights) if len(stretch) else None
        if back is not None:
            stretch = stretch.part(slice(0, back))
        if not len(stretch):
            return grown.ended(BranchEnd.NO_CONVERGENCE)
        rank = structural_rank(family, stretch.orbit(0))
        stretch, marks = _marked(family, stretch, weights, rank)
        grown.stretches.append(_shifted(stretch, length))
        grown.ranks.append(rank)
        place = len(grown.stretches) - 1
        grown.marks += [Mark(place, *mark) for mark in marks]
        if back is not None:
            return grown.ended(BranchEnd.DOUBLING)
        if traced.code == branch.BEYOND_LIMITS:
            _to_limit(family, grown, traced.beyond, frame, weights)
            grown.end, grown.words = BranchEnd.LIMIT, "the parameter reached its limit"
            return grown
        if traced.code == branch.CLOSED:
            return grown.ended(BranchEnd.CLOSED)
        if traced.code == REST:
            return grown.ended(BranchEnd.REST)
        if traced.code == branch.MOST_POINTS:
            grown.words = BranchEnd.MOST_POINTS.advice
            return grown
        last = stretch.orbit(len(stretch) - 1)
        if traced.beyond is None:
            border = Border(last, family.lap(last), None, None, frame.step * frame.spans[0] * branch.SHORTEST)
        else:
            border = bisect(family, last, traced.beyond, weights)
        coming = border.good.starts[0, -1] - stretch.starts[max(len(stretch) - 2, 0), 0, -1]
        beyond = go_on(family, border, weights_of)
        if beyond is None and traced.code == branch.LOST and _escapes(family, stretch, weights, frame):
            return grown.ended(BranchEnd.ESCAPED)
        if beyond is None:
            kind, text = reason(family, border)
            _close(grown, border, kind, f"{text}; the branch ends" if text else _lost(stretch))
            return grown
        if recounted(family, border.good, beyond.orbit):
            _append(grown, border, Special.REGULAR, "")
            grown.marks.pop()
        else:
            kind, text = what_changed(family, border, beyond.orbit)
            way = "continues" if coming * beyond.ahead[-1] > 0 else "folds back"
            _append(grown, border, kind, f"{text}; the branch {way}")
        length = float(grown.stretches[-1].arclengths[-1])
        orbit, ahead = beyond.orbit, beyond.ahead
        if met(family, orbit, weights_of(orbit), [*known, *grown.stretches]):
            return grown.ended(BranchEnd.CLOSED)
        if met(family, orbit, weights_of(orbit), list(others)):
            return grown.ended(BranchEnd.JOINED)
    grown.words = f"more than {MOST_BORDERS} changes of the sequence of events"
    return grown


LONGER = 3.0
"""Growth of the duration along a stretch that tells of an orbit which comes to pass by a point at rest."""


def _lost(stretch: Stretch) -> str:
    """Words for a branch that Newton's method could not follow, where its durations show why."""
    durations = stretch.durations.sum(axis=1)
    if durations[-1] > LONGER * durations[0]:
        return f"the duration grows without bound, to {durations[-1]:.3g}: the orbit comes to connect a point at rest"
    return ""


def _escapes(family: "Family", stretch: Stretch, weights: np.ndarray, frame: Frame) -> bool:
    """Whether a state of the orbits leaves its bounds one step beyond the end of a stretch."""
    last = stretch.orbit(len(stretch) - 1)
    lap = family.lap(last, watched=False)
    ahead = stretch.directions[-1] / np.linalg.norm(weights * stretch.directions[-1])
    return family.lap(family.moved(last, lap, frame.step * ahead), watched=False).outcome == Outcome.ESCAPED


def _shifted(stretch: Stretch, length: float) -> Stretch:
    return replace(stretch, arclengths=stretch.arclengths + length)


def _marked(
    family: "Family", stretch: Stretch, weights: np.ndarray, rank: int
) -> tuple[Stretch, list[tuple[int, Special, float, str]]]:
    """The stretch with its special points among its points, and their marks."""
    marks: list[tuple[int, Special, float, str]] = []
    added = 0
    for k in sorted({k for k, _ in special_points(family, stretch, rank)}):
        for orbit, lap, kind, error in _between(family, stretch, k + added, weights, rank, FINER):
            stretch = stretch.with_point(k + added, orbit, lap, kind)
            marks.append((k + added, kind, error, kind.words))
            added += 1
    return stretch, marks


FINER = 2
"""Times that a step is taken in smaller ones where what happens in it is not found."""

PARTS = 24
"""Smaller steps for one."""


def _between(
    family: "Family", stretch: Stretch, k: int, weights: np.ndarray, rank: int, finer: int
) -> "list[tuple[Orbit, Lap, Special, float]]":
    """Special points between point k - 1 and point k, in order.

    Where one is not found, because too much happens in the step, the branch between is followed in smaller steps.
    """
    pair = stretch.part(slice(k - 1, k + 1))
    before, after = pair.orbit(0), pair.orbit(1)
    kinds = [kind for _, kind in special_points(family, pair, rank)]
    try:
        located = [locate(family, before, after, kind, weights, rank) for kind in kinds]
        found = [one for one in located if one[2] != Special.REGULAR]
        return sorted(found, key=lambda one: float(np.abs(one[0].starts - before.starts).sum()))
    except LostError:
        if not finer:
            return []
    gap = float(pair.arclengths[1] - pair.arclengths[0])
    steps = (gap / PARTS, gap / PARTS)
    everywhere = (-np.inf, np.inf)
    part = follow_branch(family, before, pair.directions[0], weights, everywhere, steps, 8 * PARTS).stretch
    part = part.part(slice(0, int(np.searchsorted(part.arclengths, 1.02 * gap)) + 1))
    inner = sorted({i for i, _ in special_points(family, part, rank)})
    return [one for i in inner for one in _between(family, part, i, weights, rank, finer - 1)]


def _append(grown: Grown, border: Border, kind: Special, text: str) -> None:
    """The last orbit before a border becomes the last point of its stretch."""
    stretch = grown.stretches[-1]
    k = len(stretch)
    gap = np.linalg.norm(border.good.starts - stretch.starts[-1])
    grown.stretches[-1] = Stretch(
        stretch.arcs, stretch.periods,
        *(np.concatenate([old, np.asarray(new)[np.newaxis]]) for old, new in (
            (stretch.starts, border.good.starts), (stretch.phases, border.good.phase),
            (stretch.durations, border.good.durations), (stretch.speeds, border.lap.speeds),
            (stretch.arclengths, stretch.arclengths[-1] + gap), (stretch.residuals, border.lap.residual),
            (stretch.monodromies, border.lap.monodromy), (stretch.directions, stretch.directions[-1]),
            (stretch.special, int(kind)),
        )),
    )  # fmt: skip
    grown.marks.append(Mark(len(grown.stretches) - 1, k, kind, border.error, text))


def _close(grown: Grown, border: Border, kind: Special, text: str) -> None:
    """End a branch at a border behind which nothing was found."""
    ends = {
        Special.GRAZING: BranchEnd.GRAZING,
        Special.EVENT_SWAP: BranchEnd.EVENT_SWAP,
        Special.OUTCOME_SWITCH: BranchEnd.OUTCOME_SWITCH,
    }
    grown.end = ends.get(kind, BranchEnd.NO_CONVERGENCE)
    grown.words = text or grown.end.advice
    if kind != Special.REGULAR:
        _append(grown, border, kind, text)


def _to_limit(family: "Family", grown: Grown, beyond: "Orbit | None", frame: Frame, weights: np.ndarray) -> None:
    """The last point is the one at the limit itself."""
    assert beyond is not None
    stretch = grown.stretches[-1]
    last = stretch.orbit(len(stretch) - 1)
    here, there = last.starts[0, -1], beyond.starts[0, -1]
    limit = frame.limits[0] if there < frame.limits[0] else frame.limits[1]
    guess = last.between(beyond, (limit - here) / (there - here)).with_values(np.array([limit]), family.states)
    code, orbit, lap, _ = family.solve(guess)
    if code == branch.CONVERGED and admissible(orbit, lap) and abs(limit - here) > 0:
        border = Border(orbit, lap, None, None, 0.0)
        _append(grown, border, Special.REGULAR, "")
        grown.marks.pop()
