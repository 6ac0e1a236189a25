"""States on a Poincare section, the period found there, and the multipliers of the cycle."""

from dataclasses import dataclass
from typing import ClassVar

from chaosdrill.analysis.base import Dataset, HybridSystem, Job, SectionRecord, analysis
from chaosdrill.dataset.schema import (
    ITERATE,
    MULTIPLIER,
    QUADRATURE,
    RETURN_TIME,
    SI,
    STATES,
    axis,
    forcing,
    grazing,
    may,
    need,
    outcome,
    rates,
    table,
)

VARIABLES = table(
    *STATES,
    ITERATE,
    need("section", "iterate state", "f8", "state on the section", "At the strobe: at forcing phase zero."),
    axis("time", "iterate", "f8", "model time of the crossing", "Dimensionless; counted from the start.", True),
    may("phase", "iterate", "f8", "forcing phase of the crossing", "As a fraction of a forcing period, 0 to 1."),
    may("mode", "iterate", "i1", "mode on the section", "Mode that holds at the crossing.", flags="mode"),
    may(QUADRATURE, "iterate", "f8", "quadrature", "Integral along the flow from the start of the record."),
    may("period", "", "i4", "period found", "In iterates of the section; 0 when none was found."),
    RETURN_TIME,
    MULTIPLIER,
    may(
        "multiplier_real",
        "multiplier",
        "f8",
        "multiplier, real part",
        "Eigenvalues of the cycle's tangent map; NaN without one.",
    ),
    may("multiplier_imag", "multiplier", "f8", "multiplier, imaginary part", "NaN when no period was found."),
    may("penetration_si", "iterate", "f8", "penetration", SI, "m"),
    *rates(""),
    grazing(""),
    outcome(""),
    *forcing(),
)


@dataclass(frozen=True, kw_only=True)
class PoincareSection(SectionRecord):
    """Settings of `poincare_section`."""

    without_noise: ClassVar[str] = ""


@analysis(
    "poincare-section",
    PoincareSection,
    "states at every strobe or event, period and multipliers",
    VARIABLES,
    cites=("mueller1995",),
)
def poincare_section(system: HybridSystem, given: PoincareSection, job: Job) -> Dataset:
    """States at every strobe, before every event of a given name, or on a surface.

    Returns
    -------
    xarray.Dataset
        ``section`` (iterate, state), ``time``, ``mode`` and quadratures (iterate), ``period``, ``return_time``, the
        mean time between two points; with a period found, unless the record is a duration, ``multiplier_real`` and
        ``multiplier_imag`` (multiplier): eigenvalues of the tangent map over the cycle, saltation included, those of
        lost rank exactly 0, and 1 along the flow of a system without forcing; mean rates, over one cycle if there is a
        period, and ``outcome``.
    """
    from chaosdrill.analysis.measures.section_points import section

    return section(system, given, job)
