"""An orbit is found from wherever it can be, whatever the method and the units; a message says why none was found."""

import math
from dataclasses import replace
from math import pi

import numpy as np
import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st
from support.closed_autonomous import belt, gait
from support.closed_impact import one_impact

import chaosdrill as cd
from chaosdrill.dataset import Outcome
from chaosdrill.engine.numerics import Numerics
from chaosdrill.model.derive import conserved_combinations, shift_directions
from chaosdrill.orbits.branches import branches
from chaosdrill.orbits.find import find_orbit, inadmissible_words
from chaosdrill.orbits.neutral import neutral_of
from chaosdrill.orbits.orbit import Orbit
from chaosdrill.orbits.place import Place, characteristic_time
from chaosdrill.orbits.problem import Problem, admissible
from chaosdrill.orbits.search import search
from chaosdrill.orbits.verification import describe
from chaosdrill.systems import build

x, v, y, z, t, c, w = sympy.symbols("x v y z t c w", real=True)


# Every method of integration finds the same orbit, each to its own tolerance.


METHODS = [
    (Numerics(tolerance=1e-13), 1e-11),
    (Numerics(tolerance=1e-7), 1e-5),
    (Numerics("dop853", 1e-12), 1e-9),
    (Numerics("radau", 1e-12), 1e-9),
    (Numerics("rk4", 1e-12, 1000), 1e-8),
]


@pytest.mark.parametrize(("numerics", "error"), METHODS)
def test_every_method_finds_the_known_orbit_of_the_drill(drill, numerics, error):
    found = find_orbit(drill, 1, "attractor", 200, numerics)
    assert found.outcome == Outcome.PERIODIC
    assert found.checks.consistent, found.checks.disagreements
    # quadruple precision, another program
    expected = [0.5117707419326684, 0.2579689590074009, 0.3668787222623992]
    np.testing.assert_allclose(found.states[0], expected, atol=error)
    np.testing.assert_allclose(found.multipliers[0].real, 0.11672896840556, atol=10 * error)
    assert found.rank == 2


@pytest.mark.parametrize(("numerics", "error"), METHODS)
def test_every_method_finds_the_closed_form_of_the_belt(numerics, error):
    system = build("belt-stick-slip")
    own = system.parameters
    closed = belt(own["belt"], own["F_s"], own["F_k"])
    found = find_orbit(system, 1, "attractor", 50, numerics)
    assert found.duration == pytest.approx(closed.period, abs=error)
    np.testing.assert_allclose(found.multipliers, [1, 0], atol=10 * error)
    assert found.multipliers[1] == 0


@pytest.mark.parametrize(("numerics", "error"), METHODS)
def test_the_wheel(numerics, error):
    system = build("rimless-wheel")
    closed = gait(system.parameters["alpha"], system.parameters["gamma"])
    found = find_orbit(system, 1, "attractor", 50, numerics)
    assert found.duration == pytest.approx(closed.period, abs=error)
    np.testing.assert_allclose(found.multipliers.real, closed.multipliers, atol=10 * error)


# Orbits of systems without a clock are found whatever the unit of time is.


FINE = Numerics(tolerance=1e-13)


@pytest.fixture(scope="module")
def van_der_pol():
    x, v, mu, c = sympy.symbols("x v mu c", real=True)
    return cd.HybridSystem(
        name="van-der-pol",
        states=(x, v),
        parameters={"mu": 1.0, "c": 1.0},
        modes={"on": {x: c * v, v: c * (mu * (1 - x**2) * v - x)}},
        initial={"mode": "on", x: 1.0, v: 0.0},
    )


@pytest.mark.parametrize("c", [1e-5, 1.0, 1e5])
def test_any_unit_of_time(van_der_pol, c):
    found = find_orbit(van_der_pol.with_parameters(c=c), 1, "attractor", 50 / c, FINE)
    # the period known to many digits
    assert found.duration * c == pytest.approx(6.66328685932313, abs=1e-11)
    assert found.multipliers[0] == pytest.approx(1, abs=1e-11)
    assert found.checks.consistent, found.checks.disagreements


