"""Expressions as a tape of elementary operations, each with a Taylor recurrence.

A node is a constant (depends on parameters only), a state, time, or an operation on earlier nodes. Equal expressions
share one node.
"""

from dataclasses import dataclass, field
from typing import Any

import sympy

from chaosdrill.codegen.tuning import TUNING
from chaosdrill.model.special import SPECIAL, positive_power

POSITIVE = "positive"
"""Name of a power that is zero where its base is not positive."""

PATH = "path"
"""Name of the integral of a special function's slope along one of its arguments, from 0."""

SECH, LOGISTIC = "sech", "logistic"
"""Names of cosh(x) and 1 + exp(x) in a divisor: the tails of pulses and gates are zero to doubles where these are
larger than any of them."""


@dataclass(frozen=True)
class Node:
    """One elementary operation.

    ``op``: ``state``, ``time``, ``linear``, ``mul``, ``square``, ``div``, ``power``, ``log``, ``integral``, ``special``
    or ``expanded``. An ``integral`` node f(a) obeys f' = sign * slope * a', where ``slope`` is another node.
    A ``special`` node has its ``value`` arguments, then a path for each of those that move; it begins with the
    function's value, and goes on as the sum of its paths. An ``expanded`` node is the derivative of order ``value`` by
    its first argument of a function whose code gives its Taylor coefficients.
    """

    op: str
    args: tuple[int, ...] = ()
    name: str = ""
    value: Any = None
    weights: tuple[Any, ...] = ()


Entry = dict[int | None, Any]
"""A weighted sum of nodes, by nodes; the weight of None stands alone."""
Gradient = dict[int, Entry]
"""Derivatives by states, whose keys are their numbers, and by kept nodes, whose keys follow."""


