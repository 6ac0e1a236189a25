"""Archives follow CF-1.11 and ACDD-1.3, by a checker that is not ours."""

import netCDF4
import pytest
import xarray as xr
from support import compliance

from chaosdrill.archive import save
from chaosdrill.dataset import SCHEMA

pytestmark = [
    pytest.mark.filterwarnings("ignore"),
    pytest.mark.skipif(not compliance.INSTALLED, reason="compliance-checker is not installed"),
]

MODEL_TIME = "Coordinate variable 'time' should have standard_name='time', found: 'None'"
"""The checker takes every dimension of this name for time by the clock, in seconds since a date. CF asks for no
such thing, and time of a dimensionless model cannot have the standard name, whose unit is the second."""

ONE_TIME = "check_invalid_same_named_dimension_across_groups"
"""This check looks for a dimension "time" in every group of a file and stops with a KeyError where there is none."""

NOT_ON_EARTH = ("geospatial_", "time_coverage_")
NOT_KNOWN = {
    # who computes, and why, is for users to add
    *("id", "naming_authority", "comment", "license", "acknowledgment/acknowledgement", "project", "institution"),
    *("creator_name", "creator_url", "creator_email", "publisher_name", "publisher_url", "publisher_email"),
    # no variable has a name in that table
    "standard_name_vocabulary",
}


@pytest.fixture(scope="module")
def checked():
    """Check a file: what failed, as (weight, message), and the checks that stopped with an exception."""
    with compliance.checker() as check:
        yield check


def test_every_kind_is_checked(every_group):
    # what is forced has no equilibria
    assert {ds.attrs["kind"] for ds in every_group.values()} == set(SCHEMA) - {"equilibria"}


def test_the_whole_file(every_kind, checked):
    failed, stopped = checked(every_kind, "cf:1.11")
    assert failed == []
    assert stopped <= {ONE_TIME}


GROUPS = ("motion", "section", "spectrum", "diagram", "chart", "basins", "orbit", "branch", "precision")


@pytest.fixture(scope="module", params=GROUPS)
def flat(request, every_group, tmp_path_factory):
    """One group as a file of its own, since the checker looks at variables of the root only."""
    ds = compliance.in_numbers(every_group[request.param])
    return save(ds, tmp_path_factory.mktemp("flat") / f"{request.param}.nc")


def test_climate_and_forecast(flat, checked):
    failed, stopped = checked(flat, "cf:1.11")
    assert stopped == set()
    assert [message for _, message in failed if message != MODEL_TIME] == []


def test_data_discovery(flat, checked):
    failed, stopped = checked(flat, "acdd:1.3")
    assert stopped == set()
    missing = {message.removesuffix(" not present") for weight, message in failed if weight > 1}
    missing = {name for name in missing if not name.startswith(NOT_ON_EARTH)} - NOT_KNOWN
    # the CF table of standard names has none for exponents, sections and the like
    assert {name for name in missing if "geospatial" not in name} == {"standard_name"}


def test_the_checker_does_find_faults(every_group, checked, tmp_path):
    ds = every_group["spectrum"].copy(deep=True)
    ds["lyapunov_exponent"].attrs["units"] = "furlongs per fortnite"
    ds["lyapunov_exponent"].attrs["standard_name"] = "lyapunov"
    del ds.attrs["summary"]
    path = save(ds, tmp_path / "faulty.nc")
    assert any("fortnite" in message for _, message in checked(path, "cf:1.11")[0])
    assert any("summary" in message for _, message in checked(path, "acdd:1.3")[0])


def test_values_are_not_touched_by_decoding(flat):
    with netCDF4.Dataset(flat) as file, xr.open_dataset(flat) as opened:
        for name, variable in file.variables.items():
            if variable.dtype is not str:
                assert opened[name].dtype == variable.dtype, name


NAMED = {"state", "seed", "transition", "method", "quantity"}
"""Dimensions of which plain readers select by name, whereas coordinate variables of CF 1.11, 1.3, are numbers."""


def test_only_names_are_texts_along_a_dimension(every_kind):
    with netCDF4.Dataset(every_kind) as file:
        found = {
            name
            for group in file.groups.values()
            for name in group.dimensions
            if name in group.variables and group[name].dtype is str
        }
    assert found == NAMED
