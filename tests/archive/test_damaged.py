"""What cannot be opened is refused with the reason, whatever has happened to it."""

import random

import pytest
import xarray as xr

from chaosdrill.archive import info, save
from chaosdrill.archive import open as open_archive
from chaosdrill.errors import ArchiveError


def refusal(path):
    with pytest.raises(ArchiveError) as caught:
        open_archive(path)
    return str(caught.value)


def test_missing(tmp_path):
    assert "No such file" in refusal(tmp_path / "none.nc")


def test_folder(tmp_path):
    assert "directory" in refusal(tmp_path)


def test_empty(tmp_path):
    (tmp_path / "a.nc").touch()
    assert "is empty" in refusal(tmp_path / "a.nc")


def test_text(tmp_path):
    (tmp_path / "a.nc").write_text("time,state\n0,1\n")
    assert "not a NetCDF-4 file" in refusal(tmp_path / "a.nc")


def test_classic_netcdf(tmp_path):
    (tmp_path / "a.nc").write_bytes(b"CDF\x01" + bytes(100))
    assert "not a NetCDF-4 file" in refusal(tmp_path / "a.nc")


def test_somebody_elses(tmp_path):
    xr.Dataset({"x": ("t", [1.0])}).to_netcdf(tmp_path / "a.nc", engine="netcdf4")
    assert "not an archive of chaosdrill" in refusal(tmp_path / "a.nc")


@pytest.mark.parametrize("share", [0.01, 0.3, 0.6, 0.9, 0.999])
def test_truncated(tree, tmp_path, share):
    path = save(tree, tmp_path / "a.nc")
    content = path.read_bytes()
    path.write_bytes(content[: int(share * len(content))])
    assert "truncated or damaged" in refusal(path)


def test_altered_bytes_raise_nothing_else(tree, tmp_path):
    path = save(tree, tmp_path / "a.nc")
    content = path.read_bytes()
    chance = random.Random(1)
    refused = 0
    for _ in range(40):
        altered = bytearray(content)
        for _ in range(20):
            altered[chance.randrange(len(altered))] = chance.randrange(256)
        path.write_bytes(altered)
        try:
            info(path)
        except ArchiveError:
            refused += 1
    assert refused > 0
