"""How far each run of a batch is."""

import math

from chaosdrill.engine.jit import inlined, inner
from chaosdrill.engine.layout import GOAL, LAST, STAGE, TAKEN
from chaosdrill.engine.records import state_of
from chaosdrill.engine.revival import forget
from chaosdrill.engine.tangents import log_growth, orthonormalise
from chaosdrill.engine.window import bring_in_order


@inlined
def begin(p, states, results, stretches):
    progress = results.progress[p]
    strobes = states.run[p].strobes
    progress[STAGE] = 0
    progress[GOAL] = strobes + stretches[0]
    progress[LAST] = strobes + stretches.sum()
    progress[TAKEN] = 0
    results.growth[p, 0, :] = 0.0
    results.integrals[p, 0, :] = 0.0
    results.window[p, :, :] = math.nan


@inner
def is_over(p, tables, states, results, frame, stretches, image, spare):
    """Note what a run has reached where it stands at a goal, until it has one ahead; whether there is none left."""
    progress = results.progress[p]
    state = state_of(states, p)
    m = frame.shape[0]
    while state.run[0].strobes >= progress[GOAL]:
        if m > 0:
            orthonormalise(state, tables.shifts, image)
        stage = progress[STAGE]
        if stage == 0:
            forget(state, frame, tables.pins)
        else:
            for i in range(m):
                results.growth[p, stage, i] = -math.inf if state.dead[i] == 1 else log_growth(state, i)
            for i in range(state.sums.shape[1]):
                results.integrals[p, stage, i] = state.sums[0, i] + state.sums[1, i]
        if stage == stretches.size - 1:
            bring_in_order(results.window[p], progress[TAKEN], spare)
            return True
        progress[STAGE] = stage + 1
        progress[GOAL] += stretches[stage + 1]
    return False
