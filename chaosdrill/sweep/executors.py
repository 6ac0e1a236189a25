"""Executors of chunks: this thread, threads of this process, or the workers of a Dask cluster."""

import logging
import pickle
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from functools import lru_cache
from math import inf
from threading import Lock
from time import monotonic
from typing import TYPE_CHECKING, Any

from chaosdrill.errors import ChaosdrillError, SettingsError
from chaosdrill.sweep.fingerprint import changes, origin
from chaosdrill.sweep.task import Arrays, Task, run_chunk

if TYPE_CHECKING:
    from distributed import Client

ANSWER_S = 10
"""Seconds within which a scheduler is to answer."""

COUNT_S = 1.0
"""Seconds between two looks at how many workers there are."""

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

    Raises
    ------
    SettingsError
        If Dask is not installed, or nothing answers at the address.
    """
    try:
        from distributed import Client
    except ImportError as fault:
        raise SettingsError(
            f"scheduler is {address!r}, but Dask is not installed ({fault}); install it with: "
            "pip install 'chaosdrill[dask]'"
        ) from fault
    if not isinstance(address, str) or not address:
        raise SettingsError(f"scheduler is {address!r}; it must be an address, as in 'tcp://10.0.0.5:8786'")
    try:
        return Client(address, timeout=ANSWER_S, set_as_default=False, name="chaosdrill")
    except (OSError, ValueError, TypeError) as fault:
        raise SettingsError(
            f"scheduler is {address!r}, where no Dask scheduler answers within {ANSWER_S} s; start one with "
            f"'dask scheduler' and give the address that it prints, as in 'tcp://10.0.0.5:8786' ({fault})"
        ) from fault


@contextmanager
def cluster(task: Task, address: str) -> Iterator[Executor]:
    """The workers that a scheduler has, whoever joins or leaves them during the work.

    A chunk whose worker dies is run by another one; Dask gives up after several workers have died of the same chunk.
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
            counted, next_count = threads, monotonic() + COUNT_S
        return max(1, counted)

    try:
        yield Executor(lambda first, count: executor.submit(run_packed, packed, here, first, count), size)
    except KilledWorker as fault:
        raise ChaosdrillError(
            f"several workers of the scheduler at {address} died of the same chunk ({fault}); "
            "give them more memory, and look into their logs"
        ) from fault
    except (CancelledError, OSError) as fault:
        raise ChaosdrillError(f"the scheduler at {address} does not answer any more") from fault
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
