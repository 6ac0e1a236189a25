"""The table of regimes: what each case does at both readings of the damping, beside what the paper says."""

import csv
import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr

from chaosdrill.dataset.outcomes import flag_names
from chaosdrill.plots.labels import shorten, uncertain

CLAIMS = {"period1": "period 1", "period2": "period 2", "period4": "period 4", "chaos": "chaos"}
RATES = ("progression_rate", "events_per_period", "impacts_per_period")


@dataclass(frozen=True)
class Regime:
    """What one case does at one reading of the damping.

    Parameters
    ----------
    eta, xi : float
        Frequency ratio and damping ratio.
    claim, reading, found : str
        The paper's word, ``as reproduced`` or ``as printed``, and what the run shows.
    multipliers : ndarray, shape (3,), complex
        Multipliers of the cycle; NaN in chaos.
    exponents, errors : ndarray, shape (3,)
        Lyapunov exponents per unit of time, and their standard errors.
    rates : dict of str to float
        The means named in ``RATES``; exact over a cycle, averaged over the run in chaos.
    """

    eta: float
    xi: float
    claim: str
    reading: str
    found: str
    multipliers: np.ndarray
    exponents: np.ndarray
    errors: np.ndarray
    rates: dict[str, float]

    def markdown(self) -> list[str]:
        """Return the cells of the printed table."""
        multipliers = [
            shorten(number.real) + (f" ± {shorten(number.imag)}i" if number.imag else "")
            for number in self.multipliers
            if np.isfinite(number) and number.imag >= 0
        ]
        exponents = [uncertain(value, error) for value, error in zip(self.exponents, self.errors, strict=True)]
        rates = [f"{value:.10g}" for value in self.rates.values()]
        verdict = "yes" if self.found == self.claim else "no"
        head = [f"{self.eta:g}", self.claim, f"{self.xi:g} {self.reading}", self.found, verdict]
        return [*head, ", ".join(multipliers), ", ".join(exponents), *rates]

    def record(self) -> dict[str, object]:
        """Return the row of the CSV file, in full precision."""
        row: dict[str, object] = {"eta": self.eta, "xi": self.xi, "paper": self.claim, "found": self.found}
        for i, number in enumerate(self.multipliers, 1):
            row |= {f"multiplier{i}_real": number.real, f"multiplier{i}_imag": number.imag}
        for i, (value, error) in enumerate(zip(self.exponents, self.errors, strict=True), 1):
            row |= {f"exponent{i}": value, f"error{i}": error}
        return row | self.rates


def write_table(out: Path, cases: Iterable[str], readings: Mapping[str, str]) -> str:
    """Write ``regimes.csv`` and ``regimes.md`` from the archives in ``out``; return the Markdown."""
    regimes = [
        read(out / f"{prefix}{case}.nc", case, reading) for case in cases for prefix, reading in readings.items()
    ]
    with (out / "regimes.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, regimes[0].record())
        writer.writeheader()
        writer.writerows(regime.record() for regime in regimes)
    head = ["eta", "paper", "xi", "found", "agrees", "multipliers", "Lyapunov exponents"]
    head += [name.replace("_", " ") for name in RATES]
    lines = [head, ["---"] * len(head), *(regime.markdown() for regime in regimes)]
    table = "".join("| " + " | ".join(cells) + " |\n" for cells in lines)
    (out / "regimes.md").write_text(table, encoding="utf-8")
    return table


def read(archive: Path, case: str, reading: str) -> Regime:
    """Return what the archive of one case shows."""
    with xr.open_datatree(archive) as tree:
        section, spectrum = (tree[group].to_dataset().load() for group in ("section", "spectrum"))
    parameters = json.loads(section.attrs["parameters"])
    period = int(section["period"])
    outcome = flag_names(spectrum["outcome"])[int(spectrum["outcome"])]
    means = section if period else spectrum
    return Regime(
        eta=parameters["eta"],
        xi=parameters["xi"],
        claim=CLAIMS[case],
        reading=reading,
        found=f"period {period}" if period else outcome.replace("chaotic", "chaos"),
        multipliers=section["multiplier_real"].values + 1j * section["multiplier_imag"].values,
        exponents=spectrum["lyapunov_exponent"].values,
        errors=spectrum["lyapunov_error"].values,
        rates={name: float(means[name]) for name in RATES},
    )
