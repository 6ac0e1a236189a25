"""Many runs of one system by the Taylor method, stepped eight at a time in lanes.

Runs that wait for their next step stand in queues, one for every mode and number of live tangents; eight of a queue are
stepped together, each with its own step, and go to the queue of the mode that they then are in. Events are taken one by
one by the functions of a single run. No number of a run depends on which others are stepped with it.
"""

import math

from numba import int64, types

from chaosdrill.codegen.signatures import KERNEL_TYPES, LANE_TYPES, block, matrix, vector
from chaosdrill.engine import guards, lane_events, lane_step, taylor
from chaosdrill.engine.events import take
from chaosdrill.engine.jit import compiled, inlined, inner
from chaosdrill.engine.lane_series import value_in_lane
from chaosdrill.engine.lanes import LANES
from chaosdrill.engine.layout import (
    AFTER,
    BEFORE,
    BLOCK_GAP,
    BLOCK_H,
    BLOCK_OUT,
    BLOCK_REACH,
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
    GOAL,
    IMAGE,
    INVALID_START,
    LAST,
    LIVE,
    LONGEST,
    LOSES_RANK,
    MAX_EVENTS,
    MODE,
    NONFINITE,
    ONGOING,
    ORDER,
    OUT,
    PERIOD,
    PROVEN,
    QR_SINCE,
    QR_WAIT,
    RANK_CHECK,
    REACH,
    STAGE,
    STALL,
    STALLED,
    STEP_UNDERFLOW,
    STEPS,
    STROBES,
    TAKEN,
    TIES,
    TIME,
    WORKSPACE,
)
from chaosdrill.engine.limits import (
    LARGE_GROWTH,
    SMALLEST_STEP,
    STALL_LIMIT,
    integer_matrix,
    scratch_type,
    state_outcome,
)
from chaosdrill.engine.revival import pin, revive
from chaosdrill.engine.stepper import integers
from chaosdrill.engine.tangents import orthonormalise
from chaosdrill.engine.window import bring_in_order, keep

ACTIVE = 64
"""Runs under way at a time: enough to fill the lanes of every queue, few enough to stay in the cache."""

_blocks = types.Tuple(
    (
        *(vector, matrix, matrix, block, block, vector, vector, matrix, vector, matrix, vector),
        *(matrix, matrix, matrix, matrix, matrix, matrix),
    )
)  # in the order of BLOCK_...
_runs = types.Tuple(
    (
        *(matrix, matrix, matrix, block, block, integer_matrix, integer_matrix, matrix, integer_matrix, matrix),
        *(integer_matrix, integer_matrix, integer_matrix, matrix, integer_matrix, block, block, integers),
    )
)  # in the order of RUN_...
(
    RUN_SETTINGS,
    RUN_C,
    RUN_X,
    RUN_SUMS,
    RUN_VECTORS,
    RUN_SLOTS,
    RUN_DEAD,
    RUN_LOGS,
    RUN_CARRIED,
    RUN_CARRIED_F,
    RUN_SIDES,
    RUN_ARMED,
    RUN_COUNTS,
    RUN_GRAZING,
    RUN_PROGRESS,
    RUN_GROWTH,
    RUN_WINDOW,
    RUN_OUTCOME,
) = range(18)


@inlined
def _forget(p, runs, frame, pins):
    """Start all averages of a run anew."""
    runs[RUN_LOGS][p, :] = 0.0
    runs[RUN_COUNTS][p, :] = 0
    runs[RUN_SUMS][p, :, :] = 0.0
    runs[RUN_GRAZING][p, :] = math.inf
    carried = runs[RUN_CARRIED][p]
    carried[TIES] = 0
    carried[STEPS] = 0
    carried[EVALUATIONS] = 0
    if carried[LIVE] < frame.shape[0]:
        revive(runs[RUN_VECTORS][p], frame, runs[RUN_SLOTS][p], runs[RUN_DEAD][p], carried)
        pin(runs[RUN_VECTORS][p], pins, carried)


@inlined
def _begin(p, runs, stretches):
    progress = runs[RUN_PROGRESS][p]
    strobes = runs[RUN_CARRIED][p, STROBES]
    progress[STAGE] = 0
    progress[GOAL] = strobes + stretches[0]
    progress[LAST] = strobes + stretches.sum()
    progress[TAKEN] = 0
    runs[RUN_GROWTH][p, 0, :] = 0.0
    runs[RUN_WINDOW][p, :, :] = math.nan


