"""Tables that any analysis may have: single numbers, exponents, multipliers, events, and how the runs ended."""

from typing import TYPE_CHECKING, Any

from chaosdrill.reports.html import Html, Quantity, element, joined, table
from chaosdrill.reports.numbers import number, uncertain

if TYPE_CHECKING:
    import xarray as xr


def single_numbers(dataset: "xr.Dataset") -> Html:
    """Every variable that is one number, with its error and its unit."""
    rows = []
    for name, variable in dataset.variables.items():
        if (
            name == "outcome"
            or variable.ndim
            or variable.dtype.kind not in "iuf"
            or (str(name).endswith("_error") and _owner(dataset, name))
        ):
            continue
        error = next(
            (dataset[key].values for key in _errors(str(name)) if key in dataset and not dataset[key].ndim), None
        )
        if "flag_meanings" in variable.attrs:
            shown: Any = meaning(variable.values, variable.attrs)
        elif error is not None:
            shown = Quantity(uncertain(variable.values, error))
        else:
            shown = Quantity(number(variable.values))
        rows.append((long_name(dataset, name), shown, unit(variable.attrs), str(variable.attrs.get("comment", ""))))
    return table("Numbers", ("quantity", "value", "unit", "note"), rows)


def exponents(dataset: "xr.Dataset") -> Html:
    """Exponents of one run, largest first, with their standard errors."""
    if "lyapunov_exponent" not in dataset or dataset["lyapunov_exponent"].dims != ("exponent",):
        return Html("")
    values, errors = dataset["lyapunov_exponent"].values, dataset["lyapunov_error"].values
    rows = [
        (i, Quantity(number(v)), Quantity(number(e, 2))) for i, (v, e) in enumerate(zip(values, errors, strict=True), 1)
    ]
    note = element("p", "Per unit of model time. −∞ stands for a direction that is lost at events.", class_="note")
    return joined([table("Lyapunov exponents", ("number", "exponent", "standard error"), rows), note])


def multipliers(dataset: "xr.Dataset") -> Html:
    """Multipliers of the cycle of one run."""
    if "multiplier_real" not in dataset or dataset["multiplier_real"].ndim != 1:
        return Html("")
    pairs = zip(dataset["multiplier_real"].values, dataset["multiplier_imag"].values, strict=True)
    rows = [(i, real, imag, abs(complex(real, imag))) for i, (real, imag) in enumerate(pairs, 1) if real == real]
    return table("Multipliers of the cycle", ("number", "real part", "imaginary part", "modulus"), rows)


def event_counts(dataset: "xr.Dataset") -> Html:
    """How often each transition was taken in a run."""
    if "event_count" in dataset and "transition_name" in dataset.coords:
        counted = zip(map(str, dataset["transition_name"].values), dataset["event_count"].values, strict=True)
        return table("Events counted", ("transition", "times"), counted)
    if dataset.attrs.get("kind") != "trajectory":
        return Html("")
    kinds, speeds = dataset["event_kind"], abs(dataset["event_speed"].values)
    several = "run" in dataset.dims
    rows = []
    for run, part in _runs(dataset).items():
        for code, name in flags(kinds.attrs).items():
            hit = kinds.values[part] == code
            if hit.any():
                rows.append((*[run] * several, name, int(hit.sum()), float(speeds[part][hit].min())))
    head = (*["run"] * several, "transition", "times", "smallest normal speed")
    return table("Events on the way", head, rows)


def _runs(dataset: "xr.Dataset") -> dict[str, slice]:
    """Events of each of joined runs; all events if it is one."""
    if "run" not in dataset.dims:
        return {"": slice(None)}
    ends = dataset["event_count"].values.cumsum()
    starts = ends - dataset["event_count"].values
    return {str(n): slice(a, b) for n, a, b in zip(dataset["run"].values, starts, ends, strict=True)}


def outcomes(dataset: "xr.Dataset") -> Html:
    """How many runs ended how, and what to do about it."""
    if "outcome" not in dataset:
        return Html("")
    from chaosdrill.dataset.outcomes import Outcome, count_outcomes

    advice = {outcome.meaning: outcome.advice for outcome in Outcome}
    total = dataset["outcome"].size
    counts = count_outcomes(dataset["outcome"].values)
    rows = [
        (name.replace("_", " "), n, Quantity(f"{100 * n / total:.3g} %"), advice.get(name, ""))
        for name, n in counts.items()
    ]
    shown = table("Outcomes", ("outcome", "runs", "share", "what it means, and what to try"), rows)
    words = [
        element("p", str(dataset.attrs[key]), class_="fault")
        for key in ("message", "disagreement")
        if dataset.attrs.get(key)
    ]
    return joined([shown, *words])


def flags(attributes: Any) -> dict[int, str]:
    """Names of codes, from the CF attributes of their variable."""
    import numpy as np

    names = str(attributes.get("flag_meanings", "")).split()
    return dict(zip(map(int, np.atleast_1d(attributes.get("flag_values", []))), names, strict=True))


def meaning(code: Any, attributes: Any) -> str:
    """Name of a code, in words."""
    return flags(attributes).get(int(code), f"code {int(code)}").replace("_", " ")


def long_name(dataset: "xr.Dataset", name: Any) -> str:
    """Long name of a variable."""
    return str(dataset[name].attrs.get("long_name", name))


def unit(attributes: Any) -> str:
    """Unit of a variable; nothing where it is dimensionless."""
    found = str(attributes.get("units", ""))
    return "" if found == "1" else found


def _errors(name: str) -> tuple[str, str]:
    return f"{name}_error", f"{name.rsplit('_', 1)[0]}_error"


def _owner(dataset: "xr.Dataset", error: Any) -> bool:
    """Whether the number that an error belongs to is in the dataset."""
    return any(str(error) in _errors(str(name)) for name in dataset.variables if name != error)
