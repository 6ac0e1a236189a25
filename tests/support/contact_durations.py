"""Duration of a Hunt-Crossley contact and its Taylor coefficients in many digits, complex speeds by Lambert's W."""

from functools import cache
from itertools import pairwise

import mpmath

DIGITS = 35
RADIUS, POINTS = mpmath.mpf("0.01"), 14
NODES, MORE = (mpmath.calculus.quadrature.GaussLegendre(mpmath.mp).calc_nodes(degree, 150) for degree in (3, 4))
PANELS = [0, mpmath.mpf("0.2"), mpmath.mpf("0.5"), mpmath.mpf("0.9"), mpmath.mpf("1.25"), mpmath.pi / 2]


def lost(v, lam):
    """Digits that cancel in lam v - ln(1 + lam v)."""
    return 0 if lam == 0 else max(0, -2 * int(mpmath.log10(lam * v)))


def duration(v, lam, n, k):
    """The integral of dx/speed on the way in and on the way out, with the depth x = x_m cos^2(theta)."""
    lam, n, k = map(mpmath.mpf, (lam, n, k))
    motion = v * v / 2 if lam == 0 else (lam * v - mpmath.log(1 + lam * v)) / lam**2
    deepest = ((n + 1) * motion / k) ** (1 / (n + 1))

    def slowness(left):
        if lam == 0:
            return 2 / mpmath.sqrt(2 * left)
        root = -mpmath.exp(-1 - lam**2 * left)
        return -lam / (1 + mpmath.lambertw(root, -1)) + lam / (1 + mpmath.lambertw(root))

    total = mpmath.mpf(0)
    for low, high in pairwise(PANELS):
        for x, weight in NODES if abs(lam * v) < 10 else MORE:
            angle = (low + high + (high - low) * x) / 2
            left = motion * (1 - mpmath.cos(angle) ** (2 * n + 2))
            total += weight * (high - low) / 2 * mpmath.sin(2 * angle) * slowness(left)
    return deepest * total


@cache
def taylor(v, lam, n, k, order=8):
    """Coefficients of the duration by powers of the speed less v, from Cauchy's integral."""
    with mpmath.workdps(DIGITS + lost(v, lam)):
        half = POINTS // 2
        turns = [mpmath.expjpi(mpmath.mpf(j) / half) for j in range(half + 1)]
        values = [duration(v * (1 + RADIUS * turn), lam, n, k) for turn in turns]
        # the values on the other half of the circle are conjugate
        weights = [1, *[2] * (half - 1), 1]
        sums = [
            mpmath.fsum(w * mpmath.re(f / turn**m) for w, f, turn in zip(weights, values, turns, strict=True))
            for m in range(order + 1)
        ]
        return [total / (POINTS * (RADIUS * v) ** m) for m, total in enumerate(sums)]
