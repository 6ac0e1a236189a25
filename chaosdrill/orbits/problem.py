"""Orbits of one system, with the parameters that are left free: their equations, and Newton's method."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy.linalg import lstsq
from scipy.linalg.lapack import dgetrf, dgetrs

from chaosdrill.engine import shooting as at
from chaosdrill.engine.layout import DONE, ESCAPED
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.period import forcing_periods
from chaosdrill.engine.scales import SMALLEST
from chaosdrill.engine.segment import BOUND
from chaosdrill.engine.shifts import Shifts, shifts_of
from chaosdrill.model import HybridSystem
from chaosdrill.orbits.neutral import Neutral, neutral_of
from chaosdrill.orbits.orbit import Orbit
from chaosdrill.orbits.residual import Residual
from chaosdrill.orbits.roots import bracketed
from chaosdrill.orbits.sizes import sizes_met
from chaosdrill.orbits.tuning import TUNING

# how Newton's method ended; other values are outcomes of a run
CONVERGED, SINGULAR, SLOW = 0, 101, 102


class LostError(Exception):
    """Newton's method failed between two points of a curve, or beside one."""


@dataclass(frozen=True)
class Shot:
    """What one time around an orbit shows."""

    outcome: int  # DONE, or what ended a run on the way
    residual: float  # largest violation of an equation
    equations: np.ndarray  # (N + d + 1, columns + 1): linearised equations; their constants last
    sensitivity: np.ndarray  # (N, d + q, columns + 1): starts of the segments by the reduced unknowns
    monodromy: np.ndarray
    """(d, d): tangent map around the orbit from its first start, saltation included, in the units of `Problem.units`"""
    factors: np.ndarray  # (N, d, d): its factors, one a segment, in the same units
    speeds: np.ndarray
    """(N,): speeds at which the guards are crossed, positive in their direction; infinite without a guard."""
    rates: np.ndarray  # (N,): rates there of the guards as they are written; infinite without a guard
    crossed: np.ndarray  # int (N,): guard crossed on the way, -1 for none, BOUND where a bound comes first
    came: np.ndarray  # int (N,): the transition that the end of the segment took
    met: np.ndarray  # (N,): time since the start of the segment at which that guard is crossed
    drift: np.ndarray | None = None  # (d,): as of `Orbit`, with what it is shifted along lines

    @property
    def regular(self) -> bool:
        """Whether the system was followed around the orbit, and the equations have derivatives there."""
        return self.outcome == DONE and bool(np.isfinite(self.equations).all())

    def sharp(self, orbit: Orbit) -> bool:
        """Whether all events are met at their times, not only near their guards: late rebounds of chatter are low."""
        met = np.isfinite(self.speeds)
        misses = np.abs(self.equations[: len(orbit), -1])[met]
        return not (misses > TUNING.sharp_events * np.abs(self.speeds[met]) * np.abs(orbit.durations[met])).any()

    def bare(self) -> "Shot":
        """Without the derivatives by the unknowns, which are large and quickly computed again."""
        return replace(self, equations=np.zeros((0, 0)), sensitivity=np.zeros((0, 0, 0)))


def lasting(orbit: Orbit) -> np.ndarray:
    """Durations of the segments, one of rounding's length between two events in one instant as a positive one."""
    return np.where(orbit.tied, TUNING.same_instant * float(orbit.durations.sum()), orbit.durations)


def admissible(orbit: Orbit, shot: Shot) -> bool:
    """Whether the system follows the orbit as it is written down: its guards, their order, their outcomes."""
    events = orbit.segments[:, at.SEGMENT_END] >= 0
    return bool(
        (shot.crossed < 0).all()
        and (shot.came == orbit.segments[:, at.SEGMENT_OUTCOME]).all()
        and (lasting(orbit) > 0).all()
        and (shot.speeds[events] > 0).all()
    )


def escapes(orbit: Orbit, shot: Shot) -> bool:
    """Whether a bound alone keeps the system from following the orbit as it is written down."""
    return bool((shot.crossed == BOUND).any()) and admissible(orbit, shot)


