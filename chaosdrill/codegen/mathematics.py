"""Functions of numbers as LLVM code.

One double takes those of the standard library. Several side by side have a sine, cosine and exponential of their own:
reduction and polynomials of sine and cosine are those of Sun's fdlibm, within one unit in the last place of the result,
or of 1 where it is near zero; arguments out of range go to the standard library.
"""

from collections.abc import Callable
from typing import Any

from llvmlite import ir

from chaosdrill.codegen.addresses import EXPANDED, PREFIX
from chaosdrill.codegen.emitter import DOUBLE, INT, Function, Index, Module, Number, Row
from chaosdrill.codegen.tuning import TUNING


def _sine(r: Number) -> Number:
    z = r * r
    low = -1.66666666666666324348e-01 + z * (8.33333333332248946124e-03 + z * -1.98412698298579493134e-04)
    high = 2.75573137070700676789e-06 + z * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10)
    return r + (r * z) * (low + (z * z * z) * high)


def _cosine(r: Number) -> Number:
    z = r * r
    low = 4.16666666666666019037e-02 + z * (-1.38888888888741095749e-03 + z * 2.48015872894767294178e-05)
    high = -2.75573143513906633035e-07 + z * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11)
    return (1.0 - 0.5 * z) + (z * z) * (low + (z * z * z) * high)


def _turned(x: Number, quarters: float) -> Number:
    """Sine of x + quarters * pi / 2."""
    f = x.function
    n = f.intrinsic("rint", x * 0.6366197723675814)
    r = (x - n * 1.57079632673412561417e00) - n * 6.07710050650619224932e-11
    n = n + quarters
    odd = n - 2.0 * f.intrinsic("floor", 0.5 * n)
    beyond = n - 4.0 * f.intrinsic("floor", 0.25 * n) - odd
    return f.choose(odd.compare("!=", 0.0), _cosine(r), _sine(r)) * (1.0 - beyond)


def _power_of_e(x: Number) -> Number:
    f = x.function
    n = f.intrinsic("rint", x * 1.4426950408889634)
    r = (x - n * 6.93147180369123816490e-01) - n * 1.90821492927058770002e-10
    value = f.number(1.0 / 6227020800.0)
    for c in (479001600.0, 39916800.0, 3628800.0, 362880.0, 40320.0, 5040.0, 720.0, 120.0, 24.0, 6.0, 2.0, 1.0, 1.0):
        value = value * r + 1.0 / c
    return value * f.power_of_two(n)


_SIDE_BY_SIDE: dict[str, tuple[Callable[[Number], Number], float]] = {
    "sin": (lambda x: _turned(x, 0.0), TUNING.largest_angle),
    "cos": (lambda x: _turned(x, 1.0), TUNING.largest_angle),
    "exp": (_power_of_e, TUNING.largest_exponent),
}


def _known_to_compiler(name: str) -> Callable[[Number], Number]:
    def single(x: Number) -> Number:
        f = x.function
        called = f.module.declared(f"llvm.{name}.f64", [DOUBLE], DOUBLE)
        return f.one_by_one(lambda value: f.builder.call(called, [value]), x)

    def number(x: Number) -> Number:
        f = x.function
        if f.width == 1 or name not in _SIDE_BY_SIDE:
            return single(x)
        # a name of its own: that of the library is what a double out of range is given to
        made = f.module.once(f"{name}_of_{f.width}", lambda own: _written(f, own, *_SIDE_BY_SIDE[name], single))
        return Number(f, f.builder.call(made, [x.value]))

    return number


def _written(
    caller: Function, name: str, inside: Callable[[Number], Number], limit: float, single: Callable[[Number], Number]
) -> Any:
    """A function of several doubles side by side, one by one where an argument is out of range."""
    f = Function(caller.module, name, {"x": caller.type}, caller.type, fast=True, own=True, width=caller.width)
    x = Number(f, f.arguments[0])
    with f.when(f.any_beyond(x, limit)):
        beyond = ~f.intrinsic("fabs", x).compare("<=", limit)
        f.give(f.choose(beyond, single(x), inside(f.choose(beyond, 0.0, x))))
    f.give(inside(x))
    f.end()
    return f.made


