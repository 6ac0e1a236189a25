"""Accuracy: convergence of exponents with the length of the run, and of errors with the tolerance and its cost."""

from textwrap import fill
from typing import Any

import numpy as np

from chaosdrill.analysis.precision.advice import MANY, NAMES, cheapest, shown_quantities
from chaosdrill.dataset.outcomes import flag_names
from chaosdrill.plots._types import Axes, Dataset, Figure
from chaosdrill.plots.figures import is_narrow, legend_outside, new_figure, note
from chaosdrill.plots.labels import exponent_text, subscript, time_unit
from chaosdrill.plots.markers import tell
from chaosdrill.plots.palette import DASHES, MARKERS, PALETTE
from chaosdrill.plots.pictures import picture
from chaosdrill.plots.tuning import TUNING


@picture("lyapunov-spectrum", "convergence", "running means of the exponents")
def convergence(dataset: Dataset) -> Figure:
    """Draw the running means of the finite exponents, of at most a dozen, over the length of the run.

    One panel per exponent, each on its own scale, with a band of one standard error of a run of that length to either
    side. Exponents of minus infinity have no curve: the title names them.
    """
    values = np.atleast_1d(dataset["lyapunov_exponent"].values)
    errors = np.atleast_1d(dataset["lyapunov_error"].values)
    every = np.flatnonzero(np.isfinite(values)).tolist()
    finite = every[: TUNING.most_panels]
    figure = new_figure(1.2 + 1.5 * max(len(finite), 1), least=0.9 + 1.2 * TUNING.low * len(finite))
    panels = np.atleast_1d(figure.subplots(max(len(finite), 1), 1, sharex=True))
    unit, _, units = time_unit(dataset)
    time = dataset["block_time"].values / unit
    for panel, i in zip(panels, finite, strict=False):
        history = dataset["lyapunov_history"].values[:, i]
        _panel(panel, time, history, float(values[i]), float(errors[i]))
        panel.set_ylabel(subscript("λ", i + 1))
        panel.set_title(exponent_text(i + 1, values[i], errors[i]))
    panels[-1].set_xlabel(f"length of the run ({units})")
    figure.align_ylabels(list(panels))
    legend_outside(figure, panels[0].get_legend_handles_labels()[0], ncols=2, handlelength=1.4)
    lost = [subscript("λ", i + 1) for i in np.flatnonzero(np.isneginf(values)).tolist()]
    told = [f"{' = '.join(lost)} = −∞ (direction lost at an event)"] if lost else []
    told += [f"the first {len(finite)} of {len(every)} exponents"] if len(finite) < len(every) else []
    tell(figure, "; ".join(told), "black")
    if not len(finite):
        panels[0].set_axis_off()
    return figure


def _panel(panel: Axes, time: np.ndarray, history: np.ndarray, value: float, error: float) -> None:
    panel.axhline(value, color="0.5", linewidth=0.7, zorder=1)
    if np.isfinite(error) and error > 0:
        width = error * np.sqrt(time[-1] / time)
        look: dict[str, Any] = {"color": PALETTE[0], "alpha": 0.18, "linewidth": 0, "zorder": 0}
        words = "± one standard error of a run of that length"
        panel.fill_between(time, value - width, value + width, label=words, **look)
    panel.plot(time, history, color=PALETTE[0], label="running mean")
    settled = history[time >= TUNING.settled * time[-1]]
    reach = max(np.max(np.abs(settled - value)), 4 * error if np.isfinite(error) else 0.0, 1e-12 * abs(value), 1e-15)
    panel.set_ylim(value - 1.15 * reach, value + 1.15 * reach)
    panel.margins(x=0)
    panel.ticklabel_format(axis="y", useOffset=False)
    panel.locator_params(axis="y", nbins=4)


