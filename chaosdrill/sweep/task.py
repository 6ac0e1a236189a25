"""A task that can be divided into chunks, and the sizes of these, from the cost of recent ones."""

from collections.abc import Iterable, Mapping
from time import perf_counter
from typing import Any, Protocol

import numpy as np

from chaosdrill.sweep.tuning import TUNING

Arrays = dict[str, np.ndarray]


class Task(Protocol):
    """Independent units of work: one point of a grid, or one line of a sweep along which a state is followed.

    A task can be pickled, so that other processes can run parts of it.

    ``units``: number of units. ``points_per_unit``: points in a unit. ``total``: total number of points, as counted by
    progress reports.
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


class ChunkSizes:
    """Sizes of future chunks.

    The first chunks are small, since the cost of a unit is unknown. Then sizes grow until a chunk takes about a
    second, shrink at once when units become expensive, and shrink towards the end so that all workers end together.

    ``unit_bytes``: size of the results of one unit.
    """

    def __init__(self, unit_bytes: int) -> None:
        self.most = max(1, min(TUNING.most_units, TUNING.chunk_bytes // max(unit_bytes, 1)))
        self.cost = 0.0
        self.largest = 0

    def learn(self, count: int, seconds: float) -> None:
        """Record the cost of a chunk: a higher cost counts at once, a lower one gradually.

        What the first chunk spends on compiling is forgotten within a few chunks.
        """
        cost = seconds / count
        self.cost = max(cost, (cost + self.cost) / 2)
        self.largest = max(self.largest, count)

    @property
    def growing(self) -> bool:
        """Whether chunks are still much shorter than intended, so that none should be queued."""
        return self.cost * self.largest < TUNING.chunk_s / 10

    def next(self, left: int, workers: int) -> int:
        """Number of units of the next chunk, out of ``left`` that are not assigned yet."""
        if not self.largest:
            many = workers == 1 or left >= TUNING.first_units**2 * workers
            return min(TUNING.first_units, self.most, left) if many else 1
        cost = max(self.cost, TUNING.least_cost_s)
        share = left / (2 * workers) if workers > 1 else left
        most = max(share, TUNING.last_chunk_s / cost)
        size = min(TUNING.chunk_s / cost, most, TUNING.growth * self.largest, self.most)
        return max(1, min(int(size), left))


class Gaps:
    """Units still to be computed, handed out in order.

    ``units``: total number of units. ``finished``: chunks that are already finished, in any order; they may overlap.
    """

    def __init__(self, units: int, finished: Iterable[tuple[int, int]] = ()) -> None:
        self.spans: list[tuple[int, int]] = []
        begin = 0
        for first, count in sorted(finished):
            if first > begin:
                self.spans.append((begin, first))
            begin = max(begin, first + count)
        if begin < units:
            self.spans.append((begin, units))
        self.spans.reverse()
        self.left = sum(end - begin for begin, end in self.spans)

    def take(self, count: int) -> tuple[int, int]:
        """The next chunk: ``count`` units, or fewer at the end of a gap."""
        begin, end = self.spans.pop()
        count = min(count, end - begin)
        if begin + count < end:
            self.spans.append((begin + count, end))
        self.left -= count
        return begin, count
