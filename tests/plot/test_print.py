"""Pictures in a column: axes fill it, nothing is cut, and lines are curves."""

from itertools import pairwise

import matplotlib as mpl
import numpy as np
import pytest

import chaosdrill as cd
from chaosdrill.plots import PICTURES
from chaosdrill.plots.curve import Curve, curve_of, rates_of, smoothed
from chaosdrill.plots.trajectories import phase_portrait

# At a column's width axes fill it and nothing is cut, whether the size was set beforehand or afterwards.

COLUMN = 3.35
"""Inches."""


def _texts(figure):
    yield from figure.texts
    for axes in figure.axes:
        if axes.axison:
            yield from (child for child in axes.get_children() if isinstance(child, mpl.text.Text))
            yield from (axes.xaxis.label, axes.yaxis.label)


def _check(figure):
    figure.draw_without_rendering()
    page = figure.bbox
    legends = [*figure.legends, *filter(None, (axes.get_legend() for axes in figure.axes))]
    for artist in [*legends, *(text for text in _texts(figure) if text.get_text())]:
        box = artist.get_window_extent()
        assert box.x0 >= page.x0 - 1, artist
        assert box.x1 <= page.x1 + 1, artist
    left, right = min(axes.bbox.x0 for axes in figure.axes), max(axes.bbox.x1 for axes in figure.axes)
    assert right - left > 0.6 * page.width


@pytest.mark.parametrize("afterwards", [False, True])
@pytest.mark.parametrize("which", ["ball", "section", "spectrum", "diagram", "chart", "basin"])
def test_a_column_is_filled_and_nothing_is_cut(request, which, afterwards):
    dataset = request.getfixturevalue(which)
    if which == "ball":
        dataset = dataset.assign_coords(state_long_name=("state", ["height of the ball above the floor", "speed"]))
    for picture in PICTURES:
        if picture.suits(dataset):
            with mpl.rc_context({} if afterwards else {"figure.figsize": (COLUMN, 3.2)}):
                figure = picture.draw(dataset)
            if afterwards:
                figure.set_size_inches(COLUMN, 3.6)
            _check(figure)


@pytest.mark.parametrize("settings", [{"figure.figsize": (COLUMN, 1.2), "font.size": 8.0}, {"font.size": 20.0}])
@pytest.mark.parametrize("which", ["ball", "spectrum", "diagram"])
def test_panels_keep_room_in_a_low_figure_and_beside_large_text(request, which, settings):
    with mpl.rc_context(settings):
        figure = cd.plot(request.getfixturevalue(which)).figure
    figure.draw_without_rendering()
    assert figure.get_size_inches()[0] == settings.get("figure.figsize", (7.2, 0))[0]
    # the strip of periods is low at any size
    panels = figure.axes[: 3 if which == "diagram" else None]
    for axes in panels:
        assert axes.bbox.height > 2.5 * settings["font.size"] * figure.dpi / 72


def test_many_entries_of_legends_leave_a_diagram_its_room_in_a_column(diagram):
    diagram["period"][:, 0] = np.arange(101) // 10
    diagram["lyapunov_exponent"][40:50] = -np.inf
    with mpl.rc_context({"figure.figsize": (COLUMN, 2.6), "font.size": 8.0}):
        few, many = cd.plot(diagram.isel(q=slice(25))).figure, cd.plot(diagram).figure
        for figure in (few, many):
            figure.draw_without_rendering()
    heights = [figure.axes[0].bbox.height / figure.dpi for figure in (few, many)]
    assert heights[1] > 0.75 * heights[0]


def test_a_long_word_beside_a_low_panel_shrinks_and_grows_back(ball):
    names = ["penetration of the mass", "penetration of the bit"]
    figure = cd.plot(ball.assign_coords(state_long_name=("state", names))).figure
    size, labels = figure.get_size_inches().tolist(), [axes.yaxis.label for axes in figure.axes]
    letters = [label.get_fontsize() for label in labels]
    figure.set_size_inches(COLUMN, 2.4)
    figure.draw_without_rendering()
    boxes = [label.get_window_extent() for label in labels]
    assert not any(upper.overlaps(lower) for upper, lower in pairwise(boxes))
    figure.set_size_inches(size[0], 8.0)
    figure.draw_without_rendering()
    assert [label.get_fontsize() for label in labels] == letters


def test_a_legend_takes_its_columns_back_where_there_is_room(chart):
    figure = cd.plot(chart).figure
    wide, legend = figure.get_size_inches().tolist(), figure.legends[0]
    heights = []
    for size in (wide, (2.6, 4.0), wide):
        figure.set_size_inches(size)
        figure.draw_without_rendering()
        heights.append(legend.get_window_extent().height)
    assert heights[1] > heights[0]
    assert heights[2] == pytest.approx(heights[0], abs=1)


