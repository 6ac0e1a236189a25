"""Branches that have grown become one table of points."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.orbits.multipliers import free_multipliers, multipliers
from chaosdrill.orbits.results import BranchInfo, BranchResult, Cascade, SpecialPoint

if TYPE_CHECKING:
    from collections.abc import Sequence

    from chaosdrill.orbits.family import Family
    from chaosdrill.orbits.growing import Grown
    from chaosdrill.orbits.stretch import Stretch


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
    joined = {name: np.concatenate([t[name] for t in tables]) for name in tables[0]}
    return BranchResult(
        parameters=parameters,
        sequences=tuple(names),
        branches=tuple(infos),
        events=tuple(sorted(events, key=lambda e: e.point)),
        cascade=cascade,
        **joined,
    )


def _table(family: "Family", stretch: "Stretch", rank: int, number: int, sequence: int) -> dict[str, np.ndarray]:
    points, d = len(stretch), family.states
    orbits = [stretch.orbit(k) for k in range(points)]
    section, modes = family.strobes(orbits)
    values = multipliers(family, orbits[0], stretch.monodromies, rank)
    return {
        "values": stretch.values(d),
        "branch": np.full(points, number),
        "arclength": stretch.arclengths,
        "period": np.full(points, stretch.periods),
        "section": section,
        "mode": modes[:, 0],
        "multipliers": values,
        "stable": (np.abs(free_multipliers(family, values)) < 1).all(axis=-1),
        "special": stretch.special,
        "sequence": np.full(points, sequence),
        "smallest_speed": stretch.speeds.min(axis=1),
        "residual": stretch.residuals,
    }


def _cycle(events: str) -> str:
    """The names of a cycle of events, told from where they come first in the alphabet."""
    names = events.split()
    return " ".join(min((names[k:] + names[:k] for k in range(len(names))), default=[]))
