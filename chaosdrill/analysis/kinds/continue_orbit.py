"""Branches of periodic orbits along a parameter, and curves of their special points in two."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from chaosdrill.analysis.arguments import PARAMETERS, Ranges, chosen
from chaosdrill.analysis.base import ORBITS, Dataset, HybridSystem, Job, Orbit, analysis
from chaosdrill.analysis.functions import (
    FUNCTIONS,
    LEVELS,
    OPTIMA,
    function_columns,
    functions_of,
    misfits_of_functions,
    unnamed,
    with_functions,
)
from chaosdrill.dataset.branches import BranchEnd, Criticality, Onset, Special
from chaosdrill.dataset.outcomes import Outcome
from chaosdrill.dataset.schema import (
    ITERATE,
    MULTIPLIER,
    PENETRATION,
    QUADRATURE,
    STATES,
    SWEEP,
    axis,
    derivatives,
    may,
    mean_rate,
    need,
    of_orbits,
    table,
)
from chaosdrill.settings import Choice, Faults, Known, Number, Whole, setting, told

FOLLOW = (
    *("fold", "period_doubling", "neimark_sacker", "grazing", "crossing_sliding", "switching_sliding"),
    *("level", "optimum"),
)
"""Special points that can be followed in two parameters."""

MOST_DOUBLINGS = 12
"""Doubled branches followed in a row: period 4096 times the first."""

STEP = 1 / 200
"""Default of the largest step, as a fraction of the parameter's range."""

_STABLE = "Whether small deviations die out; on a curve: by all multipliers but those on the unit circle."
_BORN = "Whether what is born there attracts (supercritical, soft) or repels (subcritical, hard)."
_COEFFICIENT = "On the centre manifold, above 0 where supercritical; for an eigenvector of mean square 1 on the orbit."
_ONSET = "Of the attractor beside a stable orbit, by the returns after the event."
_POWER = "Of the return map where a guard is met at no speed, y > 0 where the event happens; NaN: not known, or none."
_GRAZING = "What that power adds to the guard's next greatest value, in units of the guard."
_RETURN = "Of a jump the first return above the guard; undecided: the first as high as the guard, a resonance; else 0."
_SPECIAL = "What happens there; the names are in flag_meanings."