@pytest.mark.parametrize("c", [1e-5, 1e5])
def test_any_unit_of_time_in_a_search(van_der_pol, c):
    found = search(van_der_pol.with_parameters(c=c), 2, np.zeros((0, 2)), np.zeros(0, dtype=np.int64), FINE)
    assert [o.duration * c for o in found] == pytest.approx([6.66328685932313], abs=1e-11)


@pytest.mark.parametrize("mu", [0.1, 10.0, 100.0])
def test_weak_and_strong_relaxation(van_der_pol, mu):
    found = find_orbit(van_der_pol.with_parameters(mu=mu), 1, "attractor", 50 + 50 * mu, FINE)
    # averaging where it is weak (Hayashi), Dorodnicyn's series where it is strong
    known = 2 * np.pi * (1 + mu**2 / 16) if mu < 1 else (3 - 2 * np.log(2)) * mu + 3 * 2.338107410 / mu ** (1 / 3)
    assert found.duration == pytest.approx(known, rel=1e-5 if mu < 1 else 0.04)
    assert found.checks.consistent, found.checks.disagreements
    # no double holds the smaller multiplier of the strong one, its exponent is known all the same
    assert found.rank == 2
    assert np.isfinite(found.checks.exponents).all()


def bavinck_and_grasman(mu):
    """The period of van der Pol's oscillator to within mu^(-4/3) (1974, doi:10.1016/0020-7462(74)90008-0).

    With the first zero of Airy's function.
    """
    return (3 - 2 * math.log(2)) * mu + 3 * 2.338107410459767 * mu ** (-1 / 3) - (2 / 3 * math.log(mu) + 1.3246) / mu


@pytest.mark.parametrize(("mu", "method"), [(1e2, "dop853"), (1e4, "radau")])
def test_a_stiff_relaxation(van_der_pol, mu, method):
    stiff = van_der_pol.with_parameters(mu=mu).with_initial(x=2.0)
    found = find_orbit(stiff, 1, "attractor", 200, Numerics(method, 1e-11))
    assert found.outcome == Outcome.PERIODIC, found.message
    assert found.duration == pytest.approx(bavinck_and_grasman(mu), abs=mu ** (-4 / 3))
    # the divergence along the slow curve, x' = x/(mu (1 - x^2)) from 2 to 1 and back, which the jumps add little to
    slow = -2 * mu**2 * (3 / 4 + math.log(2))
    assert found.checks.exponents[1] * found.duration == pytest.approx(slow, rel=5 / mu)
    assert found.multipliers[0] == pytest.approx(1, abs=1e-6)


def test_a_section_in_the_jump_of_a_relaxation(van_der_pol):
    """A jump is 8,000 times as fast as what follows, and rounding grows by as much."""
    found = cd.periodic_orbit(van_der_pol.with_parameters(mu=100.0), at="x<-1.5")
    assert found["outcome"] == Outcome.PERIODIC
    assert float(found["period_time"]) == pytest.approx(bavinck_and_grasman(100), abs=100 ** (-4 / 3))


@pytest.mark.parametrize("peak", [-34.0, -32.0])
def test_a_round_begins_in_the_state_that_its_first_duration_belongs_to(peak):
    """After its last event a neuron that still adapts takes another time to the spike, which it would run over."""
    neuron = cd.build("adaptive-integrate-and-fire", parameters={"peak": peak})
    found = cd.periodic_orbit(neuron, transient=100)
    spikes = cd.trajectory(neuron, duration=1500.0, samples=1)["event_time"].values
    assert float(found["period_time"]) == pytest.approx(spikes[-1] - spikes[-2], rel=1e-9)


