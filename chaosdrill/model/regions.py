"""Where modes begin: the region of states and parameters in which a start that names no mode is in a mode."""

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from chaosdrill.errors import SettingsError

if TYPE_CHECKING:
    import numpy as np

    from chaosdrill.model.system import HybridSystem

ROUNDING = 1e-15
"""Part of the terms of a comparison below which its sides count as equal."""

UNTOLD = -1
"""Number of the mode of a start that names none, until its region tells it; and of one that is in no region."""

Signs = dict[Any, "np.ndarray"]
"""Relation -> the sign of its left side minus its right one, at each start."""


def own_mode(system: "HybridSystem") -> int:
    """Number of the initial mode of a system, `UNTOLD` if the region of its state tells it."""
    return system.mode_names.index(system.initial["mode"]) if system.names_mode else UNTOLD


def modes_at(
    system: "HybridSystem", parameters: Mapping[str, "np.ndarray"], states: "np.ndarray"
) -> "tuple[np.ndarray, np.ndarray]":
    """The modes in whose regions starts are, and whether any start is possible at the parameters.

    Parameters
    ----------
    system : HybridSystem
        One with regions.
    parameters : mapping of str to ndarray, shape (P,)
        Those that differ from the system's own.
    states : ndarray, shape (P, n)

    Returns
    -------
    modes : ndarray of int, shape (P,)
        The first whose region holds the start, `UNTOLD` where there is none.
    possible : ndarray of bool, shape (P,)
        Whether all that the regions ask of parameters alone, each of them the same, holds.
    """
    import numpy as np
    import sympy

    regions, common, signs_at = _compiled(system)
    count = len(states)
    values = [np.broadcast_to(parameters.get(name, own), count) for name, own in system.parameters.items()]
    signs = signs_at([*states.T, *values], count)
    modes = np.full(count, UNTOLD, dtype=np.int64)
    for k, region in reversed(regions):
        modes[_holds(region, signs, count)] = k
    return modes, _holds(sympy.And(*common), signs, count)


def check_parameters(system: "HybridSystem") -> None:
    """Raise SettingsError if no start is possible at the parameters of a system."""
    import numpy as np

    if not system.regions or modes_at(system, {}, np.zeros((1, len(system.states))))[1].all():
        return
    asked = _common(system)
    named = {symbol.name for relation in asked for symbol in relation.free_symbols}
    values = {name: value for name, value in system.parameters.items() if name in named}
    expected = " and ".join(sorted(map(str, asked)))
    raise SettingsError(f"{system.name}: the parameters {values} are out of range; expected {expected}")


def _common(system: "HybridSystem") -> set[Any]:
    """What every region asks of parameters alone."""
    import sympy

    parts = (set(sympy.And.make_args(region)) for region in system.regions.values())
    return {one for one in set.intersection(*parts) if one.free_symbols and not one.free_symbols & set(system.states)}


def _compiled(system: "HybridSystem") -> tuple[list[tuple[int, Any]], set[Any], Callable[..., Signs]]:
    """Regions by the numbers of their modes, what they have in common, and the signs of their relations."""
    if "regions" not in system.shared:
        import sympy

        from chaosdrill.model.held import opaque
        from chaosdrill.model.places import parameter

        placed = system.placed
        regions = [(system.mode_names.index(mode), region) for mode, region in placed.regions.items()]
        relations = sorted(
            {one for _, region in regions for one in region.atoms(sympy.core.relational.Relational)},
            key=sympy.default_sort_key,
        )
        terms = [sympy.Add.make_args(one.lhs - one.rhs) for one in relations]
        # what numpy cannot calculate is known nowhere
        unknown = {call: sympy.nan for group in terms for term in group for call in opaque(term)}
        terms = [[term.xreplace(unknown) for term in group] for group in terms]
        symbols = [*placed.states, *map(parameter, placed.parameters)]
        function = sympy.lambdify(symbols, terms, modules="numpy")
        system.shared["regions"] = regions, _common(placed), _signs(relations, function)
    found: tuple[list[tuple[int, Any]], set[Any], Callable[..., Signs]] = system.shared["regions"]
    return found


def _signs(relations: list[Any], function: Callable[..., Any]) -> Callable[..., Signs]:
    import numpy as np

    def at(values: "list[np.ndarray]", count: int) -> Signs:
        found = {}
        with np.errstate(all="ignore"):
            for relation, terms in zip(relations, function(*values), strict=True):
                rows = np.array([np.broadcast_to(np.asarray(term, dtype=float), count) for term in terms])
                total = rows.sum(axis=0)
                found[relation] = np.where(np.abs(total) <= ROUNDING * np.abs(rows).sum(axis=0), 0.0, np.sign(total))
        return found

    return at


def _holds(condition: Any, signs: Signs, count: int) -> "np.ndarray":
    """Where a condition holds; a relation without a value does so nowhere."""
    import numpy as np
    import sympy

    if condition in (sympy.true, sympy.false):
        return np.full(count, condition == sympy.true)
    if condition in signs:
        sign = signs[condition]
        return np.asarray(_OF_SIGN[condition.rel_op](sign))
    parts = [_holds(part, signs, count) for part in condition.args]
    if isinstance(condition, sympy.Not):
        return ~parts[0]
    joined: np.ndarray = (np.all if isinstance(condition, sympy.And) else np.any)(parts, axis=0)
    return joined


_OF_SIGN: dict[str, Callable[[Any], Any]] = {
    ">": lambda sign: sign > 0,
    ">=": lambda sign: sign >= 0,
    "<": lambda sign: sign < 0,
    "<=": lambda sign: sign <= 0,
    "==": lambda sign: sign == 0,
    "!=": lambda sign: abs(sign) == 1,
}
