"""Pictures of orbits, of branches and of curves."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
import xarray as xr
from support import closed_derivatives as closed

import chaosdrill as cd
from chaosdrill.dataset import BranchEnd, Outcome, Special, label
from chaosdrill.orbits.results import Checks
from chaosdrill.plots import plot_archive
from chaosdrill.plots.branches import branches, curves
from chaosdrill.plots.contents import fits
from chaosdrill.plots.orbits import FEIGENBAUM, cascade, multipliers, orbit

# One orbit with its events, multipliers and Newton's residuals; a search with all of its orbits; and their doubts.


def test_events_are_told_in_their_order(as_orbit, found):
    title = orbit(as_orbit(found)).get_suptitle()
    assert title.startswith("stable orbit of period 2, time 2; returns to within 3.0e-15")
    assert title.endswith("events: hit, slip forward, hit")


def test_jumps_join_both_sides_of_an_event(as_orbit, found):
    axes = orbit(as_orbit(found)).axes[0]
    assert [text.get_text() for text in axes.get_legend().get_texts()] == [
        "path",
        "hit",
        "slip forward",
        "once per forcing period",
    ]
    jumps = axes.get_lines()[1].get_xydata()
    np.testing.assert_array_equal(jumps[:3], [[1.0, 0.5], [1.0, -0.5], [np.nan, np.nan]])
    np.testing.assert_array_equal(axes.get_lines()[-1].get_xydata(), [[0.4, 0.3], [0.6, -0.1]])


def test_the_path_has_a_gap_at_each_jump(as_orbit, found):
    path = orbit(as_orbit(found)).axes[0].get_lines()[0].get_xydata()
    gap = [np.nan, np.nan]
    states = found.path_states.tolist()
    np.testing.assert_array_equal(path, [*states[:2], gap, *states[2:6], gap, *states[6:]])


def test_multipliers_are_told_in_numbers(as_orbit, found):
    title = orbit(as_orbit(found)).axes[1].get_title(loc="left")
    assert title == "μ₁, μ₂ = −0.261 ± 0.6509i\n|μ₁| = |μ₂| = 0.7012"
    lost = replace(found, multipliers=np.array([-3.0, 0.0], dtype=complex))
    assert (
        orbit(as_orbit(lost)).axes[1].get_title(loc="left") == "μ₁ = −3\nμ₂ = 0 (rank lost)\n1 outside of the picture"
    )


def test_residuals_fall_on_a_logarithmic_axis(as_orbit, found):
    axes = orbit(as_orbit(found)).axes[2]
    assert axes.get_yscale() == "log"
    values = axes.get_lines()[0].get_ydata()
    np.testing.assert_array_equal(values[:3], [1e-1, 1e-3, 1e-7])
    # zero has no place on it, and is reported
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
    assert len(set(colours.values())) == len(colours) == 4


def test_one_state_is_drawn_over_time(as_orbit, found):
    axes = orbit(as_orbit(found).isel(state=[0], multiplier=[0])).axes[0]
    assert axes.get_xlabel() == "time since the start of the period"
    np.testing.assert_array_equal(axes.get_lines()[-1].get_xydata(), [[0.0, 0.4], [1.0, 0.6]])


def test_a_search_shows_all_orbits_by_period_and_stability(as_orbit, found):
    other = replace(found, period=1, section=np.array([[0.2, 0.2]]), multipliers=np.array([2.0, 0.5], dtype=complex))
    figure = orbit(as_orbit(found, found, other, search=True))
    names = [text.get_text() for text in figure.legends[0].get_texts()]
    assert names == ["period 1: 1 unstable", "period 2: 2 stable"]
    assert figure.axes[1].get_title(loc="left") == "1 of 6 multipliers\nlie outside of the picture"


def test_paths_of_a_search_have_their_gaps_however_much_fills_them_up(as_orbit, found):
    longer = replace(found, path_times=np.append(found.path_times, 3.0), path_states=np.ones((9, 2)))
    lines = [line.get_xydata() for line in orbit(as_orbit(found, longer, search=True)).axes[0].get_lines()]
    alone = orbit(as_orbit(found)).axes[0].get_lines()[0].get_xydata()
    assert any(np.array_equal(line, alone, equal_nan=True) for line in lines)


def test_one_orbit_of_a_search_is_drawn_without_what_fills_it_up(as_orbit, found):
    longer = replace(found, period=3, section=np.zeros((3, 2)), newton=np.ones(9))
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


# Branches are drawn where the orbits are, solid where these are stable, and with what happens on them.


def _legend(figure):
    return [text.get_text() for text in figure.legends[0].get_texts()]


def _lines(figure, dashed):
    """Points of the lines that are dashed or not, without marks."""
    lines = [line for line in figure.axes[0].get_lines() if line.get_marker() == "None" and len(line.get_xdata())]
    return [line.get_xydata() for line in lines if (line.get_linestyle() == "--") == dashed]


def _drawn(figure, dashed):
    return np.concatenate(_lines(figure, dashed))


def test_what_is_there_is_named_and_nothing_else(continuation):
    figure = branches(continuation)
    assert figure.axes[0].get_xlabel() == "growth rate"
    assert figure.axes[0].get_ylabel() == "population"
    names = ["period 1", "period 2", "stable", "unstable", "period doubling", "grazing", "end: grazing"]
    assert _legend(figure) == names


@pytest.mark.parametrize(("stable", "word"), [(1, "unstable"), (0, "stable")])
def test_what_no_curve_is_stands_in_no_legend(continuation, stable, word):
    """A special point at an end, of which round-off decides, makes no curve."""
    values = np.where(continuation["special_point"] != 0, 1 - stable, stable)
    figure = branches(continuation.assign(stable=continuation["stable"].copy(data=values)))
    assert word not in _legend(figure)
    assert not _lines(figure, dashed=bool(stable))


def test_solid_is_stable(continuation):
    """Period 1 up to r = 3, both points of period 2 from there to 1 + sqrt 6."""
    figure = branches(continuation)
    solid, dashed = _drawn(figure, dashed=False), _drawn(figure, dashed=True)
    r, x = solid.T
    assert r.max() == pytest.approx(1 + np.sqrt(6))
    np.testing.assert_allclose(x[r < 3], 1 - 1 / r[r < 3])
    r, x = dashed.T
    assert r.min() == 3.0
    assert r.max() == pytest.approx(3.6)
    before = r < 1 + np.sqrt(6) - 1e-9
    np.testing.assert_allclose(x[before], 1 - 1 / r[before])


def test_both_points_of_an_orbit_are_drawn(continuation):
    r, x = _drawn(branches(continuation), dashed=False).T
    # r^2 x^2 - r (r + 1) x + r + 1 = 0
    np.testing.assert_allclose(np.sort(x[np.isclose(r, 3.2)]), np.sort(np.roots([3.2**2, -3.2 * 4.2, 4.2])))


def test_every_point_of_an_orbit_is_marked(continuation):
    marks = [line for line in branches(continuation).axes[0].get_lines() if line.get_marker() == "^"]
    points = np.concatenate([line.get_xydata() for line in marks])
    assert np.isfinite(points).all(axis=1).sum() == 1 + 2


def test_branches_are_not_joined(continuation):
    figure = branches(continuation)
    for line in _lines(figure, dashed=False) + _lines(figure, dashed=True):
        assert (np.diff(line[:, 0]) > 0).all()


def test_a_jump_of_the_section_is_no_line(branch_result, continuation):
    """An event that comes to the section's phase: the state there is the one before it, and then the one after it."""
    section = branch_result.section.copy()
    section[40:81] += 0.5
    jumped = continuation.assign(section=(("point", "iterate", "state"), section))
    whole, parts = (_lines(branches(ds), dashed=True) for ds in (continuation, jumped))
    assert len(parts) == len(whole) + 1
    assert max(np.abs(np.diff(line[:, 1])).max() for line in parts) < 0.1


