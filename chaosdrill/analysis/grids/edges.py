"""Edge states between two fates: a segment between two starts is cut down to the edge, and followed until it parts.

Two motions next to the edge between two basins, one on either side, stay near it while they part from each other, and
come to what attracts within the edge. Bisected again whenever they have parted, they stay there.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import xarray as xr

from chaosdrill.analysis.curves.section_map import SectionMap
from chaosdrill.analysis.grids.matching import ATTRACTING, KNOWN_BY, alike_first
from chaosdrill.analysis.grids.measuring import measure
from chaosdrill.analysis.grids.plan import Plan, make_plan
from chaosdrill.analysis.judgement.recurrence import CLOSE
from chaosdrill.analysis.starts import drawn_or_listed, settled_modes
from chaosdrill.analysis.tuning import EDGES
from chaosdrill.dataset import Outcome
from chaosdrill.dataset.build import dataset
from chaosdrill.dataset.outcomes import MEASURED
from chaosdrill.engine.batch import Batch, Standing
from chaosdrill.model.regions import UNTOLD

if TYPE_CHECKING:
    from chaosdrill.analysis.base import Job
    from chaosdrill.engine.numerics import Numerics
    from chaosdrill.model import HybridSystem

UNKNOWN, OTHER = 0, 3
"""Codes of fates beside 1 and 2, those of the two sides."""

_COMES_BACK = (Outcome.PERIODIC, Outcome.EQUILIBRIUM)


class _Stopped(Exception):
    """An edge cannot be followed, with the reason."""


@dataclass(frozen=True)
class _Pair:
    """Two states of one mode on either side of the edge, and how the guards stand there."""

    states: np.ndarray  # (2, n)
    modes: np.ndarray  # int (2,)
    standing: Standing | None = None  # of the first; None for states from which a run begins
    time: float = 0.0  # since the start

    @property
    def middle(self) -> np.ndarray:
        """Between the two, shape (n,)."""
        return np.asarray(self.states.mean(axis=0))


class _Segment(NamedTuple):
    """One bisected pair until it has parted."""

    times: np.ndarray  # (K,): since the start
    states: np.ndarray  # (K, n): in the middle
    modes: np.ndarray  # int (K,)
    distance: np.ndarray  # (K,): of the two
    width: np.ndarray  # (n,): half the distance of the two at its beginning, state by state


@dataclass
class _Edge:
    """How the edge between the fates of two starts is followed."""

    plan: Plan
    known: dict[str, np.ndarray]  # what is known of the fates of both sides, (2, ...)
    scale: np.ndarray  # (n,): unit of distances
    closest: float
    parted: float
    longer: int = 0  # by how many lengths runs are settled longer

    def distance(self, states: np.ndarray) -> float:
        """Of two states, the largest over the states, in their units."""
        return float((np.abs(states[1] - states[0]) / self.scale).max())

    def begin(self, pair: _Pair, states: np.ndarray, modes: np.ndarray) -> Batch:
        """Runs over steps of the map from states between those of a pair."""
        batch = self.plan.mapped({}, np.ascontiguousarray(states), modes, 1)
        if pair.standing is not None:
            batch.stand(pair.standing.at(np.zeros(len(states), dtype=np.int64)))
        return batch

    def fates(self, pair: _Pair, states: np.ndarray) -> np.ndarray:
        """Codes of the fates of states between those of a pair."""
        plan = replace(self.plan, transient=self.plan.transient + self.longer * self.plan.periods)
        modes = np.full(len(states), pair.modes[0])
        if pair.standing is None:
            if plan.system.regions:
                modes = settled_modes(plan.system, states, np.full(len(states), UNTOLD))
            return told_by(self.known, measure(plan, {}, states, modes)[0])
        return told_by(self.known, measure(plan, {}, states, modes, self.begin(pair, states, modes))[0])

    def bisect(self, pair: _Pair) -> _Pair:
        """A pair as close as asked for, or as the digits of its states allow."""
        along, given = np.arange(1, EDGES.parts) / EDGES.parts, pair
        while self.distance(pair.states) > self.closest:
            between = pair.states[0] + along[:, np.newaxis] * (pair.states[1] - pair.states[0])
            if (between[0] == pair.states[0]).all() or (between[-1] == pair.states[1]).all():
                break
            codes = np.array([1, *self.fates(pair, between), 2])
            first, last = bracket(codes)
            if last - first == EDGES.parts:
                if self.longer < self.plan.max_extension:
                    self.longer += 1
                    continue
                raise _Stopped(_unclear(codes[1:-1]))
            rows = np.concatenate([pair.states[:1], between, pair.states[1:]])[[first, last]]
            modes = pair.modes
            if pair.standing is None and self.plan.system.regions:
                modes = settled_modes(self.plan.system, rows, np.full(2, UNTOLD))
            pair = replace(pair, states=rows, modes=modes)
        if given.standing is not None:
            self._ascertain(given, pair)
        if pair.modes[0] != pair.modes[1]:
            raise _Stopped("the edge lies where the starts change their mode, so nothing stays on it")
        return pair

    def _ascertain(self, given: _Pair, pair: _Pair) -> None:
        """Find once more the fates of those of a given pair that no bisection has replaced: they are from long ago."""
        kept = np.flatnonzero((given.states == pair.states).all(axis=1))
        while len(kept) and (self.fates(given, given.states[kept]) != kept + 1).any():
            if self.longer >= self.plan.max_extension:
                raise _Stopped("a motion beside the edge has another fate than the start had; give a longer transient")
            self.longer += 1

    def follow(self, pair: _Pair) -> tuple[_Segment, _Pair]:
        """Run a pair until it has parted; the last pair that has not, from which to bisect again."""
        batch = self.begin(pair, pair.states, pair.modes)
        plan, both, start = self.plan, np.arange(2), self.distance(pair.states)
        before = pair.time - float(batch.elapsed[0])
        most = max(EDGES.least_steps, (plan.transient + plan.periods) * (1 + plan.max_extension))
        times, states, modes, distances, last = [pair.time], [pair.middle], [int(pair.modes[0])], [start], pair
        for _ in range(most):
            batch.proceed(both, 0, np.array([0, 1]))
            if (batch.outcome != Outcome.OK).any():
                ended = Outcome(int(batch.outcome.max()))
                raise _Stopped(f"a run beside the edge ended as {ended.name.lower()}. {ended.advice}")
            distance = self.distance(batch.x)
            if distance == 0.0:
                raise _Stopped(
                    "runs from both sides of the edge met, as after an event that leads both to one state; their fates "
                    "were decided too early: give a longer transient"
                )
            alike = batch.mode[0] == batch.mode[1]
            gone = not alike or distance > self.parted
            if gone and (len(times) > 1 or not alike or distance > np.sqrt(self.parted)):
                if alike and len(times) > 1:
                    break
                if last is pair:
                    raise _Stopped(
                        "two starts on either side of the edge part at once, as at an event that only one of them "
                        "meets: a jump of the motion separates the fates, and no state lies on the edge"
                    )
                break
            here = batch.x.copy()
            last = _Pair(here, batch.mode.astype(np.int64), batch.standing(both), before + float(batch.elapsed[0]))
            times.append(last.time)
            states.append(last.middle)
            modes.append(int(last.modes[0]))
            distances.append(distance)
            if gone:
                break
        else:
            raise _Stopped(
                "two starts on either side of the edge did not part; give a longer transient, or more periods"
            )
        width = np.abs(pair.states[1] - pair.states[0]) / 2
        segment = _Segment(np.array(times), np.array(states), np.array(modes), np.array(distances), width)
        return segment, last


def bracket(codes: np.ndarray) -> tuple[int, int]:
    """The places of the closest 1 and 2, in this order, with neither of these between them.

    ``codes``, int, shape (K,): from a 1 to a 2.
    """
    sides = np.flatnonzero(np.isin(codes, (1, 2)))
    pairs = [(i, j) for i, j in pairwise(sides.tolist()) if codes[i] == 1 and codes[j] == 2]
    return min(pairs, key=lambda one: one[1] - one[0])


def _unclear(codes: np.ndarray) -> str:
    """Why nothing between two starts leads where one of them does."""
    advice = "give a longer transient, or two starts that are closer to one edge"
    if (codes == OTHER).any():
        return (
            f"starts between the two lead to a third fate, or stay where they are for the length of the runs; {advice}"
        )
    return f"the fates of starts between the two are not decided; {advice}"


def told_by(known: Mapping[str, np.ndarray], found: Mapping[str, np.ndarray]) -> np.ndarray:
    """Codes of the fates of runs, int (P,): 1 or 2 as one of two that are known, 3 as neither, 0 for none.

    ``known``, ``found``: what `chaosdrill.analysis.grids.measuring.measure` tells of 2 runs, and of P.
    """
    outcome = found["outcome"]
    attracted = np.isin(outcome, ATTRACTING) & np.isfinite(found["moments"]).all(axis=(1, 2))
    codes = np.where(attracted | (outcome == Outcome.ESCAPED), OTHER, UNKNOWN)
    for side in (1, 0):
        one = {name: known[name][side : side + 1] for name in KNOWN_BY}
        if one["outcome"][0] == Outcome.ESCAPED:
            codes[outcome == Outcome.ESCAPED] = side + 1
            continue
        # a word that is missing on either record tells nothing
        loose = attracted & (found["period"] == 0) & (outcome != Outcome.EQUILIBRIUM)
        wordless = loose & ((outcome == Outcome.UNDECIDED) | (one["outcome"][0] == Outcome.UNDECIDED))
        many = {name: found[name] for name in KNOWN_BY}
        many["outcome"] = np.where(wordless, one["outcome"][0], outcome)
        codes[attracted & alike_first(one, many)] = side + 1
    return codes


def edges_dataset(system: "HybridSystem", given: Any, job: "Job") -> xr.Dataset:
    """The edge state between two fates; see `chaosdrill.edge_states`."""
    plan = make_plan(system, given, job.numerics)
    report = job.report(given.rounds + 1)
    starts, modes = drawn_or_listed(system, given)
    found, batch = measure(plan, {}, starts, modes)
    chosen = _two_fates(plan, found, modes)
    segments, scale = list[_Segment](), np.ones(starts.shape[1])
    if len(chosen) == 2:
        # what escapes is larger than anything
        stay = chosen[found["outcome"][chosen] != Outcome.ESCAPED]
        scale = _scale(starts[chosen], batch.window[stay, :, :-1], batch.sizes[stay])
        edge = _Edge(plan, {name: found[name][chosen] for name in KNOWN_BY}, scale, given.closest, given.parted)
        segments, reason = _followed(edge, _Pair(starts[chosen], modes[chosen]), given.rounds + 1, report)
    elif len(chosen):
        reason = "no two starts of one mode have two fates; give starts on either side of an edge"
    else:
        reason = f"no start has a fate. {Outcome(int(found['outcome'][0])).advice}"
    if report:
        report(given.rounds + 1)
    track = _Track.of(segments, starts.shape[1])
    told = _Returns(Outcome.UNDECIDED, 0, np.nan)
    if not reason:
        told = _returns(plan, track, scale, given.parted)
    period = max(told.period, 1) if told.outcome in _COMES_BACK else 0
    rate, error = _grown(segments, period)
    exponents = _exponents(plan, segments, scale, job.numerics, period)
    if not reason:
        told, reason = _judged(plan, track, exponents, told)
    if len(chosen) < 2 and len(set(found["outcome"].tolist())) == 1 and found["outcome"][0] not in MEASURED:
        told = told._replace(outcome=Outcome(int(found["outcome"][0])))
    mode = -1
    edge_state, edge_error = np.full((2, starts.shape[1]), np.nan)
    if segments:
        edge_state, edge_error, mode = segments[-1].states[0], segments[-1].width, int(segments[-1].modes[0])
        if told.outcome in _COMES_BACK:
            edge_error = edge_error + change(segments, period, plan)
    return dataset(
        {
            "edge_state": ("state", edge_state),
            "edge_error": ("state", edge_error),
            "edge_mode": ((), np.int8(mode)),
            "period": ((), np.int32(told.period)),
            "outcome": ((), np.int8(told.outcome)),
            "return_distance": ((), told.distance),
            "growth_rate": ((), rate[0]),
            "growth_rate_error": ((), error[0]),
            "lyapunov_exponent": ("exponent", exponents[0]),
            "lyapunov_error": ("exponent", exponents[1]),
            "track_time": ("step", track.times),
            "track_state": (("step", "state"), track.states),
            "track_mode": ("step", track.modes.astype(np.int8)),
            "track_distance": ("step", track.distance),
            "bisection": ("step", track.segment),
            **_sides(starts, found, chosen),
            **({"forcing_period": ((), system.forcing_period())} if system.forced else {}),
            "state": list(system.state_names),
            "exponent": np.arange(1, len(exponents[0]) + 1, dtype=np.int32),
            "side": np.arange(1, 3, dtype=np.int32),
        },
        attrs={"reason": reason} if reason else None,
    )


def _sides(starts: np.ndarray, found: Mapping[str, np.ndarray], chosen: np.ndarray) -> dict[str, Any]:
    """Variables of the two sides of an edge, of which fewer may be known: the starts that were chosen."""
    missing = 2 - len(chosen)
    blank = np.full((missing, starts.shape[1]), np.nan)
    none = [int(Outcome.UNDECIDED)] * missing
    return {
        "side_start": (("side", "state"), np.concatenate([starts[chosen], blank])),
        "side_state": (("side", "state"), np.concatenate([found["state"][chosen], blank])),
        "side_period": ("side", np.concatenate([found["period"][chosen], np.zeros(missing, dtype=np.int16)])),
        "side_outcome": ("side", np.array([*found["outcome"][chosen].tolist(), *none], dtype=np.int8)),
    }


def _followed(
    edge: _Edge, pair: _Pair, rounds: int, report: Callable[[int], None] | None
) -> tuple[list[_Segment], str]:
    """The track, a segment a bisection, and why it ended early; empty if it did not."""
    segments: list[_Segment] = []
    try:
        for done in range(rounds):
            if report:
                report(done)
            segment, pair = edge.follow(edge.bisect(pair))
            segments.append(segment)
    except _Stopped as fault:
        return segments, str(fault)
    return segments, ""


def _judged(
    plan: Plan, track: "_Track", exponents: tuple[np.ndarray, np.ndarray], told: "_Returns"
) -> tuple["_Returns", str]:
    """What the edge state is, by how the track returns and by its exponents; or why that is not known."""
    if told.outcome in _COMES_BACK and _ways(exponents, track) > 1:
        # motions beside the track, on the same edge, leave it: only a symmetry holds it there
        return told._replace(outcome=Outcome.UNDECIDED, period=0), (
            "the track stays where several directions lead off, so that other motions on the edge do not come there; "
            "give starts that share no symmetry with it"
        )
    if told.outcome != Outcome.UNDECIDED:
        return told, ""
    if (exponents[0] > EDGES.positive * exponents[1]).sum() > 1:
        return told._replace(outcome=Outcome.CHAOTIC), ""
    advice = "give more rounds" if plan.maps else "name a section (at), whose points tell a cycle, or give more rounds"
    return told, f"the track neither returns nor is chaotic beyond the error; {advice}"


def _two_fates(plan: Plan, found: Mapping[str, np.ndarray], modes: np.ndarray) -> np.ndarray:
    """The first start with a fate, and the next one of another fate to which it can be joined, if there are any."""
    fits = np.isin(found["outcome"], (*ATTRACTING, Outcome.ESCAPED))
    for one in np.flatnonzero(fits).tolist():
        codes = told_by({name: found[name][[one, one]] for name in KNOWN_BY}, found)
        others = fits & (codes == OTHER) & ((modes == modes[one]) | bool(plan.system.regions))
        if others.any():
            return np.array([one, int(np.flatnonzero(others)[0])])
    return np.flatnonzero(fits)[:1]


def _scale(starts: np.ndarray, windows: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Units of distances: the extent of the starts and of what they lead to; the size of a state that rests.

    ``starts``, shape (2, n). ``windows``, ``known``, shapes (A, W, n), (A, n): points of the attractors, and sizes that
    states have had on the way there.
    """
    points = np.concatenate([starts, windows.reshape(-1, starts.shape[1])])
    extent = np.nanmax(points, axis=0) - np.nanmin(points, axis=0)
    size = np.maximum(known.max(axis=0), np.abs(starts).max(axis=0))
    scale = np.where(extent > CLOSE * size, extent, size)
    return np.where(scale > 0, scale, 1.0)


