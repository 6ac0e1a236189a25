"""Tangents across events that come with the reset of another one: as across the one event that they are together."""

import numpy as np
import pytest

import chaosdrill as cd

FIELD = {"x": "1 + y/5", "y": "-p*y/2", "z": "q*y - z + cos(t)"}
SLOW = {"x": "1/4", "y": "-p*y/3", "z": "-z"}
PLANE = {"p": [0.9, 1.0, 1.1], "q": [0.5, 1.0, 2.0]}
START = {"x": 0.1, "y": 0.8, "z": 0.3}


def system(modes, *transitions):
    made = [
        cd.Transition(name, source, target, guard=guard, direction=direction, reset=reset)
        for name, source, target, guard, direction, reset in transitions
    ]
    values = {"p": 1.0, "q": 1.0}
    return cd.HybridSystem(
        name="thrown", states="x y z", parameters=values, modes=modes, transitions=made, initial=START
    )


def over_a_guard():
    """A kick of y at x = 1 takes it over 1, where it is changed once more, with z; apart, and as one event."""
    kick = {"x": "x - 1", "y": "y + 1", "z": "z/2"}
    apart = system(
        {"run": FIELD},
        ("kick", "run", "run", "x - 1", 1, kick),
        ("over", "run", "run", "y - 1", 1, {"y": "y/4", "z": "z + 3*x + y**2", "x": "x + y/10"}),
    )
    one = {"x": "x - 1 + (y + 1)/10", "y": "(y + 1)/4", "z": "z/2 + 3*(x - 1) + (y + 1)**2"}
    return apart, system({"run": FIELD}, ("kick", "run", "run", "x - 1", 1, one))


def through_a_mode():
    """The mode that is entered at x = 1 is left at once, and so is the next; or the last one is entered."""
    modes = {"run": FIELD, "mid": {"x": "7", "y": "-3*y", "z": "5*x"}, "next": {"x": "0", "y": "2", "z": "t"}}
    back = ("back", "slow", "run", "x - 2", 1, {"x": "x - 2", "y": "y + 1/2"})
    apart = system(
        {**modes, "slow": SLOW},
        ("enter", "run", "mid", "x - 1", 1, {"z": "z + x*y"}),
        ("pass", "mid", "next", "x - 1/2", 1, {"y": "y + z/8"}),
        ("leave", "next", "slow", "z + 9", 1, {}),
        back,
    )
    together = ("enter", "run", "slow", "x - 1", 1, {"z": "z + x*y", "y": "y + (z + x*y)/8"})
    return apart, system({"run": FIELD, "slow": SLOW}, together, back)


PAIRS = {"over a guard": over_a_guard(), "through modes": through_a_mode()}


@pytest.mark.parametrize("method", ["taylor", "dop853", "radau"])
@pytest.mark.parametrize("pair", PAIRS)
def test_tangents_are_those_of_one_event(pair, method):
    apart, one = (
        cd.trajectory(each, duration=6.0, samples=3, tangents=True, method=method, progress=False)
        for each in PAIRS[pair]
    )
    assert apart["event_time"].size > one["event_time"].size > 2
    np.testing.assert_allclose(apart["states"], one["states"], rtol=0, atol=1e-10)
    np.testing.assert_allclose(apart["final_tangent"], one["final_tangent"], rtol=0, atol=1e-9)


@pytest.mark.parametrize("pair", PAIRS)
def test_tangents_are_differences_of_two_runs(pair):
    apart, step = PAIRS[pair][0], 1e-5

    def end(state, off):
        start = apart.with_initial(**{state: START[state] + off})
        return cd.trajectory(start, duration=6.0, samples=1, progress=False)["states"].values[-1]

    differences = [(end(state, step) - end(state, -step)) / (2 * step) for state in START]
    run = cd.trajectory(apart, duration=6.0, samples=1, tangents=True, progress=False)
    np.testing.assert_allclose(run["final_tangent"].values, differences, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("pair", PAIRS)
def test_exponents_are_those_of_one_event(pair):
    """However many are asked for, and in the lanes of a sweep; orthonormalisation may fall between the two events."""
    settings = {"transient": 60.0, "progress": False}
    for count in (1, 3):
        apart, one = (
            cd.lyapunov_spectrum(each, duration=50.0, exponents=count, **settings)["lyapunov_exponent"].values
            for each in PAIRS[pair]
        )
        np.testing.assert_allclose(apart, one, rtol=0, atol=1e-8)
    apart, one = (
        cd.parameter_chart(each, PLANE, duration=25.0, exponents=3, max_extension=0, **settings) for each in PAIRS[pair]
    )
    np.testing.assert_allclose(apart["lyapunov_exponent"], one["lyapunov_exponent"], rtol=0, atol=1e-8)


@pytest.fixture(scope="module")
def cells():
    return cd.HybridSystem(
        name="pair",
        states="x y",
        modes={"rest": {"x": "1.3 - x", "y": "1.25 - y"}},
        transitions=[
            cd.Transition("first", "rest", "rest", guard="x - 1", direction=+1, reset={"x": "0", "y": "1.3*y"}),
            cd.Transition("second", "rest", "rest", guard="y - 1", direction=+1, reset={"y": "0", "x": "x + 0.2"}),
        ],
        initial={"x": 0.3, "y": 0.2},
    )


def test_rank_that_two_events_lose_together_is_lost(cells):
    """Two cells that fire together start from one state whatever they were: one exponent is zero, the other -inf."""
    period = np.log(1.1 / 0.3)
    spectrum = cd.lyapunov_spectrum(cells, duration=1000 * period, transient=100.0, progress=False)
    assert spectrum.cd.outcome == "periodic"
    assert spectrum["lyapunov_exponent"].values[0] == pytest.approx(0.0, abs=1e-10)
    assert spectrum["lyapunov_exponent"].values[1] == -np.inf


def test_an_orbit_with_two_events_in_one_is_refused_by_name(cells):
    orbit = cd.periodic_orbit(cells, at="first", progress=False)
    assert orbit.cd.outcome == "no_orbit"
    assert "the reset of 'first' throws the state across the guard of 'second'" in orbit.attrs["message"]


def test_an_orbit_of_two_that_hit_together_is_not_refused():
    """Two oscillators that do the same, read from chaos, where no guess closes: the orbit of one of them, twice."""
    walls = [
        cd.Transition(f"at {x}", "free", "free", guard=f"{x} - 0.3", direction=+1, reset={v: f"-0.8*{v}"})
        for x, v in ("xv", "yw")
    ]
    modes = {"free": {"x": "v", "v": "-x - v/10 + cos(5*t/2)", "y": "w", "w": "-y - w/10 + cos(5*t/2)"}}
    both = cd.HybridSystem(name="both", states="x v y w", modes=modes, transitions=walls, period="4*pi/5")
    orbit = cd.periodic_orbit(both, period=2, progress=False)
    assert orbit.cd.outcome == "periodic"
    one = cd.HybridSystem(
        name="one",
        states="x v",
        modes={"free": {s: modes["free"][s] for s in "xv"}},
        transitions=walls[:1],
        period="4*pi/5",
    )
    alone = cd.periodic_orbit(one, period=2, progress=False)
    right = np.sort(np.repeat(alone["multiplier_real"], 2))
    np.testing.assert_allclose(np.sort(orbit["multiplier_real"]), right, rtol=1e-8)
