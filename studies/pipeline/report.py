"""One table of many archives, in Markdown and beside it as CSV.

python report.py A.nc B.nc ... -o report.md
"""

import argparse
import csv
import os
from pathlib import Path

import chaosdrill as cd

HEAD = [
    "load rad/s",
    "outcome",
    "period",
    "largest exponent 1/s",
    "its error 1/s",
    "progression m/h",
    "impacts a period",
]


def row(path: Path) -> list[str]:
    """The line of one archive."""
    tree = cd.open(path)
    spectrum, section = tree["spectrum"], tree["section"]
    per_second = 1 / float(tree["si_unit_of_time"])
    numbers = [
        float(spectrum["lyapunov_exponent"][0]) * per_second,
        float(spectrum["lyapunov_error"][0]) * per_second,
        float(spectrum["progression_rate_si"]),
        float(spectrum["impacts_per_period"]),
    ]
    outcome = cd.Outcome(int(spectrum["outcome"])).meaning
    return [f"{float(tree['si_omega']):g}", outcome, str(int(section["period"])), *(f"{x:.4g}" for x in numbers)]


def write(paths: list[Path], output: Path) -> None:
    """Write the tables; each file takes its place when it is whole."""
    rows = sorted((row(path) for path in paths), key=lambda cells: float(cells[0]))
    lines = [HEAD, ["---"] * len(HEAD), *rows]
    draft = output.with_suffix(".part")
    draft.write_text("\n".join("| " + " | ".join(cells) + " |" for cells in lines) + "\n", encoding="utf-8")
    with output.with_suffix(".csv").open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([HEAD, *rows])
    os.replace(draft, output)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("archives", nargs="+", type=Path)
    parser.add_argument("-o", "--output", required=True, type=Path)
    given = parser.parse_args()
    write(given.archives, given.output)
    print(given.output)
