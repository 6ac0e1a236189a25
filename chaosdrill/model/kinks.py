"""Fields with kinks and jumps, taken apart into modes."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from itertools import permutations, product
from typing import TYPE_CHECKING, Any, Unpack

import sympy

from chaosdrill.errors import ModelError
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
    as ``asin(sin(t))``, and ``atan(tan(t))``. An expression limited to an interval, ``Max(-1, Min(1, x))``, has two.
    Where the field is continuous at a surface, motions cross it. It may jump at one surface; there they slide as
    `filippov` says.

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
        If the field jumps at several surfaces, if a kink stands within another one or has more than two branches, and
        as for `filippov`.
    """
    written = Written.read(name, states, time, parameters, more)
    start = read_table(f"{name}: initial", initial or {})
    broken = _Broken(written, written.read_field("field", field))
    jumps = [g for g in broken.surfaces if broken.jumps_at(g)]
    if len(jumps) > 1:
        raise several(name, f"the field jumps at {' and at '.join(map(str, jumps))}")
    others = [g for g in broken.surfaces if g not in jumps]
    if len(others) > TUNING.kinks:
        raise ModelError(
            f"{name}: the field has kinks at {len(others)} surfaces; at most {TUNING.kinks} are taken apart, since the "
            "modes double with each"
        )
    if not jumps and surface is not None:
        raise ModelError(f"{name}: surface is {surface!r}, but the field jumps nowhere; leave it out")
    sides = [dict(zip(others, signs, strict=True)) for signs in product((1, -1), repeat=len(others))]
    if not jumps:
        modes = {FLOW + _tag(side): broken.smooth(side) for side in sides}
        transitions = [t for side in sides for t in _crossings(written, modes, FLOW, side)]
        regions = {FLOW + _tag(side): _region(written, side) for side in sides}
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
        transitions += [t for mode in parts[_tag(side)].modes for t in _crossings(given, modes, mode, side)]
    regions = {
        mode + _tag(side): sympy.And(_region(given, side), region)
        for side in sides
        for mode, region in given.regions(parts[_tag(side)]).items()
    }
    return given.system(modes, transitions, regions).with_initial(**_start(given, start))


class _Broken:
    """A field with kinks and jumps; ``surfaces`` are where it changes, each once, with one of its two signs."""

    def __init__(self, written: Written, rates: Field) -> None:
        moving = {*written.states, written.time} - {None}
        self._written = written
        self._rates = {
            state: _unclipped(self._signed(unfolded(rate, moving, written.parameters), moving), moving)
            for state, rate in rates.items()
        }
        self._parts: dict[Any, tuple[Any, int, Any, Any]] = {}
        for part in self._find():
            g, positive, negative = self._branches(part)
            surface, sign = self.canonical(g)
            self._parts[part] = (surface, sign, positive, negative)
        self.surfaces = list(dict.fromkeys(surface for surface, *_ in self._parts.values()))

    def _signed(self, rate: Any, moving: set[Any]) -> Any:
        """A rate in which a size over its own expression is a sign, as in ``Abs(x)/x``, which jumps."""

        def signed(term: Any) -> Any:
            for part, other in permutations(term.args, 2):
                (size, power), (over, by) = part.as_base_exp(), other.as_base_exp()
                if not (isinstance(size, sympy.Abs) and size.free_symbols & moving and power.is_odd and by.is_integer):
                    continue
                (g,) = size.args
                left = power + by
                if (power * by).is_negative and left >= 0 and self.canonical(g)[0] == self.canonical(over)[0]:
                    once = sympy.sign(g) * g**left * sympy.cancel(over / g) ** by
                    return signed(term / part / other * once)
            return term

        return rate.replace(lambda e: e.is_Mul, signed)

    def _find(self) -> Iterator[Any]:
        """The parts that break, in an order in which names have no say."""
        moving = {*self._written.states, self._written.time}
        places = self._written.places
        names = {place: symbol for symbol, place in places.items()}
        for rate in self._rates.values():
            for placed in sympy.preorder_traversal(rate.xreplace(places)):
                part = placed.xreplace(names) if isinstance(placed, (*_KINKS, *_JUMPS)) else None
                if part is None or not part.free_symbols & moving:
                    continue
                if _is_nested(part):
                    raise ModelError(
                        f"{self._written.name}: {part} has a kink within a kink; write the modes of it yourself"
                    )
                yield part

    def _branches(self, part: Any) -> tuple[Any, Any, Any]:
        """An expression, and what the part is where that is positive and where it is negative."""
        if isinstance(part, sympy.Abs | sympy.sign | sympy.Heaviside):
            g, one = part.args[0], sympy.Integer(1)
            if isinstance(part, sympy.Abs):
                return g, g, -g
            return g, one, -one if isinstance(part, sympy.sign) else sympy.Integer(0)
        if isinstance(part, sympy.Piecewise):
            if len(part.args) == 2 and part.args[1].cond == sympy.true:
                (one, condition), (other, _) = part.args
                if isinstance(condition, sympy.Gt | sympy.Ge | sympy.Lt | sympy.Le):
                    return condition.gts - condition.lts, one, other
        elif len(part.args) == 2:
            # sums are kept in an order of names; that of states does not depend on them
            a, b = sorted(part.args, key=lambda e: sympy.default_sort_key(e.xreplace(self._written.places)))
            return (a - b, a, b) if isinstance(part, sympy.Max) else (a - b, b, a)
        raise ModelError(
            f"{self._written.name}: {part} has more than two branches, or no inequality between them; write it with "
            "branches of two"
        )

    def canonical(self, g: Any) -> tuple[Any, int]:
        """A surface with one of its signs, without a common number, and the sign by which the expression differs."""
        _, reduced = sympy.expand(g).primitive()
        if reduced.xreplace(self._written.places).could_extract_minus_sign():
            return sympy.expand(-reduced), -1
        return reduced, 1

    def smooth(self, sides: Sides) -> Field:
        """The rates on these sides."""
        put = {
            part: positive if sides[surface] == sign else negative
            for part, (surface, sign, positive, negative) in self._parts.items()
            if surface in sides
        }
        return {state: rate.xreplace(put) for state, rate in self._rates.items()}

    def jumps_at(self, g: Any) -> bool:
        """Whether the field is not the same on both sides of a surface of states."""
        if not g.free_symbols & set(self._written.states):
            return False
        if all(isinstance(part, _KINKS) for part, (surface, *_) in self._parts.items() if surface == g):
            return False
        one, other = self.smooth({g: 1}), self.smooth({g: -1})
        linear = [x for x in self._written.states if x in g.free_symbols and x not in sympy.diff(g, x).free_symbols]
        on = {linear[-1]: sympy.expand(linear[-1] - g / sympy.diff(g, linear[-1]))} if linear else {}
        return not all(vanishes(sympy.simplify((one[x] - other[x]).xreplace(on))) for x in one)


