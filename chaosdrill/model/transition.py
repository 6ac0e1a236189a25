"""One outcome of one event, as its user writes it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, Any

from chaosdrill.errors import ModelError
from chaosdrill.model.tables import read_only
from chaosdrill.typed import constructor

_PLAIN = ("name", "source", "target", "direction", "priority", "completes", "kind")
EXPRESSIONS = ("guard", "reset", "condition", "given")
"""Attributes that an outline of a transition leaves out."""

_MAY_BE_NONE = ("condition", "completes", "kind")

CORNER = "corner"
"""Kind of the events between two pieces of a drive."""

REFLECTION = "half"
"""Kind of the events that put the image of the state, by a symmetry of the system, in its place: nothing happens there.

Systems of `chaosdrill.halved` have them.
"""


@constructor
@dataclass(frozen=True)
class Transition:
    """One outcome of one event.

    Expressions are text, numbers or sympy, or Python functions as in `HybridSystem`.

    Parameters
    ----------
    name : str
        Name of the transition; archives count and label events by it.
    source : str or sequence of str
        Mode or modes in which the guard is watched.
    target : str
        Mode that holds after the event.
    guard : expression
        The event happens where this expression of states, time and parameters reaches zero.
    direction : {+1, -1, 0}
        Upward crossings, downward crossings, or both. +1 says that the mode holds while the guard is negative: if the
        mode is entered beyond it, a transition to another mode is taken at once.
    reset : mapping of state to expression, or a function of all states, optional
        State after the event from the state before it; what is not named stays as it is.
    condition : relation, or mapping of mode to relation, optional
        Relation between pre-event quantities, one for each source if they differ; a function returns whether it holds.
        Transitions that share source, guard and direction are the outcomes of one event: the first declared whose
        condition holds is taken, and none if none holds.
    priority : int, default 0
        Of guards that reach zero together the one with the larger priority acts first.
    completes : str, optional
        Name of an outcome of the same event that throws the state back, such as the rebound of a ball. Where
        rebounds follow each other ever faster and would all be over within a negligible time, this transition is taken
        instead: its reset puts the state at rest on the guard, its target holds the contact.
    kind : str, optional
        Class under which the event is counted, e.g. ``"impact"``; default: the name.

    Raises
    ------
    ModelError
        With every fault that can be told without the system.
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
    given: Mapping[str, Any] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        given = {one.name: getattr(self, one.name) for one in fields(self) if one.init}
        given = {key: value for key, value in given.items() if value is not None or key not in _MAY_BE_NONE}
        from chaosdrill.model.parts import PartReader

        reader = PartReader()
        read = reader.transition((), given)
        if reader.faults:
            raise ModelError(reader.told(f"transition {self.name!r:.60}"))
        # a system reads it again, since it knows the names: pi may be one of them
        for key, value in (*read.items(), ("given", given)):
            object.__setattr__(self, key, read_only(value))

    # else any name would be an attribute to who checks types
    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            # expressions, of a transition that is known by its outline
            if "found" not in vars(self) or name not in EXPRESSIONS:
                raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
            whole = vars(self)["found"]()
            for one in EXPRESSIONS:
                object.__setattr__(self, one, getattr(whole, one))
            return getattr(whole, name)

    @property
    def conditions(self) -> dict[str, Any]:
        """The condition in every source mode; empty without conditions."""
        if self.condition is None:
            return {}
        one = self.condition
        return dict(one) if isinstance(one, Mapping) else dict.fromkeys(self.source, one)

    def content(self) -> tuple[Any, ...]:
        """Hashable content of the transition."""
        return (*(self.name, self.source, self.target, self.guard, self.direction, tuple(self.reset.items())),
                *(tuple(self.conditions.items()), self.priority, self.completes, self.kind))  # fmt: skip

    def marks_only(self) -> bool:
        """Whether the transition changes neither mode nor state: it marks a section."""
        known: bool | None = vars(self).get("marks")
        return (not self.reset and self.source == (self.target,)) if known is None else known

    def in_reset(self) -> frozenset[str]:
        """Names of the states, parameters and the time that its reset depends on."""
        known: frozenset[str] | None = vars(self).get("named")
        if known is not None:
            return known
        return frozenset(symbol.name for value in self.reset.values() for symbol in value.free_symbols)

    def outline(self) -> dict[str, Any]:
        """All of it but expressions, as plain data."""
        plain = (self.name, list(self.source), self.target, self.direction, self.priority, self.completes, self.kind)
        told = {"marks": self.marks_only(), "named": sorted(self.in_reset())}
        return {**dict(zip(_PLAIN, plain, strict=True)), **told}

    @classmethod
    def outlined(cls, plain: Mapping[str, Any], found: Callable[[], "Transition"]) -> "Transition":
        """The transition of an outline; ``found`` gives the whole of it."""
        made = cls.__new__(cls)
        for key in (*_PLAIN, "marks"):
            object.__setattr__(made, key, tuple(plain[key]) if key == "source" else plain[key])
        object.__setattr__(made, "named", frozenset(plain["named"]))
        object.__setattr__(made, "found", found)
        return made


# the default of an argument: an attribute of the class would be found where an outline has none
del Transition.condition
