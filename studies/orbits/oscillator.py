"""Grazing of the impact oscillator, which has a closed form.

Without impacts the oscillator is linear, and its amplitude is 1/sqrt((1 - w^2)^2 + (2 zeta w)^2). It grazes the wall
where that is the wall's distance.
"""

import numpy as np
import xarray as xr

import chaosdrill as cd

ZETA = 0.05
CASES = (
    ({"wall": 0.3, "omega": 2.3}, {"omega": (2.02, 2.4)}),
    ({"wall": 2.0, "omega": 1.4}, {"omega": (1.15, 1.5)}),
    ({"wall": 2.0, "omega": 0.6}, {"omega": (0.5, 0.8)}),
    ({"wall": 0.21, "omega": 2.5}, {"wall": (0.15, 0.25)}),
)
"""Start without impacts, and the range of the parameter that is followed."""


def amplitude(omega: float) -> float:
    """Amplitude without impacts."""
    return float(1 / np.hypot(1 - omega**2, 2 * ZETA * omega))


def closed_form(parameters: dict[str, float], name: str, near: float) -> float:
    """Value of a parameter, near a given one, at which the oscillator grazes."""
    if name == "wall":
        return amplitude(parameters["omega"])
    # w^4 - 2 (1 - 2 zeta^2) w^2 + 1 - 1/wall^2 = 0
    half = 1 - 2 * ZETA**2
    squares = half + np.array([-1, 1]) * np.sqrt(half**2 - 1 + parameters["wall"] ** -2)
    roots = np.sqrt(squares[squares > 0])
    return float(roots[np.abs(roots - near).argmin()])


def branches() -> list[xr.Dataset]:
    """Return the branches that begin without impacts."""
    found = []
    for parameters, sweep in CASES:
        response = 1 / complex(1 - parameters["omega"] ** 2, 2 * ZETA * parameters["omega"])
        state = {"x": response.real, "v": -parameters["omega"] * response.imag}
        system = cd.build("impact-oscillator", {"zeta": ZETA, **parameters}).with_initial(**state)
        found.append(cd.continue_orbit(system, sweep, start="guess", max_points=400))
    return found
