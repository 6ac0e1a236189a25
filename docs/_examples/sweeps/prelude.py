"""What the page takes for granted: a small sweep."""

import numpy as np

import chaosdrill as cd

system = cd.drill()
etas = np.linspace(0.6, 0.7, 20)
