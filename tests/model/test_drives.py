"""Drives with corners and jumps, against Fourier series, closed forms and the smooth drive that a table follows."""

from math import exp, pi

import numpy as np
import pytest

import chaosdrill as cd
from chaosdrill.errors import SettingsError

OMEGA, ZETA = 0.8, 0.1
N = np.arange(1, 200_001)


def oscillator(**changes):
    given = {
        "name": "oscillator",
        "states": ("x", "v"),
        "time": "t",
        "parameters": {"f": 0.0, "zeta": ZETA, "omega": OMEGA},
        "modes": {"free": {"x": "v", "v": "-x - 2*zeta*v + f"}},
        "period": "2*pi/omega",
        "initial": {"x": 0.3},
    }
    return cd.HybridSystem(**{**given, **changes})


def jumps_and_kinks(duty=0.5):
    """Coefficients n > 0 of the Fourier series of the drives, exp(2 pi i n phase) with twice their real part."""
    return {
        "square": (1 - np.exp(-2j * pi * N * duty)) / (1j * pi * N),
        "sawtooth": 1j / (pi * N),
        "triangle": -2 * (1 - (-1.0) ** N) / (pi * N) ** 2,
    }


def steady(coefficients, mean, omega, phases):
    """The periodic motion of the linear oscillator."""
    answer = coefficients / (1 - (N * omega) ** 2 + 2j * ZETA * N * omega)
    return mean + np.array([2 * (answer * np.exp(2j * pi * N * p)).real.sum() for p in phases])


@pytest.mark.parametrize("shape", ["square", "sawtooth", "triangle"])
def test_linear_oscillator_follows_the_fourier_series(shape):
    run = cd.trajectory(cd.driven(oscillator(), "f", shape), periods=2, transient=60, samples=8)
    phase = run["time"].values * OMEGA / (2 * pi)
    expected = steady(jumps_and_kinks()[shape], 0.0, OMEGA, phase)
    np.testing.assert_allclose(run["states"].values[:, 0], expected, atol=1e-9)


def test_corners_are_events_at_their_times_and_no_impacts():
    system = cd.driven(oscillator(), "f", {0.1: "1", 0.4: "phase**2", 0.85: "0"})
    assert system.initial["mode"] == "free-2"
    run = cd.trajectory(system, periods=3, samples=2)
    phases = run["event_time"].values * OMEGA / (2 * pi)
    np.testing.assert_allclose(phases, np.add.outer(range(3), [0.1, 0.4, 0.85]).ravel(), rtol=0, atol=1e-14)
    assert {t.kind for t in system.transitions} == {"corner"}
    assert float(cd.lyapunov_spectrum(system, periods=4)["impacts_per_period"]) == 0


def test_a_phase_may_be_a_parameter():
    system = cd.driven(
        oscillator(parameters={"f": 0, "zeta": ZETA, "omega": OMEGA, "duty": 0.5}), "f", {0: 1, "duty": -1}
    )
    for duty in (0.2, 0.9):
        run = cd.trajectory(system.with_parameters(duty=duty), periods=1, transient=60, samples=8)
        phase = run["time"].values * OMEGA / (2 * pi)
        expected = steady(jumps_and_kinks(duty)["square"], 2 * duty - 1, OMEGA, phase)
        np.testing.assert_allclose(run["states"].values[:, 0], expected, atol=1e-9)


@pytest.mark.parametrize("duty", [1e-8, 1e-6, 1e-3, 1 - 1e-3, 1 - 1e-6])
def test_a_short_piece_has_all_its_digits(duty):
    # pulses of area 1, whose integral and whose decay are known
    decay = oscillator(
        states=("x", "y"),
        parameters={"f": 0.0, "duty": duty},
        modes={"free": {"x": "f", "y": "f - y"}},
        period=2.0,
        initial={},
    )
    run = cd.trajectory(cd.driven(decay, "f", {0: "1/duty", "duty": 0}), periods=10, samples=1)
    x, y = run["states"].values[-1]
    assert x == pytest.approx(20, rel=1e-14)
    pulse = -np.expm1(-2 * duty) / duty * exp(-2 * (1 - duty))
    # a pulse as long as a hundred million roundings of the time has eight digits
    assert y == pytest.approx(pulse * -np.expm1(-20) / -np.expm1(-2), rel=max(2e-11, 1e-16 / duty))


