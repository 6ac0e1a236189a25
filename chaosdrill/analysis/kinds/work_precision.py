"""Cost of accuracy: errors against time, over methods and tolerances."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from chaosdrill.analysis.arguments import Method
from chaosdrill.analysis.base import Dataset, HybridSystem, Job, Record, analysis
from chaosdrill.dataset.references import SPECTRA
from chaosdrill.dataset.schema import STATES, axis, clocked, forcing, need, outcome, table
from chaosdrill.declared import METHODS
from chaosdrill.errors import SettingsError
from chaosdrill.settings import Faults, ListOf, Number, Whole, setting, told

TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14)

_CELL = "method tolerance"

VARIABLES = table(
    axis("quantity", "quantity", "str", "quantity", "Quantity to which the error belongs.", True),
    axis("method", "method", "str", "method", "Numerical method.", True),
    axis("tolerance", "tolerance", "f8", "tolerance", "Requested; see also steps_per_period.", True),
    *STATES,
    need("error", f"quantity {_CELL}", "f8", "error", "NaN if not measured, infinite if events differ."),
    need("reference_error", "quantity", "f8", "error of the reference", "Difference between two computations of it."),
    clocked("wall_time", _CELL, "time a period", "Median over the runs; a unit of time if not forced."),
    clocked("wall_time_spread", _CELL, "spread of the time a period", "Distance of the quartiles of the runs."),
    need("steps", _CELL, "f8", "steps a period", "Mean; events end steps. A unit of time if not forced."),
    need("evaluations", _CELL, "f8", "evaluations a period", "Of the right-hand side; a jet counts as its order."),
    need("steps_per_period", _CELL, "i4", "fixed steps a period", "Or a part of duration; 0: chosen by the method."),
    need("exponent_error_spread", _CELL, "f8", "standard error of the exponent's error", "Over the restarts."),
    need("horizon", _CELL, "f8", "trusted time", "Until a chaotic trajectory is off by 1e-6; infinite if never."),
    need("horizon_expected", "tolerance", "f8", "expected trusted time", "ln(1e-6/tolerance)/exponent, in chaos."),
    outcome(_CELL),
    need("period", "", "i4", "period of the cycle", "In forcing periods; 0 off a cycle."),
    need("lyapunov_exponent", "", "f8", "leading Lyapunov exponent", "Over the surveyed part of the attractor."),
    need("lyapunov_error", "", "f8", "standard error of the exponent", "Statistical; from blocks, not numerics."),
    need("start", "state", "f8", "start", "State from which all methods start, at the strobe."),
    forcing()[0],
    magnitude=("error", "reference_error", "exponent_error_spread", "horizon", "horizon_expected"),
    bars={"lyapunov_exponent": "lyapunov_error"},
)


@dataclass(frozen=True, kw_only=True)
class WorkPrecision(Record):
    """Settings of `work_precision`."""

    without_noise: ClassVar[str] = "its reference in extended precision has no random numbers"
    own_numerics: ClassVar[bool] = True
    meanings: ClassVar[Mapping[str, str]] = {
        "periods": "Points of the section to survey: the statistical error of the exponent is that of a run of "
        "this length, and the restarts are taken from it.",
        "duration": "Time to survey, for systems without a forcing period; 64 parts of it take the place of periods.",
        "transient": "Points of the section, or time, to run before measurements begin.",
    }

    methods: list[str] = setting(ListOf(Method(), distinct=True), tuple(METHODS), doc="Default: all methods.")
    tolerances: list[float] = setting(
        ListOf(Number(1e-16, 1e-2), distinct=True), TOLERANCES, doc="Default 1e-4, 1e-6, ..., 1e-14."
    )
    steps: list[int] | None = setting(
        ListOf(Whole(4, 10_000_000)),
        None,
        doc="Steps per period for methods with fixed steps, one for each tolerance. Default 20 "
        "tolerance^(-1/4): with order 4 their error then falls as the tolerance does.",
    )
    repeats: int = setting(
        Whole(1, 1000), 5, doc="Rounds in which all cells are timed in turn; the medians are reported."
    )

    @classmethod
    def beside(cls, table: Mapping[str, Any]) -> Faults:
        """Another number of steps than of tolerances; and the lengths."""
        yield from super().beside(table)
        steps, tolerances = table.get("steps"), table.get("tolerances", list(TOLERANCES))
        if isinstance(steps, list) and isinstance(tolerances, list) and len(steps) != len(tolerances):
            yield ("steps",), told(f"expected a list of {len(tolerances)} counts, one for each of tolerances", steps)

    @classmethod
    def misfits(cls, table: Mapping[str, Any], system: HybridSystem) -> Faults:
        """As for every run, plus a map, for which there are no methods."""
        yield from super().misfits(table, system)
        if system.discrete:
            yield (), f"{system.name} is a map: it takes no steps, so that there are no methods to compare"


@analysis(
    "work-precision",
    WorkPrecision,
    "errors against time over methods and tolerances, with a recommendation",
    VARIABLES,
    cites=(*SPECTRA, "bulirsch1966"),
)
def work_precision(system: HybridSystem, given: WorkPrecision, job: Job) -> Dataset:
    """Errors against run time, steps and evaluations, for every method and tolerance.

    After the transient the run looks for a cycle. If it has settled on one, the methods are compared over that cycle;
    otherwise over the surveyed period with the most kinds of events. Errors are measured against a 60-digit reference:
    extrapolation between events (Bulirsch and Stoer 1966, doi:10.1007/BF02165234), Newton's method for the events,
    finite differences of the flow for the tangents. The reference shares no formula with the methods. For the exponent
    and for trusted times, which it does not give, every method is compared with another one at the tightest tolerance,
    named by the attribute ``reference_methods``. If a method does not approach its reference however tight its
    tolerance is, the methods disagree, and none is recommended.

    Returns
    -------
    xarray.Dataset
        ``error`` (quantity, method, tolerance), ``reference_error`` (quantity); ``wall_time``, ``wall_time_spread``,
        ``steps``, ``evaluations``, ``steps_per_period``, ``horizon``, ``exponent_error_spread`` and ``outcome``
        (method, tolerance); ``horizon_expected`` (tolerance), ``period``, ``lyapunov_exponent``, ``lyapunov_error``,
        ``start`` (state). The attribute ``recommendation`` states the conclusion in words.

        Quantities: ``strobe``, the strobe point of the cycle, or the state after one period; ``event_time``, in parts
        of the period, infinite where events differ; ``tangent``, the tangent map; ``multiplier``, its eigenvalues on a
        cycle; ``flow_direction``, the identity by which tangents map F at the start to F at the end; ``exponent``, the
        numerical part of the leading exponent's error, from restarts at the same states. NaN where a quantity is
        undefined or has no reference. Since ``sel`` of xarray has its own keywords ``method`` and ``tolerance``, select
        with a mapping: ``ds["error"].sel({"quantity": "multiplier", "method": "taylor"})``.

    Raises
    ------
    SettingsError
        An argument that cannot be used, a map, or a system with Python functions.
    """
    from chaosdrill.analysis.precision.costs import UNITS, compare
    from chaosdrill.analysis.precision.start import TIGHT
    from chaosdrill.engine.numerics import Numerics

    for place, one in system.sources.items():
        raise SettingsError(
            f"{system.name} has a Python function, {one.name!r:.60} at {place:.200}, for which no reference with more "
            "digits can be computed; write it as expressions, or compare runs of several tolerances"
        )
    return compare(system, given.span(system, Numerics(tolerance=TIGHT), units=UNITS), given, job)
