"""Whatever a kill leaves behind or a disk damages is noticed and computed again; the rest is not."""

import errno
import json
import os
import shutil
import time
import warnings
from dataclasses import replace

import pytest
import xarray as xr
from logistic_task import Logistic

from chaosdrill.errors import ArchiveError, SettingsError
from chaosdrill.sweep import execute
from chaosdrill.sweep.parts import Parts
from chaosdrill.sweep.store import JOURNAL, MANIFEST, RESULTS, Store, kept_points

TASK = Logistic(units=60, iterations=3)
CHUNKS = ((0, 7), (7, 20), (40, 11))


@pytest.fixture
def folder(tmp_path):
    """A store with three finished chunks: units 0 to 26 and 40 to 50."""
    with Store(tmp_path / "parts", TASK) as store:
        for first, count in CHUNKS:
            store.put(first, count, TASK.run(first, count))
    return tmp_path / "parts"


def resumed(folder, task=TASK, damaged=None):
    """Results, and the number of units that were there before; a warning says how many are damaged, if any are."""
    told = []
    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always")
        found = execute(task, store=folder, progress=lambda *seen: told.append(seen))
    texts = [str(one.message) for one in heard]
    if damaged is not None:
        lost = "finished points are damaged, or the digests beside them; they are computed again"
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


def test_a_journal_cut_anywhere_vouches_for_whole_lines_only(folder, whole, same):
    journal = (folder / JOURNAL).read_bytes()
    ends = [k for k, byte in enumerate(journal) if byte == ord("\n")]
    expected = whole(TASK)
    for cut in (*range(0, len(journal), 5), *ends):
        (folder / JOURNAL).write_bytes(journal[:cut])
        complete = sum(count for (_, count), end in zip(CHUNKS, ends, strict=True) if cut >= end)
        found, before = resumed(folder)
        assert before == complete
        assert same(found, expected)
        assert resumed(folder)[1] == 60


@pytest.mark.parametrize("where", range(0, 1500, 70))
def test_a_damaged_byte_of_the_results_costs_its_chunk_only(folder, whole, same, where):
    data = bytearray((folder / RESULTS).read_bytes())
    data[where % len(data)] ^= 0x10
    (folder / RESULTS).write_bytes(data)
    found, before = resumed(folder)
    assert before in {38, 38 - 7, 38 - 20, 38 - 11}
    assert same(found, whole(TASK))


@pytest.mark.parametrize("where", range(0, 280, 9))
def test_a_damaged_byte_of_the_journal_costs_its_chunk_only(folder, whole, same, where):
    data = bytearray((folder / JOURNAL).read_bytes())
    data[where % len(data)] ^= 0x01
    (folder / JOURNAL).write_bytes(data)
    found, before = resumed(folder)
    # a damaged end of line costs the two lines that it parted
    assert before in {38, 31, 18, 27, 11}
    assert same(found, whole(TASK))


def test_a_false_digest_is_told_once(folder, whole, same):
    lines = [json.loads(line) for line in (folder / JOURNAL).read_text().splitlines()]
    first, second, _ = lines
    first["sha256"], second["sha256"] = second["sha256"], "0" * 64
    (folder / JOURNAL).write_text("".join(f"{json.dumps(line)}\n" for line in lines))
    found, before = resumed(folder, damaged=first["count"] + second["count"])
    assert before == 38 - first["count"] - second["count"]
    assert same(found, whole(TASK))
    # the false lines are still there, beside those of what was computed again
    assert resumed(folder, damaged=0)[1] == TASK.units


@pytest.mark.parametrize("left", [0, 100, 1000])
def test_results_cut_short_are_computed_again(folder, whole, same, left):
    os.truncate(folder / RESULTS, left)
    assert same(resumed(folder)[0], whole(TASK))