def test_a_label_is_whole_again_where_there_is_room(ball):
    long = "height of the ball above the floor of the room in which it was dropped"
    figure = phase_portrait(ball.assign_coords(state_long_name=("state", [long, "speed"])))
    axes = figure.axes[0]
    figure.set_size_inches(2.0, 3.0)
    figure.draw_without_rendering()
    assert axes.get_xlabel().replace("\n", " ") == long
    assert "\n" in axes.get_xlabel()
    figure.set_size_inches(8.0, 3.0)
    figure.draw_without_rendering()
    assert axes.get_xlabel() == long
    axes.set_xlabel("x")
    figure.draw_without_rendering()
    assert axes.get_xlabel() == "x"


# Lines bend where samples are few, and go through them all.


def _turns(line):
    steps = np.diff(line, axis=0)
    steps = steps[np.isfinite(steps).all(axis=1) & (np.hypot(*steps.T) > 1e-9)]
    return np.abs(np.diff(np.unwrap(np.arctan2(steps[:, 1], steps[:, 0]))))


@pytest.fixture(scope="module")
def circle():
    return cd.HybridSystem(
        states="x v", modes={"free": {"x": "v", "v": "-x"}}, initial={"x": 1.0, "v": 0.0}, name="circle"
    )


@pytest.mark.parametrize("samples", [5, 8, 16])
def test_a_circle_is_round(circle, samples):
    """x = cos t, v = -sin t from few samples a turn: a cubic with the true slopes is off by h^4/384 in each state."""
    run = cd.trajectory(circle, duration=6 * np.pi, samples=3 * samples)
    line = phase_portrait(run).axes[0].lines[0].get_xydata()
    step = 2 * np.pi / samples
    # by slopes of parabolas, where samples are many enough for them, by h^3/24 or less
    assert np.abs(np.hypot(*line.T) - 1).max() < (step**4 / 384 if step > np.radians(20) else step**3 / 24)
    # each stretch turns by a few degrees, where the polygon turned by a whole step
    assert _turns(line).max() < np.radians(10)
    drawn = {tuple(point) for point in np.round(line, 9).tolist()}
    assert {tuple(point) for point in np.round(run["states"].values, 9).tolist()} <= drawn


def test_without_equations_it_is_round_as_well(ball):
    """Parabolas of a ball from five samples a flight: the slopes of parabolas are exact."""
    few = ball.isel(time=slice(0, 401, 8))
    line = phase_portrait(few).axes[0].lines[0].get_xydata()
    line = line[np.isfinite(line).all(axis=1)]
    np.testing.assert_allclose(line[:, 0], (1 - line[:, 1] ** 2) / 2, atol=1e-9)
    assert len(line) > 3 * few.sizes["time"]


@pytest.mark.parametrize("known", [True, False])
def test_curves_turn_by_the_equations_of_their_own_parameters(known, monkeypatch):
    ds = cd.trajectory(cd.build("lorenz").with_parameters(rho=30.0), duration=2.0, samples=9)
    cd.trajectory(cd.build("lorenz"), duration=0.1)
    if not known:
        monkeypatch.setattr("chaosdrill.model.system._listed", {})
    curve = curve_of(ds)
    x, y, z = curve.state.T
    sigma, beta = 10.0, 8.0 / 3.0
    rates = np.column_stack([sigma * (y - x), x * (30.0 - z) - y, x * y - beta * z])
    np.testing.assert_allclose(rates_of(ds, curve), rates, rtol=1e-12, atol=1e-10)


def test_what_jumps_between_samples_is_not_overshot():
    time = np.arange(12.0)
    state = np.stack([np.where(time < 6, 0.0, 1.0), np.sin(time)], axis=1)
    drawn = smoothed(Curve(time, state, np.zeros(12, dtype=int))).state[:, 0]
    assert drawn.min() >= -1e-12
    assert drawn.max() <= 1 + 1e-12


def test_what_only_rises_is_drawn_rising():
    time = np.array([0.0, 0.3, 0.6, 0.9, 1.2, 1.5, 1.54])  # as a neuron does before a spike
    state = np.stack([np.tan(time), np.sin(9 * time)], axis=1)
    rates = np.stack([1 + np.tan(time) ** 2, 9 * np.cos(9 * time)], axis=1)
    drawn = smoothed(Curve(time, state, np.zeros(len(time), dtype=int)), lambda: rates).state[:, 0]
    assert len(drawn) > len(time)
    assert (np.diff(drawn) > 0).all()
