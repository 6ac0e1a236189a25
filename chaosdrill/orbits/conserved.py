"""Conserved quantities that the expressions do not show, found at an orbit that belongs to a family."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.orbits.neutral import neutral_of
from chaosdrill.orbits.tuning import TUNING

if TYPE_CHECKING:
    from chaosdrill.orbits.orbit import Orbit
    from chaosdrill.orbits.problem import Problem, Shot


def conserved_at(problem: "Problem", orbit: "Orbit", shot: "Shot") -> np.ndarray:
    """Gradients, at the start of an orbit, of what is conserved along every motion: one a row, shape (m, d).

    A conserved quantity makes the equations of an orbit depend on each other, whatever the parameters do: the map
    around the orbit cannot leave its level (Munoz-Almaraz, Freire, Galan, Doedel and Vanderbauwhede 2003,
    doi:10.1016/S0167-2789(03)00097-6). The combination of equations that vanishes is its gradient. A fold does not
    count, since its parameter leads away from it; where branches cross, the equations are regular on neighbouring
    orbits. Here a neighbouring orbit must exist at the same parameters whose equations depend on each other as well.

    ``shot``: what shooting showed of the orbit.

    Each row has the length 1 in the sizes of the states along the orbit. None (m = 0) where some were found before, and
    of what only the expressions tell, as that the rate of a state is 0.
    """
    d, count = problem.states, len(orbit)
    nothing, known = np.zeros((0, d)), problem.neutral
    if len(problem.conserved) or (problem.forced and (known.flow or known.conserved.size)):
        return nothing
    weights = problem.weights(orbit)
    left = _dependencies(problem, orbit, shot, weights)
    if not len(left):
        return nothing
    fixed = np.vstack([np.eye(problem.columns(orbit))[d + 1 + count :], problem.held(orbit)]) / weights
    _, _, right = np.linalg.svd(np.vstack([_scaled(problem, orbit, shot, weights)[0], fixed]))
    beside = problem.moved(orbit, shot, TUNING.beside_family * right[-1] / weights)
    rows = _gradients(problem, orbit, left, weights)
    with on_level(problem, rows):
        code, other, seen, _ = problem.newton(beside, weights=weights)
    if code or not len(_dependencies(problem, other, seen, weights)):
        return nothing
    if np.linalg.norm((other.starts - orbit.starts)[:, :d] * weights[:d]) < TUNING.beside_family / 10:
        return nothing
    return rows


@contextmanager
def on_level(problem: "Problem", rows: np.ndarray) -> Iterator[None]:
    """Let Newton's method hold what has these differentials, shape (m, d), for a while."""
    before, problem.conserved = problem.conserved, rows
    try:
        yield
    finally:
        problem.conserved = before


def other_family(problem: "Problem", orbit: "Orbit", shot: "Shot") -> str:
    """Why a branch does not go on with the orbits of other events that begin with this one; empty if it does.

    On a branch either every orbit is one of a family at the same parameters, or none is.
    """
    if not len(problem.conserved):
        if len(conserved_at(problem, orbit, shot)):
            return "beyond, every orbit is one of a family at the same parameters; the branch ends"
    elif not len(_dependencies(problem, orbit, shot, problem.weights(orbit))):
        return "beyond, no orbit is one of a family at the same parameters; the branch ends"
    return ""


def likely_at(problem: "Problem", guess: "Orbit") -> tuple[np.ndarray, np.ndarray]:
    """What may be conserved at a guess, as `conserved_at`: all that one shows that closes, or the likeliest quantity.

    The equations depend on each other only as nearly as the guess closes, and Newton's method leaps to and fro
    in the family: it is kept on a level.
    """
    nothing = np.zeros((0, problem.states))
    # Newton's method makes a motion at rest last no time
    if len(problem.conserved) or problem.forced or not guess.durations.sum() > 0:
        return nothing, nothing
    shot, weights = problem.shoot(guess, watched=False), problem.weights(guess)
    matrix, scale = _scaled(problem, guess, shot, weights)
    if not np.isfinite(matrix).all():
        return nothing, nothing
    vectors, sizes = _from_the_left(problem, guess, matrix, weights)
    left = vectors[:, : len(sizes)].T / scale
    known = problem.nearly_closed
    closed = (sizes <= TUNING.of_family * known * sizes[0]) & (shot.residual <= known)
    return _gradients(problem, guess, left[closed], weights), _gradients(problem, guess, left[-1:], weights)


