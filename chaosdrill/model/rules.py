"""Rules about expressions that go beyond the type of each entry."""

from collections.abc import Iterable, Mapping
from typing import Any

import sympy
from sympy.core.function import Application
from sympy.core.relational import Relational

from chaosdrill.model.python import Called
from chaosdrill.model.special import CONDITION, FLOW, RESET, SPECIAL
from chaosdrill.model.text import SMOOTH, level_of, no_function, unknown_function
from chaosdrill.model.touching import find_fold

_BOUNDED = ("Max", "Min", "Piecewise", "sign")
"""Functions without a derivative whose rounding has a bound, so that guards and rates may hold them of parameters."""

_TAKEN_APART = "chaosdrill.in_modes does so"


def refused(expression: Any, moving: set[Any], level: int) -> str | None:
    """Why an expression cannot stand where it is to, and what to write instead; None if it can.

    Rates, guards and quadratures need a Taylor series in what moves, resets a derivative; a kink or a jump within a
    flow would be stepped over in silence.
    """
    for part in sympy.preorder_traversal(expression):
        if not isinstance(part, Application) or isinstance(part, sympy.And | sympy.Or | sympy.Not | Called):
            continue
        name = type(part).__name__
        own = level_of(name)
        if own is None:
            if name == "Heaviside" and level == FLOW:
                return f"{part!s:.60} has no Taylor series; {_modes_instead(name, part)}"
            if name in {symbol.name for symbol in moving}:
                return no_function(name, delayed=True)
            return f"unknown function {name[:40]!r}; {unknown_function(name)}"
        moves = bool(part.free_symbols & moving)
        if own > level and (moves or (level == FLOW and own == CONDITION and name not in _BOUNDED)):
            where = "resets and conditions" if own == RESET else "conditions"
            lacks = "Taylor series" if level == FLOW else "derivative"
            branches = "write its branches as transitions of their own with a condition each"
            instead = _modes_instead(name, part) if level == FLOW else branches
            return f"{part!s:.60} has no {lacks}, and can stand in {where} only; {instead}"
        allowed = SPECIAL[name].moving if name in SPECIAL and level == FLOW else range(len(part.args))
        wrong = [i for i, a in enumerate(part.args) if i not in allowed and a.free_symbols & moving]
        if wrong:
            return (
                f"{part!s:.60} has no Taylor series in its argument {wrong[0] + 1}, which may hold parameters; resets "
                "and conditions may hold it as it is"
            )
    return None


def kinked(expressions: Iterable[Any], moving: set[Any]) -> tuple[Any, Any] | None:
    """The first function with a kink or a jump in one of some symbols, and that symbol; None if there is none."""
    for expression in expressions:
        parts = sorted(sympy.sympify(expression).atoms(Application), key=sympy.default_sort_key)
        for part in parts:
            if (level_of(type(part).__name__) or FLOW) > FLOW and (bent := part.free_symbols & moving):
                return part, min(bent, key=str)
    return None


def folded(expression: Any, moving: set[Any], numbers: Mapping[str, float]) -> str | None:
    """Why an expression of functions with a Taylor series has a kink or a jump nevertheless; None if it has none.

    ``numbers`` are values of the parameters.
    """
    fold = find_fold(expression, moving, numbers)
    if fold is None:
        return None
    part, where = f"{fold.part!s:.80}", f"{fold.where!s:.80}"
    if fold.instead is None:
        return (
            f"{part} has a kink where {where} is zero; write Abs({where}) times a function without one instead of it, "
            f"and a mode for each side of {where}; {_TAKEN_APART}"
        )
    (kink, *_) = sorted(fold.instead.atoms(sympy.Abs), key=sympy.default_sort_key)
    what, instead = "jump" if fold.instead.has(sympy.sign) else "kink", _modes_instead("Abs", kink)
    return f"{part} has a {what} where {where} is zero: it is {fold.instead!s:.200}. For {kink} {instead}"


def _modes_instead(name: str, part: Any) -> str:
    """The remedy for a function in a flow that has a kink, a jump or no series."""
    one, *others = part.args
    if name in ("Abs", "sign", "Heaviside", "Max", "Min"):
        branches = {"Abs": (one, -one), "sign": (1, -1), "Heaviside": (1, 0)}.get(name, part.args)
        modes = ", ".join(f"{'a mode' if i == 0 else 'one'} with {branch} for it" for i, branch in enumerate(branches))
        if name in ("Max", "Min") and len(others) > 1:
            return f"write {modes}, and guards between them, the differences of each two, such as {one - others[0]}"
        guard = one - others[0] if name in ("Max", "Min") else one
        return f"write {modes}, and a guard {guard} between them; {_TAKEN_APART}"
    if name in ("floor", "ceiling", "Mod"):
        n, step = sympy.Symbol("n"), others[0] if others else sympy.Integer(1)
        above = one - (n if name == "ceiling" else n + 1) * step
        return (
            f"write {one - n * step if name == 'Mod' else n} for it, with a state n of rate 0 in every mode that a "
            f"transition resets to n + 1 where the guard {above} rises"
        )
    if name == "Piecewise":
        edges = [str(edge.lhs - edge.rhs) for edge in sorted(part.atoms(Relational), key=sympy.default_sort_key)]
        return (
            f"write its branches as modes with a guard between them, such as {' or '.join(edges[:3])}; {_TAKEN_APART}"
        )
    if name == "acosh":
        return f"write {sympy.log(one + sympy.sqrt(one**2 - 1))} for it"
    if name == "atan2":
        (x,) = others
        angle = 2 * sympy.atan(one / (x + sympy.sqrt(x**2 + one**2)))
        return f"write {angle} for it, which jumps where {one} is zero and {x} negative"
    return f"rates, guards and quadratures may hold {', '.join(SMOOTH)} and powers"
