"""The arcs of an orbit one by one, with the states at which they end."""

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from chaosdrill.orbits.family import Family
    from chaosdrill.orbits.orbit import Orbit


def arc_by_arc(family: "Family", orbit: "Orbit") -> Iterator[tuple["Orbit", np.ndarray]]:
    """Every arc as a path of its own, and the state before the event at its end, shape (d,)."""
    period = family.period_at(orbit)
    clock = orbit.phase
    for i in range(len(orbit)):
        durations = orbit.durations[i : i + 1]
        one = replace(
            orbit, arcs=orbit.arcs[i : i + 1], starts=orbit.starts[i : i + 1], phase=clock, durations=durations
        )
        yield one, family.at([one], durations[np.newaxis])[0][0, 0]
        clock += float(durations[0])
        clock = clock % period if period else clock
