"""Two fields and a surface, drives with corners and symmetries in a scene: as in Python, with faults at their lines."""

import numpy as np
import pytest

import chaosdrill as cd
from chaosdrill.model.definition import write_definition

FRICTION = """\
[system.filippov]
name = "friction"
states = "x v"
surface = "v"
period = "2*pi/omega"
above = { x = "v", v = "u - x - S" }
below = { x = "v", v = "u - x + S" }
[system.parameters]
omega = 0.4
S = 0.6
u = 0.0
duty = 0.25
[system.drives.u]
pieces = { 0 = "1", duty = "-1" }
[system.initial]
x = 1.0
"""
DRIVEN = """\
[system.definition]
states = "x v"
modes.free = { x = "v", v = "u - x - c*v" }
period = "2*pi/omega"
[system.parameters]
omega = 0.7
c = 0.1
u = 0.0
[system.drives.u]
"""


def faults(text):
    with pytest.raises(cd.ChaosdrillError) as caught:
        _ = cd.parse_scene(text, "s.toml").system
    return str(caught.value).splitlines()


def same(one, other):
    assert write_definition(one) == write_definition(other)
    assert (one.parameters, one.initial) == (other.parameters, other.initial)


def test_two_fields_and_a_driven_parameter_are_the_system_of_python():
    parameters = {"omega": 0.4, "S": 0.6, "u": 0.0, "duty": 0.25}
    sides = {side: {"x": "v", "v": f"u - x {sign} S"} for side, sign in (("above", "-"), ("below", "+"))}
    given = {"name": "friction", "states": "x v", "period": "2*pi/omega", "initial": {"x": 1.0}}
    plain = cd.filippov(**given, parameters=parameters, surface="v", **sides)
    same(cd.parse_scene(FRICTION).system, cd.driven(plain, "u", {0: "1", "duty": "-1"}))


@pytest.mark.parametrize("names", ["x v", "x, v", "x; v", "x;v"])
def test_names_of_states_are_parted_in_the_ways_of_python(names):
    made = cd.parse_scene(FRICTION.replace('"x v"', f'"{names}"')).system
    assert (made.state_names, made.initial["x"]) == (("x", "v"), 1.0)


def test_a_surface_with_a_name_and_time_and_the_state_that_it_replaces():
    text = """
[system.filippov]
states = ["x", "v"]
surface = { s = "x + tau*v" }
above = { x = "v", v = "-U + cos(t)/9" }
below = { x = "v", v = "U + cos(t)/9" }
quadratures.slid = { above = "0", below = "0", sliding = "1" }
parameters = 0
[system.parameters]
tau = 0.5
U = 1.0
[system.initial]
x = 0.2
v = 0.3
"""
    (told,) = faults(text)
    assert told.startswith("s.toml:8: system.filippov.parameters: unknown key")
    sides = {side: {"x": "v", "v": f"{sign}U + cos(t)/9"} for side, sign in (("above", "-"), ("below", ""))}
    expected = cd.filippov(
        name="own-system", states="x v", time="t", parameters={"tau": 0.5, "U": 1.0}, surface={"s": "x + tau*v"},
        quadratures={"slid": {"above": "0", "below": "0", "sliding": "1"}}, initial={"x": 0.2, "v": 0.3}, **sides,
    )  # fmt: skip
    same(cd.parse_scene(text.replace("parameters = 0\n", "")).system, expected)


@pytest.mark.parametrize(
    ("drive", "given"),
    [
        ('pieces = "sawtooth"', {"pieces": "sawtooth"}),
        ("table = [0, 1, 0.5, -2]", {"table": [0, 1, 0.5, -2]}),
        ('table = { "0" = 0, "0.25" = 1.5, "0.5" = -1 }', {"table": {0: 0, 0.25: 1.5, 0.5: -1}}),
        ('pieces = "square"\nperiod = "pi/omega"', {"pieces": "square", "period": "pi/omega"}),
    ],
)
def test_drives_of_a_definition_are_those_of_python(drive, given):
    plain = cd.HybridSystem(
        states="x v", parameters={"omega": 0.7, "c": 0.1, "u": 0.0}, period="2*pi/omega",
        modes={"free": {"x": "v", "v": "u - x - c*v"}},
    )  # fmt: skip
    found, expected = cd.parse_scene(DRIVEN + drive).system, cd.driven(plain, "u", **given)
    start, length = np.array([0.3, -0.2]), {"periods": 1, "samples": 3}
    one, other = (cd.trajectory(s.with_initial(x=start[0], v=start[1]), **length) for s in (found, expected))
    np.testing.assert_array_equal(one["states"], other["states"])
    assert found.mode_names == expected.mode_names


