"""Where many runs start, in whatever form it is given: rows of numbers, tables, data frames, datasets; and tangents."""

from collections.abc import Mapping
from math import isfinite
from typing import TYPE_CHECKING, Any

from chaosdrill.analysis.starting_states import Start
from chaosdrill.dataset.outcomes import Outcome
from chaosdrill.errors import SettingsError
from chaosdrill.names import remedy, shown
from chaosdrill.settings import Faults, Known, Value, entries, long, real, told, within

if TYPE_CHECKING:
    import numpy as np

    from chaosdrill.model import HybridSystem

MOST = 1_000_000
"""Starts in a list."""

_FORMS = "a row of numbers each, in the order of the states, or values by name, such as [{'x': 0.1}, {'x': 0.2}]"


class Starts(Value):
    """Initial states of many runs; what they do not name is the system's own.

    They are kept as columns by name: numbers of a state, or names of modes.
    """

    type_name = "array, list, mapping, DataFrame or Dataset"

    def read(self, name: str, value: Any, system: "HybridSystem") -> dict[str, list[Any]]:
        import numpy as np

        columns = _columns(value, system)
        if columns is None:
            received = f"{type(value).__name__} of shape {np.shape(value)}" if hasattr(value, "shape") else repr(value)
            raise SettingsError(f"{name} is {received:.60}; it must be a list of initial states, {_FORMS}")
        lengths = {len(column) for column in columns.values()}
        if len(lengths) != 1 or not 1 <= max(lengths) <= MOST:
            told_lengths = {key: len(column) for key, column in columns.items()}
            raise SettingsError(f"{name} has columns of lengths {told_lengths}; they must be alike, from 1 to {MOST}")
        known, found = ("mode", *system.state_names), {}
        for key, column in columns.items():
            if key not in known:
                raise SettingsError(f"{name} names {key!r:.60}, which is not a state; {remedy(key, known)}")
            found[key] = [_entry(f"{name} of run {k}", key, one, system) for k, one in enumerate(column, 1)]
        return found

    def faults(self, value: Any) -> Faults:
        if isinstance(value, Mapping):
            yield (), f"expected a list of initial states, {_FORMS}"
        elif not isinstance(value, list):
            yield (), told("expected a list", value)
        else:
            yield from long(value, 1, MOST)
            for index, one in enumerate(value):
                if isinstance(one, Mapping):
                    yield from within((index,), Start().faults(one))
                elif not isinstance(one, list) or any(isinstance(x, bool) or not isfinite(real(x)) for x in one):
                    yield (index,), told("expected a table of initial values, or a list of finite numbers", one)
            if len({isinstance(one, Mapping) for one in value}) > 1:
                yield (), "give all as tables, or all as lists of numbers"

    def misfits(self, value: Any, known: Known) -> Faults:
        for index, one in enumerate(value if isinstance(value, list) and known.states is not None else ()):
            if isinstance(one, Mapping):
                yield from within((index,), Start().misfits(one, known))
            elif isinstance(one, list) and known.states is not None and len(one) != len(known.states):
                yield (index,), f"has {len(one)} numbers; the system has the states {', '.join(known.states)}"


STARTS = Starts()


