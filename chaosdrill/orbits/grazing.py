"""What a grazing point does: the leading term of the return map beside it, and the motion that follows.

A path whose guard would rise to y > 0 above zero meets the guard a time sqrt(2 y/A) early, A being how fast the guard's
rate falls at its greatest value. What the event then does to the path is its discontinuity map (Nordmark 1991,
doi:10.1016/0022-460X(91)90592-8; di Bernardo, Budd, Champneys and Kowalczyk 2008, doi:10.1007/978-1-84628-708-4,
chapters 6 to 8): the state is shifted by a vector times a power of y, 1/2 for an impact, 1/2 or 3/2 for another field,
1 where the motion slides, 2 where it leaves a surface on which it slides. Carried once around the orbit, the shift
changes the next y by the coefficient times that power.

After an event of the power 1/2 the guard's greatest values are those that the tangent map M makes of the shift. If one
of them is above zero the motion leaves: it jumps (Fredriksson and Nordmark 1997, doi:10.1098/rspa.1997.0069). If all
are below, it comes back along the direction of the largest multiplier in which the guard sees it, and the square-root
map of this one number decides (Chin, Ott, Nusse and Grebogi 1994, doi:10.1103/PhysRevE.50.4427): below 1/4 periods add
up without a gap, below 2/3 with chaos between them, and above there is chaos at once.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.codegen import kernels_of
from chaosdrill.codegen.signatures import event_places
from chaosdrill.dataset.branches import Onset, Special
from chaosdrill.engine import shooting as at
from chaosdrill.engine.layout import DONE
from chaosdrill.engine.setup import constrained_states
from chaosdrill.orbits.criticality import cut, extrapolated
from chaosdrill.orbits.guards_met import Touch, touches
from chaosdrill.orbits.problem import LostError
from chaosdrill.orbits.results import GrazingForm
from chaosdrill.orbits.special import Touching, test_function_at
from chaosdrill.orbits.tuning import TUNING

if TYPE_CHECKING:
    from chaosdrill.orbits.orbit import Orbit
    from chaosdrill.orbits.problem import Problem, Shot

UNDECIDED = GrazingForm(Onset.UNDECIDED)


@dataclass(frozen=True)
class Shift:
    """What an event at a grazing point adds to the state, times a power of the guard's greatest value."""

    power: float
    vector: np.ndarray  # (d,): NaN where only the power is known
    error: float  # relative


class Place:
    """Fields and guards at the point where an orbit touches a guard.

    ``orbit``: the orbit without the event. ``instant``: time since the start of the orbit.
    """

    def __init__(self, problem: "Problem", orbit: "Orbit", touch: Touch, instant: float) -> None:
        self.problem, self.touch = problem, touch
        d, total = problem.states, float(orbit.durations.sum())
        self.kernels = kernels_of(problem.system)
        self.constants = self.kernels.constants(problem.system.parameters)
        self.mode = int(orbit.segments[touch.segment, at.SEGMENT_MODE])
        self.time, self.total = orbit.phase + instant, total
        when = np.array([[instant % total if orbit.eventless else instant]])
        self.state = np.concatenate([problem.at([orbit], when)[0][0, 0], orbit.starts[0, d:]])
        self.sizes = np.maximum(problem.sizes, np.abs(orbit.starts[:, :d]).max(axis=0))

    def field(self, mode: int, along: np.ndarray | None = None) -> np.ndarray:
        """Rates of the states, shape (d,), also a way along a direction of states and, last, time."""
        rates = np.zeros(len(self.state) + len(self.problem.system.quadratures))
        self.kernels.functions.field(mode, *self._beside(along), rates)
        return rates[: self.problem.states]

    def guard(self, mode: int, guard: int, along: np.ndarray | None = None) -> tuple[float, float, np.ndarray]:
        """Value of a guard, its rate along the field of the mode, and its gradient, shape (d,)."""
        gradient, n, d = np.zeros(len(self.state) + 1), len(self.state), self.problem.states
        time, constants, state = self._beside(along)
        value = self.kernels.functions.guard(mode, guard, time, constants, state, gradient)
        return float(value), float(gradient[:d] @ self.field(mode, along) + gradient[n]), gradient[:d]

    def slope(self, function: Callable[[np.ndarray], np.ndarray], along: np.ndarray) -> tuple[np.ndarray, float]:
        """Derivative of a function, shape (m,), along a direction (states, time), and its relative error."""

        def difference(part: float) -> np.ndarray:
            ahead, back = (function(sign * part * along) for sign in (1.0, -1.0))
            if not (np.isfinite(ahead).all() and np.isfinite(back).all()):
                raise LostError("a field has no value beside the guard")
            return (ahead - back) / (2 * part)

        value, error, _ = extrapolated(difference)
        return value, float((error / np.maximum(np.abs(value).max(), 1e-300)).max())

    def _beside(self, along: np.ndarray | None) -> tuple[float, np.ndarray, np.ndarray]:
        if along is None:
            return self.time, self.constants, self.state
        state = self.state.copy()
        state[: len(along) - 1] += along[:-1]
        return self.time + float(along[-1]), self.constants, state

    def onward(self, mode: int) -> np.ndarray:
        """The direction of the motion in a mode, states and time, a radian of the orbit long."""
        return np.append(self.field(mode), 1.0) * (self.total / (2 * np.pi))

    def nothing(self, change: np.ndarray, beside: np.ndarray) -> bool:
        """Whether a change of the rates is nothing beside the rates themselves."""
        most = np.abs(beside / self.sizes).max()
        return bool(np.abs(change / self.sizes).max() <= TUNING.touching * max(most, 1 / self.total))


