"""Many runs of one system, each at its own parameters and from its own state."""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from chaosdrill.codegen import kernels_of
from chaosdrill.codegen.layout import ROUNDING
from chaosdrill.dataset import Outcome
from chaosdrill.engine import layout as at
from chaosdrill.engine import setup
from chaosdrill.engine.ahead import LANES, ONE_RUN, await_part
from chaosdrill.engine.lengths import extents, lengths_by_size, sizes_of_states
from chaosdrill.engine.methods import METHODS
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.period import check_period, forcing_periods, repeats
from chaosdrill.engine.run import BESIDE, STANDING, flow_of, lost_sum
from chaosdrill.engine.scales import SMALLEST
from chaosdrill.engine.shifts import shifts_of
from chaosdrill.engine.tuning import RUNS
from chaosdrill.errors import SettingsError

if TYPE_CHECKING:
    from chaosdrill.engine.jit import Record
    from chaosdrill.model.system import HybridSystem


def alike(system: "HybridSystem", parameters: Mapping[str, np.ndarray], points: int) -> Iterator[np.ndarray]:
    """Indices of the points that share compiled functions, group by group: a batch is of one such group.

    Only a parameter in an exponent makes a difference, see `chaosdrill.model.exponents`.
    """
    named = [name for name in system.exponent_parameters if name in parameters]
    if not named:
        yield np.arange(points)
        return
    groups: dict[tuple[float, ...], list[int]] = {}
    for p in range(points):
        values = (float(parameters[name][p]) for name in named)
        groups.setdefault(tuple(v if v.is_integer() else np.inf for v in values), []).append(p)
    yield from (np.array(group) for group in groups.values())


@dataclass(frozen=True)
class Standing:
    """How the guards of P runs stand: entries of their records, and the arrays that go with them."""

    run: Mapping[str, np.ndarray]
    beside: Mapping[str, np.ndarray]

    def at(self, which: np.ndarray) -> "Standing":
        """Of some of the runs."""
        run, beside = ({name: values[which] for name, values in part.items()} for part in (self.run, self.beside))
        return Standing(run, beside)


class Returns(NamedTuple):
    """How points of a section are counted."""

    longest: float
    """Longest time in which a point may be missing. A run that meets none in a whole multiple of it, counted from its
    start, ends with ``Outcome.NO_RETURN``."""
    after: bool = False
    """Whether the states after the events of the section are kept, not those before."""


