"""Orbits of one sequence of events over two parameters: a surface, and its tangent plane at one of them."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.orbits.special import LostError

if TYPE_CHECKING:
    from chaosdrill.orbits.family import Family, Lap
    from chaosdrill.orbits.orbit import Orbit


@dataclass(frozen=True)
class Plane:
    """Tangent plane in the reduced unknowns.

    Attributes
    ----------
    rows : ndarray, shape (2, columns)
        Two directions, of length 1 and at right angles in the norm of the weights.
    weights : ndarray, shape (columns,)
        As from `Family.weights`.
    """

    rows: np.ndarray
    weights: np.ndarray

    @property
    def conditions(self) -> np.ndarray:
        """Rows that corrections onto the surface are orthogonal to, shape (2, columns)."""
        return self.rows * self.weights**2

    @property
    def twist(self) -> float:
        """Area of the plane's unit square in the parameters; zero where the surface folds over them."""
        return float(np.linalg.det((self.rows * self.weights)[:, -2:]))

    def part(self, change: np.ndarray) -> np.ndarray:
        """Components along the rows of a change of the reduced unknowns, shape (2,)."""
        return self.conditions @ change

    def across(self, direction: np.ndarray) -> np.ndarray:
        """The direction of the plane at a right angle to one of its own, always turned the same way."""
        a, b = self.part(direction)
        return (np.array([-b, a]) @ self.rows) / np.hypot(a, b)


def plane_at(
    family: "Family", orbit: "Orbit", lap: "Lap", weights: np.ndarray, reference: Plane | None = None
) -> Plane:
    """Tangent plane at an orbit: the null space of its linearised equations.

    Parameters
    ----------
    family : Family
        Of two free parameters.
    orbit, lap : Orbit, Lap
    weights : ndarray, shape (columns,)
    reference : Plane, optional
        Neighbouring plane whose rows these resemble as much as they can, so that they turn with the surface.

    Raises
    ------
    LostError
    """
    if not np.isfinite(lap.equations).all():
        raise LostError("the equations have no derivatives there")
    rows = family.null_space(orbit, lap, weights, 2) / weights
    if reference is not None:
        # orthogonal Procrustes problem, Schoenemann 1966, doi:10.1007/BF02289451
        u, _, v = np.linalg.svd(reference.conditions @ rows.T)
        rows = u @ v @ rows
    return Plane(rows, weights)
