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
    declared = SCHEMA.get(str(ds.attrs.get("kind")), {}).values()
    names = [v.name for v in declared if v.coordinate and v.dtype == "str" and v.dims == (v.name,)]
    found = [name for name in names if name + _SUFFIX in ds.coords and ds[name + _SUFFIX].dims == (name,)]
    found = [name for name in found if name not in ds.variables]
    for name in found:
        ds = ds.rename_vars({name + _SUFFIX: name}).set_xindex(name)
    return ds
