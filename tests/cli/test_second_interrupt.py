"""A point that does not end in time is left at the second Ctrl-C, and what had finished is kept."""

import signal
import subprocess
import sys
import time

SCENE = """\
[system]
model = "percussive-drill"
effects = { drive = "harmonic", friction = "stribeck", rock = "moving", contact = "hunt-crossley" }
[analysis.short]
kind = "trajectory"
periods = 2
[analysis.long]
kind = "bifurcation-diagram"
sweep.eta = [0.8]
transient = 10_000_000_000
periods = 2
"""


def test_second_interrupt(tmp_path):
    (tmp_path / "scene.toml").write_text(SCENE)
    (tmp_path / "out.nc").write_bytes(b"the earlier archive")
    command = [sys.executable, "-m", "chaosdrill", "run", "scene.toml", "-o", "out.nc"]
    with subprocess.Popen(command, cwd=tmp_path, stderr=subprocess.PIPE, text=True) as process:
        while not (line := process.stderr.readline()).startswith("long: begins"):
            assert line, "it ended"
        # let it get into the compiled code
        time.sleep(3)
        process.send_signal(signal.SIGINT)
        while "a second Ctrl-C ends at once" not in (line := process.stderr.readline()):
            assert line, "it ended at the first one"
        process.send_signal(signal.SIGINT)
        told = process.communicate(timeout=10)[1]
    assert process.returncode == 130
    assert told.strip() == "interrupted at once"
    assert (tmp_path / "out.nc").read_bytes() == b"the earlier archive"
    assert (tmp_path / "out.nc.parts" / "short" / "result.nc").exists()
