"""The paper's regimes, at the points of the charts that are nearest to them."""

import xarray as xr
from agreement import charted
from findings import Claim

KNOWN = {
    0.06: {0.8: "period 1", 0.6: "period 2", 0.63: "period 4", 0.448: "chaotic"},
    0.12: {0.8: "period 1", 0.6: "period 2", 0.63: "period 2", 0.448: "period 1"},
}
"""What is known at b = 0.7 and a = 0.25, for each xi and eta, from a computation outside of the project."""


def claims(charts: dict[float, xr.Dataset]) -> list[Claim]:
    """Hold the charts over (eta, b), by their xi, against the known regimes."""
    found = []
    for xi, chart in charts.items():
        for eta, kind in KNOWN[xi].items():
            near = chart.sel(eta=[eta], b=[0.7], method="nearest")
            point = charted(near, (0, 0))
            place = f"η = {float(near['eta'][0]):g}, b = {float(near['b'][0]):g}"
            found.append(Claim(f"ξ = {xi:g}, η = {eta:g}: {kind}", f"{point.kind} at {place}", point.kind == kind))
    return found
