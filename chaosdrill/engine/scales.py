"""The size of a state, the unit of its errors: the same for every method, for single runs and for lanes.

A state comes to a step with the largest size that it has had of late, `brought`, and that follows it, `followed`. The
size is that of a motion: what rests keeps none, whatever its value, and what a reset writes is a value and no size.
Where such a state begins to move, its size is what it moves in a step of its own, `has_none` so far; a method of series
reads that off its series, others take it from the first length that they try. A state that moves in proportion to
itself, as a population, has its value for its size, as a tangent its length: it comes back from what is left of it. All
of this is the same in any unit of states and time.
"""

import math

from chaosdrill.codegen.layout import EPSILON
from chaosdrill.engine.jit import inlined, inner, rare
from chaosdrill.engine.lanes import as_wide, chosen, larger, magnitude, smaller
from chaosdrill.engine.tuning import SIZES

SMALLEST = 1e-290
"""Size below which one over it overflows."""


@inlined
def finest(tolerance):
    """Part of its value that is the least size of a state, in which its rounding is the tolerance."""
    return EPSILON / tolerance


@inlined
def brought(scale, x, least):
    """Size with which a state, or one in each lane, comes to a step; ``least`` is `finest` of the tolerance."""
    return larger(SIZES.fade * scale, least * magnitude(x))


@inlined
def part(tables):
    """Whether tangents have sizes of their own: some state moves in proportion to itself."""
    return tables.proportional.shape[1] > 1


@inlined
def renew(tables, mode, n, x, scale, span):
    """Let the sizes of states that move in proportion to themselves be their values, when they are brought to a step.

    Tangents keep sizes that fade: they are made orthogonal as they are, and by the value of a state that has nearly
    died out all of them would lie along it. ``x`` and the sizes are of one run, or of lanes.
    """
    if part(tables):
        for i in range(n):
            span[i] = larger(SIZES.fade * span[i], scale[i])
    for k in range(tables.proportional[mode, 0]):
        i = tables.proportional[mode, 1 + k]
        scale[i] = chosen(magnitude(x[i]) > SIZES.left, magnitude(x[i]) / SIZES.fade, scale[i])


@inlined
def has_none(size, rate, longest):
    """Whether a size says nothing of the motion: it is no more than rounding of what the state may move in a step."""
    return size <= EPSILON * longest * magnitude(rate) + SMALLEST


@inlined
def followed(scale, x, rate, h):
    """Size after a step of length h from x with that rate, of one state or of one in each lane."""
    moved = magnitude(rate) * h
    return larger(scale, larger(smaller(magnitude(x), SIZES.slow * moved), SIZES.turn * moved))


@rare
def of_series(g, order, reach, longest):
    """Size of a motion known by its series alone: its displacement in a step of its own, no longer than the longest.

    Of ``1 - gate`` far from the gate, whose last terms are tiny but there, a step of its own would be a million long.
    """
    first = 1
    while first < order and g[first] == 0.0:
        first += 1
    # both of the last two terms may lie in a gap
    last = order
    while last > 2 and g[last] == 0.0 and g[last - 1] == 0.0:
        last -= 1
    if not (first < last - 1 and abs(g[first]) > SMALLEST):
        return 0.0
    a = abs(g[last] / g[first]) ** (1.0 / (last - first))
    b = abs(g[last - 1] / g[first]) ** (1.0 / (last - 1 - first))
    if not max(a, b) > 0.0:
        return 0.0
    h = min(reach / max(a, b), longest)
    size = 0.0
    for k in range(order, 0, -1):
        size = max(size * h, abs(g[k]) * h)
    return size


@inlined
def limit(tables, n, span, period, metric):
    """Let ``metric`` be one over the least sizes for tangents, infinite where those of the states are theirs.

    ``period``, of one run or of lanes, says which.
    """
    apart = part(tables)
    for i in range(n):
        metric[i] = as_wide(math.inf, period)
        if apart:
            metric[i] = 1.0 / larger(span[i], SMALLEST)


@inlined
def widen(weights, span, n):
    """Let no size of n states, one over which the weights are, be smaller for tangents than ``span`` has it."""
    for i in range(n):
        if weights[i] * span[i] > 1.0:
            weights[i] = 1.0 / span[i]


@inner
def fill(weights):
    """Let states without a size, whose weight is 0, have the largest one of the others, for tangents."""
    common = 0.0
    for i in range(weights.size):
        if weights[i] > 0.0 and not 0.0 < common <= weights[i]:
            common = weights[i]
    for i in range(weights.size):
        if weights[i] == 0.0:
            weights[i] = common if common > 0.0 else 1.0