@pytest.mark.parametrize("end", BranchEnd)
def test_ends_are_named_unless_they_are_that_of_the_range(continuation, end):
    codes = continuation["branch_end"].copy(data=np.array([BranchEnd.LIMIT, end], dtype=np.int8))
    ends = [text for text in _legend(branches(continuation.assign(branch_end=codes))) if text.startswith("end")]
    assert len(ends) == (end not in (BranchEnd.LIMIT, BranchEnd.CLOSED))


def test_kinds_of_special_points_have_shapes_of_their_own(continuation):
    def marker(code):
        codes = continuation["special_kind"].copy(data=np.full(3, code, dtype=np.int8))
        figure = branches(continuation.assign(special_kind=codes))
        return next(line.get_marker() for line in figure.axes[0].get_lines() if line.get_markerfacecolor() == "white")

    markers = {kind: marker(kind) for kind in Special if kind != Special.REGULAR}
    assert [(one, other) for one, other in combinations(markers, 2) if markers[one] == markers[other]] == []


@pytest.mark.parametrize("states", [1, 2, 5])
def test_any_number_of_states(continuation, states):
    """States that do not vary are passed over."""
    section = continuation["section"].values
    wide = np.concatenate([np.zeros((*section.shape[:2], states - 1)), section[..., :1]], axis=2)
    one = continuation.drop_dims("state").assign(section=(("point", "iterate", "state"), wide))
    one = one.assign_coords(state=[f"part{i}" for i in range(states)])
    assert branches(one).axes[0].get_ylabel() == f"part{states - 1}"


