"""Edge states between two fates: a segment between two starts is cut down to the edge, and followed until it parts.

Two motions next to the edge between two basins, one on either side, stay near it while they part from each other, and
come to what attracts within the edge. Bisected again whenever they have parted, they stay there.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import xarray as xr

from chaosdrill.analysis.matching import ATTRACTING, KNOWN_BY, alike_first
from chaosdrill.analysis.measuring import measure
from chaosdrill.analysis.plan import Plan, make_plan
from chaosdrill.analysis.recurrence import CLOSE
from chaosdrill.analysis.section_map import SectionMap
from chaosdrill.analysis.starts import drawn_or_listed, settled_modes
from chaosdrill.analysis.tuning import EDGES
from chaosdrill.dataset import Outcome
from chaosdrill.dataset.build import dataset
from chaosdrill.engine.batch import Batch, Standing
from chaosdrill.model.regions import UNTOLD

if TYPE_CHECKING:
    from chaosdrill.analysis.base import Job
    from chaosdrill.model import HybridSystem

UNKNOWN, OTHER = 0, 3
"""Codes of fates beside 1 and 2, those of the two sides."""


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
    distance: np.ndarray  # (K,): of the two
    mode: int
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
        along = np.arange(1, EDGES.parts) / EDGES.parts
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
        if pair.modes[0] != pair.modes[1]:
            raise _Stopped("the edge lies where the starts change their mode, so that nothing stays on it")
        return pair

    def follow(self, pair: _Pair) -> tuple[_Segment, _Pair]:
        """Run a pair until it has parted; the last pair that has not, from which to bisect again."""
        batch = self.begin(pair, pair.states, pair.modes)
        plan, both, start = self.plan, np.arange(2), self.distance(pair.states)
        before = pair.time - float(batch.elapsed[0])
        most = max(EDGES.least_steps, (plan.transient + plan.periods) * (1 + plan.max_extension))
        times, states, distances, last = [pair.time], [pair.middle], [start], pair
        for _ in range(most):
            batch.proceed(both, 0, np.array([0, 1]))
            if (batch.outcome != Outcome.OK).any():
                ended = Outcome(int(batch.outcome.max()))
                raise _Stopped(f"a run beside the edge ended as {ended.name.lower()}. {ended.advice}")
            distance = self.distance(batch.x)
            if distance == 0.0:
                raise _Stopped(
                    "runs from both sides of the edge met: an event leaves nothing of what parts them, and what decides "
                    "between the fates lies before it"
                )
            alike = batch.mode[0] == batch.mode[1]
            gone = not alike or distance > self.parted
            if gone and (len(times) > 1 or not alike or distance > np.sqrt(self.parted)):
                if alike and len(times) > 1:
                    break
                if last is pair:
                    raise _Stopped(
                        "two starts on either side of the edge are torn apart at once, as at an event that only one of "
                        "them meets: the fates are parted by a jump of the motion, not by a state on the edge"
                    )
                break
            here = batch.x.copy()
            last = _Pair(here, batch.mode.astype(np.int64), batch.standing(both), before + float(batch.elapsed[0]))
            times.append(last.time)
            states.append(last.middle)
            distances.append(distance)
            if gone:
                break
        else:
            raise _Stopped("two starts on either side of the edge did not part; give a longer transient, or more periods")
        width = np.abs(pair.states[1] - pair.states[0]) / 2
        segment = _Segment(np.array(times), np.array(states), np.array(distances), int(pair.modes[0]), width)
        return segment, last


def bracket(codes: np.ndarray) -> tuple[int, int]:
    """The places of the closest 1 and 2, in this order, with neither of these between them.

    Parameters
    ----------
    codes : ndarray of int, shape (K,)
        From a 1 to a 2.
    """
    sides = np.flatnonzero(np.isin(codes, (1, 2)))
    pairs = [(int(i), int(j)) for i, j in zip(sides[:-1], sides[1:], strict=True) if codes[i] == 1 and codes[j] == 2]
    return min(pairs, key=lambda one: one[1] - one[0])


def _unclear(codes: np.ndarray) -> str:
    """Why nothing between two starts leads where one of them does."""
    advice = "give a longer transient, or two starts that are closer to one edge"
    if (codes == OTHER).any():
        return f"starts between the two lead to a third fate, or stay where they are for the length of the runs; {advice}"
    return f"the fates of starts between the two are not decided; {advice}"


def told_by(known: Mapping[str, np.ndarray], found: Mapping[str, np.ndarray]) -> np.ndarray:
    """Codes of the fates of runs, int (P,): 1 or 2 as one of two that are known, 3 as neither, 0 for none.

    Parameters
    ----------
    known, found : mapping of str to ndarray
        What `chaosdrill.analysis.measuring.measure` tells of 2 runs, and of P.
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
    segments: list[_Segment] = []
    chosen, reason, exponents, scale = _two_fates(plan, found, modes), "", None, np.ones(starts.shape[1])
    if len(chosen) == 2:
        # what escapes is larger than anything
        stay = chosen[found["outcome"][chosen] != Outcome.ESCAPED]
        scale = _scale(starts[chosen], batch.window[stay, :, :-1], batch.sizes[stay])
        edge = _Edge(plan, {name: found[name][chosen] for name in KNOWN_BY}, scale, given.closest, given.parted)
        pair = _Pair(starts[chosen], modes[chosen])
        try:
            for done in range(given.rounds + 1):
                if report:
                    report(done)
                segment, pair = edge.follow(edge.bisect(pair))
                segments.append(segment)
        except _Stopped as fault:
            reason = str(fault)
        exponents = exponents_of(plan, segments, scale, job) if segments else None
    else:
        reason = "no two starts of one mode have two fates; give starts on either side of an edge"
        if not np.isin(found["outcome"], (*ATTRACTING, Outcome.ESCAPED)).any():
            reason = f"no start has a fate. {Outcome(int(found['outcome'][0])).advice}"
    if report:
        report(given.rounds + 1)
    track = _Track.of(segments, starts.shape[1])
    told = _judged(plan, track, exponents, scale, given.parted) if segments and not reason else None
    if told is not None and not told.reason and told.outcome == Outcome.UNDECIDED:
        told = told._replace(reason="the track neither returns nor is chaotic beyond the error; give more rounds")
    outcome = Outcome.UNDECIDED if told is None else told.outcome
    if len(chosen) < 2 and (found["outcome"] == Outcome.INVALID_START).all():
        outcome = Outcome.INVALID_START
    return _labelled(plan, starts, found, chosen, segments, track, told, outcome, exponents, reason)


