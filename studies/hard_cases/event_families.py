"""Families of guards whose lists of events are known in closed form.

A family is one compiled system with numbers as parameters and initial states, and a function from those to the times
of every event. No times are searched for: they follow from arcs of sines, from prescribed roots, or, in
`event_kicks`, from a calculation in fractions. Numbers whose list would depend on a last digit (two roots nearly
together, a root that is nearly touched) are not drawn; roots exactly at starts, strobes and ends, exact ties, and exact
double and triple roots are drawn often.
"""

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np
import sympy

import chaosdrill as cd

EPS = float(np.finfo(float).eps)
ROUNDING = 32 * EPS
"""Error of a guard's value in units of its largest term."""

STATE_ERROR = 100.0
"""Error of a state in tolerances of its size, after the few turns that a list is long."""

ONTO = 100.0
"""Tolerances of its size by which an event may move a state."""

SNAP = 1e-12
"""Roots this near to a start, an end or each other, in units of the length of a run, coincide by construction."""

CLEAR = 1e-6
"""Roots that coincide by chance are further apart than this, in the same unit, or the numbers are drawn again."""

T = sympy.Symbol("t", real=True)
Numbers = dict[str, float]
Times = dict[str, tuple[np.ndarray, np.ndarray]]
"""Times of the events of each transition, and how far off each may be."""


class UnclearError(Exception):
    """The list would depend on a last digit."""


@dataclass(frozen=True)
class Family:
    """One system, numbers for it, and the events that they lead to.

    Parameters
    ----------
    name : str
        What the guards are made of.
    system : HybridSystem
        Its state ``s`` is a clock, and all its transitions have the kind ``event``.
    periods : int or None
        Forcing periods of a run; None for a system without a period.
    length : callable
        Time of a run, from the numbers.
    draw : callable
        Numbers from a random generator: parameters and initial states by name.
    times : callable
        Times of all events from the numbers, the length and the tolerance; raises UnclearError.
    axes : tuple of str
        Two parameters that can be varied without spoiling what coincides by construction.
    """

    name: str
    system: Any
    periods: int | None
    length: Callable[[Numbers], float]
    draw: Callable[[np.random.Generator], Numbers]
    times: Callable[[Numbers, float, float], Times]
    axes: tuple[str, str] | None = None

    def at(self, numbers: Mapping[str, float]) -> Any:
        """The system with these numbers."""
        states = set(self.system.state_names)
        parameters = {k: v for k, v in numbers.items() if k not in states}
        return self.system.with_parameters(**parameters).with_initial(
            **{k: v for k, v in numbers.items() if k in states}
        )

    def lists(self, rng: np.random.Generator, tolerance: float) -> Iterator[tuple[Numbers, Times]]:
        """Numbers without end, each with its events."""
        while True:
            numbers = self.draw(rng)
            try:
                yield numbers, self.times(numbers, self.length(numbers), tolerance)
            except UnclearError:
                continue


def either_sign(rng: np.random.Generator, decades: float) -> float:
    """A factor of any sign, between 10**-decades and 10**decades."""
    return float(rng.choice([-1.0, 1.0]) * 10.0 ** rng.uniform(-decades, decades))


def pick(rng: np.random.Generator, special: list[float], low: float, high: float) -> float:
    """One of some special numbers, or, half of the time, any number between two."""
    return float(rng.choice(special)) if rng.random() < 0.5 else float(rng.uniform(low, high))


def within(times: np.ndarray, length: float, *, exact: bool = True) -> np.ndarray:
    """The times in [0, length); of roots at its ends the first counts and the last does not.

    Roots of states that are not ``exact`` must not lie at the end, which they meet up to an error only.
    """
    times = np.sort(np.asarray(times, dtype=float))
    for end in (0.0, length):
        off = np.abs(times - end) / length
        if np.any((off > (SNAP if exact or end == 0 else 0.0)) & (off < CLEAR)) or (
            not exact and end and np.any(off < CLEAR)
        ):
            raise UnclearError
    kept = times[(times > -SNAP * length) & (times < length * (1 - SNAP))]
    if np.any(np.diff(kept) < CLEAR * length):
        raise UnclearError
    return np.maximum(kept, 0.0)


def turns(first: float, rate: float, length: float) -> np.ndarray:
    """All times at which ``rate * t - first`` is whole, from before a run to after it."""
    k = np.arange(np.floor(-first) - 1, np.ceil(rate * length - first) + 2)
    return (first + k) / rate


