from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from chaosdrill.dataset import label

SYSTEM = SimpleNamespace(
    name="ball",
    parameters={"e": 0.8},
    initial={"mode": "free", "x": 0.1},
    quadratures={},
    labels={"e": "coefficient of restitution"},
    modes={"free": {}},
    transitions=(),
)


def diagram(points=3):
    """A labelled bifurcation diagram with made-up numbers, some of them missing or infinite."""
    grid = ("e", "seed")
    swept = np.linspace(0.1, 0.3, points)
    section = np.random.default_rng(1).random((points, 1, 4, 2))
    section[0] = np.nan
    exponents = np.full((points, 1, 2), -np.inf)
    exponents[..., 0] = 0.25
    ds = xr.Dataset(
        {
            "section": ((*grid, "iterate", "state"), section),
            "period": (grid, np.ones((points, 1))),
            "lyapunov_exponent": ((*grid, "exponent"), exponents),
            "outcome": (grid, np.full((points, 1), 3)),
        },
        coords={"e": swept, "state_name": ("state", ["x", "v"])},
    )
    return label(ds, "bifurcation-diagram", system=SYSTEM, settings={"sweep": {"e": swept}, "tolerance": 1e-12})


@pytest.fixture
def tree():
    """An archive in memory with two groups."""
    root = xr.Dataset(attrs={"title": "made up", "history": "now", "wall_time_s": 1.5})
    return xr.DataTree.from_dict({"/": root, "first": diagram(), "second": diagram(5)})
