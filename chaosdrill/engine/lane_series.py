"""Polynomials whose coefficients are lanes: as in ``engine.polynomial``, for eight trajectories at once."""

from chaosdrill.codegen.kinds import uint64
from chaosdrill.codegen.signatures import WIDTH
from chaosdrill.engine.jit import series
from chaosdrill.engine.lanes import magnitude, spread


@series
def lane_value(g, order, s):
    """Values at s of polynomials up to an order, rounded as if there were more terms that are zero."""
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
def value_in_lane(ws, i, lane, s):
    """Value at s of the polynomial in row i of one lane, rounded as ``lane_value`` rounds it."""
    fourth = (s * s) * (s * s)
    a = ws[i, WIDTH - 4, lane]
    b = ws[i, WIDTH - 3, lane]
    c = ws[i, WIDTH - 2, lane]
    d = ws[i, WIDTH - 1, lane]
    for m in range(1, WIDTH // 4):
        k = WIDTH - 4 - 4 * m
        a = a * fourth + ws[i, k, lane]
        b = b * fourth + ws[i, k + 1, lane]
        c = c * fourth + ws[i, k + 2, lane]
        d = d * fourth + ws[i, k + 3, lane]
    return (a + b * s) + (c + d * s) * (s * s)


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
