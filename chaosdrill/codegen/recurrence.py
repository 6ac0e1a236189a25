"""The recurrences of a tape's nodes, four orders a pass, as Python source.

After Jorba and Zou 2005, doi:10.1080/10586458.2005.10128904. A product of series costs a sum that grows with the order,
and every order waits for the one before it. So the orders 4 m to 4 m + 3 are done in one pass: what they need of orders
below 4 m is summed for all four of them at once, in chains that depend on nothing new, and what they need of each other
stays in registers.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from chaosdrill.codegen.constants import Constants
    from chaosdrill.codegen.tape import Tape

PASS = 4
"""Orders done in one pass."""

_START = {"asinh": "math.asinh", "acos": "math.acos", "asin": "math.asin", "atan": "math.atan", "atanh": "math.atanh"}


@dataclass(frozen=True)
class Convolution:
    """Sum of left[j] * right[k - j] over 0 < j < k, of two rows of the workspace.

    ``newest_left`` and ``newest_right`` are the expressions of their coefficients of the order at hand.
    """

    left: str
    right: str
    newest_left: str
    newest_right: str

    @property
    def name(self) -> str:
        """What its variables begin with."""
        return f"{self.left}{self.right}"

    def begin(self) -> list[str]:
        """Registers of the last three coefficients of either side."""
        return [f"{self.name}{side}{i} = 0.0" for side in "lr" for i in (1, 2, 3)]

    def shift(self) -> list[str]:
        """The order is over: what was newest is one order old."""
        lines = []
        for side, newest in (("l", self.newest_left), ("r", self.newest_right)):
            lines += [f"{self.name}{side}3 = {self.name}{side}2", f"{self.name}{side}2 = {self.name}{side}1"]
            lines.append(f"{self.name}{side}1 = {newest}")
        return lines

    def keep(self) -> list[str]:
        """After the orders 1, 2, 3: the coefficients that every later order multiplies."""
        return [f"{self.name}{side.upper()}{i} = {self.name}{side}{PASS - i}" for side in "lr" for i in (1, 2, 3)]

    def old(self) -> list[str]:
        """Sums of the pass over all pairs of which neither is among the first three or of this pass."""
        lanes = range(PASS)
        lines = [f"{self.name}_{i} = 0.0" for i in lanes]
        lines += ["for i in range(base - 8):", f"    e = {self.left}[uint64(base - 5 - i)]"]
        lines += [f"    {self.name}_{i} += e * {self.right}[i + {5 + i}]" for i in lanes]
        lines.append("if base > 4:")
        for age in (4, 3, 2, 1):
            lines.append(f"    e = {self.left}[uint64(base - {age})]")
            lines += [f"    {self.name}_{i} += e * {self.right}[{age + i}]" for i in lanes]
        return lines

    def first(self, k: int) -> str:
        """The sum at order k = 1, 2, 3."""
        n = self.name
        return {1: "0.0", 2: f"{n}l1 * {n}r1", 3: f"{n}l2 * {n}r1 + {n}l1 * {n}r2"}[k]

    def later(self, lane: int) -> str:
        """The sum at order base + lane, the youngest terms last."""
        n = self.name
        terms = [f"{n}_{lane}", f"{n}L3 * {n}r3", f"{n}L2 * {n}r2"]
        terms += [f"{n}l{i} * {n}R{i}" for i in range(lane, 0, -1)]
        return " + ".join([*terms, f"{n}L1 * {n}r1"])


class Recurrences:
    """Source of single nodes.

    Parameters
    ----------
    tape : Tape
        The operations.
    rows, slope_rows : dict of int to int
        Workspace rows of the coefficients of a node, and of those of its derivative.
    constants : Constants
        What stands for expressions of parameters.
    """

    def __init__(self, tape: "Tape", rows: dict[int, int], slope_rows: dict[int, int], constants: "Constants") -> None:
        self.tape = tape
        self.rows = rows
        self.slope_rows = slope_rows
        self.constants = constants

    def affine(self, index: int) -> Any:
        """Rate of the argument of a sine or cosine that is linear in time; None for any other node."""
        node = self.tape.nodes[index]
        return self.tape.affine_rate(node.args[0]) if node.op == "integral" and node.name in ("sin", "cos") else None

    def is_number(self, index: int) -> bool:
        """Whether a node depends on parameters only."""
        node = self.tape.nodes[index]
        return node.op == "linear" and not node.args

    def value(self, index: int) -> str:
        """What stands for a node's coefficient of the order at hand."""
        return self.constants.text(self.tape.nodes[index].value) if self.is_number(index) else f"v{index}"

    def times(self, weight: Any) -> str:
        """A factor and its multiplication sign."""
        return "" if weight == 1 else f"{self.constants.text(weight)} * "

    def factor(self, weight: Any) -> str:
        """A multiplication sign and a factor."""
        return "" if weight == 1 else f" * {self.constants.text(weight)}"

    def start(self, index: int) -> str:
        """Source of coefficient 0."""
        node = self.tape.nodes[index]
        a = [self.value(i) for i in node.args]
        if node.op == "state":
            return f"x[{node.value}]"
        if node.op == "time":
            return "t"
        if node.op == "linear":
            terms = [f"{self.times(w)}{v}" for w, v in zip(node.weights, a, strict=True)]
            return " + ".join([self.constants.text(node.value), *terms] if node.value != 0 else terms)
        if node.op == "mul":
            return f"{a[0]} * {a[1]}"
        if node.op == "square":
            return f"{a[0]} * {a[0]}"
        if node.op == "div":
            return f"{a[0]} / {a[1]}"
        if node.op == "power":
            return f"{a[0]} ** {self.constants.text(node.value)}"
        if node.op == "log":
            return f"math.log({a[0]})"
        return f"{_START.get(node.name, 'math.' + node.name)}({a[0]})"

    def convolution(self, index: int) -> Convolution | None:
        """The convolution in a node's recurrence, if it has one."""
        node = self.tape.nodes[index]
        if node.op in ("mul", "square"):
            a, b = node.args[0], node.args[-1]
            return Convolution(f"h{self.rows[a]}", f"h{self.rows[b]}", f"v{a}", f"v{b}")
        if node.op == "div":
            return Convolution(f"h{self.rows[node.args[1]]}", f"h{self.rows[index]}", f"v{node.args[1]}", f"v{index}")
        if node.op == "integral" and self.affine(index) is None:
            slope, a = self.tape.slopes[index][0], node.args[0]
            return Convolution(f"h{self.slope_rows[a]}", f"h{self.rows[slope]}", f"m{a}", f"v{slope}")
        return None

    def factors(self, index: int) -> list[int]:
        """Nodes whose coefficient 0 multiplies newer ones in a node's recurrence."""
        node = self.tape.nodes[index]
        if node.op in ("mul", "square"):
            return list(node.args)
        if node.op in ("div", "power"):
            return [index, node.args[-1]]
        if node.op == "log":
            return list(node.args)
        return [self.tape.slopes[index][0]] if node.op == "integral" and self.affine(index) is None else []

    def order(self, index: int, inner: str, time: str) -> list[str]:
        """Source of coefficient k >= 1; ``inner`` is the value of its convolution, ``time`` coefficient k of time."""
        node = self.tape.nodes[index]
        out = f"v{index}"
        row = f"h{self.rows[index]}" if index in self.rows else ""
        a = [f"h{self.rows[i]}" if i in self.rows else "" for i in node.args]
        if node.op == "state":
            return [f"{out} = y{node.value}"]
        if node.op == "time":
            return [f"{out} = {time}"]
        if node.op == "linear":
            return [f"{out} = {' + '.join(f'{self.times(w)}v{i}' for w, i in self.terms(index))}"]
        if node.op in ("mul", "square"):
            b = node.args[-1]
            return [f"{out} = {inner} + z{node.args[0]} * v{b} + v{node.args[0]} * z{b}"]
        if node.op == "div":
            above = "0.0" if self.is_number(node.args[0]) else f"v{node.args[0]}"
            return [f"{out} = ({above} - ({inner}) - v{node.args[1]} * z{index}) / z{node.args[1]}"]
        if node.op == "power":
            exponent = self.constants.text(node.value)
            return [
                *_sum(f"({exponent} * (k - j) - j) * {a[0]}[uint64(k - j)] * {row}[j]"),
                f"{out} = (ik * s + {exponent} * v{node.args[0]} * z{index}) / z{node.args[0]}",
            ]
        if node.op == "log":
            return [
                *_sum(f"j * {row}[j] * {a[0]}[uint64(k - j)]"),
                f"{out} = (v{node.args[0]} - ik * s) / z{node.args[0]}",
            ]
        slope, sign = self.tape.slopes[index]
        minus = "-" if sign < 0 else ""
        rate = self.affine(index)
        if rate is not None:
            return [f"{out} = {minus}ik * {self.constants.text(rate)} * o{slope}"]
        scaled = self.scaled(index)
        newest = f"v{node.args[0]} * z{slope}" if scaled is None else f"v{scaled[0]} * w{index}"
        return [f"{out} = {minus}(ik * ({inner}) + {newest})"]

    def scaled(self, index: int) -> tuple[int, str] | None:
        """Of a function of a multiple of one node: that node, and the factor between their newest coefficients.

        The factor, the multiple times the slope at the start, is the same at every order, so that the function need not
        wait for its argument.
        """
        node = self.tape.nodes[index]
        if node.op != "integral" or self.affine(index) is not None:
            return None
        argument = self.tape.nodes[node.args[0]]
        if argument.op != "linear" or len(argument.args) != 1:
            return None
        return argument.args[0], f"{self.times(argument.weights[0])}z{self.tape.slopes[index][0]}"

    def terms(self, index: int) -> list[tuple[Any, int]]:
        """Weights and nodes of a sum, those that come late at the end."""
        node = self.tape.nodes[index]
        return sorted(zip(node.weights, node.args, strict=True), key=lambda term: self.depth(term[1]))

    def depth(self, index: int) -> int:
        """How many operations a node's newest coefficient waits for."""
        node = self.tape.nodes[index]
        if node.op in ("state", "time") or self.affine(index) is not None or self.is_number(index):
            return 0
        scaled = self.scaled(index)
        return 1 + max(self.depth(a) for a in (node.args if scaled is None else scaled[:1]))


