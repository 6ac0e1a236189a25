"""What the study of throughput says is computed from single measurements, and its charts do what it counts."""

import csv
import importlib
import sys
import threading
import time
from pathlib import Path
from types import SimpleNamespace

import pytest

from chaosdrill.scene import load_scene

FOLDER = Path(__file__).parents[2] / "studies" / "throughput"
PARTS = ("speed", "workers", "growth", "memory")


@pytest.fixture(scope="module")
def module():
    sys.path.insert(0, str(FOLDER))
    sys.modules.pop("make", None)
    yield importlib.import_module
    sys.modules.pop("make", None)
    sys.path.remove(str(FOLDER))


@pytest.mark.parametrize("part", PARTS)
def test_tables_are_made_of_the_measurements_beside_them(module, part):
    with (FOLDER / f"{part}.csv").open(newline="", encoding="utf-8") as file:
        reader = csv.DictReader(file)
        rows = list(reader)
    assert tuple(reader.fieldnames) == module(part).COLUMNS
    table = module(part).table(rows)
    assert (FOLDER / f"{part}.md").read_text(encoding="utf-8").startswith(table)


def _cells(table):
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in table.splitlines()]


def test_ratios_of_speed_are_medians_within_rounds(module):
    own = [("2", "1", "0.5"), ("6", "4", "2"), ("9", "8", "4")]
    rows = [
        {"chart": "c", "program": "chart", "us_asked": a, "us_run": r, "us_stepping": s, "us_around_a_point": "7"}
        for a, r, s in own
    ]
    rows += [{"chart": "c", "program": "other", "us_asked": value} for value in ("1", "4", "3")]
    rows += [{"chart": "c", "program": "many", "us_asked": value} for value in ("1", "2", "3")]
    _, _, cells = _cells(module("speed").table(rows))
    assert cells == ["c", "3 (1)", "2 (1)", "6 (2)", "4 (1)", "2 (0.5)", "7"]


def test_the_gain_of_two_workers_is_the_median_of_rounds(module):
    rows = [
        {"workers": workers, "alone_s": seconds, "clock_s": 2 * seconds + workers, "others": 0.5 * workers}
        for one, two in ((10, 5), (8, 5), (9, 5))
        for workers, seconds in ((1, one), (2, two))
    ]
    _, _, free, clock = _cells(module("workers").table(rows))
    assert free == ["without waiting for other work", "9", "5", "1.80", "3", "0.8"]
    assert clock == ["by the clock", "19", "12", "1.58", "3", "0.8"]


@pytest.mark.skipif(not Path("/proc/self/schedstat").is_file(), reason="needs Linux's count of waiting")
def test_waiting_for_a_core_is_taken_off(module, monkeypatch):
    waiting, own = module("waiting"), module("own")
    chart = own.Chart((0.6, 0.7), 6, 5, 20, 1e-6, max_extension=0)
    waited = iter(range(1000))
    monkeypatch.setattr(waiting, "_waited", lambda thread: next(waited))
    seconds, clock = waiting.alone(chart, 1)
    # asked at the beginning, before and after the points, and at the end
    assert clock - seconds == pytest.approx(3)
    main, asked = threading.get_native_id(), set()
    monkeypatch.setattr(waiting, "_waited", lambda thread: asked.add(thread) or (0.0 if thread == main else 10.0))
    monkeypatch.setattr(waiting, "time", SimpleNamespace(perf_counter=time.perf_counter, thread_time=lambda: 0.0))
    seconds, clock = waiting.alone(chart, 2)
    # as many threads as there was work for; the second may never be started
    started = len(asked - {main})
    assert started in (1, 2)
    assert clock - seconds == pytest.approx(10 * started / 2)


def test_the_cost_of_a_point_is_the_least_of_the_rounds(module):
    rows = [
        {"points": "100", "round": "1", "processor_s": "0.2", "stepping_s": "0.1"},
        {"points": "100", "round": "2", "processor_s": "0.1", "stepping_s": "0.2"},
    ]
    assert _cells(module("growth").table(rows))[2] == ["100", "1000", "1000"]


def test_memory_is_told_by_workers(module):
    rows = [
        {"points": "4", "workers": w, "peak_mb": mb, "archive_mb": "0.5"} for w, mb in (("1", "300.4"), ("2", "310.6"))
    ]
    head, _, cells = _cells(module("memory").table(rows))
    assert head[1:3] == ["peak with 1 worker, MB", "peak with 2 workers, MB"]
    assert cells == ["4", "300", "311", "0.5"]


def test_a_chart_is_the_scene_that_it_says(module, tmp_path):
    chart = module("own").Chart((0.55, 0.9), 12, 30, 70)
    (tmp_path / "scene.toml").write_text(chart.scene(), encoding="utf-8")
    scene = load_scene(tmp_path / "scene.toml")
    assert scene.analyses["chart"].kind == "parameter-chart"
    assert scene.numerics["tolerance"] == 1e-10
    assert scene.system.parameters["xi"] == 0.06
    assert chart.asked == 144 * 100


def test_periods_of_undecided_points_are_counted(module):
    own = module("own")
    short = own.Chart((0.45, 0.9), 3, 5, 20, 1e-6, max_extension=0)
    spent = own.spend(short)
    assert spent.periods == short.asked
    assert own.spend(own.Chart((0.45, 0.9), 3, 5, 20, 1e-6, max_extension=2)).periods > short.asked
    assert 0 < spent.stepping_s < spent.processor_s


def test_many_points_at_once_span_the_range(module, monkeypatch):
    outside = module("outside")
    asked = []

    def run(self, eta, tolerance, periods, spread):
        asked.append((eta, spread))
        return eta

    monkeypatch.setattr(outside.Program, "_run", run)
    many = outside.Program("many", "program {eta} {periods} {tolerance} {spread}")
    assert many.cost(0.5, 0.85, 1e-10, 100) == 0.5
    assert asked.pop() == (0.5, pytest.approx(0.05))
    one = outside.Program("one", "program {eta} {periods} {tolerance}")
    assert one.cost(0.5, 0.9, 1e-10, 100) == pytest.approx(0.7)
    assert [eta for eta, _ in asked] == pytest.approx([0.525 + 0.05 * i for i in range(8)])


def test_other_work_is_noticed(module):
    others = module("load").Others()
    others.all -= 10.0
    others.clock -= 5.0
    assert 1.5 < others.share() < 4.1


def test_every_part_is_told_of_in_the_readme(module):
    assert set(module("make").MODULES) == set(PARTS)
    text = (FOLDER / "README.md").read_text(encoding="utf-8")
    assert all(f"| `{part}` |" in text for part in PARTS)
