"""How much faster two workers are than one."""

from collections.abc import Callable
from statistics import median
from typing import Any

from load import Others
from own import Chart, spend
from waiting import alone

CHART = Chart((0.55, 0.9), 100)
COLUMNS = ("round", "workers", "alone_s", "clock_s", "others")

Row = dict[str, Any]


def measure(rounds: int, say: Callable[[str], None]) -> list[Row]:
    """Rows with the columns ``COLUMNS``."""
    spend(Chart(CHART.eta, 3), 2)
    rows: list[Row] = []
    for i in range(1, rounds + 1):
        for workers in (1, 2):
            others = Others()
            seconds, clock = alone(CHART, workers)
            row = {"round": i, "workers": workers, "alone_s": seconds, "clock_s": clock, "others": others.share()}
            say(" ".join(f"{key} {value:.4g}" for key, value in row.items()))
            rows.append(row)
    return rows


def table(rows: list[Row]) -> str:
    """Markdown of the medians; the gain is the median of the rounds' ratios."""
    head = ["", "one worker, s", "two workers, s", "gain", "rounds", "cores that others used"]
    lines = [head, ["---"] * len(head)]
    for name, key in (("without waiting for other work", "alone_s"), ("by the clock", "clock_s")):
        one, two = ([float(row[key]) for row in rows if str(row["workers"]) == workers] for workers in ("1", "2"))
        gain = median(a / b for a, b in zip(one, two, strict=True))
        others = median(float(row["others"]) for row in rows)
        lines.append([name, f"{median(one):.3g}", f"{median(two):.3g}", f"{gain:.2f}", f"{len(one)}", f"{others:.1f}"])
    return "".join("| " + " | ".join(line) + " |\n" for line in lines)
