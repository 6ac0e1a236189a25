"""How much slower or faster one commit is than others, and than programs written for the drill alone.

    python3 studies/run.py speed [BASE ...] [--head HEAD] [--rounds N] [--periods N] [--single PROGRAM]
                                 [--eight PROGRAM]

BASE and HEAD are commits of this repository; each is unpacked into ``studies/speed/out/`` and compiles its own kernels
there, once, which takes minutes. All are measured in turn, round by round, in processor time. Every round starts new
processes, since those of one commit differ by a twentieth.
Cases are single runs of the drill at three frequencies without and with two tangents, at the tolerance 1e-12, and
charts of 64 points with two tangents at 1e-10. The table has the least time of each and the ratios of HEAD to the
others: what else the machine does only adds. ``--single`` names a program that takes ``ETA PERIODS TOLERANCE [--lyap]``
and prints a line of JSON with ``us_per_period``; ``--eight`` one that steps eight points at once, which takes
``--spread``, the distance of their values of eta, too, and is what charts are compared with. The table goes to
``studies/speed/out/commits.md``, too.
"""

import argparse
import json
import os
import subprocess
import sys
import tarfile
from io import BytesIO
from pathlib import Path
from statistics import median
from typing import Any

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
OUT = HERE / "out"
TOLERANCES = {"run": 1e-12, "chart": 1e-10}
ETAS = (0.448, 0.63, 0.8)
SIDE, WIDTH = 8, 1e-3
"""Values of either parameter of a chart, and how far the first and the last are apart."""

LANES = 8
"""Points that `--eight` steps at once."""

LONGEST = 1000
"""Forcing periods of such a run, which takes some milliseconds: a longer one is interrupted on a busy machine."""

TURNS = 10
"""Times that a program runs in a round: its own figure is of the clock, and only the least is free of other work."""

SHORT = 200
"""Forcing periods by which a new process loads what it needs."""

Case = dict[str, Any]


