"""What pictures say and how: labels, curves, colours, numbers, names of files."""

import re
from itertools import combinations, pairwise

import matplotlib as mpl
import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_hex, to_rgb
from matplotlib.figure import Figure

import chaosdrill as cd
from chaosdrill.dataset import Outcome
from chaosdrill.errors import ArchiveError, SettingsError
from chaosdrill.plots import PICTURES, categories, palette, plot_archive
from chaosdrill.plots.accuracy import convergence
from chaosdrill.plots.contents import in_order
from chaosdrill.plots.curve import MOST_RUNS, curve_of, last_parts, runs_of, stops, strobe
from chaosdrill.plots.labels import drawable, shorten, subscript, uncertain
from chaosdrill.plots.pictures import stems_of
from chaosdrill.plots.sections import poincare
from chaosdrill.plots.trajectories import phase_portrait, time_history
from chaosdrill.reports.tables import event_counts

# What the pictures say: labels, legends and titles come from the dataset, and nothing is drawn that is not there.


def _labels(axes):
    return [text.get_text() for text in axes.get_legend().get_texts()]


def test_time_history_names_quantities_units_events_and_modes(ball):
    figure = time_history(ball)
    assert [panel.get_ylabel() for panel in figure.axes] == ["penetration (mm)", "x", "v"]
    assert figure.axes[-1].get_xlabel() == "model time"
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["bounce off", "dry (mode)", "wet (mode)"]


def test_a_long_record_says_which_part_is_shown(ball):
    many = ball.isel(event=np.repeat(np.arange(10), 5))
    title = time_history(many).axes[0].get_title(loc="left")
    assert title == "last 7 of 10 forcing periods"
    assert time_history(many.drop_vars("forcing_period")).axes[0].get_title(loc="left") == "last 14 of 20 units of time"


def test_phase_portrait_shows_the_stop_and_the_section(ball):
    axes = phase_portrait(ball).axes[0]
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("x", "v")
    assert _labels(axes) == ["flow", "jump", "once per forcing period", "bounce off at x = 0"]


def test_flow_is_not_drawn_across_a_jump(ball):
    x, v = phase_portrait(ball).axes[0].lines[0].get_data()
    assert np.isnan(x).sum() == 10
    assert np.nanmax(np.abs(np.diff(v))) < 0.11


def test_a_sample_at_the_time_of_an_event_is_one_of_its_sides(ball):
    """A sample at an event shows the state before it; in the curve it would come after the state after the event."""
    states = ball["states"].values.copy()
    states[np.isin(ball["time"].values, ball["event_time"].values)] = [0.0, -1.0]
    _, v = phase_portrait(ball.assign(states=(("time", "state"), states))).axes[0].lines[0].get_data()
    assert np.nanmax(np.abs(np.diff(v))) < 0.11


def test_section_names_its_period_and_multipliers(section):
    axes = poincare(section).axes[0]
    assert axes.get_title(loc="left") == "period 2, once per forcing period; multipliers 0.5 ± 0.25i"
    assert len(axes.collections[0].get_offsets()) == 2


def test_section_without_a_period_shows_every_point(section):
    axes = poincare(section.assign(period=0)).axes[0]
    assert axes.get_title(loc="left") == "40 points, once per forcing period"
    assert len(axes.collections[0].get_offsets()) == 40


def test_convergence_names_the_lost_exponent_and_draws_the_others(spectrum):
    figure = convergence(spectrum)
    assert [panel.get_title(loc="left") for panel in figure.axes] == ["λ₁ = 0.015(1)", "λ₂ = −0.0879(2)"]
    assert figure.legends[0].get_title().get_text().startswith("λ₃ = −∞")
    low, high = figure.axes[0].get_ylim()
    assert low < 0.015 - 0.001
    assert high > 0.015 + 0.001


def test_long_names_of_states_stand_on_the_axes(ball):
    named = ball.assign_coords(state_long_name=("state", ["height above the floor", "speed"]))
    axes = phase_portrait(named).axes[0]
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("height above the floor", "speed")


