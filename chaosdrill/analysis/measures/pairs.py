"""Pairs of instants at which a motion is close to itself, as sparse matrices that other libraries take."""

from typing import TYPE_CHECKING, Any

from chaosdrill.analysis.spans import check_record
from chaosdrill.errors import SettingsError
from chaosdrill.names import shown
from chaosdrill.settings import real

if TYPE_CHECKING:
    import xarray as xr

SHOWS = {"poincare-section": ("section", "iterate"), "trajectory": ("states", "time")}
"""By kind, the variable with the states, and its dimension."""


def recurrences(ds: "xr.Dataset", rate: float = 0.05) -> Any:
    """Pairs of section points, or of samples, that are close to each other: a recurrence matrix.

    States are divided by their standard deviations, so that no unit decides what is close, and those that do not move
    are left out. As many pairs are close as ``rate`` says (Eckmann, Kamphorst and Ruelle 1987,
    doi:10.1209/0295-5075/4/9/004; Marwan et al. 2007, doi:10.1016/j.physrep.2006.11.001), and those besides that are
    no further apart than 1e-6 standard deviations. Points in different modes are not close.

    Parameters
    ----------
    ds : xarray.Dataset
        A Poincare section, or a trajectory of one run. A distance is kept of every pair while this works: 10,000 points
        take 1.5 GB.
    rate : float, default 0.05
        Part of all pairs of different points that are close, above 0, at most 1.

    Returns
    -------
    scipy.sparse.csr_array of bool, shape (points, points)
        Symmetric, with its diagonal. ``toarray()`` gives what recurrence quantification takes, and as the adjacency of
        a graph it is a recurrence network.

    Raises
    ------
    SettingsError
        A dataset of another kind, of several runs or without two points; a rate out of its range.
    """
    import numpy as np
    from scipy.sparse import csr_array
    from scipy.spatial.distance import pdist

    from chaosdrill.analysis.judgement.recurrence import CLOSE

    kind = getattr(ds, "attrs", {}).get("kind")
    name, dim = SHOWS.get(kind, ("", "")) if isinstance(kind, str) else ("", "")
    if not name or getattr(ds.get(name), "dims", None) != (dim, "state"):
        raise SettingsError(f"ds is {kind or shown(ds):.60}; it must be a poincare-section, or a trajectory of one run")
    part = real(rate)
    if not 0 < part <= 1:
        raise SettingsError(f"rate is {shown(rate):.60}; it must be a part of all pairs, above 0 and at most 1")
    states = np.asarray(ds[name].values, dtype=float)
    count = len(states)
    if count < 2 or not np.isfinite(states).all():
        raise SettingsError(f"ds holds {count} points of a run with the outcome {ds.cd.outcome}; none come back")
    check_record(count, count // 2, "points")
    spread = states.std(axis=0)
    moves = spread > CLOSE * np.abs(states).max(axis=0)
    scaled = states[:, moves] / spread[moves]
    distance = pdist(scaled) if moves.any() else np.zeros(count * (count - 1) // 2)
    first, second = np.triu_indices(count, 1)
    if "mode" in ds:
        mode = ds["mode"].values
        distance[mode[first] != mode[second]] = np.inf
    last = min(max(round(part * len(distance)), 1), len(distance)) - 1
    close = distance <= max(np.partition(distance, last)[last], CLOSE)
    close &= np.isfinite(distance)
    rows, columns = first[close], second[close]
    every = np.arange(count)
    places = (np.concatenate([rows, columns, every]), np.concatenate([columns, rows, every]))
    return csr_array((np.ones(len(places[0]), dtype=bool), places), shape=(count, count))
