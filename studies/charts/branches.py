"""Slow and fast drilling at the same parameters: where each branch of the diagram at xi = 0.12 begins and ends.

A branch is known by its progression rate: that of the slow one stays below 0.03, that of the fast one above 0.1. The
independent program follows both, every point from the state in which its neighbour ended, and has to lose them in the
same places.
"""

import json
from dataclasses import dataclass

import fixed_step
import numpy as np
import xarray as xr
from findings import Claim, ended, table

import chaosdrill as cd
from chaosdrill.plots.labels import shorten

SLOW, FAST = 0.03, 0.1
"""Progression rates below and above which a motion belongs to the slow and to the fast branch."""


@dataclass(frozen=True)
class Stretch:
    """Part of the diagram that a motion exists in.

    Parameters
    ----------
    name : str
    first, last : float
        Smallest and largest eta at which some seed is on it.
    at_first, at_last : (float, float)
        Largest exponent and smallest normal speed there.
    """

    name: str
    first: float
    last: float
    at_first: tuple[float, float]
    at_last: tuple[float, float]

    def row(self) -> list[str]:
        """Return the line of the table."""
        ends = (f"{shorten(exponent)}, {shorten(speed)}" for exponent, speed in (self.at_first, self.at_last))
        return [self.name, f"{self.first:.4f}", f"{self.last:.4f}", *ends]


def stretches(diagram: xr.Dataset) -> list[Stretch]:
    """Return where each motion of the diagram exists, from the largest rate down."""
    eta, period = diagram["eta"].values, diagram["period"].values
    rate, sound = diagram["progression_rate"].values, ended(diagram, "periodic")
    fast, slow = sound & (rate > FAST), sound & (rate < SLOW) & (diagram["impacts_per_period"].values > 0)
    masks = {
        "fast, period 1": fast & (period == 1),
        "fast, period 2": fast & (period == 2),
        "slow, period 1, lower": slow & (period == 1) & (eta < 0.48)[:, np.newaxis],
        "slow, period 2": slow & (period == 2) & (eta > 0.44)[:, np.newaxis],
        "slow, period 1, upper": slow & (period == 1) & (eta > 0.48)[:, np.newaxis],
    }
    return [_stretch(diagram, name, mask) for name, mask in masks.items() if mask.any()]


def _stretch(diagram: xr.Dataset, name: str, mask: np.ndarray) -> Stretch:
    eta = diagram["eta"].values
    rows = np.flatnonzero(mask.any(axis=1))
    ends = []
    for row in (rows[0], rows[-1]):
        seed = int(mask[row].argmax())
        point = diagram.isel(eta=row, seed=seed)
        ends.append((float(point["lyapunov_exponent"][0]), float(point["closest_grazing"])))
    return Stretch(name, float(eta[rows[0]]), float(eta[rows[-1]]), *ends)


def follow(parameters: dict[str, float], etas: np.ndarray, start: np.ndarray, transient: int = 400) -> np.ndarray:
    """Return progression rates along ``etas`` by the independent program, each point from the last one's state."""
    rates, state = np.full(len(etas), np.nan), np.asarray(start, dtype=float)
    for i, eta in enumerate(etas):
        p = fixed_step.parameters(**{**parameters, "eta": float(eta)})
        rates[i], _, strobes, _ = fixed_step.run(p, state, transient, 50, 1e-7)
        if np.isnan(rates[i]):
            break
        state = strobes[-1]
    return rates


def lost(diagram: xr.Dataset, step: float, span: float = 0.003) -> tuple[float, float]:
    """Return the last eta at which the independent program is still on the fast branch, going down, and on the slow
    one, going up; it begins on the cycles of the diagram, ``span`` before the diagram loses them."""
    known = {stretch.name: stretch for stretch in stretches(diagram)}
    parameters = json.loads(diagram.attrs["parameters"])
    rate = diagram["progression_rate"].values
    found = []
    for end, way, on in (
        (known["fast, period 1"].first, -1, lambda r: r > FAST),
        (known["slow, period 1, upper"].last, 1, lambda r: r < SLOW),
    ):
        row = int(np.abs(diagram["eta"].values - (end - way * span)).argmin())
        seed = int(on(rate[row]).argmax())
        begin = float(diagram["eta"].values[row])
        etas = begin + way * step * np.arange(int(2 * span / step) + 1)
        rates = follow(parameters, etas, diagram["section"].values[row, seed, -1])
        kept = on(rates)
        found.append(float(etas[kept][-1]))
    return found[0], found[1]


