"""The second Ctrl-C ends the process at once, with the exit code of an interrupt, whenever it comes."""

import signal
import subprocess
import sys
import time

import pytest

pytestmark = pytest.mark.usefixtures("interruptible")

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
            while "a second Ctrl-C ends at once" not in (line := process.stderr.readline()):
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
