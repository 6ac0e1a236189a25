"""Events are those of the closed form, whatever a run is cut into; those at one instant keep their order."""

import importlib
import itertools

import numpy as np
import pytest
import sympy
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

import chaosdrill as cd
from chaosdrill.engine.batch import Batch
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run

X, Y, S = sympy.symbols("x y s", real=True)


# Laws of event lists: they are the closed form's, and nothing but the motion decides what is in them.


lists = importlib.import_module("event_lists")

TOLERANCE = 1e-12

NUMBERS = st.integers(0, 2**32 - 1)
METHODS = ("taylor", "dop853", "radau")
SAME_AT_ANY_CUT = ("clocks", "oscillators", "polynomials of a clock", "kicks", "switches")


def examples(most):
    """So many numbers, none of which is simpler than another one."""
    return settings(max_examples=most, phases=[Phase.explicit, Phase.reuse, Phase.generate])


def drawn(name, number):
    family = lists.FAMILIES[name]()
    return family, *next(family.lists(np.random.default_rng(number), TOLERANCE))


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", lists.FAMILIES)
@examples(6)
@given(number=NUMBERS)
def test_a_list_is_the_closed_forms(name, method, number):
    family, numbers, times = drawn(name, number)
    assert lists.check_single(family, numbers, times, method, TOLERANCE) == []


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6])
def test_guards_of_time_are_exact_at_any_tolerance(tolerance):
    """A guard that touches zero twice a turn was crossed 16 times."""
    family = lists.FAMILIES["clocks"]()
    numbers = {"m": 2.0, "p": np.pi, "c": 0.0, "a": 2.0, "m2": 2.0, "p2": np.pi, "scale": -35257.154680519256}
    times = family.times(numbers, family.length(numbers), tolerance)
    assert lists.check_single(family, numbers, times, "taylor", tolerance) == []
    _, events, wrong = lists.check_lanes(family, np.random.default_rng(5150), tolerance, (3, 3, 1))
    assert events > 0
    assert wrong == []


@pytest.fixture(scope="module")
def touched():
    """A guard that touches zero when a clock reads c, or goes a little beyond it there."""
    x, v, s, c, depth = sympy.symbols("x v s c depth", real=True)
    guard = ((s - c) ** 2 - depth) * (2 + x)
    return cd.HybridSystem(
        states=(x, v, s),
        parameters={"c": 1.0, "depth": 0.0},
        modes={"run": {x: v, v: -x, s: 1}},
        transitions=[cd.Transition(name, "run", "run", guard, way) for name, way in (("down", -1), ("up", 1))],
        initial={x: 1.0},
    )


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8])
@pytest.mark.parametrize("depth", [0.0, 1e-3])
def test_what_a_series_leaves_out_crosses_no_guard(touched, depth, tolerance):
    """One in four of these touches was two events; what does cross is found."""
    places = np.random.default_rng(1).uniform(0.3, 6.0, 24)
    swept = {"c": places, "depth": np.full(24, depth)}
    numerics = Numerics("taylor", tolerance)
    runs = Batch(touched, swept, np.tile([1.0, 0.0, 0.0], (24, 1)), np.zeros(24, int), numerics, unit=6.2)
    runs.run(0, np.array([0, 1]))
    expected = 1 if depth else 0
    assert runs.counts.tolist() == [[expected, expected]] * 24
    for c in places:
        one = touched.with_parameters(c=c, depth=depth)
        run = cd.trajectory(one, duration=6.2, samples=1, tolerance=tolerance)
        assert run.sizes["event"] == 2 * expected


NAMES = {
    "kicks": ("rate", "rate2", "push", "jump", "d1", "d2", "d3", "scale", "x", "v", "clock", "other"),
    "polynomials of a clock": ("c", "scale", "chain_scale", *(f"{a}{i}" for a in "kx" for i in range(6))),
}


def listed(name, values):
    """A family and numbers for it, in the order of their names."""
    return lists.FAMILIES[name](), dict(zip(NAMES[name], map(float, values), strict=True))


