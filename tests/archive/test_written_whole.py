"""A write that fails leaves the earlier archive whole and nothing beside it."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
import xarray as xr

from chaosdrill.archive import check_writable, save
from chaosdrill.errors import ArchiveError


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
sys.path.insert(0, sys.argv[2])
from conftest import diagram
from chaosdrill.archive import save
from chaosdrill.errors import ArchiveError
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (40_000, 40_000))
try:
    save(diagram(20_000), sys.argv[1])
except ArchiveError as fault:
    print(fault)
"""


def test_full_disk(earlier):
    command = [sys.executable, "-c", FULL_DISK, str(earlier[0]), str(Path(__file__).parent)]
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
