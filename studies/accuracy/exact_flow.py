"""Would the exact flow of a linear mode be faster than its Taylor series? The impact oscillator with both.

The closed form is written by hand for this one system: rotation, damping and forced motion, the first impact by steps
that a bound on the second derivative makes safe, two tangents, and nothing else. It runs in the engine, in the place of
a method, with all that the engine does for any method; and in a bare loop without the engine, which no engine can beat.
All run in turn; medians. The impacts found must be the same.
"""

import math
import sys
import time
import types as python_types
from statistics import median

import numpy as np

import chaosdrill as cd
from chaosdrill.codegen import kernels_of
from chaosdrill.codegen.kinds import float64, int64
from chaosdrill.codegen.signatures import matrix, vector
from chaosdrill.engine import layout as at
from chaosdrill.engine import stepper
from chaosdrill.engine.jit import compiled, inner
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.records import machine_at, state_of
from chaosdrill.engine.run import Run
from chaosdrill.engine.stepper import offered

TOLERANCE = 1e-12
WALL, ZETA, AMPLITUDE, OMEGA, RESTITUTION = range(5)
"""Places of the parameters in the constants of the system."""


@inner
def forced(c, t):
    """Displacement, speed and amplitude of the forced motion."""
    omega = c[OMEGA]
    detune, drag = 1.0 - omega * omega, 2.0 * c[ZETA] * omega
    size = c[AMPLITUDE] / (detune * detune + drag * drag)
    cosine, sine = math.cos(omega * t), math.sin(omega * t)
    x = size * (detune * cosine + drag * sine)
    v = size * omega * (drag * cosine - detune * sine)
    return x, v, size * math.sqrt(detune * detune + drag * drag)


@inner
def free_map(c, s):
    """Matrix of the free motion over a time s."""
    d = c[ZETA]
    w = math.sqrt(1.0 - d * d)
    fade = math.exp(-d * s)
    cosine, sine = fade * math.cos(w * s), fade * math.sin(w * s) / w
    return cosine + d * sine, sine, -sine, cosine - d * sine


@inner
def move(c, t, x, v, s):
    """State a time s after t."""
    here, speed, _ = forced(c, t)
    there, later, _ = forced(c, t + s)
    a, b, p, q = free_map(c, s)
    x -= here
    v -= speed
    return a * x + b * v + there, p * x + q * v + later


@inner
def first_impact(c, t, x, v, longest):
    """Time to the first impact within ``longest``, or -1: the parabola through value and slope bounds the motion."""
    here, speed, amplitude = forced(c, t)
    d = c[ZETA]
    y, u = x - here, v - speed
    swing = (u + d * y) / math.sqrt(1.0 - d * d)
    bend = math.sqrt(y * y + swing * swing) + amplitude * c[OMEGA] * c[OMEGA]
    s = 0.0
    g, slope = x - c[WALL], v
    for _ in range(200):
        step = (-slope + math.sqrt(slope * slope - 2.0 * bend * min(g, 0.0))) / bend
        s += step
        if s > longest:
            return -1.0
        if step <= 2e-16 * s:
            return s
        a, b, p, q = free_map(c, s)
        there, later, _ = forced(c, t + s)
        g = a * y + b * u + there - c[WALL]
        slope = p * y + q * u + later
    return s


@offered
def expand(place, p, t):
    """A step is a period, or less if there is an impact."""
    return state_of(machine_at(place).states, p).run[0].period


@offered
def locate(place, p, te, h, t):
    """The first impact of the step."""
    state = state_of(machine_at(place).states, p)
    s = first_impact(state.c, t, state.x[0], state.x[1], h)
    return s, (0 if s >= 0.0 else -1), 0


@offered
def evaluate(place, p, t, s):
    """State at s."""
    machine = machine_at(place)
    state, out = state_of(machine.states, p), machine.scratch.out
    out[0], out[1] = move(state.c, t, state.x[0], state.x[1], s)


@offered
def advance(place, p, t, s):
    """State and tangents at s."""
    machine = machine_at(place)
    state, out = state_of(machine.states, p), machine.scratch.out
    c, vectors = state.c, state.vectors
    out[0], out[1] = move(c, t, state.x[0], state.x[1], s)
    a, b, q, r = free_map(c, s)
    for i in range(state.run[0].live):
        y, u = vectors[i, 0], vectors[i, 1]
        vectors[i, 0] = a * y + b * u
        vectors[i, 1] = q * y + r * u


