"""How long the steps of Runge-Kutta methods are: sizes of states, errors, lengths to try.

Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, 2nd ed. 1993, section II.4
(doi:10.1007/978-3-540-78862-1). Rows of ``stages``: see ``dop853_tables``.
"""

import math

from chaosdrill.codegen.layout import EPSILON
from chaosdrill.engine.dop853_tables import END, PLACE, ROWS_A_VECTOR, VECTORS, WEIGHTS
from chaosdrill.engine.jit import inlined, inner, rare
from chaosdrill.engine.layout import ONGOING
from chaosdrill.engine.scales import brought, finest, followed, has_none
from chaosdrill.engine.tuning import SIZES, STEPS


@rare
def is_stuck(functions, mode, t, c, x, end, h, longest, rate):
    """Whether a step that could not be longer, since there is no motion so far, is short and moves no state.

    One rounding error before a branch point steps of a billionth would follow each other to the end of the run. So they
    would where one of the states does not move any more though it has a rate, whatever the others do.
    """
    if not h <= STEPS.blocked * longest:
        return False
    functions.field(mode, t, c, x, rate)
    moved = held = 0
    for i in range(x.size):
        moved += 1 if end[i] != x[i] else 0
        held += 1 if end[i] == x[i] and rate[i] != 0.0 else 0
    return moved == 0 or (h <= STEPS.held_up * longest and held > 0)


@inner
def size(x, weights):
    """Length of a vector in the scales of the states."""
    total = 0.0
    for i in range(x.size):
        total += abs(x[i]) * weights[i]
    if not 0.0 < total < math.inf:
        return total
    s = 0.0
    for i in range(x.size):
        part = x[i] * weights[i] / total
        s += part * part
    return total * math.sqrt(s)


@inner
def weigh(x, scale, longest, tolerance, stages):
    """Let the sizes fade, and note one over them, 0 where there is none; returns whether there is any.

    A length is looked for that no state could make short by leaving a size that has nearly decayed.
    """
    least = finest(tolerance)
    known = False
    for i in range(stages.shape[1]):
        value = x[i] if i < x.size else 0.0
        rate = stages[0, i]
        scale[i] = brought(scale[i], value, least)
        stages[WEIGHTS, i] = 0.0
        if not is_new(scale[i], value, rate, least, longest):
            stages[WEIGHTS, i] = 1.0 / max(scale[i], abs(rate) * longest / STEPS.quick)
            known = known or i < x.size
    return known


@inlined
def is_new(size, value, rate, least, longest):
    """Whether a size is but that of rounding, so that only steps to come can tell one."""
    return size <= least * abs(value) or has_none(size, rate, longest)


@inlined
def begun(scale, i, slowest, most):
    """Size of what begins, by what the slowest and the fastest stage of a step move: one alone may have met a pulse.

    Where that is too little, or too much, to tell one it has none still, and no error counts.
    """
    moved = max(slowest, EPSILON * most)
    if not SIZES.begun < moved < math.inf:
        scale[i] = 0.0
        return math.inf
    scale[i] = max(scale[i], moved)
    return scale[i]


@inner
def shrink(error, h, larger, longer, full):
    """Part of a rejected step to try next, by the order that two rejected lengths show: near a kink it is not full."""
    if not math.isfinite(error):
        return STEPS.smallest_growth
    order = full
    floor = STEPS.smallest_growth
    if error < larger:
        order = min(max(math.log(larger / error) / math.log(longer / h), 1.0), full)
        floor = STEPS.smallest_growth**3
    return max(STEPS.safety * error ** (-1.0 / order), floor)


