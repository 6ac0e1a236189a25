from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr


@pytest.fixture
def system():
    """What the labels need of a system, without building one."""
    return SimpleNamespace(
        name="ball",
        parameters={"e": 0.8, "omega": 1 / 3},
        start={"mode": "free flight", "x": 0.1},
        quadratures={"path": None},
        labels={"e": "coefficient of restitution", "x": "height", "path": "path travelled"},
        modes={"free flight": {}, "held": {}},
        transitions=(SimpleNamespace(name="hit hard!"),),
    )


@pytest.fixture
def diagram():
    """A raw bifurcation diagram over e with two seeds."""
    grid = ("e", "seed")
    return xr.Dataset(
        {
            "section": ((*grid, "iterate", "state"), np.zeros((3, 2, 4, 1))),
            "period": (grid, np.ones((3, 2), dtype=np.int64)),
            "outcome": (grid, np.full((3, 2), 4, dtype=np.int64)),
        },
        coords={"e": [0.1, 0.2, 0.3], "state": ["x"]},
    )


TUNING = {"sweep": {"e": np.array([0.1, 0.2, 0.3])}, "method": "taylor", "tolerance": 1e-12, "steps": None}


@pytest.fixture
def settings():
    return dict(TUNING)
