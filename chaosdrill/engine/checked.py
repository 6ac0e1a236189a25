"""When a step counts: what the estimate of a method cannot see is looked at.

An estimate tells of the operations of the equations that are smooth on the scale of the step. A steep one, a tanh far
from its slope, a pulse, a pole or a branch point beside the path, may hide something; see `chaosdrill.codegen.steep`.
What it is applied to is smooth, and how far that moves in the step is known. Where it moves no farther than the
operation shows in the estimate, nothing is hidden and nothing is done. Else the step is looked at from its start on, at
places between which no argument moves by more than the scale of its operation: at each the rates of the polynomial are
compared with the equations. The step ends before the first place at which they do not agree, or at which an argument is
about to leave where its operation has a series.
"""

import math
from collections.abc import Callable
from typing import Any

from chaosdrill.codegen.kinds import Tuple, int64, uint64
from chaosdrill.codegen.layout import AT_ALL, AT_SERIES, CROSSED, EPSILON, ONE_SIDED
from chaosdrill.engine import guards
from chaosdrill.engine import layout as at
from chaosdrill.engine.jit import inlined, inner, rare, series
from chaosdrill.engine.lanes import as_wide, chosen, every, larger, magnitude
from chaosdrill.engine.polynomial import late_size, size, value
from chaosdrill.engine.records import unit
from chaosdrill.engine.tuning import CHECKS


@series
def values_and_rates(ws, first, count, order, s, values, rates):
    """Polynomials of ``count`` rows from the first on, and their derivatives, at s."""
    i = 0
    while i < count:
        second = min(i + 1, count - 1)
        third = min(i + 2, count - 1)
        a = ws[first + i, order]
        b = ws[first + second, order]
        c = ws[first + third, order]
        da = 0.0
        db = 0.0
        dc = 0.0
        for j in range(order):
            k = uint64(order - 1 - j)
            da = da * s + a
            db = db * s + b
            dc = dc * s + c
            a = a * s + ws[first + i, k]
            b = b * s + ws[first + second, k]
            c = c * s + ws[first + third, k]
        values[i] = a
        values[second] = b
        values[third] = c
        rates[i] = da
        rates[second] = db
        rates[third] = dc
        i += 3


@inlined
def first_row(ws, vectors, v):
    """Row from which the series of tangent v stand."""
    m, n = vectors.shape[0], vectors.shape[1]
    return ws.shape[0] - (m + m % 2) * n + v * n


@inlined
def free(shape, order, here):
    """How far the argument of an operation may move from ``here`` without a look."""
    return larger(shape[0] * order, shape[1] * magnitude(here) - shape[2])


@inlined
def shows_all(late_size, size, tables, settings, mode, h, series):
    """Whether no steep operation may hide anything in a step of a series."""
    hidden = as_wide(0.0, h)
    for k in range(tables.steep[mode, 0]):
        row = uint64(tables.steep[mode, 1 + k])
        here = magnitude(series[row][0])
        allowed = free(tables.shapes[mode, k], settings.order, here)
        # the first terms alone say no to nearly all
        near = late_size(series, row, h, uint64(1)) * h <= CHECKS.few * allowed
        if not every(near):
            near = near | (size(series, row, h) - here <= allowed)
            hidden = larger(hidden, chosen(near, 0.0, 1.0))
    return hidden <= 0.0


@inner
def read(functions, mode, t, c, x, out):
    """What steep operations are applied to at a state, cut to the size of the largest that counts."""
    functions.watch(mode, t, c, x, out)
    for k in range(out.size):
        if abs(out[k]) > CHECKS.largest:
            out[k] = math.copysign(CHECKS.largest, out[k])


@inner
def watch(functions, mode, t, c, ws, n, s, place, out):
    """What steep operations are applied to at s, where the states are polynomials."""
    for i in range(n):
        place[i] = value(ws, uint64(i), s)
    read(functions, mode, t + s, c, place, out)


@inner
def may_hide_between(functions, tables, settings, h, t, state, scratch):
    """Whether a steep operation may hide something in a step with a dense output, by a few places of it."""
    mode, n = state.run[0].mode, state.x.size
    start, there = scratch.watched[0], scratch.watched[1]
    read(functions, mode, t, state.c, state.x, start)
    for m in range(4):
        watch(functions, mode, t, state.c, scratch.workspace, n, 0.25 * (m + 1) * h, scratch.image, there)
        for k in range(tables.steep[mode, 0]):
            shape = tables.shapes[mode, k]
            moved = abs(there[k] - start[k])
            if math.isnan(moved):
                return True
            if shape[6] != ONE_SIDED and not moved <= CHECKS.sampled * free(shape, settings.order, start[k]):
                return True
    # a root may have been taken across its branch point by less than the error of the step
    functions.field(mode, t + h, state.c, scratch.image, scratch.doubt)
    finite = True
    for i in range(scratch.doubt.size):
        finite &= abs(scratch.doubt[i]) < math.inf
    return not finite


