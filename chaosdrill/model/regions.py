"""Where modes begin: the region of states and parameters in which a start that names no mode is in a mode."""

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from chaosdrill.errors import SettingsError
from chaosdrill.model import arithmetic
from chaosdrill.model.tuning import TUNING
from chaosdrill.model.values import System

if TYPE_CHECKING:
    import numpy as np

UNTOLD = -1
"""Number of the mode of a start that names none, until its region tells it; and of one that is in no region."""


def own_mode(system: System) -> int:
    """Number of the initial mode of a system, `UNTOLD` if the region of its state tells it."""
    return system.initial_mode if system.names_mode else UNTOLD


def modes_at(
    system: System, parameters: Mapping[str, "np.ndarray"], states: "np.ndarray"
) -> "tuple[np.ndarray, np.ndarray]":
    """The modes in whose regions starts are, and whether any start is possible at the parameters, shapes (P,).

    ``parameters``: those that differ from the system's own, each of shape (P,). ``states``: shape (P, n).

    The mode is the first whose region holds the start; `UNTOLD` without one. A start is possible where all that the
    regions ask of parameters alone, each of them the same, holds.
    """
    import numpy as np

    plain = _plain(system)
    count = len(states)
    values = [np.broadcast_to(parameters.get(name, own), count) for name, own in system.parameters.items()]
    held = [_compared(system, number, [*states.T, *values], count) for number in range(len(plain["relations"]))]
    modes = np.full(count, UNTOLD, dtype=np.int64)
    for k, region in reversed(plain["regions"]):
        modes[_holds(region, held, count)] = k
    return modes, np.all([np.full(count, True), *(_holds(one, held, count) for one in plain["common"])], axis=0)


def check_parameters(system: System) -> None:
    """Raise SettingsError if no start is possible at the parameters of a system."""
    import numpy as np

    if not system.regions or modes_at(system, {}, np.zeros((1, len(system.state_names))))[1].all():
        return
    asked = _common(system)
    named = {symbol.name for relation in asked for symbol in relation.free_symbols}
    values = {name: value for name, value in system.parameters.items() if name in named}
    expected = " and ".join(sorted(map(str, asked)))
    raise SettingsError(f"{system.name}: the parameters {values} are out of range; expected {expected}")


def _common(system: System) -> set[Any]:
    """Conditions on parameters alone that all regions share."""
    import sympy

    parts = (set(sympy.And.make_args(region)) for region in system.regions.values())
    return {one for one in set.intersection(*parts) if one.free_symbols and not one.free_symbols & set(system.states)}


def _plain(system: System) -> dict[str, Any]:
    """The regions as plain data, which need no sympy.

    ``relations`` are comparisons, each with the terms of the difference of its sides; ``regions`` the number of each
    mode with its condition, and ``common`` what all conditions ask of parameters alone.
    """
    if "regions" not in system.shared:
        from chaosdrill.model.places import placed

        form = placed(system)
        relations = _relations(form)
        names = (*form.state_names, *form.parameters)
        terms = ([arithmetic.written(term, names, of_arrays=True) for term in _terms(one)] for one in relations)
        system.shared["regions"] = {
            "relations": [
                [one.rel_op, None if None in parts else parts] for one, parts in zip(relations, terms, strict=True)
            ],
            "regions": [[form.mode_names.index(m), _form(one, relations)] for m, one in form.regions.items()],
            "common": [_form(one, relations) for one in _common(form)],
        }
    found: dict[str, Any] = system.shared["regions"]
    return found


def _relations(placed: System) -> list[Any]:
    """The comparisons in the conditions of all regions."""
    import sympy

    relational = sympy.core.relational.Relational
    found = {one for region in placed.regions.values() for one in region.atoms(relational)}
    return sorted(found, key=sympy.default_sort_key)


def _terms(relation: Any) -> list[Any]:
    """Terms of the difference of the sides; what numpy cannot calculate is known nowhere."""
    import sympy

    from chaosdrill.model.python import opaque

    terms = sympy.Add.make_args(relation.lhs - relation.rhs)
    return [term.xreplace(dict.fromkeys(opaque(term), sympy.nan)) for term in terms]


def _form(condition: Any, relations: list[Any]) -> Any:
    """A condition of comparisons: the number of one, whether it always holds, or a connective with conditions."""
    import sympy

    if condition in (sympy.true, sympy.false):
        return bool(condition)
    if condition in relations:
        return ["relation", relations.index(condition)]
    name = next((name for name in ("Not", "And") if isinstance(condition, getattr(sympy, name))), "Or")
    return [name, *(_form(part, relations) for part in condition.args)]


def _compared(system: System, number: int, values: "list[np.ndarray]", count: int) -> "np.ndarray":
    """Where a comparison holds; one without a value does so nowhere."""
    import numpy as np

    operation, terms = _plain(system)["relations"][number]
    with np.errstate(all="ignore"):
        if terms is None:
            found = _more_than_arithmetic(system, number)(*values)
        else:
            found = [arithmetic.value(term, values, np) for term in terms]
        rows = np.array([np.broadcast_to(np.asarray(term, dtype=float), count) for term in found])
        total = rows.sum(axis=0)
        sign = np.where(np.abs(total) <= TUNING.equal_sides * np.abs(rows).sum(axis=0), 0.0, np.sign(total))
    return np.asarray(_OF_SIGN[operation](sign))


def _more_than_arithmetic(system: System, number: int) -> Callable[..., Any]:
    """Evaluates comparisons with functions beyond arithmetic."""
    if ("terms", number) not in system.shared:
        import sympy

        from chaosdrill.model.places import arguments, placed

        _, *symbols = arguments(form := placed(system))
        terms = _terms(_relations(form)[number])
        system.shared["terms", number] = sympy.lambdify(symbols, terms, modules="numpy")
    found: Callable[..., Any] = system.shared["terms", number]
    return found


def _holds(form: Any, held: "list[np.ndarray]", count: int) -> "np.ndarray":
    """Where a condition holds, by where its comparisons do."""
    import numpy as np

    if isinstance(form, bool):
        return np.full(count, form)
    name, *parts = form
    if name == "relation":
        return held[parts[0]]
    found = [_holds(part, held, count) for part in parts]
    if name == "Not":
        return ~found[0]
    joined: np.ndarray = (np.all if name == "And" else np.any)(found, axis=0)
    return joined


_OF_SIGN: dict[str, Callable[[Any], Any]] = {
    ">": lambda sign: sign > 0,
    ">=": lambda sign: sign >= 0,
    "<": lambda sign: sign < 0,
    "<=": lambda sign: sign <= 0,
    "==": lambda sign: sign == 0,
    "!=": lambda sign: abs(sign) == 1,
}
