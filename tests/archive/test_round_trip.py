"""What is saved comes back bit for bit, through this package and through plain xarray."""

import netCDF4
import numpy as np
import pytest
import xarray as xr

from chaosdrill.archive import open as open_archive
from chaosdrill.archive import save
from chaosdrill.errors import ArchiveError
from chaosdrill.workflow import compare


@pytest.fixture
def path(tree, tmp_path):
    return save(tree, tmp_path / "result.nc")


def test_nothing_is_lost(tree, path):
    assert compare(open_archive(path), tree) == []
    again = open_archive(path)
    assert np.isnan(again["first/section"].values[0]).all()
    assert np.isneginf(again["first/lyapunov_exponent"].values[:, 0, 1]).all()
    assert again["first/state_name"].values.tolist() == ["x", "v"]


def test_an_opened_archive_can_be_saved_again(tree, path, tmp_path):
    assert compare(open_archive(save(open_archive(path), tmp_path / "copy.nc")), tree) == []


def test_plain_xarray_reads_it(tree, path):
    with xr.open_datatree(path, engine="netcdf4") as plain:
        assert list(plain.children) == ["first", "second"]
        xr.testing.assert_equal(plain["second"].to_dataset(), tree["second"].to_dataset())


def test_every_variable_says_what_it_is(path):
    with netCDF4.Dataset(path) as file:
        for group in file.groups.values():
            for name, variable in group.variables.items():
                assert variable.long_name, name
                assert variable.units, name


def test_coordinates_have_no_fill_value(path):
    with netCDF4.Dataset(path) as file:
        assert "_FillValue" not in file["first/e"].ncattrs()


def test_numbers_are_compressed(path):
    with netCDF4.Dataset(path) as file:
        filters = file["second/section"].filters()
    assert filters["zlib"]
    assert filters["shuffle"]


def test_one_dataset_is_an_archive_too(tree, tmp_path):
    path = save(tree["first"].to_dataset(), tmp_path / "one.nc")
    assert open_archive(path).attrs["kind"] == "bifurcation-diagram"


def test_a_group_with_the_name_of_its_variable(tree, tmp_path):
    tree["section"] = tree["first"]
    path = save(tree, tmp_path / "result.nc")
    opened = open_archive(path)
    path.unlink()
    assert compare(opened, tree) == []


def test_the_file_is_free_after_opening(path, tree):
    opened = open_archive(path)
    path.unlink()
    assert compare(opened, tree) == []
    with pytest.raises(ArchiveError, match="No such file"):
        open_archive(path)
