"""Disturbed mass under relay control, which ends in sliding motion.

    x'' = -U + d cos(omega t)   where s = x + tau x' > 0,   +U + d cos(omega t)   where s < 0
    s = 0, x' = -x/tau          while abs(d cos(omega t) - x/tau^2) <= U (Filippov)

Where it slides it forgets the disturbance: x decays like exp(-t/tau), and one exponent is -inf. Source: Utkin 1977,
doi:10.1109/TAC.1977.1101446; di Bernardo, Johansson and Vasca 2001, doi:10.1142/S0218127401002584.
"""

from chaosdrill.limits import NOT_NEGATIVE, POSITIVE

NAME = "relay-sliding"
SUMMARY = "mass under relay control, with sliding"
GROUP = "friction and sliding"
STATES = {"x": "displacement", "s": "distance from the switching surface"}
PARAMETERS = {
    "U": (1.0, "force of the relay over the mass"),
    "tau": (1.0, "time constant of sliding"),
    "d": (0.5, "disturbance over the mass"),
    "omega": (2.0, "frequency of the disturbance"),
}
LIMITS = {"U": NOT_NEGATIVE, "tau": POSITIVE, "omega": POSITIVE}
EQUATIONS = {
    "states": ("x", "v"),
    "time": "t",
    "surface": {"s": "x + tau*v"},
    "above": {"x": "v", "v": "-U + d*cos(omega*t)"},
    "below": {"x": "v", "v": "U + d*cos(omega*t)"},
    "period": "2*pi/omega",
    "initial": {"x": 2.0},
}
"""The relay with default parameters, started above the surface."""
