"""One step of eight trajectories in one mode: series, lengths of the steps, states and tangents at their ends.

What happens at single trajectories, their events above all, is left to the functions for one. ``block`` holds the
arrays of lanes, in the order of ``engine.layout``.
"""

from chaosdrill.engine.jit import inlined
from chaosdrill.engine.lane_series import lane_size, lane_value
from chaosdrill.engine.lanes import LANES, larger, magnitude, row_of, table_of
from chaosdrill.engine.layout import (
    BLOCK_C,
    BLOCK_GAP,
    BLOCK_H,
    BLOCK_LAST,
    BLOCK_OUT,
    BLOCK_PERIOD,
    BLOCK_REACH,
    BLOCK_T,
    BLOCK_V,
    BLOCK_WS,
    BLOCK_X,
    JACOBIAN,
    ORDER,
    PERIOD,
    TIME,
)
from chaosdrill.engine.taylor import LONGEST, radius


@inlined
def gather(places, settings, x, vectors, c, varying, carried_f, live, block):
    """Put the trajectories at ``places`` into lanes."""
    times = block[BLOCK_T]
    for lane in range(places.size):
        p = places[lane]
        times[lane] = carried_f[p, TIME]
        block[BLOCK_PERIOD][lane] = settings[p, PERIOD]
        for i in range(x.shape[1]):
            block[BLOCK_X][i, lane] = x[p, i]
        for v in range(live):
            for i in range(x.shape[1]):
                block[BLOCK_V][v, i, lane] = vectors[p, v, i]
        for i in range(varying.size):
            block[BLOCK_C][varying[i], lane] = c[p, varying[i]]


@inlined
def _first_row(ws, m, n, v):
    return ws.shape[0] - (m + m % 2) * n + v * n


@inlined
def expand(lane_functions, mode, live, m, rows, settings_i, reach, block):
    """Series at the present states, and the steps that keep states and tangents within tolerance, as for one."""
    order = settings_i[ORDER]
    ws = block[BLOCK_WS]
    n = block[BLOCK_X].shape[0]
    series = table_of(ws)
    lane_functions[0](mode, order, block[BLOCK_T], block[BLOCK_C], block[BLOCK_X], ws)
    states = row_of(block[BLOCK_X])
    scale = larger(magnitude(states[0]), 1.0)
    last = magnitude(series[0][order])
    last_but_one = magnitude(series[0][order - 1])
    for i in range(1, n):
        scale = larger(scale, magnitude(states[i]))
        last = larger(last, magnitude(series[i][order]))
        last_but_one = larger(last_but_one, magnitude(series[i][order - 1]))
    for i in range(n, rows):
        last = larger(last, magnitude(series[i][order]))
        last_but_one = larger(last_but_one, magnitude(series[i][order - 1]))
    last = last / scale
    last_but_one = last_but_one / scale
    if live > 0:
        if settings_i[JACOBIAN] == 1:
            lane_functions[1](mode, order, block[BLOCK_C], ws)
        vectors = block[BLOCK_V]
        for v in range(0, live, 2):
            second = vectors[min(v + 1, live - 1)]
            lane_functions[2](mode, order, block[BLOCK_C], vectors[v], second, ws, _first_row(ws, m, n, v))
        for v in range(live):
            row = _first_row(ws, m, n, v)
            size = magnitude(series[row][0])
            a = magnitude(series[row][order])
            b = magnitude(series[row][order - 1])
            for i in range(row + 1, row + n):
                size = larger(size, magnitude(series[i][0]))
                a = larger(a, magnitude(series[i][order]))
                b = larger(b, magnitude(series[i][order - 1]))
            last = larger(last, a / size)
            last_but_one = larger(last_but_one, b / size)
    ends = block[BLOCK_LAST]
    lines = row_of(ends)
    lines[0] = last
    lines[1] = last_but_one
    lines[2] = scale
    for lane in range(LANES):
        h = radius(ends[0, lane], ends[1, lane], order) * reach
        block[BLOCK_H][lane] = min(h, block[BLOCK_PERIOD][lane], LONGEST)


@inlined
def look_for_gaps(n, reach, block):
    """Sums of the late terms of the states at the radius of convergence that the step shows, over the states' size."""
    series = table_of(block[BLOCK_WS])
    s = row_of(block[BLOCK_H])[0] / reach
    total = lane_size(series[0], s)
    for i in range(1, n):
        total = total + lane_size(series[i], s)
    row_of(block[BLOCK_GAP])[0] = total / row_of(block[BLOCK_LAST])[2]


@inlined
def evaluate(count, live, m, block):
    """States, quadratures and live tangents at the ends of the steps."""
    ws = block[BLOCK_WS]
    n = block[BLOCK_X].shape[0]
    series = table_of(ws)
    s = row_of(block[BLOCK_REACH])[0]
    out = row_of(block[BLOCK_OUT])
    for i in range(count):
        out[i] = lane_value(series[i], s)
    vectors = table_of(block[BLOCK_V])
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
