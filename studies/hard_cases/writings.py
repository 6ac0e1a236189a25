"""Events and tangents of systems that are written in many ways: how many depend on the way.

    python studies/hard_cases/writings.py [CASES] [--seed N] [--show N]

Draws CASES cases (default 500): a system of known kind, written anew by what must not change it, run by one method or
side by side. Guards are multiplied by constants of either sign or by what cannot vanish, or replaced by monotone
functions of themselves, each in one mode of its own; transitions, states and modes change their order and their
names; a mode is doubled; a state is added that nothing depends on, and an event that changes nothing; states change
sign or unit, and their bounds with them; time becomes a state, or begins elsewhere; resets are written so that they
cancel. The exit code is 0 if every case has the events and the tangents of the plain system.
"""

import argparse
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
import sympy

import chaosdrill as cd
from chaosdrill.engine.batch import Batch
from chaosdrill.engine.numerics import Numerics

METHODS = ("taylor", "dop853", "radau", "lanes")
"""``lanes`` are eight runs side by side by ``taylor``."""
T = sympy.Symbol("t", real=True)
BOUND = 1e9
"""What a state of the plain system has escaped beyond"""
SLACK = 1e-7
"""What times and tangents of two writings may differ by, relative to their sizes: their steps differ, and with them
their errors of 1e-12 a step, which the motion amplifies by 1e4 at most."""


@dataclass(frozen=True)
class Written:
    """A system as data that can be written anew."""

    states: tuple[Any, ...]
    modes: dict[str, dict[Any, Any]]
    transitions: tuple[tuple[str, tuple[str, ...], str, Any, int, dict[Any, Any]], ...]
    """name, sources, target, guard, direction, reset"""
    start: dict[Any, float]
    duration: float
    mode: str = ""
    forced: bool = False
    units: dict[Any, float] = field(default_factory=dict)
    """State of the plain system over that of this one"""
    names: dict[Any, str] = field(default_factory=dict)
    """What a state is called in the plain system, where that is not its name"""
    thrown: bool = False
    """Whether a reset throws the state across a guard: it is nowhere seen then that two guards vanish together"""

    def system(self) -> cd.HybridSystem:
        made = [
            cd.Transition(name, source, target, guard=guard, direction=direction, reset=reset)
            for name, source, target, guard, direction, reset in self.transitions
        ]
        return cd.HybridSystem(
            name="written",
            states=self.states,
            modes=self.modes,
            transitions=made,
            initial={"mode": self.mode or next(iter(self.modes)), **self.start},
            bounds={s: (-BOUND / abs(unit), BOUND / abs(unit)) for s, unit in self.units.items()},
            **({"time": T} if self.forced else {}),
        )

    def plain_names(self) -> list[str]:
        """Names of the states in the plain system, in their order here."""
        return [self.names.get(s, str(s)) for s in self.states]

    def with_states(self, put: dict[Any, Any]) -> "Written":
        """The same with other expressions for what is there; new states are put in by the caller."""

        def image(e: Any) -> Any:
            return sympy.sympify(e).xreplace(put)

        return replace(
            self,
            modes={mode: {s: image(e) for s, e in rates.items()} for mode, rates in self.modes.items()},
            transitions=tuple(
                (name, source, target, image(guard), direction, {s: image(e) for s, e in reset.items()})
                for name, source, target, guard, direction, reset in self.transitions
            ),
        )


def named(text: str) -> tuple[Any, ...]:
    return sympy.symbols(text, real=True)


def impact() -> Written:
    """A driven oscillator and a wall."""
    x, v = named("x v")
    wall = ("hit", ("free",), "free", x - 0.3, 1, {v: -0.8 * v})
    rates = {x: v, v: -x - 0.1 * v + sympy.cos(2.5 * T)}
    return Written((x, v), {"free": rates}, (wall,), {x: 0.0, v: 0.3}, 14.0, forced=True)


