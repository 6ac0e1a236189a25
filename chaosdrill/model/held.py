"""Surfaces that a mode holds: its field does not leave them, and whatever leads into the mode ends on them.

A state that a mode pins is the simplest one. On a surface the motion has lost a direction, wherever a record begins.
"""

from collections.abc import Callable, Iterable, Sequence
from functools import cache
from typing import TYPE_CHECKING, Any

import sympy

from chaosdrill.model.derive import differentiate, frozen_states, pinned_states, rate_by_states
from chaosdrill.model.places import TIME, parameter
from chaosdrill.model.python import opaque
from chaosdrill.model.transition import Transition
from chaosdrill.model.tuning import TUNING
from chaosdrill.model.values import System

if TYPE_CHECKING:
    import numpy as np


def held_surfaces(system: System) -> dict[str, tuple[Any, ...]]:
    """Expressions of states and time that each mode holds at zero, without those of pinned states alone.

    They are guards of the transitions that lead there, or say what these reset, x - R(x). A mode also holds what the
    modes before it held. All this is the same for all values of the parameters, and of states that never change.
    Those of a system that says of itself what it holds (``shared["held"]``) are not looked for.
    """
    if "held" in system.shared:
        return {mode: system.shared["held"].get(mode, ()) for mode in system.modes}
    frozen = set(frozen_states(system))
    moving = set(system.states) - frozen
    ways = [(source, t) for t in system.transitions if not t.marks_only() for source in t.source]
    zero = Trial(system).zero
    established = {t.name: _established(t, zero, moving) for source, t in ways if source != t.target}
    together = [tuple(surfaces) for surfaces in established.values()]
    groups = dict.fromkeys([*((surface,) for surfaces in together for surface in surfaces), *filter(None, together)])
    held: dict[str, list[Any]] = {mode: [] for mode in system.modes}
    settled = False
    while not settled:
        settled = True
        for group in groups:
            for mode in _modes_on(system, group, ways, held, zero):
                for surface in group:
                    if not (held[mode] and zero(surface, tuple(held[mode]))):
                        held[mode].append(surface)
                        settled = False
    for mode, surfaces in held.items():
        free = moving - {system.states[i] for i in pinned_states(system, mode, frozen)} if surfaces else moving
        held[mode] = [surface for surface in surfaces if surface.free_symbols & free]
    return {mode: tuple(surfaces) for mode, surfaces in held.items()}


def _established(t: Transition, zero: Callable[..., bool], moving: set[Any]) -> list[Any]:
    """Surfaces on which an event ends: its guard, and x - R(x), unless its reset leads away from them."""
    found = [t.guard, *(sympy.numer(sympy.cancel(x - image)) for x, image in t.reset.items() if not opaque(image))]
    return _after(t, zero, [surface for surface in found if surface.free_symbols & moving])


def _after(t: Transition, zero: Callable[..., bool], surfaces: Iterable[Any], on: Iterable[Any] = ()) -> list[Any]:
    """Those of some surfaces on which an event ends that happens on others."""
    put = dict(t.reset)
    return [s for s in surfaces if zero(kept_apart(e.xreplace(put) for e in sympy.Add.make_args(s)), (t.guard, *on))]


def _modes_on(
    system: System,
    group: tuple[Any, ...],
    ways: list[tuple[str, Transition]],
    held: dict[str, list[Any]],
    zero: Callable[..., bool],
) -> list[str]:
    """Modes that hold surfaces together, beside what they are known to hold.

    None of them leaves the surfaces, every way in ends there, and one at least comes from a mode that does not hold
    them: modes that only lead to each other are on a surface if a run begins there.
    """
    whole, modes, count = len(group), list[str](), -1
    entered = {t.target for source, t in ways if source != t.target and len(_after(t, zero, group)) == whole}
    seen, waiting = set[str](), [mode for mode in system.modes if mode in entered]
    while waiting:
        mode = waiting.pop()
        on = tuple(dict.fromkeys([*group, *held[mode]]))
        if mode not in seen and all(zero(kept_apart(rate_by_states(system, mode, surface)), on) for surface in group):
            modes.append(mode)
            waiting += [t.target for source, t in ways if source == mode]
        seen.add(mode)
    while len(modes) != count:
        count = len(modes)
        for source, t in ways:
            known = [*held[source], *(group if source in modes else ())]
            if t.target in modes and len(_after(t, zero, group, known)) < whole:
                modes.remove(t.target)
        founded = {t.target for source, t in ways if source not in modes and t.target in modes}
        for _ in modes:
            founded |= {t.target for source, t in ways if source in founded and t.target in modes}
        modes = [mode for mode in modes if mode in founded]
    return modes


def kept_apart(terms: Iterable[Any]) -> Any:
    """A sum whose terms are kept apart: what rounded numbers leave of those that cancel is small beside them."""
    return sympy.Add(*filter(None, terms), evaluate=False)


