"""The duration of a contact in rates, guards and quadratures, where its approach speed may move."""

from dataclasses import replace

import mpmath
import numpy as np
import pytest
import sympy

import chaosdrill as cd
from chaosdrill.codegen import kernels_of, mode
from chaosdrill.codegen.contacts import hunt_crossley_duration_lam, hunt_crossley_duration_series
from chaosdrill.codegen.layout import UNIT
from chaosdrill.codegen.signatures import LANES
from chaosdrill.engine.lanes import aligned
from chaosdrill.engine.layout import COLUMNS
from chaosdrill.errors import ModelError
from chaosdrill.model.special import hunt_crossley_duration, hunt_crossley_duration_lam_lam
from tests.support import contact_durations

X, Y, Z, LAM, N, K = sympy.symbols("x y z lam n k", real=True)
ORDER, CHECKED = 23, 8
SPEED = 0.9375
PLACE = (0.75, 1.25, SPEED)
DIRECTIONS = np.array([[1.0, -0.4, 0.3], [0.3, 2.0, -1.0]])
STIFFNESS = 3.0
CONTACTS = {
    "elastic": (0.0, 1.5),
    "nearly elastic": (1e-5, 1.0),
    "damped, linear": (0.7, 1.0),
    "damped": (0.7, 1.5),
    "strongly damped": (4.0, 2.0),
    "sticky": (50 / SPEED, 1.5),
}


@pytest.fixture(autouse=True)
def digits():
    with mpmath.workdps(contact_durations.DIGITS):
        yield


def system(title):
    """Two speeds that move, one of them not linearly, and one that does not; all are 0.9375 at the start."""
    moving = hunt_crossley_duration(X * Y, LAM, N, K)
    still = hunt_crossley_duration(Z, LAM, N, K)
    guard = hunt_crossley_duration(X + Z / 5, LAM, N, K) - 2
    return cd.HybridSystem(
        name=title,
        states=(X, Y, Z),
        parameters={"lam": 0.7, "n": 1.5, "k": STIFFNESS},
        modes={"on": {X: moving * Y + still, Y: X - Y, Z: 0}},
        transitions=[cd.Transition("hit", "on", "on", guard=guard, direction=1, reset={X: 0})],
        quadratures={"lasted": moving},
    )


@pytest.fixture(scope="module", params=["in line", "in tables"])
def kernels(request):
    with pytest.MonkeyPatch.context() as patched:
        if request.param == "in tables":
            patched.setattr(mode, "TUNING", replace(mode.TUNING, products_in_line=-1))
        return kernels_of(system(f"durations {request.param}"))


def constants(kernels, lam, n):
    return kernels.constants({"lam": lam, "n": n, "k": STIFFNESS})


def expanded(kernels, lam, n):
    ws, c = np.full((kernels.layout.rows + 6, COLUMNS), np.nan), constants(kernels, lam, n)
    jet, jacobian_jet, tangent = kernels.functions[:3]
    jet(0, ORDER, 0.0, c, np.array(PLACE), ws)
    jacobian_jet(0, ORDER, c, ws)
    tangent(0, ORDER, c, *DIRECTIONS, ws, kernels.layout.rows)
    return ws


def polynomial(row):
    return [mpmath.mpf(a) for a in row[: CHECKED + 1]]


def times(a, b):
    return [mpmath.fsum(a[j] * b[m - j] for j in range(m + 1)) for m in range(CHECKED + 1)]


def plus(a, b):
    return [one + other for one, other in zip(a, b, strict=True)]


def composed(coefficients, speed):
    """A polynomial of the speed less its start, by Horner's rule."""
    change = [mpmath.mpf(0), *speed[1:]]
    found = [mpmath.mpf(0)] * (CHECKED + 1)
    for c in reversed(coefficients):
        found = times(found, change)
        found[0] += c
    return found


def duration_of(lam, n):
    """The duration as a function of a series, and its derivative."""
    found = contact_durations.taylor(SPEED, lam, n, STIFFNESS, CHECKED + 1)
    slope = [m * c for m, c in enumerate(found)][1:]
    return lambda speed: composed(found, speed), lambda speed: composed(slope, speed)


def agree(found, expected, tolerance):
    """On the scale of a series whose radius is that of a duration in its speed."""
    expected = np.array([float(e) for e in expected])
    radius = SPEED / 2
    scale = np.abs(expected).max() * radius ** -np.arange(len(expected))
    np.testing.assert_array_less(np.abs(np.asarray(found) - expected), tolerance * scale)


@pytest.mark.parametrize("contact", CONTACTS)
def test_states_are_series_of_the_duration(kernels, contact):
    lam, n = CONTACTS[contact]
    ws, (duration, _) = expanded(kernels, lam, n), duration_of(lam, n)
    x, y, z = map(polynomial, ws[:3])
    moving = duration(times(x, y))
    rate = plus(times(moving, y), duration(z))
    orders = np.arange(1, CHECKED + 1)
    agree(ws[0, 1 : CHECKED + 1] * orders, rate[:-1], 1e-12)
    agree(ws[3, 1 : CHECKED + 1] * orders, moving[:-1], 1e-12)
    guard = duration(plus(x, [a / 5 for a in z]))
    agree(ws[4, : CHECKED + 1], [guard[0] - 2, *guard[1:]], 1e-12)


