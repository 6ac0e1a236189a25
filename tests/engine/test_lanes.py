"""Runs stepped in lanes, at systems whose answers are known in closed form, many different ones side by side."""

import numpy as np
import pytest
import sympy

import chaosdrill as cd
from chaosdrill.dataset import Outcome
from chaosdrill.engine.batch import Batch
from chaosdrill.engine.numerics import Numerics

X, V, S = sympy.symbols("x v s", real=True)
T = sympy.Symbol("t", real=True)
ONE = np.array([0, 1])


def batch(system, starts, modes=None, parameters=None, tolerance=1e-12, **more):
    starts = np.asarray(starts, dtype=float)
    modes = np.zeros(len(starts), dtype=int) if modes is None else np.asarray(modes)
    return Batch(system, parameters or {}, starts, modes, Numerics("taylor", tolerance), **more)


@pytest.fixture(scope="module")
def parabola():
    """x'' = -2: from (-1 + d, 2) it reaches d at t = 1."""
    return cd.HybridSystem(
        name="parabola",
        states=(X, V),
        parameters={},
        modes={"fly": {X: V, V: -2}},
        transitions=[cd.Transition("meet", "fly", "fly", guard=X, direction=0)],
        period=sympy.Float(1.9),
    )


def test_double_roots_are_met_twice_or_not_at_all(parabola):
    heights = np.concatenate([10.0 ** np.arange(-10, 0, 0.5), -(10.0 ** np.arange(-10, 0, 0.5))])
    b = batch(parabola, np.column_stack([heights - 1, np.full(len(heights), 2.0)]), window=4, section={0})
    b.run(0, ONE)
    assert b.counts[:, 0].tolist() == [2 * (h > 0) for h in heights]
    speeds = b.window[heights > 0, :2, 1]
    exact = 2 * np.sqrt(heights[heights > 0])
    # the height itself is a double beside -1
    np.testing.assert_allclose(speeds, np.column_stack([exact, -exact]), rtol=0, atol=3e-16 / exact.min())
    np.testing.assert_allclose(speeds[10:], np.column_stack([exact, -exact])[10:], rtol=1e-10)


HUMPS = {
    "round": (sympy.cos(S), np.arccos),
    "sharp": (1 / (1 + 9 * S**2), lambda level: np.sqrt(1 / level - 1) / 3),
    "lopsided": (sympy.exp(S) * (1 - S), None),
}


@pytest.mark.parametrize("name", HUMPS)
def test_a_summit_near_zero_is_above_or_below_it(name):
    """Humps that reach a level by 1e-12 to 1e-1, or stay so far below: where they do it is the closed form's root."""
    hump, place = HUMPS[name]
    level = sympy.Symbol("level", positive=True)
    system = cd.HybridSystem(
        name="hump",
        states=(S,),
        parameters={"level": 0.5},
        modes={"go": {S: 1}},
        transitions=[cd.Transition("above", "go", "go", guard=hump - level, direction=+1)],
        period=sympy.Integer(3),
    )
    over = np.repeat(10.0 ** np.arange(-12, 0), 12)
    over = np.concatenate([over, -over])
    starts = -0.6 + np.tile(np.linspace(-0.9, 0.5, 12), 24)
    reached = 1 - over
    below = np.array([float(hump.subs(S, start)) for start in starts]) < reached
    b = batch(system, starts[below, None], parameters={"level": reached[below]}, window=1, section={0})
    b.run(0, ONE)
    np.testing.assert_array_equal(b.counts[:, 0], over[below] > 0)
    met = b.counts[:, 0] == 1
    found = b.window[met, 0, 0]
    if place is None:
        off = np.exp(found) * (1 - found) - reached[below][met]
        np.testing.assert_allclose(off, 0, atol=1e-15)
        assert (found < 0).all()
    else:
        # a level is a double beside 1: by that much a root is off, times the slope of its place
        exact = -place(reached[below][met])
        np.testing.assert_allclose(found, exact, rtol=0, atol=4e-16 * np.max(1 / np.sqrt(over[below][met])))
        np.testing.assert_allclose(found[over[below][met] > 1e-5], exact[over[below][met] > 1e-5], rtol=0, atol=1e-12)


@pytest.fixture(scope="module")
def wall():
    w, r = sympy.symbols("w r", real=True)
    return cd.HybridSystem(
        name="wall-at-rest",
        states=(X, V),
        time=T,
        parameters={"w": 2.7, "r": 0.8},
        modes={"free": {X: V, V: sympy.cos(w * T) - X}},
        transitions=[cd.Transition("impact", "free", "free", guard=X, direction=+1, reset={V: -r * V}, kind="impact")],
        period=2 * sympy.pi / w,
    )


