"""What a setting may be, said once: arguments of Python are read, and tables of a scene checked, by the same record."""

from collections import ChainMap
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import MISSING, Field, dataclass, field, fields
from inspect import Parameter
from math import inf, isfinite, nan
from typing import Any, ClassVar, Self, cast

from chaosdrill.errors import SettingsError
from chaosdrill.limits import Limit
from chaosdrill.names import brief, remedy
from chaosdrill.tuning import TUNING

KeyPath = tuple[str | int, ...]
"""Keys that lead to a value in tables and lists."""

Faults = Iterator[tuple[KeyPath, str]]
"""What is wrong in a table, each with the keys that lead to it."""

LONGEST = 10**10
"""Largest count: what is longer would not end; it is a slip of the pen."""


@dataclass
class Known:
    """What is known of the system to which settings belong, without building it."""

    known: Mapping[str, float] | None = None
    """Its parameters with their usual values; None while they are unknown."""
    parameters: Mapping[str, float] = field(default_factory=dict)  # those that are given other values
    states: tuple[str, ...] | None = None  # None while they are unknown
    limits: Mapping[str, Limit] = field(default_factory=dict)  # of its parameters
    drawn: int = 0  # how many of the states noise is made of

    @classmethod
    def of(cls, system: Any) -> "Known":
        """What is known of a system that is built."""
        if system is None:
            return Known()
        return Known(
            dict(system.parameters),
            states=tuple(system.state_names),
            limits=system.limits,
            drawn=len(system.state_names) - system.free,
        )

    def unused(self, parameter: str) -> str:
        """Why it has no such parameter, if other effects than the chosen ones use it; else nothing."""
        return ""

    def refuses(self, name: str, value: Any) -> str | None:
        """Why a parameter cannot have a value; None for one that it can, and for anything but a finite number."""
        return self.limits[name].refuses(value) if name in self.limits else None


class Value:
    """What a setting may be."""

    @property
    def type_name(self) -> str:
        """Its type in words, as docstrings give it."""
        raise NotImplementedError

    def read(self, name: str, value: Any, system: Any) -> Any:
        """An argument as the analysis takes it, checked as a scene is.

        Raises `SettingsError`, with the name of the argument, the value, and what it must be.
        """
        plain = self.plain(value)
        for path, text in (*self.faults(plain), *self.misfits(plain, Known.of(system))):
            raise SettingsError(_of_an_argument(name, plain, path, text))
        return self.argument(plain)

    def plain(self, value: Any) -> Any:
        """An argument as a scene has it: numbers of other packages are Python's, and sequences lists."""
        return value

    def faults(self, value: Any) -> Faults:
        """What is wrong with a value, whatever the system."""
        raise NotImplementedError

    def misfits(self, value: Any, known: Known) -> Faults:
        """What of a value, sound or not, does not fit the system."""
        yield from ()

    def argument(self, value: Any) -> Any:
        """The argument for which a sound value of a scene stands."""
        return value


@dataclass(frozen=True)
class Whole(Value):
    """A count."""

    least: int = 0
    most: int = LONGEST
    type_name = "int"

    def plain(self, value: Any) -> Any:
        number = real(value)
        # of larger ones not every whole number is one of these
        return int(value) if abs(number) <= 2**53 and number == number // 1 else value

    def faults(self, value: Any) -> Faults:
        if not isinstance(value, int) or isinstance(value, bool):
            yield (), told("expected a whole number", value)
        else:
            yield from _beyond(value, least=self.least, most=self.most)


@dataclass(frozen=True)
class Number(Value):
    """A finite number."""

    least: float = -inf
    most: float = inf
    above: float = -inf
    type_name = "float"

    def plain(self, value: Any) -> Any:
        number = real(value)
        return value if isinstance(value, int) or number != number else number

    def faults(self, value: Any) -> Faults:
        if not isinstance(value, int | float) or isinstance(value, bool):
            yield (), told("expected a number", value)
        elif not isfinite(real(value)):
            yield (), told("must be finite", value)
        else:
            yield from _beyond(value, least=self.least, most=self.most, above=self.above)

    def argument(self, value: Any) -> float:
        return float(value)


