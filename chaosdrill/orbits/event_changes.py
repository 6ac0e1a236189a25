"""Changes of the event sequence: an event appears or vanishes, two trade places, or one has another outcome.

A branch of orbits with a given sequence of events goes on smoothly beyond the last one that the system follows. The
border is found by bisection on whether it does. From there the orbits with other sequences are looked for that go
through the same path at the border (di Bernardo, Budd, Champneys and Kowalczyk 2008, doi:10.1007/978-1-84628-708-4).
"""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from math import gcd
from typing import NamedTuple

import numpy as np

from chaosdrill.codegen import kernels_of
from chaosdrill.dataset import Outcome
from chaosdrill.dataset.branches import Special
from chaosdrill.engine import shooting as at
from chaosdrill.model.transition import REFLECTION
from chaosdrill.orbits.curve import Curve
from chaosdrill.orbits.find import at_rest
from chaosdrill.orbits.guards_met import nearest_touch, slowness, taken, touches
from chaosdrill.orbits.guess import eventless, own_path, standpoint
from chaosdrill.orbits.multipliers import based
from chaosdrill.orbits.orbit import Orbit
from chaosdrill.orbits.points import Border
from chaosdrill.orbits.problem import CONVERGED, Problem, Shot, admissible
from chaosdrill.orbits.sliding import switched, unswitched
from chaosdrill.orbits.tuning import TUNING


@dataclass(frozen=True)
class Continuation:
    """An orbit with another sequence of events beyond a border, and the direction that leads away from it."""

    orbit: Orbit
    shot: Shot
    ahead: np.ndarray


class Change(NamedTuple):
    """What happens to the events at a border."""

    kind: Special  # REGULAR: nothing that is known
    text: str


def change_at(problem: Problem, border: Border, after: Orbit | None = None) -> Change:
    """What happens at a border.

    ``after``: the first orbit of the branch beyond; without one the border ends the branch.
    """
    return _met_at(problem, border) if after is None else _changed(problem, border, after)


def _met_at(problem: Problem, border: Border) -> Change:
    """What happens at a border, from its last orbit and the first one beyond, which the system does not follow."""
    system = problem.plain
    orbit, shot = (border.good, border.shot) if border.bad is None else (border.bad, border.bad_shot)
    assert shot is not None
    events = orbit.segments[:, at.SEGMENT_END] >= 0
    names = [system.transitions[k].name if k >= 0 else "" for k in orbit.segments[:, at.SEGMENT_OUTCOME]]
    for i, (mode, end, outcome) in enumerate(orbit.segments.tolist()):
        if shot.crossed[i] >= 0:
            came, _ = taken(problem, orbit, i, int(shot.crossed[i]), float(shot.met[i]))
            first = kernels_of(problem.system).layout.events[mode][shot.crossed[i]].outcomes[0]
            name = system.transitions[came if came >= 0 else first].name
            if shot.crossed[i] == end and shot.met[i] >= (1 - TUNING.end_of_stay) * orbit.durations[i]:
                # met twice in a row, the second time from behind: between the two it was met at no speed
                return Change(Special.GRAZING, _told(_slow_events(problem, orbit, shot, i), "vanishes", "vanish"))
            if shot.met[i] <= TUNING.end_of_stay * orbit.durations[i]:
                return Change(Special.EVENT_SWAP, f"{name} coincides with {names[i - 1]}")
            if shot.met[i] >= (1 - TUNING.end_of_stay) * orbit.durations[i]:
                return Change(Special.EVENT_SWAP, f"{name} coincides with {names[i]}")
            return Change(Special.GRAZING, f"{name} appears")
        if events[i] and shot.came[i] != outcome:
            if shot.came[i] >= 0 and system.transitions[shot.came[i]].name == system.transitions[outcome].completes:
                told = f"{names[i]} would come after one more rebound; the branch was not followed further"
                return Change(Special.REGULAR, told)
            return Change(Special.OUTCOME_SWITCH, f"{names[i]} has another outcome")
    slow = slowness(problem, orbit, shot)
    short = orbit.durations / orbit.durations.sum()
    if slow.min(initial=np.inf) <= TUNING.tangential:
        slowest = _slow_events(problem, orbit, shot, int(slow.argmin()))
        return Change(Special.GRAZING, _told(slowest, "vanishes", "vanish"))
    if short.min() <= TUNING.tangential:
        i = int(short.argmin())
        return Change(Special.EVENT_SWAP, f"{names[i - 1]} and {names[i]} coincide")
    return Change(Special.REGULAR, "")


