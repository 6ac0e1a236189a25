"""From the command to the first result: a new system with empty caches, and again with warm ones."""

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

SCENE = """\
title = "First result"
[system]
model = "percussive-drill"
[system.effects]
drive = "harmonic"
friction = "stribeck"
rock = "moving"
contact = "hunt-crossley"
[analysis.section]
kind = "poincare-section"
transient = 100
periods = 64
"""


def start_up(times: int = 2) -> list[float]:
    """Run ``chaosdrill run`` on a small scene with new cache folders, a number of times; return the seconds of each."""
    with tempfile.TemporaryDirectory() as folder:
        scene = Path(folder) / "scene.toml"
        scene.write_text(SCENE, encoding="utf-8")
        caches = {"XDG_CACHE_HOME": folder, "NUMBA_CACHE_DIR": str(Path(folder) / "numba"), "MPLCONFIGDIR": folder}
        command = [sys.executable, "-m", "chaosdrill", "run", str(scene), "-o", str(Path(folder) / "out.nc")]
        return [_seconds(command, {**os.environ, **caches}) for _ in range(times)]


def _seconds(command: list[str], environment: dict[str, str]) -> float:
    begin = time.perf_counter()
    subprocess.run(command, env=environment, check=True, capture_output=True)
    return time.perf_counter() - begin


def table(seconds: list[float]) -> str:
    """Return the times as Markdown."""
    lines = ["| caches | seconds to the first result |", "| --- | --- |", f"| empty | {seconds[0]:.1f} |"]
    return "\n".join([*lines, f"| warm | {min(seconds[1:]):.1f} |"]) + "\n"
