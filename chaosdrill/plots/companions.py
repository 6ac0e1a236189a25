"""Datasets that belong in one picture: the same system over the same parameters."""

import json
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import xarray as xr


def swept(dataset: "xr.Dataset") -> tuple[str, ...]:
    """Return the names of the parameters that an analysis ran through, in its own order."""
    return tuple(settings(dataset).get("sweep") or ())


def limits(dataset: "xr.Dataset") -> dict[str, tuple[float, float]]:
    """Return the least and the largest value of each parameter that an analysis was asked for."""
    sweep = settings(dataset).get("sweep") or {}
    return {name: (float(min(values)), float(max(values))) for name, values in sweep.items()}


def fits(dataset: "xr.Dataset", other: "xr.Dataset") -> bool:
    """Return whether two datasets show the same system, at the same other parameters, over the same parameters.

    Where both hold sections these must be the same; those of periodic orbits are at the forcing's phase zero, or at the
    start of the orbit.
    """
    names = set(swept(dataset))
    places = {_section_of(ds) for ds in (dataset, other)}
    return (
        bool(names)
        and names == set(swept(other))
        and _fixed(dataset, names) == _fixed(other, names)
        and len(places - {None}) < 2
    )


def _section_of(dataset: "xr.Dataset") -> str | None:
    """Where the points of a dataset are taken; None for one that holds none."""
    if "section" not in dataset.variables:
        return None
    given = settings(dataset)
    # the section by which orbits are counted is not the place at which they begin
    return "strobe" if "period" in given else given.get("at") or "strobe"


def _fixed(dataset: "xr.Dataset", apart: set[str]) -> tuple[Any, ...]:
    """All that has to agree: the system, the names of its states, the parameters but those swept."""
    parameters = json.loads(str(dataset.attrs.get("parameters", "{}")))
    rest = {name: value for name, value in parameters.items() if name not in apart}
    states = [str(name) for name in dataset["state"].values]
    return dataset.attrs.get("system"), states, rest


def settings(dataset: "xr.Dataset") -> dict[str, Any]:
    """Return the arguments of the analysis."""
    found: dict[str, Any] = json.loads(str(dataset.attrs.get("settings", "{}")))
    return found
