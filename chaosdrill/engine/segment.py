"""One segment of an orbit: a flow of given duration in one mode, with its tangents, past whatever guards it meets.

An orbit that is looked for is cut at its events into such segments. Their ends are unknowns like their starts, so that
no event is searched for; on the way the guards are only watched, to say whether it is what the system would do.
"""

from chaosdrill.engine import fences, guards
from chaosdrill.engine import layout as at
from chaosdrill.engine.checked import ending
from chaosdrill.engine.jit import inlined
from chaosdrill.engine.records import state_outcome
from chaosdrill.engine.step import advance, expand, locate
from chaosdrill.engine.tuning import ORBITS, STEPS

BOUND = -2
"""In place of the guard that a segment crosses: a state leaves the bounds that its system was given."""


@inlined
def begin(tables, state, mode, live, last_mode, last_end, last_outcome):
    """Let a segment begin at the state, with the event that ended the one before it; ``last_end`` -1 for none."""
    run = state.run[0]
    run.mode = mode
    run.live = live
    run.fresh = at.BEGIN
    run.fired = -1
    run.held = 0
    run.surface = -1
    run.way = 0
    run.moved_by = -1
    run.residual = run.pull = 0.0
    run.next_step = 0.0
    state.sides[:] = 0
    state.scale[:] = state.span[:] = 0.0
    state.normal[:] = 0.0
    state.leeway[:] = 0.0
    for i in range(state.x.size):
        state.doubt[i] = tables.slack[i] / guards.ROUNDING
    if last_end >= 0:
        run.fresh = at.AFTER
        run.fired = tables.keys[last_mode, last_end]
        run.surface = tables.surfaces[last_mode, last_end]
        run.way = tables.active[last_mode, 1 + last_end]
        run.moved_by = last_outcome
        if tables.watched[mode, run.fired] == 1:
            state.sides[run.fired] = tables.active[last_mode, 1 + last_end]


@inlined
def follow(functions, method, settings, tables, asleep, start, duration, end, watched, state, scratch):
    """Move state and tangents through a segment that has begun.

    Returns what ended it (DONE, or an outcome), the first guard that it crosses before its end, -1 for none, and when;
    ``BOUND`` where a state leaves its bounds before any is crossed.
    ``end`` is the guard that is to be met at the end. A duration below zero leads backwards, within one step; nothing
    is watched then, as in the tables ``asleep``.
    """
    run = state.run[0]
    mode = run.mode
    run.time = 0.0
    run.longest = 0.0
    run.strength = 0.0
    run.tried = 0.0
    crossed = -1
    when = 0.0
    done = 0.0
    still = 0
    steps = 0
    sleeping = at.Method(method.stepper, method.search, method.asleep, method.asleep, method.p)
    if duration == 0.0:
        return at.DONE, crossed, when
    while True:
        watching = watched and crossed == -1 and duration > 0.0
        rest = duration - done
        # explicit time is counted from the start of the segment
        t = run.origin = start + done
        here, watched_now = (method, tables) if watching else (sleeping, asleep)
        h = expand(functions, here, watched_now, settings, t, state, scratch)
        te = -1.0
        j = -1
        ties = 0
        if settings.stepping != at.FIXED:
            te, j, ties, h = here.search(here.place, here.p, h, t)
        te, j, ties, h = locate(functions, here, watched_now, settings, te, j, ties, h, t, state, scratch)
        if te == -2.0:
            crossed = j
            when = done
            continue
        steps += 1
        if not h > STEPS.smallest * run.longest or (steps > ORBITS.steps and settings.stepping != at.FIXED):
            return ending(functions, tables, settings, h, t, state, scratch)[0], crossed, when
        run.fresh = at.ONGOING
        if rest < -h:
            return at.INVALID_START, crossed, when
        last = rest <= h
        s = rest if last else h
        marked = False
        if te >= 0.0 and te < s:
            if tables.marks[mode, j] & at.MARKS:
                s = te
                last = False
                marked = True
                still = still + 1 if te == 0.0 else 0
                if still > settings.max_stalls:
                    return at.STALLED, crossed, when
            elif j != end or te < rest - ORBITS.end * run.period:
                crossed = j
                when = done + te
        # what the motion does beyond a guard that it crosses does not count
        until = te if crossed >= 0 else s
        if tables.fences.shape[0] > 0 and watching and until > 0.0:
            te, fence = fences.up_to_escape(here, tables, settings, t, until, state, scratch)
            if fence >= 0:
                crossed = BOUND
                when = done + te
        advance(method, settings, t, state, s, scratch)
        run.longest = max(run.longest, abs(s))
        outcome = state_outcome(state.x, tables.bounds)
        if outcome != at.DONE or last:
            return outcome, crossed, when
        if watching:
            guards.pass_sides(functions, tables, state, scratch.backs, s, t + s, scratch.gradient)
        if marked:
            guards.cross(tables, state, j)
        done += s
