"""The arrays of many runs that are stepped in lanes: their places and their types, and how far each run is."""

import math

from numba import types

from chaosdrill.codegen.signatures import block, matrix, vector
from chaosdrill.engine.jit import inlined, inner
from chaosdrill.engine.layout import (
    GOAL,
    LAST,
    STAGE,
    STROBES,
    TAKEN,
)
from chaosdrill.engine.limits import integer_matrix
from chaosdrill.engine.revival import forget
from chaosdrill.engine.stepper import integers
from chaosdrill.engine.tangents import orthonormalise
from chaosdrill.engine.window import bring_in_order

blocks_type = types.Tuple(
    (
        *(vector, matrix, matrix, block, block, vector, vector, matrix, vector, matrix, vector),
        *(matrix, matrix, matrix, matrix, matrix, matrix),
    )
)  # in the order of BLOCK_...
runs_type = types.Tuple(
    (
        *(matrix, matrix, matrix, block, block, integer_matrix, integer_matrix, matrix, integer_matrix, matrix),
        *(integer_matrix, integer_matrix, integer_matrix, matrix, integer_matrix, block, block, integers),
    )
)  # in the order of RUN_...
(
    RUN_SETTINGS,
    RUN_C,
    RUN_X,
    RUN_SUMS,
    RUN_VECTORS,
    RUN_SLOTS,
    RUN_DEAD,
    RUN_LOGS,
    RUN_CARRIED,
    RUN_CARRIED_F,
    RUN_SIDES,
    RUN_ARMED,
    RUN_COUNTS,
    RUN_GRAZING,
    RUN_PROGRESS,
    RUN_GROWTH,
    RUN_WINDOW,
    RUN_OUTCOME,
) = range(18)


@inlined
def begin(p, runs, stretches):
    progress = runs[RUN_PROGRESS][p]
    strobes = runs[RUN_CARRIED][p, STROBES]
    progress[STAGE] = 0
    progress[GOAL] = strobes + stretches[0]
    progress[LAST] = strobes + stretches.sum()
    progress[TAKEN] = 0
    runs[RUN_GROWTH][p, 0, :] = 0.0
    runs[RUN_WINDOW][p, :, :] = math.nan


@inner
def is_over(p, runs, frame, shifts, pins, stretches, image, spare):
    """Note what a run has reached where it stands at a goal, until it has one ahead; whether there is none left."""
    progress = runs[RUN_PROGRESS][p]
    carried = runs[RUN_CARRIED][p]
    m = frame.shape[0]
    while carried[STROBES] >= progress[GOAL]:
        if m > 0:
            orthonormalise(
                runs[RUN_VECTORS][p],
                shifts,
                runs[RUN_SLOTS][p],
                runs[RUN_DEAD][p],
                runs[RUN_LOGS][p],
                carried,
                image,
            )
        stage = progress[STAGE]
        if stage == 0:
            forget(
                frame,
                pins,
                runs[RUN_VECTORS][p],
                runs[RUN_SLOTS][p],
                runs[RUN_DEAD][p],
                runs[RUN_LOGS][p],
                runs[RUN_SUMS][p],
                runs[RUN_COUNTS][p],
                runs[RUN_GRAZING][p],
                carried,
            )
        else:
            for i in range(m):
                lost = runs[RUN_DEAD][p, i] == 1
                runs[RUN_GROWTH][p, stage, i] = -math.inf if lost else runs[RUN_LOGS][p, i]
        if stage == stretches.size - 1:
            bring_in_order(runs[RUN_WINDOW][p], progress[TAKEN], spare)
            return True
        progress[STAGE] = stage + 1
        progress[GOAL] += stretches[stage + 1]
    return False