@inner
def _apart(shapes, count, in_series, now, then, largest):
    """By how much arguments move between two places, in units of what they may, and whether that is worth a look."""
    most = 0.0
    active = False
    for k in range(count):
        shape = shapes[k]
        if shape[6] == ONE_SIDED and not in_series:
            continue
        moved = abs(then[k] - now[k])
        near = min(abs(now[k]), abs(then[k]))
        if shape[6] == CROSSED:
            unit = max(shape[3], shape[4] * max(near - shape[2], shape[5] * largest[k]))
            active |= near < shape[2] or shape[5] > 0.0
        else:
            active = True
            unit = shape[4] * near
            if now[k] == 0.0:
                unit = abs(then[k])
            elif (now[k] > 0.0) != (then[k] > 0.0):
                unit = 0.0
            if shape[6] == AT_SERIES and not in_series:
                unit = max(shape[4] * near, CHECKS.passed * largest[k])
        if moved != 0.0 and not moved <= most * unit:
            most = moved / unit if unit > 0.0 else math.inf
    return most, active


@inlined
def _may_end(through, in_series):
    """Whether an operation ends where its argument is zero: behind zero some go on, for methods that need no series."""
    return through != CROSSED and (in_series or through != ONE_SIDED)


@rare
def has_ended(functions, tables, settings, t, state, scratch):
    """Number of an operation that ends where the state is, to the rounding of its argument; -1 for none."""
    mode, x, c = state.run[0].mode, state.x, state.c
    now, then, doubt, place = scratch.watched[0], scratch.watched[1], scratch.watched[2], scratch.image
    count = tables.steep[mode, 0]
    read(functions, mode, t, c, x, now)
    read(functions, mode, t * (1.0 + CHECKS.nudge), c, x, then)
    for k in range(count):
        doubt[k] = abs(then[k] - now[k])
    for i in range(x.size):
        place[i] = x[i]
    for i in range(x.size):
        place[i] = x[i] * (1.0 + CHECKS.nudge)
        read(functions, mode, t, c, place, then)
        place[i] = x[i]
        for k in range(count):
            doubt[k] += abs(then[k] - now[k])
    most = 8.0 * EPSILON / CHECKS.nudge
    for k in range(count):
        if _may_end(tables.shapes[mode, k, 6], settings.stepping == at.BY_SERIES) and abs(now[k]) <= most * doubt[k]:
            return k
    return -1


@inner
def _fades(shapes, count, in_series, first, then):
    """Whether what may not become zero is no more than rounding has made of its larger values in the same step."""
    found = False
    for k in range(count):
        through = shapes[k, 6]
        if through == AT_ALL or (through != CROSSED and in_series):
            found |= abs(then[k]) <= CHECKS.rounding * first[k]
    return found


def looks(agrees: Any) -> Callable[..., float]:
    """What looks at a step from its start on.

    ``agrees(functions, tables, settings, s, t, state, ws, scratch)``, a compiled function, says whether the polynomials
    in the workspace obey the equations at s.
    """

    @rare
    def look(functions, tables, settings, h, t, state, ws, scratch):  # type: ignore[no-untyped-def]
        """The step h, shortened so that it hides nothing; 0 if any step would."""
        mode, n, c = state.run[0].mode, state.x.size, state.c
        shapes, count = tables.shapes[mode], tables.steep[mode, 0]
        now, then, largest = scratch.watched[0], scratch.watched[1], scratch.watched[2]
        place = scratch.image
        read(functions, mode, t, c, state.x, now)
        for k in range(count):
            largest[k] = abs(now[k])
        for m in range(2):
            watch(functions, mode, t, c, ws, n, h if m == 0 else 0.5 * h, place, then)
            for k in range(count):
                largest[k] = max(largest[k], abs(then[k]))
        first = scratch.watched[3]
        for k in range(count):
            first[k] = abs(now[k])
        s = 0.0
        ds = CHECKS.begin * h
        failed = 0
        for _ in range(CHECKS.places):
            # the last place is the end of the step to the bit
            end = s + ds if s + 1.01 * ds < h else h
            apart = 0.0
            active = False
            if s == 0.0:
                # no place before the first one tells whether an argument has been elsewhere and is back there
                watch(functions, mode, t, c, ws, n, 0.5 * end, place, then)
                apart, active = _apart(shapes, count, settings.stepping == at.BY_SERIES, now, then, largest)
            if apart <= 1.0:
                watch(functions, mode, t, c, ws, n, end, place, then)
                apart, active = _apart(shapes, count, settings.stepping == at.BY_SERIES, now, then, largest)
            if not apart <= 1.0:
                if end - s <= CHECKS.finest * h:
                    return 0.0 if has_ended(functions, tables, settings, t, state, scratch) >= 0 else s
                ds = (end - s) * (max(CHECKS.onward / apart, 0.1) if apart < math.inf else 0.25)
                continue
            if active and not agrees(functions, tables, settings, end, t, state, ws, scratch):
                if s > 0.0:
                    return s
                if failed == CHECKS.shortenings:
                    return end
                failed += 1
                ds = 0.5 * end
                continue
            if end == h or _fades(shapes, count, settings.stepping == at.BY_SERIES, first, then):
                return end
            ds = (end - s) * (min(2.0, CHECKS.onward / apart) if apart > 0.0 else 2.0)
            s = end
            for k in range(count):
                now[k] = then[k]
        return s

    return look


