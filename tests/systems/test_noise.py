"""Noise at events: published numbers, known exponents and means, no noise to the bit, the same bits in any order."""

import json
import math
from functools import partial
from typing import Any

import numpy as np
import pytest
import scipy.stats
from scipy.special import digamma
from support.short_calls import short_calls

import chaosdrill as cd
from chaosdrill.analysis.registry import FUNCTIONS

IMPACTS = cd.build("impact-oscillator")
NOISY = IMPACTS.with_noise({"e": cd.Uniform(0.7, 0.9)}, at="impact", seed=1)
E = 1 / 0.2 * (0.9 * math.log(0.9) - 0.7 * math.log(0.7)) - 1
"""Mean logarithm of a restitution between .7 and .9, by integration."""


def forced(**rates: Any) -> cd.HybridSystem:
    return cd.HybridSystem(states="x", parameters={"e": 1.0, "e_low": 0.0}, modes={"on": rates}, period="1")


def ball(noise: Any, seed: int = 0) -> cd.HybridSystem:
    """A ball on a floor that gives it a speed of 1 at each rebound: the speeds obey v' = e v + 1."""
    plain = cd.HybridSystem(
        name="kicked ball",
        states="x v",
        parameters={"e": 0.8},
        modes={"flight": {"x": "v", "v": -1}},
        quadratures={"height": "x"},
        transitions=[cd.Transition("impact", "flight", "flight", "x", -1, reset={"v": "1 - e*v"})],
        initial={"x": 1.0},
    )
    return plain.with_noise({"e": noise}, at="impact", seed=seed)


def splitmix(seed: int, index: int) -> int:
    """Output of the generator in whole numbers of any length (Vigna, https://prng.di.unimi.it/splitmix64.c)."""
    z = (seed + (index + 1) * 0x9E3779B97F4A7C15) % 2**64
    z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) % 2**64
    z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) % 2**64
    return z ^ (z >> 31)


def uniform(seed: int, index: int) -> float:
    return ((splitmix(seed, index) >> 12) + 0.5) * 2.0**-52


def draws(distribution: Any, count: int, seed: int = 0) -> np.ndarray:
    """Values that a parameter has, one an iterate."""
    system = cd.Map("x", {"p": 1.0}, {"x": "p"}).with_noise({"p": distribution}, seed=seed)
    return cd.poincare_section(system, periods=count, transient=2)["section"].sel(state="x").values


def test_uniform_numbers_are_the_published_ones():
    # SplitMix64 with seed 1234567: https://rosettacode.org/wiki/Pseudo-random_numbers/Splitmix64
    published = (
        6457827717110365317,
        3203168211198807973,
        9817491932198370423,
        4593380528125082431,
        16408922859458223821,
    )
    assert tuple(splitmix(1234567, index) for index in range(5)) == published
    found = cd.trajectory(ball(cd.Uniform(0.7, 0.9), 1234567), at="impact", periods=5).cd.events
    assert found["e_draw_after"].tolist() == [uniform(1234567, index) for index in range(5)]


@pytest.mark.parametrize(
    ("distribution", "exact"),
    [
        (cd.Uniform(-1, 3), scipy.stats.uniform(-1, 4)),
        (cd.Normal(2, 0.5), scipy.stats.norm(2, 0.5)),
        (cd.LogNormal(3, 0.4), scipy.stats.lognorm(0.4, scale=3)),
        (cd.Exponential(0.7), scipy.stats.expon(scale=0.7)),
    ],
    ids=lambda one: getattr(one, "title", ""),
)
def test_draws_have_their_distribution_and_no_memory(distribution, exact):
    values = draws(distribution, 4000)
    assert scipy.stats.kstest(values, exact.cdf).pvalue > 1e-3
    uniform = exact.cdf(values) - 0.5
    for lag in (1, 2, 7):
        assert abs(12 * np.mean(uniform[lag:] * uniform[:-lag])) < 4 / math.sqrt(len(values))