def two_sides() -> Written:
    """Two modes that meet at x = 0, with a loss at each passage."""
    x, v = named("x v")
    modes = {"right": {x: v, v: -x - 0.2}, "left": {x: v, v: -2 * x}}
    over = (
        ("over", ("right",), "left", x, -1, {v: 0.9 * v}),
        ("back", ("left",), "right", x, 1, {v: 0.95 * v}),
    )
    return Written((x, v), modes, over, {x: 1.0, v: 0.0}, 20.0)


def rocking() -> Written:
    """A block that rocks on two corners."""
    a, w = named("a w")
    modes = {"right": {a: w, w: a - 1}, "left": {a: w, w: a + 1}}
    hits = (
        ("to_left", ("right",), "left", a, -1, {w: 0.9 * w}),
        ("to_right", ("left",), "right", a, 1, {w: 0.9 * w}),
    )
    return Written((a, w), modes, hits, {a: 0.3, w: 0.0}, 6.0)


def thermostat() -> Written:
    x, y = named("x y")
    modes = {"on": {x: 2 - x, y: x - y}, "off": {x: -x, y: x - y}}
    switches = (("too_hot", ("on",), "off", x - 1.3, 1, {}), ("too_cold", ("off",), "on", x - 0.7, -1, {}))
    return Written((x, y), modes, switches, {x: 1.0, y: 0.2}, 12.0)


def chain() -> Written:
    """An event throws the state across the guard of another one, and a third has nothing to do with it."""
    x, y, z, w, u = named("x y z w u")
    rates = {x: sympy.Integer(1), y: sympy.Integer(1), z: -z, w: -w / 3, u: -u / 5 + z / 7}
    events = (
        ("a", ("run",), "run", x - 1, 1, {x: x - 1, z: z + 5}),
        ("b", ("run",), "run", y - 1, 1, {y: y - 1, w: w + 1}),
        ("c", ("run",), "run", z - 3, 1, {z: z / 2, u: u + z}),
    )
    return Written(
        (x, y, z, w, u), {"run": rates}, events, dict.fromkeys((x, y, w, u), 0.0) | {z: 0.5}, 4.5, thrown=True
    )


def landing() -> Written:
    """A reset lands on the guard of the mode that it leads to."""
    th, q = named("th q")
    modes = {
        "before": {th: sympy.Integer(1), q: sympy.Integer(0)},
        "arc": {th: sympy.Integer(1), q: sympy.cos(th)},
        "after": {th: sympy.Integer(1), q: sympy.Integer(0)},
    }
    events = (
        ("in", ("before",), "arc", th - sympy.pi / 4, 1, {q: sympy.sin(th) - sympy.sqrt(2) / 2}),
        ("out", ("arc",), "after", q, -1, {q: sympy.Integer(0)}),
        ("round", ("after",), "before", th - 2 * sympy.pi, 1, {th: th - 2 * sympy.pi}),
    )
    return Written((th, q), modes, events, {th: 0.0, q: 0.0}, 20.0)


def firing() -> Written:
    v, w = named("v w")
    rates = {v: 1.5 - v - w, w: 0.2 * (v - w)}
    return Written((v, w), {"run": rates}, (("fire", ("run",), "run", v - 1, 1, {v: 0 * v, w: w + 0.1}),),
                   {v: 0.0, w: 0.0}, 12.0)  # fmt: skip


def flip_flop() -> Written:
    """Two modes that change at every second root of a clock."""
    x, s = named("x s")
    modes = {"up": {x: 1 - x, s: sympy.Integer(1)}, "down": {x: -1 - x, s: sympy.Integer(1)}}
    clock = sympy.sin(2 * sympy.pi * s)
    turns = (("fall", ("up",), "down", clock, 1, {}), ("rise", ("down",), "up", clock, 1, {}))
    return Written((x, s), modes, turns, {x: 0.0, s: 0.7}, 7.5)


def entered() -> Written:
    """A mode that is entered on its guard, which the motion leads across at once."""
    x, v, s = named("x v s")
    one = sympy.Integer(1)
    modes = {"rise": {x: v, v: -0.1 * v, s: one}, "fall": {x: v, v: -one, s: one}, "late": {x: one, v: 0 * v, s: one}}
    events = (
        ("top", ("rise",), "fall", x - 1, 1, {v: -v / 2}),
        ("at_once", ("fall",), "late", x - 1, -1, {x: x - 2, v: v + 1}),
        ("again", ("late",), "rise", x, 1, {v: one, s: 0 * s}),
    )
    return Written((x, v, s), modes, events, {x: 0.0, v: 1.0, s: 0.0}, 12.0)


