"""One sweep behind diagrams, charts and basins: every point of a grid is measured from every seed."""

from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from chaosdrill.analysis.base import Job
from chaosdrill.analysis.grids.cycles import at_points
from chaosdrill.analysis.grids.matching import number_attractors
from chaosdrill.analysis.grids.measuring import mean_names
from chaosdrill.analysis.grids.plan import Plan, make_plan
from chaosdrill.analysis.grids.points import Axis, LineTask, PointTask, StartTask, endings
from chaosdrill.analysis.grids.visits import merge
from chaosdrill.analysis.seeds import make_seeds
from chaosdrill.analysis.starts import cells_and_listed, share_of
from chaosdrill.analysis.tuning import ATTRACTORS
from chaosdrill.dataset import count_outcomes
from chaosdrill.dataset.build import dataset
from chaosdrill.dataset.schema import names_of_rate
from chaosdrill.engine.batch import Batch
from chaosdrill.engine.period import forcing_periods
from chaosdrill.model import HybridSystem
from chaosdrill.model.regions import own_mode
from chaosdrill.progress import Progress
from chaosdrill.sweep import execute

_EXPONENTS = ("lyapunov_exponent", "lyapunov_error")


def over_parameters(
    system: HybridSystem,
    given: Any,
    job: Job,
    *,
    rows: int,
    lines: tuple[str, ...] = (),
    counts_attractors: bool = False,
) -> xr.Dataset:
    """Measure every point of a sweep.

    ``given``: with ``sweep``, ``seeds`` and ``random``. ``rows``: section points that are kept of every run. ``lines``:
    directions in which the last state is followed along the one parameter, each as a seed of its own.
    ``counts_attractors``: whether the different attractors among the seeds of a point are counted.
    """
    axes = tuple(Axis(name, values) for name, values in given.sweep.items())
    names, shape = tuple(given.sweep), tuple(len(axis.values) for axis in axes)
    chosen = make_seeds(system, given.seeds, given.random, needed=not lines)
    plan = make_plan(system, given, job.numerics, swept=names, rows=rows)
    keeps = ("period", "outcome", "ended_by", *(_EXPONENTS if plan.exponents else ()), *mean_names(plan))
    keeps += ("section",) if rows else ()
    start, mode = _own(system)
    tasks: dict[str, PointTask | LineTask] = {}
    if len(chosen.starts):
        tasks["points"] = PointTask(plan, axes, chosen.starts, chosen.modes, keeps, counts_attractors)
    if lines:
        tasks["lines"] = LineTask(plan, axes[0], lines, start, mode, keeps)
    found = _execute(tasks, job)
    counts = found.pop("attractor_count", None)
    told = endings(system, found["outcome"], found.pop("ended_by"), axes)
    dims = {"section": ("iterate", "state"), **dict.fromkeys(_EXPONENTS, ("exponent",))}
    variables: dict[str, Any] = {
        name: ((*names, "seed", *dims.get(name, ())), values.reshape(*shape, *values.shape[1:]))
        for name, values in found.items()
    }
    if counts is not None:
        variables["attractor_count"] = (names, counts.reshape(shape))
    variables["initial_state"] = (("seed", "state"), np.concatenate([chosen.starts, np.tile(start, (len(lines), 1))]))
    grid = dict(zip(names, map(np.ravel, np.meshgrid(*given.sweep.values(), indexing="ij")), strict=True))
    if system.forced:
        variables["forcing_period"] = (names, forcing_periods(system, grid, int(np.prod(shape))).reshape(shape))
    coords = {**given.sweep, "seed": list(chosen.names + lines), **_labels(system, plan)}
    if rows:
        coords["iterate"] = np.arange(rows, dtype=np.int32)
    return dataset(variables | coords, coords, told)


