"""When a state leaves the bounds that its system was given: the first instant, wherever steps end.

A state that decays onto a bound, or rests at one, is beyond it by its error at times, and has not left it. It has where
it gets farther than that, and then at the crossing of the bound itself.
"""

from chaosdrill.codegen.kinds import Tuple, float64, int64, uint64
from chaosdrill.codegen.layout import EPSILON, ROUNDING
from chaosdrill.engine import layout as at
from chaosdrill.engine.guard_errors import slope_and_bend
from chaosdrill.engine.jit import compiled, inlined, inner, rare
from chaosdrill.engine.lanes import chosen, larger, magnitude, row_of, spread, table_of
from chaosdrill.engine.polynomial import derivative, lane_size, size, value
from chaosdrill.engine.records import STEPPER_SIGNATURES, machine_at, state_of, unit
from chaosdrill.engine.roots import first_crossing, recrossing
from chaosdrill.engine.tuning import GUARDS, STEPS


@inner
def _is_beyond(tables, k, x):
    """Whether a value is beyond a bound of fence k."""
    return x <= tables.fences[k, 1] or x >= tables.fences[k, 2]


@inner
def _leeway(tables, settings, state, k):
    """How far beyond its bounds the state of fence k is still on them: by the error that a run makes in it.

    That is as for a run that begins beyond a guard, and does not become less while the state stays there, though its
    size fades.
    """
    i = int(tables.fences[k, 0])
    width, x = abs(state.x[i]), state.x[i]
    error = GUARDS.late * max(settings.tolerance * state.scale[i], EPSILON * width) + ROUNDING * state.doubt[i]
    if settings.stepping == at.FIXED:
        error = max(error, GUARDS.late * settings.tolerance * width)
    state.leeway[i] = max(error, state.leeway[i]) if _is_beyond(tables, k, x) else error
    return state.leeway[i]


@inner
def _leaves(row, bound, leeway, up, order, h, scratch):
    """When a polynomial that gets farther beyond a bound than its leeway, up to h, crosses that; -1 if it does not."""
    first = row[0]
    room, stack, ends = scratch.polynomial, scratch.stack, scratch.ends
    s = -1.0
    row[0] = (first - bound) + (-leeway if up else leeway)
    if (row[0] > 0.0) == up and row[0] != 0.0:
        s = 0.0
    elif row[0] == row[0]:
        s = first_crossing(row, 0, order, h, up, room, stack, ends)
    if s > 0.0:
        row[0] = first - bound
        if (row[0] < 0.0) == up and row[0] != 0.0:
            crossed = first_crossing(row, 0, order, s, up, room, stack, ends)
            s = crossed if crossed >= 0.0 else s
        else:
            back, crossed = recrossing(row, 0, order, s, up, room, scratch.shifted, stack, ends)
            s = crossed if crossed >= 0.0 else 0.0 if back < 0.0 else s
    row[0] = first
    return s


@unit(Tuple((float64, int64)))
def first_escape(tables, settings, state, h, scratch):
    """When, up to h, the polynomial of a state is first beyond its bounds, and beyond which: (-1, -1) if never.

    Bound 2 k is the lower one of fence k, and 2 k + 1 the upper one.
    """
    ws = scratch.workspace
    found, which = -1.0, -1
    for k in range(tables.fences.shape[0]):
        i = uint64(tables.fences[k, 0])
        row, here = ws[i], ws[i, 0]
        moves = size(ws, i, h) - abs(here)
        if here - moves > tables.fences[k, 1] and here + moves < tables.fences[k, 2]:
            continue
        leeway = _leeway(tables, settings, state, k)
        for side in range(2):
            s = _leaves(row, tables.fences[k, 1 + side], leeway, side == 1, settings.order, h, scratch)
            if s >= 0.0 and (which < 0 or s < found):
                found, which = s, 2 * k + side
    return found, which


@inner
def _outside(tables, state, x, far):
    """Beyond which bound a state is, if ``far`` by more than its leeway; -1 for none."""
    for k in range(tables.fences.shape[0]):
        i = int(tables.fences[k, 0])
        leeway = state.leeway[i] if far else 0.0
        if x[i] <= tables.fences[k, 1] - leeway:
            return 2 * k
        if x[i] >= tables.fences[k, 2] + leeway:
            return 2 * k + 1
    return -1


