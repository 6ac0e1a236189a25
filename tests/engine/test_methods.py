"""Every method keeps its promises: errors on states, event times and tangents, and the events that it finds."""

import ast
import math
import os
import subprocess
import sys
from pathlib import Path

import mpmath
import numpy as np
import pytest
import sympy
from scipy.integrate import DOP853
from support.closed_forms import growth_with_harvest, impact_oscillator

import chaosdrill as cd
from chaosdrill.dataset import Outcome
from chaosdrill.declared import METHODS
from chaosdrill.engine import dop853_tables as tables
from chaosdrill.engine import layout as at
from chaosdrill.engine.methods import DEFAULT, NAMES
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run

X, Y, T, RATE, BEND, FAST, V = sympy.symbols("x y t rate bend fast v", real=True)


# Every method's error on states, event times and tangents is what its tolerance or its step promises.


TOLERANCES = [1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14]

FIXED_STEP = tuple(name for name, method in METHODS.items() if method.fixed_step)
ADAPTIVE = sorted(set(METHODS) - set(FIXED_STEP))

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


@pytest.mark.parametrize("unit", [1.0, 1e6, 1e-6])
@pytest.mark.parametrize(("rate", "start"), [("0*x", 1.0), ("-w*x", 1.0), ("w*(1 - cos(w*t))**4", 0.0)])
@pytest.mark.parametrize("method", ADAPTIVE)
def test_what_begins_with_a_high_power_of_time(method, rate, start, unit):
    """Its size at the start is unknown, and round-off is all of it where steps are short."""
    system = cd.HybridSystem(
        name="late",
        states="x",
        time="t",
        parameters={"w": unit},
        modes={"free": {"x": rate}},
        quadratures={"fourth": "w*(1 - cos(w*t))**4", "eighth": "w*(1 - cos(w*t))**8"},
        transitions=[],
        initial={"mode": "free", "x": start},
    )
    run = cd.trajectory(system, duration=2.0 / unit, samples=1, method=method)
    assert Outcome(int(run["outcome"])) == Outcome.OK
    for name, power in (("fourth", 4), ("eighth", 8)):
        with mpmath.workdps(30):
            exact = float(mpmath.quad(lambda t, power=power: (1 - mpmath.cos(t)) ** power, [0, 1, 2]))
        assert float(run[name][-1]) == pytest.approx(exact, rel=3e-12)


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
    # how far below its tolerance one run is, is chance; where it is loose, the events part the steps
    tolerances = np.logspace(-6, -12, 25)
    runs = [errors(*closed_form, Numerics("dop853", tolerance)) for tolerance in tolerances]
    largest = np.log([found.max() for found, _ in runs])
    assert np.polyfit(np.log(tolerances), largest, 1)[0] == pytest.approx(1, abs=0.1)
    cost = runs[-1][1].evaluations / runs[0][1].evaluations
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


@pytest.mark.parametrize("method", METHODS)
def test_steps_and_evaluations_are_counted(closed_form, method):
    """A Taylor step counts as its order; Runge-Kutta methods cannot do with less than their stages a step.

    Those of ``radau``, seven here, are evaluated twice at least.
    """
    numerics = Numerics(method)
    _, run = errors(*closed_form, numerics)
    least = {"taylor": numerics.order, "rk4": 8, "dop853": 12, "radau": 14}[method] * run.steps
    assert least <= run.evaluations < 3 * least + 500
    run.forget()
    assert run.evaluations == run.steps == 0


# Every method finds the same events: first crossings, ties, departures from a guard; adaptive ones double roots.


@pytest.fixture(scope="module")
def system():
    """Each mode is a case; what it starts from decides what happens."""
    return cd.HybridSystem(
        name="events",
        states=(X, Y),
        time=T,
        parameters={"rate": 1.0, "bend": 1.0, "fast": 40.0},
        modes={
            "throw": {X: Y, Y: -2},
            "clocks": {X: 1, Y: RATE},
            "drift": {X: 1, Y: 0},
            "ramp": {X: Y, Y: BEND * (1 - T)},
            "rest": {X: 0, Y: 0},
        },
        transitions=[
            cd.Transition("reach", "throw", "rest", guard=X, direction=+1),
            cd.Transition("first", "clocks", "clocks", guard=X - 1, direction=+1, reset={X: 0}),
            cd.Transition("second", "clocks", "clocks", guard=Y - 1, direction=+1, reset={Y: 0}),
            cd.Transition("ripple", "drift", "rest", guard=X - 1 + sympy.cos(FAST * T) / 2, direction=+1),
            cd.Transition("hold", "ramp", "rest", guard=X, direction=-1),
        ],
        initial={X: 0, Y: 0},
    )


