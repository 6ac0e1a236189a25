"""Dimensions of section points: how sums over pairs of points grow with the distance, and where they do so evenly.

Distances are the largest over the states, each in units of its standard deviation, so that the units of states do not
matter: dimensions are those of the set in any smooth coordinates.
"""

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.lib.stride_tricks import sliding_window_view

from chaosdrill.analysis.judgement.recurrence import CLOSE, sizes
from chaosdrill.analysis.judgement.statistics import in_blocks, standard_error
from chaosdrill.analysis.measures.neighbours import SCALES, Counted, Shares, neighbours, shares
from chaosdrill.analysis.measures.records import Measure, over_records
from chaosdrill.analysis.measures.section_points import Taken, phases_of
from chaosdrill.analysis.tuning import SCALING, WINDOWS
from chaosdrill.dataset import Outcome
from chaosdrill.engine.numerics import Numerics
from chaosdrill.errors import SettingsError
from chaosdrill.model import HybridSystem

if TYPE_CHECKING:
    from chaosdrill.analysis.base import Job

STEP = float(np.log(2.0)) / 2
"""Logarithm of the ratio of neighbouring distances."""


FEWEST = 500
"""Points without which no region is looked for."""


OF_SLOPE = float(np.sqrt(1.2))
"""Error of a least-squares slope over that of a mean of local slopes, if these are independent."""


class Sums(NamedTuple):
    """Logarithms of a sum that grows as the distance to the power of a dimension."""

    values: np.ndarray  # (S,): at each distance; NaN where nothing was counted
    blocks: np.ndarray  # (B, S): what parts of the record add to them
    itself: np.ndarray  # (S,): what they would gain if a point were its own neighbour, if that were no less right
    sound: np.ndarray  # (S,): whether a scaling region may reach there
    pairs: np.ndarray  # (2, S): variance by which pairs are so near by chance, and how much of that is in the blocks


class Region(NamedTuple):
    """A dimension and the distances over which it was found, as places of `SCALES`."""

    dimension: float
    error: float
    low: int
    high: int


def dimensions_of(system: HybridSystem, given: Any, job: "Job") -> xr.Dataset:
    """Dimensions of the section points of a run, or of one at every value of a parameter; see `dimensions`."""
    orders = np.array(given.orders, dtype=np.int32)
    measure = Measure(
        _of_record,
        dict.fromkeys(("dimension", "dimension_error", "scale_low", "scale_high"), ("order",))
        | dict.fromkeys(("correlation_sum", "local_slope", "local_slope_error"), ("order", "scale"))
        | {"spread": ("state",)},
        {"order": len(orders), "scale": len(SCALES)},
        {"order": orders, "scale": SCALES},
        forcing=True,
    )
    return over_records(system, given, job, measure)


def _of_record(taken: Taken, given: Any, numerics: Numerics) -> dict[str, Any]:
    """Dimensions of the points of one record, and why some have none."""
    count, orders = len(taken.states), np.array(given.orders, dtype=np.int32)
    outcome, reasons = taken.outcome, []
    shape = (len(orders), len(SCALES))
    sums, slope, slope_error = np.full((3, *shape), np.nan)
    dimension, error, low, high = np.full((4, len(orders)), np.nan)
    spread = np.zeros(taken.states.shape[1])
    if outcome == Outcome.OK and taken.period:
        outcome, dimension, error = Outcome.PERIODIC, np.zeros(len(orders)), np.zeros(len(orders))
    elif outcome == Outcome.OK and count < FEWEST:
        outcome = Outcome.UNDECIDED
        reasons = [f"{count} points are too few for a dimension: record {FEWEST} at least, better several thousand"]
    elif outcome == Outcome.OK and given.window > count / 10:
        words = (
            f"window is {given.window}; pairs of points so near in time are left out of a record of {count}, which "
            "must have ten times as many points: take a longer record or a shorter window"
        )
        if given.sweep is None:
            raise SettingsError(words)
        outcome, reasons = Outcome.UNDECIDED, [words]
    elif outcome == Outcome.OK:
        points, spread = in_spreads(taken)
        for place, (order, of_order) in enumerate(zip(orders, sums_of(points, given.window, orders), strict=True)):
            sums[place] = np.exp(of_order.values)
            slope[place, :-1], slope_error[place, :-1] = local_slopes(of_order)
            found = scaling_region(of_order)
            if found is None:
                reasons.append(f"order {order}: {refusal(of_order)}")
                continue
            dimension[place], error[place] = found.dimension, found.error
            low[place], high[place] = SCALES[found.low], SCALES[found.high]
        if np.isnan(dimension).all():
            outcome = Outcome.UNDECIDED
    return {
        "dimension": dimension,
        "dimension_error": error,
        "scale_low": low,
        "scale_high": high,
        "correlation_sum": sums,
        "local_slope": slope,
        "local_slope_error": slope_error,
        "spread": spread,
        "outcome": np.int8(outcome),
        "reason": "; ".join(reasons),
    }


