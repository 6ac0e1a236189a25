"""Normal forms of Hopf points, directions of branches that cross, and what follows a boundary equilibrium.

The first Lyapunov coefficient is Kuznetsov's (Elements of Applied Bifurcation Theory, 4th ed. 2023,
doi:10.1007/978-3-031-22007-4, section 3.5): with A q = i omega q, A^T p = -i omega p, <q, q> = <p, q> = 1,

    l1 = Re <p, C(q,q,q*) - 2 B(q, A^-1 B(q,q*)) + B(q*, (2 i omega - A)^-1 B(q,q))> / (2 omega).

Which scenario follows at a boundary depends on the modes that have an equilibrium there, and on the sides of the
parameter on which these are admissible (di Bernardo, Nordmark, Olivar 2008, doi:10.1016/j.physd.2007.08.008).
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.dataset.branches import Criticality
from chaosdrill.dataset.equilibria import Beyond
from chaosdrill.equilibrium.curve import Curve, Point
from chaosdrill.equilibrium.fields import UNIT, NoFieldError, field_of
from chaosdrill.equilibrium.points import Equilibrium, equilibrium, polished
from chaosdrill.equilibrium.tuning import TUNING

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem


@dataclass(frozen=True)
class Cycle:
    """The cycle that is born at a Hopf point, to second order in its amplitude, a little beside it."""

    value: float  # of the parameter
    state: np.ndarray  # (n,): on the cycle
    amplitude: np.ndarray  # (n,): half of the extent of each state
    period: float


@dataclass(frozen=True)
class HopfForm:
    """What is born at a Hopf point."""

    frequency: float
    criticality: Criticality
    coefficient: float = float("nan")  # l1, in the states' own units
    error: float = float("nan")
    cycle: Cycle | None = None


@dataclass(frozen=True)
class _Terms:
    """The cubic term c1 of the normal form in scaled states, and what it was made of."""

    omega: float
    cubic: complex
    size: float  # of the terms that it is the sum of, times their conditions
    q: np.ndarray
    p: np.ndarray
    level: np.ndarray  # of z z* on the centre manifold
    twice: np.ndarray  # of z^2


def _terms(curve: Curve, one: Equilibrium, near: float) -> _Terms:
    field, which, sizes = curve.field, curve.which, curve.weights(one)[:-1]
    matrix = field.jacobian(one.numbers) * sizes / sizes[:, np.newaxis]
    values, right = np.linalg.eig(matrix)
    k = int(np.abs(values - 1j * near).argmin())
    others, left = np.linalg.eig(matrix.T)
    q, p = right[:, k], left[:, int(np.abs(others - values[k]).argmin())]
    # a small product of the vectors, which have length 1, is about the distance of two eigenvalues
    if abs(p @ q) ** 2 <= UNIT * len(q):
        raise np.linalg.LinAlgError("two eigenvalues cannot be told apart")
    # <q, q> = 1 in the states' own units, whatever the phase
    q = q / np.linalg.norm(sizes * q)
    p = p / (p @ q)
    omega, m = float(values[k].imag), len(sizes)

    def along(*ways: np.ndarray) -> np.ndarray:
        return field.along(one.numbers, which, *(np.append(sizes * way, 0.0) for way in ways)) / sizes

    bar = q.conj()
    resolvent = 2j * omega * np.eye(m) - matrix
    level = -np.linalg.solve(matrix, along(q, bar))
    twice = np.linalg.solve(resolvent, along(q, q))
    parts = [along(q, q, bar), 2 * along(q, level), along(bar, twice)]
    worst = max(float(np.linalg.cond(matrix)), float(np.linalg.cond(resolvent)))
    size = float(sum(np.abs(p) @ np.abs(part) for part in parts)) * worst
    return _Terms(omega, complex(p @ sum(parts)) / 2, size, q, p, level, twice)


def hopf_form(curve: Curve, before: Point, point: Point, after: Point, omega: float, error: float) -> HopfForm:
    """What is born at a located Hopf point.

    ``before``, ``after``: points of the branch a little beside it. ``omega``: frequency of the pair. ``error``: of the
    parameter.
    """
    undecided = HopfForm(omega, Criticality.UNDECIDED)
    if curve.field.system.sources:
        return undecided
    try:
        here, beside = _terms(curve, point.at, omega), [_terms(curve, one.at, omega) for one in (before, after)]
    except (np.linalg.LinAlgError, NameError):
        return undecided
    values = [curve.value(one.at) for one in (before, after)]
    coefficient = here.cubic.real / here.omega
    span = abs(values[1] - values[0])
    changed = abs(beside[1].cubic.real - beside[0].cubic.real) / here.omega
    doubt = TUNING.level * len(here.q) * UNIT * here.size / here.omega + (changed * 2 * error / span if span else 0.0)
    if not (np.isfinite(coefficient) and np.isfinite(doubt)):
        return undecided
    if abs(coefficient) <= doubt:
        return HopfForm(here.omega, Criticality.UNDECIDED, coefficient, doubt)
    kind = Criticality.SUPERCRITICAL if coefficient < 0 else Criticality.SUBCRITICAL
    return HopfForm(here.omega, kind, coefficient, doubt, _cycle(curve, point, here))


def eigenvalue_slope(curve: Curve, one: Equilibrium, q: np.ndarray, p: np.ndarray) -> tuple[complex, np.ndarray]:
    """Derivative of an eigenvalue by the parameter along the branch, and of the free states, in their own units.

    ``q`` and ``p`` are the right and left eigenvectors, with <p, q> = 1, where states count in their sizes.
    """
    sizes = curve.weights(one)[:-1]
    matrix = curve.matrix(one.numbers)
    moves = -np.linalg.solve(matrix[:, :-1], matrix[:, -1])
    wide, along = np.append(sizes * q, 0.0), np.append(moves, 1.0)
    change = curve.field.along(one.numbers, curve.which, wide, along) / sizes
    return complex(p @ change), moves


def _cycle(curve: Curve, point: Point, form: _Terms) -> Cycle | None:
    """The cycle where its amplitude is small in the sizes of the states and its parameter near that of the point."""
    try:
        slope, moves = eigenvalue_slope(curve, point.at, form.q, form.p)
    except np.linalg.LinAlgError:
        return None
    if slope.real == 0:
        return None
    squared = (TUNING.cycle_reach / (2 * float(np.abs(form.q).max()))) ** 2
    away = -form.cubic.real * squared / slope.real
    room = TUNING.cycle_range * (curve.limits[1] - curve.limits[0])
    squared *= min(1.0, room / abs(away))
    away = -form.cubic.real * squared / slope.real
    frequency = form.omega + slope.imag * away + form.cubic.imag * squared
    field, sizes = curve.field, curve.weights(point.at)[:-1]
    numbers = point.at.numbers.copy()
    numbers[curve.places] += np.append(moves * away, away)
    radius, angles = np.sqrt(squared), np.linspace(0, 2 * np.pi, TUNING.cycle_points, endpoint=False)
    path = []
    for angle in angles:
        turn = np.exp(1j * angle)
        step = 2 * radius * (form.q * turn).real + squared * (form.level.real + (form.twice * turn**2).real)
        there = numbers.copy()
        there[list(field.free)] += sizes * step
        path.append(field.states(there))
    extent = np.ptp(np.array(path), axis=0) / 2
    return Cycle(curve.value(point.at) + away, path[0], extent, 2 * np.pi / frequency)


def _derivatives(curve: Curve, numbers: np.ndarray, weights: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """First and second derivatives of the rates by the unknowns in their sizes, (m, k) and (k, k, m); factors of rows.

    By these the rates change as much as each other: where branches cross, the first derivatives of one may all vanish.
    """
    ways = weights * np.eye(len(weights))
    first = curve.matrix(numbers) * weights
    second = np.real([[curve.field.along(numbers, curve.which, one, other) for other in ways] for one in ways])
    lengths = np.linalg.norm(first, axis=1) + np.linalg.norm(second, axis=(0, 1))
    return first, second, 1 / np.where(lengths > 0, lengths, 1.0)


def crossing(curve: Curve, point: Point) -> list[np.ndarray]:
    """Directions of all branches through a branch point, of length 1 where unknowns count in their sizes.

    They solve the quadratic equation of the second derivatives along the null space (Keller 1977).
    """
    first, second, rows = _derivatives(curve, point.at.numbers, curve.weights(point.at))
    left, _, right = np.linalg.svd(rows[:, np.newaxis] * first)
    ways = right[-2:]
    (a, b), (_, c) = ways @ (second @ (left[:, -1] * rows)) @ ways.T
    # in the plane of the null space: the angles at which the form vanishes
    spread = np.hypot((a - c) / 2, b)
    middle = (a + c) / 2
    if not spread > abs(middle):
        return []
    turned, half = np.arctan2(b, (a - c) / 2), np.arccos(-middle / spread)
    return [np.cos(angle / 2) * ways[0] + np.sin(angle / 2) * ways[1] for angle in (turned + half, turned - half)]


def branch_point(curve: Curve, point: Point, reach: float) -> tuple[Point, float] | None:
    """The branch point within ``reach`` of a point, to rounding, and the error of its parameter.

    The equations are regular there, as those of the branch are not.

    They are F(u) + b w = 0, w^T F'(u) = 0 and w^T w = 1 in the unknowns u, the left null vector w and b, which is zero
    (Allgower and Schwetlick 1997, doi:10.1002/zamm.19970770106).
    """
    field, weights = curve.field, curve.weights(point.at)
    m, b, numbers = len(field.free), 0.0, point.at.numbers.copy()
    first, second, rows = _derivatives(curve, numbers, weights)
    w = np.linalg.svd(rows[:, np.newaxis] * first)[0][:, -1]
    last = np.inf
    for _ in range(TUNING.newton_steps):
        first, second, _ = _derivatives(curve, numbers, weights)
        slopes, hessian = rows[:, np.newaxis] * first, second @ (w * rows)
        left = np.concatenate([rows * field.rate(numbers) + b * w, w @ slopes, [(w @ w - 1) / 2]])
        whole = np.zeros((2 * m + 2, 2 * m + 2))
        whole[:m, : m + 1], whole[:m, m + 1 : -1], whole[:m, -1] = slopes, b * np.eye(m), w
        whole[m:-1, : m + 1], whole[m:-1, m + 1 : -1] = hessian, slopes.T
        whole[-1, m + 1 : -1] = w
        if not (np.isfinite(whole).all() and np.isfinite(left).all()):
            return None
        try:
            step = -np.linalg.solve(whole, left)
        except np.linalg.LinAlgError:
            return None
        numbers = numbers.copy()
        numbers[curve.places] += weights * step[: m + 1]
        w, b = w + step[m + 1 : -1], b + float(step[-1])
        length = float(np.abs(step).max())
        if length <= TUNING.settled or (length < TUNING.same and length > last / 2):
            break
        last = length
    else:
        return None
    away = np.abs(numbers[curve.places] - curve.unknowns(point.at)) / weights
    if away.max() > reach or abs(b) > TUNING.same:
        return None
    doubt = np.concatenate([rows * field.rounding(numbers), UNIT * np.abs(w) @ np.abs(slopes) * np.ones(m + 1), [UNIT]])
    error = np.abs(np.linalg.inv(whole)) @ (4 * doubt)
    one = equilibrium(field, numbers)
    return Point(one, point.tangent, point.arclength), float(weights[-1] * error[m])


def beyond(
    system: "HybridSystem", curve: Curve, point: Point, side: int, sizes: np.ndarray, error: float
) -> tuple[Beyond, Equilibrium | None]:
    """What follows where a guard of the mode is met, and the equilibrium of another mode that is there.

    ``side``: which guard. ``sizes``, shape (n,): how large each state is. ``error``: of the parameter.
    """
    from chaosdrill.equilibrium.expressions import may_rest

    field, numbers = curve.field, point.at.numbers
    own = _side_slope(curve, point.at, [side])
    partners: list[tuple[Equilibrium, int]] = []
    rests, n = False, len(field.system.state_names)
    values = numbers[n : n + len(field.system.parameters)]
    known = np.concatenate([point.at.states, values])
    errors = np.concatenate([TUNING.same * sizes, np.zeros(len(values))])
    errors[field.place(curve.which)] = error
    outcomes = [field.system.transitions[i] for i in field.sides[side].outcomes]
    for target in dict.fromkeys(one.target for one in outcomes if one.target != field.system.mode_names[field.mode]):
        try:
            other = field_of(system, target)
        except NoFieldError:
            rests |= may_rest(field.system, target, known, errors)
            continue
        begin = other.numbers(point.at.states, values)
        found = polished(other, begin)
        if found is None:
            rests |= may_rest(field.system, target, known, errors)
            continue
        there = equilibrium(other, found)
        apart = np.abs(there.states - point.at.states)
        near = TUNING.same * sizes + TUNING.same_errors * np.nan_to_num(there.state_errors(), posinf=np.inf)
        if (apart > near).any():
            continue
        doubt = np.maximum(there.height_errors, _reach(there, near))
        if any(other.crossed(k, there.numbers) for k in np.flatnonzero(there.heights > doubt).tolist()):
            continue
        met = np.flatnonzero(np.abs(there.heights) <= doubt)
        twin = Curve(other, curve.which, curve.limits, sizes[list(other.free)], curve.bounds, curve.step)
        partners.append((there, _side_slope(twin, there, met.tolist())))
    if not partners:
        return (Beyond.UNDECIDED if rests else Beyond.NO_PARTNER), None
    if len(partners) > 1:
        return Beyond.UNDECIDED, partners[0][0]
    ((there, slope),) = partners
    if own * slope == 0:
        return Beyond.UNDECIDED, there
    return (Beyond.NONSMOOTH_FOLD if own == slope else Beyond.PERSISTENCE), there


def _reach(one: Equilibrium, near: np.ndarray) -> np.ndarray:
    """By how much guards change over a distance of the states."""
    slopes = np.abs(one.field.slopes(one.numbers))
    # where states are not known at all, guards that do not read them are
    parts = np.multiply(slopes, near[list(one.field.free)], out=np.zeros_like(slopes), where=slopes > 0)
    return np.asarray(parts.sum(axis=1))


def _side_slope(curve: Curve, one: Equilibrium, sides: list[int]) -> int:
    """To which side of the parameter an equilibrium at guards is admissible: 1 to larger ones, -1; 0 is undecided."""
    matrix = curve.matrix(one.numbers)
    try:
        moves = -np.linalg.solve(matrix[:, :-1], matrix[:, -1])
    except np.linalg.LinAlgError:
        return 0
    if not sides or one.spectrum.values.size == 0 or (np.abs(one.spectrum.values) <= one.spectrum.errors).any():
        return 0
    slopes = curve.field.slopes(one.numbers, curve.which)[sides]
    parts = slopes * np.append(moves, 1.0)
    total, doubt = parts.sum(axis=1), TUNING.sliding * np.abs(parts).sum(axis=1)
    ways = set(np.where(np.abs(total) <= doubt, 0, -np.sign(total)).astype(int).tolist())
    return ways.pop() if len(ways) == 1 else 0
