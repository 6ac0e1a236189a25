"""Number of attractors that the seeds of each point lead to, over two parameters."""

from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.plot.chart import kind_chart
from chaosdrill.plot.looks import NO_ATTRACTOR, Look, diverging, sort_out

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

# more steps of lightness than these are not told apart
_STEPS = 8


def attractor_count_chart(dataset: "xr.Dataset") -> "Figure":
    """Draw how many attractors were found over two parameters.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of kind ``parameter-chart`` with several seeds.

    Returns
    -------
    matplotlib.figure.Figure
        One panel; large regions carry their number.
    """
    from matplotlib.colors import to_hex

    counts = dataset["attractor_count"].values
    most = min(int(counts.max()), _STEPS)
    # from the palest colour of that scale to its dark end: one attractor is nothing to be struck by
    shades = [to_hex(shade) for shade in diverging()(np.linspace(0.5, 0, max(most, 2)))]
    table = [(counts == 0, NO_ATTRACTOR)]
    for number in range(1, most + 1):
        last = number == _STEPS and counts.max() > _STEPS
        name = f"{number} or more attractors" if last else "1 attractor" if number == 1 else f"{number} attractors"
        mask = counts >= number if last else counts == number
        table.append((mask, Look(name, shades[number - 1], short=f"≥ {number}" if last else str(number))))
    kinds, looks = sort_out(table)
    return kind_chart(dataset, kinds, looks, [str(name) for name in dataset["attractor_count"].dims])
