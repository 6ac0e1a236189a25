"""Normal forms of doublings, pitchforks and Neimark-Sacker points: what is born there, stable or not.

The return map of the orbit is taken from a place within a segment, after the periods of the forcing or, without one,
back to the plane across the flow there. All events move with the path, so that its first derivatives are exact; the
second and third are differences of them, at several distances, extrapolated to none (Ridders 1982,
doi:10.1016/S0141-1195(82)80057-0). The coefficients on the centre manifold are those of Kuznetsov 2023,
doi:10.1007/978-3-031-22007-4, chapter 5, for a critical eigenvector whose mean square along the orbit is 1, as that of
Kuznetsov, Govaerts, Doedel and Dhooge 2005, doi:10.1137/040611306.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.codegen import kernels_of
from chaosdrill.dataset.branches import Criticality, Special
from chaosdrill.engine import shooting as at
from chaosdrill.engine.layout import DONE
from chaosdrill.engine.scales import SMALLEST
from chaosdrill.engine.setup import constrained_states
from chaosdrill.orbits.orbit import Orbit
from chaosdrill.orbits.problem import LostError
from chaosdrill.orbits.results import NormalForm
from chaosdrill.orbits.tuning import TUNING

if TYPE_CHECKING:
    from chaosdrill.orbits.problem import Problem, Shot


class ReturnMap:
    """The map of deviations at a place within a segment of an orbit to those one period later.

    Raises `LostError` if the orbit has no segment in which all deviations are free to go on.
    """

    def __init__(self, problem: "Problem", orbit: Orbit) -> None:
        self.problem, d = problem, problem.states
        longest = _free_segment(problem, orbit)
        self.path = cut(problem, orbit, longest, 0.0 if orbit.eventless else float(orbit.durations[longest]) / 2)
        self.closed = problem.neutral.flow
        self.sizes = 1 / problem.weights(orbit)[:d]
        shot = problem.shoot(self.path, False)
        if not shot.regular:
            raise LostError("the return map has no derivatives there")
        # the derivative of the end by the last duration is the rate there
        end = shot.equations[len(self.path) : len(self.path) + d, d + len(self.path)]
        self.normal = end / self.sizes
        self.basis = np.eye(d)
        if self.closed:
            self.basis = np.linalg.svd(self.normal[np.newaxis])[2][1:].T

    def derivative(self, deviation: np.ndarray) -> np.ndarray:
        """First derivatives of the map at a deviation, shapes (m, m) and (m,), in units of the sizes of the states.

        Raises `LostError`.
        """
        d, count = self.problem.states, len(self.path)
        starts = self.path.starts.copy()
        starts[0, :d] += self.sizes * (self.basis @ deviation)
        path, durations = replace(self.path, starts=starts), slice(d + 1, d + 1 + count)
        total, last = float(self.path.durations.sum()), np.inf
        for _ in range(TUNING.newton_steps):
            shot = self.problem.shoot(path, False)
            if not shot.regular:
                raise LostError("the path beside the orbit cannot be followed")
            rows, ends = self._equations(path, shot)
            correction = np.zeros(rows.shape[1])
            correction[-1] = 1.0
            try:
                correction[durations] = -np.linalg.solve(rows[:, durations], rows[:, -1])
            except np.linalg.LinAlgError as failure:
                raise LostError("an event is met at no speed") from failure
            moved = float(np.abs(correction[durations]).max()) / total
            if not moved < TUNING.farthest:
                raise LostError("the events beside the orbit are far from its own")
            shift = shot.sensitivity @ correction
            # events at given times stay, though the states there move
            moved = max(moved, float((np.abs(shift[:, :d]) / self.sizes).max()))
            if moved <= TUNING.residual or (moved < TUNING.converged_path and moved > 0.3 * last):
                break
            last = moved
            path = replace(
                path,
                starts=path.starts + shift,
                durations=path.durations + correction[durations],
            )
        later = -np.linalg.solve(rows[:, durations], rows[:, :d])
        whole = (ends[:, :d] + ends[:, durations] @ later) * self.sizes / self.sizes[:, np.newaxis]
        return np.asarray(self.basis.T @ whole @ self.basis)

    def length(self, deviation: np.ndarray) -> tuple[float, float]:
        """Root mean square of a deviation, shape (m,), carried once around the orbit, and its error as a part of it.

        Each state counts in parts of its own root mean square along the orbit, an angle in radians. What is along the
        flow does not count where time is free. So it does not depend on where the deviation begins.
        """
        start, count, before = self.sizes * (self.basis @ deviation), TUNING.mean_places, np.inf
        while True:
            found = _mean_square(self.problem, self.path, start, self.closed, count) ** 0.5
            error = 0.0 if self.problem.plain.discrete else abs(found - before) / found
            if error <= TUNING.mean_known or count >= TUNING.most_places:
                return found, error
            before, count = found, 2 * count

    def _equations(self, path: Orbit, shot: "Shot") -> tuple[np.ndarray, np.ndarray]:
        """What durations obey, none a later one, and the end, linearised in the reduced unknowns; constants last."""
        d, count = self.problem.states, len(path)
        ends = shot.equations[count : count + d].copy()
        ends[:, :d] += np.eye(d)
        rows = shot.equations[:count].copy()
        if self.closed:
            rows[-1] = (self.normal / self.sizes) @ ends
            away = (path.starts[0, :d] - self.path.starts[0, :d]) / self.sizes
            rows[-1, -1] += self.normal @ away
        else:
            rows[-1] = 0.0
            rows[-1, d + 1 : d + 1 + count] = 1.0
            rows[-1, -1] = path.durations.sum() - self.path.durations.sum()
        return rows, ends


def _mean_square(problem: "Problem", path: Orbit, start: np.ndarray, closed: bool, count: int) -> float:
    """Mean square of a deviation along a path, at about as many places, in sizes of the states there.

    ``start``: the deviation at its start. ``closed``: whether what is along the flow does not count.
    """
    places, parts = _places(problem, path, count)
    shot = problem.shoot(places, False)
    if not (shot.outcome == DONE and np.isfinite(shot.factors).all()):
        raise LostError("the deviation cannot be carried around the orbit")
    moved = [start / problem.units]
    for factor in shot.factors[:-1]:
        moved.append(factor @ moved[-1])
    sizes = np.maximum(np.sqrt(parts @ places.starts[:, : problem.states] ** 2), TUNING.smallest_size * problem.sizes)
    for turn in problem.shifts.turns:
        sizes = np.where(turn != 0, np.abs(turn) / (2 * np.pi), sizes)
    away = np.array(moved) * problem.units / sizes
    if closed:
        flows = np.array([problem.flow_at(places.rotated(k, None)) for k in range(len(places))]) / sizes
        flows /= np.maximum(np.linalg.norm(flows, axis=1, keepdims=True), SMALLEST)
        away = away - flows * (flows * away).sum(axis=1, keepdims=True)
    return float(parts @ (np.abs(away) ** 2).sum(axis=1))


def _places(problem: "Problem", path: Orbit, count: int) -> tuple[Orbit, np.ndarray]:
    """A path divided at about as many Gauss nodes, or at the iterates of a map, and the part of it that each tells.

    What begins where a segment does tells nothing then.
    """
    whole, each = float(path.durations.sum()), max(2, count // len(path))
    nodes, weights = np.polynomial.legendre.leggauss(each)
    inner, parts = np.append(0.0, (1 + nodes) / 2), np.append(0.0, weights / 2)
    if problem.plain.discrete:
        inner, parts = np.arange(round(whole)) / whole, np.full(round(whole), 1 / whole)
    before = np.cumsum(path.durations) - path.durations
    times = before[:, np.newaxis] + path.durations[:, np.newaxis] * inner
    starts, segments = (np.repeat(one, len(inner), axis=0) for one in (path.starts, path.segments))
    within = np.tile(np.arange(len(inner)) > 0, len(path))
    starts[within, : problem.states] = problem.at([path], times.ravel()[within][np.newaxis])[0][0]
    goes_on = np.roll(within, -1)
    segments[goes_on, at.SEGMENT_END], segments[goes_on, at.SEGMENT_OUTCOME] = at.SHARE, -1
    durations = path.durations[:, np.newaxis] * np.diff(np.append(inner, 1.0))
    told = path.durations[:, np.newaxis] * parts / whole
    return replace(path, segments=segments, starts=starts, durations=durations.ravel()), told.ravel()


def _free_segment(problem: "Problem", orbit: Orbit) -> int:
    """The longest segment of an orbit in which all that is not pinned is free."""
    modes = orbit.segments[:, at.SEGMENT_MODE]
    held = np.array(kernels_of(problem.plain).layout.held)[modes]
    pinned = constrained_states(problem.plain)[modes].sum(axis=1)
    merit = np.where(held > 0, -1.0, orbit.durations / (1.0 + 1e3 * pinned))
    longest = int(merit.argmax())
    if merit[longest] <= 0:
        raise LostError("every segment is held to a surface")
    return longest


def cut(problem: "Problem", orbit: Orbit, segment: int, after: float) -> Orbit:
    """One period of an orbit from within a segment, a time after its start, on to the same place."""
    period, d = problem.period_at(orbit), problem.states
    share = np.array([[orbit.segments[segment, at.SEGMENT_MODE], at.SHARE, -1]], dtype=np.int64)
    if orbit.eventless:
        after, total = after + float(orbit.durations[:segment].sum()), float(orbit.durations.sum())
        begin = orbit.starts[:1].copy()
        begin[0, :d] = problem.at([orbit], np.array([[after % total]]))[0][0, 0]
        phase = orbit.phase + after
        phase = phase % period if period else phase
        return replace(orbit, segments=share, starts=begin, durations=np.array([total]), phase=phase)
    turned = orbit.rotated(segment, period)
    middle = turned.starts[0].copy()
    middle[:d] = problem.at([turned], np.array([[after]]))[0][0, 0]
    phase = turned.phase + after
    return Orbit(
        np.vstack([turned.segments, share]),
        orbit.periods,
        np.vstack([middle, turned.starts[1:], turned.starts[:1] + turned.moved_on()]),
        phase % period if period else phase,
        np.concatenate([[float(turned.durations[0]) - after], turned.durations[1:], [after]]),
        turned.drift,
    )


def normal_form(problem: "Problem", orbit: Orbit, kind: Special, multiplicity: int) -> NormalForm:
    """What is born at a special point of a branch.

    ``orbit``: the orbit there. ``multiplicity``: how many multipliers are on the unit circle.

    Undecided where the error covers zero, where several multipliers cross together, at strong resonances, and where a
    quantity is conserved.
    """
    if kind not in _CRITICAL:
        return NormalForm(Criticality.NONE)
    undecided = NormalForm(Criticality.UNDECIDED)
    if multiplicity != (2 if kind == Special.NEIMARK_SACKER else 1):
        return undecided
    if len(problem.conserved) or problem.neutral.count > int(problem.neutral.flow):
        return undecided
    try:
        return _decided(kind, ReturnMap(problem, orbit))
    except (LostError, np.linalg.LinAlgError):
        return undecided


def cubic_term(problem: "Problem", orbit: Orbit, near: complex) -> tuple[float, float]:
    """Coefficient of the cubic term on the centre manifold of the multiplier nearest to a value, and its error.

    It is known to a part of itself, which tells its sign, and the better the nearer it is to zero.

    ``near``: -1, or one of a pair on the unit circle.

    Returns them as in `NormalForm`.

    Raises `LostError` if there is no return map, or no derivatives of it, and `numpy.linalg.LinAlgError` at a pole of
    the coefficient.
    """
    returns = ReturnMap(problem, orbit)
    (_, cubic), (_, error), _, q = _terms(returns, lambda values: np.abs(values - near), TUNING.sign_known)
    return _per_length(returns, q, float(cubic), float(error))


def _decided(kind: Special, returns: ReturnMap) -> NormalForm:
    (quadratic, cubic), (quadratic_error, error), bends, q = _terms(returns, _CRITICAL[kind])
    if kind == Special.BRANCH_POINT:
        away = TUNING.crossing_known
        # in differences at h, terms of fourth and fifth order show as 2 h^2 and 5/3 h^2 of themselves
        fourth, fifth = np.abs(bends) / (2, 5 / 3)
        quadratic_error += away * (abs(cubic) + away * (6 * fourth + 10 * away * fifth))
        error += away * (abs(cubic) + 4 * fourth + 10 * away * fifth)
        if abs(quadratic) > quadratic_error:
            return NormalForm(Criticality.TRANSCRITICAL)
    cubic, error = _per_length(returns, q, float(cubic), float(error))
    if not abs(cubic) > error:
        return NormalForm(Criticality.UNDECIDED, cubic, error)
    return NormalForm(Criticality.SUPERCRITICAL if cubic > 0 else Criticality.SUBCRITICAL, cubic, error)


def _per_length(returns: ReturnMap, q: np.ndarray, cubic: float, error: float) -> tuple[float, float]:
    """A cubic coefficient and its error for a critical eigenvector of mean square 1 along the orbit."""
    length, off = returns.length(q)
    return cubic / length**2, (error + 2 * off * abs(cubic)) / length**2


def _terms(
    returns: ReturnMap, distances_of: Callable[[np.ndarray], np.ndarray], enough: float = 0.0
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Quadratic and cubic coefficient of the multiplier at the least distance, their errors and bends; its eigenvector.

    ``enough``: error, as a part of them, that need not be smaller.
    """
    at_rest = returns.derivative(np.zeros(returns.basis.shape[1]))
    values, right = np.linalg.eig(at_rest)
    distances = distances_of(values)
    k = int(distances.argmin())
    mu, q = values[k], right[:, k]
    if distances[k] > TUNING.missed_multiplier:
        raise LostError("no multiplier is critical there")
    others, left = np.linalg.eig(at_rest.T)
    p = left[:, int(np.abs(others - mu).argmin())]
    if mu.imag == 0:
        mu, q, p = mu.real, q.real, p.real
    elif min(abs(mu**m - 1) for m in (1, 2, 3, 4)) < TUNING.resonant:
        raise LostError("another normal form holds at a strong resonance")
    product = p @ q / (np.linalg.norm(p) * np.linalg.norm(q))
    # where two multipliers are one with one vector; a small product is about their distance
    if abs(product) ** 2 <= TUNING.tangent_error:
        raise np.linalg.LinAlgError("two multipliers cannot be told apart")
    q = q / np.linalg.norm(q)
    p = p / (p @ q)
    return *extrapolated(lambda h: _coefficients(returns, at_rest, mu, q, p, h), enough), q


