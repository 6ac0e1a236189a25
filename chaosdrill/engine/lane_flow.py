"""Many runs of one system by the Taylor method, stepped eight at a time in lanes.

Runs that wait for their next step stand in queues, one for every mode and number of live tangents; eight of a queue are
stepped together, each with its own step, and go to the queue of the mode that they then are in. Events are taken one by
one by the functions of a single run. No number of a run depends on which others are stepped with it.
"""

from chaosdrill.codegen.kinds import int64, uint64, void
from chaosdrill.codegen.signatures import WIDTH, integers, matrix
from chaosdrill.engine import fences, lane_events, lane_step, taylor
from chaosdrill.engine import layout as at
from chaosdrill.engine.checked import first_row
from chaosdrill.engine.jit import compiled, in_frame, inlined, rare
from chaosdrill.engine.lane_events import GUARD, OUTCOME, TIES
from chaosdrill.engine.lane_runs import at_goal, begin, is_over, keep, note_section
from chaosdrill.engine.lanes import LANES, chosen, every, row_of
from chaosdrill.engine.polynomial import lane_value
from chaosdrill.engine.records import (
    lane_functions_type,
    lane_room_type,
    machine_at,
    results_type,
    state_of,
    state_outcome,
    within,
)
from chaosdrill.engine.step import add_to, end_step, instant_after, pass_strobe, stop, up_to_strobe
from chaosdrill.engine.tuning import LANE, STEPS

_STOPPED = -2
"""In the place of a guard: the step of this lane had no length, and what comes of that has been done."""
_ESCAPED = -3
"""Likewise: a state leaves its bounds in this lane; beyond which of them stands in the place of the ties."""


@rare
def _settled(functions, tables, settings, lane, state, block, scratch):
    """The step of one lane, one of few, made to count as that of a run alone."""
    sure, held, plain = block.gap[0, lane] > 0.0, block.gap[1, lane] > 0.0, block.gap[2, lane] > 0.0
    h, ws, run = block.h[lane], scratch.workspace, state.run[0]
    if h != h or (sure and held and plain):
        return h
    count = block.out.shape[0] + tables.active[run.mode, 0]
    lane_step.copy_lane(block.ws, 0, count, lane, settings.order, ws)
    own = first_row(ws, state.vectors, 0)
    lane_step.copy_lane(block.ws, own, run.live * state.x.size, lane, settings.order, ws[own:])
    return taylor.settled(functions, tables, settings, h, block.t[lane], state, scratch, sure, plain)


@inlined
def _pass_strobes(settings, p, lane, run, results, strobed, te, early, block, out):
    """Count the strobes that fall into the step, with their states; returns the time of the last one in it, or -1."""
    s = run.period - run.time
    strobe = -1.0
    while s <= te + early:
        pass_strobe(settings, run)
        progress = results.progress[p]
        if strobed and progress[at.STAGE] > 0 and progress[at.LAST] - run.strobes < results.window.shape[1]:
            n = block.x.shape[0]
            for i in range(n):
                out[i] = lane_value(block.ws[i, :, lane], WIDTH - 1, min(s, te))
            keep(out, 0, n, run.mode, results.window[p], progress[at.TAKEN])
            progress[at.TAKEN] += 1
        strobe = s
        s += run.period
    return strobe


@inlined
def _move(lane, live, state, block):
    """Take over the state, the tangents and the integrals of one lane."""
    n = state.x.size
    for i in range(n):
        state.x[i] = block.out[i, lane]
    for v in range(live):
        for i in range(n):
            state.vectors[v, i] = block.v[v, i, lane]
    for i in range(n, block.out.shape[0]):
        add_to(state.sums, i - n, block.out[i, lane])


@inlined
def _end_at_bounds(tables, settings, states, places, count, ends, block, scratch):
    """Let the steps in which a state leaves its bounds end there."""
    fences.near_in_lanes(tables, block)
    for lane in range(count):
        if block.gap[1, lane] == 0.0 or ends[lane, OUTCOME] != at.DONE or ends[lane, GUARD] == _STOPPED:
            continue
        state = state_of(states, places[lane])
        lane_step.copy_lane(block.ws, 0, state.x.size, lane, settings.order, scratch.workspace)
        s, which = fences.first_escape(tables, settings, state, block.reach[lane], scratch)
        if which >= 0:
            block.reach[lane] = s
            block.gap[0, lane] = 0.0
            ends[lane, GUARD] = _ESCAPED
            ends[lane, TIES] = which