def _sum(term: str) -> list[str]:
    return ["s = 0.0", "for j in range(1, k):", f"    s += {term}"]


def passes(
    nodes: list[int],
    recurrences: Recurrences,
    before: list[str],
    after: list[str],
    store: dict[int, list[str]],
) -> list[str]:
    """Lines that run all orders from 1 to the multiple of four above ``order``, less one.

    Parameters
    ----------
    nodes : list of int
        Nodes in the order of their evaluation.
    recurrences : Recurrences
        Their recurrences.
    before, after : list of str
        Lines at the beginning and at the end of every order.
    store : dict of int to list of str
        Lines that keep a node's coefficient.
    """
    found = {index: c for index in nodes if (c := recurrences.convolution(index)) is not None}
    convolutions = {c.name: c for c in found.values()}.values()
    turning = [recurrences.tape.slopes[i][0] for i in nodes if recurrences.affine(i) is not None]

    def one_order(k: int | None, lane: int, time: str) -> list[str]:
        lines = [*before, *(f"o{i} = v{i}" for i in turning)]
        for index in nodes:
            c = found.get(index)
            inner = "" if c is None else c.first(k) if k is not None else c.later(lane)
            lines += [*recurrences.order(index, inner, time), *store.get(index, [])]
        return lines + after + [line for c in convolutions for line in c.shift()]

    lines = [f"z{i} = v{i}" for i in sorted({i for index in nodes for i in recurrences.factors(index)})]
    lines += [f"w{i} = {scaled[1]}" for i in nodes if (scaled := recurrences.scaled(i)) is not None]
    if not convolutions:
        loop = ["ik = RECIPROCAL[uint64(k)]", *one_order(None, 0, "1.0 if k == 1 else 0.0")]
        return [*lines, "for k in range(1, order + 1):", *(f"    {line}" for line in loop)]
    lines += [line for c in convolutions for line in c.begin()]
    for k in range(1, PASS):
        lines += [f"k = {k}", f"ik = {1.0 / k!r}", *one_order(k, k, "1.0" if k == 1 else "0.0")]
    lines += [line for c in convolutions for line in c.keep()]
    loop = [line for c in convolutions for line in c.old()]
    for lane in range(PASS):
        loop += [f"k = base + {lane}", "ik = RECIPROCAL[uint64(k)]", *one_order(None, lane, "0.0")]
    return [*lines, f"for base in range({PASS}, order + 1, {PASS}):", *(f"    {line}" for line in loop)]
