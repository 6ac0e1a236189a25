"""One step of a Radau IIA method: its stages by Newton's method, tangents, error, dense output.

The unknowns are the increments Z of the states from the start to the stages. The slopes that these have as values of a
polynomial are h times the rates there. A state whose rate no state changes, as one that rests, a clock, or a parameter
that is followed, is no unknown: its increments are sums of its rates, and exact where these are zero.

Rows of ``stages`` are those of ``dop853_tables``: the rate at the start, from ``Z`` and ``F`` on increments and rates
of the stages; for every tangent its rate at the start, then the tangents at the stages, and its end.
"""

import math

from chaosdrill.engine.checked import first_row, rounding_of_rate
from chaosdrill.engine.dop853_tables import END, PLACE, ROWS_A_VECTOR, VECTORS, WEIGHTS
from chaosdrill.engine.jit import inner, rare, series
from chaosdrill.engine.radau_tables import DEGREE, MOST_STAGES, NODES, PIVOT, POWERS, SLOPES, WEIGHTS_OF_RATES
from chaosdrill.engine.scales import SMALLEST, fill, widen
from chaosdrill.engine.step_control import begun, is_new, size
from chaosdrill.engine.tuning import CHECKS, RADAU

Z, F, WIDTHS = 1, 1 + MOST_STAGES, 1 + 2 * MOST_STAGES
"""Rows of ``stages``: increments of the stages, their rates, one over the sizes by which errors are measured."""


@series
def factorise(a, count, pivots):
    """Triangular factors in place, with partial pivoting; returns whether there are any."""
    for k in range(count):
        row = k
        largest = 0.0
        for i in range(k, count):
            here = abs(a[i, k])
            if not here <= largest:
                largest = here
                row = i
        if not 0.0 < largest < math.inf:
            return False
        pivots[k] = row
        if row != k:
            for j in range(count):
                a[k, j], a[row, j] = a[row, j], a[k, j]
        inverse = 1.0 / a[k, k]
        for i in range(k + 1, count):
            if a[i, k] != 0.0:
                part = a[i, k] * inverse
                a[i, k] = part
                for j in range(k + 1, count):
                    a[i, j] -= part * a[k, j]
    return True


@series
def solve(a, count, pivots, b):
    """Solution in place, from the factors."""
    for k in range(count):
        row = int(pivots[k])
        b[k], b[row] = b[row], b[k]
    for i in range(1, count):
        total = b[i]
        for j in range(i):
            total -= a[i, j] * b[j]
        b[i] = total
    for i in range(count - 1, -1, -1):
        total = b[i]
        for j in range(i + 1, count):
            total -= a[i, j] * b[j]
        b[i] = total / a[i, i]


@inner
def jacobian(functions, mode, t, c, place, target, n, spare):
    """The Jacobian at a place, from its products with unit vectors; ``spare`` are two rows."""
    unit, column = spare[0], spare[1]
    for k in range(n):
        for i in range(n):
            unit[i] = 0.0
        unit[k] = 1.0
        functions.variation(mode, t, c, place, unit, column)
        for i in range(n):
            target[i, k] = column[i]


@inner
def _put(x, stages, row, place):
    for i in range(x.size):
        place[i] = x[i] + stages[row, i]


@inner
def factors(functions, kind, t, state, h, room, stages, at_stages):
    """Factor the matrix of Newton's method, in the scales of the states: with Jacobians at the stages, or at the start.

    Returns whether that could be done, and the number of unknowns of a stage; which they are is in ``room.active``.
    """
    x, c, mode, weights = state.x, state.c, state.run[0].mode, stages[WEIGHTS]
    n = x.size
    s = 3 + 2 * kind
    place = stages[PLACE]
    slopes, nodes = SLOPES[kind], NODES[kind]
    for j in range(s):
        if at_stages:
            _put(x, stages, Z + j, place)
            jacobian(functions, mode, t + nodes[1 + j] * h, c, place, room.jacobians[j], n, room.spare)
        else:
            for i in range(n):
                for k in range(n):
                    room.jacobians[j, i, k] = room.at_start[i, k]
    active = room.active
    count = 0
    for i in range(n):
        moved = False
        for j in range(s):
            for k in range(n):
                moved = moved or room.jacobians[j, i, k] != 0.0
        if moved:
            active[count] = i
            count += 1
    matrix = room.matrix
    for j in range(s):
        for a in range(count):
            i = active[a]
            row = matrix[j * count + a]
            for k in range(s * count):
                row[k] = 0.0
            for k in range(s):
                row[k * count + a] = slopes[1 + j, 1 + k]
            for b in range(count):
                k = active[b]
                row[j * count + b] -= h * room.jacobians[j, i, k] * (weights[i] / weights[k])
    return factorise(matrix, s * count, room.pivots), count


