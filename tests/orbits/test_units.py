"""Branches in other units: one state that is a million times as large moves no special point and hides none."""

from dataclasses import replace

import numpy as np
import pytest

import chaosdrill as cd
from chaosdrill.dataset.branches import Special
from chaosdrill.engine.numerics import Numerics
from chaosdrill.orbits.find import starting_orbit
from chaosdrill.orbits.multipliers import largest_growth
from chaosdrill.orbits.place import Place, characteristic_time
from chaosdrill.orbits.sizes import sizes_beside, sizes_met
from chaosdrill.orbits.verification import check, describe, verify

BY_METHOD = [("taylor", 1e-8), ("dop853", 1e-12), ("dop853", 1e-13), ("radau", 1e-13)]


def specials(branch):
    return [branch[name].values for name in ("special_kind", "special_value", "special_error")]


def contact(unit):
    """A damper of its own behind a spring that is met; z in another unit."""
    free = {"x": "v", "v": "-x-2*zeta*v+cos(omega*t)-c*z/unit", "z": "-z+unit*v"}
    pressed = {"x": "v", "v": "-x-2*zeta*v-k*(x-gap)+cos(omega*t)-c*z/unit", "z": "-2*z+unit*x"}
    return cd.HybridSystem(
        states="x v z",
        parameters={"zeta": 0.113, "omega": 1.893, "k": 4.477, "gap": 0.132, "c": 0.283, "unit": unit},
        modes={"free": free, "pressed": pressed},
        transitions=[
            cd.Transition("on", "free", "pressed", guard="x-gap", direction=1),
            cd.Transition("off", "pressed", "free", guard="x-gap", direction=-1),
        ],
        period="2*pi/omega",
        initial={"v": 0.3},
    )


def stop(unit):
    """A spring that is met; v in another unit."""
    free = {"x": "v/unit", "v": "unit*(-x-2*zeta*v/unit+cos(omega*t))"}
    pressed = {"x": "v/unit", "v": "unit*(-x-2*zeta*v/unit-k*(x-gap)+cos(omega*t))"}
    return cd.HybridSystem(
        states="x v",
        parameters={"zeta": 0.051, "omega": 1.979, "k": 20.986, "gap": 0.59, "unit": unit},
        modes={"free": free, "pressed": pressed},
        transitions=[
            cd.Transition("on", "free", "pressed", guard="x-gap", direction=1),
            cd.Transition("off", "pressed", "free", guard="x-gap", direction=-1),
        ],
        period="2*pi/omega",
        initial={"v": 0.3 * unit},
    )


@pytest.mark.parametrize(("build", "span"), [(contact, (1.85, 2.33)), (stop, (1.6, 2.0))])
def test_special_points_are_the_same_ones(build, span):
    usual = specials(cd.continue_orbit(build(1.0), {"omega": span}, transient=60))
    assert len(usual[0])
    for unit in (1e6, 1e-6):
        kinds, values, errors = specials(cd.continue_orbit(build(unit), {"omega": span}, transient=60))
        np.testing.assert_array_equal(kinds, usual[0])
        assert (np.abs(values - usual[1]) <= 2 * np.hypot(errors, usual[2])).all()
        assert (errors < 1e3 * usual[2]).all()


@pytest.mark.parametrize("unit", [1.0, 1e3, 1e6])
@pytest.mark.parametrize("tolerance", [1e-13, 1e-10])
def test_events_fall_together_where_the_closed_form_has_it(unit, tolerance):
    system = cd.HybridSystem(
        states="x v",
        parameters={"zeta": 0.044, "omega": 2.157, "e": 0.517, "w": 0.128, "unit": unit},
        modes={"free": {"x": "v/unit", "v": "unit*(-x-2*zeta*v/unit+cos(omega*t))"}},
        transitions=[
            cd.Transition("hit", "free", "free", guard="x-w", direction=1, reset={"v": "-e*v"}),
            cd.Transition("kick", "free", "free", guard="sin(omega*t-1)", direction=1, reset={"v": "v+unit/10"}),
        ],
        period="2*pi/omega",
        initial={"v": 0.3 * unit},
    )
    branch = cd.continue_orbit(system, {"omega": (1.7256, 2.2)}, transient=60, tolerance=tolerance)
    _, values, errors = specials(branch)
    # linear flow between the kick and the impact that follows it at once, in 60 digits
    assert abs(values[0] - 1.78568736229855407673) <= 2 * errors[0] < 1e4 * tolerance


