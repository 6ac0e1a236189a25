"""Types of xarray in annotations: any at run time, so that nothing waits for it."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from xarray import DataArray as DataArray
    from xarray import Dataset as Dataset
    from xarray import DataTree as DataTree
    from xarray import Variable as Variable
else:
    DataArray = Dataset = DataTree = Variable = Any
