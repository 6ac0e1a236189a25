"""Discrete maps: equal to the same map with a clock to the bit, to published figures, and to closed forms."""

import json
import math
import pickle
import subprocess
import sys
from functools import partial
from typing import Any

import numpy as np
import pytest
import sympy

import chaosdrill as cd
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run
from chaosdrill.engine.structure import examine
from tests.support.discrete import HENON, LOGISTIC, clocked, timed

MAPS = {"henon": HENON, "logistic": LOGISTIC}


@pytest.mark.parametrize("name", MAPS)
def test_section_and_exponents_equal_the_clock_to_the_bit(name: str) -> None:
    given = MAPS[name]
    n, lengths = len(given["states"]), {"transient": 50, "periods": 600}
    own, other = cd.Map(**given), clocked("clocked", **given)
    points = cd.poincare_section(own, **lengths)["section"].values
    assert np.array_equal(points, cd.poincare_section(other, **lengths)["section"].values[:, :n])
    # its clock has an exponent of its own, 0, with which tangents are made orthogonal at other times
    exponents = [cd.lyapunov_spectrum(one, **lengths)["lyapunov_exponent"].values for one in (own, other)]
    assert exponents[1][np.abs(exponents[1]) > 1e-9] == pytest.approx(exponents[0], rel=1e-13)
    by_time = cd.lyapunov_spectrum(timed(**given), **lengths)
    assert np.array_equal(by_time["lyapunov_exponent"].values, exponents[0])


def test_rank_is_lost_where_the_derivative_has_no_inverse() -> None:
    # no state is moved onto a guard that depends on time alone: without a matrix every map counted as deficient
    assert examine(cd.Map(**HENON)).deficient == examine(timed(**HENON)).deficient == frozenset()
    assert examine(cd.Map("x y", {}, ["2*x + y", "4*x + 2*y"])).deficient == {0}


@pytest.mark.parametrize(("factor", "lost"), [("sin(pi*t)", {0}), ("cos(pi*t)", set())])
def test_rank_is_that_at_the_times_of_the_events(factor, lost) -> None:
    kick = cd.Transition("kick", "m", "m", "sin(pi*t)", 0, reset={"y": f"y*{factor}"})
    system = cd.HybridSystem(
        states="x y", time="t", modes={"m": {"x": "y", "y": "x"}}, transitions=[kick], initial={"x": 0.0}, period=2
    )
    assert examine(system).deficient == lost


def test_sweeps_equal_the_clock_to_the_bit() -> None:
    own, other = cd.Map(**LOGISTIC), clocked("clocked", **LOGISTIC)
    sweep = {"a": [2.8, 3.2, 3.5, 3.6, 3.83, 3.9, 4.2]}
    here, there = (cd.bifurcation_diagram(one, sweep, transient=200, periods=64) for one in (own, other))
    assert np.array_equal(here["period"], there["period"])
    assert np.array_equal(here["outcome"], there["outcome"])
    section = there["section"].sel(state=["x"]).values
    assert np.array_equal(here["section"].values, section, equal_nan=True)


def test_an_iterate_is_evaluated_once() -> None:
    # a clock's three steps an iterate evaluated as many terms of series as three times the order
    run = Run(cd.Map(**HENON), 1.0, Numerics(), tangents=np.eye(2))
    run.advance(100)
    assert (run.strobes, run.evaluations) == (100, 100)


def test_no_flow_is_compiled_ahead(monkeypatch: pytest.MonkeyPatch) -> None:
    for place in ("analysis.measures.records", "engine.ahead"):
        monkeypatch.setattr(f"chaosdrill.{place}.compile_ahead", lambda part: pytest.fail(f"{part} is compiled"))
    for analysis in (cd.zero_one_test, cd.finite_time_exponents):
        analysis(cd.Map(**LOGISTIC), transient=100, periods=200)


@pytest.fixture(scope="module")
def with_loss() -> tuple[cd.Map, cd.HybridSystem]:
    """A map that loses rank at once and leaves its bounds after 46 iterates, and its reader's clock as a system."""
    images = ["Piecewise(a*x*(1 - x), x > 1/2, a*(1 - x)*x)", "x"]
    own = cd.Map("x y", {"a": 3.9}, images, initial={"x": 0.3}, bounds={"x": (0, 0.97), "y": None})
    words = {name: getattr(own, name) for name in ("states", "time", "parameters", "modes", "transitions", "bounds")}
    return own, cd.HybridSystem(name="its clock", period=1, initial={"x": 0.3}, **words)