@pytest.mark.parametrize("peak", [-10.0, 0.0])
def test_a_spike_that_is_cut_far_up_belongs_to_an_orbit(peak):
    """In the rounding of its time the potential rises by up to 1e-4; the period no longer depends on the cut."""
    neuron = cd.build("adaptive-integrate-and-fire", parameters={"peak": peak})
    section = cd.poincare_section(neuron, at="spike", transient=50, periods=4)
    for at, transient in ((None, 100), ("spike", 50)):
        found = cd.periodic_orbit(neuron, at=at, transient=transient)
        assert found.cd.outcome == "periodic"
        assert float(found["period_time"]) == pytest.approx(float(section["return_time"]), rel=1e-11)
        np.testing.assert_allclose(found["multiplier_real"], section["multiplier_real"], rtol=2e-5)


@pytest.mark.parametrize("decay", [0.02, 0.13, 0.2])
def test_an_orbit_has_the_exponents_of_its_multipliers_however_near_they_are(decay):
    clock = cd.HybridSystem(
        states="phi x",
        parameters={"c": decay},
        modes={"on": {"phi": "1", "x": "cos(2*pi*phi) - c*x"}},
        transitions=[cd.Transition("turn", "on", "on", guard="phi - 1", direction=1, reset={"phi": "0"})],
    )
    found = cd.periodic_orbit(clock, at="turn", transient=1000)
    np.testing.assert_allclose(found["lyapunov_exponent"], [0, -decay], atol=1e-12)


def test_a_return_does_not_depend_on_units_of_states(van_der_pol):
    """The speed in units a million times as small, in which it is by far the larger state."""
    a, b, mu = sympy.symbols("x v mu", real=True)
    system = cd.HybridSystem(
        name="in other units",
        states=(a, b),
        parameters={"mu": 100.0},
        modes={"on": {a: b / 10**6, b: mu * (1 - a**2) * b - a * 10**6}},
        initial={a: 2.0, b: 0.0},
    )
    found = find_orbit(system, 1, "attractor", 200, FINE)
    plain = find_orbit(van_der_pol.with_parameters(mu=100.0).with_initial(x=2.0), 1, "attractor", 200, FINE)
    assert found.duration == pytest.approx(plain.duration, rel=1e-10)


def test_the_characteristic_time_is_that_of_the_motion(van_der_pol):
    slow, fast = (characteristic_time(Place(van_der_pol.with_parameters(c=c)), FINE) for c in (1e-3, 1e3))
    assert slow / fast == pytest.approx(1e6, rel=1)


# Orbits that go on beyond their own guards are found wherever on them the search begins.


def clock_of(*states):
    """x'' = -c x' - x, kicked by L in its direction whenever x = 0 upward: what it meets, it goes through."""
    x, v, c, size = sympy.symbols("x v c L", real=True)
    kick = cd.Transition("kick", "swing", "swing", guard=x, direction=1, reset={v: v + size})
    return cd.HybridSystem(
        name="clock", states=[{"x": x, "v": v}[name] for name in states], parameters={"c": 0.2, "L": 1.0},
        modes={"swing": {x: v, v: -x - c * v}}, transitions=[kick], initial={"mode": "swing", x: -1.0, v: 0.0},
    )  # fmt: skip


@pytest.fixture(scope="module")
def clock():
    return clock_of("x", "v")


def turn(c):
    """Duration of a turn, and by what a deviation shrinks over it."""
    duration = 2 * math.pi / math.sqrt(1 - c**2 / 4)
    return duration, np.exp(-c / 2 * duration)


def is_the_cycle(found, c=0.2, size=1.0):
    duration, shrinks = turn(c)
    assert found.outcome == Outcome.PERIODIC, found.message
    assert found.duration == pytest.approx(duration, abs=1e-13)
    np.testing.assert_allclose(found.multipliers, [1, shrinks], atol=1e-12)
    # after the kick v = L + v exp(-c T/2)
    assert np.abs(found.event_states_after[0]).max() == pytest.approx(size / (1 - shrinks), rel=1e-12)
    assert found.checks.consistent, found.checks.disagreements


@pytest.mark.parametrize("transient", range(60, 80))
def test_the_clock_from_any_place(clock, transient):
    is_the_cycle(find_orbit(clock, 1, "attractor", transient, FINE))