FOUND = {
    "a mark is fallen through at the instant of a kick": (
        "kicks",
        (0.5, 0.5, -0.5, 0, -0.125, 0.875, 2.375, 1.118438797196081e-06, 0.875, 0.5, 0.5, 0.5),
    ),
    "a root of a clock has the time of a root of states that ties with it": (
        "polynomials of a clock",
        (
            *(0, 6.140387091138255e-09, -6.718506095508968e-06),
            *(-3, 1, 0, 0, 0, 0),
            *(0, 27.791015625, -108.43359375, 218.15625, -243, 120),
        ),
    ),
    "a clock is moved onto a guard that is met beside a triple root": (
        "polynomials of a clock",
        (
            *(0.125, -2.8307292409138974e-09, -152884.5625207905),
            *(-63.75, 142.625, -126.3125, 55.21875, -11.875, 1),
            *(7.09765625, -19.3515625, 36.375, -42.75, 24, 0),
        ),
    ),
    "what an interpolation leaves out hides where a root of third order leads": (
        "polynomials of a clock",
        (
            *(0.125, -2.912535400543611e-07, 1.9547495014498014e-05),
            *(-930.96875, 1186.234375, -604.560546875, 154.046875, -19.625, 1),
            *(-24.6943359375, 47.8046875, -65.34375, 57, -24, 0),
        ),
    ),
    "a root of third order is met in steps that tangents keep short": (
        "polynomials of a clock",
        (
            *(0, 127690.97097013009, -200.6714508357713),
            *(0, 160.78125, -180.6875, 76.125, -14.25, 1),
            *(-39.345947265625, 110.61572265625, -227.08203125, 321.84375, -285, 120),
        ),
    ),
}
"""Lists that were wrong, or said to be."""

LAST_DIGIT = {
    "thrown onto two marks, from which the motion leads back": (
        "kicks",
        (0.5, 0.5, 1.25, -1.875, 0.125, 0.125, -2.5, 198075.81854307035, 1, 1, 0.25, 0.375),
    ),
    "the same from below": (
        "kicks",
        (1, 2, -1.875, 0.875, 0, -0.375, 0.875, 2.4003442100605857e-07, 0.875, 2, 0.875, 1),
    ),
    "a clock that has been moved has a root at the end": (
        "polynomials of a clock",
        (
            *(0, 2.515586512841347e-07, 319733.94280823524),
            *(-60, 137, -123.5, 54.75, -11.875, 1),
            *(-1.33941650390625, 8.296630859375, -36.2734375, 103.5, -168, 120),
        ),
    ),
}


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("case", FOUND)
def test_a_list_that_was_wrong_is_the_closed_forms(case, method):
    family, numbers = listed(*FOUND[case])
    times = family.times(numbers, family.length(numbers), TOLERANCE)
    assert lists.check_single(family, numbers, times, method, TOLERANCE) == []
    assert_counted(family, numbers, times, method, 1)


def assert_counted(family, numbers, times, method, blocks):
    """A spectrum counts as many events as there are."""
    length = {"periods": family.periods} if family.periods else {"duration": family.length(numbers)}
    run = cd.lyapunov_spectrum(
        family.at(numbers), **length, exponents=1, blocks=blocks, method=method, tolerance=TOLERANCE
    )
    assert lists.outcome(run) not in lists.FAILED
    counts = dict(zip(run["transition"].values, run["event_count"].values.tolist(), strict=True))
    assert counts == {name: len(found) for name, (found, _) in times.items()}


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    ("roots", "scale", "rises", "falls"),
    [([1.5 + k / 512 for k in range(4)], 427673578.5, 2, 2), ([3.875] * 5, -613677530.3, 0, 1)],
    ids=["four roots close together", "a root of fifth order"],
)
def test_what_is_hardly_more_than_rounding_is_counted(roots, scale, rises, falls, method):
    coefficients = np.polynomial.polynomial.polyfromroots(roots)
    family, numbers = listed("polynomials of a clock", [0, scale, 1, *np.resize([*coefficients, 0], 6), 1, *[0] * 5])
    found = dict.fromkeys(("chain-rises", "chain-falls", "chain"), 0) | {"rise": rises, "fall": falls}
    found["either"] = rises + falls
    assert_counted(family, numbers, {name: (range(count), 0) for name, count in found.items()}, method, 64)


