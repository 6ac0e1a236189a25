"""Taylor coefficients of one small mode and of its tangents, as LLVM code that is written in line.

Row i of the workspace holds the coefficients of state i, then come those of the quadratures and of the guards, then the
history that products and functions need, then the tangents.
"""

from typing import Any

from chaosdrill.codegen.emitter import DOUBLE, INT, Function, Index, Module, Number, Row, total
from chaosdrill.codegen.mode import HISTORY, Mode
from chaosdrill.codegen.recurrence import Expansion, Recurrences, sums_of_older
from chaosdrill.codegen.signatures import WIDTH
from chaosdrill.codegen.tape import POSITIVE
from chaosdrill.codegen.tuning import TUNING


class InLine:
    """The rows that the series of one mode fill, and the functions that fill them."""

    def __init__(self, mode: Mode) -> None:
        self.mode, self.tape, self.n = mode, mode.tape, mode.n
        self.rows: dict[int, int] = {}
        self.slope_rows: dict[int, int] = {}
        self.row_count = self._assign_rows()

    def watched_rows(self) -> list[int]:
        """Rows of what the steep operations are applied to."""
        return [self.rows.get(i, -1) for i in self.mode.watched]

    def _assign_rows(self) -> int:
        """Give a row to every node whose history is read; returns the number of rows."""
        tape, need = self.tape, set(self.mode.wanted)
        for index in self.mode.in_jet | self.mode.in_jacobian:
            node = tape.nodes[index]
            if node.op in HISTORY and not tape.is_known(index):
                need.update([index, *node.args])
                if index in tape.slopes:
                    need.add(tape.slopes[index][0])
        need |= {*self._inputs(), *self.mode.watched}
        free = len(self.mode.rates) + len(self.mode.guards)
        for index in sorted(need):
            node = tape.nodes[index]
            if node.op == "state":
                self.rows[index] = node.value
            elif not tape.is_number(index):
                self.rows[index] = free
                free += 1
        for index in sorted(self.mode.in_jet | self.mode.in_jacobian):
            node = tape.nodes[index]
            if node.op == "integral" and tape.turning(index) is None and node.args[0] not in self.slope_rows:
                self.slope_rows[node.args[0]] = free
                free += 1
        self.expanded: dict[int, int] = {}
        """Nodes with an expansion, and the rows from which it stands."""
        for index in sorted(self.mode.in_jet | self.mode.in_jacobian):
            if tape.nodes[index].op == "expanded" and not tape.is_still(index):
                self.expanded[index] = free
                free += WIDTH
        return free

    def _inputs(self) -> set[int]:
        """Nodes of the jet from which the Jacobian's own nodes are made."""
        used = {a for i in self.mode.in_jacobian for a in self.tape.nodes[i].args}
        used |= {self.tape.slopes[i][0] for i in self.mode.in_jacobian if i in self.tape.slopes}
        return {i for i in used & self.mode.in_jet if not self.tape.is_number(i)}

    def _beginning(self, nodes: set[int]) -> list[int]:
        """Nodes whose coefficient 0 is computed."""
        return [i for i in sorted(nodes) if not self.tape.is_number(i)]

    def _continuing(self, nodes: set[int]) -> list[int]:
        """Nodes that are computed above order 0: without states, and without what only starts a sine in time."""
        tape, kept = self.tape, self._beginning(nodes)
        used = {i for i in kept if i in self.mode.guards or i in self.rows}
        for rate in self.mode.rates:
            node = tape.nodes[rate]
            used.update(node.args if node.op == "linear" else (rate,))
        for i in reversed(kept):
            if i in used:
                used.update(tape.nodes[i].args if tape.turning(i) is None else ())
        used.update(tape.slopes[i][0] for i in tuple(used) if i in tape.slopes)
        return [i for i in kept if i in used and tape.nodes[i].op != "state"]

    def _recurrences(self, f: Function, row_of: Any, c: Row, columns: Any) -> Recurrences:
        rows = {index: row_of(place) for index, place in self.rows.items()}
        slope_rows = {index: row_of(place) for index, place in self.slope_rows.items()}
        last = Index(f, f.arguments[0])
        expansions = {i: Expansion(f.table(row_of(place).data, columns), last) for i, place in self.expanded.items()}
        return Recurrences(f, self.tape, rows, slope_rows, self.mode.constants.loaded(f, c), expansions)

    def _store(self, made: Recurrences, index: int, k: Any) -> None:
        """Keep coefficient k of a node, if it has a row."""
        if index in self.rows and self.tape.nodes[index].op != "state":
            made.rows[index][k] = made.now[index].now
        if index in self.slope_rows:
            order = k.number() if isinstance(k, Index) else made.function.number(k)
            slope = order * made.now[index].now
            made.slope_now.setdefault(index, made.function.variable()).become(slope)
            made.slope_rows[index][k] = slope

    def jet(self, module: Module, name: str) -> Any:
        """Write ``(order, t, c, x, ws, columns)``: coefficients of states, quadratures and guards up to ``order``."""
        row = DOUBLE.as_pointer()
        types = {"order": INT, "t": module.type, "c": row, "x": row, "ws": row, "columns": INT}
        return module.in_parts(name, types, self._write_jet)

    def _write_jet(self, f: Function) -> None:
        order, t, c, x = (Index(f, f.arguments[0]), Number(f, f.arguments[1]), *map(f.row, f.arguments[2:4]))
        with f.at_entry():
            ws = _rows(f, f.table(f.arguments[4], f.arguments[5]))
        made = self._recurrences(f, ws, c, f.arguments[5])
        count = len(self.mode.rates)
        states = {i: self.tape.nodes[i].value for i in self.mode.in_jet if self.tape.nodes[i].op == "state"}
        for i in range(count):
            ws(i)[0] = x[i] if i < self.n else 0.0
        for index in self._beginning(self.mode.in_jet):
            made.become(index, made.start(index, x, t))
            if index in self.rows and index not in states:
                made.rows[index][0] = made.now[index].now
        for j, guard in enumerate(self.mode.guards):
            ws(count + j)[0] = made.value(guard)
        following = [f.variable(made.value(rate)) for rate in self.mode.rates]

        def before(k: Any) -> None:
            for i, next_one in enumerate(following):
                ws(i)[k] = next_one.now
            for index, state in states.items():
                made.become(index, following[state].now)
                if index in self.slope_rows:
                    self._store(made, index, k)

        def after(k: Any) -> None:
            for j, guard in enumerate(self.mode.guards):
                ws(count + j)[k] = 0.0 if self.tape.is_number(guard) else made.now[guard].now
            jk = f.reciprocal(k + 1) if isinstance(k, Index) else f.number(1.0 / (k + 1))
            for rate, next_one in zip(self.mode.rates, following, strict=True):
                next_one.become(self._next(made, rate, jk))

        nodes = self._continuing(self.mode.in_jet)
        made.passes(nodes, order, before, after, lambda index, k: self._store(made, index, k))

    def _next(self, made: Recurrences, rate: int, jk: Number) -> Number:
        """Coefficient k + 1 of a state; every term is divided on its own, so that the last one need not wait."""
        if self.tape.is_number(rate):
            return made.function.number(0.0)
        if self.tape.nodes[rate].op != "linear":
            return jk * made.now[rate].now
        return total([(jk if w == 1 else jk * made.constants[w]) * made.now[i].now for w, i in made.terms(rate)])

    def jacobian_jet(self, module: Module, name: str) -> Any:
        """Write ``(order, c, ws, columns)``: coefficients of the Jacobian's entries that the jet does not hold."""
        row = DOUBLE.as_pointer()
        types = {"order": INT, "c": row, "ws": row, "columns": INT}
        return module.in_parts(name, types, self._write_jacobian_jet)

    def _write_jacobian_jet(self, f: Function) -> None:
        if not self.mode.in_jacobian:
            return
        with f.at_entry():
            ws = _rows(f, f.table(f.arguments[2], f.arguments[3]))
        made = self._recurrences(f, ws, f.row(f.arguments[1]), f.arguments[3])
        inputs = sorted(self._inputs())

        def read(k: Any) -> None:
            for index in inputs:
                made.become(index, made.rows[index][k])
                if index in self.slope_rows and k != 0:
                    slope = made.slope_rows[index][k]
                    made.slope_now.setdefault(index, f.variable()).become(slope)

        read(0)
        for index in self._beginning(self.mode.in_jacobian):
            made.become(index, made.start(index, Row(f, None), f.number(0.0)))
            if index in self.rows:
                made.rows[index][0] = made.now[index].now
        nodes = self._continuing(self.mode.in_jacobian)
        made.passes(nodes, Index(f, f.arguments[0]), read, lambda k: None, lambda i, k: self._store(made, i, k))

    def tangent(self, module: Module, name: str) -> Any:
        """Write ``(order, c, first, second, ws, columns, row)``: coefficients of two tangent vectors.

        The rows from ``row`` hold the n series of one vector, then those of the other. All modes fill them up to
        ``order`` + 1, for one polynomial must not end in what another mode has left.
        """
        row = DOUBLE.as_pointer()
        vectors = {"first": row, "second": row}
        types = {"order": INT, "c": row, **vectors, "ws": row, "columns": INT, "row": INT}
        return module.in_parts(name, types, lambda f: _Tangents(self, f).write())

    def variation(self, module: Module, name: str) -> Any:
        """Write ``(t, c, x, d, out)``: the Jacobian times d."""
        row = DOUBLE.as_pointer()
        f = Function(module, name, {"t": DOUBLE, "c": row, "x": row, "d": row, "out": row}, own=True)
        c, x, d, out = (f.row(argument) for argument in f.arguments[1:])
        made = Recurrences(f, self.tape, {}, {}, self.mode.constants.loaded(f, c))
        for index in self._beginning(self.tape.reach(sorted(self.mode.wanted))):
            value = made.start(index, x, Number(f, f.arguments[0]))
            node = self.tape.nodes[index]
            if node.op == "power" and node.name == POSITIVE:
                value = f.choose(made.value(node.args[0]).compare(">", 0.0), value, 0.0)
            made.become(index, value)
        for i in range(self.n):
            terms = []
            for j in self.mode.columns[i]:
                entry = [made.constants[self.mode.linear[i, j]]] if (i, j) in self.mode.linear else []
                if (i, j) in self.mode.products:
                    index, weight = self.mode.products[i, j]
                    entry.append(made.constants.times(weight, made.value(index)))
                terms.append(total(entry) * d[j])
            out[i] = total(terms) if terms else 0.0
        f.end()
        return f.made


