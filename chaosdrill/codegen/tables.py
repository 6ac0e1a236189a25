"""Taylor coefficients of a large mode and of its tangents: loops over tables of its operations, as LLVM code.

What is written in line for a small mode grows with it, and so does its compilation. Here the code is a loop over the
operations with a branch for each kind of them, whatever their number; what differs from mode to mode are constant
tables of whole numbers. Every operation keeps its series in a row of the workspace. Operations are done in the order in
which they wait for each other, and those of one kind that could be done together side by side.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from chaosdrill.codegen.emitter import DOUBLE, INT, Function, Index, Module, Number, Row, Table, Test, Variable
from chaosdrill.codegen.mathematics import START, power, special
from chaosdrill.codegen.mode import Mode
from chaosdrill.codegen.recurrence import Expansion, sums_of_older, value_alone
from chaosdrill.codegen.signatures import WIDTH
from chaosdrill.codegen.tape import PATH, POSITIVE
from chaosdrill.codegen.tuning import TUNING
from chaosdrill.model.special import SPECIAL

_ROW = DOUBLE.as_pointer()

EXPANDED_AT = {True: "expanded", False: "expanded beside"}
"""Branches of functions whose Taylor coefficients are by the argument's relative change, and by its change."""

Item = tuple[str, int]
"""A series: ``node`` or ``slope`` (coefficients times their orders), and of which node."""

Terms = list[tuple[int, Any]]
"""Nodes and their weights."""

Variation = tuple[int, dict[int, Any], dict[int, tuple[int, Any]]]
"""Place of a variation; by the places of those that it is made of: weights, and nodes with weights."""