def test_choices_are_exact_and_as_likely_as_their_weights():
    values = draws(cd.Choice([0.1, 0.7, -1.3], [1, 2, 5]), 4000)
    counts = [np.count_nonzero(values == one) for one in (0.1, 0.7, -1.3)]
    assert sum(counts) == len(values)
    assert scipy.stats.chisquare(counts, np.array([1, 2, 5]) / 8 * len(values)).pvalue > 1e-3


def test_exponents_of_products_of_gaussian_matrices():
    """(ln 2 + digamma((n - i + 1)/2))/2, Newman 1986, Commun. Math. Phys. 103, 121; and the errors cover them."""
    exact = (math.log(2) + digamma([1, 0.5])) / 2
    plain = cd.Map("x y", {"a": 1, "b": 0, "c": 0, "d": 1}, ["a*x + b*y", "c*x + d*y"])
    products = plain.with_noise(dict.fromkeys("abcd", cd.Normal(0, 1)))
    spectrum = cd.lyapunov_spectrum(products, periods=20_000, transient=10)
    assert spectrum["lyapunov_exponent"].values == pytest.approx(exact, abs=3 * spectrum["lyapunov_error"].values.max())
    many = cd.bifurcation_diagram(
        products, {"noise_seed": np.arange(200.0)}, transient=10, periods=256, max_period=16, max_extension=0
    )
    off = np.abs(many["lyapunov_exponent"] - exact) / many["lyapunov_error"]
    held = (off < 1.96).mean(("noise_seed", "seed")).values
    assert (held > 0.88).all()
    assert (held < 0.99).all()


def test_ball_with_random_restitution_has_the_mean_and_the_exponents_of_the_closed_form():
    """A flight lasts 2 v on average, v = 1/(1 - <e>); exponents are 0 and <ln e> over that time."""
    flight = 2 / (1 - 0.8)
    system = ball(cd.Uniform(0.7, 0.9), 7)
    spectrum = cd.lyapunov_spectrum(system, at="impact", periods=4000, transient=100)
    value, error = spectrum["lyapunov_exponent"].values, spectrum["lyapunov_error"].values
    assert abs(value[0]) < 1e-6
    assert abs(value[1] - E / flight) < 3 * error[1] < 0.05 * abs(E / flight)
    assert spectrum.cd.outcome == "contracting"
    section = cd.poincare_section(system, at="impact", periods=4000, transient=100)
    speeds = -section["section"].sel(state="v").values
    # v' = e v + 1 is a sum whose correlation decays by <e> a rebound
    spread = speeds.std() * math.sqrt((1 + 0.8) / (1 - 0.8) / len(speeds))
    assert abs(float(section["return_time"]) - flight) < 3 * 2 * spread
    assert int(section["period"]) == 0
    # of the stationary speeds <v^2> (1 - <e^2>) = 2 <e> <v> + 1
    square = (2 * 0.8 * flight / 2 + 1) / (1 - (0.64 + 0.2**2 / 12))
    assert np.mean(speeds**2) == pytest.approx(square, rel=0.02)


def test_a_ball_with_random_restitution_comes_to_rest_when_the_closed_form_says():
    """After sqrt(2)(1 + 2 (e_1 + e_1 e_2 + ...)), e_1 = <e> = 1/2: on average after 3 sqrt(2)."""
    falls = cd.build("bouncing-ball").with_parameters(amplitude=0.0).with_initial(x=1.0, v=0.0, mode="flight")
    system = falls.with_noise({"e": cd.Uniform(0.3, 0.7)}, at="impact")

    def exact(seed: int) -> float:
        e = [0.5, *(0.3 + 0.4 * uniform(seed, index) for index in range(60))]
        return math.sqrt(2) * (1 + 2 * math.fsum(np.cumprod(e)))

    ends = [cd.trajectory(system.with_parameters(noise_seed=seed), periods=2).cd.events for seed in range(20)]
    assert {one["kind"].iloc[-1] for one in ends} == {"rest"}
    times = [exact(seed) for seed in range(2000)]
    assert [one["time"].iloc[-1] for one in ends] == pytest.approx(times[:20], abs=1e-13)
    assert np.mean(times) == pytest.approx(3 * math.sqrt(2), abs=4 * np.std(times) / math.sqrt(2000))


