"""What is saved comes back bit for bit, here and in other programs; trajectories are cut and joined."""

import contextlib
import json
import os
import shutil
import subprocess

import netCDF4
import numpy as np
import pandas as pd
import pytest
import xarray as xr

import chaosdrill as cd
from chaosdrill.archive import open as open_archive
from chaosdrill.archive import save
from chaosdrill.archive.digest import altered
from chaosdrill.errors import ArchiveError
from chaosdrill.workflow import compare, info

# What is saved comes back bit for bit, through this package and through plain xarray.


@pytest.fixture
def path(tree, tmp_path):
    return save(tree, tmp_path / "result.nc")


def test_nothing_is_lost(tree, path):
    assert compare(open_archive(path), tree) == []
    again = open_archive(path)
    assert np.isnan(again["first/section"].values[0]).all()
    assert np.isneginf(again["first/lyapunov_exponent"].values[:, 0, 1]).all()
    assert again["first/state"].values.tolist() == ["x", "v"]


def test_an_opened_archive_can_be_saved_again(tree, path, tmp_path):
    assert compare(open_archive(save(open_archive(path), tmp_path / "copy.nc")), tree) == []


def test_plain_xarray_reads_it(tree, path):
    with xr.open_datatree(path, engine="netcdf4") as plain:
        assert list(plain.children) == ["first", "second"]
        xr.testing.assert_equal(plain["second"].to_dataset(), tree["second"].to_dataset())


def test_every_variable_says_what_it_is(path):
    with netCDF4.Dataset(path) as file:
        for group in file.groups.values():
            for name, variable in group.variables.items():
                assert variable.long_name, name
                assert variable.units, name


def test_coordinates_have_no_fill_value(path):
    with netCDF4.Dataset(path) as file:
        assert "_FillValue" not in file["first/e"].ncattrs()


def test_numbers_are_compressed(path):
    with netCDF4.Dataset(path) as file:
        filters = file["second/section"].filters()
    assert filters["zlib"]
    assert filters["shuffle"]


def test_one_dataset_is_an_archive_too(tree, tmp_path):
    path = save(tree["first"].to_dataset(), tmp_path / "one.nc")
    assert open_archive(path).attrs["kind"] == "bifurcation-diagram"


def test_a_group_with_the_name_of_its_variable(tree, tmp_path):
    tree["section"] = tree["first"]
    path = save(tree, tmp_path / "result.nc")
    opened = open_archive(path)
    path.unlink()
    assert compare(opened, tree) == []


def test_the_file_is_free_after_opening(path, tree):
    opened = open_archive(path)
    path.unlink()
    assert compare(opened, tree) == []
    with pytest.raises(ArchiveError, match="No such file"):
        open_archive(path)


# Other programs open archives of every kind and find the same numbers in them.


JSFIVE = """
const {File} = require("jsfive");
const bytes = require("fs").readFileSync(process.argv[1]);
const file = new File(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length), "archive");
const found = {};
for (const group of file.keys)
  for (const name of file.get(group).keys) {
    const data = file.get(group).get(name);
    if (data.dtype !== undefined && data.shape !== undefined && data.shape.every((length) => length > 0))
      found[`${group}/${name}`] = Array.from(data.value, String);
  }
console.log(JSON.stringify(found));
"""
"""A reader in JavaScript alone, which shares no line with the HDF5 library."""


def run(*command):
    return subprocess.run(command, capture_output=True, text=True, check=True, timeout=120).stdout


@pytest.fixture(scope="module")
def stored(every_kind):
    """Values of all variables by group/name; empty ones, and mere dimensions, apart."""
    with netCDF4.Dataset(every_kind) as file:
        file.set_auto_mask(False)
        return {
            f"{group}/{name}": variable[...]
            for group, content in file.groups.items()
            for name, variable in content.variables.items()
            if variable.size
        }


@pytest.mark.skipif(not shutil.which("ncdump"), reason="ncdump is not installed (Debian: netcdf-bin)")
def test_ncdump(every_kind, stored):
    text = run("ncdump", "-n", "archive", str(every_kind))
    assert ':Conventions = "CF-1.11, ACDD-1.3"' in text
    value = float(stored["spectrum/kaplan_yorke_dimension"])
    assert f"kaplan_yorke_dimension = {value:g} ;" in text
    for name in stored:
        assert f" {name.split('/')[1]}" in text, name


