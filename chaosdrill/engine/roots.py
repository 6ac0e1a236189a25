"""First crossing of zero of a polynomial on an interval: none missed, double roots included.

The polynomial is bounded by the Bernstein form of its first coefficients plus a bound on the rest; intervals are
halved until each is free of roots, monotone, or of one curvature. On an interval of one curvature the extremum decides,
so that two roots close together are found at any distance (compare Farouki 2012, doi:10.1016/j.cagd.2012.03.001).
"""

import numpy as np

from chaosdrill.codegen.kinds import uint64
from chaosdrill.engine.jit import rare, series
from chaosdrill.engine.lanes import part, put, spread
from chaosdrill.engine.polynomial import value_and_slope
from chaosdrill.engine.tuning import ROOTS


def bernstein_weights(degree: int) -> np.ndarray:
    """Weight of coefficient k of a polynomial on [0, 1] in Bernstein coefficient j, shape (degree + 1, degree + 1)."""
    weights = np.zeros((degree + 1, degree + 1))
    for j in range(degree + 1):
        weights[j, 0] = 1.0
        for k in range(1, j + 1):
            weights[j, k] = weights[j, k - 1] * (j - k + 1) / (degree - k + 1)
    return weights


_WEIGHTS = np.ascontiguousarray(bernstein_weights(ROOTS.degree).T)
"""Those of one coefficient side by side: of this degree they fill a vector register."""


@series
def _refine(a, n, low, high, guess):
    """Root in [low, high] of a polynomial that is negative at low and not negative at high.

    Newton steps inside of the bracket; the last one is known to be right from how the two before it shrank.
    """
    u = guess if low < guess < high else 0.5 * (low + high)
    before = 0.0
    for _ in range(100):
        f, d = value_and_slope(a, n, u)
        if f < 0.0:
            low = u
        else:
            high = u
        step = f / d if d > 0.0 else np.inf
        following = u - step
        if abs(step) <= 1.2e-16 * high:
            return min(max(following, low), high)
        # an end of the bracket is no root only because a Newton step leads there
        if not low < following < high:
            following = 0.5 * (low + high)
            step = 0.0
            if following in (low, high):
                return following
        elif abs(step) ** 3 <= 1e-17 * high * before * before:
            return following
        before = step
        u = following
    return u


@series
def _concave_crossing(a, n, left, right):
    """First root in [left, right] of a polynomial that is concave there, negative at left and falls at right; or -1.

    The tangents at two points on either side of the summit bound it from above.
    """
    low = left
    high = right
    f_low, d_low = value_and_slope(a, n, low)
    f_high, d_high = value_and_slope(a, n, high)
    if d_low <= 0.0 or d_high >= 0.0:
        return -1.0
    for _ in range(60):
        u = low + (f_high - f_low - d_high * (high - low)) / (d_low - d_high)
        if f_low + d_low * (u - low) < 0.0 or not low < u < high:
            return -1.0
        f, d = value_and_slope(a, n, u)
        if f >= 0.0:
            return _refine(a, n, left, u, left)
        if d > 0.0:
            low = u
            f_low = f
            d_low = d
        elif d < 0.0:
            high = u
            f_high = f
            d_high = d
        else:
            return -1.0
    return -1.0


@series
def _meeting(b, degree, f):
    """Where in an interval a polynomial meets zero, about: the parabola through its slopes at both ends."""
    first = degree * (b[1] - b[0])
    bend = 0.5 * (degree * (b[degree] - b[degree - 1]) - first)
    t = -b[0] / (f - b[0])
    for _ in range(2):
        t -= (b[0] + t * (first + t * bend)) / (first + 2.0 * t * bend)
    return t


