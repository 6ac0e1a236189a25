"""One equilibrium: Newton's method to rounding, its errors, eigenvalues, type, and whether the system has it.

The error of the position is what the rates and their rounding leave, through the inverse of the Jacobian (Higham 2002,
doi:10.1137/1.9780898718027, section 25.1). The error of an eigenvalue is that of the Jacobian through the eigenvectors
(Wilkinson's condition number), or that of Elsner (Linear Algebra Appl. 71 (1985) 77-80) where it is sharper, as at
multiple ones.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
import scipy.linalg

from chaosdrill.dataset.equilibria import Admissibility, EquilibriumType
from chaosdrill.equilibrium.fields import UNIT, Field
from chaosdrill.equilibrium.tuning import TUNING

Place = TypeVar("Place")


@dataclass(frozen=True)
class Spectrum:
    """The m eigenvalues of the free directions, by falling real part, a pair with the positive imaginary part first."""

    values: np.ndarray  # complex (m,)
    errors: np.ndarray  # (m,): bounds of how far each may be off

    @property
    def signs(self) -> np.ndarray:
        """Signs of the real parts, 0 within the error; shape (m,)."""
        return np.where(np.abs(self.values.real) <= self.errors, 0, np.sign(self.values.real)).astype(int)

    @property
    def type(self) -> EquilibriumType:
        """What it makes of the equilibrium."""
        signs, complex_ = self.signs, bool((np.abs(self.values.imag) > self.errors).any())
        if (signs == 0).any():
            centre = len(signs) == 2 and complex_ and not signs.any()
            return EquilibriumType.CENTRE if centre else EquilibriumType.DEGENERATE
        if abs(signs.sum()) == len(signs):
            return EquilibriumType.FOCUS if complex_ else EquilibriumType.NODE
        return EquilibriumType.SADDLE_FOCUS if complex_ else EquilibriumType.SADDLE

    @property
    def stable(self) -> bool:
        """Whether all real parts are negative beyond their errors."""
        return bool((self.signs < 0).all())

    @property
    def unstable(self) -> tuple[int, int]:
        """Between which numbers that of the real parts above zero is."""
        signs = self.signs
        return int((signs > 0).sum()), int((signs >= 0).sum())


@dataclass(frozen=True)
class Equilibrium:
    """A zero of the rates of a mode."""

    field: Field
    numbers: np.ndarray  # states, parameters and levels
    error: np.ndarray  # (m,): of the free states
    spectrum: Spectrum
    heights: np.ndarray  # (G,): guards of the mode, negative where it holds
    height_errors: np.ndarray  # (G,)
    where: Admissibility
    beyond: tuple[int, ...] = ()  # guards that are crossed, or met

    @property
    def free(self) -> np.ndarray:
        """The free states, shape (m,)."""
        return self.numbers[list(self.field.free)]

    @property
    def states(self) -> np.ndarray:
        """All states, shape (n,)."""
        return self.field.states(self.numbers)

    def state_errors(self) -> np.ndarray:
        """Errors of all states, shape (n,)."""
        high, low = (self.field.states(moved(self.field, self.numbers, s * self.error)) for s in (1, -1))
        found: np.ndarray = np.maximum(np.abs(high - low) / 2, UNIT * np.abs(self.states))
        found[list(self.field.free)] = self.error
        return found

    def met(self, other: "Equilibrium", sizes: np.ndarray) -> bool:
        """Whether this is the same as another one of its mode at the same parameters."""
        near = TUNING.same * sizes + TUNING.same_errors * np.nan_to_num(self.error + other.error, posinf=np.inf)
        return bool((np.abs(self.free - other.free) <= near).all())


def moved(field: Field, numbers: np.ndarray, step: np.ndarray) -> np.ndarray:
    """The numbers with other free states."""
    found = numbers.copy()
    found[list(field.free)] += step
    return found


def polished(field: Field, numbers: np.ndarray) -> np.ndarray | None:
    """The equilibrium to which Newton's method leads, to rounding; None where it leads to none."""
    here, best, left = numbers, None, np.inf
    for _ in range(TUNING.newton_steps):
        rates = field.rate(here)
        allowed = TUNING.rounded * field.rounding(here)
        if not (np.isfinite(rates).all() and np.isfinite(allowed).all()):
            return best
        with np.errstate(divide="ignore"):
            ratio = float(np.divide(np.abs(rates), allowed, out=np.zeros_like(rates), where=rates != 0).max())
        if ratio <= 1:
            if ratio >= left / 2:
                return best
            best, left = here, ratio
        if ratio == 0:
            return best
        step = _newton_step(field.jacobian(here), rates)
        if step is None:
            return best
        here = moved(field, here, step)
    return best


