"""Poincare section: the states of all iterates in the plane of the first two."""

import json
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.plots.picture import picture
from chaosdrill.plots.style import PALETTE, one_panel, places_of, shorten, state_label

if TYPE_CHECKING:
    from collections.abc import Sequence

    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


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
        axes.scatter(x, y, s=size, color=PALETTE[0], linewidth=0, rasterized=len(section) > 5000)
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


def _title(dataset: "xr.Dataset", period: int, iterates: int) -> str:
    place = json.loads(dataset.attrs.get("settings", "{}")).get("at") or "strobe"
    where = "once a forcing period" if place == "strobe" else f"at {place}"
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


def _complex(real: float, imaginary: float) -> str:
    return shorten(real) if imaginary == 0 else f"{shorten(real)} ± {shorten(imaginary)}i"
