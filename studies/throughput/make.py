"""How fast charts of the drill are: beside programs written for it, with two workers, with more points.

    python studies/throughput/make.py [PART ...] [--against NAME COMMAND] [--rounds N] [--keep]
    (or: python3 studies/run.py throughput ...)

Parts (all of them if none is named), each a table of single measurements, ``PART.csv``, and what it says, ``PART.md``,
in ``studies/throughput/out/``:

    speed      microseconds a point and forcing period, everything included, beside other programs
    workers    two workers against one
    growth     cost of a point from a hundred points to a hundred thousand
    memory     peak memory up to a million points

``--against`` adds a program: its name, and a command in which ``{eta}``, ``{periods}`` and ``{tolerance}`` stand for
numbers, and ``{spread}`` for the distance in eta of eight points that it steps at once. It runs the drill with two
tangents from rest and prints one line of JSON with ``us_per_period``. Ratios are to the first one. ``--keep`` writes
beside this script, too.
"""

import argparse
import csv
import datetime
import os
import platform
import sys
import time
from importlib.metadata import version
from pathlib import Path
from typing import Any

import growth
import memory
import speed
import workers
from outside import Program

HERE = Path(__file__).resolve().parent
OUT = HERE / "out"
MODULES = {"speed": speed, "workers": workers, "growth": growth, "memory": memory}


def measure(part: str, given: argparse.Namespace) -> list[dict[str, Any]]:
    """Single measurements of one part."""
    programs = [Program(name, command) for name, command in given.against]
    if part == "workers":
        return workers.measure(given.rounds, say)
    if part == "memory":
        return memory.measure(say)
    cores = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {max(cores)})
    try:
        return growth.measure(say) if part == "growth" else speed.measure(programs, given.rounds, say)
    finally:
        os.sched_setaffinity(0, cores)


def write(folder: Path, part: str, rows: list[dict[str, Any]]) -> str:
    """Write single measurements and the text made of them into a folder; returns the text."""
    with (folder / f"{part}.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, MODULES[part].COLUMNS)
        writer.writeheader()
        writer.writerows({k: f"{v:.5g}" if isinstance(v, float) else v for k, v in row.items()} for row in rows)
    text = f"{MODULES[part].table(read(folder, part))}\n{machine()}\n"
    (folder / f"{part}.md").write_text(text, encoding="utf-8")
    return text


def read(folder: Path, part: str) -> list[dict[str, Any]]:
    """Single measurements of a part, as strings."""
    with (folder / f"{part}.csv").open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def machine() -> str:
    """A sentence that names machine, versions and date."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text(encoding="utf-8").splitlines() if info.is_file() else []
    model = next(
        (line.partition(":")[2].strip() for line in lines if line.startswith("model name")), platform.machine()
    )
    versions = ", ".join(f"{name} {version(name)}" for name in ("chaosdrill", "numpy", "numba", "xarray"))
    return f"{model}, {os.cpu_count()} cores, Python {platform.python_version()}, {versions}, {datetime.date.today()}."


def main() -> int:
    """Run the parts that are asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", choices=[*MODULES, []], metavar="PART", help=", ".join(MODULES))
    parser.add_argument("--against", nargs=2, action="append", default=[], metavar=("NAME", "COMMAND"))
    parser.add_argument("--rounds", type=int, default=7, help="interleaved rounds of a comparison")
    parser.add_argument("--keep", action="store_true", help="write beside the script, too")
    given = parser.parse_args()
    OUT.mkdir(exist_ok=True)
    for part in given.parts or MODULES:
        begin = time.monotonic()
        rows = measure(part, given)
        for folder in (OUT, HERE) if given.keep else (OUT,):
            text = write(folder, part, rows)
        print(f"## {part}\n\n{text}", flush=True)
        say(f"{part}: {time.monotonic() - begin:.0f} s")
    return 0


def say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
