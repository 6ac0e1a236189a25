"""Charts over two parameters: period, exponents, rates, outcome, and number of attractors."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from chaosdrill.analysis.arguments import RANDOM, SEEDS, Axes
from chaosdrill.analysis.base import POINTS, Points, analysis
from chaosdrill.dataset.schema import SWEEP, may, need, swept, table
from chaosdrill.settings import Whole, setting

if TYPE_CHECKING:
    import xarray as xr

    from chaosdrill.analysis.base import Job
    from chaosdrill.model import HybridSystem

VARIABLES = table(
    *swept("Period of the forcing at each point of the chart."),
    may("section", f"{SWEEP} seed iterate state", "f8", "state on the section", "The last points; NaN: no result."),
    need("attractor_count", SWEEP, "i2", "number of attractors", "Different ones among the seeds; 0: none found."),
)


@dataclass(frozen=True, kw_only=True)
class ParameterChart(Points):
    """Settings of `parameter_chart`."""

    without_noise: ClassVar[str] = ""

    sweep: dict[str, Any] = setting(Axes("parameter", 2, 2, "a parameter chart sweeps two"), positional=True)
    seeds: list[dict[str, Any]] | None = setting(SEEDS, None)
    random: dict[str, Any] | None = setting(RANDOM, None)
    section_points: int = setting(Whole(0, 10_000), 0)


@analysis(
    "parameter-chart",
    ParameterChart,
    "period, exponents, rates, outcome and attractors over two parameters",
    VARIABLES,
    cites=POINTS,
)
def parameter_chart(system: "HybridSystem", given: ParameterChart, job: "Job") -> "xr.Dataset":
    """Period, spectrum, mean rates and outcome over two parameters.

    Every point is an independent run, classified as in `bifurcation_diagram`, from the same seeds. An attractor that
    several seeds reach is counted once.

    Parameters
    ----------
    system : HybridSystem
        System with its parameters and initial state.
    sweep : mapping of two parameters to values
        ``{"eta": np.linspace(0.4, 0.9, 500), "b": np.linspace(0.5, 0.9, 400)}``.
    periods, duration, transient : int or float
        As in `bifurcation_diagram`. Without forcing a ``duration`` needs no section; no period is then detected.
    at, max_return, exponents, max_period, max_extension : optional
        As in `bifurcation_diagram`.
    seeds, random : optional
        As in `bifurcation_diagram`.
    section_points : int, default 0
        Number of section points to store of every run, the last ones; a report shows them on a click.
    workers, scheduler, store : optional
        As in `bifurcation_diagram`.
    method, tolerance, steps, max_events, max_stalls, progress : optional
        As in `trajectory`; ``progress`` gets the outcomes counted so far.

    Returns
    -------
    xarray.Dataset
        Over both parameters and seed: ``period``, ``lyapunov_exponent`` and ``lyapunov_error`` (exponent), mean rates,
        ``outcome``, and ``section`` (iterate, state) if requested; over both parameters ``attractor_count`` and, of a
        forced system, ``forcing_period``; ``initial_state`` (seed, state). NaN, and the period 0, where a point has no
        result.

    Raises
    ------
    SettingsError
        An argument that cannot be used, or a ``store`` that holds chunks of another call.
    ArchiveError
        If the ``store`` cannot be written, or another call uses it.
    ChaosdrillError
        If the scheduler cannot be reached or is lost, or if its workers have other versions.
    """
    from chaosdrill.analysis.sweeps import over_parameters

    return over_parameters(system, given, job, rows=given.section_points, counts_attractors=True)
