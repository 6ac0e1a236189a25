"""Functions of an orbit as settings: tables of expressions by name, their levels and their optima."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from chaosdrill.dataset.schema import Table, axis, may
from chaosdrill.names import event_words, key_text, remedy
from chaosdrill.settings import Choice, Faults, ListOf, Number, Settings, TableOf, Text, Value, setting, told, within

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy as np
    import xarray as xr

    from chaosdrill.model import HybridSystem
    from chaosdrill.orbits.functions import Functions
    from chaosdrill.orbits.results import FoundOrbit

TAKES = ("mean", "total", "maximum", "minimum")
"""What is taken of an expression: over the time of one period of the orbit, or over the events in it."""


@dataclass(frozen=True, kw_only=True)
class FunctionTable(Settings):
    """One function of the orbit."""

    of: str = setting(Text())
    take: str = setting(Choice(TAKES), "mean")
    at: str | None = setting(Text(), None)
    modes: list[str] | None = setting(ListOf(Text(), distinct=True), None)
    units: str = setting(Text(), "1")


class FunctionTables(Value):
    """Functions by name; in Python the expression may be sympy's, or a function of the orbit's record."""

    type_name = "mapping of a name to a table"

    def plain(self, value: Any) -> Any:
        return {key_text(key): self._plain(one) for key, one in value.items()} if isinstance(value, Mapping) else value

    def _plain(self, value: Any) -> Any:
        from chaosdrill.orbits.orbit_record import PythonFunction

        if not isinstance(value, Mapping):
            return {"of": PythonFunction(value)} if callable(value) else value
        if callable(value.get("of")):
            return {**value, "of": PythonFunction(value["of"])}
        names = ListOf(Text())
        plain = {key: names.plain(one) if key == "modes" else one for key, one in value.items()}
        if not hasattr(plain.get("of"), "free_symbols"):
            return plain
        from chaosdrill.model.text import write_text

        return plain | {"of": write_text(plain["of"])}

    def faults(self, value: Any) -> Faults:
        if not isinstance(value, Mapping) or not value:
            yield (), told("expected a table of functions by name, each with an expression: of", value)
            return
        for name, one in value.items():
            yield from within((name,), FunctionTable.faults(one))


FUNCTIONS = FunctionTables()
LEVELS = TableOf(ListOf(Number(), distinct=True), " of lists of values by the name of a function")
OPTIMA = ListOf(Text(), distinct=True)


def function_columns(dims: str) -> Table:
    """The variables of functions of orbits."""
    return (
        axis("function", "function", "str", "name of the function", "As requested."),
        axis("function_expression", "function", "str", "expression of the function", "In words."),
        axis("function_units", "function", "str", "units of the function", "As they were given."),
        may("function_value", f"{dims} function", "f8", "function of the orbit", "NaN without such an event."),
        may("function_error", f"{dims} function", "f8", "error of the function", "Estimated; of quadrature and orbit."),
    )


def misfits_of_functions(table: Mapping[str, Any], system: "HybridSystem") -> Faults:
    """Expressions, events and modes that a system does not have."""
    from chaosdrill.model.grammar import ExpressionError
    from chaosdrill.orbits.functions import read_function
    from chaosdrill.orbits.orbit_record import PYTHON, PythonFunction

    events = event_words(system.transitions)
    for name, one in (table.get("functions") or {}).items():
        if isinstance(one["of"], PythonFunction):
            for key in ("take", "at", "modes"):
                if key in one:
                    yield ("functions", name, key), "a Python function sees the whole orbit; leave it out"
            continue
        if one["of"].startswith(PYTHON):
            yield ("functions", name, "of"), f"{one['of']!r:.80} cannot be read from text; pass the function itself"
            continue
        try:
            read_function(system, name, one)
        except ExpressionError as fault:
            yield ("functions", name, "of"), str(fault)
        if one.get("at") is not None and one["at"] not in events:
            yield ("functions", name, "at"), f"unknown event {one['at']!r:.60}; {remedy(one['at'], events)}"
        for index, mode in enumerate(one.get("modes") or ()):
            if mode not in system.modes:
                yield ("functions", name, "modes", index), f"unknown mode {mode!r:.60}; {remedy(mode, system.modes)}"


def unnamed(table: Mapping[str, Any]) -> Iterator[tuple[tuple[str | int, ...], str]]:
    """Levels and optima of functions that there are not."""
    functions = table.get("functions") or {}
    for name in table.get("levels") or ():
        if name not in functions:
            yield ("levels", name), f"there is no such function; {_named(name, functions)}"
    for index, name in enumerate(table.get("optima") or ()):
        if name not in functions:
            yield ("optima", index), f"there is no function {name!r:.60}; {_named(name, functions)}"


def _named(name: str, functions: Mapping[str, Any]) -> str:
    return remedy(name, functions) if functions else "name it in functions"


def functions_of(system: "HybridSystem", tables: Mapping[str, Any] | None) -> "Functions | None":
    """The functions that a sound table describes; None without one."""
    from chaosdrill.orbits.functions import Functions, read_function

    if not tables:
        return None
    return Functions(system, [read_function(system, name, one) for name, one in tables.items()])


def values_on(functions: "Functions | None", orbits: "Sequence[FoundOrbit]") -> "tuple[np.ndarray, np.ndarray]":
    """Values and errors on orbits that were found, both of shape (orbits, functions); NaN for missing orbits."""
    import numpy as np

    found = np.full((2, len(orbits), 0 if functions is None else len(functions)), np.nan)
    for row, one in enumerate(orbits):
        if functions is not None and one.solved is not None:
            problem, orbit, shot = one.solved
            found[:, row] = np.array(functions(problem, [orbit], [shot]))[:, 0]
    return found[0], found[1]


def with_functions(
    ds: "xr.Dataset", functions: "Functions | None", dims: str, values: "np.ndarray", errors: "np.ndarray"
) -> "xr.Dataset":
    """A dataset with functions over these dimensions; the same without functions.

    The attribute ``functions_message`` says which have no value on how many orbits.
    """
    if functions is None:
        return ds
    texts = ([one.words for one in functions.functions], [one.units for one in functions.functions])
    named = zip(("function", "function_expression", "function_units"), (functions.names, *texts), strict=True)
    # without an orbit there is no column
    shape = (ds.sizes[dims], len(functions))
    both = {"function_value": values.reshape(shape), "function_error": errors.reshape(shape)}
    from chaosdrill.dataset.build import more, variable

    ds = more(ds, {name: ((dims, "function"), one) for name, one in both.items()} | {"function": list(functions.names)})
    ds = ds.assign_coords({name: variable("function", list(text)) for name, text in named if name != "function"})
    states = ds["orbit_state"]
    known = states.values == states.values
    found = known.any(axis=tuple(k for k, dim in enumerate(states.dims) if dim != dims))
    column = both["function_value"]
    lacking = ((column != column) & found[..., None]).sum(axis=0).tolist()
    lost = [f"{name} on {k} of {int(found.sum())}" for name, k in zip(functions.names, lacking, strict=True) if k]
    if not lost:
        return ds
    why = "outside its domain there, or of events or modes that these orbits do not have"
    told = "; ".join(functions.failures) or why
    return ds.assign_attrs(functions_message=f"no value: {', '.join(lost)} orbits; {told}")
