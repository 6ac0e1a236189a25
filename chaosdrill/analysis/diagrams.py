"""Bifurcation diagrams: section, period, exponents and outcome along a parameter."""

from collections.abc import Iterable, Mapping, Sequence
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from chaosdrill.analysis.arguments import Progress, real, section_transitions, settings, tangent_count, whole
from chaosdrill.analysis.points import GridTask, PointTask
from chaosdrill.dataset import label
from chaosdrill.engine.numerics import Numerics
from chaosdrill.errors import SettingsError
from chaosdrill.model.check import RESERVED
from chaosdrill.sweep import execute

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem


def bifurcation_diagram(
    system: "HybridSystem",
    sweep: Mapping[str, Any],
    *,
    transient: int,
    periods: int,
    seeds: Sequence[Mapping[str, Any]] | None = None,
    exponents: int | None = None,
    at: str = "strobe",
    max_period: int = 64,
    workers: int = 1,
    scheduler: str | None = None,
    store: str | PathLike[str] | None = None,
    method: str = "taylor",
    tolerance: float = 1e-12,
    steps: int | None = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Sections along a parameter, with the spectrum beside them and an outcome for every point.

    Every point is a run of its own from its own initial state, so that the result does not depend on the number of
    workers, to the bit. A point that fails gets its outcome, and the sweep goes on.

    Parameters
    ----------
    system : HybridSystem
        System with its parameters and initial state; it must have a forcing period.
    sweep : mapping of one parameter to values
        ``{"eta": np.linspace(0.4, 0.9, 501)}``.
    transient : int
        Forcing periods to run before anything is kept.
    periods : int
        Forcing periods to record and to average the exponents over.
    seeds : sequence of mappings, optional
        Initial values (and ``mode``) of each seed; default: the system's own initial state.
    exponents : int, optional
        Number of exponents; default all, 0 for none.
    at : str, default "strobe"
        ``"strobe"`` or the name or kind of a transition; then the last ``periods`` states before that event are kept.
    max_period : int, default 64
        Longest period looked for.
    workers : int, default 1
        Threads; the kernels hold no lock.
    scheduler : str, optional
        Address of a Dask scheduler whose workers compute the points instead.
    store : path-like, optional
        Folder in which finished chunks are kept; the same call goes on from those that are there.
    method, tolerance, steps, progress
        As in `trajectory`; ``progress`` gets the outcomes counted so far.

    Returns
    -------
    xarray.Dataset
        Over the parameter and seed: ``section`` (iterate, state), ``period``, ``lyapunov_exponent`` and
        ``lyapunov_error`` (exponent), mean rates, ``outcome``; ``initial_state`` (seed, state). NaN, and the period 0,
        where a point has no result.

    Raises
    ------
    SettingsError
        An argument that cannot be used.
    """
    given = settings(dict(locals()))
    name, values = sweep_values(system, sweep)
    chosen = seed_values(seeds)
    given |= {"sweep": {name: values.tolist()}, "seeds": None if seeds is None else chosen}
    starts = [system.with_initial(**seed) for seed in chosen]
    task = PointTask(
        parameter=name,
        transient=whole("transient", transient, 0),
        periods=whole("periods", periods, 2),
        chosen=None if isinstance(at, str) and at == "strobe" else section_transitions(system, at),
        max_period=whole("max_period", max_period, 1),
        numerics=Numerics(method, tolerance, steps),
        frame=tangent_count(system, exponents),
    ).for_system(system)
    count = whole("workers", workers, 1)
    grid = GridTask(task, tuple(values.tolist()), tuple(starts))
    found = execute(grid, workers=count, scheduler=scheduler, store=store, progress=progress)
    ds = _dataset(system, name, values, starts, found)
    return label(ds, "bifurcation-diagram", system=system, settings=given)


def sweep_values(system: "HybridSystem", sweep: Mapping[str, Any]) -> tuple[str, np.ndarray]:
    """Name and values of the swept parameter, checked."""
    if not isinstance(sweep, Mapping):
        raise SettingsError(f"sweep is {sweep!r}; it must be one parameter with its values, as in {{'eta': [0.5]}}")
    if len(sweep) != 1:
        raise SettingsError(f"sweep names {sorted(map(str, sweep))}; a bifurcation diagram sweeps one parameter")
    ((key, given),) = sweep.items()
    name = str(key)
    if name not in system.parameters:
        raise SettingsError(
            f"sweep names {name!r}, which is no parameter of {system.name}: {sorted(system.parameters)}"
        )
    if name in RESERVED:
        raise SettingsError(
            f"sweep names {name!r}, which is reserved for results and cannot be their coordinate; rename the parameter"
        )
    try:
        values = np.array([real(value) for value in given])
    except TypeError:
        values = np.array([])
    if isinstance(given, str | Mapping) or len(values) == 0 or not np.isfinite(values).all():
        raise SettingsError(f"sweep of {name!r} is {given!r}; it must be a list of finite numbers, not an empty one")
    if len(np.unique(values)) != len(values):
        raise SettingsError(f"sweep of {name!r} holds a value twice; every value may stand there once")
    return name, values


def seed_values(seeds: Any) -> list[dict[str, Any]]:
    """The initial values of each seed by name, checked; without seeds, one that changes none."""
    if seeds is None:
        return [{}]
    listed = [] if isinstance(seeds, str | Mapping) or not isinstance(seeds, Iterable) else list(seeds)
    if not listed and isinstance(seeds, Sequence) and not isinstance(seeds, str):
        raise SettingsError("seeds is empty; give at least one initial state, or leave seeds out")
    if not listed or not all(isinstance(seed, Mapping) for seed in listed):
        raise SettingsError(f"seeds is {seeds!r}; it must be a list of initial values, as in [{{'x': 0.1}}]")
    return [{str(key): value for key, value in seed.items()} for seed in listed]


def _dataset(
    system: "HybridSystem", name: str, values: np.ndarray, starts: list["HybridSystem"], found: dict[str, np.ndarray]
) -> xr.Dataset:
    shape = (len(values), len(starts))
    inner = {"section": ("iterate", "state"), "lyapunov_exponent": ("exponent",), "lyapunov_error": ("exponent",)}
    variables: dict[str, Any] = {
        key: ((name, "seed", *inner.get(key, ())), array.reshape(shape + array.shape[1:]))
        for key, array in found.items()
    }
    variables["forcing_period"] = (name, found["forcing_period"][:: len(starts)])
    variables["initial_state"] = (
        ("seed", "state"),
        np.array([[s.initial[x] for x in s.state_names] for s in starts]),
    )
    exponents = found["lyapunov_exponent"].shape[1]
    coords = {
        name: values,
        "seed": np.arange(len(starts), dtype=np.int32),
        "iterate": np.arange(found["section"].shape[1], dtype=np.int32),
        "exponent": np.arange(1, exponents + 1, dtype=np.int32),
        "state_name": ("state", list(system.state_names)),
    }
    if not exponents:
        del variables["lyapunov_exponent"], variables["lyapunov_error"], coords["exponent"]
    return xr.Dataset(variables, coords=coords)