def close_roots(seed, most):
    """Five roots up to so far apart, and the numbers that tell their drawing on."""
    rng = np.random.default_rng(seed)
    return rng.uniform(0.3, 3.5) + np.cumsum(rng.uniform(most / 8, most, 5)), rng


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("seed", [1, 2, 3, 34, 92])
def test_close_roots_rise_and_fall_in_turn(seed, method):
    """All of them, where the guard between them is clear of its rounding: that of its terms, each by half a digit."""
    roots, rng = close_roots(seed, 8e-3)
    scale = rng.choice([-1, 1]) * 10 ** rng.uniform(-9, 9)
    coefficients = np.polynomial.polynomial.polyfromroots(roots)
    family, numbers = listed("polynomials of a clock", [0, scale, 1, *coefficients, 1, *[0] * 5])
    _, found, _ = lists.single(family, numbers, method, TOLERANCE)
    first, second = ("rise", "fall") if scale > 0 else ("fall", "rise")
    together = np.full(len(found["either"]), np.nan)
    assert len(together) % 2 == 1
    together[::2], together[1::2] = found[first], found[second]
    assert np.all(np.diff(together) >= 0)
    np.testing.assert_array_equal(together, found["either"])
    between = np.abs(np.prod((roots[1:, None] + roots[:-1, None]) / 2 - roots, axis=1)).min()
    rounding = 2.0**-53 * np.polynomial.polynomial.polyval(roots[-1], np.abs(coefficients))
    assert len(together) == 5 or between < (64 if method == "taylor" else 2048) * rounding


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("most", [8e-3, 1e-4])
def test_close_roots_of_a_product_are_as_exact_as_its_factors(most, method):
    """At the start of a step it rounds by far more than it is between them."""
    product = "*".join(f"(c - r{k})" for k in range(5))
    system = cd.HybridSystem(
        states="c",
        parameters={f"r{k}": 0.0 for k in range(5)},
        modes={"m": {"c": "1"}},
        transitions=[cd.Transition("rise", "m", "m", product, 1), cd.Transition("fall", "m", "m", product, -1)],
        initial={"c": 0.0},
    )
    for seed in (19, 22, 41):
        roots, _ = close_roots(seed, most)
        placed = system.with_parameters(**{f"r{k}": r for k, r in enumerate(roots)})
        run = cd.trajectory(placed, duration=6, samples=1, method=method)
        # a state is a sum over steps
        np.testing.assert_allclose(run["event_time"], roots, rtol=1e-15 if method == "taylor" else 1e-14)
        assert run["event_kind"].values.tolist() == [0, 1, 0, 1, 0]


@pytest.mark.parametrize(("clock", "methods"), [("x", METHODS), ("t", ["taylor"])])
def test_a_guard_of_a_narrow_bump_is_met_from_far(clock, methods):
    """Where a step begins its terms round by more than it reaches."""
    bump = f"1 - (({clock} - 33)/w)**4"
    system = cd.HybridSystem(
        states="x y",
        parameters={"w": 1.0},
        modes={"m": {"x": "1", "y": "cos(x)"}},
        transitions=[cd.Transition("in", "m", "m", bump, 1), cd.Transition("out", "m", "m", bump, -1)],
        initial={"x": 0.0, "y": 0.0},
    )
    widths = np.array([1e-2, 1e-4, 1e-6])
    for w, method in itertools.product(widths, methods):
        run = cd.trajectory(system.with_parameters(w=w), duration=40, samples=1, method=method)
        np.testing.assert_allclose(run["event_time"], [33 - w, 33 + w], rtol=0, atol=1e-12)
    starts, modes = np.zeros((3, 2)), np.zeros(3, dtype=int)
    swept = Batch(system, {"w": widths}, starts, modes, Numerics("taylor", TOLERANCE), unit=40.0)
    swept.run(0, np.array([0, 1]))
    assert swept.counts.tolist() == [[1, 1]] * 3


@pytest.mark.parametrize(
    ("method", "triple", "double", "scale"), [("taylor", 567, 569, -4.816034558996136e-07), ("dop853", 2220, 2227, -9)]
)
def test_a_root_of_third_order_beside_one_of_second_is_where_the_guard_is_zero(method, triple, double, scale):
    roots = np.array([triple, triple, triple, double, double]) / 1024
    terms = np.polynomial.polynomial.polyfromroots(roots)
    family, numbers = listed("polynomials of a clock", [0, scale, 1, *terms, 1, *[0] * 5])
    _, found, _ = lists.single(family, numbers, method, TOLERANCE)
    (time,) = found["fall"]
    rounding = np.finfo(float).eps * np.abs(terms) @ time ** np.arange(6)
    assert abs(np.prod(time - roots)) <= 16 * rounding


