"""A kink or a jump inside of a flow would be stepped over in silence: it is refused when the system is made.

The message tells the modes to write instead. It is the same for text, for sympy, and in a scene.
"""

import math

import pytest
import sympy

import chaosdrill as cd
from chaosdrill.model.text import write_text

X, T, K = sympy.symbols("x t k", real=True)

COUNTED = "with a state n of rate 0 in every mode that a transition resets to n + 1 where the guard"
KINKS = {
    "Abs": (sympy.Abs(X), "a mode with x for it, one with -x for it, and a guard x between them"),
    "sign": (-sympy.sign(X - K), "a mode with 1 for it, one with -1 for it, and a guard -k + x between them"),
    "Max": (sympy.Max(X, K), "with k for it, one with x for it, and a guard k - x between them"),
    "Min": (1 + sympy.Min(X, 2), "with 2 for it, one with x for it, and a guard 2 - x between them"),
    "Heaviside": (sympy.Heaviside(X), "a mode with 1 for it, one with 0 for it, and a guard x between them"),
    "Mod": (sympy.Mod(X, K), f"write -k*n + x for it, {COUNTED} -k*(n + 1) + x rises"),
    "Mod of time": (sympy.Mod(T, 3), f"write -3*n + t for it, {COUNTED} -3*n + t - 3 rises"),
    "Piecewise": (
        sympy.Piecewise((X, X > K), (2 * X, True)),
        "its branches as modes with a guard between them, such as k - x",
    ),
    "floor": (1 + sympy.floor(X), f"write n for it, {COUNTED} -n + x - 1 rises"),
    "ceiling": (1 + sympy.ceiling(T), f"write n for it, {COUNTED} -n + t rises"),
    "frac": (sympy.frac(X), "write Mod(x, 1)"),
    "inside of a function": (sympy.sin(sympy.Abs(X)), "a mode with x for it"),
    "root of a square": (sympy.sqrt(X**2), "a mode with x for it, one with -x for it"),
}
NO_TEXT = ("frac",)


def flow(rate, **more):
    return cd.HybridSystem(name="kink", states="x", parameters={"k": 1.0}, modes={"on": {"x": rate}}, **more)


def refusal(make, given):
    with pytest.raises(cd.ChaosdrillError) as caught:
        make(given)
    return str(caught.value)


@pytest.mark.parametrize("kink", KINKS)
def test_a_kink_in_a_rate_is_refused_with_the_mode_to_write(kink):
    rate, instead = KINKS[kink]
    for given in (rate,) if kink in NO_TEXT else (rate, write_text(rate)):
        told = refusal(flow, given)
        assert told.startswith("kink: modes.on.x: ")
        assert instead in told
        assert "\n" not in told


@pytest.mark.parametrize("kink", KINKS)
def test_a_kink_in_a_rate_is_refused_in_a_scene(kink):
    rate, instead = KINKS[kink]
    text = write_text(rate)
    scene = f'[system.definition]\nstates = "x"\nmodes.on.x = "{text}"\n[system.parameters]\nk = 1.0\n'
    told = refusal(cd.parse_scene, scene)
    assert told.startswith("scene.toml:3: system.definition.modes.on.x: ")
    assert ("write" if kink in NO_TEXT else instead) in told


@pytest.mark.parametrize("function", ["Abs", "sign", "Max", "Min", "Mod", "floor"])
def test_kinks_of_parameters_are_none(function):
    arguments = "k" if function in ("Abs", "sign", "floor") else "k, 2"
    system = flow(f"-{function}({arguments})*x", initial={"x": 1.0})
    value = {"Abs": 1.0, "sign": 1.0, "Max": 2.0, "Min": 1.0, "Mod": 1.0, "floor": 1.0}[function]
    end = cd.trajectory(system, duration=1.0, samples=2)["states"].values[-1, 0]
    assert end == pytest.approx(2.718281828459045**-value, rel=1e-11)


@pytest.mark.parametrize("function", [sympy.besselj(0, X), sympy.Function("mine")(X)])
def test_a_function_that_there_is_not_is_refused(function):
    with pytest.raises(cd.ModelError, match=r"modes.on.x: unknown function '(besselj|mine)'; "):
        flow(-X + function)


