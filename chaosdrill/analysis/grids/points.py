"""Points of a grid, of a list of starts, or of a line: tasks that any worker can do a part of."""

import re
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from chaosdrill.analysis.grids.matching import KNOWN_BY, count_attractors, number_attractors
from chaosdrill.analysis.grids.measuring import Arrays, beside_unstable, may_be_left, measure, point_columns
from chaosdrill.analysis.grids.plan import Plan
from chaosdrill.analysis.grids.visits import merge
from chaosdrill.analysis.tuning import ATTRACTORS, PLAN
from chaosdrill.dataset import Outcome, count_outcomes
from chaosdrill.dataset.outcomes import MEASURED
from chaosdrill.engine.batch import Batch
from chaosdrill.engine.run import LOST, ending_term
from chaosdrill.model import HybridSystem
from chaosdrill.model.noise import seeds_of_starts


@dataclass(frozen=True)
class Axis:
    """Values of a swept parameter, or of a state from which the runs start."""

    name: str
    values: np.ndarray
    of_start: bool = False


class Task(ABC):
    """What tasks of points have in common; a unit is a part of them that is computed together."""

    @property
    @abstractmethod
    def units(self) -> int:
        """How many there are."""

    @property
    @abstractmethod
    def points_per_unit(self) -> int:
        """Points of each."""

    @property
    def total(self) -> int:
        """Points in all."""
        return self.units * self.points_per_unit

    def counts(self, arrays: Mapping[str, np.ndarray]) -> dict[str, int]:
        """Points by outcome."""
        return count_outcomes(arrays["outcome"])


