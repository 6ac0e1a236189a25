"""Peak force of a Hunt-Crossley contact against the maximum along the contact itself."""

import mpmath
import pytest
from hypothesis import given
from hypothesis import strategies as st

from chaosdrill.codegen.contacts import hunt_crossley_peak


def largest(v, lam, n, k):
    """Maximum of k d^n (1 + lam d') over d' in [0, v], with the depth from the integral of motion."""
    with mpmath.workdps(64):
        v, lam, n, k = map(mpmath.mpf, (v, lam, n, k))

        def motion(u):
            return u / lam - mpmath.log1p(lam * u) / lam**2

        def force(u):
            depth = ((n + 1) * (motion(v) - motion(u)) / k) ** (1 / (n + 1))
            return k * depth**n * (1 + lam * u)

        low, high = mpmath.mpf(0), v
        for _ in range(120):
            a, b = low + (high - low) / 3, high - (high - low) / 3
            low, high = (low, b) if force(a) > force(b) else (a, high)
        return float(force(low))


@given(st.floats(-12.0, 1.698).map(lambda u: 10.0**u), st.floats(0.05, 5.0), st.floats(0.5, 3.0), st.floats(1.0, 1e6))
def test_peak_is_the_maximum(x, lam, n, k):
    v = x / lam
    assert hunt_crossley_peak(v, lam, n, k) == pytest.approx(largest(v, lam, n, k), rel=1e-12)


def test_an_elastic_linear_contact_peaks_at_its_greatest_depth():
    assert hunt_crossley_peak(3.0, 0.0, 1.0, 16.0) == pytest.approx(12.0, rel=1e-15)
    assert hunt_crossley_peak(0.0, 0.5, 1.5, 16.0) == 0.0
