"""The map from one point of a section to the next, of many points at a time, with its derivative, and its inverse."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from chaosdrill.analysis.recording import flow_of, record_returns
from chaosdrill.analysis.sections import Section
from chaosdrill.analysis.tuning import SECTION_MAP
from chaosdrill.codegen import kernels_of
from chaosdrill.dataset import Outcome
from chaosdrill.engine import layout as at
from chaosdrill.engine.batch import Batch, Returns, Standing
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import BESIDE, STANDING, Run
from chaosdrill.engine.setup import modes_of_starts
from chaosdrill.engine.structure import examine
from chaosdrill.model import HybridSystem
from chaosdrill.model.regions import UNTOLD


@dataclass(frozen=True)
class Images:
    """Images of P points; those of runs that have ended are NaN."""

    states: np.ndarray  # (P, n): where the step after it begins
    shown: np.ndarray  # (P, n): as points of a section, before its events
    modes: np.ndarray  # int (P,)
    counts: np.ndarray  # int (P, transitions): how often each was taken on the way
    outcome: np.ndarray  # int (P,)

    @property
    def ok(self) -> np.ndarray:
        """Which have an image, bool (P,)."""
        return np.asarray(self.outcome == Outcome.OK)


@dataclass(frozen=True)
class Image:
    """The image of one point, with what a single run shows."""

    outcome: Outcome
    state: np.ndarray  # (n,)
    mode: int
    jacobian: np.ndarray  # (n, n): derivative of the map, across the flow where it has no period
    kinds: np.ndarray  # int (E,): the events on the way
    speeds: np.ndarray  # (E,): normal speeds at these


@dataclass(frozen=True)
class Preimage:
    """A point that the map takes to a given one, and that step."""

    state: np.ndarray
    mode: int
    image: Image


def _length(vector: np.ndarray) -> float:
    return math.sqrt(float(vector @ vector))


class SectionMap:
    """A number of strobes, iterates or points of a section, as a map of the states.

    ``steps``: strobes or points that one application of the map takes. ``mode``: mode in which motions begin, unless
    regions tell it. ``scale``, shape (n,): what distances between states are relative to. ``transition``: of a section
    of events the one directly behind which motions begin; -1 at strobes.
    """

    def __init__(
        self, where: Section, steps: int, numerics: Numerics, mode: int, scale: np.ndarray, transition: int = -1
    ) -> None:
        self.where, self.steps, self.numerics, self.mode, self.scale = where, steps, numerics, mode, scale
        self.system: HybridSystem = where.system
        self.transition = transition
        self.n = len(self.system.state_names)
        self.at_events = where.transitions is not None
        self._run = Run(self.system, where.unit, numerics, tangents=np.eye(self.n), orthonormalise=False)
        self._run.states.run["mode"] = mode
        self._deficient = examine(self.system).deficient
        if transition >= 0:
            self._run.just_took(transition)
        # what a run has met before tells nothing of the next one
        self._first = [np.array(part) for part in self._run.states]
        self._rows = np.zeros((SECTION_MAP.events, at.EVENT_COLUMNS + 2 * self.n))

    @property
    def surface(self) -> bool:
        """Whether the section is a surface, at whose points nothing changes."""
        return self.at_events and self.transition >= self.where.own

    def images(self, states: np.ndarray, modes: np.ndarray, times: int = 1) -> list[Images]:
        """The first ``times`` images of P points, shape (P, n), by runs side by side; modes may be unknown."""
        batch = self._batch(states, modes, after=True)
        # points of a section lie before its events, and motions continue after them
        before = self._batch(states, modes, after=False) if self.at_events and not self.surface else None
        found = []
        for _ in range(times):
            for one in (batch, before):
                if one is not None:
                    one.proceed(np.flatnonzero(one.outcome == Outcome.OK), 0, np.array([0, self.steps]))
            ended = batch.outcome != Outcome.OK
            reached = (batch.window[:, -1, : self.n] if self.at_events else batch.x).copy()
            reached[ended] = np.nan
            shown = reached
            if before is not None:
                shown = before.window[:, -1, : self.n].copy()
                shown[ended] = np.nan
            modes, counts = batch.mode.astype(np.int64), batch.counts.astype(np.int64)
            found.append(Images(reached, shown, modes, counts, batch.outcome.copy()))
        return found

    def _batch(self, states: np.ndarray, modes: np.ndarray, after: bool) -> Batch:
        section: dict[str, Any] = {}
        if self.at_events:
            section = {
                "section": set(self.where.transitions or ()),
                "window": 1,
                "returns": Returns(self.where.longest, after=after),
            }
        unit = self.where.unit
        states = np.ascontiguousarray(states)
        batch = Batch(self.system, {}, states, np.asarray(modes), self.numerics, unit=unit, **section)
        if self.transition >= 0 and len(states):
            kept = self._kept_standing()
            count = len(states)
            run = {name: np.repeat(one, count) for name, one in kept.run.items() if name != "mode"}
            beside = {name: np.repeat(one, count, axis=0) for name, one in kept.beside.items() if name != "extent"}
            batch.stand(Standing(run, beside))
        return batch

    def _kept_standing(self) -> Standing:
        first = type(self._run.states)(*self._first)
        run = {name: first.run[name] for name in (*STANDING, "time")}
        return Standing(run, {name: getattr(first, name) for name in BESIDE})

    def modes_at(self, states: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Modes in which motions from some states begin, and which of them can."""
        modes = np.full(len(states), UNTOLD if self.system.regions else self.mode)
        found, refused = modes_of_starts(self.system, {}, states, modes)
        return found, refused == Outcome.OK

    def image(self, state: np.ndarray, mode: int) -> Image:
        """The image of one point, with derivative and events."""
        run, rows = self._run, self._rows
        for part, first in zip(run.states, self._first, strict=True):
            part[...] = first
        run.x[:] = state
        run.states.extent[0] = np.abs(state)
        if self.transition < 0:
            run.states.run["mode"] = mode
        run.vectors[:] = np.where(run.tables.constrained[int(run.standing["mode"])] == 1, 0.0, np.eye(self.n))
        found = []
        if self.at_events:
            assert self.where.transitions is not None
            record = record_returns(run, self.where.transitions, self.steps, self.where.longest, every=True)
            outcome = record.outcome
            found.append(record.events)
        else:
            outcome, full, target = Outcome.OK, True, self.steps
            while full and outcome == Outcome.OK:
                outcome, full = run.advance(target, None, rows)
                target = 0
                found.append(rows[: run.filled()[1]].copy())
        table = np.concatenate(found)
        jacobian = run.vectors.T.copy()
        if self.at_events and outcome == Outcome.OK:
            jacobian = self._onto_section(run, table[-1], jacobian)
        kinds = table[:, at.EVENT_KIND].astype(np.int64)
        speeds = np.abs(table[:, at.EVENT_SPEED])
        return Image(outcome, run.x.copy(), int(run.standing["mode"]), jacobian, kinds, speeds)

    def _onto_section(self, run: Run, event: np.ndarray, jacobian: np.ndarray) -> np.ndarray:
        """Deviations after an event, moved along the flow onto the section there."""
        before = event[at.EVENT_COLUMNS : at.EVENT_COLUMNS + self.n]
        rates = flow_of(run)
        if self.surface:
            normal = self.normal(before)
            return jacobian - np.outer(rates, normal @ jacobian) / float(normal @ rates)
        # tangents behind an event differ along the flow by when each neighbour met it
        length = float((rates / self.scale) @ (rates / self.scale))
        return jacobian - np.outer(rates, (rates / self.scale**2) @ jacobian) / length if length > 0 else jacobian

    def loses_rank(self, image: Image) -> bool:
        """Whether the tangent map to an image has no inverse, as far as its entries are known."""
        if self._deficient.isdisjoint(image.kinds.tolist()):
            return False
        scaled = image.jacobian * self.scale / self.scale[:, np.newaxis]
        if not np.isfinite(scaled).all():
            return True
        values = np.linalg.svd(scaled, compute_uv=False)
        least = values[-2] if self.at_events else values[-1]
        return bool(least <= SECTION_MAP.zero * values[0])

    def flow(self, state: np.ndarray) -> np.ndarray:
        """Rates of the states at one, shape (n,); of systems free of time."""
        return flow_of(self._run, state, self.mode)

    def normal(self, state: np.ndarray) -> np.ndarray:
        """Gradient of the section's guard at a state, shape (n,)."""
        return self._guard(state)[1]

    def _guard(self, state: np.ndarray) -> tuple[float, np.ndarray]:
        mode = self.system.mode_names.index(self.system.transitions[self.transition].source[0])
        events = kernels_of(self.system).layout.events[mode]
        j = next(k for k, event in enumerate(events) if self.transition in event.outcomes)
        gradient = np.empty(self.n + 1)
        value = kernels_of(self.system).functions.guard(
            mode, j, 0.0, self._run.c, np.ascontiguousarray(state), gradient
        )
        return float(value), gradient[: self.n].copy()

    def preimage(
        self, target: np.ndarray, mode: int, guess: np.ndarray, reach: float, begins: int | None = None
    ) -> Preimage | None:
        """The point that the map takes to a target, by Newton's method from a guess; None where it finds none.

        Steps that do not lead closer, or to where no motion begins, are halved.

        ``target``, ``guess``, shape (n,). ``mode``: mode of the target. ``reach``: longest step, in parts of the scale.
        ``begins``: mode in which motions begin, if it is known.
        """
        image = self._checked(guess, mode, begins)
        if image is None:
            return None
        x, noise = guess, SECTION_MAP.same * self.numerics.step_error
        miss = (target - image.state) / self.scale
        size, best, since = _length(miss), np.inf, 0
        for _ in range(SECTION_MAP.steps):
            best, since = (size, 0) if size < best / 2 else (best, since + 1)
            if size <= noise or (since >= SECTION_MAP.settled and best <= SECTION_MAP.near * noise):
                break
            step = self._correction(x, image, miss)
            length = _length(step / self.scale)
            if not np.isfinite(length):
                return None
            step *= min(1.0, reach / length) if length > 0 else 1.0
            for halving in range(SECTION_MAP.halvings):
                trial = x + step / 2**halving
                there = self._checked(trial, mode, begins)
                if there is None:
                    continue
                closer = (target - there.state) / self.scale
                if (left := _length(closer)) < size:
                    break
            else:
                break
            assert there is not None
            x, image, miss, size = trial, there, closer, left
        # next to grazing the map spreads the rounding of its point
        spread = float(np.abs(image.jacobian * self.scale / self.scale[:, np.newaxis]).max())
        if size > SECTION_MAP.near * noise * max(1.0, spread) or self.loses_rank(image):
            return None
        own = int(self.modes_at(x[np.newaxis])[0][0]) if begins is None else begins
        return Preimage(x, own, image)

    def _checked(self, state: np.ndarray, mode: int, begins: int | None) -> Image | None:
        """The image of a state in a mode; None where none begins or ends so."""
        own = self.mode if begins is None else begins
        if self.system.regions:
            modes, fine = self.modes_at(state[np.newaxis])
            if not fine[0]:
                return None
            own = int(modes[0])
        image = self.image(state, own)
        return image if image.outcome == Outcome.OK and image.mode == mode else None

    def _correction(self, x: np.ndarray, image: Image, miss: np.ndarray) -> np.ndarray:
        """Step of Newton's method; on a surface the point stays there."""
        matrix = image.jacobian * self.scale / self.scale[:, np.newaxis]
        if self.surface:
            value, normal = self._guard(x)
            row = normal * self.scale
            size = float(np.linalg.norm(row)) or 1.0
            matrix, miss = np.vstack([matrix, row / size]), np.append(miss, -value / size)
            return np.asarray(np.linalg.lstsq(matrix, miss, rcond=None)[0] * self.scale)
        try:
            return np.asarray(np.linalg.solve(matrix, miss) * self.scale)
        except np.linalg.LinAlgError:
            return np.full(self.n, np.nan)

    @cached_property
    def _backward(self) -> HybridSystem | None:
        """The system with time running backwards, from strobe to strobe; None where that is not possible."""
        if self.at_events or self.system.discrete:
            return None
        from chaosdrill.model.backward import backward

        key = "backward", tuple(self.system.parameters.items())
        if key not in self.system.shared:
            self.system.shared[key] = backward(self.system)
        found: HybridSystem | None = self.system.shared[key]
        return found

    def undone(self, states: np.ndarray, modes: np.ndarray, times: int = 1) -> list[Images]:
        """The first ``times`` preimages of P points, shape (P, n), by runs backwards in time; none where that is
        not possible.

        Their errors are those of the runs, which are larger than those of the map where that spreads points.
        """
        if self._backward is None:
            return []
        batch = Batch(self._backward, {}, np.ascontiguousarray(states), modes, self.numerics)
        found = []
        for _ in range(times):
            batch.proceed(np.flatnonzero(batch.outcome == Outcome.OK), 0, np.array([0, self.steps]))
            states = batch.x.copy()
            states[batch.outcome != Outcome.OK] = np.nan
            modes, counts = batch.mode.astype(np.int64), batch.counts.astype(np.int64)
            found.append(Images(states, states, modes, counts, batch.outcome.copy()))
        return found

    def leads_to(self, targets: np.ndarray, modes: np.ndarray, found: Images) -> np.ndarray:
        """Which of the points found the map takes to their targets, without loss of rank on the way; bool (P,)."""
        fine = found.ok.copy()
        if self.system.regions:
            own, begins = self.modes_at(found.states)
            fine &= begins & (own == found.modes)
        fine[fine] = ~found.counts[fine][:, sorted(self._deficient)].any(axis=1)
        tried = np.flatnonzero(fine)
        (reached,) = self.images(found.states[tried], found.modes[tried])
        miss = np.linalg.norm((targets[tried] - reached.states) / self.scale, axis=1)
        same = (reached.modes == modes[tried]) & (reached.counts == found.counts[tried]).all(axis=1)
        fine[tried] = same & (miss <= SECTION_MAP.same * self.numerics.step_error)
        return fine

    @cached_property
    def resets(self) -> bool:
        """Whether events throw the state elsewhere, so that preimages of neighbours may be far apart."""
        return not self.system.discrete and any(not t.marks_only() for t in self.system.transitions)

    def guesses(self, target: np.ndarray, region: np.ndarray) -> Iterator[np.ndarray]:
        """Starts in a region, shape (2, 2), whose images are nearest to a target, and then nearer ones next to them."""
        starts, tree = self._pool(region)
        if tree is None:
            return
        _, places = tree.query(target / self.scale, k=min(SECTION_MAP.guesses, len(starts)))
        near = starts[np.atleast_1d(places)]
        yield from near
        sides = (region[1] - region[0]) / (SECTION_MAP.grid - 1)
        around = (
            np.array(np.meshgrid(*[np.linspace(-1, 1, SECTION_MAP.around)] * self.n, indexing="ij"))
            .reshape(self.n, -1)
            .T
        )
        for _ in range(SECTION_MAP.rounds):
            tried = (near[:, np.newaxis] + around * sides).reshape(-1, self.n)
            modes, fine = self.modes_at(tried)
            (found,) = self.images(tried, np.where(fine, modes, self.mode))
            apart = np.linalg.norm((found.states - target) / self.scale, axis=1)
            apart[~(fine & found.ok)] = np.inf
            best = apart.reshape(len(near), -1).argmin(axis=1)
            near = tried.reshape(len(near), -1, self.n)[np.arange(len(near)), best]
            sides = sides * (2 / (SECTION_MAP.around - 1))
        yield from near

    def _pool(self, region: np.ndarray) -> tuple[np.ndarray, Any]:
        from scipy.spatial import cKDTree

        if not hasattr(self, "_grid"):
            axes = [np.linspace(low, high, SECTION_MAP.grid) for low, high in region.T]
            starts = np.array(np.meshgrid(*axes, indexing="ij")).reshape(self.n, -1).T
            modes, fine = self.modes_at(starts)
            (found,) = self.images(starts[fine], modes[fine])
            starts, images = starts[fine][found.ok], found.states[found.ok]
            self._grid = (starts, cKDTree(images / self.scale) if len(starts) else None)
        return self._grid
