"""The truth that methods are measured against: the flow with its events in 60-digit arithmetic.

The arcs come from extrapolation of the modified midpoint rule, the event times from Newton's method, and the tangents
from differences of the flow itself at starts 1e-25 apart: neither a variational equation nor a saltation matrix enters.
From a run in double precision it only takes which directions the first mode leaves, and which events come one after
another, which it checks against the guards and conditions.

Gragg's rule has an error expansion in even powers of the step, so that each further column of the extrapolation adds
two orders (Gragg 1965, doi:10.1137/0702030; Bulirsch and Stoer 1966, doi:10.1007/BF02165234). It needs nothing but the
right-hand side, and shares no formula with the methods that are measured against it; nor do the special functions of
the contact laws, which are evaluated by other formulas than the compiled ones.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import mpmath
import numpy as np
import sympy

from chaosdrill.analysis.tuning import PRECISION
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run
from chaosdrill.model import HybridSystem, special
from chaosdrill.model.derive import reset_map
from chaosdrill.model.places import arguments
from chaosdrill.model.special import RESTS, SPECIAL

Point = list[Any]
Rate = Callable[[Any, Point], Point]


DIGITS = 60


def extrapolated_step(rate: Rate, t: Any, x: Point, h: Any, columns: int) -> tuple[Point, float]:
    """The state after one step of length ``h`` from the state ``x`` at ``t``, and its error.

    A table of ``columns`` columns has the order 2 ``columns``; the error is the difference to one with a column less,
    relative to max(1, abs(x)). ``rate``: time derivative (time, state) -> state; mpmath numbers throughout.
    """
    first = rate(t, x)
    rows: list[list[Point]] = []
    for j in range(1, columns + 1):
        parts = 2 * j
        s = h / parts
        before, now = x, [a + s * b for a, b in zip(x, first, strict=True)]
        for i in range(1, parts):
            slope = rate(t + i * s, now)
            before, now = now, [a + 2 * s * b for a, b in zip(before, slope, strict=True)]
        row = [now]
        for k in range(1, j):
            # (n_j / n_(j-k))^2 - 1 for the numbers 2, 4, 6, ... of parts
            weight = (j * j - (j - k) ** 2, (j - k) ** 2)
            finer, coarser = row[-1], rows[-1][k - 1]
            row.append([a + (a - b) * weight[1] / weight[0] for a, b in zip(finer, coarser, strict=True)])
        rows.append(row)
    best, other = rows[-1][-1], rows[-1][-2]
    scale = max(1.0, *(float(abs(a)) for a in best))
    return best, float(max(abs(a - b) for a, b in zip(best, other, strict=True))) / scale


def integrate(
    rate: Rate, t: Any, x: Point, end: Any, columns: int, tolerance: float, first: Any, most: int
) -> tuple[list[Point], list[Any], Any]:
    """Integrate to the time ``end``, choosing the steps, whose local error is the ``tolerance``; others as before.

    ``first``: length to try first. ``most``: largest number of steps, those included that were too long.

    Returns: states at the start and at the end of every step; the lengths of the steps, which `integrate_along`
    repeats; the length to try first on the next arc.

    Raises `ArithmeticError` for more steps than ``most``, or a state without a value.
    """
    states: list[Point] = [x]
    mesh: list[Any] = []
    length, tries = first, 0
    while t < end:
        tries += 1
        h = min(length, end - t)
        # two steps of equal length, not a long one and a sliver
        if h < end - t < 2 * h:
            h = (end - t) / 2
        moved, error = extrapolated_step(rate, t, states[-1], h, columns)
        if error != error or tries > most:
            raise ArithmeticError(f"the reference needs more than {most} steps, or has no value")
        factor = min(4.0, PRECISION.safety * (tolerance / max(error, 1e-300)) ** (1 / (2 * columns - 1)))
        if error > tolerance:
            length = h * min(0.5, max(factor, 0.05))
            continue
        t += h
        states.append(moved)
        mesh.append(h)
        length = h * max(1.0, factor)
    return states, mesh, length


def integrate_along(rate: Rate, t: Any, x: Point, mesh: Sequence[Any], columns: int) -> Point:
    """Integrate along given steps, so that the result is a smooth function of the start."""
    for h in mesh:
        x, _ = extrapolated_step(rate, t, x, h, columns)
        t += h
    return x


def _work(v: Any, lam: Any) -> Any:
    """Digits for a contact of damping lam entered at speed v: the closed forms cancel as lam v goes to zero."""
    x = abs(lam * v)
    lost = 0 if x == 0 or x >= 1 else int(-mpmath.log10(x))
    return mpmath.workdps(2 * mpmath.mp.dps + PRECISION.guard_digits + 4 * lost)


def _potential(v: Any, lam: Any) -> Any:
    return v / lam - mpmath.log(1 + lam * v) / lam**2


def hunt_crossley_exit(v: Any, lam: Any) -> Any:
    """Exit speed by the principal branch of Lambert's function."""
    with _work(v, lam):
        x = 1 + lam * v
        speed = v if lam * v == 0 else (1 + mpmath.lambertw(-x * mpmath.exp(-x)).real) / lam
    return +speed


