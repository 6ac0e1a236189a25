"""A reset or a rate that divides by zero is an outcome, never a warning of a library."""

import warnings

import pytest

import chaosdrill as cd
from chaosdrill.dataset import Outcome

ANALYSES = {
    "trajectory": lambda system: cd.trajectory(system, periods=3),
    "spectrum": lambda system: cd.lyapunov_spectrum(system, periods=20, transient=5),
    "diagram": lambda system: cd.bifurcation_diagram(system, {"k": [0.0]}, transient=5, periods=5),
    "orbit": lambda system: cd.periodic_orbit(system),
}


@pytest.fixture(scope="module")
def divided():
    """A forced oscillator whose speed after an event is divided by k, which is zero."""
    return cd.HybridSystem(
        name="divided",
        states=["x", "v"],
        time="t",
        parameters={"k": 0.0},
        modes={"free": {"x": "v", "v": "-x - v/10 + cos(t)"}},
        transitions=[cd.Transition("hit", "free", "free", guard="x", direction=-1, reset={"v": "-v/k"})],
        period="2*pi",
        initial={"x": 1.0},
    )


@pytest.mark.parametrize("analysis", ANALYSES)
def test_it_has_an_outcome_and_pages_and_pictures(divided, tmp_path, analysis):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = ANALYSES[analysis](divided)
        path = cd.save(found, tmp_path / "a.nc")
        assert cd.report(path).faults == ()
    assert set(found["outcome"].values.ravel().tolist()) == {Outcome.NONFINITE}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert cd.verify(path).equal
