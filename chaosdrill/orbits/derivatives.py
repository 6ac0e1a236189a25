"""Exact derivatives of what is told of an orbit, by parameters: start, times, means, multipliers.

The linearised shooting equations give those of the unknowns by one linear solve (implicit function theorem). Means and
tangents are carried along the orbit as further states (`chaosdrill.model.lifted`), whose own linearised equations hold
second variations and the derivatives of saltation matrices.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.codegen import kernels_of
from chaosdrill.engine import shooting as at
from chaosdrill.engine.layout import DONE
from chaosdrill.engine.setup import constrained_states
from chaosdrill.model.lifted import Lifted, lifted
from chaosdrill.orbits.expressions import slopes_of_surfaces
from chaosdrill.orbits.orbit import Orbit
from chaosdrill.orbits.results import Derived, underived
from chaosdrill.orbits.settings import SETTINGS

if TYPE_CHECKING:
    from chaosdrill.orbits.problem import Problem, Shot


class Carrier:
    """The shooting problem of orbits with passengers; its free parameters are those by which is derived.

    Parameters
    ----------
    problem : Problem
        Its free parameters are those of its orbits.
    names : sequence of str
        The q parameters by which is derived.
    """

    def __init__(self, problem: "Problem", names: Sequence[str]) -> None:
        system = problem.plain
        self.problem, self.names = problem, tuple(names)
        self.second = not system.sources
        self.lifted: Lifted = lifted(system, tangent=self.second)
        self.free = tuple(dict.fromkeys((*problem.free, *names)))
        self.wide = problem.alike(self.lifted.system.with_parameters(system.parameters), self.free)
        self.n, self.r = len(system.state_names), len(system.quadratures)
        self.wide.sizes = np.concatenate([problem.sizes, np.ones(self.wide.states - self.n)])
        self.integrals = slice(self.n, self.n + self.r)
        self.tangent = slice(self.n + self.r, self.wide.states)

    def derived(self, orbit: Orbit, multipliers: np.ndarray, rank: int) -> Derived:
        """The derivatives on an orbit of the problem.

        Parameters
        ----------
        multipliers : ndarray of complex, shape (n,)
            Those of the orbit, by falling modulus, exactly 0 where rank is lost.
        rank : int
            How many directions are not lost.
        """
        problem = self.problem
        events = int((orbit.segments[:, at.SEGMENT_END] >= 0).sum())
        if words := refusal(problem):
            return underived(problem.plain, len(self.names), events, words)
        first = _Linear(self, orbit, multipliers, rank)
        if first.why:
            return underived(problem.plain, len(self.names), events, first.why)
        beside = _Linear(self, first.displaced(), multipliers, rank)
        values, bounds = first.told()
        others = beside.told()[0] if not beside.why else {}
        errors = {name: _error(bounds[name], values[name] - others.get(name, np.nan)) for name in values}
        message = "" if self.second else "a Python function has no second derivatives, and so multipliers have none"
        if self.second and np.isnan(values["multiplier"]).all():
            message = "an event happens at zero speed, where multipliers are infinite and have no derivatives"
        return Derived(values, errors, first.means, message)


def derived_of(problem: "Problem", names: Sequence[str], orbit: Orbit, multipliers: np.ndarray, rank: int) -> Derived:
    """The derivatives on an orbit of a problem, as of `Carrier.derived`; what is compiled for them serves others."""
    known = problem.carriers.get(tuple(names))
    if known is None:
        known = problem.carriers[tuple(names)] = Carrier(problem, names)
    found: Derived = known.derived(orbit, multipliers, rank)
    return found


def refusal(problem: "Problem") -> str:
    """Why orbits of a problem have no derivatives by parameters; empty if they have."""
    neutral = problem.neutral
    if len(neutral.conserved) > neutral.paired:
        return (
            "the orbit is one of a family at the same parameters, since a quantity is conserved: which of them a "
            "change of a parameter leads to is not determined, and so there are no derivatives"
        )
    return ""


class _Linear:
    """The linearised equations of an orbit with its passengers, solved for what parameters do to it."""

    def __init__(self, carrier: Carrier, orbit: Orbit, multipliers: np.ndarray, rank: int) -> None:
        self.carrier, self.orbit, self.multipliers, self.rank = carrier, orbit, multipliers, rank
        problem, n, count, wide = carrier.problem, carrier.n, len(orbit), carrier.wide.states
        self.accuracy, self.length = problem.accuracy, float(orbit.durations.sum())
        self.base = self._carried(None)
        self.shot = self.shoot(self.base)
        self.own = np.r_[np.arange(n), wide, wide + 1 + np.arange(count)]
        self.given = wide + 1 + count + np.array([carrier.free.index(name) for name in carrier.names], dtype=int)
        equations, self.why = self.shot.equations, ""
        rows = equations[np.r_[np.arange(count + n), count + wide]]
        if self.shot.outcome != DONE or not np.isfinite(rows[:, np.r_[self.own, self.given]]).all():
            self.why = self._words()
            return
        weights = problem.weights(orbit)[: len(self.own)]
        held = problem.held(orbit)[:, : len(self.own)]
        matrix = np.vstack([rows[:, self.own], held]) / weights
        right = -np.vstack([rows[:, self.given], np.zeros((len(held), len(self.given)))])
        scale = np.abs(matrix).max(axis=1, keepdims=True)
        scale[scale == 0] = 1.0
        matrix, right = matrix / scale, right / scale
        missed = float(np.abs(rows[:, -1] / scale[: len(rows), 0]).max())
        left, sizes, across = np.linalg.svd(matrix, full_matrices=False)
        if not sizes[-1] > SETTINGS.smallest_pivot * sizes[0]:
            self.why = self._words()
            return
        inverse = (across.T / sizes) @ left.T
        change = inverse @ right
        off = self.accuracy * (np.abs(matrix).max(axis=1)[:, np.newaxis] * np.abs(change).sum(axis=0) + np.abs(right))
        self.weakest = across[-1] * max(self.accuracy, missed) / sizes[-1] / weights
        self.change = np.zeros((equations.shape[1] - 1, len(self.given)))
        self.uncertain = np.zeros_like(self.change)
        self.change[self.own] = change / weights[:, np.newaxis]
        self.uncertain[self.own] = (np.abs(inverse) @ off) / weights[:, np.newaxis]
        self.change[self.given] = np.eye(len(self.given))
        integrals = self._passengers(self.shot, carrier.integrals)
        self.means, self.moved_integrals = integrals[:, -1] / self.length, integrals[:, :-1]

    def _words(self) -> str:
        """Why there are no derivatives."""
        orbit, problem = self.orbit, self.carrier.problem
        slow = int(np.argmin(self.shot.speeds / problem.paces(orbit)))
        end, outcome = orbit.segments[slow, [at.SEGMENT_END, at.SEGMENT_OUTCOME]].tolist()
        if end >= 0 and not self.shot.speeds[slow] > SETTINGS.grazing_speed * problem.paces(orbit)[slow]:
            name = problem.plain.transitions[outcome].name
            return f"{name!r} meets its guard at zero speed, where derivatives by parameters are infinite"
        return "the equations of the orbit are singular, as at a fold: derivatives by parameters are infinite there"

    def shoot(self, starts: np.ndarray) -> "Shot":
        """The shot with passengers that begin all segments so."""
        orbit, lifted_ = self.orbit, self.carrier.lifted
        segments = orbit.segments.copy()
        for i, (mode, end, outcome) in enumerate(segments.tolist()):
            if end >= 0:
                segments[i, at.SEGMENT_OUTCOME] = lifted_.taken[mode, outcome]
        drift = (
            None
            if orbit.drift is None
            else np.append(orbit.drift, np.zeros(self.carrier.wide.states - len(orbit.drift)))
        )
        return self.carrier.wide.shoot(replace(orbit, segments=segments, starts=starts, drift=drift), watched=False)

    def _carried(self, tangent: np.ndarray | None) -> np.ndarray:
        """Starts of all segments with this tangent at the first, or none, shape (N, states + q)."""
        carrier, orbit = self.carrier, self.orbit
        n, wide, own = carrier.n, carrier.wide.states, len(carrier.problem.free)
        starts = np.zeros((len(orbit), wide + len(carrier.free)))
        starts[:, :n] = orbit.starts[:, :n]
        starts[:, wide : wide + own] = orbit.starts[:, n:]
        starts[:, wide + own :] = [carrier.problem.plain.parameters[name] for name in carrier.free[own:]]
        if tangent is not None:
            starts[:, carrier.tangent] = self.shot.sensitivity[:, carrier.tangent, carrier.tangent] @ tangent
        return starts

    def displaced(self) -> Orbit:
        """The orbit moved by as much as it may be off, in the direction that its equations determine least."""
        n, orbit, change = self.carrier.n, self.orbit, self.weakest
        starts = orbit.starts.copy()
        starts[:, :n] += self.shot.sensitivity[:, :n, self.own] @ change
        return replace(
            orbit, starts=starts, phase=orbit.phase + float(change[n]), durations=orbit.durations + change[n + 1 :]
        )

    def along(self, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """What parameters do to what changes by these rows over the unknowns, and how uncertain that is."""
        parts = np.abs(rows) @ np.abs(self.change)
        return rows @ self.change, np.abs(rows) @ self.uncertain + self.accuracy * parts

    def told(self) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
        """All derivatives, and bounds of the errors that tangents and the linear solve leave."""
        found = {
            "orbit_state": self._state(),
            "period_time": tuple(part[0] for part in self.along(self._total())),
            "event_time": self._events(),
            "rates": self._rates(),
            "multiplier": self._multipliers(),
        }
        found["lyapunov_exponent"] = self._exponents(*found["period_time"], *found["multiplier"])
        return {name: one[0] for name, one in found.items()}, {name: one[1] for name, one in found.items()}

    def _durations(self, first: int, last: int) -> np.ndarray:
        """The row of the sum of the durations of some segments, shape (1, columns)."""
        row = np.zeros((1, len(self.change)))
        row[0, self.own[self.carrier.n + 1 + first : self.carrier.n + 1 + last]] = 1.0
        return row

    def _total(self) -> np.ndarray:
        return self._durations(0, len(self.orbit))

    def _clock(self, segment: int) -> tuple[float, np.ndarray]:
        """Time in the period at which a segment begins, and the row of its changes."""
        problem, orbit = self.carrier.problem, self.orbit
        time = orbit.phase + float(orbit.durations[:segment].sum())
        row = self._durations(0, segment)
        row[0, self.own[self.carrier.n]] = 1.0
        period = problem.period_at(orbit)
        if period:
            whole = float(np.floor(time / period))
            return time - whole * period, row - whole / orbit.periods * self._total()
        return time, row

    def _state(self) -> tuple[np.ndarray, np.ndarray]:
        """Of the state at the first strobe; without forcing of the first start."""
        orbit, problem, n, d = self.orbit, self.carrier.problem, self.carrier.n, self.carrier.wide.states
        strobe = problem.first_strobe(orbit)
        begins = np.append(0.0, np.cumsum(orbit.durations))
        if not problem.forced:
            return self.along(np.eye(len(self.change))[:n])
        segment = min(int(np.searchsorted(begins, strobe, side="right")) - 1, len(orbit) - 1)
        time, clock = self._clock(segment)
        length, period = strobe - begins[segment], problem.period_at(orbit) or np.inf
        starts = self.shot.sensitivity[segment, :n, :-1]
        if length <= SETTINGS.same_instant * period:
            return self.along(starts)
        # the start of a second segment is told as it comes, whatever the mode holds
        there = replace(
            orbit, segments=np.repeat(orbit.segments[[segment]] * [1, 0, 1] + [0, at.PLANE, 0], 2, axis=0),
            starts=np.repeat(self.base[segment : segment + 1], 2, axis=0), phase=time,
            durations=np.array([length, 0.0]),
        )  # fmt: skip
        arrived = self.carrier.wide.shoot(there, watched=False).sensitivity[1, :n, :-1]
        # the strobe is at a multiple of the period
        until = round((time + length) / period) / orbit.periods * self._total() - clock
        rows = arrived[:, :n] @ starts + arrived[:, [d]] @ clock + arrived[:, [d + 1]] @ until
        rows[:, d + 1 + len(orbit) :] += arrived[:, d + 3 :]
        return self.along(rows)

    def _events(self) -> tuple[np.ndarray, np.ndarray]:
        """Of the times of the events since the first strobe, in their order."""
        orbit, problem = self.orbit, self.carrier.problem
        ends, total = np.cumsum(orbit.durations), float(orbit.durations.sum())
        kinds = np.flatnonzero(orbit.segments[:, at.SEGMENT_END] >= 0)
        strobe = problem.first_strobe(orbit)
        times = (ends - strobe) % total if problem.forced else ends
        rows = np.zeros((len(kinds), len(self.change)))
        for place, segment in enumerate(kinds[np.argsort(times[kinds], kind="stable")].tolist()):
            row = self._durations(0, segment + 1)
            if problem.forced:
                period = total / orbit.periods
                row[0, self.own[self.carrier.n]] = 1.0
                whole = round((orbit.phase + ends[segment] - times[segment]) / period)
                row = row - whole / orbit.periods * self._total()
            rows[place] = row[0]
        return self.along(rows)

    def _passengers(self, shot: "Shot", which: slice) -> np.ndarray:
        """Rows of passengers at the end of the orbit over the unknowns, with their constants, (m, columns + 1)."""
        count = len(self.orbit)
        rows = shot.equations[count + which.start : count + which.stop].copy()
        rows[:, which] += np.eye(which.stop - which.start)
        return rows

    def _rates(self) -> tuple[np.ndarray, np.ndarray]:
        """Of the mean rates of the quadratures."""
        change, off = self.along(self.moved_integrals - self.means[:, np.newaxis] * self._total())
        return change / self.length, off / self.length

    def _multipliers(self) -> tuple[np.ndarray, np.ndarray]:
        """Of the multipliers, complex; zero for those that are 0 or 1 by structure."""
        carrier, problem = self.carrier, self.carrier.problem
        n, q = carrier.n, len(carrier.names)
        nothing = np.full((n, q), complex(np.nan, np.nan))
        if not (carrier.second and np.isfinite(self.shot.equations).all() and np.isfinite(self.multipliers).all()):
            return nothing, nothing
        units = 2.0 ** np.round(np.log2(problem.sizes))
        monodromy = problem.shoot(self.orbit, watched=False).monodromy
        free = np.flatnonzero(constrained_states(problem.plain)[self.orbit.segments[0, at.SEGMENT_MODE]] == 0)
        map_ = monodromy[np.ix_(free, free)]
        from scipy.linalg import eig

        values, left, right = eig(map_, left=True)
        kept = np.argsort(-np.abs(values), kind="stable")[: self.rank]
        values, left, right = values[kept], left[:, kept].conj(), right[:, kept]
        rest = np.ones(len(kept), dtype=bool)
        rest[np.argsort(np.abs(values - 1), kind="stable")[: problem.neutral.count]] = False
        changes = np.zeros((n, q), dtype=complex)
        errors = np.zeros((n, q))
        products = np.abs((left * right).sum(axis=0))
        seen: dict[int, tuple[np.ndarray, np.ndarray]] = {}
        for k in np.flatnonzero(rest).tolist():
            twin = next((j for j in seen if values[j] == values[k].conj() and values[k].imag), None)
            seen[k] = (
                (seen[twin][0].conj(), seen[twin][1]) if twin is not None else self._moved(right[:, k], free, units)
            )
        largest = max((float(np.abs(change).max()) for change, _ in seen.values()), default=0.0)
        size = float(np.linalg.norm(map_, 2))
        for k, (change, error) in seen.items():
            apart = np.abs(values - values[k])
            apart[k] = np.inf
            mixed = size * float((1 / (products * apart)).sum())
            if np.abs(values[k]) * products[k] <= self.accuracy * size:
                # rounding of the largest hides it
                changes[k], errors[k] = complex(np.nan, np.nan), np.nan
                continue
            changes[k] = left[:, k] @ change / (left[:, k] @ right[:, k])
            errors[k] = (np.abs(left[:, k]) @ error + self.accuracy * largest * mixed) / products[k]
            if changes[k].any() and self.multipliers[k].imag * values[k].imag < 0:
                changes[k] = changes[k].conj()
        return changes, errors * (1 + 1j)

    def _moved(self, tangent: np.ndarray, free: np.ndarray, units: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """What parameters do to the image of a tangent, in parts of the units, shape (free, q).

        It stays as it is, but for what keeps it on the surfaces that the first mode holds, as these turn.
        """
        image = np.zeros((len(free), len(self.carrier.names)), dtype=complex)
        error = np.zeros(image.shape)
        for part, factor in ((tangent.real, 1.0), (tangent.imag, 1j)):
            if not part.any():
                continue
            start = np.zeros(self.carrier.n)
            start[free] = part * units[free]
            shot = self.shoot(self._carried(start))
            rows = self._passengers(shot, self.carrier.tangent)[free, :-1] / units[free, np.newaxis]
            change, bound = self.along(rows)
            kept = self._whole[free] @ self._kept_on_surfaces(start) / units[free, np.newaxis]
            image += factor * (change + kept)
            error += bound + self.accuracy * np.abs(kept)
        return image, error

    @cached_property
    def _whole(self) -> np.ndarray:
        """The tangent map around the orbit, also across the surfaces that its first mode holds, shape (n, n)."""
        return self._passengers(self.shot, self.carrier.tangent)[:, self.carrier.tangent]

    def _kept_on_surfaces(self, tangent: np.ndarray) -> np.ndarray:
        """How a tangent at the start has to change with parameters to stay on the surfaces held there, (n, q)."""
        problem, orbit, n = self.carrier.problem, self.orbit, self.carrier.n
        mode, system = int(orbit.segments[0, at.SEGMENT_MODE]), problem.plain
        if not kernels_of(system).held[mode]:
            return np.zeros((n, len(self.given)))
        known = dict(zip(problem.free, orbit.starts[0, n:], strict=True))
        values = np.array([known.get(name, value) for name, value in system.parameters.items()])
        gradients, turned = slopes_of_surfaces(system, mode, orbit.phase, orbit.starts[0, :n], values)
        gradients[:, constrained_states(system)[mode] == 1] = 0.0
        moved = np.zeros((n + 1 + len(values), len(self.given)))
        moved[: n + 1] = self.change[self.own[: n + 1]]
        for column, name in enumerate(self.carrier.names):
            moved[n + 1 + list(system.parameters).index(name), column] = 1.0
        return -np.linalg.pinv(gradients) @ np.einsum("mis,sq,i->mq", turned, moved, tangent)

    def _exponents(
        self, period: np.ndarray, off: np.ndarray, multipliers: np.ndarray, errors: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Of the exponents log|mu|/T; NaN where they are infinite."""
        length = self.length
        with np.errstate(divide="ignore", invalid="ignore"):
            size = self.multipliers[:, np.newaxis]
            exponent = np.where(size == 0, np.nan, np.log(np.abs(size)) / length)
            # by structure 0, and what is left of it is rounding
            exponent[(exponent[:, 0] == exponent[:, 0]) & ~errors.any(axis=1)] = 0.0
            change = ((multipliers / size).real - exponent * period) / length
            bound = (errors.real / np.abs(size) + np.abs(exponent) * off) / length
        nothing = np.isnan(exponent) & np.ones(change.shape, dtype=bool)
        return np.where(nothing, np.nan, change), np.where(nothing, np.nan, bound)


def _error(bound: np.ndarray, difference: np.ndarray) -> np.ndarray:
    """An error from a bound, and the difference to a neighbour as far as the orbit may be off."""
    if np.iscomplexobj(difference):
        return np.asarray(bound + np.abs(difference.real) + 1j * np.abs(difference.imag))
    return np.asarray(bound + np.abs(difference))
