"""A trajectory as a curve with jumps at resets, and several that are joined, run by run."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.dataset.outcomes import flag_names
from chaosdrill.errors import ArchiveError, ChaosdrillError
from chaosdrill.plots._types import Dataset, Floats, Integers, Truths
from chaosdrill.plots.palette import PALETTE
from chaosdrill.plots.tuning import TUNING

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem

MOST_RUNS = len(PALETTE)
"""Largest number of runs that can be distinguished in one picture."""

_REMEDY = "join runs by chaosdrill.join, which says how many events belong to each"


@dataclass(frozen=True)
class Curve:
    """Samples and both sides of every event, in chronological order."""

    time: Floats  # shape (m,): Times, in the archive's own unit
    state: Floats  # shape (m, n): States; the two sides of an event are adjacent entries with the same time
    mode: Integers  # shape (m,): Mode codes

    def bands(self) -> list[tuple[float, float, int]]:
        """Return ``(start, end, mode)`` of every stretch of time spent in one mode."""
        if self.time.size == 0:
            return []
        changes = np.flatnonzero(np.diff(self.mode)) + 1
        edges = np.concatenate([[0], changes, [self.time.size - 1]])
        return [
            (float(self.time[i]), float(self.time[j]), int(self.mode[i]))
            for i, j in pairwise(edges)
            if self.time[j] > self.time[i]
        ]


def curve_of(dataset: Dataset) -> Curve:
    """Merge the samples of a ``trajectory`` dataset with the states before and after each event."""
    time = dataset["time"].values
    events = dataset["event_time"].values
    mode = dataset["mode"].values.astype(np.int64)
    # the mode on each side of an event, where the archive does not say, is that of the nearest sample on that side
    last = max(time.size - 1, 0)
    before = _event_mode(dataset, "event_mode_before", mode[np.clip(np.searchsorted(time, events) - 1, 0, last)])
    after = _event_mode(dataset, "event_mode_after", mode[np.clip(np.searchsorted(time, events, "right"), 0, last)])
    states = [dataset[name].values for name in ("states", "event_state_before", "event_state_after")]
    times = np.concatenate([time, events, events])
    # at equal times events keep their own order, each with its two sides: a sample there would be one of them again
    order = np.concatenate(
        [np.full(time.size, 2 * events.size), 2 * np.arange(events.size), 2 * np.arange(events.size) + 1]
    )
    index = np.lexsort((order, times))
    index = index[~np.isin(index, np.flatnonzero(np.isin(time, events)))]
    return Curve(times[index], np.concatenate(states)[index], np.concatenate([mode, before, after])[index])


def smoothed(curve: Curve, rates: Callable[[], Floats | None] | None = None) -> Curve:
    """Return a smooth curve where samples are so sparse that straight lines between them would be visible.

    Between two events the states are smooth: a cubic through each two samples, with the slopes of parabolas through
    three (the method of Bessel), limited so that nothing overshoots but peaks stay round (Huynh, SIAM J. Numer. Anal.
    30, 57, 1993, doi:10.1137/0730004). Samples, and the sides of events, stay where they are.

    ``rates``: it returns the time derivatives at all points, shape (m, n), or None. It is called where there are too
    few samples to estimate slopes from them.
    """
    step = np.diff(curve.time)
    # a run that ended in no number turns nowhere
    with np.errstate(invalid="ignore"):
        parts, coarse = _parts(curve, step)
    if not (parts > 1).any():
        return curve
    exact = rates() if coarse and rates is not None else None
    slopes = _slopes(curve.state, step) if exact is None else _limited(exact, curve.state, step)
    start = np.repeat(np.arange(len(parts)), parts)
    part = (np.arange(len(start)) - np.repeat(np.cumsum(parts) - parts, parts)) / parts[start]
    s, h = part[:, np.newaxis], step[start, np.newaxis]
    left, right = curve.state[start], curve.state[start + 1]
    state = left + s**2 * (3 - 2 * s) * (right - left)
    state += h * s * (1 - s) * ((1 - s) * slopes[start, 1] - s * slopes[start + 1, 0])
    return Curve(
        np.append(curve.time[start] + part * step[start], curve.time[-1:]),
        np.vstack([state, curve.state[-1:]]),
        np.append(curve.mode[start], curve.mode[-1:]),
    )


def _parts(curve: Curve, step: Floats) -> tuple[Integers, bool]:
    """Number of stretches between each two samples, by how much the line of each two states turns.

    Also whether it turns so much, and so often, that slopes cannot be estimated from the samples.
    """
    extent = np.ptp(curve.state, axis=0) if len(curve.state) else np.ones(curve.state.shape[1])
    span = float(np.ptp(curve.time)) if curve.time.size else 0.0
    across = np.column_stack([curve.time / (span or 1.0), curve.state / np.where(extent > 0, extent, 1.0)])
    moved = np.diff(across, axis=0)
    parts = np.ones(len(step), dtype=np.int64)
    smooth = (step[:-1] > 0) & (step[1:] > 0)
    coarse = 0.0
    for i in range(across.shape[1]):
        for j in range(i):
            before, after = moved[:-1, [i, j]], moved[1:, [i, j]]
            cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
            turn = np.abs(np.arctan2(cross, (before * after).sum(axis=1)))
            # what is smaller than a dot turns unseen
            seen = smooth & (np.minimum(np.hypot(*before.T), np.hypot(*after.T)) > TUNING.visible_bend)
            here = np.where(seen, np.minimum(np.ceil(turn / TUNING.turn), TUNING.most_stretches), 1).astype(np.int64)
            parts[:-1] = np.maximum(parts[:-1], here)
            parts[1:] = np.maximum(parts[1:], here)
            coarse = max(coarse, float((seen & (turn > TUNING.coarse_turn)).sum() / max(smooth.sum(), 1)))
    return np.where(step > 0, parts, 1), coarse > TUNING.coarse_share


def _limited(rates: Floats, state: Floats, step: Floats) -> Floats:
    """Slopes as in `_slopes`, from time derivatives, as far as the samples resolve them."""
    guessed = _slopes(state, step)
    h = np.where(step > 0, step, np.inf)[:, np.newaxis]
    rate = np.diff(state, axis=0) / h
    size = np.abs(rate)
    most = 3 * np.maximum(np.pad(size, ((0, 1), (0, 0))), np.pad(size, ((1, 0), (0, 0))))
    exact = np.clip(rates, -most, most)[:, np.newaxis]
    slopes = np.where(np.isfinite(exact), exact, guessed)
    # a slope that is steeper than this would turn the curve where no rate turns
    way = np.where(rate < 0, -1.0, 1.0)
    start, end = way * slopes[:-1, 1], way * slopes[1:, 0]
    slopes[:-1, 1] = way * np.minimum(start, 3 * (size + np.maximum(-end, 0)))
    slopes[1:, 0] = way * np.minimum(end, 3 * (size + np.maximum(-start, 0)))
    flat = (rate == 0) & (start < 0) & (end < 0)
    slopes[:-1, 1][flat] = slopes[1:, 0][flat] = 0.0
    return slopes


def rates_of(dataset: Dataset, curve: Curve) -> Floats | None:
    """Return the time derivatives at the points of a curve, from the equations in its dataset, if it has them."""
    from chaosdrill.codegen.record import remember
    from chaosdrill.workflow.run_scene import known_system

    # states in SI units are not those of the equations
    if "definition" not in dataset.attrs or "state_units" in dataset.variables:
        return None
    try:
        system = known_system(dataset)
        rates = _evaluated(system, flag_names(dataset["mode"]), curve)
        remember(system)
    # code of the user's, and functions that numpy does not know, have no place here
    except (ChaosdrillError, KeyError, TypeError, ValueError, NameError, AttributeError):
        return None
    return rates


def _evaluated(system: "HybridSystem", modes: Mapping[int, str], curve: Curve) -> Floats:
    from chaosdrill.codegen import formulas

    rates = np.full(curve.state.shape, np.nan)
    for code in np.unique(curve.mode).tolist():
        mode, here = modes[code], curve.mode == code
        with np.errstate(all="ignore"):
            found = formulas.rates_of(system, mode)(curve.time[here], *curve.state[here].T, *system.parameters.values())
        for i, rate in enumerate(found):
            rates[here, i] = rate
    return rates


def _slopes(state: Floats, step: Floats) -> Floats:
    """Slopes on the left and on the right of every point, shape (m, 2, n): equal except at events and ends."""
    h = np.where(step > 0, step, 1.0)[:, np.newaxis]
    rate = np.diff(state, axis=0) / h
    inner = (step[:-1] > 0) & (step[1:] > 0)
    slopes = np.empty((len(state), 2, state.shape[1]))
    slopes[1:, 0], slopes[:-1, 1] = rate, rate
    slopes[0, 0], slopes[-1, 1] = rate[0], rate[-1]
    before, after = rate[:-1], rate[1:]
    central = (h[1:] * before + h[:-1] * after) / (h[:-1] + h[1:])
    # a slope of three times the flatter side does not overshoot, nor does what the bends on both sides agree on
    bend = (after - before) / (h[:-1] + h[1:])
    left, right = (
        _lesser(bend, np.where(_joined(inner, side)[:, np.newaxis], np.roll(bend, -side, axis=0), bend))
        for side in (-1, 1)
    )
    agreed = np.abs(_lesser(before + left * h[:-1], after - right * h[1:]))
    most = np.maximum(3 * np.minimum(np.abs(before), np.abs(after)), 1.5 * agreed)
    central = np.clip(central, -most, most)
    # where the curve ends, at an event above all, the parabola through the next point goes on
    for way, own, side in ((-1, before, 1), (1, after, 0)):
        end = np.flatnonzero(inner & ~_joined(inner, way))
        most_here = 3 * np.abs(own[end])
        slopes[end + 1 + way, side] = np.clip(2 * own[end] - central[end], -most_here, most_here)
    slopes[1:-1][inner] = central[inner][:, np.newaxis]
    return slopes


def _lesser(a: Floats, b: Floats) -> Floats:
    """The number closer to zero of two, and zero where their signs differ (minmod)."""
    lesser: Floats = np.where(a * b > 0, np.where(np.abs(a) < np.abs(b), a, b), 0.0)
    return lesser


def _joined(inner: Truths, side: int) -> Truths:
    """Whether the point beside each inner point is an inner one as well."""
    return np.pad(inner, 1)[:-2] if side < 0 else np.pad(inner, 1)[2:]


def breaks(time: Floats, points: Floats) -> Integers:
    """Return the indices of the points of a curve, shape (m, k), to which a jump leads from the one before."""
    extent = np.maximum(np.ptp(points, axis=0), np.finfo(float).tiny) if len(points) else np.ones(points.shape[1])
    apart = (np.abs(np.diff(points, axis=0)) > TUNING.visible_jump * extent).any(axis=1)
    return np.flatnonzero((np.diff(time) == 0) & apart) + 1


def pieces(time: Floats, x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Return the flow and the jumps of a curve as points of two lines with gaps, shapes (k, 2) and (3 j, 2).

    The two sides of an event have the same time: between them lies a jump if it is visible, and everything else is
    flow.
    """
    points = np.column_stack([x, y])
    after = breaks(time, points)
    gap = np.full((len(after), 2), np.nan)
    jumps = np.stack([points[after - 1], points[after], gap], axis=1).reshape(-1, 2)
    return np.insert(points, after, np.nan, axis=0), jumps


