"""Maps, which stand still between their iterates: what ends their steps is known, and no series is expanded.

An iterate is three steps, to the event, behind it and to the strobe, that end as those of all systems do: their record
is that of `flow` to the bit.
"""

from chaosdrill.codegen.kinds import int64, void
from chaosdrill.codegen.signatures import integers, matrix
from chaosdrill.engine import layout as at
from chaosdrill.engine import scales
from chaosdrill.engine.jit import compiled, inlined
from chaosdrill.engine.lane_runs import at_goal, begin, is_over, keep, note_section
from chaosdrill.engine.records import FLOW_SIGNATURE, machine_at, results_type, state_of, state_outcome
from chaosdrill.engine.step import end_step, pass_strobe
from chaosdrill.engine.tangents import begin_tangents, orthonormalise
from chaosdrill.engine.tuning import STEPS


@inlined
def _next(settings, run):
    """Where in the period the next step ends, which begins where another one has ended."""
    if run.time < 0.5 * settings.phase:
        return settings.phase
    return STEPS.behind if run.time < 0.5 else 1.0


@inlined
def _end(functions, tables, settings, end, state, buffer, scratch):
    """What follows at the end of a step, whose strobe has been counted: as ``end_step``, see there."""
    run, x = state.run[0], state.x
    least = scales.finest(settings.tolerance)
    for i in range(x.size):
        state.scale[i] = scales.brought(state.scale[i], x[i], least)
    te = end - run.time
    j = -1
    if end == settings.phase:
        j = 0
        run.evaluations += 1
    elif end == 1.0:
        # on the way from the event the guard has come back
        state.sides[0] = -tables.active[0, 1]
    run.turning = 0
    outcome = state_outcome(x, tables.bounds)
    strobe = te if end == 1.0 else -1.0
    return end_step(functions, tables, settings, te, strobe, j, 0, scratch.backs, outcome, state, buffer, scratch)


@compiled(FLOW_SIGNATURE)
def iterate(place, p, samples, events):
    """As `flow`, for run p of a map."""
    machine = machine_at(place)
    functions, settings, tables, scratch = machine.functions, machine.settings[0], machine.tables, machine.scratch
    state = state_of(machine.states, p)
    run, x = state.run[0], state.x
    begin_tangents(functions, tables, settings, state, scratch)
    while run.strobes < settings.target:
        if settings.recording == at.EVENLY and run.sample_rows + 2 > samples.shape[0]:
            return at.FULL
        if events.shape[0] > 0 and run.event_rows == events.shape[0]:
            return at.FULL
        end = _next(settings, run)
        if end == 1.0:
            if settings.recording == at.EVENLY:
                keep(x, 0, x.size, run.mode, samples, run.sample_rows)
                run.sample_rows += 1
            pass_strobe(settings, run)
        outcome = _end(functions, tables, settings, end, state, events, scratch)
        if outcome != at.DONE:
            return outcome
    if settings.orthonormalise == 1:
        orthonormalise(functions, tables, state, scratch)
    return at.DONE


@compiled(void(int64, integers, integers, results_type, matrix, integers, matrix, matrix))
def iterate_runs(place, which, stretches, results, frame, section, row, spare):
    """As `chaosdrill.engine.lane_flow.lane_flow`, for runs of a map, one after the other."""
    machine = machine_at(place)
    functions, settings, tables, scratch = machine.functions, machine.settings[0], machine.tables, machine.scratch
    window, outcome = results.window, results.outcome
    strobed = section.size == 0 and window.shape[1] > 0
    for k in range(which.size):
        p = which[k]
        state, progress = state_of(machine.states, p), results.progress[p]
        run, x = state.run[0], state.x
        begin(p, machine, results, stretches)
        while outcome[p] == at.DONE and not (
            at_goal(progress, run) and is_over(p, machine, results, frame, stretches, spare)
        ):
            end = _next(settings, run)
            if end == 1.0:
                pass_strobe(settings, run)
                if strobed and progress[at.STAGE] > 0 and progress[at.LAST] - run.strobes < window.shape[1]:
                    keep(x, 0, x.size, run.mode, window[p], progress[at.TAKEN])
                    progress[at.TAKEN] += 1
            mode = run.mode
            outcome[p] = _end(functions, tables, settings, end, state, row, scratch)
            note_section(p, run, tables, section, row, results, x.size, mode)
