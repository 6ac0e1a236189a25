"""A definition is read: every fault of it with its place, or all that a `HybridSystem` is made of."""

import sys
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

import sympy

from chaosdrill.errors import ModelError
from chaosdrill.model.grammar import ExpressionError
from chaosdrill.model.reading import NAMES, canonical, is_name
from chaosdrill.model.text import read_text
from chaosdrill.model.transition import Transition
from chaosdrill.names import remedy

Path = tuple[str | int, ...]

MOST_LETTERS = 200_000
"""Of all expressions together."""

MOST_FAULTS = 200
MOST = sys.float_info.max
"""Largest double: whole numbers of any length may be given."""

KEYS = ("name", "description", "states", "time", "period", "modes", "transitions", "quadratures", "bounds", "labels")
OF_TRANSITION = (
    *("name", "source", "target", "guard", "direction"),
    *("reset", "condition", "priority", "completes", "kind"),
)
UNNAMED = "own-system"


@dataclass(frozen=True)
class Fault:
    """What is wrong in a definition, and the keys that lead there."""

    path: Path
    message: str

    def text(self) -> str:
        """Place and message on one line."""
        return f"{'.'.join(map(str, ('definition', *self.path)))}: {self.message}"


@dataclass
class Reading:
    """A definition that was read.

    Parameters
    ----------
    fields : dict
        Arguments of `HybridSystem`, parameters and initial values apart.
    used : set of str
        Names of states, parameters and time that expressions hold.
    """

    fields: dict[str, Any] = field(default_factory=dict)
    used: set[str] = field(default_factory=set)


def read_definition(definition: Any, parameters: Iterable[str]) -> tuple[Reading, list[Fault]]:
    """Read a definition.

    Parameters
    ----------
    definition : object
        What is to be one.
    parameters : iterable of str
        The names that expressions may hold besides states and time.

    Returns
    -------
    Reading
        Complete only without faults.
    faults : list of Fault
        All of them.
    """
    reader = _Reader(parameters)
    with suppress(_TooManyFaults):
        reader.read(definition)
    return reader.reading, reader.faults


class _TooManyFaults(Exception):
    pass


