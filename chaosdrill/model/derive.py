"""Symbolic derivatives of a system's expressions."""

from collections.abc import Mapping, Set
from functools import partial
from typing import TYPE_CHECKING, Any

import sympy

from chaosdrill.model.gates import without_overflow
from chaosdrill.model.python import HIGHEST, Along, Called, opaque
from chaosdrill.model.transition import Transition
from chaosdrill.model.tuning import TUNING
from chaosdrill.model.values import Definition, System

if TYPE_CHECKING:
    import numpy as np


class _Floor(sympy.Function):
    """floor, with the derivative it has between its jumps."""

    def fdiff(self, argindex: int = 1) -> Any:
        return sympy.Integer(0)


def differentiate(expression: Any, symbol: Any) -> Any:
    """Derivative between the jumps: that of ``Mod(u, m)`` is u' - floor(u/m) m', that of ``floor`` is 0."""
    if not expression.has(sympy.Mod, sympy.floor):
        return without_overflow(sympy.diff(expression, symbol))
    opened = expression.replace(sympy.Mod, lambda u, m: u - m * _Floor(u / m)).replace(sympy.floor, _Floor)
    return without_overflow(sympy.diff(opened, symbol).replace(_Floor, sympy.floor))


_STEPS = (sympy.sign, sympy.Heaviside, sympy.floor, sympy.ceiling, sympy.Mod)


def jacobian_entries(system: System, mode: str) -> dict[tuple[int, int], Any]:
    """Derivatives of the field of one mode by the states, without those that are zero everywhere."""
    return _entries(system, [system.modes[mode][s] for s in system.states])


def _entries(system: System, expressions: list[Any]) -> dict[tuple[int, int], Any]:
    """Derivatives of expressions by the states, without those that are zero everywhere."""
    column = {x: j for j, x in enumerate(system.states)}
    known: dict[Any, dict[Any, Any]] = {}
    found: dict[tuple[int, int], Any] = {}
    for i, e in enumerate(expressions):
        slopes = _slopes(sympy.sympify(e), column.keys(), known)
        found |= {(i, j): slopes[x] for x, j in column.items() if slopes.get(x, 0) != 0}
    return found


def _slopes(e: Any, states: Set[Any], known: dict[Any, dict[Any, Any]]) -> dict[Any, Any]:
    """Derivatives of an expression by those of the states that it names; ``known`` are those of its parts.

    sympy's own derivatives go through the whole expression once a state.
    """
    if e in states:
        return {e: sympy.Integer(1)}
    if not e.args:
        return {}
    if e not in known:
        found: dict[Any, list[Any]] = {}
        if e.is_Add:
            parts = [(sympy.Integer(1), term) for term in e.args]
        elif e.is_Mul:
            parts = [(sympy.Mul(*e.args[:i], *e.args[i + 1 :]), factor) for i, factor in enumerate(e.args)]
        elif e.is_Pow and not e.exp.free_symbols & states:
            parts = [(e.exp * e.base ** (e.exp - 1), e.base)]
        else:
            parts = []
            found = {x: [differentiate(e, x)] for x in e.free_symbols & states}
        for factor, part in parts:
            for x, slope in _slopes(part, states, known).items():
                found.setdefault(x, []).append(factor * slope)
        known[e] = {x: sympy.Add(*terms) for x, terms in found.items()}
    return known[e]


def jacobian(system: System, mode: str) -> sympy.Matrix:
    """Derivative of the field of one mode, shape (n, n)."""
    n = len(system.states)
    return sympy.SparseMatrix(n, n, jacobian_entries(system, mode)).as_mutable()


def derivative_along(expression: Any, direction: Mapping[Any, Any]) -> Any:
    """Derivative of an expression where symbols change at these rates; a Python function is called once for it."""
    if isinstance(expression, Called) and not expression.by:
        changes = [derivative_along(number, direction) for number in expression.numbers]
        return Along(expression.source, expression.place, *expression.numbers, *changes)
    return sympy.Add(
        *(differentiate(expression, x) * way for x, way in direction.items() if x in expression.free_symbols)
    )


def time_derivative(system: System, expression: Any) -> Any:
    """Explicit derivative with respect to time."""
    return sympy.Integer(0) if system.time is None else differentiate(expression, system.time)


