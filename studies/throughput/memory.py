"""How much memory a chart takes, up to a million points.

The charts here are short in time, so that a million points end within minutes. A longer record takes no more memory:
growth is kept by blocks, of which there are 32 from 32 periods on, and section points in windows of fixed length. Each
chart is a command of its own, ``chaosdrill run``, so that imports, kernels and the writing of the archive count.
"""

import os
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from own import Chart

SIDES = (10, 100, 316, 1000)
WORKERS = (1, 2)
COLUMNS = ("points", "workers", "peak_mb", "archive_mb", "processor_s")

Row = dict[str, Any]


def measure(say: Callable[[str], None]) -> list[Row]:
    """Rows with the columns ``COLUMNS``."""
    rows = []
    for side in SIDES:
        for workers in WORKERS:
            say(f"{side} x {side} points, {workers} workers")
            rows.append(_command(Chart((0.55, 0.9), side, 0, 32, 1e-4, max_extension=0), workers))
    return rows


def _command(chart: Chart, workers: int) -> Row:
    with tempfile.TemporaryDirectory() as folder:
        scene, archive = Path(folder) / "scene.toml", Path(folder) / "out.nc"
        scene.write_text(chart.scene(), encoding="utf-8")
        words = [sys.executable, "-m", "chaosdrill", "run", str(scene), "-o", str(archive), "--workers", str(workers)]
        process = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode:
            raise RuntimeError(f"{' '.join(words)} ended with the code {process.returncode}")
        return {
            "points": chart.points,
            "workers": workers,
            "peak_mb": used.ru_maxrss * (1024 if sys.platform != "darwin" else 1) / 1e6,
            "archive_mb": archive.stat().st_size / 1e6,
            "processor_s": used.ru_utime + used.ru_stime,
        }


def table(rows: list[Row]) -> str:
    """Markdown: peak memory by number of points and of workers, size of the archive."""
    teams = list(dict.fromkeys(row["workers"] for row in rows))
    head = ["points", *(f"peak with {workers} worker{'s' * (workers != '1')}, MB" for workers in teams), "archive, MB"]
    lines = [head, ["---"] * len(head)]
    for points in dict.fromkeys(row["points"] for row in rows):
        here = {row["workers"]: row for row in rows if row["points"] == points}
        peaks = (f"{float(here[workers]['peak_mb']):.0f}" for workers in teams)
        lines.append([points, *peaks, f"{float(here[teams[0]]['archive_mb']):.2g}"])
    return "".join("| " + " | ".join(line) + " |\n" for line in lines)
