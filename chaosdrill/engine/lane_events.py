"""Which event comes first in the steps of lanes.

Most guards keep their side, and most that do not have one root that a Bernstein form of low degree isolates: both are
seen for all lanes at once. Whatever is less plain is left to ``engine.guards``, trajectory by trajectory.
"""

import math

from chaosdrill.engine import guard_errors, guard_roots, guards
from chaosdrill.engine import layout as at
from chaosdrill.engine.jit import inlined, inner, series
from chaosdrill.engine.lane_step import copy_lane
from chaosdrill.engine.lanes import LANES, chosen, gathered, larger, magnitude, row_of, smaller, some, spread, table_of
from chaosdrill.engine.polynomial import value_and_slope
from chaosdrill.engine.records import state_of
from chaosdrill.engine.roots import bernstein_weights
from chaosdrill.engine.tuning import GUARDS, LANE

_WEIGHTS = bernstein_weights(LANE.degree)

# columns of how the steps of a block end: outcome, guard, ties
OUTCOME, GUARD, TIES = range(3)


@series
def scale(first, count, order, block):
    """Polynomials of the guards on [0, 1] instead of the steps; sums of sizes, and of all terms but the first."""
    series = table_of(block.ws)
    scaled = table_of(block.scaled)
    totals = row_of(block.total)
    later = row_of(block.later)
    h = row_of(block.h)[0]
    square = h * h
    for j in range(count):
        g = series[first + j]
        a = scaled[j]
        even, odd = spread(0.0), spread(0.0)
        even_size, odd_size = even, odd
        power = spread(1.0)
        # the row of a series goes on with zeros
        for k in range(0, order + 1, 2):
            value = power * g[k]
            following = (power * h) * g[k + 1]
            a[k] = value
            a[k + 1] = following
            even = even + value
            odd = odd + following
            even_size = even_size + magnitude(value)
            odd_size = odd_size + magnitude(following)
            power = power * square
        totals[j] = even_size + odd_size
        later[j] = (even - g[0]) + odd


@inner
def _first_order(j, slope_leads, lane, block, errors):
    """Order 1 or 2 of a root at the start of a step where that is plain, as ``guards.settle`` sees it, else 0."""
    h = block.h[lane]
    total = block.total[j, lane]
    off = guards.ROUNDING * errors[0]
    if slope_leads:
        return 1 if guards.out_first(block.scaled[j, 1, lane] / h, 1, off, total, h) else 0
    bend = block.scaled[j, 2, lane]
    if not abs(bend) > GUARDS.vanishing * total:
        return 0
    return 2 if guards.out_first(bend / (h * h), 2, off, total, h) else 0


@inlined
def _plan(tables, states, mode, places, first, block):
    """How the guards stand where a step begins as the last one ended; what is not plain is ``alone``.

    Rows of the block say for every guard when it fires if that is known, or -1, whether its root is searched, from
    which side, and of which order its zero at the start is.
    """
    series = table_of(block.ws)
    wanted, signs, shifts, times = row_of(block.wanted), row_of(block.sign), row_of(block.shift), row_of(block.times)
    nothing = spread(0.0)
    plain = nothing <= 0.0
    for j in range(tables.active[mode, 0]):
        side = gathered(states.sides, places, tables.keys[mode, j])
        direction = float(tables.active[mode, 1 + j])
        moves = tables.marks[mode, j] & at.STILL == 0
        if moves:
            plain = plain & guards.is_on(side, series[first + j][0]) & guards.is_armed(side, direction)
        wanted[j] = spread(1.0 if moves else 0.0)
        signs[j] = -side
        shifts[j] = nothing
        times[j] = spread(-1.0)
    row_of(block.alone)[0] = chosen(plain, 0.0, 1.0)


