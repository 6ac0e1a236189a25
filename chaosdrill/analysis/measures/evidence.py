"""Evidence of regular motion and chaos from the section points of one run: the 0-1 test, smooth averages, rotation."""

from typing import Any

import numpy as np

from chaosdrill.analysis.judgement.recurrence import CLOSE, sizes
from chaosdrill.analysis.judgement.statistics import fading
from chaosdrill.analysis.judgement.tori import (
    TURNS,
    halves_apart,
    median,
    smooth_means,
    turns,
    zero_one,
    zero_one_by_turn,
)
from chaosdrill.analysis.measures.records import Arrays, Measure
from chaosdrill.analysis.measures.section_points import Taken
from chaosdrill.dataset import Outcome
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.shifts import shifts_of

FEWEST = 40
"""Points without which the 0-1 test has no steps to compare, nor a smooth average a course."""

PARTS = 4
"""Parts of a record that are compared with each other."""

OF_PARTS = 0.6
"""Width of a gap in all steps, of the widest in a part of the record, below which more steps would close it."""

HALF_TURN = 0.5
"""Error from which on a rotation number, which is known but for whole turns, may be any."""

MEDIAN = 1.2533 / 1.349 / np.sqrt(TURNS)
"""Standard error of a median, as a part of the distance of the quartiles, if the values were independent and normal."""

SHORT = 20
"""Steps over which displacements are compared, a tenth of the points, below which K tells nothing: in so few a cycle or
a torus has not gone round, and K is near 1 as in chaos, on average 0.8 for 64 points and 0.45 for 160."""

MOST_DIGITS = 16.0
"""More than these no double has."""

OF_SIZES = np.pi / np.sqrt(8) / np.log(10)
"""Standard deviation of the digits of a normal quantity of mean zero, that is of the logarithm of its size."""


def _zero_one(taken: Taken, given: Any, numerics: Numerics) -> Arrays:
    """The 0-1 test of each state; see `zero_one_test`."""
    n = taken.states.shape[1]
    k, error = np.full((2, n), np.nan)
    by_turn = np.full((n, TURNS), np.nan)
    for i in _moving(taken):
        k[i], error[i], by_turn[i] = growth(taken.states[:, i])
    return {"k": k, "k_error": error, "k_by_turn": by_turn, "reason": _too_few(taken)}


def growth(values: np.ndarray) -> tuple[float, float, np.ndarray]:
    """Growth K of a sequence of values, its error, and K for each of the turning phases, shape (TURNS,)."""
    by_turn = zero_one_by_turn(values)
    quarter, three = np.quantile(by_turn, [0.25, 0.75])
    between = np.std(zero_one(_parts(values)), ddof=1) / np.sqrt(PARTS)
    too_few = np.exp(-((len(values) / 10 / SHORT) ** 2))
    return float(median(by_turn)), float(np.linalg.norm([MEDIAN * (three - quarter), between, too_few])), by_turn


def _regularity(taken: Taken, given: Any, numerics: Numerics) -> Arrays:
    """Smooth averages, their digits, and the rotation number; see `regularity`."""
    average, average_error, digits, digits_error = np.full((4, taken.states.shape[1]), np.nan)
    moving = _moving(taken)
    if moving:
        values, known = taken.states[:, moving].T, taken.run.sizes[moving]
        average[moving], apart, error = smooth_means(values, known)
        digits[moving] = _digits(apart, values)
        of_parts = _parts(values)
        apart_in_parts = np.stack([halves_apart(part[..., np.newaxis])[:, 0] for part in of_parts.swapaxes(0, 1)])
        digits_error[moving] = np.maximum(np.std(_digits(apart_in_parts, values), axis=0, ddof=1), OF_SIZES)
        average_error[moving] = np.hypot(error, numerics.global_error * np.abs(values).max(axis=1))
    turned = turned_error = np.nan
    uncounted = "nothing moves on the section, so that nothing turns" if taken.outcome == Outcome.OK else ""
    if moving:
        steps, uncounted = _steps(taken, given.plane, moving)
        if not uncounted:
            (mean,), _, (error,) = smooth_means(steps[np.newaxis], np.ones(1))
            if error < HALF_TURN:
                turned, turned_error = mean % 1, np.hypot(error, numerics.global_error)
            else:
                uncounted = f"turns from point to point are known to {error:.2g} on average, not to a part of one"
    return {
        "average": average,
        "average_error": average_error,
        "digits": digits,
        "digits_error": digits_error,
        "rotation_number": np.float64(turned),
        "rotation_number_error": np.float64(turned_error),
        "reason": _too_few(taken) or uncounted,
    }


