"""Lists of events of generated guards, compared with their closed forms: how many are wrong, by guards and methods.

    python studies/hard_cases/event_lists.py [LISTS] [--seed N] [--tolerance TOL] [--show N]

Runs LISTS lists (default 1000), divided among families of guards and methods, and writes one table to
``studies/hard_cases/out/``. The exit code is 0 if there is not one miscount, not one event in a wrong place, and no run
that ends before its time.
"""

import argparse
import sys
from collections import Counter
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from event_families import Family, Numbers, Times, UnclearError, clocks, oscillators, polynomials
from event_kicks import kicks, switches

import chaosdrill as cd
from chaosdrill.engine.batch import Batch
from chaosdrill.engine.numerics import Numerics

OUT = Path(__file__).resolve().parent / "out"

FAILED = ("escaped", "event_limit", "stalled", "nonfinite", "step_underflow", "invalid_start", "failed")

FAMILIES: dict[str, Callable[[], Family]] = {
    "clocks": clocks,
    "oscillators": oscillators,
    "polynomials of a clock": lambda: polynomials(forced=True),
    "polynomials of time": lambda: polynomials(forced=False),
    "kicks": kicks,
    "switches": switches,
}


def faults(found: Mapping[str, np.ndarray], times: Times) -> list[str]:
    """What is wrong with the events found, by transition: their number, or the place of one."""
    wrong = []
    for name, (right, off) in times.items():
        here = np.sort(found[name])
        if len(here) != len(right):
            wrong.append(f"{name}: {len(here)} of {len(right)} events")
        elif np.any(np.abs(here - right) > off):
            i = int(np.argmax(np.abs(here - right) / off))
            wrong.append(f"{name}: event {i} at {here[i]!r}, not at {right[i]!r}")
    return wrong


def single(family: Family, numbers: Numbers, method: str, tolerance: float, samples: int = 1, **more: Any) -> Any:
    """A trajectory and its events: outcome, times by transition."""
    system = family.at(numbers)
    length = {"periods": family.periods} if family.periods else {"duration": family.length(numbers)}
    run = cd.trajectory(system, **{**length, **more}, samples=samples, method=method, tolerance=tolerance)
    return outcome(run), times_by_name(run), run


def outcome(run: Any) -> str:
    """The outcome of a run in words."""
    return cd.Outcome(int(run["outcome"])).meaning


def times_by_name(run: Any) -> dict[str, np.ndarray]:
    """Times of a trajectory's events by transition."""
    kinds, times = run["event_kind"], run["event_time"].values
    names = kinds.attrs["flag_meanings"].split()
    return {name: times[kinds.values == code] for code, name in enumerate(names)}


def check_single(family: Family, numbers: Numbers, times: Times, method: str, tolerance: float) -> list[str]:
    """What is wrong with one run."""
    ended, found, _ = single(family, numbers, method, tolerance)
    if ended in FAILED:
        return [ended]
    return faults(found, times)


