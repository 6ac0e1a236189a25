"""Eight doubles in one vector register, as a type that compiled functions can compute with; `lanes` names it.

What compiled functions of the engine do with numbers is defined here for lanes too. No operation lets one lane see
another, so that a trajectory's numbers do not depend on which others share its register. Where the processor has
shorter registers the compiler splits them.
"""

import inspect
import operator
from collections.abc import Callable
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.imputils import lower_cast
from numba.core.typeconv import Conversion
from numba.core.typing import Signature
from numba.extending import models, overload, register_model

from chaosdrill.codegen.signatures import LANES
from chaosdrill.engine.uncompiled import Row, Table, as_lanes, machine_code

_VECTOR = ir.VectorType(ir.DoubleType(), LANES)
_TRUTHS = ir.VectorType(ir.IntType(1), LANES)
_INT, _SHORT = ir.IntType(64), ir.IntType(32)
_NUMBER = (types.Float, types.Integer)


class LanesType(types.Type):
    """Eight doubles; a plain number stands for eight equal ones."""

    def can_convert_from(self, typingctx: Any, other: Any) -> Any:
        return Conversion.safe if isinstance(other, _NUMBER) else None

    def unify(self, typingctx: Any, other: Any) -> Any:
        return self if isinstance(other, _NUMBER) else None


class MaskType(types.Type):
    """Of each of eight lanes whether something holds."""


class RowType(types.Type):
    """A row of lanes in memory; row[k] are the lanes at place k."""


class TableType(types.Type):
    """Rows of lanes of equal length; table[i] is row i."""


lanes, mask, row, table = LanesType("Lanes"), MaskType("Mask"), RowType("LaneRow"), TableType("LaneTable")


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


def _operation(
    twin: Callable[..., Any], result: Callable[..., Any] = lambda *kinds: lanes, *, count: int | None = None
) -> Callable[[Any], Any]:
    """Make an operation that compiled functions call of what writes its code.

    ``twin`` does the same in Python, to the bit. ``result`` gives the type of the result, or the whole signature, from
    the types of the arguments. There are ``count`` of these, by default as many as the twin has.
    """
    names = ("typingctx", *(f"a{i}" for i in range(count or len(inspect.signature(twin).parameters))))

    def made(emit: Callable[[Any, Any, Any, Any], Any]) -> Any:
        def function(typingctx: Any, *kinds: Any) -> Any:
            found = result(*kinds)
            signature = found if isinstance(found, Signature) else found(*kinds)
            return signature, lambda context, builder, own, arguments: emit(context, builder, own.args, arguments)

        plain = inspect.Parameter.POSITIONAL_OR_KEYWORD
        vars(function)["__signature__"] = inspect.Signature([inspect.Parameter(name, plain) for name in names])
        return machine_code(twin)(function)

    return made


def _spread(builder: Any, value: Any) -> Any:
    one = builder.insert_element(ir.Constant(_VECTOR, ir.Undefined), value, _SHORT(0))
    return builder.shuffle_vector(one, one, ir.Constant(ir.VectorType(_SHORT, LANES), [0] * LANES))


@lower_cast(types.Float, LanesType)
@lower_cast(types.Integer, LanesType)
def _from_number(context: Any, builder: Any, kind: Any, _: Any, value: Any) -> Any:
    return _spread(builder, context.cast(builder, value, kind, types.float64))


def _as_lanes(context: Any, builder: Any, kinds: Any, values: Any) -> list[Any]:
    """Values as lanes, whatever of them is a number."""
    pairs = zip(kinds, values, strict=True)
    return [value if kind == lanes else _from_number(context, builder, kind, lanes, value) for kind, value in pairs]


def _struct(context: Any, builder: Any, kind: Any, **fields: Any) -> Any:
    made = cgutils.create_struct_proxy(kind)(context, builder)
    for name, value in fields.items():
        setattr(made, name, value)
    return made._getvalue()


@_operation(Row, lambda array: row)
def row_of(context: Any, builder: Any, kinds: Any, arguments: Any) -> Any:
    """The row that an aligned array of shape (k, 8) holds."""
    return _struct(context, builder, row, data=context.make_array(kinds[0])(context, builder, arguments[0]).data)


@_operation(Table, lambda array: table)
def table_of(context: Any, builder: Any, kinds: Any, arguments: Any) -> Any:
    """The table that an aligned array of shape (rows, k, 8) holds."""
    source = context.make_array(kinds[0])(context, builder, arguments[0])
    return _struct(context, builder, table, data=source.data, stride=builder.extract_value(source.shape, 1))


