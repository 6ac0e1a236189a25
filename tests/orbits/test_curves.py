"""Curves of special points over two parameters lie where closed forms say."""

import numpy as np
import pytest
from support.following import at_both_limits, followed

from chaosdrill.dataset import Outcome
from chaosdrill.dataset.branches import Special
from chaosdrill.systems import build


@pytest.fixture(scope="module")
def wall():
    system = build("impact-oscillator", {"wall": 0.0, "zeta": 0.0, "omega": 2.64, "e": 0.8}, {})
    return system.with_initial(x=-0.615, v=0.0178)


def test_period_doubling_of_the_impact_oscillator(wall):
    limits = {"omega": (2.5, 2.8), "e": (0.3, 0.95)}
    result = followed(wall, limits, "period_doubling", 0.003)
    omega, e = result.values.T
    # Shaw and Holmes 1983: the trace is -(1 + e^2)
    gap = np.cos(np.pi / omega) ** 2 * (omega**2 - ((1 - e) / (1 + e)) ** 2) - 1
    assert np.abs(gap).max() < 1e-11
    assert at_both_limits(result, limits)
    assert (result.special == Special.PERIOD_DOUBLING).all()
    assert np.abs(result.multipliers[:, 0] + 1).max() < 1e-11
    assert np.abs(result.multipliers[:, 1].real + e**2).max() < 1e-11
    assert result.stable.all()
    assert result.residual.max() < 1e-12
    assert result.message == ""


def test_the_curve_starts_from_the_point_on_the_branch(wall):
    result = followed(wall, {"omega": (2.5, 2.8), "e": (0.75, 0.85)}, "period_doubling", 0.003)
    (start,) = result.events
    assert start.code == Special.PERIOD_DOUBLING
    assert abs(start.values[0] - 2.653347727855322934164893) < 1e-11
    assert start.values[1] == pytest.approx(0.8, abs=1e-14)
    assert start.error < 1e-11
    assert (np.diff(result.arclength) > 0).all()


@pytest.mark.parametrize(("wall", "omega"), [(1.4, 0.5), (1.2, 1.8)])
def test_grazing_of_the_free_vibration(wall, omega):
    system = build("impact-oscillator", {"zeta": 0.1, "wall": wall, "omega": omega}, {})
    limits = {"omega": (0.5, 2.0), "wall": (0.1, 6.0)}
    result = followed(system, limits, "grazing", 0.02, transient=100)
    w, height = result.values.T
    assert np.abs(height - 1 / np.hypot(1 - w**2, 0.2 * w)).max() < 1e-11
    # over the resonance, where the wall's parameter turns back
    assert at_both_limits(result, limits)
    assert np.allclose(np.sort(result.values[[0, -1], 0]), [0.5, 2.0], rtol=0, atol=1e-12)
    assert result.sequences == ("",)
    assert np.allclose(np.abs(result.multipliers), np.exp(-0.2 * np.pi / w)[:, np.newaxis], rtol=1e-10, atol=0)
    assert result.message == ""


def test_birth_of_the_bouncing_orbit():
    # an orbit with one impact a period of the floor needs A omega^2 cos = pi g (1 - e)/(1 + e), g = omega = 1
    limits = {"amplitude": (0.1, 1.5), "e": (0.5, 0.95)}
    result = followed(build("bouncing-ball", {}, {}), limits, "fold", 0.02)
    amplitude, e = result.values.T
    assert np.abs(amplitude - np.pi * (1 - e) / (1 + e)).max() < 1e-11
    assert at_both_limits(result, limits)
    assert (result.special == Special.FOLD).all()
    assert np.abs(result.multipliers[:, 0] - 1).max() < 1e-6
    assert np.abs(result.multipliers[:, 1].real - e**2).max() < 1e-6


def test_doublings_begin_at_a_resonance_of_the_grazing_vibration():
    zeta = 0.05
    system = build("impact-oscillator", {"zeta": zeta, "wall": 0.3, "omega": 2.2}, {})
    result = followed(system, {"omega": (1.9, 2.4), "wall": (0.2, 0.5)}, "period_doubling", 0.02)
    (end,) = (e for e in result.events if e.code == Special.GRAZING)
    # Nordmark 1991: where the forcing is twice the damped frequency, on the curve of grazing
    omega = 2 * np.sqrt(1 - zeta**2)
    gap = np.abs(end.values - [omega, 1 / np.hypot(1 - omega**2, 2 * zeta * omega)])
    # the multipliers have no bound there, so that it is approached only
    assert gap.max() < 1e-5
    assert gap[0] < 10 * end.error < 1e-4
    assert end.text == "impact vanishes; the curve ends"
    assert result.smallest_speed[end.point] < 1e-5


def test_what_is_not_there_is_said(wall):
    result = followed(wall, {"omega": (2.6, 2.7), "e": (0.75, 0.85)}, "fold", 0.003)
    assert result.outcome == Outcome.NO_SPECIAL_POINT
    assert result.values.shape == (0, 2)
    assert result.message.startswith("no fold on the branch of omega")
    assert "period doubling at 2.65334773" in result.message


def test_no_orbit_is_said():
    # the floor moves too little for a ball to bounce once a period
    system = build("bouncing-ball", {"amplitude": 0.1}, {})
    result = followed(system, {"amplitude": (0.05, 1.0), "e": (0.5, 0.95)}, "fold", 0.02)
    assert result.outcome != Outcome.PERIODIC
    assert result.message
    assert not len(result.values)
