"""Escape rates and saddles, against open maps and flows that are known in closed form."""

import numpy as np
import pytest

import chaosdrill as cd
from chaosdrill.analysis.measures import saddles
from chaosdrill.analysis.measures.escapes import (
    Rate,
    dimension_of_saddle,
    drift,
    drift_of_flow,
    escape_rate,
    rate_of_flow,
)

WIDTHS = np.array([0.45, 0.35])
RATE = -np.log(WIDTHS.sum())
STARTS = {"count": 4000, "seed": 3, "x": (0, 1)}


def open_tent(widths, *, forced=True, leave=False):
    """Two branches over whole of [0, 1], which a clock applies: what is mapped beyond 1 leaves.

    Of a uniform density, which stays uniform, the widths' sum is left after a step.
    """
    pieces = [("x/a", "x < 1/2"), ("(1 - x)/b", "x >= 1/2")]
    steps = [
        cd.Transition(f"piece-{k}", "wait", "wait", "clock - 1", 1, {"x": image, "clock": "0"}, condition=condition)
        for k, (image, condition) in enumerate(pieces)
    ]
    ends = [cd.Transition("leave", "wait", "wait", "clock - 1/4", 1, condition="x > 1")] if leave else []
    return cd.HybridSystem(
        name="open-tent", states="x clock", parameters={"a": widths[0], "b": widths[1]},
        modes={"wait": {"x": "0", "clock": "1"}}, transitions=[*ends, *steps], period="1" if forced else None,
        initial={"x": 0.3, "clock": 0.5}, bounds={} if leave else {"x": (0, 1)},
    )  # fmt: skip


@pytest.fixture(scope="module")
def skew():
    return cd.transient_chaos(open_tent(WIDTHS), periods=60, random=STARTS)


def test_the_rate_of_the_skew_tent_is_that_of_its_hole(skew):
    assert abs(skew["escape_rate"] - RATE) <= 3 * skew["escape_rate_error"]
    assert skew["escape_rate_error"] < 0.03 * RATE
    assert abs(skew["drift"]) < 3
    assert (skew["outcome"] == cd.Outcome.ESCAPED).all()
    assert skew["surviving"][0] == 1.0
    assert skew["lifetime"].max() < 60


def test_the_exponent_of_its_saddle_is_exact(skew):
    """Branches are visited in proportion to their widths (Kantz and Grassberger 1985)."""
    shares = WIDTHS / WIDTHS.sum()
    exact = -(shares * np.log(WIDTHS)).sum()
    found, error = (skew[name].values[0] for name in ("lyapunov_exponent", "lyapunov_error"))
    assert abs(found - exact) <= 3 * error < 0.05
    # no point of the saddle lies in the hole
    points = skew["saddle_state"].sel(state="x").values
    assert len(points) >= 500
    assert not ((points > WIDTHS[0]) & (points < 1 - WIDTHS[1])).any()


def test_the_dimension_of_its_saddle_is_exact(skew):
    """That of branches visited in proportion to their widths, along the growth; the clock's phase is neutral."""
    shares = WIDTHS / WIDTHS.sum()
    exact = 1 + (shares @ np.log(shares)) / (shares @ np.log(WIDTHS))
    assert abs(skew["saddle_dimension"] - exact) <= 3 * skew["saddle_dimension_error"] < 0.05