@pytest.mark.parametrize("contact", CONTACTS)
def test_tangents_are_series_of_its_slope(kernels, contact):
    """d' = J d, with the Jacobian by hand."""
    lam, n = CONTACTS[contact]
    ws, (duration, slope) = expanded(kernels, lam, n), duration_of(lam, n)
    x, y, z = map(polynomial, ws[:3])
    for half in range(2):
        dx, dy, dz = map(polynomial, ws[kernels.layout.rows + 3 * half :][:3])
        change = times(times(slope(times(x, y)), plus(times(y, dx), times(x, dy))), y)
        expected = plus(plus(change, times(duration(times(x, y)), dy)), times(slope(z), dz))
        agree([float(a) * k for k, a in enumerate(dx)][1:], expected[:-1], 1e-11)


@pytest.mark.parametrize("contact", ["damped", "strongly damped"])
def test_lanes_have_the_same_bits(kernels, contact):
    def lanes(numbers):
        filled = aligned(*np.shape(numbers), LANES)
        filled[:] = np.asarray(numbers)[..., np.newaxis]
        return filled

    ws, c = aligned(kernels.layout.rows + 6, COLUMNS, LANES), lanes(constants(kernels, *CONTACTS[contact]))
    ws[:] = 0.0
    jet, jacobian_jet, tangent = kernels.lanes
    jet(0, ORDER, lanes(0.0), c, lanes(PLACE), ws)
    jacobian_jet(0, ORDER, c, ws)
    tangent(0, ORDER, c, *map(lanes, DIRECTIONS), ws, kernels.layout.rows)
    single = expanded(kernels, *CONTACTS[contact])
    for rows in (slice(0, 5), slice(kernels.layout.rows, None)):
        np.testing.assert_array_equal(ws[rows, : ORDER + 1, 5], single[rows, : ORDER + 1])


@pytest.mark.parametrize("contact", CONTACTS)
def test_the_variation_is_that_of_the_series(kernels, contact):
    lam, n = CONTACTS[contact]
    ws, c, out = expanded(kernels, lam, n), constants(kernels, lam, n), np.empty(3)
    for half, direction in enumerate(DIRECTIONS):
        kernels.functions.variation(0, 0.0, c, np.array(PLACE), direction, out)
        np.testing.assert_allclose(out, ws[kernels.layout.rows + 3 * half :][:3, 1], rtol=1e-13)


@pytest.mark.parametrize("contact", CONTACTS)
@pytest.mark.parametrize("x", [0.15, 0.4, 0.72])
def test_the_error_of_a_guard_is_within_its_bound(kernels, contact, x):
    """Of its value and of its rate along the flow, whose parts nearly cancel in the strongly damped one at 0.72."""
    lam, n = CONTACTS[contact]
    place, gradient = np.array([x, 1.25, x]), np.empty(4)
    c, rates = constants(kernels, lam, n), np.empty(4)
    bounds = [kernels.functions[k](0, 0, 0.0, c, place, np.zeros(3)) for k in (6, 9)]
    value = kernels.functions.guard(0, 0, 0.0, c, place, gradient)
    kernels.functions.field(0, 0.0, c, place, rates)
    with mpmath.workdps(contact_durations.DIGITS + contact_durations.lost(x, lam)):
        speed = mpmath.mpf(x) + mpmath.mpf(x) / 5
        tiny = mpmath.mpf("1e-10")
        ends = [contact_durations.duration(speed * (1 + tiny * way), lam, n, STIFFNESS) for way in (-1, 0, 1)]
        slope = (ends[2] - ends[0]) / (2 * tiny * speed)
        wrong = abs(ends[1] - 2 - value), abs(slope * rates[0] - gradient[:3] @ rates[:3])
    assert wrong[0] <= UNIT * bounds[0] < 1e-11 * (2 + ends[1])
    assert wrong[1] <= UNIT * bounds[1] < 1e-9 * rates[0] * ends[1] / speed


@pytest.mark.parametrize("scale", [1e-3, 1e6])
@pytest.mark.parametrize("contact", CONTACTS)
def test_units_do_not_matter(contact, scale):
    lam, n = CONTACTS[contact]
    one = hunt_crossley_duration_series(SPEED, lam, n, STIFFNESS, ORDER)
    # times are the same where d, v and 1/lam are counted in another unit of length
    scaled = scale * SPEED, lam / scale, n, STIFFNESS * scale ** (1 - n)
    other = hunt_crossley_duration_series(*scaled, ORDER)
    np.testing.assert_allclose(other, one, rtol=1e-11, atol=1e-13 * one[0])
    by_lam = hunt_crossley_duration_lam(SPEED, lam, n, STIFFNESS)
    assert hunt_crossley_duration_lam(*scaled) / scale == pytest.approx(by_lam, rel=1e-12)