def _from_library(name: str) -> Callable[[Number], Number]:
    return lambda x: x.function.external(name, x)


START: dict[str, Callable[[Number], Number]] = {
    **{name: _known_to_compiler(name) for name in ("sin", "cos", "exp", "log")},
    **{
        name: _from_library(name)
        for name in ("tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "asinh", "acosh", "atanh")
    },
    "sech": lambda x: 1.0 / x.function.external("cosh", x),
    "logistic": lambda x: 1.0 / (1.0 + _known_to_compiler("exp")(x)),
}
"""The functions by name."""

LIBRARY = {"atan2": "atan2", "erf": "erf", "erfc": "erfc", "gamma": "tgamma", "loggamma": "lgamma"}
"""Other functions that resets and conditions may hold, and what the standard library calls them."""


def root(x: Number) -> Number:
    """Square root."""
    return x.function.intrinsic("sqrt", x)


def power(base: Number, exponent: Number) -> Number:
    """``base`` to the power ``exponent``."""
    f = base.function
    called = f.module.declared("llvm.pow.f64", [DOUBLE, DOUBLE], DOUBLE)
    return f.one_by_one(lambda a, b: f.builder.call(called, [a, b]), base, exponent)


def remainder(x: Number, m: Number) -> Number:
    """x modulo m, with the sign of m."""
    f = x.function
    rest = f.operate("frem", x, m)
    other_side = rest.compare("!=", 0.0) & f.choose(rest.compare("<", 0.0), 1.0, 0.0).compare(
        "!=", f.choose(m.compare("<", 0.0), 1.0, 0.0)
    )
    return f.choose(other_side, rest + m, f.choose(rest.compare("==", 0.0), f.intrinsic("copysign", 0.0, m), rest))


def _splitmix(f: Function, seed: Any, index: Any) -> Any:
    """Output ``index`` of SplitMix64 as a double between 0 and 1."""
    b = f.builder
    first, place = (b.fptosi(value, INT) for value in (seed, index))
    bits = b.add(first, b.mul(b.add(place, INT(1)), INT(0x9E3779B97F4A7C15)))
    for shift, factor in ((30, 0xBF58476D1CE4E5B9), (27, 0x94D049BB133111EB)):
        bits = b.mul(b.xor(bits, b.lshr(bits, INT(shift))), INT(factor))
    bits = b.xor(bits, b.lshr(bits, INT(31)))
    whole = b.uitofp(b.lshr(bits, INT(12)), DOUBLE)
    return b.fmul(b.fadd(whole, DOUBLE(0.5)), DOUBLE(2.0**-52))


def special(f: Function, name: str, arguments: list[Number]) -> Number:
    """One of the functions of `chaosdrill.model.special`."""
    if name == "positive_power":
        d, n = arguments
        return f.choose(d.compare(">", 0.0), power(d, n), 0.0)
    if name == "random_uniform":
        return f.one_by_one(lambda seed, index: _splitmix(f, seed, index), *arguments)
    return f.external(PREFIX + name, *arguments)


def expand(f: Function, name: str, arguments: list[Number], derivative: int, count: Index, target: Row) -> None:
    """Write Taylor coefficients of a derivative of a special function by its first argument v, at v (1 + w), by w."""
    pointer = DOUBLE.as_pointer()
    types = [*[DOUBLE] * len(arguments), INT, INT, pointer, INT]
    called = f.module.declared(f"{PREFIX}{name}{EXPANDED}", types, ir.VoidType(), pure=False)
    for i in range(f.width):
        place = f.builder.gep(target.data, [INT(i)])
        one = [f.single(a, i) for a in arguments]
        f.builder.call(called, [*one, INT(derivative), count.value, place, INT(f.module.width)])


def imports(module: Module) -> list[str]:
    """Names of the special functions that a module calls."""
    declared = (function.name for function in module.module.functions if function.is_declaration)
    return [name for name in declared if name.startswith(PREFIX)]
