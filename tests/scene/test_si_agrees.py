"""A scene in SI units and the dimensionless one give the same motion; the SI one adds the progression in m/h."""

import numpy as np
import pytest

from chaosdrill.scene import parse_scene
from chaosdrill.workflow import run

ANALYSIS = """
[analysis.section]
kind = "poincare-section"
transient = 20
periods = 6
"""
# by hand, from equation (8): sqrt(K/m1) = 126.49.../s, mu_e F_N = 8 kN, mu_e F_N / K = 2 mm
DIMENSIONLESS = """\
[system]
model = "percussive-drill"
effects = { drive = "harmonic", friction = "stribeck", rock = "moving", contact = "hunt-crossley" }
[system.parameters]
eps = 2.0
xi = 0.06008327554319921
eta = 0.7905694150420949
a = 0.25
b = 0.7
r = 1.0
mu = 0.6
g = 3.0357865537616441
lam = 0.6071573107523288
k = 12e5
"""


@pytest.fixture
def results(in_si):
    return [run(parse_scene(text + ANALYSIS))["section"] for text in (in_si, DIMENSIONLESS)]


def test_same_motion(results):
    si, dimensionless = results
    assert si.sizes["iterate"] == 6
    np.testing.assert_allclose(si["section"], dimensionless["section"], rtol=1e-8, atol=1e-10)


def test_progression_in_metres_per_hour(results):
    si, dimensionless = results
    # 2 mm in every 7.905694 ms
    expected = float(dimensionless["progression_rate"]) * 2e-3 / 7.905694150420949e-3 * 3600
    assert expected > 0
    assert float(si["progression_rate_si"]) == pytest.approx(expected, rel=1e-8)
    assert si["progression_rate_si"].attrs["units"] == "m h-1"
    assert "progression_rate_si" not in dimensionless


def test_scales_are_kept(in_si):
    tree = run(parse_scene(in_si + ANALYSIS))
    assert tree.attrs["si_length_m"] == pytest.approx(2e-3, rel=1e-14)
    assert tree.attrs["si_time_s"] == pytest.approx(7.905694150420949e-3, rel=1e-14)