@pytest.mark.parametrize("size", [1e-6, 1e6])
def test_the_clock_of_any_size(clock, size):
    changed = clock.with_parameters(L=size).with_initial(x=-size)
    is_the_cycle(find_orbit(changed, 1, "attractor", 70, FINE), size=size)


def test_the_clock_with_its_states_in_another_order():
    is_the_cycle(find_orbit(clock_of("v", "x"), 1, "attractor", 67, FINE))


def test_a_branch_of_clocks(clock):
    result = branches(clock, "c", (0.1, 0.4), 1, "attractor", 61, 0, 0.01, 200, FINE, None)
    assert result.message == ""
    assert not result.events
    assert (result.values[0, 0], result.values[-1, 0]) == (0.1, 0.4)
    expected = [turn(c)[1] for c in result.values[:, 0]]
    np.testing.assert_allclose(result.multipliers, np.column_stack([np.ones(len(expected)), expected]), atol=1e-12)
    assert result.stable.all()


@pytest.fixture(scope="module")
def walker():
    """The simplest walker: stance angle th, swing angle ph; the foot scuffs at mid-stance, through its own guard.

    Garcia, Chatterjee, Ruina and Coleman 1998, doi:10.1115/1.2798313.
    """
    th, om, ph, ps, slope = sympy.symbols("th om ph ps slope", real=True)
    stance = sympy.sin(th - slope)
    swing = stance + om**2 * sympy.sin(ph) - sympy.cos(th - slope) * sympy.sin(ph)
    turned = sympy.cos(2 * th)
    strike = cd.Transition(
        "strike", "swing", "swing", guard=ph - 2 * th, direction=1, condition=th < -0.05,
        reset={th: -th, om: turned * om, ph: -2 * th, ps: turned * (1 - turned) * om},
    )  # fmt: skip
    return cd.HybridSystem(
        name="walker", states=(th, om, ph, ps), parameters={"slope": 0.009},
        modes={"swing": {th: om, om: stance, ph: ps, ps: swing}}, transitions=[strike],
        initial={"mode": "swing", th: 0.2, om: -0.2, ph: 0.4, ps: -0.0158},
    )  # fmt: skip


# of period one at this slope, as widely published for this model
GAIT = [0.200310900544287, -0.199832473004977, 0.400621801088574, -0.015822999948318]


@pytest.mark.parametrize("transient", range(20, 26))
def test_the_walker_from_any_place(walker, transient):
    found = find_orbit(walker, 1, "attractor", transient, FINE)
    assert found.outcome == Outcome.PERIODIC, found.message
    assert found.checks.consistent, found.checks.disagreements
    np.testing.assert_allclose(found.event_states_after[0], GAIT, atol=1e-9)
    assert found.rank == 3
    assert found.multipliers[3] == 0
    assert found.multipliers[0] == pytest.approx(1, abs=1e-10)
    assert abs(found.multipliers[1]) < 1


@pytest.fixture(scope="module")
def two_legs(walker):
    """The same walker on a left and a right leg, each of which is a mode."""
    modes = dict.fromkeys(("left", "right"), walker.modes["swing"])
    steps = [
        replace(walker.transitions[0], name=name, source=name, target=other, kind="impact")
        for name, other in (("left", "right"), ("right", "left"))
    ]
    start = {**walker.initial, "mode": "left"}
    return cd.HybridSystem(
        name="two legs", states=walker.states, parameters=walker.parameters, modes=modes, transitions=steps,
        initial=start,
    )  # fmt: skip


