"""What points of a grid are on, by their exponents and the points of their section.

Neither decides alone. Before a period doubling a slow transient alternates about the cycle, so that its points come
back after two periods to any tolerance that is wider than its slow decay; near any bifurcation the exponent of a short
run has no sign; in chaos a laminar stretch repeats for a while. What is not beyond doubt is left undecided here.
"""

from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.analysis.judgement.classification import (
    Averages,
    Records,
    add_ends,
    add_later,
    add_record,
    add_rests,
    add_returns,
    add_turns,
    closes_exactly,
    evidence_of,
    undrawn,
)
from chaosdrill.analysis.judgement.recurrence import CLOSE, ROUND_OFF, Recurrence, recurrence, residual_at_largest
from chaosdrill.analysis.judgement.resting import is_left, rests
from chaosdrill.analysis.judgement.statistics import block_ends, error_of_exponents, rounding_of_point
from chaosdrill.analysis.judgement.tori import END, KEPT, LENGTH, aside, stays_late
from chaosdrill.analysis.judgement.words import Evidence, Selectable, words
from chaosdrill.analysis.tuning import PLAN
from chaosdrill.dataset import Outcome
from chaosdrill.dataset.outcomes import MEASURED
from chaosdrill.engine.batch import Batch

if TYPE_CHECKING:
    from chaosdrill.analysis.grids.plan import Plan


@dataclass
class Verdict(Selectable):
    """What P points are on."""

    outcome: np.ndarray
    """int (P,): their outcome without further steps; an exponent near zero alone does not make a torus."""
    period: np.ndarray  # int (P,)
    decided: np.ndarray  # bool (P,): whether that is beyond doubt
    exponents: np.ndarray  # (P, m): descending spectra
    errors: np.ndarray  # (P, m): their standard errors, of lengths that no unit changes
    apart: np.ndarray  # (P, m): how far exponents of such lengths are from them, their error at least
    evidence: Evidence
    cycle: np.ndarray  # int (P,): length of the cycle that the record repeats, in units of lengths; 0: unknown, or none
    moves: np.ndarray  # bool (P,): whether nothing says that the motion dies out


def judge(plan: "Plan", batch: Batch, which: np.ndarray, ends: np.ndarray, before: np.ndarray | None = None) -> Verdict:
    """Judge some points of a batch by the averages over blocks with these ends, and by the section.

    ``before`` are the states of all points before the record, to tell by what only grows.
    """
    window = last_rows(batch.window[which], plan.judged)
    paths, size = aside(window, plan.shifts), plan.shifts.sizes(batch.sizes[which])
    points = np.full(len(which), ends[-1])
    if plan.section is not None:
        points = batch.counts[which][:, sorted(plan.section)].sum(axis=1)
    rounding = _rounding_of_point(plan, batch, which, points)
    found = recurrence(paths, size, plan.max_period, 2 * plan.max_period, rounding)
    noisy = plan.system.draws
    if not plan.maps or noisy:
        # at the ends of parts of a duration, or where the system itself never repeats, a return tells no period
        found = replace(found, period=np.zeros_like(found.period))
    times = batch.times[which]
    if plan.section is not None and plan.system.forced and not plan.system.autonomous:
        found = replace(found, period=_in_phase(plan, batch, which, found.period, ends))
    cycle, certain, lasts = _cycle_length(plan, batch, which, found.period, ends)
    whole = certain & (_first_whole(ends, cycle) >= 0)
    begin = np.where(whole, _first_whole(ends, cycle), 0)
    plain = _means(batch.sums[which], begin, times)
    sums = batch.sums_by_size(which)
    errors = errors_of(plan, batch, which, sums)
    known_means = np.where(whole[:, np.newaxis], plain, np.nan)
    averages = averages_of(plan, batch, which, sums, points, errors, begin, known_means)
    order = np.argsort(-plain, axis=1, kind="stable")
    with np.errstate(invalid="ignore"):
        apart = np.abs(np.where(np.isneginf(plain), 0.0, plain - _means(sums, begin, times)))
    exponents, errors, apart = (np.take_along_axis(one, order, 1) for one in (plain, errors, apart))
    full, known = undrawn(plan.system, window), batch.sizes[which]
    windows = last_rows(full, LENGTH) if full.shape[1] > LENGTH else full
    early = None if before is None else undrawn(plan.system, before[which])
    part = np.minimum(1.0, windows.shape[1] / np.maximum(points, 1))
    records = Records(plan.system, plan.structure, plan.shifts, averages, windows, known, part)
    e = evidence_of(records, batch.outcome[which], early)
    e.measured[:] = plan.exponents > 0
    neutral = add_returns(e, found, lasts, whole, paths, size)
    if not plan.exponents:
        e.recurs &= stays_late(paths, size, found.period, e.rounding)
    centre = _add_exact(plan, e, found, neutral, paths, size)
    if plan.maps and not noisy and plan.exponents:
        rows = np.where(e.ended == Outcome.OK, np.isfinite(full[:, :, 0]).sum(axis=1), 0)
        for count in np.unique(rows[rows >= END]).tolist():
            seen = np.flatnonzero(rows == count)
            _look_closer(plan, e, seen, full[seen, :count], records, int(points[seen].max()))
    e.winds = _winds(plan, batch, which) & ~e.recurs & ~e.noisy
    e.rests, moves = _at_rest(plan, batch, which, e, before)
    e.ended = np.where(e.rests, int(Outcome.OK), e.ended)
    if not plan.maps and not plan.system.forced and not noisy:
        add_turns(e, records, lambda k, *at: batch.rates(int(which[k]), *at))
    outcome = words(e)
    if batch.counts_returns:
        grazed = np.array([plan.where.grazed(of_one) for of_one in times], dtype=bool)
        outcome[grazed & (batch.outcome[which] == Outcome.OK)] = int(Outcome.NO_RETURN)
        exponents[grazed], errors[grazed] = np.nan, np.nan
    decided = _decided(plan, e, outcome, centre, moves)
    repeats = (outcome == Outcome.PERIODIC) & e.recurs & ((e.lead < e.margin) | e.exact | ~e.measured)
    period = np.where(repeats, found.period, 0)
    cycle = np.where(certain & (period > 0), cycle, 0)
    return Verdict(outcome, period, decided, exponents, errors, apart, e, cycle, moves)


