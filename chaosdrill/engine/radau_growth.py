"""Growth of tangents that decay within a step of an implicit method.

The factor of such a step is a rational number where that of the motion is an exponential. Its directions are right,
though, and the growth along them is the integral of q'Jq, with the Jacobian J and the direction q, at right angles to
those of the tangents before it (continuous QR: Dieci, Russell and Van Vleck 1997, doi:10.1137/S0036142993247311). All
together that is the integral of the trace. The stages are nodes of a quadrature of the order of the step.

Where tangents are not orthonormalised each has a direction of its own.
"""

import math

from chaosdrill.codegen.layout import EPSILON
from chaosdrill.engine.dop853_tables import ROWS_A_VECTOR, VECTORS
from chaosdrill.engine.jit import inlined, inner, rare
from chaosdrill.engine.radau_step import WIDTHS
from chaosdrill.engine.radau_tables import AT_START, PIVOT, WEIGHTS_OF_RATES
from chaosdrill.engine.step_control import size
from chaosdrill.engine.tangents import orthonormalise
from chaosdrill.engine.tuning import RADAU

# rows of ``decay``: logarithm of growth in the step, what that is more than the one of the step's own factor, the
# difference of the rate at the start from the polynomial of the others, its rounding, lengths at the end, whether the
# growth counts
LOG, MORE, EXCESS, ROUNDING, LENGTH, COUNTS = range(6)


@inlined
def outgrown(room, v):
    """Whether the growth of a tangent in the step is not that of the step's own factor."""
    return room.decay[COUNTS, v] > 0.0


@inlined
def forgive(room, v, counts):
    """Note whether that is so."""
    room.decay[COUNTS, v] = 1.0 if counts else 0.0


@inner
def _part_along(row, direction, widths):
    total = 0.0
    for a in range(direction.size):
        total += (row[a] * widths[a]) * (direction[a] * widths[a])
    return total


@inner
def _directions(live, first, widths, frame, decay):
    """Turn tangents into directions of size 1, in the sizes of the states: those from ``first`` on at right angles to
    all before; lengths are those of what is at right angles, too."""
    n = frame.shape[1]
    for v in range(live):
        row = frame[v]
        for _ in range(2):
            for j in range(v if v >= first else 0):
                part = _part_along(row, frame[j], widths)
                for a in range(n):
                    row[a] -= part * frame[j, a]
        length = size(row, widths)
        decay[LENGTH, v] = length
        for a in range(n):
            row[a] = row[a] / length if length > 0.0 else 0.0


@inner
def _rate(direction, jacobian, widths):
    """Rate at which a direction grows, and the sum of the sizes of its terms."""
    rate = told = 0.0
    for a in range(direction.size):
        moved = terms = 0.0
        for b in range(direction.size):
            moved += jacobian[a, b] * direction[b]
            terms += abs(jacobian[a, b] * direction[b])
        part = direction[a] * widths[a] * widths[a]
        rate += part * moved
        told += abs(part) * terms
    return rate, told


@rare
def growth(kind, vectors, live, orthonormal, h, room, stages):
    """Growth of all tangents over a step whose stages are there; their directions at its end are left in ``frame``."""
    widths, frame, decay = stages[WIDTHS], room.frame, room.decay
    n = vectors.shape[1]
    s = 3 + 2 * kind
    first = 0 if orthonormal == 1 else live
    for v in range(live):
        for a in range(n):
            frame[v, a] = vectors[v, a]
    _directions(live, first, widths, frame, decay)
    for v in range(live):
        rate, told = _rate(frame[v], room.at_start, widths)
        decay[LOG, v] = 0.0
        decay[EXCESS, v] = rate
        decay[ROUNDING, v] = told
        decay[MORE, v] = decay[LENGTH, v]
    for j in range(s):
        for v in range(live):
            for a in range(n):
                frame[v, a] = stages[VECTORS + ROWS_A_VECTOR * v + 1 + j, a]
        _directions(live, first, widths, frame, decay)
        for v in range(live):
            rate, told = _rate(frame[v], room.jacobians[j], widths)
            decay[LOG, v] += h * WEIGHTS_OF_RATES[kind, s - 1, j] * rate
            decay[EXCESS, v] -= AT_START[kind, j] * rate
            decay[ROUNDING, v] += abs(AT_START[kind, j]) * told
    for v in range(live):
        there = decay[LENGTH, v] > 0.0 and decay[MORE, v] > 0.0
        decay[MORE, v] = decay[LOG, v] - math.log(decay[LENGTH, v] / decay[MORE, v]) if there else math.nan


@rare
def decay_error(kind, v, vector, orthonormal, h, room, stages):
    """Error of a tangent that decays within the step, relative to what is left; infinite for others.

    That of its growth is relative to this. What moves it along itself, or along those before it if it is made
    orthogonal to them, is none of its direction. What `tangent_error` has left is used up.
    """
    decay, frame, widths, right = room.decay, room.frame, stages[WIDTHS], room.right
    n = vector.size
    if not abs(decay[MORE, v]) < math.inf:
        return math.inf
    rounding = RADAU.noise * EPSILON * (size(vector, widths) + size(right[:n], widths))
    for _ in range(2):
        for j in range(0 if orthonormal == 1 else v, v + 1):
            part = _part_along(right, frame[j], widths)
            for a in range(n):
                right[a] -= part * frame[j, a]
    aside = max(size(right[:n], widths) - rounding, 0.0) / decay[LENGTH, v]
    off = max(abs(decay[EXCESS, v]) - RADAU.noise * EPSILON * decay[ROUNDING, v], 0.0)
    return max(aside, PIVOT[kind] * h * off / max(1.0, abs(decay[LOG, v])))


@rare
def take_growth(functions, tables, settings, state, scratch):
    """Give tangents at the end of a step the growth that counts."""
    decay, vectors, live = scratch.implicit.decay, state.vectors, state.run[0].live
    counts = 0
    for v in range(live):
        counts += 1 if decay[COUNTS, v] > 0.0 else 0
    if counts == 0:
        return
    if settings.orthonormalise == 0:
        for v in range(live):
            if decay[COUNTS, v] > 0.0:
                factor = math.exp(decay[MORE, v])
                for a in range(vectors.shape[1]):
                    vectors[v, a] *= factor
        return
    # what they lose by being made orthonormal is in their growth
    for v in range(live):
        decay[EXCESS, v] = state.exponent_of[v]
    orthonormalise(functions, tables, state, scratch)
    for v in range(live):
        if decay[COUNTS, v] > 0.0:
            state.logs[int(decay[EXCESS, v])] += decay[MORE, v]
