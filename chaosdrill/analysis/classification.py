"""Classification of points by their exponents and recurrence together.

Neither decides alone. Before a period doubling a slow transient alternates about the cycle, so that its points come
back after two periods to any tolerance that is wider than its slow decay; near any bifurcation the exponent of a short
run has no sign; in chaos a laminar stretch repeats for a while. What is not beyond doubt is left undecided here.
"""

from dataclasses import dataclass, replace

import numpy as np

from chaosdrill.analysis.plan import Plan
from chaosdrill.analysis.recurrence import CLOSE, ROUND_OFF, recurrence
from chaosdrill.analysis.regularity import only_grows, rests
from chaosdrill.analysis.statistics import SINKS, STAYS, error_of_exponents, leading
from chaosdrill.dataset import Outcome
from chaosdrill.dataset.outcomes import MEASURED
from chaosdrill.engine.batch import Batch

SPLIT = 1e-5
"""Least relative distance between the points of a cycle for which it is told from one of half its period."""

DECAY = 1e-4
"""A transient whose points nearly come back after twice the period of its cycle loses more than this part of its
amplitude meanwhile, so far from the doubling as is asked for."""

NEUTRAL = 1e-6
"""Logarithm of a multiplier that counts as zero."""

HYPERBOLIC = 1e-5
"""Logarithm of a multiplier, averaged over whole cycles, below which a cycle is attracting."""


@dataclass
class Verdict:
    """What P points are on."""

    outcome: np.ndarray
    """int (P,): what they are on if nothing more is done; an exponent that is not told from zero alone makes no
    torus."""
    period: np.ndarray  # int (P,)
    decided: np.ndarray  # bool (P,): whether that is beyond doubt
    exponents: np.ndarray  # (P, m): descending spectra
    errors: np.ndarray  # (P, m): their standard errors
    lead: np.ndarray  # (P,): largest exponent that is free to have any sign
    margin: np.ndarray  # (P,): from where on it is told from zero
    multiplier: np.ndarray  # (P,): logarithm of the leading multiplier of the cycle, where there is one
    cycle: np.ndarray  # int (P,): length of the cycle that the record repeats, in units of lengths; 0: unknown, or none
    moves: np.ndarray  # bool (P,): whether nothing says that the motion dies out