class InTables:
    """The operations of one mode, and the functions that loop over them."""

    def __init__(self, mode: Mode) -> None:
        self.mode, self.tape, self.n = mode, mode.tape, mode.n
        self.in_jet = self._items(self._without_sums(mode.in_jet), set())
        self.in_jacobian = self._items(mode.in_jacobian, set(self.in_jet))
        self.rows: dict[Item, int] = {}
        free = len(mode.rates) + len(mode.guards)
        for item in (*self.in_jet, *self.in_jacobian):
            kind, index = item
            node = self.tape.nodes[index]
            if item in self.rows:
                continue
            if kind == "node" and node.op == "state":
                self.rows[item] = node.value
            else:
                self.rows[item] = free
                # the rows of an expansion follow that of its series
                free += 1 + (WIDTH if node.op == "expanded" and not self.tape.is_still(index) else 0)
        self.kept = free
        """The row from which the tangents of kept nodes stand, those of the first vector before those of the second."""
        self.older = free + 2 * len(mode.kept)
        """The row from which sums over older coefficients stand, eight a product; no row is shorter than 24."""
        self.row_count = self.older + len(mode.products) // 3 + 1

    def watched_rows(self) -> list[int]:
        """Rows of what the steep operations are applied to."""
        return [self.rows.get(("node", i), -1) for i in self.mode.watched]

    def _without_sums(self, nodes: set[int]) -> set[int]:
        """Nodes without sums that are rates or guards and nothing else: these are added up where they are wanted."""
        tape, every = self.tape, nodes | self.mode.in_jacobian
        used = {*self.mode.wanted, *self.mode.watched} | {a for i in every for a in tape.nodes[i].args}
        used |= {tape.slopes[i][0] for i in every if i in tape.slopes}
        used |= {i for root in (*self.mode.rates, *self.mode.guards) for i, _ in self.terms(root)}
        return {i for i in nodes if i in used or tape.nodes[i].op != "linear"}

    def terms(self, index: int) -> Terms:
        """A node as nodes with weights, beside its constant."""
        node = self.tape.nodes[index]
        return list(zip(node.args, node.weights, strict=True)) if node.op == "linear" else [(index, 1)]

    def constant(self, index: int) -> Any:
        """What a node is beside its terms."""
        node = self.tape.nodes[index]
        return node.value if node.op == "linear" else 0

    def _items(self, nodes: set[int], known: set[Item]) -> list[Item]:
        """The series that nodes need, each after those that it is made of."""
        found: dict[Item, None] = {}
        for index in sorted(nodes):
            found |= dict.fromkeys([*self._sources(("node", index)), ("node", index)])
            if self.tape.nodes[index].op in ("power", "log"):
                found["slope", index] = None
        return [item for item in found if item not in known]

    def _sources(self, item: Item) -> list[Item]:
        """The series whose coefficients of an order a series waits for."""
        kind, index = item
        node = self.tape.nodes[index]
        if kind == "slope":
            return [("node", index)]
        if self.tape.is_known(index):
            return []
        nodes: list[Item] = [("node", a) for a in node.args]
        return [*nodes, ("slope", node.args[0])] if node.op in ("integral", "power", "log") else nodes

    def batches(self, items: Sequence[Item], *, start: bool) -> list[tuple[str, list[Item]]]:
        """Independent series of one kind, in the order of computation."""
        depth: dict[Item, int] = {}
        found: dict[tuple[int, str], list[Item]] = {}
        for item in items:
            sources = [("node", a) for a in self.tape.nodes[item[1]].args] if start else self._sources(item)
            depth[item] = 1 + max((depth.get(source, 0) for source in sources), default=0)
            name = self._kind(item, start=start)
            if name is not None:
                found.setdefault((depth[item], name), []).append(item)
        return [(name, found[level, name]) for level, name in sorted(found)]

    def _kind(self, item: Item, *, start: bool) -> str | None:
        """Which branch computes a series; None: it is known."""
        kind, index = item
        node = self.tape.nodes[index]
        if kind == "slope":
            return None if start else "slope"
        if node.op == "state":
            return None
        if node.op == "expanded":
            still = self.tape.is_still(index)
            if start:
                return f"{node.name} {node.value} {'still' if still else 'moving'}"
            return "linear" if still else EXPANDED_AT[SPECIAL[node.name].relative]
        if node.op == "special":
            return node.name if start else "linear"
        if node.op == "integral":
            return node.name if start else "integral" if self.tape.turning(index) is None else "turn"
        return POSITIVE if start and node.name == POSITIVE else node.op

    def record(self, item: Item) -> tuple[int, int, int, int, int]:
        """Row of a series, two rows that it is made of, one of coefficients times orders, and place of a constant."""
        kind, index = item
        tape, rows, node = self.tape, self.rows, self.tape.nodes[index]
        target = rows[item]
        if kind == "slope":
            return target, rows["node", index], 0, 0, 0
        if node.op == "integral":
            slope, sign = tape.slopes[index]
            rate = tape.turning(index)
            derived = rows["slope", node.args[0]] if rate is None else 0
            place = self.place(sign if rate is None else sign * rate)
            return target, rows["node", node.args[0]], rows["node", slope], derived, place
        if node.op in ("power", "log"):
            (a,) = node.args
            place = self.place(node.value) if node.op == "power" else 0
            return target, rows["node", a], rows["slope", index], rows["slope", a], place
        made_of = [rows["node", a] for a in tape.arguments(index)]
        first, second, third, fourth = (*made_of, 0, 0, 0, 0)[:4]
        return target, first, second, third, fourth

    def place(self, expression: Any) -> int:
        """Index of a number among the constants."""
        return self.mode.constants.place(expression)

    def jet(self, module: Module, name: str) -> Any:
        """Write ``(order, t, c, x, ws, columns)``: coefficients of states, quadratures and guards up to ``order``."""
        types = {"order": INT, "t": module.type, "c": _ROW, "x": _ROW, "ws": _ROW, "columns": INT}
        f = Function(module, name, types, fast=True, own=True, apart=True)
        mode, (order, t, c, x, ws, columns) = self.mode, f.arguments
        writer = _Writer(self, f, f.row(c), f.table(ws, columns), Index(f, order))
        rates = _Sums(writer, "rates", [(i, rate) for i, rate in enumerate(mode.rates)])
        guards = _Sums(writer, "guards", [(len(mode.rates) + j, guard) for j, guard in enumerate(mode.guards)])
        with f.loop(self.n, len(mode.rates)) as i:
            writer.ws[i][0] = 0.0
        writer.begin(self.in_jet, f.row(x), Number(f, t))
        with guards.at(f.index(0), f.truth(True)) as (target, value):
            writer.ws[target][0] = value
        with f.loop(1, Index(f, order) + 1) as k:
            ik = f.reciprocal(k)
            with rates.at(k - 1, k.compare("==", 1)) as (target, value):
                writer.ws[target][k] = ik * value
            writer.go_on(self.in_jet, k, ik)
            with guards.at(k, f.truth(False)) as (target, value):
                writer.ws[target][k] = value
        f.end()
        return f.made

    def jacobian_jet(self, module: Module, name: str) -> Any:
        """Write ``(order, c, ws, columns)``: coefficients of the Jacobian's entries that the jet does not hold."""
        types = {"order": INT, "c": _ROW, "ws": _ROW, "columns": INT}
        f = Function(module, name, types, fast=True, own=True, apart=True)
        order, c, ws, columns = f.arguments
        if self.in_jacobian:
            writer = _Writer(self, f, f.row(c), f.table(ws, columns), Index(f, order))
            writer.start(self.in_jacobian, f.number(0.0))
            with f.loop(1, Index(f, order) + 1) as k:
                writer.go_on(self.in_jacobian, k, f.reciprocal(k))
        f.end()
        return f.made

    def tangent(self, module: Module, name: str) -> Any:
        """Write ``(order, c, first, second, ws, columns, row)``: coefficients of two tangent vectors.

        The series of the Jacobian's entries are known, so that a pass sums all older coefficients of four orders at
        once.
        """
        types = {"order": INT, "c": _ROW, "first": _ROW, "second": _ROW, "ws": _ROW, "columns": INT, "row": INT}
        f = Function(module, name, types, fast=True, own=True, apart=True)
        order, c, *starts, ws, columns, row = f.arguments
        table, constants, both = f.table(ws, columns), f.row(c), Index(f, row)
        older = module.once("older", lambda called: _older(module, called))
        with f.at_entry():
            sums_at = table[f.index(self.older)]

        def source(place: Index, v: int) -> Row:
            kept = f.index(self.kept + v * len(self.mode.kept) - self.n)
            return table[place + f.either(place.compare("<", self.n), both + v * self.n, kept)]

        with f.loop(0, self.n) as i:
            for v, start in enumerate(starts):
                source(i, v)[0] = f.row(start)[i]
        kept, rates = (_Variations(self, f, *which) for which in self._variations())
        first = {kept: 0, rates: kept.count}
        with f.loop(0, Index(f, order) + 1, TUNING.orders_in_pass) as base:
            for variations in (kept, rates):
                with f.loop(0, variations.count) as p:
                    _, series, other = variations.product(p)
                    vectors = [source(other, v).data for v in range(2)]
                    sums = sums_at.after((p + first[variations]) * (2 * TUNING.orders_in_pass))
                    f.builder.call(older, [table[series].data, *vectors, base.value, sums.data])
            for lane in range(TUNING.orders_in_pass):
                ik = f.reciprocal(base + (lane + 1))
                for variations, factor in ((kept, None), (rates, ik)):
                    with f.loop(0, variations.targets.count) as i:
                        totals = [f.variable() for _ in range(2)]
                        with variations.plain(i) as (place, other):
                            for v, total in enumerate(totals):
                                total.grow(constants[place] * source(other, v)[base + lane])
                        with variations.products(i) as p:
                            place, series, other = variations.product(p)
                            sums = sums_at.after((p + first[variations]) * (2 * TUNING.orders_in_pass))
                            begun = [table[series][j] for j in range(lane + 1)]
                            for v, total in enumerate(totals):
                                newest = source(other, v).after(base)
                                value = sums[v * TUNING.orders_in_pass + lane]
                                for j in range(lane + 1):
                                    value = value + begun[lane - j] * newest[j]
                                total.grow(constants[place] * value)
                        for v, total in enumerate(totals):
                            value = total.now if factor is None else factor * total.now
                            source(variations.targets[i, 0], v)[base + (lane + int(factor is not None))] = value
        f.end()
        return f.made

    def _variations(self) -> list[tuple[str, list[Variation]]]:
        """For kept nodes, then for states: place, and what the variation of it, or of its rate, is made of."""
        mode = self.mode
        made: list[Variation] = [(place, {}, {}) for place in range(self.n + len(mode.kept))]
        for (i, j), weight in sorted(mode.linear.items()):
            made[i][1][j] = weight
        for (i, j), product in sorted(mode.products.items()):
            made[i][2][j] = product
        rates = sorted(made[: self.n], key=lambda found: (len(found[1]), len(found[2])))
        return [("kept", made[self.n :]), ("rates", rates)]

    def field(self, module: Module, name: str) -> Any:
        """Write ``(t, c, x, out)``: rates of the states, then integrands of the quadratures."""
        f = Function(module, name, {"t": DOUBLE, "c": _ROW, "x": _ROW, "out": _ROW}, own=True)
        t, c, x, out = f.arguments
        writer = _Writer(self, f, f.row(c), f.table(f.scratch(self.row_count).data, INT(1)), anywhere=True)
        writer.begin(self.in_jet, f.row(x), Number(f, t))
        rates = _Sums(writer, "rates", [(i, rate) for i, rate in enumerate(self.mode.rates)])
        with rates.at(f.index(0), f.truth(True)) as (target, value):
            f.row(out)[target] = value
        f.end()
        return f.made

    def variation(self, module: Module, name: str) -> Any:
        """Write ``(t, c, x, d, out)``: the Jacobian times d."""
        f = Function(module, name, {"t": DOUBLE, "c": _ROW, "x": _ROW, "d": _ROW, "out": _ROW}, own=True)
        t, c, x, d, out = f.arguments
        writer = _Writer(self, f, f.row(c), f.table(f.scratch(self.row_count).data, INT(1)), anywhere=True)
        writer.begin([*self.in_jet, *self.in_jacobian], f.row(x), Number(f, t))
        own = f.scratch(self.n + len(self.mode.kept))
        with f.loop(0, self.n) as i:
            own[i] = f.row(d)[i]
        for which, target in zip(self._variations(), (own, f.row(out)), strict=True):
            variations = _Variations(self, f, *which)
            with f.loop(0, variations.targets.count) as i:
                total = f.variable()
                with variations.plain(i) as (place, other):
                    total.grow(writer.c[place] * own[other])
                with variations.products(i) as p:
                    place, series, other = variations.product(p)
                    total.grow(writer.c[place] * writer.ws[series][0] * own[other])
                target[variations.targets[i, 0]] = total.now
        f.end()
        return f.made