def _coefficients(
    returns: ReturnMap, at_rest: np.ndarray, mu: complex, q: np.ndarray, p: np.ndarray, h: float
) -> np.ndarray:
    """Quadratic and cubic coefficient on the centre manifold, by differences at the distance h; errors go with h^2."""
    one = np.eye(len(q))
    beside = [[returns.derivative(s * h * way) for s in (1, -1)] for way in (q.real, q.imag) if way.any()]
    second = [(ahead - back) / (2 * h) for ahead, back in beside]
    third = sum((ahead - 2 * at_rest + back) / h**2 for ahead, back in beside)
    if len(second) == 1:
        along = second[0] @ q
        if mu.real < 0:
            across = np.linalg.solve(one - at_rest, along)
            return np.array([0.0, p @ (third @ q + 3 * second[0] @ across) / 6])
        quadratic = p @ along
        # across the critical direction, since the equations are singular along it
        across = np.linalg.solve(one - at_rest + np.outer(q, p), along - quadratic * q)
        return np.array([quadratic / 2, -p @ (third @ q + 3 * second[0] @ across) / 6])
    by_q, by_conjugate = second[0] + 1j * second[1], second[0] - 1j * second[1]
    unit = mu / abs(mu)
    level = np.linalg.solve(one - at_rest, by_q @ q.conj())
    turning = np.linalg.solve(unit**2 * one - at_rest, by_q @ q)
    cubic = p @ (third @ q + 2 * by_q @ level + by_conjugate @ turning) / 2
    return np.array([0.0, -(cubic / unit).real])


