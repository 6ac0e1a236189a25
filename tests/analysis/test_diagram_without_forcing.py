"""A system without forcing has diagrams, charts and basins over a section that is named, and none over an invented one.

Roessler: period doublings at c = 2.83 and 3.84, the window of period 3 at c = 5.3 and chaos at c = 5.7, with a and b
0.2: Strogatz 2015, section 12.3; exponent 0.0714: Sprott 2003.
"""

import numpy as np
import pytest

import chaosdrill as cd
from chaosdrill.scene import parse_scene

SCENE = """
system.model = 'lorenz'
[analysis.a]
kind = 'bifurcation-diagram'
sweep.rho = [28.0]
transient = 1
periods = 8
"""
CASES = {2.5: 1, 2.82: 1, 2.84: 2, 3.83: 2, 3.86: 4, 5.3: 3, 5.7: 0}


def words(ds):
    return [cd.Outcome(int(code)).meaning for code in np.ravel(ds["outcome"].values)]


@pytest.fixture(scope="module")
def roessler():
    return cd.build("roessler")


def test_what_to_do_is_said(roessler):
    with pytest.raises(cd.SettingsError, match=r"roessler has no forcing period.*name a section, as in at='x > 0'"):
        cd.bifurcation_diagram(roessler, sweep={"c": [2.5]}, transient=1, periods=8)
    with pytest.raises(cd.SceneError, match=r"lorenz has no forcing period, .*name a section, as in at='x > 0'"):
        cd.check(parse_scene(SCENE))
    # a length that the named section does not count
    with pytest.raises(cd.SettingsError, match=r"transient is 0.5; expected whole points of the section"):
        cd.bifurcation_diagram(roessler, sweep={"c": [2.5]}, transient=0.5, periods=8, at="x > 0")


@pytest.mark.parametrize("at", ["y > 0", "x < -1"])
def test_period_doublings_over_any_section(roessler, at):
    found = cd.bifurcation_diagram(roessler, sweep={"c": list(CASES)}, transient=100, periods=200, at=at)
    assert found["period"].values.ravel().tolist() == list(CASES.values())
    assert words(found) == ["periodic"] * 6 + ["chaotic"]
    exponent, error = found["lyapunov_exponent"].values[:, 0], found["lyapunov_error"].values[:, 0]
    assert np.all(np.abs(exponent[:6, 0]) < 3e-3)
    assert abs(exponent[6, 0] - 0.0714) < 3 * error[6, 0] < 0.03
    # a turn takes nearly 2 pi / sqrt(1 - a**2/4), about the saddle focus
    np.testing.assert_allclose(found["return_time"], 5.8, atol=0.07)


@pytest.mark.parametrize("at", [None, "y > 0"])
def test_outcomes_do_not_depend_on_what_lengths_count(roessler, at):
    values = {"c": [2.5, 3.5, 5.7], "a": [0.2]}
    found = cd.parameter_chart(roessler, values, transient=500, duration=1200, at=at)
    assert words(found) == ["periodic", "periodic", "chaotic"]
    assert found["period"].values.ravel().tolist() == ([0, 0, 0] if at is None else [1, 2, 0])
    assert "forcing_period" not in found


def test_a_section_that_is_never_met_has_an_outcome(roessler):
    found = cd.bifurcation_diagram(roessler, {"c": [2.5, 5.7]}, transient=2, periods=8, at="x > 1000", max_return=100)
    assert words(found) == ["no_return"] * 2
    assert np.isnan(found["section"].values).all()
    section = cd.poincare_section(roessler, transient=2, periods=8, at="x > 1000", max_return=100)
    assert words(section) == ["no_return"]


def test_a_record_of_more_points_goes_on_from_one_of_fewer(roessler):
    """No step depends on how many points are asked for."""
    short, long = (cd.poincare_section(roessler, periods=count, at="y > 0") for count in (70, 180))
    np.testing.assert_array_equal(long["section"].values[:70], short["section"].values)
    np.testing.assert_array_equal(long["time"].values[:70], short["time"].values)


@pytest.mark.parametrize("m", [-0.5, -0.2, -0.1, 0.1])
def test_a_rest_whose_speed_is_that_of_rounding_is_a_rest(m):
    """x'' = -3 x' + x - x**3 + m: the speed fades to its rounding, and the section may never be met again."""
    spring = cd.HybridSystem(
        name="spring",
        states="x v",
        parameters={"m": 0.0},
        modes={"on": {"x": "v", "v": "-3*v+x-x**3+m"}},
        initial={"x": 1.2, "v": 0.0},
    )
    ds = cd.bifurcation_diagram(spring, {"m": [m]}, at="v > 0", transient=50, periods=64)
    assert words(ds) == ["equilibrium"]


def test_a_followed_rest_is_left_where_it_loses_its_stability_and_not_before():
    """r' = m r + r**3 - r**5: the cycle is there from m = -1/4 on, and the rest loses its stability at 0."""
    bautin = cd.HybridSystem(
        name="bautin",
        states="x v",
        parameters={"m": 0.1},
        modes={"on": {a: f"m*{a} + {b} + {a}*(x*x+v*v) - {a}*(x*x+v*v)**2" for a, b in (("x", "-2*v"), ("v", "2*x"))}},
        initial={"x": 0.5, "v": 0.0},
    )
    m = np.linspace(-0.4, 0.1, 26)
    ds = cd.bifurcation_diagram(bautin, {"m": m}, follow="both", at="v > 0", transient=50, periods=64)
    forward, backward = np.reshape(words(ds), (26, 2)).T
    assert forward.tolist() == np.where(m > 1e-9, "periodic", "equilibrium").tolist()
    assert backward.tolist() == np.where(m > -0.25, "periodic", "equilibrium").tolist()


def test_growth_too_small_to_be_seen_is_no_chaos():
    """The rest of Mathieu's equation, damped, loses its stability at 0.0800; beyond, a motion of period 2 attracts."""
    mathieu = cd.HybridSystem(
        name="mathieu",
        states="q p",
        parameters={"a": 0.1},
        modes={"on": {"q": "p", "p": "-0.04*p-(1+a*cos(2*t))*q-q**3"}},
        period="pi",
        initial={"q": 0.0, "p": 0.1},
    )
    a = np.array([0.02, 0.03, 0.04, 0.05, 0.06, 0.07, 0.09, 0.1])
    ds = cd.bifurcation_diagram(mathieu, {"a": a}, follow="forward", transient=200, periods=64)
    assert set(words(ds)) == {"periodic"}
    assert ds["period"].values.ravel().tolist() == [1] * 6 + [2] * 2
