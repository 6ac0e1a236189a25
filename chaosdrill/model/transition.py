"""What happens when a guard reaches zero."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import sympy

from chaosdrill.errors import ModelError


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
    kind: str | None = None

    def __post_init__(self) -> None:
        if self.direction not in (-1, 0, 1):
            raise ModelError(f"transition {self.name!r}: direction is {self.direction!r}; it must be +1, -1 or 0")
        sources = (self.source,) if isinstance(self.source, str) else tuple(self.source)
        object.__setattr__(self, "source", sources)
        object.__setattr__(self, "guard", sympy.sympify(self.guard))
        object.__setattr__(self, "kind", self.kind or self.name)

    def marks_only(self) -> bool:
        """Whether the transition changes neither mode nor state: it marks a section."""
        return not self.reset and self.source == (self.target,)

    def rewritten(self, rewrite: Any) -> "Transition":
        """The same transition with ``rewrite`` applied to every expression."""
        return replace(
            self,
            guard=rewrite(self.guard),
            reset={rewrite(sympy.sympify(key)): rewrite(value) for key, value in self.reset.items()},
            condition=None if self.condition is None else rewrite(self.condition),
        )
