"""Which event comes first in the steps of lanes.

Most guards keep their side, and most that do not have one root that a Bernstein form of low degree isolates: both are
seen for all lanes at once. Whatever is less plain is left to ``engine.guards``, trajectory by trajectory.
"""

from numba import uint64

from chaosdrill.engine import guards
from chaosdrill.engine.jit import inlined, inner, series
from chaosdrill.engine.lane_step import copy_lane
from chaosdrill.engine.lanes import chosen, larger, magnitude, positive, row_of, some, spread, table_of
from chaosdrill.engine.layout import ARMED, FIRE, ONGOING, PASSED, TIMED, UNSURE, Method
from chaosdrill.engine.records import state_of
from chaosdrill.engine.roots import bernstein_weights

DEGREE = 11
"""Degree of the Bernstein form: in lanes a higher one costs little, and it isolates nearly all roots."""

_WEIGHTS = bernstein_weights(DEGREE)

ITERATIONS = 12
"""Newton steps before a root is left to the search for one trajectory."""

SURE = 1e-8
"""Part of the largest coefficient by which a value must be above zero to be called so: what only touches zero is looked
at for one trajectory."""

NOISE = 1e-14
"""Part of the sum of a guard's terms that rounding may take from its polynomial, and more."""

BELOW, ABOVE, BACK = range(3)

# columns of how the steps of a block end: outcome, guard, ties, whether the guards are looked at for one trajectory
OUTCOME, GUARD, TIES, ALONE = range(4)


@series
def scale(first, count, order, block):
    """Polynomials of the guards on [0, 1] instead of the steps, and the sums of their terms' sizes."""
    series = table_of(block.ws)
    scaled = table_of(block.scaled)
    totals = row_of(block.total)
    h = row_of(block.h)[0]
    for j in range(count):
        g = series[first + j]
        a = scaled[j]
        a[0] = g[0]
        total = magnitude(g[0])
        power = h
        for k in range(1, order + 1):
            value = power * g[k]
            a[k] = value
            total = total + magnitude(value)
            power = power * h
        totals[j] = total


@inner
def _first_order(j, slope_leads, lane, block, errors):
    """Order 1 or 2 of a root at the start of a step where that is plain, as ``guards.settle`` sees it, else 0."""
    h = block.h[lane]
    total = block.total[j, lane]
    off = guards.ROUNDING * errors[0]
    if slope_leads:
        return 1 if guards.out_first(block.scaled[j, 1, lane] / h, 1, off, total, h) else 0
    bend = block.scaled[j, 2, lane]
    if not abs(bend) > guards.VANISHING * total:
        return 0
    return 2 if guards.out_first(bend / (h * h), 2, off, total, h) else 0


@inlined
def _plan(functions, tables, state, first, lane, block, scratch):
    """How the guards of one lane stand; returns whether that is plain.

    Rows of the block say for every guard when it fires if that is known, or -1, whether its root is searched, from
    which side, and of which order its zero at the start is.
    """
    run = state.run[0]
    mode = run.mode
    count = tables.watch[mode, 0]
    for j in range(count):
        g = block.ws[first + j, 0, lane]
        direction = tables.watch[mode, 1 + j]
        side = state.sides[tables.keys[mode, j]]
        order = 0
        how = PASSED if direction != 0 and side == direction else ARMED
        if run.fresh != ONGOING:
            slope = block.ws[first + j, 1, lane]
            how, side, order = guards.look(functions, tables, state, j, g, slope, block.t[lane], scratch)
            if order == 1 or how == UNSURE:
                order = _first_order(j, order == 1, lane, block, scratch.errors)
                if order == 0:
                    return False
            if order == 2:
                how, side = guards.stand_at_rest(tables, state, j, 2, 1 if block.ws[first + j, 2, lane] > 0.0 else -1)
        elif not g * side > 0.0 or abs(side) > 1:
            return False
        if how != ARMED and not (how == FIRE and order == 0):
            return False
        block.times[j, lane] = 0.0 if how == FIRE else -1.0
        block.wanted[j, lane] = 0.0 if how == FIRE else 1.0
        block.sign[j, lane] = -float(side)
        block.shift[j, lane] = float(order) if how == ARMED else 0.0
    for j in range(count):
        state.sides[tables.keys[mode, j]] = -int(block.sign[j, lane])
    return True