@pytest.mark.parametrize("pieces", [(40,), (1, 1, 2, 36), (1, 40, 20)])
def test_records_equal_the_clock_to_the_bit(with_loss: tuple[cd.Map, cd.HybridSystem], pieces: tuple[int, ...]) -> None:
    states, tables = [], []
    for system in with_loss:
        run = Run(system, 1.0, Numerics(), tangents=np.eye(2), deficient=examine(system).deficient)
        samples, events, rows, outcome = np.zeros((64, 3)), np.zeros((7, 10)), [], cd.Outcome.OK
        for count in pieces:
            target, full = count, True
            while full and outcome == cd.Outcome.OK:
                outcome, full = run.advance(target, samples, events)
                target, (taken, met) = 0, run.filled()
                # a clock tells the time of its event up to rounding
                rows += [samples[:taken].copy(), np.delete(events[:met], 1, axis=1)]
        assert outcome == (cd.Outcome.ESCAPED if sum(pieces) > 46 else cd.Outcome.OK)
        assert run.strobes == min(sum(pieces), 46)
        tables.append([np.vstack(rows[first::2]) for first in (0, 1)])
        # a map has no time between its images at which it could be within its bounds again
        kept = (one for name, one in run.states._asdict().items() if name not in ("run", "leeway"))
        states.append([*kept, np.array(run.live)])
    assert states[0][-1] == 1
    for own, other in zip(*states, strict=True):
        assert np.array_equal(own, other)
    for own, other in zip(*tables, strict=True):
        assert np.array_equal(own, other)


def test_orbits_equal_the_fixed_points() -> None:
    found = cd.periodic_orbit(cd.Map(**HENON), transient=50)
    x = (-0.7 + math.sqrt(0.49 + 4 * 1.4)) / 2.8
    assert found["orbit_state"].values == pytest.approx([x, 0.3 * x], abs=1e-14)
    exact = np.roots([1, 2.8 * x, -0.3])
    assert np.sort(found["multiplier_real"].values) == pytest.approx(np.sort(exact), abs=1e-13)


def test_henon_doubles_where_the_closed_form_says() -> None:
    system = cd.Map(**HENON).with_parameters(a=0.2)
    branch = cd.continue_orbit(system, {"a": (0.1, 0.6)}, transient=200)
    assert branch["special_value"].values == pytest.approx([3 * 0.7**2 / 4], abs=1e-10)


def test_henon_has_its_published_exponents() -> None:
    # Sprott 2003: 0.41922 and -1.62319; their sum is ln b whatever the run
    found = cd.lyapunov_spectrum(cd.Map(**HENON), transient=1000, periods=100_000)
    exponents, errors = found["lyapunov_exponent"].values, found["lyapunov_error"].values
    assert abs(exponents[0] - 0.41922) < 4 * errors[0] < 0.01
    assert exponents.sum() == pytest.approx(math.log(0.3), abs=1e-12)


def test_the_full_logistic_map_has_the_exponent_ln_2() -> None:
    found = cd.lyapunov_spectrum(cd.Map(**LOGISTIC).with_parameters(a=4.0), transient=100, periods=50_000)
    assert abs(float(found["lyapunov_exponent"][0]) - math.log(2)) < 4 * float(found["lyapunov_error"][0]) < 0.02


def test_ikeda_has_its_published_exponents() -> None:
    # Sprott 2003 for u = 0.9: 0.5076 and -0.7183, whose sum is 2 ln u
    angle = "(0.4 - 6/(1 + x**2 + y**2))"
    images = [f"1 + u*(x*cos{angle} - y*sin{angle})", f"u*(x*sin{angle} + y*cos{angle})"]
    found = cd.lyapunov_spectrum(cd.Map("x y", {"u": 0.9}, images), transient=200, periods=40_000)
    exponents, errors = found["lyapunov_exponent"].values, found["lyapunov_error"].values
    assert abs(exponents[0] - 0.5076) < 4 * errors[0] < 0.03
    assert exponents.sum() == pytest.approx(2 * math.log(0.9), abs=1e-12)


