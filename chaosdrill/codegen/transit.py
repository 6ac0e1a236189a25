"""Source of one event: onto the guard, which outcome, and all that its reset and its saltation need, in one function.

An event has few numbers to compute and many that several of its parts share (the load at its time, above all), so that
one function of which the parts share their subexpressions costs a fraction of a function a part. What only one outcome
needs is computed in that outcome's branch.
"""

from typing import TYPE_CHECKING, Any

import sympy

from chaosdrill.codegen.expression import ExpressionPrinter
from chaosdrill.codegen.signatures import event_places
from chaosdrill.model.derive import guard_gradient, rebound, reset_jacobian, reset_map

if TYPE_CHECKING:
    from chaosdrill.codegen.source import Event
    from chaosdrill.model.system import HybridSystem


ONTO = 100.0
"""Tolerances, in scales of the states, within which a state is put onto the guard that it has met."""


class _Shared:
    """Expressions whose common parts are assigned when they are first needed."""

    def __init__(self, printer: ExpressionPrinter, expressions: list[Any]) -> None:
        self.printer = printer
        expressions = [sympy.sympify(e) for e in expressions]
        shared, reduced = sympy.cse(expressions, symbols=sympy.numbered_symbols("s_", real=True))
        self.definitions = dict(shared)
        self.reduced = dict(zip(expressions, reduced, strict=True))

    def text(self, expression: Any, lines: list[str], known: set[Any]) -> str:
        """Source of an expression; assignments of what it needs and is not ``known`` are added to ``lines``."""
        short = self.reduced[expression]
        self._assign(short, lines, known)
        return self.printer.doprint(short)

    def test(self, condition: Any, lines: list[str], known: set[Any]) -> str:
        """Source of a condition, in the same way."""
        sides = {r: r.func(*(self.reduced[side] for side in r.args), evaluate=False) for r in _relations(condition)}
        for relation in sides.values():
            self._assign(relation, lines, known)
        return self.printer.doprint(condition.xreplace(sides))

    def _assign(self, expression: Any, lines: list[str], known: set[Any]) -> None:
        for symbol in sorted(expression.free_symbols & self.definitions.keys(), key=list(self.definitions).index):
            if symbol not in known:
                self._assign(self.definitions[symbol], lines, known)
                known.add(symbol)
                lines.append(f"{symbol.name} = {self.printer.doprint(self.definitions[symbol])}")


def _relations(condition: Any) -> list[Any]:
    return sorted(condition.atoms(sympy.core.relational.Relational), key=sympy.default_sort_key)


