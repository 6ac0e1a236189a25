"""What an effect costs that a scene leaves out: the drill without it against a system written by hand without it.

Two scenes: a bit on fixed rock with a Newtonian stop (no rock-side mass, no friction), and a drill without a stop.
The systems by hand hold what is left, and no more; both are run in turn, and the ratio of their times is one if
nothing is paid for what is absent.
"""

import math
from statistics import median

import sympy
from programs import timed

import chaosdrill as cd
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run

Y, U, W, T = sympy.symbols("y u w t", real=True)
A, B, XI, ETA, MU, G, R, E, PHI = sympy.symbols("a b xi eta mu g r e phi", real=True)
PERIODS, TRANSIENT = 4000, 300


def bit_alone() -> "cd.HybridSystem":
    """A bit that hits fixed rock with restitution e."""
    return cd.HybridSystem(
        name="bit on fixed rock",
        states=(Y, U),
        time=T,
        parameters={"a": 0.25, "b": 0.7, "xi": 0.06, "eta": 0.8, "phi": math.pi / 2, "r": 1.0, "e": 0.8},
        modes={"stick": {Y: U, U: B + A * sympy.cos(ETA * T + PHI) - Y - 2 * XI * U}},
        transitions=[cd.Transition("hit", "stick", "stick", guard=Y - R, direction=+1, reset={U: -E * U})],
        period=2 * sympy.pi / ETA,
        bounds={Y: (-1e3, 1e3), U: (-1e3, 1e3)},
    )


def no_stop() -> "cd.HybridSystem":
    """Bit and rock tied by a spring, with Stribeck friction and no stop."""
    load = B + A * sympy.cos(ETA * T + PHI)
    force = Y + 2 * XI * (U - W)
    friction = MU + (1 - MU) * sympy.exp(-G * W)
    return cd.HybridSystem(
        name="drill without a stop",
        states=(Y, U, W),
        time=T,
        parameters={"a": 0.25, "b": 0.7, "xi": 0.06, "eta": 0.8, "phi": math.pi / 2, "eps": 1.0, "mu": 0.8, "g": 3.0},
        modes={
            "stick": {Y: U, U: load - Y - 2 * XI * U, W: 0},
            "slip": {Y: U - W, U: load - force, W: sympy.Symbol("eps", real=True) * (force - friction)},
        },
        transitions=[
            cd.Transition("release", "stick", "slip", guard=Y + 2 * XI * U - 1, direction=+1),
            cd.Transition("stick", "slip", "stick", guard=W, direction=-1, reset={W: 0}),
        ],
        period=2 * sympy.pi / ETA,
        quadratures={"penetration": W},
        bounds={Y: (-1e3, 1e3), U: (-1e3, 1e3), W: (-25.0, 25.0)},
    )


def pairs() -> dict[str, tuple["cd.HybridSystem", "cd.HybridSystem"]]:
    """Return by name the drill without an effect, and what was written by hand."""
    return {
        "fixed rock, no friction, Newtonian stop": (
            cd.drill(friction="none", rock="fixed", contact="newton", e=0.8),
            bit_alone(),
        ),
        "no stop": (cd.drill(contact="none", mu=0.8), no_stop()),
    }


def compare(rounds: int = 7) -> dict[str, tuple[float, float, float]]:
    """Return by name microseconds a period of both, and the median ratio of the drill to what was written by hand."""
    found = {}
    for name, systems in pairs().items():
        runs = []
        for system in systems:
            run = Run(system, system.forcing_period(), Numerics())
            run.advance(TRANSIENT)
            runs.append(run)
        times = [[timed(run, PERIODS) for run in runs] for _ in range(rounds)]
        drill, hand = (median(column) for column in zip(*times, strict=True))
        found[name] = drill, hand, median(a / b for a, b in times)
    return found


def table(found: dict[str, tuple[float, float, float]]) -> str:
    """Return the times as Markdown."""
    lines = ["| left out | drill, µs a period | by hand | ratio |", "| --- | --- | --- | --- |"]
    lines += [f"| {name} | {a:.3g} | {b:.3g} | {ratio:.3f} |" for name, (a, b, ratio) in found.items()]
    return "\n".join(lines) + "\n"
