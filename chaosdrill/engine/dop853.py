"""Adaptive Runge-Kutta method of order 8 with dense output of order 7 (Dormand and Prince, code DOP853).

Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, 2nd ed. 1993, section II.5
(doi:10.1007/978-3-540-78862-1). It asks nothing of the right-hand side but values, so it goes on where a Taylor series
does not exist. Guards become polynomials through the dense output; samples, strobes and events are steps of their own
of exactly the length asked for, so that they are as exact as the end of a step.
"""

import math

import numpy as np

from chaosdrill.codegen.layout import EPSILON
from chaosdrill.engine import checked, guard_series
from chaosdrill.engine import step_control as control
from chaosdrill.engine.dop853_tables import (
    DEGREE,
    DENSE,
    DENSE_STAGES,
    E3,
    E5,
    END,
    PLACE,
    ROWS_A_VECTOR,
    STAGES,
    VECTORS,
    WEIGHTS,
    A,
    C,
)
from chaosdrill.engine.guard_series import guard_polynomials
from chaosdrill.engine.jit import inner, series
from chaosdrill.engine.records import machine_at, state_of
from chaosdrill.engine.scales import SMALLEST, fill, finest, renew, widen
from chaosdrill.engine.stepper import offered
from chaosdrill.engine.tuning import CHECKS, DOP853, GUARDS, STEPS

METHOD = {
    "summary": "adaptive Runge-Kutta of order 8, for right-hand sides that are not analytic; events as for taylor",
    "cites": ("hairer1993", "farouki2012"),
}

DENSE_NOISE = 4 * EPSILON * float(np.abs(DENSE).sum(axis=1).max())
"""Rounding units by which the dense output moves the polynomial of a state."""


@series
def _combine(stages, first, count, weights, h, start, n, out):
    for i in range(n):
        s = 0.0
        for j in range(count):
            s += weights[j] * stages[first + j, i]
        out[i] = start[i] + h * s


@series
def stage(functions, mode, t, c, x, h, k, known, vectors, live, stages):
    """Rates of stage k of states, unless that is one of the known, and of tangents; stages before it are there."""
    n = x.size
    place = stages[PLACE]
    _combine(stages, 0, k, A[k], h, x, n, place)
    if k >= known:
        functions.field(mode, t + C[k] * h, c, place, stages[k])
    for v in range(live):
        row = VECTORS + ROWS_A_VECTOR * v
        direction = stages[row + PLACE]
        _combine(stages, row, k, A[k], h, vectors[v], n, direction)
        functions.variation(mode, t + C[k] * h, c, place, direction, stages[row + k])


@series
def attempt(functions, t, c, x, h, vectors, live, run, stages, out):
    """A step of length h from the rates at its start: states and quadratures to ``out``, tangents to their last row."""
    n = x.size
    for k in range(1, STAGES):
        stage(functions, run.mode, t, c, x, h, k, k, vectors, live, stages)
    run.evaluations += STAGES - 1
    _combine(stages, 0, STAGES, A[STAGES], h, x, n, out)
    for i in range(n, out.size):
        s = 0.0
        for j in range(STAGES):
            s += A[STAGES, j] * stages[j, i]
        out[i] = h * s
    for v in range(live):
        row = VECTORS + ROWS_A_VECTOR * v
        _combine(stages, row, STAGES, A[STAGES], h, vectors[v], n, stages[row + END])


@series
def _estimate(stages, first, n, h, length):
    """Local error as a part of a length in scales, from embedded formulas of orders 5 and 3, as Hairer, Norsett and
    Wanner combine them; the one of order 5 may be zero by accident, and is not believed then."""
    fifth = 0.0
    third = 0.0
    for i in range(n):
        a = 0.0
        b = 0.0
        for j in range(STAGES):
            a += E5[j] * stages[first + j, i]
            b += E3[j] * stages[first + j, i]
        a = abs(a)
        b = abs(b)
        spread = 0.0
        for j in range(1, STAGES):
            spread = max(spread, abs(stages[first + j, i] - stages[first, i]))
        if a * spread < DOP853.blind * b * b:
            a = min(DOP853.blind * b * (b / spread), b)
        # before the square, which overflows where a state has decayed to nothing
        a *= stages[WEIGHTS, i] / length
        b *= stages[WEIGHTS, i] / length
        fifth += a * a
        third += b * b
    return h * fifth / math.sqrt(fifth + 0.01 * third) if fifth > 0.0 else fifth * h


