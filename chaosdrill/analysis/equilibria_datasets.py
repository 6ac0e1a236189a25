"""Datasets of equilibria and of their branches."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from chaosdrill.dataset import Outcome
from chaosdrill.dataset.branches import BranchEnd, Criticality
from chaosdrill.dataset.build import dataset
from chaosdrill.equilibrium.branches import ENDS, Branch, Mark, Task, unexplained
from chaosdrill.equilibrium.points import Equilibrium
from chaosdrill.equilibrium.search import Found
from chaosdrill.model import HybridSystem


def equilibria_dataset(system: HybridSystem, found: Found) -> xr.Dataset:
    """The raw dataset of ``equilibria`` without a parameter."""
    variables = _points(system, found.equilibria)
    variables["starts_led"] = ("point", np.array(found.hits, dtype=np.int32))
    variables["guard"] = ("point", np.array([_guards(system, one) for one in found.equilibria], dtype=str))
    return _finished(system, variables, [*_told(found), *_more(found)])


def branches_dataset(system: HybridSystem, task: Task, found: Found, branches: Sequence[Branch]) -> xr.Dataset:
    """The raw dataset of ``equilibria`` along a parameter."""
    points = [(number, k, p) for number, branch in enumerate(branches) for k, p in enumerate(branch.points)]
    variables = _points(system, [p.at for _, _, p in points])
    first = np.cumsum([0, *(len(branch.points) for branch in branches)])
    marks = [(number, mark) for number, branch in enumerate(branches) for mark in branch.marks]
    special = np.zeros(len(points), dtype=np.int8)
    for number, mark in marks:
        special[first[number] + mark.point] = mark.kind
    starts = [branch.points[0].arclength for branch in branches]
    variables |= {
        task.parameter: ("point", np.array([branches[n].curve.value(p.at) for n, _, p in points], dtype=float)),
        "branch": ("point", np.array([n for n, _, _ in points], dtype=np.int32)),
        "arclength": ("point", np.array([p.arclength - starts[n] for n, _, p in points], dtype=float)),
        "special_point": ("point", special),
        "branch_number": np.arange(len(branches), dtype=np.int32),
        "branch_parent": ("branch_number", np.array([branch.parent for branch in branches], dtype=np.int32)),
        "branch_start": ("branch_number", np.array([branch.start for branch in branches], dtype=str)),
        "branch_end": ("branch_number", np.array([branch.end for branch in branches], dtype=np.int8)),
        "branch_end_text": ("branch_number", np.array([_ends(branch) for branch in branches], dtype=str)),
        "special_index": ("special", np.array([first[n] + mark.point for n, mark in marks], dtype=np.int32)),
        **_special(system, branches, marks),
    }
    jumps = [words for branch in branches for words in unexplained(branch)]
    return _finished(system, variables, [*_told(found), *jumps[:3]])


def _special(
    system: HybridSystem, branches: Sequence[Branch], marks: Sequence[tuple[int, Mark]]
) -> dict[str, tuple[Any, ...]]:
    n = len(system.state_names)
    values = [branches[number].curve.value(branches[number].points[mark.point].at) for number, mark in marks]
    forms = [mark.form for _, mark in marks]
    cycles = [None if form is None else form.cycle for form in forms]
    none = np.full(n, np.nan)

    def each(given: Sequence[Any], dtype: Any = float) -> tuple[str, np.ndarray]:
        return "special", np.array(given, dtype=dtype)

    def states(given: Sequence[Any]) -> tuple[tuple[str, str], np.ndarray]:
        return ("special", "state"), np.array(given, dtype=float).reshape(len(marks), n)

    nan = float("nan")
    return {
        "special_kind": each([mark.kind for _, mark in marks], np.int8),
        "special_value": each(values),
        "special_error": each([mark.error for _, mark in marks]),
        "special_multiplicity": each([mark.multiplicity for _, mark in marks], np.int32),
        "special_beyond": each([mark.beyond for _, mark in marks], np.int8),
        "special_criticality": each([Criticality.NONE if f is None else f.criticality for f in forms], np.int8),
        "special_coefficient": each([nan if form is None else form.coefficient for form in forms]),
        "special_coefficient_error": each([nan if form is None else form.error for form in forms]),
        "special_frequency": each([nan if form is None else form.frequency for form in forms]),
        "special_text": each([mark.text for _, mark in marks], str),
        "cycle_value": each([nan if cycle is None else cycle.value for cycle in cycles]),
        "cycle_state": states([none if cycle is None else cycle.state for cycle in cycles]),
        "cycle_amplitude": states([none if cycle is None else cycle.amplitude for cycle in cycles]),
        "cycle_period": each([nan if cycle is None else cycle.period for cycle in cycles]),
    }


def _points(system: HybridSystem, found: Sequence[Equilibrium]) -> dict[str, Any]:
    n, count = len(system.state_names), len(found)
    values = np.full((count, n), complex(np.nan, np.nan))
    errors = np.full((count, n), np.nan)
    for k, one in enumerate(found):
        m = len(one.spectrum.values)
        values[k, :m], errors[k, :m] = one.spectrum.values, one.spectrum.errors

    def each(given: Sequence[Any], dtype: Any = np.int8) -> tuple[str, np.ndarray]:
        return "point", np.array(given, dtype=dtype)

    return {
        "equilibrium_state": (("point", "state"), np.array([one.states for one in found]).reshape(count, n)),
        "equilibrium_error": (("point", "state"), np.array([one.state_errors() for one in found]).reshape(count, n)),
        "mode": each([one.field.mode for one in found]),
        "pseudo": each([one.field.slides for one in found]),
        "admissible": each([one.where for one in found]),
        "type": each([one.spectrum.type for one in found]),
        "stable": each([one.spectrum.stable for one in found]),
        "free": each([len(one.field.free) for one in found], np.int32),
        "eigenvalue_real": (("point", "eigenvalue"), values.real),
        "eigenvalue_imag": (("point", "eigenvalue"), values.imag),
        "eigenvalue_error": (("point", "eigenvalue"), errors),
    }


def _finished(system: HybridSystem, variables: dict[str, Any], words: Sequence[str]) -> xr.Dataset:
    code = Outcome.EQUILIBRIUM if variables["mode"][1].size else Outcome.NO_EQUILIBRIUM
    names = {"state": list(system.state_names), "eigenvalue": np.arange(1, len(system.state_names) + 1, dtype=np.int32)}
    return dataset({**variables, **names, "outcome": ((), np.int8(code))}, attrs={"message": "; ".join(words)})


def _guards(system: HybridSystem, one: Equilibrium) -> str:
    names = dict.fromkeys(system.transitions[i].name for k in one.beyond for i in one.field.sides[k].outcomes)
    return " ".join(names) or ("parameters" if one.beyond else "")


def _told(found: Found) -> list[str]:
    """Why modes have no equilibria, and which states have no eigenvalue."""
    words = [f"no equilibria: {reason}" for reason in found.refused.values()]
    dropped = dict.fromkeys(reason for one in found.equilibria for reason in one.field.dropped.values())
    return words + [f"no eigenvalue: {reason}" for reason in dropped]


def _more(found: Found) -> list[str]:
    """Whether more starts would find more (Good 1953)."""
    single = sum(count == 1 for count in found.hits)
    if not single:
        return []
    return [
        f"{single} of {len(found.hits)} were found by one start only, so that about one start in "
        f"{max(1, round(found.starts / single))} would lead to another one; take more starts"
    ]


def _ends(branch: Branch) -> str:
    if branch.ends[0] == BranchEnd.CLOSED:
        return ENDS[BranchEnd.CLOSED]
    first, last = (ENDS[end] for end in branch.ends)
    return f"at both ends {first}" if first == last else f"{first}; at the other end {last}"
