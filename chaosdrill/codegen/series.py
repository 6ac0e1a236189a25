"""Taylor coefficients of one mode and of its tangents, as LLVM code.

Row i of the workspace holds the coefficients of state i, then come those of the quadratures and of the guards, then the
history that products and functions need, then the tangents.
"""

from typing import TYPE_CHECKING, Any

from chaosdrill.codegen.emitter import DOUBLE, INT, Function, Index, Module, Number, Row, total
from chaosdrill.codegen.recurrence import PASS, Expansion, Recurrences, sums_of_older
from chaosdrill.codegen.signatures import WIDTH
from chaosdrill.codegen.tables import Operations
from chaosdrill.codegen.tape import POSITIVE, Tape

if TYPE_CHECKING:
    from chaosdrill.codegen.constants import Constants
    from chaosdrill.model.system import HybridSystem

IN_LINE = 48
"""Products of series of a mode whose operations are written in line; of a larger one they stand in tables."""

SUMS = 8 * IN_LINE
"""The same for terms of sums."""

_HISTORY = {"mul", "square", "div", "power", "log", "integral", "expanded"}


class ModeSeries:
    """The nodes behind the series of one mode, and the rows that the series fill.

    Attributes
    ----------
    kept : list of int
        Nodes whose variations are computed by themselves; behind the states they are rows and columns of the Jacobian.
    linear : dict of (int, int) to expression
        Entries of the Jacobian that depend on parameters only.
    products : dict of (int, int) to (int, expression)
        Node and weight, whose product the other entries have besides.
    watched : list of int
        Nodes that steep operations are applied to.
    tables : Operations or None
        What writes the functions of a large mode; those of a small one are written here, in line.
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
        self.in_jet = self._reach([*self.rates, *self.guards, *self.watched])
        self.kept: list[int] = []
        in_line = self._is_small(self.in_jet)
        if in_line:
            self._lower_jacobian()
            pairs = {(index, j) for (_, j), (index, _) in self.products.items()}
            in_line = self._is_small(self.in_jet | self.in_jacobian, len(pairs))
        if not in_line:
            self.tape.keep(self.rates[: self.n])
            self.kept = self.tape.kept
            self._lower_jacobian()
        self.rows: dict[int, int] = {}
        self.slope_rows: dict[int, int] = {}
        self.tables = None if in_line else Operations(self)
        self.row_count = self._assign_rows() if self.tables is None else self.tables.row_count

    def _is_small(self, nodes: set[int], products: int = 0) -> bool:
        found = [self.tape.nodes[i] for i in nodes]
        products += sum(node.op in _HISTORY for node in found)
        return products <= IN_LINE and sum(len(node.args) for node in found if node.op == "linear") <= SUMS

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
        self._columns: list[list[int]] = [[] for _ in range(self.n + len(self.kept))]
        for i, j in sorted({*self.linear, *self.products}):
            self._columns[i].append(j)
        self.wanted = {index for index, _ in self.products.values()}
        self.in_jacobian = self._reach(sorted(self.wanted)) - self.in_jet

    def watched_rows(self) -> list[int]:
        """Rows of what the steep operations are applied to."""
        rows = self.rows
        if self.tables is not None:
            rows = {i: row for (kind, i), row in self.tables.rows.items() if kind == "node"}
        return [rows.get(i, -1) for i in self.watched]

    def columns_of(self, i: int) -> list[int]:
        """The states that the rate of state i depends on."""
        return self._columns[i]

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

    def _assign_rows(self) -> int:
        """Give a row to every node whose history is read; returns the number of rows."""
        tape, need = self.tape, set(self.wanted)
        for index in self.in_jet | self.in_jacobian:
            node = tape.nodes[index]
            if node.op in _HISTORY and not tape.is_known(index):
                need.update([index, *node.args])
                if index in tape.slopes:
                    need.add(tape.slopes[index][0])
        need |= {*self._inputs(), *self.watched}
        free = len(self.rates) + len(self.guards)
        for index in sorted(need):
            node = tape.nodes[index]
            if node.op == "state":
                self.rows[index] = node.value
            elif not tape.is_number(index):
                self.rows[index] = free
                free += 1
        for index in sorted(self.in_jet | self.in_jacobian):
            node = tape.nodes[index]
            if node.op == "integral" and tape.turning(index) is None and node.args[0] not in self.slope_rows:
                self.slope_rows[node.args[0]] = free
                free += 1
        self.expanded: dict[int, int] = {}
        """Nodes with an expansion, and the rows from which it stands."""
        for index in sorted(self.in_jet | self.in_jacobian):
            if tape.nodes[index].op == "expanded" and not tape.is_still(index):
                self.expanded[index] = free
                free += WIDTH
        return free

    def _inputs(self) -> set[int]:
        """Nodes of the jet from which the Jacobian's own nodes are made."""
        used = {a for i in self.in_jacobian for a in self.tape.nodes[i].args}
        used |= {self.tape.slopes[i][0] for i in self.in_jacobian if i in self.tape.slopes}
        return {i for i in used & self.in_jet if not self.tape.is_number(i)}

    def _beginning(self, nodes: set[int]) -> list[int]:
        """Nodes whose coefficient 0 is computed."""
        return [i for i in sorted(nodes) if not self.tape.is_number(i)]

    def _continuing(self, nodes: set[int]) -> list[int]:
        """Nodes that are computed above order 0: without states, and without what only starts a sine in time."""
        tape, kept = self.tape, self._beginning(nodes)
        used = {i for i in kept if i in self.guards or i in self.rows}
        for rate in self.rates:
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
        return Recurrences(f, self.tape, rows, slope_rows, self.constants.loaded(f, c), expansions)

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
        if self.tables is not None:
            return self.tables.jet(module, name)
        row = DOUBLE.as_pointer()
        types = {"order": INT, "t": module.type, "c": row, "x": row, "ws": row, "columns": INT}
        return module.in_parts(name, types, self._write_jet)

    def _write_jet(self, f: Function) -> None:
        order, t, c, x = (Index(f, f.arguments[0]), Number(f, f.arguments[1]), *map(f.row, f.arguments[2:4]))
        with f.at_entry():
            ws = _rows(f, f.table(f.arguments[4], f.arguments[5]))
        made = self._recurrences(f, ws, c, f.arguments[5])
        count = len(self.rates)
        states = {i: self.tape.nodes[i].value for i in self.in_jet if self.tape.nodes[i].op == "state"}
        for i in range(count):
            ws(i)[0] = x[i] if i < self.n else 0.0
        for index in self._beginning(self.in_jet):
            made.become(index, made.start(index, x, t))
            if index in self.rows and index not in states:
                made.rows[index][0] = made.now[index].now
        for j, guard in enumerate(self.guards):
            ws(count + j)[0] = made.value(guard)
        following = [f.variable(made.value(rate)) for rate in self.rates]

        def before(k: Any) -> None:
            for i, next_one in enumerate(following):
                ws(i)[k] = next_one.now
            for index, state in states.items():
                made.become(index, following[state].now)
                if index in self.slope_rows:
                    self._store(made, index, k)

        def after(k: Any) -> None:
            for j, guard in enumerate(self.guards):
                ws(count + j)[k] = 0.0 if self.tape.is_number(guard) else made.now[guard].now
            jk = f.reciprocal(k + 1) if isinstance(k, Index) else f.number(1.0 / (k + 1))
            for rate, next_one in zip(self.rates, following, strict=True):
                next_one.become(self._next(made, rate, jk))

        nodes = self._continuing(self.in_jet)
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
        if self.tables is not None:
            return self.tables.jacobian_jet(module, name)
        row = DOUBLE.as_pointer()
        types = {"order": INT, "c": row, "ws": row, "columns": INT}
        return module.in_parts(name, types, self._write_jacobian_jet)

    def _write_jacobian_jet(self, f: Function) -> None:
        if not self.in_jacobian:
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
        for index in self._beginning(self.in_jacobian):
            made.become(index, made.start(index, Row(f, None), f.number(0.0)))
            if index in self.rows:
                made.rows[index][0] = made.now[index].now
        nodes = self._continuing(self.in_jacobian)
        made.passes(nodes, Index(f, f.arguments[0]), read, lambda k: None, lambda i, k: self._store(made, i, k))

    def tangent(self, module: Module, name: str) -> Any:
        """Write ``(order, c, first, second, ws, columns, row)``: coefficients of two tangent vectors.

        The rows from ``row`` hold the n series of one vector, then those of the other. All modes fill them up to
        ``order`` + 1, for one polynomial must not end in what another mode has left.
        """
        if self.tables is not None:
            return self.tables.tangent(module, name)
        row = DOUBLE.as_pointer()
        vectors = {"first": row, "second": row}
        types = {"order": INT, "c": row, **vectors, "ws": row, "columns": INT, "row": INT}
        return module.in_parts(name, types, lambda f: _Tangents(self, f).write())

    def variation(self, module: Module, name: str) -> Any:
        """Write ``(t, c, x, d, out)``: the Jacobian times d."""
        if self.tables is not None:
            return self.tables.variation(module, name)
        row = DOUBLE.as_pointer()
        f = Function(module, name, {"t": DOUBLE, "c": row, "x": row, "d": row, "out": row}, own=True)
        c, x, d, out = (f.row(argument) for argument in f.arguments[1:])
        made = Recurrences(f, self.tape, {}, {}, self.constants.loaded(f, c))
        for index in self._beginning(self._reach(sorted(self.wanted))):
            value = made.start(index, x, Number(f, f.arguments[0]))
            node = self.tape.nodes[index]
            if node.op == "power" and node.name == POSITIVE:
                value = f.choose(made.value(node.args[0]).compare(">", 0.0), value, 0.0)
            made.become(index, value)
        for i in range(self.n):
            terms = []
            for j in self.columns_of(i):
                entry = [made.constants[self.linear[i, j]]] if (i, j) in self.linear else []
                if (i, j) in self.products:
                    index, weight = self.products[i, j]
                    entry.append(made.times(weight, made.value(index)))
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

    def __init__(self, mode: ModeSeries, f: Function) -> None:
        self.mode, self.f, n = mode, f, mode.n
        order, c, first, second, ws, columns, row = f.arguments
        self.order = Index(f, order)
        self.constants = mode.constants.loaded(f, f.row(c))
        table = f.table(ws, columns)
        with f.at_entry():
            self.ws = _rows(f, table)
            self.kept = [[table[Index(f, row) + v * n + i] for i in range(n)] for v in range(2)]
        starts = (f.row(first), f.row(second))
        self.now = [[f.variable(start[i]) for i in range(n)] for start in starts]
        self.pairs = sorted({(mode.rows[index], j) for (_, j), (index, _) in mode.products.items()})
        self.needed = {j for _, j in self.pairs}

    def write(self) -> None:
        """The whole function."""
        f = self.f
        for rows, numbers in zip(self.kept, self.now, strict=True):
            for row, number in zip(rows, numbers, strict=True):
                row[0] = number.now
        history = {row: self.ws(row) for row, _ in self.pairs}
        self.begun = {row: [data[k] for k in range(PASS)] for row, data in history.items()}
        self.start = self._jacobian_at_start()
        lanes = PASS if self.pairs else 1
        with f.loop(0, self.order + 1, lanes) as base:
            self.old = {(v, *pair): sums for pair in self.pairs for v, sums in enumerate(self._older(*pair, base))}
            self.in_pass: list[list[list[Number]]] = [[[] for _ in range(self.mode.n)] for _ in range(2)]
            for lane in range(lanes):
                self._one_order(base + lane, lane)

    def _jacobian_at_start(self) -> dict[tuple[int, int], Number]:
        mode = self.mode
        start = {place: self.constants[entry] for place, entry in mode.linear.items()}
        for place, (index, weight) in mode.products.items():
            product = self._times(weight, self.begun[mode.rows[index]][0])
            start[place] = start[place] + product if place in start else product
        return start

    def _times(self, weight: Any, value: Number) -> Number:
        return value if weight == 1 else self.constants[weight] * value

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
        for j in self.mode.columns_of(i):
            if (i, j) in self.mode.products:
                index, weight = self.mode.products[i, j]
                row = self.mode.rows[index]
                inner = self.old[v, row, j][lane]
                for m in range(lane):
                    inner = inner + self.begun[row][lane - m] * self.in_pass[v][j][m]
                old.append(self._times(weight, inner))
        terms = [start[i, j] * self.now[v][j].now for j in self.mode.columns_of(i) if (i, j) in start]
        if old:
            terms.insert(0, ik * total(old))
        return total(terms) if terms else self.f.number(0.0)
