"""The whole road: one scene in, one labelled archive out, the same again, and pictures of it."""

import json

import netCDF4
import numpy as np
import pytest
import xarray as xr

from chaosdrill.archive import open as open_archive
from chaosdrill.cli import main
from chaosdrill.workflow import compare

SCENE = """\
title = "A short drilling"
[system]
model = "percussive-drill"
[system.effects]
drive = "harmonic"
friction = "stribeck"
rock = "moving"
contact = "hunt-crossley"
[system.parameters]
eta = 0.8
[analysis.motion]
kind = "trajectory"
periods = 3
[analysis.section]
kind = "poincare-section"
transient = 60
periods = 4
[analysis.spectrum]
kind = "lyapunov-spectrum"
transient = 10
periods = 64
[analysis.diagram]
kind = "bifurcation-diagram"
sweep.eta = { start = 0.6, stop = 0.9, num = 5 }
seeds = [{ y = 0.0 }, { y = 0.1, mode = "stick" }]
transient = 10
periods = 16
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Folder with the scene and the archives of two runs, with one worker and with two."""
    folder = tmp_path_factory.mktemp("road")
    (folder / "scene.toml").write_text(SCENE)
    for workers in (1, 2):
        arguments = ["run", str(folder / "scene.toml"), "-o", str(folder / f"{workers}.nc"), "--workers", str(workers)]
        assert main(arguments) == 0
    return folder


def test_a_group_for_each_analysis(folder):
    tree = open_archive(folder / "1.nc")
    assert {name: node.attrs["kind"] for name, node in tree.children.items()} == {
        "motion": "trajectory",
        "section": "poincare-section",
        "spectrum": "lyapunov-spectrum",
        "diagram": "bifurcation-diagram",
    }
    assert tree.attrs["scene"] == SCENE
    assert tree.attrs["title"] == "A short drilling"
    assert tree.attrs["Conventions"] == "CF-1.11, ACDD-1.3"


def test_plain_netcdf_finds_names_and_units(folder):
    with netCDF4.Dataset(folder / "1.nc") as file:
        for group in file.groups.values():
            for name, variable in group.variables.items():
                assert variable.long_name, (group.name, name)
                assert variable.units, (group.name, name)
                if name in group.dimensions:
                    assert "_FillValue" not in variable.ncattrs()


def test_plain_xarray_reads_it(folder):
    with xr.open_datatree(folder / "1.nc") as tree:
        assert dict(tree["diagram"].sizes)["eta"] == 5
        assert dict(tree["diagram"].sizes)["seed"] == 2
        np.testing.assert_allclose(tree["diagram/eta"], np.linspace(0.6, 0.9, 5), rtol=1e-15)


def test_numbers_of_the_paper(folder):
    # strobe point of eta = 0.8 and mean progression, from quadruple precision
    tree = open_archive(folder / "1.nc")
    expected = [0.5117707419326684, 0.2579689590074009, 0.3668787222623992]
    np.testing.assert_allclose(tree["section/section"].values[-1], expected, rtol=1e-8)
    assert int(tree["section/period"]) == 1
    assert float(tree["section/progression_rate"]) == pytest.approx(0.1163908540290498, rel=1e-8)


def test_the_number_of_workers_changes_no_bit(folder):
    assert compare(open_archive(folder / "2.nc"), open_archive(folder / "1.nc")) == []


def test_verify_finds_it_equal(folder, capsys):
    assert main(["verify", str(folder / "1.nc")]) == 0
    assert "equal, bit for bit" in capsys.readouterr().out


def test_verify_says_where_an_altered_archive_differs(folder, capsys, tmp_path):
    altered = tmp_path / "altered.nc"
    altered.write_bytes((folder / "1.nc").read_bytes())
    with netCDF4.Dataset(altered, "a") as file:
        values = file["spectrum/lyapunov_exponent"]
        values[0] = values[0] + 1e-3
    assert main(["verify", str(altered)]) == 1
    rows = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert rows[1] == ["group", "variable", "differing", "max", "|difference|"]
    assert rows[2:] == [["/spectrum", "lyapunov_exponent", "1", "of", "3", "0.001", "values", "differ"]]
    assert main(["verify", "--json", str(altered)]) == 1
    found = json.loads(capsys.readouterr().out)
    assert not found["equal"]
    assert [item["variable"] for item in found["differences"]] == ["lyapunov_exponent"]


def test_an_altered_scene_is_found_by_its_hash(folder, capsys, tmp_path):
    altered = tmp_path / "altered.nc"
    altered.write_bytes((folder / "1.nc").read_bytes())
    with netCDF4.Dataset(altered, "a") as file:
        file.scene = file.scene.replace("periods = 3", "periods = 2")
    assert main(["verify", str(altered)]) == 1
    out = capsys.readouterr().out
    assert ":scene_sha256" in out
    assert "/motion" in out
    assert "/spectrum" not in out


def test_pictures(folder, capsys):
    assert main(["plot", str(folder / "1.nc"), "-o", str(folder / "figure.png")]) == 0
    written = capsys.readouterr().out.splitlines()
    assert len(written) >= 4
    for path in written:
        with open(path, "rb") as file:
            assert file.read(8) == b"\x89PNG\r\n\x1a\n"
