"""When a run ends early, and the types of the arrays that all its loops share."""

import math

from numba import int64, types

from chaosdrill.codegen.signatures import matrix, vector
from chaosdrill.engine.jit import inner
from chaosdrill.engine.layout import DONE, ESCAPED, NONFINITE

STALL_LIMIT = 50
"""Events in succession without time passing before a run is called stalled."""

SMALLEST_STEP = 1e-15
"""Shortest step, as a part of the longest one taken so far."""

LARGE_GROWTH = 1e4
"""Tangents are orthonormalised at once after an event that makes one this long."""

integer_matrix = int64[:, ::1]
scratch_type = types.Tuple(
    (matrix, vector, vector, matrix, matrix, *[vector] * 8, matrix)
)  # in the order of engine.layout


@inner
def state_outcome(x, bounds):
    for i in range(x.size):
        if not math.isfinite(x[i]):
            return NONFINITE
    for i in range(x.size):
        if not bounds[0, i] <= x[i] <= bounds[1, i]:
            return ESCAPED
    return DONE
