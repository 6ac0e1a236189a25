"""Branches of orbits over one parameter: from a start in both directions, and onto the doubled ones."""

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.dataset import Outcome
from chaosdrill.dataset.branches import BranchEnd, Special
from chaosdrill.engine import branch
from chaosdrill.engine.numerics import Numerics
from chaosdrill.orbits.borders import WeightsOf
from chaosdrill.orbits.cascade import cascade_from
from chaosdrill.orbits.collect import Planned, collect, nothing
from chaosdrill.orbits.doubling import doubled
from chaosdrill.orbits.failures import NoOrbitError, admissible
from chaosdrill.orbits.find import starting_orbit
from chaosdrill.orbits.growing import Frame, Grown, Mark, grow
from chaosdrill.orbits.multipliers import multipliers
from chaosdrill.orbits.results import BranchResult, Cascade
from chaosdrill.orbits.stability import free_multipliers, is_stable

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem
    from chaosdrill.orbits.family import Family, Lap
    from chaosdrill.orbits.orbit import Orbit

NO_EFFECT = 1e-12
"""Slope of what makes an orbit over the parameter below which a parameter does nothing to it."""

FINER = 20
"""Steps in the distance between two doublings, on the branches that follow."""

Progress = Callable[[int, int, None], None]


def branches(
    system: "HybridSystem",
    parameter: str,
    limits: tuple[float, float],
    period: int,
    start: str,
    transient: int,
    doublings: int,
    step: float,
    max_points: int,
    numerics: Numerics,
    progress: Progress | None,
) -> BranchResult:
    """The branch through an orbit, and up to ``doublings`` generations of doubled ones.

    Parameters
    ----------
    system : HybridSystem
    parameter : str
    limits : pair of float
        Smallest and largest value of the parameter.
    period, start, transient
        Of the first orbit, as in `chaosdrill.orbits.find.starting_orbit`.
    doublings : int
        Generations of doubled orbits that are followed.
    step : float
        Longest step of the parameter.
    max_points : int
        Points of one branch, at most.
    numerics : Numerics
    progress : callable, optional
        Called with branches done, branches planned and None.

    Returns
    -------
    BranchResult
        Without points, and with the reason in its outcome and message, if there is no orbit to start with.
    """
    try:
        family, orbit, lap, _, _ = starting_orbit(system, (parameter,), period, start, transient, numerics)
    except NoOrbitError as failure:
        return nothing(system, (parameter,), failure.outcome, failure.message)
    span = limits[1] - limits[0]
    frame = Frame(limits, step / span, max_points)
    weights = WeightsOf(family, frame.spans)(orbit)
    direction = family.direction(orbit, lap, weights)
    orbit, direction = _beside(family, orbit, lap, direction, frame, weights)
    forward = grow(family, orbit, direction, frame)
    whole = forward
    if forward.end != BranchEnd.CLOSED:
        backward = grow(family, orbit, -direction, frame, tuple(forward.stretches))
        whole = _joined(backward, forward) if forward.stretches else backward
    if not whole.stretches:
        return nothing(system, (parameter,), Outcome.NO_ORBIT, "from its first orbit no branch could be followed")
    if not whole.marks and _unmoved(whole):
        whole.end, whole.words = BranchEnd.NO_EFFECT, BranchEnd.NO_EFFECT.advice
    value = system.parameters[parameter]
    planned = [Planned(whole, -1, f"an orbit of period {orbit.periods} at {parameter} = {value:g}")]
    _report(progress, planned, doublings)
    generation = [0]
    for turn in range(doublings):
        following: list[int] = []
        for parent in generation:
            for mark in _to_follow(family, planned[parent].grown, first_only=turn > 0):
                if _reached(planned, parent, mark, frame):
                    continue
                grown = _doubled_branch(family, planned, parent, mark, frame, turn)
                if grown is not None:
                    born = _value(planned[parent].grown, mark)
                    words = f"the period doubling at {parameter} = {born:.12g}"
                    planned.append(Planned(grown, parent, words, born))
                    following.append(len(planned) - 1)
        generation = following
        _report(progress, planned, doublings)
    return collect(family, (parameter,), planned, _longest_cascade(family, planned) if doublings else None)


BESIDE = 0.01
"""Part of the longest step by which a branch is started beside a special point."""

AT_SPECIAL = 1e-6
"""Distance of a multiplier from 1 or -1 at which a first orbit is taken to be a special point itself."""


def _beside(
    family: "Family", orbit: "Orbit", lap: "Lap", direction: np.ndarray, frame: Frame, weights: np.ndarray
) -> "tuple[Orbit, np.ndarray]":
    """The first orbit, or one beside it if it is a special point, so that the branch passes through that."""
    values = free_multipliers(np.linalg.eigvals(lap.monodromy), family.neutral.count)
    if not len(values) or np.minimum(np.abs(values - 1), np.abs(values + 1)).min() > AT_SPECIAL:
        return orbit, direction
    moved = family.moved(orbit, lap, BESIDE * frame.step * direction)
    code, other, seen, _ = family.solve(moved, (direction * weights**2)[np.newaxis])
    if code != branch.CONVERGED or not admissible(other, seen):
        return orbit, direction
    return other, family.direction(other, seen, weights, direction)


