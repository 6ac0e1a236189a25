"""Rates, guards and events at one point, as LLVM code.

An event has few numbers to compute and many that several of its parts share (the load at its time, above all), so that
one function of which the parts share their subexpressions costs a fraction of a function a part. What only one outcome
needs is computed in that outcome's branch.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import sympy

from chaosdrill.codegen.emitter import DOUBLE, INT, Function, Module, Number, Row, Test
from chaosdrill.codegen.events import cancels, in_series
from chaosdrill.codegen.expression import Expressions
from chaosdrill.codegen.layout import ROUNDING
from chaosdrill.codegen.rounding import rounding_bound
from chaosdrill.codegen.signatures import event_places
from chaosdrill.codegen.tuning import TUNING
from chaosdrill.model.derive import (
    derivative_along,
    frozen_states,
    guard_gradient,
    rate,
    reset_entries,
    reset_map,
    throw,
)
from chaosdrill.model.special import SPECIAL
from chaosdrill.model.touching import is_long

if TYPE_CHECKING:
    from chaosdrill.codegen.constants import Constants
    from chaosdrill.codegen.events import Event
    from chaosdrill.model.system import HybridSystem

_ROW = DOUBLE.as_pointer()


@dataclass(frozen=True)
class Rate:
    """The rate of a state, or an integrand."""

    expression: Any


class Pointwise:
    """Writes the functions of one mode that are evaluated at a point: ``name(t, c, x, ...)``.

    ``written``: the guards of the transitions as they are written. ``large``: modes whose operations stand in tables,
    and the functions of their rates: an event calls these.
    """

    def __init__(
        self,
        module: Module,
        system: "HybridSystem",
        written: Sequence[Any],
        constants: "Constants",
        mode: str,
        large: Mapping[str, str],
    ) -> None:
        self.module, self.system, self.constants, self.mode, self.large = module, system, constants, mode, large
        self.written = written
        self.n = len(system.states)
        self.frozen = frozenset(frozen_states(system))
        self.in_series = in_series(system)
        self.doubts = {x: sympy.Symbol(f"e_{i}", real=True, nonnegative=True) for i, x in enumerate(system.states)}

    def _begin(self, name: str, more: dict[str, Any], result: Any = None) -> tuple[Function, Row, list[Any]]:
        """A function, its states, and its arguments after these."""
        f = Function(self.module, name, {"t": DOUBLE, "c": _ROW, "x": _ROW, **more}, result, own=True)
        return f, f.row(f.arguments[2]), list(f.arguments[3:])

    def _expressions(self, f: Function, x: Row, expressions: list[Any], more: Mapping[Any, Number]) -> Expressions:
        expressions = [sympy.sympify(e) for e in expressions]
        constants = self.constants.loaded(f, f.row(f.arguments[1]))
        needed = set().union(*(e.free_symbols for e in expressions)) if expressions else set()
        values: dict[Any, Number] = dict(more)
        for i, state in enumerate(self.system.states):
            if state in needed and state not in values:
                values[state] = x[i]
        if self.system.time is not None:
            values[self.system.time] = Number(f, f.arguments[0])
        values |= {symbol: constants[symbol] for symbol in self.constants.symbols if symbol in needed}
        return Expressions(f, values, expressions)

    def field(self, module: Module, name: str) -> Any:
        """Write ``(t, c, x, out)``: rates of the states, then integrands of the quadratures."""
        f, x, (out,) = self._begin(name, {"out": _ROW})
        return self._fill(f, x, out, self._rates())

    def variation(self, module: Module, name: str) -> Any:
        """Write ``(t, c, x, d, out)``: the Jacobian times a direction, for rates of which no series is made."""
        f, x, (d, out) = self._begin(name, {"d": _ROW, "out": _ROW})
        states = self.system.states
        along = [sympy.Symbol(f"d_{i}", real=True) for i in range(self.n)]
        direction = dict(zip(states, along, strict=True))
        changes = [derivative_along(self.system.modes[self.mode][s], direction) for s in states]
        given = f.row(d)
        return self._fill(f, x, out, changes, {one: given[i] for i, one in enumerate(along)})

    def watch(self, name: str, arguments: list[Any]) -> Any:
        """Write ``(t, c, x, out)``: what the steep operations are applied to."""
        f, x, (out,) = self._begin(name, {"out": _ROW})
        return self._fill(f, x, out, arguments)

    def guard_error(self, name: str, event: "Event") -> Any:
        """Write ``(t, c, x, doubt)``: error bound of a guard's value."""
        return self._error(name, event.guard, self.doubts)

    def rate_error(self, name: str, whose: "Event | Rate") -> Any:
        """Write ``(t, c, x, doubt)``: error bound of a guard's rate along the flow, or of a rate itself.

        A rate that is as exact as what it is made of has none. Parameters count as exact there: only what changes along
        a step makes rates scatter.
        """
        if not isinstance(whose, Rate):
            return self._error(name, rate(self.system, self.mode, whose.guard), self.doubts)
        if not cancels(whose.expression):
            return None
        exact = {p: -sympy.Abs(p) for p in self.constants.symbols}
        return self._error(name, whose.expression, self.doubts | exact)

    def rates(self) -> list["Rate"]:
        """Rates of states and quadratures; 0 for those that stand in tables, as their bounds would have to."""
        return [Rate(sympy.Integer(0) if self.mode in self.large else e) for e in self._rates()]

    def _rates(self) -> list[Any]:
        field = self.system.modes[self.mode]
        return [*(field[s] for s in self.system.states), *self.system.integrands(self.mode)]

    def _error(self, name: str, expression: Any, doubts: Mapping[Any, Any]) -> Any:
        f, x, (doubt,) = self._begin(name, {"doubt": _ROW}, DOUBLE)
        given, bound = f.row(doubt), rounding_bound(expression, doubts)
        values = self._expressions(f, x, [bound], {one: given[i] for i, one in enumerate(self.doubts.values())})
        f.give(values[bound])
        f.end()
        return f.made

    def _fill(
        self, f: Function, x: Row, out: Any, expressions: list[Any], more: Mapping[Any, Number] | None = None
    ) -> Any:
        target = f.row(out)
        values = self._expressions(f, x, expressions, more or {})
        for i, number in enumerate([values[e] for e in expressions]):
            target[i] = number
        f.end()
        return f.made

    def guard(self, name: str, guard: Any) -> Any:
        """Write ``(t, c, x, gradient)``: a guard's value; its gradient and, last, its time derivative."""
        f, x, (out,) = self._begin(name, {"gradient": _ROW}, DOUBLE)
        gradient, target = guard_gradient(self.system, guard), f.row(out)
        values = self._expressions(f, x, [guard, *gradient], {})
        self._store_sparse(f, target, gradient, values)
        f.give(values[guard])
        f.end()
        return f.made

    def _store_sparse(self, f: Function, target: Row, expressions: list[Any], values: Expressions) -> None:
        if any(e == 0 for e in expressions):
            with f.loop(0, len(expressions)) as i:
                target[i] = 0.0
        for i, e in enumerate(expressions):
            if e != 0:
                target[i] = values[e]

    def event_map(self, name: str, event: "Event") -> Any:
        """Write ``(t, c, x, tangents, scale, tolerance, event)``: one guard's event, whole."""
        return _Transit(self, name, event).write()


