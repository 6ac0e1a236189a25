"""Where rebounds come ever faster, the time of rest depends neither on units, nor on the method, nor on modes."""

import math
from functools import cache

import mpmath
import numpy as np
import pytest

import chaosdrill as cd

LIMIT = 4.7719691622793349
"""When a ball on a shaker with e = 1/2 and 1.8 times gravity rests, from 84 rebounds in 60 digits."""


@pytest.fixture(scope="module")
def shaken():
    """The ball in the length unit L and the time unit T."""
    onto = {"guard": "x - A*cos(w*t)", "direction": -1}
    return cd.HybridSystem(
        name="shaken",
        states="x v",
        parameters={"L": 1.0, "T": 1.0, "e": 0.5, "A": 1.8, "w": 1.0, "g": 1.0},
        modes={"fly": {"x": "v", "v": "-g"}, "held": {"x": "-A*w*sin(w*t)", "v": "-A*w**2*cos(w*t)"}},
        transitions=[
            cd.Transition("hit", "fly", "fly", **onto, reset={"v": "-e*v - (1 + e)*A*w*sin(w*t)"}),
            cd.Transition(
                "rest", "fly", "held", **onto, reset={"x": "A*cos(w*t)", "v": "-A*w*sin(w*t)"}, completes="hit"
            ),
            cd.Transition("off", "held", "fly", guard="A*w**2*cos(w*t) - g", direction=1),
        ],
        period="2*pi/w",
    )


@pytest.mark.parametrize("method", ["taylor", "dop853", "radau"])
@pytest.mark.parametrize(("length", "time"), [(1.0, 1.0), (1e-12, 1.0), (1e6, 1e-2), (1e-6, 1e6)])
def test_the_time_of_rest_in_all_units(shaken, length, time, method):
    system = shaken.with_parameters(A=1.8 * length, w=1 / time, g=length / time**2).with_initial(x=2.3 * length)
    for tolerance in (1e-9, 1e-12, 1e-14):
        run = cd.trajectory(system, periods=1, method=method, tolerance=tolerance)
        rest = run["event_time"][run["event_kind"] == 1][0] / time
        assert abs(rest - LIMIT) < max(5 * tolerance, 1e-11)


@pytest.mark.parametrize("method", ["taylor", "dop853", "radau", "rk4"])
@pytest.mark.parametrize("restitution", ["0.9", "0.95"])
def test_the_time_of_rest_after_hundreds_of_rebounds(shaken, restitution, method):
    """On a shaker of 0.6 times gravity, whose rounding hides the last rebounds long before their sum is small."""
    limit = time_of_rest("0.6", restitution)
    # about 1/(1 - e) rebounds count, and the end of all moves by 1/(1 - e) times what one comes too late
    rounding = 30 * 2**-52 * limit / (1 - float(restitution)) ** 2
    system = shaken.with_parameters(A=0.6, e=float(restitution)).with_initial(x=1.1)
    for tolerance in (1e-9, 1e-12, 1e-14):
        given = {"steps": 400} if method == "rk4" else {"tolerance": tolerance}
        run = cd.trajectory(system, periods=6, method=method, **given)
        rest = run["event_time"][run["event_kind"] == 1][0]
        assert abs(float(rest) - limit) < {"taylor": 1e-12, "rk4": 1e-9}.get(method, rounding)


@pytest.mark.parametrize("method", ["taylor", "dop853", "radau", "rk4"])
@pytest.mark.parametrize("speed", [1e-6, 1e-7, 1e-9, 1e-10, 3e-11])
def test_a_first_hit_too_low_for_the_guard_comes_to_rest(shaken, speed, method):
    """Thrown so gently that the guard cannot tell its rebound from none, though none was harder before."""
    system = shaken.with_parameters(A=0.6, e=0.9).with_initial(x=0.6, v=speed)
    run = cd.trajectory(system, periods=1, samples=8, method=method)
    assert run["mode"][-1] == 1
    # it is carried by the shaker, to what a thousand steps of fourth order a period allow
    off = 1e-9 if method == "rk4" else 1e-12
    np.testing.assert_allclose(run["states"].values[:, 0], 0.6 * np.cos(run["time"].values), atol=off)


def above(s, height, rate, amplitude, t, sin):
    """How far the ball is above the shaker a time after a rebound at t."""
    return height + rate * s - s * s / 2 + 2 * amplitude * sin(t + s / 2) * sin(s / 2)


