"""Bifurcation diagram: the section over the swept parameter, with spectrum, progression and outcome under it."""

from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.plot.style import (
    PALETTE,
    flag_names,
    label,
    legend_above,
    new_figure,
    outcome_colour,
    readable,
    state_label,
    subscript,
    wrapped,
)

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def bifurcation(dataset: "xr.Dataset") -> "Figure":
    """Draw a bifurcation diagram.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of kind ``bifurcation-diagram`` over one parameter.

    Returns
    -------
    matplotlib.figure.Figure
        From top to bottom, over the same axis: the first state on the section (a colour a seed), the exponents with
        zero marked, the progression rate where the system has one, and a strip with the outcome of every point.
    """
    sweep = str(dataset["period"].dims[0])
    has_spectrum = "lyapunov_exponent" in dataset.variables
    has_rate = "progression_rate" in dataset.variables and bool(np.isfinite(dataset["progression_rate"]).any())
    seeds = dataset.sizes["seed"]
    heights = [2.6] + [1.7] * has_spectrum + [1.0] * has_rate + [0.09 + 0.09 * seeds]
    figure = new_figure(1.2 + sum(heights))
    panels = list(figure.subplots(len(heights), 1, sharex=True, height_ratios=heights))
    _section(panels[0], dataset, sweep)
    if has_spectrum:
        _spectrum(panels[1], dataset, sweep)
    if has_rate:
        _rate(panels[-2], dataset, sweep)
    _outcomes(panels[-1], dataset, sweep)
    panels[-1].set_xlabel(label(dataset[sweep]))
    x = dataset[sweep].values
    panels[-1].set_xlim(x.min(), x.max())
    figure.align_ylabels(panels[:-1])
    return figure


def _section(panel: "Axes", dataset: "xr.Dataset", sweep: str) -> None:
    section = dataset["section"].transpose(sweep, "seed", "iterate", "state").values[..., 0]
    period = dataset["period"].transpose(sweep, "seed").values
    x = dataset[sweep].values
    # a cloud has many small points, a cycle few that stand out
    cloud = float(np.clip(4e4 / max(section.size, 1), 0.35, 2.0))
    for seed in range(section.shape[1]):
        panel.scatter(
            np.repeat(x, section.shape[2]),
            section[:, seed].ravel(),
            s=np.repeat(np.where(period[:, seed] > 0, 0.8, cloud), section.shape[2]),
            color="black" if section.shape[1] == 1 else PALETTE[seed % len(PALETTE)],
            linewidth=0,
            rasterized=True,
            label=f"seed {seed + 1}",
        )
    panel.set_ylabel(state_label(dataset, 0))
    if section.shape[1] > 1:
        legend_above(panel, markerscale=4)


def _spectrum(panel: "Axes", dataset: "xr.Dataset", sweep: str) -> None:
    exponents = dataset["lyapunov_exponent"].transpose(sweep, "seed", "exponent").values
    x = dataset[sweep].values
    panel.axhline(0, color="0.5", linewidth=0.7, zorder=1)
    for i in range(exponents.shape[2]):
        values = exponents[:, :, i]
        known = ~np.isnan(values)
        lost = np.isneginf(values)
        if known.any() and lost[known].all():
            panel.plot([], [], linestyle="none", label=f"{subscript('λ', i + 1)} = −∞")
            continue
        name = subscript("λ", i + 1) + (" (−∞ where absent)" if lost.any() else "")
        for seed in range(values.shape[1]):
            shown = np.where(np.isfinite(values[:, seed]), values[:, seed], np.nan)
            panel.plot(x, shown, color=PALETTE[i % len(PALETTE)], linewidth=0.8, label=name if seed == 0 else None)
    panel.set_ylabel(label(dataset["lyapunov_exponent"]))
    legend_above(panel)


def _rate(panel: "Axes", dataset: "xr.Dataset", sweep: str) -> None:
    name = "progression_rate_si" if "progression_rate_si" in dataset.variables else "progression_rate"
    rates = dataset[name].transpose(sweep, "seed").values
    for seed in range(rates.shape[1]):
        colour = "black" if rates.shape[1] == 1 else PALETTE[seed % len(PALETTE)]
        panel.plot(dataset[sweep].values, rates[:, seed], color=colour, linewidth=0.8)
    panel.set_ylabel(wrapped(label(dataset[name]), 12))


def _outcomes(panel: "Axes", dataset: "xr.Dataset", sweep: str) -> None:
    from matplotlib.colors import to_rgb
    from matplotlib.patches import Patch

    codes = dataset["outcome"].transpose("seed", sweep).values
    names = flag_names(dataset["outcome"])
    x = dataset[sweep].values
    # a cell reaches half way to its neighbours
    middle = (x[1:] + x[:-1]) / 2
    edges = np.concatenate([[x[0]], middle, [x[-1]]])
    colours = np.array([[to_rgb(outcome_colour(names[int(code)])) for code in row] for row in codes])
    panel.pcolormesh(edges, np.arange(codes.shape[0] + 1), colours, rasterized=True)
    panel.set_yticks([])
    panel.spines["left"].set_visible(False)
    present = [code for code in names if (codes == code).any()]
    handles = [Patch(color=outcome_colour(names[code]), label=readable(names[code])) for code in present]
    legend_above(panel, handles=handles)
