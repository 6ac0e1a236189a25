"""Chaos that does not last: how long runs stay, the rate at which they leave, and the saddle that they leave from.

Ages are counted in units, forcing periods or parts of a duration. With forcing, of all periods that runs begin beyond a
least age, the share in which they leave is the estimate of greatest likelihood for lives that end by chance alone,
whether runs have left or only been watched for so long. Without forcing lives may end at any time, or at some instants
alone, such as multiples of a time of flight: there the number of runs that are left is averaged over all instants of a
stretch, and compared with its average over a later one.
"""

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import xarray as xr

from chaosdrill.analysis.measures.saddles import SHORT, Runs, Saddle, reached, sprinkled, staggered, unknown_saddle
from chaosdrill.analysis.measures.staggers import Walkers
from chaosdrill.analysis.starts import drawn_or_listed
from chaosdrill.analysis.tuning import ESCAPES
from chaosdrill.dataset import Outcome
from chaosdrill.dataset.build import dataset
from chaosdrill.model import HybridSystem
from chaosdrill.model.surface import surface

if TYPE_CHECKING:
    from chaosdrill.analysis.base import Job
    from chaosdrill.analysis.measures.saddles import Lives

AT_ONCE = (
    "runs that count leave at one age, or soon after each other, and none is watched for longer, so the rate is "
    "unknown: take other starts, or more of them"
)

NONE_LEFT = "no run is watched beyond the least age, so the rate is unknown: take a shorter transient, or more starts"

STAYING = "runs stay where none leaves, as at an attractor, and show no saddle: end lives there by until"

NO_FLOW = "no exponent of the saddle is 0, as one of a flow is: the saddle is an equilibrium, or runs stay too short"

NO_NUMBER = "an exponent of the saddle is not a number"


class Rate(NamedTuple):
    """An escape rate, per unit or per time."""

    value: float
    error: float
    escapes: int


def transients(system: HybridSystem, given: Any, job: "Job") -> xr.Dataset:
    """Lifetimes, escape rate and saddle; see `transient_chaos`."""
    marked, ends, at_surface = _marked(system, given.until)
    starts, modes = drawn_or_listed(system, given)
    period = system.forcing_period()
    forced = period is not None
    unit, count = (given.duration / ESCAPES.parts, ESCAPES.parts) if period is None else (period, given.periods)
    report = job.report(2 * len(starts))
    runs = Runs(marked, ends, at_surface, unit, job.numerics)
    lives = runs.watched(starts, modes, count, report)
    begun = lives.outcome != Outcome.INVALID_START
    median = int(np.median(lives.units[begun])) if begun.any() else 0
    lead = min(median, count // 4) if given.transient is None else given.transient
    if not forced and given.transient is not None:
        lead = math.ceil(given.transient / unit * (1 - 1e-12))
    rate, changes = _rate_and_drift(lives, lead, count, unit, forced=forced)
    dimension, dimension_error, unknown = math.nan, math.nan, ""
    saddle = _saddle(runs, Walkers(starts, modes, lives.units), lead, count, given, slower=changes < -ESCAPES.slower)
    leaves = rate if math.isnan(saddle.rate[0]) else Rate(*saddle.rate, saddle.staggers)
    if len(saddle.rates) and math.isfinite(leaves.value + leaves.error):
        flows = system.autonomous and not system.discrete
        dimension, dimension_error, unknown = dimension_of_saddle(saddle.rates, saddle.moved, leaves, flows=flows)
    if report:
        report(2 * len(starts))
    reasons = [AT_ONCE if rate.escapes else NONE_LEFT] if math.isnan(rate.value) else []
    reasons += [saddle.reason] if saddle.reason else []
    reasons += [unknown] if unknown else []
    alive = np.array([(lives.units[begun] >= age).sum() for age in range(count + 1)]) / max(begun.sum(), 1)
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
            "saddle_age": ((), saddle.age),
            "saddle_rate": ((), saddle.rate[0]),
            "saddle_rate_error": ((), saddle.rate[1]),
            "staggers": ((), np.int64(saddle.staggers)),
            "stagger_size": ((), saddle.size),
            "saddle_dimension": ((), dimension),
            "saddle_dimension_error": ((), dimension_error),
            "lyapunov_exponent": ("exponent", saddle.exponents),
            "lyapunov_error": ("exponent", saddle.errors),
            **({"forcing_period": ((), unit)} if forced else {}),
            "start": np.arange(1, len(starts) + 1, dtype=np.int32),
            "age": np.arange(count + 1) * unit,
            "state": list(system.state_names),
            "exponent": np.arange(1, system.free + 1, dtype=np.int32),
        },
        attrs={"reason": "; ".join(reasons)} if reasons else None,
    )


def _rate_and_drift(lives: "Lives", lead: int, count: int, unit: float, *, forced: bool) -> tuple[Rate, float]:
    """The escape rate per time of runs of at most ``count`` units that live longer than ``lead``, and its drift."""
    if not forced:
        whole = lives.length[lives.left | (lives.outcome == Outcome.OK)]
        return rate_of_flow(whole, lead * unit, count * unit), drift_of_flow(whole, lead * unit, count * unit)
    left = lives.left & (lives.units < count)
    rate = escape_rate(lives.units, left, lead)
    return Rate(rate.value / unit, rate.error / unit, rate.escapes), drift(lives.units, left, lead)


