"""Exponents over finite times: their distribution over windows of a record, and how long their rates are correlated."""

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import xarray as xr

from chaosdrill.analysis.arguments import tangent_count
from chaosdrill.analysis.base import Job
from chaosdrill.analysis.judgement.recurrence import sizes
from chaosdrill.analysis.judgement.statistics import error_of_exponents, in_blocks, standard_error
from chaosdrill.analysis.measures.blocks import Blocks
from chaosdrill.analysis.measures.records import ENDED, Arrays, ValueTask, carry_out, ended_by, swept
from chaosdrill.analysis.measures.spectra import computed_exponents, run_with_tangents
from chaosdrill.analysis.spans import Span
from chaosdrill.analysis.tuning import WINDOWS
from chaosdrill.dataset import Outcome
from chaosdrill.dataset.build import dataset
from chaosdrill.engine.lengths import sizes_of_states
from chaosdrill.engine.run import Run
from chaosdrill.engine.shifts import shifts_of
from chaosdrill.engine.structure import examine
from chaosdrill.errors import SettingsError
from chaosdrill.model import HybridSystem


@dataclass(frozen=True)
class _Windows:
    """How a record is divided."""

    plan: Span  # in units
    counts: tuple[int, ...]  # units of each window

    @property
    def times(self) -> np.ndarray:
        """Lengths of the windows."""
        return np.array(self.counts) * self.plan.unit


_OVER, _BINNED = ("window", "exponent"), ("window", "exponent", "bin")
_DIMS: dict[str, tuple[str, ...]] = {
    **dict.fromkeys(("lyapunov_exponent", "lyapunov_error"), ("exponent",)),
    **dict.fromkeys(("cumulant", "cumulant_error"), (*_OVER, "order")),
    **dict.fromkeys(("histogram", "histogram_error", "bin_centre"), _BINNED),
    **dict.fromkeys(("correlation_time", "correlation_time_error"), ("exponent",)),
    "window_time": ("window",),
}
"""Dimensions of the results of a record."""


@dataclass(frozen=True)
class _WindowTask(ValueTask):
    """Windows of records at values of a parameter."""

    windows: int

    def columns(self) -> dict[str, tuple[str, tuple[int, ...]]]:
        """Dtype and shape of one unit of each array."""
        count = tangent_count(self.system, self.given.exponents)
        sizes = {"window": self.windows, "exponent": count, "order": WINDOWS.orders, "bin": self.given.bins}
        told = {name: ("f8", tuple(sizes[dim] for dim in dims)) for name, dims in _DIMS.items()}
        return told | {"forcing_period": ("f8", ()), **ENDED}

    def at(self, system: HybridSystem) -> Arrays:
        """What the windows at a value say; it must have as many lengths of them as the others."""
        windows = _divided(self.given.span(system, self.numerics), self.given.windows)
        if len(windows.counts) != self.windows:
            raise SettingsError("windows that differ coincide in parts of the record")
        return _told(system, windows, self.given, Job(self.numerics))[0]


def finite_times(system: HybridSystem, given: Any, job: Job) -> xr.Dataset:
    """Distributions of the exponents over windows, also at values of a parameter; see `finite_time_exponents`."""
    windows, count = _divided(given.span(system, job.numerics), given.windows), tangent_count(system, given.exponents)
    coords = {
        "window": windows.times,
        "exponent": np.arange(1, count + 1, dtype=np.int32),
        "order": np.arange(1, WINDOWS.orders + 1, dtype=np.int32),
    }
    over_values = swept(system, given, job)
    if over_values is None:
        found, message = _told(system, windows, given, job)
        told = {"message": message} if message else None
        del found["window_time"], found["ended_by"]
        over: tuple[str, ...] = ()
    else:
        parameter, values = over_values
        found, told = carry_out(_WindowTask(system, given, job.numerics, parameter, values, len(windows.counts)), job)
        coords, over = {parameter: values, **coords}, (parameter,)
    if not windows.plan.periodic:
        del found["forcing_period"]
    variables = {name: ((*over, *_DIMS.get(name, ())), value) for name, value in found.items()}
    return dataset({**variables, **coords}, attrs=told)


