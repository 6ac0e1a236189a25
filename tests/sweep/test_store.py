"""What a kill leaves behind or a disk damages is noticed and computed again; the rest is not."""

import errno
import os
import shutil
import subprocess
import sys
import time
import warnings
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest
import xarray as xr
from support.logistic_task import Logistic

from chaosdrill.errors import ArchiveError, SettingsError
from chaosdrill.sweep import execute
from chaosdrill.sweep.parts import Parts
from chaosdrill.sweep.store import MANIFEST, Store, kept_points

# Whatever a kill leaves behind or a disk damages is noticed and computed again; the rest is not.


TASK = Logistic(units=60, iterations=3)

CHUNKS = ((0, 7), (7, 20), (40, 11))

COUNTS = {f"{first}-{count}.chunk": count for first, count in CHUNKS}

NAMES = [*COUNTS]


@pytest.fixture
def folder(tmp_path):
    """A store with three finished chunks: units 0 to 26 and 40 to 50."""
    store = Store(tmp_path / "parts", TASK)
    for first, count in CHUNKS:
        store.put(first, count, TASK.run(first, count))
    return tmp_path / "parts"


def files(folder):
    """Content of all files in a folder, by name."""
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def resumed(folder, task=TASK, damaged=None):
    """Results, and the number of units that were there before; a warning says how many are damaged, if any are."""
    told = []
    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always")
        found = execute(task, store=folder, progress=lambda *seen: told.append(seen))
    texts = [str(one.message) for one in heard]
    if damaged is not None:
        lost = "finished points are damaged, or the digests beside them; they are recomputed"
        assert texts == ([f"{folder}: {damaged} {lost}"] if damaged else [])
    assert told[-1][0] == task.units
    return found, told[0][0]


def test_finished_chunks_are_taken_over(folder, whole, same):
    found, before = resumed(folder, damaged=0)
    assert before == 38
    assert same(found, whole(TASK))
    assert kept_points(folder) == (60, 60)


def test_other_workers_and_chunks_go_on(folder, whole, same):
    found = execute(replace(TASK, pause=0.001), workers=3, store=folder)
    assert same(found, whole(TASK))


@pytest.mark.parametrize(("name", "count"), COUNTS.items())
def test_a_chunk_cut_anywhere_is_computed_again_and_no_other(folder, tmp_path, whole, same, name, count):
    expected, length = whole(TASK), (folder / name).stat().st_size
    for cut in {0, *range(1, length, 61), length - 1}:
        copy = shutil.copytree(folder, tmp_path / f"{cut}")
        os.truncate(copy / name, cut)
        found, before = resumed(copy, damaged=count)
        assert before == 38 - count
        assert same(found, expected)
        assert resumed(copy)[1] == 60


@pytest.mark.parametrize(("name", "count"), COUNTS.items())
def test_a_damaged_byte_costs_its_chunk_only(folder, tmp_path, whole, same, name, count):
    expected, data = whole(TASK), (folder / name).read_bytes()
    for where in (*range(0, 32, 5), *range(32, len(data), 37)):
        copy = shutil.copytree(folder, tmp_path / f"{where}")
        (copy / name).write_bytes(bytes([*data[:where], data[where] ^ 0x10, *data[where + 1 :]]))
        found, before = resumed(copy, damaged=count)
        assert before == 38 - count
        assert same(found, expected)


def test_a_false_digest_is_told_once(folder, whole, same):
    one, other = ((folder / name).read_bytes() for name in NAMES[:2])
    (folder / NAMES[0]).write_bytes(other[:32] + one[32:])
    (folder / NAMES[1]).write_bytes(bytes(32) + other[32:])
    found, before = resumed(folder, damaged=27)
    assert before == 38 - 27
    assert same(found, whole(TASK))
    # what is false may still be there, beside what was computed again
    assert resumed(folder, damaged=0)[1] == TASK.units


