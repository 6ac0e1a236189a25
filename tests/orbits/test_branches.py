"""Branches and what happens on them, against closed forms."""

import math

import numpy as np
import pytest
import sympy
from mpmath import mp
from scipy.integrate import solve_ivp
from support import wall_at_rest as wall
from support.wall_at_rest_cascade import DOUBLINGS, RATIOS, doublings

import chaosdrill as cd
from chaosdrill.dataset.branches import BranchEnd, Criticality, Special
from chaosdrill.engine.numerics import Numerics
from chaosdrill.orbits.branches import branches
from chaosdrill.orbits.crossings import changes, noise_of, outside, pair_on_circle, torus_test
from chaosdrill.systems import build

x, v, y, t = sympy.symbols("x v y t", real=True)


# Branches of the impact oscillator with its wall at rest, against its closed forms and its cascade in 45 digits.


R = 0.8


@pytest.fixture(scope="module")
def system():
    """Started beside the orbit with one impact a period, away from the other attractors there."""
    return build("impact-oscillator", {"wall": 0.0, "zeta": 0.0, "omega": 2.64, "e": R}, {}).with_initial(
        x=-0.615, v=0.0178
    )


@pytest.fixture(scope="module")
def cascade(system):
    return branches(system, "omega", (2.55, 2.76), 1, "attractor", 300, 5, 0.0015, 150, Numerics(), None)


