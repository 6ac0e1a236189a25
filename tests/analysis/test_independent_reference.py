"""Work-precision holds a method against what is no method that is judged, and tells where methods disagree."""

import numpy as np
import pytest
import xarray as xr
from scipy.integrate import solve_ivp

import chaosdrill as cd
from chaosdrill.analysis.precision import errors as precision_errors
from chaosdrill.analysis.precision.advice import contradictions, recommend

PERIODS, OMEGA, STEEP = 16, 0.8, 0.01


@pytest.fixture(scope="module")
def steep():
    """A mass with friction that is smoothed within 0.01 of speed."""
    return cd.HybridSystem(
        name="steep",
        states="x v",
        parameters={"w": OMEGA, "d": STEEP},
        period="2*pi/w",
        initial={"x": 1.0},
        modes={"all": {"x": "v", "v": "cos(w*t) - x - 0.3*tanh(v/d)"}},
    )


def measured(system, methods):
    given = {"periods": PERIODS, "transient": 20, "tolerances": [1e-6, 1e-10], "repeats": 1}
    return cd.work_precision(system, methods=methods, **given)


def growth_by_scipy(start, duration):
    """Rate of the area of two tangents, by short steps of another code: the sum of both exponents."""

    def rate(t, y):
        tanh = np.tanh(y[1] / STEEP)
        slope = -0.3 * (1 - tanh**2) / STEEP
        return [y[1], np.cos(OMEGA * t) - y[0] - 0.3 * tanh, slope]

    found = solve_ivp(rate, (0, duration), [*start, 0.0], "Radau", rtol=1e-9, atol=1e-11, max_step=0.02)
    return found.y[2, -1] / duration


@pytest.fixture(scope="module")
def known(steep):
    """The exponents are a complex pair, so that the leading one is half of the sum, which scipy knows."""
    cycle = cd.poincare_section(steep, transient=20, periods=4, method="dop853")["section"].values[-1]
    return growth_by_scipy(cycle, 4 * 2 * np.pi / OMEGA) / 2


@pytest.mark.parametrize("methods", [["taylor"], ["taylor", "dop853"]], ids="-".join)
def test_a_method_is_not_its_own_reference(steep, known, methods):
    ds = measured(steep, methods)
    references = dict(one.split(": ") for one in ds.attrs["reference_methods"].split("; "))
    assert set(references) == set(methods)
    assert all(name != other for name, other in references.items())
    assert float(ds["lyapunov_exponent"]) == pytest.approx(known, abs=4 * float(ds["lyapunov_error"]))
    for method in methods:
        spectrum = cd.lyapunov_spectrum(steep, transient=20, periods=32, method=method, tolerance=1e-10)
        right = abs(spectrum["lyapunov_exponent"].values.mean() - known) < 0.02 * abs(known)
        error = float(ds["error"].sel({"quantity": "exponent", "method": method, "tolerance": 1e-10}))
        assert (error < 1e-6) == right
        if not right:
            assert f"{method} is off by" in ds.attrs["recommendation"]
            assert f"use {method}" not in ds.attrs["recommendation"]


def test_a_faulty_method_is_told_as_a_disagreement(monkeypatch):
    """The growth by dop853 is falsified: of two methods each is off the other, and without a truth none is right."""
    plain = precision_errors.growth

    def falsified(found, unit, numerics):
        return plain(found, unit, numerics) + (0.01 if numerics.method == "dop853" else 0.0)

    monkeypatch.setattr(precision_errors, "growth", falsified)
    system = cd.build("duffing")
    ds = cd.work_precision(
        system, periods=8, transient=20, methods=["taylor", "dop853"], tolerances=[1e-6, 1e-10], repeats=1
    )
    line = next(one for one in ds.attrs["recommendation"].splitlines() if "leading exponent" in one)
    assert line.startswith(
        "methods disagree about the leading exponent beyond their errors, so that none is recommended"
    )
    assert "off by 0.01 at 1e-10" in line


def made_up(errors, fixed=0):
    """Multipliers by two methods at three tolerances: the errors of the first are the tolerances."""
    tolerances = [1e-4, 1e-8, 1e-12]
    grid = ("method", "tolerance")
    return xr.Dataset(
        {
            "error": (("quantity", *grid), [[tolerances, errors]]),
            "wall_time": (grid, np.full((2, 3), 1e-5)),
            "steps_per_period": (grid, [[0] * 3, [fixed] * 3]),
            "horizon": (grid, np.full((2, 3), np.nan)),
            "lyapunov_exponent": -0.1,
            "lyapunov_error": 0.0,
        },
        {"quantity": ["multiplier"], "method": ["series", "steps"], "tolerance": tolerances},
    )


@pytest.mark.parametrize("errors", [[0.3, 0.31, 0.3], [np.inf, np.inf, np.inf], [0.5, 0.2, 0.1]])
def test_an_error_that_no_tolerance_reduces_is_a_disagreement(errors):
    told = recommend(made_up(errors))
    assert told.startswith(
        "methods disagree about the multipliers beyond their errors, so that none is recommended: steps"
    )
    assert "use " not in told


@pytest.mark.parametrize("errors", [[0.3, 3e-4, 3e-8], [3e-7, 3e-7, 3e-7], [np.nan] * 3])
def test_an_error_that_falls_or_is_small_is_none(errors):
    assert contradictions(made_up(errors), "multiplier") == ""


def test_fixed_steps_have_errors_of_their_own():
    assert contradictions(made_up([0.3, 0.3, 0.3], fixed=200), "multiplier") == ""