KINDS: dict[str, Callable[[], Written]] = {
    kind.__name__: kind for kind in (impact, two_sides, rocking, thermostat, chain, landing, firing, flip_flop, entered)
}


# What must not change anything


def _factor(rng: np.random.Generator, one: Written) -> Any:
    """What cannot vanish, or does not where these motions are."""
    y = one.states[rng.integers(len(one.states))]
    number = sympy.Rational(int(rng.integers(1, 9)), int(rng.integers(1, 9)))
    proven = [number, 1 + y**2, sympy.exp(y / 5), sympy.cosh(y / 3), 2 + sympy.sin(y), sympy.Integer(1)]
    free = [] if one.units or one.thrown else [1 + y / 50, 1 - y / 40]
    return [*proven, *free][rng.integers(len(proven) + len(free))]


def _monotone(rng: np.random.Generator, guard: Any) -> Any:
    forms = (guard, sympy.sinh(guard), guard + guard**3, sympy.atan(guard), guard**3, sympy.tanh(guard / 3), guard**5)
    return forms[rng.integers(len(forms))]


def guards(one: Written, rng: np.random.Generator) -> Written:
    """Every transition's guard written anew."""
    found = []
    for name, source, target, guard, direction, reset in one.transitions:
        sign = int(rng.choice([-1, 1]))
        other = sign * _factor(rng, one) * _monotone(rng, guard)
        found.append((name, source, target, other, sign * direction, reset))
    return replace(one, transitions=tuple(found))


def order(one: Written, rng: np.random.Generator) -> Written:
    return replace(one, transitions=tuple(one.transitions[i] for i in rng.permutation(len(one.transitions))))


def doubled(one: Written, rng: np.random.Generator) -> Written:
    """A mode that events leave for its copy, and the copy for it; one may lead in beyond the guard of `more`."""
    mode = list(one.modes)[rng.integers(len(one.modes))]
    copy, found = f"{mode}_2", []
    for name, source, target, guard, direction, reset in one.transitions:
        found.append((name, source, copy if source == (mode,) and target == mode else target, guard, direction, reset))
        if mode in source:
            found.append((f"{name}__2", (copy,), target, guard, direction, reset))
    thrown = one.thrown or any(name == "zz_mark" for name, *_ in found)
    return replace(one, modes={**one.modes, copy: one.modes[mode]}, transitions=tuple(found), thrown=thrown)


def more(one: Written, rng: np.random.Generator) -> Written:
    """A state that nothing depends on, and an event of it that changes nothing.

    Other modes do not see that event: one that leads back may put the state beyond its guard.
    """
    z = sympy.Symbol("zz", real=True)
    modes = {mode: {**rates, z: sympy.cos(z) + 0.3} for mode, rates in one.modes.items()}
    mark = ("zz_mark", tuple(modes)[:1], next(iter(modes)), sympy.sin(z) - 0.5, 1, {})
    states = (z, *one.states) if rng.integers(2) else (*one.states, z)
    return replace(
        one,
        states=states,
        modes=modes,
        transitions=(mark, *one.transitions),
        start={**one.start, z: 0.0},
        thrown=one.thrown or len(modes) > 1,
    )


def units(one: Written, rng: np.random.Generator) -> Written:
    """Other units, or another sign, of one state."""
    x = one.states[rng.integers(len(one.states))]
    unit = float(rng.choice([-1.0, 1.0])) * 2.0 ** float(rng.integers(-40, 41))
    put = {x: x * unit}

    def image(state: Any, e: Any) -> Any:
        return sympy.sympify(e).xreplace(put) / (unit if state == x else 1)

    return replace(
        one,
        modes={mode: {s: image(s, e) for s, e in rates.items()} for mode, rates in one.modes.items()},
        transitions=tuple(
            (name, source, target, guard.xreplace(put), direction, {s: image(s, e) for s, e in reset.items()})
            for name, source, target, guard, direction, reset in one.transitions
        ),
        start={**one.start, x: one.start[x] / unit},
        units={**one.units, x: unit * one.units.get(x, 1.0)},
    )


