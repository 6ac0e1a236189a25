"""Orbits that close but for a shift that the system does not notice: runners, rotors, what is carried along."""

import math
import time

import numpy as np
import pytest
import sympy
from scipy.integrate import solve_ivp
from scipy.optimize import fsolve
from support.following import kinds

import chaosdrill as cd
from chaosdrill.dataset import Outcome
from chaosdrill.dataset.branches import Special
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.shifts import Shifts, shifts_of
from chaosdrill.engine.structure import symmetries_of, turns_of
from chaosdrill.orbits.branches import branches
from chaosdrill.orbits.find import find_orbit
from chaosdrill.orbits.search import search
from chaosdrill.systems import build

FINE = Numerics(tolerance=1e-13)
STIFFNESS, LANDING = 35.0, 1.2


def carrying(system, name, rates):
    """A system with one more state, which grows at a rate in every mode and enters nothing."""
    state = sympy.Symbol(name, real=True)
    return cd.HybridSystem(
        name=system.name, states=(*system.states, state), time=system.time, period=system.period,
        modes={mode: {**field, state: rates[mode]} for mode, field in system.modes.items()},
        transitions=system.transitions, parameters=system.parameters, initial=system.initial,
    )  # fmt: skip


def runner(placed):
    """Spring-loaded inverted pendulum with its position and the place of its foot, or the distance of the two.

    Blickhan 1989, doi:10.1016/0021-9290(89)90224-8; Ghigliazza, Altendorfer, Holmes and Koditschek 2003,
    doi:10.1137/S1111111102408311. Mass, leg and gravity are 1.
    """
    ahead, touched = ("(x - f)", {"f": "x + cos(b)"}) if placed else ("r", {"r": "-cos(b)"})
    leg = f"sqrt({ahead}**2 + y**2)"
    moves = {"x": "u", "f": "0"} if placed else {"r": "u"}
    flight = {**moves, "y": "v", "u": "0", "v": "-1"}
    stance = {**moves, "y": "v", "u": f"k*(1/{leg} - 1)*{ahead}", "v": f"k*(1/{leg} - 1)*y - 1"}
    return cd.HybridSystem(
        name="runner", states="x y u v f" if placed else "r y u v", parameters={"k": STIFFNESS, "b": LANDING},
        modes={"ascent": flight, "descent": flight, "stance": stance},
        transitions=[
            cd.Transition("touchdown", "descent", "stance", guard="y - sin(b)", direction=-1, reset=touched),
            cd.Transition("liftoff", "stance", "ascent", guard=f"{leg} - 1", direction=+1),
            cd.Transition("apex", "ascent", "descent", guard="v", direction=-1),
        ],
        initial={"mode": "descent", "y": 1.0, "u": 1.94, "v": 0.0},
    )  # fmt: skip


def step(state, stiffness=STIFFNESS):
    """State (x, u, v) at a touchdown after one step and the time of it, by SciPy's DOP853 and a parabola."""
    x, u, v = state
    foot, height = x + math.cos(LANDING), math.sin(LANDING)

    def rates(t, s):
        leg = math.hypot(s[0] - foot, s[1])
        pull = stiffness * (1 / leg - 1)
        return [s[2], s[3], pull * (s[0] - foot), pull * s[1] - 1]

    def liftoff(t, s):
        return math.hypot(s[0] - foot, s[1]) - 1

    liftoff.terminal, liftoff.direction = True, 1
    stance = solve_ivp(rates, (0, 5), [x, height, u, v], "DOP853", rtol=3e-14, atol=1e-15, events=liftoff)
    x, y, u, v = stance.y_events[0][0]
    fall = v + math.sqrt(v**2 + 2 * (y - height))
    return np.array([x + u * fall, u, v - fall]), stance.t_events[0][0] + fall


