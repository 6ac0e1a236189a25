"""A system as it was given is read: every fault of it with its place, or all that a `HybridSystem` is made of.

It may come from Python, from the table of a scene, or from an archive. The rules are the same, and stand here, in
`chaosdrill.model.parts`, `chaosdrill.model.rules`, `chaosdrill.model.completion` and `chaosdrill.model.period`.
"""

import math
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from numbers import Rational
from typing import Any
from unicodedata import normalize

import sympy

from chaosdrill.model.completion import wrong_completion
from chaosdrill.model.crossings import hidden
from chaosdrill.model.parts import NAMES, TIME, PartReader, TooManyFaults, is_name
from chaosdrill.model.period import wrong_period
from chaosdrill.model.python import is_python
from chaosdrill.model.special import FLOW
from chaosdrill.model.tables import DEFAULT_BOUNDS, OF_NOISE, UNNAMED, finite
from chaosdrill.model.transition import CORNER, Transition
from chaosdrill.model.values import Definition
from chaosdrill.names import brief, names_in, remedy, shown
from chaosdrill.settings import KeyPath, real

MOST_CODES = 127

KEYS = (
    *("name", "description", "states", "time", "period", "modes", "transitions", "regions", "quadratures", "bounds"),
    *("labels", "noise"),
)
OPTIONAL = ("time", "period", "regions", "quadratures", "bounds", "labels", "noise")
"""Keys that may be None, which means left out."""


