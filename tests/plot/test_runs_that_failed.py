"""A run that failed has little to draw: its picture says why, and what to do."""

import matplotlib as mpl
import numpy as np
import pytest

import chaosdrill as cd
from chaosdrill.dataset import Outcome
from chaosdrill.plots.trajectories import phase_portrait, time_history


@pytest.mark.parametrize("outcome", [Outcome.ESCAPED, Outcome.INVALID_START, Outcome.NONFINITE, Outcome.STALLED])
def test_a_run_that_failed_says_so_with_its_advice(ball, outcome):
    names = " ".join(one.meaning for one in Outcome)
    flags = {"flag_values": np.arange(len(Outcome), dtype=np.int8), "flag_meanings": names}
    failed = ball.isel(time=slice(1), event=slice(0)).assign(outcome=((), np.int8(outcome), flags))
    told = f"{outcome.meaning.replace('_', ' ')}. {outcome.advice}"
    for draw in (time_history, phase_portrait):
        figure = draw(failed)
        title = figure.legends[0].get_title().get_text() if figure.legends else figure.get_suptitle()
        figure.draw_without_rendering()
        shown = figure.legends[0].get_title() if figure.legends else figure.texts[-1]
        assert title == told
        assert shown.get_window_extent().x1 <= figure.bbox.x1
    axes = mpl.figure.Figure().subplots()
    cd.plot(failed, ax=axes)
    assert [text.get_text().replace("\n", " ") for text in axes.texts] == [told]
    assert time_history(ball).get_suptitle() == ""


@pytest.mark.parametrize(
    "analysis",
    [cd.lyapunov_spectrum, cd.poincare_section, cd.zero_one_test, cd.regularity, cd.dimensions],
)
def test_a_run_that_came_to_rest_before_its_section_says_so(analysis):
    """x begins below 1/2 and rests; the pictures were empty."""
    mark = cd.Transition("half", "all", "all", "x - 1/2", direction=-1)
    rests = cd.HybridSystem(states="x", modes={"all": {"x": "-x"}}, transitions=[mark], initial={"x": 0.4})
    assert f"equilibrium. {Outcome.EQUILIBRIUM.advice}" in _told(analysis(rests, at="half", periods=50))
    assert _told(cd.lyapunov_spectrum(rests, duration=100, transient=100)) == ""


@pytest.mark.parametrize("analysis", [cd.zero_one_test, cd.dimensions])
def test_a_run_that_stalled_has_a_picture_with_room_for_why(analysis):
    """Under the long advice the axes of dimensions had no height left; and a ball that stalls does move."""
    bounce = cd.Transition("impact", "flight", "flight", "x", direction=-1, reset={"v": "-v/2"})
    modes = {"flight": {"x": "v", "v": -1}}
    falling = cd.HybridSystem(states="x v", modes=modes, transitions=[bounce], initial={"x": 1.0})
    ds = analysis(falling, at="impact", periods=500)
    assert ds.cd.outcome == "stalled"
    figure = cd.plot(ds).figure
    figure.draw_without_rendering()
    assert _told(ds).endswith(f"stalled. {Outcome.STALLED.advice}")
    assert all(axes.get_title() == "" and axes.get_window_extent().height > 0 for axes in figure.axes)


def _told(ds):
    figure = cd.plot(ds).figure
    title = figure.legends[0].get_title().get_text() if figure.legends else figure.get_suptitle()
    return title.replace("\n", " ")


def test_of_several_runs_those_that_failed_are_named(joined):
    codes = joined["outcome"].copy(data=np.array([0, 4], dtype=np.int8))
    figure = time_history(joined.assign(outcome=codes))
    assert figure.legends[0].get_title().get_text() == f"run high: escaped. {Outcome.ESCAPED.advice}"
