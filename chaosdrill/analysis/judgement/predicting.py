"""Tori of two and three angles by prediction: a smooth function of angles is known where it was not looked at.

Points of a torus are smooth functions of angles that advance evenly. Their trigonometric polynomials, in frequencies
that are refined with them (after Laskar, Froeschle and Celletti 1992, doi:10.1016/0167-2789(92)90028-L; Gomez, Mondelo
and Simo 2010, doi:10.3934/dcdsb.2010.14.41), are fitted to three quarters of a record and tell the last quarter, ever
better the more terms they have. Nothing else does so: chaos and strange nonchaotic attractors are not smooth, adding
machines have no frequency beside their fractions, and exchanges of intervals none that lasts.
"""

from collections.abc import Callable
from functools import lru_cache
from itertools import combinations, product

import numpy as np

from chaosdrill.analysis.judgement.frequencies import ORDER, ROUND_OFF, related, strongest

ANGLES = (1, 2, 3)
"""How many are tried. Of one alone points lie in order along a curve, which needs no smoothness, so that one is no
answer here but the first step to two."""

MOST, FITTED = 1024, 0.75
"""Points that are looked at, at most, and part of them to which polynomials are fitted."""

TERMS, PER_ROW, FIRST = 400, 0.5, 32
"""Terms of a polynomial at most, at most for each point that is fitted, and of that which is taken off before another
frequency is looked for: many terms fit whatever lies near their frequencies."""

LOW, STEPS, FINAL = 3, 3, 2
"""Degree of the polynomials with which frequencies are refined, Gauss-Newton steps for that, and those that are left
for polynomials of a higher degree."""

ROUGH, MISSED, BETTER, EXACT = 0.05, 5e-3, 2.0, 1e-5
"""Root mean square, in parts of the extent, by which these miss at most, and those of a higher degree, how many times
less than those of half of the degree, since series of smooth functions fall like a geometric one, and from where on no
less. Strange nonchaotic attractors are missed by 2 % and more by any."""

SLOW, EXPLAINED, SEEN = 2, 0.5, 1e-7
"""Degree of the terms that are let change with time and its square, part of what a polynomial leaves that this explains
at least along a spiral (measured: 0.99 and more; on tori less than 0.1), and size of it, in parts of the extent, from
where on it is more than rounding."""

WEIGHT = 1e-7
"""Part of all squares with which coefficients count, so that two waves that hardly part have no large ones."""

BEATS = 4.0
"""Times that any combination of frequencies up to the degree `LOW` goes round in the record at least: of slower ones it
is not known that they do."""


