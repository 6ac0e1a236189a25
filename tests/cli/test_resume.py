"""An unfinished run is resumed by --resume, to the same archive, and by nothing else."""

import errno
import json
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import time
from contextlib import redirect_stderr
from dataclasses import replace
from io import StringIO
from pathlib import Path

import netCDF4
import pytest
import xarray as xr

from chaosdrill.analysis.grids.points import PointTask
from chaosdrill.archive.digest import LENGTH, append_checksum
from chaosdrill.archive.read import open_archive
from chaosdrill.cli import main
from chaosdrill.files import draft_of
from chaosdrill.sweep.store import kept_points
from chaosdrill.sweep.tuning import TUNING
from chaosdrill.workflow.compare import compare

# An unfinished run is gone on with by --resume, and by nothing else; a changed scene is refused with what changed.


SCENE = """\
title = "Impacts"
[system]
model = "impact-oscillator"
[analysis.spectrum]
kind = "lyapunov-spectrum"
transient = 10
periods = 50
[analysis.diagram]
kind = "bifurcation-diagram"
sweep.omega = { start = 2.4, stop = 2.8, num = 300 }
transient = 5
periods = 8
"""


@pytest.fixture
def scene(tmp_path):
    """File of a scene with a spectrum and a diagram."""
    path = tmp_path / "scene.toml"
    path.write_text(SCENE)
    return path


@pytest.fixture(scope="module")
def once(tmp_path_factory):
    """Folder of a run that was not interrupted."""
    folder = tmp_path_factory.mktemp("once")
    (folder / "scene.toml").write_text(SCENE)
    assert main(["run", str(folder / "scene.toml"), "-o", str(folder / "whole.nc")]) == 0
    return folder


@pytest.fixture(scope="module")
def whole(once):
    """The archive of an uninterrupted run."""
    return open_archive(once / "whole.nc")


def stop(patch, point, fault):
    """Make the diagram end with an error from some point on."""
    run = PointTask.run

    def stopping(self, first, count):
        if first + count > point:
            raise fault
        return run(self, first, count)

    patch.setattr(PointTask, "run", stopping)


@pytest.fixture(scope="module")
def interrupted(tmp_path_factory):
    """Folder of a run that was interrupted in its diagram."""
    folder = tmp_path_factory.mktemp("interrupted")
    (folder / "scene.toml").write_text(SCENE)
    with pytest.MonkeyPatch.context() as patch, redirect_stderr(StringIO()) as told:
        stop(patch, 100, KeyboardInterrupt)
        assert main(["run", str(folder / "scene.toml"), "-o", str(folder / "out.nc")]) == 130
    assert "finished parts are kept in" in told.getvalue()
    assert not (folder / "out.nc").exists()
    return folder


@pytest.fixture
def unfinished(interrupted, tmp_path):
    """Parts of that run, to be changed."""
    return shutil.copytree(interrupted / "out.nc.parts", tmp_path / "out.nc.parts")


def kept_in(folder):
    """Points in the chunks of the interrupted diagram: their number depends on the time that the first ones took."""
    return sum(int(path.stem.partition("-")[2]) for path in (folder / "diagram").glob("*.chunk"))


def contents(folder):
    """All files in a folder and in those below it."""
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_nothing_is_left_beside_the_archive(once):
    assert sorted(path.name for path in once.iterdir()) == ["scene.toml", "whole.nc"]


def test_resume_writes_the_archive_of_an_uninterrupted_run(call, scene, tmp_path, whole, unfinished, monkeypatch):
    monkeypatch.setattr("chaosdrill.analysis.lyapunov_spectrum", lambda *_, **__: pytest.fail("it ran again"))
    kept = kept_in(unfinished)
    assert 0 < kept <= 100
    answer = call("run", scene, "-o", tmp_path / "out.nc", "--resume", "--workers", "2")
    assert answer.code == 0
    assert "spectrum: found finished\n" in answer.err
    assert f"diagram: found {kept} of 300 points\n" in answer.err
    assert compare(open_archive(tmp_path / "out.nc"), whole) == []
    assert not unfinished.exists()


