"""Shooting residual of a candidate periodic orbit, and its derivatives by all that is unknown.

The unknowns are the start of every segment, the phase at which the first begins, the durations of all, and the free
parameters. The equations: every segment ends on its guard, begins where the reset of the last led, and the whole takes
a number of periods. Nothing in them is singular where a guard is met tangentially: the speed at an event passes through
zero like any other number (multi-segment boundary value problem: Dankowicz and Schilder 2013,
doi:10.1137/1.9781611972573). The starts of all segments but the first are eliminated by forward substitution, so that
the linear system is small however many states a segment has. Where they grow much along the flow and less from event to
event, as those of walkers do, what they say would be lost in round-off: there the duration of a segment is eliminated
as well, by the equation of the event at its end. Solutions and null vectors are the same.

Columns of reduced unknowns: d states of the first start, its phase, N durations, q parameters; then the constant.
"""

import math

from chaosdrill.codegen.kinds import Tuple, float64, int64
from chaosdrill.codegen.signatures import event_places, matrix, vector
from chaosdrill.engine.events import FAR, normal_speed, saltation_jump
from chaosdrill.engine.jit import compiled
from chaosdrill.engine.layout import COMPLETES, DONE, FAILED, Method
from chaosdrill.engine.records import integer_matrix, integers, machine_at, state_of
from chaosdrill.engine.segment import begin, follow
from chaosdrill.engine.tangents import normals_of

cube = float64[:, :, ::1]

# what is fixed of an orbit: numbers of states and free parameters, periods that it takes, the mode that tells the
# period, -1 where it is constant, and whether there is a period at all
STATES, FREE, PERIODS, CLOCK, FORCED = range(5)

STEEP, GROWN = 1e-2, 1e3
"""Speed of an event, in parts of the variation of its guard over the sizes of the states in one period, and growth of
the unknowns, in the same sizes, from which on a duration is eliminated."""

# what ends a segment that no event ends: a share of the period has passed, or the plane through a reference state is
# met
SHARE, PLANE = -1, -2

# columns of what is known of the segments: mode, guard or one of the above, the outcome of the event
SEGMENT_MODE, SEGMENT_END, SEGMENT_OUTCOME = range(3)

# what shooting found beside the equations: the guard that a segment crosses before its end, the outcome of its event
CROSSED, CAME = range(2)

ROOM = Tuple((matrix, matrix, matrix, matrix, vector))
"""scratch"""

FOUND = Tuple((matrix, cube, matrix, cube, vector, integer_matrix, vector))
"""equations, sensitivity of the starts, monodromy matrix and its factors, speeds at the events, crossings and outcomes,
times of crossings since the start of the segment"""

SIGNATURE = Tuple((int64, float64))(
    *(int64, int64, integers, vector, integer_matrix, matrix, matrix, float64, vector, int64, FOUND, ROOM)
)


