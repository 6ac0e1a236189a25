"""Datasets of plain arrays, made without checks for arrays of other libraries."""

from collections.abc import Collection, Mapping
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr
from xarray.indexes import Index, PandasIndex


def variable(dims: Any, values: Any, attrs: Any = None, encoding: Any = None) -> xr.Variable:
    """A variable of numpy's arrays, numbers or text; arguments as of `xarray.Variable`."""
    array = np.asarray(values)
    # to look for another library's arrays xarray imports all of dask, where it is installed
    return xr.Variable((dims,) if isinstance(dims, str) else dims, array, attrs, encoding, fastpath=True)


def dataset(
    variables: Mapping[str, Any],
    coords: Collection[str] = (),
    attrs: Any = None,
    *,
    indexes: Mapping[str, Index] | None = None,
) -> xr.Dataset:
    """A dataset identical to that of `xarray.Dataset` from the same arguments, to the type of every index.

    ``variables``: bare values are those of the dimension coordinate of this name. ``coords``: coordinates besides the
    dimension coordinates. ``attrs``: attributes of the dataset. ``indexes``: those of dimension coordinates, where
    another dataset has them; the others are made.
    """
    made = {
        name: one if isinstance(one, xr.Variable) else variable(*(one if isinstance(one, tuple) else (name, one)))
        for name, one in variables.items()
    }
    found = {name: (indexes or {}).get(name) or _index(name, one) for name, one in made.items() if one.dims == (name,)}
    labels = {name: made[name] for name in made if name in found or name in coords}
    labels |= {name: index.create_variables(labels)[name] for name, index in found.items()}
    # data first, as xarray has them; its own way here looks for what could be aligned or merged
    together = {name: one for name, one in made.items() if name not in labels} | labels
    return xr.Dataset._construct_direct(together, set(labels), attrs=dict(attrs or {}), indexes=found)


def _index(name: str, labels: xr.Variable) -> Index:
    index = pd.Index(labels.values, dtype="object" if labels.dtype.kind == "O" else None)
    return PandasIndex(index, name, coord_dtype=labels.dtype)


def more(ds: xr.Dataset, variables: Mapping[str, Any]) -> xr.Dataset:
    """The dataset with further variables, given as to `dataset`."""
    known = {str(name): one for name, one in ds.variables.items()}
    return dataset({**known, **variables}, [str(name) for name in ds.coords], ds.attrs)


def first(ds: xr.Dataset, dim: str) -> xr.Dataset:
    """The first entry along a dimension, without this, as ``ds.isel({dim: 0}, drop=True)``."""
    found = {}
    for name, one in ds.variables.items():
        if dim not in one.dims:
            found[str(name)] = variable(one.dims, one.values, one.attrs, one.encoding)
        elif name != dim:
            rest = tuple(other for other in one.dims if other != dim)
            values = one.values.take(0, axis=one.dims.index(dim))
            found[str(name)] = variable(rest, values, one.attrs, one.encoding)
    return dataset(found, [str(name) for name in ds.coords], ds.attrs)