def test_without_resume_nothing_is_touched(call, scene, tmp_path, unfinished):
    before = contents(unfinished)
    answer = call("run", scene, "-o", tmp_path / "out.nc")
    assert (answer.code, answer.out) == (2, "")
    assert f"holds an unfinished run (diagram {kept_in(unfinished)} of 300 points, spectrum finished)" in answer.err
    assert "continue it with --resume, or remove the folder to start over" in answer.err
    assert contents(unfinished) == before


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("num = 300", "num = 301", "analysis.diagram.sweep.omega.num: 300 before, 301 now"),
        ("transient = 5\n", "transient = 6\n", "analysis.diagram.transient: 5 before, 6 now"),
        ("periods = 50", "periods = 51", "analysis.spectrum.periods: 50 before, 51 now"),
        ("[analysis.spectrum]", "[analysis.other]", "analysis.spectrum: {"),
        ("impact-oscillator", "den-hartog", 'system.model: "impact-oscillator" before, "den-hartog" now'),
        (
            "[analysis.s",
            "[system.parameters]\nzeta = 0.1\n[analysis.s",
            "system.parameters.zeta: absent before, 0.1 now",
        ),
        (
            "[analysis.s",
            "[numerics]\ntolerance = 1e-10\n[analysis.s",
            "numerics.tolerance: absent before, 1e-10 now",
        ),
    ],
)
def test_a_changed_scene_is_refused_with_what_changed(call, scene, tmp_path, unfinished, old, new, told):
    scene.write_text(SCENE.replace(old, new, 1))
    before = contents(unfinished)
    answer = call("run", scene, "-o", tmp_path / "out.nc", "--resume")
    assert (answer.code, answer.out) == (2, "")
    assert "of another scene. What has changed:" in answer.err
    assert told in answer.err
    assert contents(unfinished) == before


def test_other_versions_are_refused(call, scene, tmp_path, unfinished, monkeypatch):
    path = unfinished / "_scene.json"
    content = json.loads(path.read_text())
    content["versions"]["numba"] = "0.1"
    path.write_text(json.dumps(content))
    answer = call("run", scene, "-o", tmp_path / "out.nc", "--resume")
    assert answer.code == 2
    assert 'versions.numba: "0.1" before' in answer.err


def test_a_title_and_a_further_analysis_change_no_number(call, scene, tmp_path, unfinished):
    more = '[analysis.more]\nkind = "trajectory"\nperiods = 2\n'
    scene.write_text("# again\n" + SCENE.replace("Impacts", "Knocks") + more)
    answer = call("run", scene, "-o", tmp_path / "out.nc", "--resume")
    assert answer.code == 0
    tree = open_archive(tmp_path / "out.nc")
    assert tree.attrs["title"] == "Knocks"
    assert set(tree.children) == {"spectrum", "diagram", "more"}


def test_resume_without_parts_begins(call, scene, tmp_path, whole):
    assert call("run", scene, "-o", tmp_path / "out.nc", "--resume").code == 0
    assert compare(open_archive(tmp_path / "out.nc"), whole) == []


def test_a_damaged_result_is_computed_again(call, scene, tmp_path, whole, unfinished):
    path = unfinished / "spectrum" / "result.nc"
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 1
    path.write_bytes(data)
    with pytest.warns(UserWarning, match=r"result.nc is damaged, or its checksum; spectrum is recomputed"):
        answer = call("run", scene, "-o", tmp_path / "out.nc", "--resume")
    assert answer.code == 0
    # what lies there is told before it is read, and not called usable
    assert "spectrum: found finished\n" in answer.err
    assert compare(open_archive(tmp_path / "out.nc"), whole) == []


@pytest.mark.parametrize("code", [99, -1])
def test_a_result_with_a_code_that_no_outcome_has_is_computed_again(call, scene, tmp_path, whole, unfinished, code):
    path = unfinished / "spectrum" / "result.nc"
    path.write_bytes(path.read_bytes()[:-LENGTH])
    with netCDF4.Dataset(path, "a") as file:
        file["outcome"][...] = code
    append_checksum(path)
    with pytest.warns(UserWarning, match=r"result.nc holds what no lyapunov-spectrum gives; spectrum is recomputed"):
        assert call("run", scene, "-o", tmp_path / "out.nc", "--resume").code == 0
    assert compare(open_archive(tmp_path / "out.nc"), whole) == []


def test_a_folder_in_the_parts_whose_name_makes_lines_is_passed_over(call, scene, tmp_path, whole, unfinished):
    (unfinished / "a\nspectrum: damaged").mkdir()
    (unfinished / "a\nspectrum: damaged" / "result.nc").touch()
    answer = call("run", scene, "-o", tmp_path / "out.nc", "--resume")
    assert (answer.code, "damaged" in answer.err) == (0, False)
    assert compare(open_archive(tmp_path / "out.nc"), whole) == []


def test_a_folder_of_something_else_is_left_alone(call, scene, tmp_path):
    folder = tmp_path / "out.nc.parts"
    folder.mkdir()
    (folder / "precious").touch()
    answer = call("run", scene, "-o", tmp_path / "out.nc", "--resume")
    assert answer.code == 1
    assert "move it away or remove it" in answer.err
    assert (folder / "precious").exists()


