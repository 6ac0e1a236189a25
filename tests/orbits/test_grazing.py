"""What a grazing point does, against exact flows of linear oscillators and simulations beyond it."""

import numpy as np
import pytest
from scipy.optimize import brentq

import chaosdrill as cd
from chaosdrill.dataset.branches import Onset, Special


class Oscillator:
    """x'' + 2 zeta x' + stiffness x = force + size cos(omega t), and its periodic motion; all exact."""

    def __init__(self, omega, zeta, size=1.0, stiffness=1.0, force=0.0):
        self.omega, self.rest = omega, force / stiffness
        self.response = size / (stiffness - omega**2 + 2j * zeta * omega)
        root = np.sqrt(complex(zeta**2 - stiffness))
        self.rates = -zeta + root, -zeta - root

    def forced(self, t):
        turning = self.response * np.exp(1j * self.omega * t)
        return np.array([self.rest + turning.real, (1j * self.omega * turning).real])

    def at(self, state, start, t):
        (x, v), (a, b) = state - self.forced(start), self.rates
        one = (v - b * x) / (a - b)
        parts = one * np.exp(a * (t - start)), (x - one) * np.exp(b * (t - start))
        return self.forced(t) + np.array([sum(parts).real, (a * parts[0] + b * parts[1]).real])

    @property
    def height(self):
        return abs(self.response)

    @property
    def top(self):
        """Time of the greatest displacement."""
        return -np.angle(self.response) / self.omega

    def after(self, time):
        """Displacement by a unit of velocity, a time later."""
        return (self.at(np.array([0.0, 1.0]), 0.0, time) - self.at(np.zeros(2), 0.0, time))[0]


def grazing_point(system, oscillator, **given):
    """The point at which the periodic motion grazes a wall that comes nearer."""
    w = oscillator.height
    x, v = oscillator.forced(0.0)
    system = system.with_parameters(wall=1.01 * w, **given).with_initial(x=x, v=v)
    branch = cd.continue_orbit(system, {"wall": (0.99 * w, 1.015 * w)}, start="guess", step=0.004 * w, max_points=40)
    found = branch.isel(special=np.flatnonzero(branch["special_kind"].values == Special.GRAZING)[:1]).squeeze("special")
    assert float(found["special_value"]) == pytest.approx(w, rel=1e-12)
    return found


def impacting(omega, zeta, size=1.0, e=0.8):
    system = cd.build("impact-oscillator").with_parameters(omega=omega, zeta=zeta, amplitude=size, e=e)
    return grazing_point(system, Oscillator(omega, zeta, size))


DAMPED = np.sqrt(1 - 0.05**2)


@pytest.mark.parametrize(("omega", "size"), [(2.5, 1.0), (1.7, 1e-4), (0.8, 1e3), (2 * DAMPED, 1.0), (4 * DAMPED, 1.0)])
def test_the_square_root_of_an_impact_in_closed_form(omega, size):
    found, one, time = impacting(omega, 0.05, size), Oscillator(omega, 0.05, size), 2 * np.pi / omega
    heights = [-1.8 * np.sqrt(2 * one.height) * omega * one.after(k * time) for k in (1, 2, 3, 4, 5)]
    assert float(found["special_power"]) == 0.5
    error = float(found["grazing_coefficient_error"])
    assert abs(float(found["grazing_coefficient"]) - heights[0]) <= error < 1e-8 * np.sqrt(size)
    # resonances of the damped frequency: the second turn, or the first one, has no square root (arXiv:2602.22797)
    resonant = [k for k in (1, 2, 3, 4, 5) if abs(heights[k - 1]) < 1e-12 * np.sqrt(size)]
    above = [k for k in (1, 2, 3, 4, 5) if heights[k - 1] > 1e-12 * np.sqrt(size)]
    expected = Onset.UNDECIDED if resonant and resonant[0] < min(above, default=9) else Onset.JUMP
    assert int(found["special_onset"]) == expected
    assert int(found["special_return"]) == min(resonant + above)


def exponents(omega, zeta, distances):
    """Largest exponents of the attractor at walls within the orbit's reach."""
    one = Oscillator(omega, zeta)
    system = cd.build("impact-oscillator").with_parameters(omega=omega, zeta=zeta)
    walls = one.height * (1 - np.asarray(distances))
    x, v = one.forced(0.0)
    found = cd.bifurcation_diagram(system.with_initial(x=x, v=v), {"wall": walls}, transient=3000, periods=512)
    return found["lyapunov_exponent"].isel(exponent=0).values.ravel(), found["period"].values.ravel()


@pytest.mark.parametrize(
    ("period", "zeta", "onset"),
    [(4.0, 1.2, Onset.PERIOD_ADDING), (1.0, 1.2, Onset.PERIOD_ADDING_CHAOS), (0.5, 3.0, Onset.CHAOS)],
)
def test_the_larger_multiplier_decides_what_an_overdamped_oscillator_does(period, zeta, onset):
    """Multipliers 0.117, 0.585 and 0.918, on either side of 1/4 and 2/3."""
    omega = 2 * np.pi / period
    found = impacting(omega, zeta)
    assert int(found["special_onset"]) == onset
    if onset != Onset.PERIOD_ADDING_CHAOS:
        largest, periods = exponents(omega, zeta, 10.0 ** -np.arange(2.5, 4.6, 0.3))
        assert (largest > 0).all() if onset == Onset.CHAOS else ((largest < 0).all() and len(set(periods.tolist())) > 1)


