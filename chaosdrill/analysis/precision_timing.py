"""What accuracy costs: the same stretch run by every method at every tolerance, round after round."""

import gc
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from time import perf_counter, thread_time
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.dataset import Outcome
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run
from chaosdrill.engine.structure import examine

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem

COUNTED, TIMED = 16, 64
"""Units over which steps and evaluations are counted, and of a run that is timed."""

ROUND_S, LONGEST_S = 0.02, 0.02
"""Time that one cell is meant to take in one round: short runs are repeated, long ones have fewer units."""

UNDISTURBED = 0.95
"""Share of a run's time for which it must have had the processor to count, if half of the runs had.

Other work on the machine would otherwise lengthen long runs more often than short ones, and so one method more than
another.
"""


@dataclass(frozen=True)
class Cost:
    """Cost of a unit of time; NaN where the runs came to an early end."""

    outcome: Outcome
    seconds: float = float("nan")  # median over the runs
    spread: float = float("nan")  # distance of their quartiles
    steps: float = float("nan")  # mean number
    evaluations: float = float("nan")  # mean number, of the right-hand side


def measure_costs(
    system: "HybridSystem",
    unit: float,
    count: int,
    most: int,
    cells: Sequence[Numerics],
    repeats: int,
    report: Callable[[], None] = lambda: None,
) -> list[Cost]:
    """Time runs with all tangents and events; the cells take turns, so that a slow moment of the machine meets all.

    A first run of each cell over about ``COUNTED`` units is not timed: it warms the kernels, counts the work, and tells
    how many units a run may have (``TIMED`` if they do not take too long), and a round how many runs. Only whole cycles
    are run.

    Parameters
    ----------
    system : HybridSystem
        Its initial state is where all runs begin.
    unit : float
        Time between strobes.
    count : int
        Units of a cycle.
    most : int
        Units that no run exceeds.
    cells : sequence of Numerics
        Method and tolerance of each cell.
    repeats : int
        Rounds that are timed.
    report : callable
        Called after each round.
    """
    deficient = examine(system).deficient
    frame = np.eye(len(system.states))

    def timed(numerics: Numerics, units: int) -> tuple[Outcome, float, float, Run]:
        run = Run(system, unit, numerics, tangents=frame, deficient=deficient)
        begin, begin_computing = perf_counter(), thread_time()
        outcome, _ = run.advance(units)
        computing, seconds = thread_time() - begin_computing, perf_counter() - begin
        return outcome, seconds, computing / seconds, run

    outcomes, lengths, runs, work = [], [], [], []
    for numerics in cells:
        counted = count * max(1, min(COUNTED, most) // count)
        outcome, seconds, _, run = timed(numerics, counted)
        each = max(seconds / counted, 1e-9)
        outcomes.append(outcome)
        lengths.append(count * max(1, min(TIMED, most, int(LONGEST_S / each)) // count))
        runs.append(max(1, int(ROUND_S / (each * lengths[-1]))))
        work.append((run.steps / counted, run.evaluations / counted))
    samples: list[list[tuple[float, float]]] = [[] for _ in cells]
    for _ in range(repeats):
        gc.collect()
        gc.disable()
        try:
            for i, numerics in enumerate(cells):
                for _ in range(runs[i] if outcomes[i] == Outcome.OK else 0):
                    outcome, seconds, share, _ = timed(numerics, lengths[i])
                    samples[i].append((seconds / lengths[i] if outcome == Outcome.OK else np.nan, share))
        finally:
            gc.enable()
        report()
    costs = []
    for outcome, sample, (steps, evaluations) in zip(outcomes, samples, work, strict=True):
        if outcome != Outcome.OK:
            costs.append(Cost(outcome))
            continue
        times, shares = np.array(sample).T
        undisturbed = shares >= min(UNDISTURBED, float(np.median(shares)))
        low, middle, high = np.quantile(times[undisturbed], [0.25, 0.5, 0.75])
        costs.append(Cost(outcome, float(middle), float(high - low), steps, evaluations))
    return costs
