"""The shelf's models against closed forms, published figures, and a hybrid integration that shares nothing with ours.

That one is scipy's integrator with terminal events, restarted after each.
"""

from math import cos, exp, log, pi, sin, sqrt

import numpy as np
import pytest
import scipy
import sympy

import chaosdrill as cd
from chaosdrill import systems

SPANS = {
    "adaptive-integrate-and-fire": 60.0,
    "andronov-clock": 20.0,
    "boost-converter": 1.03,
    "buck-converter": 4.13,
    "compass-gait": 2.0,
    "drill-string": 8.0,
    "duffing": 15.0,
    "gear-rattle": 15.0,
    "henon-heiles": 20.0,
    "impact-pair": 15.0,
    "integrate-and-fire": 10.0,
    "izhikevich": 100.0,
    "print-hammer": 9.0,
    "relay-sliding": 8.0,
    "simplest-walker": 12.0,
    "two-masses-on-belt": 15.0,
    "ueda": 10.0,
}
"""Times over which no model multiplies an error by more than a thousand."""


def integrated(system, end):
    """Mode and state at a time, and how many events there were."""
    t, x = sympy.Symbol("t"), [sympy.Symbol(name) for name in system.state_names]
    plain = {symbol: sympy.Symbol(symbol.name) for e in _expressions(system) for symbol in e.free_symbols}
    values = {sympy.Symbol(name): value for name, value in system.parameters.items()}

    def code(expression):
        return sympy.lambdify([t, x], sympy.sympify(expression).xreplace(plain).subs(values), "math")

    fields = {mode: [code(rates[s]) for s in system.states] for mode, rates in system.modes.items()}
    guards = {}
    for item in system.transitions:
        for mode in item.source:
            reset = [code(item.reset.get(s, s)) for s in system.states]
            outcome = (item.target, reset, None if item.condition is None else code(item.condition))
            guards.setdefault(mode, {}).setdefault((item.guard, item.direction), []).append(outcome)

    def event(expression, direction):
        value = code(expression)

        def reached(time, state):
            return value(time, state)

        reached.terminal, reached.direction = True, direction
        return reached

    now, mode = 0.0, system.initial["mode"]
    state = np.array([system.initial[name] for name in system.state_names], dtype=float)
    count = 0
    while now < end:
        watched = list(guards.get(mode, {}).items())
        options = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-13}

        def field(time, state, rates=fields[mode]):
            return [rate(time, state) for rate in rates]

        # a run begins on the guard that it has just left; nothing else happens within this time
        aside = min(1e-6 * end, end - now)
        part = scipy.integrate.solve_ivp(field, (now, now + aside), state, **options)
        now, state = part.t[-1], part.y[:, -1]
        events = [event(*key) for key, _ in watched]
        part = scipy.integrate.solve_ivp(field, (now, end), state, events=events, max_step=end / 200, **options)
        now, state = part.t[-1], part.y[:, -1]
        if part.status != 1:
            break
        (which,) = [k for k, times in enumerate(part.t_events) if times.size]
        for target, reset, condition in watched[which][1]:
            if condition is None or condition(now, state):
                mode, state = target, np.array([value(now, state) for value in reset], dtype=float)
                count += 1
                break
    return mode, state, count


def _expressions(system):
    yield from (rate for rates in system.modes.values() for rate in rates.values())
    for item in system.transitions:
        yield from (item.guard, *item.reset.values())
        if item.condition is not None:
            yield item.condition


def without_period(system):
    """The same, run for times that are no whole periods."""
    given = ("name", "states", "time", "parameters", "modes", "transitions", "initial")
    return cd.HybridSystem(**{key: getattr(system, key) for key in given})


@pytest.mark.parametrize("name", SPANS)
def test_state_after_a_while(name):
    system = systems.build(name)
    end = SPANS[name]
    run = cd.trajectory(without_period(system), duration=end, samples=1)
    mode, state, count = integrated(system, end)
    assert system.mode_names[int(run["mode"][-1])] == mode
    assert run.sizes["event"] == count
    np.testing.assert_allclose(run["states"].values[-1], state, rtol=0, atol=3e-8 * max(1, np.abs(state).max()))