def stop(force, **parameters):
    free = "-x-2*zeta*v+cos(omega*t)"
    return cd.HybridSystem(
        name="stop", states=("x", "v"), time="t",
        parameters={"zeta": 0.05, "omega": 2.5, "wall": 1.0, **parameters},
        modes={"free": {"x": "v", "v": free}, "contact": {"x": "v", "v": f"{free}-{force}"}},
        transitions=[
            cd.Transition("hit", "free", "contact", guard="x-wall", direction=1),
            cd.Transition("off", "contact", "free", guard="x-wall", direction=-1),
        ],
        period="2*pi/omega", initial={"mode": "free", "x": 0.0, "v": 0.0},
    )  # fmt: skip


def next_height(omega, y, stiff, push):
    """Greatest displacement over the wall, a period after one that would be y without the stop."""
    free = Oscillator(omega, 0.05)
    wall, top, period = free.height, free.top, 2 * np.pi / omega
    inside = Oscillator(omega, 0.05, 1.0, 1 + stiff, stiff * wall - push)
    early = np.sqrt(2 * y / (omega**2 * wall))
    high = np.array([wall + y, 0.0])
    begin = brentq(lambda t: free.at(high, top, t)[0] - wall, top - 1.5 * early, top, xtol=1e-16)
    hit = free.at(high, top, begin)
    end = brentq(lambda t: inside.at(hit, begin, t)[0] - wall, begin + 0.2 * early, begin + 3 * early, xtol=1e-16)
    off = inside.at(hit, begin, end)
    peak = brentq(lambda t: free.at(off, end, t)[1], top + 0.9 * period, top + 1.1 * period, xtol=1e-15)
    return free.at(off, end, peak)[0] - wall


@pytest.mark.parametrize(("push", "power"), [(0.0, 1.5), (2.0, 0.5)])
def test_another_field_behind_the_guard_against_least_squares_from_exact_flows(push, power):
    omega, stiff = 2.5, 20.0
    found = grazing_point(stop("(push+stiff*(x-wall))", stiff=stiff, push=push), Oscillator(omega, 0.05))
    one = Oscillator(omega, 0.05)
    y = np.geomspace(1e-7, 1e-4, 12) * one.height
    own = np.array([next_height(omega, one_y, stiff, push) for one_y in y])
    # without the stop the next height is known, too
    turn = np.exp(-0.05 * 2 * np.pi / omega)
    angle = DAMPED * 2 * np.pi / omega
    smooth = turn * (np.cos(angle) + 0.05 / DAMPED * np.sin(angle)) * y
    terms = np.array([y ** (power + k / 2) for k in range(4)]).T
    scale = np.abs(terms).max(axis=0)
    fitted = (np.linalg.lstsq(terms / scale, own - smooth, rcond=None)[0] / scale)[0]
    assert float(found["special_power"]) == power
    assert float(found["grazing_coefficient"]) == pytest.approx(fitted, rel=2e-4 if push == 0 else 1e-5)
    assert int(found["special_onset"]) == (Onset.CONTINUOUS if push == 0 else Onset.JUMP)


@pytest.mark.parametrize("step", [0.004, 0.01])
def test_a_run_is_not_asked_about_an_orbit_that_hardly_misses_the_guard(step):
    one = Oscillator(2.5, 0.05)
    w, (x, v) = one.height, one.forced(0.0)
    system = stop("(push+stiff*(x-wall))", stiff=20.0, push=0.0, wall=1.01 * w).with_initial(x=x, v=v)
    branch = cd.continue_orbit(system, {"wall": (0.97 * w, 1.015 * w)}, start="guess", step=step * w)
    assert branch["special_kind"].values.tolist() == [Special.PERIOD_DOUBLING, Special.GRAZING]
    assert branch.attrs["message"] == ""


def test_resonances_on_a_curve_of_grazing_points():
    """Returns have no square root at four (the second), three (the third) and two times the damped frequency."""
    omega, one = 3.6, Oscillator(3.6, 0.05)
    x, v = one.forced(0.0)
    system = cd.build("impact-oscillator").with_parameters(omega=omega, wall=1.01 * one.height).with_initial(x=x, v=v)
    curve = cd.continue_orbit(
        system, {"wall": (0.05, 0.6), "omega": (1.8, 4.2)}, follow="grazing", start="guess", step=0.02
    )
    found = np.flatnonzero(curve["special_kind"].values == Special.RESONANT_GRAZING)
    expected = np.array([4 * DAMPED, 3 * DAMPED, 2 * DAMPED])
    assert len(found) == len(expected)
    assert np.abs(np.sort(curve["special_value_2"].values[found])[::-1] - expected).max() < 1e-10
