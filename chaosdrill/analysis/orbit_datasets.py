"""Datasets of what the search for orbits and the following of branches give."""

from collections import Counter
from collections.abc import Iterable, Sequence
from itertools import groupby
from operator import attrgetter
from typing import Any

import numpy as np
import xarray as xr

from chaosdrill.dataset import Outcome
from chaosdrill.dataset.build import dataset, more, variable
from chaosdrill.dataset.schema import names_of_rate
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run, rate_names
from chaosdrill.engine.shifts import shifts_of
from chaosdrill.model import HybridSystem
from chaosdrill.orbits.derivatives import derived_of
from chaosdrill.orbits.multipliers import is_stable
from chaosdrill.orbits.orbit import Orbit
from chaosdrill.orbits.problem import Problem
from chaosdrill.orbits.results import BranchResult, Derived, FoundOrbit


def orbits_dataset(system: HybridSystem, orbits: Sequence[FoundOrbit]) -> xr.Dataset:
    """The raw dataset of ``periodic-orbit``, with the dimension ``orbit``.

    ``orbits``: what was found; shorter ones are filled up with NaN, and -1 for codes.
    """
    n = len(system.state_names)
    found = np.array([orbit.outcome == Outcome.PERIODIC for orbit in orbits], dtype=bool)
    multipliers = _filled([orbit.multipliers for orbit in orbits], (n,), complex(np.nan, np.nan))
    multipliers[~found] = complex(np.nan, np.nan)
    state = np.array([[*orbit.states, np.full(n, np.nan)][0] for orbit in orbits]).reshape(-1, n)
    section = _filled([orbit.section for orbit in orbits], (0, n))
    codes = _filled([orbit.event_transitions for orbit in orbits], (0,), -1)

    def each(values: Iterable[Any], missing: float, dtype: Any = float) -> tuple[str, np.ndarray]:
        return "orbit", np.where(found, np.array(list(values), dtype=dtype), missing).astype(dtype)

    def over(*dims: str) -> tuple[str, ...]:
        return ("orbit", *dims)

    speeds = [np.abs(orbit.event_speeds).min(initial=np.inf) for orbit in orbits]
    variables: dict[str, Any] = {
        "orbit_state": (over("state"), state),
        "mode": each((orbit.mode for orbit in orbits), -1, np.int8),
        "section": (over("iterate", "state"), section),
        "period": each((orbit.period for orbit in orbits), 0, np.int32),
        "period_time": each((orbit.duration for orbit in orbits), np.nan),
        "multiplier_real": (over("multiplier"), multipliers.real),
        "multiplier_imag": (over("multiplier"), multipliers.imag),
        "rank": each((orbit.rank for orbit in orbits), 0, np.int32),
        "stable": each(is_stable(multipliers, max((orbit.neutral for orbit in orbits), default=0)), 0, np.int8),
        "residual": each((orbit.residual for orbit in orbits), np.nan),
        "newton_residual": (over("iteration"), _filled([orbit.newton for orbit in orbits], (0,))),
        "event_count": ("orbit", np.array([len(orbit.event_times) for orbit in orbits], dtype=np.int32)),
        "event_time": (over("event"), _filled([orbit.event_times for orbit in orbits], (0,))),
        "event_kind": (over("event"), codes.astype(np.int8)),
        "event_speed": (over("event"), _filled([orbit.event_speeds for orbit in orbits], (0,))),
        "event_state_before": (over("event", "state"), _filled([o.event_states_before for o in orbits], (0, n))),
        "event_state_after": (over("event", "state"), _filled([o.event_states_after for o in orbits], (0, n))),
        "path_time": (over("path_point"), _filled([orbit.path_times for orbit in orbits], (0,))),
        "path_state": (over("path_point", "state"), _filled([orbit.path_states for orbit in orbits], (0, n))),
        "smallest_speed": each(speeds, np.nan),
        "lyapunov_exponent": (over("multiplier"), _filled([orbit.checks.exponents for orbit in orbits], (n,))),
        "exponent_difference": each((orbit.checks.exponent_difference for orbit in orbits), np.nan),
        "determinant_difference": each((orbit.checks.determinant_difference for orbit in orbits), np.nan),
        "recurrence_difference": each((orbit.checks.recurrence_difference for orbit in orbits), np.nan),
        "consistent": each((orbit.checks.consistent for orbit in orbits), 0, np.int8),
        "neutral": ((), np.int32(max((orbit.neutral for orbit in orbits), default=0))),
        "outcome": ("orbit", np.array([orbit.outcome for orbit in orbits], dtype=np.int8)),
    }
    if system.forced:
        variables["forcing_period"] = ((), system.forcing_period())
    if shifts_of(system):
        none = np.full((2, n), np.nan)
        drifts = [none if o.solved is None else _drift_of(*o.solved[:2], o.residual) for o in orbits]
        variables |= _drifts("orbit", n, drifts)
    sizes = {"iterate": section.shape[1], "iteration": variables["newton_residual"][1].shape[1]}
    numbers: dict[str, Any] = {name: np.arange(size, dtype=np.int32) for name, size in sizes.items()}
    numbers |= {
        name: np.arange(1, size + 1, dtype=np.int32) for name, size in (("orbit", len(orbits)), ("multiplier", n))
    }
    return dataset({**variables, "state": list(system.state_names), **numbers})


