"""States at given times along orbits."""

from numba import int64, void

from chaosdrill.codegen.signatures import KERNEL_TYPES, matrix, vector
from chaosdrill.engine.arc import follow
from chaosdrill.engine.jit import compiled
from chaosdrill.engine.lap import ARC_END, ARC_MODE, CLOCK, FORCED, MACHINE, ROOM, cube
from chaosdrill.engine.layout import BEFORE, BEGIN, FRESH, MODE, PERIOD
from chaosdrill.engine.limits import integer_matrix, scratch_type
from chaosdrill.engine.stepper import STEPPER_TYPES, integers

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
    functions = (jet, jacobian_jet, tangent, field, variation, guard, transit)
    stepper = (expand, locate, evaluate, advance_by)
    settings_i, settings_f, watch, asleep, marks, c, bounds = machine
    x, sums, vectors, carried, carried_f, sides, armed = room[:7]
    before = scratch[BEFORE]
    points, count, n = starts.shape
    for p in range(points):
        if sizes[CLOCK] >= 0:
            field(sizes[CLOCK], 0.0, c, starts[p, 0], before)
            settings_f[PERIOD] = before[0]
        period = settings_f[PERIOD]
        t = phases[p]
        passed = 0.0
        k = 0
        for i in range(count):
            for r in range(n):
                x[r] = starts[p, i, r]
            here = 0.0
            while k < instants.shape[1] and (i == count - 1 or instants[p, k] < passed + durations[p, i]):
                goal = min(instants[p, k] - passed, durations[p, i])
                carried[:] = 0
                carried[MODE] = arcs[i, ARC_MODE]
                carried[FRESH] = BEGIN
                follow(
                    functions,
                    stepper,
                    settings_i,
                    settings_f,
                    watch,
                    asleep,
                    marks,
                    t + here,
                    goal - here,
                    arcs[i, ARC_END],
                    False,
                    c,
                    bounds,
                    x,
                    sums,
                    vectors,
                    carried,
                    carried_f,
                    sides,
                    armed,
                    scratch,
                )
                here = goal
                for r in range(n):
                    states[p, k, r] = x[r]
                modes[p, k] = arcs[i, ARC_MODE]
                k += 1
            passed += durations[p, i]
            t += durations[p, i]
            if sizes[FORCED] == 1:
                t %= period
