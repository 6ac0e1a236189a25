"""One step of eight trajectories in one mode: series, lengths of the steps, states and tangents at their ends.

What happens at single trajectories, their events above all, is left to the functions for one. ``block`` holds the
arrays of lanes, in the order of ``engine.layout``.
"""

from chaosdrill.codegen.kinds import uint64
from chaosdrill.engine import scales, taylor
from chaosdrill.engine.checked import first_row
from chaosdrill.engine.jit import inlined
from chaosdrill.engine.lanes import LANES, gathered, row_of, table_of
from chaosdrill.engine.polynomial import lane_late_size, lane_size, lane_value
from chaosdrill.engine.records import time_of


@inlined
def gather(places, live, states, varying, block):
    """Put the trajectories at ``places`` into lanes."""
    n = block.x.shape[0]
    for lane in range(LANES):
        run = states.run[uint64(places[lane])]
        block.t[lane] = time_of(run)
        block.period[lane] = run.period
    x, scale, c = row_of(block.x), row_of(block.scale), row_of(block.c)
    for i in range(n):
        x[i] = gathered(states.x, places, i)
        scale[i] = gathered(states.scale, places, i)
    span = row_of(block.span)
    for i in range(block.span.shape[0]):
        span[i] = gathered(states.span, places, i)
    vectors = table_of(block.v)
    for v in range(live):
        for i in range(n):
            vectors[v][i] = gathered(states.vectors, places, v * n + i)
    for i in range(varying.size):
        k = varying[i]
        c[k] = gathered(states.c, places, k)


@inlined
def _over(a, b, size):
    part = 1.0 / size
    return a * part, b * part


@inlined
def expand(lane_functions, mode, live, tables, settings, block, row):
    """Series at the present states, and the lengths of the steps; returns what `taylor.doubts` says of them.

    ``row`` is scratch for one polynomial.
    """
    ws, vectors, n = block.ws, block.v, block.x.shape[0]
    taylor.fill(lane_functions, mode, live, settings, block.t, block.c, block.x, vectors, ws)
    series, weights, period = table_of(ws), row_of(block.weights), row_of(block.period)[0]
    first, scale, metric = first_row(ws, vectors, 0), row_of(block.scale), row_of(block.metric)
    span = row_of(block.span)
    scales.renew(tables, mode, n, row_of(block.x), scale, span)
    scales.limit(tables, n, span, period, metric)
    h = taylor.length(_over, series, n, live, first, settings, period, scale, weights, metric, row)
    taylor.follow(series, n, scale, h)
    row_of(block.h)[0] = h
    return taylor.doubts(lane_late_size, lane_size, series, n, tables, settings, mode, h, weights)


@inlined
def evaluate(count, live, order, block):
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
        row = first_row(ws, block.v, v)
        for i in range(n):
            vectors[v][i] = lane_value(series[row + i], order, s)


@inlined
def copy_lane(ws, first, count, lane, order, rows):
    """The polynomials of one lane, for the functions that look at one trajectory."""
    for j in range(count):
        for k in range(order + 1):
            rows[j, k] = ws[first + j, k, lane]
