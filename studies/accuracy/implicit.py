"""What an accuracy costs in stiff problems: ``radau`` beside explicit methods of the package and scipy's Radau.

Van der Pol's equation of the test set of Hairer and Wanner, x'' = ((1 - x^2) x' - x)/1e-6 from (2, 0), whose state at
t = 2 is published; and the body of hard case 8 that goes through a contact k x^(3/2), whose exit speed is known and
the derivative of it by the place, by a quadrature. Van der Pol's derivative is judged by what it makes of the flow
direction. All programs carry that derivative along. A time is that of the integration alone, the least of several
interleaved rounds.
"""

import re
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import sympy
from matplotlib.figure import Figure
from scipy.integrate import solve_ivp

import chaosdrill as cd
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run
from chaosdrill.plots.palette import PALETTE
from chaosdrill.plots.style import WIDTH

sys.path.append(str(Path(__file__).resolve().parent.parent / "hard_cases"))
from case_08_stiff_tangents import AFTER, LOAD, SPEED, contact_time, entry, leaving, pressed

STIFF = 1e-6
PUBLISHED = np.array([1.706167732170483, -0.8928097010247975])
"""Hairer and Wanner, test set for stiff problems, VDPOL at t = 2."""

EXPONENT = 1.5
STIFFNESSES = (1e8, 1e12)
TOLERANCES = tuple(10.0**-p for p in range(4, 14))
FEW = (1e-4, 1e-8, 1e-12)
"""Tolerances of methods that take seconds: millions of steps."""

OTHERS = tuple(10.0**-p for p in range(3, 12))
"""Tolerances of scipy, beyond which its steps underflow or its Newton iteration fails."""

LEAST = 1e-16
"""Error that is shown for one of zero."""

LONG, QUICK = 0.02, 10
"""Seconds below which a way is measured this number of times a round."""


@dataclass
class Way:
    """A problem by a program at a tolerance: errors of state and derivative, seconds of the processor."""

    problem: str
    program: str
    tolerance: float
    state: float
    derivative: float
    seconds: float


Measured = tuple[float, float, float]
"""Errors of state and derivative, seconds."""


def _timed(run: Run) -> float:
    run.advance(0)
    begin = time.process_time()
    run.advance(1)
    return time.process_time() - begin


def van_der_pol() -> "cd.HybridSystem":
    """Return the equation of the test set."""
    x, v, stiff = sympy.symbols("x v stiff", real=True)
    return cd.HybridSystem(
        name="van der Pol",
        states=(x, v),
        parameters={"stiff": STIFF},
        modes={"run": {x: v, v: ((1 - x**2) * v - x) / stiff}},
        initial={x: 2.0, v: 0.0},
    )


def rate(y: np.ndarray) -> np.ndarray:
    """Return the right-hand side."""
    x, v = y
    return np.array([v, ((1 - x * x) * v - x) / STIFF])


def _rates(t: float, y: np.ndarray) -> list[float]:
    x, v, a, b = y
    return [v, ((1 - x * x) * v - x) / STIFF, b, ((-2 * x * v - 1) * a + (1 - x * x) * b) / STIFF]


def _slopes(t: float, y: np.ndarray) -> np.ndarray:
    x, v, a, b = y
    block = np.array([[0, 1], [(-2 * x * v - 1) / STIFF, (1 - x * x) / STIFF]])
    cross = np.array([[0, 0], [(-2 * v * a - 2 * x * b) / STIFF, -2 * x * a / STIFF]])
    return np.block([[block, np.zeros((2, 2))], [cross, block]])


def _oscillator(method: str, tolerance: float) -> Measured:
    start = np.array([2.0, 0.0])
    run = Run(_VAN_DER_POL, 2.0, Numerics(method, tolerance), tangents=rate(start)[None], orthonormalise=False)
    seconds = _timed(run)
    return *_judged(run.x, run.vectors[0]), seconds


def _oscillator_of_scipy(tolerance: float) -> Measured:
    start = np.array([2.0, 0.0])
    begin = time.process_time()
    found = solve_ivp(
        _rates,
        (0, 2),
        [*start, *rate(start)],
        method="Radau",
        jac=_slopes,
        rtol=tolerance,
        atol=tolerance,
    )
    seconds = time.process_time() - begin
    return *_judged(found.y[:2, -1], found.y[2:, -1]), seconds


def _judged(state: np.ndarray, tangent: np.ndarray) -> tuple[float, float]:
    right = rate(PUBLISHED)
    return float(np.abs(state - PUBLISHED).max()), float(np.abs(tangent - right).max() / np.abs(right).max())


_VAN_DER_POL = van_der_pol()


def _through(k: float, method: str, tolerance: float) -> Measured:
    later = contact_time(k, EXPONENT) + AFTER
    run = Run(_BODIES[k], later, Numerics(method, tolerance), tangents=np.eye(2)[:1], orthonormalise=False)
    seconds = _timed(run)
    return abs(leaving(run.x) + SPEED), abs(float(run.vectors[0, 1]) - entry(k, EXPONENT)), seconds