class Tangents(Value):
    """Initial tangents, one a row; True stands for the unit vectors, False for none."""

    type_name = "bool or array of shape (tangent, state)"

    def read(self, name: str, value: Any, system: "HybridSystem") -> "np.ndarray | None":
        import numpy as np

        n = len(system.state_names)
        if isinstance(value, bool | np.bool_):
            return np.eye(n) if value else None
        try:
            rows = np.array([[real(x) for x in entries(one)] for one in entries(value)])
        except ValueError:
            rows = np.zeros(0)
        if rows.ndim != 2 or not 1 <= len(rows) <= n or rows.shape[1] != n or not np.isfinite(rows).all():
            raise SettingsError(
                f"{name} is {shown(value):.60}; it must be True, or rows of {n} finite numbers, one for each state of "
                f"{', '.join(system.state_names)}, and no more than {n} of them"
            )
        lengths = np.abs(rows).max(axis=1, keepdims=True)  # no squares, which overflow
        rank = int(np.linalg.matrix_rank(rows / np.where(lengths > 0, lengths, 1.0)))
        if rank < len(rows):
            raise SettingsError(
                f"{name} has {len(rows)} rows of rank {rank}; they must be linearly independent, as those of the unit "
                "matrix (True) are"
            )
        return rows

    def faults(self, value: Any) -> Faults:
        if isinstance(value, bool):
            return
        if not isinstance(value, list):
            yield (), told("expected true, or a list of rows of numbers", value)
            return
        for index, row in enumerate(value):
            if not isinstance(row, list) or any(isinstance(x, bool) or not isfinite(real(x)) for x in row):
                yield (index,), told("expected a list of finite numbers", row)


def states_and_modes(
    system: "HybridSystem", columns: Mapping[str, list[Any]], *, settled: bool = True
) -> "tuple[np.ndarray, np.ndarray]":
    """States (N, n) and modes (N,) of starts as `Starts` has read them; untold modes are settled, or left so."""
    import numpy as np

    from chaosdrill.model.regions import UNTOLD

    count = len(next(iter(columns.values())))
    own = [[system.initial[name]] * count for name in system.state_names]
    states = [columns.get(name, default) for name, default in zip(system.state_names, own, strict=True)]
    modes = columns.get("mode", [system.start.get("mode")] * count)
    numbers = np.array([UNTOLD if mode is None else system.mode_names.index(mode) for mode in modes], dtype=np.int64)
    rows = np.array(states, dtype=float).T.copy()
    return rows, settled_modes(system, rows, numbers) if settled else numbers


def cells_and_listed(system: "HybridSystem", given: Any, *, settled: bool = True) -> "tuple[np.ndarray, np.ndarray]":
    """States (N, n) and modes (N,) of the cells of a ``grid``, the last state fastest, and of a list ``initial``."""
    import numpy as np

    from chaosdrill.model.regions import own_mode

    parts = []
    if given.grid:
        axes = np.meshgrid(*given.grid.values(), indexing="ij")
        cells = np.tile(np.array(system.initial_values), (axes[0].size, 1))
        for name, values in zip(given.grid, axes, strict=True):
            cells[:, system.state_names.index(name)] = values.ravel()
        parts.append((cells, np.full(len(cells), own_mode(system))))
    if given.initial is not None:
        parts.append(states_and_modes(system, given.initial, settled=False))
    states, modes = map(np.concatenate, zip(*parts, strict=True))
    return states, settled_modes(system, states, modes) if settled else modes


def drawn_or_listed(system: "HybridSystem", given: Any) -> "tuple[np.ndarray, np.ndarray]":
    """States (N, n) and modes (N,) of the starts of settings ``initial``, or ``random`` where these are missing."""
    from chaosdrill.analysis.seeds import draw

    columns = given.initial
    if columns is None:
        drawn = draw(system, given.random)
        columns = {name: [one[name] for one in drawn] for name in drawn[0]}
    return states_and_modes(system, columns)


def settled_modes(system: "HybridSystem", states: "np.ndarray", modes: "np.ndarray") -> "np.ndarray":
    """Modes of starts at the system's own parameters, shape (N,), those in whose regions they are for untold ones."""
    import numpy as np

    from chaosdrill.model.regions import UNTOLD, modes_at

    return np.where(modes == UNTOLD, modes_at(system, {}, states)[0], modes) if system.regions else modes