@pytest.mark.parametrize("time", ["(1)", "(10**-6)"])
def test_a_section_at_an_event_loses_no_multiplier(time):
    """The determinant of a linear oscillator's round with one impact is e^2 exp(-2 zeta T)."""
    rate, place = "(10**6)", f"(10**-6)*{time}"
    system = cd.HybridSystem(
        states="x v",
        parameters={"zeta": 0.039, "omega": 2.26, "e": 0.57, "w": 0.031},
        modes={"free": {"x": f"{place}*v/{rate}", "v": f"{rate}*(-x/({place})-2*zeta*v/{rate}+cos(omega*t))"}},
        transitions=[cd.Transition("hit", "free", "free", guard=f"x/({place})-w", direction=1, reset={"v": "-e*v"})],
        period="2*pi/omega",
        initial={"v": 3e5},
    )
    section = cd.poincare_section(system, periods=64, transient=100, at="hit")
    found = np.prod(section["multiplier_real"].values + 1j * section["multiplier_imag"].values)
    assert found == pytest.approx(0.57**2 * np.exp(-2 * 0.039 * 2 * np.pi / 2.26), rel=1e-9)


def test_an_event_loses_its_speed_at_one_parameter_by_every_method():
    """A run cannot tell impacts slower than the root of round-off from none; the equations can."""
    system = cd.HybridSystem(
        states="x v z y",
        parameters={"zeta": 0.144, "omega": 3.2, "e": 0.423, "w": 0.111, "c": 0.35, "b": 1.809, "d": 0.812},
        modes={
            "free": {
                "x": "v",
                "v": "-x-2*zeta*v+cos(omega*t)+c*z-0.1*y",
                "z": "-b*z+x*v",
                "y": "-d*y+sin(x)*z",
            }
        },
        transitions=[cd.Transition("hit", "free", "free", guard="x-w", direction=1, reset={"v": "-e*v"})],
        period="2*pi/omega",
        initial={"v": 0.3},
    )
    found = {}
    for method, tolerance in BY_METHOD:
        branch = cd.continue_orbit(
            system, {"omega": (3.15, 3.2825)}, transient=60, max_points=300, method=method, tolerance=tolerance
        )
        _, values, errors = specials(branch)
        found[method, tolerance] = values[-1], errors[-1]
    value, error = found.pop(BY_METHOD[0])
    for other, its in found.values():
        assert abs(value - other) <= 2 * np.hypot(error, its)
    # those that are known to 1e-12 agree to that
    values = [other for other, _ in found.values()]
    assert np.ptp(values) < 1e-11


def duffing(**units):
    """A double well that is driven, with the units of position, speed, time and damping as parameters."""
    return cd.HybridSystem(
        states="x v",
        parameters={"d": 0.2 * units.get("P", 1.0), "w": 1.0, "A": 0.2, "X": 1.0, "V": 1.0, "T": 1.0, "P": 1.0} | units,
        modes={"on": {"x": "X*v/V/T", "v": "V*(x/X - (x/X)**3 - d/P*v/V + A*cos(w*t/T))/T"}},
        period="2*pi*T/w",
        initial={"x": units.get("X", 1.0)},
    )


@pytest.mark.parametrize("follow", ["fold", "period_doubling"])
def test_a_curve_is_the_same_one(follow):
    def points(**units):
        damping = units.get("P", 1.0)
        found = cd.continue_orbit(
            duffing(**units), {"A": (0.1, 0.5), "d": (0.1 * damping, 0.5 * damping)}, follow=follow, step=0.02
        )
        return np.column_stack([found["A"], found["d"] / damping])

    usual = points()
    assert len(usual) > 20
    for units in ({"X": 1e6, "V": 1e-6, "T": 1e-6}, {"V": 1e-6, "P": 1e6}):
        np.testing.assert_allclose(points(**units), usual, rtol=1e-8)


def striking(**units):
    """An impact oscillator; G is the unit of its guard."""
    return cd.HybridSystem(
        states="x v",
        parameters={"zeta": 0.05, "omega": 2.8, "wall": 0.3, "e": 0.8} | dict.fromkeys("XVTG", 1.0) | units,
        modes={"free": {"x": "X*v/V/T", "v": "V*(-x/X - 2*zeta*v/V + cos(omega*t/T))/T"}},
        transitions=[
            cd.Transition("impact", "free", "free", guard="G*(x/X - wall)", direction=+1, reset={"v": "-e*v"})
        ],
        period="2*pi*T/omega",
        initial={"v": 0.3 * units.get("V", 1.0)},
    )


