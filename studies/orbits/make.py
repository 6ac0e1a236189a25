"""Orbits of the drill and of the impact oscillator: branches, cascades, curves, and what simulations say of them.

    python studies/orbits/make.py [PART ...] [--docs] [--rounds N] [--keep]      (or: python3 studies/run.py orbits ...)

Parts (the first three if none is named):

    scenes     branches, cascades, curves, charts and diagrams, through the command line as a user would run them
    pictures   drawn from the archives
    confirm    special points held against simulations on both sides, and against a closed form
    cost       a branch beside the integration of its orbits (``--rounds``); ``--keep`` writes beside this script, too

Everything is written to ``studies/orbits/out/``; an archive that is already there is not made again. ``--docs`` writes
the page of the documentation and its pictures from the tables that are there. The exit code is 0 if everything agrees.
"""

import argparse
import csv
import datetime
import os
import platform
import shutil
import subprocess
import sys
import sysconfig
import time
from importlib.metadata import version
from pathlib import Path

import cascades
import cost
import xarray as xr
from confirm import confirm
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from reading import read

HERE = Path(__file__).resolve().parent
OUT = HERE / "out"
DOCS = HERE.parent.parent / "docs"
PARTS = ("scenes", "pictures", "confirm", "cost")
COMMAND = Path(sysconfig.get_path("scripts")) / "chaosdrill"
SCENES = {
    "branches": "branches",
    "period_two": "branches",
    "drill_cascade": "cascade",
    "drill_upward": "branches",
    "oscillator_cascade": "cascade",
    "curves_one": "",
    "curves_two": "",
}
"""Scenes, and the analysis of each that is drawn by itself."""

CURVES = (
    ("curves_one", "doubling_1"),
    ("curves_one", "grazing_1"),
    ("curves_two", "doubling_2"),
    ("curves_two", "grazing_2"),
    ("curves_two", "fold_2"),
)
"""Scenes and analyses of the picture of curves."""

PICTURES = (
    "branches",
    "branches-multipliers",
    "period_two",
    "drill_cascade",
    "drill_cascade-cascade",
    "drill_upward",
    "oscillator_cascade",
    "oscillator_cascade-cascade",
    "curves",
)
"""Pictures that the page shows."""


ENLARGED = {"drill_cascade": ((0.6238, 0.62383), (0.71, 0.757))}
"""Scenes whose picture has a second panel, and the part that it shows: parameter and state."""


def scenes() -> int:
    """Run every scene; return the exit code of the first that fails, else 0."""
    for number, scene in enumerate(SCENES, 1):
        say(f"[{number}/{len(SCENES)}] {scene}.toml")
        archive = OUT / f"{scene}.nc"
        if not archive.is_file():
            code = subprocess.call([str(COMMAND), "run", str(HERE / f"{scene}.toml"), "-o", str(archive)])
            if code:
                return code
    return 0


def pictures() -> int:
    """Draw branches over diagrams, cascades, and all curves over one chart."""
    from chaosdrill.plots.branches import branches, curves
    from chaosdrill.plots.orbits import cascade, multipliers
    from chaosdrill.plots.style import style

    with style():
        for scene, group in SCENES.items():
            if not group:
                continue
            found = read(OUT / f"{scene}.nc", group)
            diagram = read(OUT / f"{scene}.nc", "diagram")
            figure = enlarged(found, diagram, ENLARGED[scene]) if scene in ENLARGED else branches(found, over=diagram)
            figure.savefig(OUT / f"{scene}.png")
            multipliers(found).savefig(OUT / f"{scene}-multipliers.png")
            if group == "cascade":
                cascade(found).savefig(OUT / f"{scene}-cascade.png")
        drawn = [read(OUT / f"{scene}.nc", group) for scene, group in CURVES]
        curves(*drawn, over=read(OUT / "curves_one.nc", "chart")).savefig(OUT / "curves.png")
    return 0


