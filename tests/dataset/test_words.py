"""Codes in words and events as a table: by names, however many runs there are and whatever was selected."""

import subprocess
import sys

import numpy as np
import pytest
import xarray as xr

import chaosdrill as cd
from chaosdrill.errors import ArchiveError, ChaosdrillError


@pytest.fixture(scope="module")
def system():
    return cd.build("impact-oscillator")


@pytest.fixture(scope="module")
def run(system):
    return cd.trajectory(system, periods=30, samples=2)


def test_the_outcome_of_one_run_is_a_word(run):
    assert run.cd.outcome == "ok"


def test_advice_tells_each_outcome_once_with_its_number(system, run):
    assert run.cd.advice == f"ok: {cd.Outcome.OK.advice}"
    start = system.with_parameters(wall=-0.5, amplitude=0.1).with_initial(x=-0.6)
    ended = cd.trajectory(start, periods=30)
    advice, where = ended.cd.advice.split("\n")
    assert advice == f"stalled: {cd.Outcome.STALLED.advice}"
    assert where.startswith("events follow each other while no time passes: in mode 'free', time ")
    many = xr.concat([run["outcome"], ended["outcome"], ended["outcome"]], "run").to_dataset()
    first, second = many.cd.advice.split("\n")
    assert first.startswith("stalled (2 of 3): Events continued")
    assert second.startswith("ok (1 of 3): The run reached its end")


def test_outcomes_of_many_keep_their_places(system):
    ds = cd.bifurcation_diagram(system, {"omega": [2.4, 2.5]}, transient=50, periods=20)
    words = ds.cd.outcome
    assert words.dims == ds["outcome"].dims
    for omega in (2.4, 2.5):
        assert (
            str(words.sel(omega=omega, seed="fixed 1").values)
            == cd.Outcome(int(ds["outcome"].sel(omega=omega, seed="fixed 1"))).meaning
        )


def test_events_obey_the_law_of_impact(system, run):
    table = run.cd.events
    assert len(table) == run.sizes["event"] > 10
    assert set(table["kind"]) == {"impact"}
    np.testing.assert_allclose(table["v_after"], -system.parameters["e"] * table["v_before"], rtol=1e-13)
    np.testing.assert_array_equal(table["x_before"], table["x_after"])
    assert list(run.sel(state="v").cd.events.filter(like="_")) == ["mode_before", "mode_after", "v_before", "v_after"]


def test_events_of_orbits_are_those_of_each(system):
    found = cd.periodic_orbit(system, start="search", max_period=2)
    table = found.cd.events
    for number in found["orbit"].values:
        one = found.sel(orbit=number)
        count = int(one["event_count"])
        assert (number in table.index.get_level_values("orbit")) == (count > 0)
        if count:
            np.testing.assert_array_equal(table.loc[number]["time"], one["event_time"].values[:count])


def test_events_of_joined_runs(system, run):
    other = cd.trajectory(system.with_initial(x=-0.5), periods=30, samples=2)
    joined = cd.join({"one": run, "other": other})
    table = joined.cd.events
    assert table.loc["other"].equals(other.cd.events)
    assert table.loc["one"].equals(run.cd.events)
    with pytest.raises(ChaosdrillError, match="joined runs"):
        _ = joined.sel(run="one").cd.events


def test_a_code_without_a_meaning_is_told_as_it_is(run):
    altered = run.assign(mode=run["mode"].copy(data=np.where(np.arange(run.sizes["time"]) == 3, 9, 0).astype("i1")))
    altered["mode"].attrs = run["mode"].attrs
    words = altered.cd.words("mode").values
    assert (words[3], words[4]) == ("code 9", "free")


@pytest.mark.parametrize(("name", "told"), [("states", "holds numbers"), ("stats", "no variable 'stats'")])
def test_what_is_no_code_is_refused(run, name, told):
    with pytest.raises(ChaosdrillError, match=told):
        run.cd.words(name)


def test_what_has_no_events_says_so():
    with pytest.raises(ChaosdrillError, match="has no events"):
        _ = xr.Dataset().cd.events
    assert cd.trajectory(cd.build("lorenz"), duration=0.5).cd.events.empty


