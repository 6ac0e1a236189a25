"""What users of xarray do with the result of each kind of analysis works, by names and without a warning."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

from chaosdrill.archive import save

GROUPS = ("motion", "section", "spectrum", "diagram", "chart", "basins", "orbit", "branch", "precision")


@pytest.fixture(params=GROUPS)
def ds(request, every_group):
    return every_group[request.param]


def numbers(ds):
    return [name for name, variable in ds.data_vars.items() if variable.dtype.kind in "iuf"]


def test_every_variable_holds_numbers_and_no_other_names_a_dimension(ds):
    assert numbers(ds) == list(ds.data_vars)
    for name in set(ds.dims) & set(ds.variables):
        assert ds[name].dims == (name,)
        assert name in ds.indexes


def test_arithmetic_keeps_all_of_it(ds):
    apart = ds - ds
    assert set(apart.data_vars) == set(ds.data_vars)
    assert set(apart.coords) == set(ds.coords)
    for name in ds.data_vars:
        values = ds[name].values
        np.testing.assert_array_equal(apart[name].values, np.where(np.isfinite(values), 0, np.nan))


def test_means_keep_all_of_it(ds):
    for dim in (dim for dim, size in ds.sizes.items() if size):
        mean = ds.mean(dim)
        assert set(mean.data_vars) == set(ds.data_vars)
        for name in ds.data_vars:
            if ds[name].dtype.kind == "f" and dim in ds[name].dims and np.isfinite(ds[name].values).all():
                axis = ds[name].dims.index(dim)
                np.testing.assert_allclose(mean[name].values, np.mean(ds[name].values, axis=axis), rtol=1e-12)


def test_a_name_selects(ds):
    for dim, index in ds.indexes.items():
        assert index.is_unique, dim
        for place, name in enumerate(index):
            assert ds.sel({dim: name}).identical(ds.isel({dim: place})), (dim, name)
    if "state" in ds.dims:
        assert ds["state"].values.tolist() == ["x", "v"]


def test_every_curve_and_every_chart_is_drawn(ds):
    for name in ds.data_vars:
        if ds[name].ndim in (1, 2) and ds[name].size > 1:
            axes = Figure().subplots()
            ds[name].plot(ax=axes)
            assert axes.has_data(), name
        if ds[name].ndim == 2 and min(ds[name].shape) > 0:
            lines = ds[name].plot.line(x=ds[name].dims[0], ax=Figure().subplots())
            assert len(lines) == ds[name].shape[1], name


def test_tables(ds):
    for name in ds.data_vars:
        if ds[name].dims:
            table = ds[name].to_dataframe()
            assert table.index.names == list(ds[name].dims)
            np.testing.assert_array_equal(table[name].to_numpy(), ds[name].values.ravel())


def test_concatenated(ds):
    both = xr.concat([ds, ds], xr.IndexVariable("run", ["one", "two"]))
    for name in ds.data_vars:
        assert both[name].sel(run="two", drop=True).identical(ds[name]), name


def test_merged(ds):
    names = list(ds.data_vars)
    assert xr.merge([ds.drop_vars(names[::2]), ds.drop_vars(names[1::2])]).equals(ds)


def test_parts_of_a_sweep_are_put_together(every_group):
    ds = every_group["diagram"]
    name = ds["period"].dims[0]
    parts = [ds.isel({name: slice(2)}), ds.isel({name: slice(2, None)})]
    assert xr.concat(parts, name, data_vars="minimal").equals(ds)


def test_many_files_at_once(ds, tmp_path):
    files = [save(ds, tmp_path / f"{name}.nc") for name in ("one", "two")]
    with xr.open_mfdataset(files, combine="nested", concat_dim="run", decode_times=False) as opened:
        for name in ds.data_vars:
            np.testing.assert_array_equal(opened[name].isel(run=1).values, ds[name].values)
        if "state" in ds.dims:
            assert opened.sel(state="v").sizes == opened.isel(state=1).sizes


def test_a_file_is_opened_by_plain_xarray(ds, tmp_path):
    with xr.open_dataset(save(ds, tmp_path / "one.nc")) as opened:
        assert opened.equals(ds)
        for dim, index in ds.indexes.items():
            assert opened.indexes[dim].equals(index)
