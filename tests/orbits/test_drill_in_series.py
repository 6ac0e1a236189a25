"""The drill in Taylor series: it holds the known orbits, and SciPy sees the same events."""

import numpy as np
import pytest
from mpmath import mp
from scipy.special import lambertw
from support.drill_in_series import SLIP, Drill
from support.motion import arc
from support.strobe_orbits import Branch

KNOWN = {
    "0.8": (
        1,
        ("0.5117707419326684", "0.2579689590074009", "0.3668787222623992"),
        (0.11672896840556, 0.65713468420972),
    ),
    "0.6": (
        2,
        ("0.9600731434657304", "0.4240583758953005", "0.5379459585801125"),
        (-0.26096061533102, 0.65086241068766),
    ),
    "0.63": (4, ("0.7201005283205294", "0.1022519359120029", "0.0687759307641452"), None),
}
"""Quadruple precision, by another program: periods, strobe state, multiplier."""


@pytest.mark.parametrize("eta", KNOWN)
def test_known_orbits_return(digits, eta):
    digits(24)
    periods, state, _ = KNOWN[eta]
    start = [mp.mpf(value) for value in state]
    run = Drill(eta).run(start, SLIP, periods)
    assert max(abs(a - b) for a, b in zip(run.state, start, strict=True)) < 5e-16
    assert run.sequence == " ".join(["stick slip hit"] * periods)


@pytest.mark.parametrize("eta", ["0.8", "0.6"])
def test_known_multipliers(digits, eta):
    digits(24)
    periods, state, known = KNOWN[eta]
    found = Branch(periods, SLIP).at(eta, [mp.mpf(value) for value in state])
    assert min(abs(found.multipliers - complex(*known))) < 1e-10
    assert abs(found.determinant(0)) < 1e-10


def test_scipy_sees_the_same_events(digits):
    digits(24)
    eta = 0.8
    state = [float(value) for value in KNOWN["0.8"][1]]
    run = Drill("0.8").run([mp.mpf(value) for value in KNOWN["0.8"][1]], SLIP, 1)

    def slip(t, s):
        y, u, w = s
        force = y + 0.12 * (u - w)
        return [u - w, 0.7 + 0.25 * np.cos(eta * t + np.pi / 2) - force, force - 0.6 - 0.4 * np.exp(-3 * w)]

    def stick(t, s):
        return [s[1], 0.7 + 0.25 * np.cos(eta * t + np.pi / 2) - s[0] - 0.12 * s[1], 0.0]

    t, s = arc(slip, 0.0, state, 7.0, lambda _, s: -s[2])
    times = [t]
    t, s = arc(stick, t, [s[0], s[1], 0.0], 7.0, lambda _, s: s[0] + 0.12 * s[1] - 1)
    times.append(t)
    t, s = arc(slip, t, s, 7.0, lambda _, s: s[0] - 1)
    times.append(t)
    entry = 1 + 0.6 * (s[1] - s[2])
    rebound = (1 + lambertw(-entry * np.exp(-entry)).real) / 0.6
    bit = (s[1] + s[2] - rebound) / 2
    _, s = arc(slip, t, [1.0, bit, bit + rebound], 2 * np.pi / eta - t)
    np.testing.assert_allclose(times, [float(event.time) for event in run.events], atol=1e-10)
    np.testing.assert_allclose(s, [float(value) for value in run.state], atol=1e-10)


def test_the_exit_speed_is_lamberts(digits):
    digits(30)
    drill = Drill("0.8")
    for v in ("1e-9", "1e-3", "0.4", "5"):
        entry = 1 + drill.lam * mp.mpf(v)
        with mp.workdps(70):
            known = (1 + mp.lambertw(-entry * mp.exp(-entry)).real) / drill.lam
        assert abs(drill.exit_speed(mp.mpf(v)) / known - 1) < 1e-18
