"""Adaptive Taylor method of variable order (Jorba and Zou 2005, doi:10.1080/10586458.2005.10128904)."""

import math

from chaosdrill.engine.jit import inner
from chaosdrill.engine.layout import LIVE, MODE, ORDER, PERIOD, TOLERANCE

SMALLEST = 1e-300


@inner
def _reach(largest, scale, tolerance, k):
    """Step at which a coefficient of order k contributes the tolerated error."""
    return math.exp((math.log(tolerance * scale) - math.log(max(largest, SMALLEST))) / k)


@inner
def expand(functions, rows, guards, settings_i, settings_f, t, c, x, vectors, carried, ws):
    """Taylor coefficients at the present state; returns the step that keeps both state and tangents within tolerance.

    The last two coefficients bound the local error, relative to max(1, |x|) for the state and to its length for every
    tangent.
    """
    n = x.size
    order = settings_i[ORDER]
    mode = carried[MODE]
    functions[0](mode, order, t, c, x, ws)
    last = 0.0
    last_but_one = 0.0
    scale = 1.0
    for i in range(n):
        scale = max(scale, abs(x[i]))
        last = max(last, abs(ws[i, order]))
        last_but_one = max(last_but_one, abs(ws[i, order - 1]))
    for j in range(guards, rows):
        last = max(last, abs(ws[j, order]))
        last_but_one = max(last_but_one, abs(ws[j, order - 1]))
    last /= scale
    last_but_one /= scale
    live = carried[LIVE]
    if live > 0:
        functions[1](mode, order, c, ws)
        top = ws.shape[0] - vectors.shape[0] * n
        for v in range(live):
            row = top + v * n
            functions[2](mode, order, c, vectors[v], ws, row)
            size = 0.0
            a = 0.0
            b = 0.0
            for i in range(n):
                size = max(size, abs(vectors[v, i]))
                a = max(a, abs(ws[row + i, order]))
                b = max(b, abs(ws[row + i, order - 1]))
            last = max(last, a / size)
            last_but_one = max(last_but_one, b / size)
    tolerance = settings_f[TOLERANCE]
    h = min(_reach(last, 1.0, tolerance, order), _reach(last_but_one, 1.0, tolerance, order - 1))
    return min(h, settings_f[PERIOD])


@inner
def evaluate(ws, first, count, order, s, out):
    """Polynomials of ``count`` rows at s."""
    for i in range(count):
        value = ws[first + i, order]
        for k in range(order - 1, -1, -1):
            value = value * s + ws[first + i, k]
        out[i] = value


@inner
def evaluate_vectors(ws, order, s, live, vectors):
    """Live tangents at s, in place."""
    n = vectors.shape[1]
    top = ws.shape[0] - vectors.shape[0] * n
    for v in range(live):
        for i in range(n):
            row = top + v * n + i
            value = ws[row, order]
            for k in range(order - 1, -1, -1):
                value = value * s + ws[row, k]
            vectors[v, i] = value
