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
from chaosdrill.codegen.layout import ROUNDING
from chaosdrill.codegen.signatures import cube, event_places, integer_matrix, integers, matrix, vector
from chaosdrill.engine.events import saltation_jump
from chaosdrill.engine.jit import compiled, inner
from chaosdrill.engine.layout import COMPLETES, DONE, FAILED, Method
from chaosdrill.engine.passages import normal_speed
from chaosdrill.engine.records import machine_at, state_of
from chaosdrill.engine.segment import begin, follow
from chaosdrill.engine.tangents import normals_of
from chaosdrill.engine.tuning import GUARDS, ORBITS

# rows of what an orbit begins on and ends at; after them the directions along which it need not close
START, NORMAL, DRIFT, GAP, LINES = range(5)

# what is fixed of an orbit: numbers of states and free parameters, periods that it takes, the mode that tells the
# period, -1 where it is constant, and whether there is a period at all
STATES, FREE, PERIODS, CLOCK, FORCED = range(5)

# what ends a segment that no event ends: a share of the period has passed, or the plane through a reference state is
# met
SHARE, PLANE = -1, -2

# columns of what is known of the segments: mode, guard or one of the above, the outcome of the event
SEGMENT_MODE, SEGMENT_END, SEGMENT_OUTCOME = range(3)

# what shooting found beside the equations: the guard that a segment crosses before its end, the outcome of its event
CROSSED, CAME = range(2)

ROOM = Tuple((matrix, matrix, matrix, matrix, vector))
"""scratch"""

FOUND = Tuple((matrix, cube, matrix, cube, vector, vector, integer_matrix, vector))
"""equations, sensitivity of the starts, monodromy matrix and its factors, speeds at the events, rates of the guards as
written, crossings and outcomes, times of crossings since the start of the segment"""

SIGNATURE = Tuple((int64, float64))(
    *(int64, int64, integers, vector, integer_matrix, matrix, matrix, float64, vector, int64, FOUND, ROOM)
)


@inner
def pivot(direction):
    """Index of the first entry of a direction that is not zero."""
    first = 0
    while direction[first] == 0.0:
        first += 1
    return first


@inner
def _columns(sizes, count):
    """Columns of the phase, of the first duration and of the first parameter; the last one is that of the constant."""
    phase = sizes[STATES]
    return phase, phase + 1, phase + 1 + count


@inner
def _forcing(functions, c, run, sizes, start, rates, slope):
    """The period at these parameters; ``slope`` becomes its derivatives by the free ones."""
    slope[:] = 0.0
    if sizes[CLOCK] >= 0:
        functions.field(sizes[CLOCK], 0.0, c, start, rates)
        run.period = rates[0]
        for j in range(sizes[FREE]):
            slope[j] = rates[1 + j]
    return run.period


@inner
def _begin_sums(sizes, count, surfaces, normals, first, clock_row, monodromy):
    """The first start and its time by the unknowns, and the projector onto the surfaces that the first mode holds."""
    d, n = sizes[STATES], monodromy.shape[0]
    phase, _, free = _columns(sizes, count)
    first[:, :] = 0.0
    clock_row[:] = 0.0
    clock_row[phase] = 1.0
    for r in range(d):
        first[r, r] = 1.0
    for j in range(sizes[FREE]):
        first[d + j, free + j] = 1.0
    for r in range(n):
        for v in range(n):
            monodromy[r, v] = 1.0 if r == v else 0.0
            if r < d and v < d:
                for j in range(surfaces):
                    monodromy[r, v] -= normals[j, r] * normals[j, v]


