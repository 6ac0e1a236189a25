"""Trajectories as datasets: one run, or one for each of many initial states on common times."""

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from chaosdrill.analysis.paths import Path, samples_of, traced
from chaosdrill.analysis.recording import Record
from chaosdrill.analysis.sections import find_section
from chaosdrill.analysis.starts import states_and_modes
from chaosdrill.dataset.build import dataset
from chaosdrill.engine import layout as at
from chaosdrill.model.regions import UNTOLD

if TYPE_CHECKING:
    from chaosdrill.analysis.base import Job
    from chaosdrill.model import HybridSystem
    from chaosdrill.progress import Progress


def one_run(system: "HybridSystem", given: Any, job: "Job") -> xr.Dataset:
    """The trajectory from the system's own initial state; see `trajectory`."""
    path = traced(find_section(system, given, job.numerics), given, job)
    return _dataset(system, path.times, path.rows, [path], given.tangents, ())


def ensemble(system: "HybridSystem", given: Any, job: "Job") -> xr.Dataset:
    """A trajectory from each of many initial states, on the same times; what one does not reach is NaN."""
    starts, modes = states_and_modes(system, given.initial)
    plan = given.span(system, job.numerics)
    begin = plan.transient * plan.unit if plan.periodic else plan.transient
    parts = plan.count * samples_of(system, given)
    even = begin + np.arange(parts + 1) * (plan.length / parts)
    times = even if given.times is None else np.array(given.times, dtype=float)
    n, q, runs = len(system.state_names), len(system.quadratures), len(starts)
    rows = np.full((runs, len(times), n + q + 1), np.nan)
    rows[..., -1] = -1
    paths: list[Path] = []
    for k, (start, mode) in enumerate(zip(starts, modes.tolist(), strict=True)):
        initial = dict(zip(system.state_names, start.tolist(), strict=True))
        own = system.with_initial(**initial, **({} if mode == UNTOLD else {"mode": system.mode_names[mode]}))
        progress = None if job.progress is None else _part(job.progress, k, runs)
        path = traced(find_section(own, given, job.numerics), given, replace(job, progress=progress))
        if len(path.times) and path.times[0] >= times[0]:
            rows[k, : len(path.rows)] = path.rows
        paths.append(path)
    return _dataset(system, times, rows, paths, given.tangents, ("run",)).assign(
        event_count=("run", np.array([len(path.events.events) for path in paths], dtype=np.int32)),
        initial_state=(("run", "state"), starts),
        initial_mode=("run", modes.astype(np.int8)),
        run=np.arange(1, runs + 1, dtype=np.int32),
    )


def _dataset(
    system: "HybridSystem",
    times: np.ndarray,
    rows: np.ndarray,
    paths: list[Path],
    tangents: np.ndarray | None,
    over: tuple[str, ...],
) -> xr.Dataset:
    """States, quadratures and modes at times, with events run by run; ``over`` is ("run",) of many runs, () of one."""
    n = len(system.state_names)
    variables: dict[str, Any] = {
        "states": ((*over, "time", "state"), rows[..., :n]),
        "mode": ((*over, "time"), rows[..., -1].astype(np.int8)),
        **{name: ((*over, "time"), rows[..., n + i]) for i, name in enumerate(system.quadratures)},
        **_events(system, [path.events for path in paths]),
        "outcome": (
            over,
            np.array([path.outcome for path in paths], dtype=np.int8) if over else np.int8(paths[0].outcome),
        ),
    }
    coords: dict[str, Any] = {"time": times, "state": list(system.state_names)}
    if tangents is not None:
        final = [path.tangents for path in paths]
        variables["initial_tangent"] = (("tangent", "state"), tangents)
        variables["final_tangent"] = ((*over, "tangent", "state"), np.array(final) if over else final[0])
        coords["tangent"] = np.arange(1, len(tangents) + 1, dtype=np.int32)
    if system.forced:
        variables["forcing_period"] = ((), system.forcing_period())
    messages = dict.fromkeys(path.message for path in paths if path.message)
    return dataset(variables | coords, attrs={"message": "; ".join(messages)} if messages else None)


def _events(system: "HybridSystem", records: list[Record]) -> Mapping[str, Any]:
    """Events of one run after the other."""
    rows = np.concatenate([one.events for one in records])
    targets = np.array([system.mode_names.index(t.target) for t in system.transitions], dtype=np.int8)
    told = {"event_time_error": ("event", rows[:, at.EVENT_ERROR])}
    return {
        "event_time": ("event", np.concatenate([one.times for one in records])),
        **(told if any(t.completes for t in system.transitions) else {}),
        "event_kind": ("event", rows[:, at.EVENT_KIND].astype(np.int8)),
        "event_speed": ("event", rows[:, at.EVENT_RATE]),
        "event_mode_before": ("event", rows[:, at.EVENT_MODE].astype(np.int8)),
        "event_mode_after": ("event", targets[rows[:, at.EVENT_KIND].astype(int)]),
        "event_state_before": (("event", "state"), np.concatenate([one.states_before() for one in records])),
        "event_state_after": (("event", "state"), np.concatenate([one.states_after() for one in records])),
    }


def _part(progress: "Progress", before: int, runs: int) -> "Progress":
    """Progress of one run among several of the same length."""
    return lambda done, total, outcomes: progress(before * total + done, runs * total, outcomes)
