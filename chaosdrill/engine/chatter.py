"""Rebounds that follow each other ever sooner: when all of them will be over, and whether they are negligible.

A rebound leaves its surface with the speed w and the acceleration a back onto it, of rate j, and is there again after
the time 2 w/a (1 - 2 w j/(3 a^2)), with the speed w + 2 w^2 j/(3 a^2). The rebounds to come are taken one after the
other by these times, each with its own reset, through whatever modes they lead, until they are back at the same guard;
the times of these cycles become a geometric series, whatever the law of the resets, or are not completed.
"""

import math

from chaosdrill.codegen.layout import EPSILON
from chaosdrill.codegen.signatures import event_places
from chaosdrill.engine import guard_errors, guards
from chaosdrill.engine import layout as at
from chaosdrill.engine.jit import inlined, inner, rare
from chaosdrill.engine.passages import normal_speed
from chaosdrill.engine.tuning import REBOUNDS, STEPS


@inlined
def interpolated(tables, settings, mode, j):
    """Whether the polynomial of guard j goes through points of it, and leaves out more than rounding."""
    return settings.stepping == at.ADAPTIVE and tables.marks[mode, j] & at.AFFINE == 0


@inlined
def _is_small(settings, speed, hardest):
    """Whether a motion of this speed is negligible beside the hardest rebound."""
    return speed * speed <= settings.tolerance * hardest * hardest


@inner
def _is_low(functions, tables, settings, j, t, state, scratch):
    """Whether a rebound is too low or too short to be seen above rounding, and so as negligible as it may become."""
    run, event = state.run[0], scratch.event
    place = event_places(state.x.size)
    force = abs(event[place.pull])
    speed = abs(event[place.speed])
    if settings.stepping == at.FIXED and 2.0 * speed <= STEPS.probe * run.fixed_step * force:
        return True
    noise = (
        2.0 * guard_errors.INTERPOLATION_NOISE
        if interpolated(tables, settings, run.mode, j)
        else REBOUNDS.low * guards.ROUNDING
    )
    error = functions.guard_error(run.mode, j, t, state.c, state.x, scratch.none)
    return speed * speed <= 2.0 * noise * error * force


@inner
def _noise(event, n):
    """What rounding makes of the speed at which a guard is met, as a part of it."""
    place = event_places(n)
    size = abs(event[place.gradient + n])
    for i in range(n):
        size += abs(event[place.gradient + i] * event[place.before + i])
    speed = abs(normal_speed(event, n))
    return EPSILON * size / speed if speed > 0.0 else 0.0


@inner
def _steepness(event, n):
    """Size of the gradient of the guard that an event has met."""
    place = event_places(n)
    size = 0.0
    for i in range(n):
        size += abs(event[place.gradient + i])
    return size


@inlined
def may_be_over(functions, tables, settings, j, hardest, t, state, scratch):
    """Whether the next rebound alone is negligible, so that those to come are worth a look.

    Where the last look has found more than that to come, there is none before they can be.
    """
    run = state.run[0]
    speed = abs(scratch.event[event_places(state.x.size).speed])
    if not (_is_small(settings, 2.0 * speed, hardest) or _is_low(functions, tables, settings, j, t, state, scratch)):
        return False
    return run.waiting != tables.keys[run.mode, j] or t >= run.wait_until or speed <= run.wait_above


@inner
def _fly(functions, mode, begin, end, flight, state, scratch):
    """Move the image of an event through a flight of this length, by its rates at both ends, into ``out``."""
    y, ahead, rates, later = scratch.out, scratch.jump, scratch.before, scratch.after
    n = state.x.size
    image = event_places(n).image
    for i in range(n):
        y[i] = scratch.event[image + i]
    functions.field(mode, begin, state.c, y[:n], rates)
    for i in range(n):
        ahead[i] = y[i] + flight * rates[i]
    functions.field(mode, end, state.c, ahead, later)
    for i in range(n):
        y[i] += 0.5 * flight * (rates[i] + later[i])


@inner
def _trend(length, length_before, ratio, ratio_before, span, noise):
    """What a cycle is shorter by than the one before, as a part of it; how that changes a cycle; how much one over it
    grows a cycle; and whether lengths with these go to zero."""
    if abs(ratio - ratio_before) > noise:
        mean, turn = ratio, (ratio - ratio_before) / span
    else:
        mean, turn = (length / length_before) ** (1.0 / span) if length_before > 0.0 else ratio, 0.0
    short = 1.0 - mean
    shorter = short + turn * span
    settling = turn / (short * shorter)
    return short, turn, settling, short > 0.0 and shorter > 0.0 and abs(settling) < REBOUNDS.fastest


@inner
def _exactness(left, moved, short, turn, span, noise):
    """Cycles that tell the end as one does, and what it may be off by: as it ``moved``, and by rounding."""
    cycles = max(1.0, 1.0 / (short * span))
    rounding = noise * left / short * (1.0 / span if turn == 0.0 else 1.0 + 1.0 / (short * span))
    away = REBOUNDS.sure * cycles * max(moved - rounding, 0.0)
    return cycles, away, rounding * (REBOUNDS.sure * cycles)


