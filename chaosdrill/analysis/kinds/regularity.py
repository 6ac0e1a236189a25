"""Smooth averages of section points with their number of digits, and the rotation number."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from chaosdrill.analysis.base import SweptRecord, analysis
from chaosdrill.dataset.schema import COVERS, STATES, SWEEP, axis, need, outcome, table
from chaosdrill.names import remedy
from chaosdrill.settings import Faults, ListOf, Text, setting, told

if TYPE_CHECKING:
    import xarray as xr

    from chaosdrill.analysis.base import Job
    from chaosdrill.model import HybridSystem

_STATE = f"{SWEEP} state"

VARIABLES = table(
    axis(SWEEP, SWEEP, "f8", "swept parameter", "Values of the sweep.", True),
    *STATES,
    need("average", _STATE, "f8", "weighted Birkhoff average", "Over section points. NaN for a state at rest there."),
    need("average_error", _STATE, "f8", "standard error of the average", COVERS),
    need("digits", _STATE, "f8", "digits of the average", "Agreement of both halves, relative to the extent."),
    need("digits_error", _STATE, "f8", "standard error of the digits", "Of those of records of the same length."),
    need("rotation_number", SWEEP, "f8", "rotation number", "Turns about the centre from point to point, 0 to 1."),
    need("rotation_number_error", SWEEP, "f8", "standard error of the rotation number", COVERS),
    need("period", SWEEP, "i4", "period found", "In iterates of the section; 0 when none was found."),
    outcome(SWEEP),
    bars={"average": "average_error", "rotation_number": "rotation_number_error"},
    sampled=("digits", "digits_error"),
)


@dataclass(frozen=True, kw_only=True)
class Regularity(SweptRecord):
    """Settings of `regularity`."""

    plane: list[str] | None = setting(ListOf(Text(), distinct=True, least=2, most=2), None)

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
    """Weighted Birkhoff averages of section points, their number of digits, and the rotation number.

    The weight exp(-1/(t(1-t))) fades the average in and out, so that on a torus or a cycle it converges faster than any
    power of the record's length, and in chaos like the inverse of its square root (Das, Saiki, Sander and Yorke 2017,
    doi:10.1088/1361-6544/aa84c2). The averages over both halves of the record agree to ``digits`` digits: ten or more
    with 2000 points on a smooth torus, one or two in chaos, whatever the length. Where jumps cut a torus, as at the
    strobe of an integrate-and-fire cell, averages converge slowly; use points at its events instead.

    The rotation number is the smooth average of the angle by which a point turns about the average of all, seen in a
    plane of two states. On a closed curve about that centre it is the ratio of two frequencies, up to whole numbers;
    on a cycle a fraction. On other sets it is the mean of that angle, which depends on the plane.

    Parameters
    ----------
    system : HybridSystem
        System with its parameters and initial state.
    sweep : mapping of one parameter to values, optional
        ``{"eta": np.linspace(0.4, 0.9, 501)}``: a record at every value, each from the system's own initial state.
    periods, duration : int or float
        Points of the section to record, at least 40, or time.
    transient : int or float, default 0
        Points of the section, or time, to run before the record starts.
    at, max_return : optional
        The section, as in `poincare_section`.
    max_period : int, default 64
        Longest period to detect.
    plane : pair of str, optional
        States of the plane in which points turn, from the first towards the second; default: the first two that move on
        the section or, if only one does, this state and its next value.
    workers : int, default 1
        Threads among which the values of a sweep are shared; the kernels release the interpreter's lock.
    scheduler : str, optional
        Address of a Dask scheduler, whose workers are used instead.
    store : path-like, optional
        Folder for finished values of a sweep, from which the same call resumes if it was interrupted.
    method, tolerance, steps, max_events, max_stalls, progress : optional
        As in `trajectory`.

    Returns
    -------
    xarray.Dataset
        Over the swept parameter, if there is one: ``average``, ``average_error`` (in the unit of the state), ``digits``
        and ``digits_error`` (state); ``rotation_number`` in turns, from 0 to 1, and ``rotation_number_error``;
        ``period`` and ``outcome``. NaN for states that do not move on the section, and if the run ended early or has
        fewer than 40 points. Where averages converge as on a torus, errors are the differences between both halves of
        the record; elsewhere they are at least those of means of correlated values, and never less than the tolerance
        allows. The error of the digits is their scatter over parts of the record, at least 0.48, as for normal
        quantities.

    Raises
    ------
    SettingsError
        An argument that cannot be used, or a ``store`` that holds chunks of another call.
    ArchiveError
        If the ``store`` cannot be written, or another call uses it.
    ChaosdrillError
        If the scheduler cannot be reached or is lost, or if its workers have other versions.
    """
    from chaosdrill.analysis.evidence import REGULARITY
    from chaosdrill.analysis.records import over_records

    return over_records(system, given, job, REGULARITY)