@inner
def guards_agree(functions, tables, settings, part, s, t, state, ws, scratch):
    """Whether guards with steep operations are what their polynomials say, where the states are, to part of a size."""
    mode, n = state.run[0].mode, state.x.size
    for j in range(tables.active[mode, 0]):
        if tables.marks[mode, j] & at.STEEP:
            row = uint64(n + settings.quadratures + j)
            error = functions.guard(mode, j, t + s, state.c, scratch.out[:n], scratch.gradient) - value(ws, row, s)
            moved = late_size(ws, row, s, uint64(1)) * s
            bound = part * moved + CHECKS.rounding * size(ws, row, s)
            if not abs(error) <= bound:
                # near a pole the rounding of the state is what counts
                doubt = functions.guard_error(mode, j, t + s, state.c, scratch.out[:n], scratch.none)
                if not (doubt < math.inf and abs(error) <= bound + CHECKS.doubt * guards.ROUNDING * doubt):
                    return False
    return True


@inner
def rounding_of_rate(functions, tables, i, t, state, x, scratch):
    """Bound of the rounding error of the rate of state or quadrature i: that of its terms, however small it is."""
    mode = state.run[0].mode
    bound = functions.rate_error(mode, tables.active[mode, 0] + i, t, state.c, x, scratch.none)
    return EPSILON * bound if bound < math.inf else 0.0


@rare
def coarsest(functions, tables, tolerance, h, t, state, end, scratch):
    """Sizes of states and quadratures of which the tolerance is what rounding of their rates moves them by in a step
    to ``end``, into ``doubt``.

    No step is more exact, whatever the size of a state: one at zero may have a rate that is rounding and no more.
    """
    for i in range(scratch.doubt.size):
        first = rounding_of_rate(functions, tables, i, t, state, state.x, scratch)
        last = rounding_of_rate(functions, tables, i, t + h, state, end, scratch)
        scratch.doubt[i] = CHECKS.doubt * max(first, last) * h / tolerance


@rare
def doubt_of_rates(functions, tables, s, t, state, scratch):
    """What rounding of the state, of time and of their own terms makes of the rates at s, into ``doubt``; place and
    rates are there.

    Every state is moved by another part of itself, for those of which a difference is small may be rounded alike.
    """
    mode, n, place = state.run[0].mode, state.x.size, scratch.image
    part = 4.0 * EPSILON
    for i in range(n):
        place[i] = scratch.out[i] * (1.0 + part)
        part = -part - math.copysign(EPSILON, part)
    functions.field(mode, (t + s) * (1.0 + 4.0 * EPSILON), state.c, place, scratch.doubt)
    for i in range(scratch.doubt.size):
        own = rounding_of_rate(functions, tables, i, t + s, state, scratch.out, scratch)
        scratch.doubt[i] = max(abs(scratch.doubt[i] - scratch.before[i]), own)


@inner
def tangent_defect(functions, degree, v, s, t, state, ws, scratch):
    """Rate of tangent v at s, into ``before``, and that of its polynomial, into ``after``; ``jump`` is the tangent."""
    n, direction = state.x.size, scratch.jump
    values_and_rates(ws, first_row(ws, state.vectors, v), n, degree, s, direction, scratch.after[:n])
    functions.variation(state.run[0].mode, t + s, state.c, scratch.out[:n], direction, scratch.before[:n])


