"""numba as a front end: from a function of the engine, and what it calls, to one module of LLVM code.

By numba's inner parts (`inner_parts`) nothing is optimised that becomes a part of something else. Where a numba has
changed them, its public parts do the same: functions are then compiled once a level of calls, which took 1.7 times as
long when both were measured. Results are the same but for rounding where operations may be fused.
"""

import contextlib
import ctypes
import functools
import gc
from collections.abc import Callable, Iterator
from importlib import import_module
from typing import Any

import llvmlite.binding as llvm
import numba
import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.imputils import lower_builtin, lower_cast, lower_getattr_generic
from numba.core.typeconv import Conversion
from numba.core.typing.templates import AttributeTemplate, infer_getattr, infer_global, make_concrete_template
from numba.extending import intrinsic, models, register_jitable, register_model

from chaosdrill.codegen.machine import FROM_WORDS
from chaosdrill.codegen.signatures import event_places
from chaosdrill.engine.layout import State

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
PLAIN: dict[str, Any] = _CALLBACK | {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
"""Options of numba for the engine: no arithmetic errors, no allocation, no calls from Python."""

_parts: list[Any] = []
"""Functions that become parts of compiled ones, each compiled for one target: the inner parts' own, or numba's."""

if inner_parts is not None:
    PLAIN["pipeline_class"] = inner_parts.Compiler


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

    Taken apart and put together at every call of a function, its fields were three quarters of the engine's LLVM code.
    ``key`` is what makes it another type: its name is that of the tuple's class alone.
    """

    model: ir.Type = WORDS
    key: Any = None

    def __init__(self, kind: Any, where: str = "in memory") -> None:
        self.kind = self.key = kind
        super().__init__(f"{kind.name} {where}")

    def __hash__(self) -> int:
        # that of a tuple's type is made of those of all its parts, each time
        return hash(self.name)

    def part(self, name: str) -> Any:
        """The type of a field."""
        part = self.kind.types[self.kind.fields.index(name)]
        return InMemory(part) if isinstance(part, types.NamedTuple) else part


class OneOf(InMemory):
    """The `State` of one run: where the `States` of many are, and its number among them."""

    model = ir.LiteralStructType([WORDS, WORD])

    def __init__(self, states: InMemory) -> None:
        self.states = states
        parts = [part if part.ndim == 1 else part.copy(ndim=part.ndim - 1) for part in states.kind.types]
        # of a run there is an array of its record alone
        kind = types.NamedTuple(tuple(parts), State)
        kind.name = State.__name__
        super().__init__(kind)
        self.key = states


class InFrame(InMemory):
    """A named tuple of whose words a compiled function has a copy in its frame; ``there`` is the type of the original.

    No function that stays a call is given the copy (see `part`), so that its words become values.
    """

    def __init__(self, there: InMemory) -> None:
        self.there = there
        self.model = ir.LiteralStructType([WORDS, there.model])
        super().__init__(there.kind, "in the frame")
        self.key = there

    def part(self, name: str) -> Any:
        part = super().part(name)
        return InFrame(part) if isinstance(part, InMemory) else part

    def can_convert_to(self, typingctx: Any, other: Any) -> Any:
        return Conversion.safe if other == self.there else None


class _Model(models.PrimitiveModel):  # type: ignore[misc]
    def __init__(self, manager: Any, kind: InMemory) -> None:
        super().__init__(manager, kind, kind.model)


class _Field(AttributeTemplate):  # type: ignore[misc]
    def generic_resolve(self, record: InMemory, name: str) -> Any:
        return record.part(name)


for _one in (InMemory, OneOf, InFrame):
    register_model(_one)(_Model)
    infer_getattr(type("_Field", (_Field,), {"key": _one}))


@lower_getattr_generic(InMemory)
def _field(context: Any, builder: Any, record: InMemory, words: Any, name: str, *, stays: bool = True) -> Any:
    place = record.kind.fields.index(name)
    before = sum(_size(context.get_value_type(part)) for part in record.kind.types[:place])
    part = record.kind.types[place]
    if isinstance(part, types.NamedTuple):
        return builder.gep(words, [WORD(before)])
    return _load(builder, words, before, context.get_value_type(part), stays=stays)[0]


@lower_getattr_generic(OneOf)
def _field_of_one(context: Any, builder: Any, record: OneOf, value: Any, name: str) -> Any:
    words, p = (builder.extract_value(value, i) for i in range(2))
    whole = _field(context, builder, record.states, words, name)
    return _row(builder, whole, p, context.get_value_type(record.part(name)))


@lower_getattr_generic(InFrame)
def _field_in_frame(context: Any, builder: Any, record: InFrame, value: Any, name: str) -> Any:
    own, there = (builder.extract_value(value, i) for i in range(2))
    found = _field(context, builder, record, own, name, stays=False)
    if isinstance(record.part(name), InFrame):
        return _struct(builder, found, _field(context, builder, record.there, there, name))
    return found


@lower_cast(InFrame, InMemory)
def _original(context: Any, builder: Any, given: InFrame, kind: InMemory, value: Any) -> Any:
    return builder.extract_value(value, 1)


def _struct(builder: Any, *values: Any) -> Any:
    found = ir.Constant(ir.LiteralStructType([value.type for value in values]), ir.Undefined)
    for i, value in enumerate(values):
        found = builder.insert_value(found, value, i)
    return found


def _row(builder: Any, array: Any, p: Any, kind: Any) -> Any:
    """Row p of an array; of one without rows an array of that entry alone."""
    *head, _, item, data, shape, strides = (builder.extract_value(array, i) for i in range(7))
    first = builder.mul(p, builder.extract_value(strides, 0))
    data = builder.bitcast(builder.gep(builder.bitcast(data, ir.IntType(8).as_pointer()), [first]), data.type)
    whole = len(kind.elements[-1]) == len(strides.type)
    lengths = [WORD(1)] if whole else [builder.extract_value(shape, i) for i in range(1, len(shape.type))]
    steps = [builder.extract_value(strides, i) for i in range(0 if whole else 1, len(strides.type))]
    size = functools.reduce(builder.mul, lengths)
    found = ir.Constant(kind, ir.Undefined)
    for i, value in enumerate((*head, size, item, data)):
        found = builder.insert_value(found, value, i)
    for k, (length, step) in enumerate(zip(lengths, steps, strict=True)):
        found = builder.insert_value(builder.insert_value(found, length, [5, k]), step, [6, k])
    return found


def _copied(context: Any, builder: Any, kind: InFrame, values: list[Any], there: Any) -> Any:
    """A named tuple of values in the frame of the function that is written, with its original."""
    with builder.goto_entry_block():
        words = builder.alloca(WORD, size=_size(context.get_value_type(kind.kind)))
    place = 0
    for value in values:
        place = _store(builder, words, place, value)
    return _struct(builder, words, there)


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
def in_frame(typingctx: Any, record: Any) -> Any:
    """A record in memory with a copy of its words in the frame."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        value, _ = _load(builder, arguments[0], 0, context.get_value_type(record.kind))
        return _copied(context, builder, signature.return_type, [value], arguments[0])

    return InFrame(record)(record), code


@intrinsic
def state_of(typingctx: Any, states: Any, p: Any) -> Any:
    """The `State` of run p of many."""
    one = OneOf(states.there if isinstance(states, InFrame) else states)

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        given, p = arguments
        # what is in the frame already is loaded once
        field = _field_in_frame if isinstance(states, InFrame) else _field
        wholes = (field(context, builder, states, given, name) for name in one.kind.fields)
        kinds = (context.get_value_type(part) for part in one.kind.types)
        rows = [_row(builder, whole, p, kind) for whole, kind in zip(wholes, kinds, strict=True)]
        words = given if states is one.states else _original(context, builder, states, one.states, given)
        there = _struct(builder, words, p)
        return _copied(context, builder, signature.return_type, rows, there)

    return InFrame(one)(states, types.int64), code


def part(function: Callable[..., Any], options: dict[str, Any], *, framed: bool) -> Any:
    """A function that compiled functions call; unless ``framed``, it is given records where they are, and not copies.

    The words of a copy in a frame become values only if no function that stays a call is given the copy.
    """
    # what is not said, numba takes from the function that happens to call this one first
    made = numba.njit(**PLAIN, **{"fastmath": False, "forceinline": False} | options)(function)
    _parts.append(made)
    ask = made.get_call_template

    def template(arguments: Any, named: Any) -> Any:
        return ask(tuple(one.there if isinstance(one, InFrame) else one for one in arguments), named)

    if not framed:
        made.get_call_template = template
    return made


def at_symbol(name: str, signature: Any) -> Any:
    """A function that compiled functions call by the name of its machine code, which is linked when it is loaded."""

    def called() -> None: ...

    infer_global(called, types.Function(make_concrete_template(name, called, [signature])))

    @lower_builtin(called, *signature.args)  # type: ignore[untyped-decorator]
    def code(context: Any, builder: Any, given: Any, arguments: Any) -> Any:
        nothing = signature.return_type == types.void
        result = ir.VoidType() if nothing else context.get_value_type(signature.return_type)
        kind = ir.FunctionType(result, [value.type for value in arguments])
        function = cgutils.get_or_insert_function(builder.module, kind, name)
        function.attributes.add("cold")
        found = builder.call(function, arguments)
        return context.get_dummy_value() if nothing else found

    # to numba's own loader, by which nothing of the engine is run, any address will do
    llvm.add_symbol(name, ctypes.cast(ctypes.pythonapi.PyErr_BadArgument, ctypes.c_void_p).value)
    return called


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
    global inner_parts
    if inner_parts is not None:
        try:
            return inner_parts.lowered(numba.njit(**PLAIN)(function), signature)
        # whatever a numba that has changed them makes of it; a fault of the function itself comes again
        except Exception:
            for one in _parts:
                one.overloads.clear()
    found = _lowered_in_public(function, signature)
    # the parts of it are numba's now, and so are those of what follows
    inner_parts = None
    return found


@contextlib.contextmanager
def _uncollected() -> Iterator[None]:
    """Do not look for garbage: nearly all that is made meanwhile stays, and to look took a third of the time.

    What others ask of the collector meanwhile holds: whether it is enabled is theirs, and so is another threshold.
    """
    first, *others = gc.get_threshold()
    never = int(np.iinfo(np.intc).max)
    gc.set_threshold(never, *others)
    try:
        yield
    finally:
        if gc.get_threshold()[0] == never:
            gc.set_threshold(first, *others)


def llvm_module(function: Callable[..., Any], name: str, signature: Any, rare: set[str]) -> Any:
    """LLVM code of a function and of all that it calls, as one module that is not yet optimised as a whole.

    Only the two functions of `_entries` can be seen from outside: everything else is compiled for this caller alone,
    whatever was compiled before. Other names are numbers, so that the code is the same in every process. ``rare`` are
    parts of the names of functions that stay calls.
    """
    with _uncollected():
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
