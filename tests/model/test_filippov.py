"""Sliding made from two fields: against fields combined by hand, closed forms, and systems written mode by mode."""

import re
from math import atan2, cos, exp, hypot, pi, sin, sqrt

import numpy as np
import pytest
import sympy
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import chaosdrill as cd
from chaosdrill.model.definition import build_defined, write_definition

RELAY = {"U": 1.0, "tau": 0.8, "d": 0.5, "omega": 2.0}


def relay(states=("x", "v"), **changes):
    given = {
        "name": "relay",
        "states": states,
        "time": "t",
        "parameters": RELAY,
        "surface": {"s": "x + tau*v"},
        "above": {"x": "v", "v": "-U + d*cos(omega*t)"},
        "below": {"x": "v", "v": "U + d*cos(omega*t)"},
        "period": "2*pi/omega",
        "initial": {"x": 2.0},
    }
    return cd.filippov(**{**given, **changes})


def relay_in_its_surface():
    """The same in the state s from the beginning."""
    rates = {side: {"x": "(s - x)/tau", "s": f"(s - x)/tau + tau*({force})"} for side, force in FORCES.items()}
    return relay(("s", "x"), surface="s", initial={"x": 2.0, "s": 2.0}, **rates)


FORCES = {"above": "-U + d*cos(omega*t)", "below": "U + d*cos(omega*t)"}


@pytest.mark.parametrize("make", [relay, lambda: relay(("v", "x")), relay_in_its_surface], ids=["xv", "vx", "sx"])
@pytest.mark.parametrize("transient", [8, 11])
def test_sliding_has_one_exponent_whatever_the_coordinates_and_the_begin(make, transient):
    found = cd.lyapunov_spectrum(make(), periods=8, transient=transient)
    assert found["lyapunov_exponent"].values == pytest.approx([-1 / RELAY["tau"], -np.inf], abs=1e-9)
    assert int(found["rank"]) == 1


def test_a_run_that_starts_in_sliding_has_lost_the_direction_too():
    start = relay(initial={"x": 0.5, "mode": "sliding"})
    assert start.initial["s"] == 0
    found = cd.lyapunov_spectrum(start, periods=4)
    assert found["lyapunov_exponent"].values == pytest.approx([-1.25, -np.inf], abs=1e-9)


def test_relay_reaches_its_surface_in_closed_form_and_decays_on_it():
    system = relay(period=None, initial={"x": 0.5}).with_parameters(d=0.0)
    run = cd.trajectory(system, duration=6, samples=60)
    # x = 1/2 - t^2/2 and v = -t meet x + tau v = 0
    entry = -0.8 + sqrt(0.8**2 + 1)
    assert run["event_time"].values == pytest.approx([entry], rel=1e-13)
    time, (x, s) = run["time"].values, run["states"].values.T
    on = time > entry
    np.testing.assert_allclose(x[on], (0.5 - entry**2 / 2) * np.exp(-(time[on] - entry) / 0.8), rtol=0, atol=1e-13)
    assert (s[on] == 0).all()


def skew(initial, **more):
    """Two fields in three states that are not parallel on the surface y = sin(t)/4."""
    return cd.filippov(
        name="skew",
        states=("x", "y", "z"),
        time="t",
        parameters={"a": 0.7},
        surface="y - sin(t)/4",
        above={"x": "1 + a*z", "y": "-1 - x*z/2 - 2*cos(t)", "z": "-x - z/2"},
        below={"x": "-a*x - y", "y": "2 + z - x", "z": "1 - z*x"},
        initial=initial,
        **more,
    )


def above(t, x, y, z):
    return np.array([1 + 0.7 * z, -1 - x * z / 2 - 2 * cos(t), -x - z / 2])


def below(t, x, y, z):
    return np.array([-0.7 * x - y, 2 + z - x, 1 - z * x])


def normal_speeds(t, state):
    return tuple(field(t, *state)[1] - cos(t) / 4 for field in (above, below))


def slide(t, state):
    """The combination of the two fields along which y - sin(t)/4 stays, its weight found numerically."""
    up, down = above(t, *state), below(t, *state)
    weight = brentq(lambda w: (w * up + (1 - w) * down)[1] - cos(t) / 4, -1, 2, xtol=1e-15)
    return weight * up + (1 - weight) * down


