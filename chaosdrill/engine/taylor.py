"""Adaptive Taylor method of variable order (Jorba and Zou 2005, doi:10.1080/10586458.2005.10128904)."""

import math

from numba import uint64

from chaosdrill.engine.jit import RECIPROCAL, inlined, inner, rare, series
from chaosdrill.engine.lanes import exponent, floor, larger, mantissa, power_of_two
from chaosdrill.engine.layout import AFFINE, UNPROVEN
from chaosdrill.engine.polynomial import late_size, size, value

METHOD = {
    "summary": "adaptive Taylor series of variable order; events are roots of the guards' polynomials",
    "cites": ("jorba2005", "farouki2012"),
    "series": True,
}

SMALLEST = 1e-290

LONGEST = 1e9
"""Longest step, so that no power of it overflows."""

GAP = 10.0
"""Factor between the sizes of two terms and the next two, at the radius of convergence, that raises suspicion; about 5
in the series of exp."""

DEFECT = 20.0
"""Defect at the end of a step, times its length, in units of the tolerance, above which the step is shortened."""

SHORTENINGS = 16
"""Times that a step is shortened for it; what does not change then is round-off, as about a point at rest."""

FADE = 0.98
"""What is left of a state's scale after a step: it follows the motion within some hundred steps."""

SLOW = 1000.0
"""Steps' motion up to which the size of a state counts as its scale: what moves on for ever has no size."""

EPSILON = 2.220446049250313e-16


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
    """Radius of convergence that the last two coefficients show, of one trajectory or of lanes."""
    a = _log2(larger(last, SMALLEST)) * RECIPROCAL[uint64(order)]
    b = _log2(larger(last_but_one, SMALLEST)) * RECIPROCAL[uint64(order - 1)]
    return _exp2(-larger(a, b))


@inner
def _first_row(ws, vectors, v):
    """Row from which the series of tangent v stand."""
    m, n = vectors.shape
    return ws.shape[0] - (m + m % 2) * n + v * n


@series
def _values_and_rates(ws, count, order, s, values, rates):
    """Polynomials of the first ``count`` rows and their derivatives at s."""
    i = 0
    while i < count:
        second = min(i + 1, count - 1)
        third = min(i + 2, count - 1)
        a = ws[i, order]
        b = ws[second, order]
        c = ws[third, order]
        da = 0.0
        db = 0.0
        dc = 0.0
        for j in range(order):
            k = uint64(order - 1 - j)
            da = da * s + a
            db = db * s + b
            dc = dc * s + c
            a = a * s + ws[i, k]
            b = b * s + ws[second, k]
            c = c * s + ws[third, k]
        values[i] = a
        values[second] = b
        values[third] = c
        rates[i] = da
        rates[second] = db
        rates[third] = dc
        i += 3


@rare
def own_scale(g, order, reach):
    """Scale of a motion of which nothing is known but its series: what it moves in a step of its own."""
    first = 1
    while first < order and g[first] == 0.0:
        first += 1
    if not (first < order - 1 and abs(g[first]) > SMALLEST):
        return 0.0
    a = abs(g[order] / g[first]) ** (1.0 / (order - first))
    b = abs(g[order - 1] / g[first]) ** (1.0 / (order - 1 - first))
    if not max(a, b) > 0.0:
        return 0.0
    h = reach / max(a, b)
    return max(abs(g[1]) * h, abs(g[2]) * h * h, abs(g[3]) * h * h * h)


@inlined
def power_of_four(x, k):
    """x**(4 k)"""
    fourth = (x * x) * (x * x)
    power = 1.0
    for _ in range(k):
        power *= fourth
    return power


