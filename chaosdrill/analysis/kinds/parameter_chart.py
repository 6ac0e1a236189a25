"""Charts over two parameters: period, exponents, rates, outcome, and number of attractors."""

from dataclasses import dataclass
from typing import Any, ClassVar

from chaosdrill.analysis.arguments import Axes
from chaosdrill.analysis.base import POINTS, Dataset, HybridSystem, Job, Points, analysis
from chaosdrill.analysis.starting_states import FIXED_SEEDS, RANDOM, RANDOM_SEEDS, SEEDS
from chaosdrill.dataset.schema import SWEEP, may, need, swept, table
from chaosdrill.settings import Whole, setting

VARIABLES = table(
    *swept("Period of the forcing at each point of the chart."),
    may("section", f"{SWEEP} seed iterate state", "f8", "state on the section", "The last points; NaN: no result."),
    need("attractor_count", SWEEP, "i2", "number of attractors", "Different ones among the seeds; 0: none found."),
)


@dataclass(frozen=True, kw_only=True)
class ParameterChart(Points):
    """Settings of `parameter_chart`."""

    without_noise: ClassVar[str] = ""

    sweep: dict[str, Any] = setting(
        Axes("parameter", 2, 2, "a parameter chart sweeps two"),
        positional=True,
        doc='``{"eta": np.linspace(0.4, 0.9, 500), "b": np.linspace(0.5, 0.9, 400)}``.',
    )
    seeds: list[dict[str, Any]] | None = setting(SEEDS, None, doc=FIXED_SEEDS)
    random: dict[str, Any] | None = setting(RANDOM, None, doc=RANDOM_SEEDS)
    section_points: int = setting(
        Whole(0, 10_000),
        0,
        doc="Number of section points to store of every run, the last ones; a report shows them on a click.",
    )


@analysis(
    "parameter-chart",
    ParameterChart,
    "period, exponents, rates, outcome and attractors over two parameters",
    VARIABLES,
    cites=POINTS,
)
def parameter_chart(system: HybridSystem, given: ParameterChart, job: Job) -> Dataset:
    """Period, spectrum, mean rates and outcome over two parameters.

    Every point is an independent run, classified as in `bifurcation_diagram`, from the same seeds. An attractor that
    several seeds reach is counted once.

    Returns
    -------
    xarray.Dataset
        Over both parameters and seed: ``period``, ``lyapunov_exponent`` and ``lyapunov_error`` (exponent), mean rates,
        ``outcome``, and ``section`` (iterate, state) if requested; over both parameters ``attractor_count`` and, of a
        forced system, ``forcing_period``; ``initial_state`` (seed, state). NaN, and the period 0, where a point has no
        result.
    """
    from chaosdrill.analysis.grids.sweeps import over_parameters

    return over_parameters(system, given, job, rows=given.section_points, counts_attractors=True)
