"""Branches of periodic orbits followed in a parameter, and curves of their special points in two."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from chaosdrill.analysis.arguments import Progress, positive, real, settings, whole
from chaosdrill.analysis.orbit_arguments import check_start, orbit_period, settling
from chaosdrill.analysis.orbit_datasets import branches_dataset
from chaosdrill.dataset import label
from chaosdrill.dataset.schema import RESERVED
from chaosdrill.engine.numerics import Numerics
from chaosdrill.errors import SettingsError
from chaosdrill.orbits.branches import branches
from chaosdrill.orbits.curves import curve
from chaosdrill.orbits.neutral import neutral_of

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem

STARTS = ("attractor", "guess")

FOLLOW = ("fold", "period_doubling", "grazing")
"""Special points that can be followed in two parameters."""

MOST_DOUBLINGS = 12
"""Doubled branches followed in a row: period 4096 times the first."""

MOST_POINTS = 1_000_000

STEP = 1 / 200
"""Part of the parameter's range that is the largest step unless another one is given."""


def continue_orbit(
    system: "HybridSystem",
    sweep: Mapping[str, Any],
    *,
    period: int = 1,
    start: str = "attractor",
    transient: float = 200,
    doublings: int = 0,
    follow: str | None = None,
    step: float | None = None,
    max_points: int = 2000,
    method: str = "taylor",
    tolerance: float = 1e-13,
    steps: int | None = None,
    max_events: int | None = None,
    max_stalls: int = 50,
    progress: Progress | None = None,
) -> xr.Dataset:
    """A branch of periodic orbits along a parameter, stable or not, or a curve of special points in two parameters.

    Pseudo-arclength continuation of the arcs between events, so that the branch goes on around folds. Along the way
    multipliers, the sequence of events and the speeds at which guards are met are watched; folds, period doublings,
    Neimark-Sacker points, grazing and other changes of the events are located. Where the events change the branch goes
    on with the other sequence if there is an orbit with it, and ends there, and says so, if there is none.

    Parameters
    ----------
    system : HybridSystem
        System with its parameters and initial state.
    sweep : mapping of a parameter to its limits
        ``{"eta": (0.40, 0.90)}``: the branch starts at the system's own value and is followed both ways, to these
        limits. Two parameters for a curve (``follow``): the first point to follow is looked for along the first of
        them, with the second at the system's own value.
    period : int, default 1
        Period of the orbit at the start, in forcing periods; 1 for systems without forcing.
    start : {"attractor", "guess"}
        Where the orbit at the start is looked for, as in `periodic_orbit`.
    transient : int or float, default 200
        Forcing periods (without forcing: time, rounded up) to run first, for ``start="attractor"``.
    doublings : int, default 0
        How many times in a row the branch of doubled period is followed too, from the period doubling met first.
    follow : {"fold", "period_doubling", "grazing"}, optional
        The special point to follow in two parameters.
    step : float, optional
        Largest step in the parameter, of two in the first; default 1/200 of its range.
    max_points : int, default 2000
        Most points of a branch to either side of its start.
    method, tolerance, steps, max_events, max_stalls, progress : optional
        As in `trajectory`, but the tolerance is 1e-13 unless another one is given.

    Returns
    -------
    xarray.Dataset
        Over point, all branches one after the other: the parameters under their own names, ``branch``, ``arclength``,
        ``orbit_state`` (state), ``section`` (iterate, state), ``mode``, ``period``, ``multiplier_real`` and
        ``multiplier_imag`` (multiplier), ``stable``, ``special_point``, ``sequence``, ``smallest_speed``, ``residual``;
        ``event_sequence`` (sequence_number). Of each branch ``branch_parent``, ``branch_period``, ``branch_start``,
        ``branch_end`` and ``branch_end_text`` (branch_number). Of each special point ``special_index``,
        ``special_kind``, ``special_value``, ``special_error``, ``special_text`` (special), and ``special_value_2`` on
        a curve. Of a cascade ``doubling_value``, ``doubling_period``, ``feigenbaum_ratio`` (doubling),
        ``accumulation`` and ``accumulation_error``. ``outcome`` tells whether there was an orbit to start from, in
        words in the attribute ``message``.

    Raises
    ------
    SettingsError
        An argument that cannot be used.

    References
    ----------
    H. B. Keller, "Numerical solution of bifurcation and nonlinear eigenvalue problems", in Applications of Bifurcation
    Theory, Academic Press 1977, 359-384: pseudo-arclength. M. di Bernardo, C. J. Budd, A. R. Champneys, P. Kowalczyk,
    "Piecewise-smooth Dynamical Systems", Springer 2008, doi:10.1007/978-1-84628-708-4: grazing and what follows it.
    """
    given = settings(dict(locals()))
    limits = _limits(system, sweep)
    given["sweep"] = {name: list(pair) for name, pair in limits.items()}
    check_start(start, STARTS)
    numerics = Numerics(method, tolerance, steps, max_events, max_stalls)
    period = orbit_period(system, period)
    settle = settling(system, transient)
    doubled = whole("doublings", doublings, 0, MOST_DOUBLINGS)
    points = whole("max_points", max_points, 2, MOST_POINTS)
    names, pairs = tuple(limits), np.array(list(limits.values()))
    _check_follow(follow, names, doubled)
    longest = _longest_step(step, names[0], float(np.ptp(pairs[0])))
    if follow is None:
        ends = (float(pairs[0, 0]), float(pairs[0, 1]))
        result = branches(system, names[0], ends, period, start, settle, doubled, longest, points, numerics, progress)
    else:
        both = (names[0], names[1])
        result = curve(system, both, pairs, period, start, settle, follow, longest, points, numerics, progress)
    ds = label(branches_dataset(system, result), "continuation", system=system, settings=given)
    return ds.assign_attrs(message=result.message, structure=neutral_of(system).words(system))