def slow_end(diagram: xr.Dataset, step: float = 2e-6) -> tuple[float, np.ndarray]:
    """Return the last eta of the slow branch in fine steps from the end of the diagram's, and both exponents there."""
    known = {stretch.name: stretch for stretch in stretches(diagram)}
    end = known["slow, period 1, upper"].last
    row = int(np.abs(diagram["eta"].values - end).argmin())
    seed = int((diagram["progression_rate"].values[row] < SLOW).argmax())
    y, u, w = diagram["section"].values[row, seed, -1]
    start = {"y": y, "u": u, "w": w, "mode": "slip" if w > 0 else "stick"}
    system = cd.drill(**json.loads(diagram.attrs["parameters"]), initial=start)
    fine = cd.bifurcation_diagram(
        system,
        {"eta": end + step * np.arange(101)},
        transient=400,
        periods=64,
        max_period=8,
        exponents=2,
        follow="forward",
    )
    last = int(np.flatnonzero(fine["progression_rate"].values[:, 0] < SLOW)[-1])
    return float(fine["eta"][last]), fine["lyapunov_exponent"].values[last, 0]


def tables(diagram: xr.Dataset) -> str:
    """Return the table of the page."""
    head = ["motion", "from η", "to η", "λ₁ and smallest normal speed at the first", "at the last"]
    return table(head, (stretch.row() for stretch in stretches(diagram)))


def claims(diagram: xr.Dataset) -> list[Claim]:
    """Return what the page says of the branches."""
    known = {stretch.name: stretch for stretch in stretches(diagram)}
    fast, slow = known["fast, period 1"], known["slow, period 1, upper"]
    step = float(diagram["eta"][1] - diagram["eta"][0])
    outside = lost(diagram, step)
    rate = diagram["progression_rate"].sel(eta=0.52, method="nearest").values
    directions = [str(name) for name in diagram["seed"].values]
    row = int(np.abs(diagram["eta"].values - 0.52).argmin())
    forward, backward = (diagram["progression_rate"].values[row, directions.index(d)] for d in ("forward", "backward"))
    last, exponents = slow_end(diagram)
    both = (diagram["eta"].values >= fast.first) & (diagram["eta"].values <= slow.last)
    rates = diagram["progression_rate"].values[both]
    times = rates.max(axis=1) / rates.min(axis=1)
    return [
        Claim(
            "ξ = 0.12: followed up and down, η = 0.52 has two motions",
            f"rates {forward:.4f} and {backward:.4f}",
            bool(forward < SLOW and backward > FAST),
        ),
        Claim(
            "ξ = 0.12: the random starts lead to no third one at η = 0.52",
            f"rates {sorted({round(float(r), 4) for r in rate})}",
            len({round(float(r), 4) for r in rate}) == 2,
        ),
        Claim(
            "ξ = 0.12: where both are, the fast one is 6 to 78 times as fast",
            f"{times.min():.1f} to {times.max():.1f}",
            bool(times.min() >= 6 and times.max() <= 78),
        ),
        Claim(
            "the independent program loses the fast branch at the same place",
            f"η = {outside[0]:.4f}, here {fast.first:.4f}",
            abs(outside[0] - fast.first) <= 1.5 * step,
        ),
        Claim(
            "the same for the slow branch",
            f"η = {outside[1]:.4f}, here {slow.last:.4f}",
            abs(outside[1] - slow.last) <= 1.5 * step,
        ),
        Claim(
            "in steps of 2e-6 the slow branch ends in a fold: two equal exponents part, the larger rises to zero",
            f"η = {last:.6f}: {shorten(exponents[0])} and {shorten(exponents[1])}",
            bool(exponents[0] > -0.012 and exponents[1] < -0.05),
        ),
    ]
