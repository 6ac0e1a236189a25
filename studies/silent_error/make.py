"""What the exponents of an impact oscillator lose when a program leaves the impacts out of its tangents, silently.

    python studies/silent_error/make.py [--docs]          (or: python3 studies/run.py silent_error)

The exponents with saltation at every impact come from the package. Two checks share no code with its tangents: the
growth of the distance between two trajectories, and the sum of the exponents, which for this system is
``-2 zeta + 2 ln(e) x impacts per unit of time``. Writes an archive, a table and the picture to
``studies/silent_error/out/``; ``--docs`` puts the picture into the documentation, too.
"""

import shutil
import sys
from pathlib import Path

import numpy as np
import sympy
import xarray as xr
from independent import OMEGA, PERIOD, RESTITUTION, WALL, ZETA, events_left_out, two_trajectories
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import chaosdrill as cd
from chaosdrill.analysis.judgement.statistics import standard_error
from chaosdrill.plots.labels import uncertain
from chaosdrill.plots.palette import PALETTE
from chaosdrill.plots.style import WIDTH, style

HERE = Path(__file__).resolve().parent
OUT = HERE / "out"
DOCS = HERE.parent.parent / "docs" / "_static"
PERIODS, TRANSIENT, BLOCKS = 200_000, 1_000, 4_000


def impact_oscillator() -> cd.HybridSystem:
    """Return the oscillator with its wall, as a user writes it down."""
    x, v, t, zeta, omega, e = sympy.symbols("x v t zeta omega e", real=True)
    return cd.HybridSystem(
        name="impact-oscillator",
        states=(x, v),
        time=t,
        parameters={"zeta": ZETA, "omega": OMEGA, "e": RESTITUTION},
        modes={"free": {x: v, v: -x - 2 * zeta * v + sympy.cos(omega * t)}},
        transitions=[
            cd.Transition("impact", source="free", target="free", guard=x - WALL, direction=+1, reset={v: -e * v})
        ],
        period=2 * sympy.pi / omega,
        initial={"mode": "free", x: 0.0, v: 0.3},
        labels={"x": "displacement", "v": "speed"},
    )


def main() -> int:
    """Compute, save, print and draw; return 0 if both cross-checks agree within three standard errors, else 1."""
    system = impact_oscillator()
    say("exponents with saltation")
    spectrum = cd.lyapunov_spectrum(system, periods=PERIODS, transient=TRANSIENT, blocks=BLOCKS)
    section = cd.poincare_section(system, periods=20_000, transient=TRANSIENT)
    OUT.mkdir(exist_ok=True)
    cd.save(xr.DataTree.from_dict({"spectrum": spectrum, "section": section}), OUT / "silent_error.nc")
    say("two trajectories")
    growth, impacts = two_trajectories(PERIODS, TRANSIENT, BLOCKS, 1e-8)
    left_out = events_left_out(PERIODS, BLOCKS)
    table, agree = compare(spectrum, growth, impacts, left_out)
    (OUT / "exponents.md").write_text(table, encoding="utf-8")
    print(table)
    picture = OUT / "silent_error.png"
    with style():
        draw(spectrum, section, growth, sum_rule(impacts), left_out).savefig(picture)
    if "--docs" in sys.argv[1:]:
        shutil.copy(picture, DOCS)
    say(f"picture: {picture}")
    return 0 if agree else 1


