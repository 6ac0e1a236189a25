"""Eight doubles in one vector register, as a type that compiled functions can compute with; `lanes` names it.

What compiled functions of the engine do with numbers is defined here for lanes too. No operation lets one lane see
another, so that a trajectory's numbers do not depend on which others share its register. Where the processor has
shorter registers the compiler splits them.
"""

import operator
from collections.abc import Callable
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.imputils import lower_cast
from numba.core.typeconv import Conversion
from numba.extending import models, overload, register_model

from chaosdrill.codegen.signatures import LANES
from chaosdrill.engine.uncompiled import Row, Table, as_lanes, machine_code

_VECTOR = ir.VectorType(ir.DoubleType(), LANES)
_TRUTHS = ir.VectorType(ir.IntType(1), LANES)
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


class MaskType(types.Type):
    """Of each of eight lanes whether something holds."""

    def __init__(self) -> None:
        super().__init__(name="Mask")


class RowType(types.Type):
    """A row of lanes in memory; row[k] are the lanes at place k."""

    def __init__(self) -> None:
        super().__init__(name="LaneRow")


class TableType(types.Type):
    """Rows of lanes of equal length; table[i] is row i."""

    def __init__(self) -> None:
        super().__init__(name="LaneTable")


lanes, mask, row, table = LanesType(), MaskType(), RowType(), TableType()


@register_model(LanesType)
class _LanesModel(models.PrimitiveModel):  # type: ignore[misc]
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, _VECTOR)


@register_model(MaskType)
class _MaskModel(models.PrimitiveModel):  # type: ignore[misc]
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, _TRUTHS)


@register_model(RowType)
class _RowModel(models.StructModel):  # type: ignore[misc]
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, [("data", types.CPointer(types.float64))])


@register_model(TableType)
class _TableModel(models.StructModel):  # type: ignore[misc]
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, [("data", types.CPointer(types.float64)), ("stride", types.intp)])


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


@machine_code(Row)
def row_of(typingctx: Any, array: Any) -> Any:
    """The row that an aligned array of shape (k, 8) holds."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        made = cgutils.create_struct_proxy(row)(context, builder)
        made.data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
        return made._getvalue()

    return row(array), code


@machine_code(Table)
def table_of(typingctx: Any, array: Any) -> Any:
    """The table that an aligned array of shape (rows, k, 8) holds."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        source = context.make_array(signature.args[0])(context, builder, arguments[0])
        made = cgutils.create_struct_proxy(table)(context, builder)
        made.data = source.data
        made.stride = builder.extract_value(source.shape, 1)
        return made._getvalue()

    return table(array), code


@machine_code(Table.__getitem__)
def _row_at(typingctx: Any, rows: Any, index: Any) -> Any:
    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        source = cgutils.create_struct_proxy(table)(context, builder, value=arguments[0])
        index = context.cast(builder, arguments[1], signature.args[1], types.intp)
        offset = builder.mul(builder.mul(index, source.stride), ir.Constant(_INT, LANES))
        made = cgutils.create_struct_proxy(row)(context, builder)
        made.data = builder.gep(source.data, [offset])
        return made._getvalue()

    return row(rows, index), code


@machine_code(Row.__getitem__)
def _load(typingctx: Any, line: Any, index: Any) -> Any:
    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        source = cgutils.create_struct_proxy(row)(context, builder, value=arguments[0])
        value = builder.load(_place(context, builder, source.data, signature.args[1], arguments[1]))
        value.align = 8 * LANES
        return value

    return lanes(line, index), code


@machine_code(Row.__setitem__)
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


def _binary(emit: Callable[[Any, Any, Any], Any], twin: Callable[[Any, Any], Any]) -> Any:
    """A compiled function of two lanes, of lanes and a number, or of two numbers; ``twin`` is one of arrays."""

    @machine_code(lambda first, second: _alike(twin(first, second)))
    def function(typingctx: Any, first: Any, second: Any) -> Any:
        if not _pair(first, second):
            return types.float64(types.float64, types.float64), lambda _, builder, __, arguments: emit(
                builder, *arguments
            )

        def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            pair = zip(signature.args, arguments, strict=True)
            return emit(builder, *(_as_lanes(context, builder, kind, value) for kind, value in pair))

        return lanes(first, second), code

    return function


def _operator(symbol: Any, emit: Callable[[Any, Any, Any], Any]) -> None:
    function = _binary(emit, symbol)

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


