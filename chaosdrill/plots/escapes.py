"""Transient chaos: the share of surviving runs over their age, and the saddle from which they leave."""

import numpy as np

from chaosdrill.plots._types import Axes, Dataset, Figure
from chaosdrill.plots.figures import legend_inside, stacked
from chaosdrill.plots.labels import exponent_text, label, state_label, uncertain
from chaosdrill.plots.palette import PALETTE
from chaosdrill.plots.pictures import picture
from chaosdrill.plots.tuning import TUNING


@picture("transient-chaos", "transient-chaos", "share of surviving runs over age, with the escape rate; the saddle")
def escapes(dataset: Dataset) -> Figure:
    """Draw the share of runs that survive, and points on the saddle.

    The surviving share over the age, on a logarithmic scale, with the line of the escape rate from the least age on;
    below, states near the saddle in the plane of the first two states that move, with the exponents, the dimension and,
    by stagger-and-step, the rate at which it is left, as far as any were found.
    """
    points = dataset["saddle_state"].values
    moving = np.flatnonzero(np.ptp(points, axis=0) > 0) if len(points) else np.zeros(0, dtype=int)
    with_saddle = len(moving) > 0
    figure, panels = stacked([TUNING.survival_height, TUNING.saddle_height][: 1 + with_saddle], 0.7)
    _draw_survival(panels[0], dataset)
    if with_saddle:
        _draw_saddle(panels[1], dataset, moving.tolist())
    return figure


def _draw_survival(axes: Axes, dataset: Dataset) -> None:
    age, alive = dataset["age"].values, dataset["surviving"].values
    axes.step(age, np.where(alive > 0, alive, np.nan), where="post", color=PALETTE[0], label="runs")
    rate, error, least = (float(dataset[name]) for name in ("escape_rate", "escape_rate_error", "least_age"))
    if np.isfinite(rate):
        last = age[alive > 0][-1]
        along = np.array([least, max(last, least)])
        height = np.interp(least, age, alive) * np.exp(-rate * (along - least))
        axes.plot(along, height, color=PALETTE[1], linestyle="--", label=f"escape rate {uncertain(rate, error)}")
        axes.set_xlim(0, 1.05 * along[-1])
    axes.set(yscale="log", xlabel=label(dataset["age"]), ylabel=label(dataset["surviving"]))
    legend_inside(axes, loc="upper right")


def _draw_saddle(axes: Axes, dataset: Dataset, moving: list[int]) -> None:
    points, exponents = dataset["saddle_state"].values, dataset["lyapunov_exponent"].values
    if len(moving) > 1:
        axes.plot(points[:, moving[0]], points[:, moving[1]], ".", color=PALETTE[0], markersize=3)
        axes.set_ylabel(state_label(dataset, moving[1]))
    else:
        axes.hist(points[:, moving[0]], bins=64, color=PALETTE[0])
        axes.set_ylabel("points")
    axes.set_xlabel(state_label(dataset, moving[0]))
    told = [
        exponent_text(k + 1, value, error)
        for k, (value, error) in enumerate(zip(exponents, dataset["lyapunov_error"].values, strict=True))
        if np.isfinite(value)
    ]
    told = told[:4]
    for name, sign in (("saddle_dimension", "D = "), ("saddle_rate", "left at ")):
        value, error = (float(dataset[one]) for one in (name, f"{name}_error"))
        told += [sign + uncertain(value, error)] if np.isfinite(value) else []
    axes.set_title(f"saddle: {', '.join(told)}")
