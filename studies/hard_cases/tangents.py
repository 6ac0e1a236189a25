"""Tangents of random systems whose events cause others or fall together, beside differences of runs.

    python studies/hard_cases/tangents.py [SYSTEMS] [--seed N] [--show N]

Draws SYSTEMS systems (default 1000): a clock whose event throws a state across the guard of a second event, which may
throw another one across that of a third; in half of them a second clock ticks with the first, and two events share a
surface. Their tangent maps are compared with differences of fourth order over runs with the same events. The exit code
is 0 if none is off by more than the differences are.
"""

import argparse
import sys
from typing import Any

import numpy as np
import sympy

import chaosdrill as cd

METHODS = ("taylor", "dop853", "radau")
STEP = 2e-3
"""Displacement of a state for a difference: of fourth order it leaves out about 1e-10."""

CLOSE = 1e-6
"""Part of the largest entry that a tangent may be off: differences of displacements of 1e-3 and errors of 1e-12."""

X, Y, P, Q, R, S = STATES = sympy.symbols("x y p q r s", real=True)


def drawn(rng: np.random.Generator) -> tuple[cd.HybridSystem, float]:
    """A system and how long it runs."""

    def c(low: float = -1.0, high: float = 1.0) -> Any:
        return sympy.Float(round(float(rng.uniform(low, high)), 3))

    tied, shared = bool(rng.integers(2)), bool(rng.integers(2))
    rates = {
        X: sympy.Integer(1),
        Y: sympy.Integer(1),
        P: c(-1, -0.3) * P + c(-0.3, 0.3) * sympy.sin(R),
        Q: c(-1, -0.3) * Q + c(-0.3, 0.3) * P,
        R: c(-0.5, 0.5) * R + c(-0.3, 0.3) * P * Q + c(0, 0.3) * sympy.cos(X),
        S: c(-1, 0) * S + c(-0.2, 0.2) * sympy.sin(S),
    }
    other = {state: rate + (c(-0.3, 0.3) if state in (P, Q, R) else 0) for state, rate in rates.items()}
    two = bool(rng.integers(2))
    home, away = "home", "away" if two else "home"
    both = tuple(dict.fromkeys((home, away)))
    # the clock's event throws p over 2, which may throw q over 2
    tick = {X: X - 1, P: P + c(3, 4) + c(-0.2, 0.2) * R, R: R + c(-0.3, 0.3) * Q + c(-0.1, 0.1) * P**2}
    over_p = {
        P: c(0.2, 0.4) * P + c(-0.1, 0.1) * R,
        Q: Q + (c(3, 4) if rng.integers(2) else c(0, 0.3)) + c(-0.1, 0.1) * P,
    }
    over_q = {Q: c(0.2, 0.4) * Q, R: R + c(-0.3, 0.3) * Q}
    events = [
        cd.Transition("tick", home, away, X - 1, 1, reset=tick),
        cd.Transition("over_p", both, home if rng.integers(2) else away, P - 2, 1, reset=over_p),
        cd.Transition("over_q", both, home, Q - 2, 1, reset=over_q),
    ]
    if two:
        events.append(cd.Transition("tick_away", away, home, 2 * X - 2 if shared else X - 1, 1, reset=tick))
    if tied:
        events.append(
            cd.Transition("other", both, home, Y - 1, 1, reset={Y: Y - 1, S: S + c(0.3, 1)})
            if not two
            else cd.Transition("other", both, home, sympy.Symbol("y", real=True) - 1, 1, reset={Y: Y - 1, S: S + 1})
        )
    start = {X: c(0, 0.9), P: c(0, 0.5), Q: c(0, 0.5), R: c(0, 0.5), S: c(0, 0.5)}
    start[Y] = start[X] if tied else c(0, 0.9)
    modes = {home: rates} | ({away: other} if two and not tied else {away: dict(rates)} if two else {})
    system = cd.HybridSystem(
        name="drawn", states=STATES, modes=modes,
        transitions=[events[i] for i in rng.permutation(len(events))],
        initial={"mode": home, **{s: float(v) for s, v in start.items()}},
    )  # fmt: skip
    return system, 2.85 - float(start[X])


def ends(run: Any, system: cd.HybridSystem) -> tuple[np.ndarray, list[str]]:
    return run["states"].values[-1], sorted(system.transitions[int(k)].name for k in run["event_kind"].values)


def compared(system: cd.HybridSystem, length: float, method: str) -> float | None:
    """Largest difference of the tangents, over the largest entry; None where the runs differ in their events."""
    given = {"duration": length, "samples": 1, "method": method, "progress": False}
    run = cd.trajectory(system, tangents=True, **given)
    _, names = ends(run, system)
    if int(run["outcome"]) != cd.Outcome.OK or len(names) < 4:
        return None
    found = np.linalg.solve(run["initial_tangent"].values, run["final_tangent"].values)
    right = np.empty_like(found)
    for i, state in enumerate(system.state_names):
        parts = []
        for k in (-2, -1, 1, 2):
            moved = system.with_initial(**{state: system.initial[state] + k * STEP})
            end, its = ends(cd.trajectory(moved, **given), moved)
            if its != names:
                return None
            parts.append(end)
        right[i] = (parts[0] - 8 * parts[1] + 8 * parts[2] - parts[3]) / (12 * STEP)
    return float(np.abs(found - right).max() / np.abs(right).max())


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("systems", nargs="?", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=20261125)
    parser.add_argument("--show", type=int, default=10)
    given = parser.parse_args()
    done = wrong = skipped = 0
    worst = 0.0
    while done < given.systems:
        number = given.seed + done + skipped
        system, length = drawn(np.random.default_rng(number))
        gap = compared(system, length, METHODS[number % len(METHODS)])
        if gap is None:
            skipped += 1
            continue
        done += 1
        worst = max(worst, gap) if gap <= CLOSE else worst
        if not gap <= CLOSE:
            wrong += 1
            if wrong <= given.show:
                print(f"{number} {METHODS[number % len(METHODS)]}: off by {gap:.1e}")
    print(f"{done} systems, {wrong} wrong; the others within {worst:.1e} ({skipped} drawn in vain)")
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