def extrapolated(
    function: Callable[[float], np.ndarray], enough: float = 0.0
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Values at the distance zero of functions of its square, shape (m,), their errors, and their derivatives by it.

    Those are of the largest two distances, so that terms of higher orders count.

    ``enough``: error, as a part of them, that need not be smaller.

    Raises `LostError` if the functions have no values at any two distances.
    """
    best, errors, bends = np.zeros(1), np.full(1, np.inf), np.full(1, np.nan)
    before: list[np.ndarray] = []
    usual = TUNING.difference_distances
    for distance in (*usual, *(usual[-1] / 2.0**k for k in range(1, TUNING.halved_distances + 1))):
        if distance == usual[-1] / 2 and len(before) >= TUNING.least_distances:
            break
        try:
            row = [function(distance)]
        except LostError:
            before = []
            continue
        for j, old in enumerate(before):
            row.append(row[j] + (row[j] - old) / (4.0 ** (j + 1) - 1))
            error = TUNING.difference_safety * np.maximum(np.abs(row[-1] - row[-2]), np.abs(row[-1] - old))
            better = error < errors
            best, errors = np.where(better, row[-1], best), np.where(better, error, errors)
        if before and not np.isfinite(bends).all():
            bends = (before[0] - row[0]) / (3 * distance**2)
        if (errors <= enough * np.abs(best)).all():
            break
        before = row
    if not np.isfinite(errors).all():
        raise LostError("the map has no differences beside the orbit")
    return best, errors + TUNING.tangent_error**0.75 * np.abs(best), bends


_CRITICAL: dict[Special, Callable[[np.ndarray], np.ndarray]] = {
    Special.PERIOD_DOUBLING: lambda values: np.abs(values + 1),
    Special.BRANCH_POINT: lambda values: np.abs(values - 1),
    Special.NEIMARK_SACKER: lambda values: np.abs(np.abs(values) - 1) + np.where(values.imag == 0, np.inf, 0.0),
}
"""Distances of multipliers from those at points with a normal form."""
