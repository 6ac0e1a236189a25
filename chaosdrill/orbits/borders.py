"""Where the events of an orbit change: a hit or a slip appears or vanishes, two trade places, one comes out otherwise.

A branch of orbits with a given sequence of events goes on smoothly beyond the last one that the system follows. The
border is found by bisection on whether it does. From there the orbits with other sequences are looked for that go
through the same path at the border (di Bernardo, Budd, Champneys and Kowalczyk 2008, doi:10.1007/978-1-84628-708-4).
"""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import chain
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.dataset import Outcome
from chaosdrill.dataset.branches import Special
from chaosdrill.engine import branch
from chaosdrill.engine import lap as at
from chaosdrill.orbits.doubling import repeats
from chaosdrill.orbits.failures import admissible, at_rest
from chaosdrill.orbits.multipliers import based
from chaosdrill.orbits.orbit import Orbit
from chaosdrill.orbits.place import standpoint
from chaosdrill.orbits.reading import eventless, own_path
from chaosdrill.orbits.special import NOISE, ON_CHORD
from chaosdrill.orbits.touching import nearest_touch, slowness, taken

if TYPE_CHECKING:
    from chaosdrill.orbits.family import Family, Lap

BISECTIONS = 60

STEPS = (0.0, 1e-5, -1e-5, 1e-4, -1e-4, 1e-3, -1e-3, 1e-2, -1e-2)
"""Lengths along a new branch at which its first orbit is tried."""

BESIDE = (0.0, 1e-11, -1e-11, 1e-9, -1e-9, 1e-7, -1e-7, 1e-5, -1e-5)
"""Changes of the parameter, relative, at which the events of the system's own path are read."""

NEAR = 0.1
"""Distance from the border, in the norm of the weights, within which an orbit belongs to it."""

MOST_TRIED = 60
"""Sequences of events that are tried behind a border."""

ALIKE = 0.02
"""Difference of durations, as a part of the whole, within which two cycles of the same events are one."""

PROBE = 1e-5
"""Step along a new branch that tells which way leads away from the border."""

PASSED, CLOSER = 64, 5
"""Instants at which it is looked how near an orbit passes, and times that they are laid closer."""

TANGENT = 1e-3
"""Speed relative to how fast a guard changes on the way below which a guard counts as met tangentially at a border."""


@dataclass(frozen=True)
class Border:
    """The last orbit of a sequence of events, what was seen there, and the first one beyond if it could be solved for.

    ``error`` is the distance between the two in the parameter.
    """

    good: "Orbit"
    lap: "Lap"
    bad: "Orbit | None"
    bad_lap: "Lap | None"
    error: float


@dataclass(frozen=True)
class Continuation:
    """An orbit with another sequence of events, behind a border, and which way leads away from it."""

    orbit: "Orbit"
    lap: "Lap"
    ahead: np.ndarray


def bisect(family: "Family", good: "Orbit", bad: "Orbit", weights: np.ndarray) -> Border:
    """The border between an orbit of the system and a solution of the equations that is none."""
    d = family.states
    conditions = ((bad.reduced(d) - good.reduced(d)) * weights**2)[np.newaxis]
    low, high = 0.0, 1.0
    inside, lap_inside = good, family.lap(good)
    outside: Orbit | None = bad
    lap_outside: Lap | None = family.lap(bad)
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        if not low < middle < high:
            break
        code, orbit, lap, _ = family.solve(good.between(bad, middle), conditions, ON_CHORD)
        solved = code == branch.CONVERGED
        if solved and admissible(orbit, lap):
            low, inside, lap_inside = middle, orbit, lap
        else:
            high = middle
            outside, lap_outside = (orbit, lap) if solved else (None, None)
    error = (high - low) * abs(bad.starts[0, -1] - good.starts[0, -1])
    return Border(inside, lap_inside, outside, lap_outside, float(error) + NOISE * abs(float(inside.starts[0, -1])))