def test_what_counts_as_grazing_is_relative_to_the_motion():
    usual = cd.continue_orbit(striking(), {"omega": (2.0, 3.2)})
    unknown = np.isnan(usual["multiplier_real"].values).sum()
    for units in ({"G": 1e-12}, {"G": 1e12}, {"X": 1e-6, "T": 1e3}):
        found = cd.continue_orbit(striking(**units), {"omega": (2.0, 3.2)})
        assert np.isnan(found["multiplier_real"].values).sum() == unknown
        assert found.sizes["point"] == usual.sizes["point"]
        np.testing.assert_array_equal(specials(found)[0], specials(usual)[0])


@pytest.mark.parametrize("unit", [1e-12, 1.0, 1e12])
def test_wrong_multipliers_are_told_whatever_the_unit_of_the_guard(unit):
    problem, orbit, shot, residuals, _ = starting_orbit(
        striking(G=unit, zeta=0.0, omega=2.6, wall=0.0), (), 1, "attractor", 200, Numerics()
    )
    found = describe(problem, orbit, shot, residuals)
    assert len(found.event_times) == 1
    assert found.checks.consistent
    wrong = replace(found, multipliers=1.001 * found.multipliers)
    assert not check(problem, orbit, wrong, verify(problem, orbit)).consistent


@pytest.mark.parametrize("unit", [1e-9, 1e-6, 1.0, 1e6])
def test_an_orbit_without_forcing_in_any_unit_of_time(unit):
    """The period of van der Pol's oscillator is 6.6632868593231301897 at mu = 1."""
    system = cd.HybridSystem(
        states="x v",
        parameters={"mu": 1.0, "T": unit},
        modes={"on": {"x": "v/T", "v": "(mu*(1 - x**2)*v - x)/T"}},
        initial={"x": 0.5},
    )
    branch = cd.continue_orbit(system, {"mu": (0.8, 1.2)}, transient=60 * unit)
    time = np.interp(1.0, branch["mu"].values, branch["period_time"].values)
    orbit = cd.periodic_orbit(system, transient=60 * unit)
    assert float(orbit["period_time"]) == pytest.approx(6.66328685932313 * unit, rel=1e-11)
    assert time == pytest.approx(6.66328685932313 * unit, rel=1e-4)


def test_a_state_that_stays_zero_is_as_large_as_what_changes_the_events_of_a_forced_motion():
    """x is sin(2 pi t), so that y meets a border at half."""
    hit = cd.Transition("hit", "on", "on", "x + y - 1.5", +1, reset={"x": "x - 1"})
    modes = {"on": {"x": "2*pi*cos(2*pi*t)", "y": "0"}}
    system = cd.HybridSystem(states="x y", modes=modes, transitions=[hit], time="t", period="1")
    sizes = sizes_beside(system, Numerics(), np.array([1.0, 0.0]), 1.0)
    assert sizes == pytest.approx([1.0, 0.5], rel=1e-4)


def test_a_forced_motion_that_stalls_has_the_sizes_of_its_whole_way():
    """A ball falls from 3 onto a moving table, and its rebounds die out there."""
    hit = cd.Transition("hit", "air", "air", "h - 1.3*(1 + sin(t))", -1, reset={"v": "-v/2 + 1.95*cos(t)"})
    modes = {"air": {"h": "v", "v": "-1"}}
    system = cd.HybridSystem(states="h v", modes=modes, transitions=[hit], time="t", period="2*pi", initial={"h": 3.0})
    assert cd.trajectory(system, periods=20).cd.outcome == "stalled"
    height, speed = sizes_met(system, Numerics(), float(2 * np.pi))
    assert 3.0 <= height < 10.0
    assert 1.0 < speed < 10.0


