"""Exponents, rank and outcome do not depend on how many are asked for, on the order of states, or on coordinates."""

from dataclasses import replace

import numpy as np
import pytest
import sympy
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import chaosdrill as cd
from chaosdrill.analysis.grids import plan
from chaosdrill.analysis.measures.spectra import computed_exponents
from chaosdrill.engine.structure import Structure, examine

X, V, F, G, E, T = sympy.symbols("x v f g e t", real=True)
OMEGA = sympy.Rational(5, 2)
ORDERS = {"driven first": (F, G, X, V), "driven last": (X, V, F, G)}
ENDED = cd.Outcome.PERIODIC, cd.Outcome.CHAOTIC


def filtered(order, unit=1):
    """An impact oscillator with two filters that it drives, lengths in units of 1/unit.

    The filters have the exponents -2 and -3, the oscillator's sum is -0.1 + 2 ln e a hit; chaotic at e = 0.8.
    """
    field = {X: V, V: -X - V / 10 + unit * sympy.cos(OMEGA * T), F: -2 * F + X, G: -3 * G + V}
    guard = X - sympy.Rational(3, 10) * unit
    hit = cd.Transition("impact", "free", "free", guard=guard, direction=1, reset={V: -E * V})
    return cd.HybridSystem(
        name="filtered",
        states=order,
        time=T,
        parameters={"e": 0.8},
        modes={"free": field},
        transitions=[hit],
        period=2 * sympy.pi / OMEGA,
        initial={X: 0, V: 0.3 * unit},
    )


@pytest.fixture(scope="module")
def systems():
    made = {name: filtered(order) for name, order in ORDERS.items()}
    return made | {"in millionths": filtered(ORDERS["driven last"], 10**6)}


def spectrum(system, count=None, **more):
    return cd.lyapunov_spectrum(system, periods=400, transient=100, exponents=count, blocks=64, **more)


@pytest.fixture(scope="module")
def reference(systems):
    return {name: spectrum(system) for name, system in systems.items()}


@settings(max_examples=6)
@given(st.sampled_from([*ORDERS, "in millionths"]), st.integers(1, 3))
def test_fewer_exponents_are_the_first_of_all(systems, reference, name, count):
    part, whole = spectrum(systems[name], count), reference[name]
    np.testing.assert_array_equal(part["lyapunov_exponent"], whole["lyapunov_exponent"][:count])
    np.testing.assert_array_equal(part["lyapunov_history"], whole["lyapunov_history"][:, :count])
    for known in ("rank", "outcome", "kaplan_yorke_dimension"):
        assert float(part[known]) == float(whole[known]), known


@pytest.mark.parametrize("name", [*ORDERS, "in millionths"])
def test_the_spectrum_is_that_of_the_motion(reference, name):
    """0.0914(3) and the sum rule; the filters' own exponents are exact."""
    found, error = (reference[name][v].values for v in ("lyapunov_exponent", "lyapunov_error"))
    assert abs(found[0] - 0.0914) < 5 * error[0]
    hits = float(reference[name]["event_count"].sum()) / (400 * 2 * np.pi / 2.5)
    assert found[:2].sum() == pytest.approx(-0.1 + 2 * np.log(0.8) * hits, abs=1e-8)
    np.testing.assert_allclose(found[2:], [-2, -3], rtol=1e-7)
    assert int(reference[name]["outcome"]) == cd.Outcome.CHAOTIC
    assert int(reference[name]["rank"]) == 4


def diagram(system, count=None):
    return cd.bifurcation_diagram(system, {"e": [0.2, 0.6, 0.8]}, transient=300, periods=200, exponents=count)


@pytest.fixture(scope="module")
def points(systems):
    return diagram(systems["driven last"])


@pytest.mark.parametrize("count", [1, 2])
@pytest.mark.parametrize("name", ORDERS)
def test_points_of_a_sweep_are_those_of_all_exponents_to_the_bit(systems, name, count):
    found, whole = diagram(systems[name], count), diagram(systems[name])
    for known in ("section", "period", "outcome", "impacts_per_period"):
        np.testing.assert_array_equal(found[known].values, whole[known].values)
    np.testing.assert_array_equal(found["lyapunov_exponent"], whole["lyapunov_exponent"][..., :count])