def test_a_search_that_found_no_orbit_says_so(continuation):
    none = continuation.isel(point=slice(0), branch_number=slice(0), special=slice(0))
    none = none.assign(outcome=continuation["outcome"].copy(data=np.int8(Outcome.NO_ORBIT)))
    title = branches(none.assign_attrs(message="none near the start")).get_suptitle()
    assert title == "no orbit; none near the start"


def _diagram(continuation, **attrs):
    r = np.linspace(2.8, 3.6, 11)
    section = np.broadcast_to((1 - 1 / r)[:, None, None, None], (11, 1, 4, 2))
    ds = xr.Dataset(
        {
            "section": (("r", "seed", "iterate", "state"), section),
            "period": (("r", "seed"), np.where(r < 3.2, 1, 0)[:, None]),
        },
        {"r": r, "state": ["x", "v"]},
    )
    return ds.assign_attrs(continuation.attrs, kind="bifurcation-diagram", **attrs)


def test_the_diagram_lies_behind(continuation):
    figure = branches(continuation, over=_diagram(continuation))
    assert _legend(figure)[0] == "bifurcation diagram"
    clouds, cycles, _, *lines = figure.axes[0].get_lines()
    assert (len(clouds.get_xdata()), len(cycles.get_xdata())) == (24, 20)
    assert clouds.get_zorder() == cycles.get_zorder() < min(line.get_zorder() for line in lines)


def test_plot_draws_over_a_diagram_that_fits_in_the_same_style(continuation):
    figure = cd.plot(continuation, over=_diagram(continuation)).figure
    assert _legend(figure)[0] == "bifurcation diagram"
    assert not figure.axes[0].spines["top"].get_visible()
    # so does the function itself
    assert not branches(continuation, over=_diagram(continuation)).axes[0].spines["top"].get_visible()


@pytest.mark.parametrize(
    ("kind", "attrs", "message"),
    [
        ("branches", {"system": "other"}, "over is of another system"),
        (
            "branches",
            {"kind": "parameter-chart"},
            "over is a parameter-chart, but .*lies over a bifurcation",
        ),
        ("multipliers", {}, "'multipliers' has no background; leave it out"),
    ],
)
def test_what_nothing_lies_over_is_refused(continuation, kind, attrs, message):
    with pytest.raises(cd.SettingsError, match=message):
        cd.plot(continuation, kind, over=_diagram(continuation).assign_attrs(attrs))