def _rows(f: Function, table: Any) -> Any:
    """Rows of a table by their places, each found once."""
    found: dict[int, Row] = {}

    def row_of(place: int) -> Row:
        if place not in found:
            with f.at_entry():
                found[place] = table[place]
        return found[place]

    return row_of


class _Tangents:
    """The code of two solutions of the variational equation.

    The Jacobian's series is known, so that a pass sums all older coefficients of four orders at once; what is left
    between one order and the next is a product with the Jacobian at the start, whose entries wait in registers.
    """

    def __init__(self, series: InLine, f: Function) -> None:
        self.mode = mode = series.mode
        self.rows, self.f, n = series.rows, f, mode.n
        order, c, first, second, ws, columns, row = f.arguments
        self.order = Index(f, order)
        self.constants = mode.constants.loaded(f, f.row(c))
        table = f.table(ws, columns)
        with f.at_entry():
            self.ws = _rows(f, table)
            self.kept = [[table[Index(f, row) + v * n + i] for i in range(n)] for v in range(2)]
        starts = (f.row(first), f.row(second))
        self.now = [[f.variable(start[i]) for i in range(n)] for start in starts]
        self.pairs = sorted((series.rows[index], j) for index, j in mode.convolved())
        self.needed = {j for _, j in self.pairs}

    def write(self) -> None:
        """The whole function."""
        f = self.f
        for rows, numbers in zip(self.kept, self.now, strict=True):
            for row, number in zip(rows, numbers, strict=True):
                row[0] = number.now
        history = {row: self.ws(row) for row, _ in self.pairs}
        self.begun = {row: [data[k] for k in range(TUNING.orders_in_pass)] for row, data in history.items()}
        self.start = self._jacobian_at_start()
        lanes = TUNING.orders_in_pass if self.pairs else 1
        with f.loop(0, self.order + 1, lanes) as base:
            self.old = {(v, *pair): sums for pair in self.pairs for v, sums in enumerate(self._older(*pair, base))}
            self.in_pass: list[list[list[Number]]] = [[[] for _ in range(self.mode.n)] for _ in range(2)]
            for lane in range(lanes):
                self._one_order(base + lane, lane)

    def _jacobian_at_start(self) -> dict[tuple[int, int], Number]:
        mode = self.mode
        start = {place: self.constants[entry] for place, entry in mode.linear.items()}
        for place, (index, weight) in mode.products.items():
            product = self.constants.times(weight, self.ws(self.rows[index])[0])
            start[place] = start[place] + product if place in start else product
        return start

    def _older(self, row: int, j: int, base: Index) -> list[list[Number]]:
        """For both vectors and four orders: sums over all coefficients below ``base``, two chains a sum."""
        return sums_of_older(self.f, self.ws(row), [rows[j] for rows in self.kept], base)

    def _one_order(self, k: Index, lane: int) -> None:
        ik = self.f.reciprocal(k + 1)
        start = {place: ik * value for place, value in self.start.items()}
        following = [[self._next(start, ik, i, v, lane) for i in range(self.mode.n)] for v in range(2)]
        for v in range(2):
            for i, number in enumerate(self.now[v]):
                if i in self.needed:
                    self.in_pass[v][i].append(number.now)
                self.kept[v][i][k + 1] = number.become(following[v][i])

    def _next(self, start: dict[tuple[int, int], Number], ik: Number, i: int, v: int, lane: int) -> Number:
        """Coefficient k + 1 of entry i: what is old first, the product with the Jacobian at the start last."""
        old: list[Number] = []
        for j in self.mode.columns[i]:
            if (i, j) in self.mode.products:
                index, weight = self.mode.products[i, j]
                row = self.rows[index]
                if (v, row, j) not in self.old:
                    continue
                inner = self.old[v, row, j][lane]
                for m in range(lane):
                    inner = inner + self.begun[row][lane - m] * self.in_pass[v][j][m]
                old.append(self.constants.times(weight, inner))
        terms = [start[i, j] * self.now[v][j].now for j in self.mode.columns[i] if (i, j) in start]
        if old:
            terms.insert(0, ik * total(old))
        return total(terms) if terms else self.f.number(0.0)