VARIABLES = table(
    *STATES,
    MULTIPLIER,
    ITERATE,
    *of_orbits("point"),
    axis("branch_number", "branch_number", "i4", "number of the branch", "From 0.", True),
    need(SWEEP, "point", "f8", "free parameter", "Its value at each point."),
    need("branch", "point", "i4", "branch", "Number of the branch that the point belongs to."),
    need("arclength", "point", "f8", "arclength", "Along the branch, from its start."),
    need("mode", "point", "i1", "mode of the orbit", "Mode that holds in its state.", flags="mode"),
    need("period", "point", "i4", "period", "In forcing periods; without forcing in periods of the first branch."),
    need("stable", "point", "i1", "stable", _STABLE, flags="truth"),
    need("special_point", "point", "i1", "special point", _SPECIAL, flags=Special),
    need("sequence", "point", "i4", "sequence of events", "Number of the entry of event_sequence."),
    axis("event_sequence", "sequence_number", "str", "sequence of events", "Transitions of a period in order.", True),
    *mean_rate(PENETRATION, "point"),
    *mean_rate(QUADRATURE, "point"),
    *derivatives("point", events=False),
    need("branch_parent", "branch_number", "i4", "parent branch", "The one that it branches off; -1: none."),
    need("branch_period", "branch_number", "i4", "period of the branch", "As the variable period."),
    axis("branch_start", "branch_number", "str", "start of the branch", "In words.", True),
    need("branch_end", "branch_number", "i1", "end of the branch", "As a code.", flags=BranchEnd),
    axis("branch_end_text", "branch_number", "str", "end of the branch", "In words.", True),
    need("branch_length", "branch_number", "f8", "length of the branch", "The arclength of its last point."),
    need("special_index", "special", "i4", "point of the special point", "Its place in the dimension point, from 0."),
    need("special_kind", "special", "i1", "kind of the special point", _SPECIAL, flags=Special),
    need("special_value", "special", "f8", "parameter at the special point", "Of two, the first."),
    may("special_value_2", "special", "f8", "second parameter there", "Of a curve in two parameters."),
    need("special_error", "special", "f8", "error of the special point", "Estimated, of special_value."),
    need("special_multiplicity", "special", "i4", "multipliers on the unit circle", "Their number; 0 at events."),
    need("special_criticality", "special", "i1", "soft or hard", _BORN, flags=Criticality),
    need("special_coefficient", "special", "f8", "cubic coefficient", _COEFFICIENT),
    need("special_coefficient_error", "special", "f8", "error of the cubic coefficient", "Estimated; NaN without one."),
    need("special_onset", "special", "i1", "what follows grazing", _ONSET, flags=Onset),
    need("special_power", "special", "f8", "power of the guard's height", _POWER),
    need("grazing_coefficient", "special", "f8", "coefficient of that power", _GRAZING),
    need("grazing_coefficient_error", "special", "f8", "error of that coefficient", "Estimated; NaN without one."),
    need("special_return", "special", "i4", "decisive return", _RETURN),
    axis("special_text", "special", "str", "what happens at the special point", "In words.", True),
    may("doubling_value", "doubling", "f8", "parameter at the doubling", "Of the cascade, in order."),
    may("doubling_period", "doubling", "i4", "period that doubles", "As the variable period."),
    may("feigenbaum_ratio", "doubling", "f8", "ratio of distances", "Tends to 4.669; NaN for the first two."),
    may("accumulation", "", "f8", "accumulation point", "Where the period doublings lead."),
    may("accumulation_error", "", "f8", "error of the accumulation point", "Estimated from the last ratios."),
    *function_columns("point"),
    need("outcome", "", "i1", "outcome", "Of the search for the orbit from which the branch starts.", flags=Outcome),
    magnitude=(
        "residual",
        "special_error",
        "special_coefficient_error",
        "grazing_coefficient_error",
        "accumulation_error",
    ),
    bars={"special_value": "special_error", "function_value": "function_error"},
)


