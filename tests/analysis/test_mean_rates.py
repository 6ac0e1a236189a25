"""Mean rates of quadratures: closed forms, and error bars that cover the truth as often as they say."""

import numpy as np
import pytest
import xarray as xr

import chaosdrill as cd
from chaosdrill.errors import ModelError
from chaosdrill.workflow.compare import examine

ABOVE = "z > 27"


@pytest.fixture(scope="module")
def lorenz():
    """Its mean of x is zero by the symmetry (x, y) -> (-x, -y), and that of x y is beta times that of z."""
    return cd.HybridSystem(
        name="lorenz",
        states="x y z",
        parameters={"sigma": 10.0, "rho": 28.0, "beta": 8 / 3},
        modes={"flow": {"x": "sigma*(y - x)", "y": "x*(rho - z) - y", "z": "x*y - beta*z"}},
        quadratures={"left": "x", "height": "z", "product": "x*y"},
        initial={"x": 1.0, "y": 1.0, "z": 20.0},
    )


@pytest.fixture(scope="module")
def filtered():
    """x' = -x + cos(t): x goes to (cos t + sin t)/2, whose mean square is 1/4."""
    return cd.HybridSystem(
        name="filter",
        states="x",
        time="t",
        parameters={"gain": 1.0, "lag": 1.0},
        modes={"on": {"x": "-lag*x + gain*cos(t)"}},
        period="2*pi",
        quadratures={"square": "x**2", "penetration": "3*x**2"},
        initial={"x": 0.5},
    )


@pytest.fixture(scope="module")
def starts():
    box = {"count": 200, "seed": 3, "x": (-10, 10), "y": (-10, 10), "z": (15, 30)}
    return {"random": box, "at": ABOVE, "exponents": 0, "transient": 20}


@pytest.mark.parametrize("length", [{"duration": 120}, {"periods": 120}])
def test_bars_of_a_chaotic_mean_cover_the_truth(lorenz, starts, length):
    """The two lobes are changed every few turns, so that the samples are correlated: bars of free ones would be off."""
    ds = cd.bifurcation_diagram(lorenz, {"sigma": [10.0]}, **starts, **length)
    mean, bar = ds["left_rate"].values.ravel(), ds["left_rate_error"].values.ravel()
    assert 0.88 <= np.mean(np.abs(mean) <= 1.96 * bar) <= 0.985
    assert np.median(bar) < 1.6 * mean.std()
    np.testing.assert_allclose(
        ds["product_rate"].values, 8 / 3 * ds["height_rate"].values, atol=60 / float(ds["return_time"].mean()) / 120
    )


@pytest.mark.parametrize(
    "measure",
    [
        lambda lorenz: cd.lyapunov_spectrum(lorenz, duration=600, transient=20),
        lambda lorenz: cd.lyapunov_spectrum(lorenz, periods=400, transient=20, at=ABOVE, exponents=0),
        lambda lorenz: cd.poincare_section(lorenz, periods=400, transient=20, at=ABOVE),
    ],
)
def test_single_runs_have_bars_too(lorenz, measure):
    ds = measure(lorenz)
    assert abs(float(ds["left_rate"])) < 4 * float(ds["left_rate_error"]) < 4
    # published: 23.55 (Sparrow 1982)
    assert float(ds["height_rate"]) == pytest.approx(23.55, abs=0.02 + 4 * float(ds["height_rate_error"]))


@pytest.mark.parametrize(
    "measure",
    [
        lambda system: cd.poincare_section(system, periods=37, transient=20),
        lambda system: cd.lyapunov_spectrum(system, periods=37, transient=20),
        lambda system: cd.bifurcation_diagram(system, {"gain": [1.0]}, periods=37, transient=20),
        lambda system: cd.parameter_chart(system, {"gain": [1.0], "lag": [1.0]}, periods=37, transient=20),
        lambda system: cd.periodic_orbit(system),
    ],
)
def test_a_cycle_has_its_closed_form_in_every_analysis(filtered, measure):
    ds = measure(filtered)
    assert float(np.ravel(ds["square_rate"])[0]) == pytest.approx(0.25, rel=1e-11)
    assert float(np.ravel(ds["progression_rate"])[0]) == pytest.approx(0.75, rel=1e-11)
    assert "penetration_rate" not in ds
    if "square_rate_error" in ds:
        assert 0 <= float(np.ravel(ds["square_rate_error"])[0]) < 1e-11
        assert 0 <= float(np.ravel(ds["progression_error"])[0]) < 1e-11


def test_a_cycle_that_fits_neither_record_nor_blocks_is_taken_whole():
    """A rotation by a fifth of a turn a strobe, over 128 strobes in blocks of 4: the mean square of x is 1/2."""
    turn = cd.HybridSystem(
        name="turn",
        states="x y",
        parameters={"w": 2 * np.pi / 5},
        modes={"on": {"x": "-w*y", "y": "w*x"}},
        period="1",
        quadratures={"square": "x**2"},
        initial={"x": 1.0, "y": 0.0},
    )
    ds = cd.bifurcation_diagram(turn, {"w": [2 * np.pi / 5]}, periods=128, transient=7)
    assert int(ds["period"].item()) == 5
    assert ds["square_rate"].item() == pytest.approx(0.5, rel=1e-11)
    assert ds["square_rate_error"].item() < 1e-11


def test_attractors_have_rates():
    """x' = x - x**3 has the attractors -1 and 1."""
    wells = cd.HybridSystem(
        name="wells",
        states="x y",
        parameters={},
        modes={"on": {"x": "x - x**3", "y": "-y"}},
        period="1",
        quadratures={"place": "x"},
        initial={"x": 1.0, "y": 0.1},
    )
    ds = cd.basins(wells, {"x": [-2.0, 0.5, 2.0], "y": [0.0, 0.1]}, periods=40, transient=40, max_period=4)
    np.testing.assert_allclose(ds["attractor_place_rate"], [1.0, -1.0], rtol=1e-12)
    np.testing.assert_allclose(ds["attractor_place_rate_error"], 0.0, atol=1e-12)


def test_rates_of_two_chaotic_runs_agree_within_their_bars(lorenz):
    one, other = (
        cd.lyapunov_spectrum(lorenz.with_initial(x=x), duration=200, transient=20, exponents=1) for x in (1.0, 1.1)
    )
    first, second = (xr.DataTree.from_dict({"run": ds}) for ds in (one, other))
    checks = {check.variable: check for check in examine(first, second, exact=False)[1]}
    assert checks["left_rate"].how == "within 8 standard errors"
    assert checks["left_rate"].agrees
    far = one.assign(left_rate=one["left_rate"] + 20 * np.hypot(one["left_rate_error"], other["left_rate_error"]))
    checks = {c.variable: c for c in examine(xr.DataTree.from_dict({"run": far}), second, exact=False)[1]}
    assert not checks["left_rate"].agrees


@pytest.mark.parametrize(
    ("quadratures", "parameters"),
    [({"work": "x", "work_rate": "x"}, {"a": 1.0}), ({"progression": "x"}, {"a": 1.0}), ({"a": "x"}, {"a_rate": 1.0})],
)
def test_names_that_mean_two_things_are_refused(quadratures, parameters):
    name = next(iter(parameters))
    system = cd.HybridSystem(
        name="twice",
        states="x",
        parameters=parameters,
        modes={"on": {"x": f"-{name}*x"}},
        quadratures=quadratures,
        initial={"x": 1.0},
    )
    with pytest.raises(ModelError, match=r"has the mean rate '.*', a name that is taken"):
        cd.parameter_chart(system, {name: [1.0], "x": [2.0]}, duration=1, transient=0)
