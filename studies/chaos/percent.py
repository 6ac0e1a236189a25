"""What one per cent of each parameter does to the rate of progression on the fast branch, and to the force of its hit.

The rate by its exact derivatives, and for a check by central differences of fourth order between orbits beside it; the
peak force, a function of the speed of the hit that is no mean, by these differences alone.
"""

import math

import numpy as np
from findings import Claim, table
from fixed_step import parameters, run
from scipy.integrate import quad
from scipy.optimize import brentq

import chaosdrill as cd

DRILL = {"eta": 0.52, "xi": 0.12}
MOVED = ("eta", "a", "b", "xi", "r", "eps", "mu", "g", "lam")
WIDTH = 2e-4
"""Relative width of the differences: a fold of this branch is a per cent of ``b`` away, where rates are not linear."""

KNOWN_AS = {"eta": "η", "xi": "ξ", "eps": "ε", "mu": "μ", "lam": "λ"}


def peak_force(speed: float, lam: float, k: float, eps: float) -> float:
    """Return the largest force, over that of static friction, of a hit of free masses with a linear spring.

    ``F = k d (1 + lam d')`` with ``d'' = -(1 + eps) k d (1 + lam d')``, so that ``(1 + eps) k d^2/2`` is what the
    integral of ``v/(1 + lam v)`` from the rate to the speed gives. The force is greatest where its derivative along the
    motion vanishes.
    """

    def depth(rate: float) -> float:
        return math.sqrt(
            2 * quad(lambda v: v / (1 + lam * v), rate, speed, epsabs=0, epsrel=1e-13)[0] / ((1 + eps) * k)
        )

    def climb(rate: float) -> float:
        return rate - lam * (1 + eps) * k * depth(rate) ** 2

    rate = brentq(climb, 0.0, speed, xtol=1e-15, rtol=1e-14)
    return k * depth(rate) * (1 + lam * rate)


def measured(system: cd.HybridSystem) -> tuple[float, float]:
    """Return the rate and the peak force of the orbit of period 1 that the motion from rest leads to."""
    orbit = cd.periodic_orbit(system, period=1)
    speeds = orbit["event_state_before"].sel(state="u") - orbit["event_state_before"].sel(state="w")
    at_stop = np.isclose(orbit["event_state_before"].sel(state="y"), system.parameters["r"])
    law = system.parameters
    force = max(peak_force(float(v), law["lam"], law["k"], law["eps"]) for v in speeds.values[at_stop])
    return float(orbit["progression_rate"]), force


def differences(name: str) -> np.ndarray:
    """Return d ln rate / d ln p and d ln force / d ln p, by differences of fourth order."""
    fast = cd.drill(**DRILL)
    values = [
        np.log(measured(fast.with_parameters(**{name: fast.parameters[name] * (1 + step * WIDTH)})))
        for step in (-2, -1, 1, 2)
    ]
    return np.dot([1, -8, 8, -1], values) / (12 * WIDTH)


def elasticities() -> tuple[dict[str, float], float]:
    """Return d ln rate / d ln p by parameter, exact, and the largest of their errors."""
    orbit = cd.periodic_orbit(cd.drill(**DRILL), derivatives=list(MOVED))
    parts = orbit["parameter_value"] / orbit["progression_rate"]
    error = float(abs(orbit["progression_rate_derivative_error"] * parts).max())
    return (orbit["progression_rate_derivative"] * parts).to_series().to_dict(), error


def compare() -> tuple[str, list[Claim], dict[str, tuple[float, float, float]]]:
    """Return the table, the claims, and for each parameter what it does to rate, force, and rate at equal force."""
    fast = cd.drill(**DRILL)
    rate, force = measured(fast)
    exact, error = elasticities()
    beside = {name: differences(name) for name in MOVED}
    apart = max(abs(exact[name] - float(beside[name][0])) for name in MOVED)
    forces = {name: float(beside[name][1]) for name in MOVED}
    per_force = exact["a"] / forces["a"]
    effects = {name: (exact[name], forces[name], exact[name] - per_force * forces[name]) for name in MOVED}
    order = sorted(MOVED, key=lambda name: -abs(effects[name][0]))
    rows = [[f"${_symbol(name)}$", *(f"{value:+.3f} %" for value in effects[name])] for name in order]
    law = {key: fast.parameters[key] for key in ("a", "b", "xi", "eta", "eps", "mu", "g", "r", "lam", "phi", "k")}
    outside = {}
    for name in order[:3]:
        pair = [
            run(parameters(**law | {name: law[name] * factor}), np.zeros(3), 300, 64, 1e-7)[0]
            for factor in (0.9995, 1.0005)
        ]
        outside[name] = math.log(pair[1] / pair[0]) / math.log(1.0005 / 0.9995)
    off = max(abs(outside[name] / effects[name][0] - 1) for name in outside)
    claims = [
        Claim(
            "the fast motion progresses by 0.135 a unit of time, with a hit of some hundred friction forces",
            f"{rate:.6f}, {force:.1f}",
            bool(abs(rate - 0.1352) < 1e-4 and 50 < force < 500),
        ),
        Claim(
            "differences between orbits are the exact derivatives of the rate",
            f"to {apart:.1e}; their errors are {error:.1e}",
            apart < 1e-4,
        ),
        Claim(
            "the independent program agrees on the three largest to one part in a thousand",
            ", ".join(f"{KNOWN_AS.get(name, name)}: {value:+.3f} %" for name, value in outside.items()),
            off < 1e-3,
        ),
    ]
    head = ["one per cent more of", "rate", "peak force", "rate, with $a$ such that the peak force stays"]
    return table(head, rows), claims, effects


def _symbol(name: str) -> str:
    return {"eta": r"\eta", "xi": r"\xi", "eps": r"\varepsilon", "mu": r"\mu", "lam": r"\lambda"}.get(name, name)
