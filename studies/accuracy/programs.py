"""What a program under comparison is: a class for those of our own making, a command line for the others."""

import argparse
import json
import math
import resource
import shlex
import subprocess
import time
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

import chaosdrill as cd
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run
from chaosdrill.engine.structure import examine

SETTLE = 300
"""Forcing periods from rest before anything is measured, in every program."""

REFERENCE = {
    0.8: [(0.5117707419326684, 0.2579689590074009, 0.3668787222623992)],
    0.6: [
        (0.9600731434657304, 0.4240583758953005, 0.5379459585801125),
        (0.6385735529660052, 0.1126868016956719, 0.1451131728326493),
    ],
    0.63: [(0.7201005283205294, 0.1022519359120029, 0.0687759307641452)],
}
"""Strobe points in quadruple precision by eta; of the cycle of period 4 the one at strobes 4, 8, 12, ... from rest."""


class Program(Protocol):
    """The drill from rest by one method."""

    name: str

    def advance(self, periods: int) -> None:
        """Continue for a number of forcing periods."""

    def strobe(self) -> list[float]:
        """State at the last strobe."""


class Own:
    """The package, with one of its methods."""

    def __init__(self, eta: float, tolerance: float, tangents: int, method: str = "taylor", steps: int | None = None):
        system = cd.drill(eta=eta)
        deficient = examine(system).deficient
        numerics = Numerics(method, tolerance, steps)
        frame = np.eye(3)[:tangents]
        self.name = f"chaosdrill {method}" + (f", {steps} steps a period" if steps else "")
        self.run = Run(system, 2 * math.pi / eta, numerics, tangents=frame, deficient=deficient)

    def advance(self, periods: int) -> None:
        """Continue for a number of forcing periods."""
        outcome, _ = self.run.advance(periods)
        if outcome != cd.Outcome.OK:
            raise RuntimeError(f"{self.name}: {outcome.name.lower()}")

    def strobe(self) -> list[float]:
        """State at the last strobe."""
        return [float(v) for v in self.run.x]


@dataclass(frozen=True)
class Outside:
    """A program that is run as a command and prints one line of JSON with ``us_per_period``, perhaps ``strobe``.

    Parameters
    ----------
    name : str
        What it is called in the table.
    command : str
        With ``{eta}``, ``{periods}`` and ``{tolerance}``; ``[--lyap]`` stands for a flag that is given where tangents
        are wanted.
    """

    name: str
    command: str

    def measure(self, eta: float, periods: int, tolerance: float, tangents: int) -> tuple[float, list[float] | None]:
        """Return microseconds a period, and the state at the last strobe where the program prints it.

        The program's own time is that of the clock; it is reduced by the share in which it had no processor.
        """
        flag = self.command.replace("[--lyap]", "--lyap" if tangents else "")
        words = [word.format(eta=eta, periods=periods, tolerance=tolerance) for word in shlex.split(flag)]
        begin, before = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
        done = subprocess.run(words, capture_output=True, text=True, check=True)
        clock, after = time.perf_counter() - begin, resource.getrusage(resource.RUSAGE_CHILDREN)
        busy = after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime
        line = json.loads(done.stdout.strip().splitlines()[-1])
        return float(line["us_per_period"]) * min(1.0, busy / clock), line.get("strobe")


def strobe_error(eta: float, point: list[float] | None) -> float:
    """Return the largest distance of a strobe point from the nearest reference point; NaN without one."""
    if point is None or eta not in REFERENCE:
        return math.nan
    return float(np.abs(np.array(REFERENCE[eta]) - np.array(point)).max(axis=1).min())


def timed(program: Program, periods: int) -> float:
    """Microseconds of the processor a forcing period over the next periods; other work of the machine counts less."""
    begin = time.process_time()
    program.advance(periods)
    return (time.process_time() - begin) / periods * 1e6


def report(make: Any) -> None:
    """Run a program as the command line asks, after it has settled, and print the line of JSON."""
    parser = argparse.ArgumentParser()
    parser.add_argument("eta", type=float)
    parser.add_argument("periods", type=int)
    parser.add_argument("tolerance", type=float)
    parser.add_argument("--lyap", action="store_true", help="with two tangents")
    given, _ = parser.parse_known_args()
    program = make(given.eta, given.tolerance, 2 if given.lyap else 0)
    program.advance(SETTLE)
    speed = timed(program, given.periods)
    print(json.dumps({"us_per_period": speed, "strobe": program.strobe()}))