@dataclass(frozen=True)
class _Track:
    """The middle of all segments, one after the other."""

    times: np.ndarray  # (K,)
    states: np.ndarray  # (K, n)
    modes: np.ndarray  # int (K,)
    distance: np.ndarray  # (K,)
    segment: np.ndarray  # int (K,): from 1

    @classmethod
    def of(cls, segments: list[_Segment], n: int) -> "_Track":
        """The last state of a segment, which has parted, stands again, bisected, at the beginning of the next one."""
        kept = [slice(None if k == len(segments) - 1 else -1) for k in range(len(segments))]
        parts = list(zip(segments, kept, strict=True))
        return cls(
            np.concatenate([np.zeros(0), *[one.times[some] for one, some in parts]]),
            np.concatenate([np.zeros((0, n)), *[one.states[some] for one, some in parts]]),
            np.concatenate([np.zeros(0, dtype=np.int64), *[one.modes[some] for one, some in parts]]),
            np.concatenate([np.zeros(0), *[one.distance[some] for one, some in parts]]),
            np.concatenate([np.zeros(0), *[np.full(len(one.times[some]), k) for k, (one, some) in enumerate(parts, 1)]])
            .astype(np.int32),
        )  # fmt: skip


class _Returns(NamedTuple):
    """How the later half of a track returns."""

    outcome: Outcome
    period: int  # in steps
    distance: float  # largest between states a period apart


