"""Classical fourth-order Runge-Kutta steps of fixed length with bisection, the method of the paper.

A guard is looked at only at the two ends of a step, and an event is as exact as the bisection; two crossings inside one
step pass unseen. It is here to be compared with.
"""

import math

from chaosdrill.engine import scales
from chaosdrill.engine.guards import begun_at, has_fired, is_moved, is_thrown, is_zero, rests, side_before, stand
from chaosdrill.engine.jit import inner
from chaosdrill.engine.layout import BEGIN, FIRE, INVALID, NOWHERE, ONGOING, STILL
from chaosdrill.engine.records import machine_at, state_of
from chaosdrill.engine.stepper import offered
from chaosdrill.engine.tuning import STEPS

METHOD = {"summary": "fixed-step Runge-Kutta of order 4 with bisection, the method of the paper", "fixed_step": True}


@inner
def _mean(stages, first, i):
    return (stages[first, i] + 2.0 * (stages[first + 1, i] + stages[first + 2, i]) + stages[first + 3, i]) / 6.0


@inner
def move(functions, run, t, c, x, s, vectors, live, out, stages):
    """States and quadratures (``out``) and tangents (row 10 + 6 v of ``stages``) after a step of length s."""
    n = x.size
    mode = run.mode
    run.evaluations += 4
    place = stages[0]
    for k in range(4):
        part = 0.0 if k == 0 else (s if k == 3 else 0.5 * s)
        for i in range(n):
            place[i] = x[i] + (part * stages[k, i] if k > 0 else 0.0)
        functions.field(mode, t + part, c, place, stages[1 + k])
        for v in range(live):
            row = 5 + 6 * v
            direction = stages[row]
            for i in range(n):
                direction[i] = vectors[v, i] + (part * stages[row + k, i] if k > 0 else 0.0)
            functions.variation(mode, t + part, c, place, direction, stages[row + 1 + k])
    for i in range(n):
        out[i] = x[i] + s * _mean(stages, 1, i)
    for i in range(n, out.size):
        out[i] = s * _mean(stages, 1, i)
    for v in range(live):
        row = 5 + 6 * v
        for i in range(n):
            stages[row + 5, i] = vectors[v, i] + s * _mean(stages, row + 1, i)


@inner
def _leads(gradient, rates, s, ahead):
    """Whether the speed of a guard at zero, not what changes it, leads to its value ``ahead`` the time s later.

    A rebound that is over within that time is not seen: without a speed of its own the state is held by its wall.
    """
    n = gradient.size - 1
    speed = gradient[n]
    for i in range(n):
        speed += gradient[i] * rates[i]
    return abs(speed * s) > abs(ahead - speed * s)


@inner
def _settle(functions, tables, settings, state, j, s, ahead, t, scratch):
    """How guard j stands where its side is not known, or an event came before; ``ahead`` is its value the time s later.

    Where it leaves zero to the side from which it came its zero is of even order; where it does not leave, it waits.
    """
    run = state.run[0]
    mode = run.mode
    key = tables.keys[mode, j]
    old, crossed = side_before(tables, state, j)
    if abs(old) > 1 and not crossed and not is_moved(key, tables, state):
        return FIRE, old
    here = functions.guard(mode, j, t, state.c, state.x, scratch.gradient)
    if run.fresh == BEGIN:
        here = begun_at(functions, tables, settings, state, j, here, abs(ahead - here), s, t, scratch)
    zero, old = is_zero(functions, tables, state, j, here, (ahead - here) / s, old, crossed, t, scratch)
    if zero and (ahead == 0.0 or tables.marks[mode, j] & STILL):
        return NOWHERE, old
    side = 1 if (ahead if zero else here) > 0.0 else -1
    direction = tables.active[mode, 1 + j]
    fired = has_fired(state, key, direction) if zero else 0
    order = 2 if fired and not _leads(scratch.gradient, scratch.stages[1], s, ahead) else 1
    if zero and old == 0 and not fired:
        before, n = scratch.before, state.x.size
        move(functions, run, t, state.c, state.x, -s, scratch.stages, 0, before, scratch.stages)
        order = 2 if functions.guard(mode, j, t - s, state.c, before[:n], scratch.gradient) * ahead > 0.0 else 1
    return stand(zero, side, order, old, direction, run.fresh, fired, tables.marks[mode, j])


