"""One worker, two, a cluster, and ten kills with a resume after each: the same archive, to the bit."""

import random
import signal
import subprocess
import sys
import time

import netCDF4
import pytest

from chaosdrill.archive.read import open_archive
from chaosdrill.sweep.store import kept_points
from chaosdrill.workflow.compare import compare

KILLS = 10
POINTS = 600 + 2 * 20 + 2 * 30 * 20 + 30 * 30

SCENE = """\
[system]
model = "impact-oscillator"
[analysis.spectrum]
kind = "lyapunov-spectrum"
transient = 50
periods = 500
[analysis.diagram]
kind = "bifurcation-diagram"
sweep.omega = { start = 2.4, stop = 2.8, num = 600 }
transient = 20
periods = 32
[analysis.hysteresis]
kind = "bifurcation-diagram"
sweep.omega = { start = 2.6, stop = 2.7, num = 20 }
follow = "both"
transient = 20
periods = 32
[analysis.chart]
kind = "parameter-chart"
sweep.omega = { start = 2.4, stop = 2.8, num = 30 }
sweep.e = { start = 0.5, stop = 0.9, num = 20 }
random = { count = 2, seed = 1, x = [-0.5, 0.2] }
transient = 20
periods = 32
[analysis.basins]
kind = "basins"
grid.x = { start = -1.0, stop = 0.25, num = 30 }
grid.v = { start = -1.0, stop = 1.0, num = 30 }
transient = 20
periods = 32
[analysis.motion]
kind = "trajectory"
periods = 20
samples = 16
"""


def command(folder, *options):
    return [sys.executable, "-m", "chaosdrill", "run", str(folder / "scene.toml"), *map(str, options)]


def run(folder, name, *options):
    """Run the scene to its end and return the archive's path."""
    done = subprocess.run(command(folder, "-o", folder / name, *options), capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr
    assert not (folder / f"{name}.parts").exists()
    return folder / name


def raw(path):
    """Bytes of every variable of a file, nothing decoded."""
    with netCDF4.Dataset(path) as file:
        file.set_auto_mask(False)
        return {
            f"{group}/{name}": variable[...].tobytes()
            if variable.dtype is not str
            else list(map(str, variable[...].ravel()))
            for group, node in file.groups.items()
            for name, variable in node.variables.items()
        }


def assert_same(path, reference):
    assert compare(open_archive(path), open_archive(reference)) == []
    assert raw(path) == raw(reference)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Folder with the scene."""
    path = tmp_path_factory.mktemp("runs")
    (path / "scene.toml").write_text(SCENE)
    return path


@pytest.fixture(scope="module")
def one(folder):
    """Archive of a run with one worker, never interrupted."""
    return run(folder, "one.nc")


def test_two_workers(folder, one):
    assert_same(run(folder, "two.nc", "--workers", 2), one)


def test_two_worker_processes_of_a_cluster(folder, one):
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0") as cluster:
        assert_same(run(folder, "cluster.nc", "--scheduler", cluster.scheduler_address), one)


def test_ten_kills_at_random_moments(folder, one):
    chance = random.Random(20260401)
    parts = folder / "killed.nc.parts"
    kept = []
    # moments count in points, so that a slow machine is killed as far into the work as a fast one
    for moment in sorted(chance.uniform(0, 0.75) * POINTS for _ in range(KILLS)):
        call = command(folder, "-o", folder / "killed.nc", "--resume", "--workers", chance.choice([1, 2]))
        with subprocess.Popen(call, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as process:
            while process.poll() is None and points_in(parts) < moment:
                time.sleep(0.001)
            time.sleep(chance.uniform(0, 0.03))
            assert process.poll() is None, process.stderr.read()
            process.send_signal(signal.SIGKILL)
        assert not (folder / "killed.nc").exists()
        kept.append(points_in(parts))
    assert kept == sorted(kept)
    assert 0.5 * POINTS < kept[-1] < POINTS
    assert_same(run(folder, "killed.nc", "--resume"), one)


def points_in(parts):
    """Finished points in a folder that may not be there yet."""
    return sum(kept_points(group)[0] for group in parts.glob("*"))
