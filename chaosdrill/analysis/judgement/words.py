"""The word for a motion: one table of rules from evidence, for spectra, diagrams, charts and basins.

Evidence is what a record says, each item by a test of its own, see `Evidence`. A rule names a word and what it takes;
the first rule that holds gives the word, and its text is the reason. A larger error bar makes no word easier: it only
ever takes away from what differs from zero, and a torus and a cycle take evidence besides.
"""

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from typing import Self

import numpy as np

from chaosdrill.analysis.judgement.statistics import SURE
from chaosdrill.dataset import Outcome

LATE = 0.25
"""Part of the mean growth that the later half of a chaotic record has at least: on a cycle or a torus that was reached
on the way, and in shear, growth has come to an end. The same part of the mean decay is left to the end on a cycle: on
the way into the narrow channel that a cycle leaves behind, at a fold, there is less and less."""

FOLDS = 2.0
"""Logarithm by which tangents grow in that half, or shrink, at least."""

DIGITS = 36.7
"""Logarithm by which a distance grows at most from round-off to the size of the state. A motion that leaves an unstable
one has no more of it; tangents that grow so far in both halves of a bounded record fold again and again."""

UNMOVED = 1e-3
"""Logarithm by which they do so at most where they do not at all, as those of phases that run evenly."""

STEADY = 0.05
"""Part of the growth of a record by which it differs from a straight line at most where each step has its part, as on a
cycle of any length and in chaos on narrow bands. On a torus growth comes and goes."""

PAUSE, HARDLY, FEWEST = 0.125, 0.1, 4
"""Part of a record in which chaos does not pause, part of the mean growth of a block by which tangents grow or shrink
at most in one of a pause, and blocks of a pause at least. Phases without growth that last so long may have no mean
length; then the exponent is zero, whatever a record shows."""

BOUNDED, STILL = 10.0, 2.0
"""Logarithm by which tangents grow or shrink in a record of a torus at most. It stays bounded there but for shear, in
which it is that of the length. Where averages do not converge faster than any power, as on a torus that has just been
born and still attracts slowly, it is less."""


class Selectable:
    """A dataclass of which some items say one thing of each of P points."""

    def at(self, which: np.ndarray) -> Self:
        """The same of some of the points."""
        of = {field.name: getattr(self, field.name) for field in fields(self)}  # type: ignore[arg-type]
        some = {name: one.at(which) for name, one in of.items() if isinstance(one, Selectable)}
        some |= {name: one[which] for name, one in of.items() if isinstance(one, np.ndarray)}
        return replace(self, **some)  # type: ignore[type-var]