def _event_mode(dataset: Dataset, name: str, otherwise: Integers) -> Integers:
    return dataset[name].values.astype(np.int64) if name in dataset.variables else otherwise


def last_parts(datasets: Sequence[Dataset], events: int) -> list[Dataset]:
    """Return the last parts of trajectories over the same times, each with at most ``events`` events.

    They start at a whole forcing period if there is one.
    """
    start = max(_start_of_last(dataset, events) for dataset in datasets)
    if start == -np.inf:
        return list(datasets)
    starts = [start - 1e-9 * max(abs(float(dataset["time"].values[-1])), 1.0) for dataset in datasets]
    return [
        dataset.isel(time=dataset["time"].values >= first, event=dataset["event_time"].values >= first)
        for dataset, first in zip(datasets, starts, strict=True)
    ]


def _start_of_last(dataset: Dataset, events: int) -> float:
    """Time from which a trajectory has this number of events; minus infinity if it has no more in total."""
    times = dataset["event_time"].values
    if times.size <= events:
        return -np.inf
    start = float(times[-events])
    if "forcing_period" in dataset.variables:
        end, period = float(dataset["time"].values[-1]), float(dataset["forcing_period"])
        start = end - max(1, np.floor((end - start) / period)) * period
    return start


def strobe(dataset: Dataset) -> Floats:
    """Return the sampled states at whole forcing periods, shape (k, n); empty for a system that is not forced."""
    state = dataset["states"].values
    if "forcing_period" not in dataset.variables:
        return state[:0]
    turns = dataset["time"].values / float(dataset["forcing_period"])
    return state[np.abs(turns - np.round(turns)) < 1e-9 * np.maximum(1.0, np.abs(turns))]