@pytest.mark.parametrize("case", LAST_DIGIT)
def test_a_list_that_depends_on_a_last_digit_is_not_drawn(case):
    family, numbers = listed(*LAST_DIGIT[case])
    with pytest.raises(lists.UnclearError):
        family.times(numbers, family.length(numbers), TOLERANCE)


@pytest.mark.parametrize("name", SAME_AT_ANY_CUT)
@examples(3)
@given(number=NUMBERS)
def test_a_list_in_lanes_is_the_closed_forms(name, number):
    *_, wrong = lists.check_lanes(lists.FAMILIES[name](), np.random.default_rng(number), TOLERANCE, (4, 4, 2))
    assert wrong == []


def test_an_event_at_the_end_of_a_run_in_lanes_is_of_the_next_run():
    # roots of the clock's guard at 2 and 4, periods of 1: a step from just before the strobe at 3 ends at that at 4
    numbers = (4096, -1, -33338.804744796675, *(8, -6, 1, 0, 0, 0), *(4098.625, -3.25, 2, 0, 0, 0))
    family, given_numbers = listed("polynomials of a clock", numbers)
    system = family.at(given_numbers)
    start = np.array([given_numbers.get(name, system.initial[name]) for name in system.state_names], dtype=float)
    scales = -np.linspace(10.0, 20.0, 64)
    runs = Batch(
        system, {"scale": scales}, np.tile(start, (64, 1)), np.zeros(64, dtype=int), Numerics(tolerance=TOLERANCE)
    )
    runs.run(0, np.array([0, 4]))
    names = [t.name for t in system.transitions]
    clock = [names.index(name) for name in ("rise", "fall", "either")]
    assert (runs.counts[:, clock] == [1, 0, 1]).all()


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", lists.FAMILIES)
@examples(4)
@given(number=NUMBERS, samples=st.sampled_from([2, 8, 17, 64]))
def test_samples_do_not_change_a_list(name, method, number, samples):
    family, numbers, times = drawn(name, number)
    ended, found, _ = lists.single(family, numbers, method, TOLERANCE, samples=samples)
    assert ended not in lists.FAILED
    assert lists.faults(found, times) == []


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", lists.FAMILIES)
@examples(2)
@given(number=NUMBERS, blocks=st.sampled_from([1, 3, 64]))
def test_blocks_do_not_change_the_number_of_events(name, method, number, blocks):
    family, numbers, times = drawn(name, number)
    assert_counted(family, numbers, times, method, blocks)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", SAME_AT_ANY_CUT)
@examples(4)
@given(number=NUMBERS, part=st.floats(0, 1))
def test_a_transient_takes_the_first_events_and_leaves_the_others(name, method, number, part):
    family, numbers, times = drawn(name, number)
    first = min(int(part * family.periods), family.periods - 1)
    strobe = first * family.length(numbers) / family.periods
    ended, found, _ = lists.single(family, numbers, method, TOLERANCE, transient=first, periods=family.periods - first)
    assert ended not in lists.FAILED
    # an event at the strobe itself comes after it
    kept = {name: (t[here], off[here]) for name, (t, off) in times.items() for here in [t > strobe - 2 * off - 1e-12]}
    assert lists.faults(found, kept) == []


@pytest.mark.parametrize("method", METHODS)
@examples(8)
@given(number=NUMBERS, first=st.integers(1, 3))
def test_a_run_is_cut_in_two_at_a_strobe(method, number, first):
    """Guards of explicit time with the period of the strobe: the second part is a run of its own."""
    family, numbers, times = drawn("clocks", number)
    ended, found, run = lists.single(family, numbers, method, TOLERANCE, periods=first)
    end = dict(zip(run["state"].values, run["states"].values[-1], strict=True))
    then_ended, then, _ = lists.single(family, {**numbers, **end}, method, TOLERANCE, periods=family.periods - first)
    assert not {ended, then_ended} & set(lists.FAILED)
    joined = {name: np.concatenate([found[name], then[name] + first]) for name in found}
    assert lists.faults(joined, times) == []


@pytest.fixture(scope="module")
def reversed_clocks():
    """The same guards in the opposite order; they commute."""
    family = lists.FAMILIES["clocks"]()
    system = family.system
    return cd.HybridSystem(
        name="clocks, declared the other way round",
        states=system.states,
        time=system.time,
        parameters=system.parameters,
        modes=system.modes,
        transitions=system.transitions[::-1],
        period=system.period,
        bounds=dict.fromkeys(system.states),
    )


