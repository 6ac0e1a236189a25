"""The first crossing of a guard is found, whatever its polynomial, its size and where its series ends."""

import importlib
import itertools
import math
from functools import cache

import mpmath
import numpy as np
import pytest
import sympy
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

import chaosdrill as cd
from chaosdrill.codegen.kinds import Tuple, float64, int64
from chaosdrill.codegen.signatures import matrix, vector
from chaosdrill.engine import roots
from chaosdrill.engine.jit import compiled
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run
from chaosdrill.engine.tuning import ROOTS

x, v, e, X, V, U, T = sympy.symbols("x v e x v u t", real=True)


# The first crossing of a polynomial: found to 1e-12, none missed, none invented, at any degree up to 38.
#
# Polynomials are built from known roots, or numpy's companion matrix finds them and mpmath refines.


@compiled(float64(vector, int64, int64, float64, int64, vector, matrix, matrix))
def first_crossing(g, start, n, h, up, a, stack, ends):
    return roots.first_crossing(g, start, n, h, up == 1, a, stack, ends)


@compiled(Tuple((float64, float64))(vector, int64, int64, float64, int64, vector, vector, matrix, matrix))
def recrossing(g, start, n, h, up, a, shifted, stack, ends):
    return roots.recrossing(g, start, n, h, up == 1, a, shifted, stack, ends)


COLUMNS = 48

INSIDE = st.floats(0.01, 0.99)

OUTSIDE = st.one_of(st.floats(-4, -0.2), st.floats(1.2, 6))

PAIRS = st.tuples(st.floats(-1, 2), st.floats(0.3, 2))


def scratch():
    return np.zeros(COLUMNS), np.zeros((ROOTS.depth, COLUMNS)), np.zeros((ROOTS.depth, 2))


def search(g, up, h=1.0, start=0):
    a, stack, ends = scratch()
    return first_crossing(g, start, len(g) - 1 - start, h, up, a, stack, ends)


def search_again(g, up, h=1.0):
    a, stack, ends = scratch()
    return recrossing(g, 0, len(g) - 1, h, up, a, np.zeros(COLUMNS), stack, ends)[1]


def product(real, complex_pairs=()):
    """Coefficients, lowest first, of prod (1 - s/root) times those of complex pairs; exact to the last digit."""
    with mpmath.workdps(40):
        a = [mpmath.mpf(1)]
        for root in real:
            a = [p - q / root for p, q in zip([*a, 0], [0, *a], strict=True)]
        for middle, spread in complex_pairs:
            middle, spread = mpmath.mpf(middle), mpmath.mpf(spread)
            size = middle**2 + spread**2
            a = [
                p - 2 * middle / size * q + r / size for p, q, r in zip([*a, 0, 0], [0, *a, 0], [0, 0, *a], strict=True)
            ]
        return np.array([float(c) for c in a])


def noise(g, s):
    """Round-off of the coefficients, as a change of the value at s."""
    return 2e-16 * (np.abs(g) @ s ** np.arange(len(g)))


def sensitivity(g, root):
    """How far rounding the coefficients to doubles may move a root."""
    slope = abs(sum(k * c * root ** (k - 1) for k, c in enumerate(g) if k))
    return noise(g, root) / slope if slope else np.inf


def is_clear(g, roots):
    """Whether round-off can neither move the roots by much nor make others."""
    grid = np.linspace(0, 1, 201)
    away = [s for s in grid if all(abs(s - r) > 5e-3 for r in roots)]
    values = np.abs(np.polyval(g[::-1], away))
    blur = np.array([noise(g, s) for s in away])
    return bool(np.all(values > 1e3 * blur)) and all(sensitivity(g, r) < 1e-9 for r in roots)


def towards(g, up):
    """The polynomial or its negative, whichever begins on the side from which ``up`` says that zero is reached."""
    return -g if (g[0] > 0) == up else g


SEPARATE = st.lists(INSIDE, max_size=4, unique_by=lambda r: round(r * 50))


