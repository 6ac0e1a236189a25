"""Adaptive Taylor method of variable order (Jorba and Zou 2005, doi:10.1080/10586458.2005.10128904)."""

import math

from chaosdrill.codegen.kinds import float64, uint64
from chaosdrill.engine import scales
from chaosdrill.engine.checked import first_row, look_along_series, proven, shows_all
from chaosdrill.engine.jit import RECIPROCAL, inlined, rare
from chaosdrill.engine.lanes import (
    as_wide,
    chosen,
    exponent,
    floor,
    lane_of,
    larger,
    magnitude,
    mantissa,
    power_of_two,
    smaller,
    some,
    width,
    with_lane,
)
from chaosdrill.engine.layout import AFFINE, STEEP, STILL, TIMED
from chaosdrill.engine.polynomial import late_size, power, size, value
from chaosdrill.engine.records import unit
from chaosdrill.engine.scales import SMALLEST
from chaosdrill.engine.tuning import GUARDS, SERIES

METHOD = {
    "summary": "adaptive Taylor series of variable order; events are roots of the guards' polynomials",
    "cites": ("jorba2005", "farouki2012"),
    "series": True,
    "lanes": True,
}


@inlined
def _log2(x):
    """Binary logarithm of a positive number, or of lanes, to 1e-3, from its bits."""
    m = mantissa(x)
    return exponent(x) + (-2.153620718 + m * (3.047884161 + m * (-1.051874866 + m * 0.158248848)))


@inlined
def _exp2(y):
    """2**y to 2e-4."""
    whole = floor(y)
    r = y - whole
    return power_of_two(whole) * (1.0 + r * (0.695502 + r * (0.226170 + r * 0.0780245)))


@inlined
def radius(last, last_but_one, order):
    """Radius of convergence that the last two coefficients show, of one trajectory or of lanes.

    Where both are zero it is as long as its power of the order may be and not overflow.
    """
    a = _log2(larger(last, SMALLEST)) * RECIPROCAL[uint64(order)]
    b = _log2(larger(last_but_one, SMALLEST)) * RECIPROCAL[uint64(order - 1)]
    return _exp2(-larger(a, b))


@inlined
def fill(functions, mode, live, settings, t, c, x, vectors, ws):
    """Taylor coefficients of states, integrals, guards and live tangents, into the workspace."""
    order = settings.order
    functions.jet(mode, order, t, c, x, ws)
    if live > 0:
        if settings.own_jacobian == 1:
            functions.jacobian_jet(mode, order, c, ws)
        for v in range(0, live, 2):
            second = vectors[min(v + 1, live - 1)]
            functions.tangent(mode, order, c, vectors[v], second, ws, first_row(ws, vectors, v))


@rare
def _begun(g, begins, order, reach, longest, row):
    """Sizes of motions that begin in this step, by their series; 0 of others. ``row`` is scratch for one series.

    What rests has no late terms either, in whatever gap of them the last two lie; to look at these in the code of every
    step costs runs with tangents a twentieth.
    """
    found = as_wide(0.0, begins)
    for lane in range(width(found)):
        if lane_of(begins, lane) > 0.0:
            late = abs(lane_of(g[1], lane))
            for k in range(order + 1):
                row[k] = lane_of(g[k], lane)
            for k in range(order - SERIES.late + 1, order + 1):
                late = max(late, abs(row[k]))
            if late > 0.0:
                found = with_lane(found, lane, scales.of_series(row, order, reach, lane_of(longest, lane)))
    return found


@inlined
def _over(a, b, size):
    return a / size, b / size