@dataclass(frozen=True)
class PointTask(Task):
    """All points of a grid, each with every seed; a unit is a point with its seeds."""

    plan: Plan  # how a point is measured
    axes: tuple[Axis, ...]  # the grid; the last axis runs fastest
    starts: np.ndarray  # (S, n): initial states of the seeds
    modes: np.ndarray  # int (S,): their initial modes
    keeps: tuple[str, ...]  # arrays that are kept of every point
    counts_attractors: bool = False  # whether the different attractors among the seeds of a point are counted
    own_noise: bool = False  # whether points are starts, each with noise of its own

    @property
    def shape(self) -> tuple[int, ...]:
        """Lengths of the axes."""
        return tuple(len(axis.values) for axis in self.axes)

    @property
    def units(self) -> int:
        """Points of the grid."""
        return int(np.prod(self.shape, dtype=np.int64))

    @property
    def points_per_unit(self) -> int:
        """Seeds."""
        return len(self.starts)

    def columns(self) -> dict[str, tuple[str, tuple[int, ...]]]:
        """Dtype and shape of one unit of each array."""
        declared = point_columns(self.plan)
        kept = {name: (dtype, (self.points_per_unit, *shape)) for name, (dtype, shape) in declared.items()}
        columns = {name: kept[name] for name in self.keeps}
        return columns | ({"attractor_count": ("i2", ())} if self.counts_attractors else {})

    def run(self, first: int, count: int) -> Arrays:
        """Results of some points of the grid with all their seeds."""
        held = 8 * self.plan.window * (len(self.plan.system.state_names) + 1)
        step = max(1, min(PLAN.at_once, PLAN.most_held // held) // self.points_per_unit)
        parts = [self._run(begin, min(step, first + count - begin)) for begin in range(first, first + count, step)]
        return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}

    def begin(self, units: np.ndarray) -> tuple[dict[str, np.ndarray], np.ndarray, np.ndarray]:
        """Parameters, initial states and modes of some points of the grid, with every seed."""
        seeds, names = len(self.starts), self.plan.system.state_names
        places = np.unravel_index(np.repeat(units, seeds), self.shape)
        starts, modes = np.tile(self.starts, (len(units), 1)), np.tile(self.modes, len(units))
        parameters: dict[str, np.ndarray] = {}
        for axis, index in zip(self.axes, places, strict=True):
            if axis.of_start:
                starts[:, names.index(axis.name)] = axis.values[index]
            else:
                parameters[axis.name] = axis.values[index]
        if self.own_noise:
            parameters = seeds_of_starts(self.plan.system, np.repeat(units, seeds), parameters)
        return parameters, starts, modes

    def _run(self, first: int, count: int) -> Arrays:
        seeds = len(self.starts)
        found, _ = measure(self.plan, *self.begin(np.arange(first, first + count)))
        found = {name: values.reshape(count, seeds, *values.shape[1:]) for name, values in found.items()}
        kept = {name: found[name] for name in self.keeps}
        if self.counts_attractors:
            counts = count_attractors(found)
            for unit in np.flatnonzero(counts > 1).tolist():
                counts[unit] = self._told_apart(first + unit, {name: found[name][unit] for name in KNOWN_BY})
            kept["attractor_count"] = counts.astype("i2")
        return kept

    def _told_apart(self, unit: int, seeds: Arrays) -> int:
        """Attractors among the seeds of a point of the grid that seem to be on several."""
        numbers, leaders = number_attractors(seeds)
        parameters, starts, modes = self.begin(np.array([unit]))

        def begin(plan: Plan, which: np.ndarray) -> Batch:
            here = {name: values[leaders[which]] for name, values in parameters.items()}
            return plan.mapped(here, starts[leaders[which]], modes[leaders[which]], ATTRACTORS.length)

        return len(merge(self.plan, seeds, numbers, leaders, begin)[1])

    def fingerprint(self) -> dict[str, Any]:
        """Everything that determines the numbers."""
        return self.plan.fingerprint() | {
            "grid": {axis.name: axis.values.tolist() for axis in self.axes},
            "seeds": self.starts.tolist(),
            "modes": self.modes.tolist(),
            "keeps": list(self.keeps),
        }


@dataclass(frozen=True)
class StartTask(PointTask):
    """Runs from many initial states, without a grid; a unit is one of them."""

    @property
    def units(self) -> int:
        """Initial states."""
        return len(self.starts)

    @property
    def points_per_unit(self) -> int:
        """One."""
        return 1

    def begin(self, units: np.ndarray) -> tuple[dict[str, np.ndarray], np.ndarray, np.ndarray]:
        """No parameters but seeds of noise, and the initial states and modes of some of the runs."""
        return seeds_of_starts(self.plan.system, units), self.starts[units], self.modes[units]

    def _run(self, first: int, count: int) -> Arrays:
        found, _ = measure(self.plan, *self.begin(np.arange(first, first + count)))
        return {name: found[name][:, np.newaxis] for name in self.keeps}


@dataclass(frozen=True)
class LineTask(Task):
    """Lines of points, forward or backward along a parameter; a unit is a whole line.

    Where a run ends early, as one that escapes, the next point starts from the line's own initial state.
    """

    plan: Plan  # how a point is measured
    axis: Axis  # the swept parameter
    directions: tuple[str, ...]  # ``"forward"`` or ``"backward"``, for each line
    start: np.ndarray  # (n,): initial state of all lines
    mode: int  # their initial mode
    keeps: tuple[str, ...]  # arrays that are kept of every point

    @property
    def units(self) -> int:
        """Lines."""
        return len(self.directions)

    @property
    def points_per_unit(self) -> int:
        """Points of a line."""
        return len(self.axis.values)

    def columns(self) -> dict[str, tuple[str, tuple[int, ...]]]:
        """Dtype and shape of one line of each array, in the order of the values."""
        declared = point_columns(self.plan)
        return {name: (declared[name][0], (self.points_per_unit, *declared[name][1])) for name in self.keeps}

    def run(self, first: int, count: int) -> Arrays:
        """Results of some lines."""
        lines = [self._line(direction) for direction in self.directions[first : first + count]]
        return {name: np.stack([line[name] for line in lines]) for name in self.keeps}

    def _line(self, direction: str) -> Arrays:
        points = self.points_per_unit
        kept = {name: np.zeros(shape, dtype) for name, (dtype, shape) in self.columns().items()}
        before: Batch | None = None
        for index in range(points) if direction == "forward" else range(points - 1, -1, -1):
            parameters = {self.axis.name: self.axis.values[[index]]}
            start = (self.start[np.newaxis], np.array([self.mode]))
            found, batch = measure(self.plan, parameters, *start, before)
            if before is not None and may_be_left(self.plan, parameters, found, batch):
                other = measure(self.plan, parameters, *start, before, beside_unstable(len(self.start)))
                # a run that comes to an early end says nothing of the motion that was followed
                found, batch = other if np.isin(other[0]["outcome"], MEASURED).all() else (found, batch)
            before = batch
            for name in self.keeps:
                kept[name][index] = found[name][0]
        return kept

    def fingerprint(self) -> dict[str, Any]:
        """Everything that determines the numbers."""
        return self.plan.fingerprint() | {
            "line": {self.axis.name: self.axis.values.tolist()},
            "directions": list(self.directions),
            "start": self.start.tolist(),
            "mode": self.mode,
            "keeps": list(self.keeps),
        }


def reasons_along(name: str, values: np.ndarray, reasons: Sequence[Sequence[str]]) -> str:
    """The attribute ``reason`` of a sweep: each of those at all values once, with the number of these and the first.

    Those that differ by numbers alone are one.
    """
    where: dict[str, list[tuple[str, float]]] = {}
    for value, those in zip(values.tolist(), reasons, strict=True):
        for reason in filter(None, those):
            where.setdefault(re.sub(r"\d[\d.e+-]*", "", reason), []).append((reason, value))
    told = []
    for (reason, first), *others in where.values():
        count = 1 + len(others)
        place = f" (at {count} of {len(values)} values, the first {name} = {first:.6g})"
        told.append(reason + place * (count < len(values)))
    return "; ".join(told)


def endings(
    system: HybridSystem, outcomes: np.ndarray, ended_by: np.ndarray, axes: tuple[Axis, ...]
) -> dict[str, str] | None:
    """The attribute ``message``: which terms have ended runs, how many, and where the first of these is.

    ``outcomes`` are those of all points with their seeds, shape (points, seeds), and ``ended_by`` the mode
    and the number of the operation that ended each, shape (points, seeds, 2); without axes a point is a run.
    """
    shape, in_exponents = tuple(len(axis.values) for axis in axes), system.exponent_parameters
    ended: dict[tuple[Any, ...], list[dict[str, float]]] = {}
    named = np.isin(outcomes, (Outcome.SINGULAR, Outcome.STEP_UNDERFLOW)) & (ended_by[..., 1] >= 0)
    for point, seed in np.argwhere(named).tolist():
        index = np.unravel_index(point, shape) if axes else ()
        here = {axis.name: float(axis.values[i]) for axis, i in zip(axes, index, strict=True)} or {"run": point + 1}
        # at other exponents another term may have this number
        own = (here[name] for name in in_exponents if name in here)
        lost = bool(outcomes[point, seed] == Outcome.STEP_UNDERFLOW)
        ended.setdefault((lost, *ended_by[point, seed].tolist(), *own), []).append(here)
    told = []
    swept = [axis.name for axis in axes if not axis.of_start]
    for (lost, mode, k, *_), places in ended.items():
        term = ending_term(system.with_parameters({name: places[0][name] for name in swept}), mode, k)
        first = ", ".join(f"{name} = {value:.6g}" for name, value in places[0].items())
        how = f", {LOST}" if lost else ""
        told.append(
            f"{term}{how}, in mode {system.mode_names[mode]!r}: {len(places)} of {outcomes.size} runs, first {first}"
        )
    return {"message": "; ".join(told)} if told else None