def grazing_form(problem: "Problem", orbit: "Orbit", shot: "Shot", weights: np.ndarray) -> GrazingForm:
    """The leading term of the return map beside a grazing point, and what follows there.

    ``orbit``: the last one before the change of events. ``shot``: around it. ``weights``, shape (columns,).

    Undecided where no orbit without the event is found, where it touches several guards at once, where the event has an
    effect however slow it is, where a return after it is neither above nor below the guard (a resonance), and where
    orbits come in families.
    """
    try:
        test, orbit, shot, instant = test_function_at(problem, orbit, shot, Special.GRAZING, weights)
        if not isinstance(test, Touching):
            return UNDECIDED
        place = Place(problem, orbit, test.touch, instant)
        shift = _shift(place)
        if shift is None:
            return UNDECIDED
        if shift.power <= 1 and _several(problem, orbit, instant):
            return replace(UNDECIDED, power=shift.power)
        return _form(place, shift, orbit, instant)
    except (LostError, np.linalg.LinAlgError):
        return UNDECIDED


def _several(problem: "Problem", orbit: "Orbit", instant: float) -> bool:
    """Whether an orbit touches a guard elsewhere, too, or still has a stay of no time, as a symmetric one has."""
    total = float(orbit.durations.sum())
    others = [when for value, _, when in touches(problem, orbit) if value <= TUNING.touching]
    apart = [abs((when - instant) / total - round((when - instant) / total)) for when in others]
    return bool(max(apart, default=0.0) > TUNING.tangential or orbit.durations.min() <= TUNING.tangential * total)


def _shift(place: Place) -> Shift | None:
    """The discontinuity map: what the event does to a path that meets the guard; None for an unknown kind."""
    problem, mode, guard = place.problem, place.mode, place.touch.guard
    onward, pace = place.onward(mode), place.total / (2 * np.pi)

    def rate(along: np.ndarray) -> np.ndarray:
        return np.array([place.touch.side * place.guard(mode, guard, along)[1]])

    slope, doubt = place.slope(rate, onward)
    fall = -float(slope[0]) / pace
    if not fall > 0:
        return None
    taken, image, jump = _event(place, mode, guard, place.field(mode))
    if taken < 0 or np.abs((image - place.state[: len(image)]) / place.sizes).max() > TUNING.touching:
        return None
    other = problem.plain.mode_names.index(problem.plain.transitions[taken].target)
    if other == mode:
        return Shift(0.5, np.sqrt(2 / fall) * jump, doubt)
    if not place.nothing(jump, place.field(mode)):
        return None
    return _through(place, other, fall, doubt)


def _event(place: Place, mode: int, guard: int, rates: np.ndarray) -> tuple[int, np.ndarray, np.ndarray]:
    """The transition that is taken at the guard, the state after it, and what it makes of the rates of its mode.

    The last is by how much a path that meets the guard a time early is ahead of one that does not, over that time.
    """
    n, d = len(place.state), place.problem.states
    where = event_places(n)
    room = np.zeros(where.size)
    state = place.state.copy()
    taken = place.kernels.functions.event_map(mode, guard, place.time, place.constants, state, 1, np.ones(n), 0.0, room)
    jacobian = room[where.jacobian :][: n * (n + 1)].reshape(n, n + 1)
    return int(taken), room[where.image :][:d], rates - jacobian[:d, :d] @ rates - jacobian[:d, n]


