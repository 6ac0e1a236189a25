"""Taylor recurrences of the nodes of a tape, four orders per pass.

After Jorba and Zou 2005, doi:10.1080/10586458.2005.10128904. A product of series costs a sum that grows with the order,
and every order waits for the one before it. So the orders 4 m to 4 m + 3 are done in one pass: what they need of orders
below 4 m is summed for all four of them at once, in chains that depend on nothing new, and what they need of each other
stays in registers. Of a large system this would be too much code, see `chaosdrill.codegen.tables`.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from chaosdrill.codegen.emitter import DOUBLE, INT, Function, Index, Number, Sums, total
from chaosdrill.codegen.mathematics import START, expand, power, special
from chaosdrill.codegen.tape import PATH
from chaosdrill.codegen.tuning import TUNING
from chaosdrill.model.special import SPECIAL

if TYPE_CHECKING:
    from chaosdrill.codegen.constants import Loaded
    from chaosdrill.codegen.emitter import Row, Table, Variable
    from chaosdrill.codegen.tape import Tape


def sums_of_older(f: "Function", series: "Row", vectors: "list[Row]", base: "Index") -> "list[list[Number]]":
    """Sums of series[base + k - j] * vector[j] over j < base, a whole number of passes: by vectors, k of the pass."""
    if f.width < f.module.width and len(vectors) > 1:
        # the sums of one vector are as many as registers hold beside what is multiplied
        return [sums for vector in vectors for sums in sums_of_older(f, series, [vector], base)]
    sums = [[Sums(f, TUNING.orders_in_pass) for _ in range(2)] for _ in vectors]
    with f.loop(0, base, 2) as j:
        for parity in (1, 0):
            for vector, of_vector in zip(vectors, sums, strict=True):
                of_vector[parity].grow(series, base - j - parity, vector[j + parity])
    return [even.with_those(odd) for even, odd in sums]


def composition(caller: Function, name: str) -> Any:
    """A function ``(argument, table, columns, k, last, unit)``: coefficient k >= 1 of a function of a series.

    Row 0 of the table holds the function's Taylor coefficients c_m at v + w/unit by powers of w, where v is the
    argument's coefficient 0, and row k the coefficients k of R_m = c_m + w R_(m + 1), w = unit (argument - v), of which
    R_0 is the function. By this rule of Horner an order needs coefficients of lower orders alone; of the order ``last``
    only that of R_0 is wanted, of the one before it those of R_0 and R_1, and so on.
    """
    row = DOUBLE.as_pointer()
    types = {"argument": row, "table": row, "columns": INT, "k": INT, "last": INT, "unit": caller.type}
    f = Function(caller.module, name, types, caller.type, fast=True, own=True, stays=True, width=caller.width)
    argument, table = f.row(f.arguments[0]), f.table(f.arguments[1], f.arguments[2])
    k, last = Index(f, f.arguments[3]), Index(f, f.arguments[4])
    newest, unit, paired = table[k], Number(f, f.arguments[5]), f.whole_part(k, 2) + 1
    with f.loop(0, last - k + 1, TUNING.orders_in_pass) as m:
        even, odd = (Sums(f, TUNING.orders_in_pass) for _ in range(2))
        with f.loop(1, paired, 2) as j:
            even.grow(table[k - j], m + 1, argument[j])
            odd.grow(table[k - j - 1], m + 1, argument[j + 1])
        with f.loop(paired, k + 1) as j:
            even.grow(table[k - j], m + 1, argument[j])
        for i, value in enumerate(even.with_those(odd)):
            newest[m + i] = unit * value
    f.give(newest[0])
    f.end()
    return f.made


class Expansion:
    """A function's Taylor coefficients at the start of a series, and its own series.

    ``table``: one row, or as many as the series has coefficients. ``last``: order of the last coefficient.
    """

    def __init__(self, table: "Table", last: Index) -> None:
        self.table, self.last = table, last

    def start(self, name: str, arguments: list[Number], derivative: int) -> Number:
        """Coefficient 0."""
        expand(self.table.function, name, arguments, derivative, self.last + 1, self.table[0])
        return self.table[0][0]

    def order(self, argument: "Row", k: Index, *, relative: bool) -> Number:
        """Coefficient k >= 1; ``relative``: the coefficients are by powers of the argument's relative change."""
        f = self.table.function
        unit = 1.0 / argument[0] if relative else f.number(1.0)
        made = f.module.once(f"composition_of_{f.width}", lambda name: composition(f, name))
        given = [argument.data, self.table.data, self.table.length.value, k.value, self.last.value, unit.value]
        return Number(f, f.builder.call(made, given))


