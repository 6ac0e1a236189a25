"""One step of the Runge-Kutta method of order 8: stages, error, a first length, dense output.

Rows of ``stages``: see ``dop853_tables``.
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
    WEIGHTS,
    A,
    C,
)
from chaosdrill.engine.jit import inlined, inner, series
from chaosdrill.engine.taylor import EPSILON, FADE, SMALLEST

SAFETY = 0.9

SMALLEST_GROWTH = 0.1
"""A step into a contact may have to shrink by orders of magnitude."""

TANGENTS = 0.1
"""Part of the tolerance for tangents: through a stiff contact they grow by orders of magnitude, and come back."""


@series
def _combine(stages, first, count, weights, h, start, n, out):
    for i in range(n):
        s = 0.0
        for j in range(count):
            s += weights[j] * stages[first + j, i]
        out[i] = start[i] + h * s


@series
def stage(functions, mode, t, c, x, h, k, vectors, live, stages):
    """Rates of stage k of states and tangents; stages before it are there."""
    n = x.size
    place = stages[PLACE]
    _combine(stages, 0, k, A[k], h, x, n, place)
    functions.field(mode, t + C[k] * h, c, place, stages[k])
    for v in range(live):
        row = VECTORS + ROWS_A_VECTOR * v
        direction = stages[row + STAGES]
        _combine(stages, row, k, A[k], h, vectors[v], n, direction)
        functions.variation(mode, t + C[k] * h, c, place, direction, stages[row + k])


@series
def attempt(functions, t, c, x, h, vectors, live, run, stages, out):
    """A step of length h from the rates at its start: states and quadratures to ``out``, tangents to their last row."""
    n = x.size
    for k in range(1, STAGES):
        stage(functions, run.mode, t, c, x, h, k, vectors, live, stages)
    run.evaluations += STAGES - 1
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
def _estimate(stages, first, n, h, length):
    """Local error as a part of a length in scales, from embedded formulas of orders 5 and 3, as Hairer, Norsett and
    Wanner combine them."""
    fifth = 0.0
    third = 0.0
    for i in range(n):
        a = 0.0
        b = 0.0
        for j in range(STAGES):
            a += E5[j] * stages[first + j, i]
            b += E3[j] * stages[first + j, i]
        # before the square, which overflows where a state has decayed to nothing
        a *= stages[WEIGHTS, i] / length
        b *= stages[WEIGHTS, i] / length
        fifth += a * a
        third += b * b
    return h * fifth / math.sqrt(fifth + 0.01 * third) if fifth > 0.0 else fifth * h


@inner
def size(x, weights):
    """Length of a vector in the scales of the states."""
    total = 0.0
    for i in range(x.size):
        total += abs(x[i]) * weights[i]
    if not 0.0 < total < math.inf:
        return total
    s = 0.0
    for i in range(x.size):
        part = x[i] * weights[i] / total
        s += part * part
    return total * math.sqrt(s)


@inner
def weigh(x, scale, longest, tolerance, stages):
    """Let the scales fade, and note one over them; returns whether any was known.

    Where none is, as at the start of a run, they come from the rates. A state that begins to move later has none yet,
    as its first rate may be nothing but round-off.
    """
    n = x.size
    known = False
    pace = longest
    for i in range(n):
        known = known or scale[i] > SMALLEST
        if x[i] != 0.0 and stages[0, i] != 0.0:
            pace = min(pace, abs(x[i] / stages[0, i]))
    for i in range(stages.shape[1]):
        here = EPSILON / tolerance * abs(x[i]) if i < n else 0.0
        if not known:
            here = max(here, abs(stages[0, i]) * pace)
        scale[i] = max(FADE * scale[i], here)
        stages[WEIGHTS, i] = 1.0 / scale[i] if scale[i] > SMALLEST else 0.0
    return known


@inner
def weigh_all(weights):
    """Give states without a scale the largest one of the others."""
    common = math.inf
    for i in range(weights.size):
        if weights[i] > 0.0:
            common = min(common, weights[i])
    for i in range(weights.size):
        if weights[i] == 0.0:
            weights[i] = common if common < math.inf else 1.0


@inlined
def begun(scale, i, moved):
    """Scale of a state or a quadrature in a step that moves it so far; where it has none yet, this is it."""
    if scale[i] <= SMALLEST and moved < math.inf:
        scale[i] = moved
    return max(scale[i], moved)


@inner
def error_of(x, h, scale, vectors, live, stages):
    """Largest error of a step: of states and quadratures in their scales, of a tangent relative to its length.

    What has begun to move in this step has at least the scale of what it moves, and keeps that of the first length that
    is tried: what begins with a power of time looks alike at all lengths, until round-off is all of it. Tangents count
    states that have none, as what has decayed to nothing, in the largest scale of the others.
    """
    for i in range(stages.shape[1]):
        rate = 0.0
        for j in range(STAGES):
            rate = max(rate, abs(stages[j, i]))
        width = begun(scale, i, rate * h)
        stages[WEIGHTS, i] = 1.0 / width if width > SMALLEST else 0.0
    error = _estimate(stages, 0, stages.shape[1], h, 1.0)
    if live > 0:
        weigh_all(stages[WEIGHTS][: x.size])
    for v in range(live):
        length = size(vectors[v], stages[WEIGHTS])
        if length > 0.0:
            e = _estimate(stages, VECTORS + ROWS_A_VECTOR * v, x.size, h, length) / TANGENTS
            error = e if not e <= error else error
    return error


@inner
def shrink(error, h, larger, longer, full):
    """Part of a rejected step to try next, by the order that two rejected lengths show: near a kink it is not full."""
    if not math.isfinite(error):
        return SMALLEST_GROWTH
    order = full
    floor = SMALLEST_GROWTH
    if error < larger:
        order = min(max(math.log(larger / error) / math.log(longer / h), 1.0), full)
        floor = SMALLEST_GROWTH**3
    return max(SAFETY * error ** (-1.0 / order), floor)


@inner
def first_length(functions, t, state, tolerance, longest, stages):
    """Length of a step to begin with, from the first two derivatives as in section II.4, in any unit of time."""
    run, c, x, vectors = state.run[0], state.c, state.x, state.vectors
    n = x.size
    mode, live = run.mode, run.live
    weights = stages[WEIGHTS]
    speed = size(stages[0][:n], weights)
    for v in range(live):
        length = size(vectors[v], weights)
        if length > 0.0:
            speed = max(speed, size(stages[VECTORS + ROWS_A_VECTOR * v][:n], weights) / length)
    trial = min(0.01 / speed, longest) if speed > 0.0 else longest
    place = stages[PLACE]
    for i in range(n):
        place[i] = x[i] + trial * stages[0, i]
    functions.field(mode, t + trial, c, place, stages[1])
    run.evaluations += 1
    change = 0.0
    for i in range(n):
        change = max(change, abs(stages[1, i] - stages[0, i]) * weights[i])
    for v in range(live):
        length = size(vectors[v], weights)
        row = VECTORS + ROWS_A_VECTOR * v
        direction = stages[row + STAGES]
        for i in range(n):
            direction[i] = vectors[v, i] + trial * stages[row, i]
        functions.variation(mode, t + trial, c, place, direction, stages[row + 1])
        for i in range(n):
            if length > 0.0:
                change = max(change, abs(stages[row + 1, i] - stages[row, i]) * weights[i] / length)
    if not speed > 0.0:
        return longest
    return min((0.01 * tolerance / max(1.0, change / (trial * speed * speed))) ** 0.125 / speed, longest)


@series
def dense_output(functions, t, c, x, h, run, stages, ws):
    """Coefficients of the states' polynomials; the step has been taken."""
    n = x.size
    functions.field(run.mode, t + h, c, stages[END], stages[STAGES])
    for k in range(STAGES + 1, DENSE_STAGES):
        stage(functions, run.mode, t, c, x, h, k, stages, 0, stages)
    run.evaluations += DENSE_STAGES - STAGES
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
