"""How much faster two workers are than one, and what the machine gives: two copies of another program at once."""

import time
from collections.abc import Callable, Iterable
from functools import partial
from statistics import median
from typing import Any

from load import Others
from outside import Program
from own import TOLERANCE, Chart, spend

CHART = Chart((0.55, 0.9), 100, 100, 200)
QUIET = 0.04
"""Cores that other work may keep busy during a measurement that counts."""

COLUMNS = ("program", "round", "one_s", "two_s", "others_one", "others_two")

Row = dict[str, Any]


def measure(programs: Iterable[Program], rounds: int, patience_s: float, say: Callable[[str], None]) -> list[Row]:
    """Rows with the columns ``COLUMNS``.

    Rounds that other work disturbs are repeated until ``patience_s`` have passed; a program of which there is no
    undisturbed round has a disturbed one.
    """
    jobs: dict[str, Callable[[int], float]] = {"chart": lambda workers: spend(CHART, workers).clock_s}
    for program in programs:
        jobs[program.name] = partial(_copies, program, 4 * program.periods(0.63, TOLERANCE))
    spend(Chart(CHART.eta, 3), 2)
    rows: list[Row] = []
    end = time.monotonic() + patience_s
    counts = dict.fromkeys(jobs, 0)
    while any(count < (rounds if time.monotonic() < end else 1) for count in counts.values()):
        for name, job in jobs.items():
            if counts[name] < rounds:
                row = _round(name, job, end)
                disturbed = max(row["others_one"], row["others_two"])
                say(f"{name}: {row['one_s']:.2f} s and {row['two_s']:.2f} s, others on {disturbed:.2f} cores")
                if disturbed <= QUIET or (time.monotonic() > end and not counts[name]):
                    counts[name] += 1
                    rows.append(row | {"round": counts[name]})
    return sorted(rows, key=lambda row: list(jobs).index(row["program"]))


def _round(name: str, job: Callable[[int], float], end: float) -> Row:
    row: Row = {"program": name}
    for copies, word in ((1, "one"), (2, "two")):
        _await_quiet(end)
        others = Others()
        row[f"{word}_s"] = job(copies)
        row[f"others_{word}"] = others.share()
    return row


def _copies(program: Program, periods: int, copies: int) -> float:
    """Seconds of so many million periods in all, shared by the copies."""
    return program.at_once(0.63, TOLERANCE, periods, copies) * periods / 1e6 / copies


def _await_quiet(end: float) -> None:
    while time.monotonic() < end:
        others = Others()
        time.sleep(0.2)
        if others.share() <= QUIET:
            return


def table(rows: list[Row]) -> str:
    """Markdown of the medians; the gain is the median of the rounds' ratios."""
    head = ["", "one, s", "two, s", "gain", "rounds", "cores that others used, at most"]
    lines = [head, ["---"] * len(head)]
    for name in dict.fromkeys(row["program"] for row in rows):
        here = [{k: float(v) for k, v in row.items() if k != "program"} for row in rows if row["program"] == name]
        lines.append(
            [
                name,
                *(f"{median(row[key] for row in here):.3g}" for key in ("one_s", "two_s")),
                f"{median(row['one_s'] / row['two_s'] for row in here):.3f}",
                f"{len(here)}",
                f"{max(max(row['others_one'], row['others_two']) for row in here):.2f}",
            ]
        )
    return "".join("| " + " | ".join(line) + " |\n" for line in lines)