def guard_gradient(system: System, guard: Any) -> list[Any]:
    """Derivatives of a guard with respect to the states and, last, to time: n + 1 expressions."""
    known = sympy.sympify(guard).free_symbols
    zero = sympy.Integer(0)
    return [*(differentiate(guard, x) if x in known else zero for x in system.states), time_derivative(system, guard)]


def image_of(system: System, transition: Transition) -> dict[Any, Any]:
    """Each state after the event as an expression of those before it."""
    return {x: transition.reset.get(x, x) for x in system.states}


def reset_map(system: System, transition: Transition) -> list[Any]:
    """The same in the order of the states."""
    return list(image_of(system, transition).values())


def reset_entries(system: System, transition: Transition) -> dict[tuple[int, int], Any]:
    """Derivatives of the reset map by states and, in column n, by time, where they are not those of the identity."""
    n, image = len(system.states), reset_map(system, transition)
    reset = [i for i, x in enumerate(system.states) if image[i] != x]
    found = {(reset[k], j): e for (k, j), e in _entries(system, [image[i] for i in reset]).items()}
    found |= {(i, n): slope for i in reset if (slope := time_derivative(system, image[i])) != 0}
    return {(i, i): sympy.Integer(0) for i in reset} | found


def reset_jacobian(system: System, transition: Transition) -> list[list[Any]]:
    """Derivatives of the reset map, n rows of n + 1 expressions (the last by time)."""
    return [
        [*(differentiate(r, x) for x in system.states), time_derivative(system, r)]
        for r in reset_map(system, transition)
    ]


def rate(system: System, mode: str, expression: Any) -> Any:
    """Time derivative of an expression along the flow of a mode."""
    return sympy.Add(*rate_by_states(system, mode, expression))


def rate_by_states(system: System, mode: str, expression: Any) -> list[Any]:
    """The terms of that, one for each state that moves it, and one for time."""
    moving = [x for x in system.states if x in expression.free_symbols]
    along = [differentiate(expression, x) * system.modes[mode][x] for x in moving]
    return [*along, time_derivative(system, expression)]


def throw(system: System, transition: Transition, surface: Any) -> tuple[Any, Any, Any]:
    """Speed, acceleration and its rate with which a transition leaves a surface, as functions of the state before it.

    They are derivatives of the surface's expression along the motion after the transition. The rate counts
    as zero where it is unknown, for a guard that is a Python function.
    """
    image = image_of(system, transition)
    speed = rate(system, transition.target, surface)
    pull = rate(system, transition.target, speed)
    jerk = rate(system, transition.target, pull)
    if any(len(called.by) > HIGHEST for called in jerk.atoms(Called)):
        jerk = sympy.Integer(0)
    return speed.xreplace(image), pull.xreplace(image), jerk.xreplace(image)


def saltation(system: System, transition: Transition, source: str | None = None) -> sympy.Matrix:
    """Saltation matrix of a transition as an expression of the state before it, shape (n, n).

    S = DR + (F+ - DR F- - dR/dt) n^T / (n.F- + dh/dt), with R the reset, h the guard and n its gradient (Aizerman and
    Gantmakher 1958; Leine and Nijmeijer 2004, doi:10.1007/978-3-540-44398-8). In a system that is augmented with time
    S F- = F+ holds exactly.
    """
    mode = source or transition.source[0]
    before = sympy.Matrix([system.modes[mode][x] for x in system.states])
    image = image_of(system, transition)
    after = sympy.Matrix([system.modes[transition.target][x] for x in system.states]).xreplace(image)
    rows = reset_jacobian(system, transition)
    n = len(system.states)
    slope = sympy.Matrix([row[:n] for row in rows])
    explicit = sympy.Matrix([row[n] for row in rows])
    gradient = guard_gradient(system, transition.guard)
    normal = sympy.Matrix([gradient[:n]])
    speed = (normal * before)[0, 0] + gradient[n]
    return slope + (after - slope * before - explicit) * normal / speed


Sparse = dict[int, Any]
"""Entries of a row that are not zero everywhere, by column."""


