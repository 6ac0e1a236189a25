"""What has been followed: segments of one sequence of events, special points, branches of them."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from chaosdrill.dataset.branches import BranchEnd, Special
from chaosdrill.orbits.curve import Curve
from chaosdrill.orbits.multipliers import Spectra, spectra
from chaosdrill.orbits.orbit import Orbit
from chaosdrill.orbits.points import Point
from chaosdrill.orbits.results import NO_FORM, NO_GRAZING, GrazingForm, NormalForm


@dataclass(frozen=True)
class BranchSegment:
    """Points of a curve that share one sequence of events, and the rank of their tangent maps."""

    curve: Curve
    points: Sequence[Point]
    rank: int
    family: bool = False  # whether they are all at one value of the parameter, and a multiplier is 1

    def __len__(self) -> int:
        return len(self.points)

    def orbit(self, k: int) -> Orbit:
        """One of the orbits."""
        return self.points[k].orbit

    @cached_property
    def values(self) -> np.ndarray:
        """Free parameters, shape (P, q)."""
        return np.array([self.curve.values(p.orbit) for p in self.points])

    @cached_property
    def arclengths(self) -> np.ndarray:
        """Shape (P,)."""
        return np.array([p.arclength for p in self.points])

    @cached_property
    def tangents(self) -> np.ndarray:
        """Directions along the curve, shape (P, columns)."""
        return np.array([p.tangent.change for p in self.points])

    @cached_property
    def monodromies(self) -> np.ndarray:
        """Shape (P, d, d)."""
        return np.array([p.shot.monodromy for p in self.points])

    @cached_property
    def spectra(self) -> Spectra:
        """The multipliers of all orbits."""
        factors = np.array([p.shot.factors for p in self.points])
        orbits = [p.orbit for p in self.points]
        return spectra(self.curve.problem, orbits, self.monodromies, factors, self.rank)

    @cached_property
    def durations(self) -> np.ndarray:
        """Shape (P, N)."""
        return np.array([p.orbit.durations for p in self.points])

    @cached_property
    def speeds(self) -> np.ndarray:
        """Shape (P, N)."""
        return np.array([p.shot.speeds for p in self.points])

    def with_points(self, points: Sequence[Point]) -> "BranchSegment":
        """A copy with other points and the same events."""
        return replace(self, points=points)

    def reversed(self) -> "BranchSegment":
        """The same points in reverse order."""
        return self.with_points([p.turned() for p in reversed(self.points)])


@dataclass(frozen=True)
class Mark:
    """A special point: its segment and index, its kind, its error, and how many multipliers are on the circle."""

    segment: int
    point: int
    kind: Special
    error: float
    text: str
    multiplicity: int = 0  # where events change, multipliers jump
    form: NormalForm = NO_FORM  # what is born there
    grazing: GrazingForm = NO_GRAZING  # what follows where events change at no speed


@dataclass
class Branch:
    """A branch or curve that has been followed."""

    segments: list[BranchSegment] = field(default_factory=list)  # in order
    marks: list[Mark] = field(default_factory=list)
    again: list[Mark] = field(default_factory=list)  # of points that are marked where a way first leads through them
    end: BranchEnd = BranchEnd.MOST_POINTS
    words: str = BranchEnd.MOST_POINTS.advice  # the end in words
    parent: int = -1  # index of the parent branch; -1 if it did not start on a branch
    start: str = ""  # description of its start
    born: float = float("nan")  # parameter at the doubling where it starts; NaN if it did not start on a branch

    def __len__(self) -> int:
        return sum(len(s) for s in self.segments)

    @property
    def arclength(self) -> float:
        """How far it was followed."""
        return self.segments[-1].points[-1].arclength if self.segments else 0.0

    def ended(self, end: BranchEnd, words: str = "") -> "Branch":
        """This branch with the given end, described by default in the words of that end."""
        self.end, self.words = end, words or end.advice
        return self

    def orbit(self, mark: Mark) -> Orbit:
        """The orbit at a mark."""
        return self.segments[mark.segment].orbit(mark.point)

    def value(self, mark: Mark) -> float:
        """The first free parameter there."""
        return float(self.segments[mark.segment].values[mark.point, 0])

    def joined(self, backward: "Branch") -> "Branch":
        """One branch from two halves that share their first point."""
        lengths = [len(s) for s in backward.segments]
        count = len(lengths)
        marks = [
            replace(m, segment=count - 1 - m.segment, point=lengths[m.segment] - 1 - m.point)
            for m in reversed(backward.marks)
        ]
        marks += [replace(m, segment=count + m.segment, point=m.point - int(m.segment == 0)) for m in self.marks]
        segments = [s.reversed() for s in reversed(backward.segments)]
        first = self.segments[0]
        segments += [first.with_points(first.points[1:]), *self.segments[1:]]
        origin = segments[0].points[0].arclength
        segments = [s.with_points([replace(p, arclength=p.arclength - origin) for p in s.points]) for s in segments]
        words = self.words
        if backward.words != words:
            words = f"{words.removesuffix('.')}; at its start: {backward.words}"
        return Branch(segments, marks, end=self.end, words=words)
