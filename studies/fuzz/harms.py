"""Ways to do harm with an HDF5 file: links, references, types, sizes, filters, attributes and altered bytes."""

import gzip
import os
import random
import re
import signal
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from chaosdrill.archive.digest import append_checksum

MOST_HARMS = 4
MOST_SEALED = 2**30
"""Bytes of a file that gets a checksum: holes of terabytes would take hours to read."""

BUILDING_S = 10
LAST = [
    "nest",
    "link_exponentially",
    "store_elsewhere",
    "compose",
    "refer",
    "bytes_of_it",
    "bytes_of_an_index",
    "exchange",
]
"""What is done to a file at its end, in this order."""
Chance = random.Random
Harm = Callable[[h5py.File, Chance, Path], None]
HARMS: dict[str, Harm] = {}


def harm(function: Harm) -> Harm:
    """Enter a way to do harm."""
    HARMS[function.__name__] = function
    return function


def group_of(file: h5py.File, chance: Chance) -> h5py.Group:
    """Any group."""
    found = [file["/"]]
    file.visititems(lambda _, item: found.append(item) if isinstance(item, h5py.Group) else None)
    return chance.choice(found)


def variable_of(file: h5py.File, chance: Chance) -> h5py.Dataset:
    """Any variable or dimension."""
    found: list[h5py.Dataset] = []
    file.visititems(lambda _, item: found.append(item) if isinstance(item, h5py.Dataset) else None)
    return chance.choice(found)


def thing_of(file: h5py.File, chance: Chance) -> h5py.Group | h5py.Dataset:
    """Any group or variable."""
    return chance.choice([group_of, variable_of])(file, chance)


def name_in(group: h5py.Group, chance: Chance) -> str:
    """A name that is free."""
    letters = ["more", "data", "x", "kind", "\u202e", "\x1b[2J", "é", "a" * 300, "_nc4_non_coord_x", "..", " "]
    name = chance.choice(letters)
    while name in group or name in (".", ".."):
        name += chance.choice("abcdefgh")
    return name


def length(chance: Chance) -> int:
    """A length, often none that a file has room for."""
    return chance.choice([0, 1, 3, 1000, 10**6, 2**20, 2**31, 2**40, 2**62])


def variable(file: h5py.File, chance: Chance, shape: tuple[int, ...], dtype: Any, **how: Any) -> h5py.Dataset:
    """A variable with dimensions, as NetCDF has it."""
    group = group_of(file, chance)
    made = group.create_dataset(name_in(group, chance), shape, dtype, **how)
    for axis, size in enumerate(shape):
        name = f"n{size}"
        if name not in group:
            chunks = (max(1, min(size, 1000)),)
            scale = group.create_dataset(name, (size,), "f4", chunks=chunks)
            scale.make_scale(f"This is a netCDF dimension but not a netCDF variable{size:10d}")
        if isinstance(group[name], h5py.Dataset):
            made.dims[axis].attach_scale(group[name])
    return made


@harm
def link_elsewhere(file: h5py.File, chance: Chance, other: Path) -> None:
    """A soft or an external link: to itself, to nothing, to another file, to a pipe."""
    group = group_of(file, chance)
    targets = [str(other), str(other.with_name("pipe")), "/dev/zero", "/dev/stdin", file.filename, "none.h5"]
    soft = h5py.SoftLink(chance.choice(["/", ".", "..", group.name, "/none", "more"]))
    group[name_in(group, chance)] = chance.choice([soft, h5py.ExternalLink(chance.choice(targets), "/")])


@harm
def link_again(file: h5py.File, chance: Chance, other: Path) -> None:
    """A second name of a group or a variable, which may close a circle."""
    group = group_of(file, chance)
    group[name_in(group, chance)] = thing_of(file, chance)


@harm
def link_exponentially(file: h5py.File, chance: Chance, other: Path) -> None:
    """Groups that each hold the one before twice."""
    level = group_of(file, chance)
    for i in range(chance.choice([8, 30, 60])):
        deeper = file.create_group(f"level{i}_{chance.randrange(10**6)}")
        deeper["one"], deeper["two"] = level, level
        level = deeper


@harm
def store_elsewhere(file: h5py.File, chance: Chance, other: Path) -> None:
    """Values in another file, in a pipe or a device."""
    place = chance.choice(
        [str(other), other.name, str(other.with_name("pipe")), "/dev/zero", "/dev/stdin", "/proc/self/mem"]
    )
    size = chance.choice([1, 4, 1000])
    variable(file, chance, (size,), "u1", external=[(place, chance.choice([0, 2**40]), size)])