def test_exponents_of_the_impact_oscillator(wall):
    """Multipliers of the period-1 orbit of the impact oscillator: trace and determinant in closed form."""
    w = np.linspace(2.2, 2.64, 37)
    r = 0.8
    period = 2 * np.pi / w
    c = np.cos(period)
    trace = -2 * r * c + (1 + r) ** 2 * (1 - w**2) * (1 + c) / 2
    squared = trace**2 - 4 * r**2
    size = np.where(squared < 0, r, (np.abs(trace) + np.sqrt(np.maximum(squared, 0))) / 2)
    steady = (size < 0.97) & ((squared > 0.01) | (squared < -0.2))
    b = batch(wall, np.tile([-0.3, 0.0], (37, 1)), parameters={"w": w}, tangents=np.eye(2), window=2)
    b.run(3000, np.array([0, 2000]))
    # near w = 2.61 other attractors hit once a period on average, too
    repeats = np.abs(b.window[:, 1, :2] - b.window[:, 0, :2]).max(axis=1) < 1e-9
    once = steady & repeats & (b.counts[:, 0] == 2000)
    assert once.sum() >= 12
    sums = np.sort(b.sums[once, 1], axis=1) / 2000
    np.testing.assert_allclose(sums.sum(axis=1), 2 * np.log(r), rtol=1e-9)
    np.testing.assert_allclose(sums[:, 1], np.log(size[once]), rtol=0, atol=2e-3)


def test_lost_rank_is_minus_infinity_and_the_rest_exact():
    """diag(1, 0) and a turn by 0.7 at every event: exactly ln cos 0.7 and -inf."""
    angle = sympy.Symbol("angle", real=True)
    turned = {X: sympy.cos(angle) * X, V: sympy.sin(angle) * X, S: 0}
    system = cd.HybridSystem(
        name="rank",
        states=(X, V, S),
        parameters={"angle": 0.7},
        modes={"go": {X: 0, V: 0, S: 1}},
        transitions=[cd.Transition("turn", "go", "go", guard=S - 1, direction=+1, reset=turned)],
        period=sympy.Integer(1),
    )
    angles = np.linspace(0.1, 1.4, 13)
    b = batch(
        system,
        np.tile([1.0, 0.3, 0.5], (13, 1)),
        parameters={"angle": angles},
        tangents=np.eye(3)[[2, 0, 1]],
        deficient={0},
    )
    b.run(5, np.array([0, 40]))
    for p, angle_here in enumerate(angles):
        found = sorted(b.sums[p, 1], reverse=True)
        assert found[-1] == -np.inf
        assert min(abs(found[k] - 40 * np.log(np.cos(angle_here))) for k in range(2)) < 1e-11


@pytest.fixture(scope="module")
def ends():
    modes = {
        "grow": {X: X, V: 0},
        "explode": {X: X**2, V: 0},
        "fall": {X: V, V: -1},
        "clock": {X: 1, V: 0},
        "calm": {X: -X, V: sympy.Rational(1, 10)},
    }
    return cd.HybridSystem(
        name="ends",
        states=(X, V),
        parameters={},
        modes=modes,
        transitions=[
            cd.Transition("bounce", "fall", "fall", guard=X, direction=-1, reset={V: -V / 2}),
            cd.Transition("tick", "clock", "clock", guard=X - sympy.Float("1e-5"), direction=+1, reset={X: 0}),
        ],
        period=sympy.Integer(5),
        bounds={X: (-50, 50), V: (-10, 10)},
    )


def test_every_end_is_an_outcome_and_no_neighbour_feels_it(ends):
    modes = ["grow", "calm", "fall", "calm", "clock", "calm", "explode", "calm", "fall", "calm"]
    starts = [[1, 0], [1, 0], [1, 0], [2, 0], [0, 0], [3, 0], [1, 0], [4, 0], [-1, 0], [5, 0]]
    codes = [ends.mode_names.index(m) for m in modes]
    b = batch(ends, starts, codes, window=2)
    b.run(1, np.array([0, 2]))
    expected = [Outcome.ESCAPED, Outcome.STALLED, Outcome.EVENT_LIMIT, Outcome.INVALID_START]
    assert b.outcome[[0, 2, 4, 8]].tolist() == expected
    assert b.outcome[6] in (Outcome.ESCAPED, Outcome.NONFINITE, Outcome.STEP_UNDERFLOW)
    calm = np.array([1, 3, 5, 7, 9])
    assert (b.outcome[calm] == Outcome.OK).all()
    expected = np.array([s[0] for s in starts])[calm] * np.exp(-15)
    np.testing.assert_allclose(b.x[calm, 0], expected, rtol=0, atol=1e-13)
    alone = batch(ends, [starts[5]], [codes[5]], window=2)
    alone.run(1, np.array([0, 2]))
    assert alone.x[0].tobytes() == b.x[5].tobytes()


