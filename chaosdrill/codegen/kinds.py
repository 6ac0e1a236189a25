"""Types of compiled code by name: numba's own are made where something is compiled, and not where it only runs."""

import os
from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np

UNCOMPILED = bool(int(os.environ.get("NUMBA_DISABLE_JIT") or 0))
"""Whether Python runs what else is compiled."""


class Late:
    """Something of numba that is there when something is compiled."""

    @cached_property
    def real(self) -> Any:
        """That of numba."""
        raise NotImplementedError


class Kind(Late):
    """A type; arrays of it are written as in numba, ``float64[:, ::1]``, and so are signatures, ``void(int64)``."""

    ndim = 0

    def __init__(self, name: str) -> None:
        self.name = name

    def __getitem__(self, places: Any) -> "Array":
        return Array(self, len(places) if isinstance(places, tuple) else 1)

    def __call__(self, *given: Any) -> Any:
        if all(isinstance(one, Kind) for one in given):
            return Signature(self, given)
        # a number, where Python runs what else is compiled
        return getattr(np, self.name)(*given)

    @cached_property
    def real(self) -> Any:
        from numba import types

        return getattr(types, self.name)


class Array(Kind):
    """Arrays in C order."""

    def __init__(self, dtype: Kind, ndim: int) -> None:
        super().__init__(f"array of {dtype.name}")
        self.dtype, self.ndim = dtype, ndim

    @cached_property
    def real(self) -> Any:
        from numba import types

        return types.Array(self.dtype.real, self.ndim, "C")


class RecordOf(Kind):
    """An entry of a structured array."""

    def __init__(self, dtype: np.dtype) -> None:
        super().__init__("record")
        self.dtype = dtype

    @cached_property
    def real(self) -> Any:
        from numba import from_dtype

        return from_dtype(self.dtype)


class Tuple(Kind):
    """Several values."""

    def __init__(self, parts: Sequence[Kind]) -> None:
        super().__init__("tuple")
        self.parts = tuple(parts)

    @cached_property
    def real(self) -> Any:
        from numba import types

        return types.Tuple([part.real for part in self.parts])


class NamedTuple(Tuple):
    """A record of values, which keeps the names of compiled functions short by that of its class."""

    def __init__(self, parts: Sequence[Kind], cls: type) -> None:
        super().__init__(tuple(parts))
        self.cls = cls

    @cached_property
    def real(self) -> Any:
        from numba import types

        kind = types.NamedTuple(tuple(part.real for part in self.parts), self.cls)
        kind.name = self.cls.__name__
        return kind


class Pointer(Kind):
    """A function that is called by its address; the name keeps the names of compiled functions short."""

    def __init__(self, name: str, signature: "Signature") -> None:
        super().__init__(name)
        self.signature = signature

    @cached_property
    def real(self) -> Any:
        from numba import types

        kind = types.ExternalFunctionPointer(self.signature.real, None)
        kind.name = self.name
        return kind


class Signature(Late):
    """What a function takes and what it returns."""

    def __init__(self, return_type: Kind, args: Sequence[Kind]) -> None:
        self.return_type, self.args = return_type, tuple(args)

    @cached_property
    def real(self) -> Any:
        return self.return_type.real(*(one.real for one in self.args))


boolean, float64, int64, uint64, void = map(Kind, ("boolean", "float64", "int64", "uint64", "void"))


def numpy_type(kind: Kind) -> np.dtype:
    """The type of numpy of what an array of a kind holds."""
    return kind.dtype if isinstance(kind, RecordOf) else np.dtype(kind.name)
