"""Results of made-up orbits and branches become datasets that fit the table and come back from a file."""

import numpy as np
import pytest

import chaosdrill as cd
from chaosdrill.analysis.orbit_datasets import branches_dataset, numbered, orbits_dataset
from chaosdrill.dataset import BranchEnd, Outcome, Special, described_again, label
from chaosdrill.orbits.results import BranchInfo, BranchResult, Cascade, Checks, FoundOrbit, SpecialPoint
from chaosdrill.orbits.table import nothing
from chaosdrill.workflow import compare


@pytest.fixture(scope="module")
def oscillator():
    return cd.build("impact-oscillator")


def made_up(period=1, impacts=1, outcome=Outcome.PERIODIC):
    """An orbit with numbers that tell their place."""
    rows = 0 if outcome != Outcome.PERIODIC else impacts
    states = np.arange(2.0 * period).reshape(period, 2)[: None if rows or impacts == 0 else 0]
    return FoundOrbit(
        outcome=outcome,
        message="" if outcome == Outcome.PERIODIC else "none near",
        period=period,
        duration=2.5 * period,
        states=states,
        section=states,
        mode=0,
        multipliers=np.array([-0.5 + 0.1j, -0.5 - 0.1j]) if rows else np.full(2, complex(np.nan, np.nan)),
        rank=2,
        residual=1e-15,
        newton=np.array([1e-2, 1e-5, 1e-11]),
        event_times=0.5 + np.arange(rows),
        event_speeds=1.0 + np.arange(rows),
        event_transitions=np.zeros(rows, dtype=np.int64),
        event_states_before=np.ones((rows, 2)),
        event_states_after=-np.ones((rows, 2)),
        checks=Checks(np.array([-0.1, -0.1]), 1e-12, 1e-14, 1e-13, True),
        path_times=np.arange(3.0 * rows),
        path_states=np.ones((3 * rows, 2)),
    )


def branch(parameters=("omega",), cascade=None):
    """Two branches of five points, with one special point."""
    count = 5
    return BranchResult(
        parameters=parameters,
        values=np.arange(count * len(parameters), dtype=float).reshape(count, -1),
        branch=np.array([0, 0, 0, 1, 1]),
        arclength=np.array([0.0, 0.1, 0.2, 0.0, 0.1]),
        period=np.array([1, 1, 1, 2, 2]),
        duration=np.array([1.0, 1.0, 1.0, 2.0, 2.0]),
        state=np.arange(count * 4.0).reshape(count, 2, 2)[:, 0],
        section=np.arange(count * 4.0).reshape(count, 2, 2),
        mode=np.zeros(count, dtype=np.int64),
        multipliers=np.full((count, 2), 0.5 - 0.25j),
        stable=np.array([True, True, False, True, True]),
        special=np.array([0, 0, 2, 0, 0]),
        sequence=np.zeros(count, dtype=np.int64),
        sequences=("impact",),
        smallest_speed=np.full(count, 0.3),
        residual=np.full(count, 1e-14),
        branches=(
            BranchInfo(-1, 1, "from the attractor", "reached the limit", BranchEnd.LIMIT),
            BranchInfo(0, 2, "period doubling", "an impact vanishes", BranchEnd.GRAZING),
        ),
        events=(SpecialPoint(2, Special.PERIOD_DOUBLING, np.arange(4.0, 4.0 + len(parameters)), 1e-10, "doubles"),),
        cascade=cascade,
    )


def labelled(system, raw, kind="periodic-orbit", **settings):
    return label(raw, kind, system=system, settings=settings)


def test_one_orbit_has_no_leading_dimension(oscillator):
    ds = labelled(oscillator, orbits_dataset(oscillator, [made_up(2, 3)]).isel(orbit=0, drop=True))
    assert dict(ds.sizes) == {"state": 2, "iterate": 2, "multiplier": 2, "iteration": 3, "event": 3, "path_point": 9}
    assert ds["orbit_state"].values.tolist() == ds["section"].values[0].tolist() == [0.0, 1.0]
    assert ds["multiplier_imag"].values.tolist() == [0.1, -0.1]
    assert float(ds["smallest_speed"]) == 1.0


def test_orbits_of_a_search_are_filled_up(oscillator):
    ds = labelled(oscillator, orbits_dataset(oscillator, [made_up(2, 1), made_up(3, 2)]))
    assert ds["orbit"].values.tolist() == [1, 2]
    assert ds["section"].dims == ("orbit", "iterate", "state")
    assert np.isnan(ds["section"].values[0, 2]).all()
    assert ds["event_count"].values.tolist() == [1, 2]
    assert ds["event_kind"].values.tolist() == [[0, -1], [0, 0]]
    assert np.isnan(ds["event_time"].values[0, 1])
    assert ds["stable"].values.tolist() == [1, 1]


