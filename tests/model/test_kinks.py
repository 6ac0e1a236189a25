"""Fields with kinks and jumps in modes, against closed forms and systems written mode by mode."""

from math import pi, sqrt

import numpy as np
import pytest
import sympy
from scipy.integrate import solve_ivp

import chaosdrill as cd
from chaosdrill.model.definition import write_definition

X, V, T = sympy.symbols("x v t", real=True)


def made(acceleration, **changes):
    given = {"name": "mass", "states": ("x", "v"), "parameters": {}, "field": {"x": "v", "v": acceleration}}
    return cd.in_modes(**{**given, **changes})


def kinds(run):
    return run.cd.words("event_kind").values.tolist()


@pytest.mark.parametrize(
    "force",
    [
        "-x - 3*Max(x, 0)",
        "-x + 3*Min(-x, 0)",
        "-5*x/2 - 3*Abs(x)/2",
        "-x - 3*x*(1 + sign(x))/2",
        -X - 3 * X * sympy.Heaviside(X),
        sympy.Piecewise((-4 * X, X > 0), (-X, True)),
        sympy.Piecewise((-X, X <= 0), (-4 * X, True)),
        "-x - 3*x*heaviside(x)",
        "piecewise(-4*x, x > 0, -x)",
    ],
    ids=str,
)
def test_an_oscillator_of_two_stiffnesses_has_their_mean_period(force):
    system = made(force, initial={"x": 1.0})
    assert system.initial["mode"] == "flow+"
    run = cd.trajectory(system, duration=10, samples=1)
    times = run["event_time"].values
    np.testing.assert_allclose(times, pi / 4 + np.cumsum([0, pi, pi / 2, pi])[: len(times)], rtol=1e-13)
    assert len(times) == 4
    after = 10 - times[-1]
    # four times as stiff above, so that the speed at the kink is 2 everywhere
    assert run["states"].values[-1] == pytest.approx([np.sin(2 * after), 2 * np.cos(2 * after)], abs=1e-12)


@pytest.mark.parametrize("surface", ["tanh(v)", "exp(3*v) - 1", "-2*v*(1 + x**2) - v**3", "1 - (1 - v)**3"])
def test_a_surface_may_be_written_in_any_way(surface):
    """Dry friction takes twice its bound from the amplitude in each half turn."""
    sides = {name: {"x": "v", "v": f"-x {term}"} for name, term in (("above", "- b"), ("below", "+ b"))}
    whole = {"name": "mass", "states": "x v", "parameters": {"b": 0.1}, "initial": {"x": 1.0}}
    turned = {"above": sides["below"], "below": sides["above"]} if surface.startswith("-") else sides
    friction = f"-x {'+' if surface.startswith('-') else '-'} b*sign({surface})"
    for system in (
        cd.filippov(**whole, **turned, surface=surface),
        cd.in_modes(**whole, field={"x": "v", "v": friction}),
    ):
        end = cd.trajectory(system, duration=3 * pi, samples=1)["states"].values[-1]
        assert end[0] == pytest.approx(-0.4, abs=1e-12)


@pytest.mark.parametrize("force", ["-Max(-1, Min(1, 2*x))", "Min(1, Max(-2*x, -1))"])
def test_a_force_that_saturates_is_taken_apart(force):
    """x'' = -2 x within 1/2 of zero and -sign(x) beyond: let go at 5/8, it is at 1/2 with the speed 1/2."""
    system = made(force, initial={"x": 0.625})
    run = cd.trajectory(system, duration=8.0, samples=1)
    within = np.arctan(np.sqrt(2)) * np.sqrt(2)
    expected = 0.5 + np.cumsum([0, within, 1.0, within, 1.0, within])
    assert run["event_time"].values[: len(expected)] == pytest.approx(expected, abs=1e-12)
    assert kinds(run)[0] != kinds(run)[1]


GAP = [
    "x - Max(-b, Min(b, x))",
    "x - Min(Max(x, -b), b)",
    "Max(x - b, Min(0, x + b))",
    "Piecewise(x + b, x < -b, Piecewise(0, x < b, x - b))",
    "sign(x)*Max(Abs(x) - b, 0)",
    "x*(Abs(Abs(x) - b) + Abs(x) - b)/(2*Abs(x))",
    "Piecewise(Piecewise(0, x > -b, x + b), x <= b, x - b)",
]


@pytest.mark.parametrize("stretch", GAP, ids=str)
def test_a_gap_is_the_same_however_it_is_written(stretch):
    """x'' is -4 times what x exceeds 1/2 by: a half swing of pi/2 in each stiff range, and 1 for the way between."""
    given = {"parameters": {"b": 0.5}, "initial": {"v": 1.0}}
    run = cd.trajectory(made(f"-4*({stretch})", **given), duration=9, samples=1)
    expected = 0.5 + np.cumsum([0.0, pi / 2, 1.0, pi / 2, 1.0, pi / 2, 1.0])
    np.testing.assert_allclose(run["event_time"].values, expected, atol=1e-12)


