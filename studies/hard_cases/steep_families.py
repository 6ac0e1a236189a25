"""Motions through steep terms, with their closed forms: smoothed friction, pulses, gates, poles, branch points.

All of them last one unit of time; ``T`` says how much happens in it. A case is a set of parameters and of initial
states, and where one state has to be at the end.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

import chaosdrill as cd

Draw = np.random.Generator


@dataclass(frozen=True)
class Case:
    """One motion.

    Parameters
    ----------
    parameters, initial : dict of str to float
    right : float
        The first state at the end; NaN where the equations end before.
    scale : float
        Its size on the way.
    ends : bool
        Whether it comes to a branch point, where a run may end with an outcome.
    """

    parameters: dict[str, float]
    initial: dict[str, float]
    right: float
    scale: float
    ends: bool = False


@dataclass(frozen=True)
class Family:
    """Motions of one system.

    Parameters
    ----------
    name : str
    rates : dict of str to str
        By states, of which the first is compared.
    draw : callable
        A case from a random generator.
    time : str or None
    """

    name: str
    rates: dict[str, str]
    draw: Callable[[Draw], Case]
    time: str | None = None
    _made: dict[str, Any] = field(default_factory=dict)

    def system(self, case: Case) -> cd.HybridSystem:
        """The system with the numbers of a case."""
        if "system" not in self._made:
            self._made["system"] = cd.HybridSystem(
                name=self.name,
                states=" ".join(self.rates),
                time=self.time,
                parameters=case.parameters,
                modes={"all": self.rates},
                initial=case.initial,
            )
        made: cd.HybridSystem = self._made["system"]
        return made.with_parameters(**case.parameters).with_initial(**case.initial)


def _log(draw: Draw, low: float, high: float) -> float:
    return float(np.exp(draw.uniform(math.log(low), math.log(high))))


NODES, WEIGHTS = np.polynomial.legendre.leggauss(24)


def integral(
    f: Callable[[np.ndarray], np.ndarray], low: float, high: float, places: list[float], width: float
) -> float:
    """Integral of a function that changes over ``width`` at some places: panels that double away from these."""
    steps = width * 2.0 ** np.arange(-3, 40)
    around = [np.concatenate([p - steps, [p], p + steps]) for p in places]
    edges = np.concatenate([np.linspace(low, high, 33), *around])
    edges = np.unique(np.clip(edges, low, high))
    half = np.diff(edges) / 2
    nodes = (edges[:-1] + half)[:, np.newaxis] + half[:, np.newaxis] * NODES
    return math.fsum((f(nodes) @ WEIGHTS * half).tolist())


# friction laws: v' = -T f(v/e); the time from v0 to v1


def _friction(name: str, law: str, time: Callable[[float, float, float], float]) -> Family:
    def draw(draw: Draw) -> Case:
        e, v0 = _log(draw, 1e-3, 1.0), draw.uniform(0.3, 2.0)
        v1 = v0 * 10.0 ** -draw.uniform(0.05, 3.0)
        return Case({"T": time(v0, v1, e), "e": e}, {"v": v0}, v1, v0)

    return Family(name, {"v": f"-T*{law}"}, draw)


def _log_sinh(w: float) -> float:
    return w + math.log1p(-math.exp(-2 * w)) - math.log(2)


def _root_law(w: float) -> float:
    return math.sqrt(w * w + 1) - math.asinh(1 / w)


def _atan_time(v0: float, v1: float, e: float) -> float:
    return integral(lambda y: np.exp(y) / np.arctan(np.exp(y) / e), math.log(v1), math.log(v0), [math.log(e)], 0.5)


def frictions() -> list[Family]:
    """Smoothed dry friction."""
    return [
        _friction("tanh", "tanh(v/e)", lambda a, b, e: e * (_log_sinh(a / e) - _log_sinh(b / e))),
        _friction("atan", "atan(v/e)", _atan_time),
        _friction("root", "v/sqrt(v**2 + e**2)", lambda a, b, e: e * (_root_law(a / e) - _root_law(b / e))),
        _friction(
            "logistic",
            "(2/(1 + exp(-v/e)) - 1)",
            lambda a, b, e: 2 * e * (_log_sinh(a / (2 * e)) - _log_sinh(b / (2 * e))),
        ),
    ]


# pulses and gates in time: x' = T A f((T t - c)/w), with the integral of f


def _softplus(u: float) -> float:
    return max(u, 0.0) + math.log1p(math.exp(-abs(u)))


def _pulse(name: str, law: str, whole: Callable[[float], float]) -> Family:
    def draw(draw: Draw) -> Case:
        w, length = _log(draw, 1e-3, 1.0), draw.uniform(1.0, 10.0)
        c, a = draw.uniform(0.02, 0.98) * length, draw.uniform(0.3, 3.0)
        moved = a * w * (whole((length - c) / w) - whole(-c / w))
        numbers = {"T": length, "A": a, "c": c, "w": w}
        return Case(numbers, {"x": 1.0}, 1.0 + moved, max(1.0, abs(1.0 + moved)))

    return Family(f"{name} in time", {"x": "T*A*" + law.replace("u", "((T*t - c)/w)")}, draw, time="t")


def pulses() -> list[Family]:
    """Pulses in time."""
    root = math.sqrt(math.pi) / 2
    return [
        _pulse("gauss", "exp(-u**2)", lambda u: root * math.erf(u)),
        _pulse("gauss slope", "u*exp(-u**2)", lambda u: -0.5 * math.exp(-u * u) if abs(u) < 26 else 0.0),
        _pulse("sech", "1/cosh(u)", lambda u: 2 * math.atan(math.tanh(u / 2))),
        _pulse("sech squared", "(1 - tanh(u)**2)", math.tanh),
        _pulse("gate", "1/(1 + exp(-u))", _softplus),
        _pulse("switch", "tanh(u)", lambda u: _softplus(2 * u) - u),
        _pulse("lorentz", "1/(1 + u**2)", math.atan),
    ]


# terms of a state that swings: y' = T f(p), p = cos(T t + a)


def _swing(name: str, law: str, f: Callable[[np.ndarray, float, float], np.ndarray], gates: bool = False) -> Family:
    def draw(draw: Draw) -> Case:
        w, length, phase = _log(draw, 1e-3, 1.0), draw.uniform(1.0, 12.0), draw.uniform(0, 2 * math.pi)
        c = draw.uniform(0.6, 1.7) if gates else draw.uniform(-1.05, 1.05)
        center, width = (c - 1.2, 0.02) if gates else (c, w)
        places = [k * math.pi for k in range(6)]
        if abs(center) < 1:
            places += [2 * math.pi * k + s * math.acos(center) for k in range(4) for s in (-1, 1)]
        moved = integral(lambda tau: f(np.cos(tau), c, w), phase, phase + length, places, 0.3 * width)
        size = max(1.0, abs(1 + moved))
        initial = {"y": 1.0, "p": math.cos(phase), "q": -math.sin(phase)}
        return Case({"T": length, "c": c, "w": w}, initial, 1.0 + moved, size)

    return Family(f"{name} of a swing", {"y": f"T*{law}", "p": "T*q", "q": "-T*p"}, draw)


def _hill(n: int) -> Family:
    return _swing(
        f"hill gate {n}",
        f"(1.2 + p)**{n}/(c**{n} + (1.2 + p)**{n})",
        lambda p, c, w: 1 / (1 + (c / (1.2 + p)) ** n),
        gates=True,
    )


def swings() -> list[Family]:
    """Pulses, gates and poles in space, passed again and again."""
    far = 700.0
    return [
        _swing("gauss", "exp(-((p - c)/w)**2)", lambda p, c, w: np.exp(-np.minimum(((p - c) / w) ** 2, far))),
        _swing("sech", "1/cosh((p - c)/w)", lambda p, c, w: 1 / np.cosh(np.clip((p - c) / w, -far, far))),
        _swing("tanh", "tanh((p - c)/w)", lambda p, c, w: np.tanh((p - c) / w)),
        _swing("pole", "w/((p - c)**2 + w**2)", lambda p, c, w: w / ((p - c) ** 2 + w**2)),
        _swing("root", "(p - c)/sqrt((p - c)**2 + w**2)", lambda p, c, w: (p - c) / np.hypot(p - c, w)),
        _swing("corner", "sqrt((p - c)**2 + w**2)", lambda p, c, w: np.hypot(p - c, w)),
        _swing("atan", "atan((p - c)/w)", lambda p, c, w: np.arctan((p - c) / w)),
        _swing("softplus", "w*log(1 + exp((p - c)/w))", lambda p, c, w: w * np.logaddexp(0, (p - c) / w)),
        _swing("power 9", "(c*p**9 + w)", lambda p, c, w: c * p**9 + w),
        _swing("power 30", "(c*p**30 + w)", lambda p, c, w: c * p**30 + w),
        *map(_hill, (2, 8, 25, 60)),
    ]


# growth that stops: x' = T (1 - x**n), of which a series about 0 sees nothing


def _growth(n: int) -> Family:
    def draw(draw: Draw) -> Case:
        end = 1.0 - _log(draw, 1e-6, 0.7)
        length = integral(lambda x: 1 / (1 - x**n), 0.0, end, [end], 1e-3 * (1 - end))
        return Case({"T": length}, {"x": 0.0}, end, 1.0)

    return Family(f"growth up to a power {n}", {"x": f"T*(1 - x**{n})"}, draw)


# a spring through its anchor, whose force has a pole beside the path


def _spring() -> Family:
    def draw(draw: Draw) -> Case:
        b, rest, length = _log(draw, 0.02, 0.5), draw.uniform(0.2, 1.0), draw.uniform(0.3, 2.5)

        def rates(_t: float, s: np.ndarray) -> list[float]:
            force = 1 - rest / math.hypot(s[0], s[1])
            return [s[2], s[3], -s[0] * force, -s[1] * force]

        start = [1.0, b, -1.0, 0.0]
        found = solve_ivp(rates, (0, length), start, method="DOP853", rtol=3e-14, atol=1e-15, max_step=0.2 * b)
        numbers = {"T": length, "l": rest}
        return Case(numbers, dict(zip(("x", "y", "u", "v"), start, strict=True)), float(found.y[0, -1]), 1.0)

    force = "(1 - l/sqrt(x**2 + y**2))"
    return Family("spring", {"x": "T*u", "y": "T*v", "u": f"-T*x*{force}", "v": f"-T*y*{force}"}, draw)


# branch points: the equations end at one, before the time is over or after


def _branch(
    name: str, rate: str, value: Callable[[float], float], end: float, start: float, rest: float = math.nan
) -> Family:
    """A motion that is at a branch point at the time ``end``, and stays at ``rest`` or has no equations any more."""

    def draw(draw: Draw) -> Case:
        length = end * (draw.uniform(0.05, 0.99) if draw.random() < 0.5 else draw.uniform(1.01, 3.0))
        ends = length > end
        return Case({"T": length}, {"x": start}, rest if ends else value(length), 1.0, ends)

    return Family(name, {"x": f"T*({rate})"}, draw)


def branches() -> list[Family]:
    """Motions into branch points."""
    return [
        _branch("tank", "-sqrt(x)", lambda t: (1 - t / 2) ** 2, 2.0, 1.0, 0.0),
        _branch("power 3/4", "-x**(3/4)", lambda t: (1 - t / 4) ** 4, 4.0, 1.0, 0.0),
        _branch("power 1/3", "-x**(1/3)", lambda t: (1 - 2 * t / 3) ** 1.5, 1.5, 1.0, 0.0),
        _branch("quarter circle", "sqrt(1 - x**2)", math.sin, math.pi / 2, 0.0, 1.0),
        _branch("pole", "-1/x", lambda t: math.sqrt(1 - 2 * t), 0.5, 1.0),
    ]


@cache
def families() -> tuple[Family, ...]:
    """All families."""
    return (*frictions(), *pulses(), *swings(), *map(_growth, (5, 6, 7, 12, 30)), _spring(), *branches())
