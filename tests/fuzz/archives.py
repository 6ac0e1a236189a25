"""Spoilt archives: told of, cited, verified; some of them drawn, or made a page of.

An input is a recipe, so that it is short and can be read: which archive, what is changed in it, and whether it gets its
seal again, as whoever means harm would give it.
"""

import json
from contextlib import suppress
from importlib import import_module
from unittest.mock import patch
from zlib import crc32

import definitions
import judge
import netCDF4
import numpy as np
import scenes
import trees
from support.small_scenes import small_scene
from values import HOSTILE, OWNED

from chaosdrill.archive import open as open_archive
from chaosdrill.archive import save
from chaosdrill.archive.digest import LENGTH, altered, append_checksum
from chaosdrill.errors import ArchiveError
from chaosdrill.scene import parse_scene
from chaosdrill.workflow import run
from chaosdrill.workflow.run_scene import system_of

# the package has a function of that name
verifying = import_module("chaosdrill.workflow.verify")

name, ending = "archive", ".json"
SOUND = ("0", "0 0 0", "0 0 1")
DRAW_ONE_IN = 15
REPORT_ONE_IN = 120

SCENES = {
    "runs": ("motion", "spectrum"),
    "points": ("diagram", "basins"),
    "chart": ("chart", "section"),
    "orbits": ("orbit", "branch"),
    "precision": ("precision",),
}
BASES = {}
"""By name: bytes, and of every group its attributes, its variables and its dimensions."""

JSONS = ("definition", "parameters", "initial", "settings", "versions", "digests")
"""Attributes that hold JSON."""

RESULTS = {}
"""By name, what is taken where an input asks for it to be computed again."""


def prepare(folder):
    """Run the scenes once."""
    trees_of = {key: run(parse_scene(small_scene(*names), f"{key}.toml")) for key, names in SCENES.items()}
    # saved from Python, groups are computed again from their definitions
    trees_of["python"] = trees_of["runs"]["motion"].to_dataset()
    for key, tree in trees_of.items():
        path = save(tree, folder / f"{key}.nc")
        groups = {node.path: node.to_dataset(inherit=False) for node in open_archive(path).subtree}
        BASES[key] = (path.read_bytes(), {place: layout_of(ds) for place, ds in groups.items()})
    # what is loaded once is no fault of any input
    judge.command(["report", folder / "points.nc", "-o", folder / "page.html"], (0,))
    judge.command(["plot", folder / "points.nc", "-o", folder / "picture.png"], (0,))
    RESULTS.update(trees_of)


def layout_of(ds):
    """Attributes, variables and dimensions of a group."""
    return dict(ds.attrs), [str(v) for v in ds.variables], [str(d) for d in ds.sizes]


def _run(scene, **_):
    """What a scene has given, with another text."""
    found = RESULTS["runs"].copy()
    found.attrs |= {"scene": scene.text}
    return found


def _rerun(ds, **_):
    """What an analysis has given, once its system has been read."""
    system_of(ds)
    groups = (node for key in SCENES for node in RESULTS[key].children.values())
    return next(node.to_dataset() for node in groups if node.attrs["kind"] == ds.attrs["kind"])


def seeds(folder):
    """Archives as they are."""
    return [trees.written({"of": key, "sealed": sealed, "edits": []}) for key in BASES for sealed in (True, False)]


def attempt(data, folder, guard):
    """Try every command on an archive."""
    path = folder / "in" / "mutated.nc"
    recipe = json.loads(data)
    path.write_bytes(BASES[recipe["of"]][0])
    edit(path, recipe["edits"], recipe["sealed"])
    before = path.read_bytes()
    codes, wrong, turn = [], [], crc32(data)
    with (
        guard.watching(folder / "out"),
        patch.object(verifying, "compute", _run),
        patch.object(verifying, "rerun", _rerun),
    ):
        # what has no seal is first read by another process, which takes a while
        for command in ("info", "cite", "verify") if recipe["sealed"] else (("info", "cite", "verify")[turn % 3],):
            code, found = judge.command([command, path], (0, 1))
            codes.append(str(code))
            wrong += found
        if turn % DRAW_ONE_IN == 0:
            for group in _altered(path):
                wrong += judge.command(["plot", path, "-o", folder / "out" / "picture.png", "--group", group], (0, 1))[
                    1
                ]
        if turn % REPORT_ONE_IN == 0:
            page = folder / "out" / "page.html"
            wrong += judge.command(["report", path, "-o", page], (0, 1))[1]
            wrong += _loads(page) if page.exists() else []
    if path.read_bytes() != before:
        wrong.append("the archive was changed")
    return " ".join(codes), wrong


