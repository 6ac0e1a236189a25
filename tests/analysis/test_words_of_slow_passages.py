"""What seems to rest, or to repeat, and moves again: heteroclinic cycles, departures and falls of known ends."""

import numpy as np
import pytest

import chaosdrill as cd
from chaosdrill.analysis.judgement.resting import lengthens

RING = (("x", "y", "z"), ("y", "z", "x"), ("z", "x", "y"))
START = {"x": 0.6, "y": 0.3, "z": 0.2}
OPEN = {"transient", "undecided"}


def words(found):
    return {cd.Outcome(code).meaning for code in np.atleast_1d(found["outcome"].values).ravel()}


def ring(power):
    """Three competitors, of May and Leonard (1) or Guckenheimer and Holmes (2); states are in units of u."""
    field = {
        one: f"{one}*(1 - ({one}/u)**{power} - a*({other}/u)**{power} - b*({third}/u)**{power})"
        for one, other, third in RING
    }
    parameters = {"a": 0.8, "b": 1.3, "u": 1.0}
    return cd.HybridSystem(name="ring", states="x y z", parameters=parameters, modes={"on": field}, initial=START)


@pytest.fixture(scope="module", params=[1, 2])
def competitors(request):
    return ring(request.param)


def cases(rng, count):
    """Competition at which the cycle attracts, a + b > 2, units, and lengths of up to hundreds of stays."""
    for _ in range(count):
        a = rng.uniform(0.3, 0.95)
        yield (
            {"a": a, "b": 2 - a + 10 ** rng.uniform(-1.5, 0.3), "u": 10 ** rng.uniform(-9, 9)},
            10 ** rng.uniform(2, 3.3),
        )


def test_stays_grow_by_the_ratio_of_what_attracts_to_what_repels(competitors):
    """Turns of three stays are longer by the cube of (b - 1)/(1 - a), and by a constant (May and Leonard 1975)."""
    a, b = 0.6, 1.5
    found = cd.trajectory(competitors.with_parameters(a=a, b=b, u=1.0), duration=1000, samples=100_000)
    time, x = found["time"].values.ravel(), found["states"].sel(state="x").values.ravel()
    turns = np.diff(time[1:][(x[1:] > 0.5) & (x[:-1] <= 0.5)])
    longer = np.diff(turns)
    assert longer[-1] / longer[-2] == pytest.approx(((b - 1) / (1 - a)) ** 3, rel=1e-3)


def test_a_heteroclinic_cycle_is_no_attractor_of_another_kind(competitors):
    for given, duration in cases(np.random.default_rng(32), 8):
        start = {name: given["u"] * value for name, value in START.items()}
        system = competitors.with_parameters(**given).with_initial(**start)
        found = words(cd.lyapunov_spectrum(system, duration=duration))
        assert found <= OPEN, (given, duration)


def test_an_attracting_homoclinic_loop_is_no_cycle():
    """Of Hamilton's function H = y^2/2 - x^2/2 + x^4/4, which vanishes there; near it rounding decides on the stays."""
    flow = {"x": "y", "y": "x - x**3 - k*m*y*(y**2/2 - x**2/2 + x**4/4)"}
    loop = cd.HybridSystem(
        name="loop", states="x y", parameters={"k": 3.158694110965408, "m": 1.0}, modes={"on": flow},
        initial={"x": 0.3651824882998384, "y": 0.0},
    )  # fmt: skip
    assert words(cd.lyapunov_spectrum(loop, duration=403.59575215607373)) <= OPEN
    at = {"k": [0.05], "m": [0.9]}
    chart = cd.parameter_chart(loop.with_initial(x=0.5), at, duration=400, transient=100, max_extension=0)
    assert words(chart) <= OPEN


def test_turns_of_a_cycle_come_back():
    """Of one length, of lengths in turn, and those of chance near a loop, one and all together."""
    rng = np.random.default_rng(5)
    lengths = np.stack([np.full(40, 37.0), np.tile([30.0, 44.0], 20), 37 * (1 + rng.uniform(-0.2, 0.2, 40))])
    begins = np.concatenate([np.zeros((3, 1)), np.cumsum(lengths, axis=1)], axis=1)
    paths = np.stack([np.sin(2 * np.pi * np.interp(np.arange(1200), one, np.arange(41))) for one in begins])[..., None]
    found = lengthens(paths)
    assert found.tolist() == [False, False, True]
    assert [bool(lengthens(path[None])[0]) for path in paths] == found.tolist()


