"""Lorenz's model of convection, a smooth flow.

    x' = sigma (y - x),  y' = rho x - y - x z,  z' = x y - beta z

Source: Lorenz 1963, doi:10.1175/1520-0469(1963)020<0130:DNF>2.0.CO;2.
"""

NAME = "lorenz"
SUMMARY = "Lorenz's convection model"
GROUP = "smooth flows"
CITES = ("lorenz1963",)
STATES = {
    "x": "intensity of convection",
    "y": "temperature difference of the streams",
    "z": "distortion of the temperature profile",
}
PARAMETERS = {
    "sigma": (10.0, "Prandtl number"),
    "rho": (28.0, "Rayleigh number over its critical value"),
    "beta": (8 / 3, "geometric factor of the cell"),
}
EQUATIONS = {
    "modes": {"flow": {"x": "sigma*(y - x)", "y": "rho*x - y - x*z", "z": "x*y - beta*z"}},
    "initial": {"mode": "flow", "x": 1.0, "y": 1.0, "z": 20.0},
}
"""Lorenz's model with its classic parameters; exponents about 0.9056, 0, -14.572."""
