"""How large a mode is: the operations that its Taylor series are made of."""

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import sympy

if TYPE_CHECKING:
    from chaosdrill.model.system import HybridSystem

MOST_OPERATIONS = 1000
"""Of one mode. With 800 of these its code is compiled in 8 s, that for lanes in 23 s, growing in proportion."""


def operations(system: "HybridSystem", mode: str) -> int:
    """Products, powers and functions of what moves, in rates, quadratures and guards of a mode; equal ones count once.

    Sums and constant factors cost next to nothing. A function counts twice, since its series needs that of its slope.
    """
    watched = [t.guard for t in system.transitions if mode in t.source]
    moving = {*system.states, system.time}
    return _count([*system.modes[mode].values(), *system.quadratures.values(), *watched], moving)


def _count(expressions: Iterable[Any], moving: set[Any]) -> int:
    parts = {part for whole in expressions for part in sympy.preorder_traversal(whole) if part.free_symbols & moving}
    total = 0
    for part in parts:
        if part.is_Mul:
            total += sum(1 for factor in part.args if factor.free_symbols & moving) - 1
        elif part.is_Pow:
            total += 1
        elif part.is_Function:
            total += 2
    return total