def _slow_events(problem: Problem, orbit: Orbit, shot: Shot, one: int) -> list[str]:
    """Names of the event that ends a segment and of all that have lost their speed with it, in order of declaration."""
    ends = np.flatnonzero(slowness(problem, orbit, shot) <= TUNING.touching)
    came = np.union1d(orbit.segments[ends, at.SEGMENT_OUTCOME], orbit.segments[one, at.SEGMENT_OUTCOME])
    return [problem.plain.transitions[k].name for k in came.tolist()]


def _told(names: Sequence[str], one: str, many: str) -> str:
    """Events and what happens to them."""
    counted = [f"{k} {name}" if k > 1 else name for name, k in Counter(names).items()]
    return f"{' and '.join(counted)} {one if len(names) == 1 else many}"


def _changed(problem: Problem, border: Border, after: Orbit) -> Change:
    """What happens at a border, from the sequences of events on its two sides, and the speeds at the border itself."""
    system, before = problem.plain, border.good
    if recounted(problem, before, after) or reflected(problem, before, after):
        return Change(Special.REGULAR, "")
    old, new = (Counter(o.events(system)) for o in (before, after))
    # in the order of declaration: where an orbit's sequence begins may be a matter of the last digit
    declared = [t.name for t in system.transitions]
    appeared, vanished = (sorted(changed.elements(), key=declared.index) for changed in (new - old, old - new))
    slow = slowness(problem, before, border.shot).min(initial=np.inf)
    touched = nearest_touch(problem, before) is not None
    traded = slow <= TUNING.touching and touched
    if len(before) == len(after) and not before.eventless and not after.eventless and not traded:
        if not appeared and not vanished:
            return Change(Special.EVENT_SWAP, "two events change their order")
        return Change(Special.OUTCOME_SWITCH, f"{' and '.join(vanished)} becomes {' and '.join(appeared)}")
    told = ((appeared, "appears", "appear"), (vanished, "vanishes", "vanish"))
    parts = [_told(*one) for one in told if one[0]]
    grazes = slow <= TUNING.tangential or touched
    return Change(Special.GRAZING if grazes else Special.BORDER_COLLISION, ", ".join(parts))


def branch_behind(curve: Curve, border: Border) -> Continuation | None:
    """An orbit beyond a border with another sequence of events, if a branch begins there."""
    tried = [border.good]
    further: list[Orbit] = []
    for guess in _all_changed(curve.problem, border):
        # where it begins no branch, others with these events may do so at guesses further off
        found = _branch_from(curve, guess, border, [])
        if found is not None:
            return found
    shot = curve.problem.shoot(border.good, False)
    ways = _ways(curve, border, shot)
    ahead = (_branch_from(curve, guess, border, further) for guess in _own_ahead(curve, border, shot, ways))
    # with several ways, which events come near the border is a matter of the errors of the orbits there
    if len(ways) > 1 and (found := next(filter(None, ahead), None)) is not None:
        return found
    # what is found on the way is tried last
    for guess in chain(_guesses(curve, border), further):
        if len(tried) > TUNING.border_tried:
            break
        if any(_same_cycle(guess, old) for old in tried):
            continue
        tried.append(guess)
        found = _branch_from(curve, guess, border, further)
        # the branch itself comes again, nearer to a border that takes ever longer
        if found is not None and not _same_cycle(found.orbit, border.good):
            return found
    # these are tried though the same events were, nearer to the border
    return next(filter(None, ahead), None)


def recounted(problem: Problem, before: Orbit, after: Orbit) -> bool:
    """Whether only the number of rebounds before chatter is completed changes, which means nothing."""
    transitions = {t.name: t for t in problem.plain.transitions}
    old, new = (Counter(o.events(problem.plain)) for o in (before, after))
    replaced = {transitions[name].completes for name in old} - {None}
    return old != new and all(name in replaced for name in (old - new) + (new - old))


