"""Trajectories are cut and joined with their events."""

import netCDF4
import numpy as np
import pytest
import xarray as xr

import chaosdrill as cd
from chaosdrill.archive import open as open_archive
from chaosdrill.archive import save
from chaosdrill.errors import ArchiveError
from chaosdrill.workflow import compare, info


@pytest.fixture(scope="module")
def runs():
    """Three runs of the impact oscillator, with different numbers of impacts."""
    system = cd.build("impact-oscillator")
    return {f"start {x}": cd.trajectory(system.with_initial(x=x), periods=12, samples=10) for x in (-0.4, 0.0, 0.2)}


@pytest.fixture(scope="module")
def run(runs):
    return runs["start 0.0"]


def test_cut_takes_the_events_of_its_times(run):
    part = cd.cut(run, 5.0, 20.0)
    assert part["time"].values[[0, -1]] == pytest.approx([5.0, 20.0], abs=0.26)
    expected = [time for time in run["event_time"].values if 5.0 <= time <= 20.0]
    assert 0 < len(expected) < run.sizes["event"]
    assert part["event_time"].values.tolist() == expected
    assert part["event_state_after"].shape == (len(expected), 2)


def test_two_cuts_make_the_whole(run):
    middle = 0.5 * (run["time"].values[40] + run["time"].values[41])
    one, other = cd.cut(run, -1.0, middle), cd.cut(run, middle, 1e9)
    for name, dim in (("state", "time"), ("event_speed", "event")):
        both = np.concatenate([one[name].values, other[name].values])
        np.testing.assert_array_equal(both, run[name].values)
        assert run[name].dims[0] == dim


def test_the_history_tells_of_it(run):
    before, line = cd.cut(run, 5.0, 20.0).attrs["history"].splitlines()
    assert before == run.attrs["history"]
    assert line.endswith("cut to times 5.0 to 20.0")


def test_join_keeps_every_event_of_every_run(runs):
    joined = cd.join(runs)
    counts = joined["event_count"].values
    assert len(set(counts.tolist())) > 1
    ends = np.cumsum(counts)
    for (name, own), start, end in zip(runs.items(), ends - counts, ends, strict=True):
        np.testing.assert_array_equal(joined["state"].sel(run=name), own["state"])
        for variable in ("event_time", "event_kind", "event_state_before"):
            np.testing.assert_array_equal(joined[variable].values[start:end], own[variable].values)
    assert joined["event_count"].attrs["sample_dimension"] == "event"


def test_a_join_is_an_archive(runs, tmp_path):
    joined = cd.join(runs)
    path = save(joined, tmp_path / "joined.nc")
    assert compare(open_archive(path), open_archive(save(open_archive(path), tmp_path / "again.nc"))) == []
    with netCDF4.Dataset(path) as file:
        assert file["run_name"][:].tolist() == list(runs)


@pytest.mark.parametrize(
    ("act", "words"),
    [
        (lambda run: cd.cut(run, 1e6, 2e6), "no sample between"),
        (lambda run: cd.cut(run.drop_vars("event_time"), 0, 1), "without event_time"),
        (lambda run: cd.join({}), "must be a mapping of names to trajectories"),
        (lambda run: cd.join({"a": run, "b": cd.cut(run, 0, 5)}), "b: time differs"),
    ],
)
def test_what_cannot_be_done_is_said(run, act, words):
    with pytest.raises(ArchiveError, match=words):
        act(run)


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
