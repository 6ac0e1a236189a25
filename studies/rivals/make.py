"""Measures of chaos of smooth systems, beside the programs that PyPI has: equal accuracy, warm, in turns in one run.

Times are those of the processor, so that what else the machine does counts little.

    python studies/rivals/make.py [--rounds N] [--keep]      (or: python3 studies/run.py rivals)

The programs are installed by pip, in the versions of `RIVALS`, into an environment that is thrown away. Without a
network, or where one does not install, the script says so and measures the others. It writes ``rivals.csv`` and
``rivals.md`` into ``out/``, with ``--keep`` beside this script, too.
"""

import argparse
import csv
import datetime
import json
import os
import platform
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
from theirs import HENON, LORENZ, START

import chaosdrill as cd

HERE = Path(__file__).resolve().parent
OUT = HERE / "out"
RIVALS = {"heyoka": "7.13.2", "pynamicalsys": "1.7.0", "nolds": "0.6.3", "scipy": "1.17.1"}
NOT_RUN = "TSDynamics 6.1.1 needs Python 3.12 or newer, and is not among them."
SOON = 5.0
"""Time at which states of the Lorenz system are compared: later its chaos has taken all digits of a coarse one."""
WITHIN = 1e-6
"""Error there, in parts of the largest state, that every program may have at most: its coarsest setting is taken."""

COLUMNS = ("work", "program", "setting", "seconds", "value", "truth")


@dataclass(frozen=True)
class Work:
    """Something that both sides do."""

    name: str  # in the table
    rival: str
    theirs: str  # as `theirs.WORKS` has it
    length: float
    own: Callable[[float], Any]
    truth: str
    settings: tuple[tuple[float, ...], tuple[float, ...]] = ((0.0,), (0.0,))  # own, theirs; from coarse to fine


def lorenz() -> cd.HybridSystem:
    """The system of the library at the usual parameters, from the start of all programs."""
    names = ("sigma", "rho", "beta")
    start = dict(zip("xyz", START, strict=True))
    return cd.build("lorenz", dict(zip(names, LORENZ, strict=True)), initial=start)


def henon() -> cd.Map:
    """Henon's map."""
    a, b = HENON
    images = {"x": "1 - a*x**2 + y", "y": "b*x"}
    return cd.Map("x y", {"a": a, "b": b}, images, initial={"x": 0.1, "y": 0.05})


def works() -> list[Work]:
    """All that is compared."""
    flow, discrete = lorenz(), henon()
    tolerances = tuple(10.0**-k for k in range(4, 15))
    steps = tuple(0.02 / 2**k for k in range(8))

    def run(until: float) -> Callable[[float], Any]:
        return lambda tolerance: cd.trajectory(flow, duration=until, samples=1, tolerance=tolerance)["states"][
            -1
        ].values.tolist()

    def spectrum(tolerance: float) -> list[float]:
        found = cd.lyapunov_spectrum(flow, duration=450.0, transient=50.0, tolerance=tolerance)
        return [float(v) for v in found["lyapunov_exponent"].values]

    def of_map(_: float) -> list[float]:
        found = cd.lyapunov_spectrum(discrete, periods=200_000, transient=500)
        return [float(v) for v in found["lyapunov_exponent"].values]

    def vectors(_: float) -> list[float]:
        found = cd.covariant_vectors(discrete, periods=20_000, transient=500, forward=500, backward=500)
        return [float(found["smallest_angle"][0])]

    def dimension(count: int) -> Callable[[float], list[float]]:
        return lambda _: cd.dimensions(discrete, transient=500, periods=count, orders=[2])["dimension"].values.tolist()

    def iterates(_: float) -> list[float]:
        return cd.poincare_section(discrete, transient=500, periods=100_000)["section"].values[-1].tolist()

    return [
        Work("Lorenz system up to 500", "heyoka", "state", 500.0, run(500.0), "", (tolerances, tolerances)),
        Work("its spectrum over 450", "pynamicalsys", "spectrum", 500.0, spectrum,
             "0.906, 0, -14.572", (tolerances, steps)),
        Work("spectrum of the Henon map, 200,000 iterates", "pynamicalsys", "map", 200_000, of_map, "0.419, -1.623"),
        Work("covariant vectors of the Henon map, 20,000 iterates", "pynamicalsys", "vectors", 20_000, vectors, "0"),
        Work("correlation dimension of the Henon map, 3,000 points", "nolds", "dimension", 3000,
             dimension(3000), "1.22"),
        Work("correlation dimension of the Henon map, 100,000 points", "scipy", "dimension", 100_000,
             dimension(100_000), "1.22"),
        Work("100,000 iterates of the Henon map; their k-d tree", "scipy", "tree", 100_000, iterates, ""),
    ]  # fmt: skip


