"""The implicit method: its coefficients, its step and the derivative of that, stiff problems with a known end."""

import math

import mpmath
import numpy as np
import pytest
import sympy

import chaosdrill as cd
from chaosdrill.engine import radau_tables as tables
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run
from chaosdrill.engine.stepper import stepper

X, V, MU, RATE = sympy.symbols("x v mu rate", real=True)
TOLERANCES = {3: 2e-5, 5: 1e-7, 7: 1e-12}
"""By the number of stages that they ask for. What Newton's method leaves of a step is part of its differences, not of
its tangents: at 1e-4 that may be 1.3e-6 of them, at half of it 4e-9, whatever the distance of the starts."""


@pytest.fixture(scope="module")
def relaxing():
    """Van der Pol's equation, with the trace of its Jacobian as a quadrature, and a mark; and a decay onto a motion."""
    t = sympy.Symbol("t", real=True)
    return cd.HybridSystem(
        name="relaxing",
        states=(X, V),
        time=t,
        parameters={"mu": 1e3, "rate": 1e6},
        modes={
            "oscillator": {X: V, V: MU * (1 - X**2) * V - X},
            "follower": {X: -RATE * (X - sympy.cos(t)) - sympy.sin(t), V: 0},
        },
        transitions=[
            cd.Transition("pass", "oscillator", "oscillator", guard=X, direction=+1),
            cd.Transition("dip", "follower", "follower", guard=X - sympy.Rational(1, 2), direction=-1),
        ],
        quadratures={"trace": MU * (1 - X**2)},
        initial={"mode": "oscillator", X: 2.0, V: 0.0},
    )


def step(system, mode, start, length, tolerance):
    """State and tangents after one step of a length, whatever its error."""
    run = Run(
        system.with_initial(mode=mode, x=start[0], v=start[1]),
        1.0,
        Numerics("radau", tolerance),
        tangents=np.eye(2),
        orthonormalise=False,
    )
    run.advance(0)
    run.states.run["next_step"] = 0.5 * length
    functions, place = stepper("radau"), int(run.machine)
    functions.expand(place, 0, 0.0)
    functions.advance(place, 0, 0.0, length)
    return run._scratch.out[:2].copy(), run.vectors.copy()


def test_three_stages_are_those_of_the_book():
    """Hairer and Wanner II, table IV.5.6; the eigenvalue is that of section IV.8."""
    r = math.sqrt(6)
    weights = [
        [(88 - 7 * r) / 360, (296 - 169 * r) / 1800, (-2 + 3 * r) / 225],
        [(296 + 169 * r) / 1800, (88 + 7 * r) / 360, (-2 - 3 * r) / 225],
        [(16 - r) / 36, (16 + r) / 36, 1 / 9],
    ]
    np.testing.assert_allclose(tables.WEIGHTS_OF_RATES[0, :3, :3], weights, atol=2e-16)
    assert 1 / tables.PIVOT[0] == pytest.approx(3 + 3 ** (2 / 3) - 3 ** (1 / 3), rel=1e-14)


