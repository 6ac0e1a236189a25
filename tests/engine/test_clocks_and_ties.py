"""Events at strobes, at starts and together, whose number is known, by whatever blocks a run is cut into."""

import importlib
import math

import numpy as np
import pytest
import sympy

import chaosdrill as cd
from chaosdrill.engine.layout import EVENT_COLUMNS, EVENT_KIND
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run

clocks = importlib.import_module("case_14_clocks_ties_and_scales")

X, V, Y, U, N, M, T = sympy.symbols("x v y u n m t", real=True)
METHODS = ("taylor", "dop853", "radau")
both_methods = pytest.mark.parametrize("method", METHODS)


def counts(spectrum):
    names = spectrum["transition"].values
    return dict(zip(names, spectrum["event_count"].values.tolist(), strict=True))


def outcome(run):
    return cd.Outcome(int(run["outcome"])).meaning


def times(run):
    names = run["event_kind"].attrs["flag_meanings"].split()
    return {name: run["event_time"].values[run.cd.words("event_kind") == name] for name in names}


@pytest.fixture(scope="module")
def standard_map_exponent():
    """The map's own exponent at K = 10, from 200 orbits of 2000 iterates, and its error after 1000."""
    strength = 10.0
    rng = np.random.default_rng(3)
    x, v = rng.random((2, 200))
    dx, dv, grown = np.ones(200), np.zeros(200), np.zeros(200)
    for i in range(2100):
        dv = dv + strength * np.cos(2 * np.pi * x) * dx
        dx = dx + dv
        v = v + strength / (2 * np.pi) * np.sin(2 * np.pi * x)
        x = (x + v) % 1
        size = np.hypot(dx, dv)
        dx, dv = dx / size, dv / size
        grown += np.log(size) * (i >= 100)
    assert grown.std() / 2000 / math.sqrt(200) < 2e-3
    return grown.mean() / 2000, grown.std() / math.sqrt(2000) / math.sqrt(1000)


@both_methods
@pytest.mark.parametrize("blocks", [64, 1000])
def test_a_kicked_rotor_is_the_standard_map(method, blocks, standard_map_exponent):
    right, error = standard_map_exponent
    assert right == pytest.approx(1.621, abs=0.005)
    rotor, stated, off = clocks.rotor(), [], []
    # a chaotic record, and with it its error, is another one on another processor: what holds, holds of many
    for x, v in np.random.default_rng(7).random((16, 2)).tolist():
        run = cd.lyapunov_spectrum(rotor.with_initial(x=x, v=v), periods=1000, blocks=blocks, method=method)
        assert counts(run) == {"kick": 1000}
        exponents, errors = run["lyapunov_exponent"].values, run["lyapunov_error"].values
        # the map keeps areas
        assert exponents.sum() == pytest.approx(0, abs=1e-10)
        stated.append(errors[0])
        off.append(abs(exponents[0] - right) / errors[0])
    assert error / 2 < np.median(stated) < 2 * error
    assert np.mean(np.array(off) < 2) >= 0.7


@both_methods
@pytest.mark.parametrize(("phase", "sign"), [(0.0, 1), (0.0, -1), (1.0, 1), (1.0, -1), (math.pi, 1)])
def test_a_clock_ticks_once_a_period(method, phase, sign):
    system = clocks.clock().with_parameters(p=phase, k=float(sign))
    run = cd.lyapunov_spectrum(system, periods=1000, blocks=1000, exponents=1, method=method)
    assert counts(run) == {"tick": 1000}
    run = cd.trajectory(system, periods=1000, samples=1, method=method)
    first = (phase / (2 * math.pi) + (0.0 if sign > 0 else 0.5)) % 1
    np.testing.assert_allclose(run["event_time"].values, first + np.arange(1000), rtol=3e-16, atol=1e-15)
    assert (run["event_speed"].values > 0).all()


