"""Functions written as LLVM code: numbers to compute with, rows of numbers in memory, loops and branches.

A number is a double or, in a module of greater width, as many doubles side by side; what is written for one trajectory
serves several. No operation lets one of them see another.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

from llvmlite import ir

DOUBLE = ir.DoubleType()
INT = ir.IntType(64)
_SHORT = ir.IntType(32)
_BYTES = ir.IntType(8).as_pointer()

FAST = ("contract", "nsz", "arcp")
"""Rounding freedom in Taylor recurrences; never in events, resets or saltation, where exact zeros carry the rank."""

RECIPROCALS = 64
"""Length of the table of 1/k: every order of every series divides by its number."""


def array(dimensions: int) -> ir.Type:
    """An array of doubles as compiled functions of the engine hand it on."""
    places = ir.ArrayType(INT, dimensions)
    return ir.LiteralStructType([_BYTES, _BYTES, INT, INT, DOUBLE.as_pointer(), places, places])


def _operator(name: str, *, turned: bool = False) -> Callable[["Number", Any], "Number"]:
    """An operator of numbers; ``turned``: the other operand comes first."""

    def operate(self: "Number", other: Any) -> "Number":
        first, second = (other, self) if turned else (self, other)
        return self.function.operate(name, first, second)

    return operate


class _Value:
    """A value in the code of a function."""

    __slots__ = ("function", "value")

    def __init__(self, function: "Function", value: Any) -> None:
        self.function = function
        self.value = value


class Number(_Value):
    """A floating-point value."""

    __slots__ = ()

    __add__, __radd__ = _operator("fadd"), _operator("fadd", turned=True)
    __sub__, __rsub__ = _operator("fsub"), _operator("fsub", turned=True)
    __mul__, __rmul__ = _operator("fmul"), _operator("fmul", turned=True)
    __truediv__, __rtruediv__ = _operator("fdiv"), _operator("fdiv", turned=True)

    def __neg__(self) -> "Number":
        return Number(self.function, self.function.builder.fneg(self.value))

    def compare(self, symbol: str, other: Any) -> "Test":
        """Whether the relation holds; with NaN only ``!=`` does."""
        builder = self.function.builder
        compared = builder.fcmp_unordered if symbol == "!=" else builder.fcmp_ordered
        return Test(self.function, compared(symbol, self.value, self.function.number(other).value))


def total(terms: Sequence[Number]) -> Number:
    """Their sum, from the left."""
    result = terms[0]
    for term in terms[1:]:
        result = result + term
    return result


class Index(_Value):
    """A whole number, for places in memory."""

    __slots__ = ()

    def __add__(self, other: Any) -> "Index":
        return Index(self.function, self.function.builder.add(self.value, self.function.index(other).value))

    def __sub__(self, other: Any) -> "Index":
        return Index(self.function, self.function.builder.sub(self.value, self.function.index(other).value))

    def __mul__(self, other: Any) -> "Index":
        return Index(self.function, self.function.builder.mul(self.value, self.function.index(other).value))

    def compare(self, symbol: str, other: Any) -> "Test":
        """Whether the relation holds."""
        value = self.function.builder.icmp_signed(symbol, self.value, self.function.index(other).value)
        return Test(self.function, value)

    def number(self) -> Number:
        """The same as a number."""
        return self.function.spread(self.function.builder.sitofp(self.value, DOUBLE))


class Test(_Value):
    """A truth value."""

    __slots__ = ()

    def __and__(self, other: "Test") -> "Test":
        return Test(self.function, self.function.builder.and_(self.value, other.value))

    def __or__(self, other: "Test") -> "Test":
        return Test(self.function, self.function.builder.or_(self.value, other.value))

    def __invert__(self) -> "Test":
        return Test(self.function, self.function.builder.not_(self.value))


class Variable:
    """A number that can be assigned."""

    __slots__ = ("function", "slot")

    def __init__(self, function: "Function", slot: Any) -> None:
        self.function = function
        self.slot = slot

    @property
    def now(self) -> Number:
        """Its current value."""
        return Number(self.function, self.function.builder.load(self.slot))

    def become(self, value: Any) -> Number:
        """Assign a value."""
        number = self.function.number(value)
        self.function.builder.store(number.value, self.slot)
        return number

    def grow(self, value: Number) -> None:
        """Add to it."""
        self.become(self.now + value)


class Row:
    """Numbers that are contiguous in memory."""

    __slots__ = ("data", "function")

    def __init__(self, function: "Function", data: Any) -> None:
        self.function = function
        self.data = data

    def _place(self, index: Any) -> Any:
        function = self.function
        place = function.builder.gep(self.data, [function.places(index)])
        return place if function.width == 1 else function.builder.bitcast(place, function.type.as_pointer())

    def __getitem__(self, index: Any) -> Number:
        value = self.function.builder.load(self._place(index))
        value.align = 8 * self.function.width
        return Number(self.function, value)

    def __setitem__(self, index: Any, value: Any) -> None:
        stored = self.function.builder.store(self.function.number(value).value, self._place(index))
        stored.align = 8 * self.function.width

    def after(self, count: Any) -> "Row":
        """The row without its first entries."""
        function = self.function
        return Row(function, function.builder.gep(self.data, [function.places(count)]))


class Sums:
    """Several sums that grow together: by neighbours in a row times a number.

    Where a number is one double they are one vector. A compiler would find that out by itself, but takes longer for it
    than for all else.
    """

    def __init__(self, function: "Function", count: int) -> None:
        self.function, self.count = function, count
        self._vector = ir.VectorType(DOUBLE, count) if function.width == 1 else None
        kinds = [self._vector] if self._vector else [function.type] * count
        self._parts = [function.variable(Number(function, ir.Constant(kind, None))) for kind in kinds]

    def grow(self, row: Row, place: Index, factor: Number) -> None:
        """Add as many numbers of the row from a place on, times a factor."""
        if self._vector is None:
            for i, part in enumerate(self._parts):
                part.grow(row[place + i] * factor)
            return
        builder = self.function.builder
        loaded = builder.load(builder.bitcast(row.after(place).data, self._vector.as_pointer()))
        loaded.align = 8
        self._parts[0].grow(Number(self.function, loaded) * self.function.repeated(factor.value, self.count))

    def with_those(self, other: "Sums") -> list[Number]:
        """The sums, with as many others added."""
        sums = [a.now + b.now for a, b in zip(self._parts, other._parts, strict=True)]
        if self._vector is None:
            return sums
        extract = self.function.builder.extract_element
        return [Number(self.function, extract(sums[0].value, _SHORT(i))) for i in range(self.count)]


class Table:
    """Rows of equal length."""

    __slots__ = ("data", "function", "length")

    def __init__(self, function: "Function", data: Any, length: Index) -> None:
        self.function = function
        self.data = data
        self.length = length

    def __getitem__(self, index: Any) -> Row:
        return Row(self.function, self.data).after(self.length * index)


def _number(width: int) -> ir.Type:
    return DOUBLE if width == 1 else ir.VectorType(DOUBLE, width)


class Module:
    """A module of functions that are compiled together.

    ``width``: how many doubles a number has. ``parts``: in how many parts these are best computed, see `in_parts`.
    """

    def __init__(self, width: int = 1, parts: int = 1) -> None:
        self.width, self.parts = width, parts
        self.type = _number(width)
        self.module = ir.Module()
        self.written: dict[Any, Any] = {}

    def __str__(self) -> str:
        return str(self.module)

    def declared(self, name: str, types: Sequence[ir.Type], result: ir.Type, *, pure: bool = True) -> Any:
        """Declare an external function; one that is not pure writes through its arguments."""
        found = self.module.globals.get(name)
        if found is None:
            found = ir.Function(self.module, ir.FunctionType(result, types), name)
            found.attributes.add("nounwind")
            if pure:
                found.attributes.add("readnone")
        return found

    def reciprocals(self) -> Any:
        """The table of 1/k; its first number is infinite."""
        kind = ir.ArrayType(DOUBLE, RECIPROCALS)
        values = [float("inf"), *(1.0 / k for k in range(1, RECIPROCALS))]
        return self.module.globals.get("reciprocals") or self._table("reciprocals", ir.Constant(kind, values))

    def whole_numbers(self, name: str, values: Sequence[int]) -> Any:
        """A constant table of whole numbers."""
        # as text: an object a number takes longer than all else that a large table needs
        text = f"[{', '.join(f'{_SHORT} {value}' for value in values or [0])}]"
        return self._table(name, ir.FormattedConstant(ir.ArrayType(_SHORT, max(len(values), 1)), text))

    def _table(self, name: str, content: ir.Constant) -> Any:
        found = ir.GlobalVariable(self.module, content.type, name)
        found.linkage, found.global_constant, found.initializer = "internal", True, content
        return found

    def once(self, name: str, write: Callable[[str], Any]) -> Any:
        """What ``write`` makes under a name, which is written when it is first asked for."""
        if name not in self.written:
            self.written[name] = write(name)
        return self.written[name]

    def in_parts(self, name: str, arguments: Mapping[str, ir.Type], write: Callable[["Function"], None]) -> Any:
        """A function of numbers, rows and whole numbers that does some doubles of every number after the others.

        A number that fills more than one register leaves no registers for other numbers, and all of them go to memory
        and back.
        """
        width = self.width // self.parts
        of_part = {a: _number(width) if kind == self.type else kind for a, kind in arguments.items()}
        part_name = name if self.parts == 1 else f"{name}_part"
        part = Function(self, part_name, of_part, fast=True, own=True, apart=True, width=width)
        if width > 1:
            # a number put aside that lies across two lines of the cache is slow, and the compiler lets it lie there
            part.made.attributes.alignstack = 8 * width
        write(part)
        part.end()
        if self.parts == 1:
            return part.made
        f = Function(self, name, arguments, own=True, apart=True)
        for first in range(0, self.width, width):
            f.builder.call(part.made, [f.doubles_from(first, width, a) for a in f.arguments])
        f.end()
        return f.made


class Function:
    """One function that is being written.

    ``arguments``: types of its arguments by their names. ``fast``: whether its operations have the rounding freedom of
    `FAST`. ``own``: whether only its module sees it. ``stays``: whether it stays a call in whatever calls it.
    ``apart``: whether no two of its pointers lead to the same memory, of which one is written through. ``width``: how
    many doubles its numbers have, if fewer than those in memory.
    """

    def __init__(
        self,
        module: Module,
        name: str,
        arguments: Mapping[str, ir.Type],
        result: ir.Type | None = None,
        *,
        fast: bool = False,
        own: bool = False,
        stays: bool = False,
        apart: bool = False,
        width: int | None = None,
    ) -> None:
        self.module = module
        self.width = width or module.width
        self.type = _number(self.width)
        self.flags = FAST if fast else ()
        kind = ir.FunctionType(ir.VoidType() if result is None else result, list(arguments.values()))
        self.made = ir.Function(module.module, kind, name)
        for argument, named in zip(self.made.args, arguments, strict=True):
            argument.name = named
        self.made.attributes.add("nounwind")
        if stays:
            self.made.attributes.add("noinline")
        if own:
            self.made.linkage = "internal"
        for argument in self.made.args if apart else ():
            if isinstance(argument.type, ir.PointerType):
                argument.add_attribute("noalias")
        self.entry = self.made.append_basic_block("entry")
        self.builder = ir.IRBuilder(self.made.append_basic_block("body"))
        self._slots = ir.IRBuilder(self.entry)
        self._start = self.builder.block

    @property
    def arguments(self) -> tuple[Any, ...]:
        """The arguments in LLVM code."""
        return tuple(self.made.args)

    def number(self, value: Any) -> Number:
        """A number from a number of Python, or from itself."""
        if isinstance(value, Number):
            return value
        constant = float(value)
        return Number(self, ir.Constant(self.type, constant if self.width == 1 else [constant] * self.width))

    def index(self, value: Any) -> Index:
        """A whole number from one of Python, or from itself."""
        return value if isinstance(value, Index) else Index(self, ir.Constant(INT, int(value)))

    def places(self, count: Any) -> Any:
        """How far this many numbers reach in memory, in doubles."""
        width = self.module.width
        if not isinstance(count, Index):
            return ir.Constant(INT, int(count) * width)
        return count.value if width == 1 else (count * width).value

    def doubles_from(self, first: int, count: int, argument: Any) -> Any:
        """An argument for a function whose numbers are ``count`` doubles of those here."""
        if argument.type == INT:
            return argument
        if argument.type != self.type:
            return self.builder.gep(argument, [ir.Constant(INT, first)])
        places = ir.Constant(ir.VectorType(_SHORT, count), list(range(first, first + count)))
        return self.builder.shuffle_vector(argument, argument, places)

    def whole_part(self, count: Index, size: int) -> Index:
        """The largest multiple of a power of two that is not above."""
        return Index(self, self.builder.and_(count.value, ir.Constant(INT, -size)))

    def half(self, count: Index) -> Index:
        """Half of a non-negative integer, rounded down."""
        return Index(self, self.builder.lshr(count.value, ir.Constant(INT, 1)))

    def spread(self, value: Any) -> Number:
        """A double of the code as a number: as often as a number has doubles."""
        return Number(self, value) if self.width == 1 else self.repeated(value, self.width)

    def repeated(self, value: Any, count: int) -> Number:
        """A vector that holds a double of the code so often."""
        one = self.builder.insert_element(ir.Constant(ir.VectorType(DOUBLE, count), ir.Undefined), value, _SHORT(0))
        places = ir.Constant(ir.VectorType(_SHORT, count), [0] * count)
        return Number(self, self.builder.shuffle_vector(one, one, places))

    def operate(self, name: str, first: Any, second: Any) -> Number:
        """A sum, difference, product or quotient."""
        a, b = self.number(first).value, self.number(second).value
        return Number(self, getattr(self.builder, name)(a, b, flags=self.flags))

    def intrinsic(self, name: str, *arguments: Any) -> Number:
        """A compiler intrinsic, applied to all doubles of a number at once."""
        values = [self.number(a).value for a in arguments]
        kind = "f64" if self.width == 1 else f"v{self.width}f64"
        called = self.module.declared(f"llvm.{name}.{kind}", [self.type] * len(values), self.type)
        return Number(self, self.builder.call(called, values))

    def external(self, name: str, *arguments: Any) -> Number:
        """A function of doubles that is resolved by name when the code is loaded."""
        numbers = [self.number(a) for a in arguments]
        called = self.module.declared(name, [DOUBLE] * len(numbers), DOUBLE)
        return self.one_by_one(lambda *values: self.builder.call(called, values), *numbers)

    def single(self, number: Number, place: int) -> Any:
        """One of a number's doubles."""
        return number.value if self.width == 1 else self.builder.extract_element(number.value, _SHORT(place))

    def one_by_one(self, call: Callable[..., Any], *numbers: Number) -> Number:
        """What a function of doubles gives for every double of numbers."""
        if self.width == 1:
            return Number(self, call(*(n.value for n in numbers)))
        result = ir.Constant(self.type, ir.Undefined)
        for i in range(self.width):
            one = call(*(self.single(n, i) for n in numbers))
            result = self.builder.insert_element(result, one, _SHORT(i))
        return Number(self, result)

    def truth(self, value: bool) -> Test:
        """A constant test."""
        return Test(self, ir.Constant(ir.IntType(1), int(value)))

    def choose(self, test: Test, first: Any, second: Any) -> Number:
        """The first number if the test holds, otherwise the second."""
        return Number(self, self.builder.select(test.value, self.number(first).value, self.number(second).value))

    def any_beyond(self, x: Number, limit: float) -> Test:
        """Whether one of the doubles is larger than ``limit`` or below its negative, or no number."""
        outside = ~self.intrinsic("fabs", x).compare("<=", limit)
        if self.width == 1:
            return outside
        mask = self.builder.bitcast(outside.value, ir.IntType(self.width))
        return Test(self, self.builder.icmp_unsigned("!=", mask, ir.Constant(ir.IntType(self.width), 0)))

    def power_of_two(self, exponent: Number) -> Number:
        """2**n for whole numbers n of a size below 1022."""
        whole = INT if self.width == 1 else ir.VectorType(INT, self.width)

        def constant(value: int) -> Any:
            return ir.Constant(whole, value if self.width == 1 else [value] * self.width)

        biased = self.builder.add(self.builder.fptosi(exponent.value, whole), constant(1023))
        return Number(self, self.builder.bitcast(self.builder.shl(biased, constant(52)), self.type))

    def unit_of(self, x: Number) -> Number:
        """The power of two by which a double x >= 0 becomes one of about 1; 1 if x is 0, or nearly so."""
        bits = self.builder.and_(self.builder.bitcast(x.value, INT), INT(0x7FF0000000000000))
        power = Number(self, self.builder.bitcast(bits, DOUBLE))
        return self.choose(power.compare(">", 0.0), 1.0 / power, 1.0)

    def reciprocal(self, k: Index) -> Number:
        """1/k from the table."""
        place = self.builder.gep(self.module.reciprocals(), [ir.Constant(INT, 0), k.value])
        return self.spread(self.builder.load(place))

    def entry_of(self, table: Any, place: Index) -> Index:
        """A number of a constant table of whole numbers."""
        found = self.builder.load(self.builder.gep(table, [ir.Constant(INT, 0), place.value]))
        return Index(self, self.builder.sext(found, INT))

    def either(self, test: Test, first: Any, second: Any) -> Index:
        """The first integer if the test holds, otherwise the second."""
        return Index(self, self.builder.select(test.value, self.index(first).value, self.index(second).value))

    def scratch(self, count: int) -> Row:
        """A row of the function's own."""
        made = self._slots.alloca(DOUBLE, max(count, 1) * self.module.width)
        made.align = 8 * self.width
        return Row(self, made)

    def variable(self, value: Any = 0.0) -> Variable:
        """A new variable with this value."""
        number = self.number(value)
        made = Variable(self, self._slots.alloca(number.value.type))
        made.become(number)
        return made

    def row(self, argument: Any) -> Row:
        """The row that a pointer or an array leads to."""
        pointer = isinstance(argument.type, ir.PointerType)
        return Row(self, argument if pointer else self.builder.extract_value(argument, 4))

    def table(self, argument: Any, length: Any = None) -> Table:
        """The rows that an array, or a pointer and the length of a row, lead to."""
        if length is not None:
            return Table(self, argument, Index(self, length))
        return Table(self, self.builder.extract_value(argument, 4), self.row_length(argument))

    def row_length(self, argument: Any) -> Index:
        """How many numbers a row of an array of rows has."""
        return Index(self, self.builder.extract_value(argument, [5, 1]))

    @contextmanager
    def at_entry(self) -> Iterator[None]:
        """Write at the beginning of the function, so that what is made holds everywhere in it."""
        builder, self.builder = self.builder, self._slots
        yield
        self.builder = builder

    @contextmanager
    def loop(self, start: Any, stop: Any, step: int = 1) -> Iterator[Index]:
        """Write what is done for every whole number from ``start`` to below ``stop``."""
        slot = self._slots.alloca(INT)
        self.builder.store(self.index(start).value, slot)
        head, body, after = (self.made.append_basic_block(name) for name in ("head", "loop", "done"))
        self.builder.branch(head)
        self.builder.position_at_end(head)
        at = Index(self, self.builder.load(slot))
        self.builder.cbranch(at.compare("<", stop).value, body, after)
        self.builder.position_at_end(body)
        yield at
        self.builder.store((at + step).value, slot)
        self.builder.branch(head)
        self.builder.position_at_end(after)

    @contextmanager
    def when(self, test: Test) -> Iterator[None]:
        """Write what is done where the test holds."""
        body, after = (self.made.append_basic_block(name) for name in ("then", "after"))
        self.builder.cbranch(test.value, body, after)
        self.builder.position_at_end(body)
        yield
        if not self.builder.block.is_terminated:
            self.builder.branch(after)
        self.builder.position_at_end(after)

    def switch(self, number: Index, cases: Mapping[int, Callable[[], None]]) -> None:
        """Write what is done for each of these numbers."""
        after = self.made.append_basic_block("after")
        switch = self.builder.switch(number.value, after)
        for value, write in cases.items():
            block = self.made.append_basic_block("case")
            switch.add_case(ir.Constant(INT, value), block)
            self.builder.position_at_end(block)
            write()
            if not self.builder.block.is_terminated:
                self.builder.branch(after)
        self.builder.position_at_end(after)

    def give(self, result: Any = None) -> None:
        """Return a result."""
        if result is None:
            self.builder.ret_void()
        else:
            self.builder.ret(result.value)

    def end(self) -> None:
        """Nothing more is written."""
        if not self.builder.block.is_terminated:
            self.builder.ret_void()
        self._slots.branch(self._start)
