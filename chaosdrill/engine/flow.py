"""The engine: from event to event, tangents and all, for every system.

It is compiled once; a system enters as a tuple of functions of fixed signature. A call goes on until the number of
strobes asked for is reached, an output buffer is full, or the run cannot go on; all it needs to be continued is in its
arguments. A strobe falls once a period wherever the steps fall; only the last one of a call ends a step.
"""

import math

from numba import int64

from chaosdrill.codegen.signatures import KERNEL_TYPES, matrix, vector
from chaosdrill.engine import guards
from chaosdrill.engine.events import take
from chaosdrill.engine.jit import compiled
from chaosdrill.engine.layout import (
    ABSOLUTE_TIME,
    BASE,
    DONE,
    EVENT_LIMIT,
    EVENT_ROWS,
    EVENTS_IN_PERIOD,
    FRESH,
    FULL,
    IMAGE,
    INVALID_START,
    LONGEST,
    LOSES_RANK,
    MAX_EVENTS,
    METHOD,
    MODE,
    NONFINITE,
    ONGOING,
    ORDER,
    ORTHOGONALISE,
    PERIOD,
    QR_SINCE,
    QR_WAIT,
    QUADRATURES,
    RANK_CHECK,
    RECORD,
    RK4,
    SAMPLE_ROWS,
    SAMPLES,
    STALL,
    STALLED,
    STEP_UNDERFLOW,
    STEPS,
    STROBES,
    TARGET,
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
from chaosdrill.engine.step import advance, prepare, record
from chaosdrill.engine.stepper import STEPPER_TYPES, integers
from chaosdrill.engine.tangents import orthonormalise

SIGNATURE = int64(
    *KERNEL_TYPES,
    *STEPPER_TYPES,
    integers,
    vector,
    integer_matrix,
    integer_matrix,
    integer_matrix,
    vector,
    matrix,
    vector,
    matrix,
    matrix,
    matrix,
    integers,
    integers,
    vector,
    integers,
    vector,
    integers,
    integers,
    integers,
    vector,
    matrix,
    matrix,
    scratch_type,
)


@compiled(SIGNATURE)
def flow(
    jet,
    jacobian_jet,
    tangent,
    field,
    variation,
    guard,
    transit,
    expand,
    locate,
    evaluate,
    advance_by,
    settings_i,
    settings_f,
    watch,
    marks,
    transitions,
    c,
    bounds,
    x,
    sums,
    vectors,
    shifts,
    slots,
    dead,
    logs,
    carried,
    carried_f,
    sides,
    armed,
    counts,
    grazing,
    samples,
    events,
    scratch,
):
    """Continue a run; returns DONE, FULL, or the outcome that ended it."""
    functions = (jet, jacobian_jet, tangent, field, variation, guard, transit)
    stepper = (expand, locate, evaluate, advance_by)
    period = settings_f[PERIOD]
    series = settings_i[METHOD] != RK4
    first_guard = x.size + settings_i[QUADRATURES]
    while carried[STROBES] < settings_i[TARGET]:
        if settings_i[RECORD] == 1 and carried[SAMPLE_ROWS] + settings_i[SAMPLES] + 1 > samples.shape[0]:
            return FULL
        if events.shape[0] > 0 and carried[EVENT_ROWS] == events.shape[0]:
            return FULL
        local = carried_f[TIME]
        t = local + carried_f[BASE]
        mode = carried[MODE]
        h, te, j, ties = prepare(
            functions,
            stepper,
            settings_i,
            settings_f,
            watch,
            marks,
            local,
            t,
            c,
            x,
            vectors,
            carried,
            carried_f,
            sides,
            armed,
            scratch,
        )
        if te == -2.0:
            return INVALID_START
        if not h > SMALLEST_STEP * carried_f[LONGEST]:
            return STEP_UNDERFLOW if h == h else NONFINITE
        carried[FRESH] = ONGOING
        happens = te >= 0.0
        if not happens:
            te = h
        if carried[STROBES] + 1 >= settings_i[TARGET] and te >= period - local:
            te = period - local
            happens = False
        passed = carried[STROBES]
        strobe = record(functions, stepper, settings_i, settings_f, local, t, c, x, sums, te, carried, samples, scratch)
        advance(functions, stepper, settings_i, t, c, x, te, sums, vectors, carried, carried_f, scratch)
        if strobe >= 0.0:
            carried_f[TIME] = te - strobe
            if settings_i[ABSOLUTE_TIME] == 1:
                carried_f[BASE] += (carried[STROBES] - passed) * period
        else:
            carried_f[TIME] = local + te
        carried_f[LONGEST] = max(carried_f[LONGEST], te)
        if te > SMALLEST_STEP * carried_f[LONGEST]:
            carried[STALL] = 0
        elif happens:
            carried[STALL] += 1
        carried[STEPS] += 1
        carried[QR_SINCE] += 1
        outcome = state_outcome(x, bounds)
        if outcome != DONE:
            return outcome
        if series:
            guards.update_sides(
                scratch[WORKSPACE], first_guard, watch[mode, 1:], watch[mode, 0], settings_i[ORDER], te, sides, armed
            )
        if happens:
            if carried[STALL] > STALL_LIMIT:
                return STALLED
            carried[TIES] += ties
            if settings_i[ORTHOGONALISE] == 1 and marks[mode, j] & LOSES_RANK:
                orthonormalise(vectors, shifts, slots, dead, logs, carried, scratch[IMAGE])
            largest = take(
                functions,
                settings_f,
                transitions,
                j,
                carried_f[TIME],
                carried_f[TIME] + carried_f[BASE],
                c,
                x,
                vectors,
                carried,
                counts,
                grazing,
                events,
                scratch,
            )
            if carried[EVENTS_IN_PERIOD] > settings_i[MAX_EVENTS]:
                return EVENT_LIMIT
            if largest == math.inf:
                return NONFINITE
            if largest > LARGE_GROWTH:
                carried[QR_SINCE] = carried[QR_WAIT]
        if settings_i[ORTHOGONALISE] == 1 and (carried[RANK_CHECK] == 1 or carried[QR_SINCE] >= carried[QR_WAIT]):
            orthonormalise(vectors, shifts, slots, dead, logs, carried, scratch[IMAGE])
    if settings_i[ORTHOGONALISE] == 1:
        orthonormalise(vectors, shifts, slots, dead, logs, carried, scratch[IMAGE])
    return DONE