def test_trace_and_determinant_follow_their_closed_forms(cascade, digits):
    digits(30)
    first = np.flatnonzero(cascade.branch == 0)
    assert len(first) > 100
    for k in first[:: len(first) // 40]:
        known = wall.period_one(cascade.values[k, 0], R)
        product, total = cascade.multipliers[k].prod(), cascade.multipliers[k].sum()
        assert abs(total - float(known.trace)) < 1e-11
        assert abs(product - float(known.determinant)) < 1e-11
        assert abs(cascade.smallest_speed[k] - float(known.speed)) < 1e-11


def test_the_first_doubling_is_where_the_closed_form_has_it(cascade, digits):
    digits(30)
    assert abs(cascade.cascade.values[0] - float(wall.doubling(mp.mpf("0.8"), 2.65))) < 1e-12


def test_the_cascade_in_45_digits_is_what_its_program_finds(digits):
    digits(24)
    for found, known in zip(doublings(4), DOUBLINGS, strict=False):
        assert abs(found.w - mp.mpf(known)) < 1e-16


def test_five_further_doublings_are_those_of_the_exact_flow(cascade):
    assert cascade.cascade.periods.tolist() == [1, 2, 4, 8, 16, 32]
    assert np.abs(cascade.cascade.values - [float(w) for w in DOUBLINGS[:6]]).max() < 1e-10
    found = cascade.cascade.ratios[2:]
    # the gap between two doublings, as exact as they are, divides
    errors = 1e-10 * np.array(RATIOS[:4]) / np.diff(cascade.cascade.values)[1:]
    assert (np.abs(found - RATIOS[:4]) < errors + 1e-8).all()
    assert abs(found[-1] - 4.669201609) < 0.02


def test_a_long_cascade_is_followed_to_the_limits(system):
    """Far beyond its doublings a branch needs no steps as short as between them, and no more multipliers are outside.

    One multiplier grows to 1e14, the other is R^(2 n) over it: 64 impacts leave it no digit in the map.
    """
    found = branches(system, "omega", (2.55, 2.76), 1, "attractor", 300, 6, 0.004, 1000, Numerics(), None)
    known = [float(w) for w in DOUBLINGS[:7]]
    assert np.abs(found.cascade.values[: len(known)] - known).max() < 1e-10
    assert [one.end_code for one in found.branches] == [BranchEnd.LIMIT] * 7
    assert not found.message


def test_the_limit_is_as_exact_as_it_says(cascade):
    beyond = float(DOUBLINGS[-1])
    limit = beyond + (beyond - float(DOUBLINGS[-2])) / (4.669201609 - 1)
    assert abs(cascade.cascade.limit - limit) < cascade.cascade.limit_error < 1e-5


def test_each_doubling_has_the_multiplier_minus_one(cascade):
    for event in cascade.events:
        if event.code == Special.PERIOD_DOUBLING:
            assert np.abs(cascade.multipliers[event.point] + 1).min() < 1e-8


def test_orbits_are_stable_up_to_their_doubling_and_unstable_beyond(cascade):
    first = cascade.branch == 0
    values = cascade.values[first, 0]
    regular = cascade.special[first] == Special.REGULAR
    assert (cascade.stable[first] == (values < float(DOUBLINGS[0])))[regular].all()


def test_multipliers_of_an_orbit_multiply_to_what_its_impacts_leave(cascade):
    # one grows to 1e8 and the other is known to its own digits
    assert np.abs(cascade.multipliers).max() > 1e6
    for period in np.unique(cascade.period):
        known = R ** (2.0 * period)
        assert np.abs(cascade.multipliers[cascade.period == period].prod(axis=1) - known).max() < 1e-8 * known


def test_both_ends_are_the_limits(cascade):
    ends = cascade.values[cascade.branch == 0, 0][[0, -1]]
    assert cascade.branches[0].end_code == BranchEnd.LIMIT
    assert ends.tolist() == [2.55, 2.76]


def test_no_doubling_is_jumped_over_where_the_range_is_narrow(system):
    start = system.with_parameters(omega=2.7285)
    found = branches(start, "omega", (2.728, 2.732), 4, "attractor", 600, 3, 2e-5, 300, Numerics(), None)
    assert found.cascade.periods.tolist() == [4, 8, 16, 32]
    assert np.abs(found.cascade.values - [float(w) for w in DOUBLINGS[2:6]]).max() < 1e-10


# Multipliers that pass through 1 without a fold, branches that shrink onto rest, and hits that are the only ones.


def follow(system, parameter, limits, start="attractor", doublings=0):
    step = (limits[1] - limits[0]) / 200
    return branches(system, parameter, limits, 1, start, 300, doublings, step, 2000, Numerics(), None)


@pytest.fixture(scope="module")
def cubic():
    """y := k y - y^3 once a period: y = 0, and beyond k = 1 the two orbits y^2 = k - 1 of multiplier 3 - 2 k."""
    k = sympy.Symbol("k", real=True)
    jump = cd.Transition("jump", "rest", "rest", guard=sympy.sin(t), direction=1, reset={y: k * y - y**3})
    return cd.HybridSystem(
        name="cubic", states=(y,), time=t, parameters={"k": 1.5}, modes={"rest": {y: 0}}, transitions=[jump],
        period=2 * sympy.pi, initial={"mode": "rest", y: 0.5},
    )  # fmt: skip


def test_a_pitchfork_is_no_fold(cubic):
    result = follow(cubic, "k", (0.2, 2.5))
    crossings = [e for e in result.events if e.code == Special.BRANCH_POINT]
    assert [abs(e.values[0] - 1) < e.error < 1e-7 for e in crossings] == [True]
    assert not any(e.code == Special.FOLD for e in result.events)
    doublings = [e.values[0] for e in result.events if e.code == Special.PERIOD_DOUBLING]
    assert np.abs(np.array(doublings) - 2).max() < 1e-12
    regular = result.special == Special.REGULAR
    assert np.abs(result.multipliers[:, 0].real - (3 - 2 * result.values[:, 0]))[regular].max() < 1e-9


def test_a_symmetric_branch_says_where_it_loses_its_stability(cubic):
    result = follow(cubic.with_initial(y=0.0), "k", (0.3, 2.5), start="guess")
    crossings = [e for e in result.events if e.code == Special.BRANCH_POINT]
    assert [abs(e.values[0] - 1) < 1e-12 for e in crossings] == [True]
    assert (result.stable == (np.abs(result.values[:, 0]) < 1))[result.special == 0].all()


def test_a_cycle_that_shrinks_onto_rest_ends_there():
    """The normal form of a Hopf bifurcation at m = 0; the cycle has the radius sqrt(m)."""
    m = sympy.Symbol("m", real=True)
    square = x**2 + v**2
    field = {x: m * x - v - x * square, v: x + m * v - v * square}
    system = cd.HybridSystem(name="hopf", states=(x, v), parameters={"m": 1.0}, modes={"flow": field}, initial={x: 0.5})
    result = follow(system, "m", (-1.0, 2.0))
    (rest,) = result.events
    assert rest.text in result.branches[0].end
    assert (rest.code, rest.form.criticality) == (Special.HOPF, Criticality.SUPERCRITICAL)
    assert abs(rest.values[0]) <= rest.error < 1e-12
    radius = np.hypot(result.section[:, 0, 0], result.section[:, 0, 1])
    assert np.abs(radius**2 - result.values[:, 0]).max() < 1e-10


def test_the_lorenz_cycle_has_no_fold_between_its_homoclinic_orbit_and_40():
    system = build("lorenz", {}, {}).with_initial(x=-13.763610682134, y=-19.578751942452, z=27.0)
    result = branches(system, "rho", (15.0, 40.0), 1, "guess", 0, 0, 0.25, 2000, Numerics(), None)
    assert not len(result.events)
    assert result.values[[0, -1], 0].tolist() == [15.0, 40.0]
    assert np.abs(result.multipliers - 1).min(axis=1).max() < 1e-8


def test_the_only_hit_of_an_orbit_may_vanish():
    """Both ways from resonance the response leaves the wall where its amplitude is the wall's distance."""
    zeta, wall = 0.1, 1.2
    system = build("impact-oscillator", {"wall": wall, "zeta": zeta, "omega": 0.7}, {})
    result = follow(system, "omega", (0.3, 3.0), doublings=1)
    h = 1 - 2 * zeta**2
    exact = [math.sqrt(h + sign * math.sqrt(h * h - 1 + 1 / wall**2)) for sign in (-1, 1)]
    grazing = [e for e in result.events if e.code == Special.GRAZING and result.branch[e.point] == 0]
    assert len(grazing) == 2
    assert np.abs(np.sort([e.values[0] for e in grazing]) - exact).max() < 1e-9
    first = result.branch == 0
    assert result.values[first, 0].min() == 0.3
    assert result.values[first, 0].max() == 3.0
    # an orbit that is told as one of twice the period is none of the period itself
    doubled = (result.period == 2) & (result.special == Special.REGULAR)
    assert np.abs(result.section[doubled, 0] - result.section[doubled, 1]).max(axis=1).min() > 1e-6


def test_one_state_is_enough():
    k = sympy.Symbol("k", real=True)
    fire = cd.Transition("fire", "m", "m", guard=y - 1, direction=1, reset={y: 0})
    system = cd.HybridSystem(
        name="integrate-and-fire", states=(y,), parameters={"k": 2.0}, modes={"m": {y: k - y}}, transitions=[fire]
    )
    result = follow(system, "k", (1.5, 3.0))
    assert result.values[[0, -1], 0].tolist() == [1.5, 3.0]
    assert not len(result.events)


# Neimark-Sacker points are found whatever other multipliers are near to the unit circle.


def test_a_slow_real_multiplier_hides_no_pair():
    """x'' + p x' + x = cos(w t)/10 turns unstable at p = 0, with |mu| = exp(-p T/2); beside it z decays slowly."""
    x, v, z, t, p, w, k = sympy.symbols("x v z t p w k", real=True)
    system = cd.HybridSystem(
        name="slow-beside", states=(x, v, z), time=t, parameters={"p": 0.2, "w": 1.7, "k": 1e-7},
        modes={"on": {x: v, v: -p * v - x + sympy.cos(w * t) / 10, z: -k * z}}, period=2 * sympy.pi / w,
        initial={"mode": "on"},
    )  # fmt: skip
    result = branches(system, "p", (-0.5, 0.5), 1, "attractor", 200, 0, 0.02, 200, Numerics(), None)
    assert [e.code for e in result.events] == [Special.NEIMARK_SACKER]
    assert abs(result.events[0].values[0]) < 1e-12
    assert (result.stable == (result.values[:, 0] > 0))[result.special == Special.REGULAR].all()


@pytest.mark.parametrize("others", [[], [0.0], [0.0, 0.0, 0.9999], [0.9999, -0.9999, 1.0001]])
def test_the_sign_changes_with_the_pair_alone(others):
    values = [np.array([r * np.exp(1j), r * np.exp(-1j), *others]) for r in (0.999, 1.001)]
    assert torus_test(values[0]) * torus_test(values[1]) < 0
    assert outside(values[1]) - outside(values[0]) == 2
    assert pair_on_circle(values[0]) == pytest.approx(1e-3)


def test_two_real_multipliers_are_no_pair():
    assert pair_on_circle(np.array([2.0, 0.5], dtype=complex)) == np.inf


# A fold and a period doubling between the same two points of a branch are both located.


def test_multipliers_at_special_points_are_what_their_names_say(drill):
    """At 0.58658 a fold and a doubling of the drill's orbit of period 2 are 1e-6 apart, in steps of 0.02."""
    branch = cd.continue_orbit(drill.with_parameters(eta=0.6), {"eta": (0.56, 0.62)}, period=2, step=0.02)
    points, kinds = branch["special_index"].values, branch["special_kind"].values
    multipliers = branch["multiplier_real"].values + 1j * branch["multiplier_imag"].values
    values = branch["special_value"].values
    for kind, known in ((Special.FOLD, 1.0), (Special.PERIOD_DOUBLING, -1.0)):
        here = points[kinds == kind]
        assert np.abs(multipliers[here] - known).min(axis=1).max() < 1e-10
        near = values[kinds == kind]
        assert np.abs(near - 0.586579).min() < 2e-6


# Along a branch only those changes of sign count that stand out of round-off.


@pytest.mark.parametrize(
    ("values", "noise", "found"),
    [
        ([3.0, 1.0, -1.0, -2.0, 5.0], 0.0, [2, 4]),
        ([3.0, 0.0, -1.0], 0.0, [1]),
        ([3.0, np.nan, -1.0], 0.0, [2]),
        ([3.0, 0.1, -0.1, 0.1, -3.0], 0.2, [2]),
        ([3.0, -0.1, 0.1, 3.0], 0.2, []),
        ([0.1, -0.1, -3.0], 0.2, []),
    ],
)
def test_a_change_is_between_two_values_that_are_sure(values, noise, found):
    assert changes(np.array(values), np.full(len(values), noise)) == found


def test_noise_covers_the_round_off_of_determinants():
    """Products of matrices of determinant 1, up to entries of 1e7."""
    random = np.random.default_rng(5)
    product, arcs = np.eye(2), 0
    while np.abs(product).max() < 1e7:
        a, b = random.normal(size=2)
        product = np.array([[1 + a * b, a], [b, 1.0]]) @ product
        arcs += 1
        assert abs(np.linalg.det(product) - 1) < noise_of(product, arcs)
    assert abs(np.linalg.det(product) - 1) > 1e-6


@pytest.mark.parametrize("end", [0.01835, 0.019133333333333332])
def test_a_cascade_does_not_depend_on_how_far_it_is_followed(end):
    """The gaits of the simplest walker (Garcia et al. 1998, doi:10.1115/1.2798313) double towards chaos near 0.019.

    What all equations know little of, in units of the range, is no unknown that they leave free.
    """
    found = cd.continue_orbit(cd.build("simplest-walker"), {"gamma": (0.009, end)}, doublings=4)
    assert found["doubling_period"].values.tolist() == [1, 2, 4, 8, 16]
    np.testing.assert_allclose(found["doubling_value"].values[0], 0.0151, atol=1e-4)
    distances = np.diff(found["doubling_value"].values)
    assert distances[-2] / distances[-1] == pytest.approx(4.669201609, rel=0.002)


@pytest.fixture(scope="module")
def long_walks():
    """Deviations grow by 45 a step with fixed durations, to 1e52 in 32 steps, and hardly from strike to strike."""
    return cd.continue_orbit(cd.build("simplest-walker"), {"gamma": (0.009, 0.0184)}, doublings=6)


def test_the_walker_doubles_up_to_period_64(long_walks):
    assert long_walks["doubling_period"].values.tolist() == [1, 2, 4, 8, 16, 32, 64]
    assert set(long_walks["branch_end"].values.tolist()) == {BranchEnd.LIMIT}
    assert not long_walks.attrs.get("message")
    ratios = long_walks["feigenbaum_ratio"].values
    assert (np.abs(ratios[4:] - 4.669201609) < [0.01, 0.005, 0.002]).all()


def test_the_walkers_multiplier_along_the_flow_stays_1(long_walks):
    values = long_walks["multiplier_real"].values + 1j * long_walks["multiplier_imag"].values
    assert np.abs(values).max() > 1e4
    assert np.abs(values - 1).min(axis=1).max() < 1e-8


def _after_steps(steps, gamma, stance):
    """The stance leg's angle and rate after so many heel strikes, by another integrator."""

    def rate(_, s):
        pull = math.sin(s[0] - gamma)
        return [s[1], pull, s[3], pull + (s[1] ** 2 - math.cos(s[0] - gamma)) * math.sin(s[2])]

    def strike(_, s):
        return s[2] - 2 * s[0] if s[0] < -0.05 else -1.0

    strike.terminal, strike.direction = True, 1
    theta, omega = stance
    for _ in range(steps):
        begin = [theta, omega, 2 * theta, (1 - math.cos(2 * theta)) * omega]
        run = solve_ivp(rate, (0, 10), begin, "DOP853", events=strike, rtol=1e-12, atol=1e-14)
        before = run.y_events[0][0]
        theta, omega = -before[0], math.cos(2 * before[0]) * before[1]
    return np.array([theta, omega])


@pytest.mark.parametrize("steps", [8, 16])
def test_a_long_walk_doubles_in_another_integrator(long_walks, steps):
    point = next(
        k
        for k, kind in zip(long_walks["special_index"].values, long_walks["special_kind"].values, strict=True)
        if kind == Special.PERIOD_DOUBLING
        and long_walks["branch_period"].values[long_walks["branch"].values[k]] == steps
    )
    gamma, stance = float(long_walks["gamma"][point]), long_walks["orbit_state"].values[point, :2]
    # errors of 1e-12 grow by the deviations of the many steps
    assert np.abs(_after_steps(steps, gamma, stance) - stance).max() < 1e-9

    def tangent(h):
        sides = [[_after_steps(steps, gamma, stance + s * h * e) for s in (1, -1)] for e in np.eye(2)]
        return np.array([(one - other) / (2 * h) for one, other in sides]).T

    # of fourth order: third derivatives at one of the many strikes are twenty times those at another
    assert np.abs(np.linalg.eigvals((4 * tangent(3e-8) - tangent(6e-8)) / 3) + 1).min() < 1e-5


def test_a_doubling_that_cannot_be_followed_is_told(monkeypatch):
    monkeypatch.setattr("chaosdrill.orbits.branches.doubled", lambda *_: iter(()))
    found = cd.continue_orbit(cd.build("simplest-walker"), {"gamma": (0.009, 0.0189)}, doublings=5)
    assert found["branch_period"].values.tolist() == [1]
    assert "no doubled orbit was found next to the period doubling at gamma = 0.015088" in found.attrs["message"]


def test_a_food_chain_has_the_points_that_auto_prints():
    """Demo c2c in the log test/hyper.all of AUTO-07p, github.com/auto-07p/auto-07p, to six digits."""
    prey = "5*x*y/(1 + 3*x)"
    eaten = "y*z/(10*(1 + 2*y))"
    chain = cd.HybridSystem(
        name="food-chain", states="x y z", parameters={"d": 0.45}, initial={"x": 0.74, "y": 0.17, "z": 9.2},
        modes={"on": {"x": f"x*(1 - x) - {prey}", "y": f"{prey} - d*y - {eaten}", "z": f"{eaten} - z/80"}},
    )  # fmt: skip
    branch = cd.continue_orbit(chain, {"d": (0.2, 0.52)}, transient=8000, step=0.01)
    found = zip(
        branch.cd.words("special_kind").values,
        branch["special_value"].values,
        branch["period_time"].values[branch["special_index"].values],
        strict=True,
    )
    printed = {
        "fold": [(2.08045e-1, 3.43745e1)],
        "period_doubling": [(2.16681e-1, 4.04772e1), (4.28911e-1, 6.58869e1)],
        "hopf": [(5.12270e-1, None)],
    }
    ours = {kind: [] for kind in printed}
    for kind, value, period in sorted(found, key=lambda one: one[1]):
        ours[kind].append((value, None if kind == "hopf" else period))
    for kind, rows in printed.items():
        assert len(ours[kind]) == len(rows)
        for (value, period), (known, lasts) in zip(ours[kind], rows, strict=True):
            assert value == pytest.approx(known, abs=1e-6)
            assert period == pytest.approx(lasts, abs=1e-4)


def test_a_forced_neuron_leaves_its_period_where_auto_prints_it():
    """Demo ffn, as above: a torus is born at a = 0.422945."""
    neuron = cd.HybridSystem(
        name="fitzhugh-nagumo", states="x y", parameters={"a": 0.6, "b": 0.1}, period="2*pi/10",
        modes={"on": {"x": "3*(x - x**3/3 + y - b*cos(10*t))", "y": "-(x - a + 4*y/5)/3"}},
    )  # fmt: skip
    branch = cd.continue_orbit(neuron, {"a": (0.25, 1.0)}, transient=1000, step=0.03)
    assert branch.cd.words("special_kind").values.tolist() == ["neimark_sacker"]
    assert branch["special_value"].item() == pytest.approx(4.22945e-1, abs=1e-6)
