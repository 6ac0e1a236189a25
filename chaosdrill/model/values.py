"""A hybrid system as all who derive and compute read it: expressions, numbers and names, and copies with others.

What makes a system, and what makes another one of it, is above: `chaosdrill.model.system`.
"""

from collections.abc import Iterator, Mapping
from copy import copy
from dataclasses import dataclass
from threading import RLock
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Self

from chaosdrill.declared import DISPLAYS
from chaosdrill.errors import SettingsError
from chaosdrill.limits import Limit
from chaosdrill.model.tables import ANOTHER, DEFAULT_BOUNDS, read_only
from chaosdrill.model.transition import CORNER, Transition
from chaosdrill.names import remedy

EXPRESSIONS = ("time", "period")
"""Attributes that are expressions, or None."""

LATE = ("states", *EXPRESSIONS)
"""Attributes that an outline leaves to the whole system."""

NUMBERS = frozenset({"parameters", "initial", "names_mode", "limits", "shared"})
"""Attributes on which nothing depends that is derived of a system."""

PUBLIC = (
    *("name", "description", "labels", "states", "time", "period", "modes", "transitions", "regions", "quadratures"),
    *("bounds", "parameters", "initial", "state_names", "mode_names", "forcing_period"),
    *("with_parameters", "with_initial", "with_noise", "augmented"),
)
"""What users look for in a system, and find by completion."""

deriving = RLock()
"""Several threads may ask for one thing of one system at once, and each would derive it."""


class Shared(dict[Any, Any]):
    """Compiled kernels and derived expressions that systems with the same equations share.

    In another process, to which systems are sent, it starts empty; copies sent together share it again. ``key``:
    identifies a system of the library; its derived code is kept on the disk under this key.
    """

    outline: Any = None
    """Outline of the system of the library, as `chaosdrill.model.outline` has it."""
    held: Mapping[Any, Any] = MappingProxyType({})
    """Kernels that an earlier process has compiled, by the key under which they are to stand here."""
    recalled: frozenset[Any] = frozenset()
    """Names of what the disk holds already."""
    origin: "System | None" = None
    """The system that another process needs before it asks for this one."""

    def __init__(self, key: tuple[str, ...] | None = None) -> None:
        super().__init__()
        self.key = key

    def __reduce__(self) -> tuple[Any, ...]:
        return Shared, (self.key,)


@dataclass(eq=False, repr=False)
class Definition:
    """A definition that was read without faults, its numbers apart."""

    name: str
    description: str
    labels: Mapping[str, str]
    states: tuple[Any, ...]
    time: Any
    period: Any
    modes: Mapping[str, Mapping[Any, Any]]
    transitions: tuple[Transition, ...]
    regions: Mapping[str, Any]
    quadratures: Mapping[str, Mapping[str, Any]]
    bounds: Mapping[str, tuple[float, float]]
    noise: Mapping[str, Mapping[str, Any]]

    def unmoved(self) -> Iterator[tuple[int, str]]:
        """Numbers of the guards that nothing moves, each with what is said of it; none beside a drive.

        That is no fault of a definition, of which a drive may move a parameter, but of a system that is to be run.
        """
        moving = {*self.states, self.time}
        if all(t.kind != CORNER for t in self.transitions):
            for k, t in enumerate(self.transitions):
                if not t.guard.free_symbols & moving:
                    yield k, f"{t.guard} depends on no state and not on time; name one, or let a drive move a parameter"


