"""Taylor recurrences of one mode, written out as Python source.

After Jorba and Zou 2005, doi:10.1080/10586458.2005.10128904.

Row i of the workspace holds the coefficients of state i, then come those of the quadratures and of the guards, then the
history that products and functions need. At order k every recurrence reads orders up to k only, so one loop over k
serves all nodes.
"""

import re
from typing import TYPE_CHECKING, Any

import sympy

from chaosdrill.codegen.expression import ExpressionPrinter
from chaosdrill.codegen.tape import Tape
from chaosdrill.model.derive import jacobian

if TYPE_CHECKING:
    from chaosdrill.model.system import HybridSystem

_HISTORY = {"mul", "square", "div", "power", "log", "integral"}
_START = {"asinh": "math.asinh", "acos": "math.acos", "asin": "math.asin", "atan": "math.atan", "atanh": "math.atanh"}


class Constants:
    """Parameter-only expressions, computed once a run into the array that every kernel receives."""

    def __init__(self, system: "HybridSystem", printer: ExpressionPrinter) -> None:
        self.printer = printer
        self.first = len(system.parameters)
        self.expressions: list[Any] = []

    def text(self, expression: Any) -> str:
        """Source text that stands for the value of the expression."""
        expression = sympy.sympify(expression)
        if not expression.free_symbols:
            return self.printer.doprint(expression)
        if expression.is_Symbol:
            return self.printer.doprint(expression).replace("[", "").replace("]", "")
        if expression not in self.expressions:
            self.expressions.append(expression)
        return f"c{self.first + self.expressions.index(expression)}"


def with_constants(lines: list[str]) -> list[str]:
    """The lines after those that load the constants which they name."""
    used = sorted({int(i) for line in lines for i in re.findall(r"\bc(\d+)\b", line)})
    return [*(f"c{i} = c[{i}]" for i in used), *lines]


def _sum(indices: str, term: str) -> list[str]:
    """Lines that sum the inner terms of a convolution, without those of the newest coefficients."""
    return ["s = 0.0", f"for j in {indices}:", f"    s += {term}"]


def _inner(left: str, right: str) -> list[str]:
    """Lines that sum left[j] * right[k - j] over 0 < j < k in two chains, the newest coefficients last.

    What the next order waits for is then one product of numbers still in registers, not the whole sum.
    """
    return [
        "s = 0.0",
        "u = 0.0",
        "for j in range(2, k - 2, 2):",
        f"    s += {left}[j] * {right}[uint64(k - j)]",
        f"    u += {left}[j + 1] * {right}[uint64(k - j - 1)]",
        "if k > 3 and k % 2 == 0:",
        f"    s += {left}[uint64(k - 2)] * {right}[2]",
        "if k > 2:",
        f"    u += {left}[uint64(k - 1)] * {right}[1]",
        "s += u",
        "if k > 1:",
        f"    s += {left}[1] * {right}[uint64(k - 1)]",
    ]