def _labelled(
    plan: Plan,
    starts: np.ndarray,
    found: Mapping[str, np.ndarray],
    chosen: np.ndarray,
    segments: list[_Segment],
    track: "_Track",
    told: "_Judged | None",
    outcome: Outcome,
    exponents: tuple[np.ndarray, np.ndarray] | None,
    reason: str,
) -> xr.Dataset:
    system = plan.system
    n = len(system.state_names)
    rate, error = growth(segments)
    state, width = np.full(n, np.nan), np.full(n, np.nan)
    if segments:
        state, width = segments[-1].states[0], segments[-1].width
        if told is not None and told.outcome in (Outcome.PERIODIC, Outcome.EQUILIBRIUM):
            width = width + change(segments, max(told.period, 1), plan)
    mean, spread = exponents if exponents is not None else np.full((2, _count(plan)), np.nan)
    sides = np.array([*chosen.tolist(), *[-1] * (2 - len(chosen))])
    there = sides >= 0
    blank = {"start": np.full((2, n), np.nan), "state": np.full((2, n), np.nan)}
    blank["start"][there], blank["state"][there] = starts[sides[there]], found["state"][sides[there]]
    return dataset(
        {
            "edge_state": ("state", state),
            "edge_error": ("state", width),
            "edge_mode": ((), np.int8(segments[-1].mode if segments else -1)),
            "period": ((), np.int32(told.period if told else 0)),
            "outcome": ((), np.int8(outcome)),
            "return_distance": ((), told.distance if told else np.nan),
            "growth_rate": ((), rate),
            "growth_rate_error": ((), error),
            "lyapunov_exponent": ("exponent", mean),
            "lyapunov_error": ("exponent", spread),
            "track_time": ("step", track.times),
            "track_state": (("step", "state"), track.states),
            "track_distance": ("step", track.distance),
            "bisection": ("step", track.segment),
            "side_start": (("side", "state"), blank["start"]),
            "side_state": (("side", "state"), blank["state"]),
            "side_period": ("side", np.where(there, found["period"][sides], 0).astype(np.int16)),
            "side_outcome": ("side", np.where(there, found["outcome"][sides], int(Outcome.UNDECIDED)).astype(np.int8)),
            **({"forcing_period": ((), system.forcing_period())} if system.forced else {}),
            "state": list(system.state_names),
            "exponent": np.arange(1, len(mean) + 1, dtype=np.int32),
            "side": np.arange(1, 3, dtype=np.int32),
        },
        attrs={"reason": told.reason if told and not reason else reason} if reason or (told and told.reason) else None,
    )