class _Records:
    """Rows of whole numbers in the code, column by column."""

    def __init__(self, function: Function, name: str, width: int, rows: Sequence[tuple[int, ...]]) -> None:
        self.function, self.count = function, len(rows)
        write, title = function.module.whole_numbers, f"{function.made.name}_{name}"
        self.columns = [write(f"{title}_{i}", [row[i] for row in rows]) for i in range(width)]

    def __getitem__(self, place: tuple[Index, int]) -> Index:
        row, column = place
        return self.function.entry_of(self.columns[column], row)


class _Sums:
    """Weighted sums of series that are stored elsewhere.

    ``sums``: where each goes, and the node that it is.
    """

    def __init__(self, writer: "_Writer", name: str, sums: list[tuple[int, int]]) -> None:
        self.writer, operations = writer, writer.operations
        terms: list[tuple[int, int]] = []
        records = []
        # sums of one length stand together: so the processor guesses right how long the loop over the terms goes on
        for target, node in sorted(sums, key=lambda found: len(operations.terms(found[1]))):
            first = len(terms)
            terms += [(operations.rows["node", i], operations.place(w)) for i, w in operations.terms(node)]
            records.append((target, first, len(terms), operations.place(operations.constant(node))))
        self.records = _Records(writer.function, name, 4, records)
        self.terms = _Records(writer.function, f"{name}_terms", 2, terms)

    @contextmanager
    def at(self, k: Index, beginning: Test) -> Iterator[tuple[Index, Number]]:
        """Write what is done with coefficient k of every sum; constants belong to the beginning."""
        f, writer = self.writer.function, self.writer
        with f.loop(0, self.records.count) as i:
            total = f.variable()
            total.become(f.choose(beginning, writer.c[self.records[i, 3]], 0.0))
            writer.add_up(total, self.terms, self.records[i, 1], self.records[i, 2], k)
            yield self.records[i, 0], total.now


