"""Attractors along a parameter, and the share of the starts that leads to each."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from chaosdrill.analysis.arguments import Axes
from chaosdrill.analysis.base import POINTS, Dataset, HybridSystem, Job, Points, analysis
from chaosdrill.analysis.starting_states import RANDOM
from chaosdrill.analysis.starts import STARTS
from chaosdrill.dataset.branches import AttractorEnd
from chaosdrill.dataset.schema import (
    EXPONENT,
    INITIAL_STATE,
    RUN_NUMBER,
    STATES,
    SWEEP,
    axis,
    forcing,
    may,
    need,
    of_attractors,
    outcome,
    rates_of_attractors,
    table,
)
from chaosdrill.settings import Faults, setting

_EACH = f"{SWEEP} attractor"
_NEXT = "Number of the attractor to which the motion then leads; 0: none of the table, or several."

ENDS = (
    need("first_value", "attractor", "f8", "lowest value with the attractor", "Of those of the sweep."),
    need("last_value", "attractor", "f8", "highest value with the attractor", "Of those of the sweep."),
    need("end_below", "attractor", "i1", "end of the attractor below", "As a code.", flags=AttractorEnd),
    need("end_above", "attractor", "i1", "end of the attractor above", "As a code.", flags=AttractorEnd),
    need("next_below", "attractor", "i4", "attractor that follows below", _NEXT),
    need("next_above", "attractor", "i4", "attractor that follows above", _NEXT),
)

VARIABLES = table(
    axis(SWEEP, SWEEP, "f8", "swept parameter", "Values of the sweep.", True),
    axis("attractor", "attractor", "i4", "number of the attractor", "By the sum of its shares, from 1.", True),
    RUN_NUMBER,
    *STATES,
    INITIAL_STATE,
    may("initial_mode", "run", "i1", "initial mode", "Mode in which a run starts.", flags="mode"),
    EXPONENT,
    *of_attractors(_EACH, "-1 where it does not exist."),
    *rates_of_attractors(_EACH),
    need(
        "fraction_none", SWEEP, "f8", "fraction without an attractor", "Starts that lead to no attractor of the table."
    ),
    need("fraction_none_error", SWEEP, "f8", "standard error of that", "Of starts drawn at random."),
    *ENDS,
    need("reached", f"{SWEEP} run", "i4", "attractor", "Number of the attractor that a start leads to; 0: none."),
    outcome(f"{SWEEP} run"),
    *forcing(SWEEP, "Period of the forcing at each value."),
    bars={"attractor_exponent": "attractor_error"},
    average=("attractor_rate_si",),
    sampled=("attractor_state",),
)


@dataclass(frozen=True, kw_only=True)
class Attractors(Points):
    """Settings of `attractors`."""

    without_noise: ClassVar[str] = ""
    meanings: ClassVar[Mapping[str, str]] = {"system": "System with its parameters."}

    sweep: dict[str, Any] = setting(
        Axes("parameter", 1, 1, "attractors are followed along one parameter"),
        positional=True,
        doc='``{"eta": np.linspace(0.4, 0.9, 101)}``. An attractor that replaces another between two '
        "neighbouring values, and coexists with it at neither, counts as the same.",
    )
    initial: Any = setting(
        STARTS,
        None,
        doc="Initial states whose shares are counted, the same at every value, in any form that `basins` takes.",
    )
    random: dict[str, Any] | None = setting(
        RANDOM,
        None,
        doc='``{"count": 200, "seed": 1, "y": (-1, 1)}``: ``count`` states drawn uniformly from the box, by a '
        "generator with this ``seed``. If ``initial`` is also given, both are counted.",
    )

    @classmethod
    def beside(cls, table: Mapping[str, Any]) -> Faults:
        """Initial states in one way at least; and the lengths."""
        yield from super().beside(table)
        if not {"initial", "random"} & table.keys():
            yield ((), "give the initial states whose shares are counted: a list (initial), or a box (random)")


@analysis(
    "attractors",
    Attractors,
    "attractors along a parameter, the share of the starts that leads to each, and where they end",
    VARIABLES,
    cites=(*POINTS, "datseris2023", "stender2022", "menck2013"),
)
def attractors(system: HybridSystem, given: Attractors, job: Job) -> Dataset:
    """Attractors along a parameter, the share of the starts that leads to each, and where they begin and end.

    At every value all starts are run, and the attractors are distinguished as by `basins`. Every attractor is continued
    to both neighbouring values, like a state followed along a diagram, and the attractor reached there is continued in
    turn if no start had found it: an attractor whose basin contains no start has the share 0. Two attractors at
    neighbouring values are the same if the motion leads from the first to the second and back again to the first.
    Hysteresis thus becomes visible: an attractor ends in a ``jump`` if the motion goes to another one and does not come
    back. Where several lead to one, motions go back from eight stretches of it: if these reach more than one, the
    others have merged into it (``merger``; seen from the other side ``split``), and a new one begins there.
    Attractors.jl matches attractors by their distance in state space instead (Datseris, Rossi and Wagemakers 2023,
    doi:10.1063/5.0159675); shares along a parameter are drawn by bSTAB (Stender and Hoffmann 2022,
    doi:10.1007/s11071-021-06786-5).

    Returns
    -------
    xarray.Dataset
        Over the parameter and ``attractor``: ``fraction`` and ``fraction_error``, ``attractor_period``,
        ``attractor_outcome`` (its kind; -1, "none" in words, where it does not exist), ``attractor_exponent`` and
        ``attractor_error`` (exponent), mean rates, ``attractor_state`` (state). Over ``attractor``: ``first_value`` and
        ``last_value`` of the parameter with it, ``end_below`` and ``end_above`` (``limit`` of the sweep, ``jump``,
        ``merger``, ``split`` or ``lost``), ``next_below`` and ``next_above``. Over the parameter ``fraction_none``, and
        with ``run`` ``reached`` (the attractor of every start) and ``outcome``; ``initial_state`` (run, state). Shares
        are NaN where no start could be run. Errors are those of shares of starts drawn at random (Agresti and Coull
        1998, doi:10.1080/00031305.1998.10480550), not zero even for the share 0; those of neighbouring values are not
        independent, since the starts are the same. The error of a share of a grid is different, of the size of the
        share of cells on the boundary, and mostly smaller. At most 16 attractors are distinguished at one value.
    """
    from chaosdrill.analysis.grids.shares import over_one_parameter

    return over_one_parameter(system, given, job)