@settings(max_examples=80)
@given(inside=SEPARATE, outside=st.lists(OUTSIDE, max_size=5), pairs=st.lists(PAIRS, max_size=15), up=st.booleans())
def test_the_first_root_of_a_polynomial_with_known_roots_is_found(inside, outside, pairs, up):
    g = product([*inside, *outside], pairs)
    assume(len(g) > 1 and is_clear(g, inside))
    g = towards(g, up)
    found = search(g, up)
    if inside:
        assert abs(found - min(inside)) <= 1e-12 + 4 * sensitivity(g, min(inside))
    else:
        assert found == -1.0


@settings(max_examples=100)
@given(inside=SEPARATE, pairs=st.lists(PAIRS, max_size=15), up=st.booleans())
def test_a_guard_that_was_passed_must_first_come_back(inside, pairs, up):
    """From beyond zero the second root is the first crossing in the direction asked for."""
    g = product([*inside, 3.0], pairs)
    assume(is_clear(g, inside))
    g = -towards(g, up)
    found = search_again(g, up)
    if len(inside) > 1:
        second = sorted(inside)[1]
        assert abs(found - second) <= 1e-12 + 8 * sensitivity(g, second)
    else:
        assert found == -1.0


@settings(max_examples=100)
@given(degree=st.integers(1, 38), seed=st.integers(0, 10**6), decay=st.floats(0.3, 2.0), h=st.floats(1e-3, 5.0))
def test_random_coefficients(degree, seed, decay, h):
    """Like those of a Taylor step, they fall or grow geometrically; numpy's companion matrix is the reference."""
    unit = np.random.default_rng(seed).normal(size=degree + 1) * decay ** -np.arange(degree + 1.0)
    roots = np.roots(unit[::-1])
    near = roots[(roots.real > -0.01) & (roots.real < 1.01)]
    # pairs that the companion matrix cannot tell from double roots, and roots at the end, are for other tests
    assume(not np.any((np.abs(near.imag) > 0) & (np.abs(near.imag) < 1e-4)))
    real = np.sort(near[near.imag == 0].real)
    assume(np.all(np.abs(real - 1) > 1e-6) and np.all(np.diff(real) > 1e-4) and np.all(np.abs(real) > 1e-6))
    inside = real[(real > 0) & (real < 1)]
    found = search(unit / h ** np.arange(degree + 1), up=bool(unit[0] < 0), h=h)
    if not len(inside):
        assert found == -1.0
        return
    with mpmath.workdps(40):
        a = [mpmath.mpf(float(c)) for c in unit[::-1]]
        first = float(mpmath.findroot(lambda s: mpmath.polyval(a, s), mpmath.mpf(inside[0])))
    assert found / h == pytest.approx(first, abs=1e-12 + 8 * sensitivity(unit, first))


@settings(max_examples=100)
@given(
    place=st.floats(0.05, 0.95),
    gap=st.sampled_from([1e-3, 1e-4, 1e-5, 1e-6, 1e-7]),
    apart=st.booleans(),
    outside=st.lists(OUTSIDE, max_size=3),
    pairs=st.lists(PAIRS, max_size=16),
)
@example(place=0.5, gap=1e-7, apart=True, outside=[], pairs=[])
@example(place=0.5, gap=1e-7, apart=False, outside=[], pairs=[])
def test_two_roots_close_together(place, gap, apart, outside, pairs):
    """A double root split by ``gap``: the first of the two; none if it is split into the complex plane."""
    near = [place - gap / 2, place + gap / 2] if apart else []
    g = product([*near, *outside], pairs if apart else [*pairs, (place, gap / 2)])
    up = bool(g[0] < 0)
    # what the second derivative makes of the gap must stand out of the round-off
    bend = abs(sum(k * (k - 1) * c * place ** (k - 2) for k, c in enumerate(g) if k > 1))
    assume(bend * gap**2 / 8 > 50 * noise(g, place))
    found = search(g, up)
    if apart:
        first = place - gap / 2
        assert abs(found - first) <= 1e-12 + 8 * sensitivity(g, first)
    else:
        assert found == -1.0


@pytest.mark.parametrize("gap", [1e-3, 1e-5, 1e-7, 1e-8])
@pytest.mark.parametrize("place", [0.5, 0.25, 0.75])
def test_a_double_root_of_a_parabola_split_by_a_hair(gap, place):
    """(s - r)^2 = (gap/2)^2, as near as doubles can write it; the root of what was written is the reference."""
    g = np.array([place * place - (gap / 2) ** 2, -2 * place, 1.0])
    with mpmath.workdps(40):
        below = mpmath.mpf(place) ** 2 - mpmath.mpf(g[0])
        first = float(place - mpmath.sqrt(below))
    found = search(g, up=False)
    assert abs(found - first) <= 1e-15 + 2e-16 / gap