def crossings(level: float, rate: float, turn: float, length: float) -> tuple[np.ndarray, np.ndarray, float]:
    """Times at which sin(2 pi (rate t - turn)) rises and falls through a level, and its slope there, up to the sign."""
    if abs(abs(level) - 1) < 1e-3:
        raise UnclearError
    if abs(level) > 1:
        return np.zeros(0), np.zeros(0), 1.0
    angle = np.arcsin(level) / (2 * np.pi)
    slope = 2 * np.pi * rate * np.sqrt(1 - level**2)
    return turns(turn + angle, rate, length), turns(turn + 0.5 - angle, rate, length), slope


def union(a: np.ndarray, b: np.ndarray, length: float, *, exact: bool) -> tuple[np.ndarray, np.ndarray]:
    """Roots of either factor of a product that are no roots of the other one: where both are zero it does not change
    its sign."""
    apart = np.abs(a[:, np.newaxis] - b[np.newaxis, :]) / length
    if np.any((apart > (SNAP if exact else 0.0)) & (apart < 10 * CLEAR)) or (not exact and np.any(apart == 0)):
        raise UnclearError
    return a[~np.any(apart < SNAP, axis=1)], b[~np.any(apart < SNAP, axis=0)]


def event(name: str, guard: Any, direction: int, reset: Mapping[Any, Any] | None = None, mode: str = "run") -> Any:
    """A transition that stays in its mode."""
    return cd.Transition(name, mode, mode, guard=guard, direction=direction, reset=reset or {}, kind="event")


def unbounded(*states: Any) -> dict[Any, None]:
    """No state of any size has escaped."""
    return dict.fromkeys(states)


# Guards of explicit time alone: sines of any phase, scaled, with a large part that cancels, touching, triple, together


@cache
def clocks() -> Family:
    """Sines of time; the strobe is at whole numbers, where half of the lists have roots."""
    s, n = sympy.symbols("s n", real=True)
    m, p, c, a, m2, p2, scale = sympy.symbols("m p c a m2 p2 scale", real=True)
    angle, other = 2 * sympy.pi * m * T - p, 2 * sympy.pi * m2 * T - p2
    count = {n: n + 1}
    system = cd.HybridSystem(
        name="clocks",
        states=(s, n),
        time=T,
        parameters={"m": 1.0, "p": 0.0, "c": 0.0, "a": 2.0, "m2": 1.0, "p2": 0.0, "scale": 1.0},
        modes={"run": {s: 1, n: 0}},
        transitions=[
            event("rise", scale * (sympy.sin(angle) - c), +1),
            event("fall", scale * (sympy.sin(angle) - c), -1, count),
            event("either", scale * sympy.sin(other), 0, count),
            event("cancelled", scale * ((sympy.sin(angle) + a) ** 2 - (c + a) ** 2), +1, count),
            event("twin", scale * (sympy.sin(2 * angle) + sympy.sin(angle)), +1, count),
            event("touch", scale * ((1 - sympy.cos(angle - sympy.pi / 4) + a) ** 2 - a**2), 0, count),
            event("triple", scale * sympy.sin(angle) ** 3, +1),
            event("product", scale * sympy.sin(angle) * sympy.sin(other), 0, count),
        ],
        period=sympy.Integer(1),
        bounds=unbounded(s, n),
    )

    def draw(rng: np.random.Generator) -> Numbers:
        turn = pick(rng, [0, 0.25, 0.5, 1 / 3, 0.125], 0, 1)
        level = pick(rng, [0, 0.5, -0.5], -0.95, 0.95)
        if rng.random() < 0.3:
            turn = float(-np.arcsin(level) / (2 * np.pi) + rng.integers(0, 4) / 4)
        own = rng.integers(1, 4)
        same = rng.random() < 0.4
        return {
            "m": float(own),
            "p": 2 * np.pi * turn,
            "c": level,
            "a": float(rng.choice([2.0, 1e3, 1e6])),
            "m2": float(own if same else rng.integers(1, 4)),
            "p2": 2 * np.pi * (turn if same else pick(rng, [0, 0.25, 0.5], 0, 1)),
            "scale": either_sign(rng, 9),
        }

    def times(of: Numbers, length: float, tolerance: float) -> Times:
        m, m2, turn, turn2 = of["m"], of["m2"], of["p"] / (2 * np.pi), of["p2"] / (2 * np.pi)
        upward = of["scale"] > 0
        up, down, slope = crossings(of["c"], m, turn, length)
        two = [turns(turn2 + shift, m2, length) for shift in (0.0, 0.5)]
        own = [turns(turn + shift, m, length) for shift in (0.0, 0.5)]
        if np.any(np.abs(turns(turn + 0.125, m, length)) < CLEAR):
            # a start on a touching point is a start on a guard
            raise UnclearError
        first, second = union(np.concatenate(own), np.concatenate(two), length, exact=True)
        twin = own if upward else [turns(turn + third / 3, m, length) for third in (1, 2)]
        rising = up if upward else down
        spread = EPS * 16 * (1 + length) + EPS * 8 * (abs(of["p"]) + abs(of["p2"]))
        at_second = (
            2
            * np.pi
            * np.minimum(
                m * np.abs(np.sin(2 * np.pi * (m2 * first - turn2))).min(initial=1.0),
                m2 * np.abs(np.sin(2 * np.pi * (m * second - turn))).min(initial=1.0),
            )
        )
        third = (ROUNDING * (1 + abs(of["p"])) ** 3) ** (1 / 3) / (2 * np.pi * m)
        off = {
            "rise": ROUNDING / slope,
            "fall": ROUNDING / slope,
            "either": ROUNDING / m2,
            "cancelled": ROUNDING * (1 + of["a"]) ** 2 / (slope * 2 * max(of["a"] - 1, 1)),
            "twin": ROUNDING / m,
            "touch": 0.0,
            "triple": third,
            "product": ROUNDING / at_second,
        }
        lists = {
            "rise": rising,
            "fall": down if upward else up,
            "either": np.concatenate(two),
            "cancelled": rising,
            "twin": np.concatenate(twin),
            "touch": np.zeros(0),
            "triple": own[0 if upward else 1],
            "product": np.concatenate([first, second]),
        }
        kept = {name: within(found, length) for name, found in lists.items()}
        return {name: (found, np.full(len(found), off[name] + spread)) for name, found in kept.items()}

    return Family("sines of time", system, 4, lambda of: 4.0, draw, times, ("p", "scale"))


