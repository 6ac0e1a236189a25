"""Fields with kinks and jumps, taken apart into modes."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from itertools import permutations, product
from typing import TYPE_CHECKING, Any, Unpack

import sympy

from chaosdrill.errors import ModelError
from chaosdrill.model.bounds import decided
from chaosdrill.model.crossings import stripped
from chaosdrill.model.filippov import SLIDING, Field, More, TwoSided, Written, several, vanishes
from chaosdrill.model.parts import read_table
from chaosdrill.model.tables import UNNAMED
from chaosdrill.model.touching import unfolded
from chaosdrill.model.transition import Transition
from chaosdrill.model.tuning import TUNING
from chaosdrill.typed import expecting

if TYPE_CHECKING:
    from chaosdrill.model.system import HybridSystem

FLOW = "flow"

_KINKS = (sympy.Abs, sympy.Max, sympy.Min)
_JUMPS = (sympy.sign, sympy.Heaviside, sympy.Piecewise)

Sides = dict[Any, int]
"""Surface -> +1 where its expression is positive, -1 where it is negative."""


@expecting(ModelError)
def in_modes(
    *,
    name: str = UNNAMED,
    states: Iterable[Any],
    parameters: Mapping[str, float] | None = None,
    field: Mapping[Any, Any],
    surface: Any = None,
    time: Any = None,
    initial: Mapping[Any, Any] | None = None,
    **more: Unpack[More],
) -> "HybridSystem":
    """A system whose field has kinks and jumps, in modes between which it is smooth.

    ``Abs``, ``sign``, ``Max``, ``Min``, ``Heaviside`` and ``Piecewise`` change at surfaces, which are found in the
    field; so do roots of what touches zero, as ``sqrt(1 - cos(t)**2)``, ``asin`` and ``acos`` of what touches 1 or -1,
    as ``asin(sin(t))``, and ``atan(tan(t))``. They may stand within each other: ``Max(-b, Min(b, x))`` has kinks at
    ``b`` and ``-b``. What only another order of parameters would change, such as ``b < 0``, is left out, and these must
    keep their order. Where the field is continuous at a surface, motions cross it. It may jump at one surface; there
    they slide as `filippov` says.

    Modes are ``flow``, or ``above``, ``below`` and ``sliding`` if there is a jump, with a sign for every surface of a
    kink, ``+`` where its expression is positive: ``flow+-``. Surfaces stand in the order in which the states name them.

    Parameters
    ----------
    name, states, parameters : str, iterable, mapping
        As for `filippov`.
    field : mapping of state to expression
        Time derivative of every state.
    surface : expression, or mapping of str to expression, optional
        The surface of the jump, to say which side of it is above, or to name it as for `filippov`.
    time : optional
        As for `filippov`.
    initial : mapping, optional
        ``"mode"`` and values of states; default: the mode of the initial state.
    **more : optional
        As for `filippov`.

    Returns
    -------
    HybridSystem
        Its events have the kinds ``kink``, ``slide``, ``cross`` and ``leave``.

    Raises
    ------
    ModelError
        If the field jumps at several surfaces or has kinks at too many, if equations choose the branches, and as for
        `filippov`.
    """
    written = Written.read(name, states, time, parameters, more)
    start = read_table(f"{name}: initial", initial or {})
    broken = _Broken(written, written.read_field("field", field))
    jumps = [g for g in broken.surfaces if broken.jumps_at(g)]
    if len(jumps) > 1:
        raise several(name, f"the field jumps at {' and at '.join(map(str, jumps))}")
    others = [g for g in broken.surfaces if g not in jumps]
    if len(others) > TUNING.kinks:
        raise broken.too_many(len(others))
    if not jumps and surface is not None:
        raise ModelError(f"{name}: surface is {surface!r}, but the field jumps nowhere; leave it out")
    sides = [
        side
        for signs in product((1, -1), repeat=len(others))
        if broken.has(side := dict(zip(others, signs, strict=True)))
    ]
    if not jumps:
        modes = {FLOW + _tag(side): broken.smooth(side) for side in sides}
        transitions = [t for side in sides for t in _crossings(written, modes, FLOW, side, broken)]
        regions = {FLOW + _tag(side): _region(written, side, broken.orders) for side in sides}
        return written.system(modes, transitions, regions).with_initial(**start)
    (jump,) = jumps
    given = TwoSided.beside(written, jump if surface is None else surface)
    where, sign = broken.canonical(given.surface)
    if where != jump:
        raise ModelError(f"{name}: surface is {given.surface}, but the field jumps at {jump}")
    parts = {
        _tag(side): given.combined(broken.smooth({**side, jump: sign}), broken.smooth({**side, jump: -sign}))
        for side in sides
    }
    modes = {mode + tag: rates for tag, part in parts.items() for mode, rates in part.modes.items()}
    transitions = [_tagged(t, tag) for tag, part in parts.items() for t in part.transitions]
    for side in sides:
        transitions += [t for mode in parts[_tag(side)].modes for t in _crossings(given, modes, mode, side, broken)]
    regions = {
        mode + _tag(side): sympy.And(_region(given, side, broken.orders), region)
        for side in sides
        for mode, region in given.regions(parts[_tag(side)]).items()
    }
    return given.system(modes, transitions, regions).with_initial(**_start(given, start))


class _Broken:
    """A field with kinks and jumps; ``surfaces`` are where it changes, each once, with one of its two signs."""

    def __init__(self, written: Written, rates: Field) -> None:
        self._written = written
        self._moving = {*written.states, written.time} - {None}
        self._rates = {
            state: unfolded(decided(rate), self._moving, written.parameters) for state, rate in rates.items()
        }
        self._fields: dict[Any, Field] = {}
        self._may_jump: dict[Any, bool] = {}
        """Surface -> whether a function jumps there, or what is zero there divides."""
        self.orders = set[Any]()
        """What the field asks of parameters, so that it changes nowhere else."""
        for rate in self._rates.values():
            for part in self._parts(rate):
                for sides, _ in self._told(part, {}):
                    for surface in sides:
                        self._may_jump.setdefault(surface, False)
                    if len(self._may_jump) > TUNING.kinks + 1:
                        raise self.too_many(len(self._may_jump))
        for base in {p.base for rate in self._rates.values() for p in rate.atoms(sympy.Pow) if p.exp.is_negative}:
            if base.free_symbols & self._moving:
                heights = (self.canonical(e)[0] for _, e in self._told(base, {}))
                self._may_jump |= {g: True for g in heights if g in self._may_jump}
        self._links = dict(self._parallels())
        self.surfaces = [g for g in self._may_jump if self._changes(g, lambda one, other: one != other)]

    def too_many(self, count: int) -> ModelError:
        """The message that refuses this number of kinks."""
        return ModelError(
            f"{self._written.name}: the field has kinks at {count} surfaces; at most {TUNING.kinks} are taken apart, "
            "since the modes double with each"
        )

    def _parts(self, expression: Any) -> Iterator[Any]:
        """The parts that break, each after those within it, in an order in which names have no say."""
        if not expression.has(*_KINKS, *_JUMPS):
            return
        places = self._written.places
        names = {place: symbol for symbol, place in places.items()}
        for placed in sympy.postorder_traversal(expression.xreplace(places)):
            part = placed.xreplace(names) if isinstance(placed, (*_KINKS, *_JUMPS)) else None
            if part is not None and part.free_symbols & self._moving:
                yield part

    def _told(self, expression: Any, sides: Sides) -> Iterator[tuple[Sides, Any]]:
        """What an expression is on these sides, and on both of every surface that they do not name."""
        part = next(self._parts(expression), None)
        if part is None:
            yield sides, expression
            return
        g, positive, negative = self._branches(part)
        surface, sign = self.canonical(g)
        if isinstance(part, _JUMPS):
            self._may_jump[surface] = True
        for side in (sides[surface],) if surface in sides else (1, -1):
            told = positive if side == sign else negative
            if told is sympy.nan:
                raise ModelError(f"{self._written.name}: {part} has no branch where {g if side == sign else -g} > 0")
            yield from self._told(expression.xreplace({part: told}), {**sides, surface: side})

    def _branches(self, part: Any) -> tuple[Any, Any, Any]:
        """An expression, and what the part is where that is positive and where it is negative."""
        if isinstance(part, sympy.Abs | sympy.sign | sympy.Heaviside):
            g, one = part.args[0], sympy.Integer(1)
            if isinstance(part, sympy.Abs):
                return g, g, -g
            return g, one, -one if isinstance(part, sympy.sign) else sympy.Integer(0)
        if isinstance(part, sympy.Piecewise):
            relations = part.args[0].cond.atoms(sympy.core.relational.Relational)
            first = min(relations, key=lambda e: sympy.default_sort_key(e.xreplace(self._written.places)))
            branches = [part.xreplace({first: told}) for told in (sympy.true, sympy.false)]
            if not isinstance(first, sympy.Gt | sympy.Ge | sympy.Lt | sympy.Le):
                raise ModelError(f"{self._written.name}: {part} has no inequality between its branches; write one")
            return first.gts - first.lts, *branches
        # sums are kept in an order of names; that of states does not depend on them
        a, b, *rest = sorted(part.args, key=lambda e: sympy.default_sort_key(e.xreplace(self._written.places)))
        larger, smaller = (part.func(e, *rest) for e in (a, b))
        return (a - b, larger, smaller) if isinstance(part, sympy.Max) else (a - b, smaller, larger)

    def canonical(self, g: Any) -> tuple[Any, int]:
        """A surface in its simplest form, with one of its signs, and the sign by which the expression differs."""
        core, way = stripped(g)
        _, reduced = sympy.expand(core).primitive()
        if reduced.xreplace(self._written.places).could_extract_minus_sign():
            return sympy.expand(-reduced), -way
        return reduced, way

    def _parallels(self) -> Iterator[tuple[tuple[Any, Any], tuple[int, Any, int]]]:
        """Of two surfaces of one expression, h and k: the sign of c in k = c h + d, d, and the sign of that here."""
        for h, k in permutations((g for g in self._may_jump if g.free_symbols & self._moving), 2):
            (of_h, one), (of_k, other) = (g.as_independent(*self._moving, as_Add=True)[1].primitive() for g in (h, k))
            if one in (other, -other):
                turned = 1 if one == other else -1
                apart = sympy.expand(k - turned * of_k / of_h * h)
                value = self._written.value(apart, {})
                yield (h, k), (turned, apart, (value > 0) - (value < 0))

    def _contradicted(self, sides: Sides, on: Any = None) -> list[Any]:
        """Distances of parallel surfaces whose sign keeps a place, or one on a surface, from being on these sides."""
        return [
            apart
            for (h, k), (turned, apart, sign) in self._links.items()
            if k != on and (h == on or turned * sides.get(h, -turned * sign) == sign) and sides.get(k) == -sign != 0
        ]

    def smooth(self, sides: Sides) -> Field:
        """The rates on these sides."""
        key = frozenset(sides.items())
        if key not in self._fields:
            rest = [g for g in self._may_jump if g not in sides]
            choices = ({**sides, **dict(zip(rest, signs, strict=True))} for signs in product((1, -1), repeat=len(rest)))
            whole = min(choices, key=lambda one: len(self._contradicted(one)))
            told = {state: next(self._told(rate, whole))[1] for state, rate in self._rates.items()}
            if any(self._may_jump.values()):
                told = {state: rate.replace(lambda e: e.is_Mul, self._divided) for state, rate in told.items()}
            self._fields[key] = told
        return self._fields[key]

    def _divided(self, term: Any) -> Any:
        """A product in which what is zero at a surface divides what is zero there, too."""
        for part, other in permutations(term.args, 2):
            (over, power), (base, by) = part.as_base_exp(), other.as_base_exp()
            whole = power.is_Integer and by.is_Integer and power.is_positive and by.is_negative
            if not (whole and over.free_symbols & base.free_symbols & self._moving):
                continue
            if self._may_jump.get(self.canonical(base)[0]):
                ratio, times = sympy.cancel(over / base), min(power, -by)
                if not sympy.denom(ratio).free_symbols & self._moving:
                    left = over ** (power - times) * base ** (by + times)
                    return self._divided(term / part / other * left * ratio**times)
        return term

    def _changes(self, g: Any, differ: Callable[[Field, Field], bool]) -> bool:
        """Whether the rates on both sides of a surface differ, on any sides of the others on which it may be.

        What keeps them from it, if they do elsewhere, becomes one of the ``orders``.
        """
        others, never = [h for h in self._may_jump if h != g], dict[Any, None]()
        for signs in product((1, -1), repeat=len(others)):
            sides = dict(zip(others, signs, strict=True))
            wrong = self._contradicted(sides, on=g)
            if all(e.free_symbols for e in wrong) and differ(
                self.smooth({**sides, g: 1}), self.smooth({**sides, g: -1})
            ):
                if not wrong:
                    return True
                never |= dict.fromkeys(wrong)
        self.orders |= set(map(self._order, never))
        return False

    def _order(self, apart: Any) -> Any:
        """The order of parallel surfaces at the values of the parameters."""
        height, sign = self.canonical(apart)
        return height > 0 if self._written.value(apart, {}) * sign > 0 else height < 0

    def has(self, sides: Sides) -> bool:
        """Whether there is a place on these sides at all values that the parameters may have."""
        return all(apart.free_symbols and self._order(apart) not in self.orders for apart in self._contradicted(sides))

    def jumps_at(self, g: Any) -> bool:
        """Whether the field is not the same on both sides of a surface of states."""
        if not (self._may_jump[g] and g.free_symbols & set(self._written.states)):
            return False
        linear = [x for x in self._written.states if x in g.free_symbols and x not in sympy.diff(g, x).free_symbols]
        on = {linear[-1]: sympy.expand(linear[-1] - g / sympy.diff(g, linear[-1]))} if linear else {}
        return self._changes(
            g, lambda one, other: not all(vanishes(sympy.simplify((one[x] - other[x]).xreplace(on))) for x in one)
        )


def _tag(sides: Sides) -> str:
    return "".join("+" if side > 0 else "-" for side in sides.values())


def _tagged(t: "Transition", tag: str) -> "Transition":
    source = tuple(mode + tag for mode in t.source)
    return replace(t, name=t.name + tag, source=source, target=t.target + tag)


def _crossings(
    written: Written, modes: Mapping[str, Field], mode: str, sides: Sides, broken: _Broken
) -> "Iterator[Transition]":
    """How a mode on one side of the kinks goes on beyond them."""
    held = written if isinstance(written, TwoSided) and mode == SLIDING else None
    source = mode + _tag(sides)
    for i, (g, side) in enumerate(sides.items(), 1):
        beyond = {**sides, g: -side}
        target = mode + _tag(beyond)
        guard = written.off(g) if held is None else held.on(g)
        if not guard.free_symbols & {*modes[source], written.time} or not broken.has(beyond):
            continue
        if target not in modes:
            raise ModelError(f"{written.name}: the field jumps on one side of {g} = 0 only; write its modes yourself")
        reset = {} if held is None else {held.coordinate: held.held}
        yield Transition(f"kink-{i}-{source}", source, target, guard, -side, reset, kind="kink")


def _region(written: Written, sides: Sides, orders: set[Any]) -> Any:
    """Where a start is on these sides of the kinks; a motion on one goes where it leads from above it.

    ``orders``: what is asked of parameters everywhere.
    """
    heights = {written.at_first(written.off(g)): side for g, side in sides.items()}
    return sympy.And(*orders, *(h >= 0 if side > 0 else h < 0 for h, side in heights.items()))


def _start(given: TwoSided, start: Mapping[str, Any]) -> dict[str, Any]:
    """The initial state, and the mode if it is named."""
    mode = str(start.get("mode", ""))
    # the surface asks whether a mode slides, on whatever side of the kinks
    found = given.start({**start, "mode": mode.rstrip("+-")} if mode else start)
    return {**found, "mode": mode} if mode else found
