"""What a point costs in charts of a hundred points to a hundred thousand."""

from collections.abc import Callable
from typing import Any

from own import Chart, spend

SIDES = (10, 32, 100, 316)
ROUNDS = 3
COLUMNS = ("points", "round", "processor_s", "stepping_s")

Row = dict[str, Any]


def measure(say: Callable[[str], None]) -> list[Row]:
    """Rows with the columns ``COLUMNS``."""
    spend(Chart((0.55, 0.9), 3))
    rows = []
    for i in range(1, ROUNDS + 1):
        for side in SIDES:
            say(f"{side} x {side} points, round {i}")
            spent = spend(Chart((0.55, 0.9), side, 50, 50, max_extension=0))
            rows.append(
                {"points": side**2, "round": i, "processor_s": spent.processor_s, "stepping_s": spent.stepping_s}
            )
    return rows


def table(rows: list[Row]) -> str:
    """Markdown of the least over the rounds."""
    lines = [["points", "µs a point", "of that stepping"], ["---"] * 3]
    for points in dict.fromkeys(row["points"] for row in rows):
        least = [
            min(float(row[key]) for row in rows if row["points"] == points) / float(points) * 1e6
            for key in ("processor_s", "stepping_s")
        ]
        lines.append([points, *(f"{value:.0f}" for value in least)])
    return "".join("| " + " | ".join(line) + " |\n" for line in lines)
