"""How long a chart would take on a machine without other work: time of the clock less what threads waited for a core.

Linux counts for every thread how long it stood ready while others ran. What threads wait for each other, and the time
in which a worker has nothing to do, stays in.
"""

import contextlib
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from own import Chart, spend

from chaosdrill.sweep import schedule


def alone(chart: Chart, workers: int) -> tuple[float, float]:
    """Seconds of a chart with this number of workers, without the waiting for other work and with it."""
    with _watched() as seen:
        waited = _waited(threading.get_native_id())
        clock = spend(chart, workers).clock_s
        waited = _waited(threading.get_native_id()) - waited
    if workers == 1:
        return clock - waited, clock
    before_and_after = clock - seen["clock"] - (waited - seen["waited"])
    # an executor starts a thread when none is idle: what was never started never waited
    beside = seen["clock"] - sum(seen["workers"]) / workers
    # the thread that hands out chunks needs a core, too
    return before_and_after + beside + seen["processor"] / workers, clock


@contextlib.contextmanager
def _watched() -> Iterator[dict[str, Any]]:
    """While there are workers: the time of the clock, waiting of each, waiting and processor time of this thread."""
    original, seen = schedule.executor_for, {}

    @contextlib.contextmanager
    def watched(*given: Any) -> Iterator[Any]:
        with original(*given) as executor:
            main = threading.get_native_id()
            clock, processor, waited = time.perf_counter(), time.thread_time(), _waited(main)
            yield executor
            seen["clock"], seen["processor"] = time.perf_counter() - clock, time.thread_time() - processor
            seen["waited"] = _waited(main) - waited
            team = (t.native_id for t in threading.enumerate() if t.name.startswith("chaosdrill"))
            seen["workers"] = [_waited(number) for number in team]

    schedule.executor_for = watched
    try:
        yield seen
    finally:
        schedule.executor_for = original


def _waited(thread: int) -> float:
    """Seconds for which a thread of this process was ready and had no core."""
    return int(Path(f"/proc/self/task/{thread}/schedstat").read_text().split()[1]) / 1e9
