"""Texts along a dimension, in a file: CF takes a variable with the name of its dimension for numbers in order."""

from typing import TYPE_CHECKING

from chaosdrill.dataset.schema import SCHEMA

if TYPE_CHECKING:
    import xarray as xr

_SUFFIX = "_name"


def labels_to_file(ds: "xr.Dataset") -> "xr.Dataset":
    """The dataset with ``method`` (method) as ``method_name`` (method), as for all texts named as their dimension."""
    names = [str(name) for name in ds.indexes if ds[name].dtype.kind in "OUT"]
    return ds.reset_index(names).rename_vars({name: name + _SUFFIX for name in names}) if names else ds


def labels_from_file(ds: "xr.Dataset") -> "xr.Dataset":
    """The dataset with these texts under the names of their dimensions again, so that ``sel`` finds them."""
    # a name such as state_name is declared as it is
    declared = {variable.name for variable in SCHEMA.get(str(ds.attrs.get("kind")), {}).values()}
    for name in (str(name) for name in ds.coords):
        stem = name.removesuffix(_SUFFIX)
        if name == stem or name in declared or stem in ds.variables:
            continue
        if ds[name].dims == (stem,) and ds[name].dtype.kind in "OUT":
            ds = ds.rename_vars({name: stem}).set_xindex(stem)
    return ds
