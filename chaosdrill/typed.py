"""Arguments of public functions are of the type that they must be, or are refused by their names."""

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import wraps
from inspect import BoundArguments, Parameter, Signature, signature
from numbers import Integral, Real
from typing import Any, ParamSpec, TypeVar

from chaosdrill.errors import ChaosdrillError
from chaosdrill.names import brief, remedy

P = ParamSpec("P")
R = TypeVar("R")
C = TypeVar("C")


@dataclass(frozen=True)
class Kind:
    """A type of arguments."""

    words: str  # what an argument must be
    holds: Callable[[Any], bool]  # whether a value is of this type
    way: Callable[[Any], str] = lambda value: ""  # how one comes of another value


def _is_path(value: Any) -> bool:
    return isinstance(value, str) or (isinstance(value, os.PathLike) and isinstance(os.fspath(value), str))


def _way_to_path(value: Any) -> str:
    if hasattr(value, "attrs"):
        return "; save it first, as in chaosdrill.save(ds, 'result.nc'), which returns its path"
    if hasattr(value, "with_parameters"):
        return "; run an analysis of the system and save its result, as in chaosdrill.save(ds, 'result.nc')"
    return ""


def _is_table(value: Any) -> bool:
    return isinstance(value, Mapping) and all(isinstance(key, str) for key in value)


def _are_plane(value: Any) -> bool:
    from matplotlib.axes import Axes

    # what polar axes and maps of the globe have, and what axes in space have
    return isinstance(value, Axes) and not hasattr(value, "transProjection") and not hasattr(value, "zaxis")


PATH = Kind("the name of a file, as text or a pathlib.Path", _is_path, _way_to_path)
FOLDER = Kind(
    "the name of a folder, as text or a pathlib.Path",
    lambda value: _is_path(value) and value != "" and "\0" not in os.fspath(value),
)
RESULT = Kind("what an analysis returned", lambda value: not _is_path(value))
TEXT = Kind("text", lambda value: isinstance(value, str))
TABLE = Kind("a mapping of names to values, as in {'a': 0.3}", _is_table)
TABLES = Kind(
    "a mapping of names to mappings, as in {'motion': {'kind': 'trajectory'}}",
    lambda value: _is_table(value) and all(map(_is_table, value.values())),
)
NAMED = Kind(
    "a name or several, as in 'x' or ('x', 'v')",
    lambda value: (
        isinstance(value, str) or (isinstance(value, list | tuple) and all(isinstance(n, str) for n in value))
    ),
)
AXES = Kind(
    "plane axes of matplotlib, as matplotlib.pyplot.gca() returns",
    _are_plane,
)
FUNCTION = Kind("a function", callable)
COUNT = Kind("a whole number from 1 on", lambda value: isinstance(value, Integral) and int(value) >= 1)
NUMBER = Kind("a number", lambda value: isinstance(value, Real) and not isinstance(value, bool))
LISTENER = Kind("True, False or a function", lambda value: isinstance(value, bool) or callable(value))
SWITCH = Kind("True or False", lambda value: isinstance(value, bool))


def refuse(error: type[ChaosdrillError], name: str, value: Any, kind: Kind, way: str = "") -> None:
    """Raise an error if a value is not of a type.

    Raises `ChaosdrillError`, of the class that is given, with the name of the argument, the value, and what it must be.
    """
    if not kind.holds(value):
        raise error(f"{name} is {brief(value)}; it must be {kind.words}{way or kind.way(value)}")


_RATES = ("equations", "rhs", "rates", "flow", "odes", "ode", "vector_field")

