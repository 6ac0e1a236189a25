"""Curves of folds, period doublings and grazing over two parameters."""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.dataset import Outcome
from chaosdrill.dataset.branches import BranchEnd, Special
from chaosdrill.orbits.borders import WeightsOf
from chaosdrill.orbits.collect import CHECKED, Planned, collect, miss, nothing
from chaosdrill.orbits.correcting import Corrector, Spot
from chaosdrill.orbits.failures import NoOrbitError
from chaosdrill.orbits.family import Family
from chaosdrill.orbits.find import starting_orbit
from chaosdrill.orbits.growing import MOST_BORDERS, Frame, Grown, Mark, grow
from chaosdrill.orbits.multipliers import structural_rank
from chaosdrill.orbits.onward import lifted, onward
from chaosdrill.orbits.results import BranchResult
from chaosdrill.orbits.special import NOISE, LostError
from chaosdrill.orbits.stability import free_multipliers
from chaosdrill.orbits.stretch import Stretch
from chaosdrill.orbits.targets import target_at
from chaosdrill.orbits.tracing import Traced, Tracer

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from chaosdrill.engine.numerics import Numerics
    from chaosdrill.model import HybridSystem
    from chaosdrill.orbits.branches import Progress
    from chaosdrill.orbits.orbit import Orbit

FOLLOWED = {kind.meaning: kind for kind in (Special.FOLD, Special.PERIOD_DOUBLING, Special.GRAZING)}
"""What can be followed, by name."""


def curve(
    system: "HybridSystem",
    parameters: tuple[str, str],
    limits: "Sequence[Sequence[float]] | np.ndarray",
    period: int,
    start: str,
    transient: int,
    follow: str,
    step: float,
    max_points: int,
    numerics: "Numerics",
    progress: "Progress | None",
) -> BranchResult:
    """The curve of folds, period doublings or grazing over two parameters through the nearest such point.

    That point is looked for on the branch of orbits over the first parameter, both ways from the start, with the second
    one as the system has it. From there the curve is followed both ways, around its own folds and cusps.

    Parameters
    ----------
    system : HybridSystem
    parameters : pair of str
    limits : array_like, shape (2, 2)
        Smallest and largest value of each.
    period, start, transient
        Of the first orbit, as in `chaosdrill.orbits.find.starting_orbit`.
    follow : {"fold", "period_doubling", "grazing"}
    step : float
        Longest step of the first parameter; that of the second is the same part of its range.
    max_points : int
        Points in one direction, at most.
    numerics : Numerics
    progress : callable, optional
        Called with directions done, directions in all and None.

    Returns
    -------
    BranchResult
        One branch, all points of which are of the kind that is followed. ``stable`` says whether all multipliers
        but the one that is +1 or -1 are inside of the unit circle. At grazing the orbit is the one without the event
        that appears. Without points, and with the reason in its message, if there is no orbit or no such point.
    """
    ranges = np.array(limits, dtype=float)
    kind, called = FOLLOWED[follow], follow.replace("_", " ")
    frame = Frame((float(ranges[0, 0]), float(ranges[0, 1])), step / float(np.ptp(ranges[0])), max_points)
    name = parameters[0]
    try:
        alone, orbit, lap, _, _ = starting_orbit(system, (name,), period, start, transient, numerics)
    except NoOrbitError as failure:
        return nothing(system, parameters, failure.outcome, failure.message)
    direction = alone.direction(orbit, lap, WeightsOf(alone, frame.spans)(orbit))
    grown = [grow(alone, orbit, sign * direction, frame) for sign in (1.0, -1.0)]
    found = _nearest(grown, kind)
    if found is None:
        text = f"no {called} on the branch of {name} through the orbit: {_told(grown)}"
        return nothing(system, parameters, Outcome.NO_SPECIAL_POINT, text)
    family = Family(system, parameters, numerics)
    try:
        corrector, first = _begin(family, lifted(found, system.parameters[parameters[1]]), kind, ranges)
    except LostError as lost:
        text = f"the {called} at {name} = {found.starts[0, -1]:.12g} cannot be followed: {lost}"
        return nothing(system, parameters, Outcome.NO_SPECIAL_POINT, text)
    halves: list[list[Traced]] = []
    for number, begin in enumerate((first, first.turned())):
        if halves and halves[0][-1].end == BranchEnd.CLOSED:
            break
        halves.append(_followed(corrector, begin, frame))
        if progress is not None:
            progress(number + 1, 2, None)
    words = f"the {called} at {name} = {first.orbit.starts[0, -2]:.12g}"
    rows = _rows(halves)
    result = collect(family, parameters, [Planned(_whole(family, halves, rows), -1, words)], None)
    stable = _stable(family, result.multipliers, kind)
    misses = [words for corrector, spots in rows for words in _misses(family, corrector, spots)]
    return replace(result, stable=stable, message="; ".join(misses[:3]))


def _nearest(grown: list[Grown], kind: Special) -> "Orbit | None":
    """The first orbit of the kind along either half of a branch, that of the shorter way from its start."""
    places = [
        (float(abs(one.stretches[m.stretch].arclengths[m.point])), one.stretches[m.stretch].orbit(m.point))
        for one in grown
        for m in one.marks
        if m.kind == kind
    ]
    return min(places, key=lambda place: place[0])[1] if places else None