@pytest.mark.parametrize("left", [(), ("_lock",), ("_lock", "draft"), ("_lock", "draft of another machine")])
def test_a_kill_before_anything_was_kept_is_gone_on_from(call, scene, tmp_path, left):
    folder = tmp_path / "out.nc.parts"
    folder.mkdir()
    draft = draft_of(folder / "_scene.json").name
    machine = draft.split(".")[-2].partition("-")[0]
    names = {"draft": draft, "draft of another machine": draft.replace(machine, "0" * 12)}
    for name in left:
        (folder / names.get(name, name)).write_text("")
    assert call("run", scene, "-o", tmp_path / "out.nc", "--resume").code == 0
    assert {path.name for path in tmp_path.iterdir()} == {"out.nc", "scene.toml"}


def test_two_runs_do_not_use_one_folder(call, scene, tmp_path, unfinished):
    import fcntl

    with open(unfinished / "_lock") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        answer = call("run", scene, "-o", tmp_path / "out.nc", "--resume")
    assert answer.code == 1
    assert "another run is using this folder" in answer.err


def test_parts_of_which_a_kill_left_some_after_the_archive_are_forgotten(call, scene, tmp_path, unfinished):
    # a number that no process can have
    away = re.sub(r"-\d+-(\d*)-", r"-99999999-\1-", draft_of(unfinished).name)
    unfinished.rename(unfinished.with_name(away))
    assert call("run", scene, "-o", tmp_path / "out.nc").code == 0
    assert {path.name for path in tmp_path.iterdir()} == {"out.nc", "scene.toml"}


def test_a_full_disk_at_the_end_loses_nothing(call, scene, tmp_path, whole, monkeypatch):
    def full(*_, **__):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    # the spectrum has been kept by then
    monkeypatch.setattr(xr.DataTree, "to_netcdf", full)
    answer = call("run", scene, "-o", tmp_path / "out.nc")
    monkeypatch.undo()
    assert answer.code == 1
    assert os.strerror(errno.ENOSPC) in answer.err
    assert "continue with --resume" in answer.err
    answer = call("run", scene, "-o", tmp_path / "out.nc", "--resume")
    assert answer.code == 0
    assert "diagram: found finished" in answer.err
    assert compare(open_archive(tmp_path / "out.nc"), whole) == []


def test_a_full_disk_on_the_way(call, scene, tmp_path, monkeypatch):
    plain, left = Path.write_bytes, [2]

    def full(*arguments):
        left[0] -= 1
        if left[0] < 0:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return plain(*arguments)

    monkeypatch.setattr(Path, "write_bytes", full)
    answer = call("run", scene, "-o", tmp_path / "out.nc")
    assert answer.code == 1
    assert "out.nc.parts/diagram: cannot keep a finished chunk: No space left on device" in answer.err
    assert "continue with --resume" in answer.err


def test_the_output_folder_is_removed_while_running(call, scene, tmp_path, monkeypatch):
    run, folder = PointTask.run, tmp_path / "results"
    folder.mkdir()

    def removing(self, first, count):
        if first > 20:
            shutil.rmtree(folder, ignore_errors=True)
        return run(self, first, count)

    monkeypatch.setattr(PointTask, "run", removing)
    answer = call("run", scene, "-o", folder / "out.nc")
    assert answer.code == 1
    assert "removed or renamed during the run" in answer.err
    assert not folder.exists()


def test_clocks_that_jump_and_times_of_files_do_not_matter(call, scene, tmp_path, whole, monkeypatch):
    backwards = iter(range(10**7, 0, -1))
    monkeypatch.setattr(time, "time", lambda: 60.0 * next(backwards))
    monkeypatch.setattr(time, "time_ns", lambda: 60_000_000_000 * next(backwards))
    stop(monkeypatch, 100, KeyboardInterrupt)
    assert call("run", scene, "-o", tmp_path / "out.nc").code == 130
    monkeypatch.undo()
    monkeypatch.setattr(time, "time", lambda: 0.0)
    for path in (tmp_path / "out.nc.parts").rglob("*"):
        os.utime(path, (4e9, 4e9))
    kept = kept_in(tmp_path / "out.nc.parts")
    answer = call("run", scene, "-o", tmp_path / "out.nc", "--resume")
    assert answer.code == 0
    assert f"diagram: found {kept} of 300 points\n" in answer.err
    assert compare(open_archive(tmp_path / "out.nc"), whole) == []


def test_workers_and_scheduler_exclude_each_other(call, scene, tmp_path):
    answer = call("run", scene, "-o", tmp_path / "out.nc", "--workers", "2", "--scheduler", "tcp://127.0.0.1:9")
    assert answer.code == 2
    assert "give only one of the two" in answer.err
    assert not (tmp_path / "out.nc.parts").exists()


