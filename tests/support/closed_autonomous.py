"""Two cycles without a clock: stick-slip on a belt, and the rimless wheel's gait."""

from dataclasses import dataclass
from math import atan2, cos, pi, sin, sqrt

import mpmath


@dataclass(frozen=True)
class BeltCycle:
    """Stick-slip on a belt of speed v, D = F_s - F_k: it slips from x = F_s until it sticks at x = F_k - D.

    In slip x = F_k + D cos t + v sin t, until the speed is v again. Multipliers 1 and 0. Source: Leine and Nijmeijer
    2004, doi:10.1007/978-3-540-44398-8.
    """

    period: float
    release: tuple[float, float]
    stick: tuple[float, float]


def belt(speed: float, static: float, kinetic: float) -> BeltCycle:
    """The cycle that sticks; states (x, v) at release and at the begin of stick."""
    drop = static - kinetic
    slip = 2 * pi - 2 * atan2(drop, speed)
    return BeltCycle(2 * drop / speed + slip, (static, speed), (kinetic - drop, speed))


@dataclass(frozen=True)
class Gait:
    """Rolling of the rimless wheel: angular velocities after and before a step, period, multipliers.

    Energy is kept from th = gamma - alpha to gamma + alpha and a step multiplies the velocity by cos 2 alpha, so that
    the velocity before it is 2 sqrt(sin gamma sin alpha)/sin 2 alpha. With E = 1 + m the energy, m > 0, the period is
    sqrt(2/m) [F((gamma + alpha)/2 | -2/m) - F((gamma - alpha)/2 | -2/m)], F the elliptic integral of the first kind.
    Source: McGeer 1990, doi:10.1177/027836499000900206.
    """

    after: float
    before: float
    period: float
    multipliers: tuple[float, float]


def gait(alpha: float, gamma: float) -> Gait | None:
    """The gait; None if the wheel does not get over the top."""
    before = 2 * sqrt(sin(gamma) * sin(alpha)) / sin(2 * alpha)
    after = before * cos(2 * alpha)
    m = after**2 / 2 + cos(gamma - alpha) - 1
    if m <= 0:
        return None
    way = mpmath.ellipf((gamma + alpha) / 2, -2 / m) - mpmath.ellipf((gamma - alpha) / 2, -2 / m)
    return Gait(after, before, float(sqrt(2 / m) * way), (1.0, cos(2 * alpha) ** 2))
