"""The best rate of penetration along stable orbits of the drill, with the peak force below a bound.

    python studies/procedure/make.py [--docs]        (or: python3 studies/run.py procedure [--docs])

Over frequency ratio and static load, orbits of period 1: curves on which the peak force is held at each bound, the
best of their stable parts, and where these lose stability. Each best orbit is simulated by another method, and the
force of its hits computed from the law of the contact. The table and the picture are written to
``studies/procedure/out/``; ``--docs`` writes the page of the documentation and its picture. The exit code is 0 if
the simulations agree.
"""

import argparse
import csv
import sys
from itertools import product
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from scipy.optimize import brentq

import chaosdrill as cd

HERE = Path(__file__).resolve().parent
OUT = HERE / "out"
DOCS = HERE.parent.parent / "docs"

BOUNDS = (150.0, 200.0, 250.0, 300.0, 350.0)
"""Of the peak force, in units of the largest static friction."""
STARTS = ((0.5, 0.7), (0.8, 0.7), (0.72, 0.77), (0.9, 0.6), (0.9, 0.8))
"""Frequency ratio and load of the attractors from which the curves are looked for: no one of them leads to all."""
BOX = {"eta": (0.4, 1.0), "b": (0.4, 0.9)}
FUNCTIONS = {
    "force": {"of": "hunt_crossley_peak(u - w, lam, n, k*(1 + eps))/(1 + eps)", "at": "impact", "take": "maximum"},
    "rate": {"of": "penetration"},
}
STEP = 0.01
COLOURS = ("#0072B2", "#56B4E9", "#009E73", "#E69F00", "#D55E00")
BORDERS = ("fold", "period_doubling", "neimark_sacker", "grazing")
BESIDE, PERIODS = 1e-6, 200
"""Distance from the orbit at which a simulation begins, and its length."""
AGREES = 1e-4
"""Part by which rate and force of a simulation may differ: it is still on its way to the orbit."""


def drill(**values):
    """The drill of the paper with the damping that reproduces its figures."""
    return cd.drill(friction="stribeck", contact="hunt-crossley", xi=0.06, **values)


def column(curve, name):
    """A function along a curve."""
    return curve["function_value"].sel(function=name).values


def usable(curve):
    """Which points of a curve are stable, or the end of a stable part."""
    stable = curve["stable"].values != 0
    beside = np.r_[stable[1:], False] | np.r_[False, stable[:-1]]
    words = curve["special_kind"].attrs["flag_meanings"].split()
    border = np.zeros(len(stable), dtype=bool)
    for place, kind in zip(curve["special_index"].values, curve["special_kind"].values, strict=True):
        border[place] |= words[int(kind)] in BORDERS
    return stable | (border & beside)


def best_of(curve):
    """The stable orbit with the highest rate on a curve: its place, and what is there."""
    points = np.flatnonzero(usable(curve))
    place = int(points[column(curve, "rate")[points].argmax()])
    texts = [
        str(t) for i, t in zip(curve["special_index"].values, curve["special_text"].values, strict=True) if i == place
    ]
    return place, texts[0] if texts else "a point of the curve"


def contact_peak(speed, lam, stiffness):
    """Peak force of the contact d'' = -k d (1 + lam d') per unit of relative mass, where its exponent is 1.

    With G(v) = v/lam - ln(1 + lam v)/lam^2 the depth d at the speed s obeys k d^2/2 = G(v) - G(s), and the force peaks
    where s = 2 lam (G(v) - G(s)).
    """

    def energy(s):
        return s / lam - np.log1p(lam * s) / lam**2

    s = brentq(lambda s: s - 2 * lam * (energy(speed) - energy(s)), 0.0, speed, xtol=1e-15)
    return np.sqrt(2 * stiffness * (energy(speed) - energy(s))) * (1 + lam * s)


def simulated(curve, place):
    """Rate and peak force of a run by another method that begins beside an orbit."""
    system = at(curve, place)
    system = system.with_initial(y=float(curve["orbit_state"].values[place, 0]) + BESIDE)
    run = cd.trajectory(system, periods=PERIODS, method="dop853")
    names = run["event_kind"].attrs["flag_meanings"].split()
    hits = np.array([names[code].endswith("hit") for code in run["event_kind"].values])
    late = run["event_time"].values > run["time"].values[-1] / 2
    before, p = run["event_state_before"].values[hits & late], system.parameters
    force = contact_peak((before[:, 1] - before[:, 2]).max(), p["lam"], p["k"] * (1 + p["eps"])) / (1 + p["eps"])
    middle = len(run["time"]) // 2
    drilled = run["penetration"].values[-1] - run["penetration"].values[middle]
    return float(drilled / (run["time"].values[-1] - run["time"].values[middle])), float(force)


def computed():
    """Curves of all bounds, the best orbit of each, and what a simulation says of the best of a bound."""
    curves = {bound: [] for bound in BOUNDS}
    for bound, (eta, b) in product(BOUNDS, STARTS):
        add(curves, bound, drill(eta=eta, b=b), "attractor")
    # the best orbit of one force leads to curves of the next that no attractor leads to
    bests = [(bound, curve) for bound, found in curves.items() for curve in found]
    for bound, curve in bests:
        place = BOUNDS.index(bound)
        for other in BOUNDS[max(place - 1, 0) : place] + BOUNDS[place + 1 : place + 2]:
            add(curves, other, at(curve, best_of(curve)[0]), "guess")
    return curves, [row_of(bound, found) for bound, found in curves.items() if found]


