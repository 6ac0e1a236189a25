"""The paper's cases, from scenes to archives, figures 2 to 6, a table of regimes and a bifurcation diagram.

    python studies/paper/make.py [--docs]          (or: python3 studies/run.py paper)

Everything is written to ``studies/paper/out/``. The scenes run through the command line, as a user would run them.
``--docs`` puts the picture of the README into the documentation, too.
"""

import shutil
import subprocess
import sys
import sysconfig
import time
from pathlib import Path

from contact import simulate
from figures import FIGURES, draw
from regimes import write_table

HERE = Path(__file__).resolve().parent
OUT = HERE / "out"
DOCS = HERE.parent.parent / "docs" / "_static"
CASES = ("period1", "period2", "period4", "chaos")
READINGS = {"": "as reproduced", "as_printed_": "as printed"}
COMMAND = Path(sysconfig.get_path("scripts")) / "chaosdrill"


def main() -> int:
    """Run every scene, then draw; return the exit code of the first command that fails, else 0."""
    started = time.monotonic()
    OUT.mkdir(exist_ok=True)
    scenes = [*(reading + case for reading in READINGS for case in CASES), "diagram", "attractor"]
    for number, scene in enumerate(scenes, 1):
        say(f"[{number}/{len(scenes)}] {scene}.toml")
        code = chaosdrill("run", HERE / f"{scene}.toml", "-o", OUT / f"{scene}.nc", "--workers", "2")
        if code:
            return code
    say("contact")
    simulate(OUT)
    say("figures")
    for figure in FIGURES:
        draw(figure, OUT)
    if "--docs" in sys.argv[1:]:
        shutil.copy(OUT / "drill.png", DOCS)
    code = chaosdrill("plot", OUT / "diagram.nc", "-o", OUT / "bifurcation.png")
    if code:
        return code
    for case in CASES:
        code = chaosdrill("plot", OUT / f"{case}.nc", "-o", OUT / f"{case}_spectrum.png", "--group", "spectrum")
        if code:
            return code
    print(write_table(OUT, CASES, READINGS))
    say(f"done in {time.monotonic() - started:.0f} s; archives, pictures and the table are in {OUT}")
    return 0


def chaosdrill(*arguments: object) -> int:
    """Run the command line of this Python's environment and return its exit code."""
    return subprocess.call([COMMAND, *map(str, arguments)], stdout=subprocess.DEVNULL)


def say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
