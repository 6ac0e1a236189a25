"""A report is written whole or not at all, and only where a page belongs."""

import os
from pathlib import Path

import pytest

import chaosdrill as cd
from chaosdrill.archive import save
from chaosdrill.errors import ArchiveError, SettingsError


@pytest.fixture
def archive(tree, tmp_path):
    return save(tree, tmp_path / "result.nc")


def test_default_name_is_beside_the_archive(archive):
    assert cd.report(archive).path == archive.with_suffix(".html")


def test_the_same_archive_gives_the_same_page(archive, tmp_path):
    one, two = (cd.report(archive, tmp_path / f"{name}.html").path.read_bytes() for name in "ab")
    assert one == two


def test_a_full_disk_leaves_the_earlier_page(archive, monkeypatch):
    page = cd.report(archive).path
    before = page.read_bytes()

    def half(self, data):
        with open(self, "wb") as stream:
            stream.write(data[:1000])
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", half)
    with pytest.raises(ArchiveError, match="No space left on device; an earlier one is as it was"):
        cd.report(archive)
    assert page.read_bytes() == before
    assert sorted(os.listdir(page.parent)) == ["result.html", "result.nc"]


def test_the_archive_itself_is_never_the_target(archive):
    before = archive.read_bytes()
    with pytest.raises(SettingsError, match=r"does not end with \.html"):
        cd.report(archive, archive)
    assert archive.read_bytes() == before


def test_a_folder_that_does_not_exist(archive, tmp_path):
    with pytest.raises(ArchiveError, match="does not exist"):
        cd.report(archive, tmp_path / "no" / "page.html")