def shift_directions(system: System, *, decides: bool = False) -> list[list[float]]:
    """Directions along which a shift of the state changes nothing, for all parameters: independent n-vectors.

    They are the common null space of all Jacobians, guard gradients, reset Jacobians (less the identity), which is all
    that tangents see. For motions as a whole what ``decides`` counts as well: the sides of relations, and the arguments
    of functions with steps.
    """
    n = len(system.states)
    rows: list[Sparse] = []
    for mode in system.modes:
        rows += _lines(jacobian_entries(system, mode), 0)
    for transition in system.transitions:
        rows.append({j: e for j, e in enumerate(guard_gradient(system, transition.guard)[:n]) if e != 0})
        rows += _lines(_moved(system, transition), 0)
    rows += _lines(_entries(system, _deciding(system)), 0) if decides else []
    # what is drawn has no directions
    rows += [{j: sympy.Integer(1)} for j in range(system.free, n)]
    return _null_directions(rows, n)


def _deciding(system: System) -> list[sympy.Expr]:
    """Of all relations, in conditions and elsewhere, one side less the other, and arguments of functions with steps."""
    told = [e for field in system.modes.values() for e in field.values()]
    for transition in system.transitions:
        told += [transition.guard, *transition.reset.values(), *transition.conditions.values()]
    found: dict[sympy.Expr, None] = {}
    for e in map(sympy.sympify, told):
        found |= {one.lhs - one.rhs: None for one in sorted(e.atoms(sympy.core.relational.Relational), key=str)}
        found |= {step.args[0]: None for step in sorted(e.atoms(*_STEPS), key=str)}
    return list(found)


def deciding_states(system: System) -> set[int]:
    """Numbers of the states that relations and steps see."""
    return {i for e in _deciding(system) for i, x in enumerate(system.states) if x in e.free_symbols}


def turns(system: System) -> "list[tuple[sympy.Expr, list[int]]]":
    """Shifts by which nothing ever changes though the states enter sines or cosines: lengths, and the states shifted.

    An angle may be shifted by its period where fields and guards come back, and the resets to what is shifted as well;
    angles that resets carry over to others are shifted together with them. Angles enter with coefficients that are
    rational parts of each other, numbers or expressions of parameters; such a shift is proved by putting it in.
    """
    found: list[tuple[sympy.Expr, list[int]]] = []
    # a decimal number that is shifted and shifted back may be another one
    exact = partial(sympy.nsimplify, rational=True)
    wholes = [exact(e) for mode in system.modes for e in system.modes[mode].values()]
    wholes += [exact(e) for e in (*(t.guard for t in system.transitions), *_deciding(system))]
    resets = [{x: exact(e) for x, e in image_of(system, t).items()} for t in system.transitions]
    entries = (*wholes, *(e for reset in resets for e in reset.values()))
    waves = {wave for e in entries for wave in e.atoms(sympy.sin, sympy.cos, sympy.tan, sympy.cot)}
    moving = {*system.states, system.time}
    for state in system.states[: system.free]:
        slopes = sorted({sympy.diff(w.args[0], state) for w in waves} - {sympy.Integer(0)}, key=sympy.default_sort_key)
        if not slopes or slopes[0].free_symbols & moving:
            continue
        parts = [abs(sympy.cancel(slope / slopes[0])) for slope in slopes]
        if not all(part.is_Rational for part in parts):
            continue
        unit = slopes[0] * sympy.gcd_list(parts)
        length = 2 * sympy.pi / (abs(unit) if unit.is_number else unit)
        together = {state}
        while True:
            shifted = {x: x + length for x in together}
            carried = set()
            for reset in resets:
                for x, e in reset.items():
                    change = e.xreplace(shifted) - e
                    if x not in together and _vanishes(change - length):
                        carried.add(x)
            if not carried:
                break
            together |= carried
        if all(_vanishes(e.xreplace(shifted) - e) for e in wholes) and all(
            _vanishes(e.xreplace(shifted) - e - (length if x in together else 0))
            for reset in resets
            for x, e in reset.items()
        ):
            turn = (length, [i for i, x in enumerate(system.states) if x in together])
            found += [] if turn in found else [turn]
    return found