_SPELT = {
    "tolerance": ("tol", "rtol", "atol", "eps", "accuracy", "precision"),
    "workers": ("n_jobs", "njobs", "jobs", "processes", "n_workers", "cores", "parallel"),
    "periods": ("n", "n_periods", "num_periods", "cycles", "n_cycles", "iterations"),
    "duration": ("t_end", "t_max", "tmax", "tend", "t_final", "t_span", "tspan", "T", "total_time"),
    "times": ("t", "t_eval", "saveat"),
    "transient": ("skip", "discard", "ttr", "Ttr", "burn_in", "burnin", "settle", "t_transient"),
    "initial": ("x0", "y0", "u0", "ic", "initial_state", "initial_conditions", "start", "state0"),
    "parameters": ("params", "param", "p", "args"),
    "sweep": ("values", "range", "ranges", "parameter", "param_range", "grid"),
    "at": ("section", "plane", "surface", "event", "crossing"),
    "samples": ("dt", "step", "step_size", "h", "n_samples", "num_points", "resolution"),
    "path": ("file", "filename", "fname", "filepath"),
    "exponents": ("k", "n_exponents", "num_exponents"),
    "method": ("solver", "integrator", "algorithm"),
    "ax": ("axes", "axis", "axs"),
    "modes": _RATES,
    "transitions": ("events", "jumps", "impacts", "switches", "guards", "resets"),
    "reset": ("jump", "action", "map", "effect"),
    "field": ("modes", *_RATES),
    "above": ("positive", "plus", "upper"),
    "below": ("negative", "minus", "lower"),
    "images": ("step", "map", "update", "image", "rule"),
}
"""What other packages call an argument."""

_OF_LINES = (
    *("color", "c", "lw", "linewidth", "marker", "s", "x", "y"),
    *("label", "title", "xlabel", "ylabel", "xlim", "ylim"),
)
_OF_FIGURES = ("figsize", "dpi", "style", "fig", "figure", "fontsize", "font_size", "size")

_SIZES = "matplotlib.rc_context({'figure.figsize': (6, 3), 'font.size': 9})"

_ELSEWHERE = {
    "parameters": ("system", "system.with_parameters(name=value) returns a copy with other parameters"),
    "initial": ("system", "system.with_initial(name=value) returns a copy that starts elsewhere"),
    "sweep": ("system", "bifurcation_diagram and parameter_chart sweep parameters"),
    **dict.fromkeys(("mode", "initial_mode", "start_mode"), ("initial", "write initial={'mode': ...}")),
    "samples": ("system", "the method chooses its own steps, by tolerance"),
    **dict.fromkeys(_OF_LINES, ("ax", "change the axes that come back, as in axes.set(title='...')")),
    **dict.fromkeys(_OF_FIGURES, ("ax", f"pass axes of your own figure, or use {_SIZES}")),
}
"""Where else a function with a certain argument, named first, has what its caller looks for."""


def meant(name: str, keywords: Mapping[str, Any], names: list[str], system: Any = None) -> str:
    """The remedy of a keyword that a function does not have."""
    spelt = [ours for ours, theirs in _SPELT.items() if name in theirs]
    if wanted := [own for own in spelt if own in names]:
        return f"did you mean {wanted[0]!r}?"
    own = spelt[0] if spelt else name
    if name in getattr(system, "parameters", ()):
        way = f"give sweep={{{name!r}: [...]}}" if "sweep" in names else f"pass system.with_parameters({name}=...)"
        return f"it is a parameter of the system: {way}"
    beside, way = _ELSEWHERE.get(own, ("", ""))
    if beside in names:
        return way
    told = remedy(name, names)
    if "parameters" in names and told.startswith("known"):
        return f"a parameter goes into parameters={{{name!r}: {brief(keywords[name], 20)}}}; {told}"
    return told