def stops(dataset: Dataset, index: int) -> list[tuple[str, float]]:
    """Return ``(event name, value)`` of the walls at which the state jumps while its entry ``index`` keeps one value.

    A wall is recognised by its events: two or more of a kind, all at one value of the entry, which they keep, and at
    least one of which visibly changes another entry.
    """
    found = []
    extent = np.ptp(dataset["states"].values, axis=0)
    before, after = dataset["event_state_before"].values, dataset["event_state_after"].values
    kinds = dataset["event_kind"].values
    for code, name in (flag_names(dataset["event_kind"]) if kinds.size else {}).items():
        hit = kinds == code
        if hit.sum() < 2:
            continue
        level = before[hit, index]
        jumps = np.any(np.abs(after[hit] - before[hit]) > TUNING.visible_jump * np.maximum(extent, 1e-300), axis=0)
        kept = not jumps[index]
        jumps[index] = False
        if kept and np.ptp(level) <= TUNING.visible_jump * extent[index] and jumps.any():
            found.append((name, float(np.mean(level))))
    return found


def is_joined(dataset: Dataset) -> bool:
    """Return whether a dataset consists of several joined trajectories."""
    return "run" in dataset.dims


def runs_of(dataset: Dataset) -> list[tuple[str, Dataset]]:
    """Return the name of each run and its trajectory with its own events, of the first ``MOST_RUNS``.

    A trajectory that is not joined counts as one run without a name.

    Raises `ArchiveError` if the dataset does not say which events belong to which run, or does not hold trajectories.
    """
    runs = [("", dataset)]
    if is_joined(dataset):
        names = dataset["run"].values if "run" in dataset.variables else range(1, dataset.sizes["run"] + 1)
        if dataset["event_time"].dims == ("run", "event"):
            # put side by side by xarray, with the events of each in a row
            runs = [(str(name), _own(dataset.isel(run=i))) for i, name in enumerate(names[:MOST_RUNS])]
        else:
            ends = np.cumsum(_counts(dataset))
            starts = [0, *ends[:-1]]
            runs = [
                (str(name), dataset.isel(run=i, event=slice(starts[i], ends[i])).drop_vars("event_count"))
                for i, name in enumerate(names[:MOST_RUNS])
            ]
    for name, dims in {"states": ("time", "state"), "mode": ("time",), "event_time": ("event",)}.items():
        if runs[0][1][name].dims != dims:
            received = ", ".join(map(str, dataset[name].dims))
            raise ArchiveError(f"{name} has the dimensions {received}; a trajectory has {', '.join(dims)}: {_REMEDY}")
    return runs


def _own(run: Dataset) -> Dataset:
    """One of several runs, without its padding."""
    return run.isel(
        time=np.isfinite(run["states"].values).any(axis=1) & np.isfinite(run["mode"].values),
        event=np.isfinite(run["event_time"].values),
    )


def runs_left_out(dataset: Dataset) -> str:
    """Return a note on the runs that a picture does not show; empty if it shows all."""
    count = dataset.sizes.get("run", 1)
    return f"first {MOST_RUNS} of {count} runs" if count > MOST_RUNS else ""


def _counts(dataset: Dataset) -> np.ndarray:
    if "event_count" not in dataset.variables or dataset["event_count"].dims != ("run",):
        raise ArchiveError(f"the dataset has several runs and no variable event_count (run): {_REMEDY}")
    counts = dataset["event_count"].values
    events = dataset.sizes.get("event", 0)
    if counts.dtype.kind not in "iu" or (counts < 0).any() or counts.sum() != events:
        raise ArchiveError(f"event_count is {counts.tolist()}, of {events} events in all: {_REMEDY}")
    return np.asarray(counts, dtype=np.int64)
