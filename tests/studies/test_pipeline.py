"""The pipeline that Make runs: killed and called again it makes what is missing, once, and one report."""

import csv
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from chaosdrill.archive import open as open_archive
from chaosdrill.scene import load_scene

PIPELINE = Path(__file__).parents[2] / "studies" / "pipeline"
FREQUENCIES = ("95", "100")

pytestmark = pytest.mark.skipif(shutil.which("make") is None, reason="make is not installed")


def make(output, *more):
    # as if called by hand, whatever calls the tests
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("MAKE", "MFLAGS"))}
    command = ["make", "-C", PIPELINE, f"PYTHON={sys.executable}", f"OUT={output}", f"OMEGA={' '.join(FREQUENCIES)}"]
    streams = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True}
    return subprocess.Popen([*command, *more], env=environment, start_new_session=True, **streams)


@pytest.fixture(scope="module")
def killed(tmp_path_factory):
    """Folder of a pipeline that was killed after its first archive and called again: (folder, its first write, log)."""
    output = tmp_path_factory.mktemp("pipeline")
    first = output / "omega_95.nc"
    with make(output) as process:
        while not (first.exists() and (output / "omega_100.nc.parts").exists()):
            assert process.poll() is None, process.stdout.read()
            time.sleep(0.01)
        os.killpg(process.pid, signal.SIGKILL)
        # until the last of those killed has ended, which holds its folder of parts
        process.stdout.read()
    assert not (output / "omega_100.nc").exists()
    written = first.stat().st_mtime_ns
    with make(output) as process:
        log = process.communicate()[0]
    assert process.returncode == 0, log
    return output, written, log


def test_what_was_there_is_not_made_again(killed):
    output, written, log = killed
    assert (output / "omega_95.nc").stat().st_mtime_ns == written
    assert log.count(" run drill.toml") == len(FREQUENCIES) - 1
    assert not list(output.glob("*.parts"))


def test_one_report_of_all(killed):
    output = killed[0]
    with (output / "report.csv").open(newline="") as file:
        head, *rows = csv.reader(file)
    assert [row[0] for row in rows] == list(FREQUENCIES)
    assert [row[1:3] for row in rows] == [["periodic", "2"], ["periodic", "1"]]
    spectrum = open_archive(output / "omega_100.nc")["spectrum"]
    assert float(rows[1][head.index("progression m/h")]) == pytest.approx(
        float(spectrum["progression_rate"]) * 2e-3 / (250 / 4e6) ** 0.5 * 3600, rel=1e-3
    )
    assert len((output / "report.md").read_text().splitlines()) == len(FREQUENCIES) + 2


def test_every_archive_has_its_own_frequency(killed):
    for name in FREQUENCIES:
        tree = open_archive(killed[0] / f"omega_{name}.nc")
        assert float(tree["si_omega"]) == float(name)
        assert f'omega = "{name} rad/s"' in tree.attrs["scene"]
        printed = json.loads((killed[0] / f"omega_{name}.json").read_text())
        assert printed["scene_sha256"] == tree.attrs["scene_sha256"]


def test_nothing_is_left_to_do(killed):
    with make(killed[0], "--question") as process:
        process.communicate()
    assert process.returncode == 0


def test_ten_scenes():
    text = (PIPELINE / "Makefile").read_text()
    (line,) = (line for line in text.splitlines() if line.startswith("OMEGA :="))
    values = line.split()[2:]
    assert len(set(values)) == 10
    for value in values:
        scene = load_scene(PIPELINE / "drill.toml", {"system.si.omega": f"{value} rad/s"})
        assert scene.parameters["eta"] == pytest.approx(float(value) * (250 / 4e6) ** 0.5, rel=1e-12)
