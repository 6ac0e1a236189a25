"""Lyapunov spectra."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from chaosdrill.analysis.arguments import Exponents
from chaosdrill.analysis.base import Dataset, HybridSystem, Job, Record, analysis
from chaosdrill.dataset.references import SPECTRA
from chaosdrill.dataset.schema import (
    COVERS,
    EXPONENT,
    RANK_LOSS,
    axis,
    forcing,
    grazing,
    may,
    need,
    outcome,
    rates,
    table,
)
from chaosdrill.settings import Whole, setting

VARIABLES = table(
    EXPONENT,
    need("lyapunov_exponent", "exponent", "f8", "Lyapunov exponent", RANK_LOSS),
    need("lyapunov_error", "exponent", "f8", "standard error of the exponent", COVERS),
    need("lyapunov_history", "block exponent", "f8", "running mean of the exponents", "Up to the block's end."),
    axis("block_time", "block", "f8", "model time at the block's end", "Counted from the end of the transient."),
    need("kaplan_yorke_dimension", "", "f8", "Kaplan-Yorke dimension", "From the exponents; holds with -inf too."),
    need("kaplan_yorke_error", "", "f8", "standard error of the Kaplan-Yorke dimension", "NaN near a jump."),
    *rates(""),
    axis("transition", "transition", "str", "name of the transition", "In the order of the system."),
    may("event_count", "transition", "i8", "number of events", "How often each transition was taken."),
    may("tie_count", "", "i8", "number of ties", "Events that fell on the same instant as the one before."),
    grazing("", required=True),
    may(
        "rank", "", "i4", "live tangents", "Rank of the tangent map's product: the number of finite exponents, of all."
    ),
    outcome(""),
    *forcing(),
    bars={
        "lyapunov_exponent": "lyapunov_error",
        "lyapunov_history": "lyapunov_error",
        "kaplan_yorke_dimension": "kaplan_yorke_error",
    },
    average=("event_count",),
    sampled=("tie_count",),
)


@dataclass(frozen=True, kw_only=True)
class LyapunovSpectrum(Record):
    """Settings of `lyapunov_spectrum`."""

    without_noise: ClassVar[str] = ""
    meanings: ClassVar[Mapping[str, str]] = {
        "periods": "Points of the section to average over. Exponents are per unit of time. The time that a "
        "number of events takes is measured in a separate run; for a forced system it is rounded up to whole "
        "periods.",
        "duration": "Time to average over instead, for systems without a forcing period.",
        "transient": "Points of the section, or time, to run before the averages start.",
    }

    exponents: int | None = setting(
        Exponents(), None, doc="Number of exponents to report, largest first; default all; 0 computes no tangents."
    )
    blocks: int = setting(
        Whole(1, 1_000_000), 256, doc="Blocks of the history, from which the standard errors are estimated."
    )


@analysis(
    "lyapunov-spectrum",
    LyapunovSpectrum,
    "Lyapunov exponents with error bars, -inf where rank is lost",
    VARIABLES,
    cites=(*SPECTRA, "kaplan1979"),
)
def lyapunov_spectrum(system: HybridSystem, given: LyapunovSpectrum, job: Job) -> Dataset:
    """Lyapunov exponents with saltation at every event, their error bars and their history.

    Tangents follow the variational equation, jump by the saltation matrix, and are orthonormalised as often as their
    growth requires (Benettin et al. 1980, doi:10.1007/BF02128237; Mueller 1995, doi:10.1016/0960-0779(94)00170-U). Rank
    lost at resets is counted; the corresponding exponents are -inf.

    For up to 32 states all exponents are computed, however few are requested, so that the classification, the rank and
    the dimension do not depend on the number requested. For more states, if no event can lose rank, only the requested
    exponents are computed, and at least two more than the structure of the system may make zero. Their tangents start
    in general position, in the same order for any number of them, so that an exponent depends on the number requested
    only within its error. The dimension is then NaN if it requires more exponents.

    Returns
    -------
    xarray.Dataset
        ``lyapunov_exponent``, ``lyapunov_error`` (exponent), ``lyapunov_history`` (block, exponent),
        ``kaplan_yorke_dimension``, ``kaplan_yorke_error``, mean rates, ``event_count`` (transition), ``tie_count``,
        ``closest_grazing``, ``rank`` and ``outcome``; exponents per unit of time, NaN if the run ended early. The
        dimension's error is NaN where the first exponent cannot be distinguished from zero, at which the dimension
        jumps.
    """
    from chaosdrill.analysis.measures.spectra import spectrum

    return spectrum(system, given.span(system, job.numerics, units=given.blocks), given.exponents, given.blocks, job)
