"""Polynomials in rows of fixed length, zero beyond their order.

Of one run eight coefficients lie side by side in a vector register: Horner's rule in the eighth power of the argument,
then the sum over the register. Coefficients of lanes lie in registers of their own.
"""

import numpy as np

from chaosdrill.codegen.kinds import uint64
from chaosdrill.codegen.signatures import WIDTH
from chaosdrill.engine.jit import inlined, series
from chaosdrill.engine.lanes import LANES, as_wide, chosen, larger, magnitude, part, powers, spread, total
from chaosdrill.engine.layout import COLUMNS

_WITHIN = np.array([[float(k < WIDTH) for k in range(COLUMNS - LANES, COLUMNS)]])
"""Which of the last coefficients of a row are any: behind them stands what a last pass over orders has left."""

_LATER = np.array([[float(k > 0) for k in range(LANES)]])
"""Which of the first coefficients stand behind the first."""


@series
def power(s, k):
    """s**k, k >= 0, of a number or of lanes, by squares: products in a row would wait for one another."""
    found = as_wide(1.0, s)
    while k > 0:
        if k & 1:
            found = found * s
        s = s * s
        k >>= 1
    return found


@series
def _eighth(s):
    square = s * s
    return (square * square) * (square * square)


@series
def _last(rows, i):
    return chosen(part(_WITHIN, 0, 0) != 0.0, part(rows, i, COLUMNS - LANES), 0.0)


@series
def value(rows, i, s):
    """Value of the polynomial in row i; the first term, often the largest by far, is added last."""
    eighth = _eighth(s)
    terms = _last(rows, i)
    for m in range(2, COLUMNS // LANES):
        terms = terms * eighth + part(rows, i, COLUMNS - LANES * m)
    terms = terms * eighth + chosen(part(_LATER, 0, 0) != 0.0, part(rows, i, 0), 0.0)
    return rows[i, 0] + total(terms * powers(s))


@inlined
def values(rows, count, s, out):
    """Of the first ``count`` rows."""
    for i in range(count):
        out[i] = value(rows, uint64(i), s)


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
    return (a + b * s) + (c + d * s) * (s * s)


@series
def sizes(rows, i, s):
    """Sizes of the terms of row i at s > 0, every eighth of them added."""
    eighth = _eighth(s)
    terms = magnitude(_last(rows, i))
    for m in range(2, COLUMNS // LANES + 1):
        terms = terms * eighth + magnitude(part(rows, i, COLUMNS - LANES * m))
    return terms * powers(s)


@series
def size(rows, i, s):
    """Sum of the sizes of the terms of row i at s > 0."""
    return total(sizes(rows, i, s))


@series
def keeps_side(rows, i, s, sign):
    """Whether no term of the sign opposite to that of its value at 0 can bring a polynomial to zero up to s > 0.

    ``sign`` is -1.0 for a polynomial above zero, 1.0 for one below.
    """
    eighth = _eighth(s)
    terms = larger(sign * _last(rows, i), 0.0)
    for m in range(2, COLUMNS // LANES + 1):
        terms = terms * eighth + larger(sign * part(rows, i, COLUMNS - LANES * m), 0.0)
    return sign * rows[i, 0] + total(terms * powers(s)) < 0.0


@series
def late_size(rows, i, s, first):
    """Sum of the sizes of the eight terms of row i from order ``first`` on, at s > 0, over s**first."""
    return total(magnitude(part(rows, i, first)) * powers(s))


@series
def lane_value(g, order, s):
    """Values of polynomials up to an order, of lanes or of one, rounded as if there were more terms that are zero."""
    fourth = (s * s) * (s * s)
    last = uint64(order // 4)
    a = g[4 * last]
    b = g[4 * last + 1]
    c = g[4 * last + 2]
    d = g[4 * last + 3]
    for m in range(1, last + 1):
        k = 4 * (last - m)
        a = a * fourth + g[k]
        b = b * fourth + g[k + 1]
        c = c * fourth + g[k + 2]
        d = d * fourth + g[k + 3]
    return (a + b * s) + (c + d * s) * (s * s)


@series
def value_and_slope(a, order, u):
    """Value and derivative of a polynomial or of lanes, even and odd terms apart: two short chains for a long one."""
    square = u * u
    last = uint64(order // 2)
    even, odd = a[2 * last], a[2 * last + 1] if order % 2 == 1 else as_wide(0.0, u)
    even_slope = odd_slope = as_wide(0.0, u)
    for m in range(1, last + 1):
        k = 2 * (last - m)
        even_slope = even_slope * square + even
        odd_slope = odd_slope * square + odd
        even = even * square + a[k]
        odd = odd * square + a[k + 1]
    return even + u * odd, odd + (2.0 * u) * (even_slope + u * odd_slope)


@series
def lane_late_size(rows, i, s, first):
    """Sums of the sizes of the eight terms of row i from order ``first`` on, at s > 0, over s**first."""
    g = rows[i]
    fourth = (s * s) * (s * s)
    a = magnitude(g[first]) + fourth * magnitude(g[first + 4])
    b = magnitude(g[first + 1]) + fourth * magnitude(g[first + 5])
    c = magnitude(g[first + 2]) + fourth * magnitude(g[first + 6])
    d = magnitude(g[first + 3]) + fourth * magnitude(g[first + 7])
    return (a + b * s) + (c + d * s) * (s * s)


@series
def lane_size(rows, i, s):
    """Sums of the sizes of the terms of row i at s > 0."""
    g = rows[i]
    total = spread(0.0)
    for k in range(WIDTH):
        total = total * s + magnitude(g[uint64(WIDTH - 1 - k)])
    return total
