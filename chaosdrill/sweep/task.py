"""Interface of a task that can be divided into chunks."""

from collections.abc import Mapping
from time import perf_counter
from typing import Any, Protocol

import numpy as np

Arrays = dict[str, np.ndarray]


class Task(Protocol):
    """Independent units of work: one point of a grid, or one line of a sweep along which a state is followed.

    A task can be pickled, so that other processes can run parts of it.

    Attributes
    ----------
    units : int
        Number of units.
    points_per_unit : int
        Points in a unit.
    total : int
        Total number of points, as counted by progress reports.
    """

    @property
    def units(self) -> int: ...

    @property
    def points_per_unit(self) -> int: ...

    @property
    def total(self) -> int: ...

    def columns(self) -> Mapping[str, tuple[str, tuple[int, ...]]]:
        """Dtype and shape of one unit of each array that ``run`` returns."""
        ...

    def run(self, first: int, count: int) -> Mapping[str, np.ndarray]:
        """Results of the units ``first`` to ``first + count - 1``, over which the first dimension of each array runs.

        No unit's numbers depend on the chunk it is in, to the bit; what goes wrong at a point is its outcome and
        no exception. Several threads may call it at once.
        """
        ...

    def fingerprint(self) -> Mapping[str, Any]:
        """Everything that determines the results, as values that JSON can store."""
        ...

    def counts(self, arrays: Mapping[str, np.ndarray]) -> Mapping[str, int]:
        """Points by outcome in arrays that ``run`` has returned."""
        ...


def run_chunk(task: Task, first: int, count: int) -> tuple[Arrays, float]:
    """Run a chunk of a task; return its results and the time in seconds."""
    start = perf_counter()
    return dict(task.run(first, count)), perf_counter() - start
