"""Case 14: what the study compares with is right; the laws themselves are held by tests/engine."""

import math

import numpy as np
import pytest


def test_the_guard_beside_a_decay_rises_where_the_study_says(case):
    times = case(14).rises()
    assert len(times) == 32
    x, y = -np.cos(10 * times), 0.1 * np.cos(20 * times)
    np.testing.assert_allclose(x - y, 0.3, rtol=0, atol=1e-13)
    assert (10 * np.sin(10 * times) + 2 * np.sin(20 * times) > 0).all()


def test_the_energy_of_the_oscillator_has_its_size_and_rate_taken_out(case):
    x = np.array([2e-6, 1e-6])
    found = case(14).energy(x, 0 * x, 2e-6, 1e5)
    assert found[0] == pytest.approx(3 / 4)
    assert found[1] == pytest.approx(1 / 8 + 1 / 64)


def test_the_clock_escapement_is_damped_as_its_turn_says(case):
    """Its characteristic polynomial s**2 + s/5 + 1 has the frequency sqrt(0.99)."""
    assert max(np.roots([1, 0.2, 1]).imag) == pytest.approx(math.sqrt(0.99))
    assert [t.direction for t in case(14).escapement().transitions] == [1]
