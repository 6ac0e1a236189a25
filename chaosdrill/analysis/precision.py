"""What accuracy costs: errors against time, over methods and tolerances."""

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from chaosdrill.analysis.arguments import Span
from chaosdrill.analysis.base import Job
from chaosdrill.analysis.precision_advice import recommend
from chaosdrill.analysis.precision_errors import (
    QUANTITIES,
    TARGET,
    TIGHTEST,
    Errors,
    Yardstick,
    growth,
    measure,
    true_paths,
)
from chaosdrill.analysis.precision_start import Place, Survey, find_place, survey
from chaosdrill.analysis.precision_timing import Cost, measure_costs
from chaosdrill.dataset import Outcome
from chaosdrill.declared import METHODS
from chaosdrill.engine.numerics import Numerics

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem

STEPS_AT_ONE = 20.0
"""Steps a period of a method with fixed steps: this times tolerance^(-1/4), 200 at 1e-4."""

UNITS = 64
"""Parts of a duration that take the place of forcing periods."""

_LONGEST_HORIZON = 3000


def compare(system: "HybridSystem", plan: Span, asked: Any, job: Job) -> xr.Dataset:
    """Errors and times of every method at every tolerance that is asked for; see `work_precision`."""
    plan = plan if plan.periodic else Span(plan.unit, UNITS, plan.transient, False)
    names, values, repeats = asked.methods, asked.tolerances, asked.repeats
    counts = asked.steps or [int(np.ceil(STEPS_AT_ONE * value**-0.25)) for value in values]
    given = {"methods": names, "tolerances": values}
    cells = [_numerics(name, tol, count) for name in names for tol, count in zip(values, counts, strict=True)]
    total = 1 + len(cells) + repeats
    done = iter(range(1, total + 1))

    def report() -> None:
        if job.progress:
            job.progress(next(done), total, None)

    found = survey(system, plan)
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
        most = min(_LONGEST_HORIZON, int(3 * np.log(TARGET / 1e-15) / (exponent * plan.unit)))
    starts, paths = true_paths(found, plan.unit, most) if most else ([], np.empty(0))
    return Yardstick(place, found, growth(found, plan.unit, replace(found.numerics, tolerance=TIGHTEST)), starts, paths)


def _reference_errors(yardstick: Yardstick) -> dict[str, float]:
    """What is known of the errors of the truth itself."""
    truth, period = yardstick.place.truth, yardstick.place.period
    errors = dict.fromkeys(QUANTITIES, float("nan"))
    if truth is not None:
        errors |= {name: value for name, value in truth.errors.items() if period or name != "multiplier"}
    apart = growth(yardstick.found, yardstick.place.unit, yardstick.found.numerics) - yardstick.rates
    return errors | {"exponent": float(abs(apart.mean())), "flow_direction": 0.0}


def _dataset(
    system: "HybridSystem",
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
    target = np.log(TARGET / tolerances) / exponent if yardstick and yardstick.starts else np.full(shape[1], np.nan)
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
            "start": ("state", [start.initial[name] for name in system.state_names]),
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
    ds.attrs["recommendation"] = recommend(ds)
    return ds
