"""What a search for orbits and a continuation have found, as lines for people."""

import json
from typing import TYPE_CHECKING

from chaosdrill.dataset.branches import Special

if TYPE_CHECKING:
    import xarray as xr

MOST_LINES = 60


def orbit_lines(dataset: "xr.Dataset") -> list[str]:
    """One line an orbit of a search; of a continuation its branches, their special points and the cascade."""
    lines: list[str] = []
    if "orbit" in dataset.sizes:
        lines = [_orbit(dataset.isel(orbit=i)) for i in range(dataset.sizes["orbit"])]
    elif "branch_number" in dataset.sizes:
        lines = [line for number in dataset["branch_number"].values for line in _branch(dataset, int(number))]
        lines += _cascade(dataset)
    more = len(lines) - MOST_LINES
    return lines if more <= 0 else [*lines[:MOST_LINES], f"and {more} more lines; see the archive"]


def _orbit(orbit: "xr.Dataset") -> str:
    multipliers = ", ".join(
        f"{real:.6g}{imag:+.6g}i" if imag else f"{real:.6g}"
        for real, imag in zip(orbit["multiplier_real"].values, orbit["multiplier_imag"].values, strict=True)
    )
    stable = "stable" if orbit["stable"] else "unstable"
    state = ", ".join(f"{value:.10g}" for value in orbit["orbit_state"].values)
    forced = "forcing_period" in orbit
    length = f"period {int(orbit['period'])}" if forced else f"duration {float(orbit['period_time']):.10g}"
    return f"orbit {int(orbit['orbit'])}: {length}, {stable}, ({state}), multipliers {multipliers}"


def _branch(dataset: "xr.Dataset", number: int) -> list[str]:
    """A branch from its start to its end, with its special points between."""
    own = dataset["branch"].values == number
    parameters = list(json.loads(dataset.attrs["settings"])["sweep"])
    first = dataset.isel(branch_number=number)
    lines = [
        f"branch {number}: period {int(first['branch_period'])}, {int(own.sum())} points, "
        f"{int(dataset['stable'].values[own].sum())} of them stable; {first['branch_start'].item()}"
    ]
    for i, point in enumerate(dataset["special_index"].values):
        if dataset["branch"].values[point] == number:
            there = [dataset[name].values[i] for name in ("special_value", "special_value_2")[: len(parameters)]]
            place = ", ".join(f"{name} = {value:.12g}" for name, value in zip(parameters, there, strict=True))
            error = f"(error {dataset['special_error'].values[i]:.1g})"
            kind = Special(int(dataset["special_kind"].values[i]))
            text = str(dataset["special_text"].values[i])
            lines.append(
                f"  {kind.meaning.replace('_', ' ')} at {place} {error}" + (f": {text}" if text != kind.words else "")
            )
    return [*lines, f"  end: {first['branch_end_text'].item()}"]


def _cascade(dataset: "xr.Dataset") -> list[str]:
    if "doubling_value" not in dataset:
        return []
    rows = zip(*(dataset[n].values for n in ("doubling_period", "doubling_value", "feigenbaum_ratio")), strict=True)
    lines = [
        f"period {period} doubles at {value:.12g}" + (f", ratio {ratio:.6g}" if ratio == ratio else "")
        for period, value, ratio in rows
    ]
    limit, error = float(dataset["accumulation"]), float(dataset["accumulation_error"])
    return [*lines, f"doublings accumulate at {limit:.12g} (error {error:.1g})"] if limit == limit else lines