def test_other_work_is_refused_with_what_differs(folder):
    journal = (folder / JOURNAL).read_bytes()
    with pytest.raises(SettingsError) as caught:
        execute(replace(TASK, units=80), store=folder)
    assert "units: 60 before, 80 now" in str(caught.value)
    assert "remove the folder to start over" in str(caught.value)
    assert (folder / JOURNAL).read_bytes() == journal


def test_a_store_in_which_nothing_has_finished_takes_other_work(tmp_path, whole, same):
    with Store(tmp_path, TASK):
        pass
    other = Logistic(units=20, iterations=5)
    assert same(resumed(tmp_path, other)[0], whole(other))


def test_a_damaged_manifest_is_refused(folder):
    (folder / MANIFEST).write_text('{"format": 1')
    with pytest.raises(ArchiveError, match="missing or damaged"):
        execute(TASK, store=folder)


def test_full_disk_before_the_work(tmp_path, monkeypatch):
    def full(*_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "posix_fallocate", full)
    with pytest.raises(ArchiveError, match=r"cannot reserve .* MB for the results: No space left on device"):
        execute(TASK, store=tmp_path)


@pytest.mark.parametrize("call", ["pwrite", "write", "fsync"])
def test_full_disk_during_the_work(folder, whole, same, monkeypatch, call):
    plain, left = getattr(os, call), [3]

    def full(*arguments):
        left[0] -= 1
        if left[0] < 0:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return plain(*arguments)

    monkeypatch.setattr(os, call, full)
    with pytest.raises(ArchiveError, match=r"cannot keep a finished chunk: No space left .* before is kept"):
        execute(TASK, store=folder)
    monkeypatch.undo()
    found, before = resumed(folder)
    assert before > 38
    assert same(found, whole(TASK))


def test_a_system_that_writes_in_parts(tmp_path, whole, same, monkeypatch):
    pwrite = os.pwrite
    monkeypatch.setattr(os, "pwrite", lambda handle, data, offset: pwrite(handle, data[:5], offset))
    assert same(resumed(tmp_path)[0], whole(TASK))
    assert resumed(tmp_path)[1] == 60


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


def test_a_disk_that_is_too_small_is_left_as_it_was(tmp_path, monkeypatch):
    """A file system may take all that is left before it says that this is not enough: it is not asked then."""
    there = os.statvfs(tmp_path)
    full = os.statvfs_result([*there[:4], 0, *there[5:]])
    monkeypatch.setattr(os, "fstatvfs", lambda _: full)
    monkeypatch.setattr(os, "posix_fallocate", lambda *_: pytest.fail("asked for room that is not there"))
    with pytest.raises(ArchiveError, match=r"cannot reserve .*No space left"):
        execute(TASK, store=tmp_path / "parts")
    results = tmp_path / "parts" / RESULTS
    assert not results.exists() or results.stat().st_size == 0


@pytest.mark.parametrize("name", [RESULTS, JOURNAL])
@pytest.mark.parametrize("link", [os.symlink, os.link])
def test_a_file_that_is_a_link_to_another_is_not_written(folder, tmp_path, name, link):
    other = tmp_path / "other"
    other.write_text("of somebody else")
    (folder / name).unlink()
    link(other, folder / name)
    with pytest.raises(ArchiveError, match=f"{name} is a link to another file"):
        execute(TASK, store=folder)
    assert other.read_text() == "of somebody else"


def test_a_line_of_the_journal_that_is_no_line_is_passed_over(folder, whole, same):
    with (folder / JOURNAL).open("a") as journal:
        journal.write("[" * 100_000 + "\n" + '{"first": 0}\n')
    found, before = resumed(folder)
    assert before == 38
    assert same(found, whole(TASK))


def test_a_manifest_that_is_a_link_is_replaced_and_not_followed(tmp_path, whole, same):
    other = tmp_path / "other"
    other.write_text("of somebody else")
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / MANIFEST).symlink_to(other)
    assert same(execute(TASK, store=tmp_path / "parts"), whole(TASK))
    assert other.read_text() == "of somebody else"


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