class _Transit:
    """The code of one event: onto the guard, which outcome, and all that its reset and its saltation need."""

    def __init__(self, mode: Pointwise, name: str, event: "Event") -> None:
        self.mode, self.system, self.event, self.n = mode, mode.system, event, mode.n
        self.places = event_places(self.n)
        more = {"tangents": INT, "scale": _ROW, "tolerance": DOUBLE, "event": _ROW}
        self.f, self.x, (tangents, scale, self.tolerance, out) = mode._begin(name, more, INT)
        self.tangents = Test(self.f, self.f.builder.icmp_signed("!=", tangents, INT(0)))
        self.scale, self.out = self.f.row(scale), self.f.row(out)
        system, transitions = self.system, self.system.transitions
        self.outcomes = [(i, transitions[i]) for i in event.outcomes]
        self.completing = {i for i, t in self.outcomes if t.completes is not None}
        self.throws = {i: throw(system, t, event.guard) for i, t in self.outcomes if i in mode.in_series}
        self.conditions = {i: t.conditions.get(mode.mode, sympy.true) for i, t in self.outcomes}
        self.maps = {i: reset_map(system, t) for i, t in self.outcomes}
        self.slopes = {i: reset_entries(system, t) for i, t in self.outcomes}
        # a special function takes longer than all the rest of a bound: its value is that of the image
        parts = {p for images in self.maps.values() for e in images for p in e.atoms(sympy.Function)}
        slow = sorted((p for p in parts if type(p).__name__ in SPECIAL), key=sympy.default_sort_key)
        self.slow = {part: sympy.Symbol(f"q_{i}", real=True) for i, part in enumerate(slow)}
        self.gradient = guard_gradient(system, event.guard)
        self.written = {i: guard_gradient(system, mode.written[i]) for i, _ in self.outcomes}
        self.rates = [] if mode.mode in mode.large else [system.modes[mode.mode][x] for x in system.states]
        # rates after the event are those of the target mode at the images of the states
        self.images = [sympy.Symbol(f"y_{i}", real=True) for i in range(self.n)]
        to_image = dict(zip(system.states, self.images, strict=True))
        self.after = {
            i: [system.modes[t.target][x].xreplace(to_image) for x in system.states]
            for i, t in self.outcomes
            if t.target not in mode.large
        }

    def write(self) -> Any:
        """The whole function."""
        f = self.f
        states = self._onto_guard()
        shared = self.mode._expressions(
            f, self.x, self._everything(), dict(zip(self.system.states, states, strict=True))
        )
        self.mode._store_sparse(f, self.out.after(self.places.gradient), self.gradient, shared)
        self._store_rates(self.mode.mode, self.places.before, self.rates, shared)
        for index, _ in sorted(self.outcomes, key=lambda found: found[0] not in self.completing):
            condition = self.conditions[index]
            if index in self.completing:
                complete = self.out[self.places.complete].compare(">", 0.0)
                test = complete if condition == sympy.true else shared.joined(complete, condition, both=True)
            elif condition == sympy.true:
                self._branch(index, shared, states)
                break
            else:
                test = shared.test(condition)
            with f.when(test):
                self._branch(index, shared.inside(), states)
        else:
            f.builder.ret(INT(-1))
        f.end()
        return f.made

    def _everything(self) -> list[Any]:
        conditions = [side for c in self.conditions.values() for r in _relations(c) for side in r.args]
        found = [*self.gradient, *self.rates, *conditions]
        for index, _ in self.outcomes:
            found += [
                *self.written[index],
                *self.throws.get(index, ()),
                *self.maps[index],
                *(part for part in self.slow if any(e.has(part) for e in self.maps[index])),
                *self.slopes[index].values(),
                *self.after.get(index, ()),
            ]
        return found

    def _onto_guard(self) -> list[Number]:
        """Put the state on the guard, along its gradient in the scales of the states; returns the states.

        A guard that is met at a multiple root tells nothing about how far away it is: there the state stays. So does
        one that never changes, as a parameter among the states.
        """
        f, guard = self.f, self.event.guard
        moving = [i for i, x in enumerate(self.system.states) if self.gradient[i] != 0 and x not in self.mode.frozen]
        states = {i: f.variable(self.x[i]) for i in moving}
        # a lone state is as exact as it is known, and so is what does not move
        put = [i for i in moving if not (guard.is_Symbol or (self.rates and self.rates[i] == 0))]
        bound = rounding_bound(guard) if put else None
        self.offsets = {i: f.variable(f.number(0.0)) for i in put}
        if moving:
            needed = [guard, *(self.gradient[i] for i in moving)]
            needed += [] if bound is None else [bound]
            values = self.mode._expressions(f, self.x, needed, {})
            largest = f.number(0.0)
            for i in moving:
                size = f.intrinsic("fabs", values[self.gradient[i]] * self.scale[i])
                largest = f.choose(size.compare(">", largest), size, largest)
            # a guard may be measured in what it likes: its square need not be a number
            unit = f.unit_of(largest)
            value = values[guard] * unit
            slopes = {i: values[self.gradient[i]] * unit for i in moving}
            ways = {i: slopes[i] * self.scale[i] * self.scale[i] for i in moving}
            square = f.number(0.0)
            for i in moving:
                square = square + ways[i] * slopes[i]
            near = TUNING.onto_guard * Number(f, self.tolerance)
            close = (value * value).compare("<=", near * near * square)
            with f.when(square.compare(">", 0.0) & close):
                for i in moving:
                    self.x[i] = states[i].become(states[i].now - value * ways[i] / square)
            if bound is not None:
                # what is left of the value may be its rounding, and more than the tolerance of small states
                known = values[bound] * unit
                rounded = ROUNDING * known * (ROUNDING * known)
                told = close | (value * value).compare("<=", rounded)
                with f.when(square.compare(">", 0.0) & told):
                    for i in put:
                        self.offsets[i].become(f.intrinsic("fabs", known * ways[i] / square))
        return [states[i].now if i in states else self.x[i] for i in range(self.n)]

    def _branch(self, index: int, shared: Expressions, states: list[Number]) -> None:
        """What is done where an outcome is taken."""
        f, n = self.f, self.n
        self.out[self.places.rate] = self._rate(self.written[index], shared)
        if not self.system.transitions[index].marks_only():
            images = [shared[e] for e in self.maps[index]]
            for i, value in enumerate(images):
                self.out[self.places.image + i] = value
            for place, value in enumerate(self.throws.get(index, ()), self.places.speed):
                self.out[place] = shared[value]
            self._store_doubts(index, shared, states, images)
            with f.when(~self.tangents):
                f.builder.ret(INT(index))
            slopes = self.out.after(self.places.jacobian)
            with f.loop(0, n * (n + 1)) as i:
                slopes[i] = 0.0
            with f.loop(0, n) as i:
                slopes[i * (n + 2)] = 1.0
            known = self._told_from_rounding(index, shared, states)
            for (i, j), entry in self.slopes[index].items():
                slopes[i * (n + 1) + j] = known[entry] if entry in known else shared[entry]
            shared.known.update(zip(self.images, images, strict=True))
            target = self.system.transitions[index].target
            self._store_rates(target, self.places.after, self.after.get(index, []), shared)
        f.builder.ret(INT(index))

    def _rate(self, gradient: list[Any], shared: Expressions) -> Number:
        """Rate before the event of a guard of which the gradient and, last, the time derivative are given."""
        found = shared[gradient[-1]]
        for i, slope in enumerate(gradient[:-1]):
            if slope != 0:
                found = found + shared[slope] * self.out[self.places.before + i]
        return found

    def _store_doubts(self, index: int, shared: Expressions, states: list[Number], images: list[Number]) -> None:
        """Put into the event by how much the states may be off after it."""
        f, system, doubts = self.f, self.system, list(self.mode.doubts.values())
        before = [self._doubt_before(i, shared, states[i]) for i in range(self.n)]
        reset = {i: self.maps[index][i] for i, x in enumerate(system.states) if self.maps[index][i] != x}
        bounds = {i: rounding_bound(e, self.mode.doubts).xreplace(self.slow) for i, e in reset.items() if cancels(e)}
        # what each reset makes of an error in a state that stands still would grow from event to event without end
        sized = [self._at_most_known(i, doubt) for i, doubt in enumerate(before)]
        known = dict(zip([*system.states, *doubts], [*states, *sized], strict=True))
        needed = set().union(*(e.free_symbols for e in bounds.values()))
        known |= {symbol: shared[part] for part, symbol in self.slow.items() if symbol in needed}
        values = self.mode._expressions(f, self.x, list(bounds.values()), known)
        for i in range(self.n):
            after = (
                before[i] if i not in reset else values[bounds[i]] if i in bounds else f.intrinsic("fabs", images[i])
            )
            self.out[self.places.doubt + i] = after

    def _told_from_rounding(self, index: int, shared: Expressions, states: list[Number]) -> dict[Any, Number]:
        """Derivatives by states whose terms may cancel: 0 where they are no larger than their rounding.

        As of a hit that keeps nothing but round-off, the exponent of a superstable cycle is then minus infinity.
        """
        f, n = self.f, self.n
        slopes = (
            e for (_, j), e in self.slopes[index].items() if j < n and not is_long(e, TUNING.told_nodes) and cancels(e)
        )
        found = {e: rounding_bound(e) for e in slopes}
        # of a derivative of a special function no derivative is known, and so no rounding
        bounds = {e: bound for e, bound in found.items() if not bound.has(sympy.Derivative)}
        known = dict(zip(self.system.states, states, strict=True))
        values = self.mode._expressions(f, self.x, list(bounds.values()), known)
        return {
            e: f.choose(f.intrinsic("fabs", shared[e]).compare("<", ROUNDING * values[bound]), 0.0, shared[e])
            for e, bound in bounds.items()
        }

    def _at_most_known(self, i: int, doubt: Number) -> Number:
        """The error of a state, or that of a moving state of its size where that is smaller."""
        known = self.out[self.places.known + i]
        return self.f.choose(known.compare("<", doubt), known, doubt)

    def _doubt_before(self, i: int, shared: Expressions, x: Number) -> Number:
        f, places = self.f, self.places
        given = self.out[places.doubt + i]
        if self.rates and self.rates[i] == 0:
            return given
        speed = f.intrinsic("fabs", shared[self.rates[i]] if self.rates else self.out[places.before + i])
        moved = [self.out[places.part] * f.intrinsic("fabs", x), self.out[places.reach] * speed]
        most = f.choose(moved[0].compare(">", moved[1]), *moved)
        known = self.out[places.known + i]
        found = f.choose(speed.compare(">", 0.0), f.choose(known.compare("<", most), known, most), given)
        # on the guard it is put as exactly as that is known
        return found + self.offsets[i].now if i in self.offsets else found

    def _store_rates(self, mode: str, place: int, rates: list[Any], shared: Expressions) -> None:
        """Put the rates of the states in a mode into the event: at the states before it, or at their images."""
        f, large = self.f, self.mode.large
        if mode not in large:
            self.mode._store_sparse(f, self.out.after(place), rates, shared)
            return
        x = self.x if place == self.places.before else self.out.after(self.places.image)
        values = f.scratch(self.n + len(self.system.quadratures))
        field = self.mode.module.module.globals[large[mode]]
        f.builder.call(field, [*f.arguments[:2], x.data, values.data])
        with f.loop(0, self.n) as i:
            self.out[i + place] = values[i]


def _relations(condition: Any) -> list[Any]:
    return sorted(condition.atoms(sympy.core.relational.Relational), key=sympy.default_sort_key)
