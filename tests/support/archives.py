"""Archives written by hand, with numbers that the tests can say beforehand."""

import numpy as np
import xarray as xr

from chaosdrill.dataset import Outcome, label
from chaosdrill.scene import parse_scene

SCENE = """\
title = "A hitting oscillator"
[system]
model = "impact-oscillator"
[analysis.diagram]
kind = "bifurcation-diagram"
sweep.omega = { start = 2.0, stop = 3.0, num = 11 }
transient = 100
periods = 8
"""


def diagram(points=11, iterates=8):
    """Over omega: period 2 at x = -1/8 and 1/8 with the exponents -omega and minus infinity; the last point escaped."""
    omega = np.linspace(2.0, 3.0, points)
    section = np.zeros((points, 1, iterates, 2))
    section[..., 0] = np.resize([-0.125, 0.125], iterates)
    section[..., 1] = omega[:, None, None]
    exponents = np.stack([-omega, np.full(points, -np.inf)], axis=-1)[:, None]
    errors = np.full(exponents.shape, 0.0025)
    outcome = np.full((points, 1), Outcome.PERIODIC)
    period = np.full((points, 1), 2)
    section[-1], exponents[-1], period[-1], outcome[-1] = np.nan, np.nan, 0, Outcome.ESCAPED
    grid = ("omega", "seed")
    ds = xr.Dataset(
        {
            "section": ((*grid, "iterate", "state"), section),
            "period": (grid, period),
            "lyapunov_exponent": ((*grid, "exponent"), exponents),
            "lyapunov_error": ((*grid, "exponent"), errors),
            "outcome": (grid, outcome),
        },
        {"omega": omega, "state": ["x", "v"]},
    )
    system = parse_scene(SCENE).system
    return label(ds, "bifurcation-diagram", system=system, settings={"sweep": {"omega": omega}, "tolerance": 1e-12})


def chart(across=4, up=3):
    """Over zeta and omega: the period is the number of the column, from 1, the exponent zeta - 10 omega.

    Four section points are at x = zeta, v = omega, 2 omega, 3 omega, 4 omega.
    """
    zeta, omega = np.linspace(0.1, 0.4, across), np.linspace(1.0, 2.0, up)
    grid = ("zeta", "omega", "seed")
    shape = (across, up, 1)
    exponents = (zeta[:, None] - 10 * omega)[..., None, None]
    section = np.zeros((*shape, 4, 2))
    section[..., 0] = zeta[:, None, None, None]
    section[..., 1] = omega[:, None, None] * np.arange(1, 5)
    ds = xr.Dataset(
        {
            "section": ((*grid, "iterate", "state"), section),
            "period": (grid, np.broadcast_to(np.arange(1, across + 1)[:, None, None], shape)),
            "outcome": (grid, np.full(shape, Outcome.PERIODIC)),
            "lyapunov_exponent": ((*grid, "exponent"), exponents),
            "attractor_count": (grid[:2], np.ones(shape[:2])),
        },
        {"zeta": zeta, "omega": omega, "exponent": [1], "state": ["x", "v"]},
    )
    system = parse_scene(SCENE).system
    return label(ds, "parameter-chart", system=system, settings={"sweep": {"zeta": zeta, "omega": omega}})


def both():
    """An archive in memory with a diagram and a chart."""
    root = {"title": "A hitting oscillator", "scene": SCENE, "scene_name": "hit.toml", "versions": '{"numpy": "2.0"}'}
    return xr.DataTree.from_dict({"/": xr.Dataset(attrs=root), "diagram": diagram(), "chart": chart()})