@both_methods
@pytest.mark.parametrize("blocks", [1, 256, 1000])
def test_turning_points_at_the_strobe_are_met_once_a_period(method, blocks):
    """x = cos(2 t) solves it: v = 0 downwards at every strobe."""
    system = cd.HybridSystem(
        name="turning-points",
        states=(X, V),
        time=T,
        parameters={},
        modes={"free": {X: V, V: -X - V / 10 - 3 * sympy.cos(2 * T) - sympy.sin(2 * T) / 5}},
        transitions=[cd.Transition("turn", "free", "free", guard=V, direction=-1)],
        period=sympy.pi,
        initial={X: 1.0},
    )
    run = cd.lyapunov_spectrum(system, periods=1000, blocks=blocks, exponents=1, method=method)
    assert counts(run) == {"turn": 1000}


@both_methods
@pytest.mark.parametrize("phase", [0.0, 0.3, 1.0, 1.3, 2.0, 3.0, math.pi, 4.5, 5.0, 6.0])
def test_two_clocks_that_tie_every_period_tick_in_step(method, phase):
    """a = 2 pi t - p: sin a rises at 0; sin 2a + sin a = sin a (2 cos a + 1) rises at 0, with slope 3, and at pi,
    with slope 1."""
    periods = 50
    run = cd.trajectory(clocks.twins().with_parameters(p=phase), periods=periods, samples=1, method=method)
    assert outcome(run) == "ok"
    first = phase / (2 * math.pi) % 1
    once = first + np.arange(periods)
    twice = np.sort(np.concatenate([once, (first + 0.5) % 1 + np.arange(periods)]))
    np.testing.assert_allclose(times(run)["one"], once, rtol=0, atol=2e-14)
    np.testing.assert_allclose(times(run)["two"], twice, rtol=0, atol=2e-14)
    end = dict(zip(run["state"].values, run["states"].values[-1], strict=True))
    assert (end["n"], end["m"]) == (periods, 2 * periods)


def kicked_oscillator(level, push, length):
    """Times at which x'' = -x - 0.2 x' from (-1, 0) rises through a level, where v grows by ``push``; the end state."""
    w = math.sqrt(0.99)

    def arc(t, x, v):
        decay, b = np.exp(-0.1 * t), (v + 0.1 * x) / w
        place = decay * (x * np.cos(w * t) + b * np.sin(w * t))
        return place, decay * (v * np.cos(w * t) - (x + 0.1 * v) / w * np.sin(w * t))

    x, v, now, found = -1.0, 0.0, 0.0, []
    while True:
        grid = np.linspace(1e-3, 7.0, 7000)
        values = arc(grid, x, v)[0] - level
        rising = np.flatnonzero((values[:-1] < 0) & (values[1:] >= 0))
        t = grid[rising[0]] if len(rising) else np.inf
        for _ in range(5):
            if np.isfinite(t):
                place, speed = arc(t, x, v)
                t -= (place - level) / speed
        if now + t >= length:
            return np.array(found), arc(length - now, x, v)
        x, v = arc(t, x, v)
        x, v, now = level, v + push, now + t
        found.append(now)


@both_methods
@pytest.mark.parametrize(("level", "count"), [(0.0, 159), (0.2, 156)])
def test_two_oscillators_in_step_are_kicked_in_step(method, level, count):
    """Both guards are reached together for ever; which of the two acts first changes nothing."""
    c, q, d = sympy.symbols("c q d", real=True)
    system = cd.HybridSystem(
        name="two clocks in step",
        states=(X, V, Y, U),
        parameters={"c": 0.7, "q": 0.3, "d": level},
        modes={"run": {X: V, V: -X - V / 5, Y: U, U: -Y - U / 5}},
        transitions=[
            cd.Transition("first", "run", "run", guard=c * X + q * Y - d, direction=+1, reset={V: V + 1}),
            cd.Transition("second", "run", "run", guard=q * X + c * Y - d, direction=+1, reset={U: U + 1}),
        ],
        initial={X: -1.0, Y: -1.0},
    )
    right, end = kicked_oscillator(level, 1.0, 1000.0)
    run = cd.trajectory(system, duration=1000.0, samples=2, method=method)
    assert outcome(run) == "ok"
    assert len(right) == count
    for name in ("first", "second"):
        np.testing.assert_allclose(times(run)[name], right, rtol=0, atol=1e-9)
    np.testing.assert_allclose(run["states"].values[-1], [*end, *end], rtol=0, atol=1e-9)