def test_a_diagram_over_a_wider_range_does_not_widen_the_picture(continuation):
    narrow = continuation.assign_attrs(settings='{"sweep": {"r": [3.45, 3.2]}}')
    axes = branches(narrow, over=_diagram(continuation)).axes[0]
    np.testing.assert_allclose(axes.get_xlim(), [3.195, 3.455])
    np.testing.assert_allclose(np.unique(axes.get_lines()[0].get_xdata()), [3.2, 3.28, 3.36, 3.44])


@pytest.mark.parametrize(
    "attrs",
    [
        {"system": "other"},
        {"parameters": '{"r": 3.0, "q": 0.75}'},
        {"settings": '{"sweep": {"q": []}}'},
        {"settings": '{"sweep": {"r": []}, "at": "hit"}'},
    ],
)
def test_what_is_of_another_system_or_section_is_not_drawn_over(continuation, attrs):
    assert fits(continuation, _diagram(continuation, parameters='{"r": 2.0, "q": 0.5}'))
    assert not fits(continuation, _diagram(continuation, **attrs))


def test_several_continuations_share_a_picture(as_continuation, branch_result, continuation):
    infos = tuple(replace(info, period=3 * info.period) for info in branch_result.branches)
    other = as_continuation(replace(branch_result, branches=infos))
    assert _legend(branches(continuation, other))[:4] == ["period 1", "period 2", "period 3", "period 6"]


def test_many_periods_share_the_last_colour(as_continuation, branch_result):
    def with_period(factor):
        infos = tuple(replace(info, period=factor * info.period) for info in branch_result.branches)
        return as_continuation(replace(branch_result, branches=infos))

    names = _legend(branches(*[with_period(factor) for factor in (1, 4, 16, 64)]))
    assert names[4:7] == ["period 16", "periods 32 to 128", "stable"]


# A cascade's distances fall by Feigenbaum's constant, and its ratios are shown.


def test_distances_lie_on_the_line(continuation):
    upper = cascade(continuation).axes[0]
    assert upper.get_yscale() == "log"
    dots, line = upper.get_lines()
    np.testing.assert_allclose(dots.get_ydata()[1:], line.get_ydata()[1:], rtol=0.03)
    assert line.get_ydata()[0] / line.get_ydata()[1] == pytest.approx(4.669201609, abs=1e-9)


def test_the_title_tells_the_accumulation_with_its_error(continuation):
    assert cascade(continuation).axes[0].get_title(loc="left") == "growth rate: accumulation at 3.569946(1)"


def test_ratios_are_told_from_the_third_doubling_on(continuation):
    lower = cascade(continuation).axes[1]
    assert [tick.get_text() for tick in lower.get_xticklabels()] == ["1 → 2", "2 → 4", "4 → 8", "8 → 16", "16 → 32"]
    # (sqrt 6 - 2)/(3.5440903596 - 1 - sqrt 6), known as 4.7514
    assert [text.get_text() for text in lower.texts] == ["4.6692", "4.7514", "4.6563", "4.6682"]
    assert lower.get_lines()[0].get_ydata()[0] == FEIGENBAUM


def test_the_line_leaves_out_what_the_error_covers(continuation):
    """The last distance is 0.0012, and an error above it leaves the one before."""
    dots, line = cascade(continuation.assign(accumulation_error=0.002)).axes[0].get_lines()
    assert line.get_ydata()[3] == dots.get_ydata()[3]


# Curves over two parameters keep their places whatever lies behind them.


@pytest.fixture
def chart(system):
    """Period 1 everywhere over q and r, in this order, for two seeds."""
    grid = {"q": np.linspace(-0.4, 0.4, 5), "r": np.linspace(0, 1, 6)}
    ds = xr.Dataset(
        {
            "period": (("q", "r", "seed"), np.ones((5, 6, 2), dtype=int)),
            "outcome": (("q", "r", "seed"), np.full((5, 6, 2), Outcome.PERIODIC)),
            "attractor_count": (("q", "r"), np.ones((5, 6), dtype=int)),
        },
        {**grid, "state": ["x", "v"]},
    )
    return label(ds, "parameter-chart", system=system, settings={"sweep": grid})


