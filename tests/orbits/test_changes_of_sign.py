"""Along a branch only those changes of sign count that stand out of round-off."""

import numpy as np
import pytest

from chaosdrill.orbits.special import changes, noise_of


@pytest.mark.parametrize(
    ("values", "noise", "found"),
    [
        ([3.0, 1.0, -1.0, -2.0, 5.0], 0.0, [2, 4]),
        ([3.0, 0.0, -1.0], 0.0, [1]),
        ([3.0, np.nan, -1.0], 0.0, [2]),
        ([3.0, 0.1, -0.1, 0.1, -3.0], 0.2, [2]),
        ([3.0, -0.1, 0.1, 3.0], 0.2, []),
        ([0.1, -0.1, -3.0], 0.2, []),
    ],
)
def test_a_change_is_between_two_values_that_are_sure(values, noise, found):
    assert changes(np.array(values), np.full(len(values), noise)) == found


def test_noise_covers_the_round_off_of_determinants():
    """Products of matrices of determinant 1, up to entries of 1e7."""
    random = np.random.default_rng(5)
    product, arcs = np.eye(2), 0
    while np.abs(product).max() < 1e7:
        a, b = random.normal(size=2)
        product = np.array([[1 + a * b, a], [b, 1.0]]) @ product
        arcs += 1
        assert abs(np.linalg.det(product) - 1) < noise_of(product, arcs)
    assert abs(np.linalg.det(product) - 1) > 1e-6
