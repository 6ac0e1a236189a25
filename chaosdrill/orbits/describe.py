"""What is known of an orbit that was found, verified by runs of the ordinary engine."""

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from chaosdrill.dataset import Outcome
from chaosdrill.engine import lap as at
from chaosdrill.orbits.arcs import arc_by_arc
from chaosdrill.orbits.checks import check
from chaosdrill.orbits.multipliers import graded, structural_rank
from chaosdrill.orbits.results import Checks, FoundOrbit
from chaosdrill.orbits.verify import verify

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem
    from chaosdrill.orbits.family import Family, Lap
    from chaosdrill.orbits.orbit import Orbit


def describe(family: "Family", orbit: "Orbit", lap: "Lap", residuals: np.ndarray, message: str = "") -> FoundOrbit:
    """The orbit with all that is known of it; without one, if the ordinary engine does not follow it.

    Parameters
    ----------
    family : Family
    orbit : Orbit
        A solution of the equations.
    lap : Lap
        What one lap around it showed.
    residuals : ndarray
        Of Newton's method.
    message : str
        What there is to say of it.
    """
    lapped = verify(family, orbit)
    if lapped.differs:
        text = f"the equations close, but a run of the system from there goes otherwise: {lapped.differs}"
        return no_orbit(family.plain, Outcome.INADMISSIBLE, text, orbit.periods, residuals)
    if not lapped.residual <= lapped.explained(family.numerics.tolerance):
        text = f"the equations close, but a run of the system from there misses its start by {lapped.residual:.1e}"
        return no_orbit(family.plain, Outcome.INADMISSIBLE, text, orbit.periods, residuals)
    if not np.isfinite(lap.monodromy).all():
        text = "the orbit meets a guard at no speed, where small deviations grow without bound: it has no multipliers"
        return no_orbit(family.plain, Outcome.NONFINITE, text, orbit.periods, residuals)
    rank = structural_rank(family, orbit)
    strobes, modes = family.strobes([orbit])
    found = FoundOrbit(
        outcome=Outcome.PERIODIC,
        message=message,
        period=orbit.periods,
        duration=float(orbit.durations.sum()),
        states=strobes[0],
        mode=int(modes[0, 0]),
        multipliers=graded(family, orbit, lap.monodromy, rank),
        rank=rank,
        residual=lapped.residual,
        newton=residuals,
        **_events(family, orbit),
        checks=_nothing_to_check(family.states),
        neutral=family.neutral.count,
    )
    return replace(found, checks=check(family, orbit, found, lapped))


def no_orbit(
    system: "HybridSystem", outcome: Outcome, message: str, period: int, residuals: np.ndarray | None = None
) -> FoundOrbit:
    """Why there is none."""
    d = len(system.states)
    nothing = float("nan")
    return FoundOrbit(
        outcome=outcome,
        message=message,
        period=period,
        duration=nothing,
        states=np.zeros((0, d)),
        mode=-1,
        multipliers=np.full(d, complex(nothing, nothing)),
        rank=0,
        residual=nothing,
        newton=np.zeros(0) if residuals is None else residuals,
        event_times=np.zeros(0),
        event_speeds=np.zeros(0),
        event_transitions=np.zeros(0, dtype=np.int64),
        event_states_before=np.zeros((0, d)),
        event_states_after=np.zeros((0, d)),
        checks=_nothing_to_check(d),
    )


def _nothing_to_check(d: int) -> Checks:
    nothing = float("nan")
    return Checks(np.full(d, nothing), nothing, nothing, nothing, False)


def _events(family: "Family", orbit: "Orbit") -> dict[str, Any]:
    """Events in the order in which they come from phase 0 on, as fields of a `FoundOrbit`."""
    d, count = family.states, len(orbit)
    before, speeds = np.zeros((count, d)), np.full(count, np.inf)
    kernels = family.plain.kernels
    constants = kernels.constants(family.plain.parameters)
    rates, gradient = np.zeros(d + len(family.plain.quadratures)), np.zeros(d + 1)
    for i, (one, state) in enumerate(arc_by_arc(family, orbit)):
        mode, end = one.arcs[0, : at.ARC_OUTCOME].tolist()
        before[i] = state
        if end >= 0:
            time = one.phase + float(one.durations[0])
            kernels.functions[3](mode, time, constants, state, rates)
            kernels.functions[5](mode, end, time, constants, state, gradient)
            speeds[i] = gradient[:d] @ rates[:d] + gradient[d]
    ends = np.cumsum(orbit.durations)
    period = family.period
    times = (ends + orbit.phase) % (orbit.periods * period) if period else ends
    kinds = np.flatnonzero(orbit.arcs[:, at.ARC_END] >= 0)
    order = kinds[np.argsort(times[kinds], kind="stable")]
    return {
        "event_times": times[order],
        "event_speeds": speeds[order],
        "event_transitions": orbit.arcs[order, at.ARC_OUTCOME],
        "event_states_before": before[order],
        "event_states_after": orbit.starts[(order + 1) % count, :d],
    }
