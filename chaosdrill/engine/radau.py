"""Implicit Runge-Kutta methods for stiff modes: Radau IIA of 3, 5 or 7 stages, as the tolerance asks.

Hairer, Wanner, Solving Ordinary Differential Equations II, 2nd ed. 1996, sections IV.5 and IV.8
(doi:10.1007/978-3-642-05221-7). The stages are solved for by Newton's method on all of them, and so the derivative of a
step by the state at its start is one more solution with the same matrix: tangents are those of the step itself, but for
what decays in it (`radau_growth`), and no second derivative of the field is needed. Guards become polynomials through
the one on which the stages lie; samples and events are found on steps of their own of exactly the length asked for.
"""

import math

import numpy as np

from chaosdrill.codegen.layout import EPSILON
from chaosdrill.engine import checked, guard_series
from chaosdrill.engine import step_control as control
from chaosdrill.engine.dop853_tables import END, ROWS_A_VECTOR, VECTORS, WEIGHTS
from chaosdrill.engine.guard_series import guard_polynomials
from chaosdrill.engine.jit import inner
from chaosdrill.engine.layout import ONGOING
from chaosdrill.engine.polynomial import values
from chaosdrill.engine.radau_growth import decay_error, forgive, growth, outgrown, take_growth
from chaosdrill.engine.radau_step import (
    WIDTHS,
    Z,
    damped,
    dense_output,
    dense_tangents,
    errors_of,
    factors,
    finish,
    jacobian,
    newton,
    predict,
    set_filter,
    stage_tangents,
    tangent_error,
)
from chaosdrill.engine.radau_tables import BETWEEN, DEGREE, POWERS
from chaosdrill.engine.records import machine_at, state_of
from chaosdrill.engine.scales import fill, finest, renew
from chaosdrill.engine.stepper import offered
from chaosdrill.engine.tuning import CHECKS, GUARDS, RADAU, STEPS

METHOD = {
    "summary": "implicit Runge-Kutta of order 5, 9 or 13 for stiff modes (Radau IIA); events as for taylor",
    "cites": ("hairer1996", "farouki2012"),
    "implicit": True,
    # its steps of order 5 are as short as rounding allows there
    "tightest": 1e-13,
}

DENSE_NOISE = 4 * EPSILON * float(np.abs(POWERS).sum(axis=-1).max())
"""Rounding units by which the dense output moves the polynomial of a state."""


@inner
def _kind(tolerance):
    return (0 if tolerance > RADAU.fine else 1) if tolerance > RADAU.finest else 2


@inner
def _agrees(functions, tables, settings, s, t, state, ws, scratch):
    """Whether the polynomial through the stages obeys the equations at s, but for what is stiff, as in an error."""
    checked.dense_defect(functions, DEGREE, s, t, state, ws, scratch)
    rate, slope, allowed = scratch.before, scratch.after, CHECKS.dense_defect * max(settings.tolerance, RADAU.least)
    n, room, stages = state.x.size, scratch.implicit, scratch.stages
    if not damped(rate, slope, scratch.none, s, n, room, stages) <= allowed:
        checked.doubt_of_rates(functions, tables, s, t, state, scratch)
        if not damped(rate, slope, scratch.doubt, s, n, room, stages) <= allowed:
            return False
    if not checked.dense_agrees(functions, tables, settings, n, allowed, s, t, state, scratch):
        return False
    part = CHECKS.dense_defect * GUARDS.interpolated
    if not checked.guards_agree(functions, tables, settings, part, s, t, state, ws, scratch):
        return False
    for v in range(state.run[0].live):
        if outgrown(room, v):
            continue
        checked.tangent_defect(functions, DEGREE, v, s, t, state, ws, scratch)
        bound = allowed * control.size(scratch.jump, stages[WIDTHS])
        if not damped(rate, slope, scratch.none, s, n, room, stages) <= bound:
            checked.doubt_of_tangent(functions, s, t, state, scratch)
            if not damped(rate, slope, scratch.doubt, s, n, room, stages) <= bound:
                return False
    return True


_look = checked.looks(_agrees)


