"""The outline of a system: all of it but expressions, as plain data.

A system that was derived before, in another process, is known by its outline. Its expressions come with the whole
system, which is built when somebody asks for them.
"""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from chaosdrill.model.tables import Entries
from chaosdrill.model.transition import Transition
from chaosdrill.model.values import EXPRESSIONS, System, deriving

_TABLES = ("modes", "regions", "quadratures")
_PLAIN = ("name", "description", "labels", "noise", "parameters", "initial", "names_mode")


class WholeSystem:
    """Builds a system on first use, once."""

    def __init__(self, make: Callable[[], System]) -> None:
        self._make = make
        self._made: System | None = None

    def __call__(self) -> System:
        with deriving:
            if self._made is None:
                self._made = self._make()
            return self._made

    def __reduce__(self) -> tuple[Any, ...]:
        return WholeSystem, (self._make,)

    def part(self, attribute: str) -> Any:
        """An attribute of the system."""
        return getattr(self(), attribute)

    def transition(self, number: int) -> Transition:
        """One of its transitions."""
        return self().transitions[number]


def outline(system: System) -> dict[str, Any]:
    """All of a system but its expressions."""
    return {
        **{name: getattr(system, name) for name in _PLAIN},
        **{name: list(getattr(system, name)) for name in _TABLES},
        **{name: getattr(system, name) is not None for name in EXPRESSIONS},
        "states": list(system.state_names),
        "bounds": {name: list(pair) for name, pair in system.bounds.items()},
        "transitions": [t.outline() for t in system.transitions],
        "exponent_parameters": list(system.exponent_parameters),
    }


def attributes(plain: Mapping[str, Any], whole: WholeSystem) -> dict[str, Any]:
    """The attributes of the system of an outline, its limits apart; without expressions that are not None."""
    return {
        **{name: plain[name] for name in _PLAIN},
        **{name: Entries(plain[name], partial(whole.part, name)) for name in _TABLES},
        **{name: None for name in EXPRESSIONS if not plain[name]},
        "outlined_states": tuple(plain["states"]),
        "bounds": {name: tuple(pair) for name, pair in plain["bounds"].items()},
        "transitions": tuple(
            Transition.outlined(one, partial(whole.transition, number))
            for number, one in enumerate(plain["transitions"])
        ),
        "exponent_parameters": tuple(plain["exponent_parameters"]),
    }