def conserved_combinations(system: System) -> list[list[float]]:
    """Linear combinations of the states whose tangents nothing ever changes: n numbers each, linearly independent.

    They are the common null space, from the left, of all Jacobians, of all reset Jacobians (less the identity), and of
    what the flow jumps by at an event: the saltation matrix leaves them as they are.
    """
    n = len(system.states)
    rows: list[Sparse] = []
    for mode in system.modes:
        rows += _lines(jacobian_entries(system, mode), 1)
    for transition in system.transitions:
        rows += _lines(_moved(system, transition), 1)
        image = image_of(system, transition)
        by_time = {i: e for (i, j), e in reset_entries(system, transition).items() if j == n}
        for source in transition.source:
            before, after = system.modes[source], system.modes[transition.target]
            jumps = (
                sympy.sympify(after[x]).xreplace(image) - before[x] - by_time.get(i, 0)
                for i, x in enumerate(system.states)
            )
            rows.append({i: jump for i, jump in enumerate(jumps) if jump != 0})
    return _null_directions(rows, n)


def conserved_by(system: System, mode: str, states: list[int]) -> list[list[float]]:
    """Linear combinations of some states that the flow of one mode changes evenly or not at all: n numbers each."""
    lines: dict[int, Sparse] = {}
    for (i, j), e in jacobian_entries(system, mode).items():
        if i in states:
            lines.setdefault(j, {})[states.index(i)] = e
    found = []
    for row in _null_directions(list(lines.values()), len(states)):
        whole = [0.0] * len(system.states)
        for i, c in zip(states, row, strict=True):
            whole[i] = c
        found.append(whole)
    return found


def _moved(system: System, transition: Transition) -> dict[tuple[int, int], Any]:
    """The reset's derivatives by the states, less the identity, without those that are zero everywhere."""
    n = len(system.states)
    found = {(i, j): e - int(i == j) for (i, j), e in reset_entries(system, transition).items() if j < n}
    return {place: e for place, e in found.items() if e != 0}


def _lines(entries: dict[tuple[int, int], Any], axis: int) -> list[Sparse]:
    """Rows (axis 0) or columns (axis 1) of a sparse matrix."""
    lines: dict[int, Sparse] = {}
    for place, e in entries.items():
        lines.setdefault(place[axis], {})[place[1 - axis]] = e
    return list(lines.values())


def _null_directions(rows: list[Sparse], n: int) -> list[list[float]]:
    """Constant vectors that all rows of expressions vanish on.

    Candidates are the null space at random numbers; only those for which every row vanishes as an expression count.
    """
    import numpy as np

    plain = [row for row in rows if not any(opaque(sympy.sympify(e)) for e in row.values())]
    matrix = np.vstack([*_samples(plain, n), np.zeros((n, n))])
    _, weights, directions = np.linalg.svd(np.linalg.qr(matrix, mode="r"))
    candidates = directions[weights <= TUNING.null_weight * max(weights.max(), 1e-300)]
    null = sympy.Matrix(np.round(candidates, TUNING.null_digits).tolist())
    if null.rows == 0:
        return []
    found = []
    for row in np.array(null.rref(iszerofunc=lambda e: abs(e) < TUNING.null_pivot)[0].tolist(), dtype=float):
        direction = [sympy.nsimplify(round(entry, 7), rational=True) for entry in row]
        if any(direction) and all(_vanishes(sympy.Add(*(e * direction[j] for j, e in r.items()))) for r in rows):
            found.append([float(d) for d in direction])
    return found


_MEROMORPHIC = (
    sympy.Add,
    sympy.Mul,
    sympy.exp,
    sympy.sin,
    sympy.cos,
    sympy.tan,
    sympy.cot,
    sympy.sinh,
    sympy.cosh,
    sympy.tanh,
)


def _vanishes(expression: Any) -> bool:
    """Whether an expression is zero.

    Its values decide where it is meromorphic, and where one of them is not zero; else simplification does.
    """
    if expression == 0:
        return True
    if expression.has(Called):
        return bool(sympy.expand(expression) == 0)
    seen = _values_vanish(expression)
    parts = [one for one in sympy.preorder_traversal(expression) if one.args]
    if seen is False or (
        seen and all(isinstance(one, _MEROMORPHIC) or (one.is_Pow and one.exp.is_Integer) for one in parts)
    ):
        return seen
    small = len(parts) <= TUNING.simplified
    return bool(sympy.expand(expression) == 0 or (small and sympy.simplify(expression) == 0))


