"""Charts over two parameters, and basins of attraction over initial states."""

import json
from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib.colors import TwoSlopeNorm, to_hex
from matplotlib.patheffects import withStroke

from chaosdrill.dataset.outcomes import flag_names
from chaosdrill.errors import SettingsError
from chaosdrill.plots._types import Axes, Dataset, Figure, Integers, Line2D, Normalize, States, Truths
from chaosdrill.plots.categories import (
    ATTRACTED,
    FURTHER,
    MINUS_INFINITY,
    NO_ATTRACTOR,
    POSITIVE,
    UNRECOGNISED,
    Category,
    attractor_category,
    by_outcome,
    by_period,
    classify,
)
from chaosdrill.plots.contents import places_of
from chaosdrill.plots.figures import legend_outside, one_panel, size_of
from chaosdrill.plots.labels import exponent_text, label, readable, shorten, state_label, uncertain
from chaosdrill.plots.palette import EVENT_MARKERS, diverging, sequential
from chaosdrill.plots.pictures import picture
from chaosdrill.plots.plane import Plane
from chaosdrill.plots.tuning import TUNING


def _category_chart(dataset: Dataset, variable: str, found: tuple[Integers, list[Category]], ax: Axes | None) -> Figure:
    """A chart of the category of every point, over the dimensions of a variable."""
    plane = Plane(dataset, variable, ax)
    plane.categorise(*found)
    plane.legend()
    return plane.figure


@picture("parameter-chart", "isoperiodic-chart", "periods, or kinds of motion without a period")
def isoperiodic_chart(dataset: Dataset, *, ax: Axes | None = None) -> Figure:
    """Draw the periods found over two parameters, a panel for each seed; large regions carry their period."""
    return _category_chart(dataset, "period", by_period(dataset), ax)


@picture("parameter-chart", "lyapunov-chart", "largest exponent", needs="lyapunov_exponent")
def lyapunov_chart(dataset: Dataset, *, ax: Axes | None = None) -> Figure:
    """Draw the largest exponent over two parameters, a panel for each seed.

    Zero is the palest colour, and each sign has its own scale, set by values more than three standard errors from zero;
    minus infinity and points without a value have separate colours. Dotted points are positive by more than three
    standard errors.
    """
    largest = dataset["lyapunov_exponent"].isel(exponent=0)
    largest.attrs["long_name"] = f"largest {largest.attrs['long_name']}"
    told = _told(dataset)
    norm, extend = _scale(np.where(told, largest.values, np.nan))
    plane = Plane(dataset, "outcome", ax)
    positive = told & (largest.values > 0)
    plane.shade(largest, norm, diverging(), extend, [(-np.inf, MINUS_INFINITY)], (positive, POSITIVE))
    return plane.figure


def _told(dataset: Dataset) -> Truths:
    """Where the largest exponent is distinguished from zero, that of the flow direction above all."""
    every = dataset["lyapunov_exponent"].values
    size = np.abs(dataset["lyapunov_exponent"].isel(exponent=0).values)
    least = np.array(TUNING.nonzero_part * np.abs(every[np.isfinite(every)]).max(initial=0.0))
    if "lyapunov_error" in dataset.variables:
        errors = dataset["lyapunov_error"].isel(exponent=0).values
        least = np.fmax(least, TUNING.nonzero_errors * errors)
    told: Truths = size > least
    return told


def _scale(values: np.ndarray) -> tuple[Normalize, str]:
    """Norm with zero in the middle, and at which ends values lie beyond it."""
    finite = values[np.isfinite(values)]
    below, above = (part[part > 0] for part in (-finite, finite))
    low = float(np.percentile(below, TUNING.exponents_covered)) if below.size else 0.0
    high = float(np.percentile(above, TUNING.exponents_covered)) if above.size else 0.0
    # a sign that does not occur has the scale of the other
    low, high = low or high or 1.0, high or low or 1.0
    beyond = int((below > low).any()) + 2 * int((above > high).any())
    return TwoSlopeNorm(0.0, -low, high), ("neither", "min", "max", "both")[beyond]


@picture("parameter-chart", "progression-chart", "mean progression rate", needs="progression_rate")
def progression_chart(dataset: Dataset, *, ax: Axes | None = None) -> Figure:
    """Draw the mean progression rate over two parameters, a panel for each seed; in SI units if available."""
    rate = dataset["progression_rate"]
    finite = rate.values[np.isfinite(rate.values)]
    top = float(np.percentile(finite, TUNING.rates_covered, method="higher"))
    plane = Plane(dataset, "outcome", ax)
    norm = Normalize(min(0.0, finite.min()), top or 1.0)
    plane.shade(rate, norm, sequential(), "max" if finite.max() > top else "neither")
    return plane.figure


