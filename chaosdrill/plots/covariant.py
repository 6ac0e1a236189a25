"""Covariant vectors: their directions, and the angles between their subspaces."""

import numpy as np

from chaosdrill.plots._types import Axes, Dataset, Figure
from chaosdrill.plots.figures import legend_above, legend_outside, stacked
from chaosdrill.plots.labels import exponent_text, label, state_label, subscript
from chaosdrill.plots.palette import PALETTE
from chaosdrill.plots.pictures import picture
from chaosdrill.plots.tuning import TUNING


@picture("covariant-vectors", "covariant-vectors", "covariant vectors in the plane of two states, angles between them")
def covariant(dataset: Dataset) -> Figure:
    """Draw the covariant vectors in the plane of the first two states, and the distributions of angles.

    The states as dots, with the vectors at up to 150 of them as lines of equal length in the plane; below, the density
    of the angle between the first vectors and the others, with the smallest angle as a tick at the bottom. Panels
    without enough states or vectors are left out.
    """
    states, exponents = dataset["states"].values, dataset["lyapunov_exponent"].values
    shown = np.flatnonzero(np.isfinite(exponents))[: len(PALETTE)].tolist()
    splits = np.flatnonzero(np.isfinite(dataset["smallest_angle"].values))[: TUNING.most_splits].tolist()
    heights = [TUNING.panel_height] * (states.shape[1] > 1) + [TUNING.angles_height] * bool(splits)
    figure, panels = stacked(heights or [TUNING.angles_height], 0.9, least=1.2 + 2 * TUNING.low * len(heights))
    if not heights:
        panels[0].set_axis_off()
        panels[0].set_title("one state, one direction" if exponents.size else "no vectors")
        return figure
    if states.shape[1] > 1:
        _draw_plane(panels[0], dataset, shown)
        legend_outside(figure, panels[0].get_legend_handles_labels()[0][::-1], ncols=3)
    if splits:
        _draw_angles(panels[-1], dataset, splits)
    return figure


def _draw_plane(axes: Axes, dataset: Dataset, shown: list[int]) -> None:
    states, vectors = dataset["states"].values[:, :2], dataset["vector"].values[:, :2]
    axes.plot(*states.T, ".", color="0.65", markersize=2, zorder=1)
    kept = np.unique(np.linspace(0, len(states) - 1, TUNING.most_vectors).astype(int))
    extent = np.ptp(states[np.isfinite(states).all(axis=1)], axis=0) if np.isfinite(states).any() else np.ones(2)
    extent = np.where(extent > 0, extent, np.abs(vectors).max(axis=(0, 2), initial=1e-300))
    for i in reversed(shown):
        scaled = vectors[kept, :, i] / extent
        length = np.linalg.norm(scaled, axis=1, keepdims=True)
        half = (
            np.divide(scaled, length, out=np.zeros_like(scaled), where=length > 0) * (TUNING.vector_length / 2) * extent
        )
        ends = np.stack([states[kept] - half, states[kept] + half, np.full_like(half, np.nan)], axis=1).reshape(-1, 2)
        name = exponent_text(i + 1, *(dataset[f"lyapunov_{part}"].values[i] for part in ("exponent", "error")))
        axes.plot(*ends.T, color=PALETTE[i % len(PALETTE)], linewidth=1.1, label=name, zorder=2)
    axes.set(xlabel=state_label(dataset, 0), ylabel=state_label(dataset, 1))


def _draw_angles(axes: Axes, dataset: Dataset, splits: list[int]) -> None:
    centre = dataset["bin_centre"].values
    edges = np.linspace(0, np.pi / 2, len(centre) + 1)
    last = int(np.isfinite(dataset["lyapunov_exponent"].values).sum())
    for s in splits:
        colour, least = PALETTE[s % len(PALETTE)], float(dataset["smallest_angle"][s])
        first, others = _span(1, s + 1), _span(s + 2, last)
        axes.stairs(
            dataset["angle_histogram"].values[s], edges, color=colour, linewidth=1.2,
            label=f"{first} against {others}, least {least:.2g}",
        )  # fmt: skip
        axes.plot([least], [0.0], "^", color=colour, markersize=6, clip_on=False, zorder=3)
    axes.set_xlim(0, np.pi / 2)
    axes.set_xticks([0, np.pi / 8, np.pi / 4, 3 * np.pi / 8, np.pi / 2], ["0", "π/8", "π/4", "3π/8", "π/2"])
    axes.set_ylim(bottom=0)
    axes.set(xlabel=label(dataset["angle"]), ylabel="density")
    legend_above(axes, 2)


def _span(first: int, last: int) -> str:
    """Names of vectors in a row."""
    joined = " to " if last > first + 1 else ", "
    return joined.join(subscript("v", number) for number in dict.fromkeys((first, last)))
