"""Orbits that begin on a surface which a mode holds: their multipliers are those on the surface, and 0 across it."""

from math import cos, exp, pi, sqrt

import numpy as np
import pytest
from scipy.optimize import brentq

import chaosdrill as cd

TAU, W, KICK, FALL, B, C = 0.6, 2.0, 4.0, 3.0, 0.3, 0.2


def kicked(mode="on", *, pull=0, names="x v y", size=1.0, reverse=False, kick=KICK):
    """Slides on x + tau*v = 0, is kicked off it once a period, and falls back.

    States may have other names, x another unit, and all may be declared the other way round.
    """
    x, v, y = names.split()
    surface = f"{x}/{size} + tau*{v}"
    modes = {
        "on": {x: f"{size}*{v}", v: f"-{v}/tau - {pull}*({surface})", y: f"-b*{y} + {x}/{size}"},
        "off": {x: f"{size}*{v}", v: "-fall", y: f"-b*{y} + {x}/{size}"},
    }
    transitions = [
        {
            "name": "kicked",
            "source": "on",
            "target": "off",
            "guard": f"cos(w*t) + c*{x}/{size}",
            "direction": -1,
            "reset": {v: f"{v} + kick"},
        },
        {"name": "lands", "source": "off", "target": "on", "guard": surface, "direction": -1},
    ]
    order = -1 if reverse else 1
    return cd.HybridSystem(
        name="kicked",
        states=names.split()[::order],
        parameters={"tau": TAU, "w": W, "kick": kick, "fall": FALL, "b": B, "c": C},
        modes=dict(list(modes.items())[::order]),
        transitions=transitions[::order],
        period="2*pi/w",
        initial={"mode": mode, x: 0.6 * size, v: -1.0 if mode == "on" else 1.0, y: 0.1},
    )


def slide(x, y, t, tau=TAU):
    part = x / (B - 1 / tau)
    return x * exp(-t / tau), (y - part) * exp(-B * t) + part * exp(-t / tau)


def lap(x, y, kick=KICK, tau=TAU):
    """The map of (x, y) on the surface over a period, in closed form but for the time of the kick."""
    begin = brentq(lambda t: cos(W * t) + C * x * exp(-t / tau), 0.5 * pi / 2 / W, pi / W, xtol=1e-15, rtol=1e-15)
    x, y = slide(x, y, begin, tau)
    v = kick - x / tau
    linear = v - tau * FALL
    flight = (linear + sqrt(linear**2 + 2 * FALL * (x + tau * v))) / FALL
    second = -FALL / 2 / B
    first = (v - 2 * second) / B
    constant = (x - first) / B
    y = (y - constant) * exp(-B * flight) + constant + first * flight + second * flight**2
    return np.array(slide(x + v * flight - FALL * flight**2 / 2, y, 2 * pi / W - begin - flight, tau))


def by_hand(kick=KICK, tau=TAU):
    state = np.array([0.6, 0.1])
    for _ in range(200):
        state = lap(*state, kick, tau)
    columns = []
    for step in 1e-4 * np.eye(2):
        near, far = (lap(*(state + s * step), kick, tau) - lap(*(state - s * step), kick, tau) for s in (1, 2))
        columns.append((8 * near - far) / 12e-4)
    values = np.linalg.eigvals(np.column_stack(columns))
    return state, values[np.argsort(-np.abs(values))]


@pytest.mark.parametrize("pull", [0, 1])
@pytest.mark.parametrize(("mode", "start"), [("on", "attractor"), ("on", "guess"), ("off", "attractor")])
def test_an_orbit_that_leaves_and_comes_back(mode, start, pull):
    (x, y), values = by_hand()
    found = cd.periodic_orbit(kicked(mode, pull=pull), start=start, transient=20)
    assert found["orbit_state"].values == pytest.approx([x, -x / TAU, y], abs=1e-9)
    assert found["multiplier_real"].values == pytest.approx([*values, 0], abs=1e-8)
    assert found["multiplier_real"].values[2] == 0
    assert (int(found["rank"]), bool(found["consistent"])) == (2, True)


@pytest.mark.parametrize(
    "more", [{"names": "b1 a2 a1"}, {"reverse": True}, {"size": 1e-6}, {"size": 1e4, "reverse": True}], ids=str
)
@pytest.mark.parametrize("mode", ["on", "off"])
def test_whatever_names_order_and_units(mode, more):
    found = cd.periodic_orbit(kicked(mode, **more), transient=20)
    assert found["multiplier_real"].values == pytest.approx([*by_hand()[1], 0], abs=1e-8)
    assert int(found["rank"]) == 2


