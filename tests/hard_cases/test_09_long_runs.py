"""Case 9: a million periods lose no digit of the state, and the advance is summed without loss."""

import numpy as np
import pytest

import chaosdrill as cd

POINT = (0.5117707419326684, 0.2579689590074009, 0.3668787222623992)
PROGRESSION = 0.1163908540290498
LONG = 1_000_000


@pytest.fixture(scope="module")
def late():
    return cd.poincare_section(cd.drill(eta=0.8), periods=4, transient=LONG)


def test_the_cycle_is_where_it_was(late):
    np.testing.assert_allclose(late["section"].values, [POINT] * late.sizes["iterate"], rtol=0, atol=1e-12)


def test_phase_is_kept(late):
    strobes = late["time"].values * 0.8 / (2 * np.pi)
    np.testing.assert_allclose(strobes, np.round(strobes), rtol=1e-14)
    assert round(strobes[-1]) >= LONG


def test_advance_is_summed_without_loss():
    spectrum = cd.lyapunov_spectrum(cd.drill(eta=0.8), periods=100_000, transient=200)
    assert float(spectrum["progression_rate"]) == pytest.approx(PROGRESSION, rel=1e-13)
