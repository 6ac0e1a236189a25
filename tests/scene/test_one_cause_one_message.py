"""One fault of a definition is one message, with the line and the field of what is wrong, and a remedy."""

import re
from pathlib import Path

import pytest

from chaosdrill.errors import ChaosdrillError, SceneError
from chaosdrill.scene import check, parse_scene

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
        f"\n[system.definition.bounds]\nx = [-{HUGE}, inf]\n[system.par",
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