class Reader(PartReader):
    """Reads a definition."""

    def read(self, definition: Any) -> Definition | None:
        """The fields of a definition; None if it has faults."""
        with suppress(TooManyFaults):
            given = self._table((), definition)
            self._known((), given, KEYS)
            given = {key: value for key, value in given.items() if value is not None or key not in OPTIONAL}
            self.states = self._states(given.get("states"))
            # without them all that names a state, or a parameter, would be a fault of its own
            found = None if self.states is None or self._faulty("parameters") else self._fields(given)
            if found is not None and not self.faults:
                self._check_whole(found)
                return None if self.faults else found
        return None

    def _fields(self, given: Mapping[str, Any]) -> Definition:
        states = self.states or ()
        time = self._name(("time",), given["time"]) if "time" in given else None
        name = self._text(("name",), given.get("name", UNNAMED)) or UNNAMED
        description = self._text(("description",), given.get("description", ""), empty=True) or ""
        for one in self.parameters:
            if not is_name(one):
                self._fault(("parameters", one), f"received {shown(one):.60}; {NAMES}")
            elif one in states or one == time:
                place = ("states",) if one in states else ("time",)
                self._fault(place, f"{one!r:.60} is the name of a parameter too")
        if time is not None and time in states:
            self._fault(("time",), f"{time!r:.60} is the name of a state too")
        named = [*self.parameters, *states, *([] if time is None else [time])]
        plain: dict[str, str] = {}
        for one in dict.fromkeys(named):
            other = plain.setdefault(normalize("NFKC", one), one)
            if other != one:
                where: KeyPath = ("states",) if one in states else ("time",) if one == time else ("parameters", one)
                self._fault(where, f"{one!r:.60} and {other!r:.60} are one name in Python; rename one of them")
        self._hints = {one: f"if it is the time, declare it: time = {one!r}" for one in ("t", "time")}
        if time is not None:
            self._hints = dict.fromkeys(self._hints, f"the time is called {time!r:.60}")
        elif TIME not in named:
            named.append(TIME)
            self._hints = {"time": f"the time is called {TIME!r}; for another name declare it: time = 'time'"}
        self._lacking = dict.fromkeys(one for one in _rated(given.get("modes")) if one not in named)
        self._names = {one: sympy.Symbol(one, real=True) for one in named}
        self._moving = {self._names[one] for one in named if one not in self.parameters}
        self._clock = self._names.get(TIME if time is None else time)
        if time is None and TIME in (*self.parameters, *states):
            self._clock = None
        period = self._period(given["period"]) if "period" in given else None
        modes = self._read_modes(given.get("modes"))
        transitions = self._read_transitions(given.get("transitions", ()))
        regions = self._regions(given.get("regions", {}))
        quadratures = self._quadratures(given.get("quadratures", {}))
        if time is None and TIME in self.used and TIME not in (*self.parameters, *states):
            time = TIME
        for one in quadratures:
            kinds = (("state", states), ("parameter", self.parameters), ("time", (time,)))
            if taken := [kind for kind, names in kinds if one in names]:
                article = "the" if taken[0] == "time" else "a"
                self._fault(("quadratures", one), f"{one!r:.60} is the name of {article} {taken[0]} too")
        labelled = [*states, *self.parameters, *quadratures, *([] if time is None else [time])]
        return Definition(
            name=name,
            description=description,
            labels=self._labels(given.get("labels", {}), labelled),
            states=tuple(self._names[one] for one in states),
            time=None if time is None else self._names[time],
            period=period,
            modes=modes,
            transitions=transitions,
            regions=regions,
            quadratures=quadratures,
            bounds=self._bounds(given.get("bounds", {})),
            noise=self._noise(given.get("noise", {})),
        )

    def states_of(self, value: Any) -> tuple[str, ...] | None:
        """Names of states that stand alone; None if what is given are no names."""
        return self._states(value)

    def _states(self, value: Any) -> tuple[str, ...] | None:
        """Names of the states; None if what is given are no names."""
        listed = names_in(value)
        ordered = isinstance(listed, Iterable) and not isinstance(listed, Mapping | set | frozenset | bytes)
        names = [self._name(("states", place), one) for place, one in enumerate(listed)] if ordered else []
        if not names:
            given = "missing" if value is None else f"received {shown(value):.60}"
            self._fault(("states",), f"{given}; expected names in order, as in 'x v' or ['x', 'v']")
        if not names or None in names:
            return None
        read: dict[str, None] = {}
        for place, name in enumerate(filter(None, names)):
            if name in read:
                self._fault(("states", place), f"{name!r:.60} is named twice")
            elif name == "mode":
                self._fault(("states", place), "'mode' is reserved for the initial mode; rename the state")
            read[name] = None
        return tuple(read)

    def _labels(self, value: Any, labelled: list[str]) -> dict[str, str]:
        read = {}
        for name, label in self._table(("labels",), value).items():
            if name not in labelled:
                what = "names no state, parameter, quadrature or time"
                self._fault(("labels", name), f"{what}; {remedy(name, labelled)}")
            read[name] = self._text(("labels", name), label, empty=True) or ""
            if "$" in read[name] and (made := set(read[name]) & set("\a\b\f\r\t\v")):
                told = f"{min(made)!r} in a formula is one letter; write the text raw, as in r'$\\theta$'"
                self._fault(("labels", name), told)
        return read

    def _period(self, value: Any) -> Any:
        found = self._expression(("period",), value)
        named = [] if found is None else sorted(s.name for s in found.free_symbols & self._moving)
        if named:
            self._fault(("period",), f"names {named[0]!r:.60}; it must be a number made of parameters")
        return found

    def _read_modes(self, value: Any) -> dict[str, dict[Any, Any]]:
        given = self._table(("modes",), {} if value is None else value)
        plain = not any(isinstance(one, Mapping) or is_python(one) for one in given.values())
        if plain and set(given) & set(self.states or ()):
            name = next(iter(given))
            example = f"{{'free': {{{name!r}: {brief(given[name], 30)}, ...}}}}"
            self._fault(("modes",), f"has the rates of one mode alone; give the mode a name, as in {example}")
            return {}
        self._modes = tuple(given)
        if not given and not self._faulty("modes"):
            self._fault(("modes",), "missing; give the rate of every state in at least one, as in modes.free")
        self._count("modes", len(given))
        read = {}
        for mode, rates in given.items():
            path = ("modes", mode)
            self._text(path, mode)
            if is_python(rates):
                read[mode] = self._all_states(path, rates)
                continue
            rates = self._table(path, rates)
            for state in self._left_out(rates):
                self._fault(path, f"gives no rate for {state!r:.60}; write 0 if the mode holds it")
            read[mode] = self._assignments(path, rates, FLOW)
        return read

    def _faulty(self, key: str) -> bool:
        return any(path[:1] == (key,) for path, _ in self.faults)

    def _count(self, what: str, count: int) -> None:
        if count > MOST_CODES:
            fit = f"at most {MOST_CODES} fit, since archives hold their codes in one byte"
            self._fault((what,), f"there are {count} {what}; {fit}")

    def _quadratures(self, value: Any) -> dict[str, dict[str, Any]]:
        """The integrand of every quadrature in every mode."""
        read = {}
        for name, given in self._table(("quadratures",), value).items():
            path = ("quadratures", name)
            if not is_name(name):
                self._fault(path, f"received {shown(name):.60}; {NAMES}")
            if isinstance(given, Mapping):
                lacks = "write 0 if nothing is added in it"
                read[name] = self._by_mode(path, given, self._modes, lacks, self._integrand)
            else:
                read[name] = dict.fromkeys(self._modes, self._integrand(path, given))
        return read

    def _regions(self, value: Any) -> dict[str, Any]:
        """Where a start that names no mode is in a mode."""
        read = {}
        for mode, given in self._table(("regions",), value).items():
            path = ("regions", mode)
            self._mode(path, mode)
            read[mode] = found = self._relation(path, given)
            if found is not None and self._clock in found.free_symbols:
                self._fault(path, f"names the time {self._clock.name!r:.60}; a run starts at time 0")
        return read

    def _noise(self, value: Any) -> dict[str, dict[str, Any]]:
        """How parameters are drawn: what each was called, its distribution, and the events."""
        read, states = {}, [f"{name}_{one}" for name in self._table(("noise",), value) for one in OF_NOISE]
        if states and tuple(states) != (self.states or ())[-len(states) :]:
            self._fault(("noise",), f"the last states must be {', '.join(states)}")
        for name, given in self._table(("noise",), value).items():
            path = ("noise", name)
            entry = self._table(path, given)
            self._known(path, entry, ("distribution", "at"))
            events = entry.get("at")
            if not isinstance(events, list | tuple):
                self._fault((*path, "at"), f"expected names of events, received {shown(events):.60}")
                events = ()
            read[name] = {
                "distribution": self._text((*path, "distribution"), entry.get("distribution")) or "",
                "at": [self._text((*path, "at"), event) or "" for event in events],
            }
        return read

    def _integrand(self, path: KeyPath, value: Any) -> Any:
        return self._expression(path, value, FLOW)

    def _read_transitions(self, value: Any) -> tuple[Transition, ...]:
        if not isinstance(value, Iterable) or isinstance(value, str | bytes | Mapping | set | frozenset):
            self._fault(("transitions",), f"expected a list of transitions, [] for none, received {shown(value):.60}")
            return ()
        listed = list(value)
        self._transitions = [_name_of(entry) for entry in listed]
        self._driven = any(_name_of(entry, "kind") == CORNER for entry in listed)
        self._count("transitions", len(listed))
        read = []
        for place, entry in enumerate(listed):
            before, path = len(self.faults), ("transitions", place)
            fields = self.transition(path, entry.given if isinstance(entry, Transition) else entry)
            # an expression without a fault of its own may hold one of the names that are said to be missing elsewhere
            if len(self.faults) == before and not self._lacking:
                read.append(Transition(**fields))
        return tuple(read)

    def _bounds(self, value: Any) -> dict[str, tuple[float, float]]:
        states = self.states or ()
        read = dict.fromkeys(states, DEFAULT_BOUNDS)
        for state, given in self._table(("bounds",), value).items():
            pair = (-float("inf"), float("inf")) if given is None else given
            low, high = map(_end, pair) if isinstance(pair, list | tuple) and len(pair) == 2 else (float("nan"),) * 2
            if state not in states:
                self._stranger(("bounds", state), state)
            elif not low < high:
                told = f"expected [low, high], doubles or inf, with low < high, received {shown(given):.60}"
                self._fault(("bounds", state), told)
            read[state] = (low, high)
        return read

    def _check_whole(self, found: Definition) -> None:
        """Check what concerns the definition as a whole."""
        for place, transition in enumerate(found.transitions):
            if transition.completes is not None and (told := wrong_completion(found, self.parameters, transition)):
                self._fault(("transitions", place, "completes"), told)
        for place, before in hidden(found.transitions):
            told = (
                f"{found.transitions[place].name!r} is never taken, since {before!r} is another outcome of the same "
                f"event, stands before it and has no condition; give {before!r} a condition, or put it last"
            )
            self._fault(("transitions", place), told)
        numbers = {name: finite(value) for name, value in self.parameters.items()}
        if None not in numbers.values() and (told := wrong_period(found, numbers)):
            self._fault(("period",), told)


def _rated(modes: Any) -> Iterator[str]:
    """Names to which the modes give rates, where they are names."""
    for rates in modes.values() if isinstance(modes, Mapping) else ():
        if isinstance(rates, Mapping):
            keys = (getattr(key, "name", key) for key in rates)
            yield from (one for one in keys if isinstance(one, str) and is_name(one))


def _name_of(entry: Any, key: str = "name") -> str | None:
    given = entry.given if isinstance(entry, Transition) else entry
    name = given.get(key) if isinstance(given, Mapping) else None
    return name if isinstance(name, str) else None


def _end(value: Any) -> float:
    """One bound as a number; NaN if it is not a number, or a finite one larger than any double."""
    end = float(value) if isinstance(value, str) and value in ("inf", "-inf") else real(value)
    return math.nan if math.isinf(end) and isinstance(value, Rational) else end