@compiled(int64(vector, float64, int64, float64, float64, matrix, vector))
def bare_loop(c, period, periods, x, v, tangents, impacts):
    """The run without an engine: impacts counted, their first times kept, tangents mapped and scaled; no QR."""
    t = 0.0
    count = 0
    for strobe in range(periods):
        while True:
            s = first_impact(c, t, x, v, period - t)
            arc = period - t if s < 0.0 else s
            x, v = move(c, t, x, v, arc)
            a, b, p, q = free_map(c, arc)
            for i in range(2):
                y, u = tangents[i, 0], tangents[i, 1]
                tangents[i, 0] = a * y + b * u
                tangents[i, 1] = p * y + q * u
            if s < 0.0:
                break
            t += s
            x = c[WALL]
            push = c[AMPLITUDE] * math.cos(c[OMEGA] * t) - x
            e = c[RESTITUTION]
            jump = push + 2.0 * c[ZETA] * e * v + e * (push - 2.0 * c[ZETA] * v)
            for i in range(2):
                across = tangents[i, 0] / v
                tangents[i, 0] = -e * tangents[i, 0]
                tangents[i, 1] = -e * tangents[i, 1] + jump * across
            v = -e * v
            if count < impacts.size:
                impacts[count] = strobe * period + t
            count += 1
        t = 0.0
        for i in range(2):
            size = math.hypot(tangents[i, 0], tangents[i, 1])
            tangents[i, 0] /= size
            tangents[i, 1] /= size
    return count


def engine_run(system: cd.HybridSystem, tangents: int, exact: bool) -> Run:
    """A run of the engine with its own series, or with the closed form in the place of a fixed-step method."""
    period = system.forcing_period()
    assert period is not None
    run = Run(system, period, Numerics("rk4" if exact else "taylor", TOLERANCE), tangents=np.eye(2)[:tangents])
    run.method = "exact_flow" if exact else run.method
    return run


def install() -> None:
    """Let the engine find this module's functions by the name of a method."""
    module = python_types.ModuleType("chaosdrill.engine.exact_flow")
    for function in (expand, locate, evaluate, advance):
        setattr(module, function.py_func.__name__, function)
    sys.modules[module.__name__] = module
    stepper.METHODS = {**stepper.METHODS, "exact_flow": stepper.METHODS["rk4"]}


def impact_times(run: Run, count: int) -> np.ndarray:
    """Times of the first impacts of a fresh run."""
    rows = np.zeros((count, at.EVENT_COLUMNS + 4))
    run.advance(10 * count, events=rows)
    return np.asarray(rows[:, at.EVENT_STROBES] * run.period + rows[:, at.EVENT_TIME])


def timed(action, periods: int) -> float:  # type: ignore[no-untyped-def]
    """Microseconds a period."""
    begin = time.perf_counter()
    action(periods)
    return (time.perf_counter() - begin) / periods * 1e6


def compare(rounds: int, periods: int = 20_000) -> dict[str, float]:
    """Medians of microseconds a period, and the largest difference of the first twenty impacts.

    Parameters
    ----------
    rounds : int
        Rounds, in each of which every program runs once.
    periods : int
        Forcing periods a round.
    """
    install()
    system = cd.build("impact-oscillator")
    c = kernels_of(system).constants(system.parameters)
    period = system.forcing_period()
    start = (system.initial["x"], system.initial["v"])
    first = np.zeros(20)

    def bare(count: int) -> None:
        bare_loop(c, period, count, *start, np.eye(2), first)

    runs = {
        "series": engine_run(system, 2, exact=False),
        "series, state only": engine_run(system, 0, exact=False),
        "exact in the engine": engine_run(system, 2, exact=True),
        "exact in the engine, state only": engine_run(system, 0, exact=True),
    }
    actions = {name: run.advance for name, run in runs.items()} | {"exact, bare loop": bare}
    for action in actions.values():
        action(100)
    found = {name: [] for name in actions}
    for _ in range(rounds):
        for name, action in actions.items():
            found[name].append(timed(action, periods))
    series = impact_times(engine_run(system, 2, exact=False), first.size)
    exact = impact_times(engine_run(system, 2, exact=True), first.size)
    results = {name: median(values) for name, values in found.items()}
    results["largest difference"] = float(max(np.abs(series - exact).max(), np.abs(series - first).max()))
    return results


def table(results: dict[str, float]) -> str:
    """What was measured, in Markdown."""
    lines = ["| flow | microseconds a period |", "| --- | --- |"]
    lines += [f"| {name} | {value:.2f} |" for name, value in results.items() if "difference" not in name]
    whole, state = (results[f"series{x}"] / results[f"exact in the engine{x}"] for x in ("", ", state only"))
    least = results["series"] / results["exact, bare loop"]
    lines += [
        "",
        f"Series over exact flow: {whole:.2f} with two tangents, {state:.2f} for the state alone; over a loop without "
        f"an engine {least:.2f}. The first twenty impacts are the same to {results['largest difference']:.0e}.",
        "",
    ]
    return "\n".join(lines)
