"""Evidence of regular motion and chaos from the section points of one run: the 0-1 test, smooth averages, rotation."""

from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from chaosdrill.analysis.recurrence import CLOSE, sizes
from chaosdrill.analysis.sections import Taken, section_points
from chaosdrill.analysis.tori import TURNS, fading, median, turns, zero_one, zero_one_by_turn
from chaosdrill.dataset import Outcome
from chaosdrill.model import HybridSystem

if TYPE_CHECKING:
    from chaosdrill.analysis.base import Job

FEWEST = 40
"""Points without which the 0-1 test has no steps to compare, nor a smooth average a course."""

PARTS = 4
"""Parts of a record whose K are compared with each other."""

MEDIAN = 1.2533 / 1.349 / np.sqrt(TURNS)
"""Standard error of a median, as a part of the distance of the quartiles, if the values were independent and normal."""

MOST_DIGITS = 16.0
"""More than these no double has."""


def zero_one_dataset(system: HybridSystem, given: Any, job: "Job") -> xr.Dataset:
    """The 0-1 test of each state; see `zero_one_test`."""
    taken = section_points(system, given, given.max_period, job)
    growth, error = np.full((2, len(system.states)), np.nan)
    by_turn = np.full((len(system.states), TURNS), np.nan)
    for i in _moving(taken):
        values = taken.states[:, i]
        by_turn[i] = zero_one_by_turn(values)
        growth[i] = median(by_turn[i])
        parts = [zero_one(part) for part in np.array_split(values, PARTS)]
        quarter, three = np.quantile(by_turn[i], [0.25, 0.75])
        error[i] = np.hypot(MEDIAN * (three - quarter), np.std(parts, ddof=1) / np.sqrt(PARTS))
    variables = {"k": ("state", growth), "k_error": ("state", error), "k_by_turn": (("state", "turn"), by_turn)}
    return _dataset(taken, variables).assign_coords(turn_angle=("turn", turns()))


def regularity_dataset(system: HybridSystem, given: Any, job: "Job") -> xr.Dataset:
    """Smooth averages, their digits, and the rotation number; see `regularity`."""
    taken = section_points(system, given, given.max_period, job)
    n = len(system.states)
    average, error, digits = np.full((3, n), np.nan)
    for i in _moving(taken):
        values = taken.states[:, i]
        average[i], apart = _smooth(values)
        size = np.abs(values).max()
        digits[i] = min(-np.log10(max(apart / np.ptp(values), 10.0**-MOST_DIGITS)), MOST_DIGITS)
        error[i] = np.hypot(apart, job.numerics.global_error * size)
    turned, turned_error = _rotation(_plane(taken, given.plane), job.numerics.global_error)
    variables = {
        "average": ("state", average),
        "average_error": ("state", error),
        "digits": ("state", digits),
        "rotation_number": ((), turned),
        "rotation_number_error": ((), turned_error),
    }
    return _dataset(taken, variables)


def _dataset(taken: Taken, variables: dict[str, Any]) -> xr.Dataset:
    """The variables, with what every record of section points has."""
    outcome = Outcome.PERIODIC if taken.period else taken.outcome
    message = taken.run.stopped(taken.outcome)
    return xr.Dataset(
        {**variables, "period": ((), np.int32(taken.period)), "outcome": ((), np.int8(outcome))},
        coords={"state": list(taken.run.system.state_names)},
        attrs={"message": message} if message else {},
    )


def _moving(taken: Taken) -> list[int]:
    """States that have more than one value on the section; none of a run that ended early or has few points."""
    states = taken.states
    if taken.outcome != Outcome.OK or len(states) < FEWEST:
        return []
    floor = sizes(states[np.newaxis], taken.run.sizes[np.newaxis])[0]
    return np.flatnonzero(np.ptp(states, axis=0) > CLOSE * floor).tolist()


def _smooth(values: np.ndarray) -> tuple[float, float]:
    """Average that fades in and out over all values, and how far those over both halves are apart."""
    half = len(values) // 2
    early, late = (float(fading(half) @ values[k + 1 : k + half]) for k in (0, half))
    return float(fading(len(values)) @ values[1:]), abs(late - early)


def _plane(taken: Taken, names: list[str] | None) -> np.ndarray:
    """Points in the plane in which they turn, shape (N, 2), or (0, 2) if nothing does.

    It is that of two states; where only one moves, of it and its next value.
    """
    moving = _moving(taken)
    if names is not None:
        moving = [i for i in map(taken.run.system.state_names.index, names) if i in moving]
    chosen = taken.states[:, moving[:2]]
    if chosen.shape[1] == 1:
        chosen = np.column_stack([chosen[:-1], chosen[1:]])
    return chosen if chosen.shape[1] else np.zeros((0, 2))


def _rotation(points: np.ndarray, rounding: float) -> tuple[float, float]:
    """Turns about the centre from point to point on average, 0 to 1, and their error; NaN without points.

    What a step turns is known but for whole turns; they are counted from the widest gap that the steps leave.
    """
    if len(points) < FEWEST:
        return np.nan, np.nan
    centre = np.array([_smooth(one)[0] for one in points.T])
    scaled = (points - centre) / np.ptp(points, axis=0)
    angle = np.arctan2(scaled[:, 1], scaled[:, 0]) / (2 * np.pi)
    step = np.diff(angle) % 1
    ordered = np.sort(step)
    gaps = np.diff(ordered, append=ordered[0] + 1)
    begin = ordered[(int(gaps.argmax()) + 1) % len(ordered)]
    mean, apart = _smooth((step - begin) % 1)
    return float((mean + begin) % 1), float(np.hypot(apart, rounding))
