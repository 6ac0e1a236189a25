"""How accurate the numbers are, and what they cost."""

from math import log
from typing import TYPE_CHECKING, Any

from chaosdrill.reports.html import Html, Quantity, element, joined, table
from chaosdrill.reports.numbers import MISSING, number, seconds
from chaosdrill.reports.runs import meaning

if TYPE_CHECKING:
    from collections.abc import Mapping

    import xarray as xr

TRUSTED = 1e-6
"""Error up to which a chaotic trajectory counts as known."""


def accuracy_section(groups: "Mapping[str, xr.Dataset]") -> Html:
    """One table over all analyses."""
    rows = []
    for name, dataset in groups.items():
        wall, runs = dataset.attrs.get("wall_time_s"), dataset["outcome"].size if "outcome" in dataset else 1
        row: list[Any] = [name, str(dataset.attrs.get("method", MISSING)), Quantity(_attribute(dataset, "tolerance"))]
        row += [runs, Quantity(MISSING if wall is None else seconds(wall))]
        row.append(Quantity(MISSING if wall is None else seconds(float(wall) / max(runs, 1))))
        rows.append([*row, _largest_error(dataset), _grazing(dataset), Quantity(_horizon(dataset))])
    head = ["analysis", "method", "tolerance", "runs", "wall time", "a run", "largest standard error of an exponent"]
    head += ["smallest normal speed", f"trajectory known to {TRUSTED:g} until"]
    note = (
        "The tolerance bounds the error of a step. A chaotic trajectory is known only for the time ln("
        f"{TRUSTED:g}/tolerance)/λ₁; averages have standard errors instead, twice which covers the truth in 95 %. "
        "Tangents, and with them errors, grow without bound as the smallest normal speed at an event goes to zero."
    )
    return joined([table("Accuracy and cost", head, rows), element("p", note, class_="note")])


def work_precision(dataset: "xr.Dataset") -> Html:
    """Errors, time and steps of every method at every tolerance, and the advice that follows."""
    if dataset.attrs.get("kind") != "work-precision":
        return Html("")
    quantities = [str(name) for name in dataset["quantity"].values]
    rows = []
    for method in range(dataset.sizes["method"]):
        for place in range(dataset.sizes["tolerance"]):
            cell = dataset.isel(method=method, tolerance=place)
            fixed = int(cell["steps_per_period"])
            asked = f"{fixed} steps" if fixed else number(cell["tolerance"].values, 3)
            errors = [Quantity(number(value, 2)) for value in cell["error"].values]
            cost = [Quantity(seconds(cell["wall_time"])), float(cell["steps"]), float(cell["evaluations"])]
            rows.append(
                [
                    str(cell["method"].values),
                    Quantity(asked),
                    *errors,
                    *cost,
                    meaning(cell["outcome"], cell["outcome"].attrs),
                ]
            )
    head = ["method", "asked", *(f"error: {name.replace('_', ' ')}" for name in quantities)]
    shown = table(
        "Work and precision", [*head, "time a period", "steps a period", "evaluations a period", "outcome"], rows
    )
    advice = [element("li", line) for line in str(dataset.attrs.get("recommendation", "")).splitlines() if line.strip()]
    return joined([element("ul", *advice) if advice else None, shown])


def _attribute(dataset: "xr.Dataset", name: str) -> str:
    return number(dataset.attrs[name], 3) if name in dataset.attrs else MISSING


def _largest_error(dataset: "xr.Dataset") -> Quantity:
    import numpy as np

    errors = dataset["lyapunov_error"].values if "lyapunov_error" in dataset else np.empty(0)
    known = errors[np.isfinite(errors)]
    return Quantity(number(known.max(), 2) if known.size else MISSING)


def _grazing(dataset: "xr.Dataset") -> Quantity:
    import numpy as np

    name = next((key for key in ("closest_grazing", "smallest_speed") if key in dataset), None)
    speeds = np.empty(0) if name is None else dataset[name].values
    known = speeds[np.isfinite(speeds)]
    return Quantity(number(known.min(), 3) if known.size else MISSING)


def _horizon(dataset: "xr.Dataset") -> str:
    """Time until which the most chaotic motion of the dataset is known."""
    import numpy as np

    tolerance = float(dataset.attrs.get("tolerance", 0.0))
    if "lyapunov_exponent" not in dataset or not 0 < tolerance < TRUSTED:
        return MISSING
    exponents = dataset["lyapunov_exponent"].values
    known = exponents[np.isfinite(exponents)]
    if not known.size or known.max() <= 0:
        return MISSING
    return f"t = {number(log(TRUSTED / tolerance) / float(known.max()), 3)}"
