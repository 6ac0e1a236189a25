"""Grazing transitions between stick and slip

Sticking can begin or end without a crossing in two ways. *Adding-sliding*: the friction demand touches its limit from
below, and the rock is released for a short time between two steps (two roots in one step, of the demand).
*Grazing-sliding*: a body that slips on a belt reaches the speed of the belt as the load grows, and sticks from then on.
The cycle hardly changes, but its exponents jump, one of them to minus infinity. A smoothed friction law gives a number
that depends on the smoothing.
"""

import math

import mpmath
import numpy as np
import sympy
from scipy.integrate import solve_ivp
from tools import Finding, event_names, listed

import chaosdrill as cd

X, V, T = sympy.symbols("x v t", real=True)
ZETA, OMEGA, HOLD, BELT = 0.05, 0.7, 1.0, 1.0
SMOOTH = (1e-1, 1e-2)


def block(amplitude: float) -> "cd.HybridSystem":
    """A block under the load A cos(t - 1), held by friction up to 1 and slowed by the same when it slips."""
    excess = sympy.Symbol("A", real=True) * sympy.cos(T - 1) - 1
    return cd.HybridSystem(
        name="block",
        states=(X, V),
        time=T,
        parameters={"A": amplitude},
        modes={"stick": {X: 0, V: 0}, "slip": {X: V, V: excess}},
        transitions=[
            cd.Transition("release", "stick", "slip", guard=excess, direction=+1),
            cd.Transition("stick", "slip", "stick", guard=V, direction=-1, reset={V: 0}),
        ],
        period=2 * sympy.pi,
        initial={"mode": "stick"},
    )


def releases(amplitude: float, periods: int) -> int:
    """Return how many releases scipy's events find while the block sticks."""

    def excess(t: float, s: np.ndarray) -> float:
        return amplitude * math.cos(t - 1) - 1

    excess.direction = +1
    solution = solve_ivp(
        lambda t, s: [0.0, amplitude * math.sin(t - 1)],
        (0.0, 2 * math.pi * periods),
        [0.0, 0.0],
        method="DOP853",
        rtol=1e-12,
        atol=1e-12,
        events=excess,
    )
    return len(solution.t_events[0])


def slipping(amplitude: float) -> tuple[float, float]:
    """Return release and next stick of the block around the load's peak, with 40 digits for what cancels."""
    with mpmath.workdps(40):
        a = mpmath.mpf(amplitude)
        release = -mpmath.acos(1 / a)
        stick = mpmath.findroot(lambda t: a * (mpmath.sin(t) - mpmath.sin(release)) - (t - release), -2.01 * release)
        return float(release), float(stick)


def on_a_belt(force: float) -> "cd.HybridSystem":
    """An oscillator on a belt of speed 1, driven by force cos(omega t), Coulomb friction 1; slower than the belt."""
    f, s, v0, zeta, omega = sympy.symbols("F S V zeta omega", real=True)
    load = f * sympy.cos(omega * T)
    return cd.HybridSystem(
        name="driven oscillator on a belt",
        states=(X, V),
        time=T,
        parameters={"F": force, "S": HOLD, "V": BELT, "zeta": ZETA, "omega": OMEGA},
        modes={"slip": {X: V, V: load - 2 * zeta * V - X + s}, "stick": {X: V, V: 0}},
        transitions=[
            cd.Transition("stick", "slip", "stick", guard=V - v0, direction=+1, reset={V: v0}),
            cd.Transition("release", "stick", "slip", guard=X + 2 * zeta * v0 - load - s, direction=+1),
        ],
        period=2 * sympy.pi / omega,
        initial={"mode": "slip", X: 1.0},
    )


def grazing_force() -> float:
    """Force at which the speed of the slipping cycle reaches the belt's."""
    return BELT * math.hypot(1 - OMEGA**2, 2 * ZETA * OMEGA) / OMEGA


def multiplier_beyond() -> float:
    """The multiplier that is left just beyond: the free period with the speed's direction thrown away."""
    period, turn = 2 * math.pi / OMEGA, math.sqrt(1 - ZETA**2)
    return math.exp(-ZETA * period) * (math.cos(turn * period) + ZETA / turn * math.sin(turn * period))


def smoothed(force: float, width: float) -> np.ndarray:
    """Return the exponents if friction is S tanh((V - v)/width)."""
    f, s, v0, zeta, omega, d = sympy.symbols("F S V zeta omega d", real=True)
    system = cd.HybridSystem(
        name="smoothed belt",
        states=(X, V),
        time=T,
        parameters={"F": force, "S": HOLD, "V": BELT, "zeta": ZETA, "omega": OMEGA, "d": width},
        modes={"all": {X: V, V: f * sympy.cos(omega * T) - 2 * zeta * V - X + s * sympy.tanh((v0 - V) / d)}},
        period=2 * sympy.pi / omega,
        initial={"mode": "all", X: 1.0},
    )
    return cd.lyapunov_spectrum(system, periods=50, transient=100, tolerance=1e-8)["lyapunov_exponent"].values


def findings() -> list[Finding]:
    """The touch from below and above, and the cycle on both sides of the force at which it begins to stick."""
    rows = []
    for excess, count in ((-1e-10, 0), (1e-10, 3), (1e-6, 3)):
        amplitude = 1 + excess
        run = cd.trajectory(block(amplitude), periods=3, samples=2)
        names, times = event_names(run), run["event_time"].values - 1
        rows.append(
            Finding(
                f"releases, peak demand 1 {'+' if excess > 0 else '−'} {abs(excess):g}, 3 periods",
                float(count),
                float(names.count("release")),
                0.0,
                f"{releases(amplitude, 3)} (scipy's DOP853)",
            )
        )
        if count and len(names) == 2 * count:
            release, stick = slipping(amplitude)
            slack = 1e-14 / abs(release)
            rows.append(Finding("its time before the peak", release, float(times[0]), slack))
            rows.append(Finding("the stick after it", stick, float(times[1]), slack))
    force = grazing_force()
    left = multiplier_beyond()
    found = {}
    for side in (-1e-6, 1e-10):
        system = on_a_belt(force * (1 + side))
        found[side] = (
            cd.poincare_section(system, periods=4, transient=1000),
            cd.lyapunov_spectrum(system, periods=200, transient=1000),
        )
    section, spectrum = found[-1e-6]
    modulus = np.hypot(section["multiplier_real"].values, section["multiplier_imag"].values)
    rows.append(
        Finding(
            "cycle short of the belt's speed: modulus of both multipliers",
            math.exp(-ZETA * 2 * math.pi / OMEGA),
            float(modulus[0]),
            1e-10,
        )
    )
    rows.append(Finding("sum of its exponents", -2 * ZETA, float(spectrum["lyapunov_exponent"].values.sum()), 1e-10))
    section, spectrum = found[1e-10]
    smooth = "; ".join(f"{listed(smoothed(force * (1 + 1e-10), d))} with tanh(v/{d:g})" for d in SMOOTH)
    rows.append(
        Finding(
            "cycle that sticks, load 1e-10 larger: first multiplier",
            left,
            float(section["multiplier_real"].values[0]),
            1e-4,
        )
    )
    rows.append(Finding("second multiplier", 0.0, float(section["multiplier_real"].values[1])))
    first, second = spectrum["lyapunov_exponent"].values
    rows.append(Finding("λ1", math.log(abs(left)) * OMEGA / (2 * math.pi), float(first), 1e-5))
    rows.append(Finding("λ2", -math.inf, float(second), 0.0, f"{smooth} (smoothed friction)"))
    return rows
