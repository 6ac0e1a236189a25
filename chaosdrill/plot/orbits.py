"""All periodic orbits that a search found: their points on the section, and their multipliers."""

from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.plot.marks import warn
from chaosdrill.plot.style import PALETTE, legend_outside, new_figure, state_label
from chaosdrill.plot.unit_circle import unit_circle

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

_MARKERS = ("o", "s", "^", "D", "v", "P", "X")


def orbits(dataset: "xr.Dataset") -> "Figure":
    """Draw the orbits that a search found.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of kind ``periodic-orbit`` with the dimension ``orbit``.

    Returns
    -------
    matplotlib.figure.Figure
        On the left all points on the section, a shape and colour a period, filled where the orbit is stable; in the
        plane of the first two states, or against the number of the orbit for a system with one state. On the right the
        multipliers in the unit circle.
    """
    section, period = dataset["section"].values, dataset["period"].values.astype(np.int64)
    stable = dataset["stable"].values != 0
    values = dataset["multiplier_real"].values + 1j * dataset["multiplier_imag"].values
    figure = new_figure(4.0)
    left, right = figure.subplots(1, 2, width_ratios=[1.5, 1.0])
    outside = unit_circle(right, values.ravel())
    plane = section.shape[2] > 1
    shortest_first = np.unique(period)
    # a shorter orbit has fewer points, which lie on top
    for place, length in reversed(list(enumerate(shortest_first))):
        colour, marker = PALETTE[place % len(PALETTE)], _MARKERS[place % len(_MARKERS)]
        for attracts in (False, True):
            here = np.flatnonzero((period == length) & (stable == attracts))
            if not here.size:
                continue
            points = section[here]
            x = points[..., 0] if plane else np.broadcast_to(here[:, None] + 1.0, points.shape[:2])
            y = points[..., 1 if plane else 0]
            look = {"linestyle": "none", "marker": marker, "markersize": 5, "color": colour}
            look |= {} if attracts else {"markerfacecolor": "white"}
            count = f"{here.size} {'stable' if attracts else 'unstable'}"
            left.plot(x.ravel(), y.ravel(), zorder=3, label=f"period {length}: {count}", **look)
            right.plot(values[here].real.ravel(), values[here].imag.ravel(), zorder=3, **look)
    left.set_xlabel(state_label(dataset, 0) if plane else "number of the orbit")
    left.set_ylabel(state_label(dataset, 1 if plane else 0))
    left.margins(0.08)
    if outside:
        right.set_title(f"{outside} of {np.isfinite(values).sum()} multipliers\nlie outside of the picture", fontsize=8)
    handles, _ = left.get_legend_handles_labels()
    legend_outside(figure, handles[::-1], handlelength=1.2)
    warn(figure, [dataset])
    return figure
