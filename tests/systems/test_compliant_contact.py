"""A contact that is integrated is what the contacts that jump stand for: it tends to them as it stiffens."""

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import chaosdrill as cd

STIFFNESSES = np.array([1e4, 1e6, 1e8, 1e10])
METHODS = [("taylor", 1.0), ("dop853", 1.0), ("radau", 1.5)]
# the cycle at eta = 0.8 with hits that take no time, in quadruple precision
CYCLE = {"y": 0.5117707419326684, "u": 0.2579689590074009, "w": 0.3668787222623992}
PROGRESSION = 0.1163908540290498
PERIOD = 2 * np.pi / 0.8


def slopes(errors):
    return np.diff(np.log(errors)) / np.diff(np.log(STIFFNESSES))


def rebound(v, lam):
    """Exit speed by Lambert's W."""
    base = 1 + mpmath.mpf(lam) * v
    return float((1 + mpmath.lambertw(-base * mpmath.exp(-base)).real) / lam)


@pytest.mark.parametrize(("method", "n"), METHODS)
def test_a_bounce_off_a_wall_tends_to_the_jump(method, n):
    # undamped and unloaded: y = sin t up to the wall at 1/2, which it meets at pi/6 with the speed cos(pi/6)
    end, lam = 2.0, 0.6
    back, after = rebound(np.cos(np.pi / 6), lam), end - np.pi / 6
    exact = (np.cos(after) / 2 - back * np.sin(after), -np.sin(after) / 2 - back * np.cos(after))
    errors = []
    for k in STIFFNESSES:
        bit = cd.drill(
            drive="none", friction="none", rock="fixed", contact="compliant", b=0, xi=0, r=0.5, k=k, n=n, lam=lam,
            initial={"u": 1.0},
        )  # fmt: skip
        run = cd.trajectory(bit, duration=end, samples=1, method=method)
        assert run.sizes["event"] == 2
        errors.append(np.abs(run["states"].values[-1, :2] - exact).max())
    np.testing.assert_allclose(slopes(errors)[1:], -1 / (n + 1), rtol=0.01)
    assert errors[-1] < 5 * STIFFNESSES[-1] ** (-1 / (n + 1))


def cycle(contact, k, n=1.0, **numerics):
    system = cd.drill(eta=0.8, contact=contact, k=k, n=n, initial={**CYCLE, "mode": "slip"})
    return cd.poincare_section(system, periods=6, transient=120, max_period=1, **numerics)


@pytest.mark.parametrize(
    ("contact", "method", "n"), [*(("compliant", *m) for m in METHODS), ("hunt-crossley-timed", "taylor", 1.0)]
)
def test_the_cycle_of_the_drill_tends_to_that_of_the_jump(contact, method, n):
    found = [cycle(contact, k, n, method=method) for k in STIFFNESSES]
    points = np.array([section["section"].values[-1, :3] for section in found])
    errors = np.abs(points - list(CYCLE.values())).max(axis=1)
    np.testing.assert_allclose(slopes(errors)[1:], -1 / (n + 1), rtol=0.02)
    drilled = np.abs([float(section["progression_rate"]) - PROGRESSION for section in found])
    np.testing.assert_allclose(slopes(drilled)[1:], -1 / (n + 1), rtol=0.02)


def multipliers(section):
    return section["multiplier_real"].values + 1j * section["multiplier_imag"].values


def test_methods_agree_on_the_multipliers_of_a_stiff_contact():
    taylor = multipliers(cycle("compliant", 1e8))
    assert np.all(taylor[2:] == 0)
    for numerics in ({"tolerance": 1e-15}, {"method": "dop853"}, {"method": "dop853", "tolerance": 1e-13}):
        np.testing.assert_allclose(multipliers(cycle("compliant", 1e8, **numerics)), taylor, rtol=0, atol=2e-9)
    # those of the jump, and a first-order difference in k**-0.5
    assert np.abs(taylor[0] - (0.11672896840556 + 0.65713468420972j)) < 3e-4


def through(k, tolerance, x):
    """The state after one forcing period, contact included, and its derivatives, a row for each initial state."""
    start = dict(zip(("y", "u", "w", "depth"), x, strict=True))
    system = cd.drill(eta=0.8, contact="compliant", k=k, initial={**start, "mode": "slip"})
    run = cd.trajectory(system, periods=1, samples=1, tolerance=tolerance, tangents=True)
    assert run["outcome"] == cd.Outcome.OK
    assert run.sizes["event"] >= 4
    return run["states"].values[-1], run["final_tangent"].values


@pytest.mark.parametrize("k", [1e4, 1e8, 1e12])
def test_state_and_tangents_stay_within_tolerance_through_the_contact(k):
    (sharp, of_sharp), (loose, of_loose) = (through(k, one, [*CYCLE.values(), 0.0]) for one in (1e-16, 1e-10))
    np.testing.assert_allclose(loose, sharp, rtol=0, atol=1e-9)
    # a tangent's speed grows by sqrt(k) in contact, and its error with it
    np.testing.assert_allclose(of_loose, of_sharp, rtol=0, atol=1e-10 * np.sqrt(k))


@pytest.mark.parametrize("k", [1e4, 1e8])
def test_tangents_through_the_contact_are_differences_of_the_flow(k):
    start = np.array([*CYCLE.values(), 0.0])
    for unit, found in zip(np.eye(4)[:3], through(k, 1e-15, start)[1], strict=False):
        coarse, fine = (
            (through(k, 1e-15, start + h * unit)[0] - through(k, 1e-15, start - h * unit)[0]) / (2 * h)
            for h in (4e-5, 2e-5)
        )
        np.testing.assert_allclose(found, (4 * fine - coarse) / 3, rtol=0, atol=1e-7)


@settings(max_examples=20)
@given(
    u=st.floats(0.1, 2.0),
    w=st.floats(-1.0, 1.0),
    eps=st.floats(0.1, 10.0),
    k=st.floats(3.0, 10.0),
    xi=st.floats(0, 0.5),
)
def test_free_masses_keep_their_momentum_through_the_contact_and_lose_energy(u, w, eps, k, xi):
    system = cd.drill(
        drive="none", friction="none", contact="compliant", b=0.0, r=0.2, xi=xi, eps=eps, k=10**k,
        initial={"y": 0.1, "u": u + w, "w": w},
    )  # fmt: skip
    run = cd.trajectory(system, duration=4.0, samples=50)
    y, bit, rock, depth = run["states"].values.T
    momentum, scale = eps * bit + rock, 1 + eps * (abs(u) + abs(w))
    np.testing.assert_allclose(momentum, momentum[0], rtol=0, atol=1e-11 * scale)
    energy = eps * bit**2 + rock**2 + eps * (y + depth) ** 2
    outside = depth == 0
    assert np.all(np.diff(energy[outside]) <= 1e-11 * scale**2)


def test_the_depth_costs_one_exponent_and_the_stick_another():
    spectrum = cd.lyapunov_spectrum(cd.drill(eta=0.8, contact="compliant", k=1e8), periods=600, transient=200)
    found = spectrum["lyapunov_exponent"].values
    rate = np.log(np.abs(0.11672068796 + 0.65729597334j)) / PERIOD
    # of a complex pair the mean converges at once, each of the two like 1/length
    np.testing.assert_allclose(found[:2].mean(), rate, atol=1e-10)
    assert np.all(found[2:] == -np.inf)
