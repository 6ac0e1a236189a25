"""Many runs of one system, each at its own parameters and from its own state."""

from collections.abc import Collection, Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.codegen.ahead import LANES, ONE_RUN, await_part
from chaosdrill.dataset import Outcome
from chaosdrill.engine import layout as at
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.period import check_period, forcing_periods, repeats
from chaosdrill.engine.setup import (
    begin,
    bounds_of,
    event_tables,
    integer_settings,
    pins,
    real_settings,
    values_of_pins,
    workspace,
)
from chaosdrill.errors import SettingsError

if TYPE_CHECKING:
    from chaosdrill.model.system import HybridSystem

_EVENT_ROWS = 64


def alike(system: "HybridSystem", parameters: Mapping[str, np.ndarray], points: int) -> Iterator[np.ndarray]:
    """Indices of the points that share compiled functions, group by group: a batch is of one such group.

    Only a parameter in an exponent makes a difference, see `chaosdrill.model.exponents`.
    """
    named = [name for name in system.exponent_parameters if name in parameters]
    groups: dict[tuple[float, ...], list[int]] = {}
    for p in range(points):
        values = (float(parameters[name][p]) for name in named)
        groups.setdefault(tuple(v if v.is_integer() else np.inf for v in values), []).append(p)
    yield from (np.array(group) for group in groups.values())


