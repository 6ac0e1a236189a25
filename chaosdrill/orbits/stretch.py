"""A stretch of a branch: orbits of the same arcs, one after the other."""

from dataclasses import dataclass, field, fields, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from chaosdrill.dataset.branches import Special
from chaosdrill.engine import branch
from chaosdrill.engine import lap as at
from chaosdrill.orbits.family import ROUND_OFF
from chaosdrill.orbits.orbit import Orbit

if TYPE_CHECKING:
    from chaosdrill.orbits.family import Family, Lap


@dataclass(frozen=True)
class Stretch:
    """P orbits along a branch, all of the same N arcs.

    Attributes
    ----------
    arcs, periods
        As in `Orbit`.
    starts : ndarray, shape (P, N, d + q)
    phases : ndarray, shape (P,)
    durations, speeds : ndarray, shape (P, N)
    arclengths, residuals : ndarray, shape (P,)
    monodromies : ndarray, shape (P, d, d)
    directions : ndarray, shape (P, columns)
        Along the branch.
    special : ndarray of int, shape (P,)
        Codes of `Special`.
    """

    arcs: np.ndarray
    periods: int
    starts: np.ndarray
    phases: np.ndarray
    durations: np.ndarray
    speeds: np.ndarray
    arclengths: np.ndarray
    residuals: np.ndarray
    monodromies: np.ndarray
    directions: np.ndarray
    special: np.ndarray = field(repr=False)

    def __len__(self) -> int:
        return len(self.phases)

    def orbit(self, k: int) -> Orbit:
        """One of the orbits."""
        return Orbit(self.arcs, self.periods, self.starts[k], float(self.phases[k]), self.durations[k])

    def values(self, d: int) -> np.ndarray:
        """Free parameters, shape (P, q)."""
        return self.starts[:, 0, d:]

    def with_point(self, k: int, orbit: Orbit, lap: "Lap", special: Special) -> "Stretch":
        """With one more orbit in place k; its arclength and direction lie between those of its neighbours."""
        share = 0.5
        before, after = self.starts[k - 1].ravel(), self.starts[k].ravel()
        length = np.linalg.norm(after - before)
        if length > 0:
            share = float(np.clip(np.linalg.norm(orbit.starts.ravel() - before) / length, 0, 1))
        new = {
            "starts": orbit.starts,
            "phases": orbit.phase,
            "durations": orbit.durations,
            "speeds": lap.speeds,
            "arclengths": (1 - share) * self.arclengths[k - 1] + share * self.arclengths[k],
            "residuals": lap.residual,
            "monodromies": lap.monodromy,
            "directions": (1 - share) * self.directions[k - 1] + share * self.directions[k],
            "special": int(special),
        }
        return replace(self, **{name: np.insert(getattr(self, name), k, value, axis=0) for name, value in new.items()})

    def part(self, points: slice) -> "Stretch":
        """Some of the points."""
        return replace(self, **{name: getattr(self, name)[points] for name in _BY_POINT})

    def reversed(self) -> "Stretch":
        """The same points in the other order."""
        back = self.part(slice(None, None, -1))
        return replace(back, arclengths=-back.arclengths, directions=-back.directions)


_BY_POINT = tuple(f.name for f in fields(Stretch) if f.name not in ("arcs", "periods"))


@dataclass(frozen=True)
class Traced:
    """A stretch, why it stopped (a code of `chaosdrill.engine.branch`), and the point that stands behind its end."""

    stretch: Stretch
    code: int
    beyond: Orbit | None


