"""Systems that a scene defines: one message for one cause, and no code."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import sympy

import chaosdrill as cd
from chaosdrill.errors import ChaosdrillError, SceneError
from chaosdrill.scene import check, parse_scene

# One fault of a definition is one message, with the line and the field of what is wrong, and a remedy.


TEXT = (Path(__file__).parents[2] / "docs" / "_examples" / "extend" / "own.toml").read_text()
NUMBER = re.compile(r"(?<== )[-+]?\d+(\.\d+)?\b|(?<=start = )[\d.]+|(?<=x - )0.3")
HUGE = "9" * 400
SECOND = """
[[system.definition.transitions]]
name = "second"
source = "free"
target = "free"
guard = "x - 0.3"
direction = +1
"""

FAULTS = {
    "no states": ('states = ["x", "v"]', "states = []", 5, "states: received []"),
    "states that are no names": ('states = ["x", "v"]', "states = 3", 5, "states: received 3; expected names in order"),
    "name with a line break": (
        '["x", "v"]',
        r'["x", "v\n"]',
        5,
        r"states[1]: received 'v\n'; a name must .* a line br",
    ),
    "negative period": ('"2*pi/omega"', '"-2*pi/omega"', 7, "period: .* is not a positive number"),
    "wrong period": ('"2*pi/omega"', '"3*pi/omega"', 7, "period: .* does not repeat after"),
    "division by zero": ("-x - 2*zeta*v", "v/0 - 2*zeta*v", 11, "modes.free.v: divides by zero"),
    "long integer": ("-x - 2", f"-{HUGE[:310]}*x - 2", 11, "modes.free.v: .* larger than any double"),
    "product of integers": ("-x - 2", "-(10**300*10**300)*x - 2", 11, "modes.free.v: .* larger than any double"),
    "time of another name": (
        'time = "t"',
        'time = "tau"',
        11,
        "modes.free.v: unknown name 't'; the time is called 'tau'",
    ),
    "time of no name": ('time = "t"', 'time = ""', 6, "time: received ''; a name must not be empty"),
    "time that is a word": ("omega*t", "omega*time", 11, "modes.free.v: unknown name 'time'; the time is called 't'"),
    "bound": (
        "\n[system.par",
        "\n[system.definition.bounds]\nx = [2, 1]\n[system.par",
        22,
        "bounds.x: expected",
    ),
    "quadrature": (
        "\n[system.par",
        "\n[system.definition.quadratures]\nphase='v'\n[system.par",
        22,
        "quadratures.phase: ",
    ),
    "label": ("\n[system.par", "\n[system.definition.labels]\nzet='damping'\n[system.par", 22, "labels.zet: .*'zeta'?"),
    "mode": ("\n[system.par", "\n[system.definition.modes.b]\nx='v'\nv='0'\n[system.par", 21, "modes.b: no transition"),
    "outcome": (
        "\n[system.par",
        f"{SECOND}\n[system.par",
        21,
        "transitions[1]: .*'second' is never taken, .* 'impact'",
    ),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_told_once_where_it_is(faults, fault):
    old, new, line, told = FAULTS[fault]
    assert old in TEXT
    (message,) = faults(TEXT.replace(old, new, 1)) if fault != "mode" else [refusal(TEXT.replace(old, new, 1))]
    pattern = re.escape(f"scene.toml:{line}: system.definition.{told}").replace(r"\.\*", ".*")
    assert re.match(pattern, message), message


def refusal(text):
    with pytest.raises(SceneError) as caught:
        check(parse_scene(text))
    return str(caught.value)


@pytest.mark.parametrize("value", ["nan", "inf", "true", HUGE, f"-{HUGE}"], ids=lambda value: value[:4])
@pytest.mark.parametrize("of", ["definition", "drill"])
def test_a_number_that_is_none_is_told_once(sound, of, value):
    text = TEXT if of == "definition" else sound
    places = [found for found in NUMBER.finditer(text) if "guard" not in text[: found.start()].rpartition("\n")[2]]
    assert len(places) > 5
    for found in places:
        with pytest.raises(ChaosdrillError) as caught:
            check(parse_scene(text[: found.start()] + value + text[found.end() :]))
        assert len(str(caught.value).splitlines()) == 1, caught.value


@pytest.mark.parametrize("mode", ["initial.mode = 'b'", "seeds", "random"])
def test_a_mode_in_which_a_run_begins_needs_no_transition(mode):
    text = TEXT.replace("\n[system.par", "\n[system.definition.modes.b]\nx='v'\nv='0'\n[system.par", 1)
    if mode == "seeds":
        text += "seeds = [{ x = 0.0 }, { mode = 'b' }]\n"
    elif mode == "random":
        text += "random = { count = 3, seed = 1, mode = 'b', x = [0.0, 0.1] }\n"
    else:
        text = text.replace("[system.initial]", "[system.initial]\nmode = 'b'")
    assert parse_scene(text).system.mode_names == ("free", "b")


@pytest.mark.parametrize("place", ["zeta = ", "states"])
def test_no_name_replaces_the_number_pi(place):
    """A parameter of that name would halve the period without a word."""
    new = TEXT.replace("zeta", "pi") if place != "states" else TEXT.replace('"x", "v"]', '"x", "v", "pi"]')
    new = new.replace('v = "-x', 'pi = "0"\nv = "-x') if place == "states" else new
    with pytest.raises(SceneError, match=r"'pi' is the number 3\.14159") as caught:
        parse_scene(new)
    assert len(str(caught.value).splitlines()) == 1


@pytest.mark.parametrize("name", ["time", "period", "outcome"])
def test_a_sweep_whose_results_would_clash_is_refused_before_it_runs(name):
    text = TEXT.replace("zeta", name).replace("sweep.omega", f"sweep.{name}")
    line = text[: text.index("sweep.")].count("\n") + 1
    with pytest.raises(
        SceneError, match=rf"^scene.toml:{line}: analysis.diagram.sweep.{name}: .* rename the parameter$"
    ):
        parse_scene(text)


def test_a_guard_is_set_by_the_name_of_its_transition():
    for name in ("impact", "0"):
        scene = parse_scene(TEXT, changes={f"system.definition.transitions.{name}.guard": "x - 0.5"})
        assert str(scene.system.transitions[0].guard) == "x - 0.5"
    assert scene.command() == "run scene.toml --set 'system.definition.transitions.0.guard=\"x - 0.5\"'"
    with pytest.raises(SceneError, match=r"^--set: system.definition.transitions\[0\].guard: unknown name 'z'"):
        parse_scene(TEXT, changes={"system.definition.transitions.impact.guard": "z"})


def of_size(terms):
    return TEXT.replace("cos(omega*t)", "+".join(["cos(omega*t)", *(f"sin({i}*x)" for i in range(1, terms + 1))]))


def test_a_mode_that_would_be_compiled_for_minutes_is_refused_at_once(faults):
    assert parse_scene(of_size(499)).system.state_names == ("x", "v")
    (message,) = faults(of_size(500))
    assert message.startswith("scene.toml:9: system.definition.modes.free: has 1002 products, powers and functions")


# A system that a scene defines is the same as that of Python, and its faults are reported like all others.


DOCS = Path(__file__).parents[2] / "docs"
DEFINITION_TEXT = (DOCS / "_examples" / "extend" / "own.toml").read_text()


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
    assert DEFINITION_TEXT in (DOCS / "extend.md").read_text()
    one, other = parse_scene(DEFINITION_TEXT).system, of_the_readme()
    for name in ("name", "states", "time", "parameters", "modes", "transitions", "period", "initial", "bounds"):
        assert getattr(one, name) == getattr(other, name), name


def test_its_exponents():
    """The largest is 0.091; their sum is what damping and impacts take away, -2 zeta + ln(e^2) impacts a time unit."""
    found = cd.run(parse_scene(DEFINITION_TEXT))["spectrum"]
    largest, error = float(found["lyapunov_exponent"][0]), float(found["lyapunov_error"][0])
    assert abs(largest - 0.091) < 4 * error < 0.02
    rate = float(found["impacts_per_period"]) / (2 * np.pi / 2.5)
    assert float(found["lyapunov_exponent"].sum()) == pytest.approx(-0.1 + 2 * np.log(0.8) * rate, abs=1e-9)


def test_numbers_are_those_of_python_to_the_last_bit():
    text = DEFINITION_TEXT.replace("periods = 5000", "periods = 50").replace("transient = 200", "transient = 5")
    scene = parse_scene(text, changes={"system.parameters.e": 0.7})
    python = cd.lyapunov_spectrum(of_the_readme().with_parameters(e=0.7), periods=50, transient=5)
    for name, variable in cd.run(scene)["spectrum"].data_vars.items():
        assert np.array_equal(variable.values, python[name].values, equal_nan=True), name


def test_check_tells_its_equations():
    told = check(parse_scene(DEFINITION_TEXT))
    assert told["system"] == "impact-oscillator"
    assert told["modes"] == {"free": {"dx/dt": "v", "dv/dt": "-2*v*zeta - x + cos(omega*t)"}}
    assert told["simulated"] == told["left_out"] == {}


DEFINITION_FAULTS = {
    "omega*t)": ("omga*t)", "modes.free.v: unknown name 'omga'; did you mean 'omega'?"),
    'v = "-x': ('v = "-x^2', "modes.free.v: '^' cannot stand at letter 3"),
    'x = "v"': ('x = "__import__(`os`).system(`ls`)"', "modes.free.x: '.' cannot stand"),
    'guard = "x - 0.3"': ('guard = "0.3"', "transitions[0].guard: depends on no state"),
    '"x - 0.3"': ('"zeta - 0.3"', "transitions[0].guard: zeta - 0.3 depends on no state"),
    "guard = ": ("gard = ", "transitions[0].gard: unknown key; did you mean 'guard'?"),
    "direction = +1": ("direction = 2", "transitions[0].direction: must be 1 (rises)"),
    'source = "free"': ('source = "fre"', "transitions[0].source: unknown mode 'fre'; did you mean 'free'?"),
    'target = "free"': ('target = ["free"]', "transitions[0].target: expected text"),
    '"-e*v"': ('"-e*v > 0"', "transitions[0].reset.v: '-e*v > 0' must be a number"),
    "reset = { v": ("reset = { w", "transitions[0].reset.w: unknown state; known here: x, v"),
    'states = ["x", "v"]': ('states = ["x", "v", "z"]', "modes.free: gives no rate for 'z'"),
    'time = "t"': ('time = "x"', "time: 'x' is the name of a state too"),
    '"2*pi/omega"': ('"2*pi/omega + t"', "period: names 't'"),
    'name = "impact-oscillator"': ("name = 3", "name: expected text in quotes, received 3"),
    "cos(omega*t)": ("Abs(x)", "modes.free.v: Abs(x) has no Taylor series"),
}


@pytest.mark.parametrize("old", DEFINITION_FAULTS)
def test_a_fault_is_told_with_its_line_and_field(faults, old):
    new, told = DEFINITION_FAULTS[old]
    line = DEFINITION_TEXT[: DEFINITION_TEXT.index(old)].count("\n") + 1
    found = faults(DEFINITION_TEXT.replace(old, new, 1))
    wanted = f"system.definition.{told}"
    assert any(wanted in fault for fault in found), found
    shown = next(fault for fault in found if wanted in fault)
    if not told.startswith("modes.free: gives"):
        assert shown.startswith(f"scene.toml:{line}: ")


def test_all_at_once(faults):
    spoilt = DEFINITION_TEXT
    for old in ("omega*t)", 'x = "v"', "direction = +1", 'source = "free"'):
        spoilt = spoilt.replace(old, DEFINITION_FAULTS[old][0], 1)
    spoilt = spoilt.replace("lyapunov-spectrum", "lyapunov-spectra")
    assert len(faults(spoilt)) == 5


def test_a_parameter_that_nothing_names_is_likely_misspelt():
    with pytest.raises(cd.SceneError, match=r"system.parameters.omga: not used .* did you mean 'omega'"):
        parse_scene(DEFINITION_TEXT, changes={"system.parameters.omga": 3.0})


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("[system.definition]", 'model = "lorenz"\n[system.definition]', "model and definition are both given"),
        ("[system.definition]", "model = ''\nmap = {}\nfilippov = {}\n[system.definition]", "leave three of them out"),
        ("[system.definition]", "[system.effects]\ndrive = 'none'\n[system.definition]", "not assembled from effects"),
        ("[system.definition]", '[system.si]\nm1 = "2 kg"\n[system.definition]', "can be given in SI units"),
        ('"2*pi/omega"', '"3*pi/omega"', "does not repeat after the declared period"),
    ],
)
def test_what_does_not_fit_together(faults, old, new, told):
    text = DEFINITION_TEXT.replace(old, f"[system]\n{new}" if "model" in new else new, 1)
    assert any(told in fault for fault in faults(text))


def test_neither_model_nor_definition(faults):
    assert (
        "system.model: missing; name a built-in system"
        in faults("[system]\n[analysis.a]\nkind = 'trajectory'\nperiods = 2")[0]
    )


# A scene names things; it never causes code to be imported or evaluated.


HOSTILE = ["os", "os.system", "__import__('os')", "chaosdrill.cli.main:main", "../percussive-drill", ""]

SNITCH = """
import sys
from chaosdrill.errors import SceneError
from chaosdrill.scene import parse_scene
before = None
class Snitch:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in ("secret", "antigravity", "this"):
            print("imported", name)
