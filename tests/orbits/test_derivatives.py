"""Derivatives of orbits by parameters against closed forms, and against differences between orbits near by."""

from math import cos, pi, sqrt

import numpy as np
import pytest
from support import closed_derivatives as closed
from support.pages import read

import chaosdrill as cd
from chaosdrill.analysis.orbit_datasets import orbit_rates
from chaosdrill.engine.numerics import Numerics
from chaosdrill.orbits.problem import CONVERGED, Problem
from chaosdrill.orbits.verification import describe

WELL = 1e-8
"""What an error may be at most, relative to the derivative."""


def holds(name, ds, wanted, index=()):
    """Derivatives by all parameters are as told, within their errors, and these are small."""
    found, error = (ds[f"{name}_derivative{end}"][index].values for end in ("", "_error"))
    told = np.array([float(wanted[parameter]) for parameter in ds["parameter"].values])
    assert (np.abs(found - told) <= error).all()
    assert (error <= WELL * np.maximum(np.abs(told), np.abs(told).max())).all()


def holds_for_multipliers(ds, form, by):
    """Derivatives of both multipliers of two are those of the roots of mu^2 - trace mu + determinant."""
    values = ds["multiplier_real"].values + 1j * ds["multiplier_imag"].values
    for parameter in ds["parameter"].values:
        one = ds.sel(parameter=parameter)
        trace, determinant = (float(by[name][parameter]) for name in ("trace", "determinant"))
        told = (values * trace - determinant) / (2 * values - float(form["trace"]))
        for part, wanted in (("real", told.real), ("imag", told.imag)):
            error = one[f"multiplier_{part}_derivative_error"].values
            assert (np.abs(one[f"multiplier_{part}_derivative"].values - wanted) <= error).all()
            assert (error <= WELL * max(1.0, np.abs(told).max())).all()


@pytest.fixture(scope="module")
def oscillator():
    """The impact oscillator with the mean of its position."""
    return cd.HybridSystem(
        name="impact-oscillator with its mean position", states="x v",
        parameters={"wall": 0.3, "zeta": 0.05, "amplitude": 1.0, "omega": 1.9, "e": 0.8},
        modes={"free": {"x": "v", "v": "-x - 2*zeta*v + amplitude*cos(omega*t)"}},
        transitions=[cd.Transition("impact", "free", "free", guard="x - wall", direction=1, reset={"v": "-e*v"})],
        period="2*pi/omega", quadratures={"position": "x"}, initial={"v": 0.3},
    )  # fmt: skip


CASES = [
    {"wall": 0.3, "zeta": 0.05, "amplitude": 1.0, "omega": 1.9, "e": 0.8},
    {"wall": 0.5, "zeta": 0.05, "amplitude": 1.0, "omega": 1.8, "e": 0.8},
    {"wall": 0.2, "zeta": 0.15, "amplitude": 0.9, "omega": 2.1, "e": 0.6},
]


@pytest.mark.parametrize("values", CASES)
def test_of_the_impact_oscillator(oscillator, values):
    ds = cd.periodic_orbit(oscillator.with_parameters(values), derivatives=True, transient=100)
    form, by = closed.impact(**values), closed.by_parameters(closed.impact, values)
    assert float(ds["multiplier_real"].sum()) == pytest.approx(float(form["trace"]), abs=1e-10)
    np.testing.assert_array_equal(ds["parameter_value"], list(values.values()))
    holds("period_time", ds, by["period"])
    holds("event_time", ds, by["time"], 0)
    holds("position_rate", ds, by["mean"])
    holds_for_multipliers(ds, form, by)
    total = ds["lyapunov_exponent_derivative"].sum("multiplier")
    np.testing.assert_allclose(total, [float(by["exponents"][name]) for name in values], rtol=1e-9, atol=1e-10)


def ball_at_strobe(values, low):
    """Closed form of the bouncing ball's orbit: its state at phase 0, and the derivatives of that."""

    def state(amplitude, omega, e, gravity):
        when, period = closed.bounce(amplitude, omega, e, gravity, low)["time"], 2 * closed.pi / omega
        flown = period - when
        return {
            "x": amplitude * closed.sin(omega * when) + gravity * period / 2 * flown - gravity * flown**2 / 2,
            "v": gravity * (period / 2 - flown),
        }

    return state(**values), closed.by_parameters(state, values)


