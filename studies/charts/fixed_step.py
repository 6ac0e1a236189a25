"""The drill computed again, by a program that shares nothing with the package but the equations.

Fixed Runge-Kutta steps; where one leads beyond the stop, beyond the friction limit or to a negative speed of the rock,
its part up to there is found by bisection. The exit speed of an impact is bisected from the energy law that it obeys,
not taken from the closed form. No tangents: growth is that of the distance between two neighbours.
"""

import math

import numba
import numpy as np
from numpy.typing import NDArray

STICK, SLIP = 0, 1
A, B, XI, ETA, EPS, MU, G, R, LAM, PHI, K = range(11)
NAMES = ("a", "b", "xi", "eta", "eps", "mu", "g", "r", "lam", "phi", "k")
ESCAPES = 25.0
"""Speed of the rock beyond which friction no longer stops it."""

_STEPS = 400
"""Steps a forcing period."""


def parameters(**values: float) -> NDArray[np.float64]:
    """Return the parameters in the order of ``NAMES``."""
    return np.array([values[name] for name in NAMES])


@numba.njit
def _rates(slips, t, x, p, out):
    force = x[0] + 2 * p[XI] * (x[1] - x[2])
    out[0] = x[1] - x[2]
    out[1] = p[B] + p[A] * math.cos(p[ETA] * t + p[PHI]) - force
    out[2] = p[EPS] * (force - p[MU] - (1 - p[MU]) * math.exp(-p[G] * x[2])) if slips else 0.0
    out[3] = x[2]


@numba.njit
def _step(slips, t, x, h, p, k, y):
    """Put into ``y`` the state a step later."""
    _rates(slips, t, x, p, k[0])
    for j in range(3):
        part = h if j == 2 else 0.5 * h
        for i in range(4):
            y[i] = x[i] + part * k[j, i]
        _rates(slips, t + part, y, p, k[j + 1])
    for i in range(4):
        y[i] = x[i] + h / 6 * (k[0, i] + 2 * k[1, i] + 2 * k[2, i] + k[3, i])


@numba.njit
def _beyond(slips, x, p):
    """Whether a state lies beyond what ends its mode, and what that is: 0 nothing, 1 the stop, 2 the change of mode."""
    if x[0] > p[R]:
        return 1
    if slips:
        return 2 if x[2] < 0.0 else 0
    return 2 if x[0] + 2 * p[XI] * x[1] > 1.0 else 0


@numba.njit
def _loss(v, lam):
    return v / lam - math.log1p(lam * v) / lam**2


@numba.njit
def _exit_speed(v, lam):
    """The speed s > 0 for which the law's function takes the same value at -s as at v."""
    low, high = 0.0, min(v, 1.0 / lam)
    for _ in range(60):
        s = 0.5 * (low + high)
        if _loss(-s, lam) < _loss(v, lam):
            low = s
        else:
            high = s
    return 0.5 * (low + high)


@numba.njit
def _peak_force(v, p):
    """Largest force of a linear spring with Hunt-Crossley damping, the rock held: found on a grid of speeds."""
    peak = 0.0
    for i in range(200):
        speed = v * i / 200
        depth = math.sqrt(max(0.0, 2 * (_loss(v, p[LAM]) - _loss(speed, p[LAM])) / p[K]))
        peak = max(peak, p[K] * depth * (1 + p[LAM] * speed))
    return peak


@numba.njit
def _hit(slips, x, p):
    """Speeds after an impact, in place; whether the rock slips then."""
    v = x[1] - x[2]
    s = _exit_speed(v, p[LAM])
    if not slips and _peak_force(v, p) <= 1.0:
        x[1] = -s
        return False
    x[1] = (p[EPS] * x[1] + x[2] - s) / (1 + p[EPS])
    x[2] = x[1] + s
    return True


@numba.njit
def _period(slips, x, p, k, y, z):
    """One forcing period from phase 0 on, in place; returns whether the rock slips then, and the impacts."""
    period = 2 * math.pi / p[ETA]
    h = period / _STEPS
    impacts = 0
    for i in range(_STEPS):
        t, left = i * h, h
        for _ in range(50):
            _step(slips, t, x, left, p, k, y)
            if _beyond(slips, y, p) == 0:
                x[:] = y
                break
            low, high = 0.0, left
            z[:] = y
            for _ in range(52):
                middle = 0.5 * (low + high)
                _step(slips, t, x, middle, p, k, y)
                if _beyond(slips, y, p) == 0:
                    low = middle
                else:
                    high = middle
                    z[:] = y
            what = _beyond(slips, z, p)
            x[:] = z
            t += high
            left -= high
            if what == 1:
                x[0] = p[R]
                if x[1] > x[2]:
                    slips = _hit(slips, x, p)
                    impacts += 1
            else:
                slips = not slips
                if not slips:
                    x[2] = 0.0
            if left <= 0.0:
                break
    return slips, impacts


@numba.njit
def run(p, start, transient, periods, distance):
    """Run from a start at rest of the rock, forget the transient, and measure.

    Returns
    -------
    rate : float
        Mean progression per unit of time; NaN if the drill ran away.
    growth : ndarray, shape (periods,)
        Logarithm of what the distance of a neighbour grew by in each period.
    strobes : ndarray, shape (periods, 3)
        States at phase 0.
    impacts : float
        Impacts a period.
    """
    x, near = np.zeros(4), np.zeros(4)
    x[:3] = start
    k, y, z = np.zeros((4, 4)), np.zeros(4), np.zeros(4)
    growth, strobes = np.zeros(periods), np.zeros((periods, 3))
    slips = x[2] > 0.0
    for _ in range(transient):
        slips, _n = _period(slips, x, p, k, y, z)
        if x[2] > ESCAPES:
            return math.nan, growth, strobes, 0.0
    begin = x[3]
    near[:] = x
    near[0] -= distance
    near_slips = slips
    hits = 0
    for i in range(periods):
        slips, n = _period(slips, x, p, k, y, z)
        hits += n
        near_slips, _n = _period(near_slips, near, p, k, y, z)
        if x[2] > ESCAPES:
            return math.nan, growth, strobes, 0.0
        strobes[i] = x[:3]
        off = near[:3] - x[:3]
        apart = max(math.sqrt(np.sum(off**2)), 1e-15)
        growth[i] = math.log(apart / distance)
        near[:3] = x[:3] + off * (distance / apart)
        if near_slips != slips:
            near_slips = slips
            near[2] = x[2]
    return (x[3] - begin) / (periods * 2 * math.pi / p[ETA]), growth, strobes, hits / periods


def period_of(strobes: NDArray[np.float64], longest: int, close: float = 1e-5) -> int:
    """Return the period of the last strobe points, 0 if they do not come back."""
    for period in range(1, longest + 1):
        if np.abs(strobes[period:] - strobes[:-period])[-2 * longest :].max() < close:
            return period
    return 0
