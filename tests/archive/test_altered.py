"""An archive in which any single value was altered does not verify, and the variable is named."""

import sys
from hashlib import sha256

import netCDF4
import numpy as np
import pytest
import xarray as xr

from chaosdrill.archive import save
from chaosdrill.archive.digest import altered
from chaosdrill.reports import report
from chaosdrill.workflow import info, verify


@pytest.fixture
def verified(every_kind, monkeypatch, tmp_path):
    """Verify a copy of the archive that was altered; the run that it is compared with is not made anew each time."""
    from chaosdrill.archive import open as open_archive

    again = open_archive(every_kind)
    monkeypatch.setattr(sys.modules["chaosdrill.workflow.verify"], "compute", lambda *args, **keywords: again)

    def check(alter):
        copy = tmp_path / "altered.nc"
        copy.write_bytes(every_kind.read_bytes())
        with netCDF4.Dataset(copy, "a") as file:
            alter(file)
        return verify(copy)

    return check


def test_unaltered(every_kind):
    result = verify(every_kind)
    assert result.equal, result.table()
    assert result.exact
    assert {check.how for check in result.checks} == {
        "bit for bit",
        "by the checksum of its values alone: measured time",
    }


def other(value, rng):
    """Another value, as near as can be for numbers."""
    if isinstance(value, str):
        return value + "x"
    if np.asarray(value).dtype.kind in "iu":
        return value + 1 if value < 100 else value - 1
    if np.isfinite(value):
        return np.nextafter(value, rng.choice([-np.inf, np.inf]))
    return 0.0


def test_any_value_of_any_variable(every_kind, verified):
    rng = np.random.default_rng(6)
    changed = []
    with netCDF4.Dataset(every_kind) as file:
        places = [
            (group, name, tuple(int(rng.integers(n)) for n in variable.shape))
            for group, content in file.groups.items()
            for name, variable in content.variables.items()
            if variable.size
        ]

    def alter_all(file):
        for group, name, index in places:
            variable = file[group][name]
            variable.set_auto_mask(False)
            variable[index] = other(variable[index], rng)
            changed.append((f"/{group}", name))

    result = verified(alter_all)
    assert len(changed) > 150
    named = {(item.group, item.variable) for item in result.differences}
    # texts along a dimension have another name in the file
    along = {"/precision": {"method_name": "method", "quantity_name": "quantity"}}
    assert {(group, along.get(group, {}).get(name, name)) for group, name in changed} - named == set()


@pytest.mark.parametrize(
    "name", ["motion/state", "orbit/multiplier_real", "precision/wall_time", "branch/event_sequence"]
)
def test_only_the_altered_one_is_named(verified, name):
    def alter(file):
        variable = file[name]
        index = (0,) * variable.ndim
        variable[index] = variable[index] + "x" if variable.dtype is str else np.nextafter(variable[index], np.inf)

    (difference,) = verified(alter).differences
    assert f"{difference.group}/{difference.variable}" == f"/{name}"


def test_an_attribute(verified):
    def alter(file):
        file["spectrum"].parameters = file["spectrum"].parameters.replace("3.3", "3.4")

    assert [(d.group, d.variable) for d in verified(alter).differences] == [("/spectrum", ":parameters")]


def test_a_line_of_history_is_no_alteration(verified):
    def alter(file):
        file.history = "ncatted ...\n" + file.history

    assert verified(alter).equal


SCENE = 'title = "A ball"\n[system]\nmodel = "impact-oscillator"\n[system.parameters]\ne = 0.9\n'
ROOT = {"scene": SCENE.replace("0.9", "0.8"), "scene_sha256": "0" * 64, "title": "Another", "wall_time_s": 2.5}


@pytest.fixture
def small(tree, tmp_path):
    """An archive with a scene that was never run."""
    tree.attrs |= {"scene": SCENE, "scene_sha256": sha256(SCENE.encode()).hexdigest()}
    return save(tree, tmp_path / "small.nc")


@pytest.mark.parametrize("name", ROOT)
def test_an_attribute_of_the_root_is_told_without_a_run(small, name):
    with netCDF4.Dataset(small, "a") as file:
        file.setncattr(name, ROOT[name])
    assert info(small)["altered"] == ([":", ":scene"] if name.startswith("scene") else [":"])
    page = report(small).path.read_text(encoding="utf-8")
    assert "Altered since the archive was written" in page
    assert "altered since they were written: :" in page
    assert "as they were written, by the digests" not in page


def test_a_number_of_the_root_is_told_without_a_run(tree, tmp_path):
    path = save(tree.assign(si_m1=xr.Variable((), 250.0)), tmp_path / "si.nc")
    with netCDF4.Dataset(path, "a") as file:
        file["si_m1"][...] = 25.0
    assert info(path)["altered"] == ["si_m1"]
    assert "altered since they were written: si_m1" in report(path).path.read_text(encoding="utf-8")


def test_an_archive_without_digests_has_the_digest_of_its_scene():
    root = xr.Dataset(attrs={"scene": "e = 0.8", "scene_sha256": sha256(b"e = 0.9").hexdigest()})
    assert altered(root) == [":scene"]
    assert altered(root.assign_attrs(scene="e = 0.9")) is None


def test_nothing_is_told_of_one_that_was_not(small):
    assert "altered" not in info(small)
    page = report(small).path.read_text(encoding="utf-8")
    assert "Altered" not in page
    assert "as they were written, by the digests" in page