@dataclass(frozen=True, kw_only=True)
class Continuation(Orbit):
    """Settings of `continue_orbit`."""

    meanings: ClassVar[Mapping[str, str]] = {
        "period": "Period of the orbit at the start, in forcing periods; without forcing in points of the "
        "section ``at``."
    }

    sweep: dict[str, Any] = setting(
        Ranges("parameter", 1, 2, "give one parameter, or two for a curve (follow=)"),
        positional=True,
        doc='``{"eta": (0.40, 0.90)}``: the branch starts at the system\'s own value and is followed in both '
        "directions to these limits. A curve (``follow``) needs two parameters: its first point is searched for "
        "along the first one, with the second at the system's own value.",
    )
    start: str = setting(
        Choice(("attractor", "guess")),
        "attractor",
        doc="How the first orbit is found: at the state of a run after ``transient``, or at the system's "
        "initial state (at phase 0).",
    )
    doublings: int = setting(
        Whole(0, MOST_DOUBLINGS),
        0,
        doc="Number of successive branches of doubled period to follow, each from the first period doubling "
        "met. A branch that crosses the first one, for example where an orbit loses its symmetry, is followed "
        "on either side, and so are its doublings.",
    )
    follow: str | None = setting(
        Choice(FOLLOW, ", or leave it out for a branch"),
        None,
        doc="The special point to follow in two parameters; the last two are those of ``levels`` and "
        "``optima``. Points of codimension two on the curve are located: cusps, strong resonances, generalised "
        "flips, Chenciner points, and where two conditions meet.",
    )
    step: float | None = setting(
        Number(above=0.0),
        None,
        doc="Largest step in the parameter, the first of two; default 1/200 of its range.",
    )
    max_points: int = setting(
        Whole(2, 1_000_000), 2000, doc="Largest number of points of a branch on either side of its start."
    )
    derivatives: bool | list[str] = setting(
        PARAMETERS,
        False,
        doc="Parameters with respect to which the orbit of every point is differentiated, as in "
        "`periodic_orbit`; True for all.",
    )
    functions: dict[str, Any] | None = setting(
        FUNCTIONS,
        None,
        doc='Functions of the orbit: ``{"force": {"of": "k*(y - d)", "take": "maximum"}}``. ``of`` is an '
        "expression of states, time and parameters, in which a quadrature stands for its rate; ``take`` is "
        '"mean" (default), "total", "maximum" or "minimum" over one period of the orbit. With ``at``, the name '
        "or kind of an event, only the states before these events are used; with ``modes``, a list, only these "
        "modes: elsewhere the function is zero for a mean or total, and ignored for an extreme. ``units`` is "
        "kept. ``of``, or the table itself, may be a Python function of an "
        "`chaosdrill.orbits.orbit_record.OrbitRecord` (times, states, events, multipliers) that returns a "
        "number; where it raises an exception it is NaN, and ``functions_message`` says which.",
    )
    levels: dict[str, Any] | None = setting(
        LEVELS,
        None,
        doc='Special points are where the function takes one of these values. With ``follow="level"`` one '
        "function is held at one value over two parameters.",
    )
    optima: list[str] | None = setting(
        OPTIMA,
        None,
        doc="Functions whose largest and smallest values along a branch are special points. With "
        '``follow="optimum"`` those of one function over the first parameter are followed as the second varies. '
        "Along a curve they are optima under its condition: of a held value, or over both parameters where the "
        "curve is one of optima.",
    )

    @classmethod
    def together(cls, table: Mapping[str, Any], known: Known) -> Faults:
        """A curve without two parameters and a point to follow, a branch with them, and too long a step."""
        names, follow = list(table["sweep"]), table.get("follow")
        if follow is None and len(names) == 2:
            yield ("follow",), f"missing, though sweep names two parameters; expected one of {list(FOLLOW)}"
        elif follow is not None and len(names) == 1:
            yield ("follow",), told(f"sweep names only {names[0]!r}; name the second parameter too", follow)
        elif follow is not None and table.get("doublings"):
            yield ("doublings",), told("a curve in two parameters has none; leave it out", table["doublings"])
        yield from unnamed(table)
        wished = [len(one) for one in (table.get("levels") or {}).values()]
        if follow == "level" and wished != [1]:
            yield ("levels",), 'follow = "level" needs one level of one function, as in levels.force = [2.5]'
        elif follow == "optimum" and len(table.get("optima") or ()) != 1:
            yield ("optima",), 'follow = "optimum" needs the name of one function, as in optima = ["rate"]'
        first = table["sweep"][names[0]]
        room = abs(first["stop"] - first["start"])
        if table.get("step", 0) > room:
            yield ("step",), told(f"is longer than the whole range of {names[0]!r}, which is {room:g}", table["step"])

    @classmethod
    def misfits(cls, table: Mapping[str, Any], system: HybridSystem) -> Faults:
        """Functions of names that the system does not have."""
        yield from super().misfits(table, system)
        yield from misfits_of_functions(table, system)

    @property
    def room(self) -> float:
        """Range of the first parameter."""
        low, high = next(iter(self.sweep.values()))
        return float(high - low)


