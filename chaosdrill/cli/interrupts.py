"""Ctrl-C while code is compiled, or compiled code runs.

The first one is heard when the code under way returns, which for a single long point may be never. The second one ends
the process at once, as a kill would: what has finished lies on the disk, and nothing else does.
"""

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from types import FrameType
from typing import Any

PATIENCE_S = 2.0
"""Seconds after which one is told of the second Ctrl-C."""

AGAIN_S = 0.05
COMPILER = "llvmlite"
"""The compiler calls back into it; an exception that comes out of there is lost, or the process ends by a fault."""


@contextmanager
def second_one_ends(code: int) -> Iterator[None]:
    """While the block runs, the second interrupt ends the process with this exit code.

    Signals are written to a pipe by the interpreter, whatever the main thread does; a thread of its own reads them,
    which it can since compiled code does not hold the interpreter's lock. Other threads than the main one hear no
    signals, and for them nothing is done.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    handled: list[tuple[signal.Signals, Any]] = [
        (signal.SIGINT, signal.default_int_handler),
        (signal.SIGALRM, signal.SIG_DFL),
    ]
    # who has set handlers of his own, or has a run ignore Ctrl-C, is to have it so
    ours = all(signal.getsignal(number) is usual for number, usual in handled)
    if ours:
        for number, _ in handled:
            signal.signal(number, _interrupt)
    reading, writing = os.pipe()
    os.set_blocking(writing, False)
    before = signal.set_wakeup_fd(writing, warn_on_full_buffer=False)
    over = threading.Event()
    threading.Thread(target=_listen, args=(reading, code, over), daemon=True).start()
    try:
        yield
    finally:
        over.set()
        signal.set_wakeup_fd(before)
        os.close(writing)
        if ours:
            signal.setitimer(signal.ITIMER_REAL, 0)
            for number, usual in handled:
                signal.signal(number, usual)


def _interrupt(_number: int, frame: FrameType | None) -> None:
    """Raise KeyboardInterrupt, or come again a little later if this is within the compiler."""
    while frame is not None:
        if str(frame.f_globals.get("__name__", "")).partition(".")[0] == COMPILER:
            signal.setitimer(signal.ITIMER_REAL, AGAIN_S)
            return
        frame = frame.f_back
    raise KeyboardInterrupt


def _listen(reading: int, code: int, over: threading.Event) -> None:
    heard = 0
    with os.fdopen(reading, "rb", buffering=0) as pipe:
        while number := pipe.read(1):
            if number[0] != signal.SIGINT:
                continue
            heard += 1
            if heard == 2:
                _say("\ninterrupted at once")
                os._exit(code)
            threading.Thread(target=_explain, args=(over,), daemon=True).start()


def _explain(over: threading.Event) -> None:
    if not over.wait(PATIENCE_S):
        _say("\ninterrupted; waiting for the work under way, a second Ctrl-C ends at once")


def _say(text: str) -> None:
    # nobody may be there to read it
    with suppress(OSError):
        os.write(2, f"{text}\n".encode())
