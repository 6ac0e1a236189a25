"""The drill: the paper's regimes, and hits of Hunt and Crossley's law."""

import numpy as np
import pytest
import sympy

import chaosdrill as cd
from chaosdrill.codegen.contacts import hunt_crossley_duration, hunt_crossley_exit, hunt_crossley_peak
from chaosdrill.model.special import positive_power

# The paper's four regimes at xi = 0.06: strobe points, multipliers and progression rates to 8 digits.


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


def test_orbits_have_their_periods(orbit):
    section, known = orbit
    assert int(section["period"]) == known["period"]
    assert int(section["outcome"]) in (cd.Outcome.OK, cd.Outcome.PERIODIC)


def test_orbits_pass_their_strobe_points(orbit):
    section, known = orbit
    points = section["section"].values
    for point in known["points"]:
        assert np.abs(points - point).max(axis=1).min() < 1e-10


def test_orbits_have_their_multipliers(orbit, multipliers):
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


# The paper's chaos, eta = 0.448 at xi = 0.06, in the reduced and in the five-dimensional form.


KNOWN, ERRORS = [0.01510, -0.08792], [1e-5, 1e-5]


@pytest.fixture(scope="module")
def reduced():
    return cd.lyapunov_spectrum(cd.drill(eta=0.448), periods=300_000, transient=1000)


@pytest.fixture(scope="module")
def full():
    return cd.lyapunov_spectrum(cd.build("percussive-drill-5d", {"eta": 0.448}), periods=100_000, transient=1000)


def test_reduced_drill_has_its_exponents(reduced):
    found, error = (reduced[name].values for name in ("lyapunov_exponent", "lyapunov_error"))
    np.testing.assert_array_less(np.abs(found[:2] - KNOWN), 3 * np.hypot(error[:2], ERRORS))
    assert found[2] == -np.inf
    assert error[0] < 1e-3
    assert int(reduced["outcome"]) == cd.Outcome.CHAOTIC


def test_events_and_progression(reduced):
    assert float(reduced["impacts_per_period"]) == pytest.approx(0.7742, abs=3e-3)
    assert float(reduced["events_per_period"]) == pytest.approx(2.351, abs=6e-3)
    assert float(reduced["progression_rate"]) == pytest.approx(0.0048, abs=2e-4)


def test_dimension_survives_minus_infinity(reduced):
    first, second = reduced["lyapunov_exponent"].values[:2]
    assert float(reduced["kaplan_yorke_dimension"]) == pytest.approx(1 + first / abs(second), rel=1e-12)


def test_five_dimensions_add_two_structural_zeros(full):
    found, error = (full[name].values for name in ("lyapunov_exponent", "lyapunov_error"))
    assert np.abs(found[1:3]).max() < 1e-9
    assert abs(found[0] - KNOWN[0]) < 3 * np.hypot(error[0], ERRORS[0])
    assert abs(found[3] - KNOWN[1]) < 3 * np.hypot(error[3], ERRORS[1])
    assert found[4] == -np.inf


@pytest.mark.parametrize("eta", [0.8, 0.6, 0.63])
def test_five_dimensions_keep_the_exponents_of_a_cycle(eta):
    small = cd.lyapunov_spectrum(cd.drill(eta=eta), periods=2000, transient=400)["lyapunov_exponent"].values
    large = cd.lyapunov_spectrum(cd.build("percussive-drill-5d", {"eta": eta}), periods=2000, transient=400)
    large = large["lyapunov_exponent"].values
    assert np.abs(large[:2]).max() < 1e-9
    # of a complex pair the run fixes the mean; how it splits depends on the frame in which it ends
    assert large[2:4].mean() == pytest.approx(small[:2].mean(), abs=1e-9)
    if eta == 0.63:
        np.testing.assert_allclose(large[2:4], small[:2], atol=1e-9)
    assert large[4] == small[2] == -np.inf


# Hunt-Crossley contacts: exit speed, slope, duration and peak force, from the law and from the contact integrated.


# mass, stiffness, exponent, damping, entry speed; exit speed, slope, duration, peak force
ROWS = [
    (1.0, 1e6, 1.5, 0.3, 1.0, 0.8328697922656, 0.692821438954, 0.01308784404082, 265.837),
    (1.0, 1e6, 1.0, 0.3, 1.0, 0.8328697922656, 0.692821438954, 0.00315145331674, 947.613),
    (2.0, 5e3, 2.0, 1.7, 2.5, 0.5715638630951, 0.023612270164, 0.27125357342685, 119.591),
]

METHODS = [(row, "dop853") for row in ROWS] + [(row, "taylor") for row in ROWS if row[2] == int(row[2])]


@pytest.mark.parametrize("row", ROWS)
def test_exit_speed_and_peak_force(row):
    mass, stiffness, n, lam, v, leave, _, _, force = row
    assert hunt_crossley_exit(v, lam) == pytest.approx(leave, abs=5e-14)
    assert mass * hunt_crossley_peak(v, lam, n, stiffness / mass) == pytest.approx(force, abs=6e-4)


@pytest.mark.parametrize("row", ROWS)
def test_exit_speed_has_its_slope(row):
    lam, v, slope = row[3], row[4], row[6]
    h = 1e-5
    difference = (hunt_crossley_exit(v + h, lam) - hunt_crossley_exit(v - h, lam)) / (2 * h)
    s = hunt_crossley_exit(v, lam)
    assert v / (1 + lam * v) * (1 - lam * s) / s == pytest.approx(slope, abs=1e-12)
    assert difference == pytest.approx(slope, abs=1e-9)


@pytest.mark.parametrize("row", ROWS)
def test_contacts_last_as_long_as_tabled(row):
    mass, stiffness, n, lam, v, *_, duration, _ = row
    assert hunt_crossley_duration(v, lam, n, stiffness / mass) == pytest.approx(duration, rel=2e-12)


@pytest.mark.parametrize(("row", "method"), METHODS)
def test_the_contact_integrated_leaves_at_that_speed_and_time(row, method):
    mass, stiffness, n, lam, v0, leave, _, duration, force = row
    d, v, k, damping, exponent = sympy.symbols("d v k lam n", real=True)
    acceleration = -k * positive_power(d, exponent) * (1 + damping * v)
    system = cd.HybridSystem(
        name="contact",
        states=(d, v),
        parameters={"k": stiffness / mass, "lam": lam, "n": n},
        modes={"touch": {d: v, v: acceleration}, "apart": {d: v, v: 0}},
        transitions=[cd.Transition("exit", source="touch", target="apart", guard=d, direction=-1)],
        initial={"mode": "touch", d: 0.0, v: v0},
    )
    run = cd.trajectory(system, duration=1.01 * duration, samples=4001, method=method, tolerance=1e-13)
    assert run.sizes["event"] == 1
    assert float(run["event_time"][0]) == pytest.approx(duration, rel=1e-11)
    assert float(run["event_state_before"][0, 1]) == pytest.approx(-leave, rel=1e-11)
    depth, speed = run["states"].values[run["time"].values < duration].T
    largest = np.max(stiffness * depth**n * (1 + lam * speed))
    assert largest == pytest.approx(force, rel=1e-5)