def value_alone(f: Function) -> Expansion:
    """What an expansion is where only its coefficient 0 is wanted."""
    return Expansion(f.table(f.scratch(1).data, INT(1)), f.index(0))


class Convolution:
    """Sum of left[j] * right[k - j] over 0 < j < k, of two rows of the workspace.

    ``newest`` gives the coefficients of both of the order at hand.
    """

    def __init__(self, function: "Function", left: "Row", right: "Row", newest: Callable[[], "list[Number]"]) -> None:
        self.function, self.rows, self.newest = function, (left, right), newest
        self.last = [[function.variable() for _ in range(3)] for _ in range(2)]
        self.first_three: list[list[Number]] = []
        self.sums: list[Variable] = []

    def shift(self) -> None:
        """The order is over: what was newest is one order old."""
        for last, newest in zip(self.last, self.newest(), strict=True):
            last[2].become(last[1].now)
            last[1].become(last[0].now)
            last[0].become(newest)

    def keep(self) -> None:
        """After the orders 1, 2, 3: the coefficients that every later order multiplies."""
        self.first_three = [[v.now for v in reversed(last)] for last in self.last]

    def old(self, base: "Index") -> None:
        """Sums of the pass over all pairs of which neither is among the first three or of this pass."""
        left, right = self.rows
        self.sums = [self.function.variable() for _ in range(TUNING.orders_in_pass)]
        with self.function.loop(0, base - 8) as i:
            e = left[base - 5 - i]
            for lane, total in enumerate(self.sums):
                total.grow(e * right[i + 5 + lane])
        with self.function.when(base.compare(">", 4)):
            for age in (4, 3, 2, 1):
                e = left[base - age]
                for lane, total in enumerate(self.sums):
                    total.grow(e * right[age + lane])

    def first(self, k: int) -> "Number":
        """The sum at order k = 1, 2, 3."""
        l, r = ([v.now for v in last] for last in self.last)  # noqa: E741
        if k == 1:
            return self.function.number(0.0)
        return l[0] * r[0] if k == 2 else l[1] * r[0] + l[0] * r[1]

    def later(self, lane: int) -> "Number":
        """The sum at order base + lane, the youngest terms last."""
        l, r = ([v.now for v in last] for last in self.last)  # noqa: E741
        low, high = self.first_three
        result = self.sums[lane].now + low[2] * r[2] + low[1] * r[1]
        for i in range(lane, 0, -1):
            result = result + l[i - 1] * high[i - 1]
        return result + low[0] * r[0]


