"""Who runs chunks: this thread, threads of this process, or the workers of a Dask cluster."""

from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from typing import Any

from chaosdrill.sweep.task import Arrays, Task, run_chunk


@dataclass(frozen=True)
class Crew:
    """Workers of one task.

    Parameters
    ----------
    submit : callable
        Given the first unit and the number of units of a chunk, has it run some time.
    size : callable
        How many chunks can run at once now.
    parallel : bool
        Whether ``submit`` returns before the chunk has run.
    """

    submit: Callable[[int, int], "Future[tuple[Arrays, float]]"]
    size: Callable[[], int]
    parallel: bool = True


def hire(task: Task, workers: int, scheduler: str | None) -> AbstractContextManager[Crew]:
    """Workers for a task; on leaving, chunks that have not begun are cancelled."""
    if scheduler is not None:
        from chaosdrill.sweep.cluster import cluster

        return cluster(task, scheduler)
    return threads(task, workers) if workers > 1 else alone(task)


@contextmanager
def alone(task: Task) -> Iterator[Crew]:
    """The calling thread, so that an interruption is heard between two kernels."""

    def submit(first: int, count: int) -> "Future[Any]":
        future: Future[Any] = Future()
        future.set_result(run_chunk(task, first, count))
        return future

    yield Crew(submit, lambda: 1, parallel=False)


@contextmanager
def threads(task: Task, workers: int) -> Iterator[Crew]:
    """Threads of this process."""
    executor = ThreadPoolExecutor(workers, thread_name_prefix="chaosdrill")
    try:
        yield Crew(lambda first, count: executor.submit(run_chunk, task, first, count), lambda: workers)
    finally:
        executor.shutdown(wait=True, cancel_futures=True)
