"""Coefficients of the Radau IIA methods of 3, 5 and 7 stages, of orders 5, 9 and 13.

Hairer, Wanner, Solving Ordinary Differential Equations II, 2nd ed. 1996, section IV.5 (doi:10.1007/978-3-642-05221-7):
the motion over a step is the polynomial that begins at the state and satisfies the equation at the nodes, the zeros of
the difference of two Legendre polynomials. All follows from the nodes here, by the derivatives of the polynomials that
are 1 at one of them and 0 at the others.
"""

from fractions import Fraction
from math import comb, factorial

import numpy as np
from numpy.polynomial import legendre

from chaosdrill.engine.dop853_tables import inverse

MOST_STAGES = 7

DEGREE = MOST_STAGES + 1
"""Degree of the polynomial whose slope at the start is that of the motion as well."""

_NEAR = 1e-9
"""More than nodes in doubles are off by, and less than they are apart by."""


def _zero(coefficients: list[Fraction], low: float, high: float) -> float:
    """The double next to the only zero of a polynomial between two others; the first coefficient is the constant."""

    def value(place: float) -> Fraction:
        total = Fraction(0)
        for one in reversed(coefficients):
            total = total * Fraction(place) + one
        return total

    up = value(high) > 0
    while low < (middle := 0.5 * (low + high)) < high:
        low, high = (low, middle) if (value(middle) > 0) == up else (middle, high)
    return high


def _nodes(stages: int) -> np.ndarray:
    """0, then the nodes on ]0, 1]: zeros of the difference of two Legendre polynomials of 2 u - 1."""
    wanted = [Fraction(0)] * (stages + 1)
    for degree in (stages - 1, stages):
        for k in range(degree + 1):
            wanted[k] += (-1) ** (k + stages) * comb(degree, k) * comb(degree + k, k)
    near = 0.5 + 0.5 * np.real(legendre.legroots([*[0.0] * (stages - 1), -1.0, 1.0]))
    inner = [_zero(wanted, float(u) - _NEAR, float(u) + _NEAR) for u in near[:-1]]
    return np.array([0.0, *inner, 1.0], dtype=np.longdouble)


def _differentiation(nodes: np.ndarray) -> np.ndarray:
    """Entry (i, j): derivative at node i of the polynomial that is 1 at node j and 0 at the others."""
    gaps = nodes[:, None] - nodes
    np.fill_diagonal(gaps, 1.0)
    products = gaps.prod(axis=1)
    slopes = products[:, None] / products / gaps
    np.fill_diagonal(slopes, 0.0)
    # what stays constant has no derivative, to the last digit
    np.fill_diagonal(slopes, -slopes.sum(axis=1))
    return slopes


def _powers(nodes: np.ndarray) -> np.ndarray:
    """Row k - 1: coefficients of u**k in the polynomials of the nodes beyond 0; last, of the one of slope 1 at 0."""
    stages = nodes.size - 1
    table = np.zeros((stages + 1, stages + 1))
    for j in range(1, stages + 1):
        others = np.delete(nodes, j)
        table[:stages, j - 1] = np.poly(others)[::-1][1:] / np.prod(nodes[j] - others)
    table[:, -1] = np.poly(nodes)[::-1][1:] / np.prod(-nodes[1:])
    return table


def _pivot(stages: int) -> float:
    """The real one of the eigenvalues of the matrix of weights: 1 over the zero of the Padé approximation's divisor."""
    divisor = [
        Fraction((-1) ** k * comb(stages, k) * factorial(2 * stages - 1 - k), factorial(2 * stages - 1))
        for k in range(stages + 1)
    ]
    return 1.0 / _zero(divisor, 0.0, 2.0 * stages)


NODES = np.zeros((3, MOST_STAGES + 1))
"""Times in parts of the step: of the start, then of the stages; first index: 3, 5, 7 stages."""

SLOPES = np.zeros((3, MOST_STAGES + 1, MOST_STAGES + 1))
"""Derivatives at these times of a polynomial that is given by its values there, in units of 1 over the step."""

WEIGHTS_OF_RATES = np.zeros((3, MOST_STAGES, MOST_STAGES))
"""From rates at the stages to increments there."""

AT_START = np.zeros((3, MOST_STAGES))
"""Values at the start of the polynomials through the stages alone that are 1 at one of them and 0 at the others."""

POWERS = np.zeros((3, DEGREE, DEGREE))
"""From increments at the stages, and an excess of the slope at the start, to coefficients of powers of u from 1 on."""

PIVOT = np.zeros(3)

BETWEEN = np.zeros(3)
"""Largest value of the polynomials of leading coefficient 1 that vanish at the stages."""

for _i, _stages in enumerate((3, 5, 7)):
    _n = _nodes(_stages)
    _d = _differentiation(_n)
    NODES[_i, : _stages + 1] = _n
    SLOPES[_i, : _stages + 1, : _stages + 1] = _d
    _w = inverse(_d[1:, 1:])
    WEIGHTS_OF_RATES[_i, :_stages, :_stages] = _w
    AT_START[_i, :_stages] = _d[0, 1:] @ _w
    _p = _powers(_n)
    POWERS[_i, : _stages + 1, :_stages] = _p[:, :-1]
    POWERS[_i, : _stages + 1, DEGREE - 1] = _p[:, -1]
    PIVOT[_i] = _pivot(_stages)
    BETWEEN[_i] = np.abs((np.linspace(0, 1, 1001)[:, None] - _n[1:]).prod(axis=1)).max()