def test_mean_height_of_the_ball_is_that_of_the_closed_form_and_errors_cover_it():
    """With v' = e v + 1 the mean of x over a flight is <v^3>/(3 <v>), by the moments of e and v up to the third."""
    e = [1, 0.8, 0.64 + 0.2**2 / 12, (0.9**4 - 0.7**4) / 4 / 0.2]
    v = [1, 1 / (1 - e[1])]
    v.append((2 * e[1] * v[1] + 1) / (1 - e[2]))
    v.append((3 * e[2] * v[2] + 3 * e[1] * v[1] + 1) / (1 - e[3]))
    seeds = {"noise_seed": np.arange(150.0)}
    lengths = {"at": "impact", "transient": 50, "periods": 400, "max_extension": 0, "max_period": 16, "exponents": 1}
    found = cd.bifurcation_diagram(ball(cd.Uniform(0.7, 0.9)), seeds, **lengths)
    height, error = found["height_rate"].values.ravel(), found["height_rate_error"].values.ravel()
    exact = v[3] / (3 * v[1])
    assert abs(height.mean() - exact) < 4 * height.std() / math.sqrt(len(height)) < 0.02 * exact
    assert 0.88 < np.mean(np.abs(height - exact) < 1.96 * error) < 0.99


def test_a_force_drawn_once_a_period_has_the_variance_of_the_closed_form():
    plain = cd.HybridSystem(
        name="drift", states="x", time="t", parameters={"k": 0.0}, period=1, modes={"one": {"x": "k - x"}}
    )
    noisy = plain.with_noise({"k": cd.Normal(3, 0.5)}, at="period", seed=4)
    found = cd.poincare_section(noisy, periods=8000, transient=30)
    x = found["section"].sel(state="x").values
    before, after, rest = (1 - math.exp(-0.25)) * math.exp(-0.75), 1 - math.exp(-0.75), math.exp(-1)
    variance = 0.25 * (before**2 + after**2 + 2 * rest * before * after) / (1 - rest**2)
    assert x.mean() == pytest.approx(3, abs=4 * 0.5 / math.sqrt(len(x)))
    assert x.var() == pytest.approx(variance, rel=0.08)
    spectrum = cd.lyapunov_spectrum(noisy, periods=300)
    assert spectrum["lyapunov_exponent"].values == pytest.approx([-1], abs=1e-10)
    assert spectrum.cd.outcome == "contracting"


@pytest.mark.parametrize("method", ["taylor", "dop853", "radau", "rk4"])
def test_without_variance_a_run_is_that_without_noise_to_the_bit(method):
    still = IMPACTS.with_noise({"e": cd.Uniform(0.8, 0.8)}, at="impact")
    lengths = {"periods": 60, "transient": 10, "method": method, "tolerance": 1e-8}
    one, other = (cd.lyapunov_spectrum(system, **lengths) for system in (IMPACTS, still))
    for name in ("lyapunov_exponent", "lyapunov_history", "event_count"):
        assert np.array_equal(one[name], other[name])
    one, other = (cd.trajectory(system, samples=20, **lengths) for system in (IMPACTS, still))
    assert np.array_equal(one["states"], other["states"].sel(state=["x", "v"]))
    assert np.array_equal(one["event_time"], other["event_time"])


@pytest.mark.parametrize("omega", [2.5, 2.8])
def test_tangents_mind_no_draws_without_variance(omega):
    """The speed, at rest first, has its size from the rates, in which the damping is drawn; at 2.8 there is a cycle."""
    plain = IMPACTS.with_initial(v=0.0).with_parameters(omega=omega)
    still = plain.with_noise({"zeta": cd.Uniform(0.05, 0.05)}, at="impact")
    lengths = {"periods": 60, "transient": 200}
    one, other = (cd.lyapunov_spectrum(system, **lengths) for system in (plain, still))
    assert np.array_equal(one["lyapunov_history"], other["lyapunov_history"])
    one, other = (cd.poincare_section(system, **lengths) for system in (plain, still))
    assert (one["period"] > 0) == (omega == 2.8)
    for name in ("period", "multiplier_real", "multiplier_imag"):
        assert np.array_equal(one[name], other[name], equal_nan=True)


