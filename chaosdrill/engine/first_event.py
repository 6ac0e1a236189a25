"""The first event of a step, for one run: compiled by itself, for lanes and orbits; it is a part of single runs."""

from chaosdrill.engine import guards
from chaosdrill.engine.jit import compiled
from chaosdrill.engine.records import SEARCH_SIGNATURE, machine_at, state_of


@compiled(SEARCH_SIGNATURE)
def first_event(place, p, h, t):
    """As ``guards.first_event``, in a step of length h from time t whose series stand in the workspace."""
    machine = machine_at(place)
    settings, scratch = machine.settings[0], machine.scratch
    state = state_of(machine.states, p)
    ws, row = scratch.workspace, state.x.size + settings.quadratures
    return guards.first_event(machine.functions, machine.tables, settings, state, ws, row, h, t, scratch)