def judge(plan: Plan, batch: Batch, which: np.ndarray, ends: np.ndarray, before: np.ndarray | None = None) -> Verdict:
    """Judge some points of a batch by the averages over blocks with these ends, and by the section.

    ``before`` are the states of all points before the record, to tell by what only grows.
    """
    found = recurrence(batch.window[which], batch.sizes[which], plan.max_period, 2 * plan.max_period)
    if not plan.maps:
        # at the ends of parts of a duration, or where the system itself never repeats, a return tells no period
        found = replace(found, period=np.zeros_like(found.period))
    times, length = batch.times[which], batch.length[which]
    if plan.section is not None and plan.system.period is not None and not plan.system.autonomous:
        found = replace(found, period=_in_phase(plan, batch, which, found.period, ends))
    cycle, certain, lasts = _cycle_length(plan, batch, which, found.period, ends)
    whole = certain & (_first_whole(ends, cycle) >= 0)
    begin = np.where(whole, _first_whole(ends, cycle), 0)
    sums = batch.sums[which]
    with np.errstate(invalid="ignore", divide="ignore"):
        exponents = _means(sums, begin, times)
        spans = np.diff(times, axis=1)
        rates = np.diff(sums, axis=1) / spans[..., np.newaxis]
        if batch.counts_returns:
            # blocks that last longer count more
            apart = rates - (sums[:, -1] / length[:, np.newaxis])[:, np.newaxis]
            rates = apart * (spans / spans.mean(axis=1, keepdims=True))[..., np.newaxis]
        rates = np.where(np.isfinite(rates), rates, np.nan).transpose(1, 0, 2)
        errors = error_of_exponents(rates, plan.numerics, batch.steps[which], length)
    order = np.argsort(-exponents, axis=1, kind="stable")
    exponents, errors = np.take_along_axis(exponents, order, 1), np.take_along_axis(errors, order, 1)
    neutral, winds = _known(plan, batch, which)
    lead, margin = leading(exponents, errors, neutral, length, complete=plan.computed == batch.x.shape[1])
    with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
        multiplier = lead * lasts
        distance = found.residual / -np.expm1(np.minimum(multiplier, -1e-300))
        split = (found.splitting > SPLIT) & (found.residual <= DECAY * found.splitting)
        recurs = (found.period > 0) & split
        attracting = np.where(whole, multiplier < -HYPERBOLIC, lead < -margin)
        settled = recurs & attracting & (distance <= CLOSE) & (found.splitting > 10 * distance)
        centre = recurs & whole & (found.residual <= ROUND_OFF) & (np.abs(multiplier) <= NEUTRAL)
        chaotic = (found.period == 0) & (lead > margin)
        repeats = recurs & ((lead < margin) | (found.residual <= ROUND_OFF))
        outcome = np.select(
            [repeats, lead > margin, lead < -margin],
            [int(Outcome.PERIODIC), int(Outcome.CHAOTIC), int(Outcome.PERIODIC)],
            int(Outcome.UNDECIDED),
        )
    winds &= (outcome == Outcome.PERIODIC) & ~repeats
    outcome[winds] = int(Outcome.QUASIPERIODIC)
    unclear = np.flatnonzero(outcome == Outcome.UNDECIDED)
    outcome[unclear[_only_grow(plan, batch, which[unclear], before)]] = int(Outcome.OPEN)
    decided = settled | centre | chaotic | winds
    rest, sinks, moves = _at_rest(plan, batch, which, exponents, length)
    if not plan.maps:
        decided |= moves & (lead < -margin)
    if plan.exponents == 0:
        repeats, decided = recurs, np.ones(len(which), dtype=bool)
        outcome = np.where(recurs, int(Outcome.PERIODIC), int(Outcome.OK))
    else:
        outcome[np.isnan(lead)] = int(Outcome.NONFINITE)
    decided = (decided & moves) | rest
    outcome = np.where(batch.outcome[which] != Outcome.OK, batch.outcome[which], outcome)
    if batch.counts_returns:
        grazed = np.array([plan.where.grazed(of_one) for of_one in times], dtype=bool)
        outcome[grazed & (batch.outcome[which] == Outcome.OK)] = int(Outcome.NO_RETURN)
        exponents[grazed], errors[grazed] = np.nan, np.nan
    outcome[rest | (sinks & (outcome == Outcome.PERIODIC))] = int(Outcome.EQUILIBRIUM)
    ended = ~np.isin(outcome, MEASURED)
    period = np.where(repeats & ~ended & (outcome != Outcome.EQUILIBRIUM), found.period, 0)
    return Verdict(
        outcome=outcome,
        period=period,
        decided=decided | ended,
        exponents=exponents,
        errors=errors,
        lead=lead,
        margin=margin,
        multiplier=multiplier,
        cycle=np.where(certain & (period > 0), cycle, 0),
        moves=moves,
    )


