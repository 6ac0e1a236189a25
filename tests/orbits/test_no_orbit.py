"""A start that leads to no orbit gets an outcome and words, never numbers; a slow return is one."""

from math import sqrt

import numpy as np
import pytest
import sympy
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import chaosdrill as cd
from chaosdrill.dataset import Outcome
from chaosdrill.dataset.branches import Special
from chaosdrill.engine.numerics import Numerics
from chaosdrill.orbits import guess
from chaosdrill.orbits.find import find_orbit
from chaosdrill.systems import build

x, v, y, z, t, c, w = sympy.symbols("x v y z t c w", real=True)


def nothing(system, outcome, words, period=1, start="guess", transient=100):
    found = find_orbit(system, period, start, transient, Numerics(tolerance=1e-13))
    assert found.outcome == outcome, found.message
    assert words in found.message
    assert found.period == period
    assert len(found.states) == len(found.event_times) == 0
    assert np.isnan(found.multipliers).all()
    assert np.isnan(found.residual)


def test_chatter_that_never_rests():
    pressed = build("impact-oscillator", {"wall": -0.5, "amplitude": 0.1}, initial={"x": -0.6})
    nothing(pressed, Outcome.STALLED, "infinitely many impacts")


def test_a_state_beyond_a_guard():
    nothing(build("impact-oscillator", initial={"x": 0.5}), Outcome.INVALID_START, "beyond a guard")


def test_where_newtons_method_leads_is_no_start():
    """No orbit of period 3 exists; a solution of the equations lies beyond the guard, the initial state does not."""
    modes = {"soft": {"x": "v", "v": "-k*x - c*v + a*cos(w*t)"}}
    modes["hard"] = {"x": "v", "v": "-k*x - c*v + a*cos(w*t) - 3*(x - s) - g"}
    system = cd.HybridSystem(
        name="two-springs",
        states="x v",
        parameters={
            "w": 2.27613591,
            "a": 0.40058849,
            "c": 0.07481378,
            "k": 0.59855634,
            "g": 0.2832684,
            "s": 0.05769506,
        },
        modes=modes,
        transitions=[
            cd.Transition("up", "soft", "hard", "x - s", direction=+1),
            cd.Transition("down", "hard", "soft", "x - s", direction=-1),
        ],
        period="2*pi/w",
        initial={"v": 0.1},
    )
    nothing(system, Outcome.INADMISSIBLE, "the equations close", 3)


@pytest.mark.parametrize("start", ["guess", "attractor"])
def test_a_motion_that_repeats_after_other_periods_says_after_how_many(start):
    """A neuron with a periodic current spikes five times in three periods; of period 1 it has no orbit."""
    drive = {"modes": {"rest": {"v": "1.2 + 0.3*sin(2*t) - v"}}, "period": "pi"}
    spike = cd.Transition("spike", "rest", "rest", guard="v - 1", direction=1, reset={"v": 0})
    neuron = cd.HybridSystem(states="v", transitions=[spike], **drive)
    nothing(neuron, Outcome.NO_ORBIT, "the motion from the start repeats after 3 periods: give period=3", start=start)
    assert find_orbit(neuron, 3, "attractor", 100, Numerics(tolerance=1e-13)).outcome == Outcome.PERIODIC


@pytest.mark.parametrize("friction", [0.1, 0.3])
def test_a_stay_that_dies_out_is_in_doubt(friction):
    """At half the natural frequency motions without a stop come back from wherever they start, x > 1 + S at phase 0.

    Those that stop there for a time t, x = S + cos(t/2), come back closer to that edge by t**3: Newton's method takes
    a third of t off a step, and what it ends with is as good as the orbit without the stop.
    """
    slow = cd.periodic_orbit(cd.build("den-hartog", parameters={"omega": 0.5, "S": friction}))
    assert "the stay in mode 'stick' lasts" in slow.attrs["message"]
    assert float(slow["multiplier_real"][0]) == pytest.approx(1, abs=1e-6)


def test_a_mode_that_escapes(drill):
    nothing(drill.with_initial(y=-1.0, u=2.0), Outcome.ESCAPED, "runs away")
    nothing(drill.with_parameters(eta=0.48), Outcome.ESCAPED, "ended", start="attractor")


@pytest.mark.parametrize("rho", [0.5, 10.0])
def test_a_flow_that_comes_to_rest(rho):
    nothing(build("lorenz", {"rho": rho}), Outcome.EQUILIBRIUM, "comes to rest", start="attractor")


@pytest.mark.parametrize(("start", "longest"), [("attractor", 32), ("guess", 256)])
def test_a_motion_at_rest_is_followed_no_longer(start, longest, monkeypatch):
    """Units of time over which a return is looked for; at first it has to come to rest."""
    followed, lengths = guess.events_of, []

    def counted(run, periods, samples=None):
        lengths.append(periods)
        return followed(run, periods, samples)

    monkeypatch.setattr(guess, "events_of", counted)
    nothing(build("lorenz", {"rho": 10.0}), Outcome.EQUILIBRIUM, "comes to rest", start=start)
    assert max(lengths) <= longest


def test_a_flow_that_starts_at_rest():
    at_rest = sqrt(8 / 3 * 27)
    for x in (0.0, at_rest):
        start = {"x": x, "y": x, "z": 27.0 if x else 0.0}
        nothing(build("lorenz", initial=start), Outcome.EQUILIBRIUM, "comes to rest")