@pytest.mark.parametrize("name", sorted(SPANS))
def test_tangents_over_several_events(name):
    """Against finite differences of the end state, wherever states that differ a little meet the same events."""
    system, end = without_period(systems.build(name)), SPANS[name] / 4
    start = np.array([system.initial[state] for state in system.state_names], dtype=float)

    def run(x, *, tangents=False):
        moved = system.with_initial(**dict(zip(system.state_names, x.tolist(), strict=True)))
        found = cd.trajectory(moved, duration=end, samples=1, tolerance=1e-14, tangents=tangents)
        assert found["outcome"] == cd.Outcome.OK
        return found

    whole = run(start, tangents=True)
    vectors, size = whole["final_tangent"].values, np.maximum(np.abs(start), 0.1)
    checked = 0
    for j in np.flatnonzero(vectors.any(axis=1)):
        step = 1e-5 * size[j] * np.eye(len(start))[j]
        ends = [run(start + side * step) for side in (1, -1)]
        if all(np.array_equal(one["event_kind"], whole["event_kind"]) for one in ends):
            ahead, behind = (one["states"].values[-1] for one in ends)
            expected = (ahead - behind) / (2e-5 * size[j])
            np.testing.assert_allclose(vectors[j], expected, rtol=0, atol=2e-6 * max(1, np.abs(expected).max()))
            checked += 1
    assert checked


def test_every_model_has_a_known_answer():
    """Those without an integration of their own here have files of their own beside this one."""
    files = {"percussive-drill", "percussive-drill-5d", "impact-oscillator", "bouncing-ball", "belt-stick-slip"}
    files |= {"den-hartog", "rimless-wheel", "chua", "tilted-switch", "saddle-reset", "lorenz", "roessler"}
    assert {*SPANS, *files, "lorenz-96", "kuramoto"} == set(systems.REGISTRY)


def test_impact_pair_hits_each_wall_once_a_period():
    """The symmetric motion in closed form: a hit at phase p leaves with speed u, and half a period later the same."""
    e, w, a, gap = 0.5, 1.0, 1.0, 3.0
    # u (1 - e) w/(2 a e) = sin p,  (u pi (1 + e)/(2 e w) - gap) w^2/(2 a) = cos p
    sine, cosine, offset = (1 - e) * w / (2 * a * e), pi * (1 + e) * w / (4 * a * e), gap * w**2 / (2 * a)
    speeds = np.roots([sine**2 + cosine**2, -2 * cosine * offset, offset**2 - 1])
    run = cd.trajectory(systems.build("impact-pair", {"e": e, "gap": gap}), periods=4, transient=200, samples=1)
    found = np.abs(run["event_state_after"].values[:, 1])
    assert found.size == 8
    np.testing.assert_allclose(found, speeds.max(), rtol=1e-10)


def test_exponents_of_the_rattling_gear_sum_to_its_losses():
    periods = 200
    system = systems.build("gear-rattle")
    found = cd.lyapunov_spectrum(system, periods=periods, transient=20)
    rate = float(found["event_count"].sum()) / (periods * 2 * pi)
    total = -system.parameters["beta"] + 2 * log(system.parameters["e"]) * rate
    assert float(found["lyapunov_exponent"].sum()) == pytest.approx(total, abs=1e-9)


@pytest.mark.parametrize(("limits", "known"), [((24.3, 24.7), 24.516), ((31.0, 31.2), 31.1179)])
def test_buck_converter_doubles_where_it_should(limits, known):
    """The first as published; the second from the linear pieces in 30 digits (published: 31.121)."""
    branch = cd.continue_orbit(systems.build("buck-converter", {"V_in": limits[0]}), {"V_in": limits})
    doubling = branch.cd.words("special_kind") == "period_doubling"
    assert float(branch["special_value"][doubling][0]) == pytest.approx(known, abs=1e-3)