@inner
def error_of(x, h, scale, span, least, longest, vectors, live, rounding, stages):
    """Largest error of a step: of states and quadratures in their scales, of a tangent relative to its length.

    No scale is smaller than ``rounding`` has it, see `coarsest`; a state whose own would be has none for tangents.

    What has begun to move in this step has at least the scale of what it moves, and keeps that of the first length that
    is tried: what begins with a power of time looks alike at all lengths, until round-off is all of it. Tangents count
    states that have none, as what has decayed to nothing, in the largest scale of the others.
    """
    for i in range(stages.shape[1]):
        moved = abs(stages[0, i]) * h
        slowest = math.inf
        for j in range(1, STAGES):
            moved = max(moved, abs(stages[j, i]) * h)
            slowest = min(slowest, abs(stages[j, i]) * h)
        if control.is_new(scale[i], x[i] if i < x.size else 0.0, stages[0, i], least, longest):
            moved = control.begun(scale, i, slowest, moved)
        width = max(scale[i], moved, rounding[i])
        stages[WEIGHTS, i] = 1.0 / width if width > SMALLEST else 0.0
    error = _estimate(stages, 0, stages.shape[1], h, 1.0)
    if live > 0:
        for i in range(x.size):
            if rounding[i] * stages[WEIGHTS, i] > 0.5:
                stages[WEIGHTS, i] = 0.0
        fill(stages[WEIGHTS][: x.size])
        widen(stages[WEIGHTS], span, x.size)
    for v in range(live):
        length = control.size(vectors[v], stages[WEIGHTS])
        if length > 0.0:
            e = _estimate(stages, VECTORS + ROWS_A_VECTOR * v, x.size, h, length) / STEPS.tangents
            error = e if not e <= error else error
    return error


@inner
def _parted(functions, t, state, h, least, stages):
    """Largest part of itself by which the rate of a state that begins differs between the last stage and the end.

    Both are at one time. Where a step is far too long for what the rate depends on, its stages explode, and what they
    move is no size of the motion, even if the rate at the start is zero.
    """
    run, x, scale = state.run[0], state.x, state.scale
    last, after = stages[STAGES - 1], stages[STAGES]
    known = False
    largest = 0.0
    for i in range(stages.shape[1]):
        if not control.is_new(scale[i], x[i] if i < x.size else 0.0, stages[0, i], least, run.period):
            continue
        fastest = 0.0
        for j in range(STAGES):
            fastest = max(fastest, abs(stages[j, i]))
        if fastest == 0.0:
            continue
        if not known:
            functions.field(run.mode, t + h, state.c, stages[END], after)
            run.evaluations += 1
            known = True
        part = abs(after[i] - last[i]) / fastest
        largest = largest if part <= largest else part
    return largest


@series
def _polynomial(stages, first, i, start, h, row):
    """Coefficients from the rates of the stages, which stand from row ``first`` on."""
    row[0] = start
    row[1] = stages[first, i]
    power = 1.0
    for k in range(2, DEGREE + 1):
        power /= h
        s = 0.0
        for j in range(DENSE_STAGES):
            s += DENSE[k - 1, j] * stages[first + j, i]
        row[k] = s * power


@series
def dense_output(functions, t, c, x, h, known, vectors, live, run, stages, ws):
    """Coefficients of states, integrals and as many tangents as are live; ``known`` stages of the states are there."""
    n = x.size
    for k in range(STAGES, DENSE_STAGES):
        stage(functions, run.mode, t, c, x, h, k, known, vectors, live, stages)
    run.evaluations += DENSE_STAGES - known
    for i in range(stages.shape[1]):
        _polynomial(stages, 0, i, x[i] if i < n else 0.0, h, ws[i])
    for v in range(live):
        for i in range(n):
            row = ws[checked.first_row(ws, vectors, v) + i]
            _polynomial(stages, VECTORS + ROWS_A_VECTOR * v, i, vectors[v, i], h, row)


@inner
def _agrees(functions, tables, settings, s, t, state, ws, scratch):
    """Whether the dense output obeys the equations at s."""
    allowed = CHECKS.dense_defect * settings.tolerance
    checked.dense_defect(functions, DEGREE, s, t, state, ws, scratch)
    if not checked.dense_agrees(functions, tables, settings, 0, allowed, s, t, state, scratch):
        return False
    part = CHECKS.dense_defect * GUARDS.interpolated
    if not checked.guards_agree(functions, tables, settings, part, s, t, state, ws, scratch):
        return False
    return checked.tangents_agree(functions, DEGREE, allowed, settings.dense_noise, s, t, state, ws, scratch)