@inlined
def _plan_anew(functions, tables, state, first, lane, block, scratch):
    """The same for one lane whose step begins otherwise; returns whether it is plain."""
    mode = state.run[0].mode
    count = tables.active[mode, 0]
    for j in range(count):
        if tables.marks[mode, j] & at.STILL:
            return False
        g = block.ws[first + j, 0, lane]
        slope = block.ws[first + j, 1, lane]
        how, side, order = guards.look(functions, tables, state, j, g, slope, block.t[lane], scratch)
        if order == 1 or how == at.UNSURE:
            order = _first_order(j, order == 1, lane, block, scratch.errors)
            if order == 0:
                return False
        if order == 2:
            ahead = 1 if block.ws[first + j, 2, lane] > 0.0 else -1
            how, side = guards.stand_at_rest(functions, tables, state, j, 2, ahead, slope, block.t[lane], scratch)
            if side != ahead:
                return False
        if how != at.ARMED and not (how == at.FIRE and order == 0):
            return False
        block.times[j, lane] = 0.0 if how == at.FIRE else -1.0
        block.wanted[j, lane] = 0.0 if how == at.FIRE else 1.0
        block.sign[j, lane] = -float(side)
        block.shift[j, lane] = float(order) if how == at.ARMED else 0.0
    for j in range(count):
        state.sides[tables.keys[mode, j]] = -int(block.sign[j, lane])
    return True


@inlined
def _reaches(j, block):
    """Where the polynomial of guard j, without its zeros at 0 and negative there, may reach zero."""
    g = table_of(block.scaled)[j]
    shift = row_of(block.shift)[j]
    begin = g[0]
    later = row_of(block.later)[j]
    total = row_of(block.total)[j]
    sizes = total - magnitude(begin)
    if some(shift > 0.0):
        simple, double = shift == 1.0, shift == 2.0
        second = chosen(double, g[2], 0.0)
        later = chosen(shift > 0.0, later - (g[1] + second), later)
        sizes = chosen(shift > 0.0, sizes - (magnitude(g[1]) + magnitude(second)), sizes)
        begin = chosen(double, second, chosen(simple, g[1], begin))
    sign = row_of(block.sign)[j]
    # of a sum and that of sizes, half the sum is that of the terms above zero
    return ~(sign * begin + (0.5 * (sign * later + sizes) + LANE.noise * total) <= 0.0)


@inlined
def _without_zeros(j, order, block):
    """The polynomial of guard j without its zeros at 0."""
    g = table_of(block.scaled)[j]
    shift = row_of(block.shift)[j]
    if some(shift > 0.0):
        a = row_of(block.polynomial)
        simple, double = shift == 1.0, shift == 2.0
        for k in range(order + 1):
            a[k] = chosen(double, g[k + 2], chosen(simple, g[k + 1], g[k]))
        return a
    return g


@series
def _bernstein(a, order, sign, rest, block):
    """Coefficients of the Bernstein form of the terms of low degree, times a sign; then what the others may add, and
    of each coefficient the largest up to it."""
    b = row_of(block.bernstein)
    highest = spread(-math.inf)
    for j in range(LANE.degree + 1):
        value = a[0]
        for k in range(1, j + 1):
            value = value + _WEIGHTS[j, k] * a[k]
        value = sign * value
        highest = larger(highest, value)
        b[j] = value
        b[at.HIGHEST + j] = highest
    for k in range(LANE.degree + 1, order + 1):
        rest = rest + magnitude(a[k])
    b[at.REST] = rest


@series
def _isolated(block):
    """Which lanes have no root, which may have one and at most one more behind it, and which of these may come back.

    The Bernstein coefficients of a lane that is negative at the start, up to what the rest may change of their signs,
    have to go once up and then at most once down, with no valley between (Descartes' rule). Extremes decide it, and
    not truth values from one to the next: these are packed where registers are shorter than lanes.
    """
    b = row_of(block.bernstein)
    rest = b[at.REST]
    last = b[LANE.degree]
    ahead = last
    valley = spread(-math.inf)
    for m in range(1, LANE.degree):
        j = LANE.degree - m
        value = b[j]
        rim = smaller(b[at.HIGHEST + j - 1], ahead)
        valley = larger(valley, smaller(rim - rest, rest - value))
        valley = larger(valley, smaller(rim + rest, -rest - value))
        ahead = larger(ahead, value)
    highest = b[at.HIGHEST + LANE.degree]
    # a coefficient that is no number is one of those that come after it, too
    none = (highest + rest <= 0.0) & (last + rest <= 0.0)
    return none, (b[0] < 0.0) & (highest > rest) & (valley < 0.0), ~(last > rest)


