"""One orbit, from a guess to a verified result or the reason why none was found."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from itertools import product

import numpy as np

from chaosdrill.codegen import kernels_of
from chaosdrill.dataset import Outcome
from chaosdrill.engine import shooting as at
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run
from chaosdrill.model import HybridSystem
from chaosdrill.orbits.conserved import conserved_at, family_words, likely_at, on_level
from chaosdrill.orbits.guess import (
    InitialGuess,
    guess_of_autonomous,
    initial_guess,
    own_path,
    returns,
    settled,
    unit_of,
)
from chaosdrill.orbits.marks import Marks
from chaosdrill.orbits.multipliers import based, free_multipliers, largest_growth
from chaosdrill.orbits.orbit import Orbit
from chaosdrill.orbits.place import Place, drifts_until_guard, reached
from chaosdrill.orbits.problem import CONVERGED, SINGULAR, SLOW, Problem, Shot, admissible, lasting
from chaosdrill.orbits.results import FoundOrbit
from chaosdrill.orbits.tuning import TUNING
from chaosdrill.orbits.verification import describe, no_orbit


class NoOrbitError(Exception):
    """Raised if no orbit was found, with the reason.

    ``residuals``: residuals of Newton's method up to its end. ``lost``: what its last step led to, if that could not be
    followed.
    """

    returned: float = 0.0
    """Time in which the motion returned that was the guess, if one did."""

    def __init__(
        self, outcome: Outcome, message: str, residuals: np.ndarray | None = None, lost: Orbit | None = None
    ) -> None:
        super().__init__(message)
        self.outcome, self.message = outcome, message
        self.residuals = np.zeros(0) if residuals is None else residuals
        self.lost = lost


def tie_words(problem: Problem, orbit: Orbit) -> str:
    """Which events of an orbit happen in one instant, in words; empty if none do."""
    outcomes, between = orbit.segments[:, at.SEGMENT_OUTCOME], np.flatnonzero(orbit.tied)
    pairs = [[problem.plain.transitions[outcomes[k]].name for k in (i - 1, i)] for i in between.tolist()]
    told = ", ".join(f"{one!r} and {other!r}" for one, other in pairs)
    return f"{told} happen in one instant; multipliers are those of this order, event_orders has all" if told else ""


def inadmissible_words(problem: Problem, orbit: Orbit, shot: Shot) -> str:
    """Why the system does not follow an orbit whose equations hold: the first reason."""
    system, lasts = problem.plain, lasting(orbit)
    for i, (mode, end, outcome) in enumerate(orbit.segments.tolist()):
        name = system.mode_names[mode]
        if shot.crossed[i] >= 0:
            found = kernels_of(problem.system).layout.events[mode][shot.crossed[i]].outcomes[0]
            return f"in mode {name!r} the guard of {system.transitions[found].name!r} is crossed on the way"
        if not lasts[i] > 0:
            return f"the stay in mode {name!r} would last {orbit.durations[i]:.3g}"
        if end >= 0 and shot.came[i] != outcome:
            return f"the event {system.transitions[outcome].name!r} has another outcome"
        if end >= 0 and not shot.speeds[i] > 0:
            return f"the guard of {system.transitions[outcome].name!r} would be crossed from the other side"
    return ""


def open_words(problem: Problem, orbit: Orbit, shot: Shot) -> str:
    """Which stay may as well last no time, as far as the equations tell, in words; empty for none.

    A motion that stops for less from period to period nears the edge of orbits without a stop; there Newton's method
    ends.
    """
    if orbit.eventless or len(problem.conserved):
        return ""
    weights, first = problem.weights(orbit), problem.states + 1
    off = np.abs(problem.off(orbit, shot, weights))[first : first + len(orbit)]
    parts = weights[first] * orbit.durations
    i = int((off - np.where(orbit.tied, np.inf, parts)).argmax())
    free = free_multipliers(np.linalg.eigvals(shot.monodromy), problem.neutral.count)
    if orbit.tied[i] or off[i] < parts[i] or np.abs(free - 1).min(initial=np.inf) > parts[i]:
        return ""
    name = problem.plain.mode_names[orbit.segments[i, at.SEGMENT_MODE]]
    return (
        f"a multiplier is 1, and the equations leave open whether the stay in mode {name!r} lasts "
        f"{orbit.durations[i]:.1g} or no time: motions may near an orbit without it ever more slowly"
    )


def at_rest(problem: Problem, orbit: Orbit) -> bool:
    """Whether the orbit is at rest: no event occurs, except for slips of zero length.

    What parametric forcing leaves where it is, is an orbit: nearby motions feel it.
    """
    if problem.is_modulated(orbit):
        return False
    if not orbit.eventless and orbit.durations.min() > TUNING.slip_at_rest * orbit.durations.sum():
        return False
    total = float(orbit.durations.sum())
    path = problem.shifts.still(problem.at([orbit], np.linspace(0, total, 33)[np.newaxis, :-1])[0][0])
    return bool((np.ptp(path, axis=0) <= TUNING.at_rest * np.maximum(problem.sizes, np.abs(path).max(axis=0))).all())


def understood(problem: Problem, place: Place, period: int, failure: NoOrbitError) -> NoOrbitError:
    """Why there is no orbit: the motion ends, comes to rest, repeats after other periods, or a state only grows."""
    system = place.system
    unit = unit_of(problem, place)
    count, parts = TUNING.watched_units, 1 if system.discrete else TUNING.watched_samples
    if not problem.forced:
        # an even number
        count = max(count, 2 * int(np.ceil(min(failure.returned / unit, TUNING.return_units[-1]))))
    run = place.run(unit, problem.numerics, samples=parts)
    begun, d = run.x.copy(), len(system.state_names)
    rows = np.zeros(((count + 1) * parts + 1, d + len(system.quadratures) + 1))
    outcome = run.advance(count, rows)[0]
    if outcome == failure.outcome:
        return failure
    if outcome != Outcome.OK:
        words = f"{failure.message}; and the motion from the start ends: {outcome.advice}"
        return NoOrbitError(outcome, words, failure.residuals)
    paths = rows[: count * parts, :d].reshape(count, parts, d)
    points = np.vstack([begun, paths[:, -1]])
    if not problem.forced and _rests(problem, run):
        return NoOrbitError(Outcome.EQUILIBRIUM, "the motion from the start comes to rest", failure.residuals)
    # one that returns is never farther from its start than it goes within a turn, however it is sampled
    growing = _growing(points, problem.sizes) & (np.abs(points[-1] - begun) > np.ptp(paths, axis=1).max(axis=0))
    growing &= ~problem.shifts.moves
    if not growing.any():
        after = _repeats(points, problem)
        if not problem.forced or after in (0, period):
            return failure
        words = f"{failure.message}; the motion from the start repeats after {after} period{'s' * (after > 1)}"
        return NoOrbitError(failure.outcome, f"{words}: give period={after}", failure.residuals)
    ways = drifts_until_guard(run, np.where(growing, points[-1] - begun, 0.0))
    if np.isfinite(ways):
        length = f"{(1 + ways) * count:.2g} periods" if problem.forced else f"a time of {(1 + ways) * count * unit:.2g}"
        return NoOrbitError(
            Outcome.NO_ORBIT,
            f"the motion from the start drifts, and meets a guard only after about {length}: begin there, by "
            "start='attractor' and a transient of that length",
            failure.residuals,
        )
    each = "a period" if problem.forced else "a unit of time"
    net = (points[-1] - begun) / (count if problem.forced else count * unit)
    told = ", ".join(f"{system.state_names[i]} changes by {net[i]:.3g}" for i in np.flatnonzero(growing))
    return NoOrbitError(
        Outcome.OPEN,
        f"the motion cannot close: {told} {each} on average and never returns; begin nearer to the orbit if it falls "
        "or runs away, carry a state that only grows as a quadrature, or write a phase as a function of time",
        failure.residuals,
    )


def _rests(problem: Problem, run: Run) -> bool:
    """Whether the run has come to rest."""
    system = run.system
    rates = np.zeros(len(run.x) + len(system.quadratures))
    mode = system.mode_names.index(run.mode)
    kernels_of(system).functions.field(mode, run.elapsed, run.c, run.x, rates)
    moved = np.abs(problem.shifts.beside(rates[: len(run.x)])) * run.period
    return bool((moved <= TUNING.at_rest * np.maximum(problem.sizes, np.abs(run.x))).all())


def _repeats(points: np.ndarray, problem: Problem) -> int:
    """The number of periods after which points, shape (points, n), repeat at their end, and repeated before; or 0."""
    last = problem.shifts.still(points)
    near = TUNING.repeats * np.maximum(problem.sizes, np.abs(last).max(axis=0))
    for after in range(1, len(last) // 4):
        if (np.abs(last[-2 * after :] - last[-3 * after : -after]) <= near).all():
            return after
    return 0


def _growing(points: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """Which states grow or fall monotonically and evenly, shape (n,), by more than a part of their sizes."""
    steps = np.diff(points, axis=0)
    way = np.abs(steps).sum(axis=0)
    halves = np.abs(steps.reshape(2, -1, points.shape[1]).sum(axis=1))
    size = np.maximum(np.abs(points).max(axis=0), sizes)
    return (halves.min(axis=0) > TUNING.evenly * way) & (way > 1e-3 * size)


def why_not(code: int, residuals: np.ndarray) -> str:
    """The reason why Newton's method failed."""
    known = residuals[np.isfinite(residuals)]
    went = f"; its residuals went from {known[0]:.1e} to {known.min():.1e}" if len(known) else ""
    if code == SINGULAR:
        return f"Newton's method found the equations singular{went}"
    if code == SLOW:
        return f"Newton's method did not converge{went}"
    if not len(known):
        return f"the path from the start cannot be followed with its derivatives: {Outcome(code).advice}"
    return f"Newton's method ran off{went}; there the system cannot be followed: {Outcome(code).advice}"


