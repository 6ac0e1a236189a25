"""The rates of one mode in the coordinates that are free there, with exact derivatives up to the third order.

A mode may hold a state, as sliding holds its surface, or leave one as it is; a linear combination of the rates may be
zero everywhere. In each of these directions a linearisation has an eigenvalue that is zero or that of no motion, which
says nothing of stability: the state is left out of the unknowns, with the reason.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
import sympy

from chaosdrill.codegen import kernels_of, python
from chaosdrill.codegen.rounding import UNIT, rounding_bound
from chaosdrill.codegen.special import CODE
from chaosdrill.model.derive import conserved_by, derivative_along, differentiate, pinned_values
from chaosdrill.model.held import held_surfaces
from chaosdrill.model.places import TIME, parameter

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem


class NoFieldError(Exception):
    """Raised where a mode has no rates whose zeros are equilibria, with the reason."""


@dataclass(frozen=True)
class Side:
    """A guard that a mode watches, and what happens there."""

    expression: Any  # of the free states and parameters, negative where the mode holds
    outcomes: tuple[int, ...]  # transitions; none for what the mode asks of parameters alone


@dataclass(frozen=True)
class Field:
    """Rates of the m free states of a mode, as functions of numbers.

    ``numbers`` are the n states, the parameters, and the levels of conserved combinations.
    """

    system: "HybridSystem"  # in places
    mode: int
    free: tuple[int, ...]  # numbers of the m states that are unknowns
    dropped: dict[int, str]  # why each other state is none
    slides: bool  # whether it holds a surface
    whole: tuple[Any, ...]  # the n states as expressions of the free ones
    rates: tuple[Any, ...]  # of the free states
    sides: tuple[Side, ...]
    levels: tuple[tuple[float, ...], ...]  # coefficients of the conserved combinations, n each
    made: dict[Any, Callable[..., Any]] = field(default_factory=dict)  # functions that were asked for
    sizes: dict[Any, int] = field(default_factory=dict)  # how many numbers each gives

    @property
    def symbols(self) -> list[Any]:
        """Names of the numbers."""
        levels = [sympy.Symbol(f"level_{k}", real=True) for k in range(len(self.levels))]
        return [*self.system.states, *map(parameter, self.system.parameters), *levels]

    @property
    def unknowns(self) -> list[Any]:
        """Symbols of the free states."""
        return [self.system.states[i] for i in self.free]

    def numbers(self, start: Sequence[float] | np.ndarray, values: Sequence[float] | np.ndarray) -> np.ndarray:
        """The numbers of a state (n,) at parameters."""
        levels = [float(np.dot(row, start)) for row in self.levels]
        return np.array([*start, *values, *levels], dtype=float)

    def place(self, name: int) -> int:
        """Where among the numbers a parameter stands, by its own number."""
        return len(self.system.states) + name

    def value(self, key: Any, expressions: Callable[[], Any], numbers: np.ndarray, *more: Any) -> np.ndarray:
        """What expressions, written once, are at numbers; NaN where they have no value."""
        if key not in self.made:
            wanted = list(map(sympy.sympify, np.ravel(np.array(expressions(), dtype=object))))
            symbols = [*self.symbols, *(symbol for row in more for symbol in self._ways(row[0]))]
            modules = [{**CODE, "Called": python.evaluate}, "math"]
            self.sizes[key] = len(wanted)
            self.made[key] = sympy.lambdify(symbols, wanted, modules=modules, cse=True)
        given = [*numbers.tolist(), *(one for row in more for one in row[1].tolist())]
        try:
            return np.array(self.made[key](*given))
        except (ArithmeticError, ValueError, TypeError):
            return np.full(self.sizes[key], np.nan)

    def _ways(self, name: str) -> list[Any]:
        return [sympy.Symbol(f"{name}_{i}") for i in range(len(self.free) + 1)]

    def states(self, numbers: np.ndarray) -> np.ndarray:
        """All n states."""
        return self.value("whole", lambda: self.whole, numbers).astype(float)

    def rate(self, numbers: np.ndarray) -> np.ndarray:
        """Rates of the free states, shape (m,)."""
        return self.value("rates", lambda: self.rates, numbers).astype(float)

    def rounding(self, numbers: np.ndarray) -> np.ndarray:
        """Bound of their rounding errors, shape (m,)."""
        if self.system.sources:
            here = np.abs(numbers[list(self.free)])
            return 8 * UNIT * (np.abs(self.jacobian(numbers)) @ here + np.abs(self.rate(numbers)))
        return UNIT * self.value("bounds", lambda: list(map(rounding_bound, self.rates)), numbers).astype(float)

    def jacobian(self, numbers: np.ndarray) -> np.ndarray:
        """Derivatives of the rates by the free states, shape (m, m)."""
        m = len(self.free)
        return self.value("jacobian", self._jacobian, numbers).astype(float).reshape(m, m)

    def jacobian_rounding(self, numbers: np.ndarray) -> np.ndarray:
        """Bound of their rounding errors, shape (m, m)."""
        m = len(self.free)
        if self.system.sources:
            return 8 * UNIT * np.abs(self.jacobian(numbers))
        found = self.value("jacobian bound", lambda: list(map(rounding_bound, self._jacobian())), numbers)
        return UNIT * found.astype(float).reshape(m, m)

    def _jacobian(self) -> list[Any]:
        return [differentiate(rate, x) for rate in self.rates for x in self.unknowns]

    def by_parameter(self, numbers: np.ndarray, which: int) -> np.ndarray:
        """Derivatives of the rates by a parameter, shape (m,)."""
        symbol = self.symbols[self.place(which)]
        return self.value(("by", which), lambda: [differentiate(r, symbol) for r in self.rates], numbers).astype(float)

    def second(self, numbers: np.ndarray, which: int, *ways: np.ndarray) -> np.ndarray:
        """Second derivative of the rates along two directions (m + 1,) of free states and a parameter, shape (m,)."""
        return self._along(numbers, which, *ways)

    def third(self, numbers: np.ndarray, which: int, *ways: np.ndarray) -> np.ndarray:
        """Third derivative of the rates along three directions, as `second`."""
        return self._along(numbers, which, *ways)

    def _along(self, numbers: np.ndarray, which: int, *ways: np.ndarray) -> np.ndarray:
        names = ("u", "v", "w")[: len(ways)]
        moving = [*self.unknowns, self.symbols[self.place(which)]]

        def expressions() -> list[Any]:
            found = list(self.rates)
            for name in names:
                direction = dict(zip(moving, self._ways(name), strict=True))
                found = [derivative_along(one, direction) for one in found]
            return found

        given = zip(names, (np.asarray(way) for way in ways), strict=True)
        return self.value(("along", which, len(ways)), expressions, numbers, *given)

    def heights(self, numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Guards, negative where the mode holds, and bounds of their rounding errors."""
        guards = [side.expression for side in self.sides]
        bounds = self.value("side bounds", lambda: list(map(rounding_bound, guards)), numbers)
        return self.value("sides", lambda: guards, numbers).astype(float), UNIT * bounds.astype(float)

    def slopes(self, numbers: np.ndarray, which: int | None = None) -> np.ndarray:
        """Derivatives of the guards by the free states and, last, a parameter if one is named, shape (G, m + 1)."""
        moving = [*self.unknowns, *([] if which is None else [self.symbols[self.place(which)]])]
        rows = self.value(
            ("slopes", which), lambda: [differentiate(s.expression, x) for s in self.sides for x in moving], numbers
        )
        return rows.astype(float).reshape(len(self.sides), len(moving))

    def crossed(self, side: int, numbers: np.ndarray) -> bool:
        """Whether one of the outcomes of a guard would be taken here."""
        outcomes = self.sides[side].outcomes
        if not outcomes:
            return True
        name = self.system.mode_names[self.mode]
        asked = [self.system.transitions[i].conditions.get(name, sympy.true) for i in outcomes]
        if sympy.true in asked:
            return True
        known = dict(zip(self.symbols, numbers.tolist(), strict=True))
        known |= dict(zip(self.system.states, self.states(numbers).tolist(), strict=True))
        return any(bool(one.subs(known)) for one in asked)