def cancelling(one: Written, rng: np.random.Generator) -> Written:
    """Resets that add and take away what is as large as their operands."""
    found = []
    for name, source, target, guard, direction, reset in one.transitions:
        y = one.states[rng.integers(len(one.states))]
        images = {}
        for s, e in reset.items():
            one_here = 1 / sympy.Rational(abs(one.units.get(s, 1.0)))
            images[s] = sympy.Add(e, one_here * (sympy.sin(y) ** 2 + sympy.cos(y) ** 2), -one_here, evaluate=False)
        found.append((name, source, target, guard, direction, images))
    return replace(one, transitions=tuple(found))


LETTERS = ("E", "I", "N", "S", "lam", "x10", "x9", "zeta", "A", "f", "Q_1", "mode_1")
"""Names that mean something elsewhere, or that sort otherwise than they are given."""


def names(one: Written, rng: np.random.Generator) -> Written:
    """States and modes under other names and in another order."""
    drawn = [sympy.Symbol(str(name), real=True) for name in rng.permutation(LETTERS)[: len(one.states)]]
    put = {old: new for old, new in zip(one.states, drawn, strict=True) if str(old) != "zz" and new not in one.states}

    def named(values: dict[Any, Any]) -> dict[Any, Any]:
        return {put.get(s, s): value for s, value in values.items()}

    modes = [list(one.modes)[i] for i in rng.permutation(len(one.modes))]
    called = {mode: f"{'ZaB'[i % 3]}_{i}_" + mode for i, mode in enumerate(modes)}
    found = one.with_states(put)
    return replace(
        found,
        states=tuple(put.get(one.states[i], one.states[i]) for i in rng.permutation(len(one.states))),
        modes={called[mode]: named(found.modes[mode]) for mode in modes},
        transitions=tuple(
            (name, tuple(called[mode] for mode in source), called[target], guard, direction, named(reset))
            for name, source, target, guard, direction, reset in found.transitions
        ),
        start=named(one.start),
        mode=called[one.mode or next(iter(one.modes))],
        units=named(one.units),
        names={put.get(s, s): name for s, name in zip(one.states, one.plain_names(), strict=True)},
    )


def clock(one: Written, rng: np.random.Generator) -> Written:
    """Time as a state, which may begin elsewhere."""
    if not one.forced:
        return one
    s, shift = sympy.Symbol("zzt", real=True), sympy.Rational(int(rng.integers(-40, 40)), 8)
    found = one.with_states({T: s - shift})
    return replace(
        found,
        states=(*one.states, s),
        modes={mode: {**rates, s: sympy.Integer(1)} for mode, rates in found.modes.items()},
        start={**one.start, s: float(shift)},
        forced=False,
    )


CHANGES = (guards, order, doubled, more, units, cancelling, names, clock)


# Whether it did


class Found(NamedTuple):
    """What a run shows, in the plain system's states."""

    outcome: str
    counts: dict[str, int]
    times: list[tuple[str, float]]
    """Events by name and time; none side by side"""
    result: np.ndarray
    """Tangent map of a single run, state at the end of one side by side"""


def plain_name(transition: cd.Transition) -> str:
    """Name of a transition in the plain system."""
    return transition.name.split("__")[0]


def order_of(one: Written) -> list[int]:
    """Where the plain system's states are, by name."""
    states = one.plain_names()
    return [states.index(name) for name in sorted(states) if not name.startswith("zz")]