@inner
def _begin_segment(functions, segments, i, start, t, tables, state, rates):
    """Put the run at the start of a segment, with the unit vectors of states that feed its mode as tangents; rates."""
    n, x, vectors = start.size, state.x, state.vectors
    mode = segments[i, SEGMENT_MODE]
    live = 0
    for r in range(n):
        x[r] = start[r]
        if tables.feeds[mode, r] == 1:
            vectors[live, :] = 0.0
            vectors[live, r] = 1.0
            live += 1
    functions.field(mode, t, state.c, x, rates)
    last = i - 1 if i > 0 else segments.shape[0] - 1
    ended, taken = segments[last, SEGMENT_END], segments[last, SEGMENT_OUTCOME]
    begin(tables, state, mode, live, segments[last, SEGMENT_MODE], ended, taken)


@inner
def _put_back(feeds, vectors):
    """Put the tangents that were carried in their places amid unit vectors that no rate moves."""
    live = 0
    for v in range(feeds.size):
        live += feeds[v]
    for v in range(feeds.size - 1, -1, -1):
        if feeds[v] == 1:
            live -= 1
            for r in range(feeds.size):
                vectors[v, r] = vectors[live, r]
        else:
            vectors[v, :] = 0.0
            vectors[v, v] = 1.0


@inner
def _end_by_unknowns(state, stretch, rates, start_row, clock_row, own, moved):
    """The end of a segment by the unknowns: Phi dx + F+ dT + (F+ - Phi F-) dt, with F- in the first column of stretch.

    Its duration T stands in the column ``own``; the row of the clock goes on to the end.
    """
    vectors, n = state.vectors, state.x.size
    for r in range(n):
        late = rates[r]
        for v in range(n):
            late -= vectors[v, r] * stretch[v, 0]
        for u in range(clock_row.size):
            value = late * clock_row[u]
            for v in range(n):
                value += vectors[v, r] * start_row[v, u]
            moved[r, u] = value
        moved[r, own] += rates[r]
    clock_row[own] += 1.0


@inner
def _guard_equation(functions, mode, end, te, own, state, extent, clock_row, moved, gradient, row):
    """The equation that a segment ends on its guard: (its violation, what the guard varies by over the sizes).

    What a guard passes through within the rounding of time, as one that a spike meets, is no violation.
    """
    run, x, n = state.run[0], state.x, state.x.size
    value = functions.guard(mode, end, te, state.c, x, gradient)
    steep = 0.0
    for r in range(extent.size):
        steep = max(steep, abs(gradient[r]) * max(extent[r], abs(x[r])))
    steep = steep if steep > 0.0 else abs(gradient[n]) * run.period
    for u in range(clock_row.size):
        sum_ = gradient[n] * clock_row[u]
        for r in range(n):
            sum_ += gradient[r] * moved[r, u]
        row[u] = sum_
    row[clock_row.size - 1] += value
    return max(0.0, abs(value) - ROUNDING * abs(row[own] * te)) / steep, steep


@inner
def _cross(event, jump, pace, following, state, clock_row, moved, step, stretch, gap):
    """Across an event: the next start by unknowns in ``step``, tangents in ``stretch``, how far it is off in ``gap``.

    Row 0 of ``step`` is the state on the guard at which the event was taken; ``pace`` is the normal speed at the end.
    """
    x, vectors, n = state.x, state.vectors, state.x.size
    place = event_places(n)
    for r in range(n):
        row = place.jacobian + r * (n + 1)
        for u in range(clock_row.size):
            value = event[row + n] * clock_row[u]
            for v in range(n):
                value += event[row + v] * moved[v, u]
            step[1 + r, u] = value
        shift = event[place.image + r] - following[r]
        for v in range(n):
            # the event was taken on the guard, not where the segment ended
            shift += event[row + v] * (step[0, v] - x[v])
        step[1 + r, clock_row.size - 1] += shift
        for v in range(n):
            # columns of S Phi, S = DR + jump n/(n.F- + dh/dt)
            across = 0.0
            reset = 0.0
            for k in range(n):
                across += event[place.gradient + k] * vectors[v, k]
                reset += event[row + k] * vectors[v, k]
            stretch[r, v] = reset + (jump[r] * across / pace if jump[r] != 0.0 and across != 0.0 else 0.0)
        if r < gap.size:
            gap[r] = shift