@pytest.mark.parametrize("first", ["xarray", "chaosdrill"])
def test_the_accessor_is_there_in_any_order_of_imports(first, run, tmp_path):
    path = cd.save(run, tmp_path / "run.nc")
    program = {
        "xarray": f"import xarray, chaosdrill\nds = xarray.open_dataset({str(path)!r})",
        "chaosdrill": f"import chaosdrill\nds = chaosdrill.open({str(path)!r}).to_dataset()",
    }[first]
    told = subprocess.run([sys.executable, "-c", f"{program}\nprint(ds.cd.outcome)"], capture_output=True, text=True)
    assert told.stdout == "ok\n"


@pytest.mark.parametrize("part", [lambda run: run.isel(event=0), lambda run: run[["event_time", "event_speed"]]])
def test_a_part_without_a_table_of_events_is_told(run, part):
    with pytest.raises(ChaosdrillError, match=r"isel\(event=\[0\]\)|without event_kind"):
        _ = part(run).cd.events
    assert len(run.isel(event=[0]).cd.events) == 1


def test_runs_are_joined_by_text(run):
    with pytest.raises(ArchiveError, match=r"names must be text, as in '1'"):
        cd.join({1: run, 2: run})


@pytest.mark.parametrize(
    "add",
    [
        lambda run: run.assign_attrs(creator_name=None),
        lambda run: run.assign_attrs({"a/b": 1}),
        lambda run: run.assign({"a/b": 1}),
        lambda run: run.assign({3: 1}),
        lambda run: run.assign(c=1j),
        lambda run: run.assign(c=((), object())),
    ],
    ids=["none", "slash", "slash-variable", "number-name", "complex", "object"],
)
def test_what_netcdf_cannot_hold_is_told(run, add, tmp_path):
    with pytest.raises(ArchiveError, match=r"cannot hold|no name in an archive can|is no text|holds objects"):
        cd.save(add(run), tmp_path / "run.nc")
    assert not list(tmp_path.iterdir())


@pytest.fixture(scope="module")
def many(system):
    return cd.bifurcation_diagram(system, {"omega": [2.4, 2.5, 2.6]}, transient=20, periods=20, exponents=0)


KEPT = {
    "isel": lambda ds: ds.isel(omega=[2, 0]),
    "sel": lambda ds: ds.sel(omega=2.45, method="nearest"),
    "sorted": lambda ds: ds.sortby("omega", ascending=False),
    "stacked": lambda ds: ds.stack(point=("omega", "seed")),
    "joined": lambda ds: xr.concat([ds, ds], xr.IndexVariable("run", ["one", "two"])),
    "merged": lambda ds: xr.merge([ds[["outcome"]], ds[["period"]]]),
    "renamed": lambda ds: ds.rename(omega="w").transpose(),
    "copied": lambda ds: ds.copy(deep=True),
}
COMPUTED = {
    "difference": lambda ds: ds - ds,
    "sum": lambda ds: ds + 0,
    "mean": lambda ds: ds.mean(),
    "largest": lambda ds: ds.max("omega"),
    "step": lambda ds: ds.diff("omega"),
    "comparison": lambda ds: ds == ds,
    "masked": lambda ds: ds.where(ds["omega"] > 0),
}


@pytest.mark.parametrize("act", KEPT.values(), ids=KEPT)
def test_what_was_selected_or_joined_is_still_an_outcome(many, act):
    part = act(many)
    words = np.array([cd.Outcome(code).meaning for code in part["outcome"].values.ravel()], dtype=str)
    np.testing.assert_array_equal(part.cd.words("outcome").values.ravel(), words)


@pytest.mark.parametrize("act", COMPUTED.values(), ids=COMPUTED)
def test_what_was_computed_from_outcomes_is_none(many, act, tmp_path):
    computed = act(many)
    # where xarray drops attributes with arithmetic, as it did before 2025.11, nobody knows of what they were computed
    with pytest.raises(ChaosdrillError, match="holds numbers"):
        _ = computed.cd.outcome
    if computed["outcome"].dtype != bool and "kind" in computed.attrs:
        with pytest.raises(ChaosdrillError, match="holds numbers"):
            _ = cd.open(cd.save(computed, tmp_path / "computed.nc")).to_dataset().cd.outcome


def test_places_without_a_run_have_no_outcome(many):
    words = many.reindex(omega=[2.4, 9.0]).cd.outcome
    assert words.sel(omega=9.0).values.tolist() == ["none"]
    assert words.sel(omega=2.4).identical(many.cd.outcome.sel(omega=2.4))