def test_a_scheduler_that_does_not_answer_is_told_before_the_run(call, scene, tmp_path, monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setattr("chaosdrill.sweep.schedule.TUNING", replace(TUNING, answer_s=0.3))
    monkeypatch.setattr("chaosdrill.scene.checks.Asked.run", lambda *_, **__: pytest.fail("it ran"))
    answer = call("run", scene, "-o", tmp_path / "out.nc", "--scheduler", "tcp://127.0.0.1:9")
    assert answer.code == 2
    assert "no Dask scheduler answers" in answer.err
    assert not (tmp_path / "out.nc.parts").exists()


# One worker, two, a cluster, and ten kills with a resume after each: the same archive, to the bit.


KILLS = 10

POINTS = 400 + 2 * 20 + 2 * 20 * 10 + 20 * 20

SAME_SCENE = """\
[system]
model = "impact-oscillator"
[analysis.spectrum]
kind = "lyapunov-spectrum"
transient = 50
periods = 500
[analysis.diagram]
kind = "bifurcation-diagram"
sweep.omega = { start = 2.4, stop = 2.8, num = 400 }
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
sweep.omega = { start = 2.4, stop = 2.8, num = 20 }
sweep.e = { start = 0.5, stop = 0.9, num = 10 }
random = { count = 2, seed = 1, x = [-0.5, 0.2] }
transient = 20
periods = 32
[analysis.basins]
kind = "basins"
grid.x = { start = -1.0, stop = 0.25, num = 20 }
grid.v = { start = -1.0, stop = 1.0, num = 20 }
transient = 20
periods = 32
[analysis.motion]
kind = "trajectory"
periods = 20
samples = 16
"""


def run(folder, name, *options):
    """Run the scene to its end and return the archive's path."""
    assert main(list(map(str, ["run", folder / "scene.toml", "-o", folder / name, *options]))) == 0
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
    (path / "scene.toml").write_text(SAME_SCENE)
    return path


@pytest.fixture(scope="module")
def one(folder):
    """Archive of a run with one worker, never interrupted."""
    return run(folder, "one.nc")


def test_two_workers_write_the_archive_of_one(folder, one):
    assert_same(run(folder, "two.nc", "--workers", 2), one)


def test_two_processes_of_a_cluster_write_the_archive_of_one(folder, one):
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0") as cluster:
        assert_same(run(folder, "cluster.nc", "--scheduler", cluster.scheduler_address), one)


# runs a command, and then each that it is told in a process of its own, which imports and compiles nothing again
FORKS = """
import json, os, signal, sys
from chaosdrill.cli import main
sys.stdout = open(os.devnull, "w")
assert main(json.loads(sys.stdin.readline())) == 0
signal.signal(signal.SIGCHLD, signal.SIG_IGN)
for line in sys.stdin:
    if process := os.fork():
        print(process, file=sys.__stdout__, flush=True)
    else:
        os._exit(main(json.loads(line)))
"""


@pytest.fixture
def begin(folder):
    """Function that begins a run of the scene in a process of its own, of which it gives the number."""
    (folder / "short.toml").write_text(SAME_SCENE[: SAME_SCENE.index("[analysis.hysteresis]")].replace("600", "2"))
    streams = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL, "text": True}
    with subprocess.Popen([sys.executable, "-c", FORKS], cwd=folder, **streams) as process:

        def told(*arguments):
            process.stdin.write(json.dumps(["run", *arguments]) + "\n")
            process.stdin.flush()

        def begun(*options):
            told("scene.toml", *options)
            return int(process.stdout.readline())

        told("short.toml", "-o", "short.nc")
        yield begun
        process.stdin.close()


def lives(process):
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    return True


def test_ten_kills_at_random_moments(folder, one, begin):
    chance = random.Random(20260401)
    parts = folder / "killed.nc.parts"
    kept = []
    # moments count in points, so that a slow machine is killed as far into the work as a fast one
    for moment in sorted(chance.uniform(0, 0.75) * POINTS for _ in range(KILLS)):
        process = begin("-o", "killed.nc", "--resume", "--workers", str(chance.choice([1, 2])))
        while lives(process) and points_in(parts) < moment:
            time.sleep(0.005)
        time.sleep(chance.uniform(0, 0.03))
        os.kill(process, signal.SIGKILL)
        while lives(process):
            time.sleep(0.005)
        assert not (folder / "killed.nc").exists()
        kept.append(points_in(parts))
    assert kept == sorted(kept)
    assert 0.5 * POINTS < kept[-1] < POINTS
    assert_same(run(folder, "killed.nc", "--resume"), one)


def points_in(parts):
    """Finished points in a folder that may not be there yet."""
    return sum(kept_points(group)[0] for group in parts.glob("*"))