@rare
def doubt_of_tangent(functions, s, t, state, scratch):
    """What rounding of the state and of time makes of the rate of a tangent, into ``doubt``; tangent and rate are
    there."""
    n, place, rate, doubt = state.x.size, scratch.image, scratch.before, scratch.doubt
    for i in range(n):
        place[i] = scratch.out[i] * (1.0 + (4.0 + i) * (1 - 2 * (i % 2)) * EPSILON)
    functions.variation(state.run[0].mode, (t + s) * (1.0 + 4.0 * EPSILON), state.c, place, scratch.jump, doubt[:n])
    for i in range(n):
        doubt[i] = abs(doubt[i] - rate[i])


@inner
def tangents_agree(functions, degree, allowed, noise, s, t, state, ws, scratch):
    """Whether the polynomials of tangents obey the variational equation at s, but for the noise of their rates."""
    scale, n = state.span, state.x.size
    direction, rate, slope = scratch.jump, scratch.before, scratch.after
    widest = 0.0
    for i in range(n):
        widest = max(widest, scale[i])
    for v in range(state.run[0].live):
        tangent_defect(functions, degree, v, s, t, state, ws, scratch)
        length = 0.0
        off = 0.0
        for i in range(n):
            width = scale[i] if scale[i] > 0.0 else widest if widest > 0.0 else 1.0
            length = max(length, abs(direction[i]) / width)
            part = (abs(slope[i] - rate[i]) - noise * abs(rate[i])) * s / width
            off = part if not part <= off else off
        if not off <= allowed * length:
            doubt_of_tangent(functions, s, t, state, scratch)
            for i in range(n):
                width = scale[i] if scale[i] > 0.0 else widest if widest > 0.0 else 1.0
                part = (abs(slope[i] - rate[i]) - CHECKS.doubt * scratch.doubt[i] - noise * abs(rate[i])) * s / width
                if not part <= allowed * length:
                    return False
    return True


@inner
def series_agree(functions, tables, settings, s, t, state, ws, scratch):
    """Whether series of states, integrals, tangents and steep guards obey their equations at s."""
    place, rate, slope = scratch.out, scratch.before, scratch.after
    values_and_rates(ws, 0, place.size, settings.order, s, place, slope)
    functions.field(state.run[0].mode, t + s, state.c, place, rate)
    told = False
    allowed = max(CHECKS.defect * settings.tolerance, CHECKS.rounding)
    for i in range(place.size):
        bound = CHECKS.rounding * abs(rate[i]) * s
        if i < state.x.size:
            bound += allowed * state.scale[i]
        else:
            bound += CHECKS.defect * settings.tolerance * late_size(ws, uint64(i), s, uint64(1)) * s
        off = abs(slope[i] - rate[i]) * s
        if not off <= bound:
            if not told:
                doubt_of_rates(functions, tables, s, t, state, scratch)
                told = True
            if not off <= bound + CHECKS.doubt * scratch.doubt[i] * s:
                return False
    if not guards_agree(functions, tables, settings, CHECKS.defect * settings.tolerance, s, t, state, ws, scratch):
        return False
    return tangents_agree(functions, settings.order, allowed, CHECKS.rounding, s, t, state, ws, scratch)


look_along_series = looks(series_agree)


@inner
def dense_defect(functions, degree, s, t, state, ws, scratch):
    """Rates of states and integrals, into ``before``, and of their polynomials, into ``after``; ``out`` is where."""
    values_and_rates(ws, 0, scratch.out.size, degree, s, scratch.out, scratch.after)
    functions.field(state.run[0].mode, t + s, state.c, scratch.out, scratch.before)


@inner
def dense_agrees(functions, tables, settings, first, allowed, s, t, state, scratch):
    """Whether the defects that are there are allowed parts of sizes, of states and integrals from the first on.

    And of states before it that have no size yet.
    """
    rate, slope = scratch.before, scratch.after
    for i in range(rate.size):
        if i < first and state.scale[i] > 0.0:
            continue
        bound = allowed * state.scale[i] + settings.dense_noise * abs(rate[i]) * s
        off = abs(slope[i] - rate[i]) * s
        if not off <= bound:
            doubt_of_rates(functions, tables, s, t, state, scratch)
            if not off <= bound + CHECKS.doubt * scratch.doubt[i] * s:
                return False
    return True