@_operation(Table.__getitem__, lambda rows, index: row)
def _row_at(context: Any, builder: Any, kinds: Any, arguments: Any) -> Any:
    source = cgutils.create_struct_proxy(table)(context, builder, value=arguments[0])
    index = context.cast(builder, arguments[1], kinds[1], types.intp)
    offset = builder.mul(builder.mul(index, source.stride), _INT(LANES))
    return _struct(context, builder, row, data=builder.gep(source.data, [offset]))


def _place(context: Any, builder: Any, kinds: Any, arguments: Any) -> Any:
    """Pointer to the lanes at a place of a row."""
    source = cgutils.create_struct_proxy(row)(context, builder, value=arguments[0])
    index = context.cast(builder, arguments[1], kinds[1], types.intp)
    return builder.bitcast(builder.gep(source.data, [builder.mul(index, _INT(LANES))]), _VECTOR.as_pointer())


@_operation(Row.__getitem__)
def _load(context: Any, builder: Any, kinds: Any, arguments: Any) -> Any:
    value = builder.load(_place(context, builder, kinds, arguments))
    value.align = 8 * LANES
    return value


@_operation(Row.__setitem__, lambda line, index, value: types.void)
def _store(context: Any, builder: Any, kinds: Any, arguments: Any) -> Any:
    (value,) = _as_lanes(context, builder, kinds[2:], arguments[2:])
    builder.store(value, _place(context, builder, kinds, arguments)).align = 8 * LANES
    return context.get_dummy_value()


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


def _alike(value: Any) -> Any:
    """Lanes, or a number, of what numpy made of them."""
    return as_lanes(value) if np.ndim(value) else np.float64(value)


def _wide(kinds: Any) -> bool:
    """Whether types are lanes, or lanes and numbers."""
    return lanes in kinds and all(kind == lanes or isinstance(kind, _NUMBER) for kind in kinds)


def _of_numbers(emit: Callable[..., Any], twin: Callable[..., Any], result: Any = None) -> Any:
    """An operation on lanes, on lanes and numbers, or on numbers alone, by what writes it of values of one type.

    ``twin`` is one of arrays; ``result`` is the type of the result, where that is not the arguments'.
    """

    def typed(*kinds: Any) -> Any:
        return result or lanes if _wide(kinds) else types.float64(*[types.float64] * len(kinds))

    count = len(inspect.signature(emit).parameters) - 1

    @_operation(lambda *values: _alike(twin(*(np.asarray(v, dtype=float) for v in values))), typed, count=count)
    def function(context: Any, builder: Any, kinds: Any, arguments: Any) -> Any:
        return emit(builder, *(_as_lanes(context, builder, kinds, arguments) if lanes in kinds else arguments))

    return function


def _by_name(name: str, *first: Any) -> Callable[[Any, Any, Any], Any]:
    """What writes an instruction of two values."""
    return lambda builder, a, b: getattr(builder, name)(*first, a, b)


def _of_masks(symbol: Any, name: str) -> Any:
    @_operation(symbol, lambda first, second: mask)
    def function(context: Any, builder: Any, kinds: Any, arguments: Any) -> Any:
        return getattr(builder, name)(*arguments)

    return function


def _operator(symbol: Any, function: Any, applies: Callable[[Any], bool]) -> None:
    """Let an operator of two do this where it applies to the types."""

    @overload(symbol)
    def _overloaded(first, second):  # type: ignore[no-untyped-def]
        return (lambda first, second: function(first, second)) if applies((first, second)) else None


for _symbols, _name in (
    ((operator.add, operator.iadd), "fadd"),
    ((operator.sub, operator.isub), "fsub"),
    ((operator.mul, operator.imul), "fmul"),
    ((operator.truediv, operator.itruediv), "fdiv"),
):
    _done = _of_numbers(_by_name(_name), _symbols[0])
    for _symbol in _symbols:
        _operator(_symbol, _done, _wide)

for _symbol, _sign in (
    *((operator.lt, "<"), (operator.le, "<="), (operator.gt, ">"), (operator.ge, ">=")),
    *((operator.eq, "=="), (operator.ne, "!=")),
):
    _done = _of_numbers(_by_name("fcmp_unordered" if _sign == "!=" else "fcmp_ordered", _sign), _symbol, mask)
    _operator(_symbol, _done, _wide)

for _symbol, _name in ((operator.and_, "and_"), (operator.or_, "or_")):
    _operator(_symbol, _of_masks(_symbol, _name), lambda kinds: kinds == (mask, mask))


@_operation(operator.invert, lambda holds: mask)
def _not(context: Any, builder: Any, kinds: Any, arguments: Any) -> Any:
    return builder.not_(arguments[0])


@overload(operator.invert)
def _invert(holds):  # type: ignore[no-untyped-def]
    return (lambda holds: _not(holds)) if holds == mask else None


