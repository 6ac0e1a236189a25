"""Polynomials in rows of fixed length, zero beyond their order: all of their terms are added up at once."""

from chaosdrill.engine.jit import inner, reordered, series
from chaosdrill.engine.layout import COLUMNS


@series
def powers(s, out):
    """Powers of s, by their exponents."""
    a = 1.0
    b = s
    c = s * s
    d = c * s
    fourth = c * c
    for k in range(0, COLUMNS, 4):
        out[k] = a
        out[k + 1] = b
        out[k + 2] = c
        out[k + 3] = d
        a *= fourth
        b *= fourth
        c *= fourth
        d *= fourth


@reordered
def value(rows, i, power):
    """Value of row i, from the powers of its argument."""
    total = 0.0
    for k in range(COLUMNS):
        total += rows[i, k] * power[k]
    return total


@reordered
def _rises(row, power):
    total = 0.0
    for k in range(1, COLUMNS):
        total += max(row[k] * power[k], 0.0)
    return total


@reordered
def _falls(row, power):
    total = 0.0
    for k in range(1, COLUMNS):
        total += min(row[k] * power[k], 0.0)
    return total


@inner
def keeps_side(row, power, below):
    """Whether the signs of its terms alone keep a polynomial below (or above) zero up to the argument of the powers."""
    return row[0] + _rises(row, power) < 0.0 if below else row[0] + _falls(row, power) > 0.0
