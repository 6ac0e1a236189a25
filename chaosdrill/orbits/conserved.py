"""Conserved quantities that nothing in the expressions tells of, found at an orbit: every orbit is one of a family."""

from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.orbits.settings import SETTINGS

if TYPE_CHECKING:
    from chaosdrill.orbits.orbit import Orbit
    from chaosdrill.orbits.problem import Problem, Shot


def conserved_at(problem: "Problem", orbit: "Orbit", shot: "Shot") -> np.ndarray:
    """Gradients, at the start of an orbit, of what is conserved along every motion: one a row, shape (m, d).

    A conserved quantity makes the equations of an orbit depend on each other, whatever the parameters do: the map
    around the orbit cannot leave its level (Munoz-Almaraz, Freire, Galan, Doedel and Vanderbauwhede 2003,
    doi:10.1016/S0167-2789(03)00097-6). The combination of equations that vanishes is its gradient. A fold is none,
    since its parameter leads away from it; where branches cross the equations are regular on the orbits beside. Here
    there must be another orbit beside, at the same parameters, whose equations depend on each other as well.

    Parameters
    ----------
    problem : Problem
    orbit : Orbit
        An orbit.
    shot : Shot
        What shooting showed of it.

    Returns
    -------
    ndarray
        Each row has the length 1 in the sizes of the states along the orbit. None (m = 0) where what the expressions
        tell already leaves a family.
    """
    d, count = problem.states, len(orbit)
    nothing = np.zeros((0, d))
    if problem.neutral.held.size or (problem.forced and problem.neutral.flow):
        return nothing
    weights = problem.weights(orbit)
    left = _dependencies(problem, orbit, shot, weights)
    if not len(left):
        return nothing
    fixed = np.eye(problem.columns(orbit))[d + 1 + count :] / weights
    _, _, right = np.linalg.svd(np.vstack([_scaled(problem, orbit, shot, weights)[0], fixed]))
    beside = problem.moved(orbit, shot, SETTINGS.beside_family * right[-1] / weights)
    code, other, seen, _ = problem.newton(beside, weights=weights)
    if code or not len(_dependencies(problem, other, seen, weights)):
        return nothing
    if np.linalg.norm((other.starts - orbit.starts)[:, :d] * weights[:d]) < SETTINGS.beside_family / 10:
        return nothing
    rows = left[:, count : count + d]
    return np.asarray(rows / np.linalg.norm(rows / weights[:d], axis=1, keepdims=True))


def family_words(rows: np.ndarray, names: tuple[str, ...]) -> str:
    """That a quantity is conserved, and which changes of the state it forbids, in words; empty without rows."""
    if not len(rows):
        return ""
    told = [
        " + ".join(f"{value:.3g} {name}" for value, name in zip(row.tolist(), names, strict=True) if value)
        for row in rows
    ]
    return (
        f"the orbit is one of a family at the same parameters, since a quantity is conserved; {' and '.join(told)}, its "
        "differential at the start of the orbit, is held"
    )


def _dependencies(problem: "Problem", orbit: "Orbit", shot: "Shot", weights: np.ndarray) -> np.ndarray:
    """Combinations of the linearised equations that vanish, shape (m, rows)."""
    matrix, scale = _scaled(problem, orbit, shot, weights)
    vectors, sizes, _ = np.linalg.svd(matrix)
    small = sizes <= SETTINGS.smallest_singular_value * sizes[0]
    return np.asarray(vectors[:, : len(sizes)][:, small].T / scale)


def _scaled(problem: "Problem", orbit: "Orbit", shot: "Shot", weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The linearised equations in weighted unknowns, each by the largest of its entries, and these, shape (rows,)."""
    rows = shot.equations[: len(orbit) + problem.states + 1, :-1] / weights
    largest = np.abs(rows).max(axis=1)
    scale = np.where(largest > 0, largest, 1.0)
    return rows / scale[:, np.newaxis], scale