@pytest.mark.parametrize(("at", "start"), [("impact", "attractor"), ("th < 0", "guess"), ("right", "guess")])
def test_a_walker_of_two_legs_takes_two_steps(walker, two_legs, at, start):
    """Where the foot scuffs it is beyond the guard of its strike, and no run can begin there."""
    steps = 1 if at == "right" else 2
    found = cd.periodic_orbit(two_legs, at=at, start=start, period=steps)
    assert int(found["outcome"]) == Outcome.PERIODIC, found.attrs["message"]
    assert int(found["period"]) == steps
    np.testing.assert_allclose(found["event_state_after"].values, [GAIT, GAIT], atol=1e-9)
    one = find_orbit(walker, 1, "attractor", 20, FINE)
    pairs = found["multiplier_real"].values + 1j * found["multiplier_imag"].values
    np.testing.assert_allclose(np.sort_complex(pairs), np.sort_complex(one.multipliers**2), atol=1e-9)
    if steps > 1:
        half = cd.periodic_orbit(two_legs, at=at, start=start)
        assert "in the same after 2: give period=2" in half.attrs["message"]


# Orbits that come in families: what the structure of a system leaves neutral is no obstacle, and is reported.


@pytest.fixture(scope="module")
def carried():
    """A forced linear oscillator and z' = v: z - x is conserved, and z can be anything."""
    return cd.HybridSystem(
        name="carried", states=(x, v, z), time=t, parameters={"c": 0.2, "w": 1.7}, period=2 * sympy.pi / w,
        modes={"on": {x: v, v: -c * v - x + sympy.cos(w * t) / 10, z: v}}, initial={"mode": "on", z: 3.0},
    )  # fmt: skip


def response(damping, frequency=1.7):
    """State (x, v) at phase 0, and the multipliers of the oscillator."""
    amplitude = 0.1 / (1 - frequency**2 + 1j * damping * frequency)
    rate = complex(-damping / 2, math.sqrt(1 - damping**2 / 4))
    pair = np.exp(np.array([rate, rate.conjugate()]) * 2 * math.pi / frequency)
    return np.array([amplitude.real, (1j * frequency * amplitude).real]), pair


def test_a_shift_and_what_it_changes_are_one(carried):
    assert shift_directions(carried) == [[0, 0, 1]]
    assert np.array(conserved_combinations(carried)) @ [1, 0, 1] == pytest.approx([0])
    assert neutral_of(carried).count == 1


def test_a_stable_orbit_beside_a_conserved_quantity(carried):
    found = find_orbit(carried, 1, "attractor", 200, FINE)
    state, pair = response(0.2)
    np.testing.assert_allclose(found.states[0, :2], state, atol=1e-12)
    # z - x stays 3
    assert found.states[0, 2] == pytest.approx(3 + state[0], abs=1e-10)
    assert found.multipliers[0] == pytest.approx(1, abs=1e-13)
    assert sorted(found.multipliers[1:].imag) == pytest.approx(sorted(pair.imag), abs=1e-12)
    assert found.neutral == 1
    assert found.checks.consistent, found.checks.disagreements
    orbit = cd.periodic_orbit(carried)
    assert int(orbit["stable"]) == 1
    assert int(orbit["neutral"]) == 1
    assert "shifted along z" in orbit.attrs["structure"]


def test_a_branch_of_them(carried):
    result = branches(carried, "c", (0.1, 0.5), 1, "attractor", 200, 0, 0.02, 200, FINE, None)
    assert (result.values[0, 0], result.values[-1, 0]) == (0.1, 0.5)
    assert not result.events
    assert result.stable.all()
    expected = np.array([response(damping)[0] for damping in result.values[:, 0]])
    np.testing.assert_allclose(result.section[:, 0, :2], expected, atol=1e-11)


@pytest.fixture(scope="module")
def two_pairs():
    """A forced oscillator that drives another one: two complex pairs, whose tangents run around long ellipses."""
    return cd.HybridSystem(
        name="two-pairs",
        states="x v y u",
        parameters={"k": 4.0, "c": 0.1, "l": 0.3, "d": 0.3},
        modes={"on": {"x": "v", "v": "-k*x - c*v + cos(t)", "y": "u", "u": "-l*y - d*u + x"}},
        period="2*pi",
    )