def test_sliding_field_is_the_combination_of_the_fields_by_hand():
    start = [0.1, 0.0, 0.2]

    def up(t, state):
        return normal_speeds(t, state)[0]

    def down(t, state):
        return normal_speeds(t, state)[1]

    up.terminal = down.terminal = True
    options = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-13, "dense_output": True}
    hand = solve_ivp(slide, (0, 10), start, events=(up, down), **options)
    end = hand.t[-1]
    assert 0.2 < end < 10
    system = skew({"x": 0.1, "z": 0.2})
    assert system.initial["mode"] == "sliding"
    run = cd.trajectory(system, duration=end + 0.1, samples=100)
    assert run["event_time"].values[0] == pytest.approx(end, abs=1e-10)
    time = run["time"].values
    np.testing.assert_allclose(run["states"].values[time < end], hand.sol(time[time < end]).T, atol=1e-11)
    side, field = (("up", above), ("down", below))[len(hand.t_events[1])]
    assert run.cd.words("event_kind")[0] == f"leave-{side}"
    after = solve_ivp(lambda t, s: field(t, *s), (end, time[-1]), hand.y[:, -1], **options)
    np.testing.assert_allclose(run["states"].values[-1], after.y[:, -1], atol=1e-10)


def test_tangents_across_entry_and_exit_are_those_of_differences():
    start, step, length = np.array([0.3, 0.4, -0.2]), 1e-6, 6.0

    def end(state):
        run = cd.trajectory(skew(dict(zip("xyz", state, strict=True))), duration=length, samples=1)
        return run["states"].values[-1], run.cd.words("event_kind").values.tolist()

    _, kinds = end(start)
    assert kinds[0].startswith("slide")
    assert any(kind.startswith("leave") for kind in kinds)
    differences = np.array([(end(start + step * e)[0] - end(start - step * e)[0]) / (2 * step) for e in np.eye(3)]).T
    system = skew(dict(zip("xyz", start, strict=True)))
    found = cd.trajectory(system, duration=length, samples=1, tangents=True)["final_tangent"].values
    np.testing.assert_allclose(found.T, differences, atol=1e-7)
    assert np.linalg.matrix_rank(found, tol=1e-10) == 2


@pytest.mark.parametrize(("omega", "force"), [(0.8, 0.3), (0.4, 0.6)])
def test_dry_friction_is_the_system_written_by_hand(omega, force):
    made = cd.filippov(
        name="den-hartog",
        states=("x", "v"),
        time="t",
        parameters={"omega": omega, "S": force},
        surface="v",
        above={"x": "v", "v": "cos(omega*t) - x - S"},
        below={"x": "v", "v": "cos(omega*t) - x + S"},
        period="2*pi/omega",
        initial={"v": 1.0},
    )
    by_hand = cd.build("den-hartog", {"omega": omega, "S": force})
    runs = [cd.trajectory(system, periods=6, samples=5) for system in (made, by_hand)]
    for name in ("event_time", "states", "mode"):
        values = [run[name].values for run in runs] if name != "mode" else [mode_names(run) for run in runs]
        np.testing.assert_array_equal(*values)
    spectra = [cd.lyapunov_spectrum(s, periods=30, transient=7)["lyapunov_exponent"].values for s in (made, by_hand)]
    np.testing.assert_allclose(*spectra, rtol=1e-13)


def mode_names(run):
    words = {"forward": "above", "backward": "below", "stick": "sliding"}
    return [words.get(name, name) for name in run.cd.words("mode").values]


def belt(**changes):
    """A mass on a belt whose friction falls linearly with the speed of slip."""
    given = {
        "name": "belt",
        "states": ("x", "v"),
        "parameters": {"belt": 0.3, "hold": 1.0, "fall": 0.4},
        "surface": "v - belt",
        "above": {"x": "v", "v": "-x - hold + fall*(v - belt)"},
        "below": {"x": "v", "v": "-x + hold + fall*(v - belt)"},
        "initial": {"x": 0.5, "mode": "sliding"},
    }
    return cd.filippov(**{**given, **changes})


