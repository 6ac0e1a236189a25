"""Figures 2 to 6 of the paper and the picture of the README, drawn from the archives alone."""

import json
from pathlib import Path

import numpy as np
import xarray as xr
from contact import CONTACTS, force
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import chaosdrill as cd
from chaosdrill.plots.curve import curve_of, strobe
from chaosdrill.plots.figures import legend_above
from chaosdrill.plots.palette import PALETTE
from chaosdrill.plots.style import WIDTH, style

_GAP, _SPEED = "relative displacement x₁ − x₃", "bit speed x₂"


def _open(out: Path, case: str, group: str) -> xr.Dataset:
    with xr.open_datatree(out / f"{case}.nc") as tree:
        return tree[group].to_dataset().load()


def _figure2(out: Path) -> Figure:
    """The contact: force over time at several approach speeds, and an impact that takes time."""
    figure = Figure(figsize=(WIDTH, 3.4), layout="constrained")
    left, right = figure.subplots(1, 2)
    with xr.open_datatree(out / "contact.nc") as tree:
        hits = {name: group.to_dataset().load() for name, group in tree.children.items()}
    impacts = {name: hits.pop(name) for name in CONTACTS}
    for name, hit in hits.items():
        pushes = force(hit)
        last, top = np.flatnonzero(pushes)[-1] + 2, int(pushes.argmax())
        left.plot(1e3 * hit["time"].values[:last], pushes[:last], color=PALETTE[0])
        peak = 1e3 * hit["time"].values[top], pushes[top]
        speed = name.removeprefix("hit_")
        left.annotate(speed, peak, (0, 2), textcoords="offset points", ha="center")
    left.set_xlabel("time since first contact (10⁻³/ω₀)")
    left.set_ylabel("contact force over static friction")
    left.set_title("at five approach speeds")
    left.margins(y=0.08)
    for (name, orbit), line in zip(impacts.items(), ("-", (0, (3, 1.5))), strict=True):
        curve = curve_of(orbit)
        for column, (state, label) in enumerate(((1, "bit x₂"), (2, "rock x₄"))):
            right.plot(
                1e3 * curve.time,
                curve.state[:, state],
                color=PALETTE[column],
                linestyle=line,
                label=f"{label}, {name.rpartition('-')[2]}",
            )
    right.set_xlabel("time since first contact (10⁻³/ω₀)")
    right.set_ylabel("speed")
    right.legend(loc="center right", handlelength=1.5)
    _letter(left, "a")
    _letter(right, "b")
    return figure


def _figure3(out: Path) -> Figure:
    """Period 1: displacements and speeds over three forcing periods, with the impacts."""
    orbit = _open(out, "period1", "orbit")
    forcing = float(orbit["forcing_period"])
    orbit = orbit.sel(time=slice(None, orbit["time"].values[0] + 3 * forcing))
    start, end = orbit["time"].values[[0, -1]]
    orbit = orbit.isel(event=(orbit["event_time"].values >= start) & (orbit["event_time"].values <= end))
    periods = (orbit["time"].values - start) / forcing
    drift = orbit["penetration"].values - orbit["penetration"].values[0]
    curve = curve_of(orbit)
    kinds = str(orbit["event_kind"].attrs["flag_meanings"]).split()
    impact = np.isin(orbit["event_kind"].values, [code for code, kind in enumerate(kinds) if kind.endswith("hit")])
    hits = (orbit["event_time"].values[impact] - start) / forcing

    figure = Figure(figsize=(WIDTH, 5.2), layout="constrained")
    above, below = figure.subplots(2, 1, sharex=True)
    above.plot(periods, orbit["states"].values[:, 0] + drift, color=PALETTE[0], label="bit x₁")
    above.plot(periods, drift, color=PALETTE[1], label="rock x₃")
    above.set_ylabel("displacement")
    below.plot((curve.time - start) / forcing, curve.state[:, 1], color=PALETTE[0], label="bit x₂")
    below.plot((curve.time - start) / forcing, curve.state[:, 2], color=PALETTE[1], label="rock x₄")
    below.set_ylabel("speed")
    below.set_xlabel("time (forcing periods)")
    for axes in (above, below):
        for hit in hits:
            axes.axvline(
                hit, color="0.4", linewidth=0.7, linestyle="--", zorder=0, label="impact" if hit == hits[0] else None
            )
        axes.margins(x=0)
        legend_above(axes)
    _letter(above, "a")
    _letter(below, "b")
    return figure