@offered
def expand(place, p, t):
    """Length of the step to the next point of the fixed grid; the sizes of the states are noted for those who ask."""
    state = state_of(machine_at(place).states, p)
    run, x, scale = state.run[0], state.x, state.scale
    for i in range(x.size):
        scale[i] = scales.brought(scale[i], x[i], 1.0)
    step = run.fixed_step
    h = step - run.time % step
    return h if h > 1e-9 * step else h + step


@offered
def locate(place, p, te, h, t):
    """First event of the step by the signs at its ends and bisection: (time or -1, guard, ties).

    The time is NaN where a guard is.
    """
    machine = machine_at(place)
    functions, settings, tables, scratch = machine.functions, machine.settings[0], machine.tables, machine.scratch
    state = state_of(machine.states, p)
    run, c, x, sides = state.run[0], state.c, state.x, state.sides
    stages, gradient, times, backs, out = scratch.stages, scratch.gradient, scratch.times, scratch.backs, scratch.out
    mode = run.mode
    count = tables.active[mode, 0]
    fires = -1
    for j in range(count):
        if rests(tables, state, j) or (run.fresh == ONGOING and sides[tables.keys[mode, j]] != 0):
            continue
        s = STEPS.probe * h
        move(functions, run, t, c, x, s, stages, 0, out, stages)
        ahead = functions.guard(mode, j, t + s, c, out[: x.size], gradient)
        how, side = _settle(functions, tables, settings, state, j, s, ahead, t, scratch)
        if how == INVALID:
            return -2.0, j, 0
        sides[tables.keys[mode, j]] = side
        if how == FIRE and (fires < 0 or (is_thrown(tables, state, j) and not is_thrown(tables, state, fires))):
            fires = j
    if fires >= 0:
        return 0.0, fires, 0
    move(functions, run, t, c, x, h, stages, 0, out, stages)
    run.turning = 0
    for j in range(count):
        times[j] = functions.guard(mode, j, t + h, c, out[: x.size], gradient)
        if times[j] != times[j]:
            return math.nan, j, 0
    best, found, ties = -1.0, -1, 0
    for j in range(count):
        backs[j] = -1.0
        side = sides[tables.keys[mode, j]]
        if side == 0 or tables.marks[mode, j] & STILL or not times[j] * side <= 0.0:
            continue
        direction = tables.active[mode, 1 + j]
        if direction == side and direction != 0:
            backs[j] = h
            run.turning = 1
            continue
        low, high = 0.0, h
        while high - low > settings.tolerance * h:
            middle = 0.5 * (low + high)
            if middle <= low or middle >= high:
                break
            move(functions, run, t, c, x, middle, stages, 0, out, stages)
            if functions.guard(mode, j, t + middle, c, out[: x.size], gradient) * side <= 0.0:
                high = middle
            else:
                low = middle
        if found < 0 or high < best - STEPS.tie * h:
            best = high
            found = j
            ties = 0
        elif high <= best + STEPS.tie * h:
            ties += 1
    return best, found, ties


@offered
def evaluate(place, p, t, s):
    """States and quadratures after a step of length s."""
    machine = machine_at(place)
    state = state_of(machine.states, p)
    stages = machine.scratch.stages
    move(machine.functions, state.run[0], t, state.c, state.x, s, stages, 0, machine.scratch.out, stages)


@offered
def advance(place, p, t, s):
    """States and quadratures and, in place, tangents after a step of length s."""
    machine = machine_at(place)
    state = state_of(machine.states, p)
    run, x, vectors, stages = state.run[0], state.x, state.vectors, machine.scratch.stages
    move(machine.functions, run, t, state.c, x, s, vectors, run.live, machine.scratch.out, stages)
    for v in range(run.live):
        for i in range(x.size):
            vectors[v, i] = stages[10 + 6 * v, i]
