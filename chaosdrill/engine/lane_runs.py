"""How far each run of a batch is, and its last section points, which are kept in a ring."""

import math

from chaosdrill.engine import layout as at
from chaosdrill.engine.jit import inlined, inner
from chaosdrill.engine.records import state_of
from chaosdrill.engine.revival import forget
from chaosdrill.engine.tangents import begin_tangents, log_growth, orthonormalise


@inner
def keep(row, first, n, mode, window, taken):
    """Put a state and its mode into the ring, in the place of the oldest if it is full."""
    place = window[taken % window.shape[0]]
    for i in range(n):
        place[i] = row[first + i]
    place[n] = mode


@inner
def bring_in_order(window, taken, spare):
    """Turn the ring so that the oldest point comes first."""
    size = window.shape[0]
    if taken <= size:
        return
    for k in range(size):
        for i in range(window.shape[1]):
            spare[k, i] = window[(taken + k) % size, i]
    for k in range(size):
        for i in range(window.shape[1]):
            window[k, i] = spare[k, i]


@inlined
def begin(p, machine, results, stretches):
    progress = results.progress[p]
    strobes = machine.states.run[p].strobes
    state = state_of(machine.states, p)
    begin_tangents(machine.functions, machine.tables, machine.settings[0], state, machine.scratch)
    progress[at.STAGE] = 0
    progress[at.TAKEN] = 0
    if progress[at.CELL] > 0:
        progress[at.LEFT] = stretches[0]
        progress[at.GOAL] = _next_look(progress, strobes)
    else:
        progress[at.LEFT] = -1
        progress[at.GOAL] = strobes + stretches[0]
        progress[at.LAST] = strobes + stretches.sum()
    results.growth[p, 0, :] = 0.0
    results.integrals[p, 0, :] = 0.0
    results.window[p, :, :] = math.nan


@inlined
def _next_look(progress, strobes):
    """The next whole multiple of the longest return, so that no step depends on the stretches."""
    return (strobes // progress[at.CELL] + 1) * progress[at.CELL]


@inlined
def at_goal(progress, run):
    """Whether a run stands where its stretch may end, or where it is looked at."""
    return progress[at.LEFT] == 0 or run.strobes >= progress[at.GOAL]


@inner
def _orthonormalise(m, machine, state):
    if m > 0:
        orthonormalise(machine.functions, machine.tables, state, machine.scratch)


@inlined
def _keep_frame(state, row):
    """Keep the tangents of a run, each before the number of its exponent."""
    n = state.vectors.shape[1]
    row[:] = 0.0
    for i in range(state.run[0].live):
        first = i * (n + 1)
        for a in range(n):
            row[first + a] = state.vectors[i, a]
        row[first + n] = state.exponent_of[i] + 1


@inner
def is_over(p, machine, results, frame, stretches, spare):
    """Note what a run has reached where it stands at a goal, until it has one ahead; whether there is none left."""
    progress = results.progress[p]
    state = state_of(machine.states, p)
    run = state.run[0]
    m = frame.shape[0]
    counts_points = progress[at.CELL] > 0
    if counts_points and run.strobes >= progress[at.GOAL]:
        _orthonormalise(m, machine, state)
        if progress[at.MET] < progress[at.GOAL] - progress[at.CELL]:
            results.outcome[p] = at.NO_RETURN
            return True
        progress[at.GOAL] = _next_look(progress, run.strobes)
    while at_goal(progress, run):
        _orthonormalise(m, machine, state)
        stage = progress[at.STAGE]
        if stage == 0:
            forget(state, frame, machine.tables.constrained)
            begin_tangents(machine.functions, machine.tables, machine.settings[0], state, machine.scratch)
        else:
            for i in range(m):
                results.growth[p, stage, i] = -math.inf if state.lost[i] == 1 else log_growth(state, i)
            for i in range(state.sums.shape[1]):
                results.integrals[p, stage, i] = state.sums[0, i] + state.sums[1, i]
        _keep_frame(state, results.frames[p, stage])
        results.times[p, stage] = run.strobes * run.period + run.time
        if stage == stretches.size - 1:
            bring_in_order(results.window[p], progress[at.TAKEN], spare)
            return True
        progress[at.STAGE] = stage + 1
        if counts_points:
            progress[at.LEFT] = stretches[stage + 1]
        else:
            progress[at.GOAL] += stretches[stage + 1]
    return False


@inlined
def note_section(p, run, tables, section, row, results, n, mode):
    """Count an event of the section, which ``row`` holds if there was one, and keep the state before or after it."""
    if run.event_rows > 0:
        run.event_rows = 0
        progress = results.progress[p]
        kind = int(row[0, at.EVENT_KIND])
        if section[kind] > 0:
            progress[at.MET] = int(row[0, at.EVENT_STROBES])
            progress[at.LEFT] -= 1
            if progress[at.STAGE] > 0 and results.window.shape[1] > 0:
                first = at.EVENT_COLUMNS
                if section[kind] == at.BEHIND:
                    first += n
                    mode = tables.transitions[kind, at.TO_MODE]
                keep(row[0], first, n, mode, results.window[p], progress[at.TAKEN])
                progress[at.TAKEN] += 1