def alone(one: Written, system: cd.HybridSystem, method: str) -> Found:
    """One run by one method."""
    found = cd.trajectory(
        system, duration=one.duration, samples=1, tangents=True, method=method, tolerance=1e-12, progress=False
    )
    names = [plain_name(system.transitions[int(k)]) for k in found["event_kind"].values]
    events = [(n, float(t)) for n, t in zip(names, found["event_time"].values, strict=True) if n != "zz_mark"]
    matrix = np.linalg.solve(found["initial_tangent"].values, found["final_tangent"].values)
    scale = np.array([one.units.get(s, 1.0) for s in one.states])
    # a row is what becomes of a tangent along one state
    matrix = matrix * scale[np.newaxis, :] / scale[:, np.newaxis]
    outcome = cd.Outcome(int(found["outcome"])).meaning
    return Found(outcome, Counter(n for n, _ in events), events, matrix[np.ix_(order_of(one), order_of(one))])


def side_by_side(one: Written, system: cd.HybridSystem) -> Found:
    """Eight runs from the same start, stepped together; the first of them, if all are the same to the bit."""
    start = [one.start[s] for s in one.states]
    modes = np.full(8, system.mode_names.index(system.initial["mode"]))
    runs = Batch(system, {}, np.array([start] * 8), modes, Numerics("taylor", 1e-12), unit=one.duration)
    runs.run(0, np.array([0, 1]))
    if not np.array_equal(runs.x, np.array([runs.x[0]] * 8), equal_nan=True):
        return Found("runs side by side differ", {}, [], np.zeros(0))
    counts: dict[str, int] = Counter()
    for transition, number in zip(system.transitions, runs.counts[0].tolist(), strict=True):
        if (name := plain_name(transition)) != "zz_mark" and number:
            counts[name] += number
    scale = np.array([one.units.get(s, 1.0) for s in one.states])
    return Found(cd.Outcome(int(runs.outcome[0])).meaning, counts, [], (runs.x[0] * scale)[order_of(one)])


def run(one: Written, system: cd.HybridSystem, method: str) -> Found:
    """What a system shows by a method, or in lanes."""
    return side_by_side(one, system) if method == "lanes" else alone(one, system, method)


def differences(plain: Found, other: Found) -> list[str]:
    """What two runs of one system do not share."""
    if plain.outcome != other.outcome:
        return [f"outcome {other.outcome}, not {plain.outcome}"]
    if plain.counts != other.counts:
        return [f"{sum(other.counts.values())} events, not {sum(plain.counts.values())}"]
    wrong = [
        f"{a[0]} at {b[1]!r}, not {a[1]!r}"
        for a, b in zip(sorted(plain.times), sorted(other.times), strict=True)
        if abs(a[1] - b[1]) > SLACK
    ]
    gap = float(np.abs(plain.result - other.result).max() / np.abs(plain.result).max())
    return wrong + ([f"results differ by {gap:.1e}"] if not gap <= SLACK * 100 else [])


_PLAIN: dict[tuple[str, str], Found] = {}


def cases(kind: str, number: int) -> Iterator[tuple[str, list[str]]]:
    """One writing by every method and side by side: what differs from the plain system."""
    plain = KINDS[kind]()
    rng = np.random.default_rng([number, *map(ord, kind)])
    other = plain
    for change in rng.permutation(len(CHANGES))[: rng.integers(1, 4)]:
        other = CHANGES[change](other, rng)
    system = other.system()
    for method in METHODS:
        if (kind, method) not in _PLAIN:
            _PLAIN[kind, method] = run(plain, plain.system(), method)
        try:
            yield method, differences(_PLAIN[kind, method], run(other, system, method))
        except cd.ChaosdrillError as error:
            yield method, [str(error)]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("cases", nargs="?", type=int, default=500)
    parser.add_argument("--seed", type=int, default=20261125)
    parser.add_argument("--show", type=int, default=10)
    given = parser.parse_args()
    wrong: dict[str, int] = {}
    done = 0
    for i in range(-(-given.cases // len(METHODS))):
        kind = list(KINDS)[i % len(KINDS)]
        for method, found in cases(kind, given.seed + i):
            done += 1
            if found:
                wrong[kind] = wrong.get(kind, 0) + 1
                if sum(wrong.values()) <= given.show:
                    print(f"{kind} {given.seed + i} {method}: {found[0]}", flush=True)
    print(f"{done} cases, {sum(wrong.values())} wrong", wrong or "")
    return int(bool(wrong))


if __name__ == "__main__":
    sys.exit(main())
