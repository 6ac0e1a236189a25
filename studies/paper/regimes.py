"""The table of regimes: what each case does at both readings of the damping, beside what the paper says."""

import csv
import json
from collections.abc import Iterable, Mapping
from pathlib import Path

import numpy as np
import xarray as xr

from chaosdrill.plot.style import flag_names, shorten, uncertain

CLAIMS = {"period1": "period 1", "period2": "period 2", "period4": "period 4", "chaos": "chaos"}
COLUMNS = (
    "eta", "paper", "reading", "xi", "found", "multipliers", "exponents", "progression rate", "events per period",
    "impacts per period",
)  # fmt: skip


def write_table(out: Path, cases: Iterable[str], readings: Mapping[str, str]) -> str:
    """Write ``regimes.csv`` (full precision) and ``regimes.md`` from the archives in ``out``; return the Markdown."""
    rows = [_row(out / f"{prefix}{case}.nc", case, reading) for case in cases for prefix, reading in readings.items()]
    with (out / "regimes.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(
            [
                *COLUMNS[:5],
                *(f"{part} {i}" for part in ("multiplier re", "multiplier im", "exponent", "error") for i in (1, 2, 3)),
                *COLUMNS[7:],
            ]
        )
        writer.writerows([*row[:5], *row[5].ravel(), *row[6].ravel(), *row[7:]] for row in rows)
    lines = ["| " + " | ".join(COLUMNS) + " |", "|" + " --- |" * len(COLUMNS)]
    lines += [
        "| "
        + " | ".join(
            [
                *row[:2],
                row[2],
                *row[3:5],
                _multipliers(row[5]),
                _exponents(row[6]),
                *(f"{value:.10g}" for value in row[7:]),
            ]
        )
        + " |"
        for row in rows
    ]
    table = "\n".join(lines) + "\n"
    (out / "regimes.md").write_text(table, encoding="utf-8")
    return table


def _row(archive: Path, case: str, reading: str) -> list:
    with xr.open_datatree(archive) as tree:
        section, spectrum = (tree[group].to_dataset().load() for group in ("section", "spectrum"))
    parameters = json.loads(section.attrs["parameters"])
    period = int(section["period"])
    found = f"period {period}" if period else flag_names(spectrum["outcome"])[int(spectrum["outcome"])]
    multipliers = np.stack([section["multiplier_real"], section["multiplier_imag"]])
    exponents = np.stack([spectrum["lyapunov_exponent"], spectrum["lyapunov_error"]])
    means = (section if period else spectrum)[["progression_rate", "events_per_period", "impacts_per_period"]]
    return [
        f"{parameters['eta']:g}",
        CLAIMS[case],
        reading,
        f"{parameters['xi']:g}",
        found,
        multipliers,
        exponents,
        *(float(value) for value in means.values()),
    ]


def _multipliers(pairs: np.ndarray) -> str:
    texts = [
        shorten(re) if im == 0 else f"{shorten(re)} ± {shorten(im)}i"
        for re, im in pairs.T
        if np.isfinite(re) and im >= 0
    ]
    return ", ".join(texts)


def _exponents(pairs: np.ndarray) -> str:
    return ", ".join(uncertain(value, error) for value, error in pairs.T)
