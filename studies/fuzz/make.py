"""Inputs corrupted at random, for hours; and runs that are killed at random moments and resumed.

    python studies/fuzz/make.py [INPUTS] [--kills N] [--hours H] [--seed K]

tries INPUTS inputs (default 20000), or as many as the time allows: scenes, definitions, archives and folders of
finished parts, by ``tests/fuzz``, where a minute of the same is a test. Then runs of a scene are killed N times
(default 100) and resumed, and their output is compared with that of an uninterrupted run. Writes
``studies/fuzz/out/fuzz.md`` and, of every input with which something was wrong, a file beside it, which
``python tests/fuzz/fuzzer.py --replay FILE`` tries again. It belongs into ``tests/fuzz/corpus``, under a name that says
what it is. The exit code is 1 if anything was wrong.
"""

import argparse
import os
import random
import signal
import sys
import tempfile
import time
import warnings
from collections import Counter
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
OUT = Path(__file__).resolve().parent / "out"
sys.path.insert(0, str(ROOT / "tests" / "fuzz"))

SCENE = """\
[system]
model = "impact-oscillator"
[analysis.motion]
kind = "trajectory"
periods = 20
samples = 10
[analysis.spectrum]
kind = "lyapunov-spectrum"
transient = 20
periods = 400
[analysis.diagram]
kind = "bifurcation-diagram"
sweep.omega = { start = 2.4, stop = 2.8, num = 400 }
transient = 50
periods = 64
[analysis.chart]
kind = "parameter-chart"
sweep.omega = { start = 2.4, stop = 2.8, num = 12 }
sweep.e = { start = 0.7, stop = 0.8, num = 10 }
transient = 50
periods = 32
"""
MEAN = 0.3
"""Time after which a run is killed, on average, as a share of that of a whole one."""


class Killed:
    """A scene run in processes of their own, some of which are killed.

    Parameters
    ----------
    folder : pathlib.Path
        Folder to work in.
    """

    def __init__(self, folder: Path) -> None:
        from chaosdrill.archive import open as open_archive

        self.scene, self.output = folder / "scene.toml", folder / "out" / "out.nc"
        self.scene.write_text(SCENE)
        self.output.parent.mkdir()
        # the first one loads what all later ones have
        for _ in range(2):
            start = time.monotonic()
            if self._until(None, resume=False) != 0:
                raise RuntimeError("the scene cannot be run")
            self.whole_s = time.monotonic() - start
        self.expected = open_archive(self.output)
        self.output.unlink()

    def chain(self, chance: random.Random, most: int) -> tuple[list[str], str]:
        """Run until the archive is written, with at most this number of kills.

        Returns
        -------
        left : list of str
            What each kill has left behind, in words.
        wrong : str
            What is wrong at the end; empty if nothing is.
        """
        from chaosdrill.archive import open as open_archive
        from chaosdrill.workflow import compare

        left: list[str] = []
        while True:
            after = chance.expovariate(1 / (MEAN * self.whole_s)) if len(left) < most else None
            code = self._until(after, resume=True, workers=chance.choice([1, 1, 2]))
            if code != -signal.SIGKILL:
                break
            left.append(self._left())
        found = {path.name for path in self.output.parent.iterdir()} - {self.output.name}
        if code != 0:
            return left, f"exit code {code}"
        if found:
            return left, f"left {sorted(found)}"
        differences = compare(open_archive(self.output), self.expected)
        self.output.unlink()
        return left, str(differences[0]) if differences else ""

    def _until(self, seconds: float | None, *, resume: bool, workers: int = 1) -> int:
        """Exit code of a run that is killed after this number of seconds, if it has not ended before."""
        import judge

        from chaosdrill.cli import main

        arguments = ["run", str(self.scene), "-o", str(self.output), "--workers", str(workers)]
        child = os.fork()
        if not child:
            for name in ("stdout", "stderr"):
                setattr(sys, name, open(self.scene.with_name(name), "w"))  # noqa: SIM115
            os._exit(main([*arguments, "--resume"] if resume else arguments))
        code = judge.wait(child, 3600 if seconds is None else seconds)
        if code is None:
            os.kill(child, signal.SIGKILL)
            code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        return code

    def _left(self) -> str:
        from chaosdrill.sweep import Parts

        parts = Path(f"{self.output}.parts")
        kept = Parts(parts, {}, resume=True).kept()
        drafts = any(path.name.endswith(".part") for path in self.output.parent.rglob("*"))
        states = ["archive there" if self.output.exists() else "", "a draft" if drafts else ""]
        states.append(f"{len(kept)} of 4 analyses begun or finished" if parts.exists() else "no parts")
        return ", ".join(filter(None, states))


def kills(count: int, seed: int, folder: Path) -> tuple[int, int, Counter[str], list[str]]:
    """Number of kills and of archives that were compared, what the kills left, and what was wrong."""
    killed, chance = Killed(folder), random.Random(seed)
    states: Counter[str] = Counter()
    archives, wrong = 0, []
    while states.total() < count:
        left, fault = killed.chain(chance, count - states.total())
        states.update(left)
        archives += 1
        if fault:
            wrong.append(f"after {len(left)} kills: {fault}")
            break
        print(f"{states.total()} kills, {archives} archives", file=sys.stderr, flush=True)
    return states.total(), archives, states, wrong


def table(head: list[str], rows: list[list[Any]]) -> str:
    """A table in Markdown."""
    lines = [head, ["---"] * len(head), *rows]
    return "".join("| " + " | ".join(map(str, cells)) + " |\n" for cells in lines)


def main() -> int:
    """Try the inputs and the kills, write the tables, and return 1 if anything was wrong."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("inputs", type=int, nargs="?", default=20_000, help="inputs in all (default 20000)")
    parser.add_argument("--kills", type=int, default=100, help="kills in all (default 100)")
    parser.add_argument("--hours", type=float, help="as many inputs as can be tried in that time, instead")
    parser.add_argument("--seed", type=int, default=0, help="number that the random generators start from")
    given = parser.parse_args()
    import fuzzer

    # what readers of spoilt files warn of is no news
    warnings.simplefilter("ignore")
    OUT.mkdir(exist_ok=True)
    text, bad = "", 0
    with tempfile.TemporaryDirectory(prefix="fuzz-") as name:
        home = Path(name).resolve()
        if given.kills:
            (home / "kills").mkdir()
            count, archives, states, wrong = kills(given.kills, given.seed, home / "kills")
            bad += len(wrong)
            text += f"{count} kills, {archives} archives compared with that of an uninterrupted run\n\n"
            text += table(["what a kill left", "kills"], [list(row) for row in states.most_common()])
            text += "".join(f"\n{line}\n" for line in wrong) + "\n"
        if given.inputs:
            told = fuzzer.run(
                home,
                seed=given.seed,
                seconds=given.hours and 3600 * given.hours,
                inputs=given.inputs,
                keep=OUT,
                tell=lambda line: print(line, file=sys.stderr, flush=True),
            )
            rows = [
                [kind, one["inputs"], one["lines reached"], one["spoilt further"], len(one["faults"])]
                for kind, one in told.items()
            ]
            bad += sum(len(one["faults"]) for one in told.values())
            text += table(["kind", "inputs", "lines reached", "spoilt further", "wrong"], rows)
    (OUT / "fuzz.md").write_text(text, encoding="utf-8")
    print(text)
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