def test_stick_slip_period_on_a_belt():
    speed, hold, fall = 0.3, 1.0, 0.4
    # slip: y'' - fall y' + y = 0 around the rest at hold - fall speed, until the mass is as fast as the belt again
    growth, turn = fall / 2, sqrt(1 - fall**2 / 4)
    first = fall * speed

    def place(t):
        sine = (speed - growth * first) / turn
        return exp(growth * t) * (first * cos(turn * t) + sine * sin(turn * t))

    def velocity(t):
        step = 1e-30
        sine = (speed - growth * first) / turn
        z = complex(t, step)
        wave = np.exp(growth * z) * (first * np.cos(turn * z) + sine * np.sin(turn * z))
        return wave.imag / step

    slip = brentq(lambda t: velocity(t) - speed, 3.5, 2 * pi / turn, xtol=1e-14)
    stick = (hold - (hold - fall * speed + place(slip))) / speed
    run = cd.trajectory(belt(), duration=100, samples=1)
    leaves = run["event_time"].values[run.cd.words("event_kind") == "leave-down"]
    assert leaves[0] == pytest.approx((hold - 0.5) / speed, rel=1e-14)
    np.testing.assert_allclose(np.diff(leaves), slip + stick, rtol=1e-11)
    spectrum = cd.lyapunov_spectrum(belt(), duration=20 * (slip + stick), transient=slip + stick)
    assert spectrum["lyapunov_exponent"].values == pytest.approx([0, -np.inf], abs=1e-9)


@pytest.mark.parametrize("excess", [-1e-3, 1e-8])
def test_grazing_sliding_takes_one_multiplier(excess):
    """A driven mass that slips on a belt of speed 1: from the force on at which it is as fast as the belt it sticks."""
    zeta, omega = 0.05, 0.7
    graze = hypot(1 - omega**2, 2 * zeta * omega) / omega
    phase = atan2(2 * zeta * omega, 1 - omega**2)
    load = "F*cos(omega*t) - 2*zeta*v - x"
    force = graze * (1 + excess)
    amplitude = force / hypot(1 - omega**2, 2 * zeta * omega)
    system = cd.filippov(
        name="driven mass on a belt",
        states=("x", "v"),
        time="t",
        parameters={"F": force, "S": 1.0, "V": 1.0, "zeta": zeta, "omega": omega},
        surface="v - V",
        above={"x": "v", "v": f"{load} - S"},
        below={"x": "v", "v": f"{load} + S"},
        period="2*pi/omega",
        initial={"x": 1 + amplitude * cos(phase), "v": amplitude * omega * sin(phase)},
    )
    section = cd.poincare_section(system, periods=4, transient=600)
    modulus = np.hypot(section["multiplier_real"].values, section["multiplier_imag"].values)
    period, turn = 2 * pi / omega, sqrt(1 - zeta**2)
    if excess < 0:
        assert modulus == pytest.approx([exp(-zeta * period)] * 2, rel=1e-10)
    else:
        left = exp(-zeta * period) * (cos(turn * period) + zeta / turn * sin(turn * period))
        assert section["multiplier_real"].values == pytest.approx([left, 0], abs=3 * excess**0.5)
        assert modulus[1] == 0


def two_fold(**changes):
    """Rates of the surface that change sign at one instant, t = 1: what attracts repels from then on."""
    given = {
        "name": "two-fold",
        "states": ("x", "y"),
        "time": "t",
        "parameters": {},
        "surface": "y",
        "above": {"x": "1", "y": "t - 1"},
        "below": {"x": "-2", "y": "1 - t"},
    }
    return cd.filippov(**{**given, **changes})


def test_where_both_fields_turn_away_the_motion_leaves_upward():
    run = cd.trajectory(two_fold(), duration=3, samples=6)
    assert run["event_time"].values == pytest.approx([1.0], abs=1e-15)
    time, (x, y) = run["time"].values, run["states"].values.T
    # equal and opposite speeds: half of each field
    np.testing.assert_allclose(x, np.where(time < 1, -time / 2, -0.5 + (time - 1)), atol=1e-14)
    np.testing.assert_allclose(y, np.where(time < 1, 0, (time - 1) ** 2 / 2), atol=1e-14)


def test_a_start_where_both_fields_point_away_leaves_to_the_side_that_is_named():
    away = {"above": {"x": "v", "v": "1"}, "below": {"x": "v", "v": "-1"}}
    made = {"name": "escape", "states": ("x", "v"), "parameters": {}, "surface": "v", **away}
    for initial, side in (({}, 1), ({"mode": "above"}, 1), ({"mode": "below"}, -1)):
        run = cd.trajectory(cd.filippov(**made, initial=initial), duration=2, samples=4)
        assert run.sizes["event"] == 0
        np.testing.assert_allclose(run["states"].values[:, 1], side * run["time"].values)
    repelling = two_fold(initial={"x": 0.0}, above={"x": "1", "y": "1 + x**2"}, below={"x": "-2", "y": "-1 - x**2"})
    assert repelling.initial["mode"] == "above"
    with pytest.warns(cd.StartWarning):
        refused = cd.trajectory(repelling.with_initial(mode="sliding"), duration=1, samples=2)
    assert int(refused["outcome"]) == cd.Outcome.INVALID_START


