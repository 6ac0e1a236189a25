"""Periods on cascades whose doublings are known, at points no closer to them than 1e-4."""

import numpy as np
import pytest

import chaosdrill as cd

DOUBLINGS = np.array(
    [3.0, 1 + np.sqrt(6), 3.5440903595519, 3.5644072660954, 3.5687594195438, 3.5696916098013, 3.5698912593781]
)
"""From period 1 to 2, ..., from 64 to 128 (Feigenbaum 1978, doi:10.1007/BF01020332)."""

ACCUMULATION = 3.5699456718709

WINDOW, FIRST = 1 + np.sqrt(8), 3.8414990075
"""Where the window of period 3 opens, and where its cycle doubles."""

IMPACT_DOUBLING = 2.65334772785532
"""Wall at rest, restitution 0.8: see tests/known_answers/test_hits_and_sticking.py."""


def cascade():
    """Parameters on both sides of every doubling, and between them, with their periods."""
    near = (DOUBLINGS[:, None] + np.outer([-1, 1], [1e-4, 1.3e-4, 3e-4, 1e-3, 4e-3, 3e-2]).ravel()).ravel()
    r = np.unique(np.concatenate([near, np.linspace(2.7, 3.5695, 40)]))
    far = np.abs(r[:, None] - [*DOUBLINGS, ACCUMULATION]).min(axis=1) > 0.999e-4
    r = r[far & (r < ACCUMULATION)]
    return r, 2 ** np.searchsorted(DOUBLINGS, r)


def diagram(system, name, values, **more):
    settings = {"transient": 500, "periods": 256} | more
    found = cd.bifurcation_diagram(system, {name: values}, **settings).isel(seed=0)
    return found["period"].values, found["outcome"].values, found


def test_logistic_cascade(logistic):
    r, expected = cascade()
    period, outcome, found = diagram(logistic, "r", r)
    np.testing.assert_array_equal(period, np.where(expected <= 64, expected, 0))
    assert (outcome == cd.Outcome.PERIODIC).all()
    assert (found["lyapunov_exponent"].values[:, 1] < 0).all()


def test_exponents_of_cycles_are_the_logarithms_of_their_multipliers(logistic):
    """2 - r for the fixed point, 4 + 2 r - r**2 for the cycle of two."""
    r = np.array([2.9, 2.999, 2.9999, 3.0001, 3.001, 3.01, 3.4])
    _, _, found = diagram(logistic, "r", r)
    expected = np.where(r < 3, np.log(np.abs(2 - r)), np.log(np.abs(4 + 2 * r - r**2)) / 2)
    np.testing.assert_allclose(found["lyapunov_exponent"].values[:, 1], expected, rtol=2e-5)


@pytest.mark.parametrize(("transient", "periods"), [(0, 256), (100, 128), (3000, 200)])
def test_lengths_of_runs_make_no_difference(logistic, transient, periods):
    r, expected = cascade()
    chosen = expected <= 16
    period, _, _ = diagram(logistic, "r", r[chosen][::4], transient=transient, periods=periods)
    np.testing.assert_array_equal(period, expected[chosen][::4])


def test_window_of_period_three(logistic):
    inside = [WINDOW + 1e-4, WINDOW + 1e-3, FIRST - 1e-3, FIRST - 1e-4]
    period, outcome, _ = diagram(logistic, "r", np.array([*inside, FIRST + 1e-4, FIRST + 1e-3]), transient=3000)
    np.testing.assert_array_equal(period, [3, 3, 3, 3, 6, 6])
    assert (outcome == cd.Outcome.PERIODIC).all()


def test_intermittency_before_the_window_is_chaos(logistic):
    before = WINDOW - np.array([1e-4, 2e-4, 5e-4, 1e-3])
    period, outcome, found = diagram(logistic, "r", before)
    np.testing.assert_array_equal(period, 0)
    assert (outcome == cd.Outcome.CHAOTIC).all()
    assert (found["lyapunov_exponent"].values[:, 0] > 0.01).all()


def test_no_period_is_found_in_chaos(logistic):
    """Parameters at which the critical point falls on an unstable cycle: chaos without any window."""
    r = np.array([3.6785735104283222, 3.9277370017867516, 4.0])
    period, outcome, found = diagram(logistic, "r", r, seeds=[{"x": 0.3}])
    np.testing.assert_array_equal(period, 0)
    assert (outcome == cd.Outcome.CHAOTIC).all()
    assert found["lyapunov_exponent"].values[2, 0] == pytest.approx(np.log(2), abs=0.03)


def test_impact_oscillator_at_the_wall():
    system = cd.build("impact-oscillator", {"wall": 0.0, "zeta": 0.0, "e": 0.8})
    off = np.array([-1e-2, -1e-3, -1e-4, 1e-4, 1e-3])
    period, outcome, found = diagram(system, "omega", IMPACT_DOUBLING + off, periods=1024)
    np.testing.assert_array_equal(period, [1, 1, 1, 2, 2])
    assert (outcome == cd.Outcome.PERIODIC).all()
    w = IMPACT_DOUBLING + off[:3]
    c = np.cos(2 * np.pi / w)
    trace = -1.6 * c + 1.8**2 * (1 - w**2) * (1 + c) / 2
    multiplier = [np.abs(np.roots([1.0, -t, 0.8**2])).max() for t in trace]
    expected = np.log(multiplier) * w / (2 * np.pi)
    measured = found["lyapunov_exponent"].values[:3, 0]
    np.testing.assert_allclose(measured[1:], expected[1:], rtol=1e-6)
    # of a complex pair the tangents go on turning, and only the mean of its exponents is that of a record of any length
    assert found["lyapunov_exponent"].values[0].mean() == pytest.approx(expected[0], rel=1e-6)


def test_periods_at_an_event_are_those_of_its_crossings():
    """The cycle of two periods has two impacts; before the doubling there is one impact a period."""
    system = cd.build("impact-oscillator", {"wall": 0.0, "zeta": 0.0, "e": 0.8})
    off = np.array([-1e-2, -1e-4, 1e-4, 1e-3])
    period, _, found = diagram(system, "omega", IMPACT_DOUBLING + off, at="impact")
    np.testing.assert_array_equal(period, [1, 1, 2, 2])
    np.testing.assert_allclose(found["section"].values[..., 0], 0.0, atol=1e-11)


def test_points_judged_without_exponents(logistic):
    period, outcome, _ = diagram(logistic, "r", np.array([2.5, 3.2, 3.5, 3.7, 4.0]), exponents=0)
    np.testing.assert_array_equal(period, [1, 2, 4, 0, 0])
    assert outcome.tolist() == [cd.Outcome.PERIODIC] * 3 + [cd.Outcome.OK] * 2