def hunt_crossley_peak(v: Any, lam: Any, n: Any, k: Any) -> Any:
    """Largest force of the contact, by bisection for the speed at the peak; 20 digits, as only conditions name it."""
    if v <= 0:
        return mpmath.mpf(0)
    with mpmath.workdps(mpmath.mp.dps + PRECISION.guard_digits):
        low, high = mpmath.mpf(0), +v
        for _ in range(70):
            middle = (low + high) / 2
            gained = lam * (n + 1) * (_potential(v, lam) - _potential(middle, lam))
            low, high = (middle, high) if n * middle < gained else (low, middle)
        depth = ((n + 1) * (_potential(v, lam) - _potential(low, lam)) / k) ** (1 / (n + 1))
        return k * depth**n * (1 + lam * low)


def hunt_crossley_duration(v: Any, lam: Any, n: Any, k: Any) -> Any:
    """Duration of the contact, the integral of dx/speed on both branches with x = depth (1 - s^2).

    Of an elastic contact it is a beta function.
    """
    with mpmath.workdps(mpmath.mp.dps + PRECISION.guard_digits):
        if lam == 0:
            shape = mpmath.beta(1 / (n + 1), mpmath.mpf(1) / 2)
            return 2 * ((n + 1) * v ** (1 - n) / (2 * k)) ** (1 / (n + 1)) * shape / (n + 1)
        whole = _potential(v, lam)
        depth = ((n + 1) * whole / k) ** (1 / (n + 1))

        def slowness(s: Any) -> Any:
            left = whole * (-mpmath.expm1((n + 1) * mpmath.log1p(-s * s)) if s < 1 else 1)
            return 2 * depth * s * (1 / _speed(left, lam, 1) + 1 / _speed(left, lam, -1))

        return mpmath.quad(slowness, [0, 1])


def _speed(left: Any, lam: Any, way: int) -> Any:
    """Speed on the way in (1) or out (-1) at which G(way speed) = left, by the two branches of Lambert's function."""
    with _work(mpmath.sqrt(left), lam):
        speed = abs(1 + mpmath.lambertw(-mpmath.exp(-1 - lam * lam * left), -1 if way > 0 else 0).real) / lam
    return +speed


def positive_power(d: Any, n: Any) -> Any:
    """max(d, 0)^n."""
    return d**n if d > 0 else mpmath.mpf(0)


def gate(m: Any, n: Any, u: Any, e: Any) -> Any:
    """exp(e)/(m + n exp(u))."""
    return mpmath.exp(e) / (m + n * mpmath.exp(u))


def log_sum(m: Any, n: Any, u: Any) -> Any:
    """log(m + n exp(u))."""
    with mpmath.workdps(2 * mpmath.mp.dps + PRECISION.guard_digits):
        found = mpmath.log1p(n * mpmath.exp(u)) if m == 1 else mpmath.log(m + n * mpmath.exp(u))
    return +found


def log_cosh(u: Any) -> Any:
    """log(cosh(u))."""
    with mpmath.workdps(2 * mpmath.mp.dps + PRECISION.guard_digits):
        found = mpmath.log1p(2 * mpmath.sinh(u / 2) ** 2)
    return +found


def bernoulli_ratio(u: Any, s: Any, order: Any) -> Any:
    """Derivative of an order of u exp(s u)/(exp(u) - 1)."""

    def ratio(v: Any) -> Any:
        return v * mpmath.exp(s * v) / mpmath.expm1(v) if v else mpmath.mpf(1)

    with mpmath.workdps(mpmath.mp.dps + PRECISION.guard_digits):
        found = mpmath.diff(ratio, u, int(order))
    return +found


