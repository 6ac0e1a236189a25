"""Newton's method for an orbit, and a branch of orbits by pseudo-arclength.

H. B. Keller, "Numerical solution of bifurcation and nonlinear eigenvalue problems", in Applications of Bifurcation
Theory, Academic Press 1977, 359-384; predictor: the polynomial through the last points of the branch.
"""

import math

from numba import float64, int64, types

from chaosdrill.codegen.signatures import KERNEL_TYPES, matrix, vector
from chaosdrill.engine.jit import compiled, inner
from chaosdrill.engine.lap import (
    ARC_END,
    ARC_OUTCOME,
    CAME,
    CROSSED,
    FOUND,
    FREE,
    MACHINE,
    ROOM,
    STATES,
    cube,
    lap,
)
from chaosdrill.engine.layout import DONE
from chaosdrill.engine.linear import solve
from chaosdrill.engine.records import integer_matrix, integers, scratch_type
from chaosdrill.engine.stepper import STEPPER_TYPES

MOST_LAPS = 30
"""Laps that Newton's method may take from a guess."""

SHARP = 1e-3
"""Error of an event's time, as a part of the arc before it, up to which it counts as met."""

SHARPER = 3
"""Further laps that an orbit gets for it; near grazing it may be out of reach."""

ON_BRANCH = 9
"""Laps that it may take from a predicted point."""

# how a search for an orbit ended; values from DONE's neighbours on are outcomes of a run
CONVERGED, SINGULAR, SLOW = 0, 101, 102

# why a trace stopped
MOST_POINTS, BEYOND_LIMITS, BORDER, LOST, CLOSED = range(201, 206)

DEGREE = 4
"""Points through which the predictor goes."""

BEND = 0.97
"""Cosine of the largest angle between the branch's directions at two points."""

PREDICTED = 1e-5
"""Error of prediction to which steps are adapted."""

REACH = 0.1
"""Longest correction by one lap on a branch."""

FARTHEST = 0.05
"""Distance from where it was predicted at which an orbit is no longer taken for a point of the branch."""

SHORTEST = 1e-7
"""Part of the longest step below which the branch is lost."""

cube_of_integers = int64[:, :, ::1]

SOLVED = types.Tuple((matrix, integers, vector, vector, vector))
"""room for solving: the system, order of its rows, correction, which way is ahead, what was predicted"""

NEWTON = types.Tuple((int64, int64))(
    *KERNEL_TYPES,
    *STEPPER_TYPES,
    *(MACHINE, integers, integer_matrix, matrix, matrix, vector, vector),
    *(matrix, vector, float64, float64, vector),
    *(FOUND, SOLVED, ROOM, scratch_type),
)

TRACE = types.Tuple((int64, int64))(
    *KERNEL_TYPES,
    *STEPPER_TYPES,
    *(MACHINE, integers, integer_matrix, matrix, vector, vector, float64, vector),
    *(cube, matrix, matrix, cube, matrix, matrix, matrix, cube_of_integers),
    *(matrix, FOUND, SOLVED, ROOM, scratch_type),
)


@inner
def apply(sizes, starts, clock, durations, sensitivity, correction, factor):
    """Move an orbit by a correction of its reduced unknowns; the starts of later arcs follow."""
    count, n = starts.shape
    d = sizes[STATES]
    columns = correction.size
    for i in range(count):
        for r in range(n):
            value = sensitivity[i, r, columns]
            for u in range(columns):
                value += sensitivity[i, r, u] * correction[u]
            starts[i, r] += factor * value
    clock[0] += factor * correction[d]
    for i in range(count):
        durations[i] += factor * correction[d + 1 + i]


@inner
def sharp(equations, speeds, durations, columns):
    """Whether all events are met at their times, not only near their guards: the last rebounds of chatter are low."""
    late = False
    for i in range(durations.size):
        late |= abs(equations[i, columns]) > SHARP * abs(speeds[i]) * abs(durations[i])
    return not late


