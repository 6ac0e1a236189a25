"""Reads the definition of a map: its images become the outcomes of one event, a branch each."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, fields
from itertools import count
from typing import Any

import sympy

from chaosdrill.model.python import Called, is_python
from chaosdrill.model.reading import Reader
from chaosdrill.model.rules import refused
from chaosdrill.model.special import CONDITION, RESET
from chaosdrill.model.tables import UNNAMED_MAP
from chaosdrill.model.text import INSTEAD
from chaosdrill.model.transition import Transition
from chaosdrill.model.values import Definition
from chaosdrill.names import shown
from chaosdrill.settings import KeyPath

KEYS = ("name", "description", "states", "images", "bounds", "labels", "noise")
"""Keys of a map in a scene."""

MODE, EVENT = "map", "iterate"
_CLOCK = "the map's clock"
"""Symbol in the place of time, which no expression can hold, since maps have no time."""

_NO_TIME = "a map has no time; let a state count iterates, as in n = 'n + 1'"


@dataclass(eq=False, repr=False)
class MapDefinition(Definition):
    """A definition of a map that was read without faults."""

    images: dict[Any, Any]


class MapReader(Reader):
    """Reads the definition of a map, as `Reader` that of any system."""

    images: dict[Any, Any]

    def read(self, definition: Any) -> MapDefinition | None:
        """The fields of a definition; None if it has faults."""
        given = self._table((), definition)
        self._known((), given, KEYS)
        states = Reader().states_of(given.get("states")) or ()
        clock = next(name for name in _names(_CLOCK) if name not in (*states, *self.parameters))
        found = super().read(
            {
                **{key: value for key, value in given.items() if key in KEYS and key != "images"},
                "name": given.get("name", UNNAMED_MAP),
                "time": clock,
                "period": 1,
                "modes": {MODE: dict.fromkeys(states, 0)},
                "transitions": given.get("images"),
            }
        )
        if found is None:
            return None
        return MapDefinition(**{one.name: getattr(found, one.name) for one in fields(found)}, images=self.images)

    def _fault(self, path: KeyPath, message: str) -> None:
        # of what a map is made of, users see the images alone
        if path[:1] in (("modes",), ("time",), ("period",)):
            return
        if message.startswith("reads the time"):
            message = f"reads the time; {_NO_TIME}"
        message = message.replace(INSTEAD["Heaviside"], "write Piecewise(1, x >= 0, 0)")
        super()._fault(("images",) if path[:1] == ("transitions",) else path, message)

    def _labels(self, value: Any, labelled: list[str]) -> dict[str, str]:
        return super()._labels(value, [name for name in labelled if name != self._clock.name])

    def _read_transitions(self, value: Any) -> tuple[Transition, ...]:
        clock, hints = self._clock, self._hints
        self._clock, self._hints = None, dict.fromkeys(hints, _NO_TIME)
        del self._names[clock.name]
        before = len(self.faults)
        self.images = self._images(value)
        self._names[clock.name], self._clock = clock, clock
        if len(self.faults) > before:
            return ()
        read = self._outcomes(clock)
        self._transitions = [one.name for one in read]
        return read

    def _images(self, value: Any) -> dict[Any, Any]:
        """The image of every state."""
        path, states = ("images",), self.states or ()
        if is_python(value):
            return self._all_states(path, value)
        listed = value
        if isinstance(value, Iterable) and not isinstance(value, Mapping | set | frozenset | str | bytes):
            entries = list(value)
            if len(entries) != len(states):
                told = f"there are {len(entries)}; give one for each of the {len(states)} states, in order, or a table"
                self._fault(path, told)
                return {}
            listed = dict(zip(states, entries, strict=True))
        if not isinstance(listed, Mapping):
            given = "missing" if value is None else f"received {shown(value):.60}"
            self._fault(path, f"{given}; expected the next value of every state, as in {{{states[0]!r}: ...}}")
            return {}
        table = self._table(path, listed)
        for state in self._left_out(table):
            self._fault(path, f"gives no image of {state!r:.60}; write {state} = {state!r:.60} if it stays as it is")
        read = self._assignments(path, table, CONDITION)
        return {x: read[x] for x in (sympy.Symbol(state, real=True) for state in states) if x in read}

    def _outcomes(self, clock: Any) -> tuple[Transition, ...]:
        """The event that puts the images in the place of the states, one outcome for every branch of them."""
        found = list(_branches(sympy.true, self.images))
        self._count("branches", len(found))
        read = []
        for number, (condition, images) in enumerate(found, 1):
            for state, image in images.items():
                if told := refused(image, self._moving, RESET):
                    self._fault(("images", state.name), told)
            read.append(
                Transition(
                    name=EVENT if len(found) == 1 else f"branch {number}",
                    source=MODE,
                    target=MODE,
                    guard=-sympy.cos(2 * sympy.pi * clock),
                    direction=1,
                    reset=images,
                    condition=None if condition == sympy.true else condition,
                    kind=EVENT,
                )
            )
        return tuple(read)


def _names(first: str) -> Iterator[str]:
    return (f"{first}{number or ''}" for number in count())


def _branches(condition: Any, images: Mapping[Any, Any]) -> Iterator[tuple[Any, dict[Any, Any]]]:
    """Conditions and images without functions that have no derivative; the first condition that holds counts."""
    part = next((one for image in images.values() for one in sympy.postorder_traversal(image) if _pieces(one)), None)
    if part is None:
        yield condition, dict(images)
        return
    for value, holds in _pieces(part):
        both = sympy.And(condition, holds)
        if both != sympy.false:
            yield from _branches(both, {state: image.xreplace({part: value}) for state, image in images.items()})


def _pieces(part: Any) -> tuple[tuple[Any, Any], ...]:
    """The values of a function without a derivative, each with where it holds; none of any other function."""
    if isinstance(part, sympy.Piecewise):
        return tuple((piece.expr, piece.cond) for piece in part.args)
    if isinstance(part, sympy.ceiling):
        return ((-sympy.floor(-part.args[0], evaluate=False), sympy.true),)
    if isinstance(part, Called) or not part.free_symbols:
        return ()
    if isinstance(part, sympy.sign):
        (one,) = part.args
        return (sympy.Integer(1), one > 0), (sympy.Integer(-1), one < 0), (sympy.Integer(0), sympy.true)
    if isinstance(part, sympy.Abs):
        (one,) = part.args
        return (one, one >= 0), (-one, sympy.true)
    if isinstance(part, sympy.Max | sympy.Min):
        first, rest = part.args[0], part.func(*part.args[1:])
        return (first, first >= rest if isinstance(part, sympy.Max) else first <= rest), (rest, sympy.true)
    return ()
