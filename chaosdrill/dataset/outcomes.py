"""Outcomes of the computation of one point."""

from collections import Counter
from typing import Any

from chaosdrill.annotations import DataArray, Variable
from chaosdrill.dataset.codes import Code


class Outcome(Code):
    """Outcome of one run; archives store the number, with the names as CF flag meanings.

    A run has numbers if its outcome is one of ``MEASURED``; otherwise they are missing (NaN). ``advice`` says what an
    outcome means and what to try.
    """

    OK = 0, "The run reached its end; the kind of attractor was not determined."
    PERIODIC = (
        1,
        "The motion repeats after the reported period, or all its exponents are negative except those that are zero "
        "for every motion.",
    )
    QUASIPERIODIC = (
        2,
        "The motion fills a torus: one more exponent than necessary is zero, the averages over two parts of the "
        "record agree as they do only on a torus, and no point returns.",
    )
    CHAOTIC = (
        3,
        "The largest exponent is positive beyond its error, to the end of a record that neither leaves anything nor "
        "settles; without forcing, the exponent of the flow is also zero.",
    )
    ESCAPED = 4, "A state left its bounds and runs away; start elsewhere, add damping, or widen the bounds."
    EVENT_LIMIT = (
        5,
        "More events in one period than can be followed, as in chatter that has not died out. If it should come to "
        "rest, add a mode that holds the contact; otherwise raise the restitution, or look for a reset that lets its "
        "guard fire again at once.",
    )
    STALLED = (
        6,
        "Events continued while no time passed. This is how chatter ends: after infinitely many impacts in finite "
        "time the contact would have to be held. Add a mode that holds it, raise the restitution, or look for a "
        "reset that leads back across its own guard. Two modes may also lead back and forth: their motions push onto "
        "one surface from both sides (cd.filippov builds a system that slides there); or one is entered where its "
        "guard has already been passed, such as sin(2*pi*t/T) for half of each period, and is left at once; for a "
        "clock take sin(pi*t/T) with direction 0.",
    )
    NONFINITE = (
        7,
        "A state, a tangent or a guard became infinite or not a number; look for a singular term, for a guard that "
        "is met at zero speed or has no value where its mode holds, or choose tighter bounds.",
    )
    STEP_UNDERFLOW = (
        8,
        "The step became too small to advance time, or a hundred million led to no event, sample or period; "
        "loosen the tolerance, or look for a singularity, also in a guard, and for what is far quicker than the motion "
        'that you want to see. If a mode is stiff, choose method "radau".',
    )
    INVALID_START = 9, "The initial state lies beyond a guard of its mode; move it inside or choose another mode."
    FAILED = 10, "The point could not be computed; run it alone as a trajectory to see where it stops."
    NO_ORBIT = (
        11,
        "Newton's method found no orbit of this period near the start; start closer to one, choose another period, "
        'or let a search look for it (start = "search").',
    )
    EQUILIBRIUM = (
        12,
        "The system has a point at rest, which is no orbit; where a motion came to rest there, start elsewhere to "
        "find another one.",
    )
    INADMISSIBLE = (
        13,
        "The equations of the orbit close, but another guard is crossed on the way or an event has another outcome, "
        "so the system has no such orbit; start closer to one that it has.",
    )
    OPEN = (
        14,
        "All states return except one that only grows, such as a distance; write the system in states that repeat, "
        "with the growing one as a quadrature.",
    )
    NO_SPECIAL_POINT = (
        15,
        "The branch along the first parameter has no such point from which to start a curve; widen the range of that "
        "parameter, follow another kind of point, or start from another orbit.",
    )
    UNDECIDED = (
        16,
        "The record is too short to distinguish the largest exponent from zero, and too short or too uneven to show "
        "a torus; take a longer record (more periods, a longer duration, or max_extension).",
    )
    NO_RETURN = (
        17,
        "The motion continues but does not meet the section again, or only touches it, which gives no period; choose "
        "another section (at), look at the trajectory, or allow more time between its points (max_return).",
    )
    SINGULAR = (
        18,
        "The motion reached a place where a term of the equations ends, such as sqrt(h) at h = 0, log(h) or 1/h; the "
        "equations do not say how it continues. The message of a trajectory names term and place. Add a transition "
        "there, whose guard is the vanishing quantity, to a mode in which the motion continues, or write the term so "
        'that it has a value beyond. If it has a value but no series, as d**1.5 at d = 0, choose method "dop853".',
    )
    TRANSIENT = (
        19,
        "The motion is still on its way: from an unstable equilibrium or cycle, to infinity, to rest, or to a cycle, "
        "so that its numbers do not belong to an attractor; take a longer transient, or start further from what it "
        "leaves.",
    )
    CONTRACTING = (
        20,
        "The largest exponent given the noise is negative beyond its error: motions from nearby starts converge "
        "under the same noise, which alone prevents them from repeating.",
    )
    NO_EQUILIBRIUM = (
        21,
        "Newton's method found no equilibrium from any start; the message says which modes cannot have one. For "
        "others widen the region or take more starts.",
    )
    NO_SADDLE = (
        22,
        "The orbit has no manifold of one dimension of the kind asked for, or none that could be followed; the "
        "message has its multipliers and the reason. Start from another orbit.",
    )


ADVICE = {outcome.meaning: outcome.advice for outcome in Outcome}

MEASURED = (
    Outcome.OK,
    Outcome.PERIODIC,
    Outcome.QUASIPERIODIC,
    Outcome.CHAOTIC,
    Outcome.OPEN,
    Outcome.UNDECIDED,
    Outcome.EQUILIBRIUM,
    Outcome.TRANSIENT,
    Outcome.CONTRACTING,
)
"""Outcomes of runs that reached their end, whose numbers are there; of a run at rest as far as it has any."""


def count_outcomes(codes: Any) -> dict[str, int]:
    """Number of occurrences of each outcome in an array of codes, by its meaning, in the order of the codes.

    A code that is not an outcome, as an altered archive may contain, is counted as ``code N``.
    """
    meanings = {int(outcome): outcome.meaning for outcome in Outcome}
    counts = Counter(codes.ravel().tolist())
    return {meanings.get(code, f"code {code}"): counts[code] for code in sorted(counts)}


def holds_codes(variable: DataArray | Variable) -> bool:
    """Whether the values are still codes of an analysis or a file, possibly selected or joined, but not computed with.

    Arithmetic keeps the attributes of a variable, and a difference of codes may itself be a code; but it drops the
    encoding, which for codes contains the stored type.
    """
    return "flag_values" in variable.attrs and getattr(variable.encoding.get("dtype"), "kind", "") in set("iu")


def flag_names(variable: DataArray | Variable) -> dict[int, str]:
    """Names of the values of a code variable, from its CF attributes ``flag_values`` and ``flag_meanings``."""
    import numpy as np

    names = str(variable.attrs.get("flag_meanings", "")).split()
    values = np.atleast_1d(variable.attrs.get("flag_values", np.zeros(0, dtype=int)))
    return dict(zip((int(value) for value in values), names, strict=True))