def _told(grown: list[Grown]) -> str:
    """What there is on a branch instead."""
    marks = sorted(
        (float(one.stretches[m.stretch].starts[m.point, 0, -1]), m.kind.meaning.replace("_", " "))
        for one in grown
        for m in one.marks
    )
    there = ", ".join(f"{name} at {value:.9g}" for value, name in marks) or "nothing special"
    return f"{there} between {' and '.join(f'{v:.9g}' for v in sorted(_last(one) for one in grown))}"


def _last(grown: Grown) -> float:
    return float(grown.stretches[-1].starts[-1, 0, -1]) if grown.stretches else float("nan")


def _begin(family: Family, orbit: "Orbit", kind: Special, ranges: np.ndarray) -> tuple[Corrector, Spot]:
    weights = family.weights(orbit, np.ptp(ranges, axis=1))
    target, orbit, lap, instant = target_at(family, orbit, family.lap(orbit), kind, weights)
    corrector = Corrector(family, target, ranges)
    return corrector, corrector.first(orbit, lap, instant)


def _followed(corrector: Corrector, first: Spot, frame: Frame) -> list[Traced]:
    """The curve in one direction, from one sequence of events to the next."""
    parts: list[Traced] = []
    home, left = first, frame.most
    for _ in range(MOST_BORDERS):
        parts.append(Tracer(corrector, frame.step, left, home).trace(first))
        left -= len(parts[-1].spots)
        further = onward(corrector, parts[-1]) if left > 1 else None
        if further is None:
            break
        corrector, first, text = further
        parts[-1].words = f"{text}; the curve continues"
    return parts


Row = tuple[Corrector, list[Spot]]


def _rows(halves: list[list[Traced]]) -> list[Row]:
    """Points of both directions, the second one turned, one row for each sequence of events; the halves share one."""
    backward = [(part.corrector, [s.turned() for s in reversed(part.spots)]) for part in reversed(halves[-1])]
    forward = [(part.corrector, part.spots) for part in halves[0]]
    if len(halves) == 1:
        return forward
    joined = (forward[0][0], backward[-1][1][:-1] + forward[0][1])
    return [*backward[:-1], joined, *forward[1:]]


def _whole(family: Family, halves: list[list[Traced]], rows: list[Row]) -> Grown:
    """The rows as one branch, with its start and what happens at borders marked."""
    grown = Grown()
    origin = rows[0][1][0].arclength
    for corrector, spots in rows:
        orbits = [s.orbit for s in spots]
        stretch = Stretch(
            orbits[0].arcs, orbits[0].periods,
            *(np.array(values) for values in (
                [o.starts for o in orbits], [o.phase for o in orbits], [o.durations for o in orbits],
                [s.lap.speeds for s in spots], [s.arclength - origin for s in spots],
                [s.lap.residual for s in spots], [s.lap.monodromy for s in spots], [s.tangent for s in spots],
                [int(corrector.target.kind)] * len(spots),
            )),
        )  # fmt: skip
        middle = spots[len(spots) // 2]
        followed, _ = corrector.beside(middle) or (middle.orbit, middle.lap)
        grown.stretches.append(stretch)
        grown.ranks.append(structural_rank(family, followed))
    place = len(halves[1]) - 1 if len(halves) > 1 else 0
    start = halves[0][0].spots[0]
    scale = float(np.ptp(rows[0][0].limits[0]))
    error = start.error * scale + NOISE * abs(float(start.orbit.starts[0, -2]))
    point = len(rows[place][1]) - len(halves[0][0].spots)
    grown.marks.append(Mark(place, point, rows[0][0].target.kind, error, "the curve was followed from here"))
    for sign, half in zip((1, -1), halves, strict=False):
        for number, part in enumerate(half):
            if part.border is not None and part.happens != Special.REGULAR:
                row = place + sign * number
                point = len(rows[row][1]) - 1 if sign > 0 else 0
                grown.marks.append(Mark(row, point, part.happens, part.border.error, part.words))
    ends = [half[-1] for half in halves]
    grown.end, grown.words = ends[0].end, ends[0].words
    if ends[-1].words != ends[0].words:
        grown.words = f"{ends[0].words}; at its start: {ends[-1].words}"
    return grown


def _misses(family: Family, corrector: Corrector, spots: list[Spot]) -> "Iterator[str]":
    """What runs of the ordinary engine say against some of the points."""
    # next to an end a run may see an event of no speed or not
    for k in np.unique(np.linspace(0, len(spots) - 1, CHECKED + 2)[1:-1].astype(int)).tolist() if spots[2:] else []:
        found = corrector.beside(spots[k])
        words = miss(family, found[0]) if found is not None else ""
        if words:
            yield words


def _stable(family: Family, values: np.ndarray, kind: Special) -> np.ndarray:
    """Whether all multipliers but the critical one are inside of the unit circle; False where one is NaN."""
    free = free_multipliers(values, family.neutral.count)
    moduli = np.abs(free)
    if kind != Special.GRAZING:
        critical = 1.0 if kind == Special.FOLD else -1.0
        np.put_along_axis(moduli, np.abs(free - critical).argmin(axis=-1)[:, np.newaxis], 0.0, axis=-1)
    return (moduli < 1).all(axis=-1)