def _unmoved(grown: Grown) -> bool:
    """Whether nothing of an orbit changes along a branch but the parameter."""
    return all(
        (np.abs(s.directions[:, :-1]) <= NO_EFFECT * np.abs(s.directions[:, -1:])).all() for s in grown.stretches
    )


def _report(progress: Progress | None, planned: list[Planned], doublings: int) -> None:
    if progress is not None:
        progress(len(planned), max(len(planned), doublings + 1), None)


def _joined(backward: Grown, forward: Grown) -> Grown:
    """One branch of the two halves, which share their first orbit."""
    lengths = [len(s) for s in backward.stretches]
    count = len(lengths)
    marks = [
        replace(m, stretch=count - 1 - m.stretch, point=lengths[m.stretch] - 1 - m.point)
        for m in reversed(backward.marks)
    ]
    marks += [replace(m, stretch=count + m.stretch, point=m.point - int(m.stretch == 0)) for m in forward.marks]
    stretches = [s.reversed() for s in reversed(backward.stretches)]
    stretches += [forward.stretches[0].part(slice(1, None)), *forward.stretches[1:]]
    origin = float(stretches[0].arclengths[0])
    stretches = [replace(s, arclengths=s.arclengths - origin) for s in stretches]
    words = forward.words if forward.words == backward.words else f"{forward.words}; at its start: {backward.words}"
    return Grown(stretches, [*reversed(backward.ranks), *forward.ranks], marks, forward.end, words)


def _longest_cascade(family: "Family", planned: list[Planned]) -> Cascade | None:
    """The longest chain of branches, each from the doubling of the one before, with the doubling that ends it."""
    best: list[tuple[float, int]] = []
    for number in range(len(planned)):
        chain: list[tuple[float, int]] = []
        first = _to_follow(family, planned[number].grown, True) if number else []
        if first:
            chain.append(_doubling(planned[number].grown, first[0]))
        while planned[number].parent >= 0:
            parent = planned[number].parent
            born = float(planned[number].born)
            chain.append((born, planned[parent].grown.stretches[0].periods))
            number = parent
        if len(chain) > len(best):
            best = chain
    return cascade_from(*zip(*reversed(best), strict=True)) if best else None


def _doubling(grown: Grown, mark: Mark) -> tuple[float, int]:
    return _value(grown, mark), grown.stretches[mark.stretch].periods


def _value(grown: Grown, mark: Mark) -> float:
    return float(grown.stretches[mark.stretch].starts[mark.point, 0, -1])


def _to_follow(family: "Family", grown: Grown, first_only: bool) -> list[Mark]:
    """Period doublings from which doubled branches are followed: those where stability is lost, or the first one."""
    marks = [m for m in grown.marks if m.kind == Special.PERIOD_DOUBLING]
    marks.sort(key=lambda m: (m.stretch, m.point))
    if first_only:
        return marks[:1]
    return [m for m in marks if _beside_stable(family, grown, m)] or marks


def _beside_stable(family: "Family", grown: Grown, mark: Mark) -> bool:
    stretch = grown.stretches[mark.stretch]
    beside = [k for k in (mark.point - 1, mark.point + 1) if 0 <= k < len(stretch)]
    values = multipliers(family, stretch.orbit(0), stretch.monodromies[beside], grown.ranks[mark.stretch])
    return bool(is_stable(values, family.neutral.count).any())


def _reached(planned: list[Planned], parent: int, mark: Mark, frame: Frame) -> bool:
    """Whether a doubled branch that was followed from elsewhere has come to this doubling."""
    here = _value(planned[parent].grown, mark)
    ends = [
        float(one.grown.stretches[-1].starts[-1, 0, -1])
        for one in planned
        if one.parent == parent and one.grown.end == BranchEnd.DOUBLING
    ]
    return any(abs(end - here) < frame.step * frame.spans[0] for end in ends)


def _doubled_branch(
    family: "Family", planned: list[Planned], parent: int, mark: Mark, frame: Frame, turn: int
) -> Grown | None:
    grown = planned[parent].grown
    stretch = grown.stretches[mark.stretch]
    orbit = stretch.orbit(mark.point)
    here = _value(grown, mark)
    finer = frame
    scale = 1.0
    if turn > 0:
        gap = abs(here - planned[parent].born) / frame.spans[0]
        finer = replace(frame, step=min(frame.step, gap / FINER))
        scale = min(1.0, finer.step / frame.step)
    weights_of = WeightsOf(family, frame.spans)
    found = doubled(family, orbit, weights_of, scale, finer.step * float(frame.spans[0]))
    others = tuple(s for one in planned for s in one.grown.stretches)
    return None if found is None else grow(family, *found, finer, others=others)
