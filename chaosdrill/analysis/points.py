"""One point of a sweep: a run from its own initial state, with everything that a diagram keeps of it."""

from collections.abc import Collection, Mapping
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from chaosdrill.analysis.recording import Record, record
from chaosdrill.analysis.spectra import mean_exponents
from chaosdrill.analysis.statistics import classify, find_period
from chaosdrill.dataset import Outcome
from chaosdrill.dataset.outcomes import count_outcomes
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run, event_rates, rate_names
from chaosdrill.engine.structure import examine
from chaosdrill.errors import SettingsError
from chaosdrill.sweep.fingerprint import of_system, origin

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem

_BLOCKS = 32


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
class GridTask:
    """All points of a diagram: each value of the parameter from each start."""

    point: PointTask
    values: tuple[float, ...]
    starts: tuple["HybridSystem", ...]
    points_per_unit: int = 1

    @property
    def units(self) -> int:
        """One a point."""
        return len(self.values) * len(self.starts)

    @property
    def total(self) -> int:
        """Points."""
        return self.units

    def columns(self) -> dict[str, tuple[str, tuple[int, ...]]]:
        """What is kept of a point."""
        m, n = self.point.frame.shape
        return {
            "section": ("f8", (self.point.periods, n)),
            "period": ("i2", ()),
            "lyapunov_exponent": ("f8", (m,)),
            "lyapunov_error": ("f8", (m,)),
            "outcome": ("i1", ()),
            "forcing_period": ("f8", ()),
            **dict.fromkeys(rate_names(self.starts[0]), ("f8", ())),
        }

    def run(self, first: int, count: int) -> dict[str, np.ndarray]:
        """Points in the order of the values, and of the starts at each."""
        arrays = {name: np.zeros((count, *shape), dtype) for name, (dtype, shape) in self.columns().items()}
        for i in range(count):
            value, start = divmod(first + i, len(self.starts))
            point = run_point(self.point, self.values[value], self.starts[start])
            arrays["section"][i] = point.section
            arrays["period"][i] = point.period
            arrays["lyapunov_exponent"][i] = point.exponents
            arrays["lyapunov_error"][i] = point.errors
            arrays["outcome"][i] = point.outcome
            arrays["forcing_period"][i] = point.forcing_period
            for name, rate in point.rates.items():
                arrays[name][i] = rate
        return arrays

    def counts(self, arrays: Mapping[str, np.ndarray]) -> dict[str, int]:
        """Points by outcome."""
        return count_outcomes(arrays["outcome"])

    def fingerprint(self) -> dict[str, Any]:
        """What the numbers depend on."""
        point = self.point
        return {
            "system": of_system(self.starts[0]),
            "sweep": {point.parameter: list(self.values)},
            "starts": [start.initial for start in self.starts],
            "transient": point.transient,
            "periods": point.periods,
            "at": None if point.chosen is None else sorted(point.chosen),
            "max_period": point.max_period,
            "exponents": len(point.frame),
            "numerics": asdict(point.numerics),
            **origin(),
        }


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
    period = float("nan")
    try:
        system = start.with_parameters(**{task.parameter: value})
        period = system.forcing_period() or period
        deficient = examine(system).deficient if task.deficient is None else task.deficient
        run = Run(system, period, task.numerics, tangents=task.frame, shifts=task.shifts, deficient=deficient)
    except SettingsError:
        return _empty(task, start, n, m, Outcome.FAILED, period)
    outcome, _ = run.advance(task.transient)
    if outcome != Outcome.OK:
        return _empty(task, system, n, m, outcome, period)
    run.forget()
    ends = np.unique(np.linspace(0, task.periods, min(_BLOCKS, task.periods) + 1).astype(int))
    sums = np.zeros((len(ends), m))
    records: list[Record] = []
    for block, length in enumerate(np.diff(ends), start=1):
        records.append(record(run, int(length), events=task.chosen is not None, slices=1))
        if records[-1].outcome != Outcome.OK:
            return _empty(task, system, n, m, records[-1].outcome, period)
        sums[block] = np.where(run.dead[:m] == 1, -np.inf, run.logs[:m])
    if task.chosen is None:
        section = np.concatenate([r.samples for r in records])[:, :n]
    else:
        section = _last_crossings(records, task, n)
    found = find_period(section[np.isfinite(section).all(axis=1)], task.max_period)
    exponents, errors, _ = mean_exponents(sums, ends, period)
    if m:
        outcome = classify(exponents, errors, task.neutral, task.periods * period, found)
    elif found:
        outcome = Outcome.PERIODIC
    return Point(section, found, exponents, errors, event_rates(run), outcome, period)


def _last_crossings(records: list[Record], task: PointTask, n: int) -> np.ndarray:
    """The last states before the chosen events, as many as periods, NaN where there were fewer."""
    states = np.concatenate([r.of(task.chosen or set()).states_before() for r in records])[-task.periods :]
    section = np.full((task.periods, n), np.nan)
    section[: len(states)] = states
    return section


def _empty(task: PointTask, system: "HybridSystem", n: int, m: int, outcome: Outcome, period: float) -> Point:
    missing = np.full(m, np.nan)
    return Point(
        section=np.full((task.periods, n), np.nan),
        period=0,
        exponents=missing,
        errors=missing,
        rates=dict.fromkeys(rate_names(system), float("nan")),
        outcome=outcome,
        forcing_period=period,
    )
