"""What the series of one mode are made of: its operations as nodes, and the entries of its Jacobian."""

from typing import TYPE_CHECKING, Any

from chaosdrill.codegen.tape import Tape
from chaosdrill.codegen.tuning import TUNING

if TYPE_CHECKING:
    from chaosdrill.codegen.constants import Constants
    from chaosdrill.model.system import HybridSystem

HISTORY = {"mul", "square", "div", "power", "log", "integral", "expanded"}
"""Operations that read older coefficients of what they are applied to."""


class Mode:
    """The nodes behind the series of one mode.

    ``kept``: nodes whose variations are computed by themselves; behind the states they are rows and columns of the
    Jacobian. ``linear``: entries of the Jacobian that depend on parameters only. ``products``: node and weight, whose
    product the other entries have besides. ``watched``: nodes that steep operations are applied to. ``small``: whether
    its operations are written in line, as in `chaosdrill.codegen.series`; those of a large one stand in tables, as in
    `chaosdrill.codegen.tables`.
    """

    def __init__(
        self, system: "HybridSystem", mode: str, guards: list[Any], watched: list[Any], constants: "Constants"
    ) -> None:
        self.n = len(system.states)
        self.constants = constants
        field = system.modes[mode]
        self.tape = Tape(system.states, system.time, frozenset(s for s in system.states if field[s] == 0))
        self.rates = [self.tape.lower(field[s]) for s in system.states]
        self.rates += [self.tape.lower(q) for q in system.integrands(mode)]
        self.guards = [self.tape.lower(g) for g in guards]
        self.watched = [self.tape.lower(w) for w in watched]
        self.in_jet = self.tape.reach([*self.rates, *self.guards, *self.watched])
        self.kept: list[int] = []
        self.small = self._is_small(self.in_jet)
        if self.small:
            self._lower_jacobian()
            self.small = self._is_small(self.in_jet | self.in_jacobian, len(self.convolved()))
        if not self.small:
            self.tape.keep(self.rates[: self.n])
            self.kept = self.tape.kept
            self._lower_jacobian()

    def _is_small(self, nodes: set[int], products: int = 0) -> bool:
        found, tape = [self.tape.nodes[i] for i in nodes], self.tape
        products += sum(
            tape.nodes[i].op in HISTORY and not tape.is_still(i) and tape.scaled_by(i) is None for i in nodes
        )
        return (
            products <= TUNING.products_in_line
            and sum(len(node.args) for node in found if node.op == "linear") <= TUNING.sums_in_line
        )

    def _lower_jacobian(self) -> None:
        self.linear: dict[tuple[int, int], Any] = {}
        self.products: dict[tuple[int, int], tuple[int, Any]] = {}
        rates = [self.tape.variation(rate) for rate in self.rates[: self.n]]
        for i, gradient in enumerate([*rates, *map(self.tape.gradient, self.kept)]):
            for j, terms in sorted(gradient.items()):
                constant, index, weight = self.tape.entry(terms)
                if constant != 0:
                    self.linear[i, j] = constant
                if index is not None:
                    self.products[i, j] = (index, weight)
        self.columns: list[list[int]] = [[] for _ in range(self.n + len(self.kept))]
        """By rows of the Jacobian: the states that a rate depends on."""
        for i, j in sorted({*self.linear, *self.products}):
            self.columns[i].append(j)
        self.wanted = {index for index, _ in self.products.values()}
        self.in_jacobian = self.tape.reach(sorted(self.wanted)) - self.in_jet

    def convolved(self) -> set[tuple[int, int]]:
        """Nodes and states whose series a tangent's are products of."""
        return {(index, j) for (_, j), (index, _) in self.products.items() if not self.tape.is_still(index)}
