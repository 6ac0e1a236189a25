"""Basins of attraction: which attractor each initial state of a grid leads to."""

import os
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from chaosdrill.analysis.arguments import Progress, settings, whole
from chaosdrill.analysis.attractors import number_attractors
from chaosdrill.analysis.grids import listed, state_axes
from chaosdrill.analysis.plan import make_plan
from chaosdrill.analysis.points import PointTask
from chaosdrill.dataset import label
from chaosdrill.engine.numerics import Numerics
from chaosdrill.errors import SettingsError
from chaosdrill.model.derive import pinned_states
from chaosdrill.sweep import execute

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem


def basins(
    system: "HybridSystem",
    grid: Mapping[str, Any],
    *,
    transient: int,
    periods: int,
    exponents: int | None = None,
    at: str = "strobe",
    max_period: int = 64,
    patience: int = 8,
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
    """Attractors reached from a grid of initial states, and the part of the grid that leads to each.

    Two runs are on one attractor if their kind and period are the same and their section points have the same moments:
    cycles within 2e-5 of their size, whatever the phase at which they are found; attractors that are no cycles within a
    fifth of their extent, with leading exponents that agree within eight standard errors. Attractors are numbered by
    the size of their basins. The fractions are those of the cells: their standard error sqrt(p (1 - p) / N) is that of
    N states drawn at random from the box.

    Parameters
    ----------
    system : HybridSystem
        System with its parameters; its initial state gives the mode, and the states that the grid does not span.
    grid : mapping of two states to values
        ``{"y": np.linspace(-1, 1, 400), "w": np.linspace(0, 1, 300)}``.
    transient, periods : int
        As in `bifurcation_diagram`; no section is kept.
    exponents, at, max_period, patience, workers, scheduler, store : optional
        As in `bifurcation_diagram`.
    method, tolerance, steps, max_events, max_stalls, progress : optional
        As in `trajectory`; ``progress`` gets the outcomes counted so far.

    Returns
    -------
    xarray.Dataset
        Over both states ``attractor`` (its number, 0 for none) and ``outcome``; over ``attractor_number``:
        ``attractor_period``, ``attractor_outcome``, ``attractor_exponent`` and ``attractor_error`` (exponent),
        ``attractor_rate``, ``attractor_state`` (state), ``fraction`` and ``fraction_error``.

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
    axes = state_axes(system, grid)
    names = tuple(axis.name for axis in axes)
    _check_free(system, names)
    given["grid"] = listed(axes)
    plan = make_plan(
        system,
        (),
        transient=transient,
        periods=periods,
        exponents=exponents,
        at=at,
        max_period=max_period,
        patience=patience,
        numerics=Numerics(method, tolerance, steps, max_events, max_stalls),
    )
    rates = ("progression_rate",) if "penetration" in system.quadratures else ()
    keeps = ("period", "outcome", "lyapunov_exponent", "lyapunov_error", "moments", "state")
    modes = np.array([system.mode_names.index(system.initial["mode"])])
    starts = np.array([[system.initial[s] for s in system.state_names]])
    task = PointTask(plan, axes, starts, modes, (*keeps, *rates))
    found = execute(task, workers=whole("workers", workers, 1), scheduler=scheduler, store=store, progress=progress)
    cells = {name: values[:, 0] for name, values in found.items()}
    numbers, leaders = number_attractors(cells)
    fraction = np.bincount(numbers, minlength=len(leaders) + 1)[1:] / task.units
    over, number = names, "attractor_number"
    variables: dict[str, Any] = {
        "attractor": (over, numbers.reshape(task.shape).astype(np.int16)),
        "outcome": (over, cells["outcome"].reshape(task.shape)),
        "attractor_period": (number, cells["period"][leaders]),
        "attractor_outcome": (number, cells["outcome"][leaders]),
        "attractor_state": ((number, "state"), cells["state"][leaders]),
        "fraction": (number, fraction),
        "fraction_error": (number, np.sqrt(fraction * (1 - fraction) / task.units)),
        "forcing_period": ((), system.forcing_period()),
    }
    coords: dict[str, Any] = {
        **{axis.name: axis.values for axis in axes},
        number: np.arange(1, len(leaders) + 1, dtype=np.int32),
        "state_name": ("state", list(system.state_names)),
    }
    if plan.exponents:
        variables["attractor_exponent"] = ((number, "exponent"), cells["lyapunov_exponent"][leaders])
        variables["attractor_error"] = ((number, "exponent"), cells["lyapunov_error"][leaders])
        coords["exponent"] = np.arange(1, plan.exponents + 1, dtype=np.int32)
    if rates:
        variables["attractor_rate"] = (number, cells["progression_rate"][leaders])
    return label(xr.Dataset(variables, coords=coords), "basins", system=system, settings=given)


def _check_free(system: "HybridSystem", names: tuple[str, ...]) -> None:
    """Refuse a state that the initial mode holds at one value."""
    mode = str(system.initial["mode"])
    held = [system.state_names[i] for i in pinned_states(system, mode)]
    for name in names:
        if name in held:
            raise SettingsError(
                f"grid names {name!r}, which mode {mode!r}, the initial one, leaves no freedom; give another state, or "
                f"another initial mode: {list(system.modes)}"
            )
