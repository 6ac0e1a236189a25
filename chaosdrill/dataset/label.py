"""Attributes, checks and provenance of datasets, from one table of variables."""

import json
import re
from collections.abc import Iterable, Mapping
from dataclasses import replace
from importlib import import_module
from numbers import Real
from typing import Any

from chaosdrill.annotations import Dataset
from chaosdrill.dataset.branches import AttractorEnd, BranchEnd, Criticality, Onset, Special
from chaosdrill.dataset.codes import Code
from chaosdrill.dataset.curves import CurveBreak, CurveEnd
from chaosdrill.dataset.equilibria import Admissibility, Beyond, EquilibriumType, SpecialEquilibrium
from chaosdrill.dataset.outcomes import Outcome, holds_codes
from chaosdrill.dataset.provenance import provenance
from chaosdrill.dataset.schema import ORBIT, PENETRATION, QUADRATURE, RUN, SCHEMA, STARTS_OF_RUNS, SWEEP, Variable
from chaosdrill.errors import ChaosdrillError

NUMBERS = ("format_version", "tolerance", "random_seed", "wall_time_s")
"""Attributes of a labelled dataset that are not text."""

_CODES: dict[str, type[Code]] = {
    "outcome": Outcome,
    "special": Special,
    "criticality": Criticality,
    "onset": Onset,
    "branch_end": BranchEnd,
    "attractor_end": AttractorEnd,
    "equilibrium": EquilibriumType,
    "admissibility": Admissibility,
    "special_equilibrium": SpecialEquilibrium,
    "beyond": Beyond,
    "curve_end": CurveEnd,
    "curve_break": CurveBreak,
}
"""By the ``flags`` of variables."""


def label(ds: Dataset, kind: str, *, system: Any, settings: Mapping[str, Any]) -> Dataset:
    """Check a raw dataset against the table and add its attributes and provenance.

    Parameters
    ----------
    ds : xarray.Dataset
        Raw result of an analysis.
    kind : str
        Kind of the analysis, a key of ``SCHEMA``.
    system : HybridSystem
        System that was simulated.
    settings : mapping
        Arguments of the analysis; ``settings["sweep"]`` names the swept parameters, ``settings["grid"]`` the
        states of a grid of initial states, if any.

    Returns
    -------
    xarray.Dataset
        A new dataset with the same values; coordinates never get a fill value (CF forbids it).

    Raises
    ------
    ChaosdrillError
        If a variable is undeclared or missing, has other dimensions, or has values that do not fit.
    """
    import_module("chaosdrill.dataset.words")
    ds = describe(ds, kind, system=system, sweep=axes_of(settings))
    ds.attrs = provenance(
        f"{kind} of {system.name}",
        action=kind,
        kind=kind,
        variables=[str(name) for name in ds.variables],
        system=system,
        settings=settings,
    )
    return ds


def axes_of(settings: Mapping[str, Any]) -> tuple[str, ...]:
    """Names of the swept parameters, or of the states of a grid, by the settings of an analysis; none by default.

    Where initial states are listed a grid is a part of the list.
    """
    grid = settings.get("grid") if settings.get("initial") is None else None
    return tuple(str(name) for name in settings.get("sweep") or grid or ())


def describe(ds: Dataset, kind: str, *, system: Any, sweep: Iterable[str] = ()) -> Dataset:
    """Check the variables of ``ds`` and give each its dtype, attributes and encoding; ``ds.attrs`` stay as they are.

    The long names of the states are added to their names.
    """
    from chaosdrill.dataset.build import dataset, variable

    if "state" in ds.coords:
        names = [str(name) for name in ds["state"].values]
        ds = ds.assign_coords(state_long_name=variable("state", [str(system.labels.get(name, name)) for name in names]))
    declared = declarations(kind, system=system, sweep=tuple(sweep), leading=tuple(str(dim) for dim in ds.dims))
    present = {str(name) for name in ds.variables}
    if unknown := sorted(present - declared.keys()):
        raise ChaosdrillError(f"{kind}: the table of variables does not declare {', '.join(unknown)}")
    if missing := sorted(name for name, variable in declared.items() if variable.required and name not in present):
        raise ChaosdrillError(f"{kind}: the dataset lacks {', '.join(missing)}")

    columns: dict[str, Any] = {}
    for name in sorted(present):
        one, raw = declared[name], ds.variables[name]
        if raw.dims != one.dims:
            raise ChaosdrillError(f"{kind}: {name} has dimensions {raw.dims}; expected {one.dims}")
        values = _cast(raw.values, one, kind)
        encoding: dict[str, Any] = {"_FillValue": None} if one.coordinate else {}
        encoding |= {"dtype": values.dtype} if one.flags else {}
        columns[name] = variable(one.dims, values, _attributes(one, system), encoding)
    coordinates = {*map(str, ds.coords), *(name for name in present if declared[name].coordinate)}
    found = dataset({str(name): columns[str(name)] for name in ds.variables}, coordinates, ds.attrs)
    found.encoding = dict(ds.encoding)
    return found