@pytest.mark.parametrize("method", METHODS)
@examples(8)
@given(number=NUMBERS)
def test_the_order_of_declaration_of_guards_that_commute_does_not_matter(method, number, reversed_clocks):
    family, numbers, times = drawn("clocks", number)
    run = cd.trajectory(reversed_clocks.with_parameters(**numbers), periods=family.periods, samples=1, method=method)
    assert lists.outcome(run) not in lists.FAILED
    assert lists.faults(lists.times_by_name(run), times) == []


@pytest.mark.parametrize("name", SAME_AT_ANY_CUT)
def test_neighbours_and_workers_do_not_change_a_list_in_lanes(name):
    family, numbers, _ = drawn(name, 7)
    axes = {axis: np.unique([numbers[axis] * k for k in (1.0, 1.5, 2.0, 3.0, 5.0)]) for axis in family.axes}
    settings = {"transient": 0, "periods": family.periods, "exponents": 0, "max_extension": 0, "max_period": 1}
    charts = [
        cd.parameter_chart(family.at(numbers), swept, **settings, at="event", section_points=40, workers=workers)
        for swept, workers in ((axes, 1), (axes, 2), ({k: v[::2] for k, v in axes.items()}, 1))
    ]
    one, two, some = (chart["section"].values for chart in charts)
    assert np.isfinite(one).any()
    np.testing.assert_array_equal(one, two)
    np.testing.assert_array_equal(one[::2, ::2], some)


def test_an_interruption_does_not_change_a_list(tmp_path):
    """Guards of a clock, stopped after the first chunk and gone on with."""
    family, numbers, _ = drawn("kicks", 7)
    axes = {"scale": numbers["scale"] * np.linspace(1, 2, 40), "d1": np.linspace(-3, 3, 49)}
    settings = {"transient": 0, "periods": family.periods, "exponents": 0, "max_extension": 0, "max_period": 1}
    settings |= {"at": "event", "section_points": 40}
    calls = {"store": tmp_path / "chart", **settings}

    def stop(done, total, _):
        if 0 < done < total:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        cd.parameter_chart(family.at(numbers), axes, **calls, progress=stop)
    told: list[int] = []
    resumed = cd.parameter_chart(family.at(numbers), axes, **calls, progress=lambda done, *_: told.append(done))
    assert 0 < told[0] < 40 * 49
    whole = cd.parameter_chart(family.at(numbers), axes, **settings)
    np.testing.assert_array_equal(resumed["section"], whole["section"])
    assert np.isfinite(whole["section"]).any()


# Guards that are reached together are counted as ties, and an event at the end of a step is not lost.


@pytest.fixture(scope="module")
def system():
    """Two clocks; each starts anew at 1."""
    return cd.HybridSystem(
        name="clocks",
        states=(X, Y),
        parameters={"rate": 1.0},
        modes={"run": {X: 1, Y: sympy.Symbol("rate")}},
        transitions=[
            cd.Transition("first", "run", "run", guard=X - 1, direction=+1, reset={X: 0}),
            cd.Transition("second", "run", "run", guard=Y - 1, direction=+1, reset={Y: 0}),
        ],
    )


def clocks(system, length, rate, **initial):
    run = Run(system.with_parameters(rate=rate).with_initial(**initial), length, Numerics(), tangents=np.eye(2))
    assert run.advance(1)[0] == cd.Outcome.OK
    return run


def test_clocks_in_step_tie_every_time(system):
    run = clocks(system, 10.5, 1.0)
    assert list(run.counts) == [10, 10]
    assert run.ties == 10


def test_clocks_of_rates_one_and_two_tie_every_other_time(system):
    run = clocks(system, 10.25, 2.0)
    assert list(run.counts) == [10, 20]
    assert run.ties == 10


def test_clocks_that_are_apart_do_not_tie(system):
    run = clocks(system, 10.5, 1.0, x=0.25)
    assert list(run.counts) == [10, 10]
    assert run.ties == 0