@pytest.mark.parametrize("function", [sympy.gamma(X + 2), sympy.erf(X), sympy.gamma(K)])
def test_a_function_without_a_series_is_refused_and_what_there_is_is_told(function):
    with pytest.raises(cd.ModelError, match=r"has no Taylor series, .* only; .*exp, log, .*acos, .*powers"):
        flow(-X + function)


@pytest.mark.parametrize(
    ("written", "value"), [("acosh(x)", math.acosh(1.7)), ("atan2(x, t + 1)", math.atan2(1.7, 1.4))]
)
def test_a_function_that_others_make_is_refused_with_what_to_write(written, value):
    with pytest.raises(cd.ModelError, match=r"has no Taylor series, .*; write ") as caught:
        flow(written)
    instead = str(caught.value).split("; write ")[1].split(" for it")[0]
    (rate,) = flow(instead).modes["on"].values()
    assert float(rate.subs({X: 1.7, T: 0.4})) == pytest.approx(value, rel=1e-14)


def test_no_way_is_promised_for_three_branches():
    with pytest.raises(cd.ModelError, match="guards between them") as caught:
        flow(sympy.Max(X, T, 0))
    assert "in_modes" not in str(caught.value)


@pytest.mark.parametrize("at", ["guard", "quadrature"])
def test_a_kink_elsewhere_in_a_flow_is_refused(at):
    ring = cd.Transition("ring", "on", "on", guard="Abs(x) - 1", direction=+1, reset={X: 0})
    more = {"transitions": [ring]} if at == "guard" else {"quadratures": {"path": "Abs(x)"}}
    place = "transitions.ring.guard" if at == "guard" else "quadratures.path"
    with pytest.raises(cd.ModelError, match=f"kink: {place}: .*write a mode with x for it"):
        flow(1, **more)


def test_a_reset_without_a_derivative_is_refused_by_the_name_of_its_transition():
    fold = cd.Transition("fold", "on", "on", guard=X - 1, direction=+1, reset={X: sympy.Max(X - 2, T)})
    with pytest.raises(cd.ModelError, match=r"transitions.fold.reset.x: .*transitions of their own with a condition"):
        flow(1, transitions=[fold])


def test_resets_and_conditions_hold_what_flows_cannot():
    """x' = 1 from 0 to 1, then to |x - 3| = 2, since the remainder of 1 by 2 is above 0.5."""
    back = cd.Transition("back", "on", "on", "x - 1", +1, {"x": "Abs(x - 3)"}, "Mod(x, 2) > 0.5 and Max(x, 0) < 2")
    states = cd.trajectory(flow(1, transitions=[back]), duration=2.0, samples=2)["states"].values[:, 0]
    assert states == pytest.approx([0.0, 1.0, 3.0], abs=1e-12) or states[-1] == pytest.approx(3.0, abs=1e-12)


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        ("Min(sin(x), 2)", "sin(x)"),
        ("Max(x**2, -1)", "x**2"),
        ("Max(x**2, 0, sin(x)**2 - 1)", "x**2"),
        ("Min(sin(x)**2*cos(x), 2)", "sin(x)**2*cos(x)"),
        ("Abs(2 + sin(x))", "2 + sin(x)"),
        ("Abs(-1 - k**2*x**2)", "1 + k**2*x**2"),
        ("sign(2 + tanh(x)) + x", "1 + x"),
        ("Max(Abs(2 + cos(x)), 1/2)", "2 + cos(x)"),
    ],
)
def test_where_bounds_decide_there_is_no_kink(written, meant):
    assert flow(written).modes == flow(meant).modes
    if "k" not in written:
        made = cd.in_modes(name="kink", states="x", parameters={"k": 1.0}, field={"x": f"{written} - Abs(x)"})
        assert made.mode_names == ("flow+", "flow-")


def test_a_step_of_a_parameter_is_a_constant():
    at = [flow("Heaviside(k)", initial={"x": 0.0}).with_parameters(k=k) for k in (-2.0, 0.0, 2.0)]
    ends = [float(cd.trajectory(one, duration=1.0, samples=2)["states"].values[-1, 0]) for one in at]
    assert ends == pytest.approx([0.0, 0.5, 1.0], abs=1e-14)
