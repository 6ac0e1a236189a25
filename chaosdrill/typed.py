"""Arguments of public functions are of the type that they must be, or are refused by their names."""

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import wraps
from inspect import Parameter, Signature, signature
from numbers import Integral, Real
from typing import Any, ParamSpec, TypeVar

from chaosdrill.errors import ChaosdrillError
from chaosdrill.names import remedy, shown

P = ParamSpec("P")
R = TypeVar("R")


@dataclass(frozen=True)
class Kind:
    """A type of arguments."""

    words: str  # what an argument must be
    holds: Callable[[Any], bool]  # whether a value is of this type


def _is_path(value: Any) -> bool:
    return isinstance(value, str) or (isinstance(value, os.PathLike) and isinstance(os.fspath(value), str))


def _is_table(value: Any) -> bool:
    return isinstance(value, Mapping) and all(isinstance(key, str) for key in value)


def _is_nested(value: Any) -> bool:
    return _is_table(value) and all(map(_is_table, value.values()))


PATH = Kind("the name of a file, as text or a pathlib.Path", _is_path)
TEXT = Kind("text", lambda value: isinstance(value, str))
TABLE = Kind("a mapping of names to values, as in {'a': 0.3}", _is_table)
TABLES = Kind("a mapping of names to mappings, as in {'motion': {'kind': 'trajectory'}}", _is_nested)
NAMED = Kind(
    "a name or several, as in 'x' or ('x', 'v')",
    lambda value: (
        isinstance(value, str) or (isinstance(value, list | tuple) and all(isinstance(n, str) for n in value))
    ),
)
AXES = Kind("axes of matplotlib, as matplotlib.pyplot.gca() returns", lambda value: hasattr(value, "get_figure"))
FUNCTION = Kind("a function", callable)
COUNT = Kind("a whole number from 1 on", lambda value: isinstance(value, Integral) and int(value) >= 1)
NUMBER = Kind("a number", lambda value: isinstance(value, Real) and not isinstance(value, bool))
LISTENER = Kind("True, False or a function", lambda value: isinstance(value, bool) or callable(value))
SWITCH = Kind("True or False", lambda value: isinstance(value, bool))


def refuse(error: type[ChaosdrillError], name: str, value: Any, kind: Kind) -> None:
    """Raise an error if a value is not of a type.

    Raises
    ------
    ChaosdrillError
        Of the class that is given, with the name of the argument, the value, and what it must be.
    """
    if not kind.holds(value):
        raise error(f"{name} is {shown(value):.60}; it must be {kind.words}")


def known_names(function: str, known: Signature, keywords: Mapping[str, Any]) -> None:
    """Refuse a keyword that a function does not have.

    Raises
    ------
    TypeError
        With the name that is likely to be meant.
    """
    if any(one.kind is Parameter.VAR_KEYWORD for one in known.parameters.values()):
        return
    names = [name for name, one in known.parameters.items() if one.kind is not Parameter.POSITIONAL_ONLY]
    for name in keywords:
        if name not in names:
            raise TypeError(f"{function}() got an unexpected keyword argument {name!r}; {remedy(name, names)}")


def expecting(error: type[ChaosdrillError], **kinds: Kind) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Have a function refuse arguments of other types than these; one whose default is None may be None.

    Parameters
    ----------
    error : type
        What it raises then.
    **kinds : Kind
        Types by argument.
    """

    def wrap(function: Callable[P, R]) -> Callable[P, R]:
        known = signature(function)
        optional = {name for name, parameter in known.parameters.items() if parameter.default is None}

        @wraps(function)
        def checked(*arguments: P.args, **keywords: P.kwargs) -> R:
            known_names(function.__name__, known, keywords)
            try:
                given = known.bind_partial(*arguments, **keywords).arguments
            except TypeError:
                # a call with too many arguments has Python's own words
                given = {}
            for name, kind in kinds.items():
                if name in given and not (given[name] is None and name in optional):
                    refuse(error, name, given[name], kind)
            return function(*arguments, **keywords)

        return checked

    return wrap
