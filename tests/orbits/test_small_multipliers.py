"""Multipliers far below the round-off of the largest one of their orbit, against closed forms and many digits."""

import numpy as np
import pytest
import sympy
from mpmath import mp

import chaosdrill as cd
from chaosdrill.orbits.multipliers import _simultaneous, _together

x, y, a, b = sympy.symbols("x y a b", real=True)


@pytest.fixture(scope="module")
def henon():
    """x := 1 - a x^2 + y, y := b x: areas change by -b an iterate."""
    system = cd.Map(states=(x, y), parameters={"a": 0.3, "b": 1e-3}, images={x: 1 - a * x**2 + y, y: b * x})
    return cd.continue_orbit(system.with_initial(x=0.8, y=0.0), {"a": (0.3, 1.6)}, doublings=3, step=0.02)


def _multipliers(found):
    return found["multiplier_real"].values + 1j * found["multiplier_imag"].values


def test_multipliers_multiply_to_the_change_of_areas(henon):
    assert henon["doubling_period"].values.tolist() == [1, 2, 4, 8]
    known = (-1e-3) ** henon["period"].values.astype(float)
    assert (np.abs(_multipliers(henon).prod(axis=1) / known - 1) < 1e-8).all()


@pytest.mark.parametrize("period", [2, 8])
def test_each_multiplier_has_its_digits(henon, period, digits):
    digits(60)
    point = np.flatnonzero(henon["period"].values == period)[-1]
    value, size = mp.mpf(float(henon["a"][point])), mp.mpf(1e-3)
    state = mp.matrix(henon["orbit_state"].values[point].tolist())
    for _ in range(4):
        place, tangent = state.copy(), mp.eye(2)
        for _ in range(period):
            tangent = mp.matrix([[-2 * value * place[0], 1], [size, 0]]) * tangent
            place = mp.matrix([1 - value * place[0] ** 2 + place[1], size * place[0]])
        state -= mp.lu_solve(tangent - mp.eye(2), place - state)
    exact = sorted((complex(v) for v in mp.eig(tangent, left=False, right=False)), key=abs, reverse=True)
    assert abs(exact[1]) < 1e-14 * abs(exact[0]) or period == 2
    np.testing.assert_allclose(_multipliers(henon)[point], exact, rtol=1e-8)


def test_what_the_map_as_a_whole_shows_is_not_parted(monkeypatch):
    """A complex pair, one of nearly its modulus, and one of 1e-36: few turns of twelve factors give each its digits."""
    count, angle = 12, 0.3
    turn = 0.98 * np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    step = np.zeros((4, 4))
    step[:2, :2], step[2, 2], step[3, 3] = turn, 0.95, 1e-3
    frames = np.random.default_rng(5).normal(size=(count, 4, 4)) + 3 * np.eye(4)
    factors = np.array([np.roll(frames, -1, 0)[i] @ step @ np.linalg.inv(frames[i]) for i in range(count)])
    whole = np.linalg.multi_dot(factors[::-1])
    values = np.sort_complex(np.linalg.eigvals(whole))[::-1]
    values = values[np.argsort(-np.abs(values), kind="stable")]
    together = _together(values, whole, 4, 1e-6)
    assert together.tolist() == [True, True, False]
    turned, plain = [], np.linalg.qr
    monkeypatch.setattr(np.linalg, "qr", lambda a: turned.append(1) or plain(a))
    found = _simultaneous(factors[np.newaxis], 4, together[np.newaxis])[0][0]
    assert len(turned) < 6 * count
    pair = 0.98**count * np.exp(1j * angle * count)
    expected = [pair, np.conj(pair), 0.95**count, 1e-3**count]
    assert min(abs(found[0] / e - 1) for e in expected[:2]) < 1e-13
    np.testing.assert_allclose(np.sort_complex(found), np.sort_complex(expected), rtol=1e-11)