def events(system, length, method, mode, tolerance=1e-12, **settings):
    """Run and (time, kind) of its events."""
    names = {k: settings.pop(k) for k in ("rate", "bend", "fast") if k in settings}
    steps = settings.pop("steps", 2000) if method in FIXED_STEP else None
    settings.pop("steps", None)
    run = Run(
        system.with_parameters(**names).with_initial(mode=mode, **settings), length, Numerics(method, tolerance, steps)
    )
    rows = np.zeros((100, at.EVENT_COLUMNS + 4))
    assert run.advance(1, events=rows)[0] == cd.Outcome.OK
    found = rows[: run.filled()[1]]
    return run, found[:, [at.EVENT_TIME, at.EVENT_KIND]]


@pytest.mark.parametrize("method", METHODS)
def test_a_first_crossing(system, method):
    """x = -1 + 3 t - t**2."""
    run, found = events(system, 4.0, method, "throw", x=-1.0, y=3.0)
    np.testing.assert_allclose(found, [[(3 - 5**0.5) / 2, 0]], atol=2e-12)
    assert run.mode == "rest"


@pytest.mark.parametrize("gap", [1e-3, 1e-6, 1e-9, 1e-11])
@pytest.mark.parametrize("method", ADAPTIVE)
def test_two_crossings_inside_one_step(system, method, gap):
    """x rises above zero by ``gap`` only, between two roots sqrt(gap) from 1."""
    _, found = events(system, 4.0, method, "throw", x=gap - 1, y=2.0)
    assert len(found) == 1
    # what the round-off of a step does to a root of slope 2 sqrt(gap)
    assert found[0, 0] == pytest.approx(1 - gap**0.5, abs=2e-15 / gap**0.5)


@pytest.mark.parametrize("method", FIXED_STEP)
def test_two_crossings_inside_one_step_pass_a_fixed_step_unseen(system, method):
    assert len(events(system, 4.0, method, "throw", x=1e-6 - 1, y=2.0, steps=10)[1]) == 0


@pytest.mark.parametrize("gap", [1e-3, 1e-6, 1e-9, 1e-11])
@pytest.mark.parametrize("method", METHODS)
def test_a_guard_that_is_missed_by_a_hair_is_no_event(system, method, gap):
    assert len(events(system, 4.0, method, "throw", x=-gap - 1, y=2.0)[1]) == 0


def ties(system, method, rate):
    run, _ = events(system, 10.25, method, "clocks", rate=rate)
    return [*run.counts[1:3], run.ties]


@pytest.mark.parametrize("method", METHODS)
def test_clocks_in_step_tie_every_time(system, method):
    assert ties(system, method, 1.0) == [10, 10, 10]


@pytest.mark.parametrize("method", ADAPTIVE)
def test_clocks_of_different_rates_tie_where_they_meet(system, method):
    """Not so by bisection, which ends late, for each guard by an amount of its own."""
    assert ties(system, method, 2.0) == [10, 20, 10]
    assert ties(system, method, 0.5) == [10, 5, 5]


@pytest.mark.parametrize("method", METHODS)
def test_a_guard_that_moves_faster_than_the_state(system, method):
    _, found = events(system, 4.0, method, "drift")
    first = mpmath.findroot(lambda t: t - 1 + mpmath.cos(40 * t) / 2, (0.6, 0.62), solver="anderson")
    assert len(found) == 1
    assert found[0, 0] == pytest.approx(float(first), abs=2e-12)


@pytest.mark.parametrize("method", METHODS)
def test_a_guard_that_is_left_without_speed_is_met_when_the_state_comes_back(system, method):
    """x = bend (t**2 / 2 - t**3 / 6) starts at zero with no speed, and is back at t = 3."""
    _, found = events(system, 4.0, method, "ramp", bend=1.0)
    np.testing.assert_allclose(found, [[3.0, 4]], atol=4e-12)


@pytest.mark.parametrize("method", METHODS)
def test_a_guard_that_the_state_goes_through_without_speed_acts_at_once(system, method):
    _, found = events(system, 4.0, method, "ramp", bend=-1.0)
    np.testing.assert_array_equal(found, [[0.0, 4]])


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("mode", ["rest", "touch"])
def test_a_mark_is_not_met_where_a_motion_rests_on_it_or_begins_with_a_touch(method, mode):
    modes = {"rest": {"x": "0", "s": "1"}, "touch": {"x": "s", "s": "1"}}
    system = cd.HybridSystem(
        states="x s",
        modes=modes,
        transitions=[cd.Transition(f"mark in {name}", name, name, "x", 1) for name in modes],
        initial={"mode": mode, "x": 0.0, "s": 0.0},
    )
    run = cd.trajectory(system, duration=1.0, samples=1, method=method)
    assert (run.cd.outcome, run.sizes["event"]) == ("ok", 0)