@harm
def compose(file: h5py.File, chance: Chance, other: Path) -> None:
    """A virtual dataset, of another file or of itself."""
    group = group_of(file, chance)
    size = chance.choice([1, 16, 2**40])
    layout = h5py.VirtualLayout((size,), "u1", maxshape=(None,))
    source = chance.choice([str(other), str(other.with_name("pipe")), ".", "part%b.h5", "/dev/zero"])
    layout[:] = h5py.VirtualSource(source, "secret", (size,), maxshape=(None,))
    group.create_virtual_dataset(name_in(group, chance), layout)


@harm
def declare(file: h5py.File, chance: Chance, other: Path) -> None:
    """A variable far larger than the file."""
    shape = tuple(length(chance) for _ in range(chance.choice([1, 1, 2, 3])))
    chunks = tuple(max(1, min(size, chance.choice([1, 100, 2**20]))) for size in shape)
    limited = {} if chance.random() < 0.3 else {"chunks": chunks}
    made = variable(file, chance, shape, chance.choice(["u1", "f8", "i2"]), fillvalue=chance.choice([0, 1]), **limited)
    if all(shape) and chance.random() < 0.5 and limited:
        made[tuple(slice(0, 1) for _ in shape)] = 1


@harm
def compress(file: h5py.File, chance: Chance, other: Path) -> None:
    """A long constant, which takes a thousandth of its size."""
    size = chance.choice([10**5, 10**6, 10**7])
    many = chance.choice([1, 1, 1, 4, 60])
    made = variable(file, chance, (many, size), "u1", chunks=(1, size), compression="gzip", compression_opts=9)
    for i in range(many):
        made[i] = 0


@harm
def filtered(file: h5py.File, chance: Chance, other: Path) -> None:
    """Filters of other programs, or that do not fit the values."""
    made = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    made.set_chunk((10,))
    numbers = [1, 2, 3, 4, 5, 6, 305, 32000, 32001, 32015, 65535]
    for _ in range(chance.choice([1, 1, 3, 20])):
        made.set_filter(
            chance.choice(numbers), h5py.h5z.FLAG_OPTIONAL, tuple(chance.choice([0, 1, 9, 2**31]) for _ in range(3))
        )
    group = group_of(file, chance)
    space = h5py.h5s.create_simple((10,))
    name = name_in(group, chance).encode()
    dataset = h5py.h5d.create(group.id, name, h5py.h5t.IEEE_F64LE, space, made)
    dataset.write_direct_chunk((0,), chance.randbytes(chance.choice([1, 80, 5000])), chance.choice([0, 1]))


@harm
def typed(file: h5py.File, chance: Chance, other: Path) -> None:
    """Types that no archive has."""
    deep = np.dtype("f8")
    for i in range(chance.choice([1, 3, 30])):
        deep = np.dtype([(f"a{i}", deep), (f"b{i}", "i1")])
    kinds = [deep, h5py.vlen_dtype("f8"), h5py.vlen_dtype(h5py.vlen_dtype("u1")), h5py.ref_dtype, h5py.regionref_dtype]
    kinds += ["f2", "c16", "S1", "S7", "S100000", np.dtype("V9"), np.dtype(("f8", (100, 100)))]
    kinds += [h5py.enum_dtype({"a": 1, "b": 2}), h5py.string_dtype("ascii"), ">f8", ">i4", "u8", np.dtype("?")]
    kind = chance.choice(kinds)
    if chance.random() < 0.2:
        group = group_of(file, chance)
        group[name_in(group, chance)] = np.dtype(kind)
    elif chance.random() < 0.5:
        variable(file, chance, (chance.choice([0, 1, 5]),), kind)
    else:
        plain = [one for one in kinds if h5py.check_ref_dtype(np.dtype(one)) is None and np.dtype(one).kind != "O"]
        kind = chance.choice(plain)
        thing_of(file, chance).attrs.create(f"more{chance.randrange(100)}", np.zeros(2, kind), dtype=kind)


@harm
def floats(file: h5py.File, chance: Chance, other: Path) -> None:
    """Numbers whose bits stand where no machine has them."""
    kind = h5py.h5t.IEEE_F64LE.copy()
    kind.set_size(chance.choice([8, 16, 64]))
    kind.set_fields(chance.choice([63, 7, 40]), 52, chance.choice([1, 11]), 0, chance.choice([1, 40, 52]))
    group = group_of(file, chance)
    h5py.h5d.create(group.id, name_in(group, chance).encode(), kind, h5py.h5s.create_simple((3,)))


