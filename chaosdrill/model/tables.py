"""Read-only tables and numbers of a system: code derived from it depends on them."""

import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NoReturn

from chaosdrill.errors import SettingsError
from chaosdrill.names import remedy
from chaosdrill.settings import real

ANOTHER = (
    "with_parameters(name=value) returns a copy with other parameters, with_initial(name=value) a copy that starts "
    "elsewhere; for other equations build a new HybridSystem"
)
"""How to get a system that differs from one at hand."""

UNNAMED = "own-system"
"""Name of a system that was given none."""

UNNAMED_MAP = "own-map"
"""Name of a map that was given none."""

OF_NOISE = ("draw", "count")
"""Endings of the states that a parameter becomes which is drawn anew: the standard variate, and the draws so far."""

MOST = sys.float_info.max
"""Largest double: whole numbers of any length may be given."""

DEFAULT_BOUNDS = (-1e9, 1e9)
"""Bounds that nobody gave, in units of the largest initial state where that is larger than 1."""


class _ReadOnly:
    """Methods that would change a table; they raise an error."""

    def _refuse(self, *_: Any, **__: Any) -> NoReturn:
        raise SettingsError(f"a system cannot be changed in place; {ANOTHER}; dict(table) is a copy that can")

    __setitem__ = __delitem__ = __ior__ = update = setdefault = pop = popitem = clear = _refuse


class Table(_ReadOnly, dict[Any, Any]):
    """A table that is read only: parameters, the initial state, rates of modes; changes raise `SettingsError`."""

    def __reduce__(self) -> tuple[Any, ...]:
        return Table, (dict(self),)

    def __missing__(self, key: Any) -> NoReturn:
        raise KeyError(f"no entry {key!r:.60}; {remedy(key, map(str, self))}" if isinstance(key, str) else key)

    def __copy__(self) -> "Table":
        return self

    def __deepcopy__(self, _: Any) -> "Table":
        return self

    def copy(self) -> dict[Any, Any]:
        """A table of its own, which may be changed."""
        return dict(self)


class Entries(_ReadOnly, Mapping[str, Any]):
    """A read-only table whose names are known and whose entries are found on first use."""

    def __init__(self, names: Sequence[str], find: Callable[[], Mapping[str, Any]]) -> None:
        self._names = dict.fromkeys(names)
        self._find = find

    def __len__(self) -> int:
        return len(self._names)

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __contains__(self, name: object) -> bool:
        return name in self._names

    def __getitem__(self, name: str) -> Any:
        return self._find()[name]

    def __reversed__(self) -> Iterator[str]:
        return reversed(self._names)

    def __or__(self, other: Mapping[Any, Any]) -> dict[Any, Any]:
        return {**self, **other}

    def __ror__(self, other: Mapping[Any, Any]) -> dict[Any, Any]:
        return {**other, **self}

    def __repr__(self) -> str:
        return repr(dict(self))

    def copy(self) -> dict[Any, Any]:
        """A table of its own, which may be changed."""
        return dict(self)


def read_only(value: Any) -> Any:
    """Tables, and tables in tables, made read only; anything else as it is."""
    if not isinstance(value, Mapping) or isinstance(value, Table | Entries):
        return value
    return Table({key: read_only(entry) for key, entry in value.items()})


def finite(value: Any) -> float | None:
    """A finite number as a double; None for anything else."""
    number = real(value)
    return number if abs(number) <= MOST else None