def _drift_of(problem: Problem, orbit: Orbit, residual: float) -> np.ndarray:
    """By how much an orbit is shifted in one period, and the error of that, shape (2, d).

    The error is that of the method and of the closing of the orbit, relative to the sizes of the states.
    """
    d = problem.states
    drift = np.zeros(d) if orbit.drift is None else orbit.drift
    size = np.maximum(problem.sizes, np.abs(orbit.starts[:, :d]).max(axis=0) + np.abs(drift))
    along = (problem.shifts.lines != 0).any(axis=0)
    return np.array([drift, np.where(along, (residual + problem.accuracy) * size, 0.0)])


def _drifts(over: str, n: int, rows: Sequence[np.ndarray]) -> dict[str, Any]:
    """By how much orbits are shifted in one period, with errors, from rows of shape (2, n)."""
    table = np.array(rows).reshape(-1, 2, n)
    return {name: ((over, "state"), table[:, k]) for k, name in enumerate(("drift", "drift_error"))}


NOT_OF_CHAOS = (
    "there is no orbit, as the message says, and only orbits have derivatives: means of a chaotic motion "
    "need not change smoothly"
)


def with_derivatives(
    ds: xr.Dataset, system: HybridSystem, names: Sequence[str], found: Sequence[Derived], over: str
) -> xr.Dataset:
    """The dataset with derivatives of its results on orbits by parameters.

    ``names``: the parameters. ``found``: one an orbit. ``over``, {"orbit", "point"}: dimension of the orbits; for
    points of a branch the times of events are left out.
    """
    shapes: dict[str, tuple[str, ...]] = {
        "orbit_state": ("state",),
        "period_time": (),
        "multiplier_real": ("multiplier",),
        "multiplier_imag": ("multiplier",),
        "lyapunov_exponent": ("multiplier",),
    }
    if over == "orbit":
        shapes["event_time"] = ("event",)
    variables: dict[str, Any] = {}
    for ending, tables in (("", [one.values for one in found]), ("_error", [one.errors for one in found])):
        for name, dims in shapes.items():
            whole, _, part = name.rpartition("_")
            rows = [getattr(one[whole], part) if whole == "multiplier" else one[name] for one in tables]
            values = _filled(rows, (0, len(names))) if name == "event_time" else np.array(rows)
            variables[f"{name}_derivative{ending}"] = ((over, *dims, "parameter"), values)
        for i, quadrature in enumerate(system.quadratures):
            mean = names_of_rate(str(quadrature))[0]
            rows = [one["rates"][i] for one in tables]
            variables[f"{mean}_derivative{ending}"] = ((over, "parameter"), np.array(rows))
    return more(ds, {**variables, "parameter": list(names)})


