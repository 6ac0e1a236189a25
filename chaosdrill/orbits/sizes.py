"""Sizes of states: their largest values on a motion, and of those that stay zero there how far beside it they go before
the motion departs from linear.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from chaosdrill.dataset import Outcome
from chaosdrill.engine import layout
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run
from chaosdrill.engine.scales import SMALLEST
from chaosdrill.engine.structure import sizes_of
from chaosdrill.model import HybridSystem
from chaosdrill.orbits.place import Place, events_until_escape
from chaosdrill.orbits.tuning import TUNING


@dataclass(frozen=True)
class _Path:
    """A motion over some units of time."""

    outcome: Outcome  # what ended it
    states: np.ndarray  # (k, d): at its start and after each part of a unit
    maps: np.ndarray  # (k, d, d): tangent maps from its start to there, or none
    kinds: np.ndarray  # int (E,): transitions taken, without those that change nothing


def sizes_met(system: HybridSystem, numerics: Numerics, unit: float | None) -> np.ndarray:
    """Largest value of every state on the motion from the system's own start, shape (d,): its unit, so to speak.

    Of one that escapes, at its events or at its start: how far it gets after that says nothing. A state that rounding
    alone moves has the size that it has between events in one instant, or that changes of the others by theirs would
    give it; one that nothing moves, that to which the response beside the motion is linear; 1 if it is so everywhere.

    ``unit``: a period of the forcing, or a characteristic time.
    """
    d, parts, length = len(system.state_names), TUNING.characteristic_samples, unit or TUNING.unit
    run = Run(system, length, numerics, samples=parts)
    path = np.zeros((2 + TUNING.sized_units * parts, d + len(system.quadratures) + 1))
    path[-1, :d] = run.x
    if run.advance(TUNING.sized_units, path[:-1])[0] in (Outcome.ESCAPED, Outcome.NONFINITE):
        path = path[-1:]
    if not system.forced:
        events = events_until_escape(Place(system), numerics, length)
        if len(events) > 1:
            path = np.concatenate([events[:, layout.EVENT_COLUMNS :].reshape(-1, d), path[-1:, :d]])
    largest = np.abs(path[:, :d]).max(axis=0)
    found = np.where(np.isfinite(largest), largest, 0.0)
    for given in _given(system, numerics, found, length):
        found = np.where(found > TUNING.rounded * given, found, given)
    # what is smaller has decayed to nothing
    found = sizes_beside(system, numerics, np.where(found > SMALLEST, found, 0.0), unit)
    return np.where(found > SMALLEST, found, 1.0)


def _given(system: HybridSystem, numerics: Numerics, sizes: np.ndarray, unit: float) -> Iterator[np.ndarray]:
    """Largest values at events, and what changes of other states by their sizes give a state in some units."""
    d = len(sizes)
    run = Place(system).run(unit, numerics, tangents=np.eye(d), orthonormalise=False)
    events = np.zeros((TUNING.most_events, layout.EVENT_COLUMNS + 2 * d))
    moves = np.zeros((d, d))
    for _ in range(TUNING.sized_units):
        outcome, full = run.advance(1, events=events)
        if outcome != Outcome.OK or full:
            break
        met = np.abs(events[: run.filled()[1], layout.EVENT_COLUMNS :]).reshape(-1, d)
        sizes = np.maximum(sizes, met.max(axis=0, initial=0.0))
        grown = np.abs(run.vectors.T)
        # beside an unstable motion all deviations grow, and tell no size
        moves = np.maximum(moves, grown / max(1.0, np.diagonal(grown).max()))
    yield sizes
    yield np.nan_to_num((np.where(np.eye(d, dtype=bool), 0.0, moves) * sizes).max(axis=1), posinf=0.0)


def sizes_beside(system: HybridSystem, numerics: Numerics, known: np.ndarray, unit: float | None = None) -> np.ndarray:
    """Sizes of the states that stay zero on the motion from the system's own start, shape (d,), and the known ones.

    Each such state is displaced at the start, farther and farther, until the motion departs from the linear response:
    another event comes, or the state is off by a part of its largest linear response, or another one by that part of
    its size. Its size is its largest value just before. So it has the unit of the nonlinearity, or is the distance of a
    border, in whatever units the system is written.

    ``known``, shape (d,): sizes of the states; 0 where unknown. ``unit``: a period of the forcing, or a characteristic
    time; by default a turn of the fastest linear motion.

    Returns, shape (d,): the known ones as they were. A state beside which all is linear is as large as displacements of
    others make it; 0 where none moves it.
    """
    if known.all():
        return known
    unit = unit or math.tau * sizes_of(system)[1]
    base = _path(system, unit, numerics, tangents=True)
    found, moved = known.copy(), np.zeros_like(known)
    for i in np.flatnonzero(known == 0).tolist():
        for side in (-1.0, 1.0):
            last = _last_linear(system, unit, numerics, base, known, i, side)
            if last is not None:
                largest = np.abs(last.states).max(axis=0)
                found[i] = min(found[i] or np.inf, largest[i])
                moved = np.fmax(moved, largest)
    return np.where(found > 0, found, moved)


def _last_linear(
    system: HybridSystem, unit: float, numerics: Numerics, base: _Path, known: np.ndarray, i: int, side: float
) -> _Path | None:
    """The farthest motion on one side of the base whose response is linear; None if all are or none is."""
    name, paths = system.state_names[i], {}

    def linear(power: float) -> bool:
        shift = side * 2.0**power
        paths[power] = there = _path(system.with_initial(**{name: shift}), unit, numerics)
        return _is_linear(base, there, known, i, shift)

    low, high = _bracket(linear)
    if low is None:
        return None
    while high - low > TUNING.range_precision:
        middle = (low + high) / 2
        low, high = (middle, high) if linear(middle) else (low, middle)
    # a bound of a state, where the motion is linear up to it, tells nothing of its size
    return paths[low] if paths[high].outcome == Outcome.OK else None


def _bracket(linear: Callable[[float], bool]) -> tuple[float | None, float]:
    """Powers of two between which a response that was linear no longer is.

    It need not be linear at first: there the displacement may be below the rounding of other states. Where no usual one
    shows the end of the linear response, but one of the ends of all that there are does, those beyond are tried.
    """
    least, first, last, most = TUNING.range_powers
    low, high = _scan(linear, first, last)
    if high is None and low is not None and not linear(most):
        low, high = _scan(linear, low, most)
    elif low is None and linear(least):
        low, high = _scan(linear, least, first)
    return (None, last) if low is None or high is None else (low, high)


def _scan(linear: Callable[[float], bool], power: float, last: float) -> tuple[float | None, float | None]:
    """The last power at which a response is linear, from one power up to another, and the next, at which it is not."""
    low = None
    while power <= last:
        if linear(power):
            low = power
        elif low is not None:
            return low, power
        power += TUNING.range_stride
    return low, None


def _is_linear(base: _Path, there: _Path, known: np.ndarray, i: int, shift: float) -> bool:
    """Whether a motion answers to a shift of state i at the start of another one as to a small one."""
    if there.outcome != Outcome.OK and there.outcome != base.outcome:
        return False
    # events may come sooner or later, and so be counted or not
    least = min(len(base.kinds), len(there.kinds))
    if abs(len(base.kinds) - len(there.kinds)) > 1 or (base.kinds[:least] != there.kinds[:least]).any():
        return False
    count = min(len(base.states), len(there.states))
    response = shift * base.maps[:count, :, i]
    off = np.abs(there.states[:count] - base.states[:count] - response).max(axis=0, initial=0.0)
    scale = np.maximum(known, np.abs(response).max(axis=0, initial=0.0))
    counts = known > 0
    counts[i] = True
    return bool((off <= TUNING.off_linear * scale)[counts].all())


def _path(system: HybridSystem, unit: float, numerics: Numerics, tangents: bool = False) -> _Path:
    """The motion from the system's own start over ``TUNING.sized_units`` units, seen at parts of them."""
    d, parts = len(system.state_names), TUNING.characteristic_samples
    run = Run(system, unit / parts, numerics, tangents=np.eye(d) if tangents else None, orthonormalise=False)
    events = np.zeros((TUNING.most_events, layout.EVENT_COLUMNS + 2 * d))
    states, maps, kinds, outcome = [run.x.copy()], [run.vectors.T.copy()], [], Outcome.OK
    for k in range(TUNING.sized_units * parts):
        if system.forced:
            # the clock of the field would begin anew with every part
            run.begin_at(k % parts * run.period)
        outcome, full = run.advance(1, events=events)
        kinds += events[: run.filled()[1], layout.EVENT_KIND].astype(int).tolist()
        if outcome != Outcome.OK or full:
            break
        states.append(run.x.copy())
        maps.append(run.vectors.T.copy())
    taken = [k for k in kinds if not system.transitions[k].marks_only()]
    return _Path(outcome, np.array(states), np.array(maps), np.array(taken, dtype=int))
