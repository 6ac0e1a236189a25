"""The drill's curves over frequency and static load, against independent values, the ordinary engine and branches."""

import numpy as np
import pytest
from support.following import followed

import chaosdrill as cd
from chaosdrill.dataset import Outcome
from chaosdrill.dataset.branches import Special
from chaosdrill.engine.layout import EVENT_COLUMNS
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run
from chaosdrill.orbits.branches import branches

SAMPLES = 20_000
LIMITS = {"eta": (0.40, 0.90), "b": (0.60, 0.79)}


@pytest.fixture(scope="module")
def drill():
    return cd.drill(drive="harmonic", friction="stribeck", rock="moving", contact="hunt-crossley", xi=0.06)


@pytest.fixture(scope="module")
def doubling(drill):
    return followed(drill.with_parameters(eta=0.78), LIMITS, "period_doubling", 0.01)


@pytest.fixture(scope="module")
def grazing(drill):
    return followed(drill.with_parameters(eta=0.78), LIMITS, "grazing", 0.01)


def at_point(drill, result, k, eta=0.0):
    """The system at a point of a curve, or at a frequency beside it, started on its orbit."""
    values = dict(zip(result.parameters, result.values[k], strict=True))
    state = dict(zip(drill.state_names, result.section[k, 0], strict=True))
    system = drill.with_parameters(eta=values["eta"] + eta, b=values["b"])
    return system.with_initial(mode=drill.mode_names[result.mode[k]], **state)


def spread(result, count):
    return np.linspace(0, len(result.values) - 1, count + 2)[1:-1].astype(int).tolist()


def test_the_curves_start_where_independent_values_say(doubling, grazing):
    # own Taylor series in 34 digits
    known = {0: 0.76452469484555915, 1: 0.45532342522408643}
    for number, result in enumerate((doubling, grazing)):
        (start,) = (e for e in result.events if e.text == "the curve was followed from here")
        assert abs(start.values[0] - known[number]) < 1e-10
        assert start.error < 1e-10


def test_a_multiplier_of_the_ordinary_engine_is_minus_one(drill, doubling):
    for k in spread(doubling, 6):
        system = at_point(drill, doubling, k)
        run = Run(system, system.forcing_period(), Numerics(), tangents=np.eye(3), orthonormalise=False)
        assert run.advance(1)[0] == Outcome.OK
        assert np.abs(run.x - doubling.section[k, 0]).max() < 1e-10
        assert np.abs(np.linalg.eigvals(run.vectors.T) + 1).min() < 1e-8


def test_branches_at_other_loads_double_there(drill, doubling):
    for k in spread(doubling, 4):
        eta = doubling.values[k, 0]
        system = at_point(drill, doubling, k, 1e-3)
        found = branches(system, "eta", (eta - 4e-3, eta + 4e-3), 1, "guess", 0, 0, 1e-3, 100, Numerics(), None)
        places = [e.values[0] for e in found.events if e.code == Special.PERIOD_DOUBLING]
        assert np.abs(np.array(places) - eta).min() < 1e-10


def test_the_ordinary_engine_touches_the_stop(drill, grazing):
    usual = np.flatnonzero(grazing.sequence == np.bincount(grazing.sequence).argmax())
    for k in usual[np.linspace(0, len(usual) - 1, 6)[1:-1].astype(int)].tolist():
        system = at_point(drill, grazing, k)
        run = Run(system, system.forcing_period(), Numerics(), samples=SAMPLES)
        samples = np.zeros((2 * SAMPLES, 3 + len(system.quadratures) + 1))
        assert run.advance(1, samples, np.zeros((64, EVENT_COLUMNS + 6))) == (Outcome.OK, False)
        y = samples[: run.filled()[0], 0]
        tops = np.flatnonzero((y[2:-2] > y[1:-3]) & (y[2:-2] >= y[3:-1])) + 2
        fits = [np.polyfit([-1, 0, 1], y[t - 1 : t + 2], 2) for t in tops]
        heights = np.array([np.polyval(fit, -fit[1] / (2 * fit[0])) for fit in fits])
        assert np.abs(heights - system.parameters["r"]).min() < 1e-9


def test_the_curve_of_grazing_goes_on_where_another_event_begins(grazing):
    usual = np.bincount(grazing.sequence).argmax()
    appear = [e for e in grazing.events if e.text == "release and stick appear; the curve continues"]
    (junction,) = (e for e in appear if usual in grazing.sequence[e.point - 1 : e.point + 2])
    assert junction.code == Special.GRAZING
    beyond = grazing.values[grazing.sequence != grazing.sequence[junction.point]]
    assert len(beyond) > 2
    assert np.linalg.norm(beyond - junction.values, axis=1).min() < 1e-4
    # the ordinary engine sees the slip that began
    assert grazing.message == ""


def test_doubled_orbits_stop_grazing_where_the_single_one_doubles_and_grazes(drill):
    limits = {"eta": (0.40, 0.90), "b": (0.55, 0.85)}
    single = followed(drill.with_parameters(eta=0.54), limits, "period_doubling", 0.01)
    double = followed(drill.with_parameters(eta=0.6), limits, "grazing", 0.01, period=2)
    there = single.values[[0, -1]]
    ends = double.values[[0, -1]]
    assert np.linalg.norm(there[:, np.newaxis] - ends, axis=-1).min() < 1e-5
    assert "doubled orbit" in double.branches[0].end