def _limits(system: "HybridSystem", sweep: Any) -> dict[str, tuple[float, float]]:
    """The parameters and their limits, checked."""
    example = dict.fromkeys(list(system.parameters)[:1], (0.4, 0.9))
    if not isinstance(sweep, Mapping):
        raise SettingsError(f"sweep is {sweep!r}; it must be a parameter with its two limits, as in {example}")
    if len(sweep) not in (1, 2):
        raise SettingsError(f"sweep names {sorted(map(str, sweep))}; give one parameter, or two for a curve (follow=)")
    limits = {}
    for key, pair in sweep.items():
        name = str(key)
        if name not in system.parameters:
            raise SettingsError(
                f"sweep names {name!r}, which is no parameter of {system.name}: {sorted(system.parameters)}"
            )
        if name in RESERVED:
            raise SettingsError(f"sweep names {name!r}, which is reserved for results; rename the parameter")
        try:
            ends = [real(value) for value in pair]
        except TypeError:
            ends = []
        if isinstance(pair, str | Mapping) or len(ends) != 2 or not np.isfinite(ends).all():
            raise SettingsError(f"sweep of {name!r} is {pair!r}; it must be two finite numbers, as in {example}")
        low, high = sorted(ends)
        if low == high:
            raise SettingsError(f"sweep of {name!r} is {pair!r}; its two limits must differ")
        if not low <= system.parameters[name] <= high:
            raise SettingsError(
                f"{name} is {system.parameters[name]:g}, where the branch starts, but its limits are {pair!r}; "
                "give the system a value between them"
            )
        limits[name] = (low, high)
    return limits


def _longest_step(step: Any, name: str, span: float) -> float:
    """The largest step in the first parameter, checked."""
    longest = STEP * span if step is None else positive("step", step)
    if longest > span:
        raise SettingsError(f"step is {step!r}, longer than the whole range of {name!r}, which is {span:g}")
    return longest


def _check_follow(follow: Any, names: tuple[str, ...], doublings: int) -> None:
    """A curve needs two parameters and something to follow; a branch needs neither."""
    if follow is not None and (not isinstance(follow, str) or follow not in FOLLOW):
        raise SettingsError(f"follow is {follow!r}; expected one of {list(FOLLOW)}, or leave it out for a branch")
    if follow is not None and len(names) != 2:
        raise SettingsError(f"follow is {follow!r}, but sweep names only {names[0]!r}; name the second parameter too")
    if follow is None and len(names) == 2:
        raise SettingsError(f"sweep names {list(names)}, but follow is missing; expected one of {list(FOLLOW)}")
    if follow is not None and doublings:
        raise SettingsError(f"doublings is {doublings}, but a curve in two parameters has none; leave it out")