def test_the_standard_map_grows_as_chirikov_says() -> None:
    # Chirikov 1979: the exponent is ln(K/2) for large K, and areas are kept
    system = cd.Map(
        "q p", {"K": 10.0}, ["Mod(q + p + K*sin(q), 2*pi)", "Mod(p + K*sin(q), 2*pi)"], initial={"q": 1, "p": 2}
    )
    found = cd.lyapunov_spectrum(system, transient=10, periods=20_000)
    exponents = found["lyapunov_exponent"].values
    assert exponents[0] == pytest.approx(math.log(5), abs=0.02)
    assert exponents.sum() == pytest.approx(0, abs=1e-9)


PIECES = {
    "Piecewise(x/p, x < p, (1 - x)/(1 - p))": lambda x: x / 0.3 if x < 0.3 else (1 - x) / 0.7,
    "Min(x/p, (1 - x)/(1 - p))": lambda x: min(x / 0.3, (1 - x) / 0.7),
    "Max(-x/p, (x - 1)/(1 - p), -9) + sign(x)": lambda x: max(-x / 0.3, (x - 1) / 0.7) + math.copysign(1, x),
    "1 + ceiling(x - p)*(p - x)/(1 - p) + (1 - ceiling(x - p))*(x/p - 1)": None,
}


@pytest.mark.parametrize("image", PIECES)
def test_branches_are_those_of_python(image: str) -> None:
    x, by_hand = 0.123, [0.123]
    for _ in range(12):
        x = (PIECES[image] or PIECES["Min(x/p, (1 - x)/(1 - p))"])(x)
        by_hand.append(x)
    states = cd.trajectory(cd.Map("x", {"p": 0.3}, [image], initial={"x": 0.123}), periods=12)["states"]
    assert states.values[:, 0] == pytest.approx(by_hand, abs=1e-9)


@pytest.mark.parametrize(("a", "period"), [(2.0, 1), (1 + 5**0.5, 2)])
def test_a_superstable_cycle_has_no_slope_but_rounding(a: float, period: int) -> None:
    # x = 1/2 lies on the cycle, where a - 2*a*x vanishes: what rounding leaves of it is no exponent
    system = cd.Map(**LOGISTIC).with_parameters(a=a)
    assert cd.lyapunov_spectrum(system, transient=100, periods=60)["lyapunov_exponent"].item() == -np.inf
    orbit = cd.periodic_orbit(system, period=period)
    assert orbit["multiplier_real"].item() == 0.0
    assert orbit["exponent_difference"].item() == 0.0
    near = cd.lyapunov_spectrum(system.with_parameters(a=2.0 + 1e-9), transient=100, periods=60)
    assert near["lyapunov_exponent"].item() == pytest.approx(np.log(1e-9), rel=1e-6)


@pytest.mark.parametrize("b", [1e-6, 1e-10])
def test_strong_contraction_keeps_its_digits_in_any_coordinates(b: float) -> None:
    # Henon's map in p = x + 2*y, q = x - y: areas change by -b an iterate
    x, y = "(p + 2*q)/3", "(p - q)/3"
    images = {"p": f"1 - a*({x})**2 + {y} + 2*b*{x}", "q": f"1 - a*({x})**2 + {y} - b*{x}"}
    turned = cd.Map("p q", {"a": 1.7, "b": b}, images, initial={"p": 0.3, "q": 0.3})
    exponents = cd.lyapunov_spectrum(turned, transient=10, periods=700)["lyapunov_exponent"].values
    assert exponents.sum() == pytest.approx(np.log(b), abs=1e-4)


def test_branches_have_their_own_slopes() -> None:
    # the skew tent map: -p ln p - (1-p) ln(1-p)
    system = cd.Map("x", {"p": 0.3}, ["Piecewise(x/p, x < p, (1 - x)/(1 - p))"], initial={"x": 0.1234})
    found = cd.lyapunov_spectrum(system, periods=20_000)
    exact = -0.3 * math.log(0.3) - 0.7 * math.log(0.7)
    assert abs(float(found["lyapunov_exponent"][0]) - exact) < 4 * float(found["lyapunov_error"][0]) < 0.02