@pytest.mark.parametrize("at", ["stick", "impact", "period"])
def test_a_drill_in_rock_of_one_strength_is_the_drill_to_the_bit(at):
    """Its chaos would double a rounding error every 30 periods."""
    drill = cd.drill(friction="stribeck", contact="hunt-crossley", eta=0.448)
    still = drill.with_noise({"mu": cd.Normal(0.6, 0.0)}, at=at)
    one, other = (cd.lyapunov_spectrum(system, periods=150, transient=20) for system in (drill, still))
    for name in ("lyapunov_exponent", "lyapunov_history", "progression_rate"):
        assert np.array_equal(one[name], other[name])


def test_a_spread_that_becomes_zero_in_a_reset_is_no_noise_to_the_bit():
    still = NOISY.with_parameters(e_low=0.8, e_high=0.8)
    one, other = (cd.lyapunov_spectrum(system, periods=60, transient=10) for system in (IMPACTS, still))
    assert np.array_equal(one["lyapunov_history"], other["lyapunov_history"])


def test_without_variance_a_sweep_is_that_without_noise_to_the_bit():
    still = IMPACTS.with_noise({"e": cd.Uniform(0.8, 0.8)}, at="impact")
    sweep = {"omega": np.linspace(2.4, 2.8, 11)}
    given = {"transient": 20, "periods": 40, "max_period": 16, "max_extension": 4}
    one, other = (cd.bifurcation_diagram(system, sweep, **given) for system in (IMPACTS, still))
    assert np.array_equal(one["section"], other["section"].sel(state=["x", "v"]))
    for name in ("lyapunov_exponent", "outcome", "period"):
        assert np.array_equal(one[name], other[name])
    assert len(np.unique(one["outcome"])) > 1


def test_a_point_has_the_same_bits_whatever_runs_beside_it(tmp_path):
    values = np.linspace(2.0, 3.0, 21)
    given = {"transient": 20, "periods": 40, "max_period": 16, "max_extension": 2}
    whole = cd.bifurcation_diagram(NOISY, {"omega": values}, **given)
    shared = cd.bifurcation_diagram(NOISY, {"omega": values}, **given, workers=2, store=tmp_path / "parts")
    backward = cd.bifurcation_diagram(NOISY, {"omega": values[[15, 3]]}, **given)
    again = cd.bifurcation_diagram(NOISY, {"omega": values}, **given, store=tmp_path / "parts")
    for name in ("section", "lyapunov_exponent", "outcome"):
        for other in (shared, again):
            assert np.array_equal(whole[name], other[name], equal_nan=True)
        assert np.array_equal(whole[name].values[[15, 3]], backward[name].values, equal_nan=True)
    assert {"contracting", "chaotic", "undecided", "transient"} >= set(np.unique(whole.cd.outcome).tolist())
    assert (whole["period"] == 0).all()


def test_a_run_goes_on_with_the_next_draw():
    """A run in two pieces is the run in one, since what draws is part of the state."""
    whole = cd.trajectory(NOISY, periods=40, samples=1)
    first = cd.trajectory(NOISY, periods=20, samples=1)
    second = cd.trajectory(NOISY.with_initial(first["states"][-1]), periods=20, samples=1)
    assert second["states"].values[-1] == pytest.approx(whole["states"].values[-1], rel=1e-9)
    assert int(second["states"].sel(state="e_count")[-1]) == whole.sizes["event"]


