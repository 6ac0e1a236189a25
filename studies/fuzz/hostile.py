"""Hostile HDF5: archives that are well formed as files, and built to harm their reader.

    python studies/fuzz/hostile.py [FILES] [--hours H] [--seed K]

makes FILES files (default 2000), or as many as the time allows. Each is a sound archive with one to four of the
`harms`: links, references, types, sizes, filters and attributes; half of them are sealed by a right checksum line. Each
is opened in a process that may take a gigabyte and a minute of processor time. What may happen is an archive or an
`ArchiveError`; what may not is any other exception, a process that dies, a minute of work, a minute in which it waits
for anything but a processor, a gigabyte, a byte of the file beside it, or a change of that. Writes
``studies/fuzz/out/hostile.md``; what went wrong is kept beside it. The exit code is 1 if anything did.
"""

import argparse
import os
import random
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import opener
from harms import build

OUT = Path(__file__).resolve().parent / "out"


def class_of(outcome: str) -> str:
    """The kind of an outcome, without names and numbers."""
    words = [
        "link to another", "two names", "virtual dataset", "stored in another file", "were never written",
        "is declared with", "has chunks of", "by filter", "neither texts nor numbers", "named type",
        "not written as NetCDF", "a dimension", "groups deep", "attributes", "variables; an archive", "has no values",
        "a name is not text", "control character", "dimensions", "more memory than", "has no end", "crashes",
        "to its end", "not an archive", "format ", "more than 10000 groups",
    ]  # fmt: skip
    if not outcome.startswith("refused"):
        return outcome[:60]
    return next((f"refused: {word.strip()}" for word in words if word in outcome), "refused: damaged otherwise")


def small() -> Any:
    """What an archive holds, made by hand: numbers, codes, texts and a group within a group."""
    import xarray as xr

    times, about = np.linspace(0.0, 1.0, 50), {"units": "1", "long_name": "any", "comment": "made by hand"}
    codes = {"flag_values": np.arange(3, dtype="i1"), "flag_meanings": "none one two", "units": "1"}
    one = xr.Dataset(
        {
            "states": (("time", "state"), np.outer(times, [1.0, -1.0]), about),
            "mode": ("time", np.zeros(50, "i1"), codes),
            "count": ((), 3, about),
        },
        {"time": ("time", times, about), "state": ("state", ["x", "v"])},
        {"kind": "trajectory", "settings": "{}", "definition": "{}", "format_version": 2},
    )
    return xr.DataTree.from_dict({"/": xr.Dataset(attrs={"title": "small"}), "motion": one, "motion/again": one})


def run(home: Path, files: int, seconds: float | None, seed: int, keep: Path) -> dict[str, Any]:
    """Try files.

    Returns
    -------
    dict
        Counts ``files``, ``outcomes`` and ``harms``, ``wrong`` (lines), the ``slowest`` and the ``largest``.
    """
    import chaosdrill as cd

    sound = cd.save(small(), home / "sound.nc").read_bytes()
    # what every process has loaded already
    cd.open(home / "sound.nc")
    other = home / "other.h5"
    with h5py.File(other, "w") as file:
        file["secret"] = np.frombuffer(opener.SECRET.encode(), "u1")
    os.mkfifo(home / "pipe")
    before = other.read_bytes()
    outcomes: Counter[str] = Counter()
    harms: Counter[str] = Counter()
    wrong: list[str] = []
    slowest, largest, count, begun = 0.0, 0, 0, time.monotonic()
    path, opening = home / "hostile.nc", opener.Opener()
    while count < files if seconds is None else time.monotonic() - begun < seconds:
        chance = random.Random(f"{seed}-{count}")
        done = build(path, sound, chance, other)
        outcome, took, size = opening.open(path)
        if other.read_bytes() != before:
            outcome = "WRONG: changes another file"
        harms.update(done)
        outcomes[class_of(outcome)] += 1
        slowest, largest = max(slowest, took), max(largest, size)
        if outcome.startswith("WRONG"):
            wrong.append(f"{seed}-{count} ({', '.join(done)}): {outcome}")
            (keep / f"hostile-{seed}-{count}.nc").write_bytes(path.read_bytes())
        count += 1
        if count % 20 == 0:
            print(f"{count} files, {len(wrong)} wrong, slowest {slowest:.1f} s", file=sys.stderr, flush=True)
    opening.close()
    return {
        "files": count,
        "outcomes": outcomes,
        "harms": harms,
        "wrong": wrong,
        "slowest": slowest,
        "largest": largest,
    }


def main() -> int:
    """Try the files, write the table, and return 1 if anything went wrong."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", type=int, nargs="?", default=2000, help="files in all (default 2000)")
    parser.add_argument("--hours", type=float, help="as many as can be tried in that time, instead")
    parser.add_argument("--seed", type=int, default=0, help="number that the random generators start from")
    given = parser.parse_args()
    OUT.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="hostile-") as name:
        found = run(Path(name).resolve(), given.files, given.hours and 3600 * given.hours, given.seed, OUT)
    text = f"{found['files']} files, {len(found['wrong'])} wrong, "
    text += f"the slowest {found['slowest']:.1f} s of processor time, "
    text += f"the largest {found['largest'] / 2**20:.0f} MB\n\n| outcome | files |\n| --- | --- |\n"
    text += "".join(f"| {outcome} | {number} |\n" for outcome, number in found["outcomes"].most_common())
    text += "\n| harm | files |\n| --- | --- |\n"
    text += "".join(f"| {outcome} | {number} |\n" for outcome, number in sorted(found["harms"].items()))
    text += "".join(f"\n{line}\n" for line in found["wrong"])
    (OUT / "hostile.md").write_text(text, encoding="utf-8")
    print(text)
    return 1 if found["wrong"] else 0


if __name__ == "__main__":
    sys.exit(main())
