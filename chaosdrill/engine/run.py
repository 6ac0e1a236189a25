"""A run of one system at one set of numbers: its arrays, and the calls that continue it."""

from collections.abc import Collection
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.codegen.ahead import ONE_RUN, await_part
from chaosdrill.dataset import Outcome
from chaosdrill.engine import layout as at
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.period import check_period
from chaosdrill.engine.setup import (
    begin,
    bounds_of,
    event_tables,
    integer_settings,
    pins,
    real_settings,
    workspace,
)

if TYPE_CHECKING:
    from chaosdrill.model.system import HybridSystem


class Run:
    """State of a run, continued by ``advance``.

    Parameters
    ----------
    system : HybridSystem
        With the parameters and the initial state of this run.
    period : float
        Time between strobes; the forcing period, or any unit for systems without one.
    numerics : Numerics
        Method and tolerance.
    tangents : ndarray, optional
        Initial tangent vectors, shape (m, n), one a row.
    shifts : int
        How many of the first tangents lie along directions in which nothing ever changes.
    orthonormalise : bool
        Whether growth is taken out of the tangents and kept in ``logs``.
    deficient : collection of int
        Transitions at which rank may be lost.
    samples : int
        Samples a period.
    """

    def __init__(
        self,
        system: "HybridSystem",
        period: float,
        numerics: Numerics,
        *,
        tangents: np.ndarray | None = None,
        shifts: int = 0,
        orthonormalise: bool = True,
        deficient: Collection[int] = (),
        samples: int = 1,
    ) -> None:
        if system.time is not None and period == system.forcing_period():
            check_period(system, period)
        kernels = system.kernels
        n, q = len(system.states), len(system.quadratures)
        guards = kernels.mode_table.shape[1]
        m = 0 if tangents is None else len(tangents)
        self.system = system
        self.period = period
        self.method = numerics.method
        self.settings_i = integer_settings(
            system, numerics, numerics.order, samples=samples, orthonormalise=orthonormalise and m > 0
        )
        self.settings_f = real_settings(numerics, numerics.order, np.array([period]))[0]
        self.marks, self.transitions = event_tables(system, deficient)
        self.bounds = bounds_of(system)
        self.c = kernels.constants(system.parameters)
        self.x = np.array([system.initial[s] for s in system.state_names])
        self.sums = np.zeros((2, q))
        self.vectors = np.zeros((0, n)) if tangents is None else np.array(tangents, dtype=float)
        self.shifts = self.vectors[:shifts].copy()
        self._frame = self.vectors.copy()
        self.slots = np.arange(max(m, 1), dtype=np.int64)
        self.dead = np.zeros(max(m, 1), dtype=np.int64)
        self.logs = np.zeros(max(m, 1))
        self.carried = np.zeros(at.CARRIED_I, dtype=np.int64)
        begin(self.carried, m)
        self.carried[at.MODE] = system.mode_names.index(system.initial["mode"])
        self.carried_f = np.zeros(at.CARRIED_F)
        self.sides = np.zeros(guards, dtype=np.int64)
        self.armed = np.zeros(guards, dtype=np.int64)
        self.counts = np.zeros(len(kernels.transition_table), dtype=np.int64)
        self.grazing = np.full(len(kernels.transition_table), np.inf)
        self._before = 0.0
        self.forgotten = 0.0
        self._pin()
        self._no_samples = np.zeros((0, n + q + 1))
        self._no_events = np.zeros((0, at.EVENT_COLUMNS + 2 * n))
        self._scratch = workspace(system, m)

    @property
    def mode(self) -> str:
        """Present mode."""
        return self.system.mode_names[self.carried[at.MODE]]

    @property
    def strobes(self) -> int:
        """Periods completed."""
        return int(self.carried[at.STROBES])

    @property
    def elapsed(self) -> float:
        """Time since the start of the run."""
        return self._before + self.strobes * self.period + float(self.carried_f[at.TIME])

    @property
    def live(self) -> int:
        """Tangents that no event has removed."""
        return int(self.carried[at.LIVE])

    @property
    def steps(self) -> int:
        """Steps since the last ``forget``."""
        return int(self.carried[at.STEPS])

    @property
    def evaluations(self) -> int:
        """Evaluations of the right-hand side since the last ``forget``, those for events and samples included.

        A Taylor step counts as many as its order.
        """
        return int(self.carried[at.EVALUATIONS])

    def integrals(self) -> np.ndarray:
        """Quadratures since the start of the run, shape (q,)."""
        return self.sums[0] + self.sums[1]

    def forget(self) -> None:
        """Start all averages anew: logarithms, counts, quadratures, smallest speeds."""
        for array in (self.logs, self.counts, self.sums):
            array[:] = 0
        self.grazing[:] = np.inf
        self.carried[[at.TIES, at.STEPS, at.EVALUATIONS]] = 0
        self.forgotten = self.elapsed
        if self.dead.any():
            from chaosdrill.engine.revival import revive

            revive(self.vectors, self._frame, self.slots, self.dead, self.carried)
            self._pin()

    def continue_from(self, other: "Run") -> None:
        """Take over the state and the standing of the guards of another run of the same system, at a strobe of it."""
        self.x[:] = other.x
        self.sides[:] = other.sides
        self.armed[:] = other.armed
        taken_over = [at.MODE, at.FRESH, at.FIRED]
        self.carried[taken_over] = other.carried[taken_over]
        self.vectors[:] = self._frame
        self._pin()

    def just_took(self, transition: int) -> None:
        """Go on as directly after an event, of which the present state and mode are what came out.

        Parameters
        ----------
        transition : int
            Which one was taken.
        """
        mode = int(self.carried[at.MODE])
        guards = [j for j, event in enumerate(self.system.kernels.events[mode]) if transition in event.outcomes]
        self.carried[at.FRESH] = at.SAME_MODE if guards else at.NEW_MODE
        self.carried[at.FIRED] = guards[0] if guards else -1
        self.armed[:] = 0

    def _pin(self) -> None:
        """Drop the tangents that the present mode leaves no freedom."""
        self.vectors[:, pins(self.system)[self.carried[at.MODE]] == 1] = 0.0
        self.carried[at.RANK_CHECK] = 1

    def change_period(self, period: float) -> None:
        """Go on with strobes at another interval; at a strobe only."""
        self.settings_f[at.STEP] *= period / self.period
        self.settings_f[at.PERIOD] = period
        self._before += self.strobes * self.period
        self.carried[at.STROBES] = 0
        self.period = period

    def advance(
        self, periods: int, samples: np.ndarray | None = None, events: np.ndarray | None = None
    ) -> tuple[Outcome, bool]:
        """Go on for a number of periods, or until a buffer is full.

        Parameters
        ----------
        periods : int
            Periods from the strobe last passed.
        samples, events : ndarray, optional
            Buffers of shape (rows, n + q + 1) and (rows, 5 + 2 n); filled from the top in every call.

        Returns
        -------
        outcome : Outcome
            ``Outcome.OK``, or what ended the run.
        full : bool
            Whether a buffer was filled before the end; ``advance(0, ...)`` goes on to the same target.
        """
        await_part(ONE_RUN)
        from chaosdrill.engine.flow import flow
        from chaosdrill.engine.stepper import stepper

        if periods:
            self.settings_i[at.TARGET] = self.strobes + periods
        self.settings_i[at.RECORD] = int(samples is not None)
        self.carried[[at.SAMPLE_ROWS, at.EVENT_ROWS]] = 0
        code = flow(
            *self.system.kernels.functions,
            *stepper(self.method),
            *(self.settings_i, self.settings_f, self.system.kernels.mode_table, self.marks, self.transitions),
            *(self.c, self.bounds, self.x, self.sums, self.vectors, self.shifts, self.slots, self.dead, self.logs),
            *(self.carried, self.carried_f, self.sides, self.armed, self.counts, self.grazing),
            self._no_samples if samples is None else samples,
            self._no_events if events is None else events,
            self._scratch,
        )
        return (Outcome.OK if code in (at.DONE, at.FULL) else Outcome(code)), code == at.FULL

    def filled(self) -> tuple[int, int]:
        """Rows of samples and of events that the last call has written."""
        return int(self.carried[at.SAMPLE_ROWS]), int(self.carried[at.EVENT_ROWS])


