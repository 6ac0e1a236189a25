"""Systems that hit, roll, stick and fire: closed forms and published multipliers."""

from math import atan, cos, log, pi, sin, sqrt, tan

import mpmath
import numpy as np
import pytest
from scipy.optimize import brentq

import chaosdrill as cd

# Impact oscillator with its wall at 0.3: exponents, and the sum rule that they must obey.


@pytest.fixture(scope="module")
def spectrum():
    return cd.lyapunov_spectrum(cd.build("impact-oscillator"), periods=300_000, transient=1000)


def test_impact_oscillator_has_its_exponents(spectrum, agrees):
    assert agrees(spectrum, [0.0914, -0.3190], [3e-4, 3e-4])
    assert float(spectrum["lyapunov_error"][0]) < 1e-3


def test_sum_is_damping_and_impacts(spectrum):
    impacts = float(spectrum["impacts_per_period"]) * 2.5 / (2 * pi)
    total = float(spectrum["lyapunov_exponent"].sum())
    assert total == pytest.approx(-0.1 + 2 * log(0.8) * impacts, abs=1e-9)


def test_outcome_is_chaos(spectrum):
    assert int(spectrum["outcome"]) == cd.Outcome.CHAOTIC


def test_fixed_steps_with_bisection_agree(agrees):
    # the paper's method: its exponents are only as good as its statistics here
    spectrum = cd.lyapunov_spectrum(
        cd.build("impact-oscillator"), periods=10_000, transient=500, method="rk4", steps=200, tolerance=1e-10
    )
    assert agrees(spectrum, [0.0914, -0.3190], [3e-4, 3e-4])
    assert np.all(spectrum["lyapunov_error"].values < 5e-3)


# Impact oscillator with its wall at the rest position: orbit, multipliers and period doubling in closed form.


R = 0.8

DOUBLING = 2.65334772785532


def oscillator(w, **start):
    return cd.build("impact-oscillator", {"wall": 0.0, "zeta": 0.0, "omega": w, "e": R}, initial=start)


def closed_form(w):
    """Trace of the period map, and impact speed, of the orbit with one impact a period."""
    c, half = cos(2 * pi / w), pi / w
    trace = -2 * R * c + (1 + R) ** 2 * (1 - w**2) * (1 + c) / 2
    speed = 1 / abs(1 - w**2) / sqrt(((1 + R) / tan(half) / 2) ** 2 + ((1 - R) / (2 * w)) ** 2)
    return trace, speed


@pytest.mark.parametrize("w", [2.5, 2.6, 2.65])
def test_multipliers_and_impact_speed(w, multipliers):
    trace, speed = closed_form(w)
    section = cd.poincare_section(oscillator(w), periods=64, transient=2000)
    assert int(section["period"]) == 1
    expected = np.roots([1.0, -trace, R**2])
    expected = sorted(expected, key=lambda z: (-round(abs(z), 9), -z.imag))
    np.testing.assert_allclose(multipliers(section), expected, atol=1e-9)

    run = cd.trajectory(oscillator(w), periods=3, transient=2000)
    np.testing.assert_allclose(np.abs(run["event_speed"].values), speed, rtol=1e-10)
    assert run["states"].values[:, 0].max() <= 1e-12


def test_the_orbit_doubles_where_it_should():
    periods = []
    for w in (DOUBLING - 2e-3, DOUBLING + 2e-3):
        section = cd.poincare_section(oscillator(w), periods=64, transient=20_000)
        periods.append(int(section["period"]))
    assert periods == [1, 2]


def test_measured_multipliers_put_the_doubling_in_its_place(multipliers):
    assert closed_form(DOUBLING)[0] == pytest.approx(-(1 + R**2), abs=1e-12)
    frequencies = DOUBLING - 1e-3 * np.arange(1, 6)
    distance = []
    for w in frequencies:
        section = cd.poincare_section(oscillator(w), periods=16, transient=20_000)
        distance.append(np.prod(1 + multipliers(section)).real)
    # the frequency as a polynomial of the distance to a multiplier -1, continued to 0
    found = np.polynomial.Polynomial.fit(distance, frequencies, 4)(0.0)
    assert found == pytest.approx(DOUBLING, abs=1e-10)


# One bounce a period on a moving floor: impact speed and multipliers in closed form, without the high-bounce limit.


CASES = [(0.8, 0.9), (0.8, 0.4), (0.6, 0.95)]


def closed_form_of_ball(e, amplitude):
    """Normal speed, trace and determinant of the period map, gravity and frequency 1."""
    floor = (1 - e) / (1 + e) * pi
    acceleration = -amplitude * sqrt(1 - (floor / amplitude) ** 2)
    return floor + pi, 1 + e**2 + (1 + e) ** 2 * acceleration, e**2


