"""Every variable says what it is, and codes say what they mean."""

import netCDF4
import numpy as np
import pytest

from chaosdrill.dataset import SCHEMA, Outcome, label

KIND = "bifurcation-diagram"


@pytest.fixture
def labelled(diagram, system, settings):
    return label(diagram, KIND, system=system, settings=settings)


def test_every_variable_has_name_and_units(labelled):
    for name, variable in labelled.variables.items():
        assert variable.attrs["long_name"], name
        assert variable.attrs["units"], name


def test_a_swept_parameter_takes_the_label_of_the_system(labelled):
    assert labelled["e"].attrs["long_name"] == "coefficient of restitution"


def test_states_have_names_and_long_names(labelled):
    assert labelled["state"].values.tolist() == ["x"]
    assert labelled["state_long_name"].values.tolist() == ["height"]


def test_flags_of_outcomes(labelled):
    flags = labelled["outcome"].attrs
    assert flags["flag_values"].dtype == np.int8
    meanings = dict(zip(flags["flag_values"].tolist(), flags["flag_meanings"].split(), strict=True))
    assert meanings[Outcome.ESCAPED] == "escaped"
    assert len(meanings) == len(Outcome)


def test_names_with_blanks_stay_one_meaning(system):
    import xarray as xr

    ds = xr.Dataset(
        {
            "states": (("time", "state"), np.zeros((2, 1))),
            "mode": ("time", [0, 1]),
            "path": ("time", [0.0, 1.0]),
            "event_time": ("event", [0.5]),
            "event_kind": ("event", [0]),
            "event_speed": ("event", [1.0]),
            "event_state_before": (("event", "state"), [[0.0]]),
            "event_state_after": (("event", "state"), [[0.0]]),
            "outcome": ((), 0),
        },
        coords={"time": [0.0, 1.0], "state": ["x"]},
    )
    labelled = label(ds, "trajectory", system=system, settings={})
    assert labelled["mode"].attrs["flag_meanings"].split() == ["free_flight", "held"]
    assert labelled["event_kind"].attrs["flag_meanings"].split() == ["hit_hard_"]
    assert labelled["path"].attrs["long_name"] == "path travelled"


def test_coordinates_have_no_fill_value_in_the_file(labelled, tmp_path):
    labelled.to_netcdf(tmp_path / "a.nc", engine="netcdf4")
    with netCDF4.Dataset(tmp_path / "a.nc") as file:
        assert "_FillValue" not in file["e"].ncattrs()
        assert file["outcome"].dtype == np.int8


@pytest.mark.parametrize("kind", SCHEMA)
def test_the_table_is_sound(kind):
    for name, variable in SCHEMA[kind].items():
        assert name == variable.name
        assert variable.long_name, name
        assert variable.doc.endswith("."), name
        # these would come back from a file as dates or time spans
        assert variable.units not in ("", "seconds", "minutes", "hours", "days"), name
        assert variable.dtype == "str" or np.dtype(variable.dtype).kind in "if", name
        assert len(set(variable.dims)) == len(variable.dims), name
        assert not variable.flags or variable.dtype == "i1", name
