"""Where accuracy is measured: a start on the attractor, the cycle through it if there is one, and stored restarts."""

from collections.abc import Collection
from dataclasses import dataclass
from typing import Any

import mpmath
import numpy as np

from chaosdrill.analysis.judgement.recurrence import find_period, powers_of_two
from chaosdrill.analysis.judgement.statistics import standard_error
from chaosdrill.analysis.precision.reference import DIGITS, Exact, Itinerary, Point, Truth, find_truth
from chaosdrill.analysis.recording import Record, record
from chaosdrill.analysis.spans import Span
from chaosdrill.analysis.tuning import PRECISION
from chaosdrill.dataset import Outcome
from chaosdrill.engine import layout as at
from chaosdrill.engine.methods import METHODS
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run
from chaosdrill.model import HybridSystem

TIGHT = 1e-15
TIGHT_METHODS = sorted(
    (name for name, one in METHODS.items() if not one.fixed_step),
    key=lambda name: (METHODS[name].tightest, METHODS[name].series),
)
"""Methods that survey an attractor and that others are held against, in order of preference: one may fail where a field
is stiff, not analytic, or too steep for it. First come those that reach the last digits, and of them those that need
no series."""


@dataclass(frozen=True)
class UnitEvents:
    """Transitions of a unit in order, their distance in time from its ends, and the smallest normal speed."""

    transitions: tuple[int, ...]
    inside: float
    slowest: float