@pytest.mark.skipif(not shutil.which("ncks"), reason="ncks is not installed (Debian: nco)")
def test_netcdf_operators(every_kind, stored):
    text = run("ncks", "--json", "-g", "section", "-v", "multiplier_real", str(every_kind))
    read = json.loads(text)["groups"]["section"]["variables"]["multiplier_real"]["data"]
    np.testing.assert_allclose(read, stored["section/multiplier_real"], rtol=1e-6)


@pytest.fixture(scope="module")
def node():
    """Node with the package jsfive."""
    if not shutil.which("node"):
        pytest.skip("node is not installed")
    if subprocess.run(["node", "-e", "require('jsfive')"], capture_output=True, check=False).returncode:
        pytest.skip("jsfive is not installed (npm install jsfive, here or where NODE_PATH says)")
    return "node"


def test_javascript(every_kind, stored, node):
    read = json.loads(run(node, "-e", JSFIVE, str(every_kind)))
    # under this name NetCDF-4 keeps a variable that has the name of a dimension and is not its coordinate
    read |= {name.replace("_nc4_non_coord_", ""): values for name, values in read.items() if "_nc4_non_coord_" in name}
    assert stored.keys() - read.keys() == set()
    for name, values in stored.items():
        values = np.asarray(values).ravel()
        if values.dtype.kind in "OU":
            assert read[name] == values.tolist(), name
        else:
            numbers = [float(text.replace("Infinity", "inf")) for text in read[name]]
            np.testing.assert_array_equal(numbers, values.astype(float), err_msg=name)


# Trajectories are cut and joined with their events.


@pytest.fixture(scope="module")
def runs():
    """Three runs of the impact oscillator, with different numbers of impacts."""
    system = cd.build("impact-oscillator")
    return {f"start {x}": cd.trajectory(system.with_initial(x=x), periods=12, samples=10) for x in (-0.4, 0.0, 0.2)}


@pytest.fixture(scope="module")
def one_run(runs):
    return runs["start 0.0"]


def test_cut_takes_the_events_of_its_times(one_run):
    part = cd.cut(one_run, 5.0, 20.0)
    assert part["time"].values[[0, -1]] == pytest.approx([5.0, 20.0], abs=0.26)
    expected = [time for time in one_run["event_time"].values if 5.0 <= time <= 20.0]
    assert 0 < len(expected) < one_run.sizes["event"]
    assert part["event_time"].values.tolist() == expected
    assert part["event_state_after"].shape == (len(expected), 2)


def test_two_cuts_make_the_whole(one_run):
    middle = 0.5 * (one_run["time"].values[40] + one_run["time"].values[41])
    one, other = cd.cut(one_run, -1.0, middle), cd.cut(one_run, middle, 1e9)
    for name, dim in (("states", "time"), ("event_speed", "event")):
        both = np.concatenate([one[name].values, other[name].values])
        np.testing.assert_array_equal(both, one_run[name].values)
        assert one_run[name].dims[0] == dim


def test_the_history_tells_of_it(one_run):
    before, line = cd.cut(one_run, 5.0, 20.0).attrs["history"].splitlines()
    assert before == one_run.attrs["history"]
    assert line.endswith("cut to times 5.0 to 20.0")


def test_join_keeps_every_event_of_every_run(runs):
    joined = cd.join(runs)
    counts = joined["event_count"].values
    assert len(set(counts.tolist())) > 1
    ends = np.cumsum(counts)
    for (name, own), start, end in zip(runs.items(), ends - counts, ends, strict=True):
        np.testing.assert_array_equal(joined["states"].sel(run=name), own["states"])
        for variable in ("event_time", "event_kind", "event_state_before"):
            np.testing.assert_array_equal(joined[variable].values[start:end], own[variable].values)
    assert joined["event_count"].attrs["sample_dimension"] == "event"


def test_a_join_is_an_archive(runs, tmp_path):
    joined = cd.join(runs)
    path = save(joined, tmp_path / "joined.nc")
    assert compare(open_archive(path), open_archive(save(open_archive(path), tmp_path / "again.nc"))) == []
    with netCDF4.Dataset(path) as file:
        assert file["run"][:].tolist() == list(runs)


