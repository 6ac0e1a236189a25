"""Shifts of states that a system does not notice: an orbit closes but for them.

A runner is as far ahead after every step, and a rotor has turned: the foot place and the angle are not what they were,
but nothing tells the difference. Such an orbit is periodic in the quotient by the group of shifts (relative periodic
orbit: Cvitanovic, Artuso, Mainieri, Tanner and Vattay, Chaos: Classical and Quantum, chapter "Relativity for
cyclists"). By how much it is shifted in one period, its drift, follows along directions; of angles it is a whole
number of turns.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.engine.structure import symmetries_of, turns_of

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem
    from chaosdrill.orbits.orbit import Orbit
    from chaosdrill.orbits.problem import Problem


@dataclass(frozen=True)
class Shifts:
    """The group of shifts of a system with d states."""

    lines: np.ndarray
    """(m, d): directions along which states may be shifted by anything; in each the first entry that is not 0 is 1, and
    the others have 0 there."""
    turns: np.ndarray  # (k, d): shifts of which whole multiples may be taken; of no line, and of different states

    def __bool__(self) -> bool:
        return bool(len(self.lines) or len(self.turns))

    def among(self, states: int) -> "Shifts":
        """The same of a system that has more states, behind the others, which are not shifted."""
        lines, turns = (np.pad(one, ((0, 0), (0, states - one.shape[1]))) for one in (self.lines, self.turns))
        return Shifts(lines, turns)

    @cached_property
    def firsts(self) -> np.ndarray:
        """int (m,): the first entry of every line."""
        return np.array([int(np.flatnonzero(line)[0]) for line in self.lines], dtype=np.int64)

    @cached_property
    def moves(self) -> np.ndarray:
        """bool (d,): which states are shifted."""
        return np.asarray((self.lines != 0).any(axis=0) | (self.turns != 0).any(axis=0))

    @cached_property
    def _rows(self) -> np.ndarray:
        """(k, d): products with them are parts of a turn."""
        return self.turns / (self.turns**2).sum(axis=1, keepdims=True)

    def part(self, difference: np.ndarray) -> np.ndarray:
        """The shift nearest to differences of states, shape (..., d)."""
        along = difference[..., self.firsts] @ self.lines
        if not len(self.turns):
            return np.asarray(along)
        return np.asarray(along + np.rint((difference - along) @ self._rows.T) @ self.turns)

    def across(self, difference: np.ndarray) -> np.ndarray:
        """What is left of differences of states, shape (..., d), without the shift nearest to them."""
        return difference - self.part(difference) if self else difference

    def still(self, path: np.ndarray) -> np.ndarray:
        """States along a path, shape (T, d), without how far they are along lines from its first."""
        return self.beside(path - path[0]) + path[0] if len(self.lines) else path

    def beside(self, change: np.ndarray) -> np.ndarray:
        """Changes of states, shape (..., d), without what of them is along lines."""
        return np.asarray(change - change[..., self.firsts] @ self.lines)

    def extent(self, states: np.ndarray) -> np.ndarray:
        """Extent of every state among states, shape (m, d), without shifts, shape (d,)."""
        return np.asarray(np.ptp(self.across(states - states[0]) if self else states, axis=0))


def drift_of(problem: "Problem", orbit: "Orbit", residual: float) -> np.ndarray:
    """By how much an orbit is shifted in one period, and the error of that, shape (2, d).

    The error is that of the method and of the closing of the orbit, relative to the sizes of the states.
    """
    d = problem.states
    drift = np.zeros(d) if orbit.drift is None else orbit.drift
    size = np.maximum(problem.sizes, np.abs(orbit.starts[:, :d]).max(axis=0) + np.abs(drift))
    along = (problem.shifts.lines != 0).any(axis=0)
    return np.array([drift, np.where(along, (residual + problem.accuracy) * size, 0.0)])


def shifts_of(system: "HybridSystem") -> Shifts:
    """The shifts of a system, derived once for all values of its parameters."""
    known: Shifts | None = system.shared.get("shifts")
    if known is None:
        d = len(system.state_names)
        lines = np.reshape(np.array(symmetries_of(system), dtype=float), (-1, d))
        turns = np.reshape(np.array(turns_of(system), dtype=float), (-1, d))
        kept: list[np.ndarray] = []
        for rest in sorted(Shifts(lines, turns).beside(turns), key=np.count_nonzero):
            if rest.any() and not any(rest[other != 0].any() for other in kept):
                kept.append(rest)
        known = system.shared["shifts"] = Shifts(lines, np.reshape(np.array(kept), (-1, d)))
    return known
