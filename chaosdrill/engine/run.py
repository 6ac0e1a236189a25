"""A run of one system at one set of numbers: its arrays, and the calls that continue it."""

from collections.abc import Collection, Iterator
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from chaosdrill.codegen import kernels_of
from chaosdrill.dataset import Outcome
from chaosdrill.dataset.schema import names_of_rate
from chaosdrill.engine import layout as at
from chaosdrill.engine.ahead import ONE_RUN, await_part
from chaosdrill.engine.lengths import extents
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.period import check_period
from chaosdrill.engine.setup import modes_of_starts, scratch_of, settings_of, states_of, tables_of
from chaosdrill.engine.tuning import RUNS
from chaosdrill.model.regions import own_mode

if TYPE_CHECKING:
    from chaosdrill.engine.jit import Record
    from chaosdrill.model.system import HybridSystem


STANDING = ("mode", "fresh", "fired", "held", "surface", "way", "moved_by", "residual", "speed", "pull", "jerk")
BESIDE = ("scale", "span", "sides", "hardest", "extent", "doubt", "leeway", "normal")
"""Where a run keeps the sides of its guards: fields of its record, and arrays."""

_ENDLESS = {
    Outcome.STALLED: "events follow each other while no time passes",
    Outcome.EVENT_LIMIT: "events follow each other without end within one period",
    Outcome.STEP_UNDERFLOW: "steps become too small, or too many, to go on",
}
"""What is said of a run that gets nowhere."""


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
    symmetries : int
        Number of leading tangents along directions in which a shift changes nothing.
    orthonormalise : bool
        Whether growth is taken out of the tangents and kept in ``logs``.
    with_shares : bool
        Whether ``states.shares`` records the combination of earlier tangents that makes each tangent.
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
        symmetries: int = 0,
        orthonormalise: bool = True,
        with_shares: bool = False,
        deficient: Collection[int] = (),
        samples: int = 1,
    ) -> None:
        from chaosdrill.engine.structure import passes

        if period == system.forcing_period():
            check_period(system, period)
        kernels = kernels_of(system)
        start = np.array([system.initial_values])
        modes, refused = modes_of_starts(system, {}, start, np.array([own_mode(system)]))
        n, q = len(system.state_names), len(system.quadratures)
        frame = np.zeros((0, n)) if tangents is None else np.array(tangents, dtype=float)
        m = len(frame)
        self.system = system
        self.period = period
        self.method = numerics.method
        self.settings = settings_of(
            system, numerics, numerics.order, samples=samples, orthonormalise=orthonormalise and m > 0
        )
        self.tables = tables_of(system, deficient, frame[:symmetries], passes(system))
        self.states = states_of(
            system,
            kernels.constants(system.parameters)[np.newaxis],
            start,
            modes,
            np.array([period]),
            frame,
            numerics,
            with_shares=with_shares,
        )
        self._frame = frame
        self._before = 0.0
        self.forgotten = 0.0
        self._pin()
        self._no_samples = np.zeros((0, n + q + 1))
        self._no_events = np.zeros((0, at.EVENT_COLUMNS + 2 * n))
        self._scratch = scratch_of(system, m, numerics.method)
        self.refused = Outcome(int(refused[0]))
        """Why the run cannot start; ``Outcome.OK`` if it can."""

    @property
    def standing(self) -> np.void:
        """Where the run stands, a record of `chaosdrill.engine.layout.RUN`."""
        record: np.void = self.states.run[0]
        return record

    @property
    def c(self) -> np.ndarray:
        """Constants of the kernels."""
        return np.asarray(self.states.c[0])

    @property
    def x(self) -> np.ndarray:
        """Present state, shape (n,)."""
        return np.asarray(self.states.x[0])

    @property
    def sizes(self) -> np.ndarray:
        """Sizes that states have had on the way, shape (n,)."""
        return np.fmax(self.states.extent[0], self.states.scale[0, : len(self.x)])

    @property
    def extents(self) -> np.ndarray:
        """Sizes that lengths of tangents are in parts of, shape (n,)."""
        return extents(self.states.extent[0], self.states.scale[0, : len(self.x)])

    @property
    def vectors(self) -> np.ndarray:
        """Present tangents, shape (m, n), the live ones first."""
        return np.asarray(self.states.vectors[0])

    @property
    def logs(self) -> np.ndarray:
        """Logarithms of the tangents' growth since the last ``forget``, shape (m,)."""
        return np.asarray(self.states.logs[0] + np.log(self.states.grown[0]))

    @property
    def lost(self) -> np.ndarray:
        """Whether an exponent's tangent is lost, shape (m,)."""
        return np.asarray(self.states.lost[0])

    @property
    def counts(self) -> np.ndarray:
        """How often each transition was taken since the last ``forget``, shape (transitions,)."""
        return np.asarray(self.states.counts[0])

    @property
    def grazing(self) -> np.ndarray:
        """Smallest normal speed at each transition since the last ``forget``, shape (transitions,)."""
        return np.asarray(self.states.grazing[0])

    @property
    def samples(self) -> int:
        """Samples a period."""
        return int(self.settings["samples"][0])

    @property
    def mode(self) -> str:
        """Present mode."""
        return self.system.mode_names[self.standing["mode"]]

    @property
    def strobes(self) -> int:
        """Periods completed."""
        return int(self.standing["strobes"])

    @property
    def elapsed(self) -> float:
        """Time since the start of the run."""
        return self._before + self.strobes * self.period + float(self.standing["time"])

    @property
    def live(self) -> int:
        """Tangents that no event has removed."""
        return int(self.standing["live"])

    @property
    def steps(self) -> int:
        """Steps since the last ``forget``."""
        return int(self.standing["steps"])

    @property
    def evaluations(self) -> int:
        """Evaluations of the right-hand side since the last ``forget``, those for events and samples included.

        A Taylor step counts as many as its order.
        """
        return int(self.standing["evaluations"])

    def integrals(self) -> np.ndarray:
        """Quadratures since the start of the run, shape (q,)."""
        return np.asarray(self.states.sums[0, :2].sum(axis=0))

    @property
    def moved(self) -> np.ndarray:
        """How far quadratures have moved in all, up or down, since the last ``forget``, shape (q,)."""
        return np.asarray(self.states.sums[0, 2])

    @property
    def ties(self) -> int:
        """Events that coincided with another one, since the last ``forget``."""
        return int(self.standing["ties"])

    def forget(self) -> None:
        """Start all averages anew: logarithms, counts, quadratures, smallest speeds; and tangents that were lost."""
        from chaosdrill.engine.revival import forget_run

        forget_run(self.machine, 0, self._frame)
        self.forgotten = self.elapsed

    def continue_from(self, other: "Run") -> None:
        """Take over the state and the standing of the guards of another run of the same system, at a strobe of it."""
        self.x[:] = other.x
        for name in BESIDE:
            getattr(self.states, name)[:] = getattr(other.states, name)
        for name in STANDING:
            self.states.run[name] = other.states.run[name]
        self.vectors[:] = self._frame
        self._pin()

    def just_took(self, transition: int) -> None:
        """Begin directly after an event: its guard is known to have been crossed, wherever the state now lies."""
        mode = self.system.mode_names.index(self.system.transitions[transition].source[0])
        events = kernels_of(self.system).layout.events[mode]
        j = next(k for k, event in enumerate(events) if transition in event.outcomes)
        key, direction = events[j].key, events[j].direction
        run = self.states.run
        run["fresh"], run["fired"], run["surface"], run["way"] = at.AFTER, key, events[j].surface, direction
        self.states.sides[:] = 0
        run["held"], run["pull"] = 0, 0.0
        run["moved_by"] = -1 if self.system.transitions[transition].marks_only() else transition
        if self.tables.watched[run["mode"][0], key]:
            self.states.sides[0, key] = direction

    def put(self, state: np.ndarray, tangents: np.ndarray) -> None:
        """Go on from another state with other tangents; the guards are read anew where they stand otherwise."""
        self.x[:], self.vectors[:], self.states.sooner[:] = state, tangents, 0.0
        self.states.run["fresh"] = at.PUT

    def fix_step(self, step: float) -> None:
        """Let a method of fixed steps take this one."""
        self.states.run["fixed_step"] = step

    def begin_at(self, origin: float) -> None:
        """Begin at a strobe, with the clock of the field at ``origin`` there."""
        self.states.run["time"], self.states.run["origin"] = 0.0, origin

    def _pin(self) -> None:
        """Drop the tangents that the present mode leaves no freedom."""
        self.vectors[:, self.tables.constrained[self.standing["mode"]] == 1] = 0.0
        self.states.run["rank_check"] = at.CHECKED

    def change_period(self, period: float) -> None:
        """Go on with strobes at another interval; at a strobe only."""
        run = self.states.run
        self._before += self.strobes * self.period
        run["fixed_step"] *= period / self.period
        run["origin"] += run["whole"] + run["rest"]
        run["whole"] = run["rest"] = 0.0
        run["period"], run["strobes"] = period, 0
        self.period = period

    @cached_property
    def machine(self) -> "Record":
        """Arguments of the compiled functions for this run."""
        from chaosdrill.engine.stepper import machine

        functions = kernels_of(self.system).functions
        return machine(functions, self.method, self.settings, self.tables, self.states, self._scratch)

    @property
    def flow(self) -> Any:
        """What continues the run, of the signature of `chaosdrill.engine.flow.flow`."""
        return flow_of(self.settings[0], self.standing)

    def advance(
        self,
        periods: int,
        samples: np.ndarray | None = None,
        events: np.ndarray | None = None,
        *,
        instants: bool = False,
    ) -> tuple[Outcome, bool]:
        """Go on for a number of periods from the strobe last passed, or until a buffer is full.

        The buffers ``samples``, shape (rows, n + q + 1), and ``events``, shape (rows, 6 + 2 n), are filled from the top
        in every call. With ``instants`` the rows of ``samples`` hold those, in ascending order, at which they are to be
        filled: a number of strobes, and the time since that strobe.

        Returns ``Outcome.OK`` or what ended the run, and whether a buffer was filled before the end: then
        ``advance(0, ...)`` goes on to the same target.
        """
        if self.refused != Outcome.OK:
            return self.refused, False
        place = self.machine
        if periods:
            self.settings["target"] = self.strobes + periods
        self.settings["recording"] = 0 if samples is None else at.INSTANTS if instants else at.EVENLY
        self.states.run["sample_rows"] = self.states.run["event_rows"] = 0
        code = self.flow(
            place, 0, self._no_samples if samples is None else samples, self._no_events if events is None else events
        )
        return (Outcome.OK if code in (at.DONE, at.FULL) else Outcome(code)), code == at.FULL

    def stopped(self, outcome: Outcome) -> str:
        """What ended the run, and where: a term of the equations, a bound, endless switching; else empty."""
        k, system, mode = int(self.standing["blocked"]), self.system, int(self.standing["mode"])
        if outcome == Outcome.ESCAPED:
            return self._beyond()
        if k < 0 and outcome != Outcome.NONFINITE and outcome not in _ENDLESS:
            return ""
        state = ", ".join(f"{name} = {x:.6g}" for name, x in zip(system.state_names, self.x.tolist(), strict=True))
        where = f"in mode {system.mode_names[mode]!r}, time {self.elapsed:.10g}, at {state}"
        if k < 0 and outcome == Outcome.NONFINITE:
            known = np.isfinite(self.x).all() and not np.isfinite(self.vectors).all()
            what = "a tangent" if known else "an image" if system.discrete else "a number"
            return f"{what} is infinite or not a number: {where}"
        if k >= 0:
            return f"{ending_term(system, mode, k)}: {where}"
        if outcome == Outcome.STEP_UNDERFLOW and (k := lost_sum(system, mode, self.x, self.elapsed)) >= 0:
            return f"{ending_term(system, mode, k)}, {LOST}: {where}"
        if outcome == Outcome.STALLED and (found := self._facing(mode)) is not None:
            from chaosdrill.model.crossings import same_surface

            (surface, back), other = (guard.xreplace(_names(system)) for guard in found[0]), found[1]
            both = f"the motions of {system.mode_names[mode]!r} and {system.mode_names[other]!r}"
            if same_surface((surface, back)):
                return (
                    f"{both} push onto {surface} = 0 from both sides, and events lead back and forth; cd.filippov "
                    f"makes a system that slides there: {where}"
                )
            return (
                f"{both} lead to each other across {surface} = 0 and {back} = 0, infinitely often before both are "
                f"reached; what follows there is part of the model: add a mode for it: {where}"
            )
        return f"{_ENDLESS[outcome]}: {where}"

    def _beyond(self) -> str:
        """Which states have left their bounds."""
        told = []
        for name, x in zip(self.system.state_names, self.x.tolist(), strict=True):
            low, high = self.system.escapes[name]
            if not low <= x <= high:
                told.append(
                    f"{name} = {x:.6g} {'falls below' if x < low else 'exceeds'} {low if x < low else high:.6g}"
                )
        if not told:
            return ""
        return (
            f"beyond bounds at time {self.elapsed:.10g}: {'; '.join(told)}; where such a state is meant, as in a small "
            f"unit, give the system wider ones: bounds={{{told[0].split(' = ')[0]!r}: (low, high)}}"
        )

    def _facing(self, mode: int) -> "tuple[tuple[Any, Any], int] | None":
        """Another mode to which this one leads from the state, and that leads back; across what there and back."""
        kernels, n, t = kernels_of(self.system), len(self.system.state_names), self.elapsed
        c, gradient, rates = self.states.c[0], np.empty(n + 1), np.empty(n + len(self.system.quadratures))
        field, guard = kernels.functions.field, kernels.functions.guard

        def ways(mode: int) -> "Iterator[tuple[Any, int]]":
            """Surfaces on which the state is and across which the motion of a mode leads, and to which modes."""
            field(mode, t, c, self.x, rates)
            for j, event in enumerate(kernels.layout.events[mode]):
                value = guard(mode, j, t, c, self.x, gradient)
                speed = gradient[:n] @ rates[:n] + gradient[n]
                there = abs(value) <= RUNS.on_surface * (np.abs(gradient[:n]) @ self.states.scale[0, :n])
                if there and speed != 0 and event.direction * speed >= 0:
                    for k in event.outcomes:
                        yield kernels.written.events[mode][j].guard, int(kernels.transition_table[k, 0])

        for surface, other in ways(mode):
            for back, last in ways(other) if other != mode else ():
                if last == mode:
                    return (surface, back), other
        return None

    def filled(self) -> tuple[int, int]:
        """Rows of samples and of events that the last call has written."""
        return int(self.standing["sample_rows"]), int(self.standing["event_rows"])


