"""The rates of one mode in the coordinates that are free there, as expressions.

A mode may hold a state, as sliding holds its surface, or leave one as it is; a linear combination of the rates may be
zero everywhere. In each of these directions a linearisation has an eigenvalue that is zero or that of no motion, which
says nothing of stability: the state is left out of the unknowns, with the reason.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import sympy

from chaosdrill.codegen.rounding import rounding_bound
from chaosdrill.model.derive import conserved_by, derivative_along, differentiate, pinned_values
from chaosdrill.model.held import held_surfaces
from chaosdrill.model.places import TIME, parameter

if TYPE_CHECKING:
    import numpy as np

    from chaosdrill.model import HybridSystem


class NoRatesError(Exception):
    """Raised where a mode has no equilibria, or none that can be looked for, with the reason."""


@dataclass(frozen=True)
class Expressions:
    """The m rates of the free states of a mode, and what is asked of them."""

    placed: "HybridSystem"
    mode: str
    free: tuple[int, ...]  # numbers of the m states that are unknowns
    dropped: dict[int, str]  # why each other state is not an unknown
    slides: bool  # whether it holds a surface
    whole: tuple[Any, ...]  # the n states as expressions of the free ones
    rates: tuple[Any, ...]  # of the free states
    sides: tuple[tuple[Any, tuple[int, ...]], ...]  # guards, negative where the mode holds, with their transitions
    levels: tuple[tuple[float, ...], ...]  # coefficients of the conserved combinations, n each

    @property
    def symbols(self) -> list[Any]:
        """Of the states, the parameters and the levels."""
        levels = [sympy.Symbol(f"level_{k}", real=True) for k in range(len(self.levels))]
        return [*self.placed.states, *map(parameter, self.placed.parameters), *levels]

    def ways(self, names: tuple[str, ...]) -> list[Any]:
        """Symbols of directions of the free states and a parameter."""
        return [symbol for name in names for symbol in self._way(name)]

    def _way(self, name: str) -> list[Any]:
        return [sympy.Symbol(f"{name}_{i}") for i in range(len(self.free) + 1)]

    @property
    def _unknowns(self) -> list[Any]:
        return [self.placed.states[i] for i in self.free]

    def jacobian(self) -> list[Any]:
        """Derivatives of the rates by the free states, row by row."""
        return [differentiate(rate, x) for rate in self.rates for x in self._unknowns]

    def bounds(self) -> list[Any]:
        """Bounds of the rounding errors of the rates."""
        return list(map(rounding_bound, self.rates))

    def jacobian_bounds(self) -> list[Any]:
        """The same of their derivatives."""
        return list(map(rounding_bound, self.jacobian()))

    def by(self, place: int) -> list[Any]:
        """Derivatives of the rates by one of the symbols."""
        return [differentiate(rate, self.symbols[place]) for rate in self.rates]

    def along(self, place: int, names: tuple[str, ...]) -> list[Any]:
        """Derivatives of the rates along directions of the free states and one of the symbols."""
        moving, found = [*self._unknowns, self.symbols[place]], list(self.rates)
        for name in names:
            direction = dict(zip(moving, self._way(name), strict=True))
            found = [derivative_along(one, direction) for one in found]
        return found

    def guards(self) -> list[Any]:
        """The guards of the sides."""
        return [guard for guard, _ in self.sides]

    def guard_bounds(self) -> list[Any]:
        """Bounds of their rounding errors."""
        return list(map(rounding_bound, self.guards()))

    def slopes(self, place: int | None) -> list[Any]:
        """Derivatives of the guards by the free states and, last, one of the symbols if it is named, row by row."""
        moving = [*self._unknowns, *([] if place is None else [self.symbols[place]])]
        return [differentiate(guard, x) for guard in self.guards() for x in moving]

    def asked(self, side: int) -> list[Any]:
        """What each outcome of a guard asks for; nothing if one of them asks for nothing."""
        found = [self.placed.transitions[i].conditions.get(self.mode, sympy.true) for i in self.sides[side][1]]
        return [] if sympy.true in found else found


def may_rest(system: "HybridSystem", mode: str, numbers: "np.ndarray", errors: "np.ndarray") -> bool:
    """Whether the rates of a mode may all be zero, as where it rests in a continuum of states.

    ``numbers``, ``errors``: states and parameters, and how well they are known.
    """
    names = [*system.state_names, *system.parameters]
    at, near = dict(zip(names, numbers.tolist(), strict=True)), dict(zip(names, errors.tolist(), strict=True))
    for rate in map(sympy.sympify, system.modes[mode].values()):
        read = {x: sympy.Float(at[x.name]) for x in rate.free_symbols if x.name in at}
        value = rate.xreplace(read)
        doubt = sympy.Add(*(near[x.name] * abs(differentiate(rate, x).xreplace(read)) for x in read))
        if not (all(one.is_number and one.is_real for one in (value, doubt)) and abs(value) <= doubt):
            return False
    return True


def expressions_of(system: "HybridSystem", mode: str) -> Expressions:
    """The rates of a mode in its free states.

    Raises `NoRatesError` if the mode has no equilibria, or none that can be looked for, with the reason.
    """
    known = system.shared.setdefault("expressions of equilibria", {})
    if mode not in known:
        known[mode] = _derived(system.placed, mode, system.state_names)
    found: Expressions = known[mode]
    return found


def _derived(placed: "HybridSystem", mode: str, names: tuple[str, ...]) -> Expressions:
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
            raise NoRatesError(f"mode {mode!r} holds a surface that is linear in no state")
        slope = differentiate(left, solved)
        value = sympy.expand(solved - left / slope)
        values = {x: one.xreplace({solved: value}) for x, one in values.items()} | {solved: value}
        dropped[states.index(solved)] = f"mode {mode!r} holds a surface, which gives {names[states.index(solved)]}"
        slides = True
    if slides and placed.regions and mode not in placed.regions:
        raise NoRatesError(f"no motion is ever in mode {mode!r}: the fields beside its surface never both lead there")
    inside = {x: sympy.expand(sympy.sympify(rates[x]).xreplace(values)) if values else rates[x] for x in states}
    for i, x in enumerate(states):
        if x not in values and inside[x] == 0:
            dropped[i] = f"nothing moves {names[i]} in mode {mode!r}; it has its initial value"
    levels = []
    for k, row in enumerate(conserved_by(placed, mode, [i for i in range(len(states)) if i not in dropped])):
        total = sympy.expand(sympy.Add(*(c * inside[x] for c, x in zip(row, states, strict=True) if c)))
        words = " + ".join(name if c == 1 else f"{c:g} {name}" for c, name in zip(row, names, strict=True) if c)
        if total != 0:
            rests = "rests only where parameters make it zero" if total.free_symbols else "so never rests"
            raise NoRatesError(f"{words} changes at a rate of its own in mode {mode!r}, and {rests}")
        i = next(i for i in range(len(states)) if row[i] and states[i] not in values and i not in dropped)
        rest = sympy.Add(*(c * x for j, (c, x) in enumerate(zip(row, states, strict=True)) if c and j != i))
        value = (sympy.Symbol(f"level_{k}", real=True) - rest.xreplace(values)) / row[i]
        values = {x: one.xreplace({states[i]: value}) for x, one in values.items()} | {states[i]: value}
        dropped[i] = f"{words} is conserved, and has its initial value"
        levels.append(tuple(row))
    free = tuple(i for i in range(len(states)) if i not in dropped)
    if not free:
        raise NoRatesError(f"mode {mode!r} leaves no state free")
    put = {x: sympy.sympify(value) for x, value in values.items()}
    reduced = tuple(sympy.sympify(rates[states[i]]).xreplace(put) for i in free)
    if any(TIME in one.free_symbols for one in (*reduced, *put.values())):
        raise NoRatesError(f"the rates of mode {mode!r} depend on time")
    return Expressions(
        placed=placed,
        mode=mode,
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


def _sides(
    placed: "HybridSystem", mode: str, values: dict[Any, Any], slides: bool
) -> list[tuple[Any, tuple[int, ...]]]:
    """Guards of a mode that have a side on which it holds, and what a sliding mode asks of parameters alone."""
    found: dict[Any, list[int]] = {}
    for i, one in enumerate(placed.transitions):
        if mode not in one.source or one.marks_only() or one.direction == 0:
            continue
        height = sympy.sympify(one.direction * one.guard).xreplace(values)
        if height.free_symbols:
            found.setdefault(height, []).append(i)
    sides = [(height, tuple(outcomes)) for height, outcomes in found.items()]
    moving = {*placed.states, TIME}
    for part in sympy.And.make_args(placed.regions.get(mode, sympy.true)) if slides else ():
        if isinstance(part, (sympy.Le, sympy.Lt, sympy.Ge, sympy.Gt)) and not part.free_symbols & moving:
            sides.append((part.lts - part.gts, ()))
    return sides