def _newton_step(jacobian: np.ndarray, rates: np.ndarray) -> np.ndarray | None:
    rows, columns = _balance(jacobian)
    try:
        step = -columns * np.linalg.solve(rows[:, np.newaxis] * jacobian * columns, rows * rates)
    except np.linalg.LinAlgError:
        return None
    return step if np.isfinite(step).all() else None


def _balance(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Powers of two for rows and columns after which units do not matter."""
    size = np.abs(matrix)
    # what has underflowed has no digits left, and no reciprocal
    size[size < np.finfo(float).tiny] = 0.0
    columns = np.ones(size.shape[1])
    for _ in range(3):
        rows = 1 / np.where((most := (size * columns).max(axis=1)) > 0, most, 1.0)
        most = (size * rows[:, np.newaxis]).max(axis=0)
        columns = 1 / np.where(most > 0, most, 1.0)
    return tuple(2.0 ** np.round(np.log2(one)) for one in (rows, columns))  # type: ignore[return-value]


def similar(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The matrix in units of the states in which its rows and columns are about as large, and these units."""
    # scipy reads a permutation from the units, which warns where they are too far apart for integers
    with np.errstate(invalid="ignore"):
        balanced, (scale, _) = scipy.linalg.matrix_balance(matrix, permute=False, separate=True)
    return balanced, scale


def spectrum_of(field: Field, numbers: np.ndarray, error: np.ndarray) -> Spectrum:
    """The eigenvalues of the free directions at an equilibrium whose free states are known to ``error``."""
    jacobian = field.jacobian(numbers)
    known = np.where(np.isfinite(error), error, 0.0)
    change = sum(np.abs(field.jacobian(moved(field, numbers, s * known)) - jacobian) for s in (1, -1))
    doubt = np.nan_to_num(field.jacobian_rounding(numbers) + change)
    balanced, scale = similar(jacobian)
    doubt = doubt * scale / scale[:, np.newaxis]
    values, left, right = scipy.linalg.eig(balanced, left=True)
    m, size = len(values), float(np.linalg.norm(balanced))
    whole = doubt + m * UNIT * size
    away = np.abs(np.einsum("ik,ik->k", left.conj(), right))
    with np.errstate(divide="ignore", over="ignore"):
        each = np.einsum("ik,ij,jk->k", np.abs(left), whole, np.abs(right)) / away
    shift = float(np.linalg.norm(whole))
    elsner = (2 * size + shift) ** (1 - 1 / m) * shift ** (1 / m)
    errors = np.minimum(each, elsner)
    order = np.lexsort((-values.imag, -values.real))
    return Spectrum(values[order], errors[order])


def equilibrium(field: Field, numbers: np.ndarray) -> Equilibrium:
    """All that is to be known of a zero of the rates."""
    jacobian = field.jacobian(numbers)
    left = np.abs(field.rate(numbers)) + field.rounding(numbers)
    rows, columns = _balance(jacobian)
    try:
        inverse = np.linalg.inv(rows[:, np.newaxis] * jacobian * columns)
        error = columns * (np.abs(inverse) @ (rows * left))
    except np.linalg.LinAlgError:
        error = np.full(len(left), np.inf)
    error = np.maximum(error, UNIT * np.abs(numbers[list(field.free)]))
    spectrum = spectrum_of(field, numbers, error)
    heights, doubts = field.heights(numbers)
    if len(heights):
        doubts = doubts + np.abs(field.slopes(numbers)) @ np.nan_to_num(error)
    return Equilibrium(field, numbers, error, spectrum, heights, doubts, *_where(field, numbers, heights, doubts))


def _where(
    field: Field, numbers: np.ndarray, heights: np.ndarray, doubts: np.ndarray
) -> tuple[Admissibility, tuple[int, ...]]:
    crossed = [k for k in np.flatnonzero(heights > doubts).tolist() if field.crossed(k, numbers)]
    if crossed:
        return Admissibility.VIRTUAL, tuple(crossed)
    met = np.flatnonzero(np.abs(heights) <= doubts).tolist()
    return (Admissibility.BOUNDARY, tuple(met)) if met else (Admissibility.ADMISSIBLE, ())


def undecided(
    at: Callable[[float], tuple[Place, float, float]], zero: float, limits: tuple[float, float]
) -> list[Place]:
    """The nearest places on either side of a zero of a function at which its sign is certain.

    Between them the zero lies, however flat the function is there.

    ``at``: what is at a place, the function there, and its error. ``limits``: places beyond which nothing is looked
    for; where the sign is not certain up to one, that stands.
    """
    found = []
    for limit in limits:
        room = abs(limit - zero)
        way = UNIT * max(abs(zero), room)
        while True:
            where, value, error = at(zero + np.sign(limit - zero) * min(way, room))
            if abs(value) > error or way >= room:
                break
            way *= 2
        found.append(where)
    return found
