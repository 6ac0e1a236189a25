"""Scenes, definitions, archives and folders of parts that are spoilt at random, guided by the lines that they reach.

    python tests/fuzz/fuzzer.py --seconds 50 [--seed K]        every kind for so long, all together
    python tests/fuzz/fuzzer.py --inputs 20000 [--seed K]      N inputs, divided among the kinds
    python tests/fuzz/fuzzer.py --replay FILE ...              inputs that were kept

The inputs of the corpus come first. One that reaches a line of the package that none before it has reached is spoilt
further. Those with which something was wrong are kept (``--keep FOLDER``). Prints a report as JSON; the exit code is 1
if anything was wrong.
"""

import argparse
import json
import random
import shutil
import sys
import tempfile
import time
from collections import Counter
from hashlib import sha256
from importlib import import_module
from pathlib import Path

CORPUS = Path(__file__).with_name("corpus")
sys.path.insert(1, str(CORPUS.parents[1]))
SHARES = {"scenes": 0.45, "definitions": 0.4, "archives": 0.09, "parts": 0.06}
"""Of the inputs, and by how long they take about the same of the time."""

MOST_BYTES = 20_000
"""Larger inputs are not spoilt further."""

TRACED_ONE_IN = 4
"""How many inputs come on one of which it is told what lines it reaches: that takes up to ten times as long."""

SEEDS_TRIED_ONE_IN = 3
"""How many seeds come on one that is tried as it is, before all are spoilt: they are sound, as other tests say."""

LEAST = 10
"""Inputs of a kind that are spoilt, however long its corpus has taken."""


class Campaign:
    """Inputs of one kind.

    Parameters
    ----------
    kind : module
    home : pathlib.Path
        Folder to work in.
    seed : int
        Number that the random generator starts from.
    keep : pathlib.Path or None
        Where to keep inputs with which something was wrong.
    """

    def __init__(self, kind, home, seed, keep):
        from worker import Worker

        self.kind, self.keep = kind, keep
        self.chance = random.Random(f"{seed} {kind.name}")
        self.corpus = sorted((CORPUS / kind.name).glob(f"*{kind.ending}"))
        seeds = kind.seeds(home)
        self.waiting = [*seeds[::SEEDS_TRIED_ONE_IN], *(path.read_bytes() for path in self.corpus)]
        self.given = len(self.waiting)
        self.pool = [seed for k, seed in enumerate(seeds) if k % SEEDS_TRIED_ONE_IN]
        self.sound = [*self.pool]
        self.lines = set()
        self.outcomes = Counter()
        self.faults = []
        self.spent_s = 0.0
        self._worker = Worker(kind, home / f"tried-{kind.name}")

    @property
    def tried(self):
        """Number of inputs so far."""
        return self.outcomes.total()

    def step(self):
        """Try one more input."""
        start = time.monotonic()
        if self.waiting:
            data, ours = self.waiting.pop(0), True
        else:
            data, ours = self.kind.mutate(self._drawn(), self.chance, self._drawn()), False
        outcome, wrong, lines = self._worker.ask(data, self.tried % TRACED_ONE_IN == 0)
        self.outcomes[outcome] += 1
        new = set(lines) - self.lines
        self.lines |= new
        if ours or (new and len(data) <= MOST_BYTES):
            self.pool.append(data)
            if outcome in self.kind.SOUND:
                self.sound.append(data)
        if wrong:
            self.faults.append({"input": self._kept(data), "number": self.tried, "wrong": wrong})
        self.spent_s += time.monotonic() - start
        return wrong

    def close(self):
        """End the process that tries the inputs."""
        self._worker.close()

    def told(self):
        """What there is to tell."""
        return {
            "inputs": self.tried,
            "of the corpus": self.given,
            "outcomes": dict(self.outcomes.most_common()),
            "spoilt further": len(self.pool),
            "lines reached": len(self.lines),
            "seconds": round(self.spent_s, 1),
            "faults": self.faults,
        }

    def _drawn(self):
        # what is wrong already hides what else is
        if self.sound and self.chance.random() < 0.6:
            return self.chance.choice(self.sound)
        return self.chance.choice(self.pool)

    def _kept(self, data):
        if self.keep is None:
            return data.decode(errors="backslashreplace")[:2000]
        path = self.keep / self.kind.name / f"{sha256(data).hexdigest()[:12]}{self.kind.ending}"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
        return str(path)


