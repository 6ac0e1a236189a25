"""Words for motions that jump: billiards and clocks whose angles turn evenly, by closed form."""

import numpy as np
import pytest

import chaosdrill as cd
from chaosdrill.analysis.judgement.ordering import ordered

GOLDEN = (np.sqrt(5) - 1) / 2
FLIGHT = {"x": "u", "y": "v", "u": "0", "v": "0"}


def wall(name, guard, *normal):
    """An elastic wall with this normal, of any length."""
    a, b = normal
    pushed = f"2*(u*({a}) + v*({b}))/(({a})**2 + ({b})**2)"
    reset = {"u": f"u - {pushed}*({a})", "v": f"v - {pushed}*({b})"}
    return cd.Transition(name, "in", "in", guard, 1, reset)


def table(name, walls, **parameters):
    return cd.HybridSystem(name=name, states="x y u v", parameters=parameters, modes={"in": FLIGHT}, transitions=walls)


@pytest.fixture(scope="module")
def tables():
    """An ellipse of half axes a and 1, a square, and an equilateral triangle."""
    thirds = np.pi / 2 + 2 * np.pi / 3 * np.arange(3)
    sides = [(float(np.cos(t)), float(np.sin(t))) for t in thirds]
    return {
        "ellipse": table("ellipse", [wall("side", "(x/a)**2 + y**2 - 1", "x/a**2", "y")], a=2.0),
        "square": table(
            "square",
            [wall(f"{s}", f"{s} - 1", *n) for s, n in (("x", (1, 0)), ("-x", (-1, 0)))]
            + [wall(f"{s}", f"{s} - 1", *n) for s, n in (("y", (0, 1)), ("-y", (0, -1)))],
        ),
        "triangle": table(
            "triangle", [wall(f"side{k}", f"x*{a!r} + y*{b!r} - 1", a, b) for k, (a, b) in enumerate(sides)]
        ),
    }


def shot(system, x, y, u, v, **parameters):
    """The same with a shot of speed 1."""
    speed = np.hypot(u, v)
    return system.with_parameters(**parameters).with_initial(x=x, y=y, u=float(u / speed), v=float(v / speed))


def both(system, duration):
    """Words of a spectrum, and of basins, whose records are short."""
    start = {name: [system.initial[name]] for name in ("x", "y")}
    spectrum = cd.lyapunov_spectrum(system, duration=duration)
    basins = cd.basins(system, start, duration=duration / 8, transient=0)
    return {spectrum.cd.outcome, *(cd.Outcome(int(code)).meaning for code in np.ravel(basins["outcome"]))}


@pytest.mark.parametrize("a", [1.0, 1.1, 1.7, 3.0])
@pytest.mark.parametrize("between", [True, False])
def test_shots_in_an_ellipse_are_on_tori(tables, a, between):
    """Between the foci they keep off a hyperbola, beside them off an ellipse (Birkhoff 1927)."""
    focus = np.sqrt(a**2 - 1)
    x, angle = (0.6 * focus, 1.1) if between else (0.4 * focus + 0.6 * a, 1.3)
    if a == 1.0 and between:
        x, angle = 0.3, 1.9
    found = shot(tables["ellipse"], x, 0.0, np.cos(angle), np.sin(angle), a=a)
    assert both(found, 1200 * a) == {"quasiperiodic"}


@pytest.mark.parametrize(("turns", "sides"), [(1, 3), (2, 5), (3, 8), (4, 9)])
def test_stars_in_a_circle_are_cycles(tables, turns, sides):
    """A chord at the distance cos(pi turns / sides) closes after so many sides."""
    found = shot(tables["ellipse"], float(np.cos(np.pi * turns / sides)), 0.0, 0.0, 1.0, a=1.0)
    assert both(found, 1200) == {"periodic"}


@pytest.mark.parametrize("duration", [300, 1200])
def test_a_shot_along_an_axis_is_a_cycle(tables, duration):
    """Unstable along the major axis, where symmetry holds it; the diameters of a circle differ by round-off."""
    for a, angle in ((2.0, 0.0), (2.0, np.pi / 2), (1.0, 0.7)):
        found = shot(tables["ellipse"], 0.0, 0.0, np.cos(angle), np.sin(angle), a=a)
        assert both(found, duration) == {"periodic"}


@pytest.mark.parametrize(
    ("slope", "word"),
    [(0.5, "periodic"), (5 / 3, "periodic"), (np.sqrt(2), "quasiperiodic"), (1 + GOLDEN, "quasiperiodic")],
)
def test_shots_in_a_square_are_as_rational_as_their_slopes(tables, slope, word):
    assert both(shot(tables["square"], 0.1, 0.23, 1.0, slope), 1500) == {word}


@pytest.mark.parametrize(("along", "across"), [(1, 0), (1, 1), (3, 1), (2, 5)])
def test_rational_shots_in_a_triangle_are_cycles(tables, along, across):
    """Directions of the lattice of triangles into which it unfolds."""
    found = shot(tables["triangle"], 0.1, 0.23, along + across / 2, across * np.sqrt(3) / 2)
    assert both(found, 1200) == {"periodic"}