@picture("work-precision", "work-precision", "errors against time, over methods and tolerances")
def work_precision(dataset: Dataset) -> Figure:
    """Draw time against correct digits.

    One panel per quantity, and one for the time over which a chaotic trajectory can be trusted. A line is a method, a
    point a tolerance; a ring marks the cell to use for 8 digits, with its tolerance. The titles give the cost of a
    further digit.
    """
    quantities = shown_quantities(dataset)
    horizon = bool(np.isfinite(dataset["horizon"]).any())
    count = max(1, len(quantities) + horizon)
    columns = 1 if is_narrow() else min(count, 2)
    rows = -(-count // columns)
    figure = new_figure(0.9 + 2.9 * rows, least=1.3 + 2.8 * TUNING.low * rows)
    panels = list(np.atleast_1d(figure.subplots(rows, columns, sharey=True)).ravel())
    for panel, quantity in zip(panels, quantities, strict=False):
        _quantity(panel, dataset, quantity)
    if horizon:
        _horizon(panels[len(quantities)], dataset)
    if not quantities and not horizon:
        panels[0].text(0.5, 0.5, "nothing could be measured; see outcome", ha="center", transform=panels[0].transAxes)
    for panel in panels[count:]:
        panel.set_axis_off()
    what = "forcing period" if "forcing_period" in dataset.variables else "unit of model time"
    times = 1e6 * dataset["wall_time"].values
    if np.isfinite(times).any():
        # room for the labels under the lowest line
        panels[0].set_ylim(np.nanmin(times) / 2.5, np.nanmax(times) * 2)
    for panel in panels[:count:columns]:
        panel.set_ylabel(f"time per {what} (µs)")
    figure.suptitle(_heading(dataset), x=0.01, ha="left")
    shown = [line for panel in panels for line in panel.get_lines()]
    if lines := {line.get_label(): line for line in shown if line.get_label() in dataset["method"].values}:
        legend_outside(figure, list(lines.values()), ncols=len(lines), loc="outside lower center", handlelength=3.0)
    return figure


def _quantity(panel: Axes, dataset: Dataset, quantity: str) -> None:
    errors = dataset["error"].sel(quantity=quantity)
    prices = []
    for i, (method, error) in enumerate(zip(dataset["method"].values, errors.values, strict=True)):
        with np.errstate(divide="ignore"):
            digits = np.clip(-np.log10(error), 0, TUNING.most_digits)
        price = _line(panel, dataset, i, np.where(np.isfinite(error), digits, np.nan))
        if np.isfinite(price):
            prices.append(f"{method} +{max(price, 0.0):.0%}".replace("%", " %"))
    _ring(panel, dataset, quantity)
    _limit(panel, dataset, quantity)
    panel.set_xlim(0, TUNING.digits_width)
    panel.set_xticks(range(0, 17, 2))
    panel.set_xlabel(r"correct digits (error $10^{-\mathrm{digits}}$)")
    name = NAMES[quantity].removeprefix("the ").capitalize()
    # a price is one word
    told = fill(
        f"each digit: {', '.join(prices)}".replace(" +", "\u00a0+").replace(" %", "\u00a0%"), TUNING.title_letters
    )
    panel.set_title(f"{name}\n{told}".replace("\u00a0", " ") if prices else name, fontsize="small")


def _line(panel: Axes, dataset: Dataset, number: int, x: np.ndarray) -> float:
    """Draw one method; return the mean growth of its time per unit of x, minus one."""
    method = str(dataset["method"].values[number])
    tolerances, time = dataset["tolerance"].values, 1e6 * dataset["wall_time"].values[number]
    known = np.flatnonzero(np.isfinite(x) & np.isfinite(time))
    if not known.size:
        return float("nan")
    known = known[np.argsort(-tolerances[known], kind="stable")]
    x, time = x[known], time[known]
    # each distinguishes the methods, also on grey paper
    colour, marker = PALETTE[number % len(PALETTE)], MARKERS[number % len(MARKERS)]
    panel.plot(x, time, DASHES[number % len(DASHES)], marker=marker, color=colour, markersize=4, label=method)
    panel.set_yscale("log")
    return float(np.exp(np.polyfit(x, np.log(time), 1)[0]) - 1) if np.ptp(x) > 1 else float("nan")


def _ring(panel: Axes, dataset: Dataset, quantity: str) -> None:
    """Mark the cell to use for ``MANY`` digits."""
    found = cheapest(dataset, quantity, MANY)
    panel.axvline(MANY, color="0.8", linewidth=0.7, zorder=0)
    if found:
        method, tolerance, time = found
        # "method" and "tolerance" as keywords would be taken for those of the look-up itself
        error = float(dataset["error"].sel({"quantity": quantity, "method": method, "tolerance": tolerance}))
        digits = min(-np.log10(max(error, 1e-300)), TUNING.most_digits)
        panel.plot([digits], [1e6 * time], "o", markersize=11, markerfacecolor="none", markeredgecolor="black")
        note(panel, _power(tolerance), (digits, 1e6 * time), (0, 7), ha="center")


def _limit(panel: Axes, dataset: Dataset, quantity: str) -> None:
    """Shade the digits of an exponent that a run of this length does not determine."""
    error = float(dataset["lyapunov_error"])
    if quantity != "exponent" or not 0 < error < 1:
        return
    panel.axvspan(-np.log10(error), TUNING.digits_width, color="0.92", zorder=0, linewidth=0)
    text = "lost in the statistical\nerror of the run"
    panel.text(-np.log10(error) + 0.2, 0.98, text, transform=panel.get_xaxis_transform(), va="top", fontsize="small")


def _horizon(panel: Axes, dataset: Dataset) -> None:
    unit, _, units = time_unit(dataset)
    for i in range(dataset.sizes["method"]):
        times = dataset["horizon"].values[i] / unit
        _line(panel, dataset, i, np.where(np.isfinite(times), times, np.nan))
    panel.set_xlabel(f"{units} within 1e-6 of the truth")
    panel.set_title("One trajectory in chaos\nbeyond this time only averages are meaningful", fontsize="small")


def _power(tolerance: float) -> str:
    """A tolerance as scenes have it, without zeros: ``1e-8``."""
    mantissa, exponent = f"{tolerance:.2g}".split("e") if tolerance < 1e-4 else f"{tolerance:.0e}".split("e")
    return f"{mantissa}e{int(exponent)}"


def _heading(dataset: Dataset) -> str:
    period = int(dataset["period"])
    where = f"on a cycle of period {period}" if period else "from a state of the attractor"
    system = str(dataset.attrs.get("system", "")) or "the system"
    codes, names = dataset["outcome"].transpose("method", "tolerance").values, flag_names(dataset["outcome"])
    # methods that came to an early end at every tolerance
    missing = "; ".join(
        f"{method}, {names[int(row[0])]}"
        for method, row in zip(dataset["method"].values, codes, strict=True)
        if all(names[int(code)] != "ok" for code in row)
    )
    tolerances = dataset["tolerance"].values.tolist()
    return (
        f"Cost of a digit: {system}, {where}{f' (not measured: {missing})' if missing else ''}\n"
        f"Lower is cheaper, right is more exact. Points: tolerances {_power(max(tolerances))} to "
        f"{_power(min(tolerances))}. Ring: use this for {MANY} digits."
    )
