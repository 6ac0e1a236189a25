"""Dense linear systems of a few unknowns, solved in place."""

import math

from chaosdrill.engine.jit import inner

DEPENDENT = 1e-11
"""Pivot, where the largest entry of a row is 1, that is round-off: entries are known to about 1e-13 at best."""


@inner
def solve(a, rows, size, order, weights):
    """Solve A u = b by Gaussian elimination with partial pivoting and scaled rows; returns the rank of A.

    ``a`` holds A in its first ``rows`` rows and ``size`` columns, right-hand sides behind; they are replaced by the
    solutions, the k-th unknown in row ``order[k]``; ``order`` has room for ``rows + size`` numbers, rows >= size. An
    unknown whose column depends on those before it is left free by the equations: it is 0 in the solution, and
    equations that depend on others are taken to hold with them. What counts as nothing goes by ``weights``, the inverse
    sizes of the unknowns. The rank is 0 where an entry is no number.
    """
    columns = a.shape[1]
    row_of = order[rows:]
    for i in range(rows):
        largest = 0.0
        for k in range(size):
            a[i, k] /= weights[k]
            largest = max(largest, abs(a[i, k]))
            if not math.isfinite(a[i, k]):
                return 0
        if largest > 0.0:
            for k in range(columns):
                a[i, k] /= largest
        order[i] = i
    rank = 0
    for k in range(size):
        row_of[k] = -1
        best = rank
        for i in range(rank + 1, rows):
            if abs(a[order[i], k]) > abs(a[order[best], k]):
                best = i
        if rank == rows or not abs(a[order[best], k]) > DEPENDENT:
            continue
        order[rank], order[best] = order[best], order[rank]
        row = order[rank]
        pivot = a[row, k]
        rank += 1
        row_of[k] = row
        for i in range(rank, rows):
            other = order[i]
            factor = a[other, k] / pivot
            if factor != 0.0:
                for m in range(k + 1, columns):
                    a[other, m] -= factor * a[row, m]
    for right in range(size, columns):
        for k in range(size - 1, -1, -1):
            row = row_of[k]
            if row >= 0:
                total = a[row, right]
                for m in range(k + 1, size):
                    if row_of[m] >= 0:
                        total -= a[row, m] * a[row_of[m], right]
                a[row, right] = total / a[row, k]
    unused = rank
    for k in range(size):
        if row_of[k] < 0:
            row_of[k] = order[unused]
            unused += 1
            for right in range(size, columns):
                a[row_of[k], right] = 0.0
    for k in range(size):
        order[k] = row_of[k]
        for right in range(size, columns):
            a[order[k], right] /= weights[k]
    return rank
