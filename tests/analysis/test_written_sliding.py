"""Sliding modes written by hand, on surfaces that are no coordinate: exponents as in the coordinates of the surface."""

import numpy as np
import pytest

import chaosdrill as cd

PERIODS = 60


def relay(mode, tau, *, sliding=None, up="x + tau*v", reset=None):
    """On x + tau*v = 0 remain x' = -x/tau and y' = -y + x: exponents -1/tau, -1, and none across."""
    slide = {"target": "on", "kind": "slide"}
    return cd.HybridSystem(
        name="relay",
        states="x v y",
        parameters={"tau": tau, "a": 2.0, "w": 2.0},
        modes={
            "above": {"x": "v", "v": "-1 + a*cos(w*t)", "y": "-y + x"},
            "below": {"x": "v", "v": "1 + a*cos(w*t)", "y": "-y + x"},
            "on": sliding or {"x": "v", "v": "-v/tau", "y": "-y + x"},
        },
        transitions=[
            {"name": "down", "source": "above", "guard": "x + tau*v", "direction": -1, "reset": reset or {}, **slide},
            {"name": "up", "source": "below", "guard": up, "direction": 1, **slide},
        ],
        period="2*pi/w",
        initial={"mode": mode, "x": 1.0, "v": 1.0 if mode == "above" else -1.0 / tau, "y": 0.3},
    )


def spectrum(system, **settings):
    return cd.lyapunov_spectrum(system, **settings)["lyapunov_exponent"].values


@pytest.mark.parametrize("transient", [0, 5])
@pytest.mark.parametrize("mode", ["above", "on"])
@pytest.mark.parametrize("tau", [0.5, 0.6, 0.8])
def test_wherever_a_record_begins(mode, tau, transient):
    once, twice = (spectrum(relay(mode, tau), transient=transient, periods=n * PERIODS) for n in (1, 2))
    # what the time before it slides leaves in the sums is the same in both
    assert 2 * twice[:2] - once[:2] == pytest.approx([-1.0, -1.0 / tau], abs=1e-9)
    assert once[2] == twice[2] == -np.inf


@pytest.mark.parametrize("method", ["dop853", "radau", "rk4"])
def test_by_every_method(method):
    found = spectrum(relay("on", 0.6), transient=5, periods=PERIODS, method=method)
    assert found == pytest.approx([-1.0, -1.0 / 0.6, -np.inf], abs=1e-6)


@pytest.mark.parametrize(
    "more", [{"reset": {"v": "-x/tau"}}, {"sliding": {"x": "-x/tau", "v": "-v/tau", "y": "-y + x"}}], ids=str
)
def test_other_ways_to_write_it(more):
    assert spectrum(relay("on", 0.6, **more), transient=5, periods=PERIODS) == pytest.approx([-1, -1 / 0.6, -np.inf])


@pytest.mark.parametrize(
    ("more", "exact"),
    [({"sliding": {"x": "v", "v": "-3*v", "y": "-y + x"}}, [0, -1, -3]), ({"up": "x - 5"}, [0, -1, -1 / 0.6])],
    ids=["the mode leaves the surface", "a way in does not lead to it"],
)
def test_a_direction_that_may_be_there_is_not_lost(more, exact):
    assert spectrum(relay("on", 0.6, **more), transient=5, periods=PERIODS) == pytest.approx(exact, abs=1e-9)


@pytest.mark.parametrize("follow", [None, "forward"])
@pytest.mark.parametrize("method", ["taylor", "dop853"])
def test_along_a_parameter_of_the_surface(method, follow):
    taus = np.array([0.5, 0.6, 0.8])
    more = {"follow": follow} if follow else {}
    found = cd.bifurcation_diagram(
        relay("on", 0.5), {"tau": taus}, transient=5, periods=PERIODS, exponents=3, method=method, **more
    )["lyapunov_exponent"].values.reshape(-1, 3)
    assert found == pytest.approx(np.column_stack([-np.ones(3), -1 / taus, np.full(3, -np.inf)]), abs=1e-6)


@pytest.mark.parametrize("pull", [0, 1])
@pytest.mark.parametrize("start", [{"mode": "out", "x": 1.5, "v": 1.0}, {"mode": "on", "x": 0.6, "v": 0.8}], ids=str)
def test_a_curved_surface(start, pull):
    """A turn on the unit circle: exponents 0 along it and -1, whatever the mode would do beside it."""
    off = f"{pull}*(x**2 + v**2 - 1)"
    system = cd.HybridSystem(
        name="circle",
        states="x v y",
        parameters={},
        modes={"out": {"x": "-x", "v": "-v", "y": "-y"}, "on": {"x": f"-v - x*{off}", "v": f"x - v*{off}", "y": "-y"}},
        transitions=[{"name": "in", "source": "out", "target": "on", "guard": "x**2 + v**2 - 1", "direction": -1}],
        initial={**start, "y": 1.0},
    )
    assert spectrum(system, transient=5, duration=60) == pytest.approx([0, -1, -np.inf], abs=1e-9)


@pytest.mark.parametrize("mode", ["off", "on"])
def test_a_surface_that_moves(mode):
    system = cd.HybridSystem(
        name="moving",
        states="x v y",
        parameters={"w": 2.0},
        modes={
            "off": {"x": "v", "v": "-2", "y": "-y"},
            "on": {"x": "v", "v": "(-v + w*cos(w*t))/0.6", "y": "-y + x"},
        },
        transitions=[{"name": "in", "source": "off", "target": "on", "guard": "x + 0.6*v - sin(w*t)", "direction": -1}],
        period="2*pi/w",
        initial={"mode": mode, "x": 0.6, "v": 1.0 if mode == "off" else -1.0, "y": 1.0},
    )
    assert spectrum(system, transient=5, periods=PERIODS) == pytest.approx([-1, -1 / 0.6, -np.inf], abs=1e-9)


@pytest.mark.parametrize("mode", ["free", "first", "both"])
def test_two_surfaces_one_after_the_other(mode):
    """On x + 0.6 y = 0 and then z + 0.7 u = 0 as well remain two of four directions: -0.3 and -0.8."""
    on = {"x": "-0.3*x", "y": "-0.3*y"}, {"z": "-0.8*z", "u": "-0.8*u"}
    off = {"x": "-1", "y": "-1"}, {"z": "-1", "u": "-1"}
    guards = "x + 0.6*y", "z + 0.7*u"
    ways = [("free", "first", 0), ("free", "second", 1), ("first", "both", 1), ("second", "both", 0)]
    start = {"free": (1, 1, 1, 2), "first": (0.6, -1, 1, 2), "both": (0.6, -1, 0.7, -1)}[mode]
    system = cd.HybridSystem(
        name="corner",
        states="x y z u",
        parameters={},
        modes={
            "free": {**off[0], **off[1]},
            "first": {**on[0], **off[1]},
            "second": {**off[0], **on[1]},
            "both": {**on[0], **on[1]},
        },
        transitions=[
            {"name": f"{a}-{b}", "source": a, "target": b, "guard": guards[i], "direction": -1} for a, b, i in ways
        ],
        initial={"mode": mode, **dict(zip("xyzu", start, strict=True))},
    )
    found = spectrum(system, transient=5, duration=60)
    assert found == pytest.approx([-0.3, -0.8, -np.inf, -np.inf], abs=1e-9)
