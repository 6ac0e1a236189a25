"""Where the drill runs away, held against what is known from a computation outside of the project."""

import json
from pathlib import Path

import fixed_step
import numpy as np
import xarray as xr
from findings import Claim, ended, read
from limits import running_away

FROM_REST = (0.4725, 0.4988)
"""Between these frequency ratios it runs away from rest at b = 0.7 and xi = 0.06, about."""


def claims(archive: Path) -> list[Claim]:
    """Return what the page says of running away, from the three analyses of the archive."""
    chart, line, starts = (read(archive, group) for group in ("chart", "line", "starts"))
    found = running_away(chart, "four starts")
    away = ended(chart.transpose("eta", "b", "seed", ...), "escaped")
    lowest = [float(chart["b"].values[away[..., seed].any(axis=0)].min()) for seed in (0, 2, 3)]
    found.append(
        Claim(
            "from rest, from y = −1, and from y = −1, u = 2 the lowest b at which it runs away decreases",
            ", ".join(f"{b:.3f}" for b in lowest),
            lowest[0] > lowest[1] > lowest[2],
        )
    )
    eta, lost = line["eta"].values, ended(line, "escaped")[:, 0]
    turns = np.flatnonzero(np.diff(lost.astype(int)))
    first, last = (float(value) for value in (eta[turns[0] + 1], eta[turns[-1]]))
    reaches = all(abs(found - known) < 1e-3 for found, known in zip((first, last), FROM_REST, strict=True))
    found += [
        Claim(
            "from rest at b = 0.7 it runs away between η of about 0.4725 and 0.4988",
            f"{first:.4f} to {last:.4f}, without gaps" if len(turns) == 2 else f"{len(turns)} changes",
            bool(len(turns) == 2 and reaches),
        ),
        Claim(
            "the independent program has the same ends to 0.0001",
            ", ".join(f"{eta[i]:.4f}: {'away' if gone else 'stays'}" for i, gone in _outside(line, turns).items()),
            all(bool(lost[i]) == gone for i, gone in _outside(line, turns).items()),
        ),
    ]
    pushed = ended(chart.sel(b=0.7, method="nearest"), "escaped")[:, -1]
    found.append(
        Claim("from y = −1, u = 2 it does at any η at b = 0.7", f"{pushed.sum()} of {pushed.size}", bool(pushed.all()))
    )
    gone = ended(starts, "escaped")
    found.append(
        Claim(
            "at η = 0.448 it does from most y between 0.001 and 0.05 at rest",
            f"{gone.sum()} of {gone.size}",
            bool(np.mean(gone) > 0.5),
        )
    )
    return found


def _outside(line: xr.Dataset, turns: np.ndarray) -> dict[int, bool]:
    """Whether the independent program runs away at both points of every change along a line, by their index."""
    law = json.loads(line.attrs["parameters"])
    found = {}
    for i in sorted({int(j) for turn in turns for j in (turn, turn + 1)}):
        p = fixed_step.parameters(**{**law, "eta": float(line["eta"][i])})
        found[i] = bool(np.isnan(fixed_step.run(p, np.zeros(3), 2000, 100, 1e-7)[0]))
    return found
