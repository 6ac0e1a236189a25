"""Runs that leave, and what those that stay long tell of the saddle from which they leave: sprinkler, stagger-and-step.

In the middle of a long life a run is near the saddle: it has come along the stable manifold, and has not yet left along
the unstable one.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from chaosdrill.analysis.judgement.statistics import block_ends, standard_error
from chaosdrill.analysis.measures.staggers import PICTURES, WALKERS, Staggers, Walkers
from chaosdrill.codegen import kernels_of
from chaosdrill.dataset import Outcome
from chaosdrill.engine.batch import Batch, Returns
from chaosdrill.engine.structure import examine
from chaosdrill.model import HybridSystem
from chaosdrill.model.noise import seeds_of_starts
from chaosdrill.model.regions import UNTOLD, modes_at

if TYPE_CHECKING:
    from chaosdrill.engine.numerics import Numerics

TOGETHER = 4096
"""Starts of a batch."""

SURVIVORS = 100
"""Runs that are to reach the age at which the saddle is looked at: the most that do."""

MARGIN = 0.25
"""Part of that age, at its beginning and at its end, in which runs still come to the saddle or leave it already."""

SHORT = 2
"""Units between these margins without which a mean that still moves is not seen: in one, twice the error covers the
exponent of Henon's horseshoe in 63 % of records, in two in 97 %. Stagger-and-step makes runs longer."""

VISITS = 10
"""States of a run that are kept as points on the saddle, at most."""

RISES = 4
"""Errors by which more walkers stay in the later half of the pictures: beyond, they gather where none leaves. Beside
a small attractor of the drill they are 4 to 8; by chance they are beyond 4 in one record of 1,500."""

NO_SADDLE = "too few runs stay long enough to show a saddle: take more starts, nearer to it, or a longer record"

ATTRACTED = (
    "walkers gather where none leaves, as at an attractor, and show no saddle: end lives there by until, or take "
    "the sprinkler"
)

BY_DEFAULT = 256
"""Walkers at most where these are not asked for."""

TIMES, FEW = 200, 20_000
"""How many times as long as the longest runs of the starts they may then be watched, and units for a start in any case:
the tent of slope 3 takes 2,000, starts of the Lorenz system that leave at one age 140 times as long."""

TOO_LONG = (
    'stagger-and-step takes far longer than the starts, as where some stay for ever: ask for it by saddle="stagger", '
    "or end lives there by until"
)

SHOWN = 64
"""Walkers of which such states are kept, each time that their growth is measured."""


class Lives(NamedTuple):
    """What became of runs, one entry each."""

    length: np.ndarray  # time until they left, or as long as they were watched
    units: np.ndarray  # whole units of it
    left: np.ndarray  # whether they left
    outcome: np.ndarray


class Saddle(NamedTuple):
    """A saddle by runs near it."""

    points: np.ndarray  # (K, n)
    exponents: np.ndarray  # (m,): descending
    errors: np.ndarray  # (m,)
    rates: np.ndarray  # (R, m): of independent samples, single runs or pictures of walkers
    moved: np.ndarray  # (m,): exponents less those over the first half of the lives
    age: float = math.nan  # that all these runs reach
    rate: tuple[float, float] = (math.nan, math.nan)  # at which walkers leave, and its error
    staggers: int = 0
    size: float = math.nan  # of the largest tenth of these at least, in parts of the extent of the saddle
    reason: str = ""  # why nothing is known of it


