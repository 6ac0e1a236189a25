"""When a state leaves the bounds that its system was given: the first instant, wherever steps end."""

from chaosdrill.codegen.kinds import Tuple, float64, int64, uint64
from chaosdrill.codegen.layout import EPSILON
from chaosdrill.engine import layout as at
from chaosdrill.engine.jit import inlined, inner, rare
from chaosdrill.engine.lanes import LANES, chosen, every, larger, row_of, spread, table_of
from chaosdrill.engine.polynomial import derivative, lane_size, sizes
from chaosdrill.engine.records import unit
from chaosdrill.engine.roots import first_crossing
from chaosdrill.engine.tuning import STEPS


@inner
def _slack(tables, settings, state, i):
    """How far beyond a bound state i is still on it, as on a wall there: by the error of a method in its value."""
    error = STEPS.on_bound * EPSILON if settings.stepping == at.BY_SERIES else settings.tolerance
    return max(error * max(state.scale[i], abs(state.x[i])), tables.slack[i])


@unit(Tuple((float64, int64)))
def first_escape(tables, settings, state, h, scratch):
    """When, up to h, the polynomial of a state is first beyond its bounds, and beyond which: (-1, -1) if never.

    Bound 2 k is the lower one of fence k, and 2 k + 1 the upper one.
    """
    which = -1
    # a comparison of eight parts costs less than their sum
    parts = spread(0.0)
    for k in range(tables.fences.shape[0]):
        parts = parts + sizes(scratch.workspace, uint64(tables.fences[k, 0]), h) * tables.fences[k, 3]
    if every(parts <= 1.0 / LANES):
        return -1.0, which
    for k in range(tables.fences.shape[0]):
        i = int(tables.fences[k, 0])
        row, slack = scratch.workspace[i], _slack(tables, settings, state, i)
        first = row[0]
        for side in range(2):
            up = side == 1
            row[0] = first - tables.fences[k, 1 + side] + (-slack if up else slack)
            s = -1.0
            if (row[0] > 0.0) == up and row[0] != 0.0:
                s = 0.0
            elif row[0] == row[0]:
                s = first_crossing(row, 0, settings.order, h, up, scratch.polynomial, scratch.stack, scratch.ends)
            row[0] = first
            if s >= 0.0:
                h = s
                which = 2 * k + side
    return (h if which >= 0 else -1.0), which


@inner
def _beyond(tables, settings, state, x):
    """Beyond which bound a state is; -1 for none."""
    for k in range(tables.fences.shape[0]):
        i = int(tables.fences[k, 0])
        slack = _slack(tables, settings, state, i)
        if x[i] < tables.fences[k, 1] - slack:
            return 2 * k
        if x[i] > tables.fences[k, 2] + slack:
            return 2 * k + 1
    return -1


@rare
def _by_bisection(method, tables, settings, t, h, state, out):
    """As `first_escape`, by the states at both ends of the step."""
    which = _beyond(tables, settings, state, state.x)
    if which >= 0:
        return 0.0, which
    method.stepper.evaluate(method.place, method.p, t, h)
    which = _beyond(tables, settings, state, out)
    low = 0.0
    while which >= 0 and h - low > settings.tolerance * state.run[0].fixed_step:
        middle = 0.5 * (low + h)
        method.stepper.evaluate(method.place, method.p, t, middle)
        found = _beyond(tables, settings, state, out)
        if found >= 0:
            h, which = middle, found
        else:
            low = middle
    return (h if which >= 0 else -1.0), which


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


@rare
def _by_method(method, tables, settings, t, h, state, scratch):
    """As `first_escape`, as exact as a method that steps by evaluations of the right-hand side."""
    if settings.stepping == at.FIXED:
        return _by_bisection(method, tables, settings, t, h, state, scratch.out)
    s, which = first_escape(tables, settings, state, h, scratch)
    if s > 0.0:
        s = _nearer(method, tables, t, s, h, which, scratch.workspace, scratch.out)
    return s, which


@inlined
def up_to_escape(method, tables, settings, t, h, state, scratch):
    """How far a step up to h goes on within the bounds, and beyond which it then is; -1 for none."""
    if settings.stepping == at.BY_SERIES:
        s, which = first_escape(tables, settings, state, h, scratch)
    else:
        s, which = _by_method(method, tables, settings, t, h, state, scratch)
    return (s if which >= 0 else h), which


@inlined
def near_in_lanes(tables, block):
    """Into ``block.gap[1]``: in which lanes the terms of a state may bring it to its bounds."""
    series, s = table_of(block.ws), row_of(block.reach)[0]
    found = spread(0.0)
    for k in range(tables.fences.shape[0]):
        part = lane_size(series, int(tables.fences[k, 0]), s) * tables.fences[k, 3]
        found = larger(found, chosen(part <= 1.0, 0.0, 1.0))
    row_of(block.gap)[1] = found


@inlined
def put_beyond(tables, state, s, which):
    """Put a state that has escaped after the time s next to its bound, by the last digit; a reset leads farther."""
    if s > 0.0:
        state.x[int(tables.fences[which // 2, 0])] = tables.fences[which // 2, 1 + which % 2]