@pytest.mark.parametrize(("parameter", "limits"), [("duty", (0.05, 0.95)), ("omega", (0.5, 1.5))])
def test_branches_go_on_where_corners_move(parameter, limits):
    system = cd.driven(
        oscillator(parameters={"f": 0, "zeta": ZETA, "omega": OMEGA, "duty": 0.3}), "f", {0: 1, "duty": -1}
    )
    branch = cd.continue_orbit(system, {parameter: limits})
    assert not branch["special_text"].size
    assert branch[parameter].values[[0, -1]] == pytest.approx(limits)
    for point in range(0, branch.sizes["point"], 20):
        here = {"duty": 0.3, "omega": OMEGA, parameter: float(branch[parameter][point])}
        coefficients = jumps_and_kinks(here["duty"])["square"]
        (expected,) = steady(coefficients, 2 * here["duty"] - 1, here["omega"], [0.0])
        assert float(branch["orbit_state"][point, 0]) == pytest.approx(expected, abs=1e-9)


def pulses(pieces, **parameters):
    """A drive whose mean is its quadrature."""
    return cd.driven(oscillator(parameters={"f": 0, "zeta": ZETA, "omega": OMEGA, **parameters},
                                quadratures={"drive": "f"}), "f", pieces)  # fmt: skip


def test_pieces_out_of_their_order_are_refused():
    duties = np.array([-0.25, 0.0, 1e-9, 1e-6, 0.3, 1 - 1e-6, 1 - 1e-9, 1.0, 1.25])
    inside = (duties > 0) & (duties < 1)
    made = pulses({0: 1, "duty": 0}, duty=0.3)
    diagram = cd.bifurcation_diagram(made, {"duty": duties}, transient=5, periods=8)
    outcomes = np.where(inside, cd.Outcome.PERIODIC, cd.Outcome.FAILED)
    np.testing.assert_array_equal(diagram["outcome"].values[:, 0], outcomes)
    # a time is known to its rounding
    means = diagram["drive_rate"].values[:, 0]
    np.testing.assert_allclose(means, np.where(inside, duties, np.nan), rtol=1e-12, atol=1e-16)
    for duty in duties[~inside]:
        for system in (made, made.with_initial(mode="free-0")):
            with pytest.raises(
                SettingsError, match=r"parameters .*duty.* out of range; expected 0 < duty and duty < 1"
            ):
                cd.trajectory(system.with_parameters(duty=duty), periods=2)
    three = pulses({0: 1, "p": 0, "q": 3}, p=0.3, q=0.6)
    for p, q in ((0.3, 0.6), (0.6, 0.9)):
        spectrum = cd.lyapunov_spectrum(three.with_parameters(p=p, q=q), periods=64, transient=10)
        assert float(spectrum["drive_rate"]) == pytest.approx(p + 3 * (1 - q), rel=1e-12)
    for p, q in ((0.6, 0.6), (0.7, 0.6)):
        with pytest.raises(SettingsError, match="p < q"):
            cd.lyapunov_spectrum(three.with_parameters(p=p, q=q), periods=64, transient=10)


@pytest.mark.parametrize(("p", "mode"), [(0.0, 0), (0.2, 3), (0.59, 2)])
def test_a_drive_starts_in_the_piece_at_phase_0(p, mode):
    made = pulses({"p": 1, "q": "1 + 3*phase"}, p=0.0, q=0.6).with_parameters(p=p)
    assert made.initial["mode"] == f"free-{mode}"
    run = cd.trajectory(made, periods=1, samples=2)
    # on the way to p the last piece goes on beyond the phase 1
    until = min(p, 0.5)
    expected = until + 1.5 * ((1 + until) ** 2 - 1) + (0.5 - until)
    assert run["drive"].values[1] == pytest.approx(expected * 2 * pi / OMEGA, rel=1e-12)