def test_the_dimension_of_a_saddle_fills_both_sides_by_its_entropy():
    """Of an open baker's map, along and across; of a flow, one more; as that of Kaplan and Yorke where none leave."""
    shares, along, across = np.array([0.6, 0.4]), np.array([0.45, 0.3]), np.array([0.25, 0.35])
    above, below = -shares @ np.log(along), shares @ np.log(across)
    entropy = -shares @ np.log(shares)
    rates, none = np.array([[above - 0.1, below], [above + 0.1, below]]), np.zeros(2)
    rate = Rate(above - entropy, 0.02, 400)
    found, error, _ = dimension_of_saddle(rates, none, rate, flows=False)
    assert found == pytest.approx(entropy / above - entropy / below)
    by_rate, by_exponent = (1 / above - 1 / below) * 0.02, ((above - entropy) / above**2 - 1 / below) * 0.1
    assert error == pytest.approx(np.hypot(by_rate, by_exponent), rel=1e-6)
    flow = np.insert(rates, 1, [1e-4, -1e-4], axis=1)
    assert dimension_of_saddle(flow, np.zeros(3), rate, flows=True)[0] == pytest.approx(found + 1)
    lost = np.column_stack([rates, np.full(2, -np.inf)])
    assert dimension_of_saddle(lost, np.zeros(3), rate, flows=False)[0] == pytest.approx(found)
    point = dimension_of_saddle(np.full((2, 2), -np.inf), none, Rate(0.0, 0.0, 0), flows=False)
    assert point == (0, 0, "")
    closed = dimension_of_saddle(np.array([[0.5, 0.3, -1.0]] * 2), np.zeros(3), Rate(0.0, 0.0, 0), flows=False)
    assert closed[0] == pytest.approx(2.8)
    for flows in (False, True):
        *unknown, why = dimension_of_saddle(rates * [1, np.nan], none, rate, flows=flows)
        assert np.isnan(unknown).all()
        assert "not a number" in why


def test_exponents_of_a_saddle_do_not_depend_on_units():
    """Of Henon's map with y in a unit by which nothing is rounded: only the tangents to begin with are others."""
    images, box = {"x": "1 - 1.5*x**2 + y/u", "y": "0.3*u*x"}, {"count": 2000, "seed": 1, "x": (-1, 1)}
    found = [
        cd.transient_chaos(
            cd.Map("x y", {"u": u}, images, initial={"x": 0.1, "y": 0.1 * u}, bounds={"x": (-5, 5)}),
            periods=200, random={**box, "y": (-0.3 * u, 0.3 * u)},
        )["lyapunov_exponent"].values
        for u in (1.0, 2.0**-30)
    ]  # fmt: skip
    np.testing.assert_allclose(*found, atol=1e-9)
    assert found[0].sum() == pytest.approx(np.log(0.3), abs=1e-9)


def test_the_tent_map_of_slope_three():
    found = cd.transient_chaos(open_tent([1 / 3, 1 / 3]), periods=40, random=STARTS)
    assert abs(found["escape_rate"] - np.log(1.5)) <= 3 * found["escape_rate_error"]
    assert float(found["lyapunov_exponent"][0]) == pytest.approx(np.log(3), abs=1e-12)


def test_a_life_of_a_map_is_its_iterates_within_the_bounds(skew):
    """Counted here, while rounding has not grown; the same steps of a clock have the same rate."""
    images = {"x": "piecewise(x/a, x < 1/2, (1 - x)/b)"}
    tent = cd.Map("x", dict(zip("ab", WIDTHS, strict=True)), images, initial={"x": 0.3}, bounds={"x": (0, 1)})
    found = cd.transient_chaos(tent, periods=60, random=STARTS)
    x, inside, lives = found["initial_state"].values[:, 0], np.ones(4000, dtype=bool), np.zeros(4000)
    for _ in range(20):
        x = np.where(x < 0.5, x / WIDTHS[0], (1 - x) / WIDTHS[1])
        inside &= (x >= 0) & (x <= 1)
        lives += inside
    np.testing.assert_array_equal(np.minimum(found["lifetime"], 20), lives)
    for name in ("escape_rate", "escape_rate_error", "escapes", "drift"):
        np.testing.assert_array_equal(found[name], skew[name])


def test_runs_that_are_watched_too_short_count_as_long_as_they_were(skew):
    found = cd.transient_chaos(open_tent(WIDTHS), periods=5, transient=1, random=STARTS)
    assert (found["outcome"] == cd.Outcome.OK).sum() > 1000
    assert abs(found["escape_rate"] - RATE) <= 3 * found["escape_rate_error"]


def test_an_event_may_end_a_life(skew):
    found = cd.transient_chaos(open_tent(WIDTHS, leave=True), periods=60, random=STARTS, until="leave")
    assert abs(found["escape_rate"] - RATE) <= 3 * found["escape_rate_error"]
    np.testing.assert_array_equal(found["lifetime"], skew["lifetime"] + 1 / 4)


