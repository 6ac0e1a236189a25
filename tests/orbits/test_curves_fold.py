"""A curve of folds runs through its cusps and closes on itself; cycles of a flow without forcing fold too."""

import numpy as np
import pytest
import sympy
from support.following import followed

import chaosdrill as cd
from chaosdrill.dataset.branches import BranchEnd


@pytest.fixture(scope="module")
def loop():
    x, y, t, p, q = sympy.symbols("x y t p q", real=True)
    # x rests where p = x^3/3 + (q^2 - 1) x, a surface that folds on x^2 + q^2 = 1; y only keeps it from being at rest
    system = cd.HybridSystem(
        name="folded-surface",
        states=(x, y),
        time=t,
        parameters={"p": 0.0, "q": 0.3},
        modes={"free": {x: p - (x**3 / 3 + (q**2 - 1) * x), y: -y + sympy.cos(t)}},
        period=2 * sympy.pi,
        initial={"mode": "free", x: 1.7, y: 0.5},
    )
    return followed(system, {"p": (-1.0, 1.0), "q": (-1.5, 1.5)}, "fold", 0.04, transient=20)


def test_folds_lie_on_the_closed_form(loop):
    p, q = loop.values.T
    x = loop.section[:, 0, 0]
    assert np.abs(x**2 + q**2 - 1).max() < 1e-11
    assert np.abs(p + 2 / 3 * x**3).max() < 1e-11


def test_the_curve_is_closed_and_passes_both_cusps(loop):
    p, q = loop.values.T
    assert loop.branches[0].end_code == BranchEnd.CLOSED
    assert q.min() < -0.999
    assert q.max() > 0.999
    assert p.min() < -0.66
    assert p.max() > 0.66
    # the whole circle, and no part of it twice
    angles = np.unwrap(np.arctan2(loop.section[:, 0, 0], q))
    steps = np.diff(angles)
    assert (steps > 0).all() or (steps < 0).all()
    assert 2 * np.pi - 0.1 < abs(angles[-1] - angles[0]) < 2 * np.pi


def test_cycles_fold_together():
    x, y, mu, q = sympy.symbols("x y mu q", real=True)
    square = x**2 + y**2
    # growth mu + q r^2 - r^4 of the radius: two cycles meet at r^2 = q/2
    growth, turning = mu + q * square - square**2, 1 + square / 2
    system = cd.HybridSystem(
        name="two-cycles",
        states=(x, y),
        parameters={"mu": -0.1, "q": 1.0},
        modes={"flow": {x: growth * x - turning * y, y: growth * y + turning * x}},
        initial={"mode": "flow", x: 1.0, y: 0.0},
    )
    result = followed(system, {"mu": (-1.0, 0.5), "q": (0.2, 1.8)}, "fold", 0.06, transient=100)
    mu, q = result.values.T
    assert np.abs(mu + q**2 / 4).max() < 1e-12
    assert np.abs((result.section[:, 0] ** 2).sum(axis=1) - q / 2).max() < 1e-10
    assert np.allclose([q.min(), q.max()], [0.2, 1.8], rtol=0, atol=1e-12)
