"""Work that never hears the first Ctrl-C is left at the second one, which is told."""

import signal
import subprocess
import sys
import time

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