def given_to(
    function: str, known: Signature, arguments: Sequence[Any], keywords: Mapping[str, Any], system: Any = None
) -> BoundArguments:
    """The arguments of a call by their names, where some may be missing; ``system``: what it was called with, if any.

    Raises `TypeError` for a keyword that the function does not have, with the name that is likely to be meant, for more
    arguments without a name than it takes, with the names of those, and for one that is given twice.
    """
    open_ended = any(one.kind is Parameter.VAR_KEYWORD for one in known.parameters.values())
    names = [name for name, one in known.parameters.items() if one.kind is not Parameter.POSITIONAL_ONLY]
    for name in () if open_ended else keywords:
        if name not in names:
            way = meant(name, keywords, names, system)
            raise TypeError(f"{function}() got an unexpected keyword argument {name!r}; {way}")
    places = _places(known)
    if len(arguments) > len(places):
        named = [name for name, one in known.parameters.items() if one.kind is Parameter.KEYWORD_ONLY]
        listed = f" ({', '.join(places)})" if places else ""
        takes = f"{len(places) or 'no'} argument{'s' * (len(places) != 1)} without a name{listed}"
        way = f"name {'the others' if places else 'them'}, as in {named[0]}=..." if named else "leave the others out"
        if "sweep" in places and isinstance(swept := arguments[places.index("sweep")], str):
            way = f"give sweep={{{swept!r}: [...]}}"
        raise TypeError(f"{function}() takes {takes}, received {len(arguments)}; {way}")
    try:
        return known.bind_partial(*arguments, **keywords)
    except TypeError as fault:
        raise TypeError(f"{function}() got {fault}") from None


def _places(known: Signature) -> list[str]:
    """The arguments that need no name, in order."""
    return [name for name, one in known.parameters.items() if one.kind is Parameter.POSITIONAL_OR_KEYWORD]


def known_all(function: str, known: Signature, given: Mapping[str, Any]) -> None:
    """Refuse a call that leaves a required argument out.

    Raises `TypeError`, with its name, and where the arguments are described.
    """
    for name, one in known.parameters.items():
        single = one.kind not in (Parameter.VAR_POSITIONAL, Parameter.VAR_KEYWORD)
        if single and one.default is Parameter.empty and name not in given:
            instead = [key for key in given.get("more", ()) if key in _SPELT.get(name, ())]
            way = f"{instead[0]!r} is not one of its arguments; " if instead else ""
            raise TypeError(f"{function}() missing a required argument: {name!r}; {way}see help(chaosdrill.{function})")


def constructor(kind: type[C]) -> type[C]:
    """Have a class refuse arguments that it does not have, and calls that leave one out, with the way."""
    changed: Any = kind
    known, make = signature(kind), changed.__init__

    @wraps(make)
    def checked(self: C, *arguments: Any, **keywords: Any) -> None:
        known_all(kind.__name__, known, given_to(kind.__name__, known, arguments, keywords).arguments)
        make(self, *arguments, **keywords)

    changed.__init__ = checked
    return kind


def expecting(error: type[ChaosdrillError], **kinds: Kind) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Have a function refuse arguments of other types than these; one whose default is None may be None.

    ``error``: what it raises then. ``**kinds``: types by argument.
    """

    def wrap(function: Callable[P, R]) -> Callable[P, R]:
        known = signature(function)
        places = _places(known)
        optional = {name for name, parameter in known.parameters.items() if parameter.default is None}

        def order(name: str, kind: Kind, given: Mapping[str, Any]) -> str:
            """That arguments stand in another order, if one of them would do in the place of this one."""
            others = [value for other, value in given.items() if kinds.get(other) is not kind and other != name]
            return f"; the order is {function.__name__}({', '.join(places)})" if any(map(kind.holds, others)) else ""

        @wraps(function)
        def checked(*arguments: P.args, **keywords: P.kwargs) -> R:
            given = given_to(function.__name__, known, arguments, keywords).arguments
            for name, kind in kinds.items():
                if name in given and not (given[name] is None and name in optional):
                    plain = {key: value for key, value in given.items() if key not in keywords}
                    refuse(error, name, given[name], kind, order(name, kind, plain) if name in plain else "")
            known_all(function.__name__, known, given)
            return function(*arguments, **keywords)

        return checked

    return wrap