# Errors follow the tolerance: states and event times, on arcs with a closed form, and order 4 for Runge-Kutta.


LENGTH = 20.0


@pytest.fixture(scope="module")
def oscillators():
    """Harmonic oscillator and pendulum, as two modes of one system; the guard is at half of the amplitude."""
    return cd.HybridSystem(
        name="oscillators",
        states=(X, V),
        parameters={},
        modes={"harmonic": {X: V, V: -X}, "pendulum": {X: V, V: -sympy.sin(X)}},
        transitions=[
            cd.Transition(f"pass-{mode}", mode, mode, guard=X - sympy.Rational(1, 2), direction=-1)
            for mode in ("harmonic", "pendulum")
        ],
        initial={X: 1.0, V: 0.0},
    )


def pendulum(t):
    """Angle and speed from rest at 1 rad, by Jacobi's functions."""
    with mpmath.workdps(30):
        k = mpmath.sin(mpmath.mpf(1) / 2)
        u = mpmath.ellipk(k**2) - t
        sn, cn = mpmath.ellipfun("sn", u, k=k), mpmath.ellipfun("cn", u, k=k)
        return float(2 * mpmath.asin(k * sn)), float(-2 * k * cn)


def harmonic(t):
    return math.cos(t), -math.sin(t)


EXACT = {"harmonic": harmonic, "pendulum": pendulum}


def error(system, mode, numerics):
    run = Run(system.with_initial(mode=mode), LENGTH, numerics)
    assert run.advance(1)[0] == cd.Outcome.OK
    return max(abs(a - b) for a, b in zip(run.x, EXACT[mode](LENGTH), strict=True))


@pytest.mark.parametrize("mode", EXACT)
@pytest.mark.parametrize("tolerance", TOLERANCES)
def test_error_stays_near_the_tolerance(oscillators, mode, tolerance):
    assert error(oscillators, mode, Numerics("taylor", tolerance)) < max(20 * tolerance, 2e-14)


@pytest.mark.parametrize("mode", EXACT)
def test_error_falls_with_the_tolerance(oscillators, mode):
    errors = [error(oscillators, mode, Numerics("taylor", tolerance)) for tolerance in TOLERANCES]
    assert errors[0] > 100 * errors[2] > 1e4 * errors[4]


@pytest.mark.parametrize("mode", EXACT)
def test_runge_kutta_is_of_order_four(oscillators, mode):
    steps = np.array([400, 800, 1600, 3200])
    errors = [error(oscillators, mode, Numerics("rk4", 1e-12, int(n))) for n in steps]
    orders = np.diff(np.log(errors)) / np.diff(np.log(1 / steps))
    np.testing.assert_allclose(orders, 4, atol=0.25)


def pass_times(system, mode, **settings):
    run = cd.trajectory(system.with_initial(mode=mode), duration=LENGTH, samples=1, **settings)
    return run["event_time"].values


def exact_times(mode):
    if mode == "harmonic":
        return np.array([math.pi / 3 + 2 * math.pi * k for k in range(4)])[:4]
    with mpmath.workdps(30):
        k = mpmath.sin(mpmath.mpf(1) / 2)
        quarter = mpmath.ellipk(k**2)
        phase = mpmath.ellipf(mpmath.asin(mpmath.sin(mpmath.mpf(1) / 4) / k), k**2)
        return np.array([float(quarter - phase + 4 * quarter * j) for j in range(3)])


@pytest.mark.parametrize("mode", EXACT)
@pytest.mark.parametrize("tolerance", TOLERANCES)
def test_event_times_follow_the_tolerance(oscillators, mode, tolerance):
    times = pass_times(oscillators, mode, tolerance=tolerance)
    exact = exact_times(mode)
    exact = exact[exact < LENGTH]
    assert len(times) == len(exact)
    assert np.abs(times - exact).max() < max(40 * tolerance, 4e-14)


@pytest.mark.parametrize("mode", EXACT)
@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-9])
def test_bisection_follows_its_tolerance(oscillators, mode, tolerance):
    """With 4000 steps the arcs are good to 1e-10, so that the bisection is what is left; it ends late, never early."""
    late = pass_times(oscillators, mode, method="rk4", steps=4000, tolerance=tolerance)[0] - exact_times(mode)[0]
    width = tolerance * LENGTH / 4000
    assert -1e-9 < late < width + 1e-9
    assert width < 1e-8 or late > width / 100


def test_order_grows_as_tolerance_falls():
    orders = [Numerics(tolerance=tolerance).order for tolerance in TOLERANCES]
    assert orders == sorted(orders)
    assert orders[0] < orders[-1] <= 38


