"""What the archive of the chaotic attractor says: angles between its subspaces, growth over windows, dimension."""

import json
import math

import numpy as np
import xarray as xr
from findings import Claim, table
from fixed_step import parameters, run

SPECTRUM = (0.01510, -0.08792)
"""Exponents per unit of time from 1e8 periods, computed outside of the project."""

SHARES = (0.001, 0.01, 0.1, 0.5)
"""Parts of the time in which the angle is smaller than the table says."""

PARTS = (1000, 10000)
"""Periods after which the smallest angle is told, too."""

STRETCHES = 5
"""Stretches of the record whose smallest angles tell where the angles end."""

SEPARATIONS = (3e-3, 1e-3, 3e-4, 1e-4, 1e-6)
"""Distances of two neighbours whose growth is measured by the independent program, the smallest last."""

BLOCKS, BLOCK = 200, 200
"""Blocks from whose means its error comes, and the periods of each."""


def angles(vectors: xr.Dataset) -> tuple[str, list[Claim]]:
    """Return the table of angles between the expanding and the contracting direction, and what the page says of it."""
    met = vectors["angle"].isel(split=0).values
    smallest = {count: float(np.nanmin(met[:count])) for count in (*PARTS, met.size)}
    quantiles = np.nanquantile(met, SHARES)
    rows = [[f"smallest in {count:,} periods", _angle(value)] for count, value in smallest.items()]
    rows += [[f"{100 * share:g} % of the time below", _angle(q)] for share, q in zip(SHARES, quantiles, strict=True)]
    lost = float(vectors["lost"].isel(vector=2).mean())
    edge, error = edge_of([float(np.nanmin(part)) for part in np.array_split(met, STRETCHES)])
    rows.append([f"edge, by the smallest in {STRETCHES} stretches", f"{edge:.4f} ± {error:.4f}"])
    return table(["angle", "rad"], rows), [
        Claim("the third direction is lost", f"in {100 * lost:g} % of the record", lost == 1),
        Claim(
            "the two others stay apart: no angle below 0.1 rad",
            f"smallest {smallest[met.size]:.4f} rad in {met.size:,} periods",
            smallest[met.size] > 0.1,
        ),
        Claim(
            "their edge is beyond 0.1 rad, too, by three errors",
            f"{edge:.4f} ± {error:.4f} rad",
            edge - 3 * error > 0.1,
        ),
    ]


def edge_of(smallest: list[float]) -> tuple[float, float]:
    """Return where a density ends that vanishes linearly there, from the smallest values of some stretches; its error.

    The smallest of N values is beyond the edge by N^(-1/2) in the mean, and scatters as much. Twice the error holds
    the edge of 93 % of such samples.
    """
    more, scatter = math.sqrt(len(smallest)), float(np.std(smallest, ddof=1))
    edge = (more * min(smallest) - float(np.mean(smallest))) / (more - 1)
    return edge, scatter * math.hypot(1, 1 / more) / (more - 1)


def spectrum(found: xr.Dataset) -> tuple[str, list[Claim]]:
    """Return a line on exponents and the Kaplan–Yorke dimension, and that they are those known from outside."""
    exponent, error = found["lyapunov_exponent"].values[:2], found["lyapunov_error"].values[:2]
    dimension = 1 + exponent[0] / -exponent[1]
    spread = dimension_error(exponent, error)
    apart = np.abs(exponent - SPECTRUM) / np.hypot(error, 1e-5)
    text = (
        f"$\\lambda_1={exponent[0]:.5f}\\pm{error[0]:.5f}$, $\\lambda_2={exponent[1]:.5f}\\pm{error[1]:.5f}$ and "
        f"$\\lambda_3=-\\infty$, so that the Kaplan–Yorke dimension is ${dimension:.4f}\\pm{spread:.4f}$.\n"
    )
    return text, [
        Claim(
            "exponents agree with those of 1e8 periods, computed outside of the project",
            f"apart by {apart.max():.1f} standard errors",
            bool(apart.max() < 3),
        )
    ]


def dimension_error(exponent: np.ndarray, error: np.ndarray) -> float:
    """Return an upper bound of the standard error of 1 + l1/|l2|, whatever the correlation of the two."""
    return float((error[0] + error[1] * exponent[0] / -exponent[1]) / -exponent[1])