def test_along_a_branch():
    branch = cd.continue_orbit(kicked(), {"kick": [3.5, 4.5]}, transient=20)
    kicks = branch["kick"].values.ravel()
    multipliers = branch["multiplier_real"].values.reshape(len(kicks), 3)
    states = branch["orbit_state"].values.reshape(len(kicks), 3)
    assert len(kicks) > 2
    for kick, found, state in zip(kicks, multipliers, states, strict=True):
        (x, y), values = by_hand(kick)
        assert state == pytest.approx([x, -x / TAU, y], abs=1e-8)
        assert found == pytest.approx([*values, 0], abs=1e-7)


def resting(pull, x, v, rate="-v/tau", surface="x + tau*v - height"):
    """It comes to rest at x = height on the surface, where y alone is driven."""
    return cd.HybridSystem(
        name="resting",
        states="x v y",
        parameters={"tau": TAU, "w": W, "height": 0.5},
        modes={
            "off": {"x": "v", "v": "-1", "y": "-y"},
            "on": {"x": "v", "v": f"{rate} - {pull}*({surface})", "y": "-y + x + cos(w*t)"},
        },
        transitions=[{"name": "in", "source": "off", "target": "on", "guard": surface, "direction": -1}],
        period="2*pi/w",
        initial={"mode": "on", "x": x, "v": v, "y": 0.3},
    )


@pytest.mark.parametrize("start", ["attractor", "guess"])
@pytest.mark.parametrize("pull", [0, 1])
@pytest.mark.parametrize(("x", "v"), [(0.5, 0.0), (1.1, -1.0)])
def test_an_orbit_that_stays(start, pull, x, v):
    """Where the field beside the surface leads along it, nothing but the surface tells which of many orbits it is."""
    found = cd.periodic_orbit(resting(pull, x, v), start=start, transient=20)
    assert found["orbit_state"].values == pytest.approx([0.5, 0.0, 0.5 + 1 / (1 + W**2)], abs=1e-9)
    assert found["multiplier_real"].values == pytest.approx([exp(-pi), exp(-pi / TAU), 0], abs=1e-10)
    assert found["multiplier_real"].values[2] == 0
    assert (int(found["rank"]), bool(found["consistent"])) == (2, True)


@pytest.mark.parametrize("x", [0.5, 0.6])
def test_a_guess_beside_the_surface_is_put_onto_it(x):
    found = cd.periodic_orbit(resting(0, x, 0.0), start="guess")
    assert found["orbit_state"].values == pytest.approx([0.5, 0.0, 0.5 + 1 / (1 + W**2)], abs=1e-9)


@pytest.mark.parametrize("name", ["height", "tau"])
def test_a_branch_follows_the_surface(name):
    branch = cd.continue_orbit(resting(0, 0.5, 0.0), {name: [0.5, 0.9]}, transient=20)
    values = branch[name].values.ravel()
    height, tau = (values, TAU) if name == "height" else (0.5, values)
    assert branch["orbit_state"].values.reshape(-1, 3)[:, 0] == pytest.approx(height + 0 * values, abs=1e-9)
    multipliers = branch["multiplier_real"].values.reshape(-1, 3)
    assert len(values) > 2
    assert multipliers[:, 1] == pytest.approx(np.exp(-pi / tau) + 0 * values, abs=1e-9)
    assert (multipliers[:, 2] == 0).all()


def test_a_surface_that_moves():
    """On x + tau*v = sin(w t) the orbit is the driven motion of x' = v."""
    found = cd.periodic_orbit(resting(0, 0.0, 0.0, "(-v + w*cos(w*t))/tau", "x + tau*v - sin(w*t)"), transient=20)
    x = -TAU * W / (1 + (TAU * W) ** 2)
    assert found["orbit_state"].values[:2] == pytest.approx([x, -x / TAU], abs=1e-9)
    assert found["multiplier_real"].values == pytest.approx([exp(-pi), exp(-pi / TAU), 0], abs=1e-10)


@pytest.mark.parametrize("pull", [0, 3])
def test_derivatives_where_the_surface_turns_with_its_parameter(pull):
    """Whatever the field beside the surface: tangents stay on it as it turns."""
    ds = cd.periodic_orbit(kicked(pull=pull), derivatives=["tau", "kick"])
    v, h = float(ds["orbit_state"][1]), 2e-3

    def told(**moved):
        state, values = by_hand(**moved)
        return np.array([*state, *values.real])

    for name, value in (("tau", TAU), ("kick", KICK)):
        near, far = (told(**{name: value + s * h}) - told(**{name: value - s * h}) for s in (1, 2))
        wanted = (8 * near - far) / (12 * h)
        one = ds.sel(parameter=name)
        state = one["orbit_state_derivative"].values
        np.testing.assert_allclose(state[[0, 2]], wanted[:2], rtol=1e-7)
        assert abs(state[0] + TAU * state[1] + (v if name == "tau" else 0.0)) < 1e-10
        np.testing.assert_allclose(one["multiplier_real_derivative"], [*wanted[2:], 0.0], atol=1e-7)
