"""One arc of an orbit: a flow of given duration in one mode, with its tangents, past whatever guards it meets.

An orbit that is looked for is cut at its events into such arcs. Their ends are unknowns like their starts, so that no
event is searched for; on the way the guards are only watched, to say whether the arc is what the system would do.
"""

from chaosdrill.engine import guards
from chaosdrill.engine.jit import inlined
from chaosdrill.engine.layout import (
    DONE,
    FIRED,
    FRESH,
    INVALID_START,
    LONGEST,
    MARKS,
    METHOD,
    MODE,
    NONFINITE,
    ONGOING,
    ORDER,
    PERIOD,
    QUADRATURES,
    RK4,
    SAME_MODE,
    STALLED,
    STEP_UNDERFLOW,
    WORKSPACE,
)
from chaosdrill.engine.limits import SMALLEST_STEP, STALL_LIMIT, state_outcome
from chaosdrill.engine.step import advance, prepare

END = 1e-8
"""Part of the period before the end of an arc in which its guard is taken to be met at the end."""


MOST_STEPS = 200_000
"""Steps of adaptive methods along one arc, at most: a guess that is far off may be stiff without end."""


@inlined
def follow(
    functions,
    stepper,
    settings_i,
    settings_f,
    watch,
    asleep,
    marks,
    start,
    duration,
    end,
    watched,
    c,
    bounds,
    x,
    sums,
    vectors,
    carried,
    carried_f,
    sides,
    armed,
    scratch,
):
    """Move state and tangents through an arc, the mode and what came before being in ``carried``.

    Returns what ended it (DONE, or an outcome), the first guard that it crosses before its end, -1 for none, and when.
    ``end`` is the guard that is to be met at the end. A duration below zero leads backwards, within one step; nothing
    is watched then.
    """
    mode = carried[MODE]
    first_guard = x.size + settings_i[QUADRATURES]
    carried_f[:] = 0.0
    crossed = -1
    when = 0.0
    done = 0.0
    still = 0
    steps = 0
    if duration == 0.0:
        return DONE, crossed, when
    while True:
        watching = watched and crossed < 0 and duration > 0.0
        rest = duration - done
        h, te, j, _ = prepare(
            functions,
            stepper,
            settings_i,
            settings_f,
            watch if watching else asleep,
            marks,
            start + done,
            start + done,
            c,
            x,
            vectors,
            carried,
            carried_f,
            sides,
            armed,
            scratch,
        )
        if te == -2.0:
            crossed = j
            when = done
            continue
        steps += 1
        if not h > SMALLEST_STEP * carried_f[LONGEST] or (steps > MOST_STEPS and settings_i[METHOD] != RK4):
            return (STEP_UNDERFLOW if h == h else NONFINITE), crossed, when
        carried[FRESH] = ONGOING
        if rest < -h:
            return INVALID_START, crossed, when
        last = rest <= h
        s = rest if last else h
        if te >= 0.0 and te < s:
            if marks[mode, j] & MARKS:
                s = te
                last = False
                carried[FRESH] = SAME_MODE
                carried[FIRED] = j
                still = still + 1 if te == 0.0 else 0
                if still > STALL_LIMIT:
                    return STALLED, crossed, when
            elif j != end or te < rest - END * settings_f[PERIOD]:
                crossed = j
                when = done + te
        advance(functions, stepper, settings_i, start + done, c, x, s, sums, vectors, carried, carried_f, scratch)
        carried_f[LONGEST] = max(carried_f[LONGEST], abs(s))
        outcome = state_outcome(x, bounds)
        if outcome != DONE or last:
            return outcome, crossed, when
        if watching and settings_i[METHOD] != RK4:
            guards.update_sides(
                scratch[WORKSPACE], first_guard, watch[mode, 1:], watch[mode, 0], settings_i[ORDER], s, sides, armed
            )
        done += s
