"""Which event comes first in a step.

A guard is armed while the state is on the side from which it can be crossed. At the start of a phase (after an event,
or at the beginning) a guard may stand at zero; then the first derivative that does not vanish says on which side the
state goes on, and roots are searched for in the polynomial without its zero. No dead time is involved.
"""

from numba import uint64

from chaosdrill.engine.jit import inlined
from chaosdrill.engine.layout import ARMED, BEGIN, FIRE, INVALID, MARKS, ONGOING, PASSED, SAME_MODE
from chaosdrill.engine.polynomial import keeps_side, size
from chaosdrill.engine.roots import first_crossing, recrossing

ZERO = 1e-13
"""A coefficient counts as zero below this part of the guard's variation over the step."""

TIE = 1e-12
"""Events closer than this part of the step happen together."""


@inlined
def vanishing_order(ws, i, n, h, floor):
    """Number of leading coefficients that are zero to round-off; n + 1 if all are, or if they are no numbers."""
    g = ws[i]
    limit = ZERO * size(ws, uint64(i), h, 0) + floor
    if limit != limit:
        return n + 1
    order = 0
    power = 1.0
    while order <= n and abs(g[order]) * power <= limit:
        order += 1
        power *= h
    return order


@inlined
def stand(side, direction, order, fresh, marks, just_fired, was_armed):
    """How a guard stands at the start of a phase.

    ``side`` is the side on which the state is or to which it moves; ``order`` > 0 says that the guard is zero. A guard
    that is zero or beyond and still to cross fires at once, with these exceptions: a mark does so only if it was armed
    before the event, and the guard that has just fired does so only if the state leaves it with no speed (a contact
    that would have to be held), not if it goes through.
    """
    if direction == 0 or side != direction:
        return ARMED
    if fresh == BEGIN:
        if order == 0 and not marks:
            return INVALID
        return PASSED if marks else FIRE
    if fresh == SAME_MODE:
        if just_fired:
            return FIRE if order > 1 and not marks else PASSED
        return FIRE if was_armed else PASSED
    return PASSED if marks else FIRE


@inlined
def earliest(times, count, h):
    """Of the times of the guards (-1: none) the first; of guards that cross together the one that comes first."""
    best = -1.0
    found = -1
    ties = 0
    for j in range(count):
        if times[j] >= 0.0 and (found < 0 or times[j] < best):
            best = times[j]
            found = j
    if found >= 0:
        for j in range(count - 1, -1, -1):
            if times[j] >= 0.0 and times[j] <= best + TIE * h and j != found:
                ties += 1
                if j < found:
                    best = times[j]
                    found = j
    return best, found, ties


@inlined
def first_event(ws, row, directions, count, marks, n, h, floor, fresh, fired, sides, armed, polynomials):
    """First event of the step: (time in it or -1, guard, number of other guards that cross together with it).

    ``ws[row + j]`` holds the polynomial of guard j; ``sides`` and ``armed`` are carried from step to step.
    """
    a, shifted, stack, ends, times = polynomials
    for j in range(count):
        g = ws[row + j]
        direction = directions[j]
        order = 0
        fire = False
        if fresh != ONGOING:
            order = vanishing_order(ws, row + j, n, h, floor)
            if order > n:
                armed[j] = 0
                times[j] = -1.0
                continue
            sides[j] = 1 if g[order] > 0.0 else -1
            how = stand(sides[j], direction, order, fresh, marks[j] & MARKS != 0, j == fired, armed[j] == 1)
            if how == INVALID:
                return -2.0, j, 0
            armed[j] = 0 if how == PASSED else 1
            fire = how == FIRE
        elif armed[j] == 1:
            fire = g[0] * sides[j] <= 0.0
        if fire:
            times[j] = 0.0
        elif armed[j] == 1 and order == 0 and keeps_side(ws, uint64(row + j), h, -float(sides[j])):
            times[j] = -1.0
        elif armed[j] == 1:
            times[j] = first_crossing(g, order, n - order, h, sides[j] < 0, a, stack, ends)
        else:
            times[j] = recrossing(g, order, n - order, h, direction > 0, a, shifted, stack, ends)
    return earliest(times, count, h)


@inlined
def update_sides(ws, row, directions, count, n, s, sides, armed):
    """Re-arm the passed guards whose polynomial is back on the side before at s."""
    for j in range(count):
        if armed[j] == 0:
            value = ws[row + j, n]
            for k in range(n):
                value = value * s + ws[row + j, uint64(n - 1 - k)]
            side = 1 if value > 0.0 else -1
            if value != 0.0 and side != directions[j]:
                armed[j] = 1
                sides[j] = side