@settings(max_examples=100)
@given(degree=st.integers(1, 38), up=st.booleans())
def test_a_root_at_the_end_of_the_interval(degree, up):
    """s^n - 1: a root at 1 is found or left to the next step, one before it is found, one after it is not."""
    g = np.zeros(degree + 1)
    g[degree] = 1.0
    for offset in (0.0, 1e-9, -1e-12):
        g[0] = -1.0 + offset
        found = search(g if up else -g, up)
        if offset < 0:
            assert found == -1.0
        elif offset > 0 or found != -1.0:
            assert found == pytest.approx((1 - offset) ** (1 / degree), abs=1e-14)


@settings(max_examples=100)
@given(start=st.integers(1, 5), root=INSIDE, spread=st.floats(0.5, 2))
def test_leading_zeros_are_left_out(start, root, spread):
    """With ``start`` the search is for the roots of g(s)/s^start."""
    rest = product([root, -2.0], [(0.5, spread)])
    g = np.concatenate([np.full(start, 1e-18), -rest])
    assert search(g, up=True, start=start) == pytest.approx(root, abs=1e-12)


@settings(max_examples=100)
@given(degree=st.integers(1, 38), seed=st.integers(0, 10**6), size=st.sampled_from([1e-16, 1e-18, 1e-300, 0.0]))
def test_noise_ends_too(degree, seed, size):
    """A polynomial of round-off has any number of roots, but the search ends and what it returns lies in the step."""
    g = np.random.default_rng(seed).normal(size=degree + 1) * size
    g[0] = -abs(g[0])
    for result in (search(g, up=True), search_again(-g, up=True)):
        assert result == -1.0 or 0.0 <= result <= 1.0


@settings(max_examples=100)
@given(degree=st.integers(2, 38), place=st.floats(0.2, 0.8))
def test_flat_multiple_roots_end_too(degree, place):
    """(s - r)^n expanded: near r it is noise over a wide range."""
    g = np.ascontiguousarray(np.poly([place] * degree)[::-1])
    found = search(g, up=bool(g[0] < 0))
    assert found == -1.0 or 0.0 < found <= 1.0


@pytest.mark.parametrize("h", [1.0, 4.0])
def test_small_whole_coefficients(h):
    """Newton steps from the middle of an interval then often lead exactly to its ends."""
    for a, b, c in itertools.product(range(-12, 0), range(-24, 25), range(-24, 25)):
        g = np.array([a, b, c], dtype=float)
        square = b * b - 4 * a * c
        roots = [-a / b] if c == 0 and b else [(-b + s * square**0.5) / (2 * c) for s in (1, -1) if c and square > 0]
        inside = [r for r in roots if 0 < r < h]
        found = search(g, up=True, h=h)
        if square == 0 or any(abs(r - h) < 1e-12 for r in roots):
            continue
        assert found == (pytest.approx(min(inside), abs=1e-13) if inside else -1.0), g


def test_numpy_agrees_where_roots_are_well_separated():
    """A second reference: the eigenvalues of the companion matrix."""
    rng = np.random.default_rng(7)
    seen = 0
    for _ in range(500):
        g = rng.normal(size=rng.integers(2, 12))
        roots = np.roots(g[::-1])
        real = np.sort(roots[np.abs(roots.imag) < 1e-12].real)
        real = real[(real > 0) & (real < 1)]
        found = search(g, up=bool(g[0] < 0))
        if len(real):
            assert found == pytest.approx(real[0], abs=1e-8)
            seen += 1
        else:
            assert found == -1.0
    assert seen > 100


@settings(max_examples=150)
@given(first=st.floats(0.1, 0.95), scale=st.floats(1e-6, 1e9), ulps=st.integers(-4, 4), up=st.booleans())
def test_a_second_root_at_the_very_end_does_not_hide_the_first(first, scale, ulps, up):
    # (s - first) (s - 1), times the scale
    g = (-scale if up else scale) * np.array([first, -first - 1, 1.0])
    assert search(g, up, h=1 + ulps * np.spacing(1.0)) == pytest.approx(first, abs=1e-13)


