"""Clocks, ties and scales

Roots at which event detection fails: a kick at every strobe, two guards that are reached together, a start beyond a
guard that the motion crosses, a guard multiplied by a million beside a state that forces short steps, a state of size
10⁻⁹. A program that goes by the signs of a guard at the ends of its steps counts such a root twice or not at all,
depending on where its user asks for output. The list of events is a property of the motion: no strobe, sample or block
may change it, and no unit of a guard or a state.
"""

import importlib.util
import math
from collections.abc import Callable

import numpy as np
import sympy
from scipy.integrate import solve_ivp
from tools import Finding

import chaosdrill as cd

X, V, Y, U, Z, N, M, T = sympy.symbols("x v y u z n m t", real=True)
METHODS = ("taylor", "dop853")
PERIODS = 1000


def rotor() -> "cd.HybridSystem":
    """A rotor that is kicked at every whole time: the standard map with K = 10."""
    kick = {V: V + 10 / (2 * sympy.pi) * sympy.sin(2 * sympy.pi * X)}
    return cd.HybridSystem(
        name="kicked-rotor",
        states=(X, V),
        time=T,
        parameters={},
        modes={"free": {X: V, V: 0}},
        transitions=[
            cd.Transition("kick", "free", "free", guard=sympy.sin(2 * sympy.pi * T), direction=+1, reset=kick)
        ],
        period=sympy.Integer(1),
        initial={X: 0.3, V: 0.1},
    )


def clock() -> "cd.HybridSystem":
    """A clock that ticks once a period at the phase p."""
    p, k = sympy.symbols("p k", real=True)
    return cd.HybridSystem(
        name="clock",
        states=(X,),
        time=T,
        parameters={"p": 0.0, "k": 1.0},
        modes={"run": {X: 1 - X}},
        transitions=[
            cd.Transition(
                "tick", "run", "run", guard=k * sympy.sin(2 * sympy.pi * T - p), direction=+1, reset={X: X / 2}
            )
        ],
        period=sympy.Integer(1),
        initial={X: 1.0},
    )


def free_clock() -> "cd.HybridSystem":
    """A guard of time alone, without a period."""
    return cd.HybridSystem(
        name="free-clock",
        states=(X,),
        time=T,
        parameters={},
        modes={"run": {X: 0}},
        transitions=[cd.Transition("tick", "run", "run", guard=sympy.sin(T - sympy.Rational(1, 3)), direction=0)],
    )


def twins() -> "cd.HybridSystem":
    """Two clocks that tie once a period; the second one ticks a second time between."""
    p = sympy.Symbol("p", real=True)
    angle = 2 * sympy.pi * T - p
    return cd.HybridSystem(
        name="twin-clocks",
        states=(N, M),
        time=T,
        parameters={"p": 0.0},
        modes={"run": {N: 0, M: 0}},
        transitions=[
            cd.Transition("one", "run", "run", guard=sympy.sin(angle), direction=+1, reset={N: N + 1}),
            cd.Transition(
                "two", "run", "run", guard=sympy.sin(2 * angle) + sympy.sin(angle), direction=+1, reset={M: M + 1}
            ),
        ],
        period=sympy.Integer(1),
    )


def escapement(forced: bool = False) -> "cd.HybridSystem":
    """A damped oscillator that is kicked where it rises through 0, and goes on beyond; forced, it has strobes, too."""
    push = sympy.Symbol("push", real=True)
    own: dict[str, object] = {"states": (X, V), "modes": {"swing": {X: V, V: -X - V / 5}}}
    if forced:
        # a clock to read the times of events from
        own = {"states": (X, V, Z), "modes": {"swing": {X: V, V: -X - V / 5, Z: 1}}, "period": sympy.Integer(1)}
    return cd.HybridSystem(
        name="escapement",
        parameters={"push": 1.0},
        transitions=[cd.Transition("kick", "swing", "swing", guard=X, direction=+1, reset={V: V + push})],
        initial={X: -1.0},
        **own,
    )


def beside_decay(switch: bool = False) -> "cd.HybridSystem":
    """Two oscillators whose distance meets 0.3 next to a state that decays at 2e4: short steps, a guard of any scale.

    With c = cos(10 t) the distance is -c - (2 c**2 - 1)/10: it rises through 0.3 once a turn, where
    c = -(1 - sqrt(0.84))/0.4.
    """
    scale = sympy.Symbol("scale", real=True)
    flow = {X: V, V: -100 * X, Y: U, U: -400 * Y, Z: -20000 * Z}
    guard = scale * (X - Y - sympy.Rational(3, 10))
    return cd.HybridSystem(
        name="beside-decay",
        states=(X, V, Y, U, Z),
        parameters={"scale": 1.0},
        modes={"near": flow, "far": flow} if switch else {"near": flow},
        transitions=[
            cd.Transition("rise", "near", "far" if switch else "near", guard=guard, direction=+1),
            *([cd.Transition("fall", "far", "near", guard=guard, direction=-1)] if switch else []),
        ],
        initial={X: -1.0, Y: 0.1, Z: 1.0},
    )


