"""Does chaos drill faster than the periodic motion beside it? Pairs of neighbours, and windows between two cycles.

A pair is a chaotic point and a periodic one next to it along eta, at the same b. A window is a stretch of chaos between
two periodic points, whose rates are interpolated to its middle, so that a slope of the rate along eta is of no account.
Only cycles that drill are compared with: beside a motion that stands still anything is faster. Means over chaos come
from eight runs of their own.
"""

from dataclasses import dataclass, fields
from itertools import pairwise

import numpy as np
import xarray as xr
from agreement import values
from findings import Claim, ended, table

import chaosdrill as cd

DRILLS = 1e-3
"""Progression rate above which a motion is said to drill."""

SURE = 3.0
"""Standard errors by which two rates must differ."""

WIDEST = 40
"""Points of the widest window."""

RUNS = 8
"""Runs from which the mean over chaos and its standard error come."""


@dataclass(frozen=True)
class Comparison:
    """Rates of chaos less those of the cycles beside it.

    Parameters
    ----------
    b, eta : ndarray
        Where.
    chaos, error, cycle : ndarray
        Mean rate of chaos, its standard error, and the rate of the cycle.
    """

    b: np.ndarray
    eta: np.ndarray
    chaos: np.ndarray
    error: np.ndarray
    cycle: np.ndarray

    def between(self, low: float, high: float) -> "Comparison":
        """Return those with eta from ``low`` up to, not including, ``high``."""
        inside = (self.eta >= low) & (self.eta < high)
        return Comparison(*(getattr(self, field.name)[inside] for field in fields(self)))

    @property
    def gain(self) -> np.ndarray:
        """How much faster chaos is, relative to the cycle."""
        return self.chaos / self.cycle - 1

    @property
    def faster(self) -> np.ndarray:
        """Where chaos is faster beyond its error."""
        return self.chaos - self.cycle > SURE * self.error

    @property
    def slower(self) -> np.ndarray:
        """Where it is slower beyond its error."""
        return self.cycle - self.chaos > SURE * self.error

    def row(self, name: str) -> list[str]:
        """Return the line of the table."""
        low, middle, high = np.percentile(100 * self.gain, [10, 50, 90])
        counts = (self.gain.size, self.faster.sum(), self.slower.sum(), (~(self.faster | self.slower)).sum())
        cells = f"{middle:+.1f} %", f"{low:+.1f} % … {high:+.1f} %"
        return [name, *(str(n) for n in counts), *(cell.replace("-", "−") for cell in cells)]


BANDS = (0.3, 0.54, 0.72, 0.95, 1.2)
"""Bounds in eta of the regions of chaos."""

HEAD = ["", "number", "chaos faster", "slower", "within error", "median gain", "tenth … ninetieth percentile"]