@rare
def proven(functions, tables, settings, h, t, state, ws, scratch):
    """The step h, shortened until the series obey the equations at its end.

    The last coefficients may lie in a gap of the series (the solution of x'' = -x**3 from x = 0 has every fourth one
    only) and promise a step far beyond its radius; earlier ones tell that, and the defect how far it goes.
    """
    order, scale = settings.order, state.scale
    for i in range(state.x.size):
        # where one of the last two is there it tells as much, and more of a state that begins with next to nothing
        if ws[i, uint64(order)] != 0.0 or ws[i, uint64(order - 1)] != 0.0:
            continue
        for k in range(order - CHECKS.earlier, order - 1):
            if ws[i, uint64(k)] != 0.0 and scale[i] > 0.0:
                h = min(h, settings.reach * (scale[i] / abs(ws[i, uint64(k)])) ** (1.0 / k))
    whole = h
    for _ in range(CHECKS.shortenings):
        if series_agree(functions, tables, settings, h, t, state, ws, scratch):
            return h
        h *= 0.6
    return whole


@inner
def _ends(now, then):
    """Whether a value that becomes another, finite one soon is zero, or is no number, on the way."""
    return math.isnan(now) or now == 0.0 or not (abs(then - now) < abs(now) or abs(then) == math.inf)


@inner
def _runs_away(x, scale, moved, later):
    """Whether a state at its largest soon moves on by more than itself, by ``moved``, and faster then, by ``later``."""
    return x * moved > 0.0 and 0.5 * scale <= abs(x) < abs(moved) and 2.0 * abs(moved) < abs(later)


@unit(Tuple((int64, int64)))
def ending(functions, tables, settings, h, t, state, scratch):
    """What a run ends with whose step h has no length or is no number: (outcome, guard).

    Where a steep operation ends at the state, the run counts as blocked by it. A guard that ends there, too, and
    is met from its side, fires: then it is its event that comes next, and the outcome is to be left alone.
    """
    run, x = state.run[0], state.x
    mode, n = run.mode, x.size
    now, then, place, rate = scratch.watched[0], scratch.watched[1], scratch.image, scratch.before
    soon = CHECKS.ahead * (run.longest if run.longest > 0.0 else run.period)
    functions.field(mode, t, state.c, x, rate)
    for i in range(n):
        rate[i] = soon * rate[i] if abs(rate[i]) < math.inf else 0.0
    outcome = at.STEP_UNDERFLOW if h == h else at.NONFINITE
    run.blocked = has_ended(functions, tables, settings, t, state, scratch)
    if run.blocked >= 0:
        outcome = at.SINGULAR
    read(functions, mode, t, state.c, x, now)
    for i in range(n):
        place[i] = x[i] + rate[i]
    functions.field(mode, t + soon, state.c, place, scratch.doubt)
    for i in range(scratch.doubt.size):
        later = soon * scratch.doubt[i]
        # whether a series overflows before its step is too short is a question of its order
        if not abs(later) < math.inf or (i < n and _runs_away(x[i], state.scale[i], rate[i], later)):
            outcome = at.NONFINITE if outcome == at.STEP_UNDERFLOW else outcome
    for j in range(tables.active[mode, 0]):
        if not abs(functions.guard(mode, j, t + soon, state.c, place, scratch.gradient)) < math.inf:
            outcome = at.NONFINITE if outcome == at.STEP_UNDERFLOW else outcome
    read(functions, mode, t + soon, state.c, place, then)
    for k in range(tables.steep[mode, 0]):
        may_end = _may_end(tables.shapes[mode, k, 6], settings.stepping == at.BY_SERIES)
        if may_end and outcome != at.SINGULAR and _ends(now[k], then[k]):
            outcome = at.SINGULAR
            run.blocked = k
    if outcome != at.SINGULAR:
        return outcome, -1
    for j in range(tables.active[mode, 0]):
        side = state.sides[tables.keys[mode, j]]
        direction = tables.active[mode, 1 + j]
        if abs(side) == 1 and (direction == 0 or direction == -side):
            here = functions.guard(mode, j, t, state.c, x, scratch.gradient)
            # by its slope, which a pole of the guard itself leads away from zero
            change = scratch.gradient[n] * soon
            for i in range(n):
                change += scratch.gradient[i] * rate[i]
            leads = change * side < 0.0 or (here == 0.0 and change == 0.0)
            if abs(here) < math.inf and leads and _ends(here, here + change):
                run.blocked = -1
                run.turning = 0
                # steps that end at a branch point say nothing of those that follow its event
                run.next_step = 0.0
                return outcome, j
    return outcome, -1
