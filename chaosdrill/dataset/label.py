"""Attributes, checks and provenance of datasets, from one table of variables."""

import json
import re
from collections.abc import Iterable, Mapping
from copy import copy
from dataclasses import replace
from functools import lru_cache
from importlib import import_module
from numbers import Real
from typing import Any, NamedTuple

from chaosdrill.annotations import Dataset
from chaosdrill.dataset.outcomes import holds_codes
from chaosdrill.dataset.provenance import provenance
from chaosdrill.dataset.schema import ORBIT, PENETRATION, QUADRATURE, RUN, SCHEMA, STARTS_OF_RUNS, SWEEP, Variable
from chaosdrill.errors import ChaosdrillError

NUMBERS = ("format_version", "tolerance", "random_seed", "wall_time_s")
"""Attributes of a labelled dataset that are not text."""


def label(ds: Dataset, kind: str, *, system: Any, settings: Mapping[str, Any]) -> Dataset:
    """Check a raw dataset against the table of its kind and add its attributes and provenance.

    ``settings``: arguments of the analysis; ``settings["sweep"]`` names the swept parameters, ``settings["grid"]`` the
    states of a grid of initial states, if any. The values stay; coordinates never get a fill value (CF forbids it).

    Raises `ChaosdrillError` if a variable is undeclared or missing, has other dimensions, or has values that do not
    fit.
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

    Where initial states are listed a grid is a part of the list. An analysis that can be swept measures its grid.
    """
    grid = settings.get("grid") if settings.get("initial") is None else None
    return tuple(str(name) for name in settings.get("sweep", grid) or ())


def describe(ds: Dataset, kind: str, *, system: Any, sweep: Iterable[str] = ()) -> Dataset:
    """Check the variables of ``ds`` and give each its dtype, attributes and encoding; ``ds.attrs`` stay as they are.

    The long names of the states are added to their names.
    """
    from chaosdrill.dataset.build import dataset, variable

    given = {str(name): one for name, one in ds.variables.items()}
    if "state" in ds.coords:
        names = map(str, given["state"].values)
        given["state_long_name"] = variable("state", [str(system.labels.get(name, name)) for name in names])
    leading = tuple(str(dim) for dim in ds.dims if dim in ("orbit", "run"))
    declared = _told(kind, _Words.of(system), tuple(sweep), leading)
    if unknown := sorted(given.keys() - declared.keys()):
        raise ChaosdrillError(f"{kind}: the table of variables does not declare {', '.join(unknown)}")
    if missing := sorted(name for name, (one, _) in declared.items() if one.required and name not in given):
        raise ChaosdrillError(f"{kind}: the dataset lacks {', '.join(missing)}")

    columns: dict[str, Any] = {}
    indexes = {str(name): index for name, index in ds.xindexes.items()}
    for name, raw in sorted(given.items()):
        one, attributes = declared[name]
        if raw.dims != one.dims:
            raise ChaosdrillError(f"{kind}: {name} has dimensions {raw.dims}; expected {one.dims}")
        values = _cast(raw.values, one, kind)
        if values.dtype != raw.dtype:
            indexes.pop(name, None)
        encoding: dict[str, Any] = {"_FillValue": None} if one.coordinate else {}
        encoding |= {"dtype": values.dtype} if one.flags else {}
        columns[name] = variable(one.dims, values, copy(attributes), encoding)
    coordinates = {*map(str, ds.coords), *(name for name in given if declared[name][0].coordinate)}
    found = dataset({name: columns[name] for name in given}, coordinates, ds.attrs, indexes=indexes)
    found.encoding = dict(ds.encoding)
    return found