@cache
def time_of_rest(amplitude, restitution):
    """When a ball from 1/2 above the shaker rests, rebound by rebound in 30 digits."""
    with mpmath.workdps(30):
        a, e = mpmath.mpf(amplitude), mpmath.mpf(restitution)
        t, speed, height = mpmath.mpf(0), mpmath.mpf(0), mpmath.mpf(1) / 2
        while height or speed > 1e-18:
            known = (height, speed - a * mpmath.sin(t), a, t)
            s = 2 * speed / (1 - a * mpmath.cos(t))
            if height or speed > 1e-3:
                steps = max(float(s), 0.1) * np.linspace(0.01, 100, 10_000)
                s = steps[np.argmax(above(steps, *map(float, known), np.sin) < 0)]
            s = mpmath.findroot(lambda s, known=known: above(s, *known, mpmath.sin), s, verify=False)
            speed = e * (s - known[1] - a * mpmath.sin(t + s))
            t, height = t + s, mpmath.mpf(0)
        return float(t)


def test_in_lanes_as_in_one_run(shaken):
    found = cd.bifurcation_diagram(shaken.with_initial(x=2.3), {"e": [0.05, 0.1, 0.2]}, transient=20, periods=40)
    assert (found["period"] == 1).all()
    assert np.isneginf(found["lyapunov_exponent"]).all()


@pytest.mark.parametrize("restitution", [0.5, 0.9, 0.99])
def test_a_ball_on_a_floor_rests_after_its_geometric_series(restitution):
    """From the height 1/2 at gravity 1: 1 + 2 e/(1 - e), with few bounces of many left out."""
    onto = {"guard": "x", "direction": -1}
    ball = cd.HybridSystem(
        name="ball",
        states="x v",
        parameters={"e": restitution},
        modes={"fly": {"x": "v", "v": "-1"}, "held": {"x": "0", "v": "0"}},
        transitions=[
            cd.Transition("hit", "fly", "fly", **onto, reset={"v": "-e*v"}),
            cd.Transition("rest", "fly", "held", **onto, reset={"x": "0", "v": "0"}, completes="hit"),
        ],
        initial={"x": 0.5},
    )
    limit = 1 + 2 * restitution / (1 - restitution)
    for duration in (1.5 * limit, 50 * limit):
        run = cd.trajectory(ball, duration=duration)
        assert run["event_kind"][-1] == 1
        assert run["event_time"][-1] == pytest.approx(limit, rel=1e-12)
        assert run.sizes["event"] < 2000


@pytest.fixture(scope="module")
def block():
    """One that rocks from its right edge to its left, as slender as k times the right."""
    upright = {"theta": "0", "v": "0"}
    right = {"guard": "theta", "direction": -1}
    left = {"guard": "theta", "direction": 1}
    return cd.HybridSystem(
        name="block",
        states="theta v",
        parameters={"r": 0.7, "s": 0.7, "k": 1.0},
        modes={"right": {"theta": "v", "v": "theta - 1"}, "left": {"theta": "v", "v": "theta + k"}, "upright": upright},
        transitions=[
            cd.Transition("onto-left", "right", "left", **right, reset={"v": "r*v"}),
            cd.Transition("onto-right", "left", "right", **left, reset={"v": "s*v"}),
            cd.Transition("rest-right", "right", "upright", **right, reset=upright, completes="onto-left"),
            cd.Transition("rest-left", "left", "upright", **left, reset=upright, completes="onto-right"),
        ],
        initial={"mode": "right", "theta": 0.4},
    )


@pytest.mark.parametrize("method", ["taylor", "dop853", "radau", "rk4"])
@pytest.mark.parametrize(("r", "s", "k"), [(0.7, 0.7, 1.0), (0.9, 0.5, 3.0), (0.4, 0.95, 0.6)])
def test_rebounds_that_pass_from_one_mode_to_another(block, r, s, k, method):
    """Hit at the speed v, a block is back after 2 artanh v, or 2 artanh v/k (Housner 1963, BSSA 53, 403-417)."""
    limit, speed = np.arctanh(0.8), 0.8
    for _ in range(400):
        limit += 2 * np.arctanh(r * speed / k) + 2 * np.arctanh(r * s * speed)
        speed *= r * s
    for tolerance in (1e-6, 1e-12):
        given = {"steps": 2000} if method == "rk4" else {"tolerance": tolerance}
        run = cd.trajectory(block.with_parameters(r=r, s=s, k=k), duration=10.0, method=method, **given)
        assert run["mode"][-1] == 2
        off = abs(float(run["event_time"][-1]) - limit)
        assert off < {"taylor": 1e-14 + 1e-4 * tolerance, "rk4": 1e-8}.get(method, 1e-12 + 0.1 * tolerance)


