"""A task whose results are known to the bit and whose costs are chosen; other processes import it."""

import os
import signal
import time
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Logistic:
    """Unit k iterates x -> a x (1 - x) at a = 3.5 + k/(2 units)."""

    units: int = 500
    iterations: int = 40
    pause: float = 0.0
    points_per_unit: int = 1

    @property
    def total(self):
        return self.units * self.points_per_unit

    def columns(self):
        return {"orbit": ("<f8", (self.iterations,)), "code": ("|i1", ()), "none": ("<f8", (0,))}

    def run(self, first, count):
        index = np.arange(first, first + count)
        time.sleep(self.pause * count)
        a, x = 3.5 + 0.5 * index / self.units, np.full(count, 0.3)
        orbit = np.empty((count, self.iterations))
        for i in range(self.iterations):
            x = a * x * (1 - x)
            orbit[:, i] = x
        orbit[index % 7 == 3] = np.nan
        return {"orbit": orbit, "code": (index % 7).astype(np.int8), "none": np.zeros((count, 0))}

    def fingerprint(self):
        return {"map": "logistic", "units": self.units, "iterations": self.iterations}

    def counts(self, arrays):
        values, counts = np.unique(arrays["code"], return_counts=True)
        return {f"code {value}": int(count) for value, count in zip(values, counts, strict=True)}


@dataclass(frozen=True)
class Deadly(Logistic):
    """Unit 50 ends the process that runs it."""

    def run(self, first, count):
        if first <= 50 < first + count:
            os.kill(os.getpid(), signal.SIGKILL)
        return super().run(first, count)


@dataclass(frozen=True)
class Faulty(Logistic):
    """Fails at unit 200."""

    def run(self, first, count):
        if first <= 200 < first + count:
            raise ZeroDivisionError("unit 200")
        return super().run(first, count)
