"""Run times relative to other programs, as pages state them, are those of the measured table."""

import csv
import re
from pathlib import Path
from statistics import median

import pytest

ROOT = Path(__file__).parents[2]
OWN = "chaosdrill taylor, 1e-12"
# words of a row -> program of the table
ROWS = {
    "written for this one system": "C++ Taylor, single purpose",
    "numba between events": "heyoka.py, numba between events",
    "Python between events": "heyoka.py, Python between events",
    "the method of the": "C++ rk4 with bisection (the paper's method), 4000 steps",
    "`solve_ivp`": "scipy DOP853, terminal events",
}


@pytest.fixture(scope="module")
def ratios():
    """Smallest and largest ratio of every program with two tangents, by its name."""
    with (ROOT / "studies" / "accuracy" / "ratios.csv").open(encoding="utf-8", newline="") as file:
        measured = [row for row in csv.DictReader(file) if row["tangents"] == "2"]
    times = {(row["program"], row["eta"]): median(float(row[f"us_{k}"]) for k in range(1, 6)) for row in measured}
    etas = {eta for _, eta in times}
    found = {
        program: sorted(times[program, eta] / times[OWN, eta] for eta in etas)
        for program in {program for program, _ in times}
    }
    return {program: (values[0], values[-1]) for program, values in found.items()}


@pytest.mark.parametrize(("page", "rows"), [("README.md", 4), ("docs/comparison.md", 5)])
def test_a_page_states_what_was_measured(ratios, page, rows):
    stated = re.findall(
        r"^\| ([^|]+) \| ([\d.]+) to ([\d.]+) \|", (ROOT / page).read_text(encoding="utf-8"), re.MULTILINE
    )
    assert len(stated) == rows
    for words, low, high in stated:
        (program,) = [program for part, program in ROWS.items() if part in words]
        # two digits are stated
        assert (float(low), float(high)) == pytest.approx(ratios[program], rel=0.05)