@pytest.mark.parametrize("known", [0, 1])
def test_one_state_is_drawn_against_the_iterate(section, known):
    axes = poincare(section.isel(state=[0]).assign(period=2 * known)).axes[0]
    assert axes.get_xlabel() == "iterate"


# One call draws what suits an archive, under predictable names, and leaves matplotlib as it was.


@pytest.fixture
def archive(tmp_path, ball, spectrum):
    path = tmp_path / "run.nc"
    cd.save(xr.DataTree.from_dict({"orbit": ball, "spectrum": spectrum}), path)
    return path


def test_every_suitable_picture_is_drawn_beside_the_archive(archive):
    files = plot_archive(archive)
    assert [file.name for file in files] == [
        "run-orbit-time-history.png",
        "run-orbit-phase-portrait.png",
        "run-spectrum-convergence.png",
    ]
    assert all(file.read_bytes().startswith(b"\x89PNG") for file in files)


def test_several_pictures_of_a_group_are_named_apart(tmp_path, chart, basin):
    path = tmp_path / "run.nc"
    cd.save(xr.DataTree.from_dict({"load": chart, "basins": basin}), path)
    assert [file.name for file in plot_archive(path)] == [
        "run-load-isoperiodic-chart.png",
        "run-load-lyapunov-chart.png",
        "run-load-progression-chart.png",
        "run-load-attractor-count-chart.png",
        "run-load-outcome-chart.png",
        "run-basins.png",
    ]


def test_no_picture_replaces_another_where_archive_and_group_are_named_as_pictures():
    drawn = {picture.name: picture for picture in PICTURES if picture.kind == "continuation"}
    planned = [(["branches"], drawn["branches"]), (["branches"], drawn["cascade"])]
    assert stems_of("cascade", planned) == ["cascade-branches-branches", "cascade-branches-cascade"]
    assert stems_of("orbits", planned) == ["orbits-branches", "orbits-branches-cascade"]
    both = [(["a/b"], drawn["branches"]), (["a-b"], drawn["branches"]), (["\u202ea"], drawn["branches"])]
    assert stems_of("x", both) == ["x-a-b-branches", "x-a-b-branches-2", r"x-\u202ea-branches"]
    # on some systems these are the same file
    cases = [(["A"], drawn["branches"]), (["a"], drawn["branches"])]
    assert stems_of("x", cases) == ["x-A-branches", "x-a-branches-2"]


def test_one_picture_goes_exactly_where_it_was_asked_to(archive, tmp_path):
    assert plot_archive(archive, tmp_path / "a.svg", group="spectrum") == [tmp_path / "a.svg"]
    assert "λ₂ = −0.0879(2)" in (tmp_path / "a.svg").read_text(encoding="utf-8")


def test_unknown_group_is_refused_with_the_names_of_the_others(archive):
    with pytest.raises(ArchiveError, match=r"no group 'orbid'; groups are orbit, spectrum"):
        plot_archive(archive, group="orbid")


def _texts(file):
    """What a picture says; svg files hold it as text."""
    return re.findall(r">([^<>\n]+)</text>", file.read_text(encoding="utf-8"))


def test_a_state_is_shown_where_a_picture_shows_one_or_so_many(archive, tmp_path):
    history, portrait, convergence = plot_archive(archive, tmp_path / "a.svg", state="v")
    assert {"v"} == {"x", "v", "penetration (mm)"} & set(_texts(history))
    assert {"x", "v"} <= set(_texts(portrait)), "a plane needs two"
    assert convergence.exists()
    history, portrait, _ = plot_archive(archive, tmp_path / "b.svg", state=("v", "x"))
    for name in (history, portrait):
        assert {"x", "v"} == {"x", "v", "penetration (mm)"} & set(_texts(name))