def _count(plan: Plan) -> int:
    """Exponents of the map along the edge: one fewer across a flow."""
    return len(plan.system.state_names) - plan.at_events


def _two_fates(plan: Plan, found: Mapping[str, np.ndarray], modes: np.ndarray) -> np.ndarray:
    """The first two starts of different fates from which bisection can begin; fewer than two where there are none."""
    fits = np.isin(found["outcome"], (*ATTRACTING, Outcome.ESCAPED))
    for one in np.flatnonzero(fits).tolist():
        codes = told_by({name: found[name][[one, one]] for name in KNOWN_BY}, found)
        others = fits & (codes != 1) & (codes != UNKNOWN) & ((modes == modes[one]) | bool(plan.system.regions))
        if others.any():
            return np.array([one, int(np.flatnonzero(others)[0])])
    return np.zeros(0, dtype=np.int64)


def _scale(starts: np.ndarray, windows: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Units of distances: the extent of the starts and of what they lead to; the size of a state that rests.

    Parameters
    ----------
    starts : ndarray, shape (2, n)
    windows, known : ndarray, shapes (A, W, n), (A, n)
        Points of the attractors, and sizes that states have had on the way there.
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
            np.concatenate([np.zeros(0), *[one.distance[some] for one, some in parts]]),
            np.concatenate([np.zeros(0), *[np.full(len(one.times[some]), k) for k, (one, some) in enumerate(parts, 1)]])
            .astype(np.int32),
        )  # fmt: skip


class _Judged(NamedTuple):
    """What the later half of a track is."""

    outcome: Outcome
    period: int
    distance: float  # largest between states so many steps apart
    reason: str = ""


