"""Guards as polynomials along a step whose states are polynomials: exact if linear, else interpolated.

Value and slope at the start come from the guard itself, so that what vanishes there vanishes to round-off. Times that
these polynomials tell are made exact by methods that can step to any time.
"""

import math

from chaosdrill.codegen.kinds import uint64
from chaosdrill.codegen.layout import ROUNDING
from chaosdrill.engine.dop853_tables import END, GUARD_DEGREE, NODES, PLACE, STAGES, TO_CHEBYSHEV, TO_POWERS
from chaosdrill.engine.guard_errors import INTERPOLATION_NOISE, VALUE_NOISE, near, truncation
from chaosdrill.engine.guard_roots import unit_of
from chaosdrill.engine.jit import inlined, inner, series
from chaosdrill.engine.layout import AFFINE, AFTER, STILL, TIMED
from chaosdrill.engine.polynomial import keeps_side
from chaosdrill.engine.radau_tables import DEGREE
from chaosdrill.engine.records import machine_at, state_of
from chaosdrill.engine.stepper import offered
from chaosdrill.engine.tuning import GUARDS


@series
def guard_polynomials(functions, tables, settings, state, t, h, degree, between, scratch):
    """Fill the rows of the guards in the workspace from those of the states; returns what the interpolation leaves out.

    That is in parts of what it may leave out, the tolerance beside the guard's own rounding error; infinite where a
    polynomial is not finite: the step has touched what the guard or the field cannot bear. Polynomials of states are
    themselves off by ``between`` times their coefficients of a degree, which a guard that stays clear of zero may be.
    """
    run, c, x, ws = state.run[0], state.c, state.x, scratch.workspace
    mode = run.mode
    rate, place, gradient = scratch.stages[0], scratch.stages[PLACE], scratch.gradient
    marks = tables.marks[mode]
    n = x.size
    first = n + settings.quadratures
    left = 0.0
    for j in range(tables.active[mode, 0]):
        g = ws[first + j]
        if j > 0 and tables.surfaces[mode, j] == tables.surfaces[mode, j - 1]:
            for k in range(GUARD_DEGREE + 1):
                g[k] = ws[first + j - 1, k]
            continue
        g[0] = functions.guard(mode, j, t, c, x, gradient)
        slope = gradient[n]
        for i in range(n):
            slope += gradient[i] * rate[i]
        g[1] = slope
        for k in range(2, GUARD_DEGREE + 1):
            g[k] = 0.0
        if marks[j] & STILL:
            continue
        if marks[j] & AFFINE:
            for k in range(2, DEGREE + 1):
                for i in range(n):
                    g[k] += gradient[i] * ws[i, k]
        else:
            rest, largest = _interpolate(functions, mode, j, t, c, h, place, gradient, ws, g)
            allowed = truncation(settings, marks[j]) * largest
            told = max(abs(g[0]), GUARDS.flat * h * abs(slope))
            hides = 0.0 < told < GUARDS.hidden * allowed and h > GUARDS.nearest * run.longest and not marks[j] & TIMED
            if rest > allowed or hides:
                own = functions.guard_error(mode, j, t, c, x, scratch.none)
                noise = max(own, functions.guard_error(mode, j, t + h, c, scratch.stages[END][:n], scratch.none))
                left = max(left, rest / (allowed + INTERPOLATION_NOISE * noise))
                off = rest + VALUE_NOISE * ROUNDING * noise
                if hides and 2.0 * VALUE_NOISE * ROUNDING * own < told < GUARDS.seen * off:
                    # the far end of the step hides what the guard does near its start
                    left = max(left, 2.0)
            if _rebounds(run, tables, mode, j):
                # of a rebound far shorter than the step these alone tell
                g[2] = 0.5 * run.pull
                g[3] = run.jerk / 6.0 if run.jerk != 0.0 else g[3]
        off = allowed = 0.0
        for i in range(n):
            off += between * abs(gradient[i] * ws[i, degree])
            allowed += settings.tolerance * abs(gradient[i]) * state.scale[i]
        if off > allowed:
            here, side = g[0], math.copysign(1.0, g[0])
            g[0] -= side * off
            if not (side * g[0] > 0.0 and keeps_side(ws, uint64(first + j), h, -side)):
                left = max(left, 2.0)
            g[0] = here
        total = 0.0
        for k in range(GUARD_DEGREE + 1):
            total += g[k]
        if not math.isfinite(total):
            return math.inf
    return left


