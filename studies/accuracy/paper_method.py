"""The paper's method (Runge-Kutta with 200 steps a period, bisection to 1e-6) on its four cases.

How many digits it buys, and at which steps and bisections it shows chaos that is not there or loses chaos that is.
"""

import math
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure
from programs import strobe_error

import chaosdrill as cd
from chaosdrill.plots.palette import PALETTE
from chaosdrill.plots.style import WIDTH

CASES = {0.8: 1, 0.6: 2, 0.63: 4, 0.448: 0}
"""Frequency ratio -> period of the attractor from rest; 0: chaos."""

MULTIPLIERS = {
    0.8: 0.11672896840556 + 0.65713468420972j,
    0.6: -0.26096061533102 + 0.65086241068766j,
    0.63: -0.33278150112798 + 0j,
}
"""First multiplier of each cycle in quadruple precision."""

CHAOS = 0.448
LARGEST = 0.01510
"""Largest exponent in chaos, known to one unit of the last digit."""
STEPS = (20, 50, 100, 200, 500, 1000, 2000)
BISECTIONS = (1e-2, 1e-3, 1e-4, 1e-6, 1e-9, 1e-12)
VERDICTS = ("right", "another period", "no period, no chaos", "chaos that is not there", "chaos lost", "escaped")


@dataclass(frozen=True)
class Setting:
    """A method with its numbers, as the keyword arguments of an analysis."""

    name: str
    arguments: dict[str, object]


def fixed(steps: int, bisection: float) -> Setting:
    """The paper's method with this number of steps a period and this tolerance of event times."""
    return Setting(f"{steps} steps, {bisection:g}", {"method": "rk4", "steps": steps, "tolerance": bisection})


TUNING = (
    fixed(200, 1e-6),
    fixed(200, 1e-12),
    fixed(2000, 1e-6),
    fixed(2000, 1e-12),
    Setting("taylor 1e-6", {"tolerance": 1e-6}),
    Setting("taylor 1e-12", {"tolerance": 1e-12}),
)


@dataclass(frozen=True)
class CycleErrors:
    """Errors of a cycle: of its strobe point, first multiplier and largest exponent; and the period that is seen.

    Where another period is seen than there is, multiplier and exponent are NaN.
    """

    strobe: float
    multiplier: float
    exponent: float
    seen: int

    def cell(self) -> str:
        """Return the table's cell."""
        if math.isnan(self.multiplier):
            return f"{self.strobe:.0e}, period {self.seen} seen"
        return f"{self.strobe:.0e}, {self.multiplier:.0e}, {self.exponent:.0e}"


def errors_of_cycles(setting: Setting) -> list[CycleErrors]:
    """Return the errors of the three cycles of the paper."""
    found = []
    for eta, period in CASES.items():
        if not period:
            continue
        section = cd.poincare_section(cd.drill(eta=eta), periods=64, transient=400, **setting.arguments)
        seen = int(section["period"])
        strobe = min(strobe_error(eta, list(p)) for p in section["section"].values[-period:])
        multiplier, exact = complex(math.nan, math.nan), MULTIPLIERS[eta]
        if seen == period:
            multiplier = complex(section["multiplier_real"][0], abs(section["multiplier_imag"][0]))
        exponent = abs(math.log(abs(multiplier)) - math.log(abs(exact))) / (period * 2 * math.pi / eta)
        found.append(CycleErrors(strobe, abs(multiplier - exact), exponent, seen))
    return found


def exponent_in_chaos(setting: Setting, periods: int) -> tuple[float, float]:
    """Return the largest exponent at eta 0.448 and its standard error."""
    spectrum = cd.lyapunov_spectrum(
        cd.drill(eta=CHAOS), periods=periods, transient=1000, exponents=1, **setting.arguments
    )
    return float(spectrum["lyapunov_exponent"][0]), float(spectrum["lyapunov_error"][0])


def verdicts(setting: Setting, periods: int = 600, transient: int = 600) -> list[int]:
    """Return, for each of the four cases, which of ``VERDICTS`` a run of this setting comes to."""
    diagram = cd.bifurcation_diagram(
        cd.drill(), {"eta": np.array(list(CASES))}, transient=transient, periods=periods, **setting.arguments
    )
    found = []
    for i, period in enumerate(CASES.values()):
        outcome, seen = int(diagram["outcome"][i, 0]), int(diagram["period"][i, 0])
        if outcome == cd.Outcome.ESCAPED:
            found.append(5)
        elif outcome == cd.Outcome.CHAOTIC:
            found.append(3 if period else 0)
        elif period == 0:
            found.append(4)
        elif seen == 0:
            found.append(2)
        else:
            found.append(0 if seen == period else 1)
    return found


def scan() -> np.ndarray:
    """Return the verdicts over steps and bisections, shape (steps, bisections, cases)."""
    return np.array([[verdicts(fixed(n, tolerance)) for tolerance in BISECTIONS] for n in STEPS])


def table(periods: int = 10_000) -> str:
    """Return the errors of all settings as Markdown."""
    head = ["", *(f"η {eta}: point, multiplier, exponent" for eta, p in CASES.items() if p), "η 0.448: λ₁"]
    lines = [head, ["---"] * len(head)]
    for setting in TUNING:
        cells = [errors.cell() for errors in errors_of_cycles(setting)]
        value, error = exponent_in_chaos(setting, periods)
        lines.append([setting.name, *cells, f"{value:.5f} ± {error:.5f}"])
    return "".join("| " + " | ".join(cells) + " |\n" for cells in lines)


def draw(found: np.ndarray) -> Figure:
    """Return the picture of the scan: one panel a case, a square a setting, its colour the verdict."""
    colours = ("#DDE8F0", PALETTE[4], PALETTE[2], PALETTE[1], PALETTE[3], PALETTE[6])
    figure = Figure(figsize=(1.3 * WIDTH, 2.9), layout="constrained")
    panels = figure.subplots(1, len(CASES), sharey=True)
    for axes, (eta, period), verdict in zip(panels, CASES.items(), np.moveaxis(found, 2, 0), strict=True):
        for i in range(len(STEPS)):
            for j in range(len(BISECTIONS)):
                axes.fill_between([i - 0.47, i + 0.47], j - 0.47, j + 0.47, color=colours[verdict[i, j]], linewidth=0)
        paper = STEPS.index(200), BISECTIONS.index(1e-6)
        axes.plot(*paper, marker="o", markersize=5, markerfacecolor="none", markeredgecolor="black")
        axes.set_xticks(range(len(STEPS)), [str(n) for n in STEPS], rotation=60)
        axes.set_yticks(range(len(BISECTIONS)), [f"1e{round(math.log10(b))}" for b in BISECTIONS])
        axes.set_title(f"η = {eta}: " + (f"period {period}" if period else "chaos"))
        axes.set_xlabel("steps per period")
        axes.tick_params(length=0)
        for spine in axes.spines.values():
            spine.set_visible(False)
    panels[0].set_ylabel("bisection")
    shown = [k for k in range(len(VERDICTS)) if np.any(found == k)]
    handles = [panels[0].fill_between([], 0, 0, color=colours[k], label=VERDICTS[k]) for k in shown]
    handles += panels[0].plot([], [], marker="o", linestyle="", markerfacecolor="none", color="black", label="paper")
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles), frameon=False)
    return figure