def described_again(ds: Dataset, kind: str, *, system: Any) -> Dataset | None:
    """A labelled dataset read from a file, with the attributes of its variables from the table.

    Returns: None if its variables are not those of the table, or an attribute is of another type than `label` gives it.
    """
    texts = {name: value for name, value in ds.attrs.items() if name not in NUMBERS}
    numbers = [ds.attrs[name] for name in NUMBERS if name in ds.attrs]
    if not all(isinstance(value, str) for value in texts.values()) or not all(isinstance(n, Real) for n in numbers):
        return None
    if texts.get("kind") != kind:
        return None
    try:
        settings = json.loads(texts["settings"])
        return describe(ds, kind, system=system, sweep=axes_of(settings))
    except (ChaosdrillError, AttributeError, KeyError, TypeError, ValueError, RecursionError):
        return None


def without_lost_codes(ds: Dataset) -> Dataset:
    """The same, where variables computed from codes are no longer labelled as codes."""
    declared = SCHEMA.get(str(ds.attrs.get("kind")), {})
    lost = [
        name
        for name, variable in ds.variables.items()
        if name in declared and declared[str(name)].flags and not holds_codes(variable)
    ]
    for name in lost:
        kept = {key: value for key, value in ds[name].attrs.items() if not key.startswith("flag_")}
        ds = ds.assign({name: (ds[name].dims, ds[name].values, kept)})
    return ds


def declarations(
    kind: str, *, system: Any, sweep: tuple[str, ...] = (), leading: tuple[str, ...] = ()
) -> dict[str, Variable]:
    """The table of one kind with its placeholders filled in for a system and its swept parameters.

    Of the dimensions that a dataset has ``leading`` holds those at least of which there may be none.
    """
    if kind not in SCHEMA:
        raise ChaosdrillError(f"no table of variables for kind {kind!r}; there is one for {', '.join(SCHEMA)}")
    quadratures = tuple(str(name) for name in system.quadratures)
    names = {SWEEP: sweep, QUADRATURE: quadratures}
    others = tuple(name for name in quadratures if name != PENETRATION)
    orbit, run = (tuple(dim for dim in leading if dim == name) for name in ("orbit", "run"))
    several = {SWEEP: sweep, ORBIT: orbit, RUN: run, STARTS_OF_RUNS: run or sweep}
    declared: dict[str, Variable] = {}
    for variable in SCHEMA[kind].values():
        within = others if QUADRATURE in variable.name else (variable.name,)
        for one in names.get(variable.name, within):
            name = one if variable.name in names else variable.name.replace(QUADRATURE, one)
            own = (name,) if variable.name == SWEEP and variable.coordinate else variable.dims
            dims = tuple(part for dim in own for part in several.get(dim, (dim,)))
            named = str(system.labels.get(one, one))
            long_name = named if variable.name in names else variable.long_name.replace(QUADRATURE, named)
            declared[name] = replace(variable, name=name, dims=dims, long_name=long_name)
    return declared


def _cast(values: Any, variable: Variable, kind: str) -> Any:
    """The values in the declared dtype; refused if that would change them."""
    import numpy as np

    values = np.asarray(values)
    if variable.dtype == "str":
        if values.dtype.kind not in "UOT":
            raise ChaosdrillError(f"{kind}: {variable.name} holds {values.dtype}; expected text")
        return values
    if values.dtype == np.dtype(variable.dtype):
        return values
    if values.dtype.kind not in "iufb":
        raise ChaosdrillError(f"{kind}: {variable.name} holds {values.dtype}; expected {np.dtype(variable.dtype)}")
    with np.errstate(invalid="ignore"):
        cast = values.astype(variable.dtype)
    if not np.array_equal(cast, values, equal_nan=values.dtype.kind == "f"):
        raise ChaosdrillError(f"{kind}: {variable.name} has values that do not fit into {np.dtype(variable.dtype)}")
    return cast


_OF_MAPS = (
    ("unit of model time", "iterate"),
    ("units of model time", "iterates"),
    ("period of the forcing", "one iterate"),
    ("Period of the forcing", "One iterate"),
    ("forcing period", "iterate"),
    ("model time", "iterate"),
)
"""What the words for time and periods are where a period is an iterate."""


def _words_of_map(text: str) -> str:
    for words, own in _OF_MAPS:
        text = text.replace(words, own)
    return text


def _attributes(variable: Variable, system: Any) -> dict[str, Any]:
    import numpy as np

    words = _words_of_map if getattr(system, "discrete", False) else str
    attributes: dict[str, Any] = {
        "long_name": words(variable.long_name),
        "units": variable.units,
        "comment": words(variable.doc),
        "coverage_content_type": variable.content,
    }
    if variable.sample:
        attributes["sample_dimension"] = variable.sample
    if variable.flags:
        names = {
            "mode": system.modes,
            "transition": [transition.name for transition in system.transitions],
            "truth": ["no", "yes"],
        }
        code = _CODES.get(variable.flags)
        meanings = [one.meaning for one in code] if code else list(names[variable.flags])
        # CF separates the meanings by blanks and allows only these characters in one. A system without transitions
        # has no meanings at all, and NetCDF holds no empty array.
        if meanings:
            attributes["flag_values"] = np.arange(len(meanings), dtype=variable.dtype)
            attributes["flag_meanings"] = " ".join(re.sub(r"[^\w.+@-]", "_", str(meaning)) for meaning in meanings)
    return attributes
