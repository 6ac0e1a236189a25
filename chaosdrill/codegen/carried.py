"""Numbers that carry something through a Python function: a derivative, or a bound of their rounding error.

Compiled with them in place of doubles, a function computes its derivative along a direction, exact but for rounding
(dual numbers: Griewank and Walther, Evaluating Derivatives, 2nd ed. 2008, ch. 3, doi:10.1137/1.9780898717761), of a
second order where they are nested, or how far rounding may take its value (running error analysis: Higham 2002, section
3.3, doi:10.1137/1.9780898718027, see `chaosdrill.codegen.rounding`). Branches are those of the value.
"""

import builtins
import math
import operator
from collections.abc import Callable
from functools import cache, partial, wraps
from typing import Any

import numpy as np
from numba import carray, njit, types
from numba.core import cgutils
from numba.core.typeconv import Conversion
from numba.extending import intrinsic, lower_cast, make_attribute_wrapper, models, register_model
from numba.extending import overload as numba_overload

# compiled functions alone call these: without wrappers for other callers they compile in half of the time
INNER = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}

overload = partial(numba_overload, strict=False, jit_options=INNER)


class Carrier(types.Type):
    """Type of a number with what it carries, both of the ``inner`` type.

    ``kind``: "dual" for a derivative, "bounded" for a bound of the rounding error in rounding units. ``inner``:
    doubles, or numbers that carry something themselves.
    """

    def __init__(self, kind: str, inner: Any) -> None:
        self.kind, self.inner = kind, inner
        super().__init__(f"{kind}({inner})")

    def can_convert_from(self, typingctx: Any, other: Any) -> Any:
        """Plain numbers carry nothing."""
        return Conversion.safe if isinstance(other, types.Number | types.Boolean) else None

    def unify(self, typingctx: Any, other: Any) -> Any:
        """Where a branch gives a plain number."""
        return self if isinstance(other, types.Number | types.Boolean) else None


@register_model(Carrier)
class _Model(models.StructModel):
    def __init__(self, manager: Any, kind: Carrier) -> None:
        super().__init__(manager, kind, [("value", kind.inner), ("part", kind.inner)])


make_attribute_wrapper(Carrier, "value", "value")
make_attribute_wrapper(Carrier, "part", "part")

BOUNDED = Carrier("bounded", types.float64)
DUAL = Carrier("dual", types.float64)
SECOND = Carrier("dual", DUAL)
DUAL_BOUNDED = Carrier("dual", BOUNDED)


@lower_cast(types.Number, Carrier)
@lower_cast(types.Boolean, Carrier)
def _from_plain(context: Any, builder: Any, given: Any, wanted: Any, value: Any) -> Any:
    made = cgutils.create_struct_proxy(wanted)(context, builder)
    made.value = context.cast(builder, value, given, wanted.inner)
    made.part = context.get_constant_null(wanted.inner)
    return made._getvalue()


