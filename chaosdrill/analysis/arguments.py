"""Arguments that analyses share: sections, swept values, parameters, exponents, methods."""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from math import inf, isfinite
from typing import TYPE_CHECKING, Any, ClassVar

from chaosdrill.declared import METHODS, unfit
from chaosdrill.engine.methods import NAMES
from chaosdrill.names import event_words, key_text, remedy
from chaosdrill.settings import (
    LONGEST,
    Choice,
    Faults,
    Known,
    ListOf,
    Number,
    Settings,
    Text,
    Value,
    Whole,
    real,
    setting,
    told,
    too_long,
    within,
)

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem

MOST_POINTS = 1_000_000
"""Values of a swept parameter."""

LONGEST_PERIOD = 1000
"""Longest period of an orbit, in forcing periods: longer ones have too many unknowns to be solved together."""


def example_of_section(system: "HybridSystem") -> str:
    """A section that the system has, as a setting."""
    events = sorted({t.name for t in system.transitions})
    surface = f"at={system.state_names[0] + ' > 0'!r}"
    return f"at={events[0]!r} or {surface}" if events else surface


def misfits_of_duration(table: Mapping[str, Any], system: "HybridSystem") -> Faults:
    """A time where lengths are counted in periods or iterates."""
    if "duration" in table and system.forced:
        about = max(1, round(table["duration"] / system.forcing_period()))
        words = "is a map; give periods instead, which count its iterates"
        if not system.discrete:
            words = f"has a forcing period; give periods instead (about {about})"
        yield ("duration",), told(f"{system.name} {words}", table["duration"])


def misfits_of_section(table: Mapping[str, Any], system: "HybridSystem") -> Faults:
    """A section that a system does not have, and a transient that is no whole number of what it counts."""
    at = table.get("at")
    if at is not None and (fault := section_fault(system, at)):
        yield ("at",), told(fault, at)
    what = "iterates" if system.discrete else "forcing periods" if at in (None, "strobe") else "points of the section"
    transient, counted = table.get("transient") or 0, (system.forced or at is not None) and "duration" not in table
    if counted and transient % 1:
        yield ("transient",), told(f"expected whole {what}", transient)
    elif transient > LONGEST * (1 if counted else table.get("duration", inf)):
        yield ("transient",), told(f"must be at most {LONGEST:.0e} {what if counted else 'durations'}", transient)


def tangent_count(system: "HybridSystem", exponents: Any) -> int:
    """Number of requested exponents; all by default."""
    return system.free if exponents is None else int(Exponents().read("exponents", exponents, system))


class At(Text):
    """A section: ``"strobe"``, the name or kind of a transition, or a comparison, met where it becomes true."""

    def plain(self, value: Any) -> Any:
        from chaosdrill.model.text import write_text

        return write_text(value) if getattr(value, "is_Relational", False) else value


def section_fault(system: "HybridSystem", at: str, *, ends: bool = False) -> str | None:
    """Why a system has no such section, or no such ends of lives; None if it has."""
    events = event_words(system.transitions)
    if at == "strobe":
        if system.forced:
            return None
        return f"{system.name} has no forcing period for a strobe; give an event, as in {example_of_section(system)}"
    if at in events:
        return None
    if system.discrete and not ends:
        crossed = "<" in at or ">" in at
        what = "iterates jump across a surface, and none is on it" if crossed else "it has no such event"
        return f"{system.name} is a map: {what}; leave it out, the section is every iterate"
    if not ("<" in at or ">" in at):
        strobe = ("strobe",) if system.forced else ()
        way = remedy(at, (*strobe, *events)).removesuffix("?")
        example = f"'{system.state_names[0]} > 0'"
        return f"unknown event {at!r:.60}; {way}; or give a comparison that becomes true there, such as {example}"
    from chaosdrill.model.grammar import ExpressionError
    from chaosdrill.model.surface import surface

    try:
        surface(system, at)
    except ExpressionError as fault:
        return str(fault)
    return None


@dataclass(frozen=True)
class Exponents(Whole):
    """How many Lyapunov exponents; a system has as many as states."""

    def misfits(self, value: Any, known: Known) -> Faults:
        if known.states is None:
            return
        free = len(known.states) - known.drawn
        if isinstance(value, int) and value > free:
            yield (), f"the system has {free} states and as many exponents, received {value}"


