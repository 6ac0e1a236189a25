"""A write that fails leaves the earlier archive whole and nothing beside it."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
import xarray as xr

from chaosdrill.archive import check_writable, save
from chaosdrill.errors import ArchiveError
from chaosdrill.files import draft_of, remove_drafts

PLACES = [str(folder) for folder in Path(__file__).parents[:2]]
"""Where scripts find what tests share."""


@pytest.fixture
def earlier(tree, tmp_path):
    """An archive that is there already, and its bytes."""
    path = save(tree, tmp_path / "result.nc")
    return path, path.read_bytes()


def unharmed(earlier):
    path, content = earlier
    return path.read_bytes() == content and os.listdir(path.parent) == [path.name]


# the limit on the size of a file fails a write just as a full disk does, after part of it has been written
FULL_DISK = """
import resource, signal, sys
sys.path[:0] = sys.argv[2:]
from conftest import diagram
from chaosdrill.archive import save
from chaosdrill.errors import ArchiveError
from chaosdrill.files import draft_of, remove_drafts
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (40_000, 40_000))
try:
    save(diagram(20_000), sys.argv[1])
except ArchiveError as fault:
    print(fault)
"""


def test_full_disk(earlier):
    command = [sys.executable, "-c", FULL_DISK, str(earlier[0]), *PLACES]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)
    assert "cannot write the archive" in done.stdout
    assert "disk full" in done.stdout
    assert unharmed(earlier)


@pytest.mark.parametrize("fault", [KeyboardInterrupt, MemoryError])
def test_interrupt_while_writing(earlier, tree, monkeypatch, fault):
    def half(self, path, **_):
        Path(path).write_bytes(b"half an archive")
        raise fault

    monkeypatch.setattr(xr.DataTree, "to_netcdf", half)
    with pytest.raises(fault):
        save(tree, earlier[0])
    assert unharmed(earlier)


def test_fault_while_moving_into_place(earlier, tree, monkeypatch):
    def refuse(*_):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(os, "replace", refuse)
    with pytest.raises(ArchiveError, match="Permission denied; an earlier one is as it was"):
        save(tree, earlier[0])
    assert unharmed(earlier)


def test_read_only_folder(earlier, tree):
    folder = earlier[0].parent
    folder.chmod(0o500)
    try:
        if os.access(folder, os.W_OK):
            pytest.skip("this user may write anywhere")
        with pytest.raises(ArchiveError, match="Permission denied"):
            save(tree, earlier[0])
    finally:
        folder.chmod(0o700)
    assert unharmed(earlier)


def test_folder_that_takes_no_files():
    with pytest.raises(ArchiveError, match="cannot write into /proc"):
        check_writable("/proc/result.nc")


def test_target_is_a_folder(tmp_path):
    with pytest.raises(ArchiveError, match="is a folder"):
        check_writable(tmp_path)


def test_folder_that_does_not_exist(tmp_path):
    with pytest.raises(ArchiveError, match="does not exist"):
        check_writable(tmp_path / "none" / "result.nc")


def test_a_new_archive_has_the_usual_permissions(tree, tmp_path):
    (tmp_path / "plain").touch()
    assert save(tree, tmp_path / "result.nc").stat().st_mode == (tmp_path / "plain").stat().st_mode


THREADS = """
import sys
from concurrent.futures import ThreadPoolExecutor
sys.path[:0] = sys.argv[2:]
from conftest import diagram
import chaosdrill as cd

def work(number):
    path = f"{sys.argv[1]}/{number}.nc"
    cd.save(diagram(200), path)
    first = cd.open(path)
    for _ in range(8):
        cd.save(first, path)
        assert cd.open(path).identical(first)
    return number

with ThreadPoolExecutor(6) as pool:
    print(sorted(pool.map(work, range(6))))
"""


def test_threads_may_save_and_open_at_once(tmp_path):
    command = [sys.executable, "-c", THREADS, str(tmp_path), *PLACES]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout.strip()) == (0, "[0, 1, 2, 3, 4, 5]"), done.stderr[-2000:]


def test_a_link_is_followed_and_its_target_replaced(tree, tmp_path):
    (tmp_path / "far").mkdir()
    real, link = tmp_path / "far" / "real.nc", tmp_path / "link.nc"
    save(tree, real)
    before = real.stat().st_ino
    link.symlink_to(real)
    save(tree, link)
    assert link.is_symlink()
    assert real.stat().st_ino != before
    assert os.listdir(tmp_path / "far") == ["real.nc"]


def test_what_is_no_ordinary_file_is_not_replaced(tree, tmp_path):
    target = tmp_path / "pipe"
    os.mkfifo(target)
    with pytest.raises(ArchiveError, match="not an ordinary file"):
        save(tree, target)
    assert target.is_fifo()


def test_drafts_of_another_target_are_left_alone(tmp_path):
    long = "a" * 90
    one, other = tmp_path / f"{long}1.nc", tmp_path / f"{long}2.nc"
    mine, theirs = draft_of(one), draft_of(other)
    mine.touch()
    theirs.touch()
    remove_drafts(one)
    assert os.listdir(tmp_path) == [theirs.name]
