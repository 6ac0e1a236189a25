"""Disturbed mass under relay control, which ends in sliding motion.

    x'' = -U + d cos(omega t)   where s = x + tau x' > 0,   +U + d cos(omega t)   where s < 0
    s = 0, x' = -x/tau          while abs(d cos(omega t) - x/tau^2) <= U (Filippov)

Where it slides it forgets the disturbance: x decays like exp(-t/tau), and one exponent is -inf. Source: Utkin 1977,
doi:10.1109/TAC.1977.1101446; di Bernardo, Johansson and Vasca 2001, doi:10.1142/S0218127401002584.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem

NAME = "relay-sliding"
SUMMARY = "mass under relay control, with sliding"
GROUP = "friction and sliding"
STATES = ("x", "s")
PARAMETERS = {"U": 1.0, "tau": 1.0, "d": 0.5, "omega": 2.0}
LABELS = {
    "x": "displacement",
    "s": "distance from the switching surface",
    "U": "force of the relay over the mass",
    "tau": "time constant of sliding",
    "d": "disturbance over the mass",
    "omega": "frequency of the disturbance",
}


def system() -> "HybridSystem":
    """The relay with default parameters, started above the surface."""
    from chaosdrill.model.filippov import filippov

    return filippov(
        name=NAME,
        states=("x", "v"),
        time="t",
        parameters=PARAMETERS,
        surface={"s": "x + tau*v"},
        above={"x": "v", "v": "-U + d*cos(omega*t)"},
        below={"x": "v", "v": "U + d*cos(omega*t)"},
        period="2*pi/omega",
        initial={"x": 2.0},
        description=SUMMARY,
        labels=LABELS,
    )
