"""Charts over two parameters: period, exponents, rates, outcome, and how many attractors there are."""

import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from chaosdrill.analysis.arguments import Progress, settings, whole
from chaosdrill.analysis.grids import listed, parameter_axes
from chaosdrill.analysis.plan import make_plan
from chaosdrill.analysis.points import PointTask
from chaosdrill.analysis.seeds import make_seeds
from chaosdrill.dataset import label
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.period import forcing_periods
from chaosdrill.engine.run import rate_names
from chaosdrill.sweep import execute

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem


def parameter_chart(
    system: "HybridSystem",
    sweep: Mapping[str, Any],
    *,
    transient: int,
    periods: int,
    seeds: Sequence[Mapping[str, Any]] | None = None,
    random: Mapping[str, Any] | None = None,
    exponents: int | None = None,
    at: str = "strobe",
    max_period: int = 64,
    patience: int = 8,
    section_points: int = 0,
    workers: int = 1,
    scheduler: str | None = None,
    store: str | os.PathLike[str] | None = None,
    method: str = "taylor",
    tolerance: float = 1e-12,
    steps: int | None = None,
    max_events: int | None = None,
    max_stalls: int = 50,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Period, spectrum, mean rates and outcome over two parameters.

    Every point is judged as in `bifurcation_diagram`, from the same seeds, and is a run of its own. Attractors that
    several seeds of a point lead to are counted once.

    Parameters
    ----------
    system : HybridSystem
        System with its parameters and initial state; it must have a forcing period.
    sweep : mapping of two parameters to values
        ``{"eta": np.linspace(0.4, 0.9, 500), "b": np.linspace(0.5, 0.9, 400)}``.
    transient, periods : int
        As in `bifurcation_diagram`.
    seeds, random : optional
        As in `bifurcation_diagram`.
    exponents, at, max_period, patience : optional
        As in `bifurcation_diagram`.
    section_points : int, default 0
        How many section points of every run are kept, its last ones; a report shows them at a click.
    workers, scheduler, store : optional
        As in `bifurcation_diagram`.
    method, tolerance, steps, max_events, max_stalls, progress : optional
        As in `trajectory`; ``progress`` gets the outcomes counted so far.

    Returns
    -------
    xarray.Dataset
        Over both parameters and seed: ``period``, ``lyapunov_exponent`` and ``lyapunov_error`` (exponent), mean rates,
        ``outcome``, and ``section`` (iterate, state) if it is asked for; over both parameters ``attractor_count`` and
        ``forcing_period``; ``initial_state`` (seed, state).
        NaN, and the period 0, where a point has no result.

    Raises
    ------
    SettingsError
        An argument that cannot be used, or a ``store`` that holds chunks of another call.
    ArchiveError
        If the ``store`` cannot be written, or another call uses it.
    ChaosdrillError
        If the scheduler cannot be reached or is lost, or if its workers have other versions.
    """
    given = settings(dict(locals()))
    axes = parameter_axes(system, sweep, 2, "a parameter chart")
    names = tuple(axis.name for axis in axes)
    chosen = make_seeds(system, seeds, random)
    given |= {"sweep": listed(axes), **chosen.settings}
    plan = make_plan(
        system,
        names,
        transient=transient,
        periods=periods,
        exponents=exponents,
        at=at,
        max_period=max_period,
        patience=patience,
        numerics=Numerics(method, tolerance, steps, max_events, max_stalls),
        rows=whole("section_points", section_points, 0),
    )
    keeps = ("period", "outcome", *(("lyapunov_exponent", "lyapunov_error") if plan.exponents else ()))
    keeps += rate_names(system)
    keeps += ("section",) if plan.rows else ()
    task = PointTask(plan, axes, chosen.starts, chosen.modes, keeps, counts_attractors=True)
    found = execute(task, workers=whole("workers", workers, 1), scheduler=scheduler, store=store, progress=progress)
    over = (*names, "seed")
    dims = {"section": ("iterate", "state"), "lyapunov_exponent": ("exponent",), "lyapunov_error": ("exponent",)}
    variables = {
        name: ((*over, *dims.get(name, ())), found[name].reshape(*task.shape, *found[name].shape[1:])) for name in keeps
    }
    variables["attractor_count"] = (names, found["attractor_count"].reshape(task.shape))
    variables["initial_state"] = (("seed", "state"), chosen.starts)
    grid = dict(zip(names, (g.ravel() for g in np.meshgrid(*(a.values for a in axes), indexing="ij")), strict=True))
    variables["forcing_period"] = (names, forcing_periods(system, grid, task.units).reshape(task.shape))
    coords: dict[str, Any] = {
        **{axis.name: axis.values for axis in axes},
        "seed": np.arange(len(chosen.starts), dtype=np.int32),
        "seed_name": ("seed", list(chosen.names)),
        "state_name": ("state", list(system.state_names)),
    }
    if plan.rows:
        coords["iterate"] = np.arange(plan.rows, dtype=np.int32)
    if plan.exponents:
        coords["exponent"] = np.arange(1, plan.exponents + 1, dtype=np.int32)
    return label(xr.Dataset(variables, coords=coords), "parameter-chart", system=system, settings=given)