@inner
def improve(
    functions, stepper, machine, sizes, arcs, plane, starts, clock, durations, conditions, weights, target, reach, most,
    history, found, solved, room, scratch,
):  # fmt: skip
    """Newton's method with ``conditions`` on the correction: (how it ended, laps).

    There is one for every free parameter, and more where orbits come in families: what tells their members.

    It has converged when no residual is above ``target``, or when none has become smaller where round-off may be all
    that is left of them.
    """
    equations, sensitivity = found[0], found[1]
    system, order, correction = solved[0], solved[1], solved[2]
    count = starts.shape[0]
    d, q = sizes[STATES], sizes[FREE]
    columns = d + 1 + count + q
    size = count + d + 1
    before = math.inf
    sharper = 0
    for turn in range(most):
        outcome, residual = lap(
            *functions, *stepper, machine, sizes, arcs, plane, starts, clock[0], durations, int64(turn > 0), found,
            room, scratch,
        )  # fmt: skip
        if turn < history.size:
            history[turn] = residual
        if outcome != DONE:
            return outcome, turn + 1
        close = residual <= target or (residual <= 100.0 * target and residual > 0.3 * before)
        if turn > 0 and close and (sharper >= SHARPER or sharp(equations, found[3], durations, columns)):
            return CONVERGED, turn + 1
        sharper += int(close)
        if not math.isfinite(residual):
            return SLOW, turn + 1
        before = residual
        for i in range(size):
            for u in range(columns):
                system[i, u] = equations[i, u]
            system[i, columns] = -equations[i, columns]
        for j in range(conditions.shape[0]):
            for u in range(columns):
                system[size + j, u] = conditions[j, u]
            system[size + j, columns] = 0.0
        if solve(system, size + conditions.shape[0], columns, order, weights) == 0:
            return SINGULAR, turn + 1
        length = 0.0
        for u in range(columns):
            correction[u] = system[order[u], columns]
            length += (weights[u] * correction[u]) ** 2
        length = math.sqrt(length)
        if not math.isfinite(length):
            return SINGULAR, turn + 1
        apply(sizes, starts, clock, durations, sensitivity, correction, min(1.0, reach / length) if length > 0 else 1.0)
    return SLOW, most


@inner
def direction(sizes, count, conditions, weights, reference, found, solved):
    """Direction of the branch at the orbit of the last lap, of weighted length 1, into ``correction``.

    ``reference`` (weighted like a gradient) says which way is ahead. Returns False where it is not determined.
    """
    equations = found[0]
    system, order, correction = solved[0], solved[1], solved[2]
    d, q = sizes[STATES], sizes[FREE]
    columns = d + 1 + count + q
    size = count + d + 1
    for i in range(size):
        for u in range(columns):
            system[i, u] = equations[i, u]
        system[i, columns] = 0.0
    for j in range(conditions.shape[0]):
        for u in range(columns):
            system[size + j, u] = conditions[j, u]
        system[size + j, columns] = 1.0 if j == 0 else 0.0
    if solve(system, size + conditions.shape[0], columns, order, weights) == 0:
        return False
    length = 0.0
    ahead = 0.0
    for u in range(columns):
        correction[u] = system[order[u], columns]
        length += (weights[u] * correction[u]) ** 2
        ahead += reference[u] * correction[u]
    length = math.sqrt(length) * (1.0 if ahead >= 0.0 else -1.0)
    if not math.isfinite(length) or length == 0.0:
        return False
    for u in range(columns):
        correction[u] /= length
    return True


@inner
def blocked(arcs, durations, speeds, seen, count):
    """Number of the first arc that the system would not follow so, plus one; 0 if it is an orbit of the system."""
    for i in range(count):
        if seen[i, CROSSED] >= 0 or seen[i, CAME] != arcs[i, ARC_OUTCOME]:
            return i + 1
        if not durations[i] > 0.0 or (arcs[i, ARC_END] >= 0 and not speeds[i] > 0.0):
            return i + 1
    return 0


