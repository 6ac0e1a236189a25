"""The study of charts judges rightly: its outside program, its closed forms, its comparison of rates."""

import importlib
import math
import re
import sys
from pathlib import Path

import numpy as np
import pytest

import chaosdrill as cd

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "studies" / "charts"
DRILL = {"a": 0.25, "b": 0.7, "xi": 0.06, "eps": 1.0, "mu": 0.6, "g": 3.0, "r": 1.0, "lam": 0.6, "phi": math.pi / 2}


@pytest.fixture(scope="module")
def module():
    sys.modules.pop("make", None)
    sys.path.insert(0, str(FOLDER))
    yield importlib.import_module
    sys.path.remove(str(FOLDER))
    sys.modules.pop("make", None)


@pytest.fixture(scope="module")
def chart():
    """Eight by four points, of which some stand still, drill, are chaotic and run away."""
    sweep = {"eta": [0.448, 0.5, 0.6, 0.63, 0.66, 0.75, 0.8, 1.0], "b": [0.4, 0.6, 0.7, 1.02]}
    return cd.parameter_chart(cd.drill(**DRILL), sweep, transient=300, periods=200, exponents=2, tolerance=1e-10)


@pytest.mark.parametrize(
    ("eta", "period", "rate", "strobe"),
    [
        (0.8, 1, 0.1163908540290498, [0.5117707419326684, 0.2579689590074009, 0.3668787222623992]),
        (0.6, 2, 0.1591797435744490, [0.9600731434657304, 0.4240583758953005, 0.5379459585801125]),
        (0.63, 4, 0.1362474287134805, [0.7201005283205294, 0.1022519359120029, 0.0687759307641452]),
    ],
)
def test_the_outside_program_knows_the_cycles(eta, period, rate, strobe, module):
    program = module("fixed_step")
    found, _, strobes, _ = program.run(program.parameters(**DRILL, eta=eta, k=12e5), np.zeros(3), 300, 64, 1e-7)
    assert program.period_of(strobes, 16) == period
    assert found == pytest.approx(rate, abs=1e-7)
    assert np.abs(strobes - strobe).max(axis=1).min() < 1e-6


def test_its_impacts_obey_the_contact_law(module):
    program = module("fixed_step")
    assert program._exit_speed(1.0, 0.3) == pytest.approx(0.8328697922656, abs=1e-12)
    law = program.parameters(**{**DRILL, "lam": 0.3}, eta=1.0, k=1e6)
    assert program._peak_force(1.0, law) == pytest.approx(947.613, rel=1e-4)


def test_the_standing_limit_is_the_response_of_a_linear_oscillator(module):
    eta, xi = np.array([0.3, 0.8, 1.0, 1.7]), 0.06
    spring_and_damper = 1 + 2j * xi * eta
    force = spring_and_damper / (spring_and_damper - eta**2)
    limit = module("limits").standing_limit(eta, 0.25, xi)
    np.testing.assert_allclose(limit, 1 - 0.25 * np.abs(force), rtol=1e-14)


def test_a_chart_obeys_the_closed_forms_and_a_spoiled_one_does_not(module, chart):
    forms = module("limits")
    claims = forms.standing(chart, "chart") + forms.running_away(chart, "chart")
    assert len(claims) == 5
    assert [claim.text for claim in claims if not claim.holds] == []
    spoiled = chart.copy(deep=True)
    spoiled["events_per_period"][:] = 0
    assert not forms.standing(spoiled, "chart")[0].holds
    spoiled["outcome"][0, 0] = chart["outcome"].sel(eta=0.8, b=1.02).values
    assert not forms.running_away(spoiled, "chart")[0].holds


def test_known_regimes_come_out_of_the_nearest_points(module, chart):
    regimes = module("known_regimes")
    assert all(claim.holds for claim in regimes.claims({0.06: chart}))
    assert not all(claim.holds for claim in regimes.claims({0.12: chart}))