class _Reader:
    def __init__(self, parameters: Iterable[str]) -> None:
        self.parameters = [str(name) for name in parameters]
        self.faults: list[Fault] = []
        self.reading = Reading()
        self.letters = 0
        self.names: dict[str, Any] = {}
        self.moving: set[Any] = set()
        self.hints: dict[str, str] = {}

    def read(self, definition: Any) -> None:
        given = self._table((), definition)
        self._known((), given, KEYS)
        states = self._states(given.get("states"))
        if states is None:
            # all that names a state would be a fault of its own
            return
        time = self._text(("time",), given["time"]) if "time" in given else None
        fields: dict[str, Any] = {
            "name": self._text(("name",), given.get("name", UNNAMED)) or UNNAMED,
            "description": self._text(("description",), given.get("description", ""), empty=True) or "",
            "labels": self._labels(given.get("labels", {})),
        }
        named = [*states, *([time] if time else [])]
        for name in (name for name in dict.fromkeys(self.parameters) if name in named):
            self._fault(("states",) if name in states else ("time",), f"{name!r:.60} is the name of a parameter too")
        if time and time in states:
            self._fault(("time",), f"{time!r:.60} is the name of a state too")
        self.names = {name: sympy.Symbol(name, real=True) for name in (*self.parameters, *named)}
        self.moving = {self.names[name] for name in named}
        fields["states"] = tuple(self.names[name] for name in states)
        fields["time"] = self.names[time] if time else None
        if "time" not in given:
            self.hints = {name: f"if it is the time, declare it: time = {name!r}" for name in ("t", "time")}
        fields["period"] = self._period(given["period"]) if "period" in given else None
        fields["modes"] = self._modes(given.get("modes"), states)
        fields["transitions"] = self._transitions(given.get("transitions", []), states, list(fields["modes"]))
        fields["quadratures"] = {
            name: self._expression(("quadratures", name), value, moving=True)
            for name, value in self._table(("quadratures",), given.get("quadratures", {})).items()
        }
        fields["bounds"] = self._bounds(given.get("bounds", {}), states)
        self.reading.fields = fields

    def _fault(self, path: Path, message: str) -> None:
        self.faults.append(Fault(path, message))
        if len(self.faults) >= MOST_FAULTS:
            raise _TooManyFaults

    def _known(self, path: Path, given: Mapping[str, Any], keys: tuple[str, ...]) -> None:
        for key in given:
            if key not in keys:
                self._fault((*path, key), f"unknown key; {remedy(key, keys)}")

    def _table(self, path: Path, value: Any) -> dict[str, Any]:
        if isinstance(value, Mapping) and all(isinstance(key, str) for key in value):
            return dict(value)
        self._fault(path, f"expected a table, received {value!r:.60}")
        return {}

    def _text(self, path: Path, value: Any, *, empty: bool = False) -> str | None:
        if isinstance(value, str) and (empty or value.strip()):
            return value
        self._fault(path, f"expected text in quotes, received {value!r:.60}")
        return None

    def _whole(self, path: Path, value: Any) -> int:
        if isinstance(value, int) and not isinstance(value, bool) and abs(value) < 2**63:
            return value
        self._fault(path, f"expected a whole number, received {value!r:.60}")
        return 0

    def _states(self, value: Any) -> list[str] | None:
        """Names of the states; None if what is given is no list of names."""
        if not isinstance(value, list) or not value:
            given = "missing" if value is None else f"received {value!r:.60}"
            self._fault(("states",), f"{given}; expected a list of names, as in ['x', 'v']")
            return None
        if None in [self._text(("states", place), name) for place, name in enumerate(value)]:
            return None
        if wrong := [place for place, name in enumerate(value) if not is_name(name)]:
            self._fault(("states", wrong[0]), f"received {value[wrong[0]]!r:.60}; {NAMES}")
            return None
        states: list[str] = []
        for place, name in enumerate(value):
            if name in states:
                self._fault(("states", place), f"{name!r:.60} is named twice")
            else:
                states.append(name)
        return states

    def _labels(self, value: Any) -> dict[str, str]:
        given = self._table(("labels",), value)
        return {name: self._text(("labels", name), label, empty=True) or "" for name, label in given.items()}

    def _period(self, value: Any) -> Any:
        found = self._expression(("period",), value)
        named = [] if found is None else sorted(s.name for s in found.free_symbols & self.moving)
        if named:
            self._fault(("period",), f"names {named[0]!r:.60}; it is to be a number made of parameters")
        return found

    def _modes(self, value: Any, states: list[str]) -> dict[str, dict[Any, Any]]:
        given = self._table(("modes",), {} if value is None else value)
        if not given:
            self._fault(("modes",), "missing; give the rate of every state in at least one, as in [...modes.free]")
        read = {}
        for mode, rates in given.items():
            path = ("modes", mode)
            rates = self._table(path, rates)
            for state in states:
                if state not in rates:
                    self._fault(path, f"gives no rate for {state!r:.60}; write 0 if the mode holds it")
            read[mode] = self._assignments(path, rates, states, moving=True)
        return read

    def _assignments(self, path: Path, table: Mapping[str, Any], states: list[str], *, moving: bool) -> dict[Any, Any]:
        """Expressions by the state that each belongs to."""
        read = {}
        for state, value in table.items():
            if state in states:
                read[self.names[state]] = self._expression((*path, state), value, moving=moving)
            else:
                self._fault((*path, state), f"unknown state; {remedy(state, states)}")
        return read

    def _transitions(self, value: Any, states: list[str], modes: list[str]) -> tuple[Transition, ...]:
        if not isinstance(value, list):
            self._fault(("transitions",), f"expected a list of tables, received {value!r:.60}")
            return ()
        names = [entry.get("name") for entry in value if isinstance(entry, Mapping)]
        found = [self._transition(("transitions", i), entry, states, modes, names) for i, entry in enumerate(value)]
        return tuple(transition for transition in found if transition is not None)

    def _transition(
        self, path: Path, value: Any, states: list[str], modes: list[str], names: list[Any]
    ) -> Transition | None:
        before = len(self.faults)
        given = self._table(path, value)
        self._known(path, given, OF_TRANSITION)
        for key in OF_TRANSITION[:5]:
            if key not in given and given:
                self._fault((*path, key), "missing")
        texts = {
            key: self._text((*path, key), given[key]) for key in ("name", "target", "completes", "kind") if key in given
        }
        if texts.get("name") and names.count(texts["name"]) > 1:
            self._fault((*path, "name"), f"two transitions are named {texts['name']!r:.60}")
        if texts.get("completes") and texts["completes"] not in names:
            known = [name for name in names if isinstance(name, str)]
            self._fault((*path, "completes"), f"unknown transition; {remedy(str(texts['completes']), known)}")
        sources = given.get("source", [])
        sources = sources if isinstance(sources, list) else [sources]
        if "source" in given and not sources:
            self._fault((*path, "source"), "is empty; name the mode, or modes, in which the guard is watched")
        for key, mode in [("source", mode) for mode in sources] + [("target", texts.get("target"))]:
            if key == "source" and self._text((*path, key), mode) is None:
                continue
            if mode is not None and modes and mode not in modes:
                self._fault((*path, key), f"unknown mode {mode!r:.60}; {remedy(mode, modes)}")
        direction = self._whole((*path, "direction"), given["direction"]) if "direction" in given else 0
        if direction not in (-1, 0, 1):
            self._fault((*path, "direction"), f"must be 1 (rises), -1 (falls) or 0 (either), received {direction}")
        guard = self._expression((*path, "guard"), given["guard"], moving=True) if "guard" in given else None
        if guard is not None and not guard.free_symbols & self.moving:
            self._fault((*path, "guard"), "depends on no state and not on time")
        resets = self._table((*path, "reset"), given.get("reset", {}))
        reset = self._assignments((*path, "reset"), resets, states, moving=False)
        condition = None
        if "condition" in given:
            condition = self._expression((*path, "condition"), given["condition"], condition=True)
        priority = self._whole((*path, "priority"), given.get("priority", 0))
        if not given or len(self.faults) > before:
            return None
        try:
            return Transition(
                **texts,  # type: ignore[arg-type]
                source=tuple(sources),
                guard=guard,
                direction=direction,
                reset=reset,
                condition=condition,
                priority=priority,
            )
        except ModelError as fault:
            self._fault(path, str(fault))
            return None

    def _bounds(self, value: Any, states: list[str]) -> dict[str, tuple[float, float]]:
        read = {}
        for state, pair in self._table(("bounds",), value).items():
            ends = pair if isinstance(pair, list) and len(pair) == 2 else [None, None]
            low, high = (_end(end) for end in ends)
            if state not in states:
                self._fault(("bounds", state), f"unknown state; {remedy(state, states)}")
            elif not low < high:
                self._fault(
                    ("bounds", state), f"expected [low, high], doubles or inf, with low < high, received {pair!r:.60}"
                )
            else:
                read[state] = (low, high)
        return read

    def _expression(self, path: Path, value: Any, *, condition: bool = False, moving: bool = False) -> Any:
        """A text, or a number, as an expression; None with a fault."""
        if isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= MOST and not condition:
            value = repr(value)
        if not isinstance(value, str):
            self._fault(path, f"expected an expression in quotes, received {value!r:.60}")
            return None
        self.letters += len(value)
        if self.letters > MOST_LETTERS:
            self._fault(path, f"the definition has more than {MOST_LETTERS} letters of expressions")
            raise _TooManyFaults
        try:
            moved = self.moving if moving else None
            found = read_text(value, self.names, condition=condition, moving=moved, hints=self.hints)
            found = canonical(found)
        except ExpressionError as fault:
            self._fault(path, str(fault))
            return None
        self.reading.used |= {s.name for s in found.free_symbols}
        return found


def _end(value: Any) -> float:
    """One bound; NaN if it is none."""
    if value in ("inf", "-inf"):
        return float(value)
    if isinstance(value, bool) or not isinstance(value, int | float):
        return float("nan")
    return float(value) if isinstance(value, float) or abs(value) <= MOST else float("nan")