def in_spreads(taken: Taken) -> tuple[np.ndarray, np.ndarray]:
    """Points in units of the states' standard deviations, shape (N, d), and these, shape (n,), 0 of what rests.

    The phase of the forcing is a coordinate too where `phases_of` says so.
    """
    columns = np.ascontiguousarray(taken.states.T)
    floor = sizes(columns.T[np.newaxis], taken.run.sizes[np.newaxis])[0]
    spread = np.where(np.ptp(columns, axis=1) > CLOSE * floor, columns.std(axis=1), 0.0)
    moving = spread > 0
    points = (columns[moving].T - columns[moving].mean(axis=1)) / spread[moving]
    return np.column_stack([points, phases_of(taken.where, taken.times / taken.run.period)]), spread


def sums_of(points: np.ndarray, window: int, orders: np.ndarray) -> list[Sums]:
    """The sums of some orders, each of which tells the dimension of its order."""
    counted = neighbours(points, window)
    return [
        information_sums(shares(points, window), counted[0])
        if order == 1
        else joined([correlation_sums(one, order) for one in counted])
        for order in orders.tolist()
    ]


def correlation_sums(counted: Counted, order: int) -> Sums:
    """Logarithms of the correlation sum of an order from 2 on.

    The sum of order q is the mean of the (q - 1)-th power of the share of points near a point, to the power 1/(q - 1)
    (Grassberger 1983, doi:10.1016/0375-9601(83)90753-3); powers are counted as tuples of different points. A point adds
    to it as a centre, and q - 1 times as much as a neighbour. How many neighbours it has by chance is no property of
    the point, though, but of pairs, and adds to the error once for each.
    """
    power, (places, counts, possible) = order - 1, counted
    tuples = np.ones_like(counts)
    for less in range(power):
        tuples *= np.maximum(counts - less, 0.0) / (possible[:, np.newaxis] - less)
    mean = tuples.mean(axis=0)
    told = mean > 0
    blocks = (in_blocks(tuples, SCALING.blocks)[:, told] / mean[told] - 1) * (order / power)
    # at the least, where all centres have as many neighbours; those among centres are counted from both sides
    of_pairs = 1 / (len(counts) * counted.near()[told])
    pairs = np.array([1 + min(len(counts) / possible.mean(), 1.0), order**2])[:, np.newaxis] * of_pairs
    itself = np.log1p(1 / counted.near()[told]) if counted.regular() else np.zeros(told.sum())
    parts = np.log(mean[told]) / power, blocks, itself, counted.sound()[told], pairs
    whole = Sums(
        np.full(len(SCALES), np.nan),
        np.full((len(blocks), len(SCALES)), np.nan),
        np.zeros(len(SCALES)),
        np.zeros(len(SCALES), dtype=bool),
        np.zeros((2, len(SCALES))),
    )
    for part, found in zip(parts, whole, strict=True):
        found[..., places[told]] = part
    return whole


def joined(parts: list[Sums]) -> Sums:
    """Sums of which each goes on at a distance where the one before ends, moved so that they meet there."""
    whole = parts[0]
    for part in parts[1:]:
        both = np.flatnonzero(np.isfinite(part.values) & np.isfinite(whole.values))
        if len(both):
            here, beyond = both[0], np.isfinite(part.values) & ~np.isfinite(whole.values)
            moved = [
                new + (old[..., here] - new[..., here])[..., np.newaxis]
                for old, new in zip(whole[:3], part[:3], strict=True)
            ]
            # beyond, neighbours are so many that those of a pair add nothing
            found = (*moved, part.sound, whole.pairs[:, here, np.newaxis])
            whole = Sums(*(np.where(beyond, new, old) for old, new in zip(whole, found, strict=True)))
    return whole


def information_sums(found: Shares, counted: Counted) -> Sums:
    """Logarithms of the share of points whose neighbours are within a distance in the geometric mean: order 1.

    Shares are known at the mean logarithm of the distances within which they are found (Badii and Politi 1985,
    doi:10.1007/BF01009897). A point adds to that as a centre alone.
    """
    # of points that are met again exactly the first neighbours are at the distance 0
    found = Shares(*(part[..., np.isfinite(found.logs).all(axis=0)] for part in found))
    logs, at = found.logs.mean(axis=0), np.log(SCALES)
    none, no_pairs = np.full(len(SCALES), np.nan), np.zeros((2, len(SCALES)))
    if len(logs) < 2 or not (np.diff(logs) > 0).all():
        return Sums(none, np.full((1, len(SCALES)), np.nan), none, np.zeros(len(SCALES), dtype=bool), no_pairs)
    inside = (at >= logs[0]) & (at <= logs[-1])
    slope = np.interp(at, logs, np.gradient(found.parts, logs))
    off = in_blocks(logs - found.logs, SCALING.blocks)
    blocks = np.array([np.interp(at, logs, one) for one in off]) * slope
    blocks[:, ~inside] = np.nan
    itself = np.interp(at, logs, np.log1p(1 / found.neighbours)) if counted.regular() else np.zeros(len(at))
    return Sums(np.where(inside, np.interp(at, logs, found.parts), np.nan), blocks, itself, inside, no_pairs)