def test_points_are_computed_again_and_compared(module, chart):
    agreement = module("agreement")
    found = agreement.compare(chart, 12)
    assert len({tuple(point[0].values()) for point in found}) == 12
    assert all(claim.holds for claim in agreement.claims({"chart": found}))
    wrong = agreement.Point("period 1", 0.1)
    assert not agreement.same(wrong, agreement.Point("period 2", 0.1))
    assert not agreement.same(wrong, agreement.Point("period 1", 0.1002))
    assert not agreement.same(wrong, agreement.Point("chaotic", 0.1))
    assert agreement.same(agreement.Point("attracting", 0.1), wrong)


def test_pairs_and_windows_of_chaos_between_cycles(module):
    rates = module("rates")
    chaotic = np.array([[0, 1, 1, 0, 0, 1], [1, 0, 1, 0, 1, 0]], dtype=bool).T
    cycle = np.array([[1, 0, 0, 1, 0, 0], [0, 1, 0, 1, 0, 0]], dtype=bool).T
    beside = {(chaos, other) for chaos, other in rates.pairs(chaotic, cycle)}
    assert beside == {
        ((1, 0), (0, 0)), ((2, 0), (3, 0)), ((0, 1), (1, 1)), ((2, 1), (1, 1)), ((2, 1), (3, 1)), ((4, 1), (3, 1))
    }  # fmt: skip
    assert rates.windows(chaotic, cycle) == [(range(1, 3), 0), (range(2, 3), 1)]


def test_rates_differ_only_beyond_their_errors(module):
    one = np.ones(4)
    found = module("rates").Comparison(one, one, np.array([1.2, 0.8, 1.2, 1.0]), np.array([0.05, 0.05, 0.1, 0]), one)
    assert found.faster.tolist() == [True, False, False, False]
    assert found.slower.tolist() == [False, True, False, False]
    assert found.row("all")[1:5] == ["4", "1", "1", "2"]


def test_chaos_is_averaged_over_runs_that_agree(module, chart):
    rates = module("rates")
    spectrum = cd.lyapunov_spectrum(cd.drill(**DRILL | {"b": 0.6}, eta=0.66), periods=8000, transient=300, exponents=1)
    mean, error = rates.long_rates(chart, {(4, 1)}, 1000)[4, 1]
    apart = math.hypot(error, float(spectrum["progression_error"]))
    assert 0 < error < 0.01 * mean
    assert mean == pytest.approx(float(spectrum["progression_rate"]), abs=4 * apart)


def test_followed_by_either_program_both_motions_stay(module):
    branches = module("branches")
    system = cd.drill(**DRILL | {"xi": 0.12}, eta=0.52)
    etas = np.linspace(0.5, 0.56, 13)
    diagram = cd.bifurcation_diagram(system, {"eta": etas}, transient=300, periods=128, follow="both", exponents=2)
    found = {stretch.name: stretch for stretch in branches.stretches(diagram)}
    assert found["slow, period 1, upper"].last == 0.54
    assert found["fast, period 1"].first == 0.5
    slow = branches.follow({**DRILL, "xi": 0.12, "k": 12e5}, etas, diagram["section"].values[0, 0, -1], transient=200)
    np.testing.assert_allclose(slow, diagram["progression_rate"].values[:, 0], atol=1e-5)


def test_the_page_claims_only_what_was_found(module):
    make = module("make")
    page = (ROOT / "docs" / "charts.md").read_text(encoding="utf-8")
    text = (FOLDER / "page.md").read_text(encoding="utf-8")
    assert all(part in page for part in re.split(r"{{\w+}}\n", text))
    lines = [line for line in page.splitlines() if line.startswith("|")]
    assert sum(line.endswith("| yes |") for line in lines) > 20
    assert not any(line.endswith("| no |") for line in lines)
    for picture in make.PICTURES:
        name = f"charts_{picture.replace('-', '_')}.png"
        assert name in page
        assert (ROOT / "docs" / "_static" / name).is_file()