@inner
def _is_over(p, runs, frame, shifts, pins, stretches, image, spare):
    """Note what a run has reached where it stands at a goal, until it has one ahead; whether there is none left."""
    progress = runs[RUN_PROGRESS][p]
    carried = runs[RUN_CARRIED][p]
    m = frame.shape[0]
    while carried[STROBES] >= progress[GOAL]:
        if m > 0:
            orthonormalise(
                runs[RUN_VECTORS][p],
                shifts,
                runs[RUN_SLOTS][p],
                runs[RUN_DEAD][p],
                runs[RUN_LOGS][p],
                carried,
                image,
            )
        stage = progress[STAGE]
        if stage == 0:
            _forget(p, runs, frame, pins)
        else:
            for i in range(m):
                lost = runs[RUN_DEAD][p, i] == 1
                runs[RUN_GROWTH][p, stage, i] = -math.inf if lost else runs[RUN_LOGS][p, i]
        if stage == stretches.size - 1:
            bring_in_order(runs[RUN_WINDOW][p], progress[TAKEN], spare)
            return True
        progress[STAGE] = stage + 1
        progress[GOAL] += stretches[stage + 1]
    return False


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
def _proven(functions, h, gap, settings_i, settings_f, t, c, x, carried, carried_f, lane, block, scratch):
    """The step, shortened where the series does not obey the equation at its end."""
    if carried[FRESH] == ONGOING and h <= 1.3 * carried_f[PROVEN]:
        return h
    if not gap <= taylor.GAP:
        lane_step.copy_lane(block[BLOCK_WS], 0, block[BLOCK_OUT].shape[0], lane, settings_i[ORDER], scratch[WORKSPACE])
        spare = (scratch[OUT], scratch[BEFORE], scratch[AFTER])
        h = taylor.proven_step(functions, h, settings_i, settings_f, t, c, x, carried, scratch[WORKSPACE], spare)
    carried_f[PROVEN] = h
    return h


@inlined
def _update_sides(first, count, directions, order, te, sides, armed, lane, block, scratch):
    for j in range(count):
        if armed[j] == 0:
            lane_step.copy_lane(block[BLOCK_WS], first, count, lane, order, scratch[WORKSPACE])
            guards.update_sides(scratch[WORKSPACE], 0, directions, count, order, te, sides, armed)
            return


@inlined
def _move(p, lane, te, live, runs, block):
    """Take over the state, the tangents and the integrals of one lane; integrals by a compensated sum."""
    x = runs[RUN_X][p]
    n = x.size
    out = block[BLOCK_OUT]
    for i in range(n):
        x[i] = out[i, lane]
    for v in range(live):
        for i in range(n):
            runs[RUN_VECTORS][p, v, i] = block[BLOCK_V][v, i, lane]
    sums = runs[RUN_SUMS][p]
    for i in range(n, out.shape[0]):
        old = sums[0, i - n]
        term = out[i, lane]
        new = old + term
        sums[1, i - n] += (old - new) + term if abs(old) >= abs(term) else (term - new) + old
        sums[0, i - n] = new


