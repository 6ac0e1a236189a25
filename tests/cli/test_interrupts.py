"""Ctrl-C ends a run, with exit code 130, and leaves what was there, whenever it comes."""

import json
import os
import signal
import subprocess
import sys
import time

import pytest

from chaosdrill.cli.interrupts import second_one_ends
from chaosdrill.sweep.store import kept_points

# Ctrl-C ends a long run soon, with exit code 130, and leaves what was there.


pytestmark = pytest.mark.usefixtures("interruptible")

LONG = """\
[system]
model = "percussive-drill"
effects = { drive = "harmonic", friction = "stribeck", rock = "moving", contact = "hunt-crossley" }
[analysis.long]
"""

SPECTRUM = 'kind = "lyapunov-spectrum"\nperiods = 100000000\n'

DIAGRAM = 'kind = "bifurcation-diagram"\nsweep.eta = { start = 0.6, stop = 0.9, num = 100000 }\n'

DIAGRAM += "transient = 10\nperiods = 1000\n"


@pytest.mark.parametrize(("analysis", "workers"), [(SPECTRUM, 1), (DIAGRAM, 1), (DIAGRAM, 2)])
def test_an_interrupt_keeps_the_earlier_archive_and_finished_parts(tmp_path, analysis, workers):
    (tmp_path / "scene.toml").write_text(LONG + analysis)
    (tmp_path / "out.nc").write_bytes(b"the earlier archive")
    command = [sys.executable, "-m", "chaosdrill", "run", "scene.toml", "-o", "out.nc", "--workers", str(workers)]
    with subprocess.Popen(command, cwd=tmp_path, stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr.readline().startswith("long: started")
        # let it get into the compiled code, or finish something
        if analysis == DIAGRAM:
            while not kept_points(tmp_path / "out.nc.parts" / "long")[0]:
                assert process.poll() is None
                time.sleep(0.05)
        else:
            time.sleep(3)
        process.send_signal(signal.SIGINT)
        told = process.communicate(timeout=60)[1]
    assert process.returncode == 130
    assert told.splitlines()[-1] == "interrupted"
    assert "Traceback" not in told
    assert (tmp_path / "out.nc").read_bytes() == b"the earlier archive"
    left = {"out.nc", "scene.toml"}
    if analysis == DIAGRAM:
        left.add("out.nc.parts")
        assert "finished parts are kept in out.nc.parts; continue with --resume\n" in told
    assert {path.name for path in tmp_path.iterdir()} == left


# The second Ctrl-C ends the process at once, with the exit code of an interrupt, whenever it comes.


# releases the interpreter's lock for half an hour, as a kernel does, and hears no signal meanwhile
DEAF = """
import hashlib
from chaosdrill.cli.interrupts import second_one_ends
with second_one_ends(130):
    print("begins", flush=True)
    hashlib.pbkdf2_hmac("sha256", b"", b"", 2**31 - 1)
"""


def test_second_interrupt():
    streams = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen([sys.executable, "-c", DEAF], **streams) as process:
        try:
            assert process.stdout.readline() == "begins\n"
            # from the line that prints to the deaf one
            time.sleep(2)
            process.send_signal(signal.SIGINT)
            while "press Ctrl-C again to stop at once" not in (line := process.stderr.readline()):
                assert line, "it ended at the first one"
            process.send_signal(signal.SIGINT)
            told = process.communicate(timeout=20)[1]
        finally:
            process.kill()
    assert process.returncode == 130
    assert told.strip() == "interrupted at once"


# Ctrl-C as soon as the command reads its scene, and once more where it says so, or where it ends
TWICE = """
import atexit, os, signal, sys, time
import click
from chaosdrill.cli import main

def interrupt(*_, **__):
    os.kill(os.getpid(), signal.SIGINT)
    time.sleep(0.2)

class Stream:
    class buffer:
        def read(size):
            # libraries make code of texts, and Python remembers that an interrupt went through it
            exec("interrupt()")

sys.stdin = Stream
match sys.argv.pop():
    case "told":
        click.echo = interrupt
    case "over":
        atexit.register(interrupt)
sys.exit(main())
"""


@pytest.mark.parametrize("when", ["never", "told", "over"])
def test_second_interrupt_on_the_way_out(tmp_path, when):
    (tmp_path / "twice.py").write_text(TWICE)
    command = [sys.executable, "-m", "twice", "check", "-", when]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=60)
    assert done.returncode == 130
    assert done.stderr.strip() in ("interrupted", "interrupted at once")


# Ctrl-C while the commands are imported

EARLY = """
import sys
from chaosdrill.cli import main

class Finder:
    def find_spec(name, *_):
        if name == "chaosdrill.cli.program":
            raise KeyboardInterrupt

sys.meta_path.insert(0, Finder)
sys.exit(main())
"""


def test_an_interrupt_while_the_commands_are_imported():
    command = [sys.executable, "-c", EARLY, "list", "methods", "--json"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert done.returncode == json.loads(done.stdout)["error"]["exit_code"] == 130
    assert done.stderr.strip() == "interrupted"


# Ctrl-C while the compiler calls back waits until it has returned: an exception there is lost, or ends the process.


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
