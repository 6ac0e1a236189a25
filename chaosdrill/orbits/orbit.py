"""An orbit that is looked for or was found: segments between events, in a cycle."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.engine import shooting as at
from chaosdrill.orbits.tuning import TUNING

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem


@dataclass(frozen=True)
class Orbit:
    """A closed path, or a guess of one."""

    segments: np.ndarray
    """int (N, 3): mode, the guard that ends the segment (its number in the mode, or one of the marks of
    `chaosdrill.engine.shooting`), and the transition taken there."""
    periods: int  # forcing periods that it takes; 1 for systems without a period
    starts: np.ndarray
    """(N, d + q): state at the start of every segment, after the event that ended the last; the free parameters behind
    it."""
    phase: float  # time in the period at which the first segment begins
    durations: np.ndarray  # (N,): durations of the segments
    drift: np.ndarray | None = None
    """(d,): by how much its end is shifted against its start, as `chaosdrill.orbits.shifts` has it; None: not at all"""

    def __len__(self) -> int:
        return len(self.segments)

    @property
    def eventless(self) -> bool:
        """Whether no event happens on it."""
        return bool((self.segments[:, at.SEGMENT_END] < 0).all())

    @property
    def tied(self) -> np.ndarray:
        """Which segments lie between two events in one instant, bool of shape (N,): they last as long as rounding."""
        events = self.segments[:, at.SEGMENT_END] >= 0
        return events & np.roll(events, 1) & (np.abs(self.durations) <= TUNING.same_instant * self.durations.sum())

    def in_order(self, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Times at which segments end, alike for events in one instant, and the segments that end at events, by these.

        ``times``, shape (N,): since the strobe from which events are counted.
        """
        tied, rank, times = self.tied, np.arange(len(self)), times.copy()
        if tied.any() and not tied.all():
            rank = (rank - int(tied.argmin())) % len(self)
            for i in np.argsort(rank)[1:].tolist():
                times[i] = times[i - 1] if tied[i] else times[i]
        kinds = np.flatnonzero(self.segments[:, at.SEGMENT_END] >= 0)
        return times, kinds[np.lexsort((rank[kinds], times[kinds]))]

    def reduced(self, d: int) -> np.ndarray:
        """The reduced unknowns: first start, phase, durations, parameters."""
        return np.concatenate([self.starts[0, :d], [self.phase], self.durations, self.starts[0, d:]])

    def with_values(self, values: np.ndarray, d: int) -> "Orbit":
        """The same path at other values of the free parameters, as a guess."""
        starts = self.starts.copy()
        starts[:, d:] = values
        return replace(self, starts=starts)

    def between(self, other: "Orbit", part: float) -> "Orbit":
        """The guess between this orbit and another one of the same segments."""
        return replace(
            self,
            starts=self.starts + part * (other.starts - self.starts),
            phase=self.phase + part * (other.phase - self.phase),
            durations=self.durations + part * (other.durations - self.durations),
            drift=_between(self.drift, other.drift, part),
        )

    def moved_on(self) -> np.ndarray:
        """What is added to a start, shape (d + q,), when the orbit was gone through once."""
        added = np.zeros(self.starts.shape[1])
        if self.drift is not None:
            added[: len(self.drift)] = self.drift
        return added

    def shifted(self, by: np.ndarray) -> "Orbit":
        """The same path with all states, shape (d,), shifted."""
        starts = self.starts.copy()
        starts[:, : len(by)] += by
        return replace(self, starts=starts)

    def repeated(self, times: int) -> "Orbit":
        """The same path, gone through several times."""
        if (self.segments[:, at.SEGMENT_END] == at.PLANE).all():
            drift = None if self.drift is None else times * self.drift
            return replace(self, periods=self.periods * times, durations=self.durations * times, drift=drift)
        starts = np.tile(self.starts, (times, 1))
        if self.drift is not None:
            starts += np.repeat(np.arange(times), len(self))[:, np.newaxis] * self.moved_on()
        return Orbit(
            np.tile(self.segments, (times, 1)),
            self.periods * times,
            starts,
            self.phase,
            np.tile(self.durations, times),
            None if self.drift is None else times * self.drift,
        )

    def rotated(self, first: int, period: float | None) -> "Orbit":
        """The same path, starting from another segment."""
        phase = self.phase + float(self.durations[:first].sum())
        starts = np.roll(self.starts, -first, axis=0)
        if self.drift is not None and first % len(self):
            starts[-(first % len(self)) :] += self.moved_on()
        return Orbit(
            np.roll(self.segments, -first, axis=0),
            self.periods,
            starts,
            phase % period if period else phase,
            np.roll(self.durations, -first),
            self.drift,
        )

    def events(self, system: "HybridSystem") -> list[str]:
        """Names of the events, in order."""
        ends = self.segments[self.segments[:, at.SEGMENT_END] >= 0, at.SEGMENT_OUTCOME]
        return [system.transitions[k].name for k in ends.tolist()]


def _between(one: np.ndarray | None, other: np.ndarray | None, part: float) -> np.ndarray | None:
    return one if one is None or other is None else one + part * (other - one)
