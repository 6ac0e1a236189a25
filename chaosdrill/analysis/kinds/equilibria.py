"""Equilibria of modes, pseudo-equilibria of sliding, and their branches over a parameter."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from chaosdrill.analysis.arguments import Ranges
from chaosdrill.analysis.base import AnalysisSettings, Dataset, HybridSystem, Job, analysis
from chaosdrill.analysis.starting_states import SEEDS, Region
from chaosdrill.dataset.branches import BranchEnd, Criticality
from chaosdrill.dataset.equilibria import Admissibility, Beyond, EquilibriumType, SpecialEquilibrium
from chaosdrill.dataset.schema import STATES, SWEEP, axis, may, need, outcome, table
from chaosdrill.names import remedy
from chaosdrill.settings import Faults, Known, ListOf, Number, Text, Whole, setting, told

if TYPE_CHECKING:
    import numpy as np

STEP = 1 / 200
"""Part of the parameter's range that is the largest step unless another one is given."""

_SPECIAL = "What happens there; the names are in flag_meanings."
_CYCLE = "Of the cycle born at a Hopf point, to second order in its amplitude, at cycle_value."

VARIABLES = table(
    *STATES,
    axis("eigenvalue", "eigenvalue", "i4", "index of the eigenvalue", "By falling real part, from 1.", True),
    may(SWEEP, "point", "f8", "free parameter", "Its value at each point of a branch."),
    need("equilibrium_state", "point state", "f8", "state of the equilibrium", "Where the rates of its mode vanish."),
    need("equilibrium_error", "point state", "f8", "error of the state", "A bound: of the rates and their rounding."),
    need("mode", "point", "i1", "mode of the equilibrium", "The mode whose rates vanish there.", flags="mode"),
    need("pseudo", "point", "i1", "pseudo-equilibrium", "Whether its mode slides on a surface.", flags="truth"),
    need("admissible", "point", "i1", "admissible", "Whether it is where its mode holds.", flags=Admissibility),
    need("type", "point", "i1", "type of the equilibrium", "By the eigenvalues.", flags=EquilibriumType),
    need("stable", "point", "i1", "stable", "Whether small deviations die out beyond the errors.", flags="truth"),
    need("free", "point", "i4", "free directions", "Number of eigenvalues; a state that the mode holds has none."),
    need("eigenvalue_real", "point eigenvalue", "f8", "eigenvalue, real part", "NaN beyond the free directions."),
    need("eigenvalue_imag", "point eigenvalue", "f8", "eigenvalue, imaginary part", "NaN beyond them, too."),
    need("eigenvalue_error", "point eigenvalue", "f8", "error of the eigenvalue", "A bound of its modulus."),
    may("starts_led", "point", "i4", "starts that led there", "Of the search."),
    axis("guard", "point", "str", "guard that is crossed or met", "Names of its transitions; empty for none."),
    may("branch", "point", "i4", "branch", "Number of the branch that the point belongs to."),
    may("arclength", "point", "f8", "arclength", "Along the branch, from its start."),
    may("special_point", "point", "i1", "special point", _SPECIAL, flags=SpecialEquilibrium),
    axis("branch_number", "branch_number", "i4", "number of the branch", "From 0."),
    may("branch_parent", "branch_number", "i4", "parent branch", "The one that it begins on; -1: none."),
    axis("branch_start", "branch_number", "str", "start of the branch", "In words."),
    may("branch_end", "branch_number", "i1", "end of the branch", "That before the limits.", flags=BranchEnd),
    axis("branch_end_text", "branch_number", "str", "ends of the branch", "In words."),
    may("special_index", "special", "i4", "point of the special point", "Its place in the dimension point, from 0."),
    may("special_kind", "special", "i1", "kind of the special point", _SPECIAL, flags=SpecialEquilibrium),
    may("special_value", "special", "f8", "parameter at the special point", "Located."),
    may("special_error", "special", "f8", "error of the special point", "Of special_value."),
    may("special_multiplicity", "special", "i4", "eigenvalues on the imaginary axis", "Their number; 0 at guards."),
    may("special_beyond", "special", "i1", "what follows at a guard", "By the modes beside it.", flags=Beyond),
    may("special_criticality", "special", "i1", "soft or hard", "Of a Hopf point.", flags=Criticality),
    may("special_coefficient", "special", "f8", "first Lyapunov coefficient", "Below 0 where supercritical."),
    may("special_coefficient_error", "special", "f8", "error of the coefficient", "NaN without one."),
    may("special_frequency", "special", "f8", "frequency", "Imaginary part of the pair at a Hopf point."),
    axis("special_text", "special", "str", "what happens at the special point", "In words."),
    may("cycle_value", "special", "f8", "parameter of the cycle", "A little beside the Hopf point; NaN without one."),
    may("cycle_state", "special state", "f8", "state on the cycle", _CYCLE),
    may("cycle_amplitude", "special state", "f8", "amplitude of the cycle", f"Half the extent of each state. {_CYCLE}"),
    may("cycle_period", "special", "f8", "period of the cycle", _CYCLE),
    outcome(""),
    magnitude=("equilibrium_error", "eigenvalue_error", "special_error", "special_coefficient_error"),
    bars={"equilibrium_state": "equilibrium_error", "special_value": "special_error"},
)


