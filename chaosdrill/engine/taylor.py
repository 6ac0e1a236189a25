"""Adaptive Taylor method of variable order (Jorba and Zou 2005, doi:10.1080/10586458.2005.10128904)."""

import math

import numpy as np
from numba import uint64

from chaosdrill.engine.jit import RECIPROCAL, inlined, inner, series
from chaosdrill.engine.layout import JACOBIAN, LIVE, MODE, ORDER, PERIOD, REACH, TOLERANCE, UNPROVEN
from chaosdrill.engine.polynomial import size, value

SMALLEST = 1e-300

LONGEST = 1e9
"""Longest step, so that no power of it overflows."""

GAP = 1000.0
"""Sum of the late terms at the radius of convergence, relative to the states, that raises suspicion."""

DEFECT = 100.0
"""Defect at the end of a step, times its length, in units of the tolerance, above which the step is shortened."""


@inner
def _log2(x):
    """Binary logarithm of a positive number to 1e-3, from its bits."""
    bits = np.float64(x).view(np.int64)
    m = np.int64((bits & 0xFFFFFFFFFFFFF) | 0x3FF0000000000000).view(np.float64)
    return (bits >> 52) - 1023 + (-2.153620718 + m * (3.047884161 + m * (-1.051874866 + m * 0.158248848)))


@inner
def _exp2(y):
    """2**y to 2e-4."""
    whole = math.floor(y)
    r = y - whole
    return np.int64((np.int64(whole) + 1023) << 52).view(np.float64) * (
        1.0 + r * (0.695502 + r * (0.226170 + r * 0.0780245))
    )


@inner
def radius(last, last_but_one, order):
    """Radius of convergence that the last two coefficients show."""
    a = _log2(max(last, SMALLEST)) * RECIPROCAL[uint64(order)]
    b = _log2(max(last_but_one, SMALLEST)) * RECIPROCAL[uint64(order - 1)]
    return _exp2(-max(a, b))


@inner
def _first_row(ws, vectors, v):
    """Row from which the series of tangent v stand."""
    m, n = vectors.shape
    return ws.shape[0] - (m + m % 2) * n + v * n


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


@inner
def _has_gap(ws, n, radius, scale):
    """Whether a coefficient is larger than the radius of convergence lets expect, which then may be wrong."""
    total = 0.0
    for i in range(n):
        total += size(ws, uint64(i), radius, 8)
    return not total <= GAP * scale


@inlined
def proven_step(functions, h, settings_i, settings_f, t, c, x, carried, ws, spare):
    """The step h, shortened until the series obeys the equation at its end.

    The last coefficients may lie in a gap of the series (the solution of x'' = -x**3 from x = 0 has every fourth one
    only) and promise a step far beyond its radius; earlier ones show that, and the defect tells how far it goes.
    """
    place, rate, slope = spare
    n = place.size
    order = settings_i[ORDER]
    scale = 1.0
    for i in range(x.size):
        scale = max(scale, abs(x[i]))
    if not _has_gap(ws, n, h / settings_f[REACH], scale):
        return h
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
def has_unproven(marks, count):
    """Whether the series of any guard may end before that of the states."""
    found = False
    for j in range(count):
        found = found or marks[j] & UNPROVEN != 0
    return found


@inlined
def proven_guards(guard, h, first, count, marks, settings_f, t, c, x, carried, ws, place, gradient):
    """The step h, shortened until guards whose series may end before it are what their series say at its end.

    A pole, a root or a logarithm near by ends a guard's series; tanh far from its slope shows none of it. NaN if a
    guard is no number where the step begins.
    """
    scale = 1.0
    for i in range(x.size):
        scale = max(scale, abs(x[i]))
    for j in range(count):
        if marks[j] & UNPROVEN and not abs(ws[first + j, 0]) < math.inf:
            return math.nan
    for _ in range(100):
        for i in range(x.size):
            place[i] = value(ws, uint64(i), h)
        holds = True
        for j in range(count):
            if marks[j] & UNPROVEN:
                row = uint64(first + j)
                error = guard(carried[MODE], j, t + h, c, place, gradient) - value(ws, row, h)
                holds = holds and abs(error) <= DEFECT * settings_f[TOLERANCE] * scale + 1e-12 * size(ws, row, h, 0)
        if holds:
            return h
        h *= 0.5
    return h


@inlined
def expand(functions, rows, settings_i, settings_f, t, c, x, vectors, carried, ws):
    """Taylor coefficients at the present state; returns the step that keeps both state and tangents within tolerance.

    The last term is to be a part of the tolerance, relative to max(1, |x|) over all states for states, integrals and
    guards, and to its length for every tangent.
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
    for j in range(n, rows):
        last = max(last, abs(ws[j, order]))
        last_but_one = max(last_but_one, abs(ws[j, order - 1]))
    last /= scale
    last_but_one /= scale
    live = carried[LIVE]
    if live > 0:
        if settings_i[JACOBIAN] == 1:
            functions[1](mode, order, c, ws)
        for v in range(0, live, 2):
            row = _first_row(ws, vectors, v)
            functions[2](mode, order, c, vectors[v], vectors[min(v + 1, live - 1)], ws, row)
        for v in range(live):
            row = _first_row(ws, vectors, v)
            size = 0.0
            a = 0.0
            b = 0.0
            for i in range(row, row + n):
                size = max(size, abs(ws[i, 0]))
                a = max(a, abs(ws[i, order]))
                b = max(b, abs(ws[i, order - 1]))
            last = max(last, a / size)
            last_but_one = max(last_but_one, b / size)
    return min(radius(last, last_but_one, order) * settings_f[REACH], settings_f[PERIOD], LONGEST)


@inner
def evaluate(ws, count, s, out):
    """Polynomials of the first ``count`` rows at s."""
    for i in range(count):
        out[i] = value(ws, uint64(i), s)


@inner
def evaluate_vectors(ws, s, live, vectors):
    """Live tangents at s, in place."""
    n = vectors.shape[1]
    for v in range(live):
        row = _first_row(ws, vectors, v)
        for i in range(n):
            vectors[v, i] = value(ws, uint64(row + i), s)