def test_without_forcing_the_rate_is_one_of_time():
    """At phases that are drawn, too: else all leave at the same moments."""
    free = open_tent(WIDTHS, forced=False)
    found = cd.transient_chaos(free, duration=60.0, random={**STARTS, "clock": (0, 1)})
    # the share that leaves between two steps is linear in time, not exponential: 0.4 %
    assert abs(found["escape_rate"] - RATE) <= 3 * found["escape_rate_error"] + 0.004 * RATE


def test_a_comparison_may_end_a_life_of_a_flow():
    """A saddle: x doubles in ln 2, and from a uniform density over (-1, 1) exp(-t) stays below 1."""
    saddle = cd.HybridSystem(
        name="saddle", states="x y", parameters={}, modes={"on": {"x": "x", "y": "-y"}}, initial={"x": 0.5, "y": 0.5}
    )
    # at 2 every seventh life goes on; of starts beyond the surface none does
    for duration, most in ((2.0, 1), (12.0, 3)):
        starts = {"count": 4000, "seed": 5, "x": (-most, most)}
        found = cd.transient_chaos(saddle, duration=duration, random=starts, until="x**2 > 1")
        assert abs(found["escape_rate"] - 1.0) <= 3 * found["escape_rate_error"]
    exact = -np.log(abs(found["initial_state"].values[:, 0]))
    left = found["outcome"].values == cd.Outcome.ESCAPED
    np.testing.assert_allclose(found["lifetime"].values[left], exact[left], rtol=1e-9, atol=1e-12)
    np.testing.assert_array_equal(left, (exact > 0) & (exact < 12))
    np.testing.assert_array_equal(found["outcome"] == cd.Outcome.INVALID_START, exact < 0)
    np.testing.assert_allclose(found["lyapunov_exponent"], [1, -1], rtol=0, atol=1e-9)
    # a rest has no direction of a flow, which gave it the dimension 1, with an error of 7e-13
    assert np.isnan(found["saddle_dimension"])
    assert "the saddle is an equilibrium, or runs stay too short" in found.attrs["reason"]


def test_a_comparison_may_end_a_life_under_a_drive():
    """At the rate 1 for a unit of time, then at -3 for another: a surface is in every mode that the drive makes."""
    plain = cd.HybridSystem(states="x", parameters={"f": 0.0}, modes={"on": {"x": "f"}}, initial={"x": 0.0})
    driven = cd.driven(plain, "f", {0: "1", "1/2": "-3"}, period=2)
    found = cd.transient_chaos(driven, periods=3, initial={"x": [0.2, 1.5, -1.5, 9.0]}, until="x < -0.9")
    np.testing.assert_allclose(found["lifetime"], [1 + 2.1 / 3, 3 + 1.4 / 3, 0.0, 6.0], rtol=1e-12)
    assert found.cd.outcome.values.tolist() == ["escaped", "escaped", "invalid_start", "ok"]