@inlined
def _towards(j, order, block):
    """Fill the polynomial of guard j, without its zeros at 0, that is negative at 0; returns a bound of it."""
    a = row_of(block.polynomial)
    g = table_of(block.scaled)[j]
    sign = row_of(block.sign)[j]
    shift = row_of(block.shift)[j]
    bound = NOISE * row_of(block.total)[j]
    if some(shift):
        twice = larger(shift - 1.0, 0.0)
        for k in range(order + 1):
            value = sign * chosen(shift, chosen(twice, g[k + 2], g[k + 1]), g[k])
            a[k] = value
            if k > 0:
                bound = bound + larger(value, 0.0)
        return bound + a[0]
    for k in range(1, order + 1):
        value = sign * g[k]
        a[k] = value
        bound = bound + larger(value, 0.0)
    a[0] = sign * g[0]
    return bound + a[0]


@series
def _bernstein(order, rest, block):
    """Coefficients of the Bernstein form of the terms of low degree; last what the others may add."""
    a = row_of(block.polynomial)
    b = row_of(block.bernstein)
    for j in range(DEGREE + 1):
        value = a[0]
        for k in range(1, j + 1):
            value = value + _WEIGHTS[j, k] * a[k]
        b[j] = value
    for k in range(DEGREE + 1, order + 1):
        rest = rest + magnitude(a[k])
    b[DEGREE + 1] = rest


@series
def _crossing(block):
    """Which lanes have no root, which have one that the Bernstein form isolates, and about where that is.

    Lanes are 1.0 where it is so, else 0.0. One root is isolated by signs that change once (Descartes' rule).
    """
    b = row_of(block.bernstein)
    rest = b[DEGREE + 1]
    before = b[0]
    reaches = positive(before + rest)
    goes_back = reaches
    above = 0.0 * reaches
    crossed = above
    low = before
    high = before
    place = above
    for j in range(1, DEGREE + 1):
        value = b[j]
        may = positive(value + rest)
        is_above = positive(value - rest)
        goes_back = larger(goes_back, larger(reaches - may, above - is_above))
        reaches = larger(reaches, may)
        above = larger(above, is_above)
        beyond = positive(value)
        here = larger(beyond - crossed, 0.0)
        low = chosen(here, before, low)
        high = chosen(here, value, high)
        place = chosen(here, j - 1.0, place)
        crossed = larger(crossed, beyond)
        before = value
    return 1.0 - reaches, above * (1.0 - goes_back), (place + low / (low - high)) * (1.0 / DEGREE)


@series
def _value(a, order, lane, u):
    """Value at u of the polynomial in one lane."""
    value = a[order, lane]
    for k in range(order):
        value = value * u + a[uint64(order - 1 - k), lane]
    return value


@inner
def _isolated(a, b, order, lane):
    """Where one lane's polynomial first crosses zero, about, and a bound below which it does so just once.

    The first is -1 if it never does, and -2 if that is not plain: if the signs of the Bernstein coefficients, up to
    what the rest may change of them, do not go once up and at most once down (Descartes' rule).
    """
    rest = b[DEGREE + 1, lane]
    before = b[0, lane]
    if not before < -rest:
        return -2.0, 1.0
    where = -1.0
    phase = BELOW
    doubtful = False
    highest = 0
    for j in range(1, DEGREE + 1):
        value = b[j, lane]
        if abs(value) <= rest:
            doubtful = True
        elif value > rest:
            if phase == BACK or (phase == ABOVE and doubtful):
                return -2.0, 1.0
            phase = ABOVE
            doubtful = False
        elif value < -rest:
            if phase == ABOVE:
                phase = BACK
            elif doubtful:
                return -2.0, 1.0
            doubtful = False
        else:
            return -2.0, 1.0
        if value > b[highest, lane]:
            highest = j
        if before < 0.0 <= value and where < 0.0:
            where = (j - 1 + before / (before - value)) / DEGREE
        before = value
    if phase == BELOW:
        return (-2.0 if doubtful else -1.0), 1.0
    if phase == ABOVE and not doubtful:
        return where, 1.0
    bound = highest / DEGREE
    if (phase == BACK and doubtful) or not _value(a, order, lane, bound) > SURE * b[highest, lane]:
        return -2.0, 1.0
    return where, bound