def orbit_rates(
    system: HybridSystem, orbits: Sequence[FoundOrbit], numerics: Numerics
) -> dict[str, tuple[str, np.ndarray]]:
    """Means over exactly one period of each orbit, variables of ``periodic-orbit``; NaN without an orbit.

    ``numerics``: method and tolerance by which quadratures along them are taken.
    """
    names = [name for name in rate_names(system) if name != "closest_grazing"]
    rates = np.full((len(names), len(orbits)), np.nan)
    for column, orbit in enumerate(orbits):
        if orbit.outcome != Outcome.PERIODIC:
            continue
        taken = [system.transitions[i] for i in orbit.event_transitions if not system.transitions[i].marks_only()]
        counts = (len(taken), *(sum(t.kind == kind for t in taken) for kind in ("impact", "slip")))
        rates[: len(counts), column] = np.array(counts) / (orbit.period if system.forced else orbit.duration)
        if system.quadratures:
            rates[len(counts) :, column] = _integrals(system, orbit, numerics) / orbit.duration
    return {name: ("orbit", values) for name, values in zip(names, rates, strict=True)}


def _integrals(system: HybridSystem, orbit: FoundOrbit, numerics: Numerics) -> np.ndarray:
    """Quadratures over one period, NaN if it cannot be followed; shape (q,)."""
    start = dict(zip(system.state_names, orbit.states[0].tolist(), strict=True))
    parts = len(orbit.states) if system.forced else 1
    run = Run(system.with_initial(**start, mode=system.mode_names[orbit.mode]), orbit.duration / parts, numerics)
    for state in orbit.states[:parts]:
        # an unstable orbit is not left if every strobe begins on it
        run.x[:] = state
        if run.advance(1)[0] != Outcome.OK:
            return np.full(len(system.quadratures), np.nan)
    return run.integrals()


_OF_BRANCHES: dict[str, tuple[str, Any]] = {
    "branch_parent": ("parent", np.int32),
    "branch_period": ("period", np.int32),
    "branch_start": ("start", str),
    "branch_end": ("end_code", np.int8),
    "branch_end_text": ("end", str),
}
_OF_SPECIAL_POINTS: dict[str, tuple[str, Any]] = {
    "special_index": ("point", np.int32),
    "special_kind": ("code", np.int8),
    "special_error": ("error", float),
    "special_multiplicity": ("multiplicity", np.int32),
    "special_criticality": ("form.criticality", np.int8),
    "special_coefficient": ("form.coefficient", float),
    "special_coefficient_error": ("form.error", float),
    "special_onset": ("grazing.onset", np.int8),
    "special_power": ("grazing.power", float),
    "grazing_coefficient": ("grazing.coefficient", float),
    "grazing_coefficient_error": ("grazing.error", float),
    "special_return": ("grazing.decisive", np.int32),
    "special_text": ("text", str),
}
"""Where each variable stands in the record of a branch, or of a special point, and its type."""


def _columns(table: dict[str, tuple[str, Any]], dim: str, records: Sequence[Any]) -> dict[str, Any]:
    """The variables of a table, one entry a record."""
    return {
        name: (dim, np.array([attrgetter(place)(one) for one in records], dtype=dtype))
        for name, (place, dtype) in table.items()
    }