@dataclass
class Evidence(Selectable):
    """What P records say; all arrays have the shape (P,).

    What was not looked at, or cannot be told, is False.
    """

    ended: np.ndarray  # int: what ended the run, or ``OK``
    measured: np.ndarray  # bool: whether exponents were asked for
    lead: np.ndarray  # the largest exponent that is free to have any sign; NaN where one is no number
    margin: np.ndarray  # beyond which it differs from zero
    length: np.ndarray  # time of the record
    rounding: np.ndarray  # part of the sizes of states that errors of the run may add up to from point to point
    late: np.ndarray  # its growth rate over the later half of the record
    quarter: np.ndarray  # logarithm of its growth in the last quarter of the record
    steady: np.ndarray  # bool: tangents grow or shrink as fast all the time, however little, not by shear
    pauses: np.ndarray  # bool: for a good part of the record they hardly grow or shrink, though they do on average
    even: np.ndarray  # bool: they grow so, or their areas do, as where they turn: in chaos on bands of any width
    recurs: np.ndarray  # bool: all late points come back within the tolerance, those of a cycle apart from each other
    exact: np.ndarray  # bool: they come back as exactly as a run allows
    stopped: np.ndarray  # bool: the end of the record does so
    arrives: np.ndarray  # bool: a part at the end of the record does so, in which all tangents shrink
    attracts: np.ndarray  # bool: and nearby motions come closer, by the exponents over whole cycles
    leaving: np.ndarray  # bool: the spread of the record, or what it lacks to a cycle, still grows
    settling: np.ndarray  # bool: it still shrinks
    lengthens: np.ndarray  # bool: turns of a motion without forcing take longer and longer, or are less than three
    rests: np.ndarray  # bool: nothing moves
    stirs: np.ndarray  # bool: it seems to rest where nearby motions leave, or a state too small to be seen grows
    sinks: np.ndarray  # bool: all tangents shrink further than they could if the motion went on
    shrinks: np.ndarray  # bool: all tangents shrink, and none is that of the flow
    flows: np.ndarray  # bool: there are as many exponents of zero as the flow needs, or none is needed
    drifts: np.ndarray  # bool: a state only grows, beyond all its earlier values
    departs: np.ndarray  # bool: it does so at an exponential pace, at the rate that the exponent tells
    winds: np.ndarray  # bool: nothing moves but phases at rates without a common measure
    chaos_possible: np.ndarray  # bool: False for a flow without events of two states, forced of one
    torus_possible: np.ndarray  # bool: False for a forced flow of two states that contracts areas everywhere
    long_cycle: np.ndarray  # bool: a longer record comes back
    torus: np.ndarray  # bool: a part tells the rest, or averages agree, and the 0-1 test calls it regular
    converges: np.ndarray  # bool: averages converge faster than any power
    agrees: np.ndarray  # bool: averages over both halves of the record agree as far as a run allows
    curve: np.ndarray  # bool: instants lie on a closed curve along the flow
    line: np.ndarray  # bool: even closely so
    ordered: np.ndarray  # bool: ordered by an angle that advances evenly, the points run along a curve
    returns: np.ndarray  # bool: they return later than a part shows, or run along a spiral
    cycle_reached: np.ndarray  # bool: the later half comes back to round-off, or its instants lie on a closed curve
    torus_reached: np.ndarray  # bool: the later half is that of a torus by all opinions but that of the exponent
    drawn_in: np.ndarray  # bool: some tangent shrinks in the first quarter of a record that is not ``steady``
    noisy: np.ndarray  # bool: what the motion is of is drawn at events, so that nothing ever repeats
    lasts: np.ndarray  # bool: False where the equations change with time and never come back to what they were

    @classmethod
    def of(cls, points: int, **known: np.ndarray) -> "Evidence":
        """Evidence of ``points`` points, of which nothing else is known; by default all is possible and flows on."""
        given = {
            "ended": np.full(points, int(Outcome.OK)),
            **{name: np.zeros(points) for name in ("lead", "margin", "late", "quarter", "rounding")},
            "length": np.ones(points),
            **{
                name: np.ones(points, bool)
                for name in ("measured", "flows", "chaos_possible", "torus_possible", "lasts")
            },
        } | known
        rest = {field.name: np.zeros(points, bool) for field in fields(cls) if field.name not in given}
        return cls(**given, **rest)

    def put(self, which: np.ndarray, newer: "Evidence") -> None:
        """Take over newer evidence of some points."""
        for field in fields(self):
            getattr(self, field.name)[which] = getattr(newer, field.name)

    @property
    def positive(self) -> np.ndarray:
        """Whether the leading exponent is distinctly positive."""
        return self.lead > self.margin

    @property
    def negative(self) -> np.ndarray:
        """Whether it is distinctly negative."""
        return self.lead < -self.margin

    @property
    def grows_on(self) -> np.ndarray:
        """Whether tangents grow in the later half of the record as well."""
        return (self.late > LATE * self.lead) & (self.late * self.length > 2 * FOLDS)

    @property
    def folds(self) -> np.ndarray:
        """Whether tangents grow further than those of any one departure, and do so once more to the end, stationarily.

        To the end is in the later half or in the last quarter.

        In intermittent motion the error of the mean growth is often nearly as large as the mean.
        """
        later, whole = self.late * self.length / 2, self.lead * self.length
        stationary = ~self.leaving & ~self.settling & ~self.recurs & ~self.stopped
        beyond = self.lead > self.margin / SURE
        halves = (later > DIGITS) & (whole - later > DIGITS)
        late = (self.quarter > DIGITS) & (whole - self.quarter > DIGITS)
        return self.chaos_possible & stationary & beyond & (halves | late)

    @property
    def reached_cycle(self) -> np.ndarray:
        """Whether the later half is on a cycle, and nearby motions come closer there, or stay."""
        growth = self.late * self.length
        return self.cycle_reached & ~self.lengthens & ((growth < -2 * FOLDS) | (np.abs(growth) <= UNMOVED))

    @property
    def reached_torus(self) -> np.ndarray:
        """Whether the later half is on a torus, along which tangents do not grow, and the earlier was on its way there.

        There some grow or shrink. Exchanges of intervals follow one angle for a while, and then another, without.
        """
        return self.torus_reached & self.may_have_reached_torus & ~self.recurs & ~self.returns

    @property
    def may_have_reached_torus(self) -> np.ndarray:
        """Whether that is so by the growth of tangents."""
        return self.torus_possible & (self.moved_before | self.drawn_in) & self.sheared

    @property
    def moved_before(self) -> np.ndarray:
        """Whether the tangent that tells grows or shrinks in the earlier half of the record."""
        with np.errstate(invalid="ignore"):
            return np.abs(self.lead - self.late / 2) * self.length > STILL

    @property
    def may_be_torus(self) -> np.ndarray:
        """Whether tangents grow so little that it may count as a torus, or as one that was reached, by its points."""
        of_itself = self.torus_possible & (self.bounded | self.sheared)
        return of_itself | self.may_have_reached_torus | self.may_follow

    @property
    def falls_on(self) -> np.ndarray:
        """Whether they shrink in the later half as well."""
        return np.isneginf(self.lead) | ((self.late < LATE * self.lead) & (self.late * self.length < -2 * FOLDS))

    @property
    def regular(self) -> np.ndarray:
        """Whether it is a torus by all opinions: tangents do not grow, in themselves, not only against their error."""
        still = self.settled | (self.converges & self.bounded)
        return self.torus & self.torus_possible & self.apart & ~self.steady & still

    @property
    def follows(self) -> np.ndarray:
        """Whether it is a torus of drives without a common period, to which nearby motions come closer."""
        stationary = ~self.settling & ~self.leaving & ~self.drifts
        return self.may_follow & self.torus & self.converges & self.apart & stationary

    @property
    def goes_round(self) -> np.ndarray:
        """Whether instants lie on a closed curve, along which tangents do not grow, or which follows a drive."""
        return self.curve & (self.bounded | self.may_follow)

    @property
    def may_follow(self) -> np.ndarray:
        """Whether that is so by the growth of tangents."""
        return ~self.lasts & self.negative & self.falls_on

    @property
    def settled(self) -> np.ndarray:
        """Whether tangents hardly grow in a stationary record, so that averages of a torus need not converge."""
        return ~self.settling & ~self.leaving & (np.abs(self.lead) * self.length <= STILL)

    @property
    def in_order(self) -> np.ndarray:
        """Whether the points are those of a torus by their order, and tangents do not grow but for shear."""
        return self.ordered & self.torus_possible & self.apart & ~self.steady & (self.bounded | self.sheared)

    @property
    def apart(self) -> np.ndarray:
        """Whether the points do not come back, or do so within the tolerance since they are on a curve that small."""
        return ~self.recurs | (self.ordered & self.torus)

    @property
    def sheared(self) -> np.ndarray:
        """Whether tangents grow or shrink so little in the later half that it may be shear."""
        return np.abs(self.late) * self.length <= 2 * STILL

    @property
    def unmoved(self) -> np.ndarray:
        """Whether tangents neither grow nor shrink."""
        return np.abs(self.lead) * self.length <= UNMOVED

    @property
    def stays(self) -> np.ndarray:
        """Whether tangents do not grow, not even by less than can be told from chance if they do so evenly."""
        return (self.lead * self.length <= UNMOVED) | (~self.even & (self.lead * self.length <= STILL))

    @property
    def bounded(self) -> np.ndarray:
        """Whether tangents grow or shrink little in the whole record."""
        return np.abs(self.lead) * self.length <= BOUNDED


