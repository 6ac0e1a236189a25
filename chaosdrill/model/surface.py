"""A surface in state space, marked by transitions that change nothing."""

from chaosdrill.model.crossings import crossings
from chaosdrill.model.grammar import ExpressionError
from chaosdrill.model.places import parameter
from chaosdrill.model.rules import folded, refused
from chaosdrill.model.special import FLOW
from chaosdrill.model.system import HybridSystem
from chaosdrill.model.text import read_text
from chaosdrill.model.transition import Transition


def surface(system: HybridSystem, at: str) -> tuple[HybridSystem, frozenset[int]]:
    """The system with transitions that mark where a comparison becomes true, and their indices.

    Raises `ExpressionError` if that is no comparison of what moves, or if an event of the system has that surface.
    """
    known = system.shared.get(("surface", at))
    if known is None:
        moving = {*system.states, *(() if system.time is None else (system.time,))}
        names = {symbol.name: symbol for symbol in moving} | {name: parameter(name) for name in system.parameters}
        found = read_text(at, names, condition=True)
        if not hasattr(found, "gts") or not found.free_symbols & set(system.states):
            raise ExpressionError("a section is one comparison of states by < or >, such as x > 0")
        value = found.gts - found.lts
        if told := refused(value, moving, FLOW) or folded(value, moving, system.parameters):
            raise ExpressionError(told)
        first = 1 + max((t.priority for t in system.transitions), default=0)
        marks = [
            Transition(f"{at} in {mode}", mode, mode, guard=value, direction=+1, priority=first)
            for mode in system.modes
        ]
        mark, *others = crossings((marks[0], *system.transitions))
        for t, other in zip(system.transitions, others, strict=True):
            if other.surface == mark.surface and other.direction in (0, mark.direction):
                raise ExpressionError(f"this surface is the guard of {t.name!r}; name that, as in at={t.name!r}")
        known = system.shared["surface", at] = system.remade(transitions=(*system.transitions, *marks))
    marked = known.changed(parameters=system.parameters, initial=system.initial, names_mode=system.names_mode)
    count = len(system.transitions)
    return marked, frozenset(range(count, len(marked.transitions)))
