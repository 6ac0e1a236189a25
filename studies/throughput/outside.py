"""Programs that the charts are compared with: a command that prints one line of JSON with ``us_per_period``."""

import json
import resource
import shlex
import subprocess
import time
from dataclasses import dataclass

SAMPLES = 8
"""Values of eta over which the cost of a program is averaged; programs that step several points take them at once."""

SETTLE_S = 0.1
"""Seconds of one run."""


@dataclass(frozen=True)
class Program:
    """A program of the drill with two tangents, from rest.

    Parameters
    ----------
    name : str
        What it is called in the tables.
    command : str
        With ``{eta}``, ``{periods}`` and ``{tolerance}``. A program that steps eight points at once has ``{spread}``,
        the distance of their values of eta, too.
    """

    name: str
    command: str

    @property
    def many(self) -> bool:
        """Whether it steps several points at once."""
        return "{spread}" in self.command

    def cost(self, first: float, last: float, tolerance: float, periods: int) -> float:
        """Microseconds of the processor a point and forcing period, on average between two values of eta."""
        width = last - first
        if self.many:
            return self._run(first, tolerance, periods, width / (SAMPLES - 1))
        etas = [first + width * (i + 0.5) / SAMPLES for i in range(SAMPLES)]
        return sum(self._run(eta, tolerance, periods, 0.0) for eta in etas) / SAMPLES

    def periods(self, eta: float, tolerance: float) -> int:
        """Periods that fill one run."""
        return max(100, round(SETTLE_S * 1e6 / self._run(eta, tolerance, 2000, 1e-4)))

    def _words(self, eta: float, tolerance: float, periods: int, spread: float) -> list[str]:
        given = {"eta": eta, "tolerance": tolerance, "periods": periods, "spread": spread}
        return [word.format(**given) for word in shlex.split(self.command)]

    def _run(self, eta: float, tolerance: float, periods: int, spread: float) -> float:
        """The program's own figure is of the clock; it is reduced by the share in which it had no processor."""
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        process = subprocess.Popen(self._words(eta, tolerance, periods, spread), stdout=subprocess.PIPE, text=True)
        begin = time.perf_counter()
        text, _ = process.communicate()
        clock, after = time.perf_counter() - begin, resource.getrusage(resource.RUSAGE_CHILDREN)
        busy = after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime
        return _figure(text) * min(1.0, busy / clock)


def _figure(text: str) -> float:
    return float(json.loads(text.strip().splitlines()[-1])["us_per_period"])
