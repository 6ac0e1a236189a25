"""Smooth averages of section points with their number of digits, and the rotation number."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from chaosdrill.analysis.base import Dataset, HybridSystem, Job, SweptRecord, analysis
from chaosdrill.dataset.schema import COVERS, STATES, SWEEP, axis, need, outcome, table
from chaosdrill.names import remedy
from chaosdrill.settings import Faults, ListOf, Text, setting, told

_STATE = f"{SWEEP} state"

VARIABLES = table(
    axis(SWEEP, SWEEP, "f8", "swept parameter", "Values of the sweep.", True),
    *STATES,
    need("average", _STATE, "f8", "weighted Birkhoff average", "Over section points. NaN for a state at rest there."),
    need("average_error", _STATE, "f8", "standard error of the average", COVERS),
    need(
        "digits",
        _STATE,
        "f8",
        "digits of the average",
        "Agreement of both halves, relative to the extent. NaN as the average.",
    ),
    need("digits_error", _STATE, "f8", "standard error of the digits", "Of those of records of the same length."),
    need("rotation_number", SWEEP, "f8", "rotation number", "Turns about the centre from point to point, 0 to 1."),
    need("rotation_number_error", SWEEP, "f8", "standard error of the rotation number", COVERS),
    need("period", SWEEP, "i4", "period found", "In iterates of the section; 0 when none was found."),
    outcome(SWEEP),
    sampled=("digits", "digits_error"),
)


@dataclass(frozen=True, kw_only=True)
class Regularity(SweptRecord):
    """Settings of `regularity`."""

    meanings: ClassVar[Mapping[str, str]] = {"periods": "Points of the section to record, at least 40."}

    plane: list[str] | None = setting(
        ListOf(Text(), distinct=True, least=1, most=2),
        None,
        doc="States of the plane in which points turn, from the first towards the second, or one state: an angle that "
        "goes round by itself, else it and its next value. Default: the only such angle, else the first two that move "
        "on the section or, if only one does, that one.",
    )

    @classmethod
    def misfits(cls, table: Mapping[str, Any], system: HybridSystem) -> Faults:
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
def regularity(system: HybridSystem, given: Regularity, job: Job) -> Dataset:
    """Weighted Birkhoff averages of section points, their number of digits, and the rotation number.

    The weight exp(-1/(t(1-t))) fades the average in and out, so that on a torus or a cycle it converges faster than any
    power of the record's length, and in chaos like the inverse of its square root (Das, Saiki, Sander and Yorke 2017,
    doi:10.1088/1361-6544/aa84c2). The averages over both halves of the record agree to ``digits`` digits: ten or more
    with 2000 points on a smooth torus, one or two in chaos, whatever the length. Where jumps cut a torus, as at the
    strobe of an integrate-and-fire cell, averages converge slowly; use points at its events instead.

    The rotation number is the smooth average of the angle by which a point turns about the average of all, seen in a
    plane of two states, or of an angle among the states that goes round. On a closed curve about that centre it is the
    ratio of two frequencies, up to whole numbers; on a cycle a fraction. On other sets it is the mean of that angle,
    which depends on the plane. Where angles fill the turn, as in most chaos, turns cannot be counted, and it is NaN, as
    it is where the error reaches half a turn, or where several angles go round and ``plane`` names none; the attribute
    ``reason`` says which.

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
    """
    from chaosdrill.analysis.measures.evidence import REGULARITY
    from chaosdrill.analysis.measures.records import over_records

    return over_records(system, given, job, REGULARITY)
