"""What an event is: the side of a guard, how it changes, and which guard fires first in a step.

The side of a guard is a fact that a run carries. It is read off the guard's value where nothing is known of it: at the
start of a run, in a mode that has just begun to watch the guard, and after a reset that moved it. From then on only a
located root changes it, once, whatever sign round-off gives to a value near zero. So no event is lost or seen twice
where a step, a strobe or a call ends on a root ("discontinuity sticking", Park and Barton 1996,
doi:10.1145/232807.232809). A value counts as zero within a bound of its own rounding error.
"""

import math

from numba import uint64

from chaosdrill.engine.jit import inlined, inner, series
from chaosdrill.engine.layout import (
    AFFINE,
    AFTER,
    ARMED,
    BEGIN,
    FIRE,
    INVALID,
    MARKS,
    NOWHERE,
    ONGOING,
    OPEN,
    PASSED,
    PASSES,
    PUT,
    TAYLOR,
    TIMED,
    UNSURE,
)
from chaosdrill.engine.polynomial import keeps_side, size, value
from chaosdrill.engine.roots import first_crossing, recrossing

ROUNDING = 4 * 2.220446049250313e-16
"""Rounding unit of the bounds of guards: twice that of doubles for the state itself, twice that for fused operations
that the bounds know nothing of."""

VANISHING = 1e-13
"""Part of a guard's variation over a step below which its second and later derivatives count as zero."""

EPSILON = 2.220446049250313e-16

INTERPOLATED = 1e-10
"""What the polynomial of a curved guard may leave out at least, beside its rounding error, where it is interpolated."""

JUMPED, HELD = 2, 3
"""A side times this says that the guard is about to fire: a reset threw the state across it, or the motion would not
leave it any more."""

NEAR = 1e-6
"""Part of the step within which two roots, or a root and a strobe, are looked at for whether they coincide."""


