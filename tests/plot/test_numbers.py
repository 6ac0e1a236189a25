"""Numbers in legends and titles: digits that the error leaves, a true minus sign, infinity by its symbol."""

import numpy as np
import pytest

from chaosdrill.plot.style import shorten, subscript, uncertain


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [
        (0.0151012, 0.0000123, "0.01510(1)"),
        (-0.08792, 0.00021, "−0.0879(2)"),
        (14.5723, 0.3, "14.6(3)"),
        (1234.5, 20.0, "1234(20)"),
        (0.0914, 0.00097, "0.091(1)"),
        (-0.05148136, 0.0, "−0.0514814"),
        (-0.05148136, np.nan, "−0.0514814"),
        (-np.inf, np.nan, "−∞"),
    ],
)
def test_the_error_sets_the_digits(value, error, text):
    assert uncertain(value, error) == text


def test_plain_numbers_have_four_digits():
    assert shorten(-0.332781501) == "−0.3328"
    assert shorten(-np.inf) == "−∞"


def test_indices_are_lowered():
    assert subscript("λ", 12) == "λ₁₂"