def _known(plan: Plan, batch: Batch, which: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """How many exponents are zero whatever the attractor, and whether nothing but phases moves, point by point."""
    structure = plan.structure
    if not (structure.autonomous and structure.symmetries):
        return np.full(len(which), structure.most_neutral), np.zeros(len(which), dtype=bool)
    flow = batch.flow(which)
    return structure.neutral(flow), structure.winds(flow)


def _at_rest(
    plan: Plan, batch: Batch, which: np.ndarray, exponents: np.ndarray, length: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Which points of a system without forcing are at rest, which are on their way there, and which go on moving.

    A motion that neither rests nor ends has a zero exponent, that of the flow (Haken 1983,
    doi:10.1016/0375-9601(83)90209-8).
    """
    none = np.zeros(len(which), dtype=bool)
    if plan.system.period is not None or not plan.structure.autonomous:
        return none, none, ~none
    went = np.isin(batch.outcome[which], (Outcome.OK, Outcome.NO_RETURN))
    with np.errstate(invalid="ignore"):
        rest = went & rests(batch.x[which], batch.sizes[which], batch.flow(which), plan.where.unit)
        if plan.computed < batch.x.shape[1]:
            return rest, none, ~rest
        growth = exponents[:, 0] * length
        return rest, growth < -SINKS, ~rest & ~(growth < -STAYS)


def _only_grow(plan: Plan, batch: Batch, which: np.ndarray, before: np.ndarray | None) -> np.ndarray:
    """Whether a state only grows along the sections of some points, the symmetries aside."""
    symmetries = plan.structure.frame[: plan.structure.symmetries]
    states = batch.window[which][:, :, :-1]
    begin = states[:, 0] if before is None else before[which]
    return np.asarray(
        only_grows(states - (states @ symmetries.T) @ symmetries, begin - (begin @ symmetries.T) @ symmetries).any(
            axis=1
        )
    )


def _cycle_length(
    plan: Plan, batch: Batch, which: np.ndarray, period: np.ndarray, ends: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Units of lengths of a cycle of so many iterates, whether that is certain, and the time that it takes."""
    each = batch.length[which] / ends[-1]
    if plan.section is None or batch.counts_returns:
        return period, period > 0, period * each
    crossings = np.maximum(batch.counts[which][:, sorted(plan.section)].sum(axis=1), 1)
    length = int(ends[-1]) * period / crossings
    if plan.system.period is None:
        return np.zeros_like(period), np.zeros(len(which), dtype=bool), length * each
    cycle = np.rint(length).astype(int)
    # a crossing more or less in the record moves the estimate by this much
    certain = (cycle > 0) & (np.abs(length - cycle) <= (length + 1) / crossings)
    return cycle, certain, cycle * each


def _in_phase(plan: Plan, batch: Batch, which: np.ndarray, period: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """The least multiples of periods that take whole forcing periods, 0 where none does.

    What comes back to a section at another phase of the forcing goes on otherwise.
    """
    answer = np.zeros_like(period)
    for p in np.flatnonzero(period).tolist():
        times = batch.times[which[p]] / batch.period[which[p]]
        points = int(batch.counts[which[p], sorted(plan.section or ())].sum())
        for multiple in range(period[p], plan.max_period + 1, period[p]):
            begin = int(_first_whole(ends, np.array([multiple]))[0]) if batch.counts_returns else 0
            # a record of whole forcing periods holds so many points
            of = int(ends[-1] - ends[begin]) if batch.counts_returns else points
            turns = (times[-1] - times[begin]) * multiple / max(of, 1)
            # where no part of a record is whole nothing can be said against it
            if abs(turns - np.rint(turns)) <= CLOSE if begin >= 0 else multiple == period[p]:
                answer[p] = multiple
                break
    return answer if batch.counts_returns else np.where(answer > 0, answer, period)


def _first_whole(ends: np.ndarray, cycle: np.ndarray) -> np.ndarray:
    """The first block from which on the record is whole cycles of a length; -1 if there is none."""
    fits = (ends[-1] - ends[:-1]) % np.maximum(cycle, 1)[:, np.newaxis] == 0
    return np.where(fits.any(axis=1) & (cycle > 0), fits.argmax(axis=1), -1)


def _means(sums: np.ndarray, begin: np.ndarray, times: np.ndarray) -> np.ndarray:
    """Mean growth rates from the beginning of a block to the end, -inf where rank was lost; shape (P, m)."""
    last, rows = sums[:, -1], np.arange(len(sums))
    growth = last - sums[rows, begin]
    time = times[:, -1] - times[rows, begin]
    return np.where(np.isneginf(last), -np.inf, growth / time[:, np.newaxis])