def _through(place: Place, other: int, fall: float, doubt: float) -> Shift | None:
    """The shift by a stay in another mode, which the path leaves again at once."""
    problem = place.problem
    here, there = place.field(place.mode), place.field(other)
    unknown = np.full(len(here), np.nan)
    back = _way_back(place, other)
    if back is None:
        return None
    if not place.nothing(there - here, here):
        guard, side = back

        def rate(along: np.ndarray) -> np.ndarray:
            return np.array([place.guard(other, guard, along)[1]])

        away, first = place.slope(rate, -place.onward(place.mode))
        bend, second = place.slope(rate, place.onward(other))
        side = side or -int(np.sign(away[0]))
        if not (side * away[0] < 0 < side * bend[0]):
            return None
        # the guard of the way back goes away with the first, and comes back with the second
        stay = -2 * float(away[0] / bend[0])
        return Shift(0.5, stay * np.sqrt(2 / fall) * (there - here), doubt + first + second)
    held = np.array(place.kernels.layout.held) + constrained_states(problem.system).sum(axis=1)

    def apart(along: np.ndarray) -> np.ndarray:
        return place.field(other, along) - place.field(place.mode, along)

    if held[other] > held[place.mode]:
        growth, error = place.slope(apart, place.onward(place.mode))
        return Shift(1.0, -growth / (place.total / (2 * np.pi)) / fall, doubt + error)
    if held[place.mode] > held[other]:
        return Shift(2.0, unknown, doubt)
    gradient = place.touch.side * place.guard(place.mode, place.touch.guard)[2]
    try:
        growth, _ = place.slope(apart, place.onward(place.mode))
        across = gradient * place.sizes / np.abs(gradient * place.sizes).max() * place.sizes
        stiff, error = place.slope(apart, np.append(across, 0.0))
    except LostError:
        # as of a contact whose force goes with a broken power of the depth
        return Shift(np.nan, unknown, doubt)
    if not place.nothing(growth, here) or place.nothing(stiff, here):
        return Shift(1.5, unknown, doubt)
    return Shift(1.5, 4 / 3 * np.sqrt(2 / fall) * stiff / float(gradient @ across), doubt + error)


def _way_back(place: Place, other: int) -> tuple[int, int] | None:
    """Guard of another mode that is zero here and leads back, and its direction; None without one."""
    for j, event in enumerate(place.kernels.layout.events[other]):
        targets = {place.problem.plain.transitions[k].target for k in event.outcomes}
        value, _, gradient = place.guard(other, j)
        size = np.abs(gradient * place.sizes).max()
        if place.problem.plain.mode_names[place.mode] in targets and abs(value) <= TUNING.touching * size:
            return j, int(event.direction)
    return None


def _form(place: Place, shift: Shift, orbit: "Orbit", instant: float) -> GrazingForm:
    """The coefficient of the shift after one turn around the orbit, and what follows."""
    problem = place.problem
    neutral = problem.neutral
    families = len(problem.conserved) or neutral.count > int(neutral.flow)
    row, turn, vector, count = _turn(place, shift, orbit, instant)
    coefficient = float(row @ turn @ vector)
    noise = TUNING.tangent_error * count * np.linalg.norm(row) * np.linalg.norm(turn) * np.linalg.norm(vector)
    error = float(abs(coefficient) * shift.error + noise)
    if families:
        return GrazingForm(Onset.UNDECIDED, shift.power, coefficient, error)
    returns = _Returns(turn, row, vector, int(neutral.flow), shift.error, count)
    onset, decisive = returns.onset(shift.power)
    return GrazingForm(onset, shift.power, coefficient, error, decisive)


def height_of_return(problem: "Problem", orbit: "Orbit", touch: Touch, instant: float, number: int) -> float:
    """Height of a return after a grazing event, as a part of what it may be, for the power 1/2; else NaN.

    ``orbit``: the orbit without the event. ``instant``: time since the start of the orbit. ``number``: from 1.
    """
    try:
        place = Place(problem, orbit, touch, instant)
        shift = _shift(place)
        if shift is None or shift.power != 0.5:
            return float("nan")
        row, turn, vector, _ = _turn(place, shift, orbit, instant)
    except LostError:
        return float("nan")
    most = np.linalg.norm(row) * np.linalg.norm(vector) * np.linalg.norm(turn) ** number
    return float(row @ np.linalg.matrix_power(turn, number) @ vector / most)


