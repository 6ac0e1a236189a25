"""The special functions of the contact laws in extended precision, from other formulas than the compiled ones use."""

from typing import Any

import mpmath

GUARD_DIGITS = 20


def _work(v: Any, lam: Any) -> Any:
    """Digits for a contact of damping lam entered at speed v: the closed forms cancel as lam v goes to zero."""
    x = abs(lam * v)
    lost = 0 if x == 0 or x >= 1 else int(-mpmath.log10(x))
    return mpmath.workdps(2 * mpmath.mp.dps + GUARD_DIGITS + 4 * lost)


def _potential(v: Any, lam: Any) -> Any:
    return v / lam - mpmath.log(1 + lam * v) / lam**2


def hunt_crossley_exit(v: Any, lam: Any) -> Any:
    """Exit speed by the principal branch of Lambert's function."""
    with _work(v, lam):
        x = 1 + lam * v
        speed = v if lam * v == 0 else (1 + mpmath.lambertw(-x * mpmath.exp(-x)).real) / lam
    return +speed


def hunt_crossley_peak(v: Any, lam: Any, n: Any, k: Any) -> Any:
    """Largest force of the contact, by bisection for the speed at the peak; 20 digits, as only conditions name it."""
    if v <= 0:
        return mpmath.mpf(0)
    with mpmath.workdps(mpmath.mp.dps + GUARD_DIGITS):
        low, high = mpmath.mpf(0), +v
        for _ in range(70):
            middle = (low + high) / 2
            gained = lam * (n + 1) * (_potential(v, lam) - _potential(middle, lam))
            low, high = (middle, high) if n * middle < gained else (low, middle)
        depth = ((n + 1) * (_potential(v, lam) - _potential(low, lam)) / k) ** (1 / (n + 1))
        return k * depth**n * (1 + lam * low)


def hunt_crossley_duration(v: Any, lam: Any, n: Any, k: Any) -> Any:
    """Duration of the contact, the integral of dx/speed on both branches with x = depth (1 - s^2)."""
    with mpmath.workdps(mpmath.mp.dps + GUARD_DIGITS):
        whole = _potential(v, lam)
        depth = ((n + 1) * whole / k) ** (1 / (n + 1))

        def slowness(s: Any) -> Any:
            left = whole * (-mpmath.expm1((n + 1) * mpmath.log1p(-s * s)) if s < 1 else 1)
            return 2 * depth * s * (1 / _speed(left, lam, 1) + 1 / _speed(left, lam, -1))

        return mpmath.quad(slowness, [0, 1])


def _speed(left: Any, lam: Any, way: int) -> Any:
    """Speed on the way in (1) or out (-1) at which G(way speed) = left, by Newton's method."""
    digits = mpmath.mp.dps
    speed = mpmath.sqrt(2 * left)
    if lam * speed < mpmath.mpf(10) ** (-digits // 2):
        return speed * (1 + way * lam * speed / 3)
    if way < 0:
        speed = min(speed, -mpmath.expm1(-1 - lam * lam * left) / lam)
    with _work(speed, lam):
        for _ in range(100):
            change = (_potential(way * speed, lam) - left) * (1 + way * lam * speed) / speed
            speed -= change
            if abs(change) <= speed * mpmath.mpf(10) ** -digits:
                return speed
    raise ArithmeticError("no speed of the contact found")


def positive_power(d: Any, n: Any) -> Any:
    """max(d, 0)^n."""
    return d**n if d > 0 else mpmath.mpf(0)


EXACT = {
    function.__name__: function
    for function in (hunt_crossley_exit, hunt_crossley_peak, hunt_crossley_duration, positive_power)
}
"""By name, those that can be evaluated in many digits."""
