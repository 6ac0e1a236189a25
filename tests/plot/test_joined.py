"""Joined runs are drawn each by itself, with its own events."""

import re

import numpy as np
import pytest
import xarray as xr

import chaosdrill as cd
from chaosdrill.errors import ArchiveError
from chaosdrill.plot import plot_archive
from chaosdrill.plot.joined import MOST_RUNS, runs_of
from chaosdrill.plot.trajectories import phase_portrait, time_history
from chaosdrill.reports.tables import event_counts


@pytest.fixture
def runs(ball):
    """The ball, and another of twice the height and speed whose last four events are missing."""
    other = ball.isel(event=slice(6)).copy()
    for name in ("state", "event_state_before", "event_state_after"):
        other[name] = 2 * other[name]
    return {"low": ball, "high": other}


@pytest.fixture
def joined(runs):
    return cd.join(runs)


def test_taken_apart_they_are_what_was_joined(runs, joined):
    for (name, run), (expected, whole) in zip(runs_of(joined), runs.items(), strict=True):
        assert name == expected
        for variable in ("state", "mode", "event_time", "event_state_after", "outcome"):
            np.testing.assert_array_equal(run[variable].values, whole[variable].values)


def test_a_line_for_each_run_in_its_colour(joined):
    state = time_history(joined).axes[1]
    lines = {line.get_label(): line for line in state.lines if line.get_linestyle() == "-"}
    assert list(lines) == ["low", "high"]
    assert lines["low"].get_color() != lines["high"].get_color()
    np.testing.assert_allclose([line.get_ydata().max() for line in lines.values()], [0.5, 1.0])


def test_events_stand_on_the_line_of_their_own_run(joined):
    speed = time_history(joined).axes[2]
    marked = {
        line.get_color(): (line.get_xdata().size, set(line.get_ydata().tolist()))
        for line in speed.lines
        if line.get_linestyle() == "None"
    }
    colours = [line.get_color() for line in speed.lines if line.get_linestyle() == "-"]
    assert marked == {colours[0]: (10, {-1.0}), colours[1]: (6, {-2.0})}


def test_the_portrait_shows_each_run(joined):
    axes = phase_portrait(joined).axes[0]
    extents = {
        line.get_label(): np.nanmax(line.get_xdata()) for line in axes.lines if line.get_label() in ("low", "high")
    }
    assert (extents["low"], extents["high"]) == (0.5, 1.0)


def test_runs_that_are_not_shown_are_told(ball):
    figure = time_history(cd.join({f"run {i}": ball for i in range(MOST_RUNS + 3)}))
    assert figure.axes[0].get_title().startswith(f"first {MOST_RUNS} of {MOST_RUNS + 3} runs")
    assert len([line for line in figure.axes[1].lines if line.get_linestyle() == "-"]) == MOST_RUNS


def test_pictures_and_report_of_an_archive(joined, tmp_path):
    path = cd.save(joined, tmp_path / "join.nc")
    assert [file.name for file in plot_archive(path)] == ["join-time-history.png", "join-phase-portrait.png"]
    made = cd.report(path)
    assert (made.pictures, made.faults) == (2, ())


def test_the_report_counts_the_events_of_each_run(joined):
    found = re.findall(r"<t[hd][^>]*>([^<]*)</t[hd]>", event_counts(joined))
    assert found[4:] == ["low", "bounce_off", "10", "1", "high", "bounce_off", "6", "1"]


@pytest.mark.parametrize(
    "spoil",
    [
        lambda ds: ds.drop_vars("event_count"),
        lambda ds: ds.assign(event_count=("run", [10, 7])),
        lambda ds: ds.assign(event_count=("run", [17, -1])),
        lambda ds: xr.concat([ds.isel(run=0, drop=True).drop_vars("event_count")] * 2, "e"),
    ],
    ids=["no counts", "too many", "negative", "other dimension"],
)
def test_runs_that_cannot_be_told_apart_are_refused_with_the_remedy(joined, spoil):
    for draw in (time_history, phase_portrait):
        with pytest.raises(ArchiveError, match=r"join runs by chaosdrill\.join"):
            draw(spoil(joined))


def test_what_is_drawn_is_what_the_caption_names(ball, joined):
    assert time_history(ball).get_label() == "penetration and states over time, with events and modes"
    assert time_history(joined).get_label() == "penetration and states over time, a colour for each run, with events"
    plain = ball.drop_vars("penetration").isel(event=slice(0))
    plain["mode"].attrs |= {"flag_values": np.array([0], dtype=np.int8), "flag_meanings": "dry"}
    plain["mode"] = 0 * plain["mode"]
    assert time_history(plain).get_label() == "states over time"