@dataclass(frozen=True, kw_only=True)
class Equilibria(AnalysisSettings):
    """Settings of `equilibria`."""

    meanings: ClassVar[Mapping[str, str]] = {
        "system": "System without explicit dependence on time.",
        "method": "Numerical method, of the run that shows where the motion goes.",
    }

    without_noise = "parameters that are drawn at events move every equilibrium with them"

    sweep: dict[str, Any] | None = setting(
        Ranges("parameter", 1, 1, "give one parameter, or none"),
        None,
        positional=True,
        doc='``{"b": (1.0, 4.0)}``: the parameter along which branches are followed. Default: no branches.',
    )
    region: dict[str, Any] | None = setting(
        Region(),
        None,
        doc="Where starts are spread; equilibria outside of it do not count. For states that it does not name, "
        "and without it: where the motion from the initial state goes, and as far again on either side.",
    )
    seeds: list[dict[str, Any]] | None = setting(
        SEEDS, None, doc="Initial states from which Newton's method starts as well."
    )
    starts: int = setting(Whole(1, 100_000), 100, doc="How many starts are spread, beside the initial state.")
    modes: list[str] | None = setting(
        ListOf(Text(), distinct=True), None, doc="Modes that are looked at; default: all."
    )
    step: float | None = setting(
        Number(above=0.0), None, doc="Largest step in the parameter; default 1/200 of its range."
    )
    max_points: int = setting(
        Whole(2, 1_000_000), 2000, doc="Largest number of points of a branch on either side of its start."
    )

    @classmethod
    def together(cls, table: Mapping[str, Any], known: Known) -> Faults:
        """What a branch alone takes, and too long a step."""
        if "sweep" not in table:
            for name in ("step", "max_points"):
                if name in table:
                    yield (
                        (name,),
                        told("applies to branches; name the parameter in sweep, or leave it out", table[name]),
                    )
            return
        ((name, limits),) = table["sweep"].items()
        room = abs(limits["stop"] - limits["start"])
        if table.get("step", 0) > room:
            yield ("step",), told(f"is longer than the whole range of {name!r}, which is {room:g}", table["step"])

    @classmethod
    def misfits(cls, table: Mapping[str, Any], system: HybridSystem) -> Faults:
        """A system whose rates depend on time, or that has none; modes that it lacks."""
        if system.discrete:
            yield (), f"{system.name} is a map, which has fixed points; take periodic_orbit with period = 1"
        elif not system.autonomous:
            words = f"{system.name} depends on time, so no state stays at rest"
            orbits = "; take periodic_orbit with period = 1, whose strobes are fixed points"
            yield (), words + orbits * system.forced
        for index, name in enumerate(table.get("modes") or ()):
            if name not in system.mode_names:
                yield ("modes", index), told(f"unknown mode; {remedy(name, system.mode_names)}", name)


