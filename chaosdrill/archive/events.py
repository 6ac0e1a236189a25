"""Cut and join trajectories together with their events, which plain xarray does not relate to times."""

from collections.abc import Mapping
from typing import Any

from chaosdrill.annotations import Dataset
from chaosdrill.dataset.dates import DATES
from chaosdrill.dataset.provenance import DERIVED, now, signature
from chaosdrill.errors import ArchiveError
from chaosdrill.names import shown
from chaosdrill.settings import real


def cut(ds: "Dataset", start: float, stop: float) -> "Dataset":
    """The part of a trajectory between two times, with the events of that part.

    Parameters
    ----------
    ds : xarray.Dataset
        A trajectory, such as one group of an archive.
    start, stop : float
        Model times, both included.

    Returns
    -------
    xarray.Dataset
        The samples and the events with start <= time <= stop; the history records it.

    Raises
    ------
    ArchiveError
        If the dataset is not a trajectory, a time is not a number, or no sample lies between the two times.
    """
    import numpy as np

    _check_trajectory("ds", ds)
    ends = real(start), real(stop)
    for name, value, end in zip(("start", "stop"), (start, stop), ends, strict=True):
        if np.isnan(end):
            raise ArchiveError(f"{name} is {shown(value):.60}; it must be a number, in units of model time")
    times, events = ds["time"].values, ds["event_time"].values
    inside = (times >= ends[0]) & (times <= ends[1])
    if not inside.any():
        raise ArchiveError(
            f"no sample between {shown(start):.60} and {shown(stop):.60}; the trajectory has times from {times[0]} to "
            f"{times[-1]}"
        )
    kept = (events >= ends[0]) & (events <= ends[1])
    part = ds.isel(time=inside, event=kept)
    if "event_count" in ds.variables:
        last = np.cumsum(ds["event_count"].values)[:-1]
        counts = np.array([run.sum() for run in np.split(kept, last)], dtype=ds["event_count"].dtype)
        part["event_count"] = ds["event_count"].copy(data=counts)
    return _told(part, f"cut to times {shown(start):.60} to {shown(stop):.60}")


def join(runs: "Mapping[str, Dataset]") -> "Dataset":
    """Several trajectories as one dataset: samples side by side, events one run after the other.

    Parameters
    ----------
    runs : mapping of str to xarray.Dataset
        Trajectories of the same system with the same sample times, by name.

    Returns
    -------
    xarray.Dataset
        With the leading dimension ``run`` (coordinate: the names) for everything except events. These share the
        dimension ``event``, as a contiguous ragged array of CF: ``event_count`` (run) is the number of each run.

    Raises
    ------
    ArchiveError
        If ``runs`` does not name trajectories by text, if one of them is not a trajectory or is already joined, or if
        states or sample times differ.
    """
    import numpy as np
    import xarray as xr

    if not isinstance(runs, Mapping) or not runs:
        empty = isinstance(runs, list | tuple | Mapping | None) and not runs
        received = repr(runs) if empty else f"a {type(runs).__name__}"
        raise ArchiveError(
            f"runs is {received}; it must be a mapping of names to trajectories, as "
            'in join({"soft": one, "hard": another})'
        )
    first_name, first = next(iter(runs.items()))
    for name, ds in runs.items():
        if not isinstance(name, str):
            raise ArchiveError(f"runs has the name {name!r:.60}; names must be text, as in {str(name)!r:.60}")
        _check_trajectory(f"runs[{name!r}]", ds)
        if "run" in ds.dims:
            raise ArchiveError(f"runs[{name!r}] is already joined; join all runs at once")
        for axis in ("time", "state"):
            if not np.array_equal(ds[axis].values, first[axis].values):
                raise ArchiveError(
                    f"{name}: {axis} differs from that of {first_name}; cut the runs to the same times, or "
                    "interpolate them"
                )
    samples = [ds.drop_dims("event") for ds in runs.values()]
    events = [ds[[str(name) for name in ds.variables if "event" in ds[name].dims]] for ds in runs.values()]
    along = xr.IndexVariable("run", list(runs), {"long_name": "name of the run", "units": "1"})
    fixed: dict[str, Any] = {"compat": "override", "combine_attrs": "override"}
    joined = xr.concat(samples, along, data_vars="all", coords="minimal", **fixed)
    listed = xr.concat(events, "event", data_vars="minimal", coords="minimal", **fixed)
    joined = joined.assign({str(name): listed[name] for name in listed.variables if "event" in listed[name].dims})
    counts = np.array([ds.sizes["event"] for ds in runs.values()], dtype=np.int32)
    about = {"long_name": "events of the run", "units": "1", "sample_dimension": "event"}
    joined["event_count"] = ("run", counts, about)
    return _told(joined, f"join of {len(runs)} runs: {', '.join(runs)}")


def _check_trajectory(argument: str, ds: Dataset) -> None:
    import xarray as xr

    if not isinstance(ds, xr.Dataset):
        advice = "; give its dataset, as in node.to_dataset()" if isinstance(ds, xr.DataTree) else ""
        raise ArchiveError(f"{argument} is {type(ds).__name__}; it must be the xarray.Dataset of a trajectory{advice}")
    if dated := [name for name in ("time", "event_time") if name in ds.variables and ds[name].dtype.kind in DATES]:
        raise ArchiveError(f"{argument}: {dated[0]} holds dates; cut and join count model time, which is a number")
    missing = [name for name in ("time", "states", "event_time") if name not in ds.variables]
    if missing:
        kind = ds.attrs.get("kind", "dataset")
        raise ArchiveError(
            f"{argument} is a {kind} without {', '.join(missing)}; it must be a trajectory; other results are selected "
            "and merged with plain xarray"
        )


def _told(ds: Dataset, action: str) -> Dataset:
    history = str(ds.attrs.get("history", ""))
    told = "; ".join((*([str(ds.attrs[DERIVED])] if DERIVED in ds.attrs else []), action))
    return ds.assign_attrs({DERIVED: told}, history=f"{history}\n{now()} {signature()}: {action}".lstrip("\n"))
