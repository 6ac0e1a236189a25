"""Two more families: kicks by a clock, calculated in fractions by the rules for events, and switches of modes."""

from collections.abc import Callable
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cache

import numpy as np
import sympy
from event_families import (
    CLEAR,
    ROUNDING,
    SNAP,
    Family,
    Numbers,
    Times,
    UnclearError,
    either_sign,
    event,
    unbounded,
    within,
)

import chaosdrill as cd

# Straight lines between kicks at clock ticks: all of it in fractions, with the sides of guards as the theory has them


@dataclass
class Ruled:
    """The rules for events, in fractions, for states that move on straight lines.

    Parameters
    ----------
    rates : callable
        Rates of the states, from the states.
    guards : list of tuple
        Name, value as a function of the states, direction, reset as a function of the states; the first acts first.
    """

    rates: Callable[[dict[str, Fraction]], dict[str, Fraction]]
    guards: list[tuple[str, Callable[[dict[str, Fraction]], Fraction], int, Callable[[dict[str, Fraction]], None]]]
    found: list[tuple[str, Fraction]] = field(default_factory=list)

    def speed(self, value: Callable[[dict[str, Fraction]], Fraction], state: dict[str, Fraction]) -> Fraction:
        """Rate of a guard that is linear in the states."""
        rates = self.rates(state)
        return value({k: state[k] + rates[k] for k in state}) - value(state)

    def run(self, state: dict[str, Fraction], length: Fraction) -> list[tuple[str, Fraction]]:
        """Events in [0, length)."""
        time = Fraction(0)
        sides = []
        for _, value, _, _ in self.guards:
            here, speed = value(state), self.speed(value, state)
            if here == 0 and speed == 0:
                raise UnclearError
            sides.append((here > 0) - (here < 0) or (-1 if speed > 0 else 1))
        while True:
            waits: list[tuple[Fraction, int]] = []
            for i, (_, value, _, _) in enumerate(self.guards):
                here, speed = value(state), self.speed(value, state)
                if here * sides[i] < 0:
                    # a reset has thrown the state across
                    waits.append((Fraction(0), i))
                elif speed * sides[i] < 0:
                    waits.append((-here / speed, i))
            wait, i = min(waits, default=(length, -1))
            if i < 0 or time + wait >= length:
                return self.found
            if any(0 < abs(w - wait) < Fraction(CLEAR) for w, _ in waits) or 0 < length - time - wait < Fraction(CLEAR):
                raise UnclearError
            rates = self.rates(state)
            state = {k: state[k] + rates[k] * wait for k in state}
            time += wait
            name, _, direction, reset = self.guards[i]
            sides[i] = -sides[i]
            if direction in (0, sides[i]):
                self.found.append((name, time))
                before = {k: value(state) for k, (_, value, _, _) in enumerate(self.guards)}
                speeds = [self.speed(value, state) for _, value, _, _ in self.guards]
                reset(state)
                for k, (_, value, _, _) in enumerate(self.guards):
                    # only the last digit tells whether what is thrown back has been across
                    if k != i and before[k] == 0 and speeds[k] * (value(state) or self.speed(value, state)) < 0:
                        raise UnclearError
                for k, (_, value, way, _) in enumerate(self.guards):
                    after = value(state)
                    if after != before[k] and after * sides[k] < 0 and way not in (0, -sides[k]):
                        sides[k] = -sides[k]
                    if after == 0 != before[k] and self.speed(value, state) * sides[k] > 0:
                        # a state that is thrown onto a guard and turns back has crossed it by a last digit or not
                        raise UnclearError


