"""The fixed signatures through which the engine sees a system; arrays are C-contiguous doubles."""

from collections import namedtuple
from typing import Any, NamedTuple

from chaosdrill.codegen.kinds import float64, int64, void

vector = float64[::1]
matrix = float64[:, ::1]
cube = float64[:, :, ::1]
integers = int64[::1]
integer_matrix = int64[:, ::1]

SIGNATURES = {
    "jet": void(int64, int64, float64, vector, vector, matrix),
    "jacobian_jet": void(int64, int64, vector, matrix),
    "tangent": void(int64, int64, vector, vector, vector, matrix, int64),
    "field": void(int64, float64, vector, vector, vector),
    "variation": void(int64, float64, vector, vector, vector, vector),
    "guard": float64(int64, int64, float64, vector, vector, vector),
    "guard_error": float64(int64, int64, float64, vector, vector, vector),
    "event_map": int64(int64, int64, float64, vector, vector, int64, vector, float64, vector),
    "watch": void(int64, float64, vector, vector, vector),
    "rate_error": float64(int64, int64, float64, vector, vector, vector),
}
"""name -> signature of the ten functions that make a system, in the order in which the engine takes them

* ``jet(mode, order, t, c, x, ws)`` Taylor coefficients of states, quadratures and guards
* ``jacobian_jet(mode, order, c, ws)`` coefficients of the Jacobian's entries
* ``tangent(mode, order, c, first, second, ws, row)`` coefficients of two tangent vectors, one after the other
* ``field(mode, t, c, x, out)`` time derivatives of states, then integrands of quadratures
* ``variation(mode, t, c, x, d, out)`` Jacobian times a vector
* ``guard(mode, j, t, c, x, gradient)`` value of the mode's j-th guard, its gradient and, last, its time derivative;
  behind the guards come the surfaces that the mode holds
* ``guard_error(mode, j, t, c, x, doubt)`` how far that value may be from the exact one, in units of the rounding
  unit, of states with one rounding and the errors ``doubt``
* ``event_map(mode, j, t, c, x, tangents, scale, tolerance, event)`` puts the state onto the mode's j-th guard, by the
  shortest way in the scales of the states, and returns the transition that this event takes, -1 for none; what goes
  with it stands in ``event``, see `event_places`. Where ``tangents`` is 0, what only tangents need is left out
* ``watch(mode, t, c, x, out)`` what the mode's steep operations are applied to, see ``codegen.steep``
* ``rate_error(mode, j, t, c, x, doubt)`` as ``guard_error``, of the guard's rate along the flow; behind the guards come
  the states and the quadratures, of which it is the error of the rate: 0 where that is not known
"""

POINTWISE = ("field", "variation", "guard", "guard_error", "event_map", "watch", "rate_error")
"""Those that are no series."""


class EventPlaces(NamedTuple):
    """Where in the array of an event its numbers begin."""

    gradient: int
    complete: int
    speed: int
    pull: int
    jerk: int
    rate: int
    part: int
    reach: int
    known: int
    doubt: int
    before: int
    after: int
    image: int
    jacobian: int
    size: int


def event_places(n: int) -> EventPlaces:
    """Places for a system of n states.

    Gradient of the guard and, last, its time derivative; whether the outcome is taken that completes rebounds (1) or
    one of the others (0), which is given; of an event that may be one of a series of rebounds, speed and acceleration
    of the guard after it and the rate of that; rate of the transition's guard, as it is written, before the event.

    By how much the states may be off: those that move before the event by ``part`` of their values, by ``reach`` of
    their rates, or by ``known``, whichever is least of the larger of the first two and the third; those that rest by
    ``doubt``. All four are given, and under ``doubt`` stands the same of the states after the event.

    Rates of the states before and after; the state after; its derivatives by states and, last, time, row by row.
    """
    known = n + 8
    before = known + 2 * n
    image = before + 2 * n
    jacobian = image + n
    return EventPlaces(
        *(0, n + 1, n + 2, n + 3, n + 4, n + 5, n + 6, n + 7, known, known + n),
        *(before, before + n, image, jacobian, jacobian + n * (n + 1)),
    )


LANES = 8
"""Trajectories that are stepped side by side."""

WIDTH = 28
"""Coefficients of a series, at most; beyond the order a row holds zeros, so that all sums have one length."""

LANE_SIGNATURES = {
    "jet": void(int64, int64, vector, matrix, matrix, cube),
    "jacobian_jet": void(int64, int64, matrix, cube),
    "tangent": void(int64, int64, matrix, matrix, matrix, cube, int64),
}
"""The three functions of series for eight trajectories at once: as above, every number being a row of eight.

Their arrays are those of ``engine.lanes.aligned``: times (8,), constants (number, 8), states (n, 8) and the workspace
(rows, columns, 8).
"""

CONSTANTS = void(vector, vector)
"""``constants(p, c)``: parameters, then the expressions of parameters that the code needs"""


def _tuple_of(name: str, signatures: dict[str, Any]) -> Any:
    """A named tuple of functions, as any type: checkers know no fields that are computed."""
    return namedtuple(name, signatures)


Functions = _tuple_of("Functions", SIGNATURES)
"""The compiled functions of `SIGNATURES`."""

LaneFunctions = _tuple_of("LaneFunctions", LANE_SIGNATURES)
"""Those of `LANE_SIGNATURES`, for eight runs at once."""
