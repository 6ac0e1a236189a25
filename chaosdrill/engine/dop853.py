"""Adaptive Runge-Kutta method of order 8 with dense output of order 7 (Dormand and Prince, code DOP853).

Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, 2nd ed. 1993, section II.5
(doi:10.1007/978-3-540-78862-1). It asks nothing of the right-hand side but values, so it goes on where a Taylor series
does not exist. Guards become polynomials through the dense output; samples, strobes and events are steps of their own
of exactly the length asked for, so that they are as exact as the end of a step.
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
from chaosdrill.engine.guard_series import guard_polynomials
from chaosdrill.engine.guards import earliest
from chaosdrill.engine.jit import inner, series
from chaosdrill.engine.layout import (
    EVALUATIONS,
    FRESH,
    LIVE,
    LONGEST,
    MODE,
    NEXT_STEP,
    ONGOING,
    PERIOD,
    SAME_MODE,
    STROBES,
    TARGET,
    TOLERANCE,
    TRIED,
)
from chaosdrill.engine.stepper import offered

SAFETY = 0.9
LARGEST_GROWTH = 6.0
SMALLEST_GROWTH = 0.1
"""A step into a contact may have to shrink by orders of magnitude."""

UNDERFLOW = 1e-14
"""Part of the longest step below which shortening is given up."""

NEAR = 1e-6
"""Events within this part of the step of the first one are located as well: which is first is then seen exactly."""

INTERPOLATED = 1e-10
"""What the polynomial of a curved guard may leave out at least: below is round-off."""


@series
def _combine(stages, first, count, weights, h, start, n, out):
    for i in range(n):
        s = 0.0
        for j in range(count):
            s += weights[j] * stages[first + j, i]
        out[i] = start[i] + h * s


@series
def _stage(field, variation, mode, t, c, x, h, k, vectors, live, stages):
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
def _attempt(field, variation, t, c, x, h, vectors, live, carried, stages, out):
    """A step of length h from the rates at its start: states and quadratures to ``out``, tangents to their last row."""
    n = x.size
    for k in range(1, STAGES):
        _stage(field, variation, carried[MODE], t, c, x, h, k, vectors, live, stages)
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
def _size(x):
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
def _error(x, h, vectors, live, stages):
    """Largest error of a step: of states and quadratures relative to max(1, |x|), of a tangent to its length."""
    error = _estimate(stages, 0, stages.shape[1], h) / _scale(x)
    for v in range(live):
        length = _size(vectors[v])
        if length > 0.0:
            e = _estimate(stages, VECTORS + ROWS_A_VECTOR * v, x.size, h) / length
            error = e if not e <= error else error
    return error


@inner
def _first_length(field, variation, t, c, x, vectors, live, carried, tolerance, longest, stages):
    """Length of a step to begin with, from the first two derivatives (section II.4); 0 if there are none."""
    n = x.size
    mode = carried[MODE]
    scale = _scale(x)
    speed = _size(stages[0]) / scale
    for v in range(live):
        length = _size(vectors[v])
        if length > 0.0:
            speed = max(speed, _size(stages[VECTORS + ROWS_A_VECTOR * v][:n]) / length)
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
        length = _size(vectors[v])
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
def _dense_output(field, variation, t, c, x, h, carried, stages, ws):
    """Coefficients of the states' polynomials; the step has been taken."""
    n = x.size
    field(carried[MODE], t + h, c, stages[END], stages[STAGES])
    for k in range(STAGES + 1, DENSE_STAGES):
        _stage(field, variation, carried[MODE], t, c, x, h, k, stages, 0, stages)
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