class _Variations:
    """What the variations of nodes or of rates are made of.

    ``made``: for each its place, weights by the places of variations, and nodes and weights by such places.
    """

    def __init__(self, operations: InTables, function: Function, name: str, made: list[Variation]) -> None:
        self.function, place = function, operations.place
        plain: list[tuple[int, int]] = []
        products: list[tuple[int, int, int]] = []
        targets = []
        for target, weights, weighted in made:
            first = len(plain), len(products)
            plain += [(place(weight), source) for source, weight in weights.items()]
            for source, (node, weight) in weighted.items():
                products.append((place(weight), operations.rows["node", node], source))
            targets.append((target, first[0], len(plain), first[1], len(products)))
        self.targets = _Records(function, name, 5, targets)
        self._plain = _Records(function, f"{name}_plain", 2, plain)
        self._products = _Records(function, f"{name}_products", 3, products)

    @contextmanager
    def plain(self, target: Index) -> Iterator[tuple[Index, Index]]:
        """Write what is done for every weight: its place, and that of the variation."""
        with self.function.loop(self.targets[target, 1], self.targets[target, 2]) as i:
            yield self._plain[i, 0], self._plain[i, 1]

    @property
    def count(self) -> int:
        """How many products there are."""
        return self._products.count

    @contextmanager
    def products(self, target: Index) -> Iterator[Index]:
        """Write what is done for every product, by its number."""
        with self.function.loop(self.targets[target, 3], self.targets[target, 4]) as i:
            yield i

    def product(self, i: Index) -> tuple[Index, Index, Index]:
        """Place of a product's weight, row of its series, place of its variation."""
        return self._products[i, 0], self._products[i, 1], self._products[i, 2]


