"""Drill string on a lobed bottom: its torsion sticks and slips, its bit bounces.

    in contact:  M z'' = -c z' - load + force, force = k (bottom - z), bottom = height sin(lobes phi)
                 J w' = K twist - R mu_k force               slip, w > 0
                 w' = 0 while abs(K twist) <= R mu_s force   stick
    in the air:  M z'' = -c z' - load, J w' = K twist
    twist' = speed - w,  phi' = w

z is the height of the bit; the table turns at constant speed and twists the string. On a flat bottom the bit rests at
-load/k and sticks and slips with the period of a mass on a belt. After Yigit and Christoforou 2006,
doi:10.1115/1.2358141; here without damping of the torsion, and dimensionless.
"""

from chaosdrill.declared import event
from chaosdrill.limits import NOT_NEGATIVE, POSITIVE

NAME = "drill-string"
SUMMARY = "drill string with torsion and bit bounce"
GROUP = "drilling"
STATES = {
    "twist": "twist of the string",
    "w": "angular velocity of the bit",
    "phi": "angle of the bit",
    "z": "height of the bit",
    "u": "vertical velocity of the bit",
}
PARAMETERS = {
    "J": (1.0, "moment of inertia of the bit"),
    "K": (1.0, "torsional stiffness of the string"),
    "speed": (1.0, "angular velocity of the table"),
    "M": (1.0, "mass of the string"),
    "c": (1.0, "damping of the vertical motion"),
    "load": (1.0, "weight on the bit at rest"),
    "k": (50.0, "stiffness of the rock"),
    "height": (0.02, "height of the lobes"),
    "lobes": (3.0, "number of lobes"),
    "R": (1.0, "radius of the bit"),
    "mu_s": (1.0, "coefficient of static friction"),
    "mu_k": (0.5, "coefficient of kinetic friction"),
}
LIMITS = {
    "J": POSITIVE,
    "K": NOT_NEGATIVE,
    "M": POSITIVE,
    "c": NOT_NEGATIVE,
    "k": POSITIVE,
    "R": NOT_NEGATIVE,
    "mu_s": NOT_NEGATIVE,
    "mu_k": NOT_NEGATIVE,
}
force = "k*(height*sin(lobes*phi) - z)"
gap = "z - height*sin(lobes*phi)"
fall = "(-c*u - load)/M"
air = {"twist": "speed - w", "w": "K*twist/J", "phi": "w", "z": "u", "u": fall}
slip = {**air, "w": f"(K*twist - R*mu_k*{force})/J", "u": f"{fall} + {force}/M"}
back = {**slip, "w": f"(K*twist + R*mu_k*{force})/J"}
stick = {**slip, "w": "0", "phi": "0"}
grip = f"Abs(K*twist) <= R*mu_s*{force}"
EQUATIONS = {
    "modes": {"slip": slip, "stick": stick, "back": back, "air": air},
    "transitions": [
        event("stick", "slip", "stick", guard="w", direction=-1, reset={"w": "0"}, condition=grip),
        event("turn-back", "slip", "back", guard="w", direction=-1),
        event("stick-again", "back", "stick", "w", +1, reset={"w": "0"}, condition=grip, kind="stick"),
        event("turn-forward", "back", "slip", guard="w", direction=+1),
        event("release", "stick", "slip", guard=f"K*twist - R*mu_s*{force}", direction=+1, kind="slip"),
        event("release-back", "stick", "back", f"K*twist + R*mu_s*{force}", -1, kind="slip"),
        event("lift", ("slip", "stick", "back"), "air", guard=gap, direction=+1),
        event("land", "air", "slip", guard=gap, direction=-1, condition="w > 0"),
        event("land-back", "air", "back", guard=gap, direction=-1, kind="land"),
    ],
    "initial": {"mode": "stick", "twist": 0.0, "w": 0.0, "phi": 0.0, "z": -0.02, "u": 0.0},
}
"""The drill string with default parameters, in stick; it bounces between slips."""