def rests(name, legs, law="{e}", floors=("x",), *, completes=True):
    """A ball that goes from one mode to the next at each rebound; a leg has a restitution and a gravity."""
    modes = {f"fly{i}": {"x": "v", "v": f"-{g}"} for i, (_, g) in enumerate(legs)} | {"held": {"x": "0", "v": "0"}}
    transitions = []
    for i, (e, _) in enumerate(legs):
        onto = {"guard": floors[i % len(floors)], "direction": -1}
        here, there, speed = f"fly{i}", f"fly{(i + 1) % len(legs)}", law.format(e=e)
        transitions.append(cd.Transition(f"hit{i}", here, there, **onto, reset={"v": f"-({speed})*v"}))
        if completes:
            rest = cd.Transition(f"rest{i}", here, "held", **onto, reset={"x": "0", "v": "0"}, completes=f"hit{i}")
            transitions.append(rest)
    return cd.HybridSystem(name=name, states="x v", modes=modes, transitions=transitions, initial={"x": 0.5})


def flights(legs, law, least=1e-300, most=10**6):
    """Times of all flights of that ball, but for what a million rebounds have left below rounding."""
    speed = math.sqrt(legs[0][1])
    times, total = [speed / legs[0][1]], 0.0
    while speed > least and len(times) < most:
        e, _ = legs[(len(times) - 1) % len(legs)]
        total += times[-1]
        speed *= law(e, speed, total)
        times.append(2 * speed / legs[len(times) % len(legs)][1])
    return times


LEGS = {
    "two": [(0.9, 1.0), (0.5, 1.0)],
    "three": [(0.9, 1.0), (0.5, 1.0), (0.7, 1.0)],
    "three gravities": [(0.8, 1.0), (0.8, 2.0), (0.8, 4.0)],
    "five": [(0.95, 1.0), (0.3, 3.0), (0.95, 1.0), (0.99, 0.5), (0.6, 2.0)],
}


@pytest.mark.parametrize("method", ["taylor", "dop853"])
@pytest.mark.parametrize("legs", LEGS.values(), ids=LEGS)
def test_rebounds_through_any_number_of_modes(legs, method):
    limit = math.fsum(flights(legs, lambda e, speed, time: e))
    for tolerance in (1e-12, 1e-6):
        run = cd.trajectory(rests("legs", legs), duration=2 * limit, samples=1, method=method, tolerance=tolerance)
        assert int(run["outcome"]) == 0
        assert run["mode"][-1] == len(legs)
        assert abs(float(run["event_time"][-1]) - limit) < 1e-13 * limit / (1 - math.prod(e for e, _ in legs))


# one floor as the guards of modes write it; some of them vanish elsewhere, too
FLOORS = {
    "a factor": (((0.9, 1.0), (0.5, 2.0)), ("x", "x*(40 + v)")),
    "squares": (((0.9, 2.0), (0.8, 2.0)), ("(x + 1)**2 - 1", "5*x")),
    "zeros elsewhere": (((0.9, 1.0), (0.5, 2.0), (0.7, 3.0)), ("tan(x)", "(x + 1)**2 - 1", "x")),
}


@pytest.mark.parametrize("method", ["taylor", "dop853"])
@pytest.mark.parametrize(("legs", "floors"), FLOORS.values(), ids=FLOORS)
def test_rebounds_off_one_floor_that_each_mode_writes_in_its_own_way(legs, floors, method):
    """They are completed; a ball that is not told to rest stalls, and does not fall through."""
    limit = math.fsum(flights(legs, lambda e, speed, time: e))
    run = cd.trajectory(rests("floors", legs, floors=floors), duration=2 * limit, samples=1, method=method)
    assert int(run["outcome"]) == cd.Outcome.OK
    assert run["mode"][-1] == len(legs)
    assert float(run["event_time"][-1]) == pytest.approx(limit, abs=1e-9)
    restless = rests("restless", legs, floors=floors, completes=False)
    run = cd.trajectory(restless, duration=2 * limit, samples=1, method=method)
    assert int(run["outcome"]) == cd.Outcome.STALLED
    assert float(run["event_time"][-1]) == pytest.approx(limit, abs=1e-7)


