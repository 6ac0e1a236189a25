"""Generated motions through steep terms, compared with closed forms: how many are ok but wrong.

    python studies/hard_cases/steep.py [CASES] [--seed N] [--methods NAME ...] [--show N]

Runs CASES cases (default 5000), divided among families, methods (``lanes`` are eight runs side by side by ``taylor``)
and tolerances, and writes one table to ``studies/hard_cases/out/``. The exit code is 0 if no run is ok that is off by
more than a hundred tolerances, or that goes on where its equations end.
"""

import argparse
import math
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from steep_families import Case, Family, families

import chaosdrill as cd
from chaosdrill.engine.batch import Batch
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run

OUT = Path(__file__).resolve().parent / "out"
METHODS = ("taylor", "dop853", "radau", "lanes")
TOLERANCES = (1e-12, 1e-10, 1e-8, 1e-6)
MOST = 100.0
"""Tolerances by which a run may be off."""


def ends(family: Family, cases: list[Case], method: str, tolerance: float) -> Iterator[tuple[cd.Outcome, float]]:
    """How runs end, and the first state there."""
    if method != "lanes":
        for case in cases:
            run = Run(family.system(case), 1.0, Numerics(method, tolerance))
            yield run.advance(1)[0], float(run.x[0])
        return
    names, states = cases[0].parameters, cases[0].initial
    batch = Batch(
        family.system(cases[0]),
        {name: np.array([case.parameters[name] for case in cases]) for name in names},
        np.array([[case.initial[name] for name in states] for case in cases]),
        np.zeros(len(cases), dtype=np.int64),
        Numerics("taylor", tolerance),
    )
    batch.run(0, np.array([0, 1]))
    for outcome, state in zip(batch.outcome.tolist(), batch.x, strict=True):
        yield cd.Outcome(outcome), float(state[0])


def off(case: Case, outcome: cd.Outcome, found: float, tolerance: float) -> float:
    """By how many tolerances a run is off that is ok; infinite where its equations have ended before."""
    if outcome != cd.Outcome.OK:
        return 0.0
    return math.inf if math.isnan(case.right) else abs(found - case.right) / (tolerance * case.scale)


def main() -> int:
    """Run all cases and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cases", nargs="?", type=int, default=5000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--methods", nargs="+", default=METHODS, choices=METHODS)
    parser.add_argument("--show", type=int, default=10, help="wrong cases that are printed")
    given = parser.parse_args()
    draw = np.random.default_rng(given.seed)
    each = -(-given.cases // (len(families()) * len(given.methods) * len(TOLERANCES)))
    lines = ["| family | method | runs | ok | ended early | largest error in tolerances | wrong |", "|---" * 7 + "|"]
    wrong = total = shown = 0
    for family in families():
        for method in given.methods:
            ok = early = bad = 0
            worst = 0.0
            for tolerance in TOLERANCES:
                cases = [family.draw(draw) for _ in range(each)]
                for case, (outcome, found) in zip(cases, ends(family, cases, method, tolerance), strict=True):
                    error = off(case, outcome, found, tolerance)
                    ok += outcome == cd.Outcome.OK
                    # what ends early though its equations do not is no wrong number, but told
                    early += outcome != cd.Outcome.OK and not case.ends
                    worst = max(worst, error)
                    if not error <= MOST:
                        bad += 1
                        if shown < given.show:
                            shown += 1
                            print(family.name, method, tolerance, case, outcome.name, found, error, file=sys.stderr)
            runs = each * len(TOLERANCES)
            lines.append(f"| {family.name} | {method} | {runs} | {ok} | {early} | {worst:.2g} | {bad} |")
            wrong, total = wrong + bad, total + runs
            print(lines[-1], file=sys.stderr, flush=True)
    lines.append(f"\n{wrong} of {total} runs are ok but off by more than {MOST:g} tolerances.\n")
    OUT.mkdir(exist_ok=True)
    (OUT / "steep.md").write_text("\n".join(lines), encoding="utf-8")
    print("\n".join(lines))
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