def test_a_state_that_nothing_shows_is_refused(archive, tmp_path):
    with pytest.raises(SettingsError, match=r"^state names 'z'; states are x, v$"):
        plot_archive(archive, tmp_path / "a.png", state="z")
    with pytest.raises(SettingsError, match=r"write state=\('x', 'v'\) for several"):
        plot_archive(archive, tmp_path / "a.png", state="x, v")
    with pytest.raises(SettingsError, match=r"no picture shows single states"):
        plot_archive(archive, tmp_path / "a.png", group="spectrum", state="x")
    assert not list(tmp_path.glob("a*.png"))


def test_an_archive_without_a_suitable_picture_says_what_it_holds(tmp_path, ball):
    path = tmp_path / "other.nc"
    ball.attrs["kind"] = "unheard-of"
    cd.save(xr.DataTree.from_dict({"orbit": ball}), path)
    with pytest.raises(ArchiveError, match=r"no picture for orbit \(unheard-of\)"):
        plot_archive(path)


def test_unknown_format_is_refused(archive, tmp_path):
    with pytest.raises(SettingsError, match=r"\.gif.*png, pdf, svg"):
        plot_archive(archive, tmp_path / "a.gif")
    assert not (tmp_path / "a.gif").exists()


def test_nothing_is_left_changed_in_matplotlib(archive):
    before = dict(mpl.rcParams)
    plot_archive(archive, group="spectrum")
    assert dict(mpl.rcParams) == before


# Joined runs are drawn each by itself, with its own events.


@pytest.mark.parametrize("kind", ["time-history", "phase-portrait"])
def test_one_that_is_drawn_over_another_has_a_colour_of_its_own(ball, kind):
    axes = Figure().subplots()
    flows = []
    for _ in range(3):
        before = len(axes.lines)
        cd.plot(ball, kind, ax=axes)
        flows.append(to_hex(axes.lines[before].get_color()))
    marks = {to_hex(line.get_color()) for line in axes.lines if line.get_linestyle() == "None"}
    assert len({*flows}) == 3
    assert not marks & {*flows}


def test_taken_apart_they_are_what_was_joined(runs, joined):
    for (name, run), (expected, whole) in zip(runs_of(joined), runs.items(), strict=True):
        assert name == expected
        for variable in ("states", "mode", "event_time", "event_state_after", "outcome"):
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
    assert figure.axes[0].get_title(loc="left").startswith(f"first {MOST_RUNS} of {MOST_RUNS + 3} runs")
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


def test_runs_that_xarray_has_put_side_by_side_are_drawn(runs):
    """With as many events each, or filled up; of one kind only."""
    low = runs["low"]
    high = low.copy()
    for name in ("states", "event_state_before", "event_state_after"):
        high[name] = 2 * high[name]
    axes = cd.plot(xr.concat([low, high], xr.Variable("run", ["low", "high"])), "phase-portrait")
    extents = {
        line.get_label(): np.nanmax(line.get_xdata()) for line in axes.lines if line.get_label() in ("low", "high")
    }
    assert (extents["low"], extents["high"]) == (0.5, 1.0)
    filled = xr.concat([low, high.isel(event=slice(6)).pad(event=(0, 4))], "run")
    marks = [line for line in time_history(filled).axes[2].lines if line.get_linestyle() == "None"]
    assert [len(line.get_xdata()) for line in marks] == [10, 6]


@pytest.mark.parametrize("which", ["spectrum", "section"])
def test_several_results_in_one_are_refused_with_the_way(request, which):
    one = request.getfixturevalue(which)
    with pytest.raises(SettingsError, match=r"ds has the dimension 'run', .* has not; choose one .*ds.isel\(run=0\)"):
        cd.plot(xr.concat([one, one], "run", data_vars="all"))


@pytest.mark.parametrize("text", ["altered", "[1]"])
def test_settings_beyond_reading_are_refused(section, text):
    with pytest.raises(SettingsError, match=rf"^the attribute settings is '{re.escape(text)}'; it must be a JSON"):
        cd.plot(section.assign_attrs(settings=text))