def described_again(ds: Dataset, kind: str, *, system: Any) -> Dataset | None:
    """A labelled dataset read from a file, with the attributes of its variables from the table.

    Returns: None if its variables are not those of the table, if a code is not one of theirs, or if an attribute is of
    another type than `label` gives it.
    """
    import numpy as np

    texts = {name: value for name, value in ds.attrs.items() if name not in NUMBERS}
    numbers = [ds.attrs[name] for name in NUMBERS if name in ds.attrs]
    if not all(isinstance(value, str) for value in texts.values()) or not all(isinstance(n, Real) for n in numbers):
        return None
    if texts.get("kind") != kind:
        return None
    try:
        settings = json.loads(texts["settings"])
        found = describe(ds, kind, system=system, sweep=axes_of(settings))
    except (ChaosdrillError, AttributeError, KeyError, TypeError, ValueError, RecursionError):
        return None
    for name, one in found.variables.items():
        declared = SCHEMA[kind].get(str(name))
        if declared and declared.flags:
            known = [*one.attrs.get("flag_values", ()), *([-1] if declared.lacking else ())]
            if not np.isin(one, known).all():
                return None
    return found


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


class _Words(NamedTuple):
    """What of a system is in the declarations and attributes of variables."""

    quadratures: tuple[str, ...]
    labels: tuple[tuple[str, str], ...]
    modes: tuple[str, ...]
    transitions: tuple[str, ...]
    discrete: bool

    @classmethod
    def of(cls, system: Any) -> "_Words":
        """Those of a system."""
        return cls(
            tuple(map(str, system.quadratures)),
            tuple((str(name), str(label)) for name, label in system.labels.items()),
            tuple(map(str, system.modes)),
            tuple(str(transition.name) for transition in system.transitions),
            bool(getattr(system, "discrete", False)),
        )


@lru_cache(maxsize=64)
def _told(
    kind: str, words: _Words, sweep: tuple[str, ...], leading: tuple[str, ...]
) -> dict[str, tuple[Variable, dict[str, Any]]]:
    """The table of a kind, its placeholders filled in, with the attributes of each variable; the same for all calls.

    Of the dimensions that a dataset has ``leading`` holds those at least of which there may be none.
    """
    if kind not in SCHEMA:
        raise ChaosdrillError(f"no table of variables for kind {kind!r}; there is one for {', '.join(SCHEMA)}")
    quadratures, labels = words.quadratures, dict(words.labels)
    names = {SWEEP: sweep, QUADRATURE: quadratures}
    others = tuple(name for name in quadratures if name != PENETRATION)
    orbit, run = (tuple(dim for dim in leading if dim == name) for name in ("orbit", "run"))
    several = {SWEEP: sweep, ORBIT: orbit, RUN: run, STARTS_OF_RUNS: run or sweep}
    declared: dict[str, tuple[Variable, dict[str, Any]]] = {}
    for variable in SCHEMA[kind].values():
        within = others if QUADRATURE in variable.name else (variable.name,)
        for one in names.get(variable.name, within):
            name = one if variable.name in names else variable.name.replace(QUADRATURE, one)
            own = (name,) if variable.name == SWEEP and variable.coordinate else variable.dims
            dims = tuple(part for dim in own for part in several.get(dim, (dim,)))
            named = labels.get(one, one)
            long_name = named if variable.name in names else variable.long_name.replace(QUADRATURE, named)
            filled = replace(variable, name=name, dims=dims, long_name=long_name)
            declared[name] = filled, _attributes(filled, words)
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


def _attributes(variable: Variable, words: _Words) -> dict[str, Any]:
    import numpy as np

    told = _words_of_map if words.discrete else str
    attributes: dict[str, Any] = {
        "long_name": told(variable.long_name),
        "units": variable.units,
        "comment": told(variable.doc),
        "coverage_content_type": variable.content,
    }
    if variable.sample:
        attributes["sample_dimension"] = variable.sample
    if variable.flags:
        named = {"mode": words.modes, "transition": words.transitions, "truth": ("no", "yes")}
        code = variable.flags
        meanings = list(named[code]) if isinstance(code, str) else [one.meaning for one in code]
        # CF separates the meanings by blanks and allows only these characters in one. A system without transitions
        # has no meanings at all, and NetCDF holds no empty array.
        if meanings:
            attributes["flag_values"] = np.arange(len(meanings), dtype=variable.dtype)
            attributes["flag_values"].flags.writeable = False  # many datasets have the same
            attributes["flag_meanings"] = " ".join(re.sub(r"[^\w.+@-]", "_", str(meaning)) for meaning in meanings)
    return attributes
