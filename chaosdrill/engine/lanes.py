"""Eight doubles in one vector register, as a type that compiled functions can compute with.

What compiled functions of the engine do with numbers is defined here for lanes too. No operation lets one lane see
another, so that a trajectory's numbers do not depend on which others share its register. Where the processor has
shorter registers the compiler splits them.
"""

import math
import operator
from collections.abc import Callable
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.imputils import lower_cast
from numba.core.typeconv import Conversion
from numba.extending import intrinsic, models, overload, register_model

from chaosdrill.codegen.signatures import LANES

_VECTOR = ir.VectorType(ir.DoubleType(), LANES)
_INT = ir.IntType(64)
_NUMBER = (types.Float, types.Integer)


class LanesType(types.Type):
    """Eight doubles; a plain number stands for eight equal ones."""

    def __init__(self) -> None:
        super().__init__(name="Lanes")

    def can_convert_from(self, typingctx: Any, other: Any) -> Any:
        return Conversion.safe if isinstance(other, _NUMBER) else None

    def unify(self, typingctx: Any, other: Any) -> Any:
        return self if isinstance(other, _NUMBER) else None


class RowType(types.Type):
    """A row of lanes in memory; row[k] are the lanes at place k."""

    def __init__(self) -> None:
        super().__init__(name="LaneRow")


class TableType(types.Type):
    """Rows of lanes of equal length; table[i] is row i."""

    def __init__(self) -> None:
        super().__init__(name="LaneTable")


lanes, row, table = LanesType(), RowType(), TableType()


@register_model(LanesType)
class _LanesModel(models.PrimitiveModel):  # type: ignore[misc]
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, _VECTOR)


@register_model(RowType)
class _RowModel(models.StructModel):  # type: ignore[misc]
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, [("data", types.CPointer(types.float64))])


@register_model(TableType)
class _TableModel(models.StructModel):  # type: ignore[misc]
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, [("data", types.CPointer(types.float64)), ("stride", types.intp)])


def aligned(*shape: int) -> np.ndarray:
    """Zeros of which every eight stand in one line of the cache, as the loads of lanes ask for.

    Parameters
    ----------
    *shape : int
        The last one a multiple of eight.
    """
    count = math.prod(shape)
    buffer = np.zeros(count + LANES)
    first = -(buffer.ctypes.data // buffer.itemsize) % LANES
    return buffer[first : first + count].reshape(shape)


def _spread(builder: Any, value: Any) -> Any:
    zero = ir.Constant(ir.IntType(32), 0)
    one = builder.insert_element(ir.Constant(_VECTOR, ir.Undefined), value, zero)
    return builder.shuffle_vector(one, one, ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES))


@lower_cast(types.Float, LanesType)
@lower_cast(types.Integer, LanesType)
def _from_number(context: Any, builder: Any, kind: Any, _: Any, value: Any) -> Any:
    return _spread(builder, context.cast(builder, value, kind, types.float64))


def _as_lanes(context: Any, builder: Any, kind: Any, value: Any) -> Any:
    return value if kind == lanes else _from_number(context, builder, kind, lanes, value)


def _place(context: Any, builder: Any, data: Any, kind: Any, index: Any) -> Any:
    index = context.cast(builder, index, kind, types.intp)
    return builder.bitcast(builder.gep(data, [builder.mul(index, ir.Constant(_INT, LANES))]), _VECTOR.as_pointer())


@intrinsic
def row_of(typingctx: Any, array: Any) -> Any:
    """The row that an aligned array of shape (k, 8) holds."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        made = cgutils.create_struct_proxy(row)(context, builder)
        made.data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
        return made._getvalue()

    return row(array), code


@intrinsic
def table_of(typingctx: Any, array: Any) -> Any:
    """The table that an aligned array of shape (rows, k, 8) holds."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        source = context.make_array(signature.args[0])(context, builder, arguments[0])
        made = cgutils.create_struct_proxy(table)(context, builder)
        made.data = source.data
        made.stride = builder.extract_value(source.shape, 1)
        return made._getvalue()

    return table(array), code


@intrinsic
def _row_at(typingctx: Any, rows: Any, index: Any) -> Any:
    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        source = cgutils.create_struct_proxy(table)(context, builder, value=arguments[0])
        index = context.cast(builder, arguments[1], signature.args[1], types.intp)
        offset = builder.mul(builder.mul(index, source.stride), ir.Constant(_INT, LANES))
        made = cgutils.create_struct_proxy(row)(context, builder)
        made.data = builder.gep(source.data, [offset])
        return made._getvalue()

    return row(rows, index), code