def _selected(sign: str) -> Callable[..., Any]:
    return lambda builder, a, b: builder.select(builder.fcmp_ordered(sign, b, a), b, a)


larger = _of_numbers(_selected(">"), lambda a, b: np.where(b > a, b, a))
"""The larger of either lane, or of two numbers; the first where the second is no number."""

smaller = _of_numbers(_selected("<"), lambda a, b: np.where(b < a, b, a))
"""The smaller, likewise."""


@_operation(
    lambda holds, first, second: _alike(np.where(holds, first, second)),
    lambda holds, *_: lanes if holds == mask else types.float64(types.boolean, types.float64, types.float64),
)
def chosen(context: Any, builder: Any, kinds: Any, arguments: Any) -> Any:
    """Lanes of ``first`` where a mask holds, else of ``second``; or one of two numbers."""
    wide = kinds[0] == mask
    return builder.select(
        arguments[0], *(_as_lanes(context, builder, kinds[1:], arguments[1:]) if wide else arguments[1:])
    )


@_operation(as_lanes)
def spread(context: Any, builder: Any, kinds: Any, arguments: Any) -> Any:
    """Eight lanes of one number."""
    return _as_lanes(context, builder, kinds, arguments)[0]


def _of_all(twin: Callable[[Any], Any], sign: str, bits: int) -> Any:
    """A compiled function of the truth values of a mask together, or of one, which it returns."""

    @_operation(lambda holds: bool(twin(holds)), lambda holds: types.boolean)
    def function(context: Any, builder: Any, kinds: Any, arguments: Any) -> Any:
        if kinds[0] != mask:
            return arguments[0]
        packed = builder.bitcast(arguments[0], ir.IntType(LANES))
        return builder.icmp_unsigned(sign, packed, ir.Constant(packed.type, bits))

    return function


some = _of_all(np.any, "!=", 0)
"""Whether a mask holds for any lane."""

every = _of_all(np.all, "==", 2**LANES - 1)
"""Whether it holds for all."""


@_operation(lambda value: np.size(value), lambda value: types.int64)
def width(context: Any, builder: Any, kinds: Any, arguments: Any) -> Any:
    """How many trajectories a value is of: eight, or one."""
    return _INT(LANES if kinds[0] == lanes else 1)


@_operation(
    lambda number, value: as_lanes(number) if np.ndim(value) else number,
    lambda number, value: (lanes if value == lanes else types.float64)(types.float64, value),
)
def as_wide(context: Any, builder: Any, kinds: Any, arguments: Any) -> Any:
    """A number as a value is: lanes of it where that is lanes."""
    return _spread(builder, arguments[0]) if kinds[1] == lanes else arguments[0]


@_operation(
    lambda value, lane: value[lane] if np.ndim(value) else value, lambda value, lane: types.float64(value, types.int64)
)
def lane_of(context: Any, builder: Any, kinds: Any, arguments: Any) -> Any:
    """The number in one lane; of a number itself."""
    return builder.extract_element(*arguments) if kinds[0] == lanes else arguments[0]


def _with_lane(value: Any, lane: int, number: float) -> Any:
    if not np.ndim(value):
        return number
    changed = value.copy()
    changed[lane] = number
    return changed


@_operation(_with_lane, lambda value, lane, number: value(value, types.int64, types.float64))
def with_lane(context: Any, builder: Any, kinds: Any, arguments: Any) -> Any:
    """Lanes of which one is that number."""
    value, lane, number = arguments
    return builder.insert_element(value, number, lane) if kinds[0] == lanes else number


@_operation(lambda array, places, column: as_lanes(array.reshape(len(array), -1)[places[:LANES], column]))
def gathered(context: Any, builder: Any, kinds: Any, arguments: Any) -> Any:
    """Lanes from eight places along the first axis of an array, at a column of what stands there."""
    source, which = (context.make_array(kinds[i])(context, builder, arguments[i]) for i in range(2))
    size = builder.sdiv(builder.extract_value(source.strides, 0), _INT(8))
    column = context.cast(builder, arguments[2], kinds[2], types.intp)
    found = ir.Constant(_VECTOR, ir.Undefined)
    for lane in range(LANES):
        place = builder.load(builder.gep(which.data, [_INT(lane)]))
        value = builder.load(builder.gep(source.data, [builder.add(builder.mul(place, size), column)]))
        value = context.cast(builder, value, kinds[0].dtype, types.float64)
        found = builder.insert_element(found, value, _SHORT(lane))
    return found