def over_states(system: HybridSystem, given: Any, job: Job) -> xr.Dataset:
    """Tell the attractors apart to which initial states lead: those of a ``grid``, in a list ``initial``, or both."""
    grid = given.grid or {}
    axes = tuple(Axis(name, values, of_start=True) for name, values in grid.items())
    plan = make_plan(system, given, job.numerics)
    rates = dict(zip(_rates(system), _rates(system, "attractor"), strict=True))
    start, mode = _own(system)
    keeps = ("period", "outcome", "ended_by", *_EXPONENTS, "moments", "state", *rates)
    variables: dict[str, Any] = {}
    if given.initial is None:
        dims, coords = tuple(grid), dict(grid)
        task = PointTask(plan, axes, start[np.newaxis], np.array([mode]), keeps, own_noise=True)
        shape = task.shape
    else:
        starts, modes = cells_and_listed(system, given)
        task = StartTask(plan, (), starts, modes, keeps)
        dims, shape, coords = ("run",), (task.units,), {"run": np.arange(1, task.units + 1, dtype=np.int32)}
        variables = {"initial_state": (("run", "state"), starts), "initial_mode": ("run", modes.astype(np.int8))}
    cells = {name: values[:, 0] for name, values in _execute({"points": task}, job).items()}
    told = endings(system, cells["outcome"][:, np.newaxis], cells.pop("ended_by")[:, np.newaxis], task.axes)
    numbers, leaders = number_attractors(cells)
    if len(leaders) > 1:
        here, begun, begun_modes = task.begin(leaders)

        def follow(plan: Plan, which: np.ndarray) -> Batch:
            return plan.mapped(at_points(here, which), begun[which], begun_modes[which], ATTRACTORS.length)

        numbers, leaders = merge(plan, cells, numbers, leaders, follow)
    fraction, error = share_of(np.bincount(numbers, minlength=len(leaders) + 1)[1:], task.units)
    number = "attractor_number"
    variables |= {
        "attractor": (dims, numbers.reshape(shape).astype(np.int16)),
        "outcome": (dims, cells["outcome"].reshape(shape)),
        "attractor_period": (number, cells["period"][leaders]),
        "attractor_outcome": (number, cells["outcome"][leaders]),
        "attractor_state": ((number, "state"), cells["state"][leaders]),
        "fraction": (number, fraction),
        "fraction_error": (number, error),
    }
    if system.forced:
        variables["forcing_period"] = ((), system.forcing_period())
    if plan.exponents:
        variables["attractor_exponent"] = ((number, "exponent"), cells["lyapunov_exponent"][leaders])
        variables["attractor_error"] = ((number, "exponent"), cells["lyapunov_error"][leaders])
    variables |= {name: (number, cells[of_cells][leaders]) for of_cells, name in rates.items()}
    coords |= {number: np.arange(1, len(leaders) + 1, dtype=np.int32), **_labels(system, plan)}
    return dataset(variables | coords, coords, told)


def _rates(system: HybridSystem, of: str = "") -> list[str]:
    """Names of the mean rates of quadratures and of their errors."""
    return [name for quadrature in system.quadratures for name in names_of_rate(str(quadrature), of)]


def _own(system: HybridSystem) -> tuple[np.ndarray, int]:
    """State and mode from which the system itself starts; the mode may be untold."""
    start = np.array(system.initial_values)
    return start, own_mode(system)


def _labels(system: HybridSystem, plan: Plan) -> dict[str, Any]:
    """Coordinates of states and exponents."""
    labels: dict[str, Any] = {"state": list(system.state_names)}
    if plan.exponents:
        labels["exponent"] = np.arange(1, plan.exponents + 1, dtype=np.int32)
    return labels


def _execute(tasks: dict[str, PointTask | LineTask], job: Job) -> dict[str, np.ndarray]:
    """Results of all tasks, point by point, those of lines as further seeds."""
    total, done = sum(task.total for task in tasks.values()), 0
    outcomes: Counter[str] = Counter()
    parts = []
    for name, task in tasks.items():
        found = execute(
            task,
            workers=job.workers,
            scheduler=job.scheduler,
            store=None if job.store is None else Path(job.store) / name if len(tasks) > 1 else job.store,
            progress=None if job.progress is None else _shifted(job.progress, done, total, Counter(outcomes)),
        )
        parts.append(found if name == "points" else {key: values.swapaxes(0, 1) for key, values in found.items()})
        done += task.total
        outcomes.update(count_outcomes(found["outcome"]))
    if len(parts) == 1:
        return parts[0]
    return {name: np.concatenate([part[name] for part in parts], axis=1) for name in parts[0]}


def _shifted(progress: Progress, before: int, total: int, earlier: Counter[str]) -> Progress:
    """Progress of one task among several."""
    return lambda done, _, outcomes: progress(before + done, total, dict(earlier + Counter(outcomes)))