class Theirs:
    """Other programs in their environment."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.missing = folder, dict[str, str]()
        python = folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
        subprocess.run([sys.executable, "-m", "venv", str(folder)], check=True)
        for name, pinned in RIVALS.items():
            say(f"pip install {name}=={pinned}")
            words = [str(python), "-m", "pip", "install", "--quiet", "--no-input", f"{name}=={pinned}"]
            done = subprocess.run(words, capture_output=True, text=True, check=False)
            if done.returncode:
                lines = (done.stderr.strip() or "pip failed").splitlines()
                self.missing[name] = lines[-1]
        self.process = subprocess.Popen(
            [str(python), str(HERE / "theirs.py")], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )

    def ask(self, work: Work, length: float, setting: float, what: str | None = None, *, warm: bool = True) -> Any:
        """Seconds and values of a task; raises what went wrong there."""
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        task = {"program": work.rival, "work": what or work.theirs, "length": length, "setting": setting, "warm": warm}
        self.process.stdin.write(json.dumps(task) + "\n")
        self.process.stdin.flush()
        told = json.loads(self.process.stdout.readline())
        if "error" in told:
            raise RuntimeError(f"{work.rival}: {told['error']}")
        return told["seconds"], told["values"]

    def close(self) -> None:
        """End it."""
        self.process.kill()
        self.process.wait()


def coarsest(settings: tuple[float, ...], state: Callable[[float], Any], reference: np.ndarray) -> float:
    """The first setting whose state is within `WITHIN` of the reference."""
    for setting in settings:
        if np.abs(np.array(state(setting)) - reference).max() <= WITHIN * np.abs(reference).max():
            return setting
    raise RuntimeError("no setting is as accurate as asked")


def compare(work: Work, theirs: Theirs, rounds: int, reference: np.ndarray) -> list[dict[str, Any]]:
    """Single measurements of both sides, which take turns."""
    own_setting, their_setting = work.settings[0][0], work.settings[1][0]
    if len(work.settings[0]) > 1:
        flow = lorenz()
        own_setting = coarsest(
            work.settings[0],
            lambda one: cd.trajectory(flow, duration=SOON, samples=1, tolerance=one)["states"][-1].values,
            reference,
        )
        their_setting = coarsest(work.settings[1], lambda one: theirs.ask(work, SOON, one, "state")[1], reference)
    rows = []
    work.own(own_setting)
    for turn in range(rounds):
        begin = time.process_time()
        values = work.own(own_setting)
        seconds = time.process_time() - begin
        own = {"program": "chaosdrill", "setting": own_setting, "seconds": seconds, "value": values}
        seconds, values = theirs.ask(work, work.length, their_setting, warm=turn == 0)
        other = {"program": work.rival, "setting": their_setting, "seconds": seconds, "value": values}
        rows += [{"work": work.name, "truth": work.truth, **one} for one in (own, other)]
    return rows


def table(rows: list[dict[str, Any]], missing: dict[str, str]) -> str:
    """What the measurements say, as a table of Markdown."""
    lines = [
        "| work | program | result | exact or published | processor seconds | relative |",
        "|---|---|---|---|---|---|",
    ]
    for name in dict.fromkeys(row["work"] for row in rows):
        here = [row for row in rows if row["work"] == name]
        own = median(row["seconds"] for row in here if row["program"] == "chaosdrill")
        for program in dict.fromkeys(row["program"] for row in here):
            of_it = [row for row in here if row["program"] == program]
            seconds = median(row["seconds"] for row in of_it)
            values = ", ".join(f"{v:.3g}" for v in of_it[0]["value"]) if of_it[0]["truth"] else "–"
            title = program if program == "chaosdrill" else f"{program} {RIVALS[program]}"
            truth = of_it[0]["truth"] or "–"
            lines.append(f"| {name} | {title} | {values} | {truth} | {seconds:.3g} | {seconds / own:.2g} |")
    told = [f"{name} is missing: {why}" for name, why in missing.items()]
    return "\n".join([*lines, "", *told, NOT_RUN, "", machine(), ""])


def machine() -> str:
    """A sentence that names machine, versions and date."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text(encoding="utf-8").splitlines() if info.is_file() else []
    models = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    # of the code that runs, not of what pip knows of
    names = ", ".join([f"chaosdrill {cd.__version__}", *(f"{name} {version(name)}" for name in ("numba", "numpy"))])
    today = datetime.datetime.now(datetime.UTC).date()
    return f"{next(models, platform.machine())}, one core, Python {platform.python_version()}, {names}, {today}."


def say(text: str) -> None:
    """Tell how far it has come."""
    print(text, file=sys.stderr, flush=True)


def main() -> None:
    """Measure, and write the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5, help="times that each side is measured")
    parser.add_argument("--keep", action="store_true", help="write beside this script, too")
    given = parser.parse_args()
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    rows: list[dict[str, Any]] = []
    with tempfile.TemporaryDirectory() as folder:
        theirs = Theirs(Path(folder) / "rivals")
        try:
            first, *_ = works()
            reference = np.array(theirs.ask(first, SOON, 1e-16)[1]) if first.rival not in theirs.missing else None
            for work in works():
                if work.rival in theirs.missing or (len(work.settings[0]) > 1 and reference is None):
                    say(f"{work.name}: not without {work.rival}")
                    continue
                say(work.name)
                try:
                    rows += compare(work, theirs, given.rounds, np.zeros(3) if reference is None else reference)
                except RuntimeError as error:
                    say(f"{work.name}: {error}")
                    theirs.missing[work.rival] = str(error)
        finally:
            theirs.close()
    text = table(rows, theirs.missing)
    OUT.mkdir(exist_ok=True)
    for place in (OUT, HERE) if given.keep else (OUT,):
        (place / "rivals.md").write_text(text, encoding="utf-8")
        with (place / "rivals.csv").open("w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, COLUMNS)
            writer.writeheader()
            for row in rows:
                value = " ".join(f"{v:.6g}" for v in row["value"])
                writer.writerow(row | {"value": value, "seconds": f"{row['seconds']:.5g}"})
    print(text)


if __name__ == "__main__":
    main()