def _points(axes):
    (line,) = [line for line in axes.get_lines() if line.get_marker() == "None"]
    return line.get_xydata()


def _marks(ds):
    lines = curves(ds).axes[0].get_lines()
    return [tuple(line.get_xydata()[0]) for line in lines if line.get_markerfacecolor() == "white"]


def test_curves_are_named_by_kind_and_period(curve):
    figure = curves(curve("fold"), curve("period_doubling"), curve("period_doubling", 2, BranchEnd.GRAZING))
    names = ["fold, period 1", "period doubling, period 1", "period doubling, period 2", "end: grazing"]
    assert _legend(figure) == names
    lines = [line for line in figure.axes[0].get_lines() if len(line.get_xdata()) > 1]
    assert len({line.get_color() for line in lines}) == 3
    assert [line.get_linestyle() for line in lines] == ["-", "--", "--"]


def test_alone_the_first_parameter_runs_across(curve):
    axes = curves(curve("period_doubling")).axes[0]
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("growth rate", "q")
    a, b = _points(axes).T
    np.testing.assert_allclose(a, 0.75 * (1 - b) ** 2)


def test_over_a_chart_they_follow_its_axes_in_every_panel(curve, chart):
    figure = curves(curve("period_doubling"), over=chart)
    assert _legend(figure) == ["period 1", "period doubling, period 1"]
    for axes in figure.axes[:2]:
        b, a = _points(axes).T
        np.testing.assert_allclose(a, 0.75 * (1 - b) ** 2)
        # the curve goes on to 0.5, the chart does not
        np.testing.assert_allclose(axes.get_xlim(), [-0.5, 0.5])
        np.testing.assert_allclose(axes.get_ylim(), [-0.1, 1.1])


def test_a_failed_search_is_said(curve):
    none = curve("fold").isel(point=slice(0), branch_number=slice(0))
    none = none.assign(outcome=none["outcome"].copy(data=np.int8(Outcome.EQUILIBRIUM)))
    figure = curves(none.assign_attrs(message="no fold on the way"))
    assert "equilibrium; no fold on the way" in figure.get_suptitle()


def test_the_point_from_which_a_curve_was_followed_is_nothing_special(curve):
    """It has the system's own value of the second parameter, q = 0.5, which is the curve's last point."""
    ds = curve("period_doubling", specials={20: Special.PERIOD_DOUBLING, 5: Special.PERIOD_DOUBLING})
    assert _marks(ds) == [(0.75 * 1.25**2, -0.25)]
    assert _marks(curve("period_doubling", specials={20: Special.GRAZING})) == [(0.75 * 0.5**2, 0.5)]


def test_what_lies_beyond_the_chart_is_not_named(curve, chart):
    """Folds have a < 0; of the period doublings only those with a below 1.1 are within the chart."""
    ds = curve("period_doubling", specials={0: Special.GRAZING, 10: Special.FOLD})
    figure = curves(curve("fold"), ds, over=chart.sel(r=slice(0.2, None)))
    assert _legend(figure) == ["period 1", "period doubling, period 1", "fold"]


# Multipliers stand where they are in the plane, their moduli over the parameter, and crossings on the circle.


def _marks_of_multiplier(axes):
    return {line.get_label(): line.get_xydata() for line in axes.get_lines() if line.get_markerfacecolor() == "white"}


def test_values_are_coloured_by_the_parameter(continuation):
    plane = multipliers(continuation).axes[0]
    dots = plane.collections[0]
    # 2 - r and 4 + 2 r - r^2; the exact zeros are not drawn
    r = continuation["r"].values
    expected = np.where(continuation["period"].values == 1, 2 - r, 4 + 2 * r - r**2)
    np.testing.assert_allclose(dots.get_offsets(), np.stack([expected, 0 * r], axis=1), atol=1e-12)
    np.testing.assert_allclose(dots.get_array(), r)