@both_methods
def test_a_tie_within_the_error_of_a_coarse_run_is_a_tie(method):
    """A circle passes x = 0 when a clock ticks: what is declared first acts first, at any tolerance."""
    tick = cd.Transition("tick", "run", "run", guard=N - sympy.pi / 2, direction=+1, reset={M: 2 * M, N: N - 10})
    passage = cd.Transition("passage", "run", "run", guard=X, direction=-1, reset={M: M + 1})
    for events in ([tick, passage], [passage, tick]):
        system = cd.HybridSystem(
            states=(X, V, N, M), modes={"run": {X: -V, V: X, N: 1, M: 0}}, transitions=events, initial={M: 1.0}
        )
        for phase in (0.0, 0.3, 0.7, 1.1):
            started = system.with_initial(x=math.cos(phase), v=-math.sin(phase), n=-phase)
            run = cd.trajectory(started, duration=phase + 2.0, samples=1, method=method, tolerance=1e-4)
            assert [e.name for e in events] == run.cd.words("event_kind").values.tolist(), phase


@pytest.mark.parametrize(
    ("method", "samples", "length", "count"),
    [
        ("taylor", 1, 1e5, 31831),
        ("taylor", 1000, 1e4, 3183),
        ("dop853", 1, 1e4, 3183),
        ("dop853", 1000, 1e4, 3183),
    ],
)
def test_a_guard_of_time_without_a_period_is_located_as_exactly_as_time(method, samples, length, count):
    """sin(t - 1/3) either way."""
    right = 1 / 3 + np.pi * np.arange(count)
    assert right[-1] < length < right[-1] + np.pi
    run = cd.trajectory(clocks.free_clock(), duration=length, samples=samples, method=method)
    assert run.sizes["event"] == count
    # the last digit of time itself
    np.testing.assert_allclose(run["event_time"].values, right, rtol=0, atol=2 * np.spacing(length))


def test_a_guard_of_time_keeps_its_place_after_a_million_units():
    run = cd.trajectory(clocks.free_clock(), transient=1e6, duration=100.0, samples=1)
    first = math.ceil((1e6 - 1 / 3) / math.pi)
    right = 1 / 3 + np.pi * (first + np.arange(run.sizes["event"]))
    assert run.sizes["event"] in (31, 32)
    assert right[-1] < 1e6 + 100 < right[-1] + np.pi
    np.testing.assert_allclose(run["event_time"].values, right, rtol=0, atol=3 * np.spacing(1e6))


def test_a_guard_of_time_keeps_its_place_after_a_million_periods():
    run = cd.trajectory(clocks.clock().with_parameters(p=1.0), transient=1_000_000, periods=20, samples=1)
    right = 1e6 + 1 / (2 * math.pi) + np.arange(20)
    np.testing.assert_allclose(run["event_time"].values, right, rtol=0, atol=np.spacing(1e6))


def upward(x, v):
    """First time after 0 at which x'' = -x - x'/5 from (x, v) rises through 0."""
    w = math.sqrt(0.99)
    # x(t) = e^(-t/10) (x cos wt + b sin wt), b = (v + x/10)/w
    angle = math.atan2(-x, (v + 0.1 * x) / w) % (2 * math.pi)
    return angle / w


@both_methods
@pytest.mark.parametrize(
    ("x", "v", "first"),
    [
        (0.5, 0.0, upward(0.5, 0.0)),
        (0.5, 0.7, upward(0.5, 0.7)),
        (-0.5, 0.0, upward(-0.5, 0.0)),
        # on the guard and moving across it: at once; moving away: when it comes back
        (0.0, 0.5, 0.0),
        (0.0, -0.5, math.pi / math.sqrt(0.99)),
    ],
)
def test_a_clock_starts_on_either_side_of_its_guard(method, x, v, first):
    """x'' = -x - x'/5 is kicked where it rises through 0, every 2 pi / sqrt(0.99), and goes on beyond."""
    period = 2 * math.pi / math.sqrt(0.99)
    run = cd.trajectory(clocks.escapement().with_initial(x=x, v=v), duration=100.0, samples=50, method=method)
    assert outcome(run) == "ok"
    right = first + period * np.arange(math.floor((100.0 - first) / period) + 1)
    np.testing.assert_allclose(run["event_time"].values, right, rtol=0, atol=1e-10)