def rises() -> np.ndarray:
    """Times at which the guard of `beside_decay` rises, until 20."""
    first = math.pi - math.acos((1 - math.sqrt(0.84)) / 0.4)
    times = (first + 2 * math.pi * np.arange(40)) / 10
    return times[times < 20]


def duffing() -> "cd.HybridSystem":
    """x'' = -w**2 (x + x**3/size**2), the same motion at any size and rate."""
    size, w = sympy.symbols("size w", real=True)
    return cd.HybridSystem(
        name="duffing",
        states=(X, V),
        parameters={"size": 1.0, "w": 1.0},
        modes={"free": {X: V, V: -(w**2) * (X + X**3 / size**2)}},
        bounds={X: None, V: None},
    )


def energy(x: np.ndarray, v: np.ndarray, size: float, w: float) -> np.ndarray:
    """Energy of `duffing`, 3/4 where it starts from rest at its size."""
    return (v / w / size) ** 2 / 2 + (x / size) ** 2 / 2 + (x / size) ** 4 / 4


def scipy_clock(method: str, most: int = 200) -> str:
    """Kicks of the rotor by scipy, a new call after each event as its documentation shows, in one go and by periods."""
    found = []
    for strobed in (False, True):

        def kick(t: float, s: np.ndarray) -> float:
            return math.sin(2 * math.pi * t)

        kick.terminal, kick.direction = True, +1  # type: ignore[attr-defined]
        time, state, count = 0.0, np.array([0.3, 0.1]), 0
        while time < PERIODS and count < most:
            end = min(math.floor(time) + 1.0, PERIODS) if strobed else PERIODS
            leg = solve_ivp(
                lambda t, s: [s[1], 0.0],
                (time, end),
                state,
                method=method,
                rtol=1e-12,
                atol=1e-14,
                max_step=0.1,
                events=kick,
            )
            time, state = leg.t[-1], leg.y[:, -1]
            if leg.status == 1:
                count += 1
                state[1] += 10 / (2 * math.pi) * math.sin(2 * math.pi * state[0])
        found.append(str(count) if time >= PERIODS else f"{count} at t = {time:.3g}, and no end")
    both = found[0] if found[0] == found[1] else f"{found[0]}; with a call a period {found[1]}"
    return f"{both} (scipy's {method})"


def scipy_oscillator(size: float, method: str) -> float:
    """Relative error of the energy of `duffing` after 100 units by scipy at rtol = 1e-12."""
    run = solve_ivp(
        lambda t, s: [s[1], -s[0] - s[0] ** 3 / size**2],
        (0.0, 100.0),
        [size, 0.0],
        method=method,
        rtol=1e-12,
    )
    return abs(float(energy(run.y[0, -1], run.y[1, -1], size, 1.0)) / 0.75 - 1)


def heyoka_ticks() -> tuple[str, str]:
    """Ticks of `clock` and of both `twins` by heyoka's events, in one call and in one a period."""
    if importlib.util.find_spec("heyoka") is None:
        return "", ""
    import heyoka

    def seen(into: list[float]) -> Callable[..., None]:
        return lambda integrator, time, sign: into.append(time)

    x, angle = heyoka.expression("x"), 2 * math.pi * heyoka.time
    guards = (heyoka.sin(angle), heyoka.sin(2 * angle) + heyoka.sin(angle))
    upward = heyoka.event_direction.positive
    counts = []
    for strobed in (False, True):
        ticks: tuple[list[float], list[float]] = ([], [])
        events = [heyoka.nt_event(g, seen(into), direction=upward) for g, into in zip(guards, ticks, strict=True)]
        integrator = heyoka.taylor_adaptive([(x, 1.0 - x)], [1.0], nt_events=events)
        for end in range(1, PERIODS + 1) if strobed else [PERIODS]:
            integrator.propagate_until(float(end))
        counts.append([str(len(found)) for found in ticks])
    alone, in_turn = counts
    name = f"(heyoka {heyoka.__version__})"
    return (
        f"{alone[0]}; with a call a period {in_turn[0]} {name}",
        f"{' and '.join(alone)}; with a call a period {' and '.join(in_turn)} {name}",
    )