@harm
def refer(file: h5py.File, chance: Chance, other: Path) -> None:
    """Many entries that all refer to one long text."""
    count, size = chance.choice([(200_000, 50_000), (10**6, 10), (1000, 10**6), (3, 10**7)])
    made = variable(file, chance, (count,), h5py.string_dtype())
    made[0] = "x" * size
    place = made.id.get_offset()
    file.flush()
    with open(file.filename, "r+b") as raw:
        raw.seek(place)
        entry = raw.read(16)
        if chance.random() < 0.3:
            entry = bytes(byte ^ (chance.random() < 0.2) for byte in entry)
        raw.seek(place)
        raw.write(entry * count)


@harm
def name_dimensions(file: h5py.File, chance: Chance, other: Path) -> None:
    """Dimensions that are undefined, belong to others, or have another length."""
    made = variable_of(file, chance)
    way = chance.choice(["list", "class", "number", "coordinates", "name", "back"])
    if way == "list":
        target = thing_of(file, chance).ref if chance.random() < 0.8 else h5py.Reference()
        rank = chance.choice([made.ndim, 1, 5])
        values = np.empty(rank, object)
        for i in range(rank):
            values[i] = np.array([target] * chance.choice([0, 1, 3, 1000]), dtype=h5py.ref_dtype)
        made.attrs.create("DIMENSION_LIST", values, dtype=h5py.vlen_dtype(h5py.ref_dtype))
    elif way == "class":
        made.attrs["CLASS"] = np.bytes_(chance.choice([b"DIMENSION_SCALE", b"TABLE", b""]))
    elif way == "number":
        made.attrs["_Netcdf4Dimid"] = np.int32(chance.choice([-1, 0, 1, 2**31 - 1]))
    elif way == "coordinates":
        made.attrs["_Netcdf4Coordinates"] = np.array([chance.randrange(-1, 9) for _ in range(made.ndim or 1)], "i4")
    elif way == "name":
        made.attrs["NAME"] = np.bytes_(b"This is a netCDF dimension but not a netCDF variable")
    else:
        made.attrs["REFERENCE_LIST"] = np.zeros(10_000, "i8")


@harm
def attribute(file: h5py.File, chance: Chance, other: Path) -> None:
    """Attributes that decide how values are read, or what an archive is."""
    thing = thing_of(file, chance)
    names = "_FillValue missing_value scale_factor add_offset dtype _Unsigned units coordinates calendar flag_values"
    names += " flag_meanings kind scene definition settings digests versions format_version _NCProperties grid_mapping"
    names += " bounds compress Conventions history \x1b[2J"
    values = ["", "x", "bool", "true", "days since 1970-01-01", "\x1b]0;a\x07", "[" * 10_000, "{}", "1" * 5000, "é" * 9]
    values += [0, -1, 1e308, float("nan"), 2**62, np.zeros(0), np.zeros(3), np.arange(1000), np.int8(1), [1e300, 1]]
    name, value = chance.choice(names.split()), chance.choice(values)
    thing.attrs[name] = value


@harm
def attribute_many(file: h5py.File, chance: Chance, other: Path) -> None:
    """Attributes in great number, or large ones."""
    thing = thing_of(file, chance)
    if chance.random() < 0.5:
        for i in range(chance.choice([100, 3000])):
            thing.attrs[f"more{i}"] = i
    else:
        for i in range(chance.choice([1, 20])):
            thing.attrs[f"large{i}"] = np.full(8000, 1.0)
        thing.attrs.create("text", "x" * chance.choice([10, 10**6, 10**6, 7 * 10**7]), dtype=h5py.string_dtype())


@harm
def nest(file: h5py.File, chance: Chance, other: Path) -> None:
    """Groups deep in each other, or in great number."""
    group = group_of(file, chance)
    if chance.random() < 0.5:
        group.require_group("/".join(["deep"] * chance.choice([5, 15, 20, 500])))
    else:
        for i in range(chance.choice([50, 50, 2000, 12_000])):
            group.require_group(f"many{i}")


@harm
def many_variables(file: h5py.File, chance: Chance, other: Path) -> None:
    """More variables in a group than any archive has."""
    group = group_of(file, chance)
    for i in range(chance.choice([50, 1500])):
        group[f"scalar{i}"] = float(i)


