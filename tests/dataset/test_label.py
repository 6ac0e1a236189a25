"""A dataset that departs from the table is refused, with the name of what departs."""

import numpy as np
import pytest

from chaosdrill.dataset import label
from chaosdrill.errors import ChaosdrillError

KIND = "bifurcation-diagram"


def refusal(ds, system, settings, kind=KIND):
    with pytest.raises(ChaosdrillError) as caught:
        label(ds, kind, system=system, settings=settings)
    return str(caught.value)


def test_values_and_dimensions_are_kept(diagram, system, settings):
    labelled = label(diagram, KIND, system=system, settings=settings)
    assert dict(labelled.sizes) == {"e": 3, "seed": 2, "iterate": 4, "state": 1}
    np.testing.assert_array_equal(labelled["section"], diagram["section"])
    assert labelled["outcome"].dtype == np.int8
    assert labelled["period"].dtype == np.int16


def test_unknown_variable(diagram, system, settings):
    assert "does not declare colour" in refusal(diagram.assign(colour=1.0), system, settings)


def test_missing_variable(diagram, system, settings):
    assert "lacks period" in refusal(diagram.drop_vars("period"), system, settings)


def test_transposed_variable(diagram, system, settings):
    text = refusal(diagram.assign(period=diagram["period"].T), system, settings)
    assert "('seed', 'e')" in text
    assert "('e', 'seed')" in text


@pytest.mark.parametrize("value", [1e6, 0.5, np.nan])
def test_value_that_a_code_cannot_hold(diagram, system, settings, value):
    periods = diagram["period"].astype(float)
    periods[0, 0] = value
    assert "period has values that do not fit into int16" in refusal(diagram.assign(period=periods), system, settings)


def test_number_in_place_of_a_name(diagram, system, settings):
    assert "state holds" in refusal(diagram.assign_coords(state=[1.0]), system, settings)


def test_unknown_kind(diagram, system, settings):
    assert "trajectory" in refusal(diagram, system, settings, kind="diagram")


def test_the_dataset_given_stays_as_it_was(diagram, system, settings):
    before = diagram.copy(deep=True)
    label(diagram, KIND, system=system, settings=settings)
    assert diagram.identical(before)


def test_datasets_share_no_attributes(diagram, system, settings):
    one, other = (label(diagram, KIND, system=system, settings=settings) for _ in range(2))
    one["outcome"].attrs["flag_meanings"] = "mine"
    del one["e"].attrs["comment"]
    assert other["outcome"].attrs["flag_meanings"] != "mine"
    assert "comment" in other["e"].attrs
    with pytest.raises(ValueError, match="read-only"):
        one["outcome"].attrs["flag_values"][0] = 7


def test_labels_are_those_of_the_present_index(diagram, system, settings):
    moved = label(diagram.assign_coords(e=diagram["e"] + 1.0), KIND, system=system, settings=settings)
    assert moved.sel(e=float(diagram["e"][1]) + 1.0).equals(moved.isel(e=1))
    assert label(diagram, KIND, system=system, settings=settings).indexes["e"].equals(diagram.indexes["e"])
