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