@pytest.mark.parametrize(
    ("v", "mode"),
    [(0.1, "above"), (-0.1, "below"), (0.0, "sliding")],
)
def test_a_start_has_the_mode_of_its_side(v, mode):
    friction = {"above": {"x": "v", "v": "-x - 1"}, "below": {"x": "v", "v": "-x + 1"}}
    made = {"name": "block", "states": ("x", "v"), "parameters": {}, "surface": "v", **friction}
    assert cd.filippov(**made, initial={"x": 0.5, "v": v}).initial["mode"] == mode


@pytest.mark.parametrize(("x", "mode"), [(2.0, "below"), (-2.0, "above")])
def test_a_start_on_the_surface_goes_where_friction_cannot_hold(x, mode):
    friction = {"above": {"x": "v", "v": "-x - 1"}, "below": {"x": "v", "v": "-x + 1"}}
    made = cd.filippov(name="block", states=("x", "v"), parameters={}, surface="v", **friction, initial={"x": x})
    assert made.initial["mode"] == mode
    run = cd.trajectory(made, duration=1, samples=1)
    side = np.sign(x)
    assert run["states"].values[-1] == pytest.approx([side + side * cos(1), -side * sin(1)], abs=1e-13)


@pytest.mark.parametrize("fall", ["-2", "-2.0", "-4*a"])
def test_fields_that_cross_alike_have_no_sliding_mode(fall):
    made = cd.filippov(
        name="refraction",
        states=("x", "y"),
        parameters={"a": 0.5},
        surface="y",
        above={"x": "1", "y": fall},
        below={"x": "5", "y": fall},
        initial={"y": 1.0},
    )
    assert made.mode_names == ("above", "below")
    run = cd.trajectory(made, duration=1, samples=1)
    assert run["event_time"].values == pytest.approx([0.5])
    assert run["states"].values[-1] == pytest.approx([3.0, -1.0])


@pytest.mark.parametrize("writing", ["({})**3", "tanh({})", "exp({}) - 1", "{0} + ({0})**3"])
def test_a_surface_with_a_name_is_the_same_in_any_writing(writing):
    other, one = relay(surface={"s": writing.format("x + tau*v")}), relay()
    assert (other.modes, other.transitions, other.regions) == (one.modes, one.transitions, one.regions)


def test_a_start_on_the_surface_but_for_rounding_slides():
    assert 0.3 + 0.1 * -3.0 != 0
    start = relay(initial={"x": 0.3, "v": -3.0}, parameters={**RELAY, "tau": 0.1, "U": 60.0})
    assert start.initial == {"mode": "sliding", "x": 0.3, "s": 0.0}


def test_equivalent_control_is_that_of_filippov_where_it_enters_linearly():
    control = {"field": {"x": "v", "v": "u + d*cos(omega*t)"}, "control": {"u": ("-U", "U")}}
    made = cd.equivalent_control(
        name="relay",
        states=("x", "v"),
        time="t",
        parameters=RELAY,
        surface={"s": "x + tau*v"},
        period="2*pi/omega",
        initial={"x": 2.0},
        **control,
    )
    np.testing.assert_array_equal(
        *(cd.trajectory(system, periods=6, samples=5)["states"].values for system in (made, relay()))
    )


