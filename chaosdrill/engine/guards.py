"""Events: the side of a guard, how it changes, and which guard fires first in a step.

A run stores the side of each guard. It reads the side off the guard's value at the start, in a mode that begins to
watch the guard, and after a reset that moved the guard. From then on only a located root changes the side, once, and
the sign of a rounded value near zero does not matter. So no event is lost or seen twice where a step, a strobe or a
call ends on a root ("discontinuity sticking", Park and Barton 1996,
doi:10.1145/232807.232809). A value counts as zero within a bound of its own rounding error.
"""

import math

from chaosdrill.codegen.kinds import uint64
from chaosdrill.codegen.layout import EPSILON, ROUNDING
from chaosdrill.engine import layout as at
from chaosdrill.engine.guard_errors import POWER_NOISE, left_out, near, root_error, told_length
from chaosdrill.engine.guard_roots import degree_of, settled, told_before, unit_of
from chaosdrill.engine.jit import inlined, inner, rare
from chaosdrill.engine.passages import marks_at
from chaosdrill.engine.polynomial import keeps_side, size, value
from chaosdrill.engine.roots import first_crossing, recrossing
from chaosdrill.engine.tuning import GUARDS

JUMPED, HELD, PUT_ACROSS, PLACED = 2, 3, 4, 5
"""A side times one of the first three says that the guard is about to fire: the last event's reset threw the state
across it, the motion would not leave it any more, or the state was put beyond it from elsewhere. ``PLACED`` says that
the guard is zero, and was crossed to this side with the surface of the last event."""

SEEN, FOUND = -1, -2
"""In place of the order of a guard's zero: it has no root that is still to be looked for, or one that has been."""


@inlined
def stand(zero, side, order, old, direction, fresh, fired, marks):
    """How a guard stands at the start of a step, and its side: the definition of an event.

    Parameters
    ----------
    zero : bool
        Whether the guard is zero, to its error or because its surface has just been crossed.
    side : int
        The side on which it is, or to which the motion leads from zero.
    order : int
        First derivative that does not vanish, where it is zero.
    old : int
        Its side before, or that to which its surface has just been crossed; 0 if nothing is known.
    direction : int
        That of its events, 0 for either.
    fresh : int
        What came before the step.
    fired : int
        Whether its own event is what came before, and has left it at zero (1, or ``HELD``); else 0.
    marks : int
        What it is.
    """
    ahead = side == direction
    if fired:
        # a motion that does not leave a wall again with any speed is held by it, and so by those that follow
        if ahead and (order > 1 or fired == HELD) and marks & (at.MARKS | at.PASSES) == 0:
            return at.FIRE, -HELD * side
    elif old == 0:
        # by a root of even order a run that may begin beyond the guard comes from there, and does not cross it
        crosses = order % 2 == 1 or marks & at.OPEN == 0
        if zero and ((ahead and crosses) or (direction == 0 and fresh == at.BEGIN and order % 2 == 1)):
            return at.FIRE, -side
        if not zero and ahead and marks & at.OPEN == 0:
            return (at.INVALID, side) if fresh == at.BEGIN else (at.FIRE, -_across(fresh) * side)
    else:
        before = 1 if old > 0 else -1
        if side != before and (ahead or direction == 0):
            return at.FIRE, before if zero else _across(fresh) * before
    return at.PASSED if ahead and direction != 0 else at.ARMED, side


@inlined
def _across(fresh):
    """Who threw a state across a guard."""
    return JUMPED if fresh == at.AFTER else PUT_ACROSS


@inlined
def is_on(side, here):
    """Whether a guard has a side and no event before it, and its value says the same; for one run or for lanes."""
    return (here * side > 0.0) & (side * side <= 1.0)


@inlined
def is_armed(side, direction):
    """Whether a guard on a side can be crossed from there, and need not come back first."""
    return side * direction <= 0.0


@inlined
def is_moved(key, tables, state):
    """Whether the event that came before the step may have changed the guard by its reset."""
    run = state.run[0]
    return run.fresh == at.PUT or (run.fresh == at.AFTER and run.moved_by >= 0 and tables.moves[run.moved_by, key] == 1)


@inlined
def rests(tables, state, j):
    """Whether guard j, which no motion of the mode changes, is on the side on which it was, whatever rounding says."""
    run = state.run[0]
    key = tables.keys[run.mode, j]
    known = run.fresh == at.ONGOING or (abs(state.sides[key]) == 1 and not is_moved(key, tables, state))
    return known and tables.marks[run.mode, j] & at.STILL != 0