@pytest.mark.parametrize(("e", "amplitude"), CASES)
def test_impact_speed_and_multipliers(e, amplitude, multipliers):
    floor = (1 - e) / (1 + e) * pi
    phase = np.arccos(floor / amplitude)
    # on its way down, a little slower than on the orbit
    start = {"x": amplitude * np.sin(phase) + pi * phase - phase**2 / 2, "v": phase - pi + 0.01}
    system = cd.build("bouncing-ball", {"e": e, "amplitude": amplitude}, initial=start)
    section = cd.poincare_section(system, periods=16, transient=2000)
    speed, trace, determinant = closed_form_of_ball(e, amplitude)
    assert int(section["period"]) == 1
    expected = sorted(np.roots([1.0, -trace, determinant]), key=lambda z: (-round(abs(z), 9), -z.imag))
    np.testing.assert_allclose(multipliers(section), expected, atol=1e-9)
    run = cd.trajectory(system, periods=3, transient=2000)
    np.testing.assert_allclose(-run["event_speed"].values, speed, rtol=1e-11)


# Rimless wheel: multipliers 1 and cos^2(2 alpha) exactly.


WHEEL_CASES = [(0.3, 0.15), (0.2, 0.1), (0.39269908169872414, 0.2)]


def step_time(alpha, slope):
    """Duration of a step of the rolling gait, from its energy balance."""
    with mpmath.workdps(30):
        keep = mpmath.cos(2 * alpha) ** 2
        gain = 2 * (mpmath.cos(slope - alpha) - mpmath.cos(slope + alpha))
        start = keep * gain / (1 - keep)

        def pace(angle):
            return 1 / mpmath.sqrt(start + 2 * (mpmath.cos(slope - alpha) - mpmath.cos(angle)))

        return float(mpmath.quad(pace, mpmath.linspace(slope - alpha, slope + alpha, 9)))


@pytest.mark.parametrize(("alpha", "slope"), WHEEL_CASES)
def test_rimless_wheel_steps_in_closed_form(alpha, slope):
    run = cd.trajectory(cd.build("rimless-wheel", {"alpha": alpha, "gamma": slope}), duration=300)
    steps = np.diff(run["event_time"].values)
    np.testing.assert_allclose(steps[-10:], step_time(alpha, slope), rtol=1e-10)


@pytest.mark.parametrize(("alpha", "slope"), WHEEL_CASES)
def test_rimless_wheel_has_its_multipliers(alpha, slope, strobed, multipliers):
    system = cd.build("rimless-wheel", {"alpha": alpha, "gamma": slope})
    section = cd.poincare_section(strobed(system, step_time(alpha, slope)), periods=16, transient=200)
    assert int(section["period"]) == 1
    np.testing.assert_allclose(multipliers(section), [1, cos(2 * alpha) ** 2], atol=1e-9)


@pytest.mark.parametrize(("alpha", "slope"), WHEEL_CASES)
def test_exponents_of_wheel(alpha, slope):
    step = step_time(alpha, slope)
    system = cd.build("rimless-wheel", {"alpha": alpha, "gamma": slope})
    spectrum = cd.lyapunov_spectrum(system, duration=400 * step, transient=200 * step)
    expected = [0.0, 2 * log(cos(2 * alpha)) / step]
    np.testing.assert_allclose(spectrum["lyapunov_exponent"].values, expected, atol=1e-9)


# Den Hartog's oscillator without sticking, with V = 1/(1 - w^2) and U = tan(pi/(2 w))/w: x0^2 = V^2 - S^2 U^2 is the
# amplitude, and a stop multiplies the speed of a neighbour by (w^2 x0 - S)/(w^2 x0 + S). Den Hartog 1931, Trans. ASME
# 53, APM-53-9, 107; Shaw 1986, doi:10.1016/S0022-460X(86)80058-X.