@inlined
def stand(zero, side, order, old, direction, fresh, fired, crossed, marks):
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
        Its side before, 0 if nothing is known.
    direction : int
        That of its events, 0 for either.
    fresh : int
        What came before the step.
    fired : bool
        Whether its own event is what came before, and has left it at zero.
    crossed : bool
        Whether an event on its surface is what came before, and has not moved it.
    marks : int
        What it is.
    """
    ahead = side == direction
    if fired:
        # a motion that does not leave a wall again with any speed is held by it
        if ahead and order > 1 and marks & (MARKS | PASSES) == 0:
            return FIRE, -HELD * side
    elif old == 0:
        # a root of even order is no crossing; but a wall that is stood upon is met
        crosses = order % 2 == 1 or marks & (MARKS | PASSES) == 0
        if zero and not crossed and ((ahead and crosses) or (direction == 0 and fresh == BEGIN and order % 2 == 1)):
            return FIRE, -side
        if not zero and ahead and marks & OPEN == 0:
            return (INVALID, side) if fresh == BEGIN else (FIRE, -JUMPED * side)
    else:
        before = 1 if old > 0 else -1
        if side != before and (ahead or direction == 0):
            return FIRE, before if zero else JUMPED * before
    return PASSED if ahead and direction != 0 else ARMED, side


@inlined
def is_moved(key, tables, state):
    """Whether the event that came before the step may have changed the guard by its reset."""
    run = state.run[0]
    return run.fresh == PUT or (run.fresh == AFTER and run.moved_by >= 0 and tables.moves[run.moved_by, key] == 1)


@inner
def _height(functions, state, j, t, gradient):
    """By how much a guard differs between places as far apart as the largest state is large."""
    functions.guard(state.run[0].mode, j, t, state.c, state.x, gradient)
    steep = 0.0
    largest = 0.0
    for i in range(state.x.size):
        steep = max(steep, abs(gradient[i]))
        largest = max(largest, abs(state.x[i]))
    return steep * largest


@inlined
def look(functions, tables, state, j, here, slope, t, scratch):
    """How guard j stands by its value and slope: (how, side, vanishing order); UNSURE where both vanish."""
    run = state.run[0]
    key = tables.keys[run.mode, j]
    direction = tables.watch[run.mode, 1 + j]
    old = state.sides[key]
    moved = is_moved(key, tables, state)
    on_surface = run.fresh == AFTER and tables.surfaces[run.mode, j] == run.surface
    crossed = on_surface and not moved
    if not moved and not crossed and abs(old) > 1:
        return FIRE, old, 0
    if here != here:
        return NOWHERE, 0, 0
    read = moved or old == 0
    zero = crossed or here * old <= 0.0
    if read or zero:
        functions.guard_error(run.mode, j, t, state.c, state.x, scratch.errors)
    if read and not crossed:
        bound = ROUNDING * scratch.errors[0] + (2.0 * run.residual if on_surface else 0.0)
        if run.slack > 0.0:
            bound += run.slack * _height(functions, state, j, t, scratch.gradient)
        zero = abs(here) <= (bound if math.isfinite(bound) else 0.0)
    order = 0
    side = 1 if here > 0.0 else -1
    if zero:
        bound = ROUNDING * scratch.errors[1]
        if not abs(slope) > (bound if math.isfinite(bound) else 0.0):
            return UNSURE, old, 0
        order = 1
        side = 1 if slope > 0.0 else -1
    fired = zero and run.fresh == AFTER and run.fired == key
    how, side = stand(zero, side, order, old, direction, run.fresh, fired, crossed, tables.marks[run.mode, j])
    return how, side, order


@inlined
def stand_at_rest(tables, state, j, order, side):
    """How guard j stands, (how, side), where its value and slope vanish and a later derivative leads to a side."""
    run = state.run[0]
    key = tables.keys[run.mode, j]
    after = run.fresh == AFTER
    crossed = after and tables.surfaces[run.mode, j] == run.surface and not is_moved(key, tables, state)
    return stand(
        True,
        side,
        order,
        state.sides[key],
        tables.watch[run.mode, 1 + j],
        run.fresh,
        after and run.fired == key,
        crossed,
        tables.marks[run.mode, j],
    )


@inlined
def settle(functions, tables, state, ws, i, j, n, h, t, scratch):
    """As ``look`` for guard j whose polynomial is row i, by the first derivative that does not vanish."""
    how, side, order = look(functions, tables, state, j, ws[i, 0], ws[i, 1], t, scratch)
    returns = how == FIRE and order == 1 and ws[i, 1] * ws[i, 2] < 0.0
    if returns and 0.25 * ws[i, 1] * ws[i, 1] <= ROUNDING * scratch.errors[0] * abs(ws[i, 2]):
        # beyond zero it comes back before it is clear of its error
        how, side = stand_at_rest(tables, state, j, 2, 1 if ws[i, 2] > 0.0 else -1)
        return how, side, 2
    if how == UNSURE:
        limit = VANISHING * size(ws, uint64(i), h, 0)
        order = 2
        power = h * h
        while order <= n and not abs(ws[i, order]) * power > limit:
            order += 1
            power *= h
        if order > n:
            return NOWHERE, side, 0
        how, side = stand_at_rest(tables, state, j, order, 1 if ws[i, order] > 0.0 else -1)
    return how, side, order


@series
def _slope_and_bend(g, n, s):
    """First and second derivative of a polynomial at s."""
    f = 0.0
    d = 0.0
    b = 0.0
    for m in range(n + 1):
        b = b * s + d
        d = d * s + f
        f = f * s + g[uint64(n - m)]
    return d, 2.0 * b


@inner
def _state_at(ws, n, s, place):
    for i in range(n):
        place[i] = value(ws, uint64(i), s)


@inner
def root_error(functions, tables, settings, state, ws, i, j, s, t, scratch):
    """How far a root at s may be from the exact one: by the guard's rounding, and by the tolerance of the states."""
    run = state.run[0]
    n = state.x.size
    place = scratch.before[:n]
    _state_at(ws, n, s, place)
    functions.guard_error(run.mode, j, t + s, state.c, place, scratch.errors)
    off = ROUNDING * scratch.errors[0]
    if tables.marks[run.mode, j] & TIMED == 0:
        functions.guard(run.mode, j, t + s, state.c, place, scratch.gradient)
        for a in range(n):
            off += settings.tolerance * abs(scratch.gradient[a]) * state.scale[a]
    slope, _ = _slope_and_bend(ws[i], settings.order, s)
    # a time is rounded, too
    return off / abs(slope) + 2.0 * EPSILON * abs(t + s) if slope != 0.0 else math.inf


