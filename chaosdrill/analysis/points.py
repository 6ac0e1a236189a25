"""One point of a sweep: a run from its own initial state, with everything that a diagram keeps of it."""

from collections.abc import Collection
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from chaosdrill.analysis.spectra import mean_exponents
from chaosdrill.analysis.statistics import classify, find_period
from chaosdrill.dataset import Outcome
from chaosdrill.engine import layout
from chaosdrill.engine.run import Numerics, Run, event_rates
from chaosdrill.engine.structure import examine
from chaosdrill.errors import SettingsError

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem

_BLOCKS = 32
_EVENT_ROWS = 1024


@dataclass(frozen=True)
class PointTask:
    """What is done at every point; ``frame`` is a number of exponents until ``for_system`` makes it the tangents."""

    parameter: str
    transient: int
    periods: int
    chosen: set[int] | None
    max_period: int
    numerics: Numerics
    frame: Any
    deficient: Collection[int] | None = None
    shifts: int = 0
    neutral: int = 0

    def for_system(self, system: "HybridSystem") -> "PointTask":
        """The task with what the structure of the system tells about its tangents.

        A rank can depend on a parameter that a reset names; then every point looks for itself.
        """
        if system.period is None:
            raise SettingsError(f"{system.name} has no forcing period; a diagram counts its length in forcing periods")
        structure = examine(system)
        frame, shifts = structure.tangents(self.frame)
        in_resets = {s.name for t in system.transitions for value in t.reset.values() for s in value.free_symbols}
        deficient = None if self.parameter in in_resets else structure.deficient
        return replace(self, frame=frame, shifts=shifts, deficient=deficient, neutral=structure.neutral)


@dataclass(frozen=True)
class Point:
    """Result of one point; NaN (and period 0) where there is none."""

    section: np.ndarray
    period: int
    exponents: np.ndarray
    errors: np.ndarray
    rates: dict[str, float]
    outcome: Outcome
    forcing_period: float


def run_point(task: PointTask, value: float, start: "HybridSystem") -> Point:
    """Run one point of a sweep; whatever happens there becomes its outcome."""
    m, n = task.frame.shape
    try:
        system = start.with_parameters(**{task.parameter: value})
        period = system.forcing_period()
    except SettingsError:
        return _empty(task, start, n, m, Outcome.FAILED, float("nan"))
    assert period is not None
    deficient = examine(system).deficient if task.deficient is None else task.deficient
    run = Run(system, period, task.numerics, tangents=task.frame, shifts=task.shifts, deficient=deficient)
    outcome, _ = run.advance(task.transient)
    if outcome != Outcome.OK:
        return _empty(task, system, n, m, outcome, period)
    run.forget()
    ends = np.unique(np.linspace(0, task.periods, min(_BLOCKS, task.periods) + 1).astype(int))
    sums = np.zeros((len(ends), m))
    rows = np.full((task.periods + 2, n + len(system.quadratures) + 1), np.nan)
    events: list[np.ndarray] = []
    filled = 0
    for block, length in enumerate(np.diff(ends), start=1):
        outcome = _advance(run, int(length), rows[filled:], events if task.chosen else None)
        if outcome != Outcome.OK:
            return _empty(task, system, n, m, outcome, period)
        filled += int(length)
        sums[block] = np.where(run.dead[:m] == 1, -np.inf, run.logs[:m])
    strobes = rows[: task.periods, :n]
    section = _crossings(events, task, n) if task.chosen else strobes
    found = find_period(section if task.chosen else strobes, task.max_period)
    exponents, errors, _ = mean_exponents(sums, ends, period)
    if m:
        outcome = classify(exponents, errors, task.neutral, task.periods * period, found)
    elif found:
        outcome = Outcome.PERIODIC
    return Point(section, found, exponents, errors, event_rates(run), outcome, period)


def _advance(run: Run, periods: int, rows: np.ndarray, events: list[np.ndarray] | None) -> Outcome:
    if events is None:
        return run.advance(periods, rows)[0]
    n = len(run.system.states)
    buffer = np.zeros((_EVENT_ROWS, layout.EVENT_COLUMNS + 2 * n))
    filled = 0
    while True:
        outcome, full = run.advance(periods, rows[filled:], buffer)
        periods = 0
        filled += run.filled()[0]
        events.append(buffer[: run.filled()[1]].copy())
        if not full or outcome != Outcome.OK:
            return outcome


def _crossings(events: list[np.ndarray], task: PointTask, n: int) -> np.ndarray:
    """The last states before the chosen events, as many as periods, NaN where there were fewer."""
    table = np.concatenate(events)
    table = table[np.isin(table[:, layout.EVENT_KIND], list(task.chosen or ()))]
    states = table[-task.periods :, layout.EVENT_COLUMNS : layout.EVENT_COLUMNS + n]
    section = np.full((task.periods, n), np.nan)
    section[: len(states)] = states
    return section


def _empty(task: PointTask, system: "HybridSystem", n: int, m: int, outcome: Outcome, period: float) -> Point:
    missing = np.full(m, np.nan)
    names = event_rates(Run(system, 1.0, task.numerics))
    return Point(
        section=np.full((task.periods, n), np.nan),
        period=0,
        exponents=missing,
        errors=missing,
        rates=dict.fromkeys(names, float("nan")),
        outcome=outcome,
        forcing_period=period,
    )