@compiled(NEWTON)
def newton(
    jet,
    jacobian_jet,
    tangent,
    field,
    variation,
    guard,
    guard_error,
    transit,
    expand,
    locate,
    evaluate,
    advance_by,
    machine,
    sizes,
    arcs,
    plane,
    starts,
    clock,
    durations,
    conditions,
    weights,
    target,
    reach,
    history,
    found,
    solved,
    room,
    scratch,
):
    """Look for an orbit near the given one, which is replaced: (CONVERGED or why not, laps).

    Parameters are those of `chaosdrill.engine.lap.lap`; ``clock`` holds the phase. ``conditions`` (q or more, columns)
    are rows that the correction is orthogonal to, ``reach`` its greatest length in the norm of ``weights``;
    ``history`` gets the residuals.
    """
    return improve(
        (jet, jacobian_jet, tangent, field, variation, guard, guard_error, transit),
        (expand, locate, evaluate, advance_by), machine, sizes, arcs, plane,
        starts, clock, durations, conditions, weights, target, reach, MOST_LAPS, history, found,
        solved, room, scratch,
    )  # fmt: skip


@inner
def reduce_to(out, sizes, starts, clock, durations):
    """The reduced unknowns of an orbit."""
    count = starts.shape[0]
    d = sizes[STATES]
    for r in range(d):
        out[r] = starts[0, r]
    out[d] = clock[0]
    for i in range(count):
        out[d + 1 + i] = durations[i]
    for j in range(sizes[FREE]):
        out[d + 1 + count + j] = starts[0, d + j]


@inner
def predict(sizes, s, k, starts, clock, durations, all_starts, all_clocks, all_durations):
    """The polynomial through the last points before number k, at arclength s."""
    count, n = starts.shape
    points = min(k, DEGREE)
    clock[0] = 0.0
    for i in range(count):
        durations[i] = 0.0
        for r in range(n):
            starts[i, r] = 0.0
    for p in range(k - points, k):
        basis = 1.0
        for o in range(k - points, k):
            if o != p:
                basis *= (s - all_clocks[o, 1]) / (all_clocks[p, 1] - all_clocks[o, 1])
        clock[0] += basis * all_clocks[p, 0]
        for i in range(count):
            durations[i] += basis * all_durations[p, i]
            for r in range(n):
                starts[i, r] += basis * all_starts[p, i, r]
    # the parameter of all arcs is one number
    for i in range(1, count):
        for r in range(sizes[STATES], n):
            starts[i, r] = starts[0, r]


@inner
def distance(a, b, weights):
    """Weighted distance of reduced unknowns."""
    total = 0.0
    for u in range(weights.size):
        total += (weights[u] * (a[u] - b[u])) ** 2
    return math.sqrt(total)