@settings(max_examples=4, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.sampled_from([*ORDERS, "in millionths"]), st.integers(1, 4))
def test_fewer_tangents_measure_the_same(systems, points, monkeypatch, name, count):
    """Two cycles, whose exponents add up by the sum rule, and chaos, from tangents in general position."""
    monkeypatch.setattr(plan, "PLAN", replace(plan.PLAN, small=0))
    found = diagram(systems[name], count)
    np.testing.assert_array_equal(found["period"].values, points["period"].values)
    assert found["outcome"].values.ravel().tolist() == [ENDED[0], ENDED[0], ENDED[1]]
    cycles, whole = (of["lyapunov_exponent"].values[:2, 0] for of in (found, points))
    np.testing.assert_allclose(cycles[:, : min(count, 2)], whole[:, : min(count, 2)], atol=1e-6)
    hits = found["impacts_per_period"].values[:2, 0] * 2.5 / (2 * np.pi)
    np.testing.assert_allclose(whole[:, :2].sum(axis=1), -0.1 + 2 * np.log([0.2, 0.6]) * hits, atol=1e-6)
    lead, error = (float(found[v].values[2, 0, 0]) for v in ("lyapunov_exponent", "lyapunov_error"))
    assert abs(lead - 0.0914) < 5 * error


def test_fewer_tangents_start_in_general_position(systems):
    structure = examine(systems["driven first"])
    some, symmetries = structure.tangents(2)
    assert symmetries == 0
    assert np.abs(some).min() > 1e-3
    np.testing.assert_allclose(some @ some.T, np.eye(2), atol=1e-14)
    np.testing.assert_array_equal(some, examine(systems["driven last"]).tangents(2)[0])
    np.testing.assert_array_equal(some[:1], structure.tangents(1)[0])


def rotation(states, unit=1.0):
    """A circle that attracts at the rate -2, met where one axis lies along the flow and the other across it."""
    off = f"(1 - (p**2 + q**2)/{unit!r}**2)"
    field = {"p": f"a*p*{off} - w*q", "q": f"a*q*{off} + w*p"}
    modes = {"turns": {name: field[name] for name in states.split()}}
    return cd.HybridSystem(
        name="rotation", states=states, modes=modes, parameters={"a": 1.0, "w": 2.0}, initial={"p": unit, "q": 0.0}
    )


@pytest.mark.parametrize("unit", [1.0, 1e-9])
@pytest.mark.parametrize("states", ["p q", "q p"])
def test_a_start_across_the_flow_is_no_other_start(states, unit):
    """Along the axes the first tangent would stay across the flow until round-off turned it."""
    system = rotation(states, unit)
    alone = cd.lyapunov_spectrum(system, duration=50.0, transient=0)
    chart = cd.parameter_chart(system, {"a": [1.0], "w": [2.0]}, duration=50.0, transient=0)
    for found in (alone, chart):
        np.testing.assert_allclose(found["lyapunov_exponent"].values.ravel(), [0, -2], atol=0.05)
        assert found["outcome"].values.ravel().tolist() == [cd.Outcome.PERIODIC]


def driven_rotation(states, unit):
    """A circle that attracts at a rate that a forcing changes, by 2 on average; the angle goes on evenly."""
    off = f"a*(1 + cos(t)/2)*(1 - (p**2 + q**2)/{unit!r}**2)"
    field = {"p": f"p*{off} - sqrt(2)*q", "q": f"q*{off} + sqrt(2)*p"}
    modes = {"turns": {name: field[name] for name in states.split()}}
    start = {"p": unit, "q": 0.0}
    return cd.HybridSystem(states=states, modes=modes, time="t", parameters={"a": 1.0}, period="2*pi", initial=start)


def turned_points(states, unit):
    """A circle that attracts by a factor of exp(-2) a step; the angle goes on by 1."""
    off = f"(1 + a*(1 - exp(-2))/2*(1 - (p**2 + q**2)/{unit!r}**2))"
    images = {"p": f"{off}*(cos(1)*p - sin(1)*q)", "q": f"{off}*(sin(1)*p + cos(1)*q)"}
    return cd.Map(states, {"a": 1.0}, {name: images[name] for name in states.split()}, initial={"p": unit, "q": 0.0})