@inner
def _eliminate_duration(row, steep, period, extent, own, clock_row, step):
    """Eliminate a duration by the equation of its event, where the unknowns grow along the flow and less with it."""
    pace = row[own]
    if not abs(pace) * period > ORBITS.steep * steep:
        return
    kept, left = 0.0, 0.0
    for r in range(extent.size):
        for u in range(own):
            part = (extent[u] if u < extent.size else period) / extent[r]
            kept = max(kept, part * abs(step[1 + r, u]))
            left = max(left, part * abs(step[1 + r, u] - step[1 + r, own] * row[u] / pace))
    if kept > ORBITS.grown and left < kept:
        for u in range(clock_row.size):
            clock_row[u] -= row[u] / pace
        for r in range(step.shape[0] - 1):
            rate = step[1 + r, own]
            for u in range(clock_row.size):
                step[1 + r, u] -= rate * row[u] / pace


@inner
def _go_on(following, state, moved, step, stretch, gap):
    """As `_cross` where no event ends the segment."""
    x, vectors, n = state.x, state.vectors, state.x.size
    for r in range(n):
        for u in range(moved.shape[1]):
            step[1 + r, u] = moved[r, u]
        shift = x[r] - following[r]
        step[1 + r, moved.shape[1] - 1] += shift
        for v in range(n):
            stretch[r, v] = vectors[v, r]
        if r < gap.size:
            gap[r] = shift


@inner
def _largest(gap, x, extent):
    """The largest of the distances between an end and the next start, relative to the sizes of the states."""
    off = 0.0
    for r in range(gap.size):
        off = max(off, abs(gap[r]) / max(extent[r], abs(x[r])))
    return off


@inner
def _shift_along(plane):
    """Take as shifted what does not close along the directions in which an orbit need not."""
    for k in range(LINES, plane.shape[0]):
        drift = plane[GAP, pivot(plane[k])]
        for r in range(plane.shape[1]):
            plane[DRIFT, r] += plane[k, r] * drift
            plane[GAP, r] -= plane[k, r] * drift


@inner
def _close_beside(count, direction, equations):
    """Of what is shifted along a direction only the rest has to close."""
    first = pivot(direction)
    for r in range(direction.size):
        for u in range(equations.shape[1] if r != first else 0):
            equations[count + r, u] -= direction[r] * equations[count + first, u]
    for u in range(equations.shape[1]):
        equations[count + first, u] = 0.0


@inner
def _lasts(periods, time, period, first, last, free, slope, row):
    """The equation that segments, whose durations stand in these columns, last a number of periods; its violation."""
    for u in range(first, last):
        row[u] = 1.0
    for j in range(row.size - 1 - free):
        row[free + j] = -periods * slope[j]
    row[row.size - 1] = time - periods * period
    return abs(time - periods * period) / period


@inner
def _on_plane(plane, start, x, extent, row):
    """The equation that the first start lies on a plane; its violation."""
    size = 0.0
    away = 0.0
    for r in range(extent.size):
        row[r] = plane[NORMAL, r]
        away += plane[NORMAL, r] * (start[r] - plane[START, r])
        size = max(size, abs(plane[NORMAL, r]) * max(extent[r], abs(x[r])))
    row[row.size - 1] = away
    return abs(away) / size


@inner
def _multiply(factor, stretch, product, monodromy):
    """The tangent map by that of one more segment, which is kept."""
    n = monodromy.shape[0]
    for r in range(n):
        for v in range(n):
            value = 0.0
            for k in range(n):
                value += stretch[r, k] * monodromy[k, v]
            product[r, v] = value
            factor[r, v] = stretch[r, v]
    for r in range(n):
        for v in range(n):
            monodromy[r, v] = product[r, v]