@inner
def _rates(functions, kind, t, state, h, stages):
    """Rates at the stages."""
    run, x, c = state.run[0], state.x, state.c
    s = 3 + 2 * kind
    for j in range(s):
        _put(x, stages, Z + j, stages[PLACE])
        functions.field(run.mode, t + NODES[kind, 1 + j] * h, c, stages[PLACE], stages[F + j])
    run.evaluations += s


@series
def _sum(kind, h, stages, j, i):
    """Increment of a state, or an integral, up to stage j, by its rates."""
    total = 0.0
    for k in range(3 + 2 * kind):
        total += WEIGHTS_OF_RATES[kind, j, k] * stages[F + k, i]
    return h * total


@series
def _update(kind, x, h, room, stages, count):
    """Move the stages by one Newton step from their rates; row s of ``changes`` has the largest of each state."""
    n = x.size
    s = 3 + 2 * kind
    active, weights, changes, right = room.active, stages[WEIGHTS], room.changes, room.right
    for i in range(n):
        changes[s, i] = 0.0
    a = 0
    for i in range(n):
        if a < count and active[a] == i:
            a += 1
            for j in range(s):
                changes[j, i] = 0.0
        else:
            for j in range(s):
                changes[j, i] = _sum(kind, h, stages, j, i) - stages[Z + j, i]
    for j in range(s):
        for a in range(count):
            i = active[a]
            total = h * stages[F + j, i]
            for k in range(s):
                total -= SLOPES[kind, 1 + j, 1 + k] * stages[Z + k, i]
            for k in range(n):
                total += h * room.jacobians[j, i, k] * changes[j, k]
            right[j * count + a] = total * weights[i]
    solve(room.matrix, s * count, room.pivots, right)
    for j in range(s):
        for a in range(count):
            changes[j, active[a]] = right[j * count + a] / weights[active[a]]
        for i in range(n):
            stages[Z + j, i] += changes[j, i]
            change = abs(changes[j, i])
            if change > changes[s, i] or change != change:
                changes[s, i] = change


@inner
def newton(functions, tables, kind, t, state, h, tolerance, scratch, predicted):
    """Solve for the stages of a step of length h, from increments that are there; returns whether that succeeds.

    Without a prediction they are set to zero, and the Jacobian at the start serves first. Updates are measured in parts
    of the tolerance. Where they do not become smaller, what they are has to be within it, or round-off.
    """
    x, scale, room, stages = state.x, state.scale, scratch.implicit, scratch.stages
    n = x.size
    s = 3 + 2 * kind
    if not predicted:
        stages[Z : Z + s, :n] = 0.0
    before, part, count = math.inf, 0.0, 0
    for update in range(RADAU.updates):
        _rates(functions, kind, t, state, h, stages)
        if update == 0 or part > RADAU.sluggish:
            there, count = factors(functions, kind, t, state, h, room, stages, predicted or update > 0)
            if not there:
                return False
        _update(kind, x, h, room, stages, count)
        largest = 0.0
        for i in range(n):
            change = room.changes[s, i]
            if not change < math.inf:
                return False
            if change > 0.0:
                largest = max(largest, change / (tolerance * _width(scale, stages, s, i)))
        part = max(largest / before, RADAU.sluggish if update == 1 else 0.0)
        before = largest
        if largest <= RADAU.left or (update > 0 and part < RADAU.still and largest * part <= RADAU.left * (1.0 - part)):
            return True
        if update > 1 and part > RADAU.still and _is_round_off(functions, tables, t, state, h, tolerance, s, scratch):
            return True
        if part > 2.0 and update > 2:
            return False
    return False


@inner
def _width(scale, stages, s, i):
    """Size of a state in a step: that of late, or how far the stages are from its start."""
    width = max(scale[i], SMALLEST)
    for j in range(s):
        width = max(width, abs(stages[Z + j, i]))
    return width


@rare
def _is_round_off(functions, tables, t, state, h, tolerance, s, scratch):
    """Whether an update is within the tolerance, or what rounding of the states and of their rates makes."""
    x, changes, stages, slopes = state.x, scratch.implicit.changes, scratch.stages, scratch.implicit.at_start
    for i in range(x.size):
        change = changes[s, i]
        if change > tolerance * _width(state.scale, stages, s, i):
            total = abs(x[i])
            for k in range(x.size):
                total += h * abs(slopes[i, k]) * (abs(x[k]) + abs(stages[Z + s - 1, k]))
            own = CHECKS.doubt * h * rounding_of_rate(functions, tables, i, t, state, x, scratch)
            if change > max(RADAU.rates * total, own):
                return False
    return True


