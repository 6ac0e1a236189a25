"""One step of eight trajectories in one mode: series, lengths of the steps, states and tangents at their ends.

What happens at single trajectories, their events above all, is left to the functions for one. ``block`` holds the
arrays of lanes, in the order of ``engine.layout``.
"""

import math

from chaosdrill.codegen.kinds import uint64
from chaosdrill.engine import scales
from chaosdrill.engine.checked import FEW
from chaosdrill.engine.jit import inlined, inner
from chaosdrill.engine.lane_series import lane_late_size, lane_size, lane_value
from chaosdrill.engine.lanes import (
    LANES,
    chosen,
    gathered,
    larger,
    magnitude,
    row_of,
    smaller,
    some,
    spread,
    table_of,
)
from chaosdrill.engine.layout import STEEP
from chaosdrill.engine.scales import SMALLEST
from chaosdrill.engine.taylor import GAP, LONGEST, is_held, radius


@inlined
def gather(places, live, states, varying, block):
    """Put the trajectories at ``places`` into lanes."""
    n = block.x.shape[0]
    for lane in range(LANES):
        run = states.run[uint64(places[lane])]
        block.t[lane] = run.time
        block.period[lane] = run.period
    x, scale, c = row_of(block.x), row_of(block.scale), row_of(block.c)
    for i in range(n):
        x[i] = gathered(states.x, places, i)
        scale[i] = gathered(states.scale, places, i)
    vectors = table_of(block.v)
    for v in range(live):
        for i in range(n):
            vectors[v][i] = gathered(states.vectors, places, v * n + i)
    for i in range(varying.size):
        k = varying[i]
        c[k] = gathered(states.c, places, k)


@inlined
def _first_row(ws, m, n, v):
    return ws.shape[0] - (m + m % 2) * n + v * n


@inner
def _begin_scales(n, order, reach, lane, block, row):
    """Scales of one lane of which nothing is known yet."""
    for i in range(n):
        if scales.has_none(block.scale[i, lane], block.ws[i, 1, lane], block.period[lane]):
            for k in range(order + 1):
                row[k] = block.ws[i, k, lane]
            block.scale[i, lane] = max(block.scale[i, lane], scales.of_series(row, order, reach))


@inlined
def expand(lane_functions, mode, live, m, settings, block, row):
    """Series at the present states, and the steps that keep states and tangents within tolerance, as for one.

    ``row`` is scratch for one polynomial.
    """
    order, reach = settings.order, settings.reach
    ws = block.ws
    n = block.x.shape[0]
    series = table_of(ws)
    sizes = row_of(block.scale)
    period = row_of(block.period)[0]
    lane_functions.jet(mode, order, block.t, block.c, block.x, ws)
    least = scales.finest(settings.tolerance)
    nothing = spread(0.0)
    unknown = nothing
    for i in range(n):
        size = scales.brought(sizes[i], series[i][0], least)
        sizes[i] = size
        ends = larger(magnitude(series[i][order]), magnitude(series[i][order - 1]))
        unknown = larger(unknown, chosen(~scales.has_none(size, series[i][1], period), 0.0, ends))
    if some(unknown > 0.0):
        row_of(block.gap)[0] = unknown
        for lane in range(LANES):
            if block.gap[0, lane] > 0.0:
                _begin_scales(n, order, reach, lane, block, row)
    weights = row_of(block.weights)
    widest = nothing
    last = nothing
    last_but_one = nothing
    for i in range(n):
        size = sizes[i]
        known = ~(size <= SMALLEST)
        weight = chosen(known, 1.0 / size, 0.0)
        widest = larger(widest, chosen(known, size, 0.0))
        weights[i] = weight
        last = larger(last, magnitude(series[i][order]) * weight)
        last_but_one = larger(last_but_one, magnitude(series[i][order - 1]) * weight)
    if live > 0:
        if settings.own_jacobian == 1:
            lane_functions.jacobian_jet(mode, order, block.c, ws)
        vectors = block.v
        for v in range(0, live, 2):
            second = vectors[min(v + 1, live - 1)]
            lane_functions.tangent(mode, order, block.c, vectors[v], second, ws, _first_row(ws, m, n, v))
        common = 1.0 / chosen(widest > 0.0, widest, 1.0)
        metric = row_of(block.metric)
        for i in range(n):
            metric[i] = chosen(weights[i] > 0.0, weights[i], common)
        for v in range(live):
            first = _first_row(ws, m, n, v)
            length = nothing
            a = nothing
            b = nothing
            for i in range(n):
                length = larger(length, magnitude(series[first + i][0]) * metric[i])
                a = larger(a, magnitude(series[first + i][order]) * metric[i])
                b = larger(b, magnitude(series[first + i][order - 1]) * metric[i])
            length = 1.0 / length
            last = larger(last, a * length)
            last_but_one = larger(last_but_one, b * length)
    h = smaller(smaller(radius(last, last_but_one, order) * reach, period), LONGEST)
    h = chosen(larger(last, last_but_one) < math.inf, h, math.nan)
    row_of(block.h)[0] = h
    for i in range(n):
        sizes[i] = scales.followed(sizes[i], series[i][0], series[i][1], h)


@inlined
def look_for_gaps(n, quadratures, count, marks, tables, mode, settings, block):
    """What raises suspicion where it is above zero: of states, of integrals and guards, of steep operations."""
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
    hides = 0.0 * h - 1.0
    for k in range(tables.steep[mode, 0]):
        g = series[tables.steep[mode, 1 + k]]
        shape = tables.shapes[mode, k]
        here = magnitude(g[0])
        allowed = larger(shape[0] * order + 0.0 * here, shape[1] * here - shape[2])
        few = lane_late_size(g, h, 1) * h
        if some(~(few <= FEW * allowed)):
            far = chosen(few <= FEW * allowed, -1.0, chosen(lane_size(g, order, h) - here <= allowed, -1.0, 1.0))
            hides = larger(hides, far)
    for j in range(count):
        if marks[j] & STEEP:
            hides = larger(hides, chosen(magnitude(series[n + quadratures + j][0]) < math.inf, -1.0, 1.0))
    gaps[2] = hides


@inlined
def _power_of_four(x, k):
    fourth = (x * x) * (x * x)
    power = 1.0 + 0.0 * x
    for _ in range(k):
        power = power * fourth
    return power


@inlined
def evaluate(count, live, m, order, block):
    """States, quadratures and live tangents at the ends of the steps."""
    ws = block.ws
    n = block.x.shape[0]
    series = table_of(ws)
    s = row_of(block.reach)[0]
    out = row_of(block.out)
    for i in range(count):
        out[i] = lane_value(series[i], order, s)
    vectors = table_of(block.v)
    for v in range(live):
        row = _first_row(ws, m, n, v)
        for i in range(n):
            vectors[v][i] = lane_value(series[row + i], order, s)


@inlined
def note_beyond(bounds, n, block):
    """Note as a gap, 1.0, where a state has left its bounds or is no number."""
    out = row_of(block.out)
    within = out[0] < math.inf
    for i in range(n):
        x = out[i]
        within = within & (magnitude(x) < math.inf) & (x >= bounds[0, i]) & (x <= bounds[1, i])
    row_of(block.gap)[1] = chosen(within, 0.0, 1.0)


@inlined
def copy_lane(ws, first, count, lane, order, rows):
    """The polynomials of one lane, for the functions that look at one trajectory."""
    for j in range(count):
        for k in range(order + 1):
            rows[j, k] = ws[first + j, k, lane]
