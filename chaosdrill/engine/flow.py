"""The engine: from event to event, tangents and all, for every system.

It is compiled once; a system enters as functions of fixed signature. A call goes on until the number of strobes asked
for is reached, an output buffer is full, or the run cannot go on; all it needs to be continued is in the state. A
strobe falls once a period wherever the steps fall; only the last one of a call ends a step. An event that coincides
with a strobe or a sample comes after it.
"""

from chaosdrill.engine import fences, guards
from chaosdrill.engine import layout as at
from chaosdrill.engine.jit import compiled, in_frame, inlined
from chaosdrill.engine.records import FLOW_SIGNATURE, machine_at, state_of, state_outcome, time_of
from chaosdrill.engine.step import (
    advance,
    end_step,
    expand,
    instant_after,
    instant_in_row,
    locate,
    record,
    record_instants,
    stop,
    up_to_strobe,
)
from chaosdrill.engine.tangents import begin_tangents, orthonormalise
from chaosdrill.engine.tuning import STEPS


@inlined
def margin(functions, tables, settings, state, scratch, samples, row, j, te, h, t):
    """How far behind the root of guard j at te the next instant is, if the two coincide; else 0."""
    run = state.run[0]
    for place in range(run.sample_rows, samples.shape[0]):
        apart = instant_in_row(run, samples[place]) - te
        if apart > 0.0:
            ws = scratch.workspace
            if guards.coincides(functions, tables, settings, state, ws, row, j, te, te + apart, h, t, scratch):
                return apart
            return 0.0
    return 0.0


@compiled(FLOW_SIGNATURE, loops=False)
def flow(place, p, samples, events):
    """Continue run p; returns DONE, FULL, or the outcome that ended it.

    ``place`` is the address of the `chaosdrill.engine.layout.Machine`.
    """
    machine = in_frame(machine_at(place))
    functions, settings, tables, scratch = machine.functions, machine.settings[0], machine.tables, machine.scratch
    method = at.Method(machine.stepper, machine.search, place, place, p)
    state = state_of(machine.states, p)
    run = state.run[0]
    row = state.x.size + settings.quadratures
    begin_tangents(functions, tables, settings, state, scratch)
    while run.strobes < settings.target:
        if settings.recording == at.EVENLY and run.sample_rows + settings.samples + 1 > samples.shape[0]:
            return at.FULL
        if events.shape[0] > 0 and run.event_rows == events.shape[0]:
            return at.FULL
        t = time_of(run)
        h = expand(functions, method, tables, settings, t, state, scratch)
        te = -1.0
        j = -1
        ties = 0
        if settings.stepping != at.FIXED:
            # here it is no call: it would cost a twelfth of a step
            te, j, ties, h = guards.first_event(
                functions, tables, settings, state, scratch.workspace, row, h, t, scratch
            )
        te, j, ties, h = locate(functions, method, tables, settings, te, j, ties, h, t, state, scratch)
        if te == -2.0:
            return at.INVALID_START
        if not h > STEPS.smallest * run.longest:
            outcome = stop(functions, tables, settings, h, t, state, events, scratch)
            if outcome != at.DONE:
                return outcome
            continue
        happens = te >= 0.0
        if not happens:
            te = h
        early = late = 0.0
        if happens and settings.stepping != at.FIXED:
            if settings.recording == at.INSTANTS:
                late = margin(functions, tables, settings, state, scratch, samples, row, j, te, h, t)
            instant = instant_after(run, settings.samples, te)
            if guards.coincides(
                functions, tables, settings, state, scratch.workspace, row, j, te, instant, h, t, scratch
            ):
                early = instant - te
        te, happens = up_to_strobe(run, settings.target, te, early, happens)
        fence = -1
        if tables.fences.shape[0] > 0:
            te, fence = fences.up_to_escape(method, tables, settings, t, te, state, scratch)
            if fence >= 0:
                happens = False
                early = late = 0.0
        record_instants(method, settings, t, state, te, late, samples, scratch)
        strobe = record(method, settings, t, state, te, early, samples, scratch)
        advance(method, settings, t, state, te, scratch)
        # integrals whose series overflow are in no step
        outcome = state_outcome(state.x if settings.stepping == at.BY_SERIES else scratch.out, tables.bounds)
        if fence >= 0 and outcome == at.DONE:
            fences.put_beyond(tables, state, te, fence)
            outcome = at.ESCAPED
        j = j if happens else -1
        outcome = end_step(
            functions, tables, settings, te, strobe, j, ties, scratch.backs, outcome, state, events, scratch
        )
        if outcome != at.DONE:
            return outcome
    if settings.orthonormalise == 1:
        orthonormalise(functions, tables, state, scratch)
    return at.DONE