@dataclass(frozen=True)
class Survey:
    """A run along the attractor, unit by unit."""

    system: HybridSystem
    outcome: Outcome
    states: np.ndarray  # (units, n): at the start of each unit
    modes: list[str]  # at the start of each unit
    tangents: np.ndarray  # (units, n): leading tangent there
    rates: np.ndarray  # (units,): its growth over the unit per unit of time
    events: list[UnitEvents]  # what happens in each unit
    numerics: Numerics  # method that has come to the end, at a tight tolerance
    sizes: np.ndarray  # (n,): powers of two near the largest values of the states, in which errors are counted

    @property
    def exponent(self) -> tuple[float, float]:
        """Leading exponent and its standard error; -inf without an error if events leave no tangent."""
        if np.isneginf(self.rates).any():
            return float("-inf"), float("nan")
        if not len(self.rates) or not np.isfinite(self.rates).all():
            return float("nan"), float("nan")
        return float(self.rates.mean()), float(standard_error(self.rates))

    def restarts(self) -> list[int]:
        """Numbers of the units that are computed again by every method."""
        return sorted(set(np.linspace(0, len(self.states) - 1, PRECISION.restarts).astype(int).tolist()))

    def start(self, i: int) -> HybridSystem:
        """The system with the state at the start of a unit as its initial state."""
        return restart(self.system, self.states[i], self.modes[i])

    def typical(self) -> int:
        """Number of a unit that has as many kinds of events, and as many events, as any, and is typical of those.

        Of the half whose events lie farther inside of the unit (one at its very start would say little of the arc
        before it) it is the one in the middle by its smallest normal speed.
        """
        most = max((len(set(e.transitions)), len(e.transitions)) for e in self.events)
        rich = [i for i, e in enumerate(self.events) if (len(set(e.transitions)), len(e.transitions)) == most]
        inner = sorted(rich, key=lambda i: -self.events[i].inside)[: (len(rich) + 1) // 2]
        return sorted(inner, key=lambda i: self.events[i].slowest)[len(inner) // 2]


def survey(system: HybridSystem, plan: Span, judged: Collection[str] = ()) -> Survey:
    """Let the transient pass, then keep the state at the start of every unit; by a method that is not judged, if any.

    Those that reach the last digits come first.
    """
    for method in sorted(TIGHT_METHODS, key=lambda name: (METHODS[name].tightest, name in judged)):
        found = _survey(system, plan, Numerics(method, TIGHT))
        if found.outcome == Outcome.OK:
            break
    return found


def _survey(system: HybridSystem, plan: Span, numerics: Numerics) -> Survey:
    n = len(system.state_names)
    # no direction of a model is likely to be orthogonal to this one; it is the same whatever states are measured in
    direction = np.sqrt(np.arange(2.0, n + 2.0)) * _sizes_met(system, plan, numerics)
    run = Run(system, plan.unit, numerics, tangents=direction[np.newaxis] / np.linalg.norm(direction))
    outcome = plan.settle(run)
    states, modes, tangents, rates, events = [], [], [], [], []
    for _ in range(plan.count):
        if outcome != Outcome.OK:
            break
        state, mode, before = run.x.copy(), run.mode, run.logs[0]
        tangents.append(_directed(run.vectors[0]))
        found = record(run, 1, events=True)
        outcome = found.outcome
        if outcome == Outcome.OK:
            states.append(state)
            modes.append(mode)
            rates.append(-np.inf if run.lost[0] else (run.logs[0] - before) / plan.unit)
            events.append(_unit_events(found, found.times - (run.elapsed - plan.unit), plan.unit))
    count = len(states)
    points, directions = (
        np.array(rows).reshape(-1, n) for rows in (states, [*tangents[:count], _directed(run.vectors[0])])
    )
    sizes = powers_of_two(np.fmax(np.abs(points).max(axis=0, initial=0.0), run.sizes))
    # lengths in these sizes, as `growth` takes them
    with np.errstate(divide="ignore", invalid="ignore"):
        lengths = np.diff(np.log(np.linalg.norm(directions / sizes, axis=1)))
    grown = np.array(rates)
    grown = np.where(np.isfinite(grown), grown + lengths / plan.unit, grown)
    return Survey(system, outcome, points, modes, directions[:count], grown, events, numerics, sizes)


def _sizes_met(system: HybridSystem, plan: Span, numerics: Numerics) -> np.ndarray:
    """Powers of two near the sizes that states have had by the end of the transient and of a unit after it."""
    run = Run(system, plan.unit, numerics)
    if plan.settle(run) == Outcome.OK:
        run.advance(1)
    sizes = powers_of_two(run.sizes)
    return np.where(np.isfinite(sizes), sizes, 1.0)


def _directed(tangent: np.ndarray) -> np.ndarray:
    """A tangent of length 1, or zero."""
    unit: np.ndarray = tangent / max(np.linalg.norm(tangent), 1e-300)
    return unit


def _unit_events(found: Record, times: np.ndarray, unit: float) -> UnitEvents:
    if not len(times):
        return UnitEvents((), 0.0, 0.0)
    inside = float(min(times.min(), unit - times.max()))
    slowest = float(np.abs(found.events[:, at.EVENT_SPEED]).min())
    return UnitEvents(tuple(found.transitions.tolist()), inside, slowest)


def restart(system: HybridSystem, x: Any, mode: str) -> HybridSystem:
    """The system with a state of a run as its initial state."""
    return system.with_initial(mode=mode, **dict(zip(system.state_names, map(float, x), strict=True)))


@dataclass(frozen=True)
class Mapped:
    """What one run over the stretch gives: state, tangent map and events."""

    outcome: Outcome
    state: np.ndarray
    tangent: np.ndarray
    found: Record
    mode: str
    sizes: np.ndarray


def run_map(system: HybridSystem, unit: float, count: int, numerics: Numerics) -> Mapped:
    """One run from the initial state over ``count`` units with the whole tangent map."""
    run = Run(system, unit, numerics, tangents=np.eye(len(system.state_names)), orthonormalise=False)
    found = record(run, count, events=True)
    return Mapped(found.outcome, run.x.copy(), run.vectors.T.copy(), found, run.mode, run.sizes)


def find_cycle(
    system: HybridSystem, unit: float, period: int, numerics: Numerics, steps: int = PRECISION.start_newton
) -> tuple[HybridSystem, Mapped | None]:
    """The cycle of one method near the initial state, by Newton's method, (I - M) d = map(x) - x; None if it fails."""
    for _ in range(steps):
        mapped = run_map(system, unit, period, numerics)
        if mapped.outcome != Outcome.OK or mapped.mode != system.initial["mode"]:
            return system, None
        x = np.array(system.initial_values)
        try:
            correction = np.linalg.solve(np.eye(len(x)) - mapped.tangent, mapped.state - x)
        except np.linalg.LinAlgError:
            return system, None
        size = np.maximum(np.abs(x), mapped.sizes)
        if not np.isfinite(correction).all() or (np.abs(correction) > 1e-2 * size).any():
            return system, None
        system = restart(system, x + correction, mapped.mode)
        if (np.abs(correction) <= 1e-15 * size).all():
            break
    return system, run_map(system, unit, period, numerics)


@dataclass(frozen=True)
class Place:
    """The stretch on which methods are compared."""

    system: HybridSystem  # with the start as its initial state
    unit: float  # length of a unit of time, the forcing period of a forced system
    sizes: np.ndarray  # (n,): those in which states, and their errors, are counted
    period: int  # period of the cycle, 0 if there is none
    truth: Truth | None  # in extended precision
    reason: str = ""  # why there is no truth

    @property
    def count(self) -> int:
        """Units of the stretch: the period of the cycle, or 1."""
        return max(self.period, 1)


def find_place(found: Survey, plan: Span) -> Place:
    """The cycle that the run has settled on, or else a unit with many events, and the truth about it."""
    period = find_period(found.states, found.sizes, PRECISION.max_period) if plan.periodic else 0
    if period:
        system, mapped = find_cycle(found.start(-1), plan.unit, period, found.numerics)
        if mapped is not None:
            return _true_place(system, plan.unit, found.sizes, period, mapped)
    system = found.start(found.typical())
    return _true_place(system, plan.unit, found.sizes, 0, run_map(system, plan.unit, 1, found.numerics))


def _true_place(system: HybridSystem, unit: float, sizes: np.ndarray, period: int, mapped: Mapped) -> Place:
    start = [mpmath.mpf(system.initial[name] / size) for name, size in zip(system.state_names, sizes, strict=True)]
    try:
        if period:
            start = _onto_cycle(system, unit, sizes, start, period, mapped)
            system = restart(system, [a * size for a, size in zip(start, sizes, strict=True)], mapped.mode)
        truth = find_truth(system, unit, sizes, start, itinerary(mapped.found), max(period, 1))
    # arithmetic can fail in many ways far outside of what a system is made for
    except (ArithmeticError, ValueError, TypeError, np.linalg.LinAlgError) as fault:
        return Place(system, unit, sizes, period, None, str(fault))
    if period:
        open_by = max(float(abs(a - b)) for a, b in zip(truth.state, truth.start, strict=True))
        truth.errors["strobe"] = max(truth.errors["strobe"], open_by)
    return Place(system, unit, sizes, period, truth)


def _onto_cycle(
    system: HybridSystem, unit: float, sizes: np.ndarray, start: Point, period: int, mapped: Mapped
) -> Point:
    """Newton's method for the cycle in extended precision, with the tangent map of doubles; a step or two."""
    tangent = mapped.tangent * sizes / sizes[:, np.newaxis]
    inverse = mpmath.matrix(np.linalg.inv(np.eye(len(start)) - tangent).tolist())
    with mpmath.workdps(DIGITS):
        exact = Exact(system, unit, sizes)
        for _ in range(PRECISION.start_newton):
            end = exact.follow(start, itinerary(mapped.found), period, PRECISION.columns, PRECISION.tolerance)
            residual = [a - b for a, b in zip(end.state, start, strict=True)]
            start = [a + b for a, b in zip(start, inverse * mpmath.matrix(residual), strict=True)]
            # the next residual is smaller by the relative error of the tangent map, 1e-8 at worst
            if max(abs(a) for a in residual) < 1e-16:
                break
    return start


def itinerary(found: Record) -> Itinerary:
    """Which events a recorded stretch holds, and about when."""
    strobes, times = found.events[:, [at.EVENT_STROBES, at.EVENT_TIME]].T
    return list(zip(strobes.astype(int).tolist(), times.tolist(), found.transitions.tolist(), strict=True))