def test_a_comparison_may_end_a_life_of_a_map():
    """The doubling map that two binary digits 1 in a row end: of n digits as many as a Fibonacci number have none.

    A clock that applies it, halfway to its first iterate, has the same lives and half an iterate more. A life ends at
    the first iterate that is beyond, whether or not one before it was on the surface itself.
    """
    image, until = "piecewise(2*x, x < 1/2, 2*x - 1)", "x >= 3/4"
    doubling = cd.Map("x", {}, {"x": image}, name="doubling", initial={"x": 0.3})
    found = cd.transient_chaos(doubling, periods=40, random=STARTS, until=until)
    golden = (1 + np.sqrt(5)) / 2
    assert abs(found["escape_rate"] - np.log(2 / golden)) <= 3 * found["escape_rate_error"] < 0.02
    np.testing.assert_allclose(found["lyapunov_exponent"], np.log(2), rtol=1e-12)
    x, lives = found["initial_state"].values[:, 0], found["lifetime"].values
    digits = [f"{int(value * 2**53):053b}".find("11") for value in x]
    np.testing.assert_array_equal(found["outcome"] == cd.Outcome.INVALID_START, np.array(digits) == 0)
    np.testing.assert_array_equal(lives, [min(max(first - 1, 0), 40) if first >= 0 else 40 for first in digits])

    step = cd.Transition("step", "wait", "wait", "clock - 1", 1, {"x": "Mod(2*x, 1)", "clock": "0"})
    clocked = cd.HybridSystem(
        name="clocked", states="x clock", modes={"wait": {"x": "0", "clock": "1"}}, transitions=[step],
        initial={"clock": 0.5},
    )  # fmt: skip
    some = {"x": x[:50]}
    timed = cd.transient_chaos(clocked, duration=40.5, initial={**some, "clock": np.full(50, 0.5)}, until=until)
    gone = timed["outcome"].values == cd.Outcome.ESCAPED
    np.testing.assert_array_equal(timed["outcome"], found["outcome"][:50])
    np.testing.assert_array_equal(timed["lifetime"].values[gone], lives[:50][gone] + 0.5)

    count = cd.Map("x", {}, {"x": "x + 1"}, name="count")
    for strict, lives in (("x > 3", [2, 0, 0]), ("3 <= x", [1, 0, 0])):
        found = cd.transient_chaos(count, periods=9, initial={"x": [1.0, 3.0, 3.5]}, until=strict)
        np.testing.assert_array_equal(found["lifetime"], lives)
        np.testing.assert_array_equal(found["outcome"] == cd.Outcome.INVALID_START, [False, strict[0] == "3", True])


def test_where_nothing_leaves_the_rate_is_zero_within_its_error():
    closed = open_tent(np.array([0.4, 0.35])).with_initial(x=0.0)
    found = cd.transient_chaos(closed, periods=50, initial=[{"clock": 0.4}, {"clock": 0.6}])
    assert found["escape_rate"] == 0
    assert 2 * found["escape_rate_error"] == pytest.approx(3 / (2 * (50 - 12)))
    assert np.isnan(found["lyapunov_exponent"]).all()


@pytest.mark.parametrize(
    ("share", "count", "length", "lead"), [(0.2, 200, 1000, 0), (0.2, 400, 4, 2), (0.7, 100, 9, 0)]
)
def test_errors_cover(share, count, length, lead):
    rng = np.random.default_rng(11)
    hits = 0
    for _ in range(400):
        lives = rng.geometric(share, count) - 1
        found = escape_rate(np.minimum(lives, length), lives < length, lead)
        hits += abs(found.value + np.log1p(-share)) <= 2 * found.error
    assert 0.92 <= hits / 400 <= 0.985


def flights(rng, count):
    """Lives of flights of 1 and 2, each as likely as an end: z = exp(rate) solves z + z^2 = 3."""
    lives, stays = np.zeros(count), np.ones(count, dtype=bool)
    while stays.any():
        branch = rng.integers(0, 3, count)
        lives += stays * np.where(branch == 0, 1.0, 2.0)
        stays &= branch != 2
    return lives


@pytest.mark.parametrize("unit", [1e-6, 1.0])
@pytest.mark.parametrize(
    ("draw", "rate"),
    [
        (lambda rng, count: rng.exponential(1.0, count), 1.0),
        (lambda rng, count: 0.3 + rng.geometric(0.23, count), -np.log(0.77)),
        (lambda rng, count: rng.geometric(0.5, count), np.log(2)),
        (flights, np.log((np.sqrt(13) - 1) / 2)),
    ],
    ids=["any time", "steps", "few steps", "flights"],
)
def test_errors_cover_in_flows_whenever_lives_end(draw, rate, unit):
    rng = np.random.default_rng(13)
    hits, drifts = 0, []
    for _ in range(200):
        lives = unit * np.minimum(draw(rng, 2000), 41.3)
        found = rate_of_flow(lives, 1.37 * unit, 41.3 * unit)
        drifts.append(drift_of_flow(lives, 1.37 * unit, 41.3 * unit))
        hits += abs(found.value * unit - rate) <= 2 * found.error * unit
    assert 0.92 <= hits / 200 <= 0.985
    assert 0.8 < np.nanstd(drifts) < 1.2


