"""Classical fourth-order Runge-Kutta steps of fixed length with bisection, the method of the paper.

A guard is looked at only at the two ends of a step, and an event is as exact as the bisection; two crossings inside one
step pass unseen. It is here to be compared with.
"""

from chaosdrill.engine.guards import TIE, stand
from chaosdrill.engine.jit import inner
from chaosdrill.engine.layout import (
    EVALUATIONS,
    FIRE,
    FIRED,
    FRESH,
    INVALID,
    LIVE,
    MARKS,
    MODE,
    ONGOING,
    PASSED,
    STEP,
    TOLERANCE,
)
from chaosdrill.engine.stepper import offered

_PROBE = 1e-3
_ZERO = 1e-11


@inner
def _mean(stages, first, i):
    return (stages[first, i] + 2.0 * (stages[first + 1, i] + stages[first + 2, i]) + stages[first + 3, i]) / 6.0


@inner
def move(field, variation, carried, t, c, x, s, vectors, live, out, stages):
    """States and quadratures (``out``) and tangents (row 10 + 6 v of ``stages``) after a step of length s."""
    n = x.size
    mode = carried[MODE]
    carried[EVALUATIONS] += 4
    place = stages[0]
    for k in range(4):
        part = 0.0 if k == 0 else (s if k == 3 else 0.5 * s)
        for i in range(n):
            place[i] = x[i] + (part * stages[k, i] if k > 0 else 0.0)
        field(mode, t + part, c, place, stages[1 + k])
        for v in range(live):
            row = 5 + 6 * v
            direction = stages[row]
            for i in range(n):
                direction[i] = vectors[v, i] + (part * stages[row + k, i] if k > 0 else 0.0)
            variation(mode, t + part, c, place, direction, stages[row + 1 + k])
    for i in range(n):
        out[i] = x[i] + s * _mean(stages, 1, i)
    for i in range(n, out.size):
        out[i] = s * _mean(stages, 1, i)
    for v in range(live):
        row = 5 + 6 * v
        for i in range(n):
            stages[row + 5, i] = vectors[v, i] + s * _mean(stages, row + 1, i)


@inner
def _crossed(guard, mode, j, t, c, x, gradient, side):
    value = guard(mode, j, t, c, x, gradient)
    return value * side <= 0.0


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
    """Length of the step to the next point of the fixed grid."""
    step = settings_f[STEP]
    h = step - local % step
    return h if h > 1e-9 * step else h + step


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
    """First event of the step by the signs at its ends and bisection: (time or -1, guard, ties)."""
    fresh = carried[FRESH]
    fired = carried[FIRED]
    mode = carried[MODE]
    if fresh != ONGOING:
        move(field, variation, carried, t, c, x, _PROBE * h, stages, 0, out, stages)
        for j in range(count):
            here = guard(mode, j, t, c, x, gradient)
            ahead = guard(mode, j, t + _PROBE * h, c, out[: x.size], gradient)
            order = 1 if abs(here) <= _ZERO * max(1.0, abs(ahead)) or here * ahead < 0.0 else 0
            value = ahead if order == 1 else here
            if value == 0.0:
                armed[j] = 0
                continue
            sides[j] = 1 if value > 0.0 else -1
            how = stand(sides[j], directions[j], order, fresh, marks[j] & MARKS != 0, j == fired, armed[j] == 1)
            if how == INVALID:
                return -2.0, j, 0
            armed[j] = 0 if how == PASSED else 1
            if how == FIRE:
                return 0.0, j, 0
    move(field, variation, carried, t, c, x, h, stages, 0, out, stages)
    best = -1.0
    found = -1
    ties = 0
    for j in range(count):
        if armed[j] == 0:
            value = guard(mode, j, t + h, c, out[: x.size], gradient)
            if value * directions[j] < 0.0:
                armed[j] = 1
                sides[j] = -directions[j]
            continue
        move(field, variation, carried, t, c, x, h, stages, 0, out, stages)
        if not _crossed(guard, mode, j, t + h, c, out[: x.size], gradient, sides[j]):
            continue
        low = 0.0
        high = h
        while high - low > settings_f[TOLERANCE]:
            middle = 0.5 * (low + high)
            if middle <= low or middle >= high:
                break
            move(field, variation, carried, t, c, x, middle, stages, 0, out, stages)
            if _crossed(guard, mode, j, t + middle, c, out[: x.size], gradient, sides[j]):
                high = middle
            else:
                low = middle
        if found < 0 or high < best - TIE * h:
            best = high
            found = j
            ties = 0
        elif high <= best + TIE * h:
            ties += 1
    return best, found, ties


@offered
def evaluate(field, variation, t, c, x, s, carried, stages, out):
    """States and quadratures after a step of length s."""
    move(field, variation, carried, t, c, x, s, stages, 0, out, stages)


@offered
def advance(field, variation, t, c, x, s, vectors, carried, carried_f, stages, out):
    """States and quadratures and, in place, tangents after a step of length s."""
    live = carried[LIVE]
    move(field, variation, carried, t, c, x, s, vectors, live, out, stages)
    for v in range(live):
        for i in range(x.size):
            vectors[v, i] = stages[10 + 6 * v, i]
