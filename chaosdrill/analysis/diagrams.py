"""Bifurcation diagrams: section, period, exponents and outcome along a parameter."""

import os
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from chaosdrill.analysis.arguments import Progress, settings, whole
from chaosdrill.analysis.grids import listed, parameter_axes
from chaosdrill.analysis.lines import LineTask
from chaosdrill.analysis.plan import make_plan
from chaosdrill.analysis.points import PointTask
from chaosdrill.analysis.seeds import directions, make_seeds
from chaosdrill.dataset import count_outcomes, label
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.period import forcing_periods
from chaosdrill.engine.run import rate_names
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
    random: Mapping[str, Any] | None = None,
    follow: str | None = None,
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
    """Sections along a parameter, with the spectrum beside them and an outcome for every point.

    Every point is a run of its own from its own initial state, so that the result does not depend on the number of
    workers, to the bit; states that are followed along the sweep are lines of their own. A point that fails gets its
    outcome, and the sweep goes on.

    What a point is on is decided by exponents and recurrence together (see "Period detection" in the theory). A point
    that is undecided goes on, and its record is the last one: the cycle to which it leads, or up to ``patience`` times
    as many periods.

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
        Initial values (and ``mode``) of each fixed seed; default: the system's own initial state, unless other seeds
        are asked for.
    random : mapping, optional
        ``{"count": 4, "seed": 1, "y": (-1, 1)}``: so many states drawn evenly from the box of the states named, by a
        generator that is given the number ``seed``; the same states at every point.
    follow : {"forward", "backward", "both"}, optional
        The last state at a point is the first one at the next, along the sweep or against it: hysteresis shows. The
        first point, and one whose neighbour has ended early, starts from the system's own initial state.
    exponents : int, optional
        Number of exponents; default all, 0 for none. Without exponents recurrence alone decides, at once.
    at : str, default "strobe"
        ``"strobe"`` or the name or kind of a transition; then the last ``periods`` states before that event are kept.
    max_period : int, default 64
        Longest period looked for, in iterates of the section; the record must hold two.
    patience : int, default 8
        How many times as long as ``periods`` an undecided point may run on; 0: it is taken as it is after its record.
    workers : int, default 1
        Threads; the kernels hold no lock.
    scheduler : str, optional
        Address of a Dask scheduler, whose workers are used instead.
    store : path-like, optional
        Folder for finished chunks, from which the same call goes on if it was cut short.
    method, tolerance, steps, max_events, max_stalls, progress : optional
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
        An argument that cannot be used, or a ``store`` that holds chunks of another call.
    ArchiveError
        If the ``store`` cannot be written, or another call uses it.
    ChaosdrillError
        If the scheduler cannot be reached or is lost, or if its workers have other versions.
    """
    given = settings(dict(locals()))
    (axis,) = parameter_axes(system, sweep, 1, "a bifurcation diagram")
    lines = directions(follow)
    chosen = make_seeds(system, seeds, random, needed=not lines)
    given |= {"sweep": listed((axis,)), **chosen.settings}
    plan = make_plan(
        system,
        (axis.name,),
        transient=transient,
        periods=periods,
        exponents=exponents,
        at=at,
        max_period=max_period,
        patience=patience,
        numerics=Numerics(method, tolerance, steps, max_events, max_stalls),
        rows=whole("periods", periods, 2),
    )
    keeps = ("section", "period", "outcome", *(("lyapunov_exponent", "lyapunov_error") if plan.exponents else ()))
    keeps += rate_names(system)
    own = np.array([system.initial[s] for s in system.state_names])
    start = own, system.mode_names.index(system.initial["mode"])
    tasks: dict[str, PointTask | LineTask] = {}
    if len(chosen.starts):
        tasks["points"] = PointTask(plan, (axis,), chosen.starts, chosen.modes, keeps)
    if lines:
        tasks["lines"] = LineTask(plan, axis, lines, *start, keeps)
    total, done = sum(task.total for task in tasks.values()), 0
    outcomes: Counter[str] = Counter()
    parts = []
    for name, task in tasks.items():
        found = execute(
            task,
            workers=whole("workers", workers, 1),
            scheduler=scheduler,
            store=None if store is None else Path(store) / name if len(tasks) > 1 else store,
            progress=None if progress is None else _shifted(progress, done, total, Counter(outcomes)),
        )
        parts.append(found if name == "points" else {key: values.swapaxes(0, 1) for key, values in found.items()})
        done += task.total
        outcomes.update(count_outcomes(found["outcome"]))
    gathered = {name: np.concatenate([part[name] for part in parts], axis=1) for name in keeps}
    over = (axis.name, "seed")
    dims = {"section": ("iterate", "state"), "lyapunov_exponent": ("exponent",), "lyapunov_error": ("exponent",)}
    variables = {name: ((*over, *dims.get(name, ())), values) for name, values in gathered.items()}
    variables["initial_state"] = (("seed", "state"), np.concatenate([chosen.starts, np.tile(own, (len(lines), 1))]))
    parameters = {axis.name: axis.values}
    variables["forcing_period"] = ((axis.name,), forcing_periods(system, parameters, len(axis.values)))
    coords: dict[str, Any] = {
        axis.name: axis.values,
        "seed": np.arange(len(chosen.starts) + len(lines), dtype=np.int32),
        "seed_name": ("seed", list(chosen.names + lines)),
        "iterate": np.arange(plan.rows, dtype=np.int32),
        "state_name": ("state", list(system.state_names)),
    }
    if plan.exponents:
        coords["exponent"] = np.arange(1, plan.exponents + 1, dtype=np.int32)
    return label(xr.Dataset(variables, coords=coords), "bifurcation-diagram", system=system, settings=given)


def _shifted(progress: Progress, before: int, total: int, earlier: Counter[str]) -> Progress:
    """Progress of one task among several."""
    return lambda done, _, outcomes: progress(before + done, total, dict(earlier + Counter(outcomes)))
