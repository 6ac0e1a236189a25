"""Growth of one-dimensional invariant manifolds from a fundamental segment, with their breaks."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from chaosdrill.analysis.curves.section_map import Images, Preimage, SectionMap
from chaosdrill.analysis.tuning import CURVES
from chaosdrill.dataset.curves import CurveBreak, CurveEnd


@dataclass(frozen=True)
class Bounds:
    """How far and how finely a curve is followed; lengths in parts of the region's sides."""

    spacing: float  # largest distance of neighbouring points
    accuracy: float  # largest error of the first segment, and of the place of a break
    length: float
    points: int
    region: np.ndarray  # (2, n): lower and upper ends
    scale: np.ndarray  # (n,): its sides


@dataclass(frozen=True)
class Track:
    """Points of the first segment, and where the map has taken them: m points over k iterates."""

    sigma: np.ndarray  # (m,): place on the segment, from 0 to 1
    states: np.ndarray  # (m, k + 1, n)
    modes: np.ndarray  # int (m, k + 1)
    counts: np.ndarray  # int (m, k + 1, transitions): events since the segment, to and fro alike
    ok: np.ndarray  # bool (m, k + 1)
    shown: np.ndarray  # (m, n): the last of them, as points of the section
    error: np.ndarray  # (m,): of the last of them, across the curve, in parts of the scale; NaN while unknown

    def of(self, which: np.ndarray) -> "Track":
        """Some of the points."""
        return Track(*(getattr(self, name)[which] for name in self.__dataclass_fields__))

    def joined(self, other: "Track") -> "Track":
        """With further points, in order."""
        order = np.argsort(np.concatenate([self.sigma, other.sigma]), kind="stable")
        names = self.__dataclass_fields__
        return Track(*(np.concatenate([getattr(self, name), getattr(other, name)])[order] for name in names))


@dataclass
class Break:
    """A break of the segment's images from one iterate on."""

    low: float  # between which places on the segment it is
    high: float
    generation: int  # the first iterate that has it
    kind: CurveBreak
    jump: bool  # whether the curve is cut there
    state: np.ndarray  # (n,): next to it, before the step that breaks the curve


@dataclass(frozen=True)
class Piece:
    """One iterate of a first segment, as a part of a curve."""

    states: np.ndarray  # (m, n)
    kept: np.ndarray  # bool (m,): those that have an image and are near the region
    error: np.ndarray  # (m,)
    cut: np.ndarray  # bool (m - 1,): where neighbours are not joined
    breaks: dict[int, Break]  # by the place of the pair that it is in
    end: CurveEnd | None  # why the curve ends with this piece; None if it goes on


@dataclass(frozen=True)
class Start:
    """The first segment: a chord along the eigenvector, from a point to its image."""

    begin: np.ndarray
    end: np.ndarray
    ratio: float  # modulus by which the distance from the orbit grows over it
    error: float  # distance from the manifold, in parts of the scale
    mode: int


