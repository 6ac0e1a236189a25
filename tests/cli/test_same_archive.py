"""One worker, two, a cluster, and ten kills with a resume after each: the same archive, to the bit."""

import random
import signal
import subprocess
import sys
import time

import netCDF4
import pytest

from chaosdrill.archive.compare import compare
from chaosdrill.archive.read import open_archive

KILLS = 10

SCENE = """\
[system]
model = "impact-oscillator"
[analysis.spectrum]
kind = "lyapunov-spectrum"
transient = 50
periods = 500
[analysis.diagram]
kind = "bifurcation-diagram"
sweep.omega = { start = 2.4, stop = 2.8, num = 1500 }
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
    done = subprocess.run(command(folder, "-o", folder / name, *options), capture_output=True, text=True, timeout=200)
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
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        assert_same(run(folder, "cluster.nc", "--scheduler", cluster.scheduler_address), one)


def test_ten_kills_at_random_moments(folder, one):
    chance = random.Random(20260401)
    journal = folder / "killed.nc.parts" / "diagram" / "journal.txt"
    lines = []
    for _ in range(KILLS):
        workers = chance.choice([1, 2])
        call = command(folder, "-o", folder / "killed.nc", "--resume", "--workers", workers)
        # moments count in chunks, so that a slow machine is killed as far into the work as a fast one
        before = count_lines(journal)
        more, pause = chance.randrange(6), chance.uniform(0, 0.03)
        with subprocess.Popen(call, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as process:
            while process.poll() is None and count_lines(journal) < before + more:
                time.sleep(0.001)
            time.sleep(pause if more else chance.uniform(0, 1.5))
            assert process.poll() is None, process.stderr.read()
            process.send_signal(signal.SIGKILL)
        assert not (folder / "killed.nc").exists()
        lines.append(count_lines(journal))
    assert lines == sorted(lines)
    assert lines[-1] > 10
    assert_same(run(folder, "killed.nc", "--resume"), one)


def count_lines(path):
    """Lines of a file that may not be there yet."""
    try:
        return path.read_bytes().count(b"\n")
    except FileNotFoundError:
        return 0
