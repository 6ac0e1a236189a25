"""Generalised dimensions of the points of a section: information dimension, correlation dimension and beyond."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from chaosdrill.analysis.base import Dataset, HybridSystem, Job, SweptRecord, analysis
from chaosdrill.dataset.schema import COVERS, STATES, SWEEP, axis, forcing, need, outcome, table
from chaosdrill.settings import ListOf, Whole, setting

_ORDER, _OVER = f"{SWEEP} order", f"{SWEEP} order scale"

_SPREAD = "Unit of distances; 0 for a constant state."

VARIABLES = table(
    axis(SWEEP, SWEEP, "f8", "swept parameter", "Values of the sweep.", True),
    axis("order", "order", "i4", "order of the dimension", "1: information dimension; 2: correlation dimension.", True),
    axis("scale", "scale", "f8", "distance", "The largest over the states, in their standard deviations.", True),
    *STATES,
    need("dimension", _ORDER, "f8", "dimension of section points", "0 on a cycle; NaN without a scaling region."),
    need("dimension_error", _ORDER, "f8", "standard error of the dimension", COVERS),
    need("scale_low", _ORDER, "f8", "smallest distance of the scaling region", "NaN without a scaling region."),
    need("scale_high", _ORDER, "f8", "largest distance of the scaling region", "NaN without a scaling region."),
    need(
        "correlation_sum",
        _OVER,
        "f8",
        "correlation sum",
        "Grows as the distance to the power of the dimension; NaN where few pairs are so close.",
    ),
    need(
        "local_slope",
        _OVER,
        "f8",
        "local slope of the correlation sum",
        "Of logarithms, to the next distance; NaN where that of either is.",
    ),
    need("local_slope_error", _OVER, "f8", "standard error of the local slope", "Statistical, from blocks."),
    need("spread", f"{SWEEP} state", "f8", "standard deviation of the state", _SPREAD),
    need("period", SWEEP, "i4", "period found", "In iterates of the section; 0 when none was found."),
    outcome(SWEEP),
    *forcing(),
    average=("spread",),
    sampled=("scale_low", "scale_high", "correlation_sum"),
)


@dataclass(frozen=True, kw_only=True)
class Dimensions(SweptRecord):
    """Settings of `dimensions`."""

    without_noise: ClassVar[str] = "points of a run under noise fill the range of the noise, not an attractor"
    meanings: ClassVar[Mapping[str, str]] = {
        "periods": "Points of the section to record: at least 500, and several thousand for useful errors; ten "
        "times as many for each further dimension.",
        "max_period": "Longest period to detect; a cycle has dimension 0.",
    }

    orders: list[int] = setting(
        ListOf(Whole(1, 8), distinct=True), (1, 2, 3), doc="Orders of the dimensions, from 1 to 8; default 1, 2 and 3."
    )
    window: int = setting(
        Whole(0, 10_000),
        10,
        doc="Number of steps up to which two points do not count as a pair. Raise it where successive points "
        "are close.",
    )


@analysis(
    "dimensions",
    Dimensions,
    "information and correlation dimension of section points, with the scaling region and an error",
    VARIABLES,
    cites=("grassberger1983", "badii1985", "theiler1986"),
)
def dimensions(system: HybridSystem, given: Dimensions, job: Job) -> Dataset:
    """Generalised dimensions of section points, from the growth of the number of neighbours with the distance.

    The correlation sum, the fraction of all pairs of points within a distance, grows as the distance to the power of
    the correlation dimension, order 2, at distances well below the extent of the attractor at which enough points are
    left (Grassberger and Procaccia 1983, doi:10.1103/PhysRevLett.50.346). Order q uses the (q - 1)-th power of the
    fraction of points near a point; order 1, the information dimension, its logarithm, from the distances to neighbours
    (Badii and Politi 1985, doi:10.1007/BF01009897). Order 0 is left out: it depends on the parts of the attractor that
    a record hardly visits. Points within ``window`` steps of each other do not count as a pair (Theiler 1986,
    doi:10.1103/PhysRevA.34.2427). A distance is the largest over the states, each in units of its standard deviation,
    so that units do not matter; dimensions are those in any smooth coordinates. At an event of a forced system the
    phase of the forcing is a coordinate, too. Replace an angle by its cosine and sine: a state that only grows never
    comes back.

    The dimension is the slope over a range of distances, a factor of at least 11, with 500 pairs at its smallest one
    and at most a fifth of all pairs at its largest one, over each half of which the number of neighbours grows by a
    factor of 1.4: between clusters, as near a resonance of a torus, it rests. Its error combines the statistical error,
    from 128 blocks of the record; the scatter and drift of local slopes over the range; the difference of the slope
    over the finer half; and the differences of the dimensions over other ranges. The longest range with an error close
    to the smallest is used. Without a range the dimension is NaN, and the attribute ``reason`` says why; the outcome is
    ``undecided`` if no order has one. The coverage of twice the error is given in docs/howto/dimensions.md. It does not
    include distances that the record does not resolve.

    Returns
    -------
    xarray.Dataset
        Over the swept parameter, if there is one: ``dimension`` and ``dimension_error``, dimensionless, ``scale_low``
        and ``scale_high``, the ends of the scaling region (order); ``correlation_sum``, ``local_slope`` and
        ``local_slope_error`` (order, scale); ``spread`` (state), the standard deviations that are the units of
        distances; ``period`` and ``outcome``: ``periodic`` on a cycle, whose dimensions are 0.

    Raises
    ------
    SettingsError
        An argument that cannot be used, or a ``window`` that leaves too few pairs (in a sweep these values are
        undecided).
    """
    from chaosdrill.analysis.measures.scaling import dimensions_of

    return dimensions_of(system, given, job)