def test_a_built_in_system_may_be_driven():
    found = cd.parse_scene('[system]\nmodel = "roessler"\n[system.drives.b]\nperiod = "6"\npieces = "triangle"').system
    assert found.mode_names == ("flow-0", "flow-1")
    assert "b" not in found.parameters


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ('surface = "v"\n', "", "s.toml:1: system.filippov.surface: missing"),
        ('v = "u - x - S"', 'v = "u - x - Z"', "s.toml:6: system.filippov.above.v: unknown name 'Z'"),
        ('v = "u - x + S"', 'v = "u - abs(x) + S"', "s.toml:7: system.filippov.below.v: Abs(x) has no Taylor series"),
        ('v = "u - x + S"', 'v = "(x + u)**9 + S"', "s.toml:7: system.filippov.below.v: takes a power of a sum"),
        ('above = { x = "v", v', 'above = { v', "s.toml:6: system.filippov.above: gives no rate for 'x'"),
        ('surface = "v"', 'surface = "v + (x + S)**900"', "s.toml:4: system.filippov.surface: takes a power of a sum"),
        ('surface = "v"', 'surface = "v + zz"', "s.toml:4: system.filippov.surface: unknown name 'zz'"),
        ('surface = "v"', 'surface = "x + v"', "s.toml:1: system.filippov: friction: the surface v + x names"),
        ('surface = "v"', 'surface = { s = "v", r = "x" }', "s.toml:4: system.filippov.surface: expected an"),
        ("duty = 0.25", "duty = 0.25\nwidth = 1", "s.toml:13: system.parameters.width: not used in the definition"),
        ("duty = 0.25", "duty = 1.25", "s.toml:13: system.drives.u: friction: pieces of the drive begin at"),
        ('duty = "-1"', 'dty = "-1"', "s.toml:14: system.drives.u.pieces.dty: unknown name 'dty'"),
        ('duty = "-1"', 'duty = "-q"', "s.toml:14: system.drives.u.pieces.duty: unknown name 'q'"),
        ("[system.drives.u]\n", "[system.drives.w]\n", "s.toml:13: system.drives.w: there is no parameter 'w'"),
        ("pieces = {", "form = 1\npieces = {", "s.toml:14: system.drives.u.form: unknown key"),
        ("x = 1.0", "y = 1.0", "s.toml:16: system.initial.y: unknown state"),
        ("x = 1.0", 'x = 1.0\nmode = "slide"', "s.toml:1: system.filippov: friction: initial mode 'slide'"),
        ("[system.drives", "[system.definition]\n[system.drives", "s.toml:1: system.filippov: definition and"),
    ],
)  # fmt: skip
def test_every_fault_stands_at_its_line(old, new, told):
    assert old in FRICTION
    found = faults(FRICTION.replace(old, new))
    assert any(line.startswith(told) for line in found), found


def test_tables_are_bounded():
    (told,) = faults(DRIVEN + f"table = {[0.0] * 121}")
    assert told.startswith("s.toml:10: system.drives.u.table: has 121 pieces; at most 120")
    (told,) = faults(DRIVEN + "table = [0, nan, 1]")
    assert told.startswith("s.toml:10: system.drives.u.table[1]: expected a finite number")


@pytest.mark.parametrize("drive", ["table = { 0.25 = 1, 0.75 = 0 }", 'pieces = { 0.25 = "1", 0.75 = "0" }'])
def test_phases_without_quotes_are_told_to_have_them(drive):
    (told,) = faults(DRIVEN + drive)
    assert told.endswith("; a phase with a point stands in quotes")


def test_what_is_driven_is_swept_no_more():
    sweep = '[analysis.d]\nkind = "bifurcation-diagram"\nsweep.u = { start = 0, stop = 1, num = 3 }\n'
    sweep += "periods = 20\ntransient = 5\n"
    (told,) = faults(FRICTION + sweep)
    assert told.startswith("s.toml:19: analysis.d.sweep.u: unknown parameter")


HALVED = """\
[system]
model = "gear-rattle"
[system.parameters]
drag = 0.0
beta = 0.05
[system.symmetry]
s = "backlash - s"
v = "-v"
[analysis.branch]
kind = "continuation"
sweep.amplitude = { start = 0.0, stop = 1.4 }
"""


def test_a_scene_follows_a_system_over_half_of_its_motion():
    whole = cd.build("gear-rattle", {"drag": 0.0, "beta": 0.05})
    found = cd.parse_scene(HALVED)
    same(found.system, cd.halved(whole, {"s": "backlash - s", "v": "-v"}))
    assert cd.check(found)["symmetry"] == {"s": "backlash - s", "v": "-v"}
    other = cd.parse_scene(HALVED.replace("[system.symmetry]\ns", "[system.symmetry]\n# here\ns"))
    assert other.fingerprint() == found.fingerprint()
    plain = HALVED.replace('[system.symmetry]\ns = "backlash - s"\nv = "-v"\n', "")
    assert cd.parse_scene(plain).fingerprint() != found.fingerprint()


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("drag = 0.0", "drag = 0.1", "s.toml:6: system.symmetry: gear-rattle: symmetry: "),
        ('v = "-v"', 'w = "-v"', "s.toml:8: system.symmetry.w: unknown state"),
        ('v = "-v"', 'v = "-v +"', "s.toml:6: system.symmetry: gear-rattle: symmetry: v: "),
        ('v = "-v"', "v = -1", "s.toml:8: system.symmetry.v: expected text in quotes"),
        ("sweep.amplitude", "sweep.drag", "s.toml:11: analysis.branch.sweep.drag: unknown parameter"),
    ],
)
def test_what_breaks_a_symmetry_stands_at_its_line(old, new, told):
    assert old in HALVED
    found = faults(HALVED.replace(old, new))
    assert any(line.startswith(told) for line in found), found