class Amount(Number):
    """A number that stays whole where it is given so, such as a length in periods."""

    type_name = "int or float"

    def argument(self, value: Any) -> Any:
        return value


class Text(Value):
    """Text."""

    type_name = "str"

    def faults(self, value: Any) -> Faults:
        if not isinstance(value, str):
            yield (), told("expected text in quotes", value)


@dataclass(frozen=True)
class Choice(Value):
    """One of a few words."""

    words: tuple[str, ...]
    hint: str = ""

    @property
    def type_name(self) -> str:
        return "{" + ", ".join(f'"{word}"' for word in self.words) + "}"

    def faults(self, value: Any) -> Faults:
        if not isinstance(value, str) or value not in self.words:
            yield (), told(f"expected one of {list(self.words)}{self.hint}", value)


@dataclass(frozen=True)
class ListOf(Value):
    """A list of values, not empty."""

    item: Value
    distinct: bool = False
    least: int = 1
    most: int = 1_000_000
    hint: str = ""

    @property
    def type_name(self) -> str:
        item = "str" if isinstance(self.item, Text) else self.item.type_name
        return f"pair of {item}" if self.least == self.most == 2 else f"sequence of {item}"

    def plain(self, value: Any) -> Any:
        found = listed(value)
        return [self.item.plain(one) for one in found] if isinstance(found, list) else value

    def faults(self, value: Any) -> Faults:
        if not isinstance(value, list):
            yield (), told(too_long(value) or f"expected a list{self.hint}", value)
            return
        yield from long(value, self.least, self.most)
        found = [((index, *path), text) for index, one in enumerate(value) for path, text in self.item.faults(one)]
        yield from found
        if self.distinct and not found and len(set(value)) < len(value):
            yield (), told("contains a value twice; each may occur only once", value)

    def misfits(self, value: Any, known: Known) -> Faults:
        for index, one in enumerate(value if isinstance(value, list) else ()):
            yield from within((index,), self.item.misfits(one, known))

    def argument(self, value: Any) -> list[Any]:
        return [self.item.argument(one) for one in value]


@dataclass(frozen=True)
class TableOf(Value):
    """A table of values under any names; without ``item`` whatever they are."""

    item: Value | None = None
    hint: str = ""
    type_name = "mapping"

    def faults(self, value: Any) -> Faults:
        if not isinstance(value, Mapping):
            yield (), told(f"expected a table{self.hint}", value)
        elif self.item is not None:
            for name, one in value.items():
                yield from within((name,), self.item.faults(one))

    def argument(self, value: Any) -> dict[str, Any]:
        return {name: one if self.item is None else self.item.argument(one) for name, one in value.items()}


def setting(value: Value, default: Any = MISSING, *, doc: str = "", positional: bool = False) -> Any:
    """Declare a field of `Settings`: what it may be, its default, and what it means.

    One whose default is None may be None.
    """
    return field(default=default, kw_only=not positional, metadata={"value": value, "doc": doc})


