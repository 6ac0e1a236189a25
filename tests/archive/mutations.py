"""Archives that were mutated in many ways, and every command tried on them.

    python tests/archive/mutations.py ARCHIVE FOLDER FIRST LAST

makes the mutations FIRST to LAST - 1 of ARCHIVE in FOLDER, tries everything on each, and prints a line of JSON of it.
"""

import json
import random
import sys
import traceback
from contextlib import redirect_stderr, redirect_stdout
from hashlib import sha256
from io import StringIO
from pathlib import Path

import netCDF4
import numpy as np

CODE = "__import__('pathlib').Path({!r}).touch()"


def mutate(source, target, seed, trap):
    """Write the mutation of that number; returns what was done."""
    chance = random.Random(seed)
    way = WAYS[seed % len(WAYS)]
    target.write_bytes(source.read_bytes())
    told = way(target, chance, trap)
    return f"{way.__name__}: {told}"


def random_bytes(path, chance, trap):
    content = bytearray(path.read_bytes())
    count = chance.choice([1, 1, 5, 50, 500])
    reach = chance.choice([len(content), 2000, 50_000])
    for _ in range(count):
        content[chance.randrange(min(reach, len(content)))] = chance.randrange(256)
    path.write_bytes(content)
    return f"{count} among the first {reach}"


def truncated(path, chance, trap):
    content = path.read_bytes()
    keep = chance.randrange(len(content))
    path.write_bytes(content[:keep])
    return f"{keep} bytes left"


def overwritten(path, chance, trap):
    content = bytearray(path.read_bytes())
    start, length = chance.randrange(len(content)), chance.choice([16, 512, 8192])
    content[start : start + length] = chance.choice([bytes(length), b"\xff" * length, chance.randbytes(length)])
    path.write_bytes(content)
    return f"{length} from {start}"


def huge_dimensions(path, chance, trap):
    with netCDF4.Dataset(path, "a") as file:
        group = _group(file, chance)
        length = chance.choice([10**9, 10**12, 2**62])
        group.createDimension("huge", length)
        group.createVariable("huge", "f8", ("huge",), chunksizes=(1000,), zlib=True)
        if chance.random() < 0.5:
            group.createDimension("other", 10**6)
            group.createVariable("state_of_all", "f8", ("huge", "other"), chunksizes=(10, 10))
    return f"{length} in {group.path}"


def deep_nesting(path, chance, trap):
    depth = chance.choice([20, 200, 700])
    with netCDF4.Dataset(path, "a") as file:
        group = _group(file, chance)
        for _ in range(depth):
            group = group.createGroup("g")
        group.kind = "trajectory"
    return f"{depth} levels"


def wrong_attributes(path, chance, trap):
    told = []
    values = ["", "[" * 5000, CODE.format(str(trap)), "\u0000x", "💥" * 1000, 7, -1.5, float("nan"), [1, 2, 3]]
    with netCDF4.Dataset(path, "a") as file:
        for _ in range(chance.choice([1, 3, 10])):
            place = chance.choice([file, _group(file, chance), _group(file, chance)])
            if place.variables and chance.random() < 0.5:
                place = chance.choice(list(place.variables.values()))
            name = chance.choice([*place.ncattrs(), "units", "coordinates", "scale_factor", "missing_value", "kind"])
            value = chance.choice(values)
            if name != "_FillValue":
                place.setncattr(name, np.array(value) if isinstance(value, list) else value)
                told.append(f"{place.name}:{name} = {value!r:.40}")
    return "; ".join(told)


def wrong_variables(path, chance, trap):
    with netCDF4.Dataset(path, "a") as file:
        group = _group(file, chance)
        name = chance.choice(list(group.variables))
        group.renameVariable(name, "was_something_else")
        kind = chance.choice(["f8", "i1", str, "u8"])
        dims = tuple(chance.sample(list(group.dimensions), min(len(group.dimensions), chance.randrange(3))))
        variable = group.createVariable(name, kind, dims)
        if variable.size and kind is str:
            variable[...] = np.full(variable.shape, CODE.format(str(trap)), dtype=object)
        elif variable.size:
            variable[...] = chance.choice([0, 1, 100])
    return f"{group.path}/{name} is {kind} over {dims}"


