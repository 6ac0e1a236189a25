"""Tangent vectors: orthonormalised by modified Gram-Schmidt with their growth kept, their rank carried exactly.

Exponents by the method of Benettin et al. 1980 (part 2, doi:10.1007/BF02128237). A vector that an event of deficient
rank has removed is dropped, so that its exponent is -inf and no invented number.
"""

import math

from chaosdrill.codegen.kinds import void
from chaosdrill.engine.guard_roots import unit_of
from chaosdrill.engine.jit import inlined, inner, rare
from chaosdrill.engine.layout import AT_EVENT, CHECKED
from chaosdrill.engine.records import time_of, unit
from chaosdrill.engine.tuning import TANGENTS


@inner
def _project(v, basis, scratch):
    """Replace v by its part in the span of orthonormal rows."""
    k, n = basis.shape
    for a in range(n):
        scratch[a] = 0.0
    for i in range(k):
        dot = 0.0
        for a in range(n):
            dot += basis[i, a] * v[a]
        for a in range(n):
            scratch[a] += dot * basis[i, a]
    for a in range(n):
        v[a] = scratch[a]


@inner
def _take_away(row, basis, count, n, size):
    """Take from ``size`` numbers of a row their parts along orthonormal rows, as the first n tell."""
    for j in range(count):
        dot = 0.0
        for a in range(n):
            dot += basis[j, a] * row[a]
        for a in range(size):
            row[a] -= dot * basis[j, a]


@rare
def _by_size(v, scale):
    """Square of a tangent's length, in parts of the sizes that the states have had of late, times the largest."""
    widest = 0.0
    for a in range(v.size):
        widest = max(widest, scale[a])
    # of states below 1e-154 the square of one over the size overflows
    least = TANGENTS.finest * widest
    found = 0.0
    for a in range(v.size):
        part = v[a] * (widest / scale[a]) if scale[a] > least else v[a] / TANGENTS.finest if scale[a] > 0.0 else v[a]
        found += part * part
    return found


@rare
def normals_of(functions, tables, mode, t, state, n, scratch):
    """Orthonormal normals of the surfaces that a mode holds, in the first n states by ``scratch.metric``; how many.

    Their time derivatives and values, behind them, are combined like them.
    """
    normals, gradient, metric, size = scratch.normals, scratch.gradient, scratch.metric, state.x.size
    found = 0
    for k in range(tables.held[mode]):
        row = normals[found]
        row[size + 1] = functions.guard(mode, tables.active[mode, 0] + k, t, state.c, state.x, gradient)
        for a in range(size + 1):
            row[a] = gradient[a]
        largest = 0.0
        for a in range(n):
            row[a] = 0.0 if tables.constrained[mode, a] == 1 else row[a] * metric[a]
            largest = max(largest, abs(row[a]))
        unit = unit_of(largest)
        before = 0.0
        for a in range(size + 2):
            row[a] *= unit
        for a in range(n):
            before += row[a] * row[a]
        for _ in range(2):
            _take_away(row, normals, found, n, size + 2)
        length = 0.0
        for a in range(n):
            length += row[a] * row[a]
        if TANGENTS.rank**2 * before < length < math.inf:
            length = math.sqrt(length)
            for a in range(size + 2):
                row[a] /= length
            found += 1
    return found


@unit(void)
def keep_to_surfaces(functions, tables, state, scratch):
    """Keep tangents in the surfaces that the present mode holds; a call, since few modes hold any.

    In exact arithmetic they stay there. But what rounding leaves across a surface may never decay, and outlives
    tangents that do.
    """
    run, vectors, normals = state.run[0], state.vectors, scratch.normals
    n = vectors.shape[1]
    scratch.metric[:] = 1.0
    found = normals_of(functions, tables, run.mode, time_of(run), state, n, scratch)
    for i in range(vectors.shape[0]):
        before = _by_size(vectors[i], state.span)
        _take_away(vectors[i], normals, found, n, n)
        if _by_size(vectors[i], state.span) <= TANGENTS.rank**2 * before:
            for a in range(n):
                vectors[i, a] = 0.0


@rare
def _length_of(v):
    """Length of a vector whose squares may be no doubles."""
    largest = 0.0
    for a in range(v.size):
        largest = max(largest, abs(v[a]))
    unit = unit_of(largest)
    square = 0.0
    for a in range(v.size):
        square += (v[a] * unit) ** 2
    return math.sqrt(square) / unit


@rare
def _left_of(whole, basis, kept, v):
    """Part of a vector across orthonormal rows, where little is left of it; returns its length.

    Of v - (q.v) q the large entries cancel to rounding, which may be more than the small ones are. Its terms
    q_a (q_a v_b - q_b v_a) are as exact as the entries, of whatever sizes these are.
    """
    n = v.size
    for a in range(n):
        v[a] = whole[a]
    for j in range(kept):
        q = basis[j]
        for b in range(n):
            part = 0.0
            for a in range(n):
                part += q[a] * (q[a] * v[b] - q[b] * v[a])
            whole[b] = part
        for a in range(n):
            v[a] = whole[a]
    return _length_of(v)


@inlined
def log_growth(state, i):
    """Logarithm of the growth of the tangents of exponent i."""
    return state.logs[i] + math.log(state.grown[i])