def _turn(place: Place, shift: Shift, orbit: "Orbit", instant: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, int]:
    """Gradient of the guard, tangent map around the orbit from there and shift, in its units; number of segments."""
    problem, touch, d = place.problem, place.touch, place.problem.states
    path = cut(problem, orbit, touch.segment, instant - float(orbit.durations[: touch.segment].sum()))
    shot = problem.shoot(path, False)
    if shot.outcome != DONE or not np.isfinite(shot.monodromy).all():
        raise LostError("the orbit that touches the guard has no multipliers")
    row = touch.side * place.guard(place.mode, touch.guard)[2] * problem.units
    return row, shot.monodromy[:d, :d], shift.vector / problem.units, len(path)


class _Returns:
    """Heights of a guard after an event that shifts the state, as a sum of powers of the multipliers.

    ``turn``, shape (d, d): tangent map around the orbit from where it touches the guard. ``row``, ``vector``, shape
    (d,): the guard's gradient, and the shift. ``flow``: 1 where a shift in time is an orbit as well, which the guard
    does not notice where it is greatest. ``error``: of the shift, relative. ``segments``: how many the tangent map is
    made of.
    """

    def __init__(
        self, turn: np.ndarray, row: np.ndarray, vector: np.ndarray, flow: int, error: float, segments: int
    ) -> None:
        self.turn, self.row, self.vector = turn, row, vector
        values, right = np.linalg.eig(turn)
        keep = np.argsort(np.abs(values - 1))[flow:]
        keep = keep[np.argsort(-np.abs(values[keep]), kind="stable")]
        self.values = values[keep]
        self.doubt = TUNING.tangent_error * segments * np.linalg.cond(right) + error
        if np.isfinite(vector).all():
            parts = (row @ right) * np.linalg.solve(right, vector)
            self.parts = parts[keep]
            self.noise = self.doubt * float(np.abs(row @ right).max() * np.abs(np.linalg.solve(right, vector)).max())

    def onset(self, power: float) -> tuple[Onset, int]:
        """What follows, and the number of the return that decides it; 0 if none does."""
        if not (np.abs(self.values) < 1).all():
            return Onset.NONE, 0
        if not power <= 1:
            return Onset.CONTINUOUS, 0
        if not np.isfinite(self.vector).all():
            return Onset.UNDECIDED, 0
        if power == 1:
            beyond = np.linalg.eigvals(self.turn @ (np.eye(len(self.row)) + np.outer(self.vector, self.row)))
            kept = np.delete(beyond, np.abs(beyond - 1).argmin()) if len(beyond) > len(self.values) else beyond
            return (Onset.CONTINUOUS if (np.abs(kept) < 1).all() else Onset.UNDECIDED), 0
        if not (self.doubt < TUNING.missed_multiplier and np.isfinite(self.vector).all()):
            return Onset.UNDECIDED, 0
        seen = np.flatnonzero(np.abs(self.parts) > self.noise)
        if not len(seen):
            return Onset.CONTINUOUS, 0
        values, parts = self.values[seen], self.parts[seen]
        first, most = values[0], np.abs(values[0])
        same = np.abs(values) > (1 - TUNING.missed_multiplier) * most
        for count in range(1, TUNING.most_returns + 1):
            shares = parts * (values / most) ** count
            height, noise = float(shares.sum().real), self.noise * len(shares)
            if abs(height) <= noise:
                return Onset.UNDECIDED, count
            if height > 0:
                return Onset.JUMP, count
            if same.sum() == 1 and abs(shares[0]) > np.abs(shares[1:]).sum() and first.real > 0:
                return self._one_number(float(first.real)), 0
        return Onset.UNDECIDED, 0

    def _one_number(self, largest: float) -> Onset:
        """What the square-root map of the largest multiplier does."""
        for bound, onset in ((0.25, Onset.PERIOD_ADDING), (2 / 3, Onset.PERIOD_ADDING_CHAOS), (1.0, Onset.CHAOS)):
            if abs(largest - bound) <= self.doubt:
                break
            if largest < bound:
                return onset
        return Onset.UNDECIDED
