"""Programs that are timed against each other do equal work, and what the study says of them is right."""

import importlib
import math
import sys
from pathlib import Path

import numpy as np
import pytest

import chaosdrill as cd

FOLDER = Path(__file__).parents[2] / "studies" / "accuracy"


@pytest.fixture(scope="module")
def module():
    sys.path.insert(0, str(FOLDER))
    yield importlib.import_module
    sys.path.remove(str(FOLDER))


def test_scipy_with_the_written_saltation_finds_the_cycle_and_its_exponents(module):
    program = module("scipy_events").ScipyEvents(0.8, 1e-10, 2)
    program.advance(24)
    program.logs[:] = 0
    program.advance(6)
    reference = module("programs").REFERENCE[0.8][0]
    np.testing.assert_allclose(program.strobe(), reference, atol=3e-5)
    # both tangents together: the modulus of the pair of multipliers
    assert program.logs.sum() / 6 == pytest.approx(2 * math.log(abs(0.11672896840556 + 0.65713468420972j)), abs=3e-3)


@pytest.mark.parametrize("method", ["taylor", "rk4"])
def test_own_programs_reach_the_same_cycle(module, method):
    programs = module("programs")
    program = programs.Own(0.8, 1e-9, 2, method)
    program.advance(200)
    assert programs.strobe_error(0.8, program.strobe()) < 1e-6


def test_a_strobe_error_is_the_distance_from_the_nearest_point(module):
    programs = module("programs")
    y, u, w = programs.REFERENCE[0.6][1]
    assert programs.strobe_error(0.6, [y, u + 3e-5, w - 1e-5]) == pytest.approx(3e-5)
    assert math.isnan(programs.strobe_error(0.448, [0.0, 0.0, 0.0]))
    assert math.isnan(programs.strobe_error(0.6, None))


def test_a_program_from_outside_is_asked_and_heard(module):
    script = (
        "import sys, json; print(json.dumps({{'us_per_period': 1e3, 'strobe': [float(v) for v in sys.argv[1:4]]}}))"
    )
    other = module("programs").Outside(
        "echo", f'{sys.executable} -c "{script}" {{eta}} {{periods}} {{tolerance}} [--lyap]'
    )
    speed, strobe = other.measure(0.8, 100, 1e-12, 2)
    assert 0 < speed <= 1e3
    assert strobe == [0.8, 100.0, 1e-12]
    busy = module("programs").Outside("sleeper", f'{sys.executable} -c "import time; time.sleep(1); {script}" 1 2 3')
    assert busy.measure(0.8, 100, 1e-12, 0)[0] < 800


def test_ratios_are_medians_of_rounds(module):
    ratios = module("ratios")
    made = [
        ratios.Measured(name, eta, tangents, times, 1e-13)
        for eta in ratios.ETAS
        for tangents in (0, 2)
        for name, times in (("ours", [1.0, 2.0, 3.0]), ("theirs", [10.0, 2.0, 9.0]))
    ]
    rows = ratios.table(made).splitlines()
    assert rows[2].startswith("| ours | 2 (1) |")
    assert rows[3].startswith("| theirs | 9 (3) |")


def test_systems_by_hand_move_as_the_drill_without_the_effect(module):
    for drill, hand in module("effects_cost").pairs().values():
        ours, theirs = (cd.trajectory(s, periods=20, transient=5, samples=3)["states"].values for s in (drill, hand))
        np.testing.assert_allclose(ours, theirs, atol=1e-8)


def test_a_long_run_is_its_pieces(module):
    found = module("long_run").compare(pieces=12, length=200)
    assert found.periods == 2400
    assert found.state == 0
    assert found.penetration < 1e-14
    assert found.phase < 1e-14


def test_the_paper_method_is_judged_by_what_is_known(module):
    paper = module("paper_method")
    assert paper.verdicts(paper.TUNING[-1], periods=300, transient=300) == [0, 0, 0, 0]
    coarse = paper.verdicts(paper.fixed(20, 1e-4), periods=300, transient=300)
    assert coarse[3] == paper.VERDICTS.index("chaos lost")
    errors = paper.errors_of_cycles(paper.fixed(200, 1e-6))
    assert all(1e-8 < e.strobe < 1e-5 for e in errors)


def test_steps_through_a_contact_are_judged_by_the_exact_derivative(module):
    stiff = module("stiff_contact")
    way = stiff._way("taylor", stiff.Numerics("taylor", 1e-10), 1.0)
    assert way.speed < 1e-12
    assert way.derivative < 1e-9
    coarse = stiff._way("rk4", stiff.Numerics("rk4", 1e-16, 26), 1.5)
    assert coarse.speed < 1e-4
    assert coarse.derivative > 1


def test_a_stiffer_contact_is_nearer_to_the_mapped_one(module):
    stiff = module("stiff_contact")
    found = stiff.over_stiffness([1.0], [1e8, 1e10])
    assert stiff.slope(found, 1.0) == pytest.approx(-0.5, abs=1e-3)


def test_every_study_is_told_of_in_the_readme(module):
    sys.modules.pop("make", None)
    parts = module("make").PARTS
    sys.modules.pop("make")
    text = (FOLDER / "README.md").read_text(encoding="utf-8")
    assert all(f"| `{part}` |" in text for part in parts)


def test_implicit_and_explicit_methods_are_judged_alike_in_stiff_problems(module):
    implicit = module("implicit")
    for k in implicit.STIFFNESSES:
        for method in ("radau", "dop853"):
            state, derivative, _ = implicit._through(k, method, 1e-12)
            assert state < 1e-13
            assert derivative < 1e-12 * k**0.5
    state, derivative, _ = implicit._oscillator("radau", 1e-10)
    assert state < 1e-11
    assert derivative < 1e-8
    assert implicit._oscillator_of_scipy(1e-4)[0] < 1e-5
