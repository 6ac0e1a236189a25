"""What accuracy costs: errors against time, over methods and tolerances."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from chaosdrill.analysis.arguments import Progress, Span, real, settings, span, whole
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
from chaosdrill.analysis.registry import FIXED_STEP, METHODS
from chaosdrill.dataset import Outcome, label
from chaosdrill.engine.numerics import Numerics
from chaosdrill.errors import SettingsError

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem

TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14)
STEPS_AT_ONE = 20.0
"""Steps a period of a method with fixed steps: this times tolerance^(-1/4), 200 at 1e-4."""

UNITS = 64
"""Parts of a duration that take the place of forcing periods."""

_LONGEST_HORIZON = 3000


def work_precision(
    system: "HybridSystem",
    *,
    periods: int | None = None,
    duration: float | None = None,
    transient: float = 0,
    methods: Sequence[str] | None = None,
    tolerances: Sequence[float] | None = None,
    steps: Sequence[int] | None = None,
    repeats: int = 5,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Error of what matters against time, steps and evaluations, for every method and tolerance.

    After the transient the run looks for a cycle. If it has settled on one, the methods are compared over that cycle;
    else over one of the surveyed periods with the most kinds of events. The truth about this stretch comes
    from 60-digit arithmetic: extrapolation for the arcs (Bulirsch and Stoer 1966, doi:10.1007/BF02165234), Newton's
    method for the events, differences of the flow for the tangents. It shares no formula with the methods.

    Parameters
    ----------
    system : HybridSystem
        System with its parameters and initial state.
    periods, duration : int or float
        Forcing periods to survey, or time for systems that have none (64 parts of it then take the place of periods):
        the statistical error of the exponent is that of a run of this length, and the restarts are taken from it.
    transient : int or float, default 0
        Periods (or time) to run before anything is measured.
    methods : sequence of str, optional
        Default: all there are.
    tolerances : sequence of float, optional
        Default 1e-4, 1e-6, ..., 1e-14.
    steps : sequence of int, optional
        Steps a period for methods with fixed steps, one for each tolerance. Default 20 tolerance^(-1/4): with order 4
        their error then falls as the tolerance does.
    repeats : int, default 5
        Rounds in which all cells are timed in turn; medians are kept.
    progress : callable, optional
        Called with (done, total, None).

    Returns
    -------
    xarray.Dataset
        ``error`` (quantity, method, tolerance), ``reference_error`` (quantity); ``wall_time``, ``wall_time_spread``,
        ``steps``, ``evaluations``, ``steps_per_period``, ``horizon``, ``exponent_error_spread`` and ``outcome``
        (method, tolerance); ``horizon_expected`` (tolerance), ``period``, ``lyapunov_exponent``, ``lyapunov_error``,
        ``start`` (state). The attribute ``recommendation`` says in words what follows.

        Quantities: ``strobe``, the strobe point of the cycle, or the state after one period; ``event_time``, in parts
        of the period, infinite where events differ; ``tangent``, the tangent map; ``multiplier``, its eigenvalues on a
        cycle; ``flow_direction``, the identity by which tangents map F at the start to F at the end; ``exponent``, the
        numerical part of the leading exponent's error, from restarts at the same states. NaN where a quantity has no
        meaning or no truth. As xarray's ``sel`` has keywords ``method`` and ``tolerance`` of its own, select with a
        mapping: ``ds["error"].sel({"quantity": "multiplier", "method": "taylor"})``.

    Raises
    ------
    SettingsError
        An argument that cannot be used.
    """
    given = settings(dict(locals()))
    plan = span(system, periods, duration, transient, units=UNITS)
    plan = plan if plan.periodic else Span(plan.unit, UNITS, plan.transient, False)
    names = _methods(methods)
    values = _tolerances(tolerances)
    counts = _steps(steps, values)
    repeats = whole("repeats", repeats, 1)
    given |= {"methods": names, "tolerances": values}
    cells = [_numerics(name, tol, count) for name in names for tol, count in zip(values, counts, strict=True)]
    total = 1 + len(cells) + repeats
    done = iter(range(1, total + 1))

    def report() -> None:
        if progress:
            progress(next(done), total, None)

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


def _methods(methods: Any) -> list[str]:
    if methods is None:
        return list(METHODS)
    listed = _listed(methods)
    if (
        not listed
        or any(not isinstance(name, str) or name not in METHODS for name in listed)
        or len(set(listed)) != len(listed)
    ):
        raise SettingsError(f"methods is {methods!r}; it must be a list of different ones of {list(METHODS)}")
    return listed


def _tolerances(tolerances: Any) -> list[float]:
    if tolerances is None:
        return list(TOLERANCES)
    listed = [real(value) for value in _listed(tolerances)]
    if not listed or not all(1e-16 <= value <= 1e-2 for value in listed) or len(set(listed)) != len(listed):
        raise SettingsError(
            f"tolerances is {tolerances!r}; it must be a list of different numbers between 1e-16 and 1e-2"
        )
    return listed


def _steps(steps: Any, tolerances: list[float]) -> list[int]:
    if steps is None:
        return [int(np.ceil(STEPS_AT_ONE * value**-0.25)) for value in tolerances]
    listed = _listed(steps)
    if len(listed) != len(tolerances):
        raise SettingsError(
            f"steps is {steps!r}; it must be a list of {len(tolerances)} counts, one for each tolerance"
        )
    return [whole("steps", value, 4) for value in listed]


def _listed(values: Any) -> list[Any]:
    """The entries of a list, a tuple or an array; none of what is no such thing."""
    return list(values) if isinstance(values, Collection) and not isinstance(values, str | bytes | Mapping) else []


def _numerics(name: str, tolerance: float, steps: int) -> Numerics:
    return Numerics(name, tolerance, steps if name in FIXED_STEP else None)


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
            "state_name": ("state", list(system.state_names)),
        },
    )
    if plan.periodic:
        ds["forcing_period"] = ((), plan.unit)
    ds = label(ds, "work-precision", system=system, settings=given)
    reason = yardstick.place.reason if yardstick else found.outcome.advice
    if reason:
        ds.attrs["reference"] = f"none: {reason}"
    ds.attrs["recommendation"] = recommend(ds)
    return ds