@offered
def expand(place, p, t):
    """Take a step within tolerance and turn the guards into polynomials; returns its length, NaN if there is no rate.

    What is stiff need not be followed: a step is longer than its decay where that moves the state by less than the
    tolerance. The slope at the start is then not that of the motion, and the guards' is that of the polynomial, but for
    the first step after an event, where it says which guards are about to be met.
    """
    machine = machine_at(place)
    functions, settings, tables, scratch = machine.functions, machine.settings[0], machine.tables, machine.scratch
    state = state_of(machine.states, p)
    run, x, scale, vectors = state.run[0], state.x, state.scale, state.vectors
    stages, room = scratch.stages, scratch.implicit
    mode, live = run.mode, run.live
    n = x.size
    tolerance = max(settings.tolerance, RADAU.least)
    kind = _kind(tolerance)
    order = 4.0 + 2.0 * kind
    functions.field(mode, t, state.c, x, stages[0])
    run.evaluations += 1
    jacobian(functions, mode, t, state.c, x, room.at_start, n, room.spare)
    for v in range(live):
        row = stages[VECTORS + ROWS_A_VECTOR * v]
        for i in range(n):
            row[i] = 0.0
            for k in range(n):
                row[i] += room.at_start[i, k] * vectors[v, k]
    renew(tables, mode, n, x, scale, state.span)
    known = control.weigh(x, scale, run.period, tolerance / RADAU.noise, stages)
    if not math.isfinite(control.size(stages[0], stages[WEIGHTS])):
        return math.nan
    wanted = control.wanted_length(functions, t, state, known, tolerance, stages)
    fill(stages[WEIGHTS][:n])
    h = control.up_to_goal(settings, run, wanted)
    rejected = ends = cut = False
    halvings = 0
    longer = larger = 0.0
    while h > STEPS.underflow * run.longest:
        if not newton(functions, tables, kind, t, state, h, tolerance, scratch, False):
            h *= RADAU.failed
            rejected = True
            ends = True
            continue
        finish(functions, kind, t, state, h, stages, stages[END])
        error, plain = _errors(functions, settings, kind, t, state, h, tolerance, scratch.none, room, stages)
        if error > tolerance:
            checked.coarsest(functions, tables, tolerance, h, t, state, stages[END], scratch)
            error, plain = _errors(functions, settings, kind, t, state, h, tolerance, scratch.doubt, room, stages)
        error /= tolerance
        resolved = plain <= tolerance
        watching = tables.active[mode, 0] > 0
        if error <= 1.0 and watching and run.fresh != ONGOING and not resolved:
            error = plain / tolerance
        if not error <= 1.0:
            ends = ends or not math.isfinite(error)
            factor = control.shrink(error, h, larger, longer, order)
            larger = error
            longer = h
            h *= factor
            rejected = True
            continue
        if not dense_output(kind, x, h, resolved, stages, scratch.workspace):
            return math.nan
        if watching:
            # the error at the end says nothing of what is stiff between the stages
            between = 0.0 if resolved else BETWEEN[kind] * h ** (3 + 2 * kind)
            left = guard_polynomials(functions, tables, settings, state, t, h, 3 + 2 * kind, between, scratch)
            ends = ends or left == math.inf
            if left == math.inf or (left > 1.0 and halvings < STEPS.halvings):
                functions.field(mode, t, state.c, x, stages[0])
                halvings += 1
                rejected = True
                h *= 0.5
                continue
        if tables.steep[mode, 0] > 0 and checked.may_hide_between(functions, tables, settings, h, t, state, scratch):
            dense_tangents(kind, vectors, live, h, stages, scratch.workspace)
            seen = _look(functions, tables, settings, h, t, state, scratch.workspace, scratch)
            if seen < h:
                functions.field(mode, t, state.c, x, stages[0])
                # what is wrong of the dense output may be wrong everywhere
                h = max(seen, STEPS.smallest_growth * h)
                cut = True
                continue
        if ends and control.is_stuck(functions, mode, t, state.c, x, stages[END], h, run.longest, scratch.doubt):
            return 0.0
        control.accept(run, error, order, h, wanted, rejected, RADAU.largest_growth)
        if cut:
            control.begin_anew(run, h)
        break
    for i in range(stages.shape[1]):
        moved = 0.0
        for j in range(3 + 2 * kind):
            moved = max(moved, abs(stages[Z + j, i]))
        control.note_scale(scale, x, i, moved)
    return h