def test_a_search_that_finds_nothing_is_a_dataset_too(oscillator):
    ds = labelled(oscillator, orbits_dataset(oscillator, []))
    assert ds.sizes["orbit"] == 0
    assert ds["orbit_state"].shape == (0, 2)


def test_no_orbit_leaves_no_number(oscillator):
    failed = made_up(3, outcome=Outcome.NO_ORBIT)
    ds = labelled(oscillator, orbits_dataset(oscillator, [failed]).isel(orbit=0, drop=True))
    assert int(ds["outcome"]) == Outcome.NO_ORBIT
    assert int(ds["period"]) == 0
    assert int(ds["mode"]) == -1
    assert described_again(ds, "periodic-orbit", system=oscillator) is not None
    assert int(ds["stable"]) == int(ds["consistent"]) == 0
    for name in ("orbit_state", "residual", "period_time", "smallest_speed", "multiplier_real"):
        assert np.isnan(ds[name].values).all(), name
    assert ds["newton_residual"].values.tolist() == [1e-2, 1e-5, 1e-11]


def test_an_orbit_without_events_meets_no_guard(oscillator):
    ds = orbits_dataset(oscillator, [made_up(1, 0)])
    assert ds["smallest_speed"].values.tolist() == [np.inf]


def test_codes_of_branches_have_their_names(oscillator):
    ds = labelled(oscillator, branches_dataset(oscillator, branch()), "continuation", sweep={"omega": [2.0, 3.0]})
    assert ds["omega"].dims == ("point",)
    assert ds["special_point"].attrs["flag_meanings"].split()[2] == "period_doubling"
    assert ds.cd.words("branch_end").values.tolist() == ["limit", "grazing"]
    assert ds["orbit_state"].values.tolist() == ds["section"].values[:, 0].tolist()
    assert ds["stable"].attrs["flag_meanings"] == "no yes"
    assert int(ds["outcome"]) == Outcome.PERIODIC


def test_a_curve_has_two_parameters_and_two_values(oscillator):
    result = branch(("omega", "wall"))
    settings = {"sweep": {"omega": [2.0, 3.0], "wall": [0.0, 1.0]}}
    ds = labelled(oscillator, branches_dataset(oscillator, result), "continuation", **settings)
    assert ds["wall"].values.tolist() == [1.0, 3.0, 5.0, 7.0, 9.0]
    assert ds["special_value"].values.tolist() == [4.0]
    assert ds["special_value_2"].values.tolist() == [5.0]


def test_a_cascade_is_kept(oscillator):
    cascade = Cascade(np.array([1.0, 2.0, 2.2]), np.array([1, 2, 4]), np.array([np.nan, np.nan, 5.0]), 2.25, 1e-3)
    ds = labelled(oscillator, branches_dataset(oscillator, branch(cascade=cascade)), "continuation", sweep={"omega": 0})
    assert ds["feigenbaum_ratio"].values[2] == 5.0
    assert float(ds["accumulation"]) == 2.25


def test_no_branch_is_a_dataset_too(oscillator):
    none = nothing(oscillator, ("omega",), Outcome.EQUILIBRIUM, "at rest")
    ds = labelled(oscillator, branches_dataset(oscillator, none), "continuation", sweep={"omega": 0})
    assert ds.sizes["point"] == ds.sizes["branch_number"] == 0
    assert int(ds["outcome"]) == Outcome.EQUILIBRIUM


@pytest.mark.parametrize(
    "raw",
    [
        pytest.param(lambda system: orbits_dataset(system, [made_up(2, 3)]).isel(orbit=0, drop=True), id="one"),
        pytest.param(lambda system: orbits_dataset(system, [made_up(2, 1), made_up(3, 0)]), id="search"),
        pytest.param(lambda system: orbits_dataset(system, []), id="nothing"),
        pytest.param(lambda system: branches_dataset(system, branch()), id="branch"),
    ],
)
def test_nothing_is_lost_in_a_file(oscillator, tmp_path, raw):
    ds = raw(oscillator)
    kind = "continuation" if "branch" in ds else "periodic-orbit"
    ds = labelled(oscillator, ds, kind, sweep={"omega": 0} if kind == "continuation" else None)
    ds = ds.assign_attrs(message="", disagreement="orbit 2: differs")
    import xarray as xr

    assert compare(cd.open(cd.save(ds, tmp_path / "orbit.nc")), xr.DataTree(ds)) == []


def test_messages_name_their_orbit():
    assert numbered(["", "short", ""]) == "orbit 2: short"
