"""Read the contents of an HDF5 file in a separate process: the only code that looks into an untrusted file.

It is run as a script by `chaosdrill.archive.trial`, which sends it file names, and imports nothing of the package. The
process cannot write a file, start a process or open a second file; its memory and processor time are bounded. It sends
plain numbers and texts, so that the caller never passes the file to its own libraries. It reads with h5py, since the
NetCDF library follows links and sources in other files while opening one.
"""

import json
import os
import resource
import signal
import stat
import sys
from collections import deque
from contextlib import contextmanager, suppress
from itertools import product
from math import prod

DEEPEST = 16
"""Levels of groups."""
MOST_GROUPS = 10_000
MOST_VARIABLES = 1_000
"""In one group."""
MOST_ATTRIBUTES = 1_000
"""Of one group or variable."""
MOST_DIMENSIONS = 32
"""Of one variable, as HDF5 has it."""
FREE_BYTES = 2**26
"""What a file may declare however small it is; what it may declare and not hold; what its attributes may take."""
COMPRESSION = 1100
"""Bytes that deflate can make of one, at most: 1032."""
USUAL_BYTES = 2**29
"""What a file may declare that is compressed so far."""
USUAL_COMPRESSION = 100
"""Beyond that, this multiple of its size: results of many runs are compressed to a half, long constants to a tenth."""
LARGEST_CHUNK = 2**27
"""Bytes of a chunk, which is in memory as a whole; the NetCDF library makes them of up to 16 MB."""
BLOCK = 2**27
"""Bytes that are read at once, and that are kept of chunks."""
MEMORY = 3 * 2**28
"""Bytes that the process may take besides what its libraries do: with these it stays below a gigabyte."""
TEXTS = 64
"""Texts that are read at once, before their length is known."""
SHORT, MANY_TEXTS = 1000, 4096
"""Longest text in letters for which this number of texts is read at once."""
LETTER = 4
"""Bytes of a letter in an array of texts, where each has the room of the longest."""
AT_WORK_S = 20
"""Processor time for a file, and as much for every gigabyte that it declares: some damaged files have no end."""
FILTERS = {1: "deflate", 2: "shuffle", 3: "fletcher32"}
"""By their numbers in HDF5; any other may be a program that the reader's machine would look for."""
TEXT = "text"
_HIDDEN = {
    *(b"CLASS", b"NAME", b"DIMENSION_LIST", b"REFERENCE_LIST", b"_Netcdf4Dimid", b"_Netcdf4Coordinates"),
    *(b"_nc3_strict", b"_NCProperties", b"_NCCOPY"),
}
_NO_VARIABLE = b"This is a netCDF dimension but not a netCDF variable"
_NOT_ITS_DIMENSION = "_nc4_non_coord_"
_SCALED = {"_FillValue", "missing_value", "scale_factor", "add_offset"}


class Refused(Exception):
    """A file that is not an archive, with the reason."""


def most_bytes(size):
    """Bytes that a file of ``size`` bytes may declare."""
    return min(FREE_BYTES + COMPRESSION * size, max(USUAL_BYTES, USUAL_COMPRESSION * size))


def told(size):
    """A number of bytes for people."""
    return f"{size / 2**20:.3g} MB"


class Output:
    """The pipe to the caller: frames of a letter, a length and as many bytes."""

    def __init__(self, handle):
        self.handle = handle

    def say(self, **told):
        """Tell plain values."""
        self._send(b"J", json.dumps(told).encode())

    def give(self, data):
        """Tell numbers."""
        self._send(b"D", data)

    def _send(self, letter, data):
        view = memoryview(data).cast("B")
        head = letter + len(view).to_bytes(8, "little")
        for part in (memoryview(head), view):
            while len(part):
                part = part[os.write(self.handle, part) :]