@settings(max_examples=25)
@given(
    stiffness=st.tuples(st.floats(0.1, 30), st.floats(0.1, 30)),
    damping=st.tuples(st.floats(0.03, 0.25), st.floats(0.03, 0.25)),
)
def test_the_exponents_of_two_pairs_are_those_of_either(two_pairs, stiffness, damping):
    (k, l_), (c, d) = stiffness, damping
    found = cd.periodic_orbit(two_pairs.with_parameters(k=k, l=l_, c=c, d=d), transient=1, start="guess")
    expected = sorted([-c / 2, -c / 2, -d / 2, -d / 2], reverse=True)
    # nearly equal ones are known by their mean
    apart = abs(c - d) * np.pi > 0.15
    expected = expected if apart else np.mean(expected)
    exponents = found["lyapunov_exponent"] if apart else found["lyapunov_exponent"].mean()
    np.testing.assert_allclose(exponents, expected, rtol=0, atol=1e-9)
    assert bool(found["consistent"]), found.attrs["disagreement"]


@pytest.mark.parametrize("damping", [1e-1, 1e-3, 1e-5])
def test_a_linear_equation_is_solved_from_rest_however_far_the_orbit_is(two_pairs, damping):
    """In resonance the response is 1/damping times as large as the force."""
    found = cd.periodic_orbit(two_pairs.with_parameters(k=1.0, c=damping), start="guess")
    x, v = found["orbit_state"].sel(state=["x", "v"]).values * damping
    np.testing.assert_allclose([x, v], [0, 1], rtol=0, atol=1e-13 / damping)


def test_a_sum_that_is_kept_is_that_of_the_start():
    """x and y turn into each other at a forced rate: their sum is kept, and deviations at a constant sum die out."""
    flow = (2 + sympy.cos(t)) * x - y
    system = cd.HybridSystem(
        name="exchange", states=(x, y), time=t, parameters={}, modes={"on": {x: -flow, y: flow}},
        period=2 * sympy.pi, initial={"mode": "on", x: 0.7, y: 0.1},
    )  # fmt: skip
    found = find_orbit(system, 1, "guess", 0, FINE)
    assert found.states[0].sum() == pytest.approx(0.8, abs=1e-12)
    np.testing.assert_allclose(found.multipliers, [1, math.exp(-6 * math.pi)], atol=1e-13)
    assert found.neutral == 1


def test_a_state_that_drifts(carried):
    """z grows by the mean square of x, and else is what it was; where x depends on it, nothing closes."""
    drifting = cd.HybridSystem(
        name="drifting", states=(x, v, z), time=t, parameters={"c": 0.2, "w": 1.7}, period=2 * sympy.pi / w,
        modes={"on": {x: v, v: -c * v - x + sympy.cos(w * t) / 10, z: v + x**2}}, initial={"mode": "on", z: 3.0},
    )  # fmt: skip
    found, same = (find_orbit(system, 1, "attractor", 200, FINE) for system in (drifting, carried))
    amplitude = abs(complex(*(response(0.2)[0] * [1, -1 / 1.7])))
    np.testing.assert_allclose(found.solved[1].drift, [0, 0, amplitude**2 / 2 * 2 * pi / 1.7], atol=1e-13)
    np.testing.assert_allclose(found.multipliers, same.multipliers, atol=1e-13)
    np.testing.assert_allclose(found.states[0, :2], same.states[0, :2], atol=1e-13)
    growing = cd.HybridSystem(
        name="growing", states=(x, v, z), time=t, parameters={"c": 0.2, "w": 1.7}, period=2 * sympy.pi / w,
        modes={"on": {x: v, v: -c * v - x + sympy.cos(w * t) / 10 + sympy.exp(-z) / 9, z: v + x**2}},
    )  # fmt: skip
    assert find_orbit(growing, 1, "attractor", 200, FINE).outcome.meaning == "open"


# Where the equations close but the system goes otherwise, no orbit is reported.


