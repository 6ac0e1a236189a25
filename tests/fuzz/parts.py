"""Spoilt folders of finished parts, which a run is to go on with.

An input is a list of changes of the folder that an interrupted run has left.
"""

import json
import os
import shutil

import archives
import judge
import trees
from support.small_scenes import small_scene
from values import HOSTILE

from chaosdrill.analysis.grids.points import PointTask
from chaosdrill.archive import open as open_archive
from chaosdrill.workflow import compare

name, ending = "parts", ".json"
SOUND = ("0",)
ENDLESS = 2**40
"""Bytes of a file that is larger than any memory, and takes no room on the disk."""

LARGE = 10**7
"""Bytes of the largest file that is copied."""

SCENE = small_scene("spectrum", "diagram").replace("num = 4", "num = 16")
STOP_AT = 12
NAMES = ("_lock", "_scene.json", "spectrum", "diagram", "chart", "spectrum/result.nc")
NAMES += tuple(f"{group}/{name}" for group in ("diagram", "chart") for name in ("manifest.json", "0-1.chunk"))
NAMES += ("diagram/0-16.chunk", "other/result.nc", "other/0-1.chunk")
JSONS = ("_scene.json", "diagram/manifest.json")
PRECIOUS = b"of somebody else"
BASE = {}
LAYOUT = {}


def prepare(folder):
    """Run the scene whole, and until it is interrupted."""
    home = folder / "parts"
    home.mkdir()
    scene = home / "scene.toml"
    scene.write_text(SCENE)
    if any(judge.command(["run", scene, "-o", home / "whole.nc"], (0,))[1]):
        raise RuntimeError("the scene of the parts cannot be run")
    run = PointTask.run

    def stopping(self, first, count):
        if first + count > STOP_AT:
            raise KeyboardInterrupt
        return run(self, first, count)

    PointTask.run = stopping
    judge.command(["run", scene, "-o", home / "out.nc"], (130,))
    PointTask.run = run
    BASE["parts"] = home / "out.nc.parts"
    BASE["whole"] = open_archive(home / "whole.nc")
    LAYOUT["spectrum"] = {"/": archives.layout_of(open_archive(home / "whole.nc")["spectrum"].to_dataset())}


def seeds(folder):
    """The folder as it is."""
    return [trees.written([])]


def attempt(data, folder, guard):
    """Go on with a run."""
    edits = json.loads(data)
    output, other = folder / "out" / "out.nc", folder / "in" / "other"
    scene = folder / "in" / "scene.toml"
    scene.write_text(SCENE)
    other.mkdir()
    (other / "file").write_bytes(PRECIOUS)
    with (other / "endless").open("wb") as endless:
        endless.truncate(ENDLESS)
    parts = folder / "out" / "out.nc.parts"
    shutil.copytree(BASE["parts"], parts)
    for entry in edits:
        try:
            if _can_be_opened(parts / entry["file"]) and _can_be_opened(parts / entry.get("of", "")):
                BY_NAME[entry["way"]](parts, entry, other)
        # what an earlier change removed, or made very large, cannot be changed any more
        except (OSError, ValueError, TypeError, KeyError, IndexError, AttributeError, ArithmeticError, MemoryError):
            pass
    with guard.watching(folder / "out"):
        code, wrong = judge.command(["run", scene, "-o", output, "--resume", "--json"], (0, 1, 2))
    if output.exists() != (code == 0):
        wrong.append(f"exit code {code}, and the archive says otherwise")
    if code == 0:
        if os.path.lexists(parts):
            wrong.append("the parts are still there")
        forged = any(entry["way"] == "forge" for entry in edits)
        if not forged and (found := compare(open_archive(output), BASE["whole"])):
            wrong.append(f"another archive: {found[0]}")
    if sorted(os.listdir(other)) != ["endless", "file"] or (other / "file").read_bytes() != PRECIOUS:
        wrong.append("a file was changed that does not belong to it")
    if (other / "endless").stat().st_size != ENDLESS:
        wrong.append("a large file was changed that does not belong to it")
    left = {path.name for path in (folder / "out").iterdir()} - {"out.nc", "out.nc.parts"}
    if left:
        wrong.append(f"left {sorted(left)}")
    return str(code), wrong


def _can_be_opened(path):
    """Whether what an earlier change has put there does not make this process wait, or lead to other files."""
    return not path.is_fifo() and not any(part.is_symlink() for part in (path, path.parent))


def mutate(data, chance, other):
    """A list with one more change, one less, or another value in one."""
    return trees.written(trees.edited(json.loads(data), chance, json.loads(other), lambda: draw(chance)))