@dataclass(frozen=True)
class Runs:
    """Runs of a system until they leave, by an escape from its bounds or by one of some transitions.

    Ages are counted in whole units, forcing periods or parts of a duration. Where a ``surface`` ends lives, which no
    event of the system has, starts beyond it are invalid.
    """

    system: HybridSystem
    ends: list[int]
    surface: bool
    unit: float
    numerics: "Numerics"

    def watched(self, starts: np.ndarray, modes: np.ndarray, count: int, report: Any = None) -> Lives:
        """Run all starts until they leave, or for a number of units."""
        length, outcome = np.zeros(len(starts)), np.zeros(len(starts), dtype=np.int64)
        counted: dict[str, Any] = (
            {"section": set(self.ends), "returns": Returns(count * self.unit)} if self.ends else {}
        )
        for part in _parts(len(starts)):
            batch = self._batch(starts[part], modes[part], np.arange(part.start, part.stop), **counted)
            batch.run(0, np.array([0, 1 if self.ends else count]))
            length[part], outcome[part] = batch.elapsed, batch.outcome
            if report:
                report(part.stop)
        if self.ends:
            met = outcome == Outcome.OK
            stayed = np.isin(outcome, (Outcome.NO_RETURN, Outcome.EQUILIBRIUM))
            outcome = np.where(met, int(Outcome.ESCAPED), np.where(stayed, int(Outcome.OK), outcome))
            length = np.where(stayed, count * self.unit, length)
        beyond = self._beyond(starts, modes)
        length[beyond], outcome[beyond] = 0.0, int(Outcome.INVALID_START)
        units = np.minimum(np.floor(length / self.unit + 1e-9).astype(np.int64), count)
        # within a step of a map nothing happens
        return Lives(units * self.unit if self.system.discrete else length, units, outcome == Outcome.ESCAPED, outcome)

    def lives(self, starts: np.ndarray, modes: np.ndarray, count: int) -> np.ndarray:
        """Whole units that runs stay, up to a number of them."""
        return self.watched(starts, modes, count).units

    def _beyond(self, starts: np.ndarray, modes: np.ndarray) -> np.ndarray:
        """Which states are beyond the surface that ends lives."""
        found = np.zeros(len(starts), dtype=bool)
        if not self.surface:
            return found
        if self.system.discrete:
            return modes_at(self.system, {}, starts)[0] == UNTOLD
        kernels, gradient = kernels_of(self.system), np.empty(starts.shape[1] + 1)
        constants = kernels.constants(self.system.parameters)
        for mode, events in enumerate(kernels.layout.events):
            for j in (j for j, event in enumerate(events) if not set(self.ends).isdisjoint(event.outcomes)):
                for i in np.flatnonzero(modes == mode).tolist():
                    value = kernels.functions.guard(mode, j, 0.0, constants, starts[i], gradient)
                    found[i] |= events[j].direction * value > 0
        return found

    def stepped(self, starts: np.ndarray, modes: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
        """States and modes after a number of units."""
        batch = self._batch(starts, modes, np.arange(len(starts)))
        batch.run(0, np.array([0, count]))
        return batch.x.copy(), batch.mode.copy()

    def grown(
        self, starts: np.ndarray, modes: np.ndarray, which: np.ndarray, margin: int, window: int
    ) -> tuple[np.ndarray, np.ndarray]:
        """States of some runs in a window between two margins, shape (visits, R, n), and growth, (visits, R, m).

        Runs that leave before the end of the second margin are left out.
        """
        structure = examine(self.system)
        frame, symmetries = structure.tangents(self.system.free)
        points, growth = [], []
        for part in _parts(len(which)):
            some = which[part]
            batch = self._batch(
                starts[some], modes[some], some, tangents=frame, symmetries=symmetries, deficient=structure.deficient
            )
            stay = self._still_there(batch, np.arange(len(some)), margin)
            seen, grown = [], []
            for length in np.diff(block_ends(window, VISITS)).tolist():
                stay = self._still_there(batch, stay, length)
                grown.append(batch.sums_by_size(np.arange(len(some)))[:, -1])
                seen.append(batch.x.copy())
            stay = self._still_there(batch, stay, margin)
            points.append(np.array([states[stay] for states in seen]))
            growth.append(np.array([sums[stay] for sums in grown]))
        return np.concatenate(points, axis=1), np.concatenate(growth, axis=1)

    def _batch(self, starts: np.ndarray, modes: np.ndarray, places: np.ndarray, **how: Any) -> Batch:
        return Batch(
            self.system, seeds_of_starts(self.system, places), starts, modes, self.numerics, unit=self.unit, **how
        )

    def _still_there(self, batch: Batch, which: np.ndarray, units: int) -> np.ndarray:
        """Continue over a number of units; return which of some runs have not left meanwhile."""
        batch.proceed(which, 0, np.array([0, units]))
        gone = batch.counts[which][:, self.ends].any(axis=1)
        return which[(batch.outcome[which] == Outcome.OK) & ~gone]


def _parts(count: int) -> Iterator[slice]:
    yield from (slice(first, min(first + TOGETHER, count)) for first in range(0, count, TOGETHER))


def unknown_saddle(system: HybridSystem, reason: str = NO_SADDLE) -> Saddle:
    """A saddle of which nothing is known."""
    unknown, rates = np.full(system.free, np.nan), np.zeros((0, system.free))
    return Saddle(np.zeros((0, len(system.state_names))), unknown, unknown, rates, unknown, reason=reason)


def sprinkled(runs: Runs, starts: Walkers, lead: int, least: int) -> Saddle | None:
    """The saddle by runs that stay long; None if they do for less than a number of units between the margins."""
    age = reached(starts.lives)
    margin = max(lead, math.ceil(MARGIN * age))
    window = age - 2 * margin
    if window < least:
        return None
    points, growth = runs.grown(starts.states, starts.modes, np.flatnonzero(starts.lives >= margin), margin, window)
    if growth.shape[1] < 2:
        return None
    return _summed_up(points, growth, window, runs.unit)._replace(age=age * runs.unit)


def reached(lives: np.ndarray) -> int:
    """The greatest age that enough runs reach."""
    return int(np.sort(lives)[-SURVIVORS]) if len(lives) >= SURVIVORS else 0


def staggered(runs: Runs, starts: Walkers, count: int, seed: int, *, asked: bool) -> Saddle:
    """The saddle by walkers that stagger; unknown if none stay for long enough, or for ever."""
    together, most = WALKERS, math.inf
    if not asked:
        together = min(-(-len(starts.lives) // 2), BY_DEFAULT)
        most = max(TIMES * count, FEW) * len(starts.lives)
    staggers = Staggers(runs.lives, runs.stepped, count, together, most, np.random.default_rng(seed))
    points, growth, window = [], [], 0
    for walkers in staggers.walk(starts):
        margin = math.ceil(MARGIN * staggers.level)
        window = staggers.level - 2 * margin
        if window < 1:
            return unknown_saddle(runs.system)
        seen, grown = runs.grown(walkers.states, walkers.modes, np.arange(len(walkers.lives)), margin, window)
        points.append(seen[:, :SHOWN])
        growth.append(grown.mean(axis=1))
    if len(growth) < PICTURES:
        return unknown_saddle(runs.system, TOO_LONG if staggers.weary else NO_SADDLE)
    stayed = np.array(staggers.stayed)
    early, late = stayed.reshape(2, PICTURES // 2, -1).mean(axis=2)
    spread = math.sqrt((early.var() + late.var()) / (len(early) - 1))
    length = staggers.stride * runs.unit
    rate = -math.log(stayed.mean()) / length
    found = _summed_up(np.concatenate(points, axis=1), np.array(growth).transpose(1, 0, 2), window, runs.unit)
    # a saddle is left at some rate, and by growth in some direction
    if late.mean() - early.mean() > RISES * spread or not (rate > 0 and found.exponents[0] > 0):
        return unknown_saddle(runs.system, ATTRACTED)
    # pictures follow one another, and are few; those of -inf have no error
    with np.errstate(invalid="ignore"):
        errors = np.fmax(found.errors, standard_error(found.rates))
    return found._replace(
        errors=errors,
        age=staggers.level * runs.unit,
        rate=(rate, float(standard_error(stayed)) / stayed.mean() / length),
        staggers=staggers.taken,
        size=staggers.size or math.nan,
    )


def _summed_up(points: np.ndarray, growth: np.ndarray, window: int, unit: float) -> Saddle:
    """Exponents by growth of shape (visits, R, m) in parts of a window, and their errors."""
    rates = growth.sum(axis=0) / (window * unit)
    means = rates.mean(axis=0)
    order = np.argsort(-means, kind="stable")
    half, moved = len(growth) // 2, np.zeros(len(means))
    with np.errstate(invalid="ignore"):
        errors = rates.std(axis=0, ddof=1) / math.sqrt(len(rates))
        if half:
            # a mean that still moves along the lives is not yet that of the saddle
            early = block_ends(window, VISITS)[half]
            moved = means - growth[:half].sum(axis=0).mean(axis=0) / (early * unit)
            errors = np.hypot(errors, moved)
    return Saddle(points.reshape(-1, points.shape[-1]), means[order], errors[order], rates[:, order], moved[order])