@pytest.mark.parametrize(("w", "friction"), [(0.8, 0.3), (0.6, 0.2)])
def test_dry_friction_has_the_amplitude_and_the_multipliers_of_den_hartog(w, friction, multipliers):
    amplitude = sqrt(1 / (1 - w**2) ** 2 - (friction * tan(pi / (2 * w)) / w) ** 2)
    system = cd.build("den-hartog", {"omega": w, "S": friction})
    run = cd.trajectory(system, periods=4, transient=400)
    kinds = run.cd.words("event_kind").values.tolist()
    assert set(kinds) == {"reverse-forward", "reverse-backward"}
    assert len(kinds) == 8
    np.testing.assert_allclose(np.abs(run["event_state_before"].values[:, 0]), amplitude, rtol=1e-12)
    kept = (w**2 * amplitude - friction) / (w**2 * amplitude + friction)
    c, s = cos(pi / w), sin(pi / w)
    pair = sorted(np.linalg.eigvals([[c, s], [-kept * s, kept * c]]) ** 2, key=lambda z: -z.imag)
    section = cd.poincare_section(system, periods=64, transient=400)
    assert int(section["period"]) == 1
    np.testing.assert_allclose(multipliers(section), pair, atol=1e-9)


def test_a_mass_that_friction_outweighs_stays():
    system = cd.build("den-hartog", {"omega": 0.8, "S": 1.5})
    run = cd.trajectory(system, periods=20)
    assert run.cd.words("mode")[-1] == "stick"
    assert float(run["states"].values[-1, 1]) == 0.0


# Stick-slip on a belt: period in closed form, multipliers 1 and 0.


BELT_CASES = [(0.2, 1.0, 0.5), (0.1, 1.0, 0.6), (0.7, 1.5, 0.3)]


def period(belt, static, kinetic):
    drop = static - kinetic
    return 2 * drop / belt + 2 * pi - 2 * atan(drop / belt)


@pytest.mark.parametrize("case", BELT_CASES)
def test_stick_slip_has_its_period(case):
    belt, static, kinetic = case
    # the mass is carried by the belt, with whatever velocity it starts
    system = cd.build("belt-stick-slip", {"belt": belt, "F_s": static, "F_k": kinetic})
    run = cd.trajectory(system, duration=200)
    releases = run["event_time"].values[run.cd.words("event_kind") == "release"]
    assert len(releases) > 5
    np.testing.assert_allclose(np.diff(releases), period(*case), rtol=1e-12)


@pytest.mark.parametrize("case", BELT_CASES)
def test_multipliers_of_belt(case, strobed, multipliers):
    belt, static, kinetic = case
    system = cd.build("belt-stick-slip", {"belt": belt, "F_s": static, "F_k": kinetic}, initial={"v": belt})
    section = cd.poincare_section(strobed(system, period(*case)), periods=16, transient=8)
    assert int(section["period"]) == 1
    np.testing.assert_allclose(multipliers(section), [1, 0], atol=1e-9)


@pytest.mark.parametrize("case", BELT_CASES)
def test_exponents_are_zero_and_minus_infinity(case):
    belt, static, kinetic = case
    # within the stick, so that no event falls on the end of a whole number of cycles
    start = {"x": 0.25, "v": belt}
    system = cd.build("belt-stick-slip", {"belt": belt, "F_s": static, "F_k": kinetic}, initial=start)
    cycle = period(*case)
    spectrum = cd.lyapunov_spectrum(system, duration=200 * cycle, transient=8 * cycle)
    exponents = spectrum["lyapunov_exponent"].values
    assert abs(exponents[0]) < 1e-10
    assert exponents[1] == -np.inf


# Oscillators that fire.


def test_two_pulse_coupled_oscillators_repel_from_their_alternate_firing():
    """Mirollo and Strogatz 1990, doi:10.1137/0150098: p returns as h(h(p)), f(h(p)) = f(1 - p) + eps."""
    leak, eps = 1.0, 0.1
    top = 1 / (1 - np.exp(-leak))

    def fired(phase):
        return -np.log(1 - (eps + top * (1 - np.exp(-leak * (1 - phase)))) / top) / leak

    phase = brentq(lambda p: fired(p) - p, 0.3, 0.9, xtol=1e-15)
    rate, kick = "g*(1/(1 - exp(-g)) - {})", "{} + eps"
    fires = [
        cd.Transition(f"fire-{one}", "on", "on", f"{one} - 1", 1, reset={one: "0", other: kick.format(other)})
        for one, other in ("ab", "ba")
    ]
    system = cd.HybridSystem(
        name="pair", states="a b", parameters={"g": leak, "eps": eps}, transitions=fires,
        modes={"on": {one: rate.format(one) for one in "ab"}},
        initial={"a": 0.0, "b": top * (1 - np.exp(-leak * phase)) + 1e-4},
    )  # fmt: skip
    found = cd.periodic_orbit(system, start="guess", at="fire-a")
    assert abs(float(found["period_time"]) - 2 * (1 - phase)) < 1e-14
    exact = [np.exp(2 * leak * (2 * phase - 1)), 1.0]
    assert np.abs(found["multiplier_real"].values - exact).max() < 1e-13