@dataclass(frozen=True, kw_only=True)
class Settings:
    """A record of settings: signature of a function, table of a scene, and provenance."""

    meanings: ClassVar[Mapping[str, str]] = {}
    """What settings of a base class mean here, where that is not what they mean there."""

    @classmethod
    def described(cls) -> dict[str, tuple[str, str]]:
        """Type with default, and meaning, of each setting, by name, as docstrings and lists give them."""
        meant = cls.meant()
        return {one.name: (_type_of(one), meant.get(one.name, one.metadata["doc"])) for one in fields(cls)}

    @classmethod
    def meant(cls) -> Mapping[str, str]:
        """The meanings that are said for this class and its bases, the nearest first."""
        return ChainMap(*(dict(vars(one).get("meanings", {})) for one in cls.__mro__))

    @classmethod
    def values(cls) -> dict[str, Value]:
        """What each setting may be, by name."""
        return {one.name: one.metadata["value"] for one in fields(cls)}

    @classmethod
    def signature(cls) -> list[Parameter]:
        """The settings as parameters of a function."""
        return sorted(map(_parameter, fields(cls)), key=lambda one: one.kind)

    @classmethod
    def default(cls, name: str) -> Any:
        """Default of a setting; None for one that there is not."""
        return getattr(cls, name, None)

    @classmethod
    def read(cls, given: Mapping[str, Any], system: Any) -> Self:
        """The settings from arguments.

        Raises `SettingsError` for an argument that cannot be used, `TypeError` for one that is missing, if all others
        can be.
        """
        read, table = {}, {}
        missing = [one.name for one in cls.signature() if one.name not in given and one.default is Parameter.empty]
        for one in fields(cls):
            if one.name in missing:
                continue
            value, rule = given[one.name], one.metadata["value"]
            if value is None and isinstance(one.default, tuple):
                value = one.default
            left_out = value is None and one.default is None
            read[one.name] = None if left_out else rule.read(one.name, value, system)
            if not left_out and not _is_default(one, value):
                table[one.name] = rule.plain(value)
        if missing:
            raise TypeError(f"missing a required argument: {missing[0]!r}")
        for faults in (cls.beside(table), cls.together(table, Known.of(system)), cls.misfits(table, system)):
            for path, text in faults:
                name, *rest = path or ("",)
                where = (str(name), table.get(str(name)), tuple(rest))
                raise SettingsError(_of_an_argument(*where, text) if name else text)
        return cls(**read)

    @classmethod
    def faults(cls, table: Any, known: Known | None = None, also: Sequence[str] | None = None) -> Faults:
        """All that is wrong with a table of a scene.

        ``table``: what stands in the scene. ``also``: further keys that it may have; None for a table within another,
        whose names are few and seen together.
        """
        known = known or Known()
        if not isinstance(table, Mapping):
            yield (), told("expected a table", table)
            return
        values = cls.values()
        found: list[tuple[KeyPath, str]] = []
        for key in table:
            if key not in values and key not in (also or ()):
                advice = "leave it out" if also is None else remedy(key, (*also, *values))
                found.append(((key,), f"unknown key; {advice}"))
        for one in fields(cls):
            if one.name in table:
                found += within((one.name,), one.metadata["value"].faults(table[one.name]))
            elif _is_needed(one):
                found.append(((one.name,), f"missing; {_wanted(one.metadata['value'])}"))
        yield from found or cls.together(table, known)
        yield from cls.beside(table)
        for name, value in values.items():
            if name in table:
                yield from within((name,), value.misfits(table[name], known))

    @classmethod
    def together(cls, table: Mapping[str, Any], known: Known) -> Faults:
        """What is wrong with settings that are each sound."""
        yield from ()

    @classmethod
    def beside(cls, table: Mapping[str, Any]) -> Faults:
        """What is wrong with a setting because of another one, whether or not all are sound."""
        yield from ()

    @classmethod
    def misfits(cls, table: Mapping[str, Any], system: Any) -> Faults:
        """What of a sound table does not fit a system that is built."""
        yield from ()

    @classmethod
    def arguments(cls, table: Mapping[str, Any]) -> dict[str, Any]:
        """The arguments for which a sound table stands."""
        return {name: value.argument(table[name]) for name, value in cls.values().items() if name in table}


def _parameter(one: "Field[Any]") -> Parameter:
    """A setting as a parameter; None stands there for a list that is its default."""
    default, annotation = one.default, cast(Any, one.type)
    if isinstance(default, tuple):
        default, annotation = None, annotation | None
    return Parameter(
        one.name,
        Parameter.KEYWORD_ONLY if one.kw_only else Parameter.POSITIONAL_OR_KEYWORD,
        default=Parameter.empty if _is_needed(one) else default,
        annotation=annotation,
    )


def _type_of(one: "Field[Any]") -> str:
    """The type of a setting in words, with its default."""
    name, default = one.metadata["value"].type_name, one.default
    if _is_needed(one):
        return str(name)
    if default is None or isinstance(default, tuple):
        return f"{name}, optional"
    shown = f"{default:g}".replace("e-0", "e-") if type(default) is float else str(default)
    return f'{name}, default "{default}"' if isinstance(default, str) else f"{name}, default {shown}"


