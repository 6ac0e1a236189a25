"""Chaos that does not last: how long runs stay, the rate at which they leave, and the saddle that they leave from.

Ages are counted in units, forcing periods or parts of a duration. With forcing, of all periods that runs begin beyond a
least age, the share in which they leave is the estimate of greatest likelihood for lives that end by chance alone,
whether runs have left or only been watched for so long. Without forcing lives may end at any time, or at some instants
alone, such as multiples of a time of flight: there the number of runs that are left is averaged over all instants of a
stretch, and compared with its average over a later one.
"""

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import xarray as xr

from chaosdrill.analysis.starts import drawn_or_listed
from chaosdrill.analysis.statistics import block_ends
from chaosdrill.dataset import Outcome
from chaosdrill.dataset.build import dataset
from chaosdrill.engine.batch import Batch, Returns
from chaosdrill.engine.structure import examine
from chaosdrill.model import HybridSystem
from chaosdrill.model.noise import seeds_of_starts
from chaosdrill.model.surface import surface

if TYPE_CHECKING:
    from chaosdrill.analysis.base import Job

PARTS = 1024
"""Units in which lifetimes are given."""

EARLY, LATE = 0.25, 0.625
"""Quantiles of lives between which the rate of a flow is taken: half of the runs leave meanwhile, and lives that end at
multiples of a time differ by one."""

TOGETHER = 4096
"""Starts of a batch."""

SURVIVORS = 100
"""Runs that are to reach the age at which the saddle is looked at: the most that do."""

MARGIN = 0.25
"""Part of that age, at its beginning and at its end, in which runs still come to the saddle or leave it already."""

VISITS = 10
"""States of a run that are kept as points on the saddle, at most."""

NONE_SEEN = 1.5
"""Expected escapes of which twice as many would have shown one in 95 % of all cases: the error of a rate of zero."""

FEWEST = 20
"""Escapes in each half without which these are not compared."""

AT_ONCE = "all runs that count leave at one age, so that no rate is told: take other starts, or more of them"

STEP = 1e-6
"""Step of a difference of dimensions, in parts of the largest exponent: they have kinks at whole numbers only."""


class _Lives(NamedTuple):
    """What became of runs, one entry each."""

    length: np.ndarray  # time until they left, or as long as they were watched
    units: np.ndarray  # whole units of it
    left: np.ndarray  # whether they left
    outcome: np.ndarray


class _Saddle(NamedTuple):
    """What runs that stay long tell of the saddle."""

    points: np.ndarray  # (K, n)
    exponents: np.ndarray  # (m,): descending
    errors: np.ndarray  # (m,)
    rates: np.ndarray  # (R, m): of single runs
    moved: np.ndarray  # (m,): exponents less those over the first half of the lives


class Rate(NamedTuple):
    """An escape rate, per unit or per time."""

    value: float
    error: float
    escapes: int


