"""Case 8: tangents through a stiff contact are as good as the state, and the flow direction comes through it."""

import numpy as np
import pytest


@pytest.mark.parametrize(("k", "digits"), [(1e6, 1e-10), (1e8, 1e-9), (1e10, 1e-8), (1e12, 1e-7)])
def test_state_and_tangent_in_closed_form(k, digits, case, tangent_map):
    stiff = case(8)
    later = stiff.contact_time(k) + 1e-5
    state, matrix = tangent_map(stiff.pressed(k), later)
    assert state[1] == pytest.approx(-stiff.SPEED + stiff.LOAD * 1e-5, abs=1e-11)
    assert matrix[1, 0] == pytest.approx(stiff.entry(k), abs=digits)
    np.testing.assert_allclose(matrix @ [stiff.SPEED, stiff.LOAD], [state[1], stiff.LOAD], atol=digits)
    assert np.linalg.det(matrix) == pytest.approx(1.0, abs=digits)


def test_a_contact_that_has_no_series(case, tangent_map):
    stiff = case(8)
    later = stiff.contact_time(1e8, 1.5) + 1e-5
    state, matrix = tangent_map(stiff.pressed(1e8, 1.5), later, method="dop853")
    assert matrix[1, 0] == pytest.approx(stiff.entry(1e8, 1.5), abs=1e-9)
    np.testing.assert_allclose(matrix @ [stiff.SPEED, stiff.LOAD], [state[1], stiff.LOAD], atol=1e-9)
    assert np.linalg.det(matrix) == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize(("k", "n"), [(1e12, 1.0), (1e8, 1.5)])
def test_a_fixed_step_that_is_good_to_four_digits_in_the_state_is_not_in_the_tangent(k, n, case):
    stiff = case(8)
    speed, derivative = stiff.runge_kutta(k, n)
    assert speed == pytest.approx(-stiff.SPEED, abs=1e-4)
    assert abs(derivative - stiff.entry(k, n)) > 1


@pytest.mark.parametrize(("tolerance", "digits"), [(1e-4, 1e-1), (1e-6, 1e-3), (1e-8, 1e-5)])
def test_the_tangent_follows_the_tolerance(tolerance, digits, case, tangent_map):
    stiff = case(8)
    _, matrix = tangent_map(stiff.pressed(1e8), stiff.contact_time(1e8) + 1e-5, tolerance=tolerance)
    assert matrix[1, 0] == pytest.approx(stiff.entry(1e8), abs=digits)
