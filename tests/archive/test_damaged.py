"""What cannot be opened is refused with the reason, whatever has happened to it."""

import random
from hashlib import sha256
from importlib import import_module

import pytest
import xarray as xr

from chaosdrill.archive import open as open_archive
from chaosdrill.archive import save
from chaosdrill.archive.seal import LENGTH
from chaosdrill.dataset.provenance import FORMAT
from chaosdrill.errors import ArchiveError
from chaosdrill.workflow import compare, info


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
    content = path.read_bytes()[:-LENGTH]
    path.write_bytes(content[: int(share * len(content))])
    assert "truncated or damaged" in refusal(path)


def test_altered_bytes_raise_nothing_else(tree, tmp_path):
    path = save(tree, tmp_path / "a.nc")
    content = path.read_bytes()
    chance = random.Random(1)
    refused = 0
    for _ in range(8):
        altered = bytearray(content)
        for _ in range(20):
            altered[chance.randrange(len(altered))] = chance.randrange(256)
        path.write_bytes(altered)
        try:
            info(path)
        except ArchiveError:
            refused += 1
    assert refused > 0


def test_without_its_last_line_it_is_whole(tree, tmp_path):
    path = save(tree, tmp_path / "a.nc")
    path.write_bytes(path.read_bytes()[:-1])
    assert compare(open_archive(path), tree) == []


def test_the_last_line_is_the_digest_of_the_rest(tree, tmp_path):
    content = save(tree, tmp_path / "a.nc").read_bytes()
    assert content[-LENGTH:].split() == [b"chaosdrill", b"sha256", sha256(content[:-LENGTH]).hexdigest().encode()]


def test_of_a_later_format(tree, tmp_path):
    tree.attrs |= {"format_version": FORMAT + 1, "versions": '{"chaosdrill": "9.1.0"}'}
    message = refusal(save(tree, tmp_path / "a.nc"))
    assert f"format {FORMAT + 1}" in message
    assert "install" in message
    assert "9.1.0" in message


def test_of_the_first_format(tree, tmp_path):
    """Without number, digests and last line, and with texts under the names of their dimensions."""
    tree.to_netcdf(tmp_path / "a.nc", engine="netcdf4")
    assert compare(open_archive(tmp_path / "a.nc"), tree) == []


def test_a_file_on_which_the_library_goes_round_for_ever_takes_bounded_processor_time(tmp_path, monkeypatch):
    """Also where nobody is left to end the process in which it is tried."""
    # the package has a function of that name
    seal = import_module("chaosdrill.archive.seal")
    monkeypatch.setattr(seal, "AT_WORK", 1)
    before_it_reads = seal._TRIAL.split("from chaosdrill")[0]
    monkeypatch.setattr(seal, "_TRIAL", before_it_reads + "while True: pass\n")
    (tmp_path / "round.nc").write_bytes(b"any")
    with pytest.raises(ArchiveError, match="or never ends"):
        seal.try_reading(tmp_path / "round.nc")
