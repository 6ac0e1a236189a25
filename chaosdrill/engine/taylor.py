"""Adaptive Taylor method of variable order (Jorba and Zou 2005, doi:10.1080/10586458.2005.10128904)."""

import math

from numba import uint64

from chaosdrill.engine.jit import inlined, inner, series
from chaosdrill.engine.layout import LIVE, MODE, ORDER, PERIOD, TOLERANCE

SMALLEST = 1e-300

DEFECT = 100.0
"""Defect at the end of a step, times its length, in units of the tolerance, above which the step is shortened."""


@inner
def _reach(largest, tolerance, k):
    """Step at which a coefficient of order k contributes the tolerated error."""
    return math.exp(math.log(tolerance / max(largest, SMALLEST)) / k)


@inner
def _first_row(ws, vectors, v):
    """Row from which tangents v and v + 1 stand side by side."""
    m, n = vectors.shape
    return ws.shape[0] - (m + 1) // 2 * n + v // 2 * n


@series
def _values_and_rates(ws, count, order, s, values, rates):
    """Polynomials of the first ``count`` rows and their derivatives at s."""
    i = 0
    while i < count:
        second = min(i + 1, count - 1)
        third = min(i + 2, count - 1)
        a = ws[i, order]
        b = ws[second, order]
        c = ws[third, order]
        da = 0.0
        db = 0.0
        dc = 0.0
        for j in range(order):
            k = uint64(order - 1 - j)
            da = da * s + a
            db = db * s + b
            dc = dc * s + c
            a = a * s + ws[i, k]
            b = b * s + ws[second, k]
            c = c * s + ws[third, k]
        values[i] = a
        values[second] = b
        values[third] = c
        rates[i] = da
        rates[second] = db
        rates[third] = dc
        i += 3


@inlined
def proven_step(functions, h, settings_i, settings_f, t, c, x, carried, ws, place, rate, slope):
    """The step h, shortened until the series obeys the equation at its end.

    The last coefficients may lie in a gap of the series (the solution of x'' = -x**3 from x = 0 has every fourth one
    only) and promise a step far beyond its radius; the defect tells.
    """
    n = x.size
    order = settings_i[ORDER]
    scale = 1.0
    for i in range(n):
        scale = max(scale, abs(x[i]))
    for _ in range(100):
        _values_and_rates(ws, n, order, h, place, slope)
        functions[3](carried[MODE], t + h, c, place, rate)
        defect = 0.0
        size = 0.0
        for i in range(n):
            defect = max(defect, abs(slope[i] - rate[i]))
            size = max(size, abs(rate[i]))
        if not defect * h > DEFECT * settings_f[TOLERANCE] * scale + 1e-12 * size * h:
            return h
        h *= 0.6
    return h


@inlined
def expand(functions, rows, guards, settings_i, settings_f, t, c, x, vectors, carried, ws):
    """Taylor coefficients at the present state; returns the step that keeps both state and tangents within tolerance.

    The last two coefficients bound the local error, relative to max(1, |x|) over all states for the state and to its
    length for every tangent.
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
        for v in range(0, live, 2):
            row = _first_row(ws, vectors, v)
            functions[2](mode, order, c, vectors[v], vectors[min(v + 1, live - 1)], ws, row)
            for half in range(2):
                size = 0.0
                a = 0.0
                b = 0.0
                for i in range(row, row + n):
                    size = max(size, abs(ws[i, half]))
                    a = max(a, abs(ws[i, 2 * order + half]))
                    b = max(b, abs(ws[i, 2 * order - 2 + half]))
                last = max(last, a / size)
                last_but_one = max(last_but_one, b / size)
    tolerance = settings_f[TOLERANCE]
    return min(_reach(last, tolerance, order), _reach(last_but_one, tolerance, order - 1), settings_f[PERIOD])


@series
def evaluate(ws, count, order, s, out):
    """Polynomials of the first ``count`` rows at s."""
    i = 0
    while i < count:
        second = min(i + 1, count - 1)
        third = min(i + 2, count - 1)
        a = ws[i, order]
        b = ws[second, order]
        c = ws[third, order]
        for j in range(order):
            k = uint64(order - 1 - j)
            a = a * s + ws[i, k]
            b = b * s + ws[second, k]
            c = c * s + ws[third, k]
        out[i] = a
        out[second] = b
        out[third] = c
        i += 3


@series
def evaluate_vectors(ws, order, s, live, vectors):
    """Live tangents at s, in place."""
    n = vectors.shape[1]
    for v in range(0, live, 2):
        row = _first_row(ws, vectors, v)
        for i in range(n):
            a = ws[row + i, 2 * order]
            b = ws[row + i, 2 * order + 1]
            for j in range(order):
                k = 2 * (order - 1 - j)
                a = a * s + ws[row + i, uint64(k)]
                b = b * s + ws[row + i, uint64(k + 1)]
            vectors[v, i] = a
            if v + 1 < live:
                vectors[v + 1, i] = b