@compiled(SIGNATURE)
def shooting_residual(place, resting, sizes, extent, segments, plane, starts, phase, durations, watched, found, room):
    """Follow all segments; returns (DONE or the outcome that ended a segment, residual).

    Parameters
    ----------
    place, resting
        Addresses of the `chaosdrill.engine.layout.Machine`, and of one that watches no guard.
    sizes, segments
        See the names above; ``segments`` has shape (N, 3).
    extent : ndarray, shape (d,)
        What distances between states are relative to at least, above zero; else it is the state where a segment ends.
    plane : ndarray, shape (2, d)
        State and normal of the plane on which an orbit without events and without a period begins.
    starts : ndarray, shape (N, d + q)
        States at the starts of the segments; the parameters behind them.
    phase : float
        Time at which the first segment begins.
    durations : ndarray, shape (N,)
    watched : int
        Whether to look for other guards on the way.
    found : tuple of ndarray
        Filled: equations (N + d + 1 + .., columns + 1), sensitivities (N, d + q, columns), monodromy (d + q, d + q),
        its factors (N, d + q, d + q), one a segment, speeds (N,), positive in the guard's direction, crossings and
        outcomes (N, 2), times of crossings (N,).

    The residual is the largest violation of an equation: distances relative to ``extent``, time to the period.
    """
    machine = machine_at(place)
    functions, settings, tables, scratch = machine.functions, machine.settings[0], machine.tables, machine.scratch
    asleep = machine_at(resting).tables
    method = Method(machine.stepper, machine.search, place, resting, 0)
    equations, sensitivity, monodromy, factors, speeds, seen, met = found
    moved, stretch, product, step, clock_row = room
    state = state_of(machine.states, 0)
    run, x, vectors, c = state.run[0], state.x, state.vectors, state.c
    count, n = starts.shape
    d, q = sizes[STATES], sizes[FREE]
    columns = d + 1 + count + q
    event, jump, gradient = scratch.event, scratch.jump, scratch.gradient
    before, after = scratch.before, scratch.after
    place = event_places(n)
    period = run.period
    slope = stretch[n]
    slope[:] = 0.0
    if sizes[CLOCK] >= 0:
        functions.field(sizes[CLOCK], 0.0, c, starts[0], before)
        period = before[0]
        for j in range(q):
            slope[j] = before[1 + j]
        run.period = period
    equations[:, :] = 0.0
    sensitivity[0, :, :] = 0.0
    clock_row[:] = 0.0
    clock_row[d] = 1.0
    for r in range(d):
        sensitivity[0, r, r] = 1.0
    for j in range(q):
        sensitivity[0, d + j, d + 1 + count + j] = 1.0
    t = phase
    surfaces = 0
    if tables.held[segments[0, SEGMENT_MODE]] > 0:
        scratch.metric[:] = 1.0
        for r in range(n):
            x[r] = starts[0, r]
        surfaces = normals_of(functions, tables, segments[0, SEGMENT_MODE], t, state, d, scratch)
    normals = scratch.normals
    for r in range(n):
        for v in range(n):
            monodromy[r, v] = 1.0 if r == v else 0.0
            if r < d and v < d:
                for j in range(surfaces):
                    monodromy[r, v] -= normals[j, r] * normals[j, v]
    residual = 0.0
    total = 0.0
    events = 0
    for i in range(count):
        mode, end = segments[i, SEGMENT_MODE], segments[i, SEGMENT_END]
        for r in range(n):
            x[r] = starts[i, r]
            for v in range(n):
                vectors[v, r] = 1.0 if r == v else 0.0
        functions.field(mode, t, c, x, before)
        for r in range(n):
            # the derivative of the end by the time of the start is F+ - Phi F-
            stretch[r, 0] = before[r]
        last = i - 1 if i > 0 else count - 1
        ended, taken = segments[last, SEGMENT_END], segments[last, SEGMENT_OUTCOME]
        begin(tables, state, mode, n, segments[last, SEGMENT_MODE], ended, taken)
        outcome, crossed, when = follow(
            functions, method, settings, tables, asleep, t, durations[i], end, watched == 1, state, scratch
        )
        if outcome != DONE:
            return outcome, math.inf
        seen[i, CROSSED] = crossed
        met[i] = when
        seen[i, CAME] = segments[i, SEGMENT_OUTCOME]
        te = t + durations[i]
        total += durations[i]
        functions.field(mode, te, c, x, after)
        for r in range(n):
            late = after[r]
            for v in range(n):
                late -= vectors[v, r] * stretch[v, 0]
            for u in range(columns + 1):
                value = late * clock_row[u]
                for v in range(n):
                    value += vectors[v, r] * sensitivity[i, v, u]
                moved[r, u] = value
            moved[r, d + 1 + i] += after[r]
        clock_row[d + 1 + i] += 1.0
        following = starts[i + 1] if i + 1 < count else starts[0]
        if end >= 0:
            events += 1
            value = functions.guard(mode, end, te, c, x, gradient)
            steep = 0.0
            for r in range(d):
                steep = max(steep, abs(gradient[r]) * max(extent[r], abs(x[r])))
            steep = steep if steep > 0.0 else abs(gradient[n]) * period
            for u in range(columns + 1):
                sum_ = gradient[n] * clock_row[u]
                for r in range(n):
                    sum_ += gradient[r] * moved[r, u]
                equations[i, u] = sum_
            equations[i, columns] += value
            residual = max(residual, abs(value) / steep)
            for r in range(n):
                step[0, r] = x[r]
            # a guess may end far from its guard
            scratch.image[:] = FAR
            # how many rebounds come before a rest is not asked again
            event[place.complete] = tables.transitions[segments[i, SEGMENT_OUTCOME], COMPLETES]
            came = functions.event_map(mode, end, te, c, x, 1, scratch.image, settings.tolerance, event)
            seen[i, CAME] = came
            if came < 0:
                return FAILED, math.inf
            speed = normal_speed(event, n)
            direction = tables.active[mode, 1 + end]
            speeds[i] = speed * direction if direction != 0 else abs(speed)
            saltation_jump(event, jump)
            for r in range(n):
                row = place.jacobian + r * (n + 1)
                for u in range(columns + 1):
                    value = event[row + n] * clock_row[u]
                    for v in range(n):
                        value += event[row + v] * moved[v, u]
                    step[1 + r, u] = value
                shift = event[place.image + r] - following[r]
                for v in range(n):
                    # the event was taken on the guard, not where the segment ended
                    shift += event[row + v] * (step[0, v] - x[v])
                step[1 + r, columns] += shift
                for v in range(n):
                    # columns of S Phi, S = DR + jump n/(n.F- + dh/dt)
                    across = 0.0
                    reset = 0.0
                    for k in range(n):
                        across += event[place.gradient + k] * vectors[v, k]
                        reset += event[row + k] * vectors[v, k]
                    stretch[r, v] = reset + (jump[r] * across / speed if jump[r] != 0.0 and across != 0.0 else 0.0)
                if r < d:
                    residual = max(residual, abs(shift) / max(extent[r], abs(x[r])))
            own = d + 1 + i
            pace = equations[i, own]
            if abs(pace) * period > STEEP * steep:
                kept, left = 0.0, 0.0
                for r in range(d):
                    for u in range(own):
                        part = (extent[u] if u < d else period) / extent[r]
                        kept = max(kept, part * abs(step[1 + r, u]))
                        left = max(left, part * abs(step[1 + r, u] - step[1 + r, own] * equations[i, u] / pace))
                if kept > GROWN and left < kept:
                    for u in range(columns + 1):
                        clock_row[u] -= equations[i, u] / pace
                    for r in range(n):
                        rate = step[1 + r, own]
                        for u in range(columns + 1):
                            step[1 + r, u] -= rate * equations[i, u] / pace
        else:
            speeds[i] = math.inf
            for r in range(n):
                for u in range(columns + 1):
                    step[1 + r, u] = moved[r, u]
                step[1 + r, columns] += x[r] - following[r]
                for v in range(n):
                    stretch[r, v] = vectors[v, r]
                if r < d:
                    residual = max(residual, abs(x[r] - following[r]) / max(extent[r], abs(x[r])))
            if end == SHARE:
                equations[i, d + 1 + i] = 1.0
                for j in range(q):
                    equations[i, d + 1 + count + j] = -slope[j]
                equations[i, columns] = durations[i] - period
                residual = max(residual, abs(durations[i] - period) / period)
            else:
                size = 0.0
                away = 0.0
                for r in range(d):
                    equations[i, r] = plane[1, r]
                    away += plane[1, r] * (starts[0, r] - plane[0, r])
                    size = max(size, abs(plane[1, r]) * max(extent[r], abs(x[r])))
                equations[i, columns] = away
                residual = max(residual, abs(away) / size)
        for r in range(n):
            for v in range(n):
                value = 0.0
                for k in range(n):
                    value += stretch[r, k] * monodromy[k, v]
                product[r, v] = value
                factors[i, r, v] = stretch[r, v]
        for r in range(n):
            for v in range(n):
                monodromy[r, v] = product[r, v]
        if i + 1 < count:
            for r in range(n):
                for u in range(columns + 1):
                    sensitivity[i + 1, r, u] = step[1 + r, u]
        else:
            for r in range(d):
                for u in range(columns + 1):
                    equations[count + r, u] = step[1 + r, u]
                equations[count + r, r] -= 1.0
            for r in range(d if events == 0 and q == 0 else 0):
                held = True
                for v in range(n):
                    held = held and monodromy[r, v] == (1.0 if r == v else 0.0)
                if held:
                    # it comes back whatever it is, as one that a mode leads along a function of time: it stays put
                    for u in range(columns):
                        equations[count + r, u] = 1.0 if u == r else 0.0
                    equations[count + r, columns] = 0.0
            for j in range(surfaces):
                # across a surface that its first mode holds it comes back whatever it is: it lies on the surface
                for u in range(columns + 1):
                    across = 0.0
                    for r in range(d):
                        across += normals[j, r] * equations[count + r, u]
                    here = 0.0
                    if u < d:
                        here = normals[j, u]
                    elif u == d:
                        here = normals[j, n]
                    elif u == columns:
                        here = normals[j, n + 1]
                    elif u > d + count:
                        here = normals[j, u - 1 - count]
                    for r in range(d):
                        equations[count + r, u] += normals[j, r] * (here - across)
                across = 0.0
                for r in range(d):
                    across = max(across, abs(normals[j, r]) * max(extent[r], abs(starts[0, r])))
                residual = max(residual, abs(normals[j, n + 1]) / across)
        t = te
        if sizes[FORCED] == 1:
            whole = math.floor(te / period)
            t = te - whole * period
            for j in range(q):
                clock_row[d + 1 + count + j] -= whole * slope[j]
    final = count + d
    if sizes[FORCED] == 1 and events > 0:
        for i in range(count):
            equations[final, d + 1 + i] = 1.0
        for j in range(q):
            equations[final, d + 1 + count + j] = -sizes[PERIODS] * slope[j]
        equations[final, columns] = total - sizes[PERIODS] * period
        residual = max(residual, abs(total - sizes[PERIODS] * period) / period)
    else:
        equations[final, d] = 1.0
    return DONE, residual