def test_what_does_not_move_needs_no_series():
    """Of a speed that is remembered a mode has no more rows than one without it."""
    parameters = {"lam": 0.7, "n": 1.5, "k": STIFFNESS}

    def rows(rate):
        on = {X: hunt_crossley_duration(Z, LAM, N, K) + X, Z: rate}
        return kernels_of(cd.HybridSystem(name="r", states=(X, Z), parameters=parameters, modes={"on": on})).layout.rows

    assert rows(0) < 8 < 28 < rows(1)


def test_what_has_no_series_is_refused():
    def of(rate):
        return cd.HybridSystem(name="r", states=(X, Z), parameters={"lam": 0.7}, modes={"on": {X: rate, Z: 0}})

    with pytest.raises(ModelError, match=r"hunt_crossley_duration\(.*has no Taylor series in its argument 2"):
        of(hunt_crossley_duration(X, Z, 1.5, 100))
    with pytest.raises(ModelError, match=r"hunt_crossley_duration_lam_lam\(.*has no Taylor series"):
        of(hunt_crossley_duration_lam_lam(X, LAM, 1.5, 100))


def test_the_integral_over_a_speed_that_moves():
    law = hunt_crossley_duration(X, LAM, 1.5, 3.0)
    rising = cd.HybridSystem(
        name="rising",
        states=(X,),
        parameters={"lam": 1.5},
        modes={"on": {X: 1}},
        quadratures={"lasted": law},
        initial={"x": 0.25},
    )
    found = cd.trajectory(rising, duration=2.0, times=[2.0], tolerance=1e-14)["lasted"].values
    nodes, weights = np.polynomial.legendre.leggauss(24)
    with mpmath.workdps(20):
        values = [contact_durations.duration(1.25 + mpmath.mpf(a), 1.5, 1.5, 3) for a in nodes]
    assert found[-1] == pytest.approx(float(weights @ np.array(values, dtype=float)), rel=1e-12)


GRAVITY, HEIGHT, PUSH = 9.81, 0.3, 0.7
BALL = {"lam": 0.6, "n": 1.5, "k": 2e3}


def ball(contact, start, guard, direction):
    """A ball that is thrown up after every contact, which lasts as long as its law says."""
    own = "clock" if guard != "left" else "left"
    flight = {"x": "v", "v": f"-{GRAVITY}", "fell": "0", own: "0"}
    return cd.HybridSystem(
        states=f"x v fell {own}",
        parameters=BALL,
        modes={"flight": flight, "contact": {"x": "0", "v": "0", "fell": "0", own: contact}},
        transitions=[
            cd.Transition("touch", "flight", "contact", "x", -1, reset={"x": 0, "v": 0, "fell": "-v", own: start}),
            cd.Transition(
                "part", "contact", "flight", guard, direction, reset={"v": f"hunt_crossley_exit(fell, lam) + {PUSH}"}
            ),
        ],
        initial={"mode": "flight", "x": HEIGHT, "v": 0.0, "fell": 1.0, own: 0.0},
    )


REMEMBERED = ("1", "0", "clock - hunt_crossley_duration(fell, lam, n, k)", 1)
TIMED = ("-1", "hunt_crossley_duration(-v, lam, n, k)", "left", -1)


def test_a_remembered_speed_ends_a_contact_as_a_timer_does():
    law = ball(*REMEMBERED)
    found = cd.trajectory(law, duration=1.0, tolerance=1e-14)["event_time"].values
    fall = mpmath.sqrt(2 * mpmath.mpf(HEIGHT) / mpmath.mpf(GRAVITY))
    speed = mpmath.mpf(GRAVITY) * fall
    lasted = contact_durations.duration(speed, *BALL.values())
    assert found[0] == pytest.approx(float(fall), rel=1e-14)
    assert found[1] == pytest.approx(float(fall + lasted), rel=1e-13)
    long = {"duration": 2.5, "samples": 1, "tolerance": 1e-14, "tangents": True}
    one, other = (cd.trajectory(ball(*of), **long) for of in (REMEMBERED, TIMED))
    np.testing.assert_allclose(one["states"].values[-1, :3], other["states"].values[-1, :3], rtol=1e-11)
    tangents = (run["final_tangent"].values[:2, :3] for run in (one, other))
    np.testing.assert_allclose(*tangents, rtol=1e-10, atol=1e-11)


def test_the_spectrum_is_that_with_a_timer():
    """Saltation carries the change of the duration: in the guard of the one, in the reset of the other."""
    spectra = [cd.lyapunov_spectrum(ball(*of), duration=80, transient=40, blocks=40) for of in (REMEMBERED, TIMED)]
    (first, second), other = (s["lyapunov_exponent"].values[:2] for s in spectra)
    assert first == pytest.approx(other[0], abs=1e-9)
    # over a record of any length areas differ by what the timer adds to them at its ends
    errors = sum(s["lyapunov_error"].values[1] for s in spectra)
    assert second == pytest.approx(other[1], abs=2 * errors)
    assert errors < 0.1
