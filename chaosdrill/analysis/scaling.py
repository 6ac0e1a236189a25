"""Dimensions of section points: how sums over pairs of points grow with the distance, and where they do so evenly.

Distances are the largest over the states, each in units of its standard deviation, so that the units of states do not
matter: dimensions are those of the set in any smooth coordinates.
"""

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import xarray as xr
from scipy.spatial import cKDTree

from chaosdrill.analysis.recurrence import CLOSE, sizes
from chaosdrill.analysis.sections import Taken, find_section, section_points
from chaosdrill.analysis.statistics import in_blocks, standard_error
from chaosdrill.dataset import Outcome
from chaosdrill.errors import SettingsError
from chaosdrill.model import HybridSystem

if TYPE_CHECKING:
    from chaosdrill.analysis.base import Job

SCALES = 2.0 ** np.arange(-26.0, 2.25, 0.5)
"""Distances, in standard deviations of the states; below the first one the digits of states end."""

STEP = float(np.log(2.0)) / 2
"""Logarithm of the ratio of neighbouring distances."""

REFERENCES = 16_384
"""Points at most from which neighbours are counted: evenly spaced along the record, which sees all of the attractor."""

LOOKED_AT = 64
"""Points by which it is seen which distances are worth counting at."""

FEWEST_PAIRS = 500
"""Pairs at the smallest distance of a scaling region, at least: their number is then sure to 5 %."""

WIDEST = 0.2
"""Part of all pairs at the largest distance, at most: beyond, the extent of the attractor tells."""

BEYOND = 1.2
"""Part of the widest one to which is counted, so that it is seen how a region ends."""

LEAF = 64
"""Points of a leaf of the tree, which are counted without a look at them where all of a leaf is near enough."""

SHORTEST = 7
"""Steps of the distance in a scaling region, at least: a factor of 11."""

FEWEST = 500
"""Points without which no region is looked for."""

BLOCKS = 256
"""Parts of a record, in order, from which the error by chance is taken."""

OF_SLOPE = float(np.sqrt(1.2))
"""Error of a least-squares slope over that of a mean of local slopes, if these are independent."""


REGULAR = 0.5
"""Part of the points without a neighbour that chance would leave, below which points keep away from each other."""

CROWDED = 3.0
"""Mean number of neighbours, at least, where that is looked at."""


class Counted(NamedTuple):
    """Neighbours of some points."""

    counts: np.ndarray  # (R, S): within each distance; NaN at distances at which it was not worth counting
    possible: np.ndarray  # (R,): points that could be such

    def pairs(self) -> np.ndarray:
        """Pairs at each distance, shape (S,)."""
        return np.asarray(self.counts.sum(axis=0) / 2)

    def part(self) -> np.ndarray:
        """Part of all pairs that are within each distance, shape (S,)."""
        return np.asarray(self.counts.sum(axis=0) / self.possible.sum())

    def itself(self) -> np.ndarray:
        """What the logarithm of a sum gains if points neighbour themselves, where that is no less right; shape (S,).

        Points of a torus keep away from each other: where there are few, it is by their order, not by chance, how many
        are within a distance.
        """
        near = self.counts.mean(axis=0)
        crowded = np.flatnonzero(near >= CROWDED)
        if not len(crowded) or (self.counts[:, crowded[0]] == 0).mean() >= REGULAR * np.exp(-near[crowded[0]]):
            return np.zeros_like(near)
        return np.asarray(np.log1p(1 / np.maximum(near, 1e-300)))


class Sums(NamedTuple):
    """Logarithms of a sum at all distances, shape (S,), and what parts of the record add to them, shape (B, S)."""

    values: np.ndarray  # NaN where nothing was counted
    blocks: np.ndarray


class Region(NamedTuple):
    """A dimension and the distances over which it was found, as places of `SCALES`."""

    dimension: float
    error: float
    low: int
    high: int