def test_results_under_the_name_of_other_units_are_computed_again(folder, whole, same):
    (folder / NAMES[0]).rename(folder / "27-7.chunk")
    found, before = resumed(folder, damaged=7)
    assert before == 38 - 7
    assert same(found, whole(TASK))


def test_names_that_are_none_of_a_chunk_are_passed_over(folder, whole, same):
    for name in (
        "00-7.chunk",
        "27-0.chunk",
        "-1-7.chunk",
        "27-7.chunk.bak",
        "x.chunk",
        "60-1.chunk",
        "9" * 30 + "-1.chunk",
    ):
        shutil.copy(folder / NAMES[0], folder / name)
    found, before = resumed(folder, damaged=0)
    assert before == 38
    assert same(found, whole(TASK))


def test_a_chunk_that_is_larger_than_any_of_its_own_is_not_read(tmp_path, monkeypatch):
    task = Logistic(units=100_000, iterations=40)
    Store(tmp_path, task)
    with (tmp_path / "0-100000.chunk").open("wb") as file:
        file.truncate(32 + 100_000 * 321)
    monkeypatch.setattr("chaosdrill.sweep.store.open_ordinary", lambda *_: pytest.fail("it was read"))
    with pytest.warns(UserWarning, match="100000 finished points are damaged"):
        assert Store(tmp_path, task).finished == []


def test_drafts_that_a_kill_has_left_are_removed(folder, whole, same):
    (folder / ".3-4.chunk.0123456789ab.0123456789ab.part").write_bytes(b"half")
    assert same(resumed(folder)[0], whole(TASK))
    assert not list(folder.glob(".*"))


def test_other_work_is_refused_with_what_differs(folder):
    before = files(folder)
    with pytest.raises(SettingsError) as caught:
        execute(replace(TASK, units=80), store=folder)
    assert "units: 60 before, 80 now" in str(caught.value)
    assert "remove the folder to start over" in str(caught.value)
    assert files(folder) == before


def test_a_store_in_which_nothing_has_finished_takes_other_work(tmp_path, whole, same):
    Store(tmp_path, TASK)
    other = Logistic(units=20, iterations=5)
    assert same(resumed(tmp_path, other)[0], whole(other))


def test_a_damaged_manifest_is_refused(folder):
    (folder / MANIFEST).write_text('{"format": 1')
    with pytest.raises(ArchiveError, match="missing or damaged"):
        execute(TASK, store=folder)


def test_full_disk_before_the_work(tmp_path, monkeypatch):
    monkeypatch.setattr(shutil, "disk_usage", lambda _: SimpleNamespace(free=2000))
    with pytest.raises(ArchiveError, match=r"cannot keep 0.003 MB of results: No space left on device$"):
        execute(TASK, store=tmp_path / "parts")


@pytest.mark.parametrize(("place", "call"), [(Path, "write_bytes"), (os, "fsync"), (os, "replace")])
def test_full_disk_during_the_work(folder, whole, same, monkeypatch, place, call):
    plain, left = getattr(place, call), [1]

    def full(*arguments):
        left[0] -= 1
        if left[0] >= 0:
            return plain(*arguments)
        if call == "write_bytes":
            plain(arguments[0], arguments[1][:100])
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(place, call, full)
    with pytest.raises(ArchiveError, match=r"cannot keep a finished chunk: No space left .* chunks are kept"):
        execute(TASK, store=folder)
    monkeypatch.undo()
    assert not list(folder.glob(".*"))
    found, before = resumed(folder, damaged=0)
    assert before > 38
    assert same(found, whole(TASK))


