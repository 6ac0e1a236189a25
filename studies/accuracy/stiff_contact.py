"""A contact that is mapped against one that is resolved, over its stiffness; tangents through it, over the steps.

The drill's cycle of period 1 with the contact integrated (``compliant``) comes to the one whose hits take no time as
k^(-1/(n+1)), the time that a contact takes. And the body of hard case 8 goes through a contact of stiffness 1e8: how
many steps does a method need there, for the speed and for its derivative?
"""

import sys
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import chaosdrill as cd
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run
from chaosdrill.plots.palette import PALETTE
from chaosdrill.plots.style import WIDTH

sys.path.append(str(Path(__file__).resolve().parent.parent / "hard_cases"))
from case_08_stiff_tangents import AFTER, METHODS, SPEED, contact_time, entry, leaving, pressed

STIFFNESSES = tuple(10.0**p for p in range(4, 11))
STEPS = (12, 24, 48, 96, 192, 384, 768)
TOLERANCES = tuple(10.0**-p for p in range(4, 15))
STIFF = 1e8


@dataclass(frozen=True)
class Resolved:
    """The drill at exponent ``n`` and stiffness ``k``: distance of strobe point and trace from those of the map."""

    n: float
    k: float
    strobe: float
    trace: float


@dataclass(frozen=True)
class Through:
    """One way through the contact: its steps, and the errors of the exit speed and of its derivative by the place."""

    method: str
    n: float
    steps: int
    speed: float
    derivative: float


def over_stiffness(exponents: Iterable[float] = METHODS, stiffnesses: Iterable[float] = STIFFNESSES) -> list[Resolved]:
    """Return the distance of both contacts, every exponent at every stiffness."""
    point, trace = _cycle(cd.drill(eta=0.8), "taylor")
    found = []
    for n in exponents:
        for k in stiffnesses:
            other, its_trace = _cycle(cd.drill(eta=0.8, contact="compliant", k=k, n=n), METHODS[n])
            found.append(Resolved(n, k, float(np.abs(other - point).max()), abs(its_trace - trace)))
    return found


def _cycle(system: "cd.HybridSystem", method: str) -> tuple[np.ndarray, float]:
    section = cd.poincare_section(system, periods=16, transient=600, method=method)
    if int(section["period"]) != 1:
        raise RuntimeError(f"period {int(section['period'])} where 1 was expected")
    return section["section"].values[-1, :3], float(section["multiplier_real"].sum())


def through() -> list[Through]:
    """Return errors over steps for the fixed-step method, and over tolerances for the adaptive ones."""
    found = []
    for n, adaptive in METHODS.items():
        share = contact_time(STIFF, n) / (contact_time(STIFF, n) + AFTER)
        ways = [("rk4", Numerics("rk4", 1e-16, round(steps / share))) for steps in STEPS]
        ways += [(adaptive, Numerics(adaptive, tolerance)) for tolerance in TOLERANCES]
        found += [_way(method, numerics, n) for method, numerics in ways]
    return found


def _way(method: str, numerics: Numerics, n: float) -> Through:
    later = contact_time(STIFF, n) + AFTER
    run = Run(pressed(STIFF, n), later, numerics, tangents=np.eye(2), orthonormalise=False)
    run.advance(1)
    speed, derivative = abs(leaving(run.x) + SPEED), abs(float(run.vectors[0, 1]) - entry(STIFF, n))
    return Through(method, n, run.steps, speed, derivative)


def slope(found: list[Resolved], n: float) -> float:
    """Return the slope of log distance over log stiffness, over the stiffest two decades."""
    ends = [r.strobe for r in found if r.n == n and r.k in (1e8, 1e10)]
    return float(np.log(ends[1] / ends[0]) / np.log(100))


def table(found: list[Resolved], ways: list[Through]) -> str:
    """Return both measurements as Markdown."""
    lines = ["| k' | " + " | ".join(f"strobe, n = {n:g} | trace, n = {n:g}" for n in METHODS) + " |"]
    lines.append("| --- " * (1 + 2 * len(METHODS)) + "|")
    for k in STIFFNESSES:
        cells = [
            f"{value:.2e}" for n in METHODS for r in found if (r.n, r.k) == (n, k) for value in (r.strobe, r.trace)
        ]
        lines.append(f"| {k:.0e} | " + " | ".join(cells) + " |")
    slopes = ", ".join(f"{slope(found, n):.4f} for n = {n:g} (theory {-1 / (n + 1):g})" for n in METHODS)
    lines += ["", f"Slope of the strobe's distance: {slopes}.", ""]
    lines += ["| n | method | steps | error of the exit speed | of its derivative |", "| --- | --- | --- | --- | --- |"]
    lines += [f"| {w.n:g} | {w.method} | {w.steps} | {w.speed:.0e} | {w.derivative:.0e} |" for w in ways]
    return "\n".join(lines) + "\n"


def draw(found: list[Resolved], ways: list[Through]) -> Figure:
    """Return the picture: distance over stiffness with the slopes of theory; errors over steps."""
    figure = Figure(figsize=(1.2 * WIDTH, 3.5), layout="constrained")
    left, right = figure.subplots(1, 2)
    for colour, n in zip(PALETTE, METHODS, strict=False):
        rows = [r for r in found if r.n == n]
        k = np.array([r.k for r in rows])
        left.loglog(k, [r.strobe for r in rows], "o", color=colour, label=f"n = {n:g}")
        left.loglog(
            k,
            rows[-1].strobe * (k / k[-1]) ** (-1 / (n + 1)),
            color=colour,
            linewidth=0.8,
            label=f"slope −1/(n + 1) = {-1 / (n + 1):g}".replace("-", "−"),
        )
    left.set_xlabel("stiffness k'")
    left.set_title("Drill, period 1: mapped minus resolved contact (strobe)")
    styles = {("rk4", 1.0): "o", ("rk4", 1.5): "s", ("taylor", 1.0): "v", ("dop853", 1.5): "D"}
    for colour, ((method, n), marker) in zip(PALETTE, styles.items(), strict=False):
        rows = [w for w in ways if (w.method, w.n) == (method, n)]
        steps, derivative = [w.steps for w in rows], [max(w.derivative, 1e-16) for w in rows]
        right.loglog(steps, derivative, marker, color=colour, label=f"{method}, n = {n:g}")
    worst = [w for w in ways if (w.method, w.n) == ("rk4", 1.5)]
    right.loglog([w.steps for w in worst], [w.speed for w in worst], ":", color=PALETTE[1], label="rk4, n = 1.5: speed")
    right.set_xlabel("steps through a contact of stiffness 1e8")
    right.set_title("Error of the derivative of the exit speed")
    left.legend()
    right.legend(loc="center right", bbox_to_anchor=(1.0, 0.6))
    return figure
