"""What the section points of one record say, at a system's own parameters or at every value of a swept one."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import xarray as xr

from chaosdrill.analysis.base import Job
from chaosdrill.analysis.grids.points import Axis, endings, reasons_along
from chaosdrill.analysis.measures.section_points import Taken, section_points
from chaosdrill.analysis.sections import Section, find_section
from chaosdrill.dataset import Outcome, count_outcomes
from chaosdrill.dataset.build import dataset
from chaosdrill.engine.ahead import ONE_RUN, compile_ahead
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run, lost_sum
from chaosdrill.engine.setup import settings_of
from chaosdrill.errors import SettingsError
from chaosdrill.model import HybridSystem
from chaosdrill.sweep import execute
from chaosdrill.sweep.fingerprint import of_system, origin

Arrays = dict[str, Any]


@dataclass(frozen=True)
class Measure:
    """What is taken from a record."""

    function: Callable[[Taken, Any, Numerics], Arrays]
    """It can be pickled; it may tell an ``outcome`` of its own, and the ``reason`` for it, which a single record has as
    an attribute."""
    dims: Mapping[str, tuple[str, ...]]  # of each of its arrays, all of floating-point numbers
    sizes: dict[str, int]  # of their dimensions but ``state``
    coords: dict[str, Any]  # of these
    forcing: bool = False  # whether the dataset of a single record has the forcing period


@dataclass(frozen=True)
class ValueTask(ABC):
    """Runs at values of a parameter, each from the system's own initial state; a unit is a value."""

    system: HybridSystem
    given: Any
    numerics: Numerics
    parameter: str
    values: np.ndarray

    points_per_unit = 1

    @property
    def units(self) -> int:
        """Values."""
        return len(self.values)

    @property
    def total(self) -> int:
        """Values."""
        return self.units

    @abstractmethod
    def columns(self) -> dict[str, tuple[str, tuple[int, ...]]]:
        """Dtype and shape of one unit of each array."""

    @abstractmethod
    def at(self, system: HybridSystem) -> Arrays:
        """What the run of the system at a value says."""

    def run(self, first: int, count: int) -> Arrays:
        """What the runs at some values say."""
        parts = [self._at(value) for value in self.values[first : first + count].tolist()]
        columns = self.columns().items()
        return {name: np.array([part[name] for part in parts], dtype=dtype) for name, (dtype, _) in columns}

    def _at(self, value: float) -> Arrays:
        try:
            return self.at(self.system.with_parameters({self.parameter: value}))
        except SettingsError:
            # a forcing period that is no positive number, or a record that is too short for what is asked of it
            empty = {"f": np.nan, "i": 0, "U": ""}
            nothing = {name: np.full(shape, empty[dtype[0]], dtype) for name, (dtype, shape) in self.columns().items()}
            return nothing | {"outcome": np.int8(Outcome.FAILED)}

    def counts(self, arrays: Mapping[str, np.ndarray]) -> dict[str, int]:
        """Values by outcome."""
        return count_outcomes(arrays["outcome"])

    def fingerprint(self) -> dict[str, Any]:
        """Everything that determines the numbers."""
        return {
            "system": of_system(self.system),
            "settings": {name: value for name, value in vars(self.given).items() if name != "sweep"},
            "grid": {self.parameter: self.values.tolist()},
            "numerics": asdict(self.numerics),
            **origin(),
        }


ENDED = {"outcome": ("i1", ()), "ended_by": ("i2", (2,))}
"""How a run has ended, as arrays of a task."""


