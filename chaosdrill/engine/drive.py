"""Many runs of one system, one after the other: a transient, then averages and a window of the section."""

import warnings

from numba import float64, int64, types, void
from numba.core.errors import NumbaExperimentalFeatureWarning

from chaosdrill.codegen.signatures import KERNEL_TYPES, matrix
from chaosdrill.engine import flow as engine
from chaosdrill.engine.jit import compiled
from chaosdrill.engine.layout import (
    DONE,
    EVENT_COLUMNS,
    EVENT_KIND,
    EVENT_MODE,
    EVENT_ROWS,
    FULL,
    RECORD,
    SAMPLE_ROWS,
    STAGES,
    STROBES,
    TARGET,
    WORKSPACE,
)
from chaosdrill.engine.revival import forget
from chaosdrill.engine.stepper import STEPPER_TYPES, integers
from chaosdrill.engine.window import bring_in_order, keep

with warnings.catch_warnings():
    warnings.simplefilter("ignore", NumbaExperimentalFeatureWarning)
    _flow = types.FunctionType(engine.SIGNATURE)

_cube = float64[:, :, ::1]
_table = int64[:, ::1]

_signature = void(
    _flow,
    *KERNEL_TYPES,
    *STEPPER_TYPES,
    *(integers, integers, integers, matrix, _table, _table, _table, _table, matrix),
    *(matrix, matrix, _cube, matrix, _cube, matrix, _table, _table, matrix),
    *(_table, matrix, _table, _table, _table, matrix),
    *(integers, _cube, _cube, matrix, matrix, integers, matrix, engine.scratch_type),
)


@compiled(_signature)
def drive(
    flow,
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
    which,
    stretches,
    settings_i,
    settings_f,
    watch,
    marks,
    transitions,
    pins,
    constants,
    bounds,
    x,
    sums,
    shifts,
    vectors,
    frame,
    slots,
    dead,
    logs,
    carried,
    carried_f,
    sides,
    armed,
    counts,
    grazing,
    outcome,
    growth,
    windows,
    samples,
    events,
    section,
    spare,
    scratch,
):
    """Run the points ``which`` over a transient, ``stretches[0]`` periods, then over the other stretches.

    ``growth[p, b]`` gets the sums of logarithms up to the end of stretch b, -inf for tangents that are lost;
    ``windows[p]`` the last section points: at the strobe, or before the transitions that ``section`` marks.
    """
    n = x.shape[1]
    m = vectors.shape[1]
    size = windows.shape[1]
    at_events = section.size > 0
    total = stretches[1:].sum()
    for k in range(which.size):
        p = which[k]
        growth[p, 0, :] = 0.0
        windows[p, :, :] = float("nan")
        scratch[WORKSPACE][:, :] = 0.0
        scratch[STAGES][:, :] = 0.0
        taken = 0
        done = 0
        for s in range(stretches.size):
            if outcome[p] != DONE:
                break
            done += stretches[s] if s > 0 else 0
            kept = s > 0 and size > 0 and (at_events or done > total - size)
            settings_i[TARGET] = carried[p, STROBES] + stretches[s]
            settings_i[RECORD] = int64(kept and not at_events)
            rows = samples if kept and not at_events else samples[:0]
            table = events if kept and at_events else events[:0]
            code = FULL
            while code == FULL:
                carried[p, SAMPLE_ROWS] = 0
                carried[p, EVENT_ROWS] = 0
                code = flow(
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
                    settings_f[p],
                    watch,
                    marks,
                    transitions,
                    constants[p],
                    bounds,
                    x[p],
                    sums[p],
                    vectors[p],
                    shifts,
                    slots[p],
                    dead[p],
                    logs[p],
                    carried[p],
                    carried_f[p],
                    sides[p],
                    armed[p],
                    counts[p],
                    grazing[p],
                    rows,
                    table,
                    scratch,
                )
                for i in range(carried[p, SAMPLE_ROWS]):
                    keep(samples[i], 0, n, samples[i, samples.shape[1] - 1], windows[p], taken)
                    taken += 1
                for i in range(carried[p, EVENT_ROWS]):
                    if section[int64(events[i, EVENT_KIND])] == 1:
                        keep(events[i], EVENT_COLUMNS, n, events[i, EVENT_MODE], windows[p], taken)
                        taken += 1
            outcome[p] = code
            if s > 0:
                for i in range(m):
                    growth[p, s, i] = -float("inf") if dead[p, i] == 1 else logs[p, i]
                continue
            forget(frame, pins, vectors[p], slots[p], dead[p], logs[p], sums[p], counts[p], grazing[p], carried[p])
        bring_in_order(windows[p], taken, spare)