def _told(system: HybridSystem, windows: _Windows, given: Any, job: Job) -> tuple[Arrays, str]:
    """What the windows of one record say, and what ended its run."""
    plan, count = windows.plan, tangent_count(system, given.exponents)
    structure = examine(system)
    m = computed_exponents(structure, count)
    run = run_with_tangents(system, structure, m, plan.unit, job.numerics)
    outcome, growth, by_size, sums = _sums(run, plan, m, job)
    with np.errstate(invalid="ignore"):
        rates, mean = np.diff(sums, axis=0) / plan.unit, growth / plan.length
        apart = np.abs(growth - by_size) / plan.length
    rates[:, run.lost[:m] == 1] = mean[run.lost[:m] == 1] = -np.inf if outcome == Outcome.OK else np.nan
    order = np.argsort(-mean, kind="stable")[:count]
    rates, mean, apart = rates[:, order], mean[order], apart[order]
    shape = (len(windows.counts), count)
    cumulant, cumulant_error = np.full((2, *shape, WINDOWS.orders), np.nan)
    histogram, histogram_error, centre = np.full((3, *shape, given.bins), np.nan)
    times = np.full((2, count), np.nan)
    error = error_of_exponents(in_blocks(rates, WINDOWS.blocks), job.numerics, run.steps, plan.length, apart)
    for e in np.flatnonzero(np.isfinite(mean)):
        times[:, e] = correlation_time(rates[:, e])
        for w, units in enumerate(windows.counts):
            one = rates[: len(rates) // units * units, e].reshape(-1, units).mean(axis=1)
            cumulant[w, e], cumulant_error[w, e] = cumulants(one)
            # windows know no mean better than the record does
            cumulant_error[w, e, 0] = max(cumulant_error[w, e, 0], error[e])
            histogram[w, e], histogram_error[w, e], centre[w, e] = density(one, given.bins)
    found = {
        "lyapunov_exponent": mean,
        "lyapunov_error": error,
        "cumulant": cumulant,
        "cumulant_error": cumulant_error,
        "histogram": histogram,
        "histogram_error": histogram_error,
        "bin_centre": centre,
        "correlation_time": times[0] * plan.unit,
        "correlation_time_error": times[1] * plan.unit,
        "window_time": windows.times,
        "forcing_period": plan.unit if plan.periodic else np.nan,
        "outcome": np.int8(outcome),
        "ended_by": ended_by(run, outcome),
    }
    return found, plan.message or run.stopped(outcome)


def _divided(plan: Span, wanted: Any) -> _Windows:
    """The record in units of which all windows are multiples: forcing periods, or about the shortest window.

    Raises `SettingsError` for a window that does not fit into the record four times.
    """
    length = plan.length / (plan.unit if plan.periodic else 1.0)
    longest = length / WINDOWS.fewest
    if wild := [one for one in wanted or (1,) * plan.periodic if one > longest * (1 + 1e-9)]:
        raise SettingsError(
            f"windows holds {wild[0]:g}, but a record of {length:.6g} holds fewer than {WINDOWS.fewest} of them; "
            "take a longer record or shorter windows"
        )
    if not plan.periodic:
        count = WINDOWS.parts if wanted is None else max(round(length / min(wanted)), WINDOWS.fewest)
        plan = replace(plan, unit=plan.length / count, count=count)
    if wanted is None:
        counts = [units for units in WINDOWS.windows if units * WINDOWS.fewest <= plan.count]
    else:
        unit = 1.0 if plan.periodic else plan.unit
        counts = sorted({max(1, round(one / unit)) for one in wanted})
    return _Windows(plan, tuple(counts))


def _sums(run: Run, plan: Span, m: int, job: Job) -> tuple[Outcome, np.ndarray, np.ndarray, np.ndarray]:
    """Logarithms of the tangents' growth: in all, as it is and by sizes as that of a spectrum, both (m,), and at the
    beginning and after every unit, (count + 1, m).

    Of units lengths are in parts of the sizes that states have at the ends of the first units held together, which no
    unit of a state changes.
    """
    outcome, report, first = plan.settle(run), job.report(plan.count), run.strobes
    most = max(WINDOWS.blocks, WINDOWS.held // max(1, m * len(run.x)))
    whole, by_size, sums = np.full(m, np.nan), np.full(m, np.nan), np.full((plan.count + 1, m), np.nan)
    held: list[Blocks] = []
    done = 0
    while outcome == Outcome.OK and done < plan.count:
        count = min(most, plan.count - done)
        units = Blocks(run, np.arange(1, count + 1), m)
        outcome = units.go_on(count, report=report and (lambda: report(run.strobes - first)))
        if not held:
            # the largest states at the ends of steps would depend on the steps
            unit_sizes = sizes(np.nan_to_num(units.states)[np.newaxis], run.sizes)[0]
        held = [*held[:1], units]
        begin = done + 1 if done else 0
        sums[begin : done + count + 1] = units.sums_by_size(unit_sizes)[begin - done :]
        whole, done = units.sums()[-1], done + count
    if held:
        known = sizes_of_states(run.extents, shifts_of(run.system, but_of=()))
        by_size = held[-1].sums_by_size(known)[-1] - held[0].sums_by_size(known)[0]
    return outcome, whole, by_size, sums


def cumulants(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Cumulants of a sequence up to the fourth, unbiased where values are independent, and their standard errors.

    The errors are those of the means of influence functions, by `standard_error`, which minds correlations; those of
    orders 3 and 4 at least what tails beyond the sample would make them, see `_of_tails`.

    ``values``, shape (N,): in order; four at least.

    Returns ``cumulants``, ``errors``, shape (4,).
    """
    count, mean = len(values), values.mean()
    off = values - mean
    if np.abs(off).max() <= WINDOWS.constant * np.abs(values).max():
        off = np.zeros_like(values)
    square = off * off
    second, third, fourth = square.mean(), (square * off).mean(), (square * square).mean()
    first, *others = (in_blocks(power, WINDOWS.blocks) for power in (off, square, square * off, square * square))
    influence = np.stack(
        [
            first,
            others[0] - second,
            others[1] - third - 3 * second * first,
            others[2] - fourth - 4 * third * first - 6 * second * (others[0] - second),
        ],
        axis=1,
    )
    # k-statistics of values whose mean is taken out
    ones = count - 1
    found = [
        mean,
        second * count / ones,
        third * count**2 / (ones * (count - 2)),
        count**2 * ((count + 1) * fourth - 3 * ones * second**2) / (ones * (count - 2) * (count - 3)),
    ]
    errors = standard_error(influence)
    far = off * np.sign(third)
    if (far > WINDOWS.end * far.max()).mean() < WINDOWS.at_end and abs(found[2]) > 2 * errors[2]:
        errors[2:] = np.maximum(errors[2:], _of_tails(np.array(found), errors))
    return np.array(found), errors


def _of_tails(found: np.ndarray, errors: np.ndarray) -> np.ndarray:
    """Standard errors of cumulants 3 and 4, shape (2,), if tails go on as those of a gamma distribution.

    A sample seldom holds the values that matter most to these, and then their scatter is as small as they are. The
    skewness of the distribution is the largest that both cumulants allow within their errors; the variances of
    k-statistics are those of long samples (Kendall and Stuart 1977, The Advanced Theory of Statistics 1, chapter 12).
    """
    width = np.sqrt(found[1])
    third = (abs(found[2]) + 1.5 * errors[2]) / width**3
    fourth = max(found[3] + 3 * errors[3], 0.0) / width**4
    skew = min(third, np.sqrt(fourth / 1.5))
    k3, k4, k5, k6, _, k8 = (math.factorial(j - 1) * (skew / 2) ** (j - 2) for j in range(3, 9))
    variances = np.array(
        [k6 + 9 * k4 + 9 * k3**2 + 6, k8 + 16 * k6 + 48 * k5 * k3 + 34 * k4**2 + 72 * k4 + 144 * k3**2 + 24]
    )
    return np.asarray(errors[0] / WINDOWS.enlarged * width ** np.array([2, 3]) * np.sqrt(variances))


def correlation_time(rates: np.ndarray) -> tuple[float, float]:
    """Integrated correlation time of a sequence and its error, in steps; NaN if the sequence is constant.

    It is 1 + 2 sum of all correlations: 1 if values are independent, less if they alternate. The sum is the power at
    the lowest frequencies over the variance, which is never negative (Heidelberger and Welch 1981,
    doi:10.1145/358598.358630); as many are averaged as lie well below one over the correlation time.
    """
    off, count = rates - rates.mean(), len(rates)
    if np.abs(off).max() <= WINDOWS.constant * np.abs(rates).max():
        return np.nan, np.nan
    power = np.abs(np.fft.rfft(off)[1:]) ** 2 / (off**2).sum()
    most = max(WINDOWS.lowest, int(0.4 * count ** (2 / 3)))
    time = 1.0
    for _ in range(WINDOWS.rounds):
        orders = int(np.clip(count / (WINDOWS.flat * max(time, 1.0)), WINDOWS.lowest, most))
        time = float(power[:orders].mean())
    return time, time / np.sqrt(min(orders, len(power)))


def density(
    values: np.ndarray, bins: int, limits: tuple[float, float] | None = None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Density in bins over the whole range, or between limits, its standard error, and the middles of the bins.

    The error is that of a mean of correlated blocks, but at least that of a count of independent values, with a
    margin by which an empty bin differs from one with three.
    """
    low, high = limits or (values.min(), values.max())
    if high - low <= WINDOWS.constant * max(abs(low), abs(high)):
        low, high = low - 0.5, high + 0.5
    width, count = (high - low) / bins, len(values)
    # values on an edge, as those of a few kinds of steps may be, are not parted by round-off
    place = np.clip(((values - low) / width + WINDOWS.constant).astype(np.int64), 0, bins - 1)
    blocks = min(count, WINDOWS.of_density)
    block = np.arange(count) * blocks // count
    shares = np.bincount(block * bins + place, minlength=blocks * bins).reshape(blocks, bins) * (blocks / count)
    counts = np.bincount(place, minlength=bins)
    by_chance = np.sqrt((counts + WINDOWS.at_least) * (count - counts + WINDOWS.at_least) / count) / count
    error = np.fmax(standard_error(shares), by_chance)
    return counts / count / width, error / width, low + (np.arange(bins) + 0.5) * width