@inner
def on_the_clock(functions, run, c, j, s, h, place, gradient, errors):
    """A root near s of a guard of time alone, by Newton steps on the guard itself, as exact as time is known."""
    found = s
    # a root of third order is approached by a third of the way at a time
    for _ in range(100):
        t = (run.origin + run.whole) + (run.rest + run.time + found)
        # what the sum has lost
        late = ((run.origin + run.whole) - t) + (run.rest + run.time + found)
        off = functions.guard(run.mode, j, t, c, place, gradient)
        slope = gradient[place.size]
        off += slope * late
        functions.guard_error(run.mode, j, t, c, place, errors)
        if slope == 0.0:
            break
        step = off / slope
        if abs(off) <= ROUNDING * errors[0] and abs(step) > 1e-12 * h:
            # at a multiple root its error says no more
            break
        if not abs(found - step - s) <= 1e-3 * h:
            return s
        found -= step
        if abs(step) <= 4.0 * EPSILON * max(abs(t), h):
            break
    return min(max(found, 0.0), h)


@inner
def _touches(functions, tables, settings, state, ws, i, j, n, s, side, h, t, scratch):
    """Time when a guard is clearly back on its side, if beyond a root at s it gets no farther than its error; or -1.

    The error is that of its value, and that of the polynomial, whose terms are rounded where the step begins.
    """
    slope, bend = _slope_and_bend(ws[i], n, s)
    # a root found at the summit itself, or just behind it, has no slope that leads across
    if bend == 0.0 or (slope * bend >= 0.0 and slope * side < 0.0):
        return -1.0
    summit = -slope / bend
    height = 0.5 * abs(slope * summit)
    mode = state.run[0].mode
    left_out = 2.0 * max(settings.tolerance, INTERPOLATED)
    if settings.method == TAYLOR or tables.marks[mode, j] & AFFINE:
        left_out = 0.0
    if not height <= max(1e-9, left_out) * size(ws, uint64(i), h, 0):
        return -1.0
    place = scratch.before[: state.x.size]
    functions.guard_error(mode, j, t, state.c, state.x, scratch.errors)
    off = scratch.errors[0] + s * scratch.errors[1]
    _state_at(ws, place.size, s, place)
    functions.guard_error(mode, j, t + s, state.c, place, scratch.errors)
    off = ROUNDING * max(off, scratch.errors[0]) + 2.0 * EPSILON * size(ws, uint64(i), s, 0)
    if tables.marks[mode, j] & TIMED:
        # what the series or the interpolation leaves out is seen in the guard itself
        height = -side * functions.guard(mode, j, t + s + summit, state.c, place, scratch.gradient)
    else:
        off += left_out * size(ws, uint64(i), h, 0)
    if not height <= off:
        return -1.0
    back = s + max(abs(summit) + 2.0 * math.sqrt(summit * summit + 2.0 * off / abs(bend)), 10.0 * NEAR * h)
    # a root of higher order is across there
    across = value(ws, uint64(i), min(back, h))
    if tables.marks[mode, j] & TIMED:
        across = functions.guard(mode, j, t + min(back, h), state.c, place, scratch.gradient)
    return back if -side * across <= off else -1.0


