"""An event is taken: projection on the guard, choice of the outcome, reset, saltation of the tangents."""

from chaosdrill.engine.jit import inner
from chaosdrill.engine.layout import (
    AFTER, BEFORE, EVENT_COLUMNS, EVENT_KIND, EVENT_MODE, EVENT_ROWS, EVENT_SPEED, EVENT_STROBES, EVENT_TIME,
    EVENTS_IN_PERIOD, FIRED, FRESH, GRADIENT, IMAGE, LIVE, MARKS_ONLY, MODE, NEW_MODE, RANK_CHECK, RANK_DEFICIENT,
    RESET_JACOBIAN, SALTATION, SAME_MODE, STROBES, TO_MODE,
)


@inner
def _project(value, gradient, x):
    """Put the state on the guard, along the guard's gradient."""
    square = 0.0
    for i in range(x.size):
        square += gradient[i] * gradient[i]
    if square > 0.0:
        for i in range(x.size):
            x[i] -= value * gradient[i] / square


@inner
def _normal_speed(gradient, before, n):
    """Rate at which the guard is crossed: n.F- + dh/dt."""
    speed = gradient[n]
    for i in range(n):
        speed += gradient[i] * before[i]
    return speed


@inner
def saltation_matrix(jacobian, before, after, gradient, speed, out):
    """S = DR + (F+ - DR F- - dR/dt) n^T / (n.F- + dh/dt), into ``out``."""
    n = out.shape[0]
    for i in range(n):
        jump = after[i] - jacobian[i, n]
        for j in range(n):
            jump -= jacobian[i, j] * before[j]
        for j in range(n):
            out[i, j] = jacobian[i, j]
            if gradient[j] != 0.0 and jump != 0.0:
                out[i, j] += jump * gradient[j] / speed


@inner
def _saltate(vectors, carried, scratch):
    """Apply the saltation matrix to the live tangents; returns the largest entry of the images."""
    n = vectors.shape[1]
    matrix = scratch[SALTATION]
    image = scratch[IMAGE]
    largest = 0.0
    for v in range(carried[LIVE]):
        for i in range(n):
            s = 0.0
            for j in range(n):
                s += matrix[i, j] * vectors[v, j]
            image[i] = s
        for i in range(n):
            vectors[v, i] = image[i]
            largest = max(largest, abs(image[i]))
    return largest


@inner
def take(functions, transitions, j, local, t, c, x, vectors, carried, counts, grazing, buffer, scratch):
    """Take the event of guard j at the present state; returns the largest entry of the tangents after it.

    If no outcome's condition holds, nothing happens but that the guard has been passed.
    """
    n = x.size
    mode = carried[MODE]
    gradient = scratch[GRADIENT]
    before = scratch[BEFORE]
    _project(functions[5](mode, j, t, c, x, gradient), gradient, x)
    transition = functions[6](mode, j, t, c, x)
    carried[FIRED] = j
    carried[FRESH] = SAME_MODE
    if transition < 0:
        return 0.0
    functions[3](mode, t, c, x, before)
    functions[5](mode, j, t, c, x, gradient)
    speed = _normal_speed(gradient, before, n)
    recorded = buffer.shape[0] > 0
    if recorded:
        row = buffer[carried[EVENT_ROWS]]
        row[EVENT_STROBES] = carried[STROBES]
        row[EVENT_TIME] = local
        row[EVENT_KIND] = transition
        row[EVENT_MODE] = mode
        row[EVENT_SPEED] = speed
        for i in range(n):
            row[EVENT_COLUMNS + i] = x[i]
    largest = 0.0
    if transitions[transition, MARKS_ONLY] == 0:
        target = transitions[transition, TO_MODE]
        image = scratch[IMAGE]
        functions[7](transition, t, c, x, image, scratch[RESET_JACOBIAN])
        for i in range(n):
            x[i] = image[i]
        if carried[LIVE] > 0:
            functions[3](target, t, c, x, scratch[AFTER])
            saltation_matrix(scratch[RESET_JACOBIAN], before, scratch[AFTER], gradient, speed, scratch[SALTATION])
            largest = _saltate(vectors, carried, scratch)
            if transitions[transition, RANK_DEFICIENT] == 1:
                carried[RANK_CHECK] = 1
        if target != mode:
            carried[MODE] = target
            carried[FRESH] = NEW_MODE
    if recorded:
        for i in range(n):
            row[EVENT_COLUMNS + n + i] = x[i]
        carried[EVENT_ROWS] += 1
    counts[transition] += 1
    grazing[transition] = min(grazing[transition], abs(speed))
    carried[EVENTS_IN_PERIOD] += 1
    return largest
