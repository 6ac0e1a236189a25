"""The study of orbits judges rightly: it agrees with what is true, and would not with what is not."""

import csv
import importlib
import math
import re
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import chaosdrill as cd
from chaosdrill.scene import load_scene

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "studies" / "orbits"
OWN = ("make", "reading", "doublings", "touches", "oscillator", "cost", "cascades", "confirm")


@pytest.fixture(scope="module")
def module():
    for name in OWN:
        sys.modules.pop(name, None)
    sys.path.insert(0, str(FOLDER))
    yield importlib.import_module
    sys.path.remove(str(FOLDER))
    for name in OWN:
        sys.modules.pop(name, None)


@pytest.fixture(scope="module")
def doubling(module):
    """The first period doubling of the impact oscillator, with the doubled branch."""
    system = cd.build("impact-oscillator", {"wall": 0.0, "zeta": 0.0, "e": 0.8, "omega": 2.64})
    branches = cd.continue_orbit(system.with_initial(x=-0.615, v=0.0178), {"omega": (2.64, 2.66)}, doublings=1)
    (special,) = module("reading").special_points(branches, "period_doubling", (0,))
    return special


@pytest.fixture(scope="module")
def grazing(module):
    """Where the linear response of the impact oscillator comes to reach the wall at 0.3."""
    (special,) = module("reading").special_points(module("oscillator").branches()[0], "grazing")
    return special


def test_a_diagram_agrees_on_both_sides_of_a_doubling(module, doubling):
    found = module("doublings").sides(doubling, (1e-4, 1e-5))
    assert [side.told for side in found] == [1, 2, 1, 2]
    assert [side.found for side in found] == [1, 2, 1, 2]
    assert all(side.agrees for side in found)


def test_it_does_not_agree_where_stability_is_told_wrongly(module, doubling):
    spoiled = doubling.branches.assign(stable=1 - doubling.branches["stable"])
    found = module("doublings").sides(replace(doubling, branches=spoiled), (1e-4,))
    assert not any(side.agrees for side in found)


def test_a_side_without_a_doubled_branch_only_excludes_the_orbit(module):
    side = module("doublings").Side(offset=1e-4, told=0, found=4, distance=0.01, period=4)
    assert not side.agrees
    assert not replace(side, found=8).agrees
    assert replace(side, found=8, told=module("doublings").UNKNOWN).agrees
    assert replace(side, found=8, distance=0.5).agrees


def test_simulations_find_the_grazing_point_again(module, grazing):
    found = module("touches").touch(grazing)
    assert found.agrees
    assert (found.events, found.without, found.with_, found.turns) == (("impact",), 0, 1, False)
    assert not module("touches").touch(replace(grazing, value=grazing.value + 1e-6), (1e-5,)).agrees


def test_the_oscillator_grazes_where_its_closed_form_says(module, grazing):
    oscillator = module("oscillator")
    exact = oscillator.closed_form({"wall": 0.3, "omega": 2.3}, "omega", 2.08)
    assert oscillator.amplitude(exact) == pytest.approx(0.3, abs=1e-15)
    assert grazing.value == pytest.approx(exact, abs=1e-11)


def test_the_smallest_distance_is_found_between_samples(module, grazing):
    system = module("reading").system_of(grazing.branches, 2.2)
    response = 1 / complex(1 - 2.2**2, 0.1 * 2.2)
    placed = system.with_initial(x=response.real, v=-2.2 * response.imag)
    run = cd.trajectory(placed, periods=1, samples=1500)
    distance = module("touches").smallest_distance(placed, run, ("impact",))
    assert distance == pytest.approx(0.3 - abs(response), abs=1e-12)


def test_the_ratios_of_cost_are_medians_within_rounds(module):
    rows = [
        {"round": i, "points": 1000, "branch_s": b, "one_by_one_s": o, "kernel_s": k, "cascade_s": c}
        for i, (b, o, k, c) in enumerate([("2", "1", "0.5", "3"), ("6", "4", "3", "5"), ("9", "3", "1.5", "4")])
    ]
    lines = [line.strip("| ").split(" | ") for line in module("cost").table(rows).splitlines()[2:]]
    assert [line[1] for line in lines] == ["6", "3", "1.5", "4"]
    assert [line[2] for line in lines[:3]] == ["6e+03", "3e+03", "1.5e+03"]
    assert [line[3] for line in lines[:3]] == ["1.00", "2.00", "4.00"]


def test_the_table_of_cost_is_made_of_the_measurements_beside_it(module):
    with (FOLDER / "cost.csv").open(newline="", encoding="utf-8") as file:
        reader = csv.DictReader(file)
        rows = list(reader)
    assert tuple(reader.fieldnames) == module("cost").COLUMNS
    assert (FOLDER / "cost.md").read_text(encoding="utf-8").startswith(module("cost").table(rows))


def test_every_scene_can_be_run_and_is_drawn(module):
    make = module("make")
    assert set(make.SCENES) == {path.stem for path in FOLDER.glob("*.toml")}
    for name, group in make.SCENES.items():
        analyses = load_scene(FOLDER / f"{name}.toml").analyses
        assert not group or {group, "diagram"} <= set(analyses)
    assert all(group in load_scene(FOLDER / f"{name}.toml").analyses for name, group in make.CURVES)


def test_the_exact_doublings_include_the_closed_form(module):
    w, r = module("cascades").EXACT[0], 0.8
    assert math.cos(math.pi / w) ** 2 * (w**2 - ((1 - r) / (1 + r)) ** 2) == pytest.approx(1, abs=1e-14)
    gaps = np.diff(module("cascades").EXACT)
    assert gaps[-2] / gaps[-1] == pytest.approx(module("cascades").FEIGENBAUM, abs=0.01)


def test_the_page_shows_only_what_agrees(module):
    page = (ROOT / "docs" / "branches.md").read_text(encoding="utf-8")
    text = (FOLDER / "page.md").read_text(encoding="utf-8")
    assert all(part in page for part in re.split(r"{{\w+}}\n", text))
    assert page.count("| agree |") > 20
    assert "disagree" not in page
    assert "a multiplier passes" not in page
    for picture in module("make").PICTURES:
        name = f"orbits_{picture.replace('-', '_')}.png"
        assert name in page
        assert (ROOT / "docs" / "_static" / name).is_file()
