"""A chart of the drill as a scene, run as `chaosdrill run` does it, and what of its time is spent where."""

import contextlib
import io
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from chaosdrill.cli.run import run
from chaosdrill.engine.batch import Batch

TOLERANCE = 1e-10
LOAD = (0.6995, 0.7005)
"""The static load b over a chart: too narrow to change what a period costs."""


@dataclass(frozen=True)
class Chart:
    """A chart over eta and b.

    Parameters
    ----------
    eta : tuple of two floats
        First and last value.
    side : int
        Values of either parameter.
    transient, periods : int
        Forcing periods of a point.
    tolerance : float
    max_extension : int
        How many times as long an undecided point may run on; 8 is what a scene has that says nothing.
    """

    eta: tuple[float, float]
    side: int
    transient: int = 300
    periods: int = 300
    tolerance: float = TOLERANCE
    max_extension: int = 8

    @property
    def points(self) -> int:
        return self.side**2

    @property
    def asked(self) -> int:
        """Forcing periods that the scene asks for; undecided points run on, and take more."""
        return self.points * (self.transient + self.periods)

    def scene(self) -> str:
        """Text of the scene."""
        sweeps = {"eta": self.eta, "b": LOAD}
        return "\n".join(
            [
                'title = "Throughput"',
                "[system]",
                'model = "percussive-drill"',
                "[system.effects]",
                'drive = "harmonic"\nfriction = "stribeck"\nrock = "moving"\ncontact = "hunt-crossley"',
                "[system.parameters]",
                "xi = 0.06",
                "[numerics]",
                f"tolerance = {self.tolerance!r}",
                "[analysis.chart]",
                'kind = "parameter-chart"',
                *(
                    f"sweep.{name} = {{ start = {first!r}, stop = {last!r}, num = {self.side} }}"
                    for name, (first, last) in sweeps.items()
                ),
                f"transient = {self.transient}\nperiods = {self.periods}\nexponents = 2",
                f"max_extension = {self.max_extension}",
            ]
        )


@dataclass(frozen=True)
class Spent:
    """What a chart has taken.

    Attributes
    ----------
    clock_s, processor_s : float
        Time of the clock, and of the processor in all threads, from the scene to the archive.
    stepping_s : float
        Processor time of the kernels, where one thread ran them.
    periods : int
        Forcing periods that were run, those of undecided points that went on among them.
    """

    clock_s: float
    processor_s: float
    stepping_s: float
    periods: int


def spend(chart: Chart, workers: int = 1) -> Spent:
    """Run a chart from the scene to the archive."""
    with tempfile.TemporaryDirectory() as folder, _stepping() as stepping, _silence():
        scene = Path(folder) / "scene.toml"
        scene.write_text(chart.scene(), encoding="utf-8")
        clock, processor = time.perf_counter(), time.process_time()
        run.callback(str(scene), str(Path(folder) / "out.nc"), {}, workers, None, resume=False, as_json=False)
        processor, clock = time.process_time() - processor, time.perf_counter() - clock
    return Spent(clock, processor, sum(s for s, _ in stepping), sum(p for _, p in stepping))


@contextlib.contextmanager
def _stepping() -> Iterator[list[tuple[float, int]]]:
    """Seconds and forcing periods of every call of the kernels."""
    proceed, calls = Batch.proceed, []

    def timed(batch: Batch, which: np.ndarray, transient: int, ends: np.ndarray) -> None:
        begin = time.thread_time()
        proceed(batch, which, transient, ends)
        calls.append((time.thread_time() - begin, len(which) * (transient + int(ends[-1]))))

    Batch.proceed = timed
    try:
        yield calls
    finally:
        Batch.proceed = proceed


@contextlib.contextmanager
def _silence() -> Iterator[None]:
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        yield
