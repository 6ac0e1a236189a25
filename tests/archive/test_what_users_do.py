"""What users of xarray do with the result of each kind of analysis works, by names and without a warning."""

import numpy as np
import pytest
import xarray as xr
from matplotlib import pyplot
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import chaosdrill as cd
from chaosdrill.archive import save
from chaosdrill.errors import SettingsError
from chaosdrill.plots import PICTURES

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


@pytest.fixture
def shown():
    """Figures are those that a notebook would show."""
    pyplot.switch_backend("agg")
    pyplot.close("all")
    return pyplot


def test_every_picture_is_drawn_from_data_in_hand(ds, shown):
    names = [picture.name for picture in PICTURES if picture.suits(ds)]
    for name in names:
        axes = cd.plot(ds, name)
        assert isinstance(axes, Axes)
        assert axes.has_data()
        assert axes.figure.number == shown.get_fignums()[-1]
    first = cd.plot(ds)
    assert [panel.get_ylabel() for panel in first.figure.axes] == [
        panel.get_ylabel() for panel in cd.plot(ds, names[0]).figure.axes
    ]


def test_pictures_are_drawn_where_they_are_asked_for(ds, shown):
    for name in (picture.name for picture in PICTURES if picture.suits(ds)):
        axes = Figure().subplots(1, 2)[1]
        if name in ("convergence", "work-precision", "multipliers", "cascade"):
            with pytest.raises(SettingsError, match="several panels"):
                cd.plot(ds, name, ax=axes)
            continue
        assert cd.plot(ds, name, ax=axes) is axes
        assert axes.has_data()
        assert axes.get_xlabel()
    assert shown.get_fignums() == []


def test_a_state_is_chosen(every_group, shown):
    run = every_group["motion"]
    lines = cd.plot(run, state="v").lines
    np.testing.assert_array_equal(np.isin(run["states"].sel(state="v"), lines[0].get_ydata()), True)
    assert len(cd.plot(run, state="v").figure.axes) == 1
    assert cd.plot(run, "phase-portrait", state=("v", "x")).get_xlabel() == "velocity v"
    assert cd.plot(run.sel(state="v")).get_ylabel() == "velocity v"
    for name in ("diagram", "branch"):
        assert cd.plot(every_group[name], state="v").get_ylabel() == "velocity v"
    for wrong, told in (("w", "states are x, v"), (("x", "v", "x"), "shows 2")):
        with pytest.raises(SettingsError, match=told):
            cd.plot(run, "phase-portrait", state=wrong)


def test_a_selected_seed_is_drawn(every_group, shown):
    ds = every_group["diagram"]
    one = ds.sel(seed=ds["seed"].values[0])
    assert cd.plot(one).has_data()


@pytest.mark.parametrize(
    ("act", "told"),
    [
        (lambda tree: cd.plot(xr.DataTree.from_dict(tree)), "one group"),
        (lambda tree: cd.plot(tree["motion"]["states"]), "one group"),
        (lambda tree: cd.plot(tree["motion"], "isoperiodic-chart"), "time-history, phase-portrait"),
        (lambda tree: cd.plot(tree["diagram"].isel({tree["diagram"]["period"].dims[0]: 0})), "to one value"),
        (lambda tree: cd.plot(tree["chart"], state="x"), "no single states"),
    ],
)
def test_what_cannot_be_drawn_is_told(every_group, act, told):
    with pytest.raises(SettingsError, match=told):
        act(every_group)