@harm
def clash(file: h5py.File, chance: Chance, other: Path) -> None:
    """A group with the name of a variable's coordinate, a variable that is moved, renamed or removed."""
    made = variable_of(file, chance)
    way = chance.choice(["move", "remove", "empty", "scalar"])
    target = group_of(file, chance)
    if way == "move":
        target.move(made.name, f"{target.name.rstrip('/')}/{name_in(target, chance)}")
    elif way == "remove":
        del file[made.name]
    elif way == "empty":
        target.create_dataset(name_in(target, chance), data=h5py.Empty("f8"))
    else:
        target[name_in(target, chance)] = np.float64(1.0)


@harm
def bytes_of_it(file: h5py.File, chance: Chance, other: Path) -> None:
    """A few bytes anywhere."""
    file.flush()
    with open(file.filename, "r+b") as raw:
        size = raw.seek(0, os.SEEK_END)
        for _ in range(chance.choice([1, 3, 20])):
            raw.seek(chance.randrange(size))
            raw.write(chance.randbytes(chance.choice([1, 4])))


@harm
def index(file: h5py.File, chance: Chance, other: Path) -> None:
    """Chunks of a few bytes in each kind of index: trees, arrays that grow, fixed ones, none."""
    limits = chance.choice([(None,), (None, None), (4000,), (64, 64)])
    shape = tuple(size or chance.choice([40, 300] if len(limits) > 1 else [40, 20_000]) for size in limits)
    how = {"fillvalue": 1} if chance.random() < 0.5 else {"compression": "gzip"}
    made = variable(file, chance, shape, "u1", chunks=(1,) * len(shape), maxshape=limits, **how)
    step = chance.choice([1, 37])
    made[::step] = 2


@harm
def inflate(file: h5py.File, chance: Chance, other: Path) -> None:
    """Chunks that inflate to far more than they are declared to hold, once or filter upon filter."""
    count = chance.choice([1, 1, 2, 3, 12])
    made = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    made.set_chunk((1000,))
    for _ in range(count):
        made.set_deflate(9)
    name = name_in(group := group_of(file, chance), chance).encode()
    dataset = h5py.h5d.create(group.id, name, h5py.h5t.NATIVE_UINT8, h5py.h5s.create_simple((1000,)), made)
    data = bytes(chance.choice([1000, 10**6, 2 * 10**8]))
    for _ in range(count):
        data = zlib.compress(data, 9)
    dataset.write_direct_chunk((0,), data[: chance.choice([None, -1, 20])])


@harm
def compact(file: h5py.File, chance: Chance, other: Path) -> None:
    """Values within the header of a variable, or room for them that is taken early or late."""
    made = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    made.set_layout(chance.choice([h5py.h5d.COMPACT, h5py.h5d.CONTIGUOUS]))
    size = chance.choice([0, 1, 60_000, 10**6])
    name = name_in(group := group_of(file, chance), chance).encode()
    kind = chance.choice([h5py.h5t.NATIVE_UINT8, h5py.h5t.UNIX_D32LE, h5py.h5t.STD_B64BE, h5py.h5t.IEEE_F32BE])
    h5py.h5d.create(group.id, name, kind, h5py.h5s.create_simple((size,)), made)


@harm
def crowd(file: h5py.File, chance: Chance, other: Path) -> None:
    """A group whose names and attributes lie in heaps of their own."""
    parent = group_of(file, chance)
    group = parent.create_group(name_in(parent, chance), track_order=chance.random() < 0.5)
    for i in range(chance.choice([3, 300])):
        group.attrs[f"more{i}"] = "x" * chance.choice([1, 5000])
        if chance.random() < 0.3:
            group[f"scalar{i}"] = float(i)


@harm
def name_types(file: h5py.File, chance: Chance, other: Path) -> None:
    """Types with names that hold attributes of their own type, or of each other's, and of references to each other."""
    one, two = (f"type{chance.randrange(10**6)}" for _ in range(2))
    file[one], file[two] = np.dtype([("a", "f8"), ("b", h5py.ref_dtype)]), h5py.vlen_dtype(h5py.vlen_dtype("u1"))
    for at, of in chance.choice([[(one, one)], [(one, two), (two, one)], [("/", two), (two, two)]]):
        h5py.h5a.create(file[at].id, b"of", file[of].id, h5py.h5s.create_simple((chance.choice([1, 1000]),)))
    if chance.random() < 0.5:
        group_of(file, chance).create_dataset(f"typed{chance.randrange(100)}", (3,), file[one])


