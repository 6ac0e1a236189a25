"""Periodic orbits, stable or not: from a guess, from an attractor, or all up to a period."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from chaosdrill.analysis.arguments import LONGEST_PERIOD, PARAMETERS, chosen
from chaosdrill.analysis.base import ORBITS, Dataset, HybridSystem, Job, Orbit, analysis
from chaosdrill.analysis.functions import (
    FUNCTIONS,
    function_columns,
    functions_of,
    misfits_of_functions,
    values_on,
    with_functions,
)
from chaosdrill.analysis.starting_states import RANDOM, SEEDS
from chaosdrill.dataset.schema import (
    ITERATE,
    MULTIPLIER,
    ORBIT,
    STATES,
    axis,
    derivatives,
    forcing,
    may,
    need,
    of_orbits,
    outcome,
    rates,
    table,
)
from chaosdrill.settings import Choice, Faults, Known, Whole, setting, told

VARIABLES = table(
    *STATES,
    MULTIPLIER,
    ITERATE,
    *of_orbits(ORBIT),
    axis("orbit", "orbit", "i4", "index of the orbit", "Number of the orbit found by a search, from 1."),
    axis("iteration", "iteration", "i4", "index of the iteration", "Steps of Newton's method taken, from 0."),
    need("mode", ORBIT, "i1", "mode of the orbit", "In its state; -1: no orbit.", flags="mode", lacking=True),
    need("period", ORBIT, "i4", "period", "Least one, in forcing periods or points of the section; 0: no orbit."),
    need("rank", ORBIT, "i4", "rank", "Rank of the tangent map over one period, and number of finite exponents."),
    need("stable", ORBIT, "i1", "stable", "Whether small deviations from the orbit die out.", flags="truth"),
    need("newton_residual", f"{ORBIT} iteration", "f8", "residual of Newton's method", "NaN after the last step."),
    need("event_count", ORBIT, "i4", "events in one period", "The entries of event beyond it are empty."),
    need("event_time", f"{ORBIT} event", "f8", "time of the event", "Since the orbit's state, within one period."),
    need("event_kind", f"{ORBIT} event", "i1", "transition taken", "-1: no event.", flags="transition", lacking=True),
    need("event_speed", f"{ORBIT} event", "f8", "normal speed", "Rate of the guard at the event, as in `trajectory`."),
    need("event_state_before", f"{ORBIT} event state", "f8", "state before the event", "Projected onto the guard."),
    need("event_state_after", f"{ORBIT} event state", "f8", "state after the event", "After the reset."),
    may("path_time", f"{ORBIT} path_point", "f8", "time on the path", "The same on both sides of an event."),
    may(
        "path_state",
        f"{ORBIT} path_point state",
        "f8",
        "state on the path",
        "Neighbours may be joined by straight lines.",
    ),
    *rates(ORBIT),
    *derivatives(ORBIT, events=True),
    *function_columns(ORBIT),
    need(
        "lyapunov_exponent",
        f"{ORBIT} multiplier",
        "f8",
        "Lyapunov exponent",
        "By QR over the orbit, descending; of multipliers of nearly the same modulus QR gives the mean.",
    ),
    need("exponent_difference", ORBIT, "f8", "exponents against multipliers", "Largest difference between the two."),
    need("determinant_difference", ORBIT, "f8", "sum rule", "Relative: multipliers against contractions on the way."),
    need("recurrence_difference", ORBIT, "f8", "recurrence", "Distance after one more period, as the residual."),
    need("consistent", ORBIT, "i1", "agrees with itself", "Whether these differences are explained.", flags="truth"),
    outcome(ORBIT),
    *forcing(),
    magnitude=("residual", "newton_residual", "exponent_difference", "determinant_difference", "recurrence_difference"),
    bars={"function_value": "function_error"},
)


_OF_SEARCH = 'applies with start = "search" only'
_OF_ONE = {
    "period": 'start = "search" looks for all up to max_period',
    "at": 'start = "search" counts forcing periods, or the most frequent event of each orbit',
}
"""Settings of a single orbit, with the reason for which a search takes none of them."""


@dataclass(frozen=True, kw_only=True)
class PeriodicOrbit(Orbit):
    """Settings of `periodic_orbit`."""

    start: str = setting(
        Choice(("attractor", "guess", "search")),
        "attractor",
        doc="Where Newton's method starts: at the state of a run after ``transient``; at the system's initial "
        "state (at phase 0); or at many states, to find all orbits up to ``max_period``.",
    )
    max_period: int | None = setting(
        Whole(1, LONGEST_PERIOD),
        None,
        doc="Longest period of a search, in forcing periods. Without forcing: how often the most frequent event "
        "of an orbit may occur in one revolution; without events, how many maxima it may have.",
    )
    seeds: list[dict[str, Any]] | None = setting(
        SEEDS,
        None,
        doc="Initial states of the runs whose close returns start a search; default: the system's own. Runs "
        "from a box around them are added. If motions escape, loops are also composed of pieces of several of "
        "them; a seed must meet an event before it escapes.",
    )
    random: dict[str, Any] | None = setting(
        RANDOM,
        None,
        doc='Further seeds, ``{"count": 4, "seed": 1, "y": (-1, 1)}``: ``count`` states drawn uniformly from '
        "the box, by a generator with this ``seed``.",
    )
    derivatives: bool | list[str] = setting(
        PARAMETERS,
        False,
        doc="Parameters with respect to which start, times, mean rates, multipliers and exponents are "
        "differentiated; True for all.",
    )
    functions: dict[str, Any] | None = setting(FUNCTIONS, None, doc="Functions of the orbit, as in `continue_orbit`.")

    @classmethod
    def misfits(cls, table: Mapping[str, Any], system: HybridSystem) -> Faults:
        """Functions of what the system does not have."""
        yield from super().misfits(table, system)
        yield from misfits_of_functions(table, system)

    @classmethod
    def together(cls, table: Mapping[str, Any], known: Known) -> Faults:
        """Settings that only a search takes, or does not take, and a search without a longest period."""
        searches = table.get("start") == "search"
        if searches and "max_period" not in table:
            yield ("max_period",), 'missing; start = "search" needs the longest period to look for'
        unused = _OF_ONE if searches else dict.fromkeys(("max_period", "seeds", "random"), _OF_SEARCH)
        for name, words in unused.items():
            if name in table:
                yield (name,), told(f"{words}; leave it out", table[name])


@analysis(
    "periodic-orbit",
    PeriodicOrbit,
    "an orbit, stable or not, or all up to a period; multipliers and events",
    VARIABLES,
    cites=ORBITS,
)
def periodic_orbit(system: HybridSystem, given: PeriodicOrbit, job: Job) -> Dataset:
    """A periodic orbit, or all orbits that a search finds, with Floquet multipliers, events and consistency checks.

    An orbit is a closed chain of segments between events. Newton's method solves for the initial states and durations
    of all segments together (multiple shooting), with derivatives from the tangents; it converges quadratically, to
    unstable orbits as well. The result is verified by an ordinary run, which must return and meet the same events in
    the same order; otherwise no orbit is reported.

    Returns
    -------
    xarray.Dataset
        ``orbit_state`` (state) and ``mode`` at phase 0 or, without forcing, after an event, if there are any, so that a
        run can start there; ``section`` (iterate, state), the points of one period at the strobes or before the events
        of ``at``, as in `poincare_section`; ``period`` (0: no orbit) and ``period_time``; ``multiplier_real`` and
        ``multiplier_imag`` (multiplier), those of lost rank exactly 0, ``rank``, ``stable``; ``event_time``,
        ``event_kind``, ``event_speed`` (event), ``event_state_before`` and ``event_state_after`` (event, state),
        ``smallest_speed``; the whole path as points that straight lines may join, ``path_time`` (path_point) and
        ``path_state`` (path_point, state), with both sides of an event at one time; mean rates over the period, such as
        ``progression_rate`` and ``impacts_per_period``; with ``functions``, ``function_value`` and ``function_error``
        (function); ``residual``, and ``newton_residual`` (iteration); ``lyapunov_exponent`` (multiplier) and the
        discrepancies found by the checks: ``exponent_difference``, ``determinant_difference``,
        ``recurrence_difference``, ``consistent``; ``drift`` and ``drift_error`` (state), the shift of the end against
        the start where the system is invariant under shifts, as in the position of a runner, or whole turns of an
        angle; ``neutral``, the number of multipliers that are 1 by the structure of the system (described in the
        attribute ``structure``) or by a quantity found to be conserved (described in the ``message``); ``outcome``, in
        words in the attributes ``message`` and ``disagreement``. A search adds the leading dimension ``orbit``.

        With ``derivatives``, over the last dimension ``parameter`` (values in ``parameter_value``), each with its
        ``.._error``, a bound: ``orbit_state_derivative``, ``period_time_derivative``, ``event_time_derivative``,
        ``multiplier_real_derivative``, ``multiplier_imag_derivative``, ``lyapunov_exponent_derivative``, and that of
        the mean rate of every quadrature, such as ``progression_rate_derivative``. They are exact: the linearised
        equations of all segments are solved for the change of the orbit, and carried tangents give second variations
        across events. NaN, with the reason in the attribute ``derivatives_message``, where they do not exist: at
        grazing, at a fold, and where a conserved quantity makes the orbit one of a family. Only orbits have
        derivatives, not means of a chaotic motion.

    References
    ----------
    F. Dercole, Yu. A. Kuznetsov, "SlideCont: an Auto97 driver for bifurcation analysis of Filippov systems", ACM
    Trans. Math. Softw. 31 (2005) 95-119, doi:10.1145/1055531.1055536: orbits as arcs between events. M. di Bernardo,
    C. J. Budd, A. R. Champneys, P. Kowalczyk, "Piecewise-smooth Dynamical Systems", Springer 2008,
    doi:10.1007/978-1-84628-708-4: tangents across events. K. A. Khan, V. P. Saxena, P. I. Barton, "Sensitivity
    analysis of limit-cycle oscillating hybrid systems", SIAM J. Sci. Comput. 33 (2011) 1475-1504,
    doi:10.1137/100804632: derivatives by parameters.
    """
    from chaosdrill.analysis.orbit_datasets import NOT_OF_CHAOS, numbered, orbit_rates, orbits_dataset, with_derivatives
    from chaosdrill.analysis.orbit_start import orbit_start
    from chaosdrill.analysis.seeds import make_seeds
    from chaosdrill.analysis.starts import settled_modes
    from chaosdrill.dataset import Outcome
    from chaosdrill.dataset.build import first, more, variable
    from chaosdrill.orbits.find import find_orbit
    from chaosdrill.orbits.neutral import neutral_of
    from chaosdrill.orbits.results import underived
    from chaosdrill.orbits.search import search

    names = chosen(system, given.derivatives)
    if given.max_period is not None:
        seeds = make_seeds(system, given.seeds, given.random, needed=False)
        modes = settled_modes(system, seeds.starts, seeds.modes)
        found = search(system, given.max_period, seeds.starts, modes, job.numerics, job.progress, names)
        message = numbered(orbit.message for orbit in found)
        if not found:
            message = f"no orbit of a period up to {given.max_period} was found; "
            message += "give other seeds, or random states of a larger box"
        disagreement = numbered(orbit.checks.disagreements for orbit in found)
    else:
        begin = orbit_start(system, given, job.numerics)
        where = (begin.system, begin.period, begin.start, begin.transient)
        found = [find_orbit(*where, job.numerics, begin.marks, names)]
        if begin.marks is not None and found[0].outcome == Outcome.PERIODIC:
            found = [replace(found[0], period=max(1, len(found[0].section)))]
        found = [replace(found[0], message=begin.told(found[0].outcome, found[0].message))]
        message, disagreement = found[0].message, found[0].checks.disagreements
    ds = more(orbits_dataset(system, found), orbit_rates(system, found, job.numerics))
    functions = functions_of(system, given.functions)
    ds = with_functions(ds, functions, "orbit", *values_on(functions, found))
    words = neutral_of(system).words(system, int(ds["neutral"]))
    told = {"message": message, "disagreement": disagreement, "structure": words}
    if names:
        empty = underived(system, len(names), 0, NOT_OF_CHAOS)
        derived = [empty if one.derived is None else one.derived for one in found]
        ds = with_derivatives(ds, system, names, derived, "orbit")
        ds = ds.assign_coords(parameter_value=variable("parameter", [system.parameters[name] for name in names]))
        remarks = [one.message for one in derived]
        told["derivatives_message"] = remarks[0] if given.max_period is None else numbered(remarks)
    return (ds if given.max_period is not None else first(ds, "orbit")).assign_attrs(told)