@rare
def _by_bisection(method, tables, settings, t, h, state, out):
    """As `first_escape`, by the states at both ends of the step."""
    for k in range(tables.fences.shape[0]):
        _leeway(tables, settings, state, k)
    which = _outside(tables, state, state.x, True)
    if which >= 0:
        return 0.0, which
    method.stepper.evaluate(method.place, method.p, t, h)
    which = _outside(tables, state, out, True)
    if which < 0:
        return -1.0, which
    low = 0.0
    if _is_beyond(tables, which // 2, state.x[int(tables.fences[which // 2, 0])]):
        h = 0.0
    while h - low > settings.tolerance * state.run[0].fixed_step:
        middle = 0.5 * (low + h)
        method.stepper.evaluate(method.place, method.p, t, middle)
        found = _outside(tables, state, out, False)
        if found >= 0:
            h, which = middle, found
        else:
            low = middle
    return h, which


@rare
def _goes_beyond(method, tables, settings, state, t, s, h, which, ws, out):
    """Whether a state that has crossed its bound at s, as a dense output has it, does get beyond its leeway.

    It is looked at where it is farthest beyond: the dense output may be so by what it leaves out.
    """
    k, side = which // 2, 1 + which % 2
    i, sign = int(tables.fences[k, 0]), 1.0 if side == 2 else -1.0
    top = h
    for m in range(STEPS.places):
        place = s + (h - s) * m / STEPS.places
        if sign * (value(ws, uint64(i), place) - value(ws, uint64(i), top)) > 0.0:
            top = place
    for _ in range(STEPS.to_bound):
        slope, bend = slope_and_bend(ws[i], settings.order, top)
        if sign * bend < 0.0:
            top = min(max(top - slope / bend, s), h)
    method.stepper.evaluate(method.place, method.p, t, top)
    return sign * (out[i] - tables.fences[k, side]) > state.leeway[i]


@rare
def _nearer(method, tables, t, s, h, which, ws, out):
    """The time s of an escape, as exact as the method: a dense output is less so."""
    i = int(tables.fences[which // 2, 0])
    for _ in range(STEPS.to_bound):
        method.stepper.evaluate(method.place, method.p, t, s)
        slope = derivative(ws, uint64(i), s)
        step = (out[i] - tables.fences[which // 2, 1 + which % 2]) / slope if slope != 0.0 else 0.0
        if not 0.0 < s - step <= h:
            break
        s -= step
    return s


@compiled(STEPPER_SIGNATURES["escape"])
def escape(place, p, t, h):
    """As `first_escape`, as exact as a method that steps by evaluations of the right-hand side."""
    machine = machine_at(place)
    settings, tables, scratch = machine.settings[0], machine.tables, machine.scratch
    state = state_of(machine.states, p)
    method = at.Method(machine.stepper, machine.search, place, place, p)
    if settings.stepping == at.FIXED:
        return _by_bisection(method, tables, settings, t, h, state, scratch.out)
    s, which = first_escape(tables, settings, state, h, scratch)
    if which >= 0 and _outside(tables, state, state.x, True) < 0:
        if not _goes_beyond(method, tables, settings, state, t, s, h, which, scratch.workspace, scratch.out):
            return -1.0, -1
        s = _nearer(method, tables, t, s, h, which, scratch.workspace, scratch.out)
    return s, which


@inlined
def up_to_escape(method, tables, settings, t, h, state, scratch):
    """How far a step up to h goes on within the bounds, and beyond which it then is; -1 for none."""
    if settings.stepping == at.BY_SERIES:
        s, which = first_escape(tables, settings, state, h, scratch)
    else:
        s, which = method.stepper.escape(method.place, method.p, t, h)
    return (s if which >= 0 else h), which


@inlined
def near_in_lanes(tables, block):
    """Into ``block.gap[1]``: in which lanes the terms of a state may bring it to its bounds."""
    series, s = table_of(block.ws), row_of(block.reach)[0]
    found = spread(0.0)
    for k in range(tables.fences.shape[0]):
        g = series[int(tables.fences[k, 0])]
        moves = lane_size(series, int(tables.fences[k, 0]), s) - magnitude(g[0])
        within = (g[0] - moves > tables.fences[k, 1]) & (g[0] + moves < tables.fences[k, 2])
        found = larger(found, chosen(within, 0.0, 1.0))
    row_of(block.gap)[1] = found


@inlined
def put_beyond(tables, state, s, which):
    """Put a state that has escaped after the time s next to its bound, by the last digit; a reset leads farther."""
    if s > 0.0:
        state.x[int(tables.fences[which // 2, 0])] = tables.fences[which // 2, 1 + which % 2]