def test_tangents_across_draws_are_differences_of_runs_with_the_same_draws():
    """A stiffness and a restitution are drawn at impacts; the field jumps there with them."""
    plain = cd.HybridSystem(
        name="drawn spring",
        states="x v",
        time="t",
        parameters={"k": 1.0, "e": 0.8},
        modes={"free": {"x": "v", "v": "-k*x - 0.1*v + cos(2.5*t)"}},
        transitions=[cd.Transition("impact", "free", "free", "x - 0.3", 1, reset={"v": "-e*v"})],
        period="2*pi/2.5",
    )
    system = plain.with_noise({"k": cd.LogNormal(1, 0.3), "e": cd.Uniform(0.6, 0.9)}, at="impact", seed=3)
    unit = np.eye(6)[:2]
    start = np.array([0.1, 0.4])
    run = {"periods": 6, "samples": 1, "tolerance": 1e-13}

    def end(state):
        found = cd.trajectory(system.with_initial(x=state[0], v=state[1]), **run)
        return found["states"].values[-1, :2], found["event_kind"].values

    matrix = cd.trajectory(system.with_initial(x=0.1, v=0.4), tangents=unit, **run)["final_tangent"].values
    assert len(end(start)[1]) >= 3
    assert (matrix[:, 2:] == 0).all()
    step = 1e-6
    for j in range(2):
        ahead, back = (end(start + way * step * np.eye(2)[j]) for way in (1, -1))
        assert (ahead[0] - back[0]) / (2 * step) == pytest.approx(matrix[j, :2], rel=1e-6, abs=1e-6)


def test_the_system_comes_back_from_a_dataset():
    found = cd.lyapunov_spectrum(NOISY, periods=20)
    again = cd.system(found)
    assert again.noise == NOISY.noise
    assert again.free == 2
    assert list(found["exponent"].values) == [1, 2]
    assert np.array_equal(cd.lyapunov_spectrum(again, periods=20)["lyapunov_history"], found["lyapunov_history"])


def test_other_seeds_give_other_runs():
    ends = [cd.trajectory(NOISY.with_parameters(noise_seed=seed), periods=10)["states"].values[-1] for seed in (1, 2)]
    assert not np.array_equal(*ends)
    reseeded = IMPACTS.with_noise({"e": cd.Uniform(0.7, 0.9)}, at="impact", seed=2)
    assert np.array_equal(cd.trajectory(reseeded, periods=10)["states"].values[-1], ends[1])


def test_the_order_in_which_distributions_are_named_draws_the_same_numbers():
    noise = {"p": cd.Normal(1, 0.1), "q": cd.Uniform(0, 1)}
    plain = cd.Map("x y", {"p": 1.0, "q": 1.0}, {"x": "p", "y": "q"})
    one, other = (
        cd.poincare_section(plain.with_noise({name: noise[name] for name in names}), periods=3, transient=2)["section"]
        for names in ("pq", "qp")
    )
    assert np.array_equal(one.sel(state=["x", "y"]), other.sel(state=["x", "y"]))


REASONS = {
    **dict.fromkeys(("periodic_orbit", "continue_orbit", "regularity", "manifolds"), "repeats"),
    "basin_measures": "basins gives the shares",
    "edge_states": "by chance",
    "equilibria": "move every equilibrium",
    "zero_one_test": "noise itself",
    "dimensions": "fill the range of the noise",
    "work_precision": "has no random numbers",
}
SHORT = short_calls(("x", [-0.3, 0.0]), ("v", [0.0, 0.3]), ("omega", [2.4, 2.6]), ("zeta", [0.04, 0.06]))


@pytest.mark.parametrize("name", FUNCTIONS)
def test_an_analysis_takes_noise_or_refuses_it_with_the_reason(name):
    call = partial(getattr(cd, name), NOISY, **SHORT.get(name, {}))
    if name in REASONS:
        told = f"draws 'e' anew, which this analysis does not take: .*{REASONS[name]}"
        with pytest.raises(cd.SettingsError, match=told):
            call()
    else:
        assert "e" in json.loads(call().attrs["definition"])["noise"]