@inlined
def _finish_step(
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
    h,
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
    _move(p, lane, te, live, runs, block)
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


@inlined
def _step(
    functions,
    lane_functions,
    settings_i,
    watch,
    marks,
    transitions,
    bounds,
    varying,
    section,
    shifts,
    places,
    count,
    runs,
    results,
    plan,
    row,
    block,
    scratch,
):
    """One step of up to eight runs of one mode and number of live tangents; ``results`` says how each stands then."""
    x, vectors = runs[RUN_X], runs[RUN_VECTORS]
    m, n = vectors.shape[1], x.shape[1]
    mode = runs[RUN_CARRIED][places[0], MODE]
    live = runs[RUN_CARRIED][places[0], LIVE]
    guard_count = watch[mode, 0]
    first = block[BLOCK_OUT].shape[0]
    order = settings_i[ORDER]
    lane_step.gather(
        places,
        runs[RUN_SETTINGS],
        x,
        vectors,
        runs[RUN_C],
        varying,
        runs[RUN_CARRIED_F],
        live,
        block,
    )
    lane_step.expand(
        lane_functions, mode, live, m, first + guard_count, settings_i, runs[RUN_SETTINGS][places[0], REACH], block
    )
    lane_step.look_for_gaps(n, runs[RUN_SETTINGS][places[0], REACH], block)
    steps = block[BLOCK_H]
    for lane in range(count):
        p = places[lane]
        carried_f = runs[RUN_CARRIED_F][p]
        steps[lane] = _proven(
            functions,
            steps[lane],
            block[BLOCK_GAP][lane],
            settings_i,
            runs[RUN_SETTINGS][p],
            carried_f[TIME],
            runs[RUN_C][p],
            x[p],
            runs[RUN_CARRIED][p],
            carried_f,
            lane,
            block,
            scratch,
        )
    reach = block[BLOCK_REACH]
    for lane in range(count, LANES):
        reach[lane] = 0.0
    standing = (x, runs[RUN_CARRIED], runs[RUN_SIDES], runs[RUN_ARMED])
    lane_events.first_events(
        first,
        guard_count,
        watch[mode, 1:],
        marks[mode],
        order,
        count,
        places,
        standing,
        results,
        plan,
        block,
        scratch,
    )
    for lane in range(count):
        p = places[lane]
        h = steps[lane]
        te = reach[lane]
        results[lane, 0] = DONE
        if te == -2.0:
            results[lane, 0] = INVALID_START
        elif not h > SMALLEST_STEP * runs[RUN_CARRIED_F][p, LONGEST]:
            results[lane, 0] = STEP_UNDERFLOW if h == h else NONFINITE
        happens = te >= 0.0
        if not happens:
            te = h
        left = runs[RUN_SETTINGS][p, PERIOD] - runs[RUN_CARRIED_F][p, TIME]
        if runs[RUN_CARRIED][p, STROBES] + 1 >= runs[RUN_PROGRESS][p, GOAL] and te >= left:
            te = left
            happens = False
        reach[lane] = te
        if not happens:
            results[lane, 1] = -1
    lane_step.evaluate(first, live, m, block)
    for lane in range(count):
        if results[lane, 0] == DONE:
            p = places[lane]
            results[lane, 0] = _finish_step(
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
                reach[lane],
                steps[lane],
                results[lane, 1] >= 0,
                results[lane, 1],
                results[lane, 2],
                first,
                runs,
                row,
                block,
                scratch,
            )


@inlined
def _enqueue(queues, key, p):
    queue = queues[key]
    queue[2 + (queue[0] + queue[1]) % ACTIVE] = p
    queue[1] += 1


_signature = int64(
    *KERNEL_TYPES,
    *LANE_TYPES,
    *(integers, integers, integers, integer_matrix, integer_matrix, integer_matrix, integer_matrix, matrix),
    *(integers, integers, matrix, matrix, _runs),
    *(integer_matrix, integer_matrix, integer_matrix, matrix, matrix, _blocks, scratch_type),
)


@compiled(_signature)
def lane_flow(
    jet,
    jacobian_jet,
    tangent,
    field,
    variation,
    guard,
    transit,
    lane_jet,
    lane_jacobian_jet,
    lane_tangent,
    which,
    stretches,
    settings_i,
    watch,
    marks,
    transitions,
    pins,
    bounds,
    section,
    varying,
    shifts,
    frame,
    runs,
    queues,
    results,
    plan,
    row,
    spare,
    block,
    scratch,
):
    """As ``drive``, for the Taylor method; returns the number of steps.

    ``queues`` (keys, 2 + ACTIVE) hold the first place and the length of each, then a ring of runs; ``varying`` says
    which constants are not the same at all points; ``results`` (LANES + 1, LANES), ``plan`` (2 guards, LANES) and
    ``row``, one row of the event buffer, are scratch.
    """
    functions = (jet, jacobian_jet, tangent, field, variation, guard, transit)
    lane_functions = (lane_jet, lane_jacobian_jet, lane_tangent)
    tangents = frame.shape[0] + 1
    places = results[LANES]
    progress = runs[RUN_PROGRESS]
    carried = runs[RUN_CARRIED]
    outcome = runs[RUN_OUTCOME]
    image = scratch[IMAGE]
    under_way = 0
    begun = 0
    steps = 0
    while True:
        while under_way < ACTIVE and begun < which.size:
            p = which[begun]
            begun += 1
            _begin(p, runs, stretches)
            if outcome[p] == DONE and not _is_over(p, runs, frame, shifts, pins, stretches, image, spare):
                _enqueue(queues, carried[p, MODE] * tangents + carried[p, LIVE], p)
                under_way += 1
        if under_way == 0:
            return steps
        key = 0
        for k in range(1, queues.shape[0]):
            if queues[k, 1] > queues[key, 1]:
                key = k
        queue = queues[key]
        count = min(queue[1], LANES)
        for lane in range(LANES):
            # lanes without a run repeat the first one
            if lane < count:
                places[lane] = queue[2 + (queue[0] + lane) % ACTIVE]
            else:
                places[lane] = places[0]
        queue[0] = (queue[0] + count) % ACTIVE
        queue[1] -= count
        steps += count
        _step(
            functions,
            lane_functions,
            settings_i,
            watch,
            marks,
            transitions,
            bounds,
            varying,
            section,
            shifts,
            places,
            count,
            runs,
            results,
            plan,
            row,
            block,
            scratch,
        )
        for lane in range(count):
            p = places[lane]
            outcome[p] = results[lane, 0]
            at_goal = outcome[p] == DONE and carried[p, STROBES] >= progress[p, GOAL]
            if outcome[p] != DONE or (at_goal and _is_over(p, runs, frame, shifts, pins, stretches, image, spare)):
                under_way -= 1
            else:
                _enqueue(queues, carried[p, MODE] * tangents + carried[p, LIVE], p)