@series
def _search(a, n, degree, budget, stack, ends):
    """First upward crossing in [0, 1]; -1 without one, -2 if the budget of intervals does not decide.

    Row 0 of ``stack`` holds the Bernstein coefficients of the terms up to ``degree``; the rest enters by its bound.
    """
    tail = 0.0
    tail_slope = 0.0
    tail_bend = 0.0
    for k in range(degree + 1, n + 1):
        m = abs(a[k])
        tail += m
        tail_slope += k * m
        tail_bend += k * (k - 1) * m
    ends[0, 0] = 0.0
    ends[0, 1] = 1.0
    count = 1
    while count > 0:
        budget -= 1
        if budget < 0 or count + 1 > ROOTS.depth:
            return -2.0
        count -= 1
        b = stack[count]
        left = ends[count, 0]
        width = ends[count, 1]
        right = left + width
        reach = right ** (degree - 1)
        highest = b[0]
        for j in range(1, degree + 1):
            highest = max(highest, b[j])
        if highest + tail * reach * right * right < 0.0:
            continue
        rise = b[1] - b[0]
        fall = rise
        bend_high = -np.inf
        bend_low = np.inf
        before = rise
        for j in range(1, degree):
            d = b[j + 1] - b[j]
            rise = min(rise, d)
            fall = max(fall, d)
            bend_high = max(bend_high, d - before)
            bend_low = min(bend_low, d - before)
            before = d
        bound = tail_slope * reach * right * width / degree
        if rise > bound:
            f, _ = value_and_slope(a, n, right)
            if f >= 0.0:
                return _refine(a, n, left, right, left + width * _meeting(b, degree, f))
            continue
        if fall < -bound:
            continue
        bound = tail_bend * reach * width * width / (degree * (degree - 1))
        if bend_high < -bound or bend_low > bound:
            f, _ = value_and_slope(a, n, right)
            # a concave one that falls at the end is back from beyond zero there, whatever the last digit of its value
            back = bend_high < -bound and (f < 0.0 or b[degree] < b[degree - 1])
            if back:
                u = _concave_crossing(a, n, left, right)
                if u >= 0.0:
                    return u
            if f >= 0.0:
                return _refine(a, n, left, right, left + width * _meeting(b, degree, f))
            continue
        half = 0.5 * width
        # de Casteljau: row `count` becomes the right half, row `count + 1` the left half, which is searched first
        other = stack[count + 1]
        for i in range(degree + 1):
            other[i] = b[0]
            for j in range(degree - i):
                b[j] = 0.5 * (b[j] + b[j + 1])
        ends[count, 0] = left + half
        ends[count, 1] = half
        ends[count + 1, 0] = left
        ends[count + 1, 1] = half
        count += 2
    return -1.0


@rare
def _search_whole(a, n, stack, ends):
    """The same search with the Bernstein form of the whole polynomial, where the bound on the rest is too wide.

    Only a polynomial that is zero to round-off exhausts the budget; then its value at the end decides.
    """
    b = stack[0]
    binomial = 1.0
    for k in range(n + 1):
        b[k] = a[k] / binomial
        binomial *= (n - k) / (k + 1)
    for i in range(1, n + 1):
        for j in range(n, i - 1, -1):
            b[j] += b[j - 1]
    u = _search(a, n, n, ROOTS.whole_budget, stack, ends)
    if u == -2.0:
        return _refine(a, n, 0.0, 1.0, 0.5) if value_and_slope(a, n, 1.0)[0] >= 0.0 else -1.0
    return u


@series
def first_crossing(g, start, n, h, up, a, stack, ends):
    """Smallest s in (0, h] at which a polynomial reaches zero, from below if ``up``, else from above; -1 if none.

    The coefficients are g[start], ..., g[start + n]; the value at 0 must be on the side from which zero is reached.
    ``a`` (n + 1 or longer), ``stack`` (DEPTH, more than n and DEGREE) and ``ends`` (DEPTH, 2) are scratch.
    """
    even = 1.0 if up else -1.0
    odd = even * h
    square = h * h
    most = 0.0
    rest = 0.0
    for m in range((n + 1) // 2):
        k = uint64(2 * m)
        a[k] = g[uint64(start + 2 * m)] * even
        a[uint64(2 * m + 1)] = g[uint64(start + 2 * m + 1)] * odd
        if m > 0:
            most += max(a[k], 0.0)
        rest += max(a[uint64(2 * m + 1)], 0.0)
        even *= square
        odd *= square
    if n % 2 == 0:
        a[n] = g[start + n] * even
        if n > 0:
            most += max(a[n], 0.0)
    if a[0] + most + rest < 0.0:
        return -1.0
    for k in range(n + 1, ROOTS.degree + 1):
        a[k] = 0.0
    b = spread(a[0])
    for k in range(1, ROOTS.degree + 1):
        b = b + a[k] * part(_WEIGHTS, k, 0)
    put(stack, 0, 0, b)
    u = _search(a, n, ROOTS.degree, ROOTS.budget, stack, ends)
    if u == -2.0:
        u = _search_whole(a, n, stack, ends)
    return u * h if u >= 0.0 else -1.0


@rare
def recrossing(g, start, n, h, up, a, shifted, stack, ends):
    """For a polynomial that is beyond zero: when it comes back, and when it then crosses again, each -1 for never."""
    back = first_crossing(g, start, n, h, not up, a, stack, ends)
    if back < 0.0 or back >= h:
        return back, -1.0
    for k in range(n + 1):
        shifted[k] = g[start + k]
    for i in range(n):
        for k in range(n - 1, i - 1, -1):
            shifted[k] += back * shifted[k + 1]
    sign = 1.0 if up else -1.0
    first = 0
    while first < n and shifted[first] * sign >= 0.0:
        first += 1
    if first == n:
        return back, -1.0
    again = first_crossing(shifted, first, n - first, h - back, up, a, stack, ends)
    return back, (back + again if again >= 0.0 else -1.0)
