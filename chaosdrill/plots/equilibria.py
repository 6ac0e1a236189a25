"""Equilibria and their eigenvalues, and branches of equilibria over a parameter."""

from itertools import pairwise
from typing import Any

import numpy as np

from chaosdrill.dataset.outcomes import flag_names
from chaosdrill.plots._types import Axes, Dataset, Figure, Integers, States
from chaosdrill.plots.contents import limits, places_of, swept
from chaosdrill.plots.figures import is_narrow, legend_outside, new_figure, note, one_panel
from chaosdrill.plots.labels import axis_label, readable, state_label, wrapped
from chaosdrill.plots.markers import mark, named_once, soft_and_hard, tell
from chaosdrill.plots.palette import BACKGROUND, LINE_COLOURS
from chaosdrill.plots.pictures import picture
from chaosdrill.plots.sections import first_that_varies
from chaosdrill.plots.tuning import TUNING

_SHAPES = {"node": "o", "focus": "D", "saddle": "X", "saddle_focus": "P", "centre": "s", "degenerate": "*"}
"""Shape of each type of equilibrium; filled where it is stable."""

_LOOKS: dict[str, tuple[Any, float]] = {
    "stable": ("-", 1.6),
    "unstable": ((0, (4, 2)), 1.1),
    "virtual": ((0, (1, 1.6)), 1.0),
}
"""Dashes and width of the curves of each kind."""