def reason(family: "Family", border: Border) -> tuple[Special, str]:
    """What happens at a border behind which nothing goes on, from its last orbit and the first one beyond."""
    system = family.plain
    orbit, lap = (border.good, border.lap) if border.bad is None else (border.bad, border.bad_lap)
    assert lap is not None
    events = orbit.arcs[:, at.ARC_END] >= 0
    names = [system.transitions[k].name if k >= 0 else "" for k in orbit.arcs[:, at.ARC_OUTCOME]]
    for i, (mode, end, outcome) in enumerate(orbit.arcs.tolist()):
        if lap.crossed[i] >= 0:
            came = taken(family, orbit, i, int(lap.crossed[i]), float(lap.met[i]))
            first = family.system.kernels.events[mode][lap.crossed[i]].outcomes[0]
            name = system.transitions[came if came >= 0 else first].name
            if lap.crossed[i] == end and lap.met[i] >= (1 - 1e-6) * orbit.durations[i]:
                # met twice in a row, the second time from behind: between the two it was met at no speed
                return Special.GRAZING, f"{names[i]} vanishes"
            if lap.met[i] <= 1e-6 * orbit.durations[i]:
                return Special.EVENT_SWAP, f"{name} comes to fall together with {names[i - 1]}"
            if lap.met[i] >= (1 - 1e-6) * orbit.durations[i]:
                return Special.EVENT_SWAP, f"{name} comes to fall together with {names[i]}"
            return Special.GRAZING, f"{name} appears"
        if events[i] and lap.came[i] != outcome:
            if lap.came[i] >= 0 and system.transitions[lap.came[i]].name == system.transitions[outcome].completes:
                return Special.REGULAR, f"{names[i]} would come after one rebound more; the branch was not followed on"
            return Special.OUTCOME_SWITCH, f"{names[i]} comes out otherwise"
    slow = slowness(family, orbit, lap)
    short = orbit.durations / orbit.durations.sum()
    if slow.min(initial=np.inf) <= TANGENT:
        return Special.GRAZING, f"{names[int(slow.argmin())]} vanishes"
    if short.min() <= TANGENT:
        i = int(short.argmin())
        return Special.EVENT_SWAP, f"{names[i - 1]} and {names[i]} fall together"
    return Special.REGULAR, ""


def go_on(family: "Family", border: Border, weights_of: "WeightsOf") -> Continuation | None:
    """An orbit behind a border with another sequence of events, if there is one that begins there."""
    tried = [border.good]
    further: list[Orbit] = []
    for guess in chain(_guesses(family, border), _emptied(further)):
        if len(tried) > MOST_TRIED:
            break
        if any(_same_cycle(guess, old) for old in tried):
            continue
        tried.append(guess)
        found = _branch_from(family, guess, border, weights_of, further)
        if found is not None:
            return found
    return None


def _emptied(queue: "list[Orbit]") -> "Iterator[Orbit]":
    while queue:
        yield queue.pop(0)


def recounted(family: "Family", before: "Orbit", after: "Orbit") -> bool:
    """Whether all that changes is after how many rebounds the rest of them is taken as one, which means nothing."""
    transitions = {t.name: t for t in family.plain.transitions}
    old, new = (Counter(o.events(family.plain).split()) for o in (before, after))
    replaced = {transitions[name].completes for name in old} - {None}
    return old != new and all(name in replaced for name in (old - new) + (new - old))


def what_changed(family: "Family", border: Border, after: "Orbit") -> tuple[Special, str]:
    """What happens at a border, from the sequences of events on its two sides, and the speeds at the border itself."""
    system, before = family.plain, border.good
    old, new = (Counter(o.events(system).split()) for o in (before, after))
    # in the order of declaration: where an orbit's sequence begins may be a matter of the last digit
    declared = [t.name for t in system.transitions]
    appeared, vanished = (sorted(changed.elements(), key=declared.index) for changed in (new - old, old - new))
    if len(before) == len(after) and not before.eventless and not after.eventless:
        if not appeared and not vanished:
            return Special.EVENT_SWAP, "two events trade places"
        return Special.OUTCOME_SWITCH, f"{' and '.join(vanished)} becomes {' and '.join(appeared)}"
    parts = []
    for names, one, many in ((appeared, "appears", "appear"), (vanished, "vanishes", "vanish")):
        counted = [f"{k} {name}" if k > 1 else name for name, k in Counter(names).items()]
        if names:
            parts.append(f"{' and '.join(counted)} {one if len(names) == 1 else many}")
    touches = slowness(family, before, border.lap).min() <= TANGENT or nearest_touch(family, before) is not None
    return Special.GRAZING if touches else Special.BORDER_COLLISION, ", ".join(parts)