@pytest.mark.parametrize("unit", [1.0, 1e-9])
@pytest.mark.parametrize("system", [driven_rotation, turned_points])
def test_nor_is_one_on_an_axis_across_a_torus(system, unit):
    """The first tangent stayed across it until round-off turned it: for one order of the states, not for the other."""
    for states in ("p q", "q p"):
        here = system(states, unit)
        alone = cd.lyapunov_spectrum(here, periods=300, transient=0)
        chart = cd.bifurcation_diagram(here, {"a": [1.0]}, periods=300, transient=0, exponents=2)
        for found in (alone, chart):
            np.testing.assert_allclose(found["lyapunov_exponent"].values.ravel(), [0, -2], atol=2e-3)
            assert found["outcome"].values.ravel().tolist() == [cd.Outcome.QUASIPERIODIC]


@pytest.mark.parametrize(
    ("states", "deficient", "asked", "computed"),
    [
        (32, False, 1, 32),
        (33, False, 1, 3),
        (33, False, 8, 8),
        (33, True, 8, 33),
        (33, False, 33, 33),
        (40, True, 0, 0),
    ],
)
def test_large_systems_compute_what_is_asked_for_and_what_tells_the_motion(states, deficient, asked, computed):
    """A rank that an event may lower is known from all tangents alone."""
    lost = frozenset({0}) if deficient else frozenset()
    structure = Structure(deficient=lost, frame=np.eye(states), symmetries=0, autonomous=True)
    assert computed_exponents(structure, asked) == computed


@pytest.mark.parametrize("count", [1, 2, 3])
def test_an_exponent_that_was_not_computed_is_not_left_out(count):
    """Lorenz: (0.9056, 0, -14.572) and the dimension 2.062."""
    found = cd.lyapunov_spectrum(cd.build("lorenz"), duration=200, transient=20, exponents=count)
    assert int(found["outcome"]) == cd.Outcome.CHAOTIC
    assert float(found["lyapunov_exponent"][0]) == pytest.approx(0.9056, abs=5 * float(found["lyapunov_error"][0]))
    assert float(found["kaplan_yorke_dimension"]) == pytest.approx(2.062, abs=0.01)
    assert int(found["rank"]) == 3


@pytest.mark.parametrize("count", [1, 2, 3])
def test_a_round_that_ends_on_an_event_keeps_its_rank(count):
    """A reset that forgets a state, once a unit of time: multipliers 1, 1/e and 0."""
    s = sympy.Symbol("s", real=True)
    reset = {s: 0, G: sympy.Rational(1, 2), X: X + sympy.Rational(1, 10)}
    forgets = cd.HybridSystem(
        name="forgets",
        states=(X, G, s),
        parameters={},
        modes={"on": {X: -X + G, G: -G / 3, s: 1}},
        transitions=[cd.Transition("kick", "on", "on", guard=s - 1, direction=+1, reset=reset)],
        initial={X: 0.3, G: 0.5, s: 0.0},
    )
    found = cd.lyapunov_spectrum(forgets, duration=100, transient=20, exponents=count)
    assert int(found["rank"]) == 2
    assert int(found["outcome"]) == cd.Outcome.PERIODIC
    expected = np.array([0.0, -1.0, -np.inf])[:count]
    np.testing.assert_allclose(found["lyapunov_exponent"].values, expected, atol=1e-2)