@pytest.mark.parametrize(("count", "least"), [(3, 0.86), (5, 0.86), (12, 0.9)])
def test_errors_of_few_lives_cover_in_flows(count, least):
    rng, hits = np.random.default_rng(16), 0
    for _ in range(500):
        found = rate_of_flow(np.minimum(rng.exponential(1.0, count), 10.0), 0.0, 10.0)
        hits += abs(found.value - 1.0) <= 2 * found.error
    assert least <= hits / 500 <= 0.985


def test_a_flow_that_leaves_at_whole_times():
    """Lives end at whole numbers of time, which are no multiples of parts of the duration."""
    legs = [("left", "s - 1", "3*x", "x < 1/3"), ("hole", "s - 2", "9", "x >= 1/3 and x < 2/3"),
            ("right", "s - 2", "3*x - 2", "x >= 2/3")]  # fmt: skip
    flow = cd.HybridSystem(
        name="flights", states="x s", parameters={}, modes={"wait": {"x": "0", "s": "1"}}, bounds={"x": (-1, 2)},
        transitions=[
            cd.Transition(name, "wait", "wait", guard, 1, {"x": image, "s": "0"}, condition=condition)
            for name, guard, image, condition in legs
        ],
        initial={"x": 0.1, "s": 0.0},
    )  # fmt: skip
    found = cd.transient_chaos(flow, duration=90.0, random={**STARTS, "count": 10_000})
    exact = np.log((np.sqrt(13) - 1) / 2)
    assert abs(found["escape_rate"] - exact) <= 3 * found["escape_rate_error"] < 0.09 * exact
    assert abs(found["drift"]) < 3


def test_lives_that_are_not_exponential_drift():
    rng = np.random.default_rng(12)
    even = rng.geometric(0.1, 4000) - 1
    mixed = np.where(rng.random(4000) < 0.5, even, rng.geometric(0.02, 4000) - 1)
    assert abs(drift(even, even >= 0, 0)) < 3
    assert drift(mixed, mixed >= 0, 0) < -10


@pytest.mark.parametrize(
    ("starts", "transient", "words"),
    [
        ([{"x": 0.5}], None, "at one age, or soon"),
        ([{"x": 2.0}, {"x": 3.0}], None, "at one age, or soon"),
        ([{"x": 0.5}], 9, "no run is watched beyond the least age"),
    ],
)
def test_runs_that_leave_at_one_age_or_too_early_tell_no_rate(starts, transient, words):
    """It was infinite, without an error."""
    found = cd.transient_chaos(open_tent(WIDTHS), periods=40, initial=starts, transient=transient)
    assert np.isnan([found["escape_rate"], found["escape_rate_error"]]).all()
    assert words in found.attrs["reason"]


@pytest.fixture(scope="module")
def horseshoe():
    images, box = {"x": "a - x**2 + b*y/u", "y": "u*x"}, {"x": (-6, 6)}
    system = cd.Map("x y", {"a": 6.0, "b": 0.3, "u": 2.0**-30}, images, initial={"x": 0.1, "y": 0.0}, bounds=box)
    starts = {"count": 2000, "seed": 1, "x": (-3, 3), "y": (-3 * 2.0**-30, 3 * 2.0**-30)}
    return cd.transient_chaos(system, periods=40, random=starts, saddle="stagger")


def test_staggers_find_a_saddle_that_runs_leave_soon(horseshoe):
    """Rate and exponent of the horseshoe of Henon's map by its 2046 cycles of up to 10 points (cycle expansion)."""
    rate, exponent = 0.8349232170507, 1.5212953674348
    exact = {
        "saddle_rate": rate,
        "lyapunov_exponent": exponent,
        "saddle_dimension": (exponent - rate) * (1 / exponent + 1 / (exponent - np.log(0.3))),
    }
    for name, value in exact.items():
        error = horseshoe[{"lyapunov_exponent": "lyapunov_error"}.get(name, f"{name}_error")]
        assert abs(horseshoe[name].values.ravel()[0] - value) <= 3 * error.values.ravel()[0] < 0.06 * value
    assert float(horseshoe["lyapunov_exponent"].sum()) == pytest.approx(np.log(0.3), abs=1e-9)
    assert horseshoe["staggers"] > 1000
    assert 1e-11 < horseshoe["stagger_size"] < 1e-5


