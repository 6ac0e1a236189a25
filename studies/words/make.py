"""How often a word is wrong: records whose nature is known, in any units and of any length, and what they are called.

    python studies/words/make.py [--records N] [--seed S]          (or: python3 studies/run.py words)

The records go through the judgement that spectra use; runs without forcing, at events and surfaces, and of the drill
are called by spectra themselves. The table is written to ``studies/words/words.md``; the exit code is 0 if at most one
word in 1,000 is wrong at every length.
"""

import argparse
import hashlib
import json
import sys
import time
from collections import Counter
from pathlib import Path
from types import SimpleNamespace

import borders
import numpy as np
import records
from runs import RUNS as RUN_FAMILIES
from runs import called as called_by_spectra

import chaosdrill
from chaosdrill.analysis.judgement.classification import Averages, Records, evidence_of_records
from chaosdrill.analysis.judgement.statistics import block_ends, standard_error
from chaosdrill.analysis.judgement.tori import KEPT
from chaosdrill.analysis.judgement.words import words
from chaosdrill.analysis.tuning import PLAN
from chaosdrill.dataset import Outcome
from chaosdrill.engine.shifts import Shifts
from chaosdrill.engine.structure import Structure
from chaosdrill.engine.tuning import RUNS

HERE = Path(__file__).resolve().parent
LENGTHS = (64, 256, 1024, 4096, 16384)
LENGTHS_OF_RUNS = LENGTHS[:4]
SEED = 20_261_126
FAMILIES = records.FAMILIES | borders.FAMILIES
OPEN_ANSWERS = {"undecided", "transient"}
MOST_WRONG = 1e-3


def averages_of(growth):
    """Exponents of growth a step, of shape (P, L, m), as a spectrum makes them of its blocks."""
    length = growth.shape[1]
    ends = block_ends(length, PLAN.blocks)
    sums = np.concatenate([np.zeros_like(growth[:, :1]), np.cumsum(growth, axis=1)], axis=1)[:, ends]
    half = (len(ends) - 1) // 2
    rates = (np.diff(sums, axis=1) / np.diff(ends)[:, np.newaxis]).swapaxes(0, 1)
    values, errors = sums[:, -1] / length, standard_error(rates)
    late = (sums[:, -1] - sums[:, half]) / (length - ends[half])
    order = np.argsort(-values, axis=1, kind="stable")
    values, errors, late = (np.take_along_axis(one, order, 1) for one in (values, errors, late))
    points = len(growth)
    course = np.take_along_axis(sums, order[:, np.newaxis], 2)
    time, rounding = np.full(points, float(length)), np.full(points, RUNS.rounding)
    return Averages(values, errors, late, course, time, rounding, np.zeros(points, int), False), ends


def called(states, growth):
    """Words for records, of which more states than growth are known where some were passed before."""
    known = np.abs(states).max(axis=1)
    states = states[:, -growth.shape[1] :]
    points, length, n = states.shape
    averages, ends = averages_of(growth)
    jumps = SimpleNamespace(reset=True, marks_only=lambda: False)
    forced = SimpleNamespace(
        forced=True,
        autonomous=False,
        states=range(n),
        free=n,
        noise=(),
        draws=False,
        modes={"on": {}},
        transitions=[jumps],
        shared={},
    )
    structure = Structure(frozenset(), np.eye(n), 0, False)
    windows = np.concatenate([states[:, -KEPT:], np.zeros((points, min(length, KEPT), 1))], axis=2)
    coarse = states[:, np.maximum(ends - 1, 0)]
    of = np.ascontiguousarray(windows), known, min(1.0, KEPT / length)
    evidence = evidence_of_records(Records(forced, structure, Shifts.none(n), averages, *of), coarse)
    return [Outcome(int(code)).meaning for code in words(evidence)]


def digest():
    """What tells the code apart that makes records and calls them: a word of older code is none of this."""
    package = Path(chaosdrill.__file__).parent
    sources = sorted(HERE.glob("*.py")) + sorted(package.rglob("*.py"))
    return hashlib.sha256(b"".join(one.read_bytes() for one in sources)).hexdigest()[:16]