@pytest.mark.parametrize("which", ["ball", "section", "spectrum", "diagram", "chart", "basin"])
def test_dimensions_in_another_order_are_put_back(request, which):
    one = request.getfixturevalue(which)
    assert in_order(one.transpose()).identical(one)


def test_the_order_of_dimensions_changes_no_chart(chart):
    """Of a chart that a user had transposed, other values were drawn, without a word."""
    drawn = [cd.plot(ds, kind="lyapunov-chart").collections[0].get_array() for ds in (chart, chart.transpose())]
    assert np.array_equal(*drawn)


# Results of scenes in SI units are shown in SI units.


def test_a_run_in_si_is_shown_in_seconds_and_metres(ball):
    """A unit of time is 10 ms, and one of length 2 mm."""
    scales = {"time": 0.01, "event_time": 0.01, "forcing_period": 0.01, "penetration": 0.002}
    units = {"penetration": "m"}
    si = {
        f"{name}_si": (ball[name].dims, scale * ball[name].values, {"long_name": name, "units": units.get(name, "s")})
        for name, scale in scales.items()
    }
    coords = {"state_scale_si": ("state", [0.002, 0.2]), "state_units_si": ("state", ["m", "m s-1"])}
    run = ball.assign(si).assign_coords(coords)
    figure = time_history(run)
    assert [axes.get_ylabel() for axes in figure.axes] == ["penetration (m)", "x (m)", "v (m s⁻¹)"]
    assert figure.axes[-1].get_xlabel() == "time (s)"
    x, y = figure.axes[1].lines[0].get_data()
    assert (np.nanmax(x), np.nanmax(y)) == pytest.approx((0.2, 0.002 * 0.5))
    many = run.isel(event=np.repeat(np.arange(10), 5))
    assert time_history(many).axes[0].get_title(loc="left") == "last 7 of 10 forcing periods"
    axes = cd.plot(run, "phase-portrait")
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("x (m)", "v (m s⁻¹)")
    assert len(axes.collections[0].get_offsets()) == 11