@inner
def _close(count, d, step, equations):
    """The equations that the last segment leads to the first start."""
    for r in range(d):
        for u in range(equations.shape[1]):
            equations[count + r, u] = step[1 + r, u]
        equations[count + r, r] -= 1.0


@inner
def _stay_put(count, d, plane, monodromy, equations):
    """States that come back whatever they are, as those that a mode leads along a function of time, stay put."""
    n, columns = monodromy.shape[0], equations.shape[1] - 1
    for r in range(d):
        held = True
        for k in range(LINES, plane.shape[0]):
            held = held and plane[k, r] == 0.0
        for v in range(n):
            held = held and monodromy[r, v] == (1.0 if r == v else 0.0)
        if held:
            for u in range(columns):
                equations[count + r, u] = 1.0 if u == r else 0.0
            equations[count + r, columns] = 0.0


@inner
def _on_surface(count, normal, start, extent, equations):
    """The first start lies on a surface that its mode holds, across which it comes back whatever it is; how far off."""
    d, n, columns = extent.size, start.size, equations.shape[1] - 1
    for u in range(columns + 1):
        across = 0.0
        for r in range(d):
            across += normal[r] * equations[count + r, u]
        here = 0.0
        if u < d:
            here = normal[u]
        elif u == d:
            here = normal[n]
        elif u == columns:
            here = normal[n + 1]
        elif u > d + count:
            here = normal[u - 1 - count]
        for r in range(d):
            equations[count + r, u] += normal[r] * (here - across)
    size = 0.0
    for r in range(d):
        size = max(size, abs(normal[r]) * max(extent[r], abs(start[r])))
    return abs(normal[n + 1]) / size


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
    plane : ndarray, shape (4 + m, d)
        State and normal of the plane on which an orbit without events and without a period begins (`START`, `NORMAL`);
        by how much the end may be shifted against the start (`DRIFT`), to which is added what it is shifted beyond that
        along the m directions in the last rows; room. Each direction has 1 where the others have 0, its first entry
        that is not zero.
    starts : ndarray, shape (N, d + q)
        States at the starts of the segments; the parameters behind them.
    phase : float
        Time at which the first segment begins.
    durations : ndarray, shape (N,)
    watched : int
        Whether to look for other guards on the way.
    found : tuple of ndarray
        Filled: equations (N + d + 1 + .., columns + 1), where that of the first entry of a direction in ``plane`` is
        zero, sensitivities (N, d + q, columns), monodromy (d + q, d + q), its factors (N, d + q, d + q), one a segment,
        speeds (N,), positive in the guard's direction, rates of the guards as they are written (N,), crossings and
        outcomes (N, 2), times of crossings (N,).

    The residual is the largest violation of an equation: distances relative to ``extent``, time to the period.
    """
    machine = machine_at(place)
    functions, settings, tables, scratch = machine.functions, machine.settings[0], machine.tables, machine.scratch
    asleep = machine_at(resting).tables
    method = Method(machine.stepper, machine.search, place, resting, 0)
    equations, sensitivity, monodromy, factors, speeds, written, seen, met = found
    moved, stretch, product, step, clock_row = room
    state = state_of(machine.states, 0)
    run, x, c = state.run[0], state.x, state.c
    count, n = starts.shape
    d, forced = sizes[STATES], sizes[FORCED] == 1
    _, lasting, free = _columns(sizes, count)
    event, jump, rates, following = scratch.event, scratch.jump, scratch.before, scratch.after
    gap = plane[GAP]
    slope = stretch[n]
    period = _forcing(functions, c, run, sizes, starts[0], rates, slope)
    surfaces = 0
    if tables.held[segments[0, SEGMENT_MODE]] > 0:
        scratch.metric[:] = 1.0
        for r in range(n):
            x[r] = starts[0, r]
        surfaces = normals_of(functions, tables, segments[0, SEGMENT_MODE], phase, state, d, scratch)
    _begin_sums(sizes, count, surfaces, scratch.normals, sensitivity[0], clock_row, monodromy)
    equations[:, :] = 0.0
    residual = 0.0
    total = 0.0
    events = 0
    t = phase
    for i in range(count):
        mode, end, own = segments[i, SEGMENT_MODE], segments[i, SEGMENT_END], lasting + i
        _begin_segment(functions, segments, i, starts[i], t, tables, state, rates)
        for r in range(n):
            stretch[r, 0] = rates[r]
        outcome, crossed, when = follow(
            functions, method, settings, tables, asleep, t, durations[i], end, watched == 1, state, scratch
        )
        if outcome != DONE:
            return outcome, math.inf
        seen[i, CROSSED] = crossed
        met[i] = when
        seen[i, CAME] = segments[i, SEGMENT_OUTCOME]
        _put_back(tables.feeds[mode], state.vectors)
        te = t + durations[i]
        total += durations[i]
        functions.field(mode, te, c, x, rates)
        _end_by_unknowns(state, stretch, rates, sensitivity[i], clock_row, own, moved)
        for r in range(n):
            following[r] = starts[i + 1, r] if i + 1 < count else starts[0, r]
            if i + 1 == count and r < d:
                following[r] += plane[DRIFT, r]
        if end >= 0:
            events += 1
            off, steep = _guard_equation(
                functions, mode, end, te, own, state, extent, clock_row, moved, scratch.gradient, equations[i]
            )
            residual = max(residual, off)
            for r in range(n):
                step[0, r] = x[r]
            # a guess may end far from its guard
            scratch.image[:] = GUARDS.far
            # how many rebounds come before a rest is not asked again
            event[event_places(n).complete] = tables.transitions[segments[i, SEGMENT_OUTCOME], COMPLETES]
            came = functions.event_map(mode, end, te, c, x, 1, scratch.image, settings.tolerance, event)
            seen[i, CAME] = came
            if came < 0:
                return FAILED, math.inf
            speed = normal_speed(event, n)
            # tangents have come to where the segment ends, which on a spike is another speed
            pace = event[event_places(n).gradient + n]
            for r in range(n):
                pace += event[event_places(n).gradient + r] * rates[r]
            direction = tables.active[mode, 1 + end]
            speeds[i] = speed * direction if direction != 0 else abs(speed)
            written[i] = event[event_places(n).rate]
            saltation_jump(event, jump)
            _cross(event, jump, pace, following, state, clock_row, moved, step, stretch, gap)
            _eliminate_duration(equations[i], steep, period, extent, own, clock_row, step)
        else:
            speeds[i] = written[i] = math.inf
            _go_on(following, state, moved, step, stretch, gap)
            if end == SHARE:
                missed = _lasts(1.0, durations[i], period, own, own + 1, free, slope, equations[i])
            else:
                missed = _on_plane(plane, starts[0], x, extent, equations[i])
            residual = max(residual, missed)
        if i + 1 == count:
            _shift_along(plane)
        residual = max(residual, _largest(gap, x, extent))
        _multiply(factors[i], stretch, product, monodromy)
        if i + 1 < count:
            for r in range(n):
                for u in range(clock_row.size):
                    sensitivity[i + 1, r, u] = step[1 + r, u]
        t = te
        if forced:
            whole = math.floor(te / period)
            t = te - whole * period
            for j in range(sizes[FREE]):
                clock_row[free + j] -= whole * slope[j]
    _close(count, d, step, equations)
    if events == 0 and sizes[FREE] == 0:
        _stay_put(count, d, plane, monodromy, equations)
    for j in range(surfaces):
        residual = max(residual, _on_surface(count, scratch.normals[j], starts[0], extent, equations))
    for k in range(LINES, plane.shape[0]):
        _close_beside(count, plane[k], equations)
    final = equations[count + d]
    if forced and events > 0:
        missed = _lasts(sizes[PERIODS], total, period, lasting, free, free, slope, final)
        residual = max(residual, missed)
    else:
        final[d] = 1.0
    return DONE, residual