def _neighbours(context: Any, builder: Any, kinds: Any, arguments: Any) -> Any:
    """Pointer to eight numbers of one row of an array: arguments are the array, the row and the column."""
    source = context.make_array(kinds[0])(context, builder, arguments[0])
    line, column = (context.cast(builder, arguments[i], kinds[i], types.intp) for i in (1, 2))
    place = builder.add(builder.mul(line, builder.extract_value(source.shape, 1)), column)
    return builder.bitcast(builder.gep(source.data, [place]), _VECTOR.as_pointer())


@_operation(lambda rows, i, k: as_lanes(rows[i, k : k + LANES]))
def part(context: Any, builder: Any, kinds: Any, arguments: Any) -> Any:
    """Eight neighbours in row i of an array, from column k on."""
    value = builder.load(_neighbours(context, builder, kinds, arguments))
    value.align = 8
    return value


def _put(rows: np.ndarray, i: int, k: int, value: Any) -> None:
    rows[i, k : k + LANES] = value


@_operation(_put, lambda rows, i, k, value: types.void)
def put(context: Any, builder: Any, kinds: Any, arguments: Any) -> Any:
    """Write them."""
    builder.store(arguments[3], _neighbours(context, builder, kinds, arguments)).align = 8
    return context.get_dummy_value()


def _powers(s: float) -> Any:
    squares = zip((1, 2, 4), (s, s * s, (s * s) * (s * s)), strict=True)
    first, second, third = (np.where(np.arange(LANES) & bit, square, 1.0) for bit, square in squares)
    return as_lanes(first * second * third)


@_operation(_powers)
def powers(context: Any, builder: Any, kinds: Any, arguments: Any) -> Any:
    """s**k in lane k."""
    found, power = _constant(1.0), arguments[0]
    for bit in (1, 2, 4):
        wanted = ir.Constant(_TRUTHS, [int(k & bit > 0) for k in range(LANES)])
        factor = builder.select(wanted, _spread(builder, power), _constant(1.0))
        found = factor if bit == 1 else builder.fmul(found, factor)
        power = builder.fmul(power, power)
    return found


def _total(value: np.ndarray) -> Any:
    while len(value) > 1:
        value = value[: len(value) // 2] + value[len(value) // 2 :]
    return value[0]


@_operation(_total, lambda value: types.float64)
def total(context: Any, builder: Any, kinds: Any, arguments: Any) -> Any:
    """Sum of all lanes: of both halves, and so on.

    What are products are so rounded first. Where registers are shorter than lanes they would be fused with the sum of
    halves, and where they are not they would not: the last bit would tell the processor.
    """
    found, half = _named("llvm.arithmetic.fence")(builder, arguments[0]), LANES // 2
    while half:
        places = (ir.Constant(ir.VectorType(_SHORT, half), list(range(begin, begin + half))) for begin in (0, half))
        nothing = ir.Constant(found.type, ir.Undefined)
        found = builder.fadd(*[builder.shuffle_vector(found, nothing, each) for each in places])
        half //= 2
    return builder.extract_element(found, _SHORT(0))


def _constant(value: float) -> Any:
    return ir.Constant(_VECTOR, [value] * LANES)


def _named(name: str) -> Callable[[Any, Any], Any]:
    """An operation that the compiler knows by name."""

    def emit(builder: Any, value: Any) -> Any:
        suffix = "f64" if value.type == ir.DoubleType() else f"v{LANES}f64"
        kind = ir.FunctionType(value.type, [value.type])
        return builder.call(builder.module.declare_intrinsic(f"{name}.{suffix}", (), kind), [value])

    return emit


magnitude = _of_numbers(_named("llvm.fabs"), np.abs)
"""Absolute values."""

floor = _of_numbers(_named("llvm.floor"), np.floor)
"""The largest whole number that is not above."""

_negative = _of_numbers(lambda builder, value: builder.fneg(value), np.negative)


@overload(operator.neg)
def _neg(value):  # type: ignore[no-untyped-def]
    return (lambda value: _negative(value)) if value == lanes else None


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
        builder, value, lambda whole, bits: builder.or_(builder.lshr(bits, whole(_FRACTION)), whole(0x4330000000000000))
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


exponent = _of_numbers(_exponent, lambda value: (value.view(np.uint64) >> _FRACTION) - _BIAS)
"""n of a number m 2**n above zero, 1 <= m < 2."""

mantissa = _of_numbers(
    _mantissa, lambda value: (value.view(np.uint64) & 0xFFFFFFFFFFFFF | 0x3FF0000000000000).view(float)
)
"""m of it."""

power_of_two = _of_numbers(
    _power_of_two, lambda value: ((value + (2.0**_FRACTION + _BIAS)).view(np.uint64) << _FRACTION).view(float)
)
"""2**n for whole numbers n, as far as numbers reach."""
