"""What a point and forcing period of a chart costs, beside programs written for this one system.

Every round runs the chart and all programs in turn on one core. The chart's time is all of it: reading the scene,
setting up, stepping with two tangents, periods, exponents and outcomes, storing, writing the archive.
"""

from collections.abc import Callable, Iterable
from statistics import median
from typing import Any

from outside import Program
from own import TOLERANCE, Chart, spend

CHARTS = {
    "period 4, η 0.63": Chart((0.6295, 0.6305), 64),
    "chaos, η 0.448": Chart((0.4475, 0.4485), 64),
    "period 1, η 0.8": Chart((0.7995, 0.8005), 64),
    "η 0.55 to 0.9": Chart((0.55, 0.9), 64),
}
OWN = "chart"
COLUMNS = ("chart", "program", "round", "us_asked", "us_run", "us_stepping", "us_clock", "us_around_a_point")

Row = dict[str, Any]


def measure(programs: Iterable[Program], rounds: int, say: Callable[[str], None]) -> list[Row]:
    """Rows of the table of single measurements, with the columns ``COLUMNS``; programs have the first figure only."""
    rows: list[Row] = []
    for name, chart in CHARTS.items():
        say(name)
        spend(Chart(chart.eta, 3))
        lengths = {program: program.periods(chart.eta[0], TOLERANCE) for program in programs}
        for i in range(1, rounds + 1):
            rows.append({"chart": name, "program": OWN, "round": i, **_own(chart)})
            for program, periods in lengths.items():
                cost = program.cost(*chart.eta, TOLERANCE, periods)
                rows.append({"chart": name, "program": program.name, "round": i, "us_asked": cost})
    return rows


def _own(chart: Chart) -> dict[str, float]:
    spent = spend(chart)
    return {
        "us_asked": spent.processor_s / chart.asked * 1e6,
        "us_run": spent.processor_s / spent.periods * 1e6,
        "us_stepping": spent.stepping_s / spent.periods * 1e6,
        "us_clock": spent.clock_s / chart.asked * 1e6,
        "us_around_a_point": (spent.processor_s - spent.stepping_s) / chart.points * 1e6,
    }


def table(rows: list[Row]) -> str:
    """Markdown of the medians, and of the medians of ratios to the first program of the same round."""
    others = list(dict.fromkeys(row["program"] for row in rows if row["program"] != OWN))
    head = ["µs a point and forcing period", *others, "chart, a period asked for", "chart, a period run"]
    head += ["of that stepping", "all else, µs a point"]
    lines = [head, ["---"] * len(head)]
    for name in dict.fromkeys(row["chart"] for row in rows):
        by = {p: [row for row in rows if (row["chart"], row["program"]) == (name, p)] for p in (*others, OWN)}

        def column(program: str, key: str, by: dict[str, list[Row]] = by) -> list[float]:
            return [float(row[key]) for row in by[program]]

        base = column(others[0], "us_asked") if others else column(OWN, "us_asked")
        cells = [name, *(_cell(column(other, "us_asked"), base) for other in others)]
        cells += [_cell(column(OWN, key), base) for key in ("us_asked", "us_run", "us_stepping")]
        lines.append([*cells, f"{median(column(OWN, 'us_around_a_point')):.0f}"])
    return "".join("| " + " | ".join(line) + " |\n" for line in lines)


def _cell(times: list[float], base: list[float]) -> str:
    return f"{median(times):.3g} ({median(a / b for a, b in zip(times, base, strict=True)):.3g})"