@dataclass(frozen=True)
class RecordTask(ValueTask):
    """Section points at values of a parameter."""

    where: Section  # at the system's own parameters
    measure: Measure

    def columns(self) -> dict[str, tuple[str, tuple[int, ...]]]:
        """Dtype and shape of one unit of each array."""
        sizes = {**self.measure.sizes, "state": len(self.system.state_names)}
        told = {name: ("f8", tuple(sizes[dim] for dim in dims)) for name, dims in self.measure.dims.items()}
        # one for each order
        letters = 240 * sizes.get("order", 1)
        return told | {"period": ("i4", ()), "reason": (f"U{letters}", ()), **ENDED}

    def at(self, system: HybridSystem) -> Arrays:
        """What the section points at a value say."""
        where = self.where.at_parameters(system, self.given, self.numerics)
        taken = section_points(where, self.given, self.given.max_period, Job(self.numerics))
        found = _measured(taken, self.measure, self.given, self.numerics)
        return {"reason": "", **found, "ended_by": ended_by(taken.run, Outcome(int(taken.outcome)))}

    def fingerprint(self) -> dict[str, Any]:
        """Everything that determines the numbers."""
        return super().fingerprint() | {"measure": self.measure.function.__name__}


def over_records(system: HybridSystem, given: Any, job: Job, measure: Measure) -> xr.Dataset:
    """What one record says, or those at every value of a ``sweep``; each is that of a run of its own.

    Raises `SettingsError` for a store or a scheduler without points that they could keep or share.
    """
    over_values = swept(system, given, job)
    where = find_section(system, given, job.numerics)
    labels = {"state": list(system.state_names), **measure.coords}
    if over_values is None:
        taken = section_points(where, given, given.max_period, job)
        found = _measured(taken, measure, given, job.numerics)
        told = {"message": taken.run.stopped(Outcome(int(found["outcome"]))), "reason": found.pop("reason", "")}
        forcing = {"forcing_period": ((), taken.where.unit)} if measure.forcing and system.forced else {}
        return dataset(
            labels | {name: (measure.dims.get(name, ()), value) for name, value in found.items()} | forcing,
            labels,
            {name: text for name, text in told.items() if text},
        )
    parameter, values = over_values
    found, said = carry_out(RecordTask(system, given, job.numerics, parameter, values, where, measure), job)
    if reason := reasons_along(parameter, values, [[one] for one in found.pop("reason").tolist()]):
        said = {**(said or {}), "reason": reason}
    over = {name: ((parameter, *measure.dims.get(name, ())), value) for name, value in found.items()}
    return dataset({parameter: values, **labels, **over}, labels, said)


def swept(system: HybridSystem, given: Any, job: Job) -> tuple[str, np.ndarray] | None:
    """The swept parameter and its values, made ready for; None for a single run.

    Raises `SettingsError` for a store or a scheduler of a single run, which only the points of a sweep could use, and
    for a method that the system cannot use at any value of a sweep.
    """
    # a map iterates without the flow
    if not system.discrete:
        compile_ahead(ONE_RUN)
    if given.sweep is not None:
        ((parameter, values),) = given.sweep.items()
        settings_of(system, job.numerics, job.numerics.order, orthonormalise=False)
        return parameter, values
    for name in ("store", "scheduler"):
        if getattr(job, name) is not None:
            raise SettingsError(f"{name} applies to the points of a sweep; give a sweep, or leave {name} out")
    return None


def carry_out(task: ValueTask, job: Job) -> tuple[Arrays, dict[str, str] | None]:
    """What the runs at all values say, and the attribute that names what has ended some of them."""
    found = execute(task, workers=job.workers, scheduler=job.scheduler, store=job.store, progress=job.progress)
    over, ended_by = Axis(task.parameter, task.values), found.pop("ended_by")
    return found, endings(task.system, found["outcome"][:, np.newaxis], ended_by[:, np.newaxis], (over,))


def ended_by(run: Run, outcome: Outcome) -> np.ndarray:
    """The mode and the number of the steep operation that has ended a run; the number is -1 for none.

    That of one whose argument is lost in rounding where a step underflows.
    """
    found: np.ndarray = run.states.ended_by[0]
    if outcome == Outcome.STEP_UNDERFLOW and found[1] < 0:
        found[1] = lost_sum(run.system, int(found[0]), run.x, run.elapsed)
    return found


def _measured(taken: Taken, measure: Measure, given: Any, numerics: Numerics) -> Arrays:
    """The arrays, with what every record of section points has."""
    return {
        "period": np.int32(taken.period),
        "outcome": np.int8(Outcome.PERIODIC if taken.period else taken.outcome),
        **measure.function(taken, given, numerics),
    }