def _comparison(symbol: Any, emit: Callable[[Any, Any, Any], Any]) -> None:
    @machine_code(symbol)
    def function(typingctx: Any, first: Any, second: Any) -> Any:
        def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            pair = zip(signature.args, arguments, strict=True)
            return emit(builder, *(_as_lanes(context, builder, kind, value) for kind, value in pair))

        return mask(first, second), code

    @overload(symbol)
    def _overloaded(first, second):  # type: ignore[no-untyped-def]
        return (lambda first, second: function(first, second)) if _pair(first, second) else None


for _symbol, _sign in ((operator.lt, "<"), (operator.le, "<="), (operator.gt, ">"), (operator.ge, ">=")):
    _comparison(_symbol, lambda builder, a, b, sign=_sign: builder.fcmp_ordered(sign, a, b))
_comparison(operator.eq, lambda builder, a, b: builder.fcmp_ordered("==", a, b))
_comparison(operator.ne, lambda builder, a, b: builder.fcmp_unordered("!=", a, b))


def _of_masks(symbol: Any, emit: Callable[[Any, Any, Any], Any]) -> None:
    @machine_code(symbol)
    def function(typingctx: Any, first: Any, second: Any) -> Any:
        return mask(first, second), lambda _, builder, __, arguments: emit(builder, *arguments)

    @overload(symbol)
    def _overloaded(first, second):  # type: ignore[no-untyped-def]
        return (lambda first, second: function(first, second)) if first == second == mask else None


_of_masks(operator.and_, lambda builder, a, b: builder.and_(a, b))
_of_masks(operator.or_, lambda builder, a, b: builder.or_(a, b))


@machine_code(operator.invert)
def _not(typingctx: Any, holds: Any) -> Any:
    return mask(holds), lambda _, builder, __, arguments: builder.not_(arguments[0])


@overload(operator.invert)
def _invert(holds):  # type: ignore[no-untyped-def]
    return (lambda holds: _not(holds)) if holds == mask else None


def _larger(builder: Any, a: Any, b: Any) -> Any:
    return builder.select(builder.fcmp_ordered(">", b, a), b, a)


larger = _binary(_larger, lambda a, b: np.where(b > a, b, a))
"""The larger of either lane, or of two numbers; the first where the second is no number."""


def _smaller(builder: Any, a: Any, b: Any) -> Any:
    return builder.select(builder.fcmp_ordered("<", b, a), b, a)


smaller = _binary(_smaller, lambda a, b: np.where(b < a, b, a))
"""The smaller, likewise."""


@machine_code(lambda holds, first, second: _alike(np.where(holds, first, second)))
def chosen(typingctx: Any, holds: Any, first: Any, second: Any) -> Any:
    """Lanes of ``first`` where a mask holds, else of ``second``; or one of two numbers."""
    if holds != mask:
        number = types.float64(types.boolean, types.float64, types.float64)
        return number, lambda _, builder, __, arguments: builder.select(*arguments)

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        pair = zip(signature.args[1:], arguments[1:], strict=True)
        return builder.select(arguments[0], *(_as_lanes(context, builder, kind, value) for kind, value in pair))

    return lanes(holds, first, second), code


@machine_code(as_lanes)
def spread(typingctx: Any, value: Any) -> Any:
    """Eight lanes of one number."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return _as_lanes(context, builder, signature.args[0], arguments[0])

    return lanes(value), code


def _of_all(twin: Callable[[Any], Any], sign: str, bits: int) -> Any:
    """A compiled function of the truth values of a mask together, or of one, which it returns."""

    @machine_code(lambda holds: bool(twin(holds)))
    def function(typingctx: Any, holds: Any) -> Any:
        def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            if holds != mask:
                return arguments[0]
            packed = builder.bitcast(arguments[0], ir.IntType(LANES))
            return builder.icmp_unsigned(sign, packed, ir.Constant(packed.type, bits))

        return types.boolean(holds), code

    return function


some = _of_all(np.any, "!=", 0)
"""Whether a mask holds for any lane."""

every = _of_all(np.all, "==", 2**LANES - 1)
"""Whether it holds for all."""


@machine_code(np.size)
def width(typingctx: Any, value: Any) -> Any:
    """How many trajectories a value is of: eight, or one."""
    number = LANES if value == lanes else 1
    return types.int64(value), lambda *_: ir.Constant(_INT, number)


@machine_code(lambda number, value: as_lanes(number) if np.ndim(value) else number)
def as_wide(typingctx: Any, number: Any, value: Any) -> Any:
    """A number as a value is: lanes of it where that is lanes."""
    kind = lanes if value == lanes else types.float64

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return _spread(builder, arguments[0]) if value == lanes else arguments[0]

    return kind(types.float64, value), code


@machine_code(lambda value, lane: value[lane] if np.ndim(value) else value)
def lane_of(typingctx: Any, value: Any, lane: Any) -> Any:
    """The number in one lane; of a number itself."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.extract_element(*arguments) if value == lanes else arguments[0]

    return types.float64(value, types.int64), code


