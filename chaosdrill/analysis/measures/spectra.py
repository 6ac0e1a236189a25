"""Lyapunov spectra."""

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import xarray as xr

from chaosdrill.analysis.arguments import tangent_count
from chaosdrill.analysis.base import Job
from chaosdrill.analysis.judgement.classification import Averages, Records, add_rests, evidence_of_records
from chaosdrill.analysis.judgement.resting import is_left, rests
from chaosdrill.analysis.judgement.statistics import (
    BEYOND,
    ONE_BLOCK,
    block_ends,
    error_of_exponents,
    error_of_mean_rate,
    kaplan_yorke,
    kaplan_yorke_error,
    rounding_of_point,
)
from chaosdrill.analysis.judgement.tori import KEPT, LENGTH
from chaosdrill.analysis.judgement.words import Evidence, reason, words
from chaosdrill.analysis.measures.blocks import Blocks
from chaosdrill.analysis.recording import flow_of, time_of_motion
from chaosdrill.analysis.spans import Span
from chaosdrill.analysis.tuning import PLAN
from chaosdrill.dataset import Outcome
from chaosdrill.dataset.build import dataset
from chaosdrill.dataset.schema import names_of_errors
from chaosdrill.engine.layout import EVENT_COLUMNS, EVENT_KIND, EVENT_MODE
from chaosdrill.engine.lengths import sizes_of_states
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run, event_rates
from chaosdrill.engine.shifts import Shifts, shifts_of
from chaosdrill.engine.structure import Structure, examine
from chaosdrill.model import HybridSystem

ALL = 32
"""States up to which all exponents are computed, however few are asked for. Beyond, tangents take most of the time."""

AT_ONCE = 1024
"""Events between two looks at a run."""