def _guesses(family: "Family", border: Border) -> "Iterator[Orbit]":
    """Paths with other events: those of the system itself near the border, then those with events left out."""
    d = family.states
    last = border.bad if border.bad is not None else border.good
    for part in BESIDE:
        for orbit in (border.good, last):
            guess = _own_path(family, orbit, orbit.starts[0, d:] * (1 + part))
            if guess is not None:
                yield guess
    yield from left_out(border)
    yield from without_events(family, border.good)


def without_events(family: "Family", orbit: "Orbit") -> "Iterator[Orbit]":
    """The path without any event, if it stays in one mode."""
    if orbit.eventless or len(set(orbit.arcs[:, at.ARC_MODE].tolist())) > 1:
        return
    values = orbit.starts[0, family.states :]
    mode = family.plain.mode_names[orbit.arcs[0, at.ARC_MODE]]
    if family.forced:
        period = family.period_at(orbit)
        assert period is not None
        yield eventless(family, family.strobes([orbit])[0][0, 0], mode, orbit.periods, values, period)
    else:
        total = float(orbit.durations.sum())
        state = family.at([orbit], np.array([[0.5 * float(orbit.durations[0])]]))[0][0, 0]
        arcs = np.array([[orbit.arcs[0, at.ARC_MODE], at.PLANE, -1]], dtype=np.int64)
        yield Orbit(arcs, orbit.periods, np.concatenate([state, values])[np.newaxis], 0.0, np.array([total]))


def _own_path(family: "Family", orbit: "Orbit", values: np.ndarray) -> "Orbit | None":
    """What the system does from the middle of the longest arc on, in the time that the orbit takes."""
    outcome, guess = own_path(family, orbit, values, float(orbit.durations.sum()))
    if outcome != Outcome.OK or guess is None:
        return None
    return based(family, replace(guess, periods=orbit.periods))


def left_out(border: Border) -> "Iterator[Orbit]":
    """The orbit without one event that leads back into its mode, or without two or three that do so together."""
    orbit = border.good
    count = len(orbit)
    if orbit.eventless:
        return
    merit = np.minimum(border.lap.speeds, orbit.durations / orbit.durations.sum())
    for first in np.argsort(merit).tolist():
        for dropped in (1, 2, 3):
            if dropped >= count:
                break
            for shift in range(dropped):
                begin = (first - shift) % count
                turned = _turned(orbit, begin)
                if turned.arcs[0, at.ARC_MODE] == turned.arcs[dropped % count, at.ARC_MODE]:
                    arcs = np.vstack([turned.arcs[dropped], turned.arcs[dropped + 1 :]])
                    durations = np.concatenate(
                        [[turned.durations[: dropped + 1].sum()], turned.durations[dropped + 1 :]]
                    )
                    starts = np.vstack([turned.starts[0], turned.starts[dropped + 1 :]])
                    yield replace(turned, arcs=arcs, durations=durations, starts=starts)


def _turned(orbit: "Orbit", first: int) -> "Orbit":
    """The same path from another arc on, with its phase not reduced to one period."""
    return orbit.rotated(first, None)


def _same_cycle(one: "Orbit", other: "Orbit") -> bool:
    """Whether two orbits have the same events, which take about as long: two that trade places leave a cycle of two."""
    total = float(other.durations.sum())
    return len(one) == len(other) and any(
        np.array_equal(np.roll(one.arcs, k, axis=0), other.arcs)
        and np.abs(np.roll(one.durations, k) - other.durations).max() < ALIKE * total
        for k in range(len(one))
    )


