"""The smallest change is found, named and measured; times and history do not count."""

import numpy as np
import pytest
import xarray as xr

from chaosdrill.workflow import compare


@pytest.fixture
def other(tree):
    return tree.copy(deep=True)


def only(tree, other):
    (difference,) = compare(other, tree)
    return difference


def test_equal(tree, other):
    assert compare(other, tree) == []


def test_one_bit(tree, other):
    values = other["first/section"].values
    values[1, 0, 0, 0] = np.nextafter(values[1, 0, 0, 0], 1)
    found = only(tree, other)
    assert (found.group, found.variable) == ("/first", "section")
    assert (found.differing, found.total) == (1, 24)
    assert 0 < found.max_abs < 1e-15


def test_largest_of_several(tree, other):
    other["second/section"].values[4, 0, :2, 1] += [0.5, -2.0]
    found = only(tree, other)
    assert (found.group, found.differing, found.total) == ("/second", 2, 40)
    assert found.max_abs == pytest.approx(2.0)


def test_number_where_there_was_none(tree, other):
    other["first/section"].values[0, 0, 0, 0] = 1.0
    found = only(tree, other)
    assert (found.differing, found.max_abs) == (1, np.inf)


def test_sign_of_zero(tree, other):
    tree["first/section"].values[1, 0, 0, 0] = 0.0
    other["first/section"].values[1, 0, 0, 0] = -0.0
    assert (only(tree, other).differing, only(tree, other).max_abs) == (1, 0.0)


def test_code(tree, other):
    other["first/outcome"].values[2, 0] = 4
    assert (only(tree, other).variable, only(tree, other).max_abs) == ("outcome", 1.0)


def test_text(tree, other):
    other["first/state_name"].values[0] = "y"
    assert (only(tree, other).what, only(tree, other).differing) == ("text differs", 1)


def test_variable_missing_and_added(tree, other):
    other["first"] = other["first"].to_dataset().rename(period="periode")
    found = {difference.variable: difference.what for difference in compare(other, tree)}
    assert found == {"period": "is missing", "periode": "does not belong here"}


def test_group_missing_and_added(tree, other):
    other["third"] = other["first"]
    del other["first"]
    found = {difference.group: difference.what for difference in compare(other, tree)}
    assert found == {"/first": "group is missing", "/third": "unexpected group"}


def test_shape(tree, other):
    other["second"] = other["second"].to_dataset().isel(iterate=slice(3))
    assert only(tree, other).variable == "section"
    assert "'iterate': 3" in only(tree, other).what


def test_dtype(tree, other):
    first = other["first"].to_dataset()
    other["first"] = first.assign(period=first["period"].astype("i4"))
    assert only(tree, other).what == "holds int32; expected int16"


def test_attribute(tree, other):
    other["first/section"].attrs["units"] = "m"
    assert only(tree, other).variable == "section:units"


def test_what_a_clock_measured_does_not_count(tree, other):
    """Declared so in the table of variables; the shape still counts."""
    for archive, seconds in ((tree, 1e-5), (other, 2e-5)):
        archive["third"] = xr.Dataset(
            {"wall_time": (("method", "tolerance"), [[seconds]]), "error": ("quantity", [0.0])},
            attrs={"kind": "work-precision", "recommendation": f"{seconds}"},
        )
    assert compare(other, tree) == []
    other["third/error"].values[0] = 1e-9
    assert only(tree, other).variable == "error"
    other["third"] = tree["third"].to_dataset().assign(wall_time=("method", [1e-5]))
    assert only(tree, other).variable == "wall_time"


@pytest.mark.parametrize("name", ["history", "wall_time_s", "versions", "platform"])
def test_what_a_second_run_changes_does_not_count(tree, other, name):
    other.attrs[name] = other["first"].attrs[name] = "another"
    assert compare(other, tree) == []


def test_the_order_in_a_table_of_settings_says_nothing(tree, other):
    tree["first"].attrs["settings"] = '{"periods": 8, "sweep": {"e": [0.1, 0.2]}}'
    other["first"].attrs["settings"] = '{"sweep": {"e": [0.1, 0.2]}, "periods": 8}'
    assert compare(other, tree) == []
    other["first"].attrs["settings"] = '{"sweep": {"e": [0.2, 0.1]}, "periods": 8}'
    assert only(tree, other).variable == ":settings"