class System(Definition):
    """What is asked of a hybrid system; it is read only, and shares what is derived of it with its copies."""

    noise: Mapping[str, Mapping[str, Any]] = MappingProxyType({})
    """Distribution and events of each drawn parameter, by its original name; see `with_noise`."""
    parameters: dict[str, float]
    initial: Mapping[str, Any]
    names_mode: bool
    limits: Mapping[str, Limit]
    exponent_parameters: tuple[str, ...]
    shared: Shared
    discrete: ClassVar[bool] = False
    """Whether it is a map, whose period is an iterate."""
    phase: ClassVar[float] = 0.0
    """Where in the period a map takes its iterate; 0 for other systems."""
    late: ClassVar[tuple[str, ...]] = LATE

    @property
    def mode_names(self) -> tuple[str, ...]:
        """Names of the modes, in order."""
        return tuple(self.modes)

    def integrands(self, mode: str) -> list[Any]:
        """Integrands in a mode, in the order of the quadratures."""
        return [rates[mode] for rates in self.quadratures.values()]

    @property
    def built(self) -> Self:
        """The same with all of its expressions at hand."""
        if "whole" not in vars(self):
            return self
        whole: Self = vars(self)["whole"]()
        return whole.changed(**{name: vars(self)[name] for name in NUMBERS})

    @property
    def state_names(self) -> tuple[str, ...]:
        """Names of the states, in order."""
        if "states" in vars(self):
            return tuple(s.name for s in self.states)
        names: tuple[str, ...] = vars(self)["outlined_states"]
        return names

    @property
    def start(self) -> dict[str, Any]:
        """The initial state, and the mode unless its region tells it."""
        return {name: value for name, value in self.initial.items() if name != "mode" or self.names_mode}

    @property
    def initial_values(self) -> list[float]:
        """The initial state in the order of the states."""
        return [self.initial[name] for name in self.state_names]

    @property
    def initial_mode(self) -> int:
        """Number of the initial mode."""
        return self.mode_names.index(self.initial["mode"])

    @property
    def free(self) -> int:
        """States that a perturbation can move: all but those that noise is made of, which are the last ones."""
        return len(self.state_names) - 2 * len(self.noise)

    @property
    def draws(self) -> bool:
        """Whether any event draws a parameter anew, so that nothing repeats."""
        return any(one["at"] for one in self.noise.values())

    @property
    def forced(self) -> bool:
        """Whether it has a period."""
        return "period" not in vars(self) or self.period is not None

    @property
    def sources(self) -> Mapping[str, Any]:
        """Its Python functions by where they stand; empty for a system of expressions."""
        if "sources" not in self.shared:
            self.shared["sources"] = dict(self._sources())
        found: Mapping[str, Any] = self.shared["sources"]
        return found

    def _sources(self) -> Iterator[tuple[str, Any]]:
        from chaosdrill.model.python import Source

        places: list[tuple[str, list[Any]]] = [
            *((f"modes.{mode}", list(rates.values())) for mode, rates in self.modes.items()),
            *((f"quadratures.{name}", list(rates.values())) for name, rates in self.quadratures.items()),
        ]
        for t in self.transitions:
            parts = {"guard": [t.guard], "reset": list(t.reset.values()), "condition": list(t.conditions.values())}
            places += [(f"transitions.{t.name}.{key}", found) for key, found in parts.items()]
        for place, expressions in places:
            for expression in expressions:
                for one in expression.atoms(Source):
                    yield place, one

    @property
    def told_held(self) -> Mapping[str, Any] | None:
        """Surfaces that its modes hold, if known from the system that it was derived from."""
        whole = vars(self)["whole"]() if "whole" in vars(self) else self
        found: Mapping[str, Any] | None = self.shared.get("held", whole.shared.get("held"))
        return found

    def _put(self, **values: Any) -> None:
        for name, value in values.items():
            super().__setattr__(name, value if name == "shared" else read_only(value))

    def changed(self, **values: Any) -> Self:
        """A copy with other values of these attributes, not checked; it shares what was derived if they are numbers."""
        other = copy(self)
        own = {} if values.keys() <= NUMBERS else {"shared": Shared()}
        other._put(**own | values)
        return other

    def limited(self, limits: Mapping[str, Limit]) -> Self:
        """A copy whose parameters, and those of its own copies, must stay within limits."""
        return self.changed(limits={name: one for name, one in limits.items() if name in self.parameters})

    def _content(self) -> tuple[Any, ...]:
        """Hashable content of the system without its numbers."""
        return (
            *(self.name, self.description, repr(self.labels), self.states, self.time, tuple(self.parameters)),
            tuple((name, tuple(rates.items())) for name, rates in self.modes.items()),
            tuple(t.content() for t in self.transitions),
            tuple((name, tuple(rates.items())) for name, rates in self.quadratures.items()),
            tuple(self.regions.items()),
            *(self.period, repr(self.bounds), repr(self.noise)),
        )

    # else any name would be an attribute to who checks types
    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            # what an outline leaves out
            if "whole" not in vars(self) or name not in type(self).late:
                raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}{self._instead(name)}")
            self._put(**{name: vars(self)["whole"].part(name)})
            return vars(self)[name]

    def __dir__(self) -> list[str]:
        return [*PUBLIC, *(name for name in super().__dir__() if name.startswith("__"))]

    def _instead(self, name: str) -> str:
        """Where to find what is no attribute."""
        for table in ("parameters", "initial"):
            if name in vars(self).get(table, ()):
                return f"; its value is system.{table}[{name!r}]"
        if name.startswith("_"):
            return ""
        near = remedy(name, PUBLIC)
        way = near if near.startswith("did") else "analyses are functions, as in chaosdrill.trajectory(system)"
        return f"; {way}"

    @property
    def escapes(self) -> dict[str, tuple[float, float]]:
        """Bounds beyond which each state has escaped; those that nobody gave stand in units of the initial state."""
        unit = max(1.0, *(abs(self.initial[name]) for name in self.state_names))
        low, high = DEFAULT_BOUNDS
        wide = (low * unit, high * unit)
        return {name: wide if pair == DEFAULT_BOUNDS else pair for name, pair in self.bounds.items()}

    def __setattr__(self, name: str, value: Any) -> None:
        raise SettingsError(f"{self.name}: a system cannot be changed, {name!r} stays as it is; {ANOTHER}")

    def __delattr__(self, name: str) -> None:
        self.__setattr__(name, None)

    def _repr_html_(self) -> str | None:
        return DISPLAYS["html"](self)

    def _repr_latex_(self) -> str | None:
        return DISPLAYS["latex"](self)

    def __repr__(self) -> str:
        return (
            f"HybridSystem({self.name!r}, states={self.state_names}, modes={self.mode_names}, "
            f"transitions={tuple(t.name for t in self.transitions)})"
        )
