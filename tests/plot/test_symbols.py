"""Names on axes are set as symbols where plain text can, lines end where another attractor begins, marks have room."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

import chaosdrill as cd
from chaosdrill.plots.curve import stops
from chaosdrill.plots.labels import axis_label, readable, state_label, symbol, wrapped
from chaosdrill.plots.markers import room
from chaosdrill.plots.sections import bifurcation


@pytest.mark.parametrize(
    ("name", "shown"),
    [
        ("eta", "η"),
        ("Omega", "Ω"),
        ("lambda", "λ"),
        ("omega12", "ω₁₂"),
        ("x1", "x₁"),
        ("q", "q"),
        ("amplitude", "amplitude"),
        ("wall2", "wall2"),
        ("mu_e", "mu_e"),
        ("x_1", "x_1"),
        ("12", "12"),
        ("$x$", "$x$"),
    ],
)
def test_names_as_symbols(name, shown):
    assert symbol(name) == shown


@pytest.mark.parametrize(
    ("name", "long_name", "shown"),
    [
        ("wall", "position of the wall", "position of the wall"),
        ("a", "amplitude of a load", "amplitude of a load a"),
        ("omega", "frequency", "frequency ω"),
        ("I_ref", "reference current", "reference current I_ref"),
    ],
)
def test_no_word_is_said_twice(name, long_name, shown):
    coords = {name: (name, [0.0], {"long_name": long_name})}
    ds = xr.Dataset(coords=coords, attrs={"system": "impact-oscillator"})
    assert axis_label(ds, name) == shown


@pytest.mark.parametrize(
    ("given", "units", "shown"),
    [
        ("load", "1", "load"),
        ("load", "kN", "load (kN)"),
        ("load (kN)", "kN", "load (kN)"),
        ("load / kN", "kN", "load / kN"),
        ("$F$ [kN]", "kN", "$F$ [kN]"),
        (r"$\hat q$", "1", r"$\hat q$"),
        ("q", "1", "q"),
    ],
)
def test_a_label_stands_in_the_place_of_symbol_and_unit(given, units, shown):
    own = cd.HybridSystem(
        name="own", states="x", parameters={"q": 1.0}, modes={"flow": {"x": "-q*x"}}, labels={"q": given, "x": given}
    )
    diagram = cd.trajectory(own, duration=1, samples=2)
    assert state_label(diagram, 0) == given
    # of the library, and of anybody's own system, whether given to it or put in later
    for ds in (xr.Dataset(attrs={"system": "own"}), cd.trajectory(cd.build("lorenz"), duration=1, samples=2)):
        named = ds.assign_coords(q=("q", [0.0], {"long_name": given, "units": units}))
        assert axis_label(named, "q") == shown


def test_control_characters_are_drawn_as_codes():
    ds = xr.Dataset(coords={"q": ("q", [0.0], {"long_name": "load\x1b[31m\u202e"})}, attrs={"system": "own"})
    assert axis_label(ds, "q") == "load\\x1b[31m\\u202e"


def test_what_the_library_calls_it_is_followed_by_its_symbol():
    run = cd.trajectory(cd.build("impact-oscillator"), periods=1, samples=2)
    assert state_label(run, 0) == "displacement x"
    changed = run.assign_coords(state_long_name=("state", ["gap", "velocity"]))
    assert [state_label(changed, i) for i in (0, 1)] == ["gap", "velocity v"]


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("slip_forward", "slip forward"),
        ("bounce-off", "bounce off"),
        ("above+-", "above+−"),
        ("above-+", "above−+"),
        ("sliding--", "sliding−−"),
    ],
)
def test_the_signs_of_a_mode_are_no_blanks(name, words):
    assert readable(name) == words


def test_a_line_ends_where_another_attractor_begins(diagram):
    ordered = diagram.sortby("q").isel(seed=[0])
    count = ordered.sizes["q"]
    rate = np.where(np.arange(count) < count // 2, 0.0, 1.0) + 0.01 * np.arange(count)
    steps = ordered.assign(progression_rate=(("q", "seed"), rate[:, None]))
    panel = bifurcation(steps).axes[-2]
    line = max(panel.lines, key=lambda one: len(one.get_xdata()))
    drawn = np.asarray(line.get_ydata(), dtype=float)
    assert np.isnan(drawn).sum() == 1
    assert np.abs(np.diff(drawn[: count // 2])).max() < 0.1


@pytest.mark.parametrize(
    ("text", "lines"),
    [
        ("exit speed of the rock v", ["exit speed of the", "rock v"]),
        ("rate of $a + b c + d + e$", ["rate of", "$a + b c + d + e$"]),
        ("a" * 9 + " " + "b" * 8, ["a" * 9 + " " + "b" * 8]),
        ("a" * 9 + " " + "b" * 9, ["a" * 9, "b" * 9]),
    ],
)
def test_labels_of_short_axes_have_lines_that_fit_and_keep_formulas_and_symbols_whole(text, lines):
    assert wrapped(text) == "\n".join(lines)


def test_marks_are_no_wider_than_the_way_to_the_next(tmp_path):
    axes = Figure(figsize=(10, 10)).subplots()
    axes.set(xlim=(0, 1), ylim=(0, 1))
    box = axes.get_position()
    near = 5 / (72 * 10 * box.width)
    wide = room(axes, np.array([[0.1, 0.5], [0.1 + near, 0.5], [0.9, 0.5], [0.9, 0.5]]))
    assert wide[:2].tolist() == [5.0, 5.0]
    assert (wide[2:] > 100).all()


def test_a_state_that_jumps_is_no_wall(ball):
    """In a cycle every hit has the same speed, which is none at which the ball could not be."""
    before, after = ball["event_state_before"].values.copy(), ball["event_state_after"].values.copy()
    before[:, 1], after[:, 1] = -2.0, 1.6
    cycle = ball.assign(
        event_state_before=ball["event_state_before"].copy(data=before),
        event_state_after=ball["event_state_after"].copy(data=after),
    )
    assert stops(cycle, 1) == []
    assert [round(level, 6) for _, level in stops(cycle, 0)] == [0.0]
