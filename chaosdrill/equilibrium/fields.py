"""The rates of one mode in the coordinates that are free there, with exact derivatives up to the third order.

They are functions of numbers. What is derived for them is kept with the system, so that another process needs no sympy.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from chaosdrill.codegen.formulas import function_of
from chaosdrill.codegen.layout import UNIT

if TYPE_CHECKING:
    from chaosdrill.equilibrium.expressions import Expressions
    from chaosdrill.model import HybridSystem

KEPT = "fields of equilibria"
"""What is known of modes, by their names: plain data, or the reason why a mode has no equilibria."""


class NoFieldError(Exception):
    """Raised where a mode has no rates whose zeros are equilibria, with the reason."""


@dataclass(frozen=True)
class Side:
    """A guard that a mode watches, negative where the mode holds, and what happens there."""

    outcomes: tuple[int, ...]  # transitions; none for what the mode asks of parameters alone
    always: bool  # whether one of them asks for nothing else


@dataclass(frozen=True)
class Field:
    """Rates of the m free states of a mode, as functions of numbers.

    ``numbers`` are the n states, the parameters, and the levels of conserved combinations.
    """

    system: "HybridSystem"
    mode: int
    free: tuple[int, ...]  # numbers of the m states that are unknowns
    dropped: dict[int, str]  # why each other state is not an unknown
    slides: bool  # whether it holds a surface
    sides: tuple[Side, ...]
    levels: tuple[tuple[float, ...], ...]  # coefficients of the conserved combinations, n each
    made: dict[str, Callable[..., Any]] = field(default_factory=dict)  # functions that were asked for

    def numbers(self, start: Sequence[float] | np.ndarray, values: Sequence[float] | np.ndarray) -> np.ndarray:
        """The numbers of a state (n,) at parameters."""
        levels = [float(np.dot(row, start)) for row in self.levels]
        return np.array([*start, *values, *levels], dtype=float)

    def place(self, name: int) -> int:
        """Where among the numbers a parameter stands, by its own number."""
        return len(self.system.state_names) + name

    def _value(
        self,
        name: str,
        count: int,
        derive: "Callable[[Expressions], list[Any]]",
        numbers: np.ndarray,
        ways: Sequence[tuple[str, np.ndarray]] = (),
    ) -> np.ndarray:
        """Values of ``count`` expressions at numbers, derived once under a name; NaN where they have none."""
        if name not in self.made:
            self.made[name] = self._function(name, derive, tuple(way for way, _ in ways))
        try:
            return np.array(self.made[name](*numbers.tolist(), *(one for _, way in ways for one in way.tolist())))
        except (ArithmeticError, ValueError, TypeError):
            return np.full(count, np.nan)

    def _function(self, name: str, derive: "Callable[[Expressions], list[Any]]", ways: tuple[str, ...]) -> Any:
        mode = self.system.mode_names[self.mode]

        def found(_: Any) -> "Expressions":
            from chaosdrill.equilibrium.expressions import expressions_of

            return expressions_of(self.system, mode)

        return function_of(
            self.system,
            f"equilibria in {mode}: {name}",
            lambda placed: derive(found(placed)),
            of=lambda placed: [*found(placed).symbols, *found(placed).ways(ways)],
        )

    def states(self, numbers: np.ndarray) -> np.ndarray:
        """All n states."""
        return self._value("states", len(self.system.state_names), lambda e: list(e.whole), numbers).astype(float)

    def rate(self, numbers: np.ndarray) -> np.ndarray:
        """Rates of the free states, shape (m,)."""
        return self._value("rates", len(self.free), lambda e: list(e.rates), numbers).astype(float)

    def rounding(self, numbers: np.ndarray) -> np.ndarray:
        """Bound of their rounding errors, shape (m,)."""
        if self.system.sources:
            here = np.abs(numbers[list(self.free)])
            return 8 * UNIT * (np.abs(self.jacobian(numbers)) @ here + np.abs(self.rate(numbers)))
        return UNIT * self._value("bounds", len(self.free), lambda e: e.bounds(), numbers).astype(float)

    def jacobian(self, numbers: np.ndarray) -> np.ndarray:
        """Derivatives of the rates by the free states, shape (m, m)."""
        m = len(self.free)
        return self._value("jacobian", m * m, lambda e: e.jacobian(), numbers).astype(float).reshape(m, m)

    def jacobian_rounding(self, numbers: np.ndarray) -> np.ndarray:
        """Bound of their rounding errors, shape (m, m)."""
        m = len(self.free)
        if self.system.sources:
            return 8 * UNIT * np.abs(self.jacobian(numbers))
        found = self._value("jacobian bounds", m * m, lambda e: e.jacobian_bounds(), numbers)
        return UNIT * found.astype(float).reshape(m, m)

    def by_parameter(self, numbers: np.ndarray, which: int) -> np.ndarray:
        """Derivatives of the rates by a parameter, shape (m,)."""
        at = self.place(which)
        return self._value(f"by {which}", len(self.free), lambda e: e.by(at), numbers).astype(float)

    def along(self, numbers: np.ndarray, which: int, *ways: np.ndarray) -> np.ndarray:
        """Derivative of the rates along up to three directions (m + 1,) of free states and a parameter, shape (m,)."""
        names, at = ("u", "v", "w")[: len(ways)], self.place(which)
        given = list(zip(names, map(np.asarray, ways), strict=True))
        name = f"along {len(ways)} with {which}"
        return self._value(name, len(self.free), lambda e: e.along(at, names), numbers, given)

    def heights(self, numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Guards, negative where the mode holds, and bounds of their rounding errors."""
        guards = self._value("guards", len(self.sides), lambda e: e.guards(), numbers)
        bounds = self._value("guard bounds", len(self.sides), lambda e: e.guard_bounds(), numbers)
        return guards.astype(float), UNIT * bounds.astype(float)

    def slopes(self, numbers: np.ndarray, which: int | None = None) -> np.ndarray:
        """Derivatives of the guards by the free states and, last, a parameter if one is named, shape (G, m + 1)."""
        at, width = None if which is None else self.place(which), len(self.free) + (which is not None)
        rows = self._value(f"slopes {which}", len(self.sides) * width, lambda e: e.slopes(at), numbers)
        return rows.astype(float).reshape(len(self.sides), width)

    def crossed(self, side: int, numbers: np.ndarray) -> bool:
        """Whether one of the outcomes of a guard would be taken here."""
        if self.sides[side].always:
            return True
        known = np.array([*self.states(numbers), *numbers[len(self.system.state_names) :]])
        asked = self._value(f"asked {side}", len(self.sides[side].outcomes), lambda e: e.asked(side), known)
        return bool((asked == 1).any())


