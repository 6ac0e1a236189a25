"""Adaptive Taylor method of variable order (Jorba and Zou 2005, doi:10.1080/10586458.2005.10128904)."""

import math

from chaosdrill.codegen.kinds import uint64
from chaosdrill.engine import scales
from chaosdrill.engine.checked import first_row, look_along_series, may_hide, proven
from chaosdrill.engine.jit import RECIPROCAL, inlined, inner, rare
from chaosdrill.engine.lanes import exponent, floor, larger, mantissa, power_of_two
from chaosdrill.engine.layout import AFFINE, STEEP
from chaosdrill.engine.polynomial import late_size, value
from chaosdrill.engine.scales import SMALLEST

METHOD = {
    "summary": "adaptive Taylor series of variable order; events are roots of the guards' polynomials",
    "cites": ("jorba2005", "farouki2012"),
    "series": True,
    "lanes": True,
}

LONGEST = 1e9
"""Longest step, so that no power of it overflows."""

GAP = 10.0
"""Factor between the sizes of two terms and the next two, at the radius of convergence, that raises suspicion; about 5
in the series of exp."""


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


@inlined
def has_no_value(ws, first, marks, count):
    """Whether a guard with steep operations is no number where the step begins."""
    found = False
    for j in range(count):
        found |= marks[j] & STEEP != 0 and not abs(ws[first + j, 0]) < math.inf
    return found


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
    whole = 0.0
    least = scales.finest(settings.tolerance)
    for i in range(n):
        here = scales.brought(scale[i], ws[i, 0], least)
        if scales.has_none(here, ws[i, 1], run.period):
            here = max(here, scales.of_series(ws[i], order, reach))
        scale[i] = here
        weights[i] = 1.0 / here if here > SMALLEST else 0.0
        whole += ws[i, order]
        last = max(last, abs(ws[i, order]) * weights[i])
        last_but_one = max(last_but_one, abs(ws[i, order - 1]) * weights[i])
    if live > 0:
        if settings.own_jacobian == 1:
            functions.jacobian_jet(mode, order, state.c, ws)
        for v in range(0, live, 2):
            row = first_row(ws, vectors, v)
            functions.tangent(mode, order, state.c, vectors[v], vectors[min(v + 1, live - 1)], ws, row)
        metric = scratch.metric
        for i in range(n):
            metric[i] = weights[i]
        scales.fill(metric)
        for v in range(live):
            row = first_row(ws, vectors, v)
            length = 0.0
            a = 0.0
            b = 0.0
            for i in range(n):
                length = max(length, abs(ws[row + i, 0]) * metric[i])
                a = max(a, abs(ws[row + i, order]) * metric[i])
                b = max(b, abs(ws[row + i, order - 1]) * metric[i])
            last = max(last, a / length)
            last_but_one = max(last_but_one, b / length)
    if not abs(whole) < math.inf:
        return math.nan
    h = min(radius(last, last_but_one, order) * reach, run.period, LONGEST)
    for i in range(n):
        scale[i] = scales.followed(scale[i], ws[i, 0], ws[i, 1], h)
    steep = tables.steep[mode, 0] > 0
    hides = steep and may_hide(tables, settings, mode, h, ws)
    if _has_gap(ws, n, order, h / reach, weights):
        h = proven(functions, tables, settings, h, t, state, ws, scratch)
    if hides:
        h = look_along_series(functions, tables, settings, h, t, state, ws, scratch)
    if _overruns(ws, n, settings.quadratures, count, marks, h, settings):
        h = restrain(ws, n, settings.quadratures, count, marks, settings, h)
    if steep and has_no_value(ws, n + settings.quadratures, marks, count):
        return math.nan
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
        row = first_row(ws, vectors, v)
        for i in range(n):
            vectors[v, i] = value(ws, uint64(row + i), s)
