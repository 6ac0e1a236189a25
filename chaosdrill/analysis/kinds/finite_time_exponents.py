"""Lyapunov exponents over windows of finite length: their distributions."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from chaosdrill.analysis.arguments import Exponents
from chaosdrill.analysis.base import Dataset, HybridSystem, Job, Swept, analysis
from chaosdrill.dataset.references import SPECTRA
from chaosdrill.dataset.schema import COVERS, EXPONENT, RANK_LOSS, SWEEP, axis, forcing, may, need, outcome, table
from chaosdrill.settings import Faults, ListOf, Number, Whole, setting, told

_EXPONENT, _WINDOW = f"{SWEEP} exponent", f"{SWEEP} window exponent"

VARIABLES = table(
    axis(SWEEP, SWEEP, "f8", "swept parameter", "Values of the sweep.", True),
    EXPONENT,
    axis("window", "window", "f8", "length of the windows", "In units of time, at the system's own parameters.", True),
    may("window_time", f"{SWEEP} window", "f8", "length of the windows", "In units of model time, at each value."),
    axis("order", "order", "i4", "order of the cumulant", "1: mean, 2: variance, and so on.", True),
    need("lyapunov_exponent", _EXPONENT, "f8", "Lyapunov exponent", RANK_LOSS),
    need("lyapunov_error", _EXPONENT, "f8", "standard error of the exponent", COVERS),
    need(
        "cumulant",
        f"{_WINDOW} order",
        "f8",
        "cumulant of the exponents",
        "Over successive windows; NaN where rank is lost.",
    ),
    need("cumulant_error", f"{_WINDOW} order", "f8", "standard error of the cumulant", COVERS),
    need(
        "histogram",
        f"{_WINDOW} bin",
        "f8",
        "probability density",
        "Of the exponents over windows; its sum is 1. NaN where rank is lost.",
    ),
    need("histogram_error", f"{_WINDOW} bin", "f8", "standard error of the density", "Of each bin by itself."),
    need(
        "bin_centre",
        f"{_WINDOW} bin",
        "f8",
        "finite-time exponent",
        "Middles of bins of equal width; NaN where rank is lost.",
    ),
    need(
        "correlation_time",
        _EXPONENT,
        "f8",
        "correlation time",
        "Integrated, of the rates of growth; NaN where rank is lost, or they are constant.",
    ),
    need("correlation_time_error", _EXPONENT, "f8", "standard error of the correlation time", "NaN if constant."),
    outcome(SWEEP),
    forcing(SWEEP)[0],
    bars={"lyapunov_exponent": "lyapunov_error"},
    sampled=("histogram", "histogram_error", "bin_centre"),
)


@dataclass(frozen=True, kw_only=True)
class FiniteTimeExponents(Swept):
    """Settings of `finite_time_exponents`."""

    without_noise: ClassVar[str] = ""
    meanings: ClassVar[Mapping[str, str]] = {
        "periods": "Length of the record in points of the section, as in `lyapunov_spectrum`.",
        "duration": "Length of the record in time, for systems without a forcing period.",
    }

    windows: list[float] | None = setting(
        ListOf(Number(above=0), distinct=True, most=100),
        None,
        doc="Lengths of windows, in whole forcing periods; without forcing in units of time, rounded to "
        "multiples of the shortest, which is rounded to a part of the record. Each must fit into the record "
        "four times. Default: 1, 10 and 100 forcing periods, or parts of the record of 1024, as far as they "
        "fit.",
    )
    exponents: int | None = setting(Exponents(), None, doc="Number of exponents, largest first; default all.")
    bins: int = setting(
        Whole(1, 100_000), 64, doc="Bins of each histogram, of equal width from the least value to the largest."
    )

    @classmethod
    def misfits(cls, table: Mapping[str, Any], system: HybridSystem) -> Faults:
        """A window that is not a whole number of forcing periods."""
        yield from super().misfits(table, system)
        units = "iterates" if system.discrete else "forcing periods"
        for number, window in enumerate(table.get("windows") or ()):
            if system.forced and window % 1:
                yield ("windows", number), told(f"expected whole {units}", window)


@analysis(
    "finite-time-exponents",
    FiniteTimeExponents,
    "distributions of the exponents over windows of given lengths",
    VARIABLES,
    cites=SPECTRA,
)
def finite_time_exponents(system: HybridSystem, given: FiniteTimeExponents, job: Job) -> Dataset:
    """Distributions of Lyapunov exponents over windows of a record, their cumulants, and the correlation time.

    The record of `lyapunov_spectrum` is divided into successive windows, and the growth of the orthonormalised tangents
    over each, saltation included, gives one value per exponent. The largest is the growth of a tangent that has turned
    into the fastest direction; the sum of the first two is that of an area, and so on. For long windows the variance
    falls like the inverse of their length, unless rates are correlated for longer, and the distribution becomes normal
    except in its tails. Lengths of tangents over windows are in parts of the sizes of the states, so that their
    distribution depends on no unit of a state.

    Returns
    -------
    xarray.Dataset
        Over the swept parameter, if there is one: ``cumulant``, ``cumulant_error`` (window, exponent, order), for
        orders 1 to 4, of exponents per unit of time; ``histogram``, a density, ``histogram_error`` and ``bin_centre``
        (window, exponent, bin); ``lyapunov_exponent``, ``lyapunov_error``, ``correlation_time`` and
        ``correlation_time_error`` (exponent), the latter two in units of time: of rates over the shortest unit, which
        is that unit where they are independent; ``window``, in units of time, and ``outcome``, ``ok`` for a run that
        reached its end. NaN where rank is lost, and if the run ended early. Of a sweep also ``window_time`` (window) at
        each value; one at which the windows do not fit has the outcome ``failed``.
    """
    from chaosdrill.analysis.measures.finite_times import finite_times

    return finite_times(system, given, job)
