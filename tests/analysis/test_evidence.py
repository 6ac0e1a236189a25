"""The 0-1 test, smooth averages, rotation numbers and finite-time exponents, against what is known in closed form."""

import numpy as np
import pytest
import sympy
from scipy.signal import lfilter
from scipy.special import ellipk
from scipy.stats import binom, norm

import chaosdrill as cd
from chaosdrill.analysis.judgement.tori import smooth_means, turns, zero_one_by_turn
from chaosdrill.analysis.measures.evidence import growth
from chaosdrill.analysis.measures.finite_times import correlation_time, cumulants, density
from chaosdrill.dataset import Outcome

GOLDEN = (np.sqrt(5) - 1) / 2
SHARE = 0.37


def switched(name, images, **parameters):
    """A map of one state by pieces, as a switch that a clock works: (image, condition), tried in order."""
    transitions = [
        cd.Transition(f"piece-{i}", "wait", "wait", "clock - 1", 1, {"x": image, "clock": "0"}, condition=condition)
        for i, (image, condition) in enumerate(images)
    ]
    return cd.HybridSystem(
        name=name, states="x clock", parameters=parameters, modes={"wait": {"x": "0", "clock": "1"}},
        transitions=transitions, period="1", initial={"x": 0.3127, "clock": 0.5},
    )  # fmt: skip


@pytest.fixture(scope="module")
def skew_tent():
    return switched("skew-tent", [("x/a", "x < a"), ("(1 - x)/(1 - a)", "x >= a")], a=SHARE)


@pytest.fixture(scope="module")
def tripling():
    return switched("tripling", [("3*x", "x < 1/3"), ("3*x - 1", "x < 2/3"), ("3*x - 2", "True")])


@pytest.fixture(scope="module")
def pendulum():
    """Seen once a unit of time: a rotation on a closed curve, by the ratio of that to the period of the swing."""
    return cd.HybridSystem(
        name="pendulum", states="q p", parameters={"T": 1.0}, modes={"on": {"q": "p", "p": "-sin(q)"}}, period="T",
        initial={"q": 2.0},
    )  # fmt: skip


def bernoulli(share):
    """Cumulants of the growth over one step of the skew tent map, whose steps are independent."""
    rest = share * (1 - share)
    jump = np.log((1 - share) / share)
    mean = -share * np.log(share) - (1 - share) * np.log(1 - share)
    return np.array([mean, rest * jump**2, rest * (1 - 2 * share) * jump**3, rest * (1 - 6 * rest) * jump**4])


# The 0-1 test.