def _is_needed(one: "Field[Any]") -> bool:
    return one.default is MISSING


def _wanted(value: Value) -> str:
    """What a value must be, as its own fault says it of nothing."""
    return next(text for _, text in value.faults(None)).removesuffix(told("", None))


def _is_default(one: "Field[Any]", value: Any) -> bool:
    """Whether a sound argument says no more than leaving it out does."""
    return value is one.default or (isinstance(one.default, int | float | str) and bool(value == one.default))


def within(place: KeyPath, faults: Faults) -> Faults:
    """Faults of what stands at a place."""
    for path, text in faults:
        yield (*place, *path), text


def told(words: str, value: Any) -> str:
    """A fault with the value, but for a table, which stands there to be read."""
    return words if isinstance(value, Mapping) else f"{words}, received {brief(value)}"


def _of_an_argument(name: str, value: Any, path: KeyPath, text: str) -> str:
    """A fault of an argument: its place and value, and then what it must be."""
    for key in path:
        name += f"[{key}]" if isinstance(key, int) else f".{key}"
        value = value.get(key) if isinstance(value, Mapping) else value[key]
    words = text.removesuffix(received := told("", value))
    return f"{name} is {brief(value)}; {words}" if received and words != text else f"{name}: {text}"


def _beyond(value: Any, *, least: float = -inf, most: float = inf, above: float = -inf) -> Faults:
    if value < least:
        yield (), told(f"must be at least {least:g}", value)
    elif value <= above:
        yield (), told(f"must be greater than {above:g}", value)
    elif value > most:
        yield (), told(f"must be at most {most:g}", value)


def long(value: Any, least: int, most: int) -> Faults:
    """Faults of the length of a list or a table."""
    if len(value) < least:
        yield (), told("must not be empty" if least == 1 else f"must have at least {least} entries", value)
    elif len(value) > most:
        yield (), told(f"must have at most {most} entries", value)


def too_long(value: Any) -> str:
    """Why an array or a range is not listed, however little memory it takes; empty for what can be."""
    size = getattr(value, "size", 0)
    if isinstance(value, range) and value:
        # it may be too long for len()
        size = (value[-1] - value[0]) // value.step + 1
    if not isinstance(size, int) or size <= TUNING.listed:
        return ""
    return f"has {size:.4g} entries, and at most {TUNING.listed} are taken"


def listed(value: Any) -> Any:
    """A tuple, an array or the like as a list; anything else, or an endless one, unchanged."""
    if too_long(value):
        return value
    if not isinstance(value, Iterable) or isinstance(value, str | bytes | Mapping) or getattr(value, "ndim", 1) == 0:
        return value
    return list(value)


def entries(value: Any) -> list[Any]:
    """The entries of a list, a tuple or an array; none of anything else."""
    found = listed(value)
    return found if isinstance(found, list) else []


def whole(name: str, value: Any, least: int, most: int = LONGEST) -> int:
    """An integer from ``least`` to ``most``, or an error that names the argument."""
    return int(Whole(least, most).read(name, value, None))


def positive(name: str, value: Any) -> float:
    """A finite number above 0, or an error that names the argument."""
    return real(Number(above=0.0).read(name, value, None))


def real(value: Any) -> float:
    """The value as a float; NaN for anything but a real number, such as texts, truth values, dates and masked ones,
    and for one that is nearer to 0 than any double."""
    # what numpy would drop is the imaginary part
    none = isinstance(value, bool) or getattr(getattr(value, "dtype", None), "kind", "") in ("b", "c", "m", "M")
    if none or isinstance(value, str | bytes) or bool(getattr(value, "ndim", 0)) or is_masked(value):
        return nan
    try:
        number = float(value)
        return number if number or value == 0 else nan
    except OverflowError:
        return inf
    except (TypeError, ValueError):
        return nan


def is_masked(value: Any) -> bool:
    """Whether a single value is marked as missing, of which numpy makes a NaN with a warning, and sympy a zero."""
    return getattr(value, "ndim", None) == 0 and bool(getattr(value, "mask", False))