# a restitution as text in v, which is negative before a rebound, and the same as a function of speed and time
LAWS = {
    "falling": ("0.8 + 0.5*v", lambda e, speed, time: 0.8 - 0.5 * speed),
    "bell": ("0.6 + 0.3*exp(-v**2)", lambda e, speed, time: 0.6 + 0.3 * math.exp(-(speed**2))),
    "rational": ("0.9/(1 + v**2)", lambda e, speed, time: 0.9 / (1 + speed**2)),
    "elastic in the end": ("1 - 0.5*(-v)**0.2", lambda e, speed, time: 1 - 0.5 * speed**0.2),
    "elastic, slower": ("1 - 0.6*(-v)**0.1", lambda e, speed, time: 1 - 0.6 * speed**0.1),
    "in time": ("0.5 + 0.3*sin(t)", lambda e, speed, time: 0.5 + 0.3 * math.sin(time)),
}


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_rebounds_by_any_law(law):
    """Over when the sum of all flights says so, within the tolerance; the error that is told covers what is off."""
    text, restitution = law
    legs = [(1.0, 1.0)]
    limit = math.fsum(flights(legs, restitution))
    for tolerance in (1e-12, 1e-9, 1e-6):
        ball = rests("law", legs, text)
        run = cd.trajectory(ball, duration=2 * limit, samples=1, tolerance=tolerance)
        assert int(run["outcome"]) == 0
        off = abs(float(run["event_time"][-1]) - limit)
        rounding = 30 * 2**-52 * limit
        assert off < tolerance + rounding
        assert off <= float(run["event_time_error"][-1]) + rounding
        assert not run["event_time_error"][:-1].any()


@pytest.mark.parametrize("method", ["taylor", "dop853"])
def test_tens_of_thousands_of_rebounds_are_over(method):
    """Of 1 - c sqrt(w) all flights from w on take 4 sqrt(w)/c, to first order in sqrt(w)."""
    times = flights([(1.0, 1.0)], lambda e, speed, time: 1 - 0.4 * math.sqrt(speed))
    limit = math.fsum(times[:-1]) + 10 * math.sqrt(times[-1] / 2)
    ball = rests("law", [(1.0, 1.0)], "1 - 0.4*sqrt(-v)")
    run = cd.trajectory(ball, duration=2 * limit, samples=1, tolerance=1e-6, method=method, max_events=60_000)
    assert int(run["outcome"]) == 0
    assert abs(float(run["event_time"][-1]) - limit) < float(run["event_time_error"][-1]) < 1e-6


@pytest.mark.parametrize("method", ["taylor", "dop853", "radau"])
def test_each_of_many_rebounds_off_a_curved_guard_is_met_to_rounding(method):
    """The limit moves by about 66 times what a flight is late by; the guard is rounded to 1e-16."""
    onto = {"guard": "sqrt(1 + x) - 1", "direction": -1}
    ball = cd.HybridSystem(
        states="x v",
        modes={"fly": {"x": "v", "v": "-1"}, "rest": {"x": "0", "v": "0"}},
        transitions=[
            cd.Transition("hit", "fly", "fly", **onto, reset={"v": "-0.97*v"}),
            cd.Transition("rest", "fly", "rest", **onto, reset={"x": "0", "v": "0"}, completes="hit"),
        ],
        initial={"x": 0.5},
    )
    run = cd.trajectory(ball, duration=70.0, samples=1, method=method)
    assert run["event_time"][-1] == pytest.approx(1 + 2 * 0.97 / 0.03, abs=1e-10)


