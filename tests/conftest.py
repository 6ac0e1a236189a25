"""Settings that every test shares."""

import gc
import os
import signal
import subprocess
import sys

import pytest

os.environ.setdefault("MPLBACKEND", "Agg")
# tests run side by side already, on matrices so small that threads cost more than they save
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# without bytecode each process that a test starts would compile the package again
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

from hypothesis import settings

# the first example of a property may wait for a compiler
settings.register_profile("chaosdrill", deadline=None, derandomize=True, print_blob=True)
settings.load_profile("chaosdrill")

# expressions are many small objects that live long: with Python's own thresholds a sixth of what it takes to derive and
# compile a system goes into looking for garbage among them
gc.set_threshold(100_000, 20, 20)


def pytest_configure(config):
    """Compile all of the engine before several workers start, which would compile the same parts at the same time."""
    if getattr(config.option, "numprocesses", None) and not hasattr(config, "workerinput"):
        subprocess.run([sys.executable, "-m", "chaosdrill", "warm"], check=True)


def pytest_collection_finish():
    """What has been imported and collected by now stays, and is not looked through for garbage again."""
    gc.collect()
    gc.freeze()


@pytest.fixture(autouse=True)
def _figures_are_closed():
    """A figure that stays open counts among those of later tests."""
    yield
    if pyplot := sys.modules.get("matplotlib.pyplot"):
        pyplot.close("all")


@pytest.fixture
def interruptible():
    """Ctrl-C is heard, here and in processes that a test starts, also where it is ignored, as in a background job."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)
