"""How event times that come late move the exponents, and what each digit of the Taylor method costs."""

import math
from dataclasses import dataclass
from statistics import median

import numpy as np
from matplotlib.figure import Figure
from paper_method import CHAOS, LARGEST, MULTIPLIERS
from programs import Own, strobe_error, timed

import chaosdrill as cd
from chaosdrill.plots.palette import PALETTE
from chaosdrill.plots.style import WIDTH

BISECTIONS = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8)
CHAOTIC_BISECTIONS = (1e-2, 1e-3, 1e-4, 1e-6)
TOLERANCES = tuple(10.0**-k for k in range(4, 15))
CYCLE = 0.63


@dataclass(frozen=True)
class Late:
    """Errors at one tolerance of event times: of a cycle's exponent, and the exponent in chaos with its own error."""

    bisection: float
    cycle: float
    chaos: tuple[float, float] | None


@dataclass(frozen=True)
class Cost:
    """One tolerance: errors of strobe point and multiplier of the cycle, microseconds a period with two tangents."""

    tolerance: float
    strobe: float
    multiplier: float
    time: float


def late_events(steps: int = 1000, periods: int = 10_000) -> list[Late]:
    """Return what bisections of event times do to exponents, at steps so fine that nothing else does."""
    exact = math.log(abs(MULTIPLIERS[CYCLE])) / (4 * 2 * math.pi / CYCLE)
    found = []
    for bisection in BISECTIONS:
        cycle, _ = _largest(CYCLE, bisection, steps, 2000)
        chaos = _largest(CHAOS, bisection, steps, periods) if bisection in CHAOTIC_BISECTIONS else None
        found.append(Late(bisection, abs(cycle - exact), chaos))
    return found


def _largest(eta: float, bisection: float, steps: int, periods: int) -> tuple[float, float]:
    """Largest exponent and its standard error; over whole cycles of period 4 it is that of the multiplier."""
    spectrum = cd.lyapunov_spectrum(
        cd.drill(eta=eta), periods=periods, transient=400, exponents=1, method="rk4", steps=steps, tolerance=bisection
    )
    return float(spectrum["lyapunov_exponent"][0]), float(spectrum["lyapunov_error"][0])


def cost(rounds: int = 5, periods: int = 8000) -> list[Cost]:
    """Return error and time of the Taylor method over its tolerance, in interleaved rounds."""
    runs = [Own(CYCLE, tolerance, 2) for tolerance in TOLERANCES]
    for run in runs:
        run.advance(400)
    times = [[timed(run, periods) for run in runs] for _ in range(rounds)]
    found = []
    for tolerance, run, row in zip(TOLERANCES, runs, zip(*times, strict=True), strict=True):
        section = cd.poincare_section(cd.drill(eta=CYCLE), periods=64, transient=400, tolerance=tolerance)
        multiplier = abs(float(section["multiplier_real"][0]) - MULTIPLIERS[CYCLE].real)
        found.append(Cost(tolerance, strobe_error(CYCLE, run.strobe()), multiplier, median(row)))
    return found


def table(late: list[Late], cost: list[Cost]) -> str:
    """Return both measurements as Markdown."""
    lines = ["| event times within | error of λ₁, cycle at η 0.63 | λ₁ in chaos (0.01510) |", "| --- | --- | --- |"]
    for row in late:
        chaos = "" if row.chaos is None else f"{row.chaos[0]:.5f} ± {row.chaos[1]:.5f}"
        lines.append(f"| {row.bisection:.0e} | {row.cycle:.0e} | {chaos} |")
    lines += ["", f"| tolerance | error of the strobe, η {CYCLE} | of the multiplier | µs a period, 2 tangents |"]
    lines.append("| --- | --- | --- | --- |")
    lines += [f"| {c.tolerance:.0e} | {c.strobe:.0e} | {c.multiplier:.0e} | {c.time:.3g} |" for c in cost]
    grown = next(c.time for c in cost if c.tolerance < 2e-14) / next(c.time for c in cost if c.tolerance < 2e-6)
    return "\n".join([*lines, "", f"From 1e-6 to 1e-14 the time grows {grown:.2f} times."]) + "\n"


def draw(late: list[Late], cost: list[Cost]) -> Figure:
    """Return the picture: exponents over the error of event times, errors and time over the tolerance."""
    figure = Figure(figsize=(1.3 * WIDTH, 3.3), layout="constrained")
    left, middle, right = figure.subplots(1, 3)
    bisections = np.array([row.bisection for row in late])
    left.loglog(bisections, [row.cycle for row in late], "o-", color=PALETTE[0], label="cycle, η 0.63")
    chaos = [(row.bisection, *row.chaos) for row in late if row.chaos is not None]
    at, values, errors = (np.array(column) for column in zip(*chaos, strict=True))
    off = np.abs(values - LARGEST)
    seen = off > 2 * errors
    left.errorbar(at[seen], off[seen], yerr=errors[seen], fmt="s", color=PALETTE[1], label="chaos, η 0.448")
    bound = 2 * errors[~seen]
    left.errorbar(at[~seen], bound, yerr=bound / 2, fmt="_", uplims=True, color=PALETTE[1], label="below its 2σ")
    left.loglog(bisections, bisections, color="0.6", linestyle="--", label="slope 1")
    left.set_xlabel("error of event times")
    left.set_title("Error of the largest exponent")
    tolerances = [c.tolerance for c in cost]
    middle.loglog(tolerances, [c.strobe for c in cost], "o-", color=PALETTE[0], label="strobe point")
    middle.loglog(tolerances, [c.multiplier for c in cost], "s-", color=PALETTE[1], label="multiplier")
    middle.loglog(tolerances, tolerances, color="0.6", linestyle="--", label="slope 1")
    middle.set_xlabel("tolerance")
    middle.set_title(f"Errors of the cycle at η {CYCLE}")
    right.semilogx(tolerances, [c.time for c in cost], "o-", color=PALETTE[0])
    right.set_ylim(0, None)
    right.set_xlabel("tolerance")
    right.set_title("µs per period, two tangents")
    for axes in (left, middle):
        axes.legend()
    for axes in (middle, right):
        axes.invert_xaxis()
    return figure