def add(curves, bound, system, start):
    """Add the curve with this force to which a start leads, if it has stable orbits and is a new one."""
    wanted = {"levels": {"force": [bound]}, "optima": ["rate"], "follow": "level"}
    curve = cd.continue_orbit(system, BOX, functions=FUNCTIONS, transient=300, step=STEP, start=start, **wanted)
    if usable(curve).any() and not any(same(curve, other) for other in curves[bound]):
        curves[bound].append(curve)


def at(curve, place):
    """The drill on an orbit of a curve."""
    state, modes = curve["orbit_state"].values[place], curve["mode"].attrs["flag_meanings"].split()
    start = dict(zip("yuw", state.tolist(), strict=True))
    system = drill(**{name: float(curve[name][place]) for name in BOX})
    return system.with_initial(**start, mode=modes[int(curve["mode"].values[place])])


def same(curve, other):
    """Whether the best orbits of two curves are one."""
    ends = [[float(one[name][best_of(one)[0]]) for name in BOX] for one in (curve, other)]
    return bool(np.allclose(*ends, atol=1e-6))


def row_of(bound, found):
    """The best orbit with this force, beside a simulation."""
    curve = max(found, key=lambda one: column(one, "rate")[best_of(one)[0]])
    place, kind = best_of(curve)
    stable = curve["stable"].values != 0
    # where stability ends a run would not settle: the stable orbit next to it
    near = [place] if stable[place] else [k for k in (place - 1, place + 1) if 0 <= k < len(stable) and stable[k]]
    rate, force = simulated(curve, near[0])
    row = {
        "bound": bound,
        "eta": float(curve["eta"][place]),
        "b": float(curve["b"][place]),
        "rate": float(column(curve, "rate")[place]),
        "kind": kind,
        "rate_off": abs(rate / float(column(curve, "rate")[near[0]]) - 1),
        "force_off": abs(force / bound - 1),
    }
    print(row, flush=True)
    return row


def picture(curves, rows):
    """Curves in the plane, their stable parts thick, with the best of each; and the best rate over the bound."""
    figure = Figure(figsize=(9.2, 4.2), layout="constrained")
    plane, bests = figure.subplots(1, 2, width_ratios=(1.5, 1))
    for (bound, found), colour in zip(curves.items(), COLOURS, strict=True):
        plane.plot([], [], color=colour, linewidth=2.2, label=f"{bound:g}")
        for curve in found:
            eta, b = (np.where(breaks(curve), np.nan, curve[name].values) for name in BOX)
            plane.plot(eta, b, color=colour, linewidth=0.5, alpha=0.6)
            plane.plot(np.where(curve["stable"].values != 0, eta, np.nan), b, color=colour, linewidth=2.2)
            rate = float(column(curve, "rate")[best_of(curve)[0]])
            bests.plot(bound, rate, "o", color=colour, markersize=5, zorder=3)
    for row in rows:
        plane.plot(row["eta"], row["b"], "*", color="black", markersize=11, zorder=5)
    plane.plot([], [], "*", color="black", markersize=11, linestyle="none", label="highest rate")
    plane.set(xlabel="frequency ratio η", ylabel="static load b")
    plane.legend(title="peak force (thick: stable)", fontsize=7, title_fontsize=7, loc="lower left")
    highest = np.maximum.accumulate([row["rate"] for row in rows])
    bests.step([row["bound"] for row in rows], highest, where="post", color="black", linewidth=1.2, zorder=2)
    bests.plot([], [], "o", color="0.4", markersize=5, label="best stable orbit of a curve")
    bests.plot([], [], color="black", linewidth=1.2, label="highest with no more force")
    bests.set(xlabel="peak force", ylabel="rate of penetration", ylim=(0, None))
    bests.legend(fontsize=8, loc="lower right")
    return figure


def breaks(curve):
    """Points behind which the curve goes on elsewhere."""
    steps = np.hypot(np.diff(curve["eta"].values), np.diff(curve["b"].values))
    return np.r_[steps > 0.05, False]


def page(rows):
    """The page of the documentation."""
    lines = ["| peak force | η | b | rate | where |", "| --- | --- | --- | --- | --- |"]
    for row in rows:
        words = row["kind"].split(":")[0].rstrip(".")
        lines.append(f"| {row['bound']:g} | {row['eta']:.6f} | {row['b']:.6f} | {row['rate']:.6f} | {words} |")
    text = (HERE / "page.md").read_text(encoding="utf-8").replace("TABLE", "\n".join(lines))
    off = max(max(row["rate_off"], row["force_off"]) for row in rows)
    return text.replace("OFF", f"{off:.0e}")


def main(arguments):
    """Compute, draw, and say whether the simulations agree."""
    parser = argparse.ArgumentParser(description="The best rate of penetration with a bound on the peak force.")
    parser.add_argument("--docs", action="store_true", help="write the page of the documentation")
    given = parser.parse_args(arguments)
    curves, rows = computed()
    OUT.mkdir(exist_ok=True)
    with (OUT / "best.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)
    figure = picture(curves, rows)
    figure.savefig(OUT / "best.png", dpi=150)
    if given.docs:
        figure.savefig(DOCS / "_static" / "procedure_best.png", dpi=150)
        (DOCS / "procedure.md").write_text(page(rows), encoding="utf-8")
    return 0 if max(max(row["rate_off"], row["force_off"]) for row in rows) < AGREES else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
