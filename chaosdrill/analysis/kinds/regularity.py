"""Smooth averages of section points with the digits that they reach, and the rotation number."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from chaosdrill.analysis.base import Record, analysis
from chaosdrill.dataset.schema import STATES, need, outcome, table
from chaosdrill.names import remedy
from chaosdrill.settings import Faults, ListOf, Text, Whole, setting, told

if TYPE_CHECKING:
    import xarray as xr

    from chaosdrill.analysis.base import Job
    from chaosdrill.model import HybridSystem

VARIABLES = table(
    *STATES,
    need("average", "state", "f8", "weighted Birkhoff average", "Over section points. NaN for a state at rest there."),
    need("average_error", "state", "f8", "error of the average", "What both halves of the record differ by."),
    need("digits", "state", "f8", "digits of the average", "Agreement of both halves, in parts of the extent."),
    need("rotation_number", "", "f8", "rotation number", "Turns about the centre from point to point, 0 to 1."),
    need("rotation_number_error", "", "f8", "error of the rotation number", "What both halves differ by."),
    need("period", "", "i4", "period found", "In iterates of the section; 0 when none was found."),
    outcome(""),
    bars={"average": "average_error", "rotation_number": "rotation_number_error"},
    sampled=("digits",),
)


@dataclass(frozen=True, kw_only=True)
class Regularity(Record):
    """Settings of `regularity`."""

    needs_section: ClassVar[bool] = True

    plane: list[str] | None = setting(ListOf(Text(), distinct=True, least=2, most=2), None)
    max_period: int = setting(Whole(1, 1_000_000), 64)

    @classmethod
    def misfits(cls, table: Mapping[str, Any], system: "HybridSystem") -> Faults:
        """A state that the system does not have."""
        yield from super().misfits(table, system)
        for number, name in enumerate(table.get("plane") or ()):
            if name not in system.state_names:
                yield ("plane", number), told(f"unknown state; {remedy(name, system.state_names)}", name)


@analysis(
    "regularity",
    Regularity,
    "smooth averages with their digits, and the rotation number",
    VARIABLES,
    cites=("das2017",),
)
def regularity(system: "HybridSystem", given: Regularity, job: "Job") -> "xr.Dataset":
    """Weighted Birkhoff averages of section points, the digits that they reach, and the rotation number.

    The weight exp(-1/(t(1-t))) fades the average in and out, so that on a torus or a cycle it converges faster than any
    power of the record's length, and in chaos like one over its root (Das, Saiki, Sander and Yorke 2017,
    doi:10.1088/1361-6544/aa84c2). The averages over both halves of the record agree to ``digits`` digits: ten or more
    with 2000 points on a smooth torus, one or two in chaos, whatever the length. Where jumps cut a torus, as at the
    strobe of an integrate-and-fire cell, averages converge slowly, and points at its events do better.

    The rotation number is the smooth average of the angle by which a point turns about the average of all, seen in a
    plane of two states. On a closed curve about that centre it is the ratio of two frequencies, up to whole numbers;
    on a cycle a fraction. On other sets it is the mean of that angle, which depends on the plane.

    Parameters
    ----------
    system : HybridSystem
        System with its parameters and initial state.
    periods, duration : int or float
        Points of the section to record, 40 at least, or time.
    transient : int or float, default 0
        Points of the section, or time, to run before the record starts.
    at, max_return : optional
        The section, as in `poincare_section`.
    plane : pair of str, optional
        States in whose plane points turn, from the first towards the second; default: the first two that move on the
        section, or, where only one does, this state and its next value.
    max_period : int, default 64
        Longest period to detect.
    method, tolerance, steps, max_events, max_stalls, progress : optional
        As in `trajectory`.

    Returns
    -------
    xarray.Dataset
        ``average``, ``average_error`` (in the unit of the state) and ``digits`` (state); ``rotation_number`` in turns,
        from 0 to 1, and ``rotation_number_error``; ``period`` and ``outcome``. NaN for states that do not move on the
        section, and if the run ended early or has fewer than 40 points. Errors are what both halves of the record
        differ by, and what the tolerance allows.

    Raises
    ------
    SettingsError
        An argument that cannot be used.
    """
    from chaosdrill.analysis.evidence import regularity_dataset

    return regularity_dataset(system, given, job)