def serve(requests, output):
    """Read the files that are named, a line each: the name in hexadecimal digits."""
    h5py._errors.silence_errors()
    confine()
    output.say(ready=True)
    for line in requests:
        try:
            read_file(bytes.fromhex(line.strip()), output)
            output.say(end=True)
        except Refused as fault:
            output.say(fault=str(fault))
        except MemoryError as fault:
            output.say(memory=str(fault))
        except RecursionError:
            output.say(fault="nested too deeply")
        except BrokenPipeError:
            return
        # damaged files make the library fail in ways of its own
        except Exception as fault:
            text = str(fault)
            short = "memory" in text or "can't allocate" in text or "unable to allocate" in text.lower()
            output.say(**{"memory" if short else "truncated": f"{text:.500}"})


def confine():
    """Bound what this process may take, and leave it nothing but one file to open."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    taken = 0
    with suppress(OSError), open("/proc/self/statm") as file:
        taken = int(file.read().split()[0]) * resource.getpagesize()
    limits = {
        "RLIMIT_CORE": 0,
        "RLIMIT_FSIZE": 0,
        "RLIMIT_NPROC": 0,
        # elsewhere than on Linux, the system shares its libraries in spaces of unknown size
        "RLIMIT_AS": taken + MEMORY if taken else resource.RLIM_INFINITY,
    }
    for name, bound in limits.items():
        with suppress(AttributeError, OSError, ValueError):
            kind = getattr(resource, name)
            hard = resource.getrlimit(kind)[1]
            bound = bound if hard == resource.RLIM_INFINITY else min(bound, hard)
            resource.setrlimit(kind, (bound, bound))


def allow_time(seconds):
    """Give the process this many seconds more; the system ends it if it takes longer."""
    usage = resource.getrusage(resource.RUSAGE_SELF)
    hard = resource.getrlimit(resource.RLIMIT_CPU)[1]
    bound = int(usage.ru_utime + usage.ru_stime) + 1 + seconds
    resource.setrlimit(resource.RLIMIT_CPU, (bound if hard == resource.RLIM_INFINITY else min(bound, hard), hard))


def read_file(name, output):
    """Tell what a file holds."""
    allow_time(AT_WORK_S)
    handle = os.open(name, os.O_RDONLY | os.O_NONBLOCK)
    try:
        status = os.fstat(handle)
        if not stat.S_ISREG(status.st_mode):
            raise Refused("not an ordinary file")
        # a file may have holes, which take no room
        size = min(status.st_size, 512 * status.st_blocks + 2**16)
        known = b"/dev/fd/%d" % handle
        access = h5py.h5p.create(h5py.h5p.FILE_ACCESS)
        access.set_fclose_degree(h5py.h5f.CLOSE_STRONG)
        with one_more_file(handle):
            file = h5py.h5f.open(known if os.path.exists(known) else name, h5py.h5f.ACC_RDONLY, access)
            try:
                File(file, size, output).read()
            finally:
                file.close()
    finally:
        os.close(handle)


@contextmanager
def one_more_file(handle):
    """While the block runs one file can be opened, and no other as long as that is open."""
    before = resource.getrlimit(resource.RLIMIT_NOFILE)
    spare = os.dup(handle)
    os.close(spare)
    resource.setrlimit(resource.RLIMIT_NOFILE, (spare + 1, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, before)


class File:
    """A file that is open.

    ``size`` are its bytes on the disk; its contents are written to ``output``.
    """

    def __init__(self, file, size, output):
        self.file, self.size, self.output = file, size, output
        self.allowed = most_bytes(size)
        self.declared = self.missing = self.described = self._longest = 0
        self.seen = set()
        self.names = {}
        """Of the dimensions, by the addresses of their scales."""
        self.numbers = {}
        """Names of the dimensions, by their numbers."""

    def read(self):
        """Walk through the groups, and send the variables of each."""
        root = h5py.h5g.open(self.file, b"/")
        self._first_visit(root, "/")
        groups, waiting = [], deque([(root, "/", 0)])
        while waiting:
            group, path, depth = waiting.popleft()
            inner, variables = self._members(group, path, depth)
            groups.append((group, path, variables))
            waiting.extend((child, f"{path.rstrip('/')}/{name}", depth + 1) for name, child in inner)
            if len(groups) + len(waiting) > MOST_GROUPS:
                raise Refused(f"{path}: more than {MOST_GROUPS} groups")
        found = []
        for group, path, variables in groups:
            described = [self._described(dataset, name, path) for name, dataset in variables]
            found.append((group, path, [entry for entry in described if entry is not None]))
        allow_time(int(AT_WORK_S * (1 + self.declared / 2**30)))
        for group, path, described in found:
            self.output.say(group=path, attributes=self._attributes(group, path))
            for dataset, head in described:
                self.output.say(**head)
                self._values(dataset, head)

    def _members(self, group, path, depth):
        """Groups and variables of a group, by name."""
        count = group.get_num_objs()
        if depth > DEEPEST or count > MOST_GROUPS + MOST_VARIABLES:
            raise Refused(
                f"{path:.200}: {depth} groups deep, {count} entries in this one; an archive has at most {MOST_GROUPS} "
                f"groups, {DEEPEST} deep, of {MOST_VARIABLES} variables"
            )
        inner, variables = [], []
        for raw in list(group):
            name = self._name(raw, path)
            if group.links.get_info(raw).type != h5py.h5l.TYPE_HARD:
                raise Refused(
                    f"{path}: {name!r:.60} is a link to another place or file; an archive holds its data itself"
                )
            kind = h5py.h5o.get_info(group, raw).type
            if kind == h5py.h5o.TYPE_GROUP:
                child = h5py.h5g.open(group, raw)
                self._first_visit(child, f"{path}: {name}")
                inner.append((name, child))
            elif kind == h5py.h5o.TYPE_DATASET:
                dataset = h5py.h5d.open(group, raw)
                self._first_visit(dataset, f"{path}: {name}")
                self._check_storage(dataset, f"{path}: {name}")
                variables.append((name, dataset))
            else:
                raise Refused(f"{path}: {name!r:.60} is a named type, which no archive has")
        if len(variables) > MOST_VARIABLES:
            raise Refused(
                f"{path:.200}: {len(variables)} variables; an archive has at most {MOST_VARIABLES} in a group"
            )
        for name, dataset in variables:
            if self._plain(dataset, b"CLASS") == b"DIMENSION_SCALE":
                name = name.removeprefix(_NOT_ITS_DIMENSION)
                self.names[self._address(dataset)] = name
                number = self._plain(dataset, b"_Netcdf4Dimid")
                if number is not None and not isinstance(number, bytes) and number.size == 1:
                    self.numbers[int(number.ravel()[0])] = name
        return inner, variables

    def _first_visit(self, thing, what):
        # a second name of one thing makes more of it than the file holds, or a circle
        address = self._address(thing)
        if address in self.seen:
            raise Refused(f"{what:.200} has two names in the file; in an archive everything has one")
        self.seen.add(address)

    def _address(self, thing):
        return h5py.h5o.get_info(thing).addr

    def _name(self, raw, path):
        try:
            name = raw.decode("utf-8")
        except UnicodeDecodeError:
            raise Refused(f"{path:.200}: a name is not text: {raw!r:.60}") from None
        # what is listed a line each must not make lines of its own
        if any(letter < " " or letter == "\x7f" for letter in name):
            raise Refused(f"{path:.200}: {name!r:.60} holds a control character, which no name of NetCDF does")
        return name

    def _check_storage(self, dataset, what):
        """Refuse what takes its values from another file, or by a program of its own."""
        made = dataset.get_create_plist()
        if made.get_layout() == h5py.h5d.VIRTUAL:
            raise Refused(f"{what:.200} is composed of other files (virtual dataset); an archive holds its data itself")
        if made.get_external_count():
            raise Refused(f"{what:.200} is stored in another file; an archive holds its data itself")
        for place in range(made.get_nfilters()):
            number = made.get_filter(place)[0]
            if number not in FILTERS:
                raise Refused(
                    f"{what:.200} is compressed by filter {number}; archives use deflate. If you trust the file, "
                    "rewrite it by 'nccopy -d4 FILE NEW'"
                )

    def _described(self, dataset, name, path):
        """A variable and its description, which precedes its values; None for a dimension without a variable."""
        what = f"{path}: {name}"
        scale = self._plain(dataset, b"CLASS") == b"DIMENSION_SCALE"
        title = self._plain(dataset, b"NAME")
        if scale and isinstance(title, bytes) and title.startswith(_NO_VARIABLE):
            return None
        space = dataset.get_space()
        if space.get_simple_extent_type() == h5py.h5s.NULL:
            raise Refused(f"{what:.200} has no values, not even an empty array")
        shape, kind = space.get_simple_extent_dims(), self._kind(dataset.get_type(), what)
        name = name.removeprefix(_NOT_ITS_DIMENSION)
        head = {
            "variable": name,
            "dimensions": self._dimensions(dataset, name, len(shape), scale, what),
            "type": kind,
            "shape": shape,
            "attributes": self._attributes(dataset, what),
        }
        self._count(dataset, head, what)
        return dataset, head

    def _kind(self, stored, what):
        """The type of the values of a variable: "text", or a number's in the writing of numpy."""
        if stored.get_class() == h5py.h5t.STRING:
            if stored.is_variable_str():
                return TEXT
            if stored.get_size() == 1:
                return "S1"
        elif stored.get_class() in (h5py.h5t.INTEGER, h5py.h5t.FLOAT):
            number = stored.dtype
            if number.kind + str(number.itemsize) in ("i1", "i2", "i4", "i8", "u1", "u2", "u4", "u8", "f4", "f8"):
                return number.kind + str(number.itemsize)
        raise Refused(f"{what:.200} holds neither texts nor numbers of 1, 2, 4 or 8 bytes")

    def _dimensions(self, dataset, name, rank, scale, what):
        if rank > MOST_DIMENSIONS:
            raise Refused(f"{what:.200} has {rank} dimensions")
        if h5py.h5a.exists(dataset, b"_Netcdf4Coordinates"):
            given = self._plain(dataset, b"_Netcdf4Coordinates")
            if given is not None and not isinstance(given, bytes) and given.size == rank:
                found = [self.numbers.get(int(number)) for number in given.ravel()]
                if None not in found:
                    return found
        if scale and rank == 1:
            return [name]
        if rank == 0:
            return []
        found = []
        for entry in self._references(dataset, rank, what):
            if len(entry) < 1:
                raise Refused(f"{what:.200}: a dimension has no name; it was not written as NetCDF")
            # the first of several scales is the dimension
            scale = h5py.h5r.dereference(entry[0], self.file)
            known = None if scale is None else self.names.get(self._address(scale))
            if known is None:
                raise Refused(f"{what:.200}: a dimension is not defined in the file")
            found.append(known)
        return found

    def _references(self, dataset, rank, what):
        lacking = Refused(f"{what:.200}: its dimensions have no names; it was not written as NetCDF")
        if not h5py.h5a.exists(dataset, b"DIMENSION_LIST"):
            raise lacking
        listed = h5py.h5a.open(dataset, b"DIMENSION_LIST")
        if listed.shape != (rank,) or listed.get_type().get_class() != h5py.h5t.VLEN:
            raise lacking
        if listed.get_type().get_super().get_class() != h5py.h5t.REFERENCE:
            raise lacking
        entries = np.empty(rank, dtype=h5py.vlen_dtype(h5py.ref_dtype))
        listed.read(entries)
        return entries

    def _plain(self, thing, name):
        """A hidden attribute: bytes, an array of numbers, or None."""
        if not h5py.h5a.exists(thing, name):
            return None
        attribute = h5py.h5a.open(thing, name)
        kind, shape = attribute.get_type(), attribute.shape
        if shape is None or prod(shape) > MOST_DIMENSIONS:
            return None
        if kind.get_class() == h5py.h5t.INTEGER:
            found = np.empty(shape, "i8")
            attribute.read(found, mtype=h5py.h5t.py_create(found.dtype))
            return found
        if (
            kind.get_class() == h5py.h5t.STRING
            and not kind.is_variable_str()
            and kind.get_size() < 1000
            and shape == ()
        ):
            found = np.empty((), f"S{kind.get_size()}")
            attribute.read(found, mtype=kind)
            return bytes(found[()]).rstrip(b"\0")
        return None

    def _attributes(self, thing, what):
        """Names and values of attributes, in their order."""
        count = h5py.h5a.get_num_attrs(thing)
        if count > MOST_ATTRIBUTES:
            raise Refused(f"{what:.200} has {count} attributes; an archive has at most {MOST_ATTRIBUTES}")
        names: list[bytes] = []
        made = thing.get_create_plist()
        tracked = made.get_attr_creation_order() & h5py.h5p.CRT_ORDER_TRACKED
        order = {"index_type": h5py.h5.INDEX_CRT_ORDER} if tracked else {}
        try:
            h5py.h5a.iterate(thing, names.append, **order)
        except Exception:
            if not tracked:
                raise
            names.clear()
            h5py.h5a.iterate(thing, names.append)
        return [
            [name, *self._value(h5py.h5a.open(thing, raw), f"{what:.200}: the attribute {name!r:.60}")]
            for raw, name in ((raw, self._name(raw, what)) for raw in names if raw not in _HIDDEN)
        ]

    def _value(self, attribute, what):
        """An attribute: "text" and a list, or its type and its bytes in hexadecimal digits."""
        kind, shape = attribute.get_type(), attribute.shape
        count = 0 if shape is None else prod(shape)
        if kind.get_class() == h5py.h5t.STRING and not kind.is_variable_str():
            self._describe(count * kind.get_size(), what)
            if count == 0:
                return [TEXT, [""]]
            found = np.empty(shape, f"S{kind.get_size()}")
            attribute.read(found, mtype=kind)
            return [TEXT, [self._text(one) for one in found.ravel().tolist()]]
        if kind.get_class() == h5py.h5t.STRING:
            self._describe(16 * count, what)
            found = np.empty(count if shape is None else shape, dtype=h5py.string_dtype())
            if count:
                attribute.read(found, mtype=h5py.h5t.py_create(found.dtype))
            texts = [self._text(one) for one in found.ravel().tolist()]
            self._describe(sum(map(len, texts)), what)
            return [TEXT, texts]
        number = self._kind(kind, what)
        found = np.empty(0 if shape is None else shape, number)
        self._describe(2 * found.nbytes, what)
        if count:
            attribute.read(found, mtype=h5py.h5t.py_create(found.dtype))
        return [number, found.tobytes().hex()]

    def _describe(self, size, what):
        self.described += size
        if self.described > FREE_BYTES:
            raise Refused(f"{what:.300}: the attributes of the file take more than {told(FREE_BYTES)}")

    def _text(self, raw):
        if isinstance(raw, bytes):
            return raw.decode("utf-8", "replace").replace("\0", "")
        return "" if raw is None or raw == 0 else str(raw)

    def _count(self, dataset, head, what):
        """Refuse sizes that are declared far beyond the contents of a file."""
        shape, kind = head["shape"], head["type"]
        each = 16 if kind == TEXT else int(kind[1:])
        # what has a mark of missing values, or a scale, becomes doubles
        wide = 8 if kind[0] in "iu" and _SCALED & {name for name, *_ in head["attributes"]} else each
        whole = prod(shape)
        self.declared += whole * max(wide, each)
        if self.declared > self.allowed:
            self._too_large(what, shape)
        made = dataset.get_create_plist()
        if made.get_layout() == h5py.h5d.CHUNKED:
            chunk = made.get_chunk()
            if (size := each * prod(chunk)) > LARGEST_CHUNK:
                raise Refused(f"{what:.200} has chunks of {told(size)}; an archive has at most {told(LARGEST_CHUNK)}")
            chunks = prod(-(-length // part) for length, part in zip(shape, chunk, strict=True))
            self.missing += max(0, chunks - dataset.get_num_chunks()) * size if whole else 0
        elif whole and dataset.get_storage_size() < whole * each:
            self.missing += whole * each
        if self.missing > FREE_BYTES:
            raise Refused(
                f"{what:.200}, of the shape {tuple(shape)!s:.100}: more than {told(FREE_BYTES)} were never written; "
                "the file is damaged, or no archive"
            )

    def _too_large(self, what, shape):
        raise Refused(
            f"{what:.200} is declared with the shape {tuple(shape)!s:.100}; with what precedes it, that is more than "
            f"the {told(self.allowed)} accepted from a file of {self.size} bytes. If you trust the file, read it with "
            "plain xarray"
        )

    def _values(self, dataset, head):
        shape, text = head["shape"], head["type"] == TEXT
        self._longest = 0
        if prod(shape) == 0:
            return
        if not shape:
            self._send(dataset, h5py.h5s.ALL, h5py.h5s.ALL, (), head)
            return
        made = dataset.get_create_plist()
        chunk = made.get_chunk() if made.get_layout() == h5py.h5d.CHUNKED else None
        each, most = (1, TEXTS) if text else (np.dtype(head["type"]).itemsize, BLOCK)
        axis, rows = _blocks(shape, each, None if text else chunk, most)
        inner = shape[axis + 1 :]
        for index in product(*map(range, shape[:axis])):
            start = 0
            while start < shape[axis]:
                count = min(rows, shape[axis] - start)
                self._slab(dataset, (*index, start, *(0 for _ in inner)), (*(1 for _ in index), count, *inner), head)
                start += count
                if text and axis == len(shape) - 1 and self._longest <= SHORT:
                    rows = MANY_TEXTS
        self.declared += LETTER * prod(shape) * self._longest

    def _slab(self, dataset, start, count, head):
        space = dataset.get_space()
        space.select_hyperslab(start, count)
        self._send(dataset, h5py.h5s.create_simple(count), space, count, head)

    def _send(self, dataset, memory, space, shape, head):
        if head["type"] == TEXT:
            found = np.empty(shape, dtype=h5py.string_dtype())
            dataset.read(memory, space, found, mtype=h5py.h5t.py_create(found.dtype))
            texts = [self._text(one) for one in found.ravel().tolist()]
            self._longest = max(self._longest, *map(len, texts))
            if self.declared + LETTER * prod(head["shape"]) * self._longest > self.allowed:
                self._too_large(head["variable"], head["shape"])
            self.output.say(texts=texts)
            return
        found = np.empty(shape, head["type"])
        kind = dataset.get_type() if head["type"] == "S1" else h5py.h5t.py_create(found.dtype)
        dataset.read(memory, space, found, mtype=kind)
        self.output.give(found)


def _blocks(shape, each, chunk, most):
    """Along which axis, and in how many rows of it, values are read: in their order, about ``most`` at a time."""
    axis, below = 0, each * prod(shape[1:])
    while below > most and axis + 1 < len(shape):
        axis += 1
        below //= shape[axis]
    rows = max(1, most // below)
    if chunk and rows > chunk[axis]:
        rows -= rows % chunk[axis]
    return axis, rows


if __name__ == "__main__":
    sys.path[:] = sys.argv[1:]
    # the caller has no use for them
    import h5py
    import numpy as np

    serve(sys.stdin, Output(1))