def _with_lane(value: Any, lane: int, number: float) -> Any:
    if not np.ndim(value):
        return number
    changed = value.copy()
    changed[lane] = number
    return changed


@machine_code(_with_lane)
def with_lane(typingctx: Any, value: Any, lane: Any, number: Any) -> Any:
    """Lanes of which one is that number."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        if value != lanes:
            return arguments[2]
        return builder.insert_element(arguments[0], arguments[2], arguments[1])

    return value(value, types.int64, types.float64), code


@machine_code(lambda array, places, column: as_lanes(array.reshape(len(array), -1)[places[:LANES], column]))
def gathered(typingctx: Any, array: Any, places: Any, column: Any) -> Any:
    """Lanes from eight places along the first axis of an array, at a column of what stands there."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        source = context.make_array(signature.args[0])(context, builder, arguments[0])
        which = context.make_array(signature.args[1])(context, builder, arguments[1])
        size = builder.sdiv(builder.extract_value(source.strides, 0), ir.Constant(_INT, 8))
        column = context.cast(builder, arguments[2], signature.args[2], types.intp)
        found = ir.Constant(_VECTOR, ir.Undefined)
        for lane in range(LANES):
            place = builder.load(builder.gep(which.data, [ir.Constant(_INT, lane)]))
            value = builder.load(builder.gep(source.data, [builder.add(builder.mul(place, size), column)]))
            value = context.cast(builder, value, signature.args[0].dtype, types.float64)
            found = builder.insert_element(found, value, ir.Constant(ir.IntType(32), lane))
        return found

    return lanes(array, places, column), code


def _neighbours(context: Any, builder: Any, kinds: Any, arguments: Any) -> Any:
    """Pointer to eight numbers of one row of an array: arguments are the array, the row and the column."""
    source = context.make_array(kinds[0])(context, builder, arguments[0])
    line, column = (
        context.cast(builder, value, kind, types.intp) for value, kind in zip(arguments[1:3], kinds[1:3], strict=True)
    )
    place = builder.add(builder.mul(line, builder.extract_value(source.shape, 1)), column)
    return builder.bitcast(builder.gep(source.data, [place]), _VECTOR.as_pointer())


@machine_code(lambda rows, i, k: as_lanes(rows[i, k : k + LANES]))
def part(typingctx: Any, rows: Any, i: Any, k: Any) -> Any:
    """Eight neighbours in row i of an array, from column k on."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        value = builder.load(_neighbours(context, builder, signature.args, arguments))
        value.align = 8
        return value

    return lanes(rows, i, k), code


def _put(rows: np.ndarray, i: int, k: int, value: Any) -> None:
    rows[i, k : k + LANES] = value


@machine_code(_put)
def put(typingctx: Any, rows: Any, i: Any, k: Any, value: Any) -> Any:
    """Write them."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        written = builder.store(arguments[3], _neighbours(context, builder, signature.args, arguments))
        written.align = 8
        return context.get_dummy_value()

    return types.void(rows, i, k, value), code


def _powers(s: float) -> Any:
    squares = zip((1, 2, 4), (s, s * s, (s * s) * (s * s)), strict=True)
    first, second, third = (np.where(np.arange(LANES) & bit, square, 1.0) for bit, square in squares)
    return as_lanes(first * second * third)


