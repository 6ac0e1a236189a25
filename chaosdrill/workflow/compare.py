"""Compare two archives variable by variable: bit by bit, or within the errors of each variable.

Round-off differs between processors and libraries. Cycles, multipliers and other regular attractors nevertheless agree
within the error of the method; in chaos two runs diverge, and only averages agree, within their standard errors.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from chaosdrill.annotations import Dataset, DataTree, Variable
from chaosdrill.archive.digest import DIGESTS
from chaosdrill.archive.read import groups_of
from chaosdrill.dataset.outcomes import Outcome
from chaosdrill.dataset.references import mapping
from chaosdrill.dataset.schema import SCHEMA, table_of
from chaosdrill.workflow.tuning import TUNING

PASSING = frozenset({"history", "date_created", "wall_time_s", "versions", "platform", "recommendation", DIGESTS})
"""Attributes that a second run on another day or machine may change."""
DESCRIPTIVE = frozenset(
    {"Conventions", "format_version", "summary", "keywords", "processing_level", "source", "references"}
    | {"coverage_content_type", "long_name", "comment", "flag_values", "flag_meanings", "random_seed"}
    | {"definition", "definition_missing"}
)
"""Attributes in words of the version that wrote them."""
CLOCKED = "not compared: measured time"
LEADERS = {"time": "states", "iterate": "section", "event": "event_state_before"}
"""Dimensions along which a run is recorded, and the variable that shows where two runs diverge."""

_UNDECIDED = (Outcome.OK, Outcome.QUASIPERIODIC, Outcome.CHAOTIC, Outcome.UNDECIDED, Outcome.CONTRACTING)
_ORBITS = ("periodic-orbit", "continuation", "equilibria")


@dataclass(frozen=True)
class Difference:
    """The difference in one variable or attribute.

    Parameters
    ----------
    group : str
        Path of the group.
    variable : str
        Variable, or ``:attribute`` of the group, or ``variable:attribute``.
    what : str
        In words.
    differing : int
        Number of values that differ.
    total : int
        Number of values compared.
    max_abs : float
        Largest absolute difference; infinite between a number and NaN; NaN where there is nothing to subtract.
    """

    group: str
    variable: str
    what: str
    differing: int = 1
    total: int = 1
    max_abs: float = float("nan")


@dataclass(frozen=True)
class Check:
    """How one variable was compared.

    Parameters
    ----------
    group : str
        Path of the group.
    variable : str
        Its name.
    how : str
        In words: "bit for bit", "within 1e-08", "within 8 standard errors", ...
    agrees : bool
        Whether the two agree.
    """

    group: str
    variable: str
    how: str
    agrees: bool


def compare(first: DataTree, second: DataTree) -> list[Difference]:
    """All differences between two archives, except wall time, history, versions, platform and measured times.

    Numbers are compared bit for bit.

    ``first``, ``second``: the actual and the expected archive.

    Returns: empty if they are equal.
    """
    return examine(first, second)[0]


def examine(
    first: DataTree, second: DataTree, *, exact: bool = True, older: bool = False
) -> tuple[list[Difference], list[Check]]:
    """The differences between two archives, and how each variable was compared.

    ``first``, ``second``: the actual and the expected archive. ``exact``: whether to compare bit for bit; otherwise by
    the criteria for other machines and versions (`agreement`). ``older``: the first archive is of another version,
    whose descriptions in words may differ.
    """
    groups, others = groups_of(first), groups_of(second)
    found = [Difference(path, "", "group is missing") for path in others if path not in groups]
    checks: list[Check] = []
    passing = PASSING | DESCRIPTIVE if older else PASSING
    for path, group in groups.items():
        if path in others:
            found += _group(path, group, others[path], exact, passing, checks)
        else:
            found.append(Difference(path, "", "unexpected group"))
    return found, checks


def _group(
    path: str, first: Dataset, second: Dataset, exact: bool, passing: frozenset[str], checks: list[Check]
) -> list[Difference]:
    found = _attributes(path, "", first.attrs, second.attrs, passing)
    clocked = {v.name for v in SCHEMA.get(str(second.attrs.get("kind")), {}).values() if v.clocked}
    found += [Difference(path, str(name), "is missing") for name in second.variables if name not in first.variables]
    if not exact:
        first, second = _shared_events(first, second)
    for name in (str(name) for name in first.variables):
        if name not in second.variables:
            found.append(Difference(path, name, "does not belong here"))
            continue
        one, other = first.variables[name], second.variables[name]
        found += _attributes(path, name, one.attrs, other.attrs, passing)
        if one.dims != other.dims or one.shape != other.shape:
            what = f"is {dict(one.sizes)}; expected {dict(other.sizes)}"
            differences, how = [Difference(path, name, what, one.size, one.size)], "shape"
        elif name in clocked:
            differences, how = [], CLOCKED
        else:
            differences, how = _compared(path, name, first, second, exact)
        checks.append(Check(path, name, how, not differences))
        found += differences
    return found


def _shared_events(first: Dataset, second: Dataset) -> tuple[Dataset, Dataset]:
    """Both datasets cut to the shorter list of events, since runs that have diverged may differ in number."""
    both = first, second
    if second.attrs.get("kind") != "trajectory" or any("event" not in ds.dims for ds in both):
        return both
    events = [ds.sizes["event"] for ds in both]
    # the events of joined runs follow each other
    counts = [np.array([size]) for size in events]
    if "run" in second.dims:
        counts = [ds.get("event_count", ds["outcome"]).values for ds in both]
        fitting = all((own >= 0).all() and own.sum() == size for own, size in zip(counts, events, strict=True))
        if not fitting or counts[0].shape != counts[1].shape:
            return both
    shared = np.minimum(*counts)
    kept = [
        np.concatenate([np.arange(common) + begin for common, begin in zip(shared, np.cumsum(own) - own, strict=True)])
        for own in counts
    ]
    return first.isel(event=kept[0]), second.isel(event=kept[1])


def _attributes(
    path: str, name: str, first: dict[str, Any], second: dict[str, Any], passing: frozenset[str]
) -> list[Difference]:
    def same(one: Any, other: Any) -> bool:
        # NetCDF gives back a list of one entry as that entry, and a table in JSON is the same in any order
        tables = mapping(one), mapping(other)
        return np.array_equal(np.atleast_1d(one), np.atleast_1d(other)) or (tables[0] == tables[1] != {})

    return [
        Difference(path, f"{name}:{key}", "attribute differs")
        for key in sorted({*first, *second} - passing)
        if key not in first or key not in second or not same(first[key], second[key])
    ]


def _compared(path: str, name: str, first: Dataset, second: Dataset, exact: bool) -> tuple[list[Difference], str]:
    """The differences between one variable of both, and how it was compared."""
    one, other = first.variables[name].values, second.variables[name].values
    texts = [values.dtype.kind in "OUT" for values in (one, other)]
    alike = any(texts) or one.dtype == other.dtype if exact else texts[0] == texts[1]
    if not alike:
        what = f"holds {one.dtype}; expected {other.dtype}"
        return [Difference(path, name, what, one.size, one.size)], "bit for bit" if exact else "type"
    if not exact:
        how, wrong = agreement(name, first, second)
    elif any(texts):
        how, wrong = "bit for bit", np.asarray(one, dtype=str) != np.asarray(other, dtype=str)
    else:
        how, bits = "bit for bit", f"u{one.dtype.itemsize}"
        wrong = (np.ascontiguousarray(one).view(bits) != np.ascontiguousarray(other).view(bits)).reshape(one.shape)
    count = int(np.count_nonzero(wrong))
    if not count:
        return [], how
    if any(texts):
        return [Difference(path, name, "text differs", count, wrong.size)], how
    what = "values differ" if exact else f"differs: not {how}"
    return [Difference(path, name, what, count, wrong.size, _largest(one, other, wrong))], how


def _largest(one: Any, other: Any, differs: Any) -> float:
    with np.errstate(invalid="ignore"):
        apart = np.abs(one.astype(float) - other.astype(float))[differs]
    # one side is NaN: no number says how far apart they are
    return float(np.where(np.isnan(apart), np.inf, apart).max())


def _apart(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """How far numbers are apart: not at all where both are NaN, infinitely far where one is."""
    with np.errstate(invalid="ignore", over="ignore"):
        apart = np.where((a == b) | (np.isnan(a) & np.isnan(b)), 0.0, np.abs(a - b))
    return np.where(np.isnan(apart), np.inf, apart)


def agreement(name: str, first: Dataset, second: Dataset) -> tuple[str, np.ndarray]:
    """How one variable of the same shape in two groups is compared, in words for a table, and where they disagree."""
    table = table_of(str(second.attrs.get("kind")), map(str, second.variables))
    declared = table.get(name)
    rule, bar = ("", "") if declared is None else (declared.rule, declared.bar)
    one, other = first[name].variable, second[name].variable
    if one.dtype.kind in "OUT" or other.dtype.kind in "OUT":
        return "exactly", np.asarray(one.values, dtype=str) != np.asarray(other.values, dtype=str)
    a, b = one.values.astype(float), other.values.astype(float)
    loose = ~np.broadcast_to(_settled(first, second, one), a.shape)
    axis = name in first.coords
    bound = TUNING.stated if axis else _stated(second)
    apart, least = _apart(a, b), _least(name, first, second)
    allowed = bound * np.maximum(least, np.where(np.isfinite(b), np.abs(b), least))
    if rule == "magnitude":
        least = np.minimum(np.abs(a), np.abs(b))
        return "order of magnitude", apart > np.maximum(
            (TUNING.magnitude - 1) * np.where(np.isfinite(least), least, 0.0), TUNING.round_off
        )
    whole = one.dtype.kind in "iub" and rule != "average"
    if not loose.any():
        return ("exactly", apart > 0) if whole else (f"within {bound:.0e}", apart > allowed)
    if bar and _in_both(bar, first, second):
        bars = _spread(bar, first, second, one)
        allowed = allowed + np.where(loose, TUNING.deviations * bars, 0.0)
        return f"within {TUNING.deviations:g} standard errors", apart > allowed
    if name in {variable.bar for variable in table.values()}:
        least = np.minimum(np.abs(a), np.abs(b))
        allowed = allowed + np.where(loose & np.isfinite(least), (TUNING.bar - 1) * least, 0.0)
        return f"within a factor of {TUNING.bar:g}", apart > allowed
    if rule == "average":
        part = TUNING.average
        return "within a tenth", apart > allowed + np.where(loose, part * np.abs(np.nan_to_num(b)) + part, 0.0)
    if rule == "sampled":
        return "not in chaos", (apart > allowed) & ~loose
    wrong = apart > (0.0 if whole else allowed)
    if not axis and any(dim in LEADERS for dim in one.dims):
        return _recorded(name, first, second, wrong, loose, bound)
    return "exactly" if whole else f"within {bound:.0e}", wrong


def _least(name: str, *both: Dataset) -> Any:
    """Smallest scale of the differences of a variable: 1, or less for states and times that stay below.

    The scale of a state that is zero except for round-off is that of the other records in the archive.
    """

    def largest(variables: list[Any], axes: Any) -> Any:
        found = [np.nan_to_num(np.abs(v), posinf=1.0).max(axis=axes(v), initial=0.0) for v in variables]
        most = np.minimum(np.max(found, axis=0), 1.0)
        return np.where(most > 0, most, 1.0)

    if both[0][name].dims[-1:] == ("state",):
        of_states = [v for ds in both for key, v in ds.data_vars.items() if "tangent" not in str(key)]
        # tangents have their own sizes
        states = [v.values for v in of_states if v.dims[-1:] == ("state",) and v.dtype.kind == "f"]
        return largest(states, lambda values: tuple(range(values.ndim - 1)))
    if "time" in name:
        return largest([ds[name].values for ds in both], lambda values: None)
    return 1.0


def _stated(ds: Dataset) -> float:
    try:
        tolerance = float(ds.attrs["tolerance"])
    except (KeyError, TypeError, ValueError):
        return TUNING.stated
    return max(TUNING.stated, TUNING.per_tolerance * tolerance)


def _in_both(name: str, first: Dataset, second: Dataset) -> bool:
    """Whether both have numbers of that name and the same shape, which an altered archive may lack."""
    if name not in first or name not in second:
        return False
    one, other = first[name].variable, second[name].variable
    return one.sizes == other.sizes and one.dims == other.dims and {one.dtype.kind, other.dtype.kind} <= set("iufb")


def _settled(first: Dataset, second: Dataset, variable: Variable) -> Any:
    """Where both runs are known to be regular, in the shape of a variable as far as its dimensions go."""
    if second.attrs.get("kind") in _ORBITS:
        return True
    name = "attractor_outcome" if {"attractor", "attractor_number"} & set(variable.dims) else "outcome"
    if not _in_both(name, first, second):
        return False
    outcome = second[name].variable
    regular = ~np.isin(outcome.values, _UNDECIDED) & ~np.isin(first[name].values, _UNDECIDED)
    if not set(outcome.dims) <= set(variable.dims):
        return bool(regular.all())
    return np.asarray(outcome.copy(data=regular).set_dims(dict(variable.sizes)).transpose(*variable.dims).values)


def _spread(name: str, first: Dataset, second: Dataset, variable: Variable) -> np.ndarray:
    """Standard error of the difference of two estimates, in the shape of the estimates."""
    bars = second[name].variable
    total = np.hypot(np.nan_to_num(first[name].values), np.nan_to_num(bars.values))
    wide = bars.copy(data=total).set_dims(dict(variable.sizes)).transpose(*variable.dims)
    if "block" not in variable.dims:
        return np.asarray(wide.values)
    # the mean over a part of the blocks is that much less certain
    count = variable.sizes["block"]
    shape = [-1 if dim == "block" else 1 for dim in variable.dims]
    return np.asarray(wide.values * np.sqrt(count / np.arange(1, count + 1)).reshape(shape))


def _parting(dim: str, first: Dataset, second: Dataset, bound: float) -> tuple[Any, Any]:
    """Row from which two recorded runs have diverged, and where they did so by a jump instead of gradually."""
    name = LEADERS[dim]
    if not _in_both(name, first, second):
        return None, None
    leader = second[name].variable
    a, b = first[name].values, leader.values
    least = _least(name, first, second)
    distance = (_apart(a, b) / least).max(axis=-1, initial=0.0)
    size = np.maximum(1.0, (np.nan_to_num(np.abs(b)) / least).max(axis=-1, initial=0.0))
    axis = leader.dims.index(dim)
    distance, size = np.moveaxis(distance, axis, 0), np.moveaxis(size, axis, 0)
    parted = np.logical_or.accumulate(distance > bound * size, axis=0)
    before = np.concatenate([distance[:1], distance[:-1]])
    jump = parted & (distance > bound * size) & (distance > TUNING.jump * np.maximum(before, TUNING.least_distance))
    jump &= ~np.concatenate([parted[:1], parted[:-1]])
    rows = leader.isel({leader.dims[-1]: 0})
    return rows.copy(data=np.moveaxis(parted, 0, axis)), rows.copy(data=np.moveaxis(jump, 0, axis))


def _recorded(
    name: str, first: Dataset, second: Dataset, wrong: np.ndarray, loose: np.ndarray, bound: float
) -> tuple[str, np.ndarray]:
    """Records of runs that may be chaotic agree until they diverge gradually, and in their range thereafter."""
    variable = second[name].variable
    dim = next(dim for dim in variable.dims if dim in LEADERS)
    parted, jump = _parting(dim, first, second, bound)
    if parted is None:
        return f"within {bound:.0e}", wrong
    parted, jump = (mask.set_dims(dict(variable.sizes)).transpose(*variable.dims).values for mask in (parted, jump))
    excused = loose & parted
    if variable.dtype.kind == "f" and variable.size:
        a, b, axis = first[name].values, variable.values, variable.dims.index(dim)
        low, high = (pick(b, axis=axis, keepdims=True) for pick in (np.min, np.max))
        with np.errstate(invalid="ignore"):
            margin = TUNING.margin * (high - low) + bound * _least(name, first, second)
            excused = excused & (a >= low - margin) & (a <= high + margin)
    if name == LEADERS[dim]:
        excused = excused & ~jump
    return "until the runs diverge, then by their range", wrong & ~excused