def spectrum(system: HybridSystem, plan: Span, exponents: int | None, blocks: int, job: Job) -> xr.Dataset:
    """Exponents over a span, with a history of ``blocks`` blocks; see `lyapunov_spectrum`."""
    count = tangent_count(system, exponents)
    structure = examine(system)
    m = computed_exponents(structure, count)
    # one more than it takes, so that instants do not fall on a few phases of the turns only
    samples = 1 if plan.periodic else -(-LENGTH // plan.count) + plan.measured
    run = run_with_tangents(system, structure, m, plan.unit, job.numerics, samples)
    outcome = plan.settle(run)
    ends = block_ends(plan.count, blocks)
    # words are made as at points of grids, if blocks can be taken together so
    judged = np.flatnonzero(np.isin(ends, block_ends(plan.count, PLAN.blocks)))
    if len(judged) <= min(PLAN.blocks, plan.count):
        judged = np.arange(len(ends))
    kept = KEPT if plan.periodic else LENGTH
    path = _Path(run, ends, m, kept, passed=not plan.periodic and system.autonomous)
    if outcome == Outcome.OK:
        outcome = path.follow(job)
    complete, why, dimension_error, unknown = outcome == Outcome.OK, "", float("nan"), BEYOND
    means = MeanExponents.unknown(len(ends) - 1, m)
    if complete and m:
        by_size, taken = path.sums_by_size(shifts_of(system, but_of=())), (plan.unit, job.numerics, run.steps)
        means = mean_exponents(path.sums, by_size, ends, *taken)
        for_words = mean_exponents(by_size[judged], by_size[judged], ends[judged], *taken)
        of_method = job.numerics.step_error * run.steps / plan.length
        dimension_error, unknown = kaplan_yorke_error(means.values, means.rates, of_method, plan.length, system.free)
        evidence = _evidence(run, plan, structure, for_words, path, judged, job)
        outcome, why = Outcome(int(words(evidence)[0])), reason(evidence)
    variables = {
        "exponent": np.arange(1, count + 1, dtype=np.int32),
        "block_time": ("block", ends[1:] * plan.unit),
        "lyapunov_exponent": ("exponent", means.values[:count]),
        "lyapunov_error": ("exponent", means.errors[:count]),
        "lyapunov_history": (("block", "exponent"), means.history[:, :count]),
        "kaplan_yorke_dimension": ((), kaplan_yorke(means.values, system.free)),
        "kaplan_yorke_error": ((), dimension_error),
        "outcome": ((), np.int8(outcome)),
        **_averages(run, plan, job.numerics, ends, path.drilled, complete),
    }
    reasons = [why, *_unknown(variables, unknown)] if complete else []
    texts = {"message": plan.message or run.stopped(outcome), "reason": "; ".join(filter(None, reasons))}
    return dataset(variables, ["block_time"], {name: text for name, text in texts.items() if text})


def _unknown(variables: dict[str, Any], of_dimension: str) -> list[str]:
    """Why numbers of a run that reached its end are NaN, by their names."""
    if not of_dimension:
        reasons = []
    elif np.isnan(variables["kaplan_yorke_dimension"][1]):
        reasons = [f"kaplan_yorke_dimension: {of_dimension}"]
    else:
        reasons = [f"kaplan_yorke_error: {of_dimension}"]
    if len(variables["block_time"][1]) == 1:
        errors = [name for name in variables if name.endswith("_error") and not name.startswith("kaplan_yorke")]
        reasons.append(f"{', '.join(errors)}: {ONE_BLOCK}")
    return reasons


def _evidence(
    run: Run, plan: Span, structure: Structure, means: "MeanExponents", path: "_Path", blocks: np.ndarray, job: Job
) -> Evidence:
    """What a run says at its end; ``blocks`` are the places of ends of blocks at which its states are looked at."""
    averages = Averages(
        exponents=means.values[np.newaxis],
        errors=means.errors[np.newaxis],
        late=means.late[np.newaxis],
        course=means.course[np.newaxis],
        length=np.array([plan.length]),
        rounding=rounding_of_point(
            job.numerics, run.system.discrete, np.array([run.steps]), plan.count, plan.count * run.samples
        ),
        neutral=np.array([int(structure.neutral(flow_of(run)))]),
        complete=len(means.values) == run.system.free,
    )
    system, window, known = run.system, path.samples[np.newaxis], run.sizes[np.newaxis]
    flow, shifts = None if plan.periodic else partial(flow_of, run), shifts_of(system, but_of=())
    part = min(1.0, window.shape[1] / (plan.count * run.samples))
    passages = path.passages()[np.newaxis] if path.met else None
    records = Records(system, structure, shifts, averages, window, known, part)
    e = evidence_of_records(records, path.states[blocks][np.newaxis], flow, passages)
    e.winds = structure.winds(flow_of(run)[np.newaxis]) & ~e.noisy
    if not system.forced and structure.autonomous:
        # what moves by more than its size in a record, if it goes on, does not rest; the time of a motion takes a run
        slow = (np.abs(flow_of(run)) * plan.length <= run.sizes).all()
        if slow or e.sinks[0] or e.shrinks[0]:
            time = time_of_motion(system, job.numerics)
            if e.sinks[0] or e.shrinks[0]:
                # what comes to rest within the record has crossed its extent in it
                time = min(time, plan.length)
            e.rests = rests(run.x[np.newaxis], known, flow_of(run), time)
    begin = np.array([float(system.initial[name]) for name in system.state_names])
    left = partial(is_left, partial(flow_of, run), run.x, run.sizes, begin)
    add_rests(e, e.rests, np.array([not path.moved]), lambda _: left())
    return e


def run_with_tangents(
    system: HybridSystem, structure: Structure, count: int, unit: float, numerics: Numerics, samples: int = 1
) -> Run:
    """A run with ``count`` tangents, which keeps their growth."""
    frame, symmetries = structure.tangents(count) if count else (None, 0)
    return Run(
        system, unit, numerics, tangents=frame, symmetries=symmetries, deficient=structure.deficient, samples=samples
    )


def computed_exponents(structure: Structure, count: int) -> int:
    """Number of exponents computed if ``count`` are requested.

    A rank that events may lower is known from all tangents alone.
    """
    n = len(structure.frame)
    if count == 0 or n <= ALL or structure.deficient:
        return n if count else 0
    # of a complex pair only both exponents together are known well, and tangents are stepped in pairs anyway
    return min(max(count, structure.most_neutral + 2), n)


class _Path:
    """A run over its blocks, with its last samples and modes, and, if asked for, the last events that moved its states.

    ``run``: at the beginning of the record. ``ends``, int, shape (B + 1,): where blocks begin and end. ``exponents``:
    tangents whose growth is kept; without any there are no samples. ``kept``: last samples that are. ``passed``:
    whether events are kept.
    """

    def __init__(self, run: Run, ends: np.ndarray, exponents: int, kept: int, *, passed: bool) -> None:
        self._run, self._kept, n = run, kept, len(run.system.state_names)
        self._moves = np.array([not t.marks_only() for t in run.system.transitions], dtype=bool)
        # only the last of all is sampled, of a long block its end
        late = int(((ends[-1] - ends[1:]) * run.samples >= kept).sum()) if exponents else len(ends) - 1
        self._before, begin = late, int(ends[late])
        self._ends = ends[1:]
        if late < len(ends) - 1 and ends[late + 1] - begin > kept:
            begin = int(ends[late + 1]) - kept
            self._ends, self._before = np.insert(self._ends, late, begin), late + 1
        self._wanted = np.append(0, np.searchsorted(self._ends, ends[1:]) + 1)
        self._blocks, self._start = Blocks(run, self._ends, exponents), run.x.copy()
        rows = (int(ends[-1]) - begin + 1) * run.samples + 2 if late < len(ends) - 1 else 0
        self._rows = np.zeros((rows, n + len(run.system.quadratures) + 1))
        self._buffer = np.zeros((AT_ONCE if passed and self._moves.any() else 0, EVENT_COLUMNS + 2 * n))
        self._events: list[np.ndarray] = []
        self.met = 0

    @property
    def moved(self) -> bool:
        """Whether events have moved the states."""
        return bool(self._run.counts[: len(self._moves)][self._moves].any())

    @property
    def sums(self) -> np.ndarray:
        """Logarithms of growth at the beginning and at the end of each block, shape (B + 1, m)."""
        return self._blocks.sums()[self._wanted]

    def sums_by_size(self, shifts: Shifts) -> np.ndarray:
        """The same of lengths that no unit changes, see `Blocks`: others change by as much as units differ, even on
        a cycle. An angle has the size of its circle, however often it has turned.
        """
        sums = self._blocks.sums_by_size(sizes_of_states(self._run.extents, shifts))[self._wanted]
        return np.asarray(sums - sums[0])

    @property
    def drilled(self) -> np.ndarray:
        """Quadratures there, shape (B + 1, q)."""
        return np.concatenate([np.zeros_like(self._blocks.integrals[:1]), self._blocks.integrals])[self._wanted]

    @property
    def states(self) -> np.ndarray:
        """States there, shape (B + 1, n)."""
        return np.concatenate([self._start[np.newaxis], self._blocks.states])[self._wanted]

    @property
    def samples(self) -> np.ndarray:
        """The last samples with their modes."""
        n, filled = len(self._run.system.state_names), self._run.filled()[0]
        return np.delete(self._rows[:filled], np.s_[n:-1], axis=1)[-self._kept :]

    def follow(self, job: Job) -> Outcome:
        """Let the run go on to its end."""
        blocks, progress = self._blocks, job.progress
        total = self._run.strobes + int(self._ends[-1])
        report = (lambda: progress(self._run.strobes, total, None)) if progress else None
        outcome = blocks.go_on(self._before, report=report)
        if outcome != Outcome.OK:
            return outcome
        return blocks.go_on(len(self._ends), self._rows, self._buffer, drain=self._drain, report=report)

    def _drain(self) -> None:
        if met := self._run.filled()[1]:
            events = self._buffer[:met]
            self._events.append(events[self._moves[events[:, EVENT_KIND].astype(int)]])
            self.met += len(self._events[-1])
        if self.met > 2 * KEPT:
            self._events, self.met = [np.concatenate(self._events)[-KEPT:]], KEPT

    def passages(self) -> np.ndarray:
        """States after the last events of the transition that moved them most often, and the modes before."""
        events, n = np.concatenate(self._events)[-KEPT:], len(self._run.system.state_names)
        kinds = events[:, EVENT_KIND].astype(int)
        kept = events[kinds == np.bincount(kinds).argmax()]
        modes = kept[:, EVENT_MODE, np.newaxis]
        return np.concatenate([kept[:, EVENT_COLUMNS + n :], modes], axis=1)


@dataclass(frozen=True)
class MeanExponents:
    """Exponents of a record of B blocks, in descending order."""

    values: np.ndarray  # (m,)
    errors: np.ndarray  # (m,)
    history: np.ndarray  # (B, m): means up to the end of each block
    late: np.ndarray  # (m,): growth rates over the later half of the record
    course: np.ndarray  # (B + 1, m): logarithms of growth at the beginning and at the end of each block
    rates: np.ndarray  # (B, m): over each block, of lengths which no unit changes; 0 where a tangent was lost

    @classmethod
    def unknown(cls, blocks: int, exponents: int) -> "MeanExponents":
        """Those of a run that came to an early end: NaN."""
        one, each = np.full(exponents, np.nan), np.full((blocks, exponents), np.nan)
        return cls(one, one, each, one, np.full((blocks + 1, exponents), np.nan), each)


def mean_exponents(
    sums: np.ndarray, by_size: np.ndarray, ends: np.ndarray, unit: float, numerics: Numerics, steps: int
) -> MeanExponents:
    """Exponents with their errors, from logarithms summed up to the end of each block.

    ``sums``, ``by_size``, shape (blocks + 1, m): sums of logarithms, -inf from the block in which a tangent was lost,
    of lengths as they are, for the exponents, and by sizes, for the errors. ``ends``, shape (blocks + 1,): ends of the
    blocks in units. ``unit``: length of a unit. ``steps``: steps that the run took.
    """
    times = ends[1:, np.newaxis] * unit
    history = sums[1:] / times
    finite = np.isfinite(sums[-1])
    errors = np.full(sums.shape[1], np.nan)
    rates = np.zeros_like(history)
    rates[:, finite] = np.diff(by_size[:, finite], axis=0) / (np.diff(ends)[:, np.newaxis] * unit)
    apart = np.abs(sums[-1, finite] - by_size[-1, finite]) / times[-1]
    errors[finite] = error_of_exponents(rates[:, finite], numerics, steps, times[-1, 0], apart)
    half = (len(ends) - 1) // 2
    with np.errstate(invalid="ignore"):
        late = (sums[-1] - sums[half]) / ((ends[-1] - ends[half]) * unit)
    late = np.where(finite, late, -np.inf)
    order = np.argsort(-history[-1], kind="stable")
    return MeanExponents(
        history[-1, order], errors[order], history[:, order], late[order], sums[:, order], rates[:, order]
    )


def _averages(
    run: Run, plan: Span, numerics: Numerics, ends: np.ndarray, drilled: np.ndarray, complete: bool
) -> dict[str, Any]:
    """What the run counted besides the exponents, without rates if it came to an early end; the closest grazing stays.

    ``drilled`` are the quadratures at the end of each block.
    """
    system, rates = run.system, event_rates(run)
    if not complete:
        rates |= {name: np.nan for name in rates if name != "closest_grazing"}
    variables: dict[str, Any] = {
        "event_count": ("transition", run.counts[: len(system.transitions)].copy()),
        "transition": np.array([t.name for t in system.transitions], dtype=str),
        "tie_count": ((), np.int64(run.ties)),
        **{name: ((), value) for name, value in rates.items()},
    }
    times = ends * plan.unit
    errors = error_of_mean_rate(drilled, times[:, np.newaxis], numerics, run.moved / times[-1])
    variables |= {name: ((), error) for name, error in zip(names_of_errors(system.quadratures), errors, strict=True)}
    if len(run.vectors):
        all_of_them = len(run.vectors) == system.free
        variables["rank"] = ((), np.int32(run.live if all_of_them else system.free))
    if plan.periodic:
        variables["forcing_period"] = ((), plan.unit)
    return variables
