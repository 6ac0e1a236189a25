"""What the engine takes of numba's inner parts: a new numba that has changed one of them is named here."""

import contextlib
import gc
import inspect
import math
import operator
import re
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import llvmlite.binding as llvm
import numba
import numpy as np
import pytest
from numba import types
from numba.core import codegen, compiler, cpu, registry
from numba.np import arrayobj

from chaosdrill.codegen.kinds import NamedTuple, Pointer, Tuple, float64, int64
from chaosdrill.codegen.machine import optimised_object
from chaosdrill.codegen.signatures import LaneFunctions, integers, matrix, vector
from chaosdrill.engine import front_end, inner_parts, records
from chaosdrill.engine.jit import (
    Layout,
    Record,
    at_address,
    compiled,
    in_frame,
    inlined,
    inner,
    put_real,
    rare,
    series,
    unit,
)

# What the engine takes of numba's inner parts: a new numba that has changed one of them is named here.


def test_the_contexts_of_the_target_are_replaced_and_put_back():
    target = registry.cpu_target
    call_type = types.Function.get_call_type
    before = target.typing_context, target.target_context, arrayobj.fix_integer_index
    with inner_parts._own_contexts() as context:
        assert target.target_context is context
        assert target.typing_context is context.typing_context
        assert context not in before
        assert arrayobj.fix_integer_index is inner_parts._index
        assert types.Function.get_call_type is inner_parts._call_type
    assert (target.typing_context, target.target_context, arrayobj.fix_integer_index) == before
    assert types.Function.get_call_type is call_type


def test_what_an_operator_makes_of_types_is_asked_of_numba_once(monkeypatch):
    asked = []
    ask = inner_parts._type_of_call
    monkeypatch.setattr(inner_parts, "_type_of_call", lambda *given: asked.append(given[0].typing_key) or ask(*given))
    monkeypatch.setattr(inner_parts, "_types_of_calls", {})

    def many(x):
        return x * x + x * x * x + x * x * x * x

    put_real()
    front_end.llvm_module(many, "many", float64(float64).real, set())
    assert asked.count(operator.mul) == 1


def test_declarations_and_sizes_of_types_are_asked_for_once(monkeypatch):
    asked = []

    def counted(ask):
        def of_engine(context, *given):
            if isinstance(context, inner_parts._Context):
                asked.append((ask.__name__, *map(str, given)))
            return ask(context, *given)

        return of_engine

    for name in ("load_additional_registries", "get_abi_sizeof"):
        monkeypatch.setattr(cpu.CPUContext, name, counted(getattr(cpu.CPUContext, name)))

    def both(values, counts):
        return values[0] + values[1] + counts[0] + counts[1]

    put_real()
    front_end.llvm_module(both, "both", float64(vector, integers).real, set())
    assert len(asked) == len(set(asked))


def test_passes_that_are_left_out_are_there():
    state = SimpleNamespace(flags=compiler.Flags(), func_ir=None)
    passes = compiler.DefaultPassBuilder.define_nopython_pipeline(state).passes
    assert {one.__name__ for one, _ in passes} >= inner_parts._IDLE


@pytest.mark.parametrize(
    ("owner", "overridden"),
    [
        (codegen.JITCodeLibrary, inner_parts._Library),
        (codegen.JITCPUCodegen, inner_parts._Codegen),
        (cpu.CPUContext, inner_parts._Context),
    ],
)
def test_what_is_overridden_is_there(owner, overridden):
    for name, own in vars(overridden).items():
        if inspect.isfunction(own):
            assert callable(getattr(owner, name, None)), f"numba {numba.__version__} has no {owner.__name__}.{name}"


@inner
def half(x):
    return 0.5 * x


@rare
def seldom(x):
    return x**0.3


def total(values, number, table):
    result = float(number)
    for i in range(values.size):
        result += half(values[i]) if values[i] < 2.0 else seldom(values[i])
    table[0, 0] = result
    return result, number + values.size


SIGNATURE = Tuple((float64, int64))(vector, int64, matrix)


def test_one_module_holds_all_that_is_called_and_shows_two_functions():
    put_real()
    module = front_end.llvm_module(total, "total", SIGNATURE.real, set())
    module.verify()
    defined = [f for f in module.functions if not f.is_declaration]
    shown = {f.name for f in defined if f.linkage is not llvm.Linkage.internal}
    assert shown == {"total", "total" + front_end.FROM_WORDS}
    assert len(defined) >= 5
    declared = {f.name for f in module.functions if f.is_declaration}
    assert all(name.startswith("llvm.") or llvm.address_of_symbol(name) for name in declared)