def compare(spectrum: xr.Dataset, growth: np.ndarray, impacts: np.ndarray, left_out: np.ndarray) -> tuple[str, bool]:
    """Return the table of both exponents and their sum by every route, and whether the routes with impacts agree."""
    value, error = spectrum["lyapunov_exponent"].values, spectrum["lyapunov_error"].values
    total = sum_rule(impacts)
    rows = {
        "with saltation": [(value[0], error[0]), (value[1], error[1]), (value.sum(), np.nan)],
        "two trajectories": [(growth.mean(), standard_error(growth)), (np.nan, np.nan), (np.nan, np.nan)],
        "sum rule, from counted impacts": [(np.nan, np.nan), (np.nan, np.nan), (total.mean(), standard_error(total))],
        "impacts left out": [*((number, np.nan) for number in left_out[-1]), (left_out[-1].sum(), np.nan)],
    }
    lines = ["| | λ₁ | λ₂ | λ₁ + λ₂ |", "| --- | --- | --- | --- |"]
    for name, cells in rows.items():
        lines.append("| " + " | ".join([name, *("" if np.isnan(a) else uncertain(a, b) for a, b in cells)]) + " |")
    apart = abs(value[0] - growth.mean()) / np.hypot(error[0], standard_error(growth))
    gap = abs(value.sum() - total.mean()) / (np.sqrt(2) * standard_error(total))
    return "\n".join(lines) + "\n", bool(apart < 3 and gap < 3)


def sum_rule(impacts: np.ndarray) -> np.ndarray:
    """Return the sum of both exponents from the impacts per unit of time: damping, and what an impact does to areas."""
    return -2 * ZETA + 2 * np.log(RESTITUTION) * impacts


def draw(
    spectrum: xr.Dataset, section: xr.Dataset, growth: np.ndarray, total: np.ndarray, left_out: np.ndarray
) -> Figure:
    """Return the picture: the running exponents by every route, and the attractor that they belong to."""
    periods = spectrum["block_time"].values / PERIOD
    history = spectrum["lyapunov_history"].values
    two, rest = (np.cumsum(blocks) / np.arange(1, blocks.size + 1) for blocks in (growth, total - growth))
    figure = Figure(figsize=(1.25 * WIDTH, 3.7), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=[1.55, 1])
    left.axhline(0, color="0.6", linewidth=0.8, zorder=0)
    left.semilogx(periods, history[:, 0], color=PALETTE[0])
    left.semilogx(periods, history[:, 1], color=PALETTE[0])
    left.semilogx(periods, two, color="black", linestyle=(0, (4, 3)))
    left.semilogx(periods, rest, color="black", linestyle=(0, (4, 3)))
    left.semilogx(periods, left_out[:, 0], color=PALETTE[1])
    left.semilogx(periods, left_out[:, 1], color=PALETTE[1])
    left.set_xlim(periods[0], periods[-1])
    left.set_ylim(-0.38, 0.16)
    left.text(0.015, 0.0, "chaos above zero", color="0.5", va="bottom", transform=left.get_yaxis_transform())
    left.set_title("Exponents, by three programs")
    left.set_xlabel("length of run (forcing periods)")
    left.set_ylabel("Lyapunov exponents (per unit of time)")
    value, error = spectrum["lyapunov_exponent"].values, spectrum["lyapunov_error"].values
    first, second = (uncertain(value[i], error[i]) for i in (0, 1))
    _say(left, 0.125, f"with the impacts: λ₁ = {first}", PALETTE[0])
    _say(left, 0.055, f"two trajectories, no tangents: {_mean(growth)}", "black")
    _say(left, -0.085, "impacts left out of the tangents: λ₁ = λ₂ = −0.05", PALETTE[1])
    _say(left, -0.285, f"with the impacts: λ₂ = {second}", PALETTE[0])
    _say(left, -0.35, f"sum rule less two trajectories: {_mean(total - growth)}", "black")
    points = section["section"].values
    right.scatter(points[:, 0], points[:, 1], s=0.5, color="black", linewidth=0, rasterized=True)
    right.set_title("The chaotic attractor")
    right.set_xlabel("displacement, once per forcing period")
    right.set_ylabel("speed, once per forcing period")
    return figure


def _mean(blocks: np.ndarray) -> str:
    return uncertain(float(blocks.mean()), float(standard_error(blocks)))


def _say(axes: Axes, height: float, text: str, colour: str) -> None:
    axes.text(0.985, height, text, color=colour, ha="right", va="center", transform=axes.get_yaxis_transform())


def say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
