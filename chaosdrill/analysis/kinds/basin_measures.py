"""Measures of basins: shares, entropies, the uncertainty exponent of the boundary, and whether it is common to all."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar

from chaosdrill.analysis.arguments import Axes
from chaosdrill.analysis.base import POINTS, Dataset, HybridSystem, Job, OverParameter, analysis
from chaosdrill.analysis.kinds.attractors import ENDS
from chaosdrill.analysis.kinds.basins import Basins
from chaosdrill.dataset.schema import EXPONENT, STATES, SWEEP, axis, forcing, may, need, of_attractors, outcome, table
from chaosdrill.settings import Whole, setting

_MOVED = "Of another grid on the same basins."
_KICK = "From attractor_state, to the nearest cell in parts of the grid; 0 for states that it does not span."
_COMMON = "How far in cells points of any boundary are from its own at most; NaN for fewer than three basins."

_EACH, _DISTANCE = f"{SWEEP} attractor", f"{SWEEP} distance"

VARIABLES = table(
    axis(SWEEP, SWEEP, "f8", "swept parameter", "Values of the sweep.", True),
    axis(
        "attractor",
        "attractor",
        "i4",
        "number of the attractor",
        "By the size of its basin, of a sweep by the sum of its shares, from 1.",
        True,
    ),
    *STATES,
    EXPONENT,
    axis("distance", "distance", "i4", "distance of starts", "In cells along a state."),
    *of_attractors(_EACH, "Of a sweep -1 where it does not exist.", "Of random starts, or of a grid."),
    need("fraction_none", SWEEP, "f8", "fraction without an attractor", "Part of the starts that lead to none."),
    need("fraction_none_error", SWEEP, "f8", "standard error of that", "Of random starts, or of a grid."),
    need("start_count", "", "i4", "number of starts", "Cells and listed starts."),
    may("basin_entropy", SWEEP, "f8", "basin entropy", "Mean Gibbs entropy of boxes of cells."),
    may("basin_entropy_error", SWEEP, "f8", "standard error of the basin entropy", _MOVED),
    may("boundary_entropy", SWEEP, "f8", "boundary basin entropy", "Mean over boxes with more than one attractor."),
    may("boundary_entropy_error", SWEEP, "f8", "standard error of the boundary basin entropy", _MOVED),
    may("uncertainty_exponent", SWEEP, "f8", "uncertainty exponent", "1 for smooth boundaries; NaN: no range to fit."),
    may("uncertainty_exponent_error", SWEEP, "f8", "standard error of the uncertainty exponent", "On the large side."),
    may(
        "uncertain_fraction",
        _DISTANCE,
        "f8",
        "uncertain fraction",
        "Of cells with another so close along a state; NaN beyond a sixteenth of the axis.",
    ),
    may("uncertain_fraction_error", _DISTANCE, "f8", "standard error of the uncertain fraction", "By chance."),
    may("wada_distance", _EACH, "f8", "distance of other boundaries", _COMMON),
    may("smallest_kick", f"{_EACH} state", "f8", "smallest kick to another basin", _KICK),
    may("smallest_kick_error", f"{_EACH} state", "f8", "standard error of the kick", "By cells that are as near."),
    *(replace(one, required=False) for one in ENDS),
    replace(outcome(SWEEP), required=False),
    *forcing(SWEEP),
    bars={"attractor_exponent": "attractor_error"},
    sampled=("attractor_state",),
)


@dataclass(frozen=True, kw_only=True)
class BasinMeasures(OverParameter, Basins):
    """Settings of `basin_measures`."""

    without_noise: ClassVar[str] = (
        "a start leads to either side of a boundary by chance, so that it has no shape; basins gives the shares"
    )
    meanings: ClassVar[Mapping[str, str]] = {
        "initial": "Initial states, in any number and any form that `basins` takes: they have shares, but no entropies "
        "and no exponent. With a grid they are included in the shares.",
        "sweep": '``{"eta": np.linspace(0.4, 0.9, 51)}``: the same starts at every value, with their measures, and one '
        "number for an attractor at all values, as in `attractors`.",
    }

    grid: dict[str, Any] | None = setting(
        Axes("state", 1, 6, "basins are measured over one state to six"),
        None,
        positional=True,
        doc="Values of each state; equally spaced, and 100 of each at least, for an uncertainty exponent.",
    )
    box: int = setting(Whole(2, 1000), 5, doc="Cells of a box along every state.")


@analysis(
    "basin-measures",
    BasinMeasures,
    "shares of basins, basin entropy, uncertainty exponent of their boundary, and a test for Wada basins",
    VARIABLES,
    cites=(*POINTS, "menck2013", "daza2016", "grebogi1983", "daza2018"),
)
def basin_measures(system: HybridSystem, given: BasinMeasures, job: Job) -> Dataset:
    """Shares of the basins of attraction in a grid or a list of starts, and measures of their entanglement.

    The attractors are those of `basins`; starts that lead to none count as one further basin. The basin entropy is the
    mean Gibbs entropy of the attractors in boxes of cells, and the boundary basin entropy that of the boxes with more
    than one: beyond log 2 the boundary is fractal (Daza and others 2016, doi:10.1038/srep31416). The share of starts
    with another attractor within a distance along a state grows as a power of the distance, the uncertainty exponent,
    which is the number of states of the grid minus the dimension of the boundary (Grebogi, McDonald, Ott and Yorke
    1983, doi:10.1016/0375-9601(83)90945-3); the smallest over the states is taken. On grids of some hundred cells
    boundaries with an exponent below 0.4 seem smoother than they are, which the error includes. If merging all basins
    except one leaves the same boundary to a few cells, whichever basin is excepted, the basins have the Wada property
    to the resolution of the grid (Daza and others 2018, doi:10.1038/s41598-018-28119-0). With a ``sweep`` the same
    starts are measured at every value, and attractors are followed from value to value as by `attractors`, 16 at one
    value at most: starts that lead to others count as leading to none.

    Returns
    -------
    xarray.Dataset
        Over ``attractor``: ``fraction`` and ``fraction_error``, ``attractor_period``, ``attractor_outcome``,
        ``attractor_exponent`` and ``attractor_error`` (exponent), ``attractor_state`` (state), and ``wada_distance``,
        in cells. Of a grid ``basin_entropy``, ``boundary_entropy`` and ``uncertainty_exponent``, each with its
        ``_error``, and ``uncertain_fraction`` over ``distance``, in cells; ``smallest_kick`` (attractor, state) is the
        change of ``attractor_state``, in the units of each state, to the nearest start with another attractor, with
        lengths relative to the grid; NaN for an attractor outside its plane. Whole turns of an angle, if no equation
        tells them, are left out. The boundary lies up to one cell closer,
        and where it is about as near in several directions, the error says so. A state of one value is held there.
        The error of a share of a list is that of random starts (Agresti and Coull 1998,
        doi:10.1080/00031305.1998.10480550); for a grid it is the worst case of the cells cut by the boundary, if that
        is smaller.

        If a parameter is swept, all but ``start_count`` are over it, too; where an attractor does not exist its share
        is 0, and the rest NaN. ``first_value``, ``last_value``, ``end_below``, ``end_above``, ``next_below`` and
        ``next_above`` are those of `attractors`. All measures are NaN where no start could be run, at values of which
        ``outcome`` tells; elsewhere it is ``ok``.

        The attribute ``reason`` says why a measure is NaN, and along a sweep at which values.
    """
    from chaosdrill.analysis.grids.boundaries import measures_dataset

    return measures_dataset(system, given, job)