def test_points_that_staggers_find_lie_near_the_saddle(horseshoe):
    """Iterated here, they stay in the square that holds the horseshoe."""
    now, past = horseshoe["saddle_state"].values.T * [[1.0], [2.0**30]]
    assert len(np.unique(now)) > 1000
    edge = (1.3 + np.sqrt(1.3**2 + 4 * 6)) / 2
    for _ in range(2):
        assert (abs(now) <= edge).all()
        now, past = 6 - now**2 + 0.3 * past, now


def test_staggers_where_a_direction_is_lost(monkeypatch):
    """The tent of slope 3, and where it came from: errors of -inf were a warning."""
    monkeypatch.setattr(saddles, "WALKERS", 64)
    images = {"x": "3*Min(x, 1 - x)", "y": "x"}
    tent = cd.Map("x y", {}, images, initial={"x": 0.1, "y": 0.1}, bounds={"x": (0, 1)})
    found = cd.transient_chaos(tent, periods=5, random={**STARTS, "count": 100}, saddle="stagger")
    assert abs(found["saddle_rate"] - np.log(1.5)) <= 3 * found["saddle_rate_error"] < 0.2
    np.testing.assert_allclose(found["lyapunov_exponent"], [np.log(3), -np.inf], rtol=1e-12)


def test_walkers_are_as_many_as_starts_are_worth_unless_asked_for():
    """A flow whose starts all leave at one age took minutes."""
    tent = cd.Map("x", {}, {"x": "3*Min(x, 1 - x)"}, initial={"x": 0.1}, bounds={"x": (0, 1)})
    lengths = {"periods": 5, "transient": 2, "random": {**STARTS, "count": 200}}
    few, many = (cd.transient_chaos(tent, **lengths, saddle=asked) for asked in (None, "stagger"))
    assert 0 < 8 * few["staggers"] < many["staggers"]
    for found in (few, many):
        assert abs(found["saddle_rate"] - np.log(1.5)) <= 3 * found["saddle_rate_error"] < 0.2


def test_walkers_that_were_not_asked_for_give_up_in_time():
    """Half of the starts come to a gait that lasts, and walkers were watched there for hours."""
    walker = cd.build("simplest-walker")
    starts = {"count": 120, "seed": 1, "theta": (0.1, 0.3), "omega": (-0.3, -0.1)}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(saddles, "TIMES", 2)
        patch.setattr(saddles, "FEW", 0)
        found = cd.transient_chaos(walker, duration=40.0, random=starts, until="theta > 0.5")
    assert "takes far longer than the starts" in found.attrs["reason"]
    assert found["staggers"] == 0


def test_starts_that_no_run_has_count_for_nothing():
    """Below the table of the ball none begins; what begins lives as long as it is watched."""
    ball, above, below = cd.build("bouncing-ball"), [{"x": 1.0}], [{"x": -1.0}, {"x": -2.0}]
    alone, beside = (cd.transient_chaos(ball, periods=8, initial=starts) for starts in (above, above + below))
    assert beside["outcome"].values.tolist() == [cd.Outcome.OK] + 2 * [cd.Outcome.INVALID_START]
    for name in ("least_age", "surviving", "escape_rate", "escape_rate_error"):
        np.testing.assert_array_equal(beside[name], alone[name])


def test_staggers_end_at_a_comparison(monkeypatch):
    """x doubles in ln 2: beyond 1 it never becomes true again, and such displacements were taken to stay for ever."""
    monkeypatch.setattr(saddles, "WALKERS", 64)
    saddle = cd.HybridSystem(
        name="saddle", states="x y", parameters={}, modes={"on": {"x": "x", "y": "-y"}}, period=1,
        initial={"x": 0.5, "y": 0.5},
    )  # fmt: skip
    starts = {"count": 400, "seed": 5, "x": (-3, 3)}
    found = cd.transient_chaos(saddle, periods=4, random=starts, until="-x**2/9 < -1/9", saddle="stagger")
    assert abs(found["saddle_rate"] - 1) <= 3 * found["saddle_rate_error"] < 0.2
    assert abs(found["saddle_state"].sel(state="x")).max() < 1
    np.testing.assert_allclose(found["lyapunov_exponent"], [1, -1], rtol=0, atol=1e-9)


