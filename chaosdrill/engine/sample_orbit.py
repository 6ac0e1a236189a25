"""States at given times along orbits."""

from chaosdrill.codegen.kinds import int64, void
from chaosdrill.codegen.signatures import cube, integer_matrix, integers, matrix, vector
from chaosdrill.engine.jit import compiled
from chaosdrill.engine.layout import Method
from chaosdrill.engine.records import machine_at, state_of
from chaosdrill.engine.segment import begin, follow
from chaosdrill.engine.shooting import CLOCK, FORCED, SEGMENT_END, SEGMENT_MODE

SIGNATURE = void(*(int64, int64, integers, integer_matrix, cube, vector, matrix, matrix, cube, integer_matrix))


@compiled(SIGNATURE)
def sample_orbit(place, resting, sizes, segments, starts, phases, durations, instants, states, modes):
    """States (P, K, d + q) and modes (P, K) of P orbits of the same segments at times since their starts.

    ``instants`` (P, K) rise along every row, from 0 on. One at which an event falls shows the state after it; one that
    lies behind the end of the orbit shows the end of its last segment.
    """
    machine = machine_at(place)
    functions, settings, tables, scratch = machine.functions, machine.settings[0], machine.tables, machine.scratch
    asleep = machine_at(resting).tables
    method = Method(machine.stepper, machine.search, place, resting, 0)
    state = state_of(machine.states, 0)
    run, x = state.run[0], state.x
    before = scratch.before
    points, count, n = starts.shape
    for p in range(points):
        if sizes[CLOCK] >= 0:
            functions.field(sizes[CLOCK], 0.0, state.c, starts[p, 0], before)
            run.period = before[0]
        period = run.period
        t = phases[p]
        passed = 0.0
        k = 0
        for i in range(count):
            for r in range(n):
                x[r] = starts[p, i, r]
            here = 0.0
            while k < instants.shape[1] and (i == count - 1 or instants[p, k] < passed + durations[p, i]):
                goal = min(instants[p, k] - passed, durations[p, i])
                begin(tables, state, segments[i, SEGMENT_MODE], 0, 0, -1, -1)
                follow(
                    functions, method, settings, tables, asleep, t + here, goal - here, segments[i, SEGMENT_END],
                    False, state, scratch
                )  # fmt: skip
                here = goal
                for r in range(n):
                    states[p, k, r] = x[r]
                modes[p, k] = segments[i, SEGMENT_MODE]
                k += 1
            passed += durations[p, i]
            t += durations[p, i]
            if sizes[FORCED] == 1:
                t %= period
