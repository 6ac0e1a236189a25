"""Basins at one point, held against random starts that the independent program runs."""

import json

import fixed_step
import numpy as np
import xarray as xr
from branches import FAST, SLOW
from findings import Claim, ended, table

KINDS = ("fast", "slow", "runs away", "no start")


def charted(basins: xr.Dataset) -> np.ndarray:
    """Return which of ``KINDS`` every cell of the archive is, as an index."""
    rate = np.append(np.nan, basins["attractor_rate"].values)[basins["attractor"].values]
    found = np.select(
        [rate > FAST, rate < SLOW, ended(basins, "escaped"), ended(basins, "invalid_start")], range(4), -1
    )
    if (found < 0).any():
        raise ValueError(f"{(found < 0).sum()} cells are on a third attractor, or on none")
    return found


def drawn(basins: xr.Dataset, count: int, seed: int = 1) -> np.ndarray:
    """Return the kind of random starts in the same box, by the independent program, as an index."""
    law = json.loads(basins.attrs["parameters"])
    p = fixed_step.parameters(**law)
    across, up = (basins[name].values for name in ("y", "u"))
    generator = np.random.default_rng(seed)
    found = np.empty(count, dtype=int)
    for i in range(count):
        y, u = generator.uniform(across[0], across[-1]), generator.uniform(up[0], up[-1])
        if y + 2 * law["xi"] * u > 1:
            found[i] = 3
            continue
        rate = fixed_step.run(p, np.array([y, u, 0.0]), 200, 20, 1e-7)[0]
        found[i] = 2 if np.isnan(rate) else int(rate < SLOW)
    return found


def _parts(kinds: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    parts = np.array([(kinds == k).mean() for k in range(len(KINDS))])
    return parts, np.sqrt(parts * (1 - parts) / kinds.size)


def compare(basins: xr.Dataset, count: int = 400) -> tuple[str, list[Claim]]:
    """Return the table of parts of the box, and the claim that both programs agree on them."""
    (ours, error), (theirs, spread) = _parts(charted(basins)), _parts(drawn(basins, count))
    rows = [
        [kind, f"{100 * a:.1f} ± {100 * e:.1f} %", f"{100 * b:.1f} ± {100 * s:.1f} %"]
        for kind, a, e, b, s in zip(KINDS, ours, error, theirs, spread, strict=True)
    ]
    apart = np.abs(ours - theirs) / np.sqrt(ours * (1 - ours) / count)
    claim = Claim(
        f"parts of the box agree with {count} random starts of the independent program",
        f"apart by at most {apart.max():.1f} standard errors",
        bool(apart.max() < 3),
    )
    size = f"{basins.sizes['y']} × {basins.sizes['u']} starts"
    return table(["ends", size, f"{count} random starts, independent program"], rows), [claim]