@intrinsic
def _load(typingctx: Any, line: Any, index: Any) -> Any:
    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        source = cgutils.create_struct_proxy(row)(context, builder, value=arguments[0])
        value = builder.load(_place(context, builder, source.data, signature.args[1], arguments[1]))
        value.align = 8 * LANES
        return value

    return lanes(line, index), code


@intrinsic
def _store(typingctx: Any, line: Any, index: Any, value: Any) -> Any:
    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        target = cgutils.create_struct_proxy(row)(context, builder, value=arguments[0])
        place = _place(context, builder, target.data, signature.args[1], arguments[1])
        written = builder.store(_as_lanes(context, builder, signature.args[2], arguments[2]), place)
        written.align = 8 * LANES
        return context.get_dummy_value()

    return types.void(line, index, value), code


@overload(operator.getitem)
def _getitem(place, index):  # type: ignore[no-untyped-def]
    if isinstance(place, RowType) and isinstance(index, types.Integer):
        return lambda place, index: _load(place, index)
    if isinstance(place, TableType) and isinstance(index, types.Integer):
        return lambda place, index: _row_at(place, index)
    return None


@overload(operator.setitem)
def _setitem(place, index, value):  # type: ignore[no-untyped-def]
    if isinstance(place, RowType) and isinstance(index, types.Integer):
        return lambda place, index, value: _store(place, index, value)
    return None


def _pair(first: Any, second: Any) -> bool:
    """Whether two types are lanes, or lanes and a number."""
    kinds = (first, second)
    return lanes in kinds and all(k == lanes or isinstance(k, _NUMBER) for k in kinds)


def _binary(emit: Callable[[Any, Any, Any], Any]) -> Any:
    """A compiled function of two lanes, or of lanes and a number."""

    @intrinsic
    def function(typingctx: Any, first: Any, second: Any) -> Any:
        def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            pair = zip(signature.args, arguments, strict=True)
            return emit(builder, *(_as_lanes(context, builder, kind, value) for kind, value in pair))

        return lanes(first, second), code

    return function


def _operator(symbol: Any, emit: Callable[[Any, Any, Any], Any]) -> None:
    function = _binary(emit)

    @overload(symbol)
    def _overloaded(first, second):  # type: ignore[no-untyped-def]
        return (lambda first, second: function(first, second)) if _pair(first, second) else None


for _symbols, _name in (
    ((operator.add, operator.iadd), "fadd"),
    ((operator.sub, operator.isub), "fsub"),
    ((operator.mul, operator.imul), "fmul"),
    ((operator.truediv, operator.itruediv), "fdiv"),
):
    for _symbol in _symbols:
        _operator(_symbol, lambda builder, a, b, name=_name: getattr(builder, name)(a, b))


def _larger(builder: Any, a: Any, b: Any) -> Any:
    return builder.select(builder.fcmp_ordered(">", b, a), b, a)


larger = _binary(_larger)
"""The larger of either lane; the first where the second is no number."""


@intrinsic
def chosen(typingctx: Any, mask: Any, first: Any, second: Any) -> Any:
    """Lanes of ``first`` where ``mask`` is not 0.0, else of ``second``."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        test = builder.fcmp_unordered("!=", arguments[0], ir.Constant(_VECTOR, [0.0] * LANES))
        return builder.select(test, arguments[1], arguments[2])

    return lanes(mask, first, second), code


@intrinsic
def _negative(typingctx: Any, value: Any) -> Any:
    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.fneg(arguments[0])

    return lanes(value), code


@overload(operator.neg)
def _neg(value):  # type: ignore[no-untyped-def]
    return (lambda value: _negative(value)) if value == lanes else None


def _operation(builder: Any, name: str) -> Any:
    return builder.module.declare_intrinsic(f"{name}.v{LANES}f64", (), ir.FunctionType(_VECTOR, [_VECTOR]))


def _unary(name: str) -> Any:
    """A compiled function of lanes that is an operation of the compiler's own."""

    @intrinsic
    def function(typingctx: Any, value: Any) -> Any:
        def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            return builder.call(_operation(builder, name), arguments)

        return lanes(value), code

    return function


magnitude = _unary("llvm.fabs")
"""Absolute values."""