def closed(w, d, n, which):
    """The orbit of a closed form, the system it belongs to, and whether it stays below the wall."""
    impact = one_impact(w, d, 0.05, 0.8, n)[which]
    problem = Problem(build("impact-oscillator", {"omega": w, "wall": d}), (), FINE)
    segments, starts = np.array([[0, 0, 0]]), np.array([[d, -0.8 * impact.speed]])
    guess = Orbit(segments, n, starts, impact.phase / w, np.array([n * 2 * pi / w]))
    code, orbit, shot, residuals = problem.newton(guess)
    assert code == 0
    assert residuals[-1] < 1e-12
    assert np.trace(shot.monodromy) == pytest.approx(impact.trace, rel=1e-9)
    return problem, orbit, shot, residuals, impact.highest < d


@pytest.mark.parametrize(
    ("w", "d", "n", "which"), [(2.0, 0.3, 2, 0), (2.0, 0.3, 3, 0), (2.5, 0.3, 4, 0), (1.8, 0.5, 3, 1)]
)
def test_an_orbit_through_the_wall(w, d, n, which):
    problem, orbit, shot, residuals, below = closed(w, d, n, which)
    assert not below
    assert not admissible(orbit, shot)
    assert inadmissible_words(problem, orbit, shot) == "in mode 'free' the guard of 'impact' is crossed on the way"
    found = describe(problem, orbit, shot, residuals)
    assert found.outcome == Outcome.INADMISSIBLE
    assert "the equations close, but" in found.message
    assert len(found.states) == 0


@pytest.mark.parametrize(("w", "d", "n", "which"), [(2.0, 0.3, 1, 0), (2.5, 0.3, 2, 0), (1.8, 0.5, 3, 0)])
def test_an_orbit_below_the_wall(w, d, n, which):
    problem, orbit, shot, residuals, below = closed(w, d, n, which)
    assert below
    assert admissible(orbit, shot)
    found = describe(problem, orbit, shot, residuals)
    assert found.outcome == Outcome.PERIODIC
    assert found.residual < 1e-12
    assert found.checks.consistent


@pytest.mark.parametrize("tolerance", [1e-12, 1e-9, 1e-7])
def test_an_orbit_of_a_family_is_found_at_any_tolerance(tolerance):
    cubic = cd.HybridSystem(states="x v", modes={"only": {"x": "v", "v": "-x**3"}}, initial={"x": 1.0})
    found = cd.periodic_orbit(cubic, start="guess", tolerance=tolerance)
    assert float(found["period_time"]) == pytest.approx(7.416298709205487, rel=10 * tolerance)


@pytest.mark.parametrize(("method", "e", "amplitude"), [("taylor", 0.1, 1.3), ("dop853", 0.3, 1.1)])
def test_rounding_decides_which_rebound_before_a_rest_is_the_last(method, e, amplitude):
    ball = build("bouncing-ball", {"e": e, "amplitude": amplitude})
    at_rest_again(cd.periodic_orbit(ball, method=method))


def test_a_last_rebound_lower_than_an_orbit_is_solved_to():
    floor, speed = "A*sin(t)", "A*cos(t)"
    onto = {"guard": f"x - {floor}", "direction": -1}
    ball = cd.HybridSystem(
        states="x v", parameters={"e": 0.1, "A": 1.7}, period="2*pi", initial={"x": 5.0},
        modes={"flight": {"x": "v", "v": "-1"}, "contact": {"x": speed, "v": f"-{floor}"}},
        transitions=[
            cd.Transition("impact", "flight", "flight", **onto, reset={"x": floor, "v": f"(1 + e)*{speed} - e*v"}),
            cd.Transition("rest", "flight", "contact", **onto, reset={"x": floor, "v": speed}, completes="impact"),
            cd.Transition("lift-off", "contact", "flight", f"1 - {floor}", -1),
        ],
    )  # fmt: skip
    at_rest_again(cd.periodic_orbit(ball))


def at_rest_again(found):
    """A ball whose every deviation is lost while it rests, until the floor, at the height 1, falls as fast as it."""
    assert found.cd.outcome == "periodic"
    assert not found["multiplier_real"].any()
    off = found["event_kind"] == 2
    assert np.allclose(found["event_state_before"].sel(state="x")[off], [1.0], rtol=0, atol=1e-12)