def heyoka_beside_decay(scale: float) -> str:
    """Rises of the guard of `beside_decay` by heyoka's terminal events, its way to do a kick or a switch."""
    if importlib.util.find_spec("heyoka") is None:
        return ""
    import heyoka

    x, v, y, u, z = heyoka.make_vars("x", "v", "y", "u", "z")
    found = []

    def rise(integrator: object, sign: int) -> bool:
        found.append(sign)
        return True

    integrator = heyoka.taylor_adaptive(
        [(x, v), (v, -100.0 * x), (y, u), (u, -400.0 * y), (z, -20000.0 * z)],
        [-1.0, 0.0, 0.1, 0.0, 1.0],
        t_events=[heyoka.t_event(scale * (x - y - 0.3), callback=rise, direction=heyoka.event_direction.positive)],
    )
    integrator.propagate_until(20.0)
    return f"{len(found)} (heyoka {heyoka.__version__})"


def _counts(system: "cd.HybridSystem", method: str, blocks: int) -> dict[str, int]:
    run = cd.lyapunov_spectrum(system, periods=PERIODS, blocks=blocks, exponents=1, method=method)
    return dict(zip(run["transition"].values, run["event_count"].values.tolist(), strict=True))


def findings() -> list[Finding]:
    """Events counted whatever the blocks, tied, scaled, started anywhere; an oscillator of any size."""
    rows = []
    for method in METHODS:
        found = {blocks: _counts(rotor(), method, blocks)["kick"] for blocks in (1, 64, 1000)}
        elsewhere = scipy_clock("DOP853") if method == "taylor" else ""
        for blocks, count in found.items():
            name = f"kicks of the rotor in {PERIODS} periods, {method}, {blocks} block{'s' * (blocks > 1)}"
            rows.append(Finding(name, float(PERIODS), float(count), 0.0, elsewhere if blocks == 1 else ""))
    ticked = heyoka_ticks()
    count = float(_counts(clock().with_parameters(p=0.0), "taylor", 1000)["tick"])
    rows.append(Finding("ticks at every strobe, 1000 blocks", float(PERIODS), count, 0.0, ticked[0]))
    ticks = _counts(twins(), "taylor", 1000)
    rows.append(
        Finding(
            "ticks of two clocks that tie at every strobe, 1000 blocks",
            "1000 and 2000",
            f"{ticks['one']} and {ticks['two']}",
            0.0,
            ticked[1],
        )
    )
    right = rises()
    for scale in (1.0, 1e3, 1e6, 1e9):
        for switch in (False, True):
            run = cd.trajectory(beside_decay(switch).with_parameters(scale=scale), duration=20.0, samples=2)
            names = run["event_kind"].attrs["flag_meanings"].split()
            found_times = run["event_time"].values[run["event_kind"].values == names.index("rise")]
            what = f"rises of a guard times {scale:g}{' as a switch' if switch else ''}, next to a decay of 2e4"
            elsewhere = "" if switch else heyoka_beside_decay(scale)
            rows.append(Finding(what, float(len(right)), float(len(found_times)), 0.0, elsewhere))
    run = cd.trajectory(free_clock(), duration=1e5, samples=1)
    rows.append(Finding("roots of sin(t − 1/3) until 1e5", 31831.0, float(run.sizes["event"])))
    worst = np.abs(run["event_time"].values - (1 / 3 + math.pi * np.arange(run.sizes["event"]))).max()
    rows.append(Finding("largest error of their times", 0.0, float(worst), 2 * np.spacing(1e5)))
    run = cd.trajectory(escapement().with_initial(x=0.5), duration=100.0, samples=2)
    turn = 2 * math.pi / math.sqrt(0.99)
    off = np.abs(np.diff(run["event_time"].values) - turn).max(initial=0.0)
    ended = cd.Outcome(int(run["outcome"])).meaning
    rows.append(Finding("a clock that starts beyond its guard", "ok", ended))
    rows.append(Finding("its largest distance of two kicks from a turn", 0.0, float(off), 1e-11))
    for size in (1.0, 1e-3, 1e-9):
        run = cd.trajectory(duffing().with_parameters(size=size).with_initial(x=size), duration=100.0, samples=100)
        lost = np.abs(energy(*run["states"].values.T, size, 1.0) / 0.75 - 1).max()
        elsewhere = f"{scipy_oscillator(size, 'DOP853'):.0e} (scipy's DOP853, rtol = 1e-12, its own atol)"
        rows.append(Finding(f"relative error of the energy at the size {size:g}", 0.0, float(lost), 1e-10, elsewhere))
    return rows