def local_slopes(sums: Sums) -> tuple[np.ndarray, np.ndarray]:
    """Slopes from every distance to the next one, and their errors by chance, shape (S - 1,)."""
    return np.diff(sums.values) / STEP, standard_error(np.diff(sums.blocks, axis=1) / STEP)


def scaling_region(sums: Sums) -> Region | None:
    """The dimension over the distances that determine it best; None where too few are of use.

    A range of distances counts if the number of neighbours grows over each half of it, wherever that begins: between
    clusters of points it rests, whatever their dimension. Points that are met again exactly, with no others beside
    them, are a finite set, of dimension 0.
    """
    if sums.sound[0] and not np.diff(sums.values[: SCALING.shortest + 1]).any():
        return Region(0.0, 0.0, 0, SCALING.shortest)
    return even_region(sums, SCALING.shortest, SCALING.growth)


def even_region(sums: Sums, shortest: int, growth: float = -np.inf) -> Region | None:
    """The slope over the distances that determine it best; None where too few are of use.

    Over every range of distances with enough pairs, over each half of which the logarithms have that growth, the slope
    is the least-squares one. Its error joins the one by chance, from blocks of the record; the one by which local
    slopes scatter and drift over the range, by `standard_error`; how far the slope over the finer half of the range is
    off; and, on a torus, what counting a point itself would change. Of all ranges whose errors are near the least one
    the longest is taken, and its error joins how far the slopes over all other ranges are off, weighted by one over
    their squared errors.
    """
    places = np.flatnonzero(sums.sound)
    if not len(places) or places[-1] - places[0] < shortest:
        return None
    sums = Sums(*(part[..., places[0] : places[-1] + 1] for part in sums))
    count = len(sums.values)
    ranges = [(low, high) for low in range(count) for high in range(low + shortest, count)]
    ranges = [(low, high) for low, high in ranges if _least_growth(sums.values[low : high + 1]) >= growth]
    if not ranges:
        return None
    low, high = np.array(ranges).T
    dimension, error = _fitted(sums, low, high)
    near = np.flatnonzero(error <= SCALING.nearly * error.min())
    best = near[np.lexsort((error[near], (low - high)[near]))[0]]
    elsewhere = np.average((dimension - dimension[best]) ** 2, weights=error**-2)
    whole = float(np.sqrt(error[best] ** 2 + elsewhere))
    return Region(float(dimension[best]), whole, int(places[0] + low[best]), int(places[0] + high[best]))


def _least_growth(values: np.ndarray) -> float:
    """The least that values grow over half their range."""
    half = (len(values) - 1) // 2
    return float((values[half:] - values[:-half]).min())


def _fitted(sums: Sums, low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Slopes over ranges of distances, and their errors."""
    weights, finer = np.zeros((2, len(low), len(sums.values)))
    by_range = np.empty(len(low))
    slopes = np.diff(sums.values) / STEP
    for steps in np.unique(high - low).tolist():
        which = np.flatnonzero(high - low == steps)
        for into, count in ((weights, steps + 1), (finer, steps // 2 + 2)):
            into[which[:, np.newaxis], low[which, np.newaxis] + np.arange(count)] = _weights(count)
        by_range[which] = OF_SLOPE * standard_error(sliding_window_view(slopes, steps)[low[which]].T)
    dimension = weights @ sums.values
    parts = np.array([by_chance(sums, weights), by_range, finer @ sums.values - dimension, weights @ sums.itself])
    return dimension, np.sqrt((parts**2).sum(axis=0))


def by_chance(sums: Sums, weights: np.ndarray) -> np.ndarray:
    """Errors by chance of sums with weights of shape (R, S)."""
    of_points = standard_error(np.einsum("bs,rs->br", sums.blocks, weights)) ** 2
    # pairs within the smaller of two distances are within both
    together = np.diff(np.cumsum(weights, axis=1) ** 2, axis=1, prepend=0.0)
    pairs, shared = np.maximum(np.einsum("ks,rs->kr", sums.pairs, together), 0.0)
    return np.sqrt(np.maximum(of_points - WINDOWS.enlarged**2 * shared, 0.0) + pairs)


def _weights(count: int) -> np.ndarray:
    """Weights of values at ``count`` distances in a least-squares slope."""
    place = STEP * (np.arange(count) - (count - 1) / 2)
    return place / (place**2).sum()


def refusal(sums: Sums) -> str:
    """Why there is no dimension."""
    steps = int(sums.sound.sum()) - 1
    if steps < 0:
        return "no points are near each other, or none apart"
    if steps >= SCALING.shortest:
        return "no scaling region; the points lie in clusters that are not resolved: record more points"
    return (
        f"no scaling region; the points resolve distances over a factor of {2 ** (steps / 2):.3g}, and a region needs "
        f"{2 ** (SCALING.shortest / 2):.3g}: record more points, for a factor of 2 more 2^D times as many"
    )
