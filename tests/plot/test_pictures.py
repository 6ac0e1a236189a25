"""What the pictures say: labels, legends and titles come from the dataset, and nothing is drawn that is not there."""

import numpy as np
import pytest

from chaosdrill.plot.convergence import convergence
from chaosdrill.plot.poincare import poincare
from chaosdrill.plot.trajectories import phase_portrait, time_history


def _labels(axes):
    return [text.get_text() for text in axes.get_legend().get_texts()]


def test_time_history_names_quantities_units_events_and_modes(ball):
    figure = time_history(ball)
    assert [panel.get_ylabel() for panel in figure.axes] == ["penetration (mm)", "x", "v"]
    assert figure.axes[-1].get_xlabel() == "model time"
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["bounce off", "dry (mode)", "wet (mode)"]


def test_a_long_record_says_which_part_is_shown(ball):
    many = ball.isel(event=np.repeat(np.arange(10), 5))
    title = time_history(many).axes[0].get_title()
    assert title == "last 7 of 10 forcing periods"
    assert time_history(many.drop_vars("forcing_period")).axes[0].get_title() == "last 14 of 20 units of time"


def test_phase_portrait_shows_the_stop_and_the_section(ball):
    axes = phase_portrait(ball).axes[0]
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("x", "v")
    assert _labels(axes) == ["flow", "jump", "once a forcing period", "bounce off at x = 0"]


def test_flow_is_not_drawn_across_a_jump(ball):
    x, v = phase_portrait(ball).axes[0].lines[0].get_data()
    assert np.isnan(x).sum() == 10
    assert np.nanmax(np.abs(np.diff(v))) < 0.11


def test_section_names_its_period_and_multipliers(section):
    axes = poincare(section).axes[0]
    assert axes.get_title() == "period 2, once a forcing period; multipliers 0.5 ± 0.25i"
    assert len(axes.collections[0].get_offsets()) == 2


def test_section_without_a_period_shows_every_point(section):
    axes = poincare(section.assign(period=0)).axes[0]
    assert axes.get_title() == "40 points once a forcing period"
    assert len(axes.collections[0].get_offsets()) == 40


def test_convergence_names_the_lost_exponent_and_draws_the_others(spectrum):
    figure = convergence(spectrum)
    assert [panel.get_title() for panel in figure.axes] == ["λ₁ = 0.015(1)", "λ₂ = −0.0879(2)"]
    assert figure.get_suptitle().startswith("λ₃ = −∞")
    low, high = figure.axes[0].get_ylim()
    assert low < 0.015 - 0.001
    assert high > 0.015 + 0.001


def test_long_names_of_states_stand_on_the_axes(ball):
    named = ball.assign_coords(state_long_name=("state", ["height above the floor", "speed"]))
    axes = phase_portrait(named).axes[0]
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("height above the floor x", "speed v")


@pytest.mark.parametrize("known", [0, 1])
def test_one_state_is_drawn_against_the_iterate(section, known):
    axes = poincare(section.isel(state=[0]).assign(period=2 * known)).axes[0]
    assert axes.get_xlabel() == "iterate"
