"""What a forcing period of the drill costs, by several programs that do equal work: one interleaved run on one core.

Every round runs all programs one after the other, so that a change of the machine's speed meets all of them; the
ratios are medians over the rounds. The error beside the time is that of the strobe point of the period-4 cycle at
eta 0.63.
"""

import csv
import datetime
import importlib.util
import math
import os
import platform
import sys
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import partial
from importlib.metadata import version
from pathlib import Path
from statistics import median

from heyoka_events import HeyokaEvents, HeyokaNumba
from programs import SETTLE, Outside, Own, Program, strobe_error, timed
from scipy_events import ScipyEvents

from chaosdrill.declared import METHODS

TOLERANCE = 1e-12
ETAS = (0.63, 0.448)
SHARE = 0.3
"""Seconds of one measurement."""


@dataclass
class Measured:
    """One program at one eta, with or without tangents: microseconds a period, one a round, and its strobe error."""

    name: str
    eta: float
    tangents: int
    times: list[float] = field(default_factory=list)
    error: float = math.nan


def own_programs() -> dict[str, Callable[[float, int], Program]]:
    """Return how the programs of our own making are built, from eta and the number of tangents."""
    made: dict[str, Callable[[float, int], Program]] = {
        "chaosdrill taylor, 1e-12": lambda eta, m: Own(eta, TOLERANCE, m),
        "chaosdrill taylor, 1e-11": lambda eta, m: Own(eta, 1e-11, m),
        "chaosdrill taylor, 1e-14": lambda eta, m: Own(eta, 1e-14, m),
        "chaosdrill rk4, 4000 steps a period, 1e-12": lambda eta, m: Own(eta, TOLERANCE, m, "rk4", 4000),
        "chaosdrill rk4, 200 steps a period, 1e-6": lambda eta, m: Own(eta, 1e-6, m, "rk4", 200),
    }
    if "dop853" in METHODS:
        made["chaosdrill dop853, 1e-12"] = lambda eta, m: Own(eta, TOLERANCE, m, "dop853")
    if importlib.util.find_spec("heyoka"):
        made[HeyokaNumba.name] = lambda eta, m: HeyokaNumba(eta, TOLERANCE, m)
        made[HeyokaEvents.name] = lambda eta, m: HeyokaEvents(eta, TOLERANCE, m)
    else:
        print("heyoka is not installed: its rows are left out (pip install heyoka)", file=sys.stderr)
    made[ScipyEvents.name] = lambda eta, m: ScipyEvents(eta, TOLERANCE, m)
    return made


def compare(against: Iterable[Outside], rounds: int, say: Callable[[str], None]) -> list[Measured]:
    """Measure all programs at every eta, with two tangents and without."""
    results = []
    for eta in ETAS:
        for tangents in (0, 2):
            say(f"eta {eta}, {tangents} tangents")
            results += _one_setting(eta, tangents, list(against), rounds)
    return results


def _one_setting(eta: float, tangents: int, against: list[Outside], rounds: int) -> list[Measured]:
    entries: list[tuple[Measured, Callable[[Measured], float]]] = []
    for name, make in own_programs().items():
        program = make(eta, tangents)
        program.advance(SETTLE)
        entries.append((Measured(name, eta, tangents), partial(_own, program, _periods(timed(program, 20)))))
    for other in against:
        speed, _ = other.measure(eta, 1000, TOLERANCE, tangents)
        entries.append((Measured(other.name, eta, tangents), partial(_outside, other, _periods(speed))))
    for _ in range(rounds):
        for result, measure in entries:
            result.times.append(measure(result))
    return [result for result, _ in entries]


def _own(program: Program, periods: int, result: Measured) -> float:
    speed = timed(program, periods)
    result.error = strobe_error(result.eta, program.strobe())
    return speed


def _outside(program: Outside, periods: int, result: Measured) -> float:
    speed, point = program.measure(result.eta, periods, TOLERANCE, result.tangents)
    result.error = strobe_error(result.eta, point)
    return speed


def _periods(speed: float) -> int:
    """Whole cycles of period 4 that fill one measurement."""
    return 4 * max(1, round(SHARE * 1e6 / speed / 4))


def table(results: list[Measured]) -> str:
    """Return the ratios as Markdown: a row a program, times of the package's Taylor method first."""
    names = list(dict.fromkeys(r.name for r in results))
    by = {(r.name, r.eta, r.tangents): r for r in results}
    settings = list(dict.fromkeys((r.eta, r.tangents) for r in results))
    head = ["µs a forcing period (times that of the first row)"]
    head += [f"η {eta}" + (", 2 tangents" if tangents else "") for eta, tangents in settings] + ["strobe error, η 0.63"]
    lines = [head, ["---"] * len(head)]
    for name in names:
        cells = [name]
        for setting in settings:
            first, other = by[(names[0], *setting)].times, by[(name, *setting)].times
            ratio = median(b / a for a, b in zip(first, other, strict=True))
            cells.append(f"{median(other):.3g} ({ratio:.3g})")
        error = max(by[name, 0.63, m].error for m in (0, 2))
        lines.append([*cells, "" if math.isnan(error) else f"{error:.0e}"])
    return "".join("| " + " | ".join(cells) + " |\n" for cells in lines)


def machine(rounds: int) -> str:
    """Return a sentence that names machine, versions and date."""
    names = ["numpy", "numba", "scipy", *(["heyoka"] if importlib.util.find_spec("heyoka") else [])]
    versions = ", ".join(f"{name} {version(name)}" for name in ("chaosdrill", *names))
    return (
        f"Medians of {rounds} interleaved rounds on one core of {processor()}, Python {platform.python_version()}, "
        f"{versions}, {datetime.date.today().isoformat()}."
    )


def processor() -> str:
    """Return the processor's name."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        return next(line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor() or platform.machine()


def one_core() -> None:
    """Keep this process and all that it starts on one core, where the system can."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})


def write(folder: Path, results: list[Measured], rounds: int) -> str:
    """Write ``ratios.md`` and ``ratios.csv`` into a folder and return the Markdown."""
    with (folder / "ratios.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["program", "eta", "tangents", "strobe_error", *(f"us_{i}" for i in range(1, rounds + 1))])
        for r in results:
            writer.writerow([r.name, r.eta, r.tangents, f"{r.error:.2e}", *(f"{t:.4g}" for t in r.times)])
    text = f"{table(results)}\n{machine(rounds)}\n"
    (folder / "ratios.md").write_text(text, encoding="utf-8")
    return text
