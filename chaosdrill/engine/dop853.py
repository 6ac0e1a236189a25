"""Adaptive Runge-Kutta method of order 8 with dense output of order 7 (Dormand and Prince, code DOP853).

Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, 2nd ed. 1993, section II.5
(doi:10.1007/978-3-540-78862-1). It asks nothing of the right-hand side but values, so it goes on where a Taylor series
does not exist. Guards become polynomials through the dense output; samples, strobes and events are steps of their own
of exactly the length asked for, so that they are as exact as the end of a step.
"""

import math

import numpy as np

from chaosdrill.engine.dop853_step import SAFETY, attempt, dense_output, error_of, first_length, shrink, size, weigh
from chaosdrill.engine.dop853_tables import (
    DENSE,
    END,
    ROWS_A_VECTOR,
    STAGES,
    VECTORS,
    WEIGHTS,
)
from chaosdrill.engine.guard_series import guard_polynomials
from chaosdrill.engine.guard_times import MOST_HALVINGS, NEAR, exact_times
from chaosdrill.engine.guards import EPSILON
from chaosdrill.engine.jit import inner
from chaosdrill.engine.layout import ONGOING
from chaosdrill.engine.records import machine_at, state_of
from chaosdrill.engine.stepper import offered
from chaosdrill.engine.taylor import SLOW

METHOD = {
    "summary": "adaptive Runge-Kutta of order 8, for right-hand sides that are not analytic; events as for taylor",
    "cites": ("hairer1993", "farouki2012"),
}

DENSE_NOISE = 4 * EPSILON * float(np.abs(DENSE).sum(axis=1).max())
"""Rounding units by which the dense output moves the polynomial of a state."""

LARGEST_GROWTH = 6.0
BEGINNING = 0.01
"""Part of a period, or of a run without one, to begin with where the size of no state is known."""

UNDERFLOW = 1e-16
"""Part of the longest step below which shortening is given up."""


@offered
def expand(place, p, t):
    """Take a step within tolerance and turn the guards into polynomials; returns its length, NaN if there is no rate.

    The guards' polynomials have their own part in the length: what they leave out must be below the tolerance.
    """
    machine = machine_at(place)
    functions, settings, tables, scratch = machine.functions, machine.settings[0], machine.tables, machine.scratch
    state = state_of(machine.states, p)
    run, x, scale, vectors, stages = state.run[0], state.x, state.scale, state.vectors, scratch.stages
    mode, live = run.mode, run.live
    tolerance = settings.tolerance
    longest = run.period
    functions.field(mode, t, state.c, x, stages[0])
    run.evaluations += 1
    for v in range(live):
        functions.variation(mode, t, state.c, x, vectors[v], stages[VECTORS + ROWS_A_VECTOR * v])
    known = weigh(x, scale, longest, tolerance, stages)
    if not math.isfinite(size(stages[0], stages[WEIGHTS])):
        return math.nan
    h = run.next_step
    if h <= 0.0 and not known:
        h = BEGINNING * longest
    elif h <= 0.0:
        h = first_length(functions, t, state, tolerance, longest, stages)
    wanted = h
    rest = longest - run.time
    if run.strobes + 1 >= settings.target and rest > NEAR * longest:
        h = min(h, rest)
    cut = h < wanted
    rejected = False
    halvings = 0
    longer = 0.0
    larger = 0.0
    while h > UNDERFLOW * run.longest:
        attempt(functions, t, state.c, x, h, vectors, live, run, stages, stages[END])
        error = error_of(x, h, scale, vectors, live, stages) / tolerance
        if not error <= 1.0:
            factor = shrink(error, h, larger, longer, 8.0)
            larger = error
            longer = h
            h *= factor
            rejected = True
            continue
        if tables.active[mode, 0] > 0:
            dense_output(functions, t, state.c, x, h, run, stages, scratch.workspace)
            left = guard_polynomials(functions, tables, settings, state, t, h, scratch)
            if left == math.inf or (left > 1.0 and halvings < MOST_HALVINGS):
                halvings += 1
                rejected = True
                h *= 0.5
                continue
        strength = max(error, 1e-9) ** 0.125 / h
        before = run.strength if run.fresh == ONGOING else 0.0
        following = min(SAFETY / strength, LARGEST_GROWTH * h)
        if 0.0 < before < strength:
            following *= before / strength
        if rejected:
            following = min(following, h)
        elif cut:
            following = max(following, wanted)
        run.strength = strength
        run.next_step = min(following, longest)
        run.tried = h
        break
    for i in range(stages.shape[1]):
        moved = abs(stages[0, i]) * h
        scale[i] = max(scale[i], min(abs(x[i]), SLOW * moved) if i < x.size else moved)
    return h


@inner
def _arrive(functions, settings, t, state, s, scratch, out):
    """States and quadratures after a step of length s, to ``out``."""
    stages = scratch.stages
    attempt(functions, t, state.c, state.x, s, stages, 0, state.run[0], stages, out)


_exact_times = exact_times(_arrive)


@offered
def locate(place, p, te, h, t):
    """Make the times of the events exact by Newton steps on the guards themselves."""
    _exact_times(machine_at(place), p, te, h, t)
    return te, -1, 0


@offered
def evaluate(place, p, t, s):
    """States and quadratures after a step of length s, as exact as the end of a step; the step taken is kept."""
    machine = machine_at(place)
    state = state_of(machine.states, p)
    stages = machine.scratch.stages
    attempt(machine.functions, t, state.c, state.x, s, stages, 0, state.run[0], stages, machine.scratch.out)


@offered
def advance(place, p, t, s):
    """States and quadratures and, in place, tangents after a step of length s."""
    machine = machine_at(place)
    state = state_of(machine.states, p)
    run, x, vectors = state.run[0], state.x, state.vectors
    stages, out = machine.scratch.stages, machine.scratch.out
    n = x.size
    live = run.live
    if s != run.tried:
        attempt(machine.functions, t, state.c, x, s, vectors, live, run, stages, stages[END])
    for i in range(out.size):
        out[i] = stages[END, i]
    for v in range(live):
        for i in range(n):
            vectors[v, i] = stages[VECTORS + ROWS_A_VECTOR * v + STAGES + 1, i]
