"""Star in the plane of a galaxy.

    x'' = -x - 2 x y,  y'' = -y - x^2 + y^2

The energy (x'^2 + y'^2 + x^2 + y^2)/2 + x^2 y - y^3/3 is kept, and exponents come in pairs of opposite sign. Source:
Hénon and Heiles 1964, doi:10.1086/109234.
"""

from math import sqrt

NAME = "henon-heiles"
SUMMARY = "Hénon and Heiles' star in a galaxy"
GROUP = "smooth flows"
STATES = {"x": "first coordinate", "y": "second coordinate", "p": "first velocity", "q": "second velocity"}
PARAMETERS: dict[str, tuple[float, str]] = {}
EQUATIONS = {
    "modes": {"flow": {"x": "p", "y": "q", "p": "-x - 2*x*y", "q": "-y - x**2 + y**2"}},
    "initial": {"mode": "flow", "x": 0.0, "y": -0.25, "p": sqrt(0.25 - 0.0625 - 1 / 96), "q": 0.0},
}
"""The star at the energy 1/8, in the chaotic sea."""