@dataclass
class Tape:
    """A list of nodes in the order of their evaluation."""

    states: tuple[Any, ...]
    time: Any
    still: frozenset[Any] = frozenset()
    """States that do not move."""
    nodes: list[Node] = field(default_factory=list)
    slopes: dict[int, tuple[int, int]] = field(default_factory=dict)
    _seen: dict[Any, int] = field(default_factory=dict)
    _stands: dict[int, bool] = field(default_factory=dict)
    depths: dict[int, int] = field(default_factory=dict)
    kept: list[int] = field(default_factory=list)
    """Nodes whose variations are computed before others are made of them; see `keep`."""
    _gradients: dict[int, "Gradient"] = field(default_factory=dict)
    _places: dict[int, int] = field(default_factory=dict)
    _long: list[int] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._numbers = {x: i for i, x in enumerate(self.states)}
        self._moving = {*self.states, *((self.time,) if self.time is not None else ())}

    def add(self, node: Node) -> int:
        """Index of the node, new or already there."""
        if node not in self._seen:
            self._seen[node] = len(self.nodes)
            self.nodes.append(node)
        return self._seen[node]

    def is_constant(self, expression: Any) -> bool:
        """Whether the expression depends on parameters only."""
        return self._moving.isdisjoint(expression.free_symbols)

    def lower(self, expression: Any) -> int:
        """Index of the node that holds the expression."""
        expression = sympy.sympify(expression)
        if self.is_constant(expression):
            return self.add(Node("linear", value=expression))
        if expression in self._numbers:
            return self.add(Node("state", name=expression.name, value=self._numbers[expression]))
        if self.time is not None and expression == self.time:
            return self.add(Node("time"))
        if expression.is_Add:
            return self._sum(expression)
        if expression.is_Mul:
            return self._product(expression)
        if expression.is_Pow:
            return self._power(expression.base, expression.exp)
        return self._function(expression)

    def arguments(self, index: int) -> tuple[int, ...]:
        """Arguments of a node."""
        node = self.nodes[index]
        return node.args[: node.value] if node.op == "special" else node.args

    def paths(self, index: int) -> tuple[int, ...]:
        """The integrals that a special function is the sum of."""
        node = self.nodes[index]
        return node.args[node.value :] if node.op == "special" else ()

    def is_number(self, index: int) -> bool:
        """Whether a node depends on parameters only."""
        node = self.nodes[index]
        return node.op == "linear" and not node.args

    def is_still(self, index: int) -> bool:
        """Whether a node is made of parameters and of states that do not move."""
        if index not in self._stands:
            node = self.nodes[index]
            if node.op == "state":
                self._stands[index] = self.states[node.value] in self.still
            else:
                self._stands[index] = node.op != "time" and all(self.is_still(i) for i in self.arguments(index))
        return self._stands[index]

    def scaled_by(self, index: int) -> int | None:
        """The argument of a product, or the divisor, that does not move and scales a series; None if there is none."""
        node = self.nodes[index]
        parts = node.args if node.op == "mul" else node.args[1:] if node.op == "div" else ()
        return None if self.is_still(index) else next((i for i in parts if self.is_still(i)), None)

    def is_known(self, index: int) -> bool:
        """Whether a node's coefficients follow from those of order 0 alone, or from the ones before."""
        return self.turning(index) is not None or (self.nodes[index].op == "expanded" and self.is_still(index))

    def turning(self, index: int) -> Any:
        """Rate of the argument of a sine or cosine that is linear in time; None for any other node."""
        node = self.nodes[index]
        return self.affine_rate(node.args[0]) if node.op == "integral" and node.name in ("sin", "cos") else None

    def keep(self, roots: list[int]) -> None:
        """Decide which nodes' variations are computed by themselves, instead of becoming entries of the Jacobian.

        The variations are a linear graph from those of the states to those of ``roots``. To eliminate a node from it
        costs an edge from each of its sources to each of its uses, which is more than both together where many
        share it, as the mean of a field. So a node is kept if its own edges cost less than those that would replace
        them; an edge is a product of series or of a number and a series. Nodes are decided in the order of their
        evaluation (Griewank and Walther 2008, chapters 9 and 10, doi:10.1137/1.9780898717761).
        """
        uses: dict[int, list[int]] = {}
        moving = sorted(i for i in self.reach(roots, slopes=False) if not self.is_number(i))
        for index in moving:
            node = self.nodes[index]
            cost = 1 if node.op == "linear" else TUNING.product
            for part in () if node.name == PATH else self.arguments(index):
                uses.setdefault(part, []).append(cost)
        self._gradients.clear()
        for index in moving:
            if self.nodes[index].op in ("state", "time") or index not in uses:
                continue
            own = [
                1 if all(node is None for node in entry) else TUNING.product for entry in self.gradient(index).values()
            ]
            eliminated = sum(max(edge, use) for edge in own for use in uses[index])
            if sum(own) + sum(uses[index]) < eliminated:
                self._places[index] = len(self.states) + len(self.kept)
                self.kept.append(index)

    def reach(self, roots: list[int], *, slopes: bool = True) -> set[int]:
        """Nodes, and all that they are made of; ``slopes``: also what integrals take from the slopes of functions."""
        seen: set[int] = set()
        stack = list(roots)
        while stack:
            index = stack.pop()
            if index not in seen:
                seen.add(index)
                stack.extend(self.nodes[index].args)
                if slopes and index in self.slopes:
                    stack.append(self.slopes[index][0])
        return seen

    def variation(self, index: int) -> "Gradient":
        """The gradient of a node where another is made of it."""
        if index in self._places:
            return {self._places[index]: {None: sympy.Integer(1)}}
        return self.gradient(index)

    def gradient(self, index: int) -> "Gradient":
        """Derivatives of a node by the states that it depends on, and by the kept nodes that it is made of.

        Each is given as weights of nodes; the weight of ``None`` stands alone.
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
            for state, entry in self.variation(part).items():
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
        if node.op == "special":
            return [(self.nodes[p].args[0], {self.slopes[p][0]: one}) for p in self.paths(index)]
        if node.op == "expanded":
            return [(a[0], {self.add(Node("expanded", a, node.name, node.value + 1)): one})]
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
            weight, rest = self._split(term)
            offset, parts = self._parts(self.lower(rest))
            constant += weight * offset
            for index, part in parts.items():
                terms[index] = terms.get(index, sympy.Integer(0)) + weight * part
        terms = {index: weight for index, weight in terms.items() if weight != 0}
        return self._linear(constant, terms)

    def _linear(self, constant: Any, terms: dict[int, Any]) -> int:
        """A sum; a long one that differs little from another is written as that one and the difference."""
        if len(terms) > TUNING.long_sum:
            for base in self._long[-TUNING.sums_alike :]:
                offset, rest = self.nodes[base].value, dict(terms)
                for index, weight in zip(self.nodes[base].args, self.nodes[base].weights, strict=True):
                    rest[index] = rest.get(index, sympy.Integer(0)) - weight
                rest = {index: weight for index, weight in rest.items() if weight != 0}
                if 2 * len(rest) < len(terms):
                    constant, terms = constant - offset, {base: sympy.Integer(1), **rest}
                    break
        found = self.add(Node("linear", tuple(terms), value=constant, weights=tuple(terms.values())))
        if len(terms) > TUNING.long_sum and found not in self._long:
            self._long.append(found)
        return found

    def _parts(self, index: int) -> tuple[Any, dict[int, Any]]:
        """A node as a constant and weighted nodes: sums of short sums become one, which waits for less."""
        node = self.nodes[index]
        if node.op == "linear" and len(node.args) <= TUNING.long_sum:
            return node.value, dict(zip(node.args, node.weights, strict=True))
        return sympy.Integer(0), {index: sympy.Integer(1)}

    def _product(self, expression: Any) -> int:
        weight, rest = self._split(expression)
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
            return self._power_of_whole(self.lower(base), exponent)
        if exponent.is_Integer and (whole := inverse_of(base)):
            return self._power_of_whole(self._integral(whole[0], self.lower(whole[1])), -exponent)
        if exponent.is_Integer:
            return self._divide(self.lower(sympy.Integer(1)), self.lower(base**-exponent))
        return self._power_of(self.lower(base), exponent, name)

    def _power_of_whole(self, base: int, exponent: Any) -> int:
        result = base if exponent % 2 else None
        power = base
        for bit in bin(int(exponent))[2:][::-1][1:]:
            power = self._multiply(power, power)
            if bit == "1":
                result = power if result is None else self._multiply(result, power)
        return result  # type: ignore[return-value]

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
        if name in SPECIAL:
            return self._special(name, expression)
        return self._integral(name, self.lower(expression.args[0]))

    def _special(self, name: str, expression: Any) -> int:
        moving = [i for i, a in enumerate(expression.args) if not self.is_constant(a)]
        arguments = tuple(self.lower(a) for a in expression.args)
        if SPECIAL[name].expanded:
            return self.add(Node("expanded", arguments, name, 0))
        paths = tuple(self.add(Node("integral", (arguments[i],), PATH, (name, i, arguments))) for i in moving)
        index = self.add(Node("special", (*arguments, *paths), name, len(arguments)))
        for i, path in zip(moving, paths, strict=True):
            if path not in self.slopes:
                # the slope names the function itself
                self.slopes[path] = (index, 1)
                self.slopes[path] = (self.lower(expression.fdiff(i + 1)), 1)
        return index

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
            elif name == SECH:
                self.slopes[index] = (self._multiply(index, self._integral("tanh", argument)), -1)
            elif name == LOGISTIC:
                square = self._multiply(index, index)
                weights = (sympy.Integer(1), sympy.Integer(-1))
                self.slopes[index] = (
                    self.add(Node("linear", (square, index), value=sympy.Integer(0), weights=weights)),
                    1,
                )
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

    def _split(self, expression: Any) -> tuple[Any, Any]:
        """A factor that depends on parameters only, and the rest."""
        numbers = [f for f in sympy.Mul.make_args(expression) if self.is_constant(f)]
        rest = [f for f in sympy.Mul.make_args(expression) if not self.is_constant(f)]
        return sympy.Mul(*numbers), rest[0] if len(rest) == 1 else sympy.Mul(*rest)


_PARTNER = {"sin": ("cos", 1), "cos": ("sin", -1), "sinh": ("cosh", 1), "cosh": ("sinh", 1)}


def inverse_of(base: Any) -> tuple[str, Any] | None:
    """The function that is one over this one, by its name, and its argument; None where a division is meant."""
    if isinstance(base, sympy.cosh):
        return SECH, base.args[0]
    if (
        base.is_Add
        and len(base.args) == 2
        and base.args[0] in (1, sympy.Float(1))
        and isinstance(base.args[1], sympy.exp)
    ):
        return LOGISTIC, base.args[1].args[0]
    return None


def _is_denominator(factor: Any) -> bool:
    return bool(factor.is_Pow and factor.exp.is_Integer and factor.exp < 0 and not inverse_of(factor.base))
