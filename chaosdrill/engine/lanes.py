"""Operations of eight doubles side by side, by name: what they are to a compiler stands in `lane_code`."""

import math
from functools import cached_property
from importlib import import_module
from typing import Any

import numpy as np

from chaosdrill.codegen.kinds import UNCOMPILED, Late
from chaosdrill.codegen.signatures import LANES


def aligned(*shape: int) -> np.ndarray:
    """Zeros of which every eight stand in one line of the cache, as the loads of lanes ask for; the last length is a
    multiple of eight."""
    count = math.prod(shape)
    buffer = np.zeros(count + LANES)
    first = -(buffer.ctypes.data // buffer.itemsize) % LANES
    return buffer[first : first + count].reshape(shape)


class Operation(Late):
    """One of `lane_code`, which compiled functions call."""

    def __init__(self, name: str) -> None:
        self.name = name

    @cached_property
    def real(self) -> Any:
        return getattr(import_module("chaosdrill.engine.lane_code"), self.name)


def _named(name: str) -> Any:
    operation = Operation(name)
    return operation.real if UNCOMPILED else operation


row_of = _named("row_of")
table_of = _named("table_of")
larger = _named("larger")
smaller = _named("smaller")
chosen = _named("chosen")
spread = _named("spread")
some = _named("some")
every = _named("every")
width = _named("width")
as_wide = _named("as_wide")
lane_of = _named("lane_of")
with_lane = _named("with_lane")
gathered = _named("gathered")
part = _named("part")
put = _named("put")
powers = _named("powers")
total = _named("total")
magnitude = _named("magnitude")
floor = _named("floor")
exponent = _named("exponent")
mantissa = _named("mantissa")
power_of_two = _named("power_of_two")
