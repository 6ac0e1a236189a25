"""The description of an archive tells its groups, its variables and where it came from."""

import json

import netCDF4
import pytest

from chaosdrill.archive import save
from chaosdrill.workflow import info


@pytest.fixture
def described(tree, tmp_path):
    return info(save(tree, tmp_path / "result.nc"))


def test_origin(described, tmp_path):
    assert described["title"] == "made up"
    assert described["wall_time_s"] == 1.5
    assert described["bytes"] == (tmp_path / "result.nc").stat().st_size


def test_groups(described):
    assert list(described["groups"]) == ["/first", "/second"]
    first = described["groups"]["/first"]
    assert (first["kind"], first["system"], first["tolerance"]) == ("bifurcation-diagram", "ball", 1e-12)
    assert first["dimensions"] == {"e": 3, "seed": 1, "iterate": 4, "state": 2, "exponent": 2}
    assert first["outcomes"] == {"chaotic": 3}


def test_variables(described):
    variables = described["groups"]["/second"]["variables"]
    assert variables["section"] == {
        "dimensions": ["e", "seed", "iterate", "state"],
        "dtype": "float64",
        "units": "1",
        "long_name": "state on the section",
    }
    assert variables["state_name"]["dtype"] == "text"


def test_it_is_plain(described):
    assert json.loads(json.dumps(described)) == described


def test_versions_that_cannot_be_read_are_left_out(tree, tmp_path):
    tree.attrs["versions"] = "not JSON"
    for node in tree.subtree:
        node.attrs["versions"] = tree.attrs["versions"]
    assert info(save(tree, tmp_path / "result.nc"))["versions"] == {}


def test_what_was_altered_since_is_named(tree, tmp_path):
    path = save(tree, tmp_path / "result.nc")
    with netCDF4.Dataset(path, "a") as file:
        file["second/period"][2] = 7
        file["second"].settings = "{}"
    groups = info(path)["groups"]
    assert "altered" not in groups["/first"]
    assert groups["/second"]["altered"] == [":", "period"]
