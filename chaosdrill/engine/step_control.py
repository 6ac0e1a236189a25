"""How long the steps of Runge-Kutta methods are: scales of states, errors, lengths to try.

Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, 2nd ed. 1993, section II.4
(doi:10.1007/978-3-540-78862-1). Rows of ``stages``: see ``dop853_tables``.
"""

import math

from chaosdrill.engine.dop853_tables import PLACE, ROWS_A_VECTOR, STAGES, VECTORS, WEIGHTS
from chaosdrill.engine.guard_times import NEAR
from chaosdrill.engine.jit import inlined, inner
from chaosdrill.engine.layout import ONGOING
from chaosdrill.engine.taylor import EPSILON, FADE, SLOW, SMALLEST

SAFETY = 0.9

SMALLEST_GROWTH = 0.1
"""A step into a contact may have to shrink by orders of magnitude."""

TANGENTS = 0.1
"""Part of the tolerance for tangents: through a stiff contact they grow by orders of magnitude, and come back."""

BEGINNING = 0.01
"""Part of a period, or of a run without one, to begin with where the size of no state is known."""

UNDERFLOW = 1e-16
"""Part of the longest step below which shortening is given up."""


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
    """Let the scales fade, and note one over them; returns whether any was known.

    Where none is, as at the start of a run, they come from the rates. A state that begins to move later has none yet,
    as its first rate may be nothing but round-off.
    """
    n = x.size
    known = False
    pace = longest
    for i in range(n):
        known = known or scale[i] > SMALLEST
        if x[i] != 0.0 and stages[0, i] != 0.0:
            pace = min(pace, abs(x[i] / stages[0, i]))
    for i in range(stages.shape[1]):
        here = EPSILON / tolerance * abs(x[i]) if i < n else 0.0
        if not known:
            here = max(here, abs(stages[0, i]) * pace)
        scale[i] = max(FADE * scale[i], here)
        stages[WEIGHTS, i] = 1.0 / scale[i] if scale[i] > SMALLEST else 0.0
    return known


@inner
def weigh_all(weights):
    """Give states without a scale the largest one of the others."""
    common = math.inf
    for i in range(weights.size):
        if weights[i] > 0.0:
            common = min(common, weights[i])
    for i in range(weights.size):
        if weights[i] == 0.0:
            weights[i] = common if common < math.inf else 1.0


@inlined
def begun(scale, i, moved):
    """Scale of a state or a quadrature in a step that moves it so far; where it has none yet, this is it."""
    if scale[i] <= SMALLEST and moved < math.inf:
        scale[i] = moved
    return max(scale[i], moved)


@inner
def shrink(error, h, larger, longer, full):
    """Part of a rejected step to try next, by the order that two rejected lengths show: near a kink it is not full."""
    if not math.isfinite(error):
        return SMALLEST_GROWTH
    order = full
    floor = SMALLEST_GROWTH
    if error < larger:
        order = min(max(math.log(larger / error) / math.log(longer / h), 1.0), full)
        floor = SMALLEST_GROWTH**3
    return max(SAFETY * error ** (-1.0 / order), floor)


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
            speed = max(speed, size(stages[VECTORS + ROWS_A_VECTOR * v][:n], weights) / length)
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
        direction = stages[row + STAGES]
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
def wanted_length(functions, t, state, known, tolerance, stages):
    """Length to try first; ``known`` says whether the size of any state is."""
    run = state.run[0]
    if run.next_step > 0.0:
        return run.next_step
    return first_length(functions, t, state, tolerance, run.period, stages) if known else BEGINNING * run.period


@inlined
def up_to_goal(settings, run, h):
    """A length, but for the last step to where the run ends: that ends there."""
    rest = run.period - run.time
    return min(h, rest) if run.strobes + 1 >= settings.target and rest > NEAR * run.period else h


@inlined
def accept(run, error, order, h, wanted, rejected, largest_growth):
    """Note a step that is taken, and the length of the next: by its error and that of the step before (Gustafsson)."""
    strength = max(error, 1e-9) ** (1.0 / order) / h
    before = run.strength if run.fresh == ONGOING else 0.0
    following = min(SAFETY / strength, largest_growth * h)
    if 0.0 < before < strength:
        following *= before / strength
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
    """Let the scale of state or quadrature i follow a step that moves it so far."""
    scale[i] = max(scale[i], min(abs(x[i]), SLOW * moved) if i < x.size else moved)
