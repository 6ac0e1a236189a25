"""The complex plane with the unit circle, in which multipliers are seen."""

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

_NEAREST, _FARTHEST = 1.25, 1.5


def unit_circle(axes: "Axes", values: "NDArray[np.complex128]") -> int:
    """Draw the unit circle and set limits that hold it and, as far as they are near, the values.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    values : ndarray of complex
        Multipliers that will be drawn.

    Returns
    -------
    int
        How many of them lie outside of the limits.
    """
    from matplotlib.patches import Circle

    finite = values[np.isfinite(values)]
    size = np.maximum(np.abs(finite.real), np.abs(finite.imag))
    near = size[size <= _FARTHEST]
    reach = max(_NEAREST, 1.08 * float(near.max(initial=0.0)))
    for line in (axes.axhline, axes.axvline):
        line(0, color="0.8", linewidth=0.6, zorder=0)
    axes.add_patch(Circle((0, 0), 1, facecolor="none", edgecolor="0.35", linewidth=0.9, zorder=1))
    axes.set(xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal", xlabel="real part", ylabel="imaginary part")
    return int((size > reach).sum())