class Batch:
    """Runs of one system over a transient and then with averages, P of them at a time.

    No number of a run depends on the others. Whatever ends a run is its outcome, and its results are then missing.

    Parameters
    ----------
    system : HybridSystem
        It must have a forcing period.
    parameters : mapping of str to ndarray, shape (P,)
        Parameters that differ from the system's own. All points must share compiled functions, see `alike`.
    starts : ndarray, shape (P, n)
        Initial states.
    modes : ndarray of int, shape (P,)
        Initial modes.
    numerics : Numerics
        Method and tolerance.
    tangents : ndarray, shape (m, n), optional
        Initial tangent vectors, one a row; none by default.
    shifts : int
        How many of the first tangents lie along directions in which nothing ever changes.
    deficient : collection of int
        Transitions at which rank may be lost.
    section : set of int, optional
        Transitions before which section points are taken; at the strobe by default.
    window : int
        Section points kept.

    Attributes
    ----------
    outcome : ndarray of int, shape (P,)
        ``Outcome.OK``, or what ended the run.
    x, mode : ndarray, shapes (P, n), (P,)
        Present state and mode.
    period, length : ndarray, shape (P,)
        Forcing period (NaN where it is no positive number) and time averaged over.
    sums : ndarray, shape (P, B + 1, m)
        Sums of the tangents' logarithms at the ends of the blocks, -inf where rank was lost.
    counts, grazing : ndarray, shape (P, transitions)
        How often each transition was taken, and the smallest normal speed at it.
    drilled : ndarray, shape (P, q)
        Quadratures.
    window : ndarray, shape (P, window, n + 1)
        The last section points, state and mode, the oldest first; NaN behind the last where there were fewer.
    """

    def __init__(
        self,
        system: "HybridSystem",
        parameters: Mapping[str, np.ndarray],
        starts: np.ndarray,
        modes: np.ndarray,
        numerics: Numerics,
        *,
        tangents: np.ndarray | None = None,
        shifts: int = 0,
        deficient: Collection[int] = (),
        section: set[int] | None = None,
        window: int = 0,
    ) -> None:
        points, n = starts.shape
        if points:
            system = system.with_parameters(**{name: float(values[0]) for name, values in parameters.items()})
        kernels = system.kernels
        q, guards, kinds = len(system.quadratures), kernels.mode_table.shape[1], len(kernels.transition_table)
        frame = np.zeros((0, n)) if tangents is None else np.array(tangents, dtype=float)
        m = len(frame)
        self.system, self.method = system, numerics.method
        self._parameters = {name: np.asarray(values, dtype=float) for name, values in parameters.items()}
        self.period = forcing_periods(system, parameters, points)
        self.outcome = np.where(np.isnan(self.period), int(Outcome.FAILED), int(Outcome.OK))
        self._check_periods(parameters)
        self._settings_i = integer_settings(system, numerics, numerics.batch_order, orthonormalise=m > 0)
        self._settings_f = real_settings(numerics, numerics.batch_order, self.period)
        self._marks, self._transitions = event_tables(system, deficient)
        self._pins, self._bounds = pins(system), bounds_of(system)
        self._c = _constants(system, parameters, points)
        self.x = np.array(starts, dtype=float)
        self._integrals = np.zeros((points, 2, q))
        self._frame, self._shifts = frame, frame[:shifts].copy()
        self._vectors = np.repeat(frame[np.newaxis], points, axis=0)
        self._slots = np.repeat(np.arange(max(m, 1))[np.newaxis], points, axis=0)
        self._dead = np.zeros((points, max(m, 1)), dtype=np.int64)
        self._logs = np.zeros((points, max(m, 1)))
        self._carried = np.zeros((points, at.CARRIED_I), dtype=np.int64)
        begin(self._carried, m)
        self._carried[:, at.MODE] = modes
        self._carried_f = np.zeros((points, at.CARRIED_F))
        self._sides = np.zeros((points, guards), dtype=np.int64)
        self._armed = np.zeros((points, guards), dtype=np.int64)
        self.counts = np.zeros((points, kinds), dtype=np.int64)
        self.grazing = np.full((points, kinds), np.inf)
        self.sums = np.zeros((points, 1, m))
        self.window = np.full((points, window, n + 1), np.nan)
        self.length = np.zeros(points)
        self._section = np.zeros(0 if section is None else kinds, dtype=np.int64)
        self._section[sorted(section or ())] = 1
        self._events = np.zeros((0 if section is None else _EVENT_ROWS, at.EVENT_COLUMNS + 2 * n))
        self._spare = np.zeros((window, n + 1))
        self._progress = np.zeros((points, at.PROGRESS), dtype=np.int64)
        self._scratch = workspace(system, m)
        self._pin(np.arange(points))

    @property
    def mode(self) -> np.ndarray:
        """Present modes, shape (P,)."""
        return self._carried[:, at.MODE]

    @property
    def drilled(self) -> np.ndarray:
        """Quadratures since the averages began, shape (P, q)."""
        return self._integrals[:, 0] + self._integrals[:, 1]

    def flow(self, which: np.ndarray) -> np.ndarray:
        """Rates of the states of some runs where they stand, shape (len(which), n)."""
        rates = np.zeros((len(which), self.x.shape[1] + self._integrals.shape[2]))
        for p, row in zip(which.tolist(), rates, strict=True):
            time = float(self._carried_f[p, at.TIME])
            self.system.kernels.functions[3](int(self.mode[p]), time, self._c[p], self.x[p], row)
        return rates[:, : self.x.shape[1]]

    def run(self, transient: int, ends: np.ndarray) -> None:
        """Run all points over a transient, forget it, and average over blocks.

        Parameters
        ----------
        transient : int
            Forcing periods before the averages.
        ends : ndarray of int, shape (B + 1,)
            Ends of the blocks in periods, from 0 on.
        """
        self.proceed(np.arange(len(self.x)), transient, ends)

    def proceed(self, which: np.ndarray, transient: int, ends: np.ndarray) -> None:
        """Let some points go on from where they are, and average anew; as `run`, for the indices ``which``."""
        which = np.asarray(which, dtype=np.int64)
        points, m = len(self.x), len(self._frame)
        if self.sums.shape[1] != len(ends):
            self.sums = np.zeros((points, len(ends), m))
        stretches = np.array([transient, *np.diff(ends)], dtype=np.int64)
        if self.method == "taylor":
            self._step_in_lanes(which, stretches)
        else:
            self._step_alone(which, stretches)
        self.length[which] = int(ends[-1]) * self.period[which]
        ended = which[self.outcome[which] != Outcome.OK]
        for values in (self.sums, self.window, self.length):
            values[ended] = np.nan

    def _step_in_lanes(self, which: np.ndarray, stretches: np.ndarray) -> None:
        kernels, m = self.system.kernels, len(self._frame)
        if not len(which):
            return
        in_lanes = kernels.lanes
        await_part(LANES)
        from chaosdrill.engine.lane_flow import lane_flow
        from chaosdrill.engine.lane_setup import block, bookkeeping

        varying = np.flatnonzero((self._c != self._c[:1]).any(axis=0))
        lane_flow(
            *kernels.functions,
            *in_lanes,
            *(which, stretches, self._settings_i, kernels.mode_table, self._marks, self._transitions, self._pins),
            *(self._bounds, self._section, varying, self._shifts, self._frame),
            (
                *(self._settings_f, self._c, self.x, self._integrals, self._vectors, self._slots, self._dead),
                *(self._logs, self._carried, self._carried_f, self._sides, self._armed, self.counts, self.grazing),
                *(self._progress, self.sums, self.window, self.outcome),
            ),
            *(*bookkeeping(self.system, m), self._events[:1], self._spare, block(self.system, m, self._c[0])),
            self._scratch,
        )

    def _step_alone(self, which: np.ndarray, stretches: np.ndarray) -> None:
        await_part(ONE_RUN)
        from chaosdrill.engine.drive import drive
        from chaosdrill.engine.flow import flow
        from chaosdrill.engine.stepper import stepper

        at_strobe = not self._section.size and self.window.shape[1]
        longest = int(stretches[1:].max(initial=0)) + 3 if at_strobe else 0
        samples = np.zeros((longest, self.x.shape[1] + self._integrals.shape[2] + 1))
        drive(
            flow,
            *self.system.kernels.functions,
            *stepper(self.method),
            *(which, stretches, self._settings_i, self._settings_f),
            *(self.system.kernels.mode_table, self._marks, self._transitions, self._pins, self._c, self._bounds),
            *(self.x, self._integrals, self._shifts, self._vectors, self._frame, self._slots, self._dead, self._logs),
            *(self._carried, self._carried_f, self._sides, self._armed, self.counts, self.grazing),
            *(self.outcome, self.sums, self.window, samples, self._events, self._section, self._spare),
            self._scratch,
        )

    def continue_from(self, other: "Batch") -> None:
        """Take over state, mode and standing of the guards, point by point, of another batch of the same system.

        A point whose run there has ended keeps its own initial state. What a mode holds in a place that depends on the
        parameters, as a contact does, is put where it is held at these.
        """
        alive = np.flatnonzero(other.outcome == Outcome.OK)
        self.x[alive] = other.x[alive]
        self._sides[alive] = other._sides[alive]
        self._armed[alive] = other._armed[alive]
        for entry in (at.MODE, at.FRESH):
            self._carried[alive, entry] = other._carried[alive, entry]
        for mode in np.unique(self.mode[alive]).tolist():
            there = alive[self.mode[alive] == mode]
            here = {name: values[there] for name, values in self._parameters.items()}
            for state, value in values_of_pins(self.system, here, mode).items():
                self.x[there, state] = value
        self._vectors[alive] = self._frame
        self._pin(alive)

    def _pin(self, which: np.ndarray) -> None:
        """Drop the tangents that the modes leave no freedom."""
        self._vectors[which] = np.where(self._pins[self.mode[which]][:, np.newaxis] == 1, 0.0, self._vectors[which])
        self._carried[which, at.RANK_CHECK] = 1

    def _check_periods(self, parameters: Mapping[str, np.ndarray]) -> None:
        """Where the period is not proved, points at which the system does not repeat have failed."""
        if repeats(self.system):
            return
        for p in np.flatnonzero(self.outcome == Outcome.OK):
            try:
                here = {name: float(values[p]) for name, values in parameters.items()}
                check_period(self.system.with_parameters(**here), float(self.period[p]))
            except SettingsError:
                self.outcome[p] = Outcome.FAILED


def _constants(system: "HybridSystem", parameters: Mapping[str, np.ndarray], points: int) -> np.ndarray:
    """Constants of every point, shape (points, constants)."""
    given = np.zeros((points, len(system.parameters) + 1))
    for column, (name, value) in enumerate(system.parameters.items()):
        given[:, column] = parameters.get(name, value)
    c = np.empty((points, max(system.kernels.constant_count, 1)))
    fill = system.kernels.fill_constants
    for values, row in zip(given, c, strict=True):
        fill(values, row)
    return c
