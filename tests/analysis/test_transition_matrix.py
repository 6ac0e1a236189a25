"""Tangents over a trajectory: against matrix exponentials, closed forms, and two trajectories through impacts."""

import numpy as np
import pytest
from scipy.linalg import expm

import chaosdrill as cd
from chaosdrill.errors import SceneError, SettingsError

METHODS = ("taylor", "dop853", "radau", "rk4")
FIELD = np.array([[-0.1, 1.0, 0.0], [-2.0, -0.3, 0.5], [0.2, 0.0, -0.4]])


@pytest.fixture(scope="module")
def linear():
    rows = [" + ".join(f"({value})*{name}" for value, name in zip(row, "xyz", strict=True)) for row in FIELD]
    return cd.HybridSystem(
        name="linear",
        states="x y z",
        parameters={},
        modes={"on": dict(zip("xyz", rows, strict=True))},
        initial={"x": 1.0, "y": 0.2, "z": -0.3},
    )


@pytest.fixture(scope="module")
def oscillator():
    return cd.build("impact-oscillator")


@pytest.mark.parametrize("method", METHODS)
def test_a_linear_flow_has_its_matrix_exponential(linear, method):
    ds = cd.trajectory(linear, duration=3.0, transient=1.5, tangents=True, method=method)
    bound = 1e-8 if method == "rk4" else 1e-11
    np.testing.assert_allclose(ds["final_tangent"].values.T, expm(3 * FIELD), rtol=0, atol=bound)


def test_any_tangents_are_those_of_the_matrix(linear):
    rows = np.array([[1.0, 2.0, -1.0], [0.0, 1e3, 1e3]])
    ds = cd.trajectory(linear, times=[0.0, 0.7, 2.2], tangents=rows)
    np.testing.assert_array_equal(ds["initial_tangent"].values, rows)
    np.testing.assert_allclose(ds["final_tangent"].values, rows @ expm(2.2 * FIELD).T, rtol=0, atol=1e-8)


LENGTHS = {
    "periods": {"periods": 3, "transient": 2},
    "times": {"times": [5.3, 9.1], "transient": 2},
    "returns": {"periods": 4, "transient": 1, "at": "x < -0.1"},
}


@pytest.mark.parametrize("length", LENGTHS.values(), ids=LENGTHS)
def test_two_trajectories_through_impacts(oscillator, length):
    """Central differences of the state at the end, over the same time from the same phase."""
    ds = cd.trajectory(oscillator, samples=None if "times" in length else 4, tangents=True, **length)
    start, end = (ds["time"].values[0], ds["time"].values[-1])
    if "times" in length:
        start = 2 * float(ds["forcing_period"])
    assert ((ds["event_time"] > start) & (ds["event_time"] < end)).any()
    period, matrix = float(ds["forcing_period"]), ds["final_tangent"].values.T
    begin = cd.trajectory(oscillator, times=[start])["states"].values[0]
    shifted = oscillator if "at" not in length else _from_phase(oscillator, start)
    columns = []
    for k in range(2):
        ends = []
        for sign in (1, -1):
            state = begin + sign * 1e-6 * np.eye(2)[k]
            from_there = shifted.with_initial(**dict(zip(oscillator.state_names, state, strict=True)))
            ends.append(cd.trajectory(from_there, times=[0.0, end - start])["states"].values[-1])
        columns.append((ends[0] - ends[1]) / 2e-6)
    assert period > 0
    np.testing.assert_allclose(matrix, np.array(columns).T, rtol=1e-6, atol=1e-7 * np.abs(matrix).max())


def _from_phase(oscillator, time):
    """The same with its clock set forward, so that a run begins at that phase."""
    shift = {
        mode: {state: rate.subs(oscillator.time, oscillator.time + time) for state, rate in field.items()}
        for mode, field in oscillator.modes.items()
    }
    return cd.HybridSystem(
        name="later",
        states=oscillator.states,
        time=oscillator.time,
        parameters=oscillator.parameters,
        modes=shift,
        transitions=oscillator.transitions,
        period=oscillator.period,
        initial=oscillator.initial,
    )