@analysis(
    "equilibria",
    Equilibria,
    "equilibria of modes and of sliding, with eigenvalues; their branches, Hopf points and boundaries",
    VARIABLES,
    cites=("kuznetsov2023", "dibernardo2008equilibria", "keller1977"),
)
def equilibria(system: HybridSystem, given: Equilibria, job: Job) -> Dataset:
    """Equilibria of every mode, or their branches along a parameter with folds, Hopf points and boundaries.

    An equilibrium is a state at which the rates of a mode vanish. It is admissible where the mode holds and virtual
    beyond one of its guards. That of a mode that slides on a surface is a pseudo-equilibrium: the state that the mode
    holds is left out, so that only the eigenvalues of motions on the surface count. Of conserved combinations of
    states, and of states that nothing moves, the equilibria with the values of the initial state are given.

    Newton's method starts at many states. Branches are followed by pseudo-arclength in both directions from all that
    it finds at the system's own value of the parameter, onto those that cross them, and into other modes at guards.

    Returns
    -------
    xarray.Dataset
        Over ``point``, one an equilibrium: ``equilibrium_state`` and ``equilibrium_error`` (state), ``mode``,
        ``pseudo``, ``admissible`` (admissible, virtual or boundary), ``guard`` (which one is crossed or met), ``type``
        (node, focus, saddle, saddle_focus, centre, degenerate), ``stable``, and ``eigenvalue_real``,
        ``eigenvalue_imag``, ``eigenvalue_error`` (eigenvalue) of the ``free`` directions. ``starts_led`` counts the
        starts that led to each. ``outcome`` says whether there is any; the attribute ``message`` why a mode has none,
        which states have no eigenvalue, and how likely it is that more starts would find others.

        With ``sweep``, over the points of all branches: the parameter under its name, ``branch``, ``arclength``,
        ``special_point``. Of each branch ``branch_parent``, ``branch_start``, ``branch_end`` and ``branch_end_text``
        (branch_number). Of each special point ``special_index``, ``special_kind`` (fold, branch_point, hopf,
        boundary), ``special_value``, ``special_error``, ``special_multiplicity``, ``special_text`` (special). At a
        Hopf point the frequency ``special_frequency`` and the first Lyapunov coefficient ``special_coefficient``, with
        ``special_coefficient_error``, whose sign is ``special_criticality``: "undecided" where its error includes
        zero. It is exact up to rounding, since derivatives are taken of the expressions, and in units of the states
        (the eigenvector has length 1). A start for the cycle that is born there: ``cycle_state`` and
        ``cycle_amplitude`` (state), ``cycle_period``, at the parameter ``cycle_value``, from which `periodic_orbit` and
        `continue_orbit` go on with ``start="guess"``. At a boundary ``special_beyond``: whether an equilibrium of
        another mode goes on from there (persistence), or meets this one so that both vanish (nonsmooth fold).

    Raises
    ------
    SettingsError
        An argument that cannot be used; a map, or a system that depends on time.

    References
    ----------
    Yu. A. Kuznetsov, "Elements of Applied Bifurcation Theory", 4th ed., Springer 2023,
    doi:10.1007/978-3-031-22007-4: Hopf points. M. di Bernardo, A. Nordmark, G. Olivar, "Discontinuity-induced
    bifurcations of equilibria in piecewise-smooth and impacting dynamical systems", Physica D 237 (2008) 119-136,
    doi:10.1016/j.physd.2007.08.008: what follows at boundaries. H. B. Keller 1977: pseudo-arclength.
    """
    import numpy as np

    from chaosdrill.analysis.equilibria_datasets import branches_dataset, equilibria_dataset
    from chaosdrill.equilibrium.branches import Task, branches
    from chaosdrill.equilibrium.search import search

    starts, sizes, within_ = _starts(system, given, job)
    modes = given.modes or system.mode_names
    found = search(system, modes, starts, sizes, within_)
    if given.sweep is None:
        return equilibria_dataset(system, found)
    ((name, limits),) = given.sweep.items()
    step = STEP if given.step is None else float(given.step) / (limits[1] - limits[0])
    task = Task(system, name, (float(limits[0]), float(limits[1])), np.asarray(sizes), step, given.max_points)
    followed = branches(task, found.equilibria, job.report(max(len(found.equilibria), 1)))
    return branches_dataset(system, task, found, followed)


def _starts(
    system: HybridSystem, given: Equilibria, job: Job
) -> "tuple[np.ndarray, np.ndarray, dict[int, tuple[float, float]]]":
    """Where Newton's method starts (S, n), how large the states are (n,), and the limits of those that have some."""
    import numpy as np
    from scipy.stats.qmc import Halton

    from chaosdrill.analysis.seeds import make_seeds
    from chaosdrill.orbits.sizes import sizes_beside

    names, region = list(system.state_names), given.region or {}
    own = np.array([system.initial_values])
    seen = own if set(region) >= set(names) else _motion(system, job)
    low, high = seen.min(axis=0), seen.max(axis=0)
    extent = high - low
    low, high = low - extent, high + extent
    limits = {names.index(name): (float(one[0]), float(one[1])) for name, one in region.items()}
    for i, one in limits.items():
        low[i], high[i] = one
    sizes = np.maximum((high - low) / 2, np.abs(seen).max(axis=0) * [i not in limits for i in range(len(names))])
    # a state that is zero and stays there has no size of its own
    sizes = sizes_beside(system, job.numerics, sizes)
    sizes = np.where(sizes > 0, sizes, 1.0)
    spread = low + (high - low) * Halton(len(names), scramble=False).random(given.starts + 1)[1:]
    seeds = make_seeds(system, given.seeds, None, needed=False).starts
    return np.vstack([own, seeds, spread]), sizes, limits


def _motion(system: HybridSystem, job: Job) -> "np.ndarray":
    """States along the motion from the initial state, shape (m, n), as long as it goes on."""
    import numpy as np

    from chaosdrill.analysis.recording import time_of_motion
    from chaosdrill.dataset import Outcome
    from chaosdrill.engine.run import Run

    run = Run(system, time_of_motion(system, job.numerics), job.numerics)
    points = [run.x.copy()]
    while len(points) < 64 and run.advance(1)[0] == Outcome.OK:
        points.append(run.x.copy())
    return np.array(points)
