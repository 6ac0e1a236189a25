"""A run as a moving picture: the point on its path, its events as they happen, and the bodies of its system."""

import json
import shutil
import subprocess
from collections.abc import Iterator, Mapping
from os import PathLike, fspath
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from numpy.typing import NDArray

from chaosdrill.archive import check_writable, writing
from chaosdrill.dataset.outcomes import flag_names
from chaosdrill.errors import ArchiveError, SettingsError
from chaosdrill.plots._types import Axes, Dataset, Floats, Line2D, States, Truths
from chaosdrill.plots.contents import places_of
from chaosdrill.plots.curve import Curve, breaks, curve_of, is_joined, pieces
from chaosdrill.plots.figures import legend_outside, new_figure
from chaosdrill.plots.labels import label, readable, shorten, state_label, wrapped
from chaosdrill.plots.palette import DOTS, PALETTE, event_look
from chaosdrill.plots.style import style
from chaosdrill.plots.tuning import TUNING
from chaosdrill.systems import bodies_of
from chaosdrill.typed import NAMED, NUMBER, PATH, TABLE, expecting

MOVING = ("gif", "mp4")
_GREY = "0.8"


@expecting(SettingsError, path=PATH, state=NAMED, bodies=TABLE, seconds=NUMBER)
def animate(
    ds: "Dataset",
    path: str | PathLike[str],
    state: States = None,
    bodies: Mapping[str, str | float] | None = None,
    seconds: float = 10.0,
) -> Path:
    """Write an animation of a run.

    It shows the point on its path in the plane of two states, with its events as they happen, one state over time, and
    the bodies of the system, if it has any: those of the library's mechanical systems, such as the bit, the stop and
    the rock of the drill, or the given ones.

    Parameters
    ----------
    ds : xarray.Dataset
        Of kind ``trajectory``.
    path : path
        The file; its suffix is the format, gif or mp4. The latter needs the program ffmpeg. It is written whole or not
        at all.
    state : pair of str, optional
        States of the plane, the first of which is drawn over time; default: the first two.
    bodies : mapping of str to str or float, optional
        Height of each body, as an expression in states, quadratures, parameters and ``t``, such as
        ``{"ball": "x", "floor": "amplitude*sin(omega*t)"}``. Default: those of the system; none: ``{}``.
    seconds : float, default 10
        Length of the animation, at most 60; it has 20 frames a second, or one per sample if there are fewer samples.

    Returns
    -------
    pathlib.Path
        The file.

    Raises
    ------
    SettingsError
        If the dataset is of another kind, the suffix is not a format, a state or name is unknown, the length is out of
        range, or ffmpeg is missing.
    ArchiveError
        If the file cannot be written.
    """
    import xarray as xr

    target = Path(path)
    ending = target.suffix.lstrip(".").lower()
    if ending not in MOVING:
        raise SettingsError(f"path: {fspath(path)!r} has no format as its ending; use one of {', '.join(MOVING)}")
    if not isinstance(ds, xr.Dataset) or ds.attrs.get("kind") != "trajectory" or is_joined(ds):
        raise SettingsError("ds is not a single run; give what cd.trajectory returned, or one group of an archive")
    if ds.sizes["time"] < 2:
        raise SettingsError(f"ds has {ds.sizes['time']} samples; an animation needs two or more")
    if not 0 < seconds <= TUNING.longest_animation:
        raise SettingsError(f"seconds is {seconds}, but must be above 0 and at most {TUNING.longest_animation:g}")
    program = shutil.which("ffmpeg") if ending == "mp4" else ""
    if program is None:
        raise SettingsError(f"path: {fspath(path)!r} needs ffmpeg, which is not found; install it, or name a .gif")
    check_writable(target, target.suffix)
    with style():
        scene = _Scene(ds, places_of(ds, state, 2), bodies, seconds)
        with writing(target, "animation") as draft:
            _write_gif(scene, draft) if ending == "gif" else _write_mp4(scene, draft, str(program))
            scene.figure.clear()
    return target