def reflected(problem: Problem, before: Orbit, after: Orbit) -> bool:
    """Whether only reflections change their places among the same events, which at most become their images.

    An event that passes a reflection becomes its image, and two reflections in one instant cancel.
    """
    transitions = problem.plain.transitions
    reflects = np.array([t.kind == REFLECTION for t in transitions])
    if not reflects.any():
        return False
    lists = []
    for orbit in (before, after):
        ends = np.flatnonzero(orbit.segments[:, at.SEGMENT_END] >= 0)
        came, times = orbit.segments[ends, at.SEGMENT_OUTCOME], orbit.durations.cumsum()[ends]
        names = np.array([transitions[k].name for k in came.tolist()], dtype=object)
        known = ~reflects[came]
        lists.append((names[known], times[known], times[~known], float(orbit.durations.sum())))
    (names, times, _, total), (others, _, _, _) = lists
    if len(names) != len(others):
        return False

    def beside(one: tuple, place: float, within: float) -> bool:
        """Whether a reflection comes in the same instant."""
        return bool((np.abs(_in_turn(one[2] - place, one[3])) <= within).any())

    for k in range(len(names)):
        later = np.roll(lists[1][1], -k)
        off = float(np.abs(_in_turn(times - times[0] - (later - later[0]), total)).max())
        within = 2 * off + TUNING.end_of_stay * total
        if off < TUNING.same_cycle * total and all(
            one == other or (beside(lists[0], here, within) and beside(lists[1], there, within))
            for one, other, here, there in zip(names, np.roll(others, -k), times, later, strict=True)
        ):
            return True
    return not len(names)


def _in_turn(times: np.ndarray, total: float) -> np.ndarray:
    """Differences of times on a cycle of this length, of the smallest size."""
    return np.asarray((times + total / 2) % total - total / 2)


def _guesses(curve: Curve, border: Border) -> Iterator[Orbit]:
    """Paths with other events: other outcomes, those of the system itself near the border, those with events left out.

    Parameters are changed by parts of their sizes, or of the range where they are zero.
    """
    problem = curve.problem
    d = problem.states
    yield from _other_outcomes(curve, border)
    yield from switched(problem, border.good)
    yield from unswitched(problem, border.good)
    last = border.bad if border.bad is not None else border.good
    for part in TUNING.border_beside:
        for orbit in (border.good, last):
            values = orbit.starts[0, d:]
            guess = _own_path(problem, orbit, values + part * np.where(values == 0, curve.spans, np.abs(values)))
            if guess is not None:
                yield guess
    yield from left_out(problem, border)
    yield from without_events(problem, border.good)


def _ways(curve: Curve, border: Border, shot: Shot) -> np.ndarray:
    """Directions in which the smooth continuation goes on at a border, as `Problem.loosely_null`; none without it."""
    problem, orbit = curve.problem, border.good
    if not shot.regular:
        return np.zeros((0, problem.columns(orbit)))
    return problem.loosely_null(orbit, shot, curve.weights(orbit))


def _own_ahead(curve: Curve, border: Border, shot: Shot, ways: np.ndarray) -> Iterator[Orbit]:
    """What the system does some way beyond a border, where the smooth continuation is no motion of it.

    Nearer to the border the errors of the orbits may decide, as where a multiplier comes to 1 there. Of several ways,
    in the weights, that is taken along which least changes beside the parameter.
    """
    problem, orbit = curve.problem, border.good
    direction = ways[:, -1] @ ways
    length = float(np.linalg.norm(direction))
    if length <= TUNING.loose:
        return
    direction = direction / length / curve.weights(orbit)
    for step in (TUNING.ahead, -TUNING.ahead):
        moved = problem.moved(orbit, shot, step * direction)
        seen = problem.shoot(moved)
        if seen.outcome == 0 and not admissible(moved, seen):
            guess = _own_path(problem, moved, moved.starts[0, problem.states :])
            if guess is not None and sorted(guess.segments.tolist()) != sorted(orbit.segments.tolist()):
                yield guess