@pytest.mark.parametrize(("unit", "at"), [(1e-3, "y > 0"), (300.0, "x > 0.1")])
def test_a_branch_without_events_is_whole_in_any_unit_of_one_state(unit, at):
    """Circles of radius sqrt(mu): the plane on which they begin may not come to contain the flow."""
    system = cd.HybridSystem(
        states="x y",
        parameters={"mu": 0.5, "k": unit},
        modes={"on": {"x": "mu*x - y/k - x*(x**2 + (y/k)**2)", "y": "k*x + mu*y - y*(x**2 + (y/k)**2)"}},
        initial={"x": 0.5},
    )
    branch = cd.continue_orbit(system, {"mu": (0.2, 0.6)}, transient=50, at=at)
    assert branch["mu"].values[[0, -1]].tolist() == [0.2, 0.6]
    radius = np.hypot(*(branch["orbit_state"].values / [1.0, unit]).T)
    np.testing.assert_allclose(radius, np.sqrt(branch["mu"].values), rtol=1e-10)


WIDE = {"x": (-1e300, 1e300)}
PARAMETERS = {"r": 0.8, "unit": 1.0}


def turned_off():
    """A map that loses its symmetry where r is 1."""
    return cd.Map(states="x", parameters=PARAMETERS, images={"x": "unit*tanh(r*x/unit)"}, bounds=WIDE)


def driven():
    """A flow that does so where the mean of what drives it is 1."""
    modes = {"m": {"x": "-x + unit*tanh(r*x/unit)*(1 + cos(t)/2)"}}
    return cd.HybridSystem(states="x", parameters=PARAMETERS, modes=modes, period="2*pi", bounds=WIDE, time="t")


@pytest.mark.parametrize("build", [turned_off, driven])
def test_a_state_that_stays_zero_bifurcates_in_any_unit(build):
    system, known = build(), None
    for unit in (1.0, 1e-170, 1e-12, 1e12, 1e150):
        found = cd.continue_orbit(
            system.with_parameters(unit=unit), {"r": (0.6, 1.3)}, start="guess", doublings=1, step=0.02
        )
        assert found["special_kind"].values.tolist() == [Special.BRANCH_POINT]
        assert abs(found["special_value"].item() - 1) <= found["special_error"].item()
        assert found["branch_parent"].values.tolist() == [-1, 0, 0]
        told = np.array([found["special_coefficient"].item(), np.abs(found["orbit_state"].values).max() / unit])
        known = told if known is None else known
        np.testing.assert_allclose(told, known, rtol=1e-4)


def test_how_fast_a_motion_is_does_not_depend_on_the_unit_of_its_states():
    modes = {"m": {"x": "y", "y": "-x - y/2 + unit*tanh(y/unit)"}}
    system = cd.HybridSystem(states="x y", parameters={"unit": 1.0}, modes=modes, bounds=dict.fromkeys("xy", WIDE["x"]))
    numerics, times = Numerics(), []
    for unit in (1.0, 1e-170, 1e160):
        place = Place(system.with_parameters(unit=unit).with_initial(x=unit, y=0.0))
        times.append(characteristic_time(place, numerics))
    assert times[1:] == pytest.approx(times[:1] * 2, rel=1e-9)


def test_states_in_units_far_apart_that_stay_zero_lose_no_rank():
    """A pair of multipliers passes the unit circle where r is 1."""
    images = {"x": "r*(x/2 - 5*y/6*1e14) - x**3*1e-10", "y": "r*(y/2 + x*3/4*1e-14*6/5) - y**3*1e18"}
    spiral = cd.Map(states="x y", parameters={"r": 0.9}, images=images)
    found = cd.continue_orbit(spiral, {"r": (0.8, 1.2)}, start="guess", step=0.02)
    assert found["special_kind"].values.tolist() == [Special.NEIMARK_SACKER]
    assert found["special_multiplicity"].item() == 2
    assert abs(found["special_value"].item() - 1) <= found["special_error"].item()


@pytest.mark.parametrize("unit", [1e-8, 1.0, 1e8])
def test_what_deviations_grow_by_is_the_same_in_any_unit(unit):
    """Beside a circle they keep their angle and lose their radius, and nothing grows; it was 1e8 in such units."""
    system = cd.HybridSystem(
        states="x y",
        parameters={"u": unit},
        modes={"on": {"x": "x*(1 - (x/u)**2 - y**2)/4 - u*y", "y": "y*(1 - (x/u)**2 - y**2)/4 + x/u"}},
        initial={"x": unit},
    )
    problem, orbit, *_ = starting_orbit(system, (), 1, "guess", 0, Numerics())
    assert largest_growth(problem, orbit) < 2