def test_no_code_names_an_address_of_the_process():
    """What is kept is loaded by other processes."""
    script = "import sys; sys.path.insert(0, sys.argv[1]); import hashlib, test_front_end as t; "
    script += "print(hashlib.sha256(t.compiled(t.SIGNATURE)(t.total).code).hexdigest())"
    told = {
        subprocess.run(
            [sys.executable, "-c", script, str(Path(__file__).parent)], capture_output=True, text=True, check=True
        ).stdout
        for _ in range(2)
    }
    assert len(told) == 1


def test_a_call_fills_arrays_and_returns_numbers():
    values, table = np.array([1.0, 3.0]), np.zeros((1, 2))
    expected = 7.5 + 3.0**0.3
    assert compiled(SIGNATURE)(total)(values, 7, table) == (pytest.approx(expected, rel=1e-15), 9)
    assert table[0, 0] == pytest.approx(expected, rel=1e-15)


def test_an_index_is_not_asked_whether_it_counts_from_the_end():
    def shifted(values, number, table):
        return values[number], number

    put_real()
    module = front_end.llvm_module(shifted, "shifted", SIGNATURE.real, set())
    assert "icmp slt" not in str(module)


@pytest.mark.parametrize("wrong", [np.zeros(3, dtype=np.float32), np.zeros((3, 1)), np.zeros(6)[::2]])
def test_an_array_of_another_kind_is_refused(wrong):
    with pytest.raises(TypeError, match="expected an array of 1 dimensions of float64"):
        compiled(SIGNATURE)(total)(wrong, 0, np.zeros((1, 1)))


@inner
def as_it_is(record):
    return record


@rare
def filled(record, value):
    record.jacobian_jet[0] = value
    return record.jacobian_jet.size


ONE = Pointer("one", float64(float64))
RECORD = NamedTuple((ONE, vector, float64), LaneFunctions)


def doubled(x):
    return 2.0 * x


def applied(given):
    """A function that takes a record at an address by way of ``given``, and leaves it to another one."""
    at = at_address(RECORD)

    def apply(place):
        record = given(at(place))
        return filled(record, record.jet(record.tangent))

    return apply


@pytest.mark.parametrize("given", [as_it_is, in_frame], ids=["in memory", "in the frame"])
def test_a_record_is_read_with_its_functions(given):
    values = np.zeros(4)
    record = Record(Layout(RECORD), LaneFunctions(compiled(float64(float64))(doubled), values, 1.25))
    assert compiled(int64(int64))(applied(given))(record) == 4
    assert values[0] == 2.5


def test_records_of_one_class_with_other_fields_are_of_two_types():
    kinds = [NamedTuple(parts, LaneFunctions) for parts in ((ONE, float64, vector), (ONE, vector, float64))]
    first_at, second_at = map(at_address, kinds)

    def both(one, other):
        return first_at(one).jacobian_jet + in_frame(second_at(other)).tangent

    values = np.array([1.0, 2.0])
    function = compiled(float64(float64))(doubled)
    given = [LaneFunctions(function, 0.25, values), LaneFunctions(function, values, 4.0)]
    assert compiled(float64(int64, int64))(both)(*map(Record, map(Layout, kinds), given)) == 4.25


def test_words_in_the_frame_become_values():
    """An address that another function had would keep them in memory, where runs would load them all the time."""
    apply = compiled(int64(int64))(applied(in_frame)).py_func
    put_real()
    module = front_end.llvm_module(apply, "apply", int64(int64).real, set())
    words = re.compile(r"alloca i64, i\d+ 9\b")
    assert words.search(str(module))
    optimised_object(module, loops=False)
    assert not words.search(str(module))


def cube(x):
    return x * x * x


def test_a_unit_is_linked_by_its_name_and_a_part_of_no_caller():
    cubed = unit(cube, float64(float64))
    linked = cubed.symbol.encode()

    def apply(x):
        return 2.0 * cubed(x)

    made = compiled(float64(float64))(apply)
    assert made(3.0) == 54.0
    assert linked in made.code
    module = front_end.llvm_module(apply, "apply", float64(float64).real, set())
    assert [f.name.encode() for f in module.functions if f.is_declaration and "unit" in f.name] == [linked]