def test_modes_of_the_same_words_are_told_apart(ball):
    signs = [f"{side}{a}{b}" for side in ("above", "below") for a in "+-" for b in "+-"]
    modes = {"flag_values": np.arange(8, dtype=np.int8), "flag_meanings": " ".join(signs)}
    many = ball.isel(event=slice(0)).assign(mode=("time", np.arange(401) // 51, modes))
    legend = time_history(many).legends[0]
    names = [text.get_text() for text in legend.get_texts()]
    assert len(set(names)) == 8
    looks = {(patch.get_facecolor(), patch.get_hatch()) for patch in legend.get_patches()}
    assert len(looks) == 8


def test_what_is_drawn_is_what_the_caption_names(ball, joined):
    assert time_history(ball).get_label() == "penetration and states over time, with events and modes"
    assert time_history(joined).get_label() == "penetration and states over time, one colour per run, with events"
    plain = ball.drop_vars("penetration").isel(event=slice(0))
    plain["mode"].attrs |= {"flag_values": np.array([0], dtype=np.int8), "flag_meanings": "dry"}
    plain["mode"] = 0 * plain["mode"]
    assert time_history(plain).get_label() == "states over time"


# The curve that pictures draw jumps exactly at the events, and knows modes, walls and strobe points.


def test_both_sides_of_every_event_stand_at_the_same_time_in_order(ball):
    curve = curve_of(ball)
    # of each of the ten samples at an event one side of it is the same
    assert curve.time.size == 401 - 10 + 2 * 10
    assert np.all(np.diff(curve.time) >= 0)
    at = np.flatnonzero(curve.time == 4.0)
    assert curve.state[at, 1].tolist() == [-1.0, 1.0]


def test_bands_cover_the_whole_time_and_alternate(ball):
    bands = curve_of(ball).bands()
    assert bands[0][0] == 0.0
    assert bands[-1][1] == 20.0
    assert all(a[1] == b[0] and a[2] != b[2] for a, b in pairwise(bands))
    # x < 1/4 near the ends of a flight: t (2 - t) = 1/2 at t = 1 - 1/sqrt 2, so that much of every half flight is wet
    wet = sum(end - start for start, end, mode in bands if mode == 1)
    assert abs(wet - 20 * (1 - 1 / np.sqrt(2))) < 20 * 0.05


def test_a_wall_is_found_where_the_state_jumps_and_nowhere_else(ball):
    assert stops(ball, 0) == [("bounce_off", 0.0)]
    assert stops(ball, 1) == []


def test_events_that_change_no_state_are_no_wall(ball):
    ball["event_state_after"] = ball["event_state_before"]
    assert stops(ball, 0) == []


def test_strobe_points_are_one_a_forcing_period(ball):
    assert strobe(ball).tolist() == [[0.0, 1.0]] * 11
    assert strobe(ball.drop_vars("forcing_period")).shape == (0, 2)


def test_a_long_record_is_cut_at_a_whole_forcing_period(ball):
    (end,) = last_parts([ball], 4)
    assert end["time"].values[0] == 14.0
    assert end.sizes["event"] == 4
    assert last_parts([ball], 10)[0] is ball


# Numbers in legends and titles: digits that the error leaves, a true minus sign, infinity by its symbol.


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [
        (0.0151012, 0.0000123, "0.01510(1)"),
        (-0.08792, 0.00021, "−0.0879(2)"),
        (14.5723, 0.3, "14.6(3)"),
        (1234.5, 20.0, "1234(20)"),
        (0.0914, 0.00097, "0.091(1)"),
        (-0.05148136, 0.0, "−0.0514814"),
        (-0.05148136, np.nan, "−0.0514814"),
        (-np.inf, np.nan, "−∞"),
        (-1.9e-15, 4e-15, "−2(4)e−15"),
        (1.234567e-5, 1e-8, "0.00001235(1)"),
        (-0.052163941, 1e-9, "−0.052163941(1)"),
    ],
)
def test_the_error_sets_the_digits(value, error, text):
    assert uncertain(value, error) == text


def test_plain_numbers_have_four_digits():
    assert shorten(-0.332781501) == "−0.3328"
    assert shorten(-np.inf) == "−∞"


@pytest.mark.parametrize("text", [r"$\thta$", r"$\frac{1}{2$", r"$a_{1$ and $b}$"])
def test_a_formula_that_cannot_be_read_is_shown_as_it_was_written(text):
    shown = drawable(text)
    figure = Figure()
    figure.text(0, 0, shown)
    figure.draw_without_rendering()
    assert shown.replace(r"\$", "$") == text
    assert drawable(r"$\theta_1$ at 5 \$") == r"$\theta_1$ at 5 \$"


def test_indices_are_lowered():
    assert subscript("λ", 12) == "λ₁₂"


# Categories in one picture are distinct for every kind of eyes, and in grey; scales are uniform.
#
# A difference of 2.3 in CIELAB is just noticed when two patches touch; regions and legends lie apart.


# Machado, Oliveira and Fernandes 2009, full severity, for linear sRGB; doi:10.1109/TVCG.2009.113
EYES = {
    "all cones": np.eye(3),
    "protanopia": np.array(
        [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]]
    ),
    "deuteranopia": np.array(
        [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]
    ),
    "tritanopia": np.array(
        [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]]
    ),
}

_TO_XYZ = np.array(
    [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]]
)

_WHITE = np.array([0.95047, 1.0, 1.08883])


def lab(colours, eyes="all cones"):
    """CIELAB (D65) of colours as they are seen, shape (k, 3)."""
    srgb = np.array([to_rgb(colour) for colour in colours])
    linear = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
    seen = np.clip(linear @ EYES[eyes].T, 0, 1)
    ratio = seen @ _TO_XYZ.T / _WHITE
    f = np.where(ratio > 216 / 24389, np.cbrt(ratio), (24389 / 27 * ratio + 16) / 116)
    return np.stack([116 * f[:, 1] - 16, 500 * (f[:, 0] - f[:, 1]), 200 * (f[:, 1] - f[:, 2])], axis=1)


