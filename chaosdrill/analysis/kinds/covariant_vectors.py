"""Covariant Lyapunov vectors, across events."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from chaosdrill.analysis.arguments import Exponents
from chaosdrill.analysis.base import Dataset, HybridSystem, Job, Record, analysis
from chaosdrill.dataset.references import SPECTRA
from chaosdrill.dataset.schema import COVERS, RANK_LOSS, STATES, axis, forcing, need, outcome, table
from chaosdrill.settings import Amount, Faults, Number, Whole, setting, told

_OVER = "time vector"

VARIABLES = table(
    axis("time", "time", "f8", "model time", "Since the start of the run, at the vectors.", True),
    *STATES,
    axis(
        "split",
        "split",
        "i4",
        "vectors before the split",
        "The first vectors up to this number, against the others.",
        True,
    ),
    axis("vector", "time state vector", "f8", "covariant vector", "Of length 1; zero where it is lost.", True),
    need("vector_error", _OVER, "f8", "error of the direction", "Remaining effect of the ends of the two passes."),
    need("local_growth", _OVER, "f8", "local rate of growth", "From this time to the next one; -inf where lost."),
    need("lost", _OVER, "i1", "direction lost", "Whether an event has removed it by this time.", flags="truth"),
    need("lyapunov_exponent", "vector", "f8", "Lyapunov exponent", RANK_LOSS),
    need("lyapunov_error", "vector", "f8", "standard error of the exponent", COVERS),
    need("states", "time state", "f8", "state", "Where the vectors stand."),
    need("mode", "time", "i1", "mode", "Where the vectors stand; -1: nowhere.", flags="mode", lacking=True),
    need(
        "angle",
        "time split",
        "f8",
        "angle between the subspaces",
        "The smallest one; NaN where a side has no vector.",
        "rad",
    ),
    need(
        "smallest_angle",
        "split",
        "f8",
        "smallest angle met",
        "Zero in the limit where subspaces touch; NaN without an angle.",
        "rad",
    ),
    need(
        "angle_histogram",
        "split bin",
        "f8",
        "probability density",
        "Of the angle; its integral is 1. NaN without an angle.",
        "rad-1",
    ),
    need("angle_histogram_error", "split bin", "f8", "standard error of the density", "Of each bin.", "rad-1"),
    need("bin_centre", "bin", "f8", "angle", "Middles of bins of equal width from 0 to pi/2.", "rad"),
    outcome(""),
    need("interval", "", "f8", "time between two vectors", "In units of model time."),
    forcing()[0],
    bars={"lyapunov_exponent": "lyapunov_error"},
    sampled=("vector", "vector_error", "local_growth", "lost", "angle", "smallest_angle"),
)


@dataclass(frozen=True, kw_only=True)
class CovariantVectors(Record):
    """Settings of `covariant_vectors`."""

    without_noise: ClassVar[str] = ""
    meanings: ClassVar[Mapping[str, str]] = {
        "periods": "Length of the record in points of the section, as in `lyapunov_spectrum`.",
        "duration": "Length of the record in time, for systems without a forcing period.",
        "transient": "Points of the section, or time, to run first, without tangents.",
    }

    interval: float | None = setting(
        Number(above=0),
        None,
        doc="Time between two vectors: in forcing periods, a whole number or one over a whole number; by default 1, in "
        "longer records the fewest that leave at most 32,768 vectors, with a rest at the end left out. Without forcing "
        "in units of time, rounded to a part of the record, default 1/1024 of it.",
    )
    forward: float | None = setting(
        Amount(least=0),
        None,
        doc="Time that the forward pass leads into the record, between it and the transient: in forcing "
        "periods, else in units of time; rounded up to whole intervals. Default: a quarter of the record, but 100 to "
        "1000 forcing periods.",
    )
    backward: float | None = setting(
        Amount(least=0), None, doc="Time that the backward pass begins behind the record, as ``forward``."
    )
    exponents: int | None = setting(Exponents(), None, doc="Number of vectors, fastest first; default all.")
    bins: int = setting(Whole(1, 100_000), 64, doc="Bins of the histograms of angles.")

    @classmethod
    def misfits(cls, table: Mapping[str, Any], system: HybridSystem) -> Faults:
        """An interval that is neither a whole number of forcing periods nor one over a whole number."""
        yield from super().misfits(table, system)
        interval = table.get("interval")
        if interval and system.forced:
            whole = max(interval, 1 / interval)
            if abs(whole - round(whole)) > 1e-9 * whole:
                yield ("interval",), told("expected whole forcing periods, or one over a whole number", interval)


@analysis(
    "covariant-vectors",
    CovariantVectors,
    "covariant Lyapunov vectors, growth along them, angles between subspaces",
    VARIABLES,
    cites=("ginelli2007", "ginelli2013", *SPECTRA),
)
def covariant_vectors(system: HybridSystem, given: CovariantVectors, job: Job) -> Dataset:
    """Covariant Lyapunov vectors along a record, across events, with the growth along each and angles between them.

    The tangent map takes each vector to a multiple of itself at the later state: the first grows fastest, and on a
    cycle they are the eigenvectors of the monodromy matrix. A forward pass orthonormalises tangents, which jump by the
    saltation matrix at every event, and stores how each is composed of earlier tangents; a backward pass turns
    arbitrary vectors into covariant ones (Ginelli et al. 2007, doi:10.1103/PhysRevLett.99.130601; 2013,
    doi:10.1088/1751-8113/46/25/254005). Both converge at the difference of neighbouring exponents: ``vector_error`` is
    the remaining effect of their ends on a vector, near 1 for equal exponents, such as those of a spiral; then only the
    subspace of these vectors is meaningful.

    An event may lose rank, as sticking does. The direction that it removes has a vector until that event; afterwards it
    is ``lost``, its vector zero, its growth -inf. The others are vectors of the remaining space; before the event they
    are determined up to the removed direction, and the vector without a component along the removed tangent is taken.

    If the rank is lost before the record begins, all others are unique. Vectors have the Euclidean length 1 in the
    states as they are declared: scaled states give the same directions, but other local growth and other angles, unless
    these are 0.

    Memory grows with the number of vectors, not of periods, so that without an ``interval`` it is bounded. Beyond
    results it always is, since the forward pass of many vectors is repeated in chunks.

    Returns
    -------
    xarray.Dataset
        ``vector`` (time, state, vector); ``vector_error``, ``local_growth``, per unit of time and up to the next
        vector, and ``lost`` (time, vector); ``states`` (time, state) and ``mode`` (time); ``angle`` (time, split), in
        radians, the smallest between the span of the first vectors, 1, 2 and so on, and that of the others,
        ``smallest_angle`` (split), ``angle_histogram`` and ``angle_histogram_error`` (split, bin), ``bin_centre``
        (bin); ``lyapunov_exponent``, the mean of the local growth, ``lyapunov_error`` (vector); ``outcome``, ``ok`` for
        a run that reached its end. Of each vector the largest component is positive where the record begins; from there
        on the tangent map determines its sign. NaN if the run ended early, and for angles without vectors on both
        sides. ``interval``, the time between two vectors.
    """
    from chaosdrill.analysis.measures.covariant import vectors

    return vectors(system, given, job)
