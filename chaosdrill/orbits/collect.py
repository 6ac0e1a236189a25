"""Branches that have grown become one table of points."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from chaosdrill.dataset.branches import Special
from chaosdrill.orbits.family import Family
from chaosdrill.orbits.multipliers import multipliers
from chaosdrill.orbits.reading import with_values
from chaosdrill.orbits.results import BranchInfo, BranchResult, Cascade, SpecialPoint
from chaosdrill.orbits.stability import is_stable
from chaosdrill.orbits.verify import verify

if TYPE_CHECKING:
    from collections.abc import Sequence

    from chaosdrill.dataset import Outcome
    from chaosdrill.model import HybridSystem
    from chaosdrill.orbits.growing import Grown
    from chaosdrill.orbits.orbit import Orbit
    from chaosdrill.orbits.stretch import Stretch


TANGENT = 1e-9
"""Speed at a guard below which it counts as met tangentially."""

CLEAR = 1e-4
"""Speed at a guard, and part of an orbit's duration that an arc takes, below which a run is no judge of it."""

CHECKED = 4
"""Points of a stretch that the ordinary engine follows as well, at most."""


@dataclass(frozen=True)
class Planned:
    """A branch that was followed: what grew, number of the branch it comes from, words for its start, and where.

    ``born`` is the parameter at the doubling from which it comes; NaN for one that was started from outside.
    """

    grown: "Grown"
    parent: int
    start: str
    born: float = float("nan")


def collect(
    family: "Family", parameters: tuple[str, ...], planned: "Sequence[Planned]", cascade: Cascade | None
) -> BranchResult:
    """One table of all points, branch after branch."""
    tables, events, infos = [], [], []
    names: dict[str, int] = {}
    total = 0
    for number, one in enumerate(planned):
        offsets = []
        period = 1
        for stretch, rank in zip(one.grown.stretches, one.grown.ranks, strict=True):
            offsets.append(total)
            if not len(stretch):
                continue
            sequence = names.setdefault(_cycle(stretch.orbit(0).events(family.plain)), len(names))
            tables.append(_table(family, stretch, rank, number, sequence))
            total += len(stretch)
            period = stretch.periods
        for mark in one.grown.marks:
            values = one.grown.stretches[mark.stretch].values(family.states)[mark.point]
            point = offsets[mark.stretch] + mark.point
            events.append(SpecialPoint(point, mark.kind, values, float(mark.error), mark.text))
        infos.append(BranchInfo(one.parent, period, one.start, one.grown.words, one.grown.end))
    longest = max(t["section"].shape[1] for t in tables)
    for table in tables:
        lacking = longest - table["section"].shape[1]
        table["section"] = np.pad(table["section"], ((0, 0), (0, lacking), (0, 0)), constant_values=np.nan)
    joined: dict[str, Any] = {name: np.concatenate([t[name] for t in tables]) for name in tables[0]}
    misses = [miss for one in planned for stretch in one.grown.stretches for miss in _misses(family, stretch)]
    return BranchResult(
        message="; ".join(misses[:3]),
        neutral=family.neutral.count,
        parameters=parameters,
        sequences=tuple(names),
        branches=tuple(infos),
        events=tuple(sorted(events, key=lambda e: e.point)),
        cascade=cascade,
        **joined,
    )


def _table(family: "Family", stretch: "Stretch", rank: int, number: int, sequence: int) -> dict[str, np.ndarray]:
    points, d = len(stretch), family.states
    first = stretch.orbit(0)
    section, modes = family.strobes_along(first, stretch.starts, stretch.phases, stretch.durations)
    values = multipliers(family, first, stretch.monodromies, rank)
    # at grazing the map has no derivative on the side where the guard is crossed
    values[stretch.speeds.min(axis=1) < TANGENT] = complex(np.nan, np.nan)
    return {
        "values": stretch.values(d),
        "branch": np.full(points, number),
        "arclength": stretch.arclengths,
        "period": np.full(points, stretch.periods),
        "section": section,
        "mode": modes[:, 0],
        "multipliers": values,
        "stable": is_stable(values, family.neutral.count),
        "special": stretch.special,
        "sequence": np.full(points, sequence),
        "smallest_speed": stretch.speeds.min(axis=1),
        "residual": stretch.residuals,
    }


def _misses(family: "Family", stretch: "Stretch") -> "Iterator[str]":
    """What a run of the ordinary engine says against some of the points."""
    # next to a border a run may see an event of no speed or not
    clear = stretch.durations.min(axis=1) > CLEAR * stretch.durations.sum(axis=1)
    clear &= (stretch.speeds.min(axis=1) > CLEAR) & (stretch.special == Special.REGULAR)
    inner = np.flatnonzero(clear)[1:-1]
    for k in np.unique(inner[np.linspace(0, len(inner) - 1, CHECKED).astype(int)]).tolist() if len(inner) else []:
        words = miss(family, stretch.orbit(k))
        if words:
            yield words


def miss(family: "Family", orbit: "Orbit") -> str:
    """What a run of the ordinary engine says against an orbit; empty if nothing."""
    d = family.states
    system = with_values(family, orbit.starts[0, d:])
    plain = Family(system, (), family.numerics)
    lapped = verify(plain, replace(orbit, starts=np.ascontiguousarray(orbit.starts[:, :d])))
    values = ", ".join(f"{name} = {v:.9g}" for name, v in zip(family.free, orbit.starts[0, d:], strict=True))
    if lapped.differs:
        return f"at {values} a run of the system goes otherwise: {lapped.differs}"
    if not lapped.residual <= lapped.explained(family.numerics.tolerance):
        return f"at {values} a run of the system misses its start by {lapped.residual:.1e}"
    return ""


def nothing(system: "HybridSystem", parameters: tuple[str, ...], outcome: "Outcome", message: str) -> BranchResult:
    """No branch, and why."""
    d = len(system.states)
    none = np.zeros(0)
    whole = np.zeros(0, dtype=np.int64)
    return BranchResult(
        parameters=parameters, values=np.zeros((0, len(parameters))), branch=whole, arclength=none, period=whole,
        section=np.zeros((0, 1, d)), mode=whole, multipliers=np.zeros((0, d), dtype=complex),
        stable=np.zeros(0, dtype=bool), special=whole, sequence=whole, sequences=(), smallest_speed=none,
        residual=none, branches=(), events=(), outcome=outcome, message=message,
    )  # fmt: skip


def _cycle(events: str) -> str:
    """The names of a cycle of events, told from where they come first in the alphabet."""
    names = events.split()
    return " ".join(min((names[k:] + names[:k] for k in range(len(names))), default=[]))
