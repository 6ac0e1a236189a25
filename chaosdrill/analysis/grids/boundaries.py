"""Basins and their boundaries on a grid of any number of dimensions, from the number of the attractor of every cell."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, product
from typing import TYPE_CHECKING, Any

import numpy as np

from chaosdrill.analysis.judgement.recurrence import CLOSE
from chaosdrill.analysis.tuning import BOUNDARIES
from chaosdrill.dataset.outcomes import Outcome, count_outcomes
from chaosdrill.engine.shifts import Shifts, shifts_of

if TYPE_CHECKING:
    import xarray as xr

    from chaosdrill.analysis.base import Job
    from chaosdrill.model import HybridSystem


@dataclass(frozen=True)
class Uncertainty:
    """How many starts have another attractor so close, and the power of the distance with which that grows."""

    distance: np.ndarray  # int (K,): in cells
    fraction: np.ndarray  # (K,): of all cells that are uncertain at it
    error: np.ndarray  # (K,): standard errors
    exponent: float
    exponent_error: float
    reason: str  # why there is no exponent, if there is none


_UNKNOWN = Uncertainty(np.zeros(0, dtype=np.int64), np.zeros(0), np.zeros(0), np.nan, np.nan, "the grid is one cell")
"""Of a grid without an axis."""


def mixing(numbers: np.ndarray, side: int) -> dict[str, tuple[float, float]]:
    """Basin entropy and boundary basin entropy, with their standard errors; NaN without a box, or without a boundary.

    Boxes of ``side`` cells along every axis have the Gibbs entropy of the attractors in them (Daza and others 2016,
    doi:10.1038/srep31416). The first is the mean over all boxes, the second over those with more than one attractor.
    Cells that do not fill a box are left out. The errors join how far the means move with where the first box begins
    and, since a boundary may pass anywhere between two cells, with where it passes.
    """
    kinds = np.unique(numbers, return_inverse=True)[1].reshape(numbers.shape)
    counts = [length // side for length in numbers.shape]
    names = ("basin_entropy", "boundary_entropy")
    if not counts or not all(counts):
        return dict.fromkeys(names, (np.nan, np.nan))
    box, shares = _boxes(kinds, side, [0] * numbers.ndim, counts)
    entropy = _entropies(shares)
    moved = np.array([_means(_entropies(_boxes(kinds, side, *one)[1])) for one in _begins(numbers.shape, side)])
    passed = _passed(kinds[tuple(slice(length) for length in box.shape)], box, shares) / side**numbers.ndim
    found = {}
    for name, mean, values, part in zip(names, _means(entropy), moved.T, (entropy, entropy[entropy > 0]), strict=True):
        found[name] = mean, float(np.hypot(_spread(values), passed / len(part))) if len(part) else np.nan
    return found


def _begins(shape: tuple[int, ...], side: int) -> Iterator[tuple[tuple[int, ...], list[int]]]:
    """Cells at which the first box may begin, and the numbers of boxes that fit in from each of these on."""
    places = max(2, min(BOUNDARIES.shifts, int(BOUNDARIES.most_shifts ** (1 / max(len(shape), 1)))))
    counts = [max(1, (length + 1) // side - 1) for length in shape]
    room = [min(side, length - count * side + 1) for length, count in zip(shape, counts, strict=True)]
    for begin in product(*(np.unique(np.arange(places) * most // places).tolist() for most in room)):
        yield begin, counts


def _boxes(kinds: np.ndarray, side: int, begin: Sequence[int], counts: Sequence[int]) -> tuple[np.ndarray, np.ndarray]:
    """Number of the box of each cell, from a first box on, and the shares of the attractors in it, (boxes, kinds)."""
    box = _numbered([np.repeat(np.arange(count), side) for count in counts])
    cut = kinds[tuple(slice(first, first + length) for first, length in zip(begin, box.shape, strict=True))]
    boxes, most = int(np.prod(counts)), int(kinds.max()) + 1
    hits = np.bincount((box * most + cut).ravel(), minlength=boxes * most)
    return box, hits.reshape(boxes, most) / side**kinds.ndim


def _entropies(shares: np.ndarray) -> np.ndarray:
    return np.asarray(-(shares * np.log(np.where(shares > 0, shares, 1.0))).sum(axis=1))


def _means(entropy: np.ndarray) -> tuple[float, float]:
    """Over all boxes, and over those on a boundary."""
    on_boundary = entropy[entropy > 0]
    return float(entropy.mean()), float(on_boundary.mean()) if len(on_boundary) else np.nan


def _spread(values: np.ndarray) -> float:
    """Standard deviation of those that are known."""
    known = values[np.isfinite(values)]
    return float(known.std(ddof=1)) if len(known) > 1 else np.nan


def _passed(kinds: np.ndarray, box: np.ndarray, shares: np.ndarray) -> float:
    """How far the sum of all entropies moves, times the cells of a box, as boundaries pass anywhere between cells.

    Between two neighbours on its two sides each is evenly distributed; the axis along which it moves most is taken.
    """
    logarithms = np.log(np.maximum(shares, 1 / (2 * box.size / len(shares))))
    moves = [0.0]
    for axis in range(kinds.ndim):
        here, beside = (np.delete(kinds, end, axis) for end in (-1, 0))
        of = np.delete(box, -1, axis)
        moves.append(float(((logarithms[of, here] - logarithms[of, beside]) ** 2).sum() / 12))
    return float(np.sqrt(max(moves)))


def uncertainty(numbers: np.ndarray) -> Uncertainty:
    """The uncertainty exponent (Grebogi, McDonald, Ott and Yorke 1983, doi:10.1016/0375-9601(83)90945-3).

    A cell is uncertain at a distance of 3, 4, 5, 6, 8, 10, ... cells along an axis, up to a sixteenth of it, unless all
    cells as close to it along this axis lead to one attractor; cells closer to its ends than the largest of these are
    left out. The exponent is the slope of a line through the logarithms, all weighted alike, along the axis on which it
    is least: others may cross a fractal boundary where it is smooth. Its error joins that of the slope when each of the
    4 parts of every axis is left out in turn; the largest of what the line leaves unexplained, the difference of the
    slopes at small and at large distances, as the steps of a self-similar boundary make, and what a rough boundary
    hides between cells; and half of what it would be more if what is uncertain at one distance overlapped at random at
    a larger one, as it does where much of the grid is uncertain.
    """
    along = [_uncertainty_along(numbers, axis) for axis in range(numbers.ndim)]
    told = [one for one in along if np.isfinite(one.exponent)]
    if told:
        return min(told, key=lambda one: one.exponent + one.exponent_error)
    return max(along, key=lambda one: (len(one.distance), float(one.fraction.max(initial=0.0))), default=_UNKNOWN)


def _uncertainty_along(numbers: np.ndarray, axis: int) -> Uncertainty:
    """That of distances along an axis."""
    from scipy.ndimage import maximum_filter1d, minimum_filter1d

    length = numbers.shape[axis]
    distance = _distances(length // BOUNDARIES.parts)
    blocks = BOUNDARIES.blocks**numbers.ndim
    hits = np.zeros((len(distance), blocks))
    # the same cells at all distances, as far from the ends as the largest of these
    most = int(distance.max(initial=0))
    inner = (slice(None),) * axis + (slice(most, length - most),)
    where = _numbered([np.arange(size) * BOUNDARIES.blocks // size for size in numbers.shape])[inner].ravel()
    cells = np.bincount(where, minlength=blocks)
    for row, d in enumerate(distance.tolist()):
        low, high = (one(numbers, 2 * d + 1, axis)[inner] for one in (minimum_filter1d, maximum_filter1d))
        hits[row] = np.bincount(where, weights=(low != high).ravel(), minlength=blocks)
    total, every = hits.sum(axis=1), cells.sum()
    fraction = total / max(every, 1)
    without = (total[:, np.newaxis] - hits) / np.maximum(every - cells, 1)
    # that of as many random places as do not overlap
    error = np.sqrt(fraction * (1 - fraction) * (2 * distance + 1.0) ** numbers.ndim / max(every, 1))
    exponent = exponent_error = np.nan
    fits = total >= BOUNDARIES.least
    reason = _no_fit(length, total, fits, without)
    if not reason:
        across = np.log(distance[fits])
        exponent, left = _slope(across, np.log(fraction[fits]))
        slopes = np.array([_slope(across, np.log(one))[0] for one in without[fits].T])
        spread = np.sqrt((blocks - 1) / blocks * ((slopes - slopes.mean()) ** 2).sum())
        half = len(across) // 2
        ends = [_slope(across[part], np.log(fraction[fits])[part])[0] for part in (slice(half), slice(-half, None))]
        crowded = _slope(across, np.log(-np.log1p(-np.minimum(fraction[fits], BOUNDARIES.most_uncertain))))[0]
        missed = _missed_between_cells(distance[fits], fraction[fits])
        systematic = max(left, abs(ends[1] - ends[0]), missed)
        exponent_error = float(np.hypot(np.hypot(spread, systematic), abs(crowded - exponent) / 2))
    return Uncertainty(distance, fraction, error, exponent, exponent_error, reason)


def _no_fit(length: int, total: np.ndarray, fits: np.ndarray, without: np.ndarray) -> str:
    """Why no exponent is fitted to the uncertain cells at some distances; empty if one is."""
    needed = int(BOUNDARIES.parts * BOUNDARIES.nearest * 2 ** ((BOUNDARIES.fewest - 1) / 3))
    if len(total) < BOUNDARIES.fewest:
        return f"{length} values along a state are too few for a fit: give {needed} at least"
    if not total.any():
        return "no cell well within the grid is near a boundary"
    if fits.sum() < BOUNDARIES.fewest:
        return f"only {total[-1]:.0f} cells are near a boundary: give more values of the states"
    return "" if (without[fits] > 0).all() else "the boundary lies in one part of the grid: move the grid, or narrow it"


def _distances(most: int) -> np.ndarray:
    """3, 4, 5, 6, 8, 10, 13, 16, ...: at fewer cells a fine boundary is missed between them."""
    steps = np.arange(int(3 * np.log2(max(most, 1))) + 1)
    found = np.unique(np.rint(BOUNDARIES.nearest * 2 ** (steps / 3)).astype(np.int64))
    return found[found <= most]


def _numbered(along: Sequence[np.ndarray]) -> np.ndarray:
    """Numbers of the parts of a grid in which its cells lie, from those along every axis."""
    counts = [int(one[-1]) + 1 for one in along]
    found = np.zeros([len(one) for one in along], dtype=np.int64)
    for axis, one in enumerate(along):
        found = counts[axis] * found + one.reshape([-1 if k == axis else 1 for k in range(len(along))])
    return found


def _missed_between_cells(distance: np.ndarray, fraction: np.ndarray) -> float:
    """By how much an exponent may be off since a rough boundary leaves its cell and comes back between two cells.

    Fractions then lack about the same at all distances, and their logarithms are steeper than the boundary is rough.
    The power of the distance with which they grow beside a constant is compared with that without one, in proportion
    to the square of the part that the constant explains of what is unexplained without it: it explains half of the
    steps of a self-similar boundary, too.
    """
    powers = np.linspace(*BOUNDARIES.powers)
    terms = np.stack([distance ** powers[:, np.newaxis], np.ones((len(powers), len(distance)))], axis=2)
    terms /= fraction[:, np.newaxis]

    def unexplained(columns: np.ndarray) -> np.ndarray:
        left = 1.0 - (columns @ (np.linalg.pinv(columns) @ np.ones((len(distance), 1))))[:, :, 0]
        return np.asarray((left**2).sum(axis=1))

    plain, beside = unexplained(terms[:, :, :1]), unexplained(terms)
    if not plain.min() > 0:
        return 0.0
    explained = max(0.0, 1.0 - float(beside.min() / plain.min()))
    return float(abs(powers[plain.argmin()] - powers[beside.argmin()])) * explained**2


def _slope(x: np.ndarray, y: np.ndarray) -> tuple[float, float]:
    """Slope of a line and its standard error from what it leaves unexplained."""
    off = x - x.mean()
    slope = float(off @ y / (off @ off))
    left = y - y.mean() - slope * off
    return slope, float(np.sqrt(left @ left / max(len(x) - 2, 1) / (off @ off)))


def share_error_of_grid(numbers: np.ndarray, number: int, binomial: float) -> float:
    """Standard error of the part of the cells that lead to an attractor.

    The boundary may pass anywhere between two neighbours that differ, and in the worst case alike in all of them. That
    is a distance of a cell, evenly distributed, over the area of the boundary; or the error of starts drawn at random
    where it is smaller, as for fractal boundaries, and where no boundary was met.
    """
    inside = numbers == number
    crossings = (int(np.count_nonzero(np.diff(inside, axis=axis))) for axis in range(inside.ndim))
    crossed = max(crossings, default=0)
    return min(binomial, crossed / numbers.size / np.sqrt(12)) if crossed else binomial


def merged_distances(numbers: np.ndarray) -> np.ndarray:
    """For each basin how far, in cells, points of any boundary are at most from its own, by ascending number.

    All other basins are merged into one, and the boundaries that remain are compared: those of a Wada basin are all the
    same (Daza and others 2018, doi:10.1038/s41598-018-28119-0). NaN for fewer than three.
    """
    from scipy.ndimage import distance_transform_cdt

    present = np.unique(numbers).tolist()
    if len(present) < 3:
        return np.full(len(present), np.nan)
    edges = [_boundary(numbers == number) for number in present]
    far = np.zeros((len(present), len(present)))
    for i, j in [pair for one in combinations(range(len(present)), 2) for pair in (one, one[::-1])]:
        away = distance_transform_cdt(~edges[i], metric="chessboard")
        far[i, j] = away[edges[j]].max(initial=0)
    return far.max(axis=1)


def _boundary(inside: np.ndarray) -> np.ndarray:
    """Cells with a neighbour on the other side."""
    found = np.zeros(inside.shape, dtype=bool)
    for axis in range(inside.ndim):
        differs = np.diff(inside, axis=axis)
        for layers in (slice(None, -1), slice(1, None)):
            found[(slice(None),) * axis + (layers,)] |= differs
    return found


_KEPT = (
    *("attractor_period", "attractor_outcome", "attractor_state", "attractor_exponent", "attractor_error"),
    *("first_value", "last_value", "end_below", "end_above", "next_below", "next_above", "forcing_period"),
    *("attractor", "state", "exponent"),
)
"""What the datasets of basins, and of attractors along a parameter, tell of attractors."""


def measures_dataset(system: "HybridSystem", given: Any, job: "Job") -> "xr.Dataset":
    """Measures of basins; see `chaosdrill.basin_measures`."""
    from chaosdrill.analysis.grids.shares import followed
    from chaosdrill.analysis.grids.sweeps import over_states
    from chaosdrill.analysis.starts import cells_and_listed
    from chaosdrill.dataset.build import more

    if given.sweep is None:
        found = over_states(system, given, job).rename(attractor="reached", attractor_number="attractor")
        measured, reasons = _measures(system, given, found)
        reason = "; ".join(reasons)
    else:
        found = followed(system, given, job, *cells_and_listed(system, given, settled=False))
        measured, reason = _along(system, given, found)
    kept = {name: found[name].variable for name in _KEPT if name in found.variables}
    told = more(measured, kept | {"start_count": ((), found["reached"].size // measured["fraction_none"].size)})
    return told.assign_attrs({"reason": reason} if reason else {})


def _along(system: "HybridSystem", given: Any, found: "xr.Dataset") -> tuple["xr.Dataset", str]:
    """Measures at every value of a parameter, an outcome there, and why some of them are NaN, and where."""
    import xarray as xr

    from chaosdrill.analysis.grids.points import reasons_along
    from chaosdrill.analysis.starts import any_ran
    from chaosdrill.dataset.build import more

    ((name, values),) = given.sweep.items()
    codes = found["outcome"].values
    parts, said = zip(
        *(
            _measures(system.with_parameters({name: value}), given, found.isel({name: place}, drop=True))
            for place, value in enumerate(values.tolist())
        ),
        strict=True,
    )
    # along axes of different lengths there are different distances
    along = xr.concat(parts, name, data_vars="all", coords="minimal", compat="override", join="outer")
    outcome = np.where(any_ran(codes), Outcome.OK, codes.max(axis=1)).astype(np.int8)
    return more(along, {name: values, "outcome": (name, outcome)}), reasons_along(name, values, said)


def _measures(system: "HybridSystem", given: Any, found: "xr.Dataset") -> tuple["xr.Dataset", list[str]]:
    """Measures of the basins at one value of all parameters, by the attractors that all starts have ``reached``.

    They are NaN if no start could be run.

    Returns: the measures, and why some are NaN.
    """
    from chaosdrill.analysis.starts import any_ran, share_of
    from chaosdrill.dataset.build import dataset

    reached, count = found["reached"].values.astype(np.int64).ravel(), found.sizes["attractor"]
    fraction, error = share_of(np.bincount(reached, minlength=count + 1), reached.size)
    cells = None
    if given.grid:
        shape = tuple(len(values) for values in given.grid.values())
        cells = reached[: int(np.prod(shape))].reshape(shape)
        cells = cells[np.ix_(*(np.argsort(values) for values in given.grid.values()))].squeeze()
        if given.initial is None:
            error = np.array([share_error_of_grid(cells, k, float(error[k])) for k in range(count + 1)])
    error[1:][found["attractor_outcome"].values < 0] = np.nan
    variables: dict[str, Any] = {
        "fraction": ("attractor", fraction[1:]),
        "fraction_error": ("attractor", error[1:]),
        "fraction_none": ((), fraction[0]),
        "fraction_none_error": ((), error[0]),
    }
    coords: dict[str, Any] = {}
    why: dict[str, str] = {}
    if cells is not None:
        for name, (value, spread) in mixing(cells, given.box).items():
            variables |= {name: ((), value), f"{name}_error": ((), spread)}
        # a state of one value is held there, as those without an axis are
        grid = {name: values for name, values in given.grid.items() if len(values) > 1}
        held = {name: float(values[0]) for name, values in given.grid.items() if len(values) == 1}
        uneven = [name for name, values in grid.items() if not _evenly(values)]
        power = uncertainty(cells)
        if uneven:
            power = replace(power, exponent=np.nan, exponent_error=np.nan, reason=f"{uneven[0]} has unequal steps")
        variables |= {
            "uncertainty_exponent": ((), power.exponent),
            "uncertainty_exponent_error": ((), power.exponent_error),
            "uncertain_fraction": ("distance", power.fraction),
            "uncertain_fraction_error": ("distance", power.error),
            "wada_distance": ("attractor", _of_attractors(cells, count)),
        }
        along = {name: grid[name] for name in system.state_names if name in grid}
        ordered = cells.transpose([list(grid).index(name) for name in along])
        inside = list(_in_the_grid(system, along, held, found))
        kicks = [smallest_kicks(ordered, along, *one) for one in inside]
        for name, parts in zip(("smallest_kick", "smallest_kick_error"), zip(*kicks, strict=True), strict=False):
            variables[name] = (("attractor", "state"), _of_states(system, along, np.array(parts)))
        coords["distance"] = power.distance.astype(np.int32)
        there = found["attractor_outcome"].values >= 0
        why = _lacking(variables, cells, given.box, power.reason)
        why |= _without_kick(cells, *([one[k] for k in np.flatnonzero(there)] for one in (inside, kicks)))
    missed = _not_run(found["outcome"].values.ravel())
    if not any_ran(found["outcome"].values.ravel()):
        return dataset(variables | coords, coords).where(False), [f"no start could be run: {missed}"]
    reasons = [f"{name}: {words}" for name, words in why.items()]
    return dataset(variables | coords, coords), reasons + [f"fraction_none: {missed}"] * bool(missed)


def _not_run(outcomes: np.ndarray) -> str:
    """How many starts could not be run, by their outcomes."""
    from chaosdrill.analysis.starts import NOT_RUN

    counts = count_outcomes(outcomes[np.isin(outcomes, NOT_RUN)])
    return ", ".join(f"{count} of {len(outcomes)} starts are {word}" for word, count in counts.items())


def _lacking(variables: Mapping[str, Any], cells: np.ndarray, box: int, no_exponent: str) -> dict[str, str]:
    """Why measures of a grid are NaN, by their names; an error alone has its own reason."""
    more, few = "give more values, or a smaller box", len(np.unique(cells)) < 3
    fits = cells.ndim > 0 and all(length >= box for length in cells.shape)
    whys = {
        "basin_entropy": f"no box of {box} cells fits: {more}",
        "boundary_entropy": "no box has more than one attractor" if fits else f"no box of {box} cells fits: {more}",
        "uncertainty_exponent": no_exponent,
        "wada_distance": "there are fewer than three basins" if few else "no cell leads to some attractors",
    }
    lacking = {name: words for name, words in whys.items() if np.isnan(variables[name][1]).any()}
    alone = f"boxes that begin elsewhere do not fit, or meet no boundary: {more}"
    for name in ("basin_entropy", "boundary_entropy"):
        if name not in lacking and np.isnan(variables[f"{name}_error"][1]):
            lacking[f"{name}_error"] = alone
    return lacking


def _without_kick(cells: np.ndarray, inside: Sequence[Any], kicks: Sequence[Any]) -> dict[str, str]:
    """Why there is no smallest kick from some attractors, by name and number."""
    found = {}
    for (number, point, _), (kick, _) in zip(inside, kicks, strict=True):
        if not np.isfinite(kick).any():
            words = "its point is in another plane" if np.isnan(point).any() else "its point is outside the grid"
            words = "the grid has no other basin" if (cells == number).all() else words
            found[f"smallest_kick of {number}"] = words if cells.ndim else "the grid is one cell"
    return found


def _evenly(values: np.ndarray) -> bool:
    """Whether values stand at equal distances, to a thousandth of one."""
    steps = np.diff(np.sort(values))
    return len(steps) > 0 and float(np.ptp(steps)) <= 1e-3 * float(steps.mean())


def _of_attractors(cells: np.ndarray, count: int) -> np.ndarray:
    """Distances of the merged boundaries by the number of the attractor, NaN for those that no cell leads to."""
    found = np.full(count + 1, np.nan)
    found[np.unique(cells)] = merged_distances(cells)
    return found[1:]


def smallest_kicks(
    cells: np.ndarray, grid: Mapping[str, np.ndarray], number: int, point: np.ndarray, shifts: Shifts | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """The smallest change of a point to a cell of another basin, and its error, in the units of each state of the grid.

    Lengths are taken in parts of the grid along every axis. NaN for a point that is not in the grid (of a shifted
    state: in its cells), and where all cells are of one basin. The boundary lies up to a cell before; and since it
    does, the kick may lead to any place where cells of other basins are farther by no more than half a cell, as along a
    boundary that is about as far everywhere; the nearest cell is amid these. Both make the error. Points are the same
    but for ``shifts``, such as whole turns.
    """
    shifts = shifts or Shifts.none(len(grid))
    axes = [np.sort(values) for values in grid.values()]
    low, extent = (np.array([of(values) for values in axes]) for of in (np.min, np.ptp))
    nothing = np.full(len(axes), np.nan)
    others, steps = np.argwhere(cells != number), [np.diff(values) for values in axes]
    if not len(others) or not len(axes) or not (extent > 0).all():
        return nothing, nothing
    # a turn is a step longer than its grid
    reach = (extent + np.where(shifts.moves, [step.max() for step in steps], 0.0)) / 2
    middle = low + extent / 2
    if not (np.abs(shifts.across(point - middle)) <= reach + 4 * np.spacing(np.abs(middle) + extent)).all():
        return nothing, nothing
    places = np.column_stack([values[place] for values, place in zip(axes, others.T, strict=True)])
    ways = shifts.across(places - point)
    lengths = np.linalg.norm(ways / extent, axis=1)
    best = int(np.argmin(lengths))
    cell = np.array(
        [step[max(place - 1, 0) : place + 1].max() for step, place in zip(steps, others[best].tolist(), strict=True)]
    )
    as_near = ways[lengths <= lengths[best] + np.linalg.norm(cell / extent) / 2]
    return ways[best], np.sqrt(cell**2 / 3 + ((as_near - ways[best]) ** 2).mean(axis=0) / 4)


def _in_the_grid(
    system: "HybridSystem", grid: Mapping[str, np.ndarray], held: Mapping[str, float], found: "xr.Dataset"
) -> Iterator[tuple[int, np.ndarray, Shifts]]:
    """Numbers of attractors, their points in the states of the grid, NaN for those in another plane, and its shifts."""
    names = list(system.state_names)
    own = np.array([held.get(name, system.initial[name]) for name in names], dtype=float)
    spanned = np.array([name in grid for name in names])
    within, beside = (_of(shifts_of(system, but_of=()), states) for states in (spanned, ~spanned))
    for number, state in enumerate(found["attractor_state"].transpose("attractor", "state").values, start=1):
        size = np.maximum(np.abs(state), np.abs(own))
        there = (np.abs(beside.across((state - own)[~spanned])) <= CLOSE * size[~spanned]).all()
        yield number, state[spanned] if there else np.full(len(grid), np.nan), within


def _of(shifts: Shifts, states: np.ndarray) -> Shifts:
    """Shifts of some states that move no others."""
    return Shifts(*(one[~one[:, ~states].any(axis=1)][:, states] for one in (shifts.lines, shifts.turns)))


def _of_states(system: "HybridSystem", grid: Mapping[str, np.ndarray], parts: np.ndarray) -> np.ndarray:
    """Numbers of the states of the grid among all states, 0 for the others, and NaN without any."""
    found = np.zeros((len(parts), len(system.state_names)))
    found[np.isnan(parts).all(axis=1)] = np.nan
    found[:, [system.state_names.index(name) for name in grid]] = parts
    return found
