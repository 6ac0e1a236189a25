"""Joined trajectories, one by one: for pictures that show several runs."""

from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.errors import ArchiveError
from chaosdrill.plots.style import PALETTE

if TYPE_CHECKING:
    import xarray as xr

MOST_RUNS = len(PALETTE)
"""More runs cannot be distinguished in one picture."""

_REMEDY = "join runs by chaosdrill.join, which says how many events belong to each"


def is_joined(dataset: "xr.Dataset") -> bool:
    """Return whether a trajectory is several, side by side."""
    return "run" in dataset.dims


def runs_of(dataset: "xr.Dataset") -> "list[tuple[str, xr.Dataset]]":
    """Return the name of each run and its trajectory with its own events, of the first ``MOST_RUNS``.

    A trajectory that is not joined is one run without a name.

    Raises
    ------
    ArchiveError
        If the dataset does not say which events belong to which run, or holds something else than trajectories.
    """
    runs = [("", dataset)]
    if is_joined(dataset):
        names = dataset["run"].values if "run" in dataset.variables else range(1, dataset.sizes["run"] + 1)
        ends = np.cumsum(_counts(dataset))
        starts = [0, *ends[:-1]]
        runs = [
            (str(name), dataset.isel(run=i, event=slice(starts[i], ends[i])).drop_vars("event_count"))
            for i, name in enumerate(names[:MOST_RUNS])
        ]
    for name, dims in {"states": ("time", "state"), "mode": ("time",), "event_time": ("event",)}.items():
        if runs[0][1][name].dims != dims:
            received = ", ".join(map(str, dataset[name].dims))
            raise ArchiveError(f"{name} has the dimensions {received}; a trajectory has {', '.join(dims)}: {_REMEDY}")
    return runs


def runs_left_out(dataset: "xr.Dataset") -> str:
    """Return a note on the runs that a picture does not show; empty if it shows all."""
    count = dataset.sizes.get("run", 1)
    return f"first {MOST_RUNS} of {count} runs" if count > MOST_RUNS else ""


def _counts(dataset: "xr.Dataset") -> "np.ndarray":
    if "event_count" not in dataset.variables or dataset["event_count"].dims != ("run",):
        raise ArchiveError(f"the dataset has several runs and no variable event_count (run): {_REMEDY}")
    counts = dataset["event_count"].values
    events = dataset.sizes.get("event", 0)
    if counts.dtype.kind not in "iu" or (counts < 0).any() or counts.sum() != events:
        raise ArchiveError(f"event_count is {counts.tolist()}, of {events} events in all: {_REMEDY}")
    return np.asarray(counts, dtype=np.int64)