def test_full_disk_when_results_are_put_together(folder, whole, same, monkeypatch):
    def full(**_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr("chaosdrill.sweep.store.TemporaryFile", full)
    with pytest.raises(
        ArchiveError, match=r"cannot put the results together: No space left .* finished chunks are kept"
    ):
        execute(TASK, store=folder)
    monkeypatch.undo()
    found, before = resumed(folder, damaged=0)
    assert before == 60
    assert same(found, whole(TASK))


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("/proc/none", "cannot be made"),
        ("/dev/null", "is not a folder"),
        ("/dev/null/below", "cannot be made"),
        ("\ud800", "characters that file names cannot have"),
        ("a" * 300, "cannot be made"),
    ],
)
def test_a_folder_that_cannot_be(name, told):
    with pytest.raises(ArchiveError, match=told) as caught:
        Store(name, TASK)
    assert "during the run" not in str(caught.value)
    assert "name " in str(caught.value)


@pytest.mark.parametrize("remove", [shutil.rmtree, lambda folder: folder.rename(folder.with_name("elsewhere"))])
def test_the_folder_is_removed_during_the_work(folder, remove):
    begun = []

    def progress(done, total, outcomes):
        if not begun:
            remove(folder)
        begun.append(done)

    with pytest.raises(ArchiveError, match="removed or renamed"):
        execute(replace(TASK, pause=0.001), store=folder, progress=progress)
    assert len(begun) == 1


def test_a_folder_that_comes_back_is_gone_on_with(folder, whole, same):
    away = folder.with_name("away")
    with pytest.raises(ArchiveError):
        execute(TASK, store=folder, progress=lambda *_: folder.rename(away))
    away.rename(folder)
    found, before = resumed(folder)
    assert before == 38
    assert same(found, whole(TASK))


def test_clocks_and_times_of_files_do_not_matter(folder, whole, same, monkeypatch):
    for path in folder.iterdir():
        os.utime(path, (4e9, 4e9))
    hours = iter(range(10**6, 0, -1))
    monkeypatch.setattr(time, "time", lambda: 3600.0 * next(hours))
    monkeypatch.setattr(time, "time_ns", lambda: 3_600_000_000_000 * next(hours))
    found, before = resumed(folder)
    assert before == 38
    assert same(found, whole(TASK))


@pytest.mark.parametrize("kept", [True, False])
def test_results_that_would_fill_a_disk_are_refused_before_anything_is_reserved(tmp_path, kept):
    with pytest.raises(SettingsError, match=r"20000000000 points would take \d+ GB, .*give fewer points"):
        execute(replace(TASK, units=20_000_000_000), store=tmp_path / "parts" if kept else None)
    assert not (tmp_path / "parts").exists()


@pytest.mark.parametrize("link", [os.symlink, os.link])
def test_a_chunk_that_is_a_link_is_replaced_and_not_followed(folder, tmp_path, whole, same, link):
    other = tmp_path / "other"
    other.write_text("of somebody else")
    (folder / NAMES[0]).unlink()
    link(other, folder / NAMES[0])
    with pytest.warns(UserWarning, match="7 finished points are damaged"):
        store = Store(folder, TASK)
    store.put(0, 7, TASK.run(0, 7))
    assert other.read_text() == "of somebody else"
    found, before = resumed(folder, damaged=0)
    assert before == 38
    assert same(found, whole(TASK))


def test_a_manifest_that_is_a_link_is_replaced_and_not_followed(tmp_path, whole, same):
    other = tmp_path / "other"
    other.write_text("of somebody else")
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / MANIFEST).symlink_to(other)
    assert same(execute(TASK, store=tmp_path / "parts"), whole(TASK))
    assert other.read_text() == "of somebody else"


def test_a_damaged_byte_of_a_result_or_a_cut_costs_it(tmp_path):
    written = xr.Dataset({"x": ("i", [1.0, -0.0, float("nan")])}, attrs={"kind": "spectrum"})
    with Parts(tmp_path / "result.nc.parts", {"analysis": {"one": 1}}, resume=False) as parts:
        parts.keep("one", written)
        assert os.listdir(parts.folder / "one") == ["result.nc"]
        path = parts.folder / "one" / "result.nc"
        data = path.read_bytes()
        for where in (*range(0, len(data), 211), *range(len(data) - 90, len(data), 7), len(data) - 1):
            for spoilt in (bytes([*data[:where], data[where] ^ 0x10, *data[where + 1 :]]), data[:where], data + b"\n"):
                path.write_bytes(spoilt)
                with pytest.warns(UserWarning, match="is damaged, or its checksum; one is recomputed"):
                    assert parts.finished("one") is None
        path.write_bytes(data)
        assert parts.finished("one").identical(written)
    assert not parts.folder.exists()