class _Scene:
    """The figure of an animation: what stays, drawn once, and what moves, drawn over it again for every frame."""

    def __init__(
        self, run: Dataset, plane: tuple[int, ...], bodies: Mapping[str, str | float] | None, seconds: float
    ) -> None:
        self.run, self.curve = run, curve_of(run)
        time = run["time"].values
        self.times = np.linspace(time[0], time[-1], int(np.clip(round(TUNING.frame_rate * seconds), 2, len(time))))
        self.second = (time[-1] - time[0]) / seconds
        self.rate = len(self.times) / seconds
        self.figure = new_figure(4.8)
        self.figure.set_dpi(TUNING.frame_density)
        self.figure.set_size_inches(7.2, 4.8)
        heights = _heights(run, self.curve, self.times, bodies)
        panels = bool(heights) + (len(plane) > 1)
        rows = self.figure.add_gridspec(1 + bool(panels), 1, height_ratios=[2.4, 1.0][-1 - bool(panels) :])
        above = rows[0].subgridspec(1, max(panels, 1), width_ratios=[0.45, 1.0][-max(panels, 1) :])
        self.moving: list[Line2D] = []
        self.bodies = self._bodies(self.figure.add_subplot(above[0, 0]), heights) if heights else []
        over_time, across = self.curve.time, self.curve.state[:, plane]
        below = self.figure.add_subplot(rows[-1])
        self.graphs = [_Graph(self, below, over_time, across[:, 0])]
        below.set(xlabel=label(run["time"]), ylabel=wrapped(state_label(run, plane[0])))
        below.margins(x=0)
        if len(plane) > 1:
            axes = self.figure.add_subplot(above[0, -1])
            self.graphs.append(_Graph(self, axes, across[:, 0], across[:, 1]))
            axes.set(xlabel=state_label(run, plane[0]), ylabel=state_label(run, plane[1]))
        self.main = self.graphs[-1].axes
        self.said = self.main.text(1, 1, "", transform=self.main.transAxes, ha="right", va="bottom", animated=True)
        named = [axes.get_legend_handles_labels()[0] for axes in self.figure.axes]
        shown = {handle.get_label(): handle for handles in named for handle in handles}
        legend_outside(self.figure, list(shown.values()), handlelength=1.4)
        self.canvas = FigureCanvasAgg(self.figure)

    def _bodies(self, axes: Axes, heights: dict[str, Floats]) -> list[tuple[Line2D, Any]]:
        colours = ("#000000", PALETTE[0], "0.6")
        found = []
        for (name, height), colour in zip(heights.items(), colours * len(heights), strict=False):
            options: dict[str, Any] = {"color": colour, "linewidth": 4, "solid_capstyle": "butt", "label": name}
            (line,) = axes.plot([0.1, 0.9], height[[0, 0]], **options)
            if np.ptp(height):
                found.append((line, height))
                self.moves(line)
        every = np.concatenate(list(heights.values()))
        edge = 0.08 * float(np.ptp(every)) or 1.0
        axes.set(xlim=(0, 1), ylim=(every.min() - edge, every.max() + edge), xticks=[], ylabel="height")
        return found

    def moves(self, line: Line2D) -> None:
        """Exclude a line from the static part."""
        line.set_animated(True)
        self.moving.append(line)

    def frames(self) -> Iterator[NDArray[np.uint8]]:
        """Every frame, shape (height, width, 4)."""
        self.canvas.draw()
        self.figure.set_layout_engine("none")
        still = self.canvas.copy_from_bbox(self.figure.bbox)
        names = flag_names(self.run["event_kind"]) if self.run.sizes["event"] else {}
        events, kinds = self.run["event_time"].values, self.run["event_kind"].values
        for number, now in enumerate(self.times):
            for line, height in self.bodies:
                line.set_ydata(height[[number, number]])
            flashing = (events <= now) & (events > now - TUNING.flash * self.second)
            for graph in self.graphs:
                graph.show(now, flashing)
            told = [readable(names[int(kind)]) for kind in kinds[flashing][-1:]]
            self.said.set_text(", ".join([*told, f"time {shorten(now)}"]))
            self.canvas.restore_region(still)
            for artist in (*self.moving, self.said):
                self.figure.draw_artist(artist)
            yield np.array(self.canvas.buffer_rgba())