@inner
def _errors(functions, settings, kind, t, state, h, tolerance, rounding, room, stages):
    """Error of a step with its tangents, if that of the states is within the tolerance, and that of `errors_of`."""
    least = finest(tolerance / RADAU.noise)
    longest = state.run[0].period
    error, plain = errors_of(kind, state.x, h, state.scale, state.span, least, longest, rounding, room, stages)
    if error <= tolerance:
        error = _tangents(functions, settings, kind, t, state, h, tolerance, error, room, stages)
    return error, plain


@inner
def _tangents(functions, settings, kind, t, state, h, tolerance, error, room, stages):
    """Tangents through the stages that are there, to their last row; returns the largest error, ``error`` of the
    states and theirs as one of states.

    Where one would make the step shorter only its direction has to be right: its growth follows from rates on the way.
    """
    live, vectors = state.run[0].live, state.vectors
    if live == 0:
        return error
    there, count = factors(functions, kind, t, state, h, room, stages, True)
    error = error if there else math.nan
    part = tolerance / max(STEPS.tangents * tolerance, RADAU.least)
    known = False
    for v in range(live):
        stage_tangents(kind, vectors[v], h, room, stages, VECTORS + ROWS_A_VECTOR * v, count)
    for v in range(live):
        forgive(room, v, False)
        e = part * tangent_error(kind, vectors[v], h, room, stages, VECTORS + ROWS_A_VECTOR * v)
        if error < e < math.inf:
            if not known:
                growth(kind, vectors, live, settings.orthonormalise, h, room, stages)
                known = True
            of_growth = part * decay_error(kind, v, vectors[v], settings.orthonormalise, h, room, stages)
            # where the step follows the tangent it is the derivative of the step
            forgive(room, v, of_growth < e and tolerance < e)
            e = min(e, of_growth)
        error = e if not e <= error else error
    return error


@inner
def _arrive(functions, tables, settings, t, state, s, scratch, out):
    """States and quadratures after a step of length s, to ``out``, or NaN; returns whether they are found.

    The step taken says where its stages may lie.
    """
    stages = scratch.stages
    kind = _kind(settings.tolerance)
    predict(kind, state.x.size, s, stages, scratch.workspace)
    found = s > 0.0 and newton(functions, tables, kind, t, state, s, settings.tolerance, scratch, True)
    if not found:
        found = newton(functions, tables, kind, t, state, s, settings.tolerance, scratch, False)
    if found:
        finish(functions, kind, t, state, s, stages, out)
    else:
        out[:] = math.nan
    return found


locate = guard_series.locate


@offered
def evaluate(place, p, t, s):
    """States and quadratures after a step of length s: where it is stiff, no polynomial through stages is as exact.

    At a place where the rates have no value, which a longer step passes, there is only that polynomial.
    """
    machine = machine_at(place)
    state, scratch = state_of(machine.states, p), machine.scratch
    if not _arrive(machine.functions, machine.tables, machine.settings[0], t, state, s, scratch, scratch.out):
        values(scratch.workspace, scratch.out.size, s, scratch.out)


@offered
def advance(place, p, t, s):
    """States and quadratures and, in place, tangents after a step of length s."""
    machine = machine_at(place)
    state = state_of(machine.states, p)
    run, scratch = state.run[0], machine.scratch
    stages = scratch.stages
    if s != run.tried:
        _arrive(machine.functions, machine.tables, machine.settings[0], t, state, s, scratch, stages[END])
        settings, room = machine.settings[0], scratch.implicit
        tolerance, kind = settings.tolerance, _kind(settings.tolerance)
        # where there is no filter the error is no number, and no tangent is forgiven
        set_filter(s, kind, state.x.size, room, stages)
        _tangents(machine.functions, settings, kind, t, state, s, tolerance, 0.0, room, stages)
    control.take_over(stages, state.vectors, run.live, scratch.out)
    take_growth(machine.functions, machine.tables, machine.settings[0], state, scratch)
