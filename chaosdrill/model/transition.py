"""What happens when a guard reaches zero."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from numbers import Integral
from typing import Any

from chaosdrill.errors import ModelError
from chaosdrill.model.reading import read_condition, read_expression, read_mapping, read_name, read_symbol


@dataclass(frozen=True)
class Transition:
    """One outcome of one event.

    Parameters
    ----------
    name : str
        Name of the transition; archives count and label events by it.
    source : str or tuple of str
        Mode or modes in which the guard is watched.
    target : str
        Mode that holds after the event.
    guard : sympy expression
        The event happens where this expression of states, time and parameters reaches zero.
    direction : {+1, -1, 0}
        Upward crossings, downward crossings, or both.
    reset : mapping of state to expression, optional
        State after the event from the state before it; what is not named stays as it is.
    condition : sympy relation, optional
        Relation between pre-event quantities. Transitions that share source, guard and direction are the outcomes of
        one event: the first declared whose condition holds is taken, and none if none holds.
    priority : int, default 0
        Of guards that reach zero together the one with the larger priority acts first.
    completes : str, optional
        Name of an outcome of the same event that throws the state back, such as the rebound of a ball. Where
        rebounds follow each other ever faster and would all be over within a negligible time, this transition is taken
        instead: its reset puts the state at rest on the guard, its target holds the contact.
    kind : str, optional
        Class under which the event is counted, e.g. ``"impact"``; default: the name.
    """

    name: str
    source: str | tuple[str, ...]
    target: str
    guard: Any
    direction: int
    reset: Mapping[Any, Any] = field(default_factory=dict)
    condition: Any = None
    priority: int = 0
    completes: str | None = None
    kind: str | None = None

    def __post_init__(self) -> None:
        read_name("name of a transition", self.name)
        where = f"transition {self.name!r}"
        if isinstance(self.direction, bool) or self.direction not in (-1, 0, 1):
            raise ModelError(f"{where}: direction is {self.direction!r}; it must be +1, -1 or 0")
        sources = (self.source,) if isinstance(self.source, str) else self.source
        if (
            not isinstance(sources, Collection)
            or isinstance(sources, Mapping)
            or not sources
            or not all(isinstance(mode, str) for mode in sources)
        ):
            raise ModelError(f"{where}: source is {self.source!r}; it must be a mode's name, or several in a tuple")
        if not isinstance(self.target, str):
            raise ModelError(f"{where}: target is {self.target!r}; it must be the name of a mode")
        if isinstance(self.priority, bool) or not isinstance(self.priority, Integral):
            raise ModelError(f"{where}: priority is {self.priority!r}; it must be an integer, larger acts first")
        if self.completes is not None:
            read_name(f"{where}: completes", self.completes)
        if self.kind is not None:
            read_name(f"{where}: kind", self.kind)
        reset = read_mapping(f"{where}: reset", self.reset, "{v: -e * v}")
        object.__setattr__(self, "source", tuple(sources))
        object.__setattr__(self, "guard", read_expression(f"{where}: guard", self.guard))
        read = {
            read_symbol(f"{where}: a state in reset", key): read_expression(f"{where}: reset of {key}", value)
            for key, value in reset.items()
        }
        object.__setattr__(self, "reset", read)
        object.__setattr__(self, "condition", read_condition(f"{where}: condition", self.condition))
        object.__setattr__(self, "kind", self.kind or self.name)

    def content(self) -> tuple[Any, ...]:
        """All that makes this transition, to be compared and looked up by."""
        return (*(self.name, self.source, self.target, self.guard, self.direction, tuple(self.reset.items())),
                *(self.condition, self.priority, self.completes, self.kind))  # fmt: skip

    def marks_only(self) -> bool:
        """Whether the transition changes neither mode nor state: it marks a section."""
        return not self.reset and self.source == (self.target,)