class _Graph:
    """One curve of a scene: the whole in grey, its last part, the point, and marks that flash at events."""

    def __init__(self, scene: _Scene, axes: Axes, x: Floats, y: Floats) -> None:
        self.axes, self.curve, self.points = axes, scene.curve, np.column_stack([x, y])
        self.trail, self.breaks = TUNING.trail * scene.second, breaks(scene.curve.time, self.points)
        flow, jumps = pieces(scene.curve.time, x, y)
        axes.plot(*flow.T, color=_GREY, linewidth=0.8)
        axes.plot(*jumps.T, color=_GREY, linewidth=0.6, linestyle=DOTS)
        (self.way,) = axes.plot([], [], color=PALETTE[0], linewidth=1.6)
        self.marks = []
        kinds = scene.run["event_kind"].values
        sides = np.searchsorted(scene.curve.time, scene.run["event_time"].values, "right") - 1
        for number, (code, name) in enumerate(flag_names(scene.run["event_kind"]).items() if kinds.size else ()):
            if (kinds == code).any():
                marker, colour = event_look(number)
                options: dict[str, Any] = {"marker": marker, "markersize": 9, "color": colour, "label": readable(name)}
                self.marks.append((*axes.plot([], [], linestyle="none", **options), kinds == code))
        self.sides = self.points[sides]
        (self.point,) = axes.plot([], [], "o", color="black", markersize=6)
        for line in (self.way, *(line for line, _ in self.marks), self.point):
            scene.moves(line)

    def show(self, now: float, flashing: Truths) -> None:
        """Move the moving artists to where they are at a time."""
        time = self.curve.time
        first, last = np.searchsorted(time, [now - self.trail, now])
        here = at(time, self.points, now)
        within = self.breaks[(self.breaks > first) & (self.breaks < last)] - first
        way = np.insert(np.vstack([self.points[first:last], here]), within, np.nan, axis=0)
        self.way.set_data(*way.T)
        self.point.set_data(*here.reshape(2, 1))
        for line, of_kind in self.marks:
            line.set_data(*self.sides[flashing & of_kind].T)


def at(time: Floats, values: Floats, now: Any) -> Floats:
    """Values, shape (m, n), at one time or several between those of a curve; at an event those after it."""
    after = np.clip(np.searchsorted(time, now, "right"), 1, len(time) - 1)
    step = time[after] - time[after - 1]
    part = np.where(step > 0, (now - time[after - 1]) / np.where(step > 0, step, 1.0), 1.0)
    between: Floats = values[after - 1] + np.expand_dims(part, -1) * (values[after] - values[after - 1])
    return between


def _heights(run: Dataset, curve: Curve, times: Floats, bodies: Mapping[str, str | float] | None) -> dict[str, Floats]:
    """The height of each body at given times."""
    import sympy

    from chaosdrill.model.grammar import ExpressionError
    from chaosdrill.model.text import read_text

    states = dict(zip(run["state"].values.tolist(), at(curve.time, curve.state, times).T, strict=True))
    integrals = {
        str(name): np.interp(times, run["time"].values, run[name].values)
        for name in run.data_vars
        if run[name].dims == ("time",) and name != "mode"
    }
    known: dict[str, Any] = {"t": times, **json.loads(run.attrs.get("parameters", "{}")), **integrals, **states}
    declared = bodies_of(str(run.attrs.get("system")), known) if bodies is None else bodies
    # what is called as a function is called must not stand for it
    symbols = {name: sympy.Dummy(real=True) for name in known}
    found = {}
    for name, text in declared.items():
        try:
            expression = read_text(str(text), symbols)
        except ExpressionError as fault:
            raise SettingsError(f"bodies: {name}: {fault}") from None
        with np.errstate(all="ignore"):
            height = sympy.lambdify(list(symbols.values()), expression, "numpy")(*known.values())
        found[name] = np.broadcast_to(np.asarray(height, dtype=float), times.shape)
        if not np.isfinite(found[name]).all():
            raise SettingsError(f"bodies: {name}: {text} is not finite all the time")
    return found


def _write_gif(scene: _Scene, draft: Path) -> None:
    from PIL import Image

    depths = np.linspace(0, 1, TUNING.gif_shades)[:, np.newaxis]
    shades = np.concatenate([1 - depths * (1 - np.array(to_rgb(colour))) for colour in PALETTE])
    palette = Image.new("P", (1, 1))
    palette.putpalette(np.round(255 * shades).astype(np.uint8).tobytes())
    frames = (
        Image.fromarray(frame[..., :3]).quantize(palette=palette, dither=Image.Dither.NONE) for frame in scene.frames()
    )
    next(frames).save(draft, "GIF", save_all=True, append_images=frames, duration=round(1000 / scene.rate), loop=0)


def _write_mp4(scene: _Scene, draft: Path, program: str) -> None:
    width, height = scene.canvas.get_width_height()
    given = ["-f", "rawvideo", "-pix_fmt", "rgba", "-s", f"{width}x{height}", "-r", f"{scene.rate:.6g}", "-i", "-"]
    made = ["-an", "-vcodec", "h264", "-pix_fmt", "yuv420p", "-f", "mp4", str(draft)]
    command = [program, "-y", "-loglevel", "error", *given, *made]
    done = subprocess.run(command, input=b"".join(frame.tobytes() for frame in scene.frames()), capture_output=True)
    if done.returncode:
        reason = done.stderr.decode(errors="replace").strip()[-300:]
        raise ArchiveError(f"ffmpeg cannot write the animation: {reason}; name a .gif instead")
