"""Roots of functions that are known to change their sign."""

from collections.abc import Callable

ROUNDS = 200
"""Values of the function at most; bisection of the whole range of doubles between 0 and 1 takes fewer."""


def bracketed(function: Callable[[float], float], low: float, high: float) -> float:
    """Where a function changes its sign between two places; where it jumps there, the place of the jump.

    Chandrupatla 1997, doi:10.1016/S0965-9978(96)00051-8: inverse quadratic interpolation where it is safe, else
    bisection, so that no function makes it fail. Where both values have one sign it is the place of the smaller one.

    Returns: of the two last places that enclose the root, which are neighbours in double precision or nearly so, the
    one with the smaller value.
    """
    a, b = high, low
    fa, fb = function(a), function(b)
    if not fa * fb < 0:
        return a if abs(fa) < abs(fb) else b
    c, fc, part = a, fa, 0.5
    for _ in range(ROUNDS):
        x = a + part * (b - a)
        f = function(x)
        if (f > 0) == (fa > 0):
            c, fc = a, fa
        else:
            c, b, fc, fb = b, a, fb, fa
        a, fa = x, f
        best = a if abs(fa) < abs(fb) else b
        shortest = 2.3e-16 * abs(best) + 1e-300
        width = abs(b - a)
        if f == 0 or width <= 2 * shortest:
            break
        ratio, slope = (a - b) / (c - b), (fa - fb) / (fc - fb)
        part = 0.5
        if 1 - (1 - ratio) ** 0.5 < slope < ratio**0.5:
            part = fa / (fb - fa) * fc / (fb - fc) + (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb)
        least = shortest / width
        part = min(max(part, least), 1 - least)
    return a if abs(fa) < abs(fb) else b