class Parameters(Value):
    """Parameters by name, or whether all of them or none."""

    type_name = "bool or list of str"
    _list = ListOf(Text(), distinct=True)

    def plain(self, value: Any) -> Any:
        return bool(value) if getattr(getattr(value, "dtype", None), "kind", "") == "b" else self._list.plain(value)

    def faults(self, value: Any) -> Faults:
        if isinstance(value, list):
            yield from self._list.faults(value)
        elif not isinstance(value, bool):
            yield (), told(too_long(value) or "expected true for all parameters, or a list of some", value)

    def misfits(self, value: Any, known: Known) -> Faults:
        for index, name in enumerate(value if isinstance(value, list) and known.known is not None else ()):
            if isinstance(name, str) and name not in known.known:  # type: ignore[operator]
                words = known.unused(name) or f"unknown parameter; {remedy(name, known.known or ())}"
                yield (index,), told(words, name)
        if value is True and known.known is not None and not known.known:
            yield (), "the system has no parameters; leave it out"


PARAMETERS = Parameters()


def chosen(system: "HybridSystem", wanted: bool | list[str]) -> tuple[str, ...]:
    """The parameters for which a sound setting `Parameters` stands."""
    if isinstance(wanted, bool):
        return tuple(system.parameters) if wanted else ()
    return tuple(wanted)


SCIPY = {"rk23": False, "rk45": False, "bdf": True, "lsoda": True}
"""Whether a method of SciPy is implicit; by its letters ``rk45`` resembles ``rk4``."""


class Method(Text):
    """A numerical method."""

    type_name = Choice(tuple(NAMES)).type_name

    def faults(self, value: Any) -> Faults:
        if isinstance(value, str) and value not in METHODS:
            yield (), f"unknown method {value!r:.60}; {remedy(_meant(value), METHODS)}"
        yield from super().faults(value)


def _meant(name: str) -> str:
    """The method that does the work of one of SciPy's; other names as they are."""
    implicit = SCIPY.get(name.lower())
    alike = (n for n, one in METHODS.items() if not (one.series or one.fixed_step) and one.implicit == implicit)
    return name if implicit is None else next(alike)


@dataclass(frozen=True, kw_only=True)
class Range(Settings):
    """Equally spaced values, both ends included."""

    start: float = setting(Number())
    stop: float = setting(Number())
    num: int = setting(Whole(1, MOST_POINTS))

    @classmethod
    def together(cls, table: Mapping[str, Any], known: Known) -> Faults:
        if table["start"] == table["stop"] and table["num"] > 1:
            yield (), "start and stop are equal; give num = 1, or another stop"


class Times(Value):
    """Times of output, in ascending order."""

    type_name = "list of float"

    def plain(self, value: Any) -> Any:
        return _LIST.plain(value)

    def faults(self, value: Any) -> Faults:
        yield from _values(value)
        times = [one for one in value if isinstance(one, int | float)] if isinstance(value, list) else []
        if any(b < a for a, b in pairwise(times)):
            yield (), told("must ascend", value)

    def argument(self, value: Any) -> list[float]:
        return [float(time) for time in (value if isinstance(value, list) else _spread(value))]


@dataclass(frozen=True, kw_only=True)
class Between(Settings):
    """From where to where a parameter is followed."""

    start: float = setting(Number())
    stop: float = setting(Number())

    @classmethod
    def together(cls, table: Mapping[str, Any], known: Known) -> Faults:
        if table["start"] == table["stop"]:
            yield (), "start and stop are equal; a branch needs a range between them"


_LIST = ListOf(Number(), distinct=True, most=LONGEST)


def _may_be_limits(value: Any) -> bool:
    """Whether a tuple reads as start and stop, or as these and a count, as well as it reads as values."""
    return isinstance(value, tuple) and (len(value) == 2 or (len(value) == 3 and real(value[2]) % 1 == 0))


def _values(value: Any) -> Faults:
    """Faults of a list of numbers, or of a `Range`."""
    if isinstance(value, Mapping):
        yield from Range.faults(value)
    elif isinstance(value, list):
        yield from _LIST.faults(value)
    elif _may_be_limits(value):
        ends = f"'start': {value[0]!r:.40}, 'stop': {value[1]!r:.40}, 'num': {value[2] if len(value) > 2 else 100}"
        words = f"may be read as values or as limits; for values write {list(value)!r:.120}, for a range {{{ends}}}"
        yield (), told(words, value)
    else:
        yield (), told(too_long(value) or "expected a list of numbers, or a table with start, stop and num", value)