@pytest.mark.parametrize("method", ["taylor", "dop853", "radau"])
@pytest.mark.parametrize("guard", ["x", "x + x**2/2"])
def test_a_ball_that_never_rests_does_not_fall_through_its_floor(guard, method):
    """Off a curved guard its rebounds are lower than what interpolation leaves out."""
    hit = cd.Transition("hit", "fly", "fly", guard, -1, reset={"v": "-0.8*v"})
    modes = {"fly": {"x": "v", "v": "-1"}}
    ball = cd.HybridSystem(name="restless", states="x v", modes=modes, transitions=[hit], initial={"x": 0.5})
    run = cd.trajectory(ball, duration=20.0, samples=1, method=method)
    assert int(run["outcome"]) == cd.Outcome.STALLED
    assert run["event_time"][-1] == pytest.approx(9.0, abs=1e-11)
    assert (run["event_speed"] < 0).all()


@pytest.mark.parametrize("method", ["taylor", "dop853", "radau"])
@pytest.mark.parametrize(
    ("guard", "fewest", "most"), [("sin(x + y) - sin(y)", 80, 110), ("(x + y)**2 - y**2", 300, 400)]
)
def test_low_rebounds_are_met_while_they_can_be_told_from_rounding(guard, fewest, most, method):
    """Terms that interpolation gives a guard in a long step do not count where its slope has led it out of rounding.

    The polynomial is x*(x + 2*y), whose rounding falls with x: hits go on until flights are lost in that of time.
    """
    hit = cd.Transition("hit", "fly", "fly", guard, -1, reset={"v": "-0.9*v"})
    modes = {"fly": {"x": "v", "v": "-1", "y": "0"}}
    ball = cd.HybridSystem(name="low", states="x v y", modes=modes, transitions=[hit], initial={"x": 1e-10, "y": 1.0})
    first = np.sqrt(2e-10)
    run = cd.trajectory(ball, duration=40 * first, samples=1, method=method)
    assert int(run["outcome"]) == cd.Outcome.STALLED
    # the rounding of the sines, about 2e-16, is a thousandth of the height of the thirtieth rebound
    met = first * (2 * np.cumsum(0.9 ** np.arange(30)) - 1)
    np.testing.assert_allclose(run["event_time"].values[:30], met, rtol=1e-3)
    assert fewest < run.sizes["event"] < most


@pytest.mark.parametrize("method", ["taylor", "dop853", "radau"])
def test_a_surface_that_each_mode_writes_in_its_own_way_is_hit_from_the_right_side(method):
    """The other mode begins where rounding has left the state beyond its guard; all hits keep a share of 4/5."""
    onto = [
        cd.Transition("onto-left", "right", "left", "theta", -1, reset={"v": "0.8*v"}),
        cd.Transition("onto-right", "left", "right", "(theta + 1)**2 - 1", +1, reset={"v": "0.8*v"}),
    ]
    modes = {"right": {"theta": "v", "v": "theta - 1"}, "left": {"theta": "v", "v": "theta + 1"}}
    block = cd.HybridSystem(name="two ways", states="theta v", modes=modes, transitions=onto)
    for speed in np.geomspace(1e-3, 0.5, 12):
        start = block.with_initial(mode="right", theta=0.0, v=speed)
        run = cd.trajectory(start, duration=9 * speed, samples=1, method=method)
        hits = run["event_state_before"].values[:9, 1]
        expected = [-speed * (-0.8) ** k for k in range(hits.size)]
        assert hits.size >= 8 or speed > 0.2
        np.testing.assert_allclose(hits, expected, rtol=1e-6)


@pytest.mark.parametrize("method", ["taylor", "dop853", "radau"])
def test_a_contact_is_left_without_a_speed_and_an_acceleration(method):
    """As the third power of time, beside which an interpolation may have a second one of either sign."""
    system = cd.HybridSystem(
        states="y v",
        parameters={"A": 1.3},
        modes={"fly": {"y": "v", "v": "A*sin(t) - 1"}, "held": {"y": "0", "v": "0"}},
        transitions=[
            cd.Transition("rest", "fly", "held", guard="y", direction=-1, reset={"y": "0", "v": "0"}),
            cd.Transition("off", "held", "fly", guard="1 - A*sin(t)", direction=-1),
        ],
        period="2*pi",
        initial={"mode": "held"},
    )
    for tolerance in (1e-8, 1e-10, 1e-12):
        run = cd.trajectory(system, periods=5, method=method, tolerance=tolerance)
        assert list(run["event_kind"].values) == [1, 0] * 5
        off = run["event_time"].values[::2]
        assert np.allclose(off, math.asin(1 / 1.3) + 2 * math.pi * np.arange(5), rtol=0, atol=1e-13)
