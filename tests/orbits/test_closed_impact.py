"""One impact of the damped oscillator in closed form: SciPy's motion returns, with the same derivative."""

from math import cos, pi

import numpy as np
import pytest
from support import closed_impact as closed
from support.motion import arc, derivative

CASES = [(1.9, 0.3, 0.05, 0.8, 1), (2.0, 0.3, 0.05, 0.8, 1), (1.8, 0.5, 0.05, 0.8, 1), (4.1, 0.02, 0.1, 0.6, 2)]


def motion_of(w, d, zeta, r):
    """The field, and the way from a flight to the wall and on to the same phase, n periods later."""

    def field(t, s):
        return [s[1], -s[0] - 2 * zeta * s[1] + cos(w * t)]

    def lap(start, period, begin):
        t, s = arc(field, begin, start, 2 * period, lambda _, s: s[0] - d)
        return arc(field, t, [d, -r * s[1]], begin + period - t)[1]

    return field, lap


@pytest.mark.parametrize(("w", "d", "zeta", "r", "n"), CASES)
def test_the_motion_returns_with_its_multipliers(w, d, zeta, r, n):
    found = closed.one_impact(w, d, zeta, r, n)
    assert found
    for orbit in found:
        assert orbit.highest < d
        field, lap = motion_of(w, d, zeta, r)
        period, hit = 2 * pi * n / w, orbit.phase / w
        t, begin = arc(field, hit, [d, -r * orbit.speed], period / 3)
        np.testing.assert_allclose(lap(begin, period, t), begin, atol=1e-10)
        if orbit.speed > 0.1:
            map_ = derivative(lambda s, t=t, lap=lap, period=period: lap(s, period, t), begin)
            assert np.trace(map_) == pytest.approx(orbit.trace, abs=1e-7)
            assert np.linalg.det(map_) == pytest.approx(orbit.determinant, abs=1e-7)


@pytest.mark.parametrize("d", [0.3, 0.5, 0.9])
def test_free_motion_grazes(d):
    w = closed.grazing_frequency(d, 0.05)
    assert closed.amplitude(w, 0.05) == pytest.approx(d, abs=1e-15)
    assert closed.amplitude(w + 0.1, 0.05) < d


@pytest.mark.parametrize(("d", "side"), [(0.3, -1), (0.5, 1)])
def test_on_which_side_of_grazing_the_slow_impact_exists(d, side):
    """With d = 0.3 the orbit goes on with an impact; with d = 0.5 it meets one that has it already, and both end."""
    w = closed.grazing_frequency(d, 0.05)
    there = [orbit.speed for orbit in closed.one_impact(w + side * 1e-6, d, 0.05, 0.8)]
    beyond = [orbit.speed for orbit in closed.one_impact(w - side * 1e-6, d, 0.05, 0.8)]
    assert len(there) == len(beyond) + 1
    assert there[0] < 1e-5
    slow, slower = (closed.one_impact(w + side * off, d, 0.05, 0.8)[0] for off in (1e-6, 1e-8))
    assert slow.trace * side > 1e4
    assert slower.trace * slower.speed == pytest.approx(slow.trace * slow.speed, rel=1e-4)


def test_impacting_orbits_meet_in_a_fold():
    w = closed.fold_frequency(0.5, 0.05, 0.8, 1.85, 1.9)
    slow, fast = closed.one_impact(w - 1e-10, 0.5, 0.05, 0.8)
    assert slow.speed == pytest.approx(fast.speed, abs=1e-3)
    for orbit in (slow, fast):
        assert orbit.trace == pytest.approx(1 + orbit.determinant, abs=1e-3)
    assert closed.one_impact(w + 1e-10, 0.5, 0.05, 0.8) == []
