"""Shifts of states that a system does not notice: an orbit closes, and a record is judged, but for them.

A runner is as far ahead after every step, and a rotor has turned: the foot place and the angle are not what they were,
but nothing tells the difference. Such an orbit is periodic in the quotient by the group of shifts (relative periodic
orbit: Cvitanovic, Artuso, Mainieri, Tanner and Vattay, Chaos: Classical and Quantum, chapter "Relativity for
cyclists"). By how much it is shifted in one period, its drift, follows along directions; of angles it is a whole
number of turns. Coordinates of the quotient are combinations of states that no shift changes, and the two of a circle
for every turn, which do not distinguish its points.
"""

import math
from collections.abc import Collection
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.engine.structure import lines_of, turns_of

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem


@dataclass(frozen=True)
class Shifts:
    """The group of shifts of a system with d states."""

    lines: np.ndarray
    """(m, d): directions along which states may be shifted by anything; in each the first entry that is not 0 is 1, and
    the others have 0 there."""
    turns: np.ndarray  # (k, d): shifts of which whole multiples may be taken; of no line, and of different states

    @classmethod
    def none(cls, states: int) -> "Shifts":
        """Those of a system in which every shift makes a difference."""
        return cls(*np.zeros((2, 0, states)))

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

    @cached_property
    def _circles(self) -> list[tuple[int, float]]:
        """For every turn the first state that it shifts, and the radius of the circle that this state runs round."""
        firsts = [int(np.flatnonzero(turn)[0]) for turn in self.turns]
        return [(i, abs(float(turn[i])) / (2 * math.pi)) for i, turn in zip(firsts, self.turns, strict=True)]

    @cached_property
    def bounded(self) -> np.ndarray:
        """bool (d + k,): which coordinates of the quotient are those of circles."""
        found = np.zeros(self.lines.shape[1] + len(self.turns), dtype=bool)
        found[self.lines.shape[1] :] = True
        found[[i for i, _ in self._circles]] = True
        return found

    def _linear(self, states: np.ndarray) -> np.ndarray:
        """Combinations of states that no shift changes, but for the first state of every turn."""
        found = self.beside(states)
        for turn, (i, _) in zip(self.turns, self._circles, strict=True):
            others = np.where(np.arange(len(turn)) == i, 0.0, turn / turn[i])
            found = found - found[..., i, np.newaxis] * others
        return found

    def quotient(self, states: np.ndarray) -> np.ndarray:
        """Coordinates of states, shape (..., d), in the quotient, shape (..., d + k), in units of the states.

        Along a line the first state is 0. An angle is the cosine of its turn, at the radius of the circle; the sines
        stand behind the states.
        """
        if not self:
            return states
        found = self._linear(states)
        sines = []
        for i, radius in self._circles:
            sines.append(radius * np.sin(found[..., i] / radius))
            found[..., i] = radius * np.cos(found[..., i] / radius)
        return np.concatenate([found, *(one[..., np.newaxis] for one in sines)], axis=-1)

    def rates(self, state: np.ndarray, rates: np.ndarray) -> np.ndarray:
        """Rates of these coordinates, shape (d + k,), from those of the states, shape (d,), at a state."""
        place, found = self._linear(state), self._linear(rates)
        turning = []
        for i, radius in self._circles:
            turning.append(math.cos(place[i] / radius) * found[i])
            found[i] *= -math.sin(place[i] / radius)
        return np.append(found, turning)

    def sizes(self, known: np.ndarray) -> np.ndarray:
        """Sizes that these coordinates have had, shape (..., d + k), from those of the states, shape (..., d).

        They are at least those of which the coordinates are differences, and so have the rounding.
        """
        if not self:
            return known
        found, sines = np.array(known, dtype=float), []
        for line, i in zip(self.lines, self.firsts, strict=True):
            found = np.maximum(found, known[..., i, np.newaxis] * np.abs(line))
        for turn, (i, radius) in zip(self.turns, self._circles, strict=True):
            others = np.where(np.arange(len(turn)) == i, 0.0, np.abs(turn / turn[i]))
            found = np.maximum(found, found[..., i, np.newaxis] * others)
            sines.append(found[..., i].copy())
            found[..., i] = np.maximum(found[..., i], radius)
        return np.concatenate([found, *(one[..., np.newaxis] for one in sines)], axis=-1)

    def extent(self, states: np.ndarray) -> np.ndarray:
        """Extent of every state among states, shape (m, d), without shifts, shape (d,)."""
        return np.asarray(np.ptp(self.across(states - states[0]) if self else states, axis=0))


def shifts_of(system: "HybridSystem", *, but_of: Collection[str] | None = None) -> Shifts:
    """The shifts of a system with its parameters, without turns whose lengths change with those of ``but_of``; by
    default with any of them."""
    changing = frozenset(system.parameters if but_of is None else but_of)
    key = ("shifts", changing)
    lengths = tuple(turns_of(system, changing))
    known: tuple[object, Shifts] | None = system.shared.get(key)
    if known is None or known[0] != lengths:
        d = len(system.state_names)
        lines = np.reshape(np.array(lines_of(system), dtype=float), (-1, d))
        turns = np.reshape(np.array(lengths, dtype=float), (-1, d))
        kept: list[np.ndarray] = []
        for rest in sorted(Shifts(lines, turns).beside(turns), key=np.count_nonzero):
            if rest.any() and not any(rest[other != 0].any() for other in kept):
                kept.append(rest)
        known = system.shared[key] = (lengths, Shifts(lines, np.reshape(np.array(kept), (-1, d))))
    return known[1]
