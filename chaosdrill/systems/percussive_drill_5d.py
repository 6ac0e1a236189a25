"""The percussive drill as the paper writes it: five states, autonomous.

    x1' = x2
    x2' = b + a cos(x5 + phi) - 2 xi (x2 - x4) - (x1 - x3)
    x3' = x4                                                       stick: 0
    x4' = eps [(x1 - x3) + 2 xi (x2 - x4) - f(x4)]                 stick: 0
    x5' = eta

It keeps to the paper's effects: one-sided friction, and hits that act at once and are never held. The same physics as
the reduced drill, with two more exponents, both 0: nothing changes if x1 and x3 move together, and the phase x5 only
counts. Digits of x1 - x3 are lost as the bit advances, which the reduced form avoids. Source: equation (7) of the paper
"System for percussive drilling with rock model", with its misprints corrected as on the theory page.
"""

from typing import Any

from chaosdrill.declared import event
from chaosdrill.systems.drill import LABELS, contact, friction
from chaosdrill.systems.drill.assemble import BOUNDS
from chaosdrill.systems.drill.effects import PAPER, limits, parameters

NAME = "percussive-drill-5d"
SUMMARY = "the drill in the autonomous form of the paper, with phase and penetration as states"
GROUP = "drilling"
CITES = ("drilling",)
STATES = {
    "x1": "position of the bit",
    "x2": "speed of the bit",
    "x3": "position of the rock-side mass",
    "x4": "speed of the rock-side mass",
    "x5": "phase of the dynamic load",
}
PARAMETERS = {name: (value, LABELS[name]) for name, value in parameters().items()}
LIMITS = limits()


def equations() -> dict[str, Any]:
    """The drill in five dimensions with the paper's parameters, started at rest."""
    import sympy

    x1, x2, x3, x4, x5 = sympy.symbols(tuple(STATES), real=True)
    a, b, xi, eps, eta, phi, r = sympy.symbols("a b xi eps eta phi r", real=True)
    law = PAPER["contact"]
    load = b + a * sympy.cos(x5 + phi)
    held = x1 - x3 + 2 * xi * x2
    sliding = x1 - x3 + 2 * xi * (x2 - x4)
    resistance = friction.resistance(PAPER["friction"], x4)
    stop = {"guard": x1 - x3 - r, "direction": +1, "priority": 1, "kind": "impact"}
    strong = dict(zip((x2, x4), contact.exchange(law, x2, 0), strict=True))
    free = dict(zip((x2, x4), contact.exchange(law, x2, x4), strict=True))
    weak = {x2: -contact.exit_speed(law, x2)}
    return {
        "modes": {
            "stick": {x1: x2, x2: load - held, x3: 0, x4: 0, x5: eta},
            "slip": {x1: x2, x2: load - sliding, x3: x4, x4: eps * (sliding - resistance), x5: eta},
        },
        "transitions": [
            event("release", "stick", "slip", guard=held - friction.STATIC, direction=+1, kind="slip"),
            event("stick", source="slip", target="stick", guard=x4, direction=-1, reset={x4: 0}),
            event("weak-hit", "stick", "stick", reset=weak, condition=contact.holds(law, x2), **stop),
            event("strong-hit", source="stick", target="slip", reset=strong, **stop),
            event("hit", source="slip", target="slip", reset=free, **stop),
        ],
        "period": 2 * sympy.pi / eta,
        "quadratures": {"penetration": x4},
        "bounds": {x1: None, x3: None, x4: BOUNDS["w"], x5: None},
        "labels": {"penetration": LABELS["penetration"]},
    }