def draw(chance):
    """One change of the folder."""
    way = chance.choice(list(BY_NAME))
    entry = {"way": way, "file": chance.choice(NAMES)}
    if way == "bytes":
        return entry | {"at": chance.randrange(100_000), "to": chance.randbytes(chance.choice([1, 1, 8, 200])).hex()}
    if way == "cut":
        return entry | {"length": chance.randrange(5000)}
    if way == "text":
        texts = ["", "{", "[" * 100_000, "null", "[]", '{"analysis": {}}', "1" * 5000]
        texts += HOSTILE
        return entry | {"to": chance.choice(texts)[:100_000]}
    if way == "chunk":
        first, count = (chance.choice([0, 1, 1, 2, 8, 15, 16, 10**6, 2**60]) for _ in range(2))
        name = chance.choice([f"{first}-{count}.chunk", f"-{first}-{count}.chunk", f"0{first}-{count}.chunk", ".chunk"])
        return {
            "way": way,
            "file": f"{chance.choice(['diagram', 'chart'])}/{name}",
            "length": chance.choice([0, 31, 32, 33, 500, count * 1000]) % LARGE,
        }
    if way == "json":
        return {"way": way, "file": chance.choice(JSONS), "tree": _changes(chance)}
    if way == "link":
        to = chance.choice(["file", "endless", "", "missing", ".", "../scene.toml"])
        return entry | {"to": to, "hard": chance.random() < 0.3}
    if way == "copy":
        return entry | {"of": chance.choice(NAMES)}
    if way == "grow":
        return entry | {"size": chance.choice([10**7, 2**28, ENDLESS])}
    if way == "forge":
        content = (BASE["parts"] / "spectrum" / "result.nc").read_bytes()
        # bytes under a right digest do to whoever trusts it what they do to the library
        edits = [archives.draw(chance, content, LAYOUT["spectrum"]) for _ in range(chance.choice([1, 1, 2]))]
        return {
            "way": way,
            "file": "spectrum/result.nc",
            "edits": [edit for edit in edits if edit["way"] not in archives.IN_BYTES],
        }
    return entry


def _changes(chance):
    """Keys, and what they are to lead to."""
    keys = ["analysis", "diagram", "spectrum", "system", "versions", "kind", "format", "units", "columns"]
    keys += ["points_per_unit", "fingerprint", "section", 0, 1]
    return [
        [chance.sample(keys, chance.choice([1, 1, 2, 3])), trees.value(chance)] for _ in range(chance.choice([1, 2]))
    ]


def _put(parts, entry, other):
    path = parts / entry["file"]
    content = bytearray(path.read_bytes())
    at, new = entry["at"] % (len(content) + 1), bytes.fromhex(entry["to"])
    content[at : at + len(new)] = new
    path.write_bytes(content)


def _cut(parts, entry, other):
    os.truncate(parts / entry["file"], entry["length"])


def _text(parts, entry, other):
    (parts / entry["file"]).parent.mkdir(exist_ok=True)
    (parts / entry["file"]).write_text(entry["to"], encoding="utf-8", errors="replace")


def _chunk(parts, entry, other):
    path = parts / entry["file"]
    path.parent.mkdir(exist_ok=True)
    path.write_bytes(bytes(entry["length"] % LARGE))


def _json(parts, entry, other):
    path = parts / entry["file"]
    tree = json.loads(path.read_text())
    for keys, value in entry["tree"]:
        holder = tree
        for key in keys[:-1]:
            holder = holder[key] if key in holder else holder.setdefault(key, {})
        holder[keys[-1]] = value
    path.write_text(json.dumps(tree))


def _remove(parts, entry, other):
    path = parts / entry["file"]
    shutil.rmtree(path) if path.is_dir() and not path.is_symlink() else path.unlink()


def _link(parts, entry, other):
    _vacate(parts, entry, other)
    make = os.link if entry["hard"] and entry["to"] in ("file", "endless") else os.symlink
    make(other / entry["to"], parts / entry["file"])


def _folder(parts, entry, other):
    _vacate(parts, entry, other)
    (parts / entry["file"]).mkdir(parents=True)


def _pipe(parts, entry, other):
    _vacate(parts, entry, other)
    os.mkfifo(parts / entry["file"])


def _copy(parts, entry, other):
    of = parts / entry["of"]
    if any(path.stat().st_size > LARGE for path in (of, *of.rglob("*"))):
        return
    _vacate(parts, entry, other)
    (shutil.copytree if of.is_dir() else shutil.copy)(of, parts / entry["file"])


def _grow(parts, entry, other):
    with (parts / entry["file"]).open("r+b") as file:
        file.truncate(entry["size"] % (ENDLESS + 1))


def _extra(parts, entry, other):
    path = parts / entry["file"]
    path = path if path.is_dir() else path.parent
    (path / "extra").mkdir(exist_ok=True)
    (path / "extra" / "file").write_text("extra")


def _elsewhere(parts, entry, other):
    """All of it behind a link."""
    shutil.rmtree(parts)
    parts.symlink_to(other, target_is_directory=True)


def _forge(parts, entry, other):
    """A result that is another one, with its right checksum."""
    archives.edit(parts / "spectrum" / "result.nc", entry["edits"], sealed=True)


def _vacate(parts, entry, other):
    (parts / entry["file"]).parent.mkdir(exist_ok=True)
    if os.path.lexists(parts / entry["file"]):
        _remove(parts, entry, other)


BY_NAME = {
    "bytes": _put,
    "cut": _cut,
    "text": _text,
    "chunk": _chunk,
    "json": _json,
    "remove": _remove,
    "link": _link,
    "folder": _folder,
    "pipe": _pipe,
    "copy": _copy,
    "grow": _grow,
    "extra": _extra,
    "elsewhere": _elsewhere,
    "forge": _forge,
}