def test_what_is_far_outside_is_counted(continuation):
    far = continuation.copy(deep=True)
    far["multiplier_real"][5:9, 0] = 1e4
    axes = multipliers(far).axes[0]
    assert axes.get_title(loc="left") == "4 of 266 lie outside; their moduli are below"
    assert axes.get_xlim()[1] < 2
    assert multipliers(continuation).axes[0].get_title(loc="left") == ""


def test_the_circle_is_round(continuation):
    axes = multipliers(continuation).axes[0]
    assert axes.get_aspect() == 1
    assert [patch.get_radius() for patch in axes.patches] == [1]


@pytest.mark.parametrize(
    ("kind", "values", "crossing"),
    [
        (Special.FOLD, [1.0 + 1e-9, -1.0], [1.0]),
        (Special.PERIOD_DOUBLING, [1.5, -1.0 + 1e-9], [-1.0]),
        (Special.NEIMARK_SACKER, [0.6 + 0.8j, 0.6 - 0.8j], [0.6 + 0.8j, 0.6 - 0.8j]),
    ],
)
def test_crossings_are_marked_where_they_happen(continuation, kind, values, crossing):
    changed = continuation.copy(deep=True)
    changed["multiplier_real"][20], changed["multiplier_imag"][20] = np.real(values), np.imag(values)
    changed["special_kind"][:] = [kind, Special.GRAZING, Special.GRAZING]
    (points,) = _marks_of_multiplier(multipliers(changed).axes[0]).values()
    np.testing.assert_allclose(points[:, 0] + 1j * points[:, 1], crossing, atol=1e-8)


def test_special_points_without_a_crossing_stand_at_the_foot(continuation):
    below = multipliers(continuation).axes[2]
    marks = _marks_of_multiplier(below)
    np.testing.assert_allclose(marks["period doubling"], [[3, 1], [1 + np.sqrt(6), 1]])
    np.testing.assert_allclose(marks["grazing"], [[3.5, 0.05]])


def test_lost_multipliers_are_named(continuation):
    side = multipliers(continuation).axes[1]
    names = [text.get_text() for text in side.get_legend().get_texts()]
    assert names == ["period 1", "period 2", "μ₂ = 0", "period doubling", "grazing"]
    some = continuation.copy(deep=True)
    some["multiplier_real"][:33, 1] = 0.125
    names = [text.get_text() for text in multipliers(some).axes[1].get_legend().get_texts()]
    assert "μ₂ = 0 at 100 of 133 points" in names


def test_points_without_multipliers_do_not_count(continuation):
    some = continuation.copy(deep=True)
    some["multiplier_real"][-1] = np.nan
    assert "μ₂ = 0" in [text.get_text() for text in multipliers(some).axes[1].get_legend().get_texts()]


def test_moduli_have_a_logarithmic_axis_around_one(continuation):
    below = multipliers(continuation).axes[2]
    assert below.get_yscale() == "log"
    low, high = below.get_ylim()
    assert 0 < low < 1 < high


# From an archive, continuations of the same system over the same parameters go into one picture, over its diagram.


@pytest.fixture
def archive(tmp_path, continuation, curve, as_orbit, found):
    """Two continuations over r, with a diagram; one of another system, one over less; two curves; an orbit."""
    r = np.linspace(2.8, 3.6, 5)
    diagram = xr.Dataset(
        {
            "section": (("r", "seed", "iterate", "state"), np.full((5, 1, 2, 2), 0.25)),
            "period": (("r", "seed"), np.ones((5, 1), dtype=np.int16)),
            "outcome": (("r", "seed"), np.ones((5, 1), dtype=np.int8), continuation["outcome"].attrs),
        },
        {"r": r, "state": continuation["state"]},
    )
    groups = {
        "one": continuation,
        "two": continuation,
        "stranger": continuation.assign_attrs(system="another"),
        "narrow": continuation.assign(accumulation=np.nan).assign_attrs(settings='{"sweep": {"r": [3.4, 3.5]}}'),
        "diagram": diagram.assign_attrs(continuation.attrs, kind="bifurcation-diagram"),
        "folds": curve("fold"),
        "doublings": curve("period_doubling"),
        "found": as_orbit(found),
    }
    path = tmp_path / "run.nc"
    cd.save(xr.DataTree.from_dict(groups), path)
    return path


