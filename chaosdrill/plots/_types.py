"""Types in the annotations of pictures."""

from collections.abc import Sequence

import numpy as np
from matplotlib.artist import Artist as Artist
from matplotlib.axes import Axes as Axes
from matplotlib.colors import Colormap as Colormap
from matplotlib.colors import Normalize as Normalize
from matplotlib.figure import Figure as Figure
from matplotlib.font_manager import FontProperties as FontProperties
from matplotlib.legend import Legend as Legend
from matplotlib.lines import Line2D as Line2D
from matplotlib.patches import Patch as Patch
from numpy.typing import NDArray

from chaosdrill.annotations import DataArray as DataArray
from chaosdrill.annotations import Dataset as Dataset
from chaosdrill.annotations import Variable as Variable

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Truths = NDArray[np.bool_]
Complexes = NDArray[np.complex128]

States = str | Sequence[str] | None
"""Names of states to show: one, or two against each other; None: those that the picture takes by itself."""
