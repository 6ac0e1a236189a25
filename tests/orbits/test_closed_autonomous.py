"""Cycles without a clock: SciPy's motion takes the time that the closed forms say, and returns."""

import numpy as np
import pytest
from support import closed_autonomous as closed
from support.motion import arc


@pytest.mark.parametrize(("speed", "static", "kinetic"), [(0.2, 1.0, 0.5), (0.1, 1.0, 0.6), (0.7, 1.5, 0.3)])
def test_slip_on_the_belt(speed, static, kinetic):
    known = closed.belt(speed, static, kinetic)
    t, s = arc(lambda t, s: [s[1], kinetic - s[0]], 0.0, known.release, 20.0, lambda _, s: s[1] - speed)
    assert t == pytest.approx(known.slip_time, abs=1e-10)
    np.testing.assert_allclose(s, known.stick, atol=1e-10)
    assert abs(known.stick[0]) < static
    assert (known.release[0] - known.stick[0]) / speed + known.slip_time == pytest.approx(known.period, rel=1e-14)


@pytest.mark.parametrize(("alpha", "gamma"), [(0.3, 0.15), (0.3, 0.05), (0.2, 0.4)])
def test_rolling(alpha, gamma):
    known = closed.gait(alpha, gamma)

    def step(speed):
        start = [gamma - alpha, speed]
        t, s = arc(lambda t, s: [s[1], np.sin(s[0])], 0.0, start, 20.0, lambda _, s: s[0] - gamma - alpha)
        return t, np.cos(2 * alpha) * s[1]

    assert step(known.after) == pytest.approx((known.period, known.after), abs=1e-10)
    faster, slower = step(known.after + 1e-5)[1], step(known.after - 1e-5)[1]
    assert (faster - slower) / 2e-5 == pytest.approx(known.multipliers[1], abs=1e-8)


def test_a_wheel_on_too_gentle_a_slope_does_not_roll():
    assert closed.gait(0.3, 0.02) is None
