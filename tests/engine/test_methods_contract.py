"""Every method's error on states, event times and tangents is what its tolerance or its step promises."""

import numpy as np
import pytest
from support.closed_forms import growth_with_harvest, impact_oscillator

from chaosdrill.analysis.registry import FIXED_STEP
from chaosdrill.dataset import Outcome
from chaosdrill.engine import layout as at
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run

TOLERANCES = [1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14]
ADAPTIVE = sorted(set(at.METHOD_CODES) - set(FIXED_STEP))
ORDERS = {"rk4": 4}
CURVED = (impact_oscillator, growth_with_harvest)
"""Cases whose arcs are no polynomials, so that no method is exact."""


def errors(case, solution, numerics):
    """Largest errors of the state at the end, of the event times and of the tangents; the run."""
    state, times, rows = solution
    run = Run(case.system, case.length, numerics, tangents=np.eye(len(state)), orthonormalise=False)
    events = np.zeros((len(times) + 5, at.EVENT_COLUMNS + 2 * len(state)))
    assert run.advance(1, events=events)[0] == Outcome.OK
    assert run.filled()[1] == len(times)
    found = events[: len(times), at.EVENT_TIME]
    pairs = ((run.x, state), (found, times), (run.vectors, rows))
    return np.array([np.abs(a - b).max() for a, b in pairs]), run


@pytest.mark.parametrize("tolerance", TOLERANCES)
@pytest.mark.parametrize("method", ADAPTIVE)
def test_errors_stay_near_the_tolerance(closed_form, method, tolerance):
    found, _ = errors(*closed_form, Numerics(method, tolerance))
    # beside the tolerance stands the round-off of a hundred evaluations, five events on
    assert found.max() < 3 * tolerance + 2e-13


@pytest.mark.parametrize("closed_form", CURVED, indirect=True)
@pytest.mark.parametrize("tolerance", TOLERANCES)
def test_the_error_of_a_series_follows_the_tolerance_within_a_factor_of_100(closed_form, tolerance):
    found, _ = errors(*closed_form, Numerics("taylor", tolerance))
    assert tolerance / 100 < found.max() < tolerance


@pytest.mark.parametrize("closed_form", CURVED, indirect=True)
def test_eight_more_digits_of_a_series_cost_less_than_two_and_a_half_times(closed_form):
    cheap, dear = (errors(*closed_form, Numerics("taylor", tolerance))[1] for tolerance in (1e-6, 1e-14))
    assert dear.evaluations < 2.5 * cheap.evaluations
    assert dear.steps < 1.5 * cheap.steps


@pytest.mark.parametrize("closed_form", CURVED, indirect=True)
def test_runge_kutta_of_order_eight_follows_its_tolerance(closed_form):
    runs = [errors(*closed_form, Numerics("dop853", tolerance)) for tolerance in TOLERANCES[:-1]]
    largest = np.log([found.max() for found, _ in runs])
    assert np.polyfit(np.log(TOLERANCES[:-1]), largest, 1)[0] == pytest.approx(1, abs=0.1)
    cost = runs[-1][1].evaluations / runs[1][1].evaluations
    assert 3 < cost < 5.7, "six digits cost 1e6**(1/8), less what events cost at any tolerance"


@pytest.mark.parametrize("closed_form", CURVED, indirect=True)
@pytest.mark.parametrize("method", FIXED_STEP)
def test_fixed_steps_show_their_order(closed_form, method):
    steps = np.array([200, 400, 800, 1600])
    found = np.array([errors(*closed_form, Numerics(method, 1e-15, int(n)))[0] for n in steps])
    orders = np.polyfit(np.log(1 / steps), np.log(found), 1)[0]
    np.testing.assert_allclose(orders[:2], ORDERS[method], atol=0.1)
    # the flow contracts towards its harvest, and the tangents' errors with it
    assert ORDERS[method] - 0.1 < orders[2] < ORDERS[method] + 1


@pytest.mark.parametrize("method", at.METHOD_CODES)
def test_steps_and_evaluations_are_counted(closed_form, method):
    """A Taylor step counts as its order; the Runge-Kutta methods cannot do with less than their stages a step."""
    numerics = Numerics(method)
    _, run = errors(*closed_form, numerics)
    least = {"taylor": numerics.order, "rk4": 8, "dop853": 12}[method] * run.steps
    assert least <= run.evaluations < 3 * least + 500
    run.forget()
    assert run.evaluations == run.steps == 0
