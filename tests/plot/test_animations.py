"""Animations: their frames, what moves in them, and files that are written whole or not at all."""

import numpy as np
import pytest
import xarray as xr
from PIL import Image

import chaosdrill as cd
from chaosdrill.errors import ArchiveError, SettingsError
from chaosdrill.plots.animation import _heights, _Scene, at
from chaosdrill.plots.curve import curve_of
from chaosdrill.plots.pictures import plot_archive
from chaosdrill.plots.style import style
from chaosdrill.systems import REGISTRY, bodies_of

# A file has the frames and the length that were asked for, and is there whole or not at all.


@pytest.mark.parametrize(("seconds", "frames"), [(0.5, 10), (60, 401)])
def test_a_gif_has_its_frames(ball, tmp_path, seconds, frames):
    run = ball if frames < 100 else ball.isel(time=slice(0, 401, 40), event=slice(0, 10, 2))
    with Image.open(cd.animate(run, tmp_path / "run.gif", seconds=seconds)) as image:
        assert image.n_frames == min(frames, run.sizes["time"])
        length = 0
        for number in range(image.n_frames):
            image.seek(number)
            length += image.info["duration"]
        assert length == pytest.approx(1000 * seconds, rel=0.02)
        assert max(image.size) <= 720


def test_an_mp4_is_made_by_ffmpeg_or_the_remedy_is_told(ball, tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(SettingsError, match=r"run.mp4' needs ffmpeg, which is not found; install it, or name a .gif"):
        cd.animate(ball, tmp_path / "run.mp4")
    program = tmp_path / "ffmpeg"
    program.write_text("#!/bin/sh\necho no encoder >&2\nexit 1\n")
    program.chmod(0o755)
    with pytest.raises(ArchiveError, match=r"ffmpeg cannot write the animation: no encoder; name a .gif"):
        cd.animate(ball, tmp_path / "run.mp4", seconds=0.2)
    assert [file.name for file in tmp_path.iterdir()] == ["ffmpeg"]


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"path": "run.avi"}, "path: 'run.avi' has no format as its ending; use one of gif, mp4"),
        ({"seconds": 61}, "seconds is 61, but must be above 0 and at most 60"),
        ({"seconds": "long"}, "seconds is 'long'; it must be a number"),
        ({"bodies": {"ball": "z"}}, "bodies: ball: unknown name 'z'"),
        ({"bodies": {"ball": "1/x"}}, "bodies: ball: 1/x is not finite all the time"),
        ({"state": ("x", "z")}, "state names 'z'; states are x, v"),
    ],
)
def test_what_cannot_be_is_told(ball, tmp_path, monkeypatch, changed, message):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SettingsError, match=message):
        cd.animate(**{"ds": ball, "path": "run.gif", **changed})
    assert not list(tmp_path.iterdir())


def test_other_results_are_no_run(section, tmp_path):
    with pytest.raises(SettingsError, match=r"ds is not a single run; give what cd.trajectory returned"):
        cd.animate(section, tmp_path / "run.gif")


def test_the_command_animates_every_run(tree_of_runs, tmp_path):
    files = plot_archive(tree_of_runs, animated=True)
    assert [file.name for file in files] == ["runs-long-animation.gif", "runs-short-animation.gif"]
    assert plot_archive(tree_of_runs, tmp_path / "one.gif", "short", animated=True) == [tmp_path / "one.gif"]
    with pytest.raises(SettingsError, match=r"has no animation format as its ending; use one of gif, mp4"):
        plot_archive(tree_of_runs, "run.png", animated=True)
    with pytest.raises(ArchiveError, match="there is no animation for orbit \\(periodic-orbit\\)"):
        plot_archive(tree_of_runs, group="orbit", animated=True)


@pytest.fixture
def tree_of_runs(tmp_path):
    clock = cd.HybridSystem(
        states="x",
        modes={"on": {"x": "1"}},
        transitions=[cd.Transition("turn", "on", "on", guard="x - 1", direction=1, reset={"x": "0"})],
    )
    runs = {name: cd.trajectory(clock, duration=d, samples=9) for name, d in (("long", 3.5), ("short", 1.5))}
    groups = {**runs, "orbit": cd.periodic_orbit(clock, at="turn")}
    return cd.save(xr.DataTree.from_dict(groups), tmp_path / "runs.nc")


# The point is where the run is; its way has a gap at a jump; bodies that hit each other touch.


def test_the_point_is_on_the_run(ball):
    curve = curve_of(ball)
    now = np.array([0.3, 1.0, 1.777, 2.0, 7.51])
    local = now % 2
    exact = np.stack([local * (2 - local) / 2, 1 - local], axis=1)
    # the samples are 0.05 apart: half the curvature times the square of half of it
    np.testing.assert_allclose(at(curve.time, curve.state, now), exact, atol=0.025**2 / 2)


def test_the_way_behind_the_point_crosses_no_jump(ball):
    with style():
        scene = _Scene(ball, (0, 1), {}, 10.0)
        graph = scene.graphs[-1]
        graph.show(6.5, np.zeros(10, dtype=bool))
        way = graph.way.get_xydata()
        steps = np.abs(np.diff(way, axis=0))[:, 1]
        assert np.isnan(way).any()
        assert np.nanmax(steps) < 0.06
        assert graph.point.get_xydata()[0] == pytest.approx([0.375, 0.5], abs=1e-3)
        graph.show(6.05, ball["event_time"].values == 6.0)
        assert graph.marks[0][0].get_xydata().tolist() == [[0.0, 1.0]]


WITH_BODIES = ("percussive-drill", "bouncing-ball", "gear-rattle", "impact-oscillator", "impact-pair", "print-hammer")


def test_every_system_with_bodies_is_held_to_touch():
    declared = {name for name in REGISTRY if bodies_of(name, {*_known(cd.build(name))})}
    assert declared == set(WITH_BODIES)


def _known(system):
    return (*system.state_names, *system.parameters, *system.quadratures)


@pytest.mark.parametrize("name", WITH_BODIES)
def test_bodies_touch_where_they_hit(name):
    system = cd.build(name)
    hits = [t.name for t in system.transitions if t.kind == "impact"]
    run = cd.trajectory(system, periods=20, samples=20)
    met = run["event_time"].values[np.isin(run.cd.words("event_kind"), hits)]
    assert met.size
    heights = np.stack(list(_heights(run, curve_of(run), met, None).values()))
    apart = [np.abs(one - other) for i, one in enumerate(heights) for other in heights[:i]]
    assert np.min(apart, axis=0).max() < 1e-9


def test_heights_do_not_depend_on_what_things_are_called():
    """A state called like the function that stands beside it shadowed it."""
    found = []
    for name in ("x", "sin"):
        system = cd.HybridSystem(
            states=f"{name} v", modes={"free": {name: "v", "v": f"-{name}"}}, transitions=[], initial={name: 0.5}
        )
        run = cd.trajectory(system, duration=2.0, samples=8)
        found.append(_heights(run, curve_of(run), run["time"].values, {"body": f"{name} + sin(t)"})["body"])
    np.testing.assert_array_equal(*found)
