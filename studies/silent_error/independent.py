"""An impact oscillator computed again, by a program that shares nothing with the package but the equation.

Between impacts the oscillator x'' = -x - 2 zeta x' + cos(omega t) is linear: its forced part is known and its free part
is a damped rotation, so that the flow here is exact and only the times of the impacts are found by iteration.
"""

import math

import numba
import numpy as np
from numpy.typing import NDArray

ZETA, OMEGA, WALL, RESTITUTION = 0.05, 2.5, 0.3, 0.8
PERIOD = 2 * math.pi / OMEGA
_CHECKS = 200  # looks at the wall per forcing period; the extreme of the path between two looks is looked at too
_ROTATION = math.sqrt(1 - ZETA**2)
_DENOMINATOR = (1 - OMEGA**2) ** 2 + (2 * ZETA * OMEGA) ** 2
_COS = (1 - OMEGA**2) / _DENOMINATOR
_SIN = 2 * ZETA * OMEGA / _DENOMINATOR


@numba.njit
def _flow(x: float, v: float, t: float, h: float) -> tuple[float, float]:
    """Return position and speed after a free flight of length ``h`` that starts at time ``t``."""
    c, s = math.cos(OMEGA * t), math.sin(OMEGA * t)
    p, q = x - (_COS * c + _SIN * s), v - OMEGA * (_SIN * c - _COS * s)
    decay, cd, sd = math.exp(-ZETA * h), math.cos(_ROTATION * h), math.sin(_ROTATION * h) / _ROTATION
    c, s = math.cos(OMEGA * (t + h)), math.sin(OMEGA * (t + h))
    return (
        decay * ((cd + ZETA * sd) * p + sd * q) + _COS * c + _SIN * s,
        decay * (-sd * p + (cd - ZETA * sd) * q) + OMEGA * (_SIN * c - _COS * s),
    )


@numba.njit
def _root(x: float, v: float, t: float, high: float, of_speed: bool) -> float:
    """Return by bisection the flight time below ``high`` to the wall or, with ``of_speed``, to where the speed ends."""
    low = 0.0
    while True:
        middle = 0.5 * (low + high)
        if middle in (low, high):
            return high
        xm, vm = _flow(x, v, t, middle)
        beyond = vm <= 0 if of_speed else xm >= WALL
        low, high = (low, middle) if beyond else (middle, high)


@numba.njit
def _period(x: float, v: float) -> tuple[float, float, int]:
    """Return position and speed one forcing period later, from phase zero, and the number of impacts on the way."""
    impacts = 0
    for k in range(_CHECKS):
        t, end = PERIOD * k / _CHECKS, PERIOD * (k + 1) / _CHECKS
        while True:
            xe, ve = _flow(x, v, t, end - t)
            reach = end - t
            if v > 0 and ve < 0 and xe < WALL:
                reach = _root(x, v, t, end - t, True)
                if _flow(x, v, t, reach)[0] < WALL:
                    reach = end - t
            if _flow(x, v, t, reach)[0] < WALL:
                x, v = xe, ve
                break
            hit = _root(x, v, t, reach, False)
            v = -RESTITUTION * _flow(x, v, t, hit)[1]
            x, t = WALL, t + hit
            impacts += 1
    return x, v, impacts


@numba.njit
def two_trajectories(
    periods: int, transient: int, blocks: int, distance: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Follow two neighbours, bring them back to ``distance`` every period, and sum the logarithm of what they gained.

    Returns
    -------
    growth, impacts : ndarray, shape (blocks,)
        Mean growth rate (the largest exponent) and impacts per unit of time in each block.
    """
    x, v = 0.0, 0.3
    for _ in range(transient):
        x, v, _n = _period(x, v)
    growth, impacts = np.zeros(blocks), np.zeros(blocks)
    xn, vn = x + distance, v
    each = periods // blocks
    for block in range(blocks):
        for _ in range(each):
            x, v, count = _period(x, v)
            xn, vn, _n = _period(xn, vn)
            apart = math.hypot(xn - x, vn - v)
            growth[block] += math.log(apart / distance)
            xn, vn = x + (xn - x) * distance / apart, v + (vn - v) * distance / apart
            impacts[block] += count
    return growth / (each * PERIOD), impacts / (each * PERIOD)


def events_left_out(periods: int, blocks: int) -> NDArray[np.float64]:
    """Return the running mean of both exponents when the tangents ignore the impacts, shape (blocks, 2).

    This is what comes out of an integrator that resets the state at an event and carries its variational equation on
    as if nothing had happened. That equation is the same on every flight and never sees the trajectory.
    """
    one_period = np.array([_free_tangent(1.0, 0.0), _free_tangent(0.0, 1.0)]).T
    frame, sums, history = np.eye(2), np.zeros(2), np.empty((blocks, 2))
    each = periods // blocks
    for block in range(blocks):
        for _ in range(each):
            frame, triangle = np.linalg.qr(one_period @ frame)
            sums += np.log(np.abs(np.diag(triangle)))
        history[block] = sums / ((block + 1) * each * PERIOD)
    return history


def _free_tangent(x: float, v: float) -> tuple[float, float]:
    forced = _flow(0.0, 0.0, 0.0, PERIOD)
    moved = _flow(x, v, 0.0, PERIOD)
    return moved[0] - forced[0], moved[1] - forced[1]
