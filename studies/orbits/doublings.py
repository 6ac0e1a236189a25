"""Period doublings held against brute force: what attracts a little below each of them, and a little above.

Beside a period doubling the branch says whether the orbit attracts, whether the doubled one does, or neither. A run
from a state next to the orbit, as in any bifurcation diagram, has to end there: on the orbit, on one of twice its
period, or elsewhere. The nearer to the doubling, the slower the run: it skips so many periods that a
deviation has changed by a factor e^40.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from reading import Special, parameter, start, system_of, table, until_turning

import chaosdrill as cd

OFFSETS = (1e-4, 1e-5, 1e-6)
"""Distances in the parameter from the doubling."""

BESIDE = 1e-6
"""Distance of the start from the orbit."""

FORGET = 40.0
MOST_FORGOTTEN = 1_000_000
"""Distances at which more periods would have to be forgotten are left out."""

UNKNOWN = -1

NEAR = 0.05
"""Distance within which a section belongs to the orbit or to the doubled one next to it."""


BORN = 1e-4
"""Distance in the parameter from the doubling within which a doubled branch begins or ends."""


@dataclass(frozen=True)
class Side:
    """One side of a doubling at one distance.

    Parameters
    ----------
    offset : float
        Signed distance in the parameter.
    told : int
        Period that attracts by the branches; 0 if neither the orbit nor the doubled one does, ``UNKNOWN`` if the orbit
        does not and the doubled one was not followed.
    found : int
        Period of the attractor of the diagram, 0 if none was found.
    distance : float
        Largest distance of its section from the orbit at the doubling.
    period : int
        Period of the orbit.
    """

    offset: float
    told: int
    found: int
    distance: float
    period: int

    @property
    def agrees(self) -> bool:
        """Whether the diagram shows what the branches tell."""
        if self.told > 0:
            return self.found == self.told and self.distance < NEAR
        others = (self.period,) if self.told == UNKNOWN else (self.period, 2 * self.period)
        return self.found not in others or self.distance > NEAR


def sides(special: Special, offsets: Iterable[float] = OFFSETS) -> list[Side]:
    """Return what the branches tell and what a diagram shows on both sides of a period doubling."""
    found = []
    rate = _rate(special)
    section, mode = special.orbit(special.point)
    name = parameter(special.branches)
    for offset in offsets:
        values = [special.value - offset, special.value + offset]
        system = system_of(special.branches, special.value)
        beside = section[0].copy()
        beside[0] -= BESIDE
        forget = int(np.ceil(FORGET / (rate * offset))) * special.period
        if forget > MOST_FORGOTTEN:
            continue
        diagram = cd.bifurcation_diagram(
            system,
            {name: values},
            seeds=[start(system, beside, mode)],
            transient=max(forget, 200),
            periods=max(64, 8 * special.period),
            max_period=max(32, 4 * special.period),
            exponents=0,
        )
        for i, sign in enumerate((-1, 1)):
            seen = diagram["section"].values[i, 0]
            known = np.isfinite(seen).all(axis=1)
            gaps = np.linalg.norm(seen[known, None] - section[None], axis=2).min(axis=1)
            distance = float(gaps.max()) if known.any() else np.inf
            told = _told(special, values[i])
            found.append(Side(sign * offset, told, int(diagram["period"].values[i, 0]), distance, special.period))
    return found


def attracts(special: Special) -> bool:
    """Return whether the orbit attracts on one side of its doubling; if not, no diagram shows anything of it."""
    stable = special.branches["stable"].values
    return any(stable[points[1]] for points in map(special.along, (-1, 1)) if len(points) > 1)


def _rate(special: Special) -> float:
    """Change of the multiplier at -1 with the parameter."""
    branches, name = special.branches, parameter(special.branches)
    multipliers = branches["multiplier_real"].values + 1j * branches["multiplier_imag"].values
    rates = []
    for way in (-1, 1):
        points = special.along(way)[:2]
        if len(points) == 2:
            nearest = np.abs(multipliers[points[1]] + 1).min()
            rates.append(nearest / abs(float(branches[name].values[points[1]]) - special.value))
    return float(min(rates))


def _told(special: Special, value: float) -> int:
    """Period that attracts at a value of the parameter near a doubling, by the branches."""
    branches = special.branches
    for way in (-1, 1):
        if _stable(special, special.stretch(way), value):
            return special.period
    told = UNKNOWN
    for child in np.flatnonzero(branches["branch_parent"].values == special.branch):
        points = np.flatnonzero(branches["branch"].values == child)
        ends = branches[parameter(branches)].values[points[[0, -1]]]
        close = np.abs(ends - special.value)
        if close.min() > BORN:
            continue
        points = points if close[0] < close[1] else points[::-1]
        if _stable(special, until_turning(branches[parameter(branches)].values, points), value):
            return 2 * special.period
        told = 0
    return told


def _stable(special: Special, points: np.ndarray, value: float) -> bool:
    """Whether the first orbit at a value on the way along a branch is stable.

    The branch's own end may lie a step beyond the doubling.
    """
    values = special.branches[parameter(special.branches)].values[points].copy()
    stable = special.branches["stable"].values[points] != 0
    kinds = special.branches["special_point"].values[points]
    values[0] = special.value
    between = (values[:-1] - value) * (values[1:] - value) <= 0
    if not between.any():
        return False
    first = int(between.argmax())
    return bool(stable[first + 1] if first == 0 or kinds[first] else stable[first])


def tables(checked: Iterable[tuple[str, Special, list[Side]]]) -> str:
    """Return the table: a line a doubling and distance."""
    rows = []
    for name, special, found in checked:
        for below, above in zip(found[::2], found[1::2], strict=True):
            rows.append(
                [
                    name,
                    f"{special.value:.12f}",
                    f"{special.period} → {2 * special.period}",
                    f"{above.offset:.0e}",
                    *(f"{_told_words(side)} / {_found_words(side)}" for side in (below, above)),
                    "agree" if below.agrees and above.agrees else "disagree",
                ]
            )
    head = ["orbit", "at", "doubling", "distance", "below: branches / diagram", "above: branches / diagram", ""]
    return table(head, rows)


def _told_words(side: Side) -> str:
    return {0: "neither", UNKNOWN: f"not {side.period}"}.get(side.told, str(side.told))


def _found_words(side: Side) -> str:
    away = ", elsewhere" if side.distance > NEAR else ""
    return f"{side.found or 'none'}{away}"
