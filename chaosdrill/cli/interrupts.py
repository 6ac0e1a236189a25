"""Ctrl-C while code is compiled, or compiled code runs.

The first one takes effect when the running code returns, which for a single long point may be never. The second one
ends the process at once, as a kill would: finished parts are on the disk, and nothing else is.
"""

import atexit
import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from types import FrameType

from chaosdrill.cli.tuning import TUNING

COMPILER = "llvmlite"
"""The compiler calls back into it; an exception raised there is lost, or crashes the process."""


@contextmanager
def second_one_ends(code: int, *, last: bool = False) -> Iterator[None]:
    """While the block runs, the second interrupt ends the process with this exit code.

    The interpreter writes signals to a pipe, whatever the main thread does; a separate thread reads them, which works
    because compiled code releases the interpreter's lock. Only the main thread receives signals; in other threads, and
    if the user has installed handlers or ignores Ctrl-C, nothing is done.

    ``code``: the exit code. ``last``: whether the process ends after the block. Then any interrupt on the way out ends
    it with this code as well.
    """
    if (
        threading.current_thread() is not threading.main_thread()
        or signal.getsignal(signal.SIGINT) is not signal.default_int_handler
        or signal.getsignal(signal.SIGALRM) is not signal.SIG_DFL
    ):
        yield
        return
    raised = False
    hint = threading.Timer(
        TUNING.patience_s, _say, ["\ninterrupted; finishing the work in progress, press Ctrl-C again to stop at once"]
    )
    hint.daemon = True

    def handle(_: int, frame: FrameType | None) -> None:
        """Raise KeyboardInterrupt once; within the compiler, retry a little later."""
        nonlocal raised
        while frame is not None and not raised:
            if str(frame.f_globals.get("__name__", "")).partition(".")[0] == COMPILER:
                signal.setitimer(signal.ITIMER_REAL, TUNING.retry_s)
                return
            frame = frame.f_back
        if not raised:
            raised = True
            raise KeyboardInterrupt

    def listen() -> None:
        """Read the signals from the pipe: the handler may miss some, and several at once count as one."""
        with os.fdopen(reading, "rb", buffering=0) as pipe:
            while number := pipe.read(1):
                if number[0] == signal.SIGINT:
                    if hint.ident is not None:
                        end()
                    hint.start()

    def end(*_: object) -> None:
        _say("\ninterrupted at once")
        os._exit(code)

    signal.signal(signal.SIGINT, handle)
    signal.signal(signal.SIGALRM, handle)
    reading, writing = os.pipe()
    os.set_blocking(writing, False)
    before = signal.set_wakeup_fd(writing, warn_on_full_buffer=False)
    threading.Thread(target=listen, daemon=True).start()
    try:
        yield
    finally:
        hint.cancel()
        signal.signal(signal.SIGINT, end if last else signal.default_int_handler)
        if last:
            # nothing is left to be interrupted then, and the interpreter takes its handlers away
            atexit.register(signal.signal, signal.SIGINT, signal.SIG_IGN)
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
        signal.set_wakeup_fd(before)
        os.close(writing)


def _say(text: str) -> None:
    # nobody may be there to read it
    with suppress(OSError):
        os.write(2, f"{text}\n".encode())