def _saddle(runs: Runs, starts: Walkers, lead: int, count: int, given: Any, *, slower: bool) -> Saddle:
    """The saddle by the method that is asked for; by default by stagger-and-step where runs do not stay for long.

    Where those that stay leave ``slower`` than others, or their deviations shrink, the sprinkler tells of an attractor.
    """
    seed = (given.random or {}).get("seed", 0)
    if given.saddle == "stagger":
        return staggered(runs, starts, count, seed, asked=True)
    named = runs.ends and not runs.surface
    brief = given.saddle is None and not (runs.system.draws or named) and 0 < reached(starts.lives) < count
    found = sprinkled(runs, starts, lead, SHORT if brief else 1)
    if found is None and brief:
        walked = staggered(runs, starts, count, seed, asked=False)
        found = (sprinkled(runs, starts, lead, 1) or walked) if walked.reason else walked
    if found and not found.staggers and (slower or found.exponents[0] < -ESCAPES.apart * found.errors[0]):
        return unknown_saddle(runs.system, STAYING)
    return found or unknown_saddle(runs.system)


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
    error = math.sqrt(share / ((1 - share) * trials)) if escapes else ESCAPES.none_seen / trials
    return Rate(-math.log1p(-share), error, escapes)


def drift(units: np.ndarray, left: np.ndarray, lead: int) -> float:
    """Difference of the rates of the later and the earlier half of all escapes, in its standard errors."""
    gone = np.sort(units[left & (units >= lead)])
    if len(gone) < 2 * ESCAPES.fewest:
        return math.nan
    middle = int(gone[len(gone) // 2])
    early = escape_rate(np.minimum(units, middle), left & (units < middle), lead)
    late = escape_rate(units, left, middle)
    return _apart(early, late)


def _apart(early: Rate, late: Rate) -> float:
    if min(early.escapes, late.escapes) < ESCAPES.fewest or not math.isfinite(early.value + late.value):
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
        return Rate(0.0, ESCAPES.none_seen / exposed, 0)
    early, late = gone[int(ESCAPES.early * len(gone))], gone[int(ESCAPES.late * len(gone))]
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
    if len(gone) < 2 * ESCAPES.fewest:
        return math.nan
    middle = gone[len(gone) // 2]
    early, late = rate_of_flow(lengths, lead, middle), rate_of_flow(lengths, middle, longest)
    return _apart(early, late)


def _marked(system: HybridSystem, until: str | None) -> tuple[HybridSystem, list[int], bool]:
    """The system with the transitions that end a life, their numbers, and whether they are a surface's of its own."""
    if until is None:
        return system, [], False
    named = [i for i, t in enumerate(system.transitions) if until in (t.name, t.kind)]
    if named:
        return system, named, False
    marked, marks = surface(system, until)
    return marked, sorted(marks), True


def dimension_of_saddle(rates: np.ndarray, moved: np.ndarray, rate: Rate, *, flows: bool) -> tuple[float, float, str]:
    """The information dimension of a saddle by its exponents and escape rate, its standard error, and why it is NaN.

    Parameters
    ----------
    rates, moved : ndarray, shapes (R, m), (m,)
        Exponents of single runs, and how far their means still move along the lives.
    flows : bool
        Whether one direction is that of a flow, which adds 1. Where no exponent may be 0 it is a rest, or unknown.
    """
    exponents = rates.mean(axis=0)
    if np.isnan(exponents).any():
        return math.nan, math.nan, NO_NUMBER
    with np.errstate(invalid="ignore"):
        unknown = ESCAPES.apart * np.hypot(rates.std(axis=0, ddof=1) / math.sqrt(len(rates)), moved)
    sizes = np.abs(exponents)
    if flows and (sizes > np.fmax(unknown, ESCAPES.zero * sizes[np.isfinite(sizes)].max(initial=0.0))).all():
        return math.nan, math.nan, NO_FLOW
    found = _information_dimension(exponents, rate.value, flows=flows)
    known = np.flatnonzero(np.isfinite(exponents))
    step = ESCAPES.step * (max(float(np.abs(exponents[known]).max(initial=0.0)), rate.value) or 1.0)

    def slope(on: np.ndarray, on_rate: float) -> float:
        ends = [
            _information_dimension(exponents + s * on, rate.value + s * on_rate, flows=flows) for s in (-step, step)
        ]
        return (ends[1] - ends[0]) / (2 * step)

    weights = np.array([slope(np.eye(len(exponents))[k], 0.0) for k in known])
    by_chance = float((rates[:, known] @ weights).std(ddof=1)) / math.sqrt(len(rates))
    by_rate = slope(np.zeros_like(exponents), 1.0) * rate.error
    return found, math.hypot(by_chance, float(moved[known] @ weights), by_rate), ""


def _information_dimension(exponents: np.ndarray, rate: float, *, flows: bool) -> float:
    """Of a saddle: its entropy, the sum of the positive exponents less the escape rate, fills directions on both sides.

    Those of the slowest growth and of the slowest decay are filled first (Hunt, Ott and Yorke 1996,
    doi:10.1103/PhysRevE.54.4819; of maps of the plane Kantz and Grassberger 1985).
    """
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
