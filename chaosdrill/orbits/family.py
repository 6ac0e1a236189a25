"""Orbits of one system, with the parameters that are left free: the compiled shooting problem behind plain calls."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import sympy

from chaosdrill.engine import lap as at
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.period import forcing_periods
from chaosdrill.engine.setup import scratch_of, settings_of, states_of, tables_of
from chaosdrill.model import HybridSystem
from chaosdrill.model.derive import differentiate
from chaosdrill.model.places import parameter
from chaosdrill.orbits.neutral import Neutral, neutral_of
from chaosdrill.orbits.orbit import Orbit

if TYPE_CHECKING:
    from collections.abc import Sequence

CLOCK = "forcing period"
"""A mode that no transition enters; its rates are the period and its derivatives by the free parameters."""

UNIT = 1.0
"""Longest step of systems without a period."""

STATES_TO_PARAMETERS = 0.2
"""What a change of a state by its size counts along a branch, where one of the parameter by its range counts 1."""

DEPENDENT = 1e-10
"""Singular value, as a part of the largest, below which linearised equations depend on each other."""

ROUND_OFF = 3e-13
"""Residual at which an orbit is found: what is left when all equations hold to rounding."""


@dataclass(frozen=True)
class Lap:
    """What one time around an orbit shows.

    Attributes
    ----------
    outcome : int
        DONE, or what ended a run on the way.
    residual : float
        Largest violation of an equation.
    equations : ndarray, shape (N + d + 1, columns + 1)
        Linearised equations; their constants last.
    sensitivity : ndarray, shape (N, d + q, columns + 1)
        Starts of the arcs by the reduced unknowns.
    monodromy : ndarray, shape (d, d)
        Tangent map around the orbit from its first start, saltation included.
    speeds : ndarray, shape (N,)
        Speeds at which the guards are crossed, positive in their direction; infinite where there is none.
    crossed, came : ndarray of int, shape (N,)
        Guard crossed on the way, -1 for none; the transition that its end took.
    met : ndarray, shape (N,)
        Time since the start of the arc at which that guard is crossed.
    """

    outcome: int
    residual: float
    equations: np.ndarray
    sensitivity: np.ndarray
    monodromy: np.ndarray
    speeds: np.ndarray
    crossed: np.ndarray
    came: np.ndarray
    met: np.ndarray


class Family:
    """The orbits of a system over its free parameters.

    Parameters
    ----------
    system : HybridSystem
        With the values of all parameters that are not free.
    free : sequence of str
        Parameters that orbits are looked for in; none by default.
    numerics : Numerics
        Method and tolerance.
    """

    def __init__(self, system: HybridSystem, free: "Sequence[str]" = (), numerics: Numerics | None = None) -> None:
        self.plain, self.free = system, tuple(free)
        self.numerics = numerics or Numerics()
        self.states = len(system.states)
        self.system = _with_free(system, self.free) if self.free else system
        kernels = self.system.kernels
        n = len(self.system.states)
        self.forced = system.period is not None
        settings = settings_of(self.system, self.numerics, self.numerics.order)
        settings["target"] = 2**62
        tables = tables_of(self.system, (), np.zeros((0, n)))
        self._machine = (settings, tables, tables._replace(watch=np.zeros_like(tables.watch)))
        self._clock = self.system.mode_names.index(CLOCK) if CLOCK in self.system.modes else -1
        self._scratch = scratch_of(self.system, n)
        self._states = states_of(
            self.system,
            kernels.constants(self.system.parameters)[np.newaxis],
            np.zeros((1, n)),
            np.zeros(1, dtype=np.int64),
            np.array([system.forcing_period() or UNIT]),
            np.zeros((n, n)),
            self.numerics,
        )
        # the starts of arcs are solutions, as exact as the equations are
        self._states.run["slack"] = ROUND_OFF
        self._rooms: dict[tuple[int, int], Any] = {}
        self.unit = system.forcing_period()
        """Forcing period; without one the pace of the motion, as soon as one was followed."""

    def keep_pace(self, unit: float) -> None:
        """Let a system without a period be followed in steps that go with its motion, not with the unit of time."""
        self.unit = unit
        run = self._states.run
        run["fixed_step"] *= unit / run["period"]
        run["period"] = unit

    @property
    def neutral(self) -> Neutral:
        """What the structure of the system leaves neutral on every orbit."""
        return neutral_of(self.plain)

    @property
    def period(self) -> float | None:
        """Forcing period at the present values, as far as they are not free."""
        return self.plain.forcing_period()

    def period_at(self, orbit: Orbit) -> float | None:
        """Forcing period of an orbit."""
        return float(self.periods_at(orbit.starts[:1, self.states :])[0]) if self.forced else None

    def periods_at(self, values: np.ndarray) -> np.ndarray:
        """Forcing periods at values of the free parameters, shapes (P,) and (P, q)."""
        return forcing_periods(self.plain, dict(zip(self.free, values.T, strict=True)), len(values))

    def columns(self, orbit: Orbit) -> int:
        """Number of reduced unknowns."""
        return self.states + 1 + len(orbit) + len(self.free)

    def lap(self, orbit: Orbit, watched: bool = True) -> Lap:
        """Go around once."""
        sizes, arrays, found, _, room = self._prepare(orbit)
        outcome, residual = at.lap(
            *self._kernels(), self._machine, sizes, orbit.arcs, self._plane(orbit), *arrays[:1], orbit.phase, arrays[2],
            int(watched), found, room, self._scratch,
        )  # fmt: skip
        return self._seen(orbit, outcome, residual, found)

    def solve(
        self, orbit: Orbit, conditions: np.ndarray | None = None, reach: float = 0.5
    ) -> tuple[int, Orbit, Lap, np.ndarray]:
        """Newton's method from a guess.

        Parameters
        ----------
        orbit : Orbit
        conditions : ndarray, shape (q, columns), optional
            Rows that corrections are orthogonal to; by default the free parameters stay as they are.
        reach : float
            Longest correction by one lap, in the norm of `weights`.

        Returns
        -------
        code : int
            0 if it converged, else why not: an outcome of a run, or one of `chaosdrill.engine.branch`.
        orbit : Orbit
        lap : Lap
            The last one.
        residuals : ndarray
            One a lap.
        """
        from chaosdrill.engine import branch

        sizes, arrays, found, solved, room = self._prepare(orbit)
        columns = self.columns(orbit)
        if conditions is None:
            conditions = np.eye(columns)[self.states + 1 + len(orbit) :]
        conditions = np.vstack([conditions, self._held(orbit)])
        history = np.zeros(branch.MOST_LAPS)
        code, laps = branch.newton(
            *self._kernels(), self._machine, sizes, orbit.arcs, self._plane(orbit), *arrays,
            conditions, self.weights(orbit), ROUND_OFF, reach, history, found, solved, room,
            self._scratch,
        )  # fmt: skip
        result = replace(orbit, starts=arrays[0], phase=float(arrays[1][0]), durations=arrays[2])
        return code, result, self._seen(orbit, int(code), history[max(laps - 1, 0)], found), history[:laps]

    def trace(self, orbit: Orbit, weights: np.ndarray, *arrays: Any) -> tuple[int, int]:
        """Follow a branch; the arrays are those of `chaosdrill.engine.branch.trace` from ``limits`` on."""
        from chaosdrill.engine import branch

        sizes, _, found, solved, room = self._prepare(orbit)
        conditions = np.vstack([np.zeros((1, self.columns(orbit))), self._held(orbit)])
        code, points = branch.trace(
            *self._kernels(), self._machine, sizes, orbit.arcs, self._plane(orbit), weights, *arrays, conditions,
            found, solved, room, self._scratch,
        )  # fmt: skip
        return int(code), int(points)

    def weights(self, orbit: Orbit, spans: np.ndarray | None = None) -> np.ndarray:
        """What a difference of each reduced unknown counts.

        States count by their size along the orbit, times by the period; parameters by ``spans``, the ranges in which
        they are followed, and then so much more that a step along a branch is one in them.
        """
        d, count = self.states, len(orbit)
        size = np.maximum(np.abs(orbit.starts[:, :d]).max(axis=0), 0.1)
        unit = self.period_at(orbit) or float(orbit.durations.sum())
        part = 1.0 if spans is None else STATES_TO_PARAMETERS
        values = np.ones(len(self.free)) if spans is None else 1 / spans
        return np.concatenate([part / size, np.full(1 + count, part / unit), values])

    def direction(self, orbit: Orbit, lap: Lap, weights: np.ndarray, ahead: np.ndarray | None = None) -> np.ndarray:
        """Direction of the branch through an orbit, shape (columns,), of weighted length 1; q must be 1.

        It is the null vector of the linearised equations, on the side of ``ahead``, else that of a growing parameter.
        """
        vector = self.null_space(orbit, lap, weights, 1)[0] / weights
        reference = np.eye(len(vector))[-1] if ahead is None else ahead * weights**2
        return vector if vector @ reference >= 0 else -vector

    def null_space(self, orbit: Orbit, lap: Lap, weights: np.ndarray, count: int) -> np.ndarray:
        """Directions in which orbits go on, shape (count, columns), orthonormal in weighted unknowns.

        Where every orbit is one of a family, they lead to those that differ least in what tells its members.
        """
        _, sizes, rows = np.linalg.svd(self._weighted(orbit, lap, weights))
        held = self._held(orbit)
        # an orbit of twice the period has one more where it is born
        ordinary = sizes[: len(sizes) + len(self.free) - count]
        more = min(int((ordinary <= DEPENDENT * sizes[0]).sum()), len(held))
        if not more:
            return np.asarray(rows[-count:])
        null = rows[-count - more :]
        told = held @ (null / weights).T
        return np.asarray(np.linalg.svd(told)[2][-count:] @ null)

    def regularity(self, orbit: Orbit, lap: Lap, weights: np.ndarray) -> float:
        """Smallest singular value of the weighted equations that the structure of the system does not make zero."""
        sizes = np.linalg.svd(self._weighted(orbit, lap, weights), compute_uv=False)
        kept = sizes[: len(sizes) - len(self._held(orbit))]
        return float(kept[-1])

    def _held(self, orbit: Orbit) -> np.ndarray:
        """What tells the members of a family of orbits, as rows over the reduced unknowns, shape (m, columns)."""
        neutral, d = self.neutral, self.states
        shifted_in_time = self.forced and neutral.flow and not orbit.eventless
        rows = np.zeros((len(neutral.held) + shifted_in_time, self.columns(orbit)))
        rows[: len(neutral.held), :d] = neutral.held
        rows[len(neutral.held) :, d] = 1.0
        return rows

    def _weighted(self, orbit: Orbit, lap: Lap, weights: np.ndarray) -> np.ndarray:
        return np.asarray(lap.equations[: len(orbit) + self.states + 1, :-1] / weights)

    def moved(self, orbit: Orbit, lap: Lap, change: np.ndarray) -> Orbit:
        """The orbit after a change of its reduced unknowns, to first order."""
        d = self.states
        return replace(
            orbit,
            starts=orbit.starts + lap.sensitivity[:, :, :-1] @ change,
            phase=orbit.phase + float(change[d]),
            durations=orbit.durations + change[d + 1 : d + 1 + len(orbit)],
        )

    def at(self, orbits: "Sequence[Orbit]", instants: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """States and modes of orbits of the same arcs at times since their starts.

        Parameters
        ----------
        orbits : sequence of Orbit
        instants : ndarray, shape (P, K)
            Rising along every row.

        Returns
        -------
        states : ndarray, shape (P, K, d)
        modes : ndarray of int, shape (P, K)
        """
        starts, phases, durations = _stacked(orbits)
        return self._walk(orbits[0], starts, phases, durations, instants)

    def strobes(self, orbits: "Sequence[Orbit]") -> tuple[np.ndarray, np.ndarray]:
        """States (P, k, d) at phase 0 of every forcing period, in the order in which they come, and modes (P, k).

        Of systems without a period: the states at the starts of the first arcs.
        """
        return self.strobes_along(orbits[0], *_stacked(orbits))

    def strobes_along(
        self, orbit: Orbit, starts: np.ndarray, phases: np.ndarray, durations: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """The same of P orbits with the arcs of one, from their starts (P, N, d + q), phases (P,), durations (P, N)."""
        if not self.forced:
            return self._walk(orbit, starts, phases, durations, np.zeros((len(phases), 1)))
        periods = self.periods_at(starts[:, 0, self.states :])
        instants = (-phases % periods)[:, np.newaxis] + periods[:, np.newaxis] * np.arange(orbit.periods)
        return self._walk(orbit, starts, phases, durations, instants)

    def _walk(
        self, orbit: Orbit, starts: np.ndarray, phases: np.ndarray, durations: np.ndarray, instants: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        from chaosdrill.engine.walk import walk

        sizes, _, _, _, room = self._prepare(orbit)
        states = np.zeros((*instants.shape, len(self.system.states)))
        modes = np.zeros(instants.shape, dtype=np.int64)
        walk(
            *self._kernels(), self._machine, sizes, orbit.arcs, np.ascontiguousarray(starts),
            np.ascontiguousarray(phases), np.ascontiguousarray(durations), instants, states, modes, room, self._scratch,
        )  # fmt: skip
        return states[:, :, : self.states], modes

    def _kernels(self) -> tuple[Any, ...]:
        from chaosdrill.engine.stepper import stepper

        return (*self.system.kernels.functions, *stepper(self.numerics.method))

    def _plane(self, orbit: Orbit) -> np.ndarray:
        """State and normal of the plane on which an orbit without events and period starts: across the flow."""
        d = self.states
        plane = np.zeros((2, d))
        if orbit.arcs[0, at.ARC_END] == at.PLANE:
            rate = np.zeros(len(self.system.states) + len(self.system.quadratures))
            mode = int(orbit.arcs[0, at.ARC_MODE])
            self.system.kernels.functions[3](mode, orbit.phase, self._states.c[0], orbit.starts[0].copy(), rate)
            plane[0], plane[1] = orbit.starts[0, :d], rate[:d]
        return plane

    def _prepare(self, orbit: Orbit) -> tuple[np.ndarray, tuple[np.ndarray, ...], Any, Any, Any]:
        n, d, q = len(self.system.states), self.states, len(self.free)
        count = len(orbit)
        columns = self.columns(orbit)
        held = len(self._held(orbit))
        sizes = np.array([d, q, orbit.periods, self._clock, int(self.forced)], dtype=np.int64)
        arrays = (orbit.starts.copy(), np.array([orbit.phase, 0.0]), orbit.durations.copy())
        if (count, held) not in self._rooms:
            found = (
                *(np.zeros((count + d + 1, columns + 1)), np.zeros((count, n, columns + 1)), np.zeros((n, n))),
                *(np.zeros(count), np.zeros((count, 2), dtype=np.int64), np.zeros(count)),
            )
            solved = (
                *(np.zeros((columns + held, columns + 1)), np.zeros(2 * columns + held, dtype=np.int64)),
                *(np.zeros(columns), np.zeros(columns), np.zeros(columns)),
            )
            room = (
                self._states,
                *(np.zeros((n, columns + 1)), np.zeros((n + 1, max(n, q, 1))), np.zeros((n, n))),
                *(np.zeros((n + 1, max(columns + 1, n))), np.zeros(columns + 1)),
            )
            self._rooms = {(count, held): (found, solved, room)}
        return sizes, arrays, *self._rooms[count, held]

    def _seen(self, orbit: Orbit, outcome: int, residual: float, found: Any) -> Lap:
        equations, sensitivity, monodromy, speeds, seen, met = (a.copy() for a in found)
        monodromy = monodromy[: self.states, : self.states]
        return Lap(outcome, residual, equations, sensitivity, monodromy, speeds, seen[:, 0], seen[:, 1], met)


def _stacked(orbits: "Sequence[Orbit]") -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    return tuple(np.array([getattr(o, name) for o in orbits]) for name in ("starts", "phase", "durations"))  # type: ignore[return-value]


def _with_free(system: HybridSystem, free: tuple[str, ...]) -> HybridSystem:
    """The system with free parameters among its states, and a mode that tells the period."""
    key = ("free", free)
    known = system.shared.get(key)
    if known is None:
        symbols = {name: parameter(name) for name in free}
        plain = HybridSystem(
            name=system.name, states=system.states, time=system.time, parameters=system.parameters,
            modes=system.modes, transitions=system.transitions, initial=system.initial,
            quadratures=system.quadratures, bounds=system.bounds, description=system.description, labels=system.labels,
        )  # fmt: skip
        known = plain.augmented(parameters=free)
        if system.period is not None and system.period.free_symbols & set(symbols.values()):
            rates = [system.period, *(differentiate(system.period, symbols[name]) for name in free)]
            rates += [sympy.Integer(0)] * (len(known.states) - len(rates))
            modes = {**known.modes, CLOCK: dict(zip(known.states, rates, strict=True))}
            known = HybridSystem(
                name=known.name, states=known.states, time=known.time, parameters=known.parameters, modes=modes,
                transitions=known.transitions, initial=known.initial, quadratures={}, bounds=known.bounds,
                description=known.description,
                labels={name: label for name, label in known.labels.items() if name not in known.quadratures},
            )  # fmt: skip
        system.shared[key] = known
    values = {name: value for name, value in system.parameters.items() if name not in free}
    return known.with_parameters(**values)