def share_of(hits: Any, starts: int) -> tuple[Any, Any]:
    """The part of the starts that lead somewhere, and its standard error.

    The variance of a start is that of a share with two hits and two misses more (Agresti and Coull 1998,
    doi:10.1080/00031305.1998.10480550), so that the error does not vanish where all starts, or none, lead there. It is
    divided by the starts there are: twice the error then covers in 90 % or more, of one start or of hundreds.
    """
    import numpy as np

    hits = np.asarray(hits, dtype=float)
    likely = (hits + 2) / (starts + 4)
    return hits / starts, np.sqrt(likely * (1 - likely) / starts)


NOT_RUN = (Outcome.FAILED, Outcome.INVALID_START)
"""Outcomes of starts that could not be run."""


def any_ran(outcomes: "np.ndarray") -> "np.ndarray":
    """Whether any of some starts, (..., N), could be run; shares and measures of basins are NaN elsewhere."""
    import numpy as np

    return np.asarray(~np.isin(outcomes, NOT_RUN).all(axis=-1))


def told_of_starts(system: "HybridSystem", outcomes: "np.ndarray") -> str:
    """Why no run of an analysis could begin, with the guard if the system's own start is beyond one; else empty."""
    if not outcomes.size or (outcomes != Outcome.INVALID_START).any():
        return ""
    passed = _passed(system)
    return f"the run has no start. {passed or Outcome.INVALID_START.advice}"


def _passed(system: "HybridSystem") -> str:
    """The guard beyond which the system starts, with its value there; empty if it cannot be told."""
    mode = system.initial["mode"]
    there = {**system.parameters, **system.initial}
    for t in system.transitions:
        if mode not in t.source or t.marks_only():
            continue
        try:
            value = float(t.guard.subs({s: there.get(s.name, 0.0) for s in t.guard.free_symbols}))
        except TypeError:
            # a guard of a Python function, or one without a value there
            continue
        if t.direction * value > 0:
            state = ", ".join(f"{name} = {system.initial[name]:g}" for name in system.state_names)
            side = "negative" if t.direction > 0 else "positive"
            return (
                f"At {state} the guard {t.guard} of {t.name!r} is {value:g}, and mode {mode!r} holds while it is "
                f"{side}; start on that side, or in another mode; or give the guard the other direction."
            )
    return ""


def _entry(place: str, key: str, value: Any, system: "HybridSystem") -> Any:
    if key == "mode":
        if value is None and not system.names_mode:
            return None
        if not isinstance(value, str) or value not in system.mode_names:
            raise SettingsError(f"{place} has the mode {shown(value):.60}; {remedy(str(value), system.mode_names)}")
        return str(value)
    number = real(value)
    if not isfinite(number):
        raise SettingsError(f"{place} has {key} = {shown(value):.60}; it must be a finite number")
    return number


def _columns(value: Any, system: "HybridSystem") -> dict[str, list[Any]] | None:
    """The columns of a list of starts; None for anything else."""
    import numpy as np

    names: Any = system.state_names
    if "state" in getattr(value, "dims", ()) and not isinstance(value, Mapping):
        # an array of xarray says itself which state is which
        names = value["state"].values.tolist() if "state" in value.coords else names
        value = value.transpose(..., "state").values.reshape(-1, value.sizes["state"])
    elif hasattr(value, "columns") or isinstance(value, Mapping):
        given = value.columns if hasattr(value, "columns") else value
        return {str(name): np.ravel(value[name]).tolist() for name in given} or None
    listed = entries(value)
    if listed and all(isinstance(one, Mapping) for one in listed):
        rows = [{str(name): one for name, one in row.items()} for row in listed]
        # a row that leaves a state out has the system's own value
        used = dict.fromkeys(name for row in rows for name in row)
        return {name: [row.get(name, system.start.get(name)) for row in rows] for name in used} or None
    try:
        numbers = np.array([[real(x) for x in entries(one)] if np.ndim(one) else [real(one)] for one in listed])
    except (TypeError, ValueError):
        return None
    if numbers.ndim != 2 or numbers.shape[1] != len(names):
        return None
    return {str(name): numbers[:, k].tolist() for k, name in enumerate(names)}