def _add_exact(
    plan: "Plan", e: Evidence, found: Recurrence, neutral: np.ndarray, paths: np.ndarray, size: np.ndarray
) -> np.ndarray:
    """Add whether points that come back do so as exactly as a run allows.

    Returns, bool, shape (P,): whether they do so to round-off, and nearby motions neither come closer nor leave.
    """
    at_centre = np.flatnonzero(e.recurs & neutral)
    residual = residual_at_largest(found, at_centre, paths, size, plan.max_period, 2 * plan.max_period)
    exact = np.flatnonzero(e.recurs & ~e.attracts & closes_exactly(e, residual, found.period))
    e.exact[exact] = _returned(paths[exact], size[exact], e.rounding[exact])
    return np.asarray(e.recurs & neutral & (found.residual <= ROUND_OFF))


def _decided(plan: "Plan", e: Evidence, outcome: np.ndarray, centre: np.ndarray, moves: np.ndarray) -> np.ndarray:
    """Which outcomes are beyond doubt; ``centre`` is what `_add_exact` returns."""
    periodic = outcome == Outcome.PERIODIC
    decided = (periodic & (e.attracts | centre)) | ((outcome == Outcome.CHAOTIC) & ~e.recurs)
    decided |= ((outcome == Outcome.QUASIPERIODIC) & e.winds) | (outcome == Outcome.CONTRACTING)
    if not plan.maps:
        decided |= periodic & e.negative
    ended = ~np.isin(outcome, MEASURED) | (outcome == Outcome.EQUILIBRIUM) & e.rests
    return np.asarray((decided & moves) | ended | ~e.measured)


def _returned(paths: np.ndarray, known: np.ndarray, rounding: np.ndarray) -> np.ndarray:
    """Whether all of the later half of some points, shape (P, W, n + 1), comes back to the tolerance, and for good."""
    half = np.isfinite(paths).all(axis=2).sum(axis=1) // 2
    period = np.zeros(len(paths), dtype=np.int64)
    for count in np.unique(half[half > 1]).tolist():
        here = np.flatnonzero(half == count)
        period[here] = recurrence(paths[here], known[here], count, count, rounding[here]).period
    return stays_late(paths, known, period, rounding)