def test_spikes_between_two_samples_are_no_longer_turns():
    """A relaxation oscillation of 37.3 samples a turn, whose speed has them, and a motion of 3.1 samples a turn."""
    k = np.arange(2048)
    phase = k / 37.3 % 1
    slow = np.where(phase < 0.5, 1 - phase, phase - 1.5)
    fast = np.exp(-np.minimum(phase, 1 - phase) / 0.01)
    quick = np.cos(2 * np.pi * k / 3.1) ** 5
    paths = np.stack([np.stack([slow, fast], axis=-1), np.stack([quick, np.roll(quick, 1)], axis=-1)])
    assert not lengthens(paths).any()


DELAYED = cd.Map("x y", {"a": 2.01, "u": 0.0}, {"x": "a*x*(1 - y)", "y": "x"}, name="delayed-logistic")
"""Beyond a = 2 its fixed point is left at the rate log(a - 1)/2 for a torus (Maynard Smith 1968)."""


@pytest.mark.parametrize(
    ("beside", "transient", "periods"), [(1e-8, 0, 256), (1e-8, 100, 256), (1e-12, 300, 1024), (1e-12, 100, 256)]
)
def test_what_leaves_a_fixed_point_slowly_is_not_chaotic(beside, transient, periods):
    rest = 1 - 1 / 2.01
    one, length = DELAYED.with_initial(x=rest + beside, y=rest), {"transient": transient, "periods": periods}
    assert words(cd.bifurcation_diagram(one, {"u": [0.0]}, **length)) <= {"transient", "quasiperiodic"}
    assert words(cd.bifurcation_diagram(one, {"u": [0.0]}, max_extension=0, **length)) == {"transient"}
    assert words(cd.lyapunov_spectrum(one, **length)) == {"transient"}


REPELLING = cd.Map("x", {"s": 1.0, "m": 0.03}, {"x": "1 + s*((1 + m)*(x - 1) - (x - 1)**3)"}, name="repelling")


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("beside", [0.0, 1e-13, 1e-11, 1e-9])
def test_a_fixed_point_is_periodic_if_met_exactly_and_left_if_not(sign, beside):
    word, grid = "transient" if beside else "periodic", {"m": [0.01, 0.03, 0.1]}
    given = {"transient": 0, "periods": 64, "max_extension": 0}
    one = REPELLING.with_parameters(s=sign).with_initial(x=1 + beside)
    found = cd.bifurcation_diagram(one, grid, **given)["outcome"].values.ravel()
    # within the record, distances grow by less than half for the first
    told = [cd.Outcome(code).meaning for code in found[1 if beside else 0 :]]
    assert set(told) == {word}
    longer = cd.bifurcation_diagram(one, {"m": [0.03]}, transient=0, periods=64)
    assert words(longer) <= {"transient", "undecided", "periodic"}


def test_one_small_growth_is_not_that_of_chaos_and_of_the_flow():
    """Three competitors leave where they coexist, in three turns; a slow focus comes closer to rest."""
    slow = ring(1).with_parameters(b=1.5).with_initial(x=0.401, y=0.4, z=0.4)
    assert words(cd.lyapunov_spectrum(slow, duration=100)) == {"transient"}
    well = cd.HybridSystem(
        name="well", states="x v", parameters={"k": 0.02}, modes={"on": {"x": "v", "v": "x - x**3 - k*v"}},
        initial={"x": 1e-3, "v": 0.0},
    )  # fmt: skip
    assert words(cd.basins(well, {"x": [1e-3], "v": [0.0]}, duration=100, transient=0)) <= {"transient", "equilibrium"}


@pytest.mark.parametrize(("drag", "word"), [(0.0, "open"), (0.01, "periodic")])
def test_a_fall_goes_on_or_comes_to_one_speed(drag, word):
    fall = cd.HybridSystem(
        name="fall", states="x v", parameters={"k": 0.0}, modes={"on": {"x": "v", "v": "-9.81 - k*v"}}
    )
    found = cd.basins(
        fall.with_parameters(k=drag), {"x": [0.0], "v": [0.0]}, duration=4000, transient=1000 * (drag > 0)
    )
    assert words(found) == {word}


LOGISTIC = cd.Map("x y", {"r": 3.8, "u": 1.0}, {"x": "r*x*(1 - x/u)", "y": "0"}, name="logistic")
FOLD, PLACE = 1 + np.sqrt(8), 0.51435527706199
"""Where a cycle of period three is born, and one of its points, by Newton's method on slope and place."""