@pytest.mark.parametrize("method", ["taylor", "dop853", "radau", "rk4"])
@pytest.mark.parametrize("width", [1e-8, 1e-5, 0.28])
def test_no_method_steps_over_a_short_piece(method, width):
    made = pulses({0.2: "1/width", "0.2 + width": 0, 0.7: "1/width", "0.7 + width": 0}, width=width)
    run = cd.trajectory(made, periods=5, samples=1, method=method)
    # rounding of the times, and the tolerance of the bisection
    located = 1e-12 if method == "rk4" else 1e-15
    assert run["drive"].values[-1] == pytest.approx(5 * 2 * 2 * pi / OMEGA, rel=max(1e-10, located / width))


@pytest.mark.parametrize("method", ["taylor", "dop853"])
def test_a_sweep_follows_the_period(method):
    system = cd.driven(oscillator(), "f", "square")
    diagram = cd.bifurcation_diagram(
        system, sweep={"omega": np.array([0.5, 1.1, 2.0])}, transient=80, periods=4, method=method
    )
    for row, omega in zip(diagram["section"].values, (0.5, 1.1, 2.0), strict=True):
        (expected,) = steady(jumps_and_kinks()["square"], 0.0, omega, [0.0])
        np.testing.assert_allclose(row[0, :, 0], expected, atol=1e-8)


def test_exponents_and_multipliers_are_the_damping():
    system = cd.driven(oscillator(), "f", "sawtooth")
    exponents = cd.lyapunov_spectrum(system, periods=40, transient=5)["lyapunov_exponent"].values
    assert exponents.sum() == pytest.approx(-2 * ZETA, abs=1e-12)
    orbit = cd.periodic_orbit(system)
    modulus = np.hypot(orbit["multiplier_real"].values, orbit["multiplier_imag"].values)
    assert modulus == pytest.approx([exp(-ZETA * 2 * pi / OMEGA)] * 2, rel=1e-9)


def impacting(drive=None):
    modes = {"free": {"x": "v", "v": f"-x - 2*zeta*v + {drive or 'f'}"}}
    parameters = {"f": 0.0, "zeta": 0.05, "omega": 2.5, "wall": 0.3, "e": 0.8}
    return cd.HybridSystem(
        name="impact oscillator",
        states=("x", "v"),
        time="t",
        parameters=parameters if drive is None else {k: v for k, v in parameters.items() if k != "f"},
        modes=modes,
        transitions=[cd.Transition("impact", "free", "free", "x - wall", +1, {"v": "-e*v"})],
        period="2*pi/omega",
        initial={"v": 0.3},
    )


def test_a_table_of_the_cosine_becomes_the_cosine():
    exact = cd.trajectory(impacting("cos(omega*t)"), periods=3, samples=16)
    errors = []
    for count in (6, 12):
        table = np.cos(2 * pi * np.arange(count) / count)
        run = cd.trajectory(cd.driven(impacting(), "f", table=table), periods=3, samples=16)
        hits = run.cd.words("event_kind").str.contains("impact")
        assert hits.sum() == exact.sizes["event"] > 1
        errors.append(np.abs(run["states"].values - exact["states"].values).max())
    # a cubic spline through n values is as far off as n^-4
    assert errors[0] / errors[1] == pytest.approx(16, rel=0.5)
    assert errors[1] < 3e-4