_look = checked.looks(_agrees)


@offered
def expand(place, p, t):
    """Take a step within tolerance and turn the guards into polynomials; returns its length, NaN if there is no rate.

    The guards' polynomials have their own part in the length: what they leave out must be below the tolerance.
    """
    machine = machine_at(place)
    functions, settings, tables, scratch = machine.functions, machine.settings[0], machine.tables, machine.scratch
    state = state_of(machine.states, p)
    run, x, scale, span, vectors, stages = state.run[0], state.x, state.scale, state.span, state.vectors, scratch.stages
    mode, live = run.mode, run.live
    tolerance = settings.tolerance
    least = finest(tolerance)
    functions.field(mode, t, state.c, x, stages[0])
    run.evaluations += 1
    for v in range(live):
        functions.variation(mode, t, state.c, x, vectors[v], stages[VECTORS + ROWS_A_VECTOR * v])
    renew(tables, mode, x.size, x, scale, span)
    known = control.weigh(x, scale, run.period, tolerance, stages)
    if not math.isfinite(control.size(stages[0], stages[WEIGHTS])):
        return math.nan
    wanted = control.wanted_length(functions, t, state, known, tolerance, stages)
    h = control.up_to_goal(settings, run, wanted)
    rejected = ends = cut = False
    halvings = 0
    longer = larger = 0.0
    parted = math.inf
    while h > STEPS.underflow * run.longest:
        attempt(functions, t, state.c, x, h, vectors, live, run, stages, stages[END])
        part = _parted(functions, t, state, h, least, stages)
        # what begins with a high power of time, or a root of itself, looks alike at all lengths
        if not part <= DOP853.parted and (part < 0.5 * parted or not math.isfinite(part)):
            parted = min(parted, part)
            h *= STEPS.smallest_growth
            rejected = True
            continue
        error = error_of(x, h, scale, span, least, run.period, vectors, live, scratch.none, stages) / tolerance
        if error > 1.0:
            checked.coarsest(functions, tables, tolerance, h, t, state, stages[END], scratch)
            error = error_of(x, h, scale, span, least, run.period, vectors, live, scratch.doubt, stages) / tolerance
        if not error <= 1.0:
            ends = ends or not math.isfinite(error)
            factor = control.shrink(error, h, larger, longer, 8.0)
            larger = error
            longer = h
            h *= factor
            rejected = True
            continue
        watching = tables.active[mode, 0] > 0 or tables.fences.shape[0] > 0
        steep = tables.steep[mode, 0] > 0
        if watching or steep:
            dense_output(functions, t, state.c, x, h, STAGES, vectors, 0, run, stages, scratch.workspace)
        if watching:
            left = guard_polynomials(functions, tables, settings, state, t, h, 0, 0.0, scratch)
            ends = ends or left == math.inf
            if left == math.inf or (left > 1.0 and halvings < STEPS.halvings):
                halvings += 1
                rejected = True
                h *= 0.5
                continue
        if steep and checked.may_hide_between(functions, tables, settings, h, t, state, scratch):
            if live > 0:
                dense_output(functions, t, state.c, x, h, DENSE_STAGES, vectors, live, run, stages, scratch.workspace)
            seen = _look(functions, tables, settings, h, t, state, scratch.workspace, scratch)
            if seen < h:
                # what is wrong of the dense output may be wrong everywhere
                h = max(seen, STEPS.smallest_growth * h)
                cut = True
                continue
        if ends and control.is_stuck(functions, mode, t, state.c, x, stages[END], h, run.longest, scratch.doubt):
            return 0.0
        control.accept(run, error, 8.0, h, wanted, rejected, DOP853.largest_growth)
        if cut:
            control.begin_anew(run, h)
        break
    for i in range(stages.shape[1]):
        control.note_scale(scale, x, i, abs(stages[0, i]) * h)
    return h


locate = guard_series.locate


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
    run, vectors, stages = state.run[0], state.vectors, machine.scratch.stages
    if s != run.tried:
        attempt(machine.functions, t, state.c, state.x, s, vectors, run.live, run, stages, stages[END])
    control.take_over(stages, vectors, run.live, machine.scratch.out)
