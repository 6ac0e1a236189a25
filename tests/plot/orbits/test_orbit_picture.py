"""One orbit with its events, multipliers and Newton's residuals; a search with all of its orbits; and their doubts."""

from dataclasses import replace

import numpy as np
import pytest

from chaosdrill.dataset import Outcome
from chaosdrill.orbits.results import Checks
from chaosdrill.plot.orbit import orbit


def test_events_are_told_in_their_order(as_orbit, found):
    title = orbit(as_orbit(found)).get_suptitle()
    assert title.startswith("stable orbit of period 2, time 2; returns to within 3.0e-15")
    assert title.endswith("events: hit, slip forward, hit")


def test_jumps_join_both_sides_of_an_event(as_orbit, found):
    axes = orbit(as_orbit(found)).axes[0]
    assert [text.get_text() for text in axes.get_legend().get_texts()] == [
        "hit",
        "slip forward",
        "once a forcing period",
    ]
    jumps = axes.get_lines()[0].get_xydata()
    np.testing.assert_array_equal(jumps[:3], [[1.0, 0.5], [1.0, -0.5], [np.nan, np.nan]])
    np.testing.assert_array_equal(axes.get_lines()[-1].get_xydata(), [[0.4, 0.3], [0.6, -0.1]])


def test_multipliers_are_told_in_numbers(as_orbit, found):
    title = orbit(as_orbit(found)).axes[1].get_title()
    assert title == "μ₁, μ₂ = −0.261 ± 0.6509i\n|μ₁| = |μ₂| = 0.7012"
    lost = replace(found, multipliers=np.array([-3.0, 0.0], dtype=complex))
    assert orbit(as_orbit(lost)).axes[1].get_title() == "μ₁ = −3\nμ₂ = 0 (rank lost)\n1 outside of the picture"


def test_residuals_fall_on_a_logarithmic_axis(as_orbit, found):
    axes = orbit(as_orbit(found)).axes[2]
    assert axes.get_yscale() == "log"
    values = axes.get_lines()[0].get_ydata()
    np.testing.assert_array_equal(values[:3], [1e-1, 1e-3, 1e-7])
    # zero has no place on it, and is told
    assert 0 < values[3] < 2.3e-16
    assert "0" in [text.get_text() for text in axes.texts]


def test_an_orbit_that_disagrees_with_itself_says_so(as_orbit, found):
    doubtful = replace(found, checks=Checks(np.zeros(2), 0.2, 0.0, 0.0, False, "exponents"))
    figure = orbit(as_orbit(doubtful, disagreement="the exponents differ by 0.2"))
    assert figure.get_suptitle().endswith("the numbers disagree: the exponents differ by 0.2")
    assert figure.get_suptitle().startswith("stable orbit of period 2")


@pytest.mark.parametrize("outcome", [Outcome.NO_ORBIT, Outcome.INADMISSIBLE, Outcome.OPEN])
def test_what_is_no_orbit_is_said_and_not_drawn(as_orbit, found, outcome):
    nothing = {name: np.zeros(0) for name in ("event_times", "event_speeds")}
    nothing |= {name: np.zeros((0, 2)) for name in ("states", "event_states_before", "event_states_after")}
    none = replace(found, outcome=outcome, event_transitions=np.zeros(0, dtype=int), **nothing)
    figure = orbit(as_orbit(none, message="words about it"))
    assert figure.get_suptitle() == f"{outcome.meaning.replace('_', ' ')}; words about it"
    assert [axes.get_ylabel() for axes in figure.axes] == ["residual"]


def test_what_there_is_to_say_of_an_orbit_is_said(as_orbit, found):
    assert orbit(as_orbit(found, message="its period is 2, not 4")).get_suptitle().endswith("its period is 2, not 4")


def test_events_are_told_apart_from_the_section(as_orbit, found):
    lines = orbit(as_orbit(found)).axes[0].get_lines()
    colours = {line.get_label(): line.get_color() for line in lines if not line.get_label().startswith("_")}
    assert len(set(colours.values())) == len(colours) == 3


def test_one_state_is_drawn_over_time(as_orbit, found):
    axes = orbit(as_orbit(found).isel(state=[0], multiplier=[0])).axes[0]
    assert axes.get_xlabel() == "time since the start of the period"
    np.testing.assert_array_equal(axes.get_lines()[-1].get_xydata(), [[0.0, 0.4], [1.0, 0.6]])


def test_a_search_shows_all_orbits_by_period_and_stability(as_orbit, found):
    other = replace(found, period=1, states=np.array([[0.2, 0.2]]), multipliers=np.array([2.0, 0.5], dtype=complex))
    figure = orbit(as_orbit(found, found, other, search=True))
    names = [text.get_text() for text in figure.legends[0].get_texts()]
    assert names == ["period 1: 1 unstable", "period 2: 2 stable"]
    assert figure.axes[1].get_title() == "1 of 6 multipliers\nlie outside of the picture"


def test_one_orbit_of_a_search_is_drawn_without_what_fills_it_up(as_orbit, found):
    longer = replace(found, period=3, states=np.zeros((3, 2)), newton=np.ones(9))
    alone, taken = orbit(as_orbit(found)), orbit(as_orbit(longer, found, search=True).isel(orbit=1))
    for first, second in zip(alone.axes, taken.axes, strict=True):
        for a, b in zip(first.get_lines(), second.get_lines(), strict=True):
            np.testing.assert_array_equal(a.get_xydata(), b.get_xydata())


def test_an_empty_search_is_said(as_orbit):
    assert orbit(as_orbit(search=True, message="nothing found")).get_suptitle() == "no orbit found; nothing found"


def test_a_search_counts_the_orbits_that_disagree(as_orbit, found):
    doubtful = replace(found, checks=Checks(np.zeros(2), 0.2, 0.0, 0.0, False, "exponents"))
    figure = orbit(as_orbit(found, doubtful, search=True, disagreement="orbit 2: exponents"))
    assert figure.legends[0].get_title().get_text() == "the numbers of 1 of 2 orbits disagree: orbit 2: exponents"
