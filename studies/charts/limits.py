"""What charts of the drill must show, by two arguments that need no computer.

Standing. While the rock sticks, the bit is a linear oscillator under the load b + a cos(eta t), and the force on the
rock oscillates about b with the amplitude a T(eta), T being the transmissibility of the spring and damper. As long as
b + a T <= 1 it never exceeds static friction: a motion without events exists, its exponents are -xi, twice, and the
drill does not progress. Beyond that line no such motion exists.

Running away. Momentum changes by the load less the friction on the rock. Friction is at most 1, so that nothing holds
b > 1; sliding fast it is mu, which is more than the load where b < mu.
"""

import json

import numpy as np
import xarray as xr
from findings import Claim, ended


def standing_limit(eta: np.ndarray, a: np.ndarray | float, xi: float) -> np.ndarray:
    """Return the largest static load under which the rock can stay where it is."""
    damping = (2 * xi * eta) ** 2
    return 1 - a * np.sqrt((1 + damping) / ((1 - eta**2) ** 2 + damping))


def loads(chart: xr.Dataset) -> tuple[np.ndarray, np.ndarray, float, float]:
    """Return static load and standing limit over the chart's first two dimensions, then xi and mu."""
    law = json.loads(chart.attrs["parameters"])
    grid = {name: chart[name] for name in chart["outcome"].dims if name != "seed"}
    eta, a, b = (grid.get(name, xr.DataArray(law[name])) for name in ("eta", "a", "b"))
    limit = standing_limit(eta, a, law["xi"])
    shape = xr.zeros_like(chart["attractor_count"], dtype=float)
    return (shape + b).values, (shape + limit).values, law["xi"], law["mu"]


def standing(chart: xr.Dataset, name: str) -> list[Claim]:
    """Hold points without events, and points beyond the limit, against the closed form."""
    load, limit, xi, _ = loads(chart)
    still = (chart["events_per_period"].values[..., 0] == 0) & ended(chart, "periodic")[..., 0]
    exponents = chart["lyapunov_exponent"].values[still].reshape(-1, chart.sizes["exponent"])
    off, apart = np.abs(exponents.sum(axis=1) + 2 * xi).max(), np.abs(exponents[:, 0] + xi).max()
    nearest = (limit - load)[still].min()
    return [
        Claim(
            f"{name}: every point without events lies below the standing limit",
            f"{still.sum()} points, the nearest {nearest:.2g} below",
            bool(nearest >= 0),
        ),
        Claim(
            f"{name}: their exponents are −ξ, twice",
            f"their sum is off by at most {off:.1g}, the first by {apart:.1g} (it turns: a finite mean is not exact)",
            bool(off < 1e-11 and apart < 1e-3),
        ),
        Claim(
            f"{name}: they have period 1 and no progression",
            f"periods {sorted(set(chart['period'].values[still].ravel().tolist()))}, "
            f"rate at most {np.abs(chart['progression_rate'].values[still]).max():.1g}",
            bool((chart["period"].values[still] == 1).all() and (chart["progression_rate"].values[still] == 0).all()),
        ),
    ]


def running_away(chart: xr.Dataset, name: str) -> list[Claim]:
    """Hold the points that escape against what momentum allows."""
    load, _, _, mu = loads(chart)
    lost = ended(chart, "escaped")
    load = np.broadcast_to(load[..., np.newaxis], lost.shape)
    claims = [
        Claim(
            f"{name}: none runs away at b ≤ μ",
            f"lowest b that does: {load[lost].min():.3f}",
            bool(load[lost].min() > mu),
        )
    ]
    if (load > 1).any():
        kept = load[~lost].max()
        claims.append(Claim(f"{name}: all run away at b > 1", f"highest b that does not: {kept:.3f}", bool(kept <= 1)))
    return claims