def test_chatter_is_completed_in_lanes():
    """From (0, v) at gravity 1 and restitution 1/2 infinitely many impacts end at 2 v / (1 - 1/2) = 4 v."""
    system = cd.HybridSystem(
        name="ball",
        states=(X, V, S),
        parameters={},
        modes={"fly": {X: V, V: -1, S: 1}, "rest": {X: 0, V: 0, S: 0}},
        transitions=[
            cd.Transition("impact", "fly", "fly", guard=X, direction=-1, reset={V: -V / 2}),
            cd.Transition("land", "fly", "rest", guard=X, direction=-1, reset={X: 0, V: 0}, completes="impact"),
        ],
        period=sympy.Integer(10),
    )
    speeds = np.linspace(0.2, 2.0, 11)
    b = batch(system, np.column_stack([np.zeros(11), speeds, np.zeros(11)]), window=1, section={1})
    b.run(0, ONE)
    assert (b.mode == 1).all()
    np.testing.assert_array_equal(b.x[:, :2], 0.0)
    # the clock stops where the ball is taken to rest, which is within the square root of the tolerance of the limit
    np.testing.assert_allclose(b.x[:, 2], 4 * speeds, rtol=0, atol=3e-6)
    np.testing.assert_allclose(b.window[:, 0, 2], b.x[:, 2], rtol=0, atol=0)


def test_all_roots_of_a_guard_are_met_in_their_order():
    """A guard (s - r1)(s - r2)(s - r3) along s = t: three roots in one step, some of them close together."""
    r1, r2, r3 = sympy.symbols("r1 r2 r3", real=True)
    system = cd.HybridSystem(
        name="cubic",
        states=(S,),
        parameters={"r1": 0.1, "r2": 0.2, "r3": 0.3},
        modes={"go": {S: 1}},
        transitions=[cd.Transition("meet", "go", "go", guard=(S - r1) * (S - r2) * (S - r3), direction=0)],
        period=sympy.Integer(1),
    )
    rng = np.random.default_rng(11)
    roots = rng.uniform(0.02, 0.98, (400, 3))
    roots[100:250, 1] = roots[100:250, 0] + 10.0 ** rng.uniform(-6, -1, 150)
    roots = np.sort(np.where(roots < 0.99, roots, roots - 0.5), axis=1)
    kept = np.diff(roots, axis=1).min(axis=1) > 5e-7
    roots = roots[kept]
    assert len(roots) > 380
    parameters = {f"r{i + 1}": roots[:, i] for i in range(3)}
    b = batch(system, np.zeros((len(roots), 1)), parameters=parameters, window=4, section={0})
    b.run(0, ONE)
    np.testing.assert_array_equal(b.counts[:, 0], 3)
    slopes = np.abs([np.prod([r[i] - r[k] for k in range(3) if k != i]) for r in roots for i in range(3)]).reshape(
        -1, 3
    )
    # a root is as sharp as the guard's round-off over its slope allows
    assert (np.abs(b.window[:, :3, 0] - roots) <= 1e-15 + 1e-15 / slopes).all()


@pytest.mark.parametrize("tolerance", [1e-4, 1e-7, 1e-12])
def test_a_state_that_only_begins_to_move_has_a_scale_in_its_first_step(tolerance):
    system = cd.HybridSystem(
        name="late-mover",
        states=(X, V, S),
        parameters={},
        modes={"held": {X: V, V: -X, S: 0}, "loose": {X: V, V: -X, S: X}},
        transitions=[cd.Transition("release", "held", "loose", guard=X, direction=-1)],
        period=2 * sympy.pi,
    )
    b = batch(system, [[1.0, 0.0, 0.0]] * 3, tolerance=tolerance, tangents=np.eye(3)[:2])
    b.run(0, ONE)
    assert b.outcome.tolist() == [Outcome.OK] * 3
    # from a quarter of the turn on s is sin(t) - 1
    np.testing.assert_allclose(b.x, [[1.0, 0.0, -1.0]] * 3, rtol=0, atol=100 * tolerance)
