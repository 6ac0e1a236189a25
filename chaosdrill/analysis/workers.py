"""Chunks of independent work on threads: the kernels hold no lock."""

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from itertools import islice
from typing import Any, TypeVar

Chunk = TypeVar("Chunk")
Result = TypeVar("Result")


def ordered_map(work: Callable[[Chunk], Result], chunks: Iterable[Chunk], workers: int) -> Iterator[Result]:
    """Results in the order of the chunks; at most a few chunks a worker are under way, and none shares state.

    An interruption cancels what has not begun.
    """
    if workers == 1:
        yield from map(work, chunks)
        return
    executor: Executor = ThreadPoolExecutor(max_workers=workers)
    source = iter(chunks)
    pending: deque[Future[Any]] = deque(executor.submit(work, chunk) for chunk in islice(source, 4 * workers))
    try:
        while pending:
            result = pending.popleft().result()
            pending.extend(executor.submit(work, chunk) for chunk in islice(source, 1))
            yield result
    finally:
        executor.shutdown(wait=True, cancel_futures=True)
