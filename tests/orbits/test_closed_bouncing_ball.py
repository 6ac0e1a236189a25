"""One bounce in n periods in closed form: SciPy's motion returns, and doubles and is born where it should."""

from math import cos, pi, sin

import numpy as np
import pytest
from support import closed_bouncing_ball as closed
from support.motion import arc, derivative

CASES = [(0.9, 1.0, 0.8, 1.0, 1), (0.4, 1.0, 0.8, 1.0, 1), (0.02, 11.0, 0.5, 2.0, 1), (0.75, 1.0, 0.8, 1.0, 2)]


@pytest.mark.parametrize(("a", "w", "e", "g", "n"), CASES)
def test_the_motion_returns_with_its_multipliers(a, w, e, g, n):
    def field(t, s):
        return [s[1], -g]

    period = 2 * pi * n / w
    for orbit in closed.bounces(a, w, e, g, n):
        assert orbit.clearance > 0
        hit = orbit.phase / w
        begin = hit + period / 2

        def lap(start, begin=begin):
            t, s = arc(field, begin, start, period, lambda t, s: a * sin(w * t) - s[0])
            floor = a * w * cos(w * t)
            return arc(field, t, [a * sin(w * t), floor - e * (s[1] - floor)], begin + period - t)[1]

        top = arc(field, hit, [a * sin(w * hit), orbit.speed], period / 2)[1]
        np.testing.assert_allclose(lap(top), top, atol=1e-10)
        map_ = derivative(lap, top, 1e-4 * min(1.0, a))
        assert np.trace(map_) == pytest.approx(orbit.trace, rel=1e-6)
        assert np.linalg.det(map_) == pytest.approx(orbit.determinant, rel=1e-6)


@pytest.mark.parametrize(("w", "e", "g", "n"), [(1.0, 0.8, 1.0, 1), (3.0, 0.5, 9.81, 1), (1.0, 0.8, 1.0, 2)])
def test_birth_and_doubling(w, e, g, n):
    born = closed.fold_amplitude(w, e, g, n)
    assert closed.bounces(born * (1 - 1e-9), w, e, g, n) == []
    assert closed.bounces(born * (1 + 1e-12), w, e, g, n)[0].trace == pytest.approx(1 + e**2, abs=1e-4)
    doubles = closed.doubling_amplitude(w, e, g, n)
    assert closed.bounces(doubles, w, e, g, n)[0].trace == pytest.approx(-(1 + e**2), abs=1e-12)
    assert closed.doubling_frequency(doubles, e, g, n) == pytest.approx(w, rel=1e-14)
