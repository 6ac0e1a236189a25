"""An orbit that is looked for or was found: arcs between events, in a cycle."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.engine import lap

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem


@dataclass(frozen=True)
class Orbit:
    """A closed path, or a guess of one.

    Attributes
    ----------
    arcs : ndarray of int, shape (N, 3)
        Mode, the guard that ends the arc (its number in the mode, or one of the marks of `chaosdrill.engine.lap`), and
        the transition taken there.
    periods : int
        Forcing periods that it takes; 1 for systems without a period.
    starts : ndarray, shape (N, d + q)
        State at the start of every arc, after the event that ended the last; the free parameters behind it.
    phase : float
        Time in the period at which the first arc begins.
    durations : ndarray, shape (N,)
        Durations of the arcs.
    """

    arcs: np.ndarray
    periods: int
    starts: np.ndarray
    phase: float
    durations: np.ndarray

    def __len__(self) -> int:
        return len(self.arcs)

    @property
    def eventless(self) -> bool:
        """Whether no event happens on it."""
        return bool((self.arcs[:, lap.ARC_END] < 0).all())

    def same_events(self, other: "Orbit") -> bool:
        """Whether both go through the same arcs, in the same order."""
        return self.periods == other.periods and np.array_equal(self.arcs, other.arcs)

    def reduced(self, d: int) -> np.ndarray:
        """The reduced unknowns: first start, phase, durations, parameters."""
        return np.concatenate([self.starts[0, :d], [self.phase], self.durations, self.starts[0, d:]])

    def with_values(self, values: np.ndarray, d: int) -> "Orbit":
        """The same path at other values of the free parameters, as a guess."""
        starts = self.starts.copy()
        starts[:, d:] = values
        return replace(self, starts=starts)

    def between(self, other: "Orbit", part: float) -> "Orbit":
        """The guess between this orbit and another one of the same arcs."""
        return replace(
            self,
            starts=self.starts + part * (other.starts - self.starts),
            phase=self.phase + part * (other.phase - self.phase),
            durations=self.durations + part * (other.durations - self.durations),
        )

    def repeated(self, times: int) -> "Orbit":
        """The same path, gone through several times."""
        if (self.arcs[:, lap.ARC_END] == lap.PLANE).all():
            return replace(self, periods=self.periods * times, durations=self.durations * times)
        return Orbit(
            np.tile(self.arcs, (times, 1)),
            self.periods * times,
            np.tile(self.starts, (times, 1)),
            self.phase,
            np.tile(self.durations, times),
        )

    def comes_again(self, step: int, within: float) -> bool:
        """Whether the path is the same from so many arcs later on, within a part of the size of the states."""
        size = np.maximum(np.abs(self.starts).max(axis=0), 1e-6)
        turned = np.abs(np.roll(self.starts, step, axis=0) - self.starts) / size
        return bool(np.array_equal(np.roll(self.arcs, step, axis=0), self.arcs) and turned.max() < within)

    def rotated(self, first: int, period: float | None) -> "Orbit":
        """The same path, told from another arc on."""
        phase = self.phase + float(self.durations[:first].sum())
        return Orbit(
            np.roll(self.arcs, -first, axis=0),
            self.periods,
            np.roll(self.starts, -first, axis=0),
            phase % period if period else phase,
            np.roll(self.durations, -first),
        )

    def events(self, system: "HybridSystem") -> str:
        """Names of the events, in order."""
        return " ".join(system.transitions[k].name for k in self.arcs[self.arcs[:, lap.ARC_END] >= 0, lap.ARC_OUTCOME])