def test_a_clock_starts_on_either_side_of_its_guard_in_a_sweep():
    """The same beside a clock that tells the time, over twenty kicks."""
    starts = [(0.5, 0.0), (0.5, 0.7), (-0.5, 0.0), (0.9, -0.3), (-1.0, 2.0)]
    chart = cd.bifurcation_diagram(
        clocks.escapement(forced=True),
        {"push": [0.5, 1.0, 2.0]},
        transient=0,
        periods=20,
        seeds=[{"x": x, "v": v} for x, v in starts],
        exponents=0,
        max_extension=0,
        max_period=1,
        at="kick",
    )
    period = 2 * math.pi / math.sqrt(0.99)
    for i, (x, v) in enumerate(starts):
        first = upward(x, v)
        for j in range(3):
            found = chart["section"].values[j, i, :, 2]
            np.testing.assert_allclose(found, first + period * np.arange(20), rtol=0, atol=1e-10)


@both_methods
@pytest.mark.parametrize("reset", ["switch", "wall"])
def test_a_start_beyond_a_switch_or_a_wall_is_refused(method, reset):
    target = {"switch": "other", "wall": "run"}[reset]
    system = cd.HybridSystem(
        name=reset,
        states=(X, V),
        parameters={},
        modes={"run": {X: V, V: -X}, "other": {X: V, V: -X}},
        transitions=[
            cd.Transition("event", "run", target, guard=X, direction=+1, reset={V: -V / 2} if reset == "wall" else {})
        ],
        initial={X: 0.5},
    )
    with pytest.warns(cd.StartWarning, match="the guard x of 'event' is 0.5"):
        assert outcome(cd.trajectory(system, duration=1.0, method=method)) == "invalid_start"
    assert outcome(cd.trajectory(system.with_initial(x=-0.5), duration=1.0, method=method)) == "ok"


@both_methods
def test_a_reset_that_jumps_over_a_guard_fires_it_at_once(method):
    """x is thrown from 0 to 1 at t = 1/2, over a mark, a kick that counts and one that looks the other way."""
    system = cd.HybridSystem(
        name="jump",
        states=(X, N, M),
        time=T,
        parameters={},
        modes={"run": {X: 0, N: 0, M: 0}},
        transitions=[
            cd.Transition("jump", "run", "run", guard=T - sympy.Rational(1, 2), direction=+1, reset={X: X + 1}),
            cd.Transition("mark", "run", "run", guard=X - sympy.Rational(1, 4), direction=+1),
            cd.Transition("kick", "run", "run", guard=X - sympy.Rational(3, 4), direction=+1, reset={N: N + 1}),
            cd.Transition("back", "run", "run", guard=X - sympy.Rational(3, 4), direction=-1, reset={M: M + 1}),
        ],
    )
    run = cd.trajectory(system, duration=1.0, samples=4, method=method)
    assert outcome(run) == "ok"
    assert {name: found.tolist() for name, found in times(run).items()} == {
        "jump": [0.5],
        "mark": [0.5],
        "kick": [0.5],
        "back": [],
    }
    # a sample that coincides with an event shows the state before it
    np.testing.assert_array_equal(run["states"].values, [[0, 0, 0]] * 3 + [[1, 1, 0]] * 2)


@pytest.mark.parametrize("tangents", [0, 3])
@pytest.mark.parametrize("speed", [0.0, 4.591774807899561e-41, 5e-324])
def test_a_slip_begins_whatever_is_left_of_its_speed(speed, tangents):
    """The rock's speed and its rate are zero where the slip begins, to their errors; the second derivative is not."""
    system = cd.drill(eta=0.4259884424335187, b=0.7725024409931329, xi=0.06)
    system = system.with_initial(mode="stick", y=0.41059082944431274, u=0.09389970626766601, w=speed)
    run = Run(system, system.forcing_period(), Numerics(), tangents=np.eye(3)[:tangents], orthonormalise=False)
    run.begin_at(5.014884892738505)
    rows = np.zeros((64, EVENT_COLUMNS + 6))
    assert run.advance(1, events=rows)[0] == cd.Outcome.OK
    found = rows[: run.filled()[1], EVENT_KIND].astype(int)
    assert [system.transitions[k].name for k in found] == ["release", "hit", "stick"]