@rare
def _ratio(functions, tables, state, j, t, scratch):
    """The gradient of guard j, which is zero, over that of the surface of the last event; 0 if that was another one.

    Surfaces are one where gradients are parallel, states being measured by their sizes and time by the period.
    """
    run, scale, normal, gradient = state.run[0], state.scale, state.normal, scratch.gradient
    n = state.x.size
    functions.guard(run.mode, j, t, state.c, state.x, gradient)
    largest = own_largest = 0.0
    for a in range(n + 1):
        width = run.period if a == n else scale[a]
        largest = max(largest, abs(normal[a]) * width)
        own_largest = max(own_largest, abs(gradient[a]) * width)
    unit, own_unit = unit_of(largest), unit_of(own_largest)
    square = own_square = dot = 0.0
    for a in range(n + 1):
        width = run.period if a == n else scale[a]
        part, own = normal[a] * width * unit, gradient[a] * width * own_unit
        square += part * part
        own_square += own * own
        dot += part * own
    if dot == 0.0 or not dot * dot >= (1.0 - GUARDS.parallel) * square * own_square:
        return 0.0
    return dot / square * unit / own_unit


@inlined
def side_before(tables, state, j):
    """The side of guard j before the step, and whether it is zero since its surface has just been crossed."""
    run = state.run[0]
    key = tables.keys[run.mode, j]
    old = state.sides[key]
    if abs(old) == PLACED:
        return (1 if old > 0 else -1), True
    crossed = run.fresh == at.AFTER and tables.surfaces[run.mode, j] == run.surface and not is_moved(key, tables, state)
    return (run.way if crossed and old == 0 else old), crossed


@inlined
def is_zero(functions, tables, state, j, here, slope, old, crossed, t, scratch):
    """Whether guard j, whose value and slope are given, is zero to its error, and its side before the step.

    Its error is that of the states, where the side is read off the value, and after an event what it changes by as the
    time of that is rounded: else a sign other than that of its side says so.
    """
    run = state.run[0]
    key = tables.keys[run.mode, j]
    if crossed or not (old == 0 or is_moved(key, tables, state)):
        zero = crossed or here * old <= 0.0
        if zero:
            scratch.errors[0] = functions.guard_error(run.mode, j, t, state.c, state.x, scratch.none)
            scratch.errors[1] = functions.rate_error(run.mode, j, t, state.c, state.x, scratch.none)
        return zero, old
    scratch.errors[0] = functions.guard_error(run.mode, j, t, state.c, state.x, state.doubt)
    if run.fresh == at.AFTER:
        scratch.errors[0] += 2.0 * EPSILON / ROUNDING * abs(t * slope)
    bound = ROUNDING * scratch.errors[0]
    if run.fresh == at.AFTER and tables.surfaces[run.mode, j] == run.surface:
        bound += 2.0 * run.residual
    zero = abs(here) <= (bound if math.isfinite(bound) else 0.0)
    if zero:
        scratch.errors[1] = functions.rate_error(run.mode, j, t, state.c, state.x, state.doubt)
    if zero and old == 0 and run.fresh == at.AFTER and run.way != 0:
        ratio = _ratio(functions, tables, state, j, t, scratch)
        if ratio != 0.0:
            old = run.way if ratio > 0.0 else -run.way
            state.sides[key] = PLACED * old
    return zero, old


@inlined
def has_fired(state, key, direction):
    """Whether the last event was that of a guard, or of another one by which its surface was crossed in its direction.

    1, or ``HELD`` where the motion did not leave that one; 0 if it was another event.
    """
    run = state.run[0]
    own = run.fired == key or state.sides[key] * direction == PLACED
    return (HELD if run.held == 1 else 1) if run.fresh == at.AFTER and own else 0


@inlined
def look(functions, tables, state, j, here, slope, t, scratch):
    """How guard j stands by its value and slope: (how, side, vanishing order); UNSURE where both vanish."""
    run = state.run[0]
    key = tables.keys[run.mode, j]
    old, crossed = side_before(tables, state, j)
    if abs(old) > 1 and not crossed and not is_moved(key, tables, state):
        return at.FIRE, old, 0
    if here != here:
        return at.NOWHERE, 0, 0
    zero, old = is_zero(functions, tables, state, j, here, slope, old, crossed, t, scratch)
    order = 0
    side = 1 if here > 0.0 else -1
    if zero and tables.marks[run.mode, j] & at.STILL:
        return at.NOWHERE, old, 0
    if zero:
        bound = ROUNDING * scratch.errors[1]
        if not abs(slope) > (bound if math.isfinite(bound) else 0.0):
            return at.UNSURE, old, 0
        order = 1
        side = 1 if slope > 0.0 else -1
    direction = tables.active[run.mode, 1 + j]
    fired = has_fired(state, key, direction) if zero else 0
    marks = tables.marks[run.mode, j]
    if fired == HELD or (old == 0 and not zero):
        marks = marks_at(functions, tables, state, j, side, t, scratch)
    how, side = stand(zero, side, order, old, direction, run.fresh, fired, marks)
    return how, side, order


