"""What a root of a guard's polynomial is to the errors of that: none, one of its own, or several that are one."""

import math

from chaosdrill.codegen.kinds import float64, uint64
from chaosdrill.codegen.layout import EPSILON, ROUNDING
from chaosdrill.engine import layout as at
from chaosdrill.engine.guard_errors import (
    POWER_NOISE,
    VALUE_NOISE,
    cut_off,
    is_told,
    last_terms,
    left_out,
    slope_and_bend,
)
from chaosdrill.engine.jit import inlined, inner, rare, series
from chaosdrill.engine.lanes import exponent, power_of_two
from chaosdrill.engine.polynomial import derivative, size, value, values
from chaosdrill.engine.radau_tables import DEGREE
from chaosdrill.engine.records import unit
from chaosdrill.engine.roots import first_crossing
from chaosdrill.engine.tuning import GUARDS

_NOISE = VALUE_NOISE * ROUNDING
"""Part of the sizes of its terms by which a guard moves its polynomial."""


@inlined
def unit_of(largest):
    """The power of two by which numbers up to ``largest`` become ones of about 1; 1 if that is 0."""
    return power_of_two(-exponent(largest)) if largest > 0.0 else 1.0


@series
def _third(g, n, s):
    """Third derivative of a polynomial at s."""
    f = 0.0
    for m in range(n - 2):
        k = uint64(n - m)
        f = f * s + g[k] * float(k * (k - 1) * (k - 2))
    return f


@rare
def on_the_clock(functions, run, c, j, s, h, place, gradient):
    """A root near s of a guard of time alone, by Newton steps on the guard itself, as exact as time is known.

    Where a step leads no nearer, as at a multiple root, the value is no more than its error.
    """
    found = best = s
    least = math.inf
    # a root of third order is approached by a third of the way at a time
    for _ in range(100):
        t = (run.origin + run.whole) + (run.rest + run.time + found)
        # what the sum has lost
        late = ((run.origin + run.whole) - t) + (run.rest + run.time + found)
        off = functions.guard(run.mode, j, t, c, place, gradient)
        slope = gradient[place.size]
        off += slope * late
        if not abs(off) < least:
            break
        least = abs(off)
        best = found
        step = off / slope if slope != 0.0 else math.inf
        if not abs(found - step - s) <= 1e-3 * h:
            break
        found -= step
        if abs(step) <= 4.0 * EPSILON * max(abs(t), h):
            best = found
            break
    return min(max(best, 0.0), h)


@inner
def _slope_at(functions, tables, state, ws, j, s, t, scratch):
    """Rate of guard j at s by the equations, and the bound of its rounding."""
    mode, n = state.run[0].mode, state.x.size
    place, rates, gradient = scratch.before[:n], scratch.doubt, scratch.gradient
    values(ws, n, s, place)
    functions.field(mode, t + s, state.c, place, rates)
    functions.guard(mode, j, t + s, state.c, place, gradient)
    slope = gradient[n]
    for i in range(n):
        slope += gradient[i] * rates[i]
    return slope, ROUNDING * functions.rate_error(mode, j, t + s, state.c, place, scratch.none)


@rare
def _nearer(functions, state, ws, i, j, s, side, doubt, t, scratch):
    """When, before a root, a guard is clear of its doubt and rounds to far less than that; or -1."""
    mode, place = state.run[0].mode, scratch.before[: state.x.size]
    away = EPSILON * s
    while away < s and not side * value(ws, uint64(i), s - away) > doubt:
        away *= 2.0
    away *= GUARDS.clear
    if not away < s:
        return -1.0
    values(ws, place.size, s - away, place)
    # states are rounded there in parts of what they are the sum of
    for a in range(place.size):
        scratch.doubt[a] = size(ws, uint64(a), s - away)
    error = functions.guard_error(mode, j, t + s - away, state.c, place, scratch.doubt)
    error += away * functions.rate_error(mode, j, t + s - away, state.c, place, scratch.doubt)
    return s - away if GUARDS.finer * ROUNDING * error < doubt else -1.0


