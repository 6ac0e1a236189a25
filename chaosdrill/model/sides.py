"""Kinks and jumps in parameters: the branch that holds at their values, and as far as which values it does."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import sympy
from sympy.core.relational import Relational

from chaosdrill.errors import SettingsError
from chaosdrill.model.places import parameter
from chaosdrill.model.rules import kinked
from chaosdrill.model.touching import degree_bound, exact
from chaosdrill.model.tuning import TUNING
from chaosdrill.model.values import System

_BROKEN = (sympy.Abs, sympy.sign, sympy.Max, sympy.Min, sympy.Piecewise)


@dataclass
class Side:
    """The branches of functions of some parameters that hold at the values of these.

    ``free``: the parameters. ``values``: of all parameters, by their symbols.
    """

    free: frozenset[Any]
    values: Mapping[Any, float]
    heights: dict[Any, Any] = field(default_factory=dict)
    """What is positive on this side and zero at its end -> the part that has a kink or a jump there."""
    settled: dict[Any, Any] = field(default_factory=dict)
    """A condition on other parameters alone, or what it is not -> the part in which it stands."""
    name: str = ""

    @classmethod
    def of(cls, system: System, names: Iterable[str]) -> "Side":
        """That of the parameters with these names."""
        values = {parameter(name): value for name, value in system.parameters.items()}
        return cls(frozenset(map(parameter, names)), values, name=system.name.removesuffix(" (lifted)"))

    def smooth(self, system: Any) -> Any:
        """The system with the branches of its rates, guards, resets, quadratures and period; itself if it has none."""
        modes, quadratures = (
            {key: {x: self.told(rate) for x, rate in one.items()} for key, one in many.items()}
            for many in (system.modes, system.quadratures)
        )
        transitions = [
            replace(one, guard=self.told(one.guard), reset={x: self.told(e) for x, e in one.reset.items()})
            for one in system.transitions
        ]
        period = None if system.period is None else self.told(system.period)
        rates = (rate for one in (*modes.values(), *quadratures.values()) for rate in one.values())
        if bent := kinked((*rates, *(one.guard for one in transitions), period or 0), set(self.free)):
            raise self.refusal(bent[0])
        if not (self.heights or self.settled):
            return system
        return system.remade(modes=modes, transitions=transitions, quadratures=quadratures, period=period)

    def told(self, expression: Any) -> Any:
        """An expression with the branches that hold."""
        return sympy.sympify(expression).replace(self._is_broken, self._branch)

    def _is_broken(self, part: Any) -> bool:
        symbols = part.free_symbols if isinstance(part, _BROKEN) else set()
        return bool(symbols & self.free) and symbols <= self.values.keys()

    def _branch(self, part: Any) -> Any:
        if isinstance(part, sympy.Piecewise):
            return part.xreplace({r: self._holds(r, part) for r in part.atoms(Relational) if hasattr(r, "gts")})
        if isinstance(part, sympy.Abs | sympy.sign):
            (g,) = part.args
            way = sympy.Integer(self._above(g, part))
            return way if isinstance(part, sympy.sign) else way * g
        way = 1 if isinstance(part, sympy.Max) else -1
        chosen = max(part.args, key=lambda a: way * self._value(a))
        for other in part.args:
            if other != chosen:
                self._above(chosen - other, part)
        return chosen

    def _holds(self, condition: Any, part: Any) -> Any:
        g = condition.gts - condition.lts
        if g.free_symbols & self.free:
            return sympy.true if self._above(g, part) > 0 else sympy.false
        value = self._value(g)
        holds = value > 0 or (value == 0 and isinstance(condition, sympy.Ge | sympy.Le))
        self.settled[condition if holds else ~condition] = part
        return sympy.true if holds else sympy.false

    def _value(self, e: Any) -> float:
        # decimal numbers as they are written, so that a parameter at a kink is there
        return float(self._with_numbers(e, self.values))

    @staticmethod
    def _with_numbers(e: Any, numbers: Mapping[Any, float]) -> Any:
        return exact(e.xreplace({symbol: sympy.Float(number) for symbol, number in numbers.items()}))

    def _above(self, g: Any, part: Any) -> int:
        """The sign of what is zero at a kink or a jump."""
        if not g.free_symbols & self.free:
            return 1 if self._value(g) > 0 else -1
        value = self._value(g)
        if not value:
            raise self.refusal(part)
        self.heights[g if value > 0 else -g] = part
        return 1 if value > 0 else -1

    def alone(self) -> None:
        """Refuse a side that other parameters decide, too, where these may get other values."""
        for told, part in (*self.heights.items(), *self.settled.items()):
            if others := told.free_symbols - self.free:
                symbol, other = (min(some, key=str).name for some in (part.free_symbols & self.free, others))
                raise SettingsError(
                    f"{self.name}: where {part!s:.60} has a kink or a jump in the parameter {symbol!r} depends on "
                    f"{other!r}; write a number for {other!r}, or leave {symbol!r} as it is"
                )

    def refusal(self, part: Any) -> SettingsError:
        """The message that refuses derivatives by the parameters of a part."""
        symbol = min(part.free_symbols & self.free, key=str)
        return SettingsError(
            f"{self.name}: {part!s:.60} has a kink or a jump in the parameter {symbol.name!r}, whose derivatives are "
            f"needed here; write it without, or leave {symbol.name!r} as it is"
        )

    def ends(self, name: str) -> "tuple[End, End]":
        """Where the side ends below and above the value of one of the parameters."""
        symbol = parameter(name)
        low, high = End(-math.inf), End(math.inf)
        for g, part in self.heights.items():
            if symbol not in g.free_symbols:
                continue
            alone = self._with_numbers(g, {s: number for s, number in self.values.items() if s != symbol})
            straight = alone.is_polynomial(symbol) and degree_bound(alone) <= TUNING.zeros
            if not straight or len(g.free_symbols & self.free) > 1:
                raise self.refusal(part)
            for root in map(float, sympy.real_roots(sympy.Poly(alone, symbol))):
                if low.value < root < self.values[symbol]:
                    low = End(root, part)
                elif self.values[symbol] < root < high.value:
                    high = End(root, part)
        return low, high


@dataclass(frozen=True)
class End:
    """A value of a parameter, and the part that has a kink or a jump there."""

    value: float
    part: Any = None
