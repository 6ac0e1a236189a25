"""Every kind of special point held against simulations that know nothing of branches, and against a closed form."""

from pathlib import Path

import doublings
import numpy as np
import oscillator
import touches
import xarray as xr
from reading import parameter, read, special_points, table

DOUBLINGS = (
    ("drill, period 1", "branches", "branches", (0,)),
    ("drill, period 2", "period_two", "branches", (0,)),
    ("drill, period 4", "drill_cascade", "cascade", (0, 1)),
    ("drill, period 4, upward", "drill_upward", "branches", (0,)),
    ("impact oscillator", "oscillator_cascade", "cascade", (0, 1, 2)),
)
"""Name, scene, group and numbers of the branches whose period doublings are confirmed."""

GRAZINGS = (
    ("drill, period 1", "branches", "branches", (0,)),
    ("drill, period 2", "branches", "branches", (4,)),
    ("drill, period 4", "period_two", "branches", (1,)),
    ("drill, period 8", "drill_upward", "branches", (1,)),
)

RANGE = (0.60, 0.64)
"""Range of eta in which the drill's orbit of period 1 has no period doubling."""


def confirm(out: Path) -> tuple[dict[str, str], bool]:
    """Return the tables by name, and whether all of them agree."""
    doubled = [
        (name, special, doublings.sides(special))
        for name, scene, group, numbers in DOUBLINGS
        for special in special_points(read(out / f"{scene}.nc", group), "period_doubling", numbers)
        if doublings.attracts(special)
    ]
    grazed = [
        (name, special, touches.touch(special))
        for name, scene, group, numbers in GRAZINGS
        for special in special_points(read(out / f"{scene}.nc", group), "grazing", numbers)
    ]
    forms, off = [], []
    for (parameters, _), branches in zip(oscillator.CASES, oscillator.branches(), strict=True):
        for special in special_points(branches, "grazing"):
            name = parameter(special.branches)
            exact = oscillator.closed_form(parameters, name, special.value)
            fixed = next(key for key in parameters if key != name)
            grazed.append((f"impact oscillator, {fixed} {parameters[fixed]}, {name}", special, touches.touch(special)))
            forms.append([fixed, f"{parameters[fixed]}", name, f"{special.value:.14f}", f"{exact:.14f}"])
            off.append(abs(special.value - exact))
    parts = {
        "doublings": doublings.tables(doubled),
        "grazing": touches.tables(grazed),
        "closed_form": table(
            ["fixed", "at", "grazing in", "found", "closed form", "off by"],
            ([*row, f"{error:.0e}"] for row, error in zip(forms, off, strict=True)),
        ),
        "period_one": period_one(read(out / "branches.nc", "branches")),
    }
    agree = all(side.agrees for _, _, found in doubled for side in found)
    agree &= all(found is not None and found.agrees for _, _, found in grazed) and max(off) < touches.CLOSE
    return parts, agree


def period_one(branches: xr.Dataset) -> str:
    """Return the multipliers of the drill's orbit of period 1 where it is asked for period doublings."""
    eta = branches["eta"].values
    points = np.flatnonzero((branches["branch"].values == 0) & (eta >= RANGE[0]) & (eta <= RANGE[1]))
    multipliers = branches["multiplier_real"].values[points]
    chosen = points[np.linspace(0, len(points) - 1, 5).astype(int)]
    rows = [
        [f"{eta[i]:.4f}", *(f"{x:.4f}" for x in branches["multiplier_real"].values[i]), "no"] for i in sorted(chosen)
    ]
    rows.append([f"{len(points)} points", *(f"{x:.4f} to {y:.4f}" for x, y in _extent(multipliers)), "no"])
    if (np.diff(np.sign(multipliers + 1), axis=0) != 0).any():
        rows.append(["a multiplier passes −1", "", "", "", "yes"])
    return table(["η", "multiplier", "", "", "doubles"], rows)


def _extent(values: np.ndarray) -> list[tuple[float, float]]:
    return [(float(column.min()), float(column.max())) for column in values.T]
