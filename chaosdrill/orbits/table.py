"""Branches as one table of points; cascades of period doublings, Feigenbaum's ratios and their accumulation.

Feigenbaum 1978, doi:10.1007/BF01020332; the limit by Aitken's delta-squared process.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from chaosdrill.dataset.branches import Special
from chaosdrill.orbits.crossings import unexplained
from chaosdrill.orbits.guess import with_values
from chaosdrill.orbits.marks import Columns, section_of
from chaosdrill.orbits.multipliers import is_stable
from chaosdrill.orbits.problem import Problem
from chaosdrill.orbits.results import BranchInfo, BranchResult, Cascade, SpecialPoint
from chaosdrill.orbits.tuning import TUNING
from chaosdrill.orbits.verification import verify

if TYPE_CHECKING:
    from collections.abc import Sequence

    from chaosdrill.dataset import Outcome
    from chaosdrill.model import HybridSystem
    from chaosdrill.orbits.branch import Branch, BranchSegment
    from chaosdrill.orbits.orbit import Orbit


def cascade_from(values: "Sequence[float]", periods: "Sequence[int]") -> Cascade:
    """Ratios and limit of successive period doublings.

    ``values``: the parameter at each. ``periods``: period of the orbit that doubles at each.

    The limit is that of a geometric sequence through the last three doublings; its error is how far the limit of the
    three before lies from it, NaN with fewer than four.
    """
    v = np.asarray(values, dtype=float)
    gaps = np.diff(v)
    ratios = np.full(len(v), np.nan)
    ratios[2:] = gaps[:-1] / gaps[1:]
    limits = [_limit(*v[k - 2 : k + 1]) for k in range(2, len(v))]
    limit = limits[-1] if limits else np.nan
    error = abs(limits[-1] - limits[-2]) if len(limits) > 1 else np.nan
    return Cascade(v, np.asarray(periods, dtype=np.int64), ratios, float(limit), float(error))


def _limit(a: float, b: float, c: float) -> float:
    bend = (c - b) - (b - a)
    return c - (c - b) ** 2 / bend if bend != 0 else np.nan


def branch_table(
    problem: Problem,
    parameters: tuple[str, ...],
    branches: "Sequence[Branch]",
    cascade: Cascade | None,
    columns: Columns,
    missing: "Sequence[str]",
) -> BranchResult:
    """One table of the points of all branches, with what ``columns`` ask for; ``missing`` is what was not followed."""
    tables, events, infos = [], [], []
    names: dict[str, int] = {}
    total = 0
    for number, branch in enumerate(branches):
        offsets = []
        period = 1
        for segment in branch.segments:
            offsets.append(total)
            if not len(segment):
                continue
            sequence = names.setdefault(_cycle(segment.orbit(0).events(problem.plain)), len(names))
            tables.append(_table(segment, number, sequence, columns))
            total += len(segment)
            period = segment.orbit(0).periods
        for mark in branch.marks:
            values = branch.segments[mark.segment].values[mark.point]
            events.append(
                SpecialPoint(
                    offsets[mark.segment] + mark.point,
                    mark.kind,
                    values,
                    mark.error,
                    mark.text,
                    mark.multiplicity,
                    mark.form,
                    mark.grazing,
                )
            )
        infos.append(BranchInfo(branch.parent, period, branch.start, branch.words, branch.end))
    points = [points for table in tables for points in table.pop("section")]
    orbits = tuple(orbit for table in tables for orbit in table.pop("orbits"))
    section = np.full((len(points), max([1, *map(len, points)]), problem.states), np.nan)
    for row, own in zip(section, points, strict=True):
        row[: len(own)] = own
    joined: dict[str, Any] = {name: np.concatenate([t[name] for t in tables]) for name in tables[0]}
    misses = [words for branch in branches for segment in branch.segments for words in _misses(segment)]
    jumps = [words for branch in branches for words in _jumps(parameters[0], branch)]
    return BranchResult(
        message="; ".join([*missing, *problem.remarks, *jumps[:3], *misses[:3]]),
        neutral=problem.neutral.count,
        parameters=parameters,
        sequences=tuple(names),
        branches=tuple(infos),
        events=tuple(sorted(events, key=lambda e: e.point)),
        cascade=cascade,
        section=section,
        orbits=orbits,
        **joined,
    )


def _table(segment: "BranchSegment", number: int, sequence: int, columns: Columns) -> dict[str, Any]:
    problem, points, first = segment.curve.problem, segment.points, segment.orbit(0)
    strobes, modes = problem.strobes([p.orbit for p in points])
    values = segment.spectra.values.copy()
    # at grazing the map has no derivative on the side where the guard is crossed
    values[_slowness(segment) < TUNING.grazing_speed] = complex(np.nan, np.nan)
    marks, wanted = columns.marks, columns.wanted
    none = np.zeros((len(points), 0))
    seen = [p.orbit for p in points], [p.shot for p in points]
    functions = (none, none) if wanted is None else wanted.functions(problem, *seen)
    return {
        "values": segment.values,
        "branch": np.full(len(points), number),
        "arclength": segment.arclengths,
        "period": np.full(len(points), first.periods),
        "duration": segment.durations.sum(axis=1),
        "state": strobes[:, 0],
        "section": strobes if marks is None else [section_of(problem, p.orbit, marks) for p in points],
        "mode": modes[:, 0],
        "multipliers": values,
        "stable": is_stable(values, problem.neutral.count) & (not segment.family),
        "special": np.array([int(p.special) for p in points]),
        "sequence": np.full(len(points), sequence),
        "smallest_speed": np.array([np.abs(p.shot.rates).min() for p in points]),
        "residual": np.array([p.shot.residual for p in points]),
        "orbits": [(problem, p.orbit, segment.rank) for p in points],
        "functions": functions[0],
        "function_errors": functions[1],
    }


def _jumps(parameter: str, branch: "Branch") -> Iterator[str]:
    """Where the number of multipliers outside the unit circle changes without a special point, in words."""
    for number, segment in enumerate(branch.segments):
        if segment.curve.kind != Special.REGULAR or not len(segment):
            continue
        passed = (mark for mark in (*branch.marks, *branch.again) if mark.segment == number)
        marks = {mark.point: mark.multiplicity for mark in passed}
        found = unexplained(segment, marks)
        if found is not None:
            one, other = (f"{segment.values[k, 0]:.9g}" for k in found[:2])
            yield (
                f"between {parameter} = {one} and {other} the number of multipliers outside the unit circle changes "
                f"from {found[2]} to {found[3]}, and no special point found there explains it"
            )


def _slowness(segment: "BranchSegment") -> np.ndarray:
    """Smallest speed at an event of each orbit, relative to the motion; shape (P,)."""
    return np.asarray((segment.speeds / segment.curve.problem.paces(segment.orbit(0))).min(axis=1))


def _misses(segment: "BranchSegment") -> Iterator[str]:
    """What runs of the ordinary engine say against some of the points."""
    if not len(segment):
        return
    lengths = segment.arclengths - segment.arclengths[0]
    # next to a border a run may see an event of no speed or not
    clear = np.minimum(lengths, lengths[-1] - lengths) > TUNING.clear * min(1.0, lengths[-1])
    if segment.curve.kind == Special.REGULAR:
        clear &= segment.durations.min(axis=1) > TUNING.clear * segment.durations.sum(axis=1)
        clear &= _slowness(segment) > TUNING.clear
        clear &= np.array([p.special == Special.REGULAR for p in segment.points])
    inner = np.flatnonzero(clear)
    spread = np.linspace(0, max(len(inner) - 1, 0), TUNING.checked if len(inner) else 0).astype(int)
    for k in np.unique(inner[spread]).tolist():
        found = segment.curve.followed(segment.points[k])
        words = miss(segment.curve.problem, found[0]) if found is not None else ""
        if words:
            yield words


def miss(problem: Problem, orbit: "Orbit") -> str:
    """How an ordinary simulation contradicts an orbit; empty if it does not."""
    d = problem.states
    system = with_values(problem, orbit.starts[0, d:])
    plain = problem.alike(system, ())
    repeated = verify(plain, replace(orbit, starts=np.ascontiguousarray(orbit.starts[:, :d])))
    values = ", ".join(f"{name} = {v:.9g}" for name, v in zip(problem.free, orbit.starts[0, d:], strict=True))
    if repeated.differs:
        return f"at {values} a run of the system differs: {repeated.differs}"
    if not repeated.residual <= repeated.explained(problem.numerics.tolerance):
        return f"at {values} a run of the system misses its start by {repeated.residual:.1e}"
    return ""


def nothing(system: "HybridSystem", parameters: tuple[str, ...], outcome: "Outcome", message: str) -> BranchResult:
    """No branch, and why."""
    d = len(system.state_names)
    none = np.zeros(0)
    whole = np.zeros(0, dtype=np.int64)
    return BranchResult(
        parameters=parameters, values=np.zeros((0, len(parameters))), branch=whole, arclength=none, period=whole,
        duration=none, state=np.zeros((0, d)), section=np.zeros((0, 1, d)), mode=whole,
        multipliers=np.zeros((0, d), dtype=complex), stable=np.zeros(0, dtype=bool), special=whole, sequence=whole,
        sequences=(), smallest_speed=none, residual=none, branches=(), events=(), outcome=outcome, message=message,
    )  # fmt: skip


def _cycle(names: list[str]) -> str:
    """The names of a cycle of events, beginning where they come first in the alphabet."""
    return " ".join(min((names[k:] + names[:k] for k in range(len(names))), default=[]))