def test_a_table_at_given_phases_is_the_spline_through_them():
    from scipy.interpolate import CubicSpline

    table = {0.05: 1.0, 0.3: -0.5, 0.45: 0.2, 0.8: 0.4}
    clock = cd.HybridSystem(
        name="integral", states=("x",), time="t", parameters={"f": 0.0}, modes={"free": {"x": "f"}}, period=2.0
    )
    run = cd.trajectory(cd.driven(clock, "f", table=table), periods=2, samples=10)
    spline = CubicSpline([*table, 1.05], [*table.values(), 1.0], bc_type="periodic")
    expected = [2 * spline.integrate(0, t / 2) for t in run["time"].values]
    np.testing.assert_allclose(run["states"].values[:, 0], expected, atol=1e-13)


def block(force, spring=1, **initial):
    """A block of mass 1 on a spring with dry friction 1, pushed to and fro with period 8."""
    return cd.driven(
        cd.filippov(
            name="block",
            states=("x", "v"),
            parameters={"f": 1.0, "A": force},
            surface="v",
            above={"x": "v", "v": f"A*f - {spring}*x - 1"},
            below={"x": "v", "v": f"A*f - {spring}*x + 1"},
            initial=initial,
        ),
        "f",
        "square",
        period=8.0,
    )


def circles(force, times):
    """The same from rest at 0: circles around what friction leaves of the push, and rests that it can hold."""
    now, x, v, found = 0.0, 0.0, 0.0, [(0.0, 0.0)]
    for corner in np.arange(4.0, times[-1] + 4, 4.0):
        push = force if corner % 8 else -force
        while now < corner:
            way = np.sign(v) if v else np.sign(push - x) * (abs(push - x) > 1)
            centre = push - way
            stop = turn_until_rest(x - centre, v) if way else np.inf
            span = min(stop, corner - now)
            at = np.append(times[(times > now) & (times <= now + span)] - now, span)
            places = centre + (x - centre) * np.cos(at) + v * np.sin(at) if way else np.full(len(at), x)
            speeds = v * np.cos(at) - (x - centre) * np.sin(at) if way else np.zeros(len(at))
            found += zip(places[:-1], speeds[:-1], strict=True)
            now, x, v = now + span, places[-1], 0.0 if span == stop else speeds[-1]
    return np.array(found)


def turn_until_rest(y, v):
    """Time to the next zero of v cos(s) - y sin(s)."""
    return np.arctan2(v, y) % pi or pi


@pytest.mark.parametrize("force", [1.5, 2.5])
def test_a_block_that_slides_is_torn_off_by_a_jump(force):
    run = cd.trajectory(block(force), periods=5, samples=40)
    np.testing.assert_allclose(run["states"].values, circles(force, run["time"].values), atol=1e-11)
    kinds = {name[:5] for name in run.cd.words("event_kind").values}
    assert {"corne", "leave"} <= kinds


def test_a_block_that_is_held_keeps_its_lost_direction_over_corners():
    held = block(0.9)
    spectrum = cd.lyapunov_spectrum(held, periods=6, transient=4)
    assert list(spectrum["lyapunov_exponent"].values) == [0.0, -np.inf]
    assert int(spectrum["rank"]) == 1


@pytest.mark.parametrize("period", [2.0, 1.0])
def test_two_drives_may_turn_their_corners_at_once(period):
    base = cd.HybridSystem(
        name="two",
        states=("x",),
        time="t",
        parameters={"f": 0, "g": 0},
        modes={"on": {"x": "f*g - x"}},
        period=2.0,
    )
    system = cd.driven(cd.driven(base, "f", "square"), "g", "square", period=period)
    run = cd.trajectory(system, periods=3, samples=8)
    time, x = run["time"].values, run["states"].values[:, 0]
    if period == 2:
        # the square of a square wave
        np.testing.assert_allclose(x, 1 - np.exp(-time), atol=1e-13)
    else:
        # of signs + - - +, half a unit each
        level, now = 0.0, {0.0: 0.0}
        for k in range(12):
            push = 1 if k % 4 in (0, 3) else -1
            level = push + (level - push) * exp(-0.5)
            now[(k + 1) / 2] = level
        at = np.isclose(time % 0.5, 0, atol=1e-9)
        np.testing.assert_allclose(x[at], [now[round(2 * t) / 2] for t in time[at]], atol=1e-13)
        assert at.sum() >= 12
    # what falls on the end belongs to the run that follows
    assert run.sizes["event"] == (5 if period == 2 else 5 + 11)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("g", "square"), "no parameter 'g' to drive"),
        (("f", "squares"), "unknown drive 'squares'"),
        (("f",), "give one of them"),
        (("f", {}), "must be one of"),
        (("f", {0: 1, 1: 2}), "different phases"),
        (("f", {0.5: 1, "1/2": 2}), "different phases"),
        (("f", {0: 1, "x": 2}), "different phases"),
        (("f", {0: 1, 0.5: "unheard"}), "unknown name 'unheard'"),
    ],
)
def test_what_is_no_drive_is_refused(arguments, message):
    with pytest.raises(cd.ModelError, match=message):
        cd.driven(oscillator(), *arguments)