@series
def _first_sign(block):
    """About where the control polygon of the Bernstein form first gets above zero."""
    b = row_of(block.bernstein)
    value = b[LANE.degree]
    low, high = value, value
    place, knot = spread(0.0), spread(float(LANE.degree))
    for m in range(1, LANE.degree + 1):
        knot = knot - 1.0
        beyond = value > 0.0
        before = b[LANE.degree - m]
        place = chosen(beyond, knot, place)
        low = chosen(beyond, before, low)
        high = chosen(beyond, value, high)
        value = before
    return (place + low / (low - high)) * (1.0 / LANE.degree)


@series
def _summit(a, order, sign, noise, block):
    """Of lanes that rise and fall: which have no root, which have one before a place, and that place.

    Whether what rises and falls gets above zero is seen at its summit; of a concave one its tangent tells that it does
    not.
    """
    b = row_of(block.bernstein)
    rest = b[at.REST]
    highest = b[0]
    bound, bend = spread(0.0), spread(0.0)
    largest = spread(-math.inf)
    knot = spread(0.0)
    for j in range(1, LANE.degree):
        knot = knot + 1.0
        value = b[j]
        turn = (b[j + 1] - value) - (value - b[j - 1])
        above = value > highest
        largest = larger(largest, turn)
        bend = chosen(above, turn, bend)
        bound = chosen(above, knot, bound)
        highest = chosen(above, value, highest)
    bound = bound * (1.0 / LANE.degree)
    height, slope = value_and_slope(a, order, bound)
    hidden = ~(sign * height > LANE.sure * highest + noise)
    none = highest < -math.inf
    if some(hidden):
        summit = _inside(bound - slope / (LANE.degree * (LANE.degree - 1.0) * (sign * bend)))
        height, following = value_and_slope(a, order, summit)
        summit = _inside(summit - following * (summit - bound) / (following - slope))
        height, slope = value_and_slope(a, order, summit)
        margin = LANE.sure * highest + noise
        # in all of the step no point is higher than the tangent there
        top = sign * height + larger(sign * slope * (1.0 - summit), -(sign * slope * summit))
        concave = LANE.degree * (LANE.degree - 1.0) * largest + order * (order - 1.0) * rest < 0.0
        none = hidden & concave & (top < -margin)
        seen = hidden & (sign * height > margin)
        bound = chosen(seen, summit, bound)
        hidden = hidden & ~seen
    return none, ~hidden, bound


@series
def _inside(u):
    """Numbers that lie in a step as they are, others at its nearer end; what is no number becomes the beginning."""
    return smaller(larger(spread(0.0), u), 1.0)


@series
def _polish(a, order, searched, u):
    """Newton steps from u in the lanes of a mask: the roots, and where they have not settled."""
    before = spread(0.0)
    active = chosen(searched, 1.0, 0.0)
    for _ in range(LANE.iterations):
        f, d = value_and_slope(a, order, u)
        step = f / d
        u = chosen(active > 0.0, u - step, u)
        size = magnitude(step)
        # what is left after this step is to it as it is to the square of the one before
        settled = (size <= 1.2e-16 * u) | (size * size * size <= 1e-17 * u * before * before)
        active = chosen(settled, 0.0, active)
        before = size
        if not some(active > 0.0):
            break
    return u, active > 0.0


@inlined
def _search(marks, count, order, block):
    """Times of the first crossings of all guards in all lanes, -1 for none; ``alone`` is where that is not plain."""
    alone = row_of(block.alone)
    times = row_of(block.times)
    for j in range(count):
        candidates = (row_of(block.wanted)[j] > 0.0) & _reaches(j, block) & ~(alone[0] > 0.0)
        if not some(candidates):
            continue
        a = _without_zeros(j, order, block)
        sign = row_of(block.sign)[j]
        noise = LANE.noise * row_of(block.total)[j]
        if marks[j] & at.AFFINE == 0:
            noise = noise + guard_errors.cut_off(a, order, 1.0)
        _bernstein(a, order, sign, noise, block)
        none, isolated, returns = _isolated(block)
        searched = candidates & isolated
        alone[0] = chosen(candidates & ~(none | isolated), 1.0, alone[0])
        bound = spread(1.0)
        if some(searched & returns):
            absent, present, until = _summit(a, order, sign, noise, block)
            bound = chosen(returns, until, bound)
            alone[0] = chosen(searched & returns & ~(absent | present), 1.0, alone[0])
            searched = searched & (~returns | present)
        if some(searched):
            u, unsettled = _polish(a, order, searched, _first_sign(block))
            _, slope = value_and_slope(a, order, u)
            last, before = guard_errors.last_terms(a, order, u)
            told = guard_errors.is_told(last, before, u * slope)
            plain = (u >= 0.0) & (u <= bound) & told
            alone[0] = chosen(searched & (unsettled | ~plain), 1.0, alone[0])
            times[j] = chosen(searched, u * row_of(block.h)[0], times[j])


