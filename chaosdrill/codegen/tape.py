"""Expressions become a tape of elementary operations, each with a Taylor recurrence.

A node is a constant (depends on parameters only), a state, time, or an operation on earlier nodes. Equal expressions
share one node.
"""

from dataclasses import dataclass, field
from typing import Any

import sympy

from chaosdrill.model.places import UnsupportedError
from chaosdrill.model.special import positive_power

POSITIVE = "positive"
"""Name of a power that is zero where its base is not positive."""


@dataclass(frozen=True)
class Node:
    """One elementary operation.

    ``op`` is one of ``state``, ``time``, ``linear``, ``mul``, ``square``, ``div``, ``power``, ``log`` and ``integral``;
    an ``integral`` node f(a) obeys f' = sign * slope * a', where ``slope`` is another node (exp, sin, atan, ...).
    """

    op: str
    args: tuple[int, ...] = ()
    name: str = ""
    value: Any = None
    weights: tuple[Any, ...] = ()


Entry = dict[int | None, Any]
Gradient = dict[int, Entry]


@dataclass
class Tape:
    """A list of nodes in the order of their evaluation."""

    states: tuple[Any, ...]
    time: Any
    nodes: list[Node] = field(default_factory=list)
    slopes: dict[int, tuple[int, int]] = field(default_factory=dict)
    _seen: dict[Any, int] = field(default_factory=dict)
    depths: dict[int, int] = field(default_factory=dict)
    _gradients: dict[int, "Gradient"] = field(default_factory=dict)

    def add(self, node: Node) -> int:
        """Index of the node, new or already there."""
        if node not in self._seen:
            self._seen[node] = len(self.nodes)
            self.nodes.append(node)
        return self._seen[node]

    def is_constant(self, expression: Any) -> bool:
        """Whether the expression depends on parameters only."""
        moving = set(self.states) | ({self.time} if self.time is not None else set())
        return not expression.free_symbols & moving

    def lower(self, expression: Any) -> int:
        """Index of the node that holds the expression."""
        expression = sympy.sympify(expression)
        if self.is_constant(expression):
            return self.add(Node("linear", value=expression))
        if expression in self.states:
            return self.add(Node("state", name=expression.name, value=self.states.index(expression)))
        if self.time is not None and expression == self.time:
            return self.add(Node("time"))
        if expression.is_Add:
            return self._sum(expression)
        if expression.is_Mul:
            return self._product(expression)
        if expression.is_Pow:
            return self._power(expression.base, expression.exp)
        return self._function(expression)

    def is_number(self, index: int) -> bool:
        """Whether a node depends on parameters only."""
        node = self.nodes[index]
        return node.op == "linear" and not node.args

    def turning(self, index: int) -> Any:
        """Rate of the argument of a sine or cosine that is linear in time; None for any other node."""
        node = self.nodes[index]
        return self.affine_rate(node.args[0]) if node.op == "integral" and node.name in ("sin", "cos") else None

    def gradient(self, index: int) -> "Gradient":
        """Derivatives of a node by the states that it depends on.

        Returns
        -------
        dict of int to dict
            For each of these states its derivative as weights of nodes; the weight of ``None`` stands alone.
        """
        if index not in self._gradients:
            self._gradients[index] = self._gradient(self.nodes[index], index)
        return self._gradients[index]

    def _gradient(self, node: Node, index: int) -> "Gradient":
        if node.op == "state":
            return {node.value: {None: sympy.Integer(1)}}
        if node.op == "time":
            return {}
        result: Gradient = {}
        for part, factor in self._partials(node, index):
            for state, entry in self.gradient(part).items():
                total = result.setdefault(state, {})
                for found, weight in self._times(entry, factor).items():
                    total[found] = total.get(found, sympy.Integer(0)) + weight
        kept = {state: {k: w for k, w in entry.items() if w != 0} for state, entry in result.items()}
        return {state: entry for state, entry in kept.items() if entry}

    def _partials(self, node: Node, index: int) -> list[tuple[int, "Entry"]]:
        """What a node is made of, and its derivative by each."""
        one, a = sympy.Integer(1), node.args
        if node.op == "linear":
            return [(i, {None: w}) for i, w in zip(a, node.weights, strict=True)]
        if node.op == "mul":
            return [(a[0], {a[1]: one}), (a[1], {a[0]: one})]
        if node.op == "square":
            return [(a[0], {a[0]: 2 * one})]
        if node.op == "integral":
            slope, sign = self.slopes[index]
            return [(a[0], {slope: sign * one})]
        if node.op == "power":
            return [(a[0], {self._power_of(a[0], node.value - 1, node.name): node.value})]
        inverse = self._divide(self.lower(one), a[-1])
        if node.op == "log":
            return [(a[0], {inverse: one})]
        return [(a[0], {inverse: one}), (a[1], {self._multiply(index, inverse): -one})]

    def _times(self, entry: "Entry", factor: "Entry") -> "Entry":
        """The product of a weighted sum of nodes and of one weighted node."""
        ((node, weight),) = factor.items()
        result: Entry = {}
        for other, own in entry.items():
            constant, parts = sympy.Integer(0), {None if node is None else node: sympy.Integer(1)}
            if node is None:
                parts = {other: sympy.Integer(1)}
            elif other is not None:
                parts = {self._multiply(node, other): sympy.Integer(1)}
            elif len(self.nodes[node].args) <= 1:
                constant, parts = self._parts(node)  # type: ignore[assignment]
            for found, part in {None: constant, **parts}.items():
                if part != 0:
                    result[found] = result.get(found, sympy.Integer(0)) + own * weight * part
        return result

    def entry(self, terms: "Entry") -> tuple[Any, int | None, Any]:
        """A weighted sum of nodes as a constant, one node and its weight."""
        constant = terms.get(None, sympy.Integer(0))
        nodes = {index: weight for index, weight in terms.items() if index is not None}
        if not nodes:
            return constant, None, sympy.Integer(0)
        if len(nodes) == 1:
            ((index, weight),) = nodes.items()
            return constant, index, weight
        made = Node("linear", tuple(nodes), value=sympy.Integer(0), weights=tuple(nodes.values()))
        return constant, self.add(made), sympy.Integer(1)

    def affine_rate(self, index: int) -> Any:
        """The rate of a node that is linear in time and names no state; None for any other node."""
        node = self.nodes[index]
        if node.op == "time":
            return sympy.Integer(1)
        if node.op != "linear":
            return None
        rates = [self.affine_rate(i) for i in node.args]
        if not rates or any(rate is None for rate in rates):
            return None
        return sum(w * rate for w, rate in zip(node.weights, rates, strict=True))

    def _sum(self, expression: Any) -> int:
        constant: Any = sympy.Integer(0)
        terms: dict[int, Any] = {}
        for term in expression.args:
            if self.is_constant(term):
                constant += term
                continue
            weight, rest = term.as_independent(*self._moving(), as_Add=False)
            offset, parts = self._parts(self.lower(rest))
            constant += weight * offset
            for index, part in parts.items():
                terms[index] = terms.get(index, sympy.Integer(0)) + weight * part
        terms = {index: weight for index, weight in terms.items() if weight != 0}
        return self.add(Node("linear", tuple(terms), value=constant, weights=tuple(terms.values())))

    def _parts(self, index: int) -> tuple[Any, dict[int, Any]]:
        """A node as a constant and weighted nodes: sums of sums become one, which waits for less."""
        node = self.nodes[index]
        if node.op == "linear":
            return node.value, dict(zip(node.args, node.weights, strict=True))
        return sympy.Integer(0), {index: sympy.Integer(1)}

    def _product(self, expression: Any) -> int:
        weight, rest = expression.as_independent(*self._moving(), as_Add=False)
        if weight != 1:
            offset, parts = self._parts(self.lower(rest))
            weights = tuple(weight * part for part in parts.values())
            return self.add(Node("linear", tuple(parts), value=weight * offset, weights=weights))
        above = [f for f in rest.args if not _is_denominator(f)]
        below = [1 / f for f in rest.args if _is_denominator(f)]
        index = self._chain(above) if above else None
        if not below:
            return index  # type: ignore[return-value]
        divisor = self._chain(below)
        if index is None:
            return self._divide(self.lower(sympy.Integer(1)), divisor)
        return self._divide(index, divisor)

    def _chain(self, factors: list[Any]) -> int:
        index = self.lower(factors[0])
        for factor in factors[1:]:
            index = self._multiply(index, self.lower(factor))
        return index

    def _multiply(self, left: int, right: int) -> int:
        if left == right:
            return self.add(Node("square", (left,)))
        return self.add(Node("mul", (min(left, right), max(left, right))))

    def _divide(self, above: int, below: int) -> int:
        return self.add(Node("div", (above, below)))

    def _power(self, base: Any, exponent: Any, name: str = "") -> int:
        if not self.is_constant(exponent):
            return self.lower(sympy.exp(exponent * sympy.log(base)))
        if base == sympy.E:
            return self._function(sympy.exp(exponent, evaluate=False))
        if exponent.is_Float and float(exponent).is_integer():
            exponent = sympy.Integer(int(exponent))
        if exponent == 0:
            return self.lower(sympy.Integer(1))
        if exponent.is_Integer and exponent > 0:
            index = self.lower(base)
            result = index if exponent % 2 else None
            power = index
            for bit in bin(int(exponent))[2:][::-1][1:]:
                power = self._multiply(power, power)
                if bit == "1":
                    result = power if result is None else self._multiply(result, power)
            return result  # type: ignore[return-value]
        if exponent.is_Integer:
            return self._divide(self.lower(sympy.Integer(1)), self.lower(base**-exponent))
        return self._power_of(self.lower(base), exponent, name)

    def _power_of(self, base: int, exponent: Any, name: str = "") -> int:
        if exponent == 0:
            return self.lower(sympy.Integer(1))
        return base if exponent == 1 else self.add(Node("power", (base,), name, exponent))

    def _function(self, expression: Any) -> int:
        if isinstance(expression, sympy.exp):
            return self._integral("exp", self.lower(expression.args[0]))
        if isinstance(expression, sympy.log):
            return self.add(Node("log", (self.lower(expression.args[0]),)))
        if isinstance(expression, positive_power):
            return self._power(*expression.args, POSITIVE)
        name = type(expression).__name__
        if name not in _SLOPE or len(expression.args) != 1:
            raise UnsupportedError(
                expression,
                f": {name} has no Taylor series here; a function with kinks or jumps belongs into modes "
                f"and guards, any other must be written with {', '.join(sorted(_SLOPE))}, exp, log and powers",
            )
        return self._integral(name, self.lower(expression.args[0]))

    def _integral(self, name: str, argument: int) -> int:
        index = self.add(Node("integral", (argument,), name=name))
        if index not in self.slopes:
            if name == "exp":
                self.slopes[index] = (index, 1)
            elif name in _PARTNER:
                partner = self.add(Node("integral", (argument,), name=_PARTNER[name][0]))
                self.slopes[index] = (partner, _PARTNER[name][1])
                back = _PARTNER[_PARTNER[name][0]]
                self.slopes[partner] = (index, back[1])
            else:
                self.slopes[index] = (self._slope_node(name, index, argument), 1)
        return index

    def _slope_node(self, name: str, index: int, argument: int) -> int:
        one = sympy.Integer(1)
        if name in ("tan", "tanh"):
            square = self.add(Node("square", (index,)))
            sign = one if name == "tan" else -one
            return self.add(Node("linear", (square,), value=one, weights=(sign,)))
        square = self.add(Node("square", (argument,)))
        sign = -one if name in ("asin", "acos", "atanh") else one
        inner = self.add(Node("linear", (square,), value=one, weights=(sign,)))
        if name in ("atan", "atanh"):
            return self._divide(self.lower(one), inner)
        root = self._power_of(inner, -sympy.Rational(1, 2))
        if name == "acos":
            return self.add(Node("linear", (root,), value=sympy.Integer(0), weights=(-one,)))
        return root

    def _moving(self) -> tuple[Any, ...]:
        return (*self.states, *((self.time,) if self.time is not None else ()))


_PARTNER = {"sin": ("cos", 1), "cos": ("sin", -1), "sinh": ("cosh", 1), "cosh": ("sinh", 1)}
_SLOPE = {"sin", "cos", "tan", "sinh", "cosh", "tanh", "asin", "acos", "atan", "asinh", "atanh"}


def _is_denominator(factor: Any) -> bool:
    return bool(factor.is_Pow and factor.exp.is_Integer and factor.exp < 0)
