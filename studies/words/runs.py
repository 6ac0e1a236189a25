"""Runs whose nature is known: flows without forcing, events, surfaces, the drill; a spectrum calls them.

Every family is a function of a random generator and of a length in points, and returns a system, the lengths that a
spectrum takes, and whether the run is too short for its word by construction, as in `records`.
"""

import numpy as np

import chaosdrill as cd

LORENZ = cd.build("lorenz")
RETURN = 0.75
"""Mean time between the points of Lorenz's chaos on a surface, and of a turn within its window."""
ONE = {"x": "m*x - y - x*(x**2 + y**2)", "y": "x + m*y - y*(x**2 + y**2)"}
OTHER = {"u": "m*u - w*v - u*(u**2 + v**2)", "v": "w*u + m*v - v*(u**2 + v**2)"}
CYCLE = cd.HybridSystem(name="cycle", states="x y", parameters={"m": 0.1}, modes={"on": ONE})
TORUS = cd.HybridSystem(name="torus", states="x y u v", parameters={"m": 0.1, "w": 1.0}, modes={"on": ONE | OTHER})
WEAKLY = {"x": "y", "y": "m*(1 - x**2)*y - x + k*(u - x)", "u": "w*v", "v": "w*(m*(1 - u**2)*v - u) + k*(x - u)"}
COUPLED = cd.HybridSystem(
    name="coupled", states="x y u v", parameters={"m": 0.5, "w": 1.0, "k": 0.01}, modes={"on": WEAKLY}
)
SWITCH = cd.HybridSystem(
    name="switch",
    states="x clock",
    parameters={"a": 0.4},
    modes={"wait": {"x": "0", "clock": "1"}},
    transitions=[
        cd.Transition("low", "wait", "wait", "clock - 1", 1, {"x": "x/a", "clock": "0"}, condition="x < a"),
        cd.Transition("high", "wait", "wait", "clock - 1", 1, {"x": "(1 - x)/(1 - a)", "clock": "0"}),
    ],
    initial={"x": 0.3, "clock": 0.0},
)
CARRIED = cd.HybridSystem(
    name="carried",
    states="x y z s",
    parameters={"rho": 28.0},
    modes={"on": {"x": "10*(y - x)", "y": "x*(rho - z) - y", "z": "x*y - 8*z/3", "s": "z"}},
)
DRIVEN = {"x": "v", "v": "cos(n*phi) - x - v/2", "phi": "w + x/50"}
ROTOR = cd.HybridSystem(name="rotor", states="phi x v", parameters={"n": 1.0, "w": 1.0}, modes={"on": DRIVEN})
ROTORS = cd.HybridSystem(
    name="rotors",
    states="phi psi x v",
    parameters={"w": 1.0, "k": 1.4},
    modes={"on": {"phi": "w", "psi": "k", "x": "v", "v": "cos(phi) + sin(psi)/2 - x - v/2"}},
)
FLIGHT = {"x": "u", "y": "v", "u": "0", "v": "0"}
PUSH = "2*(u*x/a**2 + v*y)/((x/a**2)**2 + y**2)"
SIDE = cd.Transition("side", "in", "in", "(x/a)**2 + y**2 - 1", 1, {"u": f"u - {PUSH}*x/a**2", "v": f"v - {PUSH}*y"})
ELLIPSE = cd.HybridSystem(
    name="ellipse", states="x y u v", parameters={"a": 2.0}, modes={"in": FLIGHT}, transitions=[SIDE]
)
DRILL = cd.drill(friction="stribeck", contact="hunt-crossley", eta=0.448)


def lorenz(rng):
    """Lorenz's system where the chaos of its classical parameters is known to go on."""
    return LORENZ.with_parameters(rho=rng.uniform(26, 29.5)).with_initial(x=rng.uniform(1, 10), y=2.0, z=20.0)


def by_time(rng, length):
    return lorenz(rng), {"duration": length * RETURN, "transient": 30}, False


def by_surface(rng, length):
    return lorenz(rng), {"periods": length, "at": "x > 0", "transient": 20}, False


def by_events(rng, length):
    """Skew tents that a clock without forcing works."""
    system = SWITCH.with_parameters(a=rng.uniform(0.2, 0.8)).with_initial(x=rng.uniform(0.1, 0.9))
    return system, {"duration": float(length), "transient": 20}, False


def laminar(rng, length):
    """Lorenz's system above its window at 166.06, where a laminar phase takes up to hundreds of turns."""
    system = LORENZ.with_parameters(rho=166.062 + 10 ** rng.uniform(-3, -0.7)).with_initial(x=rng.normal() * 10)
    return system, {"duration": length * RETURN, "transient": 50}, length <= 256