def test_equivalent_control_differs_where_the_control_enters_otherwise():
    """On y = 0 the control is x, so that x' = x^2; the fields of u = 1 and u = -1 both have x' = 1."""
    fields = {side: {"x": "1", "y": f"-x + {u}"} for side, u in (("above", "(-1)"), ("below", "1"))}
    common = {"name": "square", "states": ("x", "y"), "parameters": {}, "surface": "y", "initial": {"x": 0.5}}
    control = cd.equivalent_control(**common, field={"x": "u**2", "y": "u - x"}, control={"u": (-1, 1)})
    combined = cd.filippov(**common, **fields)
    one, other = (cd.trajectory(system, duration=1.5, samples=6) for system in (control, combined))
    time = one["time"].values
    on = time < 1
    np.testing.assert_allclose(one["states"].values[on, 0], 1 / (2 - time[on]), rtol=1e-13)
    # x = 1 is reached, the control is at its bound, and the motion leaves downward
    assert one["event_time"].values == pytest.approx([1.0], abs=1e-13)
    np.testing.assert_allclose(other["states"].values[:, 0], 0.5 + time, rtol=1e-13)
    assert other["event_time"].values == pytest.approx([0.5], abs=1e-13)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"surface": ["x", "v"]}, "convex combinations of them that stay on both are not unique"),
        ({"surface": {"a": "x", "b": "v"}}, "one surface is possible"),
        ({"surface": "x + tau*v"}, r"surface=\{'s': 'tau\*v \+ x'\}"),
        ({"surface": "x**2 - 1"}, "linear in no state"),
        ({"surface": "x*v - 1"}, "linear in no state"),
        ({"surface": "tau - 1"}, "depends on no state"),
        ({"surface": {"x": "x + tau*v"}}, "names something else"),
        ({"above": {"x": "v"}}, "above gives no derivative for state 'v'"),
        ({"below": {"x": "v", "v": "1", "w": "1"}}, "gives a derivative for w"),
        ({"above": {"x": "v", "v": "-K"}}, "unknown name 'K'"),
        ({"initial": {"mode": "sliding", "x": 1.0, "v": 1.0}}, "1.8 away from the surface"),
        ({"initial": {"s": 1.0, "v": 1.0}}, "leave one out"),
        ({"states": 3}, "names in order"),
        ({"parameters": {**RELAY, "tau": 0.0}}, "does not depend on 'v', since tau is zero"),
    ],
)
def test_what_cannot_slide_is_refused(changes, message):
    with pytest.raises(cd.ModelError, match=message):
        relay(**changes)


@pytest.mark.parametrize(
    ("field", "control", "message"),
    [
        ({"x": "v + u", "v": "-x"}, {"u": (1, -1)}, "does not act"),
        ({"x": "v", "v": "u**3"}, {"u": (1, -1)}, "not linear in the control"),
        ({"x": "v", "v": "u"}, {"u": 1}, "above and below"),
        ({"x": "v", "v": "x"}, {"x": (1, -1)}, "names something else"),
        ({"x": "v", "v": "u + w"}, {"u": (1, -1), "w": (1, -1)}, "must be one control"),
    ],
)
def test_what_no_control_keeps_on_the_surface_is_refused(field, control, message):
    with pytest.raises(cd.ModelError, match=message):
        cd.equivalent_control(name="none", states=("x", "v"), parameters={}, surface="v", field=field, control=control)


def test_an_orbit_with_sliding_has_the_multipliers_of_the_belt():
    found = cd.periodic_orbit(belt())
    assert found["multiplier_real"].values == pytest.approx([1, 0], abs=1e-9)
    assert int(found["rank"]) == 1


def test_names_do_not_matter():
    system, names = skew({"x": 0.3, "y": 0.4, "z": -0.2}), {"x": "q9", "y": "a1", "z": "p_0", "a": "zeta", "t": "b"}

    def called(field):
        return {names[state]: sub(rate) for state, rate in field.items()}

    def sub(text):
        return re.sub(r"\b[xyzat]\b", lambda found: names[found[0]], text)

    other = cd.filippov(
        name="skew",
        states=("q9", "a1", "p_0"),
        time="b",
        parameters={"zeta": 0.7},
        surface=sub("y - sin(t)/4"),
        above=called({"x": "1 + a*z", "y": "-1 - x*z/2 - 2*cos(t)", "z": "-x - z/2"}),
        below=called({"x": "-a*x - y", "y": "2 + z - x", "z": "1 - z*x"}),
        initial={"q9": 0.3, "a1": 0.4, "p_0": -0.2},
    )
    runs = [cd.trajectory(made, duration=8, samples=3)["states"].values for made in (system, other)]
    np.testing.assert_array_equal(*runs)


def test_what_is_made_is_written_and_read_like_any_system():
    for made in (relay(), skew({}), belt()):
        again = build_defined(write_definition(made), made.parameters, made.initial)
        assert write_definition(again) == write_definition(made)
        assert again.initial == made.initial


