"""Which event comes first in the steps of lanes.

Most guards keep their side, and most that do not have one root that a Bernstein form of low degree isolates: both are
seen for all lanes at once. Whatever is less plain is left to ``engine.guards``, trajectory by trajectory.
"""

from numba import uint64

from chaosdrill.engine import guards
from chaosdrill.engine.jit import inlined, inner, series
from chaosdrill.engine.lane_series import lane_size_whole
from chaosdrill.engine.lane_step import copy_lane
from chaosdrill.engine.lanes import LANES, chosen, larger, magnitude, row_of, table_of
from chaosdrill.engine.layout import (
    ARMED,
    BLOCK_BERNSTEIN,
    BLOCK_H,
    BLOCK_POLYNOMIAL,
    BLOCK_REACH,
    BLOCK_ROOT,
    BLOCK_SIGN,
    BLOCK_SIZE,
    BLOCK_TIMES,
    BLOCK_WS,
    ENDS,
    FIRE,
    FIRED,
    FRESH,
    INVALID,
    MARKS,
    ONGOING,
    PASSED,
    POLYNOMIAL,
    SHIFTED,
    STACK,
    TIMES,
    WORKSPACE,
)
from chaosdrill.engine.roots import bernstein_weights, first_crossing

DEGREE = 11
"""Degree of the Bernstein form: in lanes a higher one costs little, and it isolates nearly all roots."""

_WEIGHTS = bernstein_weights(DEGREE)

ITERATIONS = 12
"""Newton steps before a root is left to the search for one trajectory."""

SURE = 1e-12
"""Part of the largest coefficient by which a value must be above zero to be called so."""

AT_ONCE, SEARCH, ALONE = range(3)
BELOW, ABOVE, BACK = range(3)


@inlined
def _plan(first, count, directions, marks, h, x, carried, sides, armed, lane, plan, block):
    """How the guards of one lane stand; returns ALONE if that is not plain, INVALID for a start beyond one."""
    ws = block[BLOCK_WS]
    fresh = carried[FRESH]
    floor = 0.0
    if fresh != ONGOING:
        for i in range(x.size):
            floor = max(floor, abs(x[i]))
        floor *= 2e-15
    for j in range(count):
        g = ws[first + j, 0, lane]
        shift = 0
        side = sides[j]
        how = ARMED
        if fresh == ONGOING:
            if armed[j] == 0:
                return ALONE
            if g * side <= 0.0:
                how = FIRE
        else:
            limit = guards.ZERO * block[BLOCK_SIZE][j, lane] + floor
            if not abs(g) > limit:
                shift = 1
                g = ws[first + j, 1, lane]
                if not abs(g) * h > limit:
                    shift = 2
                    g = ws[first + j, 2, lane]
                    if not abs(g) * h * h > limit:
                        return ALONE
            side = 1 if g > 0.0 else -1
            just_fired = j == carried[FIRED]
            how = guards.stand(side, directions[j], shift, fresh, marks[j] & MARKS != 0, just_fired, armed[j] == 1)
            if how in (PASSED, INVALID):
                return ALONE
        plan[j, lane] = AT_ONCE if how == FIRE else SEARCH
        plan[count + j, lane] = side
        block[BLOCK_SIGN][j, lane] = -float(side)
        block[BLOCK_SIGN][count + j, lane] = float(shift)
    for j in range(count):
        sides[j] = plan[count + j, lane]
        armed[j] = 1
    return SEARCH


@inlined
def _scaled(series, row, sign, shift, any_shift, h, order, block):
    """Fill the polynomial of one guard, without its zeros at 0, on [0, 1] and negative at 0; returns a bound of it."""
    a = row_of(block[BLOCK_POLYNOMIAL])
    g = series[row]
    power = sign
    bound = power * g[0]
    if any_shift:
        twice = larger(shift - 1.0, 0.0)
        for k in range(order + 1):
            later = chosen(twice, g[k + 2], g[k + 1])
            a[k] = power * chosen(shift, later, g[k])
            power = power * h
        bound = a[0]
        for k in range(1, order + 1):
            bound = bound + larger(a[k], 0.0)
    else:
        a[0] = bound
        for k in range(1, order + 1):
            power = power * h
            value = power * g[k]
            a[k] = value
            bound = bound + larger(value, 0.0)
    return bound


@series
def _bernstein(order, block):
    """Coefficients of the Bernstein form of the terms of low degree, and the size of the rest."""
    a = row_of(block[BLOCK_POLYNOMIAL])
    b = row_of(block[BLOCK_BERNSTEIN])
    for j in range(DEGREE + 1):
        value = a[0]
        for k in range(1, j + 1):
            value = value + _WEIGHTS[j, k] * a[k]
        b[j] = value
    rest = magnitude(a[DEGREE + 1])
    for k in range(DEGREE + 2, order + 1):
        rest = rest + magnitude(a[k])
    b[DEGREE + 1] = rest


@series
def _value(a, order, lane, u):
    """Value at u of the polynomial in one lane."""
    value = a[order, lane]
    for k in range(order):
        value = value * u + a[uint64(order - 1 - k), lane]
    return value


@inlined
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
    a = row_of(block[BLOCK_POLYNOMIAL])
    roots = row_of(block[BLOCK_ROOT])
    waiting = block[BLOCK_ROOT][1]
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
        settled = True
        for lane in range(LANES):
            if waiting[lane] != 0.0:
                settled = False
        if settled:
            return