class _Writer:
    """Writes loops over operations, with the constants ``c`` and the workspace ``ws``.

    ``last``: order of the last coefficient; None if only values are wanted. ``anywhere``: whether powers that are zero
    where their base is not positive are taken there, too.
    """

    def __init__(
        self,
        operations: InTables,
        function: Function,
        c: Row,
        ws: Table,
        last: Index | None = None,
        *,
        anywhere: bool = False,
    ) -> None:
        self.operations, self.function, self.c, self.ws = operations, function, c, ws
        self.last, self.anywhere = last, anywhere

    def begin(self, items: list[Item], x: Row, t: Number) -> None:
        """States, and coefficients 0 of the series that are made of them."""
        with self.function.loop(0, self.operations.n) as i:
            self.ws[i][0] = x[i]
        self.start(items, t)

    def start(self, items: list[Item], t: Number) -> None:
        """Coefficients 0."""
        zero = self.function.index(0)

        def value(name: str, record: Callable[[int], Index]) -> Number:
            if name == "time":
                return t
            if name == PATH:
                return self.function.number(0.0)
            title, *expanded = name.split()
            if title in SPECIAL:
                (count,) = SPECIAL[title].make.nargs
                arguments = [self.ws[record(i + 1)][0] for i in range(int(count))]
                if not expanded:
                    return special(self.function, title, arguments)
                derivative, motion = expanded
                return self._expansion(record, motion).start(title, arguments, int(derivative))
            first = self.ws[record(1)][0]
            if name == "square":
                return first * first
            if name == "mul":
                return first * self.ws[record(2)][0]
            if name == "div":
                return first / self.ws[record(2)][0]
            if name in ("power", POSITIVE):
                found = power(first, self.c[record(4)])
                positive = name == POSITIVE and self.anywhere
                return self.function.choose(first.compare(">", 0.0), found, 0.0) if positive else found
            return START[name](first)

        self._run("start", items, zero, value, start=True)

    def _expansion(self, record: Callable[[int], Index], motion: str = "moving") -> Expansion:
        """The Taylor coefficients of a function, in the rows that follow its own."""
        if self.last is None or motion == "still":
            return value_alone(self.function)
        return Expansion(self.function.table(self.ws[record(0) + 1].data, self.ws.length.value), self.last)

    def go_on(self, items: list[Item], k: Index, ik: Number) -> None:
        """Coefficients k >= 1; ``ik`` is 1/k."""
        f, ws = self.function, self.ws
        convolve = f.module.once("convolve", lambda name: _convolution(f.module, name))
        square = f.module.once("convolve_square", lambda name: _square(f.module, name))

        def folded(left: Row, right: Row, order: Index) -> Number:
            return Number(f, f.builder.call(convolve, [left.data, right.data, order.value]))

        def value(name: str, record: Callable[[int], Index]) -> Number:
            if name == "time":
                return f.choose(k.compare("==", 1), 1.0, 0.0)
            a = ws[record(1)]
            if name == "slope":
                return k.number() * a[k]
            if name in EXPANDED_AT.values():
                return self._expansion(record).order(a, k, relative=name == EXPANDED_AT[True])
            if name == "square":
                return Number(f, f.builder.call(square, [a.data, k.value]))
            b = ws[record(2)]
            if name == "mul":
                return folded(a, b, k)
            if name == "div":
                return (a[k] - folded(b.after(1), ws[record(0)], k - 1)) / b[0]
            if name == "turn":
                return ik * self.c[record(4)] * b[k - 1]
            derived = ws[record(3)]
            if name == "integral":
                return ik * self.c[record(4)] * folded(derived.after(1), b, k - 1)
            # b: the series' own coefficients times their orders, which are known below k
            known = folded(b.after(1), a.after(1), k - 2)
            if name == "log":
                return ik * (derived[k] - known) / a[0]
            return ik * (self.c[record(4)] * folded(derived.after(1), ws[record(0)], k - 1) - known) / a[0]

        self._run("orders", items, k, value, start=False)

    def add_up(self, total: Variable, terms: _Records, first: Index, last: Index, k: Index) -> None:
        """Add terms of order k."""
        with self.function.loop(first, last) as j:
            total.grow(self.c[terms[j, 1]] * self.ws[terms[j, 0]][k])

    def _run(
        self,
        name: str,
        items: list[Item],
        k: Index,
        value: Callable[[str, Callable[[int], Index]], Number],
        *,
        start: bool,
    ) -> None:
        """Coefficient k of all series."""
        f, operations = self.function, self.operations
        batches = operations.batches(items, start=start)
        kinds = sorted({kind for kind, _ in batches})
        terms: list[tuple[int, int]] = []
        records: list[tuple[int, ...]] = []
        spans = []
        for kind, members in batches:
            spans.append((kinds.index(kind), len(records), len(records) + len(members)))
            for item in sorted(members, key=lambda found: len(self.operations.tape.nodes[found[1]].args)):
                records.append(self._sum_record(item, terms) if kind == "linear" else operations.record(item))
        span, record = _Records(f, f"{name}_batches", 3, spans), _Records(f, name, 5, records)
        term = _Records(f, f"{name}_terms", 2, terms)

        def all_of(kind: str, batch: Index) -> None:
            with f.loop(span[batch, 1], span[batch, 2]) as i:
                if kind == "linear":
                    total = f.variable()
                    total.become(self.c[record[i, 4]] if start else 0.0)
                    self.add_up(total, term, record[i, 1], record[i, 2], k)
                    self.ws[record[i, 0]][k] = total.now
                else:
                    self.ws[record[i, 0]][k] = value(kind, lambda column: record[i, column])

        with f.loop(0, len(spans)) as batch:
            f.switch(span[batch, 0], {n: lambda kind=kind: all_of(kind, batch) for n, kind in enumerate(kinds)})

    def _sum_record(self, item: Item, terms: list[tuple[int, int]]) -> tuple[int, int, int, int, int]:
        operations, index = self.operations, item[1]
        first = len(terms)
        summed = operations.terms(index)
        if operations.tape.nodes[index].op in ("special", "expanded"):
            # that of what does not move is a sum of nothing
            summed = [(path, 1) for path in operations.tape.paths(index)]
        terms += [(operations.rows["node", i], operations.place(w)) for i, w in summed]
        return operations.rows[item], first, len(terms), 0, operations.place(operations.constant(index))


