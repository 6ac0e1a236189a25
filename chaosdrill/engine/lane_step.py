"""One step of eight trajectories in one mode: series, lengths of the steps, states and tangents at their ends.

What happens at single trajectories, their events above all, is left to the functions for one. ``block`` holds the
arrays of lanes, in the order of ``engine.layout``.
"""

from numba import uint64

from chaosdrill.engine.jit import inlined, inner
from chaosdrill.engine.lane_series import lane_late_size, lane_value
from chaosdrill.engine.lanes import LANES, chosen, larger, magnitude, row_of, table_of
from chaosdrill.engine.taylor import EPSILON, FADE, GAP, LONGEST, SLOW, SMALLEST, is_held, own_scale, radius

ABSURD = 1e100
"""Last term over its scale from which on a scale is not known yet."""


@inlined
def gather(places, live, states, varying, block):
    """Put the trajectories at ``places`` into lanes."""
    for lane in range(LANES):
        p = uint64(places[lane])
        run = states.run[p]
        block.t[lane] = run.time
        block.period[lane] = run.period
        for i in range(states.x.shape[1]):
            block.x[i, lane] = states.x[p, i]
            block.scale[i, lane] = states.scale[p, i]
        for v in range(live):
            for i in range(states.x.shape[1]):
                block.v[v, i, lane] = states.vectors[p, v, i]
        for i in range(varying.size):
            k = uint64(varying[i])
            block.c[k, lane] = states.c[p, k]


@inlined
def _first_row(ws, m, n, v):
    return ws.shape[0] - (m + m % 2) * n + v * n


@inner
def _begin_scales(n, order, reach, lane, block, row):
    """Scales of one lane of which nothing is known yet; returns its last two terms in its scales."""
    last = 0.0
    last_but_one = 0.0
    for i in range(n):
        if block.scale[i, lane] <= SMALLEST:
            for k in range(order + 1):
                row[k] = block.ws[i, k, lane]
            block.scale[i, lane] = max(block.scale[i, lane], own_scale(row, order, reach))
        if block.scale[i, lane] > SMALLEST:
            last = max(last, abs(block.ws[i, order, lane]) / block.scale[i, lane])
            last_but_one = max(last_but_one, abs(block.ws[i, order - 1, lane]) / block.scale[i, lane])
    return last, last_but_one


@inlined
def expand(lane_functions, mode, live, m, settings, block, row):
    """Series at the present states, and the steps that keep states and tangents within tolerance, as for one.

    ``row`` is scratch for one polynomial.
    """
    order, reach = settings.order, settings.reach
    ws = block.ws
    n = block.x.shape[0]
    series = table_of(ws)
    scales = row_of(block.scale)
    ends = row_of(block.last)
    lane_functions.jet(mode, order, block.t, block.c, block.x, ws)
    finest = EPSILON / settings.tolerance
    weights = row_of(block.weights)
    widest = scales[0] * 0.0
    last = widest
    last_but_one = widest
    for i in range(n):
        scale = larger(FADE * scales[i], finest * magnitude(series[i][0]))
        scales[i] = scale
        weight = 1.0 / larger(scale, SMALLEST)
        widest = larger(widest, scale)
        weights[i] = weight
        last = larger(last, magnitude(series[i][order]) * weight)
        last_but_one = larger(last_but_one, magnitude(series[i][order - 1]) * weight)
    ends[0] = last
    ends[1] = last_but_one
    for lane in range(LANES):
        if not max(block.last[0, lane], block.last[1, lane]) < ABSURD:
            block.last[0, lane], block.last[1, lane] = _begin_scales(n, order, reach, lane, block, row)
    if live > 0:
        if settings.own_jacobian == 1:
            lane_functions.jacobian_jet(mode, order, block.c, ws)
        vectors = block.v
        for v in range(0, live, 2):
            second = vectors[min(v + 1, live - 1)]
            lane_functions.tangent(mode, order, block.c, vectors[v], second, ws, _first_row(ws, m, n, v))
        last = ends[0]
        last_but_one = ends[1]
        common = 1.0 / larger(widest, SMALLEST)
        metric = row_of(block.metric)
        for i in range(n):
            metric[i] = chosen(larger(scales[i] - SMALLEST, 0.0), weights[i], common)
        for v in range(live):
            first = _first_row(ws, m, n, v)
            length = common * 0.0
            a = length
            b = length
            for i in range(n):
                length = larger(length, magnitude(series[first + i][0]) * metric[i])
                a = larger(a, magnitude(series[first + i][order]) * metric[i])
                b = larger(b, magnitude(series[first + i][order - 1]) * metric[i])
            length = 1.0 / length
            last = larger(last, a * length)
            last_but_one = larger(last_but_one, b * length)
        ends[0] = last
        ends[1] = last_but_one
    for lane in range(LANES):
        h = radius(block.last[0, lane], block.last[1, lane], order) * reach
        block.h[lane] = min(h, block.period[lane], LONGEST)
    h = row_of(block.h)[0]
    for i in range(n):
        size = -larger(-magnitude(series[i][0]), -SLOW * magnitude(series[i][1]) * h)
        scales[i] = larger(scales[i], size)


@inlined
def look_for_gaps(n, quadratures, count, marks, settings, block):
    """What raises suspicion where it is above zero: of the series of states, and of those of integrals and guards."""
    order, reach = settings.order, settings.reach
    series = table_of(block.ws)
    weights = row_of(block.weights)
    gaps = row_of(block.gap)
    h = row_of(block.h)[0]
    s = h / reach
    early = 0.0 * s
    middle = early
    late = early
    k = order - 7
    for i in range(n):
        g = series[i]
        early = larger(early, larger(magnitude(g[k]), magnitude(g[k + 1]) * s) * weights[i])
        middle = larger(middle, larger(magnitude(g[k + 2]), magnitude(g[k + 3]) * s) * weights[i])
        late = larger(late, larger(magnitude(g[k + 4]), magnitude(g[k + 5]) * s) * weights[i])
    power = _power_of_four(s, k // 4)
    early = early * power
    middle = middle * (power * s * s)
    late = late * (power * s * s * s * s)
    gaps[0] = larger(late - GAP, larger(middle - GAP * larger(late, 1.0), early - GAP * larger(middle, 1.0)))
    last = _power_of_four(h, order // 4) * h * h
    excess = 0.0 * h
    for i in range(quadratures + count):
        if is_held(i - quadratures, marks):
            g = series[n + i]
            ends = larger(magnitude(g[order]) * last * h, magnitude(g[order - 1]) * last * reach)
            excess = larger(excess, ends - settings.tolerance * lane_late_size(g, h, 1) * h)
    gaps[1] = excess - SMALLEST


@inlined
def _power_of_four(x, k):
    fourth = (x * x) * (x * x)
    power = 1.0 + 0.0 * x
    for _ in range(k):
        power = power * fourth
    return power


@inlined
def evaluate(count, live, m, block):
    """States, quadratures and live tangents at the ends of the steps."""
    ws = block.ws
    n = block.x.shape[0]
    series = table_of(ws)
    s = row_of(block.reach)[0]
    out = row_of(block.out)
    for i in range(count):
        out[i] = lane_value(series[i], s)
    vectors = table_of(block.v)
    for v in range(live):
        row = _first_row(ws, m, n, v)
        for i in range(n):
            vectors[v][i] = lane_value(series[row + i], s)


@inlined
def copy_lane(ws, first, count, lane, order, rows):
    """The polynomials of one lane, for the functions that look at one trajectory."""
    for j in range(count):
        for k in range(order + 1):
            rows[j, k] = ws[first + j, k, lane]
