"""Ctrl-C while the compiler calls back waits until it has returned: an exception there is lost, or ends the process."""

import os
import signal
import time

import pytest

from chaosdrill.cli.interrupts import second_one_ends

pytestmark = pytest.mark.usefixtures("interruptible")

CALLED_BACK = """
def called_back(interrupt, seconds):
    interrupt()
    end = clock() + seconds
    while clock() < end:
        pass
    done.append(True)
"""


def interrupt():
    os.kill(os.getpid(), signal.SIGINT)


@pytest.mark.parametrize(("module", "finishes"), [("llvmlite.binding.executionengine", True), ("numba.core", False)])
def test_where_it_is_raised(module, finishes):
    done = []
    scope = {"__name__": module, "clock": time.monotonic, "done": done}
    exec(CALLED_BACK, scope)
    heard = False
    with second_one_ends(130):
        try:
            scope["called_back"](interrupt, 0.3)
            time.sleep(10)
        except KeyboardInterrupt:
            heard = True
    assert heard
    assert bool(done) is finishes


def test_handlers_are_as_before():
    with second_one_ends(130):
        assert signal.getsignal(signal.SIGINT) is not signal.default_int_handler
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    assert signal.getsignal(signal.SIGALRM) is signal.SIG_DFL


def test_whoever_ignores_it_is_left_to_it():
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with second_one_ends(130):
            interrupt()
            assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGINT, before)