def test_the_gait_of_a_runner():
    """Energy, position and time are free: three multipliers are 1, the forgotten foot place makes one 0."""
    gait = find_orbit(runner(True), 1, "guess", 0, FINE)
    assert gait.outcome == Outcome.PERIODIC, gait.message
    assert gait.checks.consistent, gait.checks.disagreements
    assert gait.neutral == 3
    names = [runner(True).transitions[k].name for k in gait.event_transitions]
    begin = gait.event_states_after[names.index("touchdown")][[0, 2, 3]]
    after, time = step(begin)
    assert time == pytest.approx(gait.duration, abs=1e-10)
    drift = gait.solved[1].drift
    np.testing.assert_allclose(after - begin, [drift[0], 0, 0], atol=1e-10)
    np.testing.assert_allclose(drift, [drift[0], 0, 0, 0, drift[0]], atol=1e-10)
    differences = np.array([(step(begin + e)[0] - step(begin - e)[0]) / 2e-5 for e in 1e-5 * np.eye(3)]).T
    # of position, energy, and the one that decides
    free = np.linalg.det(differences[1:, 1:])
    np.testing.assert_allclose(gait.multipliers, [1, 1, 1, free, 0], atol=2e-6)
    assert gait.multipliers[3].real == pytest.approx(free, abs=1e-8)
    whole = cd.periodic_orbit(runner(True), start="guess", transient=0)
    assert whole.attrs["structure"].endswith("3 of its multipliers are 1")
    assert bool(whole["stable"])
    np.testing.assert_allclose(whole["drift"], drift, atol=1e-11)
    assert float(whole["drift_error"][0]) < 1e-10
    np.testing.assert_allclose(whole["path_state"][-1] - whole["path_state"][0], drift, atol=1e-10)


def test_which_gait_of_a_family_is_found_does_not_depend_on_writing_and_tolerance():
    """There is a gait of every energy: the last steps of Newton's method would lead to any of them."""
    gaits = [
        cd.periodic_orbit(runner(placed), start="guess", at="touchdown", tolerance=tolerance)["orbit_state"]
        for placed, tolerance in ((True, 1e-13), (False, 1e-13), (True, 1e-10))
    ]
    first, *others = ([float(gait.sel(state=name)) for name in ("y", "u")] for gait in gaits)
    for other in others:
        assert other == pytest.approx(first, rel=1e-8)


def test_what_happens_to_a_gait_does_not_depend_on_the_step():
    """A double multiplier 1 is not told from one that passes 1; at its end the flight vanishes, at no speed."""
    one, other = (
        cd.continue_orbit(runner(False), {"k": (15.0, 60.0)}, at="touchdown", start="guess", step=step)
        for step in (0.4, 1.1)
    )
    assert kinds(one) == kinds(other) == [Special.EVENT_SWAP, Special.PERIOD_DOUBLING, Special.FOLD]
    apart = np.abs(one["special_value"].values - other["special_value"].values)
    assert (apart <= one["special_error"].values + other["special_error"].values).all()


def test_where_it_runs_changes_nothing():
    """The branch of gaits is that of the runner without a position."""
    both = [branches(runner(p), "k", (34.0, 36.0), 1, "guess", 0, 0, 0.1, 200, FINE, None) for p in (True, False)]
    for result in both:
        assert not result.message
        assert not result.events
    placed, bare = ([r.duration[i] for i in (0, -1)] for r in both)
    # of the family that energy distinguishes either starts from its own member
    np.testing.assert_allclose(placed, bare, atol=1e-4)
    drifts = np.array([o.drift for _, o, _ in both[0].orbits])
    np.testing.assert_allclose(drifts[:, 0], drifts[:, 4], atol=1e-10)


def test_gaits_of_a_runner_over_its_energy():
    """They meet where the map from touchdown to touchdown has the slope 1, and double at -1: where SciPy finds it."""
    flight = "(u**2 + v**2)/2 + y"
    energies = {"ascent": flight, "descent": flight, "stance": f"{flight} + k*(sqrt(r**2 + y**2) - 1)**2/2"}
    gaits = cd.on_level(runner(False), energies)
    branch = cd.continue_orbit(gaits, {"level": (2.0, 4.5)}, start="guess", transient=0, step=0.25)
    assert not branch.attrs["message"]
    assert branch["special_kind"].values.tolist() == [Special.FOLD, Special.PERIOD_DOUBLING]

    def back(energy, v):
        return step(np.array([0.0, math.sqrt(2 * (energy - math.sin(LANDING)) - v**2), v]))[0][2]

    def slope(energy, v):
        far, near = (back(energy, v + k * 1e-3) - back(energy, v - k * 1e-3) for k in (2, 1))
        return (8 * near - far) / 12e-3

    for sign, value, k in zip((1, -1), branch["special_value"].values, branch["special_index"].values, strict=True):
        start = (float(value), branch["orbit_state"].values[k, 3])
        found = fsolve(lambda p, sign=sign: (back(*p) - p[1], slope(*p) - sign), start, xtol=1e-12)
        np.testing.assert_allclose(start, found, atol=1e-8)