# Guards whose series end sooner than those of the states: a pole, a root, a slope that nothing announces.
#
# The same events are written with a guard that is linear; that run is held against the closed form of free motion.


WALL = sympy.Rational(1, 4)

SAME_EVENTS = {
    "root": sympy.sqrt(3 + x) - sympy.sqrt(3 + WALL),
    "pole": 1 / (3 + WALL) - 1 / (3 + x),
    "slope": sympy.tanh(50 * (x - WALL)),
}


def oscillator(guard):
    """x'' = -x from x = 0 with speed 1, and a wall at 1/4 that sends it back with e times its speed."""
    return cd.HybridSystem(
        name="oscillator at a wall",
        states=(x, v),
        parameters={"e": 0.875},
        modes={"free": {x: v, v: -x}},
        transitions=[cd.Transition("impact", "free", "free", guard=guard, direction=+1, reset={v: -e * v})],
        period=sympy.Integer(5),
        initial={"mode": "free", x: 0.0, v: 1.0},
    )


def impacts(speed, count):
    """Times of impacts from x = 0 with that speed: between two the phase goes from the wall through -1 to the wall."""
    found, wall = [np.arcsin(0.25 / speed)], 0.25
    speed = np.sqrt(speed**2 - wall**2)
    for _ in range(count - 1):
        speed *= 0.875
        found.append(found[-1] + 2 * np.pi - 2 * np.arctan2(speed, wall))
    return found


@pytest.mark.parametrize("method", ["taylor", "dop853", "radau"])
@pytest.mark.parametrize("guard", SAME_EVENTS.values(), ids=SAME_EVENTS)
def test_the_events_are_those_of_the_closed_form(guard, method):
    found = cd.trajectory(oscillator(guard), periods=5, method=method)
    assert int(found["outcome"]) == cd.Outcome.OK
    times = found["event_time"].values
    np.testing.assert_allclose(times, impacts(1.0, len(times)), atol=1e-9)
    assert len(times) >= 5


@pytest.mark.parametrize("method", ["taylor", "dop853", "radau"])
def test_a_triple_root_beside_a_double_one_is_met_before_a_step_ends_close_behind_it(method):
    """Five thousandths behind it the guard is a hundredth of what interpolation may leave out, and exact to 1e-14."""
    guard = sympy.expand((x - 2) ** 2 * (x - sympy.Rational(17, 8)) ** 3)
    met = cd.Transition("met", "all", "all", guard, 0, reset={"n": "n + 1"})
    clock = cd.HybridSystem(states=(x, sympy.Symbol("n", real=True)), modes={"all": {x: 1, "n": 0}}, transitions=[met])
    run = cd.trajectory(clock, duration=2.13, samples=1, method=method)
    np.testing.assert_allclose(run["event_time"], [2.125], atol=2e-4)


@pytest.mark.parametrize(
    ("guard", "outcome"),
    [
        (sympy.log(4 * (x - sympy.Rational(1, 8))), cd.Outcome.NONFINITE),
        (1 / (WALL + sympy.Rational(1, 2)) - 1 / (x + sympy.Rational(1, 2)), cd.Outcome.SINGULAR),
    ],
    ids=["no number from the start", "pole on the way"],
)
def test_a_guard_that_has_no_value_ends_the_run(guard, outcome):
    """Alone, and stepped in lanes; beside the pole steps are a part of the way to it, as beside any."""
    system = oscillator(guard)
    run = Run(system, 10.0, Numerics("taylor", 1e-12))
    assert run.advance(1)[0] == outcome
    assert run.steps < 1000
    settings = {"transient": 4, "periods": 4, "max_period": 1, "max_extension": 0}
    diagram = cd.bifurcation_diagram(system, {"e": [0.8, 0.9]}, **settings)
    assert (diagram["outcome"].values == outcome).all()


def test_lanes_meet_the_same_events():
    swept = {"e": np.linspace(0.8, 0.95, 9)}
    settings = {"transient": 0, "periods": 4, "max_period": 1, "max_extension": 0}
    linear, steep = (
        cd.bifurcation_diagram(oscillator(guard), swept, **settings)["section"].values
        for guard in (x - WALL, SAME_EVENTS["slope"])
    )
    np.testing.assert_allclose(steep, linear, atol=1e-8)


