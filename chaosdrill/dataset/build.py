"""Datasets of plain arrays, made without checks for arrays of other libraries."""

from collections.abc import Collection, Mapping
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr
from xarray.indexes import PandasIndex


def variable(dims: Any, values: Any, attrs: Any = None, encoding: Any = None) -> xr.Variable:
    """A variable of numpy's arrays, numbers or text; arguments as of `xarray.Variable`."""
    array = np.asarray(values)
    # to look for another library's arrays xarray imports all of dask, where it is installed
    return xr.Variable((dims,) if isinstance(dims, str) else dims, array, attrs, encoding, fastpath=True)


def dataset(variables: Mapping[str, Any], coords: Collection[str] = (), attrs: Any = None) -> xr.Dataset:
    """A dataset identical to that of `xarray.Dataset` from the same arguments, to the type of every index.

    ``variables``: bare values are those of the dimension coordinate of this name. ``coords``: coordinates besides the
    dimension coordinates. ``attrs``: attributes of the dataset.
    """
    made = {
        name: one if isinstance(one, xr.Variable) else variable(*(one if isinstance(one, tuple) else (name, one)))
        for name, one in variables.items()
    }
    indexes = {}
    for name, one in made.items():
        if one.dims == (name,):
            index = pd.Index(one.values, dtype="object" if one.dtype.kind == "O" else None)
            indexes[name] = PandasIndex(index, name, coord_dtype=one.dtype)
    labels = {name: made[name] for name in made if name in indexes or name in coords}
    labels |= {name: index.create_variables(labels)[name] for name, index in indexes.items()}
    rest = {name: one for name, one in made.items() if name not in labels}
    return xr.Dataset(rest, xr.Coordinates(labels, indexes), attrs)


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
