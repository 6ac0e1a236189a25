"""Tables of branches, and of cascades: where the period doubles, Feigenbaum's ratio, where the doublings accumulate."""

from pathlib import Path

import numpy as np
from reading import parameter, read, table

FROM_TO = ("branch_start", "branch_end_text")
FEIGENBAUM = 4.669201609
CASCADES = {"drill": ("drill_cascade", "cascade"), "oscillator": ("oscillator_cascade", "cascade")}
EXACT = (
    2.653347727855322934,
    2.715987251438764717,
    2.729117918160518332,
    2.731363816169933822,
    2.731834122234837480,
    2.731935060931647197,
    2.731956708952384684,
)
"""Doublings of the impact oscillator by the exact flow in 45 digits (``tests/support/wall_at_rest_cascade.py``)."""


def ends(out: Path) -> str:
    """Return the table of how each branch of the drill of period 1 and 2 begins and ends."""
    branches = read(out / "branches.nc", "branches")
    rows = [
        [str(i), str(int(branches["branch_period"].values[i])), *(str(branches[n].values[i]) for n in FROM_TO)]
        for i in range(branches.sizes["branch_number"])
    ]
    return table(["branch", "period", "from", "end"], rows)


def tables(out: Path) -> dict[str, str]:
    """Return the tables by name."""
    found = {"ends": ends(out)}
    for name, (scene, group) in CASCADES.items():
        cascade = read(out / f"{scene}.nc", group)
        values, periods = cascade["doubling_value"].values, cascade["doubling_period"].values
        ratios = cascade["feigenbaum_ratio"].values
        head = ["doubling", "η" if parameter(cascade) == "eta" else "ω", "ratio"]
        rows = [
            [f"{k} → {2 * k}", f"{value:.13f}", "" if np.isnan(ratio) else f"{ratio:.5f}"]
            for k, value, ratio in zip(periods, values, ratios, strict=True)
        ]
        limit, error = float(cascade["accumulation"]), float(cascade["accumulation_error"])
        if name == "oscillator":
            head.append("off the exact flow by")
            rows = [[*row, f"{abs(v - e):.0e}"] for row, v, e in zip(rows, values, EXACT, strict=True)]
        rows.append(["limit", f"{limit:.11f} ± {error:.0e}", f"{FEIGENBAUM:.5f}", *[""] * (len(head) - 3)])
        found[f"cascade_{name}"] = table(head, rows)
    return found