@picture("parameter-chart", "attractor-count-chart", "number of attractors among the seeds", seeds=2)
def attractor_count_chart(dataset: Dataset, *, ax: Axes | None = None) -> Figure:
    """Draw how many attractors all seeds found over two parameters; large regions carry their number."""
    counts = dataset["attractor_count"].values
    most = min(int(counts.max()), TUNING.counted_attractors)
    # from the palest colour of that scale to its dark end: one attractor is nothing to be struck by
    shades = [to_hex(shade) for shade in diverging()(np.linspace(0.5, 0, max(most, 2)))]
    table = [(counts == 0, NO_ATTRACTOR)]
    for number in range(1, most + 1):
        last = number == TUNING.counted_attractors and counts.max() > TUNING.counted_attractors
        name = f"{number} or more attractors" if last else "1 attractor" if number == 1 else f"{number} attractors"
        mask = counts >= number if last else counts == number
        table.append((mask, Category(name, shades[number - 1], short=f"≥ {number}" if last else str(number))))
    return _category_chart(dataset, "attractor_count", classify(table), ax)


@picture("parameter-chart", "outcome-chart", "outcome of the run at each point")
def outcome_chart(dataset: Dataset, *, ax: Axes | None = None) -> Figure:
    """Draw the outcomes over two parameters, a panel for each seed."""
    return _category_chart(dataset, "outcome", by_outcome(dataset), ax)