def test_boost_converter_repeats_its_closed_form():
    """Cycle of one clock period: both modes are linear, so the map of a period is known."""
    system = systems.build("boost-converter")
    p = system.parameters
    open_matrix = np.array([[-1 / (p["R"] * p["C"]), 1 / p["C"]], [-1 / p["L"], 0]])
    rest = np.linalg.solve(open_matrix, [0, -p["V_in"] / p["L"]])

    def after(state):
        v, i = state
        closed = (p["I_ref"] - i) * p["L"] / p["V_in"]
        begin = np.array([v * exp(-closed / (p["R"] * p["C"])), p["I_ref"]])
        return rest + scipy.linalg.expm(open_matrix * (p["T"] - closed)) @ (begin - rest)

    fixed = scipy.optimize.fsolve(lambda state: after(state) - state, [15.0, 0.8], xtol=1e-13)
    run = cd.trajectory(system, duration=1, transient=50, samples=1)
    clock = run.cd.words("event_kind") == "clock"
    np.testing.assert_allclose(run["event_state_before"][clock][:, :2], np.tile(fixed, (10, 1)), rtol=1e-10)


def test_integrate_and_fire_spikes_on_time():
    run = cd.trajectory(systems.build("integrate-and-fire"), duration=20, samples=1)
    np.testing.assert_allclose(np.diff(run["event_time"]), log(3.0), rtol=1e-12)


def test_simplest_walker_has_the_gait_of_its_paper():
    """Fixed point of Garcia et al. at a slope of 0.009, after heel strike."""
    run = cd.trajectory(systems.build("simplest-walker"), duration=20, transient=400, samples=1)
    after = run["event_state_after"].values
    np.testing.assert_allclose(
        after[:, :2], np.tile([0.200310900544287, -0.199832473004977], (len(after), 1)), rtol=1e-9
    )


def test_compass_steps_as_published():
    """Step of 0.734 s on 3 degrees (Goswami et al.), after heel strike at Spong and Bullo's state."""
    run = cd.trajectory(systems.build("compass-gait"), duration=8, transient=80, samples=1)
    assert np.diff(run["event_time"]) == pytest.approx(0.734, abs=5e-4)
    np.testing.assert_allclose(run["event_state_after"][-1], [-0.3234, 0.2187, -0.3772, -1.0918], atol=2e-3)


def test_compass_keeps_angular_momentum_at_heel_strike():
    """Against an impulse at the new foot, which the old one leaves: the masses' own equations, with the body free."""
    system = systems.build("compass-gait")
    p = system.parameters
    length = p["a"] + p["b"]
    (strike,) = system.transitions
    rng = np.random.default_rng(3)
    for n, s, vn, vs in rng.uniform(-0.4, 0.4, (5, 4)):
        here = dict(zip(system.state_names, (n, s, vn, vs), strict=True)) | p
        new = [
            float(strike.reset[a].subs({b: here[b.name] for b in strike.reset[a].free_symbols})) for a in system.states
        ]

        # coordinates: the old foot, the angles of the old stance and swing legs
        up_s, up_n = np.array([-cos(s), -sin(s)]), np.array([-cos(n), -sin(n)])
        hip = np.column_stack([np.eye(2), length * up_s, 0 * up_n])
        old = np.column_stack([np.eye(2), p["a"] * up_s, 0 * up_n])
        swing = np.column_stack([np.eye(2), length * up_s, -p["b"] * up_n])
        foot = np.column_stack([np.eye(2), length * up_s, -length * up_n])
        mass = p["M"] * hip.T @ hip + p["m"] * (old.T @ old + swing.T @ swing)
        before = np.array([0, 0, vs, vn])
        hit = np.block([[mass, -foot.T], [foot, np.zeros((2, 2))]])
        after = np.linalg.solve(hit, [*(mass @ before), 0, 0])[:4]
        np.testing.assert_allclose(new, [s, n, after[2], after[3]], atol=1e-12)


