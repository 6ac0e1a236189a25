"""Rounds pieced together from motions that do not stay long enough to return."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice

import numpy as np

from chaosdrill.orbits.tuning import TUNING


@dataclass(frozen=True)
class Piece:
    """A motion from one recorded state to the next."""

    record: int  # number of the record
    index: int  # of the state with which it begins
    kinds: tuple[int, int, int]  # kind of the state, sequence of events on the way, kind of the next state


class Pieces:
    """Pieces of motions, and how well one goes on from another.

    On a set from which motions escape, each record follows it for a few states only; a round that is made of pieces of
    several of them is a guess for multiple shooting all the same (pseudo-orbits; Auerbach et al. 1987,
    doi:10.1103/PhysRevLett.58.2387, need returns of one motion).

    ``states``, ``kinds``, ``sequences``: of every record, as in `chaosdrill.orbits.search.Record`. ``extent``, shape
    (d,): extent of the motion in every state. ``lasting``: number of records, from the first, of motions that do not
    escape: their pieces come first.
    """

    def __init__(
        self,
        states: Sequence[np.ndarray],
        kinds: Sequence[np.ndarray],
        sequences: Sequence[np.ndarray],
        extent: np.ndarray,
        lasting: int,
    ) -> None:
        found: dict[tuple[int, int, int], list[tuple[int, int, int]]] = {}
        for r, (kind, sequence) in enumerate(zip(kinds, sequences, strict=True)):
            last = len(kind) - 1
            for j in range(last):
                # what has come from within and stays within is nearest to what always does
                inner = last if r < lasting else min(j, last - 1 - j)
                found.setdefault((int(kind[j]), int(sequence[j + 1]), int(kind[j + 1])), []).append((-inner, r, j))
        least, largest = TUNING.pieces_of_one
        most = min(max(least, TUNING.pieces // max(1, len(found))), largest)
        self.groups = sorted(found)
        self.pieces = [[Piece(r, j, g) for _, r, j in sorted(found[g])[:most]] for g in self.groups]
        starts = [np.array([states[p.record][p.index] for p in group]) for group in self.pieces]
        ends = [np.array([states[p.record][p.index + 1] for p in group]) for group in self.pieces]
        self._gaps: dict[tuple[int, int], np.ndarray] = {}
        for a, before in enumerate(self.groups):
            for b, after in enumerate(self.groups):
                if before[2] == after[0]:
                    apart = np.abs(ends[a][:, np.newaxis] - starts[b]) / extent
                    self._gaps[a, b] = apart.max(axis=2)

    def words(self, length: int, most: int) -> Iterator[tuple[int, ...]]:
        """Cyclic sequences of groups, each once, in which ``most`` pieces begin with the most frequent kind."""
        follow = [[b for b in range(len(self.groups)) if (a, b) in self._gaps] for a in range(len(self.groups))]
        stack: list[tuple[int, ...]] = [(a,) for a in reversed(range(len(self.groups)))]
        while stack:
            word = stack.pop()
            if len(word) < length:
                # the least of all cyclic shifts begins with its least letter
                stack.extend((*word, b) for b in reversed(follow[word[-1]]) if b >= word[0])
                continue
            closes = word[0] in follow[word[-1]] and word == min(word[i:] + word[:i] for i in range(length))
            if closes and max(Counter(self.groups[a][0] for a in word).values()) == most:
                yield word

    def rounds(self, length: int, most: int) -> Iterator[list[tuple[float, tuple[Piece, ...]]]]:
        """Closed sequences of ``length`` pieces and the sum of their gaps: the best of each word, then its next.

        ``most`` is as for `words`.
        """
        tables = [self._closed(word) for word in islice(self.words(length, most), TUNING.words)]
        for turn in range(max(map(len, tables), default=0)):
            yield sorted((t[turn] for t in tables if turn < len(t)), key=lambda pair: pair[0])

    def _closed(self, word: tuple[int, ...]) -> list[tuple[float, tuple[Piece, ...]]]:
        """For every piece of the first group the round through it with the smallest sum of gaps, the best first."""
        first = len(self.pieces[word[0]])
        sums = np.where(np.eye(first, dtype=bool), 0.0, np.inf)
        came: list[np.ndarray] = []
        for a, b in zip(word, (*word[1:], word[0]), strict=True):
            ways = sums[:, :, np.newaxis] + self._gaps[a, b]
            came.append(ways.argmin(axis=1))
            sums = ways.min(axis=1)
        best: dict[tuple[Piece, ...], float] = {}
        for start in np.argsort(np.diagonal(sums), kind="stable").tolist():
            places = [start]
            for choice in reversed(came):
                places.append(int(choice[start, places[-1]]))
            chosen = places[:0:-1]
            whole = tuple(self.pieces[g][p] for g, p in zip(word, chosen, strict=True))
            least = min(
                (whole[i:] + whole[:i] for i in range(len(whole))), key=lambda w: [(p.record, p.index) for p in w]
            )
            best.setdefault(least, float(sums[start, start]))
        return [(gap, whole) for whole, gap in best.items()]
