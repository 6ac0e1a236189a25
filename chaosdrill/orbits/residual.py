"""The compiled residual of orbits: what it is called with, the buffers that it fills, parameters as states."""

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from chaosdrill.codegen import kernels_of
from chaosdrill.engine import shooting
from chaosdrill.engine.first_event import first_event
from chaosdrill.engine.jit import Laid
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.sample_orbit import sample_orbit
from chaosdrill.engine.setup import bounds_at_ends, scratch_of, settings_of, states_of, tables_of
from chaosdrill.engine.stepper import machine
from chaosdrill.engine.structure import passes
from chaosdrill.model import HybridSystem
from chaosdrill.orbits.orbit import Orbit
from chaosdrill.orbits.tuning import TUNING

if TYPE_CHECKING:
    from chaosdrill.model.sides import End, Side

CLOCK = "forcing period"
"""A mode that no transition enters; its rates are the period and its derivatives by the free parameters."""


class Residual:
    """The shooting residual of a system's orbits, with free parameters among the states."""

    def __init__(self, system: HybridSystem, free: tuple[str, ...], numerics: Numerics) -> None:
        self.system, self.ends = _with_free(system, free) if free else (system, [])
        self._fixed = len(system.state_names), len(free), system.forced
        self._kernels = kernels_of(self.system)
        n = len(self.system.state_names)
        settings = settings_of(self.system, numerics, numerics.order, orthonormalise=False)
        settings["target"] = 2**62
        tables = tables_of(self.system, (), np.zeros((0, n)), passes(self.system))
        # bounds go with the start, among which free parameters do not count
        tables.bounds[:, : n - len(free)] = bounds_at_ends(system, tables.fences)
        self._clock = self.system.mode_names.index(CLOCK) if CLOCK in self.system.modes else -1
        self._states = states_of(
            self.system,
            self._kernels.constants(self.system.parameters)[np.newaxis],
            np.zeros((1, n)),
            np.zeros(1, dtype=np.int64),
            np.array([system.forcing_period() or TUNING.unit]),
            np.zeros((n, n)),
            numerics,
        )
        self._slack = tables.slack
        scratch = scratch_of(self.system, n, numerics.method)
        # the second one watches no guard
        self._machines = tuple(
            machine(
                self._kernels.functions, numerics.method, settings, watching, self._states, scratch, search=first_event
            )
            for watching in (tables, tables._replace(active=np.zeros_like(tables.active)))
        )
        self._rooms: dict[int, tuple[Any, Any]] = {}

    def set_unit(self, unit: float) -> None:
        """Let a system without a period be followed in steps of this unit of time."""
        run = self._states.run
        run["fixed_step"] *= unit / run["period"]
        run["period"] = unit

    def __call__(
        self, orbit: Orbit, sizes: np.ndarray, solved: np.ndarray, plane: np.ndarray, watched: bool
    ) -> tuple[int, float, list[np.ndarray]]:
        """Outcome, residual and all that `chaosdrill.engine.shooting.shooting_residual` finds.

        Of shapes (d,), (d,) and (4 + m, d): the sizes of states; how exactly equations between states are ``solved``,
        since the starts of segments are solutions, no more exact; and the ``plane``, what the orbit begins on, and
        closes but for, whose drift is filled.
        """
        self._slack[: len(solved)] = solved
        found, room = self._room(len(orbit))
        outcome, residual = shooting.shooting_residual(
            *self._machines, self._counts(orbit), sizes, orbit.segments, plane,
            np.ascontiguousarray(orbit.starts), orbit.phase, orbit.durations, int(watched), found, room,
        )  # fmt: skip
        return outcome, residual, [one.copy() for one in found]

    def at(self, orbits: Sequence[Orbit], instants: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """States (P, K, d + q) and modes (P, K) of orbits of the same segments at times (P, K) since their starts."""
        starts, durations = np.array([o.starts for o in orbits]), np.array([o.durations for o in orbits])
        phases = np.array([o.phase for o in orbits])
        states = np.zeros((*instants.shape, len(self.system.state_names)))
        modes = np.zeros(instants.shape, dtype=np.int64)
        sample_orbit(
            *self._machines, self._counts(orbits[0]), orbits[0].segments, starts, phases, durations,
            np.ascontiguousarray(instants), states, modes,
        )  # fmt: skip
        return states, modes

    def field(self, mode: int, time: float, state: np.ndarray) -> np.ndarray:
        """Rates of the states and of the integrals."""
        rate = np.zeros(len(self.system.state_names) + len(self.system.quadratures))
        self._kernels.functions.field(mode, time, self._states.c[0], state.copy(), rate)
        return rate

    def gradient(self, mode: int, guard: int, time: float, state: np.ndarray) -> np.ndarray:
        """Derivatives of a guard by the states, and by time."""
        found = np.zeros(len(state) + 1)
        self._kernels.functions.guard(mode, guard, time, self._states.c[0], state, found)
        return found

    def jacobian(self, mode: int, time: float, state: np.ndarray) -> np.ndarray:
        """Derivatives of the rates by the states."""
        columns = np.zeros((len(state), len(state)))
        for column, direction in zip(columns, np.eye(len(state)), strict=True):
            self._kernels.functions.variation(mode, time, self._states.c[0], state.copy(), direction, column)
        return columns.T

    def _counts(self, orbit: Orbit) -> np.ndarray:
        states, free, forced = self._fixed
        return np.array([states, free, orbit.periods, self._clock, forced], dtype=np.int64)

    def _room(self, count: int) -> tuple[Any, Any]:
        """The arrays that the residual of an orbit with this number of segments fills, and its scratch."""
        if count not in self._rooms:
            n, (d, q, _) = len(self.system.state_names), self._fixed
            columns = d + 1 + count + q
            found = (
                *(np.zeros((count + d + 1, columns + 1)), np.zeros((count, n, columns + 1)), np.zeros((n, n))),
                np.zeros((count, n, n)),
                *(np.zeros(count), np.zeros(count), np.zeros((count, 2), dtype=np.int64), np.zeros(count)),
            )
            room = (
                *(np.zeros((n, columns + 1)), np.zeros((n + 1, max(n, q, 1))), np.zeros((n, n))),
                *(np.zeros((n + 1, max(columns + 1, n))), np.zeros(columns + 1)),
            )
            self._rooms = {count: (Laid(found), Laid(room))}
        return self._rooms[count]


def _with_free(system: HybridSystem, free: tuple[str, ...]) -> tuple[HybridSystem, "list[tuple[End, End]]"]:
    """The system with free parameters among its states, and a mode whose rate gives the period.

    Where it has kinks in these, it is that of the side on which they are, which ends at the values that are told.
    """
    try:
        return system.relative(("free", *free), partial(_made_with_free, system, free)), []
    except _BesideKinkError as beside:
        side, smooth = beside.side, beside.smooth
        how = ("free", *free, *map(str, (*side.heights, *side.settled)))
        ends = [side.ends(name) for name in free]
        return system.relative(how, partial(_made_with_free, smooth, free)), ends


class _BesideKinkError(Exception):
    """A system has kinks in free parameters; what it is on the side on which they are."""

    def __init__(self, side: "Side", smooth: HybridSystem) -> None:
        super().__init__(f"{smooth.name} beside a kink")
        self.side, self.smooth = side, smooth


def _made_with_free(system: HybridSystem, free: tuple[str, ...]) -> HybridSystem:
    import sympy

    from chaosdrill.model.derive import differentiate
    from chaosdrill.model.places import parameter
    from chaosdrill.model.sides import Side

    side = Side.of(system, free)
    if (smooth := side.smooth(system)) is not system:
        raise _BesideKinkError(side, smooth)
    symbols = {name: parameter(name) for name in free}
    found = system.remade(period=None, regions={}, initial=system.initial).augmented(parameters=free)
    if system.forced and system.period.free_symbols & set(symbols.values()):
        rates = [system.period, *(differentiate(system.period, symbols[name]) for name in free)]
        rates += [sympy.Integer(0)] * (len(found.states) - len(rates))
        modes = {**found.modes, CLOCK: dict(zip(found.states, rates, strict=True))}
        labels = {name: label for name, label in found.labels.items() if name not in found.quadratures}
        found = found.remade(modes=modes, initial=found.initial, quadratures={}, labels=labels)
    if (held := system.told_held) is not None:
        found.shared["held"] = held
    return found
