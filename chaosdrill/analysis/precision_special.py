"""The special functions of the contact laws in extended precision, from other formulas than the compiled ones use."""

from collections.abc import Callable
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


def positive_power(d: Any, n: Any) -> Any:
    """max(d, 0)^n."""
    return d**n if d > 0 else mpmath.mpf(0)


EXACT: dict[str, Callable[..., Any]] = {
    "hunt_crossley_exit": hunt_crossley_exit,
    "hunt_crossley_peak": hunt_crossley_peak,
    "positive_power": positive_power,
}
"""Name of the sympy function -> its evaluation with mpmath."""