def find_orbit(
    system: HybridSystem,
    period: int,
    start: str | float,
    transient: float,
    numerics: Numerics,
    marks: Marks | None = None,
    derive: Sequence[str] = (),
) -> FoundOrbit:
    """Find and verify one orbit, or say why none was found.

    ``period``: in forcing periods; 1 for systems without a period. ``start``: where Newton's method starts: at the
    system's initial state, or where a run has come to from there. A number is the time after which the motion from the
    initial state is taken to be back, in a system without a period. ``transient``: forcing periods of that run, or its
    time. ``marks``: the section on which its points are given; default: the strobe, or where the orbit starts.
    ``derive``: parameters by which the results are differentiated.
    """
    try:
        problem, orbit, shot, residuals, message = starting_orbit(system, (), period, start, transient, numerics)
    except NoOrbitError as failure:
        return no_orbit(system, failure.outcome, failure.message, period, failure.residuals)
    return describe(problem, orbit, shot, residuals, message, marks, derive)


def starting_orbit(
    system: HybridSystem, free: tuple[str, ...], period: int, start: str | float, transient: float, numerics: Numerics
) -> tuple[Problem, Orbit, Shot, np.ndarray, str]:
    """The orbit near the initial state, or near the attractor that it is drawn to.

    On an attractor Newton's method starts where the motion comes back most nearly after the period, and there from
    several such places. An orbit of a shorter period is given only if none of the period asked for was found.

    Returns: ``problem``, ``orbit``, ``shot``, ``residuals``: the orbit with what shooting and Newton's method showed.
    ``message``: remarks on the orbit.

    Raises `NoOrbitError`.
    """
    problem = Problem(system, free, numerics)
    outcome, run = settled(problem, transient if start == "attractor" else 0)
    if outcome != Outcome.OK:
        raise NoOrbitError(outcome, f"the run that leads to the orbit ended: {outcome.advice}")
    place = reached(run, problem.numerics) if start == "attractor" else Place(problem.plain)
    if start == "attractor":
        guesses = returns(problem, run, period)
    elif start == "guess":
        guesses = [initial_guess(problem, place, period)]
    else:
        values = np.array([system.parameters[name] for name in free])
        guesses = [partial(guess_of_autonomous, problem, place, 2 * float(start), values, float(start))]
    failure, shorter = None, None
    for initial, reach in product(guesses, TUNING.reaches):
        try:
            orbit, shot, residuals = orbit_read(problem, initial, period, reach, level=True)
        except NoOrbitError as error:
            failure = failure or error
            continue
        least, message = least_period(problem, orbit)
        if least is not orbit:
            _, least, shot, residuals = problem.newton(least)
        if least.periods == period:
            problem.conserved = conserved_at(problem, least, shot)
            remarks = [
                message,
                family_words(problem.conserved, system.state_names),
                tie_words(problem, least),
                open_words(problem, least, shot),
            ]
            return problem, least, shot, residuals, "; ".join(filter(None, remarks))
        shorter = shorter or (problem, least, shot, residuals, message)
    if shorter is not None:
        return shorter
    assert failure is not None
    raise understood(problem, place, period, failure)