@inlined
def earliest(functions, tables, settings, state, ws, row, count, h, t, scratch):
    """Of the times of the guards (-1: none) the first: (time, guard, ties).

    Of guards whose roots coincide to within their errors the one that comes first in order acts first, at the time of
    the root that is known best.
    """
    times = scratch.times
    first = -1
    for j in range(count):
        if times[j] >= 0.0 and (first < 0 or times[j] < times[first]):
            first = j
    if first < 0:
        return -1.0, -1, 0
    found = first
    ties = 0
    te = times[first]
    error = -1.0
    least = math.inf
    for j in range(count):
        apart = times[j] - times[first]
        if j == first or times[j] < 0.0 or apart > NEAR * h:
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
def first_event(functions, tables, settings, state, ws, row, h, t, scratch):
    """First event of the step: (time in it or -1, -2 for a start that is refused; guard; ties; length of the step).

    ``ws[row + j]`` holds the polynomial of guard j. The step may end earlier, behind a guard that was only touched.
    """
    run = state.run[0]
    n, mode, fresh = settings.order, run.mode, run.fresh
    count = tables.watch[mode, 0]
    run.turning = 0
    for j in range(count):
        i = row + j
        g = ws[i]
        direction = tables.watch[mode, 1 + j]
        key = tables.keys[mode, j]
        side = state.sides[key]
        order = 0
        how = PASSED if direction != 0 and side == direction else ARMED
        scratch.backs[j] = -1.0
        if fresh != ONGOING or not g[0] * side > 0.0 or abs(side) > 1:
            how, side, order = settle(functions, tables, state, ws, i, j, n, h, t, scratch)
            if how == INVALID:
                return -2.0, j, 0, h
            state.sides[key] = side
        if how == NOWHERE:
            scratch.times[j] = -1.0
            continue
        if how == FIRE:
            scratch.times[j] = 0.0
            continue
        if how == ARMED:
            if order == 0 and keeps_side(ws, uint64(i), h, -float(side)):
                scratch.times[j] = -1.0
                continue
            root = first_crossing(g, order, n - order, h, side < 0, scratch.polynomial, scratch.stack, scratch.ends)
            turn = root
        else:
            turn, root = recrossing(
                g,
                order,
                n - order,
                h,
                direction > 0,
                scratch.polynomial,
                scratch.shifted,
                scratch.stack,
                scratch.ends,
            )
        if turn > 0.0:
            back = _touches(functions, tables, settings, state, ws, i, j, n, turn, side, h, t, scratch)
            if back >= 0.0:
                h = min(h, back)
                root = turn = -1.0
        if root > 0.0 and tables.marks[mode, j] & TIMED:
            root = on_the_clock(functions, run, state.c, j, root, h, state.x, scratch.gradient, scratch.errors)
        if how == PASSED and turn >= 0.0:
            scratch.backs[j] = turn
            run.turning = 1
        scratch.times[j] = root
    te, found, ties = earliest(functions, tables, settings, state, ws, row, count, h, t, scratch)
    if te > h:
        te = -1.0
    return te, found, ties, h


@inlined
def coincides(functions, tables, settings, state, ws, row, j, te, instant, h, t, scratch):
    """Whether an instant behind the root of guard j at te, such as a strobe, is no later than the root may be."""
    apart = instant - te
    return apart <= NEAR * h and (
        apart <= root_error(functions, tables, settings, state, ws, row + j, j, te, t, scratch)
    )


@inlined
def pass_sides(tables, state, backs, s):
    """Note the guards that were passed and are back on their near sides by the end of the step at s."""
    if state.run[0].turning == 0:
        return
    mode = state.run[0].mode
    for j in range(tables.watch[mode, 0]):
        if 0.0 <= backs[j] <= s:
            state.sides[tables.keys[mode, j]] = -tables.watch[mode, 1 + j]


@inlined
def cross(tables, state, j):
    """Let guard j be on the side to which its event leads; whether a reset threw the state across it."""
    mode = state.run[0].mode
    key = tables.keys[mode, j]
    direction = tables.watch[mode, 1 + j]
    before = state.sides[key]
    if direction != 0:
        state.sides[key] = direction
    else:
        state.sides[key] = -1 if before > 0 else 1
    return abs(before) == JUMPED


@inlined
def enter(tables, state, target):
    """Change the mode; guards that it does not watch have no side."""
    for key in range(state.sides.size):
        if tables.watched[target, key] == 0:
            state.sides[key] = 0
    state.run[0].mode = target