@pytest.mark.parametrize("stretch", GAP, ids=str)
def test_no_order_of_limits_is_wrong_in_silence(stretch):
    """At b = -1/4 a formula says something else, which is followed, or the sweep says that it cannot be."""
    system = made(f"-4*({stretch})", parameters={"b": 0.5}, initial={"v": 1.0}, period="1")
    diagram = cd.bifurcation_diagram(system, {"b": [-0.25]}, transient=0, periods=2, max_extension=0)
    if diagram.cd.words("outcome").item() == "failed":
        return
    rate = sympy.lambdify(X, sympy.sympify(str(stretch), {"x": X, "b": sympy.Rational(-1, 4)}))
    found = solve_ivp(
        lambda t, y: [y[1], -4 * float(rate(y[0]))], (0, 2), [0, 1], rtol=1e-11, atol=1e-12, max_step=1e-2
    )
    np.testing.assert_allclose(diagram["section"].values[0, 0, -1], found.y[:, -1], atol=1e-6)


def test_friction_is_the_filippov_system():
    common = {
        "name": "friction",
        "states": ("x", "v"),
        "time": "t",
        "parameters": {"omega": 0.4, "S": 0.6},
        "period": "2*pi/omega",
    }
    field = {"x": "v", "v": "cos(omega*t) - x - S*sign(v)"}
    sides = {side: {"x": "v", "v": f"cos(omega*t) - x {sign} S"} for side, sign in (("above", "-"), ("below", "+"))}
    one, other = cd.in_modes(**common, field=field), cd.filippov(**common, surface="v", **sides)
    assert write_definition(one) == write_definition(other)
    assert one.initial == other.initial
    turned = cd.in_modes(**common, field=field, surface="-v")
    assert turned.modes["above"] == other.modes["below"]


@pytest.mark.parametrize(
    "written",
    [
        "abs(v - u)/(v - u)",
        "(v - u)/abs(u - v)",
        "2*(v - u)/sqrt((2*v - 2*u)**2)",
        "sign(v - u)**3",
        "(Max(v, u) + Min(v, u) - 2*u)/Abs(u - v)",
        "Abs(v - u)**3/(v - u)**3",
        "Max(-1, Min(1, 2*sign(v - u)))",
    ],
)
def test_friction_is_the_same_however_its_sign_is_written(written):
    common = {"name": "belt", "states": "x v", "parameters": {"f": 0.4, "u": 0.5}}
    one, other = (cd.in_modes(**common, field={"x": "v", "v": f"-x - f*({sign})"}) for sign in ("sign(v - u)", written))
    assert write_definition(one) == write_definition(other)


def test_a_size_over_another_expression_does_not_jump():
    assert "sliding" not in made("-abs(v - 1)/(v + 1) + abs(x)**3/x").modes


@pytest.mark.parametrize(
    "one", ["sign(v)*Abs(v)/v", "(Max(v, 0) + Min(v, 0))/v", "(Abs(v) + v)/(2*v) - (Abs(v) - v)/(2*v)"]
)
def test_what_is_the_same_on_both_sides_is_no_kink(one):
    assert made(f"-x*({one})").mode_names == ("flow",)


def stop(**changes):
    given = {"parameters": {"k": 20.0, "mu": 0.3}, "initial": {"x": -4.0}}
    return made("-x - k*Max(x - 1, 0) - mu*sign(v)", **{**given, **changes})


def test_friction_and_a_soft_stop_take_the_energy_of_the_way():
    run = cd.trajectory(stop(), duration=60, samples=1)
    turns = [t for t, kind in enumerate(kinds(run)) if kind.startswith(("cross", "slide"))]
    places = np.array([-4.0, *run["event_state_after"].values[turns, 0]])
    energy = places**2 / 2 + 20 * np.maximum(places - 1, 0) ** 2 / 2
    np.testing.assert_allclose(energy[:-1] - energy[1:], 0.3 * np.abs(np.diff(places)), rtol=0, atol=1e-12)
    assert kinds(run)[-1].startswith("slide")
    assert abs(places[-1]) <= 0.3
    np.testing.assert_array_equal(run["states"].values[-1], [places[-1], 0])


def test_sliding_that_crosses_a_kink_keeps_its_lost_direction():
    """On v = 1 the stretch grows from the soft range into the stiff one, where friction gives way."""
    friction = {"parameters": {"k": 3.0, "S": 1.0}, "surface": "v - 1"}
    system = made("-x/4 - k*Max(x, 0) - S*sign(v - 1)", **friction, initial={"x": -2.0, "v": 1.0})
    assert system.initial["mode"] == "sliding-"
    run = cd.trajectory(system, duration=2.5, samples=1)
    assert kinds(run) == ["kink-1-sliding-", "leave-down+"]
    assert run["event_time"].values == pytest.approx([2.0, 2 + 1 / 3.25], rel=1e-14)
    spectrum = cd.lyapunov_spectrum(system, duration=1)
    assert list(spectrum["lyapunov_exponent"].values) == [0.0, -np.inf]