def _other_outcomes(curve: Curve, border: Border) -> Iterator[Orbit]:
    """The orbits a little beyond a border at which an event takes another transition, from mode to mode as before.

    The equations there are those of the other outcome, which Newton's method may not reach from the orbits before: it
    would be thrown back and forth between the two sides.
    """
    problem, orbit = curve.problem, border.good
    transitions = problem.plain.transitions
    events = kernels_of(problem.system).layout.events
    if all(len(e.outcomes) == 1 for m in set(orbit.segments[:, at.SEGMENT_MODE].tolist()) for e in events[m]):
        return
    weights = curve.weights(orbit)
    shot = problem.shoot(orbit, False)
    if not shot.regular:
        return
    direction = problem.direction(orbit, shot, weights)
    for length in TUNING.border_beside[1:]:
        moved = problem.moved(orbit, shot, length * direction)
        came = problem.shoot(moved, False).came
        changed = np.flatnonzero((came != orbit.segments[:, at.SEGMENT_OUTCOME]) & (came >= 0))
        same = all(
            transitions[came[i]].target == transitions[orbit.segments[i, at.SEGMENT_OUTCOME]].target for i in changed
        )
        if len(changed) and same:
            segments = orbit.segments.copy()
            segments[changed, at.SEGMENT_OUTCOME] = came[changed]
            yield replace(moved, segments=segments)


def _all_changed(problem: Problem, border: Border) -> Iterator[Orbit]:
    """The path without the events that have no speed and with one wherever a guard is touched, if they are several.

    As many branches meet there as there are ways to choose among these events, two of a symmetric orbit and its
    partners. Each is continued by its opposite, so that a walk takes the same ways whichever of them it comes.
    """
    orbit, names = border.good, problem.plain.mode_names
    slow = slowness(problem, orbit, border.shot) <= TUNING.touching
    touched = [(touch, when) for value, touch, when in touches(problem, orbit) if value <= TUNING.touching]
    modes = orbit.segments[:, at.SEGMENT_MODE]
    if slow.sum() + len(touched) < 2 or (modes != np.roll(modes, -1))[slow].any():
        return
    ends, values = orbit.durations.cumsum(), orbit.starts[0, problem.states :]
    following = np.vstack([orbit.starts[1:], orbit.starts[:1] + orbit.moved_on()])
    kept = np.flatnonzero((orbit.segments[:, at.SEGMENT_END] >= 0) & ~slow)
    events = [(float(ends[i]), orbit.segments[i], following[i]) for i in kept]
    for touch, when in touched:
        i, mode = touch.segment, int(modes[touch.segment])
        came, after = taken(problem, orbit, i, touch.guard, when - float(ends[i] - orbit.durations[i]))
        if came < 0 or problem.plain.transitions[came].target != names[mode]:
            return
        events.append((when, np.array([mode, touch.guard, came]), np.concatenate([after, values])))
    if events:
        events.sort(key=lambda one: one[0])
        times = np.array([when for when, _, _ in events])
        yield replace(
            orbit,
            segments=np.roll(np.array([segment for _, segment, _ in events]), -1, axis=0),
            starts=np.array([after for _, _, after in events]),
            phase=orbit.phase + times[0],
            durations=np.diff(times, append=times[0] + float(ends[-1])),
        )


def without_events(problem: Problem, orbit: Orbit) -> Iterator[Orbit]:
    """The path without its events, if it stays in one mode but for moments."""
    lasting = orbit.durations > TUNING.tangential * orbit.durations.sum()
    if orbit.eventless or len(set(orbit.segments[lasting, at.SEGMENT_MODE].tolist())) > 1:
        return
    values, longest = orbit.starts[0, problem.states :], int(orbit.durations.argmax())
    mode = problem.plain.mode_names[orbit.segments[longest, at.SEGMENT_MODE]]
    if problem.forced:
        period = problem.period_at(orbit)
        assert period is not None
        yield eventless(problem, problem.strobes([orbit])[0][0, 0], mode, orbit.periods, values, period)
    else:
        total = float(orbit.durations.sum())
        middle = float(orbit.durations[:longest].sum() + 0.5 * orbit.durations[longest])
        state = problem.at([orbit], np.array([[middle]]))[0][0, 0]
        segments = np.array([[orbit.segments[longest, at.SEGMENT_MODE], at.PLANE, -1]], dtype=np.int64)
        starts = np.concatenate([state, values])[np.newaxis]
        yield Orbit(segments, orbit.periods, starts, 0.0, np.array([total]), orbit.drift)


def _own_path(problem: Problem, orbit: Orbit, values: np.ndarray) -> Orbit | None:
    """What the system does from the middle of the longest segment on, in the time that the orbit takes."""
    outcome, guess = own_path(problem, orbit, values, float(orbit.durations.sum()))
    if outcome != Outcome.OK or guess is None:
        return None
    return based(problem, replace(guess, periods=orbit.periods))


