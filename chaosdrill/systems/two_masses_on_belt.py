"""Two masses on a belt that moves at constant speed, held by springs and joined by one, with Coulomb friction.

    stick:     x_j' = belt                                while abs(p_j) <= F_s,  p_j = x_j + k (x_j - x_i)
    slip:      x_j'' = -p_j + F_k                         slower than the belt
    overtake:  x_j'' = -p_j - F_k                         faster than the belt

Friction is two-sided: a mass lets go forward and backward. Masses and springs are 1; moving as one, the masses have the
stick-slip cycle of one mass. Source: Galvanetto and Bishop 1999, doi:10.1023/A:1008307332284.
"""

from typing import TYPE_CHECKING, Any

from chaosdrill.limits import NOT_NEGATIVE

if TYPE_CHECKING:
    from chaosdrill.model import Transition

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


def equations() -> dict[str, Any]:
    """The two masses with default parameters, both in stick."""
    motions = ("stick", "slip", "overtake")
    return {
        "modes": {f"{first}-{second}": _rates(1, first) | _rates(2, second) for first in motions for second in motions},
        "transitions": [
            *(event for other in motions for event in _events(1, "{}-" + other)),
            *(event for other in motions for event in _events(2, other + "-{}")),
        ],
        "initial": {
            "mode": "stick-stick",
            "x1": 0.0,
            "v1": PARAMETERS["belt"][0],
            "x2": 0.3,
            "v2": PARAMETERS["belt"][0],
        },
    }


def _pull(j: int) -> str:
    return f"(x{j} + k*(x{j} - x{3 - j}))"


def _rates(j: int, motion: str) -> dict[str, str]:
    """How a mass moves."""
    if motion == "stick":
        return {f"x{j}": "belt", f"v{j}": "0"}
    return {f"x{j}": f"v{j}", f"v{j}": f"-{_pull(j)} {'+' if motion == 'slip' else '-'} F_k"}


def _events(j: int, mode: str) -> "list[Transition]":
    """How a mass changes its motion, in a mode of the other one."""
    from chaosdrill.model import Transition

    pull, speed = _pull(j), f"v{j} - belt"
    stick, slip, overtake = (mode.format(motion) for motion in ("stick", "slip", "overtake"))
    other = mode.format(j)

    def event(kind: str, source: str, target: str, guard: str, direction: int, **more: Any) -> "Transition":
        return Transition(f"{kind}-{other}", source, target, guard, direction, kind=kind, **more)

    # a start in stick may have another velocity, as where only the belt is given another speed
    carried: dict[str, Any] = {"reset": {f"v{j}": "belt"}}
    grip = carried | {"condition": f"Abs{pull} <= F_s"}
    return [
        event("release", stick, slip, f"{pull} - F_s", +1, **carried),
        event("push", stick, overtake, f"{pull} + F_s", -1, **carried),
        event("stick", slip, stick, speed, +1, **grip),
        event("pass", slip, overtake, speed, +1),
        event("hold", overtake, stick, speed, -1, **grip),
        event("fall-back", overtake, slip, speed, -1),
    ]