def orbit_read(
    problem: Problem,
    initial: InitialGuess,
    period: int,
    reach: float = TUNING.reaches[0],
    *,
    level: bool = False,
) -> tuple[Orbit, Shot, np.ndarray]:
    """The orbit near a simulated path, written from the segment with the fewest degrees of freedom.

    Where the system does not follow what Newton's method makes of it, its own path from there is read. ``level`` is as
    for `solved`.

    Raises `NoOrbitError`.
    """
    failure = NoOrbitError(Outcome.NO_ORBIT, "")
    seen: list[Orbit] = []
    for _ in range(TUNING.guesses):
        outcome, guess = initial()
        if failure.message and guess is None:
            raise failure
        if outcome != Outcome.OK:
            raise NoOrbitError(outcome, f"the run from the start ended: {outcome.advice}")
        if guess is None:
            words = "does not return soon"
            if problem.forced:
                words = f"after {period} period{'s' * (period > 1)} is in another mode than at its beginning"
            raise NoOrbitError(Outcome.NO_ORBIT, f"the motion from the start {words}")
        if any(guess.periods == one.periods and np.array_equal(guess.segments, one.segments) for one in seen):
            raise failure
        try:
            orbit, shot, residuals = solved(problem, guess, reach, level=level)
        except NoOrbitError as error:
            error.returned = float(guess.durations.sum())
            if error.lost is None:
                raise
            # a spike is run over by less than a step changes its time, which the motion itself knows
            failure, initial = error, partial(own_path, problem, error.lost)
            continue
        seen.append(guess)
        if admissible(orbit, shot):
            return orbit, shot, residuals
        failure = NoOrbitError(
            Outcome.INADMISSIBLE, f"the equations close, but {inadmissible_words(problem, orbit, shot)}", residuals
        )
        initial = partial(own_path, problem, orbit)
    raise failure