def _spread(values: Mapping[str, Any]) -> Any:
    """The values of a sound `Range`."""
    import numpy as np

    return np.linspace(values["start"], values["stop"], values["num"])


@dataclass(frozen=True)
class Axes(Value):
    """Swept parameters, or states that span a grid, each with its values."""

    of: str  # {"parameter", "state"}
    least: int
    most: int  # how many there may be, from `least` on
    rule: str  # what is said of another number of them
    example: ClassVar[str] = "numpy.linspace(0, 1, 101)"

    @property
    def type_name(self) -> str:
        few = ("one", "two", "three", "four", "five", "six")
        least, most = few[self.least - 1], few[self.most - 1]
        count = least if least == most else f"{least} {'or' if self.most == self.least + 1 else 'to'} {most}"
        return f"mapping of {count} {self.of}{'s' * (self.most > 1)} to {self._values_name}"

    _values_name: ClassVar[str] = "values"

    def plain(self, value: Any) -> Any:
        return {key_text(key): self._plain(one) for key, one in value.items()} if isinstance(value, Mapping) else value

    def _plain(self, values: Any) -> Any:
        return values if _may_be_limits(values) else _LIST.plain(values)

    def faults(self, value: Any) -> Faults:
        if not isinstance(value, Mapping):
            example = f"{{'name of the {self.of}': {self.example}}}"
            yield (), told(f"expected a table of values by name, as in {example}: {self.rule}", value)
            return
        if not self.least <= len(value) <= self.most:
            yield (), f"names {sorted(value)}; {self.rule}"
        for name, values in value.items():
            yield from within((name,), self._faults(values))

    def _faults(self, values: Any) -> Faults:
        return _values(values)

    def misfits(self, value: Any, known: Known) -> Faults:
        names = known.known if self.of == "parameter" else known.states
        if not isinstance(value, Mapping) or names is None:
            return
        for name, values in value.items():
            if name not in names:
                unused = known.unused(str(name)) if self.of == "parameter" else ""
                yield (name,), unused or f"unknown {self.of}; {remedy(name, names)}"
                continue
            if name and (reason := unfit(name)):
                cannot = "be swept" if self.of == "parameter" else "span a grid"
                yield (name,), f"{reason}, and cannot {cannot}; rename the {self.of}"
            ends = [values.get("start"), values.get("stop")] if isinstance(values, Mapping) else values
            refused = (known.refuses(name, one) for one in ends) if isinstance(ends, list) else ()
            if self.of == "parameter" and (fault := next(filter(None, refused), None)):
                yield (name,), fault

    def argument(self, value: Any) -> dict[str, Any]:
        import numpy as np

        return {
            name: np.array(values, dtype=float) if isinstance(values, list) else _spread(values)
            for name, values in value.items()
        }


LIMITS = ListOf(Number(), least=2, most=2)


class Ranges(Axes):
    """One parameter or two, each with the limits within which it is followed from the system's own value."""

    example = "(0, 1)"
    _values_name = "limits"

    def read(self, name: str, value: Any, system: Any) -> dict[str, Any]:
        return {key: sorted(limits) for key, limits in super().read(name, value, system).items()}

    def _plain(self, values: Any) -> Any:
        ends = LIMITS.plain(values)
        return dict(zip(("start", "stop"), ends, strict=True)) if isinstance(ends, list) and len(ends) == 2 else values

    def _faults(self, values: Any) -> Faults:
        if isinstance(values, Mapping):
            yield from Between.faults(values)
        else:
            words = "expected two limits, start and stop, between which a branch finds its own points"
            yield (), told(words, values)

    def misfits(self, value: Any, known: Known) -> Faults:
        yield from super().misfits(value, known)
        usual = known.known
        for name, limits in value.items() if isinstance(value, Mapping) and usual is not None else ():
            ends = limits if isinstance(limits, Mapping) else {}
            own = real(known.parameters.get(name, usual.get(name) if usual else None))
            start, stop = real(ends.get("start")), real(ends.get("stop"))
            if isfinite(own + start + stop) and start != stop and not min(start, stop) <= own <= max(start, stop):
                at = f"{name} = {own:g}, which is not between start and stop"
                yield (name,), f"the branch starts at the value of the system, {at}"

    def argument(self, value: Any) -> dict[str, Any]:
        return {name: (float(ends["start"]), float(ends["stop"])) for name, ends in value.items()}