class Recurrences:
    """What computes single nodes of a tape in one function.

    ``rows``, ``slope_rows``: coefficients of a node, and those of its derivative. ``constants``: numbers that stand for
    expressions of parameters. ``expansions``: those of nodes that move.
    """

    def __init__(
        self,
        function: "Function",
        tape: "Tape",
        rows: "dict[int, Row]",
        slope_rows: "dict[int, Row]",
        constants: "Loaded",
        expansions: dict[int, Expansion] | None = None,
    ) -> None:
        self.function, self.tape, self.constants = function, tape, constants
        self.rows, self.slope_rows, self.expansions = rows, slope_rows, expansions or {}
        self.now: dict[int, Variable] = {}
        """Coefficients of the order at hand."""
        self.slope_now: dict[int, Variable] = {}
        """Those of derivatives."""
        self.begun: dict[int, Number] = {}
        """Coefficients 0."""
        self.before: dict[int, Number] = {}
        """Coefficients of the order before."""
        self.ratio: dict[int, Number] = {}
        """See `scaled`."""

    def value(self, index: int) -> "Number":
        """A node's coefficient of the order at hand."""
        return self.constants[self.tape.nodes[index].value] if self.tape.is_number(index) else self.now[index].now

    def become(self, index: int, value: "Number") -> None:
        """Give a node its coefficient."""
        if index in self.now:
            self.now[index].become(value)
        else:
            self.now[index] = self.function.variable(value)

    def start(self, index: int, x: "Row", t: "Number") -> "Number":
        """Coefficient 0."""
        node = self.tape.nodes[index]
        a = [self.value(i) for i in node.args]
        if node.op == "state":
            return x[node.value]
        if node.op == "time":
            return t
        if node.op == "linear":
            terms = [self.constants.times(w, v) for w, v in zip(node.weights, a, strict=True)]
            return total([self.constants[node.value], *terms] if node.value != 0 else terms)
        if node.op in ("mul", "square"):
            return a[0] * a[-1]
        if node.op == "div":
            return a[0] / a[1]
        if node.op == "power":
            return power(a[0], self.constants[node.value])
        if node.op == "expanded":
            found = self.expansions.get(index) or value_alone(self.function)
            return found.start(node.name, a, node.value)
        if node.op == "special":
            return special(self.function, node.name, a[: node.value])
        if node.name == PATH:
            return self.function.number(0.0)
        return START[node.name or node.op](a[0])

    def factors(self, index: int) -> "tuple[tuple[bool, int], int] | None":
        """The series whose product a node's recurrence has, if it has one: whether the first is a derivative; nodes."""
        node = self.tape.nodes[index]
        if self.tape.is_still(index) or self.tape.scaled_by(index) is not None:
            return None
        if node.op in ("mul", "square"):
            return (False, node.args[0]), node.args[-1]
        if node.op == "div":
            return (False, node.args[1]), index
        if node.op == "integral" and self.tape.turning(index) is None:
            return (True, node.args[0]), self.tape.slopes[index][0]
        return None

    def _convolution(self, factors: "tuple[tuple[bool, int], int]") -> Convolution:
        (derived, a), b = factors
        rows, now = (self.slope_rows, self.slope_now) if derived else (self.rows, self.now)
        return Convolution(self.function, rows[a], self.rows[b], lambda: [now[a].now, self.now[b].now])

    def order(self, index: int, k: Any, ik: "Number", inner: "Number | None", time: float) -> "Number":
        """Coefficient k >= 1; ``inner`` is the value of the node's convolution, ``time`` coefficient k of time."""
        if self.tape.is_still(index):
            return self.function.number(0.0)
        node, still = self.tape.nodes[index], self.tape.scaled_by(index)
        now = [None if self.tape.is_number(i) else self.now[i].now for i in node.args]
        if node.op == "time":
            return self.function.number(time) if isinstance(time, float) else time
        if node.op == "linear":
            return total([self.constants.times(w, self.now[i].now) for w, i in self.terms(index)])
        if still is not None:
            moving = now[0] if node.args[-1] == still else now[-1]
            return moving / self.begun[still] if node.op == "div" else self.begun[still] * moving
        if node.op in ("mul", "square"):
            a, b = node.args[0], node.args[-1]
            return inner + self.begun[a] * now[-1] + now[0] * self.begun[b]
        if node.op == "div":
            above = self.function.number(0.0) if now[0] is None else now[0]
            return (above - inner - now[1] * self.begun[index]) / self.begun[node.args[1]]
        if node.op == "power":
            exponent, (a,) = self.constants[node.value], node.args
            old = self._sum(
                k, lambda j, rest: (exponent * rest.number() - j.number()) * self.rows[a][rest] * self.rows[index][j]
            )
            return (ik * old + exponent * now[0] * self.begun[index]) / self.begun[a]
        if node.op == "log":
            (a,) = node.args
            old = self._sum(k, lambda j, rest: j.number() * self.rows[index][j] * self.rows[a][rest])
            return (now[0] - ik * old) / self.begun[a]
        if node.op == "expanded":
            relative = SPECIAL[node.name].relative
            return self.expansions[index].order(self.rows[node.args[0]], self.function.index(k), relative=relative)
        if node.op == "special":
            return total([self.now[i].now for i in self.tape.paths(index)])
        return self._integral(index, ik, inner, now)

    def _integral(self, index: int, ik: "Number", inner: "Number | None", now: "list[Any]") -> "Number":
        slope, sign = self.tape.slopes[index]
        rate = self.tape.turning(index)
        if rate is not None:
            found = ik * self.constants[rate] * self.before[slope]
        else:
            scaled = self.scaled(index)
            newest = now[0] * self.begun[slope] if scaled is None else self.now[scaled[0]].now * self.ratio[index]
            found = ik * inner + newest
        return -found if sign < 0 else found

    def _sum(self, k: Any, term: "Callable[[Index, Index], Number]") -> "Number":
        total = self.function.variable()
        k = self.function.index(k)
        with self.function.loop(1, k) as j:
            total.grow(term(j, k - j))
        return total.now

    def scaled(self, index: int) -> tuple[int, Any] | None:
        """Of a function of a multiple of one node: that node, and the multiple.

        The multiple times the slope at the start is the factor between their newest coefficients, the same at every
        order, so that the function need not wait for its argument.
        """
        node = self.tape.nodes[index]
        if node.op != "integral" or self.tape.turning(index) is not None:
            return None
        argument = self.tape.nodes[node.args[0]]
        if argument.op != "linear" or len(argument.args) != 1:
            return None
        return argument.args[0], argument.weights[0]

    def terms(self, index: int) -> list[tuple[Any, int]]:
        """Weights and nodes of a sum, those that come late at the end."""
        node = self.tape.nodes[index]
        return sorted(zip(node.weights, node.args, strict=True), key=lambda term: self.depth(term[1]))

    def depth(self, index: int) -> int:
        """How many operations a node's newest coefficient waits for."""
        known = self.tape.depths
        if index not in known:
            node = self.tape.nodes[index]
            if node.op in ("state", "time") or self.tape.turning(index) is not None or self.tape.is_number(index):
                known[index] = 0
            else:
                scaled = self.scaled(index)
                known[index] = 1 + max(self.depth(a) for a in (node.args if scaled is None else scaled[:1]))
        return known[index]

    def passes(
        self,
        nodes: list[int],
        order: "Index",
        before: "Callable[[Any], None]",
        after: "Callable[[Any], None]",
        store: "Callable[[int, Any], None]",
    ) -> None:
        """All orders from 1 to the multiple of four above ``order``, less one.

        ``nodes``: in the order of their evaluation; states are no nodes to evaluate. ``before``, ``after``: what is
        done at the beginning and at the end of every order, given its number. ``store``: keeps a node's coefficient,
        given the node and the number of the order.
        """
        function, tape = self.function, self.tape
        self.begun = {i: v.now for i, v in self.now.items()}
        self.ratio = {
            i: self.constants.times(scaled[1], self.begun[tape.slopes[i][0]])
            for i in nodes
            if (scaled := self.scaled(i)) is not None
        }
        factors = {i: f for i in nodes if (f := self.factors(i)) is not None}
        products = list(dict.fromkeys(factors.values()))
        found = {f: self._convolution(f) for f in products}
        turned = sorted({tape.slopes[i][0] for i in nodes if tape.turning(i) is not None})

        def one_order(k: Any, ik: Any, time: Any, inner: "Callable[[Any], Number]") -> None:
            before(k)
            self.before = {i: self.now[i].now for i in turned}
            for index in nodes:
                own = inner(factors[index]) if index in factors else None
                self.become(index, self.order(index, k, ik, own, time))
                store(index, k)
            after(k)
            for c in found.values():
                c.shift()

        if not found:
            with function.loop(1, order + 1) as k:
                time = function.choose(k.compare("==", 1), 1.0, 0.0)
                one_order(k, function.reciprocal(k), time, lambda f: function.number(0.0))
            return
        for k in range(1, TUNING.orders_in_pass):
            one_order(k, function.number(1.0 / k), float(k == 1), lambda f, k=k: found[f].first(k))
        for c in found.values():
            c.keep()
        with function.loop(TUNING.orders_in_pass, order + 1, TUNING.orders_in_pass) as base:
            for c in found.values():
                c.old(base)
            for lane in range(TUNING.orders_in_pass):
                k = base + lane
                one_order(k, function.reciprocal(k), 0.0, lambda f, lane=lane: found[f].later(lane))