def test_a_trajectory_has_a_sample_an_iterate() -> None:
    found = cd.trajectory(cd.Map(**LOGISTIC), periods=3)
    x = [0.3]
    for _ in range(3):
        x.append(3.9 * x[-1] * (1 - x[-1]))
    assert found["time"].values.tolist() == [0, 1, 2, 3]
    assert found["states"].values[:, 0] == pytest.approx(x, rel=1e-14)


WAYS: dict[str, dict[str, Any]] = {
    "names": {"states": "x y", "images": {"x": "1 - a*x**2 + y", "y": "b*x"}},
    "order": {"states": ["x", "y"], "images": ["1 - a*x**2 + y", "b*x"]},
    "table in another order": {"states": "x y", "images": {"y": "b*x", "x": "y + 1 - a*x**2"}},
}


@pytest.mark.parametrize("way", WAYS)
def test_ways_to_write_it_are_the_same(way: str) -> None:
    system = cd.Map(**{**HENON, **WAYS[way]})
    assert system.images == cd.Map(**HENON).images
    assert system.shared is cd.Map(**HENON).shared


@pytest.mark.parametrize("copy", [lambda m: pickle.loads(pickle.dumps(m)), lambda m: m.with_parameters(a=1.4)])
def test_copies_stay_maps(copy: Any) -> None:
    other = copy(cd.Map(**HENON))
    assert isinstance(other, cd.Map)
    assert other.images == cd.Map(**HENON).images


WRONG = {
    "t": ({"images": ["t", "y"]}, "images.x: unknown name 't'; a map has no time; let a state count iterates"),
    "one missing": ({"images": {"x": 1}}, "images: gives no image of 'y'"),
    "misspelt": ({"images": {"x": 1, "z": 2}}, "images.z: unknown state; known here: x, y"),
    "too many": ({"images": [1, 2, 3]}, "images: there are 3; give one for each of the 2 states"),
    "none": ({"images": None}, "images: missing; expected the next value of every state"),
    "number": ({"images": 3}, "images: received 3; expected the next value of every state"),
    "name": ({"images": ["x + q", "y"]}, "images.x: unknown name 'q'"),
    "function": ({"images": ["foo(x)", "y"]}, "images.x: unknown function 'foo'"),
    "heaviside": ({"images": ["Heaviside(x)", "y"]}, "images.x: unknown function 'Heaviside'; write Piecewise(1, "),
    "states": ({"states": "x x"}, "states.1: 'x' is named twice"),
    # the micro sign and the Greek letter
    "alike": ({"states": "\u00b5 \u03bc", "images": [1, 2]}, "states: '\u03bc' and '\u00b5' are one name in Python"),
    "parameter": ({"parameters": {"x": 1.0}}, "states: 'x' is the name of a parameter too"),
    "labels": ({"labels": {"q": "a"}}, "labels.q: names no state, parameter, quadrature or time; known here: x, y"),
    "bounds": ({"bounds": {"x": (1, 0)}}, "bounds.x: expected [low, high]"),
}


@pytest.mark.parametrize("case", WRONG)
def test_faults_name_the_place_and_the_remedy(case: str) -> None:
    change, told = WRONG[case]
    with pytest.raises(cd.ModelError) as fault:
        cd.Map(**{"states": "x y", "parameters": {}, "images": ["x", "y"], **change})
    assert any(line.startswith(f"own-map: {told}") for line in str(fault.value).splitlines()), str(fault.value)
    assert not any(word in str(fault.value) for word in ("clock", "transition", "mode"))


def test_a_state_may_be_called_as_time_is() -> None:
    found = cd.trajectory(cd.Map("t time", {}, ["t + 1", "time + t"]), periods=3)
    assert found["states"].values[-1].tolist() == [3, 3]


