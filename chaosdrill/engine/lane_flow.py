"""Many runs of one system by the Taylor method, stepped eight at a time in lanes.

Runs that wait for their next step stand in queues, one for every mode and number of live tangents; eight of a queue are
stepped together, each with its own step, and go to the queue of the mode that they then are in. Events are taken one by
one by the functions of a single run. No number of a run depends on which others are stepped with it.
"""

from numba import void

from chaosdrill.codegen.signatures import KERNEL_TYPES, LANE_TYPES, matrix
from chaosdrill.engine import lane_events, lane_step, taylor
from chaosdrill.engine.jit import compiled, inlined
from chaosdrill.engine.lane_ends import finish_step
from chaosdrill.engine.lane_runs import (
    RUN_ARMED,
    RUN_C,
    RUN_CARRIED,
    RUN_CARRIED_F,
    RUN_OUTCOME,
    RUN_PROGRESS,
    RUN_SETTINGS,
    RUN_SIDES,
    RUN_VECTORS,
    RUN_X,
    begin,
    blocks_type,
    is_over,
    runs_type,
)
from chaosdrill.engine.lanes import LANES
from chaosdrill.engine.layout import (
    AFTER,
    BEFORE,
    BLOCK_GAP,
    BLOCK_H,
    BLOCK_OUT,
    BLOCK_REACH,
    BLOCK_WS,
    DONE,
    FRESH,
    GOAL,
    GRADIENT,
    IMAGE,
    INVALID_START,
    LIVE,
    LONGEST,
    MODE,
    NONFINITE,
    ONGOING,
    ORDER,
    OUT,
    PERIOD,
    PROVEN,
    REACH,
    STEP_UNDERFLOW,
    STROBES,
    TIME,
    WORKSPACE,
)
from chaosdrill.engine.limits import SMALLEST_STEP, integer_matrix, scratch_type
from chaosdrill.engine.stepper import integers

ACTIVE = 64
"""Runs under way at a time: enough to fill the lanes of every queue, few enough to stay in the cache."""


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
    unproven = taylor.has_unproven(marks[mode], guard_count)
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
        if unproven:
            lane_step.copy_lane(block[BLOCK_WS], 0, first + guard_count, lane, order, scratch[WORKSPACE])
            steps[lane] = taylor.proven_guards(
                functions[5],
                steps[lane],
                first,
                guard_count,
                marks[mode],
                runs[RUN_SETTINGS][p],
                carried_f[TIME],
                runs[RUN_C][p],
                x[p],
                runs[RUN_CARRIED][p],
                scratch[WORKSPACE],
                scratch[BEFORE],
                scratch[GRADIENT],
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
            results[lane, 0] = finish_step(
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


_signature = void(
    *KERNEL_TYPES,
    *LANE_TYPES,
    *(integers, integers, integers, integer_matrix, integer_matrix, integer_matrix, integer_matrix, matrix),
    *(integers, integers, matrix, matrix, runs_type),
    *(integer_matrix, integer_matrix, integer_matrix, matrix, matrix, blocks_type, scratch_type),
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
    """As ``drive``, for the Taylor method.

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
    while True:
        while under_way < ACTIVE and begun < which.size:
            p = which[begun]
            begun += 1
            begin(p, runs, stretches)
            if outcome[p] == DONE and not is_over(p, runs, frame, shifts, pins, stretches, image, spare):
                _enqueue(queues, carried[p, MODE] * tangents + carried[p, LIVE], p)
                under_way += 1
        if under_way == 0:
            return
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
            if outcome[p] != DONE or (at_goal and is_over(p, runs, frame, shifts, pins, stretches, image, spare)):
                under_way -= 1
            else:
                _enqueue(queues, carried[p, MODE] * tangents + carried[p, LIVE], p)