def lightness(colours):
    """What a print in grey leaves of colours: CIE L*, from 0 to 100."""
    return lab(colours)[:, 0]


# most of those after "failed" are outcomes of looking for an orbit, which no chart shows
SHOWN = (*categories.MOTIONS, "no_return")
OUTCOMES = [categories.outcome_category(o.meaning) for o in Outcome if o <= Outcome.FAILED or o.meaning in SHOWN]

PERIODS = [categories.Category(f"period {n}", colour) for n, colour in enumerate(palette.PERIOD_COLOURS, 1)]

PERIODS.append(categories.Category("longer", palette.LONGER_COLOUR))

TOGETHER = {
    "outcomes": OUTCOMES,
    "periods": PERIODS + [one for one in OUTCOMES if one.name != "periodic"] + [categories.PERIOD_NOT_FOUND],
    "attractors": [categories.attractor_category(n, str(n)) for n in range(12)]
    + [one for one in OUTCOMES if one.name not in categories.ATTRACTED]
    + [categories.UNRECOGNISED, categories.FURTHER],
    "lines": [categories.Category(colour, colour) for colour in (*palette.LINE_COLOURS, palette.BACKGROUND)],
    "seeds": [categories.Category(colour, colour) for colour in palette.SEED_COLOURS],
}


@pytest.mark.parametrize("eyes", EYES)
@pytest.mark.parametrize("picture", TOGETHER)
def test_colours_with_the_same_hatching_are_told_apart(picture, eyes):
    for a, b in combinations(TOGETHER[picture], 2):
        if a.hatch == b.hatch:
            first, second = lab([a.colour, b.colour], eyes)
            assert np.linalg.norm(first - second) > 12, (a.name, b.name)


@pytest.mark.parametrize("picture", TOGETHER)
def test_they_are_told_apart_in_grey(picture):
    for a, b in combinations(TOGETHER[picture], 2):
        if a.hatch == b.hatch:
            first, second = lightness([a.colour, b.colour])
            assert abs(first - second) > 7, (a.name, b.name)


@pytest.mark.parametrize("category", [one for group in TOGETHER.values() for one in group], ids=lambda one: one.name)
def test_text_and_hatching_are_read_on_their_colour(category):
    first, second = lightness([category.ink, category.colour])
    assert abs(first - second) > 45


@pytest.mark.parametrize("colours", [palette.SEED_COLOURS, palette.LINE_COLOURS])
def test_dots_and_lines_are_seen_on_white(colours):
    assert (lightness(colours) < 75).all()


def test_the_diverging_scale_is_even_and_both_signs_alike():
    shades = palette.diverging()(np.linspace(0, 1, 129))[:, :3]
    light = lightness(shades)
    below, above = light[:64][::-1], light[65:]
    assert light[64] == light.max() > 95
    assert np.abs(below - above).max() < 2
    for arm in (below, above):
        assert (np.diff(arm) < 0).all()
        steps = -np.diff(arm[::8])
        assert steps.min() > 0.7 * steps.mean()
        assert steps.max() < 1.3 * steps.mean()


@pytest.mark.parametrize("eyes", EYES)
def test_signs_are_told_apart(eyes):
    shades = palette.diverging()(np.linspace(0, 1, 129))[:, :3]
    seen = lab(shades, eyes)
    apart = np.linalg.norm(seen[:64][::-1] - seen[65:], axis=1)
    assert (apart[8:] > 12).all()
    assert (apart[16:] > 25).all()


def test_eight_numbers_of_attractors_are_told_apart():
    light = lightness(palette.diverging()(np.linspace(0.5, 0, 8))[:, :3])
    assert (np.diff(light) < -7).all()