@rare
def _keep_shares(state, i, kept, dots):
    """Take ``dots[j]`` times row j, one of those kept, which are orthonormal, from what row i is made of, as from the
    row; one call for all, since few runs ask for it.

    Row i is in parts of its own growth since the start of the block, so that nothing grows that decays. None is made of
    those behind it.
    """
    logs, grown, shares = state.logs, state.grown, state.shares
    mine = state.exponent_of[i]
    for j in range(kept):
        other = state.exponent_of[j]
        if dots[j] == 0.0:
            continue
        part = dots[j] * (grown[mine] / grown[other])
        if logs[mine] != logs[other]:
            part *= math.exp(logs[mine] - logs[other])
        for k in range(other + 1):
            shares[mine, k] -= part * shares[other, k]


@unit(void)
def orthonormalise(functions, tables, state, scratch):
    """Orthonormalise the live tangents of a run, and keep the product of their lengths, as `log_growth` says it.

    ``exponent_of[i]`` is the exponent to which live row i belongs. After an event of deficient rank a row whose
    independent part vanishes is dropped and its exponent marked in ``lost``; directly at an event it waits, as zero, if
    it tells when the event happens, which the next event of the same instant depends on. The first rows stay in the
    span of the symmetries, directions along which nothing ever changes: exactly they would, but chaos amplifies the
    round-off by which they leave it. What goes with a tangent, as ``sooner``, is combined like it.
    """
    if tables.held[state.run[0].mode] > 0:
        keep_to_surfaces(functions, tables, state, scratch)
    symmetries, whole = tables.symmetries, scratch.whole
    run, vectors, exponent_of, lost = state.run[0], state.vectors, state.exponent_of, state.lost
    logs, grown, sooner = state.logs, state.grown, state.sooner
    n = vectors.shape[1]
    live = run.live
    for i in range(symmetries.shape[0]):
        _project(vectors[i], symmetries, scratch.image)
    dots = scratch.image
    kept = 0
    growth = 1.0
    waiting = 0
    for i in range(live):
        before = 0.0
        early = sooner[i]
        told = abs(early)
        for a in range(n):
            before += vectors[i, a] * vectors[i, a]
            whole[a] = vectors[i, a]
        length = before
        checked = run.rank_check >= CHECKED
        image = _by_size(vectors[i], state.span) if checked else 0.0
        for _ in range(2 if kept > 0 else 0):
            for j in range(kept):
                dot = 0.0
                for a in range(n):
                    dot += vectors[j, a] * vectors[i, a]
                for a in range(n):
                    vectors[i, a] -= dot * vectors[j, a]
                early -= dot * sooner[j]
                told += abs(dot * sooner[j])
                dots[j] = dot
            if state.shares.shape[0] > 0:
                _keep_shares(state, i, kept, dots)
            length = 0.0
            for a in range(n):
                length += vectors[i, a] * vectors[i, a]
            if length > TANGENTS.once * before:
                break
        if length > TANGENTS.graded * before and TANGENTS.squares < length < 1.0 / TANGENTS.squares:
            length = math.sqrt(length)
        else:
            length = _left_of(whole, vectors, kept, vectors[i])
        if length == 0.0 or (checked and _by_size(vectors[i], state.span) <= TANGENTS.rank**2 * image):
            if run.rank_check != AT_EVENT or abs(early) <= TANGENTS.rank * told:
                lost[exponent_of[i]] = 1
                continue
            waiting = CHECKED
            exponent_of[kept] = exponent_of[i]
            for a in range(n):
                vectors[kept, a] = 0.0
            sooner[kept] = early
            kept += 1
            continue
        shorter = 1.0 / length
        growth = max(growth, length, shorter)
        exponent = exponent_of[i]
        grown[exponent] *= length
        if not 1.0 / TANGENTS.most_grown < grown[exponent] < TANGENTS.most_grown:
            logs[exponent] += math.log(grown[exponent])
            grown[exponent] = 1.0
        exponent_of[kept] = exponent_of[i]
        for a in range(n):
            vectors[kept, a] = vectors[i, a] * shorter
        sooner[kept] = early * shorter
        kept += 1
    run.live = kept
    run.rank_check = waiting
    run.qr_since = 0
    if growth > TANGENTS.steep:
        run.qr_wait = 0
    elif growth > TANGENTS.often:
        run.qr_wait = max(run.qr_wait // 2, min(run.qr_wait, 1))
    elif growth < TANGENTS.seldom:
        run.qr_wait = min(run.qr_wait * 2, TANGENTS.longest_wait)


@rare
def begin_tangents(functions, tables, settings, state, scratch):
    """Put tangents into the freedom that the mode leaves in which a run begins, or its averages do.

    What they lose by it is no growth: tangents in general position would bring it into every exponent.
    """
    run = state.run[0]
    if run.steps > 0 or run.live == 0:
        return
    holds = tables.held[run.mode] > 0
    if settings.orthonormalise == 0:
        if holds:
            keep_to_surfaces(functions, tables, state, scratch)
        return
    for i in range(tables.constrained.shape[1]):
        holds = holds or tables.constrained[run.mode, i] == 1
    if holds:
        wait = run.qr_wait
        orthonormalise(functions, tables, state, scratch)
        run.qr_wait = wait
        state.logs[:] = 0.0
        state.grown[:] = 1.0
    else:
        run.rank_check = 0