def solved(
    problem: Problem, guess: Orbit, reach: float = TUNING.reaches[0], *, level: bool = False
) -> tuple[Orbit, Shot, np.ndarray]:
    """The orbit to which Newton's method takes a guess; it need not be admissible.

    Where it finds none and ``level`` says so, it is tried on a level of what may be conserved.

    Raises `NoOrbitError`.
    """
    if words := _comes_with_another(problem, guess):
        raise NoOrbitError(Outcome.NO_ORBIT, words)
    guess = based(problem, guess)
    if not level:
        return _solved(problem, guess, reach)
    closed, likely = likely_at(problem, guess)
    if len(closed) and (found := _solved_on_level(problem, guess, reach, closed)):
        return found
    found, failure = None, NoOrbitError(Outcome.NO_ORBIT, "")
    try:
        found = _solved(problem, guess, reach)
    except NoOrbitError as error:
        failure = error
    if found is None or len(conserved_at(problem, *found[:2])):
        # the last steps lead to any member of a family: it is the one that the others come near
        _, near, _, residuals = problem.newton(guess, reach=reach, enough=problem.nearly_closed)
        closed, _ = likely_at(problem, near)
        if len(closed) and (nearest := _solved_on_level(problem, near, reach, closed)):
            return *nearest[:2], np.concatenate([residuals, nearest[2][1:]])
    found = found or (_solved_on_level(problem, guess, reach, likely) if len(likely) else None)
    if found is None:
        raise failure
    return found


def _solved_on_level(
    problem: Problem, guess: Orbit, reach: float, rows: np.ndarray
) -> tuple[Orbit, Shot, np.ndarray] | None:
    """The orbit where what has these differentials stays as it is; None if it is not conserved."""
    try:
        with on_level(problem, rows):
            found = _solved(problem, guess, reach)
    except NoOrbitError:
        return None
    return found if len(conserved_at(problem, *found[:2])) else None


