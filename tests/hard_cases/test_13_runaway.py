"""Case 13: a bit that runs away has escaped; its numbers are missing, not large."""

import numpy as np
import pytest

import chaosdrill as cd


def test_from_rest_the_bit_runs_away_between_two_frequencies():
    diagram = cd.bifurcation_diagram(cd.drill(), {"eta": np.array([0.448, 0.48, 0.49, 0.6])}, transient=300, periods=32)
    outcome = diagram["outcome"].values[:, 0]
    assert list(outcome == cd.Outcome.ESCAPED) == [False, True, True, False]
    lost = diagram.isel(eta=[1, 2], seed=0)
    assert np.isnan(lost["section"].values).all()
    assert np.isnan(lost["lyapunov_exponent"].values).all()
    assert np.isnan(lost["progression_rate"].values).all()
    assert (lost["period"].values == 0).all()
    assert np.isfinite(diagram["progression_rate"].isel(eta=[0, 3], seed=0).values).all()


@pytest.mark.parametrize("eta", [0.448, 0.6, 0.8])
def test_a_fast_bit_runs_away_at_any_frequency(eta):
    system = cd.drill(eta=eta, initial={"y": -1.0, "u": 2.0, "mode": "stick"})
    spectrum = cd.lyapunov_spectrum(system, periods=500, transient=100)
    assert int(spectrum["outcome"]) == cd.Outcome.ESCAPED
    assert np.isnan(spectrum["lyapunov_exponent"].values).all()


@pytest.mark.parametrize("transient", [0, 10])
def test_a_bit_that_runs_away_while_averages_are_taken_has_no_rates(transient):
    spectrum = cd.lyapunov_spectrum(cd.drill(eta=0.48), periods=500, transient=transient)
    assert int(spectrum["outcome"]) == cd.Outcome.ESCAPED
    for name in ("progression_rate", "progression_error", "events_per_period", "impacts_per_period"):
        assert np.isnan(spectrum[name]), name


def test_the_last_point_of_a_trajectory_is_near_the_bound_that_it_left():
    run = cd.trajectory(cd.drill(eta=0.48), periods=500, samples=20)
    assert int(run["outcome"]) == cd.Outcome.ESCAPED
    rock = run["state"].values[:, 2]
    known = rock[np.isfinite(rock)]
    assert 24 < known[-1] < 27
    assert len(known) > 100


def test_kinetic_friction_above_the_load_lets_nothing_run_away():
    spectrum = cd.lyapunov_spectrum(cd.drill(eta=0.48, mu=0.75), periods=300, transient=100)
    assert int(spectrum["outcome"]) != cd.Outcome.ESCAPED
    assert np.isfinite(spectrum["progression_rate"])


def test_a_rock_that_nothing_holds_runs_away():
    spectrum = cd.lyapunov_spectrum(cd.drill(friction="none"), periods=500)
    assert int(spectrum["outcome"]) == cd.Outcome.ESCAPED
