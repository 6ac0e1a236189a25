"""Many runs of one system, one after the other: a transient, then averages and a window of the section."""

import warnings

from numba import types, void
from numba.core.errors import NumbaExperimentalFeatureWarning

from chaosdrill.codegen.signatures import KERNEL_TYPES, matrix
from chaosdrill.engine import flow as engine
from chaosdrill.engine.jit import compiled
from chaosdrill.engine.layout import DONE, EVENT_COLUMNS, EVENT_KIND, EVENT_MODE, FULL
from chaosdrill.engine.records import (
    integers,
    results_type,
    scratch_type,
    settings_type,
    state_of,
    states_type,
    tables_type,
)
from chaosdrill.engine.revival import forget
from chaosdrill.engine.stepper import STEPPER_TYPES
from chaosdrill.engine.window import bring_in_order, keep

with warnings.catch_warnings():
    warnings.simplefilter("ignore", NumbaExperimentalFeatureWarning)
    _flow = types.FunctionType(engine.SIGNATURE)

_signature = void(
    _flow,
    *KERNEL_TYPES,
    *STEPPER_TYPES,
    *(integers, integers, settings_type, tables_type, states_type, results_type),
    *(matrix, matrix, matrix, integers, matrix, scratch_type),
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
    guard_error,
    transit,
    expand,
    locate,
    evaluate,
    advance_by,
    which,
    stretches,
    settings,
    tables,
    states,
    results,
    frame,
    samples,
    events,
    section,
    spare,
    scratch,
):
    """Run the points ``which`` over a transient, ``stretches[0]`` periods, then over the other stretches.

    ``results.growth[p, b]`` gets the sums of logarithms up to the end of stretch b, -inf for tangents that are lost;
    ``results.window[p]`` the last section points: at the strobe, or before the transitions that ``section`` marks.
    """
    n = states.x.shape[1]
    m = states.vectors.shape[1]
    at_events = section.size > 0
    total = stretches[1:].sum()
    for k in range(which.size):
        p = which[k]
        state = state_of(states, p)
        run = state.run[0]
        window = results.window[p]
        size = window.shape[0]
        results.growth[p, 0, :] = 0.0
        window[:, :] = float("nan")
        scratch.workspace[:, :] = 0.0
        scratch.stages[:, :] = 0.0
        taken = 0
        done = 0
        for s in range(stretches.size):
            if results.outcome[p] != DONE:
                break
            done += stretches[s] if s > 0 else 0
            kept = s > 0 and size > 0 and (at_events or done > total - size)
            settings[0].target = run.strobes + stretches[s]
            settings[0].recording = 1 if kept and not at_events else 0
            rows = samples if kept and not at_events else samples[:0]
            table = events if kept and at_events else events[:0]
            code = FULL
            while code == FULL:
                run.sample_rows = 0
                run.event_rows = 0
                code = flow(
                    jet,
                    jacobian_jet,
                    tangent,
                    field,
                    variation,
                    guard,
                    guard_error,
                    transit,
                    expand,
                    locate,
                    evaluate,
                    advance_by,
                    settings,
                    tables,
                    states,
                    p,
                    rows,
                    table,
                    scratch,
                )
                for i in range(run.sample_rows):
                    keep(samples[i], 0, n, samples[i, samples.shape[1] - 1], window, taken)
                    taken += 1
                for i in range(run.event_rows):
                    if section[int(events[i, EVENT_KIND])] == 1:
                        keep(events[i], EVENT_COLUMNS, n, events[i, EVENT_MODE], window, taken)
                        taken += 1
            results.outcome[p] = code
            if s > 0:
                for i in range(m):
                    results.growth[p, s, i] = -float("inf") if state.dead[i] == 1 else state.logs[i]
                continue
            forget(state, frame, tables.pins)
        bring_in_order(window, taken, spare)
