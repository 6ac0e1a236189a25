"""The study of hard cases judges its figures rightly, has every case, and the documentation is made from it."""

import importlib
import math
import re
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "studies" / "hard_cases"


@pytest.fixture(scope="module")
def study():
    sys.modules.pop("make", None)
    sys.path.insert(0, str(FOLDER))
    yield importlib.import_module("make")
    sys.path.remove(str(FOLDER))
    sys.modules.pop("make")


@pytest.fixture(scope="module")
def finding(study):
    return study.Finding


def test_a_figure_holds_within_its_bound_and_not_beyond(finding):
    assert finding("x", 100.0, 100.1, 1.1e-3).holds
    assert not finding("x", 100.0, 100.2, 1.1e-3).holds
    assert finding("x", 1e-3, 1.1e-3, 1.1e-4).holds
    assert not finding("x", 1e-3, 1.2e-3, 1.1e-4).holds


@pytest.mark.parametrize("ours", [math.nan, 0.0, -38.9, math.inf])
def test_minus_infinity_is_nothing_else(finding, ours):
    assert finding("x", -math.inf, -math.inf).holds
    assert not finding("x", -math.inf, ours, 1e3).holds


def test_words_are_equal_or_not(finding):
    assert finding("x", "stick release", "stick release").holds
    assert not finding("x", "stick release", "stick", 1e3).holds


def test_every_case_has_a_title_a_description_and_a_test(study):
    cases = study.cases()
    text = (ROOT / "tests" / "hard_cases" / "test_cases.py").read_text(encoding="utf-8")
    tested = {
        int(number) for number in re.findall(r"^# Case (\d+): .*\n\n\n?(?:.*\n)*?def test_", text, flags=re.MULTILINE)
    }
    assert set(cases) == tested
    for case in cases.values():
        assert study.title(case)
        assert len(study.prose(case)) > 100


def test_a_case_runs_and_holds(study):
    findings = study.cases()[4].findings()
    assert all(figure.holds for figure in findings)
    assert [figure.elsewhere[:6] for figure in findings if figure.elsewhere] == ["RK45 0", "RK45 0"]


def test_the_page_has_the_words_of_every_case(study):
    page = study.PAGE.read_text(encoding="utf-8")
    for number, case in study.cases().items():
        assert f"## {number}. {study.title(case)}\n\n{study.prose(case)}\n" in page