@inlined
def stand_at_rest(functions, tables, state, j, order, side, slope, t, scratch):
    """How guard j stands, (how, side), where its value and slope vanish and a later derivative leads to a side.

    An event that has not turned the motion has led it across, whatever rounding makes of the derivatives.
    """
    run = state.run[0]
    key = tables.keys[run.mode, j]
    old, crossed = side_before(tables, state, j)
    direction = tables.active[run.mode, 1 + j]
    fired = has_fired(state, key, direction)
    marks = marks_at(functions, tables, state, j, side, t, scratch)
    if crossed and run.way != 0:
        own = tables.surfaces[run.mode, j] == run.surface
        ratio = 1.0 if own else _ratio(functions, tables, state, j, t, scratch)
        speed = ratio * run.speed
        error = ROUNDING * functions.rate_error(run.mode, j, t, state.c, state.x, scratch.none)
        # a wall that is met with no speed may have turned it
        told = abs(speed) > error or marks & (at.MARKS | at.PASSES)
        if told and abs(slope - speed) <= error:
            side = run.way if ratio > 0.0 else -run.way
    return stand(True, side, order, old, direction, run.fresh, fired, marks)


@inlined
def out_first(term, order, off, total, h):
    """Whether the term of some order of a polynomial that vanishes leads out of its error before the later ones."""
    part = (off / abs(term)) ** (1.0 / order) / h if order > 1 else off / (abs(term) * h)
    return total * part ** (order + 1) <= 0.25 * off


@inner
def _clear_side(ws, i, h, doubt):
    """On which side a polynomial first is by more than a doubt, 0 for none: seen where halves of the step end."""
    for k in range(20, -1, -1):
        here = value(ws, uint64(i), h * 0.5**k)
        if abs(here) > doubt:
            return 1 if here > 0.0 else -1
    return 0


@rare
def begun_at(functions, tables, settings, state, j, here, reach, h, t, scratch):
    """Value of guard j where a run begins: 0 if that is beyond it by no more than the error of where another run ends.

    That is some tolerances (``GUARDS.late``) of what the guard is made of, and of what it changes by in a step,
    ``reach``. The state is then no better known than what it moves in the step. Time has no such error.
    """
    run = state.run[0]
    if not here * tables.active[run.mode, 1 + j] > 0.0 or tables.marks[run.mode, j] & at.TIMED:
        return here
    error = functions.guard_error(run.mode, j, t, state.c, state.x, scratch.none)
    if not abs(here) <= GUARDS.late * settings.tolerance * (error + reach):
        return here
    run.longest = h
    return 0.0


@inlined
def settle(functions, tables, settings, state, ws, i, j, n, h, t, scratch):
    """As ``look`` for guard j whose polynomial is row i; the order is that to which the row counts as zero.

    The order of a root is that of the term that first leads out of the guard's error: beyond a simple root it may come
    back before it is clear of that. Where an interpolation may hide the term, the value itself says where it leads.
    """
    g = ws[i]
    if state.run[0].fresh == at.BEGIN:
        g[0] = begun_at(functions, tables, settings, state, j, g[0], size(ws, uint64(i), h), h, t, scratch)
    how, side, order = look(functions, tables, state, j, g[0], g[1], t, scratch)
    if order == 0 and how != at.UNSURE:
        return how, side, order
    total = size(ws, uint64(i), h)
    off = ROUNDING * scratch.errors[0]
    slope = g[1]
    nearest = math.inf
    if how == at.UNSURE:
        g[1] = 0.0
    else:
        if out_first(g[1], 1, off, total, h):
            return how, side, order
        nearest = 2.0 * off / abs(g[1])
        if nearest < h and size(ws, uint64(i), nearest) - abs(g[0]) < 3.0 * off:
            # clear of the error there, whatever the other terms are
            return how, side, order
    left = left_out(functions, tables, settings, state, ws, i, j, h, t, scratch)
    moved = ROUNDING * scratch.errors[1] * h
    if settings.stepping != at.BY_SERIES and math.isfinite(moved):
        # of a rate that cancels, the later terms of an interpolation have the rounding
        left += moved
    affine = tables.marks[state.run[0].mode, j] & at.AFFINE
    # derivatives of what an interpolation leaves out over the whole step are larger than that
    part = h / state.run[0].tried if left > 0.0 else 0.0
    unknown = (100.0 if affine else 1.0) * left * part
    hidden = False
    power = h
    for k in range(2, n + 1):
        power *= h
        unknown *= part
        # a series leaves out nothing, and may have more terms than what is interpolated
        noise = POWER_NOISE[k] if unknown > 0.0 and not affine else 1.0
        if abs(g[k]) * power > GUARDS.vanishing * total + noise * unknown:
            reach = (off / abs(g[k])) ** (1.0 / k)
            if reach < nearest:
                nearest = reach
                order = k
                if out_first(g[k], k, off, total, h):
                    break
        elif abs(g[k]) * power > GUARDS.vanishing * total:
            hidden = True
    if hidden:
        ahead = _clear_side(ws, i, h, off + left)
        if ahead != 0:
            how, side = stand_at_rest(functions, tables, state, j, max(order, 2), ahead, slope, t, scratch)
            g[0] = side * (off + left)
            return how, side, 0
    if order == 0:
        return at.NOWHERE, side, 0
    if order > 1:
        ahead = 1 if g[order] > 0.0 else -1
        how, side = stand_at_rest(functions, tables, state, j, order, ahead, slope, t, scratch)
        lower = 0.0
        for k in range(order - 1, 0, -1):
            lower = (lower + abs(g[k])) * h
        if lower > GUARDS.vanishing * total or side != ahead:
            # what is left of the earlier terms counts farther away; the value is on its side by no more than its error
            g[0] = side * off
            order = 0
    return how, side, order