def _returns(plan: Plan, track: _Track, scale: np.ndarray, parted: float) -> _Returns:
    late = track.states[len(track.states) // 2 :]
    path, size = plan.shifts.quotient(late), plan.shifts.sizes(scale)
    allowed = EDGES.returns * parted
    if not plan.maps:
        spread = float((np.ptp(path, axis=0) / size).max())
        return _Returns(Outcome.EQUILIBRIUM if spread <= allowed else Outcome.UNDECIDED, 0, spread)
    least = np.inf
    for period in range(1, min(plan.max_period, len(path) // 2) + 1):
        far = float((np.abs(path[period:] - path[:-period]) / size).max())
        if far <= allowed:
            at_rest = period == 1 and plan.system.autonomous and not plan.at_events and not plan.system.discrete
            return _Returns(Outcome.EQUILIBRIUM if at_rest else Outcome.PERIODIC, 0 if at_rest else period, far)
        least = min(least, far)
    return _Returns(Outcome.UNDECIDED, 0, float(least))


def _ways(exponents: tuple[np.ndarray, np.ndarray], track: _Track) -> int:
    """Number of directions in which motions leave a track that returns.

    Their growth is beyond the error, and shows over the later half of the track; that of a neutral direction does not.
    """
    rates, errors = exponents
    lasted = track.times[-1] - track.times[len(track.times) // 2]
    with np.errstate(invalid="ignore"):
        return int(((rates > EDGES.positive * errors) & (rates * lasted > 1)).sum())


def change(segments: list[_Segment], period: int, plan: Plan) -> np.ndarray:
    """How far the last bisected state is from the last one before at the same phase of a cycle, shape (n,); else 0."""
    begin = np.cumsum([0, *[len(one.times) - 1 for one in segments[:-1]]])
    same = np.flatnonzero((begin[-1] - begin[:-1]) % period == 0)
    now = segments[-1].states[0]
    return np.abs(plan.shifts.across(now - segments[int(same[-1])].states[0])) if len(same) else np.zeros(len(now))


def mean_rates(
    growth: np.ndarray, lasted: np.ndarray, blocks: np.ndarray, period: int
) -> tuple[np.ndarray, np.ndarray]:
    """Mean rates of growth, and their standard errors, from what single steps grow by.

    Parameters
    ----------
    growth : ndarray, shape (K, m)
        Logarithms, step by step.
    lasted : ndarray, shape (K,)
        Times of the steps.
    blocks : ndarray of int, shape (K,)
        The bisection after which each was made, whose steps depend on each other.
    period : int
        Of a cycle, on which steps a period apart are alike: all its phases then count the same. They differ by how far
        from the cycle they were made, always to one side, so that the scatter of a step, not of the mean, is the error.
        0: the rate is that of all steps, with the scatter of blocks.

    Returns
    -------
    rates, errors : ndarray, shape (m,)
        NaN from fewer than two blocks, or without all phases twice.
    """
    label = np.arange(len(growth)) % period if period else np.unique(blocks, return_inverse=True)[1]
    count = np.bincount(label) if len(growth) else np.zeros(0, dtype=np.int64)
    unknown = np.full(growth.shape[1], np.nan)
    if len(count) < (period or 2) or (period and count.min() < 2):
        return unknown, unknown
    parts = [growth[label == k] for k in range(len(count))]
    times = np.array([lasted[label == k].sum() for k in range(len(count))])
    with np.errstate(invalid="ignore"):
        if period:
            time = (times / count).sum()
            mean, spread = (np.array([of(one, axis=0) for one in parts]).sum(axis=0) for of in (np.mean, np.std))
            return mean / time, spread / time
        sums = np.array([one.sum(axis=0) for one in parts])
        rates = sums.sum(axis=0) / times.sum()
        left = sums - rates * times[:, np.newaxis]
        return rates, np.sqrt((left**2).sum(axis=0) * len(times) / (len(times) - 1)) / times.sum()


def _grown(segments: list[_Segment], period: int) -> tuple[np.ndarray, np.ndarray]:
    """Rate at which two motions beside the edge part, and its standard error, from the later half of the segments."""
    late = segments[len(segments) // 2 :]
    steps = [np.diff(np.log(one.distance)) for one in late]
    blocks = np.repeat(np.arange(len(late)), [len(one) for one in steps])
    lasted = np.concatenate([np.zeros(0), *[np.diff(one.times) for one in late]])
    return mean_rates(np.concatenate([np.zeros(0), *steps])[:, np.newaxis], lasted, blocks, period)


def _exponents(
    plan: Plan, segments: list[_Segment], scale: np.ndarray, numerics: "Numerics", period: int
) -> tuple[np.ndarray, np.ndarray]:
    """Exponents of the edge state and their standard errors, from derivatives of the map along the later half.

    NaN where the map has no derivative that is known: behind one of several events of a section.
    """
    # along a flow nothing grows from one point of a section to the next
    count, transition = len(scale) - plan.at_events, -1
    unknown = np.full(count, np.nan)
    where = replace(plan.where, transitions=None, unit=plan.system.forcing_period() or plan.part)
    if plan.at_events:
        assert plan.section is not None
        if len(plan.section) != 1:
            return unknown, unknown
        (transition,), where = plan.section, plan.where
    if len(segments) < 2:
        return unknown, unknown
    along = SectionMap(where, 1, numerics, int(segments[0].modes[0]), scale, transition)
    frame = np.linalg.qr(np.random.default_rng(1).standard_normal((len(scale), count)))[0]
    grown, lasted, blocks = [], [], []
    for place in range(len(segments) // 4, len(segments)):
        one = segments[place]
        for state, mode, time in zip(one.states[:-1], one.modes[:-1].tolist(), np.diff(one.times), strict=True):
            image = along.image(state, mode)
            matrix = image.jacobian * scale / scale[:, np.newaxis]
            if image.outcome != Outcome.OK or not np.isfinite(matrix).all():
                return unknown, unknown
            frame, upper = np.linalg.qr(matrix @ frame)
            steps = np.abs(np.diag(upper))
            if place >= len(segments) // 2:
                with np.errstate(divide="ignore"):
                    grown.append(np.log(np.where(steps > EDGES.rank * np.linalg.norm(matrix), steps, 0.0)))
                lasted.append(time)
                blocks.append(place)
    rates, errors = mean_rates(np.array(grown).reshape(-1, count), np.array(lasted), np.array(blocks), period)
    order = np.argsort(-rates, kind="stable")
    return rates[order], errors[order]