@picture("basins", "basins", "attractor of each initial state", listed=False)
def basins(dataset: Dataset, *, ax: Axes | None = None) -> Figure:
    """Draw the basins over a grid of initial states, a colour for each of the twelve attractors named first.

    The legend describes each attractor, with its largest exponent and its share of the grid. Points of attractors are
    marked where they lie in the plane of the grid.
    """
    codes, categories = attractor_cells(dataset)
    plane = Plane(dataset, "attractor", ax)
    plane.categorise(codes, categories)
    axes = plane.panels[0]
    marks = mark_attractors(axes, dataset, plane.across, plane.up)
    if fixed := _fixed(dataset):
        axes.set_title("at " + ", ".join(f"{name} = {shorten(value)}" for name, value in fixed.items()))
    names = [*(category.name for category in categories), *(str(mark.get_label()) for mark in marks)]
    columns = 2 if max(map(len, names)) <= TUNING.legend_letters else 1
    if ax is None:
        plane.figure.set_figheight(size_of(TUNING.chart_height + 0.18 * -(-len(names) // columns))[1])
    plane.legend(marks, ncols=columns)
    return plane.figure


@picture("basins", "starts", "initial states by their attractor", listed=True)
def starts(dataset: Dataset, *, ax: Axes | None = None, state: States = None) -> Figure:
    """Draw a list of initial states, each in the colour of the attractor to which it leads.

    A marker for each start; the legend describes each attractor, as in `basins`. ``state``: states of the plane, the
    horizontal one first; default: the first two. A single state is drawn against the number of the attractor.
    """
    codes, categories = attractor_cells(dataset)
    count = 1 if isinstance(state, str) or dataset.sizes["state"] == 1 else 2
    places = places_of(dataset, state, count)
    figure, axes = one_panel(ax, TUNING.chart_height)
    states = dataset["initial_state"].transpose("run", "state").values
    x, y = states[:, places[0]], states[:, places[1]] if count == 2 else dataset["attractor"].values
    for index, category in enumerate(categories):
        here = codes == index
        marker = EVENT_MARKERS[index % len(EVENT_MARKERS)]
        options: dict[str, Any] = {"color": category.colour, "marker": marker, "edgecolor": "0.3", "linewidth": 0.3}
        axes.scatter(x[here], y[here], s=18, label=category.name, **options)
    axes.set_xlabel(state_label(dataset, places[0]))
    axes.set_ylabel(state_label(dataset, places[1]) if count == 2 else label(dataset["attractor"]))
    legend_outside(figure, axes.get_legend_handles_labels()[0], ax=ax)
    return figure


def attractor_cells(dataset: Dataset) -> tuple[Integers, list[Category]]:
    """The category of every start: its attractor, or the outcome of a run that reached none."""
    reached = dataset["attractor"].values
    numbers = dataset["attractor_number"].values.tolist()
    table = [
        (reached == number, attractor_category(place, _describe(dataset.isel(attractor_number=place), number)))
        for place, number in enumerate(numbers[: TUNING.told_attractors])
    ]
    others = [(np.isin(reached, numbers[TUNING.told_attractors :]), FURTHER)]
    lost = reached == 0
    ended, categories = by_outcome(dataset)
    for code, category in enumerate(categories):
        if category.name not in ATTRACTED:
            others.append((lost & (ended == code), category))
            lost &= ended != code
    for mask, category in (*others, (lost, UNRECOGNISED)):
        part = float(mask.mean())
        share = _percent(part, float(np.sqrt(part * (1 - part) / mask.size)))
        table.append((mask, replace(category, name=f"{category.name}; {share}")))
    return classify(table)


def _describe(attractor: Dataset, number: int) -> str:
    """Description of an attractor: its period or kind, its largest exponent, and its share of the grid."""
    period = int(attractor["attractor_period"])
    kind = flag_names(attractor["attractor_outcome"]).get(int(attractor["attractor_outcome"]), "")
    parts = [f"period {period}" if period else "period not found" if kind in ("ok", "periodic") else readable(kind)]
    exponent = float(attractor["attractor_exponent"][0]) if "attractor_exponent" in attractor.variables else np.nan
    if not np.isnan(exponent):
        error = float(attractor["attractor_error"][0]) if "attractor_error" in attractor.variables else np.nan
        parts.append(exponent_text(1, exponent, error))
    if "attractor_rate" in attractor.variables and np.isfinite(attractor["attractor_rate"]):
        spread = float(attractor.get("attractor_rate_error", np.nan))
        parts.append(f"progression {uncertain(float(attractor['attractor_rate']), spread)}")
    share = _percent(float(attractor["fraction"]), float(attractor["fraction_error"]))
    return f"{number}: {', '.join(parts)}; {share}"


def _percent(part: float, error: float) -> str:
    return f"{uncertain(100 * part, 100 * error)} %"


def _fixed(dataset: Dataset) -> dict[str, float]:
    """The states that the grid does not vary, and their values, as far as the archive says."""
    initial = json.loads(dataset.attrs.get("initial", "{}"))
    names = [str(name) for name in dataset["state"].values]
    return {name: float(initial[name]) for name in names if name not in dataset["attractor"].dims and name in initial}


def mark_attractors(axes: Axes, dataset: Dataset, across: str, up: str) -> list[Line2D]:
    """Mark the attractors' points that lie in the plane and within the grid, and return a handle of the marks."""
    names = [str(name) for name in dataset["state"].values]
    needed = {across: 0, up: 0, **json.loads(dataset.attrs.get("initial", "{}"))}
    if lost := [name for name in needed if name not in (*names, "mode")]:
        raise SettingsError(
            f"ds lacks the state {lost[0]!r}, without which points of attractors have no place; select all states"
        )
    plane = np.array([_fixed(dataset).get(name, np.nan) for name in names])
    points = dataset["attractor_state"].transpose("attractor_number", "state").values[: TUNING.told_attractors]
    off = np.array([name not in (across, up) for name in names])
    near = np.abs(points - plane) <= TUNING.in_plane * (1 + np.abs(points))
    inside = near[:, off].all(axis=1)
    for axis, (low, high) in ((across, axes.get_xlim()), (up, axes.get_ylim())):
        inside &= (points[:, names.index(axis)] >= low) & (points[:, names.index(axis)] <= high)
    marks = []
    for place in np.flatnonzero(inside).tolist():
        x, y = points[place, names.index(across)], points[place, names.index(up)]
        category, layer = attractor_category(place, ""), 10 + place
        look: dict[str, Any] = {"color": category.colour, "markeredgecolor": "black", "markeredgewidth": 1.2}
        look |= {"path_effects": [withStroke(linewidth=3.0, foreground="white")], "linestyle": "none"}
        marks += axes.plot(x, y, "o", markersize=12, label="points of attractors", zorder=layer, **look)
        # the number within distinguishes them without colours
        text: dict[str, Any] = {"ha": "center", "va": "center_baseline", "fontsize": "small", "color": category.ink}
        axes.annotate(category.short, (x, y), zorder=layer, **text)
    return marks[:1]
