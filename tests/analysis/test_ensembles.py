"""Many runs on common times: each is the run of its own, and one that ends early has its outcome."""

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import chaosdrill as cd
from chaosdrill.dataset import described_again
from chaosdrill.errors import SettingsError
from chaosdrill.workflow.compare import examine

STARTS = [[0.0, 0.3], [-0.4, 0.0], [0.1, -0.2]]


@pytest.fixture(scope="module")
def oscillator():
    return cd.build("impact-oscillator")


@pytest.fixture(scope="module")
def grows():
    """x' = x, up to 10."""
    return cd.HybridSystem(
        name="grows",
        states="x",
        parameters={},
        modes={"on": {"x": "x"}},
        quadratures={"area": "x"},
        bounds={"x": (-10, 10)},
        initial={"x": 1.0},
    )


LENGTHS = {
    "periods": {"periods": 4, "transient": 2, "samples": 5},
    "times": {"times": np.array([6.0, 7.7, 9.0, 12.1]), "transient": 2},
}


@pytest.mark.parametrize("length", LENGTHS.values(), ids=LENGTHS)
def test_each_run_is_that_from_its_own_start(oscillator, length):
    ds = cd.trajectory(oscillator, initial=STARTS, tangents=True, **length)
    assert ds["states"].dims == ("run", "time", "state")
    for number, start in enumerate(STARTS, 1):
        own = cd.trajectory(oscillator.with_initial(x=start[0], v=start[1]), tangents=True, **length)
        one = ds.sel(run=number)
        for name in ("time", "states", "mode", "outcome", "final_tangent"):
            np.testing.assert_array_equal(one[name].values, own[name].values, err_msg=name)
        pd.testing.assert_frame_equal(ds.cd.events.loc[number], own.cd.events)
    np.testing.assert_array_equal(ds["initial_state"].values, STARTS)


def test_a_run_that_ends_early_has_its_outcome_and_the_others_go_on(grows):
    times, starts = np.arange(7.0), np.array([0.01, 2.0, 50.0])
    ds = cd.trajectory(grows, times=times, initial=starts)
    found, expected = ds["states"].values[..., 0], starts[:, None] * np.exp(times)
    # a step that leaves the bounds is the last one
    assert np.isfinite(found[expected < 10]).all()
    assert np.isnan(found[1:, -1]).all()
    np.testing.assert_allclose(found, np.where(np.isnan(found), np.nan, expected), rtol=1e-12)
    np.testing.assert_allclose(ds["area"].values[0], 0.01 * np.expm1(times), rtol=1e-11)
    assert ds.cd.outcome.values.tolist() == ["ok", "escaped", "escaped"]
    np.testing.assert_array_equal(ds["mode"].values, np.where(np.isnan(found), -1, 0))
    assert described_again(ds, "trajectory", system=grows) is not None


def test_what_ends_in_the_transient_has_no_states(grows):
    ds = cd.trajectory(grows, duration=1.0, samples=4, transient=1.0, initial=[1.0, 15.0])
    assert np.isnan(ds["states"].values[1]).all()
    np.testing.assert_allclose(ds["states"].values[0, :, 0], np.exp(np.linspace(1, 2, 5)), rtol=1e-12)


def test_it_is_saved_verified_drawn_and_cut(oscillator, tmp_path):
    ds = cd.trajectory(oscillator, initial=STARTS, periods=6, samples=8)
    assert cd.verify(cd.save(ds, tmp_path / "ensemble.nc")).equal
    assert len(cd.plot(ds, state="x").lines) >= 3
    assert cd.plot(ds, "phase-portrait").has_data()
    part = cd.cut(ds, 5.0, 12.0)
    assert part["event_count"].sum() == part.sizes["event"] > 0
    cd.report(tmp_path / "ensemble.nc", tmp_path / "ensemble.html")


def test_runs_of_an_ensemble_are_compared_run_by_run(oscillator):
    """One run of a chaotic ensemble that has an event less does not shift those of the others."""
    ds = cd.trajectory(oscillator, initial=STARTS, periods=6, samples=8)
    last = int(ds["event_count"][0]) - 1
    shorter = ds.drop_isel(event=last).assign(event_count=ds["event_count"] - [1, 0, 0])
    checks = examine(*(xr.DataTree.from_dict({"run": one}) for one in (shorter, ds)), exact=False)[1]
    assert all(check.agrees for check in checks if check.variable != "event_count")


def test_a_scene_has_them(tmp_path):
    scene = """
[system]
model = "impact-oscillator"
[analysis.many]
kind = "trajectory"
times = [0.0, 1.0, 2.0]
initial = [{ x = 0.1 }, { v = 0.2 }]
"""
    found = cd.run(cd.parse_scene(scene))["many"]
    assert found["states"].shape == (2, 3, 2)
    assert found["initial_state"].values[0, 0] == 0.1


def test_points_of_a_section_are_no_common_times(oscillator):
    with pytest.raises(SettingsError, match="at is 'impact'; initial and at exclude each other"):
        cd.trajectory(oscillator, periods=4, at="impact", initial=STARTS)