@inlined
def earliest(functions, tables, settings, state, ws, row, count, h, t, scratch):
    """Of the times of the guards (-1: none) the first: (time, guard, ties).

    Of guards whose roots coincide to within their errors the one that comes first in order acts first, at the time of
    the root that is known best. What an event has caused comes before all that merely coincides with it.
    """
    times = scratch.times
    first = -1
    for j in range(count):
        if times[j] >= 0.0 and (first < 0 or times[j] < times[first]):
            first = j
    if first < 0:
        return -1.0, -1, 0
    if times[first] == 0.0:
        for j in range(count):
            if times[j] == 0.0 and is_thrown(tables, state, j):
                return 0.0, j, 0
    found, ties, te = first, 0, times[first]
    error, least = -1.0, math.inf
    for j in range(count):
        apart = times[j] - times[first]
        if j == first or times[j] < 0.0 or apart > near(settings, h):
            continue
        if error < 0.0:
            error = least = root_error(functions, tables, settings, state, ws, row + first, first, te, t, scratch)
        own = root_error(functions, tables, settings, state, ws, row + j, j, times[j], t, scratch)
        if apart == 0.0 or apart <= error + own:
            ties += 1
            found = min(found, j)
            if own < least:
                least = own
                te = times[j]
    return te, found, ties


@inlined
def _roots(functions, tables, settings, state, ws, row, j, h, t, scratch):
    """Roots of guard j for all guards of its surface that stand alike; returns where the step ends at the latest.

    The first is that of those which can be crossed from their side. Others come back there, and have the second.
    """
    n, mode = settings.order, state.run[0].mode
    count, i = tables.active[mode, 0], row + j
    order, surface = scratch.orders[j], tables.surfaces[mode, j]
    side = state.sides[tables.keys[mode, j]]
    passed = False
    for k in range(j, count):
        alike = tables.surfaces[mode, k] == surface and state.sides[tables.keys[mode, k]] == side
        if alike and scratch.orders[k] == order:
            passed |= not is_armed(side, tables.active[mode, 1 + k])
            scratch.orders[k] = FOUND
    room, stack, ends = scratch.polynomial, scratch.stack, scratch.ends
    if passed:
        first, second = recrossing(ws[i], order, n - order, h, side > 0, room, scratch.shifted, stack, ends)
    else:
        first, second = first_crossing(ws[i], order, n - order, h, side < 0, room, stack, ends), -1.0
    if order < 2 and tables.marks[mode, j] & at.AFFINE == 0:
        h = told_before(functions, tables, settings, state, j, first, order, side, h, t, scratch)
    first, clear, h = settled(functions, tables, settings, state, ws, i, j, first, side, h, t, scratch)
    if first >= 0.0 and second > 0.0:
        if clear >= 0.0 and not second > clear:
            h = min(h, clear)
            second = -1.0
        between = 0.5 * (first + second)
        second, _, h = settled(functions, tables, settings, state, ws, i, j, second, -side, h, t, scratch)
        if 0.0 <= second <= first:
            # one of third order with the first, which has no place of its own beside it
            h, second = min(h, between), -1.0
    for k in range(j, count):
        if scratch.orders[k] == FOUND:
            scratch.orders[k] = SEEN
            if is_armed(side, tables.active[mode, 1 + k]):
                scratch.times[k] = first
            elif first >= 0.0:
                scratch.backs[k], scratch.times[k] = first, second
                state.run[0].turning = 1
    return h


