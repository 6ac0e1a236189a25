"""Edge states: what the motions between two basins of attraction come to."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from chaosdrill.analysis.base import POINTS, Dataset, HybridSystem, Job, Points, analysis
from chaosdrill.analysis.starting_states import RANDOM
from chaosdrill.analysis.starts import STARTS
from chaosdrill.dataset.schema import COVERS, EXPONENT, RANK_LOSS, STATES, axis, forcing, need, outcome, table
from chaosdrill.settings import Faults, Number, Whole, setting, told

_PARTS = "The largest over the states, in parts of the extent of both starts and what they lead to."

VARIABLES = table(
    axis("side", "side", "i4", "side of the edge", "From 1.", True),
    *STATES,
    EXPONENT,
    need("edge_state", "state", "f8", "edge state", "A state on it: the last one that was bisected."),
    need(
        "edge_error", "state", "f8", "error of the edge state", "Half of the last distance, or the change in a period."
    ),
    need("edge_mode", "", "i1", "mode of the edge state", "-1: no edge state.", flags="mode", lacking=True),
    need("period", "", "i4", "period of the edge state", "In steps of the track; 0: it is no cycle."),
    outcome(""),
    need("return_distance", "", "f8", "distance after a period", f"Of the best one. {_PARTS}"),
    need("growth_rate", "", "f8", "growth rate across the edge", "Of the distance of two motions beside it, per time."),
    need("growth_rate_error", "", "f8", "standard error of the growth rate", "From segments."),
    need("lyapunov_exponent", "exponent", "f8", "Lyapunov exponent of the edge state", RANK_LOSS),
    need("lyapunov_error", "exponent", "f8", "standard error of the exponent", COVERS),
    need("track_time", "step", "f8", "time on the edge", "Since the start."),
    need("track_state", "step state", "f8", "state on the edge", "In the middle between two motions beside it."),
    need("track_mode", "step", "i1", "mode on the edge", "As a code.", flags="mode"),
    need("track_distance", "step", "f8", "distance of both motions", _PARTS),
    need("bisection", "step", "i4", "number of the bisection", "After which the two motions began, from 1."),
    need("side_start", "side state", "f8", "start on this side", "Between which the edge was bisected first."),
    need("side_state", "side state", "f8", "state on the attractor", "A point of it; NaN where runs escape."),
    need("side_period", "side", "i2", "period of the attractor", "In iterates of the section, or 0."),
    outcome("side", "side_outcome", "fate on this side"),
    *forcing(),
    bars={"lyapunov_exponent": "lyapunov_error"},
    sampled=("edge_state", "track_time", "track_state", "side_state"),
    magnitude=("return_distance", "track_distance", "edge_error"),
)


@dataclass(frozen=True, kw_only=True)
class EdgeStates(Points):
    """Settings of `edge_states`."""

    parallel: ClassVar[bool] = False
    without_noise: ClassVar[str] = "a start beside an edge leads to either side of it by chance"
    meanings: ClassVar[Mapping[str, str]] = {
        "system": "System with its parameters; its initial state supplies the states that the starts do not name.",
        "transient": "Points of the section, or time, to run before a fate is determined. Starts beside the edge leave "
        "it late: the distance ``closest`` must grow to the extent of a basin meanwhile. Where it is too short, it is "
        "extended by ``periods``, up to ``max_extension`` times.",
        "at": "A section of a system without forcing, as in `poincare_section`: ``periods`` counts its points, and "
        "the edge is followed from point to point.",
    }

    initial: Any = setting(
        STARTS,
        None,
        doc="Starts in any form that `basins` takes. The edge is sought between the first one and the next that has "
        "another fate, in the same mode.",
    )
    random: dict[str, Any] | None = setting(
        RANDOM, None, doc='Starts drawn uniformly from a box instead: ``{"count": 20, "seed": 1, "x": (-1, 1)}``.'
    )
    rounds: int = setting(Whole(2, 10_000), 20, doc="How often two motions are bisected again after they have parted.")
    closest: float = setting(
        Number(above=0, most=1e-3),
        1e-8,
        doc="Distance to which starts are bisected, in parts of the extent of both starts and what they lead to.",
    )
    parted: float = setting(
        Number(above=0, most=1e-2), 1e-5, doc="Distance at which two motions are bisected again, in the same unit."
    )

    @classmethod
    def beside(cls, table: Mapping[str, Any]) -> Faults:
        """One kind of starts, and two distances in order."""
        yield from super().beside(table)
        if "random" in table and "initial" in table:
            yield ("initial",), told("random is given, too; leave one of them out", table["initial"])
        elif not {"random", "initial"} & table.keys():
            yield (), "give starts: initial, a list, or random, a box from which they are drawn"
        near, far = (table.get(name, cls.default(name)) for name in ("closest", "parted"))
        if all(isinstance(one, float | int) and not isinstance(one, bool) for one in (near, far)) and far < 10 * near:
            yield ("parted",), told(f"expected ten times closest, {near:g}, at least", far)


@analysis(
    "edge-states",
    EdgeStates,
    "the edge state between two attractors by bisection, and how fast motions leave it",
    VARIABLES,
    cites=(*POINTS, "battelino1988", "skufca2006"),
)
def edge_states(system: HybridSystem, given: EdgeStates, job: Job) -> Dataset:
    """The edge state between two attractors, or between an attractor and escape, by bisection.

    The first start is taken, and the next one of another fate. Their segment is shortened to ``closest`` where it meets
    the edge of the first basin, by nine parts at a time; both motions are followed until their distance is
    ``parted``, and bisected again (edge tracking: Battelino, Grebogi, Ott and Yorke 1988,
    doi:10.1016/0167-2789(88)90057-7; Skufca, Yorke and Eckhardt 2006, doi:10.1103/PhysRevLett.96.174101). Their middle
    thus stays within ``parted`` of the edge. If motions leave it in one direction only, it approaches what attracts
    within the edge: an equilibrium, a cycle, or a chaotic set. It is followed from strobe to strobe, from point to
    point of a section ``at``, or, without either, by 544ths of the duration. Attractors are told apart as in `basins`.

    From the later half of the bisections: the track is ``periodic`` (or ``equilibrium``) where all its states return
    to within four times ``parted``, and ``chaotic`` where two exponents are positive beyond three errors. Exponents are
    those of derivatives along the track. ``growth_rate``, of the distance of both motions, is the largest of them, seen
    in another way: on an equilibrium or a cycle that across the edge, on a chaotic edge state also one within it.
    Errors are from the scatter of bisections; on a cycle from that of single steps, as a bound.

    Returns
    -------
    xarray.Dataset
        ``edge_state`` and ``edge_error`` (state), ``edge_mode``, ``period``, in steps of the track, ``outcome``, what
        the edge state is, and ``return_distance``; ``growth_rate`` and ``growth_rate_error``; ``lyapunov_exponent`` and
        ``lyapunov_error`` (exponent), per unit of time, NaN where several transitions make the section;
        ``track_time``, ``track_state`` (state), ``track_mode``, ``track_distance`` and ``bisection`` over ``step``;
        ``side_start`` and ``side_state`` (side, state), ``side_period`` and ``side_outcome`` (side). Where the edge
        cannot be followed, or what it is cannot be told, the outcome is ``undecided``, and the attribute ``reason``
        says why: there are no two fates, a third one lies between them, or a jump parts them.
    """
    from chaosdrill.analysis.grids.edges import edges_dataset

    return edges_dataset(system, given, job)
