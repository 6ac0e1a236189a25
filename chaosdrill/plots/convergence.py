"""Convergence of exponents: running means and standard errors."""

from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.plots.picture import picture
from chaosdrill.plots.style import MOST_PANELS, PALETTE, new_figure, subscript, uncertain

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# the scale of a panel is set by what the running mean does after this part of the run
_SETTLED = 0.05


@picture("lyapunov-spectrum", "convergence", "running means of the exponents")
def convergence(dataset: "xr.Dataset") -> "Figure":
    """Draw the running means of the finite exponents, of at most a dozen, over the length of the run.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of kind ``lyapunov-spectrum``.

    Returns
    -------
    matplotlib.figure.Figure
        One panel an exponent, each on its own scale, with the band of plus and minus one standard error that a run of
        that length has. Exponents of minus infinity have no curve: the title names them.
    """
    values = np.atleast_1d(dataset["lyapunov_exponent"].values)
    errors = np.atleast_1d(dataset["lyapunov_error"].values)
    every = np.flatnonzero(np.isfinite(values)).tolist()
    finite = every[:MOST_PANELS]
    figure = new_figure(1.2 + 1.5 * max(len(finite), 1))
    panels = np.atleast_1d(figure.subplots(max(len(finite), 1), 1, sharex=True))
    time = dataset["block_time"].values
    unit = "length of the run (units of time)"
    if "forcing_period" in dataset.variables:
        time = time / float(dataset["forcing_period"])
        unit = "length of the run (forcing periods)"
    for panel, i in zip(panels, finite, strict=False):
        history = dataset["lyapunov_history"].values[:, i]
        _panel(panel, time, history, float(values[i]), float(errors[i]))
        panel.set_ylabel(subscript("λ", i + 1))
        panel.set_title(f"{subscript('λ', i + 1)} = {uncertain(float(values[i]), float(errors[i]))}")
    panels[-1].set_xlabel(unit)
    figure.align_ylabels(list(panels))
    if len(finite):
        handles, _ = panels[0].get_legend_handles_labels()
        figure.legend(handles=handles, loc="outside upper right", ncols=2, handlelength=1.4)
    lost = [subscript("λ", i + 1) for i in np.flatnonzero(np.isneginf(values)).tolist()]
    told = [f"{' = '.join(lost)} = −∞ (direction lost at an event)"] if lost else []
    told += [f"the first {len(finite)} of {len(every)} exponents"] if len(finite) < len(every) else []
    if told:
        figure.suptitle("; ".join(told), x=0.01, ha="left", fontsize=9)
    if not len(finite):
        panels[0].set_axis_off()
    return figure


def _panel(panel: "Axes", time: np.ndarray, history: np.ndarray, value: float, error: float) -> None:
    panel.axhline(value, color="0.5", linewidth=0.7, zorder=1)
    if np.isfinite(error) and error > 0:
        width = error * np.sqrt(time[-1] / time)
        panel.fill_between(
            time,
            value - width,
            value + width,
            color=PALETTE[0],
            alpha=0.18,
            linewidth=0,
            zorder=0,
            label="± one standard error of a run of that length",
        )
    panel.plot(time, history, color=PALETTE[0], label="running mean")
    settled = history[time >= _SETTLED * time[-1]]
    reach = max(np.max(np.abs(settled - value)), 4 * error if np.isfinite(error) else 0.0, 1e-12 * abs(value), 1e-15)
    panel.set_ylim(value - 1.15 * reach, value + 1.15 * reach)
    panel.margins(x=0)
    panel.ticklabel_format(axis="y", useOffset=False)
    panel.locator_params(axis="y", nbins=4)
