"""The exact times of events that polynomials of guards have found, for methods that can step to any time."""

import math
from collections.abc import Callable
from typing import Any

from chaosdrill.engine.dop853_tables import GUARD_DEGREE, STAGES
from chaosdrill.engine.guards import ROUNDING, unit_of
from chaosdrill.engine.jit import inner
from chaosdrill.engine.layout import TIMED
from chaosdrill.engine.records import state_of
from chaosdrill.engine.tuning import GUARDS


def exact_times(arrive: Any) -> Callable[..., None]:
    """Refines the event times of a step, in place: the second half of a method's ``locate``.

    Parameters
    ----------
    arrive : compiled function
        ``arrive(functions, tables, settings, t, state, s, scratch, out)`` puts states and quadratures after a step of
        length s into ``out``.
    """

    @inner
    def newton(functions, tables, settings, state, j, s, h, t, g, scratch):  # type: ignore[no-untyped-def]
        """Root near s of a guard along steps of that length; s itself where the two of a near double root merge.

        Where a step leads no nearer, as at a root of third order, the value is no more than its error. Where it is so
        at s, what rounding makes of the values around has no part in the root, and guards that share it stay together.
        """
        run, c, x, stages, gradient, out = state.run[0], state.c, state.x, scratch.stages, scratch.gradient, scratch.out
        n = x.size
        mode = run.mode
        rate = stages[STAGES]
        least = math.inf
        best = s
        for _ in range(8):
            arrive(functions, tables, settings, t, state, s, scratch, out)
            functions.field(mode, t + s, c, out, rate)
            run.evaluations += 1
            value = functions.guard(mode, j, t + s, c, out[:n], gradient)
            first = least == math.inf
            if first and abs(value) <= ROUNDING * functions.guard_error(mode, j, t + s, c, out[:n], scratch.none):
                return s
            if not abs(value) < least:
                return best
            least = abs(value)
            best = s
            slope = gradient[n]
            for i in range(n):
                slope += gradient[i] * rate[i]
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

    @inner
    def locate(machine, p, te, h, t):  # type: ignore[no-untyped-def]
        functions, settings, tables, scratch = machine.functions, machine.settings[0], machine.tables, machine.scratch
        state = state_of(machine.states, p)
        times, mode = scratch.times, state.run[0].mode
        first = state.x.size + settings.quadratures
        for j in range(tables.active[mode, 0]):
            if times[j] > te + GUARDS.near * h:
                times[j] = -1.0
            elif times[j] > 0.0 and tables.marks[mode, j] & TIMED == 0:
                g = scratch.workspace[first + j]
                times[j] = newton(functions, tables, settings, state, j, times[j], h, t, g, scratch)

    return locate