class Batch:
    """Runs of one system over a transient and then with averages, P of them at a time.

    No number of a run depends on the others. Whatever ends a run is its outcome, and its results are then missing.

    Parameters
    ----------
    system : HybridSystem
    parameters : mapping of str to ndarray, shape (P,)
        Parameters that differ from the system's own. All points must share compiled functions, see `alike`.
    starts : ndarray, shape (P, n)
        Initial states.
    modes : ndarray of int, shape (P,)
        Initial modes; `chaosdrill.model.regions.UNTOLD` stands for that in whose region the state is.
    numerics : Numerics
        Method and tolerance.
    tangents : ndarray, shape (m, n), optional
        Initial tangent vectors, one a row; none by default.
    symmetries : int
        How many of the first tangents lie along directions in which nothing ever changes.
    deficient : collection of int
        Transitions at which rank may be lost.
    section : set of int, optional
        Transitions before which section points are taken; at the strobe by default.
    window : int
        Section points kept.
    unit : float, optional
        Time between strobes of a system without a forcing period.
    returns : Returns, optional
        Let lengths count points of the section, not strobes.

    Attributes
    ----------
    outcome : ndarray of int, shape (P,)
        ``Outcome.OK``, or what ended the run.
    x, mode : ndarray, shapes (P, n), (P,)
        Present state and mode.
    period, length : ndarray, shape (P,)
        Time between strobes (NaN where it is no positive number) and time averaged over.
    times : ndarray, shape (P, B + 1)
        Ends of the blocks.
    sums : ndarray, shape (P, B + 1, m)
        Sums of the tangents' logarithms at the ends of the blocks, -inf where rank was lost.
    integrals : ndarray, shape (P, B + 1, q)
        Quadratures at the ends of the blocks.
    ends : ndarray of int, shape (B + 1,)
        Ends of the blocks in strobes, or points of the section, of the runs that went on last.
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
        symmetries: int = 0,
        deficient: Collection[int] = (),
        section: set[int] | None = None,
        window: int = 0,
        unit: float = 1.0,
        returns: Returns | None = None,
    ) -> None:
        from chaosdrill.engine.structure import passes

        points, n = starts.shape
        # the same whichever points are in the batch
        through = passes(system)
        if points:
            system = system.with_parameters(**{name: float(values[0]) for name, values in parameters.items()})
        kernels = kernels_of(system)
        q, kinds = len(system.quadratures), len(kernels.transition_table)
        frame = np.zeros((0, n)) if tangents is None else np.array(tangents, dtype=float)
        m = len(frame)
        self.system, self.method = system, numerics.method
        self._parameters = {name: np.asarray(values, dtype=float) for name, values in parameters.items()}
        forced = system.forced
        self.period = forcing_periods(system, parameters, points) if forced else np.full(points, unit)
        self.outcome = np.where(np.isnan(self.period), int(Outcome.FAILED), int(Outcome.OK))
        self._check_periods(parameters)
        modes, refused = setup.modes_of_starts(system, parameters, starts, modes)
        self.outcome = np.where(self.outcome == Outcome.OK, refused, self.outcome)
        self._settings = setup.settings_of(system, numerics, numerics.batch_order, orthonormalise=m > 0)
        self._tables = setup.tables_of(system, deficient, frame[:symmetries], through)
        c = _constants(system, parameters, points)
        self._states = setup.states_of(system, c, starts, modes, self.period, frame, numerics)
        self._frame = frame
        self.sums, self._frames = np.zeros((points, 1, m)), np.zeros((points, 1, m * (n + 1)))
        self.integrals = np.zeros((points, 1, q))
        self.ends = np.zeros(1, dtype=np.int64)
        self.window = np.full((points, window, n + 1), np.nan)
        self.length = np.zeros(points)
        self.times = np.zeros((points, 1))
        self.counts_returns = returns is not None
        cells = np.nan_to_num((1.0 if returns is None else returns.longest) / self.period, nan=1.0)
        self._progress = np.zeros((points, at.PROGRESS), dtype=np.int64)
        self._progress[:, at.CELL] = np.clip(np.ceil(cells), 1, 2**31) if self.counts_returns else 0
        self._progress[:, at.MET] = -1
        self._after = returns is not None and returns.after
        self._section = np.zeros(0 if section is None else kinds, dtype=np.int64)
        self._section[sorted(section or ())] = at.BEHIND if self._after else at.BEFORE
        rows = 0 if section is None else RUNS.return_rows if self.counts_returns else RUNS.event_rows
        self._events = np.zeros((rows, at.EVENT_COLUMNS + 2 * n))
        self._spare = np.zeros((window, n + 1))
        self._scratch = setup.scratch_of(system, m, numerics.method)
        self._quadratures = q
        self._pin(np.arange(points))

    @property
    def x(self) -> np.ndarray:
        """Present states, shape (P, n)."""
        return np.asarray(self._states.x)

    @property
    def sizes(self) -> np.ndarray:
        """Sizes that states have had on the way, shape (P, n).

        By them, what is left of a state that decays or passes through zero is distinguished from nothing.
        """
        return np.fmax(self._states.extent, self._states.scale[:, : self.x.shape[1]])

    def remember(self, sizes: np.ndarray) -> None:
        """Take over `sizes` of runs that led to where these begin."""
        self._states.extent[:] = sizes

    @property
    def mode(self) -> np.ndarray:
        """Present modes, shape (P,)."""
        return np.asarray(self._states.run["mode"])

    @property
    def ended_by(self) -> np.ndarray:
        """Mode and number of the steep operation that has ended each run, shape (P, 2); the number is -1 for none.

        That of one whose argument is lost in rounding where a step underflows.
        """
        found = self._states.ended_by
        for p in np.flatnonzero((self.outcome == Outcome.STEP_UNDERFLOW) & (found[:, 1] < 0)).tolist():
            own = self.system.with_parameters({name: float(values[p]) for name, values in self._parameters.items()})
            found[p, 1] = lost_sum(own, int(found[p, 0]), self.x[p], float(self.elapsed[p]))
        return found

    @property
    def elapsed(self) -> np.ndarray:
        """Time since the start of the runs, shape (P,): of one that has ended, until then."""
        run = self._states.run
        return np.asarray(run["strobes"] * run["period"] + run["time"])

    @property
    def steps(self) -> np.ndarray:
        """Steps since the averages began, shape (P,)."""
        return np.asarray(self._states.run["steps"])

    @property
    def moved(self) -> np.ndarray:
        """How far quadratures have moved in all, up or down, since the averages began, shape (P, q)."""
        return np.asarray(self._states.sums[:, 2])

    @property
    def counts(self) -> np.ndarray:
        """How often each transition was taken since the averages began, shape (P, transitions)."""
        return np.asarray(self._states.counts)

    @property
    def grazing(self) -> np.ndarray:
        """Smallest normal speed at each transition since the averages began, shape (P, transitions)."""
        return np.asarray(self._states.grazing)

    def flow(self, which: np.ndarray) -> np.ndarray:
        """Rates of the states of some runs where they stand, shape (len(which), n); of systems free of time."""
        return np.array([self.rates(p, self.x[p], int(self.mode[p])) for p in which.tolist()]).reshape(
            -1, self.x.shape[1]
        )

    def rates(self, p: int, state: np.ndarray, mode: int) -> np.ndarray:
        """Rates of the states at a state of run p, shape (n,); of a system that does not depend on time."""
        found = np.zeros(self.x.shape[1] + self._quadratures)
        kernels_of(self.system).functions.field(mode, 0.0, self._states.c[p], np.ascontiguousarray(state), found)
        return found[: self.x.shape[1]]

    def rounding(self, which: np.ndarray) -> np.ndarray:
        """Bounds of the rounding errors of `flow`, shape (len(which), n): those of its terms, however small it is."""
        n = self.x.shape[1]
        none = np.zeros(n + self._quadratures)
        found = np.zeros((len(which), n))
        error = kernels_of(self.system).functions.rate_error
        for row, p in enumerate(which.tolist()):
            mode = int(self.mode[p])
            first = int(self._tables.active[mode, 0])
            found[row] = [error(mode, first + i, 0.0, self._states.c[p], self.x[p], none) for i in range(n)]
        return np.where(np.isfinite(found), ROUNDING * found, 0.0)

    def rest(self, p: int) -> np.ndarray:
        """The point at rest near the present state of run p, by Newton's method; the state where there is none near."""
        n, mode, variation = self.x.shape[1], int(self.mode[p]), kernels_of(self.system).functions.variation
        x, column, jacobian, size = self.x[p].copy(), np.empty(n), np.empty((n, n)), self.sizes[p]
        size = np.where(size > SMALLEST, size, 1.0)
        for _ in range(RUNS.newton):
            for j, unit in enumerate(np.diag(size)):
                variation(mode, 0.0, self._states.c[p], x, unit, column)
                jacobian[:, j] = column / size
            rates = self.rates(p, x, mode) / size
            if not (np.isfinite(jacobian).all() and np.isfinite(rates).all()):
                break
            x = x - np.linalg.lstsq(jacobian, rates, rcond=RUNS.singular)[0] * size
        near = (np.abs(x - self.x[p]) <= RUNS.near * size).all()
        return x if near else self.x[p].copy()

    def run(self, transient: int, ends: np.ndarray) -> None:
        """Run all points over a transient of strobes, or of points of the section, forget it, and average over blocks;
        their ``ends``, shape (B + 1,), count the same, from 0 on."""
        self.proceed(np.arange(len(self.x)), transient, ends)

    def proceed(self, which: np.ndarray, transient: int, ends: np.ndarray) -> None:
        """Let some points go on from where they are, and average anew; as `run`, for the indices ``which``."""
        which = np.asarray(which, dtype=np.int64)
        points, m = len(self.x), len(self._frame)
        if self.sums.shape[1] != len(ends):
            self.sums, self._frames = (np.zeros((points, len(ends), k)) for k in (m, self._frames.shape[2]))
            self.integrals = np.zeros((points, len(ends), self._quadratures))
            self.times = np.zeros((points, len(ends)))
        stretches = np.array([transient, *np.diff(ends)], dtype=np.int64)
        self.ends = np.asarray(ends)
        if self.system.discrete:
            self._iterate(which, stretches)
        elif METHODS[self.method].lanes:
            self._step_in_lanes(which, stretches)
        elif self.counts_returns:
            self._step_to_the_section(which, stretches)
        else:
            self._step_alone(which, stretches)
        if self.counts_returns:
            self.times[which] -= self.times[which, :1]
        else:
            self.times[which] = ends * self.period[which, np.newaxis]
        self.length[which] = self.times[which, -1]
        ended = which[self.outcome[which] != Outcome.OK]
        for values in (self.sums, self.integrals, self.window, self.times, self.length):
            values[ended] = np.nan

    def sums_by_size(self, which: np.ndarray) -> np.ndarray:
        """``sums`` of some points, of lengths in parts of the sizes of the states: `lengths_by_size`."""
        sums = self.sums[which]
        if not sums.size:
            return sums
        frames = self._frames[which].reshape(*sums.shape, -1)
        seen = extents(self._states.extent[which], self._states.scale[which, : self.x.shape[1]])
        sizes = sizes_of_states(seen, shifts_of(self.system, but_of=self._parameters))
        lengths = lengths_by_size(frames[..., :-1], frames[..., -1].astype(np.int64) - 1, sizes)
        return np.asarray(sums + (lengths - lengths[:, :1]))

    def _step_in_lanes(self, which: np.ndarray, stretches: np.ndarray) -> None:
        if not len(which):
            return
        in_lanes = kernels_of(self.system).lanes
        await_part(LANES)
        from chaosdrill.engine.first_event import first_event
        from chaosdrill.engine.lane_flow import lane_flow

        c = self._states.c
        varying = np.flatnonzero((c != c[:1]).any(axis=0))
        lane_flow(
            self._machine(search=first_event),
            in_lanes,
            which,
            stretches,
            self._results(),
            self._frame,
            self._section,
            varying,
            self._room,
        )

    @cached_property
    def _room(self) -> at.LaneRoom:
        """What runs side by side work in, one stretch after the other."""
        return setup.room_of(self.system, len(self._frame), self._states.c[0], self._events[:1], self._spare)

    def _iterate(self, which: np.ndarray, stretches: np.ndarray) -> None:
        from chaosdrill.engine.iterates import iterate_runs

        row = self._events[:1]
        iterate_runs(self._machine(), which, stretches, self._results(), self._frame, self._section, row, self._spare)

    def _step_alone(self, which: np.ndarray, stretches: np.ndarray) -> None:
        await_part(ONE_RUN)
        at_strobe = not self._section.size and self.window.shape[1]
        longest = int(stretches[1:].max(initial=0)) + 3 if at_strobe else 0
        samples = np.zeros((longest, self.x.shape[1] + self._quadratures + 1))
        machine = self._machine()
        for p in which.tolist():
            self._drive(machine, p, stretches, samples)

    def _drive(self, machine: "Record", p: int, stretches: np.ndarray, samples: np.ndarray) -> None:
        """Run one point, as ``lane_flow`` does eight."""
        from chaosdrill.engine.flow import flow
        from chaosdrill.engine.lane_runs import bring_in_order, keep
        from chaosdrill.engine.revival import forget_run
        from chaosdrill.engine.uncompiled import in_python

        run, window, n = self._states.run[p], self.window[p], self.x.shape[1]
        size, total = len(window), int(stretches[1:].sum())
        self.sums[p, 0] = self.integrals[p, 0] = 0.0
        window[:] = np.nan
        self._scratch.workspace[:] = 0.0
        self._scratch.stages[:] = 0.0
        taken = done = 0
        for s, stretch in enumerate(stretches.tolist()):
            if self.outcome[p] != Outcome.OK:
                break
            done += stretch if s else 0
            kept = s > 0 and size > 0 and (self._section.size > 0 or done > total - size)
            at_strobe = kept and not self._section.size
            self._settings["target"] = run["strobes"] + stretch
            self._settings["recording"] = int(at_strobe)
            rows = samples if at_strobe else samples[:0]
            table = self._events if kept and not at_strobe else self._events[:0]
            code = at.FULL
            while code == at.FULL:
                run["sample_rows"] = run["event_rows"] = 0
                code = flow(machine, p, rows, table)
                for row in rows[: run["sample_rows"]]:
                    in_python(keep)(row, 0, n, row[-1], window, taken)
                    taken += 1
                for row in table[: run["event_rows"]]:
                    if self._section[int(row[at.EVENT_KIND])] > 0:
                        in_python(keep)(row, at.EVENT_COLUMNS, n, row[at.EVENT_MODE], window, taken)
                        taken += 1
            self.outcome[p] = code
            if s == 0:
                forget_run(machine, p, self._frame)
            self._note_averages(p, s)
        in_python(bring_in_order)(window, taken, self._spare)

    def _note_averages(self, p: int, s: int) -> None:
        """Keep what run p has summed up by the end of stretch s, and its tangents there."""
        states = self._states
        live = int(states.run["live"][p])
        kept = np.zeros((len(self._frame), self.x.shape[1] + 1))
        kept[:live, :-1], kept[:live, -1] = states.vectors[p, :live], states.exponent_of[p, :live] + 1
        self._frames[p, s] = kept.ravel()
        if s == 0:
            return
        growth = states.logs[p] + np.log(states.grown[p])
        self.sums[p, s] = np.where(states.lost[p] == 1, -np.inf, growth)[: len(self._frame)]
        self.integrals[p, s] = states.sums[p, :2].sum(axis=0)

    def _step_to_the_section(self, which: np.ndarray, stretches: np.ndarray) -> None:
        """Run points whose lengths are counted by the events of the section, as ``lane_flow`` does eight."""
        await_part(ONE_RUN)
        from chaosdrill.engine.lane_runs import bring_in_order
        from chaosdrill.engine.revival import forget_run
        from chaosdrill.engine.uncompiled import in_python

        machine = self._machine()
        self._settings["recording"] = 0
        for p in which.tolist():
            run, taken = self._states.run[p], 0
            self.sums[p, 0] = self.integrals[p, 0] = 0.0
            self.window[p] = np.nan
            for s, stretch in enumerate(stretches.tolist()):
                if self.outcome[p] == Outcome.OK:
                    taken = self._to_the_section(machine, p, stretch, taken)
                self.times[p, s] = run["strobes"] * run["period"] + run["time"]
                if s == 0:
                    forget_run(machine, p, self._frame)
                    self.window[p], taken = np.nan, 0
                self._note_averages(p, s)
            in_python(bring_in_order)(self.window[p], taken, self._spare)

    def _to_the_section(self, machine: "Record", p: int, count: int, taken: int) -> int:
        """Run on until the section was met ``count`` times; returns how many of its points were kept in all."""
        from chaosdrill.engine.flow import flow

        run, n, progress = self._states.run[p], self.x.shape[1], self._progress[p]
        cell = int(progress[at.CELL])
        first = at.EVENT_COLUMNS + (n if self._after else 0)
        none = np.zeros((0, n + self._quadratures + 1))
        left = count
        while left and self.outcome[p] == Outcome.OK:
            self._settings["target"] = target = (int(run["strobes"]) // cell + 1) * cell
            run["sample_rows"] = run["event_rows"] = 0
            code = flow(machine, p, none, self._events[: min(left, len(self._events))])
            self.outcome[p] = Outcome.OK if code == at.FULL else code
            rows = self._events[: run["event_rows"]]
            rows = rows[self._section[rows[:, at.EVENT_KIND].astype(np.int64)] > 0]
            left, taken = left - len(rows), taken + len(rows)
            if len(rows):
                progress[at.MET] = rows[-1, at.EVENT_STROBES]
            if len(rows) and (size := len(self.window[p])):
                kept = rows[-size:]
                modes = kept[:, at.EVENT_MODE]
                if self._after:
                    modes = self._tables.transitions[kept[:, at.EVENT_KIND].astype(np.int64), at.TO_MODE]
                places = np.arange(taken - len(kept), taken) % size
                self.window[p, places] = np.column_stack([kept[:, first : first + n], modes])
            if code == at.DONE and progress[at.MET] < target - cell:
                self.outcome[p] = Outcome.NO_RETURN
        if self.outcome[p] == Outcome.OK:
            # the tangents of a run that is at its goal are orthonormalised
            self._settings["target"] = run["strobes"]
            flow(machine, p, none, self._events[:0])
        return taken

    def to_strobe(self, which: np.ndarray) -> None:
        """Let runs that stand at an event go on to the next strobe."""
        machine, none = self._machine(), np.zeros((0, self.x.shape[1] + self._quadratures + 1))
        self._settings["recording"] = 0
        for p in which.tolist():
            if self.outcome[p] == Outcome.OK and self._states.run[p]["time"] > 0:
                self._settings["target"] = self._states.run[p]["strobes"] + 1
                flow = flow_of(self._settings[0], self._states.run[p])
                self.outcome[p] = flow(machine, p, none, self._events[:0])

    def standing(self, which: np.ndarray) -> "Standing":
        """How the guards of some runs stand."""
        states = self._states
        run = {name: states.run[name][which] for name in (*STANDING, "time")}
        return Standing(run, {name: getattr(states, name)[which] for name in BESIDE})

    def stand(self, as_those: "Standing") -> None:
        """Let all runs begin with their guards as others stand, at states of their own."""
        for name, values in as_those.run.items():
            self._states.run[name] = values
        for name, values in as_those.beside.items():
            getattr(self._states, name)[:] = values
        self._pin(np.arange(len(self.x)))

    def _machine(self, **search: Any) -> "Record":
        from chaosdrill.engine.stepper import machine

        functions = kernels_of(self.system).functions
        return machine(functions, self.method, self._settings, self._tables, self._states, self._scratch, **search)

    def _results(self) -> at.Results:
        found = self.sums, self._frames, self.integrals, self.times
        return at.Results(self._progress, *found, self.window, self.outcome)

    def continue_from(self, other: "Batch") -> None:
        """Take over state, mode and standing of the guards, point by point, of another batch of the same system.

        A point whose run there has ended keeps its own initial state, but for one that waited for a section in vain.
        What a mode holds in a place that depends on the parameters, as a contact does, is put where it is held at
        these; other guards may stand otherwise at these, and are read anew.
        """
        alive = np.flatnonzero(np.isin(other.outcome, (Outcome.OK, Outcome.NO_RETURN)))
        for name in ("x", *BESIDE):
            getattr(self._states, name)[alive] = getattr(other._states, name)[alive]
        for entry in STANDING:
            self._states.run[entry][alive] = other._states.run[entry][alive]
        self._states.run["fresh"][alive] = at.PUT
        # at a strobe this is no time; else the phase of the forcing stays as it is
        self._states.run["time"][alive] = other._states.run["time"][alive] * (self.period / other.period)[alive]
        for mode in np.unique(self.mode[alive]).tolist():
            there = alive[self.mode[alive] == mode]
            here = {name: values[there] for name, values in self._parameters.items()}
            for state, value in setup.values_of_constrained(self.system, here, mode).items():
                self.x[there, state] = value
        self._put(alive)
        self._states.vectors[alive], self._states.sooner[alive] = self._frame, 0.0
        self._pin(alive)

    def _put(self, which: np.ndarray) -> None:
        """Put the states onto the surfaces that their modes hold."""
        from chaosdrill.engine.revival import put_run

        holding = which[self._tables.held[self.mode[which]] > 0]
        machine = self._machine() if len(holding) else None
        for p in holding.tolist():
            put_run(machine, p)

    def _pin(self, which: np.ndarray) -> None:
        """Drop the tangents that the modes leave no freedom."""
        held = self._tables.constrained[self.mode[which]][:, np.newaxis] == 1
        self._states.vectors[which] = np.where(held, 0.0, self._states.vectors[which])
        self._states.run["rank_check"][which] = at.CHECKED

    def _check_periods(self, parameters: Mapping[str, np.ndarray]) -> None:
        """Where the period is not proved, points at which the system does not repeat have failed."""
        if not self.system.forced or repeats(self.system):
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
    c = np.empty((points, max(kernels_of(system).layout.constants, 1)))
    fill = kernels_of(system).fill_constants
    # what no parameter tells apart is computed once
    differing = points if parameters else min(points, 1)
    for values, row in zip(given[:differing], c[:differing], strict=True):
        fill(values, row)
    c[differing:] = c[:1]
    return c