def test_chua_is_that_of_the_library():
    known = cd.build("chua")
    p = {**known.parameters}
    system = cd.in_modes(
        name="chua",
        states=("x", "y", "z"),
        parameters=p,
        field={
            "x": "alpha*(y - x - m1*x - (m0 - m1)*(Abs(x + 1) - Abs(x - 1))/2)",
            "y": "x - y + z",
            "z": "-beta*y",
        },
        initial={name: known.initial[name] for name in "xyz"},
    )
    # not above 1 and below -1
    assert len(system.modes) == 3
    runs = [cd.trajectory(s, duration=10, samples=20) for s in (known, system)]
    np.testing.assert_allclose(*(run["states"].values for run in runs), atol=1e-11)
    np.testing.assert_allclose(*(run["event_time"].values for run in runs), atol=1e-11)


def test_a_jump_in_time_is_crossed():
    common = {"states": ("x", "v"), "time": "t", "period": "2*pi"}
    system = made("-x - v/5 + sign(sin(t))", **common)
    assert system.mode_names == ("flow+", "flow-")
    base = cd.HybridSystem(
        name="base", parameters={"f": 0.0}, modes={"flow": {"x": "v", "v": "-x - v/5 + f"}}, **common
    )
    runs = [cd.trajectory(s, periods=3, samples=7)["states"].values for s in (system, cd.driven(base, "f", "square"))]
    np.testing.assert_allclose(*runs, atol=1e-13)


def test_a_relay_on_a_tilted_surface():
    found = cd.lyapunov_spectrum(
        made("-sign(x + tau*v)", parameters={"tau": 0.8}, surface={"s": "x + tau*v"}, initial={"x": 0.5, "v": 0.0}),
        duration=8,
        transient=1,
    )
    assert found["lyapunov_exponent"].values == pytest.approx([-1.25, -np.inf], abs=1e-9)


@pytest.mark.parametrize(
    ("initial", "mode"),
    [
        ({"x": 2.0, "v": 1.0}, "above+"),
        ({"x": 0.5, "v": -1.0}, "below-"),
        ({"x": 0.1}, "sliding-"),
        ({"x": 1.0}, "below+"),
        ({"x": 0.1, "mode": "above-"}, "above-"),
        ({"mode": "sliding-"}, "sliding-"),
    ],
)
def test_a_start_has_the_mode_of_its_sides(initial, mode):
    assert stop(initial=initial).initial["mode"] == mode


@pytest.mark.parametrize(
    ("force", "changes", "message"),
    [
        ("-sign(x) - sign(v)", {}, "jumps at x and at v; one surface is possible"),
        ("-Max(x, v, 1, 2*x - v, x*v)", {}, "kinks at 7 surfaces; at most 5"),
        (sympy.Piecewise((1, X > 0), (2, X < -1)), {}, "has no branch where x [+] 1 > 0"),
        (sympy.Piecewise((1, sympy.Eq(X, 0)), (2, True)), {}, "no inequality between its branches"),
        ("+".join(f"Abs(x - {k})" for k in range(6)), {}, "kinks at 6 surfaces; at most 5"),
        ("-Abs(x)", {"surface": "x"}, "jumps nowhere"),
        ("-sign(v)", {"surface": "x"}, "but the field jumps at v"),
        ("-sign(x + v)", {}, "name it, as in"),
        ("-sign(x*v - 1)", {}, "linear in no state"),
        ("-sign(v)*Max(x, 0)", {}, "jumps on one side of x = 0 only"),
        ("-Abs(K - x)", {}, "unknown name 'K'"),
    ],
)
def test_what_cannot_be_taken_apart_is_refused(force, changes, message):
    with pytest.raises(cd.ModelError, match=message):
        made(force, **changes)


def test_the_speed_at_the_stop_is_that_of_the_energy():
    run = cd.trajectory(stop(parameters={"k": 20.0, "mu": 0.0}), duration=8, samples=1)
    at = [k for k, kind in enumerate(kinds(run)) if kind.startswith("kink")]
    np.testing.assert_allclose(np.abs(run["event_state_after"].values[at, 1]), sqrt(15), rtol=1e-13)


def test_a_sweep_of_a_gap_starts_on_the_side_of_its_state():
    """A soft stop at a gap; the motion is that of the field with its kink, by scipy."""
    system = cd.in_modes(
        name="stop",
        states="x v",
        parameters={"gap": 1.0},
        field={"x": "v", "v": "-x - 5*Max(x - gap, 0) + cos(t)"},
        period="2*pi",
        initial={"x": 0.5},
    )
    gaps = np.array([-1.0, 0.0, 0.5, 0.75, 1.0])
    diagram = cd.bifurcation_diagram(system, {"gap": gaps}, transient=0, periods=2, max_extension=0)
    for gap, row in zip(gaps, diagram["section"].values[:, 0, 0], strict=True):
        steps = {"rtol": 1e-11, "atol": 1e-12, "max_step": 1e-2}
        field = lambda t, y, gap=gap: [y[1], -y[0] - 5 * max(y[0] - gap, 0) + np.cos(t)]  # noqa: E731
        expected = solve_ivp(field, (0, 2 * np.pi), [0.5, 0.0], **steps).y[:, -1]
        np.testing.assert_allclose(row, expected, atol=1e-6)