# Guards of linear oscillators, beside states of other sizes and a state that decays fast


@cache
def oscillators() -> Family:
    """Two oscillators of any size and a state that decays; eight strobes a turn, where half of the lists have roots."""
    x, v, y, u, z, s, n = sympy.symbols("x v y u z s n", real=True)
    w, h, c, r, decay, scale = sympy.symbols("w h c r decay scale", real=True)
    count = {n: n + 1}
    system = cd.HybridSystem(
        name="oscillators",
        states=(x, v, y, u, z, s, n),
        parameters={"w": 1.0, "h": 2.0, "c": 0.0, "r": 1.0, "decay": 0.0, "scale": 1.0},
        modes={"run": {x: v, v: -(w**2) * x, y: u, u: -((h * w) ** 2) * y, z: -decay * w * z, s: 1, n: 0}},
        transitions=[
            event("rise", scale * (x - c), +1, count),
            event("fall", scale * (x - c), -1),
            event("either", scale * (x + r * v / w), 0, count),
            event("turn", scale * v, -1),
            event("product", scale * x * y, 0, count),
        ],
        period=sympy.pi / (4 * w),
        bounds=unbounded(x, v, y, u, z, s, n),
    )
    periods = 17

    def draw(rng: np.random.Generator) -> Numbers:
        rate = float(10.0 ** rng.uniform(-4, 4))
        size, other = (float(10.0 ** rng.uniform(-7, 7)) for _ in range(2))
        angle = pick(rng, [0, np.pi / 4, np.pi / 2], 0, 2 * np.pi)
        second = pick(rng, [np.pi / 3], 0, 2 * np.pi)
        start = size * np.cos(angle) if rng.random() > 0.2 else size
        speed = -size * np.sin(angle) if start != size else 0.0
        numbers = {
            "w": rate,
            "h": float(rng.choice([1.0, 2.0, np.sqrt(2)])),
            "c": size * pick(rng, [0, 0.5], -0.9, 0.9),
            "r": float(rng.uniform(-2, 2)),
            "decay": float(rng.choice([0.0, 1.0, 30.0, 1000.0], p=[0.3, 0.4, 0.25, 0.05])),
            "scale": either_sign(rng, 9),
            "x": start,
            "v": speed * rate,
            "y": other * np.cos(second),
            "u": -other * np.sin(second) * rate,
            "z": either_sign(rng, 6),
        }
        if rng.random() < 0.2 and speed:
            numbers["c"] = numbers["x"]
        return {name: float(value) for name, value in numbers.items()}

    def times(of: Numbers, length: float, tolerance: float) -> Times:
        w, h = of["w"], of["h"]
        size, phase = np.hypot(of["x"], of["v"] / w), np.arctan2(of["x"], of["v"] / w)
        second = np.arctan2(of["y"], of["u"] / (h * w))
        rate = w / (2 * np.pi)
        error = STATE_ERROR * tolerance * (1 + of["decay"] / 30) + ROUNDING
        # a start that is a hair beside the level has its root a hair before or after it
        if 0 < abs(of["x"] - of["c"]) < 1e-9 * size:
            raise UnclearError

        def roots(level: float, rate: float, phase: float) -> tuple[np.ndarray, np.ndarray, float]:
            return crossings(level, rate, -phase / (2 * np.pi), length)

        up, down, slope = roots(of["c"] / size, rate, phase)
        zero_up, zero_down, _ = roots(0.0, rate, phase)
        other_up, other_down, _ = roots(0.0, h * rate, second)
        sum_up, sum_down, _ = roots(0.0, rate, phase + np.arctan(of["r"]))
        turn_up, turn_down, _ = roots(0.0, rate, phase + np.pi / 2)
        if of["scale"] < 0:
            up, down, turn_up, turn_down = down, up, turn_down, turn_up
        first, second_roots = union(
            np.concatenate([zero_up, zero_down]), np.concatenate([other_up, other_down]), length, exact=False
        )
        lists = {
            "rise": (up, slope / w),
            "fall": (down, slope / w),
            "either": (np.concatenate([sum_up, sum_down]), 1.0),
            "turn": (turn_down, 1.0),
            "product": (np.concatenate([first, second_roots]), 1.0),
        }
        return {
            name: (kept := within(found, length, exact=False), np.full(len(kept), error / (steep * w)))
            for name, (found, steep) in lists.items()
        }

    return Family(
        "oscillators", system, periods, lambda of: periods * np.pi / (4 * of["w"]), draw, times, ("c", "scale")
    )


