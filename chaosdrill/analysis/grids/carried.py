"""Attractors at every value of a parameter, and where the motion on them goes at another value: two tasks.

What is needed to go on with a motion elsewhere, its foothold, is kept as plain arrays, so that any worker can.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from hashlib import sha256
from typing import Any

import numpy as np

from chaosdrill.analysis.grids.cycles import continued
from chaosdrill.analysis.grids.matching import number_attractors
from chaosdrill.analysis.grids.measuring import Arrays, may_be_left, measure, point_columns
from chaosdrill.analysis.grids.plan import Plan
from chaosdrill.analysis.grids.points import Axis, Task
from chaosdrill.analysis.grids.visits import merge
from chaosdrill.analysis.tuning import ATTRACTORS, CYCLES, PLAN
from chaosdrill.dataset import Outcome
from chaosdrill.dataset.outcomes import MEASURED
from chaosdrill.engine.batch import Batch, Standing, alike
from chaosdrill.model.noise import seeds_of_starts

_PLACE = "at_"
"""Begins the names of what a foothold is made of."""


def footholds(batch: Batch, which: np.ndarray) -> Arrays:
    """Where some runs of a batch stand, and how their guards do."""
    standing = batch.standing(which)
    parts = {"x": batch.x[which].copy(), "mode": batch.mode[which].copy()}
    parts |= {f"run_{name}": values for name, values in standing.run.items()}
    parts |= {f"beside_{name}": values for name, values in standing.beside.items()}
    return {_PLACE + name: values for name, values in parts.items()}


def standing_at(plan: Plan, parameters: Mapping[str, np.ndarray], places: Mapping[str, np.ndarray]) -> Batch:
    """Runs that stand at these footholds."""
    parts = {name.removeprefix(_PLACE): values for name, values in places.items() if name.startswith(_PLACE)}
    run, beside = (
        {name.removeprefix(kind): values for name, values in parts.items() if name.startswith(kind)}
        for kind in ("run_", "beside_")
    )
    batch = plan.batch(parameters, parts["x"], parts["mode"])
    batch.stand(Standing(run, beside))
    batch.outcome[:] = int(Outcome.OK)
    return batch


def on_the_map(plan: Plan, parameters: Mapping[str, np.ndarray], places: Mapping[str, np.ndarray]) -> Batch:
    """Runs from these footholds over steps of the map, which keep the points that `merge` compares."""
    every = np.arange(len(places[_PLACE + "x"]))
    return continued(plan, standing_at(plan, parameters, places), every, parameters).mapped(plan, ATTRACTORS.length)


def part(arrays: Mapping[str, np.ndarray], which: Any) -> Arrays:
    """Some rows of all arrays."""
    return {name: values[which] for name, values in arrays.items()}


def joined(parts: list[Arrays]) -> Arrays:
    """Rows of all parts, one after the other."""
    return {name: np.concatenate([one[name] for one in parts]) for name in parts[0]}


@dataclass(frozen=True)
class _Values(Task):
    """What both tasks have: a plan, the values, and what is kept of an attractor."""

    plan: Plan
    axis: Axis
    keeps: tuple[str, ...]

    def parameters(self, places: np.ndarray) -> dict[str, np.ndarray]:
        """The swept parameter at some places of the axis."""
        return {self.axis.name: self.axis.values[places]}

    def kept(self) -> dict[str, tuple[str, tuple[int, ...]]]:
        """Dtype and shape of what is kept of one attractor."""
        declared = point_columns(self.plan)
        own = self.plan.system.initial
        start = np.array([[own[name] for name in self.plan.system.state_names]], dtype=float)
        one = footholds(self.plan.batch(self.parameters(np.zeros(1, int)), start, np.zeros(1, int)), np.zeros(1, int))
        return {name: declared[name] for name in self.keeps} | {
            name: (values.dtype.str, values.shape[1:]) for name, values in one.items()
        }

    @property
    def at_once(self) -> int:
        """Runs that are held in memory together."""
        return max(
            1, min(PLAN.at_once, PLAN.most_held // (8 * self.plan.window * (len(self.plan.system.state_names) + 1)))
        )


@dataclass(frozen=True)
class ShareTask(_Values):
    """All starts at every value, and the attractors to which they lead; a unit is a value."""

    starts: np.ndarray  # (S, n): initial states
    modes: np.ndarray  # int (S,): their initial modes

    @property
    def units(self) -> int:
        """Values."""
        return len(self.axis.values)

    @property
    def points_per_unit(self) -> int:
        """Starts."""
        return len(self.starts)

    def columns(self) -> dict[str, tuple[str, tuple[int, ...]]]:
        """Of every start its outcome and the attractor, from 1; of every attractor what is kept of it."""
        starts = len(self.starts)
        slots = min(ATTRACTORS.carried_most, starts)
        of_attractors = {f"of_{name}": (dtype, (slots, *shape)) for name, (dtype, shape) in self.kept().items()}
        return {"outcome": ("i1", (starts,)), "reached": ("i4", (starts,)), **of_attractors}

    def run(self, first: int, count: int) -> Arrays:
        """Results at some values."""
        values = [self._at(place) for place in range(first, first + count)]
        return {name: np.stack([one[name] for one in values]) for name in values[0]}

    def _at(self, place: int) -> Arrays:
        starts = len(self.starts)
        parts = []
        for rows in np.split(np.arange(starts), range(self.at_once, starts, self.at_once)):
            here = self._here(place, rows)
            found, batch = measure(self.plan, here, self.starts[rows], self.modes[rows])
            parts.append({name: found[name] for name in self.keeps} | footholds(batch, np.arange(len(rows))))
        found = joined(parts)
        numbers, leaders = number_attractors(found)
        if len(leaders) > 1:
            numbers, leaders = merge(
                self.plan, found, numbers, leaders, lambda plan, which: self._mapped(plan, place, leaders[which])
            )
        slots = min(ATTRACTORS.carried_most, starts)
        kept = {"outcome": found["outcome"], "reached": np.where(numbers <= slots, numbers, 0).astype("i4")}
        for name, values in found.items():
            kept[f"of_{name}"] = np.zeros((slots, *values.shape[1:]), values.dtype)
            kept[f"of_{name}"][: len(leaders)] = values[leaders[:slots]]
        return kept

    def _mapped(self, plan: Plan, place: int, rows: np.ndarray) -> Batch:
        return plan.mapped(self._here(place, rows), self.starts[rows], self.modes[rows], ATTRACTORS.length)

    def _here(self, place: int, rows: np.ndarray) -> dict[str, np.ndarray]:
        """Parameters of the runs from some starts at a value."""
        return seeds_of_starts(self.plan.system, rows, self.parameters(np.full(len(rows), place)))

    def fingerprint(self) -> dict[str, Any]:
        """Everything that determines the numbers."""
        return self.plan.fingerprint() | {
            "values": {self.axis.name: self.axis.values.tolist()},
            "starts": self.starts.tolist(),
            "modes": self.modes.tolist(),
            "keeps": list(self.keeps),
        }


@dataclass(frozen=True)
class StepTask(_Values):
    """Motions that are carried from one value to another; a unit is one of them."""

    origins: np.ndarray  # int (U,): places of the values that they come from
    targets: np.ndarray  # int (U,): places of those they are carried to
    places: Mapping[str, np.ndarray]  # their footholds, (U, ...)
    ahead: np.ndarray  # int (U,): units of the lengths by which they go on before
    beside: np.ndarray  # (U, n): how far beside their footholds they begin then, in parts of the sizes of the states

    @property
    def units(self) -> int:
        """Motions."""
        return len(self.origins)

    @property
    def points_per_unit(self) -> int:
        """One."""
        return 1

    def columns(self) -> dict[str, tuple[str, tuple[int, ...]]]:
        """What is kept of each."""
        return self.kept()

    def run(self, first: int, count: int) -> Arrays:
        """Results of some of the motions."""
        kept = {name: np.zeros((count, *shape), dtype) for name, (dtype, shape) in self.columns().items()}
        for rows in self._together(np.arange(first, first + count)):
            results, left, before = self._results(rows, self.beside[rows[0]])
            # what stands on something unstable leaves it by one state or another; by one that is neutral it does not
            for unit in np.eye(self.beside.shape[1]):
                if not (again := np.flatnonzero(left & ~self.beside[rows].any(axis=1))).size:
                    break
                other, still, _ = self._results(rows[again], CYCLES.displaced * unit)
                gone = ~still & np.isin(other["outcome"], MEASURED)
                for name, values in other.items():
                    results[name][again[gone]] = values[gone]
                left[again[gone]] = False
            results["outcome"][before.outcome != Outcome.OK] = int(Outcome.FAILED)
            for name, values in results.items():
                kept[name][rows - first] = values
        return kept

    def _together(self, rows: np.ndarray) -> list[np.ndarray]:
        """Motions that share compiled functions where they come from and where they go, not too many at once."""
        system, groups = self.plan.system, []
        for far in np.unique(self.beside[rows], axis=0):
            these = rows[(self.beside[rows] == far).all(axis=1)]
            for to in alike(system, self.parameters(self.targets[these]), len(these)):
                for of in alike(system, self.parameters(self.origins[these[to]]), len(to)):
                    group = these[to][of]
                    groups += np.split(group, range(self.at_once, len(group), self.at_once))
        return groups

    def _results(self, rows: np.ndarray, beside: np.ndarray) -> tuple[Arrays, np.ndarray, Batch]:
        """What is kept of some motions, whether they may be left at once, and the runs from which they went on."""
        before = standing_at(self.plan, self.parameters(self.origins[rows]), part(self.places, rows))
        for units in np.unique(self.ahead[rows]).tolist():
            if units:
                before.proceed(np.flatnonzero(self.ahead[rows] == units), 0, np.array([0, units]))
        here = self.parameters(self.targets[rows])
        found, batch = measure(self.plan, here, before.x.copy(), before.mode.copy(), before, beside)
        left = np.array([may_be_left(self.plan, here, found, batch, k) for k in range(len(rows))])
        return {name: found[name] for name in self.keeps} | footholds(batch, np.arange(len(rows))), left, before

    def fingerprint(self) -> dict[str, Any]:
        """Everything that determines the numbers."""
        digest = sha256()
        for name in sorted(self.places):
            digest.update(np.ascontiguousarray(self.places[name]).tobytes())
        return self.plan.fingerprint() | {
            "values": {self.axis.name: self.axis.values.tolist()},
            "origins": self.origins.tolist(),
            "targets": self.targets.tolist(),
            "ahead": self.ahead.tolist(),
            "beside": self.beside.tolist(),
            "places": digest.hexdigest(),
            "keeps": list(self.keeps),
        }