def flow_of(settings: np.void, run: np.void) -> Any:
    """What continues a run: that of all systems, or, from strobe to strobe of a map, that of maps."""
    whole = run["period"] == 1.0 and float(run["origin"]).is_integer()
    if settings["phase"] > 0 and settings["samples"] == 1 and settings["recording"] != at.INSTANTS and whole:
        from chaosdrill.engine.iterates import iterate

        return iterate
    await_part(ONE_RUN)
    from chaosdrill.engine.flow import flow

    return flow


def ending_term(system: "HybridSystem", mode: int, k: int) -> str:
    """Which term of the equations steep operation k of a mode is, and where it ends."""
    one, names = kernels_of(system).written.steep[mode][k], _names(system)
    return f"{one.term.xreplace(names)} ends where {one.argument.xreplace(names)} = 0"


LOST = "which is lost in the rounding of its terms"


def lost_sum(system: "HybridSystem", mode: int, x: np.ndarray, elapsed: float) -> int:
    """Number of a steep operation whose argument is a sum of which rounding alone is left at a state; -1 for none."""
    names = _names(system)
    numbers = {**system.parameters, **dict(zip(system.state_names, x.tolist(), strict=True))}
    for k, one in enumerate(kernels_of(system).written.steep[mode]):
        argument = one.argument.xreplace(names)
        # of a symbol that is neither a state nor a parameter, it is the time
        given = {symbol: numbers.get(symbol.name, elapsed) for symbol in argument.free_symbols}
        terms = [term.subs(given) for term in argument.args] if argument.is_Add else []
        if terms and all(term.is_number for term in terms):
            sizes = [float(abs(term)) for term in terms]
            if float(abs(sum(terms))) <= RUNS.cancelled * sum(sizes):
                return k
    return -1


