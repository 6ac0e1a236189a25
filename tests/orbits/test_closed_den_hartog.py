"""Den Hartog's motion without sticking: SciPy's motion returns, and the limit is where acceleration ends at a stop."""

from math import cos, pi

import numpy as np
import pytest
from support import closed_den_hartog as closed
from support.motion import arc, derivative

CASES = [(0.8, 0.3), (0.6, 0.2), (1.4, 0.5), (0.45, 0.1)]


def lap_of(w, friction):
    def half(t, s, way):
        return arc(lambda t, s: [s[1], cos(w * t) - s[0] - way * friction], t, s, 3 * pi / w, lambda _, s: -way * s[1])

    def lap(begin, s):
        t, s = half(begin, s, 1.0)
        t, s = half(t, [s[0], 0.0], -1.0)
        return arc(lambda t, s: [s[1], cos(w * t) - s[0] - friction], t, [s[0], 0.0], begin + 2 * pi / w - t)[1]

    return lap


@pytest.mark.parametrize(("w", "friction"), CASES)
def test_the_motion_returns_with_its_multipliers(w, friction):
    known = closed.sliding(w, friction)
    hit = known.phase / w
    # from the quarter before the maximum, where the mass moves forward
    begin, s = arc(lambda t, s: [s[1], cos(w * t) - s[0] - friction], hit - pi / w, [-known.amplitude, 0.0], pi / 2 / w)
    lap = lap_of(w, friction)
    np.testing.assert_allclose(lap(begin, s), s, atol=1e-10)
    map_ = derivative(lambda s: lap(begin, s), s)
    product, total = np.prod(known.multipliers).real, np.sum(known.multipliers).real
    assert np.linalg.det(map_) == pytest.approx(product, abs=1e-7)
    assert np.trace(map_) == pytest.approx(total, abs=1e-7)


@pytest.mark.parametrize("w", [0.6, 0.8, 1.5])
def test_it_begins_to_stick_where_the_mass_would_stay(w):
    """At the limit the demand cos(w t0) - x0 at a stop is as large as friction, and a multiplier vanishes."""
    limit = closed.sticking_friction(w)
    known = closed.sliding(w, limit * (1 - 1e-9))
    assert abs(cos(known.phase) - known.amplitude) == pytest.approx(limit, rel=1e-8)
    assert abs(known.multipliers[1]) < 1e-16
    assert closed.sliding(w, limit * (1 + 1e-9)) is None


def test_at_low_frequency_it_sticks_on_its_way_first():
    assert closed.slowest(0.4) > 1.2 / 0.4**2
