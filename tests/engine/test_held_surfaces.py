"""Many runs on surfaces that modes hold are those runs one by one; so is a run in slices."""

import numpy as np
import pytest

import chaosdrill as cd
from chaosdrill.dataset import Outcome
from chaosdrill.engine.batch import Batch
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run
from chaosdrill.engine.structure import examine

FALLS = np.linspace(2.6, 3.4, 11)
PERIODS = 9


@pytest.fixture(scope="module")
def kicked():
    """Slides on x + tau*v = 0, is kicked off it once a period, and falls back; y follows x."""
    rates = {"x": "v", "y": "-0.3*y + sin(x)"}
    return cd.HybridSystem(
        name="kicked",
        states="x v y",
        parameters={"tau": 0.6, "kick": 4.0, "fall": 3.0, "w": 2.0},
        modes={"on": {**rates, "v": "-v/tau - 0.2*(x + tau*v)"}, "off": {**rates, "v": "-fall"}},
        transitions=[
            cd.Transition("kicked", "on", "off", "cos(w*t) + 0.2*x", -1, reset={"v": "v + kick"}),
            cd.Transition("lands", "off", "on", "x + tau*v", -1),
        ],
        period="2*pi/w",
        initial={"mode": "on", "x": 0.6, "v": -1.0, "y": 0.1},
    )


def frame_of(system, count):
    structure = examine(system)
    frame, symmetries = structure.tangents(count)
    return {"tangents": frame, "symmetries": symmetries, "deficient": structure.deficient}


def batch(system, falls, numerics, transient, count):
    starts = np.tile([system.initial[x] for x in system.state_names], (len(falls), 1))
    modes = np.zeros(len(falls), dtype=int)
    made = Batch(system, {"fall": falls}, starts, modes, numerics, **frame_of(system, count))
    made.run(transient, np.array([0, PERIODS]))
    return made


@pytest.mark.parametrize("count", [1, 2, 3])
@pytest.mark.parametrize("transient", [0, 4])
@pytest.mark.parametrize("method", ["taylor", "dop853"])
def test_many_runs_are_those_runs_one_by_one(kicked, method, transient, count):
    numerics = Numerics(method, 1e-12)
    together = batch(kicked, FALLS, numerics, transient, count)
    for p, fall in enumerate(FALLS):
        alone = batch(kicked, FALLS[p : p + 1], numerics, transient, count)
        assert np.array_equal(alone.x[0], together.x[p])
        assert np.array_equal(alone.sums[0], together.sums[p])
        system = kicked.with_parameters(fall=float(fall))
        run = Run(system, system.forcing_period(), numerics, **frame_of(system, count))
        run.advance(transient)
        run.forget()
        assert run.advance(PERIODS)[0] == together.outcome[p] == Outcome.OK
        found = np.where(run.lost[:count] == 1, -np.inf, run.logs[:count])
        assert together.sums[p, -1] == pytest.approx(found, abs=1e-6)
        assert np.isneginf(found).sum() == max(0, count - 2)


def test_slices_change_nothing(kicked):
    whole, sliced = (
        Run(kicked, kicked.forcing_period(), Numerics("taylor", 1e-12), **frame_of(kicked, 3)) for _ in range(2)
    )
    whole.advance(PERIODS, samples=np.zeros((100, 4)))
    full, rows = True, 0
    while full or rows < PERIODS:
        full = sliced.advance(PERIODS if not rows else 0, samples=np.zeros((2, 4)))[1]
        rows += sliced.filled()[0]
    assert np.array_equal(whole.x, sliced.x)
    assert np.array_equal(whole.vectors, sliced.vectors)
    assert np.array_equal(whole.logs, sliced.logs)


@pytest.mark.parametrize("tangents", [np.eye(3), [[1.0, 0.0, 0.0]], [[0.3, -0.5, 2.0]]], ids=str)
def test_given_tangents_lose_what_the_surface_takes(kicked, tangents):
    """In units in which tau is one, what is across the surface is across it at once; the rest are differences."""
    system = kicked.with_parameters(tau=1.0)
    rows = np.array(tangents, dtype=float)
    run = Run(system.with_initial(x=1.0, v=-1.0), 0.5, Numerics(), tangents=rows, orthonormalise=False)
    run.advance(1)
    assert run.mode == "on"
    along = (rows[:, 0] - rows[:, 1]) / 2
    ends = []
    for step in (1e-6, -1e-6):
        beside = system.with_initial(x=1.0 + step, v=-1.0 - step)
        ends.append(Run(beside, 0.5, Numerics()))
        ends[-1].advance(1)
    expected = along[:, np.newaxis] * (ends[0].x - ends[1].x) / 2e-6
    expected[:, 2] += rows[:, 2] * np.exp(-0.3 * 0.5)
    assert run.vectors == pytest.approx(expected, abs=1e-9)