def averages_of(
    plan: "Plan",
    batch: Batch,
    which: np.ndarray,
    sums: np.ndarray,
    points: np.ndarray | int,
    errors: np.ndarray,
    begin: np.ndarray | int = 0,
    known: np.ndarray | float = np.nan,
) -> Averages:
    """Exponents from the beginning of a block to the end, with their ``errors``, of records of equal length.

    They are of lengths that no unit changes, by which words are told, but for those that are ``known``, NaN for none:
    over whole cycles units change no length.
    """
    begin = np.broadcast_to(begin, len(which))
    sums, times, length = batch.sums_by_size(which), batch.times[which], batch.length[which]
    with np.errstate(invalid="ignore", divide="ignore"):
        exponents = np.where(np.isnan(known), _means(sums, begin, times), known)
        late = _means(sums, np.full(len(which), (times.shape[1] - 1) // 2), times)
    order = np.argsort(-exponents, axis=1, kind="stable")
    exponents, errors, late = (np.take_along_axis(one, order, 1) for one in (exponents, errors, late))
    neutral = np.full(len(which), plan.structure.most_neutral)
    if plan.structure.autonomous and plan.structure.symmetries:
        neutral = plan.structure.neutral(batch.flow(which))
    course = np.take_along_axis(sums, order[:, np.newaxis], 2)
    rounding = _rounding_of_point(plan, batch, which, np.broadcast_to(points, len(which)))
    return Averages(exponents, errors, late, course, length, rounding, neutral, plan.computed == plan.system.free)


def _rounding_of_point(plan: "Plan", batch: Batch, which: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Part of the sizes of states that errors may add up to from one of the ``points`` of a record to the next."""
    of = plan.numerics, plan.system.discrete
    return np.asarray(rounding_of_point(*of, batch.steps[which], batch.ends[-1], points))


def errors_of(plan: "Plan", batch: Batch, which: np.ndarray, sums: np.ndarray) -> np.ndarray:
    """Errors of the mean growth of each tangent from all blocks, shape (P, m), by lengths of which ``sums`` are."""
    spans, length = np.diff(batch.times[which], axis=1), batch.length[which]
    with np.errstate(invalid="ignore", divide="ignore"):
        rates = np.diff(sums, axis=1) / spans[..., np.newaxis]
        if batch.counts_returns:
            # blocks that last longer count more
            apart = rates - (sums[:, -1] / length[:, np.newaxis])[:, np.newaxis]
            rates = apart * (spans / spans.mean(axis=1, keepdims=True))[..., np.newaxis]
        rates = np.where(np.isfinite(rates), rates, np.nan).transpose(1, 0, 2)
        return error_of_exponents(rates, plan.numerics, batch.steps[which], length)


def _look_closer(plan: "Plan", e: Evidence, which: np.ndarray, full: np.ndarray, records: Records, points: int) -> None:
    """Look at section points as spectra do: at their ends, and at all of them where records are not extended.

    ``full`` are the last ones of those of ``which``, the same number of each. ``points``: the most a record has.
    """
    some, windows = e.at(which), full[:, -LENGTH:]
    part = min(1.0, windows.shape[1] / max(points, 1))
    late = replace(records.at(which), windows=windows, part=part)
    add_ends(some, late.averages, aside(windows, plan.shifts), plan.shifts.sizes(late.known), part)
    if not plan.max_extension:
        # the last states of blocks; of longer records than are kept only the later ones are known
        ends = block_ends(points, PLAN.blocks)
        coarse = full[:, np.maximum(ends - points + full.shape[1] - 1, 0), :-1]
        add_record(some, full[:, -KEPT:], late.known, coarse, plan.shifts, points)
        add_later(some, late)
    e.put(which, some)


def _winds(plan: "Plan", batch: Batch, which: np.ndarray) -> np.ndarray:
    """Whether nothing but phases moves, point by point."""
    if not (plan.structure.autonomous and plan.structure.symmetries):
        return np.zeros(len(which), dtype=bool)
    return plan.structure.winds(batch.flow(which))


def _at_rest(
    plan: "Plan", batch: Batch, which: np.ndarray, e: Evidence, before: np.ndarray | None
) -> tuple[np.ndarray, np.ndarray]:
    """Which points of a system without forcing are at rest, and which go on moving for all that is known.

    A motion that neither rests nor ends has a zero exponent, that of the flow (Haken 1983,
    doi:10.1016/0375-9601(83)90209-8).
    """
    if plan.system.forced or not plan.structure.autonomous:
        return np.zeros(len(which), dtype=bool), np.ones(len(which), dtype=bool)
    went = np.isin(batch.outcome[which], (Outcome.OK, Outcome.NO_RETURN))
    with np.errstate(invalid="ignore"):
        rest = went & rests(
            batch.x[which], batch.sizes[which], batch.flow(which), plan.where.unit, batch.rounding(which)
        )
    moving = [i for i, t in enumerate(plan.system.transitions) if not t.marks_only()]
    unmoved = batch.counts[which][:, moving].sum(axis=1) == 0

    def left(k: int) -> bool:
        p = int(which[k])
        at = partial(batch.rates, p, mode=int(batch.mode[p]))
        return is_left(at, batch.x[p], batch.sizes[p], None if before is None else before[p])

    add_rests(e, rest, unmoved, left)
    rest &= ~e.stirs
    return rest, ~(rest | e.sinks | e.shrinks) | e.stirs


def _cycle_length(
    plan: "Plan", batch: Batch, which: np.ndarray, period: np.ndarray, ends: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Length of a cycle with a number of iterates, in units of lengths, whether it is certain, and its duration."""
    each = batch.length[which] / ends[-1]
    if plan.section is None or batch.counts_returns:
        return period, period > 0, period * each
    crossings = np.maximum(batch.counts[which][:, sorted(plan.section)].sum(axis=1), 1)
    length = int(ends[-1]) * period / crossings
    if not plan.system.forced:
        return np.zeros_like(period), np.zeros(len(which), dtype=bool), length * each
    cycle = np.rint(length).astype(int)
    # a crossing more or less in the record moves the estimate by this much
    certain = (cycle > 0) & (np.abs(length - cycle) <= (length + 1) / crossings)
    return cycle, certain, cycle * each


def _in_phase(plan: "Plan", batch: Batch, which: np.ndarray, period: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """The least multiples of periods that take whole forcing periods, 0 where none does.

    What comes back to a section at another phase of the forcing goes on otherwise.
    """
    answer = np.zeros_like(period)
    for p in np.flatnonzero(period).tolist():
        times = batch.times[which[p]] / batch.period[which[p]]
        points = int(batch.counts[which[p], sorted(plan.section or ())].sum())
        for multiple in range(period[p], plan.max_period + 1, period[p]):
            begin = int(_first_whole(ends, np.array([multiple]))[0]) if batch.counts_returns else 0
            # the number of points in a record of whole forcing periods
            of = int(ends[-1] - ends[begin]) if batch.counts_returns else points
            turns = (times[-1] - times[begin]) * multiple / max(of, 1)
            # where no part of a record is whole nothing can be said against it
            if abs(turns - np.rint(turns)) <= CLOSE if begin >= 0 else multiple == period[p]:
                answer[p] = multiple
                break
    return answer if batch.counts_returns else np.where(answer > 0, answer, period)


def _first_whole(ends: np.ndarray, cycle: np.ndarray) -> np.ndarray:
    """The first block from which the record consists of whole cycles of a length; -1 without one."""
    fits = (ends[-1] - ends[:-1]) % np.maximum(cycle, 1)[:, np.newaxis] == 0
    return np.where(fits.any(axis=1) & (cycle > 0), fits.argmax(axis=1), -1)


def _means(sums: np.ndarray, begin: np.ndarray, times: np.ndarray) -> np.ndarray:
    """Mean growth rates from the beginning of a block to the end, -inf where rank was lost; shape (P, m)."""
    last, rows = sums[:, -1], np.arange(len(sums))
    time = times[:, -1] - times[rows, begin]
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(np.isneginf(last), -np.inf, (last - sums[rows, begin]) / time[:, np.newaxis])


def last_rows(windows: np.ndarray, count: int) -> np.ndarray:
    """The last points of every window, NaN behind them where there were fewer."""
    rows = np.isfinite(windows[:, :, 0]).sum(axis=1)
    index = np.maximum(rows - count, 0)[:, np.newaxis] + np.arange(count)
    taken = np.take_along_axis(windows, np.minimum(index, windows.shape[1] - 1)[:, :, np.newaxis], axis=1)
    taken[index >= rows[:, np.newaxis]] = np.nan
    return taken
