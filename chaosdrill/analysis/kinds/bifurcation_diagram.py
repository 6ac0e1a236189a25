"""Bifurcation diagrams: section, period, exponents and outcome along a parameter."""

from dataclasses import dataclass
from typing import Any, ClassVar

from chaosdrill.analysis.arguments import Axes
from chaosdrill.analysis.base import POINTS, Dataset, HybridSystem, Job, Points, analysis
from chaosdrill.analysis.starting_states import FIXED_SEEDS, RANDOM, RANDOM_SEEDS, SEEDS
from chaosdrill.dataset.schema import SWEEP, need, swept, table
from chaosdrill.settings import Choice, Whole, setting

FOLLOW = {"forward": ("forward",), "backward": ("backward",), "both": ("forward", "backward")}
"""Directions in which a state can be followed along a sweep, by the value of ``follow``."""

POINTS_OF_TIME = 256
"""Section points that are kept by default where the length is a duration."""

VARIABLES = table(
    *swept("Period of the forcing at each point of the sweep."),
    need("section", f"{SWEEP} seed iterate state", "f8", "state on the section", "NaN where there is no result."),
)


@dataclass(frozen=True, kw_only=True)
class BifurcationDiagram(Points):
    """Settings of `bifurcation_diagram`."""

    without_noise: ClassVar[str] = ""
    needs_section: ClassVar[bool] = True

    sweep: dict[str, Any] = setting(
        Axes("parameter", 1, 1, "a bifurcation diagram sweeps one parameter"),
        positional=True,
        doc='``{"eta": np.linspace(0.4, 0.9, 501)}``.',
    )
    seeds: list[dict[str, Any]] | None = setting(SEEDS, None, doc=FIXED_SEEDS)
    random: dict[str, Any] | None = setting(RANDOM, None, doc=RANDOM_SEEDS)
    follow: str | None = setting(
        Choice(tuple(FOLLOW), ", or leave it out"),
        None,
        doc="Start each run from the final state of its neighbour, up or down the sweep, to show hysteresis. "
        "The first run, and one whose neighbour ended early, starts from the system's own initial state.",
    )
    section_points: int | None = setting(
        Whole(1, 1_000_000),
        None,
        doc="Number of section points to store of every run, the last ones; default ``periods``, or 256 with "
        "``duration``.",
    )

    @property
    def rows(self) -> int:
        """Section points that are kept."""
        return self.section_points or self.periods or POINTS_OF_TIME


@analysis(
    "bifurcation-diagram",
    BifurcationDiagram,
    "section, period, exponents and outcome along a parameter",
    VARIABLES,
    cites=POINTS,
)
def bifurcation_diagram(system: HybridSystem, given: BifurcationDiagram, job: Job) -> Dataset:
    """Poincaré sections along a parameter, with the spectrum and an outcome at every point.

    Every point is an independent run from its own initial state, so that results are bit-identical for any number of
    workers; a state followed along the sweep is a seed of its own. If a run fails, its outcome gives the reason, and
    the sweep continues.

    Attractors are classified by exponents and recurrence together (see "Period detection" in the theory). An undecided
    run is extended by up to ``max_extension`` times ``periods``, or until it settles on a cycle; its last record is
    stored.

    Returns
    -------
    xarray.Dataset
        Over the parameter and seed: ``section`` (iterate, state), ``period``, ``lyapunov_exponent`` and
        ``lyapunov_error`` (exponent), mean rates, ``return_time`` of events, ``outcome``; ``initial_state`` (seed,
        state). NaN, and period 0, where a point has no result.
    """
    from chaosdrill.analysis.grids.sweeps import over_parameters

    lines = () if given.follow is None else FOLLOW[given.follow]
    return over_parameters(system, given, job, rows=given.rows, lines=lines)
