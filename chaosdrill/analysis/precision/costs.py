"""What accuracy costs: errors against time, over methods and tolerances."""

import gc
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import islice
from time import perf_counter, thread_time
from typing import Any

import numpy as np
import xarray as xr

from chaosdrill.analysis.base import Job
from chaosdrill.analysis.precision.advice import recommend
from chaosdrill.analysis.precision.errors import QUANTITIES, Errors, Yardstick, measure
from chaosdrill.analysis.precision.start import Place, Survey, find_place, survey
from chaosdrill.analysis.spans import Span
from chaosdrill.analysis.tuning import PRECISION
from chaosdrill.dataset import Outcome
from chaosdrill.declared import METHODS
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run
from chaosdrill.engine.structure import examine
from chaosdrill.model import HybridSystem

UNITS = 64  # parts of a duration that take the place of forcing periods


@dataclass(frozen=True)
class Cost:
    """Cost of a unit of time; NaN where the runs came to an early end."""

    outcome: Outcome
    seconds: float = float("nan")  # median over the runs
    spread: float = float("nan")  # distance of their quartiles
    steps: float = float("nan")  # mean number
    evaluations: float = float("nan")  # mean number, of the right-hand side


def measure_costs(
    system: HybridSystem,
    unit: float,
    count: int,
    most: int,
    cells: Sequence[Numerics],
    repeats: int,
    report: Callable[[], None],
) -> list[Cost]:
    """Time runs with all tangents and events; the cells take turns, so that a slow moment of the machine meets all.

    A first run of each cell over about ``counted`` units is not timed: it warms the kernels, counts the work, and tells
    how many units a run may have (``timed`` if they do not take too long), and a round how many runs. Only whole cycles
    are run.

    ``system``: its initial state is where all runs begin. ``unit``: time between strobes. ``count``: units of a cycle.
    ``most``: units that no run exceeds. ``cells``: method and tolerance of each cell. ``repeats``: rounds that are
    timed. ``report``: called after each round.
    """
    deficient = examine(system).deficient
    frame = np.eye(len(system.state_names))

    def timed(numerics: Numerics, units: int) -> tuple[Outcome, float, float, Run]:
        run = Run(system, unit, numerics, tangents=frame, deficient=deficient)
        begin, begin_computing = perf_counter(), thread_time()
        outcome, _ = run.advance(units)
        computing, seconds = thread_time() - begin_computing, perf_counter() - begin
        return outcome, seconds, computing / seconds, run

    outcomes, lengths, runs, work = [], [], [], []
    for numerics in cells:
        counted = count * max(1, min(PRECISION.counted, most) // count)
        outcome, seconds, _, run = timed(numerics, counted)
        each = max(seconds / counted, 1e-9)
        outcomes.append(outcome)
        lengths.append(count * max(1, min(PRECISION.timed, most, int(PRECISION.longest_s / each)) // count))
        runs.append(max(1, int(PRECISION.round_s / (each * lengths[-1]))))
        work.append((run.steps / counted, run.evaluations / counted))
    samples: list[list[tuple[float, float]]] = [[] for _ in cells]
    for _ in range(repeats):
        gc.collect()
        gc.disable()
        try:
            for i, numerics in enumerate(cells):
                for _ in range(runs[i] if outcomes[i] == Outcome.OK else 0):
                    outcome, seconds, share, _ = timed(numerics, lengths[i])
                    samples[i].append((seconds / lengths[i] if outcome == Outcome.OK else np.nan, share))
        finally:
            gc.enable()
        report()
    costs = []
    for outcome, sample, (steps, evaluations) in zip(outcomes, samples, work, strict=True):
        if outcome != Outcome.OK:
            costs.append(Cost(outcome))
            continue
        times, shares = np.array(sample).T
        undisturbed = shares >= min(PRECISION.undisturbed, float(np.median(shares)))
        low, middle, high = np.quantile(times[undisturbed], [0.25, 0.5, 0.75])
        costs.append(Cost(outcome, float(middle), float(high - low), steps, evaluations))
    return costs


def compare(system: HybridSystem, plan: Span, asked: Any, job: Job) -> xr.Dataset:
    """Errors and times of every method at every requested tolerance; see `work_precision`."""
    plan = plan if plan.periodic else Span(plan.unit, UNITS, plan.transient, False)
    names, values, repeats = asked.methods, asked.tolerances, asked.repeats
    counts = asked.steps or [int(np.ceil(PRECISION.steps_at_one * value**-0.25)) for value in values]
    given = {"methods": names, "tolerances": values}
    cells = [_numerics(name, tol, count) for name in names for tol, count in zip(values, counts, strict=True)]
    total = 1 + len(cells) + repeats
    done = iter(range(1, total + 1))

    def report() -> None:
        if job.progress:
            job.progress(next(done), total, None)

    found = survey(system, plan, names)
    if found.outcome != Outcome.OK:
        empty = [Errors(outcome=found.outcome)] * len(cells)
        return _dataset(system, plan, found, None, cells, empty, [Cost(found.outcome)] * len(cells), given)
    place = find_place(found, plan)
    yardstick = _yardstick(found, place, plan)
    report()
    errors = []
    for numerics in cells:
        errors.append(measure(yardstick, numerics))
        report()
    costs = measure_costs(place.system, plan.unit, place.count, plan.count, cells, repeats, report)
    return _dataset(system, plan, found, yardstick, cells, errors, costs, given)


def _numerics(name: str, tolerance: float, steps: int) -> Numerics:
    return Numerics(name, tolerance, steps if METHODS[name].fixed_step else None)


def _yardstick(found: Survey, place: Place, plan: Span) -> Yardstick:
    exponent, error = found.exponent
    most = 0
    if not place.period and exponent > 3 * error > 0:
        most = min(PRECISION.longest_horizon, int(3 * np.log(PRECISION.target / 1e-15) / (exponent * plan.unit)))
    return Yardstick(place, found, most)


def _reference_errors(yardstick: Yardstick) -> dict[str, float]:
    """What is known of the errors of the truth itself."""
    truth, period = yardstick.place.truth, yardstick.place.period
    errors = dict.fromkeys(QUANTITIES, float("nan"))
    if truth is not None:
        errors |= {name: value for name, value in truth.errors.items() if period or name != "multiplier"}
    # two methods that have nothing in common
    rates = [yardstick.rates_by(method) for method in islice(yardstick.references(), 2)]
    apart = float(abs((rates[0] - rates[1]).mean())) if len(rates) == 2 else float("nan")
    return errors | {"exponent": apart, "flow_direction": 0.0}


def _dataset(
    system: HybridSystem,
    plan: Span,
    found: Survey,
    yardstick: Yardstick | None,
    cells: list[Numerics],
    errors: list[Errors],
    costs: list[Cost],
    given: dict[str, Any],
) -> xr.Dataset:
    # costs are those of a forcing period, or of a unit of time
    length = 1.0 if plan.periodic else plan.unit
    names, tolerances = given["methods"], np.array(given["tolerances"])
    grid, shape = ("method", "tolerance"), (len(names), len(tolerances))

    def over_cells(values: Any) -> Any:
        return grid, np.array(list(values)).reshape(shape)

    exponent, standard = found.exponent if yardstick is None else yardstick.exponent()
    target = (
        np.log(PRECISION.target / tolerances) / exponent if yardstick and yardstick.most else np.full(shape[1], np.nan)
    )
    table = np.array([[e.values[q] for e in errors] for q in QUANTITIES]).reshape(len(QUANTITIES), *shape)
    truth = dict.fromkeys(QUANTITIES, float("nan")) if yardstick is None else _reference_errors(yardstick)
    start = system if yardstick is None else yardstick.place.system
    ds = xr.Dataset(
        {
            "error": (("quantity", *grid), table),
            "reference_error": ("quantity", [truth[q] for q in QUANTITIES]),
            "wall_time": over_cells(c.seconds / length for c in costs),
            "wall_time_spread": over_cells(c.spread / length for c in costs),
            "steps": over_cells(c.steps / length for c in costs),
            "evaluations": over_cells(c.evaluations / length for c in costs),
            "steps_per_period": over_cells(cell.steps or 0 for cell in cells),
            "exponent_error_spread": over_cells(e.exponent_spread for e in errors),
            "horizon": over_cells(e.horizon for e in errors),
            "horizon_expected": ("tolerance", target),
            "outcome": over_cells(np.int8(max(e.outcome, c.outcome)) for e, c in zip(errors, costs, strict=True)),
            "period": ((), np.int32(yardstick.place.period if yardstick else 0)),
            "lyapunov_exponent": ((), exponent),
            "lyapunov_error": ((), standard),
            "start": ("state", start.initial_values),
        },
        coords={
            "quantity": list(QUANTITIES),
            "method": names,
            "tolerance": tolerances,
            "state": list(system.state_names),
        },
    )
    if plan.periodic:
        ds["forcing_period"] = ((), plan.unit)
    reason = yardstick.place.reason if yardstick else found.outcome.advice
    if reason:
        ds.attrs["reference"] = f"none: {reason}"
    if yardstick:
        # what each method is held against where there is no truth of more digits
        ds.attrs["reference_methods"] = "; ".join(f"{name}: {yardstick.reference(name) or 'none'}" for name in names)
    ds.attrs["recommendation"] = recommend(ds)
    return ds