def test_runs_that_come_to_a_cycle_tell_of_no_saddle():
    """A sixth of the starts come to a cycle, whose exponents, -0.157 and -1.047, were those of the saddle."""
    images = {"x": "1 - 1.45*x**2 + y", "y": "0.3*x"}
    system = cd.Map("x y", {}, images, initial={"x": 0.1}, bounds={"x": (-5, 5)})
    starts = {"count": 1000, "seed": 1, "x": (-1, 1), "y": (-0.3, 0.3)}
    found = cd.transient_chaos(system, periods=400, random=starts)
    assert found["drift"] < -3
    assert np.isnan(found["lyapunov_exponent"]).all()
    assert "as at an attractor" in found.attrs["reason"]


def test_staggers_refuse_walkers_that_an_attractor_keeps(monkeypatch):
    """In the hole of a tent a point attracts what comes within 0.001: walkers ended there, with exponent -ln 2."""
    monkeypatch.setattr(saddles, "WALKERS", 64)
    images = {"x": "piecewise(0.55 + (x - 0.55)/2, Abs(x - 0.55) < 0.001, x/0.45, x < 1/2, (1 - x)/0.35)"}
    tent = cd.Map("x", {}, images, initial={"x": 0.3}, bounds={"x": (0, 1)})
    found = cd.transient_chaos(tent, periods=20, random={**STARTS, "count": 100}, saddle="stagger")
    assert np.isnan([found["lyapunov_exponent"].item(), found["saddle_rate"]]).all()
    assert "walkers gather where none leaves" in found.attrs["reason"]


def test_where_no_run_stays_there_is_no_saddle():
    found = cd.transient_chaos(open_tent(WIDTHS), periods=40, initial=[{"x": 2.0}], saddle="stagger")
    assert np.isnan(found["lyapunov_exponent"]).all()
    assert "too few runs stay" in found.attrs["reason"]


def test_arguments_that_do_not_fit():
    tent = open_tent(WIDTHS)
    with pytest.raises(cd.SettingsError, match="beyond the guard"):
        cd.transient_chaos(tent, periods=5, random=STARTS, until="piece-0", saddle="stagger")
    with pytest.raises(cd.SettingsError, match="sprinkler"):
        cd.transient_chaos(tent, periods=5, random=STARTS, saddle="staggers")
    with pytest.raises(cd.SettingsError, match="give starts: random"):
        cd.transient_chaos(tent, periods=5)
    with pytest.raises(cd.SettingsError, match=r"has a forcing period; give periods instead \(about 5\)"):
        cd.transient_chaos(tent, duration=5.0, random=STARTS)
    with pytest.raises(cd.SettingsError, match="own-map is a map; give periods instead, which count its iterates"):
        cd.transient_chaos(cd.Map("x", {}, {"x": "x/2"}), duration=5.0, random=STARTS)
    with pytest.raises(cd.SettingsError, match="until"):
        cd.transient_chaos(tent, periods=5, random=STARTS, until="hit")
    forced = cd.HybridSystem(states="x", time="t", modes={"on": {"x": "cos(t)"}}, period="2*pi", initial={"x": 0.0})
    with pytest.raises(cd.SettingsError, match="the surface does not repeat after the forcing period; compare"):
        cd.transient_chaos(forced, periods=5, random=STARTS, until="x > 9 - t")
    beats = forced.remade(modes={"on": {"x": "cos(k*t)"}}, parameters={"k": 1.0}).with_parameters(k=1.5)
    with pytest.raises(cd.ModelError, match=r"cos\(k\*t\) does not repeat after the declared period"):
        cd.transient_chaos(beats, periods=5, random=STARTS, until="x > 9")
    logistic = cd.Map("x", {}, {"x": "3.9*x*(1 - x)"}, initial={"x": 0.3})
    with pytest.raises(cd.SettingsError, match="unknown event 'hit'"):
        cd.transient_chaos(logistic, periods=5, random=STARTS, until="hit")
