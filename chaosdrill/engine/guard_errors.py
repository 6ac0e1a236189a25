"""What the polynomial of a guard may be off by: by rounding, and by what an interpolation leaves out."""

import math

import numpy as np
from numpy.polynomial.chebyshev import chebvander

from chaosdrill.codegen.kinds import uint64
from chaosdrill.codegen.layout import EPSILON, ROUNDING
from chaosdrill.engine import layout as at
from chaosdrill.engine.dop853_tables import GUARD_DEGREE, NODES, TO_CHEBYSHEV, TO_POWERS, inverse
from chaosdrill.engine.jit import inlined, rare, series
from chaosdrill.engine.lanes import magnitude
from chaosdrill.engine.polynomial import power, size, values
from chaosdrill.engine.radau_tables import DEGREE
from chaosdrill.engine.tuning import GUARDS, STEPS

INTERPOLATION_NOISE = 4 * EPSILON * float((np.abs(TO_CHEBYSHEV[-2:]) / NODES**2).sum())
"""Rounding units by which the interpolation moves the last two coefficients of a polynomial."""

_WEIGHTS = (TO_CHEBYSHEV.T / NODES[:, np.newaxis] ** 2).astype(np.longdouble)
_PLACES = np.linspace(0.0, 1.0, 101)
VALUE_NOISE = 2.0 + float(
    (np.abs(chebvander(2 * _PLACES - 1, GUARD_DEGREE - 2) @ _WEIGHTS.T).sum(axis=1) * _PLACES**2).max()
)
"""Errors of a guard's values by which it moves the polynomial: of those between, and of that at the start."""

POWER_NOISE = np.concatenate([(1.0, 1.0), np.abs(_WEIGHTS @ TO_POWERS).sum(axis=0) / VALUE_NOISE]).astype(float)
"""Of that, what the coefficients may be moved by, each times its power of the step."""

_FROM_POWERS = inverse(TO_POWERS[-2:, -2:]).astype(float)
"""The last two coefficients in powers -> those in Chebyshev polynomials."""


@inlined
def truncation(settings, marks):
    """Part of its size that the interpolated polynomial of a guard may leave out."""
    return GUARDS.interpolated_in_time if marks & at.TIMED else max(settings.tolerance, GUARDS.interpolated)


@rare
def left_out(functions, tables, settings, state, ws, i, j, h, t, scratch):
    """Truncation error of the interpolated polynomial of guard j over the step; for that of a series see `cut_off`."""
    mode = state.run[0].mode
    marks = tables.marks[mode, j]
    if settings.stepping == at.BY_SERIES:
        return 0.0
    place = scratch.before[: state.x.size]
    noise = functions.guard_error(mode, j, t, state.c, state.x, scratch.none)
    values(ws, place.size, h, place)
    noise = max(noise, functions.guard_error(mode, j, t + h, state.c, place, scratch.none))
    g, whole = ws[i], state.run[0].tried
    if marks & at.AFFINE:
        degree = DEGREE
        while degree > 2 and g[degree] == 0.0:
            degree -= 1
        # as Chebyshev polynomials
        last, before = last_terms(g, degree, 0.25 * whole)
        return 2.0 * (abs(last) + abs(before)) + settings.dense_noise * noise
    last = g[GUARD_DEGREE] * whole**GUARD_DEGREE
    before = g[GUARD_DEGREE - 1] * whole ** (GUARD_DEGREE - 1)
    rest = abs(_FROM_POWERS[0, 0] * before + _FROM_POWERS[1, 0] * last) + abs(_FROM_POWERS[1, 1] * last)
    return 2.0 * rest + VALUE_NOISE * ROUNDING * noise


@series
def slope_and_bend(g, n, s):
    """First and second derivative of a polynomial at s."""
    f = 0.0
    d = 0.0
    b = 0.0
    for m in range(n + 1):
        b = b * s + d
        d = d * s + f
        f = f * s + g[uint64(n - m)]
    return d, 2.0 * b


@inlined
def is_told(last, before, way):
    """Whether a polynomial tells where it has a root: its last two terms there are small beside the rate times the way.

    Else they alone may make it, where the motion comes to rest on the guard.
    """
    return magnitude(last) + magnitude(before) <= GUARDS.told * magnitude(way)


@series
def last_terms(g, n, s):
    """The last two terms of a polynomial at s, or of those of lanes."""
    before = power(s, n - 1)
    return g[uint64(n)] * (before * s), g[uint64(n - 1)] * before


@inlined
def cut_off(g, n, s):
    """What the series of a guard may leave out at s: about its last two terms."""
    last, before = last_terms(g, n, s)
    return 2.0 * (magnitude(last) + magnitude(before))


@inlined
def told_length(ws, i, degree, h):
    """Up to where the last two terms of a polynomial are small beside the others; beyond it tells of no side."""
    for _ in range(STEPS.halvings):
        last, before = last_terms(ws[i], degree, h)
        if is_told(last, before, size(ws, uint64(i), h)):
            break
        h *= 0.5
    return h


@inlined
def near(settings, h):
    """Within what time of each other roots in a step are looked at for whether they coincide."""
    return max(GUARDS.near, GUARDS.late * settings.tolerance) * h


@rare
def root_error(functions, tables, settings, state, ws, i, j, s, t, scratch):
    """How far a root at s may be from the exact one: by the guard's rounding, and by the tolerance of the states."""
    run = state.run[0]
    n = state.x.size
    place = scratch.before[:n]
    values(ws, n, s, place)
    off = ROUNDING * functions.guard_error(run.mode, j, t + s, state.c, place, scratch.none)
    if tables.marks[run.mode, j] & at.TIMED == 0:
        functions.guard(run.mode, j, t + s, state.c, place, scratch.gradient)
        for a in range(n):
            off += settings.tolerance * abs(scratch.gradient[a]) * state.scale[a]
    slope, _ = slope_and_bend(ws[i], settings.order, s)
    # a time is rounded, too
    return off / abs(slope) + 2.0 * EPSILON * abs(t + s) if slope != 0.0 else math.inf