@series
def _may_move(kind, i, moved, room):
    """Whether the rate of state i changes with one that is moved, at any stage."""
    for k in range(moved.size):
        if moved[k] > 0.0:
            for j in range(3 + 2 * kind):
                if room.jacobians[j, i, k] != 0.0:
                    return True
    return False


@series
def _mark_moved(kind, v, room, moved, count):
    """Mark the states that a tangent moves in the step."""
    further = False
    for i in range(v.size):
        moved[i] = 1.0 if v[i] != 0.0 else 0.0
        further = further or v[i] == 0.0
    while further:
        further = False
        for a in range(count):
            i = room.active[a]
            if moved[i] == 0.0 and _may_move(kind, i, moved, room):
                moved[i] = 1.0
                further = True


@series
def stage_tangents(kind, v, h, room, stages, row, count):
    """Tangents at the stages, from the factors there: the derivative of the stages by the state at the start.

    The second solution takes away what rounding leaves of the first: sizes of states are not those of tangents. What
    rounding puts where a tangent never gets would outlive one that decays.
    """
    n = v.size
    s = 3 + 2 * kind
    active, weights, right, moved = room.active, stages[WEIGHTS], room.right, room.spare[0]
    _mark_moved(kind, v, room, moved, count)
    for j in range(s):
        for i in range(n):
            stages[row + 1 + j, i] = v[i]
    for _ in range(2):
        for j in range(s):
            for a in range(count):
                i = active[a]
                total = 0.0
                for k in range(s):
                    total -= SLOPES[kind, 1 + j, 1 + k] * (stages[row + 1 + k, i] - v[i])
                for k in range(n):
                    total += h * room.jacobians[j, i, k] * stages[row + 1 + j, k]
                right[j * count + a] = total * weights[i]
        solve(room.matrix, s * count, room.pivots, right)
        for j in range(s):
            for a in range(count):
                i = active[a]
                stages[row + 1 + j, i] += right[j * count + a] / weights[i] if moved[i] > 0.0 else 0.0
    for i in range(n):
        stages[row + END, i] = stages[row + s, i]


@inner
def finish(functions, kind, t, state, h, stages, out):
    """States at the end, and integrals up to there and up to the stages."""
    x = state.x
    n = x.size
    s = 3 + 2 * kind
    for i in range(n):
        out[i] = x[i] + stages[Z + s - 1, i]
    if out.size > n:
        _rates(functions, kind, t, state, h, stages)
    for i in range(n, out.size):
        for j in range(s):
            stages[Z + j, i] = _sum(kind, h, stages, j, i)
        out[i] = stages[Z + s - 1, i]


@series
def excess(kind, h, stages, i):
    """What the rate at the start has more than the slope there of the polynomial through the stages."""
    total = 0.0
    for j in range(3 + 2 * kind):
        total += SLOPES[kind, 0, 1 + j] * stages[Z + j, i]
    return stages[0, i] - total / h


@inner
def set_filter(h, kind, n, room, stages):
    """Factor 1 - h g J, J at the start, in the scales of the states."""
    weights = stages[WEIGHTS]
    part = h * PIVOT[kind]
    for i in range(n):
        for k in range(n):
            room.filter[i, k] = -part * room.at_start[i, k] * (weights[i] / weights[k])
        room.filter[i, i] += 1.0
    return factorise(room.filter, n, room.filter_pivots)


@series
def _damp(b, n, room, stages):
    """Take the stiff part from a vector, in place, by the filter of the step."""
    weights = stages[WEIGHTS]
    for i in range(n):
        b[i] *= weights[i]
    solve(room.filter, n, room.filter_pivots, b)
    for i in range(n):
        b[i] /= weights[i]


@series
def _begun(kind, scale, stages, i, most):
    """Size of what begins, which its rate at the start would move by ``most``."""
    slowest = math.inf
    for j in range(3 + 2 * kind):
        slope = 0.0
        for k in range(3 + 2 * kind):
            slope += SLOPES[kind, 1 + j, 1 + k] * stages[Z + k, i]
        most = max(most, abs(slope))
        slowest = min(slowest, abs(slope))
    return begun(scale, i, slowest, most)


