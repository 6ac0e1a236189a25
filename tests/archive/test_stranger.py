"""Files that a stranger built on purpose are refused, with the reason, by a process of its own; sealed or not."""

import fcntl
import os
import signal
import subprocess
import sys
import threading
import time
from dataclasses import replace

import h5py
import numpy as np
import pytest
import xarray as xr
from support.archives import diagram

import chaosdrill as cd
from chaosdrill.archive import inside, trial
from chaosdrill.archive.digest import LENGTH, append_checksum
from chaosdrill.errors import ArchiveError

SECRET = 1.2345678


@pytest.fixture(scope="module")
def sound(tmp_path_factory):
    """Bytes of an archive of two groups."""
    tree = xr.DataTree.from_dict({"a": diagram(5), "b": diagram(5)})
    return cd.save(tree, tmp_path_factory.mktemp("sound") / "sound.nc").read_bytes()


@pytest.fixture(params=[True, False], ids=["sealed", "unsealed"])
def stranger(request, sound, tmp_path):
    """Writes an archive that a function of an open file has changed."""

    def written(change):
        path = tmp_path / "stranger.nc"
        path.write_bytes(sound[:-LENGTH])
        with h5py.File(path, "r+") as file:
            change(file)
        if request.param:
            append_checksum(path)
        return path

    return written


def refusal(path):
    start = time.monotonic()
    with pytest.raises(ArchiveError) as caught:
        cd.open(path)
    assert time.monotonic() - start < 60
    return str(caught.value)


def beside(file, group, name, shape, **storage):
    """A variable with the dimensions of NetCDF, stored in any way."""
    names = [f"dim{len(group)}_{i}" for i in range(len(shape))]
    made = group.create_dataset(name, shape, **storage)
    for i, (length, dim) in enumerate(zip(shape, names, strict=True)):
        if dim not in group:
            scale = group.create_dataset(dim, (length,), "f4", chunks=(min(length, 1000),), track_order=True)
            scale.make_scale(f"This is a netCDF dimension but not a netCDF variable{length:10d}")
        made.dims[i].attach_scale(group[dim])
    return made


def test_what_is_changed_without_harm_is_read(stranger):
    def change(file):
        beside(file, file["a"], "more", (3,), dtype="f8")[:] = [1.0, 2.0, 3.0]

    with pytest.warns(UserWarning, match="altered since the archive was written: a more"):
        assert cd.open(stranger(change))["a/more"].values.tolist() == [1.0, 2.0, 3.0]


def test_values_in_another_file(stranger, tmp_path):
    other = tmp_path / "other.bin"
    np.full(4, SECRET).tofile(other)

    def change(file):
        beside(file, file["a"], "more", (4,), dtype="f8", external=[(str(other), 0, 32)])

    assert "is stored in another file" in refusal(stranger(change))


def test_values_in_a_pipe(stranger, tmp_path):
    os.mkfifo(tmp_path / "pipe")

    def change(file):
        beside(file, file["a"], "more", (4,), dtype="f8", external=[(str(tmp_path / "pipe"), 0, 32)])

    assert "is stored in another file" in refusal(stranger(change))


def test_values_composed_of_another_file(stranger, tmp_path):
    with h5py.File(tmp_path / "other.h5", "w") as other:
        other["x"] = np.full(4, SECRET)

    def change(file):
        layout = h5py.VirtualLayout((4,), "f8")
        layout[:] = h5py.VirtualSource(str(tmp_path / "other.h5"), "x", (4,))
        file["a"].create_virtual_dataset("more", layout)

    assert "virtual dataset" in refusal(stranger(change))


@pytest.mark.parametrize("link", ["soft", "external"])
def test_links(stranger, tmp_path, link):
    with h5py.File(tmp_path / "other.h5", "w") as other:
        other["x"] = np.full(4, SECRET)

    def change(file):
        file["a/more"] = h5py.SoftLink("/b") if link == "soft" else h5py.ExternalLink(str(tmp_path / "other.h5"), "/x")

    assert "is a link to another place or file" in refusal(stranger(change))


@pytest.mark.parametrize("place", ["b", "b/more", "attribute"])
def test_names_that_make_lines(stranger, place):
    def change(file):
        if place == "attribute":
            file["b"].attrs["x\n  altered  nothing"] = 1
        elif place == "b":
            file.move("b", "b\nvictim")
        else:
            beside(file, file["b"], "more\x1b[2J", (1,), dtype="f8")

    assert "holds a control character" in refusal(stranger(change))


def test_a_circle_of_hard_links(stranger):
    def change(file):
        file["a/b"] = file["b"]
        file["b/a"] = file["a"]

    assert "has two names" in refusal(stranger(change))


def test_hard_links_in_exponential_number(stranger):
    def change(file):
        level = file["a"]
        for i in range(40):
            deeper = file.create_group(f"level{i}")
            deeper["one"], deeper["two"] = level, level
            level = deeper

    assert "has two names" in refusal(stranger(change))