@inlined
def first_event(functions, tables, settings, state, ws, row, h, t, scratch):
    """First event of the step: (time in it or -1, -2 for a start that is refused; guard; ties; length of the step).

    ``ws[row + j]`` holds the polynomial of guard j. The step may end earlier, behind a guard that was only touched.
    Where a guard is no number, neither is the length.
    """
    run = state.run[0]
    n, mode, fresh = settings.order, run.mode, run.fresh
    count = tables.active[mode, 0]
    run.turning = 0
    for j in range(count):
        i = row + j
        key = tables.keys[mode, j]
        side = state.sides[key]
        order = 0
        how = at.ARMED
        scratch.times[j] = scratch.backs[j] = -1.0
        scratch.orders[j] = SEEN
        if rests(tables, state, j):
            continue
        if fresh != at.ONGOING or not is_on(side, ws[i, 0]):
            if ws[i, 0] != ws[i, 0]:
                return -1.0, -1, 0, math.nan
            degree = degree_of(settings, tables.marks[mode, j])
            if degree > 0:
                h = told_length(ws, i, degree, h)
            how, side, order = settle(functions, tables, settings, state, ws, i, j, n, h, t, scratch)
            if how == at.INVALID:
                return -2.0, j, 0, h
            state.sides[key] = side
        if how == at.FIRE:
            scratch.times[j] = 0.0
        elif how == at.NOWHERE or tables.marks[mode, j] & at.STILL:
            continue
        elif not (order == 0 and keeps_side(ws, uint64(i), h, -float(side))):
            scratch.orders[j] = order
    for j in range(count):
        if scratch.orders[j] >= 0:
            h = _roots(functions, tables, settings, state, ws, row, j, h, t, scratch)
    te, found, ties = earliest(functions, tables, settings, state, ws, row, count, h, t, scratch)
    if te > h:
        te = -1.0
    return te, found, ties, h


@inlined
def coincides(functions, tables, settings, state, ws, row, j, te, instant, h, t, scratch):
    """Whether an instant behind the root of guard j at te, such as a strobe, is no later than the root may be."""
    apart = instant - te
    return apart <= near(settings, h) and (
        apart <= root_error(functions, tables, settings, state, ws, row + j, j, te, t, scratch)
    )


@inlined
def pass_sides(functions, tables, state, backs, s, t, gradient):
    """Note the guards that were passed and are back on their near sides by the end of the step at s and time t.

    A root at the very end is left to the next step if the state has not got there: a reset that leaves the guard alone
    would seem to throw it across.
    """
    if state.run[0].turning == 0:
        return
    mode = state.run[0].mode
    for j in range(tables.active[mode, 0]):
        if 0.0 <= backs[j] <= s:
            direction = tables.active[mode, 1 + j]
            at_end = s - backs[j] <= GUARDS.near * s
            if not at_end or functions.guard(mode, j, t, state.c, state.x, gradient) * direction <= 0.0:
                state.sides[tables.keys[mode, j]] = -direction


@inlined
def is_thrown(tables, state, j):
    """Whether the event of guard j happens because the last event's reset threw the state across it."""
    return abs(state.sides[tables.keys[state.run[0].mode, j]]) == JUMPED


@inlined
def cross(tables, state, j):
    """Let guard j be on the side to which its event leads; whether the state was on it, and not beyond it already.

    Then its surface is crossed, and the state is on the far side of all guards that are zero there.
    """
    run = state.run[0]
    key = tables.keys[run.mode, j]
    direction = tables.active[run.mode, 1 + j]
    before = state.sides[key]
    met = abs(before) != JUMPED and abs(before) != PUT_ACROSS
    state.sides[key] = direction if direction != 0 else -1 if before > 0 else 1
    run.fresh = at.AFTER
    run.fired = key
    run.held = 1 if abs(before) == HELD else 0
    run.surface = tables.surfaces[run.mode, j] if met else -1
    run.way = state.sides[key] if met else 0
    run.moved_by = -1
    return met


@inlined
def enter(tables, state, target):
    """Change the mode; guards that it does not watch have no side."""
    for key in range(state.sides.size):
        if tables.watched[target, key] == 0:
            state.sides[key] = 0
    state.run[0].mode = target
