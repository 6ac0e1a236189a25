"""Systems whose last state moves evenly, the rates of the others being functions of it; what their formulas become."""

import numpy as np

from chaosdrill.codegen import kernels_of
from chaosdrill.model.derive import differentiate
from chaosdrill.model.gates import without_overflow
from chaosdrill.model.text import read_text, write_text


def values_and_slopes(system, u):
    """Rates of all states but the last one, which is ``u``, and their derivatives by it."""
    kernels = kernels_of(system)
    n, c = len(system.state_names) - 1, kernels.constants(system.parameters)
    x, along = np.zeros(n + 1), np.zeros(n + 1)
    x[n], along[n] = u, 1.0
    rates, slopes = np.empty(n + 1), np.empty(n + 1)
    kernels.functions.field(0, 0.0, c, x, rates)
    kernels.functions.variation(0, 0.0, c, x, along, slopes)
    return rates[:n], slopes[:n]


def check_survival(text, names):
    """What has been made of a text is left as it is, also where it was text in between, and so is its derivative."""
    made = without_overflow(read_text(text, names))
    assert without_overflow(made) == made
    assert without_overflow(read_text(write_text(made), names)) == made
    slope = differentiate(made, names["u"])
    assert without_overflow(slope) == slope