def prepared(names, home):
    """The kinds, with what they need made in a folder."""
    kinds = [import_module(name) for name in names]
    for kind in kinds:
        kind.prepare(home)
    return kinds


def run(home, *, seed, seconds=None, inputs=None, names=tuple(SHARES), keep=None, tell=None):
    """Try inputs of several kinds.

    Parameters
    ----------
    home : pathlib.Path
        Folder to work in.
    seed : int
        Number that the random generators start from.
    seconds : float, optional
        For how long; the kinds share the time equally. The corpus is tried in any case, and some inputs more.
    inputs : int, optional
        How many, instead.
    names : sequence of str
        The kinds.
    keep : pathlib.Path, optional
        Where to keep inputs with which something was wrong.
    tell : callable, optional
        Called with a line on what was wrong.

    Returns
    -------
    dict
        By kind, what `Campaign.told` tells.
    """
    start = time.monotonic()
    campaigns = [Campaign(kind, home, seed, keep) for kind in prepared(names, home)]
    total = sum(SHARES[name] for name in names)
    wanted = {c.kind.name: (inputs or 0) * SHARES[name] / total for c, name in zip(campaigns, names, strict=True)}
    try:
        while True:
            if seconds is None:
                open_ones = [c for c in campaigns if c.waiting or c.tried < wanted[c.kind.name]]
            else:
                over = time.monotonic() - start > seconds
                open_ones = [c for c in campaigns if not over or c.waiting or c.tried < c.given + LEAST]
            if not open_ones:
                break
            campaign = min(open_ones, key=lambda c: c.spent_s)
            wrong = campaign.step()
            if tell and (wrong or campaign.tried % 500 == 0):
                tell(f"{campaign.kind.name} {campaign.tried}: {wrong[0][-300:] if wrong else 'inputs'}")
    finally:
        for campaign in campaigns:
            campaign.close()
    return {campaign.kind.name: campaign.told() for campaign in campaigns}


def replay(home, paths):
    """What is wrong with inputs that were kept, by file."""
    from worker import Worker

    found = {}
    kinds = {kind.name: kind for kind in prepared({name for name in SHARES for p in paths if _is_of(p, name)}, home)}
    for path in paths:
        kind = kinds[path.resolve().parent.name]
        worker = Worker(kind, home / "tried")
        outcome, wrong, _ = worker.ask(path.read_bytes())
        worker.close()
        found[str(path)] = {"outcome": outcome, "wrong": wrong}
    return found


def _is_of(path, module):
    return path.resolve().parent.name == module.removesuffix("s") or path.resolve().parent.name == module


def main():
    """Do what the command line says."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float)
    parser.add_argument("--inputs", type=int)
    parser.add_argument("--seed", type=int, default=0, help="number that the random generators start from")
    parser.add_argument("--kind", action="append", choices=SHARES, help="only this kind; may be given several times")
    parser.add_argument("--keep", type=Path, help="folder for inputs with which something was wrong")
    parser.add_argument("--replay", type=Path, nargs="+")
    given = parser.parse_args()
    home = Path(tempfile.mkdtemp(prefix="fuzz-")).resolve()
    try:
        if given.replay:
            report = replay(home, given.replay)
            wrong = any(entry["wrong"] for entry in report.values())
        else:
            report = run(
                home,
                seed=given.seed,
                seconds=given.seconds,
                inputs=given.inputs,
                names=given.kind or tuple(SHARES),
                keep=given.keep and given.keep.resolve(),
                tell=lambda line: print(line, file=sys.stderr, flush=True),
            )
            wrong = any(entry["faults"] for entry in report.values())
    finally:
        shutil.rmtree(home, ignore_errors=True)
    print(json.dumps(report, indent=2))
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