# Polynomials with prescribed roots, in time and along a chain of integrators


def expanded(roots: list[float]) -> np.ndarray:
    """Coefficients of the product of (t - r), lowest first, exact for roots that are multiples of 1/8 below 8."""
    return np.polynomial.polynomial.polyfromroots(roots)


def draw_roots(rng: np.random.Generator, degree: int, *, simple: bool) -> list[float]:
    """Roots that are multiples of 1/8 up to 4, some of them at whole numbers, some of them many times."""
    grid = np.arange(0, 32 if simple else 33) / 8
    if simple:
        return sorted(float(r) for r in rng.choice(grid, degree, replace=False))
    roots: list[float] = []
    while len(roots) < degree:
        root = float(rng.choice([0, 1, 2, 3, 4]) if rng.random() < 0.4 else rng.choice(grid))
        if root not in roots:
            roots += [root] * min(int(rng.choice([1, 1, 2, 3])), degree - len(roots))
    return sorted(roots)


def signed_roots(roots: list[float], lead: float, length: float) -> dict[int, np.ndarray]:
    """Roots at which lead * prod(t - r) rises (+1) and falls (-1); those of even order do not count."""
    found: dict[int, list[float]] = {1: [], -1: []}
    sign = 1 if lead > 0 else -1
    for root, order in sorted(Counter(roots).items(), reverse=True):
        if order % 2:
            found[sign].append(root)
            sign = -sign
        elif root == 0:
            raise UnclearError
    return {side: within(np.array(times), length) for side, times in found.items()}


def root_errors(found: np.ndarray, roots: list[float], noise: float) -> np.ndarray:
    """How far an error ``noise`` of the monic polynomial moves each of its roots."""
    counted = Counter(roots)
    off = []
    for root in found:
        order = counted[float(root)]
        rest = np.prod([abs(root - r) ** k for r, k in counted.items() if r != root])
        off.append((noise / rest) ** (1 / order))
    return np.array(off) + 16 * EPS * 8


def clock_error(roots: list[float], noise: float, length: float, tolerance: float) -> float:
    """How far a state that runs with time may be from it, where guards of it that have these roots are met.

    A state is put onto the guard that it meets, so that two events at each simple root move it by as much as an error
    ``noise`` of the guard's value moves the root, or by as much as the engine allows. A state has its tolerance, too.
    """
    simple = np.array([r for r, order in Counter(roots).items() if order == 1 and 0 <= r < length])
    moved = float(2 * np.minimum(root_errors(simple, roots, noise), ONTO * tolerance * length).sum())
    if length in roots and moved > tolerance * length:
        # whether the clock is there before the end of the run is a matter of a last digit
        raise UnclearError
    return moved + tolerance * length