def predicted(path: np.ndarray, *, strobed: bool = True) -> bool:
    """Whether points are smooth functions of two or three angles that advance evenly, without a common measure.

    Strobes of a cycle come back; its instants of any kind do not, but their angles have a common measure.

    ``path``, shape (W, n): states at a strobe or section, or at instants of any kind, each in parts of its extent.
    """
    # every other point, or every tenth, is on the same torus, where slow combinations go round more often
    path = path[:: -max(1, len(path) // (2 * MOST))][::-1]
    points = path[-MOST:]
    off, turns = points - points.mean(axis=0), np.zeros(0)
    fitted, rest = int(FITTED * len(points)), off
    for angles in ANGLES:
        line = strongest(rest)
        if not np.isfinite(line):
            return False
        turns = _refined(off, np.append(turns, line))
        slow = _terms(angles, LOW) @ turns
        if (np.abs(slow - np.rint(slow)) * len(points) < BEATS).any():
            return False
        # frequencies that all points tell are no worse than those of the first, by which the last are to be known
        may_be_known = angles > 1 and _misses(off, turns, LOW, fitted) <= 2 * ROUGH
        if may_be_known and (degree := _known_by(off, _refined(off[:fitted], turns), fitted)):
            cycle = _comes_back(path) if strobed else _have_common_measure(path, turns, degree)
            return not (cycle or _moves_on(off, turns, degree))
        columns = _columns(len(points), turns, _terms(angles, _degree(angles, FIRST)))
        rest = off - columns @ _solved(columns, off)
    return False


def _known_by(points: np.ndarray, turns: np.ndarray, fitted: int) -> int:
    """Degree by which the last points are known from the first ones that are fitted, and ever better; 0: by none."""
    low = _misses(points, turns, LOW, fitted)
    if low > ROUGH:
        return 0
    if low <= EXACT:
        return LOW
    most = _degree(len(turns), min(TERMS, int(PER_ROW * fitted)))
    for degree in (most, most * 2 // 3):
        fine = _misses(points, turns, degree, fitted)
        if fine <= MISSED and BETTER * fine <= max(_misses(points, turns, degree // 2, fitted), EXACT):
            return degree
    return 0


def _moves_on(points: np.ndarray, turns: np.ndarray, degree: int) -> bool:
    """Whether what a polynomial leaves is a change of its coefficients in time, as along a spiral."""
    turns = _refined(points, turns, degree, 1)
    columns, time = _columns(len(points), turns, _terms(len(turns), degree)), np.linspace(-1, 1, len(points))
    solve = _solver(columns)
    left = points - columns @ solve(points)
    waves = _columns(len(points), turns, _terms(len(turns), SLOW))
    drift = np.concatenate([waves * time[:, np.newaxis], waves * time[:, np.newaxis] ** 2], axis=1)
    drift -= columns @ solve(drift)
    rest = left - drift @ np.linalg.lstsq(drift, left, rcond=None)[0]
    return bool((rest**2).sum() < (1 - EXPLAINED) * (left**2).sum() and left.std(axis=0).max() > SEEN)


def _comes_back(points: np.ndarray) -> bool:
    """Whether points come back as closely as they are known: enough terms fit any cycle of fewer points."""
    lags = range(1, len(points) // 2 + 1)
    return any(np.median(np.abs(points[lag:] - points[:-lag]).max(axis=1)) <= MISSED for lag in lags)


def _have_common_measure(points: np.ndarray, turns: np.ndarray, degree: int) -> bool:
    """Whether small multiples of any two angles agree, for all that polynomials of this or another degree tell.

    Those of a low one may miss too much, and those of a high one have waves that hardly part.
    """
    fitted, pairs = int(FITTED * len(points)), list(combinations(range(len(turns)), 2))
    parts = [part - part.mean(axis=0) for part in (points, points[:fitted], points[-fitted:])]
    whole = turns
    for one in (LOW, degree, _degree(len(turns), int(PER_ROW * fitted))):
        whole = _refined(parts[0], whole, one, STEPS if one == LOW else FINAL)
        # one step from there tells how far off a part is
        found = [whole, *(_refined(part, whole, one, 1) for part in parts[1:])]
        error = np.maximum(np.ptp(found, axis=0), ROUND_OFF)
        if not all(related(whole[i], whole[j], error[i], error[j], ORDER) for i, j in pairs):
            return False
    return True


@lru_cache(maxsize=32)
def _terms(angles: int, degree: int) -> np.ndarray:
    """Multiples of angles up to a degree, one of each pair of opposite signs, shape (K, angles)."""
    span = product(range(-degree, degree + 1), repeat=angles)
    return np.array([m for m in span if sum(map(abs, m)) <= degree and m > (0,) * angles])


def _degree(angles: int, most: int) -> int:
    """The largest degree of a polynomial with ``most`` coefficients or fewer."""
    degree = 1
    while 2 * len(_terms(angles, degree + 1)) + 1 <= most:
        degree += 1
    return degree


def _columns(count: int, turns: np.ndarray, terms: np.ndarray) -> np.ndarray:
    """Cosines and sines of multiples of angles at ``count`` points, and a constant; shape (count, 2 K + 1)."""
    most = np.abs(terms).max()
    once = np.exp(2j * np.pi * (np.outer(turns, np.arange(count)) % 1.0))
    # products take a tenth of the time of as many exponentials
    powers = np.cumprod(np.broadcast_to(once, (most, *once.shape)), axis=0)
    powers = np.concatenate([powers[::-1].conj(), np.ones((1, *once.shape)), powers])
    waves = powers[terms[:, 0] + most, 0]
    for angle in range(1, len(turns)):
        waves *= powers[terms[:, angle] + most, angle]
    return np.concatenate([np.ones((1, count)), waves.real, waves.imag]).T


def _solver(columns: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    """Least squares, by normal equations that keep coefficients small."""
    square = columns.T @ columns
    square[np.diag_indices_from(square)] += len(columns) * WEIGHT
    # solved anew for each side: to load a library that keeps the factors takes longer than to find them
    return lambda values: np.asarray(np.linalg.solve(square, columns.T @ values))


def _solved(columns: np.ndarray, values: np.ndarray) -> np.ndarray:
    return _solver(columns)(values)


def _refined(points: np.ndarray, turns: np.ndarray, degree: int = LOW, steps: int = STEPS) -> np.ndarray:
    """Frequencies with which a polynomial of some degree is nearest to the points."""
    terms, (count, n) = _terms(len(turns), degree), points.shape
    at, half = np.arange(count) - (count - 1) / 2, len(terms) + 1
    for _ in range(steps):
        columns = _columns(count, turns, terms)
        solve = _solver(columns)
        solved = solve(points)
        real, imaginary = solved[1:half], solved[half:]
        rates = np.concatenate(
            [columns[:, 1:half] @ (of * imaginary.T).T - columns[:, half:] @ (of * real.T).T for of in terms.T], axis=1
        )
        rates *= 2 * np.pi * at[:, np.newaxis]
        apart = (rates - columns @ solve(rates)).reshape(count, len(turns), n)
        slopes = apart.transpose(0, 2, 1).reshape(count * n, len(turns))
        turns = turns + np.linalg.lstsq(slopes, (points - columns @ solved).ravel(), rcond=None)[0]
    return turns


def _misses(points: np.ndarray, turns: np.ndarray, degree: int, fitted: int) -> float:
    """Root mean square by which a polynomial that fits the first points misses the others; of the worst state."""
    columns = _columns(len(points), turns, _terms(len(turns), degree))
    lacks = points[fitted:] - columns[fitted:] @ _solved(columns[:fitted], points[:fitted])
    return float(np.sqrt((lacks**2).mean(axis=0)).max())
