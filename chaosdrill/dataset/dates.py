"""Dates that a user has given to a result, as numbers for pictures and tables."""

from chaosdrill.annotations import Dataset

DATES = frozenset("mM")
"""Kinds of numpy's types of dates and spans of time."""


def undated(ds: Dataset) -> Dataset:
    """The dataset with seconds in place of dates, counted from the first one, and in place of spans of time."""
    import numpy as np

    found = {}
    for name, variable in ds.variables.items():
        if variable.dtype.kind not in DATES:
            continue
        values, label = variable.values, str(variable.attrs.get("long_name", name))
        if variable.dtype.kind == "M" and variable.size:
            label += f" since {values.ravel()[0]!s:.19}"
            values = values - values.ravel()[0]
        seconds = values / np.timedelta64(1, "s") if variable.size else np.zeros(values.shape)
        found[name] = (variable.dims, seconds, {**variable.attrs, "long_name": label, "units": "s"})
    return ds.assign(found)