@pytest.mark.parametrize("below", [1e-10, 1e-11, 1e-12, 1e-13])
@pytest.mark.parametrize("max_extension", [0, 8])
def test_what_a_cycle_leaves_behind_is_no_cycle(below, max_extension):
    """In the channel steps of down to 2e-13 go one way; where they are smallest tangents shrink before and grow behind.

    It is passed in pi/sqrt(a c) turns, 4,000 at the first of these distances, of three iterates each.
    """
    one = LOGISTIC.with_parameters(r=FOLD - below)
    beside = np.array([-1e-4, -1e-5, -3e-6, -1e-6, -3e-7, 3e-7, 1e-6, 3e-6, 1e-5])
    grid = {"x": PLACE + beside, "y": [0.0]}
    assert "periodic" not in words(cd.basins(one, grid, transient=0, periods=256, max_extension=max_extension))
    for x in grid["x"][max_extension == 0 :: 2]:
        assert "periodic" not in words(cd.lyapunov_spectrum(one.with_initial(x=x), periods=256))


def test_the_cycle_before_it_is_left_behind_is_one():
    beyond = {"r": FOLD + np.array([3e-10, 1e-9, 1e-8, 1e-6])}
    found = cd.bifurcation_diagram(LOGISTIC.with_initial(x=0.3), beyond, transient=500, periods=256)
    assert words(found) == {"periodic"}
    assert set(found["period"].values.ravel()) == {3}


def test_what_turns_as_it_comes_closer_leaves_no_channel():
    """A forced oscillator whose damping is as small, whose strobes go round its cycle."""
    rates = {"x": "v", "v": "-2*x - c*v + cos(t)"}
    one = cd.HybridSystem(
        states="x v", time="t", parameters={"c": 1e-4}, period=2 * np.pi, modes={"on": rates}, initial={"x": 1.0}
    )
    assert words(cd.bifurcation_diagram(one, {"c": [1e-4, 2e-4]}, transient=200, periods=64)) == {"periodic"}


STILL = {
    "epidemic": ({"x": "-k*x*y", "y": "k*x*y - y"}, {"x": 0.99, "y": 0.01}, "equilibrium"),
    "drag": ({"x": "y", "y": "-k*y"}, {"x": 1.0, "y": 1.0}, "equilibrium"),
    "threshold": ({"x": "x**2*(1 - x)", "y": "-k*y"}, {"x": 1e-9, "y": 1.0}, "undecided"),
}


@pytest.mark.parametrize("name", STILL)
@pytest.mark.parametrize("duration", [60.0, 400.0])
def test_what_ends_on_a_line_of_rests_is_on_no_cycle(name, duration):
    """One exponent is zero along the line; beside a neutral rest a motion is as slow, but goes on."""
    field, start, word = STILL[name]
    system = cd.HybridSystem(
        name=name, states="x y", parameters={"k": 2.0, "q": 0.0}, modes={"on": field}, initial=start
    )
    lengths = {"duration": duration, "transient": 0}
    chart = cd.parameter_chart(system, {"k": [2.0], "q": [0.0]}, exponents=2, max_extension=0, **lengths)
    assert words(cd.lyapunov_spectrum(system, **lengths)) == words(chart) == {word}


def test_a_cycle_that_is_seen_after_whole_periods_moves():
    """Its instants stand still; its rates do not."""
    field = {"x": "a*x*(1 - x**2 - y**2) - b*y", "y": "a*y*(1 - x**2 - y**2) + b*x"}
    hopf = cd.HybridSystem(
        name="hopf", states="x y", parameters={"a": 1.0, "b": 1.0}, modes={"on": field}, initial={"x": 0.3, "y": 0.4}
    )
    for turns in (512, 512.5, 1024):
        chart = cd.parameter_chart(hopf, {"a": [1.0], "b": [1.0]}, duration=turns * 2 * np.pi, transient=50)
        assert words(chart) == {"periodic"}, turns


def test_chaos_whose_stays_have_no_mean_length_has_no_word():
    """Boole's map leaves length as it is, which is infinite: its exponent is zero, that of any record positive."""
    boole = cd.Map("x", {}, {"x": "x - 1/x"}, name="boole")
    found = [cd.lyapunov_spectrum(boole.with_initial(x=k / 41), periods=1024) for k in (3, 5, 11, 14, 15)]
    assert set.union(*map(words, found)) <= OPEN