@pytest.mark.parametrize("low", [False, True])
def test_of_a_bouncing_ball_and_its_unstable_partner(low):
    values = {"amplitude": 0.9, "omega": 1.0, "e": 0.8, "gravity": 1.0}
    state, moved = ball_at_strobe(values, low)
    ball = cd.build("bouncing-ball", parameters=values).with_initial(x=float(state["x"]), v=float(state["v"]))
    ds = cd.periodic_orbit(ball, start="guess", derivatives=list(values))
    by = closed.by_parameters(lambda **p: closed.bounce(**p, low=low), values)
    assert bool(ds["stable"]) is not low
    for i, name in enumerate("xv"):
        holds("orbit_state", ds, moved[name], i)
    holds("event_time", ds, by["time"], 0)
    holds_for_multipliers(ds, closed.bounce(**values, low=low), by)


def test_errors_are_of_the_size_of_what_they_cover(oscillator):
    """All of them cover, and in the median they are at most some hundred times what a derivative is off by."""
    ratios = []
    for values in CASES:
        ds = cd.periodic_orbit(oscillator.with_parameters(values), derivatives=True, transient=100)
        by = closed.by_parameters(closed.impact, values)
        for name, told in (("event_time", "time"), ("position_rate", "mean"), ("period_time", "period")):
            found, error = (np.ravel(ds[f"{name}_derivative{end}"]) for end in ("", "_error"))
            off = np.abs(found - [float(by[told][parameter]) for parameter in values])
            assert (off <= error).all()
            ratios += (error / np.maximum(off, 1e-17)).tolist()
    assert np.median(ratios) < 300


def test_of_cycles_without_a_clock():
    values = {"belt": 0.2, "F_s": 1.0, "F_k": 0.5}
    ds = cd.periodic_orbit(cd.build("belt-stick-slip", parameters=values), derivatives=True, transient=50)
    holds("period_time", ds, closed.by_parameters(closed.belt, values)["period"])
    # one multiplier is 1 and one is 0, by structure and for all parameters
    for part in ("real", "imag"):
        assert not ds[f"multiplier_{part}_derivative"].any()
    assert np.isnan(ds["lyapunov_exponent_derivative"][1]).all()

    values = {"alpha": 0.3, "gamma": 0.15}
    ds = cd.periodic_orbit(cd.build("rimless-wheel", parameters=values), derivatives=True, transient=50)
    by = closed.by_parameters(closed.gait, values)
    holds("period_time", ds, by["period"])
    holds("event_time", ds, by["period"], 0)
    holds("orbit_state", ds, by["after"], 1)
    holds("multiplier_real", ds, by["multiplier"], 1)


@pytest.fixture(scope="module")
def ring():
    """A limit cycle without events: r' = r (m - r^2), angle' = w + b r^2, of radius sqrt(m)."""
    square, turn = "(x**2 + y**2)", "(w + b*(x**2 + y**2))"
    return cd.HybridSystem(
        name="ring", states="x y", parameters={"m": 0.3, "w": 1.2, "b": 0.7}, quadratures={"size": square},
        modes={"flow": {"x": f"x*(m - {square}) - y*{turn}", "y": f"y*(m - {square}) + x*{turn}"}},
        initial={"x": 0.5},
    )  # fmt: skip


def test_of_a_cycle_without_events(ring):
    ds = cd.periodic_orbit(ring, derivatives=True, transient=60)
    m, w, b = ring.parameters.values()
    period, turn = 2 * pi / (w + b * m), w + b * m
    times = {"m": -period * b / turn, "w": -period / turn, "b": -period * m / turn}
    holds("period_time", ds, times)
    holds("size_rate", ds, {"m": 1.0, "w": 0.0, "b": 0.0})
    multiplier = float(np.exp(-2 * m * period))
    holds("multiplier_real", ds, {k: -2 * multiplier * ((k == "m") * period + m * v) for k, v in times.items()}, 1)
    holds("lyapunov_exponent", ds, {"m": -2.0, "w": 0.0, "b": 0.0}, 1)
    # the radius follows its parameter
    x, moved = ds["orbit_state"].values, ds["orbit_state_derivative"].sel(parameter="m").values
    assert x @ moved / np.linalg.norm(x) == pytest.approx(1 / (2 * sqrt(m)), rel=1e-9)


def test_of_a_map():
    r = 3.3
    logistic = cd.Map("x", {"r": r}, {"x": "r*x*(1 - x)"}, initial={"x": 0.3})
    ds = cd.periodic_orbit(logistic, derivatives=True)
    fixed = cd.periodic_orbit(logistic.with_initial(x=1 - 1 / r), start="guess", derivatives=True)
    holds("orbit_state", fixed, {"r": 1 / r**2}, 0)
    holds("multiplier_real", fixed, {"r": -1.0}, 0)
    holds("lyapunov_exponent", fixed, {"r": 1 / (r - 2)}, 0)
    ds = cd.periodic_orbit(logistic, period=2, derivatives=True)
    holds("multiplier_real", ds, {"r": 2 - 2 * r}, 0)
    assert not ds["event_time_derivative"].any()


