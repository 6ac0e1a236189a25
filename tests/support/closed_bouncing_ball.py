"""One bounce in n periods of the moving floor, in closed form, without the high-bounce approximation.

    x'' = -g;   at x = a sin(w t), with the floor's speed U = a w cos(w t):  v := U - e (v - U)

The flight begins and ends at the same height, with the speeds +-g T/2, T = 2 pi n/w. The law then says
U = (1 - e)/(1 + e) g T/2, and with G = a w^2/g, q = pi n (1 - e)/(1 + e) the phase w t obeys cos = q/G. There are two
such phases from G = q on (a fold, multipliers 1 and e^2). The trace of the map over n periods is
1 + e^2 - (1 + e)^2 G sin(w t), its determinant e^2. The orbit with sin > 0 doubles at
G^2 = q^2 + [2 (1 + e^2)/(1 + e)^2]^2. Source: Luck and Mehta 1993, doi:10.1103/PhysRevE.48.3988.
"""

from dataclasses import dataclass
from math import acos, pi, sin


@dataclass(frozen=True)
class Bounce:
    """Phase w t of the impact in (-pi, pi), the ball's speed after it, and trace and determinant."""

    phase: float
    speed: float
    trace: float
    determinant: float


def bounces(a: float, w: float, e: float, g: float = 1.0, n: int = 1) -> list[Bounce]:
    """The orbits with one bounce in n periods: that with sin > 0, and its unstable partner."""
    force, q = a * w**2 / g, pi * n * (1 - e) / (1 + e)
    if force < q:
        return []
    return [_bounce(sign * acos(q / force), a, w, e, g, n) for sign in (1, -1)]


def _bounce(phase: float, a: float, w: float, e: float, g: float, n: int) -> Bounce:
    period = 2 * pi * n / w
    trace = 1 + e**2 - (1 + e) ** 2 * a * w**2 / g * sin(phase)
    return Bounce(phase, g * period / 2, trace, e**2)
