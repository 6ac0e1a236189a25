"""numba as a front end: from a function of the engine, and what it calls, to one module of LLVM code.

By numba's inner parts (`inner_parts`) nothing is optimised that becomes a part of something else. Where a numba has
changed them, its public parts do the same: functions are then compiled once a level of calls, which took 1.7 times as
long when both were measured. Results are the same but for rounding where operations may be fused.
"""

from collections.abc import Callable
from importlib import import_module
from typing import Any

import llvmlite.binding as llvm
import numba
from llvmlite import ir
from numba import types
from numba.core.imputils import lower_getattr_generic
from numba.core.typing.templates import AttributeTemplate, infer_getattr
from numba.extending import intrinsic, models, register_jitable, register_model

from chaosdrill.codegen.machine import FROM_WORDS
from chaosdrill.codegen.signatures import event_places

# what operators do with lanes
import_module("chaosdrill.engine.lane_code")

# a numba that has them no more, or under other names
try:
    from chaosdrill.engine import inner_parts
except (ImportError, AttributeError):
    inner_parts = None

WORD = ir.IntType(64)
WORDS = WORD.as_pointer()

_CALLBACK = {"error_model": "numpy", "_nrt": False}
PLAIN = _CALLBACK | {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
"""Options of numba for the engine: no arithmetic errors, no allocation, no calls from Python."""


register_jitable(event_places)


def _load(builder: Any, words: Any, place: int, kind: Any, *, stays: bool = False) -> tuple[Any, int]:
    """A value from memory that begins at a place, and the place behind it; ``stays`` if nobody writes there."""
    if isinstance(kind, ir.BaseStructType | ir.ArrayType):
        value = ir.Constant(kind, ir.Undefined)
        for i in range(len(kind)):
            part, place = _load(builder, words, place, kind.elements[i], stays=stays)
            value = builder.insert_value(value, part, i)
        return value, place
    pointer = builder.gep(words, [WORD(place)])
    found = builder.load(builder.bitcast(pointer, kind.as_pointer()))
    if stays:
        found.set_metadata("invariant.load", builder.module.add_metadata([]))
    return found, place + 1


def _store(builder: Any, words: Any, place: int, value: Any) -> int:
    if isinstance(value.type, ir.BaseStructType | ir.ArrayType):
        for i in range(len(value.type)):
            place = _store(builder, words, place, builder.extract_value(value, i))
        return place
    pointer = builder.gep(words, [WORD(place)])
    builder.store(value, builder.bitcast(pointer, value.type.as_pointer()))
    return place + 1


class InMemory(types.Type):
    """A named tuple whose words stand in memory, and stay as they are: of it compiled functions load what they name.

    Taken apart and put together at every call of a function, its fields were half of the engine's LLVM code.
    """

    def __init__(self, kind: Any) -> None:
        self.kind = kind
        super().__init__(f"{kind.name} in memory")


@register_model(InMemory)
class _Model(models.PrimitiveModel):  # type: ignore[misc]
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, WORDS)


@infer_getattr
class _Field(AttributeTemplate):  # type: ignore[misc]
    key = InMemory

    def generic_resolve(self, record: InMemory, name: str) -> Any:
        part = record.kind.types[record.kind.fields.index(name)]
        return InMemory(part) if isinstance(part, types.NamedTuple) else part


@lower_getattr_generic(InMemory)
def _field(context: Any, builder: Any, record: InMemory, words: Any, name: str) -> Any:
    place = record.kind.fields.index(name)
    before = sum(_size(context.get_value_type(part)) for part in record.kind.types[:place])
    part = record.kind.types[place]
    if isinstance(part, types.NamedTuple):
        return builder.gep(words, [WORD(before)])
    return _load(builder, words, before, context.get_value_type(part), stays=True)[0]


def _size(kind: Any) -> int:
    """Words of a value in memory."""
    if isinstance(kind, ir.BaseStructType | ir.ArrayType):
        return sum(_size(kind.elements[i]) for i in range(len(kind)))
    return 1


def at_address(kind: Any) -> Any:
    """A compiled function that gives the record of a type whose words begin at an address."""

    @intrinsic
    def value_at(typingctx: Any, address: Any) -> Any:
        def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            return builder.inttoptr(arguments[0], WORDS)

        return InMemory(kind)(types.int64), code

    return value_at