def test_multipliers_beside_a_homoclinic_orbit():
    """A rimless wheel that hardly passes the top, where the slope is 0.028922, and two states that it drives.

    The multipliers are 1, cos(0.6)^2, and what the rates of the two make of the duration.
    """
    th, om, z, w, gamma = sympy.symbols("th om z w gamma", real=True)
    angle = sympy.Rational(3, 10)
    step = cd.Transition(
        "step",
        source="stance",
        target="stance",
        guard=th - gamma - angle,
        direction=+1,
        reset={th: gamma - angle, om: sympy.cos(2 * angle) * om, z: z + om},
    )
    wheel = cd.HybridSystem(
        name="wheel-with-two",
        states=(z, th, om, w),
        parameters={"gamma": 0.03},
        modes={"stance": {z: th - z / 10, th: om, om: sympy.sin(th), w: om * th - w / 20}},
        transitions=[step],
        initial={"mode": "stance", th: -0.27, om: 0.28, z: 0.0, w: 0.0},
    )
    found = cd.continue_orbit(wheel, {"gamma": (0.028, 0.031)}, start="guess", at="step")
    end = float(found["gamma"].min())
    assert end - 0.02892191395417579 < 1e-8
    times = found["period_time"].values
    exact = np.sort([1 + 0 * times, np.cos(0.6) ** 2 + 0 * times, np.exp(-times / 10), np.exp(-times / 20)], axis=0)
    np.testing.assert_allclose(np.sort(np.abs(_multipliers(found)), axis=1), exact.T, rtol=2e-7)
    assert (found["stable"] == 1).all()


@pytest.mark.parametrize("beyond", [1e-8, 1e-10])
def test_an_orbit_beside_a_homoclinic_one_from_its_closed_form(beyond):
    """Of its duration as many digits are known as rounding of its start leaves."""
    slope, kept = 0.02892191395417579 + beyond, np.cos(0.6) ** 2
    speed = np.sqrt(2 * (np.cos(slope - 0.3) - np.cos(slope + 0.3)) * kept / (1 - kept))
    wheel = cd.build("rimless-wheel", parameters={"gamma": slope}).with_initial(th=slope - 0.3, om=speed)
    found = cd.periodic_orbit(wheel, start="guess", at="step")
    assert found["outcome"] == cd.Outcome.PERIODIC
    np.testing.assert_allclose(found["multiplier_real"].values, [1, kept], rtol=1e-8)
    assert found["orbit_state"].sel(state="om").item() == pytest.approx(speed, rel=1e-12)


@pytest.mark.parametrize("left", [1, 2])
def test_what_is_left_where_directions_are_lost(left):
    """A multiplier, or a complex pair, of maps one of which loses the other directions, two of them in two rounds."""
    count, angle, lost = 5, 0.3, 2
    turn = 1.1 * np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])[:left, :left]
    step, end = np.eye(left + lost), np.zeros((left + lost, left + lost))
    step[:left, :left] = end[:left, :left] = turn
    end[left, left + 1] = 1.0
    frames = np.random.default_rng(7).normal(size=(count, left + lost, left + lost)) + 3 * np.eye(left + lost)
    middle = [step] * (count - 1) + [end]
    factors = np.array([np.roll(frames, -1, 0)[i] @ middle[i] @ np.linalg.inv(frames[i]) for i in range(count)])
    values, _ = _simultaneous(factors[np.newaxis], left, np.ones((1, left - 1), dtype=bool))
    exact = np.linalg.eigvals(np.linalg.matrix_power(turn, count))
    np.testing.assert_allclose(np.sort_complex(values[0, :left]), np.sort_complex(exact), rtol=1e-12)


def test_an_event_that_loses_a_direction_beside_a_shear():
    """A circle from which what is off in z changes the pace: its multipliers are 1, exp(0.4 pi) and 0."""
    pace = "(1 + b*(x**2 + y**2 - 1) + b*z)"
    rates = {"x": f"-x*(1 - x**2 - y**2)/10 - y*{pace}", "y": f"-y*(1 - x**2 - y**2)/10 + x*{pace}", "z": "z/20"}
    circle = cd.HybridSystem(
        states="x y z", parameters={"b": 1e5}, modes={"on": rates}, initial={"x": np.cos(0.5), "y": -np.sin(0.5)},
        transitions=[cd.Transition("tick", "on", "on", "y", 1, reset={"z": 0})],
    )  # fmt: skip
    found = cd.periodic_orbit(circle, at="tick", transient=0)
    np.testing.assert_allclose(_multipliers(found), [np.exp(0.4 * np.pi), 1.0, 0.0], rtol=1e-7)