@pytest.mark.parametrize("method", METHODS)
def test_nothing_of_the_run_depends_on_tangents(oscillator, method):
    plain, followed = (
        cd.trajectory(oscillator, periods=5, samples=3, tangents=tangents, method=method) for tangents in (None, True)
    )
    assert plain.equals(followed.drop_vars(["initial_tangent", "final_tangent", "tangent"]))


def test_over_cycles_the_eigenvalues_are_the_multipliers(oscillator):
    orbit = cd.periodic_orbit(oscillator)
    state = orbit["orbit_state"].sel(iterate=0) if "iterate" in orbit["orbit_state"].dims else orbit["orbit_state"]
    start = {name: float(state.sel(state=name)) for name in oscillator.state_names}
    ds = cd.trajectory(oscillator.with_initial(**start), periods=int(orbit["period"]), tangents=True)
    found = np.linalg.eigvals(ds["final_tangent"].values.T)
    known = orbit["multiplier_real"].values + 1j * orbit["multiplier_imag"].values
    np.testing.assert_allclose(np.sort_complex(found), np.sort_complex(known), rtol=1e-6)


def test_a_run_that_ends_early_has_none():
    grows = cd.HybridSystem(
        name="grows", states="x", parameters={}, modes={"on": {"x": "x"}}, bounds={"x": (-10, 10)}, initial={"x": 1.0}
    )
    ds = cd.trajectory(grows, duration=5.0, tangents=True)
    assert ds.cd.outcome == "escaped"
    assert np.isnan(ds["final_tangent"].values).all()
    assert cd.trajectory(grows, duration=2.0, tangents=[[3.0]])["final_tangent"].item() == pytest.approx(3 * np.exp(2))


@pytest.mark.parametrize(
    ("tangents", "told"),
    [
        ([[1.0, 0.0], [2.0, 0.0]], "2 rows of rank 1; they must be linearly independent"),
        ([[0.0, 0.0]], "1 rows of rank 0"),
        ([[1.0, 0.0, 0.0]], "rows of 2 finite numbers, one for each state of x, v"),
        ([[1.0, 0.0], [0.0, 1.0], [1.0, 1.0]], "no more than 2"),
        ([[1.0, float("nan")]], "finite"),
        (3, "tangents is 3; it must be True"),
        ("all", "tangents is 'all'"),
    ],
)
def test_tangents_that_cannot_be(oscillator, tangents, told):
    with pytest.raises(SettingsError, match=told):
        cd.trajectory(oscillator, periods=1, tangents=tangents)


@pytest.mark.parametrize("size", [1e-300, 1e-200, 1e200])
def test_the_size_of_a_tangent_does_not_matter(oscillator, size):
    unit = cd.trajectory(oscillator, periods=1, tangents=True)["final_tangent"].values
    found = cd.trajectory(oscillator, periods=1, tangents=[[size, 0.0], [0.0, 1.0]])["final_tangent"].values
    np.testing.assert_allclose(found, unit * [[size], [1.0]], rtol=1e-9)


SCENE = """
[system]
model = "impact-oscillator"
[analysis.motion]
kind = "trajectory"
periods = 2
tangents = {tangents}
"""


def test_a_scene_has_them_and_its_archive_is_verified(oscillator, tmp_path):
    found = cd.run(cd.parse_scene(SCENE.format(tangents="[[0.0, 1.0]]")))
    both = cd.trajectory(oscillator, periods=2, tangents=True)
    np.testing.assert_allclose(found["motion/final_tangent"].values[0], both["final_tangent"].values[1], rtol=1e-9)
    assert cd.verify(cd.save(found, tmp_path / "tangents.nc")).equal
    with pytest.raises(SceneError, match="tangents"):
        cd.parse_scene(SCENE.format(tangents='"all"'))
