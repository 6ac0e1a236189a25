"""Ueda's oscillator, whose strobes draw the Japanese attractor.

    x'' = -k x' - x^3 + amplitude cos t

Exponents 0.1034 and -0.1534 at the default parameters. Source: Ueda 1979, doi:10.1007/BF01011512; exponents: Sprott
2003, Chaos and Time-Series Analysis.
"""

NAME = "ueda"
SUMMARY = "Ueda's oscillator"
GROUP = "smooth flows"
STATES = {"x": "flux", "v": "rate of the flux"}
PARAMETERS = {
    "k": (0.05, "damping"),
    "amplitude": (7.5, "amplitude of the force"),
}
EQUATIONS = {
    "time": "t",
    "modes": {"flow": {"x": "v", "v": "-k*v - x**3 + amplitude*cos(t)"}},
    "period": "2*pi",
    "initial": {"mode": "flow", "x": 2.5, "v": 0.0},
}
"""Ueda's oscillator with default parameters; chaotic."""