@machine_code(_powers)
def powers(typingctx: Any, s: Any) -> Any:
    """s**k in lane k."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        found, power = _constant(1.0), arguments[0]
        for bit in (1, 2, 4):
            wanted = ir.Constant(ir.VectorType(ir.IntType(1), LANES), [int(k & bit > 0) for k in range(LANES)])
            factor = builder.select(wanted, _spread(builder, power), _constant(1.0))
            found = factor if bit == 1 else builder.fmul(found, factor)
            power = builder.fmul(power, power)
        return found

    return lanes(s), code


def _total(value: np.ndarray) -> Any:
    while len(value) > 1:
        value = value[: len(value) // 2] + value[len(value) // 2 :]
    return value[0]


@machine_code(_total)
def total(typingctx: Any, value: Any) -> Any:
    """Sum of all lanes: of both halves, and so on.

    What are products are so rounded first. Where registers are shorter than lanes they would be fused with the sum of
    halves, and where they are not they would not: the last bit would tell the processor.
    """

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        found, half = _named("llvm.arithmetic.fence")(builder, arguments[0]), LANES // 2
        while half:
            first, second = (
                builder.shuffle_vector(
                    found,
                    ir.Constant(found.type, ir.Undefined),
                    ir.Constant(ir.VectorType(ir.IntType(32), half), list(range(begin, begin + half))),
                )
                for begin in (0, half)
            )
            found, half = builder.fadd(first, second), half // 2
        return builder.extract_element(found, ir.Constant(ir.IntType(32), 0))

    return types.float64(value), code


def _constant(value: float) -> Any:
    return ir.Constant(_VECTOR, [value] * LANES)


def _alike(value: Any) -> Any:
    """Lanes, or a number, of what numpy made of them."""
    return as_lanes(value) if np.ndim(value) else np.float64(value)


def _unary(emit: Callable[[Any, Any], Any], twin: Callable[[Any], Any]) -> Any:
    """A compiled function of lanes or of a number; ``twin`` is one of arrays."""

    @machine_code(lambda value: _alike(twin(np.asarray(value, dtype=float))))
    def function(typingctx: Any, value: Any) -> Any:
        kind = lanes if value == lanes else types.float64
        return kind(kind), lambda _, builder, __, arguments: emit(builder, arguments[0])

    return function


def _named(name: str) -> Callable[[Any, Any], Any]:
    """An operation that the compiler knows by name."""

    def emit(builder: Any, value: Any) -> Any:
        suffix = "f64" if value.type == ir.DoubleType() else f"v{LANES}f64"
        kind = ir.FunctionType(value.type, [value.type])
        return builder.call(builder.module.declare_intrinsic(f"{name}.{suffix}", (), kind), [value])

    return emit


magnitude = _unary(_named("llvm.fabs"), np.abs)
"""Absolute values."""

floor = _unary(_named("llvm.floor"), np.floor)
"""The largest whole number that is not above."""

_FRACTION = 52
"""Bits of a double's fraction."""

_BIAS = 1023.0
"""What is added to its exponent."""


def _bits(builder: Any, value: Any, change: Callable[[Callable[[int], Any], Any], Any]) -> Any:
    """A number whose bits are changed as whole numbers."""
    one = value.type == ir.DoubleType()
    kind = _INT if one else ir.VectorType(_INT, LANES)
    changed = change(lambda whole: ir.Constant(kind, whole if one else [whole] * LANES), builder.bitcast(value, kind))
    return builder.bitcast(changed, value.type)


def _like(value: Any, number: float) -> Any:
    return ir.Constant(value.type, number) if value.type == ir.DoubleType() else _constant(number)


def _exponent(builder: Any, value: Any) -> Any:
    # a whole number below 2**52 in the fraction of 2**52 is that number
    shifted = _bits(
        builder,
        value,
        lambda whole, bits: builder.or_(builder.lshr(bits, whole(_FRACTION)), whole(0x4330000000000000)),
    )
    return builder.fsub(shifted, _like(value, 2.0**_FRACTION + _BIAS))


def _mantissa(builder: Any, value: Any) -> Any:
    return _bits(
        builder,
        value,
        lambda whole, bits: builder.or_(builder.and_(bits, whole(0xFFFFFFFFFFFFF)), whole(0x3FF0000000000000)),
    )


def _power_of_two(builder: Any, value: Any) -> Any:
    biased = builder.fadd(value, _like(value, 2.0**_FRACTION + _BIAS))
    return _bits(builder, biased, lambda whole, bits: builder.shl(bits, whole(_FRACTION)))


exponent = _unary(_exponent, lambda value: (value.view(np.uint64) >> _FRACTION) - _BIAS)
"""n of a number m 2**n above zero, 1 <= m < 2."""

mantissa = _unary(
    _mantissa,
    lambda value: (value.view(np.uint64) & 0xFFFFFFFFFFFFF | 0x3FF0000000000000).view(float),
)
"""m of it."""

power_of_two = _unary(
    _power_of_two, lambda value: ((value + (2.0**_FRACTION + _BIAS)).view(np.uint64) << _FRACTION).view(float)
)
"""2**n for whole numbers n, as far as numbers reach."""


@overload(operator.neg)
def _neg(value):  # type: ignore[no-untyped-def]
    return (lambda value: _negative(value)) if value == lanes else None


_negative = _unary(lambda builder, value: builder.fneg(value), np.negative)