def main():
    """Make the records, call them, write the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--records", type=int, default=6000, help="records of all families and lengths together")
    parser.add_argument("--runs", type=int, default=15, help="runs of each family and length that spectra call")
    parser.add_argument("--seed", type=int, default=SEED, help="from which they are made")
    parser.add_argument("--keep", type=Path, help="file of words found by the same code, from which a run goes on")
    given = parser.parse_args()
    code = digest()
    kept = json.loads(given.keep.read_text()) if given.keep and given.keep.exists() else {}

    def found(name, length, work):
        """Words and which records are too short, from the file or by work."""
        key = f"{name}, {length} of seed {given.seed}, {given.records} and {given.runs} by {code}"
        if key not in kept:
            said, too_short = work()
            kept[key] = list(said), [bool(one) for one in too_short]
            if given.keep:
                given.keep.write_text(json.dumps(kept))
        return [np.array(one) for one in kept[key]]

    each = max(1, -(-given.records // (len(FAMILIES) * len(LENGTHS))))
    rows, began = [], time.perf_counter()
    wrong, open_, total, short, open_short = (Counter() for _ in range(5))

    def enter(name, length, right, said, too_short):
        """Count the words for records of a family and length."""
        found, unsaid = Counter(said.tolist()), np.isin(said, sorted(OPEN_ANSWERS))
        false = sum(count for word, count in found.items() if word not in OPEN_ANSWERS | {right})
        wrong[length] += false
        total[length] += len(said)
        short[length] += too_short.sum()
        open_[length] += (unsaid & ~too_short).sum()
        open_short[length] += (unsaid & too_short).sum() if right else 0
        rows.append((name, length, right or "none", found, false))

    def of_records(name, length):
        """Words for synthetic records of a family."""
        family, right = FAMILIES[name]
        rng = np.random.default_rng([given.seed, length, *name.encode()])
        states, growth, *excused = family(rng, each, length)
        units = 10 ** rng.uniform(-9, 9, (each, 1, states.shape[2]))
        return called(states * units, growth), excused[0] if excused else np.full(each, not right)

    def of_runs(name, length):
        """Words that spectra give runs of a family."""
        rng = np.random.default_rng([given.seed, length, *name.encode()])
        return called_by_spectra(RUN_FAMILIES[name][0], rng, given.runs, length)

    for name, (_, right) in FAMILIES.items():
        for length in LENGTHS:
            enter(name, length, right, *found(name, length, lambda name=name, length=length: of_records(name, length)))
    for name, (_, right) in RUN_FAMILIES.items():
        for length in LENGTHS_OF_RUNS if given.runs else ():
            enter(name, length, right, *found(name, length, lambda name=name, length=length: of_runs(name, length)))
    listed = ("periodic", "quasiperiodic", "chaotic", "open", "equilibrium", "transient", "undecided")
    lines = [f"| records | length | right | {' | '.join(listed)} | wrong |", "|---|" + "---:|" * (len(listed) + 3)]
    lines += [
        f"| {name} | {length} | {right} | {' | '.join(str(found[word] or '') for word in listed)} | {false or ''} |"
        for name, length, right, found, false in rows
    ]
    told = [
        f"| {length} | {total[length]} | {wrong[length]} | {total[length] - short[length]} | {open_[length]} "
        f"| {open_[length] / max(total[length] - short[length], 1):.1%} | {open_short[length]} |"
        for length in LENGTHS
    ]
    lines += [
        "",
        "| length | records | wrong | long enough for a word | undecided or transient | part | of the others |",
        "|---:|---:|---:|---:|---:|---:|---:|",
        *told,
    ]
    (HERE / "words.md").write_text("\n".join(lines) + "\n")
    print("\n".join(lines))
    print(f"{sum(total.values())} records in {time.perf_counter() - began:.0f} s")
    return int(any(wrong[length] > MOST_WRONG * total[length] for length in LENGTHS))


if __name__ == "__main__":
    sys.exit(main())