@intrinsic
def by_value(typingctx: Any, record: Any) -> Any:
    """A record in memory as a named tuple, whose words are all loaded at once."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return _load(builder, arguments[0], 0, context.get_value_type(record.kind))[0]

    return record.kind(record), code


def _entries(name: str, result: Any, kinds: list[Any], call: Callable[..., Any]) -> str:
    """LLVM code of a function by the name that others call it by: with values, and from words in memory."""
    module = ir.Module("entries")
    by_value = ir.Function(module, ir.FunctionType(result, kinds), name)
    builder = ir.IRBuilder(by_value.append_basic_block())
    value = call(module, builder, list(by_value.args))
    nothing = isinstance(result, ir.VoidType)
    builder.ret_void() if nothing else builder.ret(value)
    from_words = ir.Function(module, ir.FunctionType(ir.VoidType(), [WORDS]), name + FROM_WORDS)
    builder = ir.IRBuilder(from_words.append_basic_block())
    given, place = [], 0
    for kind in kinds:
        value, place = _load(builder, from_words.args[0], place, kind)
        given.append(value)
    value = builder.call(by_value, given)
    if not nothing:
        _store(builder, from_words.args[0], place, value)
    builder.ret_void()
    return str(module)


def _known(kind: Any) -> Any:
    """A type whose pointers lead to something, as llvmlite writes them."""
    if isinstance(kind, ir.BaseStructType):
        return ir.LiteralStructType(map(_known, kind.elements))
    if isinstance(kind, ir.ArrayType):
        return ir.ArrayType(_known(kind.element), kind.count)
    return ir.IntType(8).as_pointer() if isinstance(kind, ir.PointerType) and kind.is_opaque else kind


def _kind(function: Any) -> Any:
    """The type of a function that has been compiled."""
    told = function.global_value_type.as_ir(ir.global_context)
    return ir.FunctionType(_known(told.return_type), map(_known, told.args), told.var_arg)


def _lowered_in_public(function: Callable[..., Any], signature: Any) -> tuple[Any, Any, list[Any], Callable[..., Any]]:
    """The same as `inner_parts.lowered`, by a callback for C, which numba optimises with all that it calls."""
    callback = numba.cfunc(signature, **_CALLBACK)(function)
    module = llvm.parse_assembly(callback.inspect_llvm())
    kind = _kind(module.get_function(callback.native_name))

    def call(entries: Any, builder: Any, values: list[Any]) -> Any:
        # a callback tells Python of errors, of which there are none, by functions that numba alone knows by name
        for told in module.functions:
            if told.is_declaration and told.name.startswith("numba_"):
                never = ir.Function(entries, _kind(told), told.name)
                ir.IRBuilder(never.append_basic_block()).unreachable()
        return builder.call(ir.Function(entries, kind, callback.native_name), values)

    return module, kind.return_type, list(kind.args), call


def _lowered(function: Callable[..., Any], signature: Any) -> tuple[Any, Any, list[Any], Callable[..., Any]]:
    if inner_parts is None:
        return _lowered_in_public(function, signature)
    try:
        return inner_parts.lowered(numba.njit(**PLAIN)(function), signature)
    # whatever a numba that has changed them makes of it; a fault of the function itself comes again
    except Exception:
        return _lowered_in_public(function, signature)


def llvm_module(function: Callable[..., Any], name: str, signature: Any, rare: set[str]) -> Any:
    """LLVM code of a function and of all that it calls, as one module that is not yet optimised as a whole.

    Only the two functions of `_entries` can be seen from outside: everything else is compiled for this caller alone,
    whatever was compiled before. Other names are numbers, so that the code is the same in every process. ``rare`` are
    parts of the names of functions that stay calls.
    """
    module, result, kinds, call = _lowered(function, signature)
    result = ir.VoidType() if signature.return_type == types.void else result
    module.link_in(llvm.parse_assembly(_entries(name, result, kinds, call)))
    for number, part in enumerate([*module.functions, *module.global_variables]):
        if part.is_declaration or part.name in (name, name + FROM_WORDS):
            continue
        part.linkage = "internal"
        if part.is_function and any(called in part.name for called in rare):
            part.add_function_attribute("noinline")
            part.add_function_attribute("cold")
        part.name = f"part.{number}"
    return module
