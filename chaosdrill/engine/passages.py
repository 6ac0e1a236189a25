"""Whether the motion may go on beyond a guard after the guard's own event: a wall throws it back, a kick may not."""

import math

from chaosdrill.codegen.kinds import int64
from chaosdrill.codegen.signatures import event_places
from chaosdrill.engine import layout as at
from chaosdrill.engine.jit import inlined, inner
from chaosdrill.engine.records import unit
from chaosdrill.engine.tuning import STRUCTURE


@inlined
def normal_speed(event, n):
    """Rate at which the guard is crossed: n.F- + dh/dt."""
    place = event_places(n)
    speed = event[place.gradient + n]
    for i in range(n):
        speed += event[place.gradient + i] * event[place.before + i]
    return speed


@inner
def brought_onto(functions, mode, j, t, c, sizes, x, gradient):
    """Bring a state onto a guard by Newton's method, the shortest way in sizes of states; whether it arrives."""
    n = x.size
    for _ in range(50):
        value = functions.guard(mode, j, t, c, x, gradient)
        square = size = 0.0
        for i in range(n):
            square += (gradient[i] * sizes[i]) ** 2
            size += abs(gradient[i] * x[i])
        if not math.isfinite(value + square) or square == 0.0:
            return False
        if abs(value) <= STRUCTURE.on * size:
            return True
        for i in range(n):
            x[i] -= value / square * gradient[i] * sizes[i] * sizes[i]
    return False


@inner
def leads_beyond(functions, transitions, mode, j, direction, t, c, x, event, gradient, rates, ones):
    """Whether the motion goes on beyond a guard (1) after its event at a state on it, or not (0).

    -1 where the motion does not meet the guard there. ``transitions`` is a table of target mode and whether an event
    only marks; ``x`` becomes the state after the event, the other arrays are room, and ``ones`` any scales of states.
    """
    n = x.size
    place = event_places(n)
    event[:] = 0.0
    transition = functions.event_map(mode, j, t, c, x, 1, ones, 0.0, event)
    if not normal_speed(event, n) * direction > 0.0:
        return -1
    target = mode
    if transition >= 0 and transitions[transition, 1] == 0:
        target = transitions[transition, 0]
        for i in range(n):
            x[i] = event[place.image + i]
    value = functions.guard(mode, j, t, c, x, gradient)
    functions.field(target, t, c, x, rates)
    size = abs(value)
    ahead = gradient[n]
    for i in range(n):
        size += abs(gradient[i] * x[i])
        ahead += gradient[i] * rates[i]
    if not abs(value) <= STRUCTURE.on * size:
        ahead = value
    return 1 if ahead * direction > 0.0 else 0


@inlined
def marks_at(functions, tables, state, j, side, t, scratch):
    """What guard j is, in bits, at the present state on a side of it.

    One that lets motions pass somewhere may throw all of them back here, as ``x*(1 + s)`` does where x is zero.
    """
    marks = tables.marks[state.run[0].mode, j]
    asked = side == tables.active[state.run[0].mode, 1 + j]
    if asked and marks & (at.PASSES | at.TIMED | at.MARKS) == at.PASSES:
        return _marks_about(functions, tables, state, j, t, scratch)
    return marks


@unit(int64)
def _marks_about(functions, tables, state, j, t, scratch):
    """The same of a guard that may let motions pass: the state is moved as little as makes it meet the guard."""
    c, sizes, gradient, rates = state.c, scratch.image, scratch.gradient, scratch.after
    mode, n = state.run[0].mode, state.x.size
    x, ones = scratch.before[:n], scratch.none[:n]
    marks, direction = tables.marks[mode, j], tables.active[mode, 1 + j]
    for i in range(n):
        sizes[i] = max(state.scale[i], abs(state.x[i]))
        if sizes[i] == 0.0:
            sizes[i] = 1.0
    part = STRUCTURE.about
    for _ in range(STRUCTURE.farther):
        found = -1
        for k in range(2 * n):
            for i in range(n):
                x[i] = state.x[i]
            x[k // 2] += (1 - 2 * (k % 2)) * part * sizes[k // 2]
            if brought_onto(functions, mode, j, t, c, sizes, x, gradient):
                way = leads_beyond(
                    functions, tables.transitions, mode, j, direction, t, c, x, scratch.event, gradient, rates, ones
                )
                found = max(found, way)
        if found >= 0:
            return marks if found == 1 else marks & ~(at.PASSES | at.OPEN)
        part *= 4.0
    return marks