@harm
def attribute_of_a_type(file: h5py.File, chance: Chance, other: Path) -> None:
    """An attribute of a type that no archive has, with or without a value."""
    members = {f"m{i}" * chance.choice([1, 200]): i for i in range(chance.choice([1, 2000]))}
    deep = h5py.h5t.array_create(h5py.h5t.array_create(h5py.h5t.NATIVE_DOUBLE, (8,)), (8,) * chance.choice([1, 3]))
    kinds = [deep, h5py.h5t.vlen_create(h5py.h5t.vlen_create(h5py.h5t.NATIVE_UINT8)), h5py.h5t.STD_REF_DSETREG]
    kinds += [h5py.h5t.py_create(h5py.enum_dtype(members, "i4")), h5py.h5t.UNIX_D64BE, h5py.h5t.vlen_create(deep)]
    space = h5py.h5s.create(chance.choice([h5py.h5s.SCALAR, h5py.h5s.NULL]))
    h5py.h5a.create(thing_of(file, chance).id, b"typed", chance.choice(kinds), space)


@harm
def many_dimensions(file: h5py.File, chance: Chance, other: Path) -> None:
    """As many dimensions as HDF5 has, of length 1, 2 or 0."""
    group = group_of(file, chance)
    shape = tuple(chance.choice([1, 1, 1, 1, 2, 0]) for _ in range(chance.choice([5, 17, 32])))
    chunks = None if 0 in shape or chance.random() < 0.5 else tuple(1 for _ in shape)
    group.create_dataset(name_in(group, chance), shape, "u1", chunks=chunks)


@harm
def bytes_of_an_index(file: h5py.File, chance: Chance, other: Path) -> None:
    """Bytes of a heap, a tree or a header, which lead from one part of the file to the next."""
    file.flush()
    content = Path(file.filename).read_bytes()
    marks = [b"TREE", b"SNOD", b"HEAP", b"GCOL", b"FRHP", b"FHDB", b"FHIB", b"BTHD", b"BTLF", b"BTIN", b"OHDR", b"OCHK"]
    marks += [b"EAHD", b"EAIB", b"FAHD", b"FADB"]
    places = [found.start() for mark in marks for found in re.finditer(mark, content)]
    with open(file.filename, "r+b") as raw:
        for _ in range(chance.choice([1, 1, 5])):
            place = chance.choice(places) + chance.randrange(4, 60)
            raw.seek(place)
            # addresses that lead to themselves, to others, and beyond the end
            raw.write(
                chance.choice([chance.choice(places).to_bytes(8, "little"), b"\xff" * 4, bytes(4), chance.randbytes(1)])
            )


@harm
def exchange(file: h5py.File, chance: Chance, other: Path) -> None:
    """A file of another kind, or the same one behind a block of a user's or compressed."""
    path = Path(file.filename)
    content = path.read_bytes()
    counts = b"".join(chance.choice([0, 1, 2**31 - 1]).to_bytes(4, "big") for _ in range(6))
    made = [gzip.compress(content), bytes(512) + content, b"CDF\x01" + counts, b"CDF\x02" + counts * 40]
    made += [b"CDF\x05" + counts * 900, b"PK\x03\x04" + content, content[:8] + b"\x03" + content[9:], content * 2]
    path.write_bytes(chance.choice(made))


def build(path: Path, sound: bytes, chance: Chance, other: Path) -> list[str]:
    """Write a hostile file.

    Returns
    -------
    list of str
        The harms in it.
    """
    path.write_bytes(sound)
    chosen = [chance.choice(list(HARMS)) for _ in range(chance.randint(1, MOST_HARMS))]
    # h5py must open the file for the others, and may itself wait for a pipe
    chosen.sort(key=lambda name: LAST.index(name) if name in LAST else -1)
    told, telling = os.pipe()
    child = os.fork()
    if not child:
        signal.alarm(BUILDING_S)
        for name in chosen:
            try:
                with h5py.File(path, "r+", libver=chance.choice([None, "latest"])) as file:
                    HARMS[name](file, chance, other)
            # what an earlier harm has left may not take another
            except Exception:
                continue
            os.write(telling, f"{name} ".encode())
        os._exit(0)
    os.close(telling)
    with os.fdopen(told, encoding="utf-8") as pipe:
        done = pipe.read().split()
    os.waitpid(child, 0)
    if random.Random(chance.random()).random() < 0.5 and path.stat().st_size < MOST_SEALED:
        append_checksum(path)
    return done
