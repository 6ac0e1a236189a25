"""Charts: every point has its outcome, and what has no number holds none."""

import pickle
from dataclasses import replace

import numpy as np
import pytest
import sympy
from support.discrete import clocked

import chaosdrill as cd
from chaosdrill.analysis.grids import points, sweeps

FOLD = 2 / np.sqrt(27)


@pytest.fixture(scope="module")
def lossy(circle):
    """A third of the points escapes, another third has no forcing period."""
    growth, angle = np.array([-0.5, -0.25, 0.0, 0.5, 1.0, 2.0]), 2 * np.pi * np.array([0.2, 0.25, 0.5])
    return cd.parameter_chart(circle, {"growth": growth, "angle": angle}, transient=60, periods=64)


def test_a_third_of_the_points_escapes(lossy):
    expected = np.repeat([cd.Outcome.PERIODIC] * 3 + [cd.Outcome.ESCAPED] * 3, 3).reshape(6, 3)
    np.testing.assert_array_equal(lossy["outcome"].values[..., 0], expected)
    escaped = lossy.isel(growth=[3, 4, 5])
    for name in ("lyapunov_exponent", "lyapunov_error", "events_per_period", "impacts_per_period", "closest_grazing"):
        assert np.isnan(escaped[name].values).all(), name
        assert not np.isnan(lossy.isel(growth=[0, 1, 2])[name].values).any(), name
    assert (escaped["period"].values == 0).all()
    assert (escaped["attractor_count"].values == 0).all()
    # a spiral ends in its centre, a rotation never does
    np.testing.assert_array_equal(lossy["period"].values[..., 0], [[1, 1, 1]] * 2 + [[5, 4, 2]] + [[0, 0, 0]] * 3)


def test_points_without_a_forcing_period_fail_alone(duffing):
    chart = cd.parameter_chart(
        duffing,
        {"omega": [0.0, -1.0, 1.0], "gamma": [0.1, 0.2]},
        transient=20,
        periods=16,
        max_period=4,
        max_extension=0,
    )
    failed = chart["outcome"].values[..., 0] == cd.Outcome.FAILED
    np.testing.assert_array_equal(failed, [[True, True], [True, True], [False, False]])
    np.testing.assert_array_equal(np.isnan(chart["forcing_period"].values), failed)
    assert np.isnan(chart["lyapunov_exponent"].values[:2]).all()


def test_attractors_among_the_seeds_are_counted_once(bistable, equilibria):
    """Two equilibria between the folds, one outside; the decay of y takes no part."""
    a = np.array([-0.5, -0.3, 0.0, 0.3, 0.5])
    chart = cd.parameter_chart(
        bistable,
        {"a": a, "c": [0.5, 1.0]},
        seeds=[{"x": -1.0}, {"x": 1.0}, {"x": 1.5, "y": -0.3}, {"x": -0.9}],
        transient=40,
        periods=32,
        max_period=4,
    )
    expected = np.where(np.abs(a) < FOLD, 2, 1)
    np.testing.assert_array_equal(chart["attractor_count"].values, expected[:, np.newaxis] * np.ones((1, 2)))
    slope = np.array([[1 - 3 * r**2 for r in (low, high, high, low)] for low, high in map(equilibria, a)])
    slowest = np.maximum(slope[:, np.newaxis], -np.array([0.25, 0.5])[:, np.newaxis])
    np.testing.assert_allclose(chart["lyapunov_exponent"].values[..., 0], slowest, rtol=1e-6)


def test_the_chart_is_its_points_whatever_the_chunks(bistable, monkeypatch):
    tasks = []
    monkeypatch.setattr(sweeps, "execute", lambda task, **_: tasks.append(task) or task.run(0, task.units))
    sweep = {"a": np.linspace(-0.39, 0.39, 5), "c": [0.01, 1.0, 2.0]}
    cd.parameter_chart(bistable, sweep, seeds=[{"x": -1.0}, {"x": 0.2}], transient=5, periods=16, max_period=4)
    (task,) = tasks
    whole = task.run(0, task.units)
    assert {name: (a.dtype.str[1:], a.shape[1:]) for name, a in whole.items()} == task.columns()
    for size in (1, 4, 7):
        parts = [task.run(first, min(size, task.units - first)) for first in range(0, task.units, size)]
        for name, values in whole.items():
            assert np.concatenate([part[name] for part in parts]).tobytes() == values.tobytes(), (name, size)
    monkeypatch.setattr(points, "PLAN", replace(points.PLAN, at_once=6))
    assert all(task.run(0, task.units)[name].tobytes() == values.tobytes() for name, values in whole.items())
    sent = pickle.loads(pickle.dumps(task))
    assert all(sent.run(3, 4)[name].tobytes() == values[3:7].tobytes() for name, values in whole.items())


def test_a_chart_is_wide(logistic):
    with pytest.raises(cd.SettingsError, match=r"sweep: names \['r'\]; a parameter chart sweeps two"):
        cd.parameter_chart(logistic, {"r": [3.0]}, transient=1, periods=4)


def test_section_points_are_those_of_the_closed_form(circle):
    """The last of 80 turns of a spiral, of which the map of one period is a turn by ``angle`` and a growth."""
    growth, angle = np.array([-0.05, 0.0]), 2 * np.pi * np.array([0.2, 0.25])
    chart = cd.parameter_chart(circle, {"growth": growth, "angle": angle}, transient=60, periods=64, section_points=8)
    assert chart["section"].dims == ("growth", "angle", "seed", "iterate", "state")
    points = chart["section"].values[..., 0] + 1j * chart["section"].values[..., 1]
    turn = np.exp(growth[:, np.newaxis] + 1j * angle)[:, :, np.newaxis, np.newaxis]
    np.testing.assert_allclose(points[..., 1:], turn * points[..., :-1], rtol=1e-10)
    np.testing.assert_allclose(np.abs(points[1]), 1.0, rtol=1e-10)


def test_without_section_points_a_chart_holds_none(circle, lossy):
    assert "section" not in lossy
    assert "iterate" not in lossy.sizes
    with pytest.raises(cd.errors.SettingsError, match="section_points"):
        cd.parameter_chart(circle, {"growth": [0.0], "angle": [1.0]}, transient=1, periods=2, section_points=-1)


def test_one_attractor_is_counted_once_in_short_records():
    """Chaos between the wells of Duffing's oscillator, whose means over 64 periods differ by a fifth."""
    duffing = cd.build("duffing")
    own = {name: [duffing.parameters[name]] for name in ("delta", "omega")}
    starts = {"count": 24, "seed": 1, "x": (-2, 2), "v": (-2, 2)}
    for periods in (64, 256):
        chart = cd.parameter_chart(duffing, own, periods=periods, transient=100, random=starts)
        assert (chart.cd.outcome == "chaotic").all()
        assert chart["attractor_count"].values.tolist() == [[1]]


def test_attractors_that_are_apart_stay_apart():
    """r x (1 - s |x|) has an interval of chaos on either side of zero, and so has it s times smaller."""
    x, r, s = sympy.symbols("x r s", real=True)
    both = clocked("both sides", (x,), {"r": 3.97, "s": 1.0}, {x: r * x * (1 - s * sympy.Abs(x))}, {x: 0.3})
    starts = {"count": 12, "seed": 1, "x": (-1, 1)}
    chart = cd.parameter_chart(both, {"r": [3.97, 3.99], "s": [1.0, 0.9]}, periods=64, transient=100, random=starts)
    assert (chart["attractor_count"] == 2).all()