def test_a_forced_system_without_force(drill):
    words = "a point at rest"
    nothing(build("impact-oscillator", {"amplitude": 0.0}), Outcome.EQUILIBRIUM, words, start="attractor")
    nothing(drill.with_parameters(a=0.0, b=0.3), Outcome.EQUILIBRIUM, words, start="attractor")


@pytest.fixture(scope="module")
def mathieu():
    """A pendulum whose support shakes: it stays at rest, and the forcing acts on what is beside."""
    q, p, t = sympy.symbols("q p t", real=True)
    amplitude, damping = sympy.symbols("amplitude damping", real=True)
    return cd.HybridSystem(
        name="mathieu",
        states=(q, p),
        time=t,
        parameters={"amplitude": 0.05, "damping": 0.04},
        modes={"on": {q: p, p: -damping * p - (1 + amplitude * sympy.cos(2 * t)) * q - q**3}},
        period=sympy.pi,
        initial={q: 0.0, p: 0.0},
    )


def test_a_rest_under_parametric_forcing_is_an_orbit(mathieu):
    """The tongue of Mathieu's equation, by SciPy's monodromy matrix; without forcing it is a point at rest."""

    def largest(amplitude):
        def field(t, s):
            return [s[1], -0.04 * s[1] - (1 + amplitude * np.cos(2 * t)) * s[0]]

        ends = [solve_ivp(field, (0, np.pi), s, "DOP853", rtol=1e-12, atol=1e-14).y[:, -1] for s in np.eye(2)]
        return np.linalg.eigvals(np.transpose(ends)).real.min()

    found = cd.continue_orbit(mathieu, {"amplitude": (0.02, 0.14)}, start="guess")
    assert found["special_point"].values.max() == Special.PERIOD_DOUBLING
    assert found["special_value"].values == pytest.approx(brentq(lambda a: largest(a) + 1, 0.05, 0.12), abs=1e-10)
    nothing(mathieu.with_parameters(amplitude=0.0), Outcome.EQUILIBRIUM, "a point at rest")


def test_an_angle_that_only_grows():
    angle, rate = sympy.symbols("angle rate", real=True)
    turning = cd.HybridSystem(
        name="turning",
        states=(angle, rate),
        parameters={},
        # by no shift is this what it was
        modes={"on": {angle: rate, rate: 1 + sympy.cos(angle) / (1 + angle**2) - rate}},
        initial={"mode": "on", angle: 0.0, rate: 1.0},
    )
    nothing(turning, Outcome.OPEN, "angle changes by", start="attractor")


@pytest.mark.parametrize(
    ("slow", "start"), [(1e-4, {"start": "attractor", "transient": 5e4}), (1e-6, {"start": "guess"})]
)
def test_a_slow_switch_returns(slow, start):
    # between two switches the other state comes to rest, but for rounding
    system = cd.HybridSystem(
        name="slow switch",
        states="x s",
        parameters={"slow": slow},
        modes={"up": {"x": "1 - x", "s": "slow"}, "down": {"x": "-x", "s": "-slow"}},
        transitions=[
            cd.Transition("top", "up", "down", guard="s - 1", direction=+1),
            cd.Transition("bottom", "down", "up", guard="s", direction=-1),
        ],
        initial={"x": 0.0, "s": 0.5, "mode": "up"},
    )
    found = cd.periodic_orbit(system, **start)
    assert int(found["outcome"]) == Outcome.PERIODIC
    assert float(found["period_time"]) == pytest.approx(2 / slow, rel=1e-11)
    assert np.sort(found["event_state_before"].sel(state="x").values) == pytest.approx([0, 1], abs=1e-12)


def test_a_slow_drift_from_off_its_cycle_is_no_rest():
    sawtooth = {
        "states": "x s", "modes": {"only": {"x": "-x + a*cos(w*t)", "s": "-1e-6"}}, "initial": {"x": 1.0},
        "transitions": [cd.Transition("down", "only", "only", "s + 1", direction=-1, reset={"s": "0"})],
    }  # fmt: skip
    free = cd.HybridSystem(**sawtooth, parameters={"a": 0.0, "w": 1.0, "t": 0.0})
    forced = cd.HybridSystem(**sawtooth, parameters={"a": 0.1, "w": 0.1}, period="2*pi/w")
    for system, length in ((free, "a time of 1e+06"), (forced, "1.6e+04 periods")):
        found = cd.periodic_orbit(system, start="guess")
        assert int(found["outcome"]) == Outcome.NO_ORBIT
        assert f"meets a guard only after about {length}" in found.attrs["message"]


def test_a_wrong_period_makes_no_motion_grow():
    """To and fro in 2, looked at every 2.01: each time it is a little farther on its way."""
    to_and_fro = cd.HybridSystem(
        name="to and fro", states="x", parameters={}, period="2.01", initial={"x": 0.0, "mode": "up"},
        modes={"up": {"x": "1"}, "down": {"x": "-1"}},
        transitions=[cd.Transition("top", "up", "down", "x - 1", 1), cd.Transition("bottom", "down", "up", "x", -1)],
    )  # fmt: skip
    nothing(to_and_fro, Outcome.NO_ORBIT, "Newton's method")


def test_a_period_that_no_orbit_has():
    # counted by another program: no orbit of period 3 or 5
    for period in (3, 5):
        nothing(build("impact-oscillator"), Outcome.NO_ORBIT, "Newton's method", period, "attractor")
