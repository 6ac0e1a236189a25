"""An event is taken: the reset of its outcome, and the saltation of the tangents."""

import math

from chaosdrill.codegen.kinds import Tuple, float64, int64
from chaosdrill.codegen.signatures import event_places
from chaosdrill.engine import guards
from chaosdrill.engine import layout as at
from chaosdrill.engine.chatter import interpolated, may_be_over, time_left
from chaosdrill.engine.jit import inlined, inner, rare
from chaosdrill.engine.passages import normal_speed
from chaosdrill.engine.records import unit
from chaosdrill.engine.tuning import GUARDS


@inlined
def saltation_jump(event, out):
    """F+ - DR F- - dR/dt, the part of the saltation that goes with the tangent's speed across the guard."""
    n = out.size
    place = event_places(n)
    for i in range(n):
        row = place.jacobian + i * (n + 1)
        out[i] = event[place.after + i] - event[row + n]
        for j in range(n):
            out[i] -= event[row + j] * event[place.before + j]


@inlined
def saltate(vectors, live, event, speed, caused, sooner, jump, image):
    """Map live tangents across an event, S d = DR d + jump (n.d) / (n.F- + dh/dt); returns their largest entry.

    That is infinity where one is no number. A tangent along the guard is mapped by the reset alone, without round-off
    from a large jump; so is every tangent where the flow does not jump, however slowly it comes. ``sooner`` gets by how
    much the event comes sooner along each tangent, or says so, of an event that the last one has caused.
    """
    n = vectors.shape[1]
    place = event_places(n)
    largest = 0.0
    for v in range(live):
        across = sooner[v]
        if not caused:
            across = 0.0
            for j in range(n):
                across += event[place.gradient + j] * vectors[v, j]
            across = across / speed if across != 0.0 else 0.0
            sooner[v] = across
        for i in range(n):
            row = place.jacobian + i * (n + 1)
            s = 0.0
            for j in range(n):
                s += event[row + j] * vectors[v, j]
            image[i] = s + jump[i] * across if jump[i] != 0.0 else s
        for i in range(n):
            vectors[v, i] = image[i]
            size = abs(image[i])
            largest = max(largest, size if size < math.inf else math.inf)
    return largest


@inlined
def _mapped(functions, settings, mode, j, t, state, with_tangents, scale, event):
    """The transition of an event, which is written into ``event`` with the errors of the states before and after it.

    They are in units of ``guards.ROUNDING``: before the event the states are as exact as the step and the surface onto
    which they were put allow, in their sizes, unless they stood still.
    """
    place = event_places(state.x.size)
    part = 1.0 + settings.tolerance / guards.ROUNDING
    event[place.part] = part
    # the size that a method begins with may be far too large
    event[place.reach] = part * state.run[0].longest
    for i in range(state.x.size):
        event[place.known + i] = part * state.scale[i]
        event[place.doubt + i] = state.doubt[i]
    return functions.event_map(mode, j, t, state.c, state.x, with_tangents, scale, settings.tolerance, event)


@unit(Tuple((int64, float64, float64, float64)))
def _completed(functions, tables, settings, j, transition, with_tangents, t, state, scale, scratch):
    """What becomes of an event that another one may replace, which completes its rebounds; few systems have any.

    Returns the transition that is taken, which stands in ``scratch.event``; time to the last of the rebounds that it
    replaces, or -1, and the error of that; and how long the rebound lasts that is not completed.
    """
    event, n = scratch.event, state.x.size
    place = event_places(n)
    mode = state.run[0].mode
    flight = 2.0 * abs(event[place.speed] / event[place.pull])
    hardest = max(state.hardest[tables.keys[mode, j]], abs(normal_speed(event, n)))
    if not may_be_over(functions, tables, settings, j, hardest, t, state, scratch):
        return transition, -1.0, 0.0, flight
    rest, unsure = time_left(functions, tables, settings, j, transition, hardest, t, state, scratch)
    event[place.complete] = 1.0 if rest >= 0.0 else 0.0
    transition = _mapped(functions, settings, mode, j, t, state, with_tangents, scale, event)
    if tables.transitions[transition, at.COMPLETES] == 0:
        rest = -1.0
    return transition, rest, unsure, flight


@rare
def _leads_back(functions, state, target, t, scratch):
    """Whether a mode leads back over the surface that has just been crossed, from the state before the reset."""
    n = state.x.size
    functions.field(target, t, state.c, state.x, scratch.doubt)
    ahead = state.normal[n]
    for i in range(n):
        ahead += state.normal[i] * scratch.doubt[i]
    return ahead * state.run[0].way < 0.0


@inner
def _begin_row(row, transition, rate, error, state):
    """Record an event before its reset."""
    run, x = state.run[0], state.x
    row[at.EVENT_STROBES] = run.strobes
    row[at.EVENT_TIME] = run.time
    row[at.EVENT_KIND] = transition
    row[at.EVENT_MODE] = run.mode
    row[at.EVENT_SPEED] = run.speed
    row[at.EVENT_RATE] = rate
    row[at.EVENT_ERROR] = error
    for i in range(x.size):
        row[at.EVENT_COLUMNS + i] = x[i]