def _rest(told: Any, kind: Any, g: Any, u: Any, m: Any, order: Any) -> Any:
    """Derivative of an order of what the first m terms of its Taylor series leave of a function g, over u^m."""
    terms = [sympy.Rational(kind.term(sympy.nsimplify(told, rational=True), p)) for p in range(int(m + order) + 1)]
    exact = [mpmath.mpf(int(c.p)) / int(c.q) for c in terms]
    if not u:
        return exact[-1] * mpmath.factorial(int(order))
    with mpmath.workdps(3 * mpmath.mp.dps + PRECISION.guard_digits):
        found = mpmath.diff(lambda v: (g(v) - mpmath.polyval(exact[: int(m)][::-1], v)) / v**m, u, int(order))
    return +found


def taylor_rest(u: Any, told: Any, m: Any, order: Any) -> Any:
    """Of the function with this number among `RESTS` of `chaosdrill.model.special`."""
    name = RESTS[int(told)].__name__
    g = log_cosh if name == "log_cosh" else getattr(mpmath, name)
    return _rest(int(told), special.taylor_rest, g, u, m, order)


def power_rest(u: Any, a: Any, m: Any, order: Any) -> Any:
    """Of (1 + u)^a."""
    return _rest(a, special.power_rest, lambda v: (1 + v) ** a, u, m, order)


def even_rest(s: Any, told: Any, m: Any, order: Any) -> Any:
    """Derivative of an order by s of what is left of the function with this number, at the root of s."""
    terms = [sympy.Rational(special.even_rest.term(told, int(m) + 2 * j)) for j in range(int(order) + 1)]
    if not s:
        return mpmath.mpf(int(terms[-1].p)) / int(terms[-1].q) * mpmath.factorial(int(order))
    with mpmath.workdps(3 * mpmath.mp.dps + PRECISION.guard_digits):
        found = mpmath.diff(lambda v: taylor_rest(mpmath.sqrt(v), told, m, 0), s, int(order))
    return +found


EXACT = {
    function.__name__: function
    for function in (
        *(hunt_crossley_exit, hunt_crossley_peak, hunt_crossley_duration, positive_power),
        *(gate, log_sum, log_cosh, bernoulli_ratio, taylor_rest, power_rest, even_rest),
    )
}
"""By name, those that can be evaluated in many digits."""


class NoReferenceError(ArithmeticError):
    """The reference cannot be computed, with the reason."""


Itinerary = list[tuple[int, float, int]]
"""Events of a stretch in order: strobe count, time since that strobe, transition."""


@dataclass
class Leg:
    """A stretch without events: its mode, its steps, and the transition at its end (None at a strobe)."""

    mode: str
    mesh: list[Any]
    transition: int | None


@dataclass(frozen=True)
class Truth:
    """State, event times and tangent map after the stretch, rounded to doubles only when compared.

    States are counted in their sizes.
    """

    start: Point
    state: Point
    times: list[Any]  # event times since the start
    transitions: list[int]  # transitions taken at these times
    tangent: Any  # (n, n)
    multipliers: np.ndarray  # (n,): eigenvalues of the tangent map
    errors: dict[str, float]
    """Disagreement with a second computation of another order, other steps and another distance of the starts."""