@pytest.mark.parametrize("damping", [0.2, 0.01])
def test_the_error_tells_of_ellipses_that_hardly_turn(damping):
    """A hundred swings fit the forcing period: from strobe to strobe tangents turn by 0.01 of a turn at most.

    In parts of the sizes of the states, which a swing has set, they have one length. Windows of whole swings are alike
    to 1e-8, and say nothing of how wrong their mean is.
    """
    swinging = cd.HybridSystem(
        name="swinging", states="x v", time="t", parameters={"d": damping}, period="2*pi",
        modes={"on": {"x": "v", "v": "cos(t) - 10000*x - d*v"}}, initial={"x": 0.0, "v": 0.0},
    )  # fmt: skip
    given = {"periods": 100, "transient": 30}
    analyses = cd.lyapunov_spectrum, cd.finite_time_exponents, cd.covariant_vectors
    diagram = cd.bifurcation_diagram(swinging, {"d": [damping]}, **given)
    for found in (diagram, *(analysis(swinging, **given) for analysis in analyses)):
        gap = np.abs(found["lyapunov_exponent"].values + damping / 2).ravel()
        error = found["lyapunov_error"].values.ravel()
        assert (gap < 2 * error).all()
        assert (error < 2 * np.log(100) / (200 * np.pi)).all()
        if "cumulant" in found:
            mean, error = (found[name].sel(order=1).values for name in ("cumulant", "cumulant_error"))
            assert (abs(mean + damping / 2) < 2 * error).all()


@pytest.mark.parametrize("tolerance", [1e-12, 1e-8, 1e-5])
def test_on_a_cycle_the_error_is_that_of_the_method(tolerance):
    """Real multipliers of the impact oscillator's period-1 orbit, its mean place and power, in closed form.

    Blocks of whole periods are alike there, to the last bit: their spread says nothing.
    """
    oscillator = cd.HybridSystem(
        name="wall-at-rest",
        states="x v",
        time="t",
        parameters={"w": 2.7},
        modes={"free": {"x": "v", "v": "cos(w*t) - x"}},
        transitions=[
            cd.Transition("hit", "free", "free", guard="x", direction=1, reset={"v": "-0.3*v"}, kind="impact")
        ],
        period="2*pi/w",
        initial={"mode": "free", "x": -0.3},
        quadratures={"place": "x", "work": "v*cos(w*t)"},
    )
    w, r = np.linspace(2.56, 2.67, 120), 0.3
    period = 2 * np.pi / w
    c = np.cos(period)
    trace = -2 * r * c + (1 + r) ** 2 * (1 - w**2) * (1 + c) / 2
    squared = trace**2 - 4 * r**2
    size = (np.abs(trace) + np.sqrt(np.maximum(squared, 0))) / 2
    real = (squared > 0.01) & (size < 0.97)
    found = cd.bifurcation_diagram(
        oscillator, {"w": w[real]}, transient=1500, periods=64, exponents=2, tolerance=tolerance
    ).isel(seed=0)
    once = (found["period"].values == 1) & (found["impacts_per_period"].values == 1)
    exact = np.log(np.stack([size[real], r**2 / size[real]], axis=-1)) / period[real, np.newaxis]
    gap = np.abs(found["lyapunov_exponent"].values - exact)[once]
    error = found["lyapunov_error"].values[once]
    assert gap.size >= 150
    assert np.mean(gap <= 2 * error) >= 0.95
    assert np.median(error) < 10 * tolerance
    # x = cos(wt + f)/(1 - w^2) + a cos t + b sin t between impacts at 0 and the period
    b = -1 / ((w**2 - 1) * np.hypot(1 / np.tan(period / 2), (1 - r) / ((1 + r) * w)))
    means = {"place": 2 * b / period, "work": 2 * (1 - r) / (1 + r) * b**2 / period}
    for name, mean in means.items():
        gap = np.abs(found[f"{name}_rate"].values - mean[real])[once]
        error = found[f"{name}_rate_error"].values[once]
        assert np.mean(gap <= 2 * error) >= 0.95
        assert np.median(error) < 10 * tolerance


def test_errors_of_means_do_not_depend_on_steps(systems):
    """Those of the filters, whose rates are the same in all blocks, are the method's."""
    system = systems["driven first"].with_parameters(e=0.735)
    taylor, *others = (
        cd.lyapunov_spectrum(system, periods=7, method=method).lyapunov_error.values[:2]
        for method in ("taylor", "dop853", "radau")
    )
    diagram = cd.bifurcation_diagram(system, {"e": [0.735]}, transient=0, periods=7, max_extension=1)
    for errors in (*others, diagram.lyapunov_error.values[0, 0, :2]):
        np.testing.assert_allclose(errors, taylor, rtol=1e-6)