def kinds(chart: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
    """Return where a chart over (eta, b) is chaotic, and where it is on a cycle that drills."""
    rate = chart["progression_rate"].transpose("eta", "b", "seed").values[..., 0]
    ordered = chart.transpose("eta", "b", "seed", ...)
    cycle = ended(ordered, "periodic")[..., 0] & (ordered["period"].values[..., 0] > 0) & (rate > DRILLS)
    return ended(ordered, "chaotic")[..., 0], cycle


def pairs(chaotic: np.ndarray, cycle: np.ndarray) -> list[tuple[tuple[int, int], tuple[int, int]]]:
    """Return the places of a chaotic point and of a cycle next to it along the first axis."""
    found = []
    for i, j in np.argwhere(chaotic):
        found += [((i, j), (k, j)) for k in (i - 1, i + 1) if 0 <= k < len(cycle) and cycle[k, j]]
    return found


def windows(chaotic: np.ndarray, cycle: np.ndarray) -> list[tuple[range, int]]:
    """Return stretches of chaos along the first axis between two cycles: their rows, and the column."""
    found = []
    for j in range(chaotic.shape[1]):
        turns = np.flatnonzero(np.diff(np.pad(chaotic[:, j].astype(int), 1)))
        for first, last in turns.reshape(-1, 2):
            inside = first > 0 and last < len(cycle) and cycle[first - 1, j] and cycle[last, j]
            if inside and last - first <= WIDEST:
                found.append((range(first, last), j))
    return found


def long_rates(chart: xr.Dataset, places: set[tuple[int, int]], periods: int) -> dict[tuple[int, int], np.ndarray]:
    """Return rate and standard error at chaotic places; NaN where chaos did not last in all runs.

    ``RUNS`` runs of this number of periods start a billionth apart: long before the averages begin they are
    independent.
    """
    system = cd.drill(**values(chart, (0, 0)))
    found = {}
    for j in sorted({j for _, j in places}):
        rows = sorted(i for i, column in places if column == j)
        runs = cd.parameter_chart(
            system,
            {"b": chart["b"].values[[j]], "eta": chart["eta"].values[rows]},
            transient=300,
            periods=periods,
            seeds=[{"y": 1e-9 * k} for k in range(RUNS)],
            exponents=1,
            tolerance=1e-10,
            workers=2,
        )
        rate = runs["progression_rate"].values[0]
        lasts = ended(runs, "chaotic")[0].all(axis=1)
        error = rate.std(axis=1, ddof=1) / np.sqrt(RUNS)
        for k, i in enumerate(rows):
            found[i, j] = np.array([rate[k].mean(), error[k]]) if lasts[k] else np.full(2, np.nan)
    return found


@dataclass(frozen=True)
class Rates:
    """Comparisons over all pairs and over all windows, and how many of the chaotic points beside cycles stay chaotic.

    Parameters
    ----------
    pairs, windows : Comparison
        Of the points at which chaos lasts.
    points, lasting : int
        Chaotic points that were run again, and those of them at which chaos lasted in all runs.
    """

    pairs: Comparison
    windows: Comparison
    points: int
    lasting: int

    def items(self) -> tuple[tuple[str, Comparison], ...]:
        """Return both comparisons with their names."""
        return ("pairs", self.pairs), ("windows", self.windows)


def compare(chart: xr.Dataset, periods: int = 1000) -> Rates:
    """Compare the rates of a chart over (eta, b), first seed."""
    chart = chart.transpose("eta", "b", "seed", ...)
    chaotic, cycle = kinds(chart)
    eta, b = chart["eta"].values, chart["b"].values
    rate = chart["progression_rate"].values[..., 0]
    beside = pairs(chaotic, cycle)
    between = windows(chaotic, cycle)
    wanted = {tuple(map(int, chaos)) for chaos, _ in beside} | {(int(i), int(j)) for rows, j in between for i in rows}
    known = long_rates(chart, wanted, periods)
    lines = [(b[j], eta[i], *known[i, j], rate[other]) for (i, j), other in beside]
    adjacent, lines = _kept(lines), []
    for rows, j in between:
        means = np.array([known[i, j] for i in rows])
        ends = rate[rows.start - 1, j], rate[rows.stop, j]
        error = np.sqrt((means[:, 1] ** 2).sum()) / len(means)
        lines.append((b[j], eta[list(rows)].mean(), means[:, 0].mean(), error, np.mean(ends)))
    lasting = sum(bool(np.isfinite(rate).all()) for rate in known.values())
    return Rates(adjacent, _kept(lines), len(known), lasting)


def _kept(lines: list[tuple[float, ...]]) -> Comparison:
    columns = np.array(lines, dtype=float).reshape(-1, 5)
    return Comparison(*columns[np.isfinite(columns).all(axis=1)].T)


def best(chart: xr.Dataset) -> tuple[list[list[str]], int, list[int]]:
    """Return, for some b, the fastest chaos and the fastest cycle; for how many b chaos wins; all cycles' periods."""
    chart = chart.transpose("eta", "b", "seed", ...)
    chaotic, cycle = kinds(chart)
    rate = chart["progression_rate"].values[..., 0]
    rows, wins, periods = [], 0, []
    for j, b in enumerate(chart["b"].values):
        if not (chaotic[:, j].any() and cycle[:, j].any()):
            continue
        tops = [int(np.where(mask[:, j], rate[:, j], -1).argmax()) for mask in (chaotic, cycle)]
        periods.append(int(chart["period"].values[tops[1], j, 0]))
        wins += bool(rate[tops[0], j] > rate[tops[1], j])
        if abs(b * 20 - round(b * 20)) < 1e-6:
            rows.append([f"{b:.2f}", *(f"{rate[i, j]:.3f} at η = {chart['eta'].values[i]:.3f}" for i in tops)])
    return rows, wins, periods


def tables(chart: xr.Dataset, found: Rates) -> str:
    """Return both tables of the page."""
    lines = []
    for name, comparison in found.items():
        lines.append(comparison.row(f"all {name}"))
        for low, high in pairwise(BANDS):
            part = comparison.between(low, high)
            if part.gain.size:
                lines.append(part.row(f"{name}, η from {low:g} to {high:g}"))
    rows, _, _ = best(chart)
    short = f"Chaos lasted in all {RUNS} runs at {found.lasting} of {found.points} points; the others are left out.\n\n"
    return short + table(HEAD, lines) + "\n" + table(["b", "fastest chaos", "fastest cycle"], rows)


def claims(chart: xr.Dataset, found: Rates) -> list[Claim]:
    """Return what the page says of the rates."""
    _, wins, periods = best(chart)
    result = []
    for name, comparison in found.items():
        most = comparison.slower.sum() > comparison.faster.sum()
        text = f"chaos drills slower than the cycle beside it in most {name}"
        result.append(Claim(text, f"{comparison.slower.sum()} of {comparison.gain.size}", bool(most)))
    low, high = BANDS[-2:]
    part = found.windows.between(low, high)
    text = f"only above η = {low:g} it is faster than the cycles on both sides in most windows"
    others = [found.windows.between(*band) for band in pairwise(BANDS[:-1])]
    holds = part.faster.sum() > part.slower.sum() and all(o.faster.sum() < o.slower.sum() for o in others)
    result.append(Claim(text, f"{part.faster.sum()} of {part.gain.size}", bool(holds)))
    total, short = len(periods), sum(period <= 2 for period in periods)
    return [
        *result,
        Claim("at most b some cycle is faster than all chaos", f"{total - wins} of {total}", wins < total - wins),
        Claim("the fastest cycle has mostly period 1 or 2", f"{short} of {total}", short > 0.8 * total),
    ]
