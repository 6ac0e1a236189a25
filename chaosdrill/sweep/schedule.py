"""The main loop of a sweep: submit chunks, collect and store results."""

import os
from collections import Counter
from collections.abc import Mapping
from concurrent.futures import FIRST_COMPLETED, Future, wait
from typing import Any

from chaosdrill.errors import SettingsError
from chaosdrill.progress import Progress
from chaosdrill.sweep.executors import Executor, executor_for
from chaosdrill.sweep.store import Memory, Store
from chaosdrill.sweep.task import Arrays, ChunkSizes, Gaps, Task

AHEAD = 2
"""Chunks under way for each that can run at once, so that no worker waits for the next one."""


def execute(
    task: Task,
    *,
    workers: int = 1,
    scheduler: str | None = None,
    store: str | os.PathLike[str] | None = None,
    progress: Progress | None = None,
) -> Arrays:
    """Run all units of a task in chunks and return their results.

    The same function runs the same units wherever that is, so that the results depend neither on the number of
    workers nor on the chunks, to the bit. Only a few chunks are under way at a time. An interruption cancels those that
    have not begun and leaves those that have finished in the store.

    Parameters
    ----------
    task : Task
        Task to run.
    workers : int, default 1
        Threads of this process; the kernels hold no lock.
    scheduler : str, optional
        Address of a Dask scheduler, as ``"tcp://10.0.0.5:8786"``, whose workers are used instead. Chunks of a worker
        that dies are run again by another.
    store : path-like, optional
        Folder in which finished chunks are kept on the disk. If some of the same task are there already, only the
        others are run. Without it results stay in memory.
    progress : callable, optional
        Called with points done, their total, and points by outcome: before the work begins with what was there, and
        after every chunk.

    Returns
    -------
    dict of str to ndarray
        Results of all units; with a store they are mapped from files, and changes stay in memory.

    Raises
    ------
    SettingsError
        If the store holds results of other work, or the scheduler cannot be used.
    ArchiveError
        If the store cannot be read or written; what had finished before is kept.
    """
    if scheduler is not None and workers != 1:
        raise SettingsError(
            f"workers is {workers!r}, but the scheduler at {scheduler!r} has workers of its own; leave workers out"
        )
    kept = Memory(task) if store is None else Store(store, task)
    tally = Tally(task, progress)
    for first, count in kept.finished:
        tally.add(count, kept.part(first, count))
    tally.tell()
    gaps = Gaps(task.units, kept.finished)
    if gaps.left:
        with executor_for(task, workers, scheduler) as executor:
            _run(executor, gaps, kept, tally)
    return kept.arrays()


class Tally:
    """Count of finished points, by outcome.

    Parameters
    ----------
    task : Task
        What is counted.
    progress : callable, optional
        Who is told.
    """

    def __init__(self, task: Task, progress: Progress | None) -> None:
        self.task = task
        self.progress = progress
        self.done = 0
        self.outcomes: Counter[str] = Counter()

    def add(self, units: int, arrays: Mapping[str, Any]) -> None:
        """Count a chunk."""
        self.done += units * self.task.points_per_unit
        self.outcomes.update(self.task.counts(arrays))

    def tell(self) -> None:
        """Report."""
        if self.progress:
            self.progress(self.done, self.task.total, dict(self.outcomes))


def _run(executor: Executor, gaps: Gaps, kept: Memory, tally: Tally) -> None:
    sizes = ChunkSizes(kept.unit_bytes)
    pending: dict[Future[tuple[Arrays, float]], tuple[int, int]] = {}
    while gaps.left or pending:
        hands = executor.size()
        ahead = AHEAD if executor.parallel and not sizes.growing else 1
        while gaps.left and len(pending) < ahead * hands:
            first, count = gaps.take(sizes.next(gaps.left, hands))
            pending[executor.submit(first, count)] = (first, count)
        # what has finished beside a chunk that failed is kept before its fault goes up
        for future in sorted(wait(pending, return_when=FIRST_COMPLETED).done, key=_failed):
            first, count = pending.pop(future)
            arrays, seconds = future.result()
            kept.put(first, count, arrays)
            sizes.learn(count, seconds)
            tally.add(count, arrays)
        tally.tell()


def _failed(future: Future[Any]) -> bool:
    return future.cancelled() or future.exception() is not None