@inlined
def _rebounds(run, tables, mode, j):
    """Whether the step begins with a rebound from the surface of guard j of which the derivatives are known."""
    own = run.fired == tables.keys[mode, j] or run.surface == tables.surfaces[mode, j]
    return run.pull != 0.0 and run.fresh == AFTER and own


@series
def _interpolate(functions, mode, j, t, c, h, place, gradient, ws, g):
    """Coefficients from order 2 on, through the nodes; returns the sizes of the last two and of the guard."""
    n = gradient.size - 1
    count = GUARD_DEGREE - 1
    largest = abs(g[0])
    for a in range(count):
        u = NODES[a]
        s = u * h
        for i in range(n):
            y = ws[i, DEGREE]
            for k in range(DEGREE - 1, -1, -1):
                y = y * s + ws[i, k]
            place[i] = y
        value = functions.guard(mode, j, t + s, c, place[:n], gradient)
        largest = max(largest, abs(value))
        value = (value - g[0] - g[1] * s) / (u * u)
        for k in range(count):
            g[k + 2] += TO_CHEBYSHEV[k, a] * value
    left = abs(g[count]) + abs(g[count + 1])
    for k in range(count):
        coefficient = g[k + 2]
        g[k + 2] = 0.0
        for m in range(k + 1):
            g[m + 2] += coefficient * TO_POWERS[k, m]
    power = 1.0
    for k in range(2, GUARD_DEGREE + 1):
        power /= h
        g[k] *= power / h
    return left, largest


@inner
def _root(machine, place, p, j, s, h, t, g):
    """Root near s of a guard along steps of that length; s itself where the two of a near double root merge.

    Where a step leads no nearer, as at a root of third order, the value is no more than its error. Where it is so
    at s, what rounding makes of the values around has no part in the root, and guards that share it stay together;
    but for rebounds, of which each hands its error on, and which the polynomial tells better if they are short.
    """
    functions, tables, scratch, state = machine.functions, machine.tables, machine.scratch, state_of(machine.states, p)
    run, c, x, stages, gradient, out = state.run[0], state.c, state.x, scratch.stages, scratch.gradient, scratch.out
    n = x.size
    mode = run.mode
    rate = stages[STAGES]
    least = math.inf
    best = start = s
    key = tables.keys[mode, j]
    way = tables.active[mode, 1 + j] if tables.active[mode, 1 + j] != 0 else -state.sides[key]
    trusted = s <= GUARDS.short * h or not _rebounds(run, tables, mode, j)
    for _ in range(8):
        machine.stepper.evaluate(place, p, t, s)
        functions.field(mode, t + s, c, out, rate)
        run.evaluations += 1
        value = functions.guard(mode, j, t + s, c, out[:n], gradient)
        if trusted and abs(value) <= ROUNDING * functions.guard_error(mode, j, t + s, c, out[:n], scratch.none):
            return s
        trusted = False
        if not abs(value) < least:
            return best
        least = abs(value)
        best = s
        slope = gradient[n]
        for i in range(n):
            slope += gradient[i] * rate[i]
        if slope * way < 0.0:
            return start
        bend = 0.0
        for k in range(GUARD_DEGREE, 1, -1):
            bend = bend * s + k * (k - 1) * g[k]
        unit = unit_of(abs(slope))
        value, slope, bend = value * unit, slope * unit, bend * unit
        square = slope * slope - 2.0 * bend * value
        if slope == 0.0 or not square >= 0.0:
            return s
        move = -2.0 * value / (slope + math.copysign(math.sqrt(square), slope))
        if not abs(move) <= 0.01 * h or s + move <= 0.0:
            return s
        s += move
        if abs(bend) * move * move <= 1e-15 * h * abs(slope):
            return s
    return s


@offered
def locate(place, p, te, h, t):
    """Make the times of the events exact by Newton steps on the guards, for methods that step to any time."""
    machine = machine_at(place)
    tables, state, times = machine.tables, state_of(machine.states, p), machine.scratch.times
    mode = state.run[0].mode
    settings = machine.settings[0]
    first = state.x.size + settings.quadratures
    for j in range(tables.active[mode, 0]):
        if times[j] > te + near(settings, h):
            times[j] = -1.0
        elif times[j] > 0.0 and tables.marks[mode, j] & TIMED == 0:
            times[j] = _root(machine, place, p, j, times[j], h, t, machine.scratch.workspace[first + j])
    return te, -1, 0