@inner
def _end_row(row, rest, state, event):
    """Record an event after its reset, at the end of the rebounds that it replaces."""
    n = state.x.size
    after = event_places(n).after
    for i in range(n):
        row[at.EVENT_COLUMNS + n + i] = state.x[i]
    if rest > 0.0:
        row[at.EVENT_TIME] += rest
        for i in range(n):
            row[at.EVENT_COLUMNS + n + i] += rest * event[after + i]


@inner
def _move_to_image(state, event):
    """Put the state where the reset puts it; returns whether that is away from the surface of the guard."""
    x, normal, place = state.x, state.normal, event_places(state.x.size)
    away = error = 0.0
    for i in range(x.size):
        image = event[place.image + i]
        state.doubt[i] = event[place.doubt + i]
        away += normal[i] * (image - x[i])
        error += abs(normal[i]) * (state.doubt[i] + abs(x[i]))
        x[i] = image
    return abs(away) > guards.ROUNDING * error


@unit(float64)
def take(functions, tables, settings, j, t, state, buffer, scratch):
    """Take the event of guard j at the present state; returns the largest entry of the tangents after it.

    An event across whose guard a reset has thrown the state comes with that reset: the state is not put onto the guard,
    and along a tangent it comes as much sooner as the event of that reset.

    If no outcome's condition holds, nothing happens but that the guard has been passed. Of an event that replaces
    rebounds the limit time and state are recorded; the run goes on from here, on the same path within the tolerance.
    """
    run, x = state.run[0], state.x
    n = x.size
    place = event_places(n)
    mode = run.mode
    event = scratch.event
    recorded = buffer.shape[0] > 0
    caused = guards.is_thrown(tables, state, j)
    met = guards.cross(tables, state, j)
    scale = state.scale
    if not met:
        scale = scratch.none
    elif settings.stepping == at.FIXED:
        scale = scratch.image
        scale[:] = GUARDS.far
    key = tables.keys[mode, j]
    with_tangents = run.live + recorded
    event[place.complete] = 0.0
    transition = _mapped(functions, settings, mode, j, t, state, with_tangents, scale, event)
    rest = -1.0
    unsure = flight = 0.0
    if transition >= 0 and tables.transitions[transition, at.COMPLETED] == 1:
        transition, rest, unsure, flight = _completed(
            functions, tables, settings, j, transition, with_tangents, t, state, scale, scratch
        )
    run.residual = run.pull = 0.0
    for i in range(n + 1):
        state.normal[i] = event[place.gradient + i]
    run.speed = speed = normal_speed(event, n)
    if transition < 0:
        return 0.0
    if recorded:
        _begin_row(buffer[run.event_rows], transition, event[place.rate], unsure if rest > 0.0 else 0.0, state)
    largest = 0.0
    if tables.transitions[transition, at.MARKS_ONLY] == 0:
        target = tables.transitions[transition, at.TO_MODE]
        run.moved_by = transition
        if target != mode and tables.active[mode, 1 + j] == 0 and _leads_back(functions, state, target, t, scratch):
            # it is not the reset that turns the motion: the guard is met anew
            run.fired = -1
        if tables.moves[transition, key] == 1:
            run.residual = abs(functions.guard(mode, j, t, state.c, x, scratch.gradient))
        if _move_to_image(state, event):
            # what is zero where the reset leads to is another surface
            run.way = 0
        if run.live > 0:
            if not met or (rest >= 0.0 and speed == 0.0):
                # the time of such an event does not depend on the state, if it has no cause
                speed = math.inf
            saltation_jump(event, scratch.jump)
            largest = saltate(state.vectors, run.live, event, speed, caused, state.sooner, scratch.jump, scratch.image)
            if not met or tables.transitions[transition, at.RANK_DEFICIENT] == 1:
                run.rank_check = at.AT_EVENT
        if target != mode:
            guards.enter(tables, state, target)
            run.next_step = 0.0
        if flight > 0.0 and rest < 0.0 and interpolated(tables, settings, mode, j):
            run.pull, run.jerk = event[place.pull], event[place.jerk]
            # of a longer step the polynomial leaves out what is not small beside the flight
            longest = 0.1 * flight / math.sqrt(max(settings.tolerance, GUARDS.interpolated))
            if longest < run.tried:
                run.next_step = min(run.next_step, longest) if run.next_step > 0.0 else longest
    if recorded:
        _end_row(buffer[run.event_rows], rest, state, event)
        run.event_rows += 1
    state.counts[transition] += 1
    if rest >= 0.0:
        state.hardest[key] = 0.0
    elif met:
        state.grazing[transition] = min(state.grazing[transition], abs(event[place.rate]))
        state.hardest[key] = max(state.hardest[key], abs(speed))
    run.events_in_period += 1
    return largest
