"""The main loop of a sweep: submit chunks to an executor, collect and store their results.

Executors are this thread, threads of this process, or the workers of a Dask cluster.
"""

import logging
import os
import pickle
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, ThreadPoolExecutor, wait
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, field
from functools import lru_cache
from math import inf
from threading import Lock
from time import monotonic
from typing import TYPE_CHECKING, Any

from chaosdrill.errors import ChaosdrillError, SettingsError
from chaosdrill.progress import Progress
from chaosdrill.sweep.fingerprint import changes, origin
from chaosdrill.sweep.store import Memory, Store
from chaosdrill.sweep.task import Arrays, ChunkSizes, Gaps, Task, run_chunk
from chaosdrill.sweep.tuning import TUNING

if TYPE_CHECKING:
    from distributed import Client


CHATTY = ("tornado.application", "distributed.client")
"""Loggers that print a traceback for each chunk that is cancelled, and for a connection that ends."""

_log = logging.getLogger("chaosdrill")
_unpacking = Lock()


@dataclass(frozen=True)
class Executor:
    """Workers of one task."""

    submit: Callable[[int, int], Future[tuple[Arrays, float]]]
    """Given the first unit and the number of units of a chunk, has it run some time."""
    size: Callable[[], int]  # number of chunks that can run at once
    parallel: bool = True  # whether ``submit`` returns before the chunk has run


def executor_for(task: Task, workers: int, scheduler: str | None) -> AbstractContextManager[Executor]:
    """Workers for a task; on leaving, chunks that have not begun are cancelled."""
    if scheduler is not None:
        return cluster(task, scheduler)
    return threads(task, workers) if workers > 1 else alone(task)


@contextmanager
def alone(task: Task) -> Iterator[Executor]:
    """The calling thread, so that an interruption is heard between two kernels."""

    def submit(first: int, count: int) -> Future[Any]:
        future: Future[Any] = Future()
        future.set_result(run_chunk(task, first, count))
        return future

    yield Executor(submit, lambda: 1, parallel=False)


@contextmanager
def threads(task: Task, workers: int) -> Iterator[Executor]:
    """Threads of this process."""
    executor = ThreadPoolExecutor(workers, thread_name_prefix="chaosdrill")
    try:
        yield Executor(lambda first, count: executor.submit(run_chunk, task, first, count), lambda: workers)
    finally:
        executor.shutdown(wait=True, cancel_futures=True)


def connect(address: str) -> "Client":
    """A client of the scheduler at an address.

    Raises `SettingsError` if Dask is not installed, or nothing answers at the address.
    """
    try:
        from distributed import Client
        from distributed.comm import resolve_address
    except ImportError as fault:
        raise SettingsError(
            f"scheduler is {address!r}, but Dask is not installed ({fault}); install it with: "
            "pip install 'chaosdrill[dask]'"
        ) from fault
    try:
        # a client of something that is no address prints a traceback when it is collected
        resolve_address(address)
        return Client(address, timeout=TUNING.answer_s, set_as_default=False, name="chaosdrill")
    except (ValueError, TypeError) as fault:
        raise SettingsError(
            f"scheduler is {address!r}, which is not the address of a Dask scheduler; give the one that "
            f"'dask scheduler' prints, as in 'tcp://10.0.0.5:8786' ({fault})"
        ) from fault
    except OSError as fault:
        raise SettingsError(
            f"scheduler is {address!r}, where no Dask scheduler answers within {TUNING.answer_s:g} s; start one with "
            f"'dask scheduler' and give the address that it prints, as in 'tcp://10.0.0.5:8786' ({fault})"
        ) from fault