def left_out(problem: Problem, border: Border) -> Iterator[Orbit]:
    """The orbit without one event that leads back into its mode, or without two or three that do so together."""
    orbit = border.good
    count = len(orbit)
    if orbit.eventless:
        return
    merit = np.minimum(border.shot.speeds / problem.paces(orbit), orbit.durations / orbit.durations.sum())
    for first in np.argsort(merit).tolist():
        for dropped in (1, 2, 3):
            if dropped >= count:
                break
            for shift in range(dropped):
                begin = (first - shift) % count
                turned = orbit.rotated(begin, None)
                if turned.segments[0, at.SEGMENT_MODE] == turned.segments[dropped % count, at.SEGMENT_MODE]:
                    durations = np.concatenate(
                        [[turned.durations[: dropped + 1].sum()], turned.durations[dropped + 1 :]]
                    )
                    starts = np.vstack([turned.starts[0], turned.starts[dropped + 1 :]])
                    yield replace(turned, segments=turned.segments[dropped:], durations=durations, starts=starts)


def _same_cycle(one: Orbit, other: Orbit) -> bool:
    """Whether two orbits have the same events after about the same parts of the whole.

    Two that trade places leave a cycle of two, with other parts.
    """
    here, there = (orbit.durations / orbit.durations.sum() for orbit in (one, other))
    return len(one) == len(other) and any(
        np.array_equal(np.roll(one.segments, k, axis=0), other.segments)
        and np.abs(np.roll(here, k) - there).max() < TUNING.same_cycle
        for k in range(len(one))
    )


def _branch_from(curve: Curve, guess: Orbit, border: Border, further: list[Orbit]) -> Continuation | None:
    """The branch of orbits with the events of a guess that begins at a border, some way along it.

    Where its orbits cross yet another guard, as two do at once on a symmetric orbit, the system's own path from there
    is added to ``further`` guesses.
    """
    problem = curve.problem
    guess = based(problem, guess)
    shot = problem.shoot(guess)
    if not shot.regular:
        return None
    weights = curve.weights(guess)
    direction, lengths = _into(problem, guess, shot, weights)
    if reflected(problem, border.good, guess):
        # it is the same smooth branch, of which all is seen
        lengths = [*TUNING.reflected_steps, *lengths]
    for length in lengths:
        code, orbit, seen, _ = problem.beside(guess, shot, direction, length, weights)
        if code != CONVERGED or distance(problem, orbit, border.good, weights) > TUNING.border_near:
            continue
        if _repeats(problem, orbit) or at_rest(problem, orbit):
            continue
        if not admissible(orbit, seen):
            if length and admissible(orbit, replace(seen, crossed=np.full(len(orbit), -1))):
                fuller = _own_path(problem, orbit, orbit.starts[0, problem.states :])
                further += [] if fuller is None else [fuller]
            continue
        ahead = _away(problem, orbit, seen, border, weights)
        if ahead is not None and _leads_back(problem, orbit, seen, border, weights):
            return Continuation(orbit, seen, ahead)
    return None