def test_andronov_clock_keeps_time():
    h, p = 0.1, 1.0
    period = 2 * pi / sqrt(1 - h**2)
    system = systems.build("andronov-clock")
    run = cd.trajectory(system, duration=40, transient=200, samples=1)
    np.testing.assert_allclose(np.diff(run["event_time"]), period, rtol=1e-11)
    speed = p / sqrt(1 - exp(-2 * h * period))
    np.testing.assert_allclose(run["event_state_after"][:, 1], speed, rtol=1e-10)
    orbit = cd.periodic_orbit(system)
    np.testing.assert_allclose(orbit["multiplier_real"], [1, exp(-2 * h * period)], atol=1e-9)


def test_relay_slides_as_its_surface_says():
    tau = 0.8
    found = cd.lyapunov_spectrum(systems.build("relay-sliding", {"tau": tau}), periods=8, transient=10)
    assert found["lyapunov_exponent"].values == pytest.approx([-1 / tau, -np.inf], abs=1e-9)
    assert int(found["rank"]) == 1


def stick_slip_period(speed, drop):
    """Of a unit mass on a unit spring, from the circle around the kinetic friction."""
    return 2 * drop / speed + 2 * pi - 2 * np.arctan(drop / speed)


def test_masses_that_move_as_one_stick_and_slip_as_one():
    system = systems.build("two-masses-on-belt", initial={"x2": 0.0})
    run = cd.trajectory(system, duration=80, transient=20, samples=1)
    p = system.parameters
    times = np.unique(np.round(run["event_time"], 9))
    cycles = times[2::2] - times[:-2:2]
    np.testing.assert_allclose(cycles, stick_slip_period(p["belt"], p["F_s"] - p["F_k"]), rtol=1e-8)


def test_drill_string_sticks_and_slips_on_a_flat_bottom():
    system = systems.build("drill-string", {"height": 0.0, "speed": 0.5})
    run = cd.trajectory(system, duration=60, transient=20, samples=1)
    p = system.parameters
    cycles = run["event_time"][2:].values - run["event_time"][:-2].values
    np.testing.assert_allclose(cycles, stick_slip_period(p["speed"], p["mu_s"] - p["mu_k"]), rtol=1e-9)


def test_ueda_exponents_are_the_published_ones():
    found = cd.lyapunov_spectrum(systems.build("ueda"), periods=1500, transient=50)
    error = float(found["lyapunov_error"][0])
    np.testing.assert_allclose(found["lyapunov_exponent"], [0.1034, -0.1534], atol=3 * error + 1e-3)
    assert float(found["lyapunov_exponent"].sum()) == pytest.approx(-0.05, abs=1e-9)


def test_duffing_exponents_sum_to_the_damping():
    found = cd.lyapunov_spectrum(systems.build("duffing"), periods=200, transient=50)
    assert float(found["lyapunov_exponent"].sum()) == pytest.approx(-0.25, abs=1e-9)
    assert int(found["outcome"]) == cd.Outcome.CHAOTIC


def test_henon_heiles_keeps_energy_and_pairs_exponents():
    system = systems.build("henon-heiles")
    run = cd.trajectory(system, duration=200, samples=50)
    x, y, p, q = run["states"].values.T
    energy = (p**2 + q**2 + x**2 + y**2) / 2 + x**2 * y - y**3 / 3
    np.testing.assert_allclose(energy, 1 / 8, rtol=1e-10)
    found = cd.lyapunov_spectrum(system, duration=1000)
    exponents, errors = found["lyapunov_exponent"].values, found["lyapunov_error"].values
    assert exponents.sum() == pytest.approx(0, abs=1e-12)
    assert (np.abs(exponents + exponents[::-1]) < 3 * np.hypot(errors, errors[::-1])).all()