@pytest.fixture(scope="module")
def clocks():
    """A clock of period r beside a forcing of period 1 that drives a state, and beside a clock of period 1."""
    again = cd.Transition("again", "on", "on", "c - r", 1, {"c": "0"})
    other = cd.Transition("other", "on", "on", "d - 1", 1, {"d": "0"})
    given = {"parameters": {"r": 1.5}, "transitions": [again, other]}
    driven = {"x": "cos(2*pi*t) - x + c", "c": "1", "d": "1"}
    return (
        cd.HybridSystem(name="driven", states="x c d", time="t", modes={"on": driven}, period=1.0, **given),
        cd.HybridSystem(name="pair", states="c d", modes={"on": {"c": "1", "d": "1"}}, **given),
    )


@pytest.mark.parametrize(
    ("ratio", "word"),
    [
        (1.5, "periodic"),
        (0.625, "periodic"),
        (np.sqrt(2), "quasiperiodic"),
        (GOLDEN, "quasiperiodic"),
        (np.pi / 2, "quasiperiodic"),
        (0.2 * np.sqrt(3), "quasiperiodic"),
    ],
)
def test_clocks_have_a_common_period_or_a_torus(clocks, ratio, word):
    driven, pair = (system.with_parameters(r=float(ratio)).with_initial(c=0.1, d=0.3) for system in clocks)
    assert cd.lyapunov_spectrum(driven, periods=1200, transient=40).cd.outcome == word
    assert cd.lyapunov_spectrum(pair, duration=1200).cd.outcome == word


def test_a_wall_that_is_never_met_says_nothing(tables):
    """A shot along the square has no event in so short a run; its surface is no event that moves a state."""
    free = shot(tables["square"], -0.5, 0.0, 1.0, 0.0)
    for lengths in ({"duration": 0.4}, {"periods": 1, "at": "x > -0.4"}):
        assert cd.lyapunov_spectrum(free, **lengths).sizes["exponent"] == 4


K = np.arange(1024)


def turned(turn, harmonics, fall):
    """A function of an angle that turns evenly, with so many harmonics that fall like a power."""
    rng = np.random.default_rng(harmonics)
    k = np.arange(1, harmonics + 1)
    weight, phase = rng.normal(size=harmonics) / k**fall, rng.uniform(0, 2 * np.pi, harmonics)
    return (weight * np.cos(2 * np.pi * turn * np.outer(K, k) + phase)).sum(axis=1)


@pytest.mark.parametrize("turn", [GOLDEN, np.sqrt(2) - 1, 1 / 3 + 0.01 * GOLDEN, 0.07 * np.pi])
@pytest.mark.parametrize(("harmonics", "fall"), [(1, 1.0), (30, 2.0), (200, 2.0)])
def test_tori_of_many_harmonics_are_in_order(turn, harmonics, fall):
    """Averages of a sum of so many converge slowly, its order shows at once; so do those of a jump."""
    path = turned(turn, harmonics, fall)
    jumps = (K * turn + 0.3) % 1.0
    for values in (path, jumps, jumps + 0.2 * path / np.ptp(path)):
        assert ordered(np.column_stack([values, np.roll(values, 1)])[1:])[0]


def logistic(r, count):
    x = np.empty(count)
    x[0] = 0.3
    for k in range(count - 1):
        x[k + 1] = r * x[k] * (1 - x[k])
    return x[-1024:]


def strange():
    """The strange nonchaotic attractor of Grebogi, Ott, Pelikan and Yorke."""
    x = np.empty(1500)
    x[0] = 0.5
    for k in range(1499):
        x[k + 1] = 3.0 * np.tanh(x[k]) * np.cos(2 * np.pi * GOLDEN * k)
    return x[-1024:]


@pytest.mark.parametrize(
    "path",
    [
        logistic(3.9, 2000),
        logistic(3.5699456718709, 40_000),
        strange(),
        np.exp(2e-5 * K) * np.cos(2 * np.pi * GOLDEN * K),
        np.exp(-2e-5 * K) * np.cos(2 * np.pi * GOLDEN * K),
        np.cos(2 * np.pi * K * 123 / 300),
        np.random.default_rng(2).normal(size=300)[K % 300],
        K / 1024 + 1e-3 * np.cos(K),
        np.cumsum(np.random.default_rng(1).normal(size=1024)),
        np.cos(2 * np.pi * GOLDEN * K) + 0.02 * np.random.default_rng(5).normal(size=1024),
    ],
    ids=["chaos", "adding machine", "strange", "grows", "fades", "locked", "cycle", "drift", "walk", "noise"],
)
def test_what_is_no_torus_is_in_no_order(path):
    for beside in (np.roll(path, 1), np.cos(2 * np.pi * GOLDEN * K), 1e-9 * path):
        assert not ordered(np.column_stack([path, beside])[1:])[0]


@pytest.mark.parametrize("turns", [0.01, 0.02, 0.05])
@pytest.mark.parametrize(
    "drift",
    [lambda s: np.sqrt(s + 0.05), lambda s: s**3, np.square, lambda s: np.sin(2 * s), lambda s: np.expm1(2 * s) / 4],
    ids=["ever slower", "cubic", "even", "turns back", "ever faster"],
)
def test_an_angle_whose_rate_drifts_by_a_hundredth_of_a_turn_is_in_no_order(drift, turns):
    """Its points still run along a circle, at an angle that is off by as little."""
    for rate in (0.377, 0.468, GOLDEN, 0.145):
        angle = 2 * np.pi * (rate * K + turns * drift(K / 1024) + 0.3)
        points = np.stack([np.cos(angle) + 0.2 * np.cos(2 * angle + 0.4), np.sin(angle + 0.3)], axis=1)
        assert not ordered(points)[0]