@offered
def expand(
    field,
    variation,
    guard,
    first,
    count,
    marks,
    settings_i,
    settings_f,
    local,
    t,
    c,
    x,
    vectors,
    carried,
    carried_f,
    ws,
    stages,
    gradient,
):
    """Take a step within tolerance and turn the guards into polynomials; returns its length, NaN if there is no rate.

    The guards' polynomials have their own part in the length: what they leave out must be below the tolerance.
    """
    mode = carried[MODE]
    live = carried[LIVE]
    tolerance = settings_f[TOLERANCE]
    longest = settings_f[PERIOD]
    field(mode, t, c, x, stages[0])
    carried[EVALUATIONS] += 1
    for v in range(live):
        variation(mode, t, c, x, vectors[v], stages[VECTORS + ROWS_A_VECTOR * v])
    if not math.isfinite(_size(stages[0])):
        return math.nan
    h = carried_f[NEXT_STEP]
    if h <= 0.0 or carried[FRESH] not in (ONGOING, SAME_MODE):
        h = _first_length(field, variation, t, c, x, vectors, live, carried, tolerance, longest, stages)
    wanted = h
    rest = longest - local
    if carried[STROBES] + 1 >= settings_i[TARGET] and rest > NEAR * longest:
        h = min(h, rest)
    rejected = False
    halvings = 0
    while h > UNDERFLOW * carried_f[LONGEST]:
        _attempt(field, variation, t, c, x, h, vectors, live, carried, stages, stages[END])
        error = _error(x, h, vectors, live, stages) / tolerance
        factor = LARGEST_GROWTH
        if not error <= 1e-9:
            factor = SAFETY * error**-0.125
        if not error <= 1.0:
            rejected = True
            h *= factor if factor > SMALLEST_GROWTH else SMALLEST_GROWTH
            continue
        if count > 0:
            _dense_output(field, variation, t, c, x, h, carried, stages, ws)
            left = guard_polynomials(
                guard, mode, count, marks, t, c, x, h, stages[0], stages[PLACE], gradient, ws, first
            )
            if left > max(tolerance, INTERPOLATED) and halvings < 6:
                halvings += 1
                rejected = True
                h *= 0.5
                continue
        following = h * (min(factor, 1.0) if rejected else min(factor, LARGEST_GROWTH))
        carried_f[NEXT_STEP] = min(following if rejected else max(following, wanted), longest)
        carried_f[TRIED] = h
        break
    return h


@inner
def _newton(field, variation, guard, j, s, h, t, c, x, carried, g, stages, gradient, out):
    """Root near s of a guard along steps of that length; s itself where the two of a near double root merge."""
    n = x.size
    mode = carried[MODE]
    rate = stages[STAGES]
    for _ in range(8):
        _attempt(field, variation, t, c, x, s, stages, 0, carried, stages, out)
        field(mode, t + s, c, out, rate)
        carried[EVALUATIONS] += 1
        value = guard(mode, j, t + s, c, out[:n], gradient)
        slope = gradient[n]
        for i in range(n):
            slope += gradient[i] * rate[i]
        bend = 0.0
        for k in range(g.size - 1, 1, -1):
            bend = bend * s + k * (k - 1) * g[k]
        square = slope * slope - 2.0 * bend * value
        if slope == 0.0 or not square >= 0.0:
            return s
        move = -2.0 * value / (slope + math.copysign(math.sqrt(square), slope))
        if not abs(move) <= 0.01 * h or s + move <= 0.0:
            return s
        s += move
        if abs(bend) * move * move <= 1e-15 * h * abs(slope):
            return s
    return s


@offered
def locate(
    field,
    variation,
    guard,
    first,
    count,
    directions,
    marks,
    settings_f,
    te,
    h,
    t,
    c,
    x,
    carried,
    sides,
    armed,
    ws,
    stages,
    gradient,
    times,
    out,
):
    """Make the times of the events exact by Newton steps on the guards themselves: (time, guard, ties)."""
    for j in range(count):
        if times[j] > te + NEAR * h:
            times[j] = -1.0
        elif times[j] > 0.0:
            times[j] = _newton(
                field, variation, guard, j, times[j], h, t, c, x, carried, ws[first + j], stages, gradient, out
            )
    return earliest(times, count, h)


@offered
def evaluate(field, variation, t, c, x, s, carried, stages, out):
    """States and quadratures after a step of length s, as exact as the end of a step; the step taken is kept."""
    _attempt(field, variation, t, c, x, s, stages, 0, carried, stages, out)


@offered
def advance(field, variation, t, c, x, s, vectors, carried, carried_f, stages, out):
    """States and quadratures and, in place, tangents after a step of length s."""
    n = x.size
    live = carried[LIVE]
    if s != carried_f[TRIED]:
        _attempt(field, variation, t, c, x, s, vectors, live, carried, stages, stages[END])
    for i in range(out.size):
        out[i] = stages[END, i]
    for v in range(live):
        for i in range(n):
            vectors[v, i] = stages[VECTORS + ROWS_A_VECTOR * v + STAGES + 1, i]
