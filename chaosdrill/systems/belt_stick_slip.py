"""Mass on a spring, dragged by a belt at constant speed through Coulomb friction.

    stick:     x' = belt                      while abs(x) <= F_s
    slip:      x'' = -x + F_k                 slower than the belt
    overtake:  x'' = -x - F_k                 faster than the belt

Mass and stiffness are 1, static friction is F_s, kinetic friction F_k < F_s. The stick-slip cycle has the period
2 D/belt + 2 pi - 2 atan(D/belt), D = F_s - F_k, and the multipliers 1 and 0. Source: Leine and Nijmeijer 2004,
doi:10.1007/978-3-540-44398-8.
"""

from chaosdrill.declared import event
from chaosdrill.limits import NOT_NEGATIVE

NAME = "belt-stick-slip"
SUMMARY = "spring-held mass on a moving belt, Coulomb friction"
GROUP = "friction and sliding"
CITES = ("leine2004",)
STATES = {"x": "displacement of the mass, stretch of the spring", "v": "velocity of the mass"}
PARAMETERS = {
    "belt": (0.2, "speed of the belt"),
    "F_s": (1.0, "static friction force"),
    "F_k": (0.5, "kinetic friction force"),
}
LIMITS = {"belt": NOT_NEGATIVE, "F_s": NOT_NEGATIVE, "F_k": NOT_NEGATIVE}
catch_up = {"guard": "v - belt", "direction": +1}
fall_back = {"guard": "v - belt", "direction": -1}
held = {"reset": {"v": "belt"}, "condition": "Abs(x) <= F_s"}
EQUATIONS = {
    "modes": {
        "stick": {"x": "belt", "v": "0"},
        "slip": {"x": "v", "v": "F_k - x"},
        "overtake": {"x": "v", "v": "-F_k - x"},
    },
    "transitions": [
        # a start in stick may have another velocity, as where only the belt is given another speed
        event("release", "stick", "slip", guard="x - F_s", direction=+1, reset={"v": "belt"}, kind="slip"),
        event("stick", "slip", "stick", **held, **catch_up),
        event("overtake", "slip", "overtake", **catch_up),
        event("hold", "overtake", "stick", kind="stick", **held, **fall_back),
        event("fall-back", "overtake", "slip", kind="slip", **fall_back),
    ],
    "initial": {"mode": "stick", "x": 0.0, "v": PARAMETERS["belt"][0]},
}
"""The belt oscillator with default parameters, started in stick at rest length."""
