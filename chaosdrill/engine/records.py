"""The types that compiled code has of what `chaosdrill.engine.layout` names, and when a run ends early."""

import math

import numba
from numba import float64, int64, types

from chaosdrill.codegen.signatures import block, matrix, vector
from chaosdrill.engine.jit import inlined, inner
from chaosdrill.engine.layout import (
    DONE,
    ESCAPED,
    NONFINITE,
    RUN,
    SETTINGS,
    Block,
    Results,
    Scratch,
    State,
    States,
    Tables,
)

SMALLEST_STEP = 1e-15
"""Shortest step, as a part of the longest one taken so far."""

LARGE_GROWTH = 1e4
"""Tangents are orthonormalised at once after an event that makes one this long."""

integers = int64[::1]
integer_matrix = int64[:, ::1]
cube = float64[:, :, ::1]
settings_record = numba.from_dtype(SETTINGS)
run_record = numba.from_dtype(RUN)
settings_type = types.Array(settings_record, 1, "C")

tables_type = types.NamedTuple((*[integer_matrix] * 7, matrix, matrix, integer_matrix), Tables)
states_type = types.NamedTuple(
    (
        *(types.Array(run_record, 1, "C"), matrix, matrix, matrix, cube, cube, integer_matrix, integer_matrix),
        *(matrix, integer_matrix, integer_matrix, matrix),
    ),
    States,
)
scratch_type = types.NamedTuple((matrix, vector, vector, matrix, matrix, *[vector] * 13, matrix), Scratch)
block_type = types.NamedTuple(
    (
        *(vector, matrix, matrix, block, block, matrix, matrix, matrix, vector, vector, matrix, matrix, matrix, vector),
        *(matrix, matrix, matrix, matrix, matrix, matrix, matrix),
    ),
    Block,
)
results_type = types.NamedTuple((integer_matrix, cube, cube, integers), Results)


@inlined
def state_of(states, p):
    """Run p of many."""
    return State(
        states.run[p : p + 1],
        states.c[p],
        states.x[p],
        states.scale[p],
        states.sums[p],
        states.vectors[p],
        states.slots[p],
        states.dead[p],
        states.logs[p],
        states.sides[p],
        states.counts[p],
        states.grazing[p],
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