def field_of(system: "HybridSystem", mode: str) -> Field:
    """The rates of a mode in its free states.

    Raises
    ------
    NoFieldError
        The mode has no equilibria, or none that can be looked for, with the reason.
    """
    known = system.shared.setdefault("fields of equilibria", {})
    if mode not in known:
        if system.sources:
            # its Python functions are known by what was compiled of them
            kernels_of(system)
        try:
            known[mode] = _field_of(system, mode)
        except NoFieldError as fault:
            known[mode] = str(fault)
    if isinstance(known[mode], str):
        raise NoFieldError(known[mode])
    found: Field = known[mode]
    return found


def _field_of(system: "HybridSystem", mode: str) -> Field:
    placed, names = system.placed, system.state_names
    states, rates = placed.states, dict(placed.modes[mode])
    dropped: dict[int, str] = {}
    values: dict[Any, Any] = {}
    for i, value in pinned_values(placed, mode).items():
        values[states[i]] = value
        dropped[i] = f"mode {mode!r} holds {names[i]}"
    slides = bool(values)
    for surface in held_surfaces(placed)[mode]:
        left = sympy.expand(surface.xreplace(values))
        solved = _linear_in(left, [x for x in states if x not in values])
        if solved is None:
            raise NoFieldError(f"mode {mode!r} holds a surface that is linear in no state")
        slope = differentiate(left, solved)
        value = sympy.expand(solved - left / slope)
        values = {x: one.xreplace({solved: value}) for x, one in values.items()} | {solved: value}
        dropped[states.index(solved)] = f"mode {mode!r} holds a surface, which gives {names[states.index(solved)]}"
        slides = True
    if slides and placed.regions and mode not in placed.regions:
        raise NoFieldError(f"no motion is ever in mode {mode!r}: the fields beside its surface never both lead there")
    inside = {x: sympy.expand(sympy.sympify(rates[x]).xreplace(values)) if values else rates[x] for x in states}
    for i, x in enumerate(states):
        if x not in values and inside[x] == 0:
            dropped[i] = f"nothing moves {names[i]} in mode {mode!r}; it has its initial value"
    levels = []
    for k, row in enumerate(conserved_by(placed, mode, [i for i in range(len(states)) if i not in dropped])):
        total = sympy.expand(sympy.Add(*(c * inside[x] for c, x in zip(row, states, strict=True) if c)))
        words = " + ".join(name if c == 1 else f"{c:g} {name}" for c, name in zip(row, names, strict=True) if c)
        if total != 0:
            raise NoFieldError(f"{words} changes at a rate of its own in mode {mode!r}, and so never rests")
        i = next(i for i in range(len(states)) if row[i] and states[i] not in values and i not in dropped)
        rest = sympy.Add(*(c * x for j, (c, x) in enumerate(zip(row, states, strict=True)) if c and j != i))
        value = (sympy.Symbol(f"level_{k}", real=True) - rest.xreplace(values)) / row[i]
        values = {x: one.xreplace({states[i]: value}) for x, one in values.items()} | {states[i]: value}
        dropped[i] = f"{words} is conserved, and has its initial value"
        levels.append(tuple(row))
    free = tuple(i for i in range(len(states)) if i not in dropped)
    if not free:
        raise NoFieldError(f"mode {mode!r} leaves no state free")
    put = {x: sympy.sympify(value) for x, value in values.items()}
    reduced = tuple(sympy.sympify(rates[states[i]]).xreplace(put) for i in free)
    if any(TIME in one.free_symbols for one in (*reduced, *put.values())):
        raise NoFieldError(f"the rates of mode {mode!r} depend on time")
    return Field(
        system=placed,
        mode=placed.mode_names.index(mode),
        free=free,
        dropped=dropped,
        slides=slides,
        whole=tuple(put.get(x, x) for x in states),
        rates=reduced,
        sides=tuple(_sides(placed, mode, put, slides)),
        levels=tuple(levels),
    )


def _linear_in(surface: Any, states: list[Any]) -> Any:
    """A state in which a surface is linear with a coefficient of parameters alone; None without one."""
    for x in states:
        slope = sympy.expand(differentiate(surface, x))
        if slope != 0 and not slope.free_symbols & set(states):
            return x
    return None


def _sides(placed: "HybridSystem", mode: str, values: dict[Any, Any], slides: bool) -> list[Side]:
    """Guards of a mode that have a side on which it holds, and what a sliding mode asks of parameters alone."""
    found: dict[Any, list[int]] = {}
    for i, one in enumerate(placed.transitions):
        if mode not in one.source or one.marks_only() or one.direction == 0:
            continue
        height = sympy.sympify(one.direction * one.guard).xreplace(values)
        if height.free_symbols:
            found.setdefault(height, []).append(i)
    sides = [Side(height, tuple(outcomes)) for height, outcomes in found.items()]
    moving = {*placed.states, TIME}
    for part in sympy.And.make_args(placed.regions.get(mode, sympy.true)) if slides else ():
        if isinstance(part, (sympy.Le, sympy.Lt, sympy.Ge, sympy.Gt)) and not part.free_symbols & moving:
            sides.append(Side(part.lts - part.gts, ()))
    return sides
