"""Poincare section: the states of all iterates in the plane of the first two, and each against the one before."""

from typing import TYPE_CHECKING, Any

import numpy as np

from chaosdrill.plots.bifurcation import first_that_varies, seed_lines
from chaosdrill.plots.companions import settings, swept
from chaosdrill.plots.picture import picture
from chaosdrill.plots.style import (
    PALETTE,
    axis_label,
    legend_outside,
    one_panel,
    places_of,
    shorten,
    state_label,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_ONE_POINT = 1e-5
_MANY = 5000
"""Points that a vector format holds as one image."""
_STEPS = 40
"""Returns that a cobweb shows from the first point on: more fill the picture."""


@picture("poincare-section", "poincare-section", "the section in the plane of the first two states")
def poincare(
    dataset: "xr.Dataset", *, ax: "Axes | None" = None, state: "str | Sequence[str] | None" = None
) -> "Figure":
    """Draw a section.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of kind ``poincare-section``; a system with one state is drawn against the number of the iterate.
    ax : matplotlib.axes.Axes, optional
        Where it is drawn.
    state : pair of str, optional
        States of the plane; default: the first two.

    Returns
    -------
    matplotlib.figure.Figure
        The points; the title names the place of the section, the period found and the multipliers.
    """
    section = dataset["section"].values
    period = int(dataset["period"]) if "period" in dataset.variables else 0
    figure, axes = one_panel(ax, 4.4)
    plane = section.shape[1] > 1
    first, *second = _plane(section) if plane and state is None else places_of(dataset, state, 2)
    x = section[:, first] if plane else np.arange(len(section))
    y = section[:, second[0]] if plane else section[:, first]
    if period:
        axes.scatter(x[-period:], y[-period:], s=34, color=PALETTE[1], edgecolor="white", linewidth=0.5)
        axes.margins(0.25)
    else:
        size = float(np.clip(6e3 / max(len(section), 1), 0.6, 9.0))
        axes.scatter(x, y, s=size, color=PALETTE[0], linewidth=0, rasterized=len(section) > _MANY)
    axes.set_xlabel(state_label(dataset, first) if plane else "iterate")
    axes.set_ylabel(state_label(dataset, second[0] if plane else first))
    axes.set_title(_title(dataset, period, len(section)))
    return figure


def _plane(section: np.ndarray) -> tuple[int, int]:
    """Return the first two states that are not one value on the whole section, as one is on a surface."""
    size = np.abs(section).max(axis=0, initial=1.0)
    varies = np.ptp(section, axis=0) > 1e-9 * size if len(section) else np.ones(section.shape[1], dtype=bool)
    first, second = sorted(np.argsort(~varies, kind="stable")[:2].tolist())
    return first, second


@picture("poincare-section", "return-map", "each point of the section against the one before it, with its cobweb")
@picture(
    "bifurcation-diagram",
    "return-map",
    "each point of the section against the one before it, at one value of the parameter",
    values=1,
)
def return_map(
    dataset: "xr.Dataset", *, ax: "Axes | None" = None, state: "str | Sequence[str] | None" = None
) -> "Figure":
    """Draw one state of each point of a section against that of the point before.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of kind ``poincare-section``, or ``bifurcation-diagram`` with one value of the parameter.
    ax : matplotlib.axes.Axes, optional
        Where it is drawn.
    state : str, optional
        State that is drawn; default: the first that varies.

    Returns
    -------
    matplotlib.figure.Figure
        The points with the diagonal, and the cobweb of the first 40 returns as a thin line: a transient, if the record
        begins with one. That of a cycle that was found is a thick line. A colour a seed.
    """
    varied = swept(dataset)
    ordered = dataset.transpose(*varied, "seed", "iterate", "state", ..., missing_dims="ignore")
    states = ordered["section"].values.reshape(-1, dataset.sizes["iterate"], dataset.sizes["state"])
    index = first_that_varies(states) if state is None else places_of(dataset, state, 1)[0]
    periods = np.ravel(ordered["period"].values) if "period" in dataset.variables else np.zeros(1)
    figure, axes = one_panel(ax, 5.4)
    lines = seed_lines(dataset) if varied else [(PALETTE[0], "", 0.0)]
    for values, period, (colour, name, _) in zip(states[..., index], periods.astype(int), lines, strict=True):
        last = int(np.flatnonzero(np.isfinite(values))[-1]) if np.isfinite(values).any() else 0
        axes.plot(*cobweb(values[: _STEPS + 1]), color=colour, linewidth=0.5, alpha=0.6)
        if 0 < period <= last:
            axes.plot(*cobweb(values[last - period : last + 1]), color=colour, linewidth=1.5)
        size = float(np.clip(np.sqrt(6e3 / max(last, 1)), 1.0, 4.0))
        dots: dict[str, Any] = {"linestyle": "none", "marker": "o", "color": colour, "markeredgewidth": 0}
        axes.plot(values[:-1], values[1:], markersize=size, rasterized=len(values) > _MANY, **dots)
        axes.plot([], [], markersize=4, label=name or "point", **dots)
    inside = states[..., index][np.isfinite(states[..., index])]
    if inside.size:
        extent, size = float(np.ptp(inside)), float(np.abs(inside).max())
        # what is left of a transient beyond the digits of an axis is one point
        edge = 0.05 * (extent if extent > _ONE_POINT * size else size) or 1.0
        ends = (float(inside.min()) - edge, float(inside.max()) + edge)
        axes.plot(ends, ends, color="0.5", linewidth=0.8, zorder=1, label="diagonal")
        axes.set(xlim=ends, ylim=ends)
    text = state_label(dataset, index)
    axes.ticklabel_format(useOffset=False)
    axes.locator_params(nbins=6)
    axes.set(aspect="equal", xlabel=f"{text}, at one point", ylabel=f"{text}, at the next")
    legend_outside(figure, axes.get_legend_handles_labels()[0], ax=ax)
    at = [f"{axis_label(dataset, name)} = {shorten(float(dataset[name].values[0]))}" for name in varied]
    axes.set_title(", ".join([*at, _place(dataset)]))
    return figure


def cobweb(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the line from the diagonal up or down to the next value, across to the diagonal, and so on."""
    return np.repeat(values, 2)[:-1], np.repeat(values, 2)[1:]


def _title(dataset: "xr.Dataset", period: int, iterates: int) -> str:
    where = _place(dataset)
    if not period:
        return f"{iterates} points {where}"
    multipliers = (
        [
            _complex(real, imaginary)
            for real, imaginary in zip(
                np.atleast_1d(dataset["multiplier_real"].values),
                np.atleast_1d(dataset["multiplier_imag"].values),
                strict=True,
            )
            if np.isfinite(real) and imaginary >= 0
        ]
        if "multiplier_real" in dataset.variables
        else []
    )
    return f"period {period}, {where}" + (f"; multipliers {', '.join(multipliers)}" if multipliers else "")


def _place(dataset: "xr.Dataset") -> str:
    place = settings(dataset).get("at") or "strobe"
    return "once a forcing period" if place == "strobe" else f"at {place}"


def _complex(real: float, imaginary: float) -> str:
    return shorten(real) if imaginary == 0 else f"{shorten(real)} ± {shorten(imaginary)}i"