@dataclass(frozen=True)
class Rule:
    """What it takes for a word."""

    word: Outcome
    holds: Callable[[Evidence], np.ndarray]
    reason: str


RULES = (
    Rule(Outcome.TRANSIENT, lambda e: e.stirs, "it seems to rest, or to repeat, where it will move on"),
    Rule(Outcome.EQUILIBRIUM, lambda e: e.rests, "nothing moves"),
    Rule(Outcome.PERIODIC, lambda e: ~e.measured & e.recurs, "the points come back; no exponent was requested"),
    Rule(Outcome.OK, lambda e: ~e.measured, "no exponent was requested"),
    Rule(Outcome.NONFINITE, lambda e: np.isnan(e.lead), "an exponent is not a number"),
    Rule(Outcome.EQUILIBRIUM, lambda e: e.sinks, "all tangents shrink beyond round-off, that of the flow as well"),
    Rule(
        Outcome.TRANSIENT,
        lambda e: e.shrinks,
        "all tangents shrink, that of the flow as well: the motion comes to rest",
    ),
    Rule(
        Outcome.TRANSIENT, lambda e: ~e.flows, "no exponent is zero for the flow: the motion leaves, or comes to rest"
    ),
    Rule(Outcome.QUASIPERIODIC, lambda e: e.winds & ~e.positive, "nothing moves but phases without a common measure"),
    Rule(Outcome.PERIODIC, lambda e: e.exact & ~e.leaving, "the points come back to round-off"),
    Rule(Outcome.PERIODIC, lambda e: e.attracts, "the points come back, and nearby motions come closer"),
    Rule(
        Outcome.PERIODIC,
        lambda e: e.reached_cycle,
        "its later half comes back to round-off, or lies on a closed curve, and nearby motions come closer, or stay",
    ),
    Rule(
        Outcome.PERIODIC,
        lambda e: e.arrives & ~e.lengthens,
        "at its end the points come back to round-off, and nearby motions come closer",
    ),
    Rule(
        Outcome.QUASIPERIODIC,
        lambda e: e.reached_torus,
        "its later half is on a torus, and tangents do not grow",
    ),
    Rule(Outcome.TRANSIENT, lambda e: e.positive & e.leaving, "it grows evenly away from where it began"),
    Rule(
        Outcome.TRANSIENT, lambda e: e.positive & e.settling, "its extent, or its distance from a cycle, still shrinks"
    ),
    Rule(Outcome.TRANSIENT, lambda e: e.positive & e.stopped, "at its end the points come back to round-off"),
    Rule(Outcome.TRANSIENT, lambda e: e.positive & ~e.chaos_possible, "tangents grow in a flow that has no chaos"),
    Rule(
        Outcome.CHAOTIC,
        lambda e: e.positive & e.grows_on & ~e.pauses,
        "the largest exponent is positive beyond its error, to the end of a stationary record",
    ),
    Rule(
        Outcome.CHAOTIC,
        lambda e: e.folds & ~e.pauses,
        "tangents grow further than in any departure, and once more to the end of a stationary record",
    ),
    Rule(
        Outcome.CONTRACTING,
        lambda e: e.noisy & e.negative & e.falls_on & ~e.leaving,
        "nearby motions under the same noise come closer to the end",
    ),
    Rule(
        Outcome.PERIODIC,
        lambda e: e.negative & e.falls_on & ~e.leaving & ~e.drifts & ~e.lengthens & e.lasts,
        "nearby motions come closer to the end",
    ),
    Rule(
        Outcome.OPEN, lambda e: ~e.positive & e.drifts & ~e.departs, "a state only grows, beyond all its earlier values"
    ),
    Rule(
        Outcome.PERIODIC,
        lambda e: ~e.positive & e.long_cycle & e.stays,
        "a longer record comes back, and tangents do not grow",
    ),
    Rule(
        Outcome.QUASIPERIODIC,
        lambda e: ~e.positive & (e.regular | e.follows),
        "a part of it tells the rest as that of a torus, or smooth averages agree, and tangents do not grow",
    ),
    Rule(
        Outcome.QUASIPERIODIC,
        lambda e: e.in_order & ~e.leaving,
        "ordered by an angle that advances evenly, the points run along a curve, and tangents do not grow",
    ),
    Rule(
        Outcome.PERIODIC,
        lambda e: ~e.positive & e.goes_round & (e.falls_on | e.line & (e.agrees | e.unmoved)),
        "its instants lie on a closed curve, and nearby motions come closer, or stay, or averages agree to round-off",
    ),
    Rule(Outcome.TRANSIENT, lambda e: e.leaving, "it grows evenly away from where it began"),
    Rule(Outcome.TRANSIENT, lambda e: e.settling, "its extent, or its distance from a cycle, still shrinks"),
    Rule(Outcome.UNDECIDED, lambda e: np.ones_like(e.recurs), "the evidence does not suffice for any other word"),
)
"""In the order in which they are tried."""