@pytest.mark.parametrize(
    ("given", "told"),
    [
        (lambda: IMPACTS.with_noise({}, at="impact"), "give distributions by parameter"),
        (lambda: IMPACTS.with_noise({"e": 0.7}, at="impact"), "e is 0.7; give one of Uniform, Normal"),
        (lambda: IMPACTS.with_noise({"f": cd.Uniform(0, 1)}, at="impact"), "unknown parameter 'f'"),
        (
            lambda: IMPACTS.with_noise({"e": cd.Uniform(0, 1)}, at="hit"),
            "at is 'hit' for 'e'; it has 'impact', 'period'",
        ),
        (lambda: IMPACTS.with_noise({"e": cd.Uniform(0, 1)}), "give the name or kind of an event"),
        (lambda: IMPACTS.with_noise({"e": cd.Uniform(0, 1.2)}, at="impact"), "at most 1, received 1.2"),
        (lambda: IMPACTS.with_noise({"e": cd.Normal(0.8, 0.1)}, at="impact"), "cannot have normal values"),
        (lambda: IMPACTS.with_noise({"omega": cd.Uniform(1, 2)}, at="impact"), "the period depends on 'omega'"),
        (lambda: IMPACTS.with_noise({"e": cd.Uniform(0, 1)}, at="impact", seed=-1), "seed is -1"),
        (lambda: NOISY.with_noise({"zeta": cd.Uniform(0, 1)}, at="impact"), "noise already"),
        (lambda: forced(x="e + e_low").with_noise({"e": cd.Uniform(0, 1)}, at="period"), "already, .*rename it"),
        (lambda: forced(x=lambda t, x, p: 0.0).with_noise({"e": cd.Uniform(0, 1)}, at="period"), "Python functions"),
        (lambda: NOISY.with_parameters(e_high=1.1), "parameter 'e_high': .* at most 1, received 1.1"),
        (lambda: NOISY.with_parameters(noise_seed=1e300), "the seed of the noise must be a whole number, at least 0"),
        (lambda: NOISY.with_parameters(noise_seed=1.5), "must be a whole number, at least 0 .* received 1.5"),
        (
            lambda: cd.bifurcation_diagram(NOISY, {"noise_seed": [0, 0.5]}, transient=1, periods=2),
            "must be a whole number",
        ),
        (lambda: ball(cd.Normal(0.8, 0.1)).with_parameters(e_deviation=-0.1), "at least 0, received -0.1"),
        (lambda: ball(cd.LogNormal(0.8, 0.1)).with_parameters(e_median=0), "greater than 0, received 0"),
        (lambda: ball(cd.LogNormal(0.8, 0.1)).with_parameters(e_sigma=-0.1), "at least 0, received -0.1"),
        (lambda: ball(cd.Exponential(0.8)).with_parameters(e_mean=-0.8), "at least 0, received -0.8"),
        (lambda: ball(cd.Uniform(0.5, 0.4)), "low must not be above high"),
        (lambda: cd.Choice([]), "values is"),
        (lambda: cd.Choice([1, 2], [0, 0]), "weights is"),
        (lambda: cd.LogNormal(0, 1), "median: it must be greater than 0, received 0"),
        (lambda: cd.lyapunov_spectrum(NOISY, periods=10, exponents=3), "the system has 2 states"),
    ],
)
def test_wrong_noise_is_told_what_to_do(given, told):
    with pytest.raises(cd.SettingsError, match=told):
        given()


