"""Den Hartog's oscillator, its symmetric motion that never sticks, in closed form.

    x'' + x = cos(w t) - S sgn x'

With V = 1/(1 - w^2) and U = tan(pi/(2 w))/w the motion from a maximum x0 at t0 down to -x0, a half period later, is

    x = V cos(w t) + S - S cos(t - t0) - S tan(pi/(2 w)) sin(t - t0),   x0^2 = V^2 - S^2 U^2,
    V cos(w t0) = x0,   V w sin(w t0) = -S tan(pi/(2 w)).

Its speed stays negative if x0 > S h(t) throughout, where h tends to 1/w^2 at the start: there x'' vanishes after the
stop, and the mass begins to stick. A stop multiplies the speed of a neighbour by rho = (w^2 x0 - S)/(w^2 x0 + S), so
that the multipliers are the squares of the eigenvalues of diag(1, rho) times the rotation by pi/w.
Source: Den Hartog 1931, Trans. ASME 53, APM-53-9, 107; Shaw 1986, doi:10.1016/S0022-460X(86)80058-X.
"""

from dataclasses import dataclass
from math import atan2, cos, pi, sin, sqrt, tan

import numpy as np


@dataclass(frozen=True)
class Sliding:
    """Phase w t0 of the maximum in [0, 2 pi), amplitude, multipliers, largest modulus first."""

    phase: float
    amplitude: float
    multipliers: np.ndarray


def sliding(w: float, friction: float) -> Sliding | None:
    """The motion that never sticks; None where it would have to."""
    v, turn = 1 / (1 - w**2), tan(pi / (2 * w))
    square = v**2 - (friction * turn / w) ** 2
    if square <= 0 or sqrt(square) <= friction * slowest(w):
        return None
    top = sqrt(square)
    rho = (w**2 * top - friction) / (w**2 * top + friction)
    c, s = cos(pi / w), sin(pi / w)
    half = np.linalg.eigvals(np.array([[c, s], [-rho * s, rho * c]]).astype(complex))
    multipliers = np.array(sorted(half**2, key=lambda z: (-round(abs(z), 12), -z.imag)))
    return Sliding(atan2(-friction * turn / (v * w), top / v) % (2 * pi), top, multipliers)


def slowest(w: float) -> float:
    """The largest x0/S at which the motion stops on its way: the supremum of Den Hartog's function h."""
    turn = tan(pi / (2 * w))
    t = np.linspace(0, pi / w, 200_002)[1:-1]
    return max(1 / w**2, float(((np.sin(t) + turn * (np.cos(w * t) - np.cos(t))) / (w * np.sin(w * t))).max()))


def sticking_friction(w: float) -> float:
    """The friction force above which the mass begins to stick."""
    v, u = 1 / (1 - w**2), tan(pi / (2 * w)) / w
    return abs(v) / sqrt(u**2 + slowest(w) ** 2)