def dimensions_of(system: HybridSystem, given: Any, job: "Job") -> xr.Dataset:
    """Dimensions of the section points of a run; see `dimensions`."""
    taken = section_points(find_section(system, given, job.numerics), given, given.max_period, job)
    count, orders = len(taken.states), np.array([2.0])
    if given.window >= max(count, 1) / 10 and taken.outcome == Outcome.OK:
        raise SettingsError(
            f"window is {given.window}; pairs of points so near in time are left out, and a record of {count} points "
            "needs ten times as many: take a longer record or a shorter window"
        )
    outcome, why = taken.outcome, taken.run.stopped(taken.outcome)
    shape = (len(orders), len(SCALES))
    sums, slope, slope_error = np.full((3, *shape), np.nan)
    dimension, error, low, high = np.full((4, len(orders)), np.nan)
    spread = np.zeros(len(system.states))
    if outcome == Outcome.OK and taken.period:
        outcome, dimension, error = Outcome.PERIODIC, np.zeros(len(orders)), np.zeros(len(orders))
    elif outcome == Outcome.OK:
        points, spread = in_spreads(taken)
        counted = neighbours(points, given.window) if count >= FEWEST and points.shape[1] else None
        for place, order in enumerate(orders.tolist()):
            if counted is None:
                continue
            of_order = correlation_sums(counted, order)
            sums[place] = np.exp(of_order.values)
            slope[place, :-1], slope_error[place, :-1] = local_slopes(of_order)
            found = scaling_region(of_order, counted)
            if found is not None:
                dimension[place], error[place] = found.dimension, found.error
                low[place], high[place] = SCALES[found.low], SCALES[found.high]
        if np.isnan(dimension).all():
            outcome, why = Outcome.UNDECIDED, refusal(count, sums)
    told = {"reason" if outcome == Outcome.UNDECIDED else "message": why}
    return xr.Dataset(
        {
            "dimension": ("order", dimension),
            "dimension_error": ("order", error),
            "scale_low": ("order", low),
            "scale_high": ("order", high),
            "correlation_sum": (("order", "scale"), sums),
            "local_slope": (("order", "scale"), slope),
            "local_slope_error": (("order", "scale"), slope_error),
            "spread": ("state", spread),
            "period": ((), np.int32(taken.period)),
            "outcome": ((), np.int8(outcome)),
            **({"forcing_period": ((), taken.where.unit)} if system.period is not None else {}),
        },
        coords={"order": orders, "scale": SCALES, "state": list(system.state_names)},
        attrs={name: text for name, text in told.items() if text},
    )


def in_spreads(taken: Taken) -> tuple[np.ndarray, np.ndarray]:
    """Points in units of the states' standard deviations, shape (N, d), and these, shape (n,), 0 of what rests.

    At events of a system with a clock of its own the phase of this is a coordinate too, on a circle.
    """
    states, system = taken.states, taken.run.system
    floor = sizes(states[np.newaxis], taken.run.sizes[np.newaxis])[0]
    spread = np.where(np.ptp(states, axis=0) > CLOSE * floor, states.std(axis=0), 0.0)
    moving = spread > 0
    points = (states[:, moving] - states[:, moving].mean(axis=0)) / spread[moving]
    if taken.where.transitions is not None and system.period is not None and not system.autonomous:
        angle = 2 * np.pi * (taken.times / taken.run.period % 1)
        points = np.column_stack([points, np.cos(angle), np.sin(angle)])
    return points, spread