def _judged(
    plan: Plan, track: _Track, exponents: tuple[np.ndarray, np.ndarray] | None, scale: np.ndarray, parted: float
) -> _Judged:
    late = track.states[len(track.states) // 2 :]
    path, size = plan.shifts.quotient(late), plan.shifts.sizes(scale)
    allowed = EDGES.returns * parted
    if not plan.maps:
        spread = float((np.ptp(path, axis=0) / size).max())
        if spread <= allowed:
            return _Judged(Outcome.EQUILIBRIUM, 0, spread)
    else:
        best, least = 0, np.inf
        for period in range(1, min(plan.max_period, len(path) // 2) + 1):
            far = float((np.abs(path[period:] - path[:-period]) / size).max())
            if far <= allowed:
                at_rest = period == 1 and plan.system.autonomous and not plan.at_events and not plan.system.discrete
                word = Outcome.EQUILIBRIUM if at_rest else Outcome.PERIODIC
                return _Judged(word, 0 if at_rest else period, far)
            best, least = (period, far) if far < least else (best, least)
    if exponents is not None:
        mean, error = exponents
        if int((mean > EDGES.positive * error).sum()) > 1:
            return _Judged(Outcome.CHAOTIC, 0, least if plan.maps else spread)
    reason = "" if plan.maps else "the edge state does not rest; name a section (at) to tell a cycle from its points"
    return _Judged(Outcome.UNDECIDED, 0, least if plan.maps else spread, reason)


def change(segments: list[_Segment], period: int, plan: Plan) -> np.ndarray:
    """How far the last bisected state is from the one before at the same phase of a cycle, shape (n,); 0 without one."""
    begin = np.cumsum([0, *[len(one.times) - 1 for one in segments[:-1]]])
    same = np.flatnonzero((begin[-1] - begin[:-1]) % period == 0)
    now = segments[-1].states[0]
    return np.abs(plan.shifts.across(now - segments[int(same[-1])].states[0])) if len(same) else np.zeros(len(now))


def growth(segments: list[_Segment]) -> tuple[float, float]:
    """Rate at which two motions beside the edge part, and its standard error, from the later half of the segments."""
    late = segments[len(segments) // 2 :]
    grown = np.array([np.log(one.distance[-1] / one.distance[0]) for one in late])
    lasted = np.array([one.times[-1] - one.times[0] for one in late])
    if len(late) < 2 or not lasted.sum() > 0:
        return np.nan, np.nan
    rate = grown.sum() / lasted.sum()
    left = grown - rate * lasted
    return float(rate), float(np.sqrt((left**2).sum() * len(late) / (len(late) - 1)) / lasted.sum())


def exponents_of(
    plan: Plan, segments: list[_Segment], scale: np.ndarray, job: "Job"
) -> tuple[np.ndarray, np.ndarray] | None:
    """Exponents of the edge state and their standard errors, from derivatives of the map along the later half.

    None where the map has no derivative that is known: behind one of several events of a section.
    """
    where, transition = plan.where, -1
    if plan.at_events:
        if len(plan.section or ()) != 1:
            return None
        (transition,) = plan.section or ()
    else:
        where = replace(where, transitions=None, unit=plan.system.forcing_period() or plan.part)
    along = SectionMap(where, 1, job.numerics, segments[0].mode, scale, transition)
    count, lead = _count(plan), len(segments) // 4
    frame = np.linalg.qr(np.random.default_rng(1).standard_normal((len(scale), count)))[0]
    grown, lasted = [], []
    for place, one in enumerate(segments[lead:], lead):
        sums = np.zeros(count)
        for state in one.states[:-1]:
            image = along.image(state, one.mode) if transition < 0 else along.image(state, -1)
            matrix = image.jacobian * scale / scale[:, np.newaxis]
            if image.outcome != Outcome.OK or not np.isfinite(matrix).all():
                return None
            frame, upper = np.linalg.qr(matrix @ frame)
            steps = np.abs(np.diag(upper))
            with np.errstate(divide="ignore"):
                sums += np.log(np.where(steps > EDGES.rank * np.linalg.norm(matrix), steps, 0.0))
        if place >= len(segments) // 2:
            grown.append(sums)
            lasted.append(one.times[-1] - one.times[0])
    sums, times = np.array(grown), np.array(lasted)
    if len(sums) < 2 or not times.sum() > 0:
        return None
    mean = sums.sum(axis=0) / times.sum()
    with np.errstate(invalid="ignore"):
        left = sums - mean * times[:, np.newaxis]
        error = np.sqrt((left**2).sum(axis=0) * len(times) / (len(times) - 1)) / times.sum()
    order = np.argsort(-mean, kind="stable")
    return mean[order], error[order]
