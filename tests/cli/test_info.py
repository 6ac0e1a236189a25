"""``info`` tells what is in an archive, for people and for scripts."""

import json

import numpy as np
import pytest
import xarray as xr

from chaosdrill.archive import save


@pytest.fixture
def path(tmp_path):
    spectrum = xr.Dataset(
        {
            "lyapunov_exponent": ("exponent", [0.0151, -np.inf], {"units": "1", "long_name": "Lyapunov exponent"}),
            "outcome": ((), np.int8(3), {"units": "1", "long_name": "outcome"}),
        },
        attrs={"kind": "lyapunov-spectrum", "system": "drill", "method": "taylor", "tolerance": 1e-12},
    )
    root = xr.Dataset(attrs={"title": "A spectrum", "versions": '{"chaosdrill": "0.1.0"}'})
    return save(xr.DataTree.from_dict({"/": root, "spectrum": spectrum}), tmp_path / "a.nc")


def test_text(call, path):
    answer = call("info", path)
    assert answer.code == 0
    lines = [" ".join(line.split()) for line in answer.out.splitlines()]
    assert "title A spectrum" in lines
    assert "versions chaosdrill 0.1.0" in lines
    assert "/spectrum lyapunov-spectrum system drill, method taylor, tolerance 1e-12" in lines
    assert "outcomes chaotic 1" in lines
    assert "lyapunov_exponent(exponent) float64 [1] Lyapunov exponent" in lines


def test_numbers_of_the_root(call, tmp_path):
    mass = xr.Dataset({"si_m1": ((), 250.0, {"units": "kg", "long_name": "mass of the bit"})})
    group = xr.Dataset({"x": ("t", [1.0])}, attrs={"kind": "trajectory"})
    path = save(xr.DataTree.from_dict({"/": mass, "motion": group}), tmp_path / "si.nc")
    assert "si_m1 250.0 [kg] mass of the bit" in [
        " ".join(line.split()) for line in call("info", path).out.splitlines()
    ]
    assert json.loads(call("info", path, "--json").out)["quantities"] == {
        "si_m1": {"value": 250.0, "units": "kg", "long_name": "mass of the bit"}
    }


def test_json(call, path):
    described = json.loads(call("info", path, "--json").out)
    assert described["groups"]["/spectrum"]["dimensions"] == {"exponent": 2}


@pytest.mark.parametrize(
    "versions", [{}, {"versions": '{"chaosdrill": "0.1.0", "numpy": "2.4"}'}], ids=["none", "some"]
)
def test_a_tree_from_python_has_the_versions_of_its_groups(call, tmp_path, versions):
    group = xr.Dataset({"x": ("t", [1.0])}, attrs={"kind": "trajectory", **versions})
    path = save(xr.DataTree.from_dict({"a": group, "b": group}), tmp_path / "a.nc")
    lines = [line.split() for line in call("info", path).out.splitlines() if line.startswith("  versions")]
    assert lines == ([["versions", "chaosdrill", "0.1.0,", "numpy", "2.4"]] if versions else [])


def test_versions_in_which_groups_differ(call, tmp_path):
    groups = {n: xr.Dataset(attrs={"kind": "trajectory", "versions": f'{{"numpy": "2.{n}"}}'}) for n in "45"}
    path = save(xr.DataTree.from_dict(groups), tmp_path / "a.nc")
    assert json.loads(call("info", path, "--json").out)["versions"] == {"numpy": "2.4 and 2.5"}


def test_what_was_altered_of_the_root_has_a_line(call, path):
    import netCDF4

    with netCDF4.Dataset(path, "a") as file:
        file.title = "Another"
    assert "  altered       :  (since the archive was written)" in call("info", path).out.splitlines()
