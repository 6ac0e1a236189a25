"""Taylor coefficients of one mode, written out as Python source.

Row i of the workspace holds the coefficients of state i, then come those of the quadratures and of the guards, then the
history that products and functions need.
"""

from typing import TYPE_CHECKING, Any

import sympy

from chaosdrill.codegen.constants import Constants, with_constants
from chaosdrill.codegen.recurrence import Recurrences, passes
from chaosdrill.codegen.tape import Tape
from chaosdrill.model.derive import jacobian

if TYPE_CHECKING:
    from chaosdrill.model.system import HybridSystem

_HISTORY = {"mul", "square", "div", "power", "log", "integral"}


class ModeSource:
    """The source of jet and Jacobian jet for one mode, and the rows that they fill.

    Attributes
    ----------
    linear : dict of (int, int) to expression
        Entries of the Jacobian that depend on parameters only.
    products : dict of (int, int) to (int, expression)
        Node and weight, whose product the other entries have besides.
    """

    def __init__(self, system: "HybridSystem", mode: str, guards: list[Any], constants: Constants) -> None:
        self.n = len(system.states)
        self.tape = Tape(system.states, system.time)
        field = system.modes[mode]
        self.rates = [self.tape.lower(field[s]) for s in system.states]
        self.rates += [self.tape.lower(q) for q in system.quadratures.values()]
        self.guards = [self.tape.lower(g) for g in guards]
        self.rows: dict[int, int] = {}
        self.slope_rows: dict[int, int] = {}
        self.source = Recurrences(self.tape, self.rows, self.slope_rows, constants)
        self.in_jet = self._reach([*self.rates, *self.guards])
        self._lower_jacobian(system, mode)
        wanted = {index for index, _ in self.products.values()}
        self.in_jacobian = self._reach(sorted(wanted)) - self.in_jet
        self.row_count = self._assign_rows(wanted)

    def _lower_jacobian(self, system: "HybridSystem", mode: str) -> None:
        self.linear: dict[tuple[int, int], Any] = {}
        self.products: dict[tuple[int, int], tuple[int, Any]] = {}
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
                weight, constant = sympy.Integer(1), sympy.Integer(0)
                while self.tape.nodes[index].op == "linear" and len(self.tape.nodes[index].args) == 1:
                    node = self.tape.nodes[index]
                    constant += weight * node.value
                    weight *= node.weights[0]
                    index = node.args[0]
                if constant != 0:
                    self.linear[i, j] = constant
                self.products[i, j] = (index, weight)

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

    def _assign_rows(self, wanted: set[int]) -> int:
        """Give a row to every node whose history is read; returns the number of rows."""
        need = set(wanted)
        for index in self.in_jet | self.in_jacobian:
            node = self.tape.nodes[index]
            if node.op in _HISTORY and self.source.affine(index) is None:
                need.update([index, *node.args])
                if index in self.tape.slopes:
                    need.add(self.tape.slopes[index][0])
        need |= self._inputs()
        free = len(self.rates) + len(self.guards)
        for index in sorted(need):
            node = self.tape.nodes[index]
            if node.op == "state":
                self.rows[index] = node.value
            elif not self.source.is_number(index):
                self.rows[index] = free
                free += 1
        for index in sorted(self.in_jet | self.in_jacobian):
            node = self.tape.nodes[index]
            if node.op == "integral" and self.source.affine(index) is None and node.args[0] not in self.slope_rows:
                self.slope_rows[node.args[0]] = free
                free += 1
        return free

    def _inputs(self) -> set[int]:
        """Nodes of the jet from which the Jacobian's own nodes are made."""
        used = {a for i in self.in_jacobian for a in self.tape.nodes[i].args}
        used |= {self.tape.slopes[i][0] for i in self.in_jacobian if i in self.tape.slopes}
        return {i for i in used & self.in_jet if not self.source.is_number(i)}

    def _ordered(self, nodes: set[int], order: bool) -> list[int]:
        """Nodes to evaluate, without plain numbers, and above order 0 without what only starts a sine in time."""
        kept = [i for i in sorted(nodes) if not self.source.is_number(i)]
        if not order:
            return kept
        used = {i for i in kept if i in self.guards or i in self.rows}
        for rate in self.rates:
            node = self.tape.nodes[rate]
            used.update(node.args if node.op == "linear" else (rate,))
        for i in reversed(kept):
            if i in used:
                used.update(self.tape.nodes[i].args if self.source.affine(i) is None else ())
        used.update(self.tape.slopes[i][0] for i in tuple(used) if i in self.tape.slopes)
        return [i for i in kept if i in used]

    def _store(self, nodes: list[int]) -> dict[int, list[str]]:
        """Lines that keep coefficient k of each node that has a row."""
        lines: dict[int, list[str]] = {}
        for index in nodes:
            lines[index] = []
            if index in self.rows and self.tape.nodes[index].op != "state":
                lines[index].append(f"h{self.rows[index]}[k] = v{index}")
            if index in self.slope_rows:
                lines[index] += [f"m{index} = k * v{index}", f"h{self.slope_rows[index]}[k] = m{index}"]
        return lines

    def _begin(self, nodes: set[int]) -> list[str]:
        """Lines for coefficient 0."""
        lines = []
        for index in self._ordered(nodes, order=False):
            lines.append(f"v{index} = {self.source.start(index)}")
            if index in self.rows and self.tape.nodes[index].op != "state":
                lines.append(f"h{self.rows[index]}[0] = v{index}")
        return lines

    def _rows_of(self, nodes: set[int]) -> list[int]:
        return sorted({table[i] for table in (self.rows, self.slope_rows) for i in nodes if i in table})

    def jet(self) -> list[str]:
        """Body of ``jet``: Taylor coefficients of states, quadratures and guards, at least up to ``order``."""
        count, first_guard = len(self.rates), len(self.rates)
        number, value = self.source.is_number, self.source.value
        used = sorted({*range(count + len(self.guards)), *self._rows_of(self.in_jet)})
        lines = [f"h{r} = ws[{r}]" for r in used]
        lines += [f"h{i}[0] = {f'x[{i}]' if i < self.n else '0.0'}" for i in range(count)]
        lines += self._begin(self.in_jet)
        lines += [f"h{first_guard + j}[0] = {value(g)}" for j, g in enumerate(self.guards)]
        lines += [f"n{i} = {value(rate)}" for i, rate in enumerate(self.rates)]
        before = [line for i in range(count) for line in (f"y{i} = n{i}", f"h{i}[k] = y{i}")]
        after = [f"h{first_guard + j}[k] = {'0.0' if number(g) else f'v{g}'}" for j, g in enumerate(self.guards)]
        after += [
            "jk = RECIPROCAL[uint64(k + 1)]",
            *(f"n{i} = {self._next(rate)}" for i, rate in enumerate(self.rates)),
        ]
        nodes = self._ordered(self.in_jet, order=True)
        return with_constants(lines + passes(nodes, self.source, before, after, self._store(nodes)))

    def _next(self, rate: int) -> str:
        """Coefficient k + 1 of a state; every term is divided on its own, so that the last one need not wait."""
        if self.source.is_number(rate):
            return "0.0"
        if self.tape.nodes[rate].op != "linear":
            return f"jk * v{rate}"
        return " + ".join(f"jk{self.source.factor(w)} * v{i}" for w, i in self.source.terms(rate))

    def jacobian_jet(self) -> list[str]:
        """Body of ``jacobian_jet``: coefficients of the Jacobian's entries that the jet does not already hold."""
        if not self.in_jacobian:
            return ["return"]
        inputs = sorted(self._inputs())
        lines = [f"h{r} = ws[{r}]" for r in self._rows_of(self.in_jacobian | set(inputs))]
        lines += [f"v{i} = h{self.rows[i]}[0]" for i in inputs]
        lines += self._begin(self.in_jacobian)
        before = [f"v{i} = h{self.rows[i]}[k]" for i in inputs]
        before += [f"m{i} = h{self.slope_rows[i]}[k]" for i in inputs if i in self.slope_rows]
        nodes = self._ordered(self.in_jacobian, order=True)
        return with_constants(lines + passes(nodes, self.source, before, [], self._store(nodes)))
