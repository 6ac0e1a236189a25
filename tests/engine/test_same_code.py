"""A function is the same machine code whatever was compiled before it; else a rerun may differ in the last bit."""

import math

from numba import float64

from chaosdrill.engine.jit import compiled, inner

MATRIX = float64[:, ::1]


def caller_of(helper):
    def total(matrix):
        result = 0.0
        for row in range(matrix.shape[0]):
            result += helper(matrix[row]) * helper(matrix[row - 1]) + helper(matrix[row // 2])
        return result + helper(matrix[0]) / helper(matrix[1])

    return total


def weigh(values):
    result = 0.0
    for k in range(values.size // 4):
        a, b, c, d = values[4 * k], values[4 * k + 1], values[4 * k + 2], values[4 * k + 3]
        values[4 * k], values[4 * k + 1], values[4 * k + 2], values[4 * k + 3] = a * a, b * b, c * c, d * d
        result += a + b + c + d
        for other in range(k):
            result += math.sin(values[other] * a) - math.cos(values[other] * b) + math.exp(c) * math.atan2(d, a)
            values[other] = math.tanh(result) - math.log1p(a * a) + math.hypot(b, c)
        if result > 1e3:
            result = weigh_again(result, a)
    return result


@inner
def weigh_again(total, value):
    return total / (1.0 + value * value)


def other_caller_of(helper):
    def total(matrix):
        return helper(matrix[0]) - helper(matrix[1])

    return total


def test_the_same_helper_after_another_caller():
    first = compiled(float64(MATRIX))(caller_of(inner(weigh)))
    assert len(first.code) > 1000
    shared = inner(weigh)
    assert compiled(float64(MATRIX))(other_caller_of(shared)).code != first.code
    assert compiled(float64(MATRIX))(caller_of(shared)).code == first.code