def _values_vanish(expression: Any) -> bool | None:
    """Whether an expression is zero at random numbers, in two precisions; None where it has no values.

    Of one that is zero they show rounding alone, of which each precision has its own.
    """
    import random

    import mpmath

    names, rng = sorted(expression.free_symbols, key=str), random.Random(20260103)
    exact = expression.xreplace({one: sympy.Rational(repr(float(one))) for one in expression.atoms(sympy.Float)})
    told = False
    try:
        value = sympy.lambdify(names, exact, modules="mpmath", cse=True)
        for _ in range(TUNING.null_samples):
            place = [rng.choice((-1, 1)) * rng.uniform(*TUNING.drawn) for _ in names]
            found = []
            for digits in TUNING.null_precisions:
                with mpmath.workdps(digits):
                    found.append(mpmath.mpmathify(value(*map(mpmath.mpf, place))))
            rough, fine = found
            if mpmath.isfinite(fine):
                told = True
                if abs(fine - rough) < abs(fine) / 2:
                    return False
    except (ArithmeticError, AttributeError, NameError, TypeError, ValueError):
        return None
    return True if told else None


def _samples(rows: list[Sparse], n: int) -> "list[np.ndarray]":
    """The rows at four times random numbers for their symbols; where one is no number it is left out."""
    import numpy as np

    entries = list(dict.fromkeys(e for row in rows for e in row.values()))
    names = sorted({symbol for e in entries for symbol in sympy.sympify(e).free_symbols}, key=str)
    evaluate = sympy.lambdify(names, entries, modules="numpy")
    rng, place = np.random.default_rng(20260103), {e: k for k, e in enumerate(entries)}
    found = []
    for _ in range(TUNING.null_samples):
        with np.errstate(all="ignore"):
            values = np.array(evaluate(*rng.uniform(*TUNING.drawn, len(names))), dtype=float)
        matrix = np.zeros((len(rows), n))
        for line, row in zip(matrix, rows, strict=True):
            line[list(row)] = [values[place[e]] for e in row.values()]
            # in whatever units the rows are
            line /= np.abs(line).max(initial=0.0) or 1.0
        found.append(matrix[np.isfinite(matrix).all(axis=1)])
    return found


def frozen_states(system: Definition) -> list[Any]:
    """States that never change: no mode moves them and no transition resets them."""
    reset = {x for t in system.transitions for x in t.reset}
    return [x for x in system.states if x not in reset and all(f[x] == 0 for f in system.modes.values())]


def pinned_states(system: System, mode: str, known: Set[Any] = frozenset()) -> tuple[int, ...]:
    """States that a mode holds at a constant or leads along a function of time.

    Every way in resets them to a number, or to a function of time whose derivative is their rate there, so that they
    follow it whenever the mode began: the state has no freedom in that direction, so no tangent either. A state whose
    value is carried into the mode is frozen, not pinned. States that are ``known`` count as numbers.
    """
    unknown = set(system.states) - known
    ways_in = [t for t in system.transitions if t.target == mode and set(t.source) != {mode}]
    within = [t for t in system.transitions if t.target == mode and t not in ways_in]

    def follows(x: Any, t: Transition) -> bool:
        value = t.reset.get(x)
        if value is None or value.free_symbols & unknown:
            return False
        gap = time_derivative(system, value) - system.modes[mode][x]
        return bool(gap == 0 or (not gap.free_symbols & unknown and sympy.simplify(gap) == 0))

    return tuple(
        i
        for i, x in enumerate(system.states)
        if ways_in
        and all(follows(x, t) for t in ways_in)
        and all(follows(x, t) or t.reset.get(x, x) == x for t in within)
    )


def pinned_values(system: System, mode: str) -> dict[int, Any]:
    """Values at which a mode pins states, as functions of time; states whose entries differ are left out."""
    ways_in = [t for t in system.transitions if t.target == mode and set(t.source) != {mode}]
    values = {i: {t.reset[system.states[i]] for t in ways_in} for i in pinned_states(system, mode)}
    return {i: found.pop() for i, found in values.items() if len(found) == 1}
