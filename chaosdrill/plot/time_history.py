"""Time history: every quadrature and state over time, with the events and the modes marked."""

from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.plot.curve import Curve, join, last_part
from chaosdrill.plot.style import (
    EVENT_MARKERS,
    MODE_SHADES,
    PALETTE,
    flag_names,
    label,
    new_figure,
    readable,
    state_label,
    wrapped,
)

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# more events than this on one page cannot be told apart
_EVENTS = 40


def time_history(dataset: "xr.Dataset") -> "Figure":
    """Draw the end of a trajectory.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of kind ``trajectory``.

    Returns
    -------
    matplotlib.figure.Figure
        One panel for each quadrature and state. Shades are modes, markers are events at the state before the reset; a
        trajectory with many events is shown from a whole forcing period on, and the title says so.
    """
    shown = last_part(dataset, _EVENTS)
    curve = join(shown)
    quadratures = [str(name) for name in shown.data_vars if shown[name].dims == ("time",) and name != "mode"]
    names = [str(name) for name in shown["state_name"].values]
    figure = new_figure(1.0 + 1.35 * (len(quadratures) + len(names)))
    panels = np.atleast_1d(figure.subplots(len(quadratures) + len(names), 1, sharex=True))

    for panel, name in zip(panels, quadratures, strict=False):
        panel.plot(shown["time"], shown[name], color=PALETTE[0])
        panel.set_ylabel(wrapped(label(shown[name])))
    for i, panel in enumerate(panels[len(quadratures) :]):
        panel.plot(curve.time, curve.state[:, i], color=PALETTE[0])
        _mark_events(panel, shown, i)
        panel.set_ylabel(wrapped(state_label(shown, i)))
    modes = flag_names(shown["mode"])
    for panel in panels:
        _shade(panel, curve, modes)
        panel.margins(x=0)
    panels[-1].set_xlabel(label(shown["time"]))
    figure.align_ylabels(list(panels))
    _legend(figure, panels[-1], curve, modes)
    if shown is not dataset:
        panels[0].set_title(_title(shown, dataset))
    return figure


def _mark_events(panel: "Axes", shown: "xr.Dataset", i: int) -> None:
    kinds = shown["event_kind"].values
    for number, (code, name) in enumerate(flag_names(shown["event_kind"]).items() if kinds.size else ()):
        hit = kinds == code
        if hit.any():
            panel.plot(
                shown["event_time"].values[hit],
                shown["event_state_before"].values[hit, i],
                EVENT_MARKERS[number % len(EVENT_MARKERS)],
                color=PALETTE[1 + number % (len(PALETTE) - 1)],
                markersize=4,
                markeredgecolor="white",
                markeredgewidth=0.4,
                label=readable(name),
                clip_on=False,
                zorder=3,
            )


def _shade(panel: "Axes", curve: Curve, modes: dict[int, str]) -> None:
    codes = list(modes)
    for start, end, mode in curve.bands():
        shade = codes.index(mode) % len(MODE_SHADES)
        if shade:
            panel.axvspan(start, end, color=MODE_SHADES[shade], linewidth=0, zorder=0)


def _legend(figure: "Figure", panel: "Axes", curve: Curve, modes: dict[int, str]) -> None:
    from matplotlib.patches import Patch

    handles, _ = panel.get_legend_handles_labels()
    if len(modes) > 1:
        present = set(curve.mode.tolist())
        for number, (code, name) in enumerate(modes.items()):
            if code in present:
                shade = MODE_SHADES[number % len(MODE_SHADES)]
                handles.append(Patch(facecolor=shade, edgecolor="0.6", linewidth=0.5, label=f"{readable(name)} (mode)"))
    if handles:
        figure.legend(handles=handles, loc="outside upper right", ncols=min(len(handles), 6), handlelength=1.4)


def _title(shown: "xr.Dataset", dataset: "xr.Dataset") -> str:
    part, whole = (float(np.ptp(record["time"].values)) for record in (shown, dataset))
    if "forcing_period" in dataset.variables:
        period = float(dataset["forcing_period"])
        return f"last {part / period:.0f} of {whole / period:.0f} forcing periods"
    return f"last {part:.4g} of {whole:.4g} units of time"