@rare
def _is_crossed(functions, settings, state, ws, j, s, bend, steep, side, h, t, scratch):
    """Whether a guard itself is beyond zero by more than its states may err, where its polynomial turns next to s."""
    summit = min(max(s - steep / bend, 0.0), h) if bend != 0.0 else s
    place = scratch.before[: state.x.size]
    values(ws, place.size, summit, place)
    beyond = -side * functions.guard(state.run[0].mode, j, t + summit, state.c, place, scratch.gradient)
    off = ROUNDING * functions.guard_error(state.run[0].mode, j, t + summit, state.c, place, scratch.none)
    for a in range(place.size):
        off += settings.tolerance * abs(scratch.gradient[a]) * state.scale[a]
    return beyond > off


@inner
def _multiple(functions, tables, settings, state, ws, i, j, s, side, h, t, scratch):
    """What a root at s, approached from a side, is to the guard's error: (when it is clear of that, root or -1).

    The time is -1 for a simple root. For a root of even order, which is no crossing, the root is -1; one of odd order
    is where the second derivative vanishes, which is known far better than where the value does. Of roots that a series
    from nearby tells far better, as those of a product, the root is -1, too, and the time is where that begins.
    """
    n, mode = settings.order, state.run[0].mode
    marks = tables.marks[mode, j]
    whole = size(ws, uint64(i), h)
    left = 0.0
    by_series = settings.stepping == at.BY_SERIES
    if by_series and marks & at.AFFINE == 0:
        left = cut_off(ws[i], n, s)
    elif marks & at.AFFINE == 0:
        left = left_out(functions, tables, settings, state, ws, i, j, h, t, scratch)
        if marks & at.TIMED == 0:
            # value and slope at the start of the step are known
            left *= min(1.0, POWER_NOISE[2] * (2.0 * s / state.run[0].tried) ** 2)
    error = functions.guard_error(mode, j, t, state.c, state.x, scratch.none)
    # of its terms, which are rounded where the step begins
    off = ROUNDING * (error + s * functions.rate_error(mode, j, t, state.c, state.x, scratch.none))
    # what is squared is taken in units of about the guard's size, whatever it is measured in
    unit = unit_of(whole)
    margin = (1e-9 * whole + left + 100.0 * off) * unit
    # no second derivative is larger than that of the last term, were it all of the guard
    if (derivative(ws, uint64(i), s) * unit * h) ** 2 > 2.0 * margin * n * (n - 1) * (whole * unit):
        return -1.0, s
    steep, bend = slope_and_bend(ws[i], n, s)
    steep, bend = steep * unit, bend * unit
    if steep * steep > 2.0 * margin * abs(bend):
        return -1.0, s
    place = scratch.before[: state.x.size]
    values(ws, place.size, s, place)
    own = ROUNDING * functions.guard_error(mode, j, t + s, state.c, place, scratch.none)
    begun, off = off, max(off, own)
    slack = ROUNDING * functions.rate_error(mode, j, t + s, state.c, place, scratch.none) * unit
    doubt = (off + 2.0 * EPSILON * size(ws, uint64(i), s) + left) * unit
    told = abs(steep) - slack
    simple = told > 0.0 and told * told > 2.0 * doubt * abs(bend)
    if (
        (by_series or left == 0.0)
        and GUARDS.finer * own < begun
        and not (simple and doubt <= settings.tolerance * h * told)
    ):
        nearer = _nearer(functions, state, ws, i, j, s, side, doubt / unit, t, scratch)
        if nearer > 0.0:
            return nearer, -1.0
    if simple or (
        by_series and left > 0.0 and _is_crossed(functions, settings, state, ws, j, s, bend, steep, side, h, t, scratch)
    ):
        return -1.0, s
    if bend != 0.0:
        # by as much as that the value is in doubt where the rate, with its own error, may vanish
        doubt += slack * (abs(steep) + slack) / abs(bend)
    third = _third(ws[i], n, s) * unit
    reach = math.inf
    if bend != 0.0:
        summit = steep / bend
        reach = abs(summit) + 2.0 * math.sqrt(summit * summit + 2.0 * doubt / abs(bend))
    if third != 0.0:
        reach = min(reach, 2.0 * abs(bend / third) + 2.0 * (6.0 * doubt / abs(third)) ** (1.0 / 3.0))
    reach = max(reach, 10.0 * GUARDS.near * h)
    for _ in range(60):
        clear = min(s + reach, h)
        room = off
        if left > 0.0 or marks & at.TIMED:
            # what the interpolation leaves out may be far more than the guard there: a step would end across it
            values(ws, place.size, clear, place)
            across = -side * functions.guard(mode, j, t + clear, state.c, place, scratch.gradient)
            for a in range(place.size):
                room += settings.tolerance * abs(scratch.gradient[a]) * state.scale[a]
        else:
            room = doubt / unit
            across = -side * value(ws, uint64(i), clear)
        if not math.isfinite(across):
            return -1.0, s
        if abs(across) > room or clear == h:
            break
        reach *= 2.0
    if not across > room:
        return clear, -1.0
    inflection = s
    for _ in range(3):
        if third == 0.0:
            return clear, s
        inflection -= bend / third
        _, bend = slope_and_bend(ws[i], n, inflection)
        third = _third(ws[i], n, inflection)
    # a motion that has just left the surface does not meet it before the root that is seen
    if not 0.0 < inflection < clear or abs(value(ws, uint64(i), inflection)) * unit > doubt:
        return clear, s
    slope, error = _slope_at(functions, tables, state, ws, j, inflection, t, scratch)
    # where it leads back, beyond its error, three roots are apart
    return (-1.0, s) if slope * side > error else (clear, inflection)