def enlarged(found: xr.Dataset, diagram: xr.Dataset, part: tuple[tuple[float, float], ...]) -> Figure:
    """Branches over a diagram, and below them a part of both, which a frame shows above."""
    from chaosdrill.plots.branches import branches
    from chaosdrill.plots.figures import legend_outside, new_figure
    from chaosdrill.plots.markers import named_once

    (left, right), (low, high) = part
    figure = new_figure(8.4)
    above, below = figure.subplots(2, 1)
    for axes in (above, below):
        branches(found, over=diagram, ax=axes)
    above.get_legend().remove()
    below.get_legend().remove()
    below.set(xlim=(left, right), ylim=(low, high))
    below.ticklabel_format(axis="x", useOffset=False)
    above.set_xlabel("")
    frame = Rectangle(
        (left, low), right - left, high - low, fill=False, edgecolor="0.25", label="shown below", zorder=5
    )
    above.add_patch(frame)
    legend_outside(figure, named_once(above), handlelength=2.0)
    return figure


def confirmed() -> int:
    """Write all tables; return 1 if a simulation disagrees."""
    parts, agree = confirm(OUT)
    for name, text in {**cascades.tables(OUT), **parts}.items():
        (OUT / f"{name}.md").write_text(text, encoding="utf-8")
        print(f"## {name}\n\n{text}", flush=True)
    return 0 if agree else 1


def costs(rounds: int, keep: bool) -> int:
    """Measure on one core and write single measurements and the table made of them."""
    cores = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {max(cores)})
    rows = cost.measure(rounds, say)
    os.sched_setaffinity(0, cores)
    text = f"{cost.table(rows)}\n{machine()}\n"
    for folder in (OUT, HERE) if keep else (OUT,):
        with (folder / "cost.csv").open("w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, cost.COLUMNS)
            writer.writeheader()
            writer.writerows({k: f"{v:.5g}" if isinstance(v, float) else v for k, v in row.items()} for row in rows)
        (folder / "cost.md").write_text(text, encoding="utf-8")
    print(text, flush=True)
    return 0


def machine() -> str:
    """A sentence that names machine, versions and date."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text(encoding="utf-8").splitlines() if info.is_file() else []
    model = next(
        (line.partition(":")[2].strip() for line in lines if line.startswith("model name")), platform.machine()
    )
    versions = ", ".join(f"{name} {version(name)}" for name in ("chaosdrill", "numpy", "numba", "xarray"))
    return f"{model}, {os.cpu_count()} cores, Python {platform.python_version()}, {versions}, {datetime.date.today()}."


def page() -> str:
    """Return the page of the documentation: the text with the tables that are there."""
    text = (HERE / "page.md").read_text(encoding="utf-8")
    for part in OUT.glob("*.md"):
        text = text.replace(f"{{{{{part.stem}}}}}\n", part.read_text(encoding="utf-8"))
    return text


def main() -> int:
    """Run the parts that are asked for; return the first exit code that is not 0."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", choices=[*PARTS, []], metavar="PART", help=", ".join(PARTS))
    parser.add_argument("--docs", action="store_true", help="write the page of the documentation and its pictures, too")
    parser.add_argument("--rounds", type=int, default=7, help="rounds of measuring the cost")
    parser.add_argument("--keep", action="store_true", help="write the cost beside the script, too")
    given = parser.parse_args()
    jobs = dict(zip(PARTS, (scenes, pictures, confirmed, lambda: costs(given.rounds, given.keep)), strict=True))
    OUT.mkdir(exist_ok=True)
    begin = time.monotonic()
    code = 0
    for part in given.parts or PARTS[:3]:
        say(part)
        code = code or jobs[part]()
    if given.docs and not code:
        (DOCS / "branches.md").write_text(page(), encoding="utf-8")
        for picture in PICTURES:
            shutil.copy(OUT / f"{picture}.png", DOCS / "_static" / f"orbits_{picture.replace('-', '_')}.png")
    say(f"done in {time.monotonic() - begin:.0f} s; archives, pictures and tables are in {OUT}")
    return code


def say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