def test_many_references_to_one_long_text(stranger):
    """Its text stands in the file once, and 200,000 entries refer to it."""

    def change(file):
        made = beside(file, file["a"], "more", (200_000,), dtype=h5py.string_dtype())
        made[0] = "x" * 50_000
        # an entry is a length and the place of the text; all are made the first one's
        offset = made.id.get_offset()
        file.flush()
        with open(file.filename, "r+b") as raw:
            raw.seek(offset)
            entry = raw.read(16)
            raw.seek(offset)
            raw.write(entry * 200_000)
            raw.flush()

    path = stranger(change)
    assert path.stat().st_size < 10**7
    assert "more than the 512 MB" in refusal(path)


def test_one_long_text_among_many(stranger):
    """An array of texts has the room of the longest for each."""

    def change(file):
        made = beside(file, file["a"], "more", (100_000,), dtype=h5py.string_dtype())
        made[0] = "x" * 5_000

    assert "more than the 512 MB" in refusal(stranger(change))


def test_chunks_that_were_never_written(stranger):
    def change(file):
        made = beside(file, file["a"], "more", (250_000, 100), dtype="f8", chunks=(1000, 100), compression="gzip")
        made[:1000] = np.random.default_rng(1).random((1000, 100))
        # padding, so that the size of the file would allow it
        beside(file, file["a"], "padding", (1_000_000,), dtype="u1", chunks=(100_000,))[:] = 7

    assert "were never written" in refusal(stranger(change))


def test_constants_far_beyond_the_usual(stranger):
    def change(file):
        made = beside(file, file["a"], "more", (800, 100_000), dtype="f8", chunks=(10, 100_000), compression="gzip")
        for start in range(0, 800, 10):
            made[start : start + 10] = 0.0

    assert "is declared with the shape (800, 100000)" in refusal(stranger(change))


def test_a_chunk_larger_than_any(stranger):
    def change(file):
        beside(file, file["a"], "more", (2**25,), dtype="f8", chunks=(2**25,))[0] = 1.0

    assert "has chunks of 256 MB" in refusal(stranger(change))


def test_a_filter_that_is_a_program(stranger):
    def change(file):
        made = file["a"].create_dataset("more", (10,), "f8", chunks=(10,), compression="lzf")
        made[:] = 1.0

    assert "compressed by filter 32000" in refusal(stranger(change))


@pytest.mark.parametrize(
    "kind", [np.dtype([("x", "f8")]), h5py.vlen_dtype("f8"), h5py.ref_dtype, "f2", "c16", "S9"], ids=str
)
def test_types_that_no_archive_has(stranger, kind):
    def change(file):
        beside(file, file["a"], "more", (2,), dtype=kind)

    assert "holds neither texts nor numbers" in refusal(stranger(change))


def test_an_attribute_of_a_type_that_no_archive_has(stranger):
    refused = refusal(stranger(lambda file: file["a"].attrs.create("half", 0.5, dtype="f2")))
    assert "/a: the attribute 'half' holds neither texts nor numbers" in refused


def test_groups_too_deep(stranger):
    assert "groups deep" in refusal(stranger(lambda file: file.create_group("/".join("d" * 40))))


def test_attributes_without_number(stranger):
    def change(file):
        for i in range(1001):
            file["b"].attrs[f"n{i}"] = i

    assert "attributes; an archive has at most 1000" in refusal(stranger(change))


def test_dimensions_without_names(stranger):
    assert "not written as NetCDF" in refusal(stranger(lambda file: file["a"].create_dataset("more", data=[1.0, 2.0])))


def test_the_library_crashes(tmp_path, sound, monkeypatch):
    """A crash, and work without an end, cost the process in which the file is read, and this one a message."""
    path = tmp_path / "a.nc"
    path.write_bytes(sound)
    text = trial.source()
    for before, after, told in [
        ("File(file, size, output).read()", "os.abort()", "the HDF5 library crashes on it"),
        ("File(file, size, output).read()", "[None for _ in iter(int, 1)]", "reading it never ends"),
        ("File(file, size, output).read()", "b'x' * 2**40", "takes more memory than is free"),
        ("File(file, size, output).read()", "open('/etc/passwd'); output.say(end=True)", "Too many open files"),
    ]:
        trial._end_spare()
        changed = text.replace(before, after).replace("AT_WORK_S = 20", "AT_WORK_S = 0")
        assert changed.count(after) == 1
        with monkeypatch.context() as patch:
            patch.setattr(trial, "source", lambda changed=changed: changed)
            assert told in refusal(path)
    trial._end_spare()
    assert list(cd.open(path).children) == ["a", "b"]


def test_a_pipe_or_a_device_is_no_archive(tmp_path):
    os.mkfifo(tmp_path / "pipe.nc")
    assert "not an ordinary file" in refusal(tmp_path / "pipe.nc")
    assert "not an ordinary file" in refusal("/dev/zero")


