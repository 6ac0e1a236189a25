"""Tables of periodic orbits and of branches: multipliers, events, special points, cascades."""

from typing import TYPE_CHECKING, Any

from chaosdrill.reports.html import Html, Quantity, element, joined, table
from chaosdrill.reports.numbers import number
from chaosdrill.reports.runs import flags, meaning
from chaosdrill.reports.scenes import read_json

if TYPE_CHECKING:
    import xarray as xr

_DIGITS = 12


def orbits(dataset: "xr.Dataset") -> Html:
    """Every orbit found, with its point, its multipliers and what its checks say."""
    if dataset.attrs.get("kind") != "periodic-orbit":
        return Html("")
    many = dataset if "orbit" in dataset.dims else dataset.expand_dims("orbit")
    states = [str(name) for name in dataset["state_name"].values]
    points, checks = [], []
    for i in range(many.sizes["orbit"]):
        one = many.isel(orbit=i)
        name = str(int(one["orbit"])) if "orbit" in one.coords else "the one asked for"
        length = [int(one["period"]), float(one["period_time"])]
        stable = "stable" if int(one["stable"]) else "unstable"
        state = [Quantity(number(value, _DIGITS)) for value in one["orbit_state"].values]
        points.append((name, *length, stable, *state, Quantity(_complex(one))))
        differences = [float(one[f"{key}_difference"]) for key in ("exponent", "determinant", "recurrence")]
        agrees = "yes" if int(one["consistent"]) else "no"
        checks.append(
            (name, float(one["residual"]), *differences, agrees, int(one["event_count"]), float(one["smallest_speed"]))
        )
    head = ("orbit", "period", "duration", "stability", *(f"{name} at phase 0" for name in states), "multipliers")
    checked = ("orbit", "residual", "exponents against multipliers", "sum rule", "recurrence", "agrees with itself")
    return joined(
        [
            table("Orbits", head, points),
            table("How good the orbits are", (*checked, "events", "smallest normal speed"), checks),
            _events(dataset) if "orbit" not in dataset.dims else None,
        ]
    )


def branches(dataset: "xr.Dataset") -> Html:
    """Branches of orbits with their starts and ends, their special points, and the cascade."""
    import numpy as np

    if dataset.attrs.get("kind") != "continuation":
        return Html("")
    parameters = [str(name) for name in read_json(dataset.attrs.get("settings")).get("sweep", {})]
    owner, stable = dataset["branch"].values, dataset["stable"].values
    rows = []
    for i, branch in enumerate(dataset["branch_number"].values):
        own, one = owner == branch, dataset.isel(branch_number=i)
        spans = []
        for name in parameters:
            values = dataset[name].values[own]
            spans.append(Quantity(f"{number(np.min(values))} to {number(np.max(values))}" if values.size else "–"))
        start, end = str(one["branch_start"].item()), str(one["branch_end_text"].item())
        rows.append(
            (int(branch), int(one["branch_period"]), *spans, int(own.sum()), int(stable[own].sum()), start, end)
        )
    head = ("branch", "period", *parameters, "points", "stable", "begins", "ends")
    return joined([table("Branches", head, rows), _special(dataset, parameters), _cascade(dataset)])


def _special(dataset: "xr.Dataset", parameters: list[str]) -> Html:
    kinds = dataset["special_kind"]
    owner = dataset["branch"].values
    values = [dataset[name].values for name in ("special_value", "special_value_2")[: len(parameters)]]
    rows = []
    for i, place in enumerate(dataset["special_index"].values):
        at = [Quantity(number(column[i], _DIGITS)) for column in values]
        error = Quantity(number(dataset["special_error"].values[i], 2))
        kind, words = meaning(kinds.values[i], kinds.attrs), str(dataset["special_text"].values[i])
        rows.append((kind, *at, error, int(owner[place]), words))
    return table("Special points", ("kind", *parameters, "error", "branch", "what happens"), rows)


def _cascade(dataset: "xr.Dataset") -> Html:
    if "doubling_value" not in dataset:
        return Html("")
    columns = [dataset[name].values for name in ("doubling_period", "doubling_value", "feigenbaum_ratio")]
    rows = [
        (int(period), Quantity(number(at, _DIGITS)), float(ratio)) for period, at, ratio in zip(*columns, strict=True)
    ]
    note = "The ratios tend to Feigenbaum's 4.6692 where one smooth direction doubles."
    shown = table("Period doublings", ("period that doubles", "at", "ratio of distances"), rows)
    return joined([shown, element("p", note, class_="note") if rows else None])


def _events(orbit: "xr.Dataset") -> Html:
    kinds, names = orbit["event_kind"], flags(orbit["event_kind"].attrs)
    states = [str(name) for name in orbit["state_name"].values]
    rows = []
    for i in range(int(orbit["event_count"])):
        after = list(orbit["event_state_after"].values[i])
        name = names.get(int(kinds.values[i]), "")
        rows.append((name, float(orbit["event_time"].values[i]), float(orbit["event_speed"].values[i]), *after))
    head = ("event", "time", "normal speed", *(f"{name} after" for name in states))
    return table("Events of the orbit", head, rows)


def _complex(orbit: Any) -> str:
    pairs = zip(orbit["multiplier_real"].values, orbit["multiplier_imag"].values, strict=True)
    return ", ".join(number(a) + (f"{'+' if b > 0 else '−'}{number(abs(b))}i" if b else "") for a, b in pairs)
