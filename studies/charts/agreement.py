"""Points of charts computed again: by the independent program, and by the package's other method."""

import json
from dataclasses import dataclass
from math import pi

import fixed_step
import numpy as np
import xarray as xr
from findings import Claim, table

import chaosdrill as cd
from chaosdrill.dataset.outcomes import flag_names

LENGTHS = {"transient": 300, "periods": 240}
LONGEST = 64
SAME_RATE = 1e-4
"""Largest difference of the progression rates of one cycle found twice."""


@dataclass(frozen=True)
class Point:
    """What one program says of one point.

    Parameters
    ----------
    kind : str
        ``period 2``, ``chaotic``, ``escaped``, ...; ``attracting`` for a cycle that is still being approached.
    rate : float
        Mean progression per unit of time.
    """

    kind: str
    rate: float


Sample = list[tuple[dict[str, float], Point, Point, Point | None]]
"""Points with their parameters, and what the chart, the independent program and ``dop853`` say of them."""


def sample(chart: xr.Dataset, count: int, seed: int) -> list[tuple[int, int]]:
    """Return a number of places of a chart, drawn at random without repetition."""
    shape = chart["attractor_count"].shape
    chosen = np.random.default_rng(seed).choice(int(np.prod(shape)), count, replace=False)
    return [tuple(int(i) for i in np.unravel_index(place, shape)) for place in np.sort(chosen)]


def values(chart: xr.Dataset, place: tuple[int, int]) -> dict[str, float]:
    """Return all parameters of the system at a place of a chart."""
    names = chart["attractor_count"].dims
    swept = {str(name): float(chart[name].values[i]) for name, i in zip(names, place, strict=True)}
    return {**json.loads(chart.attrs["parameters"]), **swept}


def charted(chart: xr.Dataset, place: tuple[int, int]) -> Point:
    """Return what the chart says of a point, from its first seed."""
    point = chart.isel(dict(zip(chart["attractor_count"].dims, place, strict=True))).isel(seed=0)
    kind = flag_names(chart["outcome"])[int(point["outcome"])]
    if kind == "periodic":
        kind = f"period {int(point['period'])}" if int(point["period"]) else "attracting"
    return Point(kind, float(point["progression_rate"]))


def outside(parameters: dict[str, float]) -> Point:
    """Return what the independent program finds, from rest and over the same lengths."""
    p = fixed_step.parameters(**parameters)
    rate, growth, strobes, _ = fixed_step.run(p, np.zeros(3), LENGTHS["transient"], LENGTHS["periods"], 1e-7)
    if np.isnan(rate):
        return Point("escaped", rate)
    period = fixed_step.period_of(strobes, LONGEST)
    if period:
        return Point(f"period {period}", rate)
    grows = growth.mean() * parameters["eta"] / (2 * pi) > 0
    return Point("chaotic" if grows else "attracting", rate)


def other_method(chart: xr.Dataset, place: tuple[int, int]) -> Point:
    """Return what the package finds with method ``dop853``."""
    parameters = values(chart, place)
    system = cd.drill(**parameters)
    names = [str(name) for name in chart["attractor_count"].dims]
    again = cd.parameter_chart(
        system, {n: [parameters[n]] for n in names}, exponents=2, method="dop853", tolerance=1e-10, **LENGTHS
    )
    return charted(again, (0, 0))


def same(first: Point, second: Point) -> bool:
    """Whether two programs found the same motion."""
    if "attracting" in (first.kind, second.kind):
        cycles = all(point.kind.startswith(("period", "attracting")) for point in (first, second))
        return cycles and abs(first.rate - second.rate) <= SAME_RATE
    if first.kind != second.kind:
        return False
    return not first.kind.startswith("period") or abs(first.rate - second.rate) <= SAME_RATE


def compare(chart: xr.Dataset, count: int, seed: int = 1) -> Sample:
    """Return, for a random sample of points, their parameters and what the chart, the independent program and, for
    every third one, ``dop853`` say."""
    found = []
    for number, place in enumerate(sample(chart, count, seed)):
        other = other_method(chart, place) if number % 3 == 0 else None
        found.append((values(chart, place), charted(chart, place), outside(values(chart, place)), other))
    return found


def tables(again: dict[str, Sample]) -> str:
    """Return the table of the page: how many points agree, and those that do not."""
    rows, apart = [], []
    for name, points in again.items():
        for program, column in (("independent, fixed steps", 2), ("`dop853`", 3)):
            met = [(point[0], point[1], point[column]) for point in points if point[column] is not None]
            agree = [same(first, second) for _, first, second in met]
            cycles = [
                abs(first.rate - second.rate)
                for (_, first, second), equal in zip(met, agree, strict=True)
                if equal and first.kind.startswith("period") and second.kind.startswith("period")
            ]
            rows.append([name, program, str(len(met)), str(sum(agree)), f"{max(cycles):.1g}"])
            for (parameters, first, second), equal in zip(met, agree, strict=True):
                if not equal:
                    place = ", ".join(f"{key} = {parameters[key]:.3f}" for key in ("eta", "a", "b"))
                    apart.append([name, place, first.kind, f"{second.kind} ({program})"])
    head = ["chart", "program", "points", "agree", "rates of cycles differ by at most"]
    return (
        table(head, rows) + "\n" + (table(["chart", "point", "chart says", "the other says"], apart) if apart else "")
    )


def claims(again: dict[str, Sample], least: float = 0.95) -> list[Claim]:
    """Return that nearly all points of every chart agree."""
    found = []
    for name, points in again.items():
        for program, column in (("the independent program", 2), ("dop853", 3)):
            met = [(point[1], point[column]) for point in points if point[column] is not None]
            agree = sum(same(first, second) for first, second in met)
            text = f"{name}: {program} finds the same at {least:.0%} of random points at least"
            found.append(Claim(text, f"{agree} of {len(met)}", agree >= least * len(met)))
    return found
