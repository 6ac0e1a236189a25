"""Guards as polynomials along a step whose states are polynomials: exact if linear, else interpolated.

Value and slope at the start come from the guard itself, so that what vanishes there vanishes to round-off.
"""

import math

from chaosdrill.engine.dop853_tables import GUARD_DEGREE, NODES, PLACE, TO_CHEBYSHEV, TO_POWERS
from chaosdrill.engine.guards import INTERPOLATION_NOISE, truncation
from chaosdrill.engine.jit import series
from chaosdrill.engine.layout import AFFINE
from chaosdrill.engine.radau_tables import DEGREE


@series
def guard_polynomials(functions, tables, settings, state, t, h, scratch):
    """Fill the rows of the guards in the workspace from those of the states; returns what the interpolation leaves out.

    That is in parts of what it may leave out, the tolerance beside the guard's own rounding error; infinite where a
    polynomial is not finite: the step has touched what the guard or the field cannot bear.
    """
    mode, c, x, ws = state.run[0].mode, state.c, state.x, scratch.workspace
    rate, place, gradient = scratch.stages[0], scratch.stages[PLACE], scratch.gradient
    marks = tables.marks[mode]
    n = x.size
    first = n + settings.quadratures
    left = 0.0
    for j in range(tables.active[mode, 0]):
        g = ws[first + j]
        g[0] = functions.guard(mode, j, t, c, x, gradient)
        slope = gradient[n]
        for i in range(n):
            slope += gradient[i] * rate[i]
        g[1] = slope
        for k in range(2, GUARD_DEGREE + 1):
            g[k] = 0.0
        if marks[j] & AFFINE:
            for k in range(2, DEGREE + 1):
                for i in range(n):
                    g[k] += gradient[i] * ws[i, k]
        else:
            rest, largest = _interpolate(functions, mode, j, t, c, h, place, gradient, ws, g)
            allowed = truncation(settings, marks[j]) * largest
            if rest > allowed:
                noise = functions.guard_error(mode, j, t, c, x, scratch.none)
                noise = max(noise, functions.guard_error(mode, j, t + h, c, place[:n], scratch.none))
                left = max(left, rest / (allowed + INTERPOLATION_NOISE * noise))
        total = 0.0
        for k in range(GUARD_DEGREE + 1):
            total += g[k]
        if not math.isfinite(total):
            return math.inf
    return left


@series
def _interpolate(functions, mode, j, t, c, h, place, gradient, ws, g):
    """Coefficients from order 2 on, through Chebyshev nodes; returns the sizes of the last two and of the guard."""
    n = gradient.size - 1
    count = GUARD_DEGREE - 1
    largest = abs(g[0])
    for a in range(count):
        u = NODES[a]
        s = u * h
        for i in range(n):
            y = ws[i, DEGREE]
            for k in range(DEGREE - 1, -1, -1):
                y = y * s + ws[i, k]
            place[i] = y
        value = functions.guard(mode, j, t + s, c, place[:n], gradient)
        largest = max(largest, abs(value))
        value = (value - g[0] - g[1] * s) / (u * u)
        for k in range(count):
            g[k + 2] += TO_CHEBYSHEV[k, a] * value
    left = abs(g[count]) + abs(g[count + 1])
    for k in range(count):
        coefficient = g[k + 2]
        g[k + 2] = 0.0
        for m in range(k + 1):
            g[m + 2] += coefficient * TO_POWERS[k, m]
    power = 1.0
    for k in range(2, GUARD_DEGREE + 1):
        power /= h
        g[k] *= power / h
    return left, largest
