"""Stagger-and-step: states that stay near a chaotic saddle for long, where runs from anywhere leave soon.

Walkers step along the saddle together. One whose time to stay has become too short goes where another one is, drawn at
random, and small displacements part the two, sizes of all orders alike: the staggers of Sweet, Nusse and Yorke (2001,
doi:10.1103/PhysRevLett.86.2261). A displacement is taken wherever the time to stay remains long enough. As one is as
likely as its reverse, this leaves walkers distributed over such states as runs from anywhere would be (Metropolis), and
so does the exchange of those that leave. Staggers of one walker alone prefer what is near, and not what is likely.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

WALKERS = 1024
"""How many step together where they are asked for. Their mean is wrong by about one part in as many as are apart,
below its error unless most of them leave in each round."""

TRIES = 12
"""Displacements that each clone tries in a round. One that is not parted from its twin at once is later on."""

DECADES = 16.0
"""Orders of size that displacements have, from the extent of the walkers down to rounding."""

NEAR, BAND, FIRST = 0.9, 2.0, 0.1
"""Share of the displacements whose sizes are within a band, in orders of size, about that from which on the first ones
fail: it is a quantile of the sizes that do. Among all orders alike, few would be neither in vain nor without effect."""

FINE = 1e-9
"""This size, in parts of the extent, below which no longer times to stay are asked for: smaller ones come near
rounding."""

HALVINGS = 40
"""Times that half of the walkers, or more, have left by the longest time to stay that is asked for."""

FURTHER = 4
"""How many times the time to stay that is asked for runs are watched, to see how much longer they stay."""

FEWEST = 100
"""Starts among which the first walkers are drawn, if as many live a unit."""

PICTURES = 16
"""How often growth along the saddle is measured."""


class Walkers(NamedTuple):
    """States that stay for long, with their modes and the units that they stay."""

    states: np.ndarray  # (W, n)
    modes: np.ndarray  # int (W,)
    lives: np.ndarray  # int (W,)


@dataclass
class Staggers:
    """Walkers on a saddle.

    ``watch``: whole units that runs from states in modes stay, up to a number of units. ``step``: states and modes
    after a number of units. ``longest``: units for which runs may be watched. ``together``: how many walkers.
    ``most``: units that may be watched in all.
    """

    watch: Callable[[np.ndarray, np.ndarray, int], np.ndarray]
    step: Callable[[np.ndarray, np.ndarray, int], tuple[np.ndarray, np.ndarray]]
    longest: int
    together: int
    most: float
    generator: np.random.Generator
    size: float | None = None
    """That from which on displacements fail, in parts of the extent of the walkers."""
    extent: dict[int, np.ndarray] = field(default_factory=dict)
    """The largest that walkers have had in each mode, of each state."""
    taken: int = 0
    """How many displacements have been taken."""
    stayed: list[float] = field(default_factory=list)
    """Share of the walkers that could stay where they had stepped, round by round."""
    level: int = 0
    """Units that walkers stay at least."""
    stride: int = 1
    """Units of a round: half of them, or more, would leave meanwhile."""
    watched: int = 0
    """Units that have been watched in all."""

    def walk(self, begin: Walkers) -> Iterator[Walkers]:
        """Pictures of the walkers, far enough apart to tell different parts of the saddle; none if all leave at once.

        ``begin``: starts of runs.
        """
        found = self._rise(begin)
        if found is None or self.weary:
            return
        rounds = -(-self.level // (2 * self.stride))
        self.taken = 0
        for _ in range(PICTURES):
            for _ in range(rounds):
                states, modes = self.step(found.states, found.modes, self.stride)
                stepped = Walkers(states, modes, self._watch(states, modes, self.level))
                self.stayed.append(float((stepped.lives >= self.level).mean()))
                renewed = self._renew(stepped, self.level)
                if renewed is None or self.weary:
                    return
                found = renewed
            yield found

    @property
    def weary(self) -> bool:
        """Whether more has been watched than may be."""
        return self.watched > self.most

    def _rise(self, begin: Walkers) -> Walkers | None:
        """Walkers that stay as long as can be asked for."""
        sorted_lives = np.sort(begin.lives)
        self.level = max(int(sorted_lives[-min(FEWEST, len(sorted_lives))]), 1)
        drawn = np.flatnonzero(begin.lives >= self.level)
        if not len(drawn):
            return None
        drawn = self.generator.permutation(drawn)[: self.together]
        found, strides = Walkers(*(part[np.resize(drawn, self.together)].copy() for part in begin)), []
        found.lives[len(drawn) :] = 0
        for _ in range(HALVINGS):
            renewed = self._renew(found, self.level, min(FURTHER * self.level, self.longest))
            if renewed is None or self.weary or self.level >= self.longest:
                break
            if self.size is not None and self.size < FINE:
                break
            found = renewed
            level = min(max(int(np.median(found.lives)), self.level + 1), self.longest)
            if not (found.lives >= level).any():
                break
            strides.append(level - self.level)
            self.level = level
        found = Walkers(found.states, found.modes, np.minimum(found.lives, self.level))
        self.stride = int(np.median(strides)) if strides else self.level
        return self._renew(found, self.level)

    def _renew(self, walkers: Walkers, level: int, watched: int | None = None) -> Walkers | None:
        """Walkers of which all stay for a number of units, in place of those that do not; None if none does."""
        stay, gone = np.flatnonzero(walkers.lives >= level), np.flatnonzero(walkers.lives < level)
        if not len(stay):
            return None
        parents = self.generator.choice(stay, len(gone))
        for part in walkers:
            part[gone] = part[parents]
        self._widen(walkers)
        failed, everyone = [], np.arange(len(walkers.lives))
        # whoever is held where rounding has put it, such as on a fixed point, is set free
        for some in (everyone, *[gone] * (TRIES if len(gone) else 0)):
            size, near = self._sizes(len(some))
            extent = np.array([self.extent[mode] for mode in walkers.modes[some].tolist()]).reshape(
                -1, walkers.states.shape[1]
            )
            ways = self.generator.standard_normal(extent.shape)
            ways *= (size / np.linalg.norm(ways, axis=1))[:, np.newaxis] * extent
            shifted = walkers.states[some] + ways
            lives = self._watch(shifted, walkers.modes[some], level if watched is None else watched)
            take = (lives >= level) & (shifted != walkers.states[some]).any(axis=1)
            walkers.states[some[take]], walkers.lives[some[take]] = shifted[take], lives[take]
            self.taken += int(take.sum())
            failed.append(size[(lives < level) & ~near])
        fails = np.concatenate(failed)
        self.size = float(np.quantile(fails, FIRST)) if len(fails) else self.size
        return walkers

    def _watch(self, states: np.ndarray, modes: np.ndarray, units: int) -> np.ndarray:
        lives = self.watch(states, modes, units)
        self.watched += int(lives.sum())
        return lives

    def _sizes(self, count: int) -> tuple[np.ndarray, np.ndarray]:
        """Sizes of displacements, in parts of the extent, and which of them are drawn from the band."""
        size = 10.0 ** (-DECADES * self.generator.random(count))
        if self.size is None:
            return size, np.zeros(count, dtype=bool)
        near = self.generator.random(count) < NEAR
        band = self.size * 10.0 ** (BAND * (self.generator.random(count) - 0.5))
        return np.where(near, band, size), near

    def _widen(self, walkers: Walkers) -> None:
        """Take note of the extent of walkers in each mode: what is the same in all, as where it is held, remains so."""
        for mode in np.unique(walkers.modes).tolist():
            extent = np.ptp(walkers.states[walkers.modes == mode], axis=0)
            self.extent[mode] = np.maximum(extent, self.extent.get(mode, 0.0))