def branches_dataset(system: HybridSystem, result: BranchResult) -> xr.Dataset:
    """The raw dataset of ``continuation``.

    ``result``: branches with their special points.
    """
    n = len(system.state_names)
    branches, special = result.branches, result.events
    values = np.array([point.values for point in special]).reshape(len(special), len(result.parameters))
    lengths = [result.arclength[result.branch == number].max(initial=0.0) for number in range(len(branches))]
    variables: dict[str, Any] = {
        **{name: ("point", result.values[:, i]) for i, name in enumerate(result.parameters)},
        "branch": ("point", result.branch),
        "arclength": ("point", result.arclength),
        "orbit_state": (("point", "state"), result.state),
        "section": (("point", "iterate", "state"), result.section),
        "mode": ("point", result.mode),
        "period": ("point", result.period),
        "period_time": ("point", result.duration),
        "multiplier_real": (("point", "multiplier"), result.multipliers.real),
        "multiplier_imag": (("point", "multiplier"), result.multipliers.imag),
        "stable": ("point", result.stable),
        "special_point": ("point", result.special),
        "sequence": ("point", result.sequence),
        "event_sequence": ("sequence_number", np.array(result.sequences, dtype=str)),
        "smallest_speed": ("point", result.smallest_speed),
        "residual": ("point", result.residual),
        **_columns(_OF_BRANCHES, "branch_number", branches),
        "branch_length": ("branch_number", np.array(lengths)),
        **_columns(_OF_SPECIAL_POINTS, "special", special),
        "neutral": ((), np.int32(result.neutral)),
        "outcome": ((), np.int8(result.outcome)),
    }
    for i, name in enumerate(("special_value", "special_value_2")[: len(result.parameters)]):
        variables[name] = ("special", values[:, i].astype(float))
    if result.orbits and shifts_of(system):
        pairs = zip(result.orbits, result.residual.tolist(), strict=True)
        variables |= _drifts("point", n, [_drift_of(problem, orbit, left) for (problem, orbit, _), left in pairs])
    if result.cascade is not None:
        cascade = result.cascade
        variables |= {
            "doubling_value": ("doubling", cascade.values),
            "doubling_period": ("doubling", cascade.periods),
            "feigenbaum_ratio": ("doubling", cascade.ratios),
            "accumulation": ((), cascade.limit),
            "accumulation_error": ((), cascade.limit_error),
        }
    numbers = {
        "multiplier": np.arange(1, n + 1, dtype=np.int32),
        "iterate": np.arange(result.section.shape[1], dtype=np.int32),
        "branch_number": np.arange(len(branches), dtype=np.int32),
    }
    return dataset({**variables, "state": list(system.state_names), **numbers})


def branches_derived(ds: xr.Dataset, system: HybridSystem, names: Sequence[str], result: BranchResult) -> xr.Dataset:
    """The dataset of branches with mean rates and derivatives by parameters at every point, NaN where unknown.

    The attribute ``derivatives_message`` says where and why.
    """
    found: list[Derived] = []
    pairs = zip(result.orbits, result.multipliers, strict=True)
    for problem, run in groupby(pairs, key=lambda pair: pair[0][0]):
        found += derived_of(problem, names, [(orbit, values, rank) for (_, orbit, rank), values in run])
    if not found:
        return ds.assign_attrs(derivatives_message=NOT_OF_CHAOS)
    here = np.tile([system.parameters[name] for name in names], (len(found), 1))
    for i, name in enumerate(result.parameters):
        if name in names:
            here[:, list(names).index(name)] = result.values[:, i]
    means = {
        names_of_rate(str(quadrature))[0]: ("point", np.array([one.means[i] for one in found]))
        for i, quadrature in enumerate(system.quadratures)
    }
    missing = Counter(one.message for one in found if one.message)
    words = "; ".join(f"{count} of {len(found)} points: {text}" for text, count in missing.items())
    ds = with_derivatives(more(ds, means), system, names, found, "point")
    ds = ds.assign_coords(parameter_value=variable(("point", "parameter"), here))
    return ds.assign_attrs(derivatives_message=words)


def numbered(texts: Iterable[str]) -> str:
    """Texts that are not empty, a line each, with the number of the orbit in front."""
    return "\n".join(f"orbit {number}: {text}" for number, text in enumerate(texts, 1) if text)


def _filled(rows: Sequence[np.ndarray], least: tuple[int, ...], fill: Any = np.nan) -> np.ndarray:
    """Rows of one array each, filled up to the longest; ``least`` is the shape of a row where there are none."""
    length = max((len(row) for row in rows), default=least[0])
    filled = np.full((len(rows), length, *least[1:]), fill)
    for i, row in enumerate(rows):
        filled[i, : len(row)] = row
    return filled