@cache
def polynomials(forced: bool) -> Family:
    """A chain of six integrators, and a polynomial of time itself, or of a clock for a run with strobes."""
    chain = sympy.symbols("x0:6", real=True)
    s, n = sympy.symbols("s n", real=True)
    c, scale, chain_scale = sympy.symbols("c scale chain_scale", real=True)
    coefficients = sympy.symbols("k0:6", real=True)
    clock = s if forced else T
    value: Any = 0
    for coefficient in reversed(coefficients):
        value = value * clock + coefficient
    count = {n: n + 1}
    system = cd.HybridSystem(
        name="polynomials of a clock" if forced else "polynomials of time",
        states=(*chain, s, n),
        time=None if forced else T,
        parameters={
            "c": 0.0,
            "scale": 1.0,
            "chain_scale": 1.0,
            **{str(k): float(i == 0) for i, k in enumerate(coefficients)},
        },
        modes={"run": {**dict(zip(chain, (*chain[1:], 0), strict=True)), s: 1, n: 0}},
        transitions=[
            event("chain-rises", chain_scale * (chain[0] - c), +1, count),
            event("chain-falls", chain_scale * (chain[0] - c), -1),
            event("chain", chain_scale * (chain[0] - c), 0, count),
            event("rise", scale * value, +1),
            event("fall", scale * value, -1, count),
            event("either", scale * value, 0, count),
        ],
        period=sympy.Integer(1) if forced else None,
        bounds=unbounded(*chain, s, n),
    )
    factorial = np.array([1, 1, 2, 6, 24, 120])

    def draw(rng: np.random.Generator) -> Numbers:
        degree = int(rng.integers(1, 6))
        own = np.zeros(6)
        own[: degree + 1] = expanded(draw_roots(rng, degree, simple=True)) * rng.choice([-1, 1])
        degree = int(rng.integers(1, 6))
        other = np.zeros(6)
        other[: degree + 1] = expanded(draw_roots(rng, degree, simple=False))
        level = float(rng.choice([0.0, 0.125, 64.0, 4096.0]))
        start = own * factorial
        start[0] += level
        return {
            "c": level,
            "scale": either_sign(rng, 9),
            "chain_scale": either_sign(rng, 9),
            **{str(k): float(value) for k, value in zip(coefficients, other, strict=True)},
            **{str(k): float(value) for k, value in zip(chain, start, strict=True)},
        }

    def roots_of(coefficients: np.ndarray) -> tuple[list[float], float]:
        """Roots, all of them on the grid, with their orders, by exact division."""
        rest = [Fraction(float(v)) for v in coefficients]
        while rest and rest[-1] == 0:
            rest.pop()
        lead, roots = rest[-1], []
        for candidate in range(33):
            root = Fraction(candidate, 8)
            while len(rest) > 1:
                quotient, remainder = [Fraction(0)] * (len(rest) - 1), Fraction(0)
                for i in range(len(rest) - 1, -1, -1):
                    remainder = remainder * root + rest[i]
                    if i:
                        quotient[i - 1] = remainder
                if remainder != 0:
                    break
                rest = quotient
                roots.append(float(root))
        if len(rest) > 1:
            # another start beside this level has other roots
            raise UnclearError
        return roots, float(lead)

    def times(of: Numbers, length: float, tolerance: float) -> Times:
        start = np.array([of[str(k)] for k in chain])
        start[0] -= of["c"]
        own, lead = roots_of(start / factorial)
        other, _ = roots_of(np.array([of[str(k)] for k in coefficients]))
        lists: Times = {}
        for names, roots, sign, noise in (
            (
                ("chain-rises", "chain-falls", "chain"),
                own,
                lead * of["chain_scale"],
                (STATE_ERROR * tolerance + ROUNDING)
                * (abs(of["c"]) + np.abs(expanded(own)) @ 4.0 ** np.arange(len(own) + 1)),
            ),
            (
                ("rise", "fall", "either"),
                other,
                of["scale"],
                ROUNDING * np.abs(expanded(other)) @ 4.0 ** np.arange(len(other) + 1),
            ),
        ):
            sides = signed_roots(roots, sign, length)
            # of time itself, or of a clock that an event at a root in doubt puts onto its guard
            late = clock_error(roots, noise, length, tolerance) if forced and "rise" in names else 0.0
            for name, found in zip(
                names, (sides[1], sides[-1], np.sort(np.concatenate([sides[1], sides[-1]]))), strict=True
            ):
                lists[name] = found, root_errors(found, roots, noise) + late
        return lists

    name = "polynomials of a clock" if forced else "polynomials of time"
    return Family(name, system, 4 if forced else None, lambda of: 4.0, draw, times, ("scale", "chain_scale"))
