"""A cascade's distances fall by Feigenbaum's constant, and its ratios are told."""

import numpy as np
import pytest

from chaosdrill.plot.multipliers import FEIGENBAUM, cascade


def test_distances_lie_on_the_line(continuation):
    upper = cascade(continuation).axes[0]
    assert upper.get_yscale() == "log"
    dots, line = upper.get_lines()
    np.testing.assert_allclose(dots.get_ydata()[1:], line.get_ydata()[1:], rtol=0.03)
    assert line.get_ydata()[0] / line.get_ydata()[1] == pytest.approx(4.669201609, abs=1e-9)


def test_the_title_tells_the_accumulation_with_its_error(continuation):
    assert cascade(continuation).axes[0].get_title() == "growth rate r: accumulation at 3.569946(1)"


def test_ratios_are_told_from_the_third_doubling_on(continuation):
    lower = cascade(continuation).axes[1]
    assert [tick.get_text() for tick in lower.get_xticklabels()] == ["1 → 2", "2 → 4", "4 → 8", "8 → 16", "16 → 32"]
    # (sqrt 6 - 2)/(3.5440903596 - 1 - sqrt 6), known as 4.7514
    assert [text.get_text() for text in lower.texts] == ["4.6692", "4.7514", "4.6563", "4.6682"]
    assert lower.get_lines()[0].get_ydata()[0] == FEIGENBAUM


def test_the_line_leaves_out_what_the_error_covers(continuation):
    """The last distance is 0.0012, and an error above it leaves the one before."""
    dots, line = cascade(continuation.assign(accumulation_error=0.002)).axes[0].get_lines()
    assert line.get_ydata()[3] == dots.get_ydata()[3]
