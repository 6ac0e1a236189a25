"""The 0-1 test for chaos, from the points of a section."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from chaosdrill.analysis.base import Dataset, HybridSystem, Job, SweptRecord, analysis
from chaosdrill.dataset.schema import STATES, SWEEP, axis, need, outcome, table

_STATE = f"{SWEEP} state"

VARIABLES = table(
    axis(SWEEP, SWEEP, "f8", "swept parameter", "Values of the sweep.", True),
    *STATES,
    need("k", _STATE, "f8", "growth K of the 0-1 test", "0: regular, 1: chaos. NaN for a state that does not move."),
    need("k_error", _STATE, "f8", "standard error of K", "For records of this length; near 1 for short ones."),
    need(
        "k_by_turn", f"{_STATE} turn", "f8", "growth K for each turning phase", "K is the median over these; NaN as K."
    ),
    axis("turn_angle", "turn", "f8", "turning phase", "In radians, between pi/5 and 4 pi/5."),
    need("period", SWEEP, "i4", "period found", "In iterates of the section; 0 when none was found."),
    outcome(SWEEP),
    sampled=("k_by_turn",),
)


@dataclass(frozen=True, kw_only=True)
class ZeroOneTest(SweptRecord):
    """Settings of `zero_one_test`."""

    without_noise: ClassVar[str] = "it takes the noise itself for chaos"
    meanings: ClassVar[Mapping[str, str]] = {
        "periods": "Points of the section to record: at least 40, and several hundred for a conclusive result."
    }


@analysis(
    "zero-one-test",
    ZeroOneTest,
    "growth K of the 0-1 test: 0 for regular motion, 1 for chaos",
    VARIABLES,
    cites=("gottwald2009",),
)
def zero_one_test(system: HybridSystem, given: ZeroOneTest, job: Job) -> Dataset:
    """The 0-1 test of each state, from section points alone, without tangents.

    The values of a state drive a point in a plane that turns by a fixed angle at every iterate. If the motion is
    regular the point stays bounded, and in chaos it wanders like a random walk. K is the correlation with time of its
    mean square displacement, without the oscillating part; the median over 24 angles is taken (Gottwald and Melbourne
    2009, doi:10.1137/080718851). K near 0 or 1 is conclusive; between them the record is too short, or the chaos has
    many bands. Measurement noise, slow drift, and strange nonchaotic attractors also give intermediate values.

    Returns
    -------
    xarray.Dataset
        Over the swept parameter, if there is one: ``k``, ``k_error`` (state), dimensionless, NaN for a state that does
        not move on the section and if the run ended early or has fewer than 40 points; ``k_by_turn`` (state, turn) with
        ``turn_angle`` (turn) in radians; ``period`` and ``outcome``. The error combines the spread over the angles with
        that between four parts of the record. It is the error of K for records of this length, whose mean is somewhat
        less than 1 in chaos. In those of less than 400 points it grows up to 1, since a cycle or a torus has not gone
        round often enough in a tenth of them, and K is as near 1 as in chaos.
    """
    from chaosdrill.analysis.measures.evidence import ZERO_ONE
    from chaosdrill.analysis.measures.records import over_records

    return over_records(system, given, job, ZERO_ONE)