def follow_branch(
    family: "Family",
    orbit: Orbit,
    direction: np.ndarray,
    weights: np.ndarray,
    limits: tuple[float, float],
    steps: tuple[float, float],
    most: int,
) -> Traced:
    """Follow a branch in the one free parameter, for as long as its orbits are orbits of the system.

    Parameters
    ----------
    family : Family
    orbit : Orbit
        A converged one.
    direction : ndarray, shape (columns,)
        Which way to go.
    weights : ndarray, shape (columns,)
    limits : pair of float
        Of the parameter.
    steps : pair of float
        First and longest step, in the norm of the weights.
    most : int
        Points, at most.
    """
    if orbit.arcs[0, at.ARC_END] != at.PLANE:
        return _trace(family, orbit, direction, weights, limits, steps, most)
    # the plane across the flow is moved along, or the flow would come to lie in it
    pieces: list[Stretch] = []
    first, length, points = steps[0], 0.0, 0
    while True:
        traced = _trace(family, orbit, direction, weights, limits, (first, steps[1]), min(ON_PLANE, most - points) + 1)
        stretch = replace(traced.stretch, arclengths=traced.stretch.arclengths + length)
        pieces.append(stretch.part(slice(1, None)) if pieces else stretch)
        points = sum(len(p) for p in pieces)
        whole = _joined(pieces)
        rest = _through_rest(family, whole, points - len(pieces[-1]))
        if rest is not None:
            return Traced(whole.part(slice(0, rest)), REST, None)
        if traced.code != branch.MOST_POINTS or points >= most:
            return Traced(whole, traced.code, traced.beyond)
        orbit, direction = whole.orbit(points - 1), whole.directions[-1]
        first, length = float(stretch.arclengths[-1] - stretch.arclengths[-2]), float(whole.arclengths[-1])


ON_PLANE = 10
"""Points for which one plane across the flow serves."""

SHRUNK = 0.3
"""Part of its extent a few points before to which an orbit has shrunk that turns back at a point at rest."""

BEFORE = 4
"""So many points before."""

REST = 301
"""Why a trace stopped, beside the codes of `chaosdrill.engine.branch`."""


def _through_rest(family: "Family", stretch: Stretch, first: int) -> int | None:
    """Number of the first point, from ``first`` on, behind one at which the orbits have shrunk onto a point at rest.

    Beyond, the same orbits come again, half a turn later: the branch seems to turn back.
    """
    begin = max(first - BEFORE, 0)
    part = stretch.part(slice(begin, None))
    back = np.flatnonzero(part.directions[1:, -1] * part.directions[:-1, -1] < 0) + 1
    if not len(back):
        return None
    ends = part.durations.sum(axis=1)[:, np.newaxis]
    states = family.at([part.orbit(k) for k in range(len(part))], ends * np.linspace(0, 1, 33)[:-1])[0]
    extents = np.ptp(states, axis=1).max(axis=1)
    small = [k for k in back.tolist() if extents[k - 1 : k + 1].min() < SHRUNK * extents[max(k - BEFORE, 0)]]
    return begin + small[0] if small else None


def _joined(pieces: list[Stretch]) -> Stretch:
    joined: dict[str, Any] = {name: np.concatenate([getattr(p, name) for p in pieces]) for name in _BY_POINT}
    return replace(pieces[0], **joined)


def _trace(
    family: "Family",
    orbit: Orbit,
    direction: np.ndarray,
    weights: np.ndarray,
    limits: tuple[float, float],
    steps: tuple[float, float],
    most: int,
) -> Traced:
    room = most + 2
    d, count = family.states, len(orbit)
    columns = family.columns(orbit)
    starts, clocks = np.zeros((room, count, d + 1)), np.zeros((room, 2))
    durations, speeds = np.zeros((room, count)), np.zeros((room, count))
    monodromies, directions = np.zeros((room, d, d)), np.zeros((room, columns))
    figures = np.zeros((room, 3 + branch.ON_BRANCH))
    seen = np.zeros((room, count, 2), dtype=np.int64)
    starts[0], clocks[0, 0], durations[0], directions[0] = orbit.starts, orbit.phase, orbit.durations, direction
    code, points = family.trace(
        orbit, weights, np.array(limits, dtype=float), ROUND_OFF, np.array(steps, dtype=float), starts, clocks,
        durations, monodromies, speeds, directions, figures, seen,
    )  # fmt: skip
    stretch = Stretch(
        orbit.arcs, orbit.periods, starts[:points], clocks[:points, 0], durations[:points], speeds[:points],
        clocks[:points, 1], figures[:points, 0], monodromies[:points], directions[:points],
        np.zeros(points, dtype=np.int64),
    )  # fmt: skip
    beyond = None
    if code in (branch.BORDER, branch.BEYOND_LIMITS):
        beyond = replace(orbit, starts=starts[points], phase=float(clocks[points, 0]), durations=durations[points])
    return Traced(stretch, code, beyond)
