"""States at given times along orbits."""

from numba import int64, void

from chaosdrill.codegen.signatures import KERNEL_TYPES, matrix, vector
from chaosdrill.engine.arc import begin, follow
from chaosdrill.engine.jit import compiled
from chaosdrill.engine.lap import ARC_END, ARC_MODE, CLOCK, FORCED, MACHINE, ROOM, cube
from chaosdrill.engine.layout import Functions, Stepper
from chaosdrill.engine.records import integer_matrix, integers, scratch_type, state_of
from chaosdrill.engine.stepper import STEPPER_TYPES

SIGNATURE = void(
    *KERNEL_TYPES,
    *STEPPER_TYPES,
    *(MACHINE, integers, integer_matrix, cube, vector, matrix),
    *(matrix, cube, int64[:, ::1], ROOM, scratch_type),
)


@compiled(SIGNATURE)
def walk(
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
    machine,
    sizes,
    arcs,
    starts,
    phases,
    durations,
    instants,
    states,
    modes,
    room,
    scratch,
):
    """States (P, K, d + q) and modes (P, K) of P orbits of the same arcs at times since their starts.

    ``instants`` (P, K) rise along every row, from 0 on. One at which an event falls shows the state after it; one that
    lies behind the end of the orbit shows the end of its last arc.
    """
    functions = Functions(jet, jacobian_jet, tangent, field, variation, guard, guard_error, transit)
    stepper = Stepper(expand, locate, evaluate, advance_by)
    all_settings, tables, asleep = machine
    settings = all_settings[0]
    state = state_of(room[0], 0)
    run, x = state.run[0], state.x
    before = scratch.before
    points, count, n = starts.shape
    for p in range(points):
        if sizes[CLOCK] >= 0:
            field(sizes[CLOCK], 0.0, state.c, starts[p, 0], before)
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
                begin(tables, state, arcs[i, ARC_MODE], 0, 0, -1, -1)
                follow(
                    functions, stepper, settings, tables, asleep, t + here, goal - here, arcs[i, ARC_END], False, state,
                    scratch,
                )  # fmt: skip
                here = goal
                for r in range(n):
                    states[p, k, r] = x[r]
                modes[p, k] = arcs[i, ARC_MODE]
                k += 1
            passed += durations[p, i]
            t += durations[p, i]
            if sizes[FORCED] == 1:
                t %= period