def _gradients(problem: "Problem", orbit: "Orbit", left: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """The part of combinations of equations that is of the closing of the states, each of length 1."""
    d, count = problem.states, len(orbit)
    rows = left[:, count : count + d] / weights[:d]
    lengths = np.linalg.norm(rows, axis=1, keepdims=True)
    rows = _reduced(rows[lengths[:, 0] > 0] / lengths[lengths[:, 0] > 0])
    rows[np.abs(rows) < problem.nearly_closed] = 0.0
    largest = np.take_along_axis(rows, np.abs(rows).argmax(axis=1, keepdims=True), axis=1)
    return np.asarray(np.sign(largest) * rows * weights[:d])


def _reduced(rows: np.ndarray) -> np.ndarray:
    """The rows of length 1 in a reduced echelon form: which singular vectors span a space is left to round-off."""
    if len(rows) < 2:
        return rows
    rest = np.linalg.svd(rows, full_matrices=False)[2]
    pivots = []
    for column in range(rows.shape[1]):
        part = rest[:, column]
        # of what is left at least one column is longer than twice this
        if np.linalg.norm(part) > 0.5 / np.sqrt(rows.shape[1]):
            pivots.append(column)
            rest = rest - np.outer(part, part @ rest) / (part @ part)
    reduced = np.linalg.lstsq(rows[:, pivots], rows, rcond=None)[0]
    return np.asarray(reduced / np.linalg.norm(reduced, axis=1, keepdims=True))


def family_words(rows: np.ndarray, names: tuple[str, ...]) -> str:
    """That a quantity is conserved, and which changes of the state it forbids, in words; empty without rows."""
    if not len(rows):
        return ""
    told = [" ".join(f"{v:+.3g} {x}" for v, x in zip(row.tolist(), names, strict=True) if v) for row in rows]
    told = [one.removeprefix("+").replace(" +", " + ").replace(" -", " - ") for one in told]
    why, which = "a quantity is conserved", "its differential at the start of the orbit, is held"
    if len(rows) > 1:
        why, which = f"{len(rows)} quantities are conserved", "their differentials at the start of the orbit, are held"
    return f"the orbit is one of a family at the same parameters, since {why}; {' and '.join(told)}, {which}"


def _dependencies(problem: "Problem", orbit: "Orbit", shot: "Shot", weights: np.ndarray) -> np.ndarray:
    """Combinations of the linearised equations that vanish, shape (m, rows)."""
    matrix, scale = _scaled(problem, orbit, shot, weights)
    vectors, sizes = _from_the_left(problem, orbit, matrix, weights)
    small = sizes <= problem.dependent * sizes[0]
    return np.asarray(vectors[:, : len(sizes)][:, small].T / scale)


def _from_the_left(
    problem: "Problem", orbit: "Orbit", matrix: np.ndarray, weights: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Left singular vectors of the equations that say something, and singular values; 0 for the others.

    Those of the states say nothing along shifts, and nothing of what is conserved by its expression.
    """
    d, count, closes = problem.states, len(orbit), problem.closes
    known = neutral_of(problem.plain).conserved[:, closes] / weights[:d][closes]
    across = np.linalg.svd(known)[2][np.linalg.matrix_rank(known) :] if known.any() else np.eye(closes.sum())
    closing = np.zeros((len(across), len(matrix)))
    closing[:, count : count + d][:, closes] = across
    every = np.eye(len(matrix))
    kept = np.vstack([every[:count], closing, every[count + d :]])
    vectors, sizes, _ = np.linalg.svd(kept @ matrix)
    return kept.T @ vectors, sizes


def _scaled(problem: "Problem", orbit: "Orbit", shot: "Shot", weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The linearised equations in weighted unknowns without units, and what they were divided by, shape (rows,).

    Those of the states may vanish as a whole: they count by the sizes of the states, the others by their entries.
    Parameters, whose range is not known here, count for no more than states do.
    """
    d, count = problem.states, len(orbit)
    rows = shot.equations[: count + d + 1, :-1] / weights
    scale = np.abs(rows).max(axis=1)
    scale[count : count + d] = 1 / weights[:d]
    scale[scale == 0] = 1.0
    matrix = rows / scale[:, np.newaxis]
    matrix[:, d + 1 + count :] /= np.maximum(np.abs(matrix[:, d + 1 + count :]).max(axis=0), 1.0)
    return matrix, scale
