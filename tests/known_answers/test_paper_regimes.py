"""The paper's four regimes at xi = 0.06: strobe points, multipliers and progression rates to 8 digits."""

import numpy as np
import pytest

import chaosdrill as cd

ORBITS = {
    0.8: {
        "points": [(0.5117707419326684, 0.2579689590074009, 0.3668787222623992)],
        "multipliers": [0.11672896840556 + 0.65713468420972j, 0.11672896840556 - 0.65713468420972j, 0],
        "progression": 0.1163908540290498,
        "events": 3,
        "period": 1,
    },
    0.6: {
        "points": [
            (0.9600731434657304, 0.4240583758953005, 0.5379459585801125),
            (0.6385735529660052, 0.1126868016956719, 0.1451131728326493),
        ],
        "multipliers": [-0.26096061533102 + 0.65086241068766j, -0.26096061533102 - 0.65086241068766j, 0],
        "progression": 0.1591797435744490,
        "period": 2,
    },
    0.63: {
        "points": [(0.7201005283205294, 0.1022519359120029, 0.0687759307641452)],
        "multipliers": [-0.33278150112798, 0.25609401718225, 0],
        "progression": 0.1362474287134805,
        "events": 3,
        "period": 4,
    },
}


@pytest.fixture(scope="module", params=ORBITS, ids="eta={}".format)
def orbit(request):
    return cd.poincare_section(cd.drill(eta=request.param), periods=128, transient=400), ORBITS[request.param]


def test_period(orbit):
    section, known = orbit
    assert int(section["period"]) == known["period"]
    assert int(section["outcome"]) in (cd.Outcome.OK, cd.Outcome.PERIODIC)


def test_strobe_points(orbit):
    section, known = orbit
    points = section["section"].values
    for point in known["points"]:
        assert np.abs(points - point).max(axis=1).min() < 1e-10


def test_multipliers(orbit, multipliers):
    section, known = orbit
    np.testing.assert_allclose(multipliers(section), known["multipliers"], atol=1e-9)


def test_progression_and_events(orbit):
    section, known = orbit
    assert float(section["progression_rate"]) == pytest.approx(known["progression"], rel=1e-9)
    if "events" in known:
        assert float(section["events_per_period"]) == pytest.approx(known["events"], abs=1e-12)


@pytest.mark.parametrize(("eta", "period"), [(0.8, 1), (0.6, 2), (0.63, 2), (0.448, 1)])
def test_damping_as_printed_gives_other_regimes(eta, period):
    section = cd.poincare_section(cd.drill(eta=eta, xi=0.12), periods=128, transient=1000)
    assert int(section["period"]) == period


def test_spectrum_of_a_cycle_is_its_multipliers():
    spectrum = cd.lyapunov_spectrum(cd.drill(eta=0.63), periods=4000, transient=400)
    cycle = 4 * 2 * np.pi / 0.63
    expected = np.log([0.33278150112798, 0.25609401718225]) / cycle
    np.testing.assert_allclose(spectrum["lyapunov_exponent"].values[:2], expected, atol=1e-9)
    assert spectrum["lyapunov_exponent"].values[2] == -np.inf
