"""Charts over two parameters, with a panel for each seed and a kind or a number in each cell."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.errors import SettingsError
from chaosdrill.plots.cells import bounds, draw_kinds, hatch, legend_entry
from chaosdrill.plots.picture import picture
from chaosdrill.plots.style import (
    MINUS_INFINITY,
    MOTIONS,
    NO_ATTRACTOR,
    NO_RESULT,
    POSITIVE,
    Category,
    axis_label,
    by_outcome,
    by_period,
    classify,
    diverging,
    label,
    legend_outside,
    new_figure,
    owner,
    progression,
    seed_names,
    sequential,
    shorten,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    import xarray as xr
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.colors import Colormap, Normalize
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

_MOST_PANELS = 9
_DARK = 0.45
_SIDE = 6.3
"""Width in inches that all panels of a row share."""
# the few points beyond this percentile on either side, near superstable cycles above all, do not set the scale
_EXPONENTS_COVERED = 99.0
_ERRORS, _ROUND_OFF = 3.0, 1e-9
"""An exponent is told from zero by so many standard errors, and by this part of the largest one of all."""
# the few points beyond this percentile, runs about to escape above all, do not set the scale
_RATES_COVERED = 99.9
# more steps of lightness than these are not told apart
_STEPS = 8


@dataclass(frozen=True)
class Chart:
    """A figure with a panel for each seed, or a single panel.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
    panels : list of (Axes, Dataset)
        Each with its part of the data, over the second and the first parameter in ascending order.
    x, y : ndarray
        Bounds of the cells.
    size : (float, float)
        Width and height of a panel in inches, about.
    """

    figure: "Figure"
    panels: "list[tuple[Axes, xr.Dataset]]"
    x: "NDArray[np.float64]"
    y: "NDArray[np.float64]"
    size: tuple[float, float]

    def legend(self, looks: "Sequence[Category]", further: "Sequence[Artist]" = (), ax: "Axes | None" = None) -> None:
        """Put one legend above all panels: looks, each named once, and what else is drawn over the cells."""
        handles = [*(legend_entry(look) for look in dict.fromkeys(looks)), *further]
        legend_outside(self.figure, handles, ax=ax, handlelength=1.6, handleheight=1.1, borderpad=0)


def chart(dataset: "xr.Dataset", *, seeds: bool = True, ax: "Axes | None" = None) -> Chart:
    """Lay out the panels of a picture over two parameters.

    Parameters
    ----------
    dataset : xarray.Dataset
        With ``outcome`` over the two parameters, and ``seed``.
    seeds : bool, default True
        A panel for each seed, at most nine, the rest of which the title counts; otherwise one panel.
    ax : matplotlib.axes.Axes, optional
        Where it is drawn; for one panel.

    Raises
    ------
    SettingsError
        Several panels, but one axes.
    """
    across, up = (str(name) for name in dataset["outcome"].dims if name != "seed")
    ordered = dataset.sortby([across, up]).transpose(up, across, ...)
    names = seed_names(dataset) if seeds else [""]
    parts = [ordered.isel(seed=i) if seeds else ordered for i in range(min(len(names), _MOST_PANELS))]
    columns = 1 if len(parts) == 1 else 2 if len(parts) <= 4 else 3
    rows = -(-len(parts) // columns)
    x, y = (bounds(ordered[name].values) for name in (across, up))
    if ax is not None:
        if len(names) > 1:
            raise SettingsError(
                f"ax is one, but there are {len(names)} seeds, each with a panel; choose one, as in ds.isel(seed=[0])"
            )
        figure = owner(ax)
        ax.set(xlabel=axis_label(dataset, across), ylabel=axis_label(dataset, up))
        box = ax.get_window_extent()
        return Chart(figure, [(ax, parts[0])], x, y, (box.width / figure.dpi, box.height / figure.dpi))
    width = _SIDE / columns
    height = 4.4 if columns == 1 else 0.8 * width
    figure = new_figure(1.0 + rows * (height + 0.15), max(dataset.sizes[across] / width, dataset.sizes[up] / height))
    grid = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    for axes in grid.flat[len(parts) :]:
        axes.set_axis_off()
    for place, axes in enumerate(grid.flat[: len(parts)]):
        if place + columns >= len(parts):
            axes.tick_params(labelbottom=True)
        if len(parts) > 1:
            axes.set_title(names[place] + _start(dataset, place))
        for name, set_ticks in ((across, axes.set_xticks), (up, axes.set_yticks)):
            if dataset.sizes[name] == 1:
                set_ticks(dataset[name].values)
    if len(parts) == 1:
        grid[0, 0].set(xlabel=axis_label(dataset, across), ylabel=axis_label(dataset, up))
    else:
        figure.supxlabel(axis_label(dataset, across), fontsize="medium")
        figure.supylabel(axis_label(dataset, up), fontsize="medium")
    if len(names) > len(parts):
        figure.suptitle(f"seeds 1 to {len(parts)} of {len(names)}", x=0.01, ha="left", fontsize=9)
    return Chart(figure, list(zip(grid.flat, parts, strict=False)), x, y, (width, height))


def _frame(dataset: "xr.Dataset") -> "xr.Dataset":
    """What a chart needs to know besides what it shows."""
    return dataset[[name for name in ("outcome", "initial_state") if name in dataset.variables]]


def _start(dataset: "xr.Dataset", seed: int) -> str:
    """Where a seed starts, told by the states in which the seeds differ; nothing if the archive does not tell."""
    if "initial_state" not in dataset.variables:
        return ""
    states = dataset["initial_state"].transpose("seed", "state").values
    names = dataset["state"].values
    apart = np.flatnonzero(np.ptp(states, axis=0) > 0)
    return ": " * bool(apart.size) + ", ".join(f"{names[i]} = {shorten(float(states[seed, i]))}" for i in apart)


def kind_chart(
    dataset: "xr.Dataset",
    kinds: "NDArray[np.int64]",
    looks: "Sequence[Category]",
    of: str,
    ax: "Axes | None" = None,
) -> "Figure":
    """Draw over two parameters what kind each point is of.

    Parameters
    ----------
    dataset : xarray.Dataset
        With ``outcome`` over the two parameters and ``seed``.
    kinds : ndarray
        Index of each point's look.
    looks : sequence of Category
    of : str
        Variable whose dimensions ``kinds`` has; without ``seed`` there is one panel.
    ax : matplotlib.axes.Axes, optional
        Where it is drawn.
    """
    drawn = kind_panels(dataset, kinds, looks, of, ax)
    drawn.legend(looks, ax=ax)
    return drawn.figure


def kind_panels(
    dataset: "xr.Dataset",
    kinds: "NDArray[np.int64]",
    looks: "Sequence[Category]",
    of: str,
    ax: "Axes | None" = None,
) -> Chart:
    """Draw the cells of `kind_chart` without a legend, for a picture that lays something over them."""
    dims = dataset[of].dims
    drawn = chart(_frame(dataset).assign(_kinds=(dims, kinds)), seeds="seed" in dims, ax=ax)
    for axes, part in drawn.panels:
        draw_kinds(axes, drawn.x, drawn.y, part["_kinds"].values, looks, drawn.size)
    return drawn


def value_chart(
    dataset: "xr.Dataset",
    values: "xr.DataArray",
    norm: "Normalize",
    colours: "Colormap",
    apart: "Sequence[tuple[float, Category]]" = (),
    extend: str = "neither",
    hatched: "tuple[NDArray[np.bool_], Category] | None" = None,
    ax: "Axes | None" = None,
) -> "Figure":
    """Draw a number over two parameters; points without one show how they ended.

    Parameters
    ----------
    dataset : xarray.Dataset
        With ``outcome`` over the two parameters and ``seed``.
    values : xarray.DataArray
        The numbers, over the same dimensions.
    norm, colours : matplotlib norm and colormap
    apart : sequence of (float, Category)
        Values that have looks of their own, such as minus infinity.
    extend : str
        At which ends the colour bar stands for more than it shows, in matplotlib's words.
    hatched : (ndarray, Category), optional
        Points that are hatched over their colour, and the look that says what they are.
    ax : matplotlib.axes.Axes, optional
        Where it is drawn.
    """
    from matplotlib.cm import ScalarMappable

    kinds, looks = by_outcome(dataset)
    looks = [NO_RESULT if look.name in MOTIONS else look for look in looks]
    kinds[np.isfinite(values.values)] = -1
    for value, look in apart:
        kinds[values.values == value] = len(looks)
        looks.append(look)
    marked, over = hatched if hatched is not None else (np.zeros(kinds.shape, dtype=bool), NO_RESULT)
    drawn = chart(
        _frame(dataset).assign(_shown=values, _kinds=(values.dims, kinds), _over=(values.dims, marked)), ax=ax
    )
    for axes, part in drawn.panels:
        numbers = part["_shown"].values
        shades = colours(norm(np.where(np.isfinite(numbers), numbers, 0)))[..., :3].astype(np.float32)
        draw_kinds(axes, drawn.x, drawn.y, part["_kinds"].values, looks, drawn.size, shades)
        # black dots are not seen on the dark ends of a scale, nor white ones on the rest
        dark = shades.mean(axis=-1) < _DARK
        for ground, mask in (("#FFFFFF", ~dark), ("#000000", dark)):
            hatch(axes, drawn.x, drawn.y, part["_over"].values & mask, replace(over, colour=ground), drawn.size)
    drawn.legend(
        [look for index, look in enumerate(looks) if (kinds == index).any()] + [over] * bool(marked.any()), ax=ax
    )
    bar = drawn.figure.colorbar(
        ScalarMappable(norm, colours), ax=[axes for axes, _ in drawn.panels], extend=extend, aspect=30, pad=0.02
    )
    bar.set_label(label(values))
    bar.outline.set_linewidth(0.5)
    return drawn.figure


@picture("parameter-chart", "isoperiodic-chart", "periods, and what there is instead")
def isoperiodic_chart(dataset: "xr.Dataset", *, ax: "Axes | None" = None) -> "Figure":
    """Draw the periods found over two parameters.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of kind ``parameter-chart``.
    ax : matplotlib.axes.Axes, optional
        Where one panel is drawn.

    Returns
    -------
    matplotlib.figure.Figure
        A panel for each seed; large regions carry their period.
    """
    kinds, looks = by_period(dataset)
    return kind_chart(dataset, kinds, looks, "period", ax)


@picture("parameter-chart", "lyapunov-chart", "largest exponent", needs="lyapunov_exponent")
def lyapunov_chart(dataset: "xr.Dataset", *, ax: "Axes | None" = None) -> "Figure":
    """Draw the largest exponent over two parameters.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of kind ``parameter-chart`` with exponents.
    ax : matplotlib.axes.Axes, optional
        Where one panel is drawn.

    Returns
    -------
    matplotlib.figure.Figure
        A panel for each seed. Zero is the palest colour, and each sign has a scale of its own, which numbers within
        three standard errors of zero do not set; minus infinity and points without a number stand apart. Dotted points
        are positive by more than that.
    """
    largest = dataset["lyapunov_exponent"].isel(exponent=0)
    largest.attrs["long_name"] = f"largest {largest.attrs['long_name']}"
    told = _told(dataset)
    norm, extend = _scale(np.where(told, largest.values, np.nan))
    positive = told & (largest.values > 0)
    return value_chart(
        dataset, largest, norm, diverging(), [(-np.inf, MINUS_INFINITY)], extend, (positive, POSITIVE), ax
    )


def _told(dataset: "xr.Dataset") -> "NDArray[np.bool_]":
    """Where the largest exponent is told from zero, that of the flow direction above all."""
    every = dataset["lyapunov_exponent"].values
    size = np.abs(dataset["lyapunov_exponent"].isel(exponent=0).values)
    least = np.array(_ROUND_OFF * np.abs(every[np.isfinite(every)]).max(initial=0.0))
    if "lyapunov_error" in dataset.variables:
        errors = dataset["lyapunov_error"].isel(exponent=0).values
        least = np.fmax(least, _ERRORS * errors)
    told: NDArray[np.bool_] = size > least
    return told


def _scale(values: np.ndarray) -> "tuple[Normalize, str]":
    """Norm with zero in the middle, and at which ends values lie beyond it."""
    from matplotlib.colors import TwoSlopeNorm

    finite = values[np.isfinite(values)]
    below, above = (part[part > 0] for part in (-finite, finite))
    low = float(np.percentile(below, _EXPONENTS_COVERED)) if below.size else 0.0
    high = float(np.percentile(above, _EXPONENTS_COVERED)) if above.size else 0.0
    # a sign that does not occur has the scale of the other
    low, high = low or high or 1.0, high or low or 1.0
    ends = (bool((below > low).any()), bool((above > high).any()))
    extend = {(False, False): "neither", (True, False): "min", (False, True): "max", (True, True): "both"}[ends]
    return TwoSlopeNorm(0.0, -low, high), extend


@picture("parameter-chart", "progression-chart", "mean progression rate", needs="progression_rate")
def progression_chart(dataset: "xr.Dataset", *, ax: "Axes | None" = None) -> "Figure":
    """Draw the mean progression rate over two parameters.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of kind ``parameter-chart`` of a system that progresses.
    ax : matplotlib.axes.Axes, optional
        Where one panel is drawn.

    Returns
    -------
    matplotlib.figure.Figure
        A panel for each seed; in SI units where the archive has them.
    """
    from matplotlib.colors import Normalize

    rate = progression(dataset)
    finite = rate.values[np.isfinite(rate.values)]
    top = float(np.percentile(finite, _RATES_COVERED, method="higher"))
    extend = "max" if finite.max() > top else "neither"
    return value_chart(dataset, rate, Normalize(min(0.0, finite.min()), top or 1.0), sequential(), extend=extend, ax=ax)


@picture("parameter-chart", "attractor-count-chart", "number of attractors among the seeds", seeds=2)
def attractor_count_chart(dataset: "xr.Dataset", *, ax: "Axes | None" = None) -> "Figure":
    """Draw how many attractors were found over two parameters.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of kind ``parameter-chart`` with several seeds.
    ax : matplotlib.axes.Axes, optional
        Where one panel is drawn.

    Returns
    -------
    matplotlib.figure.Figure
        One panel; large regions carry their number.
    """
    from matplotlib.colors import to_hex

    counts = dataset["attractor_count"].values
    most = min(int(counts.max()), _STEPS)
    # from the palest colour of that scale to its dark end: one attractor is nothing to be struck by
    shades = [to_hex(shade) for shade in diverging()(np.linspace(0.5, 0, max(most, 2)))]
    table = [(counts == 0, NO_ATTRACTOR)]
    for number in range(1, most + 1):
        last = number == _STEPS and counts.max() > _STEPS
        name = f"{number} or more attractors" if last else "1 attractor" if number == 1 else f"{number} attractors"
        mask = counts >= number if last else counts == number
        table.append((mask, Category(name, shades[number - 1], short=f"≥ {number}" if last else str(number))))
    kinds, looks = classify(table)
    return kind_chart(dataset, kinds, looks, "attractor_count", ax)


@picture("parameter-chart", "outcome-chart", "how the run of each point ended")
def outcome_chart(dataset: "xr.Dataset", *, ax: "Axes | None" = None) -> "Figure":
    """Draw the outcomes over two parameters.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of kind ``parameter-chart``.
    ax : matplotlib.axes.Axes, optional
        Where one panel is drawn.

    Returns
    -------
    matplotlib.figure.Figure
        A panel for each seed.
    """
    kinds, looks = by_outcome(dataset)
    return kind_chart(dataset, kinds, looks, "outcome", ax)