class Trial:
    """Tests whether expressions vanish on surfaces, for all times and parameters.

    They are tried at random numbers; what a special or a Python function gives is a number of its own. Beside what is
    as large as 1 anything seems zero whose unit is another one: states of many sizes are tried. Parameters are drawn
    without regard to their values, or ``near`` these and at them: an expression may be a number there only.
    """

    def __init__(self, system: System, *, near: bool = False) -> None:
        self.near = [*system.parameters.values()] if near else []
        self.states = system.states
        self.moving = set(system.states) - set(frozen_states(system))
        self.symbols = [system.time or TIME, *system.states, *map(parameter, system.parameters)]
        self.unknown: dict[Any, int] = {}
        self.points, self.rows, self.rounding = cache(self._points), cache(self._rows), cache(self._rounding)
        self.zero = cache(self._zero)

    def values(self, expression: Any, points: "np.ndarray") -> "np.ndarray":
        """Values of an expression at points, one a column as in ``points``; NaN where it has none."""
        return _rows(_compiled(self.symbols, [expression]), points)[0]

    def _zero(self, expression: Any, surfaces: tuple[Any, ...]) -> bool:
        if expression == 0 or any(expression in (surface, -surface) for surface in surfaces):
            return True
        found = self._vanishing(expression, surfaces, whole=True)
        return found.size >= TUNING.fewest_samples and bool(found.all())

    def has_values(self, expression: Any, surfaces: tuple[Any, ...]) -> bool:
        """Whether an expression is a number at places enough to tell whether it vanishes."""
        return self._vanishing(expression, surfaces).size >= TUNING.fewest_samples

    def _vanishing(self, expression: Any, surfaces: tuple[Any, ...], whole: bool = False) -> "np.ndarray":
        """At which of the points on surfaces an expression vanishes, of those where it is a number.

        As a ``whole`` its rounding is not looked at if it plainly does not at the first.
        """
        import numpy as np

        surfaces = tuple(surface for surface in surfaces if surface.free_symbols & self.moving)
        if any(opaque(surface) for surface in surfaces) or self.points(surfaces)[1].shape[1] < TUNING.fewest_samples:
            return np.zeros(0, bool)
        products = (term.as_coeff_Mul() for term in sympy.Add.make_args(expression))
        terms = [(float(number), term) for number, term in products]
        with np.errstate(all="ignore"):
            values = np.array([number * self.rows(term, surfaces) for number, term in terms])
            left, sizes = np.abs(values[:, 0].sum(axis=0)), np.abs(values).sum(axis=(0, 1))
            # of nothing but zeros nothing is left
            parts = left / np.where(sizes == 0.0, 1.0, sizes)
            if whole and parts[0] > TUNING.plainly_none:
                return np.zeros(0, bool)
            good, small = np.isfinite(parts) & np.isfinite(sizes), parts <= TUNING.vanishing
            # what is left may be the rounding of parts that cancel each other
            if not small[good].all():
                rounding = sum(abs(number) * self.rounding(term, surfaces, number != 1) for number, term in terms)
                small |= left <= TUNING.clear * rounding
        found: np.ndarray = small[good]
        return found

    def _rows(self, term: Any, surfaces: tuple[Any, ...]) -> "np.ndarray":
        """Values of a term at the points on surfaces, and off them."""
        import numpy as np

        symbols, term, values = self._known(term, surfaces)
        return _rows(_compiled(symbols, [term]), np.hstack(values)).reshape(2, -1)

    def _rounding(self, term: Any, surfaces: tuple[Any, ...], multiplied: bool) -> "np.ndarray":
        """By how much a term changes at the points on surfaces with rounded numbers, also one that multiplies it."""
        import numpy as np

        symbols, known, (on, _) = self._known(term, surfaces)
        return _spread(symbols, [known], on)[0] + TUNING.beside * multiplied * np.abs(self.rows(term, surfaces)[0])

    def _known(self, term: Any, surfaces: tuple[Any, ...]) -> "tuple[list[Any], Any, tuple[np.ndarray, np.ndarray]]":
        """Symbols, a term of them, and their values on surfaces and off them; of what is opaque they are drawn."""
        import numpy as np

        off, on = self.points(surfaces)
        unknown = {e: sympy.Dummy(real=True) for e in sorted(opaque(term), key=sympy.default_sort_key)}
        numbers = [self.unknown.setdefault(e, len(self.unknown)) for e in unknown]
        more = [np.random.default_rng((20260108, k)).uniform(*TUNING.drawn, on.shape[1]) for k in numbers]
        return (
            [*self.symbols, *unknown.values()],
            term.xreplace(unknown),
            (np.vstack([on, *more]), np.vstack([off, *more])),
        )

    def _points(self, surfaces: tuple[Any, ...]) -> "tuple[np.ndarray, np.ndarray]":
        """Values of the symbols, one column a point: off all surfaces, and where all of them are zero.

        A state is off by a part of its value, so that expressions are as large there as its unit makes them on the
        surfaces; from zero, which has no unit, it is where it was drawn.
        """
        import numpy as np

        n, samples = len(self.states), TUNING.samples + TUNING.sized_samples
        rng = np.random.default_rng(20260107)
        drawn = rng.uniform(*TUNING.drawn, (len(self.symbols), samples))
        # of many roots and logarithms hardly a place has them all, if not half of the places are positive
        drawn[1 : n + 1, ::2] *= rng.choice([-1.0, 1.0], (n, samples // 2))
        parts, sizes = drawn[1 : n + 1].copy(), np.ones((n, samples))
        sizes[:, TUNING.samples :] = 2.0 ** rng.integers(-TUNING.doublings, TUNING.doublings, (n, TUNING.sized_samples))
        drawn[1 : n + 1] *= sizes
        near = rng.uniform(*TUNING.near_values, (len(self.near), samples))
        near[:, np.arange(samples) // 2 % 2 == 0] = 1.0
        for row, value, factors in zip(drawn[n + 1 :], self.near, near, strict=False):
            if value != 0.0:
                row[:] = value * factors
        values, on = self._onto(surfaces, drawn, sizes)
        x, off = values[1 : n + 1], values.copy()
        off[1 : n + 1] = np.where(x == 0.0, drawn[1 : n + 1], x * (1.0 + 0.5 * parts))
        return off[:, on], values[:, on]

    def _onto(
        self, surfaces: tuple[Any, ...], drawn: "np.ndarray", sizes: "np.ndarray"
    ) -> "tuple[np.ndarray, np.ndarray]":
        """Points brought onto surfaces, the shortest way in sizes of states, and which of them are there.

        Where the rounding of a surface is as large as what it is made of, none is.
        """
        import numpy as np

        (n, samples), k = sizes.shape, len(surfaces)
        values, on = drawn.copy(), np.full(samples, True)
        if not k:
            return values, on
        x = values[1 : n + 1]
        gradients = [differentiate(surface, x) for surface in surfaces for x in self.states]
        function = _compiled(self.symbols, [*surfaces, *gradients])
        with np.errstate(all="ignore"):
            for _ in range(TUNING.newton_steps):
                rows = _rows(function, values).T
                heights, slopes = rows[:, :k], rows[:, k:].reshape(samples, k, n)
                terms = np.einsum("ska,as->sk", np.abs(slopes), np.abs(x))
                on = (np.abs(heights) <= TUNING.on_surface * terms).all(axis=1)
                if on.all():
                    break
                known = np.isfinite(rows).all(axis=1)[:, np.newaxis, np.newaxis]
                across = np.where(known, slopes * sizes.T[:, np.newaxis, :], 0.0)
                x -= sizes * (np.linalg.pinv(across) @ heights[:, :, np.newaxis])[:, :, 0].T
            reach = np.abs(slopes) * np.where(x == 0.0, np.abs(drawn[1 : n + 1]), np.abs(x)).T[:, np.newaxis, :]
            on &= (_spread(self.symbols, surfaces, values) <= TUNING.vanishing * reach.max(axis=2).T).all(axis=0)
        return values, on


def _spread(symbols: Sequence[Any], expressions: Iterable[Any], values: "np.ndarray") -> "np.ndarray":
    """By how much expressions, one a row, differ at points, one a column, from those beside them, with the numbers in
    them no better known.
    """
    import numpy as np

    numbers: dict[Any, float] = {}
    loose = [_loosened(e, numbers) for e in expressions]
    function = _compiled([*symbols, *numbers], loose)
    held = np.array([*numbers.values()])[:, np.newaxis] * np.ones(values.shape[1])
    whole = np.vstack([values, held]) if numbers else values
    rng, here = np.random.default_rng(20260109), _rows(function, whole)
    beside = (whole * (1.0 + TUNING.beside * rng.uniform(-1.0, 1.0, whole.shape)) for _ in range(3))
    return np.max([np.abs(_rows(function, places) - here) for places in beside], axis=0)


def _loosened(expression: Any, numbers: dict[Any, float]) -> Any:
    """The same with each number but exponents replaced by a symbol of its own, which goes into ``numbers``."""
    if not isinstance(expression, sympy.Expr):
        return expression
    if expression.is_Number or expression.is_NumberSymbol:
        symbol = sympy.Dummy(real=True)
        numbers[symbol] = float(expression)
        return symbol
    if not expression.args:
        return expression
    kept = [
        e if expression.is_Pow and i and e.is_Number else _loosened(e, numbers) for i, e in enumerate(expression.args)
    ]
    return expression.func(*kept)


def _compiled(symbols: Sequence[Any], expressions: Sequence[Any]) -> Callable[..., Any]:
    """Expressions as a function of the values of symbols."""
    # for every argument that is no identifier sympy goes through all expressions anew
    named = {symbol: sympy.Symbol(f"x{i}", real=True) for i, symbol in enumerate(symbols)}
    function: Callable[..., Any] = sympy.lambdify([*named.values()], [e.xreplace(named) for e in expressions], "numpy")
    return function


def _rows(function: Callable[..., Any], values: "np.ndarray") -> "np.ndarray":
    """Values of some expressions, one a row, at points, one a column."""
    import numpy as np

    with np.errstate(all="ignore"):
        return np.array([np.broadcast_to(np.asarray(row, dtype=float), values.shape[1]) for row in function(*values)])