def test_a_result_of_holes_alone_is_not_read(tmp_path, monkeypatch):
    with Parts(tmp_path / "result.nc.parts", {"analysis": {"one": 1}}, resume=False) as parts:
        (parts.folder / "one").mkdir()
        with (parts.folder / "one" / "result.nc").open("wb") as file:
            file.truncate(15 * 10**9)
        monkeypatch.setattr("chaosdrill.archive.digest._line", lambda *_: pytest.fail("it was read"))
        with pytest.warns(UserWarning, match="one is recomputed"):
            assert parts.finished("one") is None


def test_parts_of_an_analysis_that_lie_behind_a_link_are_not_written(tmp_path):
    other = tmp_path / "other"
    other.mkdir()
    with Parts(tmp_path / "result.nc.parts", {"analysis": {"one": 1}}, resume=False) as parts:
        (parts.folder / "one").symlink_to(other, target_is_directory=True)
        with pytest.raises(ArchiveError, match="one: is a link"):
            parts.keep("one", xr.Dataset({"x": ("i", [1.0])}))
        with pytest.raises(ArchiveError, match="one: is a link"):
            parts.store("one")
    assert list(other.iterdir()) == []


# A process that ends at any of its system calls, a write half done, is gone on with to the same result.


RUNS = """
import os, shutil, sys
from pathlib import Path
sys.path.insert(0, sys.argv[2])
import numpy as np, xarray as xr
from support.logistic_task import Logistic
from chaosdrill.files import remove_drafts, replacing
from chaosdrill.sweep import Parts, execute

CALLS = [(os, name) for name in ("open", "mkdir", "fsync", "replace", "unlink", "rmdir")] + [(Path, "write_bytes")]
TASK = Logistic(units=12, iterations=3)
folder = Path(sys.argv[1])
target, parts_folder = folder / "out.bin", folder / "out.nc.parts"

def run():
    with Parts(parts_folder, {"analysis": {"one": 1, "many": 2}}, resume=True) as parts:
        remove_drafts(target)
        one = parts.finished("one")
        if one is None:
            one = xr.Dataset({"x": ("t", np.array([0.1, -0.0, np.inf, -np.nan]))})
            parts.keep("one", one)
        many = execute(TASK, store=parts.store("many"))
        with replacing(target) as draft:
            draft.write_bytes(one["x"].values.tobytes() + b"".join(many[name].tobytes() for name in sorted(many)))
    return target.read_bytes()

def run_until(call):
    '''Run in a process that ends before its n-th call, or halfway through it if it writes; whether it came so far.'''
    pid = os.fork()
    if pid:
        return os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]) == 9
    made = [0]

    def counted(name, plain):
        def made_one(*arguments, **keywords):
            made[0] += 1
            if made[0] == call:
                if name == "write_bytes":
                    path, data = arguments
                    plain(path, data[: len(data) // 2])
                os._exit(9)
            return plain(*arguments, **keywords)
        return made_one

    for place, name in CALLS:
        setattr(place, name, counted(name, getattr(place, name)))
    run()
    os._exit(0)

expected = run()
call = 1
while run_until(call):
    assert run() == expected, call
    assert os.listdir(folder) == ["out.bin"], (call, os.listdir(folder))
    target.unlink()
    call += 1
print(call)
"""


def test_killed_at_every_system_call(tmp_path):
    command = [sys.executable, "-c", RUNS, str(tmp_path), str(Path(__file__).parents[1])]
    done = subprocess.run(command, capture_output=True, text=True, timeout=500)
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) > 60