@inlined
def length(over, series, n, live, first, settings, period, scale, weights, metric, row):
    """The step that keeps states and tangents within tolerance; NaN where the series of a state holds one.

    The last term is to be a part of the tolerance: for states relative to their scales, which are the sizes that they
    have had of late, for a tangent to its length in these scales.

    ``over(a, b, size)`` divides the first two by the third; of lanes that is one division and two products. ``series``
    has the coefficients of the states, and from row ``first`` on those of the tangents; ``scale``, ``weights`` and
    ``metric`` have of each state its size, one over it, and that where all have one, no more than it was before, as
    `scales.limit` has it; ``row`` is scratch for one series.
    All are of one run, or of lanes.
    """
    order, reach = settings.order, settings.reach
    least = scales.finest(settings.tolerance)
    nothing = as_wide(0.0, period)
    last = last_but_one = whole = nothing
    for i in range(n):
        g = series[i]
        here = scales.brought(scale[i], g[0], least)
        begins = scales.has_none(here, g[1], period)
        if some(begins):
            here = larger(here, _begun(g, chosen(begins, 1.0, 0.0), order, reach, period, row))
        scale[i] = here
        weight = chosen(here > SMALLEST, 1.0 / here, 0.0)
        weights[i] = weight
        whole += g[order]
        last = larger(last, magnitude(g[order]) * weight)
        last_but_one = larger(last_but_one, magnitude(g[order - 1]) * weight)
    if live > 0:
        widest = nothing
        for i in range(n):
            widest = larger(widest, chosen(weights[i] > 0.0, scale[i], 0.0))
        common = 1.0 / chosen(widest > 0.0, widest, 1.0)
        for i in range(n):
            metric[i] = smaller(metric[i], chosen(weights[i] > 0.0, weights[i], common))
        for v in range(live):
            size = a = b = nothing
            for i in range(n):
                g = series[first + v * n + i]
                size = larger(size, magnitude(g[0]) * metric[i])
                a = larger(a, magnitude(g[order]) * metric[i])
                b = larger(b, magnitude(g[order - 1]) * metric[i])
            a, b = over(a, b, size)
            last = larger(last, a)
            last_but_one = larger(last_but_one, b)
    h = smaller(radius(last, last_but_one, order) * reach, period)
    return chosen(magnitude(whole) < math.inf, h, math.nan)


@inlined
def follow(series, n, scale, h):
    """Let sizes follow a step of length h."""
    for i in range(n):
        scale[i] = scales.followed(scale[i], series[i][0], series[i][1], h)


@inlined
def _has_no_gap(series, n, order, radius, weights):
    """Whether the last two terms of the states, which are 1 at most at the radius, follow on none that are far larger.

    Else the radius may be wrong. The three pairs of terms before the last are compared, each with the one after it.
    """
    early = middle = late = as_wide(0.0, radius)
    k = uint64(order - 7)
    for i in range(n):
        g = series[i]
        early = larger(early, weights[i] * larger(magnitude(g[k]), magnitude(g[k + 1]) * radius))
        middle = larger(middle, weights[i] * larger(magnitude(g[k + 2]), magnitude(g[k + 3]) * radius))
        late = larger(late, weights[i] * larger(magnitude(g[k + 4]), magnitude(g[k + 5]) * radius))
    square = radius * radius
    first = power(radius, order - 7)
    early *= first
    middle *= first * square
    late *= first * square * square
    gap = SERIES.gap
    return (late <= gap) & (middle <= gap * larger(late, 1.0)) & (early <= gap * larger(middle, 1.0))


@inlined
def _is_held(i, marks):
    """Whether the last terms of integral or guard i, counted from the first integral, bound the step.

    Those of an affine guard are as small as the states' are.
    """
    return i < 0 or marks[i] & (AFFINE | STILL) == 0


@inlined
def _excess(late_size, series, n, count, marks, h, settings):
    """By how much last terms of integrals and guards, to which series of states lead, exceed a part of what they move.

    0 if they do not, 1 if a term is no number.
    """
    order, quadratures = settings.order, settings.quadratures
    before = power(h, order - 1)
    excess = sizes = as_wide(0.0, h)
    for i in range(quadratures + count):
        if _is_held(i - quadratures, marks):
            g = series[n + i]
            moves = late_size(series, uint64(n + i), h, uint64(1)) * h
            part = as_wide(settings.tolerance, h)
            if i >= quadratures and marks[i - quadratures] & TIMED:
                # what stays clear of zero has no root to be told
                part = chosen(magnitude(g[0]) > moves, part, smaller(part, GUARDS.in_time))
            allowed = part * moves + SMALLEST
            ends = larger(magnitude(g[order]) * (before * h), magnitude(g[order - 1]) * (before * settings.reach))
            excess = larger(excess, ends - allowed)
            sizes += allowed
    return chosen(sizes < math.inf, excess, 1.0)


