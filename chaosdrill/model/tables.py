"""The tables of a system, which stay as they are: what was derived from a system belongs to them."""

from collections.abc import Mapping
from typing import Any, NoReturn

from chaosdrill.errors import SettingsError

ANOTHER = (
    "with_parameters(name=value) returns a copy with other parameters, with_initial(name=value) a copy that starts "
    "elsewhere; for other equations build a new HybridSystem"
)
"""How to get a system that differs from one at hand."""


class Table(dict[Any, Any]):
    """A table that is read only: parameters, the initial state, rates of modes.

    Raises
    ------
    SettingsError
        On any attempt to change, add or remove an entry.
    """

    def _refuse(self, *_: Any, **__: Any) -> NoReturn:
        raise SettingsError(f"a system cannot be changed in place; {ANOTHER}; dict(table) is a copy that can")

    __setitem__ = __delitem__ = __ior__ = update = setdefault = pop = popitem = clear = _refuse

    def __reduce__(self) -> tuple[Any, ...]:
        return Table, (dict(self),)

    def __copy__(self) -> "Table":
        return self

    def __deepcopy__(self, _: Any) -> "Table":
        return self

    def copy(self) -> dict[Any, Any]:
        """A table of its own, which may be changed."""
        return dict(self)


def read_only(value: Any) -> Any:
    """Tables, and tables in tables, made read only; anything else as it is."""
    if not isinstance(value, Mapping) or isinstance(value, Table):
        return value
    return Table({key: read_only(entry) for key, entry in value.items()})