def test_no_derivative_depends_on_where_another_system_of_these_equations_began():
    """x = b/(1 - r), beyond the default bounds of the first start."""
    for b in (1.0, 1e12):
        line = cd.Map("x", {"r": 0.5, "b": b}, {"x": "r*x + b"}, initial={"x": b})
        holds("orbit_state", cd.periodic_orbit(line, derivatives=True), {"r": 4 * b, "b": 2}, 0)


def test_what_moves_the_drill(drill_period_one, drill):
    """Against differences between orbits at neighbouring parameters, of fourth order."""
    _, orbit, _ = drill_period_one
    names = ["b", "a", "eta", "mu", "r", "lam"]
    ds = cd.periodic_orbit(drill, transient=300, derivatives=[*names, "phi", "k"])
    start = Problem(drill, ()), orbit.starts[:, : len(drill.states)].copy()

    def told(name, value):
        problem = Problem(drill.with_parameters({name: value}), (), Numerics(tolerance=1e-14))
        code, found, shot, _ = problem.newton(type(orbit)(orbit.segments, 1, start[1], orbit.phase, orbit.durations))
        assert code == CONVERGED
        one = describe(problem, found, shot, np.zeros(1))
        rate = orbit_rates(problem.plain, [one], problem.numerics)["progression_rate"][1]
        return np.concatenate([rate, one.states[0], one.event_times, one.multipliers[:1].real])

    for name in names:
        value = drill.parameters[name]
        h = 2e-4 * value
        near, far = (told(name, value + s * h) - told(name, value - s * h) for s in (1, 2))
        wanted = (8 * near - far) / (12 * h)
        one = ds.sel(parameter=name)
        parts = ("progression_rate", "orbit_state", "event_time", "multiplier_real")
        found = np.concatenate([np.atleast_1d(one[f"{part}_derivative"].values) for part in parts])[: len(wanted)]
        np.testing.assert_allclose(found, wanted, rtol=1e-8, atol=1e-8 * np.abs(wanted).max(), err_msg=name)
        assert (one["progression_rate_derivative_error"] < 1e-8 * np.abs(one["progression_rate_derivative"])).all()
    # neither a shift of the phase nor what the mapped contact has no use for moves a mean
    still = ds["progression_rate_derivative"].sel(parameter=["phi", "k"])
    np.testing.assert_allclose(still, 0, atol=1e-12)


def test_along_a_branch_and_across_its_fold(oscillator):
    """Every point of both arms, to within their errors, which grow as the fold comes near."""
    values = {**CASES[1], "omega": 1.88}
    ds = cd.continue_orbit(
        oscillator.with_parameters(values), {"omega": (1.87, 1.90)}, transient=300, step=1e-3,
        derivatives=["omega", "e"],
    )  # fmt: skip
    assert "multiplier is +1" in " ".join(ds["special_text"].values)
    assert "singular, as at a fold" in ds.attrs["derivatives_message"]
    arms = set()
    for one in (ds.isel(point=i) for i in range(0, ds.sizes["point"], 5)):
        if np.isnan(one["period_time_derivative"]).any():
            continue
        here, trace = {**values, "omega": float(one["omega"])}, float(one["multiplier_real"].sum())
        fast = abs(float(closed.impact(**here)["trace"]) - trace) < 1e-4
        arms.add(fast)
        by = closed.by_parameters(lambda fast=fast, **p: closed.impact(**p, fast=fast), here)
        assert float(one["position_rate"]) == pytest.approx(float(closed.impact(**here, fast=fast)["mean"]), rel=1e-6)
        for parameter in ("omega", "e"):
            own = one.sel(parameter=parameter)
            wanted, found = float(by["mean"][parameter]), float(own["position_rate_derivative"])
            assert abs(found - wanted) <= float(own["position_rate_derivative_error"])
            wanted, found = float(by["trace"][parameter]), float(own["multiplier_real_derivative"].sum())
            assert abs(found - wanted) <= float(own["multiplier_real_derivative_error"].sum())
            assert found == pytest.approx(wanted, rel=1e-7)
    assert arms == {True, False}


def test_of_all_orbits_that_a_search_finds():
    logistic = cd.Map("x", {"r": 3.3}, {"x": "r*x*(1 - x)"}, initial={"x": 0.3})
    ds = cd.periodic_orbit(logistic, start="search", max_period=2, derivatives=["r"])
    for one in (ds.isel(orbit=i) for i in range(ds.sizes["orbit"])):
        wanted = 2 - 2 * 3.3 if one["period"] == 2 else -1.0 if one["orbit_state"] > 0.1 else 1.0
        assert float(one["multiplier_real_derivative"].squeeze()) == pytest.approx(wanted, rel=1e-9)


