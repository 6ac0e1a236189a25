"""What the study shares: claims with the figures behind them, and reading archives."""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr

from chaosdrill.dataset.outcomes import flag_names


@dataclass(frozen=True)
class Claim:
    """One sentence of the page, the figure that was found for it, and whether it bears the sentence out.

    Parameters
    ----------
    text : str
        What is claimed.
    found : str
        The figure.
    holds : bool
        Whether the claim is true.
    """

    text: str
    found: str
    holds: bool


def table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """Return a Markdown table."""
    names = list(head)
    return "".join("| " + " | ".join(line) + " |\n" for line in [names, ["---"] * len(names), *rows])


def read(path: Path, group: str) -> xr.Dataset:
    """Return one group of an archive, in memory."""
    with xr.open_datatree(path) as tree:
        return tree[group].to_dataset().load()


def ended(dataset: xr.Dataset, *names: str) -> np.ndarray:
    """Return where the outcome has one of these names."""
    codes = [code for code, name in flag_names(dataset["outcome"]).items() if name in names]
    return np.isin(dataset["outcome"].values, codes)