@rare
def time_left(functions, tables, settings, j, transition, hardest, t, state, scratch):
    """Time to the last of the rebounds that a transition begins, and its error; (-1, 0) if they do not count as over.

    What they move has to be below the tolerance beside the hardest before them, and the error of their time below the
    tolerance of that of the hardest; what nobody could tell from none may move as much as that.

    Where cycles last T, and the next one is r times as long, T r/(1 - r) is left; where 1/(1 - r) grows by q a cycle,
    1/(1 - q) times that. So q is constant for lengths that fall as a power of their number, however far apart it is
    looked for. By how much such an end moves from one cycle to the next says how exact it is.

    Guard j has been met; the event of its outcome ``transition`` stands in ``scratch.event``, and is lost. ``hardest``
    is the normal speed of the hardest rebound so far.
    """
    run = state.run[0]
    n = state.x.size
    c, event, y = state.c, scratch.event, scratch.out
    place = event_places(n)
    low = _is_low(functions, tables, settings, j, t, state, scratch)
    met = j
    force = abs(event[place.pull])
    most = math.sqrt(settings.tolerance) * hardest / force
    allowed = settings.tolerance * hardest / force
    fine = REBOUNDS.fine * allowed
    if low:
        allowed = max(allowed, 2.0 * abs(event[place.speed]) / force)
    total = error = drift = 0.0
    mode = begin_mode = run.mode
    begin_guard, cycle = j, 0.0
    hits, wait = 0, REBOUNDS.first_cycle
    known, check, checks, looked = 0, 2, 0, 0
    length = seen = ratio = end = moved = unsure = walk = 0.0
    best = -1.0
    speed, k = event[place.speed], transition
    for _ in range(REBOUNDS.most):
        speed, pull, jerk = event[place.speed], event[place.pull], event[place.jerk]
        target = tables.transitions[k, at.TO_MODE]
        # what does not leave is pressed on from the side to which it would be led
        below = speed < 0.0 or (speed == 0.0 and pull > 0.0)
        g = tables.returns[k, 1 if below else 0]
        back, change = (pull, jerk) if below else (-pull, -jerk)
        bend = 2.0 * abs(speed) * change / (back * back)
        if g < 0 or not (back > 0.0 and abs(bend) < 1.0):
            break
        if speed == 0.0:
            if low or total <= most:
                return total, error
            break
        flight = 2.0 * abs(speed) / back * (1.0 - bend / 3.0)
        begin = total
        total += flight
        cycle += flight
        _fly(functions, target, t + begin, t + total, flight, state, scratch)
        if total > 2.0 * most and not low:
            break
        steep, surface = _steepness(event, n), tables.surfaces[mode, j]
        k = functions.event_map(target, g, t + total, c, y[:n], 0, scratch.none, settings.tolerance, event)
        mode, j = target, g
        if k < 0 or tables.transitions[k, at.MARKS_ONLY] == 1:
            break
        noise = 4.0 * _noise(event, n)
        if not noise < 1.0:
            break
        walk += (noise * flight) ** 2
        # what the series of one rebound leaves out shows in the speed with which it comes back
        expected = abs(speed) * (1.0 + bend / 3.0)
        if tables.surfaces[mode, j] != surface:
            # the same surface by another guard, in which speeds are others
            expected *= _steepness(event, n) / steep
        drift += max(abs(abs(normal_speed(event, n)) / expected - 1.0) - noise, 0.0)
        error += drift * flight
        hits += 1
        if target != begin_mode or g != begin_guard:
            if hits == wait:
                begin_mode, begin_guard, cycle = target, g, 0.0
                hits, wait = 0, 2 * wait
                known, check, checks, looked = 0, 2, 0, 0
            continue
        before, length = length, cycle
        cycle = 0.0
        hits = 0
        known += 1
        if known < check:
            continue
        span, check, looked = known - looked, max(known + 1, int(REBOUNDS.further * known)), known
        ratio_before, ratio = ratio, length / before
        length_before, seen = seen, length
        short, turn, settling, falls = _trend(length, length_before, ratio, ratio_before, span, noise)
        checks = checks + 1 if falls else 0
        if checks < 2:
            continue
        following = short / (1.0 + settling * short)
        left = length * (1.0 - following) / (following * (1.0 - settling))
        end_before, end = end, total + left
        moved_before, moved = moved, abs(end - end_before)
        if checks < 4:
            continue
        cycles, away, rounding = _exactness(left, max(moved, moved_before), short, turn, span, noise)
        known_part = error + drift * left
        if not low and end - known_part - away - rounding > most:
            break
        if known_part + away > allowed or not (rounding <= allowed or cycles == 1.0) or not (low or end <= most):
            continue
        told = known_part + away + rounding + math.sqrt(walk) / short
        if best < 0.0 or told < unsure:
            best, unsure = end, told
        if away <= max(fine, known_part) and (cycles == 1.0 or rounding <= fine):
            break
    if best >= 0.0:
        return best, unsure
    run.waiting = tables.keys[run.mode, met]
    run.wait_until = t + max(total - most, 0.5 * total)
    run.wait_above = abs(speed)
    return -1.0, 0.0