def test_the_sequential_scale_is_even():
    light = lightness(palette.sequential()(np.linspace(0, 1, 17))[:, :3])
    steps = -np.diff(light)
    assert steps.min() > 0.8 * steps.mean()
    assert steps.max() < 1.2 * steps.mean()
    # escape is black
    assert light[-1] > 15


def test_a_hatching_over_a_scale_means_one_thing():
    others = [one for one in OUTCOMES if one.name not in categories.ATTRACTED] + [
        categories.NO_RESULT,
        categories.MINUS_INFINITY,
    ]
    hatches = [one.hatch for one in [*others, categories.POSITIVE] if one.hatch]
    assert len(set(hatches)) == len(hatches)


@pytest.mark.parametrize("eyes", EYES)
def test_what_has_no_number_is_no_shade_of_the_scale(eyes):
    """Either the colour is far from all of the scale, or a hatching marks it."""
    for scale in (palette.sequential(), palette.diverging()):
        shades = lab(scale(np.linspace(0, 1, 65))[:, :3], eyes)
        for category in [*OUTCOMES, categories.NO_RESULT, categories.MINUS_INFINITY]:
            if category.name not in categories.MOTIONS and not category.hatch:
                assert np.linalg.norm(shades - lab([category.colour], eyes), axis=1).min() > 12, category.name


def test_of_many_states_and_exponents_the_first_dozen_are_drawn_and_it_is_said():
    ring = cd.build("lorenz-96")
    figures = [
        cd.plot(cd.trajectory(ring, duration=1, samples=4)).figure,
        cd.plot(cd.lyapunov_spectrum(ring, duration=2, blocks=4, tolerance=1e-8)).figure,
    ]
    for figure, told in zip(figures, ("the first 12 of 40 states", "the first 12 of 40 exponents"), strict=True):
        assert len(figure.axes) == 12
        notes = [legend.get_title().get_text() for legend in figure.legends]
        assert told in "".join([figure.axes[0].get_title(loc="left"), *notes])
    assert len(cd.plot(cd.trajectory(ring, duration=1, samples=4), state=("x0", "x39")).figure.axes) == 2


@pytest.mark.parametrize(
    ("result", "part", "told"),
    [
        (
            "spectrum",
            {"exponent": 0},
            "one entry of 'exponent' alone; select it as a list, as in ds.isel(exponent=[0])",
        ),
        ("diagram", {"iterate": 0}, "one entry of 'iterate' alone"),
        ("basin", {"v": 0}, "one entry of 'v' alone"),
        ("diagram", {"exponent": slice(0)}, "no entry of 'exponent'; select some"),
        ("basin", {"state": [0]}, "lacks the state 'v', without which points of attractors have no place"),
    ],
)
def test_a_part_that_a_picture_cannot_be_drawn_of_is_told(request, result, part, told):
    with pytest.raises(SettingsError, match=re.escape(told)):
        cd.plot(request.getfixturevalue(result).isel(part))


def test_a_variable_that_a_picture_needs_is_named(diagram):
    with pytest.raises(SettingsError, match="lacks the variable 'section'; draw the whole result"):
        cd.plot(diagram.drop_vars("section"))


def test_correlation_times_have_errors_and_spreads_need_variances():
    logistic = cd.Map("x", {"a": 3.9}, ["a*x*(1 - x)"], initial={"x": 0.3})
    ds = cd.finite_time_exponents(logistic, periods=64)
    ds["correlation_time"][:], ds["correlation_time_error"][:] = 1.3, 0.2
    assert cd.plot(ds).get_title(loc="left").endswith("correlation time 1.3(2) iterates")
    ds = cd.finite_time_exponents(logistic, periods=64, sweep={"a": [3.7, 3.9]})
    assert cd.plot(ds.sel(order=[2])).figure
    with pytest.raises(SettingsError, match=re.escape("select them, as in ds.sel(order=[2])")):
        cd.plot(ds.sel(order=[1]))