@pytest.mark.parametrize("stages", TOLERANCES)
def test_the_order_is_twice_the_number_of_stages_less_one(stages):
    weights = tables.WEIGHTS_OF_RATES[stages // 2 - 1, stages - 1, :stages]
    nodes = tables.NODES[stages // 2 - 1, 1 : stages + 1]
    for k in range(1, 2 * stages):
        assert weights @ nodes ** (k - 1) == pytest.approx(1 / k, abs=3e-16)
    assert abs(weights @ nodes ** (2 * stages - 1) - 1 / (2 * stages)) > 1e-9


@pytest.mark.parametrize("stages", TOLERANCES)
@pytest.mark.parametrize("z", [-0.5, -3.0, -30.0, -1e6])
def test_a_step_of_a_linear_decay_is_pades(relaxing, stages, z):
    """The factor of a step is Padé's approximation of exp(z) with one degree more below; that of a tangent exp(z)."""
    with mpmath.workdps(40):
        above, below = mpmath.pade(mpmath.taylor(mpmath.exp, 0, 2 * stages - 1), stages - 1, stages)
        factor = float(mpmath.polyval(above[::-1], z) / mpmath.polyval(below[::-1], z))
    length = 0.25
    system = relaxing.with_parameters(rate=-z / length)
    up, tangents = step(system, "follower", (2.0, 0.0), length, TOLERANCES[stages])
    down, _ = step(system, "follower", (1.0, 0.0), length, TOLERANCES[stages])
    assert up[0] - down[0] == pytest.approx(factor, rel=1e-9, abs=2e-13)
    assert tangents[0, 0] == pytest.approx(math.exp(z), rel=TOLERANCES[stages], abs=0.0)
    assert tangents[1].tolist() == [0.0, 1.0]


@pytest.mark.parametrize("stages", TOLERANCES)
def test_tangents_are_the_derivative_of_the_step_and_not_of_the_flow(relaxing, stages):
    system, start, e = relaxing.with_parameters(mu=3.0), np.array([1.2, -1.0]), 1e-4
    length = {3: 0.3, 5: 0.5, 7: 0.6}[stages]
    found = step(system, "oscillator", start, length, TOLERANCES[stages])[1]

    def ends(size):
        return [step(system, "oscillator", start + d, length, TOLERANCES[stages])[0] for d in size * np.eye(2)]

    near, far = (np.subtract(ends(k * e), ends(-k * e)) / (2 * k * e) for k in (1, 2))
    differences = (4 * near - far) / 3
    flow = cd.trajectory(system.with_initial(x=1.2, v=-1.0), duration=length, samples=1, tolerance=1e-14, tangents=True)
    off = np.abs(found - flow["final_tangent"].values).max()
    assert np.abs(found - differences).max() < min(1e-6, 0.01 * off)


def test_the_published_end_of_van_der_pol(relaxing):
    """VDPOL of Hairer and Wanner's test set: 1e-6 in time units of 1000, x' in units of 1/1000, from (2, 0) to 2."""
    for tolerance, steps in ((1e-6, 200), (1e-9, 300), (1e-12, 500)):
        run = Run(relaxing, 2000.0, Numerics("radau", tolerance))
        assert run.advance(1)[0] == cd.Outcome.OK
        found = run.x * [1, 1000]
        np.testing.assert_allclose(found, [1.706167732170483, -0.8928097010247975], atol=tolerance)
        assert run.steps < steps


@pytest.mark.parametrize("mu", [1e3, 1e6])
def test_the_period_of_relaxation_is_that_of_the_expansion(relaxing, mu):
    """Dorodnitsyn's expansion for large mu; what it leaves out is of the order mu**(-4/3), less the logarithm of it."""
    zero = 2.338107410459767
    period = (3 - 2 * math.log(2)) * mu + 3 * zero * mu ** (-1 / 3) - 2 / 3 * math.log(mu) / mu - 1.3246 / mu
    run = cd.trajectory(relaxing.with_parameters(mu=mu), duration=6 * mu, samples=1, method="radau")
    periods = np.diff(run["event_time"].values)
    np.testing.assert_allclose(periods, period, rtol=0, atol=mu ** (-4 / 3) + 1e-12 * mu)


@pytest.mark.parametrize("mu", [1e3, 1e6])
def test_multipliers_of_the_relaxation_are_one_and_nothing(relaxing, mu):
    """Between, tangents along the flow grow by mu**2 with the speed, and lose as many digits when they return."""
    found = []
    for near in mu * (1 + np.arange(-4, 5) / 1000):
        system = relaxing.with_parameters(mu=near)
        marks = cd.trajectory(system, duration=4 * near, samples=1, method="radau")["event_time"].values
        begin = marks[0] + 0.5 * near
        to = Run(system, begin, Numerics("radau", 1e-12))
        to.advance(1)
        around = Run(
            system.with_initial(x=to.x[0], v=to.x[1]),
            marks[1] - marks[0],
            Numerics("radau", 1e-12),
            tangents=np.eye(2),
            orthonormalise=False,
        )
        around.advance(1)
        assert around.steps < 5000
        np.testing.assert_allclose(around.x, to.x, rtol=1e-9)
        large, small = sorted(np.abs(np.linalg.eigvals(around.vectors)), reverse=True)
        assert small < 1e-12
        found.append(large)
    # what rounding does to one of them is by chance; to the mean of nine it does a third of that
    assert np.mean(found) == pytest.approx(1, abs=5e-9 + 5e-16 * mu**2)


def test_exponents_add_up_to_the_mean_trace(relaxing):
    system = relaxing.with_parameters(mu=30.0)
    run = cd.lyapunov_spectrum(system, transient=100.0, duration=200.0, blocks=2, method="radau", tolerance=1e-9)
    trace = cd.trajectory(system, transient=100.0, duration=200.0, samples=1)["trace"].values
    mean = (trace[-1] - trace[0]) / 200.0
    assert float(run["lyapunov_exponent"].sum()) == pytest.approx(mean, rel=1e-8)


def test_what_follows_a_motion_stiffly_meets_a_guard_when_that_does(relaxing):
    """x = cos t, beside exp(-1e6 t) which is over at once: the guard at 1/2 is met at pi/3 and a turn later."""
    run = cd.trajectory(relaxing.with_initial(mode="follower", x=1.5), duration=10.0, samples=50, method="radau")
    np.testing.assert_allclose(run["event_time"], [math.pi / 3, math.pi / 3 + 2 * math.pi], atol=1e-11)
    np.testing.assert_allclose(run["states"][1:, 0], np.cos(run["time"][1:]), atol=1e-11)


def test_a_level_next_to_the_turn_of_what_is_stiff_is_met_if_it_is_below():
    """x = cos(t - a), as tan a = 1/k, but for a factor: one step passes its turn, and others."""
    system = cd.HybridSystem(
        states="x",
        parameters={"k": 1.0, "level": 1.0},
        modes={"on": {"x": "-k*(x - cos(t))"}},
        transitions=[cd.Transition(name, "on", "on", "x - level", way) for name, way in (("up", 1), ("down", -1))],
        initial={"x": 0.0},
    )
    turns = 2 * np.pi * np.arange(1, 4)[:, np.newaxis]
    for k in (1e5, 1e6, 1e7):
        for tolerance in (1e-6, 1e-8, 1e-10):
            for off in (1e-2, 1e-3, -1e-3, -1e-2):
                here = system.with_parameters(k=k, level=(1 + off) / np.hypot(1, 1 / k))
                run = cd.trajectory(here, duration=22.0, samples=1, method="radau", tolerance=tolerance)
                apart = np.array([-1, 1]) * np.arccos(min(1 + off, 1.0))
                expected = (turns + np.arctan(1 / k) + apart).ravel() if off < 0 else []
                found = run["event_time"].values
                np.testing.assert_allclose(found[found > 1], expected, rtol=0, atol=10 * tolerance / np.sqrt(abs(off)))


def test_a_damped_oscillator_follows_a_slow_load_to_its_end():
    """Steps are as long as the load; that one has to be as short as the decay says nothing of the next."""
    system = cd.HybridSystem(
        states="x v", parameters={"w": 1.0, "k": 1.0}, modes={"on": {"x": "v", "v": "k**2*(cos(w*t) - x) - 0.3*k*v"}}
    )
    for k in (1.0, 1e5):
        for w in k * np.geomspace(1e-8, 1e-5, 12):
            turns = 12.0
            run = cd.trajectory(system.with_parameters(w=w, k=k), duration=turns / w, samples=1, method="radau")
            assert run["outcome"] == cd.Outcome.OK
            follows = np.exp(1j * turns) / (1 - (w / k) ** 2 + 0.3j * w / k)
            np.testing.assert_allclose(run["states"][-1] / [1, k], np.real([follows, 1j * w / k * follows]), atol=1e-10)


def test_a_rate_may_pass_the_smallest_doubles_on_its_way_up():
    passing = cd.HybridSystem(
        states="a y u", modes={"on": {"a": "u", "y": "exp(1000*u)*cos(u)", "u": "1"}}, initial={"u": -0.8}
    )
    run = cd.trajectory(passing, duration=0.8, samples=1, method="radau")
    assert run["outcome"] == cd.Outcome.OK
    np.testing.assert_allclose(run["states"][-1, :2], [-0.32, 1000 / 1000001], rtol=1e-9)


@pytest.fixture(scope="module")
def slaved():
    """Two stiff relaxations after a slow one, the first of which a clock takes half of twice a period."""
    t, y, z, a, b = sympy.symbols("t y z a b", real=True)
    return cd.HybridSystem(
        states=(X, y, z),
        time=t,
        parameters={"a": 1e3, "b": 1e6},
        modes={"on": {X: -X / 2 + sympy.cos(t), y: -a * (y - X / 3 - z / 2), z: -b * (z - X - sympy.cos(t))}},
        transitions=[cd.Transition("half", "on", "on", guard=sympy.sin(t - 1), direction=0, reset={y: y / 2 + X * z})],
        period=2 * sympy.pi,
        initial={X: 0.1, y: 0.0, z: 0.0},
    )


@pytest.mark.parametrize("rate", [10.0, 1e3, 1e5, 1e8])
def test_a_relaxation_has_its_rate_as_exponent_at_the_cost_of_its_motion(relaxing, rate):
    system = relaxing.with_initial(mode="follower", x=1.5).with_parameters(rate=rate)
    alone = Run(system, 20.0, Numerics("radau", 1e-10))
    alone.advance(1)
    beside = Run(system, 20.0, Numerics("radau", 1e-10), tangents=np.array([[0.6, 0.8], [0.8, -0.6]]))
    beside.advance(1)
    assert beside.steps < 2 * alone.steps
    run = cd.lyapunov_spectrum(system, duration=20.0, transient=10.0, method="radau", tolerance=1e-10)
    off = np.abs(run["lyapunov_exponent"] - [0.0, -rate])
    assert (off <= 2 * run["lyapunov_error"]).all()
    assert (run["lyapunov_error"] < 1e-9 * max(rate, 1.0)).all()


@pytest.mark.parametrize("rates", [(10.0, 100.0), (1e3, 1e6), (1e7, 1e3)])
def test_exponents_of_two_stiff_directions_and_of_what_resets_take(slaved, rates):
    system = slaved.with_parameters(a=rates[0], b=rates[1])
    expected = sorted([-0.5, -rates[0] - 2 * math.log(2) / (2 * math.pi), -rates[1]], reverse=True)
    run = cd.lyapunov_spectrum(system, periods=10, transient=3, method="radau", tolerance=1e-10)
    assert (np.abs(run["lyapunov_exponent"] - expected) <= 2 * run["lyapunov_error"]).all()
    np.testing.assert_allclose(run["lyapunov_exponent"], expected, rtol=1e-10)
    orbit = cd.periodic_orbit(system, method="radau", tolerance=1e-10)
    assert orbit["outcome"] == cd.Outcome.PERIODIC
    assert orbit["consistent"]
    np.testing.assert_allclose(orbit["lyapunov_exponent"], expected, rtol=1e-9)
    known = np.exp(2 * math.pi * np.array(expected))
    np.testing.assert_allclose(orbit["multiplier_real"], known, rtol=1e-8, atol=1e-300)


@pytest.mark.parametrize("rates", [(10.0, 100.0), (1e3, 1e6)])
def test_a_direction_that_decays_and_moves_no_other_state_stays_where_it_is(slaved, rates):
    """From the first period on: what rounding puts beside it would soon be all of it."""
    run = cd.finite_time_exponents(slaved.with_parameters(a=rates[0], b=rates[1]), periods=40, method="radau")
    expected = [-0.5, -rates[0] - 2 * math.log(2) / (2 * math.pi), -rates[1]]
    np.testing.assert_allclose(run["lyapunov_exponent"], expected, rtol=1e-9)