@inner
def errors_of(kind, x, h, scale, span, least, longest, rounding, room, stages):
    """Error of a step: as it counts, and without the damping of what is stiff; the sizes that measure it are kept.

    Tangents count states that have no size, as what has decayed to nothing, by the largest one of the others. No size
    is smaller than ``rounding`` has it, see `checked.coarsest`; a state whose own would be has none for tangents.

    It is that of an embedded formula of the order of the stages, which takes part of the rate at the start (Hairer and
    Wanner, section IV.8). Between the stages their polynomial is as exact only where nothing is stiff.
    """
    n = x.size
    s = 3 + 2 * kind
    widths = stages[WIDTHS]
    for i in range(stages.shape[1]):
        moved = 0.0
        if is_new(scale[i], x[i] if i < n else 0.0, stages[0, i], least, longest):
            moved = _begun(kind, scale, stages, i, h * abs(stages[0, i]))
        else:
            for j in range(s):
                moved = max(moved, abs(stages[Z + j, i]))
        width = max(scale[i], moved, rounding[i])
        widths[i] = 1.0 / width if width > SMALLEST else 0.0
    if not set_filter(h, kind, n, room, stages):
        return math.nan, math.nan
    raw = stages[PLACE]
    for i in range(raw.size):
        raw[i] = PIVOT[kind] * h * excess(kind, h, stages, i)
    plain = size(raw, widths)
    _damp(raw, n, room, stages)
    error = size(raw, widths)
    for i in range(n):
        if rounding[i] * widths[i] > 0.5:
            widths[i] = 0.0
    fill(widths[:n])
    widen(widths, span, n)
    return error, plain


@inner
def damped(rate, slope, doubt, s, n, room, stages):
    """Length of s times the difference of two rates, but for their doubt, without its stiff part; sizes and filter are
    those of the step."""
    widths, right = stages[WIDTHS], room.right
    for i in range(n):
        off = abs(slope[i] - rate[i])
        off = off if math.isnan(off) else max(off - CHECKS.rounding * abs(rate[i]) - CHECKS.doubt * doubt[i], 0.0)
        right[i] = math.copysign(off * s, slope[i] - rate[i])
    _damp(right, n, room, stages)
    return size(right[:n], widths[:n])


@inner
def tangent_error(kind, v, h, room, stages, row):
    """Error of a tangent relative to its length; the error itself is left in ``right``.

    The sizes and the filter are those of the step.
    """
    n = v.size
    widths, right = stages[WIDTHS], room.right
    length = size(v, widths)
    # below, it has no digits
    if not length > SMALLEST:
        return 0.0
    for i in range(n):
        total = 0.0
        for j in range(3 + 2 * kind):
            total += SLOPES[kind, 0, 1 + j] * (stages[row + 1 + j, i] - v[i])
        right[i] = PIVOT[kind] * (h * stages[row, i] - total)
    _damp(right, n, room, stages)
    return size(right[:n], widths) / length


@series
def dense_output(kind, x, h, steep, stages, ws):
    """Coefficients of states and integrals over the step; returns whether they are numbers.

    ``steep`` is for the slope at the start to be the rate there.
    """
    s = 3 + 2 * kind
    sizes = 0.0
    for i in range(stages.shape[1]):
        ws[i, 0] = x[i] if i < x.size else 0.0
        more = h * excess(kind, h, stages, i) if steep else 0.0
        power = 1.0
        for k in range(DEGREE):
            total = POWERS[kind, k, DEGREE - 1] * more
            for j in range(s):
                total += POWERS[kind, k, j] * stages[Z + j, i]
            power /= h
            ws[i, k + 1] = total * power
            sizes += abs(ws[i, k + 1])
        if steep:
            ws[i, 1] = stages[0, i]
        else:
            stages[0, i] = ws[i, 1]
    return sizes < math.inf


@series
def dense_tangents(kind, vectors, live, h, stages, ws):
    """Coefficients of the tangents over the step, through the stages alone."""
    for v in range(live):
        for i in range(vectors.shape[1]):
            row = ws[first_row(ws, vectors, v) + i]
            row[0] = vectors[v, i]
            power = 1.0
            for k in range(DEGREE):
                total = 0.0
                for j in range(3 + 2 * kind):
                    total += POWERS[kind, k, j] * (stages[VECTORS + ROWS_A_VECTOR * v + 1 + j, i] - vectors[v, i])
                power /= h
                row[k + 1] = total * power


@series
def predict(kind, n, s, stages, ws):
    """Increments at the stages of a step of length s, from the dense output of one that begins alike."""
    for j in range(3 + 2 * kind):
        u = NODES[kind, 1 + j] * s
        for i in range(n):
            total = 0.0
            for k in range(DEGREE, 0, -1):
                total = (total + ws[i, k]) * u
            stages[Z + j, i] = total