def _convolution(module: Module, name: str) -> Any:
    """A function: the sum of left[j] * right[k - j] over 0 <= j <= k."""
    f = Function(module, name, {"left": _ROW, "right": _ROW, "k": INT}, module.type, fast=True, own=True, stays=True)
    left, right = (f.row(argument) for argument in f.arguments[:2])
    k = Index(f, f.arguments[2])
    sums = [f.variable() for _ in range(TUNING.chains)]
    whole = f.whole_part(k + 1, TUNING.chains)
    with f.loop(0, whole, TUNING.chains) as j:
        for i, total in enumerate(sums):
            total.grow(left[j + i] * right[k - j - i])
    with f.loop(whole, k + 1) as j:
        sums[0].grow(left[j] * right[k - j])
    f.give((sums[0].now + sums[1].now) + (sums[2].now + sums[3].now))
    f.end()
    return f.made


def _square(module: Module, name: str) -> Any:
    """A function: the same of one series with itself, each pair once."""
    f = Function(module, name, {"series": _ROW, "k": INT}, module.type, fast=True, own=True, stays=True)
    series, k = f.row(f.arguments[0]), Index(f, f.arguments[1])
    half = f.half(k + 1)
    sums = [f.variable() for _ in range(2)]
    whole = f.whole_part(half, 2)
    with f.loop(0, whole, 2) as j:
        for i, total in enumerate(sums):
            total.grow(series[j + i] * series[k - j - i])
    with f.loop(whole, half) as j:
        sums[0].grow(series[j] * series[k - j])
    middle = series[half]
    pairs = 2.0 * (sums[0].now + sums[1].now)
    f.give(f.choose((half + half).compare("==", k), pairs + middle * middle, pairs))
    f.end()
    return f.made


def _older(module: Module, name: str) -> Any:
    """A function: sums over older coefficients, see `sums_of_older`, for both vectors and every order of a pass."""

    def write(f: Function) -> None:
        series, *vectors = (f.row(argument) for argument in f.arguments[:3])
        base, target = Index(f, f.arguments[3]), f.row(f.arguments[4])
        for v, sums in enumerate(sums_of_older(f, series, vectors, base)):
            for lane, value in enumerate(sums):
                target[v * TUNING.orders_in_pass + lane] = value

    types = {"series": _ROW, "first": _ROW, "second": _ROW, "base": INT, "sums": _ROW}
    return module.in_parts(name, types, write)