@dataclass(frozen=True)
class _Step:
    """A correction of Newton's method, of which a part may be taken."""

    origin: Orbit
    states: int
    sensitivity: np.ndarray  # that of `Shot`
    correction: np.ndarray  # (columns,)
    length: float  # of the correction, in the norm of the weights

    def part(self, reach: float) -> float:
        """The part that is at most as long as ``reach``."""
        return min(1.0, reach / self.length) if self.length > 0 else 1.0

    def taken(self, reach: float) -> Orbit:
        """The orbit to which this part leads."""
        part, old, d = self.part(reach), self.origin, self.states
        return Orbit(
            old.segments,
            old.periods,
            old.starts + part * (self.sensitivity @ np.append(self.correction, 1.0)),
            old.phase + part * float(self.correction[d]),
            old.durations + part * self.correction[d + 1 : d + 1 + len(old)],
            old.drift,
        )

    def foresaw(self, reach: float, weights: np.ndarray, following: np.ndarray) -> bool:
        """Whether this part was not all, and the correction after it is the rest of the way, as it was."""
        part = self.part(reach)
        off = float(np.linalg.norm(weights * (following - (1 - part) * self.correction)))
        return part < 1 and off <= TUNING.linear * part * self.length


class Problem:
    """The orbits of a system over its free parameters.

    ``system``: with the values of all parameters that are not free. ``free``: parameters that orbits are looked for in;
    none by default. ``numerics``: method and tolerance. ``shifts``: shifts of the states but for which orbits close; by
    default all that the system does not notice.
    """

    def __init__(
        self,
        system: HybridSystem,
        free: Sequence[str] = (),
        numerics: Numerics | None = None,
        shifts: Shifts | None = None,
    ) -> None:
        # on the way to an orbit at its limit a parameter may step over it
        self.plain, self.free = system.limited({}), tuple(free)
        self.numerics = numerics or Numerics()
        self.states = len(system.state_names)
        self.forced = system.forced
        self._residual = Residual(system, self.free, self.numerics)
        self.system = self._residual.system
        self.ends = self._residual.ends
        """Kinks in its free parameters between which it is followed, one pair for each; none if there are none."""
        self.shifts = shifts_of(self.plain) if shifts is None else shifts
        self._periods: dict[tuple[float, ...], float] = {}
        self.carriers: dict[tuple[str, ...], Any] = {}
        """What derives its orbits by parameters (`chaosdrill.orbits.derivatives`), by their names."""
        self.unit = system.forcing_period()
        """Forcing period; without one the characteristic time of the motion, as soon as one was followed."""
        self.remarks: dict[str, None] = {}
        """What was in the way of those who looked at its orbits, in words, once each."""
        self.conserved = np.zeros((0, self.states))
        """Differentials of conserved quantities at the start of the first orbit, as `conserved_at` finds them."""
        self._model: Problem | None = None

    def set_unit(self, unit: float) -> None:
        """Let a system without a period be followed in steps that go with its motion, not with the unit of time."""
        self.unit = unit
        self._residual.set_unit(unit)

    def alike(self, system: HybridSystem, free: Sequence[str], numerics: Numerics | None = None) -> "Problem":
        """The problem of other parameters, by default in the same steps; states behind its own are not shifted.

        States have the same sizes in both.
        """
        other = Problem(system, free, numerics or self.numerics, self.shifts.among(len(system.state_names)))
        if not self.forced and self.unit is not None:
            other.set_unit(self.unit)
        other.conserved = self.conserved
        if other.states == self.states:
            other._model = self
        return other

    @property
    def accuracy(self) -> float:
        """Error of an orbit due to the method, relative to its size."""
        if self.numerics.traits.fixed_step:
            return self.numerics.angle**4
        return max(TUNING.tangent_error, self.numerics.tolerance)

    @property
    def nearly_closed(self) -> float:
        """The residual at which the equations of an orbit tell whether it is one of a family."""
        return max(TUNING.closes, TUNING.closes_by * self.accuracy)

    @property
    def dependent(self) -> float:
        """Singular value, as a part of the largest, below which linearised equations depend on each other."""
        return max(TUNING.smallest_singular_value, TUNING.dependent_by * self.accuracy)

    @property
    def neutral(self) -> Neutral:
        """What the structure of the system leaves neutral on every orbit, and what was found to be conserved."""
        known = neutral_of(self.plain)
        return replace(known, conserved=np.vstack([known.conserved, self.conserved])) if len(self.conserved) else known

    @cached_property
    def closes(self) -> np.ndarray:
        """Which of the closing equations count, bool of shape (d,): each line of shifts costs one."""
        found = np.ones(self.states, dtype=bool)
        found[self.shifts.firsts] = False
        return found

    @property
    def period(self) -> float | None:
        """Forcing period at the present values, as far as they are not free."""
        return self.plain.forcing_period()

    def period_at(self, orbit: Orbit) -> float | None:
        """Forcing period of an orbit."""
        if not self.forced:
            return None
        values = tuple(orbit.starts[0, self.states :].tolist())
        if values not in self._periods:
            self._periods = {values: float(self.periods_at(orbit.starts[:1, self.states :])[0])}
        return self._periods[values]

    def periods_at(self, values: np.ndarray) -> np.ndarray:
        """Forcing periods at values of the free parameters, shapes (P,) and (P, q)."""
        return forcing_periods(self.plain, dict(zip(self.free, values.T, strict=True)), len(values))

    def columns(self, orbit: Orbit) -> int:
        """Number of reduced unknowns."""
        return self.states + 1 + len(orbit) + len(self.free)

    @cached_property
    def sizes(self) -> np.ndarray:
        """Sizes of the states, shape (d,): units, so to speak; see `chaosdrill.orbits.sizes.sizes_met`."""
        if self._model is not None:
            return self._model.sizes
        return sizes_met(self.plain, self.numerics, self.unit)

    @property
    def units(self) -> np.ndarray:
        """Powers of two near the sizes, in which no digit of a state is lost, shape (d,)."""
        return np.asarray(2.0 ** np.round(np.log2(self.sizes)))

    def segment_by_segment(self, orbit: Orbit) -> Iterator[tuple[Orbit, np.ndarray]]:
        """Every segment as a path of its own, and the state before the event at its end, shape (d,)."""
        period = self.period_at(orbit)
        clock = orbit.phase
        for i in range(len(orbit)):
            own = slice(i, i + 1)
            durations = orbit.durations[own]
            one = replace(
                orbit, segments=orbit.segments[own], starts=orbit.starts[own], phase=clock, durations=durations
            )
            yield one, self.at([one], durations[np.newaxis])[0][0, 0]
            clock += float(durations[0])
            clock = clock % period if period else clock

    def comes_again(self, orbit: Orbit, step: int, within: float) -> bool:
        """Whether a path repeats after this number of segments, within a part of the sizes of the states."""
        starts = orbit.starts[:, : self.states]
        size = np.maximum(np.abs(starts).max(axis=0), 1e-6 * self.sizes)
        turned = np.abs(self.shifts.across(np.roll(starts, step, axis=0) - starts))
        # both turns solve the equations to a residual only, of which a state that stays zero consists
        apart = turned > within * size + 4 * self.solved_to(starts)
        return bool(np.array_equal(np.roll(orbit.segments, step, axis=0), orbit.segments) and not apart.any())

    def solved_to(self, states: np.ndarray) -> np.ndarray:
        """Residual at which equations between states (M, d) are solved, shape (d,)."""
        return np.asarray(TUNING.residual * np.maximum(self.sizes, np.abs(states).max(axis=0)))

    def shoot(
        self,
        orbit: Orbit,
        watched: bool = True,
        section: Orbit | None = None,
        solved: float | None = None,
    ) -> Shot:
        """The shooting residual of an orbit, and its derivatives.

        ``watched``: whether to look for other guards on the way. ``section``: the one through whose start, across the
        flow there, the plane goes on which an orbit without events and without a period begins; by default the orbit
        itself. ``solved``: the residual by which states are taken to be off; by default that of solved equations. A
        rebound lower than that is none: where equations that hold better show a crossing, their own residual counts.
        """
        d = self.states
        plane = self.plane(section or orbit)
        if orbit.drift is not None:
            plane[at.DRIFT] = orbit.drift
        exactness = self.solved_to(orbit.starts[:, :d])
        if solved is not None:
            exactness = solved / TUNING.residual * exactness
        outcome, residual, found = self._residual(orbit, self.sizes, exactness, plane, watched)
        equations, sensitivity, monodromy, factors, speeds, rates, seen, met = found
        if watched and solved is None and residual < TUNING.residual and (seen[:, 0] >= 0).any():
            return self.shoot(orbit, watched, section, residual)
        if not np.isfinite(equations[:, -1]).all():
            residual = np.inf
        units = self.units
        monodromy, factors = (a[..., :d, :d] * units / units[:, np.newaxis] for a in (monodromy, factors))
        drift = plane[at.DRIFT] if self.shifts else None
        return Shot(
            *(outcome, residual, equations, sensitivity, monodromy, factors, speeds, rates),
            *(seen[:, 0], seen[:, 1], met, drift),
        )

    def newton(
        self,
        orbit: Orbit,
        conditions: np.ndarray | None = None,
        reach: float = 0.5,
        weights: np.ndarray | None = None,
        section: Orbit | None = None,
        enough: float = TUNING.residual,
    ) -> tuple[int, Orbit, Shot, np.ndarray]:
        """Newton's method from a guess.

        It has converged when no residual is above ``enough``, when none has become smaller where round-off,
        or the change of the steps with the state, may be all that is left of them, or when the start is known to its
        rounding, of which deviations that grow in one turn make a large residual and durations as little known. On a
        level of what is conserved, which the steps keep to their tolerance only, it has converged when corrections
        become no shorter.

        ``conditions``, shape (q, columns): rows that corrections are orthogonal to; by default the free parameters stay
        as they are. ``reach``: longest correction by one step, in the norm of the weights. Where a shortened one has
        left the rest of the way as it was (Deuflhard 2011, doi:10.1007/978-3-642-23899-4), the next may be twice as
        long. ``weights``, shape (columns,): what a difference of each reduced unknown counts; by default those of
        `weights` at the guess. ``section``: as for `shoot`.

        Returns ``code``, which is `CONVERGED`, or else why not, `SINGULAR`, `SLOW`, or an outcome of a run; the last
        orbit and its shot; and ``residuals``, one a step.
        """
        d, count, section = self.states, len(orbit), section or orbit
        columns = self.columns(orbit)
        weights = self.weights(orbit) if weights is None else weights
        conditions = np.eye(columns)[d + 1 + count :] if conditions is None else conditions
        conditions = np.vstack([conditions, self.held(orbit)])
        residuals: list[float] = []
        code, sharper, shortest, last = SLOW, 0, reach, np.inf
        noise = max(100 * TUNING.residual, TUNING.residual_of_steps * self.numerics.tolerance)
        step: _Step | None = None
        for turn in range(TUNING.newton_steps):
            shot = self.shoot(orbit, turn > 0, section)
            if step is not None and reach > shortest and not (shot.outcome == DONE and np.isfinite(shot.residual)):
                reach = shortest
                orbit = step.taken(reach)
                continue
            residual, before = shot.residual, residuals[-1] if residuals else np.inf
            residuals.append(residual)
            if shot.outcome != DONE:
                code = shot.outcome
                break
            if self.plain.discrete:
                # no steps, and thus none of their errors: beside a sharp fold a small residual is no orbit
                enough = TUNING.rounding
                noise = TUNING.rounding_of_maps * enough * float(np.abs(shot.equations).max())
            close = residual <= enough or (residual <= noise and residual > 0.3 * before)
            if turn > 0 and close and (sharper >= TUNING.sharper_steps or shot.sharp(orbit)):
                code = ESCAPED if escapes(orbit, shot) else CONVERGED
                break
            sharper += close
            if not np.isfinite(residual):
                break
            rows = self._independent(shot.equations[: count + d + 1], count, weights)
            matrix = np.vstack([rows[:, :-1], conditions])
            right = np.concatenate([-rows[:, -1], np.zeros(len(conditions))])
            correction = solve(matrix, right, weights)
            length = float(np.linalg.norm(weights * correction))
            if not np.isfinite(length):
                code = SINGULAR
                break
            grown = TUNING.rounding * float(np.abs(shot.monodromy).max())
            # the durations follow from the start, but for what its rounding grows to on the way
            timeless = np.delete(weights * correction, np.s_[d + 1 : d + 1 + count])
            settled = bool(np.linalg.norm(timeless) <= TUNING.rounding) and max(length, residual) <= grown
            if len(self.conserved) and residual <= self.nearly_closed:
                # what a step loses of a conserved quantity is left, since no equation is solved for it
                settled |= length <= enough or (length <= self.nearly_closed and length > 0.3 * last)
            if turn > 0 and settled:
                code = ESCAPED if escapes(orbit, shot) else CONVERGED
                break
            last = length
            if step is not None and step.foresaw(reach, weights, correction):
                reach *= 2
            step = _Step(orbit, d, shot.sensitivity, correction, length)
            orbit = step.taken(reach)
        if shot.drift is not None and shot.outcome == DONE:
            orbit = replace(orbit, drift=shot.drift if shot.drift.any() else None)
        return code, orbit, shot, np.array(residuals)

    def _independent(self, rows: np.ndarray, count: int, weights: np.ndarray) -> np.ndarray:
        """The equations without those that nothing is left of: those along shifts, and what is conserved gives."""
        if not len(self.conserved) and not len(self.shifts.lines):
            return rows
        kept, d = self.closes, self.states
        closing = rows[count : count + d][kept]
        if len(self.conserved):
            across = np.linalg.svd(self.conserved[:, kept] / weights[:d][kept])[2][len(self.conserved) :]
            closing = across @ (closing * weights[:d][kept, np.newaxis])
        return np.vstack([rows[:count], closing, rows[count + d :]])

    def weights(self, orbit: Orbit, spans: np.ndarray | None = None, gain: float = 1.0) -> np.ndarray:
        """What a difference of each reduced unknown counts.

        States count by their size along the orbit, times by the period, both times ``gain``; parameters by ``spans``,
        the ranges in which they are followed, and then so much more that a step along a branch is one in them.
        """
        d, count = self.states, len(orbit)
        size = np.maximum(np.abs(orbit.starts[:, :d]).max(axis=0), TUNING.smallest_size * self.sizes)
        unit = self.period_at(orbit) or float(orbit.durations.sum())
        part = 1.0 if spans is None else gain * TUNING.states_to_parameters
        values = np.ones(len(self.free)) if spans is None else 1 / spans
        return np.concatenate([part / size, np.full(1 + count, part / unit), values])

    def direction(self, orbit: Orbit, shot: Shot, weights: np.ndarray, row: np.ndarray | None = None) -> np.ndarray:
        """Direction of the branch through an orbit, shape (columns,), of weighted length 1; q must be 1.

        It is the null vector of the linearised equations whose product with ``row`` is positive, by default that along
        which the parameter grows.
        Where they determine it, a row that says how far ahead it leads makes them regular (Keller 1977): a long orbit
        has a thousand unknowns, whose singular values take thirty times as long.
        """
        reference = np.eye(self.columns(orbit))[-1] if row is None else row
        if row is not None and not len(self.held(orbit)):
            rows = np.vstack([shot.equations[: len(orbit) + self.states + 1, :-1], reference])
            vector = solve(rows, np.eye(len(rows))[-1], weights)
            length = np.linalg.norm(weights * vector)
            if np.isfinite(length) and length > 0:
                return np.asarray(vector / length)
        vector = self.null_space(orbit, shot, weights, 1)[0] / weights
        return vector if vector @ reference >= 0 else -vector

    def null_space(self, orbit: Orbit, shot: Shot, weights: np.ndarray, count: int) -> np.ndarray:
        """Directions in which orbits go on, shape (count, columns), orthonormal in weighted unknowns.

        Where every orbit is one of a family, they lead to those that differ least in the quantity that distinguishes
        its members.
        """
        _, sizes, rows = np.linalg.svd(self._weighted(orbit, shot, weights))
        held = self.held(orbit)
        # an orbit of twice the period has one more where it is born
        ordinary = sizes[: len(sizes) + len(self.free) - count]
        more = min(int((ordinary <= self.dependent * sizes[0]).sum()), len(held))
        if not more:
            return np.asarray(rows[-count:])
        null = rows[-count - more :]
        told = held @ (null / weights).T
        return np.asarray(np.linalg.svd(told)[2][-count:] @ null)

    def nearly_null(self, orbit: Orbit, shot: Shot, weights: np.ndarray, count: int = 2) -> np.ndarray:
        """Directions in which orbits most nearly go on within their families, shape (count, columns), as `null_space`.

        Where branches cross, an orbit is known to the root of its residual, and so are the equations there.
        """
        return self._within_families(orbit, shot, weights)[1][-count:]

    def loosely_null(self, orbit: Orbit, shot: Shot, weights: np.ndarray) -> np.ndarray:
        """All directions in which orbits go on to within ``TUNING.loose``, shape (m, columns), as `nearly_null`."""
        sizes, rows = self._within_families(orbit, shot, weights)
        firm = int((sizes > TUNING.loose * sizes[0]).sum())
        return rows[min(firm, len(rows) - len(self.free)) :]

    def _within_families(self, orbit: Orbit, shot: Shot, weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Singular values and right singular vectors of the weighted equations with what a family holds fixed."""
        held = self.held(orbit) / weights
        _, sizes, rows = np.linalg.svd(np.vstack([self._weighted(orbit, shot, weights), held]))
        return np.asarray(sizes), np.asarray(rows)

    def regularity(self, orbit: Orbit, shot: Shot, weights: np.ndarray) -> float:
        """Smallest singular value of the weighted equations that the structure of the system does not make zero."""
        sizes = np.linalg.svd(self._weighted(orbit, shot, weights), compute_uv=False)
        kept = sizes[: len(sizes) - len(self.held(orbit))]
        return float(kept[-1])

    def side(self, orbit: Orbit, row: np.ndarray, weights: np.ndarray) -> float:
        """Sign of the determinant of the linearised equations with one more row; 0 where they are no square."""
        if len(self.held(orbit)):
            return 0.0
        rows = np.vstack([self._weighted(orbit, self.shoot(orbit, False), weights), row / weights])
        return float(np.linalg.slogdet(rows)[0])

    def off(self, orbit: Orbit, shot: Shot, weights: np.ndarray, gain: float = 1.0) -> np.ndarray:
        """How far the unknowns of an orbit may be off where its equations determine them least, shape (columns,).

        They are in the weights, with their ``gain``. States close to within a part of their sizes, also where they are
        smaller than that along the orbit.
        """
        d, count = self.states, len(orbit)
        vectors, sizes, rows = np.linalg.svd(self._weighted(orbit, shot, weights), full_matrices=False)
        last = len(sizes) - len(self.held(orbit)) - 1
        left = np.full(len(vectors), gain * TUNING.states_to_parameters)
        left[count : count + d] = weights[:d] * self.solved_to(orbit.starts[:, :d]) / TUNING.residual
        most = self.accuracy * np.linalg.norm(vectors[:, last] * left) / max(sizes[last], TUNING.smallest_pivot)
        return np.asarray(most * rows[last])

    def kept(self, guess: Orbit, orbit: Orbit, change: np.ndarray) -> Orbit:
        """A guess with what distinguishes the orbits of a family as it is after a change of an orbit.

        Newton's method leaves it alone; what a polynomial makes of its round-off grows from point to point.
        """
        held, d = self.held(orbit), self.states
        if not len(held):
            return guess
        moved = np.append(guess.starts[0, :d] - orbit.starts[0, :d], guess.phase - orbit.phase)
        back = np.linalg.lstsq(held[:, : d + 1], held @ change - held[:, : d + 1] @ moved, rcond=None)[0]
        starts = guess.starts.copy()
        starts[:, :d] += back[:d]
        return replace(guess, starts=starts, phase=guess.phase + float(back[d]))

    def held(self, orbit: Orbit) -> np.ndarray:
        """What distinguishes the orbits of a family, as rows over the reduced unknowns, shape (m, columns).

        What is conserved at any time may change with the time at which an orbit begins, as the phase of a clock does.
        """
        neutral, d = self.neutral, self.states
        shifted_in_time = self.forced and neutral.flow and not orbit.eventless
        if not (shifted_in_time or len(neutral.held)):
            return np.zeros((0, self.columns(orbit)))
        rows = np.zeros((len(neutral.held) + shifted_in_time, self.columns(orbit)))
        rows[: len(neutral.held), :d] = neutral.held
        if self.forced and len(neutral.conserved) and not orbit.eventless:
            rows[: len(neutral.conserved), d] = -neutral.conserved @ self.flow_at(orbit)
        rows[len(neutral.held) :, d] = 1.0
        return rows

    def _weighted(self, orbit: Orbit, shot: Shot, weights: np.ndarray) -> np.ndarray:
        """The linearised equations in weighted unknowns, each without the unit of what it says is zero.

        Those of the states may vanish as a whole where branches cross: they are not scaled by their own entries.
        """
        d, count = self.states, len(orbit)
        rows = np.asarray(shot.equations[: count + d + 1, :-1] / weights)
        largest = np.abs(rows).max(axis=1, keepdims=True)
        largest[count : count + d, 0] = 1 / weights[:d]
        return rows / np.where(largest > 0, largest, 1.0)

    def moved(self, orbit: Orbit, shot: Shot, change: np.ndarray) -> Orbit:
        """The orbit after a change of its reduced unknowns, to first order."""
        d = self.states
        return replace(
            orbit,
            starts=orbit.starts + shot.sensitivity[:, :, :-1] @ change,
            phase=orbit.phase + float(change[d]),
            durations=orbit.durations + change[d + 1 : d + 1 + len(orbit)],
        )

    def beside(
        self, orbit: Orbit, shot: Shot, way: np.ndarray, length: float, weights: np.ndarray
    ) -> tuple[int, Orbit, Shot, np.ndarray]:
        """What `newton` finds some way from an orbit in a direction of the reduced unknowns, at a right angle to it."""
        # in this order, since a square of a weight may be no number
        conditions = (way * weights * weights)[np.newaxis]
        return self.newton(self.moved(orbit, shot, length * way), conditions, TUNING.reach_beside)

    def at(self, orbits: Sequence[Orbit], instants: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """States and modes of orbits of the same segments at times since their starts.

        ``instants``, shape (P, K): rising along every row.

        Returns: ``states``, shape (P, K, d). ``modes``, int, shape (P, K).
        """
        states, modes = self._residual.at(orbits, instants)
        return states[:, :, : self.states], modes

    def begun_beside(self, one: Orbit, other: Orbit, weights: np.ndarray) -> Orbit | None:
        """An orbit without events and period, begun where it comes nearest to the start of another one.

        That is on the plane across the flow there, in the same direction; None where it does not meet it.
        """
        d, there = self.states, other.starts[0, : self.states]
        normal = self.plane(other)[at.NORMAL]
        whole = float(one.durations[0])

        def beside(times: np.ndarray) -> np.ndarray:
            return self.shifts.across(self.at([one], times[np.newaxis])[0][0] - there)

        times = np.linspace(0, whole, TUNING.plane_samples + 1)
        ahead = beside(times[:-1]) @ normal
        ups = np.flatnonzero((ahead <= 0) & (np.roll(ahead, -1) > 0))
        met = np.array([bracketed(lambda t: float(beside(np.array([t]))[0] @ normal), *times[k : k + 2]) for k in ups])
        if not len(met):
            return None
        time = met[int(np.linalg.norm(beside(met) * weights[:d], axis=1).argmin())]
        starts = one.starts.copy()
        starts[0, :d] = self.at([one], np.array([[time]]))[0][0, 0]
        return replace(one, starts=starts)

    def strobes(self, orbits: Sequence[Orbit]) -> tuple[np.ndarray, np.ndarray]:
        """States (P, k, d) at phase 0 of every forcing period, in the order in which they come, and modes (P, k).

        Of systems without a period: the states at the starts of the first segments.
        """
        if not self.forced:
            return self.at(orbits, np.zeros((len(orbits), 1)))
        periods = self.periods_at(np.array([o.starts[0, self.states :] for o in orbits]))
        first = np.array([self.first_strobe(o) for o in orbits])
        return self.at(orbits, first[:, np.newaxis] + periods[:, np.newaxis] * np.arange(orbits[0].periods))

    def first_strobe(self, orbit: Orbit) -> float:
        """Time from the start of an orbit to phase 0 of its first period; 0 for systems without a period.

        A start that is behind phase 0 by no more than round-off is there.
        """
        period = self.period_at(orbit)
        ahead = -orbit.phase % period if period else 0.0
        return ahead if period and period - ahead > TUNING.same_instant * period else 0.0

    def paces(self, orbit: Orbit) -> np.ndarray:
        """What speeds at the guards are relative to, shape (N,): states that move by their sizes in a period.

        Where a guard depends on time alone, its own rate; 1 where no event ends a segment.
        """
        d, found = self.states, np.ones(len(orbit))
        sizes = np.maximum(self.sizes, np.abs(orbit.starts[:, :d]).max(axis=0))
        unit = self.period_at(orbit) or float(orbit.durations.sum())
        for i, (one, before) in enumerate(self.segment_by_segment(orbit)):
            mode, end, _ = one.segments[0].tolist()
            if end >= 0:
                state = np.concatenate([before, one.starts[0, d:]])
                time = one.phase + float(one.durations[0])
                gradient = self._residual.gradient(mode, end, time, state)
                steep = float(np.abs(gradient[:d] * sizes).max()) / unit
                found[i] = steep or abs(float(gradient[-1])) or 1.0
        return found

    def halves_apart(self, orbit: Orbit, weights: np.ndarray) -> np.ndarray:
        """Weighted differences between the two halves of an orbit, shape (m,): starts and durations of their segments.

        Of an orbit that is one segment: its states at the start and half its duration later. Where its halves have
        other events, or take other times of the forcing, there is nothing to compare, and m is 0.
        """
        d, half = self.states, len(orbit) // 2
        if self.forced and orbit.periods % 2:
            return np.zeros(0)
        if len(orbit) == 1:
            states = self.at([orbit], np.array([[0.0, 0.5 * float(orbit.durations[0])]]))[0][0]
            return np.asarray(self.shifts.across(states[0] - states[1]) * weights[:d])
        path = orbit.segments[:, [at.SEGMENT_MODE, at.SEGMENT_END]]
        if len(orbit) % 2 or (path[:half] != path[half:]).any():
            return np.zeros(0)
        moved = self.shifts.across(orbit.starts[:half, :d] - orbit.starts[half:, :d]) * weights[:d]
        return np.concatenate([moved.ravel(), (orbit.durations[:half] - orbit.durations[half:]) * weights[d + 1]])

    def plane(self, orbit: Orbit) -> np.ndarray:
        """What shooting takes an orbit to begin on and to close but for, shape (4 + m, d).

        An orbit without events and period starts on a plane across the flow.
        """
        plane = np.vstack([np.zeros((at.LINES, self.states)), self.shifts.lines])
        if orbit.segments[0, at.SEGMENT_END] == at.PLANE:
            # across the flow in units of the states' sizes: in any others a plane may almost contain it
            plane[at.START] = orbit.starts[0, : self.states]
            plane[at.NORMAL] = self.flow_at(orbit) / self.sizes / self.sizes
        return plane

    def flow_at(self, orbit: Orbit) -> np.ndarray:
        """Rates of the states where an orbit begins, shape (d,)."""
        mode = int(orbit.segments[0, at.SEGMENT_MODE])
        return self._residual.field(mode, orbit.phase, orbit.starts[0])[: self.states]

    def is_modulated(self, orbit: Orbit) -> bool:
        """Whether the forcing acts on motions beside an orbit without events that it leaves at rest.

        Parametric forcing does: the Jacobian there depends on the phase.
        """
        period = self.period_at(orbit)
        if period is None or not orbit.eventless:
            return False
        d, mode = self.states, int(orbit.segments[0, at.SEGMENT_MODE])
        times = orbit.phase + np.arange(TUNING.phases) * period / TUNING.phases
        found = np.array([self._residual.jacobian(mode, time, orbit.starts[0])[:d, :d] for time in times.tolist()])
        found *= self.sizes / self.sizes[:, np.newaxis]
        return bool(np.ptp(found, axis=0).max() > TUNING.at_rest * np.abs(found).max())


def solve(matrix: np.ndarray, right: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Solution of linear equations whose number may be larger than that of the unknowns, if some follow from others.

    ``matrix``, shape (m, n). ``right``, shape (m,). ``weights``, shape (n,): inverse sizes of the unknowns: what counts
    as nothing goes by them.

    Returns, shape (n,): Where the equations leave unknowns free, the shortest one in the weights; NaN if an entry is
    not a number.
    """
    n = len(weights)
    rows = matrix / weights
    largest = np.abs(rows).max(axis=1)
    if not (np.isfinite(largest).all() and np.isfinite(right).all()):
        return np.full(n, np.nan)
    largest[largest == 0] = 1.0
    rows, right = rows / largest[:, np.newaxis], right / largest
    if len(rows) == n:
        # an unknown that hardly enters any equation is not a free one
        widest = np.abs(rows).max(axis=0)
        widest[widest < SMALLEST] = 1.0
        factors, pivots, _ = dgetrf(rows / widest)
        if np.abs(np.diagonal(factors)).min() > TUNING.smallest_pivot:
            return np.asarray(dgetrs(factors, pivots, right)[0]) / widest / weights
    shortest = lstsq(rows, right, TUNING.smallest_pivot, lapack_driver="gelsy", check_finite=False)[0]
    return np.asarray(shortest) / weights