def _branch_from(
    family: "Family", guess: "Orbit", border: Border, weights_of: "WeightsOf", further: "list[Orbit]"
) -> Continuation | None:
    """The branch of orbits with the events of a guess that begins at a border, some way along it.

    Where its orbits cross yet another guard, as two do at once on a symmetric orbit, the system's own path from there
    is added to ``further`` guesses.
    """
    guess = based(family, guess)
    lap = family.lap(guess)
    if lap.outcome != 0 or not np.isfinite(lap.equations).all():
        return None
    weights = weights_of(guess)
    direction = family.direction(guess, lap, weights)
    conditions = (direction * weights**2)[np.newaxis]
    for length in STEPS:
        start = family.moved(guess, lap, length * direction)
        code, orbit, seen, _ = family.solve(start, conditions, ON_CHORD)
        if code != branch.CONVERGED or distance(family, orbit, border.good, weights) > NEAR:
            continue
        if repeats(orbit) or at_rest(family, orbit):
            continue
        if not admissible(orbit, seen):
            if length and admissible(orbit, replace(seen, crossed=np.full(len(orbit), -1))):
                fuller = _own_path(family, orbit, orbit.starts[0, family.states :])
                further += [] if fuller is None else [fuller]
            continue
        ahead = _away(family, orbit, seen, border, weights)
        if ahead is not None:
            return Continuation(orbit, seen, ahead)
    return None


def distance(family: "Family", orbit: "Orbit", other: "Orbit", weights: np.ndarray) -> float:
    """Distance of two orbits at the strobes and in the parameter, in the norm of the weights.

    Without strobes: the largest distance at which one passes a place of the other, and how much longer one takes.
    """
    d = family.states
    apart = float(abs(orbit.starts[0, -1] - other.starts[0, -1])) * weights[-1]
    if not family.forced:
        apart += abs(float(np.log(orbit.durations.sum() / other.durations.sum())))
        if apart > NEAR:
            return apart
        return apart + max(passing(family, *pair, weights[:d]) for pair in ((orbit, other), (other, orbit)))
    here, there = (family.strobes([o])[0][0] for o in (orbit, other))
    if len(here) != len(there):
        return np.inf
    return apart + min(float((np.abs(np.roll(here, k, axis=0) - there) * weights[:d]).max()) for k in range(len(here)))


def passing(family: "Family", orbit: "Orbit", other: "Orbit", weights: np.ndarray) -> float:
    """Distance at which an orbit passes the middle of the longest arc of another one."""
    state = standpoint(family, other)[2]
    total = float(orbit.durations.sum())
    first, width, closest = 0.0, total, np.inf
    for _ in range(CLOSER):
        instants = np.unique(np.linspace(first, first + width, PASSED + 1) % total)
        away = (np.abs(family.at([orbit], instants[np.newaxis])[0][0] - state) * weights).max(axis=1)
        closest = min(closest, float(away.min()))
        width *= 2 / PASSED
        first = float(instants[away.argmin()]) - width / 2
    return closest


def _away(family: "Family", orbit: "Orbit", lap: "Lap", border: Border, weights: np.ndarray) -> np.ndarray | None:
    """The direction that leads away from a border, along orbits that the system follows."""
    direction = family.direction(orbit, lap, weights)
    farthest, away = 0.0, None
    step = max(PROBE, 2 * distance(family, orbit, border.good, weights))
    for sign in (1.0, -1.0):
        moved = family.moved(orbit, lap, sign * step * direction)
        code, there, seen, _ = family.solve(moved, (direction * weights**2)[np.newaxis], ON_CHORD)
        if code == branch.CONVERGED and admissible(there, seen):
            far = distance(family, there, border.good, weights)
            if far > farthest:
                farthest, away = far, sign * direction
    return away


class WeightsOf:
    """Weights of the reduced unknowns of an orbit, for the ranges in which its parameters are followed."""

    def __init__(self, family: "Family", spans: np.ndarray) -> None:
        self._family, self._spans = family, spans

    def __call__(self, orbit: "Orbit") -> np.ndarray:
        return self._family.weights(orbit, self._spans)
