"""The types that compiled code has of what `chaosdrill.engine.layout` names, and when a run ends early."""

import math

from chaosdrill.codegen.kinds import Array, NamedTuple, Pointer, RecordOf, Tuple, float64, int64, uint64, void
from chaosdrill.codegen.signatures import LANE_SIGNATURES, SIGNATURES, Functions, LaneFunctions, block, matrix, vector
from chaosdrill.engine.jit import at_address, inlined, inner
from chaosdrill.engine.layout import (
    DONE,
    ESCAPED,
    NONFINITE,
    RUN,
    SETTINGS,
    Block,
    Implicit,
    LaneRoom,
    Machine,
    Results,
    Scratch,
    State,
    States,
    Stepper,
    Tables,
)

SMALLEST_STEP = 1e-15
"""Shortest step, as a part of the longest one taken so far."""

LARGE_GROWTH = 1e4
"""Tangents are orthonormalised at once after an event that makes one this long."""

integers = int64[::1]
integer_matrix = int64[:, ::1]
cube = float64[:, :, ::1]
settings_record = RecordOf(SETTINGS)
run_record = RecordOf(RUN)
settings_type = Array(settings_record, 1)

tables_type = NamedTuple(
    (*[integer_matrix] * 8, matrix, matrix, integer_matrix, integers, vector, integer_matrix, cube), Tables
)
states_type = NamedTuple(
    (
        *(Array(run_record, 1), matrix, matrix, matrix, cube, cube, integer_matrix, integer_matrix),
        *(matrix, matrix, matrix, cube, integer_matrix, integer_matrix, *[matrix] * 5),
    ),
    States,
)
implicit_type = NamedTuple((matrix, cube, *[matrix] * 3, vector, matrix, *[integers] * 3), Implicit)
scratch_type = NamedTuple(
    (matrix, vector, vector, matrix, matrix, *[vector] * 13, matrix, matrix, implicit_type, vector, matrix), Scratch
)
block_type = NamedTuple(
    (
        *(vector, matrix, matrix, block, block, matrix, matrix, matrix, vector, vector, matrix, matrix, vector),
        *(block, *[matrix] * 3, vector, vector, *[matrix] * 6),
    ),
    Block,
)
results_type = NamedTuple((integer_matrix, cube, cube, matrix, cube, integers), Results)
lane_room_type = NamedTuple((integer_matrix, integer_matrix, matrix, matrix, block_type), LaneRoom)

STEPPER_SIGNATURES = {
    "expand": float64(int64, int64, float64),
    "locate": Tuple((float64, int64, int64))(int64, int64, float64, float64, float64),
    "evaluate": void(int64, int64, float64, float64),
    "advance": void(int64, int64, float64, float64),
}
"""Signatures of a method's functions, see ``engine.stepper``."""

SEARCH_SIGNATURE = Tuple((float64, int64, int64, float64))(int64, int64, float64, float64)
"""``first_event(place, p, h, t)``: time of it or -1, -2 for a start that is refused; guard; ties; length of the step"""

functions_type = NamedTuple((Pointer(name, s) for name, s in SIGNATURES.items()), Functions)
lane_functions_type = NamedTuple((Pointer(f"lane_{name}", s) for name, s in LANE_SIGNATURES.items()), LaneFunctions)
stepper_type = NamedTuple((Pointer(name, s) for name, s in STEPPER_SIGNATURES.items()), Stepper)
machine_type = NamedTuple(
    (
        functions_type,
        stepper_type,
        Pointer("search", SEARCH_SIGNATURE),
        settings_type,
        tables_type,
        states_type,
        scratch_type,
    ),
    Machine,
)

machine_at = at_address(machine_type)
"""The `Machine` at an address."""


@inlined
def state_of(states, p):
    """Run p of many."""
    # every array would look whether a number with a sign counts from its end
    k = uint64(p)
    return State(
        states.run[p : p + 1],
        states.c[k],
        states.x[k],
        states.scale[k],
        states.sums[k],
        states.vectors[k],
        states.exponent_of[k],
        states.lost[k],
        states.logs[k],
        states.grown[k],
        states.sooner[k],
        states.shares[k],
        states.sides[k],
        states.counts[k],
        states.grazing[k],
        states.hardest[k],
        states.extent[k],
        states.doubt[k],
        states.normal[k],
    )


@inner
def state_outcome(x, bounds):
    for i in range(x.size):
        if not math.isfinite(x[i]):
            return NONFINITE
    for i in range(x.size):
        if not bounds[0, i] <= x[i] <= bounds[1, i]:
            return ESCAPED
    return DONE


@inlined
def time_of(run):
    """The time at which a run stands."""
    return (run.origin + run.whole) + (run.rest + run.time)
