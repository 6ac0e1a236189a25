"""The drill computed again to any number of digits; nothing is shared with the package but the equations.

    y' = u - w,   u' = b + a cos(eta t + phi) - l,   w' = eps [l - mu - (1 - mu) exp(-g w)],   l = y + 2 xi (u - w)
    stick: w = 0 while l <= 1;   stop y <= r: relative speed v -> -s(v), momentum eps u + w kept

Taylor series in mpmath, summed a step at a time; events are sign changes of the guards' polynomials. The exit speed s
solves G(-s) = G(v), G(v) = v/lam - ln(1 + lam v)/lam^2. There are no variational equations and no saltation:
derivatives of the period map are differences of the map itself, at starts so close that half of the digits are left.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from mpmath import mp
from scipy.optimize import brentq

PAPER = {"a": "0.25", "b": "0.7", "xi": "0.06", "eps": "1", "mu": "0.6", "g": "3", "r": "1", "lam": "0.6"}
"""Parameters besides eta; the phase phi is pi/2."""

STICK, SLIP = "stick", "slip"
ESCAPED = 100
PARTS = (0.0, *(0.5**k for k in range(40, 5, -1)), *(i / 40 for i in range(1, 41)))
"""Parts of a step of the series at which guards are looked at, beside their extrema.