@inner
def _alone(first, j, shift, order, h, up, lane, block, scratch):
    """The first crossing of one guard of one lane, by the search for one trajectory."""
    copy_lane(block[BLOCK_WS], first + j, 1, lane, order, scratch[WORKSPACE])
    return first_crossing(
        scratch[WORKSPACE][0], shift, order - shift, h, up, scratch[POLYNOMIAL], scratch[STACK], scratch[ENDS]
    )


@inlined
def search(first, count, order, lanes, plan, results, block, scratch):
    """Times of the first crossings of all guards in all lanes that are planned, -1 for none."""
    series = table_of(block[BLOCK_WS])
    signs = row_of(block[BLOCK_SIGN])
    h = row_of(block[BLOCK_H])[0]
    times = block[BLOCK_TIMES]
    b = block[BLOCK_BERNSTEIN]
    roots = block[BLOCK_ROOT]
    shifts = block[BLOCK_SIGN]
    for j in range(count):
        any_shift = False
        for lane in range(LANES):
            any_shift |= shifts[count + j, lane] != 0.0
        bound = _scaled(series, first + j, signs[j], signs[count + j], any_shift, h, order, block)
        row_of(roots)[2] = bound
        candidates = 0
        for lane in range(LANES):
            times[j, lane] = -1.0
            roots[1, lane] = 0.0
            roots[0, lane] = 0.5
            if lane < lanes and results[lane, 3] == SEARCH:
                if plan[j, lane] == AT_ONCE:
                    times[j, lane] = 0.0
                elif not roots[2, lane] < 0.0:
                    roots[1, lane] = 1.0
                    candidates += 1
        if candidates == 0:
            continue
        _bernstein(order, block)
        isolated = 0
        for lane in range(lanes):
            # from here on row 2 says which lanes are searched, and row 1 which of them are polished
            searched = roots[1, lane]
            roots[2, lane] = searched
            if searched != 0.0:
                where, roots[3, lane] = _isolated(block[BLOCK_POLYNOMIAL], b, order, lane)
                if where == -1.0:
                    roots[2, lane] = 0.0
                if where >= 0.0:
                    roots[0, lane] = where
                    isolated += 1
                else:
                    roots[1, lane] = 0.0
                    roots[0, lane] = -1.0
        if isolated > 0:
            _polish(order, block)
        for lane in range(lanes):
            if roots[2, lane] == 0.0:
                continue
            u = roots[0, lane]
            if roots[1, lane] == 0.0 and 0.0 <= u <= roots[3, lane]:
                times[j, lane] = u * block[BLOCK_H][lane]
            else:
                shift = int(shifts[count + j, lane])
                up = plan[count + j, lane] < 0
                times[j, lane] = _alone(first, j, shift, order, block[BLOCK_H][lane], up, lane, block, scratch)


@inner
def _by_itself(first, count, directions, marks, order, h, x, carried, sides, armed, lane, block, scratch):
    """First event of one lane's step, as ``guards.first_event`` finds it for one trajectory."""
    floor = 0.0
    for i in range(x.size):
        floor = max(floor, abs(x[i]))
    rows = scratch[WORKSPACE]
    copy_lane(block[BLOCK_WS], first, count, lane, order, rows)
    polynomials = (scratch[POLYNOMIAL], scratch[SHIFTED], scratch[STACK], scratch[ENDS], scratch[TIMES])
    return guards.first_event(
        rows,
        0,
        directions,
        count,
        marks,
        order,
        h,
        2e-15 * floor,
        carried[FRESH],
        carried[FIRED],
        sides,
        armed,
        polynomials,
    )


@inlined
def first_events(first, count, directions, marks, order, lanes, places, runs, results, plan, block, scratch):
    """First event of every lane's step: its time (or -1, or -2) goes into ``block``, guard and ties into ``results``.

    ``runs`` are the states, the carried integers, and how the guards stand, of all runs.
    """
    x, carried, sides, armed = runs
    steps = block[BLOCK_H]
    began = False
    for lane in range(lanes):
        began |= carried[places[lane], FRESH] != ONGOING
    if began:
        series = table_of(block[BLOCK_WS])
        h = row_of(steps)[0]
        sizes = row_of(block[BLOCK_SIZE])
        for j in range(count):
            sizes[j] = lane_size_whole(series[first + j], h)
    for lane in range(lanes):
        p = places[lane]
        results[lane, 3] = _plan(
            first, count, directions, marks, steps[lane], x[p], carried[p], sides[p], armed[p], lane, plan, block
        )
    search(first, count, order, lanes, plan, results, block, scratch)
    for lane in range(lanes):
        p = places[lane]
        if results[lane, 3] == SEARCH:
            times = scratch[TIMES]
            for j in range(count):
                times[j] = block[BLOCK_TIMES][j, lane]
            te, j, ties = guards.earliest(times, count, steps[lane])
        else:
            te, j, ties = _by_itself(
                first,
                count,
                directions,
                marks,
                order,
                steps[lane],
                x[p],
                carried[p],
                sides[p],
                armed[p],
                lane,
                block,
                scratch,
            )
        block[BLOCK_REACH][lane] = te
        results[lane, 1] = j
        results[lane, 2] = ties