def test_a_right_hand_side_that_is_no_number_anywhere_is_an_outcome():
    system = oscillator(x - WALL)
    broken = cd.HybridSystem(
        name="no number",
        states=(x, v),
        parameters={},
        modes={"free": {x: v, v: -x + sympy.sqrt(-1 - x**2)}},
        period=system.period,
        initial=system.initial,
    )
    assert int(cd.lyapunov_spectrum(broken, periods=4)["outcome"]) == cd.Outcome.NONFINITE


# Guards and states of any size: a factor, a unit or a neighbour changes nothing but the unit of the answer.


scales = importlib.import_module("case_14_clocks_ties_and_scales")

METHODS = ("taylor", "dop853", "radau")


def outcome(run):
    return cd.Outcome(int(run["outcome"])).meaning


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("switch", [False, True])
@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e3, 1e6, 1e9])
def test_a_factor_before_a_guard_changes_nothing_next_to_a_state_that_decays(method, switch, scale):
    right = scales.rises()
    assert len(right) == 32
    run = cd.trajectory(
        scales.beside_decay(switch).with_parameters(scale=scale), duration=20.0, samples=2, method=method
    )
    assert outcome(run) == "ok"
    found = run["event_time"].values[run.cd.words("event_kind") == "rise"]
    assert len(found) == 32
    np.testing.assert_allclose(found, right, rtol=0, atol=1e-8)


@pytest.mark.parametrize("method", METHODS)
def test_a_state_that_has_decayed_to_nothing_stops_no_tangent(method):
    """u' = -1000 u is below the smallest number after 0.75."""
    system = cd.HybridSystem(
        name="oscillator beside a decay",
        states=(X, V, U),
        parameters={},
        modes={"run": {X: V, V: -X, U: -1000 * U}},
        period=sympy.Integer(1),
        initial={X: 1.0, V: 0.0, U: 1.0},
    )
    run = cd.lyapunov_spectrum(system, periods=6, blocks=2, method=method)
    np.testing.assert_allclose(run["lyapunov_exponent"], [0, 0, -1000], rtol=1e-9, atol=0.3)
    assert outcome(run) not in ("step_underflow", "nonfinite")


@pytest.mark.parametrize("power", [3, 7])
def test_an_energy_is_kept_within_ten_tolerances(power):
    """x'' = -x**power from (1, 0): the largest jump of the energy within half a unit, in a run of 20000."""
    p = sympy.Integer(power)
    system = cd.HybridSystem(
        name=f"power-{power}",
        states=(X, V),
        parameters={},
        modes={"free": {X: V, V: -(X**p)}},
        initial={X: 1.0},
    )
    run = cd.trajectory(system, duration=20000.0, samples=40000, tolerance=1e-9)
    x, v = run["states"].values.T
    energy = v**2 / 2 + x ** (power + 1) / (power + 1)
    assert np.abs(np.diff(energy)).max() <= 1e-8


@cache
def duffing_in_own_units(method, size, rate):
    system = scales.duffing().with_parameters(size=size, w=rate).with_initial(x=size)
    run = cd.trajectory(system, duration=100.0 / rate, samples=100, method=method)
    return run["states"].values / [size, size * rate]


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    ("size", "rate"), [(1.0, 1.0), (1e-3, 1.0), (1e-9, 1.0), (1e6, 1.0), (2e-6, 2 * math.pi * 1e5), (1e-9, 1e-4)]
)
def test_an_oscillator_of_any_size_keeps_its_energy(method, size, rate):
    """x'' = -w**2 (x + x**3/size**2) over a hundred radians: relative to its energy, and beside the one of size 1."""
    found = duffing_in_own_units(method, size, rate)
    energy = scales.energy(*found.T, 1.0, 1.0)
    np.testing.assert_allclose(energy, 0.75, rtol=1e-10)
    np.testing.assert_allclose(found, duffing_in_own_units(method, 1.0, 1.0), rtol=0, atol=1e-9)