class Exact:
    """A system's expressions evaluated with mpmath, and its flow along an itinerary.

    ``system``: with the parameters and the initial mode. ``unit``: time between strobes. ``sizes``, shape (n,): units
    in which its states are counted here, powers of two.
    """

    def __init__(self, system: HybridSystem, unit: float, sizes: np.ndarray) -> None:
        self.system = system = system.placed
        self.unit = mpmath.mpf(unit)
        self._sizes = [mpmath.mpf(float(size)) for size in sizes]
        symbols = arguments(system)
        self._c = [mpmath.mpf(value) for value in system.parameters.values()]
        if missing := sorted(_special_names(system) - EXACT.keys()):
            raise NoReferenceError(f"{', '.join(missing)} has no evaluation in extended precision")

        def function(expression: Any) -> Any:
            compiled = sympy.lambdify(symbols, expression, modules=[EXACT, "mpmath"], cse=True)
            return lambda t, x: compiled(t, *(a * size for a, size in zip(x, self._sizes, strict=True)), *self._c)

        self._rates = {mode: function([f[x] for x in system.states]) for mode, f in system.modes.items()}
        self._guards = [function(t.guard) for t in system.transitions]
        self._conditions = [{m: function(c) for m, c in t.conditions.items()} for t in system.transitions]
        self._resets = [function(reset_map(system, t)) for t in system.transitions]

    def rate(self, mode: str) -> Any:
        """Time derivative in a mode, as a function of (time, state)."""
        compiled = self._rates[mode]
        return lambda t, x: self._sized(compiled(t, x))

    def _sized(self, state: Iterable[Any]) -> Point:
        """A state, or its rate, in the sizes of the states."""
        return [mpmath.mpf(value) / size for value, size in zip(state, self._sizes, strict=True)]

    def holds(self, transition: int, mode: str, t: Any, x: Point) -> bool:
        """Whether the condition of a transition is met in a mode."""
        condition = self._conditions[transition].get(mode)
        return True if condition is None else bool(condition(t, x))

    def follow(self, x: Point, itinerary: Itinerary, count: int, columns: int, tolerance: float) -> "Followed":
        """Integrate over ``count`` units, choosing the steps; every guard is watched at their ends."""
        for taken in (self.system.transitions[j] for *_, j in itinerary):
            if taken.completes is not None:
                raise NoReferenceError(f"{taken.name} stands for infinitely many events; there is no reference for it")
        legs: list[Leg] = []
        times: list[Any] = []
        mode, length = str(self.system.initial["mode"]), self.unit / 16
        for k in range(count):
            base, t = k * self.unit, mpmath.mpf(0)
            for end, transition in [*((e, j) for s, e, j in itinerary if s == k), (self.unit, None)]:
                at, stop = self._clock(base, t), max(end - t, mpmath.mpf(0))
                states, mesh, length = integrate(
                    self.rate(mode), at, x, at + stop, columns, tolerance, length, PRECISION.most_steps
                )
                self._watch(mode, at, states, mesh, transition)
                legs.append(Leg(mode, mesh, transition))
                x, t = states[-1], t + stop
                if transition is not None:
                    x, passed = self._onto_guard(mode, transition, self._clock(base, t), x)
                    t += passed
                    times.append(base + t)
                    x, mode = self._take(mode, transition, self._clock(base, t), x)
        return Followed(x, times, legs)

    def repeat(self, x: Point, legs: list[Leg], columns: int) -> Point:
        """Integrate along the steps that `follow` chose, from another start close by: a smooth function of it."""
        base = t = mpmath.mpf(0)
        for leg in legs:
            mesh = list(leg.mesh)
            if leg.transition is None:
                # the events before have moved with the start, the strobe has not
                mesh[-1] = self.unit - t - mpmath.fsum(mesh[:-1])
            x = integrate_along(self.rate(leg.mode), self._clock(base, t), x, mesh, columns)
            t += mpmath.fsum(mesh)
            if leg.transition is None:
                base, t = base + self.unit, mpmath.mpf(0)
                continue
            x, passed = self._onto_guard(leg.mode, leg.transition, self._clock(base, t), x)
            t += passed
            x, _ = self._take(leg.mode, leg.transition, self._clock(base, t), x)
        return x

    def _clock(self, base: Any, t: Any) -> Any:
        """Time as the expressions see it: since the start, or in a forced system since the last strobe."""
        return t if self.system.forced else base + t

    def _onto_guard(self, mode: str, transition: int, t: Any, x: Point) -> tuple[Point, Any]:
        """Newton's method for the event near the present state: (state, time passed)."""
        rate, guard = self.rate(mode), self._guards[transition]
        tiny = mpmath.mpf(10) ** (-DIGITS // 3)
        total = mpmath.mpf(0)
        for _ in range(PRECISION.newton):
            value = guard(t, x)
            slope = rate(t, x)
            ahead = guard(t + tiny, [a + tiny * b for a, b in zip(x, slope, strict=True)])
            if ahead == value:
                break
            dt = -value * tiny / (ahead - value)
            x, _ = extrapolated_step(rate, t, x, dt, 4)
            t, total = t + dt, total + dt
            if abs(total) > PRECISION.close * self.unit:
                break
            if abs(dt) < mpmath.mpf(10) ** (4 - DIGITS):
                return x, total
        raise NoReferenceError(f"no crossing of {self.system.transitions[transition].name} near the one found")

    def _take(self, mode: str, transition: int, t: Any, x: Point) -> tuple[Point, str]:
        """State and mode after an event; the outcome is chosen anew."""
        taken = self.system.transitions[transition]
        if next((j for j in self._outcomes(mode, transition) if self.holds(j, mode, t, x)), None) != transition:
            raise NoReferenceError(f"{taken.name} is not what follows in extended precision")
        return self._sized(self._resets[transition](t, x)), taken.target

    def _outcomes(self, mode: str, transition: int) -> list[int]:
        """Transitions that share the event of one, in order of declaration."""
        one = self.system.transitions[transition]
        return [
            j
            for j, t in enumerate(self.system.transitions)
            if mode in t.source and t.guard == one.guard and t.direction == one.direction
        ]

    def _watch(self, mode: str, t: Any, states: list[Point], mesh: list[Any], expected: int | None) -> None:
        """Raise NoReferenceError if a guard crosses zero within a leg, as its steps see it."""
        mine = [] if expected is None else self._outcomes(mode, expected)
        for j, transition in enumerate(self.system.transitions):
            if mode not in transition.source or j in mine:
                continue
            at, before = t, None
            for h, x in zip(mesh, states[1:], strict=True):
                at += h
                value = self._guards[j](at, x)
                crossed = before is not None and before * value < 0 and transition.direction * value >= 0
                if crossed and self.holds(j, mode, at, x):
                    raise NoReferenceError(f"{transition.name} happens in extended precision only")
                before = value


@dataclass(frozen=True)
class Followed:
    """End of a stretch, its event times, and the legs to repeat it by."""

    state: Point
    times: list[Any]
    legs: list[Leg]


def _special_names(system: HybridSystem) -> set[str]:
    expressions = [rate for field in system.modes.values() for rate in field.values()]
    for transition in system.transitions:
        expressions += [transition.guard, *transition.reset.values()]
        expressions += transition.conditions.values()
    return {type(f).__name__ for e in expressions for f in e.atoms(sympy.Function)} & SPECIAL.keys()


def find_truth(
    system: HybridSystem, unit: float, sizes: np.ndarray, start: Point, itinerary: Itinerary, count: int
) -> Truth:
    """State, events and tangent map over ``count`` units from a start, in extended precision.

    The start, as the truth, is counted in the sizes of the states, powers of two.

    Raises `NoReferenceError` if the events are not those of the itinerary, or a function has no evaluation. Raises
    `ArithmeticError`, `ValueError`, `TypeError` if a number cannot be computed.
    """
    n = len(system.state_names)
    with mpmath.workdps(DIGITS):
        exact = Exact(system, unit, sizes)
        base = exact.follow(start, itinerary, count, PRECISION.columns, PRECISION.tolerance)
        other = exact.follow(start, itinerary, count, PRECISION.other_columns, PRECISION.other_tolerance)
        run = Run(system, unit, Numerics(), tangents=np.eye(n), orthonormalise=False)
        run.advance(0)
        tangent = mpmath.zeros(n, n)
        for j in np.flatnonzero(run.vectors.any(axis=1)).tolist():
            direction = [mpmath.mpf(entry) for entry in run.vectors[j] * (sizes[j] / sizes)]
            tangent[:, j] = mpmath.matrix(
                _difference(exact, start, base, direction, PRECISION.columns, PRECISION.apart)
            )
        diagonal = [mpmath.mpf(entry) for entry in sizes @ run.vectors / sizes]
        image = _difference(exact, start, other, diagonal, PRECISION.other_columns, PRECISION.apart - 1)
        expected = tangent * mpmath.matrix(diagonal)
        error = float(max(abs(a - b) for a, b in zip(image, expected, strict=True)))
        values, _ = mpmath.mp.eig(tangent)
        _, basis = np.linalg.eig(np.array(tangent.tolist(), dtype=float))
        errors = {
            "strobe": _apart(base.state, other.state),
            "event_time": _apart(base.times, other.times),
            "tangent": error,
            # Bauer and Fike 1960, doi:10.1007/BF01386217
            "multiplier": error * n * float(np.linalg.cond(basis)),
        }
        multipliers = np.array([complex(value) for value in values])
        return Truth(start, base.state, base.times, [j for *_, j in itinerary], tangent, multipliers, errors)


def _difference(exact: Exact, start: Point, base: Followed, direction: Point, columns: int, apart: int) -> Point:
    """Derivative of the end along a direction of the start."""
    tiny = mpmath.mpf(10) ** -apart
    moved = exact.repeat([a + tiny * b for a, b in zip(start, direction, strict=True)], base.legs, columns)
    return [(a - b) / tiny for a, b in zip(moved, base.state, strict=True)]


def _apart(one: Point, other: Point) -> float:
    return float(max((abs(a - b) for a, b in zip(one, other, strict=True)), default=mpmath.mpf(0)))