def _loads(page):
    """What a page would load, or run besides its own script."""
    from html.parser import HTMLParser

    wrong = []

    class Reader(HTMLParser):
        def handle_starttag(self, tag, attributes):
            for key, value in attributes:
                foreign = key in ("src", "href", "data", "action") and not (value or "").startswith(
                    ("data:image/", "data:,", "#")
                )
                if key.startswith("on") or foreign or tag in ("iframe", "object", "embed", "base", "form"):
                    wrong.append(f"the page has <{tag} {key}={value!r:.80}>")

    Reader().feed(page.read_text(encoding="utf-8"))
    return wrong


def _altered(path):
    """Groups that are not as they were, up to two of them; their pictures are those that may fail."""
    try:
        groups = [node for node in open_archive(path).subtree if "kind" in node.attrs and node.path != "/"]
    except ArchiveError:
        return []
    return [node.path for node in groups if altered(node.to_dataset(inherit=False)) != []][:2]


FAULTS = (RuntimeError, OSError, ValueError, TypeError, LookupError, AttributeError, ArithmeticError, MemoryError)


def edit(path, edits, sealed):
    """Change an archive; what the library refuses to write is passed over."""
    work = path.with_name("work.nc")
    content = path.read_bytes()
    work.write_bytes(content[:-LENGTH])
    in_bytes = [entry for entry in edits if entry["way"] in IN_BYTES]
    for entry in edits:
        if entry not in in_bytes:
            with suppress(*FAULTS), netCDF4.Dataset(work, "a") as file:
                BY_NAME[entry["way"]](file, entry)
    # the library is not to write into what it cannot read, and may still hold what it could not close
    content = bytearray(work.read_bytes())
    work.unlink()
    for entry in in_bytes:
        with suppress(*FAULTS):
            BY_NAME[entry["way"]](content, entry)
    path.write_bytes(content)
    if sealed:
        append_checksum(path)


def mutate(data, chance, other):
    """A recipe with one more change, one less, or another value in one."""
    recipe, given = json.loads(data), json.loads(other)
    layout = BASES[recipe["of"]]
    recipe["edits"] = trees.edited(recipe["edits"], chance, given["edits"], lambda: draw(chance, *layout))
    # bytes that are changed under a right seal may stop the library, and with it whoever trusts the seal
    in_bytes = any(entry["way"] in IN_BYTES for entry in recipe["edits"])
    recipe["sealed"] = not in_bytes and chance.random() < 0.9
    return trees.written(recipe)


def draw(chance, content, layout):
    """One change of an archive of that layout."""
    way = chance.choice(list(BY_NAME))
    place = chance.choice(list(layout))
    attributes, variables, dimensions = layout[place]
    variable = chance.choice(variables) if variables else None
    entry = {"way": way, "group": place}
    if way == "byte":
        reach = chance.choice([len(content), 2000, 50_000])
        return {
            "way": way,
            "at": [chance.randrange(reach) for _ in range(chance.choice([1, 1, 5, 50]))],
            "to": chance.randrange(256),
        }
    if way in ("cut", "fill"):
        fill = chance.choice([0, 255, 1])
        return {"way": way, "at": chance.randrange(len(content)), "length": chance.choice([16, 512, 8192]), "to": fill}
    if way == "attribute":
        name = chance.choice([*attributes, "units", "coordinates", "scale_factor", "missing_value", "kind", "calendar"])
        of = variable if chance.random() < 0.5 else None
        return entry | {"variable": of, "name": name, "to": _attribute(name, attributes.get(name), chance)}
    if way == "json":
        held = [key for key in JSONS if key in attributes]
        key = chance.choice(held or ["settings"])
        old = json.loads(attributes[key]) if held else {}
        return entry | {"name": key, "to": trees.mutated(old, chance)}
    if way == "variable":
        return entry | {
            "name": variable,
            "type": chance.choice(["f8", "i1", "str", "u8", "i8", "f4"]),
            "dimensions": chance.sample(dimensions, min(len(dimensions), chance.randrange(3))),
            "to": chance.choice([0, 1, 100, -1, f"__import__('{OWNED}')"]),
        }
    if way == "value":
        value = chance.choice([float("nan"), float("inf"), 1e308, -1e-320, 0, -128, 127, 2**31 - 1])
        return entry | {"name": variable, "at": chance.choice([None, chance.randrange(100)]), "to": value}
    if way == "rename":
        what = chance.choice(["variable", "dimension", "group", "attribute"])
        names = {"variable": variables, "dimension": dimensions, "group": [place], "attribute": list(attributes)}[what]
        old = chance.choice(names) if names else ""
        return entry | {
            "what": what,
            "name": old,
            "to": chance.choice([f"{old}_2", "-o", "é", "a b", "x", "kind", OWNED]),
        }
    if way == "remove":
        return entry | {"name": chance.choice(list(attributes)) if attributes else "kind"}
    if way == "huge":
        return entry | {"length": chance.choice([10**9, 10**12, 2**62]), "wide": chance.random() < 0.5}
    return entry | {"depth": chance.choice([3, 20, 200])}