@contextmanager
def cluster(task: Task, address: str) -> Iterator[Executor]:
    """The workers of a scheduler, some of which may join or leave during the work.

    A chunk whose worker dies is run by another one; Dask gives up after several workers have died on the same chunk.
    """
    from distributed.scheduler import KilledWorker

    packed, here = pickle.dumps(task), origin()
    client = connect(address)
    loggers = [logging.getLogger(name) for name in CHATTY]
    for logger in loggers:
        logger.addFilter(_drop)
    executor = client.get_executor(pure=False)
    counted, next_count = 1, -inf

    def size() -> int:
        nonlocal counted, next_count
        if monotonic() > next_count:
            threads = sum(client.nthreads().values())
            if counted and not threads:
                _log.warning("the scheduler at %s has no workers at present; waiting for some", address)
            counted, next_count = threads, monotonic() + TUNING.count_s
        return max(1, counted)

    try:
        yield Executor(lambda first, count: executor.submit(run_packed, packed, here, first, count), size)
    except KilledWorker as fault:
        raise ChaosdrillError(
            f"several workers of the scheduler at {address} died on the same chunk ({fault}); "
            "give them more memory, and read their logs"
        ) from fault
    except (CancelledError, OSError) as fault:
        raise ChaosdrillError(f"the scheduler at {address} no longer answers") from fault
    finally:
        executor.shutdown(wait=False)
        client.close()
        for logger in loggers:
            logger.removeFilter(_drop)


def _drop(_: logging.LogRecord) -> bool:
    return False


def run_packed(packed: bytes, expected: dict[str, Any], first: int, count: int) -> tuple[Arrays, float]:
    """Run a chunk of a pickled task: what the workers of a cluster are sent.

    A task is unpickled once a worker and kept, so that its kernels are compiled, or loaded, once.
    """
    if found := changes(expected, origin()):
        raise SettingsError(
            "a worker of the cluster has other versions, which may change the last digit; install the same ones:\n  "
            + "\n  ".join(line.replace(" before", " here").replace(" now", " there") for line in found)
        )
    with _unpacking:
        task = _unpack(packed)
    return run_chunk(task, first, count)


@lru_cache(maxsize=2)
def _unpack(packed: bytes) -> Any:
    return pickle.loads(packed)


def execute(
    task: Task,
    *,
    workers: int = 1,
    scheduler: str | None = None,
    store: str | os.PathLike[str] | None = None,
    progress: Progress | None = None,
) -> Arrays:
    """Run all units of a task in chunks and return their results by name.

    The same function runs the same units wherever that is, so that the results depend neither on the number of workers
    nor on the chunks, to the bit. Only a few chunks are under way at a time. An interruption cancels those that have
    not begun and leaves those that have finished in the store.

    ``workers``: threads of this process; the kernels hold no lock. ``scheduler``: address of a Dask scheduler, as
    ``"tcp://10.0.0.5:8786"``, whose workers are used instead. Chunks of a worker that dies are run again by another.
    ``store``: folder in which finished chunks are kept on the disk; if some of the same task are there already, only
    the others are run. The results are then mapped from files, and changes stay in memory. ``progress``: called with
    points done, their total, and points by outcome: before the work begins with what was there, and after every chunk.

    Raises `SettingsError` if the store holds results of other work, or the scheduler cannot be used, and `ArchiveError`
    if the store cannot be read or written; what had finished before is kept.
    """
    if scheduler is not None and workers != 1:
        raise SettingsError(
            f"workers is {workers!r}, but the scheduler at {scheduler!r} has workers of its own; leave workers out"
        )
    tally = Tally(task, progress)
    kept: Memory
    if store is None:
        kept = Memory(task)
    else:
        kept = Store(store, task)
        for first, count in kept.finished:
            tally.add(count, kept.part(first, count))
    tally.tell()
    gaps = Gaps(task.units, kept.finished)
    if gaps.left:
        with executor_for(task, workers, scheduler) as executor:
            _run(executor, gaps, kept, tally)
    return kept.arrays()


@dataclass
class Tally:
    """Count of the finished points of a task by outcome, for its listeners."""

    task: Task
    progress: Progress | None
    done: int = 0
    outcomes: Counter[str] = field(default_factory=Counter)

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
        ahead = TUNING.ahead if executor.parallel and not sizes.growing else 1
        while gaps.left and len(pending) < ahead * hands:
            first, count = gaps.take(sizes.next(gaps.left, hands))
            pending[executor.submit(first, count)] = (first, count)
        # what has finished beside a chunk that failed is kept before its fault goes up
        done = wait(pending, return_when=FIRST_COMPLETED).done
        for future in sorted(done, key=lambda one: one.cancelled() or one.exception() is not None):
            first, count = pending.pop(future)
            arrays, seconds = future.result()
            kept.put(first, count, arrays)
            sizes.learn(count, seconds)
            tally.add(count, arrays)
        tally.tell()
