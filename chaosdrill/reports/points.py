"""Tables of diagrams, charts and basins: which motions there are, and where."""

from typing import TYPE_CHECKING, Any

from chaosdrill.reports.html import Html, Quantity, element, table
from chaosdrill.reports.numbers import count, number, uncertain
from chaosdrill.reports.runs import flags, long_name

if TYPE_CHECKING:
    import xarray as xr

MOST_STRETCHES = 60
_PERIODIC = ("ok", "periodic")


def motions(dataset: "xr.Dataset") -> Html:
    """How many points have each period, and what the others are."""
    if "seed" not in dataset.dims or "period" not in dataset:
        return Html("")
    names = _kinds(dataset).ravel()
    largest = _largest(dataset)
    rows = []
    for name in dict.fromkeys(sorted(names, key=_rank)):
        here = names == name
        span = (number(largest.ravel()[here].min()), number(largest.ravel()[here].max())) if largest is not None else ()
        rows.append((name, int(here.sum()), Quantity(f"{100 * here.mean():.3g} %"), *map(Quantity, span)))
    head = [
        "motion",
        "points",
        "share",
        *(["least largest exponent", "greatest largest exponent"] if largest is not None else []),
    ]
    return table("Cycles and other motions", head, rows)


def without_results(dataset: "xr.Dataset") -> Html:
    """How many points have no exponent."""
    import numpy as np

    if "seed" not in dataset.dims:
        return Html("")
    largest = _largest(dataset)
    missing = 0 if largest is None else int(np.isnan(largest).sum())
    if not missing:
        return Html("")
    return element("p", f"{missing} of {count(largest.size, 'point')} have no exponent.", class_="note")


def stretches(dataset: "xr.Dataset") -> Html:
    """Along one parameter: from where to where the first seed has the same motion."""
    import numpy as np

    if dataset.attrs.get("kind") != "bifurcation-diagram":
        return Html("")
    parameter = str(dataset["outcome"].dims[0])
    ordered = dataset.isel(seed=0).sortby(parameter)
    values, names, largest = ordered[parameter].values, _kinds(ordered), _largest(ordered)
    starts = np.flatnonzero(np.r_[True, names[1:] != names[:-1]])
    ends = np.r_[starts[1:], len(names)]
    rows = []
    for start, end in zip(starts, ends, strict=True):
        row: list[Any] = [
            Quantity(number(values[start])),
            Quantity(number(values[end - 1])),
            names[start],
            int(end - start),
        ]
        if largest is not None:
            row.append(Quantity(number(largest[start:end].max())))
        rows.append(row)
    head = [f"from {parameter}", "to", "motion", "points", *(["greatest exponent"] if largest is not None else [])]
    of = " of the first seed" if dataset.sizes["seed"] > 1 else ""
    return table(f"Motions along {long_name(dataset, parameter)} {parameter}{of}", head, rows, MOST_STRETCHES)


def attractors(dataset: "xr.Dataset") -> Html:
    """The attractors that basins lead to."""
    if "attractor_number" not in dataset.dims:
        return Html("")
    names = flags(dataset["attractor_outcome"].attrs)
    states = [str(name) for name in dataset["state_name"].values]
    has_exponents, has_rate = "attractor_exponent" in dataset, "attractor_rate" in dataset
    rows = []
    for i, place in enumerate(dataset["attractor_number"].values):
        one = dataset.isel(attractor_number=i)
        period = int(one["attractor_period"])
        row: list[Any] = [
            int(place),
            f"period {period}" if period else _words(names.get(int(one["attractor_outcome"]), "")),
        ]
        row.append(Quantity(uncertain(one["fraction"], one["fraction_error"])))
        if has_exponents:
            row.append(Quantity(uncertain(one["attractor_exponent"].values[0], one["attractor_error"].values[0])))
        if has_rate:
            row.append(float(one["attractor_rate"]))
        rows.append([*row, *one["attractor_state"].values])
    head = ["attractor", "motion", "part of the starts", *(["largest exponent"] if has_exponents else [])]
    head += [*(["progression rate"] if has_rate else []), *(f"{name} at a point of it" for name in states)]
    return table("Attractors", head, rows)


def _kinds(dataset: "xr.Dataset") -> Any:
    """Name of the motion of every point."""
    import numpy as np

    names = flags(dataset["outcome"].attrs)
    codes, periods = dataset["outcome"].values, dataset["period"].values
    kinds = np.full(codes.shape, "", dtype=object)
    for code in np.unique(codes):
        name = names.get(int(code), f"code {int(code)}")
        here = codes == code
        if name not in _PERIODIC:
            kinds[here] = _words(name)
            continue
        for period in np.unique(periods[here]):
            kinds[here & (periods == period)] = f"period {period}" if period > 0 else "period not found"
    return kinds


def _largest(dataset: "xr.Dataset") -> Any:
    return dataset["lyapunov_exponent"].isel(exponent=0).values if "lyapunov_exponent" in dataset else None


def _rank(name: str) -> tuple[int, str]:
    """Periods in their order, then the rest."""
    last = name.rsplit(" ", 1)[-1]
    return (int(last), "") if name.startswith("period ") and last.isdigit() else (2**31, name)


def _words(name: str) -> str:
    return name.replace("_", " ")
