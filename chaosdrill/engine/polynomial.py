"""Polynomials in rows of fixed length, zero beyond their order.

The coefficients of every fourth power are summed apart, by Horner's rule in the fourth power of the argument: four
short chains at once, for which the compiler takes one vector instruction a step.
"""

from chaosdrill.engine.jit import series
from chaosdrill.engine.layout import WIDTH


@series
def _join(a, b, c, d, s):
    return (a + b * s) + (c + d * s) * (s * s)


@series
def value(rows, i, s):
    """Value of the polynomial in row i."""
    fourth = (s * s) * (s * s)
    a = b = c = d = 0.0
    for m in range(WIDTH // 4):
        k = WIDTH - 4 - 4 * m
        a = a * fourth + rows[i, k]
        b = b * fourth + rows[i, k + 1]
        c = c * fourth + rows[i, k + 2]
        d = d * fourth + rows[i, k + 3]
    return _join(a, b, c, d, s)


@series
def derivative(rows, i, s):
    """Derivative of the polynomial in row i."""
    fourth = (s * s) * (s * s)
    a = b = c = d = 0.0
    for m in range(WIDTH // 4):
        k = WIDTH - 4 - 4 * m
        a = a * fourth + (k + 1) * rows[i, k + 1]
        b = b * fourth + (k + 2) * rows[i, k + 2]
        c = c * fourth + (k + 3) * rows[i, k + 3]
        if m > 0:
            d = d * fourth + (k + 4) * rows[i, k + 4]
    return _join(a, b, c, d, s)


@series
def size(rows, i, s, first):
    """Sum of the sizes of the terms of row i at s > 0, from order ``first`` on, a multiple of four."""
    fourth = (s * s) * (s * s)
    a = b = c = d = 0.0
    for m in range((WIDTH - first) // 4):
        k = WIDTH - 4 - 4 * m
        a = a * fourth + abs(rows[i, k])
        b = b * fourth + abs(rows[i, k + 1])
        c = c * fourth + abs(rows[i, k + 2])
        d = d * fourth + abs(rows[i, k + 3])
    return _join(a, b, c, d, s) * fourth ** (first // 4)


@series
def keeps_side(rows, i, s, sign):
    """Whether no term of the sign opposite to that of its value at 0 can bring a polynomial to zero up to s > 0.

    ``sign`` is -1.0 for a polynomial above zero, 1.0 for one below.
    """
    fourth = (s * s) * (s * s)
    a = b = c = d = 0.0
    for m in range(WIDTH // 4):
        k = WIDTH - 4 - 4 * m
        a = a * fourth + max(sign * rows[i, k], 0.0)
        b = b * fourth + max(sign * rows[i, k + 1], 0.0)
        c = c * fourth + max(sign * rows[i, k + 2], 0.0)
        d = d * fourth + max(sign * rows[i, k + 3], 0.0)
    return sign * rows[i, 0] + _join(a, b, c, d, s) < 0.0


@series
def late_size(rows, i, s, first):
    """Sum of the sizes of the eight terms of row i from order ``first`` on, at s > 0, over s**first."""
    fourth = (s * s) * (s * s)
    a = abs(rows[i, first]) + fourth * abs(rows[i, first + 4])
    b = abs(rows[i, first + 1]) + fourth * abs(rows[i, first + 5])
    c = abs(rows[i, first + 2]) + fourth * abs(rows[i, first + 6])
    d = abs(rows[i, first + 3]) + fourth * abs(rows[i, first + 7])
    return _join(a, b, c, d, s)