def test_analyses_that_take_noise_agree_with_the_closed_form():
    """Of x' = p x with p of two values the exponent is the mean logarithm, over windows as in charts and on lines."""
    plain = cd.Map("x y", {"p": 1.0, "c": 0.1}, {"x": "p*x", "y": "c*y"})
    system = plain.with_noise({"p": cd.Choice([0.3, 0.9])}, seed=2)
    exact = (math.log(0.3) + math.log(0.9)) / 2
    windows = cd.finite_time_exponents(system, periods=4000, windows=[1, 10], exponents=2)
    assert windows["lyapunov_exponent"].values == pytest.approx([exact, math.log(0.1)], abs=0.03)
    # of one draw the values are two, with this variance; of ten it is a tenth of it
    variance = (math.log(0.3) - math.log(0.9)) ** 2 / 4
    spread = windows["cumulant"].sel(exponent=1).values[:, 1]
    # with two values the variance is off by the square of what their shares are off, of which 4 errors are allowed
    assert spread[0] == pytest.approx(variance, rel=16 / 4000)
    assert spread[1] == pytest.approx(variance / 10, rel=0.1)
    lengths = {"transient": 10, "periods": 2000, "max_extension": 0, "max_period": 16}
    sweep = {"c": [0.1, 0.2]}
    lines = cd.bifurcation_diagram(system, sweep, follow="both", exponents=1, **lengths)
    chart = cd.parameter_chart(system, {**sweep, "noise_seed": [2, 3]}, exponents=2, **lengths)
    assert lines["lyapunov_exponent"].sel(c=0.1).values == pytest.approx(np.full((2, 1), exact), abs=0.06)
    found = chart["lyapunov_exponent"].squeeze("seed")
    assert found.sel(c=0.2, exponent=1).values == pytest.approx(exact, abs=0.06)
    assert found.sel(c=0.1, exponent=2).values == pytest.approx(math.log(0.1), abs=1e-9)
    runs = cd.trajectory(system, initial=[[1.0, 0.0, 0.5, 0.0], [2.0, 0.0, 0.5, 0.0]], periods=20)
    states = runs["states"].sel(state="x").values
    assert np.array_equal(2 * states[0], states[1])


KICK = cd.Map(
    "x k", {"u": 0.0, "c": 0.0}, ["Piecewise(x, k < 1, 0.3*x - 1 + 0.2*u, x + u < c, 0.3*x + 1 + 0.2*u)", "1"],
    initial={"x": 0.25, "k": 0.0},
).with_noise({"u": cd.Uniform(-0.5, 0.5)}, seed=3)  # fmt: skip
"""The first draw decides between two attractors, near 1.4 and -1.4: the upper one with probability 1/2 + x - c."""


def test_each_start_of_basins_has_noise_of_its_own(tmp_path):
    """Of starts in one place the shares are probabilities, and errors cover them."""
    given = {"initial": {"x": [0.25] * 300 + [1.0]}, "transient": 20, "periods": 40}
    found = cd.basins(KICK, **given)
    assert found.sizes["attractor_number"] == 2
    assert (found.cd.outcome == "contracting").all()
    share, error = found["fraction"].values[0], found["fraction_error"].values[0]
    assert abs(share - 0.75) < 3 * error < 0.09
    assert found["attractor_state"].values[:, 0] == pytest.approx([1 / 0.7, -1 / 0.7], abs=0.15)
    for other in (cd.basins(KICK, **given, workers=2, store=tmp_path), cd.basins(KICK, **given, store=tmp_path)):
        for name in ("attractor", "outcome", "attractor_state", "attractor_exponent"):
            assert np.array_equal(found[name], other[name])
    # a start draws as a run with the seed that is larger by its place
    where = np.sign([
        float(cd.poincare_section(KICK.with_parameters(noise_seed=3 + k), periods=1, transient=20)["section"][0, 0])
        for k in range(5)
    ])  # fmt: skip
    np.testing.assert_array_equal(found["attractor"][:5], np.where(where > 0, 1, 2))
    plane = cd.basins(KICK, {"x": [0.25], "k": [0.0, -1.0]}, transient=20, periods=40)
    reached = plane["attractor_state"].values[np.ravel(plane["attractor"]) - 1, 0]
    np.testing.assert_array_equal(np.sign(reached), where[:2])