@inlined
def _has_gap(ws, n, order, radius, weights):
    """Whether the last two terms of the states, which are 1 at most at the radius, follow on far larger ones.

    Then the radius may be wrong. The three pairs of terms before the last are compared, each with the one after it.
    """
    early = 0.0
    middle = 0.0
    late = 0.0
    k = uint64(order - 7)
    for i in range(n):
        early = max(early, weights[i] * max(abs(ws[i, k]), abs(ws[i, k + 1]) * radius))
        middle = max(middle, weights[i] * max(abs(ws[i, k + 2]), abs(ws[i, k + 3]) * radius))
        late = max(late, weights[i] * max(abs(ws[i, k + 4]), abs(ws[i, k + 5]) * radius))
    power = power_of_four(radius, (order - 7) // 4)
    square = radius * radius
    early *= power
    middle *= power * square
    late *= power * square * square
    return not (late <= GAP and middle <= GAP * max(late, 1.0) and early <= GAP * max(middle, 1.0))


@inlined
def is_held(i, marks):
    """Whether the last terms of integral or guard i, counted from the first integral, bound the step.

    Those of an affine guard are as small as the states' are.
    """
    return i < 0 or marks[i] & AFFINE == 0


@inlined
def _overruns(ws, n, quadratures, count, marks, h, settings):
    """Whether an integral or a guard, to which series of states lead, has larger last terms than what it moves."""
    order = settings.order
    last = power_of_four(h, order // 4) * h * h * h
    found = False
    for i in range(quadratures + count):
        if is_held(i - quadratures, marks):
            g = ws[n + i]
            allowed = settings.tolerance * late_size(ws, uint64(n + i), h, uint64(1)) * h + SMALLEST
            found |= max(abs(g[order]) * last, abs(g[order - 1]) * last * settings.reach / h) > allowed
    return found


@rare
def restrain(ws, n, quadratures, count, marks, settings, h):
    """The step h, shortened until integrals and guards are as exact as the states."""
    shorter = h
    # a guard of time may be as much faster than the states as it likes
    for _ in range(100):
        if not _overruns(ws, n, quadratures, count, marks, shorter, settings):
            return shorter
        shorter *= 0.7
    return h


@rare
def proven_step(functions, settings, h, t, state, ws, scratch):
    """The step h, shortened until the series obeys the equation at its end.

    The last coefficients may lie in a gap of the series (the solution of x'' = -x**3 from x = 0 has every fourth one
    only) and promise a step far beyond its radius; earlier ones show that, and the defect tells how far it goes.
    """
    place, rate, slope = scratch.out, scratch.before, scratch.after
    n = place.size
    whole = h
    for _ in range(SHORTENINGS):
        _values_and_rates(ws, n, settings.order, h, place, slope)
        functions.field(state.run[0].mode, t + h, state.c, place, rate)
        holds = True
        for i in range(n):
            allowed = 1e-12 * abs(rate[i]) * h
            if i < state.x.size:
                allowed += max(DEFECT * settings.tolerance, 1e-12) * state.scale[i]
            else:
                allowed += DEFECT * settings.tolerance * late_size(ws, uint64(i), h, uint64(1)) * h
            holds = holds and abs(slope[i] - rate[i]) * h <= allowed
        if holds:
            return h
        h *= 0.6
    return whole


@inlined
def has_unproven(marks, count):
    """Whether the series of any guard may end before that of the states."""
    found = False
    for j in range(count):
        found = found or marks[j] & UNPROVEN != 0
    return found


@rare
def proven_guards(functions, tables, settings, h, t, state, ws, scratch):
    """The step h, shortened until guards whose series may end before it are what their series say at its end.

    A pole, a root or a logarithm near by ends a guard's series; tanh far from its slope shows none of it. NaN if a
    guard is no number where the step begins.
    """
    n = state.x.size
    first = n + settings.quadratures
    mode = state.run[0].mode
    marks = tables.marks[mode]
    count = tables.active[mode, 0]
    place = scratch.before[:n]
    for j in range(count):
        if marks[j] & UNPROVEN and not abs(ws[first + j, 0]) < math.inf:
            return math.nan
    for _ in range(100):
        for i in range(n):
            place[i] = value(ws, uint64(i), h)
        holds = True
        for j in range(count):
            if marks[j] & UNPROVEN:
                row = uint64(first + j)
                error = functions.guard(mode, j, t + h, state.c, place, scratch.gradient) - value(ws, row, h)
                moved = late_size(ws, row, h, uint64(1)) * h
                allowed = DEFECT * settings.tolerance * moved + 1e-12 * size(ws, row, h)
                holds = holds and abs(error) <= allowed
        if holds:
            return h
        h *= 0.5
    return h


@inlined
def expand(functions, tables, settings, t, state, ws, scratch):
    """Taylor coefficients at the present state; returns the step that keeps both state and tangents within tolerance.

    The last term is to be a part of the tolerance: for states relative to their scales, which are the sizes that they
    have had of late, for a tangent to its length in these scales, for integrals and guards to what they move in this
    step.
    """
    run, vectors, scale, weights = state.run[0], state.vectors, state.scale, scratch.weights
    n = state.x.size
    order, mode, live, reach = settings.order, run.mode, run.live, settings.reach
    marks, count = tables.marks[mode], tables.active[mode, 0]
    functions.jet(mode, order, t, state.c, state.x, ws)
    run.evaluations += order
    last = 0.0
    last_but_one = 0.0
    finest = EPSILON / settings.tolerance
    common = math.inf
    for i in range(n):
        here = max(FADE * scale[i], finest * abs(ws[i, 0]))
        if here <= SMALLEST:
            here = max(here, own_scale(ws[i], order, reach))
        scale[i] = here
        weights[i] = 0.0
        if here > SMALLEST:
            weights[i] = 1.0 / here
            common = min(common, weights[i])
        last = max(last, abs(ws[i, order]) * weights[i])
        last_but_one = max(last_but_one, abs(ws[i, order - 1]) * weights[i])
    if live > 0:
        if settings.own_jacobian == 1:
            functions.jacobian_jet(mode, order, state.c, ws)
        for v in range(0, live, 2):
            row = _first_row(ws, vectors, v)
            functions.tangent(mode, order, state.c, vectors[v], vectors[min(v + 1, live - 1)], ws, row)
        metric = scratch.metric
        for i in range(n):
            metric[i] = weights[i] if weights[i] > 0.0 else (common if common < math.inf else 1.0)
        for v in range(live):
            row = _first_row(ws, vectors, v)
            length = 0.0
            a = 0.0
            b = 0.0
            for i in range(n):
                length = max(length, abs(ws[row + i, 0]) * metric[i])
                a = max(a, abs(ws[row + i, order]) * metric[i])
                b = max(b, abs(ws[row + i, order - 1]) * metric[i])
            last = max(last, a / length)
            last_but_one = max(last_but_one, b / length)
    h = min(radius(last, last_but_one, order) * reach, run.period, LONGEST)
    for i in range(n):
        scale[i] = max(scale[i], min(abs(ws[i, 0]), SLOW * abs(ws[i, 1]) * h))
    if _has_gap(ws, n, order, h / reach, weights):
        h = proven_step(functions, settings, h, t, state, ws, scratch)
    if _overruns(ws, n, settings.quadratures, count, marks, h, settings):
        h = restrain(ws, n, settings.quadratures, count, marks, settings, h)
    if has_unproven(marks, count):
        h = proven_guards(functions, tables, settings, h, t, state, ws, scratch)
    return h


@inner
def evaluate(ws, count, s, out):
    """Polynomials of the first ``count`` rows at s."""
    for i in range(count):
        out[i] = value(ws, uint64(i), s)


@inner
def evaluate_vectors(ws, s, live, vectors):
    """Live tangents at s, in place."""
    n = vectors.shape[1]
    for v in range(live):
        row = _first_row(ws, vectors, v)
        for i in range(n):
            vectors[v, i] = value(ws, uint64(row + i), s)
