"""Dense linear systems of a few unknowns, solved in place."""

from chaosdrill.engine.jit import inner


@inner
def solve(a, size, order):
    """Solve A u = b by Gaussian elimination with partial pivoting and scaled rows.

    ``a`` holds A in its first ``size`` rows and columns, right-hand sides behind; they are replaced by the solutions,
    the k-th unknown in row ``order[k]``. Returns the smallest pivot over the largest, 0 for a singular matrix.
    """
    columns = a.shape[1]
    for i in range(size):
        largest = 0.0
        for k in range(size):
            largest = max(largest, abs(a[i, k]))
        if not largest > 0.0:
            return 0.0
        for k in range(columns):
            a[i, k] /= largest
        order[i] = i
    smallest = 1e300
    greatest = 0.0
    for k in range(size):
        best = k
        for i in range(k + 1, size):
            if abs(a[order[i], k]) > abs(a[order[best], k]):
                best = i
        order[k], order[best] = order[best], order[k]
        row = order[k]
        pivot = a[row, k]
        smallest = min(smallest, abs(pivot))
        greatest = max(greatest, abs(pivot))
        if not abs(pivot) > 0.0:
            return 0.0
        for i in range(k + 1, size):
            other = order[i]
            factor = a[other, k] / pivot
            if factor != 0.0:
                for m in range(k + 1, columns):
                    a[other, m] -= factor * a[row, m]
    for right in range(size, columns):
        for k in range(size - 1, -1, -1):
            row = order[k]
            total = a[row, right]
            for m in range(k + 1, size):
                total -= a[row, m] * a[order[m], right]
            a[row, right] = total / a[row, k]
    return smallest / greatest
