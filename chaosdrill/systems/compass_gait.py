"""Passive compass walker on a slope: two legs with a mass each, and a mass at the hip.

    m b^2 n'' - m l b cos(s - n) s'' = -m l b sin(s - n) s'^2 - m b g sin n
    (M l^2 + m a^2 + m l^2) s'' - m l b cos(s - n) n'' = m l b sin(s - n) n'^2 + (M l + m a + m l) g sin s
    at heel strike, s + n = -2 slope: the legs change roles, angular momenta about the new foot and the hip are kept

s is the angle of the stance leg, n that of the swing leg, l = a + b. The swing foot may pass through the ground, as in
the source: Goswami, Thuilot and Espiau 1998, doi:10.1177/027836499801701202.
"""

from math import pi

from chaosdrill.declared import event
from chaosdrill.limits import NOT_NEGATIVE, POSITIVE

NAME = "compass-gait"
SUMMARY = "compass-like biped on a slope"
GROUP = "walkers"
STATES = {
    "n": "angle of the swing leg",
    "s": "angle of the stance leg",
    "p": "angular velocity of the swing leg",
    "q": "angular velocity of the stance leg",
}
PARAMETERS = {
    "M": (10.0, "mass of the hip"),
    "m": (5.0, "mass of a leg"),
    "a": (0.5, "length from foot to mass of a leg"),
    "b": (0.5, "length from mass of a leg to hip"),
    "g": (9.81, "gravity"),
    "slope": (pi / 60, "inclination of the ground"),
}
LIMITS = {"M": NOT_NEGATIVE, "m": POSITIVE, "a": NOT_NEGATIVE, "b": POSITIVE, "g": POSITIVE}
leg = "(a + b)"
swing, stance = "m*b**2", f"(M*{leg}**2 + m*a**2 + m*{leg}**2)"
cross = f"(m*{leg}*b*cos(s - n))"


def solved(first: str, second: str) -> dict[str, str]:
    """What the mass matrix takes to these two."""
    over = f"/({swing}*{stance} - {cross}**2)"
    return {
        "p": f"({stance}*({first}) + {cross}*({second})){over}",
        "q": f"({cross}*({first}) + {swing}*({second})){over}",
    }


forces = solved(
    f"-m*{leg}*b*sin(s - n)*q**2 - m*b*g*sin(n)",
    f"m*{leg}*b*sin(s - n)*p**2 + (M*{leg} + m*a + m*{leg})*g*sin(s)",
)
momenta = solved("-m*a*b*q", f"(M*{leg}**2 + 2*m*a*{leg})*cos(s - n)*q - m*a*b*p")
EQUATIONS = {
    "modes": {"stance": {"n": "p", "s": "q", **forces}},
    "transitions": [
        event(
            "heel-strike",
            "stance",
            "stance",
            guard="n + s + 2*slope",
            direction=-1,
            reset={"n": "s", "s": "n", **momenta},
            condition="n > s",
            kind="impact",
        )
    ],
    "initial": {"mode": "stance", "n": -0.3234, "s": 0.2187, "p": -0.3772, "q": -1.0918},
}
"""The compass on a slope of 3 degrees, started near its gait."""