sys.meta_path.insert(0, Snitch())
try:
    parse_scene(sys.stdin.read())
except SceneError as fault:
    print(str(fault).count(chr(10)) + 1, "faults")
print(sorted(set(sys.modules) & {"numba", "sympy", "xarray", "matplotlib", "netCDF4", "dask"}))
"""


@pytest.mark.parametrize("name", HOSTILE)
@pytest.mark.parametrize(
    ("old", "field"),
    [
        ('"percussive-drill"', "system.model"),
        ('"stribeck"', "system.effects.friction"),
        ('"taylor"', "numerics.method"),
        ('"lyapunov-spectrum"', "analysis.spectrum.kind"),
    ],
)
def test_only_known_names(sound, faults, old, field, name):
    assert f": {field}: unknown " in faults(sound.replace(old, f'"{name}"', 1))[0]


def run(text):
    return subprocess.run(
        [sys.executable, "-c", SNITCH], input=text, capture_output=True, text=True, timeout=60, check=True
    ).stdout.splitlines()


def test_module_names_are_not_imported(sound):
    text = sound.replace("percussive-drill", "antigravity").replace("taylor", "secret.method")
    assert run(text) == ["2 faults", "[]"]


def test_a_sound_scene_is_read_without_heavy_imports(sound):
    assert run(sound) == ["[]"]
