"""On which side of a grazing the orbits with the new event lie, and how unstable they are.

An event of small speed v moves the state after it by about v, while the guard's maximum beyond zero is only about v^2.
So to first order the orbit with the event solves a linear system in v, whose solution starts Newton's method.
"""

from typing import Any

import mpmath
from mpmath import mp

from support.drill_in_series import SLIP, Run
from support.drill_orbits import Special, located
from support.strobe_orbits import Branch, Orbit, touches

OVERLOOK = 1e-2
DEPTH = "1e-8"
"""How far beyond zero the guard's maximum is put to see what an event does."""


def with_event(special: Special, speed: Any) -> tuple[Orbit, Orbit]:
    """The grazing orbit, and the one whose new event has the given speed."""
    kind = special.touched
    touching = touches(kind, mp.mpf(special.time))
    grazing = located(special)
    passing, meeting = Branch(special.periods, SLIP, OVERLOOK), Branch(special.periods, SLIP)
    apart = mp.mpf(10) ** (-mp.dps // 2)
    matrix, rises = mpmath.zeros(4), []
    for j in range(4):
        moved = [a + (apart if i == j else 0) for i, a in enumerate(grazing.unknowns)]
        run = passing.run(moved)
        rises.append((touching(moved, run) - touching(grazing.unknowns, grazing.run)) / apart)
        matrix[3, j] = rises[j]
        for i in range(3):
            matrix[i, j] = (run.state[i] - grazing.run.state[i]) / apart - (i == j)
    size = mp.fdot(rises, rises)
    beyond = [a + mp.mpf(DEPTH) * b / size for a, b in zip(grazing.unknowns, rises, strict=True)]
    missed, met = passing.run(beyond), meeting.run(beyond)
    slow = _slowest(kind, met)
    kick = [-(a - b) / slow for a, b in zip(met.state, missed.state, strict=True)]
    direction = mpmath.lu_solve(matrix, mpmath.matrix([*kick, 0]))
    guess = [a + speed * b for a, b in zip(grazing.unknowns, direction, strict=True)]
    for _ in range(3):
        # the event exists only if the maximum is beyond zero by what its speed asks for
        short = mp.mpf(DEPTH) * (speed / slow) ** 2 - touching(guess, passing.run(guess))
        guess = [a + short * b / size for a, b in zip(guess, rises, strict=True)]
    found = meeting.find(guess, lambda z, run: _slowest(kind, run) - speed)
    if found is None:
        raise ArithmeticError(f"no orbit with the event beside {special.eta}")
    return grazing, found


def _slowest(kind: str, run: Run) -> Any:
    return min(event.speed for event in run.events if event.kind == kind)