@pytest.mark.parametrize(
    ("act", "words"),
    [
        (lambda run: cd.cut(run, 1e6, 2e6), "no sample between"),
        (lambda run: cd.cut(run.drop_vars("event_time"), 0, 1), "without event_time"),
        (lambda run: cd.join({}), "must be a mapping of names to trajectories"),
        (lambda run: cd.join({"a": run, "b": cd.cut(run, 0, 5)}), "b: time differs"),
    ],
)
def test_what_cannot_be_done_is_said(one_run, act, words):
    with pytest.raises(ArchiveError, match=words):
        act(one_run)


def test_plain_xarray_parts_and_merges(every_group, tmp_path):
    """As the page on archives shows."""
    diagram = every_group["diagram"]
    low, high = diagram.sel(omega=slice(0, 3.34)), diagram.sel(omega=slice(3.35, 9))
    both = xr.concat([high, low], "omega", data_vars="minimal", coords="minimal", compat="override").sortby("omega")
    assert both.drop_attrs().identical(diagram.drop_attrs())
    tree = xr.DataTree.from_dict({"here": low, "there": high})
    opened = open_archive(cd.save(tree, tmp_path / "together.nc"))
    assert compare(opened, tree) == []
    assert all("altered" not in group for group in info(tmp_path / "together.nc")["groups"].values())


def test_attributes_come_back_as_they_were(tmp_path):
    run = cd.trajectory(cd.build("impact-oscillator"), periods=3, samples=2)
    again = cd.open(cd.save(run, tmp_path / "run.nc")).to_dataset()
    for name, variable in run.variables.items():
        assert again[name].attrs.keys() == variable.attrs.keys()
        for key, value in variable.attrs.items():
            assert np.shape(again[name].attrs[key]) == np.shape(value), (name, key)
            np.testing.assert_array_equal(again[name].attrs[key], value)


MADE = xr.Dataset({"x": ("t", [1.0, 2.0])}, {"t": ("t", [0.0, 1.0])}, {"kind": "trajectory"})


def with_attribute(**attributes):
    return MADE.assign(x=MADE["x"].assign_attrs(attributes))


@pytest.mark.parametrize(
    "made",
    [
        *(with_attribute(**{name: 2.0}) for name in ("scale_factor", "missing_value", "_FillValue", "_Unsigned")),
        with_attribute(units="days since 2000-01-01"),
        with_attribute(dtype="bool"),
        with_attribute(coordinates="x"),
        MADE.assign_attrs(coordinates="x"),
        *(MADE.assign_attrs(more=value) for value in (b"ab", "a\0b", ["a", "b\0"])),
        *(MADE.rename(x=name) for name in ("e\u0301", "a\0b", " a", "a ", "a\n", "a/b", "..", "é" * 129, 1)),
        xr.DataTree.from_dict({"e\u0301": MADE}),
        *(
            MADE.assign(y=("t", values))
            for values in (
                np.array(["a\0b", "c"]),
                np.array([1, None], object),
                np.array([None, np.nan], object),
                pd.Categorical(["a", "b"]),
            )
        ),
    ],
)
def test_what_would_come_back_otherwise_is_refused(made, tmp_path):
    with pytest.raises(ArchiveError) as caught:
        cd.save(made, tmp_path / "a.nc")
    assert "disk" not in str(caught.value)
    assert os.listdir(tmp_path) == []


# the lowest xarray has no other dates than nanoseconds, and refuses these itself
@pytest.mark.filterwarnings("ignore:Converting non-nanosecond:UserWarning")
def test_dates_that_come_back_as_objects_are_refused(tmp_path):
    dates = np.array(["9999-01-01", "1000-01-01"], "M8[s]")
    with pytest.raises((ArchiveError, pd.errors.OutOfBoundsDatetime)):
        cd.save(MADE.assign(y=("t", dates)), tmp_path / "a.nc")


def test_what_is_saved_comes_back_to_the_last_bit_and_unaltered(tmp_path):
    """Also a number that was packed where it came from, a missing text, and in folders with meanings to libraries."""
    packed = xr.Variable((), 1.23456, {}, {"dtype": "i2", "scale_factor": 0.1})
    made = MADE.assign(packed=packed, text=("t", np.array([np.nan, "a"], object)))
    for folder in ("~", "file:", "a::b"):
        (tmp_path / folder).mkdir()
        with contextlib.chdir(tmp_path):
            again = cd.open(cd.save(made, f"{folder}/a.nc#mode=zarr")).to_dataset()
        assert altered(again) == []
        assert again["packed"] == 1.23456
        assert again["text"].values.tolist() == ["", "a"]
