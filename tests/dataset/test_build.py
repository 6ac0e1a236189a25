"""A dataset built of plain arrays is that of xarray, and nobody is asked for dask."""

import subprocess
import sys

import numpy as np
import pytest
import xarray as xr

from chaosdrill.dataset import SCHEMA
from chaosdrill.dataset.build import dataset, variable
from chaosdrill.dataset.schema import ORBIT, ORDER, RUN

LABELS = {
    "time": ("time", np.arange(4.0), {"units": "s"}, {"_FillValue": None}),
    "state": ["x", "longer"],
    "transition": np.array([], dtype=str),
    "exponent": np.arange(1, 4, dtype=np.int32),
    "state_long_name": ("state", np.array(["place", "speed"])),
}
VALUES = {
    "states": (("time", "state"), np.ones((4, 2)), {"long_name": "states"}),
    "outcome": ((), np.int8(3), {}, {"dtype": np.dtype("i1")}),
    "rate": ((), 2.5),
    "event_count": ("transition", np.zeros(0, dtype=np.int64)),
    "mode": ("time", [0, 1, 1, 0]),
}


def test_it_is_what_xarray_makes():
    own, plain = dataset(VALUES | LABELS, ["state_long_name"], {"a": 1}), xr.Dataset(VALUES, LABELS, {"a": 1})
    xr.testing.assert_identical(own, plain)
    assert list(own.variables) == list(plain.variables)
    for name, expected in plain.variables.items():
        found = own.variables[name]
        assert (type(found), found.dtype, found.encoding) == (type(expected), expected.dtype, expected.encoding)
    for name, index in plain.indexes.items():
        assert own.indexes[name].dtype == index.dtype
        assert own.indexes[name].name == index.name


def test_labels_select_as_those_of_xarray():
    own, plain = dataset(VALUES | LABELS, ["state_long_name"]), xr.Dataset(VALUES, LABELS)
    one = {"time": 2.0, "state": "longer"}
    xr.testing.assert_identical(own.sel(one), plain.sel(one))
    with pytest.raises(KeyError):
        own.sel(state="y")


def test_a_wrong_number_of_dimensions_is_refused():
    with pytest.raises(ValueError, match="dimensions"):
        variable(("time", "state"), np.ones(3))
    with pytest.raises(ValueError, match="conflicting sizes"):
        dataset({"time": np.arange(3.0), "a": ("time", np.ones(4))})


CHUNKED = """
import sys
import chaosdrill as cd
found = cd.lyapunov_spectrum(cd.build("lorenz"), duration=2.0)
cd.trajectory(cd.build("roessler"), duration=2.0)
assert "dask" not in sys.modules
import dask.array
import xarray as xr
chunked = found.chunk(exponent=2)
assert chunked.chunks["exponent"] == (2, 1), chunked.chunks
assert isinstance(chunked["lyapunov_exponent"].data, dask.array.Array)
assert chunked.compute().identical(found)
"""


def test_who_imports_dask_later_has_all_of_it():
    pytest.importorskip("dask.array")
    done = subprocess.run([sys.executable, "-c", CHUNKED], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_one_order_of_dimensions_holds_in_every_table():
    places = {name: place for place, name in enumerate(ORDER)} | {ORBIT: ORDER.index("orbit"), RUN: ORDER.index("run")}
    for table in SCHEMA.values():
        for declared in table.values():
            assert [places.get(dim, -1) for dim in declared.dims] == sorted(
                places.get(dim, -1) for dim in declared.dims
            )
