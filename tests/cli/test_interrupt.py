"""Ctrl-C ends a long run soon, with exit code 130, and leaves what was there."""

import re
import signal
import subprocess
import sys
import time

import pytest

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
FINISHED = re.compile(r" [1-9]\d*/100000 ")


@pytest.mark.parametrize(("analysis", "workers"), [(SPECTRUM, 1), (DIAGRAM, 1), (DIAGRAM, 2)])
def test_interrupt(tmp_path, analysis, workers):
    (tmp_path / "scene.toml").write_text(LONG + analysis)
    (tmp_path / "out.nc").write_bytes(b"the earlier archive")
    command = [sys.executable, "-m", "chaosdrill", "run", "scene.toml", "-o", "out.nc", "--workers", str(workers)]
    with subprocess.Popen(command, cwd=tmp_path, stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr.readline().startswith("long: begins")
        # let it get into the compiled code, or finish something
        if analysis == DIAGRAM:
            assert any(FINISHED.search(line) for line in process.stderr)
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
