"""Stability follows from the multipliers, the one along the flow of an autonomous system apart."""

import numpy as np
import pytest

from chaosdrill.orbits.multipliers import is_stable


@pytest.mark.parametrize(
    ("multipliers", "autonomous", "stable"),
    [
        ([0.9 + 0.1j, 0.9 - 0.1j], False, True),
        ([-1.1, 0.2], False, False),
        ([1.0, 0.2], False, False),
        ([1.0 + 1e-13, 0.2], True, True),
        ([1.5, 1.0], True, False),
        ([-1.0, 1.0], True, False),
        ([np.nan, np.nan], False, False),
        ([np.nan, np.nan], True, False),
    ],
)
def test_stability(multipliers, autonomous, stable):
    assert bool(is_stable(np.array(multipliers, dtype=complex), int(autonomous))) is stable


def test_many_orbits_at_once():
    many = np.array([[2.0, 1.0], [1.0, 0.5]], dtype=complex)
    assert is_stable(many, 1).tolist() == [False, True]
    assert is_stable(many[:0], 1).shape == (0,)