@inlined
def _is_finite(ws, i, order):
    total = 0.0
    for k in range(order + 1):
        total += abs(ws[i, k])
    return total < math.inf


@inlined
def _has_values(series, first, marks, count, h):
    """Whether all guards with steep operations are numbers where the step begins."""
    missing = as_wide(0.0, h)
    for j in range(count):
        if marks[j] & STEEP:
            missing = larger(missing, chosen(magnitude(series[first + j][0]) < math.inf, 0.0, 1.0))
    return missing <= 0.0


@inlined
def doubts(late_size, size, series, n, tables, settings, mode, h, weights):
    """Whether a step of length h is what it seems: by its terms, its integrals and guards, its steep operations.

    ``late_size`` and ``size`` are those of polynomials, in rows of arrays or of lanes. What is in doubt is left to
    `settled`.
    """
    count, marks = tables.active[mode, 0], tables.marks[mode]
    sure = _has_no_gap(series, n, settings.order, h / settings.reach, weights)
    held = _excess(late_size, series, n, count, marks, h, settings) <= 0.0
    plain = h == h
    if tables.steep[mode, 0] > 0:
        plain = shows_all(late_size, size, tables, settings, mode, h, series)
        plain = plain & _has_values(series, n + settings.quadratures, marks, count, h)
    return sure, held, plain


@unit(float64)
def settled(functions, tables, settings, h, t, state, scratch, sure, plain):
    """The step h of one run, of which `doubts` has not been sure, shortened until it counts; no number if none does.

    Integrals and guards are as exact as the states then. A term of theirs that overflows is in no step.
    """
    mode, n, ws = state.run[0].mode, state.x.size, scratch.workspace
    count, marks = tables.active[mode, 0], tables.marks[mode]
    if tables.steep[mode, 0] > 0 and not _has_values(ws, n + settings.quadratures, marks, count, h):
        return math.nan
    if not sure:
        h = proven(functions, tables, settings, h, t, state, ws, scratch)
    if not plain:
        h = look_along_series(functions, tables, settings, h, t, state, ws, scratch)
    if _excess(late_size, ws, n, count, marks, h, settings) <= 0.0:
        return h
    for i in range(settings.quadratures + count):
        if _is_held(i - settings.quadratures, marks) and not _is_finite(ws, n + i, settings.order):
            return math.nan
    # a guard of time may be as much faster than the states as it likes
    shorter = h
    for _ in range(100):
        shorter *= 0.7
        if _excess(late_size, ws, n, count, marks, shorter, settings) <= 0.0:
            return shorter
    return h


@inlined
def expand(functions, tables, settings, t, state, ws, scratch):
    """Taylor coefficients at the present state; returns the length of the step."""
    run, n = state.run[0], state.x.size
    mode, live, weights = run.mode, run.live, scratch.weights
    fill(functions, mode, live, settings, t, state.c, state.x, state.vectors, ws)
    run.evaluations += settings.order
    first = first_row(ws, state.vectors, 0)
    metric, row = scratch.metric, scratch.polynomial
    scale, span = state.scale, state.span
    scales.renew(tables, mode, n, state.x, scale, span)
    scales.limit(tables, n, span, run.period, metric)
    h = length(_over, ws, n, live, first, settings, run.period, scale, weights, metric, row)
    if h != h:
        return h
    follow(ws, n, scale, h)
    sure, held, plain = doubts(late_size, size, ws, n, tables, settings, mode, h, weights)
    if not (sure & held & plain):
        h = settled(functions, tables, settings, h, t, state, scratch, sure, plain)
    return h


@inlined
def evaluate_vectors(ws, s, live, vectors):
    """Live tangents at s, in place."""
    n = vectors.shape[1]
    for v in range(live):
        row = first_row(ws, vectors, v)
        for i in range(n):
            vectors[v, i] = value(ws, uint64(row + i), s)