class Segment:
    """The images of a first segment under the map, or its inverse."""

    def __init__(self, onward: SectionMap, backward: bool, start: Start, bounds: Bounds) -> None:
        self.map, self.backward, self.start, self.bounds = onward, backward, start, bounds
        self.breaks: list[Break] = []
        self._located: set[int] = set()  # pairs between which a break is being located
        self._present: dict[int, Break] = {}  # those of the present iterate, by the place of the pair
        self.generation = 0
        far = np.abs(np.concatenate([start.begin, start.end]) / np.tile(bounds.scale, 2)).max()
        long = float(np.linalg.norm((start.end - start.begin) / bounds.scale))
        self._finest = 8 * np.finfo(float).eps * (1 + far / long) if long > 0 else 1.0
        self.track = self._seeds(np.array([0.0, 0.5, 1.0]))
        self._last_errors = (self.track.sigma, self.track.error)

    @property
    def end(self) -> np.ndarray:
        """Where the last image ends, shape (n,)."""
        return np.asarray(self.track.states[-1, -1])

    def _seeds(self, sigma: np.ndarray) -> Track:
        start, n = self.start, self.map.n
        ratio = start.ratio
        part = (ratio**sigma - 1) / (ratio - 1) if ratio != 1 else sigma
        states = start.begin + part[:, np.newaxis] * (start.end - start.begin)
        states[sigma == 1] = start.end
        modes = np.full((len(sigma), 1), start.mode)
        counts = np.zeros((len(sigma), 1, len(self.map.system.transitions)), dtype=np.int64)
        ok = np.ones((len(sigma), 1), dtype=bool)
        error = np.full(len(sigma), start.error)
        return Track(sigma, states.reshape(-1, 1, n), modes, counts, ok, states.copy(), error)

    def _longer(
        self, track: Track, states: np.ndarray, shown: np.ndarray, modes: np.ndarray, counts: np.ndarray
    ) -> Track:
        """A track with one more iterate; rows of NaN have none."""
        fine = np.isfinite(states).all(axis=1)
        return Track(
            track.sigma,
            np.concatenate([track.states, states[:, np.newaxis]], axis=1),
            np.concatenate([track.modes, modes[:, np.newaxis]], axis=1),
            np.concatenate([track.counts, (track.counts[:, -1] + counts)[:, np.newaxis]], axis=1),
            np.concatenate([track.ok, fine[:, np.newaxis]], axis=1),
            shown,
            track.error,
        )

    def _onward(self, track: Track, times: int) -> Track:
        """The next iterates of a track, ``times`` of them, by runs side by side."""
        count, n, kinds = len(track.sigma), self.map.n, len(self.map.system.transitions)
        alive = np.flatnonzero(track.ok[:, -1])
        for found in self.map.images(track.states[alive, -1], track.modes[alive, -1], times):
            states, modes = np.full((count, n), np.nan), track.modes[:, -1].copy()
            shown, counts = states.copy(), np.zeros((count, kinds), dtype=np.int64)
            states[alive], shown[alive], modes[alive] = found.states, found.shown, found.modes
            counts[alive] = np.where(found.ok[:, np.newaxis], found.counts, 0)
            track = self._longer(track, states, shown, modes, counts)
        return track

    def _back(self, track: Track, guesses: list[list[np.ndarray]] | None, first: np.ndarray | None) -> Track:
        """One more iterate of a track, backwards by Newton's method, one point after the other."""
        count, n, kinds = len(track.sigma), self.map.n, len(self.map.system.transitions)
        states, modes = np.full((count, n), np.nan), track.modes[:, -1].copy()
        counts = np.zeros((count, kinds), dtype=np.int64)
        alive = np.flatnonzero(track.ok[:, -1])
        runs = self.map.undone(track.states[alive, -1], track.modes[alive, -1]) if len(alive) else []
        undone = runs[0] if runs else None
        fine = np.zeros(len(alive), dtype=bool)
        if undone is not None:
            fine = self.map.leads_to(track.states[alive, -1], track.modes[alive, -1], undone)
            states[alive[fine]], modes[alive[fine]] = undone.states[fine], undone.modes[fine]
            counts[alive[fine]] = undone.counts[fine]
        before: tuple[np.ndarray, np.ndarray, np.ndarray] | None = None
        failures = 0
        for place, i in enumerate(alive.tolist()):
            if fine[place]:
                continue
            target = track.states[i, -1]
            if undone is not None:
                one = self._verified(undone, place, target, int(track.modes[i, -1]))
                if one is not None:
                    states[i], modes[i] = one.state, one.mode
                    counts[i] = np.bincount(one.image.kinds, minlength=kinds)[:kinds]
                continue
            tried = list(guesses[i]) if guesses is not None else []
            if guesses is None and before is None and first is not None:
                tried.append(first)
            if guesses is None and before is not None:
                state, image, jacobian = before
                tried += [state + _solved(jacobian, target - image), state]
            if guesses is None and failures >= CURVES.in_a_row:
                break
            one = self._preimage(target, int(track.modes[i, -1]), tried)
            failures = 0 if one is not None else failures + 1
            if one is None:
                continue
            states[i], modes[i] = one.state, one.mode
            counts[i] = np.bincount(one.image.kinds, minlength=kinds)[:kinds]
            before = one.state, one.image.state, one.image.jacobian
        return self._longer(track, states, states.copy(), modes, counts)

    def _run_back(self, track: Track, times: int) -> Track:
        """The next iterates of a track by runs backwards, as far as the map takes all of them to those before."""
        runs = self.map.undone(track.states[:, -1], track.modes[:, -1], times) if times > 1 else []
        if not runs:
            return track
        before = [track.states[:, -1], *(one.states for one in runs[:-1])]
        modes = [track.modes[:, -1], *(one.modes for one in runs[:-1])]
        joined = Images(*(np.concatenate([getattr(one, f) for one in runs]) for f in Images.__dataclass_fields__))
        fine = self.map.leads_to(np.concatenate(before), np.concatenate(modes), joined).reshape(times, -1).all(axis=1)
        for one in runs[: times if fine.all() else int(fine.argmin())]:
            track = self._longer(track, one.states, one.shown, one.modes, one.counts)
        return track

    def _verified(self, undone: Images, place: int, target: np.ndarray, mode: int) -> Preimage | None:
        """What a run backwards has come to, corrected until the map takes it to the target; None if it does not."""
        if not undone.ok[place]:
            return None
        begins = int(undone.modes[place])
        return self.map.preimage(target, mode, undone.states[place], self.bounds.spacing, begins)

    def _preimage(self, target: np.ndarray, mode: int, tried: list[np.ndarray]) -> Preimage | None:
        reach = 10 * self.bounds.spacing
        for guess in tried:
            if np.isfinite(guess).all() and (one := self.map.preimage(target, mode, guess, reach)) is not None:
                return one
        if self.map.resets and self.map.n == 2 and not self.map.at_events:
            # across a reset the neighbour of a preimage is elsewhere
            wide = self.bounds.region + CURVES.margin * self.bounds.scale * np.array([[-1.0], [1.0]])
            for guess in self.map.guesses(target, wide):
                if (one := self.map.preimage(target, mode, guess, reach)) is not None:
                    return one
        return None

    def advance(self, first: np.ndarray | None) -> None:
        """Go on by one iterate; backwards it begins at ``first``, where the iterate before has ended."""
        self.track = self._back(self.track, None, first) if self.backward else self._onward(self.track, 1)
        self.generation += 1

    def _follow(self, sigma: np.ndarray) -> Track:
        """All iterates of further places on the segment."""
        track, known = self._seeds(sigma), self.track
        right = np.clip(np.searchsorted(known.sigma, sigma), 1, len(known.sigma) - 1)
        part = (sigma - known.sigma[right - 1]) / (known.sigma[right] - known.sigma[right - 1])
        if not self.backward:
            return self._onward(track, self.generation)
        track = self._run_back(track, self.generation)
        for k in range(track.states.shape[1], self.generation + 1):
            a, b = known.states[right - 1, k], known.states[right, k]
            between = a + part[:, np.newaxis] * (b - a)
            track = self._back(track, [list(three) for three in zip(between, a, b, strict=True)], None)
        return track

    def grow(self, length: float, points: int) -> Piece:
        """Refine the present iterate, up to a length and a number of points."""
        end: CurveEnd | None = None
        beyond_end = []
        while True:
            sums, split, cut = self._look()
            beyond = np.flatnonzero(sums > length)
            if len(beyond) and (beyond[0] + 2 < len(self.track.sigma) or not split[: beyond[0] + 1].any()):
                end = CurveEnd.LENGTH
                keep = int(beyond[0]) + 2
                beyond_end.append(self._shorten(keep))
                split, cut = split[: keep - 1], cut[: keep - 1]
            if len(self.track.sigma) > points:
                end = CurveEnd.MOST_POINTS
                beyond_end.append(self._shorten(points))
                split, cut = split[: points - 1], cut[: points - 1]
            places = np.flatnonzero(split)
            if not len(places):
                break
            self.track = self.track.joined(self._follow(self._between(places)))
        self._thin()
        self._note_errors()
        piece = self._piece(end)
        for rest in beyond_end:
            # the other branch may go on from here
            self.track = self.track.joined(rest)
        return piece

    def _shorten(self, keep: int) -> Track:
        """Leave out all but the first points, and return the rest."""
        track = self.track
        self.track = track.of(np.arange(keep))
        return track.of(np.arange(keep, len(track.sigma)))

    def loses_rank(self) -> bool:
        """Whether the step to the present iterate loses rank."""
        place = len(self.track.sigma) // 2
        k = -1 if self.backward else -2
        if self.track.states.shape[1] < 2 or not np.isfinite(self.track.states[place, k]).all():
            return False
        image = self.map.image(self.track.states[place, k], int(self.track.modes[place, k]))
        return self.map.loses_rank(image)

    def _between(self, places: np.ndarray) -> np.ndarray:
        """Places at which chords are split: in the middle; towards a break, in as many parts as run side by side."""
        low, high = self.track.sigma[places], self.track.sigma[places + 1]
        middle = (low + high) / 2
        towards = np.array([int(i) in self._located for i in places], dtype=bool)
        parts = np.arange(1, CURVES.lanes) / CURVES.lanes
        fine = low[towards, np.newaxis] + parts * (high - low)[towards, np.newaxis]
        return np.unique(np.concatenate([middle[~towards], fine.ravel()]))

    def _look(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Lengths up to the end of each chord, which chords are to be split, and which are cuts."""
        track, bounds = self.track, self.bounds
        present = track.states[:, -1] / bounds.scale
        ok = track.ok[:, -1]
        steps = np.diff(present, axis=0)
        lengths = np.linalg.norm(steps, axis=1)
        both, one = ok[:-1] & ok[1:], ok[:-1] != ok[1:]
        wide = np.diff(track.sigma) > self._finest
        inside = ok & self._near(track.states[:, -1])
        seen = inside[:-1] | inside[1:]
        differs = both & (track.counts[:-1, -1] != track.counts[1:, -1]).any(axis=1)
        split = np.zeros(len(lengths), dtype=bool)
        cut = ~both
        corner = ~both
        suspects = np.flatnonzero((differs | one | (both & ~wide & (lengths > bounds.spacing))) & seen)
        self._present, self._located = {}, set()
        joined = CURVES.shortest * bounds.spacing
        found = {i: self._known(i) for i in suspects.tolist()}
        fresh = []
        for i in (i for i, known in found.items() if known is None):
            generation = self._first(i, one[i])
            apart = np.linalg.norm(
                (track.states[i, generation - 1] - track.states[i + 1, generation - 1]) / bounds.scale
            )
            if wide[i] and not apart <= bounds.accuracy:
                split[i] = True
                self._located.add(i)
            else:
                fresh.append((i, generation))
        found |= self._classified(fresh, one)
        for i, known in found.items():
            if known is None:
                continue
            known.low, known.high = float(track.sigma[i]), float(track.sigma[i + 1])
            corner[i] = True
            self._present[i] = known
            if known.jump:
                # what an event before or behind the strobe has parted is one motion again a step later
                cut[i] = not lengths[i] <= joined
            elif lengths[i] > bounds.spacing:
                split[i] |= bool(wide[i])
                cut[i] |= not wide[i]
        smooth = both & ~corner & seen
        split |= smooth & (lengths > bounds.spacing) & wide
        turned = self._bent(steps, lengths, smooth)
        split |= turned & wide
        sums = np.cumsum(np.where(both & ~cut & seen, lengths, 0.0))
        return sums, split, cut | ~seen

    def _bent(self, steps: np.ndarray, lengths: np.ndarray, smooth: np.ndarray) -> np.ndarray:
        """Which chords are too long for how much the curve turns at their ends."""
        bounds, found = self.bounds, np.zeros(len(lengths), dtype=bool)
        angles = angles_between(steps, lengths)
        joined = smooth[:-1] & smooth[1:]
        longer = np.maximum(lengths[:-1], lengths[1:])
        bad = joined & ((angles > CURVES.bend) | (angles * longer > CURVES.bow * bounds.spacing))
        shortest = CURVES.shortest * bounds.spacing
        found[:-1] |= bad & (lengths[:-1] > np.maximum(shortest, longer / 2))
        found[1:] |= bad & (lengths[1:] > np.maximum(shortest, longer / 2))
        return found

    def _near(self, states: np.ndarray) -> np.ndarray:
        """Which states are in the region or close to it."""
        low, high = self.bounds.region
        edge = CURVES.margin * self.bounds.scale
        with np.errstate(invalid="ignore"):
            return np.asarray(((states >= low - edge) & (states <= high + edge)).all(axis=1))

    def _known(self, i: int) -> Break | None:
        """The break that is known between a point and the next."""
        a, b = self.track.sigma[i], self.track.sigma[i + 1]
        return next((one for one in self.breaks if one.low < b and a < one.high), None)

    def _first(self, i: int, ended: bool) -> int:
        """The first iterate in which a point and the next differ."""
        track = self.track
        differs = (track.counts[i] != track.counts[i + 1]).any(axis=1)
        if ended:
            differs |= track.ok[i] != track.ok[i + 1]
        return int(np.argmax(differs)) if differs.any() else self.generation

    def _classified(self, fresh: list[tuple[int, int]], ended: np.ndarray) -> dict[int, Break]:
        """Breaks located between points and the next, by what both sides and points farther from them show.

        ``fresh``: places and generations. ``ended``: whether one side has no image, at every place.
        """
        track, bounds, found = self.track, self.bounds, {}
        sigma, at = track.sigma, 0 if self.backward else -1
        whole = [i for i, _ in fresh if not ended[i]]
        low, high = sigma[whole], sigma[[i + 1 for i in whole]]
        away = CURVES.beside * (high - low)
        # where the segment ends close by, the probe is the end
        places = np.concatenate([np.maximum(low - away, 0.0), np.minimum(high + away, 1.0)])
        probes = self._follow(places) if whole else None
        for i, generation in fresh:
            a, b = float(sigma[i]), float(sigma[i + 1])
            source = track.states[[i, i + 1], generation + at]
            if probes is None or ended[i]:
                kind = CurveBreak.NO_PREIMAGE if self.backward else CurveBreak.NO_IMAGE
                found[i] = Break(a, b, generation, kind, True, source[0 if track.ok[i, generation] else 1].copy())
                continue
            k = whole.index(i)
            beside = probes.states[[k, k + len(whole)]]
            here = np.linalg.norm((track.states[i, generation] - track.states[i + 1, generation]) / bounds.scale)
            wide = np.linalg.norm((beside[0, generation] - beside[1, generation]) / bounds.scale)
            jump = not here * CURVES.continuous < wide
            kind = self._kind(source, beside[:, generation + at], track.modes[[i, i + 1], generation + at])
            found[i] = Break(a, b, generation, kind, bool(jump), source[0].copy())
        self.breaks += found.values()
        return found

    def _kind(self, sides: np.ndarray, beside: np.ndarray, modes: np.ndarray) -> CurveBreak:
        """What breaks the curve, by the events on both sides of it and farther away on each."""
        near = [self.map.image(state, int(mode)) for state, mode in zip(sides, modes, strict=True)]
        kinds = [one.kinds.tolist() for one in near]
        if kinds[0] == kinds[1]:
            return CurveBreak.UNEXPLAINED
        more = int(len(kinds[1]) > len(kinds[0]))
        long, short = kinds[more], kinds[1 - more]
        if len(long) == len(short) or not np.isfinite(beside[more]).all():
            return CurveBreak.CHANGE_OF_EVENTS
        away = self.map.image(beside[more], int(modes[more]))
        if away.kinds.tolist() != long:
            return CurveBreak.CHANGE_OF_EVENTS
        # those that are left out may be any that leave the same names
        count = len(long) - len(short)
        for first in range(len(short) + 1):
            further = slice(first, first + count)
            slower = near[more].speeds[further] * CURVES.continuous < away.speeds[further]
            if long[:first] + long[first + count :] == short and slower.any():
                return CurveBreak.GRAZING
        return CurveBreak.CHANGE_OF_EVENTS

    def _thin(self) -> None:
        """Drop points that neighbours can do without, as where an iterate is shorter than the one before."""
        while True:
            track, bounds = self.track, self.bounds
            count = len(track.sigma)
            if count < 5:
                return
            steps = np.diff(track.states[:, -1] / bounds.scale, axis=0)
            lengths = np.linalg.norm(steps, axis=1)
            angles = angles_between(steps, lengths)
            ok = track.ok[:, -1]
            both = lengths[:-1] + lengths[1:]
            spare = ok[:-2] & ok[1:-1] & ok[2:] & (both < CURVES.thin * bounds.spacing)
            # of a chord that is twice as long the angles are twice as large
            spare &= (angles < CURVES.thin * CURVES.bend / 2) & (
                angles * both < CURVES.thin * CURVES.bow * bounds.spacing / 2
            )
            for one in self.breaks:
                spare[(track.sigma[1:-1] >= one.low) & (track.sigma[1:-1] <= one.high)] = False
            spare[1::2] = False
            dropped = np.flatnonzero(spare) + 1
            if len(dropped) < count / 16:
                return
            kept = np.ones(count, dtype=bool)
            kept[dropped] = False
            self.track = track.of(kept)

    def _note_errors(self) -> None:
        """Errors across the curve: those of the iterate before, as the tangent map carries them, and the step's own."""
        if self.generation == 0:
            return
        track, scale = self.track, self.bounds.scale
        error, known = track.error.copy(), self._errors_before()
        own = self.map.numerics.global_error * np.abs(track.states[:, -1] / scale).max(axis=1, initial=0.0)
        before, after = (_tangents(track.states[:, k] / scale) for k in (-2, -1))
        at = -1 if self.backward else -2
        ok = np.flatnonzero(track.ok[:, -1])
        matrices = np.array(
            [self.map.image(track.states[i, at], int(track.modes[i, at])).jacobian for i in ok.tolist()]
        )
        matrices = matrices.reshape(-1, self.map.n, self.map.n) * scale / scale[:, np.newaxis]
        fine = (
            np.isfinite(matrices).all(axis=(1, 2))
            & np.isfinite(before[ok]).all(axis=1)
            & np.isfinite(after[ok]).all(axis=1)
        )
        error[ok[~fine]] = known[ok[~fine]]
        ok, matrices = ok[fine], matrices[fine]
        if self.backward:
            matrices = np.linalg.pinv(matrices, rcond=np.finfo(float).eps)
        across = matrices - np.einsum("kij,kj,kl->kil", matrices, before[ok], before[ok])
        across -= np.einsum("ki,kj,kjl->kil", after[ok], after[ok], across)
        grows = np.linalg.norm(across, 2, axis=(1, 2))
        error[ok] = grows * (known[ok] + own[ok]) if self.backward else grows * known[ok] + own[ok]
        self.track = replace(track, error=error)
        self._last_errors = (track.sigma, error)

    def _errors_before(self) -> np.ndarray:
        """Errors of the iterate before at the present points; between those of its own the larger one."""
        sigma, errors = self._last_errors
        right = np.clip(np.searchsorted(sigma, self.track.sigma), 0, len(sigma) - 1)
        left = np.clip(right - 1, 0, None)
        exact = sigma[right] == self.track.sigma
        return np.asarray(np.where(exact, errors[right], np.fmax(errors[left], errors[right])))

    def _piece(self, end: CurveEnd | None) -> Piece:
        track = self.track
        _, _, cut = self._look()
        kept = track.ok[:, -1] & self._near(track.states[:, -1])
        if end is None and not track.ok[:, -1].any():
            end = CurveEnd.NO_PREIMAGE if self.backward else CurveEnd.NO_IMAGE
        breaks = {i: one for i, one in self._present.items() if (kept[i] or kept[i + 1]) and (cut[i] or not one.jump)}
        return Piece(track.shown, kept, track.error, cut, breaks, end)


def _solved(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    try:
        return np.asarray(np.linalg.lstsq(matrix, right, rcond=None)[0])
    except np.linalg.LinAlgError:
        return np.full(len(right), np.nan)


def angles_between(steps: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    """Angles between neighbouring chords, shape (chords - 1,); 0 where one has no length."""
    units = steps / np.where(lengths > 0, lengths, 1.0)[:, np.newaxis]
    # the half angle by its tangent: an arc cosine knows small angles to 1e-8 only
    apart = np.linalg.norm(units[1:] - units[:-1], axis=1)
    along = np.linalg.norm(units[1:] + units[:-1], axis=1)
    return np.asarray(2 * np.arctan2(apart, along))


def _tangents(states: np.ndarray) -> np.ndarray:
    """Unit tangents of a curve at its points, by those on both sides; shape (m, n)."""
    ahead = np.vstack([states[1:], states[-1:]])
    behind = np.vstack([states[:1], states[:-1]])
    ahead = np.where(np.isfinite(ahead), ahead, states)
    behind = np.where(np.isfinite(behind), behind, states)
    steps = ahead - behind
    lengths = np.linalg.norm(steps, axis=1)
    return np.asarray(steps / np.where(lengths > 0, lengths, np.nan)[:, np.newaxis])


@dataclass
class Curve:
    """One branch, as it has grown so far."""

    side: int
    pieces: list[Piece] = field(default_factory=list)
    length: float = 0.0
    points: int = 0
    end: CurveEnd | None = None
    longest: float = 0.0
    away: int = 0  # iterates of the first segment in a row that were outside the region


def grow(
    segments: dict[int, Segment], flips: bool, bounds: Bounds, report: Callable[[int], None] | None
) -> dict[int, Curve]:
    """Grow both branches from their first segments, ``{-1: ..., 1: ...}``; they take turns where sides ``flip``."""
    curves = {side: Curve(side) for side in segments}
    for generation in range(CURVES.generations + 1):
        going = [side for side, curve in curves.items() if curve.end is None]
        if not going:
            break
        turned = flips and generation % 2 == 1
        ends = {side: one.end.copy() for side, one in segments.items()}
        for side, segment in segments.items():
            if generation and (flips or side in going):
                segment.advance(ends[-side if flips else side])
        for side in going:
            curve, segment = curves[side], segments[-side if turned else side]
            piece = segment.grow(bounds.length - curve.length, max(bounds.points - curve.points, 2))
            _add(curve, piece, segment, bounds)
            if report is not None:
                report(sum(one.points for one in curves.values()))
    for curve in curves.values():
        curve.end = CurveEnd.MOST_ITERATES if curve.end is None else curve.end
    return curves


def _add(curve: Curve, piece: Piece, segment: Segment, bounds: Bounds) -> None:
    """Add an iterate of the first segment to a branch, and see whether it ends there."""
    steps = np.linalg.norm(np.diff(piece.states / bounds.scale, axis=0), axis=1)
    new = float(steps[~piece.cut].sum())
    curve.pieces.append(piece)
    curve.length += new
    curve.points += int(piece.kept.sum())
    curve.away = 0 if piece.kept.any() else curve.away + 1
    curve.end = piece.end
    if curve.end is None and curve.points >= bounds.points:
        curve.end = CurveEnd.MOST_POINTS
    if curve.end is None and curve.away >= CURVES.away:
        curve.end = CurveEnd.LEFT
    if curve.end is None and not curve.away and new <= bounds.accuracy and new < curve.longest:
        curve.end = CurveEnd.RANK_LOSS if segment.loses_rank() else CurveEnd.LIMIT_SET
    curve.longest = max(curve.longest, new)
