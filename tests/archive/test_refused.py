"""What is not the result of an analysis is refused when it is saved, cut or joined, not when it is read."""

import numpy as np
import pytest
import xarray as xr

import chaosdrill as cd
from chaosdrill.errors import ArchiveError


@pytest.fixture(scope="module")
def motion():
    return cd.trajectory(cd.build("impact-oscillator"), periods=3, samples=10)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (None, "expected an xarray.DataTree or an xarray.Dataset, received NoneType None"),
        ([1.0, 2.0], r"received list \[1.0, 2.0\]"),
        (xr.DataArray([1.0]), "received DataArray"),
        (xr.Dataset({"a": ("t", [1.0])}), "holds a, and no result of an analysis"),
        (xr.DataTree.from_dict({"g": xr.Dataset({"b": ("t", [1.0])})}), "holds b, and no result of an analysis"),
        (xr.Dataset(), "holds nothing, and no result"),
    ],
    ids=["None", "list", "array", "dataset", "tree", "empty"],
)
def test_save(given, message, tmp_path):
    with pytest.raises(ArchiveError, match=f"^tree: .*{message}"):
        cd.save(given, tmp_path / "a.nc")
    assert list(tmp_path.iterdir()) == []


def test_other_data_beside_a_result_are_saved(motion, tmp_path):
    tree = xr.DataTree.from_dict({"motion": motion, "mine": xr.Dataset({"a": ("t", [1.0])})})
    assert float(cd.open(cd.save(tree, tmp_path / "a.nc"))["mine/a"][0]) == 1.0


@pytest.mark.parametrize("runs", [None, [], {}, 3, "both"], ids=repr)
def test_join_of_what_names_no_trajectories(runs):
    with pytest.raises(ArchiveError, match=r"^runs is .*; it must be a mapping of names to trajectories"):
        cd.join(runs)


def test_join_of_a_list(motion):
    with pytest.raises(ArchiveError, match=r'^runs is list; .* as in join\(\{"soft": one, "hard": another\}\)'):
        cd.join([motion, motion])


@pytest.mark.parametrize("wrong", [None, "a.nc", np.zeros(3)], ids=["None", "text", "array"])
def test_what_is_no_dataset(motion, wrong):
    with pytest.raises(ArchiveError, match=r"^runs\['b'\] is .*; it must be the xarray.Dataset of a trajectory"):
        cd.join({"a": motion, "b": wrong})
    with pytest.raises(ArchiveError, match=r"^ds is .*; it must be the xarray.Dataset of a trajectory"):
        cd.cut(wrong, 0.0, 1.0)


def test_a_node_of_a_tree_is_answered_with_the_way_to_its_dataset(motion):
    with pytest.raises(ArchiveError, match=r"to_dataset\(\)"):
        cd.cut(xr.DataTree(motion), 0.0, 1.0)


@pytest.mark.parametrize(("start", "stop", "name"), [("a", "b", "start"), (0.0, None, "stop"), (np.nan, 1.0, "start")])
def test_cut_at_what_is_no_time(motion, start, stop, name):
    with pytest.raises(ArchiveError, match=f"^{name} is .*; it must be a number"):
        cd.cut(motion, start, stop)


def test_join_of_what_is_joined_already(motion):
    joined = cd.join({"a": motion, "b": motion})
    with pytest.raises(ArchiveError, match="is already joined; join all runs at once"):
        cd.join({"both": joined, "again": joined})


def test_cut_of_joined_runs_counts_the_events_that_are_left():
    system = cd.build("impact-oscillator")
    runs = {str(x): cd.trajectory(system.with_initial(x=x), periods=12, samples=10) for x in (-0.4, 0.2)}
    both = cd.cut(cd.join(runs), 5.0, 20.0)
    apart = [cd.cut(run, 5.0, 20.0).sizes["event"] for run in runs.values()]
    assert both["event_count"].values.tolist() == apart
    assert sum(apart) == both.sizes["event"] > 0
