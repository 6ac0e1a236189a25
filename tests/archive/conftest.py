from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from support.small_scenes import small_scene

from chaosdrill.archive import open as open_archive
from chaosdrill.archive import save
from chaosdrill.dataset import label
from chaosdrill.declared import ANALYSES
from chaosdrill.scene import parse_scene
from chaosdrill.workflow import run

SYSTEM = SimpleNamespace(
    name="ball",
    parameters={"e": 0.8},
    start={"mode": "free", "x": 0.1},
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
        coords={"e": swept, "state": ["x", "v"]},
    )
    return label(ds, "bifurcation-diagram", system=SYSTEM, settings={"sweep": {"e": swept}, "tolerance": 1e-12})


@pytest.fixture
def tree():
    """An archive in memory with two groups."""
    root = xr.Dataset(attrs={"title": "made up", "history": "now", "wall_time_s": 1.5})
    return xr.DataTree.from_dict({"/": root, "first": diagram(), "second": diagram(5)})


@pytest.fixture(scope="session")
def every_kind(tmp_path_factory):
    """An archive with a group of every kind of analysis, of the impact oscillator on a cycle of period 2.

    It is forced and has no equilibria, which have an archive of their own in `tests/equilibrium`.
    """
    # a run that nothing special is asked of needs no lines of its own
    asked = {"equilibria"} | {analysis.kind for analysis in parse_scene(small_scene()).analyses.values()}
    more = [f'[analysis.{kind}]\nkind = "{kind}"\nperiods = 8\n' for kind in ANALYSES if kind not in asked]
    scene = parse_scene(small_scene() + "".join(more), "every_kind.toml")
    return save(run(scene), tmp_path_factory.mktemp("every") / "kind.nc")


@pytest.fixture(scope="session")
def every_group(every_kind):
    """The same in memory, by name."""
    return {name: node.to_dataset() for name, node in open_archive(every_kind).children.items()}