def neighbours(points: np.ndarray, window: int) -> Counted:
    """Neighbours within each distance, and points that could be such, of some points.

    Parameters
    ----------
    points : ndarray, shape (N, d)
    window : int
        Steps of time up to which two points are no pair (Theiler 1986).
    """
    count = len(points)
    tree = cKDTree(points, leafsize=LEAF)
    which = np.arange(0, count, -(-count // REFERENCES))
    few = which[:: -(-len(which) // LOOKED_AT)]
    near = np.array([_within(tree, points[few], r).mean() for r in SCALES]) - 1
    # what a few points see of a sparse distance is by chance
    chosen = (near * len(which) >= FEWEST_PAIRS) & (near <= BEYOND * WIDEST * count)
    counts = np.full((len(which), len(SCALES)), np.nan)
    for place in np.flatnonzero(chosen):
        counts[:, place] = _within(tree, points[which], SCALES[place]) - 1
    possible = np.full(len(which), count - 1)
    for lag in [*range(-window, 0), *range(1, window + 1)]:
        there = (which + lag >= 0) & (which + lag < count)
        apart = np.abs(points[which[there]] - points[which[there] + lag]).max(axis=1)
        counts[there] -= apart[:, np.newaxis] <= SCALES
        possible[there] -= 1
    return Counted(counts, possible)


def _within(tree: cKDTree, places: np.ndarray, distance: float) -> np.ndarray:
    return np.asarray(tree.query_ball_point(places, distance, p=np.inf, return_length=True))


def correlation_sums(counted: Counted, order: float) -> Sums:
    """Logarithms of the correlation sum of an order that is 2 or a larger whole number, and the parts' shares.

    The sum of order q is the mean of the (q - 1)-th power of the share of points near a point, to the power 1/(q - 1)
    (Grassberger 1983, doi:10.1016/0375-9601(83)90753-3); powers are counted as tuples of different points. A point adds
    to it as a centre, and q - 1 times as much as a neighbour.
    """
    power, (counts, possible) = round(order) - 1, counted
    tuples = np.ones_like(counts)
    for less in range(power):
        tuples *= np.maximum(counts - less, 0.0) / (possible[:, np.newaxis] - less)
    mean = tuples.mean(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        values = np.log(mean) / power
        blocks = in_blocks(tuples / mean - 1, BLOCKS) * (power + 1) / power
    missing = ~np.isfinite(values)
    values[missing], blocks[:, missing] = np.nan, np.nan
    return Sums(values, blocks)


def local_slopes(sums: Sums) -> tuple[np.ndarray, np.ndarray]:
    """Slopes from every distance to the next one, and their errors by chance, shape (S - 1,)."""
    return np.diff(sums.values) / STEP, standard_error(np.diff(sums.blocks, axis=1) / STEP)


def scaling_region(sums: Sums, counted: Counted) -> Region | None:
    """The dimension over the distances that determine it best; None where too few are of use.

    Over every range of distances with enough pairs the dimension is the least-squares slope. Its error joins the one by
    chance, from blocks of the record; the one by which local slopes scatter and drift over the range, by
    `standard_error`; how far the slope over the finer half of the range is off; and, on a torus, what counting a point
    itself would change. The range with the least error is taken.
    """
    with np.errstate(invalid="ignore"):
        fit = np.isfinite(sums.values) & (counted.pairs() >= FEWEST_PAIRS) & (counted.part() <= WIDEST)
    itself = counted.itself()
    places = np.flatnonzero(fit)
    best = None
    for low in places.tolist():
        for high in range(low + SHORTEST, int(places[-1]) + 1):
            found = _fitted(sums, itself, low, high)
            if best is None or found.error < best.error:
                best = found
    return best


def _fitted(sums: Sums, itself: np.ndarray, low: int, high: int) -> Region:
    values, blocks = sums.values[low : high + 1], sums.blocks[:, low : high + 1]
    weight = _weights(high - low + 1)
    dimension = float(weight @ values)
    half = (high - low) // 2 + 2
    finer = float(_weights(half) @ values[:half])
    by_chance, by_range = standard_error(blocks @ weight), OF_SLOPE * standard_error(np.diff(values) / STEP)
    parts = np.array([by_chance, by_range, finer - dimension, weight @ itself[low : high + 1]])
    return Region(dimension, float(np.sqrt((parts**2).sum())), low, high)


def _weights(count: int) -> np.ndarray:
    """Of values at so many distances in a least-squares slope."""
    place = STEP * (np.arange(count) - (count - 1) / 2)
    return place / (place**2).sum()


def refusal(count: int, sums: np.ndarray) -> str:
    """Why there is no dimension."""
    if count < FEWEST:
        return f"{count} points are too few for a dimension: record {FEWEST} at least, and some thousand to tell any"
    steps = int(np.isfinite(sums[0]).sum()) - 1
    if steps < 0:
        return "the points are nowhere near each other, or all at one place"
    return (
        f"no scaling region: of {count} points enough are near each other over a factor of {2 ** (steps / 2):.3g} of "
        f"the distance, and it takes {2 ** (SHORTEST / 2):.3g}; record more points, about 10^(D/2) times as many for "
        "a factor of 3 more in dimension D"
    )
