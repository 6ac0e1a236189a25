"""What a branch with multipliers costs beside the integration of its orbits with tangents.

A round times, one after the other on one core and warm:

    branch     ``continue_orbit`` over the drill's orbit of period 1, 1000 points, everything included
    one by one every orbit of that branch run for one period with its tangents, a run of its own each
    kernel     the engine alone, many periods with tangents at some of these values, per period

and then the cascade of the impact oscillator to period 64.
"""

import time
from collections.abc import Callable
from statistics import median
from typing import Any

import numpy as np
import xarray as xr

import chaosdrill as cd
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run

RANGE = (0.56, 0.9)
POINTS = 1000
COLUMNS = ("round", "points", "branch_s", "one_by_one_s", "kernel_s", "cascade_s")

Row = dict[str, Any]


def measure(rounds: int, say: Callable[[str], None]) -> list[Row]:
    """Rows of single measurements, with the columns ``COLUMNS``."""
    system = cd.drill(drive="harmonic", friction="stribeck", rock="moving", contact="hunt-crossley", eta=0.8, xi=0.06)
    beside = {"x": -0.615, "v": 0.0178}
    oscillator = cd.build("impact-oscillator", {"wall": 0.0, "zeta": 0.0, "e": 0.8, "omega": 2.64}).with_initial(
        **beside
    )
    _branch(system, 50)
    cd.continue_orbit(oscillator, {"omega": (2.6, 2.7)}, doublings=1)
    rows = []
    for i in range(1, rounds + 1):
        say(f"round {i}")
        branch_s, branch = _timed(lambda: _branch(system, POINTS))
        one_by_one_s, _ = _timed(lambda found=branch: _one_by_one(system, found))
        cascade_s, _ = _timed(lambda: cd.continue_orbit(oscillator, {"omega": (2.5, 2.8)}, doublings=6))
        rows.append(
            {
                "round": i,
                "points": branch.sizes["point"],
                "branch_s": branch_s,
                "one_by_one_s": one_by_one_s,
                "kernel_s": _kernel(system, branch) * branch.sizes["point"],
                "cascade_s": cascade_s,
            }
        )
    return rows


def _timed(job: Callable[[], Any]) -> tuple[float, Any]:
    begin = time.process_time()
    result = job()
    return time.process_time() - begin, result


def _branch(system: "cd.HybridSystem", points: int) -> xr.Dataset:
    return cd.continue_orbit(system, {"eta": RANGE}, step=(RANGE[1] - RANGE[0]) / points)


def _one_by_one(system: "cd.HybridSystem", branch: xr.Dataset) -> None:
    numerics = Numerics(tolerance=1e-13)
    for eta, state in zip(branch["eta"].values, branch["orbit_state"].values, strict=True):
        run = _run(system.with_parameters(eta=float(eta)), state, numerics)
        run.advance(1)


def _kernel(
    system: "cd.HybridSystem", branch: xr.Dataset, values: int = 8, turns: int = 10, periods: int = 50
) -> float:
    """Seconds a period of stepping alone, in the mean over some of the orbits; tangents start anew every turn."""
    numerics = Numerics(tolerance=1e-13)
    stable = np.flatnonzero(branch["stable"].values)
    spent = 0.0
    for point in stable[np.linspace(0, len(stable) - 1, values).astype(int)]:
        eta, state = float(branch["eta"].values[point]), branch["orbit_state"].values[point]
        run = _run(system.with_parameters(eta=eta), state, numerics)
        for _ in range(turns):
            run.vectors[:] = np.eye(len(state))
            spent += _timed(lambda here=run: here.advance(periods))[0]
    return spent / (values * turns * periods)


def _run(system: "cd.HybridSystem", state: np.ndarray, numerics: Numerics) -> Run:
    run = Run(system, system.forcing_period(), numerics, tangents=np.eye(len(state)), orthonormalise=False)
    run.x[:] = state
    return run


def table(rows: list[Row]) -> str:
    """Markdown of the medians, and of the medians of ratios within the same round."""
    columns = {name: [float(row[name]) for row in rows] for name in COLUMNS}
    points = median(columns["points"])
    lines = [["", "s", "µs a point", "time of the branch over it"], ["---"] * 4]
    for key, name in (
        ("branch_s", "branch of the drill"),
        ("one_by_one_s", "its orbits one by one"),
        ("kernel_s", "stepping alone"),
    ):
        ratio = median(a / b for a, b in zip(columns["branch_s"], columns[key], strict=True))
        seconds = median(columns[key])
        lines.append(
            [f"{name}, {points:.0f} points", f"{seconds:.3g}", f"{seconds / points * 1e6:.3g}", f"{ratio:.2f}"]
        )
    lines.append(["cascade of the impact oscillator to period 64", f"{median(columns['cascade_s']):.3g}", "", ""])
    return "".join("| " + " | ".join(line) + " |\n" for line in lines)