@picture("equilibria", "branches", "branches of equilibria over the parameter with what happens on them", parameters=1)
def branches(dataset: Dataset, ax: Axes | None = None, state: States = None) -> Figure:
    """Draw branches of equilibria over the parameter.

    A colour a mode, solid where the equilibrium is stable and dashed where it is not; grey and dotted where it is
    virtual. Special points have a shape a kind, black where a cycle is born hard, and a bar leads from each Hopf point
    to the extent of the predicted cycle beside it. ``state``: state that is drawn; default: the first that varies.
    """
    (name,) = swept(dataset)
    states = dataset["equilibrium_state"].values
    index = (first_that_varies(states) if len(states) else 0) if state is None else places_of(dataset, state, 1)[0]
    figure, axes = one_panel(ax, 4.2)
    low, high = limits(dataset)[name]
    edge = 0.02 * (high - low)
    axes.set_xlim(low - edge, high + edge)
    x, y = dataset[name].values, states[:, index]
    modes = flag_names(dataset["mode"])
    used = [int(code) for code in np.unique(dataset["mode"].values)]
    colours = {code: LINE_COLOURS[k % len(LINE_COLOURS)] for k, code in enumerate(used)}
    drawn = set()
    for number in np.unique(dataset["branch"].values):
        points = np.flatnonzero(dataset["branch"].values == number)
        for first, last in _stretches(dataset, points):
            part = points[first : last + 1]
            inner = part[len(part) // 2] if len(part) > 2 else part[-1]
            virtual, stable = dataset["admissible"].values[inner] == 1, dataset["stable"].values[inner] != 0
            kind = "virtual" if virtual else "stable" if stable else "unstable"
            drawn.add(kind)
            dashes, width = _LOOKS[kind]
            colour = BACKGROUND if virtual else colours[int(dataset["mode"].values[inner])]
            axes.plot(x[part], y[part], color=colour, linestyle=dashes, linewidth=width, zorder=2 if virtual else 3)
    if len(used) > 1:
        for code in used:
            axes.plot([], [], color=colours[code], linewidth=1.8, label=f"mode {modes[code]}")
    for kind, (dashes, _) in _LOOKS.items():
        if kind in drawn:
            colour = BACKGROUND if kind == "virtual" else "0.25"
            axes.plot([], [], color=colour, linestyle=dashes, linewidth=1.2, label=kind)
    _cycles(axes, dataset, index)
    for kind, off, points in soft_and_hard(dataset):
        mark(axes, x[points], y[points], kind, TUNING.special_mark, jumps=off)
    axes.set(xlabel=axis_label(dataset, name), ylabel=state_label(dataset, index))
    legend_outside(figure, named_once(axes), ax=ax, handlelength=2.0)
    if ax is None:
        tell(figure, _nothing(dataset))
    figure.set_label("branches of equilibria and their special points")
    return figure


def _nothing(dataset: Dataset) -> str:
    """Why there is nothing to see; empty where there is something."""
    if dataset.sizes["point"]:
        return ""
    return wrapped(f"no equilibrium found. {dataset.attrs.get('message', '')}", 90)


def _stretches(dataset: Dataset, points: Integers) -> list[tuple[int, int]]:
    """First and last of the points of a branch between which nothing changes; special points belong to both sides."""
    cuts = {0, len(points) - 1, *np.flatnonzero(dataset["special_point"].values[points] != 0).tolist()}
    told = dataset["stable"].values[points] + 2 * (dataset["admissible"].values[points] == 1)
    plain = dataset["special_point"].values[points] == 0
    both = plain[:-1] & plain[1:] & (told[:-1] != told[1:])
    cuts |= set((np.flatnonzero(both) + 1).tolist())
    return list(pairwise(sorted(cuts)))


def _cycles(axes: Axes, dataset: Dataset, index: int) -> None:
    """Bars from each Hopf point to the extent of the cycle that is born there."""
    born = np.flatnonzero(np.isfinite(dataset["cycle_value"].values))
    if not born.size:
        return
    at = dataset["equilibrium_state"].values[dataset["special_index"].values[born], index]
    extent = dataset["cycle_amplitude"].values[born, index]
    look: dict[str, Any] = {"linestyle": "none", "color": "0.25", "elinewidth": 1.1, "capsize": 3, "zorder": 3}
    words = "extent of the cycle\nborn, as predicted"
    axes.errorbar(dataset["cycle_value"].values[born], at, yerr=extent, label=words, **look)


@picture("equilibria", "equilibria", "the equilibria and their eigenvalues", sweeps=False)
def equilibria(dataset: Dataset, state: States = None) -> Figure:
    """Draw equilibria in the plane of two states, and their eigenvalues in the complex plane.

    A shape a type, filled where the equilibrium is stable, grey where it is virtual; the number of each stands beside
    it, and its eigenvalues have its shape and colour. Beside a system of one state numbers take the place of the second
    one. ``state``: states that are drawn; default: the first two.
    """
    stacked = is_narrow()
    figure = new_figure(3.6, least=4.6 if stacked else 0.0)
    left, right = figure.subplots(*((2, 1) if stacked else (1, 2)))
    chosen = places_of(dataset, state, min(dataset.sizes["state"], 2))
    values = dataset["equilibrium_state"].values
    x = values[:, chosen[0]]
    y = values[:, chosen[1]] if len(chosen) > 1 else np.arange(1.0, len(x) + 1)
    types, modes = flag_names(dataset["type"]), flag_names(dataset["mode"])
    several = len(np.unique(dataset["mode"].values)) > 1
    spectrum = dataset["eigenvalue_real"].values + 1j * dataset["eigenvalue_imag"].values
    right.axvline(0, color="0.35", linewidth=0.9, zorder=1)
    right.axhline(0, color="0.8", linewidth=0.6, zorder=0)
    for k in range(len(x)):
        kind, stable = types[int(dataset["type"].values[k])], dataset["stable"].values[k] != 0
        virtual = dataset["admissible"].values[k] == 1
        colour = BACKGROUND if virtual else LINE_COLOURS[(k % (len(LINE_COLOURS) - 1)) + 1]
        options: dict[str, Any] = {
            "linestyle": "none",
            "marker": _SHAPES.get(kind, "*"),
            "markersize": 7.0,
            "markeredgecolor": colour,
            "markerfacecolor": colour if stable else "white",
            "markeredgewidth": 1.2,
            "zorder": 3,
        }
        mode = f"mode {modes[int(dataset['mode'].values[k])]}" if several else ""
        told = (readable(kind), "stable" if stable else "unstable", mode, "virtual" if virtual else "")
        words = ", ".join(filter(None, told))
        left.plot(x[k], y[k], **options, label=f"{k + 1}: {words}")
        note(left, str(k + 1), (x[k], y[k]), (5, 5))
        right.plot(spectrum[k].real, spectrum[k].imag, **options)
    left.margins(0.15)
    left.locator_params(nbins=5)
    right.margins(0.12)
    left.set_xlabel(state_label(dataset, chosen[0]))
    left.set_ylabel(state_label(dataset, chosen[1]) if len(chosen) > 1 else "number of the equilibrium")
    right.set(xlabel="real part", ylabel="imaginary part", title="eigenvalues")
    handles, _ = left.get_legend_handles_labels()
    legend_outside(figure, handles, handlelength=1.2)
    tell(figure, _nothing(dataset))
    figure.set_label("equilibria and their eigenvalues")
    return figure