def test_a_wall_is_added_to_what_is_made():
    """A block with friction between a spring and a wall loses the work of friction and a part at the wall."""
    made = cd.filippov(
        name="block",
        states=("x", "v"),
        parameters={"S": 0.1, "e": 0.8},
        surface="v",
        above={"x": "v", "v": "-x - S"},
        below={"x": "v", "v": "-x + S"},
    )
    walled = cd.HybridSystem(
        name="block and wall",
        states=made.states,
        parameters=made.parameters,
        modes=made.modes,
        transitions=[*made.transitions, cd.Transition("impact", "above", "below", "x - 1", +1, {"v": "-e*v"})],
        initial={"mode": "above", "x": -3.0},
    )
    run = cd.trajectory(walled, duration=60, samples=1)
    assert run.cd.words("event_kind")[:3].values.tolist() == ["impact", "cross-up", "impact"]
    # from rest at -3 to the wall at 1, back to rest at -y, to the wall again
    first = sqrt(9 - 1 - 2 * 0.1 * 4)
    assert run["event_speed"].values[0] == pytest.approx(first, rel=1e-13)
    y = -run["event_state_after"].values[1, 0]
    assert (0.8 * first) ** 2 + 1 == pytest.approx(y**2 + 2 * 0.1 * (1 + y), rel=1e-13)
    assert run["event_speed"].values[2] == pytest.approx(sqrt(y**2 - 1 - 2 * 0.1 * (1 + y)), rel=1e-13)
    assert str(run.cd.words("event_kind")[-1].values).startswith("slide")


@pytest.mark.parametrize("initial", [{"v": 2.0}, {"mode": "above", "v": 2.0}])
def test_time_is_called_t_unless_something_else_is(initial):
    given = {
        "name": "belt",
        "states": "x v",
        "parameters": {"mu": 0.3, "omega": 1.1},
        "surface": {"s": "v - cos(omega*t)"},
        "above": {"x": "v", "v": "-x - mu"},
        "below": {"x": "v", "v": "-x + mu"},
        "period": "2*pi/omega",
        "initial": initial,
    }
    runs = [cd.trajectory(cd.filippov(**given, **named), periods=2, samples=10) for named in ({}, {"time": "t"})]
    np.testing.assert_array_equal(runs[0]["states"].values, runs[1]["states"].values)


def test_pi_is_the_number_unless_something_is_called_so():
    drive = {"x": "v", "v": "pi - 2*abs(x) + pi*cos(pi*t)"}
    number = cd.in_modes(name="drive", states="x v", parameters={}, field=drive, period="2")
    assert number.time is not None
    assert not any(
        one.name == "pi" for rates in number.modes.values() for e in rates.values() for one in e.free_symbols
    )
    named = cd.in_modes(name="drive", states="x v", parameters={"pi": 3.0}, field=drive)
    assert all(sympy.Symbol("pi", real=True) in rates[named.states[1]].free_symbols for rates in named.modes.values())
    belt = {"name": "belt", "states": "v", "parameters": {}}
    belt |= {"above": {"v": "-pi"}, "below": {"v": "pi"}, "initial": {"v": 3 * np.pi}}
    run = cd.trajectory(cd.filippov(**belt, surface="v - pi"), duration=3.0, samples=1)
    assert run["event_time"].values == pytest.approx([2.0], abs=1e-13)
    x, symbol = sympy.symbols("x pi")
    grown = cd.HybridSystem(states="x", modes={"on": {x: symbol * x}})
    assert grown.modes["on"][grown.states[0]] == sympy.pi * grown.states[0]


@pytest.mark.parametrize("method", ["taylor", "dop853", "radau"])
@pytest.mark.parametrize("start", [1.0, -1.0])
def test_friction_that_vanishes_holds_nothing_at_the_turn_of_its_demand(start, method):
    """At x = 1 the force on a body at rest is zero, and so is its rate: its next derivative moves the body."""
    rates = {"x": "v", "v": "-x - v/10 + cos(4*t/5)"}
    parts = {"states": "x v", "period": "5*pi/2", "initial": {"x": start}}
    rubbed = {side: rates | {"v": f"{rates['v']} {sign} S"} for side, sign in (("above", "-"), ("below", "+"))}
    friction = cd.filippov(parameters={"S": 0.0}, surface="v", **rubbed, **parts)
    free = cd.HybridSystem(modes={"free": rates}, **parts)
    runs = [cd.trajectory(system, periods=3, samples=5, method=method)["states"] for system in (friction, free)]
    np.testing.assert_allclose(*runs, rtol=0, atol=1e-9)
    if method == "taylor":
        exponents = cd.lyapunov_spectrum(friction, periods=100, transient=10)["lyapunov_exponent"].values
        assert exponents == pytest.approx([-0.05, -0.05], abs=1e-3)