def _unclipped(rate: Any, moving: set[Any]) -> Any:
    """A rate with what is kept between two numbers written by the distances from both, whose kinks stand apart.

    Where kinks are left within kinks it stays as it was written.
    """

    def apart(part: Any) -> Any:
        if len(part.args) != 2:
            return part
        end, inner = sorted(part.args, key=lambda e: isinstance(e, _KINKS))
        if not isinstance(inner, sympy.Max | sympy.Min) or isinstance(inner, type(part)) or len(inner.args) != 2:
            return part
        other, u = sorted(inner.args, key=lambda e: not e.is_number)
        low, high = (end, other) if isinstance(part, sympy.Max) else (other, end)
        if not (end.is_number and other.is_number and low <= high):
            return part
        return (low + high + sympy.Abs(u - low) - sympy.Abs(u - high)) / 2

    found = rate.replace(lambda e: isinstance(e, sympy.Max | sympy.Min), apart)
    parts = (part for part in found.atoms(*_KINKS, *_JUMPS) if part.free_symbols & moving)
    return rate if any(map(_is_nested, parts)) else found


def _is_nested(part: Any) -> bool:
    return any(inner.has(*_KINKS, *_JUMPS) for inner in part.args)


def _tag(sides: Sides) -> str:
    return "".join("+" if side > 0 else "-" for side in sides.values())


def _tagged(t: "Transition", tag: str) -> "Transition":
    source = tuple(mode + tag for mode in t.source)
    return replace(t, name=t.name + tag, source=source, target=t.target + tag)


def _crossings(written: Written, modes: Mapping[str, Field], mode: str, sides: Sides) -> "Iterator[Transition]":
    """How a mode on one side of the kinks goes on beyond them."""
    held = written if isinstance(written, TwoSided) and mode == SLIDING else None
    source = mode + _tag(sides)
    for i, (g, side) in enumerate(sides.items(), 1):
        target = mode + _tag({**sides, g: -side})
        guard = written.off(g) if held is None else held.on(g)
        if not guard.free_symbols & {*modes[source], written.time}:
            continue
        if target not in modes:
            raise ModelError(f"{written.name}: the field jumps on one side of {g} = 0 only; write its modes yourself")
        reset = {} if held is None else {held.coordinate: held.held}
        yield Transition(f"kink-{i}-{source}", source, target, guard, -side, reset, kind="kink")


def _region(written: Written, sides: Sides) -> Any:
    """Where a start is on these sides of the kinks; a motion on one goes where it leads from above it."""
    heights = {written.at_first(written.off(g)): side for g, side in sides.items()}
    return sympy.And(*(h >= 0 if side > 0 else h < 0 for h, side in heights.items()))


def _start(given: TwoSided, start: Mapping[str, Any]) -> dict[str, Any]:
    """The initial state, and the mode if it is named."""
    mode = str(start.get("mode", ""))
    # the surface asks whether a mode slides, on whatever side of the kinks
    found = given.start({**start, "mode": mode.rstrip("+-")} if mode else start)
    return {**found, "mode": mode} if mode else found