def test_where_there_are_none():
    """A family of orbits, a chaotic motion without an orbit, and Python functions, each with the reason."""
    spring = cd.HybridSystem(
        name="hard spring", states="x v", parameters={"k": 1.0}, initial={"x": 1.0},
        modes={"free": {"x": "v", "v": "-k*x - x**3"}},
    )  # fmt: skip
    ds = cd.periodic_orbit(spring, start="guess", derivatives=True)
    assert int(ds["outcome"]) == cd.Outcome.PERIODIC
    assert "one of a family" in ds.attrs["derivatives_message"]
    assert np.isnan(ds["period_time_derivative"]).all()

    def field(t, x, p):
        return x.v, -x.x - 2 * p.zeta * x.v + p.amplitude * cos(p.omega * t)

    values = CASES[0]
    own = cd.HybridSystem(
        name="own", states="x v", parameters=values, modes={"free": field}, period="2*pi/omega",
        transitions=[cd.Transition("impact", "free", "free", guard="x - wall", direction=1, reset={"v": "-e*v"})],
    )  # fmt: skip
    ds = cd.periodic_orbit(own, derivatives=True, transient=100, method="dop853")
    np.testing.assert_allclose(
        ds["event_time_derivative"][0], list(map(float, closed.by_parameters(closed.impact, values)["time"].values())),
        rtol=1e-6, atol=1e-9,
    )  # fmt: skip
    assert "no second derivatives" in ds.attrs["derivatives_message"]
    assert np.isnan(ds["multiplier_real_derivative"]).all()

    ds = cd.periodic_orbit(own.with_parameters(zeta=40.0, wall=5.0, amplitude=0.0), derivatives=["e"], method="dop853")
    assert int(ds["outcome"]) != cd.Outcome.PERIODIC
    assert "means of a chaotic motion" in ds.attrs["derivatives_message"]


SCENE = """\
[system]
model = "rimless-wheel"
[analysis.gait]
kind = "periodic-orbit"
transient = 50
derivatives = DERIVATIVES
"""


def test_in_a_scene_its_archive_and_the_report(tmp_path):
    """One per cent of each parameter, in the table of the page, is that of the closed form."""
    archive = tmp_path / "gait.nc"
    cd.run(cd.parse_scene(SCENE.replace("DERIVATIVES", "true")), archive)
    assert cd.verify(archive).exact
    page = read(cd.report(archive, tmp_path / "gait.html").path)
    (table,) = (one for one in page.all("table") if "What moves the orbit" in one.text)
    values = {"alpha": 0.3, "gamma": 0.15}
    period, by = float(closed.gait(**values)["period"]), closed.by_parameters(closed.gait, values)["period"]
    rows = [[cell.text for cell in row.all("th", "td")] for row in table.all("tr")]
    for name, value, moved, *_ in rows[-2:]:
        assert float(value) == values[name]
        assert float(moved.replace("−", "-")) == pytest.approx(float(by[name]) * values[name] / period, rel=1e-4)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ('["alfa"]', ("6: analysis.gait.derivatives", "unknown parameter; did you mean 'alpha'?")),
        ('"alpha"', ("6: analysis.gait.derivatives", "expected true for all parameters, or a list of some")),
    ],
)
def test_refused_in_a_scene(given, words):
    with pytest.raises(cd.SceneError) as caught:
        cd.parse_scene(SCENE.replace("DERIVATIVES", given))
    assert all(part in str(caught.value) for part in words)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (["omga"], "did you mean 'omega'"),
        ("omega", "expected true for all parameters, or a list of some"),
        (["e", "e"], "twice"),
        ([], "must not be empty"),
    ],
)
def test_refused(oscillator, given, words):
    with pytest.raises(cd.SettingsError, match=words):
        cd.periodic_orbit(oscillator, derivatives=given)


@pytest.mark.parametrize("images", [{"x": "x/2 + k*y", "y": "y/2", "z": "z/4 + k*x"}, {"x": "x/2", "y": "k*y/2"}])
def test_multipliers_that_are_one_have_no_derivative_and_others_do(images):
    system = cd.Map(list(images), {"k": 1.0}, images, initial=dict.fromkeys(images, 0.0))
    ds = cd.periodic_orbit(system, start="guess", derivatives=True)
    apart = ds["multiplier_real"].values != 0.5
    assert (np.isfinite(ds["multiplier_real_derivative"].values[:, 0]) == apart).all()
    assert not ds["multiplier_real_derivative"].values[apart].any()