def rate_names(system: "HybridSystem") -> tuple[str, ...]:
    """Names of the means that ``event_rates`` returns for a system."""
    suffix = "period" if system.period is not None else "time"
    drilled = ("progression_rate",) if "penetration" in system.quadratures else ()
    return (*(f"{name}_per_{suffix}" for name in ("events", "impacts", "slips")), *drilled, "closest_grazing")


def event_rates(run: Run) -> dict[str, float]:
    """Mean rates since the last ``forget``, NaN for a run of no length.

    Events, impacts and slips per forcing period (or per unit of time), the progression rate of systems that have a
    quadrature of the name ``penetration``, and the smallest normal speed met.
    """
    system = run.system
    changing = [i for i, t in enumerate(system.transitions) if not t.marks_only()]
    length = run.elapsed - run.forgotten
    units = length / run.period if system.period is not None else length
    counted = (
        sum(run.counts[i] for i in changing),
        sum(run.counts[i] for i in changing if system.transitions[i].kind == "impact"),
        sum(run.counts[i] for i in changing if system.transitions[i].kind == "slip"),
    )
    values = [float(n) / units if units > 0 else float("nan") for n in counted]
    if "penetration" in system.quadratures:
        total = run.integrals()[list(system.quadratures).index("penetration")]
        values.append(float(total) / length if length > 0 else float("nan"))
    values.append(float(min((run.grazing[i] for i in changing), default=float("inf"))))
    return dict(zip(rate_names(system), values, strict=True))