def _repeats(problem: Problem, orbit: Orbit) -> bool:
    """Whether an orbit goes through the same path several times."""
    whole = gcd(len(orbit), orbit.periods) if problem.forced else len(orbit)
    parts = [times for times in range(2, whole + 1) if whole % times == 0]
    return any(problem.comes_again(orbit, len(orbit) // times, TUNING.repeated) for times in parts)


def _into(problem: Problem, guess: Orbit, shot: Shot, weights: np.ndarray) -> tuple[np.ndarray, Sequence[float]]:
    """The direction of the branch of orbits with the events of a guess, and lengths at which its first is tried.

    A path that leaves a guard and meets it again may stay no time in between: this holds on a whole branch of its own,
    none of whose paths the system follows. At a border where such a stay begins this branch crosses the one that is
    looked for, and which of the two the equations there lead along is a matter of round-off. The stay is what grows.
    """
    short = np.flatnonzero(guess.durations <= TUNING.touching * guess.durations.sum())
    if len(short):
        plane = problem.loosely_null(guess, shot, weights)
        growth = plane[:, problem.states + 1 + short].sum(axis=1)
        if len(plane) > 1 and growth.any():
            return growth @ plane / np.linalg.norm(growth) / weights, [s for s in TUNING.border_steps if s > 0]
    return problem.direction(guess, shot, weights), TUNING.border_steps


def distance(problem: Problem, orbit: Orbit, other: Orbit, weights: np.ndarray) -> float:
    """Distance between two orbits at their strobes and in the parameter, in the weighted norm.

    Without strobes: the largest distance at which one passes a place of the other, and how much longer one takes.
    """
    d = problem.states
    apart = float(abs(orbit.starts[0, -1] - other.starts[0, -1])) * weights[-1]
    if not problem.forced:
        longer = float(orbit.durations.sum() / other.durations.sum())
        apart += abs(float(np.log(longer))) if longer > 0 else np.inf
        if apart > TUNING.border_near:
            return apart
        return apart + max(passing(problem, *pair, weights[:d]) for pair in ((orbit, other), (other, orbit)))
    here, there = (problem.strobes([o])[0][0] for o in (orbit, other))
    if len(here) != len(there):
        return np.inf
    return apart + min(
        float((np.abs(problem.shifts.across(np.roll(here, k, axis=0) - there)) * weights[:d]).max())
        for k in range(len(here))
    )


def passing(problem: Problem, orbit: Orbit, other: Orbit, weights: np.ndarray) -> float:
    """Distance at which an orbit passes the middle of the longest segment of another one."""
    state, total = standpoint(problem, other)[2], float(orbit.durations.sum())
    parts, rounds, most = TUNING.passing_samples
    step = total / (parts * len(orbit))
    instants = step * np.arange(parts * len(orbit))
    offsets = np.linspace(-1, 1, parts + 1)
    for _ in range(rounds):
        away = problem.shifts.across(problem.at([orbit], instants[np.newaxis])[0][0] - state)
        away = (np.abs(away) * weights).max(axis=1)
        # where it turns several times it comes near as often
        nearest = np.flatnonzero((away <= np.roll(away, 1)) & (away <= np.roll(away, -1)))
        nearest = nearest[away[nearest].argsort(kind="stable")[:most]]
        instants = np.unique((instants[nearest, np.newaxis] + step * offsets) % total)
        step *= 2 / parts
    return float(away.min())


def _leads_back(problem: Problem, orbit: Orbit, shot: Shot, border: Border, weights: np.ndarray) -> bool:
    """Whether the orbits beside one come ever nearer to the border, as on a branch that begins there.

    A branch that only passes by may be as near as the first orbits of one behind a touch, which change with the root of
    the distance from it.
    """
    near = max(TUNING.begins, TUNING.root_near * float(np.sqrt(border.error * weights[-1])))
    away = distance(problem, orbit, border.good, weights)
    if away <= TUNING.same_path:
        return True
    for _ in range(TUNING.bisections):
        if away <= near:
            return True
        direction = problem.direction(orbit, shot, weights)
        nearest = None
        # a step counts all points of the orbit, and what it changes at one of them may be many times as much
        for part in TUNING.way_back:
            for sign in (1.0, -1.0):
                code, there, seen, _ = problem.beside(orbit, shot, direction, sign * part * away, weights)
                if code == CONVERGED and seen.regular:
                    left = distance(problem, there, border.good, weights)
                    if left < TUNING.nearer * away and (nearest is None or left < nearest[0]):
                        nearest = left, there, seen
            if nearest is not None:
                break
        if nearest is None:
            return False
        away, orbit, shot = nearest
    return False


def _away(problem: Problem, orbit: Orbit, shot: Shot, border: Border, weights: np.ndarray) -> np.ndarray | None:
    """The direction that leads away from a border, along orbits that the system follows."""
    direction = problem.direction(orbit, shot, weights)
    farthest, away = 0.0, None
    least = 2 * distance(problem, orbit, border.good, weights)
    # the next change of events may be near
    for step in sorted({max(TUNING.border_probe * part, least) for part in (1.0, 0.1, 0.01)}, reverse=True):
        for sign in (1.0, -1.0):
            code, there, seen, _ = problem.beside(orbit, shot, direction, sign * step, weights)
            if code == CONVERGED and admissible(there, seen):
                far = distance(problem, there, border.good, weights)
                if far > farthest:
                    farthest, away = far, sign * direction
        if away is not None:
            break
    return away