def check_lanes(
    family: Family, rng: np.random.Generator, tolerance: float, shape: tuple[int, int, int]
) -> tuple[int, int, list[str]]:
    """All points of a chart of two parameters and some seeds at once, as sweeps at the strobe step them.

    Returns
    -------
    lists : int
        Points of the chart whose list is clear.
    events : int
        Events in all of them.
    wrong : list of str
        What is wrong with them; the events of all transitions of a point are compared together.
    """
    assert family.axes is not None
    drawn = family.lists(rng, tolerance)
    base = next(drawn)[0]
    first, second = (
        np.array([next(drawn)[0][name] for _ in range(k)]) for name, k in zip(family.axes, shape, strict=False)
    )
    states = [name for name in base if name in family.system.state_names]
    varied = [base, *(next(drawn)[0] for _ in range(shape[2] - 1))] if states else [base]
    seeds = [{name: numbers[name] for name in states} for numbers in varied]
    axes = dict(zip(family.axes, (np.unique(first), np.unique(second)), strict=True))
    expected: dict[tuple[int, int, int], tuple[np.ndarray, np.ndarray]] = {}
    most = 1
    for i, a in enumerate(axes[family.axes[0]]):
        for j, b in enumerate(axes[family.axes[1]]):
            for k, seed in enumerate(seeds):
                numbers = {**base, **seed, family.axes[0]: float(a), family.axes[1]: float(b)}
                try:
                    times = family.times(numbers, family.length(numbers), tolerance)
                except UnclearError:
                    continue
                merged = np.concatenate([t for t, _ in times.values()])
                order = np.argsort(merged, kind="stable")
                expected[i, j, k] = merged[order], np.concatenate([off for _, off in times.values()])[order]
                most = max(most, len(merged))
    system, names = family.at(base), family.system.state_names
    grid = [values.ravel() for values in np.meshgrid(*axes.values(), range(len(seeds)), indexing="ij")]
    starts = [[seeds[k].get(name, system.initial[name]) for name in names] for k in grid[2].astype(int)]
    runs = Batch(
        system,
        dict(zip(axes, grid, strict=False)),
        np.array(starts, dtype=float),
        np.full(len(starts), system.mode_names.index(system.initial["mode"])),
        Numerics(tolerance=tolerance),
        section={i for i, t in enumerate(system.transitions) if t.kind == "event"},
        window=most + 8,
    )
    runs.run(0, np.array([0, family.periods]))
    cells = (*(len(values) for values in axes.values()), len(seeds))
    points = runs.window[..., names.index("s")].reshape(*cells, -1)
    outcomes = runs.outcome.reshape(cells)
    wrong = []
    for place, (right, off) in expected.items():
        ended = cd.Outcome(int(outcomes[place])).meaning
        if ended in FAILED:
            wrong.append(ended)
            continue
        row = points[place]
        here = np.sort(row[np.isfinite(row)])
        # a place in a merged list may be taken by the neighbour, if both are in doubt
        room = np.maximum(off, off.max(initial=0.0)) + 1e-14 * (1 + family.length(base))
        if len(here) != len(right):
            wrong.append(f"{len(here)} of {len(right)} events")
        elif np.any(np.abs(here - right) > room):
            wrong.append("an event in a wrong place")
    return len(expected), sum(len(right) for right, _ in expected.values()), wrong


def main() -> int:
    """Run the lists, write the table, and return 1 if anything is wrong."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("lists", type=int, nargs="?", default=1000, help="lists in all (default 1000)")
    parser.add_argument("--seed", type=int, default=0, help="number that the random generators start from")
    parser.add_argument("--tolerance", type=float, default=1e-12)
    parser.add_argument("--show", type=int, default=0, help="print the numbers of at most N wrong lists of each kind")
    given = parser.parse_args()
    columns = [
        (family, method)
        for family in (make() for make in FAMILIES.values())
        for method in ("taylor", "dop853", "lanes")
    ]
    columns = [(family, method) for family, method in columns if method != "lanes" or family.periods]
    share = -(-given.lists // len(columns))
    rows, bad = [], 0
    for number, (family, method) in enumerate(columns):
        rng = np.random.default_rng([given.seed, number])
        lists, events, wrong = 0, 0, Counter[str]()
        if method == "lanes":
            while lists < share:
                some, seen, found = check_lanes(family, rng, given.tolerance, (8, 8, 4))
                lists += some
                events += seen
                wrong.update(found)
        else:
            drawn = family.lists(rng, given.tolerance)
            for _ in range(share):
                numbers, times = next(drawn)
                found = check_single(family, numbers, times, method, given.tolerance)
                lists += 1
                events += sum(len(t) for t, _ in times.values())
                wrong.update({"; ".join(found): 1} if found else {})
                if found and wrong.total() <= given.show:
                    print(family.name, method, found, numbers, sep="\n    ", file=sys.stderr)
        bad += wrong.total()
        rows.append([family.name, method, str(lists), str(events), str(wrong.total())])
        print(*rows[-1], *(f"[{text}]" for text, _ in wrong.most_common(3)), file=sys.stderr, flush=True)
    head = [["guards", "method", "lists", "events", "lists that are not the closed form's"], ["---"] * 5]
    table = "".join("| " + " | ".join(cells) + " |\n" for cells in [*head, *rows])
    OUT.mkdir(exist_ok=True)
    (OUT / "event_lists.md").write_text(table, encoding="utf-8")
    print(table)
    return 0 if bad == 0 else 1


if __name__ == "__main__":
    sys.exit(main())
