"""Two simultaneous events

A motion reaches two switches at the same time. The two orders of the events have different tangent maps, and the motion
lies on the boundary between them; the average of both maps belongs to neither. Declared priorities decide which event
acts first, and ties are counted. In the drill, r = 1 and xi = 0 make slip onset and impact the same guard.
"""

import numpy as np
import sympy
from tools import Finding, event_names, listed, tangent_map

import chaosdrill as cd

P, Q = sympy.symbols("p q", real=True)
FIELDS = {"none": (1, 1), "first": (1, 2), "second": (2, 1), "both": (1, 1)}
ORDERS = {(1, 0): [[1.0, 0.0], [0.5, 0.5]], (0, 1): [[0.5, 0.5], [0.0, 1.0]]}


def corner(first: int, second: int) -> "cd.HybridSystem":
    """Two switches that are met together at the origin, with the priorities given."""
    return cd.HybridSystem(
        name="corner",
        states=(P, Q),
        parameters={},
        modes={mode: {P: p, Q: q} for mode, (p, q) in FIELDS.items()},
        transitions=[
            cd.Transition("p-first", "none", "first", guard=P, direction=+1, priority=first),
            cd.Transition("q-first", "none", "second", guard=Q, direction=+1, priority=second),
            cd.Transition("q-last", "first", "both", guard=Q, direction=+1),
            cd.Transition("p-last", "second", "both", guard=P, direction=+1),
        ],
        initial={"mode": "none", P: -1.0, Q: -1.0},
    )


def findings() -> list[Finding]:
    """The tangent map of either order, the count of ties, and the drill with both guards in one."""
    average = np.mean(list(ORDERS.values()), axis=0)
    rows = []
    for priorities, matrix in ORDERS.items():
        _, found, _ = tangent_map(corner(*priorities), 2.0)
        wrong = float(np.abs(average - matrix).max())
        name = f"tangent map, {'p' if priorities[0] else 'q'} first: largest error of an entry"
        rows.append(Finding(name, 0.0, float(np.abs(found - matrix).max()), 1e-12, f"{wrong:g} (average of both)"))
        rows.append(Finding("its entries", listed(np.ravel(matrix)), listed(np.round(found, 12).ravel())))
    spectrum = cd.lyapunov_spectrum(corner(1, 0), duration=2.0)
    rows.append(Finding("ties counted", 1.0, float(spectrum["tie_count"])))
    drill = cd.drill(eta=0.8, xi=0.0, r=1.0)
    names = event_names(cd.trajectory(drill, periods=50))
    rows.append(Finding("drill, r = 1, xi = 0: releases beside hits", 0.0, float(names.count("release"))))
    counted = cd.lyapunov_spectrum(drill, periods=50)
    hits = dict(zip(counted["transition"].values, counted["event_count"].values, strict=True))["strong-hit"]
    rows.append(Finding("its ties, as many as strong hits", float(hits), float(counted["tie_count"])))
    return rows
