"""Lorenz's model of convection, a smooth flow.

    x' = sigma (y - x),  y' = rho x - y - x z,  z' = x y - beta z

Source: Lorenz 1963, doi:10.1175/1520-0469(1963)020<0130:DNF>2.0.CO;2.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem

NAME = "lorenz"
SUMMARY = "Lorenz's convection model"
GROUP = "smooth flows"
CITES = ("lorenz1963",)
STATES = ("x", "y", "z")
PARAMETERS = {"sigma": 10.0, "rho": 28.0, "beta": 8 / 3}
LABELS = {
    "x": "intensity of convection",
    "y": "temperature difference of the streams",
    "z": "distortion of the temperature profile",
    "sigma": "Prandtl number",
    "rho": "Rayleigh number over its critical value",
    "beta": "geometric factor of the cell",
}


def system() -> "HybridSystem":
    """Lorenz's model with its classic parameters; exponents about 0.9056, 0, -14.572."""
    import sympy

    from chaosdrill.model import HybridSystem

    x, y, z, sigma, rho, beta = sympy.symbols("x y z sigma rho beta", real=True)
    return HybridSystem(
        name=NAME,
        states=(x, y, z),
        parameters=PARAMETERS,
        modes={"flow": {x: sigma * (y - x), y: rho * x - y - x * z, z: x * y - beta * z}},
        initial={"mode": "flow", x: 1.0, y: 1.0, z: 20.0},
        description=SUMMARY,
        labels=LABELS,
    )
