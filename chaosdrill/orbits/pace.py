"""How fast a system without a period moves: the unit in which its returns are waited for."""

from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.engine.numerics import Numerics

if TYPE_CHECKING:
    from chaosdrill.orbits.family import Family
    from chaosdrill.orbits.place import Place

UNITS = 32
"""Units over which the motion is looked at."""

SAMPLES = 8
"""Samples a unit."""

ROUNDS = 8
"""Times that the unit is improved, at most."""

MOST_STEPS = 2000
"""Steps that the motion may take in all units together before they are too long."""

ALIKE = 2.0
"""Ratio of two successive units that is good enough."""


def unit_of(family: "Family", place: "Place") -> float:
    """Forcing period, or the pace of the first motion that was followed."""
    if family.unit is None:
        family.keep_pace(pace(place, family.numerics))
    assert family.unit is not None
    return family.unit


def pace(place: "Place", numerics: Numerics) -> float:
    """Time in which the motion from a place crosses its own extent, 1 if it does not move.

    A sinusoidal motion takes about nine of these units for a turn.
    """
    unit = 1.0
    for _ in range(ROUNDS):
        better, steps = _crossing(place, numerics, unit)
        if not 1e-12 < better < 1e12 or (better > unit and steps > MOST_STEPS):
            return unit
        good = 1 / ALIKE <= better / unit <= ALIKE
        unit = better
        if good:
            break
    return unit


def _crossing(place: "Place", numerics: Numerics, unit: float) -> tuple[float, int]:
    """Extent over mean rate of the state for which that is longest, as samples at this distance show it, and the steps.

    States that only go one way tell nothing, as long as there are others.
    """
    system = place.system
    d = len(system.states)
    run = place.run(unit, numerics, samples=SAMPLES)
    samples = np.zeros(((UNITS + 2) * SAMPLES, d + len(system.quadratures) + 1))
    run.advance(UNITS, samples)
    rows = samples[: run.filled()[0]]
    if len(rows) < 2:
        return 0.0, run.steps
    rates = np.zeros((len(rows), d + len(system.quadratures)))
    times = np.arange(1, len(rows) + 1) * unit / SAMPLES
    for row, time, rate in zip(rows, times, rates, strict=True):
        system.kernels.functions[3](int(row[-1]), time, run.c, row[:d].copy(), rate)
    extent = np.ptp(rows[:, :d], axis=0)
    mean = np.sqrt((rates[:, :d] ** 2).mean(axis=0))
    moving = (mean > 0) & (extent > 0)
    ways = extent[moving] / mean[moving]
    returning = ways < UNITS * unit / 2
    return float((ways[returning] if returning.any() else ways).max(initial=0.0)), run.steps