def _attribute(name, old, chance):
    if name == "scene" and isinstance(old, str):
        return scenes.mutate(old.encode(), chance, old.encode()).decode(errors="replace").replace("\0", "")[:5000]
    if name == "definition" and isinstance(old, str) and chance.random() < 0.7:
        return definitions.mutate(old.encode(), chance, old.encode()).decode()
    values = ["", "[" * 5000, "\u0000x", "💥" * 1000, 7, -1.5, float("nan"), [1, 2, 3], 2**40, *HOSTILE]
    value = chance.choice(values)
    return value[:5000] if isinstance(value, str) else value


def _byte(content, entry):
    for place in entry["at"]:
        content[place % len(content)] = entry["to"] % 256


def _cut(content, entry):
    del content[entry["at"] % len(content) :]


def _fill(content, entry):
    at, length = entry["at"] % len(content), entry["length"] % 2**20
    content[at : at + length] = bytes([entry["to"] % 256]) * length


def _group(file, entry):
    return file if entry["group"] == "/" else file[entry["group"]]


def _set_attribute(file, entry):
    holder = _group(file, entry)
    if entry["variable"] is not None:
        holder = holder[entry["variable"]]
    if entry["name"] != "_FillValue":
        value = entry["to"]
        holder.setncattr(entry["name"], np.array(value) if isinstance(value, list) else value)


def _set_json(file, entry):
    _group(file, entry).setncattr(entry["name"], json.dumps(entry["to"]))


def _remove(file, entry):
    _group(file, entry).delncattr(entry["name"])


def _variable(file, entry):
    group = _group(file, entry)
    group.renameVariable(entry["name"], "was_something_else")
    kind = str if entry["type"] == "str" else entry["type"]
    variable = group.createVariable(entry["name"], kind, tuple(entry["dimensions"]))
    if variable.size > 10**6:
        return
    if kind is str:
        variable[...] = np.full(variable.shape, str(entry["to"]), dtype=object)
    elif not isinstance(entry["to"], str):
        variable[...] = entry["to"]


def _value(file, entry):
    variable = _group(file, entry)[entry["name"]]
    variable.set_auto_mask(False)
    values = variable[...]
    if entry["at"] is None:
        values[...] = entry["to"]
    else:
        values.reshape(-1)[entry["at"] % values.size] = entry["to"]
    variable[...] = values


def _rename(file, entry):
    group, what, old, new = _group(file, entry), entry["what"], entry["name"], entry["to"]
    if what == "variable":
        group.renameVariable(old, new)
    elif what == "dimension":
        group.renameDimension(old, new)
    elif what == "group":
        file.renameGroup(old.strip("/"), new)
    else:
        group.renameAttribute(old, new)


def _huge(file, entry):
    group = _group(file, entry)
    group.createDimension("huge", entry["length"])
    group.createVariable("huge", "f8", ("huge",), chunksizes=(1000,), zlib=True)
    if entry["wide"]:
        group.createDimension("other", 10**6)
        group.createVariable("state_of_all", "f8", ("huge", "other"), chunksizes=(10, 10))


def _deep(file, entry):
    group = _group(file, entry)
    for _ in range(min(entry["depth"], 1000)):
        group = group.createGroup("g")
    group.kind = "trajectory"


BY_NAME = {
    "byte": _byte,
    "cut": _cut,
    "fill": _fill,
    "attribute": _set_attribute,
    "json": _set_json,
    "remove": _remove,
    "variable": _variable,
    "value": _value,
    "rename": _rename,
    "huge": _huge,
    "deep": _deep,
}
IN_BYTES = ("byte", "cut", "fill")
