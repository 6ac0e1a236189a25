"""Keep xarray from importing dask where nobody has.

To tell whether an array is one of dask's, xarray imports all of dask at its first array, where dask is installed: twice
the time of its own import. No array can be one as long as nobody has imported dask. No public part of xarray says so;
what is used of its inner parts stands in this file alone, and where a version lacks it nothing is spared.
"""

import sys
from contextlib import suppress
from importlib import import_module
from typing import Any

_asked_less: list[bool] = []


class _Unasked:
    """What xarray keeps of dask, told anew at each question as long as dask is not there."""

    def __init__(self, found: type) -> None:
        self._found = found

    @property
    def type(self) -> tuple[Any, ...]:
        """Classes of dask's arrays."""
        arrays = sys.modules.get("dask.array")
        return (arrays.Array,) if hasattr(arrays, "Array") else ()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._found("dask"), name)


def spare_dask() -> None:
    """Have xarray ask for dask's arrays only when somebody has imported dask."""
    if "dask" in sys.modules or _asked_less:
        return
    with suppress(ImportError, AttributeError):
        pycompat, utils = (import_module(f"xarray.namedarray.{name}") for name in ("pycompat", "utils"))
        pycompat._cached_duck_array_modules.setdefault("dask", _Unasked(pycompat.DuckArrayModule))
        asks = utils.is_dask_collection
        utils.is_dask_collection = lambda value: "dask" in sys.modules and asks(value)
        _asked_less.append(True)
