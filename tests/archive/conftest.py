from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from chaosdrill.archive import open as open_archive
from chaosdrill.archive import save
from chaosdrill.dataset import label
from chaosdrill.scene import parse_scene

EVERY_KIND = """\
title = "Every kind of archive"
[system]
model = "impact-oscillator"
[system.parameters]
omega = 3.3
[analysis.motion]
kind = "trajectory"
periods = 3
samples = 10
[analysis.section]
kind = "poincare-section"
transient = 100
periods = 8
[analysis.spectrum]
kind = "lyapunov-spectrum"
transient = 50
periods = 128
blocks = 16
[analysis.diagram]
kind = "bifurcation-diagram"
sweep.omega = { start = 3.3, stop = 3.4, num = 4 }
transient = 50
periods = 32
max_period = 8
[analysis.chart]
kind = "parameter-chart"
sweep.omega = { start = 3.3, stop = 3.4, num = 3 }
sweep.e = { start = 0.7, stop = 0.8, num = 2 }
transient = 50
periods = 32
max_period = 8
[analysis.basins]
kind = "basins"
grid.x = { start = -0.3, stop = 0.2, num = 3 }
grid.v = { start = -0.5, stop = 0.5, num = 3 }
transient = 50
periods = 32
max_period = 8
[analysis.orbit]
kind = "periodic-orbit"
start = "search"
max_period = 1
[analysis.branch]
kind = "continuation"
sweep.omega = { start = 3.3, stop = 3.4 }
doublings = 0
transient = 300
[analysis.precision]
kind = "work-precision"
methods = ["taylor", "dop853"]
tolerances = [1e-6, 1e-10]
periods = 20
repeats = 2
"""

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


@pytest.fixture(scope="session")
def every_kind(tmp_path_factory):
    """An archive with a group of every kind of analysis, of the impact oscillator on a cycle of period 2."""
    return save(parse_scene(EVERY_KIND, "every_kind.toml").run(), tmp_path_factory.mktemp("every") / "kind.nc")


@pytest.fixture(scope="session")
def every_group(every_kind):
    """The same in memory, by name."""
    return {name: node.to_dataset() for name, node in open_archive(every_kind).children.items()}