def test_a_wheel_on_its_way_down():
    """Rimless wheel with the place of its foot, which steps put 2 sin(alpha) ahead; multipliers in closed form."""
    wheel = build("rimless-wheel")
    foot = sympy.Symbol("foot", real=True)
    alpha = next(s for s in wheel.transitions[0].guard.free_symbols if str(s) == "alpha")
    ahead = {"step": 2 * sympy.sin(alpha), "step-back": -2 * sympy.sin(alpha)}
    walking = cd.HybridSystem(
        name="wheel", states=(*wheel.states, foot), parameters=wheel.parameters, initial=wheel.initial,
        modes={"stance": {**wheel.modes["stance"], foot: 0}},
        transitions=[
            cd.Transition(t.name, t.source, t.target, t.guard, t.direction, {**t.reset, foot: foot + ahead[t.name]})
            for t in wheel.transitions
        ],
    )  # fmt: skip
    found = find_orbit(walking, 1, "attractor", 50, FINE)
    assert found.outcome == Outcome.PERIODIC, found.message
    np.testing.assert_allclose(found.multipliers, [1, 1, math.cos(0.6) ** 2], atol=1e-12)
    np.testing.assert_allclose(found.solved[1].drift, [0, 0, 2 * math.sin(0.3)], atol=1e-12)
    assert found.neutral == 2
    assert found.duration == pytest.approx(find_orbit(wheel, 1, "attractor", 50, FINE).duration, abs=1e-12)


def test_the_drill_sinks():
    """Penetration as a state that the rock carries along says what it says as a quadrature."""
    drill = build("percussive-drill")
    (rates,) = drill.quadratures.values()
    sinking = carrying(drill, "sunk", rates)
    whole, other = cd.periodic_orbit(drill), cd.periodic_orbit(sinking)
    assert int(other["outcome"]) == Outcome.PERIODIC, other.attrs["message"]
    mean = float(other["drift"].sel(state="sunk") / other["period_time"])
    assert mean == pytest.approx(float(whole["progression_rate"]), rel=1e-10)
    np.testing.assert_allclose(other["orbit_state"][:-1], whole["orbit_state"], atol=1e-10)
    np.testing.assert_allclose(other["multiplier_real"][1:], whole["multiplier_real"], atol=1e-9)
    # with the positions of both masses and the phase as states
    placed = cd.periodic_orbit(build("percussive-drill-5d"))
    sunk = float(other["drift"].sel(state="sunk"))
    np.testing.assert_allclose(placed["drift"], [sunk, 0, sunk, 0, 2 * math.pi], atol=1e-10)
    assert int(placed["neutral"]) == 2
    np.testing.assert_allclose(placed["multiplier_real"], [1, 1, *whole["multiplier_real"]], atol=1e-9)


def test_a_branch_is_that_without_what_is_carried_along():
    """Nothing else of the doublings of Ueda's oscillator changes if the integral of x^2 is a state."""
    bare = build("ueda", {"k": 0.25}).with_initial(x=-0.5, v=1.0)
    alike = carrying(bare, "z", {"flow": bare.states[0] ** 2})
    results = [
        branches(s, "amplitude", (1.0, 8.0), 1, "attractor", 100, 1, 0.02, 200, FINE, None) for s in (bare, alike)
    ]
    first, second = results
    assert [e.code for e in first.events] == [e.code for e in second.events]
    assert any("doubling" in e.code.meaning for e in first.events)
    for one, other in zip(first.events, second.events, strict=True):
        assert one.values[0] == pytest.approx(other.values[0], abs=1e-7)
    assert not second.message


