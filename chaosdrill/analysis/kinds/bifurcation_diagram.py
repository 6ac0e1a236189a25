"""Bifurcation diagrams: section, period, exponents and outcome along a parameter."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from chaosdrill.analysis.arguments import RANDOM, SEEDS, Axes
from chaosdrill.analysis.base import POINTS, Points, analysis
from chaosdrill.dataset.schema import SWEEP, need, swept, table
from chaosdrill.settings import Choice, Whole, setting

if TYPE_CHECKING:
    import xarray as xr

    from chaosdrill.analysis.base import Job
    from chaosdrill.model import HybridSystem

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
        Axes("parameter", 1, 1, "a bifurcation diagram sweeps one parameter"), positional=True
    )
    seeds: list[dict[str, Any]] | None = setting(SEEDS, None)
    random: dict[str, Any] | None = setting(RANDOM, None)
    follow: str | None = setting(Choice(tuple(FOLLOW), ", or leave it out"), None)
    section_points: int | None = setting(Whole(1, 1_000_000), None)

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
def bifurcation_diagram(system: "HybridSystem", given: BifurcationDiagram, job: "Job") -> "xr.Dataset":
    """Poincaré sections along a parameter, with the spectrum and an outcome at every point.

    Every point is an independent run from its own initial state, so that results are bit-identical for any number of
    workers; a state followed along the sweep is a seed of its own. If a run fails, its outcome gives the reason, and
    the sweep continues.

    Attractors are classified by exponents and recurrence together (see "Period detection" in the theory). An undecided
    run is extended by up to ``max_extension`` times ``periods``, or until it settles on a cycle; its last record is
    stored.

    Parameters
    ----------
    system : HybridSystem
        System with its parameters and initial state.
    sweep : mapping of one parameter to values
        ``{"eta": np.linspace(0.4, 0.9, 501)}``.
    periods : int
        Points of the section to record and to average the exponents over: forcing periods, or events named by ``at``.
    duration : float
        Time to average over instead, for systems without a forcing period; the transient, a time too, is rounded up to
        a whole part of it, of 512.
    transient : int or float
        Points of the section, or time, to run before the record starts.
    at : str, optional
        The section, as in `poincare_section`: an event, a surface, or the strobe, which is the default of a forced
        system. Without forcing, name one.
    max_return : float, optional
        As in `poincare_section`: a point whose run does not meet the section has the outcome ``no_return``, or
        ``equilibrium`` if it is at rest, and the sweep goes on.
    exponents : int, optional
        Number of exponents; default all; 0 for none, so that recurrence alone classifies, without extension.
    max_period : int, default 64
        Longest period to detect, in iterates of the section; the record must contain two.
    max_extension : int, default 8
        How many times ``periods`` an undecided run may be extended by; 0 for no extension.
    seeds : sequence of mappings, optional
        Initial values (and ``mode``) of each fixed seed; default: the system's own initial state, unless other seeds
        are requested.
    random : mapping, optional
        ``{"count": 4, "seed": 1, "y": (-1, 1)}``: ``count`` states drawn uniformly from the box, by a generator with
        this ``seed``; the same states at every point.
    follow : {"forward", "backward", "both"}, optional
        Start each run from the final state of its neighbour, up or down the sweep, to show hysteresis. The first run,
        and one whose neighbour ended early, starts from the system's own initial state.
    section_points : int, optional
        Number of section points to store of every run, the last ones; default ``periods``, or 256 with ``duration``.
    workers : int, default 1
        Threads; the kernels release the interpreter's lock.
    scheduler : str, optional
        Address of a Dask scheduler, whose workers are used instead.
    store : path-like, optional
        Folder for finished chunks, from which the same call resumes if it was interrupted.
    method, tolerance, steps, max_events, max_stalls, progress : optional
        As in `trajectory`; ``progress`` gets the outcomes counted so far.

    Returns
    -------
    xarray.Dataset
        Over the parameter and seed: ``section`` (iterate, state), ``period``, ``lyapunov_exponent`` and
        ``lyapunov_error`` (exponent), mean rates, ``return_time`` of events, ``outcome``; ``initial_state`` (seed,
        state). NaN, and period 0, where a point has no result.

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

    lines = () if given.follow is None else FOLLOW[given.follow]
    return over_parameters(system, given, job, rows=given.rows, lines=lines)