@pytest.mark.parametrize("period", [0.5, 1.0, 0.25])
def test_an_event_at_a_strobe_happens_once(system, period):
    """Strobes at multiples of the period fall on the events at 1, 2, 3, ..."""
    run = Run(system.with_initial(y=0.375), period, Numerics(), samples=1)
    for strobe in range(1, round(21 / period)):
        assert run.advance(1)[0] == cd.Outcome.OK
        passed, at_the_end = divmod(strobe * period, 1)
        # an event at the end itself may be left to the next call
        assert run.counts[0] in ((passed - 1, passed) if at_the_end == 0 else (passed,))
        assert run.counts[1] == int(strobe * period + 0.375)


@pytest.mark.parametrize("method", METHODS)
def test_the_unit_of_a_guard_does_not_matter(method):
    """Of two roots 1e-4 apart both are met in both directions, whether or not squares of the guard are doubles."""
    unit, a = sympy.symbols("unit a", real=True)
    system = cd.HybridSystem(
        states=(X, Y),
        parameters={unit: 1.0, a: 0.5},
        modes={"swing": {X: Y, Y: -X}},
        transitions=[cd.Transition("meet", "swing", "swing", guard=unit * (X - a) * (X - a - 1e-4), direction=0)],
        period=2 * sympy.pi,
        initial={"x": 0.0, "y": 1.0},
    )
    first, second = np.arcsin([0.5, 0.5001])
    one = np.array([first, second, np.pi - second, np.pi - first])
    units = [1e-270, 1e-200, 1e-160, 1e-100, 1.0, 1e100, 1e160, 1e270]
    for value in units:
        run = cd.trajectory(system.with_parameters(unit=value), periods=2, method=method, tolerance=TOLERANCE)
        expected = np.concatenate([one, one + 2 * np.pi])
        np.testing.assert_allclose(run["event_time"], expected, rtol=0, atol=1e-11)
    starts, modes = np.tile([0.0, 1.0], (len(units), 1)), np.zeros(len(units), dtype=int)
    swept = Batch(system, {"unit": np.array(units)}, starts, modes, Numerics(method, TOLERANCE))
    swept.run(1, np.array([0, 4]))
    assert swept.counts[:, 0].tolist() == [16] * len(units)


@pytest.fixture(scope="module")
def folded_disc():
    """A billiard in the unit disc, whose hits also turn the disc: all chords have one length, at any angle."""
    c, s, (u, v) = *sympy.symbols("c s", real=True), sympy.symbols("u v", real=True)
    kept = u - 2 * (X * u + Y * v) * X, v - 2 * (X * u + Y * v) * Y
    turned = {a: c * p - s * q for a, (p, q) in {X: (X, Y), u: kept}.items()}
    turned |= {b: s * p + c * q for b, (p, q) in {Y: (X, Y), v: kept}.items()}
    return cd.HybridSystem(
        states=(X, Y, u, v),
        parameters={c: 1.0, s: 0.0},
        modes={"in": {X: u, Y: v, u: 0, v: 0}},
        transitions=[cd.Transition("hit", "in", "in", guard=X**2 + Y**2 - 1, direction=+1, reset=turned)],
        initial={"x": 0.1, "y": 0.2, "u": 0.6, "v": 0.8},
    )


@pytest.mark.parametrize("method", METHODS)
def test_flights_take_as_many_steps_in_other_units_of_time(folded_disc, method):
    """Where series end, steps are as long as the flights between hits."""
    steps = []
    for unit in 2.0 ** np.array([-60, 0, 36]):
        run = Run(folded_disc.with_initial(u=0.6 / unit, v=0.8 / unit), 20 * unit, Numerics(method, TOLERANCE))
        assert run.advance(1)[0] == cd.Outcome.OK
        assert run.counts[0] == 10
        steps.append(run.steps)
    assert steps == [steps[1]] * 3


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("angle", [0.0, 0.3, np.pi])
def test_hits_that_turn_states_which_stand_still_are_each_met_once(folded_disc, method, angle):
    """What a hit makes of an error in a velocity may not grow from hit to hit, until nothing tells a side any more."""
    system = folded_disc.with_parameters(c=np.cos(angle), s=np.sin(angle))
    run = cd.trajectory(system, duration=200.0, samples=1, method=method, tolerance=TOLERANCE)
    chord, first = 2 * np.sqrt(1 - 0.04**2), np.sqrt(1 - 0.04**2) - 0.22
    np.testing.assert_allclose(run["event_time"], np.arange(first, 200, chord), rtol=0, atol=1e-11)