def in_units(system):
    """The same system with lengths and speeds in units of one's choice, which are parameters of it."""
    length, second = sympy.symbols("unit_length unit_time", real=True)
    sizes = {"y": length, "u": length / second, "w": length / second}
    states = {s: sizes[s.name] for s in system.states}
    into = {s: s / size for s, size in states.items()}
    if system.time is not None:
        into[system.time] = system.time / second

    def read(expression):
        return sympy.sympify(expression).xreplace(into)

    return cd.HybridSystem(
        name=f"{system.name} in units",
        states=system.states,
        time=system.time,
        parameters={**system.parameters, "unit_length": 1.0, "unit_time": 1.0},
        modes={
            mode: {s: size / second * read(flow[s]) for s, size in states.items()}
            for mode, flow in system.modes.items()
        },
        transitions=[
            cd.Transition(
                t.name,
                t.source,
                t.target,
                guard=read(t.guard),
                direction=t.direction,
                reset={s: states[s] * read(value) for s, value in t.reset.items()},
                condition={m: read(c) for m, c in t.conditions.items()} or None,
                priority=t.priority,
                kind=t.kind,
            )
            for t in system.transitions
        ],
        period=system.period * second,
        initial=system.initial,
        bounds=dict.fromkeys(system.states),
    )


@pytest.fixture(scope="module")
def drill():
    system = cd.drill(eta=0.8)
    return in_units(system)


@pytest.fixture(scope="module")
def in_its_own_units(drill):
    """The run of the drill by each method that those in other units are held against."""
    return {method: cd.trajectory(drill, periods=10, samples=16, method=method) for method in METHODS}


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    ("length", "second"), [(1.7e-3, 1.0), (1.7e3, 1.0), (1.7e-9, 1.0), (1.7e-3, 0.02), (1.7e3, 2e4)]
)
def test_the_drill_in_metres_and_in_micrometres_is_the_drill(method, length, second, drill, in_its_own_units):
    """Ten periods from rest with hits, sticks and slips, in metres or micrometres, and in seconds or microseconds."""
    own = in_its_own_units[method]
    other = cd.trajectory(
        drill.with_parameters(unit_length=length, unit_time=second), periods=10, samples=16, method=method
    )
    assert outcome(own) == outcome(other) == "ok"
    assert own.sizes["event"] > 20
    np.testing.assert_array_equal(other["event_kind"].values, own["event_kind"].values)
    np.testing.assert_allclose(other["event_time"].values / second, own["event_time"].values, rtol=0, atol=1e-10)
    sizes = [length, length / second, length / second]
    np.testing.assert_allclose(other["states"].values / sizes, own["states"].values, rtol=0, atol=1e-10)


def test_the_drill_has_the_same_exponents_in_any_unit(drill):
    """On its cycle the exponents are those of the multipliers, whatever lengths are measured in."""
    found = [
        cd.lyapunov_spectrum(drill.with_parameters(unit_length=length), periods=64, transient=64)
        for length in (1.0, 1.7e-3, 1.7e3)
    ]
    exponents = np.array([run["lyapunov_exponent"].values for run in found])
    np.testing.assert_array_equal(np.isneginf(exponents), np.isneginf(exponents[[0, 0, 0]]))
    finite = np.isfinite(exponents[0])
    np.testing.assert_allclose(exponents[1:, finite], exponents[[0, 0]][:, finite], rtol=0, atol=1e-6)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("other", [1e-12, 1.0, 1e6])
def test_a_neighbour_of_any_size_does_not_move_an_event(method, other):
    """x = size sin t rises through half its size at pi/6 + 2 pi k, beside an oscillator of another size."""
    y, u = sympy.symbols("y u", real=True)
    size = 1e-6
    system = cd.HybridSystem(
        name="neighbours",
        states=(X, V, y, u),
        parameters={"c": size / 2},
        modes={"free": {X: V, V: -X, y: u, u: -2 * y}},
        transitions=[cd.Transition("rise", "free", "free", guard=X - sympy.Symbol("c"), direction=+1)],
        initial={V: size, y: other},
        bounds=dict.fromkeys((X, V, y, u)),
    )
    run = cd.trajectory(system, duration=100.0, samples=3, method=method)
    right = math.pi / 6 + 2 * math.pi * np.arange(16)
    np.testing.assert_allclose(run["event_time"].values, right, rtol=0, atol=1e-10)