def _solved(problem: Problem, guess: Orbit, reach: float) -> tuple[Orbit, Shot, np.ndarray]:
    """The orbit to which Newton's method takes a guess."""
    code, orbit, shot, residuals = problem.newton(guess, reach=reach)
    if code == SLOW and residuals[-1] <= TUNING.converging:
        # what rounding grows to on a part of the orbit is left, as where a relaxation oscillation jumps
        grown = TUNING.step_error * largest_growth(problem, orbit)
        code, orbit, shot, more = problem.newton(orbit, reach=reach, enough=max(TUNING.residual, grown))
        residuals = np.concatenate([residuals, more[1:]])
    if code != CONVERGED:
        lost = orbit if code in (Outcome.NONFINITE, Outcome.ESCAPED) and len(residuals) > 1 else None
        raise NoOrbitError(Outcome.NO_ORBIT, why_not(code, residuals), residuals, lost)
    if at_rest(problem, orbit):
        raise NoOrbitError(Outcome.EQUILIBRIUM, "the result is a point at rest, not an orbit", residuals)
    return orbit, shot, residuals


def _comes_with_another(problem: Problem, guess: Orbit) -> str:
    """Which event of a path a reset causes by throwing the state across its guard, in words; empty for none."""
    for i in np.flatnonzero((guess.durations == 0) & (guess.segments[:, at.SEGMENT_END] >= 0)).tolist():
        one = guess.rotated(i, problem.period_at(guess))
        shot = problem.shoot(
            replace(one, segments=one.segments[:1], starts=one.starts[:1], durations=one.durations[:1]), watched=False
        )
        if abs(shot.equations[0, -1]) > TUNING.off_guard * abs(shot.speeds[0]) * guess.durations.sum():
            cause, event = (problem.plain.transitions[guess.segments[k, at.SEGMENT_OUTCOME]].name for k in (i - 1, i))
            return (
                f"the reset of {cause!r} throws the state across the guard of {event!r}, and an orbit is not followed "
                "where two events are at one instant: write them as one transition"
            )
    return ""


def least_period(problem: Problem, orbit: Orbit) -> tuple[Orbit, str]:
    """The orbit traversed once, and a remark if a multiple of its period was asked for."""
    count, periods = len(orbit), orbit.periods
    if not problem.forced and orbit.eventless:
        return _one_turn(problem, orbit), ""
    parts = periods if problem.forced else count
    for times in range(parts, 1, -1):
        if count % times or (problem.forced and periods % times):
            continue
        step = count // times
        if problem.comes_again(orbit, step, TUNING.same_point):
            least = replace(
                orbit,
                segments=orbit.segments[:step],
                periods=periods // times if problem.forced else periods,
                starts=orbit.starts[:step],
                durations=orbit.durations[:step],
                drift=_drift_within(problem, orbit, orbit.starts[step, : problem.states]),
            )
            return least, f"its period is {least.periods}, not {periods}" if problem.forced else ""
    return orbit, ""


def _one_turn(problem: Problem, orbit: Orbit) -> Orbit:
    """An orbit of a smooth flow, a single segment, traversed once."""
    d = problem.states
    turns = np.arange(TUNING.most_turns, 1, -1)
    ends = float(orbit.durations[0]) / turns
    states = problem.at([orbit], ends[np.newaxis])[0][0]
    size = np.maximum(np.abs(orbit.starts[0, :d]), 1e-6 * problem.sizes)
    allowed = TUNING.same_point * size + 4 * problem.solved_to(orbit.starts[:, :d])
    back = np.flatnonzero((np.abs(problem.shifts.across(states - orbit.starts[0, :d])) < allowed).all(axis=1))
    if not len(back):
        return orbit
    return replace(orbit, durations=ends[back[:1]], drift=_drift_within(problem, orbit, states[back[0]]))


def _drift_within(problem: Problem, orbit: Orbit, state: np.ndarray) -> np.ndarray | None:
    """The drift of an orbit that is back in a state before the whole of it was gone through."""
    return None if orbit.drift is None else problem.shifts.part(state - orbit.starts[0, : problem.states])