@inlined
def _step(machine, place, lane_functions, results, section, varying, places, count, room):
    """One step of up to eight runs of one mode and number of live tangents; ``ends`` says how each stands then."""
    functions, settings, tables = machine.functions, machine.settings[0], machine.tables
    states, scratch = machine.states, machine.scratch
    ends, row, block = room.ends, room.row, room.block
    n = states.x.shape[1]
    mode = states.run[places[0]].mode
    live = states.run[places[0]].live
    guard_count = tables.active[mode, 0]
    first = block.out.shape[0]
    lane_step.gather(places, live, states, varying, block)
    sure, held, plain = lane_step.expand(lane_functions, mode, live, tables, settings, block, scratch.polynomial)
    for lane in range(count):
        state = state_of(states, places[lane])
        for i in range(n):
            state.scale[i] = block.scale[i, lane]
        for i in range(block.span.shape[0]):
            state.span[i] = block.span[i, lane]
    if not every(sure & held & plain):
        gaps = row_of(block.gap)
        gaps[0] = chosen(sure, 1.0, 0.0)
        gaps[1] = chosen(held, 1.0, 0.0)
        gaps[2] = chosen(plain, 1.0, 0.0)
        for lane in range(count):
            state = state_of(states, places[lane])
            block.h[lane] = _settled(functions, tables, settings, lane, state, block, scratch)
    for lane in range(count, LANES):
        block.reach[lane] = 0.0
    lane_events.first_events(machine, place, settings, mode, count, places, first, ends, block)
    for lane in range(count):
        p = places[lane]
        run = states.run[p]
        h = block.h[lane]
        te = block.reach[lane]
        j = ends[lane, GUARD]
        ends[lane, OUTCOME] = at.DONE
        if te == -2.0:
            ends[lane, OUTCOME] = at.INVALID_START
        elif not h > STEPS.smallest * run.longest:
            state = state_of(states, p)
            ends[lane, OUTCOME] = stop(functions, tables, settings, h, block.t[lane], state, row, scratch)
            note_section(p, state.run[0], tables, section, row, results, n, mode)
            ends[lane, GUARD] = _STOPPED
            block.reach[lane] = 0.0
            continue
        happens = te >= 0.0
        if not happens:
            te = h
        block.gap[0, lane] = 0.0
        if happens:
            state = state_of(states, p)
            rest = run.period - run.time
            instant = rest if te < rest else instant_after(run, 1, te)
            if lane_events.coincides(functions, tables, settings, state, first, j, te, instant, lane, block, scratch):
                block.gap[0, lane] = instant - te
        te, happens = up_to_strobe(run, results.progress[p, at.GOAL], te, block.gap[0, lane], happens)
        block.reach[lane] = te
        if not happens:
            ends[lane, GUARD] = -1
    if tables.fences.shape[0] > 0:
        _end_at_bounds(tables, settings, states, places, count, ends, block, scratch)
    lane_step.evaluate(first, live, settings.order, block)
    row_of(block.gap)[1] = chosen(within(row_of(block.out), n, tables.bounds), 0.0, 1.0)
    strobed = section.size == 0 and results.window.shape[1] > 0
    for lane in range(count):
        if ends[lane, OUTCOME] != at.DONE or ends[lane, GUARD] == _STOPPED:
            continue
        p = places[lane]
        state = state_of(states, p)
        te = block.reach[lane]
        j = ends[lane, GUARD]
        early = block.gap[0, lane]
        strobe = _pass_strobes(settings, p, lane, state.run[0], results, strobed, te, early, block, scratch.out)
        _move(lane, live, state, block)
        if state.run[0].turning == 1:
            for k in range(guard_count):
                scratch.backs[k] = block.backs[k, lane]
        outcome = state_outcome(state.x, tables.bounds) if block.gap[1, lane] != 0.0 else at.DONE
        if j == _ESCAPED and outcome == at.DONE:
            fences.put_beyond(tables, state, te, ends[lane, TIES])
            outcome = at.ESCAPED
        ends[lane, OUTCOME] = end_step(
            functions, tables, settings, te, strobe, j, ends[lane, TIES], scratch.backs, outcome, state, row, scratch
        )
        note_section(p, state.run[0], tables, section, row, results, n, mode)


@inlined
def _enqueue(queues, key, p):
    queue = queues[key]
    queue[2 + uint64(queue[0] + queue[1]) % uint64(LANE.active)] = p
    queue[1] += 1


@compiled(
    void(
        *(int64, lane_functions_type, integers, integers, results_type, matrix), *(integers, integers, lane_room_type)
    ),
    loops=False,
)
def lane_flow(place, lane_functions, which, stretches, results, frame, section, varying, room):
    """Run the points ``which`` over a transient, ``stretches[0]`` strobes or points, then over the other stretches.

    ``place`` is the address of the `chaosdrill.engine.layout.Machine`. ``results.growth[p, b]`` gets the sums of
    logarithms up to the end of stretch b, -inf for tangents that are lost; ``results.window[p]`` the last section
    points: at the strobe, or before or after the transitions that ``section`` marks. ``varying`` says which constants
    are not the same at all points.
    """
    machine = in_frame(machine_at(place))
    states = machine.states
    queues, ends, spare = room.queues, room.ends, room.spare
    tangents = frame.shape[0] + 1
    places = ends[LANES]
    outcome = results.outcome
    under_way = 0
    begun = 0
    while True:
        while under_way < LANE.active and begun < which.size:
            p = which[begun]
            begun += 1
            begin(p, machine, results, stretches)
            if outcome[p] == at.DONE and not is_over(p, machine, results, frame, stretches, spare):
                _enqueue(queues, states.run[p].mode * tangents + states.run[p].live, p)
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
                places[lane] = queue[2 + (queue[0] + lane) % LANE.active]
            else:
                places[lane] = places[0]
        queue[0] = (queue[0] + count) % LANE.active
        queue[1] -= count
        _step(machine, place, lane_functions, results, section, varying, places, count, room)
        for lane in range(count):
            p = places[lane]
            run = states.run[p]
            outcome[p] = ends[lane, OUTCOME]
            if outcome[p] != at.DONE or (
                at_goal(results.progress[p], run) and is_over(p, machine, results, frame, stretches, spare)
            ):
                under_way -= 1
            else:
                _enqueue(queues, run.mode * tangents + run.live, p)