def field_of(system: "HybridSystem", mode: str) -> Field:
    """The rates of a mode in its free states.

    Raises `NoFieldError` if the mode has no equilibria, or none that can be looked for, with the reason.
    """
    known = system.shared.setdefault("equilibria", {})
    if mode not in known:
        plain = system.shared.setdefault(KEPT, {})
        if mode not in plain:
            plain[mode] = _plain(system, mode)
        known[mode] = plain[mode] if isinstance(plain[mode], str) else _of_plain(system, mode, *plain[mode])
    if isinstance(known[mode], str):
        raise NoFieldError(known[mode])
    found: Field = known[mode]
    return found


def _plain(system: "HybridSystem", mode: str) -> str | list[Any]:
    """What is to be kept of a mode: why it has no equilibria, or its free states and what stands beside them."""
    from chaosdrill.equilibrium.expressions import NoRatesError, expressions_of

    if system.sources:
        from chaosdrill.codegen import kernels_of

        # its Python functions are known by what was compiled of them
        kernels_of(system)
    try:
        found = expressions_of(system, mode)
    except NoRatesError as fault:
        return str(fault)
    sides = [[list(outcomes), not found.asked(k)] for k, (_, outcomes) in enumerate(found.sides)]
    levels = [list(map(float, row)) for row in found.levels]
    return [list(found.free), list(found.dropped.items()), found.slides, sides, levels]


def _of_plain(
    system: "HybridSystem", mode: str, free: Any, dropped: Any, slides: bool, sides: Any, levels: Any
) -> Field:
    return Field(
        system=system,
        mode=system.mode_names.index(mode),
        free=tuple(free),
        dropped=dict(dropped),
        slides=slides,
        sides=tuple(Side(tuple(outcomes), always) for outcomes, always in sides),
        levels=tuple(map(tuple, levels)),
    )