def transients(system: HybridSystem, given: Any, job: "Job") -> xr.Dataset:
    """Lifetimes, escape rate and saddle; see `transient_chaos`."""
    marked, ends = _marked(system, given.until)
    starts, modes = drawn_or_listed(system, given)
    period = system.forcing_period()
    forced = period is not None
    unit, count = (given.duration / PARTS, PARTS) if period is None else (period, given.periods)
    report = job.report(2 * len(starts))
    lives = _watched(marked, ends, starts, modes, unit, count, job, report)
    lead = min(int(np.median(lives.units)), count // 4) if given.transient is None else given.transient
    if not forced and given.transient is not None:
        lead = math.ceil(given.transient / unit * (1 - 1e-12))
    if forced:
        left = lives.left & (lives.units < count)
        rate, changes = escape_rate(lives.units, left, lead), drift(lives.units, left, lead)
        rate = Rate(rate.value / unit, rate.error / unit, rate.escapes)
    else:
        whole = lives.length[lives.left | (lives.outcome == Outcome.OK)]
        rate, changes = rate_of_flow(whole, lead * unit, count * unit), drift_of_flow(whole, lead * unit, count * unit)
    dimension = (math.nan, math.nan)
    saddle = _saddle(marked, ends, starts, modes, lives.units, unit, lead, job)
    if len(saddle.rates) and math.isfinite(rate.value + rate.error):
        flows = system.autonomous and not system.discrete
        dimension = dimension_of_saddle(saddle.rates, saddle.moved, rate, flows=flows)
    if report:
        report(2 * len(starts))
    alive = np.array([(lives.units >= age).sum() for age in range(count + 1)]) / len(starts)
    return dataset(
        {
            "lifetime": ("start", lives.length),
            "outcome": ("start", lives.outcome.astype(np.int8)),
            "initial_state": (("start", "state"), starts),
            "surviving": ("age", alive),
            "escape_rate": ((), rate.value),
            "escape_rate_error": ((), rate.error),
            "escapes": ((), np.int64(rate.escapes)),
            "drift": ((), changes),
            "least_age": ((), lead * unit),
            "saddle_state": (("point", "state"), saddle.points),
            "saddle_dimension": ((), dimension[0]),
            "saddle_dimension_error": ((), dimension[1]),
            "lyapunov_exponent": ("exponent", saddle.exponents),
            "lyapunov_error": ("exponent", saddle.errors),
            **({"forcing_period": ((), unit)} if forced else {}),
            "start": np.arange(1, len(starts) + 1, dtype=np.int32),
            "age": np.arange(count + 1) * unit,
            "state": list(system.state_names),
            "exponent": np.arange(1, system.free + 1, dtype=np.int32),
        },
        attrs={"reason": AT_ONCE} if rate.escapes and math.isnan(rate.value) else None,
    )


def escape_rate(units: np.ndarray, left: np.ndarray, lead: int) -> Rate:
    """The escape rate per unit and its standard error, by maximum likelihood from lives that may have been cut.

    Parameters
    ----------
    units : ndarray of int, shape (N,)
        Whole units that each run stayed.
    left : ndarray of bool, shape (N,)
        Whether it left in the next one; else it was watched no longer.
    lead : int
        Units from which on lives count.
    """
    old = units >= lead
    escapes = int((old & left).sum())
    trials = int((units[old] - lead).sum()) + escapes
    if trials == escapes:
        # nothing was watched, or all left at once
        return Rate(math.nan, math.nan, escapes)
    share = escapes / trials
    error = math.sqrt(share / ((1 - share) * trials)) if escapes else NONE_SEEN / trials
    return Rate(-math.log1p(-share), error, escapes)


def drift(units: np.ndarray, left: np.ndarray, lead: int) -> float:
    """Difference of the rates of the later and the earlier half of all escapes, in its standard errors."""
    gone = np.sort(units[left & (units >= lead)])
    if len(gone) < 2 * FEWEST:
        return math.nan
    middle = int(gone[len(gone) // 2])
    early = escape_rate(np.minimum(units, middle), left & (units < middle), lead)
    late = escape_rate(units, left, middle)
    return _apart(early, late)


def _apart(early: Rate, late: Rate) -> float:
    if min(early.escapes, late.escapes) < FEWEST or not math.isfinite(early.value + late.value):
        return math.nan
    return (late.value - early.value) / math.hypot(late.error, early.error)


def rate_of_flow(lengths: np.ndarray, lead: float, longest: float) -> Rate:
    """The escape rate per time and its standard error, from lives that may end at any time or at some instants alone.

    The logarithm of the ratio of two integrals of the number of runs that are left, one over a later stretch, divided
    by the time between them. A run adds to both, independently of others.

    Parameters
    ----------
    lengths : ndarray, shape (N,)
        Times that the runs stayed, ``longest`` for those that were watched no longer.
    lead : float
        Age from which lives count.
    """
    gone = np.sort(lengths[(lengths > lead) & (lengths < longest)])
    exposed = float((np.minimum(lengths, longest) - lead).clip(0.0).sum())
    if not exposed > 0:
        return Rate(math.nan, math.nan, len(gone))
    if not len(gone):
        return Rate(0.0, NONE_SEEN / exposed, 0)
    early, late = gone[int(EARLY * len(gone))], gone[int(LATE * len(gone))]
    if not late > early:
        late = gone[min(np.searchsorted(gone, early, side="right"), len(gone) - 1)]
    gap = late - early if late > early else (longest - lead) / 2
    before = lengths.clip(lead, longest - gap) - lead
    after = lengths.clip(lead + gap, longest) - (lead + gap)
    if not (before.sum() > 0 and after.sum() > 0):
        return Rate(math.nan, math.nan, len(gone))
    scatter = before / before.sum() - after / after.sum()
    value = math.log(before.sum() / after.sum()) / gap
    # few escapes show too little scatter: about Student's factor for as many degrees of freedom less 1
    few = math.sqrt((len(gone) + 3) / max(len(gone) - 1, 0.5))
    return Rate(value, few * math.sqrt(float((scatter**2).sum())) / gap, len(gone))


def drift_of_flow(lengths: np.ndarray, lead: float, longest: float) -> float:
    """As `drift`, of such lives."""
    gone = np.sort(lengths[(lengths > lead) & (lengths < longest)])
    if len(gone) < 2 * FEWEST:
        return math.nan
    middle = gone[len(gone) // 2]
    early, late = rate_of_flow(lengths, lead, middle), rate_of_flow(lengths, middle, longest)
    return _apart(early, late)


def _marked(system: HybridSystem, until: str | None) -> tuple[HybridSystem, list[int]]:
    """The system with the transitions that end a life, and their numbers."""
    if until is None:
        return system, []
    named = [i for i, t in enumerate(system.transitions) if until in (t.name, t.kind)]
    if named:
        return system, named
    marked, marks = surface(system, until)
    return marked, sorted(marks)


def _parts(count: int) -> Iterator[slice]:
    yield from (slice(first, min(first + TOGETHER, count)) for first in range(0, count, TOGETHER))


def _watched(
    system: HybridSystem,
    ends: list[int],
    starts: np.ndarray,
    modes: np.ndarray,
    unit: float,
    count: int,
    job: "Job",
    report: Any,
) -> _Lives:
    """Run all starts until they leave, or to the end."""
    length, outcome = np.zeros(len(starts)), np.zeros(len(starts), dtype=np.int64)
    counted: dict[str, Any] = {"section": set(ends), "returns": Returns(count * unit)} if ends else {}
    for part in _parts(len(starts)):
        seeds = seeds_of_starts(system, np.arange(part.start, part.stop))
        batch = Batch(system, seeds, starts[part], modes[part], job.numerics, unit=unit, **counted)
        batch.run(0, np.array([0, 1 if ends else count]))
        length[part], outcome[part] = batch.elapsed, batch.outcome
        if report:
            report(part.stop)
    if ends:
        met = outcome == Outcome.OK
        stayed = np.isin(outcome, (Outcome.NO_RETURN, Outcome.EQUILIBRIUM))
        outcome = np.where(met, int(Outcome.ESCAPED), np.where(stayed, int(Outcome.OK), outcome))
        length = np.where(stayed, count * unit, length)
    units = np.minimum(np.floor(length / unit + 1e-9).astype(np.int64), count)
    # within a step of a map nothing happens
    return _Lives(units * unit if system.discrete else length, units, outcome == Outcome.ESCAPED, outcome)


def _saddle(
    system: HybridSystem,
    ends: list[int],
    starts: np.ndarray,
    modes: np.ndarray,
    units: np.ndarray,
    unit: float,
    lead: int,
    job: "Job",
) -> _Saddle:
    """Points on the saddle and its exponents with their errors, from runs that stay long (sprinkler).

    In the middle of a long life a run is near the saddle: it has come along the stable manifold, and has not yet left
    along the unstable one.
    """
    n = len(system.state_names)
    unknown = np.full(system.free, np.nan)
    none = _Saddle(np.zeros((0, n)), unknown, unknown, np.zeros((0, system.free)), unknown)
    if len(units) < SURVIVORS:
        return none
    age = int(np.sort(units)[-SURVIVORS])
    margin = max(lead, math.ceil(MARGIN * age))
    window = age - 2 * margin
    if window < 1:
        return none
    structure = examine(system)
    frame, symmetries = structure.tangents(system.free)
    old = np.flatnonzero(units >= margin)
    points, growth = [], []
    lengths = np.diff(block_ends(window, VISITS))
    early = lengths[: len(lengths) // 2].sum()
    for part in _parts(len(old)):
        which = old[part]
        batch = Batch(
            system, seeds_of_starts(system, which), starts[which], modes[which], job.numerics, unit=unit,
            tangents=frame, symmetries=symmetries, deficient=structure.deficient,
        )  # fmt: skip
        stay = _still_there(batch, np.arange(len(which)), margin, ends)
        seen, grown = [], []
        for length in lengths.tolist():
            stay = _still_there(batch, stay, length, ends)
            grown.append(batch.sums_by_size(np.arange(len(which)))[:, -1])
            seen.append(batch.x.copy())
        stay = _still_there(batch, stay, margin, ends)
        points.append(np.concatenate([states[stay] for states in seen]))
        growth.append(np.array([sums[stay] for sums in grown]))
    parts = np.concatenate(growth, axis=1)
    rates = parts.sum(axis=0) / (window * unit)
    if len(rates) < 2:
        return none
    means = rates.mean(axis=0)
    order = np.argsort(-means, kind="stable")
    half, moved = len(lengths) // 2, np.zeros(system.free)
    with np.errstate(invalid="ignore"):
        errors = rates.std(axis=0, ddof=1) / math.sqrt(len(rates))
        if half:
            # a mean that still moves along the lives is not yet that of the saddle
            moved = means - parts[:half].sum(axis=0).mean(axis=0) / (early * unit)
            errors = np.hypot(errors, moved)
    return _Saddle(np.concatenate(points), means[order], errors[order], rates[:, order], moved[order])


def dimension_of_saddle(rates: np.ndarray, moved: np.ndarray, rate: Rate, *, flows: bool) -> tuple[float, float]:
    """The information dimension of a saddle by its exponents and escape rate, and its standard error.

    Parameters
    ----------
    rates, moved : ndarray, shapes (R, m), (m,)
        Exponents of single runs, and how far their means still move along the lives.
    flows : bool
        Whether one direction is that of a flow, which adds 1.
    """
    exponents = rates.mean(axis=0)
    found = _information_dimension(exponents, rate.value, flows=flows)
    known = np.flatnonzero(np.isfinite(exponents))
    step = STEP * max(float(np.abs(exponents[known]).max(initial=0.0)), rate.value)
    if math.isnan(found) or not step > 0:
        return found, math.nan

    def slope(on: np.ndarray, on_rate: float) -> float:
        ends = [
            _information_dimension(exponents + s * on, rate.value + s * on_rate, flows=flows) for s in (-step, step)
        ]
        return (ends[1] - ends[0]) / (2 * step)

    weights = np.array([slope(np.eye(len(exponents))[k], 0.0) for k in known])
    by_chance = float((rates[:, known] @ weights).std(ddof=1)) / math.sqrt(len(rates))
    return found, math.hypot(
        by_chance, float(moved[known] @ weights), slope(np.zeros_like(exponents), 1.0) * rate.error
    )


def _information_dimension(exponents: np.ndarray, rate: float, *, flows: bool) -> float:
    """Of a saddle: its entropy, the sum of the positive exponents less the escape rate, fills directions on both sides.

    Those of the slowest growth and of the slowest decay are filled first (Hunt, Ott and Yorke 1996,
    doi:10.1103/PhysRevE.54.4819; of maps of the plane Kantz and Grassberger 1985).
    """
    if np.isnan(exponents).any():
        return math.nan
    if flows:
        exponents = np.delete(exponents, np.abs(exponents).argmin())
    entropy = max(float(exponents[exponents > 0].sum()) - rate, 0.0)
    total = float(flows)
    for side in (np.sort(exponents[exponents > 0]), np.sort(-exponents[exponents <= 0])):
        left = entropy
        for growth in side.tolist():
            if left < growth:
                total += left / growth
                break
            left, total = left - growth, total + 1
    return total


def _still_there(batch: Batch, which: np.ndarray, units: int, ends: list[int]) -> np.ndarray:
    """Continue over a number of units; return which of some runs have not left meanwhile."""
    batch.proceed(which, 0, np.array([0, units]))
    gone = batch.counts[which][:, ends].any(axis=1)
    return which[(batch.outcome[which] == Outcome.OK) & ~gone]
