"""A style leaves matplotlib as it was, from any number of threads, and a user's settings are heeded."""

import ast
import os
import subprocess
import sys
import textwrap
import threading
from pathlib import Path

import matplotlib as mpl
import matplotlib.style
import pytest
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties, findfont

import chaosdrill as cd
from chaosdrill.plots import tuning
from chaosdrill.plots.figures import new_figure
from chaosdrill.plots.style import lettering, page_style, saved_alike, style
from chaosdrill.plots.trajectories import phase_portrait, time_history


def _settings():
    return {name: value for name, value in mpl.rcParams.items() if name != "backend"}


# What a style sets is as before when the last thread has left it, whoever enters and leaves when.


def test_threads_leave_nothing_changed():
    before, entered = _settings(), threading.Barrier(8)
    faults = []

    def draw(number):
        entered.wait()
        made = (style, page_style, saved_alike)[number % 3]
        for _ in range(20):
            with made(), lettering():
                size, salt = mpl.rcParams["font.size"], mpl.rcParams["svg.hashsalt"]
                if (size, salt) != ((9.0, None), (10.5, "chaosdrill"), (9.0, "chaosdrill"))[number % 3]:
                    faults.append((number, size, salt))

    threads = [threading.Thread(target=draw, args=(number,)) for number in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60)
    assert faults == []
    assert _settings() == before


def test_what_somebody_sets_meanwhile_stays(monkeypatch):
    for name in ("lines.linewidth", "font.size"):
        monkeypatch.setitem(mpl.rcParams, name, mpl.rcParams[name])
    with style():
        mpl.rcParams["lines.linewidth"], mpl.rcParams["font.size"] = 7.5, 23.0
    assert (mpl.rcParams["lines.linewidth"], mpl.rcParams["font.size"]) == (7.5, 23.0)


@pytest.mark.filterwarnings("ignore:This process .* is multi-threaded:DeprecationWarning")
def test_a_child_that_is_forked_meanwhile_can_draw():
    inside, done = threading.Event(), threading.Event()

    def hold():
        with style():
            inside.set()
            done.wait(60)

    before = _settings()
    holder = threading.Thread(target=hold)
    holder.start()
    inside.wait(60)
    child = os.fork()
    if child == 0:
        code = 1
        try:
            same = _settings() == before
            with style():
                code = 0 if same else 2
        finally:
            os._exit(code)
    done.set()
    holder.join(60)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0


# A notebook's backend makes matplotlib interactive when the first figure calls for it; a style that puts that back with
# everything else hides every later picture.

BACKEND = """
import matplotlib
from matplotlib.backends.backend_agg import FigureCanvasAgg as FigureCanvas
matplotlib.interactive(True)
"""


def test_a_backend_that_the_first_picture_calls_for_stays_interactive(ball, tmp_path):
    ball.to_netcdf(tmp_path / "ball.nc")
    (tmp_path / "late.py").write_text(BACKEND)
    program = """
        import matplotlib, xarray
        import chaosdrill as cd
        assert not matplotlib.is_interactive()
        ax = cd.plot(xarray.open_dataset("ball.nc"))
        assert matplotlib.is_interactive()
        import matplotlib.pyplot as plt
        assert plt.gcf() is ax.figure
    """
    environment = dict(os.environ, MPLBACKEND="module://late", PYTHONPATH=os.pathsep.join([str(tmp_path), *sys.path]))
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(program)], cwd=tmp_path, env=environment, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(
    "family", ["sans-serif", "serif", "DejaVu Sans", ["cmr10", "sans-serif"], ["serif", "DejaVu Sans"]]
)
def test_a_font_is_looked_up_once_and_the_complete_one_always(family):
    with mpl.rc_context({"font.family": family}), style():
        files = [findfont(FontProperties(family=[name])) for name in mpl.rcParams["font.family"]]
    assert len(set(files)) == len(files)
    assert any(file.endswith("DejaVuSans.ttf") for file in files)