@series
def _polish(order, block):
    """Newton steps from row 0 of the roots where row 1 is not 0.0, which it becomes where they settle."""
    a = row_of(block.polynomial)
    roots = row_of(block.root)
    u = roots[0]
    active = roots[1]
    before = 0.0 * u
    top = order - order % 2
    for _ in range(ITERATIONS):
        square = u * u
        f = a[top]
        d = 0.0 * u
        g = a[top + 1] if order % 2 == 1 else 0.0 * u
        e = 0.0 * u
        for j in range(top // 2):
            k = uint64(top - 2 - 2 * j)
            d = d * square + f
            f = f * square + a[k]
            e = e * square + g
            g = g * square + a[uint64(k + 1)]
        step = (f + u * g) / (2.0 * u * (d + u * e) + g)
        following = u - step
        size = magnitude(step)
        # what is left after this step is to it as it is to the square of the one before
        left = size * size * size - 1e-17 * u * before * before
        left = larger(0.0, chosen(larger(size - 1.2e-16 * u, 0.0), left, 0.0 * u))
        u = chosen(active, following, u)
        roots[0] = u
        active = chosen(active, left, 0.0 * u)
        roots[1] = active
        before = size
        if not some(active):
            return


@inlined
def _search(count, order, lanes, ends, block):
    """Times of the first crossings of all guards in all lanes that are planned, -1 for none.

    A lane in which one of them is not plain is left to the search for one trajectory.
    """
    h = row_of(block.h)[0]
    times = row_of(block.times)
    roots = row_of(block.root)
    for j in range(count):
        candidates = row_of(block.wanted)[j] * positive(_towards(j, order, block))
        if not some(candidates):
            continue
        _bernstein(order, NOISE * row_of(block.total)[j], block)
        none, once, where = _crossing(block)
        searched = candidates * once
        others = candidates - candidates * larger(none, once)
        roots[0] = chosen(searched, where, 0.5)
        roots[1] = searched
        roots[2] = others
        roots[3] = spread(1.0)
        if some(others):
            for lane in range(lanes):
                if block.root[2, lane] != 0.0:
                    where, block.root[3, lane] = _isolated(block.polynomial, block.bernstein, order, lane)
                    if where >= 0.0:
                        block.root[0, lane] = where
                        block.root[1, lane] = 1.0
                    elif where == -2.0:
                        ends[lane, ALONE] = 1
        searched = roots[1]
        if not some(searched):
            continue
        _polish(order, block)
        u = roots[0]
        outside = larger(roots[1], larger(positive(-u), positive(u - roots[3])))
        times[j] = chosen(searched, u * h, times[j])
        missed = searched * outside
        if some(missed):
            roots[2] = missed
            for lane in range(lanes):
                if block.root[2, lane] != 0.0:
                    ends[lane, ALONE] = 1


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
def _first_of(count, h, lane, times):
    """The guard that fires first in one lane, -1 for none, -2 where two are too near each other for that."""
    found = -1
    for j in range(count):
        if times[j, lane] >= 0.0 and (found < 0 or times[j, lane] < times[found, lane]):
            found = j
    for j in range(count):
        if j != found and times[j, lane] >= 0.0 and times[j, lane] - times[found, lane] <= guards.NEAR * h:
            return -2
    return found


@inlined
def first_events(machine, place, settings, mode, lanes, places, first, ends, block):
    """First event of every lane's step: its time (or -1, or -2) goes into ``block``, guard and ties into ``ends``."""
    functions, tables, states, scratch = machine.functions, machine.tables, machine.states, machine.scratch
    count = tables.watch[mode, 0]
    scale(first, count, settings.order, block)
    for j in range(count):
        row_of(block.wanted)[j] = spread(0.0)
    for lane in range(lanes):
        ends[lane, ALONE] = 0
        if not _plan(functions, tables, state_of(states, places[lane]), first, lane, block, scratch):
            ends[lane, ALONE] = 1
            for j in range(count):
                block.wanted[j, lane] = 0.0
    _search(count, settings.order, lanes, ends, block)
    for lane in range(lanes):
        state = state_of(states, places[lane])
        h = block.h[lane]
        j = -2
        if ends[lane, ALONE] == 0:
            state.run[0].turning = 0
            for k in range(count):
                if block.times[k, lane] > 0.0 and tables.marks[mode, k] & TIMED:
                    block.times[k, lane] = guards.on_the_clock(
                        functions,
                        state.run[0],
                        state.c,
                        k,
                        block.times[k, lane],
                        h,
                        state.x,
                        scratch.gradient,
                    )
            j = _first_of(count, h, lane, block.times)
        ends[lane, TIES] = 0
        if j == -2:
            method = Method(machine.stepper, machine.search, place, place, places[lane])
            te, j, ties = _by_itself(method, count, first, settings.order, lane, block, scratch)
            ends[lane, TIES] = ties
            block.reach[lane] = te
        else:
            block.reach[lane] = block.times[j, lane] if j >= 0 else -1.0
        ends[lane, GUARD] = j


@inner
def coincides(functions, tables, settings, state, first, j, te, instant, lane, block, scratch):
    """As ``guards.coincides`` for one lane."""
    if instant - te > guards.NEAR * block.h[lane]:
        return False
    count = tables.watch[state.run[0].mode, 0]
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