def departure(rng, system, length, names):
    """From near an unstable rest to the cycle or torus around it, which it reaches like exp(m t)."""
    rate, off = 10 ** rng.uniform(-2.5, -0.5), 10 ** rng.uniform(-9, -1)
    duration = 6.0 * length
    there = np.log(np.sqrt(rate) / min(off, np.sqrt(rate))) / rate
    start = dict.fromkeys(names, off)
    return system.with_parameters(m=rate).with_initial(**start), {"duration": duration}, duration / 2 < there + 5 / rate


def cycles(rng, length):
    return departure(rng, CYCLE, length, "x")


def tori(rng, length):
    ratio = rng.choice([np.sqrt(2), np.sqrt(3), (np.sqrt(5) - 1) / 2, np.sqrt(7) - 1])
    return departure(rng, TORUS.with_parameters(w=ratio), length, "xu")


def coupled(rng, length):
    """Two oscillators of van der Pol whose frequencies a weak coupling hardly changes."""
    ratio, weak = rng.choice([np.sqrt(2), np.sqrt(3), np.sqrt(7) - 1]), 10 ** rng.uniform(-4, -1.5)
    system = COUPLED.with_parameters(w=ratio, k=weak, m=rng.uniform(0.1, 1))
    return system.with_initial(x=rng.uniform(0.5, 2), u=1.0), {"duration": 6.0 * length, "transient": 300}, False


def shot(x, angle, a, length):
    """A shot in an ellipse that meets it about so many times."""
    start = {"x": float(x), "y": 0.0, "u": float(np.cos(angle)), "v": float(np.sin(angle))}
    return ELLIPSE.with_parameters(a=float(a)).with_initial(**start), {"duration": 1.5 * length * a}, False


def shots(rng, length):
    """Of any kind: off a hyperbola or an ellipse of the same foci."""
    a = rng.uniform(1.05, 3)
    return *shot(rng.uniform(-0.9, 0.9) * a, rng.uniform(0.2, 2.9), a, length)[:2], length <= 256


def stars(rng, length):
    """Stars in a circle, of up to 30 sides."""
    sides = int(rng.integers(3, 31))
    turns = next(t for t in iter(lambda: int(rng.integers(1, sides)), 0) if 2 * t < sides and np.gcd(t, sides) == 1)
    return *shot(np.cos(np.pi * turns / sides), np.pi / 2, 1.0, length)[:2], length <= 4 * sides


def carried(rng, length):
    """Lorenz's system with the integral of one of its states, which only grows."""
    return (
        CARRIED.with_parameters(rho=rng.uniform(26, 29.5)).with_initial(x=rng.uniform(1, 10), y=2.0, z=20.0),
        {
            "duration": length * RETURN,
            "transient": 30,
        },
        False,
    )


def rotor(rng, length):
    """A rotor that drives an oscillator, which drives it too weakly to stop it: an angle with a parameter."""
    n, rate = float(rng.integers(1, 6)), rng.uniform(0.4, 1.5)
    system = ROTOR.with_parameters(n=n, w=rate / n).with_initial(phi=rng.uniform(-9, 9))
    return system, {"duration": 6.0 * length / rate, "transient": 60}, False


def rotors(rng, length):
    """Two rotors without a common period that drive an oscillator."""
    ratio = rng.choice([np.sqrt(2), np.sqrt(3), (np.sqrt(5) - 1) / 2, np.sqrt(7) - 1])
    rate = rng.uniform(0.5, 1.5)
    system = ROTORS.with_parameters(w=rate, k=rate * ratio).with_initial(phi=rng.uniform(-9, 9))
    return system, {"duration": 6.0 * length / rate, "transient": 60}, False


def drill(rng, length):
    """Stretches of the drill's chaos, whose exponent is 44 standard errors above zero in 20,000 periods."""
    return DRILL, {"periods": length, "transient": int(rng.integers(300, 2000))}, False


RUNS = {
    "Lorenz by time": (by_time, "chaotic"),
    "Lorenz at a surface": (by_surface, "chaotic"),
    "tents by events": (by_events, "chaotic"),
    "Lorenz, laminar": (laminar, "chaotic"),
    "flows to cycles": (cycles, "periodic"),
    "flows to tori": (tori, "quasiperiodic"),
    "coupled oscillators": (coupled, "quasiperiodic"),
    "shots in an ellipse": (shots, "quasiperiodic"),
    "stars in a circle": (stars, "periodic"),
    "a state carried along": (carried, "chaotic"),
    "a rotor": (rotor, "periodic"),
    "two rotors": (rotors, "quasiperiodic"),
    "the drill": (drill, "chaotic"),
}
"""Families, and the one word for each."""


def called(family, rng, count, length):
    """Words for so many runs, and which are too short for theirs."""
    words, short = [], []
    for _ in range(count):
        system, lengths, too_short = family(rng, length)
        words.append(cd.lyapunov_spectrum(system, **lengths).cd.outcome)
        short.append(too_short)
    return words, np.array(short)
