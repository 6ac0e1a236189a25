"""Duffing's oscillator with a double well.

    x'' = -delta x' - alpha x - beta x^3 + amplitude cos(omega t)

The exponents sum to -delta. Source: Moon and Holmes 1979, doi:10.1016/0022-460X(79)90520-0.
"""

from chaosdrill.limits import POSITIVE

NAME = "duffing"
SUMMARY = "Duffing's forced oscillator"
GROUP = "smooth flows"
STATES = {"x": "displacement", "v": "velocity"}
PARAMETERS = {
    "delta": (0.25, "damping"),
    "alpha": (-1.0, "linear stiffness"),
    "beta": (1.0, "cubic stiffness"),
    "amplitude": (0.4, "amplitude of the force"),
    "omega": (1.0, "forcing frequency"),
}
LIMITS = {"omega": POSITIVE}
EQUATIONS = {
    "time": "t",
    "modes": {"flow": {"x": "v", "v": "-delta*v - alpha*x - beta*x**3 + amplitude*cos(omega*t)"}},
    "period": "2*pi/omega",
    "initial": {"mode": "flow", "x": 0.2, "v": 0.0},
}
"""Duffing's oscillator with default parameters; chaotic."""
