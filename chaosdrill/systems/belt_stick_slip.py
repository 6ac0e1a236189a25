"""Mass on a spring, dragged by a belt at constant speed through Coulomb friction.

    stick:     x' = belt                      while abs(x) <= F_s
    slip:      x'' = -x + F_k                 slower than the belt
    overtake:  x'' = -x - F_k                 faster than the belt

Mass and stiffness are 1, static friction is F_s, kinetic friction F_k < F_s. The stick-slip cycle has the period
2 D/belt + 2 pi - 2 atan(D/belt), D = F_s - F_k, and the multipliers 1 and 0. Source: Leine and Nijmeijer 2004,
doi:10.1007/978-3-540-44398-8.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem

NAME = "belt-stick-slip"
SUMMARY = "spring-held mass on a moving belt, Coulomb friction"
GROUP = "friction and sliding"
CITES = ("leine2004",)
STATES = ("x", "v")
PARAMETERS = {"belt": 0.2, "F_s": 1.0, "F_k": 0.5}
LABELS = {
    "x": "displacement of the mass, stretch of the spring",
    "v": "velocity of the mass",
    "belt": "speed of the belt",
    "F_s": "static friction force",
    "F_k": "kinetic friction force",
}


def system() -> "HybridSystem":
    """The belt oscillator with default parameters, started in stick at rest length."""
    import sympy

    from chaosdrill.model import HybridSystem, Transition

    x, v, belt, f_s, f_k = sympy.symbols("x v belt F_s F_k", real=True)
    catch_up = {"guard": v - belt, "direction": +1}
    fall_back = {"guard": v - belt, "direction": -1}
    grip = sympy.Abs(x) <= f_s
    return HybridSystem(
        name=NAME,
        states=(x, v),
        parameters=PARAMETERS,
        modes={
            "stick": {x: belt, v: 0},
            "slip": {x: v, v: f_k - x},
            "overtake": {x: v, v: -f_k - x},
        },
        transitions=[
            Transition("release", source="stick", target="slip", guard=x - f_s, direction=+1, kind="slip"),
            Transition("stick", source="slip", target="stick", reset={v: belt}, condition=grip, **catch_up),
            Transition("overtake", source="slip", target="overtake", **catch_up),
            Transition("hold", "overtake", "stick", reset={v: belt}, condition=grip, kind="stick", **fall_back),
            Transition("fall-back", source="overtake", target="slip", kind="slip", **fall_back),
        ],
        initial={"mode": "stick", x: 0.0, v: PARAMETERS["belt"]},
        description=SUMMARY,
        labels=LABELS,
    )