def _figure4(out: Path) -> Figure:
    """Period 1 in the phase plane."""
    figure = Figure(figsize=(WIDTH * 0.6, 3.6), layout="constrained")
    axes = figure.subplots()
    _portrait(axes, _open(out, "period1", "orbit"))
    legend_above(axes, columns=3)
    return figure


def _figure5(out: Path) -> Figure:
    """Periods 2 and 4 in the phase plane."""
    figure = Figure(figsize=(WIDTH, 3.6), layout="constrained")
    for axes, case, letter in zip(figure.subplots(1, 2), ("period2", "period4"), "ab", strict=True):
        _portrait(axes, _open(out, case, "orbit"))
        _letter(axes, letter)
        if letter == "a":
            legend_above(axes, columns=3)
    return figure


def _figure6(out: Path) -> Figure:
    """Chaos: the phase plane, and the attractor in the stroboscopic section."""
    figure = Figure(figsize=(WIDTH, 3.6), layout="constrained")
    left, right = figure.subplots(1, 2)
    _portrait(left, _open(out, "chaos", "orbit"), weight=0.35, points=False)
    legend_above(left, columns=3)
    _letter(left, "a")
    section = _open(out, "chaos", "section")["section"].values
    right.scatter(section[:, 0], section[:, 1], s=0.6, color="black", linewidth=0, rasterized=True)
    right.set_xlabel(_GAP)
    right.set_ylabel(_SPEED)
    _letter(right, "b")
    return figure


def _drill(out: Path) -> Figure:
    """The picture of the README: regimes over the frequency ratio, and the attractor at one of them."""
    diagram, section = _open(out, "diagram", "diagram"), _open(out, "attractor", "section")
    eta = json.loads(section.attrs["parameters"])["eta"]
    figure = Figure(figsize=(1.5 * WIDTH, 4.0), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=[1.7, 1])
    cd.plot(diagram, ax=left, state="u")
    left.axvline(eta, color=PALETTE[1], linewidth=1.0, linestyle="--", zorder=0)
    left.set_title("Speed of the bit, once per forcing period: cycles, chaos, runaway (hatched)")
    cd.plot(section, "poincare-section", ax=right, state=("y", "u"))
    right.set_title(f"The chaotic attractor at η = {eta:g}", color=PALETTE[1])
    return figure


def _portrait(axes: Axes, orbit: xr.Dataset, weight: float = 0.9, points: bool = True) -> None:
    curve = curve_of(orbit)
    axes.plot(curve.state[:, 0], curve.state[:, 1], color=PALETTE[0], linewidth=weight, label="orbit")
    if points:
        section = strobe(orbit)
        axes.scatter(
            section[:, 0],
            section[:, 1],
            s=26,
            color=PALETTE[1],
            edgecolor="white",
            linewidth=0.4,
            zorder=3,
            label="section",
        )
    stop = json.loads(orbit.attrs["parameters"])["r"]
    axes.axvline(stop, color="0.25", linewidth=0.9, linestyle="--", zorder=1, label="stop")
    axes.set_xlabel(_GAP)
    axes.set_ylabel(_SPEED)


def _letter(axes: Axes, letter: str) -> None:
    axes.set_title(f"{letter})", loc="right")


FIGURES = {
    "figure2": _figure2,
    "figure3": _figure3,
    "figure4": _figure4,
    "figure5": _figure5,
    "figure6": _figure6,
    "drill": _drill,
}


def draw(name: str, out: Path) -> Path:
    """Draw one of ``FIGURES`` from the archives in ``out`` and return the picture's path."""
    path = out / f"{name}.png"
    with style():
        FIGURES[name](out).savefig(path)
    return path
