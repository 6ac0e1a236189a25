"""Two masses on a belt that moves at constant speed, held by springs and joined by one, with Coulomb friction.

    stick:     x_j' = belt                                while abs(p_j) <= F_s,  p_j = x_j + k (x_j - x_i)
    slip:      x_j'' = -p_j + F_k                         slower than the belt
    overtake:  x_j'' = -p_j - F_k                         faster than the belt

Friction is two-sided: a mass lets go forward and backward. Masses and springs are 1; moving as one, the masses have the
stick-slip cycle of one mass. Source: Galvanetto and Bishop 1999, doi:10.1023/A:1008307332284.
"""

from typing import Any

from chaosdrill.declared import Event, event
from chaosdrill.limits import NOT_NEGATIVE

NAME = "two-masses-on-belt"
SUMMARY = "two coupled masses on a moving belt, two-sided Coulomb friction"
GROUP = "friction and sliding"
STATES = {
    "x1": "displacement of the first mass",
    "v1": "velocity of the first mass",
    "x2": "displacement of the second mass",
    "v2": "velocity of the second mass",
}
PARAMETERS = {
    "belt": (0.2, "speed of the belt"),
    "k": (0.4, "stiffness between the masses"),
    "F_s": (1.0, "static friction force"),
    "F_k": (0.5, "kinetic friction force"),
}
LIMITS = {"belt": NOT_NEGATIVE, "k": NOT_NEGATIVE, "F_s": NOT_NEGATIVE, "F_k": NOT_NEGATIVE}


def _pull(j: int) -> str:
    return f"(x{j} + k*(x{j} - x{3 - j}))"


def _rates(j: int, motion: str) -> dict[str, str]:
    """How a mass moves."""
    if motion == "stick":
        return {f"x{j}": "belt", f"v{j}": "0"}
    return {f"x{j}": f"v{j}", f"v{j}": f"-{_pull(j)} {'+' if motion == 'slip' else '-'} F_k"}


def _events(j: int, mode: str) -> list[Event]:
    """How a mass changes its motion, in a mode of the other one."""
    pull, speed = _pull(j), f"v{j} - belt"
    stick, slip, overtake = (mode.format(motion) for motion in ("stick", "slip", "overtake"))
    other = mode.format(j)

    def change(kind: str, source: str, target: str, guard: str, direction: int, **more: Any) -> Event:
        return event(f"{kind}-{other}", source, target, guard, direction, kind=kind, **more)

    # a start in stick may have another velocity, as where only the belt is given another speed
    carried: dict[str, Any] = {"reset": {f"v{j}": "belt"}}
    grip = carried | {"condition": f"Abs{pull} <= F_s"}
    return [
        change("release", stick, slip, f"{pull} - F_s", +1, **carried),
        change("push", stick, overtake, f"{pull} + F_s", -1, **carried),
        change("stick", slip, stick, speed, +1, **grip),
        change("pass", slip, overtake, speed, +1),
        change("hold", overtake, stick, speed, -1, **grip),
        change("fall-back", overtake, slip, speed, -1),
    ]


belt, motions = PARAMETERS["belt"][0], ("stick", "slip", "overtake")
EQUATIONS = {
    "modes": {f"{first}-{second}": _rates(1, first) | _rates(2, second) for first in motions for second in motions},
    "transitions": [
        *(one for other in motions for one in _events(1, "{}-" + other)),
        *(one for other in motions for one in _events(2, other + "-{}")),
    ],
    "initial": {"mode": "stick-stick", "x1": 0.0, "v1": belt, "x2": 0.3, "v2": belt},
}
"""The two masses with default parameters, both in stick."""
