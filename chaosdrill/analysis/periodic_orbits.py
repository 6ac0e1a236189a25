"""Periodic orbits, stable or not: from a guess, from an attractor, or all up to a period."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import xarray as xr

from chaosdrill.analysis.arguments import Progress, settings, whole
from chaosdrill.analysis.orbit_arguments import LONGEST_PERIOD, check_start, orbit_period, settling
from chaosdrill.analysis.orbit_datasets import numbered, orbit_rates, orbits_dataset
from chaosdrill.analysis.seeds import make_seeds
from chaosdrill.dataset import label
from chaosdrill.engine.numerics import Numerics
from chaosdrill.errors import SettingsError
from chaosdrill.orbits.find import find_orbit
from chaosdrill.orbits.neutral import neutral_of
from chaosdrill.orbits.search import search

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem

STARTS = ("attractor", "guess", "search")


def periodic_orbit(
    system: "HybridSystem",
    *,
    period: int = 1,
    start: str = "attractor",
    transient: float = 200,
    max_period: int | None = None,
    seeds: Sequence[Mapping[str, Any]] | None = None,
    random: Mapping[str, Any] | None = None,
    method: str = "taylor",
    tolerance: float = 1e-13,
    steps: int | None = None,
    max_events: int | None = None,
    max_stalls: int = 50,
    progress: Progress | None = None,
) -> xr.Dataset:
    """One periodic orbit, or all that a search finds, with multipliers, events and checks.

    An orbit is a cycle of arcs between events. Newton's method solves for the states at which the arcs begin and for
    their durations, all together (multiple shooting), with derivatives from the tangents: it converges quadratically,
    also onto an orbit that no trajectory stays near. What it finds is run once more by the ordinary engine, which must
    return and meet the same events in the same order; else it is not reported as an orbit.

    Parameters
    ----------
    system : HybridSystem
        System with its parameters and initial state.
    period : int, default 1
        Period in forcing periods; 1 for systems without forcing, whose orbit then is one round. An orbit whose least
        period is a part of it is reported with that one.
    start : {"attractor", "guess", "search"}
        Where Newton's method starts: from where a run has come to after ``transient``; from the system's initial state
        (at phase 0); or from many states, for all orbits up to ``max_period``.
    transient : int or float, default 200
        Forcing periods (without forcing: time, rounded up) to run first, for ``start="attractor"``.
    max_period : int, optional
        Longest period of a search, in forcing periods. Without forcing: how often the most frequent event of an orbit
        may happen in one round; without events too, how many maxima it may have.
    seeds, random : optional
        Initial states of the motions from whose returns a search starts, as in `bifurcation_diagram`; default: the
        system's own. Motions from a box around them are added.
    method, tolerance, steps, max_events, max_stalls, progress : optional
        As in `trajectory`, but the tolerance is 1e-13 unless another one is given.

    Returns
    -------
    xarray.Dataset
        ``orbit_state`` (state) and ``mode`` at phase 0, ``section`` (iterate, state), ``period`` (0: there is none) and
        ``period_time``; ``multiplier_real`` and ``multiplier_imag`` (multiplier), those of lost rank exactly 0,
        ``rank``, ``stable``; ``event_time``, ``event_kind``, ``event_speed`` (event), ``event_state_before`` and
        ``event_state_after`` (event, state), ``smallest_speed``; mean rates over the period, such as
        ``progression_rate`` and ``impacts_per_period``; ``residual``, and ``newton_residual`` (iteration);
        ``lyapunov_exponent`` (multiplier) and what the checks differ by: ``exponent_difference``,
        ``determinant_difference``, ``recurrence_difference``, ``consistent``; ``neutral``, how many multipliers are 1
        by the structure of the system, in words in the attribute ``structure``; ``outcome``, in words in the attributes
        ``message`` and ``disagreement``. A search adds the dimension ``orbit`` in front of all.

    Raises
    ------
    SettingsError
        An argument that cannot be used.

    References
    ----------
    F. Dercole, Yu. A. Kuznetsov, "SlideCont: an Auto97 driver for bifurcation analysis of Filippov systems", ACM
    Trans. Math. Softw. 31 (2005) 95-119, doi:10.1145/1055531.1055536: orbits as arcs between events. M. di Bernardo,
    C. J. Budd, A. R. Champneys, P. Kowalczyk, "Piecewise-smooth Dynamical Systems", Springer 2008,
    doi:10.1007/978-1-84628-708-4: tangents across events.
    """
    given = settings(dict(locals()))
    check_start(start, STARTS)
    numerics = Numerics(method, tolerance, steps, max_events, max_stalls)
    period = orbit_period(system, period)
    settle = settling(system, transient)
    if start == "search":
        longest = _longest(period, max_period)
        chosen = make_seeds(system, seeds, random, needed=False)
        given |= chosen.settings
        found = search(system, longest, chosen.starts, chosen.modes, numerics, progress)
        ds = orbits_dataset(system, found).assign(orbit_rates(system, found, numerics))
        message = numbered(orbit.message for orbit in found)
        if not found:
            message = (
                f"no orbit of a period up to {longest} was found; give other seeds, or random states of a larger box"
            )
        disagreement = numbered(orbit.checks.disagreements for orbit in found)
    else:
        for name, value in (("max_period", max_period), ("seeds", seeds), ("random", random)):
            if value is not None:
                raise SettingsError(f'{name} is {value!r}, but start is {start!r}; give it with start="search" only')
        orbit = find_orbit(system, period, start, settle, numerics)
        ds = orbits_dataset(system, [orbit]).assign(orbit_rates(system, [orbit], numerics)).isel(orbit=0, drop=True)
        message, disagreement = orbit.message, orbit.checks.disagreements
    ds = label(ds, "periodic-orbit", system=system, settings=given)
    structure = neutral_of(system).words(system)
    return ds.assign_attrs(message=message, disagreement=disagreement, structure=structure)


def _longest(period: int, max_period: Any) -> int:
    """Longest period of a search, checked."""
    if max_period is None:
        raise SettingsError('max_period is missing; with start="search" give the longest period to look for')
    if period != 1:
        raise SettingsError(f'period is {period}, but start is "search", which looks for all up to max_period; drop it')
    return whole("max_period", max_period, 1, LONGEST_PERIOD)
