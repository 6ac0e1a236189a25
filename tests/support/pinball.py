"""Three disks of radius 1, centres 6 apart: a point bounces between them until it leaves for ever (a pinball).

Cvitanovic et al., Chaos: Classical and Quantum, chaosbook.org: cycles and their stabilities in the fundamental domain.
"""

from collections import Counter
from itertools import product

import numpy as np

from chaosdrill.model import HybridSystem, Transition

CENTRES = np.array([[0.0, 0.0], [6.0, 0.0], [3.0, 3 * 3**0.5]])

ROUNDS = {
    2: (8.0, 9.898979485566356**2),
    3: (3 * 4.267949192431, -(11.77145514**3)),
    4: (2 * 8.316529485168, 124.0948019921**2),
}
"""Times and leading multipliers of cycles of two, three and four bounces."""


def pinball(order=(0, 1, 2), states="x y p", unit=1.0, away=0.0, **options):
    """The system: place (x, y) and direction p of motion at speed ``unit``, disks in any order, ``away`` from 0."""
    x, y = f"(x/{unit!r} - {away!r})", f"(y/{unit!r})"
    bounces = [
        Transition(
            f"d{i}", "m", "m", f"1 - ({x} - {cx!r})**2 - ({y} - {cy!r})**2", 1, kind="bounce",
            reset={"p": f"Mod(2*atan2({y} - {cy!r}, {x} - {cx!r}) + pi - p + 1, 2*pi) - 1"},
        )
        for i, (cx, cy) in ((i, CENTRES[i].tolist()) for i in order)
    ]  # fmt: skip
    return HybridSystem(
        name="pinball", states=states, parameters={}, transitions=bounces,
        modes={"m": {"x": f"{unit!r}*cos(p)", "y": f"{unit!r}*sin(p)", "p": "0"}},
        initial={"x": (1.5 + away) * unit, "y": 0.0, "p": 0.01}, **options,
    )  # fmt: skip


def on_triangle(first, second):
    """Place halfway between two disks, and direction, on the cycle round all three of them."""
    inner = CENTRES + (CENTRES.mean(axis=0) - CENTRES) / np.linalg.norm(CENTRES.mean(axis=0) - CENTRES, axis=1)[:, None]
    way = inner[second] - inner[first]
    x, y = inner[first] + way / 2
    return {"x": float(x), "y": float(y), "p": float((np.arctan2(way[1], way[0]) + 1) % (2 * np.pi) - 1)}


def least(word):
    """The first of all cyclic shifts."""
    return min(tuple(word[i:]) + tuple(word[:i]) for i in range(len(word)))


def itineraries(most):
    """Cyclic sequences of disks, no disk twice in a row, none the power of another, none oftener than ``most``."""
    found = set()
    for length in range(2, 3 * most + 1):
        for word in product(range(3), repeat=length):
            shifts = {word[i:] + word[:i] for i in range(length)}
            again = any(word[i] == word[i - 1] for i in range(length))
            if not again and len(shifts) == length and max(Counter(word).values()) <= most:
                found.add(min(shifts))
    return found
