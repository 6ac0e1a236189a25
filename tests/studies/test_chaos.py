"""The study of chaos judges rightly: forces of hits, what counts as a transient, parts below zero, ends of starts."""

import importlib
import re
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

STUDIES = Path(__file__).parents[2] / "studies"


@pytest.fixture(scope="module")
def module():
    folders = [str(STUDIES / name) for name in ("chaos", "charts")]
    sys.path[:0] = folders
    yield importlib.import_module
    for folder in folders:
        sys.path.remove(folder)


def test_the_peak_force_is_that_of_an_integrated_hit(module):
    # F = k d (1 + lam d') of a mass 1 against a wall, from a run in fixed steps outside of the project
    assert module("percent").peak_force(1.0, 0.3, 1e6, 0.0) == pytest.approx(947.613, rel=1e-5)


def test_the_edge_of_a_density_is_told_by_the_smallest_values(module):
    rng, edge_of = np.random.default_rng(0), module("attractor").edge_of
    samples = 0.13 + 0.5 * np.sqrt(rng.random((400, 5, 1000)))
    edges, errors = np.array([edge_of(one.tolist()) for one in samples.min(axis=2)]).T
    assert (np.abs(edges - 0.13) <= 2 * errors).mean() > 0.9
    # the smallest value alone is beyond it
    assert abs(np.median(edges) - 0.13) < np.median(samples.min(axis=(1, 2)) - 0.13) / 4


def test_free_masses_hit_as_one_of_their_relative_mass(module):
    force = module("percent").peak_force
    eps = 0.7
    # (1 + eps) F(free) is the force on the relative mass 1 with the stiffness (1 + eps) k
    assert (1 + eps) * force(0.4, 0.6, 2e5, eps) == pytest.approx(force(0.4, 0.6, (1 + eps) * 2e5, 0.0), rel=1e-12)
    assert force(0.4, 1e-9, 2e5, eps) == pytest.approx(0.4 * np.sqrt(2e5 / (1 + eps)), rel=1e-8)


@pytest.mark.parametrize(
    ("old", "left", "drift", "decays", "stays"),
    [
        (80, 80, 1.0, True, False),
        (80, 79, 1.0, False, False),
        (80, 80, 4.0, False, False),
        (80, 0, np.nan, False, True),
    ],
)
def test_a_rate_needs_that_all_leave_alike(old, left, drift, decays, stays, module):
    lives = module("lives")
    line = xr.Dataset({key: ("b", [value]) for key, value in {"old": old, "left": left, "drift": drift}.items()})
    assert lives.decays(line).tolist() == [decays]
    assert lives.stays(line).tolist() == [stays]


def test_the_part_below_zero_of_a_normal_density(module):
    centres = np.linspace(-4.9, 5.3, 103)
    density = np.exp(-((centres - 0.5) ** 2) / 2) / np.sqrt(2 * np.pi)
    growth = xr.Dataset({"bin_centre": ("bin", centres), "histogram": ("bin", density)})
    assert module("attractor")._below_zero(growth) == pytest.approx(0.30854, abs=1e-3)


def test_the_error_of_the_dimension_bounds_that_of_correlated_exponents(module):
    exponent, error = np.array([0.0151, -0.0879]), np.array([1e-4, 3e-4])
    bound = module("attractor").dimension_error(exponent, error)
    moved = [1 + (exponent[0] + a * error[0]) / -(exponent[1] + b * error[1]) for a in (-1, 1) for b in (-1, 1)]
    assert bound == pytest.approx(max(np.abs(np.array(moved) - 1 + exponent[0] / exponent[1])), rel=0.01)


def test_starts_end_fast_slow_or_away(module):
    outcome = xr.Variable(
        ("b", "run"),
        [[1, 1, 4, 9, 1]],
        {"flag_values": np.arange(10, dtype="i1"), "flag_meanings": "ok periodic a b escaped c d e f invalid_start"},
    )
    found = xr.Dataset(
        {
            "attractor_rate": (("b", "attractor"), [[0.2, 0.01, 0.05]]),
            "reached": (("b", "run"), [[1, 2, 0, 0, 3]]),
            "outcome": outcome,
        },
        {"attractor": [1, 2, 3], "b": [0.7]},
    )
    assert module("shares").ends(found).values.tolist() == [[0, 1, 2, -1, 3]]


def test_the_page_claims_only_what_was_found():
    docs = STUDIES.parent / "docs"
    page = (docs / "chaos.md").read_text(encoding="utf-8")
    text = (STUDIES / "chaos" / "page.md").read_text(encoding="utf-8")
    assert all(part in page for part in re.split(r"{{\w+}}\n", text))
    lines = [line for line in page.splitlines() if line.startswith("|")]
    assert sum(line.endswith("| yes |") for line in lines) > 20
    assert not any(line.endswith("| no |") for line in lines)
    for name in re.findall(r"_static/(chaos_\w+\.png)", page):
        assert (docs / "_static" / name).is_file()
