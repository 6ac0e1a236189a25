"""The study of the procedure judges rightly: forces of hits, which orbits count, and which is the best."""

import runpy
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from scipy.integrate import solve_ivp

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def make():
    return runpy.run_path(str(ROOT / "studies" / "procedure" / "make.py"))


@pytest.mark.parametrize(("speed", "lam", "stiffness"), [(0.4, 0.6, 2.4e6), (1.5, 0.1, 1e3), (0.05, 2.0, 1e5)])
def test_the_peak_force_is_that_of_an_integrated_contact(make, speed, lam, stiffness):
    def field(t, s):
        return [s[1], -stiffness * s[0] * (1 + lam * s[1])]

    run = solve_ivp(field, (0, 2 / np.sqrt(stiffness)), [0, speed], rtol=1e-11, atol=1e-14, dense_output=True)
    depth, rate = run.sol(np.linspace(0, run.t[-1], 20_001))
    assert make["contact_peak"](speed, lam, stiffness) == pytest.approx(
        (stiffness * depth * (1 + lam * rate)).max(), rel=1e-7
    )


@pytest.fixture
def curve():
    """Six orbits, of which the second to the fourth are stable; the fifth is where they cease to be."""
    rates = [9.0, 1.0, 3.0, 2.0, 4.0, 8.0]
    return xr.Dataset(
        {
            "stable": ("point", np.array([0, 1, 1, 1, 0, 0], dtype=np.int8)),
            "function_value": (("point", "function"), np.array([np.ones(6), rates]).T),
            "special_index": ("special", [0, 4]),
            "special_kind": (
                "special",
                np.array([5, 2]),
                {"flag_meanings": "regular fold period_doubling a b optimum"},
            ),
        },
        {"function": ["force", "rate"], "special_text": ("special", ["rate has a maximum of 9", "doubles"])},
    )


def test_the_best_is_stable_or_where_stability_ends(make, curve):
    assert make["usable"](curve).tolist() == [False, True, True, True, True, False]
    assert make["best_of"](curve) == (4, "doubles")
    assert make["best_of"](curve.isel(special=[0])) == (2, "a point of the curve")


def test_the_page_has_the_picture_and_the_text():
    page = (ROOT / "docs" / "procedure.md").read_text(encoding="utf-8")
    parts = (
        (ROOT / "studies" / "procedure" / "page.md").read_text(encoding="utf-8").replace("OFF", "TABLE").split("TABLE")
    )
    assert all(part in page for part in parts)
    assert (ROOT / "docs" / "_static" / "procedure_best.png").is_file()