def test_shares_under_noise_along_a_parameter():
    values = np.linspace(-0.4, 0.4, 5)
    given = {"initial": {"x": [0.0] * 300}, "transient": 20, "periods": 40}
    found = cd.attractors(KICK, {"c": values}, **given)
    assert found.sizes["attractor"] == 2
    upper = found["attractor_state"].sel(state="x").max("c").values > 0
    share = found["fraction"].values[:, upper][:, 0]
    assert (np.abs(share - (0.5 - values)) < 3 * found["fraction_error"].values[:, upper][:, 0]).all()
    assert (found["end_below"] == 0).all()
    assert (found["end_above"] == 0).all()
    backward = cd.attractors(KICK, {"c": values[::-1]}, **given, workers=2)
    for name in ("fraction", "reached", "attractor_state"):
        assert np.array_equal(found[name].sel(c=values), backward[name].sel(c=values))


def test_an_open_map_with_random_slopes_loses_what_the_mean_hole_takes():
    """Of evenly spread points 2/s stay; each start draws s itself, so that the rate is -ln <2/s>, not -<ln(2/s)>.

    Runs that stay long have drawn s as often as 2/s says, which weights the mean of the exponent ln s.
    """
    tent = cd.Map(
        "x", {"s": 2.5}, ["Piecewise(s*x, x < 1/2, s*(1 - x))"], initial={"x": 0.3}, bounds={"x": (0, 1)}
    ).with_noise({"s": cd.Choice([2.5, 4])}, seed=1)  # fmt: skip
    starts = {"count": 10_000, "seed": 1, "x": (0, 1)}
    found = cd.transient_chaos(tent, periods=60, random=starts)
    exact, frozen = -math.log(0.65), (math.log(1.25) + math.log(2)) / 2
    assert abs(found["escape_rate"] - exact) < 3 * found["escape_rate_error"] < abs(frozen - exact)
    value, error = found["lyapunov_exponent"].values, found["lyapunov_error"].values
    assert value.shape == (1,)
    assert abs(value[0] - (0.8 * math.log(2.5) + 0.5 * math.log(4)) / 1.3) < 3 * error[0] < 0.15
    again = cd.transient_chaos(tent, periods=60, random={**starts, "count": 50})
    assert np.array_equal(again["lifetime"], found["lifetime"][:50])


def test_covariant_vectors_are_mapped_onto_each_other_by_the_matrices_drawn():
    plain = cd.Map("x y", {"p": 1.0, "q": 1.0}, {"x": "p*x + q*y", "y": "x/2"})
    system = plain.with_noise({"p": cd.Normal(1.0, 0.4), "q": cd.Choice([-1.0, 1.0])}, seed=5)
    found = cd.covariant_vectors(system, periods=60, transient=20)
    drawn = found["states"].sel(state=["p_draw", "q_draw"]).values
    vectors = found["vector"].sel(state=["x", "y"]).values
    assert (found["vector"].sel(state=["p_draw", "p_count"]) == 0).all()
    for k in range(len(vectors) - 1):
        p, q = 1.0 + 0.4 * drawn[k, 0], drawn[k, 1]
        image = np.array([[p, q], [0.5, 0.0]]) @ vectors[k]
        growth = np.log(np.linalg.norm(image, axis=0))
        assert np.abs(np.sum(image / np.exp(growth) * vectors[k + 1], axis=0)) == pytest.approx([1, 1], abs=1e-9)
        assert found["local_growth"].values[k] == pytest.approx(growth, abs=1e-9)


def test_lives_up_to_a_comparison_have_noise_of_their_own():
    """The marked system had lost its noise: all starts one realisation, and exponents of the states that draw."""
    start = {"x": 1.0, "v": 0.0}

    def lives(starts: int, seed: int) -> Any:
        noisy = ball(cd.Uniform(0.7, 0.9), seed)
        return cd.transient_chaos(noisy, duration=60.0, initial=[start] * starts, until="x > 9")

    together = lives(3, 0)
    assert together.sizes["exponent"] == 2
    assert len(np.unique(together["lifetime"])) == 3
    np.testing.assert_array_equal(together["lifetime"], [lives(1, seed)["lifetime"].item() for seed in range(3)])
