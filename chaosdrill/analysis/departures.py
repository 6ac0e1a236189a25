"""Runs that leave an unstable cycle, more slowly than anybody would wait, are displaced in the direction they go.

Just behind a bifurcation a state that was followed there stands close to the cycle that has lost its stability, and
departs from it by a factor of 1 + 1e-4 a period, say.
"""

from collections.abc import Mapping

import numpy as np

from chaosdrill.analysis.cycles import Begun, at_points, attempts, extrapolate, trail_of
from chaosdrill.analysis.plan import Plan
from chaosdrill.analysis.recurrence import ROUND_OFF, recurrence, sizes, trend
from chaosdrill.engine.batch import Batch

DISPLACED = 0.02
"""Distance from the unstable cycle to which a run is displaced, relative to the size of the states."""


def departures(
    plan: Plan, batch: Batch, which: np.ndarray, parameters: Mapping[str, np.ndarray]
) -> tuple[np.ndarray, Batch]:
    """Runs that begin further away from the cycles that some points of a batch are leaving.

    Parameters
    ----------
    batch : Batch
        The runs, at the end of their record.
    which : ndarray of int
        Points that are undecided although they ran as long as they may.
    parameters : mapping of str to ndarray, shape (P,)
        Parameters of all points of the batch.

    Returns
    -------
    leaving : ndarray of int
        The points that are leaving a cycle.
    runs : Batch
        A run for each of these, which has not begun.
    """
    here = at_points(parameters, which)
    states, modes, trail, standing = trail_of(plan, batch, which, here)
    near = recurrence(trail, plan.max_period, 2 * plan.max_period).near
    displaced = np.full(states.shape, np.nan)
    for points, periods in attempts(near):
        tried = np.isnan(displaced[points, 0]) & trend(trail, points, periods)[1]
        points, periods = points[tried], periods[tried]
        stand = None if standing is None else standing.at(points)
        found, converged, _ = extrapolate(plan, at_points(here, points), states[points], modes[points], periods, stand)
        off = states[points] - found
        distance = (np.abs(off) / sizes(found[:, np.newaxis])).max(axis=1)
        slow = converged & (distance > 10 * ROUND_OFF) & (distance < DISPLACED)
        displaced[points[slow]] = found[slow] + off[slow] * (DISPLACED / distance[slow])[:, np.newaxis]
    chosen = np.flatnonzero(np.isfinite(displaced[:, 0]))
    stand = None if standing is None else standing.at(chosen)
    begun = Begun(at_points(here, chosen), displaced[chosen], modes[chosen], stand)
    return which[chosen], begun.let(plan.batch(begun.parameters, begun.states, begun.modes))