def test_a_rotor_turns_once_in_closed_form():
    """It turns once in 2 pi / sqrt(f^2 - a^2); with inertia its second multiplier is that of its damping."""
    light = cd.HybridSystem(
        name="rotor", states="th", parameters={"f": 1.3, "a": 0.5}, modes={"on": {"th": "f - a*sin(th)"}}
    )
    turned = find_orbit(light, 1, "attractor", 10, FINE)
    assert turned.outcome == Outcome.PERIODIC, turned.message
    assert turned.duration == pytest.approx(2 * math.pi / 1.2, rel=1e-12)
    assert turned.multipliers == pytest.approx([1])
    heavy = cd.HybridSystem(
        name="rotor", states="th om", parameters={"f": 0.6}, initial={"om": 3.0},
        modes={"on": {"th": "om", "om": "f - om/5 - sin(th)/2"}},
    )  # fmt: skip
    found = find_orbit(heavy, 1, "attractor", 100, FINE)
    np.testing.assert_allclose(found.multipliers, [1, math.exp(-found.duration / 5)], atol=1e-11)
    np.testing.assert_allclose(found.solved[1].drift, [2 * math.pi, 0], atol=1e-12)
    (one,) = search(heavy, 1, np.zeros((0, 2)), np.zeros(0, dtype=int), FINE)
    assert one.duration == pytest.approx(found.duration, abs=1e-11)
    branch = branches(heavy, "f", (0.5, 0.7), 1, "attractor", 100, 0, 0.02, 200, FINE, None)
    assert not branch.message
    assert (branch.values[0, 0], branch.values[-1, 0]) == (0.5, 0.7)


def test_what_may_be_shifted():
    """Angles by their periods, together with what resets make of them; not what a guard or a reset ties down."""
    th, ps, z = sympy.symbols("th ps z", real=True)

    def system(guard, reset):
        return cd.HybridSystem(
            name="angles", states=(th, ps, z), modes={"on": {th: 1, ps: sympy.sin(2 * ps), z: sympy.cos(4 * th / 3)}},
            transitions=[cd.Transition("tick", "on", "on", guard, 1, reset=reset)],
        )  # fmt: skip

    def turns_of_all(one):
        return list(map(list, turns_of(one, ())))

    free = system(sympy.sin(2 * th), {})
    assert turns_of_all(free) == [[pytest.approx(3 * math.pi), 0, 0], [0, pytest.approx(math.pi), 0]]
    assert shifts_of(free).lines.tolist() == [[0, 0, 1]]
    # ps becomes th: both turn together, by what suits both
    assert turns_of_all(system(sympy.sin(2 * th), {ps: th})) == [[pytest.approx(3 * math.pi)] * 2 + [0]]
    assert turns_of_all(system(th - 1, {})) == [[0, pytest.approx(math.pi), 0]]
    assert turns_of_all(system(sympy.sin(2 * th), {th: 0, ps: 2 * ps})) == []


def test_what_decides_is_not_shifted():
    """A condition and a step tell where a state is though no derivative does; tangents along it never change."""
    bounce = {"name": "hit", "source": "on", "target": "on", "guard": "x", "direction": -1}
    for thrown, condition in (("-v", "s < 3"), ("-v + floor(s)", "v < 0")):
        ball = cd.HybridSystem(
            name="ball", states="x v s", modes={"on": {"x": "v", "v": "-1", "s": "1"}},
            transitions=[cd.Transition(**bounce, reset={"v": thrown}, condition=condition)],
        )  # fmt: skip
        assert len(symmetries_of(ball)) == 1
        assert not shifts_of(ball)


def test_the_turn_of_an_angle_may_depend_on_a_parameter():
    string = build("drill-string")
    turn = [[0, 0, pytest.approx(2 * math.pi / 3, rel=1e-15), 0, 0]]
    assert shifts_of(string, but_of=("k",)).turns.tolist() == turn
    turn[0][2] = pytest.approx(math.pi / 2, rel=1e-15)
    assert shifts_of(string.with_parameters(lobes=4.0), but_of=()).turns.tolist() == turn
    assert not shifts_of(string.with_parameters(lobes=0.0), but_of=())
    assert not shifts_of(string, but_of=("lobes",))