THREADS = """
import sys, threading, time
sys.path.insert(0, sys.argv[1])
import test_front_end as t
from chaosdrill.progress import COMPILATION

number = t.float64(t.float64)
cubed = t.unit(t.cube, number)

def apply(x):
    return 2.0 * cubed(x)

one, other = t.compiled(number)(apply), t.compiled(number)(t.doubled)
thread = threading.Thread(target=lambda: print(one(3.0)), daemon=True)
thread.start()
while not COMPILATION.under_way:
    time.sleep(0.001)
assert other.address
thread.join()
"""


def test_two_threads_do_not_wait_for_each_other():
    command = [sys.executable, "-c", THREADS, str(Path(__file__).parent)]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=60)
    assert done.stdout == "54.0\n"


def test_a_unit_has_arguments_of_known_kinds():
    def push(speed):
        return speed

    with pytest.raises(TypeError, match=r"test_front_end\.push has an argument of no known kind: speed"):
        records.unit(float64)(push)


def test_others_decide_about_the_collector_while_it_waits():
    before, collections = gc.get_threshold(), [one["collections"] for one in gc.get_stats()]
    try:
        with contextlib.suppress(OSError), front_end._uncollected():
            kept = [[] for _ in range(10 * before[0])]
            assert [one["collections"] for one in gc.get_stats()] == collections
            gc.disable()
            raise OSError(len(kept))
        assert not gc.isenabled()
        assert gc.get_threshold() == before
        with front_end._uncollected():
            gc.set_threshold(5 * before[0])
        assert gc.get_threshold()[0] == 5 * before[0]
    finally:
        gc.enable()
        gc.set_threshold(*before)


def test_numba_compiles_other_code_after_the_engine():
    script = "import sys; sys.path.insert(0, sys.argv[1]); import test_front_end as t; "
    script += "t.compiled(t.SIGNATURE)(t.total).compile(); import numba; "
    script += "print(numba.cfunc('float64(float64)', _nrt=False)(lambda x: 2.0 * x).ctypes(1.5))"
    command = [sys.executable, "-c", script, str(Path(__file__).parent)]
    assert subprocess.run(command, capture_output=True, text=True, check=True).stdout == "3.0\n"


def test_python_is_refused_a_part_of_the_engine():
    compiled(SIGNATURE)(total).compile()
    with pytest.raises(TypeError):
        half(1.0)


# A function is the same machine code whatever was compiled before it; else a rerun may differ in the last bit.


MATRIX = float64[:, ::1]


def caller_of(helper):
    def total(matrix):
        result = 0.0
        for row in range(matrix.shape[0]):
            result += helper(matrix[row]) * helper(matrix[row - 1]) + helper(matrix[row // 2])
        return result + helper(matrix[0]) / helper(matrix[1])

    return total


def weigh(values):
    result = 0.0
    for k in range(values.size // 4):
        a, b, c, d = values[4 * k], values[4 * k + 1], values[4 * k + 2], values[4 * k + 3]
        values[4 * k], values[4 * k + 1], values[4 * k + 2], values[4 * k + 3] = a * a, b * b, c * c, d * d
        result += a + b + c + d
        for other in range(k):
            result += math.sin(values[other] * a) - math.cos(values[other] * b) + math.exp(c) * math.atan2(d, a)
            values[other] = math.tanh(result) - math.log1p(a * a) + math.hypot(b, c)
        if result > 1e3:
            result = weigh_again(result, a)
    return result


@inner
def weigh_again(total, value):
    return total / (1.0 + value * value)


def other_caller_of(helper):
    def total(matrix):
        return helper(matrix[0]) - helper(matrix[1])

    return total


def test_the_same_helper_after_another_caller():
    first = compiled(float64(MATRIX))(caller_of(inner(weigh)))
    assert len(first.code) > 1000
    shared = inner(weigh)
    assert compiled(float64(MATRIX))(other_caller_of(shared)).code != first.code
    assert compiled(float64(MATRIX))(caller_of(shared)).code == first.code


def product(a, b, c):
    return a * b + c


@pytest.mark.parametrize("decorated", [inner, rare, inlined], ids=["inner", "rare", "inlined"])
def test_a_strict_helper_is_not_fused_because_a_series_calls_it_first(decorated):
    """Of options that a function does not give numba takes those of its first caller."""
    strict = decorated(product)

    @series
    def first(a, b, c):
        return strict(a, b, c)

    @compiled(Tuple((float64, float64))(float64, float64, float64))
    def both(a, b, c):
        one = first(a, b, c)
        return one, strict(a, b, c)

    # the exact result is -2**-60; the product alone is rounded to 1
    assert both(1.0 + 2.0**-30, 1.0 - 2.0**-30, -1.0) == (0.0, 0.0)