REFUSED = {
    "method": (lambda m: cd.work_precision(m, periods=10), "is a map: it takes no steps"),
    "surface": (lambda m: cd.poincare_section(m, periods=10, at="x > 0"), "is a map: iterates jump across a surface"),
    "duration": (lambda m: cd.lyapunov_spectrum(m, duration=10.0), "is a map; give periods instead"),
    "drive": (lambda m: cd.driven(m, "a", "square"), "a map has no time"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_has_no_meaning_is_refused(case: str) -> None:
    run, told = REFUSED[case]
    with pytest.raises(cd.ChaosdrillError, match=told):
        run(cd.Map(**HENON))


def test_archives_give_it_back() -> None:
    system = cd.Map(**HENON, name="henon", labels={"x": "position"})
    again = cd.system(cd.poincare_section(system, periods=4))
    assert isinstance(again, cd.Map)
    assert (again.name, again.images, again.labels) == ("henon", system.images, system.labels)
    assert dict(again.initial) == dict(system.initial)


def test_pieces_survive_an_archive() -> None:
    system = cd.Map("x", {"p": 0.3}, {"x": "Max(x/p, 1) - floor(x)"})
    assert cd.system(cd.poincare_section(system, periods=4)).images == system.images


SCENE = """\
[system.map]
states = ["x", "y"]
images = { x = "1 - a*x**2 + y", y = "b*x" }
[system.parameters]
a = 1.4
b = 0.3
[analysis.section]
kind = "poincare-section"
periods = 40
"""


def test_a_scene_is_checked_as_a_map() -> None:
    told = cd.check(cd.parse_scene(SCENE))
    assert told["map"] == {"x next": "-a*x**2 + y + 1", "y next": "b*x"}
    assert told["modes"] == told["events"] == {}
    assert told["period"] is None


def test_a_scene_runs_and_is_verified(tmp_path: Any) -> None:
    cd.run(cd.parse_scene(SCENE), tmp_path / "map.nc")
    assert cd.verify(tmp_path / "map.nc").exact
    # a second process finds what was derived, and reads the images when they are asked for
    (tmp_path / "map.toml").write_text(SCENE)
    command = [sys.executable, "-m", "chaosdrill", "check", "--json", str(tmp_path / "map.toml")]
    told = json.loads(subprocess.run(command, check=True, capture_output=True).stdout)
    assert told["map"] == {"x next": "-a*x**2 + y + 1", "y next": "b*x"}


def test_a_map_is_saved_as_a_scene(tmp_path: Any) -> None:
    asked = {"section": {"kind": "poincare-section", "periods": 4}}
    scene = cd.load_scene(cd.save_scene(tmp_path / "map.toml", cd.Map(**HENON), asked))
    assert isinstance(scene.system, cd.Map)
    assert scene.system.images == cd.Map(**HENON).images


def test_faults_of_a_scene_have_their_lines() -> None:
    with pytest.raises(cd.SceneError, match=r"scene.toml:3: system.map.images.y: unknown name 'c'"):
        cd.parse_scene(SCENE.replace("b*x", "c*x"))
    with pytest.raises(cd.SceneError, match=r"scene.toml:6: system.parameters.b: not used in the map"):
        cd.parse_scene(SCENE.replace("b*x", "x"))
    with pytest.raises(cd.SceneError, match=r"system.drives: a map has no time"):
        cd.parse_scene(SCENE + '[system.drives.a]\npieces = "square"\n')


def test_a_scene_refuses_what_has_no_meaning() -> None:
    scene = cd.parse_scene(SCENE + '[analysis.work]\nkind = "work-precision"\nperiods = 9\n')
    with pytest.raises(cd.SceneError, match=r"scene.toml:10: analysis.work: .* is a map"):
        cd.check(scene)


def test_equations_are_shown_as_a_map() -> None:
    latex, html = str(cd.Map(**HENON)._repr_latex_()), str(cd.Map(**HENON)._repr_html_())
    assert r"y &\mapsto b x" in latex
    assert "↦" in html
    assert not any(word in text for word in ("cos", "forcing", "Event") for text in (latex, html))


def test_words_of_pictures_are_of_iterates() -> None:
    from matplotlib import pyplot as plt

    axes = cd.plot(cd.poincare_section(cd.Map(**HENON), periods=20))
    assert "every iterate" in " ".join([axes.get_title(), *(t.get_text() for t in axes.figure.findobj(plt.Text))])


def test_words_of_variables_are_of_iterates() -> None:
    found = cd.lyapunov_spectrum(cd.Map(**HENON), periods=100)
    assert found["lyapunov_exponent"].attrs["comment"].startswith("Per iterate;")
    assert found["events_per_period"].attrs["long_name"] == "events per iterate"
    texts = [str(text) for one in found.variables.values() for text in one.attrs.values()]
    assert not [text for text in texts if "forcing" in text or "model time" in text]


def test_symbols_are_matched_by_name() -> None:
    x, a = sympy.symbols("x a")
    assert cd.Map([x], {"a": 2.0}, {x: a * x}).images == cd.Map("x", {"a": 2.0}, ["a*x"]).images


RUNS: dict[str, tuple[Any, tuple[str, ...]]] = {
    "chart": (
        lambda s: cd.parameter_chart(s, {"a": [0.2, 0.9, 1.4], "b": [0.2, 0.3]}, transient=100, periods=64),
        ("period", "outcome"),
    ),
    "basins": (
        lambda s: cd.basins(s, {"x": [-0.5, 0.5, 9.0], "y": [-0.2, 0.3]}, transient=100, periods=64),
        ("attractor", "outcome"),
    ),
    "0-1 test": (lambda s: cd.zero_one_test(s, transient=100, periods=200), ("k",)),
    "regularity": (
        lambda s: cd.regularity(s.with_parameters(a=0.9), transient=300, periods=200),
        ("digits", "outcome"),
    ),
}


@pytest.mark.parametrize("name", RUNS)
def test_other_analyses_equal_the_clock_to_the_bit(name: str) -> None:
    run, variables = RUNS[name]
    own, other = (run(make(**HENON)) for make in (cd.Map, partial(clocked, "clocked")))
    for variable in variables:
        there = other[variable]
        there = there.sel(state=["x", "y"]) if "state" in there.dims else there
        assert np.array_equal(own[variable].values, there.values, equal_nan=True), variable


def test_an_image_may_be_a_python_function() -> None:
    def image(t: float, x: Any, p: Any) -> tuple[float]:
        return (p.a * x.x * (1 - x.x),)

    system = cd.Map(**{**LOGISTIC, "images": image}).with_parameters(a=3.2)
    found = cd.lyapunov_spectrum(system, transient=200, periods=50, method="dop853")
    # of the cycle of period 2 the multiplier is 4 + 2a - a^2
    assert found["lyapunov_exponent"].values == pytest.approx([math.log(abs(4 + 6.4 - 3.2**2)) / 2], rel=1e-9)
    with pytest.raises(cd.ModelError, match="images: reads the time; a map has no time"):
        cd.Map("x", {}, lambda t, x, p: (x.x + t,))


def test_windows_of_growth_are_those_of_the_map() -> None:
    found = cd.finite_time_exponents(cd.Map(**LOGISTIC).with_parameters(a=4.0), transient=100, periods=20_000)
    # of one iterate: pi^2/12, the variance of ln|4 - 8x| over the invariant density
    value, error = (float(found[name].sel(exponent=1, order=2)[0]) for name in ("cumulant", "cumulant_error"))
    assert abs(value - math.pi**2 / 12) < 2 * error < 0.05 * value


def test_an_image_without_a_value_says_where() -> None:
    found = cd.lyapunov_spectrum(cd.Map("x", {}, ["log(x)"], initial={"x": 2}), periods=500)
    assert found.cd.outcome == "nonfinite"
    assert found.attrs["message"].startswith("an image is infinite or not a number: in mode 'map', time 2.75, at x")


def test_zaslavsky_with_a_long_remainder():
    # its angle has more operations than Mod takes; areas shrink by exp(-G)
    w = "(x + nu*(1 + (1 - exp(-G))/G*y) + k*nu*(1 - exp(-G))/G*cos(2*pi*x))"
    images = {"x": f"Mod({w}, 1)", "y": "exp(-G)*(y + k*cos(2*pi*x))"}
    given = {"parameters": {"G": 3.0, "nu": 0.2, "k": 5.0}, "initial": {"x": 0.1}}
    with pytest.raises(cd.ModelError, match=r"write x - y\*floor\(x/y\) for Mod\(x, y\)"):
        cd.Map("x y", images=images, **given)
    found = cd.lyapunov_spectrum(cd.Map("x y", images={**images, "x": f"{w} - floor({w})"}, **given), periods=500)
    assert float(found["lyapunov_exponent"].sum()) == pytest.approx(-3, abs=1e-12)
