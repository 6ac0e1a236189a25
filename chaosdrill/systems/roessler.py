"""Rössler's flow, the simplest smooth chaos.

    x' = -y - z,  y' = x + a y,  z' = b + z (x - c)

Source: Rössler 1976, doi:10.1016/0375-9601(76)90101-8.
"""

NAME = "roessler"
SUMMARY = "Rössler's single-scroll flow"
GROUP = "smooth flows"
CITES = ("roessler1976",)
STATES = {
    "x": "first coordinate of the scroll",
    "y": "second coordinate of the scroll",
    "z": "coordinate across the scroll",
}
PARAMETERS = {
    "a": (0.2, "growth rate within the scroll"),
    "b": (0.2, "feed across the scroll"),
    "c": (5.7, "position of the fold"),
}
EQUATIONS = {
    "modes": {"flow": {"x": "-y - z", "y": "x + a*y", "z": "b + z*(x - c)"}},
    "initial": {"mode": "flow", "x": 1.0, "y": 1.0, "z": 0.0},
}
"""Rössler's flow with its classic parameters; exponents about 0.0718, 0, -5.3945."""