def separations(found: xr.Dataset) -> tuple[str, list[Claim]]:
    """Return the growth of finite distances by the independent program, and that it tends to the exponent."""
    law = json.loads(found.attrs["parameters"])
    period = 2 * math.pi / law["eta"]
    rows, growth = [], {}
    for distance in SEPARATIONS:
        _, logs, _, _ = run(parameters(**law), np.zeros(3), 500, BLOCKS * BLOCK, distance)
        means = logs.reshape(BLOCKS, BLOCK).mean(axis=1) / period
        growth[distance] = means.mean()
        error = means.std(ddof=1) / math.sqrt(BLOCKS)
        rows.append([f"{distance:g}", f"{means.mean():.5f} ± {error:.5f}"])
    limit = float(found["lyapunov_exponent"][0])
    apart = abs(growth[SEPARATIONS[-1]] - limit) / math.hypot(error, float(found["lyapunov_error"][0]))
    return table(["distance", "growth per unit of time"], rows), [
        Claim(
            "the growth of small distances, by the independent program, tends to the exponent",
            f"apart by {apart:.1f} standard errors at {SEPARATIONS[-1]:g}",
            apart < 3,
        ),
        Claim(
            "distances of 1e-3 grow faster, by some per cent",
            f"{100 * (growth[1e-3] / growth[SEPARATIONS[-1]] - 1):.1f} %",
            0.02 < growth[1e-3] / growth[SEPARATIONS[-1]] - 1 < 0.12,
        ),
    ]


def dimensions(found: xr.Dataset) -> tuple[str, list[Claim]]:
    """Return the table of generalised dimensions, and that they are no more than exponents from outside allow."""
    rows = [
        [
            f"{int(one['order'])}",
            f"{float(one['dimension']):.3f} ± {float(one['dimension_error']):.3f}",
            f"{float(one['scale_low']):.1e} to {float(one['scale_high']):.1e}",
        ]
        for one in (found.isel(order=place) for place in range(found.sizes["order"]))
    ]
    information, correlation = (found.sel(order=order) for order in (1, 2))
    expected = 1 + SPECTRUM[0] / -SPECTRUM[1]
    apart = abs(float(information["dimension"]) - expected) / float(information["dimension_error"])
    below = expected - float(correlation["dimension"])
    return table(["order", "dimension", "distances, in standard deviations"], rows), [
        Claim(
            "the information dimension agrees with the Kaplan–Yorke dimension",
            f"apart by {apart:.1f} standard errors from {expected:.4f}",
            apart < 2,
        ),
        Claim(
            "the correlation dimension is less",
            f"by {below:.3f}, {below / float(correlation['dimension_error']):.1f} standard errors",
            below > 2 * float(correlation["dimension_error"]),
        ),
    ]


def windows(growth: xr.Dataset) -> tuple[str, list[Claim]]:
    """Return the table of the largest exponent over windows, and how its spread shrinks."""
    cumulants = growth["cumulant"].sel(exponent=1)
    period = float(growth["forcing_period"])
    rows, negative = [], []
    for window in growth["window"].values:
        mean, variance = (float(cumulants.sel(window=window, order=order)) for order in (1, 2))
        below = _below_zero(growth.sel(window=window, exponent=1))
        negative.append(below)
        skewness = float(cumulants.sel(window=window, order=3)) / variance**1.5
        rows.append(
            [
                f"{window / period:.0f}",
                f"{mean:.4f}",
                f"{np.sqrt(variance):.4f}",
                f"{skewness:+.2f}",
                f"{100 * below:.2g} %",
            ]
        )
    spread = [np.sqrt(float(cumulants.sel(window=w, order=2)) * w) for w in growth["window"].values[1:]]
    head = ["periods", "mean", "standard deviation", "skewness", "below zero"]
    return table(head, rows), [
        Claim(
            "growth is negative in a third of single periods, an eighth of stretches of ten, and none of a hundred",
            ", ".join(f"{100 * below:.2g} %" for below in negative),
            0.3 < negative[0] < 0.4 and 0.1 < negative[1] < 0.15 and negative[2] < 1e-3,
        ),
        Claim(
            "from 10 to 100 periods the deviation falls by the root of the length, within a fifth",
            f"{spread[1] / spread[0]:.3f} of it",
            bool(abs(spread[1] / spread[0] - 1) < 0.2),
        ),
    ]


def _below_zero(growth: xr.Dataset) -> float:
    """Part of the windows with a negative exponent; the bin that holds zero counts in proportion."""
    centres, density = growth["bin_centre"].values, growth["histogram"].values
    width = centres[1] - centres[0]
    part = np.clip((0 - (centres - width / 2)) / width, 0, 1)
    return float((part * density * width).sum())


def _angle(value: float) -> str:
    return f"{value:.4f}"
