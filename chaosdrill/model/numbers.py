"""The numbers of a system, which stay as they are: what was derived from a system belongs to them."""

from typing import Any, NoReturn

from chaosdrill.errors import SettingsError


class Numbers(dict[str, float]):
    """Values of parameters by name; another system has other ones.

    Raises
    ------
    SettingsError
        If one is to be changed, added or removed.
    """

    def _refuse(self, *_: Any, **__: Any) -> NoReturn:
        raise SettingsError(
            "the parameters of a system are not changed, added or removed; with_parameters(name=value) returns a copy "
            "with other values, and dict(system.parameters) a table of its own"
        )

    __setitem__ = __delitem__ = __ior__ = update = setdefault = pop = popitem = clear = _refuse

    def __reduce__(self) -> tuple[Any, ...]:
        return Numbers, (dict(self),)

    def __copy__(self) -> "Numbers":
        return self

    def __deepcopy__(self, _: Any) -> "Numbers":
        return self

    def copy(self) -> dict[str, float]:
        """A table of its own, which may be changed."""
        return dict(self)
