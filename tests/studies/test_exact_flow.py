"""The closed form that is timed against the series solves the same system."""

import importlib
import sys
from pathlib import Path

import numpy as np
import pytest

import chaosdrill as cd
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run

FOLDER = Path(__file__).parents[2] / "studies" / "accuracy"


@pytest.fixture(scope="module")
def study():
    sys.path.insert(0, str(FOLDER))
    yield importlib.import_module("exact_flow")
    sys.path.remove(str(FOLDER))


def test_impacts_are_the_same_with_the_engine_and_without(study):
    results = study.compare(rounds=1, periods=50)
    # chaos makes the tolerance of 1e-12 grow over twenty impacts
    assert results["largest difference"] < 3e-9


def test_tangents_are_the_same(study):
    study.install()
    system = cd.build("impact-oscillator")
    period = system.forcing_period()
    runs = [study.engine_run(system, 2, exact=True), Run(system, period, Numerics("taylor", 1e-13), tangents=np.eye(2))]
    for run in runs:
        run.advance(2000)
    exact, series = (run.logs / run.elapsed for run in runs)
    # trajectories differ after some thirty impacts, but their sum is fixed by the number of impacts
    impacts = [run.counts[0] for run in runs]
    expected = [-0.1 + 2 * np.log(0.8) * n / run.elapsed for n, run in zip(impacts, runs, strict=True)]
    np.testing.assert_allclose([exact.sum(), series.sum()], expected, atol=1e-12)
    assert exact[0] == pytest.approx(series[0], abs=0.03)
