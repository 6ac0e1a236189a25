"""A system that a scene defines is the same as that of Python, and its faults are told like all others."""

from pathlib import Path

import numpy as np
import pytest
import sympy

import chaosdrill as cd
from chaosdrill.scene import check, parse_scene

DOCS = Path(__file__).parents[2] / "docs"
TEXT = (DOCS / "_examples" / "extend" / "own.toml").read_text()


def of_the_readme():
    x, v, t, zeta, omega, e = sympy.symbols("x v t zeta omega e", real=True)
    return cd.HybridSystem(
        name="impact-oscillator",
        states=(x, v),
        time=t,
        parameters={"zeta": 0.05, "omega": 2.5, "e": 0.8},
        modes={"free": {x: v, v: -x - 2 * zeta * v + sympy.cos(omega * t)}},
        transitions=[
            cd.Transition("impact", source="free", target="free", guard=x - 0.3, direction=+1, reset={v: -e * v})
        ],
        period=2 * sympy.pi / omega,
        initial={"mode": "free", x: 0.0, v: 0.3},
    )


def test_the_example_is_the_system_of_the_readme():
    assert TEXT in (DOCS / "extend.md").read_text()
    one, other = parse_scene(TEXT).system, of_the_readme()
    for name in ("name", "states", "time", "parameters", "modes", "transitions", "period", "initial", "bounds"):
        assert getattr(one, name) == getattr(other, name), name


def test_its_exponents():
    """The largest is 0.091; their sum is what damping and impacts take away, -2 zeta + ln(e^2) impacts a time unit."""
    found = cd.run(parse_scene(TEXT))["spectrum"]
    largest, error = float(found["lyapunov_exponent"][0]), float(found["lyapunov_error"][0])
    assert abs(largest - 0.091) < 4 * error < 0.02
    rate = float(found["impacts_per_period"]) / (2 * np.pi / 2.5)
    assert float(found["lyapunov_exponent"].sum()) == pytest.approx(-0.1 + 2 * np.log(0.8) * rate, abs=1e-9)


def test_numbers_are_those_of_python_to_the_last_bit():
    text = TEXT.replace("periods = 5000", "periods = 50").replace("transient = 200", "transient = 5")
    scene = parse_scene(text, changes={"system.parameters.e": 0.7})
    python = cd.lyapunov_spectrum(of_the_readme().with_parameters(e=0.7), periods=50, transient=5)
    for name, variable in cd.run(scene)["spectrum"].data_vars.items():
        assert np.array_equal(variable.values, python[name].values, equal_nan=True), name


def test_check_tells_its_equations():
    told = check(parse_scene(TEXT))
    assert told["system"] == "impact-oscillator"
    assert told["modes"] == {"free": {"dx/dt": "v", "dv/dt": "-2*v*zeta - x + cos(omega*t)"}}
    assert told["simulated"] == told["left_out"] == {}


FAULTS = {
    "omega*t)": ("omga*t)", "modes.free.v: unknown name 'omga'; did you mean 'omega'?"),
    'v = "-x': ('v = "-x^2', "modes.free.v: '^' cannot stand at letter 3"),
    'x = "v"': ('x = "__import__(`os`).system(`ls`)"', "modes.free.x: '.' cannot stand"),
    'guard = "x - 0.3"': ('guard = "0.3"', "transitions[0].guard: depends on no state"),
    "guard = ": ("gard = ", "transitions[0].gard: unknown key; did you mean 'guard'?"),
    "direction = +1": ("direction = 2", "transitions[0].direction: must be 1 (rises)"),
    'source = "free"': ('source = "fre"', "transitions[0].source: unknown mode 'fre'; did you mean 'free'?"),
    'target = "free"': ('target = ["free"]', "transitions[0].target: expected text"),
    '"-e*v"': ('"-e*v > 0"', "transitions[0].reset.v: '-e*v > 0' is to be a number"),
    "reset = { v": ("reset = { w", "transitions[0].reset.w: unknown state; known here: x, v"),
    'states = ["x", "v"]': ('states = ["x", "v", "z"]', "modes.free: gives no rate for 'z'"),
    'time = "t"': ('time = "x"', "time: 'x' is the name of a state too"),
    '"2*pi/omega"': ('"2*pi/omega + t"', "period: names 't'"),
    'name = "impact-oscillator"': ("name = 3", "name: expected text in quotes, received 3"),
    "cos(omega*t)": ("Abs(x)", "modes.free.v: Abs(x) has no Taylor series"),
}


@pytest.mark.parametrize("old", FAULTS)
def test_a_fault_is_told_with_its_line_and_field(faults, old):
    new, told = FAULTS[old]
    line = TEXT[: TEXT.index(old)].count("\n") + 1
    found = faults(TEXT.replace(old, new, 1))
    wanted = f"system.definition.{told}"
    assert any(wanted in fault for fault in found), found
    shown = next(fault for fault in found if wanted in fault)
    if not told.startswith("modes.free: gives"):
        assert shown.startswith(f"scene.toml:{line}: ")


def test_all_at_once(faults):
    spoilt = TEXT
    for old in ("omega*t)", 'x = "v"', "direction = +1", 'source = "free"'):
        spoilt = spoilt.replace(old, FAULTS[old][0], 1)
    spoilt = spoilt.replace("lyapunov-spectrum", "lyapunov-spectra")
    assert len(faults(spoilt)) == 5


def test_a_parameter_that_nothing_names_is_likely_misspelt():
    with pytest.raises(cd.SceneError, match=r"system.parameters.omga: not used .* did you mean 'omega'"):
        parse_scene(TEXT, changes={"system.parameters.omga": 3.0})


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("[system.definition]", 'model = "lorenz"\n[system.definition]', "model and definition are both given"),
        ("[system.definition]", "[system.effects]\ndrive = 'none'\n[system.definition]", "not assembled from effects"),
        ("[system.definition]", '[system.si]\nm1 = "2 kg"\n[system.definition]', "can be given in SI units"),
        ('"2*pi/omega"', '"3*pi/omega"', "does not repeat after the declared period"),
    ],
)
def test_what_does_not_fit_together(faults, old, new, told):
    text = TEXT.replace(old, f"[system]\n{new}" if "model" in new else new, 1)
    assert any(told in fault for fault in faults(text))


def test_neither_model_nor_definition(faults):
    assert (
        "system.model: missing; name a built-in system"
        in faults("[system]\n[analysis.a]\nkind = 'trajectory'\nperiods = 2")[0]
    )