# Sizes and fonts that a user has set are those of the picture; its colours are those of white paper.


@pytest.mark.parametrize("size", [(3.35, 2.6), (10.0, 4.0)])
def test_the_users_figure_size(ball, size):
    with mpl.rc_context({"figure.figsize": size}):
        for figure in (phase_portrait(ball), cd.plot(ball).figure):
            assert tuple(figure.get_size_inches()) == size
    with style():
        assert new_figure(3.0).get_size_inches().tolist() == [7.2, 3.0]


def test_every_text_is_of_the_users_size(ball):
    ratios = []
    for size in (6.0, 12.0):
        with mpl.rc_context({"font.size": size}):
            figure = time_history(ball)
        figure.draw_without_rendering()
        texts = figure.findobj(lambda one: isinstance(one, mpl.text.Text) and one.get_text())
        ratios.append(sorted({round(text.get_fontsize() / size, 6) for text in texts}))
        assert 0.6 < ratios[-1][0] <= ratios[-1][-1] < 1.2
    assert ratios[0] == ratios[1]


@pytest.mark.parametrize(
    "settings",
    [
        {"font.family": "cmr10", "axes.formatter.use_mathtext": True},
        {"text.usetex": True},
        "dark_background",
        "ggplot",
    ],
)
def test_every_letter_is_drawn_in_any_style_black_on_white(spectrum, settings, tmp_path):
    """Computer Modern has no lowered digits, and TeX stops at them; a missing letter is a warning, which fails here."""
    with mpl.style.context(settings):
        figure = cd.plot(spectrum).figure
    figure.savefig(tmp_path / "a.png")
    assert "λ₁" in figure.axes[0].get_ylabel()
    assert mpl.colors.to_hex(figure.get_facecolor()) == "#ffffff"
    assert mpl.colors.to_hex(figure.axes[0].yaxis.label.get_color()) == "#000000"


def test_ticks_that_are_made_when_a_figure_is_drawn_have_its_style(ball, tmp_path):
    figure = cd.plot(ball).figure
    with mpl.rc_context({"xtick.labelsize": 40, "ytick.labelsize": 40}):
        figure.savefig(tmp_path / "a.png")
        sizes = {label.get_fontsize() for axes in figure.axes for label in axes.get_xticklabels() if label.get_text()}
    assert sizes == {8.0}


def test_axes_of_somebody_else_keep_their_style(ball):
    axes = Figure().add_subplot(axes_class=type("Own", (Axes,), {"name": "own"}))
    cd.plot(ball, ax=axes)
    assert axes.spines["top"].get_visible()
    assert axes.xaxis.label.get_fontsize() == mpl.rcParamsDefault["font.size"]


def test_the_same_picture_is_the_same_file(ball, tmp_path):
    archive = tmp_path / "run.nc"
    cd.save(xr.DataTree.from_dict({"orbit": ball}), archive)
    for ending in ("svg", "pdf", "png"):
        found = [cd.plot_archive(archive, tmp_path / f"{name}.{ending}")[1].read_bytes() for name in "ab"]
        assert found[0] == found[1], ending


def test_numbers_that_tune_stand_in_one_record():
    """But the width of a page, which studies share, the dots of jumps, and a constant of mathematics."""
    found = []
    for path in Path(tuning.__file__).parent.glob("*.py"):
        given = [one for one in ast.parse(path.read_text(encoding="utf-8")).body if isinstance(one, ast.Assign)]
        found += [ast.unparse(one.targets[0]) for one in given if _is_number(one.value)]
    assert sorted(found) == ["DOTS", "FEIGENBAUM", "WIDTH"]


def _is_number(value):
    if isinstance(value, ast.Tuple):
        return all(map(_is_number, value.elts))
    return isinstance(value, ast.Constant) and isinstance(value.value, int | float)