@cache
def kicks() -> Family:
    """A point that moves on a line is kicked in place and speed by a clock, past marks that it may be thrown across."""
    x, v, clock, other, s, n = sympy.symbols("x v clock other s n", real=True)
    rate, rate2, push, jump, d1, d2, d3, scale = sympy.symbols("rate rate2 push jump d1 d2 d3 scale", real=True)
    count = {n: n + 1}
    system = cd.HybridSystem(
        name="kicks",
        states=(x, v, clock, other, s, n),
        parameters={
            "rate": 1.0,
            "rate2": 1.0,
            "push": 0.0,
            "jump": 0.0,
            "d1": 1.0,
            "d2": 1.0,
            "d3": 1.0,
            "scale": 1.0,
        },
        modes={"run": {x: v, v: 0, clock: rate, other: rate2, s: 1, n: 0}},
        transitions=[
            event("rise", scale * (x - d1), +1),
            event("fall", scale * (x - d2), -1, count),
            event("kick", scale * (clock - 1), +1, {clock: clock - 1, v: push - v / 2, x: x + jump}),
            event("tick", scale * (other - 1), +1, {other: other - 1, n: n + 1}),
            event("either", scale * (x - d3), 0, count),
        ],
        period=sympy.Integer(1),
        bounds=unbounded(x, v, clock, other, s, n),
    )

    def draw(rng: np.random.Generator) -> Numbers:
        def eighths(low: int, high: int) -> float:
            return float(rng.integers(low, high + 1)) / 8

        start = eighths(-16, 16)
        return {
            "rate": float(rng.choice([0.5, 1.0, 2.0])),
            "rate2": float(rng.choice([0.5, 1.0, 2.0])),
            "push": eighths(-16, 16),
            "jump": float(rng.choice([0.0, 0.0, eighths(-16, 16)])),
            "d1": start if rng.random() < 0.1 else eighths(-24, 24),
            "d2": start if rng.random() < 0.1 else eighths(-24, 24),
            "d3": start if rng.random() < 0.1 else eighths(-24, 24),
            # the clocks must rise
            "scale": abs(either_sign(rng, 9)),
            "x": start,
            "v": eighths(-16, 16),
            "clock": eighths(0, 8),
            "other": eighths(0, 8),
        }

    def times(of: Numbers, length: float, tolerance: float) -> Times:
        exact = {name: Fraction(value) for name, value in of.items()}

        def kick(state: dict[str, Fraction]) -> None:
            state["clock"] -= 1
            state["v"] = exact["push"] - state["v"] / 2
            state["x"] += exact["jump"]

        def tick(state: dict[str, Fraction]) -> None:
            state["other"] -= 1

        def nothing(state: dict[str, Fraction]) -> None:
            pass

        rules = Ruled(
            lambda state: {
                "x": state["v"],
                "v": Fraction(0),
                "clock": exact["rate"],
                "other": exact["rate2"],
            },
            [
                ("rise", lambda state: state["x"] - exact["d1"], +1, nothing),
                ("fall", lambda state: state["x"] - exact["d2"], -1, nothing),
                ("kick", lambda state: state["clock"] - 1, +1, kick),
                ("tick", lambda state: state["other"] - 1, +1, tick),
                ("either", lambda state: state["x"] - exact["d3"], 0, nothing),
            ],
        )
        found = rules.run({k: exact[k] for k in ("x", "v", "clock", "other")}, Fraction(length))
        lists = {name: np.array([float(time) for who, time in found if who == name]) for name, *_ in rules.guards}
        # the slowest motion that meets a mark is an eighth less what halving leaves of it
        return {name: (values, np.full(len(values), 1e3 * (tolerance + ROUNDING))) for name, values in lists.items()}

    return Family("kicks in fractions", system, 6, lambda of: 6.0, draw, times, ("scale", "d1"))


# Switches of modes


@cache
def switches() -> Family:
    """A saw tooth between two switches of modes, with a counter in either mode that may tie with them."""
    x, clock, z, s, n = sympy.symbols("x clock z s n", real=True)
    up, down, high, decay, scale = sympy.symbols("up down high decay scale", real=True)
    shared = {clock: 1, z: -decay * z, s: 1, n: 0}
    tick = [
        event(f"tick-{mode}", scale * (clock - 1), +1, {clock: clock - 1, n: n + 1}, mode) for mode in ("up", "down")
    ]
    system = cd.HybridSystem(
        name="switches",
        states=(x, clock, z, s, n),
        parameters={"up": 1.0, "down": 1.0, "high": 1.0, "decay": 1.0, "scale": 1.0},
        modes={"up": {x: up, **shared}, "down": {x: -down, **shared}},
        transitions=[
            cd.Transition("top", "up", "down", guard=scale * (x - high), direction=+1, kind="event"),
            cd.Transition("bottom", "down", "up", guard=scale * x, direction=-1, kind="event"),
            *tick,
        ],
        period=sympy.Integer(1),
        initial={"mode": "up"},
        bounds=unbounded(x, clock, z, s, n),
    )

    def draw(rng: np.random.Generator) -> Numbers:
        size = 2.0 ** rng.integers(-30, 30)
        up, down = (size * float(rng.choice([0.5, 1.0, 1.5, 2.0, 3.0])) for _ in range(2))
        return {
            "up": up,
            "down": down,
            "high": size * float(rng.choice([0.5, 1.0, 0.75])),
            "decay": float(rng.choice([0.0, 1.0, 100.0, 2e3], p=[0.3, 0.3, 0.3, 0.1])),
            "scale": abs(either_sign(rng, 9)),
            "clock": float(rng.integers(0, 8)) / 8,
            "z": either_sign(rng, 6),
        }

    def times(of: Numbers, length: float, tolerance: float) -> Times:
        rise, drop = of["high"] / of["up"], of["high"] / of["down"]
        rounds = np.arange(int(length / (rise + drop)) + 2) * (rise + drop)
        # many short steps leave no exact end
        exact = of["decay"] <= 1
        top, bottom = (within(rounds + first, length, exact=exact) for first in (rise, rise + drop))
        ticks = within(np.arange(1, int(length) + 2) - of["clock"], length)
        # the first declared acts first: at a tie the counter sees the mode after the switch
        switched = np.sort(np.concatenate([top, bottom]))
        if len(switched):
            near = np.abs(ticks[:, np.newaxis] - switched[np.newaxis, :])
            if np.any((near > SNAP) & (near < CLEAR)):
                raise UnclearError
        later = np.searchsorted(switched, ticks + CLEAR) % 2
        error = 100 * (tolerance + ROUNDING) * length * (1 + of["decay"] / 30)
        lists = {"top": top, "bottom": bottom, "tick-up": ticks[later == 0], "tick-down": ticks[later == 1]}
        return {name: (values, np.full(len(values), error)) for name, values in lists.items()}

    return Family("switches of modes", system, 6, lambda of: 6.0, draw, times, ("scale", "decay"))