@inner
def first_length(functions, t, state, tolerance, longest, stages):
    """Length of a step to begin with, from the first two derivatives as in section II.4, in any unit of time."""
    run, c, x, vectors = state.run[0], state.c, state.x, state.vectors
    n = x.size
    mode, live = run.mode, run.live
    weights = stages[WEIGHTS]
    speed = size(stages[0][:n], weights)
    for v in range(live):
        length = size(vectors[v], weights)
        if length > 0.0:
            own = size(stages[VECTORS + ROWS_A_VECTOR * v][:n], weights) / length
            # beside a state that has only begun, with next to no size, a tangent may be as fast as one likes
            speed = max(speed, min(own, STEPS.quick / longest))
    trial = min(0.01 / speed, longest) if speed > 0.0 else longest
    place = stages[PLACE]
    for i in range(n):
        place[i] = x[i] + trial * stages[0, i]
    functions.field(mode, t + trial, c, place, stages[1])
    run.evaluations += 1
    change = 0.0
    for i in range(n):
        change = max(change, abs(stages[1, i] - stages[0, i]) * weights[i])
    for v in range(live):
        length = size(vectors[v], weights)
        row = VECTORS + ROWS_A_VECTOR * v
        direction = stages[row + PLACE]
        for i in range(n):
            direction[i] = vectors[v, i] + trial * stages[row, i]
        functions.variation(mode, t + trial, c, place, direction, stages[row + 1])
        for i in range(n):
            if length > 0.0:
                change = max(change, abs(stages[row + 1, i] - stages[row, i]) * weights[i] / length)
    if not speed > 0.0:
        return longest
    return min((0.01 * tolerance / max(1.0, change / (trial * speed * speed))) ** 0.125 / speed, longest)


@inner
def calm_length(functions, t, state, h, stages):
    """The length h, or a shorter one in which no state without a size changes its rate by a part of it.

    What such a state moves in the stages of a step that is far too long would be no size of its motion. A rate that is
    zero or round-off at the start changes at any length by more than itself, and counts for nothing.
    """
    run, c, x = state.run[0], state.c, state.x
    n = x.size
    begins = False
    for i in range(n):
        begins = begins or (stages[WEIGHTS, i] == 0.0 and stages[0, i] != 0.0)
        stages[2, i] = 0.0
    if not begins:
        return h
    place = stages[PLACE]
    s = h * STEPS.closer ** (STEPS.probes - 1)
    before = s
    for _ in range(STEPS.probes):
        for i in range(n):
            place[i] = x[i] + s * stages[0, i]
        functions.field(run.mode, t + s, c, place, stages[1])
        run.evaluations += 1
        for i in range(n):
            calm = abs(stages[1, i] - stages[0, i]) <= STEPS.calm * abs(stages[0, i])
            if stages[2, i] == 1.0 and not calm:
                return before
            moves = stages[WEIGHTS, i] == 0.0 and stages[0, i] != 0.0
            stages[2, i] = 1.0 if calm and moves else 0.0
        before = s
        s /= STEPS.closer
    return h


@inner
def wanted_length(functions, t, state, known, tolerance, stages):
    """Length to try first; ``known`` says whether the size of any state is."""
    run = state.run[0]
    if run.next_step > 0.0:
        return run.next_step
    h = first_length(functions, t, state, tolerance, run.period, stages) if known else STEPS.beginning * run.period
    return calm_length(functions, t, state, h, stages)


@inlined
def up_to_goal(settings, run, h):
    """A length, but for the last step to where the run ends: that ends there."""
    rest = run.period - run.time
    return min(h, rest) if run.strobes + 1 >= settings.target and rest > STEPS.goal * run.period else h


@inlined
def accept(run, error, order, h, wanted, rejected, largest_growth):
    """Note a step that is taken, and the length of the next: by its error and that of the step before (Gustafsson)."""
    strength = max(error, 1e-9) ** (1.0 / order) / h
    before = run.strength if run.fresh == ONGOING else 0.0
    following = min(STEPS.safety / strength, largest_growth * h)
    if 0.0 < before < strength:
        following *= max(before / strength, STEPS.smallest_growth)
    if rejected:
        following = min(following, h)
    elif h < wanted:
        following = max(following, wanted)
    run.strength = strength
    run.next_step = min(following, run.period)
    run.tried = h


@inlined
def begin_anew(run, h):
    """Note a step that ends before something it did not see: its error says nothing of the next one."""
    run.strength = 0.0
    run.next_step = h


@inlined
def note_scale(scale, x, i, moved):
    """Let the size of state or quadrature i follow a step that moves it so far."""
    scale[i] = followed(scale[i], x[i], moved, 1.0) if i < x.size else max(scale[i], moved)


@inlined
def take_over(stages, vectors, live, out):
    """States, quadratures and live tangents at the end of a step, from the rows where it has left them."""
    for i in range(out.size):
        out[i] = stages[END, i]
    for v in range(live):
        for i in range(vectors.shape[1]):
            vectors[v, i] = stages[VECTORS + ROWS_A_VECTOR * v + END, i]