def transit(system: "HybridSystem", printer: ExpressionPrinter, mode: str, event: "Event") -> list[str]:
    """Body of ``transit`` for one guard of one mode, after the states have been unpacked.

    Parameters
    ----------
    system : HybridSystem
    printer : ExpressionPrinter
    mode : str
        The mode before.
    event : Event
        Guard and outcomes.
    """
    n = len(system.states)
    places = event_places(n)
    outcomes = [(index, system.transitions[index]) for index in event.outcomes]
    named = {t.name: t for t in system.transitions}
    images = [sympy.Symbol(f"y{i}", real=True) for i in range(n)]
    to_image = dict(zip(system.states, images, strict=True))
    gradient = guard_gradient(system, event.guard)
    rates = [system.modes[mode][x] for x in system.states]
    rebounds = {i: rebound(system, named[t.completes]) for i, t in outcomes if t.completes is not None}
    conditions = {i: sympy.sympify(True if t.condition is None else t.condition) for i, t in outcomes}
    maps = {i: reset_map(system, t) for i, t in outcomes}
    slopes = {i: [v for row in reset_jacobian(system, t) for v in row] for i, t in outcomes}
    after = {i: [system.modes[t.target][x].xreplace(to_image) for x in system.states] for i, t in outcomes}
    everything = [*gradient, *rates, *(side for c in conditions.values() for r in _relations(c) for side in r.args)]
    for index, _ in outcomes:
        everything += [*rebounds.get(index, ()), *maps[index], *slopes[index], *after[index]]
    shared = _Shared(printer, everything)
    lines = _onto_guard(system, printer, event)
    known: set[Any] = set()

    def store(first: int, values: list[Any], into: list[str], have: set[Any]) -> None:
        for i, value in enumerate(values):
            text = shared.text(sympy.sympify(value), into, have)
            into.append(f"event[{first + i}] = {text}")

    store(places.gradient, gradient, lines, known)
    store(places.before, rates, lines, known)
    lines.append(f"event[{places.rest}] = -1.0")

    def branch(index: int) -> list[str]:
        transition = system.transitions[index]
        if transition.marks_only():
            return [f"return {index}"]
        own: list[str] = []
        have = set(known)
        for i, value in enumerate(maps[index]):
            text = shared.text(sympy.sympify(value), own, have)
            own += [f"y{i} = {text}", f"event[{places.image + i}] = y{i}"]
        own += ["if not tangents:", f"    return {index}"]
        store(places.jacobian, slopes[index], own, have)
        store(places.after, after[index], own, have)
        return [*own, f"return {index}"]

    for index, _ in sorted(outcomes, key=lambda found: found[0] not in rebounds):
        if index in rebounds:
            test = _completion(shared, rebounds[index], conditions[index], named[system.transitions[index].completes],
                               places.rest, lines, known)  # fmt: skip
            lines += [f"if {test}:", *(f"    {line}" for line in branch(index)), f"event[{places.rest}] = -1.0"]
        elif conditions[index] == sympy.true:
            return [*lines, *branch(index)]
        else:
            test = shared.test(conditions[index], lines, known)
            lines += [f"if {test}:", *(f"    {line}" for line in branch(index))]
    return [*lines, "return -1"]


def _onto_guard(system: "HybridSystem", printer: ExpressionPrinter, event: "Event") -> list[str]:
    """Lines that put the state on the guard, along its gradient in the scales of the states.

    A guard that is met at a multiple root tells nothing about how far away it is: there the state stays.
    """
    gradient = guard_gradient(system, event.guard)
    moving = [i for i in range(len(system.states)) if gradient[i] != 0]
    lines = [f"value = {printer.doprint(event.guard)}"]
    for i in moving:
        lines += [f"g{i} = {printer.doprint(gradient[i])}", f"d{i} = g{i} * scale[{i}] * scale[{i}]"]
    lines += [f"square = {' + '.join(f'd{i} * g{i}' for i in moving) or '0.0'}"]
    lines += [f"near = {ONTO} * tolerance", "if square > 0.0 and value * value <= near * near * square:"]
    for i in moving:
        lines += [f"    x{i} -= value * d{i} / square", f"    x[{i}] = x{i}"]
    return lines if moving else []


def _completion(
    shared: _Shared,
    motion: tuple[Any, Any, Any],
    condition: Any,
    rebounding: Any,
    rest: int,
    lines: list[str],
    known: set[Any],
) -> str:
    """Test that the rebounds to come take a negligible time, which goes into ``event[rest]``.

    With the normal speeds v before and w after a rebound and the acceleration a they last 2 w/a (1 + e + ..), e = -w/v.
    """
    sign = "" if rebounding.direction > 0 else "-"
    for name, value in zip(("incoming", "outgoing", "pull"), motion, strict=True):
        text = shared.text(sympy.sympify(value), lines, known)
        lines.append(f"{name} = {text}")
    lines.append("last = 0.0 if outgoing == 0.0 else -2.0 * outgoing * incoming / (pull * (incoming + outgoing))")
    lines.append(f"event[{rest}] = last")
    tests = [f"{sign}pull > 0.0", f"{sign}outgoing <= 0.0", f"{sign}(incoming + outgoing) >= 0.0"]
    tests.append("last * last * abs(pull) <= tolerance")
    if condition != sympy.true:
        tests.append(f"({shared.test(condition, lines, known)})")
    return " and ".join(tests)
