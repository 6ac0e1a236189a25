"""Case 7: a resolved contact comes to the mapped one as k^(-1/(n+1)), no faster and no slower."""

from math import log

import numpy as np
import pytest


@pytest.mark.parametrize("n", [1.0, 1.5])
def test_the_trace_approaches_with_the_slope_of_theory(n, case):
    found = case(7).traces(n, (1e6, 1e8, 1e10))
    slopes = [log(found[high] / found[low]) / log(high / low) for low, high in ((1e6, 1e8), (1e8, 1e10))]
    # what is left is of the next order in k^(-1/(n+1))
    assert slopes == pytest.approx([-1 / (n + 1)] * 2, abs=2e-3)
    assert abs(slopes[1] + 1 / (n + 1)) < abs(slopes[0] + 1 / (n + 1))


def test_multipliers_of_a_stiff_cycle_agree_between_methods(case):
    stop = case(7).resolved(1e8, 1.0)
    (_, taylor), (_, runge_kutta) = (case(7).cycle(stop, method) for method in ("taylor", "dop853"))
    np.testing.assert_allclose(np.sort_complex(taylor), np.sort_complex(runge_kutta), rtol=0, atol=1e-8)


def test_a_soft_stop_is_another_system(case):
    assert case(7).cycle(case(7).mapped())[0] == 1
    assert case(7).cycle(case(7).resolved(1e4, 1.0))[0] == 3
