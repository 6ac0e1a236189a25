"""One run of a block of lanes is brought to the end of its step: strobes, states, and the event there."""

import math

from chaosdrill.engine import guards
from chaosdrill.engine.events import take
from chaosdrill.engine.jit import inlined
from chaosdrill.engine.lane_runs import (
    RUN_ARMED,
    RUN_C,
    RUN_CARRIED,
    RUN_CARRIED_F,
    RUN_COUNTS,
    RUN_DEAD,
    RUN_GRAZING,
    RUN_LOGS,
    RUN_PROGRESS,
    RUN_SETTINGS,
    RUN_SIDES,
    RUN_SLOTS,
    RUN_SUMS,
    RUN_VECTORS,
    RUN_WINDOW,
    RUN_X,
)
from chaosdrill.engine.lane_series import value_in_lane
from chaosdrill.engine.lane_step import copy_lane
from chaosdrill.engine.layout import (
    BLOCK_OUT,
    BLOCK_V,
    BLOCK_WS,
    DONE,
    EVALUATIONS,
    EVENT_COLUMNS,
    EVENT_KIND,
    EVENT_LIMIT,
    EVENT_ROWS,
    EVENTS_IN_PERIOD,
    FRESH,
    IMAGE,
    LAST,
    LONGEST,
    LOSES_RANK,
    MAX_EVENTS,
    MODE,
    NONFINITE,
    ONGOING,
    ORDER,
    OUT,
    PERIOD,
    QR_SINCE,
    QR_WAIT,
    RANK_CHECK,
    STAGE,
    STALL,
    STALLED,
    STEPS,
    STROBES,
    TAKEN,
    TIES,
    TIME,
    WORKSPACE,
)
from chaosdrill.engine.limits import LARGE_GROWTH, SMALLEST_STEP, STALL_LIMIT, state_outcome
from chaosdrill.engine.step import add_to
from chaosdrill.engine.tangents import orthonormalise
from chaosdrill.engine.window import keep


@inlined
def _pass_strobes(p, lane, runs, te, local, strobed, block, out):
    """Count the strobes that fall into the step, with their states; returns the time of the last one in it, or -1."""
    period = runs[RUN_SETTINGS][p, PERIOD]
    carried = runs[RUN_CARRIED][p]
    s = period - local
    strobe = -1.0
    while s <= te:
        carried[STROBES] += 1
        progress = runs[RUN_PROGRESS][p]
        if strobed and progress[STAGE] > 0 and progress[LAST] - carried[STROBES] < runs[RUN_WINDOW].shape[1]:
            n = runs[RUN_X].shape[1]
            for i in range(n):
                out[i] = value_in_lane(block[BLOCK_WS], i, lane, s)
            keep(out, 0, n, carried[MODE], runs[RUN_WINDOW][p], progress[TAKEN])
            progress[TAKEN] += 1
        carried[EVENTS_IN_PERIOD] = 0
        strobe = s
        s += period
    return strobe


@inlined
def _update_sides(first, count, directions, order, te, sides, armed, lane, block, scratch):
    for j in range(count):
        if armed[j] == 0:
            copy_lane(block[BLOCK_WS], first, count, lane, order, scratch[WORKSPACE])
            guards.update_sides(scratch[WORKSPACE], 0, directions, count, order, te, sides, armed)
            return


@inlined
def _move(p, lane, live, runs, block):
    """Take over the state, the tangents and the integrals of one lane."""
    x = runs[RUN_X][p]
    n = x.size
    out = block[BLOCK_OUT]
    for i in range(n):
        x[i] = out[i, lane]
    for v in range(live):
        for i in range(n):
            runs[RUN_VECTORS][p, v, i] = block[BLOCK_V][v, i, lane]
    for i in range(n, out.shape[0]):
        add_to(runs[RUN_SUMS][p], i - n, out[i, lane])


@inlined
def finish_step(
    functions,
    settings_i,
    watch,
    marks,
    transitions,
    bounds,
    section,
    shifts,
    p,
    lane,
    mode,
    live,
    te,
    happens,
    j,
    ties,
    first,
    runs,
    row,
    block,
    scratch,
):
    """Bring one run to the end of its step, and through the event there; returns DONE or what ended it."""
    carried = runs[RUN_CARRIED][p]
    carried_f = runs[RUN_CARRIED_F][p]
    x = runs[RUN_X][p]
    local = carried_f[TIME]
    order = settings_i[ORDER]
    carried[FRESH] = ONGOING
    strobed = section.size == 0 and runs[RUN_WINDOW].shape[1] > 0
    strobe = _pass_strobes(p, lane, runs, te, local, strobed, block, scratch[OUT])
    _move(p, lane, live, runs, block)
    carried_f[TIME] = te - strobe if strobe >= 0.0 else local + te
    carried_f[LONGEST] = max(carried_f[LONGEST], te)
    if te > SMALLEST_STEP * carried_f[LONGEST]:
        carried[STALL] = 0
    elif happens:
        carried[STALL] += 1
    carried[STEPS] += 1
    carried[EVALUATIONS] += order
    carried[QR_SINCE] += 1
    outcome = state_outcome(x, bounds)
    if outcome != DONE:
        return outcome
    sides = runs[RUN_SIDES][p]
    armed = runs[RUN_ARMED][p]
    _update_sides(first, watch[mode, 0], watch[mode, 1:], order, te, sides, armed, lane, block, scratch)
    orthonormal = runs[RUN_VECTORS].shape[1] > 0
    vectors = runs[RUN_VECTORS][p]
    logs = runs[RUN_LOGS][p]
    slots = runs[RUN_SLOTS][p]
    dead = runs[RUN_DEAD][p]
    if happens:
        if carried[STALL] > STALL_LIMIT:
            return STALLED
        carried[TIES] += ties
        if orthonormal and marks[mode, j] & LOSES_RANK:
            orthonormalise(vectors, shifts, slots, dead, logs, carried, scratch[IMAGE])
        largest = take(
            functions,
            runs[RUN_SETTINGS][p],
            transitions,
            j,
            carried_f[TIME],
            carried_f[TIME],
            runs[RUN_C][p],
            x,
            vectors,
            carried,
            runs[RUN_COUNTS][p],
            runs[RUN_GRAZING][p],
            row,
            scratch,
        )
        if carried[EVENT_ROWS] > 0:
            carried[EVENT_ROWS] = 0
            if section[int(row[0, EVENT_KIND])] == 1 and runs[RUN_PROGRESS][p, STAGE] > 0:
                keep(row[0], EVENT_COLUMNS, x.size, mode, runs[RUN_WINDOW][p], runs[RUN_PROGRESS][p, TAKEN])
                runs[RUN_PROGRESS][p, TAKEN] += 1
        if carried[EVENTS_IN_PERIOD] > settings_i[MAX_EVENTS]:
            return EVENT_LIMIT
        if largest == math.inf:
            return NONFINITE
        if largest > LARGE_GROWTH:
            carried[QR_SINCE] = carried[QR_WAIT]
    if orthonormal and (carried[RANK_CHECK] == 1 or carried[QR_SINCE] >= carried[QR_WAIT]):
        orthonormalise(vectors, shifts, slots, dead, logs, carried, scratch[IMAGE])
    return DONE