def _through_by_scipy(k: float, tolerance: float) -> Measured:
    def field(t: float, y: np.ndarray) -> list[float]:
        depth = max(y[0], 0.0)
        return [y[1], LOAD - k * depth**EXPONENT, y[3], -EXPONENT * k * np.sqrt(depth) * y[2]]

    def slopes(t: float, y: np.ndarray) -> np.ndarray:
        depth = max(y[0], 1e-300)
        steep = -EXPONENT * k * np.sqrt(depth)
        bend = -0.5 * EXPONENT * k / np.sqrt(depth) * y[2]
        return np.array([[0, 1, 0, 0], [steep, 0, 0, 0], [0, 0, 0, 1], [bend, 0, steep, 0]])

    def part(t: float, y: np.ndarray) -> float:
        return float(y[0]) if t > 0 else 1.0

    part.terminal, part.direction = True, -1  # type: ignore[attr-defined]
    duration = contact_time(k, EXPONENT)
    begin = time.process_time()
    found = solve_ivp(
        field,
        (0, 2 * duration),
        [0.0, SPEED, 1.0, 0.0],
        method="Radau",
        jac=slopes,
        events=part,
        rtol=tolerance,
        atol=tolerance * np.array([duration, SPEED, 1.0, 1 / duration]),
    )
    seconds = time.process_time() - begin
    return abs(float(found.y[1, -1]) + SPEED), abs(float(found.y[3, -1]) - entry(k, EXPONENT)), seconds


_BODIES = {k: pressed(k, EXPONENT) for k in STIFFNESSES}

Program = Callable[[float], Measured]


def problems() -> dict[str, dict[str, tuple[Program, tuple[float, ...]]]]:
    """Return problem -> program -> what computes errors at a tolerance, and the tolerances."""
    made: dict[str, dict[str, tuple[Program, tuple[float, ...]]]] = {
        "van der Pol, stiffness 1e6": {
            "radau": (lambda tolerance: _oscillator("radau", tolerance), TOLERANCES),
            "dop853": (lambda tolerance: _oscillator("dop853", tolerance), FEW),
            "taylor": (lambda tolerance: _oscillator("taylor", tolerance), FEW),
            "scipy Radau": (_oscillator_of_scipy, OTHERS[:7]),
        }
    }
    for k in STIFFNESSES:
        made[f"contact, k = {k:.0e}".replace("e+0", "e").replace("e+", "e")] = {
            "radau": (lambda tolerance, k=k: _through(k, "radau", tolerance), TOLERANCES),
            "dop853": (lambda tolerance, k=k: _through(k, "dop853", tolerance), TOLERANCES),
            "scipy Radau": (lambda tolerance, k=k: _through_by_scipy(k, tolerance), OTHERS),
        }
    return made


def compare(rounds: int) -> list[Way]:
    """Return errors and least times of all; what takes long is measured less often."""
    made = problems()
    found = []
    for problem, programs in made.items():
        for program, (run, tolerances) in programs.items():
            run(tolerances[0])
            found += [Way(problem, program, tolerance, *run(tolerance)) for tolerance in tolerances]
    for _ in range(rounds):
        for way in found:
            run = made[way.problem][way.program][0]
            for _ in range(QUICK if way.seconds < LONG else 1):
                way.seconds = min(way.seconds, run(way.tolerance)[-1])
    return found


def at_equal_error(found: list[Way], problem: str, program: str, field: str, error: float) -> float:
    """Return the seconds of the cheapest way of a program below an error; infinite if no way reaches it."""
    ways = [w for w in found if (w.problem, w.program) == (problem, program)]
    return min((w.seconds for w in ways if getattr(w, field) <= error), default=np.inf)


def table(found: list[Way]) -> str:
    """Return the ratios at equal error, and all ways, as Markdown."""
    lines = ["| problem | error | of | " + " | ".join(_PROGRAMS) + " |", "| --- " * (3 + len(_PROGRAMS)) + "|"]
    for problem in dict.fromkeys(w.problem for w in found):
        for error in (1e-4, 1e-6, 1e-8, 1e-10):
            for field in ("state", "derivative"):
                times = [at_equal_error(found, problem, program, field, error) for program in _PROGRAMS]
                shown = [f"{1e3 * t:.3g} ms ({t / times[0]:.2g})" if t < np.inf else "–" for t in times]
                lines.append(f"| {problem} | {error:.0e} | {field} | " + " | ".join(shown) + " |")
    lines += ["", "In brackets: over the time of radau.", ""]
    lines += ["| problem | program | tolerance | state | derivative | ms |", "| --- " * 6 + "|"]
    lines += [
        f"| {w.problem} | {w.program} | {w.tolerance:.0e} | {w.state:.0e} | {w.derivative:.0e} "
        f"| {1e3 * w.seconds:.3g} |"
        for w in found
    ]
    return "\n".join(lines) + "\n"


_PROGRAMS = ("radau", "dop853", "taylor", "scipy Radau")


def draw(found: list[Way]) -> Figure:
    """Return the picture: errors of state and derivative over time, a column a problem."""
    names = list(dict.fromkeys(w.problem for w in found))
    figure = Figure(figsize=(1.5 * WIDTH, 5.5), layout="constrained")
    axes = figure.subplots(2, len(names), sharey="row", sharex="col")
    for row, (field, label) in zip(
        axes, (("state", "error of the state"), ("derivative", "error of the derivative")), strict=True
    ):
        row[0].set_ylabel(label)
        for ax, name in zip(row, names, strict=True):
            for colour, marker, program in zip(PALETTE, "osv^", _PROGRAMS, strict=False):
                ways = [w for w in found if (w.problem, w.program) == (name, program)]
                seconds, errors = [w.seconds for w in ways], [max(getattr(w, field), LEAST) for w in ways]
                if ways:
                    ax.loglog(seconds, errors, marker + "-", color=colour, markersize=4, label=program)
    for ax, name in zip(axes[0], names, strict=True):
        ax.set_title(re.sub(r"\b1e(\d+)", r"$10^{\1}$", name).replace("k =", "$k$ ="))
    for ax in axes[1]:
        ax.set_xlabel("processor time (s)")
    axes[0, 1].legend(*axes[0, 0].get_legend_handles_labels(), loc="center")
    return figure
