"""Contents of a dataset for pictures: states, swept parameters and their limits, and which datasets belong together."""

import json
from collections.abc import Sequence
from typing import Any

import numpy as np

from chaosdrill.dataset.label import axes_of
from chaosdrill.dataset.schema import ORDER
from chaosdrill.errors import SettingsError
from chaosdrill.names import brief
from chaosdrill.plots._types import Dataset, States, Variable


class OtherCountError(SettingsError):
    """The number of requested states differs from that of the picture."""


def check_names(wanted: Sequence[str], names: Sequence[str]) -> None:
    """Raise a `SettingsError` if there is no state of a name."""
    if unknown := next((name for name in wanted if name not in names), None):
        several = tuple(part for part in unknown.replace(",", " ").split() if part in names)
        way = f"; write state={several!r} for several, in a shell --state for each" if len(several) > 1 else ""
        raise SettingsError(f"state names {unknown!r:.60}; states are {', '.join(names)}{way}")


def places_of(dataset: Dataset, state: States, count: int) -> tuple[int, ...]:
    """Return the indices of the states requested for a picture.

    ``state``: names of states; default: the first ones. ``count``: how many the picture shows.

    Raises `SettingsError` if no state has a name, or the number of names differs (an `OtherCountError`).
    """
    names = [str(name) for name in dataset["state"].values]
    wanted = names[:count] if state is None else [state] if isinstance(state, str) else list(state)
    check_names(wanted, names)
    if len(wanted) != min(count, len(names)):
        example = f"state={tuple(names[:count])!r}" if count > 1 else f"state={names[0]!r}"
        raise OtherCountError(f"state is {state!r:.60}, but this picture shows {count}; give {example}")
    return tuple(names.index(name) for name in wanted)


def swept(dataset: Dataset) -> tuple[str, ...]:
    """Return the names of the swept parameters of an analysis, in its own order."""
    return tuple(settings(dataset).get("sweep") or ())


def limits(dataset: Dataset) -> dict[str, tuple[float, float]]:
    """Return the smallest and the largest requested value of each parameter of an analysis."""
    sweep = settings(dataset).get("sweep") or {}
    return {name: (float(min(values)), float(max(values))) for name, values in sweep.items()}


def fits(dataset: Dataset, other: Dataset) -> bool:
    """Return whether two datasets show the same system, at the same other parameters, over the same parameters.

    If both hold sections, these must be the same.
    """
    names = set(swept(dataset))
    with_points = (ds for ds in (dataset, other) if {"section", "orbit_section"} & ds.variables.keys())
    places = {settings(ds).get("at") or "strobe" for ds in with_points}
    return names == set(swept(other)) and _fixed(dataset, names) == _fixed(other, names) and len(places) < 2


def _fixed(dataset: Dataset, apart: set[str]) -> tuple[Any, ...]:
    """Everything that has to agree: the system, the names of its states, and all parameters except those swept."""
    parameters = json.loads(str(dataset.attrs.get("parameters", "{}")))
    rest = {name: value for name, value in parameters.items() if name not in apart}
    states = [str(name) for name in dataset["state"].values]
    return dataset.attrs.get("system"), states, rest


def settings(dataset: Dataset) -> dict[str, Any]:
    """Return the arguments of the analysis; SettingsError if somebody altered them beyond reading."""
    text = str(dataset.attrs.get("settings", "{}"))
    try:
        found: dict[str, Any] | None = json.loads(text)
    except (ValueError, RecursionError):
        found = None
    if not isinstance(found, dict):
        raise SettingsError(f"the attribute settings is {brief(text)}; it must be a JSON object, as the analysis wrote")
    return found


SINGLE = ("trajectory", "poincare-section", "lyapunov-spectrum")
"""Kinds of single runs, or of several joined runs."""
MEASURES = {
    "poincare-section": "section",
    **dict.fromkeys(("lyapunov-spectrum", "covariant-vectors", "finite-time-exponents"), "lyapunov_exponent"),
    "zero-one-test": "k",
    "regularity": "digits",
    "dimensions": "dimension",
}
"""What a run of a kind measures."""
_IN_SI = ("trajectory", "poincare-section", "bifurcation-diagram", "periodic-orbit", "continuation", "equilibria")
"""Kinds whose states and times are shown in SI units; charts and basins show only their results so."""
_TIMES = ("time", "event_time", "path_time", "forcing_period", "period_time")


def in_order(dataset: Dataset) -> Dataset:
    """Return a dataset with the dimensions of its variables in the order of an analysis; those of others lead."""
    try:
        first = [name for name in axes_of(settings(dataset)) if name in dataset.dims]
    except SettingsError:
        first = []
    rest = [name for name in ORDER if name in dataset.dims and name not in first]
    return dataset.transpose(*first, ..., *rest)


def shown_in_si(dataset: Dataset) -> Dataset:
    """Return a dataset in order, whose results are in SI units if its scene was in SI units.

    Every ``NAME_si`` replaces ``NAME``. Times without one, and states, are multiplied by their unit; the units of the
    states are in ``state_units``.
    """
    dataset = in_order(dataset)
    known = {str(name).removesuffix("_si"): name for name in dataset.variables if str(name).endswith("_si")}
    given = {name: dataset[own].variable for name, own in known.items() if name in dataset.variables}
    if not known:
        return dataset
    shown = dict(given)
    kind = dataset.attrs.get("kind")
    if kind in _IN_SI:
        second = _second(dataset, given)
        for name in _TIMES:
            if second and name in dataset.variables and name not in given:
                shown[name] = _scaled(dataset[name].variable, second, units="s")
        if "state_scale" in known:
            scale = dataset["state_scale_si"].variable
            for own_name, variable in dataset.variables.items():
                if "state" in variable.dims and variable.dtype.kind == "f" and own_name != "state_scale_si":
                    shown[str(own_name)] = _scaled(variable, scale)
            shown["state_units"] = dataset["state_units_si"].variable
    coords = [name for name in shown if name in dataset.coords or name == "state_units"]
    # what has no dimensionless counterpart is kept
    dropped = [own for name, own in known.items() if name in given or name in ("state_scale", "state_units")]
    return dataset.drop_vars(dropped).assign(shown).set_coords(coords)


def _second(dataset: Dataset, given: dict[str, Variable]) -> float:
    """A unit of time in seconds; 0 if the dataset does not give it."""
    for name in _TIMES:
        if name in given:
            dimensionless, seconds = np.ravel(dataset[name].values), np.ravel(given[name].values)
            told = np.isfinite(seconds) & (np.abs(dimensionless) > 0)
            if told.any():
                place = int(np.abs(np.where(told, dimensionless, 0.0)).argmax())
                return float(seconds[place] / dimensionless[place])
    return 0.0


def _scaled(variable: Variable, scale: Any, **attrs: str) -> Variable:
    scaled = (variable * scale).transpose(*variable.dims)
    scaled.attrs = {**variable.attrs, **attrs}
    return scaled