@inlined
def _by_itself(method, count, first, order, lane, block, scratch):
    """First event of one lane's step, as ``guards.first_event`` finds it for one trajectory: (time, guard, ties)."""
    copy_lane(block.ws, 0, first + count, lane, order, scratch.workspace)
    te, j, ties, h = method.search(method.place, method.p, block.h[lane], block.t[lane])
    block.h[lane] = h
    for k in range(count):
        block.backs[k, lane] = scratch.backs[k]
    return te, j, ties


@inlined
def _first_of(settings, count, block):
    """Which guard fires first in every lane and when, -1 for none; ``alone`` is where two are near each other."""
    times, alone = row_of(block.times), row_of(block.alone)
    none = spread(math.inf)
    first, second, which = none, none, spread(-1.0)
    for j in range(count):
        time = times[j]
        time = chosen(time >= 0.0, time, none)
        sooner = time < first
        second = chosen(sooner, first, smaller(second, time))
        which = chosen(sooner, float(j), which)
        first = chosen(sooner, time, first)
    alone[0] = chosen(second - first <= guard_errors.near(settings, row_of(block.h)[0]), 1.0, alone[0])
    row_of(block.which)[0] = which
    row_of(block.reach)[0] = chosen(which >= 0.0, first, -1.0)


@inlined
def first_events(machine, place, settings, mode, lanes, places, first, ends, block):
    """First event of every lane's step: its time (or -1, or -2) goes into ``block``, guard and ties into ``ends``."""
    functions, tables, states, scratch = machine.functions, machine.tables, machine.states, machine.scratch
    count = tables.active[mode, 0]
    scale(first, count, settings.order, block)
    _plan(tables, states, mode, places, first, block)
    for lane in range(LANES):
        state = state_of(states, places[lane])
        if lane >= lanes:
            block.alone[lane] = 1.0
        elif state.run[0].fresh != at.ONGOING:
            plain = _plan_anew(functions, tables, state, first, lane, block, scratch)
            block.alone[lane] = 0.0 if plain else 1.0
        state.run[0].turning = 0
    _search(tables.marks[mode], count, settings.order, block)
    for j in range(count):
        if tables.marks[mode, j] & at.TIMED:
            for lane in range(lanes):
                if block.alone[lane] == 0.0 and block.times[j, lane] > 0.0:
                    state = state_of(states, places[lane])
                    block.times[j, lane] = guard_roots.on_the_clock(
                        functions,
                        state.run[0],
                        state.c,
                        j,
                        block.times[j, lane],
                        block.h[lane],
                        state.x,
                        scratch.gradient,
                    )
    _first_of(settings, count, block)
    for lane in range(lanes):
        if block.alone[lane] == 0.0:
            ends[lane, GUARD] = int(block.which[lane])
            ends[lane, TIES] = 0
        else:
            method = at.Method(machine.stepper, machine.search, place, place, places[lane])
            te, j, ties = _by_itself(method, count, first, settings.order, lane, block, scratch)
            ends[lane, GUARD] = j
            ends[lane, TIES] = ties
            block.reach[lane] = te


@inner
def coincides(functions, tables, settings, state, first, j, te, instant, lane, block, scratch):
    """As ``guards.coincides`` for one lane."""
    if instant - te > guard_errors.near(settings, block.h[lane]):
        return False
    count = tables.active[state.run[0].mode, 0]
    copy_lane(block.ws, 0, first + count, lane, settings.order, scratch.workspace)
    return guards.coincides(
        functions,
        tables,
        settings,
        state,
        scratch.workspace,
        first,
        j,
        te,
        instant,
        block.h[lane],
        block.t[lane],
        scratch,
    )