def cases(periods: int) -> dict[str, Case]:
    """What is measured, by name; single runs last ``periods`` forcing periods, charts as long as one of them."""
    found: dict[str, Case] = {}
    for eta in ETAS:
        for tangents in (0, 2):
            name = f"run, η {eta}, {tangents or 'no'} tangents"
            found[name] = {"kind": "run", "eta": eta, "tangents": tangents, "periods": periods}
    chart = {"kind": "chart", "side": SIDE, "width": WIDTH, "periods": max(periods // 13, 1)}
    found |= {f"chart, η {eta}": {**chart, "eta": eta} for eta in ETAS}
    for case in found.values():
        case["tolerance"] = TOLERANCES[case["kind"]]
    return found


class Commit:
    """The package of one commit, in processes of its own.

    Parameters
    ----------
    name : str
        What git knows the commit by.
    """

    def __init__(self, name: str) -> None:
        self.number = git("rev-parse", "--short=12", f"{name}^{{commit}}").decode().strip()
        folder = OUT / self.number
        if not folder.is_dir():
            with tarfile.open(fileobj=BytesIO(git("archive", self.number, "chaosdrill"))) as packed:
                packed.extractall(folder, filter="data")
        self._folder = folder
        self._worker: subprocess.Popen[str] | None = None

    def renew(self) -> None:
        """Start another process, and let it load or compile all that is measured: where code comes to lie matters."""
        self.end()
        folder = self._folder
        environment = dict(os.environ, PYTHONPATH=str(folder), XDG_CACHE_HOME=str(folder / "cache"))
        self._worker = subprocess.Popen(
            [sys.executable, str(HERE / "worker.py")],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            cwd=folder,
            env=environment,
            text=True,
        )
        for case in cases(SHORT).values():
            self.measure(dict(case))

    def measure(self, case: Case) -> float:
        """Microseconds of processor time a forcing period."""
        assert self._worker is not None
        assert self._worker.stdin is not None
        assert self._worker.stdout is not None
        self._worker.stdin.write(json.dumps(case) + "\n")
        self._worker.stdin.flush()
        answer = self._worker.stdout.readline()
        if not answer:
            raise SystemExit(f"{self.number} could not measure {case}")
        return float(answer)

    def end(self) -> None:
        """Let the process end, if there is one."""
        if self._worker is not None:
            self._worker.communicate()


class Yardstick:
    """A program that does the same runs, or those of charts.

    Parameters
    ----------
    program : str
    kind : str
        The kind of cases that it does.
    """

    def __init__(self, program: str, kind: str) -> None:
        self._program, self._kind = program, kind

    def renew(self) -> None:
        """Nothing: every measurement is a process."""

    def measure(self, case: Case) -> float | None:
        """Microseconds a forcing period (of a point); None for what it does not do."""
        if case["kind"] != self._kind:
            return None
        command = [self._program, str(case["eta"]), str(min(case["periods"], LONGEST)), str(case["tolerance"])]
        command += ["--lyap"] if case.get("tangents", 2) else []
        command += ["--spread", str(WIDTH / (LANES - 1))] if case["kind"] == "chart" else []
        answers = (subprocess.run(command, check=True, capture_output=True, text=True).stdout for _ in range(TURNS))
        return min(float(json.loads(answer)["us_per_period"]) for answer in answers)

    def end(self) -> None:
        """Nothing, as before."""


def git(*arguments: str) -> bytes:
    """What git prints."""
    return subprocess.run(["git", *arguments], cwd=ROOT, check=True, stdout=subprocess.PIPE).stdout


def measure(columns: dict[str, Any], wanted: dict[str, Case], rounds: int) -> dict[str, dict[str, list[float]]]:
    """Times of every column by case."""
    times: dict[str, dict[str, list[float]]] = {case: {name: [] for name in columns} for case in wanted}
    for i in range(rounds):
        # who comes first meets another state of the machine
        order = list(columns) if i % 2 else list(columns)[::-1]
        for name in order:
            columns[name].renew()
        for case, numbers in wanted.items():
            for name in order:
                found = columns[name].measure(dict(numbers))
                if found is not None:
                    times[case][name].append(found)
        print(f"round {i + 1} of {rounds}", file=sys.stderr, flush=True)
    return times


def table(times: dict[str, dict[str, list[float]]], head: str) -> str:
    """Markdown of least times and their ratios; in parentheses the median of the ratios of single rounds."""
    others = [name for name in next(iter(times.values())) if name != head]
    lines = [["µs a period", head, *others, *(f"{head} / {name}" for name in others)]]
    lines.append(["---"] * len(lines[0]))
    for case, by in times.items():
        cells = [f"{min(by[name]):.3g}" if by[name] else "" for name in (head, *others)]
        for name in others:
            rounds = [a / b for a, b in zip(by[head], by[name], strict=False)]
            cells.append(f"{min(by[head]) / min(by[name]):.3f} ({median(rounds):.3f})" if rounds else "")
        lines.append([case, *cells])
    return "".join("| " + " | ".join(line) + " |\n" for line in lines)


def main() -> None:
    """Measure, print the table, and write it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bases", nargs="*", metavar="BASE")
    parser.add_argument("--head", default="HEAD", help="default HEAD")
    parser.add_argument("--rounds", type=int, default=40, help="interleaved rounds (default 40)")
    parser.add_argument("--periods", type=int, default=4000, help="forcing periods of a single run (default 4000)")
    parser.add_argument("--single", metavar="PROGRAM", help="does one run at a time")
    parser.add_argument("--eight", metavar="PROGRAM", help="does eight at once")
    given = parser.parse_args()
    OUT.mkdir(exist_ok=True)
    columns: dict[str, Any] = {name: Commit(name) for name in dict.fromkeys((given.head, *given.bases))}
    programs = {"single": (given.single, "run"), "eight": (given.eight, "chart")}
    columns |= {name: Yardstick(*program) for name, program in programs.items() if program[0]}
    text = table(measure(columns, cases(given.periods), given.rounds), given.head)
    for column in columns.values():
        column.end()
    (OUT / "commits.md").write_text(text, encoding="utf-8")
    print(text)


if __name__ == "__main__":
    main()