def as_published(values, angle):
    """K by the formulas of the paper (section 3), sum by sum."""
    count = len(values)
    steps = np.arange(1, count // 10 + 1)
    j = np.arange(1, count + 1)
    p, q = np.cumsum(values * np.cos(j * angle)), np.cumsum(values * np.sin(j * angle))
    kept = count - count // 10
    square = [((p[n : n + kept] - p[:kept]) ** 2 + (q[n : n + kept] - q[:kept]) ** 2).mean() for n in steps]
    swing = values.mean() ** 2 * (1 - np.cos(steps * angle)) / (1 - np.cos(angle))
    return np.corrcoef(steps, np.array(square) - swing)[0, 1]


def test_growth_is_that_of_the_published_formulas():
    rng = np.random.default_rng(4)
    values = rng.normal(size=600) + 0.3 * np.cumsum(rng.normal(size=600)) * 0.1
    centred = values - values.mean()
    found = zero_one_by_turn(values)
    np.testing.assert_allclose(found, [as_published(centred, c) for c in turns()], rtol=0, atol=1e-9)
    np.testing.assert_allclose(found, [as_published(values, c) for c in turns()], rtol=0, atol=0.05)


@pytest.mark.parametrize(("r", "low", "high"), [(3.97, 0.98, 1.0), (3.55, -0.05, 0.05), (3.83, -0.05, 0.05)])
def test_the_logistic_map_is_chaotic_or_on_a_cycle(logistic, r, low, high):
    found = cd.zero_one_test(logistic.with_parameters(r=r), periods=1500, transient=500)
    assert low < float(found["k"].sel(state="x")) < high
    # the clock does not move on the section
    assert np.isnan(found["k"].sel(state="clock"))
    assert found["k_by_turn"].sizes == {"state": 2, "turn": 24}


def test_a_rotation_is_regular_and_a_run_that_escapes_has_no_growth(circle):
    angle = 2 * np.pi * GOLDEN
    found = cd.zero_one_test(circle.with_parameters(angle=angle), periods=1000)
    assert (abs(found["k"]) < 0.02).all()
    assert (found["k_error"] < 0.02).all()
    lost = cd.zero_one_test(circle.with_parameters(growth=1.0), periods=1000)
    assert int(lost["outcome"]) == cd.Outcome.ESCAPED
    assert lost["k"].isnull().all()


def test_the_error_of_growth_covers_what_other_starts_give(logistic):
    chaotic = logistic.with_parameters(r=3.97)
    runs = [cd.zero_one_test(chaotic.with_initial(x=x), periods=500, transient=99) for x in np.linspace(0.2, 0.4, 40)]
    growth, error = (np.array([float(run[name].sel(state="x")) for run in runs]) for name in ("k", "k_error"))
    assert np.mean(abs(growth - growth.mean()) <= 2 * error) >= 0.85
    assert error.mean() < 4 * growth.std()


def test_the_error_of_growth_covers_that_of_regular_motion_in_few_points():
    """Over a few steps a rotation or a cycle grows as chaos does: K of 64 points is 0.8 on average."""
    rng = np.random.default_rng(3)
    for count in (40, 64, 100, 160, 240, 400):
        angles = 2 * np.pi * rng.uniform(0.02, 0.98, (60, 1)) * np.arange(count)
        cycles = [rng.normal(size=period)[np.arange(count) % period] for period in rng.integers(2, 9, 60)]
        found = np.array([growth(values)[:2] for values in (*np.cos(angles), *cycles)])
        assert np.mean(abs(found[:, 0]) <= 2 * found[:, 1]) >= 0.9, count


# Smooth averages and rotation numbers.


@pytest.mark.parametrize("angle", [0.5, 1.0, 2.0, 3.0])
def test_the_rotation_number_of_a_pendulum_is_an_elliptic_integral(pendulum, angle):
    exact = 1 / (4 * ellipk(np.sin(angle / 2) ** 2))
    swing = pendulum.with_initial(q=angle)
    found = cd.regularity(swing, periods=2000, plane=["p", "q"])
    assert abs(float(found["rotation_number"]) - exact) <= 2 * float(found["rotation_number_error"]) < 1e-9
    assert (found["digits"] > 11).all()
    back = cd.regularity(swing, periods=2000)
    assert float(back["rotation_number"]) == pytest.approx(1 - exact, abs=1e-10)


@pytest.mark.parametrize("speed", [2.5, -7.0])
def test_an_angle_that_goes_round_turns_by_itself(pendulum, speed):
    """A pendulum that goes over the top, by the time of a turn."""
    exact = speed / (4 * ellipk(4 / speed**2)) % 1
    found = cd.regularity(
        pendulum.with_initial(q=0.1, p=(speed**2 - 2 + 2 * np.cos(0.1)) ** 0.5 * np.sign(speed)), periods=1000
    )
    assert float(found["rotation_number"]) == pytest.approx(exact, abs=1e-9)


def test_what_has_no_rotation_number_says_why(logistic):
    """The clock is at one value whenever it ticks; of forty values of one state there are 39 pairs."""
    assert "clock did not move" in cd.regularity(logistic, periods=100, plane=["clock", "x"]).attrs["reason"]
    assert cd.regularity(logistic, periods=40).attrs["reason"].startswith("39 pairs")


def test_angles_that_go_round_apart_are_named():
    """The standard map turns evenly by its momentum; where it is chaotic, the momentum wanders over many turns."""
    rules = {"x": "x + p + k*sin(x)", "p": "p + k*sin(x)", "y": "y + 2 + sin(y)/4"}
    start = {"x": 0.1, "p": 2 * np.pi * 0.6237}
    even, swapped = (cd.Map(names, {"k": 0.0}, rules, initial=start) for names in ("x y p", "y x p"))
    for system in (even, swapped):
        found = cd.regularity(system, periods=500)
        assert found["rotation_number"].isnull()
        assert "go round apart" in found.attrs["reason"]
        assert "goes round by itself" in cd.regularity(system, periods=500, plane=["p", "x"]).attrs["reason"]
        named = cd.regularity(system, periods=500, plane=["x"])
        assert float(named["rotation_number"]) == pytest.approx(0.6237, abs=1e-12)
    wanders = cd.regularity(even.with_parameters(k=5.0), periods=500, plane=["x"])
    assert wanders["rotation_number"].isnull()
    assert wanders["rotation_number_error"].isnull()
    assert "not to a part of one" in wanders.attrs["reason"]


def test_the_error_of_turns_covers_where_a_remainder_cuts_the_circle():
    """Both halves agreed by chance; 0.62370909347 by 20,000 points of the same map without the remainder."""
    cut = cd.Map("x", {"g": GOLDEN}, {"x": "Mod(x + g + sin(2*pi*x)/10, 1)"}, initial={"x": 0.1})
    found = cd.regularity(cut, periods=1000)
    assert abs(float(found["rotation_number"]) - 0.62370909347) <= 2 * float(found["rotation_number_error"]) < 2e-5


def test_the_golden_mean(circle):
    found = cd.regularity(circle.with_parameters(angle=2 * np.pi * GOLDEN), periods=1500)
    assert float(found["rotation_number"]) == pytest.approx(GOLDEN, abs=1e-12)
    assert int(found["period"]) == 0


def test_averages_of_predator_and_prey_are_those_of_the_rest():
    """Over any cycle of Lotka and Volterra the means of both are those of the point at rest (Volterra 1926)."""
    system = cd.HybridSystem(
        name="prey", states="x y", parameters={"a": 1.5}, modes={"on": {"x": "x*(a - y)", "y": "y*(x - 1)"}},
        period="1", initial={"x": 2.0, "y": 1.0},
    )  # fmt: skip
    found = cd.regularity(system, periods=3000)
    apart = abs(found["average"].values - [1.0, 1.5])
    assert (apart <= 2 * found["average_error"].values).all()
    assert (found["average_error"] < 1e-10).all()


def test_in_chaos_averages_have_few_digits_and_an_error_that_says_so(logistic):
    """At r = 4 the mean of x is 1/2, by its density (Ulam and von Neumann)."""
    found = cd.regularity(logistic.with_parameters(r=4 - 1e-9), periods=4000, transient=50)
    assert found["digits"].sel(state="x") < 4
    assert abs(float(found["average"].sel(state="x")) - 0.5) < 5 * float(found["average_error"].sel(state="x")) + 0.01
    assert np.isnan(found["average"].sel(state="clock"))
    # steps fill the turn: whole turns would be counted from another angle in every record
    assert found["rotation_number"].isnull()
    assert "turns can be counted" in found.attrs["reason"]
    still = cd.regularity(logistic.with_parameters(r=2.0).with_initial(x=0.5), periods=50)
    assert "nothing moves" in still.attrs["reason"]


def test_a_winner_rests_where_the_loser_still_decays():
    """Steps of hundreds of times grow towards a node, and from such samples a motion has no time of its own."""
    rates = {"x": "x*(1 - x - 2*y)", "y": "y*(1 - 2*x - y)"}
    rivals = cd.HybridSystem(states="x y", modes={"on": rates}, initial={"x": 0.6, "y": 0.3})
    found = cd.lyapunov_spectrum(rivals, duration=384, transient=20, method="radau", tolerance=1e-12)
    assert abs(found["lyapunov_exponent"].sum() + 2) < 1e-5
    assert found.cd.outcome == "equilibrium"


def orbits(image, starts, count):
    """Orbits of a map from many starts, shape (starts, count)."""
    found = np.empty((len(starts), count + 200))
    for column in found.T:
        column[:] = starts = image(starts)
    return found[:, 200:]


@pytest.mark.parametrize("count", [64, 1024])
@pytest.mark.parametrize(
    ("image", "mean"),
    [(lambda x: 4 * x * (1 - x), 0.5), (lambda x: np.where(x < SHARE, x / SHARE, (1 - x) / (1 - SHARE)), 0.5)],
    ids=["logistic", "skew tent"],
)
def test_errors_of_smooth_averages_cover_in_chaos(image, mean, count):
    """The difference of two halves alone covers in 84 %."""
    values = orbits(image, np.random.default_rng(8).random(500), count)
    found, apart, error = smooth_means(values, np.ones(500))
    off = abs(found - mean)
    assert 0.93 <= np.mean(off <= 2 * error) <= 0.995
    assert np.mean(off <= 2 * apart) < 0.9
    assert np.sqrt((error**2).mean()) < 3 * found.std()


def test_errors_of_smooth_averages_on_a_torus_are_still_those_of_the_halves():
    phase = np.random.default_rng(8).random((50, 1)) + GOLDEN * np.arange(512)
    values = np.cos(2 * np.pi * phase) + 0.3 * np.sin(6 * np.pi * phase)
    found, apart, error = smooth_means(values, np.ones(50))
    assert (error >= apart).all()
    assert np.median(error / apart) == 1
    assert (error < 1e-9).all()
    assert (abs(found) <= 2 * error + 1e-15).all()


def test_the_error_of_digits_covers_what_other_starts_give(logistic):
    starts = [logistic.with_parameters(r=3.97).with_initial(x=x) for x in np.linspace(0.2, 0.4, 40)]
    runs = [cd.regularity(one, periods=300, transient=99).sel(state="x") for one in starts]
    digits, error = (np.array([float(run[name]) for run in runs]) for name in ("digits", "digits_error"))
    assert np.mean(abs(digits - digits.mean()) <= 2 * error) >= 0.9
    assert error.mean() < 2 * digits.std()


# Sweeps.


def test_a_sweep_is_made_of_the_runs_at_its_values(logistic, pendulum):
    values = [3.2, 3.83, 3.97, 4.5]
    swept = cd.zero_one_test(logistic, {"r": values}, periods=400, transient=300)
    assert swept.cd.outcome.values.tolist() == ["periodic", "periodic", "ok", "escaped"]
    for r in values:
        one = cd.zero_one_test(logistic.with_parameters(r=r), periods=400, transient=300)
        for name in ("k", "k_error", "k_by_turn", "period", "outcome"):
            assert one[name].identical(swept[name].sel(r=r, drop=True)), name
    turned = cd.regularity(pendulum, {"T": [1.0, -1.0, 0.5]}, periods=500, plane=["p", "q"])
    exact = np.array([1.0, np.nan, 0.5]) / (4 * ellipk(np.sin(1.0) ** 2))
    np.testing.assert_allclose(turned["rotation_number"], exact, rtol=0, atol=1e-9)
    assert turned.cd.outcome.values.tolist() == ["ok", "failed", "ok"]


def test_sections_of_sweeps_are_found_at_every_value():
    lorenz, surface = cd.build("lorenz"), {"periods": 50, "at": "x > 0", "transient": 5}
    swept = cd.regularity(lorenz, {"rho": [10.0, 28.0]}, **surface, workers=2)
    assert swept.cd.outcome.values.tolist() == ["equilibrium", "ok"]
    one = cd.regularity(lorenz.with_parameters(rho=28.0), **surface)
    for name in ("average", "average_error", "digits", "rotation_number"):
        assert one[name].identical(swept[name].sel(rho=28.0, drop=True)), name


def test_a_sweep_that_was_stopped_goes_on(logistic, tmp_path):
    def stop(done, total, outcomes):
        if done:
            raise KeyboardInterrupt

    asked = {"sweep": {"r": np.linspace(3.5, 3.9, 64)}, "periods": 50, "store": tmp_path / "store"}
    with pytest.raises(KeyboardInterrupt):
        cd.regularity(logistic, **asked, progress=stop)
    found = []
    resumed = cd.regularity(logistic, **asked, progress=lambda done, *_: found.append(done))
    assert found[0] > 0
    assert resumed.drop_attrs().identical(cd.regularity(logistic, **asked | {"store": None}).drop_attrs())
    with pytest.raises(cd.SettingsError, match=r"holds finished chunks of other work(.|\n)*periods: 50 before, 60 now"):
        cd.regularity(logistic, **asked | {"periods": 60})


def test_what_a_sweep_cannot_be(logistic, tmp_path):
    spring = cd.HybridSystem(
        name="spring", states="x v", parameters={"k": 1.0}, modes={"on": {"x": "v", "v": "-k*x - v"}}, period="1"
    )
    with pytest.raises(cd.SettingsError, match=r"sweep.*k.*is a variable of the result"):
        cd.zero_one_test(spring, {"k": [1.0, 2.0]}, periods=50)
    assert cd.regularity(spring, {"k": [1.0, 2.0]}, periods=50).sizes["k"] == 2
    with pytest.raises(cd.SettingsError, match="store applies to the points of a sweep"):
        cd.regularity(logistic, periods=50, store=tmp_path)
    with pytest.raises(cd.SettingsError, match="store is ''; it must be the name of a folder"):
        cd.regularity(logistic, {"r": [3.2, 3.3]}, periods=50, store="")


def test_a_record_too_short_says_nothing(pendulum):
    found = cd.regularity(pendulum, periods=39)
    assert found["digits"].isnull().all()
    assert found["rotation_number"].isnull()
    assert found.attrs["reason"] == "39 points say nothing: record 40 at least"


def test_a_method_that_no_value_can_use_is_refused():
    """Every value of the sweep had failed, without a word."""
    function = cd.Map("x", {"a": 3.9}, lambda t, x, p: (p[0] * x[0] * (1 - x[0]),), initial={"x": 0.3})
    for analysis in (cd.regularity, cd.finite_time_exponents):
        with pytest.raises(cd.SettingsError, match="takes series of expressions"):
            analysis(function, {"a": [3.8, 3.9]}, periods=100)


# Exponents over finite times.


def test_skew_tent_map(skew_tent):
    """Growth over a step is one of two logarithms, independent of all others; the clock's is 0."""
    found = cd.finite_time_exponents(skew_tent, periods=8000, transient=64)
    for window in (1, 10, 100):
        exact = bernoulli(SHARE) / float(window) ** np.arange(4)
        one = found.sel(window=window, exponent=1)
        assert (abs(one["cumulant"].values - exact) <= 4 * one["cumulant_error"].values).all()
    shares = (found["histogram"] * found["bin_centre"].diff("bin").mean("bin")).sel(exponent=1)
    np.testing.assert_allclose(shares.sum("bin"), 1.0)
    np.testing.assert_allclose(shares.sel(window=1).values[[0, -1]], [1 - SHARE, SHARE], atol=0.02)
    assert shares.sel(window=1).values[1:-1].max() == 0.0
    time, error = (float(found[name].sel(exponent=1)) for name in ("correlation_time", "correlation_time_error"))
    assert abs(time - 1.0) <= 4 * error < 1.0
    assert float(found["lyapunov_exponent"].sel(exponent=2)) == pytest.approx(0.0, abs=1e-12)


def test_growth_that_is_constant_has_no_spread(tripling):
    found = cd.finite_time_exponents(tripling, periods=1000, windows=[1, 7], bins=5)
    np.testing.assert_allclose(found["cumulant"].sel(exponent=1), [[np.log(3), 0, 0, 0]] * 2, atol=1e-12)
    # what the tolerance leaves open of the exponent is open of its mean as well
    error = found["cumulant_error"].sel(exponent=1)
    assert (error.sel(order=slice(2, None)) < 1e-12).all()
    np.testing.assert_allclose(error.sel(order=1), found["lyapunov_error"].sel(exponent=1), rtol=1e-6)
    assert (error.sel(order=1) < 1e-11).all()
    assert np.isnan(found["correlation_time"].sel(exponent=1))
    assert found["histogram"].sizes == {"window": 2, "exponent": 2, "bin": 5}


@pytest.mark.parametrize(
    "lengths", [{"duration": 8.0, "transient": 7.0}, {"periods": 6, "at": "x > 0", "transient": 3}]
)
def test_the_mean_is_the_exponent_of_the_spectrum(lengths):
    """Also behind a transient, whose strobes are counted anew."""
    lorenz = cd.build("lorenz")
    spectrum = cd.lyapunov_spectrum(lorenz, **lengths)
    found = cd.finite_time_exponents(lorenz, **lengths, windows=[0.1, 1.03])
    np.testing.assert_allclose(found["lyapunov_exponent"], spectrum["lyapunov_exponent"], rtol=0, atol=1e-4)
    # a window of any length takes volume at the rate of the field's divergence
    volume = found["cumulant"].sel(order=1).sum("exponent")
    np.testing.assert_allclose(volume, -(10 + 1 + 8 / 3), rtol=1e-9)
    assert (abs(found["window"] - [0.1, 1.0]) < 0.04).all()


def test_windows_of_a_sweep_are_those_of_the_runs_at_its_values(tmp_path):
    duffing = cd.build("duffing")
    asked = {"periods": 200, "transient": 20, "windows": [2, 5], "exponents": 1}
    values = [0.2, 0.3, 0.25]
    swept = cd.finite_time_exponents(duffing, {"delta": values}, workers=2, store=tmp_path / "store", **asked)
    for value in values:
        one = cd.finite_time_exponents(duffing.with_parameters(delta=value), **asked)
        here = swept.sel(delta=value)
        for name in one.data_vars:
            np.testing.assert_array_equal(here[name], one[name])
        np.testing.assert_array_equal(here["window_time"], one["window"])
    again = cd.finite_time_exponents(duffing, {"delta": values}, store=tmp_path / "store", **asked)
    assert swept.drop_attrs().identical(again.drop_attrs())
    # the time that three points take holds two windows of such a length at some values only
    flow = cd.build("roessler")
    short = cd.finite_time_exponents(flow, {"c": [2.5, 5.7]}, at="x > 0", periods=8, transient=20, windows=[11.7])
    assert sorted(short["outcome"].values.tolist()) == [Outcome.OK, Outcome.FAILED]


@pytest.mark.parametrize("name", ["impact-oscillator", "roessler"])
def test_distributions_do_not_depend_on_units(name):
    """Nor do errors, that of an exponent by no more than units move it; chaos, by which motions part, is weak here."""
    system = cd.build(name)
    lengths = {"periods": 300} if system.forced else {"duration": 60}
    units = {x: 2.0**k for x, k in zip(system.states, (-30, 20, 7), strict=False)}

    def put(e):
        return sympy.sympify(e).xreplace({x: x / unit for x, unit in units.items()})

    scaled = cd.HybridSystem(
        name=name, states=system.states, time=system.time, period=system.period, parameters=system.parameters,
        modes={m: {x: units[x] * put(e) for x, e in field.items()} for m, field in system.modes.items()},
        transitions=[
            cd.Transition(t.name, t.source, t.target, put(t.guard), t.direction,
                          {x: units[x] * put(e) for x, e in t.reset.items()}, t.condition and put(t.condition),
                          t.priority, t.completes, t.kind)
            for t in system.transitions
        ],
        initial={x: units[x] * system.initial[x.name] for x in system.states} | {"mode": system.initial["mode"]},
    )  # fmt: skip
    one, other = (cd.finite_time_exponents(s, transient=20, **lengths) for s in (system, scaled))
    moved, larger = (np.abs(other[of] - one[of]) for of in ("lyapunov_exponent", "lyapunov_error"))
    assert (larger <= moved + 1e-6 * one["lyapunov_error"]).all()
    of_mean = np.abs(other["cumulant_error"] - one["cumulant_error"]).sel(order=1)
    assert (of_mean <= larger + 1e-6 * one["lyapunov_error"]).all()
    one, other = (found.assign(cumulant_error=found["cumulant_error"].sel(order=[2, 3, 4])) for found in (one, other))
    for of in ("cumulant", "cumulant_error", "bin_centre", "histogram", "histogram_error"):
        np.testing.assert_allclose(other[of], one[of], rtol=1e-6, atol=1e-9 * np.abs(one[of]).max().item())


def test_a_mean_of_growth_that_does_not_vary_has_the_error_of_the_method():
    """Of x' = -x, of which `lyapunov_spectrum` says the same."""
    decay = cd.HybridSystem(states="x", parameters={}, modes={"on": {"x": "-x"}}, initial={"x": 1.0})
    found, spectrum = cd.finite_time_exponents(decay, duration=40.0), cd.lyapunov_spectrum(decay, duration=40.0)
    error = float(found["lyapunov_error"][0])
    assert abs(found["lyapunov_exponent"][0] + 1) <= 2 * error
    assert error >= 0.5 * float(spectrum["lyapunov_error"][0]) > 0


def test_lost_rank_has_no_distribution():
    relay = cd.build("relay-sliding")
    found = cd.finite_time_exponents(relay, periods=40, transient=20, windows=[2])
    lost = np.isneginf(found["lyapunov_exponent"].values)
    assert lost.any()
    assert np.isnan(found["cumulant"].values[:, lost]).all()


@pytest.mark.parametrize("window", [1, 10])
def test_errors_of_cumulants_cover(window):
    rng = np.random.default_rng(3)
    exact = bernoulli(SHARE) / float(window) ** np.arange(4)
    hits = np.zeros(4)
    for _ in range(200):
        steps = np.where(rng.random(2000) < SHARE, -np.log(SHARE), -np.log(1 - SHARE))
        found, error = cumulants(steps.reshape(-1, window).mean(axis=1))
        hits += abs(found - exact) <= 2 * error
    assert (hits >= 0.9 * 200).all()
    assert (hits <= 0.99 * 200).all()


@pytest.mark.parametrize(("window", "count"), [(1, 200), (10, 200)])
def test_errors_of_high_cumulants_cover_the_tails_that_few_windows_meet(window, count):
    """Growth that is distributed exponentially: what matters most to orders 3 and 4 is seldom met."""
    rng = np.random.default_rng(4)
    exact = np.array([1.0, 1.0, 2.0, 6.0]) / float(window) ** np.arange(4)
    hits = np.zeros(4)
    for _ in range(200):
        found, error = cumulants(rng.exponential(1.0, (count, window)).mean(axis=1))
        hits += abs(found - exact) <= 2 * error
    assert (hits >= 0.88 * 200).all()


@pytest.mark.parametrize("window", [1, 10, 100])
def test_errors_of_densities_cover(window):
    """Windows of the skew tent map have a binomial distribution, on places that bins of any width may hold."""
    rng = np.random.default_rng(6)
    logs = -np.log([1 - SHARE, SHARE])
    numbers = np.arange(window + 1)
    exact = binom.pmf(numbers, window, SHARE)
    places = logs[0] + (logs[1] - logs[0]) * numbers / window
    hits = []
    for _ in range(60):
        steps = logs[(rng.random(4000) < SHARE).astype(int)]
        found, error, centre = density(steps.reshape(-1, window).mean(axis=1), 64)
        width = centre[1] - centre[0]
        bins = np.floor((places - centre[0]) / width + 0.5 + 1e-8).astype(int)
        inside = (bins >= 0) & (bins <= 64)
        truth = np.bincount(np.minimum(bins[inside], 63), exact[inside], minlength=64) / width
        hits.append((abs(found - truth) <= 2 * error)[truth > 0].mean())
    assert np.mean(hits) >= 0.95


@pytest.mark.parametrize("factor", [-0.5, 0.0, 0.9])
def test_errors_of_densities_cover_where_windows_are_correlated(factor):
    rng = np.random.default_rng(7)
    hits = []
    for _ in range(60):
        values = lfilter([1], [1, -factor], rng.normal(size=2400))[400:] * np.sqrt(1 - factor**2)
        found, error, centre = density(values, 40)
        edges = np.append(centre, 2 * centre[-1] - centre[-2]) - (centre[1] - centre[0]) / 2
        hits.append(abs(found - np.diff(norm.cdf(edges)) / np.diff(edges)) <= 2 * error)
    assert 0.93 <= np.mean(hits) <= 0.99
    assert np.mean(hits, axis=0).min() >= 0.8


@pytest.mark.parametrize("factor", [-0.5, 0.0, 0.9])
def test_errors_of_correlation_times_cover(factor):
    """An autoregression of first order has the correlation time (1 + factor)/(1 - factor)."""
    rng = np.random.default_rng(5)
    found = [correlation_time(lfilter([1], [1, -factor], rng.normal(size=4000))[400:]) for _ in range(200)]
    times, errors = np.array(found).T
    share = np.mean(abs(times - (1 + factor) / (1 - factor)) <= 2 * errors)
    assert 0.9 <= share <= 0.99


# What is refused, and what is still free.


def test_windows_that_do_not_fit(skew_tent):
    with pytest.raises(cd.SettingsError, match="windows holds 300, but a record of 1000 holds fewer than 4 of them"):
        cd.finite_time_exponents(skew_tent, periods=1000, windows=[1, 300])
    with pytest.raises(cd.SettingsError, match="expected whole forcing periods"):
        cd.finite_time_exponents(skew_tent, periods=1000, windows=[1.5])
    with pytest.raises(cd.SettingsError, match="windows holds 1, but a record of 3 holds fewer than 4 of them"):
        cd.finite_time_exponents(cd.build("impact-oscillator"), periods=3)


def test_a_plane_of_states_that_there_are(pendulum):
    with pytest.raises(cd.SettingsError, match="unknown state; did you mean 'q'"):
        cd.regularity(pendulum, periods=100, plane=["p", "qq"])


def test_without_forcing_a_section_is_asked_for():
    for function in (cd.zero_one_test, cd.regularity):
        with pytest.raises(cd.SettingsError, match="has no forcing period, and so no strobe; name a section"):
            function(cd.build("lorenz"), duration=10.0)


def test_a_parameter_may_be_called_as_what_no_sweep_holds():
    """K of the 0-1 test is ``k`` in archives, and so is the stiffness of many a contact."""
    system = cd.HybridSystem(
        name="spring", states="x v", parameters={"k": 1.0}, modes={"on": {"x": "v", "v": "-k*x - v"}}, period="1",
        initial={"x": 1.0},
    )  # fmt: skip
    assert cd.bifurcation_diagram(system, {"k": [1.0, 2.0]}, periods=4, transient=4).sizes["k"] == 2
