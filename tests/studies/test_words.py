"""The study of words makes records of the kinds that it names, and none of them is called wrongly."""

import importlib
import sys
from pathlib import Path

import numpy as np
import pytest

FOLDER = Path(__file__).parents[2] / "studies" / "words"
OWN = ("make", "borders", "records", "runs")


@pytest.fixture(scope="module")
def make():
    for name in OWN:
        sys.modules.pop(name, None)
    sys.path.insert(0, str(FOLDER))
    yield importlib.import_module("make")
    sys.path.remove(str(FOLDER))
    for name in OWN:
        sys.modules.pop(name, None)


def test_records_are_called_rightly_in_any_units(make):
    few, length = 9, 1024
    for name, (family, right) in make.FAMILIES.items():
        rng = np.random.default_rng([7, *name.encode()])
        states, growth, *_ = family(rng, few, length)
        units = np.resize([1.0, 1e-9, 1e9], (few, 1, 1))
        assert set(make.called(states * units, growth)) <= make.OPEN_ANSWERS | {right}, name


def test_growth_is_that_of_the_map(make):
    """Of skew tents it is the entropy of the lengths of their two sides, of the standard map it sums to zero."""
    families = {name: family for name, (family, _) in make.FAMILIES.items()}
    rng = np.random.default_rng(3)
    _, growth = families["tents"](rng, 1, 4000)
    sides = np.exp(-np.unique(np.round(growth, 12)))
    assert sides.sum() == pytest.approx(1, abs=1e-9)
    assert growth.mean() == pytest.approx(-(sides * np.log(sides)).sum(), abs=0.03)
    assert np.abs(families["seas"](rng, 3, 200)[1].sum(axis=2)).max() < 1e-9


def test_runs_are_called_rightly(make):
    """Flows without forcing, events, surfaces and the drill."""
    for name, (family, right) in make.RUN_FAMILIES.items():
        said, too_short = make.called_by_spectra(family, np.random.default_rng([7, *name.encode()]), 2, 256)
        assert set(said) <= make.OPEN_ANSWERS | {right}, name
        assert len(too_short) == 2


def test_kept_words_are_those_of_the_code(make, monkeypatch, tmp_path):
    """A change of the package or of the study makes words anew."""
    (tmp_path / "__init__.py").write_text("")
    (tmp_path / "rules.py").write_text("LEAST = 1\n")
    monkeypatch.setattr(make.chaosdrill, "__file__", str(tmp_path / "__init__.py"))
    before = make.digest()
    assert make.digest() == before
    (tmp_path / "rules.py").write_text("LEAST = 2\n")
    assert make.digest() != before
