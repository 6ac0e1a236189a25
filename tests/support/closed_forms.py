"""Hybrid systems whose arcs have a closed form, and their runs to any number of digits.

A case holds the system, its start, a length, and three functions of time and state in mpmath: the state on an arc, the
guard, and the reset. The tangent map is the derivative of the whole run by its start: no saltation matrix is used.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import mpmath
import numpy as np

import chaosdrill as cd

DIGITS = 40


@dataclass(frozen=True)
class Case:
    """One system in closed form; ``arc(t, t0, state)``, ``guard(t, state)``, ``reset(t, state)``; guards rise."""

    name: str
    system: Any
    start: tuple[str, ...]
    length: float
    arc: Callable[..., Any]
    guard: Callable[..., Any]
    reset: Callable[..., Any]

    def solve(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """State at the end, times of the events, tangent map, shape (n, n), one image a row."""
        with mpmath.workdps(DIGITS):
            start = [mpmath.mpf(s) for s in self.start]
            guesses: list[Any] = []
            state, times = self._run(start, guesses)
            h = mpmath.mpf(10) ** (-DIGITS // 4)
            rows = []
            for i in range(len(start)):
                ends = []
                for sign in (1, -1):
                    moved = list(start)
                    moved[i] += sign * h
                    ends.append(self._run(moved, guesses)[0])
                rows.append([(a - b) / (2 * h) for a, b in zip(*ends, strict=True)])
            return tuple(np.array(mpmath.matrix(v).tolist(), dtype=float).squeeze() for v in (state, times, rows))

    def _run(self, state: list[Any], guesses: list[Any]) -> tuple[list[Any], list[Any]]:
        known = len(guesses) > 0
        t0 = mpmath.mpf(0)
        times: list[Any] = []
        while True:
            if not known:
                guess = self._look(t0, state)
                guesses.append(guess)
            guess = guesses[len(times)]
            if guess is None:
                return self.arc(mpmath.mpf(self.length), t0, state), times
            t = mpmath.findroot(lambda s, t0=t0, state=state: self.guard(s, self.arc(s, t0, state)), guess)
            state = self.reset(t, self.arc(t, t0, state))
            times.append(t)
            t0 = t

    def _look(self, t0: Any, state: list[Any]) -> Any:
        """Interval in which the guard first rises through zero, on a grid much finer than the distance of roots."""
        step = mpmath.mpf(1) / 64
        t = t0 + step
        before = self.guard(t, self.arc(t, t0, state))
        while t < self.length:
            after = self.guard(t + step, self.arc(t + step, t0, state))
            if before < 0 <= after:
                return (t, t + step) if t + step < self.length else None
            t, before = t + step, after
        return None


def impact_oscillator() -> Case:
    """x'' + x = cos(5t/2) with a wall at 3/10, restitution 4/5."""
    omega, wall, e = mpmath.mpf("2.5"), mpmath.mpf("0.3"), mpmath.mpf("0.8")
    amplitude = 1 / (1 - omega**2)

    def arc(t, t0, state):
        a = state[0] - amplitude * mpmath.cos(omega * t0)
        b = state[1] + amplitude * omega * mpmath.sin(omega * t0)
        c, s = mpmath.cos(t - t0), mpmath.sin(t - t0)
        return [
            a * c + b * s + amplitude * mpmath.cos(omega * t),
            b * c - a * s - amplitude * omega * mpmath.sin(omega * t),
        ]

    system = cd.HybridSystem(
        name="impact-oscillator",
        states="x v",
        parameters={"omega": 2.5, "wall": 0.3, "e": 0.8},
        modes={"free": {"x": "v", "v": "-x + cos(omega*t)"}},
        transitions=[cd.Transition("impact", "free", "free", "x - wall", +1, reset={"v": "-e*v"})],
        initial={"v": 0.25},
    )
    return Case(
        "impact oscillator", system, ("0", "0.25"), 10.0, arc, lambda t, s: s[0] - wall, lambda t, s: [wall, -e * s[1]]
    )


def ball_on_a_table() -> Case:
    """x'' = -1 above a table at sin(2t)/8, restitution 3/4: the guard depends on time."""
    high, omega, e = mpmath.mpf("0.125"), mpmath.mpf(2), mpmath.mpf("0.75")

    def arc(t, t0, state):
        s = t - t0
        return [state[0] + state[1] * s - s * s / 2, state[1] - s]

    def reset(t, state):
        speed = high * omega * mpmath.cos(omega * t)
        return [high * mpmath.sin(omega * t), speed - e * (state[1] - speed)]

    onto = {"x": "sin(2*t)/8", "v": "7*cos(2*t)/16 - 3*v/4"}
    system = cd.HybridSystem(
        name="ball-on-a-table",
        states="x v",
        parameters={},
        modes={"free": {"x": "v", "v": "-1"}},
        transitions=[cd.Transition("impact", "free", "free", "sin(2*t)/8 - x", +1, reset=onto)],
        initial={"x": 1.0},
    )
    return Case(
        "ball on a table", system, ("1", "0"), 6.0, arc, lambda t, s: high * mpmath.sin(omega * t) - s[0], reset
    )


def growth_with_harvest() -> Case:
    """x' = x (1 - x), y' = -x y, harvested where x + y**2 / 4 = 9/10: field and guard are both curved."""

    def arc(t, t0, state):
        grown = 1 - state[0] + state[0] * mpmath.exp(t - t0)
        return [state[0] * mpmath.exp(t - t0) / grown, state[1] / grown]

    system = cd.HybridSystem(
        name="growth-with-harvest",
        states="x y",
        parameters={},
        modes={"grow": {"x": "x*(1 - x)", "y": "-x*y"}},
        transitions=[
            cd.Transition("harvest", "grow", "grow", "x + y**2/4 - 9/10", +1, reset={"x": "x/4 + y/8", "y": "y + x/2"})
        ],
        initial={"x": 0.25, "y": 0.5},
    )
    return Case(
        "growth with harvest",
        system,
        ("0.25", "0.5"),
        12.0,
        arc,
        lambda t, s: s[0] + s[1] ** 2 / 4 - mpmath.mpf("0.9"),
        lambda t, s: [s[0] / 4 + s[1] / 8, s[1] + s[0] / 2],
    )


CASES = (impact_oscillator, ball_on_a_table, growth_with_harvest)
