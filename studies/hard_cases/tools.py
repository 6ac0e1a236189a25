"""What the hard cases share: how a figure is reported, the tangent map of a stretch of time, a ball in scipy."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

import chaosdrill as cd
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run


@dataclass(frozen=True)
class Finding:
    """One figure of a case.

    Parameters
    ----------
    quantity : str
        What is measured.
    right : float or str
        The closed form, or what theory says.
    ours : float or str
        What the package gives.
    within : float
        Largest distance between the two that passes; relative to ``right`` where that is larger than 1.
    elsewhere : str
        What another program gives, and which; empty where the row only adds to the one above.
    """

    quantity: str
    right: float | str
    ours: float | str
    within: float = 0.0
    elsewhere: str = ""

    @property
    def off(self) -> float:
        """Distance of ``ours`` from ``right``; 0 for equal words and equal infinities, NaN if words differ."""
        if isinstance(self.right, str) or isinstance(self.ours, str):
            return 0.0 if self.right == self.ours else math.nan
        if self.right == self.ours:
            return 0.0
        return abs(self.ours - self.right) / max(1.0, abs(self.right))

    @property
    def holds(self) -> bool:
        """Whether the package's figure is as near as it must be."""
        return self.off <= self.within

    def cells(self) -> list[str]:
        """Return the row of a table; digits beyond the error are not shown."""
        digits = 6 if self.within > 1e-7 else 10
        ours = _below(self.off) if self.right == 0 and self.off > 0 else show(self.ours, digits)
        return [self.quantity, show(self.right, digits), ours, _below(self.off), self.elsewhere]


def show(value: float | str, digits: int = 6) -> str:
    """Return a number for a table: this number of significant digits, a true minus sign, infinity by its symbol."""
    if isinstance(value, str):
        return value
    if math.isinf(value):
        return "−∞" if value < 0 else "∞"
    return "0" if value == 0 else f"{value:.{digits}g}".replace("-", "−")


def _below(off: float) -> str:
    """The decade above an error: what remains of it is no property of the method but of the machine."""
    if off == 0:
        return "0"
    return "?" if math.isnan(off) else f"< 1e{math.floor(math.log10(off)) + 1}"


def tangent_map(system: "cd.HybridSystem", duration: float, **numerics: object) -> tuple[np.ndarray, np.ndarray, "Run"]:
    """Return the state after ``duration`` (n,), its derivative by the initial one (n, n), and the run."""
    run = Run(system, duration, Numerics(**numerics), tangents=np.eye(len(system.states)), orthonormalise=False)
    outcome, _ = run.advance(1)
    if outcome != cd.Outcome.OK:
        raise RuntimeError(f"{system.name}: the run ended as {outcome.name.lower()}")
    return run.x.copy(), run.vectors.T.copy(), run


def event_names(run: object) -> list[str]:
    """Return the names of a trajectory's events in their order."""
    names = run["event_kind"].attrs["flag_meanings"].split()
    return [names[code] for code in run["event_kind"].values]


def listed(values: Iterable[float]) -> str:
    """Return numbers as a list for a table."""
    return ", ".join(show(float(value), 4) for value in values)


def scipy_ball(e: float, most: int) -> tuple[list[float], float]:
    """Bounce a ball (gravity 1, upward speed 1) with scipy's terminal events, as its documentation shows.

    Returns
    -------
    times : list of float
        Bounces found, at most ``most``.
    height : float
        Where the ball is at time 5.
    """
    from scipy.integrate import solve_ivp

    def floor(t: float, s: np.ndarray) -> float:
        return s[0]

    floor.terminal, floor.direction = True, -1
    time, state, times = 0.0, np.array([0.0, 1.0]), []
    while time < 5.0 and len(times) < most:
        leg = solve_ivp(
            lambda t, s: [s[1], -1.0], (time, 5.0), state, method="DOP853", rtol=1e-12, atol=1e-14, events=floor
        )
        time, state = leg.t[-1], leg.y[:, -1]
        if leg.status == 1:
            times.append(float(time))
            state[1] *= -e
    return times, float(state[0])
