"""Lyapunov spectra."""

from functools import partial
from typing import Any

import numpy as np
import xarray as xr

from chaosdrill.analysis.arguments import Span, tangent_count
from chaosdrill.analysis.base import Job
from chaosdrill.analysis.recording import flow_of
from chaosdrill.analysis.regularity import LENGTH, repeats_exactly, tell
from chaosdrill.analysis.statistics import (
    SINKS,
    block_ends,
    classify,
    error_of_exponents,
    error_of_mean_rate,
    kaplan_yorke,
    leading,
)
from chaosdrill.dataset import Outcome
from chaosdrill.dataset.schema import names_of_errors
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run, event_rates
from chaosdrill.engine.structure import Structure, examine
from chaosdrill.model import HybridSystem

ALL = 32
"""States up to which all exponents are computed, however few are asked for. Beyond, tangents take most of the time."""


def spectrum(system: HybridSystem, plan: Span, exponents: int | None, blocks: int, job: Job) -> xr.Dataset:
    """Exponents over a span, with a history of so many blocks; see `lyapunov_spectrum`."""
    count = tangent_count(system, exponents)
    structure = examine(system)
    m = computed_exponents(structure, count)
    frame, symmetries = structure.tangents(m) if m else (None, 0)
    samples = 1 if plan.periodic else -(-LENGTH // plan.count)
    run = Run(
        system,
        plan.unit,
        job.numerics,
        tangents=frame,
        symmetries=symmetries,
        deficient=structure.deficient,
        samples=samples,
    )
    outcome = plan.settle(run)
    ends = block_ends(plan.count, blocks)
    sums = np.full((len(ends), m), np.nan)
    drilled = np.full((len(ends), len(system.quadratures)), np.nan)
    sums[0], drilled[0] = 0.0, 0.0
    path = [np.zeros((0, len(system.states) + 1))]
    for block, length in enumerate(np.diff(ends), start=1):
        if outcome != Outcome.OK:
            break
        kept = m and (plan.count - ends[block]) * samples < LENGTH
        outcome = _advance(run, int(length), path) if kept else run.advance(int(length))[0]
        if outcome == Outcome.OK:
            sums[block] = np.where(run.lost[:m] == 1, -np.inf, run.logs[:m])
            drilled[block] = run.integrals()
        if job.progress:
            job.progress(run.strobes, run.strobes + int(ends[-1] - ends[block]), None)
    complete = outcome == Outcome.OK
    values = errors = np.full(m, np.nan)
    history = np.full((len(ends) - 1, m), np.nan)
    if complete and m:
        values, errors, history = mean_exponents(sums, ends, plan.unit, job.numerics, run.steps)
        flow = flow_of(run)
        every = m == len(system.states)
        lead, margin = leading(
            values[np.newaxis],
            errors[np.newaxis],
            int(structure.neutral(flow)),
            np.array([plan.length]),
            complete=every,
        )
        outcome = classify(lead[0], margin[0])
        window, known = np.concatenate(path)[np.newaxis, -LENGTH:], run.sizes[np.newaxis]
        directions = structure.frame[: structure.symmetries]
        if system.period is None and structure.autonomous and every and values[0] * plan.length < -SINKS:
            outcome = Outcome.EQUILIBRIUM
        elif outcome == Outcome.UNDECIDED:
            outcome = Outcome(
                int(tell(window, known, directions, lead, margin, None if plan.periodic else partial(flow_of, run))[0])
            )
        elif outcome == Outcome.PERIODIC and structure.winds(flow):
            outcome = Outcome.QUASIPERIODIC
        elif outcome == Outcome.CHAOTIC and repeats_exactly(window, known, directions)[0]:
            outcome = Outcome.PERIODIC
    ds = xr.Dataset(
        {
            "lyapunov_exponent": ("exponent", values[:count]),
            "lyapunov_error": ("exponent", errors[:count]),
            "lyapunov_history": (("block", "exponent"), history[:, :count]),
            "kaplan_yorke_dimension": ((), kaplan_yorke(values, len(system.states))),
            "outcome": ((), np.int8(outcome)),
        },
        coords={
            "exponent": np.arange(1, count + 1, dtype=np.int32),
            "block_time": ("block", ends[1:] * plan.unit),
        },
    )
    ds = ds.assign(_averages(system, run, plan, job.numerics, ends, drilled, complete))
    message = run.stopped(outcome)
    return ds.assign_attrs(message=message) if message else ds


def computed_exponents(structure: Structure, count: int) -> int:
    """How many exponents are computed if ``count`` are asked for.

    A rank that events may lower is known from all tangents alone.
    """
    n = len(structure.frame)
    if count == 0 or n <= ALL or structure.deficient:
        return n if count else 0
    # of a complex pair only both exponents together are known well, and tangents are stepped in pairs anyway
    return min(max(count, structure.most_neutral + 2), n)


def _advance(run: Run, periods: int, path: list[np.ndarray]) -> Outcome:
    """Go on, and keep the last samples with their modes in ``path``."""
    n, outcome = len(run.system.states), Outcome.OK
    if periods > LENGTH:
        outcome, periods = run.advance(periods - LENGTH)[0], LENGTH
    if outcome != Outcome.OK:
        return outcome
    rows = np.zeros(((periods + 1) * int(run.samples) + 2, n + len(run.system.quadratures) + 1))
    outcome, _ = run.advance(periods, rows)
    path.append(np.delete(rows[: run.filled()[0]], np.s_[n:-1], axis=1)[-LENGTH:])
    return outcome


def mean_exponents(
    sums: np.ndarray, ends: np.ndarray, unit: float, numerics: Numerics, steps: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Exponents, their errors and history in descending order, from logarithms summed up to the end of each block.

    Parameters
    ----------
    sums : ndarray, shape (blocks + 1, m)
        Sums of logarithms, -inf from the block in which a tangent was lost.
    ends : ndarray, shape (blocks + 1,)
        Ends of the blocks in units.
    unit : float
        Length of a unit.
    numerics : Numerics
    steps : int
        Steps that the run took.
    """
    times = ends[1:, np.newaxis] * unit
    history = sums[1:] / times
    finite = np.isfinite(sums[-1])
    errors = np.full(sums.shape[1], np.nan)
    rates = np.diff(sums[:, finite], axis=0) / (np.diff(ends)[:, np.newaxis] * unit)
    errors[finite] = error_of_exponents(rates, numerics, steps, times[-1, 0])
    order = np.argsort(-history[-1], kind="stable")
    return history[-1, order], errors[order], history[:, order]


def _averages(
    system: HybridSystem,
    run: Run,
    plan: Span,
    numerics: Numerics,
    ends: np.ndarray,
    drilled: np.ndarray,
    complete: bool,
) -> dict[str, Any]:
    """What the run counted besides the exponents, without rates if it came to an early end; the closest grazing stays.

    ``drilled`` are the quadratures at the end of each block.
    """
    rates = event_rates(run)
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
        all_of_them = len(run.vectors) == len(system.states)
        variables["rank"] = ((), np.int32(run.live if all_of_them else len(system.states)))
    if plan.periodic:
        variables["forcing_period"] = ((), plan.unit)
    return variables
