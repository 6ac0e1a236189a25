"""A cell that fails gets an outcome, and the others go on."""

from dataclasses import replace

import numpy as np
import pytest
import sympy

import chaosdrill as cd
from chaosdrill.analysis.precision import errors as precision_errors
from chaosdrill.analysis.tuning import PRECISION
from chaosdrill.dataset import Outcome

CELL = ("method", "tolerance")


def measure(system, **options):
    options = {"periods": 8, "repeats": 1, "tolerances": [1e-4, 1e-8]} | options
    return cd.work_precision(system, **options)


@pytest.fixture(scope="module")
def stiff():
    """x relaxes to cos t at the rate 30: too fast for four fixed steps a period, which explode."""
    x, t = sympy.symbols("x t", real=True)
    return cd.HybridSystem(
        name="relaxation",
        states=(x,),
        time=t,
        parameters={},
        modes={"one": {x: 30 * (sympy.cos(t) - x)}},
        period=2 * sympy.pi,
        initial={x: 1.0},
        bounds={x: (-10, 10)},
    )


def test_one_method_fails_and_the_other_is_measured(stiff):
    ds = measure(stiff, methods=["rk4", "taylor"], steps=[4, 8])
    outcomes = ds["outcome"].transpose(*CELL).values
    assert outcomes[0].tolist() == [Outcome.ESCAPED, Outcome.ESCAPED]
    assert outcomes[1].tolist() == [Outcome.OK, Outcome.OK]
    assert np.isnan(ds["error"].sel({"method": "rk4"})).all()
    assert np.isnan(ds["wall_time"].sel({"method": "rk4"})).all()
    assert np.isfinite(ds["error"].sel({"method": "taylor", "quantity": "multiplier"})).all()
    assert "use taylor" in ds.attrs["recommendation"]


def test_a_run_that_escapes_leaves_outcomes_only(circle):
    ds = measure(circle.with_parameters(growth=1.0), methods=["taylor"], periods=20)
    assert np.all(ds["outcome"] == Outcome.ESCAPED)
    for name in ("error", "wall_time", "steps", "evaluations", "horizon"):
        assert np.isnan(ds[name]).all(), name
    assert ds.attrs["recommendation"] == "nothing could be measured; see outcome"


def test_without_a_truth_the_identity_and_the_exponent_are_left(bouncer, monkeypatch):
    """The reason stands in an attribute."""
    monkeypatch.setattr("chaosdrill.analysis.precision.reference.PRECISION", replace(PRECISION, most_steps=0))
    ds = measure(bouncer, periods=None, duration=4.0, methods=["taylor"])
    assert "more than 0 steps" in ds.attrs["reference"]
    measured = [q for q in precision_errors.QUANTITIES if np.isfinite(ds["error"].sel(quantity=q)).any()]
    assert measured == ["flow_direction", "exponent"]


def test_events_that_differ_make_the_error_infinite():
    """x = sin t passes 0.999 and is back within a thirtieth of a period, between two of thirty steps."""
    x, v, t = sympy.symbols("x v t", real=True)
    hop = cd.HybridSystem(
        name="hop",
        states=(x, v),
        time=t,
        parameters={},
        modes={"one": {x: v, v: -x - v + sympy.cos(t)}},
        transitions=[cd.Transition("up", "one", "one", guard=x - sympy.Rational(999, 1000), direction=+1)],
        period=2 * sympy.pi,
        initial={x: 0.0, v: 1.0},
    )
    ds = measure(hop, methods=["taylor", "rk4"], steps=[30, 400], transient=20)
    error = ds["error"].sel(quantity="event_time").transpose(*CELL).values
    assert np.isposinf(error[1, 0])
    assert error[1, 1] < 1e-4
    assert np.all(error[0] < 1e-3)
    assert np.all(ds["outcome"] == Outcome.OK)


def test_settings_are_refused_by_name(duffing):
    for options, text in [
        ({"methods": ["tailor"]}, r"methods\[0\]: unknown method 'tailor'"),
        ({"methods": []}, "methods is"),
        ({"methods": "taylor"}, "methods is"),
        ({"methods": ["rk4", "rk4"]}, "methods is"),
        ({"tolerances": [1.0]}, r"tolerances\[0\] is 1.0; must be at most 0.01"),
        ({"tolerances": []}, "tolerances is"),
        ({"tolerances": ["1e-4"]}, r"tolerances\[0\] is '1e-4'; expected a number"),
        ({"tolerances": [1e-4, 1e-4]}, "tolerances is"),
        ({"steps": [100]}, "steps is"),
        ({"steps": [100, 3]}, r"steps\[1\] is 3; must be at least 4"),
        ({"repeats": 0}, "repeats is 0"),
        ({"periods": None}, "give either periods"),
    ]:
        with pytest.raises(cd.SettingsError, match=text):
            measure(duffing, **options)


def test_a_field_that_is_not_analytic_is_surveyed_by_another_method():
    """A ball on a Hertz contact d^1.5: taylor has no series at d = 0 and gets its outcome, dop853 is measured."""
    ball = cd.HybridSystem(
        name="hertz",
        states="x v",
        parameters={"k": 100.0},
        modes={"air": {"x": "v", "v": "-1"}, "contact": {"x": "v", "v": "k*positive_power(-x, 1.5) - 1"}},
        transitions=[
            cd.Transition("down", "air", "contact", guard="x", direction=-1),
            cd.Transition("up", "contact", "air", guard="x", direction=+1),
        ],
        initial={"x": 1.0},
    )
    ds = measure(ball, periods=None, duration=200.0, methods=["taylor", "dop853"], tolerances=[1e-6, 1e-10])
    outcomes = ds["outcome"].transpose(*CELL).values
    assert np.all(outcomes[0] > Outcome.CHAOTIC)
    assert np.all(outcomes[1] == Outcome.OK)
    error = ds["error"].sel({"method": "dop853", "quantity": ["strobe", "event_time", "tangent"]}).values
    assert np.all(error[:, 1] < 1e-3 * error[:, 0])
    assert np.all(error[:, 1] < 1e-7)
    assert np.all(ds["reference_error"].sel(quantity=["strobe", "event_time"]) < 1e-20)


def test_completed_chatter_has_no_truth_and_no_tangent():
    """A ball of restitution 0.2 on a table comes to rest in every period, which leaves no freedom."""
    ball = cd.build("bouncing-ball", {"amplitude": 1.5, "e": 0.2})
    ds = measure(ball, methods=["taylor"], periods=16, transient=40)
    assert int(ds["period"]) == 1
    assert np.all(ds["outcome"] == Outcome.OK)
    assert "infinitely many events" in ds.attrs["reference"]
    assert np.isneginf(ds["lyapunov_exponent"])
    assert np.isnan(ds["error"].sel(quantity=["strobe", "event_time", "tangent", "multiplier", "exponent"])).all()
    assert np.all(ds["error"].sel(quantity="flow_direction") < 1e-3)