def wrong_values(path, chance, trap):
    told = []
    with netCDF4.Dataset(path, "a") as file:
        for _ in range(chance.choice([1, 5, 20])):
            group = _group(file, chance)
            name = chance.choice(list(group.variables))
            variable = group[name]
            if not variable.size or variable.dtype is str:
                continue
            floats = variable.dtype.kind == "f"
            value = (
                chance.choice([np.nan, np.inf, -np.inf, 1e308, -1e-320, 0]) if floats else chance.choice([-128, 127])
            )
            variable.set_auto_mask(False)
            if chance.random() < 0.5:
                variable[...] = value
            else:
                variable[tuple(chance.randrange(length) for length in variable.shape)] = value
            told.append(f"{group.path}/{name} = {value}")
    return "; ".join(told)


def other_names(path, chance, trap):
    told = []
    with netCDF4.Dataset(path, "a") as file:
        group = _group(file, chance)
        if chance.random() < 0.5:
            name = chance.choice(list(group.dimensions))
            group.renameDimension(name, f"{name}_2")
        else:
            name = chance.choice(list(group.variables))
            group.renameVariable(name, f"{name}_2")
        told.append(f"{group.path}/{name}")
        if chance.random() < 0.5:
            file.renameGroup(group.name, chance.choice(["-o", "é", "a b"]))
    return "; ".join(told)


WAYS = (
    random_bytes,
    wrong_attributes,
    truncated,
    wrong_values,
    overwritten,
    wrong_variables,
    random_bytes,
    wrong_attributes,
    other_names,
    huge_dimensions,
    deep_nesting,
)


def _group(file, chance):
    return chance.choice(list(file.groups.values()))


def attempt(commands, arguments):
    """Exit code, or the traceback, of a command, with what it printed thrown away."""
    try:
        with redirect_stdout(StringIO()), redirect_stderr(StringIO()):
            return commands([str(argument) for argument in arguments])
    except BaseException:
        return traceback.format_exc()


def touched(path):
    """Groups that were altered, up to two of them; their pictures are those that may fail."""
    from chaosdrill.archive import open as open_archive
    from chaosdrill.archive.digest import altered
    from chaosdrill.errors import ArchiveError

    try:
        groups = [node for node in open_archive(path).subtree if "kind" in node.attrs and node.path != "/"]
    except ArchiveError:
        return []
    return [node.path for node in groups if altered(node.to_dataset(inherit=False)) != []][:2]


def main(source, folder, first, last):
    import resource

    from chaosdrill.archive import open as open_archive
    from chaosdrill.cli import main as commands
    from chaosdrill.scene import Scene

    # the scene itself need not be run five hundred times to compare with
    again = open_archive(source)
    Scene.run = lambda *_args, **_keywords: again
    resource.setrlimit(resource.RLIMIT_AS, (8 * 2**30, 8 * 2**30))
    for seed in range(first, last):
        place = folder / str(seed)
        place.mkdir()
        path, trap = place / "mutated.nc", folder / "trap"
        found = {"seed": seed, "done": "not made", "codes": {}}
        try:
            found["done"] = mutate(source, path, seed, trap)
        # the library refuses to make some of them
        except (RuntimeError, OSError, ValueError, TypeError, IndexError, AttributeError) as fault:
            found["done"] += f": {fault}"
        before = sha256(path.read_bytes()).hexdigest()
        print(json.dumps({"seed": seed, "begins": found["done"]}), flush=True)
        for command in ("info", "cite", "verify"):
            found["codes"][command] = attempt(commands, [command, path])
        for group in touched(path):
            pictures = ["-o", place / "picture.png", "--group", group]
            found["codes"][f"plot {group}"] = attempt(commands, ["plot", path, *pictures])
        found["lost"] = not path.exists() or sha256(path.read_bytes()).hexdigest() != before
        found["others"] = sorted(p.name for p in place.iterdir() if p.suffix != ".png" and p != path)
        found["trapped"] = trap.exists()
        found["memory"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024
        print(json.dumps(found), flush=True)
        for left in place.iterdir():
            left.unlink()


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]), int(sys.argv[3]), int(sys.argv[4]))