def steady(course: np.ndarray) -> np.ndarray:
    """Whether logarithms of growth, shape (P, B + 1), at the ends of blocks of one length, follow a straight line."""
    times = np.linspace(-0.5, 0.5, course.shape[1])
    with np.errstate(invalid="ignore", over="ignore"):
        off = course - course.mean(axis=1, keepdims=True)
        grown = off @ times / (times @ times)
        rest = np.sqrt(((off - grown[:, np.newaxis] * times) ** 2).mean(axis=1))
        return np.asarray((np.abs(grown) > UNMOVED) & (rest <= STEADY * np.abs(grown)))


def pauses(course: np.ndarray) -> np.ndarray:
    """Whether logarithms of growth, as in `steady`, hardly change in a good part of a record in which they do grow."""
    growth = np.diff(course, axis=1)
    count = max(FEWEST, round(PAUSE * growth.shape[1]))
    if count > growth.shape[1]:
        return np.zeros(len(course), dtype=bool)
    with np.errstate(invalid="ignore"):
        still = np.abs(growth) <= HARDLY * growth.mean(axis=1, keepdims=True)
    spans: np.ndarray = np.lib.stride_tricks.sliding_window_view(still, count, axis=1)
    return np.asarray((spans.sum(axis=2) == count).any(axis=1))


def rule_of(evidence: Evidence) -> np.ndarray:
    """Number of the first rule that holds; shape (P,)."""
    found, open_ = np.zeros(len(evidence.lead), dtype=np.int64), np.ones(len(evidence.lead), dtype=bool)
    with np.errstate(invalid="ignore"):
        for number, rule in enumerate(RULES):
            holds = open_ & rule.holds(evidence)
            found[holds], open_[holds] = number, False
            if not open_.any():
                break
    return found


def words(evidence: Evidence) -> np.ndarray:
    """Outcomes of records; int, shape (P,)."""
    codes = np.array([int(rule.word) for rule in RULES])[rule_of(evidence)]
    return np.where(evidence.ended == Outcome.OK, codes, evidence.ended)


def reason(evidence: Evidence) -> str:
    """Why the first of the records has its word; empty for one that came to an early end."""
    return RULES[int(rule_of(evidence)[0])].reason if evidence.ended[0] == Outcome.OK else ""