def test_coordinates_that_no_shift_changes():
    shifts = Shifts(np.array([[1.0, 0, 1.0, 0, 0]]), np.array([[0, 2.0, 0, -6.0, 0]]))
    rng = np.random.default_rng(5)
    states, rates = rng.normal(size=(2, 20, 5))
    moved = states + 7.3 * shifts.lines + 3 * shifts.turns
    seen = shifts.quotient(states)
    np.testing.assert_allclose(shifts.quotient(moved), seen, atol=1e-13)
    assert seen.shape == (20, 6)
    assert shifts.bounded.tolist() == [False, True, False, False, False, True]
    apart = np.abs(seen[:, np.newaxis] - seen[np.newaxis]).max(axis=2)
    assert (apart + np.eye(20) > 1e-3).all()
    ahead, back = (shifts.quotient(states + e * rates) for e in (1e-5, -1e-5))
    told = [shifts.rates(state, rate) for state, rate in zip(states, rates, strict=True)]
    np.testing.assert_allclose(told, (ahead - back) / 2e-5, atol=1e-8)


def test_what_lies_across_shifts_is_kept():
    shifts = Shifts(np.array([[1.0, 0, 1.0, 0]]), np.array([[0, 2.0, 0, 0]]))
    apart = np.array([3.5, 4.1, 3.75, -1.0])
    np.testing.assert_allclose(shifts.part(apart), [3.5, 4, 3.5, 0])
    np.testing.assert_allclose(shifts.across(apart), [0, 0.1, 0.25, -1])


def test_two_gaits_of_one_energy_meet_where_a_multiplier_is_one():
    """The branch turns back elsewhere: only the differential of the energy is held on it, not the energy."""
    gait = runner(True).with_initial(y=0.95907022, u=1.96942721)
    branch = cd.continue_orbit(gait, {"k": (34.0, 48.0)}, start="guess", step=0.5, max_points=40)
    fold = np.flatnonzero(branch["special_multiplicity"].values)
    assert branch["special_kind"].values[fold].tolist() == [Special.FOLD]
    assert "one value of what is conserved" in str(branch["special_text"].values[fold[0]])
    _, y, u, v, _ = branch["orbit_state"].values[int(branch["special_index"][fold[0]])]
    known, error = (float(branch[name][fold[0]]) for name in ("special_value", "special_error"))
    energy = y + (u**2 + v**2) / 2

    def misses(fall, stiffness):
        state = np.array([0.0, math.sqrt(2 * (energy - math.sin(LANDING)) - fall**2), -fall])
        return step(state, stiffness)[0][2] + fall

    def tangency(unknowns):
        fall, stiffness = unknowns
        far, near = (misses(fall + k * 1e-3, stiffness) - misses(fall - k * 1e-3, stiffness) for k in (2, 1))
        return [misses(fall, stiffness), (8 * near - far) / 12e-3]

    guess = [math.sqrt(v**2 + 2 * (y - math.sin(LANDING))), known + 0.1]
    _, stiffness = fsolve(tangency, guess, xtol=1e-12)
    assert abs(stiffness - known) < 1e-8
    assert 0 < error < 1e-8
    assert branch["k"].values.max() > known + 1


@pytest.mark.parametrize("unit", [1.0, 1e-13])
def test_slow_states_are_shifted_as_quick_ones_are(unit):
    """Two bodies tied to each other, however weakly, and one that comes to rest."""
    system = cd.HybridSystem(
        name="tied", states="x y z", parameters={"k": 1.0}, initial={"mode": "free", "x": 1.0, "y": 0.0, "z": 1.0},
        modes={"free": {"x": f"{unit}*k*(y - x)", "y": f"{unit}*k*(x - y)", "z": "-z"}},
    )  # fmt: skip
    assert shifts_of(system).lines.tolist() == [[1.0, 1.0, 0.0]]


def test_a_turn_between_shears_has_no_shifts_and_that_is_soon_known():
    """Expansion of its slopes, which are polynomials of the degree 128, takes minutes."""
    x, y, a, b, w = sympy.symbols("x y a b w", real=True)
    for _ in range(2):
        x += a * y**2
        y += b * x**2
    p, q = x * sympy.cos(w) - y * sympy.sin(w), x * sympy.sin(w) + y * sympy.cos(w)
    for _ in range(2):
        q -= b * p**2
        p -= a * q**2
    system = cd.Map(states="x y", parameters={"a": 0.3, "b": 0.2, "w": 1.0}, images={"x": p, "y": q})
    begin = time.process_time()
    shifts = shifts_of(system)
    assert time.process_time() - begin < 10
    assert not shifts
