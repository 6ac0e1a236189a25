"""What a table of errors and costs says to someone who wants a number of digits."""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, cast

import numpy as np

from chaosdrill.analysis.tuning import PRECISION

if TYPE_CHECKING:
    import xarray as xr

FEW, MANY, MOST = 4, 8, 12


NAMES: Mapping[str, str] = {
    "strobe": "the strobe point",
    "event_time": "the event times",
    "tangent": "the tangent map",
    "multiplier": "the multipliers",
    "flow_direction": "the flow direction",
    "exponent": "the leading exponent",
}


def shown_quantities(ds: "xr.Dataset") -> list[str]:
    """Quantities that were measured, without those that say the same as another.

    On a cycle the multipliers tell all of the tangent map and of the exponents.
    """
    measured = [str(q) for q in ds["quantity"].values if np.isfinite(ds["error"].sel(quantity=q)).any()]
    covered = {"tangent", "exponent"} if "multiplier" in measured else set()
    return [q for q in measured if q not in covered]


def recommend(ds: "xr.Dataset") -> str:
    """Advice in words, a sentence a line, from the table alone.

    ``ds``: ``error`` (quantity, method, tolerance), ``wall_time`` (method, tolerance), ``lyapunov_exponent`` and
    ``lyapunov_error``, ``horizon`` (method, tolerance), ``forcing_period`` if there is one.

    Returns: for each quantity what ``MANY`` (and ``MOST``) digits cost over ``FEW``, and which method and tolerance to
    take for ``MANY``; or how many digits were reached. Then what the statistical error and chaos leave of them.
    """
    advice: dict[str, list[str]] = {}
    disagree: dict[str, list[str]] = {}
    for quantity in shown_quantities(ds):
        if told := contradictions(ds, quantity):
            disagree.setdefault(told, []).append(NAMES[quantity])
        else:
            advice.setdefault(_digits(ds, quantity), []).append(NAMES[quantity])
    lines = [f"{MANY} digits of {_listed(names)} {text}" for text, names in advice.items()]
    lines += [
        f"methods disagree about {_listed(names)} beyond their errors, so that none is recommended: {told}"
        for told, names in disagree.items()
    ]
    lines += [] if disagree else [*_statistics(ds), *_horizon(ds)]
    return "\n".join(lines) if lines else "nothing could be measured; see outcome"


def contradictions(ds: "xr.Dataset", quantity: str) -> str:
    """Which methods are off a quantity at their tightest tolerance by more than accuracy explains; empty: none.

    Fixed steps have an error of their own.
    """
    found = []
    for method in ds["method"].values:
        cells = ds.sel({"method": method, "quantity": quantity}).sortby("tolerance", ascending=False)
        errors, tolerances = cells["error"].values, cells["tolerance"].values
        known = ~np.isnan(errors)
        if not known.any() or ("steps_per_period" in ds.variables and cells["steps_per_period"].values.any()):
            continue
        first, last, tolerance = errors[known][0], errors[known][-1], float(tolerances[known][-1])
        if last > PRECISION.contradicts * max(tolerance, PRECISION.rounding) and not last < 0.1 * first:
            found.append(f"{method} is off by {last:.1g} at {tolerance:g}")
    return "; ".join(found)


def cheapest(ds: "xr.Dataset", quantity: str, digits: float) -> tuple[str, float, float] | None:
    """Method, tolerance and time of the cheapest cell with an error of at most 10^-digits; None without one.

    Of those that cost the same within ``same`` it is the one with the tightest tolerance.
    """
    reached = (ds["error"].sel(quantity=quantity) <= 10.0**-digits) & np.isfinite(ds["wall_time"])
    if not reached.any():
        return None
    times = ds["wall_time"].where(reached)
    return _cell(times, ds["tolerance"].where(times <= PRECISION.same * times.min()))


def best(ds: "xr.Dataset", quantity: str) -> tuple[str, float, float]:
    """Method, tolerance and error of the most accurate cell."""
    errors = ds["error"].sel(quantity=quantity)
    return _cell(errors, errors)


def _cell(values: "xr.DataArray", least: "xr.DataArray") -> tuple[str, float, float]:
    """Method, tolerance and value of the cell at which another quantity is least."""
    one = values.isel(cast("dict[str, xr.DataArray]", least.argmin(("method", "tolerance"))))
    return str(one["method"].values), float(one["tolerance"]), float(one)


def _digits(ds: "xr.Dataset", quantity: str) -> str:
    """What ``MANY`` digits of a quantity cost."""
    few, many, most = (cheapest(ds, quantity, digits) for digits in (FEW, MANY, MOST))
    if many is None:
        method, tolerance, error = best(ds, quantity)
        digits = max(0.0, -np.log10(error))
        return f"are not reached; the best is {digits:.1f} ({method} at {tolerance:g})"
    method, tolerance, time = many
    base = few[2] if few else time
    cost = f"{time / base:.2g} times what {FEW} cost" if time > PRECISION.same * base else f"no more than {FEW}"
    unit = "period" if "forcing_period" in ds.variables else "unit of time"
    further = f" ({MOST} digits {max(1.0, most[2] / base):.2g} times)" if most else ""
    return f"cost {cost}{further}; use {method} at {tolerance:g} ({duration(time)} a {unit})"


def _listed(names: list[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def _statistics(ds: "xr.Dataset") -> Iterator[str]:
    if "exponent" not in shown_quantities(ds):
        return
    value, error = float(ds["lyapunov_exponent"]), float(ds["lyapunov_error"])
    # an exponent that the structure makes zero has an error of round-off
    if not error > 1e-12 or not np.isfinite(value):
        return
    enough = cheapest(ds, "exponent", -np.log10(0.1 * error))
    advice = f"; {enough[0]} at {enough[1]:g} is exact enough" if enough else ""
    yield (
        f"the leading exponent of this run is {value:.3g} +- {error:.1g}: the length of the run limits its digits"
        f"{advice}"
    )


def _horizon(ds: "xr.Dataset") -> Iterator[str]:
    horizon = ds["horizon"].where(np.isfinite(ds["horizon"]))
    if not horizon.notnull().any():
        return
    method, tolerance, length = _cell(horizon, -horizon)
    forced = "forcing_period" in ds.variables
    unit, units = (float(ds["forcing_period"]), "periods") if forced else (1.0, "units of time")
    yield (
        f"a single trajectory can be trusted to 1e-6 for {length / unit:.3g} {units} at most "
        f"({method} at {tolerance:g}); beyond that only averages mean something"
    )


def duration(seconds: float) -> str:
    """A time for people: ``38 us``, ``1.2 ms``."""
    for factor, unit in ((1e6, "us"), (1e3, "ms")):
        if (shown := seconds * factor) < 999.5:
            return f"{shown:.2g} {unit}" if shown < 100 else f"{shown:.0f} {unit}"
    return f"{seconds:.2g} s"