def test_what_belongs_together_is_one_picture(archive):
    assert [file.name for file in plot_archive(archive)] == [
        "run-one-two-branches.png",
        "run-one-multipliers.png",
        "run-one-cascade.png",
        "run-two-multipliers.png",
        "run-two-cascade.png",
        "run-stranger-branches.png",
        "run-stranger-multipliers.png",
        "run-stranger-cascade.png",
        "run-narrow-branches.png",
        "run-narrow-multipliers.png",
        "run-diagram-bifurcation-diagram.png",
        "run-folds-doublings-curves.png",
        "run-found-periodic-orbit.png",
    ]


def test_the_diagram_of_another_group_lies_behind(archive, tmp_path):
    for group, behind in (("two", True), ("stranger", False)):
        plot_archive(archive, tmp_path / "a.svg", group=group)
        text = (tmp_path / f"a-{group}-branches.svg").read_text(encoding="utf-8")
        assert ("bifurcation diagram" in text) == behind


def test_a_cascade_without_an_accumulation_point_has_no_picture(tmp_path, continuation):
    short = continuation.assign(accumulation=np.nan)
    cd.save(xr.DataTree.from_dict({"run": short}), tmp_path / "run.nc")
    assert [file.name for file in plot_archive(tmp_path / "run.nc")] == ["run-branches.png", "run-multipliers.png"]


def test_what_one_per_cent_does_is_drawn_as_bars_of_their_lengths():
    """The period of the rimless wheel, against its closed form; its neutral exponent is not drawn."""
    ds = cd.periodic_orbit(cd.build("rimless-wheel"), transient=50, derivatives=True)
    values = {"alpha": 0.3, "gamma": 0.15}
    form, by = closed.gait(**values), closed.by_parameters(closed.gait, values)
    left, right = cd.plot(ds, kind="elasticities").figure.axes
    names = [text.get_text() for text in left.get_yticklabels()]
    lengths = dict(zip(names, (bar.get_width() for bar in left.patches), strict=True))
    for name, letter in (("alpha", "α"), ("gamma", "γ")):
        wanted = float(by["period"][name]) * values[name] / float(form["period"])
        assert lengths[letter] == pytest.approx(wanted, rel=1e-9)
    # exponent log(cos^2 2a)/T
    moved = float(by["multiplier"]["alpha"] / form["multiplier"]) - float(ds["lyapunov_exponent"][1]) * float(
        by["period"]["alpha"]
    )
    drawn = right.patches[names.index("α")].get_width()
    assert drawn == pytest.approx(moved / float(form["period"]) * 0.3 / 100, rel=1e-8)


@pytest.mark.parametrize("part", [slice(1), slice(1, None)])
def test_special_points_are_not_drawn_at_other_points(continuation, part):
    assert continuation.sizes["special"]
    with pytest.raises(cd.SettingsError, match="draw the whole result and narrow the axes"):
        cd.plot(continuation.isel(point=part))


def test_a_part_of_a_branch_does_not_end_where_it_was_cut(continuation):
    plain = continuation.isel(special=[]).assign(special_point=0 * continuation["special_point"])
    assert any(text.startswith("end") for text in _legend(branches(plain)))
    assert not any(text.startswith("end") for text in _legend(branches(plain.isel(point=slice(-1)))))
    # archives of 0.2.0 do not know the length of a branch
    assert _legend(branches(plain.drop_vars("branch_length"))) == _legend(branches(plain))


def test_multipliers_that_are_all_zero_stand_over_their_parameter():
    held = cd.Map("x", {"a": 2.0}, ["a"], initial={"x": 2.0})
    branch = cd.continue_orbit(held, {"a": (1.5, 2.5)}, start="guess")
    _plane, _, below, bar = multipliers(branch).axes
    assert below.get_xlim() == pytest.approx((1.48, 2.52))
    assert bar.get_ylim() == (1.5, 2.5)