def _written(kind: Carrier, value: Any, part: Any, first: int) -> Callable[..., Any]:
    """What writes a number of a kind from two arguments of a call, the first of which has this place."""

    def write(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        made = cgutils.create_struct_proxy(kind)(context, builder)
        made.value = context.cast(builder, arguments[first], value, kind.inner)
        made.part = context.cast(builder, arguments[first + 1], part, kind.inner)
        return made._getvalue()

    return write


@intrinsic
def _like(typingctx: Any, like: Any, value: Any, part: Any) -> Any:
    """A number of the type of the first."""
    return like(like, value, part), _written(like, value, part, 1)


def carry(kind: Carrier) -> Callable[..., Any]:
    """What makes a number of a kind from two of the inner one, for compiled code."""

    @intrinsic
    def carried(typingctx: Any, value: Any, part: Any) -> Any:
        return kind(value, part), _written(kind, value, part, 0)

    made: Callable[..., Any] = carried
    return made


def _by_type(typed: Callable[..., Any]) -> Callable[..., Any]:
    """A function for compiled code, which is what ``typed`` gives for the types of its arguments."""

    @wraps(typed)
    def called(*given: Any) -> Any:
        raise NotImplementedError

    overload(called)(typed)
    return called


@_by_type
def _plain(a: Any) -> Any:
    """The double behind a number."""
    return (lambda a: _plain(a.value)) if isinstance(a, Carrier) else (lambda a: a)


@_by_type
def value_of(a: Any) -> Any:
    """The value of a number that may carry something."""
    return (lambda a: a.value) if isinstance(a, Carrier) else (lambda a: a)


@_by_type
def part_of(a: Any) -> Any:
    """What a number carries; 0 where it carries nothing."""
    return (lambda a: a.part) if isinstance(a, Carrier) else (lambda a: 0.0)


@_by_type
def _is_nothing(a: Any) -> Any:
    if isinstance(a, Carrier):
        return lambda a: _is_nothing(a.value) and _is_nothing(a.part)
    return lambda a: a == 0.0


@_by_type
def _share(a: Any, slope: Any) -> Any:
    """What an operation of this slope hands on of what a number carries.

    That is nothing where it carries nothing, whatever the slope: that of a root at 0 is infinite.
    """
    if not isinstance(a, Carrier):
        return lambda a, slope: 0.0
    if a.kind == "dual":
        return lambda a, slope: a.part if _is_nothing(a.part) else slope * a.part
    return lambda a, slope: a.part if a.part == 0.0 else abs(slope) * a.part


@_by_type
def _rounding(a: Any, result: Any) -> Any:
    """What an operation adds to what it hands on."""
    return (lambda a, result: abs(result)) if a.kind == "bounded" else (lambda a, result: 0.0)


def _carrier(*given: Any) -> Any:
    """The one type of number with something that is among types, if the others are plain numbers."""
    found = {one for one in given if isinstance(one, Carrier)}
    plain = all(isinstance(one, Carrier | types.Number | types.Boolean) for one in given)
    return found.pop() if len(found) == 1 and plain else None


@cache
def _at(function: Callable[..., Any], *given: Any) -> Any:
    """A function to be compiled for these types alone.

    While a function is compiled for numbers within numbers it is needed for the inner ones, which numba would take
    for a recursion, and leave out.
    """
    return njit(function, error_model="numpy", **INNER)


def _one(functions: tuple[Any, ...], value: Callable[..., Any], slope: Callable[..., Any]) -> None:
    """Let functions of one number carry: value from the argument, slope from it and the value."""

    def typed(a: Any) -> Any:
        if _carrier(a) is None:
            return None
        of, by = _at(value, a), _at(slope, a)

        def impl(a):  # type: ignore[no-untyped-def]
            found = of(a.value)
            return _like(a, found, _share(a, by(a.value, found)) + _rounding(a, found))

        return impl

    for function in functions:
        overload(function)(typed)


def _two(
    functions: tuple[Any, ...], value: Callable[..., Any], first: Callable[..., Any], second: Callable[..., Any]
) -> None:
    """Let functions of two numbers carry: slopes by either from both and the value."""

    def typed(a: Any, b: Any) -> Any:
        if _carrier(a, b) is None:
            return None
        of, by_first, by_second = (_at(one, a, b) for one in (value, first, second))
        if isinstance(a, Carrier):

            def impl(a, b):  # type: ignore[no-untyped-def]
                u, v = a.value, value_of(b)
                found = of(u, v)
                shared = _share(a, by_first(u, v, found)) + _share(b, by_second(u, v, found))
                return _like(a, found, shared + _rounding(a, found))

            return impl

        def other(a, b):  # type: ignore[no-untyped-def]
            found = of(a, b.value)
            return _like(b, found, _share(b, by_second(a, b.value, found)) + _rounding(b, found))

        return other

    for function in functions:
        overload(function)(typed)


_two((operator.add, operator.iadd, np.add), lambda a, b: a + b, lambda a, b, r: 1.0, lambda a, b, r: 1.0)
_two((operator.sub, operator.isub, np.subtract), lambda a, b: a - b, lambda a, b, r: 1.0, lambda a, b, r: -1.0)
_two((operator.mul, operator.imul, np.multiply), lambda a, b: a * b, lambda a, b, r: b, lambda a, b, r: a)
_two(
    (operator.truediv, operator.itruediv, np.divide, np.true_divide),
    lambda a, b: a / b,
    lambda a, b, r: 1.0 / b,
    lambda a, b, r: -r / b,
)
_two(
    (operator.pow, operator.ipow, builtins.pow, math.pow, np.power),
    lambda a, b: a**b,
    lambda a, b, r: b * a ** (b - 1),
    lambda a, b, r: r * np.log(a),
)
_two(
    (operator.mod, operator.imod, np.mod, np.remainder),
    lambda a, b: a % b,
    lambda a, b, r: 1.0,
    lambda a, b, r: -(a // b),
)
_two(
    (operator.floordiv, operator.ifloordiv, np.floor_divide),
    lambda a, b: a // b,
    lambda a, b, r: 0.0,
    lambda a, b, r: 0.0,
)
_two(
    (math.atan2, np.arctan2),
    lambda a, b: math.atan2(a, b),
    lambda a, b, r: b / (a * a + b * b),
    lambda a, b, r: -a / (a * a + b * b),
)
_two((math.hypot, np.hypot), lambda a, b: math.hypot(a, b), lambda a, b, r: a / r, lambda a, b, r: b / r)
_two(
    (math.copysign, np.copysign),
    lambda a, b: math.copysign(a, b),
    lambda a, b, r: 1.0 if (a < 0) == (r < 0) else -1.0,
    lambda a, b, r: 0.0,
)

_one((operator.neg, np.negative), lambda a: -a, lambda a, r: -1.0)
_one((operator.pos,), lambda a: a, lambda a, r: 1.0)
_one((builtins.abs, math.fabs, np.abs, np.fabs, operator.abs), lambda a: abs(a), lambda a, r: -1.0 if a < 0 else 1.0)
_one((math.sqrt, np.sqrt), lambda a: math.sqrt(a), lambda a, r: 0.5 / r)
_one((math.exp, np.exp), lambda a: math.exp(a), lambda a, r: r)
_one((math.expm1, np.expm1), lambda a: math.expm1(a), lambda a, r: r + 1.0)
_one((math.log, np.log), lambda a: math.log(a), lambda a, r: 1.0 / a)
_one((math.log1p, np.log1p), lambda a: math.log1p(a), lambda a, r: 1.0 / (1.0 + a))
_one((math.sin, np.sin), lambda a: math.sin(a), lambda a, r: math.cos(a))
_one((math.cos, np.cos), lambda a: math.cos(a), lambda a, r: -math.sin(a))
_one((math.tan, np.tan), lambda a: math.tan(a), lambda a, r: 1.0 + r * r)
_one((math.asin, np.arcsin), lambda a: math.asin(a), lambda a, r: 1.0 / math.sqrt(1.0 - a * a))
_one((math.acos, np.arccos), lambda a: math.acos(a), lambda a, r: -1.0 / math.sqrt(1.0 - a * a))
_one((math.atan, np.arctan), lambda a: math.atan(a), lambda a, r: 1.0 / (1.0 + a * a))
_one((math.sinh, np.sinh), lambda a: math.sinh(a), lambda a, r: math.cosh(a))
_one((math.cosh, np.cosh), lambda a: math.cosh(a), lambda a, r: math.sinh(a))
_one((math.tanh, np.tanh), lambda a: math.tanh(a), lambda a, r: 1.0 - r * r)


def _compares(relation: Any) -> None:
    def typed(a: Any, b: Any) -> Any:
        return None if _carrier(a, b) is None else (lambda a, b: relation(_plain(a), _plain(b)))

    overload(relation)(typed)


for _relation in (operator.lt, operator.le, operator.gt, operator.ge, operator.eq, operator.ne):
    _compares(_relation)


def _of_value(function: Any) -> None:
    """Let a function see the value alone: a whole number, a truth value, a step."""

    def typed(a: Any) -> Any:
        return None if _carrier(a) is None else (lambda a: function(_plain(a)))

    overload(function)(typed)


for _function in (
    *(builtins.int, builtins.bool, operator.truth, math.isnan, math.isfinite, math.isinf, np.isnan, np.isfinite),
    *(np.isinf, np.sign, math.floor, math.ceil, math.trunc, np.floor, np.ceil, np.trunc, np.rint),
):
    _of_value(_function)


@overload(builtins.float)
def _float_of(a: Any) -> Any:
    return None if _carrier(a) is None else (lambda a: a)


def _chooses(functions: tuple[Any, ...], relation: Any) -> None:
    """Let the smaller or larger of two numbers be one of them, as it is."""

    def typed(a: Any, b: Any) -> Any:
        if _carrier(a, b) is None:
            return None
        if isinstance(a, Carrier):
            return lambda a, b: a if relation(_plain(a), _plain(b)) else _like(a, value_of(b), part_of(b))
        return lambda a, b: b if relation(_plain(b), _plain(a)) else _like(b, a, 0.0)

    for function in functions:
        overload(function)(typed)


_chooses((builtins.min, np.minimum, np.fmin), operator.lt)
_chooses((builtins.max, np.maximum, np.fmax), operator.gt)


@overload(np.searchsorted)
def _searched(a: Any, v: Any, side: Any = "left") -> Any:
    return None if not isinstance(v, Carrier) else (lambda a, v, side="left": np.searchsorted(a, _plain(v), side))


@overload(np.interp)
def _interpolated(x: Any, xp: Any, fp: Any) -> Any:
    if not isinstance(x, Carrier):
        return None

    def impl(x, xp, fp):  # type: ignore[no-untyped-def]
        here = _plain(x)
        if here <= xp[0]:
            return _like(x, fp[0], 0.0)
        if here >= xp[-1]:
            return _like(x, fp[-1], 0.0)
        j = np.searchsorted(xp, here, "right") - 1
        return fp[j] + (fp[j + 1] - fp[j]) / (xp[j + 1] - xp[j]) * (x - xp[j])

    return impl


@overload(carray)
def _as_array(pointer: Any, shape: Any, dtype: Any = None) -> Any:
    """A tuple is what the functions of cfuncs are given in place of a pointer."""
    return (lambda pointer, shape, dtype=None: pointer) if isinstance(pointer, types.BaseTuple) else None
