"""Sine, cosine and exponential of lanes, all eight at once; arguments out of range go to the standard library.

Reduction and polynomials of sine and cosine are those of Sun's fdlibm, within one unit in the last place of the result,
or of 1 where it is near zero.
"""

import math

from numba.extending import overload

from chaosdrill.engine.jit import helper
from chaosdrill.engine.lanes import LANES, any_beyond, chosen, floor, lane_of, lanes, nearest, power_of_two, with_lane

_TURNS = 1e5
"""Largest argument of a sine or cosine for which the reduction is exact enough."""

_EXPONENT = 700.0
"""Largest argument of an exponential that neither overflows nor is subnormal."""


@helper
def _sine(r):
    z = r * r
    low = -1.66666666666666324348e-01 + z * (8.33333333332248946124e-03 + z * -1.98412698298579493134e-04)
    high = 2.75573137070700676789e-06 + z * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10)
    return r + (r * z) * (low + (z * z * z) * high)


@helper
def _cosine(r):
    z = r * r
    low = 4.16666666666666019037e-02 + z * (-1.38888888888741095749e-03 + z * 2.48015872894767294178e-05)
    high = -2.75573143513906633035e-07 + z * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11)
    return (1.0 - 0.5 * z) + (z * z) * (low + (z * z * z) * high)


@helper
def _turned(x, quarters):
    """Sine of x + quarters * pi / 2."""
    n = nearest(x * 0.6366197723675814)
    r = (x - n * 1.57079632673412561417e00) - n * 6.07710050650619224932e-11
    n = n + quarters
    odd = n - 2.0 * floor(0.5 * n)
    beyond = n - 4.0 * floor(0.25 * n) - odd
    return chosen(odd, _cosine(r), _sine(r)) * (1.0 - beyond)


@helper
def _power(x):
    n = nearest(x * 1.4426950408889634)
    r = (x - n * 6.93147180369123816490e-01) - n * 1.90821492927058770002e-10
    value = 1.0 / 6227020800.0
    for c in (479001600.0, 39916800.0, 3628800.0, 362880.0, 40320.0, 5040.0, 720.0, 120.0, 24.0, 6.0, 2.0, 1.0, 1.0):
        value = value * r + 1.0 / c
    return value * power_of_two(n)


@helper
def _sin(x):
    return _turned(x, 0.0)


@helper
def _cos(x):
    return _turned(x, 1.0)


def _define(function, in_lanes, limit):  # type: ignore[no-untyped-def]
    """Let a function of the standard library take lanes."""

    @overload(function)
    def _overloaded(x):  # type: ignore[no-untyped-def]
        if x != lanes:
            return None

        def each(x):
            result = in_lanes(x)
            if any_beyond(x, limit):
                for i in range(LANES):
                    if not abs(lane_of(x, i)) <= limit:
                        result = with_lane(result, i, function(lane_of(x, i)))
            return result

        return each


_define(math.sin, _sin, _TURNS)
_define(math.cos, _cos, _TURNS)
_define(math.exp, _power, _EXPONENT)
