"""Ctrl-C while code is compiled, or compiled code runs.

The first one is heard when the code under way returns, which for a single long point may be never. The second one ends
the process at once, as a kill would: what has finished lies on the disk, and nothing else does.
"""

import atexit
import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from types import FrameType
from typing import Any

PATIENCE_S = 2.0
"""Seconds after which one is told of the second Ctrl-C."""

RETRY_S = 0.05
COMPILER = "llvmlite"
"""The compiler calls back into it; an exception that comes out of there is lost, or the process ends by a fault."""


@contextmanager
def second_one_ends(code: int, *, last: bool = False) -> Iterator[None]:
    """While the block runs, the second interrupt ends the process with this exit code.

    Signals are written to a pipe by the interpreter, whatever the main thread does; a thread of its own reads them,
    which it can since compiled code does not hold the interpreter's lock. Other threads than the main one hear no
    signals; for them, and for who has set handlers of his own or has a run ignore Ctrl-C, nothing is done.

    Parameters
    ----------
    code : int
        The exit code.
    last : bool
        Whether the process ends after the block. Then any interrupt on the way out ends it with this code as well.
    """
    handled: list[tuple[signal.Signals, Any]] = [
        (signal.SIGINT, signal.default_int_handler),
        (signal.SIGALRM, signal.SIG_DFL),
    ]
    if threading.current_thread() is not threading.main_thread() or any(
        signal.getsignal(number) is not usual for number, usual in handled
    ):
        yield
        return
    interrupts = _Interrupts(code)
    for number, _ in handled:
        signal.signal(number, interrupts.handle)
    reading, writing = os.pipe()
    os.set_blocking(writing, False)
    before = signal.set_wakeup_fd(writing, warn_on_full_buffer=False)
    threading.Thread(target=interrupts.listen, args=(reading,), daemon=True).start()
    try:
        yield
    finally:
        interrupts.over.set()
        if last:
            signal.signal(signal.SIGINT, interrupts.end)
            # nothing is left to be interrupted then, and the interpreter takes its handlers away
            atexit.register(signal.signal, signal.SIGINT, signal.SIG_IGN)
        else:
            signal.signal(signal.SIGINT, handled[0][1])
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
        signal.set_wakeup_fd(before)
        os.close(writing)


class _Interrupts:
    """The interrupts of one block.

    The handler and the thread count on their own: interrupts that follow each other at once are one for the handler.
    """

    def __init__(self, code: int) -> None:
        self.code = code
        self.over = threading.Event()
        self.raised = False

    def handle(self, number: int, frame: FrameType | None) -> None:
        """Raise KeyboardInterrupt once; within the compiler, retry a little later."""
        if self.raised:
            if number == signal.SIGINT:
                self.end()
            return
        while frame is not None:
            if str(frame.f_globals.get("__name__", "")).partition(".")[0] == COMPILER:
                signal.setitimer(signal.ITIMER_REAL, RETRY_S)
                return
            frame = frame.f_back
        self.raised = True
        raise KeyboardInterrupt

    def listen(self, reading: int) -> None:
        """Read the signals from a pipe."""
        heard = 0
        with os.fdopen(reading, "rb", buffering=0) as pipe:
            while number := pipe.read(1):
                if number[0] != signal.SIGINT:
                    continue
                heard += 1
                if heard == 2:
                    self.end()
                threading.Thread(target=self.explain, daemon=True).start()

    def explain(self) -> None:
        """Tell of the second Ctrl-C if the first one is not heard soon."""
        if not self.over.wait(PATIENCE_S):
            _say("\ninterrupted; waiting for the work under way, a second Ctrl-C ends at once")

    def end(self, *_: object) -> None:
        """End the process."""
        _say("\ninterrupted at once")
        os._exit(self.code)


def _say(text: str) -> None:
    # nobody may be there to read it
    with suppress(OSError):
        os.write(2, f"{text}\n".encode())
