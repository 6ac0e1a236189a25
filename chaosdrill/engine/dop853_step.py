"""One step of the Runge-Kutta method of order 8: stages, error, a first length, dense output.

Rows of ``stages``: rates of the states, a place, the end, and for every tangent its rates, a place and its end.
"""

import math

from chaosdrill.engine.dop853_tables import (
    DEGREE,
    DENSE,
    DENSE_STAGES,
    E3,
    E5,
    END,
    PLACE,
    ROWS_A_VECTOR,
    STAGES,
    VECTORS,
    A,
    C,
)
from chaosdrill.engine.jit import inner, series
from chaosdrill.engine.layout import EVALUATIONS, MODE


@series
def _combine(stages, first, count, weights, h, start, n, out):
    for i in range(n):
        s = 0.0
        for j in range(count):
            s += weights[j] * stages[first + j, i]
        out[i] = start[i] + h * s


@series
def stage(field, variation, mode, t, c, x, h, k, vectors, live, stages):
    """Rates of stage k of states and tangents; stages before it are there."""
    n = x.size
    place = stages[PLACE]
    _combine(stages, 0, k, A[k], h, x, n, place)
    field(mode, t + C[k] * h, c, place, stages[k])
    for v in range(live):
        row = VECTORS + ROWS_A_VECTOR * v
        direction = stages[row + STAGES]
        _combine(stages, row, k, A[k], h, vectors[v], n, direction)
        variation(mode, t + C[k] * h, c, place, direction, stages[row + k])


@series
def attempt(field, variation, t, c, x, h, vectors, live, carried, stages, out):
    """A step of length h from the rates at its start: states and quadratures to ``out``, tangents to their last row."""
    n = x.size
    for k in range(1, STAGES):
        stage(field, variation, carried[MODE], t, c, x, h, k, vectors, live, stages)
    carried[EVALUATIONS] += STAGES - 1
    _combine(stages, 0, STAGES, A[STAGES], h, x, n, out)
    for i in range(n, out.size):
        s = 0.0
        for j in range(STAGES):
            s += A[STAGES, j] * stages[j, i]
        out[i] = h * s
    for v in range(live):
        row = VECTORS + ROWS_A_VECTOR * v
        _combine(stages, row, STAGES, A[STAGES], h, vectors[v], n, stages[row + STAGES + 1])


@series
def _estimate(stages, first, n, h):
    """Local error from embedded formulas of orders 5 and 3, as Hairer, Norsett and Wanner combine them."""
    fifth = 0.0
    third = 0.0
    for i in range(n):
        a = 0.0
        b = 0.0
        for j in range(STAGES):
            a += E5[j] * stages[first + j, i]
            b += E3[j] * stages[first + j, i]
        fifth += a * a
        third += b * b
    return h * fifth / math.sqrt(fifth + 0.01 * third) if fifth > 0.0 else fifth * h


@inner
def size(x):
    s = 0.0
    for i in range(x.size):
        s += x[i] * x[i]
    return math.sqrt(s)


@inner
def _scale(x):
    s = 1.0
    for i in range(x.size):
        s = max(s, abs(x[i]))
    return s


@inner
def error_of(x, h, vectors, live, stages):
    """Largest error of a step: of states and quadratures relative to max(1, |x|), of a tangent to its length."""
    error = _estimate(stages, 0, stages.shape[1], h) / _scale(x)
    for v in range(live):
        length = size(vectors[v])
        if length > 0.0:
            e = _estimate(stages, VECTORS + ROWS_A_VECTOR * v, x.size, h) / length
            error = e if not e <= error else error
    return error


@inner
def first_length(field, variation, t, c, x, vectors, live, carried, tolerance, longest, stages):
    """Length of a step to begin with, from the first two derivatives (section II.4); 0 if there are none."""
    n = x.size
    mode = carried[MODE]
    scale = _scale(x)
    speed = size(stages[0]) / scale
    for v in range(live):
        length = size(vectors[v])
        if length > 0.0:
            speed = max(speed, size(stages[VECTORS + ROWS_A_VECTOR * v][:n]) / length)
    trial = min(0.01 / speed, longest) if speed > 0.0 else longest
    place = stages[PLACE]
    for i in range(n):
        place[i] = x[i] + trial * stages[0, i]
    field(mode, t + trial, c, place, stages[1])
    carried[EVALUATIONS] += 1
    change = 0.0
    for i in range(n):
        change = max(change, abs(stages[1, i] - stages[0, i]) / scale)
    for v in range(live):
        length = size(vectors[v])
        row = VECTORS + ROWS_A_VECTOR * v
        direction = stages[row + STAGES]
        for i in range(n):
            direction[i] = vectors[v, i] + trial * stages[row, i]
        variation(mode, t + trial, c, place, direction, stages[row + 1])
        for i in range(n):
            if length > 0.0:
                change = max(change, abs(stages[row + 1, i] - stages[row, i]) / length)
    bend = max(speed, change / trial)
    length = (0.01 * tolerance / bend) ** 0.125 if bend > 0.0 else longest
    return min(length, longest)


@series
def dense_output(field, variation, t, c, x, h, carried, stages, ws):
    """Coefficients of the states' polynomials; the step has been taken."""
    n = x.size
    field(carried[MODE], t + h, c, stages[END], stages[STAGES])
    for k in range(STAGES + 1, DENSE_STAGES):
        stage(field, variation, carried[MODE], t, c, x, h, k, stages, 0, stages)
    carried[EVALUATIONS] += DENSE_STAGES - STAGES
    for i in range(n):
        ws[i, 0] = x[i]
        ws[i, 1] = stages[0, i]
        power = 1.0
        for k in range(2, DEGREE + 1):
            power /= h
            s = 0.0
            for j in range(DENSE_STAGES):
                s += DENSE[k - 1, j] * stages[j, i]
            ws[i, k] = s * power