@compiled(TRACE)
def trace(
    jet,
    jacobian_jet,
    tangent,
    field,
    variation,
    guard,
    guard_error,
    transit,
    expand,
    locate,
    evaluate,
    advance_by,
    machine,
    sizes,
    arcs,
    plane,
    weights,
    limits,
    target,
    steps,
    all_starts,
    all_clocks,
    all_durations,
    all_monodromies,
    all_speeds,
    all_directions,
    all_figures,
    all_seen,
    conditions,
    found,
    solved,
    room,
    scratch,
):
    """Follow a branch in one free parameter from a converged orbit: (why it stopped, points).

    Row 0 of ``all_starts``, ``all_clocks`` (phase, arclength) and ``all_durations`` hold the orbit, row 0 of
    ``all_directions`` which way to go. All rows are filled point by point; the others hold monodromy matrices, speeds,
    directions of length 1 in the norm of ``weights``, (residual, laps, error of the prediction), crossings and
    outcomes of the arcs. Behind the last point stands the one that lies beyond the limits or is no orbit of the system
    (BORDER). ``steps`` holds the first step and the longest one.
    """
    functions = (jet, jacobian_jet, tangent, field, variation, guard, guard_error, transit)
    stepper = (expand, locate, evaluate, advance_by)
    monodromy, speeds, seen = found[2], found[3], found[4]
    correction, reference, predicted = solved[2], solved[3], solved[4]
    most, count, n = all_starts.shape
    d = sizes[STATES]
    columns = d + 2 + count
    h = steps[0]
    k = 0
    residual = 0.0
    while True:
        starts, clock, durations = all_starts[k], all_clocks[k], all_durations[k]
        laps = 1
        error = 0.0
        good = True
        if k > 0:
            s = all_clocks[k - 1, 1] + h
            if k == 1:
                outcome, residual = lap(
                    *functions, *stepper, machine, sizes, arcs, plane, all_starts[0], all_clocks[0, 0],
                    all_durations[0], 0, found, room, scratch,
                )  # fmt: skip
                for u in range(columns):
                    correction[u] = all_directions[0, u]
                for i in range(count):
                    durations[i] = all_durations[0, i]
                    for r in range(n):
                        starts[i, r] = all_starts[0, i, r]
                clock[0] = all_clocks[0, 0]
                apply(sizes, starts, clock, durations, found[1], correction, h)
            else:
                predict(sizes, s, k, starts, clock, durations, all_starts, all_clocks, all_durations)
            reduce_to(predicted, sizes, starts, clock, durations)
            for u in range(columns):
                reference[u] = weights[u] ** 2 * all_directions[k - 1, u]
                conditions[0, u] = reference[u]
            ended, laps = improve(
                functions, stepper, machine, sizes, arcs, plane, starts, clock, durations, conditions, weights, target,
                REACH, ON_BRANCH, all_figures[k, 3:], found, solved, room, scratch,
            )  # fmt: skip
            good = ended == CONVERGED
            if good:
                residual = all_figures[k, 2 + laps]
                reduce_to(correction, sizes, starts, clock, durations)
                error = distance(correction, predicted, weights)
                good = error < FARTHEST
        else:
            for u in range(columns):
                reference[u] = weights[u] ** 2 * all_directions[0, u]
                conditions[0, u] = reference[u]
            outcome, residual = lap(
                *functions, *stepper, machine, sizes, arcs, plane, starts, clock[0], durations, 1, found, room, scratch
            )  # fmt: skip
            good = outcome == DONE
        if good:
            good = direction(sizes, count, conditions, weights, reference, found, solved)
        if good and k > 0:
            cosine = 0.0
            for u in range(columns):
                cosine += reference[u] * correction[u]
            good = cosine > BEND
        if not good:
            h *= 0.5
            if k == 0 or h < SHORTEST * steps[1]:
                return LOST, k
            continue
        for u in range(columns):
            all_directions[k, u] = correction[u]
        reduce_to(correction, sizes, starts, clock, durations)
        if k > 0:
            reduce_to(predicted, sizes, all_starts[k - 1], all_clocks[k - 1], all_durations[k - 1])
            clock[1] = all_clocks[k - 1, 1] + distance(correction, predicted, weights)
        for r in range(d):
            for v in range(d):
                all_monodromies[k, r, v] = monodromy[r, v]
        for i in range(count):
            all_speeds[k, i] = speeds[i]
            all_seen[k, i, 0] = seen[i, 0]
            all_seen[k, i, 1] = seen[i, 1]
        all_figures[k, 0] = residual
        all_figures[k, 1] = laps
        all_figures[k, 2] = error
        if blocked(arcs, durations, speeds, seen, count) > 0:
            return BORDER, k
        if not limits[0] <= starts[0, d] <= limits[1]:
            return BEYOND_LIMITS, k
        k += 1
        if k + 1 >= most:
            return MOST_POINTS, k
        if k > 10:
            reduce_to(predicted, sizes, all_starts[0], all_clocks[0], all_durations[0])
            cosine = 0.0
            for u in range(columns):
                cosine += weights[u] ** 2 * all_directions[0, u] * all_directions[k - 1, u]
            if distance(correction, predicted, weights) < h and cosine > 0.5:
                return CLOSED, k
        if k > 1:
            growth = (PREDICTED / error) ** (1.0 / min(k, DEGREE)) if error > 0.0 else 2.0
            h = min(h * min(max(growth, 0.3), 2.0), steps[1])