# The coefficients of order 8: scipy's, and of the order that they claim, with the step and with the dense output.


def test_coefficients_are_those_of_scipy():
    n = tables.STAGES
    np.testing.assert_array_equal(tables.A[:n, :n], DOP853.A)
    np.testing.assert_array_equal(tables.A[n, :n], DOP853.B)
    np.testing.assert_array_equal(tables.A[n + 1 :], DOP853.A_EXTRA)
    np.testing.assert_array_equal(tables.C, [*DOP853.C, 1, *DOP853.C_EXTRA])
    np.testing.assert_array_equal([*tables.E3, 0], DOP853.E3)
    np.testing.assert_array_equal([*tables.E5, 0], DOP853.E5)


def field(t, x):
    """x = exp(sin(t)) and y = cos(x): nothing in it is linear."""
    return np.array([x[0] * np.cos(t), -np.sin(x[0]) * x[0] * np.cos(t)])


def exact(t):
    x = np.exp(np.sin(t))
    return np.array([x, np.cos(x)])


def step(t, x, h, stages):
    rates = np.zeros((tables.DENSE_STAGES, 2))
    for k in range(stages):
        rates[k] = field(t + tables.C[k] * h, x + h * tables.A[k] @ rates)
    return rates


def orders(lengths, errors):
    return np.diff(np.log(errors)) / np.diff(np.log(lengths))


def test_the_step_is_of_order_eight():
    errors, counts = [], np.array([8, 16, 32])
    for count in counts:
        x, h = exact(0.0), 3 / count
        for i in range(count):
            x = x + h * tables.A[tables.STAGES] @ step(i * h, x, h, tables.STAGES)
        errors.append(np.abs(x - exact(3.0)).max())
    assert orders(1 / counts, errors).min() > 7.8


def test_the_dense_output_is_of_order_seven_and_starts_as_the_flow_does():
    lengths, errors = np.array([0.8, 0.4, 0.2]), []
    for h in lengths:
        rates = step(0.1, exact(0.1), h, tables.DENSE_STAGES)
        powers = h * tables.DENSE @ rates
        np.testing.assert_array_equal(powers[0], h * rates[0])
        u = np.linspace(0, 1, 21)[:, None]
        path = exact(0.1) + sum(u ** (k + 1) * powers[k] for k in range(tables.DEGREE))
        errors.append(np.abs(path - np.array([exact(0.1 + s * h) for s in u[:, 0]])).max())
    # order 7 is a local error of h**8
    assert orders(lengths, errors).min() > 7.5


@pytest.mark.parametrize("function", [np.exp, lambda u: np.cos(3 * u), lambda u: 1 / (2 + u)])
def test_guards_are_interpolated_to_eleven_digits(function):
    series = tables.TO_CHEBYSHEV @ function(tables.NODES)
    powers = tables.TO_POWERS.T @ series
    u = np.linspace(0, 1, 33)
    np.testing.assert_allclose(np.polynomial.polynomial.polyval(u, powers), function(u), atol=1e-11)


def test_no_method_is_known_by_name_but_the_default():
    """What a method can do stands in its own file."""
    found = []
    for path in Path(cd.__file__).parent.rglob("*.py"):
        module = ast.parse(path.read_text(encoding="utf-8"))
        texts = (one for one in ast.walk(module) if isinstance(one, ast.Constant))
        found += [(path.name, one.value) for one in texts if isinstance(one.value, str) and one.value in NAMES]
    assert found == [("methods.py", DEFAULT)]


CONSTANTS = """
import chaosdrill as cd
import numpy as np
from chaosdrill.engine import dop853_tables, guard_errors, radau_tables
from chaosdrill.engine.structure import examine, general_position
for room in (dop853_tables, guard_errors, radau_tables):
    for name, value in sorted(vars(room).items()):
        if name.isupper() and isinstance(value, (float, np.ndarray)):
            print(room.__name__, name, np.asarray(value, float).tobytes().hex())
for n in range(1, 9):
    print(n, general_position(n).tobytes().hex())
for name in ("compass-gait", "drill-string", "lorenz", "simplest-walker"):
    print(name, examine(cd.build(name)).frame.tobytes().hex())
"""


def test_constants_of_the_methods_and_first_tangents_have_the_same_digits_on_every_processor():
    """OpenBLAS sums in the order that suits a processor; whatever runs are made of must not follow it."""
    told = []
    for processor in ("Nehalem", "Haswell", "SkylakeX"):
        other = {**os.environ, "OPENBLAS_CORETYPE": processor}
        told.append(
            subprocess.check_output([sys.executable, "-c", CONSTANTS], env=other, text=True, timeout=120).splitlines()
        )
    assert len(told[0]) > 15
    assert told[1] == told[0]
    assert told[2] == told[0]