ZERO_ONE = Measure(
    _zero_one,
    {"k": ("state",), "k_error": ("state",), "k_by_turn": ("state", "turn")},
    {"turn": TURNS},
    {"turn_angle": ("turn", turns())},
)
REGULARITY = Measure(
    _regularity,
    dict.fromkeys(("average", "average_error", "digits", "digits_error"), ("state",))
    | dict.fromkeys(("rotation_number", "rotation_number_error"), ()),
    {},
    {},
)


def _parts(values: np.ndarray) -> np.ndarray:
    """Sequences, shape (..., N), in parts of equal length, shape (..., PARTS, N // PARTS)."""
    length = values.shape[-1] // PARTS
    return values[..., : PARTS * length].reshape(*values.shape[:-1], PARTS, length)


def _digits(apart: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Digits to which averages agree that are so far apart, in parts of the extent of sequences, shape (S, N)."""
    return np.asarray(-np.log10(np.maximum(apart / np.ptp(values, axis=1), 10.0**-MOST_DIGITS)))


def _moving(taken: Taken) -> list[int]:
    """States that have more than one value on the section; none of a run that ended early or has few points."""
    states = taken.states
    if taken.outcome != Outcome.OK or len(states) < FEWEST:
        return []
    floor = sizes(states[np.newaxis], taken.run.sizes[np.newaxis])[0]
    return np.flatnonzero(np.ptp(states, axis=0) > CLOSE * floor).tolist()


def _too_few(taken: Taken) -> str:
    """Why a record that reached its end says nothing; empty if it does."""
    count = len(taken.states)
    if taken.outcome != Outcome.OK or count >= FEWEST:
        return ""
    return f"{count} points say nothing: record {FEWEST} at least"


def _steps(taken: Taken, names: list[str] | None, moving: list[int]) -> tuple[np.ndarray, str]:
    """Turns from point to point, and why they are not counted, if they are not."""
    states, system, none = taken.states, taken.run.system, np.zeros(0)
    rounds = _angles(taken)
    if names is None and rounds:
        (first, one), *others = rounds.items()
        if apart := [name for name, other in others if np.ptp(other - one) > 1]:
            return none, f"{' and '.join([first, *apart])} go round apart: name one of them, as in plane=[{first!r}]"
        return np.diff(one), ""
    if names is not None and (named := [name for name in names if name in rounds]):
        if len(names) > 1:
            return none, f"{named[0]} goes round by itself, in no plane: name it alone, as in plane=[{named[0]!r}]"
        return np.diff(rounds[names[0]]), ""
    places = moving[:2] if names is None else [system.state_names.index(name) for name in names]
    if still := [system.state_names[i] for i in places if i not in moving]:
        return none, f"nothing turns in the plane: {' and '.join(still)} did not move on the section"
    points = states[:, places]
    if len(places) == 1:
        points = np.column_stack([points[:-1], points[1:]])
    if len(points) < FEWEST:
        return none, f"{len(points)} pairs of a state and its next value say nothing: record one point more"
    return _counted(points)


def _angles(taken: Taken) -> dict[str, np.ndarray]:
    """Turns that angles have made, of those that go round."""
    states, names = taken.states, taken.run.system.state_names
    turned = {
        names[i]: states[:, i] / abs(turn[i])
        for turn in shifts_of(taken.run.system, but_of=()).turns
        for i in np.flatnonzero(turn).tolist()
    }
    return {name: turns for name, turns in turned.items() if np.ptp(turns) > 1}


def _counted(points: np.ndarray) -> tuple[np.ndarray, str]:
    """Turns about the centre from point to point, shape (N, 2), and why they are not counted, if they are not.

    What a step turns is known but for whole turns; they are counted from the widest gap that the steps leave. If all
    steps make it much narrower than those of a part of the record, they fill the turn, and there is no such gap.
    """
    centre = np.einsum("w,wi->i", fading(len(points)), points[1:])
    scaled = (points - centre) / np.ptp(points, axis=0)
    step = np.diff(np.arctan2(scaled[:, 1], scaled[:, 0]) / (2 * np.pi)) % 1
    ordered, gaps = _gaps(step)
    if gaps.max() < OF_PARTS * max(_gaps(part)[1].max() for part in _parts(step)):
        return step, "the points do not turn about their centre so that turns can be counted"
    begin = ordered[(int(gaps.argmax()) + 1) % len(ordered)]
    return begin + (step - begin) % 1, ""


def _gaps(step: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Parts of a turn in order, and the gap behind each."""
    ordered = np.sort(step)
    return ordered, np.diff(ordered, append=ordered[0] + 1)
