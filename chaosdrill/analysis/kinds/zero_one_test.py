"""The 0-1 test for chaos, from the points of a section."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from chaosdrill.analysis.base import Record, analysis
from chaosdrill.dataset.schema import STATES, axis, need, outcome, table
from chaosdrill.settings import Whole, setting

if TYPE_CHECKING:
    import xarray as xr

    from chaosdrill.analysis.base import Job
    from chaosdrill.model import HybridSystem

VARIABLES = table(
    *STATES,
    need("k", "state", "f8", "growth K of the 0-1 test", "0: regular, 1: chaos. NaN for a state that does not move."),
    need("k_error", "state", "f8", "standard error of K", "Of the mean K of records of the same length."),
    need("k_by_turn", "state turn", "f8", "growth K for each turning phase", "K is the median over these."),
    axis("turn_angle", "turn", "f8", "turning phase", "In radians, between pi/5 and 4 pi/5."),
    need("period", "", "i4", "period found", "In iterates of the section; 0 when none was found."),
    outcome(""),
    bars={"k": "k_error"},
    sampled=("k_by_turn",),
)


@dataclass(frozen=True, kw_only=True)
class ZeroOneTest(Record):
    """Settings of `zero_one_test`."""

    needs_section: ClassVar[bool] = True

    max_period: int = setting(Whole(1, 1_000_000), 64)


@analysis(
    "zero-one-test",
    ZeroOneTest,
    "growth K of the 0-1 test: 0 for regular motion, 1 for chaos",
    VARIABLES,
    cites=("gottwald2009",),
)
def zero_one_test(system: "HybridSystem", given: ZeroOneTest, job: "Job") -> "xr.Dataset":
    """The 0-1 test of each state, from section points alone: no tangents, and no equations but those of the run.

    The values of a state drive a point in a plane that turns by a fixed angle at every iterate. If the motion is
    regular the point stays bounded, and in chaos it wanders like a random walk. K is the correlation of its mean square
    displacement, without the part that oscillates, with time, the median over 24 angles (Gottwald and Melbourne 2009,
    doi:10.1137/080718851). Near 0 and near 1 K decides; between them the record is too short, or the chaos has many
    bands. Noise of the measurement, slow drift, and strange attractors that are not chaotic give values between as
    well.

    Parameters
    ----------
    system : HybridSystem
        System with its parameters and initial state.
    periods, duration : int or float
        Points of the section to record, or time; 40 points at least, several hundred to decide anything.
    transient : int or float, default 0
        Points of the section, or time, to run before the record starts.
    at, max_return : optional
        The section, as in `poincare_section`.
    max_period : int, default 64
        Longest period to detect.
    method, tolerance, steps, max_events, max_stalls, progress : optional
        As in `trajectory`.

    Returns
    -------
    xarray.Dataset
        ``k``, ``k_error`` (state), dimensionless, NaN for a state that does not move on the section and if the run
        ended early or has fewer than 40 points; ``k_by_turn`` (state, turn) with ``turn_angle`` (turn) in radians;
        ``period`` and ``outcome``. The error joins the spread over the angles with that between four parts of the
        record. It is that of K of records of this length, whose mean is somewhat less than 1 in chaos.

    Raises
    ------
    SettingsError
        An argument that cannot be used.
    """
    from chaosdrill.analysis.evidence import zero_one_dataset

    return zero_one_dataset(system, given, job)