They begin with short ones: a guard that was just left may rise again at once.
"""


@dataclass
class Event:
    """What happened: ``hit``, ``stick`` or ``slip`` (release), when, at which rate of the guard, states around it."""

    kind: str
    time: Any
    speed: Any
    before: list[Any]
    after: list[Any]


@dataclass
class Run:
    """A stretch of motion: state and mode at its end, its events, and the closest approaches that were no events.

    ``misses`` holds (guard, time, value) of every maximum of a guard that ended in no event.
    """

    state: list[Any]
    mode: str
    events: list[Event] = field(default_factory=list)
    misses: list[tuple[str, Any, Any]] = field(default_factory=list)

    @property
    def sequence(self) -> str:
        """Kinds of the events in order."""
        return " ".join(event.kind for event in self.events)


class Drill:
    """The drill with the paper's parameters and those given as strings or mpf."""

    def __init__(self, eta: Any, **changed: Any) -> None:
        self.eta = mp.mpf(eta)
        values = {name: mp.mpf(value) for name, value in {**PAPER, **changed}.items()}
        self.a, self.b, self.xi, self.eps, self.mu, self.g, self.r, self.lam = values.values()
        self.phi = mp.pi / 2
        self.period = 2 * mp.pi / self.eta

    def series(self, mode: str, t: Any, x: list[Any], order: int) -> list[list[Any]]:
        """Taylor coefficients of y, u, w at time ``t``, shape (3, order + 1)."""
        y, u, w = ([value] for value in x)
        angle = self.eta * t + self.phi
        c, s = self.a * mp.cos(angle), self.a * mp.sin(angle)
        e = [(1 - self.mu) * mp.exp(-self.g * w[0])]
        slopes: list[Any] = []
        for k in range(order):
            spring = y[k] + 2 * self.xi * (u[k] - w[k])
            steady = mp.mpf(k == 0)
            y.append((u[k] - w[k]) / (k + 1))
            u.append((self.b * steady + c - spring) / (k + 1))
            slope = self.eps * (spring - self.mu * steady - e[k]) if mode == SLIP else mp.zero
            w.append(slope / (k + 1))
            if mode == SLIP:
                slopes.append(slope)
                e.append(-self.g * mp.fdot(zip(slopes, reversed(e), strict=True)) / (k + 1))
            c, s = -self.eta * s / (k + 1), self.eta * c / (k + 1)
        return [y, u, w]

    def guards(self, mode: str, series: list[list[Any]]) -> dict[str, list[Any]]:
        """Polynomials that rise through zero at an event."""
        y, u, w = series
        stop = [y[0] - self.r, *y[1:]]
        if mode == SLIP:
            return {"hit": stop, "stick": [-c for c in w]}
        demand = [p + 2 * self.xi * q for p, q in zip(y, u, strict=True)]
        return {"hit": stop, "slip": [demand[0] - 1, *demand[1:]]}

    def exit_speed(self, v: Any) -> Any:
        """Speed s > 0 with G(-s) = G(v): Newton's method from its first terms."""
        lam = self.lam

        def lost(z: Any) -> Any:
            return z / lam - mp.log(1 + lam * z) / lam**2

        # both sides are about v^2/2: a slow hit needs digits beyond those of v
        with mp.workdps(2 * mp.dps + 20):
            s = v / (1 + lam * v)
            for _ in range(100):
                # the logarithm ends at 1/lam
                change = max((lost(-s) - lost(v)) * (1 - lam * s) / s, (s - 1 / lam) / 2)
                s -= change
                if abs(change) <= s * mp.mpf(10) ** (-mp.dps // 2):
                    return s
        raise ArithmeticError("no exit speed found")

    def act(self, kind: str, mode: str, x: list[Any]) -> tuple[str, list[Any]]:
        """Mode and state after an event."""
        y, u, w = x
        if kind == "stick":
            return STICK, [y, u, mp.zero]
        if kind == "slip":
            return SLIP, x
        s = self.exit_speed(u - w)
        bit = (self.eps * u + w - s) / (1 + self.eps)
        return SLIP, [self.r, bit, bit + s]

    def run(self, x: list[Any], mode: str, periods: int = 1, overlook: float = 0.0) -> Run:
        """Motion from phase 0 on through ``periods`` forcing periods.

        A guard met at a rate below ``overlook`` is passed as if it were not there, and its maximum beyond zero counts
        as a miss: so the motion before a grazing event goes on smoothly beyond it, and the grazing itself is a root.
        """
        order = int(1.2 * mp.dps) + 4
        t, end = mp.zero, self.period * periods
        run = Run(list(x), mode)
        while t < end:
            series = self.series(run.mode, t, run.state, order)
            size = max(abs(c[k]) ** (mp.one / k) for c in series for k in (order - 1, order))
            h = min(mp.mpf(10) ** (-(mp.dps + 2) / mp.mpf(order)) / max(size, mp.mpf("0.01")), mp.one, end - t)
            kind, h, rate = self._first(self.guards(run.mode, series), t, h, run, overlook)
            t += h
            run.state = [_value(c, h) for c in series]
            if max(abs(value) for value in run.state) > ESCAPED:
                raise ArithmeticError("the drill runs away")
            if kind is not None:
                mode, after = self.act(kind, run.mode, run.state)
                run.events.append(Event(kind, t, rate, run.state, after))
                run.mode, run.state = mode, after
        return run

    def _first(self, guards: dict[str, list[Any]], t: Any, h: Any, run: Run, overlook: float) -> tuple[Any, Any, Any]:
        """The first event within ``h``: its kind (None without one), its time after ``t``, the rate of its guard."""
        first: tuple[Any, Any, Any] = (None, h, None)
        misses = []
        for kind, c in guards.items():
            rate = _derivative(c)
            slopes = _floats(rate, [float(h) * part for part in PARTS])
            turns = [i for i in range(len(PARTS) - 1) if (slopes[i] > 0) != (slopes[i + 1] > 0)]
            extrema = [_extremum(rate, float(h) * PARTS[i], float(h) * PARTS[i + 1]) for i in turns]
            tops = [top for i, top in zip(turns, extrema, strict=True) if slopes[i] > 0]
            looks = [h * part for part in PARTS]
            marks = sorted([*looks, *extrema])
            values = [_value(c, m) if abs(v) < 1e-12 else v for m, v in zip(marks, _floats(c, marks), strict=True)]
            rises = [i for i in range(len(marks) - 1) if values[i] < 0 <= values[i + 1]]
            misses += [(kind, top, _value(c, top)) for top in tops]
            for i in rises:
                when = _root(c, marks[i], marks[i + 1])
                met = _value(rate, when)
                if met >= overlook:
                    if when < first[1]:
                        first = (kind, when, met)
                    break
        # a rock that is released starts at w = 0 with w' = 0: no approach, but the release itself
        away = mp.mpf(10) ** (-mp.dps // 3)
        run.misses += [(kind, t + top, value) for kind, top, value in misses if away < top < first[1]]
        return first


def _value(c: list[Any], t: Any) -> Any:
    return mp.polyval(c[::-1], t)


def _floats(c: list[Any], t: list[Any]) -> np.ndarray:
    return np.polynomial.polynomial.polyval(np.array(t, float), np.array(c, float))


def _derivative(c: list[Any]) -> list[Any]:
    return [k * a for k, a in enumerate(c)][1:]


def _extremum(rate: list[Any], low: float, high: float) -> Any:
    """Where the rate vanishes: as a double, then one step of Newton's method."""
    near = mp.mpf(brentq(lambda t: float(_floats(rate, [t])[0]), low, high, xtol=1e-18))
    return near - _value(rate, near) / _value(_derivative(rate), near)


def _root(c: list[Any], low: Any, high: Any) -> Any:
    return mp.findroot(lambda t: _value(c, t), (low, high), solver="anderson", verify=False)