@analysis(
    "continuation",
    Continuation,
    "branches of orbits along a parameter with their special points; curves in two",
    VARIABLES,
    cites=(*ORBITS, "keller1977"),
)
def continue_orbit(system: HybridSystem, given: Continuation, job: Job) -> Dataset:
    """A branch of stable and unstable periodic orbits along a parameter, or a curve of special points in two.

    Pseudo-arclength continuation of the segments between events, which passes folds. Multipliers, the event sequence
    and the normal speeds at guards are monitored; folds, period doublings, Neimark-Sacker points, grazing and other
    changes of the event sequence are located. At such a change the branch continues with the new sequence if an orbit
    with it exists nearby; otherwise it ends there, with the reason.

    Returns
    -------
    xarray.Dataset
        Over ``point``, with all branches in sequence: the parameters under their own names, ``branch``, ``arclength``;
        ``orbit_state`` (state), ``mode``, ``section`` (iterate, state; NaN beyond the points of an orbit), ``period``
        and ``period_time`` as in `periodic_orbit`; ``multiplier_real`` and ``multiplier_imag`` (multiplier),
        ``stable``, ``special_point``, ``sequence``, ``smallest_speed``, ``residual``; ``event_sequence``
        (sequence_number). Of each branch ``branch_parent``, ``branch_period``, ``branch_start``, ``branch_end``,
        ``branch_end_text`` and ``branch_length`` (branch_number). Of each special point ``special_index``,
        ``special_kind``, ``special_value``, ``special_error``, ``special_multiplicity``, ``special_text`` (special),
        and ``special_value_2`` on a curve; ``special_criticality`` says whether a doubling, a pitchfork or a
        Neimark-Sacker point is soft or hard, by the normal form's ``special_coefficient`` and
        ``special_coefficient_error``. Of a cascade ``doubling_value``, ``doubling_period``, ``feigenbaum_ratio``
        (doubling), ``accumulation`` and ``accumulation_error``. With ``functions``, ``function_value`` and
        ``function_error`` (point, function). ``outcome`` says whether a first orbit was found; the attribute
        ``message`` explains, and names places where the number of multipliers outside the unit circle changes without a
        special point.

        With ``derivatives`` also the mean rates, such as ``progression_rate``, and over ``point``, .., ``parameter``
        the derivatives of `periodic_orbit` with their errors, except those of the times of events;
        ``derivatives_message`` says at how many points they are missing, and why.

    References
    ----------
    H. B. Keller, "Numerical solution of bifurcation and nonlinear eigenvalue problems", in Applications of Bifurcation
    Theory, Academic Press 1977, 359-384: pseudo-arclength. M. di Bernardo, C. J. Budd, A. R. Champneys, P. Kowalczyk,
    "Piecewise-smooth Dynamical Systems", Springer 2008, doi:10.1007/978-1-84628-708-4: grazing and what follows it.
    """
    import numpy as np

    from chaosdrill.analysis.orbit_datasets import branches_dataset, branches_derived
    from chaosdrill.analysis.orbit_start import orbit_start
    from chaosdrill.orbits.branches import branches
    from chaosdrill.orbits.curves import curve
    from chaosdrill.orbits.functions import Wanted
    from chaosdrill.orbits.marks import Columns
    from chaosdrill.orbits.neutral import neutral_of

    begin = orbit_start(system, given, job.numerics)
    system = begin.system
    longest = STEP * given.room if given.step is None else float(given.step)
    names, limits = tuple(given.sweep), np.array(list(given.sweep.values()))
    start, points = (begin.period, begin.start, begin.transient), given.max_points
    functions = functions_of(system, given.functions)
    wanted = None if functions is None else Wanted(functions, given.levels or {}, given.optima or ())
    columns = Columns(begin.marks, wanted)
    if given.follow is None:
        ends = (float(limits[0, 0]), float(limits[0, 1]))
        result = branches(
            system, names[0], ends, *start, given.doublings, longest, points, job.numerics, job.progress, columns
        )
    else:
        both = (names[0], names[1])
        result = curve(system, both, limits, *start, given.follow, longest, points, job.numerics, job.progress, columns)
    ds = branches_dataset(system, result)
    ds = with_functions(ds, functions, "point", result.functions, result.function_errors)
    if by := chosen(system, given.derivatives):
        ds = branches_derived(ds, system, by, result)
    structure = neutral_of(system).words(system, result.neutral)
    return ds.assign_attrs(message=begin.told(result.outcome, result.message), structure=structure)