@unit(float64)
def told_before(functions, tables, settings, state, j, root, order, side, h, t, scratch):
    """Until when the polynomial of guard j, on a side, tells of its roots what a step from there would.

    That is up to where it comes as near to zero as it may be off by, if the guard itself rounds to far less there; not
    before a simple root, whose time is given, else -1. An interpolation may be off by as much anywhere, but for value
    and slope at the start of the step; a series by parts of its terms. One in time alone has its own clock.
    """
    ws, run, n = scratch.workspace, state.run[0], settings.order - order
    i = uint64(state.x.size + settings.quadratures + j)
    g, least = ws[i], scratch.shifted
    by_series = settings.stepping == at.BY_SERIES
    if tables.marks[run.mode, j] & at.TIMED and not by_series:
        return h
    for k in range(n + 1):
        least[k] = g[order + k]
        if by_series:
            least[k] -= side * _NOISE * abs(least[k])
    off = 0.0
    known = 0
    if not by_series:
        off = left_out(functions, tables, settings, state, ws, i, j, h, t, scratch)
        if order == 1 or not side * g[0] > off:
            known, off = 2, POWER_NOISE[2] * off / run.tried**2
        least[known - order] -= side * off
    s = first_crossing(least, 0, n, h, side < 0, scratch.polynomial, scratch.stack, scratch.ends)
    if not GUARDS.nearest * max(h, run.longest) < s < h:
        return h
    off = _NOISE * size(ws, i, s) if by_series else off * s**known
    if root >= 0.0:
        slope, bend = slope_and_bend(g, settings.order, root)
        if (root - s) * abs(slope) <= 2.0 * off and slope * slope > 4.0 * off * abs(bend):
            return h
    place = scratch.before[: state.x.size]
    values(ws, place.size, s, place)
    own = _NOISE * functions.guard_error(run.mode, j, t + s, state.c, place, scratch.none)
    return s if GUARDS.finer * own < off else h


@inlined
def degree_of(settings, marks):
    """Degree of a guard's polynomial; 0 of what is interpolated, whose last terms are those of its rounding."""
    return settings.order if settings.stepping == at.BY_SERIES else DEGREE if marks & at.AFFINE else 0


@inlined
def settled(functions, tables, settings, state, ws, i, j, s, side, h, t, scratch):
    """A root at s of guard j, approached from a side: (its time, -1 if it is no root; when it is clear; where to end).

    The step ends before a root of which the polynomial does not tell, and behind one that is only touched.
    """
    marks = tables.marks[state.run[0].mode, j]
    degree = degree_of(settings, marks)
    clear = -1.0
    if s > 0.0 and degree > 0:
        last, before = last_terms(ws[i], degree, s)
        if not is_told(last, before, s * derivative(ws, uint64(i), s)):
            return -1.0, clear, min(h, 0.5 * s)
    if s > 0.0:
        clear, s = _multiple(functions, tables, settings, state, ws, i, j, s, side, h, t, scratch)
        if s < 0.0:
            h = min(h, clear)
    if s > 0.0 and marks & at.TIMED:
        s = on_the_clock(functions, state.run[0], state.c, j, s, h, state.x, scratch.gradient)
    return s, clear, h