class ModeSource:
    """The source of jet, Jacobian jet and tangent for one mode."""

    def __init__(self, system: "HybridSystem", mode: str, guards: list[Any], constants: Constants) -> None:
        self.constants = constants
        self.n = len(system.states)
        self.tape = Tape(system.states, system.time)
        field = system.modes[mode]
        self.rates = [self.tape.lower(field[s]) for s in system.states]
        self.rates += [self.tape.lower(q) for q in system.quadratures.values()]
        self.guards = [self.tape.lower(g) for g in guards]
        self.in_jet = self._reach([*self.rates, *self.guards])
        self._lower_jacobian(system, mode)
        wanted = {index for terms in self.products.values() for index, _ in terms}
        self.in_jacobian = self._reach(sorted(wanted)) - self.in_jet
        self._assign_rows(wanted)

    def _lower_jacobian(self, system: "HybridSystem", mode: str) -> None:
        """Split J into constants and weighted nodes: J_ij = constant_ij + sum of weight * node."""
        self.linear: dict[tuple[int, int], Any] = {}
        self.products: dict[tuple[int, int], list[tuple[int, Any]]] = {}
        matrix = jacobian(system, mode)
        for i in range(self.n):
            for j in range(self.n):
                entry = matrix[i, j]
                if entry == 0:
                    continue
                if self.tape.is_constant(entry):
                    self.linear[i, j] = entry
                    continue
                index = self.tape.lower(entry)
                node = self.tape.nodes[index]
                if node.op == "linear" and len(node.args) == 1:
                    if node.value != 0:
                        self.linear[i, j] = node.value
                    self.products[i, j] = [(node.args[0], node.weights[0])]
                else:
                    self.products[i, j] = [(index, sympy.Integer(1))]

    def _affine(self, index: int) -> Any:
        node = self.tape.nodes[index]
        return self.tape.affine_rate(node.args[0]) if node.op == "integral" and node.name in ("sin", "cos") else None

    def _reach(self, roots: list[int]) -> set[int]:
        seen: set[int] = set()
        stack = list(roots)
        while stack:
            index = stack.pop()
            if index in seen:
                continue
            seen.add(index)
            stack.extend(self.tape.nodes[index].args)
            if index in self.tape.slopes:
                stack.append(self.tape.slopes[index][0])
        return seen

    def _assign_rows(self, wanted: set[int]) -> None:
        need = set(wanted)
        for index in self.in_jet | self.in_jacobian:
            node = self.tape.nodes[index]
            if node.op in _HISTORY:
                need.add(index)
                if self._affine(index) is None:
                    need.update(node.args)
                if index in self.tape.slopes:
                    need.add(self.tape.slopes[index][0])
        if self.in_jacobian:
            need.update(i for k in self.in_jacobian for i in self.tape.nodes[k].args if i in self.in_jet)
        self.rows: dict[int, int] = {}
        free = len(self.rates) + len(self.guards)
        for index in sorted(need):
            node = self.tape.nodes[index]
            if node.op == "state":
                self.rows[index] = node.value
            elif node.op == "linear" and not node.args:
                continue
            else:
                self.rows[index] = free
                free += 1
        self.slope_rows: dict[int, int] = {}
        for index in sorted(self.in_jet | self.in_jacobian):
            node = self.tape.nodes[index]
            if node.op == "integral" and self._affine(index) is None and node.args[0] not in self.slope_rows:
                self.slope_rows[node.args[0]] = free
                free += 1
        self.row_count = free

    def _value(self, index: int) -> str:
        node = self.tape.nodes[index]
        return self.constants.text(node.value) if node.op == "linear" and not node.args else f"v{index}"

    def _is_number(self, index: int) -> bool:
        node = self.tape.nodes[index]
        return node.op == "linear" and not node.args

    def _start(self, index: int) -> str:
        """Source of coefficient 0."""
        node = self.tape.nodes[index]
        a = [self._value(i) for i in node.args]
        if node.op == "state":
            return f"x[{node.value}]"
        if node.op == "time":
            return "t"
        if node.op == "linear":
            terms = [f"{self._times(w)}{v}" for w, v in zip(node.weights, a, strict=True)]
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

    def _order(self, index: int) -> list[str]:
        """Source lines of coefficient k >= 1."""
        node = self.tape.nodes[index]
        out = f"v{index}"
        row = self.rows.get(index)
        a = [f"h{self.rows[i]}" if i in self.rows else "" for i in node.args]
        if node.op == "state":
            return [f"{out} = y{node.value}"]
        if node.op == "time":
            return [f"{out} = 1.0 if k == 1 else 0.0"]
        if node.op == "linear":
            terms = [f"{self._times(w)}v{i}" for w, i in zip(node.weights, node.args, strict=True)]
            return [f"{out} = {' + '.join(terms)}"]
        if node.op == "mul":
            x, y = (f"v{i}" for i in node.args)
            return [
                *_inner(a[0], a[1]),
                f"{out} = s + {a[0]}[0] * {y} + {x} * {a[1]}[0]",
            ]
        if node.op == "square":
            return [
                *_sum("range(1, (k + 1) // 2)", f"{a[0]}[j] * {a[0]}[uint64(k - j)]"),
                "s += s",
                "if k % 2 == 0:",
                f"    s += {a[0]}[uint64(k // 2)] * {a[0]}[uint64(k // 2)]",
                f"{out} = s + 2.0 * {a[0]}[0] * v{node.args[0]}",
            ]
        if node.op == "div":
            above = "0.0" if self._is_number(node.args[0]) else f"v{node.args[0]}"
            return [
                *_inner(a[1], f"h{row}"),
                f"{out} = ({above} - s - v{node.args[1]} * h{row}[0]) / {a[1]}[0]",
            ]
        if node.op == "power":
            exponent = self.constants.text(node.value)
            return [
                *_sum("range(1, k)", f"({exponent} * (k - j) - j) * {a[0]}[uint64(k - j)] * h{row}[j]"),
                f"{out} = (ik * s + {exponent} * v{node.args[0]} * h{row}[0]) / {a[0]}[0]",
            ]
        if node.op == "log":
            return [
                *_sum("range(1, k)", f"j * h{row}[j] * {a[0]}[uint64(k - j)]"),
                f"{out} = (v{node.args[0]} - ik * s) / {a[0]}[0]",
            ]
        slope, sign = self.tape.slopes[index]
        minus = "-" if sign < 0 else ""
        rate = self._affine(index)
        if rate is not None:
            return [f"{out} = {minus}ik * {self.constants.text(rate)} * h{self.rows[slope]}[uint64(k - 1)]"]
        return [
            *_inner(f"h{self.slope_rows[node.args[0]]}", f"h{self.rows[slope]}"),
            f"{out} = {minus}(ik * s + v{node.args[0]} * h{self.rows[slope]}[0])",
        ]

    def _ordered(self, nodes: set[int], order: bool) -> list[int]:
        """Nodes to evaluate, without plain numbers, and above order 0 without what only starts a sine in time."""
        kept = [i for i in sorted(nodes) if not self._is_number(i)]
        if not order:
            return kept
        users: dict[int, bool] = {i: i in self.rates or i in self.guards or i in self.rows for i in kept}
        for i in reversed(kept):
            if users[i] and self._affine(i) is None:
                for a in self.tape.nodes[i].args:
                    users[a] = True
        return [i for i in kept if users[i]]

    def _store(self, index: int, k: str) -> list[str]:
        lines = []
        if index in self.rows and self.tape.nodes[index].op != "state":
            lines.append(f"h{self.rows[index]}[{k}] = v{index}")
        if index in self.slope_rows and k != "0":
            lines.append(f"h{self.slope_rows[index]}[k] = k * v{index}")
        return lines

    def _rows_of(self, nodes: set[int]) -> list[int]:
        return sorted({table[i] for table in (self.rows, self.slope_rows) for i in nodes if i in table})

    def jet(self) -> list[str]:
        """Body of ``jet``: Taylor coefficients of states, quadratures and guards up to ``order``."""
        used = sorted({*range(len(self.rates) + len(self.guards)), *self._rows_of(self.in_jet)})
        lines = [f"h{r} = ws[{r}]" for r in used]
        lines += [f"h{i}[0] = x[{i}]" for i in range(self.n)]
        lines += [f"h{i}[0] = 0.0" for i in range(self.n, len(self.rates))]
        for index in self._ordered(self.in_jet, order=False):
            lines += [f"v{index} = {self._start(index)}", *self._store(index, "0")]
        first_guard = len(self.rates)
        lines += [f"h{first_guard + j}[0] = {self._value(g)}" for j, g in enumerate(self.guards)]
        moving = [i for i, r in enumerate(self.rates) if not self._is_number(r)]
        still = [i for i, r in enumerate(self.rates) if self._is_number(r)]
        lines += [f"r{i} = {self._value(self.rates[i])}" for i in range(len(self.rates))]
        loop = ["ik = RECIPROCAL[k]"]
        for i in range(len(self.rates)):
            loop += [f"y{i} = r{i} * ik", f"h{i}[k] = y{i}"]
        for index in self._ordered(self.in_jet, order=True):
            loop += [*self._order(index), *self._store(index, "k")]
        loop += [
            f"h{first_guard + j}[k] = {'0.0' if self._is_number(g) else f'v{g}'}" for j, g in enumerate(self.guards)
        ]
        loop += [f"r{i} = v{self.rates[i]}" for i in moving] + [f"r{i} = 0.0" for i in still]
        return with_constants([*lines, "for k in range(1, order + 1):", *(f"    {line}" for line in loop)])

    def jacobian_jet(self) -> list[str]:
        """Body of ``jacobian_jet``: coefficients of the Jacobian's entries that the jet does not already hold."""
        if not self.in_jacobian:
            return ["return"]
        inputs = {a for i in self.in_jacobian for a in self.tape.nodes[i].args if a in self.in_jet}
        slopes = {self.tape.slopes[i][0] for i in self.in_jacobian if i in self.tape.slopes}
        touched = self.in_jacobian | inputs | slopes
        lines = [f"h{r} = ws[{r}]" for r in self._rows_of(touched)]
        lines += [f"v{i} = h{self.rows[i]}[0]" for i in sorted(inputs) if i in self.rows]
        for index in self._ordered(self.in_jacobian, order=False):
            lines += [f"v{index} = {self._start(index)}", *self._store(index, "0")]
        loop = ["ik = RECIPROCAL[k]"]
        loop += [f"v{i} = h{self.rows[i]}[k]" for i in sorted(inputs) if i in self.rows]
        for index in self._ordered(self.in_jacobian, order=True):
            loop += [*self._order(index), *self._store(index, "k")]
        return with_constants([*lines, "for k in range(1, order + 1):", *(f"    {line}" for line in loop)])

    def tangent(self) -> list[str]:
        """Body of ``tangent``: coefficients of two solutions of the variational equation.

        They stand side by side in the n rows from ``row``, so that one pass over the Jacobian serves both.
        """
        pairs = sorted({(index, j) for (_, j), terms in self.products.items() for index, _ in terms})
        lines = [f"h{r} = ws[{r}]" for r in sorted({self.rows[i] for i, _ in pairs})]
        for i in range(self.n):
            lines += [f"w{i} = ws[row + {i}]", f"a{i} = first[{i}]", f"b{i} = second[{i}]"]
            lines += [f"w{i}[0] = a{i}", f"w{i}[1] = b{i}"]
        loop = ["ik = RECIPROCAL[k + 1]"]
        for index, j in pairs:
            row = self.rows[index]
            loop += ["s = 0.0", "u = 0.0", "s_odd = 0.0", "u_odd = 0.0", "for j in range(0, k - 1, 2):"]
            loop += [f"    e = h{row}[uint64(k - j)]", f"    f = h{row}[uint64(k - j - 1)]"]
            loop += [f"    s += e * w{j}[2 * j]", f"    u += e * w{j}[2 * j + 1]"]
            loop += [f"    s_odd += f * w{j}[2 * j + 2]", f"    u_odd += f * w{j}[2 * j + 3]", "if k % 2 == 1:"]
            loop += [f"    s += h{row}[1] * w{j}[uint64(2 * k - 2)]", f"    u += h{row}[1] * w{j}[uint64(2 * k - 1)]"]
            loop += [f"p{index}_{j} = s + s_odd + h{row}[0] * a{j}", f"q{index}_{j} = u + u_odd + h{row}[0] * b{j}"]
        for i in range(self.n):
            for vector, product in (("a", "p"), ("b", "q")):
                terms = [f"{self._times(w)}{vector}{j}" for (a, j), w in self.linear.items() if a == i]
                for (a, j), products in self.products.items():
                    if a == i:
                        terms += [f"{self._times(w)}{product}{index}_{j}" for index, w in products]
                loop.append(f"n{vector}{i} = " + (f"ik * ({' + '.join(terms)})" if terms else "0.0"))
        for i in range(self.n):
            loop += [f"a{i} = na{i}", f"b{i} = nb{i}", f"w{i}[2 * k + 2] = a{i}", f"w{i}[2 * k + 3] = b{i}"]
        return with_constants([*lines, "for k in range(order):", *(f"    {line}" for line in loop)])

    def _times(self, weight: Any) -> str:
        return "" if weight == 1 else f"{self.constants.text(weight)} * "