def test_no_parameter_is_named_as_the_phase():
    named = cd.HybridSystem(states="x", parameters={"f": 0, "phase": 1}, modes={"on": {"x": "f*phase - x"}}, period=1)
    with pytest.raises(cd.ModelError, match="named 'phase', which"):
        cd.driven(named, "f", "square")


@pytest.mark.parametrize(
    "table", [[1, 2], "cosine", [1, 2, float("nan")], {0: 1, 0.5: 2}, {0: 1, 0.5: 2, 1.5: 3}, [1, 2, "a"]]
)
def test_what_is_no_table_is_refused(table):
    with pytest.raises(cd.ModelError):
        cd.driven(oscillator(), "f", table=table)


def test_work_of_a_drive_is_the_energy_that_it_leaves_and_what_is_lost():
    system = cd.driven(oscillator(quadratures={"work": "f*v", "loss": "2*zeta*v**2"}), "f", "square")
    run = cd.trajectory(system, periods=2, samples=20)
    energy = (run["states"] ** 2).sum("state").values / 2
    np.testing.assert_allclose(run["work"] - run["loss"], energy - energy[0], atol=1e-11)


def test_a_guard_may_hold_the_drive_alone():
    """A brake is let go where the drive has risen to 1, in the middle of a piece, and set where it jumps below 1/2."""
    ways = [("let go", "held", "free", "f - 1", +1), ("set", "free", "held", "f - 1/2", -1)]
    brake = cd.HybridSystem(
        states="x", parameters={"f": 0.0}, modes={"held": {"x": "0"}, "free": {"x": "1"}},
        transitions=[cd.Transition(*way) for way in ways],
    )  # fmt: skip
    with pytest.raises(cd.ModelError, match=r"transitions.let go.guard: f - 1 depends on no state and not on time"):
        cd.trajectory(brake, duration=1.0)
    pieces = {0: "0", "1/4": "8*phase - 2", "1/2": "2", "3/4": "0"}
    run = cd.trajectory(cd.driven(brake, "f", pieces, period=4), periods=2)
    moves = ~np.char.startswith(run.cd.words("event_kind").values.astype(str), "corner")
    np.testing.assert_allclose(run["event_time"][moves], [1.5, 3.0, 5.5, 7.0], rtol=1e-14)
    np.testing.assert_allclose(run["states"][-1], 3.0, rtol=1e-14)
    assert cd.system(run).transitions


def test_what_cannot_be_driven_is_refused():
    with pytest.raises(cd.ModelError, match="give period="):
        cd.driven(oscillator(period=None), "f", "square")
    with pytest.raises(cd.ModelError, match="no guard of it sees"):
        block(3.0, spring=0)
    with pytest.raises(cd.ModelError, match="as if that did not move"):
        cd.driven(
            cd.filippov(
                name="belt",
                states=("x", "v"),
                parameters={"f": 0.0},
                surface="v - f",
                above={"x": "v", "v": "-x - 1"},
                below={"x": "v", "v": "-x + 1"},
            ),
            "f",
            "triangle",
            period=5.0,
        )