def _names(system: "HybridSystem") -> dict[Any, Any]:
    """Names of the symbols of a system, by their places in its kernels."""
    from chaosdrill.model.places import places_of

    return {place: symbol for symbol, place in places_of(system).items()}


def rate_names(system: "HybridSystem") -> tuple[str, ...]:
    """Names of the means that ``event_rates`` returns for a system."""
    suffix = "period" if system.forced else "time"
    of_quadratures = (names_of_rate(str(name))[0] for name in system.quadratures)
    return (*(f"{name}_per_{suffix}" for name in ("events", "impacts", "slips")), *of_quadratures, "closest_grazing")


def event_rates(run: Run) -> dict[str, float]:
    """Mean rates since the last ``forget``, NaN for a run of no length.

    Events, impacts and slips per forcing period (or per unit of time), the mean rate of every quadrature, and the
    smallest normal speed met.
    """
    system = run.system
    changing = [i for i, t in enumerate(system.transitions) if not t.marks_only()]
    length = run.elapsed - run.forgotten
    units = length / run.period if system.forced else length
    counted = (
        sum(run.counts[i] for i in changing),
        sum(run.counts[i] for i in changing if system.transitions[i].kind == "impact"),
        sum(run.counts[i] for i in changing if system.transitions[i].kind == "slip"),
    )
    values = [float(n) / units if units > 0 else float("nan") for n in counted]
    values += [float(total) / length if length > 0 else float("nan") for total in run.integrals()]
    values.append(float(min((run.grazing[i] for i in changing), default=float("inf"))))
    return dict(zip(rate_names(system), values, strict=True))
