"""Guards as polynomials along a step whose states are polynomials: exact if linear, else interpolated.

Value and slope at the start come from the guard itself, so that what vanishes there vanishes to round-off.
"""

import math

from chaosdrill.engine.dop853_tables import DEGREE, GUARD_DEGREE, NODES, TO_CHEBYSHEV, TO_POWERS
from chaosdrill.engine.guards import INTERPOLATED, INTERPOLATED_IN_TIME, INTERPOLATION_NOISE
from chaosdrill.engine.jit import series
from chaosdrill.engine.layout import AFFINE, TIMED


@series
def guard_polynomials(guard, guard_error, mode, count, marks, tolerance, t, c, x, h, rate, place, gradient, ws, first):
    """Fill rows ``first``, ... of the workspace from those of the states; returns what the interpolation leaves out.

    That is in parts of what it may leave out, the tolerance beside the guard's own rounding error; infinite where a
    polynomial is not finite: the step has touched what the guard or the field cannot bear.
    """
    n = x.size
    left = 0.0
    for j in range(count):
        g = ws[first + j]
        g[0] = guard(mode, j, t, c, x, gradient)
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
            rest, largest = _interpolate(guard, mode, j, t, c, h, n, place, gradient, ws, g)
            allowed = (INTERPOLATED_IN_TIME if marks[j] & TIMED else max(tolerance, INTERPOLATED)) * largest
            if rest > allowed:
                guard_error(mode, j, t, c, x, gradient)
                noise = gradient[0]
                guard_error(mode, j, t + h, c, place[:n], gradient)
                left = max(left, rest / (allowed + INTERPOLATION_NOISE * max(noise, gradient[0])))
        total = 0.0
        for k in range(GUARD_DEGREE + 1):
            total += g[k]
        if not math.isfinite(total):
            return math.inf
    return left


@series
def _interpolate(guard, mode, j, t, c, h, n, place, gradient, ws, g):
    """Coefficients from order 2 on, through Chebyshev nodes; returns the sizes of the last two and of the guard."""
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
        value = guard(mode, j, t + s, c, place[:n], gradient)
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