# Neither the process that asks nor one that it forks ever holds the NetCDF library to read.

READS = """
import sys
import chaosdrill as cd
cd.open(sys.argv[1])
print(*[name for name in ("netCDF4", "h5py", "numba", "sympy") if name in sys.modules])
"""


def test_the_process_that_asks_loads_no_library_that_reads(tmp_path, sound):
    path = tmp_path / "a.nc"
    path.write_bytes(sound)
    done = subprocess.run([sys.executable, "-c", READS, str(path)], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []


def test_the_process_that_reads_loads_little(tmp_path, sound):
    path = tmp_path / "a.nc"
    path.write_bytes(sound)
    names = "('numba', 'sympy', 'xarray', 'netCDF4', 'scipy', 'pandas', 'chaosdrill')"
    text = trial.source() + f"\n    Output(1).say(heavy=[name for name in {names} if name in sys.modules])\n"
    command = [sys.executable, "-I", "-S", "-c", text, *filter(None, sys.path)]
    asked = os.fsencode(path).hex() + "\n"
    done = subprocess.run(command, input=asked, capture_output=True, text=True, errors="replace", check=True)
    assert done.stdout.endswith('{"heavy": []}')


def test_one_process_reads_several_files(tmp_path, sound):
    path, wrong = tmp_path / "a.nc", tmp_path / "wrong.nc"
    path.write_bytes(sound)
    wrong.write_bytes(sound[: len(sound) // 2])
    with trial.borrowed() as reader:
        first = reader.read(path, decoded=True)
        number = reader._process.pid
        with pytest.raises(trial.DamagedError):
            reader.read(wrong, decoded=True)
        again = reader.read(path, decoded=True)
        assert reader._process.pid == number
    assert all(first[name].identical(again[name]) for name in first)


def test_a_process_that_is_kept_waiting_is_no_damage(tmp_path, sound, monkeypatch):
    path = tmp_path / "a.nc"
    path.write_bytes(sound)
    with trial.borrowed() as reader:
        reader.read(path, decoded=True)
        os.kill(reader._process.pid, signal.SIGSTOP)
        monkeypatch.setattr(trial, "TUNING", replace(trial.TUNING, patience_s=0.1))
        with pytest.raises(ArchiveError, match="is the machine busy, or the disk slow") as caught:
            reader.read(path, decoded=True)
    assert not isinstance(caught.value, trial.DamagedError)


def test_too_many_open_files_is_no_damage(tmp_path, sound):
    import resource

    path = tmp_path / "a.nc"
    path.write_bytes(sound)
    trial._end_spare()
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    spare = os.dup(0)
    os.close(spare)
    resource.setrlimit(resource.RLIMIT_NOFILE, (spare + 3, hard))
    try:
        told = refusal(path)
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
    assert "Too many open files" in told
    assert "damaged" not in told


def test_a_file_that_another_program_has_locked_is_no_damage(tmp_path, sound):
    path = tmp_path / "a.nc"
    path.write_bytes(sound)
    trial._end_spare()
    with open(path, "rb") as held:
        fcntl.flock(held, fcntl.LOCK_EX)
        assert "a" in cd.open(path)


def test_what_may_be_declared():
    """Everything that small files compress to, and no more than half a gigabyte where nothing is held."""
    assert inside.most_bytes(0) == inside.FREE_BYTES
    assert inside.most_bytes(2 * 10**6) == inside.USUAL_BYTES
    assert inside.most_bytes(10**9) == inside.USUAL_COMPRESSION * 10**9


def test_a_file_that_is_exchanged_while_it_is_opened(stranger, sound, tmp_path):
    # it is the file that was checked that is read, or none
    secret = tmp_path / "secret.bin"
    np.full(4, SECRET).tofile(secret)
    hostile = stranger(lambda file: beside(file, file["a"], "more", (4,), dtype="f8", external=[(str(secret), 0, 32)]))
    whole, target, begun = tmp_path / "whole.nc", tmp_path / "target.nc", threading.Event()
    whole.write_bytes(sound)
    expected = cd.open(whole)
    os.link(whole, target)
    stop = threading.Event()

    def exchange():
        while not stop.is_set():
            for other in (hostile, whole, secret, whole):
                os.link(other, tmp_path / "next")
                os.replace(tmp_path / "next", target)
                # two names of one file would not replace each other
                (tmp_path / "next").unlink(missing_ok=True)
                begun.set()
                time.sleep(0.002)

    thread = threading.Thread(target=exchange)
    thread.start()
    begun.wait()
    opened = refused = 0
    end = time.monotonic() + 30
    try:
        while min(opened, refused) < 10 and time.monotonic() < end:
            time.sleep(0.001)
            try:
                assert cd.open(target).identical(expected)
                opened += 1
            except ArchiveError:
                refused += 1
    finally:
        stop.set()
        thread.join()
    assert min(opened, refused) >= 10
